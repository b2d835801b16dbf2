/* Runge-Kutta steps of a motion, and how their ends vary.

   All stages of a step are solved by a Newton iteration each: from the tangent at its start and
   what earlier stages bend off it; a second one where the first corrects much. The last corrections
   tell whether they converged; where they did not, the step is made again from there, or stage by
   stage until certain. */

/* A step counts when what Newton's last correction leaves, about its square, is off by this share
   of its tolerance over its length. It is made again this often at most, and as long as corrections
   become that much smaller each time. */
static const double LEFT_OVER = 0.05, HOPELESS = 0.3;
enum { AGAIN = 3 };
/* The share of the rough estimate (generate.py) that counts, and the bounds of the next step's
   length. */
static const double LEAST_SHARE = 0.3, SAFETY = 0.8, SHRINK = 0.2, GROW = 4.0;
/* Steps no longer than this are taken even where a margin is broken on them. */
static const double LEAST_ADVANCE = 1e-9;
/* Of states and parameters, where a support point stands still. */
static const double DIFFERENCE = 1e-6;
/* Corrections, about whose square unknowns are off afterwards, that leave nothing to correct. */
static const double SOLVED = 1e-7;
/* Unknowns in the middle of a step that a Newton iteration corrects by more than this are solved
   first. */
static const double UNSOLVED_MIDDLE = 1e-5;

typedef struct {
    double h, error, correction, rows[STAGES + 1][ROW];
} Step;

/* Derivatives by `count` parameters, by columns: of the state; and of the motion's own SOURCES
   (rows) by each of them (columns). */
struct Variation {
    int count;
    double state[STATE_SIZE * MOST_VARIED], source[SOURCES][MOST_VARIED];
};
typedef struct Variation Variation;
/* Columns of derivatives of the rates: by the state, then by what comes after it. */
enum { BY_STATE = STATE_SIZE * STATE_SIZE, RATES = STATE_SIZE * (STATE_SIZE + MOST_VARIED) };

/* Derivatives of a motion's rates at a row (by columns: by the state and all SOURCES, or the
   first); of its unknowns by the state; returns what a Newton iteration would correct of these. */
static double slopes_at(Stroke *r, const Motion *m, const double *state, const double *z, int all,
                        double *by, double *toward) {
    Begun b;
    double friction[FRICTION_SIZE], by_law[3 * WRENCH], by_turning[WRENCH];
    double by_pressure[WRENCH * OF_PRESSURE] = {0.0};
    double correction;
    double plain[UNKNOWN_SIZE];
    memcpy(plain, z, sizeof plain);
    if (m->watched >= 0)
        friction_watched(r, m, state, all, plain, &b, friction, by_law, by_turning, by_pressure);
    else {
        begin(r, m, state, z, &b);
        friction_on(r, state, &b, &r->is_far, 0, friction);
        friction_varies(r, &b, all, 0, by_law, by_turning, by_pressure);
    }
    const double *given[] = {state, m->p, plain, friction, by_law, by_turning, by_pressure};
    double *results[] = {by, toward, &correction};
    (all ? ALL_SLOPES : SLOPES)[kind_of(r, m)][law_of(m)](given, results, 0, 0, 0);
    return correction;
}

/* The same of the rates alone, by differences: where a support point stands still. */
static int slopes_by_differences(Stroke *r, const Motion *m, const double *row, int sources,
                                 double *slopes) {
    for (int j = 0; j < STATE_SIZE + (sources < VARIED ? sources : VARIED); ++j)
        for (int side = -1; side <= 1; side += 2) {
            Motion moved = *m;
            double state[] = {row[THETA], row[COORDINATE]}, found[ROW], report[REPORT];
            memcpy(moved.z, row + UNKNOWN, sizeof moved.z);
            double *at = j < STATE_SIZE ? state + j : moved.p + VARIED_AT[j - STATE_SIZE];
            *at += side * DIFFERENCE;
            face(&moved);
            if (evaluate(r, &moved, state, found, report) < 0) return UNSOLVED;
            for (int c = 0; c < STATE_SIZE; ++c)
                slopes[STATE_SIZE * j + c] += side * found[SLOPE + c] / (2.0 * DIFFERENCE);
        }
    return 1;
}

/* Derivatives of the unknowns by the state at a row where a point is watched, by how Newton's
   method corrects them beside it. */
