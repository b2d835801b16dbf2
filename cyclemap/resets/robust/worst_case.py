"""The worst that a strategy does over many materials: which one, how many exceed what is allowed, how sure that is."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps import Noise
from cyclemap.mechanics import Material
from cyclemap.resets.robust.material_score import (
    DEFAULT_GRID,
    DEFAULT_NOISE,
    MaterialScore,
    QuickGrid,
    independent_law,
    material_score,
)
from cyclemap.resets.robust.sampled_materials import SOBOL, MaterialSource, SampledMaterials, material_source
from cyclemap.resets.robust.sampling_confidence import largest_between, share_bound
from cyclemap.resets.robust.scenario_loops import direction_matters, loop_on
from cyclemap.resets.scores.reset_scores import ResetScores, reset_scores
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import strategy_maps
from cyclemap.sweeps.point_workers import own_executor

Array = NDArray[np.float64]
S = TypeVar("S")
T = TypeVar("T")


@dataclass(frozen=True)
class Allowance:
    """What a reset may leave: total variation from uniform, how much more after some pushes, and how long a drag.

    total_variation : of the stationary law. reach : that much more after `pushes` pushes from the worst start.
    drag_ratio : mean drag over that of the loop's own push and reset.
    """

    total_variation: float = 0.05
    reach: float = 0.05
    pushes: int = 50
    drag_ratio: float = 2.0

    def __post_init__(self) -> None:
        for name in ("total_variation", "reach"):
            if not 0.0 < finite_number(f"allowed {name}", getattr(self, name)) <= 1.0:
                raise InvalidInput(
                    f"allowed {name} is {getattr(self, name)}: a total variation is above 0 and at most 1"
                )
        whole_number("pushes", self.pushes, least=1)
        positive_number("allowed drag_ratio", self.drag_ratio)

    def is_met(self, score: MaterialScore) -> bool:
        """Whether a material's score keeps all three."""
        return self.excess(score) <= 0.0

    def excess(self, score: MaterialScore) -> float:
        """Return by how much the score exceeds what is allowed, the largest of the three; at most 0 where it is met."""
        return max(
            score.total_variation - self.total_variation,
            score.variation_after - self.total_variation - self.reach,
            score.drag_ratio - self.drag_ratio,
        )


DEFAULT_ALLOWANCE = Allowance()


@dataclass(frozen=True, eq=False)
class WorstCase:
    """A strategy over materials.

    strategy : what was looked at. sample : the materials. scores : of each, in their order. allowance : what was asked.
    direction_matters : whether the surface's direction was varied; where it cannot matter it was left as it is.
    """

    strategy: ResetStrategy
    sample: SampledMaterials
    scores: tuple[MaterialScore, ...]
    allowance: Allowance
    direction_matters: bool

    def column(self, name: str) -> Array:
        """Return one field of all scores, or their `drag_ratio`, (n,)."""
        if name not in {*(field.name for field in fields(MaterialScore)), "drag_ratio"}:
            raise InvalidInput(f"scores have no {name!r}: total_variation, variation_after, drag_ratio, error, ...")
        return np.array([getattr(score, name) for score in self.scores], dtype=float)

    def worst(self, name: str = "total_variation") -> tuple[Material, MaterialScore]:
        """Return the material of the largest value of a column, and its score."""
        at = int(np.argmax(self.column(name)))
        return self.sample.materials[at], self.scores[at]

    def quantile(self, share: float, name: str = "total_variation") -> float:
        """Return a quantile of a column over the drawn materials; over all where none was drawn."""
        values = self.column(name)
        return float(np.quantile(values[self.sample.chosen :] if self.sample.drawn else values, share))

    @property
    def furthest(self) -> Material:
        """The material that exceeds the allowance by most, or comes nearest to it."""
        return self.sample.materials[int(np.argmax([self.allowance.excess(score) for score in self.scores]))]

    @property
    def nominal(self) -> MaterialScore:
        """The score on the nominal material."""
        return self.scores[0]

    @property
    def exceeding(self) -> tuple[Material, ...]:
        """The materials on which the allowance is not kept."""
        pairs = zip(self.sample.materials, self.scores, strict=True)
        return tuple(material for material, score in pairs if not self.allowance.is_met(score))

    @property
    def holds(self) -> bool:
        """Whether the allowance is kept on every one of the materials."""
        return not self.exceeding

    @property
    def exceeding_drawn(self) -> int:
        """On how many of the drawn materials the allowance is not kept."""
        return sum(not self.allowance.is_met(score) for score in self.scores[self.sample.chosen :])

    @property
    def share_exceeding(self) -> float:
        """Upper 95 % confidence bound of the share of all materials that exceed; nan unless draws are independent."""
        if not self.sample.independent or not self.sample.drawn:
            return float("nan")
        return share_bound(self.exceeding_drawn, self.sample.drawn)

    @property
    def variation_between(self) -> float:
        """Estimate of the largest total variation between the samples of a range, by slopes; see `largest_between`.

        nan for a posterior or a list, which have no range to be filled.
        """
        if not self.sample.cube:
            return float("nan")
        return largest_between(self.sample.points, self.column("total_variation"))


