/* A contact: a rod on a piece of its contact curve, in the ring or in a wedge, and the unknowns
   that balance it. */

/* Residuals, over the mean friction coefficient, at which unknowns count as found, and above which
   they are refused. */
static const double FOUND = 2e-13, ACCEPTED = 1e-10;
/* The sums of a foundation have noise, of nearly rigid shapes more than ACCEPTED: this share of the
   tolerance of a step may remain. */
static const double ACCEPTED_SHARE = 0.1;
/* A support point slower than this (unit travel of the rod) has a kink beneath it. */
static const double STILL = 1e-7;

typedef struct Record Record;

/* One stroke: the rod goes straight on. */
typedef struct {
    const Object *object;
    double direction, friction, longest;
    int is_ambiguous; /* whether another motion, too, would have gone on from a concave corner */
    int is_wedged;    /* whether the rod has been in a concave corner */
    int64_t pinned;   /* the support point that the object last turned about */
    int64_t steps;
    int is_far; /* regime of the pressure's sums */
    const volatile int64_t *stop;
    struct Variation *varied; /* null where no derivatives are wanted */
    Pressed *pressed;         /* the contact of a foundation, at the last orientation */
    Record *record;
} Stroke;

typedef struct {
    int mode, piece;
    double p[PARAMETERS], z[UNKNOWN_SIZE];
    int64_t watched; /* the support point by whose velocity z is told, or -1 (rest.c) */
    double side;     /* on which side of its rest it moves */
    int rests;
    /* at the start of a step: derivatives of the unknowns by the state, and those of the slopes */
    double toward[UNKNOWN_SIZE * STATE_SIZE], reached[STATE_SIZE * (STATE_SIZE + MOST_VARIED)];
    int has_tangent, has_reached;
} Motion;

static int law_of(const Motion *m) { return MODE_LAW[m->mode]; }

static int place_of(const Motion *m) { return MODE_PLACE[m->mode]; }

static int slides(const Motion *m) { return law_of(m) == LAW_SLIDE; }

static int is_held(const Motion *m) { return MODE_HELD[m->mode]; }

/* Whether the contact changes where a margin falls below zero: not in the ring, nor where the
   object is held; where a support point comes to rest, everywhere. */
static int has_margins(const Motion *m) {
    return m->watched >= 0 || (place_of(m) != AT_RING && !is_held(m));
}

static int unknowns(const Motion *m) { return UNKNOWNS[law_of(m)]; }

static const double *piece_of(const Stroke *r, int piece) {
    return r->object->pieces + piece * PIECE_COLUMNS;
}

static int kind_of(const Stroke *r, const Motion *m) {
    return (int)piece_of(r, m->piece)[PIECE_KIND];
}

/* Cosines and sines of the parameters that are angles. */
static void face(Motion *m) {
    m->p[COS_DIRECTION] = cos(m->p[DIRECTION]);
    m->p[SIN_DIRECTION] = sin(m->p[DIRECTION]);
    m->p[COS_PHI] = cos(m->p[PHI]);
    m->p[SIN_PHI] = sin(m->p[PHI]);
}

static Motion motion_of(const Stroke *r, int mode, int piece, double spin, double slip) {
    const Object *o = r->object;
    Motion m = {.mode = mode, .piece = piece, .z = {spin, slip}, .watched = -1};
    m.p[DIRECTION] = r->direction;
    m.p[RADIUS] = place_of(&m) == AT_RING ? 0.0 : o->radius;
    m.p[SMU] = SIGN[mode] * r->friction;
    memcpy(m.p + MU_A, o->friction, sizeof o->friction);
    /* geometry and range */
    memcpy(m.p + GEOMETRY, piece_of(r, piece) + PIECE_GEOMETRY,
           (PIECE_BEFORE - PIECE_GEOMETRY) * sizeof(double));
    face(&m);
    return m;
}

typedef struct {
    double twist[TWIST_SIZE], matrix[MATRIX_SIZE], frame[FRAME_SIZE];
} Begun;

static void begin(const Stroke *r, const Motion *m, const double *state, const double *z,
                  Begun *b) {
    const double *given[] = {state, m->p, z};
    double *results[] = {b->twist, b->matrix, b->frame};
    BEGIN[kind_of(r, m)][law_of(m)](given, results, 0, 0, 0);
}

/* Wrench and Hessian of friction at a state: what all contacts balance. apart: the row of a support
   point that is left out, or null. */
static void friction_on(const Stroke *r, const double *state, const Begun *b, int *is_far,
                        const double *apart, double *friction) {
    const Pressure *pressure = &r->object->pressure;
    if (is_pressed(pressure)) press(pressure, state[THETA], r->pressed);
    friction_at(pressure, r->pressed, b->twist, b->matrix, is_far, apart, friction);
}

