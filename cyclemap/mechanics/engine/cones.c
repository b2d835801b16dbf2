/* Friction over the contact of a foundation that is pressed (foundation.c).

   The contact's image in the velocity plane is cut into cones from w = 0, the centre of rotation
   (equations.py, _pressed_side): sides are summed in closed form, arcs by Gauss's rule on panels
   that are short beside their distance from where |w| is singular. From afar cones are taken from
   the centroid and summed place by place. */

/* Panels of arcs that are shorter than this, in 2 s - 1, are summed by the least rule. */
static const double SHORTEST_PANEL = 1e-12;
/* By digits: centres of rotation farther than this (extents, velocity plane) are summed place by
   place, by these rules along a cone and along a side; from near, sums cancel as the third
   power of the distance. */
static const double FOUNDATION_FAR[] = {30.0, 20.0, 10.0, 3.0};
static const int ALONG_CONE[] = {0, 1, 1, 2}, ALONG_SIDE[] = {1, 2, 2, 4};
/* Sums of pieces: D, the force, and the Hessian by the velocity. */
enum { SUM_SPEED, SUM_X, SUM_Y, SUM_XX, SUM_XY, SUM_YY, SUM_SIZE };

/* What is summed at a twist about the centroid, under a quadratic; frame: w of places, image: the
   quadratic of w. */
typedef struct {
    Friction *f;
    const double *quadratic;
    int is_far, digits;
    double image[QUADRATIC_SIZE], moved[WRENCH];
    Frame frame;
    Lanes sums[SUM_SIZE];
    Sums places;
} Cones;

static void begin_cones(Cones *c, Friction *f, const double *quadratic, int is_far, int digits) {
    c->f = f;
    c->quadratic = quadratic;
    c->is_far = is_far;
    c->digits = digits;
    c->frame = frame_of(f, 0.0, 0.0, 1.0, 1.0);
    memset(c->moved, 0, sizeof c->moved);
    if (is_far) {
        memset(&c->places, 0, sizeof c->places);
        return;
    }
    memset(c->sums, 0, sizeof c->sums);
    const double *given[] = {f->twist, f->matrix, quadratic};
    double *results[] = {c->image};
    pressed_image(given, results, 0, 0, 0);
}

/* From afar: places along the cone from the centroid to a place on the boundary. */
static inline void add_far_cone(Cones *c, double end_x, double end_y, double cross) {
    int rule = ALONG_CONE[c->digits];
    for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; j += LANES) {
        Lanes x, y, share;
        for (int k = 0; k < LANES; ++k) {
            double s = 0.5 * (1.0 + BOUNDARY_NODES[j + k]);
            x[k] = s * end_x;
            y[k] = s * end_y;
            share[k] = s * cross * BOUNDARY_WEIGHTS[j + k] * pressure_at(c->quadratic, x[k], y[k]);
        }
        if (!c->f->toward) add_places(&c->frame, &x, &y, &share, &c->places);
        for (int k = 0; k < LANES && c->f->toward; ++k) {
            double found[WRENCH], *results[] = {found};
            const double place[] = {x[k], y[k]};
            const double *given[] = {c->f->twist, c->f->matrix, place, c->f->toward};
            point_toward(given, results, 0, 0, 0);
            add(c->moved, found, share[k], WRENCH);
        }
    }
}

/* Thin cones from the centre of rotation, w = 0, to places w on the boundary. */
static ALWAYS_INLINE void add_cones(const Lanes *image, const Boundary *at, Lanes *sums) {
    Lanes x = at->x, y = at->y, xx = x * x, yy = y * y;
    Lanes level = at->cross * image[Q_LEVEL];
    Lanes first = at->cross * (image[Q_SLOPE_X] * x + image[Q_SLOPE_Y] * y);
    Lanes second = at->cross * (image[Q_XX] * xx + image[Q_XY] * (x * y) + image[Q_YY] * yy);
    Lanes slowness = 1.0 / rooted(xx + yy + 1e-300), ux = x * slowness, uy = y * slowness;
    Lanes power = level * (1.0 / 3.0) + first * (1.0 / 4.0) + second * (1.0 / 5.0);
    Lanes force = level * (1.0 / 2.0) + first * (1.0 / 3.0) + second * (1.0 / 4.0);
    Lanes bent = slowness * (level + first * (1.0 / 2.0) + second * (1.0 / 3.0));
    Lanes bent_x = bent * ux, bent_y = bent * uy;
    sums[SUM_SPEED] += power * (x * ux + y * uy);
    sums[SUM_X] += force * ux;
    sums[SUM_Y] += force * uy;
    sums[SUM_XX] += bent_y * uy;
    sums[SUM_XY] -= bent_x * uy;
    sums[SUM_YY] += bent_x * ux;
}

