"""`cyclemap portrait`: in sentences, as JSON, and as a picture."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cyclemap.cli.json_report import margin_report, portrait_report
from cyclemap.cli.options import ResultOptions, TableOptions, measured_orientations
from cyclemap.cli.output import (
    PeopleConsole,
    margins_of,
    people_table,
    progress_bar,
    publish,
    result_stem,
    tell_margins,
)
from cyclemap.collection.portrait import DEFAULT_CYCLES, Portrait, portrait
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.errors import InvalidInput
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.views import sentences
from cyclemap.views.portrait_page import portrait_page

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, Theta0Pairs


def run_portrait(
    options: LoopOptions,
    data: Path | None,
    table: TableOptions,
    cycles: int | None,
    seed: int,
    margin: bool,
    results: ResultOptions,
) -> None:
    """Compute the portrait, draw it, and print it for people or as JSON."""
    pairs, chosen = (
        measured_orientations(data, table, results.out),
        chosen_collection(options, data).simplified(),
    )
    loop, sigma = chosen.loop, chosen.sigma
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_portrait

        if margin:
            raise InvalidInput(
                "--margin tells how far one loop's settings are from a change, and a strategy "
                "has many"
            )

        run_strategy_portrait(chosen, chosen.strategy, pairs, cycles, seed, results)
        return
    # The staircase starts where the data start and is as long, unless told otherwise.
    path = None if pairs is None else pairs.path
    length, start = (DEFAULT_CYCLES, 0.0) if path is None else (len(path) - 1, float(path[0]))
    with progress_bar(f"cycle map of {loop.material.name}") as done:
        found = portrait(
            loop, sigma=sigma, cycles=cycles or length, start=start, seed=seed, progress=done
        )
    measured = None if pairs is None else _overlay(pairs, found)
    page, stem = (
        portrait_page(found, portrait_curves(found), measured),
        result_stem(results.out, "portrait", loop),
    )
    report, margins = portrait_report(found, measured), margins_of(loop) if margin else None
    if margins is not None:
        report["margins"] = [*map(margin_report, margins)]
    picture = publish(report, page, stem, results)
    if picture is None:
        return
    console, material = PeopleConsole(), found.loop.material
    told = [
        sentences.lock_sentence(found),
        sentences.noise_sentence(found),
        sentences.staircase_sentence(found),
    ]
    told.append(sentences.uncertainty_sentence(material.name, found.uncertainty))
    told.append(sentences.ahead_sentence(found.forecast))
    if measured is not None:
        told.append(sentences.agreement_sentence(measured.agreement))
    console.tell(sentences.headline(found), *filter(None, told))
    if found.fixed_points:
        rows = [
            (f"{math.degrees(o.points[0]):.3f}", f"{o.multiplier:.4f}", o.kind)
            for o in found.fixed_points
        ]
        console.print_table(
            people_table("Fixed points of the cycle map", ("θ0 (°)", "multiplier", ""), rows)
        )
    if margins is not None:
        tell_margins(console, margins)
    if line := sentences.material_line(material):
        console.print(line)
    for tell in (sentences.push_line, sentences.parameters_line, sentences.accuracy_line):
        console.print(tell(found), style="dim")
    console.print(f"picture: {picture}")


def _overlay(pairs: Theta0Pairs, drawn: Portrait) -> MeasuredOverlay:
    """The pairs beside the map; where it wears and their cycles are known, each beside the map of
    its own cycle.
    """
    from cyclemap.evidence import measured_overlay
    from cyclemap.evidence.comparison.cycle_agreement import cycle_agreement
    from cyclemap.evidence.comparison.prediction import Prediction

    overlay = measured_overlay(pairs, drawn.map.turn)
    if drawn.drifting is None or pairs.cycle is None:
        return overlay
    prediction = Prediction(drawn.drifting, drawn.noise, "loop", drawn.loop)
    return replace(overlay, agreement=cycle_agreement(prediction, pairs).agreement)
