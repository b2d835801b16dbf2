/* One phase: which way a contact moves, and that motion integrated until the contact changes, which
   it lands on. */

/* A margin this share of the tolerance's root below zero still counts as kept, and a place where
   one is that near to zero as landed on: rates are continuous from one law to the next, so that
   what is wrong is of its square. Where rates jump (a rod that leaves while it sticks, a point that
   passes a corner) it is this share of the tolerance itself. */
static const double SLACK_SHARE = 0.03, STRICT_SHARE = 0.1;
/* What a side's ends are told by, extents: their rounding; and speeds along it, over the rod's,
   that count as none. */
static const double AT_END = 1e-14, AT_REST = 1e-9;
/* Forces may lie outside the friction cone by this, over the mean friction coefficient: far more
   than their rounding. */
static const double FORCE_SLACK = 4e-10;
/* Forces that are outside the cone by this when a slip ends tell that it reverses. */
static const double REVERSED = 1e-3;
/* A margin that dips this many slacks below zero at a stage, though not at the end, calls for a
   shorter step. */
static const double DIP = 30.0;
/* A motion that cannot go on by this much, where a margin is zero, has ended there. */
static const double STUCK = 1e-8;
/* Steps above this share of the length are made in one go or not at all: shorter ones are cheaper
   than certainty. */
static const double SHORT = 1e-5;
/* Where polar unknowns are not found in steps this short, over the length, plain ones are tried. */
static const double UNWATCHED = 1e-5;
/* Steps go no farther than this many times to where a point passes its rest. */
static const double OVERSHOOT = 1.2;
enum { NOTHING = -100, MOST_STEPS = 20000 };

/* Approach and motion along the outline of a rod that travels by one, and the curve's metric. */
typedef struct {
    double approach, along, metric;
} Touch;

static Touch touch_of(const Stroke *r, const Motion *m, const double *state) {
    Begun b;
    begin(r, m, state, m->z, &b);
    return (Touch){b.frame[FRAME_APPROACH], b.frame[FRAME_ALONG], b.frame[FRAME_METRIC]};
}

/* Slides from a motion that sticks, with the unknowns of the same twist. */
static Motion sliding(const Stroke *r, const Motion *m, const double *state, int mode) {
    Touch touch = touch_of(r, m, state);
    double approach = fmax(touch.approach, 1e-6);
    int slide = r->friction == 0.0 ? SLIDE_FREE : mode;
    return motion_of(r, slide, m->piece, m->z[SPIN] / approach, touch.along / approach);
}

/* The motion on the other side of a broken margin. A rod that stops sliding sticks; but where a
   support point stands still, the slip may reverse at once: the force that sticking needs is then
   far outside the cone. */
static int other_mode(Stroke *r, Motion *m, const double *state, int broken) {
    double row[ROW], report[REPORT];
    if (!slides(m)) {
        *m = sliding(r, m, state, broken == FIRST ? SLIDE_LEFT : SLIDE_RIGHT);
        return 1;
    }
    int reversed = m->mode == SLIDE_LEFT ? SLIDE_RIGHT : SLIDE_LEFT;
    Touch touch = touch_of(r, m, state);
    *m = motion_of(r, STICK, m->piece, touch.approach * m->z[SPIN], 0.0);
    int found = evaluate(r, m, state, row, report);
    if (found < 0) return found;
    if (count_of_points(r) && fmin(row[MARGIN + FIRST], row[MARGIN + SECOND]) < -REVERSED)
        *m = sliding(r, m, state, reversed);
    return 1;
}

/* Sticks if the force that sticking needs lies in the friction cone, else slides the way it
   points. */
static int first_motion(Stroke *r, Motion *m, const double *state) {
    double row[ROW], report[REPORT];
    *m = motion_of(r, STICK, m->piece, 0.0, 0.0);
    int found = evaluate(r, m, state, row, report);
    if (found < 0) return found;
    if (row[MARGIN + APPROACH] <= 0.0) return POINTS_AWAY;
    double first = row[MARGIN + FIRST], second = row[MARGIN + SECOND];
    if (first >= 0.0 && second >= 0.0 && r->friction > 0.0) return 1;
    return other_mode(r, m, state, first < second ? FIRST : SECOND);
}

