"""Samples a circle map with its slope until polynomials reproduce it, and finds its kinks and
jumps.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import positive_number
from cyclemap.maps import CircleMap
from cyclemap.progress import Progress, unheard

Sample = Callable[[Array], tuple[Array, Array]]

_FIRST_INTERVALS = 24
# Halving an interval divides the error of a cubic by 16 where the map is smooth. None of that is
# counted on when a half is accepted, since a single sample may flatter; an error that does not fall
# by this much is suspect.
_HALVING = 4.0
# An interval this short (rad) whose error does not fall as it should may hold a kink or a jump.
_SUSPECT = 0.04
# A jump is located this closely (rad); no interval is cut shorter.
_NARROWEST = 1e-10
# A kink is located so closely that this share of the tolerance is left.
_LOCATED = 0.01
# Where higher polynomials hold, cubics are put through so many of their values that this share of
# the tolerance is lost.
_FILLED = 0.1
# What a polynomial through four of five nodes misses at the fifth counts as this much of the error
# of that through all: the middle one, and those beside it. Of 4,000 stretches of the built-in
# materials' maps 40 were further off than that.
_MIDDLE = 1.0
_BESIDE = 0.3
# A sample belongs to one side of a break if it lies this near to that side's tangent, as a share of
# the gap.
_SIDE_SHARE = 0.2
# Intervals that are tried at one more place at the end, the least certain first; where in them, as
# a share, by the number of their inner nodes: where polynomials through these are off by nearly the
# most.
_CHECKED = 12
_OFF_NODES = {0: 0.3, 1: 0.3, 3: 0.1}
# Times that intervals are tried so, while some fail.
_ROUNDS = 3
# Cubics are compared at these shares of their width; they are put this much closer than what is
# seen there asks for.
_COMPARED = (0.25, 0.5, 0.75)
_CLOSER = 1.15


@dataclass(frozen=True)
class Node:
    """A sample of a function: place, value, slope."""

    theta: float
    value: float
    slope: float


@dataclass(frozen=True)
class HermitePolynomial:
    """The polynomial of degree 2 k - 1 with the values and slopes of k nodes, by divided
    differences (Davis 1975, 3.1).

    nodes : ascending, no place twice.
    differences : Newton's coefficients, to places that come twice each.
    """

    nodes: tuple[Node, ...]
    differences: tuple[float, ...]

    @classmethod
    def through(cls, nodes: Sequence[Node]) -> "HermitePolynomial":
        """Return the polynomial that has the values and slopes of the nodes."""
        places = [node.theta for node in nodes for _ in (0, 1)]
        column = [node.value for node in nodes for _ in (0, 1)]
        differences = column[:1]
        for order in range(1, len(places)):
            column = [
                nodes[i // 2].slope
                if order == 1 and i % 2 == 0
                else (column[i + 1] - column[i]) / (places[i + order] - places[i])
                for i in range(len(column) - 1)
            ]
            differences.append(column[0])
        return cls(tuple(nodes), tuple(differences))

    def at(self, theta: float) -> tuple[float, float]:
        """Value and slope at a place."""
        value = slope = 0.0
        for k in reversed(range(len(self.differences))):
            off = theta - self.nodes[k // 2].theta
            slope = slope * off + value
            value = value * off + self.differences[k]
        return value, slope

    def refined(self, error: float) -> Iterator[Node]:
        """Its nodes, and so many between them that cubics from one to the next are within `error`
        of it.
        """
        for low, high in pairwise(self.nodes):
            # A cubic between two places misses q by q'''' (s (1 - s) h^2)^2 / 24 at the share s of
            # its width h.
            width = high.theta - low.theta
            off = 0.0
            for s in _COMPARED:
                tangents = width * s * (1.0 - s) * ((1.0 - s) * low.slope - s * high.slope)
                cubic = low.value + s**2 * (3.0 - 2.0 * s) * (high.value - low.value) + tangents
                off = max(
                    off,
                    abs(cubic - self.at(low.theta + s * width)[0]) / (16.0 * (s * (1.0 - s)) ** 2),
                )
            count = max(1, math.ceil(_CLOSER * (off / error) ** 0.25))
            yield low
            for theta in (low.theta + k * (width / count) for k in range(1, count)):
                yield Node(theta, *self.at(theta))
        yield self.nodes[-1]


@dataclass(frozen=True)
class _Interval:
    """Neighbouring nodes and the error (rad) that the polynomial through them is believed to have.

    inner : nodes between, evenly spaced: none, the middle or three.
    around : the polynomial of what this is half of.
    """

    low: Node
    high: Node
    error: float
    inner: tuple[Node, ...] = ()
    around: HermitePolynomial | None = None

    @property
    def width(self) -> float:
        return self.high.theta - self.low.theta

    @property
    def polynomial(self) -> HermitePolynomial:
        return HermitePolynomial.through((self.low, *self.inner, self.high))

    def error_at(self, node: Node, polynomial: HermitePolynomial) -> float:
        """What a polynomial misses at a node, in value and, as far as it reaches within a half, in
        slope.
        """
        value, slope = polynomial.at(node.theta)
        return max(abs(value - node.value), abs(slope - node.slope) * self.width / 8.0)


@dataclass
class _Sampler:
    """Work in progress: counts and reports samples, keeps what is finished."""

    sample: Sample
    tolerance: float
    progress: Progress
    finished: list[_Interval] = field(default_factory=list)
    covered: float = 0.0
    taken: int = 0
    known: dict[float, Node] = field(default_factory=dict)

    def nodes(self, theta: list[float]) -> list[Node]:
        """The nodes at several places: those not known yet in one call."""
        new = [t for t in theta if t not in self.known]
        if new:
            self.taken += len(new)
            columns = (column.tolist() for column in self.sample(np.array(new)))
            self.known.update((node[0], Node(*node)) for node in zip(new, *columns, strict=True))
        return [self.known[t] for t in theta]

    def finish(self, *intervals: _Interval) -> None:
        self.finished.extend(intervals)
        self.covered += sum(interval.width for interval in intervals)
        self.progress(min(self.covered / TWO_PI, 1.0))


def sample_circle_map(
    sample: Sample,
    tolerance: float,
    progress: Progress | None = None,
    sample_error: float = 0.0,
) -> CircleMap:
    """Return the circle map of degree one that `sample` gives: thetas (n,), rad -> lifted values
    (n,), slopes (n,).

    Intervals are halved until a polynomial through values and slopes agrees with samples that it
    does not go through to `tolerance` (rad): a cubic or a quintic with the next ones, one of degree
    nine through five nodes as those through four of them do. Where the error does not fall with the
    width as it does for a smooth map, a kink or a jump is looked for by bisection, to 1e-10 rad for
    jumps, and kept as a break with a value and a slope on either side.

    The map's `max_error` is the largest error estimate, checked at further places, plus
    `sample_error`; it exceeds the tolerance where that could not be reached, as on stretches so
    steep that they cannot be told from a jump. It is an estimate, no bound: where a contact begins
    to slide the map bends suddenly, which samples may pass by. Of maps of 16 loops of strong
    anisotropy at tolerances from 1e-3 to 1e-6 rad 9 in 64 were further off somewhere, by 1.9 times
    at the most; of the built-in materials' 1 in 16, by 1.6 times at 1e-3.
    """
    interpolated = (1.0 - _LOCATED) * positive_number("tolerance", tolerance)
    sampler = _Sampler(sample, interpolated, progress or unheard)
    nodes = sampler.nodes([TWO_PI * k / _FIRST_INTERVALS for k in range(_FIRST_INTERVALS)])
    nodes.append(Node(TWO_PI, nodes[0].value + TWO_PI, nodes[0].slope))
    _resolve(sampler, [_Interval(low, high, math.inf) for low, high in pairwise(nodes)])
    _check(sampler)
    intervals = sorted(sampler.finished, key=lambda interval: interval.low.theta)
    joined: list[Node] = []
    for interval in intervals:
        # Where neighbours do not share a node, a repeated place marks a break.
        if not joined or joined[-1] != interval.low:
            joined.append(interval.low)
        inner = (
            interval.polynomial.refined(_FILLED * interpolated)
            if interval.inner
            else (interval.low, interval.high)
        )
        joined.extend(list(inner)[1:])
    theta, lifted, slopes = np.array([(node.theta, node.value, node.slope) for node in joined]).T
    error = max(interval.error for interval in intervals) + _LOCATED * tolerance + sample_error
    made = CircleMap.from_samples(theta, lifted, slopes, degree=1, max_error=error)
    assert made.pieces is not None
    # For the record: what was asked for, not the nodes that were put between.
    return CircleMap.from_pieces(made.pieces, made.breaks, sampler.taken, made.max_error)


def _resolve(sampler: _Sampler, waiting: list[_Interval]) -> None:
    """Halve intervals until all of their parts are good enough, splitting them at breaks."""
    while waiting:
        for interval in (narrow for narrow in waiting if narrow.width <= 2.0 * _NARROWEST):
            # Most that the cubic can be off where the map stays between the values of the ends:
            # slopes lift it by 4/27 of the width each at most above the straight line.
            low = interval.low
            high = interval.high
            most = abs(high.value - low.value) + 4.0 / 27.0 * interval.width * (
                abs(low.slope) + abs(high.slope)
            )
            sampler.finish(replace(interval, error=min(interval.error, most)))
        halved = [interval for interval in waiting if interval.width > 2.0 * _NARROWEST]
        middles = sampler.nodes(
            [0.5 * (interval.low.theta + interval.high.theta) for interval in halved]
        )
        rest = [pair for pair in zip(halved, middles, strict=True) if not _finished(sampler, *pair)]
        waiting = []
        for around, group in groupby(rest, key=lambda pair: pair[0].around):
            halves = list(group)
            if around is None or len(halves) == 1 or not _joined(sampler, halves):
                for interval, middle in halves:
                    error = interval.error_at(middle, interval.polynomial)
                    suspect = interval.width <= _SUSPECT and error > interval.error / _HALVING
                    quintic = HermitePolynomial.through((interval.low, middle, interval.high))
                    waiting += (_split_at_break(sampler, interval) if suspect else None) or (
                        _Interval(interval.low, middle, error, around=quintic),
                        _Interval(middle, interval.high, error, around=quintic),
                    )


def _finished(sampler: _Sampler, interval: _Interval, middle: Node) -> bool:
    """Whether an interval whose middle has been sampled is good enough, and kept."""
    low = interval.low
    high = interval.high
    around = interval.around
    error = interval.error_at(middle, interval.polynomial)
    if error <= sampler.tolerance:
        sampler.finish(_Interval(low, middle, error), _Interval(middle, high, error))
        return True
    # The quintic that did not know the middle yet is worse than the interval's own.
    missed = math.inf if around is None else interval.error_at(middle, around)
    if not missed <= (1.0 - _FILLED) * sampler.tolerance:
        return False
    sampler.finish(_Interval(low, high, missed + _FILLED * sampler.tolerance, (middle,)))
    return True


def _joined(sampler: _Sampler, halves: list[tuple[_Interval, Node]]) -> bool:
    """Keep both halves of an interval together if the polynomial through their five nodes is good
    enough.
    """
    (first, before), (second, after) = halves
    nodes = (first.low, before, first.high, after, second.high)
    # By how much the polynomial through the four others misses each inner node.
    missed = []
    for index, left in list(enumerate(nodes))[1:-1]:
        others = HermitePolynomial.through([*nodes[:index], *nodes[index + 1 :]])
        missed.append(abs(others.at(left.theta)[0] - left.value))
    error = (
        max(_MIDDLE * missed[1], _BESIDE * max(missed[0], missed[2])) + _FILLED * sampler.tolerance
    )
    if not error <= sampler.tolerance:
        return False
    sampler.finish(_Interval(first.low, second.high, error, nodes[1:-1]))
    return True


def _split_at_break(sampler: _Sampler, interval: _Interval) -> tuple[_Interval, ...] | None:
    """Bisect to a kink or a jump; return the parts on either side, or None if the map is only steep
    or curved.
    """
    low = interval.low
    high = interval.high
    while high.theta - low.theta > _NARROWEST:
        gap = abs(
            high.value - low.value - 0.5 * (low.slope + high.slope) * (high.theta - low.theta)
        )
        is_jump = gap > 10.0 * sampler.tolerance
        if (
            not is_jump
            and abs(high.slope - low.slope) * (high.theta - low.theta)
            < _LOCATED * sampler.tolerance
        ):
            break
        (middle,) = sampler.nodes([0.5 * (low.theta + high.theta)])
        # It belongs to a side by value where the sides are apart, by slope where they only meet at
        # an angle.
        if is_jump:
            tangents = (
                side.value + side.slope * (middle.theta - side.theta) for side in (low, high)
            )
            off = [abs(middle.value - value) for value in tangents]
        else:
            gap = abs(high.slope - low.slope)
            off = [abs(middle.slope - side.slope) for side in (low, high)]
        if min(off) > _SIDE_SHARE * gap:
            return None
        low, high = (middle, high) if off[0] < off[1] else (low, middle)
    place = 0.5 * (low.theta + high.theta)
    left, right = (side.value + side.slope * (place - side.theta) for side in (low, high))
    if abs(right - left) <= sampler.tolerance:
        left = right = 0.5 * (left + right)
    before = Node(place, left, low.slope)
    after = Node(place, right, high.slope)
    return _Interval(after, interval.high, math.inf), _Interval(interval.low, before, math.inf)


def _check(sampler: _Sampler) -> None:
    """Try the least certain intervals, and some spread over the circle, off their middle; resolve
    those that fail.

    Where one does, a map may wave in step with the nodes, which are blind to it: then all others
    are tried, too.
    """
    by_error = sorted(sampler.finished, key=lambda interval: interval.error, reverse=True)
    spread = sampler.finished[:: max(1, len(sampler.finished) // _CHECKED)]
    waiting = [*by_error[:_CHECKED], *spread]
    checked = set[tuple[float, float]]()
    for _ in range(_ROUNDS):
        chosen = {(interval.low.theta, interval.high.theta): interval for interval in waiting}
        wide = [
            candidate
            for ends, candidate in chosen.items()
            if candidate.width > 2.0 * _NARROWEST and ends not in checked
        ]
        checked |= set(chosen)
        places = [
            interval.low.theta + _OFF_NODES[len(interval.inner)] * interval.width
            for interval in wide
        ]
        missed = False
        for interval, node in zip(wide, sampler.nodes(places), strict=True):
            filled = _FILLED * sampler.tolerance if interval.inner else 0.0
            error = abs(interval.polynomial.at(node.theta)[0] - node.value) + filled
            sampler.finished = [other for other in sampler.finished if other is not interval]
            if error <= sampler.tolerance:
                sampler.finish(replace(interval, error=max(error, interval.error)))
            else:
                missed = True
                ends = (interval.low, node, interval.high)
                _resolve(sampler, [_Interval(low, high, math.inf) for low, high in pairwise(ends)])
        if not missed:
            return
        waiting = sampler.finished
