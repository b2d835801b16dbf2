"""What a material predicts of the published pushes: the statistics of its noisy cycles, in a run as
long.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import finite_array, positive_number, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.figures.repeated_pushes import (
    PUBLISHED_CYCLES,
    PublishedStatistics,
    published_statistics,
)
from cyclemap.mechanics import Material, load_material

# A run that starts in a named direction starts within this standard deviation of it (rad): it is
# read off a histogram.
START_SPREAD = float(np.deg2rad(10.0))
# Standard deviations of noise beyond which it counts as zero.
_REACH = 7.0
# Every so many cycles it is seen whether the law has settled: whether no share changes any more by
# the second number.
_CHECKED, _STILL = 50, 1e-14
NODES = 47
# Scatter of measured plywood cycles about a smooth map (rad); on the other materials it is not
# known.
CYCLE_NOISE = float(np.deg2rad(1.1))
GRID = 480
# A histogram of θ0 has a peak where it exceeds the even one by this factor.
PEAK = 1.5
# A direction that is read off a histogram is not known better (rad).
DIRECTION_TOLERANCE = float(np.deg2rad(15.0))
_UNITS = np.array([180.0 / np.pi, 1e3, 1e3])


def run_law(turn: Array, sigma: float, cycles: int, start: float | None = None) -> Array:
    """Return the mean share (n,) of a run's cycles that begin at each angle 2 pi k / n.

    turn (n,) : rad, of a noiseless cycle from each of the angles.
    sigma : rad, standard deviation of a cycle's noise (normal), at least 1.2 spacings of the
        angles.
    cycles : in the run.
    start : rad; None where it is not known, and taken as equally likely anywhere.

    The law of the k-th cycle is L^k applied to that of the first, L the transfer operator of the
    noisy map; the mean over k < cycles is returned. Where the map mixes within far fewer cycles it
    is the stationary law. Where noise hardly ever frees an orbit from a stable direction, the
    stationary law hangs on how often that happens in millions of cycles; this one only on what
    happens in a run. Accurate to the trapezoidal rule: to 1e-4 or better where the noise, seen
    through the map's slope, spans a spacing.

    >>> run_law(np.full(4, 0.3), 2.0, 50).round(12).tolist()
    [0.25, 0.25, 0.25, 0.25]
    """
    from scipy.sparse import csr_array

    turns, cycles = finite_array("turn", turn, ndim=1), whole_number("cycles", cycles, least=1)
    count, spacing = turns.size, 2.0 * np.pi / turns.size
    if positive_number("sigma", sigma) < 1.2 * spacing:
        raise InvalidInput(
            f"noise of {sigma:.3g} rad is finer than 1.2 spacings of {count} angles: take more "
            "angles"
        )
    # Column k of the transfer operator is the law of what comes after angle k.
    half = min(int(np.ceil(_REACH * sigma / spacing)) + 1, count // 2)
    place = np.arange(count) + turns / spacing
    nearest = np.rint(place).astype(np.int64)
    offsets = np.arange(-half, half + count % 2 if half == count // 2 else half + 1)
    off = (nearest - place)[:, np.newaxis] + offsets
    weight = np.exp(-0.5 * (off * spacing / sigma) ** 2)
    weight /= weight.sum(axis=1, keepdims=True)
    rows = (nearest[:, np.newaxis] + offsets) % count
    columns = np.broadcast_to(np.arange(count)[:, np.newaxis], rows.shape)
    matrix: Any = csr_array((weight.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))
    step, total = np.full(count, 1.0 / count), np.zeros(count)
    if start is not None:
        off = 2.0 * np.pi * np.arange(count) / count - start
        step = np.exp(-0.5 * (shorter_way(off) / START_SPREAD) ** 2)
        step /= step.sum()
    for done in range(1, cycles + 1):
        total += step
        ahead = matrix @ step
        if done % _CHECKED == 0 and np.max(np.abs(ahead - step)) < _STILL:
            total += (cycles - done) * ahead
            break
        step = ahead
    return np.asarray(total / total.sum())


def node_values(loop: CollectionLoop, count: int = NODES) -> Array:
    """Run cycles of a loop at orientations 2 pi k / count: their turn, then turn and displacement
    of the push.

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

    theta (n,) : rad.
    law (n,) : share of the run's cycles that begin at each.
    turn (n,) : rad, of the noiseless cycle.
    mean, std (3,) : of dtheta (rad), dx, dy (m), the spread about the published fitted law
        included.
    first_share : of the cycles nearer to the first published direction than to any other; nan with
        fewer than two.
    """

    theta: Array
    law: Array
    turn: Array
    mean: Array
    std: Array
    first_share: float


def predicted_statistics(
    values: Array,
    published: PublishedStatistics,
    sigma: float = CYCLE_NOISE,
    cycles: int = PUBLISHED_CYCLES,
) -> PredictedStatistics:
    """Return the statistics implied by cycles (m, 4), `node_values` at an odd number m, in a run
    like the published.

    The run has `cycles` cycles with normal noise `sigma` (rad) each; see `run_law`. The variance of
    a quantity is that of its noiseless value over the law of θ0, plus the published squared error
    about a law of θ0 (Table III).
    """
    theta = 2.0 * np.pi * np.arange(GRID) / GRID
    # Between the nodes by the Fourier series through them.
    series = np.fft.irfft(np.fft.rfft(values, axis=0), GRID, axis=0).T
    turn, *motions = series * (GRID / len(values))
    # A share of the first direction is told of a run that starts there.
    start = None if published.first_share is None else published.directions[0]
    law = run_law(turn, sigma, cycles, start)
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
    peaks : rad, where the predicted histogram of θ0 exceeds 1.5 times the even one and its
        neighbours, highest first.
    """

    material: str
    published: PublishedStatistics
    predicted: PredictedStatistics
    stable: Array
    peaks: Array

    @property
    def misses(self) -> Array:
        """How far (rad) each published direction lies from the nearest peak; inf where there is
        none. (d,)
        """
        off = np.abs(shorter_way(np.array(self.published.directions)[:, np.newaxis] - self.peaks))
        return np.asarray(np.min(off, axis=1, initial=np.inf))

    @property
    def sentence(self) -> str:
        """Means, spreads and directions, predicted and published, in words."""
        numbers = []
        for row in (self.predicted, self.published):
            columns = zip(row.mean * _UNITS, row.std * _UNITS, strict=True)
            numbers.append([f"{mean:.1f} +- {std:.2f}" for mean, std in columns])
        pairs = zip(("turn", "dx", "dy"), ("deg", "mm", "mm"), *numbers, strict=True)
        words = [f"{name} {found} {unit} (published {given})" for name, unit, found, given in pairs]
        told = f"{', '.join(words)}; stable directions {_degrees(self.stable)}, peaks of the "
        told += f"histogram {_degrees(self.peaks)}"
        told += f" (published {_degrees(self.published.directions)})"
        missed = np.array(self.published.directions)[self.misses > DIRECTION_TOLERANCE]
        if missed.size:
            told += f"; no peak within 15 deg of {_degrees(missed)}"
        if self.published.first_share is not None:
            shares = self.predicted.first_share, self.published.first_share
            found, given = (f"{100 * share:.1f} %" for share in shares)
            told += f"; share of the first direction {found} (published {given})"
        if self.published.always_advancing:
            least = np.degrees(self.predicted.turn.min())
            told += f"; the least turn of a cycle {least:.2f} deg (published: always positive)"
        return told


def published_comparison(material: Material | str | Path) -> PublishedComparison:
    """Compare what a material predicts for MIT's repeated pushes with what is published of it.

    material : a material, the name of one, or its file; the first part of its name tells whose
        numbers are meant, so that `plywood-measured` meets `plywood`. A surface that wears is taken
        as it is half way through the run.

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
    share = found.turn[falls] / (found.turn[falls] - ahead[falls])
    places = found.theta[falls] + found.theta[1] * share
    stable = places[np.argsort(-law[falls])] % (2.0 * np.pi)
    is_top = (law >= np.roll(law, 1)) & (law > np.roll(law, -1)) & (law * law.size > PEAK)
    tops = np.flatnonzero(is_top)
    peaks = found.theta[tops[np.argsort(-law[tops])]]
    return PublishedComparison(surface.name, given, found, stable, peaks)


def _degrees(angles: Iterable[float]) -> str:
    listed = [f"{np.degrees(angle) % 360.0:.0f}" for angle in angles]
    return ", ".join(listed) + " deg" if listed else "none"
