"""`cyclemap plan`: pushes to make by hand or robot, as tables, sentences, JSON and a picture to
print.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from pathlib import Path

import click
from rich.table import Table

from cyclemap.arrays import Array
from cyclemap.cli.collected.readable_data import readable_tables
from cyclemap.cli.commands import PlanOptions
from cyclemap.cli.options import TableOptions, pair_in_metres, said_command
from cyclemap.cli.output import (
    PeopleConsole,
    Told,
    file_stem,
    millimetres,
    people_table,
    progress_bar,
    publish,
    publish_json,
    push_report,
    styled,
    uncertainty_report,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.identified_words import implausible
from cyclemap.evidence.measured_plan import (
    MeasuredPlan,
    measured_plan,
    robot_schedule,
    table_to_fill,
)
from cyclemap.evidence.plan_pushes import PushPlan, SetPush, plan_pushes
from cyclemap.evidence.tables.data_kinds import files_of_data, recognise
from cyclemap.plain_text import number_or_nan
from cyclemap.protocol.chosen_loop import chosen_loop
from cyclemap.protocol.collection_file import collection_text
from cyclemap.text_files import write_whole
from cyclemap.views.push_pages import known_sizes, measured_sentences, plan_page, plan_sentences
from cyclemap.written import Json, degrees, json_of, rows

FREE = "free"


def run_plan(asked: PlanOptions) -> None:
    """Plan what is asked for, after what was measured, write its tables and picture, and tell what
    will be known.
    """
    if asked.object_file.suffix != ".toml":
        raise InvalidInput(
            f"{asked.object_file}: give the file of your object; cyclemap init makes one, MIT's "
            "with --shape"
        )
    step = _orientation_step(asked.grid)
    room = _room(asked.room_mm)
    loop = chosen_loop(asked.floor, asked.object_file, asked.settings).loop
    out = asked.results.out
    name = f"plan_{file_stem(loop.slider.name)}"
    within = math.radians(asked.until_deg)
    as_json: Json = {}
    sentences: list[Told] = []
    if asked.after:
        floor = out / f"{name}_measured.toml"
        measured = _measured(asked, loop, floor)
        as_json = measured_report(measured, within)
        sentences += measured_sentences(measured, within)
        if measured.is_enough(within):
            if not publish_json(as_json, asked.results.json):
                PeopleConsole().tell(*sentences, f"floor and plate: {floor}")
                PeopleConsole().print(f"next: cyclemap portrait {shlex.quote(str(floor))}")
            return
        loop = measured.loop
    with progress_bar("choosing pushes") as report:
        plan = plan_pushes(
            loop,
            asked.pushes,
            target=asked.target,
            grid=step,
            room=room,
            seed=asked.seed,
            progress=report,
            read=(1e-3 * asked.error_mm, math.radians(asked.error_deg)),
        )
    headline, *others = plan_sentences(plan)
    content = table_to_fill(plan, asked.by or ("pose" if step is None else "corners"), asked.excel)
    table = _unused(out / name, ".xlsx" if asked.excel else ".csv", content)
    robot = out / f"{table.stem}_robot.csv"
    following = shlex.join([*said_command("json"), "--after", str(table)])
    publish(
        {**plan_report(plan), **as_json},
        plan_page(plan),
        asked.results,
        table.stem,
        *sentences,
        styled(headline, "bold"),
        *others,
        push_table(plan),
        knowledge_table(plan),
        after=(f"for a robot: {robot}", f"to fill in: {table}", f"next: {following}"),
        beside={table: content, robot: robot_schedule(plan)},
    )


def _room(text: str) -> tuple[float, float]:
    """The width and depth (m) of the table."""
    room = pair_in_metres("--room-mm", text)
    if not 0.0 < min(room) <= max(room) <= 100.0:
        raise InvalidInput(
            f"--room-mm {text!r}: give the width and depth of the table in mm, such as 600,400"
        )
    return room


def _measured(asked: PlanOptions, loop: CollectionLoop, floor: Path) -> MeasuredPlan:
    """What the tables that were filled in tell, written as a floor; its doubts go to stderr."""
    readable = readable_tables(asked.after, TableOptions(), asked.results.out)
    for path in readable:
        files, problems = files_of_data(path), list[str]()
        for file in files:
            try:
                recognise(file)
            except DataFileError as error:
                problems.append(str(error))
        if len(problems) == len(files):
            mend = "--after takes the table that cyclemap plan wrote, filled in"
            raise InvalidInput(f"{problems[0]}; {mend}")
    with progress_bar("identifying") as report:
        measured = measured_plan(loop, readable, seed=asked.seed, progress=report)
    for words in implausible(measured.identification, loop.slider.outline.extent):
        click.echo(f"warning: this cannot be right: {words}", err=True)
    write_whole(floor, collection_text(measured.loop).encode())
    return measured


def _orientation_step(grid: str) -> float | None:
    """The angle (rad) between orientations that a hand sets; None for any."""
    if grid == FREE:
        return None
    step = number_or_nan(grid)
    if not 0.1 <= step <= 180.0:
        raise InvalidInput(
            f"--grid {grid!r}: give the degrees between orientations, 0.1 to 180, or {FREE}"
        )
    return math.radians(step)


def _unused(stem: Path, suffix: str, content: bytes) -> Path:
    """Where a table goes that is not there yet, so that one that was filled in is never written
    over.
    """
    path = stem.with_name(f"{stem.name}{suffix}")
    count = 1
    while path.exists() and path.read_bytes() != content:
        count += 1
        path = stem.with_name(f"{stem.name}_{count}{suffix}")
    return path


def plan_report(plan: PushPlan) -> Json:
    """The report of a plan; what will be known in degrees, mm and chances."""
    return {
        "object": plan.loop.slider.name,
        "floor": plan.loop.material.name,
        "for": plan.target,
        "chance_of_lock_in": plan.chance,
        "pushes": [*map(_push, plan.pushes, plan.ends)],
        "knowledge": rows(
            pushes=[after.pushes for after in plan.knowledge],
            planned=[_known(after.planned) for after in plan.knowledge],
            random=[_known(after.random) for after in plan.knowledge],
        ),
        "one_push_lost": _known(plan.without),
        **json_of(plan, "samples", "candidates"),
    }


def _push(planned: SetPush, end: Array) -> Json:
    return {
        **push_report(planned.push),
        "set_x_mm": millimetres(planned.start.x),
        "set_y_mm": millimetres(planned.start.y),
        "set_theta_deg": degrees(planned.start.theta),
        "likely_x1_mm": millimetres(float(end[0])),
        "likely_y1_mm": millimetres(float(end[1])),
        "likely_theta1_deg": degrees(end[2]),
    }


def _known(known: Mapping[str, float]) -> Json:
    named: Json = {}
    for name, value in known.items():
        if name == "wrong":
            named["chance_of_wrong_answer"] = value
        elif name == "place":
            named["place_mm"] = millimetres(value)
        else:
            named[f"{name}_deg"] = degrees(value)
    return named


def measured_report(measured: MeasuredPlan, within: float) -> Json:
    """What the measured pushes told, and whether that is enough."""
    return {
        "enough": measured.is_enough(within),
        "half_width_deg": degrees(measured.half_width),
        "uncertainty": uncertainty_report(measured.directions),
        "notes": [*measured.notes],
    }


def push_table(plan: PushPlan) -> Table:
    """The pushes, a row each."""
    columns = ("push", "side", "at", "slant (°)", "push (mm)", "set to x (mm)", "y (mm)", "θ (°)")
    rows = []
    for row, planned in enumerate(plan.pushes, 1):
        push = planned.push
        start = planned.start
        lengths = (1e3 * push.distance, 1e3 * start.x, 1e3 * start.y)
        numbers = (math.degrees(push.angle), *lengths, math.degrees(start.theta))
        cells = [f"{number:.0f}" for number in numbers]
        rows.append((str(row), str(push.side), f"{push.fraction:.2f}", *cells))
    return people_table("Pushes, what tells most first", columns, rows)


def knowledge_table(plan: PushPlan) -> Table:
    """What will be known after some pushes, planned and random."""
    names = known_sizes(plan.knowledge[0].planned)
    rows = []
    for after in plan.knowledge:
        sizes = [*known_sizes(after.planned).values(), *known_sizes(after.random).values()]
        rows.append((str(after.pushes), *sizes))
    columns = [f"{sort}: {name}" for sort in ("planned", "random") for name in names]
    return people_table("What will be known", ("pushes", *columns), rows)
