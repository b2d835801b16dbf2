/* Support points that come to rest: what the centre of rotation comes near to.

   Friction of a point that hardly moves turns with its velocity w however small that is: it has a kink where the point
   rests. So the point nearest to the centre of rotation is watched: the unknowns of the motion are told by its velocity,
   in polar coordinates, in which nothing is abrupt, and the motion goes on smoothly beyond the rest itself. That it comes
   to rest is an event, where a margin is zero:

   A contact that sticks leaves the point a line of velocities, w = d n + x b, d by the state alone. Unknown is the angle
   of w from n, for either sign of d: w comes to rest for an instant, where d changes its sign.
   A contact that slides leaves it all velocities. Unknowns are the speed and the direction. Once the speed is zero the
   point rests: the object turns about it, and its friction is what the others leave to it, until that comes to the edge
   of its ellipse; then it sets out in the direction of that force. */

/* Centres of rotation nearer to a point than this (extents, in the velocity plane) make it watched; and the tangent of
   the angle beyond which a sticking contact's friction does not come from it. */
static const double NEAR = 0.04, STEEP = 4.0;
/* Steps of states that tangents are told by; and the least speed by which directions turn. */
static const double ASIDE = 1e-7, LEAST_SPEED = 1e-9;
/* Speeds (unit travel of the rod) that count as rest where a motion begins. */
static const double RESTING = 1e-9;

/* The watched point at a state: w = still + z0 by[0] + z1 by[1]. */
typedef struct {
    Begun b; /* at rest of both unknowns */
    const double *row;
    double load, still[2], by[2][2];
} Watched;

static void watched_at(const Stroke *r, const Motion *m, const double *state, Watched *w) {
    const double none[2] = {0.0, 0.0}, *n = w->b.matrix;
    begin(r, m, state, none, &w->b);
    const double *f = w->b.frame;
    w->row = support(r, m->watched);
    w->load = w->row[ROW_LOAD] * r->object->pressure.load[part_of_points(r)];
    double x = f[3] - w->row[ROW_GEOMETRY], y = f[4] - w->row[ROW_GEOMETRY + 1];
    const double ways[3][2] = {{w->b.twist[0], w->b.twist[1]}, {y, -x}, {-f[6], f[5]}};
    for (int k = 0; k < 3; ++k) {
        double *to = k ? w->by[k - 1] : w->still;
        to[0] = n[0] * ways[k][0] + n[2] * ways[k][1];
        to[1] = n[1] * ways[k][0] + n[3] * ways[k][1];
    }
}

/* What polar unknowns mean: direction u and signed speed of w, how u turns by its angle, plain unknowns and their
   derivatives by the polar ones. */
typedef struct { double u[2], turning[2], speed, z[2], by[2][2]; } Polar;

static Polar polar_at(const Motion *m, const Watched *w, const double *unknown) {
    Polar p = {.speed = 0.0};
    if (!slides(m)) {
        double size = hypot(w->by[0][0], w->by[0][1]), c = cos(unknown[0]), s = sin(unknown[0]);
        double bx = w->by[0][0] / size, by = w->by[0][1] / size, away = w->still[1] * bx - w->still[0] * by;
        p.u[0] = -m->side * c * by + s * bx;
        p.u[1] = m->side * c * bx + s * by;
        p.turning[0] = m->side * s * by + c * bx;
        p.turning[1] = -m->side * s * bx + c * by;
        p.speed = m->side * away / c;
        p.z[0] = (p.speed * s - w->still[0] * bx - w->still[1] * by) / size;
        p.by[0][0] = p.speed / (c * size);
        return p;
    }
    double c = cos(unknown[1]), s = sin(unknown[1]), whole = w->by[0][0] * w->by[1][1] - w->by[1][0] * w->by[0][1];
    double inverse[2][2] = {{w->by[1][1] / whole, -w->by[1][0] / whole}, {-w->by[0][1] / whole, w->by[0][0] / whole}};
    p.speed = unknown[0];
    p.u[0] = c;
    p.u[1] = s;
    p.turning[0] = -s;
    p.turning[1] = c;
    for (int k = 0; k < 2; ++k) {
        p.z[k] = inverse[k][0] * (p.speed * c - w->still[0]) + inverse[k][1] * (p.speed * s - w->still[1]);
        p.by[0][k] = inverse[k][0] * c + inverse[k][1] * s;
        p.by[1][k] = p.speed * (inverse[k][1] * c - inverse[k][0] * s);
    }
    return p;
}

/* The wrench of the point's friction in a direction of w. */
static void own_wrench(const Watched *w, const double *direction, double *wrench) {
    const double *n = w->b.matrix, *place = w->row + ROW_GEOMETRY;
    wrench[0] = w->load * (n[0] * direction[0] + n[1] * direction[1]);
    wrench[1] = w->load * (n[2] * direction[0] + n[3] * direction[1]);
    wrench[2] = place[0] * wrench[1] - place[1] * wrench[0];
}

