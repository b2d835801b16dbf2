"""Circle maps made of circle maps: composition, iterates, inverse, conjugation by a rotation,
shifted lifts.
"""

from __future__ import annotations

import math
import sys
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from math import floor

import numpy as np

from cyclemap.arrays import TWO_PI, Array, even_angles
from cyclemap.checks import finite_number, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS, LIFT
from cyclemap.maps.lifts.branches import Branch, MonotoneTable, branches, seams
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import (
    JUMP,
    SIDE_STEP,
    SNAP,
    MadeLift,
    Scalar,
    base_angles,
    carried_round,
    distance_to_break,
    within_turn,
)
from cyclemap.maps.lifts.scan import monotone_cells, pulled_back


def slope_and_error_beside(
    circle_map: CircleMap,
    theta: Array,
    moved: Array | float,
    low: Array | float = -np.inf,
    high: Array | float = np.inf,
) -> tuple[Array, Array]:
    """F' at ``theta``, which may be off by ``moved``, and a bound on its error; F' is read in [low,
    high] only.
    """
    slope, error = circle_map.derivative_and_error(np.clip(theta, low, high))
    sides = (
        circle_map.derivative(np.clip(theta + side * moved, low, high)) for side in (-1.0, 1.0)
    )
    return slope, error + np.max([np.abs(side - slope) for side in sides], axis=0)


@dataclass(frozen=True, eq=False)
class InverseLift(MadeLift):
    """F⁻¹ from a table of one turn of F, along which F rises or falls by 2π."""

    table: MonotoneTable

    def __call__(self, values: Array) -> Array:
        """The inverse at ``values``, radians."""
        base, turns = self._in_table(values)
        return self.table.inverse(base) + (TWO_PI * self.table.sign) * turns

    def _in_table(self, values: Array) -> tuple[Array, Array]:
        """The values less whole turns, within the table, and those turns."""
        turns = np.floor((values - min(self.table.value[0], self.table.value[-1])) / TWO_PI)
        return values - TWO_PI * turns, turns

    def derivative_and_error(self, values: Array) -> tuple[Array, Array]:
        """1/F' at the inverse, on the side of F's breaks that belongs to the value, 0 across a jump
        of F; its error is that of F', at an angle that is known to rounding over F'.
        """
        base, _ = self._in_table(values)
        theta = self.table.inverse(base)
        # F' belongs to the value inside the breaks at the ends of its cell.
        cell = self.table.cell(base)
        low = self.table.theta[cell]
        high = self.table.theta[cell + 1]
        margin = np.minimum(SIDE_STEP, 0.25 * (high - low))
        low = low + margin
        high = high - margin
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = self.table.map.derivative(np.clip(theta, low, high))
            moved = LIFT * (TWO_PI + np.abs(values)) * (1.0 + 1.0 / np.abs(slope))
            slope, error = slope_and_error_beside(self.table.map, theta, moved, low, high)
            lowest = np.abs(slope) - error
            bound = np.where(
                lowest > 0.0, error / (np.abs(slope) * lowest), np.inf
            ) + LIFT / np.abs(slope)
            return np.where(high > low, 1.0 / slope, 0.0), np.where(high > low, bound, 0.0)


@dataclass(frozen=True, eq=False)
class _Stage:
    """One map of a composite: its argument ``angle``, kept in [low, high], its image, and the whole
    turns that were taken off up to there.
    """

    map: CircleMap
    angle: Array
    low: Array
    high: Array
    image: Array
    turns: Array


