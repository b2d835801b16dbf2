"""Dissipation of a footprint as CasADi expressions: its value, force, torque and second derivatives.

A footprint that moves with the twist (v, omega) in its own frame dissipates, per unit load, the mean of
h(M (v + omega z x r)) over its pressure. With w(r) = M (v + omega z x r) the centred part is the mean of |w|, and w
maps the patch to a patch of the velocity plane, where the divergence theorem leaves integrals around the rim:

    int |w|          = 1/3 rim |w| (w.n)            int w_i |w|        = 1/4 rim w_i |w| (w.n)
    int grad |w|     = rim |w| n                    int w_i grad |w|   = rim w_i |w| n - e_i int |w|
    int hess |w|     = rim (w/|w|) n^T              int w_i hess |w|   = rim w_i (w/|w|) n^T - int (w/|w|) e_i^T

    int w_i w_j |w|      = 1/5 rim w_i w_j |w| (w.n)
    int w_i w_j grad |w| = rim w_i w_j |w| n - int (e_i w_j + w_i e_j) |w|
    int w_i w_j hess |w| = rim w_i w_j (w/|w|) n^T - int (w/|w|) (e_i w_j + w_i e_j)^T

(the second column where the pressure leans, the last lines where it is warped). The rest of gradient and Hessian
follows from homogeneity: D = V . grad D and hess D . V = 0. Along straight sides the rim integrals are closed; around
an ellipse they are Gauss sums, graded towards the centre of rotation. A rim share w adds RIM_RISE w times the mean over
the outline less the mean over its inner outline, by the same integrals; a warp adds its saddles over the one less those
over the other. All of this cancels when the centre of rotation is far away (omega -> 0); there a plain quadrature of
the area is exact to rounding.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.footprint import RIM_INNER, RIM_RISE, PatchFootprint
from cyclemap.mechanics.outline import Outline, Polygon
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.pressure_means import Means, even_means, linear_means, quadratic_means
from cyclemap.mechanics.rim import Expression, Rim, ellipse_rim, polygon_rim

# Distance of the centre of rotation over the patch's extent, both in the velocity plane, beyond which the area
# quadrature has more digits than the rim integrals (tests/mechanics/test_patch_integrals.py and test_warp.py measure
# both). Saddles cancel one order more, and are integrated by a finer quadrature.
FAR_RATIO, WARPED_FAR_RATIO = 8.0, 5.0

# Keeps quotients finite where a support point is the centre of rotation.
_TINY = 1e-150


@dataclass(frozen=True)
class PatchExpressions:
    """Expressions of one footprint in its own frame, about the frame's origin, per unit load.

    `dissipation`; `force` (2, 1) and `torque`, its derivatives by v and omega; `hessian` (3, 3) by (vx, vy, omega);
    `far`: distance of the centre of rotation over the patch's extent, in the velocity plane (inf in translation).
    `frozen`: pairs (symbol, expression) of quadrature nodes, to be substituted after any differentiation, since the
    integrals do not depend on where their nodes are.
    """

    dissipation: Expression
    force: Expression
    torque: Expression
    hessian: Expression
    far: Expression
    frozen: tuple[tuple[Expression, Expression], ...] = ()

    def substituted(self, expression: Expression) -> Expression:
        """Return an expression with the frozen symbols replaced by what they stand for."""
        for symbol, value in self.frozen:
            expression = ca.substitute(expression, symbol, value)
        return expression


@dataclass(frozen=True)
class _Motion:
    """Twist and traction, w(r) = matrix (velocity + omega z x r)."""

    velocity: Expression
    omega: Expression
    matrix: Expression


def far_ratio(pressure: PressureFamily) -> float:
    """Return the distance of the centre of rotation over the patch's extent beyond which the area quadrature holds."""
    return WARPED_FAR_RATIO if pressure.warped else FAR_RATIO


