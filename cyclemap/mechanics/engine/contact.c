/* A contact: a rod on a piece of its contact curve, in the ring or in a wedge, and the unknowns that balance it. */

enum { STICK, SLIDE_LEFT, SLIDE_RIGHT, SLIDE_FREE, RING, RING_LEFT, RING_RIGHT, RING_STUCK, WEDGE_LEFT, WEDGE_RIGHT,
       WEDGE_STUCK };
/* Margins: where one falls below zero a contact changes. */
enum { APPROACH, AFTER_LOW, BEFORE_HIGH, FIRST, SECOND, RESTS, MARGINS };
/* Rows of a motion: state, slope by the rod's travel, margins, unknowns. */
enum { STATE = 0, SLOPE = 2, MARGIN = 4, UNKNOWN = 10, ROW = 12 };
/* What one Newton iteration reports besides. */
enum { CORRECTION, RESIDUAL, NORMAL_FORCE, TANGENTIAL_FORCE, REPORT };
/* Why a stroke ends, and why it cannot go on. */
enum { DISTANCE = 0, LEFT = 1, UNSOLVED = -1, MANY_STEPS = -2, NO_SLIP = -3, POINTS_AWAY = -4, NOT_ALONE = -5,
       RING_STOPS = -6, CHATTERS = -7, RECORD_FULL = -8, STOPPED = -9 };
/* Columns of pieces of a contact curve: kind, geometry, range; the pieces before and after. */
enum { PIECE_KIND, PIECE_GEOMETRY, PIECE_LOW = 6, PIECE_HIGH, PIECE_BEFORE, PIECE_AFTER, PIECE_COLUMNS };

/* Residuals, over the mean friction coefficient, at which unknowns count as found, and above which they are refused. */
static const double FOUND = 2e-13, ACCEPTED = 1e-10;
/* A support point slower than this (unit travel of the rod) has a kink beneath it. */
static const double STILL = 1e-7;

/* What is pushed with what: shared by many strokes, and never written. */
typedef struct {
    Pressure pressure;
    double friction[8]; /* mu_a, mu_b, m0, n0, phi, centre of pressure, friction of the rod */
    double radius, tolerance;
    const double *pieces; /* of the contact curve; the ring behind them */
    int64_t piece_count;
} Object;

typedef struct Record Record;

/* One stroke: the rod goes straight on. */
typedef struct {
    const Object *object;
    double direction, friction, longest;
    int is_wedged;       /* whether the rod has been in a concave corner */
    int64_t pinned;      /* the support point that the object last turned about */
    int64_t steps;
    int is_far;          /* regime of the pressure's sums */
    const volatile int64_t *stop;
    struct Variation *varied; /* null where no derivatives are wanted */
    Record *record;
} Stroke;

typedef struct {
    int mode, piece;
    double p[PARAMETERS], z[2];
    /* the support point by whose velocity z is told, or -1; on which side it passes; whether it rests (rest.c) */
    int64_t watched;
    double side;
    int rests;
    /* at the start of a step: derivatives of the unknowns by the state, and those of the slopes */
    double toward[4], reached[2 * (2 + MOST_VARIED)];
    int has_tangent, has_reached;
} Motion;

static const double SIGN[] = {1.0, 1.0, -1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 1.0, -1.0, 0.0};

static int slides(const Motion *m) { return SLIDE_LEFT <= m->mode && m->mode <= SLIDE_FREE; }

static int is_held(const Motion *m) { return m->mode == RING_STUCK || m->mode == WEDGE_STUCK; }

/* Whether the contact changes where a margin falls below zero: not in the ring, nor where the object is held. */
static int has_margins(const Motion *m) {
    return m->mode < RING || m->mode == WEDGE_LEFT || m->mode == WEDGE_RIGHT || m->watched >= 0;
}

