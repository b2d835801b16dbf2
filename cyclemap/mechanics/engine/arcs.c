/* The contact of a foundation that is pressed, as what bounds it: sides, and arcs of conics, which
   are rational curves, summed by Gauss's rules. Where it is bounded is found in boundary.c, its
   pressure in foundation.c. */

enum { MOST_SIDES = 512, MOST_ARCS = 128, ARC_ROOM = 2 * MOST_ARCS };
/* Integrals of monomials over the contact. */
enum { OF_1, OF_X, OF_Y, OF_XX, OF_XY, OF_YY, OF_XXX, OF_XXY, OF_XYY, OF_YYY, MONOMIALS };
/* Load and moments: of 1, x and y; and what balances them, c and l. */
enum { LOAD, MOMENT_X, MOMENT_Y, BALANCE_SIZE };
/* Arcs are halved until their axis is this at least. */
static const double LEAST_AXIS = 1.8;
/* Arcs that turn by less than this are straight. */
static const double STRAIGHT_TURN = 1e-13;
/* Where P's gradient is less than this beside what P bends by along an arc the conic nearly falls
   into lines, and rounding hides which way an arc bends: it is straight. */
static const double NEARLY_DOUBLE = 1e-7;

/* An arc of a conic from a to b as a rational curve of Bezier's, c where the tangents at both ends
   meet, t = 1 - s: (t^2 a + 2 weight s t c + s^2 b) / (t^2 + 2 weight s t + s^2), 0 <= s <= 1. */
enum {
    CURVE_START_X,
    CURVE_START_Y,
    CURVE_MIDDLE_X,
    CURVE_MIDDLE_Y,
    CURVE_END_X,
    CURVE_END_Y,
    CURVE_WEIGHT,
    CURVE_SIZE
};
/* Arcs, or their images, by columns. */
typedef struct {
    int count;
    double of[CURVE_SIZE][ARC_ROOM + WIDTH];
} Arcs;

/* The balance at the last few orientations, the newest first, from which the next one is told. */
enum { REMEMBERED = 4 };
typedef struct {
    int count;
    double theta[REMEMBERED], lean[REMEMBERED][BALANCE_SIZE];
} Past;

/* The contact at an orientation: P, how it changes by each number of the shapes, and its boundary,
   the contact on the left, by columns; of sides WIDTH more as the first one. is_alone: no table
   knows the pressure where the object stands. */
typedef struct Pressed {
    double theta, pressure[QUADRATIC_SIZE], by_shape[SHAPE_SIZE][QUADRATIC_SIZE];
    double moments[MONOMIALS];
    double tolerance;
    int is_alone, is_known, has_moments, has_slopes, digits, side_count;
    double sides[EDGE_SIZE][MOST_SIDES + WIDTH];
    Arcs arcs;
    Past past;
} Pressed;

static inline double pressure_at(const double *p, double x, double y) {
    double along_x = p[Q_SLOPE_X] + p[Q_XX] * x + 2.0 * p[Q_XY] * y;
    return p[Q_LEVEL] + x * along_x + y * (p[Q_SLOPE_Y] + p[Q_YY] * y);
}

static ALWAYS_INLINE Wide taken(const double *from) {
    Wide x;
    memcpy(&x, from, sizeof x);
    return x;
}

static ALWAYS_INLINE Wide all(double x) { return (Wide){0.0} + x; }

/* One for the first so many, nought after them. */
static ALWAYS_INLINE Wide ones(int count) {
    static const double of[2 * WIDTH] = {1.0, 1.0, 1.0, 1.0};
    return taken(of + WIDTH - (count < WIDTH ? count : WIDTH));
}

static ALWAYS_INLINE double summed(const Wide *x) {
    return ((*x)[0] + (*x)[1]) + ((*x)[2] + (*x)[3]);
}

static void put_side(Pressed *at, const double *side) {
    for (int k = 0; k < EDGE_SIZE && at->side_count < MOST_SIDES; ++k)
        at->sides[k][at->side_count] = side[k];
    ++at->side_count;
}

/* What has no room is counted. */
static void put_arc(Arcs *arcs, const double *arc) {
    for (int k = 0; k < CURVE_SIZE && arcs->count < ARC_ROOM; ++k)
        arcs->of[k][arcs->count] = arc[k];
    ++arcs->count;
}

