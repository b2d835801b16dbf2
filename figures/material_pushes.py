"""The pushes that the tables tell of: simulated ones of every material, and recorded ones where the folder has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cyclemap.evidence import PushSet
from cyclemap.evidence.published_statistics import (
    PublishedStatistics,
    published_statistics,
)

from .measured_folder import MeasuredFolder
from .measured_sets import MeasuredRun, measured_run
from .simulated_collections import PAPER, STANDS_FOR, SampledRun, Sampling, sampled_run

# Of each of the paper's materials, those that a table simulates: plywood by Table I, and as the staircase tells it.
SIMULATED = {surface: tuple(dict.fromkeys((surface, material))) for surface, material in STANDS_FOR.items()}
# Names and units of Δθ, Δx and Δy in the paper's convention, and the factors from radians, m and this package's signs.
QUANTITIES = (("Δθ", "°", 57.29577951308232), ("Δx", "mm", 1e3), ("Δy", "mm", -1e3))


@dataclass(frozen=True, eq=False)
class MaterialPushes:
    """One of the paper's materials. runs : simulated, of each material that stands for it. measured : None without."""

    surface: str
    runs: tuple[SampledRun, ...]
    measured: MeasuredRun | None

    @property
    def published(self) -> PublishedStatistics:
        """What the paper prints."""
        return published_statistics(self.surface)

    @property
    def sets(self) -> list[tuple[str, PushSet]]:
        """The sets with the words for where they come from, the recorded one last."""
        found = [(f"simulated, {run.material}", run.pushes) for run in self.runs]
        return found if self.measured is None else [*found, ("recorded", self.measured.pushes)]


def material_pushes(measured: MeasuredFolder, sampling: Sampling = PAPER) -> tuple[MaterialPushes, ...]:
    """Simulate pushes on every material and look for recorded ones, in the paper's order."""
    return tuple(
        MaterialPushes(
            surface,
            tuple(sampled_run(material, sampling) for material in materials),
            measured_run(measured, surface),
        )
        for surface, materials in SIMULATED.items()
    )


def absent(materials: Sequence[MaterialPushes]) -> list[str]:
    """The materials without recorded pushes."""
    return [one.surface for one in materials if one.measured is None]