static int law_of(const Motion *m) {
    if (m->mode >= WEDGE_LEFT) return LAW_WEDGE;
    return slides(m) ? LAW_SLIDE : m->mode == RING_LEFT || m->mode == RING_RIGHT ? LAW_TURN : LAW_STICK;
}

static int unknowns(const Motion *m) { return slides(m) ? 2 : 1; }

static const double *piece_of(const Stroke *r, int piece) { return r->object->pieces + piece * PIECE_COLUMNS; }

static int kind_of(const Stroke *r, const Motion *m) { return (int)piece_of(r, m->piece)[PIECE_KIND]; }

/* Cosines and sines of the parameters that are angles. */
static void face(Motion *m) {
    double *to = m->p + COSINES;
    to[0] = cos(m->p[DIRECTION]);
    to[1] = sin(m->p[DIRECTION]);
    to[2] = cos(m->p[PHI]);
    to[3] = sin(m->p[PHI]);
}

static Motion motion_of(const Stroke *r, int mode, int piece, double z0, double z1) {
    const Object *o = r->object;
    Motion m = {.mode = mode, .piece = piece, .z = {z0, z1}, .watched = -1};
    m.p[DIRECTION] = r->direction;
    m.p[1] = RING <= mode && mode <= RING_STUCK ? 0.0 : o->radius;
    m.p[2] = SIGN[mode] * r->friction;
    memcpy(m.p + 3, o->friction, 7 * sizeof(double));
    memcpy(m.p + 10, piece_of(r, piece) + PIECE_GEOMETRY, 7 * sizeof(double));
    face(&m);
    return m;
}

typedef struct { double twist[3], matrix[4], frame[FRAME]; } Begun;

static void begin(const Stroke *r, const Motion *m, const double *state, const double *z, Begun *b) {
    const double *given[] = {state, m->p, z};
    double *results[] = {b->twist, b->matrix, b->frame};
    BEGIN[kind_of(r, m)][law_of(m)](given, results, 0, 0, 0);
}

static void finish(const Motion *m, const Begun *b, const double *z, const double *wrench, double *row, double *report) {
    const double *given[] = {b->frame, m->p, z, wrench};
    double *results[] = {row + SLOPE, report};
    FINISH[law_of(m)](given, results, 0, 0, 0);
}

static double iterate_watched(Stroke *r, const Motion *m, const double *state, const double *unknown, double *row,
                              double *report);
static double iterate_resting(Stroke *r, const Motion *m, const double *state, double *row, double *report);
static int evaluate_watched(Stroke *r, Motion *m, const double *state, double *row, double *report);

/* One Newton iteration: the row of the motion at a state, its unknowns corrected. Returns the size of the residual. */
static double iterate(Stroke *r, const Motion *m, const double *state, const double *z, double *row, double *report) {
    Begun b;
    double wrench[9];
    if (m->rests) return iterate_resting(r, m, state, row, report);
    if (m->watched >= 0) return iterate_watched(r, m, state, z, row, report);
    begin(r, m, state, z, &b);
    friction_at(&r->object->pressure, b.twist, b.matrix, &r->is_far, wrench);
    finish(m, &b, z, wrench, row, report);
    memcpy(row, state, 2 * sizeof(double));
    return fabs(report[RESIDUAL]);
}

/* The motion at its unknowns, with forces that no Newton iteration tells: those of a contact at which a support point
   stands still, whose friction is any force between those of the motions on both sides. */
static void settle_with(const Stroke *r, const Motion *m, const double *state, const double *force, double *row,
                        double *report) {
    Begun b;
    begin(r, m, state, m->z, &b);
    /* the wrench whose part at the contact is the given force, with no torque about it */
    const double *f = b.frame, gx = -f[5] * force[0] - f[6] * force[1], gy = -f[6] * force[0] + f[5] * force[1];
    /* any Hessian serves: what it would correct is zero */
    const double wrench[9] = {gx - f[0], gy - f[1], f[3] * gy - f[4] * gx - f[2], 1.0, 0.0, 1.0, 0.0, 0.0, 1.0};
    finish(m, &b, m->z, wrench, row, report);
    memcpy(row, state, 2 * sizeof(double));
    memcpy(row + UNKNOWN, m->z, 2 * sizeof(double));
    report[CORRECTION] = report[RESIDUAL] = 0.0;
    report[NORMAL_FORCE] = force[0];
    report[TANGENTIAL_FORCE] = force[1];
}

