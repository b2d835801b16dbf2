#include <math.h>
#include <string.h>

/* The library's asinh holds its relative error near zero, which costs three times as much; here differences count. */
static double fast_asinh(double x) {
    double size = fabs(x);
    return copysign(log(size + sqrt(size * size + 1.0)), x);
}
#define asinh fast_asinh

/* As exact as the library's log1p for what is not negative (Kahan), at half the cost. */
static double fast_log1p(double x) {
    double u = 1.0 + x;
    return u == 1.0 ? x : log(u) * (x / (u - 1.0));
}
#define log1p fast_log1p
