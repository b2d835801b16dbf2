"""Results as JSON: degrees and millimetres, every number finite or null."""

import json
import math
from collections.abc import Sequence

import numpy as np

from cyclemap.collection.loop import Cycle
from cyclemap.collection.portrait import Portrait
from cyclemap.evidence import MeasuredOverlay

Json = dict[str, object]


def cycles_report(starts_deg: Sequence[float], cycles: Sequence[Cycle]) -> Json:
    """The report of `cyclemap cycle`: cycles from the start angles as they were given (degrees)."""
    return {"cycles": [_cycle(start, cycle) for start, cycle in zip(starts_deg, cycles, strict=True)]}


def portrait_report(portrait: Portrait, measured: MeasuredOverlay | None = None) -> Json:
    """The report of `cyclemap portrait`; with data it has one entry more, "data"."""
    report: Json = {
        "map": _map(portrait),
        "fixed_points": [
            {
                "theta_deg": _direction_deg(orbit.points[0]),
                "multiplier": _number(orbit.multiplier),
                "stable": bool(orbit.stable),
            }
            for orbit in portrait.fixed_points
        ],
        "rotation_number": _rotation(portrait),
        "stationary": _stationary(portrait),
        "staircase": _staircase(portrait),
    }
    return report if measured is None else {**report, "data": _data(measured)}


def json_text(report: Json) -> str:
    """The text of a report, ending with a line break; NaN and infinities are refused."""
    return json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _cycle(start_deg: float, cycle: Cycle) -> Json:
    dx, dy = cycle.push_displacement
    return {
        "theta0_deg": start_deg,
        "push_turn_deg": _degrees(cycle.push_turn),
        "push_dx_mm": _number(1000 * dx),
        "push_dy_mm": _number(1000 * dy),
        "drag_turn_deg": _degrees(cycle.drag_turn),
        "drag_mm": _number(1000 * cycle.drag_length),
        "theta1_deg": _degrees(cycle.theta_next),
    }


def _map(portrait: Portrait) -> Json:
    turns = portrait.turns
    return {
        "degree": int(portrait.map.degree),
        "samples": int(portrait.map.samples),
        "max_error_deg": _degrees(portrait.map.max_error),
        "mean_turn_deg": _degrees(turns.mean),
        "min_turn_deg": _degrees(turns.minimum),
        "max_turn_deg": _degrees(turns.maximum),
        "min_slope": _number(turns.min_slope),
        "max_slope": _number(turns.max_slope),
    }


def _rotation(portrait: Portrait) -> Json:
    rotation = portrait.rotation
    locked = rotation.locked
    return {
        "value": _number(rotation.value),
        "lower": _number(rotation.lower),
        "upper": _number(rotation.upper),
        "locked": None if locked is None else f"{locked.numerator}/{locked.denominator}",
    }


def _stationary(portrait: Portrait) -> Json:
    operator = portrait.operator
    return {
        "noise_deg": _degrees(portrait.noise.sigma),
        "peaks_deg": sorted(_direction_deg(peak) for peak in portrait.highest_peaks),
        "spectral_gap": _number(operator.spectral_gap),
        "mixing_cycles": _number(operator.mixing_cycles),
        "tv_from_uniform": _number(portrait.tv_from_uniform),
    }


def _staircase(portrait: Portrait) -> Json:
    prediction = portrait.prediction
    return {
        "mean_turn_deg": _degrees(prediction.mean_turn),
        "mean_residence_cycles": _number(prediction.mean_residence_cycles),
        "step_deg": _degrees(prediction.step),
    }


def _data(measured: MeasuredOverlay) -> Json:
    agreement = measured.agreement
    return {
        "pairs": agreement.pairs,
        "dropped": dict(measured.pairs.dropped),
        "rms_deg": _degrees(agreement.rms),
        "bins": agreement.bins,
        "bin_rms_deg": _degrees(agreement.bin_rms),
    }


def _number(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _degrees(radians: float | None) -> float | None:
    return None if radians is None else _number(math.degrees(radians))


def _direction_deg(radians: float) -> float:
    """Degrees in [0, 360); a hair below zero must not round to 360."""
    return float(np.degrees(radians) % 360.0) % 360.0