static int evaluate(Stroke *r, Motion *m, const double *state, double *row, double *report);

/* What a bracket closes on: the spin of a contact that sticks, or the slip of one that slides. */
typedef struct {
    Stroke *r;
    const Motion *m;
    const double *state;
    double *row, *report, omega, facing; /* facing: angle of the outward normal in the world */
    double force[2];
} Search;

static double torque_at(Search *s, double spin) {
    iterate(s->r, s->m, s->state, &spin, s->row, s->report);
    return s->report[RESIDUAL];
}

/* The part across the cone's edge of the force on a contact that sticks to a rod with this slip; all of it, with the
   turn's sign, beyond a right angle: the force's angle from the normal grows with the slip, so that this changes sign
   once. */
static double excess_at(Search *s, double tau) {
    double speed = hypot(1.0, tau), smu = s->m->p[2];
    Motion stick = motion_of(s->r, STICK, s->m->piece, s->omega / speed, 0.0);
    stick.p[DIRECTION] = s->facing + M_PI - atan(tau);
    face(&stick);
    if (evaluate(s->r, &stick, s->state, s->row, s->report) < 0) return NAN;
    s->omega = stick.z[0] * speed;
    double normal = s->report[NORMAL_FORCE], tangential = s->report[TANGENTIAL_FORCE];
    double turn = atan2(tangential, normal) - atan(smu);
    return fabs(turn) > M_PI / 2.0 ? copysign(hypot(normal, tangential), turn) : tangential - smu * normal;
}

/* Where a function that grows vanishes: 1; where it jumps over zero: 2, with the forces of both sides mixed so that it
   would vanish; UNSOLVED where there is no bracket. */
static int vanishes(double (*of)(Search *, double), Search *s, double start, double *at) {
    double width = 0.1 * (1.0 + fabs(start)), value = of(s, start), bound[2], side[2], force[2][2];
    const double *now = s->report + NORMAL_FORCE;
    if (!isfinite(value)) return UNSOLVED;
    int up = value <= 0.0, tries = 0;
    bound[!up] = start;
    side[!up] = value;
    memcpy(force[!up], now, sizeof force[0]);
    for (; tries < 60; ++tries, width *= 2.0) {
        bound[up] = bound[!up] + (up ? width : -width);
        side[up] = of(s, bound[up]);
        memcpy(force[up], now, sizeof force[0]);
        if (up ? side[up] >= 0.0 : side[up] <= 0.0) break;
        bound[!up] = bound[up];
        side[!up] = side[up];
        memcpy(force[!up], force[up], sizeof force[0]);
    }
    if (tries == 60) return UNSOLVED;
    for (int i = 0; i < 200; ++i) {
        double rise = side[1] - side[0], secant = bound[0] - side[0] * (bound[1] - bound[0]) / rise;
        *at = (bound[0] + bound[1]) / 2.0;
        if (rise > 0.0 && i % 3 && bound[0] < secant && secant < bound[1]) *at = secant;
        value = of(s, *at);
        if (fabs(value) <= FOUND) return 1;
        if (!isfinite(value)) return UNSOLVED;
        if (bound[1] - bound[0] <= 1e-15 * fmax(fmax(fabs(bound[0]), fabs(bound[1])), 1e-3)) break;
        bound[value >= 0.0] = *at;
        side[value >= 0.0] = value;
        memcpy(force[value >= 0.0], now, sizeof force[0]);
    }
    double share = side[1] != side[0] ? side[0] / (side[0] - side[1]) : 0.5;
    *at = (bound[0] + bound[1]) / 2.0;
    for (int k = 0; k < 2; ++k) s->force[k] = (1.0 - share) * force[0][k] + share * force[1][k];
    return 2;
}

