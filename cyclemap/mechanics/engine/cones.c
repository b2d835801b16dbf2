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

/* The velocity plane, w = still + turn x; image: the quadratic of w. */
typedef struct {
    double still[2], turn[MATRIX_SIZE], image[QUADRATIC_SIZE];
} Plane;

/* What is summed at a twist about the centroid, under a quadratic; motion: how the plane moves with
   M. Sums of how D and force move are followed by the force. */
typedef struct {
    Friction *f;
    const double *quadratic;
    int is_far, digits;
    double moved[WRENCH];
    Plane plane, motion;
    Frame frame;
    Wide sums[SUM_SIZE];
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
    for (int i = 0; i < (f->toward ? 2 : 1); ++i) {
        Plane *plane = i ? &c->motion : &c->plane;
        const double *given[] = {f->twist, f->matrix, quadratic, f->toward};
        double *results[] = {plane->image};
        (i ? pressed_image_toward : pressed_image)(given, results, 0, 0, 0);
        Friction by = {.twist = f->twist, .matrix = i ? f->toward : f->matrix};
        Frame frame = frame_of(&by, 0.0, 0.0, 1.0, 1.0);
        memcpy(plane->still, frame.middle, sizeof plane->still);
        for (int k = 0; k < MATRIX_SIZE; ++k) plane->turn[k] = frame.omega * frame.spin[k];
    }
}

/* From afar: places along the cones from the centroid to nodes on the boundary, as add_places
   (pressure.c) has them. */
static WIDENED void add_far_nodes(Cones *c, const Nodes *nodes) {
    const double *p = c->quadratic, *turn = c->frame.spin, *still = c->frame.middle;
    double omega = c->frame.omega;
    Wide sums[FRICTION_SIZE] = {{0.0}};
    int rule = ALONG_CONE[c->digits];
    for (int i = 0; i < nodes->count; i += WIDTH) {
        Wide end_x = taken(nodes->x + i), end_y = taken(nodes->y + i);
        Wide cross = end_x * taken(nodes->dy + i) - end_y * taken(nodes->dx + i);
        Wide linear = p[Q_SLOPE_X] * end_x + p[Q_SLOPE_Y] * end_y;
        Wide square = p[Q_XX] * end_x * end_x + p[Q_YY] * end_y * end_y;
        square += 2.0 * p[Q_XY] * end_x * end_y;
        Wide turn_x = turn[M_XX] * end_x + turn[M_XY] * end_y;
        Wide turn_y = turn[M_YX] * end_x + turn[M_YY] * end_y;
        for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; ++j) {
            double s = 0.5 * (1.0 + BOUNDARY_NODES[j]), weight = s * BOUNDARY_WEIGHTS[j];
            Wide share = weight * cross * (p[Q_LEVEL] + s * (linear + s * square));
            Wide px = s * turn_x, py = s * turn_y;
            Wide wx = still[X] + omega * px, wy = still[Y] + omega * py;
            Wide slowness = 1.0 / roots(wx * wx + wy * wy + 1e-300);
            Wide ux = wx * slowness, uy = wy * slowness, k = share * slowness;
            Wide spin = ux * py - uy * px, kx = -k * uy, ky = k * ux;
            sums[FORCE_X] += share * ux;
            sums[FORCE_Y] += share * uy;
            sums[TORQUE] += share * (ux * px + uy * py);
            sums[XX] -= kx * uy;
            sums[XY] += kx * ux;
            sums[YY] += ky * ux;
            sums[XW] += kx * spin;
            sums[YW] += ky * spin;
            sums[WW] += k * spin * spin;
        }
    }
    for (int k = 0; k < FRICTION_SIZE; ++k) c->places.of[k][0] += summed(sums + k);
}