/* How the object moves in a ring whose friction circle has a radius: a spin that depends on the
   orientation alone never changes its sign on the way, so that the mode stays. */
static int ring_mode(Stroke *r, const Motion *m, const double *state) {
    double still[UNKNOWN_SIZE] = {0.0}, row[ROW], report[REPORT];
    if (r->friction == 0.0) return RING;
    iterate(r, m, state, still, row, report);
    double torque = report[RESIDUAL];
    if (fabs(torque) <= r->friction * hypot(report[NORMAL_FORCE], report[TANGENTIAL_FORCE]))
        return RING_STUCK;
    return torque < 0.0 ? RING_LEFT : RING_RIGHT;
}

/* How far below zero each margin may go. The ends of a piece count by the curvature beyond them:
   arcs have the rod's radius. A point may come to them from rest, so that its travel is off by the
   root of what is left. */
static void set_slack(const Stroke *r, const Motion *m, double *slack) {
    double tolerance = r->object->tolerance, radius = r->object->radius;
    double strict = STRICT_SHARE * tolerance;
    for (int k = 0; k < MARGINS; ++k) slack[k] = SLACK_SHARE * sqrt(tolerance);
    slack[APPROACH] = strict;
    if (m->mode == STICK) slack[FIRST] = slack[SECOND] = FORCE_SLACK;
    if (place_of(m) == AT_WEDGE) slack[FIRST] = slack[SECOND] = FORCE_SLACK;
    if (place_of(m) != AT_OUTLINE) return;
    double loose = fmax(SLACK_SHARE * sqrt(tolerance * fmin(radius, 1.0)), strict);
    double end = radius > 0.0 ? loose : AT_END;
    slack[AFTER_LOW] = slack[BEFORE_HIGH] = kind_of(r, m) == KIND_CORNER ? end / radius : end;
}

/* Where a margin is landed on, in slacks: a contact that sticks is still inside the friction cone,
   one that slides has just come to rest, so that the force that it needs to stick is inside as
   well. */
static double goal_of(const Motion *m, int broken) {
    if (broken < FIRST || broken == RESTS) return 0.0;
    return slides(m) ? -0.5 : 0.5;
}

/* Where a stroke is written down, as long as there is room. */
struct Record {
    int64_t count, room;
    double *rows, longest, stroke, before, travelled, start[2];
};

static void turned(double angle, const double *vector, double *result) {
    double c = cos(angle), s = sin(angle), x = vector[X], y = vector[Y];
    result[X] = c * x - s * y;
    result[Y] = s * x + c * y;
}

/* Adds a contact's force: compression, and what is along the tangent as a share of it. */
static void add_force(const double *normal, double compression, double share, double *force) {
    force[X] -= compression * (normal[X] + share * normal[Y]);
    force[Y] -= compression * (normal[Y] - share * normal[X]);
}

/* The rod's force on the object, in the object's frame. In a wedge both contacts are on an edge of
   their cones. */
static void force_on(const Motion *m, const double *frame, const double *report, double *force) {
    const double normal[] = {frame[FRAME_COSINE], frame[FRAME_SINE]};
    const double second[] = {frame[FRAME_SECOND_COSINE], frame[FRAME_SECOND_SINE]};
    double smu = m->p[SMU], sense = m->p[GEOMETRY + WEDGE_SENSE];
    force[X] = force[Y] = 0.0;
    add_force(normal, report[NORMAL_FORCE], place_of(m) == AT_WEDGE ? smu : 0.0, force);
    if (place_of(m) == AT_WEDGE)
        add_force(second, report[TANGENTIAL_FORCE], smu * sense, force);
    else {
        force[X] -= report[TANGENTIAL_FORCE] * normal[Y];
        force[Y] += report[TANGENTIAL_FORCE] * normal[X];
    }
}

