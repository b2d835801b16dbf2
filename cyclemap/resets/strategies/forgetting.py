"""How a straight leg forgets where the object came from, by simulation of any loop's object."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, non_negative_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics import Pose
from cyclemap.resets.strategies.ellipsoid_leg import TrailingPoint, checked_share, checked_tolerance, trailing_point

Array = NDArray[np.float64]

# Spacing of the samples of a long leg, as a share of the length on which a heading dies away.
_SPACING = 0.05
# How much longer than the closed form says a leg is run before it is given up.
_MARGIN = 30.0


@dataclass(frozen=True, eq=False)
class LegFlow:
    """The headings of an object on a long straight leg: as an autonomous flow, all of its legs in two runs.

    The spin depends on the orientation alone, so that one run from beside the orientation straight ahead to beside the
    trailing one, on either side, holds every leg between. In y = ln tan(|psi|/2), psi the heading, an ellipsoid's leg
    is the straight line dy/ds = -rate.

    point : the trailing orientation. paths : of either side (psi > 0 first), (n,), m, rising; steepness : y, falling.
    """

    point: TrailingPoint
    paths: tuple[Array, Array]
    steepness: tuple[Array, Array]

    def length_between(self, side: int, before: float, after: float) -> float:
        """Return the leg (m) that takes the heading side*before to side*after (rad, pi > before > after > 0).

        side : 1 or -1. Raises InvalidInput for headings beyond those of the run.
        """
        if side not in (1, -1):
            raise InvalidInput(f"side must be 1 or -1, not {side!r}")
        first, last = (self._path(side, math.log(math.tan(0.5 * checked_tolerance(psi)))) for psi in (before, after))
        if not first <= last:
            raise InvalidInput(f"on a leg headings shrink: not from {before} to {after} rad")
        return last - first

    def share_outside(self, tolerance: float, length: float) -> float:
        """Return the share of even headings that a leg (m) leaves further than `tolerance` (rad) from trailing.

        Raises InvalidInput for legs longer than the run's, which leave out less than it began with.
        """
        goal = math.log(math.tan(0.5 * checked_tolerance(tolerance)))
        leg = non_negative_number("length", length)
        outside = 0.0
        for side, path, y in zip((1, -1), self.paths, self.steepness, strict=True):
            start = self._path(side, goal) - leg
            if start < 0.0:
                raise InvalidInput(f"a leg of {leg} m leaves out less than this flow began with: make it finer")
            outside += 2.0 * math.atan(math.exp(-_interpolated(path, y, start)))
        return outside / (2.0 * math.pi)

    def forgetting_length(self, tolerance: float, left_out: float) -> float:
        """Return the leg (m) after which all headings but a share `left_out` lie within `tolerance` (rad) of trailing.

        0 where no leg is needed.
        """
        from scipy.optimize import brentq

        share = checked_share(left_out)
        if self.share_outside(tolerance, 0.0) <= share:
            return 0.0
        goal = math.log(math.tan(0.5 * checked_tolerance(tolerance)))
        longest = min(self._path(side, goal) for side in (1, -1))
        if self.share_outside(tolerance, longest) > share:
            raise InvalidInput(f"this flow began with more than a share of {share}: make it finer")
        return float(brentq(lambda leg: self.share_outside(tolerance, leg) - share, 0.0, longest, xtol=1e-9))

    def rate_at(self, heading: float) -> float:
        """Return -dy/ds (1/m) at a heading (rad, its sign the side): `point.rate` as the heading goes to 0 or pi."""
        side = 0 if heading > 0.0 else 1
        y = math.log(math.tan(0.5 * checked_tolerance(abs(heading))))
        path, steep = self.paths[side], self.steepness[side]
        if not steep[-1] <= y <= steep[0]:
            raise InvalidInput(f"heading {heading} rad lies beyond those of the run")
        return -_interpolated(path, steep, _interpolated(-steep, path, -y), 1)

    def _path(self, side: int, y: float) -> float:
        path, steep = self.paths[0 if side == 1 else 1], self.steepness[0 if side == 1 else 1]
        if not steep[-1] <= y <= steep[0]:
            raise InvalidInput(f"heading {2.0 * math.atan(math.exp(y)):.4g} rad lies beyond those of this flow")
        return _interpolated(-steep, path, -y)


def leg_flow(
    loop: CollectionLoop, direction: float = 0.0, *, nearest_trailing: float = 1e-3, nearest_ahead: float = 1e-3
) -> LegFlow:
    """Return the flow of headings on a leg of the loop's ring along `direction` (rad, world), from two long drags.

    It reaches from `nearest_ahead` (rad) beside straight ahead to `nearest_trailing` beside trailing. Its lengths are
    good to about 0.1 um for patches; near the ends to `loop.accuracy` over the heading, of 1/rate. Some 0.2 s.

    Raises InvalidInput as `trailing_point`; ConvergenceError where the object does not come so near to trailing.

    >>> even = CollectionLoop.from_settings({"mu_a": 0.2, "mu_b": 0.2, "m0": 0.0, "n0": 0.0})
    >>> flow = leg_flow(even, nearest_trailing=0.05, nearest_ahead=0.05)
    >>> leg = flow.forgetting_length(math.radians(5.0), 5.0 / 180.0)
    >>> closed = flow.point.leg.forgetting_length(math.radians(5.0), 5.0 / 180.0)
    >>> round(leg, 3), round(closed, 3)  # the even square against the ellipsoid with its rate, m
    (0.398, 0.376)
    """
    point = trailing_point(loop, direction)
    ahead, trailing = checked_tolerance(nearest_ahead), checked_tolerance(nearest_trailing)
    runs = [_one_side(loop, point, side * (math.pi - ahead), trailing) for side in (1.0, -1.0)]
    (path, steep), (other_path, other_steep) = runs
    return LegFlow(point, (path, other_path), (steep, other_steep))


def headings_after(loop: CollectionLoop, headings: ArrayLike, length: float, direction: float = 0.0) -> Array:
    """Return the headings (n,) after a straight leg (m) along `direction` (rad) from headings (n,), by one drag each.

    Headings are counted from trailing, rad, and are not wrapped.
    """
    point, starts = trailing_point(loop, direction), finite_array("headings", headings, ndim=1)
    leg = positive_number("length", length)
    goal = (leg * math.cos(point.direction), leg * math.sin(point.direction))
    ends = [loop.model.drag(loop.start_pose(point.theta + psi), (goal,)).turn for psi in starts.tolist()]
    return np.asarray(starts + ends)


def _one_side(loop: CollectionLoop, point: TrailingPoint, heading: float, nearest: float) -> tuple[Array, Array]:
    """Path (m) and y of a run from a heading until its size is below `nearest`."""
    stretch = (math.log(math.tan(0.5 * abs(heading))) - math.log(math.tan(0.5 * nearest))) / point.rate
    pose, travelled = loop.start_pose(point.theta + heading), 0.0
    paths, headings = [np.zeros(1)], [np.array([heading])]
    while abs(headings[-1][-1]) > nearest:
        if travelled > _MARGIN * stretch:
            raise ConvergenceError(
                f"after {travelled:.3g} m the object is still {abs(headings[-1][-1]):.3g} rad off trailing, not within "
                f"{nearest:.3g}: its pressure resists turning far more on the way than near trailing; ask for less"
            )
        path, orientation, pose = _stretch_of_leg(loop, point, pose, 0.25 * stretch)
        paths.append(travelled + path)
        headings.append(orientation - point.theta)
        travelled = float(paths[-1][-1])
    size = np.abs(np.concatenate(headings))
    return np.concatenate(paths), np.log(np.tan(0.5 * size))


def _stretch_of_leg(loop: CollectionLoop, point: TrailingPoint, pose: Pose, length: float) -> tuple[Array, Array, Pose]:
    """Path (m) and orientation (rad) at the samples of the next stretch of a leg, without its first, and its end."""
    x, y = loop.model.ring_place(pose)
    goal = (x + length * math.cos(point.direction), y + length * math.sin(point.direction))
    drag = loop.model.drag(pose, (goal,), _SPACING / point.rate)
    course = drag.trajectory
    return course.path[1:], course.pose[1:, 2], drag.end


def _interpolated(x: Array, y: Array, at: float, derivative: int = 0) -> float:
    from scipy.interpolate import CubicSpline

    return float(CubicSpline(x, y)(at, derivative))
