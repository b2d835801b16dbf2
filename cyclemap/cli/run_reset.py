"""`cyclemap reset`: three lines and a few rows, as JSON, a picture, a protocol and a schedule; and
what `cyclemap portrait` and `staircase` say of a strategy whose cycles differ.
"""

import math
from pathlib import Path

from cyclemap.arrays import TWO_PI, Array
from cyclemap.cli.commands import ResetOptions
from cyclemap.cli.options import RunOptions
from cyclemap.cli.output import (
    Told,
    actions_report,
    measured_report,
    people_table,
    progress_bar,
    publish,
    result_name,
    steps_report,
    styled,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence import MeasuredStaircase, Theta0Pairs
from cyclemap.maps import find_steps
from cyclemap.mechanics import Material, load_material
from cyclemap.protocol import write_protocol, write_schedule
from cyclemap.protocol.chosen_loop import ChosenCollection
from cyclemap.resets import (
    MaterialRange,
    ResetDemands,
    ResetDesign,
    ResetRow,
    ResetStrategy,
    design_reset,
    map_turns,
    material_range,
    orientation_law,
    run_strategy,
    strategy_maps,
)
from cyclemap.resets.orientation_law import OrientationLaw, slowest_factor
from cyclemap.views.reset_page import (
    COLUMNS,
    design_sentences,
    histogram_words,
    miss_sentences,
    recipe,
    reset_page,
    row_cells,
    strategy_page,
)
from cyclemap.views.sentences import angle, material_line
from cyclemap.written import Json, degrees, direction_deg, json_of, rows, written

_EACH = "cycles differ from each other, so that no orientation is fixed: see stationary"
_CHANGING = "the map changes from cycle to cycle: cyclemap portrait tells the distribution of θ0"
_NO_STEPS = dict.fromkeys(("mean_turn_deg", "mean_residence_cycles", "step_deg"))


def run_reset(asked: ResetOptions) -> None:
    """Design the reset, write its files, and print it for people or as JSON."""
    chosen = asked.loop.chosen_collection()
    demands = ResetDemands(
        allow_tv=asked.allow_tv,
        extra_tv=asked.extra_tv,
        within=asked.within,
        drag_ratio=asked.drag_ratio,
        seconds=asked.seconds,
        reach=_times(1e-3, asked.reach_mm),
        contact=_times(1e-3, asked.least_push_mm),
        abilities=asked.abilities,
        keep_push=asked.keep_push,
        pushes=asked.pushes,
    )
    with progress_bar("comparing resets") as report:
        design = design_reset(
            chosen.loop,
            demands,
            sigma=chosen.noise,
            materials=_range(chosen.loop.material, asked),
            given=chosen.strategy,
            seed=asked.seed,
            progress=report,
        )
    name = result_name("reset", chosen.loop)
    strategy = design.chosen.strategy
    protocol = asked.results.out / f"{name}.toml"
    schedule = asked.results.out / f"{name}.csv"
    write_protocol(
        protocol, design.loop, strategy, noise=chosen.noise, predicted=_predicted(design.chosen)
    )
    write_schedule(schedule, design.loop, strategy, asked.cycles, asked.seed)
    publish(
        _report(design, protocol, schedule),
        reset_page(design),
        asked.results,
        name,
        *_lines(design),
        after=(f"protocol: {protocol}", f"schedule: {schedule}"),
    )


def _times(factor: float, value: float | None) -> float | None:
    return None if value is None else factor * value


def _range(nominal: Material, asked: ResetOptions) -> MaterialRange:
    """The materials that are named, else those of percentages."""
    shares = (_times(0.01, percent) for percent in (asked.axes_percent, asked.offsets_percent))
    about = material_range(nominal, *shares)
    likely = asked.likely
    if not likely:
        return about
    if asked.axes_percent is not None or asked.offsets_percent is not None:
        raise InvalidInput(
            "--likely takes the place of --axes-percent and --offsets-percent: leave these out"
        )
    return MaterialRange(about.nominal, tuple(map(load_material, likely)), ", ".join(likely))


def _lines(design: ResetDesign) -> list[Told]:
    headline, *sentences = design_sentences(design)
    title = f"It, and others beside it ({histogram_words(design)})"
    return [
        *(styled(sentence, "bold red") for sentence in miss_sentences(design)),
        styled(headline, "bold"),
        *sentences,
        people_table(title, COLUMNS, map(row_cells, design.rows), words=(0, 1)),
        material_line(design.loop.material),
    ]


def _report(design: ResetDesign, protocol: Path, schedule: Path) -> Json:
    """The report of `cyclemap reset`; the chosen row is the first."""
    rows: list[Json] = [
        {
            **json_of(row, "roles"),
            "recipe": recipe(row.strategy),
            "actions": actions_report(row.strategy, design.loop),
            **_predicted(row),
            "worst_material": row.worst_material.name,
            "histogram_spread": row.histogram[1],
            "worst_histogram_distance": row.worst_histogram[0],
            "seconds": row.seconds,
            "reach_mm": 1e3 * row.room,
            "shortest_contact_mm": 1e3 * row.contact,
            **json_of(row, "misses", "lacking"),
        }
        for row in design.rows
    ]
    return {
        "material": design.loop.material.name,
        "noise_deg": degrees(design.sigma),
        "range": {
            **json_of(design.about, "origin"),
            "materials": [material.name for material in design.about.materials],
            **json_of(design.about, "share", "confidence"),
        },
        "met": design.met,
        "reasons": list(miss_sentences(design)),
        "independent_histogram_distance": design.independent,
        "histogram_distance_by_order": design.orders,
        "friction_error": {"ratio": design.ratio_errors.tolist(), "tv": design.ratio_tv.tolist()},
        "rows": rows,
        "protocol": str(protocol),
        "schedule": str(schedule),
    }


def _predicted(row: ResetRow) -> dict[str, float]:
    """What a protocol file carries along."""
    return {
        "tv": row.nominal.total_variation,
        "tv_after": row.nominal.after,
        "within": row.nominal.pushes,
        "worst_tv": row.worst,
        "worst_tv_after": row.worst_after,
        "histogram_distance": row.histogram[0],
        "mean_drag_mm": 1e3 * row.drag,
    }


def run_strategy_portrait(
    chosen: ChosenCollection,
    strategy: ResetStrategy,
    pairs: Theta0Pairs | None,
    asked: RunOptions,
) -> None:
    """Compute the distribution of the orientations, draw it, and print it for people or as JSON."""
    loop = chosen.loop
    sigma = chosen.noise
    with progress_bar(f"cycle maps of {loop.material.name}") as report:
        maps = strategy_maps(loop, strategy, tolerance=1e-4, progress=report)
    turns = map_turns(maps)
    measured = None if pairs is None else pairs.path
    law = orientation_law(turns, strategy, sigma)
    theta, ran = _run(loop, strategy, sigma, pairs, asked)
    mean_turn = _mean_turn(theta)
    factor = slowest_factor(turns, strategy, sigma)
    as_json: Json = {
        "strategy": {"recipe": recipe(strategy), **json_of(strategy, "order", "needs")},
        "map": rows(
            action=actions_report(strategy, loop),
            max_error_deg=[degrees(cycle_map.max_error) for cycle_map in maps],
            mean_turn_deg=degrees(turns.mean(axis=1)),
        ),
        "fixed_points": [],
        "fixed_points_reason": _EACH,
        "rotation_number": {
            "value": mean_turn / TWO_PI,
            "lower": None,
            "upper": None,
            "locked": None,
        },
        # The stationary distribution, and how fast it is reached: by a factor a cycle.
        "stationary": {
            "noise_deg": degrees(sigma),
            "peaks_deg": [*map(direction_deg, law.peaks)],
            "spectral_gap": written(1.0 - factor),
            "mixing_cycles": written(-1.0 / math.log(factor)) if 0.0 < factor < 1.0 else None,
            "tv_from_uniform": written(law.total_variation),
            "tv_error": written(law.error),
            "tv_after_pushes_from_worst_start": {"pushes": law.pushes, "tv": written(law.after)},
        },
        "staircase": {**_NO_STEPS, "mean_turn_deg": degrees(mean_turn), "run": ran},
    }
    if pairs is not None:
        as_json["data"] = {"pairs": len(pairs.theta), "dropped": dict(pairs.dropped)}
    words = _law_words(chosen, strategy, law, theta)
    publish(
        as_json,
        strategy_page(words, loop, strategy, theta, measured, turns, law),
        asked.results,
        result_name("portrait", loop),
        *words,
    )


def _law_words(
    chosen: ChosenCollection, strategy: ResetStrategy, law: OrientationLaw, theta: Array
) -> tuple[str, ...]:
    return (
        f"{chosen.loop.material.name}: {law.total_variation:.1%} away from uniform",
        f"With {math.degrees(chosen.noise):.2g}° of noise a cycle: {recipe(strategy)}.",
        f"Total variation from uniform {law.total_variation:.4f} in the long run, {law.after:.4f} "
        f"after {law.pushes} pushes from the worst start (± {law.error:.1g} for the modes kept).",
        f"In a run of {len(theta) - 1} cycles θ0 moves {angle(_mean_turn(theta), 2)} a cycle on "
        "average.",
    )


def _mean_turn(theta: Array) -> float:
    return float((theta[-1] - theta[0]) / (len(theta) - 1))


def run_strategy_staircase(
    chosen: ChosenCollection,
    strategy: ResetStrategy,
    measured: MeasuredStaircase | None,
    asked: RunOptions,
) -> None:
    """Run the strategy, set the measured staircase beside it, draw both, and print them for people
    or as JSON.
    """
    loop = chosen.loop
    sigma = chosen.noise
    theta, ran = _run(loop, strategy, sigma, measured, asked)
    steps = find_steps(theta)
    as_json: Json = {
        "noise_deg": degrees(sigma),
        "prediction": {**_NO_STEPS, "zones": [], "reason": _CHANGING},
        "run": {**ran, "followed": "mechanics", **steps_report(steps)},
        **({} if measured is None else {"data": measured_report(measured)}),
    }
    rests = f"makes {steps.count} steps" if steps.levels.size else "rests nowhere"
    words = (
        f"Staircase of {loop.material.name}",
        f"{recipe(strategy)}.".capitalize(),
        f"In a run of {len(theta) - 1} cycles by the full mechanics (seed {asked.seed}) it "
        f"{rests}; θ0 moves {angle(_mean_turn(theta), 2)} a cycle on "
        "average.",
    )
    publish(
        as_json,
        strategy_page(words, loop, strategy, theta, None if measured is None else measured.path),
        asked.results,
        result_name("staircase", loop),
        *words,
    )


def _run(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    sigma: float,
    measured: Theta0Pairs | MeasuredStaircase | None,
    asked: RunOptions,
) -> tuple[Array, Json]:
    """A run of the strategy by the full mechanics, from where the data start and as long where
    there are some.
    """
    wanted = asked.run_beside(measured)
    with progress_bar(f"{wanted['cycles']} cycles on {loop.material.name}") as report:
        run = run_strategy(loop, strategy, sigma=sigma, progress=report, **wanted)
    theta = run.theta[0]
    climb = degrees(theta[-1] - theta[0])
    return theta, {"seed": asked.seed, "cycles": wanted["cycles"], "climb_deg": climb}