/* Derivatives of its wrench where it was found last, by columns: by mu_a, mu_b, alpha (not all: by
   alpha alone), by theta through the pressure, and by OF_PRESSURE. */
static void friction_varies(const Stroke *r, const Begun *b, int all, const double *apart,
                            double *by_law, double *by_turning, double *by_pressure) {
    const Pressure *pressure = &r->object->pressure;
    friction_by_law(pressure, r->pressed, b->twist, b->matrix, r->is_far, !all, apart, by_law);
    memset(by_turning, 0, WRENCH * sizeof(double));
    if (is_pressed(pressure)) {
        friction_by_turning(pressure, r->pressed, b->twist, b->matrix, r->is_far, by_turning);
        if (all)
            friction_by_shapes(pressure, r->pressed, b->twist, b->matrix, r->is_far,
                               by_pressure + WRENCH * SHARES);
    } else if (all)
        friction_by_shares(pressure, b->twist, b->matrix, r->is_far, apart, by_pressure);
}

static void finish(const Motion *m, const Begun *b, const double *z, const double *wrench,
                   double *row, double *report) {
    const double *given[] = {b->frame, m->p, z, wrench};
    double *results[] = {row + SLOPE, report};
    FINISH[law_of(m)](given, results, 0, 0, 0);
}

/* Of a motion with a watched support point (rest.c). */
static double iterate_watched(Stroke *r, const Motion *m, const double *state, const double *polar,
                              double *row, double *report);
static double iterate_resting(Stroke *r, const Motion *m, const double *state, double *row,
                              double *report);
static int evaluate_watched(Stroke *r, Motion *m, const double *state, double *row, double *report);

/* One Newton iteration: the row of the motion at a state, its unknowns corrected. Returns the size
   of the residual. */
static double iterate(Stroke *r, const Motion *m, const double *state, const double *z, double *row,
                      double *report) {
    Begun b;
    double friction[FRICTION_SIZE];
    if (m->rests) return iterate_resting(r, m, state, row, report);
    if (m->watched >= 0) return iterate_watched(r, m, state, z, row, report);
    begin(r, m, state, z, &b);
    friction_on(r, state, &b, &r->is_far, 0, friction);
    finish(m, &b, z, friction, row, report);
    /* the state may be the row's own */
    memmove(row, state, STATE_SIZE * sizeof(double));
    return fabs(report[RESIDUAL]);
}

/* The force of the rod: its compression, and its part along the tangent. */
typedef struct {
    double normal, tangential;
} Force;

static Force force_of(const double *report) {
    return (Force){report[NORMAL_FORCE], report[TANGENTIAL_FORCE]};
}

/* The motion at its unknowns, with forces that no Newton iteration tells: those of a contact at
   which a support point stands still, whose friction is any force between those of the motions on
   both sides. */
static void settle_with(const Stroke *r, const Motion *m, const double *state, Force force,
                        double *row, double *report) {
    Begun b;
    begin(r, m, state, m->z, &b);
    /* the wrench whose part at the contact is the given force, with no torque about it */
    const double *f = b.frame, c = f[FRAME_COSINE], s = f[FRAME_SINE];
    double gx = -c * force.normal - s * force.tangential;
    double gy = -s * force.normal + c * force.tangential;
    /* any Hessian serves: what it would correct is zero */
    const double friction[FRICTION_SIZE] = {
        [FORCE_X] = gx - f[FRAME_FORCE_X],
        [FORCE_Y] = gy - f[FRAME_FORCE_Y],
        [TORQUE] = f[FRAME_X] * gy - f[FRAME_Y] * gx - f[FRAME_TORQUE],
        [XX] = 1.0,
        [YY] = 1.0,
        [WW] = 1.0,
    };
    finish(m, &b, m->z, friction, row, report);
    memmove(row, state, STATE_SIZE * sizeof(double));
    memcpy(row + UNKNOWN, m->z, sizeof m->z);
    report[CORRECTION] = report[RESIDUAL] = 0.0;
    report[NORMAL_FORCE] = force.normal;
    report[TANGENTIAL_FORCE] = force.tangential;
}

static int evaluate(Stroke *r, Motion *m, const double *state, double *row, double *report);

/* What a bracket closes on: the spin of a contact that sticks, or the slip of one that slides. */
typedef struct {
    Stroke *r;
    const Motion *m;
    const double *state;
    double *row, *report, omega, facing; /* facing: angle of the outward normal in the world */
    Force force;
} Search;

