"""Cycles: `cyclemap cycle` as a table, `cyclemap dynamics` with inertia beside quasi-static ones,
and `cyclemap experiment` batches of them as the paper ran; as JSON and as pictures.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from cyclemap.cli.json_report import actions_report
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import (
    PeopleConsole,
    people_table,
    progress_bar,
    publish,
    publish_json,
    result_stem,
    write_json,
)
from cyclemap.collection.batch_experiment import WITHIN, BatchRun, batch_experiment
from cyclemap.collection.cycles import Cycles
from cyclemap.collection.dynamic_loop import (
    DynamicLoop,
    compare_dynamics,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import isotropic_twin
from cyclemap.errors import InvalidInput
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import (
    ChosenCollection,
    LoopOptions,
    chosen_collection,
    chosen_loop,
)
from cyclemap.views import experiment_page as page
from cyclemap.views.experiment_page import difference_sentence, dynamics_page
from cyclemap.written import MILLIMETRES, Json, degrees, direction_deg, json_of, rows, written

COLUMNS = (
    "θ0 (°)",
    "push turn (°)",
    "dx (mm)",
    "dy (mm)",
    "drag turn (°)",
    "drag (mm)",
    "next θ0 (°)",
)
DYNAMIC_COLUMNS = (
    "law",
    "model",
    "θ0 (°)",
    "push turn (°)",
    "dx (mm)",
    "dy (mm)",
    "drag turn (°)",
    "next θ0 (°)",
)
# Up to so many degrees an orientation is known to a thousandth of a degree.
LARGEST_DEG = 1e12


def run_cycle(
    options: LoopOptions, theta0_deg: str, out: Path | None, json_target: str | None
) -> None:
    """Run the cycles that start at the angles listed in `theta0_deg`, and print or write them."""
    starts = parse_angles(theta0_deg)
    chosen = chosen_collection(options)
    all_rows = list[Json]()
    tables = []
    for title, loop, turn, more in _acted(chosen):
        cycles = loop.cycles([math.radians(start) for start in starts])
        of_loop = rows(
            **cycle_columns(starts, cycles),
            drag_mm=written(cycles.drag_length, MILLIMETRES),
            # What a gripper turns comes after the drag.
            theta1_deg=degrees(cycles.theta_next + turn),
        )
        cells = [[f"{value:.3f}" for value in row.values()] for row in of_loop]
        tables.append(people_table(title, COLUMNS, cells))
        all_rows += [{**row, **more} for row in of_loop]
    report: Json = {"cycles": all_rows}
    if out is not None:
        stem = result_stem(out, "cycles", chosen.loop)
        write_json(stem.with_name(f"{stem.name}.json"), report)
    if not publish_json(report, json_target):
        for table in tables:
            PeopleConsole().print_table(table)


def _acted(chosen: ChosenCollection) -> Iterator[tuple[str, CollectionLoop, float, Json]]:
    """A title, the loop, the turn of the gripper and what is told of it in JSON: of each action,
    or of a loop without a strategy.
    """
    loop = chosen.loop
    strategy = chosen.strategy
    name = chosen.loop.material.name
    if strategy is None:
        yield f"One push and drag back on {name}", loop, 0.0, {}
        return
    actions = zip(
        strategy.actions, strategy.loops(loop), actions_report(strategy, loop), strict=True
    )
    for action, acted, row in actions:
        title = f"{row['name']}: {row['weight']:.3g} of the cycles on {name}"
        yield title, acted, action.turn, {"action": row}


def cycle_columns(starts_deg: Sequence[float], cycles: Cycles) -> Json:
    """What every command tells of cycles, by its name in a row of theirs."""
    return {
        "theta0_deg": starts_deg,
        "push_turn_deg": degrees(cycles.push_turn),
        "push_dx_mm": written(cycles.push_displacement[:, 0], MILLIMETRES),
        "push_dy_mm": written(cycles.push_displacement[:, 1], MILLIMETRES),
        "drag_turn_deg": degrees(cycles.drag_turn),
    }


def parse_angles(text: str) -> list[float]:
    """The finite numbers of a list with commas; InvalidInput names what is not one.

    >>> parse_angles("0, -30,60.5")
    [0.0, -30.0, 60.5]
    """
    angles = []
    for word in map(str.strip, text.split(",")):
        try:
            value = plain_number(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InvalidInput(
                f"--theta0-deg has {word!r}; give finite numbers with commas, such as 0,30,60"
            )
        if abs(value) > LARGEST_DEG:
            raise InvalidInput(
                f"--theta0-deg has {word!r}, whose part of a turn is lost to rounding; wrap it "
                "first"
            )
        angles.append(value)
    return angles


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
            "dynamic": _cycle_rows(starts_deg, comparison.dynamic),
            "quasi_static": _cycle_rows(starts_deg, comparison.quasi_static),
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
    table = people_table(f"Cycles at {1e3 * loop.speed:g} mm/s", DYNAMIC_COLUMNS, words=(0, 1))
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


def _cycle_rows(starts_deg: list[float], cycles: Cycles) -> list[Json]:
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
        "anisotropic": _batches(experiment.anisotropic),
        "isotropic": _batches(experiment.isotropic),
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


def _batches(run: BatchRun) -> Json:
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
