"""A fingerprint and what it predicts as JSON: angles in degrees, every number finite or null."""

import math

from cyclemap.cli.json_numbers import degrees, direction_deg, number
from cyclemap.cli.json_report import Json, uncertainty_report
from cyclemap.collection.fingerprint import Fingerprint, TurnResponse
from cyclemap.collection.fingerprint_check import CheckedDirection, PredictionCheck
from cyclemap.collection.fingerprint_prediction import PredictedDirection, Prediction
from cyclemap.collection.uncertain_directions import DirectionUncertainty
from cyclemap.maps import Orbit


def fingerprint_report(
    found: Fingerprint,
    prediction: Prediction | None,
    checked: PredictionCheck | None,
    name: str,
    known: DirectionUncertainty | None = None,
) -> Json:
    """The report of `cyclemap fingerprint`: the five numbers, with "prediction" and "full_map" where asked for.

    "uncertainty" is of the stable directions of the full map.
    """
    report: Json = {
        **_response(found.cycle),
        "push": _response(found.push),
        "drag": _response(found.drag),
        "remainder_per_rad": number(found.remainder),
    }
    if prediction is not None:
        report["prediction"] = _prediction(prediction, name)
    if known is not None:
        report["uncertainty"] = uncertainty_report(known)
    if checked is not None:
        report["full_map"] = {
            "fixed_points": [_orbit(orbit) for orbit in checked.fixed_points],
            "checked": [_checked(direction) for direction in checked.directions],
        }
    return report


def _response(response: TurnResponse) -> Json:
    return {
        "turn_deg": degrees(response.turn),
        "offset_amplitude_deg": degrees(response.offset_amplitude),
        "offset_phase_deg": degrees(response.offset_phase),
        "ellipse_amplitude_deg": degrees(response.ellipse_amplitude),
        "ellipse_phase_deg": degrees(response.ellipse_phase),
    }


def _prediction(prediction: Prediction, name: str) -> Json:
    surface, lock_in = prediction.anisotropy, prediction.lock_in
    locks = math.isfinite(lock_in.scale)
    return {
        "material": name,
        "offset": number(surface.offset),
        "offset_direction_deg": direction_deg(surface.offset_direction),
        "ellipticity": number(surface.ellipticity),
        "ellipse_direction_deg": direction_deg(surface.ellipse_direction),
        "verdict": prediction.verdict,
        "trusted": prediction.trusted,
        "error_ratio": number(prediction.ratio),
        "directions": [_direction(direction) for direction in prediction.directions],
        "second_order_directions": [_orbit(orbit) for orbit in prediction.second_order_points],
        "mean_turn_deg": degrees(prediction.mean_turn),
        "slowest_deg": direction_deg(prediction.slowest),
        "slowest_turn_deg": degrees(float(prediction.turn(prediction.slowest))),
        "lock_in_scale": number(lock_in.scale),
        "lock_in_scale_range": [number(factor) for factor in prediction.lock_in_range],
        "lock_in_deg": direction_deg(lock_in.theta) if locks else None,
    }


def _direction(direction: PredictedDirection) -> Json:
    second = direction.second_order
    return {
        **_orbit(direction.orbit),
        "error_deg": degrees(direction.error),
        "second_order_deg": None if second is None else direction_deg(float(second.points[0])),
    }


def _checked(checked: CheckedDirection) -> Json:
    return {
        "predicted_deg": direction_deg(checked.predicted.theta),
        "full_deg": None if checked.full is None else direction_deg(float(checked.full.points[0])),
        "miss_deg": degrees(checked.miss),
        "within_error": checked.within_error,
    }


def _orbit(orbit: Orbit) -> Json:
    return {
        "theta_deg": direction_deg(float(orbit.points[0])),
        "multiplier": number(orbit.multiplier),
        "stable": bool(orbit.stable),
    }
