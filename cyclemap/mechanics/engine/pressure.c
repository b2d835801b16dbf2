/* Friction of a whole footprint, as a sum over the pieces of its pressure. */

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

/* Points in rows of `stride`, their places and shares of the load at these columns. */
static void add_points(Friction *f, const double *rows, int64_t count, int stride, int place, int share, double load) {
    double total[9] = {0.0}, found[9], *results[] = {found};
    for (int64_t i = 0; i < count; ++i, rows += stride) {
        const double *given[] = {f->twist, f->matrix, rows + place, f->toward};
        if (f->toward) point_toward(given, results, 0, 0, 0);
        else point(given, results, 0, 0, 0);
        add(total, found, rows[share], f->toward ? 3 : 9);
    }
    add(f->wrench, total, load, f->toward ? 3 : 9);
}

static void add_point(Friction *f, double x, double y, double load) {
    const double row[] = {x, y, 1.0};
    add_points(f, row, 1, 3, 0, 2, load);
}

static void add_chord(Friction *f, const double *chord_given, double load) {
    double found[9], *results[] = {found};
    const double *given[] = {f->matrix, chord_given}, *moved[] = {f->twist, f->matrix, chord_given, f->toward};
    if (f->toward) chord_toward(moved, results, 0, 0, 0);
    else chord(given, results, 0, 0, 0);
    add(f->wrench, found, load, f->toward ? 3 : 9);
}

/* An ellipse in the coordinates of its own unit disc, w = middle + spin x, and the centre of rotation: far: whether it
   lies outside; size: its distance from the centre, or one over it; away: the direction from it to the centre;
   thinness: the ratio of the image's axes; slow: the direction that is mapped on the shorter one. */
typedef struct {
    double semi[2], at[2], slope[2], level, middle[2], spin[4], size, away[2], thinness, slow;
    int far;
} Ellipse;

static Ellipse ellipse_of(const Friction *f, const double *geometry) {
    const double *v = f->twist, *m = f->matrix;
    Ellipse e = {{geometry[0], geometry[1]}, {geometry[2], geometry[3]}, {geometry[4], geometry[5]}, geometry[6],
                 {0}, {0}, 0.0, {0}, 0.0, 0.0, 0};
    double x = v[0] - v[2] * e.at[1], y = v[1] + v[2] * e.at[0];
    e.middle[0] = m[0] * x + m[2] * y;
    e.middle[1] = m[1] * x + m[3] * y;
    /* M J diag(semi), by columns */
    double turned[] = {m[2] * e.semi[0], m[3] * e.semi[0], -m[0] * e.semi[1], -m[1] * e.semi[1]};
    for (int k = 0; k < 4; ++k) e.spin[k] = v[2] * turned[k];
    double det = turned[0] * turned[3] - turned[1] * turned[2];
    double px = (turned[3] * e.middle[0] - turned[2] * e.middle[1]) / det;
    double py = (turned[0] * e.middle[1] - turned[1] * e.middle[0]) / det;
    double p = hypot(px, py), omega = fabs(v[2]), half = 0.0;
    for (int k = 0; k < 4; ++k) half += turned[k] * turned[k] / 2.0;
    /* the direction in which the image is least wide */
    e.slow = 0.5 * atan2(2.0 * (turned[0] * turned[2] + turned[1] * turned[3]),
                         turned[0] * turned[0] + turned[1] * turned[1] - turned[2] * turned[2] - turned[3] * turned[3])
             + M_PI / 2.0;
    e.thinness = fabs(det) / (half + sqrt(fmax(half * half - det * det, 0.0))); /* ratio of its singular values */
    /* the centre of rotation is -(px, py) / omega */
    e.far = p > omega;
    e.size = e.far ? omega / p : p / omega;
    double sign = v[2] < 0.0 ? -1.0 : 1.0;
    e.away[0] = p > 0.0 ? sign * px / p : 1.0;
    e.away[1] = p > 0.0 ? sign * py / p : 0.0;
    return e;
}

/* The chord at angle t, -pi/2 < t < pi/2, for a width dt of it. Outside, the chord's distance from the centre is sin t;
   inside, its angle from the direction to the centre is t. */
