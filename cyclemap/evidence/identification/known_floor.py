"""What is known before an identification, of a floor from its material, of plates from their
shapes, and the identification of collected data with it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from cyclemap.errors import ConvergenceError
from cyclemap.evidence.identification.collected_blocks import CollectedBlocks
from cyclemap.evidence.identification.data_block import SESSION_KINDS, USUAL, DataBlock, asked_by
from cyclemap.evidence.identification.identify import Identification, identify
from cyclemap.evidence.identification.session_blocks import PLATE_OWNED, SESSION_OWNED
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_NAMES,
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    ParameterSpace,
    SurfaceParameters,
    Values,
    field_factors,
)
from cyclemap.evidence.pushes.measured_strokes import ROD_OFF
from cyclemap.mechanics import Material, PlatePressure
from cyclemap.progress import Progress

# What a session may be off by, kPa, of which no spread is known; less is no spread.
_LEAST_SPREAD = 0.2
# What a floor tells of the friction ellipse, but for its size, which no motion tells, and the ring.
_ELLIPSE = SURFACE.names[1:5]
_RING = "pin_friction_radius"
FLOOR_TOLD = (*_ELLIPSE, _RING)
# So many sessions tell how the floor's shape varies with the place.
_SESSIONS_OF_A_FIELD = 4
# Samples that differ by less than this share of their mean are all the same.
_ALIKE = 1e-9
# How well a material knows what it has no samples of.
_SURE = {"pusher_friction": 0.02, _RING: 5e-4}
_SURE_SHAPE = 0.5


def known_beliefs(
    floor: Material | None, names: Sequence[str], plate: str = "rect1"
) -> dict[str, tuple[float, float]]:
    """Return what a material tells of unknowns: mean and deviation of its samples, SI units and
    kPa.

    plate : the object that names without one are of. Samples are of new sessions: of the floor's
        mean the spread between sessions is taken off again, down to what the number of its sessions
        leaves. Without samples, or of what is alike in all of them, shapes are taken as
        known to .5 kPa, the rod's friction to .02, the ring's lever to .5 mm, the friction ellipse
        as it stands.
    """
    if floor is None:
        return {}
    count = 0 if floor.posterior is None else len(floor.posterior)
    drawn = [floor.sample(index) for index in range(count)]
    believed = {}
    for name in names:
        plain, _, owner = name.partition("[")
        rows = [_known_value(row, plain, owner.rstrip("]") or plate) for row in (floor, *drawn)]
        if any(row is None for row in rows) or (plain in FLOOR_NAMES and owner):
            continue
        likely = np.array(rows[1:] or rows, dtype=float)
        best = float(np.mean(likely))
        width = float(np.std(likely))
        # What is left of alike numbers is rounding.
        if width <= _ALIKE * abs(best):
            width = _SURE.get(plain, 0.0 if plain in _ELLIPSE else _SURE_SHAPE)
        if plain in FLOOR_NAMES:
            spread = floor.session_spread[FLOOR_NAMES.index(plain)]
            least = max(
                spread / np.sqrt(max(len(floor.sessions), 1)), 0.0 if drawn else _SURE_SHAPE
            )
            width = float(np.sqrt(max(width**2 - spread**2, least**2)))
        if width > 0.0:
            believed[name] = (best, width)
    return believed


def _known_value(material: Material, name: str, plate: str) -> float | None:
    """What a material tells of an unknown by its plain name."""
    surface = SurfaceParameters.from_friction(material.friction).values()
    values: dict[str, float | None] = {key: surface[key] for key in _ELLIPSE}
    values |= vars(material.found_with)
    values |= zip(FLOOR_NAMES, material.floor.bend.tolist(), strict=True)
    pressure = material.pressure_of(plate)
    if pressure is not None:
        values |= zip(PLATE_NAMES, pressure.shape.bend.tolist(), strict=True)
    return values.get(name)


def known_spread(floor: Material | None, blocks: Sequence[DataBlock]) -> dict[str, float]:
    """Return how much sessions of a known floor differ, kPa, by kind of noise, where blocks tell of
    sessions.
    """
    if floor is None or not any({*block.kinds} & {*SESSION_KINDS} for block in blocks):
        return {}
    dome, along, across = floor.session_spread
    sizes = {
        SESSION_KINDS[0]: dome,
        SESSION_KINDS[1]: float(np.hypot(along, across) / np.sqrt(2.0)),
    }
    return {kind: max(size, _LEAST_SPREAD) for kind, size in sizes.items()}


def known_shapes(
    plates: Sequence[PlatePressure], blocks: Sequence[DataBlock], plate: str
) -> dict[str, float]:
    """Return what known shapes of plates tell of the unknowns of blocks, kPa; of those without a
    name, of `plate`.
    """
    asked = asked_by(blocks)
    values: dict[str, float] = {}
    for known in plates:
        for name, size in zip(PLATE_NAMES, known.shape.bend.tolist(), strict=True):
            owned = f"{name}[{known.plate}]"
            if owned in asked:
                values[owned] = size
            elif known.plate == plate and name in asked:
                values[name] = size
    return values


def held_values(
    blocks: Sequence[DataBlock],
    space: ParameterSpace,
    free: Sequence[str],
    floor: Material | None = None,
) -> dict[str, float]:
    """Return the values of what is held: the friction ellipse, as the space has it, a ring of which
    nothing is told, as usual, and how a floor's shape varies.
    """
    asked = asked_by(blocks) - {*free}
    values = {
        name: at for name, at in space.nominal.items() if name in asked and name in space.names[:5]
    }
    if _RING in asked and space[_RING].nominal == 0.0:
        values[_RING] = USUAL[_RING][0]
    heights = np.zeros(len(FIELD_NAMES))
    if floor is not None and floor.field is not None:
        factors = field_factors().reshape(-1, len(FIELD_NAMES))
        heights = np.linalg.lstsq(factors, np.ravel(floor.field.coefficients), rcond=None)[0]
    return values | {
        name: height
        for name, height in zip(FIELD_NAMES, heights.tolist(), strict=True)
        if name in asked
    }


def telling_parameters(
    blocks: Sequence[DataBlock], believed: Collection[str] | None = None
) -> tuple[str, ...]:
    """Return the names of what blocks of data can usually tell, for a start: not what mostly trades
    off.

    The friction ellipse, its size only where scans or forces tell it; shapes of floor and plates,
    the rod, how each data set's frame is shifted, friction in the ring with cycles, how the surface
    wears; of four sessions and more, how the floor's shape varies with the place. believed : of a
    known floor, what its samples tell of ellipse and ring (`FLOOR_TOLD`); single pushes and drags
    take the rest of it as it stands, and drags the ring: they scatter by more than any ring
    explains, and would take that for friction in it.

    >>> ratios = DataBlock("ratios", ("pusher_friction",), lambda v: None, [0, 1], "ratio")
    >>> telling_parameters([ratios])
    ('pusher_friction',)
    """
    asked = asked_by(blocks)
    by_cycles = asked_by(block for block in blocks if block.curve)
    of_ellipse = by_cycles | asked_by(block for block in blocks if block.motions is None)
    by_motions = asked & {*SURFACE.names[1:5]} & {*(asked if believed is None else believed)}
    free = [name for name in SURFACE.names[:5] if name in of_ellipse | by_motions]
    owned = {row.name for row in (*PLATE_OWNED, *SESSION_OWNED)}
    beside = asked & {"pusher_friction", *by_cycles, *(believed or ())}
    free += [name for name in ("pusher_friction", "pin_friction_radius") if name in beside]
    free += sorted(name for name in asked if name.partition("[")[0] in owned)
    free += [name for block in blocks for name in block.parameters if name.startswith(ROD_OFF)]
    if len([name for name in asked if name.startswith("floor_dome[")]) >= _SESSIONS_OF_A_FIELD:
        free += [name for name in FIELD_NAMES if name in asked]
    return (*free, *sorted(name for name in asked if name.startswith(("worn_", "wear_pace_"))))


def identify_collected(
    collected: CollectedBlocks,
    known: Material | None,
    fixed: Values,
    space: ParameterSpace,
    *,
    free: Sequence[str] = (),
    believes: bool = True,
    folds: int = 0,
    starts: int = 2,
    student: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Identify the parameters named, or else all that the data tell and is not fixed; raises
    ConvergenceError where no start converges.

    known : the floor whose samples are what is believed before. fixed : values that stay, but of
    parameters named. space : where the search begins. believes : whether usual beliefs and those of
    the known floor count; folds, starts, student, seed, progress : see `identify`.
    """
    blocks = collected.blocks
    by_floor = None if known is None else known_beliefs(known, FLOOR_TOLD)
    if not free:
        free = [name for name in telling_parameters(blocks, by_floor) if name not in fixed]
    beliefs = collected.beliefs(free) | known_beliefs(known, free, collected.loop.slider.name)
    held = {name: value for name, value in fixed.items() if name not in free}
    identified = identify(
        blocks,
        free,
        held_values(blocks, space, free, known) | held,
        priors=beliefs if believes else {},
        noise={**collected.noise, **known_spread(known, blocks)},
        folds=folds,
        starts=starts,
        student=student,
        seed=seed,
        space=space,
        progress=progress,
    )
    if not identified.fit.converged:
        raise ConvergenceError(
            f"no start converged: {identified.fit.message}; take more starts, or free fewer "
            "parameters"
        )
    return identified
