/* Runs whole strokes below Python. Steps and contacts are the CasADi functions in the tables; this only does with them
   what event_integration.py, push_run.py, motion.py and contact_solver.py do, under the same names. What is rare (an
   iteration that does not converge, ends of a push that are refused) is declined, and left to them. */

enum { STICK, SLIDE_LEFT, SLIDE_RIGHT, SLIDE_FREE, RING, RING_LEFT, RING_RIGHT, RING_STUCK };
enum { APPROACH, AFTER_LOW, BEFORE_HIGH, FIRST, SECOND, MARGINS };
enum { NOTHING = -1, DECLINED = -2 };
enum { STATE = 0, SLOPE = 2, MARGIN = 4, UNKNOWN = 9, ROW = 11 };

/* Columns of the arrays that Python passes: pieces, strokes to run, results, phases. */
enum { KIND, GEOMETRY, LOW = 6, HIGH, PIECE_COLUMNS };
enum { AT_PIECE, AT_COORDINATE, AT_THETA, AT_LENGTH, AT_VARIED, AT_PARAMETERS = 7, STROKE_COLUMNS = 18 };
enum { IS_DONE, END_STATE, END_PIECE = 3, TRAVEL, LEFT, END_VARIED, END_SLOPE = 8, PHASES = 10, RESULT_COLUMNS };
enum { PHASE_MODE, PHASE_PIECE, PHASE_BROKEN, PHASE_NEXT, PHASE_STEPS, PHASE_START, PHASE_COLUMNS = 7 };

typedef struct { double h, error, rows[STAGES + 1][ROW]; } Step;
typedef struct { long most_steps, most_phases, steps, phases; Step *step; double (*phase)[PHASE_COLUMNS]; } Record;

typedef struct {
    const double *pieces, *parameters;
    double tolerance, longest, varied[3]; /* varied: theta, coordinate, direction of the rod */
    long piece_count;
    int vary, is_far[2], pinned; /* pinned: the support point that the object last turned about */
    Record *record;
} Run;

typedef struct {
    const Law *law;
    int mode, piece, regime, quick;
    double p[PARAMETERS], z[2];
} Motion;

static const double SIGN[] = {1.0, 1.0, -1.0, 0.0, 0.0, 1.0, -1.0, 0.0};

static int slides(const Motion *m) { return SLIDE_LEFT <= m->mode && m->mode <= SLIDE_FREE; }

static void call(Function *f, const double *a, const double *b, const double *c, const double *d, double *x, double *y) {
    const double *arguments[ARGUMENTS] = {a, b, c, d};
    double *results[RESULTS] = {x, y}, work[WORK];
    casadi_int integers[INTEGERS];
    f(arguments, results, integers, work, 0);
}

static Motion motion_of(const Run *r, int mode, int piece, double z0, double z1) {
    const double *at = r->pieces + piece * PIECE_COLUMNS;
    Motion m = {&LAWS[(int)at[KIND]][SLIDE_LEFT <= mode && mode <= SLIDE_FREE], mode, piece, 0, 0, {0}, {z0, z1}};
    memcpy(m.p, r->parameters, 11 * sizeof(double));
    memcpy(m.p + 11, at + GEOMETRY, 7 * sizeof(double));
    m.p[2] *= SIGN[mode];
    return m;
}

/* What the contact equations ask for; a contact that sticks is a ring without friction. */
static void equation_arguments(const Motion *m, const double *state, double *q) {
    call(m->law->arguments, state, m->p, 0, 0, q, 0);
    if (m->mode == STICK || m->mode == RING) q[5] = 0.0;
}

/* The motion with what one Newton iteration found: row of ROW; report: correction, far, residual, normal force. */
static void settle(const Motion *m, const double *state, const double *z, const double *found, double *row, double *report) {
    int n = m->law->unknowns;
    memcpy(row, state, 2 * sizeof(double));
    for (int k = 0; k < n; ++k) row[UNKNOWN + k] = z[k] + found[n + k];
    call(m->law->rate, state, row + UNKNOWN, found + 2 * n, m->p, row + SLOPE, row + MARGIN);
    report[0] = n == 1 ? fabs(found[1]) : fmax(fabs(found[2]), fabs(found[3]));
    report[1] = found[2 * n + 2];
    report[2] = (n == 1 ? found[0] : hypot(found[0], found[1])) / sqrt(m->p[3] * m->p[4]);
    report[3] = found[2 * n];
}

