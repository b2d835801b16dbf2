/* Phases joined: how a contact goes on where it changes, and whole pushes and legs of drags. */

/* First steps to try, extents: where they are too long, the estimate of their error may flatter. */
static const double FIRST_PUSH_STEP = 0.07, FIRST_DRAG_STEP = 0.12;
/* A leg of a drag this short, extents, is none. */
static const double NO_LEG = 1e-12;
/* Spins in the ring (rad per extent of travel) against the sense of its friction that count as
   none. */
static const double TURNS_BACK = 1e-3;
enum { MOST_PHASES = 10000 };

/* How much later the variation comes to the end of a piece, at which a motion is at this row. A
   point that has just come to rest there leaves when its force comes to the cone's edge: its rate
   along the side is zero there, and changes sign; what starts beside the end leaves later by a
   root. */
static int delays(Stroke *r, Motion *m, const double *row, double *later) {
    double at[ROW], by[RATES], rate = row[SLOPE + COORDINATE], spin = row[SLOPE + THETA];
    int rests = fabs(rate) <= AT_REST;
    memcpy(at, row, sizeof at);
    if (rests && rates_vary(r, m, at, 0, by) < 0) return UNSOLVED;
    for (int i = 0; i < r->varied->count; ++i) {
        const double *w = r->varied->state + STATE_SIZE * i;
        if (!rests) {
            later[i] = -w[COORDINATE] / rate;
            continue;
        }
        double by_theta = by[STATE_SIZE * THETA + COORDINATE];
        double given = by[BY_STATE + STATE_SIZE * i + COORDINATE];
        later[i] = w[COORDINATE] != 0.0 ? NAN : -(by_theta * w[THETA] + given) / (by_theta * spin);
    }
    return 1;
}

/* Derivative by the rod's radius of its centre c in a wedge: n . c grows by one for both n. */
static void wedge_by_radius(const Stroke *r, int wedge, double *centre) {
    const double *at = piece_of(r, wedge) + PIECE_GEOMETRY;
    double first = at[WEDGE_FIRST_NORMAL], second = at[WEDGE_SECOND_NORMAL];
    double whole = 1.0 + cos(first - second);
    centre[X] = (cos(first) + cos(second)) / whole;
    centre[Y] = (sin(first) + sin(second)) / whole;
}

/* The same of the coordinate at which the piece before a wedge ends, or that after it begins. */
static double end_by_radius(const Stroke *r, int wedge, int forward) {
    const double *at = piece_of(r, wedge);
    double normal = at[PIECE_GEOMETRY + (forward ? WEDGE_SECOND_NORMAL : WEDGE_FIRST_NORMAL)];
    double centre[2];
    int kind = (int)piece_of(r, (int)at[forward ? PIECE_AFTER : PIECE_BEFORE])[PIECE_KIND];
    wedge_by_radius(r, wedge, centre);
    double along = centre[Y] * cos(normal) - centre[X] * sin(normal);
    return kind == KIND_CORNER ? along / r->object->radius : along;
}

/* Lets a wedge lie where the radius takes it: the sources of its geometry; below 0: of none. */
static void vary_wedge(const Stroke *r, int wedge) {
    double by[WEDGE_SENSE] = {0.0};
    if (!r->varied || r->object->radius == 0.0) return;
    if (wedge >= 0) wedge_by_radius(r, wedge, by + WEDGE_X);
    for (int forward = 0; forward < 2 && wedge >= 0; ++forward) {
        int piece = (int)piece_of(r, wedge)[forward ? PIECE_AFTER : PIECE_BEFORE];
        /* the normal of a corner is its coordinate */
        if ((int)piece_of(r, piece)[PIECE_KIND] == KIND_CORNER)
            by[WEDGE_FIRST_NORMAL + forward] = end_by_radius(r, wedge, forward);
    }
    double (*source)[MOST_VARIED] = r->varied->source;
    for (int k = 0; k < r->varied->count; ++k)
        for (int i = 0; i < WEDGE_SENSE; ++i)
            source[SOURCE_GEOMETRY_0 + i][k] = by[i] * source[SOURCE_RADIUS][k];
}

/* Takes another motion at a state; where rates jump, it counts how much later the variation comes
   there; the coordinate goes on by `ratio`. By the radius the ends of the old and the new piece
   move as told. */
