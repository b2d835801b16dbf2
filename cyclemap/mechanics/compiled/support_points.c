/* Support points that do not slide, where their friction has a kink: pinned_point.py and phase_variation._kinked in C,
   under the same names. Rows of POINTS: x, y, share of the load; none for patches. */

enum { THETA, DIRECTION_OF_ROD, AT_X, AT_Y, NORMAL, SMU, MU_A, MU_B, M0, N0, PHI };

/* Traction (slider's frame) at a velocity, by the contact equations' arguments. */
static void traction(const double *q, double vx, double vy, double *found) {
    double c = cos(q[PHI] - q[THETA]), s = sin(q[PHI] - q[THETA]);
    double along = c * vx + s * vy, across = c * vy - s * vx, size = hypot(q[MU_A] * along, q[MU_B] * across);
    along = q[M0] + q[MU_A] * q[MU_A] * along / size;
    across = q[N0] + q[MU_B] * q[MU_B] * across / size;
    found[0] = c * along - s * across;
    found[1] = s * along + c * across;
}

/* Whether a traction (slider's frame) lies inside the friction ellipse. */
static int holds(const double *q, double fx, double fy) {
    double c = cos(q[PHI] - q[THETA]), s = sin(q[PHI] - q[THETA]);
    return hypot((c * fx + s * fy - q[M0]) / q[MU_A], (c * fy - s * fx - q[N0]) / q[MU_B]) <= 1.0;
}

/* Slip about one point: spin and slip in z, compression and tangential force; 0 if its friction could not hold it. */
static int about(const double *q, int index, double *z, double *force) {
    const double *pin = POINTS[index];
    double c = cos(q[NORMAL]), s = sin(q[NORMAL]), x = q[AT_X] - pin[0], y = q[AT_Y] - pin[1];
    double inward = c * y - s * x, dx = -c - q[SMU] * s, dy = -s + q[SMU] * c, arm = x * dy - y * dx;
    double fx = 0.0, fy = 0.0, torque = 0.0, one[2];
    if (inward == 0.0 || arm == 0.0) return 0;
    z[0] = 1.0 / inward;
    z[1] = z[0] * (c * x + s * y);
    for (int k = 0; k < POINT_COUNT; ++k) {
        if (k == index) continue;
        double lever_x = POINTS[k][0] - pin[0], lever_y = POINTS[k][1] - pin[1];
        traction(q, -z[0] * lever_y, z[0] * lever_x, one);
        fx += POINTS[k][2] * one[0];
        fy += POINTS[k][2] * one[1];
        torque += POINTS[k][2] * (lever_x * one[1] - lever_y * one[0]);
    }
    double size = torque / arm;
    force[0] = size;
    force[1] = size * q[SMU];
    return size > 0.0 && holds(q, (size * dx - fx) / pin[2], (size * dy - fy) / pin[2]);
}

/* The velocity of a point (slider's frame) at a solved stage: for a unit travel, sliding for a unit approach. */
static double speed_of(const Motion *m, const double *q, const double *z, int index) {
    double c = cos(q[NORMAL]), s = sin(q[NORMAL]), off = q[DIRECTION_OF_ROD] - q[THETA];
    double vx = slides(m) ? -c - z[1] * s : cos(off), vy = slides(m) ? -s + z[1] * c : sin(off);
    return hypot(vx - z[0] * (POINTS[index][1] - q[AT_Y]), vy + z[0] * (POINTS[index][0] - q[AT_X]));
}

static int settled_about(Run *r, Motion *m, const double *state, const double *q, int index, double *row, double *report) {
    double z[2], force[2];
    if (index < 0 || !about(q, index, z, force)) return 0;
    r->pinned = index;
    memcpy(m->z, z, sizeof z);
    settle_with(m, state, force, row, report);
    return 1;
}

/* ContactSolver.slide: about the point that was pinned last, which stays so over an interval. */
static int remembered(Run *r, Motion *m, const double *state, double *row, double *report) {
    double q[EQUATION_ARGUMENTS];
    if (POINT_COUNT == 0 || r->pinned < 0 || !slides(m)) return 0;
    equation_arguments(m, state, q);
    return settled_about(r, m, state, q, r->pinned, row, report);
}

/* About one of the four points that hardly move at the motion's unknowns. */
static int pinned(Run *r, Motion *m, const double *state, double *row, double *report) {
    double q[EQUATION_ARGUMENTS], speed[POINT_COUNT + 1];
    equation_arguments(m, state, q);
    for (int k = 0; k < POINT_COUNT; ++k) speed[k] = speed_of(m, q, m->z, k);
    for (int tried = 0; tried < 4 && tried < POINT_COUNT; ++tried) {
        int index = 0;
        for (int k = 1; k < POINT_COUNT; ++k)
            if (speed[k] < speed[index]) index = k;
        if (settled_about(r, m, state, q, index, row, report)) return 1;
        speed[index] = INFINITY;
    }
    return 0;
}

/* Whether a point hardly moves at a stage: tangents are not to be trusted there. */
static int kinked(const Motion *m, const double *row) {
    double q[EQUATION_ARGUMENTS];
    if (POINT_COUNT) equation_arguments(m, row, q);
    for (int k = 0; k < POINT_COUNT; ++k)
        if (speed_of(m, q, row + UNKNOWN, k) < STILL) return 1;
    return 0;
}
