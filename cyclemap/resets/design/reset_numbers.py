"""The few scores that a reset is ranked by, quickly for a search or with bounds, for drawn and alternating actions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import CircleMap, Noise, transfer_operator
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import (
    CycleOperator,
    complex_moments,
    fourier_basis,
    images_law,
    real_coefficients,
    stationary_fourier_law,
)
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.maps.mixtures.start_ensemble import StartEnsemble
from cyclemap.maps.mixtures.worst_start import largest_variation
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.resets.scores.effective_size import effective_size
from cyclemap.resets.scores.schedule_laws import ScheduleLaws
from cyclemap.resets.scores.schedule_routes import OperatorImages, periodic_chain
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.strategy import PERIODIC

# Fourier modes and starts of a quick look; laws too sharp for them are looked at with all modes.
QUICK_MODES, QUICK_STARTS = 96, 72
_REPORTED = 100


@dataclass(frozen=True, eq=False)
class ResetNumbers:
    """Scores of a reset whose kernel is known.

    law : of a recorded orientation, in the long run. tv : its total variation from uniform. tv_after : the same
    after `within` pushes, from the worst start. reach : pushes from which on it is within `near`, from any start; inf
    where that takes more than `within`. effective_per_100 : independent orientations that 100 pushes are worth, for
    the worst mean of the first two harmonics; where actions know of each other, of exactly 100 pushes; nan where the
    law is too sharp for that.
    bounded : whether the errors of `tv` and `tv_after` are known; else their bounds are infinite.
    """

    law: FourierLaw
    tv: Estimate
    tv_after: Estimate
    reach: float
    effective_per_100: float
    within: int
    near: float
    bounded: bool

    @property
    def reach_words(self) -> str:
        """The reach in words, for a table."""
        return f"{self.reach:.0f}" if math.isfinite(self.reach) else f"> {self.within}"


@dataclass(frozen=True, eq=False)
class ResetKernel:
    """What moves the orientation in a cycle: one of `maps` with `weights`, by `kind` of law, and `noise`.

    kind : "independent" or "periodic". Raises InvalidInput for another: what is drawn in blocks or follows a sequence
    has no kernel.
    """

    maps: Sequence[CircleMap]
    weights: Array
    kind: str
    noise: Noise

    def __post_init__(self) -> None:
        if self.kind not in (INDEPENDENT, PERIODIC):
            raise InvalidInput(f"actions drawn by {self.kind!r} have no kernel: draw independently, or alternate")

    def numbers(self, within: int, near: float, bounded: bool = False) -> ResetNumbers:
        """Return the scores; `near` : total variation that counts as reached. bounded : with bounds, a hundred times
        slower.

        >>> from cyclemap.maps import WrappedNormal
        >>> turns = ResetKernel([CircleMap.rigid(0.1)], np.ones(1), "independent", WrappedNormal(1.0))
        >>> found = turns.numbers(within=10, near=0.1)
        >>> round(found.tv, 9), found.reach
        (0.0, 4.0)
        """
        if bounded:
            return self._numbers(within, near, None, True)
        try:
            return self._numbers(within, near, min(QUICK_MODES, needed_modes(self.noise)), False)
        except ConvergenceError:
            return self._numbers(within, near, None, False)

    def quick_tv(self) -> float:
        """Return the stationary law's total variation from uniform alone, on few modes where they do."""
        try:
            return float(self._law(min(QUICK_MODES, needed_modes(self.noise)), False).total_variation())
        except ConvergenceError:
            return float(self._law(None, False).total_variation())

    def operator(self, modes: int | None = None) -> CycleOperator:
        """The transfer operator of independently drawn actions."""
        if len(self.maps) == 1:
            return transfer_operator(self.maps[0], self.noise, modes=modes)
        return mixture_operator(self.maps, self.weights, self.noise, modes)

    def schedule(self, modes: int | None = None) -> PeriodicSchedule:
        """The schedule of alternating actions."""
        return PeriodicSchedule([transfer_operator(one, self.noise, modes=modes) for one in self.maps])

    @property
    def alternates(self) -> bool:
        """Whether actions come in turn."""
        return self.kind == PERIODIC and len(self.maps) > 1

    # -- inside --------------------------------------------------------------------------------------------

    def _law(self, modes: int | None, bounded: bool) -> FourierLaw:
        if self.alternates:
            return self.schedule(modes).recorded_law()
        return stationary_fourier_law(self.operator(modes), bounded)

    def _numbers(self, within: int, near: float, modes: int | None, bounded: bool) -> ResetNumbers:
        if self.alternates:
            schedule = self.schedule(modes)
            worth = _worth_in_turn(schedule, within)
            law, worst = schedule.recorded_law(), schedule.worst(within, starts=None if bounded else QUICK_STARTS)
            curve, error = worst.total_variation, float(worst.total_variation_error[-1])
        else:
            operator = self.operator(modes)
            law = stationary_fourier_law(operator, bounded)
            worth = float(effective_size(operator, bounded=False).of(_REPORTED))
            curve, error = _curve(operator, within) if not bounded else _bounded_curve(operator, within)
        return ResetNumbers(
            law=law,
            tv=law.total_variation() if bounded else Estimate(float(law.total_variation()), math.inf),
            tv_after=Estimate(float(curve[-1]), error if bounded else math.inf),
            reach=_reach(curve, near),
            effective_per_100=worth,
            within=within,
            near=near,
            bounded=bounded,
        )


def _worth_in_turn(schedule: PeriodicSchedule, within: int) -> float:
    """What 100 pushes of alternating actions are worth; nan where the law is too sharp for variances."""
    chain = periodic_chain(schedule.operators)
    first = real_coefficients(schedule.recorded_law().moments, chain.size // 2)
    laws = ScheduleLaws(chain, OperatorImages(schedule.operators), first, QUICK_STARTS, within)
    try:
        return float(laws.effective_size(_REPORTED))
    except ConvergenceError:
        return math.nan


def _curve(operator: CycleOperator, cycles: int) -> tuple[Array, float]:
    """Total variation from uniform after 1, ..., `cycles` cycles from the worst of a few starts, without a bound."""
    basis, even = fourier_basis(operator), FourierLaw.uniform()
    columns = images_law(basis, TWO_PI * np.arange(QUICK_STARTS) / QUICK_STARTS)
    found = np.empty(cycles)
    for n in range(cycles):
        found[n] = largest_variation(complex_moments(columns), even)
        columns = basis.matrix @ columns
    return found, math.inf


def _bounded_curve(operator: CycleOperator, cycles: int) -> tuple[Array, float]:
    """The same with all starts that count, and the bound on the last."""
    worst = StartEnsemble(operator).worst(cycles, FourierLaw.uniform())
    return worst.total_variation, float(worst.total_variation_error[-1])


def _reach(curve: Array, near: float) -> float:
    """The first push from which on the worst start's distance is at most `near`; inf where the last one is not."""
    above = np.flatnonzero(curve > near)
    if above.size and above[-1] == curve.size - 1:
        return math.inf
    return float(above[-1] + 2) if above.size else 1.0
