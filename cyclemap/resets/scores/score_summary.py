"""Scores as plain numbers for JSON: angles in degrees; what is infinite or undefined is None."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.worst_start import ReachTime
from cyclemap.resets.scores.simulated_coverage import SampledMean, SimulatedCoverage

REPORTED_PUSHES = 100  # that the effective sample size is told for
_UNDEFINED = Estimate(np.inf, np.inf)


def summary_numbers(scores: Any) -> dict[str, Any]:
    """The numbers and errors that every kind of scores has; coverage and what is certified come beside them.

    scores : a ``ResetScores`` or a ``StrategyScores``.
    """
    even, gap = scores.evenness, scores.spectral_gap
    return {
        **_with_error("tv_from_target", even.total_variation),
        **_with_error("wasserstein_deg", even.wasserstein, np.degrees(1.0)),
        **_with_error("peak_to_mean", even.peak_to_mean),
        "peaks_deg": np.degrees(scores.peaks).tolist(),
        **_with_error("spectral_gap", _UNDEFINED if gap is None else gap),
        "near_tv": scores.tv,
        **_time("mixing_cycles", scores.mixing_cycles),
        **_time("reach_cycles", scores.reach_cycles),
        **_with_error("effective_size_per_100", scores.effective_size_per_100),
        "pushes": scores.pushes,
        "sectors": scores.sectors,
    }


def coverage_numbers(covered: SimulatedCoverage) -> dict[str, float]:
    """The expected largest gap and Kuiper statistic with their standard errors."""
    gap = sampled_number("largest_gap_deg", covered.largest_gap, np.degrees(1.0))
    return {**gap, **sampled_number("kuiper", covered.kuiper)}


def sampled_number(name: str, found: SampledMean, unit: float = 1.0) -> dict[str, float]:
    """A simulated mean and its standard error."""
    return {name: float(found.mean * unit), f"{name}_standard_error": float(found.standard_error * unit)}


def _with_error(name: str, found: Estimate, unit: float = 1.0) -> dict[str, float | None]:
    return {name: _finite(found * unit), f"{name}_error": _finite(found.error_bound * unit)}


def _time(name: str, found: ReachTime) -> dict[str, float | bool | None]:
    ends = {f"{name}_earliest": _finite(found.earliest), f"{name}_latest": _finite(found.latest)}
    return {name: _finite(found.cycles), **ends, f"{name}_certified": found.certified}


def _finite(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None