/* Arcs from the first on, of which the ends are known, as arcs of P = 0, P > 0 on their left: the
   turn of P's gradient, at most a right angle, is that of the arc. */
static WIDENED void bend_arcs(Pressed *at, int first) {
    const double *p = at->pressure;
    double (*arcs)[ARC_ROOM + WIDTH] = at->arcs.of;
    double bend = NEARLY_DOUBLE * (fabs(p[Q_XX]) + 2.0 * fabs(p[Q_XY]) + fabs(p[Q_YY]));
    for (int i = first; i < at->arcs.count; i += WIDTH) {
        Wide ax = taken(arcs[CURVE_START_X] + i), ex = taken(arcs[CURVE_END_X] + i) - ax;
        Wide ay = taken(arcs[CURVE_START_Y] + i), ey = taken(arcs[CURVE_END_Y] + i) - ay;
        Wide bent_x = 2.0 * (p[Q_XX] * ex + p[Q_XY] * ey);
        Wide bent_y = 2.0 * (p[Q_XY] * ex + p[Q_YY] * ey);
        Wide first_x = p[Q_SLOPE_X] + 2.0 * (p[Q_XX] * ax + p[Q_XY] * ay),
             last_x = first_x + bent_x;
        Wide first_y = p[Q_SLOPE_Y] + 2.0 * (p[Q_XY] * ax + p[Q_YY] * ay),
             last_y = first_y + bent_y;
        Wide turn = first_x * last_y - first_y * last_x;
        /* all squared */
        Wide start = first_x * first_x + first_y * first_y;
        Wide end = last_x * last_x + last_y * last_y, least = bend * bend * (ex * ex + ey * ey);
        Flags is_straight = turn * turn <= STRAIGHT_TURN * STRAIGHT_TURN * start * end;
        is_straight |= (start < least) | (end < least);
        /* c = a + along (-first_y, first_x): off both gradients */
        Wide along = (last_x * ex + last_y * ey) / turn, cx = -along * first_y;
        Wide cy = along * first_x, bulge = bent_x * ex + bent_y * ey;
        Wide bent = cx * (p[Q_XX] * cx + 2.0 * p[Q_XY] * cy) + p[Q_YY] * (cy * cy);
        Wide weight = roots(sizes(0.125 * bulge / bent));
        for (int k = 0; k < WIDTH; ++k) {
            arcs[CURVE_MIDDLE_X][i + k] = ax[k] + (is_straight[k] ? 0.5 * ex[k] : cx[k]);
            arcs[CURVE_MIDDLE_Y][i + k] = ay[k] + (is_straight[k] ? 0.5 * ey[k] : cy[k]);
            arcs[CURVE_WEIGHT][i + k] = is_straight[k] ? 1.0 : weight[k];
        }
    }
}

/* Halves an arc at s = 1/2: the first half takes its place. */
static void halve_arc(Arcs *arcs, int i) {
    double half[CURVE_SIZE], *weight = arcs->of[CURVE_WEIGHT] + i, share = 1.0 / (1.0 + *weight);
    for (int k = X; k <= Y; ++k) {
        double *a = arcs->of[CURVE_START_X + k] + i, *c = arcs->of[CURVE_MIDDLE_X + k] + i;
        double *b = arcs->of[CURVE_END_X + k] + i, before = share * (*a + *weight * *c);
        half[CURVE_MIDDLE_X + k] = share * (*b + *weight * *c);
        half[CURVE_START_X + k] = 0.5 * (before + half[CURVE_MIDDLE_X + k]);
        half[CURVE_END_X + k] = *b;
        *b = half[CURVE_START_X + k];
        *c = before;
    }
    *weight = half[CURVE_WEIGHT] = sqrt(0.5 * (1.0 + *weight));
    put_arc(arcs, half);
}

/* The square of the larger half axis of Bernstein's ellipse, about -1 to 1, in which an arc is
   analytic in 2 s - 1, is 1 + max(1, weight) over |1 - weight|: its poles are on the imaginary
   axis, of a hyperbola on the real one.

   Halves arcs from the first on until that is far, as long as there is room. */
