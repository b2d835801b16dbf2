"""Lifts made of pieces: cubics through samples, and functions that each have an interval of their
own.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import floor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.checks import finite_array, finite_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import SAME_ANGLE
from cyclemap.maps.lifts.lift_checks import (
    SNAP,
    Index,
    Lift,
    MadeLift,
    Scalar,
    base_angles,
    checked_call,
    differences_between,
    with_rounding,
    within_turn,
)


@dataclass(frozen=True, eq=False)
class PiecewiseCubic(MadeLift):
    """A lift made of cubics on [0, 2π): piece i is Σ_j coefficients[j, i] (θ - knots[i])^j.

    ``knots`` has shape (n + 1,), from 0 to 2π; ``coefficients`` has shape (4, n).
    """

    knots: Array
    coefficients: Array
    degree: int
    has_scalar = True

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta``, radians."""
        piece, offset, turns = self._locate(theta)
        c0, c1, c2, c3 = (row[piece] for row in self.coefficients)
        value = ((c3 * offset + c2) * offset + c1) * offset + c0
        return np.asarray(value + (TWO_PI * self.degree) * turns)

    def derivative(self, theta: Array) -> Array:
        """Its slope."""
        piece, offset, _ = self._locate(theta)
        _, c1, c2, c3 = (row[piece] for row in self.coefficients)
        return np.asarray((3.0 * c3 * offset + 2.0 * c2) * offset + c1)

    def derivative_and_error(self, theta: Array) -> tuple[Array, Array]:
        """Its slope and what rounding makes of it."""
        return with_rounding(self.derivative(theta))

    def surely_rises(self) -> bool:
        """Whether no cubic falls, as its slope's coefficients in Bernstein's polynomials tell:
        where they do not, it may rise all the same.
        """
        _, first, second, third = self.coefficients
        width = np.diff(self.knots)
        middle = first + second * width
        last = middle + (second + 3.0 * third * width) * width
        return bool(np.min([first, middle, last]) >= 0.0)

    def _locate(self, theta: Array) -> tuple[Index, Array, Array]:
        base, turns = within_turn(theta)
        piece = np.searchsorted(self.knots, base, side="right") - 1
        piece = np.clip(piece, 0, self.knots.size - 2)
        return piece, base - self.knots[piece], turns

    def scalar(self) -> Scalar:
        """The same lift for one python float, without numpy's overhead."""
        knots: list[float] = self.knots.tolist()
        last = self.knots.size - 2
        rows: list[list[float]] = self.coefficients.T.tolist()
        climb = TWO_PI * self.degree

        def lift(theta: float) -> float:
            turns = floor(theta / TWO_PI)
            base = theta - TWO_PI * turns
            piece = bisect_right(knots, base) - 1
            if piece > last:
                piece = last
            offset = base - knots[piece]
            c0, c1, c2, c3 = rows[piece]
            return ((c3 * offset + c2) * offset + c1) * offset + c0 + climb * turns

        return lift

    def shifted(self, along: float, up: float) -> PiecewiseCubic:
        """θ → F(θ - along) + up, the same cubics at other places (radians)."""
        rows = self.coefficients.copy()
        rows[0] += up
        return _onto_base_period(self.knots[:-1] + along, rows, self.degree)

    def blended(self, other: PiecewiseCubic, share: float) -> PiecewiseCubic:
        """θ → (1 - share) F(θ) + share G(θ), cubics between the knots of both; G of F's degree."""
        knots = np.union1d(self.knots, other.knots)
        rows = (1.0 - share) * self._rows_at(knots[:-1])
        rows += share * other._rows_at(knots[:-1])
        return PiecewiseCubic(read_only(knots), read_only(rows), self.degree)

    def _rows_at(self, knots: Array) -> Array:
        """(4, n): the coefficients about each of ``knots`` in [0, 2π)."""
        piece, offset, _ = self._locate(knots)
        return _moved_along(self.coefficients[:, piece], offset)


