/* Friction under ellipses: even or leaning patches, and loads along the rim, by trapezoidal rules.
   docs/theory/ellipse-sums.md derives them.

   Patches: integrands are analytic and periodic: the error of n nodes falls with exp(-2 n delta),
   delta the distance of the nearest singularity from the real axis. Where that is short, tan t =
   beta tan x, beta = k^-1/2, takes a singularity from atanh(k) beside t = pi/2 to atanh(k^1/2)
   beside x = pi/2. The least number of nodes that does is taken from tables (RULES); beyond, it is
   Gauss's rule on panels no longer than their distance from singularities. Along rims it is even
   steps of an elliptic integral's argument, of which a few more do however near a singularity
   is. */

/* Rules up to this are not worth a beta, which costs a third more a node. */
enum { WORTH = 3 };
/* The exponent that errors along rims have at most. */
static const double RIM_DIGITS = 36.0;

/* An ellipse in the coordinates of its own unit disc, w = middle + omega M J diag(semi) x, and the
   centre of rotation: far: whether it lies outside; size: its distance from the centre, or one over
   it; away: the direction from it to the centre. */
typedef struct {
    Frame frame;
    double semi[2], slope[2], level, det, size, away[2];
    int far;
} Ellipse;

static Ellipse ellipse_of(const Friction *f, const double *geometry) {
    const double *g = geometry;
    Ellipse e = {.frame = frame_of(f, g[CHORD_X], g[CHORD_Y], g[CHORD_SEMI_X], g[CHORD_SEMI_Y]),
                 .semi = {g[CHORD_SEMI_X], g[CHORD_SEMI_Y]}};
    const double *v = f->twist, *spin = e.frame.spin, *middle = e.frame.middle;
    e.det = spin[M_XX] * spin[M_YY] - spin[M_YX] * spin[M_XY];
    double px = (spin[M_YY] * middle[X] - spin[M_XY] * middle[Y]) / e.det;
    double py = (spin[M_XX] * middle[Y] - spin[M_YX] * middle[X]) / e.det;
    double p = size_of(px, py), omega = fabs(v[OMEGA]), sign = v[OMEGA] < 0.0 ? -1.0 : 1.0;
    /* the centre of rotation is -(px, py) / omega */
    e.far = p > omega;
    e.size = e.far ? omega / p : p / omega;
    e.away[X] = p > 0.0 ? sign * px / p : 1.0;
    e.away[Y] = p > 0.0 ? sign * py / p : 0.0;
    return e;
}

/* Squared hyperbolic cosine of the distance from the real axis of x, tan x = tan t / beta, sin^2 t
   = z; z at infinity: the singularity that beta brings. */
static double distance_of(double complex z, double beta) {
    double square = beta * beta, x = creal(z), y = cimag(z);
    double size = size_of(square * (1.0 - x) + x, y - square * y);
    return (size_of(x, y) + square * size_of(1.0 - x, y) + size) / (2.0 * size);
}

/* The least rule of which `reach` admits singularities at both places, the first real, and the beta
   that it takes; RULE_COUNT: none. */
static int rule_for(const double *reach, double first, double complex second, double *beta) {
    int plain = 0, bent = 0;
    double nearest = fmin(first, distance_of(second, 1.0));
    *beta = 1.0;
    while (plain < RULE_COUNT && !(nearest >= reach[plain])) ++plain;
    if (plain <= WORTH) return plain;
    double tried = 1.0 / sqrt(sqrt(1.0 - 1.0 / first));
    nearest = fmin(fmin(distance_of(first, tried), distance_of(second, tried)),
                   tried * tried / (tried * tried - 1.0));
    while (bent < RULE_COUNT && !(nearest >= reach[bent])) ++bent;
    if (bent + 1 >= plain) return plain;
    *beta = tried;
    return bent;
}

/* Derivative of the wrench as M moves, of chords of a pressure f0 + tau f1, |tau| <= q, from their
   middles p along e; u: the one direction in which a chord moves. */