@dataclass(frozen=True, eq=False)
class CompositeLift(MadeLift):
    """θ → F_k(… F_2(F_1(θ))). Whole turns are taken off between the maps and carried apart.

    So no digits are lost on long orbits, and beside a break of the composite each map is used on
    that side of its own break on which the image truly lies, however rounding moves it. ``breaks``
    are sorted, in [0, 2π).

    guards : for each map (turns, low, high) of shape (pieces,): on piece p of the composite its
        argument less 2π·turns[p] lies in [low[p], high[p]], between two of its breaks; None for a
        map without breaks, or the first.
    """

    maps: tuple[CircleMap, ...]
    guards: tuple[tuple[Array, Array, Array] | None, ...]
    breaks: Array
    has_scalar = True

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta``, radians."""
        for stage in self._stages(theta):
            image = stage.image + TWO_PI * stage.turns
        return image

    def derivative(self, theta: Array) -> Array:
        """Its slope by the chain rule."""
        product = np.ones_like(theta)
        for stage in self._stages(theta):
            product = product * stage.map.derivative(stage.angle)
        return product

    def derivative_and_error(self, theta: Array) -> tuple[Array, Array]:
        """The same and a bound on its error: those of the slopes, at angles that rounding has
        moved.
        """
        product = np.ones_like(theta)
        error = np.zeros_like(theta)
        moved = 0.5 * np.spacing(np.abs(theta))
        for stage in self._stages(theta):
            slope, off = slope_and_error_beside(
                stage.map, stage.angle, moved, stage.low, stage.high
            )
            error = (
                np.abs(product) * off
                + error * (np.abs(slope) + off)
                + EPS * np.abs(product * slope)
            )
            moved = moved * (np.abs(slope) + off) + LIFT * (TWO_PI + np.abs(stage.image))
            product = product * slope
        return product, error

    def _stages(self, theta: Array) -> Iterator[_Stage]:
        angle, turns = within_turn(theta)
        piece = np.searchsorted(self.breaks, angle, side="right")
        low = np.full_like(angle, -np.inf)
        high = -low
        for circle_map, guard in zip(self.maps, self.guards, strict=True):
            if guard is None:
                angle, whole = within_turn(angle)
                stage_low, stage_high = low, high
            else:
                whole, stage_low, stage_high = (column[piece] for column in guard)
                angle = np.clip(angle - TWO_PI * whole, stage_low, stage_high)
            image = circle_map(angle)
            turns = (turns + whole) * float(circle_map.degree)
            yield _Stage(circle_map, angle, stage_low, stage_high, image, turns)
            angle = image

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        breaks: list[float] = self.breaks.tolist()
        rows = [
            (
                circle_map.scalar(),
                circle_map.degree,
                list(zip(*(column.tolist() for column in guard or ()), strict=True)),
            )
            for circle_map, guard in zip(self.maps, self.guards, strict=True)
        ]

        def lift(theta: float) -> float:
            turns = floor(theta / TWO_PI)
            angle = theta - TWO_PI * turns
            piece = bisect_right(breaks, angle)
            for step, degree, guard in rows:
                if guard:
                    whole, low, high = guard[piece]
                    angle = min(max(angle - TWO_PI * whole, low), high)
                else:
                    whole = floor(angle / TWO_PI)
                    angle -= TWO_PI * whole
                angle = step(angle)
                turns = (turns + whole) * degree
            return angle + TWO_PI * turns

        return lift


MAX_ITERATES = 250_000
_GRID = even_angles(2048)


def compose(outer: CircleMap, inner: CircleMap) -> CircleMap:
    """The composition of two maps, θ → outer(inner(θ)).

    Parameters
    ----------
    outer : CircleMap
        The map that comes second.
    inner : CircleMap
        The map that comes first; its degree times that of ``outer`` is the composite's.

    Returns
    -------
    CircleMap
        θ → outer(inner(θ)).

    Raises
    ------
    ConvergenceError
        When the composite has more than 250,000 breaks.

    Notes
    -----
    Breaks: those of ``inner`` and the preimages under it of those of ``outer``, on each side of
    which the composite keeps to its own side of the outer break. ``max_error`` is E_outer +
    L·E_inner with L the largest |outer'| at 2,048 angles: measured, and good where ``outer``
    has no jump within E_inner. Samples are not kept: ``pieces`` is None.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, compose
    >>> doubled = compose(CircleMap.blaschke([0, 0]), CircleMap.rigid(0.25))
    >>> doubled.degree, round(float(doubled(0.0)), 6)
    (2, 3.141593)
    """
    require_map(outer)
    require_map(inner)
    breaks = _breaks_before(inner, outer.breaks, 1)
    return _composite([inner, outer], breaks, _error_after(outer, inner.max_error))


def nth_iterate(circle_map: CircleMap, n: int) -> CircleMap:
    """The n-th iterate Fⁿ of a map; F⁰ is the identity.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    n : int
        How often it is applied, 0 or more.

    Returns
    -------
    CircleMap
        Breaks, derivative and ``max_error`` as in ``compose``, one after the other.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, nth_iterate
    >>> nth_iterate(CircleMap.blaschke([0, 0]), 5).degree
    32
    """
    require_map(circle_map)
    count = whole_number("n", n, least=0)
    require_room("the iterate", count, "iterate less often", MAX_ITERATES)
    if count == 0:
        return CircleMap.rigid(0.0)
    if count == 1:
        return circle_map
    error = circle_map.max_error
    for _ in range(count - 1):
        error = _error_after(circle_map, error)
    breaks = _breaks_before(circle_map, circle_map.breaks, count - 1)
    return _composite([circle_map] * count, breaks, error)


def conjugate(circle_map: CircleMap, angle: float) -> CircleMap:
    """The same map seen turned, R∘F∘R⁻¹ with R a rotation: θ → F(θ - angle) + angle.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    angle : float
        What R turns by, radians.

    Returns
    -------
    CircleMap
        The conjugate map.

    Notes
    -----
    Breaks move along by ``angle``; multipliers, rotation number and ``max_error`` stay. A
    sampled map stays sampled.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, conjugate
    >>> round(float(conjugate(CircleMap.arnold(0.0, 0.5), 1.0)(1.0)), 12)
    1.0
    """
    require_map(circle_map)
    turn = finite_number("angle", angle)
    return _moved(circle_map, turn, turn)


def shifted(circle_map: CircleMap, turns: int) -> CircleMap:
    """Another lift of the same circle map, F + 2π·turns.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    turns : int
        Whole turns that are added.

    Returns
    -------
    CircleMap
        The other lift; a sampled map stays sampled.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, shifted
    >>> round(float(shifted(CircleMap.rigid(0.25), -1)(0.0)), 6)
    -4.712389
    """
    require_map(circle_map)
    return _moved(circle_map, 0.0, TWO_PI * whole_number("turns", turns))


def _moved(circle_map: CircleMap, along: float, up: float) -> CircleMap:
    """θ → F(θ - along) + up."""
    breaks = np.unique(base_angles(circle_map.breaks + along))
    if circle_map.pieces is not None:
        cubic = circle_map.pieces.shifted(along, up)
        return CircleMap.from_pieces(cubic, breaks, circle_map.samples, circle_map.max_error)
    back = CircleMap.rigid(-along / TWO_PI)
    forth = CircleMap.rigid(up / TWO_PI)
    return _composite([back, circle_map, forth], breaks, circle_map.max_error)


def inverse(circle_map: CircleMap) -> CircleMap:
    """The inverse F⁻¹ of a monotone map of degree 1 or -1.

    Parameters
    ----------
    circle_map : CircleMap
        A monotone map of degree 1 or -1.

    Returns
    -------
    CircleMap
        F⁻¹, continuous from the right; its derivative 1/F'(F⁻¹).

    Raises
    ------
    InvalidInput
        For other degrees, and when F folds or jumps backwards: use ``branches`` then.

    Notes
    -----
    Homeomorphisms are inverted to rounding. Where F jumps its inverse is constant, along the
    whole gap; where F is constant its inverse jumps: F⁻¹(F(θ)) = θ off the plateaus, and
    F(F⁻¹(y)) = y for every y that F takes. Breaks: the images of the breaks, both sides of a
    jump, and the levels of plateaus. The derivative is inf where F' = 0. ``max_error`` is the
    most that F⁻¹ moves when y moves by that of F, measured at 2,048 angles and the breaks.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, inverse
    >>> map_there = CircleMap.arnold(0.2, 0.9)
    >>> bool(abs(inverse(map_there)(map_there(1.0)) - 1.0) < 1e-14)
    True
    """
    require_map(circle_map)
    degree = circle_map.degree
    error = circle_map.max_error
    if degree not in (1, -1):
        raise InvalidInput(
            f"the map has degree {degree}: only degree 1 or -1 has an inverse; preimages gives "
            "all of them"
        )
    parts = branches(circle_map)
    hint = "it has no inverse; branches inverts each monotone piece"
    for branch, after, jump in seams(parts, degree):
        if branch.direction == -degree:
            raise InvalidInput(f"F turns back on [{branch.start:.9g}, {branch.end:.9g}]: {hint}")
        if degree * jump < -JUMP:
            raise InvalidInput(f"F jumps back by {abs(jump):.6g} at θ = {after.start:.9g}: {hint}")
    lift, breaks = _inverse_lift(circle_map, parts)
    values = np.concatenate([_GRID, breaks])
    moved = float(np.max(np.abs(lift(values + error) - lift(values - error)))) if error else 0.0
    return CircleMap(lift, None, breaks, degree, max_error=moved)


def _inverse_lift(circle_map: CircleMap, parts: tuple[Branch, ...]) -> tuple[InverseLift, Array]:
    """The inverse and its breaks in [0, 2π)."""
    degree = circle_map.degree
    theta = np.concatenate([branch.table.theta for branch in parts])
    value = np.concatenate([branch.table.value for branch in parts])
    bent = value[distance_to_break(circle_map.breaks, theta) <= SNAP]
    levels = [branch.start_value for branch in parts if branch.direction == 0]
    breaks = np.unique(base_angles(np.append(bent, levels)))
    # On to where the next turn begins: a jump may lie there.
    theta = np.append(theta, theta[0] + TWO_PI)
    value = np.append(value, value[0] + TWO_PI * degree)
    rising = np.maximum.accumulate(degree * value)
    table = MonotoneTable(theta, degree * rising, degree, circle_map)
    return InverseLift(table), breaks[np.diff(breaks, prepend=-1.0) > SNAP]


def _composite(maps: list[CircleMap], breaks: Array, max_error: float) -> CircleMap:
    """The chain of ``maps``, the first applied first; ``breaks`` are all its breaks, in [0, 2π)."""
    guards: list[tuple[Array, Array, Array] | None] = [None]
    if breaks.size:
        edges = carried_round(breaks)
        angle = maps[0](0.5 * (edges[:-1] + edges[1:]))
    for circle_map in maps[1:]:
        own = circle_map.breaks
        if own.size == 0:
            guards.append(None)
        else:  # the argument lies, piece by piece, between the breaks on both sides of ``angle``
            base, turns = within_turn(angle)
            around = carried_round(own)
            above = around.searchsorted(base, side="right").clip(1, own.size + 1)
            margin = np.minimum(SIDE_STEP, 0.25 * (around[above] - around[above - 1]))
            guards.append((turns, around[above - 1] + margin, around[above] - margin))
        if breaks.size:
            angle = circle_map(within_turn(angle)[0])
    lift = CompositeLift(tuple(maps), tuple(guards), breaks)
    degree = math.prod(circle_map.degree for circle_map in maps)
    return CircleMap(lift, None, breaks, degree, max_error=max_error)


def _breaks_before(inner: CircleMap, levels: Array, cycles: int) -> Array:
    """The breaks of ``inner`` and the preimages of ``levels`` up to so many cycles back."""
    if levels.size == 0:
        return inner.breaks
    return pulled_back(inner, monotone_cells(inner, 1, 0.0), inner.breaks, levels, cycles)


def _error_after(outer: CircleMap, error: float) -> float:
    """What is left of ``error`` after ``outer``, which adds its own."""
    if error == 0.0:
        return outer.max_error
    sides = [
        outer.derivative(_GRID),
        outer.derivative(outer.breaks, -1),
        outer.derivative(outer.breaks, 1),
    ]
    steepest = float(np.max(np.abs(np.concatenate(sides))))
    return min(outer.max_error + steepest * error, sys.float_info.max)
