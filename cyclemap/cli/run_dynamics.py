"""With inertia: `cyclemap dynamics` sets dynamic cycles beside quasi-static ones, and `cyclemap
experiment` runs batches of them as the paper did; in sentences, as JSON, and as pictures.
"""

import math
from dataclasses import replace

from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import people_table, progress_bar, publish, result_stem
from cyclemap.cli.run_cycle import cycle_columns, parse_angles
from cyclemap.collection.batch_experiment import WITHIN, BatchRun, batch_experiment
from cyclemap.collection.dynamic_loop import (
    DynamicLoop,
    compare_dynamics,
    isotropic_twin,
)
from cyclemap.collection.loop import Cycles
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views import experiment_page as page
from cyclemap.views.experiment_page import difference_sentence, dynamics_page
from cyclemap.written import MILLIMETRES, Json, degrees, direction_deg, json_of, rows, written

COLUMNS = (
    "law",
    "model",
    "θ0 (°)",
    "push turn (°)",
    "dx (mm)",
    "dy (mm)",
    "drag turn (°)",
    "next θ0 (°)",
)


def run_dynamics(
    options: LoopOptions,
    theta0_deg: str,
    speed_mm_s: float,
    results: ResultOptions,
) -> None:
    """Run the cycles of both models under both laws, draw them, and print them for people or as
    JSON.
    """
    starts_deg = parse_angles(theta0_deg)
    theta = [math.radians(start) for start in starts_deg]
    chosen = chosen_loop(options).loop
    loop = DynamicLoop(chosen, speed=1e-3 * speed_mm_s)
    with progress_bar(f"dynamic cycles on {chosen.material.name}") as report:
        material = compare_dynamics(loop, theta)
        report(0.5)
        isotropic = compare_dynamics(replace(loop, loop=isotropic_twin(chosen)), theta)
        report(1.0)
    cycles = {
        law: {
            "dynamic": _cycles(starts_deg, comparison.dynamic),
            "quasi_static": _cycles(starts_deg, comparison.quasi_static),
        }
        for law, comparison in (("anisotropic", material), ("isotropic", isotropic))
    }
    as_json: Json = {
        "speed_mm_s": written(loop.speed, MILLIMETRES),
        **cycles,
        "isotropic": {
            "mu": written(isotropic.loop.loop.material.friction.mu_a),
            **cycles["isotropic"],
        },
    }
    table = people_table(f"Cycles at {1e3 * loop.speed:g} mm/s", COLUMNS, words=(0, 1))
    for law, models in cycles.items():
        for dynamic, quasi_static in zip(models["dynamic"], models["quasi_static"], strict=True):
            table.add_row(law, "dynamic", *_cells(dynamic))
            table.add_row("", "quasi-static", "", *_cells(quasi_static)[1:], end_section=True)
    words = (difference_sentence(material), difference_sentence(isotropic))
    publish(
        as_json,
        dynamics_page(material, isotropic),
        result_stem(results.out, "dynamics", chosen),
        results,
        *words,
        table,
    )


def _cycles(starts_deg: list[float], cycles: Cycles) -> list[Json]:
    """The cycles of a model, one from each start angle (degrees)."""
    return rows(
        **cycle_columns(starts_deg, cycles),
        theta1_deg=degrees(cycles.theta_next),
        left=cycles.left,
    )


def _cells(row: Json) -> list[str]:
    start, *lengths, _ = row.values()
    return [f"{start:.1f}", *("–" if length is None else f"{length:.3f}" for length in lengths)]


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
    as_json: Json = {
        "model": "quasi-static" if experiment.speed is None else "dynamic",
        "speed_mm_s": written(experiment.speed, MILLIMETRES),
        "cycles": experiment.cycles,
        "within_deg": degrees(WITHIN),
        "anisotropic": _run(experiment.anisotropic),
        "isotropic": _run(experiment.isotropic),
    }
    publish(
        as_json,
        page.experiment_page(experiment),
        result_stem(results.out, "experiment", loop),
        results,
        page.experiment_headline(experiment),
        page.spread_sentence(experiment),
        page.isotropic_sentence(experiment),
        page.method_line(experiment),
    )


def _run(run: BatchRun) -> Json:
    directions = run.directions()
    settled = run.settled_after()
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