static void halve_arcs(Arcs *arcs, int first) {
    const double least = LEAST_AXIS * LEAST_AXIS, *weight = arcs->of[CURVE_WEIGHT];
    for (int i = first; i < arcs->count; ++i)
        while (1.0 + fmax(1.0, weight[i]) < least * fabs(1.0 - weight[i])
               && arcs->count <= MOST_ARCS)
            halve_arc(arcs, i);
}

/* Which arcs have poles too near for one of Gauss's rules. On parabolas, whose poles are at
   infinity, sums are of degree 8: the least rule is exact. */
static ALWAYS_INLINE Flags has_poles(Wide weight, int digits, int rule) {
    return 1.5 + 0.5 * weight < (POLE_REACH[digits][rule] - 0.5) * sizes(1.0 - weight);
}

/* The first rule that serves an arc; one does, since arcs are halved. */
static int arc_rule(double weight, int digits) {
    int rule = LEAST_RULE;
    while (has_poles(all(weight), digits, rule)[0]) ++rule;
    return rule;
}

/* An arc where it lies, or its image; and twice the vector products of a and c (by the weight), a
   and b, c and b. */
typedef struct {
    double a[2], c[2], b[2], weight, ac, ab, cb;
} Curve;

static inline double across(const double *a, const double *b) { return a[X] * b[Y] - a[Y] * b[X]; }

static inline void close_curve(Curve *k) {
    k->ac = 2.0 * k->weight * across(k->a, k->c);
    k->ab = 2.0 * across(k->a, k->b);
    k->cb = 2.0 * k->weight * across(k->c, k->b);
}

static inline Curve curve_of(const Arcs *arcs, int i) {
    Curve k = {.weight = arcs->of[CURVE_WEIGHT][i]};
    for (int j = X; j <= Y; ++j) {
        k.a[j] = arcs->of[CURVE_START_X + j][i];
        k.c[j] = arcs->of[CURVE_MIDDLE_X + j][i];
        k.b[j] = arcs->of[CURVE_END_X + j][i];
    }
    close_curve(&k);
    return k;
}

/* What nodes on an arc take of a, c and b, before that is divided by `whole`; and of its vector
   products, times a share. */
typedef struct {
    Wide begun, bent, ended, whole, down, both, share;
} Shares;

/* Nodes j on of a rule. */
static ALWAYS_INLINE Shares shares_at(double weight, int j) {
    Shares of = {.begun = taken(BEGUN + j), .ended = taken(ENDED + j), .both = taken(BOTH + j)};
    of.bent = 2.0 * weight * of.both;
    of.whole = of.begun + of.bent + of.ended;
    of.down = 1.0 / of.whole;
    of.share = of.down * of.down * taken(BOUNDARY_WEIGHTS + j);
    return of;
}

static ALWAYS_INLINE Wide place_on(const Curve *k, const Shares *of, int j) {
    return of->begun * k->a[j] + of->bent * k->c[j] + of->ended * k->b[j];
}

/* x dy - y dx, by the weights of the nodes. */
static ALWAYS_INLINE Wide cone_on(const Curve *k, const Shares *of) {
    return (of->begun * k->ac + of->both * k->ab + of->ended * k->cb) * of->share;
}

/* Arcs with their nodes, WIDTH a stretch: so that one loop sums them all, whatever their rules. */
enum { LONGEST = LONGEST_RULE / WIDTH, MOST_STRETCHES = ARC_ROOM * LONGEST };
typedef struct {
    int curve_count, count;
    Curve curves[ARC_ROOM];
    struct {
        int curve, node;
    } of[MOST_STRETCHES];
} Stretches;

/* All that the longest rule has are written, those of its own are counted: nothing to mispredict. */
static ALWAYS_INLINE void put_stretches(Stretches *to, const Arcs *arcs, int i, int rule) {
    int first = BOUNDARY_FIRST[rule];
    for (int k = 0; k < LONGEST; ++k) {
        to->of[to->count + k].curve = to->curve_count;
        to->of[to->count + k].node = first + WIDTH * k;
    }
    to->count += (BOUNDARY_FIRST[rule + 1] - first) / WIDTH;
    to->curves[to->curve_count++] = curve_of(arcs, i);
}
