/* Pushes and drags in the world, and whole cycles: a push, and the drag back by the ring; with their derivatives.
   Lengths in extents. */

/* What is done again and again with one object. */
typedef struct {
    Object object;
    int64_t start_piece;
    double start_coordinate, by_fraction; /* where the rod first touches, and the derivative of that by the fraction */
    double direction, length;             /* of the push, as seen from the object or from the world; length 0: none */
    double rod_friction, pin_friction;
    int64_t with_object;                  /* whether the push's direction turns with the object */
    int64_t goal_count;                   /* of the drag; 0: none */
    const double *goals;
} Loop;

enum { TASK_LOOP, TASK_POSE, TASK_COLUMNS = 4 };
/* Results: status (1: done, below 0: why not), whether the rod left, travel and pose after the push, pose at the end,
   the ring's way. Derivatives are those of the last seven. */
enum { DONE, HAS_LEFT, TRAVEL, PUSHED, ENDED = 6, WAY = 9, RESULT_COLUMNS, OUTPUTS = 7 };
/* What a cycle is differentiated by; the first alone where only the map's slope is asked for. */
enum { BY_THETA, BY_MU_A, BY_ROD_FRICTION = 6, BY_RADIUS, BY_FRACTION, BY_ANGLE, BY_DISTANCE, BY_HITCH, BY_SHARES = 13,
       BY_PIN = 16, BY_ALL };

/* An object on its way: place of its origin, orientation, and how both vary: columns (x, y, theta). */
typedef struct { double place[2], theta, by[3 * MOST_VARIED]; int count; } Body;

static void turned(double angle, const double *vector, double *result) {
    double c = cos(angle), s = sin(angle);
    result[0] = c * vector[0] - s * vector[1];
    result[1] = s * vector[0] + c * vector[1];
}

/* What a parameter's own derivative is where it is the one that column k varies, and it varies at all. */
static double one(const Loop *loop, int k, int which, int own) {
    return k == which && (loop->with_object || !own) ? 1.0 : 0.0;
}

/* Variation of the motion's parameters that pushes and drags share. */
static void set_sources(const Loop *loop, Variation *v) {
    memset(v->source, 0, sizeof v->source);
    for (int k = 0; k < v->count; ++k) {
        for (int j = 0; j < 5; ++j) v->source[SOURCE_MU_A + j][k] = one(loop, k, BY_MU_A + j, 0);
        for (int j = 0; j < SHARES; ++j) v->source[VARIED + j][k] = one(loop, k, BY_SHARES + j, 0);
    }
}

/* The rod's centre seen from the object's origin, in the world's axes; by the state and by the radius. */
static void rod_centre(const Stroke *r, const Motion *m, const double *state, double *centre, double *by_theta,
                       double *by_coordinate, double *by_radius) {
    Begun b;
    begin(r, m, state, m->z, &b);
    const double *f = b.frame, normal[] = {f[5], f[6]};
    const double radius = m->mode < RING ? m->p[1] : 0.0; /* ring and wedge hold the rod's centre itself */
    const double own[] = {f[3] + radius * normal[0], f[4] + radius * normal[1]};
    turned(state[0], own, centre);
    turned(state[0], normal, by_radius);
    by_theta[0] = -centre[1];
    by_theta[1] = centre[0];
    by_coordinate[0] = -f[9] * by_radius[1];
    by_coordinate[1] = f[9] * by_radius[0];
}

/* Derivative of the normal's angle by the coordinate. */
static double normal_slope(const Stroke *r, const Motion *m, double coordinate) {
    int kind = kind_of(r, m);
    double c = cos(coordinate), s = sin(coordinate), a = m->p[10], b = m->p[11];
    return kind == KIND_CORNER ? 1.0 : kind == KIND_ELLIPSE ? a * b / (a * a * s * s + b * b * c * c) : 0.0;
}

