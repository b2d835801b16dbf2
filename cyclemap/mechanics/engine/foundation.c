/* The contact of a foundation that is pressed: p = max(0, P), P = c + l . x + q, q a quadratic of
   the plate's shape and, turned against it, the floor's; c and l by the balance of load and moment.
   Places x are off the outline's centroid, P is per unit load.

   The contact, where P > 0, is bounded by stretches of the outline and by arcs of the conic P = 0,
   which are rational curves. Friction is summed over this boundary in cones.c. */

/* Loads, of one, that may lack: aimed at, and at the most. */
static const double BALANCED = 1e-13, NEARLY_BALANCED = 1e-11;
enum { MOST_CORRECTIONS = 200 };
/* Steps are halved down to this share. */
static const double SHORTEST_STEP = 1e-6;
/* Of a motion's tolerance: what the table, or a last correction's square, may be off by. */
static const double LEAN_SHARE = 0.1;
/* A correction by less leaves nothing, whatever the tolerance. */
static const double WELL_CORRECTED = 3e-8;
enum { MOST_REPEATS = 3 };
/* rad: nearer to each other two balances tell no slope. */
static const double NEIGHBOURS = 1e-4;
/* The classes of digits serve motions of tolerances above these. */
static const double ABOVE[] = {1e-7, 1e-8, 2e-11, -INFINITY};

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
    Stretches stretches;
    stretches.count = stretches.curve_count = 0;
    for (int i = 0; i < at->arcs.count; ++i)
        put_stretches(&stretches, &at->arcs, i, arc_rule(at->arcs.of[CURVE_WEIGHT][i], at->digits));
    for (int i = 0; i < stretches.count; ++i) {
        const Curve *curve = stretches.curves + stretches.of[i].curve;
        Shares of = shares_at(curve->weight, stretches.of[i].node);
        Wide x = of.down * place_on(curve, &of, X), y = of.down * place_on(curve, &of, Y);
        add_monomials(m, x, y, cone_on(curve, &of));
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

/* Corrects the pressure in few steps; whether the last one was so short that its square does not
   count. */
static int settle(const Pressure *pressure, Pressed *at) {
    double enough = fmax(sqrt(LEAN_SHARE * at->tolerance), WELL_CORRECTED);
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
