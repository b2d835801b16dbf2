"""A data set that exists already, looked at for what its reset did to it: cover, lock-in, worth,
and what to change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.turn_bins import covered_arcs
from cyclemap.evidence.motion_check import check_orientations, check_pushes
from cyclemap.evidence.pushes.push_table import SET_FACTS, PushTable, load_pushes
from cyclemap.evidence.pushes.theta0_pairs import read_theta0_pairs
from cyclemap.evidence.tables.columns import written_convention
from cyclemap.evidence.tables.data_kinds import tells_orientations_alone
from cyclemap.progress import Progress, part_of
from cyclemap.resets.bias_monitor import BiasMonitor, BiasReport
from cyclemap.written import DIRECTION

if TYPE_CHECKING:
    import pandas

# Pushes worth less than this share of as many spread evenly want another reset.
LEAST_WORTH = 0.5
FEWEST = 10
_NEAR = np.radians(10.0)
# Turns alike to this (rad) are alike but for rounding.
_ALIKE = 1e-9
# What a reset takes back is a share of a mean turn that is so many of its errors from none.
_SURELY = 3.0


@dataclass(frozen=True, eq=False)
class ResetEffect:
    """What the resets of a data set did to the orientation, over n of them.

    Attributes
    ----------
    push_turn, reset_turn : ndarray, shape (n,)
        Of each push and of what followed it until the next, rad.
    undone : float
        Share of the mean turn of a push that the reset takes back; 1: all of it. NaN where
        that mean may be none.
    slope : float
        Of a reset's turn on its push's, -1 where it undoes each push, 0 where it knows none;
        NaN where pushes turn alike.
    """

    push_turn: Array
    reset_turn: Array
    undone: float
    slope: float


@dataclass(frozen=True, eq=False)
class Audit:
    """What a data set is worth.

    Attributes
    ----------
    name : str
        That of the data.
    theta : tuple of float
        Its orientations, rad, in order.
    reports : tuple of BiasReport
        Of the monitor after each.
    alarm_rate : float
        The monitor's chance of a false alarm.
    ordered : bool
        Whether their order is known.
    covered : tuple of tuple[float, float]
        Arcs (from, to), rad, with no gap of 20 degrees.
    reset : ResetEffect or None
        What the reset did; None where the data do not tell poses before and after pushes.
    others : int
        Pushes of other sets in the data, left out.
    posed : bool
        Whether poses after pushes are there, at least.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.resets import audit
    >>> with tempfile.TemporaryDirectory() as place:
    ...     text = "theta0_deg\\n" + "".join(f"{137.5 * push % 360}\\n" for push in range(40))
    ...     count = Path(place, "even.csv").write_text(text)
    ...     found = audit(f"{place}/even.csv")
    >>> found.report.alarm is None, found.is_good, found.others
    (True, True, 0)
    """

    name: str
    theta: tuple[float, ...]
    reports: tuple[BiasReport, ...]
    alarm_rate: float
    ordered: bool = field(metadata={"name": "order_known"})
    covered: tuple[tuple[float, float], ...] = field(metadata=DIRECTION)
    reset: ResetEffect | None
    others: int = field(metadata={"name": "pushes_of_other_sets"})
    posed: bool = False

    @property
    def report(self) -> BiasReport:
        """What the monitor says after the last push."""
        return self.reports[-1]

    @property
    def worth(self) -> float:
        """How many pushes spread evenly it is worth."""
        return self.report.coverage.effective_pushes

    @property
    def locked_from(self) -> int | None:
        """The push from which on it locked in; None where it did not, or its order is unknown."""
        alarm = self.report.alarm
        if alarm is None or not self.ordered:
            return None
        return alarm.push if alarm.began is None else alarm.began

    @property
    def gathered(self) -> float:
        """Share of the pushes from the lock-in on that lie within 10 degrees of its directions; 0
        without one.
        """
        alarm = self.report.alarm
        start = self.locked_from
        if alarm is None or start is None:
            return 0.0
        away = shorter_way(np.subtract.outer(self.theta[start:], alarm.directions))
        return float(np.mean(np.abs(away).min(axis=1) < _NEAR))

    @property
    def is_good(self) -> bool:
        """Whether nothing speaks for another reset: no lock-in, the circle covered, pushes worth
        half their number.
        """
        covers_all = len(self.covered) == 1 and self.covered[0][1] - self.covered[0][0] > 6.28
        return (
            self.locked_from is None and covers_all and self.worth >= LEAST_WORTH * len(self.theta)
        )


def audit(
    data: str | Path | PushTable,
    *,
    loop: CollectionLoop | None = None,
    progress: Progress | None = None,
) -> Audit:
    """Look at the orientations of a data set, and at the poses where it has them.

    Parameters
    ----------
    data : str or Path or PushTable
        A path that `load_pushes` or `read_theta0_pairs` reads, or a table of pushes. Of several
        sets pushed alike the one of most pushes is taken.
    loop : CollectionLoop or None, optional
        The loop that made them, where it is known: the sense of angles is tested by it, else by
        whether pushes alike move the object alike.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    Audit
        The monitor's reports, and what the data cover.

    Raises
    ------
    OtherConvention
        Where the sense of angles is another.
    InvalidInput
        For fewer than 10 pushes.
    DataFileError
        For a bad file.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.resets import audit
    >>> with tempfile.TemporaryDirectory() as place:
    ...     _ = Path(place, "still.csv").write_text("theta0_deg\\n" + "63.2\\n" * 40)
    ...     found = audit(f"{place}/still.csv")
    >>> found.locked_from, found.is_good, round(found.worth)
    (0, False, 1)
    """
    name = data.table["path"].iloc[0] if isinstance(data, PushTable) else str(data)
    theta, about = _largest_set(data, loop)
    if theta.size < FEWEST:
        raise InvalidInput(f"{name}: {theta.size} pushes of one set; an audit needs {FEWEST}")
    monitor = BiasMonitor()
    reports = []
    for index, angle in enumerate(theta.tolist()):
        reports.append(monitor.update(angle))
        part_of(progress, index, theta.size)(1.0)
    return Audit(
        Path(name).name,
        monitor.path,
        tuple(reports),
        monitor.alarm_rate,
        covered=covered_arcs(theta),
        **about,
    )


def _largest_set(
    data: str | Path | PushTable, loop: CollectionLoop | None
) -> tuple[Array, dict[str, Any]]:
    """The orientations of the largest set of the data, and what an `Audit` tells of it."""
    if not isinstance(data, PushTable) and tells_orientations_alone(Path(data)):
        pairs = read_theta0_pairs(data)
        if loop is not None:
            check_orientations(pairs.theta, pairs.theta_next, loop, written_convention(data)[0])
        ordered = pairs.path is not None
        theta = pairs.theta if pairs.path is None else pairs.path
        return theta, {"ordered": ordered, "reset": None, "others": 0}
    pushes = data if isinstance(data, PushTable) else load_pushes(data)
    table = pushes.table.dropna(subset=["theta0"])
    if not len(table):
        why = "".join(f": {file.path}: {file.reason}" for file in pushes.unreadable[:1])
        raise InvalidInput(f"{data}: no push with an orientation in it{why}")
    check_pushes(pushes, loop)
    sets = table.groupby([*SET_FACTS], dropna=False, sort=False)
    rows = max((rows for _, rows in sets), key=len)
    numbers = rows["repetition"]
    numbered = bool(numbers.notna().all()) and numbers.nunique() == len(rows)
    if numbered:
        rows = rows.sort_values("repetition", kind="stable")
    return rows["theta0"].to_numpy(), {
        # A table of one file is in the order in which it was written.
        "ordered": numbered or rows["path"].nunique() == 1,
        "reset": _effect(rows),
        "others": len(table) - len(rows),
        "posed": bool(rows["theta1"].notna().any()),
    }


def _effect(rows: pandas.DataFrame) -> ResetEffect | None:
    """What the resets between pushes that follow each other did; None where these are too few."""
    followed = rows.dropna(subset=["theta1", "theta_next"])
    if len(followed) < FEWEST:
        return None
    before, after, then = (followed[name].to_numpy() for name in ("theta0", "theta1", "theta_next"))
    push_turn = after - before
    reset_turn = then - after
    mean = float(push_turn.mean())
    spread = float(np.std(push_turn, ddof=1))
    slope = undone = math.nan
    if spread > _ALIKE:
        slope = float(np.cov(push_turn, reset_turn)[0, 1] / spread**2)
    if abs(mean) > max(_ALIKE, _SURELY * spread / math.sqrt(push_turn.size)):
        undone = float(-reset_turn.mean() / mean)
    return ResetEffect(push_turn, reset_turn, undone, slope)
