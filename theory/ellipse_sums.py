"""The sums of friction under ellipses: chords through the centre of rotation, and elliptic steps
around the rim.

In the coordinates x of an ellipse's unit disc the velocity is w = omega S (x - x_0), S linear, x_0
the centre of rotation: along a chord through x_0 it keeps its direction. Along the rim z = exp(i
alpha) it is p z + c + q/z, with two zeros. Functions named `..._residual` vanish.
"""

import sympy as sp

#: Angle of a chord, and the distance of the centre of rotation from the middle, or one over it.
T, SIZE = sp.symbols("t size", positive=True)
#: Position along a chord from its middle, and its half length.
TAU, HALF = sp.symbols("tau q", positive=True)
#: A singularity's distance from the real axis beside t = pi/2, and the bend of the rule's nodes.
ETA, BETA = sp.symbols("eta beta", positive=True)
#: Where the zeros lie, -s and s, and the angle on the unit circle.
S, PHI = sp.symbols("s phi", positive=True)
#: Jacobi's sn and cn of two arguments, and the modulus.
SN, CN, SN_2, CN_2 = sp.symbols("sn cn sn_2 cn_2", real=True)
K = sp.Symbol("k", positive=True)


def inner_area() -> sp.Expr:
    """Return the area element per dt dtau of chords through a centre inside, at the angle t from
    its direction.

    The distance from the centre, with its sign along the chord: the chord's middle is size cos t
    ahead of the centre.
    """
    return SIZE * sp.cos(T) + TAU


def outer_area() -> sp.Expr:
    """Return the area element per dt dtau of chords at the distance sin t from the middle, the
    centre 1/size away.

    The chord's angle psi has sin psi = size sin t, and its middle is sqrt(1/size^2 - sin^2 t) from
    the centre.
    """
    angle = sp.asin(SIZE * sp.sin(T))
    away = sp.sqrt(1 - SIZE**2 * sp.sin(T) ** 2) / SIZE
    return (away + TAU) * sp.diff(angle, T)


def outer_area_residual() -> sp.Expr:
    """Return outer_area off cos t (1 + tau size/root): what C sums, root = sqrt(1 - size^2 sin^2
    t).
    """
    root = sp.sqrt(1 - SIZE**2 * sp.sin(T) ** 2)
    return sp.simplify(outer_area() - sp.cos(T) * (1 + TAU * SIZE / root))


def disc_area_residual() -> sp.Expr:
    """Return the area that all chords from outside cover, off that of the unit disc."""
    along = sp.integrate(sp.cos(T) * (1 + TAU * SIZE), (TAU, -sp.cos(T), sp.cos(T)))
    return sp.integrate(along, (T, -sp.pi / 2, sp.pi / 2)) - sp.pi


def chord_moments() -> tuple[sp.Expr, sp.Expr]:
    """Return int (a + b tau)(f + g tau) (1, tau) over a chord, a pressure f + g tau on it."""
    a, b, f, g = sp.symbols("a b f g")
    density = sp.expand((a + b * TAU) * (f + g * TAU))
    even = sp.integrate(density, (TAU, -HALF, HALF))
    odd = sp.integrate(sp.expand(density * TAU), (TAU, -HALF, HALF))
    return sp.expand(even), sp.expand(odd)


def depth_residual() -> sp.Expr:
    """Return |sin x|^2 + |cos x|^2 off 2 cosh^2 y - 1, x = a + i y: how far from the axis a place
    sin^2 x is.
    """
    a, y = sp.symbols("a y", real=True)
    sine = (sp.sin(a) * sp.cosh(y)) ** 2 + (sp.cos(a) * sp.sinh(y)) ** 2
    cosine = (sp.cos(a) * sp.cosh(y)) ** 2 + (sp.sin(a) * sp.sinh(y)) ** 2
    return sp.simplify((sine + cosine - (2 * sp.cosh(y) ** 2 - 1)).rewrite(sp.exp))


def bent_depths() -> tuple[sp.Expr, sp.Expr]:
    """Return tanh of the distances at which a rule bent by tan t = beta tan x is singular.

    First what was at t = pi/2 + i eta, where tan t = i coth eta and tan x = (i/beta) coth eta, so
    that x = pi/2 + i atanh(beta tanh eta); then t = i infinity, where tan t = i, which the bend
    brings to x = i atanh(1/beta).
    """
    return BETA * sp.tanh(ETA), 1 / BETA


def best_bend() -> sp.Expr:
    """Return the beta that puts both singularities equally far from the axis."""
    first, second = bent_depths()
    (found,) = sp.solve(sp.Eq(first, second), BETA)
    return found


def legendre_residual() -> sp.Expr:
    """Return |Z^2 - s^2|^2 on the circle off (1 + s^2)^2 (1 - k^2 cos^2 phi), k = 2 s/(1 + s^2)."""
    k = 2 * S / (1 + S**2)
    square = (sp.cos(2 * PHI) - S**2) ** 2 + sp.sin(2 * PHI) ** 2
    return sp.simplify(sp.expand_trig(square - (1 + S**2) ** 2 * (1 - k**2 * sp.cos(PHI) ** 2)))


def circle_residual() -> sp.Expr:
    """Return |Z|^2 - 1 of Z = -cd + i k' sd: elliptic steps go around the unit circle."""
    dn_squared = 1 - K**2 * SN**2
    size = (CN**2 + (1 - K**2) * SN**2) / dn_squared
    return sp.simplify(size.subs(CN, sp.sqrt(1 - SN**2)) - 1)


def speed_residual() -> sp.Expr:
    """Return (dphi/dv)^2 = (k' nd)^2 off 1 - k^2 cos^2 phi, cos phi = -cd: steps are dense where
    |w| is small.
    """
    dn_squared = 1 - K**2 * SN**2
    root = 1 - K**2 * CN**2 / dn_squared
    return sp.simplify(((1 - K**2) / dn_squared - root).subs(CN, sp.sqrt(1 - SN**2)))


def sum_denominator_residual() -> sp.Expr:
    """Return cn^2 u + sn^2 u dn^2 v off 1 - k^2 sn^2 u sn^2 v: the addition theorem's, without
    cancellation.
    """
    whole = CN**2 + SN**2 * (1 - K**2 * SN_2**2) - (1 - K**2 * SN**2 * SN_2**2)
    return sp.simplify(whole.subs(CN, sp.sqrt(1 - SN**2)))


def landen(sn: sp.Expr, small: sp.Expr) -> sp.Expr:
    """Return sn(u, k) of sn(u/(1 + small), small), small = (1 - k')/(1 + k') (DLMF 22.7.2)."""
    return (1 + small) * sn / (1 + small * sn**2)