typedef struct {
    Lanes ux, uy, mx, my, ex, ey, level, rise, first, second, by_speed, half;
} Chords;

static void move_chords(Friction *f, const Chords *c, double load) {
    for (int k = 0; k < LANES; ++k) {
        double f0 = c->level[k], f1 = c->rise[k], first = c->first[k], second = c->second[k];
        double by_speed = c->by_speed[k], q = c->half[k], two = 2.0 * q;
        double cube = 2.0 / 3.0 * q * q * q;
        /* int (first + second tau) (f0 + f1 tau) (1, tau), and int (f0 + f1 tau) (1, tau, tau^2)
           by_speed */
        const double given[] = {c->ux[k],
                                c->uy[k],
                                c->mx[k],
                                c->my[k],
                                c->ex[k],
                                c->ey[k],
                                two * first * f0 + cube * second * f1,
                                cube * (first * f1 + second * f0),
                                two * f0 * by_speed,
                                cube * f1 * by_speed,
                                cube * f0 * by_speed};
        double found[WRENCH], *results[] = {found};
        const double *all[] = {f->twist, f->matrix, given, f->toward};
        chord_toward(all, results, 0, 0, 0);
        add(f->friction, found, load, WRENCH);
    }
}

/* Chords through the centre of rotation at angles t, for a width of them: along each, all of it
   moves along one direction u. Outside, a chord's distance from the middle is sin t; inside, its
   angle from the direction to the middle is t. root: of 1 - (size sin t)^2. */
static ALWAYS_INLINE void add_chords(Friction *f, const Ellipse *e, int far, int leans,
                                     const Lanes *cosine, const Lanes *sine, const Lanes *root,
                                     const Lanes *width, double load, Sums *sums) {
    Lanes c = *cosine, s = *sine, ex, ey, offset, q, wx, wy, first, second;
    if (far) {
        Lanes across = e->size * s;
        ex = *root * e->away[X] - across * e->away[Y];
        ey = *root * e->away[Y] + across * e->away[X];
        offset = s;
        q = c;
    } else {
        ex = c * e->away[X] - s * e->away[Y];
        ey = c * e->away[Y] + s * e->away[X];
        offset = e->size * s;
        q = *root;
    }
    /* the images of the directions along and across the chord */
    const double *t = e->frame.spin;
    Lanes tx = t[M_XX] * ex + t[M_XY] * ey, ty = t[M_YX] * ex + t[M_YY] * ey;
    Lanes nx = (t[M_XY] * ex - t[M_XX] * ey) * offset, ny = (t[M_YY] * ex - t[M_YX] * ey) * offset;
    if (far) {
        wx = e->frame.middle[X] + e->frame.omega * nx;
        wy = e->frame.middle[Y] + e->frame.omega * ny;
    } else {
        wx = e->frame.omega * tx;
        wy = e->frame.omega * ty;
    }
    Lanes speed = wx * wx + wy * wy;
    speed = rooted(speed);
    Lanes slowness = 1.0 / speed, ux = wx * slowness, uy = wy * slowness, steep = ux * tx + uy * ty;
    Lanes by_speed;
    if (far) {
        first = *width * c;
        by_speed = first * slowness;
        second = by_speed * (e->frame.omega * steep);
    } else {
        first = *width * c * e->size;
        second = *width;
        by_speed = *width * slowness;
    }
    /* the pressure along the chord is f0 + tau f1, |tau| <= q */
    Lanes px = -e->semi[X] * ey * offset, py = e->semi[Y] * ex * offset;
    Lanes f0 = e->level + e->slope[X] * px + e->slope[Y] * py;
    Lanes f1 = e->slope[X] * e->semi[X] * ex + e->slope[Y] * e->semi[Y] * ey;
    if (f->toward) {
        const Chords of = {ux, uy, px,    py,     e->semi[X] * ex, e->semi[Y] * ey,
                           f0, f1, first, second, by_speed,        q};
        move_chords(f, &of, load);
        return;
    }
    Lanes two = 2.0 * q, cube = two * q * q * (1.0 / 3.0), even = two * first, odd = cube * second;
    Lanes k = two * by_speed;
    if (leans) {
        even = even * f0 + odd * f1;
        odd = odd * f0 + cube * first * f1;
        k *= f0;
    }
    Lanes middle = ux * ny - uy * nx, kx = -k * uy, ky = k * ux;
    sums->of[FORCE_X] += even * ux;
    sums->of[FORCE_Y] += even * uy;
    sums->of[TORQUE] += even * (ux * nx + uy * ny) + odd * steep;
    sums->of[XX] -= kx * uy;
    sums->of[XY] += kx * ux;
    sums->of[YY] += ky * ux;
    sums->of[XW] += kx * middle;
    sums->of[YW] += ky * middle;
    sums->of[WW] += k * middle * middle;
}

