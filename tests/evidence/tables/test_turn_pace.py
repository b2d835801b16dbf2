"""Full turns timed and predicted: rotations known exactly, mirror images, and turns of the map's own paths."""

import numpy as np
import pytest
from made_sets import TURN, worn_pairs

from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.fit_map import fit_map
from cyclemap.evidence.tables.measured_cycle_map import full_turns, turn_pace


def rotation(turns_a_push: float, count: int = 200):
    path = 0.3 + TURN * turns_a_push * np.arange(count + 1.0)
    return path, fit_map(path[:-1], path[1:], cycle=np.arange(float(count)), harmonics=0, wear_degree=0)


@pytest.mark.parametrize("pace", [0.05, -0.05])
def test_a_rotation_takes_its_twenty_pushes_a_turn_measured_and_predicted(pace) -> None:
    path, fitted = rotation(pace)
    found = turn_pace(fitted, path, np.arange(201.0), level=1.0, runs=3)
    assert found.measured.tolist() == [20.0] * 9
    assert found.predicted.tolist() == found.lower.tolist() == found.upper.tolist() == [20.0] * 9
    assert found.inside == 1.0
    assert np.all(np.diff(found.start) == 20.0)


def test_the_mirror_image_of_a_path_turns_at_the_same_places() -> None:
    path = worn_pairs(500).path
    places = full_turns(path, level=0.7)
    assert places.size >= 4
    assert np.array_equal(full_turns(-path, level=-0.7), places)
    assert np.array_equal(full_turns(path + 3 * TURN, level=0.7), places)


def test_a_path_that_goes_nowhere_has_no_turns() -> None:
    path, fitted = rotation(0.001, 60)
    found = turn_pace(fitted, path, np.arange(61.0), level=2.0, runs=3)
    assert found.measured.size == found.predicted.size == 0
    assert np.isnan(found.inside)


def test_jitter_about_the_mark_makes_no_turn() -> None:
    path = np.concatenate([np.linspace(0.0, 1.0, 20), 1.0 + 0.1 * np.cos(np.arange(50.0)), np.linspace(1.0, 9.0, 80)])
    assert full_turns(path, level=1.0).size == 2


@pytest.mark.slow
def test_turns_of_the_maps_own_paths_lie_in_their_ranges_as_often_as_they_should() -> None:
    """Two worn paths, of more than ten turns each: their 95 % ranges cover about 95 %."""
    pairs = worn_pairs(900)
    fitted = fit_map(pairs.theta, pairs.theta_next, cycle=pairs.cycle, harmonics=1, wear_degree=1)
    paths = fitted.paths(np.zeros(2), 900, seed=7)
    inside = [turn_pace(fitted, path, np.arange(901.0), level=0.0, runs=40, seed=k) for k, path in enumerate(paths)]
    counts = [found.measured.size for found in inside]
    assert min(counts) >= 10
    assert np.average([found.inside for found in inside], weights=counts) == pytest.approx(0.95, abs=0.04)


def test_a_map_without_numbered_cycles_is_refused() -> None:
    path, _ = rotation(0.05)
    with pytest.raises(InvalidInput, match="fitted without cycle numbers"):
        turn_pace(fit_map(path[:-1], path[1:], harmonics=0), path, np.arange(201.0), level=1.0)
