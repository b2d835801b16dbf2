"""The bottleneck under noise: mean passage time of dx = (ε + a x²) dt + √(2D) dW from -∞ to ∞.

D is half the variance a cycle, rad²; the gap ε may have either sign (negative: a stable point to be
left). With U the potential, U' = -(ε + a x²), the mean time is (1/D)∫∫_{y<x} exp((U(x) - U(y))/D)
dy dx (Kramers 1940); in u = x - y and the middle, the middle's integral is a Gaussian (Sigeti &
Horsthemke 1989 for ε = 0).
"""

import sympy as sp

from theory.passage_time import CURVATURE, passage_time

DIFFUSION, SEPARATION = sp.symbols("D u", positive=True)
GAP = sp.Symbol("epsilon", real=True)
MIDDLE = sp.Symbol("s", real=True)


def exponent() -> sp.Expr:
    """Return (U(x) - U(y))/D at x = s + u/2, y = s - u/2: -(εu + a s²u + a u³/12)/D."""
    place = sp.Symbol("x", real=True)
    potential = -GAP * place - CURVATURE * place**3 / 3
    high, low = MIDDLE + SEPARATION / 2, MIDDLE - SEPARATION / 2
    return sp.expand((potential.subs(place, high) - potential.subs(place, low)) / DIFFUSION)


def integrand() -> sp.Expr:
    """Return the mean time's integrand over u > 0: √(π/(aDu)) exp(-(εu + a u³/12)/D), cycles per
    rad.
    """
    gaussian = sp.sqrt(sp.pi * DIFFUSION / (CURVATURE * SEPARATION))
    return gaussian * sp.exp(exponent().subs(MIDDLE, 0)) / DIFFUSION


def passage_at_tangency() -> sp.Expr:
    """Return the mean time at ε = 0: (√π/3) 12^{1/6} Γ(1/6) (a²D)^{-1/3}, cycles; noise alone
    carries it through.
    """
    return (
        sp.sqrt(sp.pi)
        / 3
        * 12 ** sp.Rational(1, 6)
        * sp.gamma(sp.Rational(1, 6))
        / sp.cbrt(CURVATURE**2 * DIFFUSION)
    )


def passage_without_noise() -> sp.Expr:
    """Return the limit D → 0 for ε > 0: with u = D w the cubic term drops out, and π/√(aε) is left,
    cycles.
    """
    gap, width = sp.symbols("epsilon w", positive=True)
    scaled = (integrand().subs(GAP, gap).subs(SEPARATION, DIFFUSION * width) * DIFFUSION).simplify()
    return sp.integrate(sp.limit(scaled, DIFFUSION, 0), (width, 0, sp.oo))


def kramers_time() -> sp.Expr:
    """Return the leading term for ε = -e < 0 and little noise: π/√(ae) exp(4 e^{3/2}/(3 D √a)),
    cycles.

    Laplace's method about the largest integrand, u = 2 √(e/a), the distance of the two fixed
    points.
    """
    depth = sp.Symbol("e", positive=True)
    logarithm = exponent().subs(MIDDLE, 0).subs(GAP, -depth)
    (top,) = sp.solve(sp.diff(logarithm, SEPARATION), SEPARATION)
    width = sp.sqrt(2 * sp.pi / -sp.diff(logarithm, SEPARATION, 2).subs(SEPARATION, top))
    before = (integrand() / sp.exp(exponent().subs(MIDDLE, 0))).subs(SEPARATION, top)
    return sp.simplify(before * width) * sp.exp(sp.simplify(logarithm.subs(SEPARATION, top)))


def without_noise_residual() -> sp.Expr:
    """Return the noiseless limit less the flow's passage time: zero."""
    return sp.simplify(passage_without_noise() - passage_time())
