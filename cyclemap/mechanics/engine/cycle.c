/* Pushes and drags in the world, and whole cycles: a push, and the drag back by the ring; with
   their derivatives. Lengths in extents. */

/* Where a floor's shape that varies with the place is taken: this share of a push's way ahead,
   since the object goes about half as far as the rod; of a leg of a drag in its middle. */
static const double PUSH_SHARE = 0.25;

/* An object on its way: place of its origin, orientation, and how both vary, by columns. */
enum { POSE_X, POSE_Y, POSE_THETA, POSE };
typedef struct {
    double place[2], theta, by[POSE * MOST_VARIED];
    int count;
} Body;

/* What a parameter's own derivative is where it is the one that column k varies, and it varies at
   all. */
static double one(const Loop *loop, int k, int which, int own) {
    return k == which && (loop->with_object || !own) ? 1.0 : 0.0;
}

/* Variation of the motion's parameters that pushes and drags share. */
static void set_sources(const Loop *loop, Variation *v) {
    memset(v->source, 0, sizeof v->source);
    for (int k = 0; k < v->count; ++k) {
        for (int j = BY_MU_A; j <= BY_PHI; ++j)
            v->source[SOURCE_MU_A + j - BY_MU_A][k] = one(loop, k, j, 0);
        for (int j = 0; j < OF_PRESSURE; ++j)
            v->source[VARIED + j][k] = one(loop, k, BY_PRESSURE[j], 0);
    }
}

/* A floor's shape that varies with the place varies as the place does. */
static void move_floor(const Standing *standing, const double *by_place, Variation *v, int k) {
    if (!varies(&standing->object)) return;
    for (int s = 0; s < SHAPE_SIZE; ++s)
        v->source[SOURCE_FLOOR_DOME + s][k] +=
            standing->by[s][X] * by_place[X] + standing->by[s][Y] * by_place[Y];
}

/* The rod's centre seen from the object's origin, in the world's axes; by the state and by the
   radius. */
static void rod_centre(const Stroke *r, const Motion *m, const double *state, double *centre,
                       double *by_theta, double *by_coordinate, double *by_radius) {
    Begun b;
    begin(r, m, state, m->z, &b);
    const double *f = b.frame, normal[] = {f[FRAME_COSINE], f[FRAME_SINE]};
    /* ring and wedge hold the rod's centre itself */
    const double radius = place_of(m) == AT_OUTLINE ? m->p[RADIUS] : 0.0;
    const double own[] = {f[FRAME_X] + radius * normal[X], f[FRAME_Y] + radius * normal[Y]};
    turned(state[THETA], own, centre);
    double rising[] = {normal[X], normal[Y]};
    if (place_of(m) == AT_WEDGE) wedge_by_radius(r, m->piece, rising);
    turned(state[THETA], rising, by_radius);
    by_theta[X] = -centre[Y];
    by_theta[Y] = centre[X];
    by_coordinate[X] = -f[FRAME_METRIC] * by_radius[Y];
    by_coordinate[Y] = f[FRAME_METRIC] * by_radius[X];
}

/* Derivative of the normal's angle by the coordinate. */
static double normal_slope(const Stroke *r, const Motion *m, double coordinate) {
    int kind = kind_of(r, m);
    if (kind != KIND_ELLIPSE) return kind == KIND_CORNER ? 1.0 : 0.0;
    const double *semi = m->p + GEOMETRY;
    double c = cos(coordinate), s = sin(coordinate), a = semi[ELLIPSE_SEMI_X];
    double b = semi[ELLIPSE_SEMI_Y];
    return a * b / (a * a * s * s + b * b * c * c);
}

