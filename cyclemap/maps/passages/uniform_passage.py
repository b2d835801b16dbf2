"""Passage times and hitting probabilities under uniform noise, by collocation on panels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import lapack

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import EPS, SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.scan import Cells, monotone_cells
from cyclemap.maps.noise.bounded_noise import UniformNoise
from cyclemap.maps.noise.panels import Panels, Singularities, level_steps, refined, with_ends
from cyclemap.maps.passages.killed_chain import Arc, arcs_between

_SLIVER = 1e-12  # radians: an overlap no longer than this is none
_GROWTH = 1e-11  # radians: a set that grows by less in a cycle has stopped
_CYCLES = 3_000
_CYCLES_AHEAD = 100  # a path that has not been everywhere by then may as well come everywhere
_WIDER = 1.001  # times the noise: so a set that only comes nearer and nearer to its ends is soon closed


@dataclass(frozen=True, eq=False)
class Intervals:
    """Disjoint intervals (start, end), sorted, on the line, or with ``wrapped`` on the circle (any turn)."""

    start: Array
    end: Array
    wrapped: bool

    @property
    def length(self) -> float:
        """Their total length."""
        return float(np.sum(self.end - self.start))

    def overlaps(self, low: Array, high: Array) -> Mask:
        """Whether each (low, high) shares more than a point with one of the intervals."""
        low, high = low[:, None] + _SLIVER, high[:, None] - _SLIVER
        if not self.wrapped:
            return np.asarray(np.any((low < self.end) & (self.start < high), axis=1))
        # The first whole turn that lifts the interval's end above ``low`` must leave its start below ``high``.
        turns = np.floor((low - self.end) / TWO_PI) + 1.0
        return np.asarray(np.any(self.start + TWO_PI * turns < high, axis=1))

    def hold(self, theta: Array) -> Mask:
        """Whether each angle lies inside one of the intervals, ends left out."""
        return self.overlaps(theta - 2.0 * _SLIVER, theta + 2.0 * _SLIVER)


@dataclass(frozen=True, eq=False)
class Reach:
    """The noisy map on a domain: the intervals inside ``domain`` from which paths go on."""

    map: CircleMap
    cells: Cells
    halfwidth: float
    domain: Intervals

    def basin(self, target: Intervals) -> Intervals:
        """The part of the domain from which the path is in ``target`` later on with a chance above zero.

        Grown backward a cycle at a time until it stops growing: x belongs to it when (F(x) - h, F(x) + h) meets the
        target or the basin so far. A domain that takes more than 3000 cycles to cross (a gap that opens by less
        than about 1e-6 of its width) is left as it is then: chances there are below 1e-300.
        """
        found = self.before(target, Intervals(np.zeros(0), np.zeros(0), target.wrapped))
        for _ in range(_CYCLES):
            more = self.before(target, found)
            if more.length <= found.length + _GROWTH:
                break
            found = more
        return found

    def meets(self, start: float, part: Intervals) -> bool:
        """Whether the path from ``start`` may be in ``part`` a cycle later."""
        image = self.map(np.array([start]))
        return bool(part.overlaps(image - self.halfwidth, image + self.halfwidth)[0])

    def ahead(self, start: float) -> Reach:
        """On a part of the domain, and little more than need be, that paths from ``start`` stay in until they leave."""
        nothing = Intervals(np.zeros(0), np.zeros(0), self.domain.wrapped)
        found = self._after(np.array([start]), np.array([start]), _WIDER, nothing)
        for _ in range(_CYCLES_AHEAD):
            if found.length == 0.0:
                break
            nodes = replace(self, domain=found).cut(self.cells.start)
            inside = found.hold(0.5 * (nodes[1:] + nodes[:-1]))
            low, high = nodes[:-1][inside], nodes[1:][inside]
            if self._after(low, high, 1.0, found).length <= found.length + _SLIVER:
                break
            found = self._after(low, high, _WIDER, found)
        else:
            return self
        return replace(self, domain=found)

    def _after(self, low: Array, high: Array, wider: float, known: Intervals) -> Intervals:
        """The part of the domain that is ``known`` or one cycle behind an interval [low, high] where F is monotone."""
        ends, reach = np.stack([self.map.right(low), self.map.left(high)]), wider * self.halfwidth
        start, end = np.append(ends.min(axis=0) - reach, known.start), np.append(ends.max(axis=0) + reach, known.end)
        order = np.argsort(start)
        start, end = start[order], np.maximum.accumulate(end[order])
        apart = np.append(True, start[1:] > end[:-1])
        wanted = Intervals(start[apart], end[np.append(apart[1:], True)], known.wrapped)
        pieces = self.cut(np.append(wanted.start, wanted.end))
        middle = 0.5 * (pieces[1:] + pieces[:-1])
        return _joined(pieces, self.domain.hold(middle) & wanted.hold(middle), known.wrapped)

    def before(self, target: Intervals, basin: Intervals) -> Intervals:
        """The part of the domain whose next positions meet ``target`` or ``basin``."""
        wanted = Intervals(np.append(target.start, basin.start), np.append(target.end, basin.end), target.wrapped)
        # On each of the pieces all next positions meet the same of the intervals.
        ends = np.concatenate([wanted.start, wanted.end])
        levels = np.concatenate([ends + self.halfwidth, ends - self.halfwidth])
        pieces = self.cut(self.preimages(levels[np.isfinite(levels)]))
        middle = self.map(0.5 * (pieces[1:] + pieces[:-1]))
        inside = self.domain.hold(0.5 * (pieces[1:] + pieces[:-1]))
        meets = inside & wanted.overlaps(middle - self.halfwidth, middle + self.halfwidth)
        return _joined(pieces, meets, target.wrapped)

    def without(self, part: Intervals) -> Intervals:
        """The domain less ``part`` (some of it): what is left."""
        pieces = np.unique(np.concatenate([self.domain.start, self.domain.end, part.start, part.end]))
        middle = 0.5 * (pieces[1:] + pieces[:-1])
        kept = self.domain.hold(middle) & ~part.hold(middle) & (np.diff(pieces) > _GROWTH)
        return _joined(pieces, kept, self.domain.wrapped)

    def preimages(self, levels: Array) -> Array:
        """Angles of [0, 2π) whose images, up to whole turns, are among ``levels``; F's breaks with them."""
        return np.append(level_steps(self.map, self.cells, np.mod(levels, TWO_PI))[1], self.map.breaks)

    def cut(self, theta: Array) -> Array:
        """The domain's ends and all turns of ``theta`` between them, sorted."""
        low, high = float(self.domain.start[0]), float(self.domain.end[-1])
        first = low + np.mod(theta - low, TWO_PI)
        inner = np.concatenate([self.domain.start, self.domain.end, first, np.mod(theta, TWO_PI)])
        return np.unique(inner[(inner >= low) & (inner <= high)])


