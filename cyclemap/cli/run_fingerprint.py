"""`cyclemap fingerprint`: the five numbers of a protocol and what they predict, in sentences, as JSON, as a picture."""

import math
from pathlib import Path

from cyclemap.cli.json_report import Json, degrees, degrees_of, direction_deg, number, uncertainty_report
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import PeopleConsole, file_stem, people_table, progress_bar, publish
from cyclemap.cli.settings import chosen_loop
from cyclemap.collection.fingerprint import Anisotropy, Fingerprint, TurnResponse, fingerprint
from cyclemap.collection.fingerprint_check import PredictionCheck, check_prediction
from cyclemap.collection.fingerprint_prediction import PredictedDirection, Prediction, predict
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import InvalidInput
from cyclemap.maps import Orbit
from cyclemap.views.fingerprint_page import (
    check_sentence,
    direction_sentence,
    fingerprint_page,
    five_numbers,
    lock_in_sentence,
    protocol_sentence,
    surface_sentence,
    trust_sentence,
)
from cyclemap.views.sentences import uncertainty_sentence

COLUMNS = ("", "Ω (°)", "A₁ (°)", "δ₁ (°)", "A₂ (°)", "δ₂ (°)")


def run_fingerprint(options: LoopOptions, check: bool, out: Path, picture_format: str, json_target: str | None) -> None:
    """Compute the fingerprint and the prediction, draw both, and print them for people or as JSON."""
    loop, _ = chosen_loop(options)
    surface = Anisotropy.of(loop.material.friction)
    predicts = options.material is not None or max(surface.offset, surface.ellipticity) > 0.0
    if check and not predicts:
        raise InvalidInput("--check compares a prediction with the full map: name a MATERIAL or set its friction")
    name = loop.material.name if predicts else "protocol"
    found, prediction, checked = _computed(loop, surface if predicts else None, check, name)
    known = direction_uncertainty(loop) if predicts else None
    told = fingerprint_report(found, prediction, checked, name, known)
    page = fingerprint_page(found, prediction, checked, name)
    picture = publish(told, page, out / f"fingerprint_{file_stem(name)}", picture_format, json_target)
    if picture is not None:
        _print_for_people(found, prediction, checked, name, known)
        PeopleConsole().print(f"picture: {picture}")


def _computed(
    loop: CollectionLoop, surface: Anisotropy | None, check: bool, name: str
) -> tuple[Fingerprint, Prediction | None, PredictionCheck | None]:
    with progress_bar(f"fingerprint of {name}") as report:
        found = fingerprint(loop, (lambda done: report(0.2 * done)) if check else report)
        if surface is None:
            return found, None, None
        prediction = predict(found, surface)
        if not check:
            return found, prediction, None
        return found, prediction, check_prediction(prediction, loop, progress=lambda done: report(0.2 + 0.8 * done))


def _print_for_people(
    found: Fingerprint,
    prediction: Prediction | None,
    checked: PredictionCheck | None,
    name: str,
    known: DirectionUncertainty | None,
) -> None:
    console = PeopleConsole()
    table = people_table("Fingerprint of the protocol", COLUMNS, words=1)
    for part, response in (("push", found.push), ("drag", found.drag), ("cycle", found.cycle)):
        table.add_row(part, *five_numbers(response))
    console.print_table(table)
    console.print(protocol_sentence(found))
    if prediction is not None:
        console.print(surface_sentence(prediction, name))
        console.print(direction_sentence(prediction, name), style="bold")
        for sentence in filter(None, (lock_in_sentence(prediction), trust_sentence(prediction))):
            console.print(sentence)
    if told := uncertainty_sentence(name, known):
        console.print(told)
    if checked is not None:
        console.print(check_sentence(checked))


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
        surface, lock_in = prediction.anisotropy, prediction.lock_in
        locks = math.isfinite(lock_in.scale)
        report["prediction"] = {
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
    if known is not None:
        report["uncertainty"] = uncertainty_report(known)
    if checked is not None:
        report["full_map"] = {
            "fixed_points": [_orbit(orbit) for orbit in checked.fixed_points],
            "checked": [
                {
                    "predicted_deg": direction_deg(direction.predicted.theta),
                    "full_deg": None if direction.full is None else direction_deg(float(direction.full.points[0])),
                    "miss_deg": degrees(direction.miss),
                    "within_error": direction.within_error,
                }
                for direction in checked.directions
            ],
        }
    return report


def _response(response: TurnResponse) -> Json:
    five = ("turn", "offset_amplitude", "offset_phase", "ellipse_amplitude", "ellipse_phase")
    return degrees_of(response, *five)


def _direction(direction: PredictedDirection) -> Json:
    second = direction.second_order
    return {
        **_orbit(direction.orbit),
        "error_deg": degrees(direction.error),
        "second_order_deg": None if second is None else direction_deg(float(second.points[0])),
    }


def _orbit(orbit: Orbit) -> Json:
    return {
        "theta_deg": direction_deg(float(orbit.points[0])),
        "multiplier": number(orbit.multiplier),
        "stable": bool(orbit.stable),
    }
