"""A collection's pushes, parted into the sets that were pushed alike, and how much equal pushes
differ.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.evidence.pushes.push_table import SET_FACTS, PushTable, homes
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.evidence.tables.columns import Row, Selection

if TYPE_CHECKING:
    import pandas


# The fewest pushes to which a law is fitted with an order of its own choice: two a fold.
FEWEST = 20
SURROUNDINGS = SET_FACTS[:4]
CONTACT = SET_FACTS[4:]
_TEXT = SET_FACTS[:2]
_LETTERS = {
    "acceleration": ("a", 1e3),
    "speed": ("v", 1e3),
    "side": ("i", 1.0),
    "fraction": ("s", 1.0),
    "angle": ("t", 1.0),
}
QUANTITIES = ("dtheta", "dx", "dy")
# Two values have a spread; nobody should quote that of fewer than this many.
_FEWEST_FOR_SPREAD = 5


@dataclass(frozen=True, eq=False)
class PushSet:
    """The pushes of one surface, object and protocol, from one folder or CSV table, in order of
    recording.

    Attributes
    ----------
    name : str
        Short, unlike that of any other set of the collection.
    source : Path
        The folder or the table.
    facts : mapping
        What all its pushes share, SI units and radians: the columns of ``SURROUNDINGS`` and
        ``CONTACT`` that are known.
    contacts : int
        How many places and directions of pushing it pools; 1 for repeated pushes.
    theta : ndarray, shape (n,)
        Orientation before each push, rad.
    dtheta : ndarray, shape (n,)
        Turn of the push, rad; NaN where unknown.
    dx, dy : ndarray, shape (n,)
        Displacement in the object's initial frame, m; NaN where unknown.
    pairs : Theta0Pairs or None
        The steps of the cycle map, where orientations before successive pushes are known, else
        None.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.full(30, 0.04), np.full(30, -0.07)
    >>> slate = PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, pairs=None)
    >>> slate.count, slate.has_motion
    (30, True)
    """

    name: str
    source: Path
    facts: Row
    contacts: int
    theta: Array
    dtheta: Array
    dx: Array
    dy: Array
    pairs: Theta0Pairs | None

    @property
    def count(self) -> int:
        """How many pushes it has."""
        return self.theta.size

    @property
    def has_motion(self) -> bool:
        """Whether any push has its turn and displacement, and not its first orientation alone."""
        return bool(np.isfinite(self.dtheta).any())


def push_sets(pushes: PushTable, select: Selection | None = None) -> tuple[PushSet, ...]:
    """Part the pushes into sets pushed alike: same folder (or CSV table), surface, object, speed
    and contact.

    Parameters
    ----------
    pushes : PushTable
        A table of pushes.
    select : mapping of str to str or float or None, optional
        Columns of ``SURROUNDINGS`` and ``CONTACT`` with the one value to keep, SI units and
        radians; None: all are kept.

    Returns
    -------
    tuple of PushSet
        In the order in which they were recorded.

    Raises
    ------
    InvalidInput
        For a column of another name, and where nothing is selected.

    Notes
    -----
    Where no set of a folder has 20 pushes, no push was repeated there often enough: its sets
    are then pooled over the contacts, and say so in ``contacts``.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.evidence import load_pushes, push_sets
    >>> with tempfile.TemporaryDirectory() as place:
    ...     text = "theta0_deg\\n" + "".join(f"{8 * push}\\n" for push in range(25))
    ...     count = Path(place, "slate.csv").write_text(text)
    ...     (pushes,) = push_sets(load_pushes(f"{place}/slate.csv"))
    >>> pushes.name, pushes.count, pushes.has_motion
    ('slate', 24, False)
    """
    table = selected_pushes(pushes.table, select or {})
    gathered: list[tuple[Path, Row, pandas.DataFrame]] = []
    for home, rows in table.groupby(homes(table), sort=False):
        for columns in (SET_FACTS, SURROUNDINGS):
            alike = [own for _, own in rows.groupby([*columns], dropna=False, sort=False)]
            if any(len(own) >= FEWEST for own in alike):
                break
        for own in alike:
            facts = own[[*SET_FACTS]]
            first = facts.iloc[0]
            is_shared = (facts.nunique(dropna=False) == 1) & first.notna()
            gathered.append((Path(home), dict(first[is_shared]), own))
    names = _names([(home, facts) for home, facts, _ in gathered])
    sets = zip(names, gathered, strict=True)
    return tuple(_push_set(name, *own, pushes.pairs.get(str(own[0]))) for name, own in sets)


def selected_pushes(table: pandas.DataFrame, select: Selection) -> pandas.DataFrame:
    """Return the rows whose columns of ``SURROUNDINGS`` and ``CONTACT`` have these values, SI units
    and radians.

    Raises InvalidInput, telling what there is, for a column of another name and where no push has a
    value, or none has all.
    """
    kept = np.ones(len(table), dtype=bool)
    for column, value in select.items():
        if column not in SET_FACTS:
            raise unknown_name("column", column, SET_FACTS)
        cells = table[column]
        same = cells == value
        if column not in _TEXT:
            same = np.isclose(cells, value, rtol=1e-6, atol=1e-9)
        if not np.any(same):
            there = sorted(
                {f"{cell:g}" if isinstance(cell, float) else str(cell) for cell in cells}
            )
            raise InvalidInput(
                f"no such {column}: {value}; the data have {', '.join(there) or 'no push at all'}"
            )
        kept &= np.asarray(same, dtype=bool)
    if select and not kept.any():
        asked = ", ".join(f"{column} {value}" for column, value in select.items())
        raise InvalidInput(f"no push has {asked} at once")
    return table[kept]


def _push_set(
    name: str, home: Path, facts: Row, rows: pandas.DataFrame, pairs: Theta0Pairs | None
) -> PushSet:
    """A set of pushes; pairs : of a table of orientations alone."""
    contacts = rows.groupby([*CONTACT], dropna=False).ngroups
    ordered = contacts == 1 and rows["repetition"].notna().all() and rows["repetition"].is_unique
    if ordered:
        rows = rows.sort_values("repetition", kind="stable")
    theta, dtheta, dx, dy = (rows[column].to_numpy() for column in ("theta0", *QUANTITIES))
    ahead = rows["theta_next"].to_numpy()
    known = np.isfinite(ahead)
    if pairs is None and known.any():
        if ordered:
            pairs = ordered_pairs(theta, ahead, rows["repetition"].to_numpy())
        else:
            pairs = Theta0Pairs(theta[known], ahead[known])
    return PushSet(name, home, facts, contacts, theta, dtheta, dx, dy, pairs)


def ordered_pairs(theta: Array, theta_next: Array, numbers: Array) -> Theta0Pairs:
    """The pairs of pushes (n,), rad, NaN where the next θ0 is not known, in the order of their
    numbers (n,), with the path of all of them.

    The path passes through every θ0 that was measured before a push: what somebody moved the object
    by stays a gap to the next θ0 of the push before. Across a missing push it takes the shorter
    way; it breaks where the next θ0 is not known.
    """
    known = np.isfinite(theta_next)
    turn = theta_next - theta
    follows = np.diff(numbers) == 1.0
    lifted = turn[:-1] + shorter_way(theta[1:] - theta_next[:-1])
    steps = np.where(known[:-1] & follows, lifted, shorter_way(np.diff(theta)))
    path = theta[0] + np.concatenate([[0.0], np.cumsum(steps)])
    moved = numbers[:-1][follows & ~known[:-1]]
    return replace(Theta0Pairs.along(path, turn, known, numbers), moved=tuple(moved.tolist()))


def _names(sets: list[tuple[Path, Row]]) -> list[str]:
    """The shortest names that tell the sets apart: surface and object, then all facts, then the
    source too.

    Facts are told in the letters of the MIT file names: v=20 i=0 s=0.7.
    """
    known = []
    for index, (home, facts) in enumerate(sets, 1):
        short = " ".join(facts[key] for key in _TEXT if key in facts) or home.stem
        letters = [
            f"{letter}={facts[key] * unit:g}"
            for key, (letter, unit) in _LETTERS.items()
            if key in facts and (letter != "a" or facts[key])
        ]
        long = " ".join([short, *letters])
        known.append((short, long, f"{home.stem} {long}", f"{home.stem} {long} {index}"))
    alike = [Counter(names) for names in zip(*known, strict=True)]
    return [
        next(name for name, counts in zip(names, alike, strict=True) if counts[name] == 1)
        for names in known
    ]


@dataclass(frozen=True)
class MotionStatistics:
    """Mean and standard deviation of one quantity: Δθ in rad, Δx or Δy in m.

    Attributes
    ----------
    count : int
        How many pushes.
    mean : float
        Of the quantity.
    std : float
        Standard deviation, n - 1 in its divisor.
    """

    count: int
    mean: float
    std: float

    @property
    def percent(self) -> float:
        """The standard deviation in per cent of the mean's size; inf for a mean of 0."""
        return 100.0 * self.std / abs(self.mean) if self.mean != 0.0 else float("inf")


