/* What edges, lines and points of a pressure add to the friction. */

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
    double sums[6], wrench[9];
    int is_summed;
} Friction;

static void add(double *to, const double *what, double factor, int count) {
    for (int i = 0; i < count; ++i) to[i] += factor * what[i];
}

/* What a patch's sums in the velocity plane are to be multiplied by. */
static double patch_scale(const Friction *f) {
    const double *m = f->matrix;
    return 1.0 / (f->twist[2] * f->twist[2] * (m[0] * m[3] - m[1] * m[2]));
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
        move_point(f, rows[place], rows[place + 1], load * rows[share]);
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

static void add_point(Friction *f, double x, double y, double load) {
    const double row[] = {x, y, 1.0};
    add_points(f, row, 1, 3, 0, 2, load);
}