def cubic_from_samples(
    theta: ArrayLike, lifted: ArrayLike, slopes: ArrayLike | None, degree: int
) -> tuple[PiecewiseCubic, Array]:
    """The piecewise cubic through the samples, and its breaks in [0, 2π)."""
    (angle, value, tangent), closed = _one_period(*_checked(theta, lifted, slopes), degree)
    nodal = _shape_preserving(angle, value, closed, degree) if slopes is None else tangent
    use = np.diff(angle) > 0.0
    width = np.diff(angle)[use]
    rise = np.diff(value)[use]
    left = value[:-1][use]
    slope_left = nodal[:-1][use]
    slope_right = nodal[1:][use]
    secant = rise / width
    c2 = (3.0 * secant - 2.0 * slope_left - slope_right) / width
    c3 = (slope_left + slope_right - 2.0 * secant) / width**2
    pieces = _onto_base_period(angle[:-1][use], np.stack([left, slope_left, c2, c3]), degree)
    inner = angle[1:][~use]
    breaks = inner if closed else np.append(inner, angle[0])
    return pieces, np.unique(base_angles(breaks))


def _checked(
    theta: ArrayLike, lifted: ArrayLike, slopes: ArrayLike | None
) -> tuple[Array, Array, Array | None]:
    angles = finite_array("theta", theta, ndim=1)
    values = finite_array("lifted", lifted, ndim=1)
    given = None if slopes is None else finite_array("slopes", slopes, ndim=1)
    if values.shape != angles.shape or (given is not None and given.shape != angles.shape):
        raise InvalidInput(f"theta has {angles.size} samples: lifted and slopes must have as many")
    if angles.size < 3:
        raise InvalidInput(f"theta has {angles.size} samples: give at least 3")
    steps = np.diff(angles)
    if np.any(steps < 0.0):
        raise InvalidInput(
            f"theta decreases after entry {int(np.argmax(steps < 0.0))}: sort the samples"
        )
    near = (steps > 0.0) & (steps < SAME_ANGLE)
    if np.any(near):
        raise InvalidInput(
            f"theta holds two angles {steps[near][0]:.3g} radians apart: give one of them, or one "
            "angle twice for a break"
        )
    if np.any((steps[1:] == 0.0) & (steps[:-1] == 0.0)):
        raise InvalidInput(
            "theta holds one angle three times: a break is one angle twice (left, right)"
        )
    if angles[-1] - angles[0] > TWO_PI + 1e-9:
        raise InvalidInput(
            f"theta spans {angles[-1] - angles[0]:g}: the samples must cover one turn, 2π"
        )
    return angles, values, given


def _one_period(
    angles: Array, values: Array, slopes: Array | None, degree: int
) -> tuple[Array, bool]:
    """(3, m): angles, values and slopes from the right side of the first angle to the left side of
    it plus 2π.

    An angle given twice holds its left entry first. True if the end point is the same smooth point
    as the first.
    """
    tangents = np.zeros_like(angles) if slopes is None else slopes
    table = np.stack([angles, values, tangents])
    climb = np.array([TWO_PI, TWO_PI * degree, 0.0])
    inner = angles < angles[0] + TWO_PI - 1e-9
    doubled = bool(angles[1] == angles[0])
    end = table[:, 0] + climb
    if not inner[-1] and not doubled:
        end = table[:, np.argmin(inner)]
    elif not inner[-1] and abs(values[-1] - end[1]) > 1e-9:
        raise InvalidInput(
            f"the end point holds {values[-1]:g}, the left entry of its angle {end[1]:g}"
        )
    table = table[:, inner][:, int(doubled) :]
    end[0] = table[0, 0] + TWO_PI
    gap = np.abs(end - table[:, 0] - climb)
    smooth = bool(gap[1] <= 1e-12 * (1.0 + abs(end[1])) and (slopes is None or gap[2] <= 1e-9))
    return np.column_stack([table, end]), smooth and not doubled


def _shape_preserving(theta: Array, lifted: Array, closed: bool, degree: int) -> Array:
    """Slopes that keep monotone data monotone (Fritsch & Butland 1984), on each branch between
    breaks.
    """
    count = theta.size
    if closed:  # as it goes on in the turns before and after
        climb = TWO_PI * degree
        theta = np.concatenate([theta[:-1] - TWO_PI, theta, theta[1:] + TWO_PI])
        lifted = np.concatenate([lifted[:-1] - climb, lifted, lifted[1:] + climb])
    cuts = np.flatnonzero(np.diff(theta) == 0.0) + 1
    branches = zip(np.split(theta, cuts), np.split(lifted, cuts), strict=True)
    slopes = np.concatenate([_pchip_slopes(*branch) for branch in branches])
    return slopes[count - 1 : 2 * count - 1] if closed else slopes


