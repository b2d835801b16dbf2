"""Results as JSON: degrees and millimetres, every number finite or null."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.file_text import MILLIMETRES

if TYPE_CHECKING:
    from cyclemap.collection.lock_forecast import LockForecast
    from cyclemap.collection.loop import CollectionLoop
    from cyclemap.collection.portrait import Portrait, StaircaseForecast
    from cyclemap.collection.uncertain_directions import DirectionUncertainty
    from cyclemap.evidence import MeasuredOverlay, MeasuredStaircase
    from cyclemap.maps import (
        Orbit,
        RestMultiplier,
        SlowZone,
        StaircaseSummary,
        StepComparison,
        Steps,
    )
    from cyclemap.resets import ResetStrategy
    from cyclemap.sweeps.direction_margins import DirectionMargin

Json = dict[str, object]


def portrait_report(portrait: Portrait, measured: MeasuredOverlay | None = None) -> Json:
    """The report of `cyclemap portrait`; with data it has one entry more, "data"."""
    rotation, operator, turns = portrait.rotation, portrait.operator, portrait.turns
    locked = rotation.locked
    stationary: Json = {
        "noise_deg": degrees(portrait.noise.sigma),
        "peaks_deg": sorted(direction_deg(peak) for peak in portrait.highest_peaks),
        **numbers_of(operator, "spectral_gap", "mixing_cycles"),
        "tv_from_uniform": number(portrait.tv_from_uniform),
    }
    if portrait.held:
        stationary["held"] = [
            {"peak_deg": direction_deg(held.peak), **numbers_of(held, "share", "leaving")}
            for held in portrait.held
        ]
    report: Json = {
        "map": {
            "degree": int(portrait.map.degree),
            "samples": int(portrait.map.samples),
            "max_error_deg": degrees(portrait.map.max_error),
            "mean_turn_deg": degrees(turns.mean),
            "min_turn_deg": degrees(turns.minimum),
            "max_turn_deg": degrees(turns.maximum),
            **numbers_of(turns, "min_slope", "max_slope"),
        },
        "fixed_points": [*map(orbit_report, portrait.fixed_points)],
        "rotation_number": {
            **numbers_of(rotation, "value", "lower", "upper"),
            "locked": None if locked is None else f"{locked.numerator}/{locked.denominator}",
        },
        "stationary": stationary,
        "staircase": _staircase(portrait.prediction),
    }
    if portrait.uncertainty is not None:
        report["uncertainty"] = uncertainty_report(portrait.uncertainty)
    if portrait.forecast is not None:
        report["forecast"] = forecast_report(portrait.forecast)
    if portrait.worn is not None:
        report["worn"] = _with_zones(portrait.worn)
    if measured is not None:
        agreement = measured.agreement
        told: Json = {
            "pairs": agreement.pairs,
            "dropped": dict(measured.pairs.dropped),
            "bins": agreement.bins,
        }
        report["data"] = {**told, **degrees_of(agreement, "rms", "bin_rms")}
    return report


def staircase_report(
    forecast: StaircaseForecast, measured: MeasuredStaircase | None = None
) -> Json:
    """The report of `cyclemap staircase`; with data it has one entry more, "data"."""
    zones = zip(forecast.prediction.zones, forecast.log10_residences, strict=True)
    report: Json = {
        "noise_deg": degrees(forecast.noise.sigma),
        "prediction": {
            **_staircase(forecast.prediction),
            "zones": [
                {**_zone(zone), "log10_residence_cycles": number(log10)} for zone, log10 in zones
            ],
        },
        "run": {"seed": forecast.run.seed, **steps_report(forecast.steps)},
    }
    if forecast.uncertainty is not None:
        report["uncertainty"] = uncertainty_report(forecast.uncertainty)
    if forecast.forecast is not None:
        report["forecast"] = forecast_report(forecast.forecast)
    if forecast.worn is not None:
        report["worn"] = _with_zones(forecast.worn)
    return report if measured is None else {**report, "data": measured_report(measured)}


def actions_report(strategy: ResetStrategy, loop: CollectionLoop) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares of the cycles."""
    from cyclemap.views.reset_page import action_words

    return [
        {
            "name": action_words(action),
            "weight": number(share),
            "side": acted.push.side,
            "fraction": number(acted.push.fraction),
            "angle_deg": degrees(acted.push.angle),
            "push_mm": millimetres(acted.push.distance),
            "way_points_mm": [[*map(millimetres, place)] for place in acted.reset.way_points],
            "gripper_turn_deg": degrees(action.turn),
        }
        for action, acted, share in zip(
            strategy.actions, strategy.loops(loop), strategy.shares, strict=True
        )
    ]


def orbit_report(orbit: Orbit) -> Json:
    """Where a fixed point is, and whether it is stable."""
    theta = direction_deg(float(orbit.points[0]))
    return {
        "theta_deg": theta,
        "multiplier": number(orbit.multiplier),
        "stable": bool(orbit.stable),
    }


def json_text(report: Json) -> str:
    """The text of a report, ending with a line break; NaN and infinities are refused."""
    return json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def uncertainty_report(found: DirectionUncertainty) -> Json:
    """How well stable directions are known; `upper_deg` may pass 360. Of no posterior the shares
    are no chances.
    """
    return {
        "source": found.source,
        "method": found.method,
        "first_order_error_deg": degrees(found.first_order_error),
        "samples": found.samples,
        "samples_that_lock": found.locks,
        "chance_of_lock_in": found.chance if found.is_posterior else None,
        "directions": [
            {
                "theta_deg": None if one.theta is None else direction_deg(one.theta),
                "lower_deg": degrees(one.lower),
                "upper_deg": degrees(one.upper),
                "share": one.share,
            }
            for one in found.directions
        ],
    }


