"""Lifts on intervals: a formula, or samples with bounds, evaluated with its slope in ball
arithmetic (FLINT's arb).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI
from cyclemap.checks import non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import LIFT
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.map_algebra import CompositeLift
from cyclemap.maps.lifts.piecewise_lifts import PiecewiseCubic
from cyclemap.plain_text import install_words

# flint.arb, a midpoint and a radius: every operation gives a ball that holds the true result
Ball = Any

_WRITTEN = (
    "write it with +, -, *, /, powers and numpy's sin, cos, tan, exp, log, sqrt, sinh, cosh, tanh, "
    "arctan and arctan2, without comparisons"
)


def ball_library() -> Any:  # typed as Any: an extra that need not be there
    """python-flint, or a refusal that says how to install it."""
    try:
        import flint
    except ImportError as error:
        raise InvalidInput(f"a proof needs python-flint: {install_words('proofs')}") from error
    return flint


def _chained(
    function: Callable[[Ball], Ball], slope: Callable[[Ball], Ball]
) -> Callable[[Jet], Jet]:
    """A method of jets for a function and its derivative."""

    def method(jet: Jet) -> Jet:
        return Jet(function(jet.value), slope(jet.value) * jet.slope)

    return method


@dataclass(frozen=True, eq=False)
class Jet:
    """A value and its slope by the orbit's start, both balls."""

    value: Ball
    slope: Ball

    def __add__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        return Jet(self.value + value, self.slope + slope)

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.slope)

    def __sub__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        return Jet(self.value - value, self.slope - slope)

    def __rsub__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        return Jet(value - self.value, slope - self.slope)

    def __mul__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        return Jet(self.value * value, self.slope * value + self.value * slope)

    __rmul__ = __mul__

    def __truediv__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        ratio = self.value / value
        return Jet(ratio, (self.slope - ratio * slope) / value)

    def __rtruediv__(self, other: Jet | float) -> Jet:
        value, slope = self._both(other)
        return Jet(value, slope) / self

    def __pow__(self, exponent: Jet | float) -> Jet:
        if isinstance(exponent, Jet):
            raise TypeError("an exponent that depends on θ")
        if exponent == int(exponent):
            power = int(exponent)
            return Jet(self.value**power, power * self.value ** (power - 1) * self.slope)
        power, _ = self._both(exponent)
        return Jet(self.value**power, power * self.value ** (power - 1) * self.slope)

    def __bool__(self) -> bool:
        raise TypeError("an interval is neither true nor false")

    def __eq__(self, other: object) -> bool:
        raise TypeError("intervals cannot be compared")

    # numpy's functions of object arrays call the methods of their names.
    sin = _chained(lambda x: x.sin(), lambda x: x.cos())
    cos = _chained(lambda x: x.cos(), lambda x: -x.sin())
    tan = _chained(lambda x: x.tan(), lambda x: 1 + x.tan() ** 2)
    exp = _chained(lambda x: x.exp(), lambda x: x.exp())
    log = _chained(lambda x: x.log(), lambda x: 1 / x)
    sqrt = _chained(lambda x: x.sqrt(), lambda x: 1 / (2 * x.sqrt()))
    sinh = _chained(lambda x: x.sinh(), lambda x: x.cosh())
    cosh = _chained(lambda x: x.cosh(), lambda x: x.sinh())
    tanh = _chained(lambda x: x.tanh(), lambda x: 1 - x.tanh() ** 2)
    arctan = _chained(lambda x: x.atan(), lambda x: 1 / (1 + x * x))

    def arctan2(self, across: Jet | float) -> Jet:
        """The angle of the point (across, self); where it may jump from π to -π its slope is
        unknown.
        """
        arb = ball_library().arb
        value, slope = self._both(across)
        angle = arb.atan2(self.value, value)
        if not value > 0 and self.value.contains(0):
            return Jet(angle, arb.nan())
        return Jet(
            angle,
            (value * self.slope - self.value * slope) / (value * value + self.value * self.value),
        )

    def _both(self, other: Jet | float) -> tuple[Ball, Ball]:
        if isinstance(other, Jet):
            return other.value, other.slope
        if not isinstance(other, (int, float, np.integer, np.float32)):
            raise TypeError(f"{type(other).__name__} beside an interval")
        exact = int(other) if isinstance(other, (int, np.integer)) else float(other)
        return self.value * 0 + exact, self.value * 0


IntervalLift = Callable[[Jet], Jet]


