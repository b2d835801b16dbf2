/* The contact of a foundation that is pressed: p = max(0, P), P = c + l . x + q, q a quadratic of
   the plate's shape and, turned against it, the floor's; c and l by the balance of load and moment.
   Places x are off the outline's centroid, P is per unit load.

   The contact, where P > 0, is bounded by stretches of the outline and by arcs of the conic P = 0,
   which are rational curves. Friction is summed over this boundary in cones.c. */

enum { MOST_SIDES = 512, MOST_ARCS = 256, MOST_NODES = 1024, MOST_PLACES = 64 };
/* Integrals of monomials over the contact. */
enum { OF_1, OF_X, OF_Y, OF_XX, OF_XY, OF_YY, OF_XXX, OF_XXY, OF_XYY, OF_YYY, MONOMIALS };
/* Load and moments: of 1, x and y; and what balances them, c and l. */
enum { LOAD, MOMENT_X, MOMENT_Y, BALANCE_SIZE };
/* Arcs are halved until their axis is this at least. */
static const double LEAST_AXIS = 1.8;
enum { MOST_HALVINGS = 6 };
/* Arcs that turn by less than this are sides. */
static const double STRAIGHT_TURN = 1e-13;
/* Where P's gradient is less than this beside what P bends by along an arc the conic nearly falls
   into lines, and rounding hides which way an arc bends: it is straight. */
static const double NEARLY_DOUBLE = 1e-7;
/* An arc of an ellipse's rim goes no farther around it. */
static const double WIDEST_RIM = 1.6;
/* Steps along the rim that are this short and no longer shrink are rounding's. */
static const double ROUNDED = 1e-13;
/* Conics that bend by less than this share of their slope are taken for straight where their arcs
   are sorted. */
static const double STRAIGHT = 1e-9;
/* Loads, of one, that may lack: aimed at, and at the most. */
static const double BALANCED = 1e-13, NEARLY_BALANCED = 1e-11;
enum { MOST_CORRECTIONS = 200 };
/* Steps are halved down to this share. */
static const double SHORTEST_STEP = 1e-6;
/* The table serves as it is where it is off by less than this share of a motion's tolerance. */
static const double LEAN_SHARE = 0.1;
/* A correction by less leaves nothing, whatever the tolerance. */
static const double WELL_CORRECTED = 3e-8;
enum { MOST_REPEATS = 3 };
/* rad: nearer to each other two balances tell no slope. */
static const double NEIGHBOURS = 1e-4;
/* The classes of digits serve motions of tolerances above these. */
static const double ABOVE[] = {1e-7, 1e-8, 2e-11, -INFINITY};

/* An arc of a conic from a to b as a rational curve of Bezier's, c where the tangents at both ends
   meet, t = 1 - s: (t^2 a + 2 weight s t c + s^2 b) / (t^2 + 2 weight s t + s^2), 0 <= s <= 1.
   rule: Gauss's that its poles ask for; first: of its nodes. */
typedef struct {
    double a[2], b[2], c[2], weight;
    int rule, first;
} Arc;

/* Nodes of Gauss's rules on arcs, and how the arcs go on there, times the weights; WIDTH of noughts
   after them. */
typedef struct {
    int count;
    double x[MOST_NODES], y[MOST_NODES], dx[MOST_NODES], dy[MOST_NODES];
} Nodes;

/* The balance at the last few orientations, the newest first, from which the next one is told. */
enum { REMEMBERED = 4 };
typedef struct {
    int count;
    double theta[REMEMBERED], lean[REMEMBERED][BALANCE_SIZE];
} Past;

/* The contact at an orientation: P, how it changes by each number of the shapes, and its boundary,
   the contact on the left, sides by columns, WIDTH more as the first one. is_alone: no table knows
   the pressure where the object stands. */
typedef struct Pressed {
    double theta, pressure[QUADRATIC_SIZE], by_shape[SHAPE_SIZE][QUADRATIC_SIZE];
    double moments[MONOMIALS];
    double tolerance;
    int is_alone, is_known, has_moments, has_slopes, digits, side_count, arc_count;
    double sides[EDGE_SIZE][MOST_SIDES + WIDTH];
    Arc arcs[MOST_ARCS];
    Nodes nodes;
    Past past;
} Pressed;

/* Which of BOUNDARY_REACH serves a tolerance. */
static int digits_for(double tolerance) {
    int digits = 0;
    while (tolerance <= ABOVE[digits]) ++digits;
    return digits;
}

static void begin_pressed(Pressed *at, double tolerance) {
    at->is_alone = at->is_known = at->past.count = 0;
    at->tolerance = tolerance;
    at->digits = digits_for(tolerance);
}

static inline double pressure_at(const double *p, double x, double y) {
    double along_x = p[Q_SLOPE_X] + p[Q_XX] * x + 2.0 * p[Q_XY] * y;
    return p[Q_LEVEL] + x * along_x + y * (p[Q_SLOPE_Y] + p[Q_YY] * y);
}

static inline void gradient_at(const double *p, double x, double y, double *to) {
    to[X] = p[Q_SLOPE_X] + 2.0 * (p[Q_XX] * x + p[Q_XY] * y);
    to[Y] = p[Q_SLOPE_Y] + 2.0 * (p[Q_XY] * x + p[Q_YY] * y);
}

/* The quadratic of both shapes at an orientation, in the plate's frame: dome, and the parts of the
   bow. */
static void shapes_at(const Pressure *pressure, double theta, double *shape) {
    const double *plate = pressure->plate, *floor = pressure->floor;
    double c = cos(2.0 * theta), s = sin(2.0 * theta);
    shape[SHAPE_DOME] = plate[SHAPE_DOME] + floor[SHAPE_DOME];
    shape[SHAPE_BOW_X] = plate[SHAPE_BOW_X] + c * floor[SHAPE_BOW_X] + s * floor[SHAPE_BOW_Y];
    shape[SHAPE_BOW_Y] = plate[SHAPE_BOW_Y] + c * floor[SHAPE_BOW_Y] - s * floor[SHAPE_BOW_X];
}

