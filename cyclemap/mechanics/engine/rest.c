/* Support points that come to rest: what the centre of rotation comes near to.

   Friction of a point turns with the image w of its velocity however small that is: it has a kink
   where the point rests. So the point nearest to the centre of rotation is watched: the unknowns of
   the motion are told by w in polar coordinates, in which nothing is abrupt, so that steps go on
   smoothly beyond the rest itself. That the point rests is an event, where a margin is zero:

   A contact that sticks leaves the point a line of w = away n + along b, `away` by the state alone.
   Unknown is the angle of w from n, on either side of the line's foot: w is zero for an instant,
   where `away` changes its sign.
   A contact that slides leaves it every w; unknowns are its size and its direction. Where the size
   is zero the point comes to rest: the object turns about it, and its friction is what the others
   leave to it, until that comes to the edge of its ellipse. Then it sets out in the direction of
   that force. */

/* Points no farther than this from the centre of rotation (extents, in the velocity plane) are
   watched; under a contact that sticks, up to this tangent of their angle: beyond it the balance is
   not theirs. */
static const double NEAR = 0.04, STEEP = 20.0;
/* Steps of states that tangents are told by, and the least size by which directions turn. */
static const double ASIDE = 1e-7, LEAST_SIZE = 1e-9;
/* Sizes of w (unit travel of the rod) that count as rest where a motion begins. */
static const double RESTING = 1e-9;

/* The watched point at a state: w = still + spin by[SPIN] + slip by[SLIP]. */
typedef struct {
    Begun begun; /* without spin and slip */
    const double *row;
    double load, still[2], by[UNKNOWN_SIZE][2];
} Watched;

static void image_by(const double *m, double x, double y, double *image) {
    image[X] = m[M_XX] * x + m[M_XY] * y;
    image[Y] = m[M_YX] * x + m[M_YY] * y;
}

static Watched watched_at(const Stroke *r, const Motion *m, const double *state, int64_t index) {
    Watched w = {.row = support(r, index)};
    const double none[UNKNOWN_SIZE] = {0.0}, *place = w.row + ROW_GEOMETRY;
    begin(r, m, state, none, &w.begun);
    const double *f = w.begun.frame, *matrix = w.begun.matrix;
    w.load = w.row[ROW_LOAD] * r->object->pressure.load[part_of_points(r)];
    image_by(matrix, w.begun.twist[VX], w.begun.twist[VY], w.still);
    image_by(matrix, f[FRAME_Y] - place[Y], place[X] - f[FRAME_X], w.by[SPIN]);
    if (slides(m)) image_by(matrix, -f[FRAME_SINE], f[FRAME_COSINE], w.by[SLIP]);
    return w;
}

/* The line of w under a contact that sticks: its direction b, how far w goes along it by the spin,
   and where it is without: away from zero, and along. */
typedef struct {
    double b[2], rate, away, along;
} Line;

static Line line_of(const Watched *w) {
    Line l = {.rate = hypot(w->by[SPIN][X], w->by[SPIN][Y])};
    for (int k = 0; k < 2; ++k) l.b[k] = w->by[SPIN][k] / l.rate;
    l.away = w->still[Y] * l.b[X] - w->still[X] * l.b[Y];
    l.along = w->still[X] * l.b[X] + w->still[Y] * l.b[Y];
    return l;
}

/* What polar unknowns mean: direction u of w and its size, which may be negative; how u turns by
   its angle; spin and slip, and their derivatives by the polar unknowns. */
typedef struct {
    double u[2], turning[2], size, z[UNKNOWN_SIZE], by[UNKNOWN_SIZE][UNKNOWN_SIZE];
} Polar;
/* Polar unknowns: the angle from the line's normal; or size and direction. */
enum { FROM_NORMAL = 0, SIZE = 0, FACING };

