/* The contact of a foundation that is pressed, as what bounds it: sides, and arcs of conics, which
   are rational curves, with the nodes of the rules by which they are summed. Where it is bounded
   is found in boundary.c, its pressure in foundation.c. */

enum { MOST_SIDES = 512, MOST_ARCS = 256, MOST_NODES = 1024 };
/* Integrals of monomials over the contact. */
enum { OF_1, OF_X, OF_Y, OF_XX, OF_XY, OF_YY, OF_XXX, OF_XXY, OF_XYY, OF_YYY, MONOMIALS };
/* Load and moments: of 1, x and y; and what balances them, c and l. */
enum { LOAD, MOMENT_X, MOMENT_Y, BALANCE_SIZE };
/* Arcs are halved until their axis is this at least. */
static const double LEAST_AXIS = 1.8;
enum { MOST_HALVINGS = 6 };
/* Arcs that turn by less than this are sides. */
static const double STRAIGHT_TURN = 1e-13;
/* Where P's gradient is less than this beside what P bends by along an arc the conic nearly falls
   into lines, and rounding hides which way an arc bends: it is straight. */
static const double NEARLY_DOUBLE = 1e-7;
/* An arc of a conic from a to b as a rational curve of Bezier's, c where the tangents at both ends
   meet, t = 1 - s: (t^2 a + 2 weight s t c + s^2 b) / (t^2 + 2 weight s t + s^2), 0 <= s <= 1.
   rule: Gauss's that its poles ask for; first: of its nodes. */
typedef struct {
    double a[2], b[2], c[2], weight;
    int rule, first;
} Arc;

/* Nodes of Gauss's rules on arcs, and how the arcs go on there, times the weights; WIDTH of noughts
   after them. */
typedef struct {
    int count;
    double x[MOST_NODES], y[MOST_NODES], dx[MOST_NODES], dy[MOST_NODES];
} Nodes;

/* The balance at the last few orientations, the newest first, from which the next one is told. */
enum { REMEMBERED = 4 };
typedef struct {
    int count;
    double theta[REMEMBERED], lean[REMEMBERED][BALANCE_SIZE];
} Past;

/* The contact at an orientation: P, how it changes by each number of the shapes, and its boundary,
   the contact on the left, sides by columns, WIDTH more as the first one. is_alone: no table knows
   the pressure where the object stands. */
typedef struct Pressed {
    double theta, pressure[QUADRATIC_SIZE], by_shape[SHAPE_SIZE][QUADRATIC_SIZE];
    double moments[MONOMIALS];
    double tolerance;
    int is_alone, is_known, has_moments, has_slopes, digits, side_count, arc_count;
    double sides[EDGE_SIZE][MOST_SIDES + WIDTH];
    Arc arcs[MOST_ARCS];
    Nodes nodes;
    Past past;
} Pressed;

static inline double pressure_at(const double *p, double x, double y) {
    double along_x = p[Q_SLOPE_X] + p[Q_XX] * x + 2.0 * p[Q_XY] * y;
    return p[Q_LEVEL] + x * along_x + y * (p[Q_SLOPE_Y] + p[Q_YY] * y);
}

static inline void gradient_at(const double *p, double x, double y, double *to) {
    to[X] = p[Q_SLOPE_X] + 2.0 * (p[Q_XX] * x + p[Q_XY] * y);
    to[Y] = p[Q_SLOPE_Y] + 2.0 * (p[Q_XY] * x + p[Q_YY] * y);
}

static void put_side(Pressed *at, const double *side) {
    for (int k = 0; k < EDGE_SIZE && at->side_count < MOST_SIDES; ++k)
        at->sides[k][at->side_count] = side[k];
    ++at->side_count;
}

/* The larger half axis of Bernstein's ellipse, about -1 to 1, in which an arc is analytic in 2 s - 1,
   as the square of a quotient. Its poles are on the imaginary axis, of a hyperbola on the real
   one. */
typedef struct {
    double above, below;
} Axis;

static Axis axis_of(double weight) {
    return (Axis){weight < 1.0 ? 2.0 : 1.0 + weight, fabs(1.0 - weight)};
}

/* The first of Gauss's rules that serves an arc with such poles. On parabolas, whose poles are at
   infinity, sums are of degree 8: six nodes at least. */
enum { LEAST_RULE = 1 };
static int arc_rule(Axis axis, int digits) {
    int rule = LEAST_RULE;
    while (rule < BOUNDARY_RULE_COUNT && axis.above < axis.below * POLE_REACH[digits][rule]) ++rule;
    return rule;
}

static ALWAYS_INLINE Wide all(double x) { return (Wide){0.0} + x; }

