/* Friction over the contact of a foundation that is pressed (foundation.c).

   The contact is cut into cones from the centre of rotation, where w = 0 (equations.py,
   _pressed_side): sides are summed in closed form, arcs by Gauss's rule on panels that are short
   beside their distance from where |w| is singular. From afar cones are taken from the centroid and
   summed place by place. */

/* Panels of arcs that are shorter than this, in 2 s - 1, are summed by the least rule. */
static const double SHORTEST_PANEL = 1e-12;
/* Of rough, usual and fine motions: centres of rotation farther than this (extents, velocity plane)
   are summed place by place, by these rules along a cone and along a side: from there the sums in
   closed form cancel to 1e-9, 1e-10 and 1e-11. */
static const double FOUNDATION_FAR[] = {30.0, 10.0, 5.0};
static const int ALONG_CONE[] = {0, 1, 2}, ALONG_SIDE[] = {1, 2, 4};
/* Motions up to these tolerances are fine ones, usual ones. */
static const double FINE = 2e-11, USUAL = 1e-7;
/* Sums of pieces: D, the force, and the Hessian by the velocity. */
enum { SUM_SPEED, SUM_X, SUM_Y, SUM_XX, SUM_XY, SUM_YY, SUM_SIZE };

/* Which of BOUNDARY_REACH serves a tolerance. */
static int digits_for(double tolerance) {
    return tolerance > USUAL ? 0 : tolerance > FINE ? 1 : 2;
}

static void begin_pressed(Pressed *at, double tolerance) {
    at->is_known = 0;
    at->digits = digits_for(tolerance);
}

/* What is summed at a twist about the centroid, under a quadratic. From near: its value, gradient
   and bend at the centre of rotation, and w = image (x - centre), by columns. */
typedef struct {
    Friction *f;
    const double *quadratic;
    int is_far, digits;
    double centre[2], level, gradient[2], bend[3], image[MATRIX_SIZE];
    double sums[SUM_SIZE], moved[WRENCH];
    Frame frame;
    Sums places;
} Cones;