def _joined(pieces: Array, keep: Mask, wrapped: bool) -> Intervals:
    """The kept pieces, neighbours joined."""
    edge = np.diff(np.concatenate([[False], keep, [False]]).astype(np.int64))
    return Intervals(pieces[edge == 1], pieces[edge == -1], wrapped)


Source = Callable[[Array], Array]

MAX_PANELS = 100
RESOLUTION = 512
_GENERATIONS = 4
_MOST = 600  # kinks looked for
_TOLERANCE = 1e-12
_ACCEPTED = 0.3  # residual of the mean time
_REFINEMENTS = 3  # of the linear solution: long times lose digits without


def uniform_passage_time(
    circle_map: CircleMap,
    noise: UniformNoise,
    start: float,
    ends: Arc,
    lifted: bool = False,
) -> Estimate:
    """``mean_passage_time`` under uniform noise on [-h, h], from ``start`` inside the arc ``ends``, radians.

    T(x) = 1 + (S(F(x) + h) - S(F(x) - h))/2h, S the antiderivative of T, zero outside the arc: by collocation on panels
    that end where T kinks (F(x) ± h at an end of the arc or at an earlier kink) or jumps (F's breaks), and are cut
    until T's last coefficients are below 1e-12, or there are 100 panels. inf where the path can come to a part of the
    arc that the noise is too small to leave: that part is found as a set of intervals.

    ``error_bound``: with r a bound on the residual of the computed T, |T - computed| <= r T, since the equation's
    kernel is positive (Collatz 1952): proved; r is measured, see ``residual``. It grows like 1e-14 T, relative;
    ConvergenceError where it would reach T/2.
    """
    arc = Intervals(np.array([ends[0]]), np.array([ends[1]]), not lifted)
    cells = monotone_cells(circle_map, 1, 0.0, RESOLUTION)
    reach = Reach(circle_map, cells, noise.halfwidth, arc).ahead(start)
    if reach.domain.length == 0.0:
        return Estimate(1.0, 0.0)
    if lifted:
        outside = Intervals(np.array([-np.inf, ends[1]]), np.array([ends[0], np.inf]), False)
    else:
        outside = Intervals(np.array([ends[1]]), np.array([ends[0] + TWO_PI]), True)
    trap = reach.without(reach.basin(outside))
    if trap.length > 0.0:
        lost = reach.basin(trap)
        if reach.meets(start, lost) or reach.meets(start, trap):
            return Estimate(np.inf, 0.0)
        reach = replace(reach, domain=replace(reach, domain=reach.without(lost)).without(trap))
    if reach.domain.length == 0.0:
        return Estimate(1.0, 0.0)
    chain, slack = _chain(reach, [ends[0], ends[1]], np.ones_like)
    value = chain.extended(chain.solutions[:, 1], start, np.ones_like)
    return Estimate(value, (slack / (1.0 - slack) + SOLUTION) * value)