/* The push: moves the object; LEFT, DISTANCE, or why not. */
static int push_object(const Loop *loop, Body *body, double *travel, const volatile int64_t *stop, Record *record) {
    Stroke r = {.object = &loop->object, .direction = loop->direction + (loop->with_object ? body->theta : 0.0),
                .friction = loop->rod_friction, .longest = record ? record->longest : INFINITY, .pinned = -1, .stop = stop,
                .record = record};
    double state[] = {body->theta, loop->start_coordinate};
    double before[2], after[2], by_theta[2], by_coordinate[2], by_radius[2], by_before[2 * MOST_VARIED];
    Variation v = {.count = body->count};
    Motion m = motion_of(&r, STICK, (int)loop->start_piece, 0.0, 0.0);
    rod_centre(&r, &m, state, before, by_theta, by_coordinate, by_radius);
    for (int k = 0; record && k < 2; ++k) record->start[k] = body->place[k] + before[k];
    if (v.count) {
        double turning = normal_slope(&r, &m, state[1]);
        set_sources(loop, &v);
        r.varied = &v;
        for (int k = 0; k < v.count; ++k) {
            double along = loop->by_fraction * one(loop, k, BY_FRACTION, 1), wider = one(loop, k, BY_RADIUS, 1);
            double *now = v.state + 2 * k, *by = body->by + 3 * k;
            now[0] = by[2];
            now[1] = along;
            v.source[SOURCE_DIRECTION][k] = (loop->with_object ? by[2] : 0.0) + one(loop, k, BY_ANGLE, 1) + turning * along;
            v.source[SOURCE_RADIUS][k] = wider;
            v.source[SOURCE_SMU][k] = one(loop, k, BY_ROD_FRICTION, 0);
            for (int c = 0; c < 2; ++c)
                by_before[2 * k + c] = by_theta[c] * now[0] + by_coordinate[c] * now[1] + by_radius[c] * wider;
        }
    }
    Step last = {0};
    int64_t first = m.piece;
    int ended = run_push(&r, &m, state, loop->length, travel, &last);
    if (ended < 0) return ended;
    double toward[] = {cos(r.direction), sin(r.direction)};
    rod_centre(&r, &m, state, after, by_theta, by_coordinate, by_radius);
    const double *slope = last.rows[STAGES] + SLOPE;
    double turning = v.count ? normal_slope(&r, &m, state[1]) : 0.0, rate = slope[0] + turning * slope[1];
    int at_corner = ended == LEFT && loop->object.radius == 0.0 && last.rows[STAGES][MARGIN + APPROACH] > 1e-6;
    double later[MOST_VARIED];
    if (v.count && at_corner && delays(&r, &m, last.rows[STAGES], later) < 0) return UNSOLVED;
    for (int k = 0; k < v.count; ++k) {
        double *now = v.state + 2 * k, *by = body->by + 3 * k, by_travel = one(loop, k, BY_DISTANCE, 1);
        double by_direction = v.source[SOURCE_DIRECTION][k], wider = v.source[SOURCE_RADIUS][k];
        /* a rod leaves where the angle from its direction to the normal is a right one; a point, over a corner */
        if (ended == LEFT)
            by_travel = at_corner ? later[k] : -(now[0] + turning * now[1] - by_direction) / rate;
        now[0] += slope[0] * by_travel;
        now[1] += slope[1] * by_travel;
        const double sideways[] = {-toward[1], toward[0]};
        /* added to where it starts as one number: wherever that is, the push is the same to the bit */
        for (int c = 0; c < 2; ++c)
            by[c] += by_before[2 * k + c] + toward[c] * by_travel + *travel * sideways[c] * by_direction
                     - (by_theta[c] * now[0] + by_coordinate[c] * now[1] + by_radius[c] * wider);
        by[2] = now[0];
        /* a point skips the arc that every thicker rod goes around; where wedges lie by the radius is not followed */
        if (wider != 0.0 && (r.is_wedged || (loop->object.radius == 0.0 && (m.piece != first || at_corner))))
            by[0] = by[1] = by[2] = NAN;
    }
    for (int c = 0; c < 2; ++c) body->place[c] += before[c] + *travel * toward[c] - after[c];
    body->theta = state[0];
    return ended;
}

