"""Proofs by ball arithmetic: the exact number of periodic points and their enclosures, by bisection
and monotonicity, and enclosures of rotation numbers.

A turn is cut into cells. On a cell either Fⁿ - id is proved to keep between two neighbouring
multiples of 2π, or its slope is proved not to vanish; else the cell is halved. Between cells of the
first kind the curve is strictly monotone, so the whole turns on its two sides count its crossings
exactly, each of one point (Moore, Kearfott & Cloud 2009).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial, reduce
from itertools import pairwise
from operator import methodcaller
from threading import RLock
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole, shorter_way
from cyclemap.checks import non_negative_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import LIFT, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import within_turn
from cyclemap.maps.lifts.map_algebra import CompositeLift
from cyclemap.maps.lifts.piecewise_lifts import PiecewiseCubic
from cyclemap.maps.lifts.scan import root_between
from cyclemap.plain_text import install_words

# flint.arb, a midpoint and a radius, or a power series of two: every operation gives balls that
# hold the true result
Ball = Any
_PRECISION = RLock()  # the library's precision is one for all threads
_BITS = 160  # of the balls: three times those of a float, for steep iterates and near tangencies
_START_CELLS = 32
_MOST_STEPS = 1_000_000  # cells times their iterates: a minute
_MOST_FOLDED = 500_000  # the same for each of the iterates that bound a folded lift's rotation
_MOST_POINTS = 150_000  # points times their iterates: a minute
# radians: a cell this narrow that decides nothing holds a tangency, or nearly one
_NARROWEST = 1e-13
_POINT = 1e-30  # radians: a ball this small counts as a point, which only rounding widens
# where a turn may be cut: no number of mathematics
_CUTS = 0.0131, 1.6127, 3.1923, 4.7719, 5.5512, 2.3456
_SEAM = 1e-12  # radians on both sides of the cut that must be free of points
_NEWTON_STEPS = 2  # from a root that is good to a float's digits
_FLAT = 1e-6  # radians: an arc this narrow on which the sign of F' cannot be told may be flat
_LONGEST_FOLDED = 6  # iterates of a lift that folds: each has many more monotone pieces
_WRITTEN = (
    "write it with +, -, *, /, powers and numpy's sin, cos, tan, exp, log, sqrt, sinh, cosh, tanh, "
    "arctan and arctan2, without comparisons"
)


@dataclass(frozen=True)
class LockingProof:
    """Two angles that prove ρ = p/q of a nondecreasing lift.

    Attributes
    ----------
    ratio : Fraction
        p/q in lowest terms.
    below, above : float
        Radians, in [-π, 3π]: F^q(below) < below + 2πp, so ρ ≤ p/q, and F^q(above) > above +
        2πp, so ρ ≥ p/q.

    Notes
    -----
    A nondecreasing lift jumps only upwards, so between ``above`` and the next copy of ``below``
    lies an orbit of period q and winding p: ``periodic_orbits`` gives it.
    """

    ratio: Fraction
    below: float
    above: float


def _ball_library() -> Any:  # typed as Any: an extra that need not be there
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
        return _ball_library().arb_series([number.value, number.slope], prec=2)
    if not isinstance(number, (int, float, np.integer, np.float32)):
        raise TypeError(f"{type(number).__name__} beside an interval")
    return int(number) if isinstance(number, (int, np.integer)) else float(number)


@dataclass(frozen=True, eq=False)
class Jet:
    """A value and its slope by the orbit's start, both balls."""

    value: Ball
    slope: Ball

    __add__ = __radd__ = _lifted(operator.add)
    __neg__ = _lifted(operator.neg)
    __sub__ = _lifted(operator.sub)
    __rsub__ = _lifted(lambda x, y: y - x)
    __mul__ = __rmul__ = _lifted(operator.mul)
    __truediv__ = _lifted(operator.truediv)
    __rtruediv__ = _lifted(lambda x, y: y / x)
    __pow__ = _lifted(operator.pow)

    def __bool__(self) -> bool:
        raise TypeError("an interval is neither true nor false")

    def __eq__(self, other: object) -> bool:
        raise TypeError("intervals cannot be compared")

    # numpy's functions of object arrays call the methods of their names.
    sin = _lifted(methodcaller("sin"))
    cos = _lifted(methodcaller("cos"))
    tan = _lifted(methodcaller("tan"))
    exp = _lifted(methodcaller("exp"))
    log = _lifted(methodcaller("log"))
    sqrt = _lifted(methodcaller("sqrt"))
    sinh = _lifted(lambda x: 0.5 * (x.exp() - (-x).exp()))
    cosh = _lifted(lambda x: 0.5 * (x.exp() + (-x).exp()))
    tanh = _lifted(lambda x: 1 - 2 / ((2 * x).exp() + 1))
    arctan = _lifted(methodcaller("atan"))

    def arctan2(self, across: Jet | float) -> Jet:
        """The angle of the point (across, self); where it may jump from π to -π its slope is
        unknown.
        """
        arb = _ball_library().arb
        across = across if isinstance(across, Jet) else 0 * self + across
        angle = arb.atan2(self.value, across.value)
        if not across.value > 0 and self.value.contains(0):
            return Jet(angle, arb.nan())
        turned = across.value * self.slope - self.value * across.slope
        return Jet(angle, turned / (across.value * across.value + self.value * self.value))


