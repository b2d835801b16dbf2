"""What is drawn of an identification: friction ellipses, forces, data beside predictions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.evidence.data_blocks.cycle_pair_block import CyclePairBlock
from cyclemap.evidence.data_blocks.scan_forces import ScanForces
from cyclemap.evidence.data_blocks.stroke_block import StrokeBlock
from cyclemap.evidence.identification.data_block import plain_block
from cyclemap.evidence.identification.derived_quantities import sampled_surfaces
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics import EllipseFriction

_AROUND = np.linspace(0.0, 2.0 * np.pi, 181)
_BAND_DRAWS = 200


@dataclass(frozen=True, eq=False)
class TurnFit:
    """Turns of strokes of one block: measured and predicted (n,), rad."""

    name: str
    measured: Array
    predicted: Array


@dataclass(frozen=True, eq=False)
class PlaceFit:
    """Errors of the places where pushes of a block ended, predicted less measured, (n, 2), m."""

    name: str
    errors: Array


@dataclass(frozen=True, eq=False)
class CycleFit:
    """Cycles: orientation and turn measured (n,), rad; the fitted map's turn (k,) over `grid` (k,).

    late : (k,) the same at the end of the data where the surface wears, else None.
    """

    name: str
    theta: Array
    turn: Array
    grid: Array
    fitted: Array
    late: Array | None


@dataclass(frozen=True, eq=False)
class IdentifiedCurves:
    """Friction in units of a traction coefficient: the ellipse (m, 2), its worn state, sampled ones (d, m, 2).

    worn : None where nothing wears. forces : (s, 2) measured by scans, None without. sized : whether the data tell the
    size of the ellipse, and not its shape alone.
    """

    ellipse: Array
    worn: Array | None
    samples: Array
    forces: Array | None
    sized: bool
    turns: tuple[TurnFit, ...]
    places: tuple[PlaceFit, ...]
    cycles: tuple[CycleFit, ...]


def identified_curves(found: Identification, scans: ScanForces | None = None, seed: int = 0) -> IdentifiedCurves:
    """Compute what is drawn of an identification; `scans` : the forces of its friction scans."""
    laws = [surface.to_friction() for surface in sampled_surfaces(found, _BAND_DRAWS, seed)]
    worn = worn_friction_of(found)
    turns, places, cycles = [], [], []
    for number, block in enumerate(found.problem.blocks):
        errors = found.fit.residuals[found.problem.block_index == number]
        plain = plain_block(block)
        if isinstance(plain, StrokeBlock):
            turns.append(_turns(block.name, plain, errors))
            if len(plain.row_kinds) == 3:
                places.append(PlaceFit(block.name, errors.reshape(-1, 3)[:, :2]))
        elif isinstance(plain, CyclePairBlock):
            own = dict(zip(plain.parameters, block.parameters, strict=True))
            cycles.append(_cycles(block.name, plain, {name: found.values[own[name]] for name in own}))
    return IdentifiedCurves(
        _outline(found.friction()),
        None if worn is None else _outline(worn),
        np.array([_outline(law) for law in laws]).reshape(-1, _AROUND.size, 2),
        None if scans is None else scans.traction,
        "friction_scale" in found.problem.space.names,
        tuple(turns),
        tuple(places),
        tuple(cycles),
    )


def worn_friction_of(found: Identification) -> EllipseFriction | None:
    """Return the friction at the end of the data where they were let wear, else None."""
    values = found.values
    worn = {name.removeprefix("worn_"): value for name, value in values.items() if name.startswith("worn_")}
    return SurfaceParameters.from_values({**values, **worn}).to_friction() if worn else None


def _outline(law: EllipseFriction) -> Array:
    """Traction (m, 2) over all directions of sliding, world axes."""
    return law.traction(np.stack([np.cos(_AROUND), np.sin(_AROUND)], axis=-1))


def _turns(name: str, block: StrokeBlock, errors: Array) -> TurnFit:
    """Turns of strokes; each stroke's last row is its turn."""
    measured = np.array([stroke.end.theta - stroke.start.theta for stroke in block.strokes])
    return TurnFit(name, measured, measured + errors.reshape(len(block.strokes), -1)[:, -1])


def _cycles(name: str, block: CyclePairBlock, values: Mapping[str, float]) -> CycleFit:
    def turn(share: float) -> Array:
        shares = None if block.share is None else np.full(_AROUND.size, share)
        grid = replace(block, theta=_AROUND, turn=np.zeros(_AROUND.size), labels=np.arange(_AROUND.size), share=shares)
        return grid.residuals(values)[0]

    late = None if block.share is None else turn(1.0)
    return CycleFit(name, block.theta, block.turn, _AROUND, turn(0.0), late)