static void bend(double *p, const double *shape) {
    p[Q_XX] = shape[SHAPE_DOME] + shape[SHAPE_BOW_X];
    p[Q_YY] = shape[SHAPE_DOME] - shape[SHAPE_BOW_X];
    p[Q_XY] = shape[SHAPE_BOW_Y];
}

static int is_pressed(const Pressure *pressure) { return pressure->table_count > 0; }

static int is_ellipse(const Pressure *pressure) { return pressure->side_count == 0; }

static int is_inside(const Pressure *pressure, double x, double y) {
    const double *at = pressure->outline;
    if (!(x * x + y * y <= pressure->reach)) return 0;
    if (is_ellipse(pressure)) return x * x / (at[X] * at[X]) + y * y / (at[Y] * at[Y]) < 1.0;
    int inside = 0;
    for (int64_t i = 0, j = pressure->side_count - 1; i < pressure->side_count; j = i++) {
        const double *a = at + 2 * i, *b = at + 2 * j;
        if ((a[Y] > y) == (b[Y] > y)) continue;
        if (x < a[X] + (y - a[Y]) / (b[Y] - a[Y]) * (b[X] - a[X])) inside = !inside;
    }
    return inside;
}

/* Places where the boundary of the contact changes, in the conic's frame: on the outline, around
   which P turns negative (the boundary goes on along the conic) or positive (it comes from there),
   or inside of it. */
enum { IS_INNER, IS_START, IS_END };
typedef struct {
    double u, v, at[2];
    int kind;
} Place;
typedef struct {
    int count;
    Place of[MOST_PLACES];
} Places;

static void note(Places *places, double x, double y, int kind) {
    if (places->count < MOST_PLACES) {
        Place *place = places->of + places->count;
        place->at[X] = x;
        place->at[Y] = y;
        place->kind = kind;
    }
    ++places->count;
}

static void put_side(Pressed *at, const double *side) {
    for (int k = 0; k < EDGE_SIZE && at->side_count < MOST_SIDES; ++k)
        at->sides[k][at->side_count] = side[k];
    ++at->side_count;
}

/* Stretches of one side on which P > 0, and the places where it changes its sign. */
static void cut_side(Pressed *at, const double *a, const double *b, double first, double last,
                     Places *crossings) {
    const double *p = at->pressure;
    double ex = b[X] - a[X], ey = b[Y] - a[Y];
    double square = p[Q_XX] * ex * ex + 2.0 * p[Q_XY] * ex * ey + p[Q_YY] * ey * ey;
    double linear = last - first - square, root[2] = {-1.0, -1.0}, stops[4] = {0.0};
    double inside = linear * linear - 4.0 * square * first;
    /* P changes its sign, or its extreme lies in between */
    int may_cross = (first > 0.0) != (last > 0.0) || linear * (linear + 2.0 * square) < 0.0;
    if (may_cross && inside > 0.0) {
        double down = -0.5 * (linear + copysign(sqrt(inside), linear));
        if (down != 0.0) root[0] = first / down;
        if (square != 0.0) root[1] = down / square;
    }
    int count = 1;
    for (int k = 0; k < 2; ++k) {
        double t = root[(root[0] <= root[1]) ? k : 1 - k];
        if (!(t >= 0.0 && t < 1.0)) continue;
        int is_rising = linear + 2.0 * t * square > 0.0;
        note(crossings, a[X] + t * ex, a[Y] + t * ey, is_rising ? IS_END : IS_START);
        stops[count++] = t;
    }
    stops[count++] = 1.0;
    for (int k = 0; k + 1 < count; ++k) {
        double middle = 0.5 * (stops[k] + stops[k + 1]);
        if (!(first + middle * (linear + middle * square) > 0.0)) continue;
        const double side[] = {
            [EDGE_START_X] = a[X] + stops[k] * ex,
            [EDGE_START_Y] = a[Y] + stops[k] * ey,
            [EDGE_END_X] = a[X] + stops[k + 1] * ex,
            [EDGE_END_Y] = a[Y] + stops[k + 1] * ey,
        };
        put_side(at, side);
    }
}

/* P along an ellipse's rim, (x, y) on the unit circle, and how it changes with the angle. */
typedef struct {
    double level, slope[2], xx, xy, yy;
} Around;

static Around around_of(const double *p, const double *semi) {
    double a = semi[X], b = semi[Y];
    return (Around){
        .level = p[Q_LEVEL],
        .slope = {a * p[Q_SLOPE_X], b * p[Q_SLOPE_Y]},
        .xx = a * a * p[Q_XX],
        .xy = a * b * p[Q_XY],
        .yy = b * b * p[Q_YY],
    };
}

static double around_at(const Around *e, double x, double y) {
    double along_x = e->slope[X] + e->xx * x + 2.0 * e->xy * y;
    return e->level + x * along_x + y * (e->slope[Y] + e->yy * y);
}

static double around_slope(const Around *e, double x, double y) {
    double bent = e->xy * (x * x - y * y) + (e->yy - e->xx) * x * y;
    return x * e->slope[Y] - y * e->slope[X] + 2.0 * bent;
}

static double around_bend(const Around *e, double x, double y) {
    double bent = (e->yy - e->xx) * (x * x - y * y) - 4.0 * e->xy * x * y;
    return 2.0 * bent - x * e->slope[X] - y * e->slope[Y];
}

/* On the unit circle, where the half angle from a place has this tangent. */
static void turn_half(const double *from, double tangent, double *to) {
    double down = 1.0 / (1.0 + tangent * tangent);
    double c = (1.0 - tangent * tangent) * down, s = 2.0 * tangent * down;
    to[X] = c * from[X] - s * from[Y];
    to[Y] = c * from[Y] + s * from[X];
}

/* Where a function along the rim, of the derivative `by`, changes its sign between two places less
   than half a turn apart: by Newton's method on the tangent of the half angle inside the bracket,
   which is halved where that gains little. Returns its angle from the first. */
