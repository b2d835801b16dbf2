"""The command `cyclemap experiment`: the paper's numerical experiment in sentences, as JSON, and as
a picture.
"""

from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import progress_bar, publish, result_stem
from cyclemap.collection.batch_experiment import WITHIN, BatchRun, batch_experiment
from cyclemap.collection.dynamic_loop import DynamicLoop
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views import experiment_page as page
from cyclemap.written import MILLIMETRES, Json, degrees, direction_deg, json_of, rows, written


def run_experiment(
    options: LoopOptions,
    batches: int,
    cycles: int,
    speed_mm_s: float,
    quasi_static: bool,
    results: ResultOptions,
) -> None:
    """Run the batches, draw them, and tell how they end; theta0_deg is on the lift, one entry more
    than cycles.
    """
    loop = chosen_loop(options).loop
    run = loop if quasi_static else DynamicLoop(loop, speed=1e-3 * speed_mm_s)
    with progress_bar(f"batches of cycles on {loop.material.name}") as report:
        experiment = batch_experiment(run, batches, cycles, report)
    told: Json = {
        "model": "quasi-static" if experiment.speed is None else "dynamic",
        "speed_mm_s": written(experiment.speed, MILLIMETRES),
        "cycles": experiment.cycles,
        "within_deg": degrees(WITHIN),
        "anisotropic": _run(experiment.anisotropic),
        "isotropic": _run(experiment.isotropic),
    }
    stem = result_stem(results.out, "experiment", loop)
    publish(
        told,
        page.experiment_page(experiment),
        stem,
        results,
        page.experiment_headline(experiment),
        page.spread_sentence(experiment),
        page.isotropic_sentence(experiment),
        page.method_line(experiment),
    )


def _run(run: BatchRun) -> Json:
    directions, settled = run.directions(), run.settled_after()
    return {
        "directions_deg": [*map(direction_deg, directions)],
        "all_agree": len(directions) == 1,
        **json_of(run, "spread", unit=MILLIMETRES),
        "batches": rows(
            start_deg=degrees(run.theta[:, 0]),
            final_deg=map(direction_deg, run.theta[:, -1]),
            last_step_deg=degrees(run.last_step),
            settled_after_cycles=settled if directions else [None] * len(run.theta),
            theta0_deg=degrees(run.theta),
        ),
    }
