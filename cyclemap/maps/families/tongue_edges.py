"""The edges of a tongue: where the largest or the least value of F^q - id - 2πp over the circle is zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.families.parameter_tangent import Family, family_member, limit_at_break, parameter_tangent
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.rotation.envelopes import lower_envelope, upper_envelope

_EPS = float(np.finfo(float).eps)
_ROUNDING = 2.0 * _EPS  # of a lift's value, relative to the largest angles it handles
_PROBES = np.linspace(0.01, TWO_PI + 0.01, 48, endpoint=False)
_WINDOWS, _POINTS = 4, 33  # maxima refined together, and the points across each
_ZOOMS = 7  # each by 16: enough for a smooth hump; a corner or jump is decided at the map's break it comes from
_FAR = 3.0  # radians
_OFFSETS = np.linspace(-1.0, 1.0, _POINTS)


def displacement(circle_map: CircleMap, theta: Array, ratio: Fraction) -> Array:
    """F^q(θ) - θ - 2πp for ``ratio`` = p/q, radians, any shape.

    The iterate is kept within half a turn of 0 and its turns are counted apart, so that rounding does not
    grow with the angle.

    >>> import numpy as np
    >>> bool(abs(displacement(CircleMap.rigid(0.4), np.array(1.0), Fraction(2, 5))) < 1e-15)
    True
    """
    return _displacement(circle_map, theta, ratio, circle_map(theta))


def _displacement(circle_map: CircleMap, theta: Array, ratio: Fraction, image: Array) -> Array:
    """The same from the first images F(θ), which may be one-sided limits."""
    turns = np.full(np.shape(theta), -float(ratio.numerator))
    for remaining in range(ratio.denominator - 1, -1, -1):
        lap = np.rint(image / TWO_PI)
        image, turns = image - TWO_PI * lap, turns + lap
        if remaining:
            image = circle_map(image)
    return np.asarray((image - theta) + TWO_PI * turns)


@dataclass(frozen=True)
class Extremum:
    """The largest (or least) value of F^q - id - 2πp, radians, and where it is taken."""

    value: float
    theta: float


def extreme_displacement(circle_map: CircleMap, ratio: Fraction, resolution: int, sign: float) -> Extremum:
    """The largest (``sign`` 1) or least (-1) value of F^q - id - 2πp over the circle.

    Taken from ``resolution + 8q`` angles, the greatest humps between them refined (to 1e-3 of the value, to
    rounding where that is near 0), and from both sides of the map's own breaks: these alone when the sign
    there is the wanted one already. Of a nondecreasing map this gives the right sign even where the extremum
    lies at a break of the iterate: the sign is the same all along an orbit.
    """
    at_breaks = _beside_breaks(circle_map, ratio, sign)
    if at_breaks.value >= 0.0:
        return Extremum(sign * at_breaks.value, at_breaks.theta)
    count = resolution + 8 * ratio.denominator
    grid = np.linspace(-np.pi, np.pi, count, endpoint=False)
    values = sign * displacement(circle_map, grid, ratio)
    peaks = np.flatnonzero((values >= np.roll(values, 1)) & (values >= np.roll(values, -1)))
    best = peaks[np.argsort(values[peaks])[-_WINDOWS:]]
    found = _refined(circle_map, ratio, sign, grid[best], TWO_PI / count)
    found = max(found, at_breaks, key=lambda extremum: extremum.value)
    return Extremum(sign * found.value, found.theta)


def _refined(circle_map: CircleMap, ratio: Fraction, sign: float, centres: Array, reach: float) -> Extremum:
    """Zoom into every window, until the parabola through the top adds less than 1e-3 of the value or rounding."""
    rows = np.arange(centres.size)
    for _ in range(_ZOOMS):
        theta = centres[:, None] + reach * _OFFSETS
        values = sign * displacement(circle_map, theta, ratio)
        top = np.clip(np.argmax(values, axis=1), 1, _POINTS - 2)
        shift, gain = _vertex(*(values[rows, top + k] for k in (-1, 0, 1)))
        reach *= 2.0 / (_POINTS - 1)
        centres = theta[rows, top] + reach * shift
        best = int(np.argmax(values[rows, top] + gain))
        highest = float(np.max(values))
        if gain[best] <= max(4.0 * _EPS, 1e-3 * abs(highest)):
            break
    return Extremum(highest, float(centres[best]))


def _vertex(before: Array, here: Array, after: Array) -> tuple[Array, Array]:
    """Where, in steps from the middle, the parabola through three values is highest, and how much higher."""
    bend = 2.0 * here - before - after
    lift = after - before
    shift = np.where(bend > 0.0, lift / (2.0 * np.where(bend > 0.0, bend, 1.0)), 0.0)
    shift = np.clip(shift, -1.0, 1.0)
    return shift, np.maximum(0.5 * shift * (lift - bend * shift), 0.0)


def _beside_breaks(circle_map: CircleMap, ratio: Fraction, sign: float) -> Extremum:
    if circle_map.breaks.size == 0:
        return Extremum(-np.inf, 0.0)
    images = (limit_at_break(circle_map, circle_map.breaks, side) for side in (-1, 1))
    values = np.concatenate([sign * _displacement(circle_map, circle_map.breaks, ratio, image) for image in images])
    best = int(np.argmax(values))
    return Extremum(float(values[best]), float(np.tile(circle_map.breaks, 2)[best]))


# -- the edge ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Edge:
    """An edge of a tongue: the parameter, a bound on its error, the angle of its orbit, whether the map folds."""

    parameter: float
    error: float
    theta: float
    folded: bool


@dataclass(frozen=True, eq=False)
class _Trial:
    """A parameter tried: its map, that map's monotone envelope, the extremum, and the lift at fixed angles."""

    member: CircleMap
    monotone: CircleMap
    found: Extremum
    lift: Array


