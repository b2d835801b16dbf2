"""A plan as tables, one to fill in and one for a robot, and what is known once it is filled in:
what measured pushes tell of a floor of which something was believed before, and whether that is
enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.evidence.identification.collected_blocks import collected_blocks
from cyclemap.evidence.identification.identify import Identification
from cyclemap.evidence.identification.known_floor import identify_collected, known_shapes
from cyclemap.evidence.identification.surface_parameters import starting_space
from cyclemap.evidence.identified_material import identified_material
from cyclemap.evidence.plan_pushes import APPROACH, PushPlan, SetPush
from cyclemap.evidence.pushes.measured_strokes import ReadErrors
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
from cyclemap.mechanics import Pose
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.mechanics.material import ANY_PLATE
from cyclemap.mechanics.plate_footprint import known_plate
from cyclemap.progress import Progress, part_of
from cyclemap.text_files import file_stem

MM = 1e3
_POINTS = [f"{place}_{axis}_mm" for place in ("approach", "touch", "end", "ring") for axis in "xy"]
ROBOT = ("push", "set_x_mm", "set_y_mm", "set_theta_deg", *_POINTS)
# Directions, and whether there are any, are known when this share of what is left to believe
# agrees.
SURE = 0.95


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
        The file's content: a row a push, its side, place, angle, length and orientation to set, and
        columns to fill with where the object was before and after.

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
    loop: CollectionLoop, pushes: Sequence[SetPush], read: ReadErrors, by: str
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
    for index, planned in enumerate(pushes, 1):
        push = planned.push
        place, way = first_contact(loop.slider, push, loop.pusher.radius)
        row: list[object] = [index, file_stem(loop.slider.name), push.side, push.fraction]
        row += _rounded([math.degrees(push.angle), MM * push.distance, *_written(planned.start)])
        fixed = [*(MM * place), *way, *marks, MM * read[0], math.degrees(read[1])]
        rows.append([*row, *[None] * len(empty), *_rounded(fixed)])
    return [*SET_UP, *empty, *IN_OBJECT, *ERRORS], rows


def robot_schedule(plan: PushPlan) -> bytes:
    """Return where a robot puts the object and leads its rod, in the room's frame, as a CSV file.

    The object is set, the rod comes in from `approach`, touches at `touch` and goes straight to
    `end`. Then, in the ring wherever that is, it goes straight to `ring`, where the ring was before
    the push.
    """
    slider = plan.loop.slider
    rows = []
    for index, planned in enumerate(plan.pushes, 1):
        first, last = MM * planned.rod(slider, plan.loop.pusher.radius)
        approach = first - APPROACH * (last - first) / planned.push.distance
        ring = [MM * coordinate for coordinate in planned.start.to_world(*slider.hitch)]
        places = [*approach, *first, *last, *ring]
        rows.append([index, *_rounded([*_written(planned.start), *places])])
    return table_bytes(ROBOT, rows, excel=False)


def _written(pose: Pose) -> tuple[float, float, float]:
    return MM * pose.x, MM * pose.y, math.degrees(pose.theta)


def _rounded(values: Sequence[float]) -> list[float]:
    return [round(float(value), 6) + 0.0 for value in values]


@dataclass(frozen=True, eq=False)
class MeasuredPlan:
    """What pushes on a floor tell of it.

    Attributes
    ----------
    loop : CollectionLoop
        On the identified floor.
    identification : Identification
        Of its parameters.
    directions : DirectionUncertainty
        How well the stable ones are known.
    notes : tuple of str
        What was read and left out.

    Examples
    --------
    Of the file that `filled_text` makes of a filled table:

    >>> from pathlib import Path
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import measured_plan
    >>> loop = CollectionLoop.mit("unknown")
    >>> measured = measured_plan(loop, [Path("read.csv")])  # doctest: +SKIP
    >>> measured.is_enough(within=0.1)  # doctest: +SKIP
    False
    """

    loop: CollectionLoop
    identification: Identification
    directions: DirectionUncertainty
    notes: tuple[str, ...]

    @property
    def half_width(self) -> float:
        """Half the widest 95 % interval of a stable direction that is likely to be there, rad; 0
        where none is.
        """
        widths = [0.0]
        for direction in self.directions.directions:
            if direction.share > 1.0 - SURE:
                widths.append(direction.upper - direction.lower)
        return 0.5 * max(widths)

    def is_enough(self, within: float) -> bool:
        """Whether it is known that the loop locks in, and where to `within` rad, or that it does
        not.
        """
        chance = self.directions.chance
        return chance <= 1.0 - SURE or (chance >= SURE and self.half_width <= within)


def measured_plan(
    loop: CollectionLoop,
    paths: Sequence[Path],
    *,
    seed: int = 0,
    progress: Progress | None = None,
) -> MeasuredPlan:
    """Identify the floor of a loop from measured pushes, and tell how well its stable directions
    are then known.

    Parameters
    ----------
    loop : CollectionLoop
        Its material has samples of what is believed of the floor.
    paths : sequence of Path
        Tables that `readable_data` made readable.
    seed : int, default 0
        Of the starts of the search.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    MeasuredPlan
        The floor, its parameters, and how well directions are known.

    Raises
    ------
    InvalidInput
        For data that cannot be read, or that hold a filled-in push twice.
    ConvergenceError
        Where no start converges.

    Examples
    --------
    Of two pushes, in half a minute:

    >>> from pathlib import Path
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import measured_plan
    >>> loop = CollectionLoop.mit("unknown")
    >>> measured = measured_plan(loop, [Path("read.csv")])  # doctest: +SKIP
    >>> measured.notes  # doctest: +SKIP
    ('read.csv: 2 push ends of rect1',)
    """
    identifying = part_of(progress, 0, 2)
    identification, notes = identified_plan(loop, paths, seed=seed, progress=identifying)
    floor = loop.material
    sources = [path.name for path in paths]
    name = f"{floor.name}-measured"
    material = identified_material(
        identification, name, sources, plate=loop.slider.name, floor=floor
    )
    measured = replace(loop, footprint=None).with_material(material)
    directions = direction_uncertainty(measured, part_of(progress, 1, 2))
    return MeasuredPlan(measured, identification, directions, notes)


def identified_plan(
    loop: CollectionLoop,
    paths: Sequence[Path],
    *,
    starts: int = 2,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[Identification, tuple[str, ...]]:
    """Identify floor, plate, rod and ring from measured pushes, beginning with what the loop's
    material believes.

    loop, paths, seed, progress : see `measured_plan`, and there what is raised.
    starts : of the search. Returns the identification, and notes on what was read. A plate that is
        known stays as it is. Noise is Student's with four degrees of freedom, so that a misread
        ruler counts little.
    """
    floor = loop.material
    collected = collected_blocks(paths, loop, population=True)
    plate = known_plate(floor, collected.loop.slider)
    shapes = () if plate is None or plate.plate == ANY_PLATE else (plate,)
    fixed = known_shapes(shapes, collected.blocks, collected.loop.slider.name)
    identification = identify_collected(
        collected,
        floor,
        fixed,
        starting_space(loop, floor),
        starts=starts,
        student=4.0,
        seed=seed,
        progress=progress,
    )
    return identification, collected.notes
