"""Measured pairs (θ0, next θ0), from tables of orientations alone."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.evidence.tables.columns import Convention, convention_of
from cyclemap.text_files import CsvTable, read_csv_table, require_columns

STAIRCASE_COLUMNS = ("rep", "theta0_accum_deg", "theta0_mod360_deg", "dtheta_to_next_deg", "flag")
PAIR_COLUMNS = ("theta0_deg", "theta_next_deg")

# Angles of fewer rows may lie within a few degrees of each other by chance.
# They are read as radians where they come near a turn, and, but for rounding, not beyond.
_TELLING = 8
_NEARLY_A_TURN = 5.0
_HALF_A_TURN = 1.001 * math.pi
# Figures in a staircase file are rounded to 0.001 degrees, three of them enter each comparison.
_CONSISTENT = math.radians(0.005)
# Pairs are in order where their usual gap is less than this part of what turns vary by; gaps beyond
# so many are told.
_ENOUGH = 20
_SMALL_GAP = 0.2
_LARGE_GAP = 8.0
# Turns by hand: from how near others are like them, how many of these it takes, how far off a
# hand's is (rad), and how many there may be.
_NEARBY = math.radians(10.0)
_FEWEST_NEARBY = 4
_FAR_OFF = 8.0
_LEAST_BY_HAND = math.radians(12.0)
_MOST_BY_HAND = 0.04
# How alike a column's name and theta_next_deg are where it is likely meant; theta1_deg is 0.75.
_NEARLY_THE_NAME = 0.85


@dataclass(frozen=True, eq=False)
class Theta0Pairs:
    """Measured steps of the cycle map.

    Parameters
    ----------
    theta : ndarray, shape (n,)
        Orientations before the pushes, rad.
    theta_next : ndarray, shape (n,)
        Orientations before the next ones, rad, lifted: `theta_next - theta` is the turn of that
        cycle.
    path : ndarray, shape (m,), optional
        The unwrapped θ0 of every push in order, rad, flagged ones too; None where order is
        unknown.
    dropped : mapping of str to int, optional
        How many pairs were left out, by reason.
    cycle : ndarray, shape (n,), optional
        The number of each pair's push; None where unknown.
    path_cycle : ndarray, shape (m,), optional
        That of each entry of `path`; None where unknown.
    moved : tuple of float, default ()
        Numbers of pushes behind which somebody moved the object: they make no pair, and the
        path breaks there.

    Raises
    ------
    InvalidInput
        For lists of different lengths, empty ones, and numbers that are not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs
    >>> theta = np.array([0.0, 0.4, 0.9, 1.5])
    >>> Theta0Pairs(theta[:-1], theta[1:], path=theta).turn.round(3).tolist()
    [0.4, 0.5, 0.6]
    """

    theta: Array
    theta_next: Array
    path: Array | None = None
    dropped: Mapping[str, int] = field(default_factory=dict)
    cycle: Array | None = None
    path_cycle: Array | None = None
    moved: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.theta.ndim != 1 or self.theta.shape != self.theta_next.shape or not self.theta.size:
            shapes = f"{self.theta.shape} and {self.theta_next.shape}"
            raise InvalidInput(
                f"theta and theta_next have shapes {shapes}; give two equally long lists"
            )
        if not (np.isfinite(self.theta).all() and np.isfinite(self.theta_next).all()):
            raise InvalidInput(
                "theta and theta_next hold a number that is not finite; remove those pairs"
            )
        for name, angles in (("cycle", self.theta), ("path_cycle", self.path)):
            cycle: Array | None = getattr(self, name)
            shape = None if angles is None else angles.shape
            if cycle is not None and (cycle.shape != shape or not np.isfinite(cycle).all()):
                shapes = f"{name} has shape {cycle.shape} for angles of shape {shape}"
                raise InvalidInput(f"{shapes}; give one number an angle")

    @classmethod
    def along(
        cls,
        path: Array,
        turn: Array,
        kept: Mask,
        cycle: Array,
        dropped: Mapping[str, int] | None = None,
    ) -> Theta0Pairs:
        """Return the pairs of pushes along a path (m,), rad, with their numbers (m,), by how far
        their cycles turned the object (n,), rad, n = m or m - 1; of those that are kept (n,).
        """
        start, own = (values[: turn.size][kept] for values in (path, cycle))
        return cls(start, start + turn[kept], path, dropped or {}, own, cycle)

    @property
    def turn(self) -> Array:
        """(n,) rad, how far each cycle turned the object."""
        return self.theta_next - self.theta

    @property
    def numbers(self) -> Array:
        """(n,) numbers of the pushes, from 0 where they are not told."""
        return np.arange(float(self.theta.size)) if self.cycle is None else self.cycle

    @property
    def unbroken(self) -> Theta0Pairs:
        """The same pairs with the longest stretch of the path in which each ends where the next
        begins.

        Beyond it stands what no map tells: the object moved by hand, or an orientation that was
        misread.
        """
        if (
            self.path is None
            or self.cycle is None
            or self.path_cycle is None
            or (np.diff(self.path_cycle) <= 0).any()
        ):
            return self
        # Where the next push stands in the path; one that is missing tells no gap.
        ahead = np.searchsorted(self.path_cycle, self.cycle + 1.0)
        known = np.isin(self.cycle + 1.0, self.path_cycle)
        if not known.any():
            return self
        gap = shorter_way(self.path[ahead[known]] - self.theta_next[known])
        by_hand = np.searchsorted(self.path_cycle, np.array(self.moved) + 1.0)
        broken = np.union1d(ahead[known][_is_large(gap)], by_hand).astype(np.int64)
        ends = np.concatenate([[0], broken, [self.path.size]])
        longest = int(np.argmax(np.diff(ends)))
        stretch = slice(int(ends[longest]), int(ends[longest + 1]))
        return replace(self, path=self.path[stretch], path_cycle=self.path_cycle[stretch])


def _is_large(gap: Array) -> Mask:
    """Which gaps are no mere error of measured orientations: the object was moved, or an
    orientation misread.
    """
    return np.abs(gap) > max(_CONSISTENT, _LARGE_GAP * float(np.median(np.abs(gap))))


def read_theta0_pairs(
    path: str | Path,
    *,
    angles: str | None = None,
    offset_deg: float | None = None,
) -> Theta0Pairs:
    """Read measured pairs from a CSV file, in one of three layouts told apart by the header.

    Parameters
    ----------
    path : str or Path
        The file.
    angles : str or None, optional
        How the file counts angles, as in `Convention`; None: what a collection.toml with the
        data says, else counter-clockwise. Orientations alone cannot tell.
    offset_deg : float or None, optional
        What it counts them from, as in `Convention`; None: what a collection.toml says, else 0.

    Returns
    -------
    Theta0Pairs
        The pairs, on the lift.

    Raises
    ------
    DataFileError
        Naming the file, the line and the mend.

    Notes
    -----
    - `rep,theta0_accum_deg,theta0_mod360_deg,dtheta_to_next_deg,flag`: a staircase; a row with a
      flag makes no pair and is counted in `dropped`; the last row has no next θ0.
    - `theta0_deg,theta_next_deg`: pairs; the turn is the shorter way round. They are in order where
      pairs begin where the one before ended (half of 20 or more within a fifth of what turns vary
      by, or all within 0.005 degrees), in any order else. Pairs of a row in order that begin
      elsewhere are warned of (`DoubtfulInput`).
    - `theta0_deg`: the pushes in order, numbered from 0; the turn is the shorter way round. A
      column beside it whose name is nearly theta_next_deg, or speaks of the next one, is refused.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> from cyclemap.evidence import read_theta0_pairs
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = pathlib.Path(place, "slate.csv").write_text("theta0_deg\\n0\\n10\\n25\\n")
    ...     pairs = read_theta0_pairs(f"{place}/slate.csv")
    >>> np.degrees(pairs.turn).round(6).tolist()
    [10.0, 15.0]
    """
    return pairs_in_table(read_csv_table(path), convention_of(path, angles, None, offset_deg))


def pairs_in_table(table: CsvTable, convention: Convention) -> Theta0Pairs:
    """Return the pairs of a table, as `read_theta0_pairs` does."""
    doubt_degrees(table, PAIR_COLUMNS)
    if "theta0_accum_deg" in table.header:
        return _from_staircase(table, convention)
    if "theta_next_deg" in table.header:
        return _from_pairs(table, convention)
    return _from_orientations(table, convention)


def _orientations(table: CsvTable, column: str, convention: Convention) -> Array:
    """A column of angles in degrees, rad in our convention."""
    return convention.theta(np.deg2rad(table.numbers(column)))


def _from_orientations(table: CsvTable, convention: Convention) -> Theta0Pairs:
    """Orientations in order; turns by hand make no pair."""
    ordered, ahead = PAIR_COLUMNS
    if ordered not in table.header:
        raise table.error(
            1,
            f"the header is {','.join(table.header)}; it must be "
            f"{','.join(STAIRCASE_COLUMNS)} or {','.join(PAIR_COLUMNS)} or {ordered} alone",
        )
    for name in table.header:
        if "next" in name or get_close_matches(name, (ahead,), cutoff=_NEARLY_THE_NAME):
            raise table.error(
                1,
                f"the header has {name} beside {ordered}: name it {ahead} if it is the next "
                "θ0 in degrees, or leave it out",
            )
    theta = _orientations(table, ordered, convention)
    if theta.size < 2:
        raise table.error(table.rows[0].line, "a single θ0 makes no pair; give at least two rows")
    turn = shorter_way(np.diff(theta))
    path = theta[0] + np.concatenate([[0.0], np.cumsum(turn)])
    cycle = np.arange(float(path.size))
    kept = ~moved_by_hand(path[:-1], turn)
    moved = tuple(cycle[:-1][~kept].tolist())
    if moved:
        where = ", ".join(f"{push:.0f}" for push in moved[:6])
        doubt = (
            f"{table.path}: turns behind pushes {where} (from 0) are like no others: taken as "
            "moved by hand, left out"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=4)
    dropped = {"moved by hand": len(moved)} if moved else {}
    return replace(Theta0Pairs.along(path, turn, kept, cycle, dropped), moved=moved)


def moved_by_hand(theta: Array, turn: Array) -> Mask:
    """Which turns (n,), rad, of cycles from orientations (n,), rad, are a hand's: few, and unlike
    those from nearby.

    Each is held against the median of four or more others from within 10 degrees; of a cycle that
    has no such neighbours nothing is said. Far is eight times what is usual, and 12 degrees at
    least. Where many are far, or cycles are few, none is a hand's.
    """
    none = np.zeros(turn.size, dtype=bool)
    off = np.full(turn.size, np.nan)
    order = np.argsort(np.mod(theta, TWO_PI), kind="stable")
    places = np.mod(theta, TWO_PI)[order]
    around = np.concatenate([places - TWO_PI, places, places + TWO_PI])
    turns = np.tile(turn[order], 3)
    low, high = (np.searchsorted(around, places + side * _NEARBY) for side in (-1.0, 1.0))
    for row, first, last in zip(order, low, high, strict=True):
        if last - first > _FEWEST_NEARBY:
            # A thousand neighbours tell as much as all.
            others = turns[first : last : max(1, (last - first) // 1000)]
            # The shorter way: of a hand's turn nobody knows the whole turns.
            off[row] = math.remainder(turn[row] - float(np.median(others)), TWO_PI)
    known = np.isfinite(off)
    if turn.size < _ENOUGH or not known.any():
        return none
    scale = 1.4826 * float(np.median(np.abs(off[known])))
    far = np.abs(off) > max(_FAR_OFF * scale, _LEAST_BY_HAND)
    return far if far.sum() <= _MOST_BY_HAND * turn.size else none


def doubt_degrees(table: CsvTable, columns: Sequence[str]) -> None:
    """Warn (`DoubtfulInput`) where angles of columns in degrees fill one circle in radians, and no
    more.
    """
    for name in columns:
        if name not in table.header:
            continue
        degrees = table.numbers(name, blank=True)
        degrees = degrees[np.isfinite(degrees)]
        low = float(degrees.min(initial=0.0))
        high = float(degrees.max(initial=0.0))
        one_turn = max(-low, high) <= _HALF_A_TURN or (low >= 0.0 and high <= 2.0 * _HALF_A_TURN)
        if degrees.size >= _TELLING and one_turn and high - low > _NEARLY_A_TURN:
            warnings.warn(
                f"{table.path}: {name} runs from {low:g} to {high:g} in {degrees.size} rows: "
                "are these radians?",
                DoubtfulInput,
                stacklevel=4,
            )
            return


def _from_staircase(table: CsvTable, convention: Convention) -> Theta0Pairs:
    """A staircase whose columns agree; flagged rows make no pair."""
    require_columns(table, STAIRCASE_COLUMNS)
    cycle, path, wrapped = (table.numbers(name) for name in STAIRCASE_COLUMNS[:3])
    # Empty where there is no next one.
    turn = table.numbers("dtheta_to_next_deg", blank=True)
    last = table.rows[-1].line
    if not np.isnan(turn[-1]):
        raise table.error(
            last, "the last row has a next θ0: the file is cut off; restore it or empty that field"
        )
    for index in np.flatnonzero(np.abs(shorter_way(np.deg2rad(path - wrapped))) > _CONSISTENT)[:1]:
        values = f"{path[index]:g} and {wrapped[index]:g}"
        words = f"theta0_accum_deg and theta0_mod360_deg disagree ({values})"
        raise table.error(table.rows[index].line, words)
    off = np.abs(np.deg2rad(np.diff(path) - turn[:-1])) > _CONSISTENT
    off_next = (np.diff(cycle) == 1) & off
    for index in np.flatnonzero(off_next)[:1]:
        values = f"{turn[index]:g}, the next row says {path[index + 1] - path[index]:g}"
        words = f"dtheta_to_next_deg is {values}; a row is missing or cut off"
        raise table.error(table.rows[index].line, words)
    flags = np.array([table.text(row, "flag") for row in table.rows])
    kept = (flags == "") & ~np.isnan(turn)
    if not kept.any():
        raise table.error(last, "no row without a flag has a next θ0; nothing to compare with")
    dropped = dict(Counter(flag for flag in flags.tolist() if flag))
    theta = convention.theta(np.deg2rad(path))
    turned = convention.sense * np.deg2rad(turn)
    return Theta0Pairs.along(theta, turned, kept, cycle, dropped)


def _from_pairs(table: CsvTable, convention: Convention) -> Theta0Pairs:
    """Pairs, in order where each begins where the one before ended."""
    require_columns(table, PAIR_COLUMNS)
    theta, theta_next = (_orientations(table, name, convention) for name in PAIR_COLUMNS)
    turn = shorter_way(theta_next - theta)
    gap = shorter_way(theta[1:] - theta_next[:-1])
    if not _is_in_order(gap, turn):
        return Theta0Pairs(theta, theta + turn)
    elsewhere = int(_is_large(gap).sum())
    if elsewhere:
        doubt = (
            f"{table.path}: {elsewhere} of {theta.size} pairs do not begin where the one "
            "before ended: the rows are taken to be in order, and staircases are of the "
            "longest run without such a pair"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=4)
    path = theta[0] + np.cumsum(np.concatenate([[0.0], turn + np.append(gap, 0.0)]))
    every = np.ones(turn.size, dtype=bool)
    return Theta0Pairs.along(path, turn, every, np.arange(float(path.size)))


def _is_in_order(gap: Array, turn: Array) -> bool:
    """Whether pairs whose turns are (n,) and which begin by `gap` (n - 1,) beside where the one
    before ended follow each other.
    """
    if not gap.size:
        return False
    # A sweep over θ0 begins near where the pair before ended, too: but then gaps vary as much as
    # turns.
    usual, varied = np.median(np.abs([gap, turn[1:] - np.median(turn)]), axis=1)
    exact = bool((np.abs(gap) <= _CONSISTENT).all())
    return exact or (turn.size >= _ENOUGH and bool(usual <= _SMALL_GAP * varied))