static void twist_of(const Motion *m, const Watched *w, const double *z, double *twist) {
    const double *f = w->b.frame;
    twist[0] = w->b.twist[0] + z[0] * f[4] - (slides(m) ? z[1] * f[6] : 0.0);
    twist[1] = w->b.twist[1] - z[0] * f[3] + (slides(m) ? z[1] * f[5] : 0.0);
    twist[2] = z[0];
}

/* The equations' residuals at a wrench, and their derivatives by it. */
static void balance_at(const Motion *m, const double *f, const double *g, double *residual, double by[2][3]) {
    double smu = m->p[2], size = hypot(g[0], g[1]), turn = law_of(m) == LAW_TURN && size > 0.0 ? smu / size : 0.0;
    by[0][0] = f[4] + turn * g[0];
    by[0][1] = -f[3] + turn * g[1];
    by[0][2] = 1.0;
    by[1][0] = smu * f[5] - f[6];
    by[1][1] = smu * f[6] + f[5];
    by[1][2] = 0.0;
    for (int i = 0; i < 2; ++i) residual[i] = by[i][0] * g[0] + by[i][1] * g[1] + by[i][2] * g[2];
}

static void finish_with(const Motion *m, const Watched *w, const double *z, const double *g, double *row, double *report) {
    const double *f = w->b.frame;
    /* any Hessian serves: what it would correct is next to zero */
    const double wrench[9] = {g[0] - f[0], g[1] - f[1], g[2] - f[2], 1.0, 0.0, 1.0, 0.0, 0.0, 1.0};
    finish(m, &w->b, z, wrench, row, report);
}

/* One Newton iteration of polar unknowns, as `iterate` does it for plain ones. */
static double iterate_watched(Stroke *r, const Motion *m, const double *state, const double *unknown, double *row,
                              double *report) {
    Watched w;
    double twist[3], wrench[9], own[3], turning[3], g[3], residual[2], by[2][3], moved[2][3], step[2] = {0.0, 0.0};
    watched_at(r, m, state, &w);
    Polar p = polar_at(m, &w, unknown);
    const double *f = w.b.frame, ways[2][3] = {{f[4], -f[3], 1.0}, {-f[6], f[5], 0.0}};
    int n = unknowns(m), angle = n - 1;
    twist_of(m, &w, p.z, twist);
    friction_without(&r->object->pressure, twist, w.b.matrix, &r->is_far, w.row, wrench);
    own_wrench(&w, p.u, own);
    own_wrench(&w, p.turning, turning);
    for (int k = 0; k < 3; ++k) g[k] = wrench[k] + own[k] + f[k];
    balance_at(m, f, g, residual, by);
    const double hessian[3][3] = {{wrench[3], wrench[4], wrench[6]}, {wrench[4], wrench[5], wrench[7]},
                                  {wrench[6], wrench[7], wrench[8]}};
    for (int j = 0; j < n; ++j) {
        double way[3];
        for (int k = 0; k < 3; ++k) way[k] = p.by[j][0] * ways[0][k] + p.by[j][1] * ways[1][k];
        for (int k = 0; k < 3; ++k) {
            moved[j][k] = hessian[k][0] * way[0] + hessian[k][1] * way[1] + hessian[k][2] * way[2];
            if (j == angle) moved[j][k] += turning[k];
        }
    }
    double slope[2][2];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) slope[i][j] = by[i][0] * moved[j][0] + by[i][1] * moved[j][1] + by[i][2] * moved[j][2];
    if (n == 1) step[0] = -residual[0] / slope[0][0];
    else {
        double whole = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
        step[0] = (slope[0][1] * residual[1] - slope[1][1] * residual[0]) / whole;
        step[1] = (slope[1][0] * residual[0] - slope[0][0] * residual[1]) / whole;
    }
    const double corrected[2] = {unknown[0] + step[0], unknown[1] + step[1]};
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < 3; ++k) g[k] += step[j] * moved[j][k];
    Polar after = polar_at(m, &w, corrected);
    /* what is left of it bends with the direction, the less the slower the point is and the less it carries */
    double turn = step[angle] * step[angle], left = n == 1
        ? turn * fmin(1.0, fabs(p.by[0][0]) * (1.0 + fabs(tan(unknown[0]))))
        : turn * fmin(1.0, w.load + fabs(p.speed)) + fabs(step[0] * step[1]) + step[0] * step[0];
    finish_with(m, &w, after.z, g, row, report);
    memcpy(row, state, 2 * sizeof(double));
    memcpy(row + UNKNOWN, corrected, 2 * sizeof(double));
    /* in the ring no contact changes */
    for (int k = 0; k < RESTS && m->mode >= RING; ++k) row[MARGIN + k] = 1.0;
    row[MARGIN + RESTS] = n == 1 ? after.speed * cos(corrected[0]) : corrected[0];
    report[CORRECTION] = sqrt(left);
    report[RESIDUAL] = n == 1 ? residual[0] : hypot(residual[0], residual[1]);
    /* of the pressure's sums from afar the point cannot be left out */
    if (r->is_far) report[CORRECTION] = report[RESIDUAL] = NAN;
    return fabs(report[RESIDUAL]);
}

