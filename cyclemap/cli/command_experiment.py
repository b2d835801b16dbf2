"""The command `cyclemap experiment`: the paper's numerical experiment in sentences, as JSON, and as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cyclemap.cli.options import MOST_CYCLES, LoopOptions, Real, Whole, loop_options, result_options

if TYPE_CHECKING:
    from cyclemap.cli.json_report import Json
    from cyclemap.collection.batch_experiment import BatchRun


@click.command("experiment")
@loop_options
@click.option("--batches", type=Whole(min=1), default=6, help="Batches, evenly spaced.")
@click.option("--cycles", type=Whole(1, MOST_CYCLES), default=100, help="Cycles a batch.")
@click.option("--speed-mm-s", type=Real(), default=20.0, help="Speed of the rod.")
@click.option("--quasi-static", is_flag=True, help="Quasi-static cycles, without inertia, in place of dynamic ones.")
@result_options("experiment_MATERIAL.png and .json")
def experiment_command(
    options: LoopOptions,
    batches: int,
    cycles: int,
    speed_mm_s: float,
    quasi_static: bool,
    out: Path,
    picture_format: str,
    json_target: str | None,
) -> None:
    """Run the paper's numerical experiment: batches of cycles from several θ0, and on isotropic friction.

    It takes a minute or two; --quasi-static on the exact footprint a quarter of that. Dynamic cycles stand on the
    footprint if it is made of points, else on points that carry its pressure: the paper's grid:8 where it is even,
    weighted and with points along the rim where it leans or has parts.
    """
    from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, publish
    from cyclemap.cli.settings import chosen_loop
    from cyclemap.collection.batch_experiment import batch_experiment
    from cyclemap.collection.dynamic_loop import DynamicLoop
    from cyclemap.views import experiment_page as page

    loop, _ = chosen_loop(options)
    run = loop if quasi_static else DynamicLoop(loop, speed=1e-3 * speed_mm_s)
    with progress_bar(f"batches of cycles on {loop.material.name}") as report:
        experiment = batch_experiment(run, batches, cycles, report)
    stem = out / f"experiment_{file_stem(loop.material.name)}"
    # The experiment as JSON; theta0_deg on the lift, one entry more than cycles.
    from cyclemap.cli.json_report import degrees, number
    from cyclemap.collection.batch_experiment import WITHIN

    picture = publish(
        {
            "model": "quasi-static" if experiment.speed is None else "dynamic",
            "speed_mm_s": None if experiment.speed is None else number(1e3 * experiment.speed),
            "cycles": experiment.cycles,
            "within_deg": degrees(WITHIN),
            "anisotropic": _run(experiment.anisotropic),
            "isotropic": _run(experiment.isotropic),
        },
        page.experiment_page(experiment),
        stem,
        picture_format,
        json_target,
    )
    if picture is not None:
        told = (page.spread_sentence, page.isotropic_sentence, page.method_line)
        words = (sentence(experiment) for sentence in told)
        PeopleConsole().tell(page.experiment_headline(experiment), *words, f"picture: {picture}")


def _run(run: BatchRun) -> Json:
    import numpy as np

    from cyclemap.cli.json_report import degrees, direction_deg, number, numbers

    directions, settled = run.directions(), run.settled_after()
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
