"""How long a straight leg forgets what came before it, under an ellipsoidal limit surface, in
closed form.

A leg of length ℓ multiplies tan(ψ/2) by exp(-κℓ), κ = r/(r² + c²) (`theory.moebius_drag`), ψ the
heading of the lever: 0 where the object trails behind its ring. Angles in rad, lengths in m.
"""

import sympy as sp

from theory.moebius_drag import HEADING, LENGTH, POINT, leg_of_the_lever, rate

EXCLUDED, TOLERANCE = sp.symbols("delta epsilon", positive=True)


def multiplier() -> sp.Expr:
    """Return the factor exp(-κℓ) = (1 - a)/(1 + a) by which a leg shrinks a small heading."""
    return sp.exp(-rate() * LENGTH)


def slope(shrink: sp.Expr) -> sp.Expr:
    """Return d(end)/d(start) of a leg of multiplier m at heading ψ:
    m/(cos²(ψ/2) + m² sin²(ψ/2))."""
    return shrink / (sp.cos(HEADING / 2) ** 2 + shrink**2 * sp.sin(HEADING / 2) ** 2)


def forgetting_length() -> sp.Expr:
    """Return the leg ℓ after which every heading ends within ±ε of the trailing one, if it began δ
    away from ±π.

    (1/κ) ln(cot(δ/2) cot(ε/2)): no length would do for δ = 0, since the object that goes straight
    ahead stays there.
    """
    return sp.log(sp.cot(EXCLUDED / 2) * sp.cot(TOLERANCE / 2)) / rate()


def share_within() -> sp.Expr:
    """Return the share of all headings, evenly spread, that a leg of length ℓ brings within ±ε of
    the trailing one.
    """
    return 2 * sp.atan(sp.tan(TOLERANCE / 2) / multiplier()) / sp.pi


def density_from_uniform(a: sp.Expr) -> sp.Expr:
    """Return the density of the heading (1/rad) after a leg of strength a that began at a uniformly
    random heading.

    It is the wrapped Cauchy density (the Poisson kernel) with resultant a = tanh(κℓ/2).
    """
    return (1 - a**2) / (2 * sp.pi * (1 - 2 * a * sp.cos(HEADING) + a**2))


def mean_from_uniform(a: sp.Expr) -> sp.Expr:
    """Return the mean of e^{iψ} after a leg of strength a from a uniform start: the bias that the
    leg leaves, a itself.

    The mean of an analytic function over the unit circle is its value at the centre (Cauchy).
    """
    return leg_of_the_lever(a).subs(POINT, 0)
