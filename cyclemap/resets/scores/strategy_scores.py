"""The scores of any strategy, whatever its schedule, from its maps: one call, the same names for all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.maps.mixtures.worst_start import ReachTime, WorstStart
from cyclemap.resets.scores.coverage_measures import DEFAULT_SECTORS
from cyclemap.resets.scores.evenness import Evenness, Target, evenness
from cyclemap.resets.scores.reset_scores import ResetScores
from cyclemap.resets.scores.schedule_laws import ScheduleLaws
from cyclemap.resets.scores.schedule_routes import FOLLOWED_RUNS, schedule_laws
from cyclemap.resets.scores.score_options import check_score_options, checked_score_noise
from cyclemap.resets.scores.score_summary import REPORTED_PUSHES, coverage_numbers, sampled_number, summary_numbers
from cyclemap.resets.scores.score_targets import law_peaks, target_law, target_table
from cyclemap.resets.scores.simulated_coverage import SimulatedCoverage, schedule_sampler, simulated_coverage
from cyclemap.resets.scores.strategy_operators import (
    action_operators,
    independent_operator,
    is_quickly_resolved,
    kept_modes,
)
from cyclemap.resets.scores.strategy_sampler import strategy_sampler
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.strategy import PERIODIC
from cyclemap.resets.strategies.strategy_maps import StrategyMaps
from cyclemap.resets.strategies.strategy_sampling import Interpolated

Made = TypeVar("Made", ResetScores, ScheduleLaws)
_QUICK_STARTS, _STARTS = 64, 256


def strategy_scores(
    maps: StrategyMaps, noise: Noise, *, bounded: bool = False, modes: int | None = None, **options: Any
) -> StrategyScores:
    """The scores of a strategy from its maps, whatever its schedule.

    maps : from ``strategy_maps``. noise : added after each cycle. bounded : whether to work out error bounds, on all
    modes; else 64 Fourier modes at most are kept, for rankings and searches, or 192 where that leaves a law
    unresolved. modes : keep so many instead.
    options : ``target``, ``tv``, ``pushes``, ``sectors``, ``runs``, ``seed``, ``starts``, ``followed``, as those of
    ``StrategyScores``.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn
    >>> from cyclemap.resets.strategies.strategy_maps import strategy_maps
    >>> maps = strategy_maps(CollectionLoop.mit(), GripperTurn(), tolerance=1e-2)
    >>> scores = strategy_scores(maps, WrappedNormal(0.05), tv=0.05, pushes=50)
    >>> scores.kind, round(scores.total_variation, 9), scores.within(0.1).cycles
    ('independent', 0.0, 1)
    """
    if not isinstance(maps, StrategyMaps):
        raise InvalidInput(f"maps is {maps!r}: make them with strategy_maps(loop, strategy)")
    return StrategyScores(maps, checked_score_noise(noise), modes=modes, bounded=bounded, **options)


@dataclass(frozen=True, eq=False)
class StrategyScores:
    """The scores of a strategy; each is computed when first asked for, and kept. Made by ``strategy_scores``.

    target : the law that is wished for: None for uniform, a ``FourierLaw`` or a density per radian (callable).
    tv : total variation that "near" means in ``mixing_cycles`` and ``reach_cycles``, in (0, 1).
    pushes : length of a collection, for ``curve`` and the coverage. sectors : of the coverage.
    runs, seed : simulated collections for what no formula gives. starts : starting angles compared; None takes enough.
    followed : runs of a schedule that never repeats whose laws are followed. modes : Fourier modes kept; None: as
    ``strategy_scores`` says.

    The stationary law of a strategy is the share of pushes, in a long run, at each orientation. Independent: the one
    that the mean operator keeps. Periodic: the mean over the pushes of a period. Blocks and fixed sequences: the
    mean over a long run and the schedule's own chance. Laws after n pushes are over noise and that chance, from the
    schedule's beginning. Independent: as ``ResetScores``, which ``independent`` is. Else errors are
    measured, without those of the maps and of what is cut off (a periodic law's, where ``bounded``: as those of
    ``PeriodicSchedule``), and nothing is certified. ``undefined`` says why a score is None.
    Raises InvalidInput for anything else.
    """

    maps: StrategyMaps
    noise: Noise
    target: Target = None
    tv: float = 0.05
    pushes: int = 50
    sectors: int = DEFAULT_SECTORS
    runs: int = 400
    seed: int = 0
    starts: int | None = None
    followed: int = FOLLOWED_RUNS
    modes: int | None = None
    bounded: bool = False

    def __post_init__(self) -> None:
        check_score_options(self, pushes=1, sectors=2, runs=2, seed=0, followed=2, starts=8, modes=2)

    @property
    def name(self) -> str:
        """The strategy's."""
        return self.maps.strategy.name

    @property
    def kind(self) -> str:
        """``independent``, ``periodic``, ``blocks`` or ``sequence``; see ``ActionLaw``."""
        return self.maps.law.kind

    @cached_property
    def independent(self) -> ResetScores | None:
        """The scores of the chain whose kernel is the mean over the law, where the strategy is that; else None."""
        if self.kind != INDEPENDENT:
            return None
        given = {name: getattr(self, name) for name in ("target", "tv", "pushes", "sectors", "runs", "seed", "bounded")}
        given["starts"] = self.starts if self.bounded or self.starts else _QUICK_STARTS
        return self._resolved(lambda n: ResetScores(independent_operator(self.maps, self.noise, n), **given))

    @cached_property
    def schedule(self) -> ScheduleLaws | None:
        """The laws of the schedule, where pushes know of each other; else None."""
        if self.kind == INDEPENDENT:
            return None
        return self._resolved(self._schedule_laws) if self.kind == PERIODIC else self._schedule_laws(self._kept(False))

    # -- the law in the long run ---------------------------------------------------------------------------

    @cached_property
    def law(self) -> FourierLaw:
        """The share of pushes in a long run at each orientation."""
        if self.independent is not None:
            return self.independent.law
        return self._periodic.recorded_law() if self._periodic and self.bounded else self._schedule.law

    @cached_property
    def evenness(self) -> Evenness:
        """Total variation and Wasserstein distance of the law from the target, and its peak to mean."""
        if self.independent is not None:
            return self.independent.evenness
        certain = self._periodic is not None and self.bounded
        return evenness(self.law, self.target) if certain else self._schedule.evenness(self.target)

    @property
    def total_variation(self) -> Estimate:
        """Of the law from the target, in [0, 1]."""
        return self.evenness.total_variation

    @property
    def wasserstein(self) -> Estimate:
        """W1 on the circle of the law from the target, radians."""
        return self.evenness.wasserstein

    @property
    def peak_to_mean(self) -> Estimate:
        """Largest density over 1/2π."""
        return self.evenness.peak_to_mean

    # -- how fast the start is forgotten -------------------------------------------------------------------

    @cached_property
    def spectral_gap(self) -> Estimate | None:
        """1 - |λ₂| a push, of the operator of a cycle or of a period; None for blocks and fixed sequences."""
        if self.independent is not None:
            return self.independent.spectral_gap
        return None if self._periodic is None else self._periodic.spectral_gap

    @cached_property
    def mixing_cycles(self) -> ReachTime:
        """Pushes from which on the law from any start is within ``tv`` of that of a run that had long begun."""
        return self._schedule.mixing_cycles(self.tv) if self.independent is None else self.independent.mixing_cycles

    @cached_property
    def reach_cycles(self) -> ReachTime:
        """Pushes from which on the law from any start stays within 2·``tv`` of the target."""
        return self.within(2.0 * self.tv) if self.tv < 0.5 else ReachTime(0, 0, 0)

    def within(self, tv: float) -> ReachTime:
        """Pushes from which on the law from any start stays within ``tv`` of the target."""
        if self.independent is not None:
            return self.independent.within(tv)
        return self._schedule.within(tv, target_law(self.target))

    @cached_property
    def curve(self) -> WorstStart:
        """Largest total variation and W1 from the target over all starts, after 1, ..., ``pushes`` pushes."""
        if self.independent is not None:
            return self.independent.curve
        return self._schedule.worst(self.pushes, target_law(self.target))

    # -- what the pushes are worth -------------------------------------------------------------------------

    @cached_property
    def effective_size_per_100(self) -> Estimate:
        """Independent orientations that 100 pushes are worth, for the worst mean of the first two harmonics.

        Independent: in the limit of long collections. Else of exactly 100 pushes: a schedule's excesses cancel later.
        """
        if self.independent is not None:
            return self.independent.effective_size_per_100
        try:
            return self._schedule.effective_size(REPORTED_PUSHES)
        except ConvergenceError:
            if self.modes is not None or self.bounded:
                raise
            return self._schedule_laws(self._kept(True)).effective_size(REPORTED_PUSHES)

    @cached_property
    def coverage(self) -> SimulatedCoverage:
        """Mean largest gap, discrepancy and share of sectors after ``pushes`` pushes, simulated from the law.

        A periodic strategy that does not say what it draws begins at uniform orientations instead.
        """
        if self.independent is not None:
            return self.independent.coverage
        own = self.kind == PERIODIC and not isinstance(self.maps.strategy, Interpolated)
        sampler = schedule_sampler(self._period) if own else strategy_sampler(self.maps, self.noise, self.law)
        options: dict[str, Any] = {"sectors": self.sectors, "runs": self.runs, "seed": self.seed}
        return simulated_coverage(sampler, self.pushes, target=target_table(self.target), **options)

    # -- together ------------------------------------------------------------------------------------------

    @property
    def undefined(self) -> dict[str, str]:
        """Scores that are None, and what is not certified, with the reason."""
        if self.independent is not None:
            return {}
        why = {
            "certified": "errors under a schedule are measured; modes cut off, cells and the maps' own are not in them"
        }
        if self.spectral_gap is None:
            why["spectral_gap"] = "no single operator carries the law on: the pushes of the schedule know of each other"
        return why

    @property
    def certified(self) -> bool:
        """Whether distances and times are known within bounds; only where pushes are independent of each other."""
        return self.independent is not None and self.independent.certified

    def summary(self, coverage: bool = True) -> dict[str, Any]:
        """The scores as numbers and their errors, ready for JSON; angles in degrees; inf and undefined as None.

        coverage : False leaves out what is simulated and the visits of sectors, which take longest.
        """
        about = {"strategy": self.name, "kind": self.kind}
        covered = self._coverage_numbers() if coverage else {}
        return {**about, **summary_numbers(self), **covered, "certified": self.certified, "undefined": self.undefined}

    @cached_property
    def peaks(self) -> Any:
        """Angles in [0, 2π), radians, of the maxima of the law's density; none where it is uniform."""
        return law_peaks(self.law) if self.independent is None else self.independent.peaks

    # -- inside --------------------------------------------------------------------------------------------

    def _coverage_numbers(self) -> dict[str, Any]:
        shares: dict[str, Any] = sampled_number("sector_share", self.coverage.sector_share)
        if self.independent is not None:
            visits = self.independent.visits
            ends = float(visits.stationary[-1]), float(visits.worst[-1])
            shares = {"sector_share": ends[0], "sector_share_worst_start": ends[1]}
        return {**shares, **coverage_numbers(self.coverage)}

    def _kept(self, finer: bool) -> int | None:
        return kept_modes(self.noise, self.modes, self.bounded, finer)

    def _resolved(self, made: Callable[[int | None], Made]) -> Made:
        """What is made on the modes kept; in a quick look on more of them, where the law needs them."""
        first = made(self._kept(False))
        try:
            enough = self.modes is not None or self.bounded or is_quickly_resolved(first.law)
        except ConvergenceError:
            enough = False
        return first if enough else made(self._kept(True))

    def _schedule_laws(self, modes: int | None) -> ScheduleLaws:
        starts = self.starts or (_STARTS if self.bounded else _QUICK_STARTS)
        options: dict[str, Any] = {"pushes": self.pushes, "runs": self.followed, "seed": self.seed}
        return schedule_laws(self.maps, self.noise, modes=modes, starts=starts, **options)

    @property
    def _schedule(self) -> ScheduleLaws:
        assert self.schedule is not None
        return self.schedule

    @property
    def _periodic(self) -> PeriodicSchedule | None:
        return self._period if self.kind == PERIODIC else None

    @cached_property
    def _period(self) -> PeriodicSchedule:
        return PeriodicSchedule(action_operators(self.maps, self.noise, self._schedule.chain.size // 2))