def traction_matrix(mu_a: Expression, mu_b: Expression, angle: Expression) -> Expression:
    """Return M with s = |M v|, for a material whose first axis stands at `angle` in the frame of v."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.blockcat([[mu_a * c, mu_a * s], [-mu_b * s, mu_b * c]])


def patch_expressions(
    pressure: PressureFamily, twist: Expression, law: Expression, frame: Expression, near: bool
) -> PatchExpressions:
    """Return a footprint's dissipation and its derivatives at a `twist` (vx, vy, omega) of its own frame.

    Parameters
    ----------
    pressure : the footprint's family, its lengths in the unit of length that the twist uses.
    law : the expressions (mu_a, mu_b, m0, n0, phi, rim share, warp a, warp b).
    frame : the angle of the footprint's frame, rad.
    near : rim integrals, for centres of rotation within `far_ratio`; False: area quadrature, for those beyond.
        Point footprints are summed either way.
    """
    mu_a, mu_b, m0, n0, phi = ca.vertsplit(law[:5])
    footprint = pressure.footprint
    matrix = traction_matrix(mu_a, mu_b, phi - frame)
    velocity, omega = twist[:2], twist[2]
    centre = ca.DM(footprint.centre)
    at_centre = velocity + omega * _quarter_turn(centre)
    frozen: tuple[tuple[Expression, Expression], ...] = ()
    if near and isinstance(footprint, PatchFootprint):
        means, frozen = _means(pressure, _Motion(velocity, omega, matrix), law[5], law[6:8])
        centred = _from_means(means, velocity, omega, matrix, omega**2 * mu_a * mu_b * footprint.outline.area)
    else:
        centred = _from_points(*_nodes(pressure, law[5], law[6:8]), velocity, omega, matrix)
    # The ellipse's centre (m0, n0) acts as one constant force at the centre of pressure.
    c, s = ca.cos(phi - frame), ca.sin(phi - frame)
    constant = ca.vertcat(c * m0 - s * n0, s * m0 + c * n0)
    dissipation, force, torque, hessian = centred
    return PatchExpressions(
        dissipation + ca.dot(constant, at_centre),
        force + constant,
        torque + ca.dot(constant, _quarter_turn(centre)),
        hessian,
        _norm(matrix @ at_centre) / (ca.fabs(omega) * ca.fmax(mu_a, mu_b) * footprint.extent),
        frozen,
    )


def _quarter_turn(vector: Expression) -> Expression:
    return ca.vertcat(-vector[1], vector[0])


def _norm(vector: Expression) -> Expression:
    return ca.sqrt(vector[0] ** 2 + vector[1] ** 2)


_Centred = tuple[Expression, Expression, Expression, Expression]
_Frozen = tuple[tuple[Expression, Expression], ...]


def _nodes(pressure: PressureFamily, rim_share: Expression, warp: Expression) -> tuple[NDArray[np.float64], Expression]:
    """Points and their shares of the load."""
    footprint = pressure.footprint
    if not pressure.framed:
        points, weights = footprint.quadrature
        return points, ca.DM(weights)
    assert isinstance(footprint, PatchFootprint)
    if not pressure.warped:
        points, without, by_share = footprint.rim_quadrature
        return points, ca.DM(without) + rim_share * ca.DM(by_share)
    points, without, by_share, by_warp = footprint.warp_quadrature
    return points, ca.DM(without) + rim_share * ca.DM(by_share) + ca.DM(by_warp) @ warp


def _from_points(
    points: NDArray[np.float64], share: Expression, velocity: Expression, omega: Expression, matrix: Expression
) -> _Centred:
    """Dissipation, force, torque and Hessian as sums over points."""
    x, y = ca.DM(points[:, 0]), ca.DM(points[:, 1])
    vx, vy = velocity[0] - omega * y, velocity[1] + omega * x
    wx, wy = matrix[0, 0] * vx + matrix[0, 1] * vy, matrix[1, 0] * vx + matrix[1, 1] * vy
    speed = ca.sqrt(wx * wx + wy * wy + _TINY**2)
    # Each point's force, and the direction in which |w| curves: B = (d w / d twist)^T w_perp / |w|.
    along_x, along_y = wx / speed, wy / speed
    fx = matrix[0, 0] * along_x + matrix[1, 0] * along_y
    fy = matrix[0, 1] * along_x + matrix[1, 1] * along_y
    bx = matrix[1, 0] * along_x - matrix[0, 0] * along_y
    by = matrix[1, 1] * along_x - matrix[0, 1] * along_y
    across = ca.horzcat(bx, by, x * by - y * bx)
    hessian = across.T @ (ca.repmat(share / speed, 1, 3) * across)
    return (
        ca.dot(share, speed),
        ca.vertcat(ca.dot(share, fx), ca.dot(share, fy)),
        ca.dot(share, x * fy - y * fx),
        hessian,
    )


def _means(pressure: PressureFamily, motion: _Motion, rim_share: Expression, warp: Expression) -> tuple[Means, _Frozen]:
    """Integrals of |w| and its derivatives over the image of the footprint, weighted by its pressure."""
    footprint = pressure.footprint
    assert isinstance(footprint, PatchFootprint)
    rim, frozen = _rim(footprint.outline, motion.velocity, motion.omega, motion.matrix)
    if not pressure.framed:
        return _outer_means(footprint, rim, motion, None), frozen
    inner_rim, more = _rim(footprint.inner, motion.velocity, motion.omega, motion.matrix)
    level, factor = 1 + RIM_RISE * rim_share, -RIM_RISE / RIM_INNER**2 * rim_share
    if pressure.warped:
        means = _warped_means(footprint, (rim, inner_rim), motion, (level, factor), warp)
    else:
        means = _outer_means(footprint, rim, motion, level).plus(factor, even_means(inner_rim))
    return means, (*frozen, *more)


def _rim(outline: Outline, velocity: Expression, omega: Expression, matrix: Expression) -> tuple[Rim, _Frozen]:
    """Image of an outline in the velocity plane."""
    if isinstance(outline, Polygon):
        corners = ca.DM(outline.array)
        vx, vy = velocity[0] - omega * corners[:, 1], velocity[1] + omega * corners[:, 0]
        return polygon_rim(matrix[0, 0] * vx + matrix[0, 1] * vy, matrix[1, 0] * vx + matrix[1, 1] * vy), ()
    cosine = omega * outline.semi_x * matrix @ ca.DM([0.0, 1.0])
    sine = omega * outline.semi_y * matrix @ ca.DM([-1.0, 0.0])
    return ellipse_rim(matrix @ velocity, cosine, sine)


def _from_means(
    means: Means, velocity: Expression, omega: Expression, matrix: Expression, area: Expression
) -> _Centred:
    """Dissipation, force, torque and Hessian from the rim's integrals and homogeneity; `area`: that of the image."""
    dissipation, force = means.speed / area, matrix.T @ means.direction / area
    torque = (dissipation - ca.dot(velocity, force)) / omega
    block = matrix.T @ means.curvature @ matrix / area
    mixed = -block @ velocity / omega
    hessian = ca.blockcat([[block, mixed], [mixed.T, -ca.dot(mixed, velocity) / omega]])
    return dissipation, force, torque, hessian


