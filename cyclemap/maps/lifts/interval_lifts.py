"""Lifts on intervals: a formula, or samples with bounds, evaluated with its slope in ball
arithmetic (FLINT's arb).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, reduce
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI
from cyclemap.checks import non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import LIFT
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import within_turn
from cyclemap.maps.lifts.map_algebra import CompositeLift
from cyclemap.maps.lifts.piecewise_lifts import PiecewiseCubic
from cyclemap.plain_text import install_words

# flint.arb, a midpoint and a radius, or a power series of two: every operation gives balls that
# hold the true result
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


def _lifted(operation: Callable[..., Ball]) -> Callable[..., Jet]:
    """A method of jets for an operation on power series."""

    def method(*jets: Jet | float) -> Jet:
        series = operation(*(_series(jet) for jet in jets))
        return Jet(series[0], series[1])

    return method


def _series(number: Jet | float) -> Ball:
    """The two terms of a jet, or a number as it is."""
    if isinstance(number, Jet):
        return ball_library().arb_series([number.value, number.slope], prec=2)
    if not isinstance(number, (int, float, np.integer, np.float32)):
        raise TypeError(f"{type(number).__name__} beside an interval")
    return int(number) if isinstance(number, (int, np.integer)) else float(number)


@dataclass(frozen=True, eq=False)
class Jet:
    """A value and its slope by the orbit's start, both balls."""

    value: Ball
    slope: Ball

    __add__ = __radd__ = _lifted(lambda x, y: x + y)
    __neg__ = _lifted(lambda x: -x)
    __sub__ = _lifted(lambda x, y: x - y)
    __rsub__ = _lifted(lambda x, y: y - x)
    __mul__ = __rmul__ = _lifted(lambda x, y: x * y)
    __truediv__ = _lifted(lambda x, y: x / y)
    __rtruediv__ = _lifted(lambda x, y: y / x)

    __pow__ = _lifted(lambda x, y: x**y)

    def __bool__(self) -> bool:
        raise TypeError("an interval is neither true nor false")

    def __eq__(self, other: object) -> bool:
        raise TypeError("intervals cannot be compared")

    # numpy's functions of object arrays call the methods of their names.
    sin = _lifted(lambda x: x.sin())
    cos = _lifted(lambda x: x.cos())
    tan = _lifted(lambda x: x.tan())
    exp = _lifted(lambda x: x.exp())
    log = _lifted(lambda x: x.log())
    sqrt = _lifted(lambda x: x.sqrt())
    sinh = _lifted(lambda x: 0.5 * (x.exp() - (-x).exp()))
    cosh = _lifted(lambda x: 0.5 * (x.exp() + (-x).exp()))
    tanh = _lifted(lambda x: 1 - 2 / ((2 * x).exp() + 1))
    arctan = _lifted(lambda x: x.atan())

    def arctan2(self, across: Jet | float) -> Jet:
        """The angle of the point (across, self); where it may jump from π to -π its slope is
        unknown.
        """
        arb = ball_library().arb
        across = across if isinstance(across, Jet) else 0 * self + across
        angle = arb.atan2(self.value, across.value)
        if not across.value > 0 and self.value.contains(0):
            return Jet(angle, arb.nan())
        turned = across.value * self.slope - self.value * across.slope
        return Jet(angle, turned / (across.value * across.value + self.value * self.value))


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
    if isinstance(lift, CompositeLift):
        if circle_map.max_error > 0.0 or bound > 0.0:
            raise InvalidInput(
                "no proof: errors of maps made of maps are not followed; prove of a sampled map "
                "itself"
            )
        chain = [interval_lift(inner, 0.0) for inner in lift.maps]
        return lambda jet: reduce(lambda image, step: step(image), chain, jet)
    exact: IntervalLift = partial(_of_formula, lift)
    if isinstance(lift, PiecewiseCubic):
        exact = partial(_of_cubics, lift)
    elif circle_map.max_error == 0.0 and bound == 0.0:
        return exact
    if circle_map.max_error == 0.0 or bound == 0.0:
        raise InvalidInput(
            f"no proof: max_error is {circle_map.max_error:g} and slope_error {bound:g}; a map "
            "that is not exact needs bounds on the errors of its values (max_error of the map) and "
            "of its slope (slope_error), both above 0"
        )
    return partial(_inexact, exact, circle_map.max_error, bound)


def _inexact(exact: IntervalLift, max_error: float, slope_error: float, jet: Jet) -> Jet:
    """The image of every lift that lies so near to a computed one."""
    arb = ball_library().arb
    straight = exact(Jet(jet.value, arb(1)))
    if not straight.value.is_finite():
        return straight
    size = float(straight.value.abs_upper())
    steepness = float(straight.slope.abs_upper())
    rounding = LIFT * (TWO_PI * (1.0 + steepness) + size)
    value = straight.value + arb(0, max_error + rounding)
    return Jet(value, (straight.slope + arb(0, slope_error + rounding)) * jet.slope)


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
    low = np.nextafter(float(jet.value.lower()), -np.inf)
    high = np.nextafter(float(jet.value.upper()), np.inf)
    count = pieces.knots.size - 1
    base, laps = within_turn(np.array([low, high]))
    first, last = (np.searchsorted(pieces.knots, base, "right") + count * laps).astype(int)
    values = []
    slopes = []
    # A neighbour more on either side is never wrong, as the ends of turns are rounded.
    for index in range(first - 2, last + 1):
        lap, piece = divmod(index, count)
        ends = pieces.knots[piece : piece + 2] + TWO_PI * lap
        start, end = np.nextafter(ends, [-np.inf, np.inf])
        if max(low, start) > min(high, end):
            continue
        turned = 2 * arb.pi() * lap
        place = arb(max(low, start)).union(arb(min(high, end)))
        offset = place - turned - float(pieces.knots[piece])
        cubic = ball_library().arb_poly(pieces.coefficients[:, piece].tolist())
        values.append(cubic(offset) + pieces.degree * turned)
        slopes.append(cubic.derivative()(offset))
    return Jet(reduce(arb.union, values), reduce(arb.union, slopes) * jet.slope)
