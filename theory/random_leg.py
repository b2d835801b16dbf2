"""A final leg in a random direction, under isotropic friction: no bias at any length, and how fast
it forgets.

By isotropy a leg in the direction β is g turned by β, f_β(θ) = β + g(θ - β), g the leg along x (any
footprint; any path of legs, turned as a whole). If β is uniform and drawn anew, so is θ - β, and
the turn g(θ - β) - (θ - β) has a law that does not know θ: the orientation makes a random walk. A
uniform orientation stays uniform, whatever the length; the n-th moment E e^{inθ} of any other
shrinks each cycle by κ_n, the mean of e^{in(g(x) - x)} over the circle.

Under an ellipsoid κ_n is the coefficient of zⁿ in ((z + a)/(1 + a z))ⁿ, a = tanh(κℓ/2): κ_1 = 1 -
a² = 1/cosh²(κℓ/2).
"""

import sympy as sp

from theory.moebius_drag import LENGTH, POINT, leg_of_the_lever, rate

STRENGTH = sp.Symbol("a", real=True)
START, DIRECTION = sp.symbols("theta beta", real=True)


def turned_leg(leg: sp.Function) -> sp.Expr:
    """Return f_β(θ) = β + g(θ - β) for a leg g along x."""
    return DIRECTION + leg(START - DIRECTION)


def turn_by_heading(leg: sp.Function) -> sp.Expr:
    """Return the turn f_β(θ) - θ as a function of x = θ - β: θ alone is in it no more."""
    heading = sp.Symbol("x", real=True)
    return sp.expand(turned_leg(leg).subs(START, DIRECTION + heading) - DIRECTION - heading)


def memory(order: int) -> sp.Expr:
    """Return κ_n of an ellipsoid's leg, the factor by which one cycle shrinks the n-th moment: a
    residue.

    The mean of e^{in(g - x)} is the integral of (g(z)/z)ⁿ over z around the circle, whose only pole
    inside is at 0.
    """
    image = leg_of_the_lever(STRENGTH) ** order
    derivative = sp.diff(image, POINT, order) / sp.factorial(order)
    factors = sp.factor(derivative.subs(POINT, 0))
    return sp.cancel(factors / (1 - STRENGTH**2)) * (1 - STRENGTH**2)


def correlation() -> sp.Expr:
    """Return κ_1 as a function of the leg's length ℓ: 1/cosh²(κℓ/2), about 4 exp(-κℓ) for long
    legs.
    """
    return 1 / sp.cosh(rate() * LENGTH / 2) ** 2


def moment_from_uniform(harmonic: int) -> sp.Expr:
    """Return E e^{inψ} after one leg of an ellipsoid in one direction, the headings ψ before it
    evenly spread: aⁿ.

    The mean of an analytic function over the unit circle is its value at the centre (Cauchy).
    """
    return (leg_of_the_lever(STRENGTH) ** harmonic).subs(POINT, 0)


def surviving_share(harmonic: int, directions: int) -> sp.Expr:
    """Return the mean of e^{-inβ} over K equally spaced directions β: 1 if K divides n, else 0.

    So a leg in one of K such directions at random commutes, in the mean, with a turn by 2π/K: only
    the harmonics nK of the bias survive, and two opposite directions already leave no first
    harmonic.
    """
    total = sum(
        sp.exp(-2 * sp.pi * sp.I * sp.Rational(harmonic * j, directions)) for j in range(directions)
    )
    return sp.nsimplify(sp.simplify(sp.expand_complex(total)) / directions)
