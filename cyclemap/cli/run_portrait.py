"""`cyclemap portrait`, `cyclemap staircase`, and `cyclemap fingerprint`, the numbers of a protocol
and what they predict: in sentences, as JSON, and as pictures.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cyclemap.cli.json_report import (
    orbit_report,
    portrait_report,
    staircase_report,
    uncertainty_report,
)
from cyclemap.cli.options import ResultOptions, RunOptions
from cyclemap.cli.output import (
    Told,
    margins_of,
    people_table,
    progress_bar,
    publish,
    result_stem,
    styled,
)
from cyclemap.collection.fingerprint import Fingerprint, fingerprint
from cyclemap.collection.fingerprint_prediction import (
    Prediction,
    PredictionCheck,
    check_prediction,
    predict,
)
from cyclemap.collection.loop_surfaces import Anisotropy, floor_bow
from cyclemap.collection.portrait import Portrait, portrait, staircase_forecast
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import InvalidInput
from cyclemap.maps import Orbit
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection, chosen_loop
from cyclemap.views import fingerprint_page, portrait_page, sentences
from cyclemap.written import DEGREES, Json, degrees, direction_deg, json_of, written

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, Theta0Pairs

COLUMNS = ("", "Ω (°)", "A₁ (°)", "δ₁ (°)", "A₂ (°)", "δ₂ (°)", "A₃ (°)", "δ₃ (°)")


def run_portrait(asked: RunOptions, margin: bool) -> None:
    """Compute the portrait, draw it, and print it for people or as JSON."""
    pairs = asked.pairs()
    chosen = chosen_collection(asked.options, asked.data).simplified()
    loop = chosen.loop
    if chosen.strategy is not None:
        from cyclemap.cli.run_reset import run_strategy_portrait

        if margin:
            raise InvalidInput(
                "--margin tells how far one loop's settings are from a change, and a strategy "
                "has many"
            )
        run_strategy_portrait(chosen, chosen.strategy, pairs, asked)
        return
    run = asked.run_beside(None if pairs is None else pairs.path)
    with progress_bar(f"cycle map of {loop.material.name}") as done:
        drawn = portrait(loop, sigma=chosen.sigma, progress=done, **run)
    measured = None if pairs is None else _overlay(pairs, drawn)
    report = portrait_report(drawn, measured)
    margins = list[Told]()
    if margin:
        report["margins"], margins = margins_of(loop)
    publish(
        report,
        portrait_page.portrait_page(drawn, portrait_curves(drawn), measured),
        result_stem(asked.results.out, "portrait", loop),
        asked.results,
        *_lines(drawn, measured, margins),
    )


def _lines(
    drawn: Portrait, measured: MeasuredOverlay | None, margins: Sequence[Told]
) -> list[Told]:
    """What people are told of a portrait, in order."""
    material = drawn.loop.material
    rows = [
        (f"{math.degrees(orbit.points[0]):.3f}", f"{orbit.multiplier:.4f}", orbit.kind)
        for orbit in drawn.fixed_points
    ]
    columns = ("θ0 (°)", "multiplier", "")
    return [
        sentences.headline(drawn),
        sentences.lock_sentence(drawn),
        sentences.noise_sentence(drawn),
        sentences.staircase_sentence(drawn),
        sentences.uncertainty_sentence(material.name, drawn.uncertainty),
        sentences.ahead_sentence(drawn.forecast),
        "" if measured is None else sentences.agreement_sentence(measured.agreement),
        people_table("Fixed points of the cycle map", columns, rows) if rows else "",
        *margins,
        sentences.material_line(material),
        styled(sentences.push_line(drawn), "dim"),
        styled(sentences.parameters_line(drawn), "dim"),
        styled(sentences.accuracy_line(drawn), "dim"),
    ]


def _overlay(pairs: Theta0Pairs, drawn: Portrait) -> MeasuredOverlay:
    """The pairs beside the map; where it wears and their cycles are known, each beside the map of
    its own cycle.
    """
    from cyclemap.evidence import measured_overlay
    from cyclemap.evidence.comparison.collection_null import CollectionModel
    from cyclemap.evidence.comparison.cycle_agreement import cycle_agreement

    overlay = measured_overlay(pairs, drawn.map.turn)
    if drawn.drifting is None or pairs.cycle is None:
        return overlay
    model = CollectionModel(drawn.drifting, drawn.noise)
    return replace(overlay, agreement=cycle_agreement(model, drawn.loop, pairs).agreement)


def run_staircase(asked: RunOptions) -> None:
    """Predict the staircase, set the measured one beside it, draw both, and print them for people
    or as JSON.
    """
    from cyclemap.evidence import measured_staircase

    pairs = asked.pairs()
    chosen = chosen_collection(asked.options, asked.data).simplified()
    loop = chosen.loop
    measured = None if pairs is None else measured_staircase(pairs, asked.seed)
    if chosen.strategy is not None:
        from cyclemap.cli.run_reset import run_strategy_staircase

        run_strategy_staircase(chosen, chosen.strategy, measured, asked)
        return
    run = asked.run_beside(None if measured is None else measured.path)
    with progress_bar(f"staircase of {loop.material.name}") as report:
        forecast = staircase_forecast(loop, sigma=chosen.sigma, progress=report, **run)
    publish(
        staircase_report(forecast, measured),
        portrait_page.staircase_page(forecast, measured),
        result_stem(asked.results.out, "staircase", loop),
        asked.results,
        portrait_page.forecast_sentence(forecast),
        portrait_page.worn_sentence(forecast),
        portrait_page.run_sentence(forecast),
        sentences.uncertainty_sentence(loop.material.name, forecast.uncertainty),
        sentences.ahead_sentence(forecast.forecast),
        "" if measured is None else portrait_page.measured_sentence(measured),
        "" if measured is None else portrait_page.fitted_sentence(measured),
    )


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
        lines += [
            fingerprint_page.surface_sentence(prediction, name),
            styled(fingerprint_page.direction_sentence(prediction, name), "bold"),
            fingerprint_page.lock_in_sentence(prediction),
            fingerprint_page.trust_sentence(prediction),
        ]
    if margin:
        as_json["margins"], margins = margins_of(loop)
        lines += margins
    if bow:
        lines.append(fingerprint_page.bow_sentence(numbers, bow))
    lines.append(sentences.uncertainty_sentence(name, known))
    if checked is not None:
        lines.append(fingerprint_page.check_sentence(checked))
    publish(
        as_json,
        fingerprint_page.fingerprint_page(numbers, prediction, checked, name),
        result_stem(results.out, "fingerprint", loop, name),
        results,
        *lines,
    )


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
