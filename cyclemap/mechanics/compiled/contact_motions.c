/* Whole strokes below Python. Steps and contacts are the CasADi functions in the tables; these files only do with them
   what motion.py, contact_solver.py, event_integration.py and push_run.py do, under the same names. What is rare (an
   iteration that does not converge, ends of a push that are refused) is declined, and left to them.

   Here: a motion, and one evaluation of it. */

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

/* Derivatives of the unknowns by theta, coordinate and direction, by columns, and what the solver finds, at a place
   (state and unknowns); far: the regime, -1 for none yet. */
typedef struct { int far; double place[4], toward[6], found[7]; } Tangent;

typedef struct {
    const Law *law;
    int mode, piece, regime;
    double p[PARAMETERS], z[2];
    Tangent tangent; /* the last one: a step starts where the one before it ended, as does one that was too long */
    int is_varied;   /* whether the end of a step before is known, with how its slope varies: */
    double reached[6];
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
    Motion m = {&LAWS[(int)at[KIND]][SLIDE_LEFT <= mode && mode <= SLIDE_FREE], mode, piece, 0, {0}, {z0, z1}, {-1}, 0, {0}};
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

/* The tangent of the unknowns at a place, and what the solver finds there. */
static const Tangent *tangent_at(Motion *m, int far, const double *state, const double *z) {
    Tangent *t = &m->tangent;
    double q[EQUATION_ARGUMENTS], tangent[10], chain[15];
    int n = m->law->unknowns;
    const double place[] = {state[0], state[1], z[0], n == 2 ? z[1] : 0.0};
    if (t->far == far && memcmp(t->place, place, sizeof place) == 0) return t;
    t->far = far;
    memcpy(t->place, place, sizeof place);
    equation_arguments(m, state, q);
    call(m->law->tangent[far], z, q, 0, 0, tangent, t->found);
    call(m->law->chain, state, m->p, 0, 0, chain, 0);
    memset(t->toward, 0, sizeof t->toward);
    for (int column = 0; column < 3; ++column)
        for (int k = 0; k < n; ++k)
            for (int j = 0; j < 5; ++j) t->toward[column * n + k] += tangent[j * n + k] * chain[column * 5 + j];
    return t;
}

/* motion_functions.variation_function: derivatives of the slope (2, 3), by columns, in the regime that is accurate. */
static const Tangent *variation(Motion *m, const double *state, const double *z, double *by) {
    int n = m->law->unknowns, far = m->regime;
    const Tangent *t = tangent_at(m, far, state, z);
    if (far != !(t->found[2 * n + 2] <= FAR_RATIO)) t = tangent_at(m, !far, state, z);
    double by_unknowns[4];
    call(m->law->rate_slopes, state, z, m->p, 0, by, by_unknowns);
    for (int column = 0; column < 3; ++column)
        for (int k = 0; k < n; ++k)
            for (int c = 0; c < 2; ++c) by[column * 2 + c] += by_unknowns[k * 2 + c] * t->toward[column * n + k];
    return t;
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