static int change_motion(Stroke *r, Motion *m, Motion following, const double *end,
                         const double *state, double ratio, double old_end, double new_end) {
    double row[ROW], report[REPORT], later[MOST_VARIED];
    Variation *v = r->varied;
    for (int i = 0; v && i < v->count; ++i)
        v->state[STATE_SIZE * i + COORDINATE] -= old_end * v->source[SOURCE_RADIUS][i];
    int found = v ? delays(r, m, end, later) : NOTHING;
    *m = following;
    if (!v) return NOTHING;
    if (found < 0 || (found = evaluate(r, m, state, row, report)) < 0) return found;
    for (int i = 0; i < v->count; ++i) {
        double *w = v->state + STATE_SIZE * i;
        const double *before = end + SLOPE, *after = row + SLOPE;
        w[THETA] += (before[THETA] - after[THETA]) * later[i];
        w[COORDINATE] = w[COORDINATE] * ratio
                        + (before[COORDINATE] * ratio - after[COORDINATE]) * later[i]
                        + new_end * v->source[SOURCE_RADIUS][i];
    }
    return NOTHING;
}

/* Whether a rod in a wedge that keeps the contact of one piece alone moves away along it; then with
   that motion. */
static int leaves_along(Stroke *r, Motion *m, int piece, int forward, double theta) {
    const double *at = piece_of(r, piece);
    double state[] = {theta, at[forward ? PIECE_LOW : PIECE_HIGH]}, row[ROW], report[REPORT];
    *m = motion_of(r, STICK, piece, 0.0, 0.0);
    if (touch_of(r, m, state).approach <= 0.0 || first_motion(r, m, state) < 0) return 0;
    if (evaluate(r, m, state, row, report) < 0) return 0;
    /* a point that sticks to one side of a vertex sticks to both: its rate is zero */
    double rate = row[SLOPE + COORDINATE];
    return report[NORMAL_FORCE] >= 0.0 && (forward ? rate > 0.0 : rate < 0.0);
}

/* Whether the object turns about a rod in a wedge in a sense, against the friction of both
   contacts. */
static int turns_about(Stroke *r, Motion *m, int wedge, int mode, double theta) {
    double state[] = {theta, 0.0}, still[UNKNOWN_SIZE] = {0.0}, row[ROW], report[REPORT];
    *m = motion_of(r, mode, wedge, 0.0, 0.0);
    iterate(r, m, state, still, row, report);
    if (r->object->radius > 0.0 && !(SIGN[mode] * report[RESIDUAL] < 0.0)) return 0;
    if (evaluate(r, m, state, row, report) < 0) return 0;
    if (r->object->radius > 0.0 && SIGN[mode] * m->z[SPIN] < 0.0) {
        Search s = {r, m, state, row, report, 0.0, 0.0, {0.0, 0.0}};
        if (vanishes(torque_at, &s, 0.0, m->z + SPIN) != 1 || SIGN[mode] * m->z[SPIN] < 0.0)
            return 0;
        iterate(r, m, state, m->z, row, report);
    }
    return row[MARGIN + FIRST] >= 0.0 && row[MARGIN + SECOND] >= 0.0;
}

/* Whether a notch locks itself: two forces along the line through both contacts are in both cones,
   so that squeezing holds any load. */
static int locks(const Stroke *r, int wedge, double theta) {
    double state[] = {theta, 0.0};
    Motion m = motion_of(r, WEDGE_STUCK, wedge, 0.0, 0.0);
    Begun b;
    begin(r, &m, state, m.z, &b);
    const double *f = b.frame;
    double cosine = f[FRAME_COSINE] * f[FRAME_SECOND_COSINE] + f[FRAME_SINE] * f[FRAME_SECOND_SINE];
    return acos(-fmin(fmax(cosine, -1.0), 1.0)) <= 2.0 * atan(r->friction);
}

/* Whether the friction of both contacts can hold the object in translation. Of the tangential force
   x at the first contact the other forces are linear; the cones leave an interval of it. */
static int is_held_in(Stroke *r, Motion *m, int wedge, double theta) {
    double state[] = {theta, 0.0}, friction[FRICTION_SIZE], mu = r->friction;
    double radius = r->object->radius;
    double low = -INFINITY, high = INFINITY;
    if (radius == 0.0) return locks(r, wedge, theta);
    Begun b;
    *m = motion_of(r, WEDGE_STUCK, wedge, 0.0, 0.0);
    begin(r, m, state, m->z, &b);
    friction_on(r, state, &b, &r->is_far, 0, friction);
    const double *f = b.frame, c1 = f[FRAME_COSINE], s1 = f[FRAME_SINE];
    double c2 = f[FRAME_SECOND_COSINE], s2 = f[FRAME_SECOND_SINE], det = c1 * s2 - s1 * c2;
    double gx = friction[FORCE_X] + f[FRAME_FORCE_X], gy = friction[FORCE_Y] + f[FRAME_FORCE_Y];
    double torque = friction[TORQUE] + f[FRAME_TORQUE];
    double turn = (f[FRAME_Y] * gx - f[FRAME_X] * gy + torque) / radius;
    /* -N1 n1 + x t1 - N2 n2 - (x + turn) t2 = g, of each contact N = fixed + slope x */
    double zero_x = gx - turn * s2, zero_y = gy + turn * c2, by_x = s1 - s2, by_y = c2 - c1;
    double fixed[] = {(zero_y * c2 - zero_x * s2) / det, (s1 * zero_x - c1 * zero_y) / det};
    double slope[] = {(by_y * c2 - by_x * s2) / det, (s1 * by_x - c1 * by_y) / det};
    for (int k = 0; k < 2; ++k)
        for (int sign = -1; sign <= 1; sign += 2) {
            /* mu N - sign T >= 0, T = x or -(x + turn) */
            double a = mu * fixed[k] + (k ? sign * turn : 0.0);
            double c = mu * slope[k] + (k ? sign : -sign);
            if (c > 0.0)
                low = fmax(low, -a / c);
            else if (c < 0.0)
                high = fmin(high, -a / c);
            else if (a < 0.0)
                return 0;
        }
    return low <= high;
}

