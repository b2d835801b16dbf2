"""Published statistics of a collection as data: means and spreads of the pushes, and where the object lingers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection import CollectionLoop
from cyclemap.evidence.data_blocks.cycle_pair_block import CYCLE_UNKNOWNS
from cyclemap.evidence.data_blocks.fourier_interpolation import interpolation, interpolation_slope
from cyclemap.evidence.identification.data_block import FunctionBlock, Values
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters
from cyclemap.evidence.published.cycle_nodes import NODES, cycle_nodes
from cyclemap.evidence.published.published_statistics import PUBLISHED_CYCLES, PublishedStatistics
from cyclemap.evidence.published.run_law import run_law

# Scatter of measured plywood cycles about a smooth map (rad); on the other materials it is not known.
CYCLE_NOISE = float(np.deg2rad(1.1))
GRID = 480

MEAN_KINDS = ("mean turn (rad)", "mean dx (m)", "mean dy (m)")
STD_KINDS = ("std of turn (rad)", "std of dx (m)", "std of dy (m)")
STILL_KIND, SLOPE_KIND = "turn at a stable direction (rad)", "slope at a stable direction"
THERE_KIND = "share of cycles near the directions"
ADVANCE_KIND, SHARE_KIND = "turn where none is stable (rad)", "share of the first direction"

# How near a prediction is asked to come. Means: about a third of what the mechanics miss on single measured pushes;
# spreads: about a tenth. A direction read off a histogram is good to some 8 degrees; the turn about it changes by less
# than a tenth of that.
TOLERANCES = MappingProxyType(
    {
        MEAN_KINDS[0]: float(np.deg2rad(1.2)),
        MEAN_KINDS[1]: 1.5e-3,
        MEAN_KINDS[2]: 3e-3,
        STD_KINDS[0]: float(np.deg2rad(0.5)),
        STD_KINDS[1]: 0.4e-3,
        STD_KINDS[2]: 1e-3,
        STILL_KIND: float(np.deg2rad(0.6)),
        SLOPE_KIND: 0.05,
        ADVANCE_KIND: float(np.deg2rad(0.5)),
        SHARE_KIND: 0.05,
        THERE_KIND: 0.1,
    }
)
# Where no other peak is seen, at least this share of the cycles lies within so many rad of one of the directions.
MOST, NEAR = 0.9, float(np.deg2rad(30.0))
# A slope above this at a stable direction, and a turn (rad) below this where none is stable, count as misses.
# The paper's "changes very regularly" leaves no place where the object lingers.
STEEPEST, SLOWEST = 0.95, float(np.deg2rad(3.0))
# Share of a parameter's scale by which the law of orientations is differenced.
_STEP = 1e-5


@dataclass(frozen=True, eq=False)
class PredictedStatistics:
    """What a map implies for a published collection.

    theta (n,) : rad. law (n,) : share of the run's cycles that begin at each. turn (n,) : rad, of the noiseless cycle.
    mean, std (3,) : of dtheta (rad), dx, dy (m), the spread about the published fitted law included.
    turn_there, slope_there (d,) : rad and f' at the published directions. first_share : of the cycles nearer to the
    first published direction than to any other; nan with fewer than two. share_there : within NEAR of one of them.
    """

    theta: Array
    law: Array
    turn: Array
    mean: Array
    std: Array
    turn_there: Array
    slope_there: Array
    first_share: float
    share_there: float


def predicted_statistics(
    values: Array, published: PublishedStatistics, sigma: float = CYCLE_NOISE, cycles: int = PUBLISHED_CYCLES
) -> PredictedStatistics:
    """Return the statistics implied by cycles (m, 4), NODE_OUTPUTS at 2 pi k / m, in a run like the published one.

    The run has `cycles` cycles with normal noise `sigma` (rad) each; see `run_law`. The variance of a quantity is that
    of its noiseless value over the law of θ0, plus the published squared error about a law of θ0 (Table III).
    """
    theta, between = _grid(len(values))
    turn, *pushes = between @ values[:, :1], *(between @ values[:, 1:]).T
    law = run_law(turn[:, 0], sigma, cycles, published.start)
    motions = np.array(pushes)
    mean = motions @ law
    variance = (motions - mean[:, np.newaxis]) ** 2 @ law + np.square(published.rmse)
    there = np.array(published.directions)
    return PredictedStatistics(
        theta,
        law,
        turn[:, 0],
        mean,
        np.sqrt(variance),
        interpolation(there, len(values)) @ values[:, 0],
        1.0 + interpolation_slope(there, len(values)) @ values[:, 0],
        _first_share(theta, law, there),
        float(law[(np.cos(theta[:, np.newaxis] - there) >= np.cos(NEAR)).any(axis=1)].sum()),
    )


def statistics_block(
    published: PublishedStatistics,
    loop: CollectionLoop,
    sigma: float = CYCLE_NOISE,
    nodes: int = NODES,
    cycles: int = PUBLISHED_CYCLES,
) -> FunctionBlock:
    """Return the published statistics of a material as a block that depends on CYCLE_UNKNOWNS.

    Rows: three means and three standard deviations; at each stable direction the turn, and by how much the slope
    exceeds STEEPEST; where no direction is stable, by how much the turn falls below SLOWEST at each node; the share of
    the first direction where it is told; by how much the share near the directions falls below MOST where the text sees
    no other. Cycles are computed at `nodes` (odd) orientations with exact derivatives; the
    law of θ0 is differenced through the nodes, to first order, without further mechanics. Give `noise=TOLERANCES` to
    `identify`: so few numbers cannot tell their own scatter.
    """
    kinds = _kinds(published, nodes)

    def function(values: Values) -> tuple[Array, Array]:
        found = cycle_nodes(SurfaceParameters.from_values(values), loop, nodes)
        rows = _rows(found.values, published, sigma, cycles)
        jacobian = np.empty((rows.size, len(CYCLE_UNKNOWNS)))
        for index, name in enumerate(CYCLE_UNKNOWNS):
            step = _STEP * SURFACE[name].scale
            moved = found.values + step * found.jacobian[..., index]
            jacobian[:, index] = (_rows(moved, published, sigma, cycles) - rows) / step
        return rows, jacobian

    name = f"published statistics of {published.material}"
    return FunctionBlock(name, CYCLE_UNKNOWNS, function, np.arange(len(kinds)), np.array(kinds))


def _kinds(published: PublishedStatistics, nodes: int) -> list[str]:
    many, told = len(published.directions), published.first_share is not None
    kinds = [*MEAN_KINDS, *STD_KINDS, *[STILL_KIND] * many, *[SLOPE_KIND] * many]
    return [
        *kinds,
        *[ADVANCE_KIND] * (nodes * published.always_advancing),
        *[SHARE_KIND] * told,
        *[THERE_KIND] * published.only_there,
    ]


def _rows(values: Array, published: PublishedStatistics, sigma: float, cycles: int) -> Array:
    """Predicted minus published, in the order of `_kinds`."""
    found = predicted_statistics(values, published, sigma, cycles)
    parts = [found.mean - published.mean, found.std - published.std, found.turn_there]
    parts.append(np.maximum(found.slope_there - STEEPEST, 0.0))
    if published.always_advancing:
        parts.append(np.minimum(values[:, 0] - SLOWEST, 0.0))
    if published.first_share is not None:
        parts.append(np.array([found.first_share - published.first_share]))
    if published.only_there:
        parts.append(np.array([min(found.share_there - MOST, 0.0)]))
    return np.concatenate(parts)


def _first_share(theta: Array, law: Array, directions: Array) -> float:
    if directions.size < 2:
        return float("nan")
    nearness = np.cos(theta[:, np.newaxis] - directions)
    return float(law[np.argmax(nearness, axis=1) == 0].sum())


@lru_cache(maxsize=4)
def _grid(count: int) -> tuple[Array, Array]:
    """Angles (GRID,) and the matrix (GRID, count) from nodes to them."""
    theta = 2.0 * np.pi * np.arange(GRID) / GRID
    return theta, interpolation(theta, count)