/* The drag through all goals, the ring ending at the last; returns 1 or why not. */
static int drag_object(const Loop *loop, Body *body, double *way, double *by_way, const volatile int64_t *stop,
                       Record *record) {
    const Object *o = &loop->object;
    const double *hitch = o->pieces + o->piece_count * PIECE_COLUMNS + PIECE_GEOMETRY, unit[2][2] = {{1, 0}, {0, 1}};
    double lever[2], by_ring[2 * MOST_VARIED], ring[2], moved = 0.0;
    turned(body->theta, hitch, lever);
    for (int c = 0; c < 2; ++c) ring[c] = body->place[c] + lever[c];
    for (int k = 0; k < body->count; ++k) {
        double *by = body->by + 3 * k, across[2] = {0.0, 0.0};
        if (k == BY_HITCH || k == BY_HITCH + 1) turned(body->theta, unit[k - BY_HITCH], across);
        by_ring[2 * k] = by[0] - lever[1] * by[2] + across[0];
        by_ring[2 * k + 1] = by[1] + lever[0] * by[2] + across[1];
    }
    for (int64_t leg = 0; leg < loop->goal_count; ++leg) {
        const double *goal = loop->goals + 2 * leg, dx = goal[0] - ring[0], dy = goal[1] - ring[1], goes = hypot(dx, dy);
        if (goes <= NO_LEG) continue;
        const double toward[] = {dx / goes, dy / goes};
        double state[] = {body->theta, 0.0}, travel = 0.0;
        Stroke r = {.object = o, .direction = atan2(dy, dx), .friction = loop->pin_friction,
                    .longest = record ? record->longest : INFINITY, .pinned = -1, .stop = stop, .record = record};
        Variation v = {.count = body->count};
        if (record) {
            record->stroke = leg + 1.0;
            record->travelled = 0.0;
            memcpy(record->start, ring, sizeof ring);
        }
        if (v.count) {
            set_sources(loop, &v);
            r.varied = &v;
            for (int k = 0; k < v.count; ++k) {
                v.state[2 * k] = body->by[3 * k + 2];
                v.state[2 * k + 1] = 0.0;
                v.source[SOURCE_DIRECTION][k] = (toward[1] * by_ring[2 * k] - toward[0] * by_ring[2 * k + 1]) / goes;
                v.source[SOURCE_SMU][k] = one(loop, k, BY_PIN, 0);
                for (int c = 0; c < 2; ++c) v.source[SOURCE_GEOMETRY + c][k] = one(loop, k, BY_HITCH + c, 0);
            }
        }
        Motion m = motion_of(&r, RING, (int)o->piece_count, 0.0, 0.0);
        Step last = {0};
        int ended = run_leg(&r, &m, state, goes, &travel, &last);
        if (ended < 0) return ended;
        for (int k = 0; k < v.count; ++k) {
            double longer = -(toward[0] * by_ring[2 * k] + toward[1] * by_ring[2 * k + 1]);
            body->by[3 * k + 2] = v.state[2 * k] + last.rows[STAGES][SLOPE] * longer;
            by_way[k] += longer;
            by_ring[2 * k] = by_ring[2 * k + 1] = 0.0;
        }
        body->theta = state[0];
        *way += goes;
        moved = 1.0;
        memcpy(ring, goal, sizeof ring);
    }
    if (moved == 0.0) return 1;
    turned(body->theta, hitch, lever);
    for (int c = 0; c < 2; ++c) body->place[c] = ring[c] - lever[c];
    for (int k = 0; k < body->count; ++k) {
        double *by = body->by + 3 * k, across[2] = {0.0, 0.0};
        if (k == BY_HITCH || k == BY_HITCH + 1) turned(body->theta, unit[k - BY_HITCH], across);
        by[0] = lever[1] * by[2] - across[0];
        by[1] = -lever[0] * by[2] - across[1];
    }
    return 1;
}