/* A rod that comes into a wedge, where it touches two pieces: which motion goes on from there. Of
   several the one without forces inside the wedge that nothing has built up. */
static int enter_wedge(Stroke *r, Motion *m, int wedge, const double *end, double *state) {
    const double *at = piece_of(r, wedge);
    int first = r->object->radius > 0.0 ? WEDGE_LEFT : WEDGE_RIGHT, count = 0;
    int is_forward = m->piece == (int)at[PIECE_BEFORE];
    double coordinate = 0.0, new_end = 0.0;
    Motion next, tried;
    r->is_wedged = 1;
    for (int forward = 1; forward >= 0; --forward) {
        int piece = (int)at[forward ? PIECE_AFTER : PIECE_BEFORE];
        if (!leaves_along(r, &tried, piece, forward, state[THETA]) || count++) continue;
        coordinate = piece_of(r, piece)[forward ? PIECE_LOW : PIECE_HIGH];
        new_end = end_by_radius(r, wedge, forward);
        next = tried;
    }
    for (int mode = first; mode <= WEDGE_RIGHT; ++mode)
        if (turns_about(r, &tried, wedge, mode, state[THETA]) && !count++) next = tried;
    if (is_held_in(r, &tried, wedge, state[THETA]) && !count++)
        next = motion_of(r, WEDGE_STUCK, wedge, 0.0, 0.0);
    if (!count) return NOT_ALONE;
    if (count > 1) r->is_ambiguous = 1;
    state[COORDINATE] = coordinate;
    double old_end = end_by_radius(r, wedge, !is_forward);
    int found = change_motion(r, m, next, end, state, 0.0, old_end, new_end);
    if (place_of(m) == AT_WEDGE) vary_wedge(r, wedge);
    return found;
}

/* A rod in a wedge loses one of both contacts, and goes on along the piece of the other one, in the
   same sense. */
static int leave_wedge(Stroke *r, Motion *m, double *state, int forward) {
    int piece = (int)piece_of(r, m->piece)[forward ? PIECE_AFTER : PIECE_BEFORE];
    int left = m->mode == WEDGE_LEFT;
    double end = end_by_radius(r, m->piece, forward);
    for (int k = 0; r->varied && k < r->varied->count; ++k)
        r->varied->state[STATE_SIZE * k + COORDINATE] = end * r->varied->source[SOURCE_RADIUS][k];
    vary_wedge(r, -1);
    double spin = m->z[SPIN], coordinate = piece_of(r, piece)[forward ? PIECE_LOW : PIECE_HIGH];
    if (leaves_along(r, m, piece, forward, state[THETA])) {
        state[COORDINATE] = coordinate;
        return NOTHING;
    }
    state[COORDINATE] = coordinate;
    Motion next = motion_of(r,
                            r->friction == 0.0 ? SLIDE_FREE
                            : left             ? SLIDE_LEFT
                                               : SLIDE_RIGHT,
                            piece, 0.0, 0.0);
    Touch touch = touch_of(r, &next, state);
    if (touch.approach <= 0.0) return LEFT;
    next.z[SPIN] = spin / touch.approach;
    next.z[SLIP] = (touch.along - spin * r->object->radius) / touch.approach;
    *m = next;
    return NOTHING;
}

/* Carries state and variation to the next piece: the same mode goes on there; a point that passes a
   corner starts anew, its normal having jumped, or leaves. What the last step overshot is carried
   over at the same speed. */
