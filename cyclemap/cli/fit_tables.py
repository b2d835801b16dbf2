"""The two tables of `cyclemap fit`: how much equal pushes differ, and what a law of θ0 leaves of it."""

import math
from itertools import chain

from rich.table import Table

from cyclemap.evidence.tables.law_table import MotionLaw, SetLaws
from cyclemap.evidence.tables.push_statistics import MotionStatistics, PushStatistics

QUANTITIES = (("dtheta", "Δθ (°)", math.degrees(1.0)), ("dx", "Δx (mm)", 1000.0), ("dy", "Δy (mm)", 1000.0))
NOTHING = "–"
# A percentage of a mean near 0 says nothing but that.
MOST_PERCENT = 1000.0
NOTE_LETTERS = 60


def statistics_table(rows: list[PushStatistics]) -> Table:
    """Mean, standard deviation and its percentage of Δθ, Δx and Δy, a row a set."""
    notes = any(row.problem for row in rows)
    title = "Pushes: mean, standard deviation σ, and σ in per cent of the mean"
    table = _table(title, notes, "mean", "σ", "%")
    for row in rows:
        numbers = [_statistic(getattr(row, name), unit) for name, _, unit in QUANTITIES]
        table.add_row(*_cells(row, numbers, notes))
    return table


def law_table(rows: list[SetLaws]) -> Table:
    """RMSE of the laws of θ0 and its percentage, as in the paper, with that in pushes left out and the order."""
    title = "Laws of θ0: RMSE, its per cent of the mean, RMSE in pushes left out (cv), harmonics (K)"
    notes = any(row.problem for row in rows)
    table = _table(title, notes, "RMSE", "%", "cv", "K")
    for row in rows:
        numbers = [_law(getattr(row, name), unit) for name, _, unit in QUANTITIES]
        table.add_row(*_cells(row, numbers, notes))
    return table


def _table(title: str, notes: bool, *columns: str) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column("set", no_wrap=True)
    table.add_column("pushes", justify="right")
    for _, label, _ in QUANTITIES:
        for number, column in enumerate(columns):
            table.add_column(f"{label}\n{column}" if number == 0 else f"\n{column}", justify="right", no_wrap=True)
    if notes:
        table.add_column("note", max_width=NOTE_LETTERS)
    return table


def _cells(row: PushStatistics | SetLaws, numbers: list[list[str]], notes: bool) -> list[str]:
    return [row.name, str(row.count), *chain.from_iterable(numbers), *([row.problem or ""] if notes else [])]


def _statistic(one: MotionStatistics | None, unit: float) -> list[str]:
    if one is None:
        return [NOTHING] * 3
    return [f"{unit * one.mean:.2f}", f"{unit * one.std:.2f}", _percent(one.percent)]


def _percent(value: float) -> str:
    return f"{value:.2f}" if value < MOST_PERCENT else f">{MOST_PERCENT:.0f}"


def _law(found: MotionLaw, unit: float) -> list[str]:
    law = found.law
    if law is None:
        return [NOTHING] * 4
    errors = f"{unit * law.rmse:.2f}", _percent(law.percent), f"{unit * found.cross_validated_rmse:.2f}"
    return [*errors, str(law.harmonics)]