static void write_body(const Body *body, double *pose, double *by, int count) {
    const double values[] = {body->place[0], body->place[1], body->theta};
    memcpy(pose, values, sizeof values);
    for (int i = 0; by && i < 3; ++i)
        for (int k = 0; k < count; ++k) by[i * count + k] = body->by[3 * k + i];
}

/* One task: a row of RESULT_COLUMNS, and derivatives (OUTPUTS, count); those of the pose it starts from: (3, count). */
static int run_task(const Loop *loop, const double *task, const double *varied, int count, double *result, double *by,
                    const volatile int64_t *stop, Record *record) {
    Body body = {.theta = task[TASK_POSE + 2], .count = count};
    memcpy(body.place, task + TASK_POSE, sizeof body.place);
    for (int k = 0; varied && k < count; ++k)
        for (int i = 0; i < 3; ++i) body.by[3 * k + i] = varied[i * count + k];
    int left = DISTANCE, done = 1;
    if (loop->length > 0.0) left = push_object(loop, &body, result + TRAVEL, stop, record);
    if (left < 0 || !isfinite(body.theta)) return left < 0 ? left : UNSOLVED;
    result[HAS_LEFT] = left;
    write_body(&body, result + PUSHED, by, count);
    if (loop->goal_count) done = drag_object(loop, &body, result + WAY, by ? by + 6 * count : 0, stop, record);
    if (done < 0 || !isfinite(body.theta)) return done < 0 ? done : UNSOLVED;
    write_body(&body, result + ENDED, by ? by + 3 * count : 0, count);
    return 1;
}

/* Runs tasks (TASK_COLUMNS) off a queue that threads share (the next one to run) into rows of results and derivatives
   by the first `count` parameters, by which their poses vary so (3, count); until one of them sets `stop`. */
EXPORT void cm_run(const Loop *loops, const double *tasks, const double *varied, int64_t tasks_count, int64_t count,
                   double *results, double *derivatives, int64_t *queue, int64_t *stop) {
    while (!*(volatile int64_t *)stop) {
        int64_t i = __atomic_fetch_add(queue, 1, __ATOMIC_RELAXED);
        if (i >= tasks_count) return;
        const double *task = tasks + TASK_COLUMNS * i;
        double *result = results + RESULT_COLUMNS * i, *by = count ? derivatives + OUTPUTS * count * i : 0;
        memset(result, 0, RESULT_COLUMNS * sizeof(double));
        if (count) memset(by, 0, OUTPUTS * count * sizeof(double));
        int status = run_task(loops + (int64_t)task[TASK_LOOP], task, varied + 3 * count * i, (int)count, result, by, stop, 0);
        result[DONE] = status;
        if (status > 0) continue;
        for (int k = TRAVEL; k < RESULT_COLUMNS; ++k) result[k] = NAN;
        for (int k = 0; k < OUTPUTS * count; ++k) by[k] = NAN;
    }
}

/* Runs one task and writes down its course, in steps no longer than `longest`; returns the number of rows, or below 0
   why there is none. */
EXPORT int64_t cm_record(const Loop *loop, const double *task, double longest, double *rows, int64_t room) {
    Record record = {.room = room, .rows = rows, .longest = longest};
    double result[RESULT_COLUMNS] = {0.0};
    int status = run_task(loop, task, 0, 0, result, 0, 0, &record);
    return status < 0 ? status : record.count;
}

/* For a test that Python reads what is written here: sizes of a loop, and of rows of tasks, results, derivatives, records. */
EXPORT const int64_t cm_layout[] = {sizeof(Loop), TASK_COLUMNS, RESULT_COLUMNS, OUTPUTS, RECORD_COLUMNS, BY_ALL,
                                    ROW_COLUMNS, PARTS, PIECE_COLUMNS};

EXPORT const char *cm_version(void) { return ENGINE_VERSION; }
