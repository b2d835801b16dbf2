"""The shipped material that was identified from every second block of the measured staircase,
against the others.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop, drifting_map, worn_loop
from cyclemap.evidence import read_theta0_pairs, turn_bins
from cyclemap.evidence.comparison.collection_null import CollectionModel
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import DriftingMap, LocalNoise, WrappedNormal, sample_staircases
from cyclemap.mechanics import load_material

pytestmark = pytest.mark.slow

PUSHES, BLOCK, RUNS = 2000, 125, 200


@pytest.fixture(scope="module")
def drifting() -> DriftingMap:
    return drifting_map(CollectionLoop.mit("plywood-measured"), PUSHES, math.radians(0.05))


@pytest.fixture(scope="module")
def pairs(measured_data: Path) -> Theta0Pairs:
    return read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv")


@pytest.fixture(scope="module")
def runs(drifting: DriftingMap, pairs: Theta0Pairs) -> np.ndarray:
    """Runs (RUNS, 2000) of the material with its own noise, from where the robot began, rad."""
    noise = load_material("plywood-measured").noise
    assert noise is not None and pairs.path is not None
    local = LocalNoise(noise.log_sigma, noise.correlation)
    starts = np.full(RUNS, pairs.path[0])
    return sample_staircases(drifting, local, len(pairs.path) - 1, starts, seed=0)


def test_it_says_that_it_was_inferred_and_from_what() -> None:
    material = load_material("plywood-measured")
    assert material.inferred and material.wear is not None and material.wear.cycles == PUSHES
    assert "every second block" in material.provenance and "left out" in material.misfit
    # Ring and contact are where they were: pressure and friction of the ring carry the misfit.
    assert CollectionLoop.mit(material).footprint is not None


def test_the_map_is_within_2_1_degrees_over_bins_of_the_blocks_left_out(pairs, drifting) -> None:
    late = (pairs.cycle >= 500) & (pairs.cycle // BLOCK % 2 == 1)
    model, theta = CollectionModel(drifting, WrappedNormal(0.02)), pairs.theta[late]
    turn = model.turns(theta, pairs.cycle[late])[0]
    medians = turn_bins(Theta0Pairs(theta, theta + turn - pairs.turn[late])).median
    assert medians.size > 40 and math.degrees(np.sqrt(np.mean(medians**2))) <= 2.1


def test_the_histogram_of_the_blocks_left_out_is_one_that_its_own_runs_make(pairs, runs) -> None:
    left_out = np.arange(runs.shape[1]) // BLOCK % 2 == 1

    def histogram(theta: np.ndarray) -> np.ndarray:
        counts, _ = np.histogram(np.mod(np.degrees(theta), 360.0), bins=36, range=(0.0, 360.0))
        return counts / theta.size

    made = np.array([histogram(run[left_out]) for run in runs])
    off = 0.5 * np.abs(histogram(pairs.path[left_out]) - made.mean(axis=0)).sum()
    own = 0.5 * np.abs(made - made.mean(axis=0)).sum(axis=1)
    assert off <= min(0.10, np.quantile(own, 0.95))


def test_turns_are_those_of_nine_in_ten_of_its_runs(pairs, runs) -> None:
    """Where a run ends, at rest, is known to 4 degrees:
    the model rests beside where the robot did."""

    def turns(path: np.ndarray, first: int) -> np.ndarray:
        last = min(first + 500, path.shape[-1] - 1)
        return (path[..., last] - path[..., first]) / (2.0 * math.pi)

    for first in (500, 1000, 1500):
        low, high = np.quantile(turns(runs, first), [0.05, 0.95])
        assert low <= turns(pairs.path, first) <= high + 4.0 / 360.0


def test_the_drift_is_the_loops_own_map_at_every_bend_of_the_course(drifting) -> None:
    theta = np.array([0.3, 1.7, 4.0])
    for cycle in (0, 250, 800, 1375, 1999):
        loop = worn_loop(CollectionLoop.mit("plywood-measured"), cycle)
        ahead = loop.next_theta(theta)
        assert drifting.at(cycle)(theta) == pytest.approx(ahead, abs=math.radians(0.06))
