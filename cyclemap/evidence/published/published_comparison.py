"""What a material's numbers predict, beside what is published of it, as it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.evidence.published.cycle_nodes import node_values
from cyclemap.evidence.published.published_statistics import (
    PUBLISHED_CYCLES,
    PublishedStatistics,
    published_statistics,
)
from cyclemap.evidence.published.statistics_block import (
    CYCLE_NOISE,
    PredictedStatistics,
    predicted_statistics,
)
from cyclemap.mechanics import Material, load_material

# A histogram of θ0 has a peak where it exceeds the even one by this factor.
PEAK = 1.5
# A direction that is read off a histogram is not known better (rad).
DIRECTION_TOLERANCE = float(np.deg2rad(15.0))
_UNITS = np.array([180.0 / np.pi, 1e3, 1e3])


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
        return _distance(np.array(self.published.directions), self.peaks)

    @property
    def unexpected(self) -> Array:
        """Stable directions (rad) that are not published: further than 15 degrees from any that is."""
        far = _distance(self.stable, np.array(self.published.directions))
        return self.stable[far > DIRECTION_TOLERANCE]

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
    return PublishedComparison(surface.name, given, found, _stable(found), _peaks(found))


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


def _stable(found: PredictedStatistics) -> Array:
    """Where the turn falls through zero, by linear interpolation, the most visited first."""
    ahead = np.roll(found.turn, -1)
    index = np.flatnonzero((found.turn > 0.0) & (ahead <= 0.0))
    spacing = found.theta[1]
    places = found.theta[index] + spacing * found.turn[index] / (found.turn[index] - ahead[index])
    return np.asarray(places[np.argsort(-found.law[index])] % (2.0 * np.pi))


def _peaks(found: PredictedStatistics) -> Array:
    law = found.law
    top = (law >= np.roll(law, 1)) & (law > np.roll(law, -1)) & (law * law.size > PEAK)
    index = np.flatnonzero(top)
    return np.asarray(found.theta[index[np.argsort(-law[index])]])


def _distance(angles: Array, others: Array) -> Array:
    """Distance (n,) on the circle of each of `angles` (n,) from the nearest of `others`; inf where there is none."""
    off = np.abs((angles[:, np.newaxis] - others + np.pi) % (2.0 * np.pi) - np.pi)
    return np.asarray(np.min(off, axis=1, initial=np.inf))


def _degrees(angles: Iterable[float]) -> str:
    listed = [f"{np.degrees(angle) % 360.0:.0f}" for angle in angles]
    return ", ".join(listed) + " deg" if listed else "none"