static Polar polar_on_line(const Watched *w, double side, double angle) {
    Line l = line_of(w);
    double c = cos(angle), s = sin(angle), size = side * l.away / c;
    return (Polar){
        .u = {s * l.b[X] - side * c * l.b[Y], s * l.b[Y] + side * c * l.b[X]},
        .turning = {c * l.b[X] + side * s * l.b[Y], c * l.b[Y] - side * s * l.b[X]},
        .size = size,
        .z = {(size * s - l.along) / l.rate},
        .by = {{size / (c * l.rate)}},
    };
}

static Polar polar_in_plane(const Watched *w, double size, double angle) {
    const double *spin = w->by[SPIN], *slip = w->by[SLIP];
    double c = cos(angle), s = sin(angle), whole = spin[X] * slip[Y] - spin[Y] * slip[X];
    const double inverse[UNKNOWN_SIZE][2] = {{slip[Y] / whole, -slip[X] / whole},
                                             {-spin[Y] / whole, spin[X] / whole}};
    Polar p = {.u = {c, s}, .turning = {-s, c}, .size = size};
    for (int k = 0; k < UNKNOWN_SIZE; ++k) {
        const double *i = inverse[k];
        p.z[k] = i[X] * (size * c - w->still[X]) + i[Y] * (size * s - w->still[Y]);
        p.by[SIZE][k] = i[X] * c + i[Y] * s;
        p.by[FACING][k] = size * (i[Y] * c - i[X] * s);
    }
    return p;
}

static Polar polar_at(const Motion *m, const Watched *w, const double *polar) {
    if (slides(m)) return polar_in_plane(w, polar[SIZE], polar[FACING]);
    return polar_on_line(w, m->side, polar[FROM_NORMAL]);
}

/* The wrench of the point's friction for a w of this direction. */
static void own_wrench(const Watched *w, const double *u, double *wrench) {
    const double *m = w->begun.matrix, *place = w->row + ROW_GEOMETRY;
    wrench[FORCE_X] = w->load * (m[M_XX] * u[X] + m[M_YX] * u[Y]);
    wrench[FORCE_Y] = w->load * (m[M_XY] * u[X] + m[M_YY] * u[Y]);
    wrench[TORQUE] = place[X] * wrench[FORCE_Y] - place[Y] * wrench[FORCE_X];
}

/* The law's residuals at a wrench, and their derivatives by it. */
static void balance_at(const Motion *m, const double *f, const double *g, double *residual,
                       double by[UNKNOWN_SIZE][WRENCH]) {
    double smu = m->p[SMU], size = hypot(g[FORCE_X], g[FORCE_Y]);
    double turn = law_of(m) == LAW_TURN && size > 0.0 ? smu / size : 0.0;
    const double torque[WRENCH] = {f[FRAME_Y] + turn * g[FORCE_X], turn * g[FORCE_Y] - f[FRAME_X],
                                   1.0};
    const double across[WRENCH] = {smu * f[FRAME_COSINE] - f[FRAME_SINE],
                                   smu * f[FRAME_SINE] + f[FRAME_COSINE], 0.0};
    memcpy(by[0], torque, sizeof torque);
    memcpy(by[1], across, sizeof across);
    for (int i = 0; i < UNKNOWN_SIZE; ++i) {
        residual[i] = 0.0;
        for (int k = 0; k < WRENCH; ++k) residual[i] += by[i][k] * g[k];
    }
}

/* What spin and slip z add to the twist; a contact that does not slide has no slip. */
static void twist_of(const double *f, const double *z, double *twist) {
    twist[VX] = z[SPIN] * f[FRAME_Y] - z[SLIP] * f[FRAME_SINE];
    twist[VY] = z[SLIP] * f[FRAME_COSINE] - z[SPIN] * f[FRAME_X];
    twist[OMEGA] = z[SPIN];
}

/* How the wrench g goes with the polar unknowns: by the twist, which moves the others, and by the
   direction. */