static int cross(Stroke *r, Motion *m, const double *end, double *state, int forward) {
    const double *old = piece_of(r, m->piece);
    int next = (int)old[forward ? PIECE_AFTER : PIECE_BEFORE];
    const double *new = piece_of(r, next);
    if ((int)new[PIECE_KIND] == KIND_WEDGE) return enter_wedge(r, m, next, end, state);
    Motion following = motion_of(r, m->mode, next, m->z[SPIN], m->z[SLIP]);
    double edge_old = old[forward ? PIECE_HIGH : PIECE_LOW];
    double edge_new = new[forward ? PIECE_LOW : PIECE_HIGH];
    double at_old[] = {state[THETA], edge_old}, at_new[] = {state[THETA], edge_new};
    Touch before = touch_of(r, m, at_old), after = touch_of(r, &following, at_new);
    double ratio = before.metric / after.metric;
    if (r->object->radius == 0.0 && after.approach <= 0.0) return LEFT;
    state[COORDINATE] = edge_new + (state[COORDINATE] - edge_old) * ratio;
    if (r->object->radius == 0.0) {
        int found = first_motion(r, &following, state);
        if (found < 0) return found;
    }
    return change_motion(r, m, following, end, state, ratio, 0.0, 0.0);
}

/* The end of its side that a point stands on and is about to slide over, else NOTHING; or why it
   cannot be told. */
static int slides_off(Stroke *r, Motion *m, const double *state, double *row) {
    const double *on = piece_of(r, m->piece);
    double report[REPORT];
    if (r->object->radius > 0.0 || !slides(m)) return NOTHING;
    int low = state[COORDINATE] - on[PIECE_LOW] <= AT_END;
    int high = on[PIECE_HIGH] - state[COORDINATE] <= AT_END;
    if (!low && !high) return NOTHING;
    int found = evaluate(r, m, state, row, report);
    if (found < 0) return found;
    double sense = m->mode == SLIDE_FREE ? row[SLOPE + COORDINATE] : SIGN[m->mode];
    return low && sense < 0.0 ? AFTER_LOW : high && sense > 0.0 ? BEFORE_HIGH : NOTHING;
}

/* A straight push: why it ended; m, state and last are those of its end. */
static int run_push(Stroke *r, Motion *m, double *state, double length, double *travel,
                    Step *last) {
    double h = FIRST_PUSH_STEP, left = length, done;
    int found = first_motion(r, m, state);
    if (found < 0) return found;
    for (int phase = 0; phase < MOST_PHASES; ++phase) {
        int broken = phase > 0 ? slides_off(r, m, state, last->rows[STAGES]) : NOTHING;
        done = 0.0;
        if (broken == NOTHING) broken = integrate(r, m, state, left, &h, &done, last);
        if (broken < 0 && broken != NOTHING) return broken;
        *travel += done;
        left -= done;
        if (broken == NOTHING || broken == APPROACH || left <= 1e-14 * length)
            return broken == APPROACH ? LEFT : DISTANCE;
        if (broken == AFTER_LOW || broken == BEFORE_HIGH) {
            found = cross(r, m, last->rows[STAGES], state, broken == BEFORE_HIGH);
            if (found != NOTHING) return found;
        } else if (place_of(m) == AT_WEDGE) {
            found = leave_wedge(r, m, state, broken == FIRST);
            if (found != NOTHING) return found;
        } else if ((found = other_mode(r, m, state, broken)) < 0)
            return found;
    }
    return CHATTERS;
}

/* One leg in the ring. Where its friction does not hold the object there is a spin in its sense,
   since from rest to the fastest spin the torque changes sign. */
static int run_leg(Stroke *r, Motion *m, double *state, double length, double *travel, Step *last) {
    double h = FIRST_DRAG_STEP, row[ROW], report[REPORT];
    *m = motion_of(r, ring_mode(r, m, state), m->piece, 0.0, 0.0);
    if (m->mode == RING_STUCK) {
        evaluate(r, m, state, last->rows[STAGES], report);
        int64_t samples = r->record ? (int64_t)fmin(ceil(length / r->longest), 1e6) : 0, found = 1;
        if (r->record && samples < 1) samples = 1;
        for (int64_t k = 0; found >= 0 && k <= samples && r->record; ++k) {
            r->record->travelled = length * (double)k / (double)samples;
            found = record(r, m, last->rows[STAGES]);
        }
        *travel += length;
        return found < 0 ? (int)found : DISTANCE;
    }
    int found = evaluate(r, m, state, row, report);
    if (found >= 0 && SIGN[m->mode] * m->z[SPIN] < 0.0) {
        Search s = {r, m, state, row, report, 0.0, 0.0, {0.0, 0.0}};
        found = vanishes(torque_at, &s, 0.0, m->z + SPIN);
    }
    if (found >= 0) found = integrate(r, m, state, length, &h, travel, last);
    /* where the spin has ended, what is left is that the ring holds the object */
    if (found == UNSOLVED && ring_mode(r, m, state) == RING_STUCK) return RING_STOPS;
    if (found != NOTHING) return found;
    return SIGN[m->mode] * m->z[SPIN] < -TURNS_BACK ? RING_STOPS : DISTANCE;
}
