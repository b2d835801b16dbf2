"""Cells: one turn of θ cut so finely that each iterate Fⁿ runs monotonely through every cell.

The one search for extrema that root finding, envelopes, tongues and orbit counts share. A cell is
cut until the cubic through its ends' values and slopes meets the iterate at probes inside, of F
itself no further apart than ``GRAIN``; that cubic's slope then tells how often the slope of Fⁿ -
shift·id changes sign. The folds of F, the narrow cells that F needs, and the preimages of both are
ends of cells of Fⁿ. A hump or dent of F that turns Fⁿ - shift·id back is seen where it is as wide
as ``GRAIN`` at half its height; a narrower one may hide between the probes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import EPS, LIFT
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import distance_to_break

_CLOSE = 2.0 * EPS  # share of |x| (plus a thousandth) at which a bracket is closed
_STEPS = 120


def bracketed_root(function: Callable[[Array, Whole], Array], low: Array, high: Array) -> Array:
    """A root of f(x, i) in each bracket i, to rounding (Chandrupatla 1997): bisection or inverse
    quadratic steps.

    f takes points and the numbers of their brackets. Where it has one sign at both ends, the end
    nearer to zero.
    """
    index = np.arange(low.size)
    bracket = np.stack([low, high, function(low, index), function(high, index)])
    answer = _nearer_to_zero(bracket)
    opposite = bracket[2] * bracket[3] < 0.0
    index = index[opposite]
    bracket = bracket[:, opposite]
    share = np.full(index.size, 0.5)
    for _ in range(_STEPS):
        if index.size == 0:
            break
        a, b, fa, fb = bracket
        x = a + share * (b - a)
        fx = function(x, index)
        stays = np.sign(fx) == np.sign(fa)
        c, fc = np.where(stays, (a, fa), (b, fb))
        b, fb = np.where(stays, (b, fb), (a, fa))
        bracket = np.stack([x, b, fx, fb])
        answer[index] = _nearer_to_zero(bracket)
        reach = _CLOSE * (np.abs(x) + 1e-3) / np.maximum(np.abs(b - x), 1e-300)
        with np.errstate(divide="ignore", invalid="ignore"):
            xi = (x - b) / (c - b)
            phi = (fx - fb) / (fc - fb)
            trusted = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
            share = fx / (fb - fx) * fc / (fb - fc) + (c - x) / (b - x) * fx / (fc - fx) * fb / (
                fc - fb
            )
        share = np.clip(np.where(trusted & np.isfinite(share), share, 0.5), reach, 1.0 - reach)
        goes_on = (reach < 0.5) & (fx != 0.0)
        index = index[goes_on]
        bracket = bracket[:, goes_on]
        share = share[goes_on]
    return answer


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """The same of one function in one bracket."""
    [root] = bracketed_root(
        lambda x, _: np.array([function(float(x[0]))]), np.array([low]), np.array([high])
    )
    return float(root)


def _nearer_to_zero(bracket: Array) -> Array:
    a, b, fa, fb = bracket
    return np.asarray(np.where(np.abs(fa) < np.abs(fb), a, b))


INSET = 1e-12  # radians: how far beside a break of an iterate its one-sided values are read
_ARRAYS = ("start", "end", "g_start", "g_end", "slope_start", "slope_end", "cut")


def iterate(circle_map: CircleMap, theta: Array, period: int) -> Array:
    """Fⁿ(θ), radians, lifted."""
    image = np.asarray(theta, dtype=np.float64)
    for _ in range(period):
        image = circle_map(image)
    return image


def iterate_slope(circle_map: CircleMap, theta: Array, period: int) -> Array:
    """(Fⁿ)'(θ) by the chain rule."""
    image = theta
    slope = circle_map.derivative(theta)
    for _ in range(period - 1):
        image = circle_map(image)
        slope = slope * circle_map.derivative(image)
    return slope


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells [a, b] in order over [0, 2π] and the values there of ``g = Fⁿ(θ) - shift·θ`` with its
    slopes.

    ``cut[i]`` says that a break of the iterate lies at the start of cell i (and at the end of cell
    i - 1); there ``start`` and ``end`` hold the break, while values are one-sided limits.
    """

    start: Array
    end: Array
    g_start: Array
    g_end: Array
    slope_start: Array
    slope_end: Array
    cut: Mask
    period: int
    shift: float
    degree: int

    @property
    def climb(self) -> float:
        """g(θ + 2π) - g(θ), radians."""
        return float(TWO_PI * (self.degree**self.period - self.shift))

    def inner(self) -> tuple[Array, Array]:
        """The cells' ends moved inside by ``INSET`` where a break lies there."""
        cut_after = np.roll(self.cut, -1)
        return self.start + INSET * self.cut, self.end - INSET * cut_after


