"""`cyclemap staircase` with a strategy: one run of it in sentences, as JSON, and as a picture."""

from pathlib import Path

from cyclemap.cli.json_numbers import degrees
from cyclemap.cli.json_report import Json, measured_report, steps_report
from cyclemap.cli.options import RunRequest
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES
from cyclemap.evidence import MeasuredStaircase
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategy_staircase import StrategyStaircase, strategy_staircase
from cyclemap.views import strategy_sentences as sentences
from cyclemap.views.staircase_sentences import fitted_sentence, measured_sentence
from cyclemap.views.strategy_staircase_page import strategy_staircase_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole


def run_strategy_staircase(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    request: RunRequest,
    measured: MeasuredStaircase | None,
    json_target: str | None,
) -> None:
    """Run the strategy, set the measured staircase beside it, draw both, and print them for people or as JSON."""
    length = DEFAULT_CYCLES if measured is None else len(measured.path) - 1
    start = 0.0 if measured is None else float(measured.path[0])
    cycles = request.cycles or length
    with progress_bar(f"staircase of {loop.material.name}") as report:
        found = strategy_staircase(
            loop, strategy, sigma=sigma, cycles=cycles, start=start, seed=request.seed, progress=report
        )
    told = strategy_staircase_report(found, measured)
    stem = request.out / f"staircase_{file_stem(loop.material.name)}"
    write_json(stem.with_name(f"{stem.name}.json"), told)
    picture = stem.with_name(f"{stem.name}.{request.picture_format}")
    write_whole(picture, render(strategy_staircase_page(found, measured), request.picture_format))
    if not publish_json(told, json_target):
        _print_for_people(found, measured, picture)


def strategy_staircase_report(found: StrategyStaircase, measured: MeasuredStaircase | None) -> Json:
    """The keys of the report without a strategy; what belongs to one map is null, and `reason` says why."""
    report: Json = {
        "noise_deg": degrees(found.noise.sigma),
        "prediction": {
            "mean_turn_deg": None,
            "mean_residence_cycles": None,
            "step_deg": None,
            "zones": [],
            "reason": "the map changes from cycle to cycle: cyclemap portrait tells the mean turn and the law of θ0",
        },
        "run": {
            "seed": found.run.seed,
            "followed": "mechanics" if found.maps is None else "maps",
            **steps_report(found.steps),
        },
    }
    return report if measured is None else {**report, "data": measured_report(measured)}


def _print_for_people(found: StrategyStaircase, measured: MeasuredStaircase | None, picture: Path) -> None:
    console = PeopleConsole()
    console.print(sentences.staircase_headline(found), style="bold")
    console.print(sentences.run_sentence(found))
    if measured is not None:
        console.print(measured_sentence(measured))
        console.print(fitted_sentence(measured))
    console.print(f"picture: {picture}")