static inline void add_chord_at(Friction *f, const Ellipse *e, double c, double s, double dt, double load) {
    double given[11], *middle = given + 2, *chord_way = given + 4, *moment = given + 6;
    double width = dt / M_PI, by_speed, first, second, q, offset, ex, ey, wx, wy;
    if (e->far) {
        double across = e->size * s, along = sqrt(1.0 - across * across);
        ex = along * e->away[0] - across * e->away[1];
        ey = along * e->away[1] + across * e->away[0];
        q = c;
        offset = s;
        wx = e->middle[0] + offset * (e->spin[2] * ex - e->spin[0] * ey);
        wy = e->middle[1] + offset * (e->spin[3] * ex - e->spin[1] * ey);
    } else {
        ex = c * e->away[0] - s * e->away[1];
        ey = c * e->away[1] + s * e->away[0];
        offset = e->size * s;
        q = sqrt(1.0 - offset * offset);
        wx = e->spin[0] * ex + e->spin[2] * ey;
        wy = e->spin[1] * ex + e->spin[3] * ey;
    }
    double slowness = 1.0 / sqrt(wx * wx + wy * wy);
    given[0] = wx * slowness;
    given[1] = wy * slowness;
    first = width * c;
    if (e->far) {
        /* w grows along the chord, in the sense of e */
        double steep = (e->spin[0] * ex + e->spin[2] * ey) * given[0] + (e->spin[1] * ex + e->spin[3] * ey) * given[1];
        by_speed = first * slowness;
        second = by_speed * steep;
    } else {
        first *= e->size;
        second = width;
        by_speed = width * slowness;
    }
    middle[0] = -e->semi[0] * offset * ey;
    middle[1] = e->semi[1] * offset * ex;
    chord_way[0] = e->semi[0] * ex;
    chord_way[1] = e->semi[1] * ey;
    double f0 = e->level + e->slope[0] * middle[0] + e->slope[1] * middle[1];
    double f1 = e->slope[0] * chord_way[0] + e->slope[1] * chord_way[1], two = 2.0 * q, cube = 2.0 / 3.0 * q * q * q;
    /* int (first + second tau) (f0 + f1 tau) (1, tau), and int (f0 + f1 tau) (1, tau, tau^2) by_speed */
    moment[0] = two * first * f0 + cube * second * f1;
    moment[1] = cube * (first * f1 + second * f0);
    moment[2] = two * f0 * by_speed;
    moment[3] = cube * f1 * by_speed;
    moment[4] = cube * f0 * by_speed;
    add_chord(f, given, load);
}

/* Where the integrand over t is singular, as complex numbers: at both ends, by the chords' lengths, and where the speed
   along a chord is least; there once more by symmetry. */
enum { SINGULAR = 5 };
static void singularities(const Ellipse *e, double complex *at) {
    double size = fmin(fmax(e->size, 1e-12), 1.0 - 1e-15), along = atan2(e->away[1], e->away[0]);
    /* The chord has no sense. */
    double complex slow = remainder(e->slow - along, M_PI) + I * atanh(fmin(e->thinness, 1.0 - 1e-9));
    if (e->far) slow = casin(csin(slow) / size);
    slow = remainder(creal(slow), M_PI) + I * fabs(cimag(slow));
    at[0] = -M_PI / 2.0 + I * acosh(1.0 / size);
    at[1] = M_PI + at[0];
    at[2] = slow;
    at[3] = e->far ? M_PI - conj(slow) : slow + M_PI;
    at[4] = e->far ? -M_PI - conj(slow) : slow - M_PI;
}

enum { PANEL_ORDER = 12, MOST_EVEN = 250 };
static const double DIGITS = 15.5;

/* How wide a panel from t on may be, to reach no farther than the singularities are away, nor over the end. */
static double panel_width(const double complex *at, int count, double t, double end) {
    double width = end - t;
    for (int k = 0; k < count; ++k) {
        double ahead = creal(at[k]) - t, away = cimag(at[k]);
        width = fmin(width, ahead > 0.0 ? fmax(away, ahead / 2.0) : hypot(away, ahead));
    }
    return fmax(width, 1e-15);
}

/* A patch: by the trapezoidal rule in t, whose error falls with exp(-2 n delta) where the nearest singularity is delta
   away; where that is near, by Gauss's rule on panels no longer than their distance from any. */
static void add_patch(Friction *f, const double *geometry, double load) {
    Ellipse e = ellipse_of(f, geometry);
    double complex at[SINGULAR];
    double nearest = INFINITY;
    singularities(&e, at);
    for (int k = 0; k < SINGULAR; ++k) nearest = fmin(nearest, cimag(at[k]));
    if (DIGITS <= MOST_EVEN * nearest) {
        int count = (int)fmax(ceil(DIGITS / nearest), 8.0);
        double dt = M_PI / count, c = cos(dt), s = sin(dt), ct = sin(dt / 2.0), st = -cos(dt / 2.0);
        for (int j = 0; j < count; ++j) {
            add_chord_at(f, &e, ct, st, dt, load);
            double next = ct * c - st * s;
            st = st * c + ct * s;
            ct = next;
        }
        return;
    }
    for (double t = -M_PI / 2.0; t < M_PI / 2.0;) {
        double width = panel_width(at, SINGULAR, t, M_PI / 2.0);
        for (int j = 0; j < PANEL_ORDER; ++j) {
            double x = t + width * (1.0 + GAUSS_NODES[j]) / 2.0;
            add_chord_at(f, &e, cos(x), sin(x), width * GAUSS_WEIGHTS[j] / 2.0, load);
        }
        t += width;
    }
}

static void add_rim_point(Friction *f, const double *geometry, double tau, double load) {
    add_point(f, geometry[2] + geometry[0] * cos(tau), geometry[3] + geometry[1] * sin(tau), load);
}

/* A load along the rim, even in the eccentric angle tau (the derivative of the even patch by its scale). |w| is singular
   at the complex tau where p z^2 + c z + q = 0, z = exp(i tau), w as a complex number. */