@dataclass(eq=False)
class EdgeSearch:
    """The search for one edge; remembers every parameter tried, to notice a family that goes back.

    The extremum M(p) of F^q - id - 2πp does not fall as p grows when the family does not: the left edge is
    where the largest value leaves the negative numbers, the right edge where the least leaves the others.
    """

    family: Family
    ratio: Fraction
    side: str
    resolution: int
    tried: dict[float, _Trial] = field(default_factory=dict)

    def value(self, p: float) -> float:
        """M(p), of the monotone envelope where F folds, over what moving every lift by one radian would add to it.

        So scaled, M has the same slope on both sides of zero, whichever point of the orbit is extreme there;
        far from zero the plain M/q is straighter.
        """
        if p not in self.tried:
            self.tried[p] = self._trial(p)
            self._check_monotone(p)
        trial = self.tried[p]
        far = abs(trial.found.value) > _FAR
        return trial.found.value / (self.ratio.denominator if far else self._gained(trial, np.ones_like))

    def _trial(self, p: float) -> _Trial:
        member = family_member(self.family, p)
        if member.degree != 1:
            raise InvalidInput(f"the map at {p:.9g} has degree {member.degree}: a tongue needs degree 1")
        monotone = upper_envelope(member) if self.side == "left" else lower_envelope(member)
        sign = 1.0 if self.side == "left" else -1.0
        found = extreme_displacement(monotone, self.ratio, self.resolution, sign)
        return _Trial(member, monotone, found, np.asarray(member(_PROBES)))

    def _check_monotone(self, p: float) -> None:
        order = sorted(self.tried)
        around = order[max(order.index(p) - 1, 0) : order.index(p) + 2]
        for low, high in pairwise(around):
            first, second = self.tried[low], self.tried[high]
            fall = float(np.max(first.lift - second.lift))
            if fall > 1e-12 + first.member.max_error + second.member.max_error:
                raise InvalidInput(
                    f"the family falls with its parameter: F drops by {fall:.3g} radians from {low:.9g} to "
                    f"{high:.9g}; tongue edges need a family that nowhere decreases (try the negative parameter)"
                )

    def edge(self, low: float, high: float) -> Edge:
        """The edge inside [low, high]; the ends must lie on its two sides."""
        below, above = bracketed_zero(self.value, low, high)
        parameter = above if self.side == "left" else below
        trial = self.tried[parameter]
        error = above - below + self._rounding(parameter, trial, (low, high))
        return Edge(parameter, error, trial.found.theta % TWO_PI, trial.monotone is not trial.member)

    def _rounding(self, p: float, trial: _Trial, within: tuple[float, float]) -> float:
        """How far the lift's rounding can move the edge, to first order along the orbit of the edge."""
        tangent = parameter_tangent(self.family, p, step=1e-6 * (within[1] - within[0]), within=within, order=2)
        disturbed, moved = self._gained(trial, np.ones_like), self._gained(trial, tangent)
        if moved <= 0.0:
            raise ConvergenceError(f"the orbits of rotation {self.ratio} do not move with the parameter at {p:.9g}")
        angle = 2.0 * TWO_PI + float(np.max(np.abs(trial.lift - _PROBES)))
        return _ROUNDING * angle * disturbed / moved + 2.0 * _EPS * abs(p)

    def _gained(self, trial: _Trial, push: Callable[[Array], Array]) -> float:
        """How far the extremal orbit ends from where it did when every lift moves by ``push``, to first order."""
        image, gained = np.array(trial.found.theta), 0.0
        for _ in range(self.ratio.denominator):
            gained = float(push(image)) + float(trial.monotone.derivative(image)) * gained
            image = trial.monotone(image)
            image = image - TWO_PI * np.rint(image / TWO_PI)
        return gained


def bracketed_zero(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Parameters a < b a few roundings apart with value(a) < 0 <= value(b): the Illinois method, safeguarded.

    Dowell & Jarratt (1971); a step that does not shrink the bracket to a quarter in three is a bisection.
    """
    at_low, at_high = value(low), value(high)
    tolerance, widths, last = 2.0 * _EPS * max(abs(low), abs(high)), [high - low], 0.0
    while high - low > 2.0 * tolerance:
        guess = low + (high - low) * (-at_low / (at_high - at_low))
        if len(widths) > 3 and widths[-1] > 0.25 * widths[-4]:
            guess, widths = 0.5 * (low + high), []
        guess = min(max(guess, low + tolerance), high - tolerance)
        found = value(guess)
        if found < 0.0:
            low, at_low, at_high = guess, found, at_high * (0.5 if last < 0.0 else 1.0)
        else:
            high, at_high, at_low = guess, found, at_low * (0.5 if last > 0.0 else 1.0)
        last = -1.0 if found < 0.0 else 1.0
        widths.append(high - low)
    return low, high
