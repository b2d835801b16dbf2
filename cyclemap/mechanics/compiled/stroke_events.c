/* Phases, their ends, and whole strokes: event_integration.py and push_run.py in C. */

/* The margin that is least, in slacks. */
static int least(const double *row, const double *slack, double *value) {
    int index = 0;
    for (int k = 1; k < MARGINS; ++k)
        if (row[MARGIN + k] / slack[k] < row[MARGIN + index] / slack[index]) index = k;
    *value = row[MARGIN + index] / slack[index];
    return index;
}

static void first_crossing(const Step *taken, const double *slack, int *index, double *place, double *slope) {
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

/* Returns the margin that is zero at the end of the step, now shortened. */
static int land(Run *r, Motion *m, const double *state, const double *slack, Step *taken) {
    double low = 0.0, high = taken->h, h, slope, place = NAN, before = NAN, z[2] = {m->z[0], m->z[1]}, value;
    int broken = NOTHING;
    Step tried;
    first_crossing(taken, slack, &broken, &h, &slope);
    if (broken == NOTHING) return DECLINED;
    for (int i = 0; i < 400; ++i) {
        h = fmax(h, LEAST_ADVANCE);
        memcpy(m->z, z, sizeof z);
        int found = attempt(r, m, state, h, 0, &tried);
        if (found == DECLINED) return DECLINED;
        if (!found) {
            high = h;
            h = 0.5 * (low + h);
            place = before = NAN;
            continue;
        }
        *taken = tried;
        const double *end = taken->rows[STAGES];
        int worst = least(end, slack, &value);
        if (end[MARGIN + broken] / slack[broken] > 1.0 && value < -1.0) {
            broken = worst;
            slope = place = before = NAN;
        }
        double margin = end[MARGIN + broken] / slack[broken];
        if (fabs(margin) <= 1.0 || h <= LEAST_ADVANCE || high - low <= 1e-13) return broken;
        if (margin < 0.0) high = h;
        else low = h;
        if (h != place) {
            double secant = (margin - before) / (h - place);
            slope = isnan(secant) ? slope : secant;
        }
        place = h;
        before = margin;
        h = slope < 0.0 ? h - margin / slope : NAN;
        if (!(low < h && h < high) || i % 8 == 7) h = 0.5 * (low + high);
    }
    return DECLINED;
}

static int keep(Run *r, Motion *m, const Step *taken) {
    if (r->vary && !vary(r, m, taken)) return 0;
    if (!r->record) return 1;
    if (r->record->steps == r->record->most_steps) return 0;
    r->record->step[r->record->steps++] = *taken;
    return 1;
}

/* event_integration.integrate: the margin that ended the phase, NOTHING, or DECLINED. */
static int integrate(Run *r, Motion *m, double *state, double length, double *next_h, double *done, Step *taken) {
    double h = *next_h, first_h = *next_h, tolerance = r->tolerance, slack[MARGINS], row[ROW], report[4], value;
    long count = 0;
    int refused = 0;
    for (int k = 0; k < MARGINS; ++k) slack[k] = SLACK_SHARE * sqrt(tolerance);
    if (m->mode == STICK) slack[APPROACH] = STRICT_SHARE * tolerance;
    if (!evaluate(r, m, state, row, report)) return DECLINED;
    for (*done = 0.0; *done < length;) {
        if (count > MOST_STEPS || h < 1e-15 * length) return DECLINED;
        double tried = fmin(fmin(h, length - *done), r->longest), lowest = INFINITY;
        int found = attempt(r, m, state, tried, tried > SHORT * length, taken), broken = NOTHING;
        if (found == DECLINED) return DECLINED;
        if (!found || !(taken->error <= tolerance)) {
            int ended = least(row, slack, &value);
            if (count && tried <= fmax(tolerance, STUCK) && value <= 1.0) {
                *next_h = first_h;
                return ended;
            }
            h = found ? next_length(tried, taken->error, tolerance) : 0.5 * tried;
            refused = 1;
            continue;
        }
        for (int i = 0; i <= STAGES; ++i) {
            broken = least(taken->rows[i], slack, &value);
            lowest = fmin(lowest, value);
        }
        if (!(value < -1.0)) broken = NOTHING;
        if (broken == NOTHING && lowest < -DIP && tried > 1e-4 * length) {
            h = 0.4 * tried;
            continue;
        }
        if (broken != NOTHING && tried > LEAST_ADVANCE && (broken = land(r, m, state, slack, taken)) == DECLINED)
            return DECLINED;
        memcpy(row, taken->rows[STAGES], sizeof row);
        memcpy(m->z, row + UNKNOWN, m->law->unknowns * sizeof(double));
        if (!keep(r, m, taken)) return DECLINED;
        ++count;
        *done += taken->h;
        memcpy(state, row, 2 * sizeof(double));
        if (taken->h == h) h = fmin(next_length(tried, taken->error, tolerance), refused ? h : INFINITY);
        refused = 0;
        *next_h = h;
        if (broken != NOTHING) return broken;
        if (length - *done <= 1e-14 * length) break;
    }
    *next_h = h;
    return NOTHING;
}

/* One phase, with its record. */
static int run_phase(Run *r, Motion *m, double *state, double length, double *next_h, double *done, Step *last) {
    Record *record = r->record;
    if (!record) return integrate(r, m, state, length, next_h, done, last);
    if (record->phases == record->most_phases) return DECLINED;
    double *row = record->phase[record->phases++], start[2] = {state[0], state[1]};
    long before = record->steps;
    int broken = integrate(r, m, state, length, next_h, done, last);
    const double values[] = {m->mode, m->piece, broken, *next_h, record->steps - before, start[0], start[1]};
    memcpy(row, values, sizeof values);
    return broken;
}

static Motion other_mode(const Run *r, const Motion *m, const double *state, int broken) {
    double touch[3]; /* approach, along, metric */
    call(TOUCH[(int)r->pieces[m->piece * PIECE_COLUMNS]], state, m->p, 0, 0, touch, 0);
    if (slides(m)) return motion_of(r, STICK, m->piece, touch[0] * m->z[0], 0.0);
    int mode = r->parameters[2] == 0.0 ? SLIDE_FREE : broken == FIRST ? SLIDE_LEFT : SLIDE_RIGHT;
    double approach = fmax(touch[0], 1e-6);
    return motion_of(r, mode, m->piece, m->z[0] / approach, touch[1] / approach);
}

/* Carries state and variation to the next piece. */
static Motion across(Run *r, const Motion *m, const double *end, double *state, int forward) {
    int piece = (int)((m->piece + (forward ? 1 : r->piece_count - 1)) % r->piece_count);
    Motion following = motion_of(r, m->mode, piece, m->z[0], m->z[1]);
    double edge_old = m->p[forward ? 17 : 16], edge_new = following.p[forward ? 16 : 17], old[3], new[3];
    double at_old[2] = {state[0], edge_old}, at_new[2] = {state[0], edge_new};
    call(TOUCH[(int)r->pieces[m->piece * PIECE_COLUMNS]], at_old, m->p, 0, 0, old, 0);
    call(TOUCH[(int)r->pieces[piece * PIECE_COLUMNS]], at_new, following.p, 0, 0, new, 0);
    double ratio = old[2] / new[2], row[ROW], report[4];
    state[1] = edge_new + (state[1] - edge_old) * ratio;
    if (r->vary && evaluate(r, &following, state, row, report)) {
        /* stroke_variation._across_pieces */
        double later = -r->varied[1] / end[SLOPE + 1];
        r->varied[0] += (end[SLOPE] - row[SLOPE]) * later;
        r->varied[1] = r->varied[1] * ratio + (end[SLOPE + 1] * ratio - row[SLOPE + 1]) * later;
    }
    return following;
}

/* push_run.run_push: why it ended, 0 distance, 1 left, or DECLINED. */
static int run_push(Run *r, Motion *m, double *state, double length, double *travel, Step *last) {
    double h = FIRST_PUSH_STEP, left = length, row[ROW], report[4], done;
    if (!evaluate(r, m, state, row, report) || row[MARGIN + APPROACH] <= 0.0) return DECLINED;
    double first = row[MARGIN + FIRST], second = row[MARGIN + SECOND];
    if (!(first >= 0.0 && second >= 0.0 && r->parameters[2] > 0.0))
        *m = other_mode(r, m, state, first < second ? FIRST : SECOND);
    for (int phase = 0; phase < MOST_PHASES; ++phase) {
        int broken = run_phase(r, m, state, left, &h, &done, last);
        if (broken == DECLINED) return DECLINED;
        *travel += done;
        left -= done;
        if (broken == NOTHING || broken == APPROACH || left <= 1e-14 * length) return broken == APPROACH;
        int passes = broken == AFTER_LOW || broken == BEFORE_HIGH;
        *m = passes ? across(r, m, last->rows[STAGES], state, broken == BEFORE_HIGH) : other_mode(r, m, state, broken);
    }
    return DECLINED;
}

/* motion.ring_mode: how the object moves in a ring with friction. */
static int ring_mode(const Motion *m, const double *state, double friction) {
    double q[EQUATION_ARGUMENTS], found[5], still = 0.0;
    equation_arguments(m, state, q);
    call(m->law->solver[1], &still, q, 0, 0, found, 0);
    if (fabs(found[0]) <= friction * hypot(found[2], found[3])) return RING_STUCK;
    return found[0] < 0.0 ? RING_LEFT : RING_RIGHT;
}

/* One leg in the ring; where its friction holds the object, Python tells so. */
static int run_leg(Run *r, Motion *m, double *state, double length, double *travel, Step *last) {
    double h = FIRST_DRAG_STEP, friction = r->parameters[2];
    if (friction > 0.0) *m = motion_of(r, ring_mode(m, state, friction), 0, 0.0, 0.0);
    if (m->mode == RING_STUCK || run_phase(r, m, state, length, &h, travel, last) != NOTHING) return DECLINED;
    return SIGN[m->mode] * m->z[0] < -TURNS_BACK ? DECLINED : 0;
}

/* Runs `count` strokes, rows of STROKE_COLUMNS, into rows of RESULT_COLUMNS; `record` (may be null) of the last one. */
void run_strokes(const double *pieces, long piece_count, const double *strokes, long count, double tolerance,
                 double longest, int vary, double *results, Record *record) {
    for (long i = 0; i < count; ++i) {
        const double *stroke = strokes + i * STROKE_COLUMNS, *varied = stroke + AT_VARIED;
        Run r = {pieces, stroke + AT_PARAMETERS, tolerance, longest, {varied[0], varied[1], varied[2]}, piece_count,
                 vary, {0, 0}, -1, record};
        double *result = results + i * RESULT_COLUMNS, state[2] = {stroke[AT_THETA], stroke[AT_COORDINATE]}, travel = 0;
        Step last = {0};
        int ring = pieces[KIND] == RING_KIND, piece = (int)stroke[AT_PIECE];
        if (record) record->steps = record->phases = 0;
        Motion m = motion_of(&r, ring ? RING : STICK, piece, 0.0, 0.0);
        int ended = (ring ? run_leg : run_push)(&r, &m, state, stroke[AT_LENGTH], &travel, &last);
        const double *end = last.rows[STAGES];
        int done = ended != DECLINED && isfinite(state[0]);
        const double values[] = {done, state[0], state[1], m.piece, travel, ended, r.varied[0], r.varied[1],
                                 end[SLOPE], end[SLOPE + 1], record ? record->phases : 0};
        memcpy(result, values, sizeof values);
    }
}