/* Lanes pairs of chords at angles t and -t. */
static ALWAYS_INLINE void add_pairs(Friction *f, const Ellipse *e, int far, int leans,
                                    const Lanes *c, const Lanes *s, const Lanes *width, double load,
                                    Sums *sums) {
    Lanes root = 1.0 - (e->size * *s) * (e->size * *s), opposite = -*s;
    root = rooted(root);
    add_chords(f, e, far, leans, c, s, &root, width, load, sums);
    add_chords(f, e, far, leans, c, &opposite, &root, width, load, sums);
}

/* sin^2 of where, beside the ends, the speed along a chord vanishes: in the direction that is
   mapped on the image's shorter axis, at the complex angle atanh(ratio of the axes) from it. */
static double complex slowest(const Ellipse *e) {
    const double *t = e->frame.spin;
    double xx = t[M_XX], yx = t[M_YX], xy = t[M_XY], yy = t[M_YY];
    double stretch = xx * xx + yx * yx - xy * xy - yy * yy, mixed = 2.0 * (xx * xy + yx * yy);
    double half = (xx * xx + yx * yx + xy * xy + yy * yy) / 2.0;
    double apart = size_of(stretch, mixed) / 2.0;
    /* cosh and sinh of twice that angle; the double angle between the slow direction and the one to
       the middle */
    if (apart < 1e-12 * half) return 1e24;
    double wide = half / apart, deep = fabs(e->det) / apart, ax = e->away[X], ay = e->away[Y];
    double twice_c = ax * ax - ay * ay, twice_s = 2.0 * ax * ay, along_c = -stretch / (2.0 * apart);
    double along_s = -mixed / (2.0 * apart);
    double cosine = along_c * twice_c + along_s * twice_s;
    double sine = along_s * twice_c - along_c * twice_s;
    double complex z = (1.0 - cosine * wide + I * sine * deep) / 2.0;
    return e->far ? z / fmax(e->size * e->size, 1e-24) : z;
}

/* How wide a panel from t on may be, to reach no farther than the singularities are away, nor over
   the end. */
static double panel_width(const double complex *at, int count, double t, double end) {
    double width = end - t;
    for (int k = 0; k < count; ++k) {
        double ahead = creal(at[k]) - t, away = cimag(at[k]);
        width = fmin(width, ahead > 0.0 ? fmax(away, ahead / 2.0) : hypot(away, ahead));
    }
    return fmax(width, 1e-15);
}

static ALWAYS_INLINE void add_rule(Friction *f, const Ellipse *e, int far, int leans, int rule,
                                   double beta, double load, Sums *sums) {
    Lanes width = (Lanes){0.0} + 1.0 / RULES[rule];
    Sums all = *sums;
    for (int j = FIRST_NODE[rule]; j < FIRST_NODE[rule + 1]; j += LANES) {
        Lanes c, s, wide = width;
        memcpy(&c, NODE_COSINES + j, sizeof c);
        memcpy(&s, NODE_SINES + j, sizeof s);
        if (beta != 1.0) {
            Lanes norm = c * c + beta * beta * s * s;
            wide = width * beta / norm;
            norm = rooted(norm);
            c /= norm;
            s *= beta / norm;
        }
        add_pairs(f, e, far, leans, &c, &s, &wide, load, &all);
    }
    *sums = all;
}