def _pchip_slopes(x: Array, y: Array) -> Array:
    if x.size == 1:
        raise InvalidInput(
            f"theta has a break at {x[0]:g} with no sample beside it: add one on each side"
        )
    # Imported where it is needed: it takes longer to load than most maps take to build.
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(x, y).derivative()(x), dtype=np.float64)


def _moved_along(rows: Array, step: Array) -> Array:
    """Coefficients (4, ...) of the same cubics about places ``step`` (...) further along."""
    c0, c1, c2, c3 = rows
    value = ((c3 * step + c2) * step + c1) * step + c0
    slope = (3.0 * c3 * step + 2.0 * c2) * step + c1
    return np.stack([value, slope, c2 + 3.0 * c3 * step, c3])


def _onto_base_period(start: Array, rows: Array, degree: int) -> PiecewiseCubic:
    """Move the pieces to [0, 2π), cutting the one that runs over 2π."""
    base = base_angles(start)
    turns = np.round((start - base) / TWO_PI)
    rows = rows.copy()
    rows[0] -= TWO_PI * degree * turns
    order = np.argsort(base, kind="stable")
    base = base[order]
    rows = rows[:, order]
    if base[0] > 0.0:
        wrapped = _moved_along(rows[:, -1], TWO_PI - base[-1])
        wrapped[0] -= TWO_PI * degree
        base = np.append(0.0, base)
        rows = np.column_stack([wrapped, rows])
    return PiecewiseCubic(read_only(np.append(base, TWO_PI)), read_only(rows), degree)


_SAME_VALUE = 1e-12  # relative: seams whose values differ by more are breaks
_SAME_SLOPE = 1e-9  # relative: seams whose slopes differ by more are breaks
_SAME_DIFFERENCE = 1e-6  # the same where a slope comes from differences


@dataclass(frozen=True, eq=False)
class Piece:
    """One branch on [start, end], radians, ``shift`` turns ahead of where it lies in [0, 2π)."""

    start: float
    end: float
    lift: MadeLift
    shift: float = 0.0


@dataclass(frozen=True, eq=False)
class GivenBranch(MadeLift):
    """A function that was given for [start, end] only, with its slope or None for differences."""

    lift: Lift
    slope: Lift | None
    start: float
    end: float

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta``, radians."""
        return self.lift(theta)

    def derivative_and_error(self, theta: Array) -> tuple[Array, Array]:
        """Its slope, told from inside the interval, and a bound on the slope's error."""
        if self.slope is None:
            return differences_between(self.lift, theta, theta - self.start, self.end - theta)
        return with_rounding(self.slope(theta))


@dataclass(frozen=True, eq=False)
class BranchedLift(MadeLift):
    """The lift made of ``pieces`` in order on [0, 2π): piece i starts at ``starts[i]``, the first
    at 0.
    """

    starts: Array
    pieces: tuple[Piece, ...]
    degree: int
    has_scalar = True

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta``, radians."""
        values = np.empty(np.shape(theta))
        for piece, own, turns, here in self._parts(theta):
            values[here] = piece.lift(own) + (TWO_PI * self.degree) * (turns - piece.shift)
        return values

    def derivative_and_error(self, theta: Array) -> tuple[Array, Array]:
        """Its slope, at a seam the one from the right, and a bound on the slope's error."""
        slope = np.empty(np.shape(theta))
        error = np.empty(np.shape(theta))
        for piece, own, _, here in self._parts(theta):
            slope[here], error[here] = piece.lift.derivative_and_error(own)
        return slope, error

    def _parts(self, theta: Array) -> Iterator[tuple[Piece, Array, Array, Mask]]:
        """Each piece that owns some of the angles, those as its own, their turns, and where they
        are.
        """
        base, turns = within_turn(theta)
        owner = np.searchsorted(self.starts, base, side="right") - 1
        for index, piece in enumerate(self.pieces):
            here = owner == index
            if here.any():
                own = np.clip(base[here] + TWO_PI * piece.shift, piece.start, piece.end)
                yield piece, own, turns[here], here

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        starts = self.starts.tolist()
        climb = TWO_PI * self.degree
        rows = [
            (piece.lift.scalar(), TWO_PI * piece.shift, piece.start, piece.end, climb * piece.shift)
            for piece in self.pieces
        ]

        def lift(theta: float) -> float:
            turns = floor(theta / TWO_PI)
            base = theta - TWO_PI * turns
            branch, ahead, start, end, risen = rows[bisect_right(starts, base) - 1]
            return branch(min(max(base + ahead, start), end)) + climb * turns - risen

        return lift