static double zero_between(double (*of)(const Around *, double, double),
                           double (*by)(const Around *, double, double), const Around *e,
                           const double *from, const double *end, double *at) {
    enum { MOST_TRIALS = 100 };
    double across = from[X] * end[Y] - from[Y] * end[X];
    double along = from[X] * end[X] + from[Y] * end[Y];
    double low = 0.0, high = across / (1.0 + along), before = high;
    double first = of(e, from[X], from[Y]), last = of(e, end[X], end[Y]);
    double t = first == last ? 0.5 * high : high * first / (first - last);
    for (int i = 0; i < MOST_TRIALS; ++i) {
        turn_half(from, t, at);
        double value = of(e, at[X], at[Y]);
        double step = -0.5 * (1.0 + t * t) * value / by(e, at[X], at[Y]);
        if ((value > 0.0) == !(first > 0.0))
            high = t;
        else
            low = t;
        int is_less = fabs(step) < 0.5 * before;
        if (fabs(step) <= 2e-16 || (!is_less && fabs(step) < ROUNDED)) break;
        if (!is_less || !(low < t + step && t + step < high)) step = 0.5 * (low + high) - t;
        t += step;
        before = fabs(step);
    }
    return 2.0 * atan(t);
}

/* The larger half axis of Bernstein's ellipse, about -1 to 1, in which an arc is analytic in 2 s - 1,
   as the square of a quotient. Its poles are on the imaginary axis, of a hyperbola on the real
   one. */
typedef struct {
    double above, below;
} Axis;

static Axis axis_of(double weight) {
    return (Axis){weight < 1.0 ? 2.0 : 1.0 + weight, fabs(1.0 - weight)};
}

/* The first of Gauss's rules that serves an arc with such poles. On parabolas, whose poles are at
   infinity, sums are of degree 8: six nodes at least. */
enum { LEAST_RULE = 1 };
static int arc_rule(Axis axis, int digits) {
    int rule = LEAST_RULE;
    while (rule < BOUNDARY_RULE_COUNT && axis.above < axis.below * POLE_REACH[digits][rule]) ++rule;
    return rule;
}

static ALWAYS_INLINE Wide all(double x) { return (Wide){0.0} + x; }

/* Nodes of a rule on the panel of an arc from low to high in 2 s - 1; whether there was room. */
static WIDENED int put_nodes(Nodes *to, const Arc *arc, int rule, double low, double high) {
    int first = BOUNDARY_FIRST[rule], count = BOUNDARY_FIRST[rule + 1] - first;
    if (to->count + count + 2 * WIDTH > MOST_NODES) return 0;
    const double *a = arc->a, *b = arc->b, *c = arc->c, twice = 2.0 * arc->weight;
    double half = 0.5 * (high - low), middle = 0.5 + 0.25 * (low + high);
    for (int j = 0; j < count; j += WIDTH) {
        int at = to->count + j;
        Wide node, share;
        memcpy(&node, BOUNDARY_NODES + first + j, sizeof node);
        memcpy(&share, BOUNDARY_WEIGHTS + first + j, sizeof share);
        Wide s = middle + 0.5 * half * node, t = 1.0 - s;
        Wide begun = t * t, ended = s * s, both = s * t;
        both += both;
        Wide bent = arc->weight * both, down = 1.0 / (begun + bent + ended);
        Wide x = (begun * a[X] + bent * c[X] + ended * b[X]) * down;
        Wide y = (begun * a[Y] + bent * c[Y] + ended * b[Y]) * down;
        share *= half * (down * down);
        begun *= twice;
        ended *= twice;
        Wide dx = begun * (c[X] - a[X]) + both * (b[X] - a[X]) + ended * (b[X] - c[X]);
        Wide dy = begun * (c[Y] - a[Y]) + both * (b[Y] - a[Y]) + ended * (b[Y] - c[Y]);
        dx *= share;
        dy *= share;
        memcpy(to->x + at, &x, sizeof x);
        memcpy(to->y + at, &y, sizeof y);
        memcpy(to->dx + at, &dx, sizeof dx);
        memcpy(to->dy + at, &dy, sizeof dy);
    }
    to->count += count;
    double *columns[] = {to->x, to->y, to->dx, to->dy};
    for (int k = 0; k < 4; ++k) memset(columns[k] + to->count, 0, sizeof(Wide));
    return 1;
}

static void put_arc(Pressed *at, const Arc *arc) {
    if (at->arc_count < MOST_ARCS) {
        Arc *to = at->arcs + at->arc_count;
        *to = *arc;
        to->rule = arc_rule(axis_of(arc->weight), at->digits);
        to->first = at->nodes.count;
        int rule = to->rule < BOUNDARY_RULE_COUNT ? to->rule : BOUNDARY_RULE_COUNT - 1;
        /* without room for its nodes there are too many arcs */
        if (!put_nodes(&at->nodes, to, rule, -1.0, 1.0)) at->arc_count = MOST_ARCS;
    }
    ++at->arc_count;
}

/* A place on the unit circle. */
typedef struct {
    double angle, at[2];
} Stop;

/* Arcs of an ellipse's rim from a stop to an angle. */
static void add_rims(Pressed *at, const double *semi, const Stop *from, double to) {
    int count = (int)ceil((to - from->angle) / WIDEST_RIM);
    double half = 0.5 * (to - from->angle) / count, c = cos(half), s = sin(half);
    double x = from->at[X], y = from->at[Y];
    for (int i = 0; i < count; ++i) {
        double middle_x = c * x - s * y, middle_y = c * y + s * x;
        Arc arc = {
            .a = {semi[X] * x, semi[Y] * y},
            .c = {semi[X] * middle_x / c, semi[Y] * middle_y / c},
            .weight = c,
        };
        x = c * middle_x - s * middle_y;
        y = c * middle_y + s * middle_x;
        arc.b[X] = semi[X] * x;
        arc.b[Y] = semi[Y] * y;
        put_arc(at, &arc);
    }
}

/* The same of an ellipse's rim: P along it has four zeros at most, one between neighbours of its
   extremes. */