static void add_patch(Friction *f, const double *geometry, double load) {
    Ellipse e = ellipse_of(f, geometry);
    e.slope[X] = geometry[CHORD_SLOPE_X];
    e.slope[Y] = geometry[CHORD_SLOPE_Y];
    e.level = geometry[CHORD_LEVEL];
    Sums sums = {0};
    double size = fmin(fmax(e.size, 1e-12), 1.0 - 1e-15), beta;
    double complex slow = slowest(&e);
    int rule = rule_for(PATCH_REACH, 1.0 / (size * size), slow, &beta);
    if (rule < RULE_COUNT) {
        if (e.far && e.level == 1.0)
            add_rule(f, &e, 1, 0, rule, beta, load, &sums);
        else if (e.far)
            add_rule(f, &e, 1, 1, rule, beta, load, &sums);
        else if (e.level == 1.0)
            add_rule(f, &e, 0, 0, rule, beta, load, &sums);
        else
            add_rule(f, &e, 0, 1, rule, beta, load, &sums);
    } else {
        double complex t = casin(csqrt(slow)), near = fabs(creal(t)) + I * fabs(cimag(t));
        const double complex at[] = {M_PI / 2.0 + I * acosh(1.0 / size), near, M_PI - conj(near),
                                     -near};
        for (double from = 0.0; from < M_PI / 2.0;) {
            double wide = panel_width(at, 4, from, M_PI / 2.0);
            for (int j = 0; j < PANEL_ORDER; j += LANES) {
                Lanes c, s, width;
                for (int k = 0; k < LANES; ++k) {
                    double x = from + wide * (1.0 + GAUSS_NODES[j + k]) / 2.0;
                    c[k] = cos(x);
                    s[k] = sin(x);
                    width[k] = wide * GAUSS_WEIGHTS[j + k] / (2.0 * M_PI);
                }
                add_pairs(f, &e, e.far, 1, &c, &s, &width, load, &sums);
            }
            from += wide;
        }
    }
    if (!f->toward) add_sums(f, &e.frame, &sums, load);
}

/* Places on the rim, in the unit disc's coordinates. */
static inline void add_rim_places(Friction *f, const Ellipse *e, const Lanes *x, const Lanes *y,
                                  const Lanes *share, double load, Sums *sums) {
    const double *at = e->frame.at;
    if (!f->toward) add_places(&e->frame, x, y, share, sums);
    for (int k = 0; k < LANES && f->toward; ++k)
        move_point(f, at[X] + e->semi[X] * (*x)[k], at[Y] + e->semi[Y] * (*y)[k],
                   load * (*share)[k]);
}

/* A motion that leaves the middle nearer to the rim than this is rounded too much. */
static const double SHALLOW = 1e-3;
/* Roots nearer to the rim than this lie so far inside. */
static const double ON_RIM = 1e-13;

/* Without the care for what is infinite that the language takes. */
static double size(double complex z) { return size_of(creal(z), cimag(z)); }

static double complex quotient(double complex a, double complex b) {
    double x = creal(b), y = cimag(b), square = 1.0 / (x * x + y * y);
    return (creal(a) * x + cimag(a) * y) * square + I * ((cimag(a) * x - creal(a) * y) * square);
}

/* Jacobi's sn, cn, dn. */
typedef struct {
    double s, c, d;
} Jacobi;