static Cones cones_of(Friction *f, const double *quadratic, int is_far, int digits) {
    const double *m = f->matrix, *v = f->twist, *q = quadratic, omega = v[OMEGA];
    Cones c = {.f = f, .quadratic = q, .is_far = is_far, .digits = digits};
    if (is_far) {
        c.frame = frame_of(f, 0.0, 0.0, 1.0, 1.0);
        return c;
    }
    c.image[M_XX] = omega * m[M_XY];
    c.image[M_YX] = omega * m[M_YY];
    c.image[M_XY] = -omega * m[M_XX];
    c.image[M_YY] = -omega * m[M_YX];
    c.centre[X] = -v[VY] / omega;
    c.centre[Y] = v[VX] / omega;
    c.bend[0] = q[Q_XX];
    c.bend[1] = 2.0 * q[Q_XY];
    c.bend[2] = q[Q_YY];
    c.level = pressure_at(q, c.centre[X], c.centre[Y]);
    gradient_at(q, c.centre[X], c.centre[Y], c.gradient);
    return c;
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

/* Places on the boundary, how they go on, and the weights with which they count. */
typedef struct { Lanes x, y, by_x, by_y, weight; } Boundary;

/* Thin cones from the centre of rotation to places on the boundary. */
static ALWAYS_INLINE void add_cones(const Cones *c, const Boundary *at, Lanes *sums) {
    const double *b = c->image;
    Lanes x = at->x - c->centre[X], y = at->y - c->centre[Y];
    Lanes cross = at->weight * (x * at->by_y - y * at->by_x);
    Lanes first = c->gradient[X] * x + c->gradient[Y] * y;
    Lanes second = x * (c->bend[0] * x + c->bend[1] * y) + c->bend[2] * y * y;
    Lanes wx = b[M_XX] * x + b[M_XY] * y, wy = b[M_YX] * x + b[M_YY] * y;
    Lanes speed = wx * wx + wy * wy + 1e-300;
    roots(&speed);
    Lanes slowness = 1.0 / speed, ux = wx * slowness, uy = wy * slowness;
    Lanes power = cross * (c->level * (1.0 / 3.0) + first * (1.0 / 4.0) + second * (1.0 / 5.0));
    Lanes force = cross * (c->level * (1.0 / 2.0) + first * (1.0 / 3.0) + second * (1.0 / 4.0));
    Lanes bent = cross * slowness * (c->level + first * (1.0 / 2.0) + second * (1.0 / 3.0));
    sums[SUM_SPEED] += power * speed;
    sums[SUM_X] += force * ux;
    sums[SUM_Y] += force * uy;
    sums[SUM_XX] += bent * uy * uy;
    sums[SUM_XY] -= bent * ux * uy;
    sums[SUM_YY] += bent * ux * ux;
}

/* How D and force of the same move. */
static void move_cones(Cones *c, const Boundary *at) {
    Lanes x = at->x - c->centre[X], y = at->y - c->centre[Y];
    Lanes cross = at->weight * (x * at->by_y - y * at->by_x);
    for (int k = 0; k < LANES; ++k) {
        double found[WRENCH], *results[] = {found};
        const double cone[] = {at->x[k], at->y[k], cross[k]};
        const double *given[] = {c->f->twist, c->f->matrix, cone, c->quadratic, c->f->toward};
        pressed_cone_toward(given, results, 0, 0, 0);
        add(c->moved, found, 1.0, WRENCH);
    }
}

static double complex root_of(double complex z) {
    double x = creal(z), y = cimag(z), larger = sqrt(0.5 * (size_of(x, y) + fabs(x)));
    double smaller = larger > 0.0 ? 0.5 * y / larger : 0.0;
    return x >= 0.0 ? larger + I * smaller : fabs(smaller) + I * copysign(larger, y);
}

/* Where a sum along an arc is singular, 2 s - 1 as (real, imaginary): its poles, which come in
   pairs, and the complex zeros of w, which is a quadratic of the arc's form. */
enum { POLE, MIRRORED, FIRST_ZERO, SECOND_ZERO, SINGULAR };
typedef struct { double at[SINGULAR][2]; } Singular;

static Singular singular_of(const Cones *c, const Arc *arc) {
    double pole = pole_of(arc->weight), real = arc->weight < 1.0 ? 0.0 : pole;
    double imaginary = arc->weight < 1.0 ? pole : 0.0;
    /* of cones from afar, nothing else */
    Singular found = {{{real, imaginary}, {-real, imaginary}, {0.0, 1e9}, {0.0, 1e9}}};
    if (c->is_far) return found;
    const double *b = c->image, *places[] = {arc->a, arc->c, arc->b};
    double complex w[3];
    for (int k = 0; k < 3; ++k) {
        double x = places[k][X] - c->centre[X], y = places[k][Y] - c->centre[Y];
        w[k] = b[M_XX] * x + b[M_XY] * y + I * (b[M_YX] * x + b[M_YY] * y);
    }
    /* in t = s / (1 - s): w2 t^2 + 2 weight w1 t + w0 = 0, 2 s - 1 = (t - 1) / (t + 1) */
    double complex half = arc->weight * w[1], root = root_of(half * half - w[0] * w[2]);
    int same = creal(half) * creal(root) + cimag(half) * cimag(root) >= 0.0;
    double complex down = same ? -half - root : root - half;
    const double complex zero[] = {quotient(down - w[2], down + w[2]), quotient(w[0] - down, w[0] + down)};
    for (int k = 0; k < 2; ++k) {
        found.at[FIRST_ZERO + k][0] = creal(zero[k]);
        found.at[FIRST_ZERO + k][1] = cimag(zero[k]);
    }
    return found;
}

/* How far a panel reaches to what is singular; low and high in 2 s - 1. */
static double panel_reach(const Singular *singular, double low, double high) {
    double middle = 0.5 * (low + high), scale = 2.0 / (high - low), least = INFINITY;
    for (int k = 0; k < SINGULAR; ++k) {
        const double *at = singular->at[k];
        double reach = reach_of((at[0] - middle) * scale, at[1] * scale);
        if (reach < least) least = reach;
    }
    return least;
}

/* Cones to a panel of an arc, halved towards what is singular. */
static void add_panel(Cones *c, const Arc *arc, const Singular *singular, double low, double high) {
    int rule = boundary_rule(panel_reach(singular, low, high), c->digits);
    double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    if (rule == BOUNDARY_RULE_COUNT && half > SHORTEST_PANEL) {
        add_panel(c, arc, singular, low, middle);
        add_panel(c, arc, singular, middle, high);
        return;
    }
    if (rule == BOUNDARY_RULE_COUNT) rule = 0;
    Lanes sums[SUM_SIZE] = {{0.0}};
    const Cones near = *c;
    for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; j += LANES) {
        Lanes node, weight;
        Boundary at;
        memcpy(&node, BOUNDARY_NODES + j, sizeof node);
        memcpy(&weight, BOUNDARY_WEIGHTS + j, sizeof weight);
        Lanes s = 0.5 * (1.0 + middle + half * node);
        arc_at(arc, &s, &at.x, &at.y, &at.by_x, &at.by_y);
        at.weight = half * weight;
        if (c->is_far) {
            Lanes cross = at.weight * (at.x * at.by_y - at.y * at.by_x);
            for (int k = 0; k < LANES; ++k) add_far_cone(c, at.x[k], at.y[k], cross[k]);
        } else if (c->f->toward) move_cones(c, &at);
        else add_cones(&near, &at, sums);
    }
    for (int k = 0; k < SUM_SIZE; ++k) c->sums[k] += sums[k][0] + sums[k][1];
}

