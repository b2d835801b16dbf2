#include <math.h>
#include <string.h>

/* The library's asinh holds its relative error near zero, which costs three times as much; here differences count. */
static double fast_asinh(double x) {
    double size = fabs(x);
    return copysign(log(size + sqrt(size * size + 1.0)), x);
}
#define asinh fast_asinh