def interval_lift(circle_map: CircleMap, slope_error: float) -> IntervalLift:
    """The lift and its slope on balls: of a formula as it is written, of samples with their errors.

    slope_error : a bound on |F' - truth| beside ``max_error``; the balls hold every truth within
        both.

    Raises InvalidInput for maps with breaks, for lifts that do not take intervals, and for samples
    without bounds.
    """
    if circle_map.breaks.size:
        raise InvalidInput(
            f"no proof: the map has {circle_map.breaks.size} breaks, and proofs are for smooth maps"
        )
    bound = non_negative_number("slope_error", slope_error)
    lift = circle_map.formula
    inner: IntervalLift
    if isinstance(lift, CompositeLift):
        if circle_map.max_error > 0.0 or bound > 0.0:
            raise InvalidInput(
                "no proof: errors of maps made of maps are not followed; prove of a sampled map "
                "itself"
            )
        chain = [interval_lift(part, 0.0) for part in lift.maps]

        def inner(jet: Jet) -> Jet:
            for step in chain:
                jet = step(jet)
            return jet

        return inner
    inner = (
        partial(_of_cubics, lift)
        if isinstance(lift, PiecewiseCubic)
        else partial(_of_formula, lift)
    )
    if circle_map.max_error == 0.0 and bound == 0.0 and not isinstance(lift, PiecewiseCubic):
        return inner
    if circle_map.max_error == 0.0 or bound == 0.0:
        raise InvalidInput(
            f"no proof: max_error is {circle_map.max_error:g} and slope_error {bound:g}; a map "
            "that is not exact needs bounds on the errors of its values (max_error of the map) and "
            "of its slope (slope_error), both above 0"
        )
    arb = ball_library().arb

    def inexact(jet: Jet) -> Jet:
        straight = inner(Jet(jet.value, arb(1)))
        if not straight.value.is_finite():
            return straight
        size = float(straight.value.abs_upper())
        steepness = float(straight.slope.abs_upper())
        rounding = LIFT * (TWO_PI * (1.0 + steepness) + size)
        value = straight.value + arb(0, circle_map.max_error + rounding)
        return Jet(value, (straight.slope + arb(0, bound + rounding)) * jet.slope)

    return inexact


def _of_formula(lift: Callable[[Any], Any], jet: Jet) -> Jet:
    try:
        value = lift(np.array([jet], dtype=object))[0]
        return value if isinstance(value, Jet) else 0 * jet + value  # a constant becomes a jet
    except Exception as error:
        raise InvalidInput(
            f"no proof: the lift does not take intervals ({type(error).__name__}: {error}); "
            f"{_WRITTEN}"
        ) from error


def _of_cubics(pieces: PiecewiseCubic, jet: Jet) -> Jet:
    """The hull of all cubics that an interval meets."""
    arb = ball_library().arb
    if not float(jet.value.rad()) < np.pi:  # a turn or more, or unknown
        return Jet(arb.nan(), arb.nan())
    turns = int(np.floor(float(jet.value.mid()) / TWO_PI))
    base = jet.value - 2 * arb.pi() * turns
    low = np.nextafter(float(base.lower()), -np.inf)
    high = np.nextafter(float(base.upper()), np.inf)
    hull: Jet | None = None
    for lap in (-1, 0, 1):
        start = lap * TWO_PI
        first = int(np.searchsorted(pieces.knots, low - start, side="right")) - 1
        last = int(np.searchsorted(pieces.knots, high - start, side="left"))
        # A neighbour more on either side is never wrong, as ``start`` is rounded.
        for index in range(max(first - 1, 0), min(last + 1, pieces.knots.size - 1)):
            left = float(pieces.knots[index] + start)
            begin = max(low, left)
            end = min(high, float(pieces.knots[index + 1] + start))
            if begin > end:
                continue
            offset = arb(begin).union(arb(end)) - left
            c0, c1, c2, c3 = pieces.coefficients[:, index].tolist()
            climb = 2 * arb.pi() * (pieces.degree * (lap + turns))
            value = ((c3 * offset + c2) * offset + c1) * offset + c0 + climb
            slope = (3 * c3 * offset + 2 * c2) * offset + c1
            hull = (
                Jet(value, slope)
                if hull is None
                else Jet(hull.value.union(value), hull.slope.union(slope))
            )
    assert hull is not None
    return Jet(hull.value, hull.slope * jet.slope)