/* Those of a sum of arguments: 1 - k^2 s^2 t^2 as a sum of squares. */
static Jacobi jacobi_sum(Jacobi u, Jacobi v, double square) {
    double down = 1.0 / (u.c * u.c + u.s * u.s * v.d * v.d);
    return (Jacobi){(u.s * v.c * v.d + v.s * u.c * u.d) * down,
                    (u.c * v.c - u.s * v.s * u.d * v.d) * down,
                    (u.d * v.d - square * u.s * v.s * u.c * v.c) * down};
}

/* How the rim is gone around: z = way (Z + middle) / (1 + conj(middle) Z), Z = -cd(v) + i k' sd(v)
   and its images in both axes, v evenly spaced. quarter: nodes from one axis to the other; step: of
   v; first: Jacobi's functions of half of it. */
typedef struct {
    double complex way, middle;
    double modulus, step;
    int quarter;
    Jacobi first;
} Round;

/* w = p z + c + q / z vanishes at two places; inside the unit circle they or their mirror images
   are `at`, by `left` 1 - |at|^2 away from it. A motion of the hyperbolic plane takes them to -s
   and s; then |w| is Legendre's root, of modulus 2 s / (1 + s^2), times what is rational, and by v
   integrands are elliptic: singular at i K', and where z = 0. */
static Round round_of(const double complex *at, const double *left) {
    enum { MOST = 8 };
    double complex across = 1.0 - conj(at[0]) * at[1], apart = quotient(at[1] - at[0], across);
    double k = sqrt(left[0] * left[1]) / size(across);
    double complex half = apart / (1.0 + k);
    double complex middle = quotient(half + at[0], 1.0 + conj(at[0]) * half);
    double complex to = quotient(at[1] - middle, 1.0 - conj(middle) * at[1]);
    double reach = size(to);
    Round r = {.way = reach > 0.0 ? to / reach : 1.0, .modulus = k};
    r.middle = middle * conj(r.way);
    /* Landen's steps: means for K and Jacobi's functions, the height of z = 0, and what is left of
       the modulus */
    double a[MOST + 1] = {1.0}, b[MOST + 1] = {k}, scale = 1.0, small = 1.0, height = INFINITY;
    double complex q = -r.middle * r.middle;
    int n = 0;
    for (; n < MOST && small > 1e-9; ++n) {
        small = (a[n] - b[n]) / (a[n] + b[n]);
        a[n + 1] = (a[n] + b[n]) / 2.0;
        b[n + 1] = sqrt(a[n] * b[n]);
        scale *= (1.0 + small) / 2.0;
        q *= quotient(q + small, 1.0 + small * q);
        /* smaller ones are but rounding */
        if (small <= 1e-6 && n > 0) continue;
        height = scale * fmin(-log(fmax(size(q), 1e-300)) / 2.0, log(4.0 / fmax(small, 1e-16)));
    }
    double mean = a[n], quarter = M_PI / (2.0 * mean);
    r.quarter = 2 * (int)ceil(fmax(RIM_DIGITS * quarter / (4.0 * M_PI * height), 2.0));
    r.step = quarter / r.quarter;
    double angle = mean * r.step / 2.0, sine = sin(angle), up = cos(angle) / sine;
    double cotangent = mean * up, d = 1.0;
    for (int i = n - 1; i >= 0; --i) {
        up *= cotangent;
        cotangent *= d;
        d = (b[i] + up) / (a[i] + up);
        up = cotangent / a[i];
    }
    sine = 1.0 / sqrt(cotangent * cotangent + 1.0);
    r.first = (Jacobi){sine, cotangent * sine, d};
    return r;
}

/* The same by panels that are no longer than singularities are away, where rounding leaves little
   of such steps. */