IntervalLift = Callable[[Jet], Jet]


def _interval_lift(circle_map: CircleMap, slope_error: float) -> IntervalLift:
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
        chain = [_interval_lift(inner, 0.0) for inner in lift.maps]
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
    arb = _ball_library().arb
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
    arb = _ball_library().arb
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
        cubic = _ball_library().arb_poly(pieces.coefficients[:, piece].tolist())
        values.append(cubic(offset) + pieces.degree * turned)
        slopes.append(cubic.derivative()(offset))
    return Jet(reduce(arb.union, values), reduce(arb.union, slopes) * jet.slope)


@dataclass(frozen=True, eq=False)
class ProvedPoints:
    """Points with Fⁿ(θ) = θ + 2πw that are there, sorted, each alone within its error bound.

    theta : radians in [0, 2π); error_bound : theirs.
    winding : w.
    multiplier : (Fⁿ)' there; multiplier_error : bounds on the errors of that.
    image : index of the point that F maps each to.
    """

    theta: Array
    error_bound: Array
    winding: Whole
    multiplier: Array
    multiplier_error: Array
    image: Whole


@dataclass(frozen=True, eq=False)
class _Cell:
    """[start, end] and what is proved of Fⁿ - id on it: its sign of slope, or the whole turns that
    it keeps above.
    """

    start: float
    end: float
    sign: int
    turns: int


def proved_points(circle_map: CircleMap, period: int, slope_error: float) -> ProvedPoints:
    """All θ in [0, 2π) with Fⁿ(θ) = θ + 2πw, sorted: that there are so many, and where, is a
    theorem.

    Of a formula it is one about the formula with the floats that are written in it, π being the
    true one where numpy's functions bring it in; of a sampled map, about every smooth map within
    ``max_error`` and ``slope_error`` of it.

    Raises InvalidInput when the lift does not take intervals, or is no lift in exact arithmetic;
    ConvergenceError when a tangency, or nearly one, is met, or it needs more than 1,000,000/n
    cells or 150,000/n points.
    """
    with _proof(circle_map, period, slope_error) as proof:
        return proof.points()


def proved_rotation(
    circle_map: CircleMap, iterates: int, width: float, lock: LockingProof | None
) -> tuple[Fraction, Fraction]:
    """Bounds on the turns a cycle of every orbit of a degree-1 lift; equal where ``lock`` holds.

    Where the lift is proved to rise they are p/n ≤ ρ with Fⁿ(0) ≥ 2πp, and the like from above
    (Poincaré 1885), n ≤ ``iterates``, or fewer once they are no further apart than ``width``; else
    those of Fⁿ - id all round, n ≤ 6.
    """
    with _proof(circle_map, 1, 0.0) as proof:
        rises = proof.rises()
        if rises and lock is not None and proof.holds(lock):
            return lock.ratio, lock.ratio
        bounds = proof.orbit_turns(iterates) if rises else proof.all_turns()
        low, high = next(bounds, (None, None))
        if low is None or high is None:
            raise ConvergenceError(
                f"no proof: Fⁿ - id, n ≤ {_LONGEST_FOLDED}, meets whole turns so nearly, as at a "
                "tangency, that it cannot be bounded: prove on either side of it"
            )
        for lower, upper in bounds:
            low = max(low, lower)
            high = min(high, upper)
            if high - low <= width:
                break
        return low, high