/* A point that rests under a contact that slides: the unknowns are known, the forces what is left to it. */
static double iterate_resting(Stroke *r, const Motion *m, const double *state, double *row, double *report) {
    Motion at = *m;
    double force[2], holding[2], room = slips_about(r, m, state, m->watched, at.z, force, holding);
    settle_with(r, &at, state, force, row, report);
    row[MARGIN + RESTS] = room;
    return isfinite(at.z[0]) && isfinite(room) ? 0.0 : NAN;
}

static int evaluate_watched(Stroke *r, Motion *m, const double *state, double *row, double *report) {
    double best = INFINITY;
    for (int i = 0; i < 12; ++i) {
        double residual = iterate(r, m, state, m->z, row, report);
        int pulls = slides(m) && !(report[NORMAL_FORCE] > 0.0);
        if (m->rests || (residual <= FOUND && !pulls)) {
            memcpy(m->z, row + UNKNOWN, sizeof m->z);
            return isfinite(residual) ? 1 : UNSOLVED;
        }
        if (!(residual < (i < 4 ? INFINITY : best))) return UNSOLVED;
        best = residual;
        memcpy(m->z, row + UNKNOWN, sizeof m->z);
    }
    return UNSOLVED;
}

/* Takes the plain unknowns of a row and of its motion again. */
static void unwatch(const Stroke *r, Motion *m, double *row) {
    if (m->watched < 0) return;
    if (!m->rests) {
        Watched w;
        watched_at(r, m, row, &w);
        Polar p = polar_at(m, &w, row + UNKNOWN);
        memcpy(row + UNKNOWN, p.z, sizeof p.z);
    }
    memcpy(m->z, row + UNKNOWN, sizeof m->z);
    m->watched = -1;
    m->rests = 0;
}

/* The point that moves least at a row of plain unknowns, and its speed in the velocity plane. */
static int64_t least_moved(const Stroke *r, const Motion *m, const double *row, double *speed) {
    Begun b;
    int64_t index = -1, count = count_of_points(r);
    begin(r, m, row, row + UNKNOWN, &b);
    const double *v = b.twist, *n = b.matrix;
    double least = INFINITY;
    for (int64_t k = 0; k < count; ++k) {
        const double *place = support(r, k) + ROW_GEOMETRY;
        double x = v[0] - v[2] * place[1], y = v[1] + v[2] * place[0];
        double wx = n[0] * x + n[2] * y, wy = n[1] * x + n[3] * y, square = wx * wx + wy * wy;
        if (square < least) {
            least = square;
            index = k;
        }
    }
    *speed = sqrt(least);
    return least <= NEAR * NEAR * v[2] * v[2] ? index : -1;
}

/* Watches the point that moves least, if it is near to the centre of rotation, at a row of plain unknowns. */
static void watch(Stroke *r, Motion *m, double *row) {
    double speed, report[REPORT], found[ROW];
    if (r->is_far || m->mode >= WEDGE_LEFT || is_held(m) || !count_of_points(r)) return;
    int64_t index = least_moved(r, m, row, &speed);
    if (index < 0) return;
    Motion with = *m;
    Watched w;
    with.watched = index;
    watched_at(r, &with, row, &w);
    double x = w.still[0] + row[UNKNOWN] * w.by[0][0], y = w.still[1] + row[UNKNOWN] * w.by[0][1];
    if (slides(m)) {
        x += row[UNKNOWN + 1] * w.by[1][0];
        y += row[UNKNOWN + 1] * w.by[1][1];
        with.rests = speed <= RESTING && slips_about(r, m, row, index, with.z, found, found + 2) >= 0.0;
        with.z[0] = with.rests ? with.z[0] : speed;
        with.z[1] = with.rests ? with.z[1] : atan2(y, x);
    } else {
        double size = hypot(w.by[0][0], w.by[0][1]), bx = w.by[0][0] / size, by = w.by[0][1] / size;
        double away = w.still[1] * bx - w.still[0] * by, along = x * bx + y * by;
        if (fabs(away) <= RESTING && fabs(along) <= RESTING) {
            /* it leaves the point to that side */
            double later[2] = {row[0] + ASIDE * row[SLOPE], row[1] + ASIDE * row[SLOPE + 1]};
            Watched next;
            watched_at(r, &with, later, &next);
            away = next.still[1] * next.by[0][0] - next.still[0] * next.by[0][1];
            along = 0.0;
        }
        if (!(fabs(along) <= STEEP * fabs(away))) return;
        with.side = copysign(1.0, away);
        with.z[0] = atan2(along, fabs(away));
        with.z[1] = 0.0;
    }
    if (evaluate_watched(r, &with, row, found, report) < 0) return;
    *m = with;
    memcpy(row, found, sizeof found);
}