/* The margin that is least, in slacks. */
static int least(const double *row, const double *slack, double *value) {
    int index = 0;
    for (int k = 1; k < MARGINS; ++k)
        if (row[MARGIN + k] / slack[k] < row[MARGIN + index] / slack[index]) index = k;
    *value = row[MARGIN + index] / slack[index];
    return index;
}

/* The margin that breaks first, where, and its slope (in slacks) there, as the stages tell
   roughly. */
static void first_crossing(const Step *taken, const double *slack, int *index, double *place,
                           double *slope) {
    *place = INFINITY;
    for (int k = 0; k < MARGINS; ++k) {
        int after = 0;
        double value[PLACE_COUNT], at[PLACE_COUNT];
        for (int i = 0; i < PLACE_COUNT; ++i) {
            value[i] = taken->rows[STAGE_ORDER[i]][MARGIN + k] / slack[k];
            at[i] = STAGE_PLACES[i] * taken->h;
        }
        if (!(value[PLACE_COUNT - 1] < -1.0)) continue;
        while (!(value[after] < -1.0)) ++after;
        if (after == 0) after = 1;
        double a = fmax(value[after - 1], 0.0), b = value[after], width = at[after] - at[after - 1];
        if (at[after - 1] + width * a / (a - b) < *place) {
            *index = k;
            *place = at[after - 1] + width * a / (a - b);
            *slope = (b - a) / width;
        }
    }
}

/* Shortens a step until the first margin to break is zero: secants on its length inside a bracket;
   returns which. */
static int land(Stroke *r, Motion *m, const double *start, const double *slack, Step *taken) {
    double low = 0.0, high = taken->h, h, slope, place = NAN, before = NAN, value;
    double z[UNKNOWN_SIZE];
    memcpy(z, m->z, sizeof z);
    int broken = NOTHING, has_kept = 0;
    Step tried, kept;
    first_crossing(taken, slack, &broken, &h, &slope);
    for (int i = 0; broken != NOTHING && i < 400; ++i) {
        h = fmax(h, LEAST_ADVANCE);
        memcpy(m->z, z, sizeof z);
        int found = attempt(r, m, start, h, 0, &tried);
        if (found < 0) return found;
        if (!found) {
            high = h;
            h = 0.5 * (low + h);
            place = before = NAN;
            continue;
        }
        *taken = tried;
        double *end = taken->rows[STAGES], report[REPORT];
        if (m->mode == STICK && (broken == FIRST || broken == SECOND)) {
            /* forces count to their last digits, which coarse steps do not reach */
            memcpy(m->z, end + UNKNOWN, sizeof m->z);
            if ((found = evaluate(r, m, end, end, report)) < 0) return found;
        }
        int worst = least(end, slack, &value);
        if (end[MARGIN + broken] / slack[broken] > 1.0 && value < -1.0) {
            broken = worst;
            slope = place = before = NAN;
        }
        double margin = end[MARGIN + broken] / slack[broken] - goal_of(m, broken);
        double near = goal_of(m, broken) == 0.0 ? 1.0 : 0.5;
        if (fabs(margin) <= near || h <= LEAST_ADVANCE) return broken;
        if (high - low <= 1e-13) {
            /* it jumps here: the side where it still holds counts */
            if (has_kept) *taken = kept;
            return broken;
        }
        if (margin < 0.0)
            high = h;
        else {
            low = h;
            kept = tried;
            has_kept = 1;
        }
        if (h != place) {
            double secant = (margin - before) / (h - place);
            slope = isnan(secant) ? slope : secant;
        }
        place = h;
        before = margin;
        h = slope < 0.0 ? h - margin / slope : NAN;
        /* secants creep where a margin jumps, as it may between support points: now and then the
           bracket is halved */
        if (!(low < h && h < high) || i % 8 == 7) h = 0.5 * (low + high);
    }
    return UNSOLVED;
}

