/* Pushes, drags and whole cycles of a slider: one library for every object. It is compiled as one
   piece:

   kernels.c   written when the package is built: names of schema.py, CasADi's functions of
               equations.py, and the tables of generate.py
   pressure.c  wrench and Hessian of friction: what edges, lines and points add, and their sum
   ellipse.c   what elliptic patches and rims add
   arcs.c      what bounds the contact of a foundation that is pressed: sides and arcs of conics
   boundary.c  where its boundary is, under a pressure
   foundation.c  its pressure, by the balance of load and moment
   cones.c     friction over such a contact
   friction.c  friction of either pressure, and its derivatives
   contact.c   a rod on a piece of its contact curve, in the ring or in a wedge; its unknowns,
               solved until certain
   rest.c      support points that come to rest
   step.c      one step of a motion, its error, its length, and how its end varies with its start
               and parameters
   phase.c     a motion until its contact changes
   stroke.c    phases joined: whole pushes and drags
   cycle.c     pushes and drags in the world, their derivatives, and batches of them

   No function keeps anything from one call to the next: any number of threads may call at once.
   Lengths are in extents of the footprint, forces per unit load over the mean friction
   coefficient. */

#include <complex.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* As exact as the library's log1p for what is not negative (Kahan), at half the cost. */
static double fast_log1p(double x) {
    double u = 1.0 + x;
    return x > 1.0 ? log(u) : u == 1.0 ? x : log(u) * (x / (u - 1.0));
}
#define log1p fast_log1p

/* Places are summed some at once: each has the same roots and quotients to take. */
enum { LANES = 2 };
#define ALWAYS_INLINE inline __attribute__((always_inline))
typedef double Lanes __attribute__((vector_size(8 * LANES)));

static ALWAYS_INLINE Lanes rooted(Lanes x) {
    for (int k = 0; k < LANES; ++k) x[k] = sqrt(x[k]);
    return x;
}

/* What bounds a contact is summed this many places at once; twice as fast where the processor turns
   out to have registers of that width. Sums are the same to the bit. */
enum { WIDTH = 4 };
typedef double Wide __attribute__((vector_size(8 * WIDTH)));
typedef int64_t Flags __attribute__((vector_size(8 * WIDTH)));
#if defined(__x86_64__) && defined(__GLIBC__)
#define WIDENED __attribute__((target_clones("avx2", "default")))
#else
#define WIDENED
#endif

static ALWAYS_INLINE Wide sizes(Wide x) {
    for (int k = 0; k < WIDTH; ++k) x[k] = fabs(x[k]);
    return x;
}

static ALWAYS_INLINE Wide signs(Wide x) {
    for (int k = 0; k < WIDTH; ++k) x[k] = (x[k] > 0.0) - (x[k] < 0.0);
    return x;
}

static ALWAYS_INLINE Wide roots(Wide x) {
    for (int k = 0; k < WIDTH; ++k) x[k] = sqrt(x[k]);
    return x;
}

static ALWAYS_INLINE Wide logarithms(Wide x) {
    for (int k = 0; k < WIDTH; ++k) x[k] = log1p(x[k]);
    return x;
}

/* Places in the plane; other names are those of schema.py. */
enum { X, Y };

#define CASADI_SYMBOL_EXPORT static
#include "kernels.c"

#include "pressure.c"
#include "ellipse.c"
#include "arcs.c"
#include "boundary.c"
#include "foundation.c"
#include "cones.c"
#include "friction.c"
#include "contact.c"
#include "rest.c"
#include "step.c"
#include "phase.c"
#include "stroke.c"
#include "cycle.c"
