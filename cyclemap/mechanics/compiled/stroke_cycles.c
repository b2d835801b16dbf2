/* Whole cycles: the push from the ring's target and the drag back of quasi_static.py, and how they vary with the
   orientation they start from, as stroke_variation.py tells. Lengths in the loop's unit until they are results. */

/* Columns of the arrays that Python passes: loops, cycles to run, results. A loop's ring follows its pieces. */
enum { FIRST_PIECE, PIECE_COUNT, FIRST_GOAL, GOAL_COUNT, START_PIECE, START_COORDINATE, START_DIRECTION, PUSH_LENGTH,
       UNIT, STEP_TOLERANCE, PIN_FRICTION, LOOP_PARAMETERS, LOOP_COLUMNS = 22 };
enum { CYCLE_LOOP, CYCLE_THETA, CYCLE_COLUMNS };
enum { CYCLE_DONE, HAS_LEFT, PUSH_TURN, DISPLACEMENT, DRAG_TURN = 5, DRAG_LENGTH, THETA_NEXT, BY_THETA, CYCLE_RESULTS };

/* An object on its way: its origin's place and its orientation, and how they vary. */
typedef struct { double place[2], theta, by_place[2], by_theta; } Object;

static void unit_vector(double angle, double *vector) {
    vector[0] = cos(angle);
    vector[1] = sin(angle);
}

static void turned(double angle, const double *vector, double *result) {
    double c = cos(angle), s = sin(angle);
    result[0] = c * vector[0] - s * vector[1];
    result[1] = s * vector[0] + c * vector[1];
}

/* z x vector */
static void quarter(const double *vector, double *result) {
    result[0] = -vector[1];
    result[1] = vector[0];
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1]; }

/* One stroke of a loop in the direction of its parameters, from an orientation that varies as the object's. */
static Run stroke_of(const double *loop, const double *pieces, long piece_count, const double *parameters, int vary) {
    Run r = {pieces, parameters, loop[STEP_TOLERANCE], INFINITY, {0, 0, 0}, piece_count, vary, {0, 0}, -1, 0};
    return r;
}

/* The rod's centre seen from the object's origin, in the world's axes, and its derivative by the coordinate. */
static void rod_centre(const Motion *m, int kind, const double *state, double *centre, double *by_coordinate) {
    double q[EQUATION_ARGUMENTS], touch[3];
    call(m->law->arguments, state, m->p, 0, 0, q, 0);
    call(TOUCH[kind], state, m->p, 0, 0, touch, 0);
    double own[2] = {q[2] + m->p[1] * cos(q[4]), q[3] + m->p[1] * sin(q[4])};
    turned(state[0], own, centre);
    by_coordinate[0] = -touch[2] * sin(state[0] + q[4]);
    by_coordinate[1] = touch[2] * cos(state[0] + q[4]);
}

/* Variation of the travel at which a rod leaves: where the angle from its direction to the normal is a right one. */
static double later_leaving(const Motion *m, const double *state, const double *varied, const double *slope) {
    double chain[15];
    call(m->law->chain, state, m->p, 0, 0, chain, 0);
    double turning = chain[9], rate = slope[0] + turning * slope[1]; /* the normal by the coordinate */
    return rate == 0.0 ? NAN : -(varied[0] + turning * varied[1] - 1.0) / rate;
}

/* How the place of a pushed object varies, with what a rod that leaves does later. */
static void vary_push(const Run *r, const Motion *m, const double *state, const double *end_slope, double travel,
                      int left, const double *toward, const double *before, Object *object) {
    double after[2], by_coordinate[2], by_before[2], by_after[2], sideways[2];
    double by_travel = left ? later_leaving(m, state, r->varied, end_slope) : 0.0;
    double by_theta = r->varied[0] + end_slope[0] * by_travel, along = r->varied[1] + end_slope[1] * by_travel;
    rod_centre(m, (int)r->pieces[m->piece * PIECE_COLUMNS], state, after, by_coordinate);
    quarter(before, by_before);
    quarter(after, by_after);
    quarter(toward, sideways);
    for (int k = 0; k < 2; ++k)
        object->by_place[k] += by_before[k] + toward[k] * by_travel + sideways[k] * travel
                               - by_after[k] * by_theta - by_coordinate[k] * along;
    object->by_theta = by_theta;
}

/* QuasiStaticModel.push: moves the object; whether the rod left, or DECLINED. */
static int push_object(const double *loop, const double *pieces, int vary, Object *object) {
    double parameters[11], toward[2], before[2], after[2], unused[2], travel = 0.0;
    double state[2] = {object->theta, loop[START_COORDINATE]};
    memcpy(parameters, loop + LOOP_PARAMETERS, sizeof parameters);
    parameters[0] = object->theta + loop[START_DIRECTION];
    Run r = stroke_of(loop, pieces, (long)loop[PIECE_COUNT], parameters, vary);
    r.varied[0] = r.varied[2] = 1.0;
    Motion m = motion_of(&r, STICK, (int)loop[START_PIECE], 0.0, 0.0);
    Step last = {0};
    rod_centre(&m, (int)pieces[m.piece * PIECE_COLUMNS], state, before, unused);
    int left = run_push(&r, &m, state, loop[PUSH_LENGTH], &travel, &last);
    if (left == DECLINED) return DECLINED;
    unit_vector(parameters[0], toward);
    if (vary) vary_push(&r, &m, state, last.rows[STAGES] + SLOPE, travel, left, toward, before, object);
    rod_centre(&m, (int)pieces[m.piece * PIECE_COLUMNS], state, after, unused);
    for (int k = 0; k < 2; ++k) object->place[k] += before[k] + travel * toward[k] - after[k];
    object->theta = state[0];
    return left;
}