static void add_rim_panels(Friction *f, const Ellipse *e, const double complex *at,
                           const double *left, double load, Sums *sums) {
    int near = left[1] < left[0];
    double begin = carg(at[near]), apart = carg(at[!near] * conj(at[near]));
    double complex places[6];
    double complex aside = apart - I * log1p(-fmin(left[!near], 0.999)) / 2.0;
    for (int k = 0; k < 6; ++k)
        places[k] = (k % 2 ? aside : I * left[near] / 2.0) + 2.0 * M_PI * (k / 2 - 1);
    for (double tau = 0.0; tau < 2.0 * M_PI;) {
        double wide = panel_width(places, 6, tau, 2.0 * M_PI);
        for (int j = 0; j < PANEL_ORDER; j += LANES) {
            Lanes x, y, share;
            for (int k = 0; k < LANES; ++k) {
                double angle = begin + tau + wide * (1.0 + GAUSS_NODES[j + k]) / 2.0;
                x[k] = cos(angle);
                y[k] = sin(angle);
                share[k] = wide * GAUSS_WEIGHTS[j + k] / (4.0 * M_PI);
            }
            add_rim_places(f, e, &x, &y, &share, load, sums);
        }
        tau += wide;
    }
}

/* A load along the rim, even in the eccentric angle (the derivative of the even patch by its
   scale), z = exp(i angle). */
static void add_rim(Friction *f, const double *geometry, double load) {
    Ellipse e = ellipse_of(f, geometry);
    Sums sums = {0};
    const double *t = e.frame.spin;
    double complex c = e.frame.middle[X] + I * e.frame.middle[Y];
    double complex p = e.frame.omega * ((t[M_XX] + t[M_YY]) + I * (t[M_YX] - t[M_XY])) / 2.0;
    double complex q = e.frame.omega * ((t[M_XX] - t[M_YY]) + I * (t[M_YX] + t[M_XY])) / 2.0;
    double complex root = csqrt(c * c - 4.0 * p * q);
    double complex b = -(creal(conj(c) * root) >= 0.0 ? c + root : c - root) / 2.0, at[2] = {0.0};
    const double complex over[] = {b, q}, under[] = {p, b};
    double left[] = {1.0, 1.0};
    for (int k = 0; k < 2; ++k) {
        double top = size(over[k]), bottom = size(under[k]), larger = fmax(top, bottom);
        if (!(larger > 0.0)) continue;
        at[k] = bottom >= top ? quotient(over[k], under[k]) : conj(quotient(under[k], over[k]));
        left[k] = fabs(bottom - top) * (top + bottom) / (larger * larger);
        if (left[k] >= ON_RIM) continue;
        left[k] = ON_RIM;
        at[k] *= 1.0 - ON_RIM / 2.0;
    }
    Round r = round_of(at, left);
    Jacobi now = r.first, step = jacobi_sum(now, now, 1.0 - r.modulus * r.modulus);
    double ax = creal(r.middle), ay = cimag(r.middle), cx = creal(r.way), sx = cimag(r.way);
    double inside = 1.0 - ax * ax - ay * ay, whole = r.step * inside / (2.0 * M_PI);
    if (inside < SHALLOW) add_rim_panels(f, &e, at, left, load, &sums);
    for (int j = 0; j < r.quarter && inside >= SHALLOW;
         j += 2, now = jacobi_sum(now, step, 1.0 - r.modulus * r.modulus)) {
        /* v, and K - v */
        Lanes far = {now.c / now.d, now.s}, aside = {r.modulus * now.s / now.d, now.c};
        Lanes dense = {r.modulus / now.d, now.d};
        for (int image = 0; image < 4; ++image) {
            Lanes down = 1.0 + ax * far + ay * aside, up = ax * aside - ay * far;
            Lanes part = 1.0 / (down * down + up * up);
            Lanes x = ((far + ax) * down + (aside + ay) * up) * part;
            Lanes y = ((aside + ay) * down - (far + ax) * up) * part;
            Lanes place_x = cx * x - sx * y, place_y = sx * x + cx * y;
            Lanes share = whole * dense * part;
            add_rim_places(f, &e, &place_x, &place_y, &share, load, &sums);
            if (image % 2)
                far = -far;
            else
                aside = -aside;
        }
    }
    if (!f->toward) add_sums(f, &e.frame, &sums, load);
}
