"""A plan as tables: one to fill in, and one for a robot that makes the pushes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.push_plan.candidates import APPROACH, SetPush
from cyclemap.evidence.push_plan.plan_pushes import PushPlan
from cyclemap.evidence.tables.planned_table import (
    ERRORS,
    IN_OBJECT,
    ROD,
    SET_UP,
    mark_columns,
    marks_of,
    pose_columns,
    table_bytes,
)
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.text_files import file_stem

MM = 1e3
_POINTS = [f"{place}_{axis}_mm" for place in ("approach", "touch", "end", "ring") for axis in "xy"]
ROBOT = ("push", "set_x_mm", "set_y_mm", "set_theta_deg", *_POINTS)


def table_to_fill(plan: PushPlan, by: str = "corners", excel: bool = False) -> bytes:
    """Return the table that asks for what is measured of each planned push.

    Parameters
    ----------
    plan : PushPlan
        The pushes, in order.
    by : {'corners', 'pose'}
        What is measured: the places of two marks as a ruler tells them; places and
        orientations, and those of the robot's rod. Columns of the other sort may be added: both
        are read.
    excel : bool, default False
        An Excel file in place of CSV.

    Returns
    -------
    bytes
        The file's content; see `empty_table`.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import plan_pushes, table_to_fill
    >>> loop = CollectionLoop.mit("unknown")
    >>> plan = plan_pushes(loop, 2, samples=4, candidates=8, target="pushes")
    >>> header, *rows = table_to_fill(plan, by="pose").decode().splitlines()
    >>> header.split(",")[:4], len(rows)
    (['push', 'object', 'side', 'fraction'], 2)
    """
    return table_bytes(*empty_table(plan.loop, plan.pushes, plan.read, by), excel)


def empty_table(
    loop: CollectionLoop, pushes: Sequence[SetPush], read: tuple[float, float], by: str
) -> tuple[list[str], list[list[object]]]:
    """Return the header and the rows of a table to fill in.

    read : error of a reading, m and rad.
    by : `corners`, the places of two marks as a ruler tells them; `pose`, places and orientations,
        and those of the robot's rod. Columns of the other sort may be added: both are read.
    """
    columns = mark_columns if by == "corners" else pose_columns
    empty = [name for state in "012" for name in columns(state)]
    empty += [] if by == "corners" else [*ROD]
    marks = [MM * coordinate for mark in marks_of(loop.slider) for coordinate in mark]
    rows = []
    for number, planned in enumerate(pushes, 1):
        push, start = planned.push, planned.start
        place, way = first_contact(loop.slider, push, loop.pusher.radius)
        set_up: list[object] = [
            number,
            file_stem(loop.slider.name),
            push.side,
            push.fraction,
            *_rounded([math.degrees(push.angle)]),
        ]
        set_up += _rounded(
            [MM * push.distance, MM * start.x, MM * start.y, math.degrees(start.theta)]
        )
        fixed = _rounded([*(MM * place), *way, *marks, MM * read[0], math.degrees(read[1])])
        rows.append([*set_up, *[None] * len(empty), *fixed])
    return [*SET_UP, *empty, *IN_OBJECT, *ERRORS], rows


def robot_schedule(plan: PushPlan) -> bytes:
    """Return where a robot puts the object and leads its rod, in the room's frame, as a CSV file.

    The object is set, the rod comes in from `approach`, touches at `touch` and goes straight to
    `end`. Then, in the ring wherever that is, it goes straight to `ring`, where the ring was before
    the push.
    """
    rows = []
    for number, planned in enumerate(plan.pushes, 1):
        first, last = (
            np.array(place) for place in planned.rod(plan.loop.slider, plan.loop.pusher.radius)
        )
        approach = first - APPROACH * (last - first) / planned.push.distance
        ring = planned.start.to_world(*plan.loop.slider.hitch)
        places = [
            MM * coordinate for place in (approach, first, last, ring) for coordinate in place
        ]
        pose = [MM * planned.start.x, MM * planned.start.y, math.degrees(planned.start.theta)]
        rows.append([number, *_rounded([*pose, *places])])
    return table_bytes(ROBOT, rows, excel=False)


def _rounded(values: Sequence[float]) -> list[float]:
    return [round(float(value), 6) + 0.0 for value in values]
