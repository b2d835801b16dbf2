/* The unknowns of a contact, solved until certain: contact_solver.py in C. */

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
    if (!isfinite(value)) return 0;
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