def multiplier_report(found: RestMultiplier | None) -> Json | None:
    """The multiplier of the last cycles; None where they do not rest."""
    if found is None:
        return None
    numbers_told = numbers_of(found, "value", "lower", "upper")
    return {**numbers_told, "cycles": found.cycles, "theta_deg": direction_deg(found.theta)}


def margins_report(margins: Iterable[DirectionMargin]) -> list[Json]:
    """How far each setting is from a change of the stable directions, nearest first, in the units
    of the keys.
    """
    from cyclemap.protocol.setting_table import SETTINGS

    found: list[Json] = []
    for one in margins:
        unit = float(SETTINGS[one.key].unit.in_si)
        told: Json = {"key": one.key, "value": one.value / unit, "directions": one.directions}
        for side, change in (("below", one.below), ("above", one.above)):
            told[side] = (
                None
                if change is None
                else {
                    "value": change.value / unit,
                    "error": change.value.error_bound / unit,
                    "kind": change.kind,
                    "theta_deg": None if math.isnan(change.theta) else direction_deg(change.theta),
                    "directions": change.directions,
                }
            )
        found.append(
            {**told, "searched": [one.low / unit, one.high / unit], "share": number(one.share)}
        )
    return found


def forecast_report(found: LockForecast) -> Json:
    """What the next pushes will bring."""
    middle, low, high = found.orientations
    where = [
        {"theta_deg": direction_deg(theta), "share": share, "within_deg": degrees(within)}
        for theta, share, within in found.directions
    ]
    seen = {"median": middle, "lower": low, "upper": high}
    return {
        "cycles": found.cycles,
        "chance_of_lock_in": found.chance,
        "directions": where,
        "orientations_of_36": seen,
    }


def _staircase(prediction: StaircaseSummary) -> Json:
    return {
        "mean_turn_deg": degrees(prediction.mean_turn),
        "mean_residence_cycles": number(prediction.mean_residence_cycles),
        "step_deg": degrees(prediction.step),
    }


def _with_zones(prediction: StaircaseSummary) -> Json:
    return {**_staircase(prediction), "zones": [_zone(zone) for zone in prediction.zones]}


def _zone(zone: SlowZone) -> Json:
    return {
        "centre_deg": direction_deg(zone.centre),
        "arc_deg": [degrees(end) for end in zone.arc],
        "kind": zone.kind,
        "residence_cycles": number(zone.residence_cycles),
    }


def steps_report(steps: Steps) -> Json:
    """The dwells and steps of a path."""
    return {
        "cycles": int(steps.cycles),
        "climb_deg": degrees(steps.climb),
        "steps": int(steps.count),
        "heights_deg": [degrees(height) for height in steps.heights],
        "dwells": [
            {
                "first_cycle": int(first),
                "cycles": int(length),
                "level_deg": degrees(level),
                "censored": bool(censored),
            }
            for first, length, level, censored in zip(
                steps.start, steps.lengths, steps.levels, steps.censored, strict=True
            )
        ],
    }


def measured_report(measured: MeasuredStaircase) -> Json:
    """A measured staircase, and what the map fitted to it predicts."""
    found = measured.foretold
    if found is None:
        return {
            **steps_report(measured.steps),
            "fitted": None,
            "problem": measured.problem,
            "comparison": None,
        }
    return {
        **steps_report(measured.steps),
        "fitted": {
            "harmonics": found.fitted.law.harmonics,
            "pairs": found.fitted.pairs,
            "noise_deg": degrees(found.fitted.sigma),
            **_with_zones(found.prediction),
        },
        "problem": None,
        "comparison": comparison_report(found.comparison),
    }


def comparison_report(comparison: StepComparison, errors: bool = True) -> Json:
    """Steps and visits measured beside those predicted; of visits also their standard errors where
    asked for.
    """
    told: Json = {
        "steps": number(comparison.net_steps),
        **numbers_of(comparison, "expected_steps", "pace_p_value"),
    }
    visits = []
    for one in comparison.visits:
        visit: Json = {
            "centre_deg": direction_deg(one.zone.centre),
            "exits": one.exits,
            "mean_cycles": number(one.mean),
        }
        if errors:
            visit["standard_error_cycles"] = number(one.standard_error)
        visits.append(
            {
                **visit,
                "predicted_cycles": number(one.predicted),
                "p_value": number(one.mean_p_value),
            }
        )
    return {**told, "visits": visits}


def number(value: float | None) -> float | None:
    """Return the value, None where there is none or it is not finite.

    >>> number(1.5), number(math.inf), number(None)
    (1.5, None, None)
    """
    return float(value) if value is not None and math.isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return each value as `number` does."""
    return [number(value) for value in values]


def degrees(radians: float | None) -> float | None:
    """Return an angle in degrees."""
    return None if radians is None else number(math.degrees(radians))


def millimetres(metres: float) -> float:
    """Return a length that was set in millimetres, in the digits it was set in.

    >>> millimetres(0.01378)
    13.78
    """
    return float(MILLIMETRES.written(metres))


def numbers_of(one: object, *names: str) -> Json:
    """Return attributes by their names, as `number` does."""
    return {name: number(getattr(one, name)) for name in names}


def degrees_of(one: object, *names: str) -> Json:
    """Return attributes in radians as name_deg."""
    return {f"{name}_deg": degrees(getattr(one, name)) for name in names}


def direction_deg(radians: float) -> float:
    """Return a direction in degrees in [0, 360); a hair below zero must not round to 360."""
    return float(np.degrees(radians) % 360.0) % 360.0