def taken(cells: Cells, index: Mask | Whole) -> Cells:
    """The cells with these indices."""
    return replace(cells, **{name: getattr(cells, name)[index] for name in _ARRAYS})


def joined(groups: list[Cells]) -> Cells:
    """All the cells, sorted by start; both sides of every smooth node get the very same value, so
    no root is lost.
    """
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(cells, name) for cells in groups]) for name in _ARRAYS
    }
    order = np.argsort(arrays["start"])
    cells = replace(groups[0], **{name: array[order] for name, array in arrays.items()})
    g_end = np.where(np.roll(cells.cut, -1), cells.g_end, np.roll(cells.g_start, -1))
    if not cells.cut[0]:
        g_end[-1] = cells.g_start[0] + cells.climb
    return replace(cells, g_end=g_end, end=np.append(cells.start[1:], TWO_PI))


def is_continuous(cells: Cells) -> Mask:
    """Whether g is continuous at the start of each cell (the last cell's end is the first cell's
    start).
    """
    before = np.roll(cells.g_end, 1)
    slope = np.abs(np.roll(cells.slope_end, 1))
    before[0] -= cells.climb
    allowed = 1e-9 + 4.0 * INSET * (slope + np.abs(cells.slope_start))
    return ~cells.cut | (np.abs(before - cells.g_start) <= allowed)


def is_rising(cells: Cells) -> Mask:
    """Whether g climbs along each cell."""
    trend = cells.slope_start + cells.slope_end
    return np.where(trend == 0.0, cells.g_end > cells.g_start, trend > 0.0)


RESOLUTION = 512  # cells a turn, at least
MAX_CELLS = 2_000_000
# cells of F that no cubic meets: more than a lift without structure below ``GRAIN`` has
MAX_ROUGH = 8_000
_LONGEST_IMAGE = 0.5  # radians: no cell's image under any iterate is longer
_PASSES = 60
GRAIN = 1e-4  # radians: distance of the probes
_SKEW = 0.04  # of a cell's width: no probe in its middle, where an odd misfit is zero
# of the width that the resolution asks for: narrower cells of F are marked in its iterates
_NARROW = 0.2
_MISFIT = 1e-3  # of the cell's steepest rise: how far the probes may lie off the cubic
_HIDDEN_JUMP = 1e-6  # radians: a rise within 32 INSET beyond what the slopes explain
_LEVELS_AT_ONCE = 2_048
_NOTHING = 1e-13  # radians: smaller misfits and dips are of no account