static void cut_rim(Pressed *at, const double *semi, Places *crossings) {
    enum { MOST = 2 * RIM_SAMPLES, MOST_CUTS = 8 };
    int kinds[MOST_CUTS], count = 0, cut_count = 0;
    Around e = around_of(at->pressure, semi);
    Stop stops[MOST + 1], cuts[MOST_CUTS];
    double values[MOST + 1], step = 2.0 * M_PI / RIM_SAMPLES;
    double slope = around_slope(&e, 1.0, 0.0), value = around_at(&e, 1.0, 0.0);
    /* between samples of one sign P vanishes only where it is less than it can bend by */
    double most_bend = size_of(e.slope[X], e.slope[Y]) + 2.0 * fabs(e.yy - e.xx) + 4.0 * fabs(e.xy);
    double least = 0.125 * step * step * most_bend;
    for (int i = 0; i <= RIM_SAMPLES; ++i) {
        Stop here = {i * step, {RIM_COSINES[i], RIM_SINES[i]}};
        stops[count] = here;
        values[count++] = value;
        if (i == RIM_SAMPLES) break;
        const double there[] = {RIM_COSINES[i + 1], RIM_SINES[i + 1]};
        double next = around_slope(&e, there[X], there[Y]);
        double after = around_at(&e, there[X], there[Y]);
        int may_vanish = fmin(fabs(value), fabs(after)) <= least;
        if (may_vanish && (slope > 0.0) != (next > 0.0)) {
            Stop *extreme = stops + count;
            double t = zero_between(around_slope, around_bend, &e, here.at, there, extreme->at);
            extreme->angle = here.angle + t;
            values[count++] = around_at(&e, extreme->at[X], extreme->at[Y]);
        }
        slope = next;
        value = after;
    }
    for (int i = 0; i + 1 < count; ++i)
        if ((values[i] > 0.0) != (values[i + 1] > 0.0) && cut_count < MOST_CUTS) {
            const Stop *low = stops + i;
            Stop *to = cuts + cut_count;
            kinds[cut_count++] = values[i + 1] > 0.0 ? IS_END : IS_START;
            double t = zero_between(around_at, around_slope, &e, low->at, low[1].at, to->at);
            to->angle = low->angle + t;
        }
    if (!cut_count) {
        if (values[0] > 0.0) add_rims(at, semi, stops, 2.0 * M_PI);
        return;
    }
    for (int i = 0; i < cut_count; ++i) {
        double end = i + 1 < cut_count ? cuts[i + 1].angle : cuts[0].angle + 2.0 * M_PI;
        note(crossings, semi[X] * cuts[i].at[X], semi[Y] * cuts[i].at[Y], kinds[i]);
        if (kinds[i] == IS_END) add_rims(at, semi, cuts + i, end);
    }
}

/* The arc of P = 0 from a to b, P > 0 on its left: the turn of P's gradient, at most a right angle,
   is that of the arc. */
static void add_arc(Pressed *at, const double *a, const double *b) {
    const double *p = at->pressure, ex = b[X] - a[X], ey = b[Y] - a[Y];
    double first[2], last[2];
    gradient_at(p, a[X], a[Y], first);
    gradient_at(p, b[X], b[Y], last);
    double turn = first[X] * last[Y] - first[Y] * last[X];
    /* all squared */
    double start = first[X] * first[X] + first[Y] * first[Y];
    double end = last[X] * last[X] + last[Y] * last[Y];
    double bend = NEARLY_DOUBLE * (fabs(p[Q_XX]) + 2.0 * fabs(p[Q_XY]) + fabs(p[Q_YY]));
    double least = bend * bend * (ex * ex + ey * ey);
    int is_bent = turn * turn > STRAIGHT_TURN * STRAIGHT_TURN * start * end;
    if (!is_bent || start < least || end < least) {
        const double side[] = {a[X], a[Y], b[X], b[Y]};
        put_side(at, side);
        return;
    }
    /* c = a + along (-first_y, first_x): off both gradients */
    double along = (last[X] * ex + last[Y] * ey) / turn, cx = -along * first[Y];
    double cy = along * first[X];
    double bulge = p[Q_XX] * ex * ex + 2.0 * p[Q_XY] * ex * ey + p[Q_YY] * ey * ey;
    double bent = p[Q_XX] * cx * cx + 2.0 * p[Q_XY] * cx * cy + p[Q_YY] * cy * cy;
    Arc whole = {
        .a = {a[X], a[Y]},
        .b = {b[X], b[Y]},
        .c = {a[X] + cx, a[Y] + cy},
        .weight = sqrt(fabs(0.25 * bulge / bent)),
    };
    /* halves meet at s = 1/2 until poles are far */
    int halvings = 0;
    Axis axis = axis_of(whole.weight);
    for (double weight = whole.weight;
         halvings < MOST_HALVINGS && axis.above < LEAST_AXIS * LEAST_AXIS * axis.below;
         ++halvings) {
        weight = sqrt(0.5 * (1.0 + weight));
        axis = axis_of(weight);
    }
    if (!halvings) {
        put_arc(at, &whole);
        return;
    }
    for (int i = 0; i < 1 << halvings; ++i) {
        Arc arc = whole;
        for (int level = halvings - 1; level >= 0; --level) {
            double share = 1.0 / (1.0 + arc.weight);
            Arc half = arc;
            int later = i >> level & 1;
            for (int k = 0; k < 2; ++k) {
                double before = share * (arc.a[k] + arc.weight * arc.c[k]);
                double after = share * (arc.b[k] + arc.weight * arc.c[k]);
                *(later ? half.a + k : half.b + k) = 0.5 * (before + after);
                half.c[k] = later ? after : before;
            }
            half.weight = sqrt(0.5 * (1.0 + arc.weight));
            arc = half;
        }
        put_arc(at, &arc);
    }
}

static void sort_places(Places *places) {
    for (int i = 1; i < places->count; ++i) {
        Place moved = places->of[i];
        int j = i;
        for (; j > 0 && places->of[j - 1].v > moved.v; --j) places->of[j] = places->of[j - 1];
        places->of[j] = moved;
    }
}

/* The conic in a frame of its own: P = a u^2 + b u + d v^2 + e v + c, |a| >= |d|, so that u is a
   root along v. */
typedef struct {
    double cosine, sine, a, b, c, d, e;
} Conic;

