"""From files of measured data to the blocks that an identification takes, and a note on everything left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.settings import OWN_OUTLINE
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.block_builders import (
    CYCLES,
    LAYOUTS,
    RECORDS,
    BlockChoices,
    Built,
    DataFile,
    csv_part,
    cycle_parts,
    recognise,
    record_parts,
)
from cyclemap.evidence.data_blocks.cycle_pair_block import NODES
from cyclemap.evidence.data_blocks.force_blocks import ScanForces
from cyclemap.evidence.identification.data_block import DataBlock, Progress, part_of
from cyclemap.evidence.pushes.measured_strokes import RowSelection, pushes_of, select_csv, select_pushes, told
from cyclemap.evidence.pushes.push_table import UnreadableFile
from cyclemap.mechanics import MIT_SHAPE_NAMES, Slider
from cyclemap.whole_files import file_stem

MOST_STROKES = 2000
_OWNED = ("rim_share", "corner_share", "inner_share", "tip_offset_x", "tip_offset_y")
_ALWAYS = ("friction_scale", "ellipticity_x", "ellipticity_y", "offset_x", "offset_y", "pusher_friction")


@dataclass(frozen=True, eq=False)
class CollectedBlocks:
    """Blocks of data of one surface, of one object or of several.

    blocks : of unlike names; of several objects each is a `PlateBlock`. notes : what was recognised, what was left out
    and why, in words. surface : its name where the data tell it. loop : with the data's object, where it is one.
    scans : forces of friction scans, None without. last_cycle : number of the last cycle behind the first one used, 0
    where it is unknown.
    """

    blocks: tuple[DataBlock, ...]
    notes: tuple[str, ...]
    surface: str | None
    loop: CollectionLoop
    scans: ScanForces | None
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
    progress: Progress | None = None,
) -> CollectedBlocks:
    """Return the blocks of all data in files, folders and trees.

    paths : files of the MIT layout (friction scans; pushes: their ends, their forces, and cycles where they are
        repeated), CSV tables of push ends with tip, of drag-backs, of orientations or repeated poses, of wrenches and
        twists. loop : who is pushed where, with which rod and ring.
    select : values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Objects are all those of the MIT
        dataset that the data name, or the selected one; of an outline of the loop's own, that one alone.
    first : the first cycle (repetition) used. wear : let the surface of the cycles wear.
    most : strokes of one sort in a file, at most: beyond, every so many-th is taken. nodes : see `CyclePairBlock`;
        with 9 the ring's lever comes out 3 % short on a map with strong second harmonics, with 15 it does not.

    A push of a repeated set tells its end and its cycle's end: their errors are taken as independent.
    Raises InvalidInput where nothing is recognised, naming what each path was, where the data are of several surfaces
    or of several objects of unknown outline, and for a number that does not fit.
    """
    whole_number("first cycle", first, least=0)
    loop, selection = _object(loop, dict(select or {}))
    choices = BlockChoices(loop, first, wear, whole_number("most strokes", most, least=2), nodes)
    found = [recognise(path) for path in paths]
    files = list(dict.fromkeys(file for known, _ in found for file in known))
    unused = list(dict.fromkeys(file for _, others in found for file in others))
    built, surfaces = Built(), set[str]()
    for number, file in enumerate(files):
        surfaces |= _add(built, file, selection, choices, part_of(progress, number, len(files)))
    _check(paths, built, unused, surfaces, loop.slider, selection.chosen)
    notes = (*built.notes, *(f"{file.path}: not used: {file.reason}" for file in unused))
    scans = ScanForces.joined(built.scans) if built.scans else None
    plates = sorted(set(built.plates))
    if len(plates) == 1 and plates[0] in MIT_SHAPE_NAMES:
        loop = _of_plate(loop, plates[0])
    blocks = _named_apart(built.blocks if len(plates) < 2 else built.of_plates())
    return CollectedBlocks(blocks, notes, next(iter(surfaces), None), loop, scans, built.last_cycle)


def telling_parameters(blocks: Sequence[DataBlock]) -> tuple[str, ...]:
    """Return the names of what blocks of data can usually tell, for a start: not what mostly trades off.

    Ellipse, offset and pusher friction wherever a block depends on them, how each plate presses and each data set's
    frame is shifted, friction in the ring with drags or cycles, and how the surface wears.

    >>> from cyclemap.evidence.identification.data_block import FunctionBlock
    >>> telling_parameters([FunctionBlock("ratios", ("pusher_friction",), lambda v: None, [0, 1], "ratio")])
    ('pusher_friction',)
    """
    asked = {name for block in blocks for name in block.parameters}
    plain = {name.partition("[")[0] for name in asked}
    free = [name for name in _ALWAYS if name in asked]
    free += sorted(name for name in asked if name.partition("[")[0] in _OWNED)
    free += ["pin_friction_radius"] if "pin_friction_radius" in plain else []
    return (*free, *sorted(name for name in asked if name.startswith("worn_")))


def _of_plate(loop: CollectionLoop, plate: str) -> CollectionLoop:
    """The loop with a plate of the MIT dataset, its ring where it was; with its own object for that one's name."""
    if plate == loop.slider.name or plate not in MIT_SHAPE_NAMES:
        return loop
    return replace(loop, slider=Slider.mit(plate, loop.slider.hitch), footprint=None)


