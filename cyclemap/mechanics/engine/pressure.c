/* Friction of whole footprints: what edges, lines and points of a pressure add to it, their sum,
   and its derivatives. What ellipses add is in ellipse.c. */

/* The wrench comes first in what friction is. */
enum { WRENCH = XX };

/* Sums at one twist. toward: a motion of the matrix, for derivatives of the wrench by it; else
   null. */
typedef struct {
    const double *twist, *matrix, *toward;
    const double *apart; /* the row of a support point that is left out, or null */
    double scale;        /* of patches: the area over the image's */
    double sums[6], friction[FRICTION_SIZE];
    int is_summed;
} Friction;

static void add(double *to, const double *what, double factor, int count) {
    for (int i = 0; i < count; ++i) to[i] += factor * what[i];
}

/* The image of a corner in the velocity plane, and its distance from the origin. */
static inline void image_of(const Friction *f, const double *place, double *image) {
    const double *given[] = {f->twist, f->matrix, place};
    corner(given, &image, 0, 0, 0);
}

/* Edges, leaning edges or lines, all of one kind. Slow steps of one do not wait for those of
   another. */
static void add_sides(Friction *f, const double *rows, int64_t count, double load) {
    enum { AT_ONCE = 16 };
    double corners[2 * AT_ONCE][3], sides[AT_ONCE][6], angles[AT_ONCE], found[6];
    double *results[] = {found};
    int kind = (int)rows[ROW_KIND];
    double factor = kind == LINE ? load : load * f->scale;
    f->is_summed = 1;
    for (int64_t first = 0; first < count; first += AT_ONCE) {
        const double *row = rows + first * ROW_COLUMNS, *images[AT_ONCE];
        int n = (int)(count - first < AT_ONCE ? count - first : AT_ONCE), known = 0;
        for (int i = 0; i < n; ++i) {
            const double *ends = row + i * ROW_COLUMNS + ROW_GEOMETRY;
            /* neighbours share a corner, and its image */
            const double *before = ends - ROW_COLUMNS;
            if (i == 0 || before[EDGE_END_X] != ends[EDGE_START_X]
                || before[EDGE_END_Y] != ends[EDGE_START_Y])
                image_of(f, ends, corners[known++]);
            images[i] = corners[known - 1];
            image_of(f, ends + EDGE_END_X, corners[known++]);
        }
        if (kind == EDGE) {
            for (int i = 0; i < n; ++i) {
                double *to = sides[i];
                side(images + i, &to, 0, 0, 0);
            }
            for (int i = 0; i < n; ++i) angles[i] = log1p(sides[i][5]);
        }
        for (int i = 0; i < n; ++i) {
            const double *at = row + i * ROW_COLUMNS, *more = at + ROW_GEOMETRY + LEAN_SLOPE_X;
            const double *edge_given[] = {f->matrix, sides[i], angles + i};
            const double *lean_given[] = {f->twist, f->matrix, images[i], more};
            const double *line_given[] = {f->matrix, images[i]};
            if (kind == EDGE)
                edge(edge_given, results, 0, 0, 0);
            else if (kind == LEAN)
                lean(lean_given, results, 0, 0, 0);
            else
                line(line_given, results, 0, 0, 0);
            add(f->sums, found, factor * at[ROW_LOAD], 6);
        }
    }
}

static void move_side(Friction *f, const double *row, double load) {
    double found[WRENCH], *results[] = {found};
    const double *ends = row + ROW_GEOMETRY, *lean = ends + LEAN_SLOPE_X;
    const double *lean_given[] = {f->twist, f->matrix, ends, lean, f->toward};
    const double *given[] = {f->twist, f->matrix, ends, f->toward};
    int kind = (int)row[ROW_KIND];
    if (kind == EDGE)
        edge_toward(given, results, 0, 0, 0);
    else if (kind == LEAN)
        lean_toward(lean_given, results, 0, 0, 0);
    else
        line_toward(given, results, 0, 0, 0);
    add(f->sums, found, load, WRENCH);
    f->is_summed = 1;
}

/* The sum over all lanes. */
static inline double total(const Lanes *x) {
    double sum = 0.0;
    for (int k = 0; k < LANES; ++k) sum += (*x)[k];
    return sum;
}

static inline double size_of(double x, double y) { return sqrt(x * x + y * y); }