static Conic conic_of(const double *p) {
    double half = 0.5 * (p[Q_XX] - p[Q_YY]), mean = 0.5 * (p[Q_XX] + p[Q_YY]);
    double spread = size_of(half, p[Q_XY]), slope = size_of(p[Q_SLOPE_X], p[Q_SLOPE_Y]);
    double cosine = 1.0, sine = 0.0;
    if (fabs(mean) + spread < STRAIGHT * slope) {
        cosine = p[Q_SLOPE_X] / slope;
        sine = p[Q_SLOPE_Y] / slope;
    } else if (spread > 0.0) {
        /* the axis of the larger bend: half the angle of (x, y) */
        double x = copysign(1.0, mean) * half / spread, y = copysign(1.0, mean) * p[Q_XY] / spread;
        double larger = sqrt(0.5 * (1.0 + fabs(x))), smaller = 0.5 * y / larger;
        cosine = x >= 0.0 ? larger : smaller;
        sine = x >= 0.0 ? smaller : larger;
    }
    Conic k = {.cosine = cosine, .sine = sine, .c = p[Q_LEVEL]};
    k.a = mean < 0.0 ? mean - spread : mean + spread;
    k.d = mean < 0.0 ? mean + spread : mean - spread;
    k.b = k.cosine * p[Q_SLOPE_X] + k.sine * p[Q_SLOPE_Y];
    k.e = k.cosine * p[Q_SLOPE_Y] - k.sine * p[Q_SLOPE_X];
    return k;
}

/* Where the conic is at v, on the branch of a sign; NAN where it is not. */
static double branch_at(const Conic *k, double v, double sign) {
    double rest = k->c + v * (k->e + v * k->d), inside = k->b * k->b - 4.0 * k->a * rest;
    if (inside < 0.0) return NAN;
    double root = sign * sqrt(inside);
    if (root * k->b > 0.0) return -2.0 * rest / (root + k->b);
    return (root - k->b) / (2.0 * k->a);
}

static void place_at(const Conic *k, double u, double v, Place *place) {
    double x = k->cosine * u - k->sine * v, y = k->sine * u + k->cosine * v;
    *place = (Place){u, v, {x, y}, IS_INNER};
}

/* Where the conic goes from one branch to the other, inside the outline. */
static int turns_of(const Pressure *pressure, const Conic *k, Place *turns) {
    double square = -4.0 * k->a * k->d, linear = -4.0 * k->a * k->e;
    double level = k->b * k->b - 4.0 * k->a * k->c, inside = linear * linear - 4.0 * square * level;
    if (!(inside > 0.0)) return 0;
    double down = -0.5 * (linear + copysign(sqrt(inside), linear));
    const double at[] = {level / down, down / square};
    int count = 0;
    for (int i = 0; i < 2; ++i) {
        place_at(k, -k->b / (2.0 * k->a), at[i], turns + count);
        if (is_inside(pressure, turns[count].at[X], turns[count].at[Y])) ++count;
    }
    return count;
}

/* The arcs between the places of one branch, on which P > 0 on the left; u grows with P where
   `side` is 1, so that v falls along it there, and grows on the other. */
static void add_branch(const Pressure *pressure, Pressed *at, const Conic *k, double side,
                       Places *branch) {
    for (int i = 0; i + 1 < branch->count; ++i) {
        const Place *low = branch->of + i, *high = low + 1;
        const Place *from = side > 0.0 ? high : low, *to = side > 0.0 ? low : high;
        int is_begun = from->kind != IS_END, is_ended = to->kind != IS_START;
        if (is_begun != is_ended) {
            /* places so close that rounding has them in another order */
            Place middle;
            double v = 0.5 * (low->v + high->v);
            place_at(k, branch_at(k, v, side), v, &middle);
            is_begun = is_inside(pressure, middle.at[X], middle.at[Y]);
        }
        if (is_begun && high->v > low->v) add_arc(at, from->at, to->at);
    }
}

/* The arcs of P = 0 inside the outline, from its crossings of it and from where it turns. */
static void cut_inside(const Pressure *pressure, Pressed *at, const Places *crossings) {
    Conic k = conic_of(at->pressure);
    /* what does not cross the outline is closed, an ellipse */
    if (!crossings->count && !(k.a * k.d > 0.0)) return;
    Place turns[2];
    int turn_count = turns_of(pressure, &k, turns);
    if (!crossings->count && !turn_count) return;
    for (double side = -1.0; side <= 1.0; side += 2.0) {
        Places branch;
        branch.count = turn_count;
        memcpy(branch.of, turns, (size_t)turn_count * sizeof *turns);
        for (int i = 0; i < crossings->count; ++i) {
            Place place = crossings->of[i];
            place.u = k.cosine * place.at[X] + k.sine * place.at[Y];
            place.v = k.cosine * place.at[Y] - k.sine * place.at[X];
            int is_here = (2.0 * k.a * place.u + k.b > 0.0) == (side > 0.0);
            if (is_here) branch.of[branch.count++] = place;
        }
        if (!branch.count) continue;
        /* halfway between the turns no arc turns by more than a right angle */
        Place *middle = branch.of + branch.count;
        double v = -k.e / (2.0 * k.d);
        place_at(&k, branch_at(&k, v, side), v, middle);
        if (is_inside(pressure, middle->at[X], middle->at[Y])) ++branch.count;
        sort_places(&branch);
        add_branch(pressure, at, &k, side, &branch);
    }
}

static void forget_pressure(Pressed *at) {
    for (int k = 0; k < BALANCE_SIZE; ++k) at->pressure[k] = NAN;
}

/* The boundary of the contact under the pressure at hand; whether there was room for it: if not,
   nothing is known of either. */
