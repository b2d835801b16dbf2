"""The lift of the inverse of a monotone map of degree 1 or -1: the representation behind ``inverse``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import TWO_PI, Array
from cyclemap.maps.algebra.branches import Branch
from cyclemap.maps.algebra.monotone_table import MonotoneTable
from cyclemap.maps.estimate import SAME_ANGLE
from cyclemap.maps.lifts.circle_map import SIDE_STEP, SNAP, CircleMap
from cyclemap.maps.lifts.lift_checks import Scalar, base_angles, distance_to_break


@dataclass(frozen=True, eq=False)
class InverseLift:
    """F⁻¹ from a table of F whose values cover [0, 2π]; ``breaks`` are its own, sorted, in [0, 2π)."""

    table: MonotoneTable
    breaks: Array
    degree: int

    def __call__(self, values: Array) -> Array:
        """The lift of the inverse at ``values`` (radians, any shape)."""
        turns = np.floor(values / TWO_PI)
        return np.asarray(self.table.inverse(values - TWO_PI * turns) + (TWO_PI * self.degree) * turns)

    def derivative(self, values: Array) -> Array:
        """1/F' at the inverse, on the side of F's breaks that belongs to the value; 0 across a jump of F."""
        base = np.asarray(values - TWO_PI * np.floor(values / TWO_PI))
        theta, cell = self.table.inverse(base), self.table.cell(base)
        low, high = self.table.theta[cell], self.table.theta[cell + 1]
        margin = np.minimum(SIDE_STEP, 0.25 * (high - low))
        slope = self.table.map.derivative(np.clip(theta, low + margin, high - margin))
        with np.errstate(divide="ignore"):
            return np.where(high > low, 1.0 / slope, 0.0)

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        one, degree = self.table.inverse_of_one_float(), self.degree

        def lift(value: float) -> float:
            turns = value // TWO_PI
            return one(value - TWO_PI * turns) + TWO_PI * degree * turns

        return lift


def inverse_lift(circle_map: CircleMap, parts: tuple[Branch, ...]) -> InverseLift:
    """The inverse of a map whose branches all run in the direction of its degree, jumps and plateaus included."""
    degree = circle_map.degree
    theta = np.concatenate([part.table.theta for part in parts])
    value = np.concatenate([part.table.value for part in parts])
    ends = np.concatenate([_at_ends(part) for part in parts])
    bent = ends | (distance_to_break(circle_map.breaks, theta) <= SNAP)
    base = base_angles(value)
    moved = theta - degree * TWO_PI * np.round((value - base) / TWO_PI)
    order = np.lexsort((degree * moved, base))
    table = _around(circle_map, moved[order], base[order])
    breaks = np.unique(base[bent])
    return InverseLift(table, breaks[np.diff(breaks, prepend=-1.0) > SNAP], degree)


def _at_ends(part: Branch) -> npt.NDArray[np.bool_]:
    """Marks the ends of a plateau among its nodes."""
    marks = np.zeros(part.table.theta.size, dtype=bool)
    marks[[0, -1]] = part.direction == 0
    return marks


def _around(circle_map: CircleMap, theta: Array, value: Array) -> MonotoneTable:
    """The table carried on by one node below 0 and one above 2π, in the order of θ."""
    degree = circle_map.degree
    value = np.concatenate([value[-1:] - TWO_PI, value, value[:1] + TWO_PI])
    theta = np.concatenate([theta[-1:] - degree * TWO_PI, theta, theta[:1] + degree * TWO_PI])
    theta, value = theta[::degree], value[::degree]
    theta = np.maximum.accumulate(theta)
    # The two sides of a jump, a turn apart, are one angle however they were rounded.
    apart = np.diff(theta, prepend=-np.inf) > SAME_ANGLE
    theta = theta[apart][np.cumsum(apart) - 1]
    return MonotoneTable(theta, value, degree, circle_map)
