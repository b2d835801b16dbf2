"""`cyclemap portrait` and `staircase` with a strategy whose cycles differ."""

import math

import numpy as np

from cyclemap.arrays import Array
from cyclemap.cli.json_report import actions_report, measured_report, steps_report
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import progress_bar, publish, result_stem
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES, DEFAULT_SIGMA
from cyclemap.evidence import MeasuredStaircase, Theta0Pairs
from cyclemap.maps import find_steps
from cyclemap.protocol.chosen_loop import ChosenCollection
from cyclemap.resets import ResetStrategy, map_turns, orientation_law, run_strategy, strategy_maps
from cyclemap.resets.design.orientation_law import slowest_factor
from cyclemap.views.reset_page import recipe, strategy_page
from cyclemap.written import Json, degrees, direction_deg, written

_EACH = "cycles differ from each other, so that no orientation is fixed: see stationary"
_CHANGING = "the map changes from cycle to cycle: cyclemap portrait tells the distribution of θ0"


def run_strategy_portrait(
    chosen: ChosenCollection,
    strategy: ResetStrategy,
    pairs: Theta0Pairs | None,
    cycles: int | None,
    seed: int,
    results: ResultOptions,
) -> None:
    """Compute the distribution of the orientations, draw it, and print it for people or as JSON."""
    loop, sigma = chosen.loop, DEFAULT_SIGMA if chosen.sigma is None else chosen.sigma
    with progress_bar(f"cycle maps of {loop.material.name}") as report:
        maps = strategy_maps(loop, strategy, tolerance=1e-4, progress=report)
    turns, measured = map_turns(maps), None if pairs is None else pairs.path
    law, factor = orientation_law(turns, strategy, sigma), slowest_factor(turns, strategy, sigma)
    theta, ran = _run(loop, strategy, sigma, measured, cycles, seed)
    mean_turn, above = float((theta[-1] - theta[0]) / (len(theta) - 1)), law.density > 0.5 / math.pi
    peaks = np.flatnonzero(
        (law.density > np.roll(law.density, 1)) & (law.density >= np.roll(law.density, -1)) & above
    )
    told: Json = {
        "strategy": {
            "recipe": recipe(strategy),
            "order": strategy.order,
            "needs": list(strategy.needs),
        },
        "map": [
            {
                "action": action,
                "max_error_deg": degrees(one.max_error),
                "mean_turn_deg": degrees(float(turn.mean())),
            }
            for action, one, turn in zip(actions_report(strategy, loop), maps, turns, strict=True)
        ],
        "fixed_points": [],
        "fixed_points_reason": _EACH,
        "rotation_number": {
            "value": written(mean_turn / (2.0 * math.pi)),
            "lower": None,
            "upper": None,
            "locked": None,
        },
        "stationary": {
            "noise_deg": degrees(sigma),
            "peaks_deg": [direction_deg(math.radians(peak)) for peak in peaks.tolist()],
            "spectral_gap": written(1.0 - factor),
            "mixing_cycles": written(-1.0 / math.log(factor)) if 0.0 < factor < 1.0 else None,
            "tv_from_uniform": written(law.total_variation),
            "tv_error": written(law.error),
            "tv_after_pushes_from_worst_start": {"pushes": law.pushes, "tv": written(law.after)},
        },
        "staircase": {
            "mean_turn_deg": degrees(mean_turn),
            "mean_residence_cycles": None,
            "step_deg": None,
            "run": ran,
        },
        **(
            {}
            if pairs is None
            else {"data": {"pairs": len(pairs.theta), "dropped": dict(pairs.dropped)}}
        ),
    }
    words = (
        f"{loop.material.name}: {law.total_variation:.1%} away from uniform",
        f"With {math.degrees(sigma):.2g}° of noise a cycle: {recipe(strategy)}.",
        f"Total variation from uniform {law.total_variation:.4f} in the long run, {law.after:.4f} "
        f"after {law.pushes} pushes from the worst start (± {law.error:.1g} for the modes kept).",
        f"In a run of {len(theta) - 1} cycles θ0 moves {math.degrees(mean_turn):.2f}° a cycle on "
        "average.",
    )
    figure = strategy_page(words, loop, strategy, theta, measured, turns, law)
    publish(told, figure, result_stem(results.out, "portrait", loop), results, *words)


def run_strategy_staircase(
    chosen: ChosenCollection,
    strategy: ResetStrategy,
    measured: MeasuredStaircase | None,
    cycles: int | None,
    seed: int,
    results: ResultOptions,
) -> None:
    """Run the strategy, set the measured staircase beside it, draw both, and print them for people
    or as JSON.
    """
    loop, sigma = chosen.loop, DEFAULT_SIGMA if chosen.sigma is None else chosen.sigma
    data = None if measured is None else measured.path
    theta, ran = _run(loop, strategy, sigma, data, cycles, seed)
    steps = find_steps(theta)
    nothing = dict.fromkeys(("mean_turn_deg", "mean_residence_cycles", "step_deg"))
    told: Json = {
        "noise_deg": degrees(sigma),
        "prediction": {**nothing, "zones": [], "reason": _CHANGING},
        "run": {**ran, "followed": "mechanics", **steps_report(steps)},
        **({} if measured is None else {"data": measured_report(measured)}),
    }
    rests = f"makes {steps.count} steps" if steps.levels.size else "rests nowhere"
    words = (
        f"Staircase of {loop.material.name}",
        f"{recipe(strategy)}.".capitalize(),
        f"In a run of {len(theta) - 1} cycles by the full mechanics (seed {seed}) it {rests}; "
        f"θ0 moves {math.degrees((theta[-1] - theta[0]) / (len(theta) - 1)):.2f}° a cycle on "
        "average.",
    )
    page, stem = (
        strategy_page(words, loop, strategy, theta, data),
        result_stem(results.out, "staircase", loop),
    )
    publish(told, page, stem, results, *words)


def _run(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    data: Array | None,
    cycles: int | None,
    seed: int,
) -> tuple[Array, Json]:
    """A run of the strategy by the full mechanics, from where the data start and as long where
    there are some.
    """
    cycles = cycles or (DEFAULT_CYCLES if data is None else len(data) - 1)
    start = 0.0 if data is None else float(data[0])
    with progress_bar(f"{cycles} cycles on {loop.material.name}") as report:
        run = run_strategy(
            loop, strategy, cycles, start=start, sigma=sigma, seed=seed, progress=report
        )
    theta = run.theta[0]
    return theta, {
        "seed": seed,
        "cycles": cycles,
        "climb_deg": degrees(float(theta[-1] - theta[0])),
    }