/* How D and force of a thin cone move. */
static void move_cone(Cones *c, double x, double y, double cross) {
    double found[WRENCH], *results[] = {found};
    const double cone[] = {x, y, cross};
    const double *given[] = {c->f->twist, c->f->matrix, cone, c->quadratic, c->f->toward};
    pressed_cone_toward(given, results, 0, 0, 0);
    add(c->moved, found, 1.0, WRENCH);
}

static inline void velocity_at(const Frame *e, const double *place, double *w) {
    const double *t = e->spin;
    w[X] = e->middle[X] + e->omega * (t[M_XX] * place[X] + t[M_XY] * place[Y]);
    w[Y] = e->middle[Y] + e->omega * (t[M_YX] * place[X] + t[M_YY] * place[Y]);
}

/* Without C's care for what is not finite. */
static ALWAYS_INLINE double complex product(double complex a, double complex b) {
    double real = creal(a) * creal(b) - cimag(a) * cimag(b);
    return real + I * (creal(a) * cimag(b) + cimag(a) * creal(b));
}

static ALWAYS_INLINE double complex root_of(double complex z) {
    double x = creal(z), y = cimag(z), larger = sqrt(0.5 * (size_of(x, y) + fabs(x)));
    double smaller = larger > 0.0 ? 0.5 * y / larger : 0.0;
    return x >= 0.0 ? larger + I * smaller : fabs(smaller) + I * copysign(larger, y);
}

/* Where |w| along an arc's image is singular, in x = 2 s - 1: the complex zeros of w, a quadratic.
   Returns how many of them may lie within `reach` of the middle; none where the quadratic's level
   outweighs its other terms that far. */
enum { ZEROS = 2 };
static ALWAYS_INLINE int zeros_of(double weight, const double *a, const double *c, const double *b,
                                  double reach, double complex *zeros) {
    double complex first = a[X] + I * a[Y], last = b[X] + I * b[Y];
    double complex both = first + last, twice = 2.0 * weight * c[X] + I * (2.0 * weight * c[Y]);
    /* square x^2 + 2 half x + level */
    double complex square = both - twice, half = last - first, level = both + twice;
    if (size(level) > reach * (2.0 * size(half) + reach * size(square))) return 0;
    double complex root = root_of(product(half, half) - product(square, level));
    int same = creal(half) * creal(root) + cimag(half) * cimag(root) >= 0.0;
    double complex down = same ? -half - root : root - half;
    zeros[0] = quotient(down, square);
    zeros[1] = quotient(level, down);
    return ZEROS;
}

/* The first of Gauss's rules that serves a panel of an arc, low to high in 2 s - 1, beside the
   zeros of w, from the one that its poles ask for. */
static int panel_rule(int rule, int zero_count, const double complex *zeros, double low,
                      double high, int digits) {
    double middle = 0.5 * (low + high), scale = 2.0 / (high - low);
    for (int k = 0; k < zero_count; ++k) {
        double x = (creal(zeros[k]) - middle) * scale, y = cimag(zeros[k]) * scale;
        double axis = 0.5 * (size_of(x - 1.0, y) + size_of(x + 1.0, y));
        while (rule < BOUNDARY_RULE_COUNT && axis < BOUNDARY_REACH[digits][rule]) ++rule;
    }
    return rule;
}