static void wrench_varies(const Motion *m, const Watched *w, const Polar *p, const double *others,
                          double by[UNKNOWN_SIZE][WRENCH]) {
    int n = unknowns(m);
    double turning[WRENCH];
    own_wrench(w, p->turning, turning);
    for (int j = 0; j < n; ++j) {
        double v[TWIST_SIZE];
        twist_of(w->begun.frame, p->by[j], v);
        by[j][FORCE_X] = others[XX] * v[VX] + others[XY] * v[VY] + others[XW] * v[OMEGA];
        by[j][FORCE_Y] = others[XY] * v[VX] + others[YY] * v[VY] + others[YW] * v[OMEGA];
        by[j][TORQUE] = others[XW] * v[VX] + others[YW] * v[VY] + others[WW] * v[OMEGA];
    }
    add(by[n - 1], turning, 1.0, WRENCH);
}

/* Newton's correction of the polar unknowns. */
static void correction_of(int n, const double *residual, const double by_wrench[][WRENCH],
                          const double by[][WRENCH], double *step) {
    double slope[UNKNOWN_SIZE][UNKNOWN_SIZE] = {{0.0}};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < WRENCH; ++k) slope[i][j] += by_wrench[i][k] * by[j][k];
    step[0] = -residual[0] / slope[0][0];
    if (n == 1) return;
    double det = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
    step[0] = (slope[0][1] * residual[1] - slope[1][1] * residual[0]) / det;
    step[1] = (slope[1][0] * residual[0] - slope[0][0] * residual[1]) / det;
}

/* About what a correction leaves to be corrected: it bends with the direction, the less the smaller
   w is and the less the point carries. */
static double left_of(const Watched *w, const Polar *p, const double *polar, const double *step,
                      int n) {
    double turn = step[n - 1] * step[n - 1];
    if (n == 1)
        return turn * fmin(1.0, fabs(p->by[0][SPIN]) * (1.0 + fabs(tan(polar[FROM_NORMAL]))));
    return turn * fmin(1.0, w->load + fabs(p->size)) + fabs(step[0] * step[1]) + step[0] * step[0];
}

/* The begun contact of polar unknowns with its friction: that of all others, and of the point. */
static void friction_about(Stroke *r, const double *state, const Watched *w, const double *z,
                           Begun *b, double *others) {
    double added[TWIST_SIZE];
    *b = w->begun;
    twist_of(b->frame, z, added);
    add(b->twist, added, 1.0, TWIST_SIZE);
    friction_on(r, state, b, &r->is_far, w->row, others);
}

/* One Newton iteration of polar unknowns, as `iterate` does it for plain ones. */
static double iterate_watched(Stroke *r, const Motion *m, const double *state, const double *polar,
                              double *row, double *report) {
    Watched w = watched_at(r, m, state, m->watched);
    Polar p = polar_at(m, &w, polar);
    Begun b;
    int n = unknowns(m);
    double others[FRICTION_SIZE], g[WRENCH], residual[UNKNOWN_SIZE], step[UNKNOWN_SIZE] = {0.0};
    double by_wrench[UNKNOWN_SIZE][WRENCH], by[UNKNOWN_SIZE][WRENCH], after[UNKNOWN_SIZE];
    friction_about(r, state, &w, p.z, &b, others);
    own_wrench(&w, p.u, g);
    add(g, others, 1.0, WRENCH);
    add(g, b.frame + FRAME_FORCE_X, 1.0, WRENCH);
    balance_at(m, b.frame, g, residual, by_wrench);
    wrench_varies(m, &w, &p, others, by);
    correction_of(n, residual, by_wrench, by, step);
    for (int j = 0; j < n; ++j) add(g, by[j], step[j], WRENCH);
    for (int k = 0; k < UNKNOWN_SIZE; ++k) after[k] = k < n ? polar[k] + step[k] : 0.0;
    Polar corrected = polar_at(m, &w, after);
    /* any Hessian serves: what it would correct is next to zero */
    double friction[FRICTION_SIZE] = {[XX] = 1.0, [YY] = 1.0, [WW] = 1.0};
    for (int k = 0; k < WRENCH; ++k) friction[k] = g[k] - b.frame[FRAME_FORCE_X + k];
    finish(m, &b, corrected.z, friction, row, report);
    memmove(row, state, STATE_SIZE * sizeof(double));
    memcpy(row + UNKNOWN, after, sizeof after);
    /* in the ring no contact changes */
    for (int k = 0; k < RESTS && place_of(m) == AT_RING; ++k) row[MARGIN + k] = 1.0;
    row[MARGIN + RESTS] = slides(m) ? after[SIZE] : m->side * line_of(&w).away;
    report[CORRECTION] = sqrt(left_of(&w, &p, polar, step, n));
    report[RESIDUAL] = n == 1 ? residual[0] : hypot(residual[0], residual[1]);
    /* of the pressure's sums from afar the point cannot be left out */
    if (r->is_far) report[CORRECTION] = report[RESIDUAL] = NAN;
    return fabs(report[RESIDUAL]);
}

