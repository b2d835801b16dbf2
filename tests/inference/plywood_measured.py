"""Infer plywood, its wear and its noise from every second block of the measured staircase.

`python -m tests.inference.plywood_measured` takes some minutes and prints a material file: friction
fresh and worn, the course of the wear, the pressure of the plate, rod and ring, and the noise of a
cycle. `tests/evidence/identified` judges the shipped one on the other blocks.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from scipy.optimize import least_squares

from cyclemap.collection import Anisotropy, CollectionLoop
from cyclemap.evidence import read_theta0_pairs
from cyclemap.evidence.identification.stroke_block import interpolation
from cyclemap.mechanics import (
    CycleNoise,
    EllipseFriction,
    FoundWith,
    Material,
    PlatePressure,
    Wear,
    load_material,
    material_toml,
    worn_friction,
)
from cyclemap.mechanics.cycle_batch import run_batch
from tests.inference.measured_floors import CYCLES as CYCLES_FILE, folder

BLOCK, CYCLES, NODES = 125, 2000.0, 61
KNOTS = np.array([0.0, 125.0, 250.0, 375.0, 500.0, 750.0, 1000.0, 1250.0, 1500.0, 1750.0, CYCLES])
# Unknowns: anisotropy fresh (4) and worn (4), logarithms of inner, rim and corner share over the
# even one (3), rod, ring (mm), and logarithms of the parts of the wear between the knots.
MECHANICS, ALL = 13, 13 + KNOTS.size - 1
STEPS = np.array([2e-4] * 12 + [1e-2] * (KNOTS.size))
# Blocks of pushes in which means over 2 degrees of the bottleneck are fitted, and edges of the bins
# of the noise.
STRETCHES = ((0, 125), (250, 375), (500, 625), (750, 875), (1000, 1250), (1250, 1500), (1500, 2000))
NOISE_BINS = np.radians([0, 40, 70, 85, 95, 105, 120, 140, 170, 220, 250, 270, 290, 315, 360])
DEG = math.radians(1.0)


def huber(value: np.ndarray, bend: float = 1.0) -> np.ndarray:
    """Residuals whose squares grow like their size beyond `bend`."""
    return np.sign(value) * bend * np.sqrt(2.0 * (np.sqrt(1.0 + (value / bend) ** 2) - 1.0))


@dataclass
class Staircase:
    """The measured cycles: θ0, turn (rad) and number of each, and which of them the fit may see."""

    theta: np.ndarray
    turn: np.ndarray
    cycle: np.ndarray

    @cached_property
    def seen(self) -> np.ndarray:
        return self.cycle // BLOCK % 2 == 0

    def rows(self, first: float, last: float, low_deg: float, high_deg: float) -> np.ndarray:
        """Seen cycles of a stretch of pushes from an arc."""
        inside = (self.theta >= math.radians(low_deg)) & (self.theta < math.radians(high_deg))
        return np.flatnonzero(self.seen & inside & (self.cycle >= first) & (self.cycle < last))

    @cached_property
    def bins(self) -> list[np.ndarray]:
        """Cycles of each 5 degrees of the pushes from 500 on."""
        every = [self.rows(500, CYCLES, low, low + 5.0) for low in range(0, 360, 5)]
        return [rows for rows in every if rows.size]

    @cached_property
    def bottleneck(self) -> list[np.ndarray]:
        """Cycles of each stretch in each 2 degrees of the bottleneck."""
        arcs = product(STRETCHES, np.arange(80.0, 112.0, 2.0))
        every = [self.rows(*stretch, low, low + 2.0) for stretch, low in arcs]
        return [rows for rows in every if rows.size >= 3]

    @cached_property
    def weights(self) -> np.ndarray:
        return interpolation(self.theta, NODES)


def shares(unknown: np.ndarray) -> np.ndarray:
    powers = np.exp(np.clip(unknown, -8.0, 8.0))
    return np.asarray(powers / (1.0 + powers.sum()))


def course(unknown: np.ndarray) -> np.ndarray:
    parts = np.exp(unknown - unknown.max())
    return np.concatenate([[0.0], np.cumsum(parts / parts.sum())])


def friction(unknown: np.ndarray) -> EllipseFriction:
    return Anisotropy.of_components(unknown).friction(0.25)


def material(unknown: np.ndarray) -> Material:
    """The material of the unknowns, but for its noise."""
    gone = course(unknown[MECHANICS:])
    bends = zip(KNOTS[1:-1].tolist(), np.round(gone[1:-1], 3).tolist(), strict=True)
    return Material(
        "plywood-measured",
        friction(unknown[:4]),
        inferred=True,
        found_with=FoundWith(float(unknown[11]), 1e-3 * abs(float(unknown[12]))),
        wear=Wear(friction(unknown[4:8]), CYCLES, tuple(bends)),
        plates=(PlatePressure("rect1", *map(float, shares(unknown[8:11]))),),
    )


def node_turns(every: list[np.ndarray]) -> np.ndarray:
    """Turns (k, 3, NODES) of a cycle on the fresh, the half and the wholly worn surface of k sets,
    in one run.
    """
    loops = []
    for unknown in every:
        loop = replace(CollectionLoop.mit(material(unknown)), accuracy=1e-6)
        surface = loop.material
        for share in (0.0, 0.5, 1.0):
            law = worn_friction(surface.friction, surface.wear.friction, share)
            loops.append(replace(loop, material=replace(surface, friction=law, wear=None)))
    theta = 2.0 * math.pi * np.arange(NODES) / NODES
    batch = run_batch(loops, np.tile(theta, (len(loops), 1)))
    return np.asarray((batch.theta_next - theta).reshape(len(every), 3, NODES))


def misses(data: Staircase, unknown: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Predicted less measured turn of each cycle, rad."""
    gone = np.interp(data.cycle, KNOTS, course(unknown[MECHANICS:]))
    fresh, half, worn = turns @ data.weights.T
    # The map is no straight line of the share: a parabola through the three.
    bent = 2.0 * gone * (1.0 - gone) * (2.0 * half - fresh - worn)
    return np.asarray(fresh + gone * (worn - fresh) + bent - data.turn)