static void add_side(Cones *c, const double *side) {
    double found[SUM_SIZE], *results[] = {found};
    const double *twist = c->f->twist, *matrix = c->f->matrix, *toward = c->f->toward;
    if (c->is_far) {
        double ex = side[EDGE_END_X] - side[EDGE_START_X], ey = side[EDGE_END_Y] - side[EDGE_START_Y];
        double cross = side[EDGE_START_X] * ey - side[EDGE_START_Y] * ex;
        int rule = ALONG_SIDE[c->digits];
        for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; ++j) {
            double s = 0.5 * (1.0 + BOUNDARY_NODES[j]), share = BOUNDARY_WEIGHTS[j] * cross;
            add_far_cone(c, side[EDGE_START_X] + s * ex, side[EDGE_START_Y] + s * ey, share);
        }
    } else if (toward) {
        const double *given[] = {twist, matrix, side, c->quadratic, toward};
        pressed_side_toward(given, results, 0, 0, 0);
        add(c->moved, found, 1.0, WRENCH);
    } else {
        const double *given[] = {twist, matrix, side, c->quadratic};
        pressed_side(given, results, 0, 0, 0);
        add(c->f->sums, found, 1.0, SUM_SIZE);
    }
}

/* Sums in the velocity plane, by the velocity: M^T F and M^T H M. */
static void sums_by_velocity(const double *m, const double *s, double *to) {
    double ax = m[M_XX] * s[SUM_XX] + m[M_YX] * s[SUM_XY], ay = m[M_XX] * s[SUM_XY] + m[M_YX] * s[SUM_YY];
    double bx = m[M_XY] * s[SUM_XX] + m[M_YY] * s[SUM_XY], by = m[M_XY] * s[SUM_XY] + m[M_YY] * s[SUM_YY];
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
                            [VY] = twist[VY] + twist[OMEGA] * middle[X], [OMEGA] = twist[OMEGA]};
    Friction f;
    begin_sums(&f, about, m, toward);
    Cones c = cones_of(&f, quadratic, is_far, at->digits);
    for (int i = 0; i < at->side_count; ++i) add_side(&c, at->sides[i]);
    for (int i = 0; i < at->arc_count; ++i) {
        Singular singular = singular_of(&c, at->arcs + i);
        add_panel(&c, at->arcs + i, &singular, -1.0, 1.0);
    }
    if (is_far && toward) memcpy(f.friction, c.moved, sizeof c.moved);
    else if (is_far) add_sums(&f, &c.frame, &c.places, 1.0);
    else {
        double sums[SUM_SIZE];
        sums_by_velocity(m, c.sums, sums);
        add(f.sums, toward ? c.moved : sums, 1.0, toward ? WRENCH : SUM_SIZE);
        f.is_summed = 1;
        end_sums(&f);
    }
    shift(f.friction, middle);
    memcpy(friction, f.friction, (toward ? WRENCH : FRICTION_SIZE) * sizeof(double));
}

/* Derivatives of the wrench by theta through the pressure, and by the floor's and the plate's shape,
   by columns. The floor's turns against the plate. */
static void friction_by_shapes(const Pressure *pressure, Pressed *at, const double *twist,
                               const double *m, int is_far, double *by_turning, double *by_shapes) {
    double by[SHAPE_SIZE][FRICTION_SIZE], turned[SHAPE_SIZE];
    double c = cos(2.0 * at->theta), s = sin(2.0 * at->theta);
    if (!at->has_slopes) slopes_of(at);
    for (int k = 0; k < SHAPE_SIZE; ++k)
        sum_pressed(pressure, at, at->by_shape[k], twist, m, 0, is_far, by[k]);
    shapes_by_theta(pressure, at, turned);
    double *floor = by_shapes, *plate = by_shapes + WRENCH * SHAPE_SIZE;
    for (int j = 0; j < WRENCH; ++j) {
        double dome = by[SHAPE_DOME][j], bow_x = by[SHAPE_BOW_X][j], bow_y = by[SHAPE_BOW_Y][j];
        by_turning[j] = turned[SHAPE_BOW_X] * bow_x + turned[SHAPE_BOW_Y] * bow_y;
        plate[WRENCH * SHAPE_DOME + j] = floor[WRENCH * SHAPE_DOME + j] = dome;
        plate[WRENCH * SHAPE_BOW_X + j] = bow_x;
        plate[WRENCH * SHAPE_BOW_Y + j] = bow_y;
        floor[WRENCH * SHAPE_BOW_X + j] = c * bow_x - s * bow_y;
        floor[WRENCH * SHAPE_BOW_Y + j] = s * bow_x + c * bow_y;
    }
}
