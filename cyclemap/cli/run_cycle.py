"""`cyclemap cycle`: single cycles, as a table or as JSON."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from cyclemap.cli.json_report import actions_report
from cyclemap.cli.output import PeopleConsole, people_table, publish_json, result_stem, write_json
from cyclemap.collection.loop import CollectionLoop, Cycles
from cyclemap.errors import InvalidInput
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import ChosenCollection, LoopOptions, chosen_collection
from cyclemap.written import MILLIMETRES, Json, degrees, rows, written

COLUMNS = (
    "θ0 (°)",
    "push turn (°)",
    "dx (mm)",
    "dy (mm)",
    "drag turn (°)",
    "drag (mm)",
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