def uniform_hitting_probability(
    circle_map: CircleMap,
    noise: UniformNoise,
    start: float,
    arc_a: Arc,
    arc_b: Arc,
) -> Estimate:
    """``hitting_probability`` under uniform noise, from a ``start`` outside both arcs, which do not overlap.

    The equation is that of ``uniform_passage_time`` with P(F(x) + ξ in a) in place of 1. Paths that come to neither arc
    count as not in a; 0 is exact where the noise cannot bring the path to a. ``error_bound``: the residual's bound
    times the mean number of cycles until an arc, or a part of the circle that the noise is too small to leave, is
    reached.
    """
    between = np.array(arcs_between(arc_a, arc_b))
    rest = Intervals(between[:, 0], between[:, 1], True)
    goal = Intervals(np.array([arc_a[0]]), np.array([arc_a[1]]), True)
    either = Intervals(np.array([arc_a[0], arc_b[0]]), np.array([arc_a[1], arc_b[1]]), True)

    def arrives(image: Array) -> Array:
        return noise.arc_probability(arc_a[0] - image, arc_a[1] - image)

    reach = Reach(circle_map, monotone_cells(circle_map, 1, 0.0, RESOLUTION), noise.halfwidth, rest).ahead(start)
    if reach.domain.length > 0.0:
        if not (reach.meets(start, goal) or reach.meets(start, reach.basin(goal))):
            return Estimate(0.0, 0.0)
        trap = reach.without(reach.basin(either))
        reach = replace(reach, domain=reach.without(trap)) if trap.length > 0.0 else reach
    if reach.domain.length == 0.0:  # at once or never
        value = float(arrives(circle_map(np.array([start])))[0])
        return Estimate(value, SOLUTION * value)
    chain, slack = _chain(reach, [*arc_a, *arc_b], arrives)
    law, time = chain.solutions.T
    longest = chain.extended(time, start, np.ones_like) / (1.0 - slack)
    value = float(np.clip(chain.extended(law, start, arrives), 0.0, 1.0))
    return Estimate(value, min(chain.residual(law, arrives) * longest + SOLUTION * value, 1.0))


