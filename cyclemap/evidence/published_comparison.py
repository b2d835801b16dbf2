"""What a material predicts for MIT's repeated pushes, beside what is published of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.evidence.published_statistics import PUBLISHED_CYCLES, PublishedStatistics, published_statistics, run_law
from cyclemap.mechanics import Material, load_material

NODES = 47
# Scatter of measured plywood cycles about a smooth map (rad); on the other materials it is not known.
CYCLE_NOISE = float(np.deg2rad(1.1))
GRID = 480
# A histogram of θ0 has a peak where it exceeds the even one by this factor.
PEAK = 1.5
# A direction that is read off a histogram is not known better (rad).
DIRECTION_TOLERANCE = float(np.deg2rad(15.0))
_UNITS = np.array([180.0 / np.pi, 1e3, 1e3])


def node_values(loop: CollectionLoop, count: int = NODES) -> Array:
    """Run cycles of a loop at orientations 2 pi k / count: their turn, then turn and displacement of the push.

    (count, 4), rad and m.

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
    mean, std (3,) : of dtheta (rad), dx, dy (m), the spread about the published fitted law included. first_share : of
    the cycles nearer to the first published direction than to any other; nan with fewer than two.
    """

    theta: Array
    law: Array
    turn: Array
    mean: Array
    std: Array
    first_share: float


def predicted_statistics(
    values: Array, published: PublishedStatistics, sigma: float = CYCLE_NOISE, cycles: int = PUBLISHED_CYCLES
) -> PredictedStatistics:
    """Return the statistics implied by cycles (m, 4), `node_values` at an odd number m, in a run like the published.

    The run has `cycles` cycles with normal noise `sigma` (rad) each; see `run_law`. The variance of a quantity is that
    of its noiseless value over the law of θ0, plus the published squared error about a law of θ0 (Table III).
    """
    theta = 2.0 * np.pi * np.arange(GRID) / GRID
    # Between the nodes by the Fourier series through them.
    turn, *motions = np.fft.irfft(np.fft.rfft(values, axis=0), GRID, axis=0).T * (GRID / len(values))
    law = run_law(turn, sigma, cycles, published.start)
    mean = np.array(motions) @ law
    variance = (np.array(motions) - mean[:, np.newaxis]) ** 2 @ law + np.square(published.rmse)
    first_share = float("nan")
    if len(published.directions) > 1:
        nearness = np.cos(theta[:, np.newaxis] - np.array(published.directions))
        first_share = float(law[np.argmax(nearness, axis=1) == 0].sum())
    return PredictedStatistics(theta, law, turn, mean, np.sqrt(variance), first_share)


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
        told = [f"{name} {found} {unit} (published {given})" for name, unit, found, given in pairs]
        return f"{', '.join(told)}; {self._directions()}"

    def _numbers(self) -> list[list[str]]:
        """Mean and standard deviation of each quantity, predicted and published, degrees and mm."""
        both = ((np.array(one.mean) * _UNITS, np.array(one.std) * _UNITS) for one in (self.predicted, self.published))
        return [[f"{at:.1f} +- {by:.2f}" for at, by in zip(mean, std, strict=True)] for mean, std in both]

    def _directions(self) -> str:
        text = f"stable directions {_degrees(self.stable)}, peaks of the histogram {_degrees(self.peaks)}"
        told = f"{text} (published {_degrees(self.published.directions)})"
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


def published_comparison(material: Material | str | Path) -> PublishedComparison:
    """Compare what a material predicts for MIT's repeated pushes with what is published of it.

    material : a material, the name of one, or its file; the first part of its name tells whose numbers are meant, so
    that `plywood-measured` meets `plywood`. A surface that wears is taken as it is half way through the run.

    Raises InvalidInput where nothing is published of the material.

    >>> found = published_comparison("plywood")
    >>> np.degrees(found.stable).round().tolist()
    [63.0]
    """
    surface = material if isinstance(material, Material) else load_material(material)
    given = published_statistics(surface.name.split("-")[0])
    loop = worn_loop(CollectionLoop.mit(surface), 0.5 * PUBLISHED_CYCLES)
    found = predicted_statistics(node_values(loop), given)
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
        lines += [f"  {name:16}{predicted:>18}{published:>18}" for name, predicted, published in named]
        lines.append(f"  {one._directions()}")
    return "\n".join(lines)


def _degrees(angles: Iterable[float]) -> str:
    listed = [f"{np.degrees(angle) % 360.0:.0f}" for angle in angles]
    return ", ".join(listed) + " deg" if listed else "none"