static double torque_at(Search *s, double spin) {
    iterate(s->r, s->m, s->state, &spin, s->row, s->report);
    return s->report[RESIDUAL];
}

/* The part across the cone's edge of the force on a contact that sticks to a rod with this slip;
   all of it, with the turn's sign, beyond a right angle: the force's angle from the normal grows
   with the slip, so that this changes sign once. */
static double excess_at(Search *s, double tau) {
    double speed = hypot(1.0, tau), smu = s->m->p[SMU];
    Motion stick = motion_of(s->r, STICK, s->m->piece, s->omega / speed, 0.0);
    stick.p[DIRECTION] = s->facing + M_PI - atan(tau);
    face(&stick);
    if (evaluate(s->r, &stick, s->state, s->row, s->report) < 0) return NAN;
    s->omega = stick.z[SPIN] * speed;
    double normal = s->report[NORMAL_FORCE], tangential = s->report[TANGENTIAL_FORCE];
    double turn = atan2(tangential, normal) - atan(smu);
    if (fabs(turn) > M_PI / 2.0) return copysign(hypot(normal, tangential), turn);
    return tangential - smu * normal;
}

/* Where a function that grows vanishes: 1; where it jumps over zero: 2, with the forces of both
   sides mixed so that it would vanish; UNSOLVED where there is no bracket. */
static int vanishes(double (*of)(Search *, double), Search *s, double start, double *at) {
    enum { LOWER, UPPER };
    double width = 0.1 * (1.0 + fabs(start)), value = of(s, start), bound[2], side[2];
    Force force[2];
    if (!isfinite(value)) return UNSOLVED;
    int up = value <= 0.0, tries = 0;
    bound[!up] = start;
    side[!up] = value;
    force[!up] = force_of(s->report);
    for (; tries < 60; ++tries, width *= 2.0) {
        bound[up] = bound[!up] + (up ? width : -width);
        side[up] = of(s, bound[up]);
        force[up] = force_of(s->report);
        if (up ? side[up] >= 0.0 : side[up] <= 0.0) break;
        bound[!up] = bound[up];
        side[!up] = side[up];
        force[!up] = force[up];
    }
    if (tries == 60) return UNSOLVED;
    for (int i = 0; i < 200; ++i) {
        double rise = side[UPPER] - side[LOWER];
        double secant = bound[LOWER] - side[LOWER] * (bound[UPPER] - bound[LOWER]) / rise;
        *at = (bound[LOWER] + bound[UPPER]) / 2.0;
        if (rise > 0.0 && i % 3 && bound[LOWER] < secant && secant < bound[UPPER]) *at = secant;
        value = of(s, *at);
        if (fabs(value) <= FOUND) return 1;
        if (!isfinite(value)) return UNSOLVED;
        double farthest = fmax(fabs(bound[LOWER]), fabs(bound[UPPER]));
        if (bound[UPPER] - bound[LOWER] <= 1e-15 * fmax(farthest, 1e-3)) break;
        bound[value >= 0.0] = *at;
        side[value >= 0.0] = value;
        force[value >= 0.0] = force_of(s->report);
    }
    double share = side[UPPER] != side[LOWER] ? side[LOWER] / (side[LOWER] - side[UPPER]) : 0.5;
    *at = (bound[LOWER] + bound[UPPER]) / 2.0;
    s->force.normal = (1.0 - share) * force[LOWER].normal + share * force[UPPER].normal;
    s->force.tangential = (1.0 - share) * force[LOWER].tangential + share * force[UPPER].tangential;
    return 2;
}

/* Support points, and corners of a patch that carry a load: where one stands still, friction has a
   kink. */