/* The parameters of a rod in the ring. */
static void leg_parameters(const double *loop, double direction, double *parameters) {
    memcpy(parameters, loop + LOOP_PARAMETERS, 11 * sizeof(double));
    parameters[0] = direction;
    parameters[1] = 0.0;
    parameters[2] = loop[PIN_FRICTION];
}

/* One leg of a drag, from the ring's place to a goal, which is where the ring is then. */
static int drag_leg(const double *loop, const double *ring_piece, int vary, const double *goal, double *ring,
                    double *by_ring, Object *object, double *length) {
    double parameters[11], way[2] = {goal[0] - ring[0], goal[1] - ring[1]}, goes = hypot(way[0], way[1]), travel = 0.0;
    double toward[2] = {way[0] / goes, way[1] / goes}, sideways[2], state[2] = {object->theta, 0.0};
    if (goes <= NO_LEG) return 0;
    leg_parameters(loop, atan2(way[1], way[0]), parameters);
    Run r = stroke_of(loop, ring_piece, 1, parameters, vary);
    quarter(toward, sideways);
    r.varied[0] = object->by_theta;
    r.varied[2] = -dot(sideways, by_ring) / goes;
    Motion m = motion_of(&r, RING, 0, 0.0, 0.0);
    Step last = {0}; /* a ring that holds the object takes no step, and does not turn it */
    if (run_leg(&r, &m, state, goes, &travel, &last) == DECLINED && m.mode != RING_STUCK) return DECLINED;
    object->theta = state[0];
    object->by_theta = r.varied[0] - last.rows[STAGES][SLOPE] * dot(toward, by_ring);
    *length += goes;
    memcpy(ring, goal, 2 * sizeof(double));
    memset(by_ring, 0, 2 * sizeof(double));
    return 0;
}

/* QuasiStaticModel.drag, through all goals, of which the last is the target. */
static int drag_object(const double *loop, const double *pieces, const double *goals, int vary, Object *object,
                       double *length) {
    const double *ring_piece = pieces + (long)loop[PIECE_COUNT] * PIECE_COLUMNS;
    const double *goal = goals + 2 * (long)loop[FIRST_GOAL];
    double lever[2], by_lever[2], ring[2], by_ring[2];
    turned(object->theta, ring_piece + GEOMETRY, lever);
    quarter(lever, by_lever);
    for (int k = 0; k < 2; ++k) {
        ring[k] = object->place[k] + lever[k];
        by_ring[k] = object->by_place[k] + by_lever[k] * object->by_theta;
    }
    for (long leg = 0; leg < (long)loop[GOAL_COUNT]; ++leg, goal += 2)
        if (drag_leg(loop, ring_piece, vary, goal, ring, by_ring, object, length) == DECLINED) return DECLINED;
    return 0;
}

/* CollectionLoop.cycle: a row of CYCLE_RESULTS; 0 where it is declined. */
static int run_cycle(const double *loop, const double *pieces, const double *goals, double theta, int vary, double *row) {
    double lever[2], moved[2], length = 0.0, unit = loop[UNIT];
    const double *own = pieces + (long)loop[FIRST_PIECE] * PIECE_COLUMNS;
    turned(theta, own + (long)loop[PIECE_COUNT] * PIECE_COLUMNS + GEOMETRY, lever);
    Object object = {{-lever[0], -lever[1]}, theta, {lever[1], -lever[0]}, 1.0};
    int left = push_object(loop, own, vary, &object);
    if (left == DECLINED) return 0;
    if (!isfinite(object.theta)) return 0;
    double pushed = object.theta, shift[2] = {object.place[0] + lever[0], object.place[1] + lever[1]};
    if (drag_object(loop, own, goals, vary, &object, &length) == DECLINED || !isfinite(object.theta)) return 0;
    turned(-theta, shift, moved);
    const double found[] = {1.0, left, pushed - theta, unit * moved[0], unit * moved[1], object.theta - pushed,
                            unit * length, object.theta, vary ? object.by_theta : NAN};
    memcpy(row, found, sizeof found);
    return 1;
}

/* Runs cycles off a queue that threads share (the next one to run), `most` of them at most, into rows of results. */
void run_cycles(const double *loops, const double *pieces, const double *goals, const double *cycles, long count,
                int vary, double *results, long *queue, long most) {
    for (long taken = 0; taken < most; ++taken) {
        long i = __atomic_fetch_add(queue, 1, __ATOMIC_RELAXED);
        if (i >= count) return;
        const double *cycle = cycles + i * CYCLE_COLUMNS, *loop = loops + (long)cycle[CYCLE_LOOP] * LOOP_COLUMNS;
        double *row = results + i * CYCLE_RESULTS;
        if (run_cycle(loop, pieces, goals, cycle[CYCLE_THETA], vary, row)) continue;
        for (int k = 0; k < CYCLE_RESULTS; ++k) row[k] = k <= HAS_LEFT ? 0.0 : NAN;
    }
}
