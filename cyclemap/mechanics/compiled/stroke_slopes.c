/* How the end of a step varies with its start: phase_variation.py in C. */

/* phase_variation._slope_jacobians, of one row: derivatives of the slope (2, 3), by columns; 0 where a tangent is not to
   be trusted. */
static int slope_jacobian(Run *r, Motion *m, double *row, double *by) {
    double report[4];
    int n = m->law->unknowns;
    if (kinked(m, row)) return 0;
    const double *found = variation(m, row, row + UNKNOWN, by)->found;
    for (int k = 0; k < n; ++k) {
        if (fabs(found[n + k]) <= UNSOLVED) continue;
        memcpy(m->z, row + UNKNOWN, n * sizeof(double));
        if (!evaluate(r, m, row, row, report) || kinked(m, row)) return 0;
        variation(m, row, row + UNKNOWN, by);
        break;
    }
    return 1;
}

/* phase_variation._middles, of one. */
static void middle(const Motion *m, const Step *taken, double *row) {
    for (int c = 0; c < 2; ++c) {
        row[c] = taken->rows[0][c];
        for (int i = 0; i <= STAGES; ++i) row[c] += taken->h * MIDDLE_STATE[i] * taken->rows[i][SLOPE + c];
    }
    for (int k = 0; k < m->law->unknowns; ++k) {
        row[UNKNOWN + k] = 0.0;
        for (int i = 0; i <= STAGES; ++i) row[UNKNOWN + k] += MIDDLE_VALUE[i] * taken->rows[i][UNKNOWN + k];
    }
}

/* phase_variation._step_tangents, of one variation: what it is after a step. */
static void stepped(const double *start, const double *mid, const double *end, double h, double *v) {
    double own[2][2], rest[2], at_start[2], later[2];
    for (int c = 0; c < 2; ++c) {
        at_start[c] = start[c] * v[0] + start[2 + c] * v[1] + start[4 + c] * v[2];
        later[c] = end[4 + c] * v[2];
    }
    for (int c = 0; c < 2; ++c) {
        rest[c] = v[c] + h / 6.0 * (at_start[c] + 4.0 * mid[4 + c] * v[2] + later[c]);
        for (int k = 0; k < 2; ++k) {
            rest[c] += h * mid[2 * k + c] * (v[k] / 3.0 + h / 12.0 * (at_start[k] - later[k]));
            own[c][k] = (c == k) - h / 6.0 * (end[2 * k + c] + 2.0 * mid[2 * k + c]);
            for (int j = 0; j < 2; ++j) own[c][k] += h * h / 12.0 * mid[2 * j + c] * end[2 * k + j];
        }
    }
    double whole = own[0][0] * own[1][1] - own[0][1] * own[1][0];
    v[0] = (rest[0] * own[1][1] - own[0][1] * rest[1]) / whole;
    v[1] = (own[0][0] * rest[1] - own[1][0] * rest[0]) / whole;
}

/* phase_variation.vary_phase, of one step. */
static int vary(Run *r, Motion *m, const Step *taken) {
    double row[ROW] = {0.0}, start[6], mid[6], *end = m->reached;
    Motion between = *m;
    memcpy(start, m->reached, sizeof start);
    if (!m->is_varied && !slope_jacobian(r, &between, memcpy(row, taken->rows[0], sizeof row), start)) return 0;
    middle(m, taken, row);
    if (!slope_jacobian(r, &between, row, mid)) return 0;
    if (!slope_jacobian(r, m, memcpy(row, taken->rows[STAGES], sizeof row), end)) return 0;
    m->is_varied = 1;
    stepped(start, mid, end, taken->h, r->varied);
    return 1;
}
