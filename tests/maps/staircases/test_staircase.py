"""Staircases: noisy paths, alike or locally kicked, and what theory says of them."""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    LocalNoise,
    WrappedNormal,
    mean_passage_time,
    predict_staircase,
    sample_staircase,
    sample_staircases,
    transfer_operator,
)
from tests.maps.known_maps import simulated

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)


def test_a_path_without_noise_is_the_orbit():
    x = np.linspace(0, TWO_PI, 300, endpoint=False)
    for circle_map in (STICKY, CircleMap.from_samples(x, STICKY(x)), CircleMap(STICKY)):
        path = sample_staircase(circle_map, None, 50, start=-20.0)
        assert (path.theta.shape, path.cycles) == ((51,), 50)
        np.testing.assert_allclose(path.theta[1:], circle_map(path.theta[:-1]), rtol=0, atol=1e-12)


def test_a_stable_point_makes_steps_of_one_turn_and_its_escape_time():
    noise = WrappedNormal(0.45)
    found = predict_staircase(STICKY, noise, transfer_operator(STICKY, noise))
    (zone,) = found.zones
    assert (zone.kind, found.step) == ("stable", TWO_PI)
    assert abs(zone.arc[1] - zone.arc[0] - TWO_PI) < 1e-9
    left = lambda x: (x < zone.arc[0]) | (x > zone.arc[1])  # noqa: E731
    lives, _ = simulated(STICKY, noise, zone.centre, left, 4000)
    assert abs(found.mean_residence_cycles - lives.mean()) < 5 * lives.std() / np.sqrt(lives.size)


def test_the_mean_turn_is_known_as_well_as_the_map_is():
    """A map that is off by up to a microradian, and one that is: with a zone and without."""
    noise, error = WrappedNormal(0.3), 1e-6
    for strength in (0.9, 0.0):
        plain = CircleMap.arnold(0.15, strength)
        claimed = CircleMap(plain, plain.derivative, max_error=error)
        other = CircleMap.arnold(0.15 + error / TWO_PI, strength)
        found, moved = (predict_staircase(one, noise).mean_turn for one in (claimed, other))
        assert 1e-7 < abs(found - moved) <= found.error_bound * (1 + 1e-6) < 10 * error


def test_a_ghost_holds_the_path_for_the_saddle_node_time_where_the_turn_is_below_half_its_mean():
    """θ' = θ + ε + a(θ - θ₀)² passes its bottleneck in about π/√(aε) cycles."""
    strength, gap = 0.6, 1e-3
    sine, noise = CircleMap.arnold((strength + gap) / TWO_PI, strength), WrappedNormal(0.02)
    found = predict_staircase(sine, noise)
    (zone,) = found.zones
    np.testing.assert_allclose(sine.turn(np.array(zone.arc)), 0.5 * (strength + gap), atol=1e-5)
    assert zone.residence_cycles == mean_passage_time(sine, noise, zone.arc[0], zone.arc)
    assert (zone.kind, found.step) == ("ghost", TWO_PI)
    assert abs(zone.centre - np.pi / 2) < 2e-3
    theory = np.pi / np.sqrt(0.5 * strength * gap)
    assert 0.4 * theory < found.mean_residence_cycles < 1.1 * theory


def visits_counted(path, zone):
    """Lengths of the runs inside a copy of the arc that reach the core, one cycle at a time."""
    lengths, first, deep = [], None, False
    for n, theta in enumerate(path):
        turns = np.floor((theta - zone.arc[0]) / TWO_PI)
        place = theta - TWO_PI * turns
        here = turns if place < zone.arc[1] else None
        if first is not None and here != first[1]:
            if deep and first[0] > 0:
                lengths.append(n - first[0])
            first, deep = None, False
        if first is None and here is not None:
            first = (n, here)
        deep |= here is not None and zone.core[0] <= place <= zone.core[1]
    return np.array(lengths)


@pytest.mark.slow
@pytest.mark.parametrize(("omega", "sigma"), [(0.15, 0.3), (0.03, 0.8)])
def test_visits_of_the_stationary_path_have_the_predicted_number_mean_and_spread(omega, sigma):
    """Two routes: integral equations on the arc, and cycles counted one by one."""
    circle_map, noise, cycles = CircleMap.arnold(omega, 0.9), WrappedNormal(sigma), 100_000
    (zone,) = predict_staircase(circle_map, noise).zones
    path = sample_staircase(circle_map, noise, cycles, seed=5).theta
    lengths = visits_counted(path.tolist(), zone)
    assert lengths.size > 400
    error = lengths.std() / np.sqrt(lengths.size)
    assert abs(lengths.mean() - zone.visit_cycles) < 4 * error
    assert zone.visit_cycles.error_bound < 1e-3 * error
    assert abs(lengths.std() / zone.visit_spread - 1) < 10 / np.sqrt(lengths.size)
    assert abs(lengths.size / cycles / zone.visits_a_cycle - 1) < 4 / np.sqrt(lengths.size)


def test_a_slow_stretch_that_the_path_hurries_through_is_no_zone():
    """Its pace is below half the mean, its time no longer than at an even pace elsewhere."""
    turn = lambda x: 0.24 - 0.045 * np.sin(x) + 0.17 * np.cos(2 * x)  # noqa: E731
    found = predict_staircase(CircleMap(lambda x: x + turn(x)), WrappedNormal(0.05))
    assert abs(found.step - TWO_PI) < 1e-12
    slow = np.abs(turn(np.linspace(0, TWO_PI, 4096, endpoint=False))) < 0.12
    assert np.sum(slow & ~np.roll(slow, 1)) == len(found.zones) + 1 == 2