static int is_points(const Stroke *r) {
    const Pressure *p = &r->object->pressure;
    return p->first_row[EVEN + 1] > 0 && (int)p->rows[ROW_KIND] == POINT;
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

/* Slip about one support point: spin and slip in z, the force, and the friction that holds the
   point: of its image, as a share of its load. Returns what share is left, -inf where none would
   do. */
static double slips_about(const Stroke *r, const Motion *m, const double *state, int64_t index,
                          double *z, Force *force, double *holding) {
    const double *row = support(r, index), *pin = row + ROW_GEOMETRY, smu = m->p[SMU];
    Begun b;
    const double still[UNKNOWN_SIZE] = {0.0};
    begin(r, m, state, still, &b);
    const double *f = b.frame;
    double c = f[FRAME_COSINE], s = f[FRAME_SINE];
    double x = f[FRAME_X] - pin[POINT_X], y = f[FRAME_Y] - pin[POINT_Y];
    double inward = c * y - s * x, dx = -c - smu * s, dy = -s + smu * c, arm = x * dy - y * dx;
    if (inward == 0.0 || arm == 0.0) return -INFINITY;
    z[SPIN] = 1.0 / inward;
    z[SLIP] = z[SPIN] * (c * x + s * y);
    begin(r, m, state, z, &b);
    /* the friction of all others, and its torque about the point */
    double others[FRICTION_SIZE];
    int is_far = 0;
    friction_on(r, state, &b, &is_far, row, others);
    double gx = others[FORCE_X] + f[FRAME_FORCE_X], gy = others[FORCE_Y] + f[FRAME_FORCE_Y];
    double torque = others[TORQUE] + f[FRAME_TORQUE] - (pin[POINT_X] * gy - pin[POINT_Y] * gx);
    double size = torque / arm;
    *force = (Force){size, size * smu};
    /* what is left for the point lies within its own ellipse: |M^-T rest| <= load */
    double load = row[ROW_LOAD] * r->object->pressure.load[part_of_points(r)];
    double px = size * dx - gx, py = size * dy - gy, *n = b.matrix;
    double all = load * (n[M_XX] * n[M_YY] - n[M_YX] * n[M_XY]);
    holding[X] = (n[M_YY] * px - n[M_YX] * py) / all;
    holding[Y] = (n[M_XX] * py - n[M_XY] * px) / all;
    return size > 0.0 && !is_far ? 1.0 - hypot(holding[X], holding[Y]) : -INFINITY;
}

static int settled_about(Stroke *r, Motion *m, const double *state, int64_t index, double *row,
                         double *report) {
    double z[UNKNOWN_SIZE], holding[2];
    Force force;
    if (index < 0 || slips_about(r, m, state, index, z, &force, holding) < 0.0) return 0;
    r->pinned = index;
    memcpy(m->z, z, sizeof z);
    settle_with(r, m, state, force, row, report);
    return 1;
}

/* Speed of a support point at a motion's unknowns. */
static double speed_of(const double *twist, const double *place) {
    return hypot(twist[VX] - twist[OMEGA] * place[Y], twist[VY] + twist[OMEGA] * place[X]);
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

/* Where Newton's method does not converge: a bracket always closes, since torque grows with the
   spin. */
static int bracketed(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    Search s = {r, m, state, row, report, m->z[SPIN], 0.0, {0.0, 0.0}};
    int closed;
    if (!slides(m)) {
        closed = vanishes(torque_at, &s, isfinite(m->z[SPIN]) ? m->z[SPIN] : 0.0, m->z + SPIN);
        if (closed == 2) settle_with(r, m, state, s.force, row, report);
        return closed < 0 ? UNSOLVED : 1;
    }
    if (count_of_points(r) && pinned(r, m, state, row, report)) return 1;
    Begun b;
    begin(r, m, state, m->z, &b);
    s.facing = state[THETA] + atan2(b.frame[FRAME_SINE], b.frame[FRAME_COSINE]);
    closed = vanishes(excess_at, &s, isfinite(m->z[SLIP]) ? m->z[SLIP] : 0.0, m->z + SLIP);
    m->z[SPIN] = s.omega;
    if (closed == 2) settle_with(r, m, state, s.force, row, report);
    if (closed != 1) return closed < 0 ? NO_SLIP : 1;
    s.force = force_of(report);
    double accepted = ACCEPTED;
    if (is_pressed(&r->object->pressure))
        accepted = fmax(accepted, ACCEPTED_SHARE * r->object->tolerance);
    double residual = iterate(r, m, state, m->z, row, report);
    if (residual > accepted && !count_of_points(r)) {
        /* the bracket closes to the digits of a summed pressure: a step of Newton's takes the rest */
        memcpy(m->z, row + UNKNOWN, sizeof m->z);
        residual = iterate(r, m, state, m->z, row, report);
    }
    if (residual <= accepted) return 1;
    if (!count_of_points(r)) return UNSOLVED;
    /* a support point stands still, whose friction the spin alone does not tell */
    settle_with(r, m, state, s.force, row, report);
    return 1;
}

/* The motion at a state, its unknowns solved until certain, from those that it has; or why that
   fails. */
static int evaluate(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    double best = INFINITY, nearest[UNKNOWN_SIZE];
    memcpy(nearest, m->z, sizeof nearest);
    if (is_held(m)) {
        const double still[UNKNOWN_SIZE] = {0.0};
        iterate(r, m, state, still, row, report);
        memset(row + SLOPE, 0, STATE_SIZE * sizeof(double));
        memset(row + UNKNOWN, 0, sizeof m->z);
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