/* Writes down a motion at a row. */
static int record(Stroke *r, Motion *m, const double *row) {
    Record *to = r->record;
    if (!to) return 1;
    if (to->count == to->room) return RECORD_FULL;
    double found[ROW], report[REPORT];
    Motion at = *m;
    memcpy(at.z, row + UNKNOWN, sizeof at.z);
    int solved = evaluate(r, &at, row, found, report);
    if (solved < 0) return solved;
    Begun b;
    begin(r, &at, row, at.z, &b);
    const double *f = b.frame, own_point[] = {f[FRAME_X], f[FRAME_Y]};
    const double own_normal[] = {f[FRAME_COSINE], f[FRAME_SINE]};
    double own_force[2], force[2], point[2], normal[2];
    force_on(&at, f, report, own_force);
    turned(row[THETA], own_force, force);
    turned(row[THETA], own_point, point);
    turned(row[THETA], own_normal, normal);
    /* ring and wedge hold the rod's centre itself, which a wedge has at a radius from what it
       touches */
    double held = place_of(m) == AT_OUTLINE ? r->object->radius : 0.0;
    double touched = place_of(m) == AT_RING ? 0.0 : r->object->radius;
    const double ahead[] = {cos(r->direction), sin(r->direction)};
    double *to_row = to->rows + RECORD_COLUMNS * to->count++;
    to_row[RECORD_STROKE] = to->stroke;
    to_row[RECORD_WAY] = to->before + to->travelled;
    for (int k = X; k <= Y; ++k) {
        double rod = to->start[k] + to->travelled * ahead[k];
        to_row[RECORD_ROD + k] = rod;
        to_row[RECORD_PLACE + k] = rod - held * normal[k] - point[k];
        to_row[RECORD_TOUCH + k] = rod - touched * normal[k];
        to_row[RECORD_FORCE + k] = force[k];
    }
    to_row[RECORD_THETA] = row[THETA];
    to_row[RECORD_PIECE] = m->piece;
    to_row[RECORD_MODE] = m->mode;
    to_row[RECORD_COMPRESSION] = report[NORMAL_FORCE];
    to_row[RECORD_TANGENTIAL] = report[TANGENTIAL_FORCE];
    to_row[RECORD_RESIDUAL] = fabs(report[RESIDUAL]);
    return 1;
}

/* Whether polar unknowns no longer serve in a step: they are not found, or a contact that sticks
   has its balance from elsewhere. */
static int is_lost(const Motion *m, const Step *taken, int found, double tried, double length,
                   double tolerance) {
    if (m->watched < 0) return 0;
    if (!found) return tried <= UNWATCHED * length;
    const double *end = taken->rows[STAGES];
    return taken->error <= tolerance && end[MARGIN + RESTS] >= 0.0 && !is_watchable(m, end);
}

/* Whether the friction of a point was used up before it passed its rest. */
static int is_used_up(const Motion *m, const Step *taken) {
    const double *end = taken->rows[STAGES];
    return m->watched >= 0 && end[MARGIN + RESTS] < 0.0 && !is_watchable(m, end);
}

/* Integrates a motion over a length or until a margin falls below zero: returns which, NOTHING, or
   why it cannot. */
