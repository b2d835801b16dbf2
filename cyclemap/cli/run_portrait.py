"""`cyclemap portrait` and `cyclemap staircase`: each in sentences, as JSON, and as a picture."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cyclemap.cli.json_report import portrait_report, staircase_report
from cyclemap.cli.options import LoopOptions, RunRequest
from cyclemap.cli.output import PeopleConsole, file_stem, people_table, progress_bar, publish
from cyclemap.cli.settings import chosen_collection
from cyclemap.collection.portrait import DEFAULT_CYCLES, DEFAULT_SIGMA, Portrait, portrait, staircase_forecast
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.views import sentences
from cyclemap.views.portrait_page import portrait_page

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay, Theta0Pairs


def run_portrait(options: LoopOptions, request: RunRequest, json_target: str | None) -> None:
    """Compute the portrait, draw it, and print it for people or as JSON."""
    chosen, pairs = chosen_collection(options).simplified(), request.data
    loop, sigma = chosen.loop, chosen.sigma
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_portrait

        noise = DEFAULT_SIGMA if sigma is None else sigma
        run_strategy_portrait(loop, chosen.strategy, noise, request, pairs, json_target)
        return
    # The staircase starts where the data start and is as long, unless told otherwise.
    path = None if pairs is None else pairs.path
    cycles, start = (DEFAULT_CYCLES, 0.0) if path is None else (len(path) - 1, float(path[0]))
    with progress_bar(f"cycle map of {loop.material.name}") as report:
        found = portrait(
            loop, sigma=sigma, cycles=request.cycles or cycles, start=start, seed=request.seed, progress=report
        )
    measured = None if pairs is None else _overlay(pairs, found)
    page, stem = portrait_page(found, portrait_curves(found), measured), f"portrait_{file_stem(loop.material.name)}"
    picture = publish(portrait_report(found, measured), page, request.out / stem, request.picture_format, json_target)
    if picture is not None:
        _tell(found, measured, picture)


def _tell(found: Portrait, measured: MeasuredOverlay | None, picture: Path) -> None:
    console, material = PeopleConsole(), found.loop.material
    told = [sentences.lock_sentence(found), sentences.noise_sentence(found), sentences.staircase_sentence(found)]
    told.append(sentences.uncertainty_sentence(material.name, found.uncertainty))
    if measured is not None:
        told.append(sentences.agreement_sentence(measured.agreement))
    console.tell(sentences.headline(found), *filter(None, told))
    if found.fixed_points:
        table = people_table("Fixed points of the cycle map", ("θ0 (°)", "multiplier", ""))
        for orbit in found.fixed_points:
            table.add_row(f"{math.degrees(orbit.points[0]):.3f}", f"{orbit.multiplier:.4f}", orbit.kind)
        console.print_table(table)
    if line := sentences.material_line(material):
        console.print(line)
    for tell in (sentences.push_line, sentences.parameters_line, sentences.accuracy_line):
        console.print(tell(found), style="dim")
    console.print(f"picture: {picture}")


def _overlay(pairs: Theta0Pairs, drawn: Portrait) -> MeasuredOverlay:
    """The pairs beside the map; where it wears and their cycles are known, each beside the map of its own cycle."""
    from cyclemap.evidence import measured_overlay
    from cyclemap.evidence.comparison.cycle_agreement import cycle_agreement
    from cyclemap.evidence.comparison.prediction import Prediction

    overlay = measured_overlay(pairs, drawn.map.turn)
    if drawn.drifting is None or pairs.cycle is None:
        return overlay
    prediction = Prediction(drawn.drifting, drawn.noise, "loop", drawn.loop)
    return replace(overlay, agreement=cycle_agreement(prediction, pairs).agreement)


def run_staircase(options: LoopOptions, request: RunRequest, json_target: str | None) -> None:
    """Predict the staircase, set the measured one beside it, draw both, and print them for people or as JSON."""
    from cyclemap.evidence import measured_staircase
    from cyclemap.views import staircase_page

    chosen = chosen_collection(options).simplified()
    loop, sigma = chosen.loop, chosen.sigma
    measured = None if request.data is None else measured_staircase(request.data, request.seed)
    if chosen.strategy is not None:
        from cyclemap.cli.run_strategy import run_strategy_staircase

        noise = DEFAULT_SIGMA if sigma is None else sigma
        run_strategy_staircase(loop, chosen.strategy, noise, request, measured, json_target)
        return
    # The run starts where the data start and is as long, unless told otherwise.
    cycles, start = (DEFAULT_CYCLES, 0.0) if measured is None else (len(measured.path) - 1, float(measured.path[0]))
    with progress_bar(f"staircase of {loop.material.name}") as report:
        forecast = staircase_forecast(
            loop, sigma=sigma, cycles=request.cycles or cycles, start=start, seed=request.seed, progress=report
        )
    stem = request.out / f"staircase_{file_stem(loop.material.name)}"
    page = staircase_page.staircase_page(forecast, measured)
    picture = publish(staircase_report(forecast, measured), page, stem, request.picture_format, json_target)
    if picture is None:
        return
    told = [staircase_page.worn_sentence(forecast), staircase_page.run_sentence(forecast)]
    told.append(sentences.uncertainty_sentence(loop.material.name, forecast.uncertainty))
    if measured is not None:
        told += [staircase_page.measured_sentence(measured), staircase_page.fitted_sentence(measured)]
    words = staircase_page.forecast_sentence(forecast), *filter(None, told), f"picture: {picture}"
    PeopleConsole().tell(*words)