/* A point that rests under a contact that slides: the unknowns are known, as plain ones, and so is
   the force. */
static double iterate_resting(Stroke *r, const Motion *m, const double *state, double *row,
                              double *report) {
    Motion at = *m;
    Force force;
    double holding[2], room = slips_about(r, m, state, m->watched, at.z, &force, holding);
    if (room == -INFINITY) return report[CORRECTION] = report[RESIDUAL] = NAN;
    settle_with(r, &at, state, force, row, report);
    row[MARGIN + RESTS] = room;
    return 0.0;
}

static int evaluate_watched(Stroke *r, Motion *m, const double *state, double *row,
                            double *report) {
    enum { FREE = 4, MOST = 12 };
    double best = INFINITY;
    for (int i = 0; i < MOST; ++i) {
        double residual = iterate(r, m, state, m->z, row, report);
        if (!(residual < (i < FREE ? INFINITY : best))) return UNSOLVED;
        best = residual;
        memcpy(m->z, row + UNKNOWN, sizeof m->z);
        int pulls = slides(m) && !(report[NORMAL_FORCE] > 0.0);
        if (residual > FOUND || pulls) continue;
        double *angle = m->z + unknowns(m) - 1;
        if (!m->rests) *angle = remainder(*angle, 2.0 * M_PI);
        memcpy(row + UNKNOWN, m->z, sizeof m->z);
        return slides(m) || cos(*angle) > 0.0 ? 1 : UNSOLVED;
    }
    return UNSOLVED;
}

/* Takes the plain unknowns of a row and of its motion again. */
static void unwatch(const Stroke *r, Motion *m, double *row) {
    if (m->watched < 0) return;
    if (!m->rests) {
        Watched w = watched_at(r, m, row, m->watched);
        Polar p = polar_at(m, &w, row + UNKNOWN);
        memcpy(row + UNKNOWN, p.z, sizeof p.z);
    }
    memcpy(m->z, row + UNKNOWN, sizeof m->z);
    m->watched = -1;
    m->rests = 0;
}

/* The point that moves least at a row of plain unknowns, if it is near to the centre of rotation;
   else -1. */
static int64_t nearest_to(const Stroke *r, const Motion *m, const double *row) {
    Begun b;
    int64_t index = -1, count = count_of_points(r);
    begin(r, m, row, row + UNKNOWN, &b);
    const double *v = b.twist;
    double least = NEAR * NEAR * v[OMEGA] * v[OMEGA];
    for (int64_t k = 0; k < count; ++k) {
        const double *place = support(r, k) + ROW_GEOMETRY;
        double w[2];
        image_by(b.matrix, v[VX] - v[OMEGA] * place[Y], v[VY] + v[OMEGA] * place[X], w);
        double square = w[X] * w[X] + w[Y] * w[Y];
        if (square > least) continue;
        least = square;
        index = k;
    }
    return index;
}

/* On which side of its line's foot a point moves, and at which angle; 0 where the balance is not
   its own. Where it rests it leaves to the side that the motion takes it to. */