/* The push: moves the object, writes its part of the result; LEFT, DISTANCE, or why not. */
static int push_object(const Loop *loop, Body *body, double *result, const volatile int64_t *stop,
                       Record *record) {
    Standing standing;
    double centre[2], place[2], direction = loop->direction;
    if (loop->with_object) direction += body->theta;
    turned(body->theta, loop->object.pressure.middle, centre);
    const double ahead[] = {cos(direction), sin(direction)};
    for (int c = 0; c < 2; ++c)
        place[c] = body->place[c] + centre[c] + PUSH_SHARE * loop->length * ahead[c];
    stand(&loop->object, place, &standing);
    Stroke r = {
        .object = &standing.object,
        .pressed = &standing.pressed,
        .direction = direction,
        .friction = loop->rod_friction,
        .longest = record ? record->longest : INFINITY,
        .pinned = -1,
        .stop = stop,
        .record = record,
    };
    double state[] = {body->theta, loop->start_coordinate};
    double before[2], after[2], by_theta[2], by_coordinate[2], by_radius[2];
    double by_before[MOST_VARIED][2];
    Variation v = {.count = body->count};
    Motion m = motion_of(&r, STICK, (int)loop->start_piece, 0.0, 0.0);
    rod_centre(&r, &m, state, before, by_theta, by_coordinate, by_radius);
    for (int k = 0; record && k < 2; ++k) record->start[k] = body->place[k] + before[k];
    if (v.count) {
        double turning = normal_slope(&r, &m, state[COORDINATE]);
        set_sources(loop, &v);
        r.varied = &v;
        for (int k = 0; k < v.count; ++k) {
            double along = loop->by_fraction * one(loop, k, BY_FRACTION, 1);
            double wider = one(loop, k, BY_PUSHER_RADIUS, 1);
            double *now = v.state + STATE_SIZE * k, *by = body->by + POSE * k;
            now[THETA] = by[POSE_THETA];
            now[COORDINATE] = along;
            v.source[SOURCE_DIRECTION][k] = (loop->with_object ? by[POSE_THETA] : 0.0)
                                            + one(loop, k, BY_ANGLE, 1) + turning * along;
            v.source[SOURCE_RADIUS][k] = wider;
            v.source[SOURCE_SMU][k] = one(loop, k, BY_PUSHER_FRICTION, 0);
            double farther = PUSH_SHARE * one(loop, k, BY_DISTANCE, 1);
            double by_direction = loop->with_object ? by[POSE_THETA] : 0.0;
            by_direction += one(loop, k, BY_ANGLE, 1) + turning * along;
            double aside = PUSH_SHARE * loop->length * by_direction;
            const double moved[] = {
                by[POSE_X] - centre[Y] * by[POSE_THETA] + farther * ahead[X] - aside * ahead[Y],
                by[POSE_Y] + centre[X] * by[POSE_THETA] + farther * ahead[Y] + aside * ahead[X],
            };
            move_floor(&standing, moved, &v, k);
            for (int c = 0; c < 2; ++c)
                by_before[k][c] = by_theta[c] * now[THETA] + by_coordinate[c] * now[COORDINATE]
                                  + by_radius[c] * wider;
        }
    }
    Step last = {0};
    int64_t first = m.piece;
    int ended = run_push(&r, &m, state, loop->length, result + RESULT_TRAVEL, &last);
    if (ended < 0) return ended;
    double travel = result[RESULT_TRAVEL];
    result[RESULT_IS_AMBIGUOUS] = r.is_ambiguous;
    double toward[] = {cos(r.direction), sin(r.direction)};
    rod_centre(&r, &m, state, after, by_theta, by_coordinate, by_radius);
    const double *slope = last.rows[STAGES] + SLOPE;
    double turning = v.count ? normal_slope(&r, &m, state[COORDINATE]) : 0.0;
    double rate = slope[THETA] + turning * slope[COORDINATE];
    int at_corner =
        ended == LEFT && loop->object.radius == 0.0 && last.rows[STAGES][MARGIN + APPROACH] > 1e-6;
    double later[MOST_VARIED];
    if (v.count && at_corner && delays(&r, &m, last.rows[STAGES], later) < 0) return UNSOLVED;
    for (int k = 0; k < v.count; ++k) {
        double *now = v.state + STATE_SIZE * k, *by = body->by + POSE * k;
        double by_travel = one(loop, k, BY_DISTANCE, 1);
        double by_direction = v.source[SOURCE_DIRECTION][k], wider = v.source[SOURCE_RADIUS][k];
        /* a rod leaves where the angle from its direction to the normal is a right one; a point,
           over a corner */
        if (ended == LEFT)
            by_travel = at_corner ? later[k]
                                  : -(now[THETA] + turning * now[COORDINATE] - by_direction) / rate;
        now[THETA] += slope[THETA] * by_travel;
        now[COORDINATE] += slope[COORDINATE] * by_travel;
        const double sideways[] = {-toward[Y], toward[X]};
        /* added to where it starts as one number: wherever that is, the push is the same to the
           bit */
        for (int c = 0; c < 2; ++c)
            by[c] += by_before[k][c] + toward[c] * by_travel + travel * sideways[c] * by_direction
                     - (by_theta[c] * now[THETA] + by_coordinate[c] * now[COORDINATE]
                        + by_radius[c] * wider);
        by[POSE_THETA] = now[THETA];
        /* a point skips the arc that every thicker rod goes around, and is no shaft in a wedge:
           thin rods tell that derivative (cycle_batch.py) */
        int is_point = loop->object.radius == 0.0;
        if (wider != 0.0 && is_point && (r.is_wedged || m.piece != first || at_corner))
            by[POSE_X] = by[POSE_Y] = by[POSE_THETA] = NAN;
    }
    for (int c = 0; c < 2; ++c) body->place[c] += before[c] + travel * toward[c] - after[c];
    body->theta = state[THETA];
    return ended;
}

