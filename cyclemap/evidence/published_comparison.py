"""What a material predicts for MIT's repeated pushes, beside what is published of them, and that as data."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.cycle_pair_block import (
    CYCLE_UNKNOWNS,
    cycles_by_unknowns,
    interpolation,
    interpolation_slope,
)
from cyclemap.evidence.identification.data_block import FunctionBlock, Values
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters
from cyclemap.evidence.published_statistics import PUBLISHED_CYCLES, PublishedStatistics, published_statistics, run_law
from cyclemap.mechanics import Material, load_material
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS

# What a node holds: the turn of the whole cycle (rad), then turn (rad) and displacement (m) of the push.
NODE_OUTPUTS = ("cycle_turn", "push_turn", "push_dx", "push_dy")
NODES = 47
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
# A histogram of θ0 has a peak where it exceeds the even one by this factor.
PEAK = 1.5
# A direction that is read off a histogram is not known better (rad).
DIRECTION_TOLERANCE = float(np.deg2rad(15.0))
_UNITS = np.array([180.0 / np.pi, 1e3, 1e3])


def cycle_nodes(surface: SurfaceParameters, loop: CollectionLoop, count: int = NODES) -> tuple[Array, Array]:
    """Run cycles of `loop` on an identified surface at orientations 2 pi k / count, count odd.

    Returns their NODE_OUTPUTS (count, 4) and the exact derivatives of these by the k CYCLE_UNKNOWNS (count, 4, k).
    Raises what the mechanics raise where they have no answer.
    """
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    if count % 2 == 0:
        raise InvalidInput(f"{count} nodes: their number must be odd, for a real Fourier series")
    runs, by_unknowns = cycles_by_unknowns(surface, loop, theta)
    values = np.column_stack([runs.theta_next[0] - theta, runs.push_turn[0], runs.push_displacement[0]])
    rows = [CYCLE_OUTPUTS.index(name) for name in ("theta_next", *NODE_OUTPUTS[1:])]
    return values, by_unknowns[:, rows]


def node_values(loop: CollectionLoop, count: int = NODES) -> Array:
    """Run `count` cycles of a loop, evenly spread in orientation, and return their NODE_OUTPUTS (count, 4).

    >>> np.degrees(node_values(CollectionLoop.mit(), 9)[0, :2]).round(3)
    array([ 9.965, 73.653])
    """
    theta = 2.0 * np.pi * np.arange(whole_number("count", count, least=9)) / count
    runs = loop.cycles(theta)
    return np.column_stack([runs.theta_next - theta, runs.push_turn, runs.push_displacement])


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
    theta = 2.0 * np.pi * np.arange(GRID) / GRID
    between = _interpolation(len(values))
    turn, *pushes = between @ values[:, :1], *(between @ values[:, 1:]).T
    law = run_law(turn[:, 0], sigma, cycles, published.start)
    motions = np.array(pushes)
    mean = motions @ law
    variance = (motions - mean[:, np.newaxis]) ** 2 @ law + np.square(published.rmse)
    there = np.array(published.directions)
    nearness = np.cos(theta[:, np.newaxis] - there)
    first_share = float(law[np.argmax(nearness, axis=1) == 0].sum()) if there.size > 1 else float("nan")
    return PredictedStatistics(
        theta,
        law,
        turn[:, 0],
        mean,
        np.sqrt(variance),
        interpolation(there, len(values)) @ values[:, 0],
        1.0 + interpolation_slope(there, len(values)) @ values[:, 0],
        first_share,
        float(law[(nearness >= np.cos(NEAR)).any(axis=1)].sum()),
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
    directions, told = len(published.directions), published.first_share is not None
    kinds = [*MEAN_KINDS, *STD_KINDS, *[STILL_KIND] * directions, *[SLOPE_KIND] * directions]
    kinds += [ADVANCE_KIND] * (nodes * published.always_advancing) + [SHARE_KIND] * told
    kinds += [THERE_KIND] * published.only_there

    def function(values: Values) -> tuple[Array, Array]:
        found, by_unknowns = cycle_nodes(SurfaceParameters.from_values(values), loop, nodes)
        rows = _rows(found, published, sigma, cycles)
        jacobian = np.empty((rows.size, len(CYCLE_UNKNOWNS)))
        for index, name in enumerate(CYCLE_UNKNOWNS):
            step = _STEP * SURFACE[name].scale
            moved = found + step * by_unknowns[..., index]
            jacobian[:, index] = (_rows(moved, published, sigma, cycles) - rows) / step
        return rows, jacobian

    name = f"published statistics of {published.material}"
    return FunctionBlock(name, CYCLE_UNKNOWNS, function, np.arange(len(kinds)), np.array(kinds))


def _rows(values: Array, published: PublishedStatistics, sigma: float, cycles: int) -> Array:
    """Predicted minus published, in the order of `statistics_block`."""
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


@lru_cache(maxsize=4)
def _interpolation(count: int) -> Array:
    """The matrix (GRID, count) from nodes to angles of the grid: the same for every fit of a block."""
    return interpolation(2.0 * np.pi * np.arange(GRID) / GRID, count)


@dataclass(frozen=True, eq=False)
class PublishedComparison:
    """A material's prediction and the published numbers.

    stable : rad in [0, 2 pi), the stable directions of the noiseless map, those most visited first.
    peaks : rad, where the predicted histogram of θ0 exceeds 1.5 times the even one and its neighbours, highest first.
    """

    material: str
    published: PublishedStatistics
    predicted: PredictedStatistics
    stable: Array
    peaks: Array

    @property
    def misses(self) -> Array:
        """How far (rad) each published direction lies from the nearest peak; inf where there is none. (d,)"""
        off = np.abs(shorter_way(np.array(self.published.directions)[:, np.newaxis] - self.peaks))
        return np.asarray(np.min(off, axis=1, initial=np.inf))

    @property
    def sentence(self) -> str:
        """Means, spreads and directions, predicted and published, in words."""
        pairs = zip(("turn", "dx", "dy"), ("deg", "mm", "mm"), *self._numbers(), strict=True)
        told = [
            f"{name} {mean:.1f} +- {std:.2f} {unit} (published {at:.1f} +- {by:.2f})"
            for name, unit, mean, std, at, by in pairs
        ]
        return f"{', '.join(told)}; {self._directions()}"

    def _numbers(self) -> tuple[Array, Array, Array, Array]:
        found, given = self.predicted, self.published
        return found.mean * _UNITS, found.std * _UNITS, np.array(given.mean) * _UNITS, np.array(given.std) * _UNITS

    def _directions(self) -> str:
        published = _degrees(self.published.directions) if self.published.directions else "none"
        text = f"stable directions {_degrees(self.stable)}, peaks of the histogram {_degrees(self.peaks)}"
        told = f"{text} (published {published})"
        missed = np.array(self.published.directions)[self.misses > DIRECTION_TOLERANCE]
        if missed.size:
            told += f"; no peak within 15 deg of {_degrees(missed)}"
        if self.published.first_share is not None:
            share = f"{100 * self.predicted.first_share:.1f} % (published {100 * self.published.first_share:.1f} %)"
            told += f"; share of the first direction {share}"
        if self.published.always_advancing:
            least = np.degrees(self.predicted.turn.min())
            told += f"; the least turn of a cycle {least:.2f} deg (published: always positive)"
        return told


def published_comparison(
    material: Material | str | Path, published: PublishedStatistics | None = None, sigma: float = CYCLE_NOISE
) -> PublishedComparison:
    """Compare what a material predicts for MIT's repeated pushes with what is published of it.

    material : a material, the name of one, or its file. published : None looks up the first part of the material's
    name, so that `plywood-measured` meets `plywood`. sigma : rad, noise of a cycle. A surface that wears is taken as it
    is half way through the run.

    Raises InvalidInput where nothing is published of the material.

    >>> found = published_comparison("plywood")
    >>> np.degrees(found.stable).round().tolist()
    [63.0]
    """
    surface = material if isinstance(material, Material) else load_material(material)
    given = published or published_statistics(surface.name.split("-")[0])
    loop = worn_loop(CollectionLoop.mit(surface), 0.5 * PUBLISHED_CYCLES)
    found = predicted_statistics(node_values(loop), given, sigma)
    # Where the turn falls through zero, by linear interpolation.
    ahead, law = np.roll(found.turn, -1), found.law
    falls = np.flatnonzero((found.turn > 0.0) & (ahead <= 0.0))
    places = found.theta[falls] + found.theta[1] * found.turn[falls] / (found.turn[falls] - ahead[falls])
    stable = places[np.argsort(-law[falls])] % (2.0 * np.pi)
    tops = np.flatnonzero((law >= np.roll(law, 1)) & (law > np.roll(law, -1)) & (law * law.size > PEAK))
    return PublishedComparison(surface.name, given, found, stable, found.theta[tops[np.argsort(-law[tops])]])


def comparison_table(comparisons: Iterable[PublishedComparison]) -> str:
    """Return the comparisons as a text table: mean and standard deviation, predicted and published, and directions."""
    lines = [f"{'':18}{'predicted':>18}{'published':>18}"]
    for one in comparisons:
        lines.append(one.material)
        named = zip(("turn (deg)", "dx (mm)", "dy (mm)"), *one._numbers(), strict=True)
        for name, mean, std, at, by in named:
            lines.append(f"  {name:16}{f'{mean:.1f} +- {std:.2f}':>18}{f'{at:.1f} +- {by:.2f}':>18}")
        lines.append(f"  {one._directions()}")
    return "\n".join(lines)


def _degrees(angles: Iterable[float]) -> str:
    listed = [f"{np.degrees(angle) % 360.0:.0f}" for angle in angles]
    return ", ".join(listed) + " deg" if listed else "none"
