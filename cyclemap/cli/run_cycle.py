"""`cyclemap cycle`: single cycles, as a table or as JSON."""

import math
from pathlib import Path

from cyclemap.cli.json_report import actions_report
from cyclemap.cli.output import PeopleConsole, people_table, publish_json, result_stem, write_json
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.written import Json, degrees, written

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
    starts, chosen = parse_angles(theta0_deg), chosen_collection(options)
    loop, strategy, name = chosen.loop, chosen.strategy, chosen.loop.material.name
    acts: list[tuple[CollectionLoop, float, Json, str]] = [
        (loop, 0.0, {}, f"One push and drag back on {name}")
    ]
    if strategy is not None:
        parts = zip(
            strategy.actions, strategy.loops(loop), actions_report(strategy, loop), strict=True
        )
        acts = [
            (
                acted,
                action.turn,
                {"action": told},
                f"{told['name']}: {told['weight']:.3g} of the cycles on {name}",
            )
            for action, acted, told in parts
        ]
    cycles, tables = list[Json](), []
    for acted, turn, more, title in acts:
        table = people_table(title, COLUMNS)
        for start in starts:
            cycle = acted.cycle(math.radians(start))
            dx, dy = cycle.push_displacement
            found = {
                "theta0_deg": start,
                "push_turn_deg": degrees(cycle.push_turn),
                "push_dx_mm": written(1000 * dx),
                "push_dy_mm": written(1000 * dy),
                "drag_turn_deg": degrees(cycle.drag_turn),
                "drag_mm": written(1000 * cycle.drag_length),
                # What a gripper turns comes after the drag.
                "theta1_deg": degrees(cycle.theta_next + turn),
            }
            table.add_row(*(f"{value:.3f}" for value in found.values()))
            cycles.append({**found, **more})
        tables.append(table)
    report: Json = {"cycles": cycles}
    if out is not None:
        stem = result_stem(out, "cycles", loop)
        write_json(stem.with_name(f"{stem.name}.json"), report)
    if not publish_json(report, json_target):
        for table in tables:
            PeopleConsole().print_table(table)


def parse_angles(text: str) -> list[float]:
    """The finite numbers of a list with commas; InvalidInput names what is not one.

    >>> parse_angles("0, -30,60.5")
    [0.0, -30.0, 60.5]
    """
    angles = []
    for part in map(str.strip, text.split(",")):
        try:
            value = plain_number(part)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InvalidInput(
                f"--theta0-deg has {part!r}; give finite numbers with commas, such as 0,30,60"
            )
        if abs(value) > LARGEST_DEG:
            raise InvalidInput(
                f"--theta0-deg has {part!r}, whose part of a turn is lost to rounding; wrap it "
                "first"
            )
        angles.append(value)
    return angles