static void tangents_aside(Stroke *r, const Motion *m, const double *row, double *toward) {
    int n = unknowns(m), moves = place_of(m) == AT_OUTLINE ? STATE_SIZE : 1;
    double beside[ROW], report[REPORT];
    memset(toward, 0, UNKNOWN_SIZE * STATE_SIZE * sizeof(double));
    for (int j = 0; j < moves && !m->rests; ++j) {
        double state[STATE_SIZE] = {row[THETA], row[COORDINATE]};
        state[j] += ASIDE;
        iterate(r, m, state, row + UNKNOWN, beside, report);
        for (int k = 0; k < n; ++k)
            toward[n * j + k] = (beside[UNKNOWN + k] - row[UNKNOWN + k]) / ASIDE;
    }
}

/* Where stage i of a step lies. */
static void place_stage(const Step *taken, const double *state, double h, int i, double *at) {
    for (int k = 0; k < STATE_SIZE; ++k) {
        at[k] = state[k];
        for (int j = 0; j < i; ++j)
            at[k] += h * (i < STAGES ? A[i][j] : B[j]) * taken->rows[j][SLOPE + k];
    }
}

static void estimate_error(Step *taken, double h) {
    taken->h = h;
    taken->error = 0.0;
    for (int k = 0; k < STATE_SIZE; ++k) {
        double error = 0.0, rough = 0.0;
        for (int i = 0; i <= STAGES; ++i) {
            error += ERROR[i] * taken->rows[i][SLOPE + k];
            rough += ROUGH[i] * taken->rows[i][SLOPE + k];
        }
        error = h * fabs(error);
        rough = LEAST_SHARE * h * h * fabs(rough);
        /* what is no number stays, whatever comes after it */
        if (isnan(error) || isnan(rough)) taken->error = NAN;
        if (error > taken->error) taken->error = error;
        if (rough > taken->error) taken->error = rough;
    }
}

/* A step from a row with its contacts corrected once a stage; whether they count as solved. again:
   from the unknowns it has. */
static int certified(Stroke *r, Motion *m, int again, const double *start, double h, Step *taken) {
    int n = unknowns(m);
    double bend[STAGES + 1][UNKNOWN_SIZE], at[STATE_SIZE], z[UNKNOWN_SIZE], report[REPORT];
    double correction = 0.0, tolerance = r->object->tolerance;
    /* around a corner a slip turns the contact the faster the thinner the rod */
    double slow = kind_of(r, m) == KIND_CORNER ? fmin(r->object->radius, 1.0) : 1.0;
    double allowed = sqrt(LEFT_OVER * tolerance * slow / h);
    /* the tangent at the start is kept: a step that is too long starts again there */
    double by[BY_STATE + STATE_SIZE];
    if (!m->has_tangent && m->watched >= 0)
        tangents_aside(r, m, start, m->toward);
    else if (!m->has_tangent)
        slopes_at(r, m, start, start + UNKNOWN, 0, by, m->toward);
    m->has_tangent = 1;
    memcpy(taken->rows[0], start, sizeof taken->rows[0]);
    for (int i = 1; i <= STAGES; ++i) {
        double *row = taken->rows[i], tangent[UNKNOWN_SIZE];
        place_stage(taken, start, h, i, at);
        if (again)
            memcpy(z, row + UNKNOWN, sizeof z);
        else {
            for (int k = 0; k < n; ++k) {
                const double *toward = m->toward + k;
                tangent[k] = start[UNKNOWN + k] + toward[n * THETA] * (at[THETA] - start[THETA])
                             + toward[n * COORDINATE] * (at[COORDINATE] - start[COORDINATE]);
                z[k] = tangent[k];
                for (int j = 1; j < i; ++j) z[k] += BEND[i][j] * bend[j][k];
            }
        }
        iterate(r, m, at, z, row, report);
        /* the next step begins with the end: its balance is what is looked at */
        if (!(report[CORRECTION] <= (i == STAGES ? SOLVED : allowed))) {
            memcpy(z, row + UNKNOWN, sizeof z);
            iterate(r, m, at, z, row, report);
        }
        if (!again)
            for (int k = 0; k < n; ++k) bend[i][k] = row[UNKNOWN + k] - tangent[k];
        taken->correction = goes_around(m, start, row) ? NAN : report[CORRECTION];
        if (!isfinite(taken->correction)) return 0;
        correction = fmax(correction, report[CORRECTION]);
    }
    estimate_error(taken, h);
    taken->correction = correction;
    return isfinite(taken->error) && correction <= allowed;
}

