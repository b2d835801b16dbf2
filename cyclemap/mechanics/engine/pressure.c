/* Friction of whole footprints: what edges, lines and points of a pressure add to it, their sum, and its derivatives.
   What ellipses add is in ellipse.c. */

/* Rows of a pressure: kind, share of the part's load, and up to eight numbers of geometry. */
enum { EDGE, LEAN, LINE, POINT, CHORD, ARC, KIND_COUNT };
enum { ROW_KIND, ROW_LOAD, ROW_GEOMETRY, ROW_COLUMNS = 10 };
/* Parts of a pressure, each of which D is linear in. LEANING has no load of its own: it moves the centre of pressure to
   the centre of mass; BALANCE is how it changes by the load on the corners. */
enum { EVEN, INNER, RIM, CORNERS, LEANING, BALANCE, PARTS };
enum { SHARES = 3 };

typedef struct {
    double load[PARTS];           /* of each part; they add to one, but for the last two */
    double middle[2];             /* centroid of the outline */
    double far;                   /* centres of rotation farther than this (extents, velocity plane) are summed by nodes */
    int64_t first_row[PARTS + 1], first_node[PARTS + 1]; /* parts lie one behind the other */
    const double *rows;           /* (n, ROW_COLUMNS) */
    const double *nodes;          /* (m, 3): x, y, share of the part's load; exact to rounding from afar */
} Pressure;