static int begin_on_line(const Stroke *r, Motion *m, const double *row, const Watched *w) {
    Line l = line_of(w);
    double along = l.along + row[UNKNOWN + SPIN] * l.rate, away = l.away;
    if (fabs(away) <= RESTING && fabs(along) <= RESTING) {
        double later[STATE_SIZE] = {row[THETA], row[COORDINATE]};
        add(later, row + SLOPE, ASIDE, STATE_SIZE);
        Watched next = watched_at(r, m, later, m->watched);
        away = line_of(&next).away;
        along = 0.0;
    }
    m->side = copysign(1.0, away);
    m->z[FROM_NORMAL] = atan2(along, fabs(away));
    return fabs(along) <= STEEP * fabs(away);
}

/* Size and direction of w, or that the point rests. */
static void begin_in_plane(const Stroke *r, Motion *m, const double *row, const Watched *w) {
    double image[2] = {w->still[X], w->still[Y]}, holding[2];
    Force force;
    add(image, w->by[SPIN], row[UNKNOWN + SPIN], 2);
    add(image, w->by[SLIP], row[UNKNOWN + SLIP], 2);
    double size = hypot(image[X], image[Y]);
    m->rests = size <= RESTING && slips_about(r, m, row, m->watched, m->z, &force, holding) >= 0.0;
    if (m->rests) return;
    m->z[SIZE] = size;
    m->z[FACING] = atan2(image[Y], image[X]);
}

/* Watches the point that moves least, if it is near to the centre of rotation, at a row of plain
   unknowns. */
static void watch(Stroke *r, Motion *m, double *row) {
    double report[REPORT], found[ROW];
    if (r->is_far || place_of(m) == AT_WEDGE || is_held(m) || !count_of_points(r)) return;
    Motion with = *m;
    with.watched = nearest_to(r, m, row);
    if (with.watched < 0) return;
    Watched w = watched_at(r, m, row, with.watched);
    if (slides(m))
        begin_in_plane(r, &with, row, &w);
    else if (!begin_on_line(r, &with, row, &w))
        return;
    if (evaluate_watched(r, &with, row, found, report) < 0) return;
    *m = with;
    memcpy(row, found, sizeof found);
}

/* Whether the angle of a stage has gone around, or next to it, from where the step began. */
static int goes_around(const Motion *m, const double *start, const double *row) {
    int angle = UNKNOWN + unknowns(m) - 1;
    return m->watched >= 0 && !m->rests && !(fabs(row[angle] - start[angle]) < M_PI / 2.0);
}

/* Whether the balance is still the watched point's at the end of a step. */
static int is_watchable(const Motion *m, const double *row) {
    return slides(m) || cos(row[UNKNOWN + FROM_NORMAL]) > 0.5 / STEEP;
}

/* How far a contact that sticks is from where the point passes its rest, at its pace; infinite
   where it does not come there. */
static double rest_ahead(const Stroke *r, const Motion *m, const double *row) {
    if (m->watched < 0 || slides(m)) return INFINITY;
    double later[STATE_SIZE] = {row[THETA], row[COORDINATE]};
    add(later, row + SLOPE, ASIDE, STATE_SIZE);
    Watched now = watched_at(r, m, row, m->watched), next = watched_at(r, m, later, m->watched);
    double away = m->side * line_of(&now).away, goes = m->side * line_of(&next).away - away;
    return away > 0.0 && goes < 0.0 ? ASIDE * away / -goes : INFINITY;
}

/* Whether a watched point is still the one to watch at a row. */
static int stays_watched(const Stroke *r, const Motion *m, const double *row) {
    double plain[ROW];
    Motion at = *m;
    memcpy(plain, row, sizeof plain);
    unwatch(r, &at, plain);
    if (nearest_to(r, &at, plain) != m->watched) return 0;
    return slides(m) || fabs(tan(row[UNKNOWN + FROM_NORMAL])) <= STEEP;
}

/* Where the margin of a watched point is zero: it passes its rest, comes to rest, or sets out.
   Where no polar unknowns are found then, as on the rim of a patch, plain ones are taken again. */
