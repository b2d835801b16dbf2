"""Rotation numbers with an enclosure that holds the truth, and rotation intervals of folded lifts."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor

import numpy as np
import numpy.typing as npt

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.envelopes import is_nondecreasing, lower_envelope, upper_envelope

ITERATES = 40_000
MAX_PERIOD = 2_000
_ROUNDING = 4e-15  # radians a cycle: allowance for rounding when iterates are compared


@dataclass(frozen=True)
class RotationNumber:
    """A rotation number in turns a cycle.

    value : the best estimate, inside [lower, upper].
    lower, upper : the truth lies between them (both included; rounded outward).
    locked : p/q when a periodic orbit proves the rotation number to be exactly that, else None.
    """

    value: float
    lower: float
    upper: float
    locked: Fraction | None


@dataclass(frozen=True)
class RotationInterval:
    """All rotation numbers of a lift, [lower, upper] in turns a cycle, with the enclosures of both ends."""

    lower: float
    upper: float
    lower_number: RotationNumber
    upper_number: RotationNumber


@dataclass(frozen=True, eq=False)
class _Path:
    """An orbit: positions in [0, 2π), whole turns so far (both n + 1 long), and the turn of each cycle."""

    theta: Array
    turns: npt.NDArray[np.int64]
    steps: Array


def rotation_number(circle_map: CircleMap, *, iterates: int = ITERATES, max_period: int = MAX_PERIOD) -> RotationNumber:
    """The rotation number ρ = lim (Fⁿ(θ) - θ)/2πn of a degree-1 lift, with bounds.

    Nondecreasing lifts (jumps allowed): every iterate bounds ρ, since Fⁿ(θ) ≥ θ + 2πp at one θ implies ρ ≥
    p/n, and ≤ likewise; the best of ``iterates`` such bounds from one orbit make [lower, upper], about
    1/iterates² wide where ρ is irrational. Exact in exact arithmetic; comparisons closer than 4e-15
    radians a cycle are not used. When F^q - id takes values on both sides of 2πp near the orbit (q ≤
    ``max_period``), ρ = p/q is proved and ``locked``. Otherwise ``value`` is the weighted Birkhoff average
    of the turn (Das, Saiki, Sander & Yorke 2017), near rounding for smooth maps with Diophantine ρ, kept
    inside the bounds. At the very edge of a tongue the two sides cannot be told apart: ``locked`` is None
    and the bounds are wide.

    Lifts that fold have an interval of rotation numbers: [lower, upper] encloses all of it (see
    ``rotation_interval``), ``value`` is the weighted Birkhoff average of the one orbit that starts at θ =
    0, and ``locked`` is set only when the interval is one proved fraction.

    The bounds hold for the map as given; its ``max_error`` is not added.

    >>> rotation_number(CircleMap.arnold(0.1, 0.9)).locked
    Fraction(0, 1)
    """
    count = whole_number("iterates", iterates, least=16)
    longest = whole_number("max_period", max_period, least=1)
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: a rotation number needs degree 1")
    if is_nondecreasing(circle_map):
        return _monotone_rotation(circle_map, count, longest)
    interval = rotation_interval(circle_map, iterates=count, max_period=longest)
    low, high = interval.lower_number, interval.upper_number
    locked = low.locked if low.locked == high.locked else None
    value = float(locked) if locked is not None else _weighted_birkhoff(_path(circle_map, 0.0, count).steps)
    return RotationNumber(min(max(value, low.lower), high.upper), low.lower, high.upper, locked)


def rotation_interval(
    circle_map: CircleMap, *, iterates: int = ITERATES, max_period: int = MAX_PERIOD
) -> RotationInterval:
    """All rotation numbers of a degree-1 lift: [ρ(F⁻), ρ(F⁺)] of its lower and upper monotone envelopes.

    For continuous lifts every number between is the rotation number of some orbit (Chenciner, Gambaudo &
    Tresser 1984; Misiurewicz 1986); with downward jumps it still contains all of them. A nondecreasing
    lift gives one point.

    >>> found = rotation_interval(CircleMap.arnold(0.5, 3.0))
    >>> found.lower_number.locked, found.upper_number.locked
    (Fraction(1, 6), Fraction(5, 6))
    """
    count = whole_number("iterates", iterates, least=16)
    longest = whole_number("max_period", max_period, least=1)
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: a rotation interval needs degree 1")
    low = _monotone_rotation(lower_envelope(circle_map), count, longest)
    high = _monotone_rotation(upper_envelope(circle_map), count, longest)
    return RotationInterval(low.value, high.value, low, high)


def _monotone_rotation(circle_map: CircleMap, iterates: int, max_period: int) -> RotationNumber:
    path = _path(circle_map, 0.0, iterates)
    low, high = _bounds(path)
    candidate = simplest_between(low, high)
    if candidate.denominator <= max_period and _is_locked(circle_map, float(path.theta[-1]), candidate):
        return RotationNumber(float(candidate), _down(candidate), _up(candidate), candidate)
    lower, upper = _down(low), _up(high)
    value = _weighted_birkhoff(path.steps)
    return RotationNumber(value if lower <= value <= upper else 0.5 * (lower + upper), lower, upper, None)


def _path(circle_map: CircleMap, start: float, count: int) -> _Path:
    """One orbit kept in [0, 2π) with its whole turns counted apart, so that nothing is lost to rounding."""
    lift, theta, turns = circle_map.scalar(), start, 0
    thetas, laps, steps = [theta], [turns], []
    for _ in range(count):
        image = lift(theta)
        steps.append(image - theta)
        lap = floor(image / TWO_PI)
        theta = image - TWO_PI * lap
        turns += lap
        thetas.append(theta)
        laps.append(turns)
    return _Path(np.array(thetas), np.array(laps, dtype=np.int64), np.array(steps))


def _bounds(path: _Path) -> tuple[Fraction, Fraction]:
    """The best p/n ≤ ρ ≤ p'/n' that this orbit proves."""
    n = np.arange(1, path.theta.size)
    part = (path.theta[1:] - path.theta[0]) / TWO_PI
    allowance = _ROUNDING * (n + 8.0)
    below = path.turns[1:] + np.floor(part - allowance).astype(np.int64)
    above = path.turns[1:] + np.ceil(part + allowance).astype(np.int64)
    best_low, best_high = int(np.argmax(below / n)), int(np.argmin(above / n))
    return Fraction(int(below[best_low]), best_low + 1), Fraction(int(above[best_high]), best_high + 1)


def _is_locked(circle_map: CircleMap, near: float, ratio: Fraction) -> bool:
    """Whether F^q - id - 2πp takes both signs beyond rounding: for a nondecreasing F that proves ρ = p/q."""
    reach = np.pi * 2.0 ** -np.arange(0.0, 38.0)
    start = near + np.concatenate([-reach, [0.0], reach[::-1]])
    theta, turns = start, np.zeros(start.size)
    for _ in range(ratio.denominator):
        image = circle_map(theta)
        lap = np.floor(image / TWO_PI)
        theta, turns = image - TWO_PI * lap, turns + lap
    gap = (theta - start) + TWO_PI * (turns - ratio.numerator)
    margin = 4.0 * _ROUNDING * (ratio.denominator + 8.0)
    return bool(np.any(gap > margin) and np.any(gap < -margin))


def _weighted_birkhoff(steps: Array) -> float:
    """Average of the turns with weights exp(-1/t(1 - t)), in turns a cycle."""
    t = np.arange(1.0, steps.size + 1.0) / (steps.size + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    return float(np.dot(weight, steps) / np.sum(weight) / TWO_PI)


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The fraction of smallest denominator in [low, high] (Stern-Brocot descent).

    >>> simplest_between(Fraction(5, 17), Fraction(1, 3))
    Fraction(1, 3)
    """
    if high < low:
        raise InvalidInput(f"the interval [{low}, {high}] is empty: give low <= high")
    whole = ceil(low)
    if whole <= high:
        return Fraction(whole)
    base = floor(low)
    return base + 1 / simplest_between(1 / (high - base), 1 / (low - base))


def _down(ratio: Fraction) -> float:
    near = float(ratio)
    return near if Fraction(near) <= ratio else float(np.nextafter(near, -np.inf))


def _up(ratio: Fraction) -> float:
    near = float(ratio)
    return near if Fraction(near) >= ratio else float(np.nextafter(near, np.inf))