/* How what they add moves. */
static void move_far_nodes(Cones *c, const Nodes *nodes) {
    int rule = ALONG_CONE[c->digits];
    for (int i = 0; i < nodes->count; ++i) {
        double x = nodes->x[i], y = nodes->y[i], cross = x * nodes->dy[i] - y * nodes->dx[i];
        for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; ++j) {
            double s = 0.5 * (1.0 + BOUNDARY_NODES[j]), found[WRENCH], *results[] = {found};
            const double place[] = {s * x, s * y};
            const double *given[] = {c->f->twist, c->f->matrix, place, c->f->toward};
            point_toward(given, results, 0, 0, 0);
            double share = s * cross * BOUNDARY_WEIGHTS[j];
            add(c->moved, found, share * pressure_at(c->quadratic, place[X], place[Y]), WRENCH);
        }
    }
}

/* Images of places, and of how the boundary goes on there. */
static ALWAYS_INLINE void turn_by(const Plane *p, Wide x, Wide y, Wide *to) {
    to[X] = p->turn[M_XX] * x + p->turn[M_XY] * y;
    to[Y] = p->turn[M_YX] * x + p->turn[M_YY] * y;
}

static ALWAYS_INLINE void image_at(const Plane *p, Wide x, Wide y, Wide *to) {
    turn_by(p, x, y, to);
    to[X] += p->still[X];
    to[Y] += p->still[Y];
}

/* Thin cones from the centre of rotation, w = 0, to nodes on the boundary. */
static WIDENED void add_nodes(Cones *c, const Nodes *nodes, int from, int to) {
    const double *image = c->plane.image, twist = 2.0 * image[Q_XY];
    Wide sums[SUM_SIZE];
    memcpy(sums, c->sums, sizeof sums);
    for (int i = from; i < to; i += WIDTH) {
        Wide w[2], dw[2];
        image_at(&c->plane, taken(nodes->x + i), taken(nodes->y + i), w);
        turn_by(&c->plane, taken(nodes->dx + i), taken(nodes->dy + i), dw);
        Wide x = w[X], y = w[Y], cross = ones(to - i) * (x * dw[Y] - y * dw[X]);
        Wide square = x * x + y * y + 1e-300;
        Wide slowness = 1.0 / roots(square), ux = x * slowness, uy = y * slowness;
        Wide level = cross * image[Q_LEVEL];
        Wide first = cross * (image[Q_SLOPE_X] * x + image[Q_SLOPE_Y] * y);
        Wide second = cross * (x * (image[Q_XX] * x + twist * y) + image[Q_YY] * (y * y));
        Wide power = level * (1.0 / 3.0) + first * (1.0 / 4.0) + second * (1.0 / 5.0);
        Wide force = level * (1.0 / 2.0) + first * (1.0 / 3.0) + second * (1.0 / 4.0);
        Wide bent = slowness * (level + first * (1.0 / 2.0) + second * (1.0 / 3.0));
        Wide bent_x = bent * ux, bent_y = bent * uy;
        sums[SUM_SPEED] += power * (square * slowness);
        sums[SUM_X] += force * ux;
        sums[SUM_Y] += force * uy;
        sums[SUM_XX] += bent_y * uy;
        sums[SUM_XY] -= bent_x * uy;
        sums[SUM_YY] += bent_x * ux;
    }
    memcpy(c->sums, sums, sizeof sums);
}

/* What functions of a side or a cone are given: its numbers, and the quadratic of w, the same
   everywhere. */
static ALWAYS_INLINE void give_image(const Plane *plane, Wide *to) {
    for (int k = 0; k < QUADRATIC_SIZE; ++k) to[k] = all(plane->image[k]);
}

