"""Everything that is fitted to one set of pushes: its statistics, its laws, its histogram and its cycle map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.tables.law_table import SetLaws, set_laws
from cyclemap.evidence.tables.measured_cycle_map import MeasuredCycleMap, measured_cycle_map
from cyclemap.evidence.tables.push_sets import PushSet
from cyclemap.evidence.tables.push_statistics import PushStatistics, push_statistics
from cyclemap.evidence.tables.turn_histogram import TurnHistogram, turn_histogram


@dataclass(frozen=True, eq=False)
class SetFit:
    """A set with what was fitted to it; what could not be is None, and its row or ``map_problem`` says why.

    histogram : of Δθ, measured and predicted; None without a law of Δθ, or where all Δθ are alike.
    """

    pushes: PushSet
    statistics: PushStatistics
    laws: SetLaws
    histogram: TurnHistogram | None
    cycle_map: MeasuredCycleMap | None
    map_problem: str | None

    @property
    def has_laws(self) -> bool:
        """Whether any of Δθ, Δx, Δy has a law."""
        return any(law.law is not None for law in self.laws.laws)

    @property
    def is_empty(self) -> bool:
        """Whether nothing could be fitted."""
        return not self.has_laws and self.cycle_map is None


def fit_set(
    pushes: PushSet,
    *,
    harmonics: int | None = None,
    wear: bool = True,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> SetFit:
    """Fit the laws, the histogram and the cycle map of a set; never fails for want of pushes.

    harmonics : the order of all laws; None chooses each by cross-validation. wear : whether the cycle map may change
    with the cycle. progress : called with the share done.
    """
    report = progress or (lambda fraction: None)
    laws = set_laws(pushes, harmonics=harmonics, seed=seed, progress=lambda share: report(0.3 * share))
    histogram = _histogram(laws, seed)
    report(0.4)
    cycle_map, problem = _cycle_map(pushes, harmonics, wear, seed, lambda share: report(0.4 + 0.6 * share))
    report(1.0)
    return SetFit(pushes, push_statistics(pushes), laws, histogram, cycle_map, problem)


def _histogram(laws: SetLaws, seed: int) -> TurnHistogram | None:
    found = laws.dtheta
    if found.law is None or found.law.total_std == 0.0:
        return None
    return turn_histogram(found.theta, found.value, found.law, seed=seed)


def _cycle_map(
    pushes: PushSet, harmonics: int | None, wear: bool, seed: int, progress: Callable[[float], None]
) -> tuple[MeasuredCycleMap | None, str | None]:
    if pushes.pairs is None:
        return None, "no push has a known next θ0"
    try:
        found = measured_cycle_map(pushes.pairs, harmonics=harmonics, wear=wear, seed=seed, progress=progress)
    except (InvalidInput, ConvergenceError) as error:
        return None, str(error)
    return found, None