/* Places in coordinates x of their own, from a point `at` on: w = middle + omega spin x. */
typedef struct {
    double at[2], omega, middle[2], spin[MATRIX_SIZE];
} Frame;

static Frame frame_of(const Friction *f, double at_x, double at_y, double unit_x, double unit_y) {
    const double *v = f->twist, *m = f->matrix;
    double x = v[VX] - v[OMEGA] * at_y, y = v[VY] + v[OMEGA] * at_x;
    return (Frame){{at_x, at_y},
                   v[OMEGA],
                   {m[M_XX] * x + m[M_XY] * y, m[M_YX] * x + m[M_YY] * y},
                   {m[M_XY] * unit_x, m[M_YY] * unit_x, -m[M_XX] * unit_y, -m[M_YX] * unit_y}};
}

/* Wrench and Hessian about `at`, as sums over w = |w| u, n across u: of u, u . spin x; of n n^T /
   |w|, n (n . spin x) / |w|, (n . spin x)^2 / |w|. */
typedef struct {
    Lanes of[FRICTION_SIZE];
} Sums;

static void add_sums(Friction *f, const Frame *e, const Sums *sums, double load) {
    const double *m = f->matrix, x = e->at[X], y = e->at[Y];
    double s[FRICTION_SIZE], g[FRICTION_SIZE];
    for (int i = 0; i < FRICTION_SIZE; ++i) s[i] = total(&sums->of[i]);
    g[FORCE_X] = m[M_XX] * s[FORCE_X] + m[M_YX] * s[FORCE_Y];
    g[FORCE_Y] = m[M_XY] * s[FORCE_X] + m[M_YY] * s[FORCE_Y];
    g[TORQUE] = s[TORQUE] + x * g[FORCE_Y] - y * g[FORCE_X];
    double ax = m[M_XX] * s[XX] + m[M_YX] * s[XY], ay = m[M_XX] * s[XY] + m[M_YX] * s[YY];
    double bx = m[M_XY] * s[XX] + m[M_YY] * s[XY], by = m[M_XY] * s[XY] + m[M_YY] * s[YY];
    g[XX] = ax * m[M_XX] + ay * m[M_YX];
    g[XY] = ax * m[M_XY] + ay * m[M_YY];
    g[YY] = bx * m[M_XY] + by * m[M_YY];
    double cx = m[M_XX] * s[XW] + m[M_YX] * s[YW], cy = m[M_XY] * s[XW] + m[M_YY] * s[YW];
    g[XW] = cx - y * g[XX] + x * g[XY];
    g[YW] = cy - y * g[XY] + x * g[YY];
    g[WW] = s[WW] + x * (cy + g[YW]) - y * (cx + g[XW]);
    add(f->friction, g, load, FRICTION_SIZE);
}

/* Loads at places, in the coordinates of a frame. A place that rests has no direction. */
static ALWAYS_INLINE void add_places(const Frame *e, const Lanes *x, const Lanes *y,
                                     const Lanes *share, Sums *sums) {
    const double *t = e->spin;
    Lanes px = t[M_XX] * *x + t[M_XY] * *y, py = t[M_YX] * *x + t[M_YY] * *y;
    Lanes wx = e->middle[X] + e->omega * px, wy = e->middle[Y] + e->omega * py;
    Lanes speed = wx * wx + wy * wy + 1e-300;
    speed = rooted(speed);
    Lanes slowness = 1.0 / speed, ux = wx * slowness, uy = wy * slowness, k = *share * slowness;
    Lanes spin = ux * py - uy * px, kx = -k * uy, ky = k * ux;
    sums->of[FORCE_X] += *share * ux;
    sums->of[FORCE_Y] += *share * uy;
    sums->of[TORQUE] += *share * (ux * px + uy * py);
    sums->of[XX] -= kx * uy;
    sums->of[XY] += kx * ux;
    sums->of[YY] += ky * ux;
    sums->of[XW] += kx * spin;
    sums->of[YW] += ky * spin;
    sums->of[WW] += k * spin * spin;
}

/* The same without what follows from homogeneity while the centre of rotation is not distant: |w|
   in place of the torque, and of the Hessian the part by the velocity. */
