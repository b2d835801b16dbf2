"""Materials that stand for a range, a posterior or a list: who offers them, and the values that were drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Material

Array = NDArray[np.float64]

# How points are drawn beside the chosen ones: evenly spread, or each anew (then shares have exact confidence bounds).
SOBOL, INDEPENDENT = "sobol", "independent"


@dataclass(frozen=True, eq=False)
class SampledMaterials:
    """Materials, and where each lies.

    materials : n of them. points : (n, d), the coordinates in which they were drawn. names : of the d coordinates.
    chosen : how many of the first were chosen (the nominal one, corners), not drawn. independent : whether the others
    were drawn independently of each other from one law. cube : whether they fill the cube [-1, 1]^d.

    >>> from cyclemap.mechanics import load_material
    >>> SampledMaterials((load_material("pu"),), np.zeros((1, 0)), (), 1).drawn
    0
    """

    materials: tuple[Material, ...]
    points: Array
    names: tuple[str, ...]
    chosen: int
    independent: bool = False
    cube: bool = False

    def __post_init__(self) -> None:
        points, count = finite_array("points", self.points, ndim=2), len(self.materials)
        if not count or points.shape != (count, len(self.names)):
            raise InvalidInput(
                f"{count} materials with {len(self.names)} coordinates need points of shape "
                f"({count}, {len(self.names)}) and one material at least, not {points.shape}"
            )
        if not 0 <= whole_number("chosen", self.chosen) <= count:
            raise InvalidInput(f"chosen is {self.chosen}: it counts some of the {count} materials")
        object.__setattr__(self, "materials", tuple(self.materials))
        object.__setattr__(self, "points", read_only(points))

    def __len__(self) -> int:
        return len(self.materials)

    @property
    def drawn(self) -> int:
        """How many were drawn, not chosen."""
        return len(self.materials) - self.chosen


@runtime_checkable
class MaterialSource(Protocol):
    """What robust design asks of a set of materials; the nominal material is the first of every answer."""

    def sampled(self, count: int, seed: int = 0, draw: str = SOBOL) -> SampledMaterials:
        """Return `count` materials: the nominal one, those that are chosen, then drawn ones; same seed, same ones."""

    def scenarios(self) -> SampledMaterials:
        """Return a few materials that are likely to hold the worst."""

    def without_direction(self) -> MaterialSource:
        """Return the same materials with the surface's direction left out, where that is a separate coordinate."""


@dataclass(frozen=True)
class MaterialList:
    """Materials given outright; `sampled` returns them, at most `count`, and draws nothing.

    >>> from cyclemap.mechanics import load_material
    >>> len(MaterialList((load_material("pu"), load_material("abs"))).sampled(10))
    2
    """

    materials: tuple[Material, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "materials", tuple(self.materials))
        if not self.materials or not all(isinstance(one, Material) for one in self.materials):
            raise InvalidInput(f"a list of materials needs one or more of Material, not {self.materials!r}")

    def sampled(self, count: int, seed: int = 0, draw: str = SOBOL) -> SampledMaterials:
        """Return the first `count` of them, or all where there are fewer."""
        checked_draw(draw)
        kept = self.materials[: whole_number("count", count, least=1)]
        return SampledMaterials(kept, np.empty((len(kept), 0)), (), len(kept))

    def scenarios(self) -> SampledMaterials:
        """Return all of them."""
        return self.sampled(len(self.materials))

    def without_direction(self) -> MaterialList:
        """Return the list itself: its materials are what they are."""
        return self


def material_source(given: MaterialSource | Material | Sequence[Material]) -> MaterialSource:
    """Return a source of materials, one material or a sequence of them as a source; InvalidInput for anything else.

    >>> from cyclemap.mechanics import load_material
    >>> len(material_source(load_material("pu")).scenarios())
    1
    """
    if isinstance(given, Material):
        return MaterialList((given,))
    if isinstance(given, MaterialSource):
        return given
    if isinstance(given, Sequence) and not isinstance(given, str):
        return MaterialList(tuple(given))
    raise InvalidInput(f"{given!r} is no set of materials: give a MaterialRange, a MaterialPosterior or a list")


def checked_draw(draw: str) -> str:
    """Return how points are to be drawn, or raise InvalidInput."""
    if draw not in (SOBOL, INDEPENDENT):
        raise InvalidInput(f"draw is {draw!r}: it must be {SOBOL!r} or {INDEPENDENT!r}")
    return draw


def unit_points(count: int, dimensions: int, seed: int, draw: str) -> Array:
    """Return points (count, dimensions) of the unit cube, scrambled Sobol (Owen 1998) or independent.

    >>> unit_points(5, 2, 0, SOBOL).shape
    (5, 2)
    """
    checked_draw(draw)
    if not count or not dimensions:
        return np.empty((count, dimensions))
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    if draw == INDEPENDENT:
        return rng.random((count, dimensions))
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=True, rng=rng)
    return np.asarray(engine.random_base2(max(count - 1, 1).bit_length())[:count])


def spread_out(points: Array, count: int) -> list[int]:
    """Return the indices of `count` of the points (n, d) far from each other, the first point first.

    Each next one is the point furthest from all that were taken (Gonzalez 1985): no point is then further from them
    than twice the least that any choice of as many allows.

    >>> spread_out(np.array([[0.0], [1.0], [0.9], [-3.0]]), 3)
    [0, 3, 1]
    """
    taken, nearest = [0], np.linalg.norm(points - points[0], axis=1)
    while len(taken) < min(count, len(points)):
        taken.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[taken[-1]], axis=1))
    return taken
