/* The boundary of the contact under a pressure P that is known: where P changes its sign along the
   outline, and the arcs of P = 0 inside of it, joined from there. */

enum { MOST_PLACES = 64 };
/* An arc of an ellipse's rim goes no farther around it. */
static const double WIDEST_RIM = 1.6;
/* Steps along the rim that are this short and no longer shrink are rounding's. */
static const double ROUNDED = 1e-13;
/* Conics that bend by less than this share of their slope are taken for straight where their arcs
   are sorted. */
static const double STRAIGHT = 1e-9;

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
        double arc[CURVE_SIZE] = {
            [CURVE_START_X] = semi[X] * x,
            [CURVE_START_Y] = semi[Y] * y,
            [CURVE_MIDDLE_X] = semi[X] * middle_x / c,
            [CURVE_MIDDLE_Y] = semi[Y] * middle_y / c,
            [CURVE_WEIGHT] = c,
        };
        x = c * middle_x - s * middle_y;
        y = c * middle_y + s * middle_x;
        arc[CURVE_END_X] = semi[X] * x;
        arc[CURVE_END_Y] = semi[Y] * y;
        put_arc(&at->arcs, arc);
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

/* Where the conic goes from one branch to the other, inside the outline; and of an ellipse its half
   width along v, of which arcs may span this much without being parted. */
static const double WIDEST_ARC = 1.8;
static int turns_of(const Pressure *pressure, const Conic *k, Place *turns, double *width) {
    double square = -4.0 * k->a * k->d, linear = -4.0 * k->a * k->e;
    double level = k->b * k->b - 4.0 * k->a * k->c, inside = linear * linear - 4.0 * square * level;
    if (!(inside > 0.0)) return 0;
    double down = -0.5 * (linear + copysign(sqrt(inside), linear));
    const double at[] = {level / down, down / square};
    int count = 0;
    if (k->a * k->d > 0.0) *width = 0.5 * fabs(at[1] - at[0]);
    for (int i = 0; i < 2; ++i) {
        place_at(k, -k->b / (2.0 * k->a), at[i], turns + count);
        if (is_inside(pressure, turns[count].at[X], turns[count].at[Y])) ++count;
    }
    return count;
}

static void put_ends(Pressed *at, const Place *from, const Place *to) {
    const double arc[CURVE_SIZE] = {
        [CURVE_START_X] = from->at[X],
        [CURVE_START_Y] = from->at[Y],
        [CURVE_END_X] = to->at[X],
        [CURVE_END_Y] = to->at[Y],
    };
    put_arc(&at->arcs, arc);
}

/* The arcs between the places of one branch, on which P > 0 on the left; u grows with P where
   `side` is 1, so that v falls along it there, and grows on the other. */
static void add_branch(const Pressure *pressure, Pressed *at, const Conic *k, double side,
                       double width, const Places *branch) {
    int is_hyperbola = k->a * k->d < 0.0;
    for (int i = 0; i + 1 < branch->count; ++i) {
        const Place *low = branch->of + i, *high = low + 1;
        /* a hyperbola has nothing between its own two branches */
        if (is_hyperbola && low->kind == IS_INNER && high->kind == IS_INNER) continue;
        const Place *from = side > 0.0 ? high : low, *to = side > 0.0 ? low : high;
        int is_begun = from->kind != IS_END, is_ended = to->kind != IS_START;
        if (is_begun != is_ended) {
            /* places so close that rounding has them in another order */
            Place middle;
            double v = 0.5 * (low->v + high->v);
            place_at(k, branch_at(k, v, side), v, &middle);
            is_begun = is_inside(pressure, middle.at[X], middle.at[Y]);
        }
        if (!is_begun || !(high->v > low->v)) continue;
        double halfway = -k->e / (2.0 * k->d);
        if (high->v - low->v > WIDEST_ARC * width && low->v < halfway && halfway < high->v) {
            Place middle;
            place_at(k, branch_at(k, halfway, side), halfway, &middle);
            put_ends(at, from, &middle);
            put_ends(at, &middle, to);
        } else
            put_ends(at, from, to);
    }
}

/* The arcs of P = 0 inside the outline, from its crossings of it and from where it turns. */
static void cut_inside(const Pressure *pressure, Pressed *at, const Places *crossings) {
    Conic k = conic_of(at->pressure);
    /* what does not cross the outline is closed, an ellipse */
    if (!crossings->count && !(k.a * k.d > 0.0)) return;
    Place turns[2];
    double width = INFINITY;
    int turn_count = turns_of(pressure, &k, turns, &width);
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
        sort_places(&branch);
        add_branch(pressure, at, &k, side, width, &branch);
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
    at->has_moments = at->has_slopes = at->side_count = at->arcs.count = 0;
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
    int rim_count = at->arcs.count;
    if (has_room) cut_inside(pressure, at, &crossings);
    if (at->arcs.count <= MOST_ARCS) bend_arcs(at, rim_count);
    halve_arcs(&at->arcs, rim_count);
    if (at->side_count > MOST_SIDES || at->arcs.count > MOST_ARCS) has_room = 0;
    if (!has_room) {
        at->side_count = at->arcs.count = 0;
        forget_pressure(at);
    }
    for (int k = 0; k < EDGE_SIZE; ++k)
        for (int i = 0; i < WIDTH; ++i) at->sides[k][at->side_count + i] = at->sides[k][0];
    return has_room;
}