static ALWAYS_INLINE void add_moving(const Frame *e, const Lanes *x, const Lanes *y,
                                     const Lanes *share, Sums *sums) {
    const double *t = e->spin, omega = e->omega;
    Lanes wx = e->middle[X] + (omega * t[M_XX] * *x + omega * t[M_XY] * *y);
    Lanes wy = e->middle[Y] + (omega * t[M_YX] * *x + omega * t[M_YY] * *y);
    Lanes speed = wx * wx + wy * wy + 1e-300;
    speed = rooted(speed);
    Lanes slowness = 1.0 / speed, ux = wx * slowness, uy = wy * slowness;
    Lanes fx = *share * ux, fy = *share * uy, kx = fx * slowness, ky = fy * slowness;
    sums->of[FORCE_X] += fx;
    sums->of[FORCE_Y] += fy;
    sums->of[TORQUE] += *share * speed;
    sums->of[XX] += ky * uy;
    sums->of[XY] -= ky * ux;
    sums->of[YY] += kx * ux;
}

/* Such sums as those of sides: D, the force and the Hessian by the velocity. */
static void add_speeds(Friction *f, const Sums *sums, double load) {
    const double *m = f->matrix;
    double s[FRICTION_SIZE];
    for (int i = 0; i <= YY; ++i) s[i] = total(&sums->of[i]);
    double ax = m[M_XX] * s[XX] + m[M_YX] * s[XY], ay = m[M_XX] * s[XY] + m[M_YX] * s[YY];
    double bx = m[M_XY] * s[XX] + m[M_YY] * s[XY], by = m[M_XY] * s[XY] + m[M_YY] * s[YY];
    const double added[6] = {
        s[TORQUE],
        m[M_XX] * s[FORCE_X] + m[M_YX] * s[FORCE_Y],
        m[M_XY] * s[FORCE_X] + m[M_YY] * s[FORCE_Y],
        ax * m[M_XX] + ay * m[M_YX],
        ax * m[M_XY] + ay * m[M_YY],
        bx * m[M_XY] + by * m[M_YY],
    };
    add(f->sums, added, load, 6);
    f->is_summed = 1;
}

static ALWAYS_INLINE void sum_points(const Frame *frame, const double *rows, int64_t count,
                                     int stride, int place, int share, int is_near, Sums *sums) {
    for (int64_t i = 0; i < count; i += LANES, rows += LANES * stride) {
        /* the last one stands twice, once without load */
        int is_pair = i + 1 < count;
        const double *next = is_pair ? rows + stride : rows, *at = rows + place;
        const double *at_next = next + place;
        Lanes x = {at[X], at_next[X]}, y = {at[Y], at_next[Y]};
        Lanes part = {rows[share], is_pair ? next[share] : 0.0};
        if (is_near)
            add_moving(frame, &x, &y, &part, sums);
        else
            add_places(frame, &x, &y, &part, sums);
    }
}

static void move_point(Friction *f, double x, double y, double load) {
    double found[WRENCH], *results[] = {found};
    const double place[] = {x, y}, *given[] = {f->twist, f->matrix, place, f->toward};
    point_toward(given, results, 0, 0, 0);
    add(f->friction, found, load, WRENCH);
}

/* Centres of rotation farther than this (extents, in the velocity plane) leave homogeneity too few
   digits. */
static const double DISTANT = 4.0;

/* Points in rows of `stride`, their places and shares of the load at these columns. */
static void add_points(Friction *f, const double *rows, int64_t count, int stride, int place,
                       int share, double load) {
    Sums sums = {0};
    Frame frame = frame_of(f, 0.0, 0.0, 1.0, 1.0);
    if (f->toward) {
        for (int64_t i = 0; i < count; ++i, rows += stride) {
            const double *at = rows + place;
            if (rows != f->apart) move_point(f, at[X], at[Y], load * rows[share]);
        }
        return;
    }
    if (hypot(frame.middle[X], frame.middle[Y]) > DISTANT * fabs(frame.omega)) {
        sum_points(&frame, rows, count, stride, place, share, 0, &sums);
        add_sums(f, &frame, &sums, load);
        return;
    }
    sum_points(&frame, rows, count, stride, place, share, 1, &sums);
    add_speeds(f, &sums, load);
}

static void add_patch(Friction *f, const double *geometry, double load);
static void add_rim(Friction *f, const double *geometry, double load);

