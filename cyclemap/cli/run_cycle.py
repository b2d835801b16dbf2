"""Cycles: `cyclemap cycle` as a table, `cyclemap dynamics` with inertia beside quasi-static ones,
`cyclemap experiment` batches of them as the paper ran, as JSON and as pictures; and `cyclemap
simulate` a collection of them as files.
"""

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import click
import numpy as np

from cyclemap.cli.commands import CycleOptions, DynamicsOptions, ExperimentOptions, SimulateOptions
from cyclemap.cli.output import (
    PeopleConsole,
    actions_report,
    people_table,
    progress_bar,
    publish,
    publish_json,
    result_name,
    write_json,
)
from cyclemap.collection.cycles import Cycles
from cyclemap.collection.dynamic_loop import (
    WITHIN,
    BatchRun,
    DynamicLoop,
    batch_experiment,
    compare_dynamics,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import (
    floor_varies,
    isotropic_twin,
    with_even_floor,
)
from cyclemap.errors import InvalidInput
from cyclemap.evidence.recorded_push import RecordingNoise
from cyclemap.evidence.simulated_collection import SimulatedCollection, simulate_collection
from cyclemap.maps import LocalNoise
from cyclemap.mechanics import load_material
from cyclemap.plain_text import number_or_nan
from cyclemap.protocol.chosen_loop import ChosenCollection
from cyclemap.views import experiment_page as page
from cyclemap.written import MILLIMETRES, Json, degrees, direction_deg, json_of, rows, written

DEFAULT_SPEED_MM_S = 20.0
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


def run_cycle(asked: CycleOptions) -> None:
    """Run the cycles that start at the angles listed, and print or write them."""
    starts = parse_angles(asked.theta0_deg)
    chosen = asked.loop.chosen_collection()
    all_rows = list[Json]()
    tables = []
    for title, loop, turn, more in _acted(chosen):
        cycles = loop.cycles(np.radians(starts))
        of_loop = rows(
            **cycle_columns(starts, cycles),
            drag_mm=written(cycles.drag_length, MILLIMETRES),
            # What a gripper turns comes after the drag.
            theta1_deg=degrees(cycles.theta_next + turn),
        )
        cells = [[f"{value:.3f}" for value in row.values()] for row in of_loop]
        tables.append(people_table(title, COLUMNS, cells))
        all_rows += [row | more for row in of_loop]
    report: Json = {"cycles": all_rows}
    if asked.out is not None:
        write_json(asked.out / f"{result_name('cycles', chosen.loop)}.json", report)
    if not publish_json(report, asked.json):
        for table in tables:
            PeopleConsole().print_table(table)


def _acted(chosen: ChosenCollection) -> Iterator[tuple[str, CollectionLoop, float, Json]]:
    """A title, the loop, the turn of the gripper and what is told of it in JSON: of each action,
    or of a loop without a strategy.
    """
    loop = chosen.loop
    strategy = chosen.strategy
    name = loop.material.name
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
    words = [word.strip() for word in text.split(",")]
    angles = [number_or_nan(word) for word in words]
    for word, angle in zip(words, angles, strict=True):
        if not math.isfinite(angle):
            raise InvalidInput(
                f"--theta0-deg has {word!r}; give finite numbers with commas, such as 0,30,60"
            )
        if abs(angle) > LARGEST_DEG:
            raise InvalidInput(
                f"--theta0-deg has {word!r}, whose part of a turn is lost to rounding; wrap it "
                "first"
            )
    return angles


def _on_even_floor(loop: CollectionLoop) -> CollectionLoop:
    """The loop as the dynamic simulation can run it, after saying on stderr what is left out."""
    if floor_varies(loop):
        click.echo(
            f"the floor of {loop.material.name} varies from place to place, which the dynamic "
            "simulation does not know: both models run on its shape at the target",
            err=True,
        )
    return with_even_floor(loop)


def run_dynamics(asked: DynamicsOptions) -> None:
    """Run the cycles of both models under both laws, draw them, and print them for people or as
    JSON.
    """
    starts_deg = parse_angles(asked.theta0_deg)
    theta = np.radians(starts_deg)
    chosen = _on_even_floor(asked.loop.chosen_loop().loop)
    loop = DynamicLoop(chosen, speed=1e-3 * asked.speed_mm_s)
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
    mu = isotropic.loop.loop.material.friction.mu_a
    as_json: Json = {
        "speed_mm_s": written(loop.speed, MILLIMETRES),
        **cycles,
        "isotropic": {"mu": mu, **cycles["isotropic"]},
    }
    table = people_table(f"Cycles at {1e3 * loop.speed:g} mm/s", DYNAMIC_COLUMNS, words=(0, 1))
    for law, models in cycles.items():
        for dynamic, quasi_static in zip(models["dynamic"], models["quasi_static"], strict=True):
            table.add_row(law, "dynamic", *_cells(dynamic))
            table.add_row("", "quasi-static", "", *_cells(quasi_static)[1:], end_section=True)
    publish(
        as_json,
        page.dynamics_page(material, isotropic),
        asked.results,
        result_name("dynamics", chosen),
        page.difference_sentence(material),
        page.difference_sentence(isotropic),
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


def run_experiment(asked: ExperimentOptions) -> None:
    """Run the batches, draw them, and tell how they end; theta0_deg is on the lift, one entry more
    than cycles.
    """
    loop = asked.loop.chosen_loop().loop
    if asked.quasi_static and asked.speed_mm_s is not None:
        raise InvalidInput("--speed-mm-s is of dynamic cycles: leave it or --quasi-static out")
    run: CollectionLoop | DynamicLoop = loop
    if not asked.quasi_static:
        loop = _on_even_floor(loop)
        run = DynamicLoop(loop, speed=1e-3 * (asked.speed_mm_s or DEFAULT_SPEED_MM_S))
    with progress_bar(f"batches of cycles on {loop.material.name}") as report:
        experiment = batch_experiment(run, asked.batches, asked.cycles, report)
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
        asked.results,
        result_name("experiment", loop),
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


# Far below any noise of a cycle, and twice as fast as the default.
ACCURACY = 1e-6


def run_simulate(asked: SimulateOptions) -> None:
    """Write the collection that is asked for, or the rest of it, and tell where it is."""
    chosen = asked.loop.chosen_collection().simplified()
    loop = replace(chosen.loop, accuracy=ACCURACY)
    strategy = chosen.strategy
    cycle_by_cycle = dict[str, Any]()
    if strategy is not None:
        # What it changes from cycle to cycle is the same that its schedule of this seed says.
        loop = strategy.prepared(loop)
        actions = strategy.run(asked.cycles, asked.seed)
        cycle_by_cycle["cycle_loops"] = tuple(action.on(loop) for action in actions)
        cycle_by_cycle["gripper_turns"] = tuple(action.turn for action in actions)
    noise = RecordingNoise(
        turn=chosen.noise if asked.noise_deg is None else math.radians(asked.noise_deg),
        position=1e-3 * asked.pose_noise_mm,
        angle=math.radians(asked.pose_noise_deg),
        force=asked.force_noise_n,
    )
    own = loop.material.noise if asked.noise_deg is None and chosen.sigma is None else None
    with progress_bar(f"collection on {loop.material.name}") as report:
        made = simulate_collection(
            loop,
            asked.out,
            asked.cycles,
            start=math.radians(asked.start_deg),
            noise=noise,
            cycle_noise=None if own is None else LocalNoise(own.log_sigma, own.correlation),
            speed=1e-3 * asked.speed_mm_s,
            wear_to=None if asked.wear_to is None else load_material(asked.wear_to),
            seed=asked.seed,
            scans=asked.scans,
            suffix=f".{asked.format}",
            progress=report,
            **cycle_by_cycle,
        )
    as_json = {
        **json_of(made, "folder", "cycles", "written", "resumed"),
        "theta0_deg_last": math.degrees(made.theta_last),
        "bytes": made.bytes,
    }
    if not publish_json(as_json, asked.json):
        PeopleConsole().tell(*_sentences(made))


def _sentences(made: SimulatedCollection) -> tuple[str, ...]:
    scans = f" and {made.scans} friction scans" if made.scans else ""
    added = f"{made.resumed} of the pushes were there already, {made.written} were added."
    last = f"{math.degrees(made.theta_last):.2f}°, counted without wrapping"
    return (
        f"{made.cycles} pushes{scans} in {made.folder}, {made.bytes / 1e6:.1f} MB",
        added if made.resumed else "",
        f"The last push starts at θ0 = {last}.",
        f"next: cyclemap fit {shlex.quote(str(made.folder))}",
    )
