"""The shipped material that was identified from the measured staircase, against that staircase."""

import math
from pathlib import Path

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.evidence import read_theta0_pairs, turn_bins
from cyclemap.evidence.data_blocks.fourier_interpolation import interpolation
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, sample_staircases
from cyclemap.mechanics import load_material

GRID = np.linspace(0.0, 2.0 * math.pi, 360, endpoint=False)
PUSHES = 2000


@pytest.fixture(scope="module")
def turns() -> np.ndarray:
    """Turns (3, 360) of a cycle on the fresh, the half worn and the worn surface, rad."""
    loop, found = CollectionLoop.mit("plywood-measured"), []
    nodes = 2.0 * math.pi * np.arange(47) / 47
    for cycles in (0, PUSHES // 2, PUSHES):
        now = worn_loop(loop, cycles)
        found.append(interpolation(GRID, 47) @ (now.next_theta(nodes) - nodes))
    return np.array(found)


def at_share(turns: np.ndarray, theta: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Turn at angles when a share of the wear has been done, blended between the three surfaces."""
    each = np.array([np.interp(np.mod(theta, 2.0 * math.pi), GRID, turn, period=2.0 * math.pi) for turn in turns])
    early = np.clip(2.0 * share, 0.0, 1.0)
    late = np.clip(2.0 * share - 1.0, 0.0, 1.0)
    return np.where(share < 0.5, each[0] + early * (each[1] - each[0]), each[1] + late * (each[2] - each[1]))


def test_it_says_that_it_was_inferred_and_from_what() -> None:
    material = load_material("plywood-measured")
    assert material.inferred and material.wear is not None and material.wear.cycles == PUSHES
    assert "measured theta0" in material.provenance and "RMS" in material.misfit


def test_its_misfit_is_what_the_file_says(measured_data: Path, turns: np.ndarray) -> None:
    """Single cycles within 1.56 degrees, medians over 5 degree bins of the late ones within 2.45."""
    pairs = read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv")
    assert pairs.cycle is not None
    residual = at_share(turns, pairs.theta, pairs.cycle / PUSHES) - pairs.turn
    assert math.degrees(np.sqrt(np.mean(residual**2))) == pytest.approx(1.56, abs=0.03)
    late = pairs.cycle >= 500
    medians = turn_bins(Theta0Pairs(pairs.theta[late], (pairs.theta + residual)[late])).median
    assert medians.size == 61
    assert math.degrees(np.sqrt(np.mean(medians**2))) == pytest.approx(2.45, abs=0.05)


def test_it_climbs_as_many_turns_as_were_measured_and_rests_where_the_histogram_peaks(turns: np.ndarray) -> None:
    """Pushes 500 to 2000: 17.5 turns were measured, with a peak at 95 to 100 degrees and steps of a full turn."""

    def map_of(row: np.ndarray) -> CircleMap:
        return CircleMap.from_samples(GRID, GRID + row)

    knots = [(500.0 * k - 500.0, map_of(at_share(turns, GRID, np.full(360, 0.25 * k)))) for k in range(5)]
    paths = sample_staircases(DriftingMap.between(knots), WrappedNormal(math.radians(1.1)), 1500, np.full(40, 1.66), 0)
    climbed = (paths[:, -1] - paths[:, 0]) / (2.0 * math.pi)
    assert climbed.mean() == pytest.approx(17.5, abs=1.5)
    histogram, edges = np.histogram(np.mod(np.degrees(paths), 360.0), bins=72, range=(0.0, 360.0))
    assert 90.0 <= edges[np.argmax(histogram)] <= 105.0


def test_nodes_of_the_mechanics_and_of_the_block_are_the_same_cycles() -> None:
    """The interpolated map of the fresh surface is the loop's own, to a twentieth of the noise."""
    loop = worn_loop(CollectionLoop.mit("plywood-measured"), 0)
    theta = np.array([0.3, 1.7, 4.0])
    nodes = 2.0 * math.pi * np.arange(47) / 47
    turn = interpolation(theta, 47) @ (loop.next_theta(nodes) - nodes)
    assert turn == pytest.approx(loop.next_theta(theta) - theta, abs=math.radians(0.06))