/* Whether a contact's friction still comes from the watched point at the end of a step. */
static int is_watchable(const Motion *m, const double *row) {
    return slides(m) || cos(row[UNKNOWN]) > 0.5 / STEEP;
}

/* Whether a watched point is still the one to watch at a row. */
static int stays_watched(const Stroke *r, const Motion *m, const double *row) {
    double speed, plain[ROW];
    Motion at = *m;
    memcpy(plain, row, sizeof plain);
    unwatch(r, &at, plain);
    return least_moved(r, &at, plain, &speed) == m->watched && (slides(m) || fabs(tan(row[UNKNOWN])) <= STEEP);
}

/* Where the margin of a watched point is zero: it passes its rest, comes to rest, or sets out. */
static int change_rest(Stroke *r, Motion *m, double *row) {
    double report[REPORT];
    memcpy(m->z, row + UNKNOWN, sizeof m->z);
    if (!slides(m)) m->side = -m->side;
    else if (m->rests) {
        double z[2], force[2], holding[2];
        slips_about(r, m, row, m->watched, z, force, holding);
        m->rests = 0;
        m->z[0] = 0.0;
        m->z[1] = atan2(holding[1], holding[0]);
    } else m->rests = 1;
    m->has_tangent = m->has_reached = 0;
    return evaluate_watched(r, m, row, row, report);
}

/* What `slopes_at` needs at polar unknowns, which become plain ones: the friction of the watched point by its direction,
   that of the others by their velocities. */
static void friction_watched(Stroke *r, const Motion *m, const double *state, int all, double *unknown, Begun *b,
                             double *wrench, double *by_law, double *by_shares) {
    const Pressure *pressure = &r->object->pressure;
    Watched w;
    watched_at(r, m, state, &w);
    Polar p = polar_at(m, &w, unknown);
    memcpy(unknown, p.z, sizeof p.z);
    begin(r, m, state, unknown, b);
    const double *n = b->matrix, *place = w.row + ROW_GEOMETRY, det = n[0] * n[3] - n[1] * n[2];
    double own[3], turning[3], mu_a = hypot(n[0], n[2]), mu_b = hypot(n[1], n[3]);
    double speed = copysign(fmax(fabs(p.speed), LEAST_SPEED), p.speed);
    friction_without(pressure, b->twist, n, &r->is_far, w.row, wrench);
    friction_by_law(pressure, b->twist, n, r->is_far, !all, w.row, by_law);
    if (all) friction_by_shares(pressure, b->twist, n, r->is_far, w.row, by_shares);
    own_wrench(&w, p.u, own);
    own_wrench(&w, p.turning, turning);
    /* how the direction turns, by the twist */
    const double *t = p.turning;
    double by[3] = {t[0] * n[0] + t[1] * n[1], t[0] * n[2] + t[1] * n[3]};
    by[2] = place[0] * by[1] - place[1] * by[0];
    const int at[6][2] = {{0, 0}, {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}};
    add(wrench, own, 1.0, 3);
    for (int k = 0; k < 6; ++k) wrench[3 + k] += turning[at[k][0]] * by[at[k][1]] / speed;
    /* by mu_a, mu_b and alpha: M^T moves, and so does the direction of M v */
    const double toward[3][4] = {{n[0] / mu_a, 0.0, n[2] / mu_a, 0.0},
                                 {0.0, n[1] / mu_b, 0.0, n[3] / mu_b},
                                 {-n[2], -n[3], n[0], n[1]}};
    const double vx = (n[3] * p.u[0] - n[2] * p.u[1]) / det, vy = (n[0] * p.u[1] - n[1] * p.u[0]) / det;
    for (int k = all ? 0 : 2; k < 3; ++k) {
        const double *d = toward[k];
        double turns = t[0] * (d[0] * vx + d[2] * vy) + t[1] * (d[1] * vx + d[3] * vy);
        double fx = w.load * (d[0] * p.u[0] + d[1] * p.u[1]), fy = w.load * (d[2] * p.u[0] + d[3] * p.u[1]);
        const double moved[3] = {fx + turns * turning[0], fy + turns * turning[1],
                                 place[0] * fy - place[1] * fx + turns * turning[2]};
        add(by_law + 3 * k, moved, 1.0, 3);
    }
    if (all && part_of_points(r) == CORNERS) add(by_shares + 3 * (CORNERS - 1), own, 1.0 / pressure->load[CORNERS], 3);
}