/* Cones to a panel of an arc's image. */
static void add_panel(Cones *c, const Sweep *sweep, const Panel *panel) {
    Lanes sums[SUM_SIZE], image[QUADRATIC_SIZE];
    for (int k = 0; k < QUADRATIC_SIZE; ++k) image[k] = all(c->image[k]);
    image[Q_XY] *= 2.0;
    memcpy(sums, c->sums, sizeof sums);
    for (int j = BOUNDARY_FIRST[panel->rule]; j < BOUNDARY_FIRST[panel->rule + 1]; j += LANES) {
        Boundary at;
        panel_at(sweep, panel, j, &at);
        add_cones(image, &at, sums);
    }
    memcpy(c->sums, sums, sizeof sums);
}

/* How what they add moves; the arc is seen from the centre of rotation. */
static void move_panel(Cones *c, const Sweep *sweep, const Panel *panel) {
    const double *v = c->f->twist, centre[] = {-v[VY] / v[OMEGA], v[VX] / v[OMEGA]};
    for (int j = BOUNDARY_FIRST[panel->rule]; j < BOUNDARY_FIRST[panel->rule + 1]; j += LANES) {
        Boundary at;
        panel_at(sweep, panel, j, &at);
        for (int k = 0; k < LANES; ++k)
            move_cone(c, at.x[k] + centre[X], at.y[k] + centre[Y], at.cross[k]);
    }
}

/* Panels are halved towards what is singular; the poles' half axis grows at least by its distance
   from 1. */
static void add_panels(Cones *c, const Sweep *sweep, double axis, int zero_count,
                       const double complex *zeros, double low, double high) {
    int rule = panel_rule(arc_rule(axis, c->digits), zero_count, zeros, low, high, c->digits);
    double middle = 0.5 * (low + high);
    if (rule == BOUNDARY_RULE_COUNT && high - low > SHORTEST_PANEL) {
        add_panels(c, sweep, 2.0 * axis - 1.0, zero_count, zeros, low, middle);
        add_panels(c, sweep, 2.0 * axis - 1.0, zero_count, zeros, middle, high);
        return;
    }
    Panel panel = {middle, 0.5 * (high - low), rule < BOUNDARY_RULE_COUNT ? rule : LEAST_RULE};
    if (c->f->toward)
        move_panel(c, sweep, &panel);
    else
        add_panel(c, sweep, &panel);
}

static void add_arc_of(Cones *c, const Arc *arc) {
    int rule = arc_rule(arc->axis, c->digits);
    if (!c->is_far) {
        const double *from[] = {arc->a, arc->c, arc->b}, *v = c->f->twist;
        double complex zeros[ZEROS];
        double at[3][2];
        for (int i = 0; i < 3; ++i) velocity_at(&c->frame, from[i], at[i]);
        int least = rule < BOUNDARY_RULE_COUNT ? rule : BOUNDARY_RULE_COUNT - 1;
        double reach = BOUNDARY_REACH[c->digits][least];
        int zero_count = zeros_of(arc->weight, at[0], at[1], at[2], reach, zeros);
        /* w is summed in its own plane; how it moves, off the centre of rotation */
        for (int i = 0; i < 3 && c->f->toward; ++i) {
            at[i][X] = from[i][X] + v[VY] / v[OMEGA];
            at[i][Y] = from[i][Y] - v[VX] / v[OMEGA];
        }
        Sweep sweep = sweep_of(arc->weight, at[0], at[1], at[2]);
        add_panels(c, &sweep, arc->axis, zero_count, zeros, -1.0, 1.0);
        return;
    }
    if (rule < ALONG_SIDE[c->digits]) rule = ALONG_SIDE[c->digits];
    Sweep sweep = sweep_of(arc->weight, arc->a, arc->c, arc->b);
    Panel whole = {0.0, 1.0, rule};
    for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; j += LANES) {
        Boundary at;
        panel_at(&sweep, &whole, j, &at);
        for (int k = 0; k < LANES; ++k) add_far_cone(c, at.x[k], at.y[k], at.cross[k]);
    }
}

