"""Materials drawn from the uncertainty of an identification."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.data_blocks.stroke_block import StrokeBlock
from cyclemap.evidence.data_blocks.underside import warp_of
from cyclemap.evidence.identification.derived_quantities import sampled_surfaces
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics import FoundWith, Material
from cyclemap.resets.robust.sampled_materials import SOBOL, SampledMaterials, checked_draw, spread_out

Array = NDArray[np.float64]

_POOL = 400  # draws among which scenarios are sought
_SCENARIOS = 12
_ATTEMPTS = 5


@dataclass(frozen=True, eq=False)
class MaterialPosterior:
    """The materials that an identification leaves possible, drawn by `sampled_surfaces`.

    found : the identification. name : of the materials. What the data were asked about besides friction (rod, ring,
    pressure) is drawn along with it and goes into `found_with`; what they leave open stays at its value.
    """

    found: Identification
    name: str = "identified"

    def __post_init__(self) -> None:
        if not isinstance(self.found, Identification):
            raise InvalidInput(f"a posterior needs an Identification, as identify returns it, not {self.found!r}")

    @property
    def names(self) -> tuple[str, ...]:
        """The free parameters, the coordinates of the samples."""
        return tuple(self.found.problem.space.names)

    def sampled(self, count: int, seed: int = 0, draw: str = SOBOL) -> SampledMaterials:
        """Return `count` materials: the best one, then independent draws, whatever `draw` says.

        Raises ConvergenceError where hardly any draw is a friction ellipse.
        """
        checked_draw(draw)
        surfaces = [self.found.surface, *self._draws(whole_number("count", count, least=1) - 1, seed)]
        return self._materials(surfaces, 1, True)

    def scenarios(self) -> SampledMaterials:
        """Return the best material and those among 400 draws that lie furthest from it and from each other."""
        surfaces = [self.found.surface, *self._draws(_POOL, 0)]
        points = self._points(surfaces)
        spread = np.std(points, axis=0)
        kept = spread_out((points - points[0]) / np.where(spread > 0.0, spread, 1.0), _SCENARIOS)
        return self._materials([surfaces[index] for index in kept], len(kept), False)

    def without_direction(self) -> MaterialPosterior:
        """Return the posterior itself: the direction is drawn along with all else."""
        return self

    def _draws(self, count: int, seed: int) -> list[SurfaceParameters]:
        asked = count + 1
        for _ in range(_ATTEMPTS):
            surfaces = sampled_surfaces(self.found, asked, seed)
            if len(surfaces) >= count:
                return list(surfaces[:count])
            asked *= 4
        raise ConvergenceError(
            f"of {asked // 4} draws only {len(surfaces)} are friction ellipses: the data fix too little"
        )

    def _points(self, surfaces: list[SurfaceParameters]) -> Array:
        rows = [[surface.values()[name] for name in self.names if name in surface.values()] for surface in surfaces]
        return np.reshape(rows, (len(surfaces), -1))

    def _materials(self, surfaces: list[SurfaceParameters], chosen: int, independent: bool) -> SampledMaterials:
        known = tuple(name for name in self.names if name in surfaces[0].values())
        made = tuple(self._material(surface, number) for number, surface in enumerate(surfaces))
        return SampledMaterials(made, self._points(surfaces), known, chosen, independent)

    def _material(self, surface: SurfaceParameters, number: int) -> Material:
        asked = {part for block in self.found.problem.blocks for part in block.parameters}
        values = surface.values()
        told = {field.name: values[field.name] for field in fields(FoundWith) if field.name in asked}
        sliders = [block.slider for block in self.found.problem.blocks if isinstance(block, StrokeBlock)]
        if "saddle_b" in asked and sliders:
            told["warp_a"], told["warp_b"] = warp_of(surface, sliders[0])
        name = self.name if number == 0 else f"{self.name} (draw {number})"
        return Material(name, surface.to_friction(), inferred=True, found_with=FoundWith(**told))