/* The motion at its unknowns, with the forces of a contact that no Newton iteration tells. */
static void settle_with(const Motion *m, const double *state, const double *force, double *row, double *report) {
    int n = m->law->unknowns;
    double found[7] = {0.0};
    memcpy(found + 2 * n, force, 2 * sizeof(double));
    settle(m, state, m->z, found, row, report);
}

/* motion_functions.stage_function. */
static void stage(const Motion *m, int far, const double *state, const double *z, double *row, double *report) {
    double q[EQUATION_ARGUMENTS], found[7];
    equation_arguments(m, state, q);
    call(m->law->solver[far], z, q, 0, 0, found, 0);
    settle(m, state, z, found, row, report);
}

/* Derivatives of the unknowns (n, 3) by theta, coordinate and direction, by columns; found: as the solver finds. */
static void tangent_at(const Motion *m, int far, const double *state, const double *z, double *toward, double *found) {
    double q[EQUATION_ARGUMENTS], tangent[10], chain[15];
    int n = m->law->unknowns;
    equation_arguments(m, state, q);
    call(m->law->tangent[far], z, q, 0, 0, tangent, found);
    call(m->law->chain, state, m->p, 0, 0, chain, 0);
    memset(toward, 0, 3 * n * sizeof(double));
    for (int column = 0; column < 3; ++column)
        for (int k = 0; k < n; ++k)
            for (int j = 0; j < 5; ++j) toward[column * n + k] += tangent[j * n + k] * chain[column * 5 + j];
}

/* motion_functions.variation_function: derivatives of the slope (2, 3), by columns; returns far. */
static double variation(const Motion *m, int far, const double *state, const double *z, double *by) {
    double toward[6], found[7], by_unknowns[4];
    int n = m->law->unknowns;
    tangent_at(m, far, state, z, toward, found);
    call(m->law->rate_slopes, state, z, m->p, 0, by, by_unknowns);
    for (int column = 0; column < 3; ++column)
        for (int k = 0; k < n; ++k)
            for (int c = 0; c < 2; ++c) by[column * 2 + c] += by_unknowns[k * 2 + c] * toward[column * n + k];
    return found[2 * n + 2];
}

/* _RegimeSwitch.at: one stage, in the regime that is accurate; returns the residual. */
static double solved_at(Run *r, const Motion *m, const double *state, const double *z, double *row, double *report) {
    int *far = &r->is_far[slides(m)];
    stage(m, *far, state, z, row, report);
    if (*far != !(report[1] <= FAR_RATIO)) {
        *far = !*far;
        stage(m, *far, state, z, row, report);
    }
    return report[2];
}

static int evaluate(Run *r, Motion *m, const double *state, double *row, double *report);
static int remembered(Run *r, Motion *m, const double *state, double *row, double *report);
static int pinned(Run *r, Motion *m, const double *state, double *row, double *report);

/* What a bracket closes on: the spin of a contact that sticks, or the slip of one that slides. */
typedef struct {
    Run *r;
    const Motion *m;
    const double *state;
    double *row, *report, omega, facing, force[2]; /* facing: angle of the outward normal in the world */
} Search;

static double torque(Search *s, double spin) { return solved_at(s->r, s->m, s->state, &spin, s->row, s->report); }

/* ContactSolver._slide_bracketed: the part of the force of a contact that sticks to a rod with this slip. */
static double excess(Search *s, double tau) {
    double speed = hypot(1.0, tau), smu = s->m->p[2];
    Motion stick = motion_of(s->r, STICK, s->m->piece, s->omega / speed, 0.0);
    stick.p[0] = s->facing + M_PI - atan(tau);
    if (!evaluate(s->r, &stick, s->state, s->row, s->report)) return NAN;
    s->omega = stick.z[0] * speed;
    double normal = s->report[3], tangential = (s->row[MARGIN + SECOND] - s->row[MARGIN + FIRST]) / 2.0;
    double turn = atan2(tangential, normal) - atan(smu);
    return fabs(turn) > M_PI / 2.0 ? copysign(hypot(normal, tangential), turn) : tangential - smu * normal;
}

/* The forces of a contact that sticks, as its margins tell them. */
static void forces(const Search *s, double *force) {
    force[0] = s->report[3];
    force[1] = (s->row[MARGIN + SECOND] - s->row[MARGIN + FIRST]) / 2.0;
}

/* contact_solver._bracket and _close, for a function that grows: 1 where it vanishes, 2 where it jumps, and forces of
   both sides are mixed; 0 where there is no bracket. */
