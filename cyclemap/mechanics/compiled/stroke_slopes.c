/* How the end of a step varies with its start: phase_variation.py in C. */

/* phase_variation._nodes, of one: 0 where a tangent is not to be trusted. */
static int node(Motion *m, const double *row, Node *at) {
    int n = m->law->unknowns;
    if (kinked(m, row)) return 0;
    const double *toward = variation(m, row, row + UNKNOWN, at->by)->toward, *slope = row + SLOPE;
    memcpy(at->row, row, sizeof at->row);
    for (int c = 0; c < 2; ++c) at->bend[c] = at->by[c] * slope[0] + at->by[2 + c] * slope[1];
    for (int k = 0; k < n; ++k) at->drift[k] = toward[k] * slope[0] + toward[n + k] * slope[1];
    return at->is_known = 1;
}

/* phase_variation._middles, of one. */
static int middle(Run *r, Motion m, const Node *start, const Node *end, double h, Node *at) {
    double row[ROW] = {0.0}, report[4];
    int n = m.law->unknowns;
    for (int c = 0; c < 2; ++c)
        row[c] = (start->row[c] + end->row[c]) / 2.0 + h * 5.0 / 32.0 * (start->row[SLOPE + c] - end->row[SLOPE + c])
                 + h * h / 64.0 * (start->bend[c] + end->bend[c]);
    for (int k = 0; k < n; ++k) {
        m.z[k] = (start->row[UNKNOWN + k] + end->row[UNKNOWN + k]) / 2.0 + h / 8.0 * (start->drift[k] - end->drift[k]);
        row[UNKNOWN + k] = m.z[k];
    }
    if (!node(&m, row, at)) return 0;
    for (int k = 0; k < n; ++k)
        if (!(fabs(m.tangent.found[n + k]) <= MIDDLE)) return evaluate(r, &m, row, row, report) && node(&m, row, at);
    return 1;
}

/* phase_variation._step_tangents, of one variation: what it is after a step. */
static void stepped(const Node *start, const Node *mid, const Node *end, double h, double *v) {
    double own[2][2], rest[2], at_start[2], later[2];
    for (int c = 0; c < 2; ++c) {
        at_start[c] = start->by[c] * v[0] + start->by[2 + c] * v[1] + start->by[4 + c] * v[2];
        later[c] = end->by[4 + c] * v[2];
    }
    for (int c = 0; c < 2; ++c) {
        rest[c] = v[c] + h / 6.0 * (at_start[c] + 4.0 * mid->by[4 + c] * v[2] + later[c]);
        for (int k = 0; k < 2; ++k) {
            rest[c] += h * mid->by[2 * k + c] * (v[k] / 3.0 + h / 12.0 * (at_start[k] - later[k]));
            own[c][k] = (c == k) - h / 6.0 * (end->by[2 * k + c] + 2.0 * mid->by[2 * k + c]);
            for (int j = 0; j < 2; ++j) own[c][k] += h * h / 12.0 * mid->by[2 * j + c] * end->by[2 * k + j];
        }
    }
    double whole = own[0][0] * own[1][1] - own[0][1] * own[1][0];
    v[0] = (rest[0] * own[1][1] - own[0][1] * rest[1]) / whole;
    v[1] = (own[0][0] * rest[1] - own[1][0] * rest[0]) / whole;
}

/* phase_variation.vary_phase, of one step. */
static int vary(Run *r, Motion *m, const Step *taken) {
    Node start = m->reached, mid;
    if (!start.is_known && !node(m, taken->rows[0], &start)) return 0;
    if (!node(m, taken->rows[STAGES], &m->reached)) return 0;
    if (!middle(r, *m, &start, &m->reached, taken->h, &mid)) return 0;
    stepped(&start, &mid, &m->reached, taken->h, r->varied);
    return 1;
}