/* Nodes of a rule on the panel of an arc from low to high in 2 s - 1; whether there was room. */
static WIDENED int put_nodes(Nodes *to, const Arc *arc, int rule, double low, double high) {
    int first = BOUNDARY_FIRST[rule], count = BOUNDARY_FIRST[rule + 1] - first;
    if (to->count + count + 2 * WIDTH > MOST_NODES) return 0;
    const double *a = arc->a, *b = arc->b, *c = arc->c, twice = 2.0 * arc->weight;
    double half = 0.5 * (high - low), middle = 0.5 + 0.25 * (low + high);
    for (int j = 0; j < count; j += WIDTH) {
        int at = to->count + j;
        Wide node, share;
        memcpy(&node, BOUNDARY_NODES + first + j, sizeof node);
        memcpy(&share, BOUNDARY_WEIGHTS + first + j, sizeof share);
        Wide s = middle + 0.5 * half * node, t = 1.0 - s;
        Wide begun = t * t, ended = s * s, both = s * t;
        both += both;
        Wide bent = arc->weight * both, down = 1.0 / (begun + bent + ended);
        Wide x = (begun * a[X] + bent * c[X] + ended * b[X]) * down;
        Wide y = (begun * a[Y] + bent * c[Y] + ended * b[Y]) * down;
        share *= half * (down * down);
        begun *= twice;
        ended *= twice;
        Wide dx = begun * (c[X] - a[X]) + both * (b[X] - a[X]) + ended * (b[X] - c[X]);
        Wide dy = begun * (c[Y] - a[Y]) + both * (b[Y] - a[Y]) + ended * (b[Y] - c[Y]);
        dx *= share;
        dy *= share;
        memcpy(to->x + at, &x, sizeof x);
        memcpy(to->y + at, &y, sizeof y);
        memcpy(to->dx + at, &dx, sizeof dx);
        memcpy(to->dy + at, &dy, sizeof dy);
    }
    to->count += count;
    double *columns[] = {to->x, to->y, to->dx, to->dy};
    for (int k = 0; k < 4; ++k) memset(columns[k] + to->count, 0, sizeof(Wide));
    return 1;
}

static void put_arc(Pressed *at, const Arc *arc) {
    if (at->arc_count < MOST_ARCS) {
        Arc *to = at->arcs + at->arc_count;
        *to = *arc;
        to->rule = arc_rule(axis_of(arc->weight), at->digits);
        to->first = at->nodes.count;
        int rule = to->rule < BOUNDARY_RULE_COUNT ? to->rule : BOUNDARY_RULE_COUNT - 1;
        /* without room for its nodes there are too many arcs */
        if (!put_nodes(&at->nodes, to, rule, -1.0, 1.0)) at->arc_count = MOST_ARCS;
    }
    ++at->arc_count;
}

/* The arc of P = 0 from a to b, P > 0 on its left: the turn of P's gradient, at most a right angle,
   is that of the arc. */
static void add_arc(Pressed *at, const double *a, const double *b) {
    const double *p = at->pressure, ex = b[X] - a[X], ey = b[Y] - a[Y];
    double first[2], last[2];
    gradient_at(p, a[X], a[Y], first);
    gradient_at(p, b[X], b[Y], last);
    double turn = first[X] * last[Y] - first[Y] * last[X];
    /* all squared */
    double start = first[X] * first[X] + first[Y] * first[Y];
    double end = last[X] * last[X] + last[Y] * last[Y];
    double bend = NEARLY_DOUBLE * (fabs(p[Q_XX]) + 2.0 * fabs(p[Q_XY]) + fabs(p[Q_YY]));
    double least = bend * bend * (ex * ex + ey * ey);
    int is_bent = turn * turn > STRAIGHT_TURN * STRAIGHT_TURN * start * end;
    if (!is_bent || start < least || end < least) {
        const double side[] = {a[X], a[Y], b[X], b[Y]};
        put_side(at, side);
        return;
    }
    /* c = a + along (-first_y, first_x): off both gradients */
    double along = (last[X] * ex + last[Y] * ey) / turn, cx = -along * first[Y];
    double cy = along * first[X];
    double bulge = p[Q_XX] * ex * ex + 2.0 * p[Q_XY] * ex * ey + p[Q_YY] * ey * ey;
    double bent = p[Q_XX] * cx * cx + 2.0 * p[Q_XY] * cx * cy + p[Q_YY] * cy * cy;
    Arc whole = {
        .a = {a[X], a[Y]},
        .b = {b[X], b[Y]},
        .c = {a[X] + cx, a[Y] + cy},
        .weight = sqrt(fabs(0.25 * bulge / bent)),
    };
    /* halves meet at s = 1/2 until poles are far */
    int halvings = 0;
    Axis axis = axis_of(whole.weight);
    for (double weight = whole.weight;
         halvings < MOST_HALVINGS && axis.above < LEAST_AXIS * LEAST_AXIS * axis.below;
         ++halvings) {
        weight = sqrt(0.5 * (1.0 + weight));
        axis = axis_of(weight);
    }
    if (!halvings) {
        put_arc(at, &whole);
        return;
    }
    for (int i = 0; i < 1 << halvings; ++i) {
        Arc arc = whole;
        for (int level = halvings - 1; level >= 0; --level) {
            double share = 1.0 / (1.0 + arc.weight);
            Arc half = arc;
            int later = i >> level & 1;
            for (int k = 0; k < 2; ++k) {
                double before = share * (arc.a[k] + arc.weight * arc.c[k]);
                double after = share * (arc.b[k] + arc.weight * arc.c[k]);
                *(later ? half.a + k : half.b + k) = 0.5 * (before + after);
                half.c[k] = later ? after : before;
            }
            half.weight = sqrt(0.5 * (1.0 + arc.weight));
            arc = half;
        }
        put_arc(at, &arc);
    }
}