static int vanishes(double (*of)(Search *, double), Search *s, double start, double scale, double *at) {
    double width = 0.1 * (1.0 + fabs(start)), value = of(s, start), bound[2], side[2], force[2][2];
    int up = value <= 0.0, tries = 0;
    bound[!up] = start;
    side[!up] = value;
    forces(s, force[!up]);
    for (; tries < 60; ++tries, width *= 2.0) {
        bound[up] = bound[!up] + (up ? width : -width);
        side[up] = of(s, bound[up]);
        forces(s, force[up]);
        if (up ? side[up] >= 0.0 : side[up] <= 0.0) break;
        bound[!up] = bound[up];
        side[!up] = side[up];
        memcpy(force[!up], force[up], sizeof force[up]);
    }
    if (tries == 60) return 0;
    for (int i = 0; i < 200; ++i) {
        double rise = side[1] - side[0], secant = bound[0] - side[0] * (bound[1] - bound[0]) / rise;
        *at = (bound[0] + bound[1]) / 2.0;
        if (rise > 0.0 && i % 3 && bound[0] < secant && secant < bound[1]) *at = secant;
        value = of(s, *at);
        if (fabs(value) <= FOUND * scale) return 1;
        if (!isfinite(value)) return 0;
        if (bound[1] - bound[0] <= 1e-15 * fmax(fmax(fabs(bound[0]), fabs(bound[1])), 1e-3)) break;
        bound[value >= 0.0] = *at;
        side[value >= 0.0] = value;
        forces(s, force[value >= 0.0]);
    }
    double share = side[1] != side[0] ? side[0] / (side[0] - side[1]) : 0.5;
    *at = (bound[0] + bound[1]) / 2.0;
    for (int k = 0; k < 2; ++k) s->force[k] = (1.0 - share) * force[0][k] + share * force[1][k];
    return 2;
}

static int bracketed(Run *r, Motion *m, const double *state, double *row, double *report) {
    Search s = {r, m, state, row, report, m->z[0], 0.0, {0.0}};
    int closed;
    if (!slides(m)) {
        closed = vanishes(torque, &s, isfinite(m->z[0]) ? m->z[0] : 0.0, 1.0, m->z);
        if (closed == 2) settle_with(m, state, s.force, row, report);
        return closed;
    }
    if (POINT_COUNT && pinned(r, m, state, row, report)) return 1;
    double touch[3];
    call(TOUCH[(int)r->pieces[m->piece * PIECE_COLUMNS]], state, m->p, 0, 0, touch, 0);
    s.facing = m->p[0] + atan2(-touch[1], -touch[0]);
    closed = vanishes(excess, &s, m->z[1], sqrt(m->p[3] * m->p[4]), &m->z[1]);
    m->z[0] = s.omega;
    if (closed == 2) settle_with(m, state, s.force, row, report);
    return closed == 1 ? fabs(solved_at(r, m, state, m->z, row, report)) <= ACCEPTED : closed;
}

/* Motion.evaluate: solved until certain; 0 where that is not reached. */
static int evaluate(Run *r, Motion *m, const double *state, double *row, double *report) {
    double best = INFINITY, nearest[2] = {m->z[0], m->z[1]};
    if (remembered(r, m, state, row, report)) return 1;
    for (int i = 0;; ++i) {
        double residual = fabs(solved_at(r, m, state, m->z, row, report));
        if (residual <= FOUND && (!slides(m) || report[3] > 0.0)) break;
        if (i == 11 || !(residual < 0.7 * best)) {
            if (slides(m)) memcpy(m->z, nearest, sizeof nearest);
            if (!bracketed(r, m, state, row, report)) return 0;
            break;
        }
        best = residual;
        memcpy(nearest, m->z, sizeof nearest);
        memcpy(m->z, row + UNKNOWN, m->law->unknowns * sizeof(double));
    }
    memcpy(m->z, row + UNKNOWN, m->law->unknowns * sizeof(double));
    return 1;
}

/* Where stage i of a step lies. */
static void place(const Step *taken, const double *state, double h, int i, double *at) {
    for (int k = 0; k < 2; ++k) {
        at[k] = state[k];
        for (int j = 0; j < i; ++j) at[k] += h * (i < STAGES ? A[i][j] : B[j]) * taken->rows[j][SLOPE + k];
    }
}

static void finish(Step *taken, double h) {
    taken->h = h;
    taken->error = 0.0;
    for (int k = 0; k < 2; ++k) {
        double error = 0.0, rough = 0.0;
        for (int i = 0; i <= STAGES; ++i) {
            error += ERROR[i] * taken->rows[i][SLOPE + k];
            rough += ROUGH[i] * taken->rows[i][SLOPE + k];
        }
        if (!(h * fabs(error) <= taken->error)) taken->error = h * fabs(error);
        if (!(LEAST_SHARE * h * h * fabs(rough) <= taken->error)) taken->error = LEAST_SHARE * h * h * fabs(rough);
    }
}