/* Sides of the contact, some at once. */
static void add_pressed_sides(Cones *c, const Pressed *at) {
    Lanes given[EDGE_SIZE + QUADRATIC_SIZE], found[SUM_SIZE], ends[EDGE_SIZE] = {{0.0}}, still[2];
    Lanes turn[MATRIX_SIZE], sums[SUM_SIZE];
    for (int k = 0; k < QUADRATIC_SIZE; ++k) given[EDGE_SIZE + k] = all(c->image[k]);
    for (int k = 0; k < MATRIX_SIZE; ++k) turn[k] = all(c->frame.omega * c->frame.spin[k]);
    for (int k = 0; k < 2; ++k) still[k] = all(c->frame.middle[k]);
    memset(sums, 0, sizeof sums);
    for (int i = 0; i < at->side_count; i += LANES) {
        Lanes counts;
        for (int k = 0; k < LANES; ++k) {
            const double *side = at->sides[i + k < at->side_count ? i + k : i];
            for (int j = 0; j < EDGE_SIZE; ++j) ends[j][k] = side[j];
            counts[k] = i + k < at->side_count;
        }
        for (int j = 0; j < EDGE_SIZE; j += 2) {
            given[j + X] = still[X] + turn[M_XX] * ends[j + X] + turn[M_XY] * ends[j + Y];
            given[j + Y] = still[Y] + turn[M_YX] * ends[j + X] + turn[M_YY] * ends[j + Y];
        }
        pressed_side(given, found);
        for (int j = 0; j < SUM_SIZE; ++j) sums[j] += counts * found[j];
    }
    for (int j = 0; j < SUM_SIZE; ++j) c->sums[j] += sums[j];
}

static void add_far_side(Cones *c, const double *side) {
    double ex = side[EDGE_END_X] - side[EDGE_START_X], ey = side[EDGE_END_Y] - side[EDGE_START_Y];
    double cross = side[EDGE_START_X] * ey - side[EDGE_START_Y] * ex;
    int rule = ALONG_SIDE[c->digits];
    for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; ++j) {
        double s = 0.5 * (1.0 + BOUNDARY_NODES[j]), share = BOUNDARY_WEIGHTS[j] * cross;
        add_far_cone(c, side[EDGE_START_X] + s * ex, side[EDGE_START_Y] + s * ey, share);
    }
}

static void move_pressed_side(Cones *c, const double *side) {
    double found[WRENCH], *results[] = {found};
    const double *given[] = {c->f->twist, c->f->matrix, side, c->quadratic, c->f->toward};
    pressed_side_toward(given, results, 0, 0, 0);
    add(c->moved, found, 1.0, WRENCH);
}

/* Sums in the velocity plane, by the velocity: M^T F and M^T H M. */
static void sums_by_velocity(const double *m, const double *s, double *to) {
    double ax = m[M_XX] * s[SUM_XX] + m[M_YX] * s[SUM_XY];
    double ay = m[M_XX] * s[SUM_XY] + m[M_YX] * s[SUM_YY];
    double bx = m[M_XY] * s[SUM_XX] + m[M_YY] * s[SUM_XY];
    double by = m[M_XY] * s[SUM_XY] + m[M_YY] * s[SUM_YY];
    to[SUM_SPEED] = s[SUM_SPEED];
    to[SUM_X] = m[M_XX] * s[SUM_X] + m[M_YX] * s[SUM_Y];
    to[SUM_Y] = m[M_XY] * s[SUM_X] + m[M_YY] * s[SUM_Y];
    to[SUM_XX] = ax * m[M_XX] + ay * m[M_YX];
    to[SUM_XY] = ax * m[M_XY] + ay * m[M_YY];
    to[SUM_YY] = bx * m[M_XY] + by * m[M_YY];
}

/* Friction about a place, about the frame's origin. */
static void shift(double *g, const double *to) {
    double x = to[X], y = to[Y], cx = g[XW], cy = g[YW];
    g[TORQUE] += x * g[FORCE_Y] - y * g[FORCE_X];
    g[XW] = cx - y * g[XX] + x * g[XY];
    g[YW] = cy - y * g[XY] + x * g[YY];
    g[WW] += x * (cy + g[YW]) - y * (cx + g[XW]);
}

