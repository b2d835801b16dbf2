"""Everything a reset is judged by, predicted from its transfer operator, in one value."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cyclemap.maps import Noise, transfer_operator
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import CycleOperator, fourier_basis, stationary_fourier_law
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.random_map import checked_maps, checked_weights
from cyclemap.maps.mixtures.start_ensemble import StartEnsemble
from cyclemap.maps.mixtures.worst_start import ReachTime, WorstStart
from cyclemap.resets.scores.coverage_measures import DEFAULT_SECTORS
from cyclemap.resets.scores.effective_size import EffectiveSize, effective_size
from cyclemap.resets.scores.evenness import Evenness, Target, evenness
from cyclemap.resets.scores.score_options import check_score_options
from cyclemap.resets.scores.score_summary import REPORTED_PUSHES, coverage_numbers, summary_numbers
from cyclemap.resets.scores.score_targets import target_law, target_table
from cyclemap.resets.scores.sector_visits import SectorVisits, sector_visits
from cyclemap.resets.scores.simulated_coverage import SimulatedCoverage, Start, chain_sampler, simulated_coverage


def reset_scores(
    maps: Any, noise: Noise, weights: Any = None, *, modes: int | None = None, **options: Any
) -> ResetScores:
    """The scores of the reset whose cycle draws one of ``maps`` with ``weights`` and adds ``noise``.

    maps : one CircleMap or more; weights : None for equal ones. modes : keep this many Fourier modes only; for a quick
    look at an even reset 64 and ``bounded=False`` do. options : those of ``ResetScores``.

    >>> from cyclemap.maps import CircleMap, WrappedNormal
    >>> scores = reset_scores([CircleMap.rigid(0.1), CircleMap.rigid(0.4)], WrappedNormal(0.3))
    >>> round(scores.evenness.total_variation, 9), scores.mixing_cycles.cycles
    (0.0, 6)
    """
    parts = checked_maps(maps)
    checked_weights(weights, len(parts))
    if len(parts) == 1:
        return ResetScores(transfer_operator(parts[0], noise, modes=modes), **options)
    return ResetScores(mixture_operator(parts, weights, noise, modes), **options)


@dataclass(frozen=True, eq=False)
class ResetScores:
    """The scores of a reset; each is computed when first asked for, and kept.

    operator : of its cycle, ``transfer_operator`` or ``mixture_operator``, on Fourier modes.
    target : the law that is wished for: None for uniform, a ``FourierLaw`` or a density per radian (callable).
    tv : total variation that "near" means in ``mixing_cycles`` and ``reach_cycles``, in (0, 1).
    pushes : length of a collection, for ``curve`` and the coverage. sectors : of the coverage.
    runs, seed : simulated collections for what no formula gives. starts : starting angles compared; None
        takes enough.
    bounded : False leaves out the bounds that take longer than the numbers; nothing is certified then.
    Raises InvalidInput for anything else.
    """

    operator: CycleOperator
    target: Target = None
    tv: float = 0.05
    pushes: int = 50
    sectors: int = DEFAULT_SECTORS
    runs: int = 400
    seed: int = 0
    starts: int | None = None
    bounded: bool = True

    def __post_init__(self) -> None:
        fourier_basis(self.operator)
        check_score_options(self, pushes=1, sectors=2, runs=2, seed=0)

    # -- the law in the long run ---------------------------------------------------------------------------

    @cached_property
    def law(self) -> FourierLaw:
        """The stationary law."""
        return stationary_fourier_law(self.operator, self.bounded)

    @cached_property
    def evenness(self) -> Evenness:
        """Total variation and Wasserstein distance of the stationary law from the target, and its peak to mean."""
        return evenness(self.law, self.target)

    @cached_property
    def peaks(self) -> Any:
        """Angles in [0, 2π), radians, of the maxima of the stationary density."""
        return self.operator.peaks()

    # -- how fast the start is forgotten -------------------------------------------------------------------

    @cached_property
    def spectral_gap(self) -> Estimate:
        """1 - |λ₂| of the operator."""
        if self.bounded:
            return self.operator.spectral_gap
        return Estimate(max(0.0, 1.0 - float(np.abs(self.operator.eigenvalues(2)[1]))), np.inf)

    @cached_property
    def mixing_cycles(self) -> ReachTime:
        """Cycles until the law from any start is within ``tv`` of the stationary one."""
        return self._ensemble.mixing_cycles(self.tv)

    @cached_property
    def reach_cycles(self) -> ReachTime:
        """Cycles from which on the law from any start stays within 2·``tv`` of the target.

        Twice, so that a stationary law that just meets ``tv`` can be approached; ``within`` takes any distance.
        """
        return self.within(2.0 * self.tv) if self.tv < 0.5 else ReachTime(0, 0, 0)

    def within(self, tv: float) -> ReachTime:
        """Cycles from which on the law from any start stays within ``tv`` of the target."""
        return self._ensemble.reach_cycles(tv, self._target_law)

    @cached_property
    def curve(self) -> WorstStart:
        """Largest total variation and W1 from the target over all starts, after 1, ..., ``pushes`` cycles."""
        return self._ensemble.worst(self.pushes, self._target_law)

    # -- what the pushes are worth -------------------------------------------------------------------------

    @cached_property
    def effective_size(self) -> EffectiveSize:
        """Independent orientations a push is worth, for means of the first two harmonics."""
        return effective_size(self.operator, bounded=self.bounded)

    @property
    def effective_size_per_100(self) -> Estimate:
        """Independent orientations that 100 pushes are worth, for the worst mean of the first two harmonics."""
        return self.effective_size.of(REPORTED_PUSHES)

    @cached_property
    def visits(self) -> SectorVisits:
        """Mean share of sectors visited in the first 1, ..., ``pushes`` pushes, exactly."""
        return sector_visits(self.operator, self.pushes, self.sectors, self.bounded)

    @cached_property
    def coverage(self) -> SimulatedCoverage:
        """Mean largest gap, discrepancy and share of sectors after ``pushes`` pushes, simulated, stationary start."""
        return self.coverage_from("stationary")

    def coverage_from(self, start: Start) -> SimulatedCoverage:
        """The same from a start: an angle in radians, "uniform" or "stationary"."""
        sampler = chain_sampler(self.operator, start)
        options: dict[str, Any] = {"sectors": self.sectors, "runs": self.runs, "seed": self.seed}
        return simulated_coverage(sampler, self.pushes, target=target_table(self.target), **options)

    # -- together ------------------------------------------------------------------------------------------

    @property
    def certified(self) -> bool:
        """Whether distances are known to 0.005 and the bounds confirm latest times, or that there are none."""
        times = self.mixing_cycles.certified and self.reach_cycles.certified
        return self.evenness.certified and times

    def summary(self) -> dict[str, Any]:
        """The scores as numbers and their errors, ready for JSON; angles in degrees; inf as None."""
        visits = {
            "sector_share": float(self.visits.stationary[-1]),
            "sector_share_worst_start": float(self.visits.worst[-1]),
        }
        return {**summary_numbers(self), **visits, **coverage_numbers(self.coverage), "certified": self.certified}

    # -- inside --------------------------------------------------------------------------------------------

    @cached_property
    def _ensemble(self) -> StartEnsemble:
        return StartEnsemble(self.operator, self.starts, self.bounded)

    @cached_property
    def _target_law(self) -> FourierLaw:
        return target_law(self.target)
