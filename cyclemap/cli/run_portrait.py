"""`cyclemap portrait` and `cyclemap staircase`: in sentences, as JSON, and as pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cyclemap.cli.json_report import portrait_report, staircase_report
from cyclemap.cli.options import RunOptions
from cyclemap.cli.output import (
    Told,
    margins_of,
    people_table,
    progress_bar,
    publish,
    result_stem,
    styled,
)
from cyclemap.collection.portrait import Portrait, portrait, staircase_forecast
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.errors import InvalidInput
from cyclemap.protocol.chosen_loop import chosen_collection
from cyclemap.views import portrait_page, sentences

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, Theta0Pairs


def run_portrait(asked: RunOptions, margin: bool) -> None:
    """Compute the portrait, draw it, and print it for people or as JSON."""
    pairs = asked.pairs()
    chosen = chosen_collection(asked.options, asked.data).simplified()
    loop = chosen.loop
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_portrait

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
        from cyclemap.cli.run_strategy import run_strategy_staircase

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