static int change_rest(Stroke *r, Motion *m, double *row) {
    double report[REPORT], holding[2], z[UNKNOWN_SIZE], found[ROW];
    Force force;
    Motion plain = *m;
    memcpy(found, row, sizeof found);
    unwatch(r, &plain, found);
    memcpy(m->z, row + UNKNOWN, sizeof m->z);
    if (!slides(m))
        m->side = -m->side;
    else if (!m->rests)
        m->rests = 1;
    else {
        slips_about(r, m, row, m->watched, z, &force, holding);
        m->rests = 0;
        m->z[SIZE] = 0.0;
        m->z[FACING] = atan2(holding[Y], holding[X]);
    }
    m->has_tangent = m->has_reached = 0;
    if (is_watchable(m, row) && evaluate_watched(r, m, row, row, report) == 1) return 1;
    *m = plain;
    m->has_tangent = m->has_reached = 0;
    return evaluate(r, m, found, row, report);
}

/* How the point's friction goes with the twist (added to a Hessian) and with the law (added to
   columns by mu_a, mu_b and alpha; not all: by alpha alone): M^T moves, and so does the direction
   of M v. */
static void own_varies(const Watched *w, const Polar *p, int all, double *friction,
                       double *by_law) {
    const double *m = w->begun.matrix, *u = p->u, *t = p->turning, *place = w->row + ROW_GEOMETRY;
    double turning[WRENCH], det = m[M_XX] * m[M_YY] - m[M_YX] * m[M_XY];
    own_wrench(w, t, turning);
    double size = w->load * copysign(fmax(fabs(p->size), LEAST_SIZE), p->size);
    const double hessian[FRICTION_SIZE] = {
        [XX] = turning[FORCE_X] * turning[FORCE_X] / size,
        [XY] = turning[FORCE_X] * turning[FORCE_Y] / size,
        [YY] = turning[FORCE_Y] * turning[FORCE_Y] / size,
        [XW] = turning[FORCE_X] * turning[TORQUE] / size,
        [YW] = turning[FORCE_Y] * turning[TORQUE] / size,
        [WW] = turning[TORQUE] * turning[TORQUE] / size,
    };
    add(friction, hessian, 1.0, FRICTION_SIZE);
    /* velocity over the size of w */
    double vx = (m[M_YY] * u[X] - m[M_XY] * u[Y]) / det;
    double vy = (m[M_XX] * u[Y] - m[M_YX] * u[X]) / det;
    double toward[LAW_NUMBERS][MATRIX_SIZE];
    matrix_by_law(m, toward);
    for (int k = all ? 0 : OF_ALPHA; k < LAW_NUMBERS; ++k) {
        const double *d = toward[k];
        double image[2], fx = w->load * (d[M_XX] * u[X] + d[M_YX] * u[Y]);
        double fy = w->load * (d[M_XY] * u[X] + d[M_YY] * u[Y]);
        image_by(d, vx, vy, image);
        const double moved[WRENCH] = {fx, fy, place[X] * fy - place[Y] * fx};
        add(by_law + WRENCH * k, moved, 1.0, WRENCH);
        add(by_law + WRENCH * k, turning, t[X] * image[X] + t[Y] * image[Y], WRENCH);
    }
}

/* What derivatives need at polar unknowns, which become plain ones: the friction of the watched
   point by its direction, that of the others by their velocities. */
static void friction_watched(Stroke *r, const Motion *m, const double *state, int all,
                             double *unknown, Begun *b, double *friction, double *by_law,
                             double *by_turning, double *by_pressure) {
    Watched w = watched_at(r, m, state, m->watched);
    double own[WRENCH];
    Polar p = polar_at(m, &w, unknown);
    memcpy(unknown, p.z, sizeof p.z);
    friction_about(r, state, &w, p.z, b, friction);
    friction_varies(r, b, all, w.row, by_law, by_turning, by_pressure);
    own_wrench(&w, p.u, own);
    add(friction, own, 1.0, WRENCH);
    own_varies(&w, &p, all, friction, by_law);
    int part = part_of_points(r), share = SHARE_OF_PART[part];
    double load = r->object->pressure.load[part];
    if (all && share >= 0) add(by_pressure + WRENCH * share, own, 1.0 / load, WRENCH);
}