static int integrate_watching(Stroke *r, Motion *m, double *state, double length, double *next_h,
                              double *done, Step *taken) {
    double h = *next_h, first_h = *next_h, tolerance = r->object->tolerance, slack[MARGINS];
    double loose[MARGINS], ends[MARGINS], row[ROW], report[REPORT], value;
    int refused = 0, count = 0, is_blocked = 0, found = evaluate(r, m, state, row, report);
    set_slack(r, m, slack);
    memcpy(loose, slack, sizeof loose);
    loose[FIRST] = loose[SECOND] = SLACK_SHARE * sqrt(tolerance);
    /* the equations of a slide may end with it */
    memcpy(ends, slack, sizeof ends);
    if (slides(m)) loose[APPROACH] = ends[APPROACH] = loose[FIRST];
    if (found < 0 || (found = record(r, m, row)) < 0) return found;
    watch(r, m, row);
    m->has_tangent = m->has_reached = 0;
    for (*done = 0.0; *done < length;) {
        if (r->stop && *r->stop) return STOPPED;
        if (++r->steps > MOST_STEPS) return MANY_STEPS;
        if (h < 1e-15 * length) return UNSOLVED;
        double tried = fmin(fmin(h, length - *done), r->longest), lowest = INFINITY;
        tried = fmin(tried, OVERSHOOT * rest_ahead(r, m, row));
        int broken = NOTHING;
        found = attempt(r, m, row, tried, tried > SHORT * length, taken);
        if (found < 0) return found;
        if (is_lost(m, taken, found, tried, length, tolerance)) {
            unwatch(r, m, row);
            m->has_tangent = 0;
            is_blocked = 1;
            continue;
        }
        /* what is told beyond such a rest is void */
        if (found && is_used_up(m, taken)) found = 0;
        if (!found || !(taken->error <= tolerance)) {
            int ended = least(row, ends, &value);
            if (count && has_margins(m) && tried <= fmax(tolerance, STUCK) && value <= 1.0
                && ended != RESTS) {
                *next_h = first_h;
                return ended;
            }
            h = found ? next_length(tried, taken->error, tolerance) : 0.5 * tried;
            refused = 1;
            continue;
        }
        for (int i = 0; i <= STAGES && has_margins(m); ++i) {
            least(taken->rows[i], loose, &value);
            lowest = fmin(lowest, value);
            broken = least(taken->rows[i], slack, &value);
            if (!(value < -1.0)) broken = NOTHING;
        }
        if (broken == NOTHING && lowest < -DIP && tried > 1e-4 * length) {
            h = 0.4 * tried;
            continue;
        }
        if (broken != NOTHING && tried > LEAST_ADVANCE
            && (broken = land(r, m, row, slack, taken)) < 0)
            return broken;
        memcpy(row, taken->rows[STAGES], sizeof row);
        memcpy(m->z, row + UNKNOWN, sizeof m->z);
        m->has_tangent = 0;
        if (r->varied && (found = vary_step(r, m, taken)) < 0) return found;
        ++count;
        *done += taken->h;
        memcpy(state, row, STATE_SIZE * sizeof(double));
        if (r->record) {
            r->record->travelled += taken->h;
            if ((found = record(r, m, row)) < 0) return found;
        }
        /* a last short step says nothing about the size that the next phase can take */
        double longer = next_length(tried, taken->error, tolerance);
        if (taken->h == h) h = fmin(longer, refused ? h : INFINITY);
        refused = 0;
        *next_h = h;
        if (broken != NOTHING && broken != RESTS) return broken;
        if (length - *done <= 1e-14 * length) break;
        if (broken == RESTS) {
            if ((found = change_rest(r, m, row)) < 0) return found;
            memcpy(taken->rows[STAGES], row, sizeof row);
            /* the point's friction turns as it passes its rest, and with it the rod's force */
            broken = least(row, slack, &value);
            if (has_margins(m) && value < -1.0 && broken != RESTS) return broken;
        } else if (m->watched < 0 || !(m->rests || stays_watched(r, m, row))) {
            unwatch(r, m, row);
            if (!is_blocked) watch(r, m, row);
            is_blocked = 0;
        }
    }
    *next_h = h;
    return NOTHING;
}

/* The same, beginning and ending with plain unknowns. */
static int integrate(Stroke *r, Motion *m, double *state, double length, double *next_h,
                     double *done, Step *taken) {
    int found = integrate_watching(r, m, state, length, next_h, done, taken);
    if (found >= 0 || found == NOTHING) unwatch(r, m, taken->rows[STAGES]);
    return found;
}
