"""`cyclemap cycle`, `portrait` and `staircase` with a strategy whose cycles differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich.table import Table

from cyclemap.cli.json_numbers import degrees, direction_deg, number
from cyclemap.cli.json_report import Json, cycle_report, measured_report, steps_report
from cyclemap.cli.options import RunRequest
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.run_cycle import cycle_table
from cyclemap.cli.run_reset import action_report
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES
from cyclemap.evidence import MeasuredStaircase, Theta0Pairs
from cyclemap.maps import CircleMap, find_steps
from cyclemap.resets import OrientationLaw, ResetStrategy, map_turns, orientation_law, run_strategy, strategy_maps
from cyclemap.resets.design.orientation_law import slowest_factor
from cyclemap.views.reset_sentences import action_words, recipe
from cyclemap.views.strategy_page import strategy_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

_EACH = "cycles differ from each other, so that no orientation is fixed: see stationary"
_TOLERANCE = 1e-4


def strategy_cycles(
    loop: CollectionLoop, strategy: ResetStrategy, starts_deg: Sequence[float]
) -> tuple[Json, list[Table]]:
    """The report and the tables of a cycle from each start (degrees) for each action of the strategy."""
    cycles: list[Json] = []
    tables = []
    acted = zip(strategy.actions, strategy.shares.tolist(), strategy.loops(loop), strict=True)
    for action, share, one in acted:
        runs = [one.cycle(math.radians(start)) for start in starts_deg]
        told = action_report(action.filled(one), action, share)
        for start, run in zip(starts_deg, runs, strict=True):
            ends = {"theta1_deg": degrees(run.theta_next + action.turn)}
            cycles.append({**cycle_report(start, run), **ends, "action": told})
        title = f"{action_words(action)}: {share:.3g} of the cycles on {loop.material.name}"
        tables.append(cycle_table(title, runs, action.turn))
    return {"cycles": cycles}, tables


@dataclass(frozen=True, eq=False)
class _Run:
    """A run of the strategy by the full mechanics, beside the data where there are some."""

    theta: NDArray[np.float64]
    report: Json

    @classmethod
    def of(cls, loop: CollectionLoop, strategy: ResetStrategy, sigma: float, request: RunRequest,
           data: NDArray[np.float64] | None) -> _Run:  # fmt: skip
        cycles = request.cycles or (DEFAULT_CYCLES if data is None else len(data) - 1)
        start = 0.0 if data is None else float(data[0])
        with progress_bar(f"{cycles} cycles on {loop.material.name}") as report:
            run = run_strategy(loop, strategy, cycles, start=start, sigma=sigma, seed=request.seed, progress=report)
        theta = run.theta[0]
        told: Json = {"seed": request.seed, "cycles": cycles, "climb_deg": degrees(float(theta[-1] - theta[0]))}
        return cls(theta, told)


def run_strategy_portrait(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    request: RunRequest,
    pairs: Theta0Pairs | None,
    json_target: str | None,
) -> None:
    """Compute the distribution of the orientations, draw it, and print it for people or as JSON."""
    with progress_bar(f"cycle maps of {loop.material.name}") as report:
        maps = strategy_maps(loop, strategy, tolerance=_TOLERANCE, progress=report)
    turns = map_turns(maps)
    law = orientation_law(turns, strategy, sigma)
    factor = slowest_factor(turns, strategy, sigma)
    run = _Run.of(loop, strategy, sigma, request, None if pairs is None else pairs.path)
    mean_turn = float((run.theta[-1] - run.theta[0]) / (len(run.theta) - 1))
    told: Json = {
        "strategy": {"recipe": recipe(strategy), "order": strategy.order, "needs": list(strategy.needs)},
        "map": [_map(one, turn, action_report(action.filled(acted), action, share)) for one, turn, action, acted, share
                in zip(maps, turns, strategy.actions, strategy.loops(loop), strategy.shares.tolist(), strict=True)],
        "fixed_points": [],
        "fixed_points_reason": _EACH,
        "rotation_number": {"value": number(mean_turn / (2.0 * math.pi)), "lower": None, "upper": None, "locked": None},
        "stationary": _stationary(law, sigma, factor),
        "staircase": {
            "mean_turn_deg": degrees(mean_turn), "mean_residence_cycles": None, "step_deg": None, "run": run.report
        },
    }  # fmt: skip
    told |= {} if pairs is None else {"data": {"pairs": len(pairs.theta), "dropped": dict(pairs.dropped)}}
    words = (
        f"{loop.material.name}: {law.total_variation:.1%} away from uniform",
        f"With {math.degrees(sigma):.2g}° of noise a cycle: {recipe(strategy)}.",
        f"Total variation from uniform {law.total_variation:.4f} in the long run, {law.after:.4f} after {law.pushes} "
        f"pushes from the worst start (± {law.error:.1g} for the modes kept).",
        f"In a run of {len(run.theta) - 1} cycles θ0 moves {math.degrees(mean_turn):.2f}° a cycle on average.",
    )
    measured = None if pairs is None else pairs.path
    figure = strategy_page(words, loop, strategy, turns, law, run.theta, measured)
    _publish("portrait", loop, request, told, words, figure, json_target)


def _map(one: CircleMap, turn: NDArray[np.float64], action: Json) -> Json:
    slopes = 1.0 + np.diff(turn, append=turn[:1]) * turn.size / (2.0 * math.pi)
    return {
        "action": action,
        "degree": int(one.degree),
        "samples": int(one.samples),
        "max_error_deg": degrees(one.max_error),
        "mean_turn_deg": degrees(float(turn.mean())),
        "min_turn_deg": degrees(float(turn.min())),
        "max_turn_deg": degrees(float(turn.max())),
        "min_slope": number(float(slopes.min())),
        "max_slope": number(float(slopes.max())),
    }


def _stationary(law: OrientationLaw, sigma: float, factor: float) -> Json:
    density = law.density
    peaks = np.flatnonzero((density > np.roll(density, 1)) & (density >= np.roll(density, -1)))
    high = peaks[density[peaks] > 1.0 / (2.0 * math.pi)]
    return {
        "noise_deg": degrees(sigma),
        "peaks_deg": [direction_deg(math.radians(peak)) for peak in high.tolist()],
        "spectral_gap": number(1.0 - factor),
        "mixing_cycles": number(-1.0 / math.log(factor)) if 0.0 < factor < 1.0 else None,
        "tv_from_uniform": number(law.total_variation),
        "tv_error": number(law.error),
        "tv_after_pushes_from_worst_start": {"pushes": law.pushes, "tv": number(law.after)},
    }


def run_strategy_staircase(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    request: RunRequest,
    measured: MeasuredStaircase | None,
    json_target: str | None,
) -> None:
    """Run the strategy, set the measured staircase beside it, draw both, and print them for people or as JSON."""
    run = _Run.of(loop, strategy, sigma, request, None if measured is None else measured.path)
    steps = find_steps(run.theta)
    nothing: Json = {"mean_turn_deg": None, "mean_residence_cycles": None, "step_deg": None, "zones": []}
    why = "the map changes from cycle to cycle: cyclemap portrait tells the distribution of θ0"
    told: Json = {
        "noise_deg": degrees(sigma),
        "prediction": {**nothing, "reason": why},
        "run": {**run.report, "followed": "mechanics", **steps_report(steps)},
    }
    told |= {} if measured is None else {"data": measured_report(measured)}
    moved = math.degrees((run.theta[-1] - run.theta[0]) / (len(run.theta) - 1))
    rests = f"makes {steps.count} steps" if steps.levels.size else "rests nowhere"
    words = (
        f"Staircase of {loop.material.name}",
        f"{recipe(strategy)}.".capitalize(),
        f"In a run of {len(run.theta) - 1} cycles by the full mechanics (seed {request.seed}) it {rests}; "
        f"θ0 moves {moved:.2f}° a cycle on average.",
    )
    figure = strategy_page(words, loop, strategy, None, None, run.theta, None if measured is None else measured.path)
    _publish("staircase", loop, request, told, words, figure, json_target)


def _publish(
    command: str, loop: CollectionLoop, request: RunRequest, told: Json, words: Sequence[str], figure: Figure,
    json_target: str | None,
) -> None:  # fmt: skip
    stem = request.out / f"{command}_{file_stem(loop.material.name)}"
    picture: Path = stem.with_name(f"{stem.name}.{request.picture_format}")
    write_json(stem.with_name(f"{stem.name}.json"), told)
    write_whole(picture, render(figure, request.picture_format))
    if not publish_json(told, json_target):
        console = PeopleConsole()
        for place, sentence in enumerate((*words, f"picture: {picture}")):
            console.print(sentence, style=None if place else "bold")