/* The drag through all goals, the ring ending at the last; returns 1 or why not. */
static int drag_object(const Loop *loop, Body *body, double *way, double *by_way,
                       const volatile int64_t *stop, Record *record) {
    const Object *o = &loop->object;
    const double *hitch = o->pieces + o->piece_count * PIECE_COLUMNS + PIECE_GEOMETRY;
    const double unit[2][2] = {{1, 0}, {0, 1}};
    double lever[2], by_ring[MOST_VARIED][2], ring[2], moved = 0.0;
    const double *middle = o->pressure.middle;
    const double own[] = {middle[X] - hitch[X], middle[Y] - hitch[Y]};
    turned(body->theta, hitch, lever);
    for (int c = 0; c < 2; ++c) ring[c] = body->place[c] + lever[c];
    for (int k = 0; k < body->count; ++k) {
        double *by = body->by + POSE * k, across[2] = {0.0, 0.0};
        if (k == BY_HITCH_X || k == BY_HITCH_Y) turned(body->theta, unit[k - BY_HITCH_X], across);
        by_ring[k][X] = by[POSE_X] - lever[Y] * by[POSE_THETA] + across[X];
        by_ring[k][Y] = by[POSE_Y] + lever[X] * by[POSE_THETA] + across[Y];
    }
    for (int64_t leg = 0; leg < loop->goal_count; ++leg) {
        const double *goal = loop->goals + 2 * leg, dx = goal[X] - ring[X], dy = goal[Y] - ring[Y];
        const double goes = hypot(dx, dy);
        if (goes <= NO_LEG) continue;
        const double toward[] = {dx / goes, dy / goes};
        double state[] = {body->theta, 0.0}, travel = 0.0;
        Standing standing;
        double centre[2], place[2];
        turned(body->theta, own, centre);
        for (int c = 0; c < 2; ++c) place[c] = 0.5 * (ring[c] + goal[c]) + centre[c];
        stand(o, place, &standing);
        Stroke r = {
            .object = &standing.object,
            .pressed = &standing.pressed,
            .direction = atan2(dy, dx),
            .friction = loop->pin_friction,
            .longest = record ? record->longest : INFINITY,
            .pinned = -1,
            .stop = stop,
            .record = record,
        };
        Variation v = {.count = body->count};
        if (record) {
            record->stroke = leg + 1.0;
            record->before = *way;
            record->travelled = 0.0;
            memcpy(record->start, ring, sizeof ring);
        }
        if (v.count) {
            set_sources(loop, &v);
            r.varied = &v;
            for (int k = 0; k < v.count; ++k) {
                v.state[STATE_SIZE * k + THETA] = body->by[POSE * k + POSE_THETA];
                v.state[STATE_SIZE * k + COORDINATE] = 0.0;
                v.source[SOURCE_DIRECTION][k] =
                    (toward[Y] * by_ring[k][X] - toward[X] * by_ring[k][Y]) / goes;
                v.source[SOURCE_SMU][k] = one(loop, k, BY_PIN_FRICTION_RADIUS, 0);
                v.source[SOURCE_GEOMETRY_0 + RING_X][k] = one(loop, k, BY_HITCH_X, 0);
                v.source[SOURCE_GEOMETRY_0 + RING_Y][k] = one(loop, k, BY_HITCH_Y, 0);
                double turn = body->by[POSE * k + POSE_THETA], across[2] = {0.0, 0.0};
                if (k == BY_HITCH_X || k == BY_HITCH_Y)
                    turned(body->theta, unit[k - BY_HITCH_X], across);
                const double shifted[] = {
                    0.5 * by_ring[k][X] - centre[Y] * turn - across[X],
                    0.5 * by_ring[k][Y] + centre[X] * turn - across[Y],
                };
                move_floor(&standing, shifted, &v, k);
            }
        }
        Motion m = motion_of(&r, RING, (int)o->piece_count, 0.0, 0.0);
        Step last = {0};
        int ended = run_leg(&r, &m, state, goes, &travel, &last);
        if (ended < 0) return ended;
        for (int k = 0; k < v.count; ++k) {
            double longer = -(toward[X] * by_ring[k][X] + toward[Y] * by_ring[k][Y]);
            double by_theta = v.state[STATE_SIZE * k + THETA];
            body->by[POSE * k + POSE_THETA] = by_theta + last.rows[STAGES][SLOPE + THETA] * longer;
            by_way[k] += longer;
            by_ring[k][X] = by_ring[k][Y] = 0.0;
        }
        body->theta = state[THETA];
        *way += goes;
        moved = 1.0;
        memcpy(ring, goal, sizeof ring);
    }
    if (moved == 0.0) return 1;
    turned(body->theta, hitch, lever);
    for (int c = 0; c < 2; ++c) body->place[c] = ring[c] - lever[c];
    for (int k = 0; k < body->count; ++k) {
        double *by = body->by + POSE * k, across[2] = {0.0, 0.0};
        if (k == BY_HITCH_X || k == BY_HITCH_Y) turned(body->theta, unit[k - BY_HITCH_X], across);
        by[POSE_X] = lever[Y] * by[POSE_THETA] - across[X];
        by[POSE_Y] = -lever[X] * by[POSE_THETA] - across[Y];
    }
    return 1;
}

