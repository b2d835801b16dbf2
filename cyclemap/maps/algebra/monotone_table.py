"""A monotone function tabulated so closely that it can be inverted anywhere to rounding, in arrays or one float."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import EPS
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import Scalar

_PASSES = 200


@dataclass(frozen=True, eq=False)
class MonotoneTable:
    """Nodes of a function that is monotone and continuous between neighbours.

    theta : shape (n,), radians, nondecreasing; value : shape (n,), monotone. An angle given twice is a jump, a
    value given twice a plateau. ``sign`` is 1 when the values rise, -1 when they fall. The inverse is the one that
    is continuous from the right: constant across a jump, at a plateau's level its far end.
    """

    theta: Array
    value: Array
    sign: int
    map: CircleMap

    def inverse(self, values: Array) -> Array:
        """The angle at which the function takes each of ``values``; values beyond the table give its ends.

        Newton steps kept inside a bracket, halved when they converge slowly (Brent 1973, ch. 4; Press et al. 2007,
        9.4), until the residual is at rounding; one more step is taken then.
        """
        wanted = self.sign * np.ravel(values)
        rising = self.sign * self.value
        cell = self.cell(np.ravel(values))
        low, high = self.theta[cell], self.theta[cell + 1]
        below, above = rising[cell] - wanted, rising[cell + 1] - wanted
        result = np.where(below >= 0.0, low, high)
        inside = np.flatnonzero((below < 0.0) & (above > 0.0) & (high > low))
        if inside.size:
            share = below[inside] / (below[inside] - above[inside])
            first = low[inside] + (high - low)[inside] * share
            result[inside] = self._newton(wanted[inside], low[inside], high[inside], first)
        return np.reshape(result, np.shape(values))

    def cell(self, values: Array) -> npt.NDArray[np.intp]:
        """The cell, between one node and the next, in which each of ``values`` is taken."""
        rising, side = self.sign * self.value, "right" if self.sign > 0 else "left"
        cell = np.searchsorted(rising, self.sign * values, side=side) - 1  # type: ignore[call-overload]
        return np.asarray(np.clip(cell, 0, self.theta.size - 2))

    def _newton(self, wanted: Array, low: Array, high: Array, x: Array) -> Array:
        solved, index = x.copy(), np.arange(x.size)
        last = high - low
        for _ in range(_PASSES):
            gap, slope = self.sign * self.map(x) - wanted, self.map.derivative(x)
            low, high = np.where(gap <= 0.0, x, low), np.where(gap >= 0.0, x, high)
            ahead, good = _step(x, gap, self.sign * slope, low, high, last)
            # The rounding of values, and of angles magnified by the slope: no gap below it means anything.
            rounding = 4.0 * EPS * (1.0 + np.abs(wanted) + np.abs(slope) * (1.0 + np.abs(x)))
            fine = (np.abs(gap) <= rounding) | (np.abs(ahead - x) <= EPS * (1.0 + np.abs(x)))
            solved[index] = np.where(good, ahead, x)
            if fine.all():
                return solved
            last, more = ahead - x, ~fine
            x, last, index = ahead[more], last[more], index[more]
            low, high, wanted = low[more], high[more], wanted[more]
        raise ConvergenceError(f"the inverse at {wanted[0]:.9g} is still {np.max(high - low):.3g} rad wide")

    def inverse_of_one_float(self) -> Scalar:
        """The same inverse for one python float: interpolation kept inside a bracket (Anderson & Björck 1973)."""
        sign, lift = self.sign, self.map.scalar()
        nodes, rising = self.theta.tolist(), (self.sign * self.value).tolist()
        bisect, final = bisect_right if sign > 0 else bisect_left, len(nodes) - 2

        def inverse(value: float) -> float:
            wanted = sign * value
            cell = min(max(bisect(rising, wanted) - 1, 0), final)
            low, high = nodes[cell], nodes[cell + 1]
            below, above = rising[cell] - wanted, rising[cell + 1] - wanted
            if below >= 0.0:
                return float(low)
            if above <= 0.0 or low == high:
                return float(high)
            return _interpolated(lambda x: sign * lift(x) - wanted, low, high, below, above)

        return inverse


def _step(
    x: Array, gap: Array, slope: Array, low: Array, high: Array, last: Array
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Newton's next angle, or the middle of the bracket where that one is outside or no nearer; which it is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        step = -gap / slope
    ahead = x + step
    good = (ahead >= low) & (ahead <= high) & (np.abs(step) <= 0.5 * np.abs(last))
    return np.where(good, ahead, 0.5 * (low + high)), good


def _interpolated(gap: Scalar, low: float, high: float, below: float, above: float) -> float:
    """The root of ``gap`` between ``low`` and ``high``, where it is ``below`` < 0 < ``above``."""
    x, side = low, 0
    for turn in range(_PASSES):
        before = x
        x = low - below * (high - low) / (above - below) if turn % 8 < 6 else 0.5 * (low + high)
        at = gap(x)
        if at == 0.0 or abs(x - before) <= EPS * max(abs(x), 1.0):
            return x
        if at < 0.0:
            ratio = 1.0 - at / below
            above *= (ratio if ratio > 0.0 else 0.5) if side < 0 else 1.0
            low, below, side = x, at, -1
        else:
            ratio = 1.0 - at / above
            below *= (ratio if ratio > 0.0 else 0.5) if side > 0 else 1.0
            high, above, side = x, at, 1
    raise ConvergenceError(f"the inverse is still {high - low:.3g} rad wide at θ = {x:.9g}")