/* Friction under a quadratic over the contact; toward: how its wrench moves, alone. */
static void sum_pressed(const Pressure *pressure, const Pressed *at, const double *quadratic,
                        const double *twist, const double *m, const double *toward, int is_far,
                        double *friction) {
    const double *middle = pressure->middle;
    const double about[] = {[VX] = twist[VX] - twist[OMEGA] * middle[Y],
                            [VY] = twist[VY] + twist[OMEGA] * middle[X],
                            [OMEGA] = twist[OMEGA]};
    Friction f;
    begin_sums(&f, about, m, toward, 0);
    Cones c;
    begin_cones(&c, &f, quadratic, is_far, at->digits);
    if (!is_far && !toward)
        add_pressed_sides(&c, at);
    else
        for (int i = 0; i < at->side_count; ++i) {
            if (is_far)
                add_far_side(&c, at->sides[i]);
            else
                move_pressed_side(&c, at->sides[i]);
        }
    for (int i = 0; i < at->arc_count; ++i) add_arc_of(&c, at->arcs + i);
    if (is_far && toward)
        memcpy(f.friction, c.moved, sizeof c.moved);
    else if (is_far)
        add_sums(&f, &c.frame, &c.places, 1.0);
    else if (toward)
        add(f.sums, c.moved, 1.0, WRENCH);
    else {
        double sums[SUM_SIZE];
        for (int k = 0; k < SUM_SIZE; ++k) sums[k] = total(c.sums + k);
        sums_by_velocity(m, sums, f.sums);
    }
    if (!is_far) {
        f.is_summed = 1;
        end_sums(&f);
    }
    shift(f.friction, middle);
    memcpy(friction, f.friction, (toward ? WRENCH : FRICTION_SIZE) * sizeof(double));
}

/* Derivatives of the wrench by theta through the pressure, since the floor's shape turns against
   the plate. */
static void friction_by_turning(const Pressure *pressure, Pressed *at, const double *twist,
                                const double *m, int is_far, double *by_turning) {
    double turned[SHAPE_SIZE], quadratic[QUADRATIC_SIZE], by[FRICTION_SIZE];
    if (!at->has_slopes) slopes_of(at);
    shapes_by_theta(pressure, at, turned);
    for (int k = 0; k < QUADRATIC_SIZE; ++k)
        quadratic[k] = turned[SHAPE_BOW_X] * at->by_shape[SHAPE_BOW_X][k]
                       + turned[SHAPE_BOW_Y] * at->by_shape[SHAPE_BOW_Y][k];
    sum_pressed(pressure, at, quadratic, twist, m, 0, is_far, by);
    memcpy(by_turning, by, WRENCH * sizeof(double));
}

/* Derivatives of the wrench by the floor's and the plate's shape, by columns. */
static void friction_by_shapes(const Pressure *pressure, Pressed *at, const double *twist,
                               const double *m, int is_far, double *by_shapes) {
    double by[SHAPE_SIZE][FRICTION_SIZE];
    double c = cos(2.0 * at->theta), s = sin(2.0 * at->theta);
    if (!at->has_slopes) slopes_of(at);
    for (int k = 0; k < SHAPE_SIZE; ++k)
        sum_pressed(pressure, at, at->by_shape[k], twist, m, 0, is_far, by[k]);
    double *floor = by_shapes, *plate = by_shapes + WRENCH * SHAPE_SIZE;
    for (int j = 0; j < WRENCH; ++j) {
        double dome = by[SHAPE_DOME][j], bow_x = by[SHAPE_BOW_X][j], bow_y = by[SHAPE_BOW_Y][j];
        plate[WRENCH * SHAPE_DOME + j] = floor[WRENCH * SHAPE_DOME + j] = dome;
        plate[WRENCH * SHAPE_BOW_X + j] = bow_x;
        plate[WRENCH * SHAPE_BOW_Y + j] = bow_y;
        floor[WRENCH * SHAPE_BOW_X + j] = c * bow_x - s * bow_y;
        floor[WRENCH * SHAPE_BOW_Y + j] = s * bow_x + c * bow_y;
    }
}