def lift_from_branches(branches: Any, degree: int) -> tuple[BranchedLift, Array]:
    """The lift on all branches, checked, and its breaks in [0, 2π): the seams where value or slope
    differ.
    """
    if not isinstance(branches, list) or not branches:
        raise InvalidInput(
            f"branches is {branches!r}: give a list of (start, end, lift, derivative), at least one"
        )
    pieces = [_piece(index, branch) for index, branch in enumerate(branches)]
    _refuse_gaps(pieces)
    exact = np.array([derivative is not None for _, _, _, derivative in branches])
    seams = base_angles(np.array([piece.start for piece in pieces]))
    return on_base_turn(pieces, degree), seams[_differing(pieces, exact, degree)]


def on_base_turn(pieces: list[Piece], degree: int) -> BranchedLift:
    """The lift made of pieces of one turn, in order, each starting where the one before ends."""
    given = np.array([piece.start for piece in pieces])
    seams = base_angles(given)
    shift = np.round((given - seams) / TWO_PI)
    order = np.argsort(seams, kind="stable")
    starts = seams[order]
    placed = [replace(pieces[index], shift=float(shift[index])) for index in order]
    if starts[0] > 0.0:  # the one that runs over 2π serves both at its end and at its start
        starts = np.append(0.0, starts)
        placed.insert(0, replace(placed[-1], shift=placed[-1].shift + 1.0))
    return BranchedLift(starts, tuple(placed), degree)


def _refuse_gaps(pieces: list[Piece]) -> None:
    for i, (before, after) in enumerate(pairwise(pieces), 1):
        gap = after.start - before.end
        if abs(gap) > SNAP:
            kind = "a gap" if gap > 0.0 else "an overlap"
            raise InvalidInput(
                f"branch {i} starts at {after.start:.12g} but branch {i - 1} ends at "
                f"{before.end:.12g}: {kind} of {abs(gap):.3g}; each branch must start where "
                "the one before it ends"
            )
    span = pieces[-1].end - pieces[0].start
    if abs(span - TWO_PI) > 4.0 * SNAP:
        raise InvalidInput(
            f"the branches span {span:.12g} radians: together they must cover one turn, 2π"
        )


def _piece(index: int, branch: Any) -> Piece:
    try:
        start, end, lift, derivative = branch
    except (TypeError, ValueError) as cause:
        raise InvalidInput(
            f"branch {index} is {branch!r}: give (start, end, lift, derivative or None)"
        ) from cause
    first = finite_number(f"start of branch {index}", start)
    last = finite_number(f"end of branch {index}", end)
    if not callable(lift) or not (derivative is None or callable(derivative)):
        raise InvalidInput(
            f"branch {index} has {lift!r}, {derivative!r}: lift and derivative must be callables"
        )
    if not first < last:
        raise InvalidInput(
            f"branch {index} runs from {first:.12g} to {last:.12g}: its end must lie after its "
            "start"
        )

    made = GivenBranch(lift, derivative, first, last)
    ends = np.array([first, last])
    with np.errstate(all="ignore"):
        checked_call(f"lift of branch {index}", lift, ends)
        checked_call(f"derivative of branch {index}", made.derivative, ends)
    return Piece(first, last, made)


def _differing(pieces: list[Piece], exact: Mask, degree: int) -> Mask:
    """Whether value or slope differ at the start of each branch from those at the end of the one
    before; ``exact`` where the slopes are no differences.
    """
    edges = [(piece.lift, np.array([piece.start, piece.end])) for piece in pieces]
    ends = np.array([[lift(edge), lift.derivative(edge)] for lift, edge in edges])
    after = ends[:, :, 0]
    before = np.roll(ends[:, :, 1], 1, axis=0)
    before[0, 0] -= TWO_PI * degree
    slopes = np.where(exact & np.roll(exact, 1), _SAME_SLOPE, _SAME_DIFFERENCE)
    allowed = np.stack([np.full(exact.size, _SAME_VALUE), slopes], axis=1)
    return np.asarray(np.any(np.abs(after - before) > allowed * (1.0 + np.abs(after)), axis=1))