/* Sums at one twist. toward: a motion of the matrix, for derivatives of the wrench by it; else null. */
typedef struct {
    const double *twist, *matrix, *toward;
    double scale; /* of patches: the area over the image's */
    const double *apart; /* the row of a support point that is left out, or null */
    double sums[6], wrench[9];
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

/* Edges, leaning edges or lines, all of one kind. Slow steps of one do not wait for those of another. */
static void add_sides(Friction *f, const double *rows, int64_t count, double load) {
    enum { AT_ONCE = 16 };
    double corners[2 * AT_ONCE][3], sides[AT_ONCE][6], angles[AT_ONCE], found[6], *results[] = {found};
    int kind = (int)rows[ROW_KIND];
    double factor = kind == LINE ? load : load * f->scale;
    f->is_summed = 1;
    for (int64_t first = 0; first < count; first += AT_ONCE) {
        const double *row = rows + first * ROW_COLUMNS, *images[AT_ONCE];
        int n = (int)(count - first < AT_ONCE ? count - first : AT_ONCE), known = 0;
        for (int i = 0; i < n; ++i) {
            const double *ends = row + i * ROW_COLUMNS + ROW_GEOMETRY;
            /* neighbours share a corner, and its image */
            if (i == 0 || ends[-ROW_COLUMNS + 2] != ends[0] || ends[-ROW_COLUMNS + 3] != ends[1])
                image_of(f, ends, corners[known++]);
            images[i] = corners[known - 1];
            image_of(f, ends + 2, corners[known++]);
        }
        if (kind == EDGE) {
            for (int i = 0; i < n; ++i) {
                double *to = sides[i];
                side(images + i, &to, 0, 0, 0);
            }
            for (int i = 0; i < n; ++i) angles[i] = log1p(sides[i][5]);
        }
        for (int i = 0; i < n; ++i) {
            const double *at = row + i * ROW_COLUMNS, *more = at + ROW_GEOMETRY + 4;
            const double *edge_given[] = {f->matrix, sides[i], angles + i}, *given[] = {f->twist, f->matrix, images[i], more};
            if (kind == EDGE) edge(edge_given, results, 0, 0, 0);
            else if (kind == LEAN) lean(given, results, 0, 0, 0);
            else line(given, results, 0, 0, 0);
            add(f->sums, found, factor * at[ROW_LOAD], 6);
        }
    }
}

static void move_side(Friction *f, const double *row, double load) {
    double found[3], *results[] = {found};
    const double *ends = row + ROW_GEOMETRY, *lean_given[] = {f->twist, f->matrix, ends, ends + 4, f->toward};
    const double *given[] = {f->twist, f->matrix, ends, f->toward};
    int kind = (int)row[ROW_KIND];
    if (kind == EDGE) edge_toward(given, results, 0, 0, 0);
    else if (kind == LEAN) lean_toward(lean_given, results, 0, 0, 0);
    else line_toward(given, results, 0, 0, 0);
    add(f->sums, found, load, 3);
    f->is_summed = 1;
}

/* Places are summed some at once: each has the same roots and quotients to take. */
enum { LANES = 2 };
#define ALWAYS_INLINE inline __attribute__((always_inline))
typedef double Lanes __attribute__((vector_size(8 * LANES)));
static inline void roots(Lanes *x) {
    for (int k = 0; k < LANES; ++k) (*x)[k] = sqrt((*x)[k]);
}

static inline double size_of(double x, double y) { return sqrt(x * x + y * y); }

/* Places in coordinates x of their own, from a point `at` on: w = middle + omega spin x. */
typedef struct { double at[2], omega, middle[2], spin[4]; } Frame;

static Frame frame_of(const Friction *f, double at_x, double at_y, double unit_x, double unit_y) {
    const double *v = f->twist, *m = f->matrix, x = v[0] - v[2] * at_y, y = v[1] + v[2] * at_x;
    return (Frame){{at_x, at_y}, v[2], {m[0] * x + m[2] * y, m[1] * x + m[3] * y},
                   {m[2] * unit_x, m[3] * unit_x, -m[0] * unit_y, -m[1] * unit_y}};
}

/* Wrench and Hessian about `at`, as sums over w = |w| u, n across u: of u, u . spin x; of n n^T / |w| (xx, xy, yy), n (n . spin x) / |w|, (n . spin x)^2 / |w|. */
typedef struct { Lanes of[9]; } Sums;

static void add_sums(Friction *f, const Frame *e, const Sums *sums, double load) {
    const double *m = f->matrix, x = e->at[0], y = e->at[1];
    double s[9], g[9];
    for (int i = 0; i < 9; ++i) s[i] = sums->of[i][0] + sums->of[i][1];
    g[0] = m[0] * s[0] + m[1] * s[1];
    g[1] = m[2] * s[0] + m[3] * s[1];
    g[2] = s[2] + x * g[1] - y * g[0];
    double ax = m[0] * s[3] + m[1] * s[4], ay = m[0] * s[4] + m[1] * s[5];
    double bx = m[2] * s[3] + m[3] * s[4], by = m[2] * s[4] + m[3] * s[5];
    g[3] = ax * m[0] + ay * m[1];
    g[4] = ax * m[2] + ay * m[3];
    g[5] = bx * m[2] + by * m[3];
    double cx = m[0] * s[6] + m[1] * s[7], cy = m[2] * s[6] + m[3] * s[7];
    g[6] = cx - y * g[3] + x * g[4];
    g[7] = cy - y * g[4] + x * g[5];
    g[8] = s[8] + x * (cy + g[7]) - y * (cx + g[6]);
    add(f->wrench, g, load, 9);
}

/* Loads at places, in the coordinates of a frame. A place that rests has no direction. */
static ALWAYS_INLINE void add_places(const Frame *e, const Lanes *x, const Lanes *y, const Lanes *share, Sums *sums) {
    Lanes px = e->spin[0] * *x + e->spin[2] * *y, py = e->spin[1] * *x + e->spin[3] * *y;
    Lanes wx = e->middle[0] + e->omega * px, wy = e->middle[1] + e->omega * py, speed = wx * wx + wy * wy + 1e-300;
    roots(&speed);
    Lanes slowness = 1.0 / speed, ux = wx * slowness, uy = wy * slowness, k = *share * slowness;
    Lanes spin = ux * py - uy * px, kx = -k * uy, ky = k * ux;
    sums->of[0] += *share * ux;
    sums->of[1] += *share * uy;
    sums->of[2] += *share * (ux * px + uy * py);
    sums->of[3] -= kx * uy;
    sums->of[4] += kx * ux;
    sums->of[5] += ky * ux;
    sums->of[6] += kx * spin;
    sums->of[7] += ky * spin;
    sums->of[8] += k * spin * spin;
}

static void move_point(Friction *f, double x, double y, double load) {
    double found[3], *results[] = {found};
    const double place[] = {x, y}, *given[] = {f->twist, f->matrix, place, f->toward};
    point_toward(given, results, 0, 0, 0);
    add(f->wrench, found, load, 3);
}

/* Points in rows of `stride`, their places and shares of the load at these columns. */
static void add_points(Friction *f, const double *rows, int64_t count, int stride, int place, int share, double load) {
    Sums sums = {0};
    Frame frame = frame_of(f, 0.0, 0.0, 1.0, 1.0);
    for (int64_t i = 0; i < count && f->toward; ++i, rows += stride)
        if (rows != f->apart) move_point(f, rows[place], rows[place + 1], load * rows[share]);
    if (f->toward) return;
    for (int64_t i = 0; i + 1 < count; i += LANES, rows += LANES * stride) {
        const double *next = rows + stride;
        Lanes x = {rows[place], next[place]}, y = {rows[place + 1], next[place + 1]}, part = {rows[share], next[share]};
        add_places(&frame, &x, &y, &part, &sums);
    }
    if (count % LANES) {
        Lanes x = {rows[place]}, y = {rows[place + 1]}, part = {rows[share]};
        add_places(&frame, &x, &y, &part, &sums);
    }
    add_sums(f, &frame, &sums, load);
}

static void add_patch(Friction *f, const double *geometry, double load);
static void add_rim(Friction *f, const double *geometry, double load);

static void add_part(Friction *f, const Pressure *pressure, int part, int is_far, double load) {
    if (is_far) {
        const double *nodes = pressure->nodes + 3 * pressure->first_node[part];
        add_points(f, nodes, pressure->first_node[part + 1] - pressure->first_node[part], 3, 0, 2, load);
        return;
    }
    const double *rows = pressure->rows + ROW_COLUMNS * pressure->first_row[part];
    int64_t count = pressure->first_row[part + 1] - pressure->first_row[part];
    if (count && rows[ROW_KIND] <= LINE && !f->toward) {
        add_sides(f, rows, count, load);
        return;
    }
    if (count && rows[ROW_KIND] == POINT) {
        int64_t before = f->apart && !f->toward ? (f->apart - rows) / ROW_COLUMNS : count, after = count - 1 - before;
        add_points(f, rows, before, ROW_COLUMNS, ROW_GEOMETRY, ROW_LOAD, load);
        if (after > 0) add_points(f, f->apart + ROW_COLUMNS, after, ROW_COLUMNS, ROW_GEOMETRY, ROW_LOAD, load);
        return;
    }
    for (int64_t i = 0; i < count; ++i) {
        const double *row = rows + ROW_COLUMNS * i, *geometry = row + ROW_GEOMETRY;
        int kind = (int)row[ROW_KIND];
        double share = load * row[ROW_LOAD];
        if (kind == CHORD) add_patch(f, geometry, share);
        else if (kind == ARC) add_rim(f, geometry, share);
        else move_side(f, row, share);
    }
}

static void begin_sums(Friction *f, const double *twist, const double *matrix, const double *toward,
                       const double *apart) {
    f->twist = twist;
    f->matrix = matrix;
    f->toward = toward;
    f->apart = apart;
    f->is_summed = 0;
    f->scale = 1.0 / (twist[2] * twist[2] * (matrix[0] * matrix[3] - matrix[1] * matrix[2]));
    memset(f->sums, 0, sizeof f->sums);
    memset(f->wrench, 0, sizeof f->wrench);
}

static void end_sums(Friction *f) {
    if (!f->is_summed) return;
    double found[9], *results[] = {found};
    const double *given[] = {f->twist, f->matrix, f->sums};
    assembled(given, results, 0, 0, 0);
    add(f->wrench, found, 1.0, f->toward ? 3 : 9);
}

static void add_loads(Friction *f, const Pressure *pressure, int is_far) {
    for (int part = 0; part < PARTS; ++part)
        if (pressure->load[part] != 0.0) add_part(f, pressure, part, is_far, pressure->load[part]);
    end_sums(f);
}

/* Whether the centre of rotation is farther than this from the middle, in extents, in the velocity plane. */
static int is_beyond(const Pressure *pressure, const double *twist, const double *m, double far) {
    double x = twist[0] - twist[2] * pressure->middle[1], y = twist[1] + twist[2] * pressure->middle[0];
    double wx = m[0] * x + m[2] * y, wy = m[1] * x + m[3] * y, size = far * twist[2];
    return !(wx * wx + wy * wy <= size * size * fmax(m[0] * m[0] + m[2] * m[2], m[1] * m[1] + m[3] * m[3]));
}

/* Wrench (3) and Hessian (xx, xy, yy, x omega, y omega, omega omega). is_far: the regime of the last call and of this
   one, which changes a little late, so that small steps do not cross from one rounding to another. apart: the row of a
   support point that is left out, or null. */
static void friction_without(const Pressure *pressure, const double *twist, const double *matrix, int *is_far,
                             const double *apart, double *wrench) {
    Friction f;
    *is_far = pressure->far < INFINITY && is_beyond(pressure, twist, matrix, pressure->far * (*is_far ? 0.7 : 1.7));
    begin_sums(&f, twist, matrix, 0, *is_far ? 0 : apart);
    add_loads(&f, pressure, *is_far);
    memcpy(wrench, f.wrench, sizeof f.wrench);
}

static void friction_at(const Pressure *pressure, const double *twist, const double *matrix, int *is_far, double *wrench) {
    friction_without(pressure, twist, matrix, is_far, 0, wrench);
}

/* Derivatives of the wrench by mu_a, mu_b and alpha, by columns; only_angle: by alpha alone. */
static void friction_by_law(const Pressure *pressure, const double *twist, const double *m, int is_far, int only_angle,
                            const double *apart, double *by_law) {
    double mu_a = hypot(m[0], m[2]), mu_b = hypot(m[1], m[3]);
    const double toward[3][4] = {{m[0] / mu_a, 0.0, m[2] / mu_a, 0.0},
                                 {0.0, m[1] / mu_b, 0.0, m[3] / mu_b},
                                 {-m[2], -m[3], m[0], m[1]}};
    Friction f;
    memset(by_law, 0, 9 * sizeof(double));
    for (int k = only_angle ? 2 : 0; k < 3; ++k) {
        begin_sums(&f, twist, m, toward[k], apart);
        add_loads(&f, pressure, is_far);
        memcpy(by_law + 3 * k, f.wrench, 3 * sizeof(double));
    }
}

/* Derivatives of the wrench by the shares of the pressure inside, on the rim and at the corners, at the expense of the
   even one; by columns, zero by those that the footprint cannot have. */
static void friction_by_shares(const Pressure *pressure, const double *twist, const double *m, int is_far,
                               const double *apart, double *by) {
    double even[3] = {0.0};
    memset(by, 0, 3 * SHARES * sizeof(double));
    Friction f;
    for (int part = EVEN; part <= CORNERS; ++part) {
        if (pressure->first_row[part] == pressure->first_row[part + 1]) continue;
        begin_sums(&f, twist, m, 0, part == CORNERS ? apart : 0);
        add_part(&f, pressure, part, is_far, 1.0);
        if (part == CORNERS) add_part(&f, pressure, BALANCE, is_far, 1.0);
        end_sums(&f);
        if (part == EVEN) memcpy(even, f.wrench, sizeof even);
        else
            for (int k = 0; k < 3; ++k) by[3 * (part - 1) + k] = f.wrench[k] - even[k];
    }
}

/* For drawings and tests: D, wrench and Hessian (10) at each of `count` twists (3) of the footprint's own frame. */
EXPORT void cm_friction(const Pressure *pressure, const double *matrix, const double *twists, int64_t count,
                        double *values) {
    for (int64_t i = 0; i < count; ++i) {
        int is_far = 0;
        const double *v = twists + 3 * i;
        double *to = values + 10 * i;
        friction_at(pressure, v, matrix, &is_far, to + 1);
        to[0] = v[0] * to[1] + v[1] * to[2] + v[2] * to[3];
    }
}
