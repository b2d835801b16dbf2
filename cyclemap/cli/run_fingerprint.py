"""`cyclemap fingerprint`: the numbers of a protocol and what they predict, in sentences, as JSON,
as a picture.
"""

import math

from cyclemap.cli.json_report import orbit_report, uncertainty_report
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import (
    Told,
    margins_of,
    people_table,
    progress_bar,
    publish,
    result_stem,
    styled,
)
from cyclemap.collection.fingerprint import Anisotropy, Fingerprint, fingerprint, floor_bow
from cyclemap.collection.fingerprint_prediction import (
    Prediction,
    PredictionCheck,
    check_prediction,
    predict,
)
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import InvalidInput
from cyclemap.maps import Orbit
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views import fingerprint_page
from cyclemap.views.sentences import uncertainty_sentence
from cyclemap.written import DEGREES, Json, degrees, direction_deg, json_of, written

COLUMNS = ("", "Ω (°)", "A₁ (°)", "δ₁ (°)", "A₂ (°)", "δ₂ (°)", "A₃ (°)", "δ₃ (°)")


def run_fingerprint(
    options: LoopOptions,
    check: bool,
    margin: bool,
    results: ResultOptions,
) -> None:
    """Compute the fingerprint and the prediction, draw both, and print them for people or as
    JSON.
    """
    loop = chosen_loop(options).loop
    surface = Anisotropy.of(loop.material.friction)
    bow = floor_bow(loop)
    is_named = options.material is not None or max(surface.offset, surface.ellipticity) > 0.0
    predicts = is_named and bow == 0.0
    if check and not predicts:
        if bow:
            raise InvalidInput(
                f"--check compares a prediction for a floor without a bow, but this one has "
                f"{bow:.3g} mean pressures: set floor_bow=0, or ask for the portrait"
            )
        raise InvalidInput(
            "--check compares a prediction with the full map: name a MATERIAL or set its friction"
        )
    name = loop.material.name if predicts else "protocol"
    with progress_bar(f"fingerprint of {name}") as report:
        numbers = fingerprint(loop, (lambda done: report(0.2 * done)) if check else report)
        prediction = predict(numbers, surface) if predicts else None
        checked = None
        if check and prediction is not None:
            checked = check_prediction(
                prediction, loop, progress=lambda done: report(0.2 + 0.8 * done)
            )
    known = direction_uncertainty(loop) if predicts else None
    as_json = fingerprint_report(numbers, prediction, checked, name, known)
    rows = []
    for stroke in ("push", "drag", "cycle"):
        rows.append((stroke, *fingerprint_page.seven_numbers(getattr(numbers, stroke))))
    lines: list[Told] = [
        people_table("Fingerprint of the protocol", COLUMNS, rows, words=(0,)),
        fingerprint_page.protocol_sentence(numbers),
    ]
    if prediction is not None:
        lines += _prediction_lines(prediction, name)
    if margin:
        as_json["margins"], margins = margins_of(loop)
        lines += margins
    if bow:
        lines.append(fingerprint_page.bow_sentence(numbers, bow))
    lines.append(uncertainty_sentence(name, known))
    if checked is not None:
        lines.append(fingerprint_page.check_sentence(checked))
    publish(
        as_json,
        fingerprint_page.fingerprint_page(numbers, prediction, checked, name),
        result_stem(results.out, "fingerprint", loop, name),
        results,
        *lines,
    )


def _prediction_lines(prediction: Prediction, name: str) -> list[Told]:
    return [
        fingerprint_page.surface_sentence(prediction, name),
        styled(fingerprint_page.direction_sentence(prediction, name), "bold"),
        fingerprint_page.lock_in_sentence(prediction),
        fingerprint_page.trust_sentence(prediction),
    ]


def fingerprint_report(
    found: Fingerprint,
    prediction: Prediction | None,
    checked: PredictionCheck | None,
    name: str,
    known: DirectionUncertainty | None = None,
) -> Json:
    """The report of `cyclemap fingerprint`: the seven numbers, with "prediction" and "full_map"
    where asked for.

    "uncertainty" is of the stable directions of the full map.
    """
    report: Json = {
        **json_of(found.cycle),
        **json_of(found, "push", "drag", "remainder", "bow_remainder"),
    }
    if prediction is not None:
        report["prediction"] = _prediction(prediction, name)
    if known is not None:
        report["uncertainty"] = uncertainty_report(known)
    if checked is not None:
        report["full_map"] = {
            "fixed_points": [*map(orbit_report, checked.fixed_points)],
            "checked": [
                {
                    "predicted_deg": direction_deg(direction.predicted.theta),
                    "full_deg": _direction(direction.full),
                    "miss_deg": degrees(direction.miss),
                    "within_error": direction.within_error,
                }
                for direction in checked.directions
            ],
        }
    return report


def _prediction(prediction: Prediction, name: str) -> Json:
    lock_in = prediction.lock_in
    locks = math.isfinite(lock_in.scale)
    return {
        "material": name,
        **json_of(prediction.anisotropy),
        **json_of(prediction, "verdict", "trusted"),
        "error_ratio": written(prediction.ratio),
        "directions": [
            {
                **orbit_report(direction.orbit),
                "error_deg": degrees(direction.error),
                "second_order_deg": _direction(direction.second_order),
            }
            for direction in prediction.directions
        ],
        "second_order_directions": [*map(orbit_report, prediction.second_order_points)],
        **json_of(prediction, "mean_turn", unit=DEGREES),
        "slowest_deg": direction_deg(prediction.slowest),
        "slowest_turn_deg": degrees(prediction.turn(prediction.slowest)),
        "lock_in_scale": written(lock_in.scale),
        "lock_in_scale_range": written(prediction.lock_in_range),
        "lock_in_deg": direction_deg(lock_in.theta) if locks else None,
    }


def _direction(orbit: Orbit | None) -> float | None:
    return None if orbit is None else direction_deg(float(orbit.points[0]))
