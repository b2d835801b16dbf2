/* Runge-Kutta steps of a motion, their errors and lengths: runge_kutta.py and motion.py in C. */

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
        error = h * fabs(error);
        rough = LEAST_SHARE * h * h * fabs(rough);
        /* what is no number stays, whatever comes after it */
        if (isnan(error) || isnan(rough)) taken->error = NAN;
        if (error > taken->error) taken->error = error;
        if (rough > taken->error) taken->error = rough;
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

/* motion_functions.step_function and motion._StepCall: 1 taken, 0 not certified, -1 not in its regime. `again`: from
   the unknowns of all rows. */
static int certified(Motion *m, int again, const double *state, double h, double tolerance, Step *taken) {
    int n = m->law->unknowns;
    double bend[STAGES + 1][2], tangent[2], at[2], z[2], report[4];
    double correction = 0.0, nearest = INFINITY, farthest = 0.0;
    double allowed = SMOOTH ? sqrt(LEFT_OVER * tolerance / h) : LEFT_AT_POINTS * tolerance;
    for (int i = 0; i <= STAGES; ++i) {
        double *row = taken->rows[i];
        place(taken, state, h, i, at);
        if (again) memcpy(z, row + UNKNOWN, n * sizeof(double));
        else if (i) predict(m, m->tangent.toward, bend, taken, at, i, tangent, z);
        else settle(m, state, m->z, tangent_at(m, m->regime, state, m->z)->found, row, report);
        for (int iteration = 0; (i || again) && iteration < ITERATIONS[i]; ++iteration) {
            stage(m, m->regime, at, z, row, report);
            memcpy(z, row + UNKNOWN, n * sizeof(double));
        }
        for (int k = 0; i && k < n; ++k) bend[i][k] = z[k] - tangent[k];
        correction = fmax(correction, report[0]);
        nearest = fmin(nearest, report[1]);
        farthest = fmax(farthest, report[1]);
        if (!(m->regime ? nearest >= FAR_LIMIT : farthest <= NEAR_LIMIT)) return -1;
    }
    finish(taken, h);
    return isfinite(taken->error) && correction <= allowed;
}

/* Motion.fast_step */
static int fast_step(Motion *m, const double *state, double h, double tolerance, Step *taken) {
    int found = certified(m, 0, state, h, tolerance, taken);
    if (found < 0) {
        m->regime = !m->regime;
        found = certified(m, 0, state, h, tolerance, taken);
    }
    for (int k = 0; found == 0 && k < AGAIN; ++k) found = certified(m, 1, state, h, tolerance, taken);
    return found > 0;
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
    int exponent;
    if (!isfinite(error)) return h * SHRINK;
    double factor = SAFETY * pow(tolerance / fmax(error, 1e-300), 1.0 / ORDER);
    double mantissa = frexp(h * fmin(GROW, fmax(SHRINK, factor)), &exponent);
    return ldexp(floor(256.0 * mantissa), exponent - 8);
}