def test_many_paths_are_each_a_noisy_orbit_of_its_own():
    noise, starts = WrappedNormal(0.2), np.linspace(-3.0, 9.0, 40)
    paths = sample_staircases(STICKY, noise, 3_000, starts, seed=4)
    assert paths.shape == (40, 3_001)
    assert np.array_equal(paths[:, 0], starts)
    assert np.array_equal(paths, sample_staircases(STICKY, noise, 3_000, starts, seed=4))
    assert not np.array_equal(paths, sample_staircases(STICKY, noise, 3_000, starts, seed=5))
    kicks = paths[:, 1:] - STICKY(paths[:, :-1])
    assert abs(kicks.std() / 0.2 - 1) < 5 / np.sqrt(2 * kicks.size)
    assert np.max(np.abs(np.corrcoef(kicks) - np.eye(40))) < 6 / np.sqrt(3_000)


@pytest.mark.parametrize(
    "noise", [None, WrappedNormal(0.05), LocalNoise((math.log(0.05), 0.3, 0.1), 0.5)], ids=repr
)
@pytest.mark.parametrize(
    "worn", [STICKY, DriftingMap.between([(0, STICKY), (900, CircleMap.rigid(0.3))])]
)
def test_one_of_many_is_the_single_path_to_rounding(worn, noise):
    (path,) = sample_staircases(worn, noise, 1_000, [0.5], seed=3)
    single = sample_staircase(worn, noise, 1_000, 0.5, seed=3)
    np.testing.assert_allclose(path, single.theta, rtol=0, atol=1e-8)


def test_an_attracting_jump_is_a_slow_zone():
    down = CircleMap.from_samples([0.5, 2.0, 2.0, 4.0, 5.5], [1.1, 2.4, 1.6, 3.7, 6.0])
    (zone,) = predict_staircase(down, WrappedNormal(0.3)).zones
    assert (zone.kind, zone.centre) == ("jump", 2.0)


def test_the_operator_of_another_map_or_noise_is_refused():
    noise, told = WrappedNormal(0.3), "not that of this map and noise"
    other = transfer_operator(CircleMap.arnold(0.4, 0.2), noise)
    for operator in (other, transfer_operator(STICKY, WrappedNormal(1.0)), 3):
        refused(predict_staircase, STICKY, noise, operator, told=told)
    own = transfer_operator(STICKY, noise)
    assert predict_staircase(STICKY, noise, own) == predict_staircase(STICKY, noise, own)


def test_a_rotation_has_no_steps():
    found = predict_staircase(CircleMap.rigid(0.1), WrappedNormal(0.1))
    assert (found.mean_residence_cycles, found.step, found.zones) == (None, None, ())
    assert abs(found.mean_turn - 0.2 * np.pi) < 1e-14


STILL = CircleMap.rigid(0.0)


def test_kicks_have_the_size_of_the_place_they_start_from() -> None:
    """From many starts, the spread after one cycle is σ(θ) there: four standard errors."""
    noise = LocalNoise((math.log(0.01), 0.7, -0.4, 0.2, 0.1), 0.6)
    for theta in (0.3, 2.0, 4.5):
        paths = sample_staircases(STILL, noise, 1, np.full(20000, theta), seed=1)
        first = 0.7 * math.cos(theta) - 0.4 * math.sin(theta)
        second = 0.2 * math.cos(2 * theta) + 0.1 * math.sin(2 * theta)
        expected = 0.01 * math.exp(first + second)
        assert paths[:, 1].std() == pytest.approx(expected, rel=4.0 / math.sqrt(2 * 20000))
        assert noise.sigma(theta) == pytest.approx(expected, rel=1e-12)


def test_successive_kicks_are_correlated_over_the_blocks_that_draws_come_in(monkeypatch) -> None:
    """corr(z_n, z_{n+k}) = ρ^k, also where one block of draws ends and the next begins."""
    monkeypatch.setattr("cyclemap.maps.staircases.staircase._DRAWS", 3 * 8000)
    paths = sample_staircases(STILL, LocalNoise((math.log(0.02),), 0.7), 6, np.zeros(8000), seed=2)
    kicks = np.diff(paths, axis=1)
    found = np.corrcoef(kicks.T)
    gap = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    assert found == pytest.approx(0.7**gap, abs=0.04)


def test_the_white_noise_that_stands_for_it_carries_as_far_over_many_cycles() -> None:
    """Less a constant of ρ/(1 - ρ)² cycles, here 1.8 % of the variance."""
    noise = LocalNoise((math.log(0.01),), 0.69)
    far = sample_staircases(STILL, noise, 400, np.zeros(4000), seed=3)[:, -1]
    assert far.std() == pytest.approx(noise.white(0.0) * math.sqrt(400), rel=0.05)


@pytest.mark.parametrize(("omega", "sigma"), [(0.1, 0.3), (0.15, 0.1)])
def test_whole_turns_added_to_a_map_with_a_stable_point_or_a_ghost_change_only_the_mean_turn(
    omega, sigma
):
    noise = WrappedNormal(sigma)
    plain = predict_staircase(CircleMap.arnold(omega, 0.9), noise)
    faster = predict_staircase(CircleMap.arnold(omega - 1, 0.9), noise)
    assert abs(faster.mean_turn - plain.mean_turn + TWO_PI) < 1e-10
    assert [zone.winding for zone in faster.zones] == [-1]
    assert abs(faster.mean_residence_cycles / plain.mean_residence_cycles - 1) < 1e-9
    assert abs(faster.cycles_a_step / plain.cycles_a_step - 1) < 1e-9