static void add_rim(Friction *f, const double *geometry, double load) {
    Ellipse e = ellipse_of(f, geometry);
    double px = (e.spin[0] + e.spin[3]) / 2.0, py = (e.spin[1] - e.spin[2]) / 2.0;
    double qx = (e.spin[0] - e.spin[3]) / 2.0, qy = (e.spin[1] + e.spin[2]) / 2.0, cx = e.middle[0], cy = e.middle[1];
    double rx = cx * cx - cy * cy - 4.0 * (px * qx - py * qy), ry = 2.0 * cx * cy - 4.0 * (px * qy + py * qx);
    double size = sqrt(hypot(rx, ry)), angle = atan2(ry, rx) / 2.0;
    rx = size * cos(angle);
    ry = size * sin(angle);
    double sign = cx * rx + cy * ry >= 0.0 ? 1.0 : -1.0, bx = -(cx + sign * rx) / 2.0, by = -(cy + sign * ry) / 2.0;
    /* roots b/p and q/b */
    double p = hypot(px, py), b = hypot(bx, by), q = hypot(qx, qy);
    double at[] = {atan2(by, bx) - atan2(py, px), atan2(qy, qx) - atan2(by, bx)};
    double from[] = {p > 0.0 ? fabs(log(b / p)) : 40.0, q > 0.0 ? fabs(log(q / b)) : 40.0};
    for (int k = 0; k < 2; ++k) from[k] = from[k] >= 1e-13 ? from[k] : 1e-13;
    double nearest = fmin(from[0], from[1]);
    if (2.0 * DIGITS <= 2.0 * MOST_EVEN * nearest) {
        int count = (int)fmax(ceil(2.0 * DIGITS / nearest), 16.0);
        for (int j = 0; j < count; ++j) add_rim_point(f, geometry, at[0] + 2.0 * M_PI * (j + 0.5) / count, load / count);
        return;
    }
    double complex singular[6];
    at[1] = at[0] + remainder(at[1] - at[0], 2.0 * M_PI);
    for (int k = 0; k < 6; ++k) singular[k] = at[k % 2] + 2.0 * M_PI * (k / 2 - 1) + I * from[k % 2];
    for (double tau = at[0], end = at[0] + 2.0 * M_PI; tau < end;) {
        double width = panel_width(singular, 6, tau, end);
        for (int j = 0; j < PANEL_ORDER; ++j)
            add_rim_point(f, geometry, tau + width * (1.0 + GAUSS_NODES[j]) / 2.0,
                          load * width * GAUSS_WEIGHTS[j] / (4.0 * M_PI));
        tau += width;
    }
}

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
        add_points(f, rows, count, ROW_COLUMNS, ROW_GEOMETRY, ROW_LOAD, load);
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

static void begin_sums(Friction *f, const double *twist, const double *matrix, const double *toward) {
    f->twist = twist;
    f->matrix = matrix;
    f->toward = toward;
    f->is_summed = 0;
    f->scale = patch_scale(f);
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
   one, which changes a little late, so that small steps do not cross from one rounding to another. */
static void friction_at(const Pressure *pressure, const double *twist, const double *matrix, int *is_far, double *wrench) {
    Friction f;
    *is_far = pressure->far < INFINITY && is_beyond(pressure, twist, matrix, pressure->far * (*is_far ? 0.7 : 1.7));
    begin_sums(&f, twist, matrix, 0);
    add_loads(&f, pressure, *is_far);
    memcpy(wrench, f.wrench, sizeof f.wrench);
}

/* Derivatives of the wrench by mu_a, mu_b and alpha, by columns; only_angle: by alpha alone. */
static void friction_by_law(const Pressure *pressure, const double *twist, const double *m, int is_far, int only_angle,
                            double *by_law) {
    double mu_a = hypot(m[0], m[2]), mu_b = hypot(m[1], m[3]);
    const double toward[3][4] = {{m[0] / mu_a, 0.0, m[2] / mu_a, 0.0},
                                 {0.0, m[1] / mu_b, 0.0, m[3] / mu_b},
                                 {-m[2], -m[3], m[0], m[1]}};
    Friction f;
    memset(by_law, 0, 9 * sizeof(double));
    for (int k = only_angle ? 2 : 0; k < 3; ++k) {
        begin_sums(&f, twist, m, toward[k]);
        add_loads(&f, pressure, is_far);
        memcpy(by_law + 3 * k, f.wrench, 3 * sizeof(double));
    }
}

/* Derivatives of the wrench by the shares of the pressure inside, on the rim and at the corners, at the expense of the
   even one; by columns, zero by those that the footprint cannot have. */
static void friction_by_shares(const Pressure *pressure, const double *twist, const double *m, int is_far, double *by) {
    double even[3] = {0.0};
    memset(by, 0, 3 * SHARES * sizeof(double));
    Friction f;
    for (int part = EVEN; part <= CORNERS; ++part) {
        if (pressure->first_row[part] == pressure->first_row[part + 1]) continue;
        begin_sums(&f, twist, m, 0);
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