def monotone_cells(
    circle_map: CircleMap,
    period: int,
    shift: float,
    resolution: int = RESOLUTION,
    marks: Sequence[float] = (),
) -> Cells:
    """Cells on each of which g = Fⁿ - shift·id is monotone, down to ``GRAIN``; ``marks`` are ends
    of cells, too.
    """
    nodes, breaks = _first_nodes(circle_map, period, resolution, marks)
    start = nodes[:-1]
    end = nodes[1:]
    cut = np.isin(start, breaks)
    cut_end = np.roll(cut, -1)
    done = []
    count = 0
    for _ in range(_PASSES):
        cells, parts, rough = _evaluated(circle_map, start, end, cut, cut_end, period, shift)
        if period == 1 and np.count_nonzero(rough) > MAX_ROUGH:
            _refuse_rough(cells, rough)
        whole = parts == 1
        done.append(taken(cells, whole))
        if np.all(whole):
            decided = joined(done)
            if period == 1:
                _refuse_hidden_jump(decided)
            return _split_at_extrema(circle_map, decided)
        count += int(np.count_nonzero(whole))
        parts[whole] = 0
        owner = np.repeat(np.arange(start.size), parts)
        if count + owner.size > MAX_CELLS:
            break
        rank = ranks(parts)
        last = rank + 1 == parts[owner]
        low = start[owner]
        step = (end - start)[owner] / parts[owner]
        start = low + step * rank
        end = np.where(last, end[owner], low + step * (rank + 1))
        cut = cut[owner] & (rank == 0)
        cut_end = cut_end[owner] & last
    raise ConvergenceError(
        f"period {period} needs more than {MAX_CELLS} cells: the map is too steep, most of all "
        f"near θ = {cells.start[int(np.argmax(parts))]:.6g}; ask for a shorter period, or name the "
        "break that is missing there"
    )


def _refuse_hidden_jump(cells: Cells) -> None:
    """Say where the lift jumps between two ends that its slopes do not let it."""
    width = cells.end - cells.start
    rise = np.abs(cells.g_end - cells.g_start)
    steepest = np.maximum(np.abs(cells.slope_start), np.abs(cells.slope_end))
    jumps = (width < 32.0 * INSET) & (rise > 4.0 * steepest * width + _HIDDEN_JUMP)
    if np.any(jumps):
        place = int(np.argmax(np.where(jumps, rise, 0.0)))
        raise ConvergenceError(
            f"the lift jumps by {rise[place]:.6g} radians at θ = "
            f"{cells.start[place]:.12g}, which is none of its breaks: give it in breaks"
        )


def _split_at_extrema(circle_map: CircleMap, cells: Cells) -> Cells:
    turns = cells.slope_start * cells.slope_end < 0.0
    if not np.any(turns):
        return cells
    turning = np.flatnonzero(turns)
    start, end = (ends[turning] for ends in cells.inner())
    theta = bracketed_root(
        lambda x, _: iterate_slope(circle_map, x, cells.period) - cells.shift, start, end
    )
    g = iterate(circle_map, theta, cells.period) - cells.shift * theta
    flat = np.zeros_like(g)
    halves = taken(cells, turning)
    first = replace(halves, end=theta, g_end=g, slope_end=flat)
    second = replace(
        halves, start=theta, g_start=g, slope_start=flat, cut=np.zeros(g.size, dtype=bool)
    )
    return joined([taken(cells, ~turns), first, second])


def _refuse_rough(cells: Cells, rough: Mask) -> None:
    """Say where most of the cells lie that no cubic through their ends meets."""
    places = cells.start[rough]
    crowd = 1 + MAX_ROUGH // 10
    densest = int(np.argmin(places[crowd:] - places[:-crowd]))
    low = places[densest]
    high = places[densest + crowd]
    raise ConvergenceError(
        f"the lift is too rough to follow, most of all between θ = {low:.12g} and {high:.12g}: a "
        "break may be missing there (give it in breaks), the derivative may be another lift's (or "
        f"none given, where F' is steep), or the lift has structure finer than {GRAIN:g} radians"
    )


