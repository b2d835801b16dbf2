/* Friction of a whole footprint, as a sum over the pieces of its pressure. */

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
