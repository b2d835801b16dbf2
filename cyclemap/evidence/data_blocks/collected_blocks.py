"""From files of measured data to the blocks that an identification takes, and a note on everything left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import OWN_OUTLINE
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.block_builders import (
    LAYOUTS,
    BlockBuilder,
    loop_of_plate,
    recognise,
)
from cyclemap.evidence.data_blocks.stroke_block import NODES, TIP_OFFSET
from cyclemap.evidence.identification.data_block import DataBlock, Progress, part_of
from cyclemap.evidence.identification.surface_parameters import SHARE_NAMES, SURFACE
from cyclemap.evidence.pushes.measured_strokes import RowSelection
from cyclemap.mechanics import MIT_SHAPE_NAMES
from cyclemap.text_files import file_stem

MOST_STROKES = 2000
# What belongs to a plate, or to the frame that its data are in.
_OWNED = (*SURFACE.select(SHARE_NAMES).parameters, *TIP_OFFSET)


@dataclass(frozen=True, eq=False)
class CollectedBlocks:
    """Blocks of data of one surface, of one object or of several.

    blocks : of unlike names; of several objects each is that of a plate. notes : what was recognised, what was left out
    and why, in words. surface : its name where the data tell it. loop : with the data's object, where it is one.
    scans : (n, 2) tractions of friction scans, None without. last_cycle : number of the last
    cycle behind the first one used, 0 where it is unknown.
    """

    blocks: tuple[DataBlock, ...]
    notes: tuple[str, ...]
    surface: str | None
    loop: CollectionLoop
    scans: Array | None
    last_cycle: float


def collected_blocks(
    paths: Sequence[str | Path],
    loop: CollectionLoop,
    select: Mapping[str, str | float] | None = None,
    *,
    first: int = 0,
    wear: bool = False,
    most: int = MOST_STROKES,
    nodes: int = NODES,
    push_length: float | None = None,
    progress: Progress | None = None,
) -> CollectedBlocks:
    """Return the blocks of all data in files, folders and trees.

    paths : files of the MIT layout (friction scans; pushes: their ends, their forces, and cycles where they are
        repeated), CSV tables of push ends with the tip's places or without (then it went as the loop's does, from its
        first touch on), of drag-backs, of orientations, of wrenches and twists. loop : who is pushed where, with which
        rod and ring.
    select : values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Objects are all those of the MIT
        dataset that the data name, or the selected one; of an outline of the loop's own, that one alone.
    first : the first cycle (repetition) used. wear : let the surface of the cycles wear.
    push_length : how far the rod of pushes went from its first touch, m, where tables of poses do not tell; None leaves
        the ends of such pushes out.
    most : strokes of one sort in a file, at most: beyond, every so many-th is taken. nodes : see `cycle_pair_block`;
        with 9 the ring's lever comes out 3 % short on a map with strong second harmonics, with 15 it does not.

    A push of a repeated set tells its end and its cycle's end: their errors are taken as independent.
    Raises InvalidInput where nothing is recognised, naming what each path was, where the data are of several surfaces
    or of several objects of unknown outline, and for a number that does not fit.
    """
    whole_number("first cycle", first, least=0)
    chosen = dict(select or {})
    wanted, objects = chosen.get("object"), MIT_SHAPE_NAMES
    if isinstance(wanted, str):
        loop, objects = loop_of_plate(loop, wanted), (wanted,)
    elif loop.slider.name not in MIT_SHAPE_NAMES:
        objects = () if loop.slider.name == OWN_OUTLINE else (file_stem(loop.slider.name),)
    selection = RowSelection(objects, chosen)
    builder = BlockBuilder(loop, first, wear, whole_number("most strokes", most, least=2), nodes, push_length)
    found = [recognise(path) for path in paths]
    files = list(dict.fromkeys(file for known, _ in found for file in known))
    unused = list(dict.fromkeys(file for _, others in found for file in others))
    surfaces, shapes = set[str](), set[str]()
    for number, (path, sort) in enumerate(files):
        on, of = builder.add_file(path, sort, selection, part_of(progress, number, len(files)))
        surfaces, shapes = surfaces | on, shapes | of
    if len(surfaces) > 1:
        raise InvalidInput(f"the data are of several surfaces: {', '.join(sorted(surfaces))}; select one, surface=NAME")
    if len(shapes) > 1 and loop.slider.name not in MIT_SHAPE_NAMES:
        raise InvalidInput(f"the data are of several objects: {', '.join(sorted(shapes))}; select one")
    if not builder.blocks:
        reasons = [*builder.notes, *(f"{file.path}: {file.reason}" for file in unused)]
        listed = "; ".join(reasons) or ", ".join(str(path) for path in paths)
        facts = ", ".join(f"{name}: {value}" for name, value in chosen.items() if name != "object")
        if facts and not unused:
            raise InvalidInput(f"no such {facts}; {listed}")
        raise InvalidInput(f"no data of {loop.slider.name} recognised: {listed}. Give {LAYOUTS}")
    notes = (*builder.notes, *(f"{file.path}: not used: {file.reason}" for file in unused))
    scans = np.concatenate(builder.scans) if builder.scans else None
    loop = loop if len(set(builder.plates)) > 1 else loop_of_plate(loop, builder.plates[0])
    return CollectedBlocks(builder.named(_OWNED), notes, next(iter(surfaces), None), loop, scans, builder.last_cycle)


def telling_parameters(blocks: Sequence[DataBlock]) -> tuple[str, ...]:
    """Return the names of what blocks of data can usually tell, for a start: not what mostly trades off.

    Ellipse, offset and pusher friction wherever a block depends on them, how each plate presses and each data set's
    frame is shifted, friction in the ring with drags or cycles, and how the surface wears.

    >>> telling_parameters([DataBlock("ratios", ("pusher_friction",), lambda v: None, [0, 1], "ratio")])
    ('pusher_friction',)
    """
    asked = {name for block in blocks for name in block.parameters}
    owned = {one.name for one in _OWNED}
    free = [name for name in SURFACE.names[:6] if name in asked]
    free += sorted(name for name in asked if name.partition("[")[0] in owned)
    free += ["pin_friction_radius"] if "pin_friction_radius" in asked else []
    return (*free, *sorted(name for name in asked if name.startswith("worn_")))