def _object(loop: CollectionLoop, chosen: dict[str, str | float]) -> tuple[CollectionLoop, RowSelection]:
    """The loop with the selected object, and the selection of rows: of that, of every known object, or of any."""
    wanted = chosen.get("object")
    if isinstance(wanted, str):
        return _of_plate(loop, wanted), RowSelection((wanted,), chosen)
    if loop.slider.name in MIT_SHAPE_NAMES:
        return loop, RowSelection(MIT_SHAPE_NAMES, chosen)
    return loop, RowSelection(() if loop.slider.name == OWN_OUTLINE else (file_stem(loop.slider.name),), chosen)


def _add(
    built: Built, file: DataFile, selection: RowSelection, choices: BlockChoices, progress: Progress
) -> frozenset[str]:
    """Add a file's blocks and notes to what is built; return the surfaces that it tells of."""
    if file.sort in (RECORDS, CYCLES):
        pushes, left_out = select_pushes(file.path, selection, file.sort == CYCLES, part_of(progress, 0, 2))
        built.left_out(file.path, left_out)
        surfaces = told(pushes.table, "surface") | told(pushes.scans, "surface")
        built.objects |= told(pushes.table, "object") | told(pushes.scans, "object")
        if len(surfaces) <= 1:
            plates = sorted(told(pushes.table, "object") | told(pushes.scans, "object"))
            for number, plate in enumerate(plates or [choices.loop.slider.name]):
                own = pushes if len(plates) < 2 else pushes_of(pushes, plate)
                with built.plate(plate):
                    of_plate = replace(choices, loop=_of_plate(choices.loop, plate))
                    if file.sort == CYCLES:
                        cycle_parts(built, file.path, own, of_plate)
                    else:
                        half = part_of(progress, 1, 2)
                        record_parts(built, file.path, own, of_plate, part_of(half, number, max(len(plates), 1)))
        return surfaces
    rows = select_csv(file.path, selection)
    built.left_out(file.path, rows.left_out)
    built.objects |= rows.objects
    if len(rows.surfaces) > 1:
        return rows.surfaces
    for plate in sorted(rows.objects) or [choices.loop.slider.name]:
        chosen = rows if len(rows.objects) < 2 else select_csv(file.path, replace(selection, objects=(plate,)))
        if chosen.texts:
            with built.plate(plate):
                csv_part(built, file, chosen, replace(choices, loop=_of_plate(choices.loop, plate)))
    return rows.surfaces


def _check(
    paths: Sequence[str | Path],
    built: Built,
    unused: Sequence[UnreadableFile],
    surfaces: set[str],
    slider: Slider,
    chosen: Mapping[str, str | float],
) -> None:
    if len(surfaces) > 1:
        raise InvalidInput(f"the data are of several surfaces: {', '.join(sorted(surfaces))}; select one, surface=NAME")
    if len(built.objects) > 1 and slider.name not in MIT_SHAPE_NAMES:
        raise InvalidInput(f"the data are of several objects: {', '.join(sorted(built.objects))}; select one")
    if not built.blocks:
        reasons = [*built.notes, *(f"{file.path}: {file.reason}" for file in unused)]
        listed = "; ".join(reasons) or ", ".join(str(path) for path in paths)
        facts = ", ".join(f"{name}: {value}" for name, value in chosen.items() if name != "object")
        if facts and not unused:
            raise InvalidInput(f"no such {facts}; {listed}")
        raise InvalidInput(f"no data of {slider.name} recognised: {listed}. Give {LAYOUTS}")


def _named_apart(blocks: Sequence[DataBlock]) -> tuple[DataBlock, ...]:
    """Blocks with a number behind the names that several have."""
    counts, seen, named = Counter(block.name for block in blocks), Counter[str](), []
    for block in blocks:
        if counts[block.name] > 1:
            seen[block.name] += 1
            block = replace(block, name=f"{block.name} {seen[block.name]}")  # type: ignore[type-var]
        named.append(block)
    return tuple(named)