def _outer_means(footprint: PatchFootprint, rim: Rim, motion: _Motion, level: Expression | None) -> Means:
    """Integrals over the whole outline with its pressure, `level` (one) at the centroid."""
    if footprint.gradient != (0.0, 0.0):
        constant, slope = _leaning(footprint, motion, 1 if level is None else level)
        return linear_means(rim, constant, slope)
    even = even_means(rim)
    return even if level is None else even.times(level)


def _leaning(footprint: PatchFootprint, motion: _Motion, level: Expression | int) -> tuple[Expression, Expression]:
    """Return (p0, q): the leaning pressure is p0 + q . w in the velocity plane."""
    gradient = ca.DM(footprint.gradient)
    q = ca.solve(motion.matrix.T, _quarter_turn(gradient)) / motion.omega
    lean = ca.dot(gradient, ca.DM(footprint.outline.centroid))
    return level - lean - ca.dot(_quarter_turn(gradient), motion.velocity) / motion.omega, q


def _warped_means(
    footprint: PatchFootprint,
    rims: tuple[Rim, Rim],
    motion: _Motion,
    levels: tuple[Expression, Expression],
    warp: Expression,
) -> Means:
    """Integrals over outline and inner outline, each with its level; the first leans, both hold the saddles."""
    turn, shift = _lever(footprint, motion)
    lean = ca.DM(footprint.gradient)
    constant, slope, bend = _saddle(footprint, turn, shift, warp / (1.0 - RIM_INNER**2))
    level = levels[0] + ca.dot(lean, shift)
    outer = quadratic_means(rims[0], level + constant, turn.T @ lean + slope, bend)
    return outer.plus(1, quadratic_means(rims[1], levels[1] - constant, -slope, -bend))


def _lever(footprint: PatchFootprint, motion: _Motion) -> tuple[Expression, Expression]:
    """Return `turn` (2, 2), `shift` (2, 1): the lever from the centroid is turn w + shift."""
    m, omega = motion.matrix, motion.omega
    turn = ca.blockcat([[-m[1, 0], m[0, 0]], [-m[1, 1], m[0, 1]]]) / ((m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]) * omega)
    return turn, _quarter_turn(motion.velocity) / omega - ca.DM(footprint.outline.centroid)


def _saddle(
    footprint: PatchFootprint, turn: Expression, shift: Expression, share: Expression
) -> tuple[Expression, Expression, Expression]:
    """Return the saddles' pressure constant + slope . w + w^T bend w in the velocity plane."""
    first, second = footprint.saddles
    beta = share[0] * ca.DM(first.slope) + share[1] * ca.DM(second.slope)
    bend = share[0] * ca.DM(first.bend) + share[1] * ca.DM(second.bend)
    bent = bend @ shift
    constant = share[0] * first.constant + share[1] * second.constant + ca.dot(beta + bent, shift)
    return constant, turn.T @ (beta + 2 * bent), turn.T @ bend @ turn
