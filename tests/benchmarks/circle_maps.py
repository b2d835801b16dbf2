"""How long the circle maps' main questions take, each beside a plain method in the same run.

Run `python -m tests.benchmarks.circle_maps` from the repository's root, with nothing else running.
It prints medians of repeated runs, with what each method's answer is off by, and asserts nothing:
times are for people.
"""

import math
from functools import partial

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from cyclemap.maps import (
    ARNOLD_FAMILY,
    CircleMap,
    WrappedNormal,
    fixed_points,
    mean_passage_time,
    periodic_points,
    rotation_numbers,
    tongue,
    transfer_operator,
)
from tests.benchmarks.timing import Row, seconds, show, timed

TURN = 2 * math.pi
SINE, NOISE = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.05 * TURN)
ANGLES = np.linspace(0.0, TURN, 256, endpoint=False)
STABLE = float(fixed_points(SINE)[0].points[0])
ARC = (0.0, 0.25 * TURN)
RNG = np.random.default_rng(1)
OMEGA, STRENGTH = RNG.random(400_000), RNG.random(400_000)


def ulam_density(cells: int) -> np.ndarray:
    """The stationary density by Ulam's method: chances from cell centre to cell, and an
    eigenvector.
    """
    centres = (np.arange(cells) + 0.5) * TURN / cells
    edges = np.arange(cells + 1) * TURN / cells
    chances = np.zeros((cells, cells))
    for turn in range(-2, 3):
        gap = edges + TURN * turn - SINE(centres)[:, None]
        chances += np.diff(ndtr(gap / NOISE.sigma), axis=1)
    law = np.linalg.solve((np.eye(cells) - chances + 1.0 / cells).T, np.full(cells, 1.0 / cells))
    return law * cells / TURN


def density_rows() -> list[Row]:
    """The stationary density of the noisy sine map at 256 angles: exact modes,
    and Ulam's method."""

    def density() -> np.ndarray:
        return transfer_operator(SINE, NOISE).density(ANGLES)

    def bound() -> float:
        return transfer_operator(SINE, NOISE).error_bound

    cells = 1024
    off = float(np.max(np.abs(ulam_density(cells)[:: cells // 256] - density())))
    return [
        timed("density at σ = .05 turns", density, f"error bound {bound():.0e}", 21),
        timed("the same with its error bound", bound, "256 angles", 21),
        timed(f"Ulam's method, {cells} cells", lambda: ulam_density(cells), f"off by {off:.0e}", 3),
    ]


def brentq_points() -> int:
    """The fixed points of the doubling map's twelfth iterate, bracket by bracket."""
    grid = np.linspace(0.0, TURN, 40_001) - 1e-5
    turns = 4095.0 * grid / TURN
    found = 0
    for low, high, below, above in zip(grid[:-1], grid[1:], turns[:-1], turns[1:], strict=True):
        for whole in range(math.ceil(below), math.ceil(above)):
            brentq(lambda x, whole=whole: 4095.0 * x - TURN * whole, low, high)
            found += 1
    return found


def orbit_rows() -> list[Row]:
    """All 4,095 points of period 12 of the doubling map."""
    doubling = CircleMap.blaschke([0.0, 0.0])
    steep = CircleMap(lambda x: 4096.0 * x, lambda x: np.full_like(x, 4096.0), degree=4096)
    periodic, fixed = partial(periodic_points, doubling, 12), partial(fixed_points, steep)
    return [
        timed("points of period 12, doubling map", periodic, f"{periodic().count} points"),
        timed("fixed points of θ → 4096 θ", fixed, f"{len(fixed())} points"),
        timed("a plain grid and SciPy's brentq", brentq_points, f"{brentq_points()} points", 3),
    ]


def plain_rotation(omega: np.ndarray, strength: np.ndarray, iterates: int = 1_000) -> np.ndarray:
    """Rotation numbers as the mean turn over many iterates: within 1/iterates of the truth."""
    x = np.zeros_like(omega)
    for _ in range(iterates):
        x = x + omega - strength / TURN * np.sin(TURN * x)
    return x / iterates


def rotation_rows() -> list[Row]:
    """A rotation number of the sine family to 1e-3, each of many at random parameters."""
    some = slice(0, 20_000)
    rows = []
    for threads in (1, 2):
        numbers = partial(rotation_numbers, ARNOLD_FAMILY, OMEGA, STRENGTH, threads=threads)
        taken = seconds(numbers, 3) / OMEGA.size
        name = f"a rotation number to 1e-3, {threads} thread(s)"
        rows.append(Row(name, taken, f"{1 / taken:.3g} a second"))
    plain = seconds(lambda: plain_rotation(OMEGA[some], STRENGTH[some]), 3) / 20_000
    return [*rows, Row("1,000 iterates in NumPy", plain, f"{1 / plain:.3g} a second")]


def bisected_edge() -> float:
    """The left edge of 1/3 of the sine family at K = 0.9, to 1e-6 turns, by rotation numbers of
    plain iterates.
    """
    low, high = 0.32, 0.338
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        number = float(plain_rotation(np.array([middle]), np.array([0.9]), 20_000)[0])
        low, high = (middle, high) if number < 1.0 / 3.0 - 1e-4 else (low, middle)
    return high


def tongue_rows() -> list[Row]:
    """The tongue 1/3 of the sine family at K = 0.9."""
    edges = partial(tongue, partial(CircleMap.arnold, K=0.9), (1, 3), (0.3, 0.37))
    left = edges().left
    off = abs(bisected_edge() - float(left))
    return [
        timed("both edges of a tongue", edges, f"to {left.error_bound:.0e}"),
        timed("one by bisection of plain iterates", bisected_edge, f"off by {off:.0e} turns", 1),
    ]


def sampled_passage(paths: int) -> tuple[float, float]:
    """The mean passage time by following paths, and its standard error."""
    random = np.random.default_rng(2)
    theta, alive, cycles = np.full(paths, STABLE), np.arange(paths), np.zeros(paths)
    while alive.size:
        theta = np.mod(SINE(theta) + NOISE.sample(random, theta.size), TURN)
        cycles[alive] += 1
        inside = theta < ARC[1]
        theta, alive = theta[inside], alive[inside]
    return float(cycles.mean()), float(cycles.std() / math.sqrt(paths))


def passage_rows() -> list[Row]:
    """The mean passage time out of a quarter turn, and what following paths would take for the same
    error.
    """
    time = mean_passage_time(SINE, NOISE, STABLE, ARC)
    ours = seconds(lambda: mean_passage_time(SINE, NOISE, STABLE, ARC), 11)
    paths = 20_000
    mean, error = sampled_passage(paths)
    taken = seconds(lambda: sampled_passage(paths), 3)
    equal = taken * (error / time.error_bound) ** 2
    return [
        Row("mean passage time", ours, f"{time:.6f} ± {time.error_bound:.0e}"),
        Row(f"{paths} paths", taken, f"{mean:.3f} ± {error:.3f}"),
        Row("paths for equal error", equal, "from the row above: error as one over the root"),
    ]


def main() -> None:
    """Print the tables."""
    show("stationary density", density_rows())
    show("periodic points", orbit_rows())
    show("rotation numbers", rotation_rows())
    show("tongue edges", tongue_rows())
    show("passage times", passage_rows())


if __name__ == "__main__":
    main()
