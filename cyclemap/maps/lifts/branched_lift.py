"""Lifts joined from branches, each a function on its own interval: the representation behind ``from_branches``."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from math import floor
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.lift_checks import SNAP, Lift, Scalar, base_angles, checked_call, differences_between

_SAME_VALUE = 1e-12  # relative: seams whose values differ by more are breaks
_SAME_SLOPE = 1e-9  # relative: seams whose slopes differ by more are breaks
_SAME_DIFFERENCE = 1e-6  # the same where a slope comes from differences


@dataclass(frozen=True, eq=False)
class Piece:
    """One branch: ``lift`` and ``derivative`` on [start, end], radians; ``exact`` when the derivative was given."""

    start: float
    end: float
    lift: Lift
    derivative: Lift
    exact: bool

    def at_ends(self) -> tuple[Array, Array]:
        """Values and slopes at both ends."""
        ends = np.array([self.start, self.end])
        return self.lift(ends), self.derivative(ends)


@dataclass(frozen=True, eq=False)
class BranchedLift:
    """The lift made of ``pieces`` in order on [0, 2π): piece i starts at ``starts[i]``, its own angle ``shift[i]`` on.

    ``starts`` has shape (n,), its first entry 0; ``shift`` holds whole turns.
    """

    starts: Array
    pieces: tuple[Piece, ...]
    shift: Array
    degree: int

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta`` (radians, any shape)."""
        return self._evaluate(theta, slope=False)

    def derivative(self, theta: Array) -> Array:
        """Its slope; at a seam the one from the right."""
        return self._evaluate(theta, slope=True)

    def _evaluate(self, theta: Array, slope: bool) -> Array:
        turns = np.floor(theta / TWO_PI)
        base = np.asarray(theta - TWO_PI * turns)
        owner = np.searchsorted(self.starts, base, side="right") - 1
        values = np.empty(np.shape(theta))
        for i, piece in enumerate(self.pieces):
            here = owner == i
            if here.any():
                own = np.minimum(np.maximum(base[here] + TWO_PI * self.shift[i], piece.start), piece.end)
                values[here] = piece.derivative(own) if slope else piece.lift(own)
        return values if slope else values + (TWO_PI * self.degree) * (turns - self.shift[owner])

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        starts, climb = self.starts.tolist(), TWO_PI * self.degree
        rows: list[tuple[Scalar, float, float, float, float]] = [
            (_for_one_float(piece), TWO_PI * shift, piece.start, piece.end, climb * shift)
            for piece, shift in zip(self.pieces, self.shift.tolist(), strict=True)
        ]

        def lift(theta: float) -> float:
            turns = floor(theta / TWO_PI)
            base = theta - TWO_PI * turns
            one, ahead, start, end, risen = rows[bisect_right(starts, base) - 1]
            return one(min(max(base + ahead, start), end)) + climb * turns - risen

        return lift


def lift_from_branches(branches: list[Any], degree: int) -> tuple[BranchedLift, Array]:
    """The lift on all branches, checked, and its breaks in [0, 2π): the seams where value or slope differ."""
    pieces = tuple(_piece(i, branch) for i, branch in enumerate(branches))
    _check_cover(pieces)
    seams = base_angles(np.array([piece.start for piece in pieces]))
    return _onto_one_turn(pieces, seams, degree), seams[_differing(pieces, degree)]


def listed_branches(branches: Any) -> list[Any]:
    """The branches as a list, or InvalidInput where there are none.

    >>> listed_branches([(0.0, 1.0, np.sin, None)])[0][:2]
    (0.0, 1.0)
    """
    try:
        given = list(branches)
    except TypeError as cause:
        raise InvalidInput(f"branches is {branches!r}: give a list of (start, end, lift, derivative)") from cause
    if not given:
        raise InvalidInput("branches is empty: give at least one (start, end, lift, derivative)")
    return given


