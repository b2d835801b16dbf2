"""Branches: the maximal monotone pieces of a lift over one turn, each with its inverse; preimages
on all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.checks import finite_array, finite_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import (
    JUMP,
    SIDE_STEP,
    SNAP,
    base_angles,
    distance_to_break,
)
from cyclemap.maps.lifts.scan import Cells, bracketed_root, monotone_cells, ranks


@dataclass(frozen=True, eq=False)
class MonotoneTable:
    """Nodes of a function that is monotone and continuous between neighbours.

    theta : shape (n,), radians, nondecreasing; value : shape (n,), monotone. An angle given twice
        is a jump, a value given twice a plateau. ``sign`` is 1 when the values rise, -1 when they
        fall. The inverse is the one that is continuous from the right: constant across a jump, at a
        plateau's level its far end.
    """

    theta: Array
    value: Array
    sign: int
    map: CircleMap

    def inverse(self, values: Array) -> Array:
        """The angle at which the function takes each of ``values``; values beyond the table give
        its ends.
        """
        wanted = self.sign * np.ravel(values)
        rising = self.sign * self.value
        cell = self.cell(np.ravel(values))
        low = self.theta[cell]
        high = self.theta[cell + 1]
        result = np.where(rising[cell] >= wanted, low, high)
        inside = np.flatnonzero(
            (rising[cell] < wanted) & (rising[cell + 1] > wanted) & (high > low)
        )
        if inside.size:
            level = wanted[inside]
            # At a break F has the value from the right, which belongs to the next branch.
            broken = distance_to_break(self.map.breaks, high[inside]) <= SNAP
            last = high[inside] - SIDE_STEP * broken
            result[inside] = bracketed_root(
                lambda x, index: self.sign * self.map(np.minimum(x, last[index])) - level[index],
                low[inside],
                high[inside],
            )
        return np.reshape(result, np.shape(values))

    def cell(self, values: Array) -> npt.NDArray[np.intp]:
        """The cell, between one node and the next, in which each of ``values`` is taken."""
        rising = self.sign * self.value
        side = "right" if self.sign > 0 else "left"
        after = np.searchsorted(rising, self.sign * values, side)  # type: ignore[call-overload]
        return np.asarray(np.clip(after - 1, 0, self.theta.size - 2))


TOUCH = 1e-12  # radians: a fold this near a level touches it
_SHORTEST_PLATEAU = 1e-5  # radians: a shorter constant piece belongs to its neighbour
# slopes below this, relative to 1 + |F|, are zero: what differences leave of a constant
_FLAT = 1e-11
_UNKNOWN = 2


@dataclass(frozen=True, eq=False)
class Branch:
    """A maximal interval on which a lift is continuous and monotone.

    Attributes
    ----------
    start, end : float
        Radians, 0 ≤ start < 2π, start < end ≤ start + 2π.
    start_value, end_value : float
        Radians, lifted: the limits of F at both ends from inside.
    direction : int
        1 rising, -1 falling, 0 constant (a plateau).
    table : MonotoneTable
        Nodes of F from start to end, for the inverse.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, branches
    >>> rising, falling = branches(CircleMap.arnold(0.0, 2.0))
    >>> rising.direction, falling.direction, round(rising.end - rising.start, 6)
    (1, -1, 4.18879)
    """

    start: float
    end: float
    start_value: float
    end_value: float
    direction: int
    table: MonotoneTable

    def inverse(self, values: ArrayLike) -> Array:
        """The angles in [start, end] at which F takes each of some values.

        Parameters
        ----------
        values : array_like
            Radians, lifted, any shape.

        Returns
        -------
        ndarray
            Radians. Exact to rounding: F there is ``values`` to about 1e-15, so the angle is
            good to 1e-15/|F'|.

        Raises
        ------
        InvalidInput
            For values outside the branch and on a plateau.
        ConvergenceError
            When F is not monotone.

        Examples
        --------
        >>> from cyclemap.maps import CircleMap, branches
        >>> rising = branches(CircleMap.arnold(0.0, 2.0))[0]
        >>> bool(abs(CircleMap.arnold(0.0, 2.0)(rising.inverse(3.0)) - 3.0) < 1e-14)
        True
        """
        wanted = finite_array("values", values)
        if self.direction == 0:
            raise InvalidInput(
                f"F is {self.start_value:.9g} all along this branch: a plateau has no inverse"
            )
        low, high = sorted((self.start_value, self.end_value))
        slack = 8.0 * EPS * (1.0 + max(abs(low), abs(high)))
        outside = (wanted < low - slack) | (wanted > high + slack)
        if np.any(outside):
            first = float(wanted[outside][0])
            raise InvalidInput(
                f"the value {first:.9g} is outside the branch: F runs from {low:.9g} to {high:.9g}"
            )
        return self.table.inverse(wanted)


def branches(circle_map: CircleMap) -> tuple[Branch, ...]:
    """The maximal monotone pieces of F over one turn, in order, the first starting in [0, 2π).

    Parameters
    ----------
    circle_map : CircleMap
        The map.

    Returns
    -------
    tuple of Branch
        In order, together one turn.

    Raises
    ------
    ConvergenceError
        When the map is too steep to be cut into cells.

    Notes
    -----
    Cut at folds, at jumps, at the ends of plateaus, and at kinks where the direction changes. A
    map without any cut is one branch, [0, 2π]. Complete down to the resolution, as
    ``monotone_cells``. Constant pieces shorter than 1e-5 radians join a neighbour.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, branches
    >>> cut = branches(CircleMap.arnold(0.2, 2.0))
    >>> [(round(branch.start, 6), round(branch.end, 6), branch.direction) for branch in cut]
    [(1.047198, 5.235988, 1), (5.235988, 7.330383, -1)]
    """
    require_map(circle_map)
    cells = monotone_cells(circle_map, 1, 0.0)
    first, last = cell_limits(circle_map, cells)
    following = np.append(first[1:], first[0] + cells.climb)
    smooth_after = np.abs(following - last) <= JUMP
    last[smooth_after] = following[smooth_after]
    smooth = np.roll(smooth_after, 1)
    direction = _directions(cells, first, last, smooth)
    cut = np.flatnonzero(~smooth | (direction != np.roll(direction, 1)))
    cut = cut if cut.size else np.array([0])
    # A branch may run on into the next turn.
    start, end = (np.append(nodes, nodes + TWO_PI) for nodes in (cells.start, cells.end))
    first, last = (np.append(values, values + cells.climb) for values in (first, last))
    made = []
    for a, b in zip(cut, np.append(cut[1:], cut[0] + cells.start.size), strict=True):
        sign = -1 if direction[a] < 0 else 1
        theta = np.append(start[a:b], end[b - 1])
        value = np.append(first[a:b], last[b - 1])
        rising = np.maximum.accumulate(sign * value)
        table = MonotoneTable(read_only(theta), read_only(sign * rising), sign, circle_map)
        ends = [float(column[place]) for column in (theta, value) for place in (0, -1)]
        made.append(Branch(ends[0], ends[1], ends[2], ends[3], int(direction[a]), table))
    return tuple(made)


def seams(parts: tuple[Branch, ...], degree: int) -> Iterator[tuple[Branch, Branch, float]]:
    """Each branch, the one after it, and by how much F jumps up between them, radians."""
    for branch, after in zip(parts, (*parts[1:], parts[0]), strict=True):
        climb = TWO_PI * degree if after is parts[0] else 0.0
        yield branch, after, after.start_value + climb - branch.end_value


def limit_at_break(circle_map: CircleMap, theta: Array, side: int) -> Array:
    """The limit of F at breaks ``theta`` from below (side -1) or above (1), to rounding.

    The map reads its one-sided limits a few roundings beside the break; to first order that is
    taken back here.
    """
    limit = circle_map.right(theta) if side > 0 else circle_map.left(theta)
    return limit - side * SIDE_STEP * circle_map.derivative(theta, side)


def cell_limits(circle_map: CircleMap, cells: Cells) -> tuple[Array, Array]:
    """F at the start and at the end of each of its cells, its own limit where a break lies
    there.
    """
    first = cells.g_start.copy()
    last = cells.g_end.copy()
    before = np.roll(cells.cut, -1)
    if np.any(cells.cut):
        start = cells.start[cells.cut]
        end = cells.end[before]
        own = circle_map(start)
        right = circle_map.right(start)
        first[cells.cut] = np.where(np.abs(own - right) <= JUMP, own, right)
        last[before] = limit_at_break(circle_map, end, -1)
    return first, last


def _directions(cells: Cells, first: Array, last: Array, smooth: Mask) -> Whole:
    """1, -1 or 0 for each cell; one too flat to tell goes with the cell it continues."""
    scale = 1.0 + np.abs(first)
    still = np.abs(last - first) <= 64.0 * EPS * scale
    steepest = np.maximum(np.abs(cells.slope_start), np.abs(cells.slope_end))
    constant = still & (steepest <= _FLAT * scale) & (cells.end - cells.start > _SHORTEST_PLATEAU)
    direction = np.where(still, _UNKNOWN, np.sign(last - first)).astype(np.int64)
    direction[constant] = 0
    for i in np.flatnonzero(direction == _UNKNOWN):
        if smooth[i]:
            direction[i] = direction[i - 1]
    for i in np.flatnonzero(direction == _UNKNOWN)[::-1]:
        after = (i + 1) % cells.start.size
        direction[i] = direction[after] if smooth[after] else 0
    return np.where(direction == _UNKNOWN, 0, direction)


def preimages(circle_map: CircleMap, angle: float) -> Array:
    """All θ in [0, 2π) that a map carries to one angle.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    angle : float
        Radians, any turn.

    Returns
    -------
    ndarray, shape (n,)
        All θ with F(θ) = angle mod 2π, radians, sorted, each once.

    Raises
    ------
    InvalidInput
        When F is ``angle`` along a whole plateau, for then they cannot be listed.

    Notes
    -----
    Solved to rounding on each branch. A fold within 1e-12 radians of the angle is one preimage,
    never two and never none; at a jump F has the value from the right. Complete as ``branches``
    is.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, preimages
    >>> preimages(CircleMap.blaschke([0, 0]), 1.0).round(6).tolist()
    [0.5, 3.641593]
    """
    require_map(circle_map)
    wanted = finite_number("angle", angle)
    roots, flat = preimages_on(branches(circle_map), np.array([wanted]), circle_map.degree)
    if flat.size:
        raise InvalidInput(
            f"F is {wanted:.9g} (mod 2π) all along [{flat[0]:.9g}, {flat[1]:.9g}]: the preimages "
            "cannot be listed; branches gives the plateau"
        )
    return roots


def preimages_on(parts: tuple[Branch, ...], angles: Array, degree: int) -> tuple[Array, Array]:
    """The preimages of all ``angles`` on the branches of one map, sorted, and the ends of plateaus
    at one of them.
    """
    roots = [np.zeros(0)]
    plateaus = [np.zeros(0)]
    for index, (branch, after, jump) in enumerate(seams(parts, degree)):
        start = _turns_to(
            branch.start_value, angles, parts[index - 1].direction != branch.direction
        )
        end = _turns_to(branch.end_value, angles, False)
        if abs(jump) <= JUMP:  # both branches count from the same rounding
            end = _turns_to(after.start_value, angles, branch.direction != after.direction)
            end = end + degree * (after is parts[0])
        if branch.direction == 0:
            if np.any(start == np.round(start)):
                plateaus.append(np.array([branch.start, branch.end]))
            continue
        # The start of a branch belongs to it, its end to the next one.
        low = np.ceil(start) if branch.direction > 0 else np.floor(end) + 1.0
        high = np.ceil(end) - 1.0 if branch.direction > 0 else np.floor(start)
        count = np.maximum(high - low + 1.0, 0.0).astype(np.int64)
        owner = np.repeat(np.arange(angles.size), count)
        whole = low[owner] + ranks(count)
        # A touched fold may lie beyond its level by rounding: the table then gives the fold itself.
        roots.append(branch.table.inverse(angles[owner] + TWO_PI * whole))
    return np.sort(base_angles(np.concatenate(roots))), np.concatenate(plateaus)


def _turns_to(value: float, angles: Array, turns_back: bool) -> Array:
    """The turns from each angle to the value: whole ones where they are equal within the
    tolerance.
    """
    turns = (value - angles) / TWO_PI
    nearest = np.round(turns)
    tolerance = TOUCH if turns_back else 4.0 * EPS * (1.0 + abs(value))
    return np.where(np.abs(value - angles - TWO_PI * nearest) <= tolerance, nearest, turns)