/* How D and force of thin cones move. */
static WIDENED void move_nodes(Cones *c, const Nodes *nodes, int from, int to) {
    enum { CONE = 3, ROOM = CONE + QUADRATIC_SIZE };
    Wide given[2 * ROOM], found[SUM_SIZE], *motion = given + ROOM;
    give_image(&c->plane, given + CONE);
    give_image(&c->motion, motion + CONE);
    for (int i = from; i < to; i += WIDTH) {
        Wide x = taken(nodes->x + i), y = taken(nodes->y + i), w[2], v[2];
        Wide dx = ones(to - i) * taken(nodes->dx + i), dy = ones(to - i) * taken(nodes->dy + i);
        image_at(&c->plane, x, y, given);
        turn_by(&c->plane, dx, dy, w);
        image_at(&c->motion, x, y, motion);
        turn_by(&c->motion, dx, dy, v);
        given[2] = given[X] * w[Y] - given[Y] * w[X];
        motion[2] = motion[X] * w[Y] - motion[Y] * w[X] + given[X] * v[Y] - given[Y] * v[X];
        pressed_cone_toward(given, found);
        for (int k = 0; k <= SUM_XY; ++k) c->sums[k] += found[k];
    }
}

static inline void velocity_at(const Plane *p, const double *place, double *w) {
    w[X] = p->still[X] + p->turn[M_XX] * place[X] + p->turn[M_XY] * place[Y];
    w[Y] = p->still[Y] + p->turn[M_YX] * place[X] + p->turn[M_YY] * place[Y];
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

static void sum_nodes(Cones *c, const Nodes *nodes, int from, int to) {
    if (c->f->toward)
        move_nodes(c, nodes, from, to);
    else
        add_nodes(c, nodes, from, to);
}

/* Panels are halved towards what is singular; the poles' half axis grows at least by its distance
   from 1. */
static void add_panels(Cones *c, const Arc *arc, Axis axis, int zero_count,
                       const double complex *zeros, double low, double high, Nodes *nodes) {
    int rule = panel_rule(arc_rule(axis, c->digits), zero_count, zeros, low, high, c->digits);
    double middle = 0.5 * (low + high);
    if (rule == BOUNDARY_RULE_COUNT && high - low > SHORTEST_PANEL) {
        double farther = 2.0 * sqrt(axis.above / axis.below) - 1.0;
        axis = (Axis){farther * farther, 1.0};
        add_panels(c, arc, axis, zero_count, zeros, low, middle, nodes);
        add_panels(c, arc, axis, zero_count, zeros, middle, high, nodes);
        return;
    }
    if (rule == BOUNDARY_RULE_COUNT) rule = LEAST_RULE;
    if (put_nodes(nodes, arc, rule, low, high)) return;
    sum_nodes(c, nodes, 0, nodes->count);
    nodes->count = 0;
    put_nodes(nodes, arc, rule, low, high);
}

/* Arcs by the nodes that they have, but for those near the centre of rotation. */
static void add_arcs(Cones *c, const Pressed *at) {
    int from = 0;
    Nodes finer;
    finer.count = 0;
    for (int i = 0; i < at->arc_count; ++i) {
        const Arc *arc = at->arcs + i;
        const double *of[] = {arc->a, arc->c, arc->b};
        int last = BOUNDARY_RULE_COUNT - 1, least = arc->rule < last ? arc->rule : last;
        double complex zeros[ZEROS];
        double image[3][2];
        for (int k = 0; k < 3; ++k) velocity_at(&c->plane, of[k], image[k]);
        double reach = BOUNDARY_REACH[c->digits][least];
        int zero_count = zeros_of(arc->weight, image[0], image[1], image[2], reach, zeros);
        int rule = panel_rule(arc->rule, zero_count, zeros, -1.0, 1.0, c->digits);
        if (rule == arc->rule && rule < BOUNDARY_RULE_COUNT) continue;
        sum_nodes(c, &at->nodes, from, arc->first);
        add_panels(c, arc, axis_of(arc->weight), zero_count, zeros, -1.0, 1.0, &finer);
        from = i + 1 < at->arc_count ? arc[1].first : at->nodes.count;
    }
    sum_nodes(c, &at->nodes, from, at->nodes.count);
    sum_nodes(c, &finer, 0, finer.count);
}

/* Sides of the contact, some at once. */
static WIDENED void add_pressed_sides(Cones *c, const Pressed *at) {
    enum { ROOM = EDGE_SIZE + QUADRATIC_SIZE };
    Wide given[2 * ROOM], found[SUM_SIZE] = {{0.0}}, *motion = given + ROOM;
    int is_moved = c->f->toward != 0;
    give_image(&c->plane, given + EDGE_SIZE);
    if (is_moved) give_image(&c->motion, motion + EDGE_SIZE);
    for (int i = 0; i < at->side_count; i += WIDTH) {
        Wide ends[EDGE_SIZE], counts = ones(at->side_count - i);
        for (int j = 0; j < EDGE_SIZE; ++j) ends[j] = taken(at->sides[j] + i);
        for (int j = 0; j < EDGE_SIZE; j += 2) {
            image_at(&c->plane, ends[j + X], ends[j + Y], given + j);
            if (is_moved) image_at(&c->motion, ends[j + X], ends[j + Y], motion + j);
        }
        if (is_moved)
            pressed_side_toward(given, found);
        else
            pressed_side(given, found);
        for (int j = 0; j < SUM_SIZE; ++j) c->sums[j] += counts * found[j];
    }
}

static void sum_far_nodes(Cones *c, Nodes *nodes) {
    if (c->f->toward)
        move_far_nodes(c, nodes);
    else
        add_far_nodes(c, nodes);
    nodes->count = 0;
}

/* Friction from afar: a side is an arc that is a parabola's, straight. */
static void sum_from_afar(Cones *c, const Pressed *at) {
    Nodes nodes;
    nodes.count = 0;
    for (int i = 0; i < at->side_count + at->arc_count; ++i) {
        Arc side = {.weight = 1.0};
        for (int k = 0; k < 2 && i < at->side_count; ++k) {
            side.a[k] = at->sides[EDGE_START_X + k][i];
            side.b[k] = at->sides[EDGE_END_X + k][i];
            side.c[k] = 0.5 * (side.a[k] + side.b[k]);
        }
        const Arc *arc = i < at->side_count ? &side : at->arcs + i - at->side_count;
        int rule = arc_rule(axis_of(arc->weight), c->digits);
        if (rule < ALONG_SIDE[c->digits]) rule = ALONG_SIDE[c->digits];
        if (rule == BOUNDARY_RULE_COUNT) --rule;
        if (put_nodes(&nodes, arc, rule, -1.0, 1.0)) continue;
        sum_far_nodes(c, &nodes);
        put_nodes(&nodes, arc, rule, -1.0, 1.0);
    }
    sum_far_nodes(c, &nodes);
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

/* How D and force move, from their motion in the velocity plane and from M's. */
static void motion_by_velocity(const double *m, const double *toward, const double *s, double *to) {
    const double *force = s + WRENCH;
    to[SUM_SPEED] = s[SUM_SPEED];
    to[SUM_X] = m[M_XX] * s[SUM_X] + m[M_YX] * s[SUM_Y];
    to[SUM_X] += toward[M_XX] * force[X] + toward[M_YX] * force[Y];
    to[SUM_Y] = m[M_XY] * s[SUM_X] + m[M_YY] * s[SUM_Y];
    to[SUM_Y] += toward[M_XY] * force[X] + toward[M_YY] * force[Y];
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
    if (is_far) sum_from_afar(&c, at);
    if (is_far && toward)
        memcpy(f.friction, c.moved, sizeof c.moved);
    else if (is_far)
        add_sums(&f, &c.frame, &c.places, 1.0);
    else {
        double sums[SUM_SIZE];
        add_pressed_sides(&c, at);
        add_arcs(&c, at);
        for (int k = 0; k < SUM_SIZE; ++k) sums[k] = summed(c.sums + k);
        if (toward)
            motion_by_velocity(m, toward, sums, f.sums);
        else
            sums_by_velocity(m, sums, f.sums);
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