/* Support points, and corners of a patch that carry a load: where one stands still, friction has a kink. */

static int is_points(const Stroke *r) {
    const Pressure *p = &r->object->pressure;
    return p->first_row[1] > 0 && (int)p->rows[ROW_KIND] == POINT;
}

/* The part of the pressure that consists of points. */
static int part_of_points(const Stroke *r) { return is_points(r) ? EVEN : CORNERS; }

static int64_t count_of_points(const Stroke *r) {
    const Pressure *p = &r->object->pressure;
    int part = part_of_points(r);
    return p->load[part] != 0.0 ? p->first_row[part + 1] - p->first_row[part] : 0;
}

static const double *support(const Stroke *r, int64_t index) {
    const Pressure *p = &r->object->pressure;
    return p->rows + ROW_COLUMNS * (p->first_row[part_of_points(r)] + index);
}

/* Slip about one support point: spin and slip in z, forces, and what of the point's friction holds it there: w's
   direction as it sets out, times the share that is needed. Returns what share of it is left, -inf where none would do. */
static double slips_about(const Stroke *r, const Motion *m, const double *state, int64_t index, double *z, double *force,
                          double *holding) {
    const double *row = support(r, index), *pin = row + ROW_GEOMETRY, smu = m->p[2], still[2] = {0.0, 0.0};
    Begun b;
    begin(r, m, state, still, &b);
    const double *f = b.frame;
    double c = f[5], s = f[6], x = f[3] - pin[0], y = f[4] - pin[1];
    double inward = c * y - s * x, dx = -c - smu * s, dy = -s + smu * c, arm = x * dy - y * dx;
    if (inward == 0.0 || arm == 0.0) return -INFINITY;
    z[0] = 1.0 / inward;
    z[1] = z[0] * (c * x + s * y);
    begin(r, m, state, z, &b);
    /* the friction of all others, and its torque about the point */
    const Pressure *p = &r->object->pressure;
    double wrench[9], load = row[ROW_LOAD] * p->load[part_of_points(r)];
    int is_far = 0;
    friction_without(p, b.twist, b.matrix, &is_far, row, wrench);
    double gx = wrench[0] + f[0], gy = wrench[1] + f[1], torque = wrench[2] + f[2] - (pin[0] * gy - pin[1] * gx);
    double size = torque / arm;
    force[0] = size;
    force[1] = size * smu;
    /* what is left for the point lies within its own ellipse: |M^-T rest| <= load */
    double px = size * dx - gx, py = size * dy - gy, *n = b.matrix, all = load * (n[0] * n[3] - n[1] * n[2]);
    holding[0] = (n[3] * px - n[1] * py) / all;
    holding[1] = (n[0] * py - n[2] * px) / all;
    return size > 0.0 && !is_far ? 1.0 - hypot(holding[0], holding[1]) : -INFINITY;
}

static int settled_about(Stroke *r, Motion *m, const double *state, int64_t index, double *row, double *report) {
    double z[2], force[2], holding[2];
    if (index < 0 || slips_about(r, m, state, index, z, force, holding) < 0.0) return 0;
    r->pinned = index;
    memcpy(m->z, z, sizeof z);
    settle_with(r, m, state, force, row, report);
    return 1;
}

/* Speed of a support point at a motion's unknowns. */
static double speed_of(const double *twist, const double *place) {
    return hypot(twist[0] - twist[2] * place[1], twist[1] + twist[2] * place[0]);
}

