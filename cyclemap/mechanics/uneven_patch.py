"""Dissipation of a patch whose pressure leans or is warped, from integrals around its rim.

Written as a polynomial of w about the centre of rotation a pressure has coefficients that grow with its distance, and
cancel: force and torque therefore come from the excess over a tangent, with the pressure about the centroid
(rim_excess.py). The Hessian alone, on which no balance rests, is summed in the velocity plane, where

    int w_i hess |w|     = rim w_i (w/|w|) n^T - int (w/|w|) e_i^T
    int w_i w_j hess |w| = rim w_i w_j (w/|w|) n^T - int (w/|w|) (e_i w_j + w_i e_j)^T
"""

import casadi as ca

from cyclemap.mechanics.footprint import RIM_INNER, RIM_RISE, PatchFootprint
from cyclemap.mechanics.patch_motion import PatchMotion, RimImage, quarter_turn
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.pressure_means import linear_curvature, quadratic_curvature
from cyclemap.mechanics.rim import Expression
from cyclemap.mechanics.rim_excess import Tangent, Weight, excess_integrals


def frame_levels(rim_share: Expression) -> tuple[Expression, Expression]:
    """Return the even pressures of the whole outline and of the inner one whose sum a rim share is."""
    return 1 + RIM_RISE * rim_share, -RIM_RISE / RIM_INNER**2 * rim_share


def uneven_patch(
    pressure: PressureFamily,
    images: tuple[RimImage, ...],
    motion: PatchMotion,
    rim_share: Expression,
    warp: Expression,
) -> tuple[Expression, Expression, Expression, Expression]:
    """Return dissipation, force, torque about the frame's origin and Hessian; `images`: of the rims that it has."""
    footprint = pressure.footprint
    assert isinstance(footprint, PatchFootprint)
    weights = _weights(pressure, rim_share, warp)
    force, torque = _wrench(footprint, images, motion, weights)
    curvature = sum(_curvature(*pair, motion, footprint.outline.centroid) for pair in zip(images, weights, strict=True))
    dissipation = ca.dot(motion.velocity, force) + motion.omega * torque
    return dissipation, force, torque, motion.hessian(curvature / motion.image_area(footprint.outline))


def _weights(pressure: PressureFamily, rim_share: Expression, warp: Expression) -> tuple[Weight, ...]:
    """Pressures over the outline and over the inner one whose sum is the footprint's: by levers from the centroid."""
    footprint = pressure.footprint
    assert isinstance(footprint, PatchFootprint)
    lean = ca.DM(footprint.gradient)
    if not pressure.framed:
        return (Weight(1, lean),)
    level, factor = frame_levels(rim_share)
    if not pressure.warped:
        return Weight(level, lean), Weight(factor, ca.DM.zeros(2))
    first, second = footprint.saddles
    a, b = ca.vertsplit(warp / (1.0 - RIM_INNER**2))
    constant, bend = a * first.constant + b * second.constant, a * ca.DM(first.bend) + b * ca.DM(second.bend)
    slope = a * ca.DM(first.slope) + b * ca.DM(second.slope)
    return Weight(level + constant, lean + slope, bend), Weight(factor - constant, -slope, -bend)


def _wrench(
    footprint: PatchFootprint, images: tuple[RimImage, ...], motion: PatchMotion, weights: tuple[Weight, ...]
) -> tuple[Expression, Expression]:
    """Force and torque about the frame's origin: the tangent's at the centre of pressure, and the excess's."""
    centroid = ca.DM(footprint.outline.centroid)
    velocity = motion.at(centroid)
    tangent = Tangent.at(motion.matrix @ velocity, motion.map)
    away = quarter_turn(velocity) / motion.omega
    parts = [
        excess_integrals(image.excess(tangent), away, weight) for image, weight in zip(images, weights, strict=True)
    ]
    scale = motion.omega * footprint.outline.area
    steady, rest = motion.matrix.T @ tangent.direction, quarter_turn(sum(part.gradient for part in parts)) / scale
    radial = sum(part.radial for part in parts) / scale
    torque = ca.dot(quarter_turn(ca.DM(footprint.centre)), steady) + ca.dot(quarter_turn(centroid), rest) + radial
    return steady + rest, torque


def _curvature(image: RimImage, weight: Weight, motion: PatchMotion, centroid: tuple[float, float]) -> Expression:
    """Integral (2, 2) of the Hessian of |w| over an image, with the weight written in the velocity plane."""
    m = motion.matrix
    # The lever from the centroid is turn w + shift.
    turn = ca.blockcat([[-m[1, 0], m[0, 0]], [-m[1, 1], m[0, 1]]]) / (motion.stretch * motion.omega)
    shift = quarter_turn(motion.velocity) / motion.omega - ca.DM(centroid)
    constant, slope = weight.constant + ca.dot(weight.slope, shift), turn.T @ weight.slope
    if weight.bend is None:
        return linear_curvature(image.rim, constant, slope)
    bent = weight.bend @ shift
    return quadratic_curvature(
        image.rim, constant + ca.dot(bent, shift), slope + 2 * turn.T @ bent, turn.T @ weight.bend @ turn
    )
