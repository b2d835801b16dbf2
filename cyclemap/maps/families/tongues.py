"""Arnold tongues: for which parameters of a family an orbit of rotation number p/q exists."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import pairwise, product
from math import gcd

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, even_angles
from cyclemap.checks import finite_array, read_only, require_room, unwritable, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, LIFT, Estimate
from cyclemap.maps.families.family import (
    Family,
    Range,
    each_done,
    family_member,
    parameter_range,
    parameter_tangent,
)
from cyclemap.maps.lifts.branches import limit_at_break
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one
from cyclemap.maps.lifts.lift_checks import distance_to_break
from cyclemap.maps.lifts.scan import monotone_cells, root_between
from cyclemap.maps.orbits.diagonal import displacement
from cyclemap.maps.orbits.rotation_number import lower_envelope, upper_envelope
from cyclemap.progress import Progress

_PROBES = np.linspace(0.01, TWO_PI + 0.01, 48, endpoint=False)
_FIRST_LOOK = 256  # cells a turn with which the search for what was missed begins
_CELLS = 4_096  # once so many are left, those in which F^q is smooth need no cutting any more
_MOST_CELLS = 65_536
_AT_BREAK = 1e-6  # radians: an extremum is known to about the root of rounding
RESOLUTION = 128
_LONGEST = 1_000  # cycles of an edge's orbit
_MOST_STEPS = 3_000_000  # cells of F^q times its cycles, for one parameter of fifty: a minute
_SEARCHES = 4  # times that an edge is sought, a hump that was missed before among the marks
_QUARTERS = np.linspace(0.0, 1.0, 5)
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_QUARTIC = np.linalg.solve(np.vander(_QUARTERS).T, np.vander(np.linspace(0.0, 1.0, 33), 5).T)


# the largest (or least) value of F^q - id - 2πp, radians, and where it is taken
Extremum = tuple[float, float]


def extreme_displacement(
    circle_map: CircleMap, ratio: Fraction, sign: float, marks: Sequence[float] = ()
) -> Extremum:
    """The largest (``sign`` 1) or least (-1) value of F^q - id - 2πp over the circle, and where.

    Taken from the ends of the scanner's cells, ``marks`` among them, and from both sides of the
    map's own breaks: these alone when the sign there is the wanted one already. Of a nondecreasing
    map this gives the right sign even where the extremum lies at a break of the iterate: the sign
    is the same all along an orbit.
    """
    breaks = circle_map.breaks
    highest = -np.inf
    at = 0.0
    if breaks.size:
        image = np.stack([limit_at_break(circle_map, breaks, side) for side in (-1, 1)])
        lap = np.rint(image / TWO_PI)
        image -= TWO_PI * lap
        rest, _, _ = displacement(
            circle_map, image, ratio.denominator - 1, ratio.numerator - lap.astype(np.int64)
        )
        values = sign * (rest + (image - breaks))
        best = int(np.argmax(values))
        highest = float(values.flat[best])
        at = float(breaks[best % breaks.size])
    if highest < 0.0:
        cells = monotone_cells(circle_map, ratio.denominator, 1.0, RESOLUTION, marks)
        if ratio.denominator * cells.start.size > _MOST_STEPS:
            raise ConvergenceError(
                f"the tongue {ratio} needs {cells.start.size:,} cells of F^{ratio.denominator}, "
                f"above {_MOST_STEPS // ratio.denominator:,}: give a ratio with a smaller period"
            )
        theta = cells.start[~cells.cut]
        values = np.append(highest, _height(circle_map, theta, ratio, sign))
        best = int(np.argmax(values))
        highest = float(values[best])
        at = float(np.append(at, theta)[best])
    return sign * highest, at


def _height(circle_map: CircleMap, theta: Array, ratio: Fraction, sign: float) -> Array:
    """``sign``·(F^q - id - 2πp) at ``theta``."""
    return sign * displacement(circle_map, theta, ratio.denominator, np.array(ratio.numerator))[0]


def unseen_height(circle_map: CircleMap, ratio: Fraction, sign: float) -> Extremum:
    """How far above 0 a value of ``sign``·(F^q - id - 2πp) may lie, F nondecreasing, and where; 0
    where none can.

    Between its values at a < b a nondecreasing F^q stays, so that F^q - id exceeds its value at b
    by b - a at most: cells which that leaves room above 0 are cut, whatever the slopes and breaks
    there. Once ``_CELLS`` of them are left, those whose five values a quartic meets to rounding
    count with its largest value: measured, not proved.
    """
    start = even_angles(_FIRST_LOOK)
    width = TWO_PI / _FIRST_LOOK
    unseen = (0.0, 0.0)
    smooth_ones_count = False
    while start.size:
        theta = start[:, None] + width * _QUARTERS
        gap, _, rounding = displacement(
            circle_map, theta, ratio.denominator, np.asarray(ratio.numerator)
        )
        gap = sign * gap
        noise = 2.0 * np.max(rounding, axis=1)
        room = np.max(gap[:, 1:] if sign > 0.0 else gap[:, :-1], axis=1) + 0.25 * width
        left = room > noise
        smooth_ones_count = smooth_ones_count or bool(np.count_nonzero(left) >= _CELLS)
        smooth = left & smooth_ones_count & (np.abs(gap @ _FOURTH_DIFFERENCE) <= 8.0 * noise)
        height = np.where(smooth, np.max(gap @ _QUARTIC, axis=1), room) - noise
        left &= ~smooth
        if 4 * np.count_nonzero(left) > _MOST_CELLS or width < 1e-15:
            smooth = smooth | left
            left = np.zeros_like(left)
        highest = int(np.argmax(np.where(smooth, height, 0.0)))
        if smooth[highest] and height[highest] > unseen[0]:
            unseen = float(height[highest]), float(theta[highest, int(np.argmax(gap[highest]))])
        start = (start[left, None] + width * _QUARTERS[:-1]).ravel()
        width = 0.25 * width
    return unseen


@dataclass(frozen=True, eq=False)
class _Trial:
    """A parameter tried: its map, that map's monotone envelope, the extremum, and the lift at fixed
    angles.
    """

    member: CircleMap
    monotone: CircleMap
    extremum: Extremum
    lift: Array


@dataclass(eq=False)
class EdgeSearch:
    """The search for one edge; remembers every parameter tried, to notice a family that goes back.

    The extremum M(p) of F^q - id - 2πp does not fall as p grows when the family does not: the left
    edge is where the largest value leaves the negative numbers, the right edge where the least
    leaves the others.
    """

    family: Family
    ratio: Fraction
    side: str
    within: Range
    marks: list[float] = field(default_factory=list)
    tried: dict[float, _Trial] = field(default_factory=dict)

    @property
    def _sign(self) -> float:
        return 1.0 if self.side == "left" else -1.0

    def trial(self, p: float) -> _Trial:
        """What is known at a parameter; InvalidInput where the family falls beside it."""
        if p in self.tried:
            return self.tried[p]
        member = family_member(self.family, p)
        require_degree_one(member, "a tongue")
        monotone = upper_envelope(member) if self.side == "left" else lower_envelope(member)
        extremum = extreme_displacement(monotone, self.ratio, self._sign, self.marks)
        self.tried[p] = _Trial(member, monotone, extremum, member(_PROBES))
        order = sorted(self.tried)
        for low, high in pairwise(order[max(order.index(p) - 1, 0) : order.index(p) + 2]):
            first = self.tried[low]
            second = self.tried[high]
            fall = float(np.max(first.lift - second.lift))
            if fall > 1e-12 + first.member.max_error + second.member.max_error:
                raise InvalidInput(
                    f"the family falls with its parameter: F drops by {fall:.3g} radians from "
                    f"{low:.9g} to {high:.9g}; tongue edges need a family that nowhere "
                    "decreases (try the negative parameter)"
                )
        return self.tried[p]

    def value(self, p: float) -> float:
        """M(p), of the monotone envelope where F folds, over what moving every lift by one radian
        would add to it.

        So scaled, M has the same slope on both sides of zero, whichever point of the orbit is
        extreme there.
        """
        trial = self.trial(p)
        return trial.extremum[0] / self._gained(trial, np.ones_like)

    def edge(self) -> tuple[Estimate, Array, str, bool]:
        """The edge, its orbit, why it is one, whether the map folds there."""
        for _ in range(_SEARCHES):
            below, above = self._bracketed()
            parameter, beyond = (above, below) if self.side == "left" else (below, above)
            trial = self.tried[parameter]
            outside = self.tried[beyond].monotone
            unseen, where = unseen_height(outside, self.ratio, self._sign)
            missed = _height(outside, np.array(where), self.ratio, self._sign)
            if unseen == 0.0 or missed <= 0.0:
                break
            self.marks.append(where)
            self.tried.clear()
        error = above - below + self._off(trial, parameter, unseen) + 2.0 * EPS * abs(parameter)
        points = self._orbit(trial)
        meets = float(np.min(distance_to_break(trial.member.breaks, points))) < _AT_BREAK
        kind = "border-collision" if meets else "saddle-node"
        return Estimate(parameter, error), points, kind, trial.monotone is not trial.member

    def _bracketed(self) -> tuple[float, float]:
        """Neighbouring floats, M below 0 at the lower one, and not at the upper one."""
        low, high = self.within
        for end, beyond, where in (
            (low, self.value(low) >= 0.0, "below"),
            (high, self.value(high) < 0.0, "above"),
        ):
            if beyond:
                raise InvalidInput(
                    f"the {self.side} edge of the tongue {self.ratio} lies {where} {end:.9g}, "
                    f"outside the parameters ({low:.9g}, {high:.9g}): widen them"
                )
        # The last two guesses lie on the two sides of the edge: a zero counts as beyond it.
        root_between(lambda p: self.value(p) or 1e-300, low, high)
        return (
            max(p for p in self.tried if self.value(p) < 0.0),
            min(p for p in self.tried if self.value(p) >= 0.0),
        )

    def _off(self, trial: _Trial, parameter: float, unseen: float) -> float:
        """How far the lift's rounding and what is unseen can move the edge, to first order along
        its orbit.
        """
        tangent = parameter_tangent(self.family, parameter, 1e-6, self.within)
        disturbed = self._gained(trial, np.ones_like)
        moved = self._gained(trial, tangent)
        if moved <= 0.0:
            raise ConvergenceError(
                f"the orbits of rotation {self.ratio} do not move with the parameter at "
                f"{parameter:.9g}"
            )
        angle = 2.0 * TWO_PI + float(np.max(np.abs(trial.lift - _PROBES)))
        return (LIFT * angle * disturbed + unseen) / moved

    def _orbit(self, trial: _Trial) -> Array:
        """The orbit at which the extremum is taken, by the limits of the side it is taken from."""
        lift = trial.monotone.right if self._sign > 0.0 else trial.monotone.left
        points = np.full(self.ratio.denominator, trial.extremum[1] % TWO_PI)
        for index in range(1, points.size):
            points[index] = np.mod(lift(points[index - 1]), TWO_PI)
        return points

    def _gained(self, trial: _Trial, push: Callable[[Array], Array]) -> float:
        """How far the extremal orbit ends from where it did when every lift moves by ``push``, to
        first order.
        """
        points = self._orbit(trial)
        gained = 0.0
        for moved, slope in zip(push(points), trial.monotone.derivative(points), strict=True):
            gained = float(moved + slope * gained)
        return gained


@dataclass(frozen=True)
class Tongue:
    """The tongue p/q of a one-parameter family: the parameters at which an orbit of rotation number
    p/q exists.

    Attributes
    ----------
    ratio : Fraction
        p/q, turns a cycle.
    left, right : Estimate
        Its edges, in the parameter's unit.
    left_orbit, right_orbit : ndarray, shape (q,)
        Radians in [0, 2π), the orbit that is born at each edge, in order of visit.
    left_kind, right_kind : str
        Why the tongue ends there: "saddle-node" (two orbits meet, multiplier 1) or
        "border-collision" (the orbit meets a kink or a jump of the map). Where the map folds it
        is one of the two as well: no orbit of an edge visits a plateau of the monotone
        envelope, on which F^q - id falls.
    folded : bool
        Whether the map folds at an edge. If not, the rotation number is p/q all through the
        tongue and nowhere else (locking); if it does, p/q is one of an interval of rotation
        numbers, and tongues overlap.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, tongue
    >>> locked = tongue(lambda omega: CircleMap.arnold(omega, 0.9), (0, 1), (-0.5, 0.5))
    >>> locked.ratio, locked.left_kind, locked.width.holds(0.9 / np.pi)
    (Fraction(0, 1), 'saddle-node', True)
    """

    ratio: Fraction
    left: Estimate
    right: Estimate
    left_orbit: Array
    right_orbit: Array
    left_kind: str
    right_kind: str
    folded: bool

    @property
    def width(self) -> Estimate:
        """right - left, zero where they agree within rounding; its bound is the sum of theirs."""
        return Estimate(
            max(self.right - self.left, 0.0), self.left.error_bound + self.right.error_bound
        )


@dataclass(frozen=True, eq=False)
class TongueBoundaries:
    """The edges of several tongues as curves over a second parameter.

    Attributes
    ----------
    ratios : tuple of Fraction
        The p/q, k of them.
    second : ndarray, shape (m,)
        The second parameter's values.
    left, right : ndarray, shape (k, m)
        The edges in the first parameter.
    left_error, right_error : ndarray, shape (k, m)
        Bounds on their errors.
    folded : ndarray of bool, shape (k, m)
        Whether the map folds at an edge there (see ``Tongue``).

    Examples
    --------
    >>> from cyclemap import CircleMap, tongues
    >>> edges = tongues(CircleMap.arnold, [0], [0.4, 0.8], (-0.5, 0.5))
    >>> edges.right.round(6).tolist(), bool(edges.folded.any())
    ([[0.063662, 0.127324]], False)
    """

    ratios: tuple[Fraction, ...]
    second: Array
    left: Array
    right: Array
    left_error: Array
    right_error: Array
    folded: Mask


Ratio = Fraction | int | Sequence[int]


def tongue(family: Family, ratio: Ratio, parameters: Range) -> Tongue:
    """The edges of the tongue p/q of a family whose lifts nowhere fall as the parameter grows.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap of degree 1.
    ratio : Fraction, int or tuple[int, int]
        p/q, turns a cycle, q at most 1,000; as a pair in lowest terms.
    parameters : tuple[float, float]
        (low, high), with the whole tongue inside; the family is called only there.

    Returns
    -------
    Tongue
        Its edges, with bounds, and the orbits born there.

    Raises
    ------
    InvalidInput
        When an edge lies outside the range or the family is seen to fall.
    ConvergenceError
        When F^q needs more than 3,000,000/q cells (the sine family with K = 1: q above some 500),
        or its orbits do not move with the parameter.

    Notes
    -----
    Left edge: where the largest value of F^q - id - 2πp over the circle reaches 0; right edge:
    where the least does (Arnold 1965; Herman 1977): a saddle-node of period q, at a kink or
    jump a border collision. Where F folds, the same of its monotone envelopes: the left edge of
    F⁺ and the right edge of F⁻ bound the parameters whose rotation interval holds p/q (Boyland
    1986). Both extrema are monotone in the parameter, so each edge is bracketed to neighbouring
    floats. A tongue narrower than rounding has width 0 and the bound says how narrow.

    The error bounds add the bracket, the lift's rounding (to first order along the edge's
    orbit), some 2e-15 for ``arnold``, and what the search for extrema may have missed just
    outside the edge: since F^q does not fall, no value between two samples exceeds the second
    by more than their distance, and samples are added until that rules every other hump out
    (proved). Where 4096 samples cannot, F^q counts as smooth where a quartic meets five
    neighbours to rounding: humps narrower, at half their height, than a tenth of a milliradian,
    and no higher, may hide there. ``max_error`` is not added.

    References
    ----------
    - Arnold, V. I. (1965), Small denominators I, AMS Translations 46.
    - Herman, M. R. (1977), Mesure de Lebesgue et nombre de rotation, Lecture Notes in Mathematics
      597.
    - Boyland, P. L. (1986), Bifurcations of circle maps: Arnol'd tongues, bistability and rotation
      intervals, Communications in Mathematical Physics 106.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, tongue
    >>> locked = tongue(lambda omega: CircleMap.arnold(omega, 0.9), (0, 1), (-0.5, 0.5))
    >>> locked.right.holds(0.9 / (2 * np.pi)), locked.right.error_bound < 1e-14
    (True, True)
    """
    wanted = rotation_ratio(ratio)
    within = parameter_range("parameters", parameters)
    (left, left_orbit, left_kind, left_folds), (right, right_orbit, right_kind, right_folds) = (
        EdgeSearch(family, wanted, side, within).edge() for side in ("left", "right")
    )
    orbits = read_only(left_orbit), read_only(right_orbit)
    return Tongue(wanted, left, right, *orbits, left_kind, right_kind, left_folds or right_folds)


def rotation_ratio(ratio: Ratio) -> Fraction:
    """p/q as a Fraction, from a Fraction, a whole number or a pair (p, q) in lowest terms,
    1 ≤ q ≤ 1,000."""
    if isinstance(ratio, Fraction):
        require_room("the period", ratio.denominator, "give a smaller one", _LONGEST)
        return ratio
    if isinstance(ratio, (int, np.integer)):
        return Fraction(whole_number("ratio", ratio))
    if not isinstance(ratio, Sequence) or isinstance(ratio, str) or len(ratio) != 2:
        raise InvalidInput(f"ratio is {ratio!r}: give a Fraction, a whole number or a pair (p, q)")
    p = whole_number("p", ratio[0])
    q = whole_number("q", ratio[1])
    if q < 1 or gcd(p, q) != 1:
        raise InvalidInput(f"ratio is {p}/{q}: give p/q in lowest terms with q of at least 1")
    return rotation_ratio(Fraction(p, q))


def tongues(
    family: Family,
    ratios: Sequence[Ratio],
    second: ArrayLike,
    parameters: Range,
    *,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> TongueBoundaries:
    """The edges of several tongues of a family over a second parameter.

    Parameters
    ----------
    family : callable
        (p, q) → CircleMap of degree 1, nowhere falling in its first parameter.
    ratios : sequence of Fraction, int or tuple[int, int]
        Turns a cycle, as of ``tongue``.
    second : array_like, shape (m,)
        Values of the second parameter.
    parameters : tuple[float, float]
        (low, high) of the first parameter, with every edge inside.
    progress : callable or None, optional
        Called with the fraction done.
    executor : Executor or None, optional
        As of ``rotation_plane``; tongue by tongue.

    Returns
    -------
    TongueBoundaries
        The edges, with bounds.

    Raises
    ------
    InvalidInput
        As ``tongue``.

    Notes
    -----
    Accuracy and bounds are as in ``tongue``.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, tongues
    >>> edges = tongues(CircleMap.arnold, [0, (1, 2)], [0.4, 0.8], (-0.5, 1.0))
    >>> exact = np.array([0.4, 0.8]) / (2 * np.pi)
    >>> bool(np.all(np.abs(edges.right[0] - exact) <= edges.right_error[0]))
    True
    """
    if not callable(family):
        raise InvalidInput(f"family is {family!r}: give a callable of two parameters")
    try:
        given = tuple(ratios)
    except TypeError as cause:
        raise InvalidInput(
            f"ratios is {ratios!r}: give a sequence of them, such as [0, (1, 2)]"
        ) from cause
    wanted = tuple(rotation_ratio(ratio) for ratio in given)
    values = finite_array("second", second, ndim=1)
    within = parameter_range("parameters", parameters)
    if not wanted or values.size == 0:
        raise InvalidInput(
            f"{len(wanted)} ratios and {values.size} values of the second parameter: give some "
            "of each"
        )
    places = list(product(wanted, values.tolist()))
    locked = each_done(partial(_tongue_at, family, within), places, executor, progress)
    rows = [
        (at.left, at.right, at.left.error_bound, at.right.error_bound, at.folded) for at in locked
    ]
    table = read_only(np.transpose(rows).reshape(5, len(wanted), values.size))
    left, right, left_error, right_error, folded = table
    return TongueBoundaries(
        wanted, read_only(values), left, right, left_error, right_error, unwritable(folded > 0.0)
    )


def _tongue_at(family: Family, within: Range, place: tuple[Fraction, float]) -> Tongue:
    ratio, value = place
    return tongue(lambda first: family(first, value), ratio, within)