def residuals(data: Staircase, unknown: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """What the fit makes small.

    A turn that is off by a share makes the histogram off by that share, so that errors count
    relative to the turn: of medians over 5 degrees everywhere; of means, which set the pace, over 2
    degrees and over the narrowest part of the bottleneck; of single cycles there. Weak priors:
    shares, rod, little wear, and an even pace.
    """
    off = misses(data, unknown, turns)
    bins, fine = [], []
    for rows in data.bins:
        usual = 0.1 * abs(np.median(data.turn[rows])) + 0.2 * DEG
        bins.append(np.median(off[rows]) / min(1.5 * DEG, usual))
    for rows in data.bottleneck:
        usual = 0.04 * DEG + 0.12 * abs(np.median(data.turn[rows]))
        fine.append(np.mean(off[rows]) / (usual + 0.25 * DEG / math.sqrt(rows.size / 2.0)))
    paces = [off[data.rows(n, n + 250, 88.0, 102.0)] for n in range(0, 2000, 250)]
    narrow = np.array([np.mean(rows) for rows in paces]) / (0.06 * DEG)
    single = huber(off[data.rows(0, CYCLES, 70.0, 130.0)] / (0.25 * DEG)) / math.sqrt(24.0)
    prior = [
        *(unknown[8:11] + 1.0) / 3.0,
        (unknown[11] - 0.15) / 0.02,
        *(unknown[4:8] - unknown[:4]) / 0.03,
        *np.diff(unknown[MECHANICS:]) / 2.0,
    ]
    medians = huber(np.array(bins), 2.0), huber(np.array(fine), 2.0)
    return np.concatenate([*medians, 0.7 * narrow, single, prior])


def fitted(data: Staircase, unknown: np.ndarray, most: int = 30) -> np.ndarray:
    """Least squares by differences; all sets of unknowns that a derivative takes are
    run at once."""

    def missed(one: np.ndarray) -> np.ndarray:
        return residuals(data, one, node_turns([one])[0])

    def slopes(one: np.ndarray) -> np.ndarray:
        tried = [one + step for step in np.diag(STEPS)]
        here, *moved = node_turns([one, *tried[:MECHANICS]])
        moved += [here] * (ALL - MECHANICS)
        now = residuals(data, one, here)
        after = [residuals(data, at, run) for at, run in zip(tried, moved, strict=True)]
        return (np.array(after) - now).T / STEPS

    options = {"method": "lm", "max_nfev": most, "ftol": 1e-4, "x_scale": "jac"}
    return least_squares(missed, unknown, slopes, **options).x


def noise(data: Staircase, off: np.ndarray) -> CycleNoise:
    """Robust scatter over θ0 about the smooth part of the misfit, and its correlation in the
    bottleneck.

    Jumps of single cycles, up to 20 degrees, are not noise that a normal law can carry: medians
    leave them out.
    """
    angles = np.multiply.outer(data.theta, np.arange(1, 9))
    smooth = np.concatenate([np.ones((data.theta.size, 1)), np.cos(angles), np.sin(angles)], axis=1)
    scale, law = np.maximum(0.3 * DEG, 0.05 * data.turn), np.zeros(smooth.shape[1])
    for _ in range(15):
        robust = data.seen / scale**2 / np.sqrt(1.0 + ((off - smooth @ law) / scale) ** 2)
        square = smooth.T @ (smooth * robust[:, None]) + 100.0 * np.eye(law.size)
        law = np.linalg.solve(square, smooth.T @ (robust * off))
    rest = off - smooth @ law
    bins = [data.rows(0, CYCLES, *np.degrees(ends)) for ends in pairwise(NOISE_BINS.tolist())]
    place = np.array([np.median(data.theta[rows]) for rows in bins])
    away = [np.abs(rest[rows] - np.median(rest[rows])) for rows in bins]
    sizes = np.array([1.4826 * np.median(off) for off in away])

    def columns(theta: np.ndarray) -> np.ndarray:
        waves = [wave(k * theta) for k in (1, 2, 3) for wave in (np.cos, np.sin)]
        return np.stack([np.ones_like(theta), *waves], axis=-1)

    count = np.minimum([rows.size for rows in bins], 100)
    square = columns(place).T @ (columns(place) * count[:, None]) + np.diag([0.0] + [3.0] * 6)
    found = np.linalg.solve(square, columns(place).T @ (count * np.log(sizes)))
    unit = np.clip(rest / np.exp(columns(data.theta) @ found), -3.0, 3.0)
    near = data.seen & (data.theta > math.radians(80.0)) & (data.theta < math.radians(110.0))
    pairs = np.flatnonzero(near[:-1] & near[1:] & (np.diff(data.cycle) == 1))
    correlation = float(np.corrcoef(unit[pairs], unit[pairs + 1])[0, 1])
    return CycleNoise(tuple(np.round(found, 3).tolist()), round(correlation, 2))


def main() -> None:
    pairs = read_theta0_pairs(folder() / CYCLES_FILE)
    assert pairs.cycle is not None
    data = Staircase(np.mod(pairs.theta, 2.0 * math.pi), pairs.turn, pairs.cycle)
    shipped = load_material("plywood-measured")
    assert shipped.wear is not None
    laws = shipped.friction, shipped.wear.friction
    begins = [Anisotropy.of(law).seen_from(0.0) for law in laws]
    (plate,), rod = shipped.plates, shipped.found_with
    own = np.array(list(plate.shares.values()))
    pressure = np.log(np.maximum(own, 1e-3) / (1.0 - own.sum()))
    ring = 1e3 * (rod.pin_friction_radius or 0.0)
    parts = np.diff([shipped.wear.share(n) for n in KNOTS])
    start = np.concatenate([*begins, pressure, [rod.pusher_friction, ring], np.log(parts + 1e-3)])
    found = fitted(data, start)
    made = material(found)
    made = replace(made, noise=noise(data, -misses(data, found, node_turns([found])[0])))
    print(material_toml(made))


if __name__ == "__main__":
    main()
