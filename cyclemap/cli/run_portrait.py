"""`cyclemap portrait`, `cyclemap staircase`, and `cyclemap fingerprint`, the numbers of a protocol
and what they predict: in sentences, as JSON, and as pictures.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from rich.table import Table

from cyclemap.cli.commands import FingerprintOptions, PortraitOptions, StaircaseOptions
from cyclemap.cli.options import RunOptions
from cyclemap.cli.output import (
    Told,
    measured_report,
    orbit_deg,
    orbit_report,
    people_table,
    progress_bar,
    publish,
    result_name,
    steps_report,
    styled,
    uncertainty_report,
)
from cyclemap.collection.fingerprint import Fingerprint, fingerprint
from cyclemap.collection.fingerprint_prediction import (
    Prediction,
    PredictionCheck,
    check_prediction,
    predict,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy, floor_bow, floor_varies
from cyclemap.collection.portrait import (
    Portrait,
    StaircaseForecast,
    portrait,
    staircase_forecast,
)
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import InvalidInput
from cyclemap.protocol.settings import SETTINGS
from cyclemap.views import fingerprint_page, portrait_page, sentences
from cyclemap.written import DEGREES, Json, Unit, degrees, direction_deg, if_known, json_of, written

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, MeasuredStaircase, Theta0Pairs
    from cyclemap.sweeps.direction_margins import DirectionChange, DirectionMargin

_STAIRCASE = ("mean_turn", "mean_residence_cycles", "step")
COLUMNS = ("", "Ω (°)", "A₁ (°)", "δ₁ (°)", "A₂ (°)", "δ₂ (°)", "A₃ (°)", "δ₃ (°)")


def run_portrait(asked: PortraitOptions) -> None:
    """Compute the portrait, draw it, and print it for people or as JSON."""
    pairs = _pairs(asked)
    chosen = asked.loop.chosen_collection(asked.data).simplified()
    loop = chosen.loop
    if chosen.strategy is not None:
        from cyclemap.cli.run_reset import run_strategy_portrait

        if asked.margin:
            raise InvalidInput(
                "--margin tells how far one loop's settings are from a change, and a strategy "
                "has many"
            )
        run_strategy_portrait(chosen, chosen.strategy, pairs, asked)
        return
    run = asked.run_beside(pairs)
    with progress_bar(f"cycle map of {loop.material.name}") as done:
        drawn = portrait(loop, sigma=chosen.sigma, progress=done, **run)
    measured = None if pairs is None else _overlay(pairs, drawn)
    report = portrait_report(drawn, measured)
    margins = list[Told]()
    if asked.margin:
        report["margins"], margins = margins_of(loop)
    publish(
        report,
        portrait_page.portrait_page(drawn, portrait_curves(drawn), measured),
        asked.results,
        result_name("portrait", loop),
        *_lines(drawn, measured, margins),
    )


def portrait_report(portrait: Portrait, measured: MeasuredOverlay | None = None) -> Json:
    """The report of `cyclemap portrait`; with data it has one entry more, "data"."""
    rotation = portrait.rotation
    operator = portrait.operator
    locked = rotation.locked
    stationary: Json = {
        "noise_deg": degrees(portrait.noise.sigma),
        "peaks_deg": sorted(map(direction_deg, portrait.highest_peaks)),
        "spectral_gap": written(operator.spectral_gap),
        "mixing_cycles": written(operator.mixing_cycles),
        "tv_from_uniform": written(portrait.tv_from_uniform),
    }
    if portrait.held:
        stationary["held"] = [json_of(held, "peak", "share", "leaving") for held in portrait.held]
    report: Json = {
        "map": {
            "degree": portrait.map.degree,
            "samples": portrait.map.samples,
            "max_error_deg": degrees(portrait.map.max_error),
            **json_of(portrait.turns),
        },
        "fixed_points": [*map(orbit_report, portrait.fixed_points)],
        "rotation_number": {
            **json_of(rotation, "value", "lower", "upper"),
            "locked": None if locked is None else f"{locked.numerator}/{locked.denominator}",
        },
        "stationary": stationary,
        "staircase": json_of(portrait.prediction, *_STAIRCASE),
        **_prospects(portrait),
    }
    if measured is not None:
        report["data"] = {
            "pairs": measured.agreement.pairs,
            "dropped": dict(measured.pairs.dropped),
            **json_of(measured.agreement, "bins", "rms", "bin_rms"),
        }
    return report


def _prospects(result: Portrait | StaircaseForecast) -> Json:
    """How sure a prediction is, what the next pushes bring, and the worn surface, where known."""
    report: Json = {}
    if result.uncertainty is not None:
        report["uncertainty"] = uncertainty_report(result.uncertainty)
    if result.forecast is not None:
        report["forecast"] = json_of(result.forecast)
    if result.worn is not None:
        report["worn"] = json_of(result.worn)
    return report


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


def _pairs(asked: RunOptions) -> Theta0Pairs | None:
    """The measured pairs of θ0, if any."""
    if asked.data is None:
        return None
    from cyclemap.cli.collected.readable_data import readable_data
    from cyclemap.evidence.comparison.collection_data import measured_pairs

    return measured_pairs(readable_data(asked.data, asked.table, asked.results.out))


def run_staircase(asked: StaircaseOptions) -> None:
    """Predict the staircase, set the measured one beside it, draw both, and print them for people
    or as JSON.
    """
    from cyclemap.evidence import measured_staircase

    pairs = _pairs(asked)
    chosen = asked.loop.chosen_collection(asked.data).simplified()
    loop = chosen.loop
    measured = None if pairs is None else measured_staircase(pairs, asked.seed)
    if chosen.strategy is not None:
        from cyclemap.cli.run_reset import run_strategy_staircase

        run_strategy_staircase(chosen, chosen.strategy, measured, asked)
        return
    run = asked.run_beside(measured)
    with progress_bar(f"staircase of {loop.material.name}") as report:
        forecast = staircase_forecast(loop, sigma=chosen.sigma, progress=report, **run)
    publish(
        staircase_report(forecast, measured),
        portrait_page.staircase_page(forecast, measured),
        asked.results,
        result_name("staircase", loop),
        portrait_page.forecast_sentence(forecast),
        portrait_page.worn_sentence(forecast),
        portrait_page.run_sentence(forecast),
        sentences.uncertainty_sentence(loop.material.name, forecast.uncertainty),
        sentences.ahead_sentence(forecast.forecast),
        "" if measured is None else portrait_page.measured_sentence(measured),
        "" if measured is None else portrait_page.fitted_sentence(measured),
    )


def staircase_report(
    forecast: StaircaseForecast, measured: MeasuredStaircase | None = None
) -> Json:
    """The report of `cyclemap staircase`; with data it has one entry more, "data"."""
    zones = zip(forecast.prediction.zones, forecast.log10_residences, strict=True)
    report: Json = {
        "noise_deg": degrees(forecast.noise.sigma),
        "prediction": {
            **json_of(forecast.prediction, *_STAIRCASE),
            "zones": [
                {**json_of(zone), "log10_residence_cycles": written(log10)} for zone, log10 in zones
            ],
        },
        "run": {"seed": forecast.staircase.seed, **steps_report(forecast.steps)},
        **_prospects(forecast),
    }
    return report if measured is None else {**report, "data": measured_report(measured)}


def run_fingerprint(asked: FingerprintOptions) -> None:
    """Compute the fingerprint and the prediction, draw both, and print them for people or as
    JSON.
    """
    loop = asked.loop.chosen_loop().loop
    surface = Anisotropy.of(loop.material.friction)
    bow = floor_bow(loop)
    is_named = asked.loop.surface is not None or max(surface.offset, surface.ellipticity) > 0.0
    varies = floor_varies(loop)
    predicts = is_named and bow == 0.0 and not varies
    if asked.check and bow:
        raise InvalidInput(
            f"--check compares a prediction for a floor without a bow, but this one has {bow:.3g} "
            "mean pressures: set floor_bow=0, or ask for the portrait"
        )
    if asked.check and varies:
        raise InvalidInput(
            "--check compares a prediction for a floor that is alike everywhere, but this one has "
            "a field: ask for the portrait"
        )
    if asked.check and not predicts:
        raise InvalidInput(
            "--check compares a prediction with the full map: name a MATERIAL or set its friction"
        )
    name = loop.material.name if predicts else "protocol"
    with progress_bar(f"fingerprint of {name}") as report:
        numbers = fingerprint(loop, (lambda done: report(0.2 * done)) if asked.check else report)
        prediction = predict(numbers, surface) if predicts else None
        checked = None
        if asked.check and prediction is not None:
            checked = check_prediction(
                prediction, loop, progress=lambda done: report(0.2 + 0.8 * done)
            )
    known = direction_uncertainty(loop) if predicts else None
    as_json = fingerprint_report(numbers, prediction, checked, name, known)
    lines: list[Told] = [_seven_numbers(numbers), fingerprint_page.protocol_sentence(numbers)]
    if prediction is not None:
        lines += [
            fingerprint_page.surface_sentence(prediction, name),
            styled(fingerprint_page.direction_sentence(prediction, name), "bold"),
            fingerprint_page.lock_in_sentence(prediction),
            fingerprint_page.trust_sentence(prediction),
        ]
    if asked.margin:
        as_json["margins"], margins = margins_of(loop)
        lines += margins
    publish(
        as_json,
        fingerprint_page.fingerprint_page(numbers, prediction, checked, name),
        asked.results,
        result_name("fingerprint", loop, name),
        *lines,
        fingerprint_page.floor_sentence(numbers, bow, varies),
        sentences.uncertainty_sentence(name, known),
        "" if checked is None else fingerprint_page.check_sentence(checked),
    )


def _seven_numbers(numbers: Fingerprint) -> Table:
    rows = []
    for stroke in ("push", "drag", "cycle"):
        rows.append((stroke, *fingerprint_page.seven_numbers(getattr(numbers, stroke))))
    return people_table("Fingerprint of the protocol", COLUMNS, rows, words=(0,))


def fingerprint_report(
    numbers: Fingerprint,
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
        **json_of(numbers.cycle),
        **json_of(numbers, "push", "drag", "remainder", "bow_remainder"),
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
                    "full_deg": if_known(orbit_deg, direction.full),
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
                "second_order_deg": if_known(orbit_deg, direction.second_order),
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


def margins_of(loop: CollectionLoop) -> tuple[list[Json], list[Told]]:
    """How far every setting of a loop is from a change of its stable directions: as JSON, and what
    people are told of it.
    """
    from cyclemap.sweeps.direction_margins import direction_margins

    with progress_bar("margins of the settings") as report:
        margins = direction_margins(loop, progress=report)
    words: list[Told] = [sentences.margin_sentence(margins)]
    if rows := sentences.margin_rows(margins):
        title = "Where stable directions come and go"
        words.append(people_table(title, sentences.MARGIN_COLUMNS, rows, words=(0,)))
    return [*map(margin_report, margins)], words


def margin_report(margin: DirectionMargin) -> Json:
    """How far a setting is from a change of the stable directions, in the unit of its key."""
    unit = Unit("", SETTINGS[margin.key].unit.of_si)
    return {
        **json_of(margin, "key", "value", "directions", unit=unit),
        "below": if_known(partial(_change, unit=unit), margin.below),
        "above": if_known(partial(_change, unit=unit), margin.above),
        "searched": written((margin.low, margin.high), unit),
        "share": written(margin.share),
    }


def _change(change: DirectionChange, unit: Unit) -> Json:
    return {
        **json_of(change, "value", unit=unit),
        "error": written(change.value.error_bound, unit),
        **json_of(change, "kind", "theta", "directions"),
    }