static int cut(const Pressure *pressure, Pressed *at) {
    Places crossings;
    crossings.count = 0;
    const double *outline = pressure->outline;
    at->has_moments = at->has_slopes = at->side_count = at->arc_count = at->nodes.count = 0;
    if (is_ellipse(pressure)) cut_rim(at, outline, &crossings);
    double first = pressure_at(at->pressure, outline[X], outline[Y]);
    for (int64_t i = 0; i < pressure->side_count; ++i) {
        const double *a = outline + 2 * i;
        const double *b = i + 1 < pressure->side_count ? a + 2 : outline;
        double last = pressure_at(at->pressure, b[X], b[Y]);
        cut_side(at, a, b, first, last, &crossings);
        first = last;
    }
    int has_room = crossings.count <= MOST_PLACES - 4;
    if (has_room) cut_inside(pressure, at, &crossings);
    if (at->side_count > MOST_SIDES || at->arc_count > MOST_ARCS) has_room = 0;
    if (!has_room) {
        at->side_count = at->arc_count = at->nodes.count = 0;
        forget_pressure(at);
    }
    for (int k = 0; k < EDGE_SIZE; ++k)
        for (int i = 0; i < WIDTH; ++i) at->sides[k][at->side_count + i] = at->sides[k][0];
    return has_room;
}

/* Integrals of monomials over cones from the centroid: cross x^i y^j / (i + j + 2). */
static ALWAYS_INLINE void add_monomials(Wide *m, Wide x, Wide y, Wide cross) {
    Wide second = cross * (1.0 / 2.0), third = cross * (1.0 / 3.0), fourth = cross * (1.0 / 4.0);
    Wide fifth = cross * (1.0 / 5.0);
    Wide xx = x * x, xy = x * y, yy = y * y, fx = fifth * x, fy = fifth * y;
    m[OF_1] += second;
    m[OF_X] += third * x;
    m[OF_Y] += third * y;
    m[OF_XX] += fourth * xx;
    m[OF_XY] += fourth * xy;
    m[OF_YY] += fourth * yy;
    m[OF_XXX] += fx * xx;
    m[OF_XXY] += fy * xx;
    m[OF_XYY] += fx * yy;
    m[OF_YYY] += fy * yy;
}

static ALWAYS_INLINE Wide taken(const double *from) {
    Wide x;
    memcpy(&x, from, sizeof x);
    return x;
}

/* One for the first so many, nought after them. */
static ALWAYS_INLINE Wide ones(int count) {
    static const double of[2 * WIDTH] = {1.0, 1.0, 1.0, 1.0};
    return taken(of + WIDTH - (count < WIDTH ? count : WIDTH));
}

static ALWAYS_INLINE double summed(const Wide *x) {
    return ((*x)[0] + (*x)[1]) + ((*x)[2] + (*x)[3]);
}

/* Of the contact. Along a side Gauss's rule of two nodes is exact. */
static WIDENED void take_moments(Pressed *at) {
    static const double places[] = {0.21132486540518711775, 0.78867513459481288225};
    Wide m[MONOMIALS] = {{0.0}};
    for (int i = 0; i < at->side_count; i += WIDTH) {
        Wide ends[EDGE_SIZE];
        for (int k = 0; k < EDGE_SIZE; ++k) ends[k] = taken(at->sides[k] + i);
        Wide x = ends[EDGE_START_X], ex = ends[EDGE_END_X] - x;
        Wide y = ends[EDGE_START_Y], ey = ends[EDGE_END_Y] - y, share = 0.5 * (x * ey - y * ex);
        share *= ones(at->side_count - i);
        for (int j = 0; j < 2; ++j) add_monomials(m, x + places[j] * ex, y + places[j] * ey, share);
    }
    const Nodes *nodes = &at->nodes;
    for (int i = 0; i < nodes->count; i += WIDTH) {
        Wide x = taken(nodes->x + i), y = taken(nodes->y + i);
        add_monomials(m, x, y, x * taken(nodes->dy + i) - y * taken(nodes->dx + i));
    }
    for (int k = 0; k < MONOMIALS; ++k) at->moments[k] = summed(m + k);
    at->has_moments = 1;
}

/* Load and moments (3) of a quadratic over the contact. */
static void loads_of(const double *m, const double *p, double *to) {
    /* of each monomial, those of it times 1, x and y */
    static const int of[QUADRATIC_SIZE][BALANCE_SIZE] = {
        [Q_LEVEL] = {OF_1, OF_X, OF_Y},     [Q_SLOPE_X] = {OF_X, OF_XX, OF_XY},
        [Q_SLOPE_Y] = {OF_Y, OF_XY, OF_YY}, [Q_XX] = {OF_XX, OF_XXX, OF_XXY},
        [Q_XY] = {OF_XY, OF_XXY, OF_XYY},   [Q_YY] = {OF_YY, OF_XYY, OF_YYY},
    };
    for (int k = 0; k < BALANCE_SIZE; ++k) {
        to[k] = p[Q_XY] * m[of[Q_XY][k]];
        for (int j = 0; j < QUADRATIC_SIZE; ++j) to[k] += p[j] * m[of[j][k]];
    }
}

/* c and l (3) whose load and moments over the contact are these. */
static void lean_for(const double *m, const double *load, double *to) {
    /* symmetric: rows 1, x, y */
    double a = m[OF_XX] * m[OF_YY] - m[OF_XY] * m[OF_XY];
    double b = m[OF_Y] * m[OF_XY] - m[OF_X] * m[OF_YY];
    double c = m[OF_X] * m[OF_XY] - m[OF_Y] * m[OF_XX];
    double det = m[OF_1] * a + m[OF_X] * b + m[OF_Y] * c;
    double d = m[OF_1] * m[OF_YY] - m[OF_Y] * m[OF_Y], e = m[OF_X] * m[OF_Y] - m[OF_1] * m[OF_XY];
    double f = m[OF_1] * m[OF_XX] - m[OF_X] * m[OF_X];
    to[LOAD] = (a * load[LOAD] + b * load[MOMENT_X] + c * load[MOMENT_Y]) / det;
    to[MOMENT_X] = (b * load[LOAD] + d * load[MOMENT_X] + e * load[MOMENT_Y]) / det;
    to[MOMENT_Y] = (c * load[LOAD] + e * load[MOMENT_X] + f * load[MOMENT_Y]) / det;
}

