"""Dissipation of a footprint as CasADi expressions: its value, force, torque and second derivatives.

A footprint that moves with the twist (v, omega) in its own frame dissipates, per unit load, the mean of
h(M (v + omega z x r)) over its pressure. With w(r) = M (v + omega z x r) the centred part is the mean of |w|, and w
maps the patch to a patch of the velocity plane, where the divergence theorem leaves integrals around the rim:

    int |w|      = 1/3 rim |w| (w.n)
    int grad |w| = rim |w| n
    int hess |w| = rim (w/|w|) n^T

The rest of gradient and Hessian follows from homogeneity: D = V . grad D and hess D . V = 0. Along straight sides the
rim integrals are closed; around an ellipse they are Gauss sums, graded towards the centre of rotation. A rim share w
adds RIM_RISE w times the mean over the outline less the mean over its inner outline, by the same integrals. Pressure
that leans or is warped is the part of uneven_patch.py. All of this cancels when the centre of rotation is far away
(omega -> 0); there a plain quadrature of the area is exact to rounding.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.footprint import PatchFootprint
from cyclemap.mechanics.patch_motion import Frozen, PatchMotion, quarter_turn, rim_image
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.pressure_means import Means, even_means
from cyclemap.mechanics.rim import Expression
from cyclemap.mechanics.uneven_patch import frame_levels, uneven_patch

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
    at_centre = velocity + omega * quarter_turn(centre)
    frozen: Frozen = ()
    if near and isinstance(footprint, PatchFootprint):
        motion = PatchMotion(velocity, omega, matrix, mu_a * mu_b)
        centred, frozen = _from_rims(pressure, motion, law[5], law[6:8])
    else:
        centred = _from_points(*_nodes(pressure, law[5], law[6:8]), velocity, omega, matrix)
    # The ellipse's centre (m0, n0) acts as one constant force at the centre of pressure.
    c, s = ca.cos(phi - frame), ca.sin(phi - frame)
    constant = ca.vertcat(c * m0 - s * n0, s * m0 + c * n0)
    dissipation, force, torque, hessian = centred
    return PatchExpressions(
        dissipation + ca.dot(constant, at_centre),
        force + constant,
        torque + ca.dot(constant, quarter_turn(centre)),
        hessian,
        _norm(matrix @ at_centre) / (ca.fabs(omega) * ca.fmax(mu_a, mu_b) * footprint.extent),
        frozen,
    )


def _norm(vector: Expression) -> Expression:
    return ca.sqrt(vector[0] ** 2 + vector[1] ** 2)


_Centred = tuple[Expression, Expression, Expression, Expression]


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


def _from_rims(
    pressure: PressureFamily, motion: PatchMotion, rim_share: Expression, warp: Expression
) -> tuple[_Centred, Frozen]:
    """The same from integrals around the rim of the outline and, where it has a frame, of the inner outline."""
    footprint = pressure.footprint
    assert isinstance(footprint, PatchFootprint)
    outlines = (footprint.outline, footprint.inner)[: 1 + pressure.framed]
    images = tuple(rim_image(outline, motion) for outline in outlines)
    frozen = tuple(pair for image in images for pair in image.frozen)
    if pressure.warped or footprint.gradient != (0.0, 0.0):
        return uneven_patch(pressure, images, motion, rim_share, warp), frozen
    means = even_means(images[0].rim)
    if pressure.framed:
        level, factor = frame_levels(rim_share)
        means = means.times(level).plus(factor, even_means(images[1].rim))
    return _from_means(means, motion, motion.image_area(footprint.outline)), frozen


def _from_means(means: Means, motion: PatchMotion, area: Expression) -> _Centred:
    """Dissipation, force, torque and Hessian from the rim's integrals and homogeneity; `area`: that of the image."""
    dissipation, force = means.speed / area, motion.matrix.T @ means.direction / area
    torque = (dissipation - ca.dot(motion.velocity, force)) / motion.omega
    return dissipation, force, torque, motion.hessian(means.curvature / area)