@dataclass(frozen=True)
class PushStatistics:
    """A row of the table of what pushes did.

    Attributes
    ----------
    name : str
        That of the set.
    count : int
        How many pushes it has.
    dtheta : MotionStatistics or None
        Mean and standard deviation of Δθ, rad.
    dx, dy : MotionStatistics or None
        Mean and standard deviation of Δx and Δy, m.
    problem : str or None
        What is wrong with it; None where nothing is.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, push_statistics
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.full(30, 0.04), np.full(30, -0.07)
    >>> row = push_statistics(PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, None))
    >>> round(row.dtheta.mean, 3), round(row.dtheta.percent, 1), row.problem
    (1.199, 6.0, None)
    """

    name: str
    count: int
    dtheta: MotionStatistics | None
    dx: MotionStatistics | None
    dy: MotionStatistics | None
    problem: str | None = None


def push_statistics(pushes: PushSet) -> PushStatistics:
    """Return the mean and the standard deviation of what the pushes of a set did.

    Parameters
    ----------
    pushes : PushSet
        The set.

    Returns
    -------
    PushStatistics
        The set's row of the table; with fewer than five pushes of known motion it has a problem
        and no numbers.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, push_statistics
    >>> few = np.zeros(3)
    >>> row = push_statistics(PushSet("few", Path("few.csv"), {}, 1, few, few, few, few, None))
    >>> row.dtheta is None, row.count
    (True, 3)
    """
    known = np.isfinite(pushes.dtheta)
    count = int(np.sum(known))
    if count < _FEWEST_FOR_SPREAD:
        reason = f"too few pushes with a known end for a spread: {count} of {_FEWEST_FOR_SPREAD}"
        return PushStatistics(pushes.name, pushes.count, None, None, None, reason)
    dtheta, dx, dy = (
        MotionStatistics(count, float(np.mean(column[known])), float(np.std(column[known], ddof=1)))
        for column in (pushes.dtheta, pushes.dx, pushes.dy)
    )
    return PushStatistics(pushes.name, pushes.count, dtheta, dx, dy)