def _piece(index: int, branch: Any) -> Piece:
    try:
        start, end, lift, derivative = branch
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"branch {index} is {branch!r}: give (start, end, lift, derivative or None)") from cause
    first, last = finite_number(f"start of branch {index}", start), finite_number(f"end of branch {index}", end)
    if not callable(lift) or not (derivative is None or callable(derivative)):
        raise InvalidInput(f"branch {index} has {lift!r}, {derivative!r}: lift and derivative must be callables")
    if not first < last:
        raise InvalidInput(f"branch {index} runs from {first:.12g} to {last:.12g}: its end must lie after its start")

    def by_differences(theta: Array) -> Array:
        return differences_between(lift, theta, theta - first, last - theta)[0]

    piece = Piece(first, last, lift, by_differences if derivative is None else derivative, derivative is not None)
    ends = np.array([piece.start, piece.end])
    with np.errstate(all="ignore"):
        checked_call(f"lift of branch {index}", piece.lift, ends)
        checked_call(f"derivative of branch {index}", piece.derivative, ends)
    return piece


def _check_cover(pieces: tuple[Piece, ...]) -> None:
    for i in range(1, len(pieces)):
        gap = pieces[i].start - pieces[i - 1].end
        if abs(gap) > SNAP:
            kind = "a gap" if gap > 0.0 else "an overlap"
            raise InvalidInput(
                f"branch {i} starts at {pieces[i].start:.12g} but branch {i - 1} ends at {pieces[i - 1].end:.12g}: "
                f"{kind} of {abs(gap):.3g}; each branch must start where the one before it ends"
            )
    span = pieces[-1].end - pieces[0].start
    if abs(span - TWO_PI) > 4.0 * SNAP:
        raise InvalidInput(f"the branches span {span:.12g} radians: together they must cover one turn, 2π")


def _differing(pieces: tuple[Piece, ...], degree: int) -> list[bool]:
    """Whether value or slope differ at the start of each branch from those at the end of the one before."""
    ends = [piece.at_ends() for piece in pieces]
    found = []
    for i, piece in enumerate(pieces):
        climb = TWO_PI * degree if i == 0 else 0.0
        before, after = ends[i - 1][0][1] - climb, ends[i][0][0]
        slope_before, slope_after = ends[i - 1][1][1], ends[i][1][0]
        allowed = _SAME_SLOPE if piece.exact and pieces[i - 1].exact else _SAME_DIFFERENCE
        jumps = abs(after - before) > _SAME_VALUE * (1.0 + abs(after))
        kinks = abs(slope_after - slope_before) > allowed * (1.0 + abs(slope_after))
        found.append(bool(jumps or kinks))
    return found


def _onto_one_turn(pieces: tuple[Piece, ...], seams: Array, degree: int) -> BranchedLift:
    """Move the branches to [0, 2π): the one that runs over 2π serves both at its end and at its start."""
    shift = np.round((np.array([piece.start for piece in pieces]) - seams) / TWO_PI)
    order = np.argsort(seams, kind="stable")
    starts, shift = seams[order], shift[order]
    placed = tuple(pieces[i] for i in order)
    if starts[0] > 0.0:
        starts, shift = np.append(0.0, starts), np.append(shift[-1] + 1.0, shift)
        placed = (placed[-1], *placed)
    return BranchedLift(starts, placed, shift, degree)


def _for_one_float(piece: Piece) -> Scalar:
    """The branch for one python float: called with it directly where that gives the same values, else by array."""
    lift: Any = piece.lift
    probes = [piece.start, 0.5 * (piece.start + piece.end), piece.end]
    try:
        plain = [lift(x) for x in probes]
        if all(isinstance(y, float) for y in plain) and plain == [float(lift(np.asarray(x))) for x in probes]:
            return lambda x: float(lift(x))
    except (TypeError, ValueError, IndexError, AttributeError):
        pass
    return lambda x: float(lift(np.asarray(x)))