/* What load and moments lack (3), and c and l that would make it up. */
static double lacking(const Pressure *pressure, const Pressed *at, double *step) {
    double load[BALANCE_SIZE];
    loads_of(at->moments, at->pressure, load);
    for (int k = 0; k < BALANCE_SIZE; ++k) load[k] = (k ? pressure->centre[k - 1] : 1.0) - load[k];
    lean_for(at->moments, load, step);
    return fmax(fabs(load[LOAD]), fmax(fabs(load[MOMENT_X]), fabs(load[MOMENT_Y])));
}

/* Balances load and moments from the c and l at hand by Newton's method on a convex function;
   whether that came to an end. */
static int balance_fully(const Pressure *pressure, Pressed *at) {
    double step[BALANCE_SIZE], tried[BALANCE_SIZE], left;
    if (!cut(pressure, at)) return 0;
    take_moments(at);
    left = lacking(pressure, at, step);
    for (int i = 0; i < MOST_CORRECTIONS && left > BALANCED; ++i) {
        double share = 1.0, now = INFINITY;
        memcpy(tried, at->pressure, sizeof tried);
        for (; share > SHORTEST_STEP; share *= 0.5) {
            double next[BALANCE_SIZE];
            for (int k = 0; k < BALANCE_SIZE; ++k) at->pressure[k] = tried[k] + share * step[k];
            if (!cut(pressure, at)) return 0;
            take_moments(at);
            now = at->moments[OF_1] > 0.0 ? lacking(pressure, at, next) : INFINITY;
            if (now < left || now <= BALANCED) {
                memcpy(step, next, sizeof next);
                break;
            }
        }
        if (!(now < left)) return left < NEARLY_BALANCED;
        left = now;
    }
    return left <= NEARLY_BALANCED;
}

/* The same, with all digits. */
static int balance(const Pressure *pressure, Pressed *at) {
    int digits = at->digits;
    at->digits = DIGIT_CLASSES - 1;
    int is_balanced = balance_fully(pressure, at);
    at->digits = digits;
    return is_balanced;
}

/* Derivatives of c and l by what the shape's numbers add to P. */
static void slopes_of(Pressed *at) {
    if (!at->has_moments) take_moments(at);
    for (int k = 0; k < SHAPE_SIZE; ++k) {
        double shape[SHAPE_SIZE] = {0.0}, load[BALANCE_SIZE], *to = at->by_shape[k];
        shape[k] = 1.0;
        memset(to, 0, BALANCE_SIZE * sizeof(double));
        bend(to, shape);
        loads_of(at->moments, to, load);
        for (int j = 0; j < BALANCE_SIZE; ++j) load[j] = -load[j];
        lean_for(at->moments, load, to);
    }
    at->has_slopes = 1;
}

/* How the shapes' numbers change by theta. */
static void shapes_by_theta(const Pressure *pressure, const Pressed *at, double *by) {
    const double *plate = pressure->plate;
    double bow = 0.5 * (at->pressure[Q_XX] - at->pressure[Q_YY]) - plate[SHAPE_BOW_X];
    double twist = at->pressure[Q_XY] - plate[SHAPE_BOW_Y];
    by[SHAPE_DOME] = 0.0;
    by[SHAPE_BOW_X] = 2.0 * twist;
    by[SHAPE_BOW_Y] = -2.0 * bow;
}

/* The pressure at an orientation by the cubic between two rows of the table; returns how far it may
   be off. */
static double lean_between(const Pressure *pressure, double theta, double *p) {
    double count = (double)pressure->table_count, turns = theta / M_PI;
    double place = (turns - floor(turns)) * count, h = M_PI / count, shape[SHAPE_SIZE];
    int64_t index = (int64_t)place, last = pressure->table_count - 1;
    if (index > last) index = last;
    const double *a = pressure->table + BALANCE_COLUMNS * index;
    const double *b = index < last ? a + BALANCE_COLUMNS : pressure->table;
    double s = place - (double)index, t = 1.0 - s;
    for (int k = 0; k < BALANCE_SIZE; ++k) {
        double after_a = (1.0 + 2.0 * s) * a[BALANCE_LEAN + k] + s * h * a[BALANCE_SLOPE + k];
        double before_b = (1.0 + 2.0 * t) * b[BALANCE_LEAN + k] - t * h * b[BALANCE_SLOPE + k];
        p[k] = t * t * after_a + s * s * before_b;
    }
    shapes_at(pressure, theta, shape);
    bend(p, shape);
    return a[BALANCE_ERROR];
}

/* One step of Newton's method towards the balance; returns how much it moves c or l. The boundary
   stays: P vanishes on it, so that it counts by squares. */
static double correct(const Pressure *pressure, Pressed *at) {
    double step[BALANCE_SIZE], most = 0.0;
    if (!at->has_moments) take_moments(at);
    lacking(pressure, at, step);
    for (int k = 0; k < BALANCE_SIZE; ++k) {
        at->pressure[k] += step[k];
        if (!(fabs(step[k]) <= most)) most = fabs(step[k]);
    }
    return most;
}

/* c and l to begin with where nothing is known: corrected once as if all of the outline were in
   contact; whether there was room. */
static int begin_balance(const Pressure *pressure, const double *shape, Pressed *at) {
    memset(at->pressure, 0, sizeof at->pressure);
    at->pressure[Q_LEVEL] = 1.0;
    if (!cut(pressure, at)) return 0;
    at->pressure[Q_LEVEL] = 0.0;
    bend(at->pressure, shape);
    correct(pressure, at);
    return 1;
}

/* Derivatives of c and l by theta. */
static void lean_by_theta(const Pressure *pressure, const Pressed *at, double *to) {
    double by[SHAPE_SIZE];
    shapes_by_theta(pressure, at, by);
    for (int k = 0; k < BALANCE_SIZE; ++k)
        to[k] = by[SHAPE_BOW_X] * at->by_shape[SHAPE_BOW_X][k]
                + by[SHAPE_BOW_Y] * at->by_shape[SHAPE_BOW_Y][k];
}

/* A table over half a turn, rows of BALANCE; returns the rows that could be found. pressure: has
   its address already. */
