/* Friction of any pressure: of one that is made of parts (pressure.c), or of a foundation that is
   pressed (foundation.c, cones.c), which the caller keeps for the orientation at hand. */

/* Wrench and Hessian. is_far: the regime of the last call and of this one, which changes a little
   late, so that small steps do not cross from one rounding to another. */
static void friction_at(const Pressure *pressure, const Pressed *pressed, const double *twist,
                        const double *m, int *is_far, double *friction) {
    double from = is_pressed(pressure) ? FOUNDATION_FAR[pressed->digits] : pressure->far;
    *is_far = from < INFINITY && is_beyond(pressure, twist, m, from * (*is_far ? 0.7 : 1.7));
    if (is_pressed(pressure)) {
        sum_pressed(pressure, pressed, pressed->pressure, twist, m, 0, *is_far, friction);
        return;
    }
    Friction f;
    begin_sums(&f, twist, m, 0);
    add_loads(&f, pressure, *is_far);
    memcpy(friction, f.friction, sizeof f.friction);
}

/* Derivatives of the wrench by mu_a, mu_b and alpha, by columns; only_angle: by alpha alone. */
static void friction_by_law(const Pressure *pressure, const Pressed *pressed, const double *twist,
                            const double *m, int is_far, int only_angle, double *by_law) {
    enum { HALF_AXES = 2, COUNT };
    double mu_a = hypot(m[M_XX], m[M_XY]), mu_b = hypot(m[M_YX], m[M_YY]);
    const double toward[COUNT][MATRIX_SIZE] = {{[M_XX] = m[M_XX] / mu_a, [M_XY] = m[M_XY] / mu_a},
                                               {[M_YX] = m[M_YX] / mu_b, [M_YY] = m[M_YY] / mu_b},
                                               {-m[M_XY], -m[M_YY], m[M_XX], m[M_YX]}};
    /* which way an ellipse with equal axes is turned makes no difference */
    int is_round = m[M_XX] == m[M_YY] && m[M_XY] == -m[M_YX];
    Friction f;
    memset(by_law, 0, WRENCH * COUNT * sizeof(double));
    for (int k = only_angle ? HALF_AXES : 0; k < (is_round ? HALF_AXES : COUNT); ++k) {
        double *by = by_law + WRENCH * k;
        if (is_pressed(pressure)) {
            sum_pressed(pressure, pressed, pressed->pressure, twist, m, toward[k], is_far, by);
            continue;
        }
        begin_sums(&f, twist, m, toward[k]);
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
        friction_at(pressure, &pressed, v, matrix, &is_far, wrench);
        *speed = v[VX] * wrench[FORCE_X] + v[VY] * wrench[FORCE_Y] + v[OMEGA] * wrench[TORQUE];
    }
}