/* About one of the four support points that move least at the motion's unknowns. */
static int pinned(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    Begun b;
    double slower_than = -1.0;
    begin(r, m, state, m->z, &b);
    int64_t count = count_of_points(r);
    for (int tried = 0; tried < 4 && tried < count; ++tried) {
        int64_t index = -1;
        double least = INFINITY;
        for (int64_t k = 0; k < count; ++k) {
            double speed = speed_of(b.twist, support(r, k) + ROW_GEOMETRY);
            if (speed > slower_than && speed < least) {
                least = speed;
                index = k;
            }
        }
        if (index < 0) return 0;
        if (settled_about(r, m, state, index, row, report)) return 1;
        slower_than = least;
    }
    return 0;
}

/* Whether a support point hardly moves at a row: tangents are not to be trusted there. */
static int is_kinked(const Stroke *r, const Motion *m, const double *row) {
    int64_t count = count_of_points(r);
    if (!count) return 0;
    Begun b;
    begin(r, m, row, row + UNKNOWN, &b);
    for (int64_t k = 0; k < count; ++k)
        if (speed_of(b.twist, support(r, k) + ROW_GEOMETRY) < STILL) return 1;
    return 0;
}

/* Where Newton's method does not converge: a bracket always closes, since torque grows with the spin. */
static int bracketed(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    Search s = {r, m, state, row, report, m->z[0], 0.0, {0.0}};
    int closed;
    if (!slides(m)) {
        closed = vanishes(torque_at, &s, isfinite(m->z[0]) ? m->z[0] : 0.0, m->z);
        if (closed == 2) settle_with(r, m, state, s.force, row, report);
        return closed < 0 ? UNSOLVED : 1;
    }
    if (count_of_points(r) && pinned(r, m, state, row, report)) return 1;
    Begun b;
    begin(r, m, state, m->z, &b);
    s.facing = state[0] + atan2(b.frame[6], b.frame[5]);
    closed = vanishes(excess_at, &s, isfinite(m->z[1]) ? m->z[1] : 0.0, &m->z[1]);
    m->z[0] = s.omega;
    if (closed == 2) settle_with(r, m, state, s.force, row, report);
    if (closed != 1) return closed < 0 ? NO_SLIP : 1;
    memcpy(s.force, report + NORMAL_FORCE, sizeof s.force);
    if (iterate(r, m, state, m->z, row, report) <= ACCEPTED) return 1;
    if (!count_of_points(r)) return UNSOLVED;
    /* a support point stands still, whose friction the spin alone does not tell */
    settle_with(r, m, state, s.force, row, report);
    return 1;
}

/* The motion at a state, its unknowns solved until certain, from those that it has; or why that fails. */
static int evaluate(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    double best = INFINITY, nearest[2] = {m->z[0], m->z[1]};
    if (is_held(m)) {
        const double still[2] = {0.0, 0.0};
        iterate(r, m, state, still, row, report);
        memset(row + SLOPE, 0, 2 * sizeof(double));
        memset(row + UNKNOWN, 0, 2 * sizeof(double));
        report[CORRECTION] = report[RESIDUAL] = 0.0;
        return 1;
    }
    if (m->watched >= 0) return evaluate_watched(r, m, state, row, report);
    if (slides(m) && r->pinned >= 0 && settled_about(r, m, state, r->pinned, row, report)) return 1;
    for (int i = 0;; ++i) {
        double residual = iterate(r, m, state, m->z, row, report);
        /* the opposite of the cone's edge satisfies the equations too, but a rod cannot pull */
        if (residual <= FOUND && (!slides(m) || report[NORMAL_FORCE] > 0.0)) break;
        if (i == 11 || !(residual < 0.7 * best)) {
            if (slides(m)) memcpy(m->z, nearest, sizeof nearest);
            int found = bracketed(r, m, state, row, report);
            if (found < 0) return found;
            break;
        }
        best = residual;
        memcpy(nearest, m->z, sizeof nearest);
        memcpy(m->z, row + UNKNOWN, sizeof nearest);
    }
    memcpy(m->z, row + UNKNOWN, sizeof nearest);
    return 1;
}