EXPORT int64_t cm_balance(const Pressure *pressure, double *table) {
    Pressed at;
    begin_pressed(&at, 0.0);
    double shape[SHAPE_SIZE];
    int64_t count = pressure->table_count;
    for (int64_t i = 0; i < count; ++i) {
        double *row = table + BALANCE_COLUMNS * i;
        shapes_at(pressure, M_PI * (double)i / (double)count, shape);
        if (i == 0 && !begin_balance(pressure, shape, &at)) return 0;
        bend(at.pressure, shape);
        if (!balance(pressure, &at)) return i;
        slopes_of(&at);
        memcpy(row + BALANCE_LEAN, at.pressure, BALANCE_SIZE * sizeof(double));
        lean_by_theta(pressure, &at, row + BALANCE_SLOPE);
    }
    for (int64_t i = 0; i < count; ++i) {
        lean_between(pressure, M_PI * ((double)i + 0.5) / (double)count, at.pressure);
        if (!cut(pressure, &at)) return i;
        table[BALANCE_COLUMNS * i + BALANCE_ERROR] = correct(pressure, &at);
    }
    return count;
}

/* Corrects the pressure in few steps; whether the last one was so short that its square is less
   than the tolerance. */
static int settle(const Pressure *pressure, Pressed *at) {
    double enough = fmax(0.1 * sqrt(at->tolerance), WELL_CORRECTED);
    for (int i = 0; i < MOST_REPEATS; ++i) {
        if (correct(pressure, at) <= enough) return 1;
        cut(pressure, at);
    }
    return 0;
}

/* c and l as a polynomial through those of the last few orientations has them. */
static void lean_ahead(const Past *past, double theta, double *to) {
    for (int k = 0; k < BALANCE_SIZE; ++k) to[k] = 0.0;
    for (int i = 0; i < past->count; ++i) {
        double weight = 1.0;
        for (int j = 0; j < past->count; ++j)
            if (j != i) weight *= (theta - past->theta[j]) / (past->theta[i] - past->theta[j]);
        for (int k = 0; k < BALANCE_SIZE; ++k) to[k] += weight * past->lean[i][k];
    }
}

/* Between orientations closer than NEIGHBOURS differences are the corrections' digits: the new one
   takes the place of such. */
static void remember(Past *past, double theta, const double *lean) {
    const Past before = *past;
    past->count = 0;
    for (int i = -1; i < before.count && past->count < REMEMBERED; ++i) {
        if (i >= 0 && fabs(before.theta[i] - theta) <= NEIGHBOURS) continue;
        past->theta[past->count] = i < 0 ? theta : before.theta[i];
        memcpy(past->lean[past->count++], i < 0 ? lean : before.lean[i], sizeof before.lean[0]);
    }
}

/* The pressure at an orientation from those at the last ones, or else anew. Not a number where the
   load cannot be balanced. */
static void press_alone(const Pressure *pressure, double theta, Pressed *at) {
    double shape[SHAPE_SIZE];
    shapes_at(pressure, theta, shape);
    int is_settled = 0;
    if (at->past.count) {
        lean_ahead(&at->past, theta, at->pressure);
        bend(at->pressure, shape);
        cut(pressure, at);
        is_settled = settle(pressure, at);
    }
    if (!is_settled) {
        at->past.count = 0;
        if (!begin_balance(pressure, shape, at) || !balance(pressure, at)) {
            forget_pressure(at);
            return;
        }
    }
    remember(&at->past, theta, at->pressure);
}

/* The pressure at an orientation: from the table, corrected where that may be too far off. Not a
   number where the load cannot be balanced. */
static void press(const Pressure *pressure, double theta, Pressed *at) {
    if (at->is_known && at->theta == theta) return;
    if (at->is_alone)
        press_alone(pressure, theta, at);
    else {
        double error = lean_between(pressure, theta, at->pressure);
        cut(pressure, at);
        int is_near = error <= LEAN_SHARE * at->tolerance;
        if (!is_near && !settle(pressure, at) && !balance(pressure, at)) forget_pressure(at);
    }
    at->theta = theta;
    at->is_known = 1;
}

/* The floor's shape at a place, and its derivatives by the place. Beyond the reach it stays what it
   is at the edge. */
static void floor_at(const Pressure *pressure, const double *place, double *shape,
                     double by[SHAPE_SIZE][2]) {
    double away = size_of(place[X], place[Y]), share = 1.0;
    if (away > pressure->field_reach) share = pressure->field_reach / away;
    double x = share * place[X], y = share * place[Y];
    for (int k = 0; k < SHAPE_SIZE; ++k) {
        const double *f = pressure->field + FIELD_SIZE * k;
        shape[k] = pressure->floor[k] + x * (f[FIELD_X] + f[FIELD_XX] * x + f[FIELD_XY] * y)
                   + y * (f[FIELD_Y] + f[FIELD_YY] * y);
        double along_x = f[FIELD_X] + 2.0 * f[FIELD_XX] * x + f[FIELD_XY] * y;
        double along_y = f[FIELD_Y] + f[FIELD_XY] * x + 2.0 * f[FIELD_YY] * y;
        double outward = share < 1.0 ? (along_x * x + along_y * y) / (x * x + y * y) : 0.0;
        by[k][X] = share * (along_x - outward * x);
        by[k][Y] = share * (along_y - outward * y);
    }
}

/* An object where it is: where the floor's shape varies with the place, with that. */
typedef struct {
    Object object;
    Pressed pressed;
    double by[SHAPE_SIZE][2];
} Standing;

static int varies(const Object *object) { return object->pressure.field_reach > 0.0; }

static void stand(const Object *object, const double *place, Standing *standing) {
    standing->object = *object;
    begin_pressed(&standing->pressed, object->tolerance);
    standing->pressed.is_alone = varies(object);
    if (varies(object))
        floor_at(&object->pressure, place, standing->object.pressure.floor, standing->by);
}

/* For drawings and tests: the pressure at an orientation. */
EXPORT void cm_press(const Pressure *pressure, double theta, double *quadratic) {
    Pressed at;
    begin_pressed(&at, 0.0);
    press(pressure, theta, &at);
    memcpy(quadratic, at.pressure, sizeof at.pressure);
}