def worst_case(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    materials: MaterialSource | Material | Sequence[Material],
    *,
    count: int = 1000,
    seed: int = 0,
    draw: str = SOBOL,
    allowance: Allowance = DEFAULT_ALLOWANCE,
    noise: Noise = DEFAULT_NOISE,
    grid: QuickGrid = DEFAULT_GRID,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> WorstCase:
    """Return how a strategy that draws its actions independently does over `count` materials.

    loop : made for its own material, see `loop_on`. materials : a `MaterialRange`, a `MaterialPosterior`, or materials
    outright. draw : `sobol` or `independent`, which lets shares be bounded with confidence. noise : of a cycle.
    workers : processes; None: one a core. The scores are the same whatever their number. About 0.1 s a material and
    push of the law. A `CycleMapError` on a material names it.

    >>> from cyclemap.mechanics import EllipseFriction, SidePush
    >>> from cyclemap.resets.robust.material_range import MaterialRange
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> even = Material("even", EllipseFriction.isotropic(0.25))
    >>> short = CollectionLoop.mit(even, push=SidePush(distance=0.02))
    >>> found = worst_case(short, StraightReset(), MaterialRange(even, ratio=0.0), count=5, grid=QuickGrid(samples=8))
    >>> len(found.scores), round(found.worst()[1].total_variation, 9)
    (5, 0.0)
    """
    independent_law(strategy, grid.nodes)
    matters, source = direction_matters(loop, strategy), material_source(materials)
    sample = (source if matters else source.without_direction()).sampled(count, seed, draw)
    score = partial(_score, loop, strategy, allowance.pushes, noise, grid)
    scores = []
    for made in spread_work(score, sample.materials, workers):
        scores.append(made)
        if progress is not None:
            progress(len(scores) / len(sample))
    return WorstCase(strategy, sample, tuple(scores), allowance, matters)


def spread_work(work: Callable[[S], T], items: Sequence[S], workers: int | None) -> Iterator[T]:
    """Yield work(item) for every item, in their order, from as many processes; None: one a core."""
    most = (os.cpu_count() or 1) if workers is None else whole_number("workers", workers, least=1)
    count = min(most, len(items))
    if count == 1:
        yield from map(work, items)
        return
    # Fresh processes: CasADi's functions and its threads do not survive a fork. They end when this one does.
    with own_executor(count) as pool:
        yield from pool.map(work, items, chunksize=max(1, min(8, len(items) // (4 * count))))


def worst_scores(
    loop: CollectionLoop,
    found: WorstCase,
    *,
    noise: Noise = DEFAULT_NOISE,
    nodes: int = DEFAULT_GRID.nodes,
    tolerance: float = 1e-4,
    **options: Any,
) -> ResetScores:
    """Return all scores on the material with the largest total variation, from adaptive maps and not from the grid's.

    The difference of their total variations tells how far the quick scores can be trusted. tolerance : rad, of the
    maps; 1e-5 for distances certified to .005. options : those of `ResetScores`, and `modes`.
    """
    here = loop_on(loop, found.worst()[0])
    made = strategy_maps(here, found.strategy, nodes=nodes, tolerance=tolerance)
    return reset_scores(made.maps, noise, made.weights, **options)


def _score(
    loop: CollectionLoop, strategy: ResetStrategy, pushes: int, noise: Noise, grid: QuickGrid, material: Material
) -> MaterialScore:
    try:
        return material_score(loop_on(loop, material), strategy, pushes, noise, grid)
    except CycleMapError as error:
        raise type(error)(f"{material.name}: {error}") from error
