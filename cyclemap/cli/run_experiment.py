"""`cyclemap experiment`: the paper's numerical experiment in sentences, as JSON, and as a picture."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.cli.json_numbers import degrees, direction_deg, number, numbers
from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.settings import chosen_loop
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.batch_experiment import WITHIN, BatchExperiment, BatchRun, batch_experiment
from cyclemap.collection.dynamic_loop import DynamicLoop
from cyclemap.views.experiment_page import experiment_page
from cyclemap.views.experiment_sentences import (
    experiment_headline,
    isotropic_sentence,
    method_line,
    spread_sentence,
)
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole


@dataclass(frozen=True)
class ExperimentRequest:
    """What is asked of the experiment: its size, the rod's speed, which model, and where results go."""

    batches: int
    cycles: int
    speed_mm_s: float
    quasi_static: bool
    out: Path
    picture_format: str


def run_experiment(options: LoopOptions, request: ExperimentRequest, json_target: str | None) -> None:
    """Run the batches, write picture and JSON, and print for people or as JSON."""
    loop, _ = chosen_loop(options)
    run = loop if request.quasi_static else DynamicLoop(loop, speed=1e-3 * request.speed_mm_s)
    with progress_bar(f"batches of cycles on {loop.material.name}") as report:
        experiment = batch_experiment(run, request.batches, request.cycles, report)
    report_json = experiment_report(experiment)
    stem = f"experiment_{file_stem(loop.material.name)}"
    write_json(request.out / f"{stem}.json", report_json)
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(experiment_page(experiment), request.picture_format))
    if not publish_json(report_json, json_target):
        _print_for_people(experiment, picture)


def experiment_report(experiment: BatchExperiment) -> Json:
    """The experiment as JSON; theta0_deg on the lift, one entry more than cycles."""
    return {
        "model": "quasi-static" if experiment.speed is None else "dynamic",
        "speed_mm_s": None if experiment.speed is None else number(1e3 * experiment.speed),
        "cycles": experiment.cycles,
        "within_deg": degrees(WITHIN),
        "anisotropic": _run(experiment.anisotropic),
        "isotropic": _run(experiment.isotropic),
    }


def _run(run: BatchRun) -> Json:
    directions = run.directions()
    settled = run.settled_after()
    return {
        "directions_deg": [direction_deg(direction) for direction in directions],
        "all_agree": len(directions) == 1,
        "spread_mm": number(1e3 * run.spread),
        "batches": [
            {
                "start_deg": degrees(theta[0]),
                "final_deg": direction_deg(theta[-1]),
                "last_step_deg": degrees(step),
                "settled_after_cycles": int(cycles) if directions else None,
                "theta0_deg": numbers(np.degrees(theta)),
            }
            for theta, step, cycles in zip(run.theta, run.last_step, settled, strict=True)
        ],
    }


def _print_for_people(experiment: BatchExperiment, picture: Path) -> None:
    console = PeopleConsole()
    console.print(experiment_headline(experiment), style="bold")
    console.print(spread_sentence(experiment))
    console.print(isotropic_sentence(experiment))
    console.print(method_line(experiment))
    console.print(f"picture: {picture}")