/* A step stage by stage. */
static int sure_step(Stroke *r, Motion *m, const double *start, double h, Step *taken) {
    memcpy(taken->rows[0], start, sizeof taken->rows[0]);
    for (int i = 1; i <= STAGES; ++i) {
        double at[STATE_SIZE], report[REPORT];
        place_stage(taken, start, h, i, at);
        int found = evaluate(r, m, at, taken->rows[i], report);
        if (found < 0) return found;
    }
    estimate_error(taken, h);
    return 1;
}

/* A step of length h from a row: 1; 0 where a shorter one is called for; or why there is none.
   fast: certified or not at all. */
static int attempt(Stroke *r, Motion *m, const double *start, double h, int fast, Step *taken) {
    double z[UNKNOWN_SIZE];
    memcpy(z, m->z, sizeof z);
    if (is_held(m)) return sure_step(r, m, start, h, taken);
    double before = INFINITY;
    for (int k = 0; k <= AGAIN && (k == 0 || taken->correction < HOPELESS * before); ++k) {
        before = k ? taken->correction : INFINITY;
        if (certified(r, m, k > 0, start, h, taken)) return 1;
    }
    if (fast) return 0;
    int found = sure_step(r, m, start, h, taken);
    if (found == 1 || h <= LEAST_ADVANCE) return found;
    memcpy(m->z, z, sizeof z);
    return 0;
}

/* The length at which the error should just meet the tolerance; to eight binary digits, downwards:
   else it would follow the rounding of an error that is itself a difference. */
static double next_length(double h, double error, double tolerance) {
    int exponent;
    if (!isfinite(error)) return h * SHRINK;
    double factor = SAFETY * pow(tolerance / fmax(error, 1e-300), 1.0 / ORDER);
    double mantissa = frexp(h * fmin(GROW, fmax(SHRINK, factor)), &exponent);
    return ldexp(floor(256.0 * mantissa), exponent - 8);
}

/* Derivatives of the rates at a row that a variation needs (2, 2 + count): by the state, and by its
   parameters. */
static int rates_vary(Stroke *r, Motion *m, double *row, int is_middle, double *by) {
    double slopes[STATE_SIZE * (STATE_SIZE + SOURCES)] = {0.0}, report[REPORT];
    double other[UNKNOWN_SIZE * STATE_SIZE], *toward = is_middle ? other : m->toward;
    const Variation *v = r->varied;
    int all = v->count > 1 || varies(r->object), sources = all ? SOURCES : 1;
    memset(by, 0, STATE_SIZE * (STATE_SIZE + v->count) * sizeof(double));
    if (is_held(m)) return 1;
    Motion with = *m;
    /* a ring without friction is differentiated by it in the sense in which the object turns */
    if (all && m->mode == RING) with.mode = row[SLOPE] < 0.0 ? RING_RIGHT : RING_LEFT;
    double correction = 0.0;
    if (!m->rests) correction = slopes_at(r, &with, row, row + UNKNOWN, all, slopes, toward);
    m->has_tangent = !is_middle && with.mode == m->mode && m->watched < 0;
    int is_poor = is_middle && !(correction <= UNSOLVED_MIDDLE);
    if ((m->watched < 0 && is_kinked(r, m, row)) || is_poor) {
        double before[ROW];
        memcpy(before, row, sizeof before);
        memcpy(m->z, row + UNKNOWN, sizeof m->z);
        if (evaluate(r, m, row, row, report) < 0) {
            if (m->watched < 0) return UNSOLVED;
            /* polar unknowns may not serve in the middle of a step: plain ones do, from where the
               stages have it, not from where the others went astray */
            unwatch(r, m, before);
            return rates_vary(r, m, before, is_middle, by);
        }
        slopes_at(r, &with, row, row + UNKNOWN, all, slopes, toward);
    }
    if (m->rests || (m->watched < 0 && is_kinked(r, m, row))) {
        memset(slopes, 0, sizeof slopes);
        if (slopes_by_differences(r, m, row, sources, slopes) < 0) return UNSOLVED;
    }
    memcpy(by, slopes, BY_STATE * sizeof(double));
    for (int j = 0; j < sources; ++j) {
        double sense = j == SOURCE_SMU && SIGN[with.mode] < 0.0 ? -1.0 : 1.0;
        for (int k = 0; k < v->count; ++k)
            for (int c = 0; c < STATE_SIZE; ++c)
                by[BY_STATE + STATE_SIZE * k + c] +=
                    sense * slopes[BY_STATE + STATE_SIZE * j + c] * v->source[j][k];
    }
    return 1;
}