def ranks(count: Whole) -> Whole:
    """0, 1, ..., count - 1 for each entry, one after the other."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)


def pulled_back(
    circle_map: CircleMap, once: Cells, marks: Array, levels: Array, cycles: int
) -> Array:
    """``marks`` and the preimages of ``levels`` up to so many cycles back, in [0, 2π), sorted; of
    those that lie together the one given first.

    once : cells of F itself.
    """
    for _ in range(cycles):
        if levels.size == 0:
            break
        known = marks
        angles = np.append(known, np.mod(preimages(circle_map, once, levels), TWO_PI))
        angles = np.where(angles > TWO_PI - 8.0 * INSET, 0.0, angles)
        order = np.argsort(angles, kind="stable")
        fresh = np.flatnonzero(np.diff(angles[order], prepend=-1.0) > 8.0 * INSET)
        if fresh.size > MAX_CELLS // 8:
            raise ConvergenceError(
                f"the iterate has more than {fresh.size} breaks or folds: ask for a shorter period"
            )
        marks = angles[np.minimum.reduceat(order, fresh)]
        levels = np.setdiff1d(marks, known)
    return marks


def _first_nodes(
    circle_map: CircleMap, period: int, resolution: int, marks: Sequence[float]
) -> tuple[Array, Array]:
    """The ends of the first cells, and those of them that are breaks of the iterate."""
    breaks = circle_map.breaks
    features = np.mod(marks, TWO_PI)
    if period > 1:
        # Breaks, smooth turning points and narrow cells of F, and their preimages up to n - 1
        # cycles back.
        once = monotone_cells(circle_map, 1, 0.0, resolution)
        rising = is_rising(once)
        narrow = once.end - once.start < _NARROW * TWO_PI / resolution
        breaks = pulled_back(circle_map, once, breaks, breaks, period - 1)
        special = once.start[((rising != np.roll(rising, 1)) | narrow) & ~once.cut]
        pulled = pulled_back(circle_map, once, special, special, period - 1)
        features = np.append(pulled, features)
    grid = np.linspace(0.0, TWO_PI, resolution + 1)
    knots = circle_map.pieces.knots if circle_map.pieces is not None else np.zeros(0)
    smooth = np.unique(np.concatenate([grid, knots, features]))
    near = distance_to_break(breaks, smooth) <= 8.0 * INSET
    smooth = smooth[~near | (smooth == 0.0) | (smooth == TWO_PI)]
    nodes = np.union1d(smooth, breaks)
    return nodes[np.append(np.diff(nodes) > 4.0 * INSET, True)], breaks


def _evaluated(
    circle_map: CircleMap,
    start: Array,
    end: Array,
    cut: Mask,
    cut_end: Mask,
    period: int,
    shift: float,
) -> tuple[Cells, Whole, Mask]:
    """The cells with their values, into how many parts each must still be cut, and which no cubic
    meets.
    """
    width = end - start
    inset = INSET * np.stack([1.0 * cut, -1.0 * cut_end])
    here = np.stack([start, end]) + inset
    image = here
    slope = np.ones_like(here)
    longest = np.zeros(start.size)
    rounding = np.ones_like(here)
    for _ in range(period):
        steepness = circle_map.derivative(image)
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            slope = slope * steepness
            rounding = np.abs(steepness) * rounding + 1.0
        image = circle_map(image)
        steepest = np.max(np.abs(slope), axis=0) * width
        longest = np.maximum(longest, np.maximum(steepest, np.abs(image[1] - image[0])))
    beyond = ~(np.isfinite(slope) & np.isfinite(rounding))
    if np.any(beyond):
        raise ConvergenceError(
            f"the slope of F^{period} is beyond all floats at θ = {here[beyond][0]:.6g}: ask for a "
            "shorter period"
        )
    g_slope = slope - shift
    g = image - shift * here - inset * g_slope
    ends = (g[0], g[1], g_slope[0], g_slope[1])
    cells = Cells(start, end, *ends, cut, period, shift, circle_map.degree)
    parts = np.clip(np.ceil(longest / _LONGEST_IMAGE), 1, 64).astype(np.int64)
    ready = np.flatnonzero((parts == 1) & (width >= 32.0 * INSET))
    noise = 8.0 * LIFT * np.max((TWO_PI + np.abs(g)) * rounding, axis=0)
    rough = np.zeros(start.size, dtype=bool)
    rough[ready] = _unclear(circle_map, taken(cells, ready), noise[ready])
    parts[rough] = 2
    parts[width < 32.0 * INSET] = 1
    return cells, parts, rough


def _unclear(circle_map: CircleMap, cells: Cells, noise: Array) -> Mask:
    """Whether the cubic through a cell's ends misses the iterate,
    or turns twice inside the cell."""
    width = cells.end - cells.start
    rise = cells.g_end - cells.g_start
    a = width * cells.slope_start
    b = width * cells.slope_end
    steepest = np.maximum(np.abs(a), np.abs(b))
    nothing = _NOTHING + noise
    probes = np.full(width.size, 2)
    if cells.period == 1 and circle_map.pieces is None:
        probes = np.maximum(2, np.ceil(width / GRAIN).astype(np.int64))
    misfit = np.zeros(width.size)
    for count in np.unique(probes).tolist():
        alike = np.flatnonzero(probes == count)
        t = (np.arange(1.0, count + 1.0) + 3.0 * _SKEW) / (count + 1.0)
        theta = cells.start[alike, None] + t * width[alike, None]
        # Hermite's cubic: its start, its rise, and both slopes.
        shapes = [np.ones(count), t * t * (3.0 - 2.0 * t), t * (1.0 - t) ** 2, -t * t * (1.0 - t)]
        cubic = np.stack([cells.g_start, rise, a, b], axis=1)[alike] @ np.stack(shapes)
        cubic += cells.shift * theta
        cubic -= iterate(circle_map, theta, cells.period)
        misfit[alike] = np.maximum(np.max(cubic, axis=1), -np.min(cubic, axis=1))
    # The cubic's slope is the parabola with Bernstein's coefficients a, middle, b.
    middle = 3.0 * rise - a - b
    dip = (middle**2 - a * b) / np.maximum(np.abs(a) + 2.0 * np.abs(middle) + np.abs(b), 1e-300)
    turns_twice = (a * b > 0.0) & (a * middle < 0.0) & (dip > nothing)
    return (misfit > _MISFIT * steepest + nothing) | turns_twice


def preimages(circle_map: CircleMap, cells: Cells, levels: Array) -> Array:
    """All θ in [0, 2π] with g(θ) = level + 2πw for some w, level after level of ``levels``, shape
    (m,), radians.
    """
    roots = [np.zeros(0)]
    for first in range(0, levels.size, _LEVELS_AT_ONCE):
        chosen = levels[first : first + _LEVELS_AT_ONCE]
        start, end = (whole_turns(g - chosen[:, None]) for g in (cells.g_start, cells.g_end))
        level, cell = np.nonzero(start != end)
        turns = (start[level, cell], end[level, cell])
        roots.append(solved(circle_map, cells, cell, chosen[level], *turns)[0])
    return np.concatenate(roots)


def whole_turns(g: Array) -> Whole:
    """The whole turns below each value."""
    return np.floor(g / TWO_PI).astype(np.int64)


def solved(
    circle_map: CircleMap,
    cells: Cells,
    cell: Whole,
    level: Array | np.float64,
    turn_start: Whole,
    turn_end: Whole,
) -> tuple[Array, Whole, Whole]:
    """The roots in the listed cells, their w, and which entry of the list each belongs to."""
    count = np.abs(turn_end - turn_start)
    owner = np.repeat(np.arange(count.size), count)
    whole = np.minimum(turn_start, turn_end)[owner] + 1 + ranks(count)
    if owner.size == 0:
        return np.zeros(0), whole, owner
    inner_start, inner_end = cells.inner()
    target = np.broadcast_to(level, count.shape)[owner] + TWO_PI * whole

    def residual(theta: Array, index: Whole) -> Array:
        return np.asarray(
            iterate(circle_map, theta, cells.period) - cells.shift * theta - target[index]
        )

    return bracketed_root(residual, inner_start[cell[owner]], inner_end[cell[owner]]), whole, owner
