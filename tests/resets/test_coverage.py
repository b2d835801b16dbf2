"""What pushes are worth, what is covered, and the direction to record next."""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.evidence.laws.linear_fit import fourier_columns
from cyclemap.maps import CircleMap
from cyclemap.resets.coverage import CELLS, Coverage, Crowding, next_action


def covering(theta) -> Coverage:
    coverage = Coverage()
    for angle in np.asarray(theta, dtype=float).tolist():
        coverage.add(angle)
    return coverage


def columns(theta) -> np.ndarray:
    """The columns of a Fourier series of six harmonics, of a mean square of one each."""
    return fourier_columns(theta, 6) * np.r_[1.0, np.full(12, math.sqrt(2.0))]


def test_worth_is_the_root_of_the_information_determinant() -> None:
    theta = np.random.default_rng(0).vonmises(1.0, 1.0, 60)
    information = columns(theta).T @ columns(theta)
    expected = np.linalg.det(np.eye(13) + information) ** (1 / 13) - 1
    for turns in (0.0, 4.0 * np.pi):
        assert covering(theta - turns).state().effective_pushes == pytest.approx(expected, rel=1e-9)
    assert expected < 50.0


def test_useful_repeats_are_those_that_recording_them_finds_useful() -> None:
    coverage = covering(np.random.default_rng(2).uniform(0, 2 * np.pi, 60))
    predicted = coverage.useful_repeats((1.0,), 0.02)
    around = columns(np.arange(90) * np.radians(4.0) + np.radians(0.25))
    least = 0.02 * float(coverage._information(around).max())
    found = 0
    while float(coverage._information(columns(1.0))) >= least:
        coverage.add(1.0)
        found += 1
    assert predicted == found > 10


def test_following_the_advice_halves_the_gaps_again_and_again() -> None:
    coverage = Coverage()
    for count in range(1, 33):
        coverage.add(coverage.state().least_covered)
        if count & (count - 1) == 0:
            gap = coverage.state().largest_gap
            assert gap == pytest.approx(2 * np.pi / count, abs=2 * 2 * np.pi / CELLS), count
    assert coverage.state().effective_pushes == pytest.approx(32.0, rel=0.01)
    assert coverage.state().covered > 0.8


def test_the_least_covered_direction_is_the_least_visited_one_where_all_are_visited() -> None:
    """A crowd opposite does not outweigh what is near by."""
    even = np.arange(0.0, 2 * np.pi, np.radians(2.0))
    near, far = (even[np.abs(even - 4.0) > away] for away in (0.15, 0.6))
    visited = np.r_[near, np.full(1000, 1.0), np.tile(far, 5)]
    assert covering(visited).state().least_covered == pytest.approx(4.0, abs=0.1)


def test_one_push_covers_its_reach_and_leaves_the_rest_as_a_gap() -> None:
    state, nothing = covering([1.0]).state(), Coverage().state()
    assert (nothing.covered, nothing.effective_pushes, nothing.gain) == (0.0, 0.0, 1.0)
    assert state.covered == pytest.approx(10.0 / 360.0, abs=1.0 / CELLS)
    assert state.largest_gap == nothing.largest_gap == pytest.approx(2 * np.pi)
    opposite = pytest.approx(1.0 + np.pi, abs=np.radians(0.5))
    assert state.gap_centre == state.least_covered == opposite


@pytest.mark.parametrize("start", [0.3, 2.0, 5.5])
def test_the_widest_gap_is_the_longest_arc_between_neighbours_wherever_it_lies(start) -> None:
    """Also across 0."""
    state = covering(start + np.array([0.0, 0.7, 1.2, 4.0, 4.9])).state()
    assert state.largest_gap == pytest.approx(2.8, abs=2 * 2 * np.pi / CELLS)
    assert abs(math.remainder(state.gap_centre - start - 2.6, 2 * math.pi)) < 4 * np.pi / CELLS


def test_crowding_is_the_density_of_the_recorded_directions_over_its_mean() -> None:
    """The wrapped Cauchy density of the reach; collections side by side know nothing of another."""
    theta, starts = np.radians(np.arange(0.0, 360.0, 7.0)), np.array([1.0, 3.0, 5.0])
    crowding = Crowding(3)
    assert np.all(crowding.at(theta[:, None]) == 0.0)
    crowding.add(starts)
    decay = math.exp(-math.radians(5.0))
    density = (1 - decay**2) / (1 + decay**2 - 2 * decay * np.cos(theta[:, None] - starts))
    assert crowding.at(theta[:, None]) == pytest.approx(density, rel=0.15)
    assert crowding.crowding.mean(axis=1) == pytest.approx(1.0, rel=0.01)


def test_the_next_action_is_the_one_that_lands_where_least_is_recorded() -> None:
    coverage = covering(np.r_[np.arange(0.0, 3.0, 0.1), 1.0])
    maps = [CircleMap.rigid(turns) for turns in (0.02, 0.5, 0.1)]
    chosen = next_action(maps, coverage, 1.0)
    assert (chosen.number, chosen.lands) == (1, pytest.approx(1.0 + np.pi))
    there = coverage.crowding.at(np.array([[1.0 + np.pi]]))
    assert chosen.crowding == pytest.approx(float(there[0, 0]))
    assert next_action(maps, Coverage(), 1.0).number == 0
    for bad, maps_given in ((math.nan, maps), (1.0, [])):
        refused(next_action, maps_given, coverage, bad)
