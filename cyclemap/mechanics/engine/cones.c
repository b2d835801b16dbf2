/* Friction over the contact of a foundation that is pressed (foundation.c).

   The contact's image in the velocity plane is cut into cones from w = 0, the centre of rotation
   (equations.py, _pressed_side): sides are summed in closed form, arcs by Gauss's rule on panels
   that are short beside their distance from where |w| is singular. From afar cones are taken from
   the centroid and summed place by place. */

/* Arcs of images no farther than this from the centre of rotation are halved no more (extents). */
static const double NEAREST = 1e-12;
/* By digits: centres of rotation farther than this (extents, velocity plane) are summed place by
   place, by these rules along a cone and along a side; from near, sums cancel as the third
   power of the distance. */
static const double FOUNDATION_FAR[] = {30.0, 20.0, 10.0, 3.0};
static const int ALONG_CONE[] = {0, 1, 1, 2}, ALONG_SIDE[] = {2, 2, 2, 3};
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

/* From afar: places along the cones from the centroid to nodes on an arc, as add_places (pressure.c)
   has them. */
static WIDENED void add_far_arc(Cones *c, const Curve *curve, int rule) {
    const double *p = c->quadratic, *turn = c->frame.spin, *still = c->frame.middle;
    double omega = c->frame.omega;
    int along = ALONG_CONE[c->digits];
    Wide sums[FRICTION_SIZE] = {{0.0}};
    for (int i = BOUNDARY_FIRST[rule]; i < BOUNDARY_FIRST[rule + 1]; i += WIDTH) {
        Shares of = shares_at(curve->weight, i);
        Wide end_x = of.down * place_on(curve, &of, X), end_y = of.down * place_on(curve, &of, Y);
        Wide cone = cone_on(curve, &of);
        Wide linear = p[Q_SLOPE_X] * end_x + p[Q_SLOPE_Y] * end_y;
        Wide square = p[Q_XX] * end_x * end_x + p[Q_YY] * end_y * end_y;
        square += 2.0 * p[Q_XY] * end_x * end_y;
        Wide turn_x = turn[M_XX] * end_x + turn[M_XY] * end_y;
        Wide turn_y = turn[M_YX] * end_x + turn[M_YY] * end_y;
        for (int j = BOUNDARY_FIRST[along]; j < BOUNDARY_FIRST[along + 1]; ++j) {
            double s = BOUNDARY_NODES[j], weight = s * BOUNDARY_WEIGHTS[j];
            Wide share = weight * cone * (p[Q_LEVEL] + s * (linear + s * square));
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

/* How what it adds moves. */
static void move_far_arc(Cones *c, const Curve *curve, int rule) {
    int along = ALONG_CONE[c->digits];
    for (int i = BOUNDARY_FIRST[rule]; i < BOUNDARY_FIRST[rule + 1]; i += WIDTH) {
        Shares of = shares_at(curve->weight, i);
        Wide x = of.down * place_on(curve, &of, X), y = of.down * place_on(curve, &of, Y);
        Wide cone = cone_on(curve, &of);
        for (int j = WIDTH * BOUNDARY_FIRST[along]; j < WIDTH * BOUNDARY_FIRST[along + 1]; ++j) {
            int node = j / WIDTH, lane = j % WIDTH;
            double s = BOUNDARY_NODES[node], found[WRENCH], *results[] = {found};
            const double place[] = {s * x[lane], s * y[lane]};
            const double *given[] = {c->f->twist, c->f->matrix, place, c->f->toward};
            point_toward(given, results, 0, 0, 0);
            double share = s * cone[lane] * BOUNDARY_WEIGHTS[node];
            add(c->moved, found, share * pressure_at(c->quadratic, place[X], place[Y]), WRENCH);
        }
    }
}

static ALWAYS_INLINE void image_at(const Plane *p, Wide x, Wide y, Wide *to) {
    to[X] = p->still[X] + (p->turn[M_XX] * x + p->turn[M_XY] * y);
    to[Y] = p->still[Y] + (p->turn[M_YX] * x + p->turn[M_YY] * y);
}

/* Thin cones from the centre of rotation, w = 0, to nodes on arcs. */
static ALWAYS_INLINE void add_stretches(const Cones *c, const Stretches *stretches, Wide *sums) {
    const double *image = c->plane.image, twist = 2.0 * image[Q_XY];
    for (int i = 0; i < stretches->count; ++i) {
        const Curve *curve = stretches->curves + stretches->of[i].curve;
        Shares of = shares_at(curve->weight, stretches->of[i].node);
        Wide x = place_on(curve, &of, X), y = place_on(curve, &of, Y);
        Wide size = roots(x * x + y * y + 1e-300), inverse = 1.0 / size;
        Wide ux = x * inverse, uy = y * inverse, cone = cone_on(curve, &of);
        x *= of.down;
        y *= of.down;
        Wide level = cone * image[Q_LEVEL];
        Wide first = cone * (image[Q_SLOPE_X] * x + image[Q_SLOPE_Y] * y);
        Wide second = cone * (x * (image[Q_XX] * x + twist * y) + image[Q_YY] * (y * y));
        Wide power = level * (1.0 / 3.0) + first * (1.0 / 4.0) + second * (1.0 / 5.0);
        Wide force = level * (1.0 / 2.0) + first * (1.0 / 3.0) + second * (1.0 / 4.0);
        Wide bent = level + first * (1.0 / 2.0) + second * (1.0 / 3.0);
        bent *= of.whole * inverse;
        Wide bent_x = bent * ux, bent_y = bent * uy;
        sums[SUM_SPEED] += power * (size * of.down);
        sums[SUM_X] += force * ux;
        sums[SUM_Y] += force * uy;
        sums[SUM_XX] += bent_y * uy;
        sums[SUM_XY] -= bent_x * uy;
        sums[SUM_YY] += bent_x * ux;
    }
}

/* What functions of a side or a cone are given: its numbers, and the quadratic of w, the same
   everywhere. */
static ALWAYS_INLINE void give_image(const Plane *plane, Wide *to) {
    for (int k = 0; k < QUADRATIC_SIZE; ++k) to[k] = all(plane->image[k]);
}

enum { CONE = 3, CONE_ROOM = CONE + QUADRATIC_SIZE };

/* How D and force of thin cones move, where the image of an arc moves so; given: the quadratic of w
   and its motion. */
static ALWAYS_INLINE void move_arc(const Curve *image, Curve *moved, int rule, Wide *given,
                                   Wide *sums) {
    Wide found[SUM_SIZE], *motion = given + CONE_ROOM;
    moved->ac = 2.0 * image->weight * (across(moved->a, image->c) + across(image->a, moved->c));
    moved->ab = 2.0 * (across(moved->a, image->b) + across(image->a, moved->b));
    moved->cb = 2.0 * image->weight * (across(moved->c, image->b) + across(image->c, moved->b));
    for (int j = BOUNDARY_FIRST[rule]; j < BOUNDARY_FIRST[rule + 1]; j += WIDTH) {
        Shares of = shares_at(image->weight, j);
        for (int k = X; k <= Y; ++k) {
            given[k] = of.down * place_on(image, &of, k);
            motion[k] = of.down * place_on(moved, &of, k);
        }
        given[2] = cone_on(image, &of);
        motion[2] = cone_on(moved, &of);
        pressed_cone_toward(given, found);
        for (int k = 0; k <= SUM_XY; ++k) sums[k] += found[k];
    }
}

/* Where |w| along an arc's image is singular, in x = 2 s - 1: the complex zeros of w, square x^2 + 2
   half x + level: half and its root of the same sense over square, and level over both. */
enum { ZEROS = 2 };
typedef struct {
    Wide x, y;
} Complex;

static ALWAYS_INLINE Complex product(Complex a, Complex b) {
    return (Complex){a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x};
}

/* Over the square of the denominator's size, `whole`. */
static ALWAYS_INLINE Complex over(Complex a, Complex b, Wide *whole) {
    *whole = b.x * b.x + b.y * b.y;
    return (Complex){a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y};
}

static ALWAYS_INLINE void zeros_of(Wide weight, const Wide *a, const Wide *c, const Wide *b,
                                   Complex *zeros, Wide *wholes) {
    Wide twice = 2.0 * weight, bent_x = twice * c[X], bent_y = twice * c[Y];
    Complex square = {a[X] + b[X] - bent_x, a[Y] + b[Y] - bent_y};
    Complex half = {b[X] - a[X], b[Y] - a[Y]}, level = {a[X] + b[X] + bent_x, a[Y] + b[Y] + bent_y};
    Complex own = product(half, half), other = product(square, level);
    Wide x = own.x - other.x, y = own.y - other.y, larger, smaller;
    larger = roots(0.5 * (roots(x * x + y * y) + sizes(x)));
    smaller = 0.5 * y / (larger + 1e-300);
    Complex down;
    for (int k = 0; k < WIDTH; ++k) {
        double real = x[k] >= 0.0 ? larger[k] : fabs(smaller[k]);
        double rest = x[k] >= 0.0 ? smaller[k] : copysign(larger[k], y[k]);
        double sense = half.x[k] * real + half.y[k] * rest >= 0.0 ? -1.0 : 1.0;
        down.x[k] = sense * real - half.x[k];
        down.y[k] = sense * rest - half.y[k];
    }
    zeros[0] = over(down, square, wholes);
    zeros[1] = over(level, down, wholes + 1);
}

/* The first of Gauss's rules that serve each of some arcs' images; none, where that is too near to
   the centre of rotation. */
static ALWAYS_INLINE Flags rules_of(const Arcs *images, int i, int digits) {
    Wide of[CURVE_SIZE], wholes[ZEROS];
    Complex zeros[ZEROS];
    for (int k = 0; k < CURVE_SIZE; ++k) of[k] = taken(images->of[k] + i);
    zeros_of(of[CURVE_WEIGHT], of + CURVE_START_X, of + CURVE_MIDDLE_X, of + CURVE_END_X, zeros,
             wholes);
    Flags rules = {LEAST_RULE, LEAST_RULE, LEAST_RULE, LEAST_RULE};
    for (int rule = LEAST_RULE; rule < BOUNDARY_RULE_COUNT; ++rule) {
        Flags is_near = has_poles(of[CURVE_WEIGHT], digits, rule);
        for (int k = 0; k < ZEROS; ++k) {
            Wide x = zeros[k].x * zeros[k].x, y = zeros[k].y * zeros[k].y;
            is_near |=
                x * REACH_X[digits][rule] + y * REACH_Y[digits][rule] < wholes[k] * wholes[k];
        }
        rules -= is_near;
    }
    return rules;
}

static WIDENED void images_of(const Plane *plane, const Arcs *arcs, Arcs *images) {
    images->count = arcs->count;
    for (int i = 0; i < arcs->count; i += WIDTH) {
        for (int k = CURVE_START_X; k < CURVE_WEIGHT; k += 2) {
            Wide image[2];
            image_at(plane, taken(arcs->of[k + X] + i), taken(arcs->of[k + Y] + i), image);
            memcpy(images->of[k + X] + i, image + X, sizeof *image);
            memcpy(images->of[k + Y] + i, image + Y, sizeof *image);
        }
        memcpy(images->of[CURVE_WEIGHT] + i, arcs->of[CURVE_WEIGHT] + i, sizeof(Wide));
    }
}

/* Whether an image is halved: as long as it is not a place. */
static int is_long(const Arcs *images, int i, double omega) {
    double far = 0.0;
    for (int k = 0; k < CURVE_WEIGHT; ++k) far = fmax(far, fabs(images->of[k][i]));
    return far > NEAREST * fabs(omega) && images->count < ARC_ROOM;
}

/* Arcs, halved near the centre of rotation. */
static WIDENED void add_arcs(Cones *c, const Pressed *at) {
    Arcs images, motions;
    Stretches stretches;
    stretches.count = stretches.curve_count = 0;
    Wide given[2 * CONE_ROOM], sums[SUM_SIZE];
    images_of(&c->plane, &at->arcs, &images);
    if (c->f->toward) {
        images_of(&c->motion, &at->arcs, &motions);
        give_image(&c->plane, given + CONE);
        give_image(&c->motion, given + CONE_ROOM + CONE);
    }
    memcpy(sums, c->sums, sizeof sums);
    for (int i = 0; i < images.count;) {
        Flags rules = rules_of(&images, i, c->digits);
        int width = images.count - i < WIDTH ? images.count - i : WIDTH, is_halved = 0;
        for (int k = 0; k < width; ++k) {
            if (rules[k] < BOUNDARY_RULE_COUNT) continue;
            rules[k] = BOUNDARY_RULE_COUNT - 1;
            if (!is_long(&images, i + k, c->frame.omega)) continue;
            halve_arc(&images, i + k);
            if (c->f->toward) halve_arc(&motions, i + k);
            is_halved = 1;
        }
        if (is_halved) continue;
        for (int k = 0; k < width; ++k) {
            put_stretches(&stretches, &images, i + k, (int)rules[k]);
            if (!c->f->toward) continue;
            Curve image = curve_of(&images, i + k), moved = curve_of(&motions, i + k);
            move_arc(&image, &moved, (int)rules[k], given, sums);
        }
        i += WIDTH;
    }
    if (!c->f->toward) add_stretches(c, &stretches, sums);
    memcpy(c->sums, sums, sizeof sums);
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

/* Friction from afar: a side is an arc that is a parabola's, straight. */
static void sum_from_afar(Cones *c, const Pressed *at) {
    for (int i = 0; i < at->side_count + at->arcs.count; ++i) {
        Curve curve = {.weight = 1.0};
        for (int k = X; k <= Y && i < at->side_count; ++k) {
            curve.a[k] = at->sides[EDGE_START_X + k][i];
            curve.b[k] = at->sides[EDGE_END_X + k][i];
            curve.c[k] = 0.5 * (curve.a[k] + curve.b[k]);
        }
        if (i < at->side_count)
            close_curve(&curve);
        else
            curve = curve_of(&at->arcs, i - at->side_count);
        int rule = arc_rule(curve.weight, c->digits);
        if (rule < ALONG_SIDE[c->digits]) rule = ALONG_SIDE[c->digits];
        if (c->f->toward)
            move_far_arc(c, &curve, rule);
        else
            add_far_arc(c, &curve, rule);
    }
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