/* Where Newton's method starts at stage i, motion_functions._Course.predicted: along the tangent from the start, and
   bent; from the nearest stage where friction bends abruptly. */
static void predict(const Motion *m, const double *toward, double (*bend)[2], const Step *taken, const double *at, int i,
                    double *tangent, double *z) {
    int n = m->law->unknowns;
    const double *from = taken->rows[SMOOTH ? 0 : NEAREST_STAGE[i]];
    for (int k = 0; k < n; ++k) {
        tangent[k] = from[UNKNOWN + k] + toward[k] * (at[0] - from[0]) + toward[n + k] * (at[1] - from[1]);
        z[k] = tangent[k];
        for (int j = 1; SMOOTH && j < i; ++j) z[k] += BEND[i][j] * bend[j][k];
    }
}

/* motion_functions.step_function and motion._StepCall: 1 taken, 0 not certified, -1 not in its regime. */
static int certified(Motion *m, const int *iterations, const double *state, double h, double tolerance, Step *taken) {
    int n = m->law->unknowns;
    double toward[6], found[7], bend[STAGES + 1][2], tangent[2], at[2], z[2], report[4];
    double correction = 0.0, quick = 0.0, nearest = INFINITY, farthest = 0.0;
    double allowed = SMOOTH ? sqrt(LEFT_OVER * tolerance / h) : LEFT_AT_POINTS * tolerance;
    m->quick = 0;
    for (int i = 0; i <= STAGES; ++i) {
        double *row = taken->rows[i];
        if (i == 0) {
            tangent_at(m, m->regime, state, m->z, toward, found);
            settle(m, state, m->z, found, row, report);
            quick = report[0];
        } else {
            place(taken, state, h, i, at);
            predict(m, toward, bend, taken, at, i, tangent, z);
        }
        for (int iteration = 1; i && iteration <= iterations[i]; ++iteration) {
            stage(m, m->regime, at, z, row, report);
            memcpy(z, row + UNKNOWN, n * sizeof(double));
            if (iteration == ITERATIONS[0][i]) quick = fmax(quick, report[0]);
        }
        for (int k = 0; i && k < n; ++k) bend[i][k] = z[k] - tangent[k];
        correction = fmax(correction, report[0]);
        nearest = fmin(nearest, report[1]);
        farthest = fmax(farthest, report[1]);
        if (!(m->regime ? nearest >= FAR_LIMIT : farthest <= NEAR_LIMIT)) return -1;
    }
    finish(taken, h);
    m->quick = isfinite(taken->error) && quick <= allowed;
    return isfinite(taken->error) && correction <= allowed;
}

/* Motion.fast_step */
static int fast_step(Motion *m, const double *state, double h, double tolerance, Step *taken) {
    for (int effort = !(SMOOTH && m->quick); effort < 2; ++effort) {
        int found = certified(m, ITERATIONS[effort], state, h, tolerance, taken);
        if (found < 0) {
            m->regime = !m->regime;
            found = certified(m, ITERATIONS[effort], state, h, tolerance, taken);
        }
        if (found) return found > 0;
    }
    return 0;
}

/* runge_kutta.step, stage by stage. */
static int sure_step(Run *r, Motion *m, const double *state, double h, Step *taken) {
    for (int i = 0; i <= STAGES; ++i) {
        double at[2], report[4];
        place(taken, state, h, i, at);
        if (!evaluate(r, m, at, taken->rows[i], report)) return DECLINED;
    }
    finish(taken, h);
    return 1;
}

/* event_integration._attempt: 0 where a shorter step is called for. */
static int attempt(Run *r, Motion *m, const double *state, double h, int fast, Step *taken) {
    double z[2] = {m->z[0], m->z[1]};
    if (fast_step(m, state, h, r->tolerance, taken)) return 1;
    if (fast) return 0;
    int found = sure_step(r, m, state, h, taken);
    if (found == 1 || h <= LEAST_ADVANCE) return found;
    memcpy(m->z, z, sizeof z);
    return 0;
}

static double next_length(double h, double error, double tolerance) {
    if (!isfinite(error)) return h * SHRINK;
    return h * fmin(GROW, fmax(SHRINK, SAFETY * pow(tolerance / fmax(error, 1e-300), 0.2)));
}