static void add_part(Friction *f, const Pressure *pressure, int part, int is_far, double load) {
    if (is_far) {
        const int64_t *first = pressure->first_node + part;
        const double *nodes = pressure->nodes + NODE_COLUMNS * *first;
        add_points(f, nodes, first[1] - *first, NODE_COLUMNS, NODE_PLACE, NODE_SHARE, load);
        return;
    }
    const double *rows = pressure->rows + ROW_COLUMNS * pressure->first_row[part];
    int64_t count = pressure->first_row[part + 1] - pressure->first_row[part];
    if (count && rows[ROW_KIND] <= LINE && !f->toward) {
        add_sides(f, rows, count, load);
        return;
    }
    if (count && rows[ROW_KIND] == POINT) {
        int is_whole = !f->apart || f->toward;
        int64_t before = is_whole ? count : (f->apart - rows) / ROW_COLUMNS;
        add_points(f, rows, before, ROW_COLUMNS, ROW_GEOMETRY, ROW_LOAD, load);
        if (is_whole) return;
        const double *after = f->apart + ROW_COLUMNS;
        add_points(f, after, count - before - 1, ROW_COLUMNS, ROW_GEOMETRY, ROW_LOAD, load);
        return;
    }
    for (int64_t i = 0; i < count; ++i) {
        const double *row = rows + ROW_COLUMNS * i, *geometry = row + ROW_GEOMETRY;
        int kind = (int)row[ROW_KIND];
        double share = load * row[ROW_LOAD];
        if (kind == CHORD)
            add_patch(f, geometry, share);
        else if (kind == ARC)
            add_rim(f, geometry, share);
        else
            move_side(f, row, share);
    }
}

static void begin_sums(Friction *f, const double *twist, const double *matrix, const double *toward,
                       const double *apart) {
    f->twist = twist;
    f->matrix = matrix;
    f->toward = toward;
    f->apart = apart;
    f->is_summed = 0;
    double det = matrix[M_XX] * matrix[M_YY] - matrix[M_YX] * matrix[M_XY];
    f->scale = 1.0 / (twist[OMEGA] * twist[OMEGA] * det);
    memset(f->sums, 0, sizeof f->sums);
    memset(f->friction, 0, sizeof f->friction);
}

static void end_sums(Friction *f) {
    if (!f->is_summed) return;
    double found[FRICTION_SIZE], *results[] = {found};
    const double *given[] = {f->twist, f->sums};
    assembled(given, results, 0, 0, 0);
    add(f->friction, found, 1.0, f->toward ? WRENCH : FRICTION_SIZE);
}

static void add_loads(Friction *f, const Pressure *pressure, int is_far) {
    for (int part = 0; part < PARTS; ++part)
        if (pressure->load[part] != 0.0) add_part(f, pressure, part, is_far, pressure->load[part]);
    end_sums(f);
}

/* Whether the centre of rotation is farther than this from the middle, in extents, in the velocity
   plane. */
static int is_beyond(const Pressure *pressure, const double *twist, const double *m, double far) {
    const double *middle = pressure->middle;
    double x = twist[VX] - twist[OMEGA] * middle[Y], y = twist[VY] + twist[OMEGA] * middle[X];
    double wx = m[M_XX] * x + m[M_XY] * y, wy = m[M_YX] * x + m[M_YY] * y;
    double size = far * twist[OMEGA];
    double first = m[M_XX] * m[M_XX] + m[M_XY] * m[M_XY];
    double second = m[M_YX] * m[M_YX] + m[M_YY] * m[M_YY];
    return !(wx * wx + wy * wy <= size * size * fmax(first, second));
}

/* Derivatives of the wrench by the shares of the pressure, at the expense of the even one; by
   columns, zero by those that the footprint cannot have. */
static void friction_by_shares(const Pressure *pressure, const double *twist, const double *m,
                               int is_far, const double *apart, double *by) {
    double even[WRENCH] = {0.0};
    memset(by, 0, WRENCH * SHARES * sizeof(double));
    Friction f;
    for (int part = EVEN; part < PARTS; ++part) {
        int share = SHARE_OF_PART[part], balance = BALANCE_OF_PART[part];
        if (part != EVEN && share < 0) continue;
        if (pressure->first_row[part] == pressure->first_row[part + 1]) continue;
        begin_sums(&f, twist, m, 0, part == CORNERS ? apart : 0);
        add_part(&f, pressure, part, is_far, 1.0);
        if (balance >= 0) add_part(&f, pressure, balance, is_far, 1.0);
        end_sums(&f);
        if (part == EVEN)
            memcpy(even, f.friction, sizeof even);
        else
            for (int k = 0; k < WRENCH; ++k) by[WRENCH * share + k] = f.friction[k] - even[k];
    }
}