/* The middle of a step, as far as its stages tell. */
static void middle_of(const Step *taken, double *row) {
    memset(row, 0, ROW * sizeof(double));
    memcpy(row, taken->rows, STATE_SIZE * sizeof(double));
    for (int i = 0; i <= STAGES; ++i) {
        const double *stage = taken->rows[i];
        for (int c = 0; c < STATE_SIZE; ++c) {
            row[c] += taken->h * MIDDLE_STATE[i] * stage[SLOPE + c];
            row[SLOPE + c] += MIDDLE_VALUE[i] * stage[SLOPE + c];
        }
        for (int k = 0; k < UNKNOWN_SIZE; ++k)
            row[UNKNOWN + k] += MIDDLE_VALUE[i] * stage[UNKNOWN + k];
    }
}

/* Carries the variation over a step: of v' = J v + g, v1 = v0 + h/6 (f0 + 4 fm + f1), vm = (v0 +
   v1)/2 + h/8 (f0 - f1), solved for v1 (Lobatto's method IIIA of order 4; Hairer & Wanner 1996,
   IV.5). */
static int vary_step(Stroke *r, Motion *m, const Step *taken) {
    Variation *v = r->varied;
    double row[ROW], start[RATES], mid[RATES], end[RATES], h = taken->h;
    Motion between = *m;
    size_t size = STATE_SIZE * (STATE_SIZE + v->count) * sizeof(double);
    if (m->has_reached)
        memcpy(start, m->reached, size);
    else {
        memcpy(row, taken->rows[0], sizeof row);
        if (rates_vary(r, &between, row, 0, start) < 0) return UNSOLVED;
    }
    middle_of(taken, row);
    if (rates_vary(r, &between, row, 1, mid) < 0) return UNSOLVED;
    memcpy(row, taken->rows[STAGES], sizeof row);
    if (rates_vary(r, m, row, 0, end) < 0) return UNSOLVED;
    memcpy(m->reached, end, size);
    m->has_reached = 1;
    double own[STATE_SIZE][STATE_SIZE];
    for (int c = 0; c < STATE_SIZE; ++c)
        for (int k = 0; k < STATE_SIZE; ++k) {
            own[c][k] =
                (c == k) - h / 6.0 * (end[STATE_SIZE * k + c] + 2.0 * mid[STATE_SIZE * k + c]);
            for (int j = 0; j < STATE_SIZE; ++j)
                own[c][k] += h * h / 12.0 * mid[STATE_SIZE * j + c] * end[STATE_SIZE * k + j];
        }
    const double *first = own[THETA], *second = own[COORDINATE];
    double whole = first[THETA] * second[COORDINATE] - first[COORDINATE] * second[THETA];
    for (int i = 0; i < v->count; ++i) {
        double *w = v->state + STATE_SIZE * i, rest[STATE_SIZE], at_start[STATE_SIZE];
        const double *sooner = start + BY_STATE + STATE_SIZE * i;
        const double *given = mid + BY_STATE + STATE_SIZE * i;
        const double *later = end + BY_STATE + STATE_SIZE * i;
        for (int c = 0; c < STATE_SIZE; ++c)
            at_start[c] = start[STATE_SIZE * THETA + c] * w[THETA]
                          + start[STATE_SIZE * COORDINATE + c] * w[COORDINATE] + sooner[c];
        for (int c = 0; c < STATE_SIZE; ++c) {
            rest[c] = w[c] + h / 6.0 * (at_start[c] + 4.0 * given[c] + later[c]);
            for (int k = 0; k < STATE_SIZE; ++k)
                rest[c] += h * mid[STATE_SIZE * k + c]
                           * (w[k] / 3.0 + h / 12.0 * (at_start[k] - later[k]));
        }
        w[THETA] =
            (rest[THETA] * second[COORDINATE] - first[COORDINATE] * rest[COORDINATE]) / whole;
        w[COORDINATE] = (first[THETA] * rest[COORDINATE] - second[THETA] * rest[THETA]) / whole;
    }
    return 1;
}
