"""Monotone matching of two laws on the circle: optimal for convex costs (Delon, Salomon & Sobolevski 2010)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_array, read_only
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.resets.least_noise.turn_costs import TurnCost

_LEVELS = 16_384  # quantiles on which the shift is sought
_SHIFTS = 65  # shifts tried before the best is refined


@dataclass(frozen=True, eq=False)
class CircularMatching:
    """The mass at quantile t of one law goes to quantile t + ``shift`` of the other; quantiles are lifted.

    from_angles, to_angles : (n,), (m,), rising, in [0, 2π). from_masses, to_masses : at them, each of sum 1.
    mean_cost : of this coupling, exactly, so an upper bound on the transport cost whatever the shift; it is the
    transport cost where the cost is convex and the shift optimal.
    """

    from_angles: Array
    from_masses: Array
    to_angles: Array
    to_masses: Array
    shift: float
    mean_cost: float

    def turn(self, angle: Array) -> Array:
        """The extra turn, radians in [-π, π), at angles of any shape; linear between the laws' points."""
        angles = finite_array("angle", angle)
        wrapped = np.mod(angles, TWO_PI)
        level = _interpolated(wrapped, self.from_angles, _middle_levels(self.from_masses), TWO_PI, 1.0)
        there = level + self.shift
        goal = _interpolated(there, _middle_levels(self.to_masses), self.to_angles, 1.0, TWO_PI)
        return np.asarray(np.mod(goal - wrapped + np.pi, TWO_PI) - np.pi)


def circular_matching(
    from_angles: Array, from_masses: Array, to_angles: Array, to_masses: Array, cost: TurnCost
) -> CircularMatching:
    """The monotone matching of least mean cost of weighted points, any angles; masses of sum 1.

    >>> from cyclemap.resets.least_noise.turn_costs import turn_cost
    >>> half = np.array([0.5, 0.5])
    >>> found = circular_matching(np.array([0.1, 3.1]), half, np.array([6.2, 3.0]), half, turn_cost("absolute"))
    >>> round(found.mean_cost, 6)
    0.141593
    """
    start, begin = _sorted(from_angles, from_masses)
    goal, arrive = _sorted(to_angles, to_masses)
    shift = _best_shift(start, begin, goal, arrive, cost)
    mean = _mean_cost(start, begin, goal, arrive, shift, cost)
    return CircularMatching(read_only(start), read_only(begin), read_only(goal), read_only(arrive), shift, mean)


def _sorted(angles: Array, masses: Array) -> tuple[Array, Array]:
    wrapped = np.mod(angles, TWO_PI)
    order = np.argsort(wrapped, kind="stable")
    return wrapped[order], masses[order] / np.sum(masses)


def _quantile(levels: Array, angles: Array, reached: Array) -> Array:
    """The angle at each level, lifted: one turn further a whole level."""
    whole = np.floor(levels)
    place = np.minimum(np.searchsorted(reached, levels - whole, side="right"), angles.size - 1)
    return np.asarray(angles[place] + TWO_PI * whole)


def _best_shift(start: Array, begin: Array, goal: Array, arrive: Array, cost: TurnCost) -> float:
    from scipy.optimize import minimize_scalar

    levels = (np.arange(_LEVELS) + 0.5) / _LEVELS
    leaving, reached = _quantile(levels, start, np.cumsum(begin)), np.cumsum(arrive)

    def mean(shift: float) -> float:
        return float(np.mean(cost.of(_quantile(levels + shift, goal, reached) - leaving)))

    trials = np.linspace(-1.0, 1.0, _SHIFTS)
    best = trials[int(np.argmin([mean(shift) for shift in trials]))]
    step = trials[1] - trials[0]
    found = minimize_scalar(mean, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-9})
    return float(found.x)


def _mean_cost(start: Array, begin: Array, goal: Array, arrive: Array, shift: float, cost: TurnCost) -> float:
    leaving, reached = np.cumsum(begin), np.cumsum(arrive)
    ends = np.sort(np.concatenate([leaving[:-1], np.mod(reached - shift, 1.0), [0.0, 1.0]]))
    levels, widths = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)
    turns = _quantile(levels + shift, goal, reached) - _quantile(levels, start, leaving)
    return float(np.dot(widths, cost.of(turns)))


def _middle_levels(masses: Array) -> Array:
    return np.asarray(np.cumsum(masses) - 0.5 * masses)


def _interpolated(at: Array, x: Array, y: Array, x_period: float, y_period: float) -> Array:
    """Linear between the points (x, y), continued by whole periods of both."""
    whole = np.floor(at / x_period)
    left = np.concatenate([[x[-1] - x_period], x, [x[0] + x_period]])
    value = np.concatenate([[y[-1] - y_period], y, [y[0] + y_period]])
    return np.asarray(np.interp(at - whole * x_period, left, value) + whole * y_period)
