/* Friction of any pressure: of one that is made of parts (pressure.c), or of a foundation that is
   pressed (foundation.c, cones.c), which the caller keeps for the orientation at hand. */

/* Wrench and Hessian. is_far: the regime of the last call and of this one, which changes a little
   late, so that small steps do not cross from one rounding to another. apart: the row of a support
   point that is left out, unless it is far, or null. */
static void friction_at(const Pressure *pressure, const Pressed *pressed, const double *twist,
                        const double *m, int *is_far, const double *apart, double *friction) {
    double from = is_pressed(pressure) ? FOUNDATION_FAR[pressed->digits] : pressure->far;
    *is_far = from < INFINITY && is_beyond(pressure, twist, m, from * (*is_far ? 0.7 : 1.7));
    if (is_pressed(pressure)) {
        sum_pressed(pressure, pressed, pressed->pressure, twist, m, 0, *is_far, friction);
        return;
    }
    Friction f;
    begin_sums(&f, twist, m, 0, *is_far ? 0 : apart);
    add_loads(&f, pressure, *is_far);
    memcpy(friction, f.friction, sizeof f.friction);
}

/* M of the law, and how it moves: with mu_a, mu_b and alpha, the ellipse's half axes and turn. */
enum { OF_MU_A, OF_MU_B, OF_ALPHA, LAW_NUMBERS };

static void matrix_by_law(const double *m, double by[LAW_NUMBERS][MATRIX_SIZE]) {
    double mu_a = hypot(m[M_XX], m[M_XY]), mu_b = hypot(m[M_YX], m[M_YY]);
    memset(by, 0, LAW_NUMBERS * MATRIX_SIZE * sizeof(double));
    by[OF_MU_A][M_XX] = m[M_XX] / mu_a;
    by[OF_MU_A][M_XY] = m[M_XY] / mu_a;
    by[OF_MU_B][M_YX] = m[M_YX] / mu_b;
    by[OF_MU_B][M_YY] = m[M_YY] / mu_b;
    by[OF_ALPHA][M_XX] = -m[M_XY];
    by[OF_ALPHA][M_YX] = -m[M_YY];
    by[OF_ALPHA][M_XY] = m[M_XX];
    by[OF_ALPHA][M_YY] = m[M_YX];
}

/* Derivatives of the wrench by mu_a, mu_b and alpha, by columns; only_angle: by alpha alone. */
static void friction_by_law(const Pressure *pressure, const Pressed *pressed, const double *twist,
                            const double *m, int is_far, int only_angle, const double *apart,
                            double *by_law) {
    double toward[LAW_NUMBERS][MATRIX_SIZE];
    matrix_by_law(m, toward);
    /* which way an ellipse with equal axes is turned makes no difference */
    int is_round = m[M_XX] == m[M_YY] && m[M_XY] == -m[M_YX];
    Friction f;
    memset(by_law, 0, WRENCH * LAW_NUMBERS * sizeof(double));
    for (int k = only_angle ? OF_ALPHA : 0; k < (is_round ? OF_ALPHA : LAW_NUMBERS); ++k) {
        double *by = by_law + WRENCH * k;
        if (is_pressed(pressure)) {
            sum_pressed(pressure, pressed, pressed->pressure, twist, m, toward[k], is_far, by);
            continue;
        }
        begin_sums(&f, twist, m, toward[k], apart);
        add_loads(&f, pressure, is_far);
        memcpy(by, f.friction, WRENCH * sizeof(double));
    }
}

/* For drawings and tests: D, wrench and Hessian at each of `count` twists of the footprint's own
   frame, at an orientation. */
EXPORT void cm_friction(const Pressure *pressure, double theta, const double *matrix,
                        const double *twists, int64_t count, double *values) {
    Pressed pressed;
    begin_pressed(&pressed, 0.0);
    if (is_pressed(pressure)) press(pressure, theta, &pressed);
    for (int64_t i = 0; i < count; ++i) {
        int is_far = 0;
        const double *v = twists + TWIST_SIZE * i;
        double *speed = values + (1 + FRICTION_SIZE) * i, *wrench = speed + 1;
        friction_at(pressure, &pressed, v, matrix, &is_far, 0, wrench);
        *speed = v[VX] * wrench[FORCE_X] + v[VY] * wrench[FORCE_Y] + v[OMEGA] * wrench[TORQUE];
    }
}