static void write_body(const Body *body, double *pose, double *by, int count) {
    const double values[POSE] = {body->place[X], body->place[Y], body->theta};
    memcpy(pose, values, sizeof values);
    for (int i = 0; by && i < POSE; ++i)
        for (int k = 0; k < count; ++k) by[i * count + k] = body->by[POSE * k + i];
}

/* One task: a row of RESULT_COLUMNS, and derivatives (OUTPUTS, count); those of the pose it starts
   from: (3, count). */
static int run_task(const Loop *loop, const double *task, const double *varied, int count,
                    double *result, double *by, const volatile int64_t *stop, Record *record) {
    Body body = {.theta = task[TASK_POSE + POSE_THETA], .count = count};
    memcpy(body.place, task + TASK_POSE, sizeof body.place);
    for (int k = 0; varied && k < count; ++k)
        for (int i = 0; i < POSE; ++i) body.by[POSE * k + i] = varied[i * count + k];
    int left = DISTANCE, done = 1;
    if (loop->length > 0.0) left = push_object(loop, &body, result, stop, record);
    if (left < 0 || !isfinite(body.theta)) return left < 0 ? left : UNSOLVED;
    result[RESULT_HAS_LEFT] = left;
    write_body(&body, result + RESULT_PUSHED, by ? by + OUTPUT_PUSHED * count : 0, count);
    double *by_way = by ? by + OUTPUT_WAY * count : 0;
    if (loop->goal_count)
        done = drag_object(loop, &body, result + RESULT_WAY, by_way, stop, record);
    if (done < 0 || !isfinite(body.theta)) return done < 0 ? done : UNSOLVED;
    write_body(&body, result + RESULT_ENDED, by ? by + OUTPUT_ENDED * count : 0, count);
    return 1;
}

/* Runs tasks (TASK_COLUMNS) off a queue that threads share (the next one to run) into rows of
   results and derivatives by the first `count` parameters, by which their poses vary so (3, count);
   until one of them sets `stop`. */
EXPORT void cm_run(const Loop *loops, const double *tasks, const double *varied,
                   int64_t tasks_count, int64_t count, double *results, double *derivatives,
                   int64_t *queue, int64_t *stop) {
    while (!*(volatile int64_t *)stop) {
        int64_t i = __atomic_fetch_add(queue, 1, __ATOMIC_RELAXED);
        if (i >= tasks_count) return;
        const double *task = tasks + TASK_COLUMNS * i;
        double *result = results + RESULT_COLUMNS * i;
        double *by = count ? derivatives + OUTPUTS * count * i : 0;
        memset(result, 0, RESULT_COLUMNS * sizeof(double));
        if (count) memset(by, 0, OUTPUTS * count * sizeof(double));
        int status = run_task(loops + (int64_t)task[TASK_LOOP], task, varied + POSE * count * i,
                              (int)count, result, by, stop, 0);
        result[RESULT_STATUS] = status;
        if (status > 0) continue;
        for (int k = RESULT_TRAVEL; k < RESULT_COLUMNS; ++k) result[k] = NAN;
        for (int k = 0; k < OUTPUTS * count; ++k) by[k] = NAN;
    }
}

/* Runs one task and writes down its course, in steps no longer than `longest`; returns the number
   of rows, or below 0 why there is none. */
EXPORT int64_t cm_record(const Loop *loop, const double *task, double longest, double *rows,
                         int64_t room) {
    Record record = {.room = room, .rows = rows, .longest = longest};
    double result[RESULT_COLUMNS] = {0.0};
    int status = run_task(loop, task, 0, 0, result, 0, 0, &record);
    return status < 0 ? status : record.count;
}

/* For a test that Python reads what is written here: the structures, in which a compiler may leave
   gaps. */
EXPORT const int64_t cm_layout[] = {sizeof(Pressure), sizeof(Object), sizeof(Loop)};

EXPORT const char *cm_version(void) { return ENGINE_VERSION; }