@dataclass(frozen=True, eq=False)
class _Chain(Panels):
    """K f(x) = the integral of f over the panels within h of F(x), over 2h; ``source`` a function of F(x)."""

    map: CircleMap
    halfwidth: float
    wrapped: bool
    source: Source
    missing: float  # radians of the domain that no panel covers: slivers

    @cached_property
    def solutions(self) -> Array:
        """(size, 2): coefficients for ``source``, and for the source 1: cycles until the domain is left."""
        images = self.map(self.nodes)
        count, (at, turns) = images.size, self._ends(images)
        sign = np.repeat([1.0, -1.0], count)
        theta = np.append(at, np.full(2 * count, self.end[-1]))
        sums = self.integral_matrix(theta, np.append(sign, sign * turns), np.tile(np.arange(count), 4), count)
        system = np.eye(self.size) - self.coefficients(sums / (2.0 * self.halfwidth))
        right = self.coefficients(np.stack([self.source(images), np.ones_like(images)], axis=1))
        factors, pivots, failed = lapack.dgetrf(system)
        if failed:
            return np.full(right.shape, np.inf)
        found = np.zeros_like(right)
        for _ in range(_REFINEMENTS):
            found = found + lapack.dgetrs(factors, pivots, right - system @ found)[0]
        return np.asarray(found)

    def _ends(self, images: Array) -> tuple[Array, Array]:
        """Where S is read, F ± h brought into the domain's turn, and how many whole domains lie below."""
        at = np.concatenate([images + self.halfwidth, images - self.halfwidth])
        turns = np.floor((at - self.start[0]) / TWO_PI) if self.wrapped else np.zeros_like(at)
        return at - TWO_PI * turns, turns

    def carried(self, law: Array, images: Array) -> Array:
        """K f where F is ``images``."""
        at, turns = self._ends(images)
        above, below = np.split(self.integral(law, at) + turns * float(self.mass @ law), 2)
        return np.asarray((above - below) / (2.0 * self.halfwidth))

    def extended(self, law: Array, theta: float, source: Source) -> float:
        """The solution at one angle, inside the domain or not."""
        image = self.map(np.array([theta]))
        return float((source(image) + self.carried(law, image))[0])

    def residual(self, law: Array, source: Source) -> float:
        """Twice the largest |f - source - K f| at three times as many angles, with rounding and the map's error."""
        if not np.all(np.isfinite(law)):
            return float("inf")
        images, here = self.map(self.test_points), self.value(law, self.test_points)
        worst = float(np.max(np.abs(here - source(images) - self.carried(law, images))))
        largest = float(np.max(np.abs(here)))
        rounding = 8.0 * EPS * (1.0 + np.pi / self.halfwidth) * largest
        moved = self.map.max_error * (largest + 1.0) / self.halfwidth
        return 2.0 * worst + rounding + moved + self.missing * largest / self.halfwidth


def _chain(reach: Reach, marks: list[float], source: Source) -> tuple[_Chain, float]:
    """Panels on which the solution is resolved, and the residual of the mean time, small enough to say something.

    marks : the ends of the arcs that matter.
    """
    domain, halfwidth = reach.domain, reach.halfwidth
    edges = np.concatenate([domain.start, domain.end, np.array(marks)])
    # Kinks: angles x with F(x) ± h at an edge (generation 0), or at a kink of the generation before.
    theta, generation, values = np.zeros(0), np.zeros(0, dtype=np.int64), np.append(edges, reach.map.breaks)
    for step in range(_GENERATIONS):
        found = reach.cut(reach.preimages(np.append(values - halfwidth, values + halfwidth)))
        fresh = found[~np.isin(found, theta)]
        if theta.size + fresh.size > _MOST and step > 0:
            break
        theta, generation = np.append(theta, fresh), np.append(generation, np.full(fresh.size, step))
        values = fresh
    order = np.argsort(theta, kind="stable")
    kinks = Singularities(theta[order], generation[order], np.zeros(theta.size, dtype=bool))

    def chain(panels: Panels) -> _Chain:
        missing = max(domain.length - float(np.sum(panels.end - panels.start)), 0.0)
        intervals = panels.start, panels.end, panels.bent
        return _Chain(*intervals, reach.map, halfwidth, domain.wrapped, source, missing)

    def solution(panels: Panels) -> Array:
        law = chain(panels).solutions[:, 0]
        return law[:, None] / max(float(np.max(np.abs(law))), 1.0)

    ends = np.array([domain.start[0], domain.end[-1]])
    for more in (domain.start, domain.end, reach.cut(reach.map.breaks), kinks.upto(0).theta):
        ends = with_ends(ends, more)
    made = chain(refined(ends, kinks, solution, np.array([_TOLERANCE]), MAX_PANELS, domain.hold))
    slack = made.residual(made.solutions[:, 1], np.ones_like)
    if slack > _ACCEPTED:
        wide = float(np.sum(made.end - made.start)) / halfwidth
        raise ConvergenceError(
            f"the passage is too long for the noise {halfwidth:g}, or {made.count} panels are too few "
            f"for where it leads, {wide:.0f} times as wide: the equation's solution leaves a residual of {slack:.2g} "
            "(times longer than about 1e12 cycles are beyond double precision); raise the noise or shorten the arc"
        )
    return made, slack