@contextmanager
def _proof(circle_map: CircleMap, period: int, slope_error: float) -> Iterator[_Proof]:
    """What proves of Fⁿ, within the library's precision for it; the lift is checked."""
    flint = _ball_library()
    with _PRECISION, flint.ctx.workprec(_BITS):
        proof = _Proof(
            _interval_lift(circle_map, slope_error), period, circle_map.degree, flint.arb
        )
        proof.check_lift()
        yield proof


@dataclass(frozen=True, eq=False)
class _Proof:
    lift: IntervalLift
    period: int
    degree: int
    arb: Any

    def check_lift(self) -> None:
        """Refuse constants that make F(θ + 2π) - F(θ) anything but 2π·degree."""
        for theta in _CUTS:
            low = self._iterate(self.arb(theta), 1)
            high = self._iterate(theta + 2 * self.arb.pi(), 1)
            climb = (high.value - low.value) / (2 * self.arb.pi())
            if not climb.overlaps(self.arb(self.degree)):
                raise InvalidInput(
                    "no proof: in exact arithmetic F(θ + 2π) - F(θ) is "
                    f"{climb.str(20, radius=False)} turns at θ = {theta:g}, not {self.degree}: a "
                    "constant of the lift, such as a rounded π, must cancel"
                )

    def points(self) -> ProvedPoints:
        """Every crossing between cells that keep off the multiples of 2π, in order."""
        if _START_CELLS * self.period > _MOST_STEPS:
            raise ConvergenceError(
                f"no proof: F^{self.period} takes {_START_CELLS} cells at least, above "
                f"{_MOST_STEPS:,} steps: ask for a shorter period"
            )
        lap = self.degree**self.period - 1
        cut, turns = self._cut()
        cells = self._cells(cut, _MOST_STEPS)
        covered = cells[-1].end - cut if cells else 0.0
        if covered < TWO_PI:
            raise ConvergenceError(
                f"no proof within {_MOST_STEPS // self.period:,} cells, which have come "
                f"{covered:.3g} of {TWO_PI:.3g} radians far: F^{self.period} is too steep, or the "
                "errors of the map are too large"
            )
        runs = []
        run = _Cell(cut, cut, 0, turns)
        for cell in [*cells, _Cell(cut + TWO_PI, cut + TWO_PI, 0, turns + lap)]:
            if cell.sign:
                run = _Cell(run.start if run.sign else cell.start, cell.end, cell.sign, run.turns)
                continue
            low, high = sorted((run.turns, cell.turns))
            runs.append((run, low + 1, high + 1))
            run = cell
        count = sum(end - start for _, start, end in runs)
        if self.period * count > _MOST_POINTS:
            raise ConvergenceError(
                f"no proof: F^{self.period} has {count:,} points, above "
                f"{_MOST_POINTS // self.period:,}: ask for a shorter period"
            )
        crossings = []
        for run, start, end in runs:
            crossings += [self._enclosed(run, level, lap) for level in range(start, end)]
        crossings.sort(key=lambda item: item[0])
        rows = [
            (theta, theta.error_bound, multiplier, multiplier.error_bound)
            for theta, _, multiplier, _ in crossings
        ]
        theta, bound, multiplier, error = np.reshape(rows, (-1, 4)).astype(float).T
        winding = np.array([turns for _, turns, _, _ in crossings], dtype=np.int64)
        image = [self._image(ball, theta, bound) for _, _, _, ball in crossings]
        return ProvedPoints(
            theta, bound, winding, multiplier, error, np.array(image, dtype=np.int64)
        )

    def rises(self) -> bool:
        """Whether F' > 0 all round, on arcs halved as long as that may be told."""
        edges = np.linspace(0.0, TWO_PI + _SEAM, _START_CELLS + 1).tolist()
        waiting = list(pairwise(edges))
        while waiting:
            start, end = waiting.pop()
            slope = self._iterate(self.arb(start).union(self.arb(end)), 1).slope
            if slope > 0:
                continue
            if end - start < _FLAT or slope < 0:
                return False
            middle = 0.5 * (start + end)
            waiting += [(start, middle), (middle, end)]
        return True

    def orbit_turns(self, iterates: int) -> Iterator[tuple[Fraction, Fraction]]:
        """The whole turns below and above Fⁿ(0), by n, as long as they can be told."""
        theta = self.arb(0)
        for n in range(1, iterates + 1):
            theta = self._iterate(theta, 1).value
            turns = theta / (2 * self.arb.pi())
            if not turns.rad() < 1:
                return
            lower = turns.lower().floor()
            upper = turns.upper().ceil()
            yield Fraction(_whole(lower), n), Fraction(_whole(upper), n)

    def all_turns(self) -> Iterator[tuple[Fraction, Fraction]]:
        """The whole turns below and above Fⁿ - id all round, by n, where it touches none, up to
        the first n that is too steep.
        """
        for n in range(1, _LONGEST_FOLDED + 1):
            iterated = replace(self, period=n)
            try:
                cut, turns = iterated._cut()
                cells = iterated._cells(cut, _MOST_FOLDED)
            except ConvergenceError:
                continue
            if not cells or cells[-1].end < cut + TWO_PI:
                return
            # Runs of monotone cells lie between the levels of the cells beside them.
            levels = [turns, *(cell.turns for cell in cells if not cell.sign)]
            yield Fraction(min(levels), n), Fraction(max(levels) + 1, n)

    def holds(self, lock: LockingProof) -> bool:
        """Whether F^q - id is below p turns and above them for certain at the two angles."""
        iterated = replace(self, period=lock.ratio.denominator)
        below, above = (
            iterated._displacement(self.arb(theta)).value for theta in (lock.below, lock.above)
        )
        return bool(below < lock.ratio.numerator < above)

    def _iterate(self, theta: Ball, times: int) -> Jet:
        """The iterate and its slope on a ball, which grows by no more than the slopes there: each
        image is also known by the mean value theorem.
        """
        jet = Jet(theta, self.arb(1))
        for _ in range(times):
            step = self.lift(Jet(jet.value, self.arb(1)))
            image = step.value
            middle = jet.value.mid()
            spread = step.slope * (jet.value - middle)
            if jet.value.rad() > _POINT and spread.rad() < image.rad():
                image = self.lift(Jet(middle, self.arb(1))).value + spread
            jet = Jet(image, step.slope * jet.slope)
        return jet

    def _displacement(self, theta: Ball) -> Jet:
        """Fⁿ - id and its slope, in turns and turns a radian."""
        jet = self._iterate(theta, self.period)
        return Jet((jet.value - theta) / (2 * self.arb.pi()), (jet.slope - 1) / (2 * self.arb.pi()))

    def _judged(self, start: float, end: float) -> _Cell | None:
        """What is proved on [start, end], by the mean value theorem; None where nothing is."""
        middle = self.arb(0.5 * (start + end))
        cell = self.arb(start).union(self.arb(end))
        slope = self._displacement(cell).slope
        value = self._displacement(middle).value + slope * (cell - middle)
        if not value.contains_integer():
            return _Cell(start, end, 0, _whole(value.floor()))
        if not slope.contains(0):
            return _Cell(start, end, 1 if slope > 0 else -1, 0)
        return None

    def _cut(self) -> tuple[float, int]:
        """An angle beside which there is no point, and the whole turns below Fⁿ - id there."""
        for cut in _CUTS:
            cell = self._judged(cut - _SEAM, cut + _SEAM)
            if cell is not None and cell.sign == 0:
                return cut, cell.turns
        raise ConvergenceError(
            f"no proof: Fⁿ - id cannot be told from a multiple of 2π at any of {len(_CUTS)} "
            "angles: a whole arc may be fixed, or the errors of the map leave nothing to prove"
        )

    def _cells(self, cut: float, steps: int) -> list[_Cell]:
        """The decided cells of the turn from ``cut``, in order; the last ends a little beyond it,
        or earlier where they need more than so many ``steps``: cells times their iterates.
        """
        edges = np.linspace(cut, cut + TWO_PI + 0.5 * _SEAM, _START_CELLS + 1).tolist()
        waiting = list(pairwise(edges))[::-1]
        decided: list[_Cell] = []
        for _ in range(steps // self.period):
            if not waiting:
                break
            start, end = waiting.pop()
            cell = self._judged(start, end)
            if cell is not None:
                decided.append(cell)
                continue
            if end - start < _NARROWEST:
                raise ConvergenceError(
                    f"no proof: at θ = {start % TWO_PI:.9g} F^{self.period} - id meets a multiple "
                    "of 2π and its slope vanishes, or both so nearly that they cannot be told "
                    "apart: a tangency (saddle-node) is no matter of intervals; prove on either "
                    "side of it"
                )
            middle = 0.5 * (start + end)
            waiting += [(middle, end), (start, middle)]
        return decided

    def _enclosed(self, run: _Cell, level: int, lap: int) -> tuple[Estimate, int, Estimate, Ball]:
        """The one crossing of ``level`` in a monotone run: angle, winding, multiplier, and the ball
        that holds it.
        """

        def residual(place: float) -> float:
            return float((self._displacement(self.arb(place)).value - level).mid())

        theta = self.arb(root_between(residual, run.start, run.end))
        for _ in range(_NEWTON_STEPS):
            jet = self._displacement(theta)
            theta = (theta - (jet.value.mid() - level) / jet.slope.mid()).mid()
        # Widened until the two sides are proved to differ; the ends of the run are known to.
        half = self.arb(2) ** (-_BITS // 2)
        while True:
            left = (theta - half).mid()
            right = (theta + half).mid()
            below = left <= run.start or run.sign * (self._displacement(left).value - level) < 0
            above = right >= run.end or run.sign * (self._displacement(right).value - level) > 0
            if below and above:
                break
            half = 4 * half
        ball = max(left, self.arb(run.start)).union(min(right, self.arb(run.end)))
        multiplier = self._iterate(ball, self.period).slope
        turns = int(np.floor(float(ball.mid()) / TWO_PI))
        base = ball - 2 * self.arb.pi() * turns
        if base < 0 or not base < 2 * self.arb.pi():
            turns += -1 if base < 0 else 1
            base = ball - 2 * self.arb.pi() * turns
        angle = min(max(float(base.mid()), 0.0), np.nextafter(TWO_PI, 0.0))
        return self._estimate(base, angle), level - turns * lap, self._estimate(multiplier), ball

    def _estimate(self, ball: Ball, value: float | None = None) -> Estimate:
        nearest = float(ball.mid()) if value is None else value
        return Estimate(nearest, np.nextafter(float(abs(ball - nearest).upper()), np.inf))

    def _image(self, ball: Ball, angles: Array, bounds: Array) -> int:
        """The only point whose enclosure meets the image of this one, which is itself one of the
        points.
        """
        image = self._iterate(ball, 1).value
        centre = float(image.mid())
        radius = float(image.rad()) + 1e-14 * (1.0 + abs(float(image.mid())))
        gaps = shorter_way(angles - centre)
        near = np.flatnonzero(np.abs(gaps) <= radius + bounds)
        if near.size != 1:
            raise ConvergenceError(
                f"no proof: {near.size} of the {angles.size} points may be the image of one: they "
                "lie too close together for what is known of the map"
            )
        return int(near[0])


def _whole(ball: Ball) -> int:
    return int(ball.unique_fmpz())
