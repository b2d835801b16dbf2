"""Maps that wear: blends of lifts, families on a schedule, and the staircase of slow drift."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    WrappedNormal,
    mean_passage_time,
    predict_drift,
    sample_staircase,
    sample_staircases,
    transfer_operator,
)
from cyclemap.maps.staircases import drifting_map
from tests.refusals import refused

TWO_PI = 2 * np.pi
FRESH, WORN = CircleMap.arnold(0.15, 0.9), CircleMap.arnold(0.2, 0.9)
WEAR = DriftingMap.between([(100, FRESH), (300, WORN)])


def family(p):
    return CircleMap.arnold(0.15 + 0.05 * p, 0.9)


def test_a_frozen_map_is_the_blend_of_its_neighbours_and_a_lift():
    x = np.linspace(-7.0, 9.0, 50)
    for cycle, share in ((0, 0.0), (100, 0.0), (150, 0.25), (300, 1.0), (1000, 1.0)):
        frozen = WEAR.at(cycle)
        np.testing.assert_allclose(
            frozen(x), (1 - share) * FRESH(x) + share * WORN(x), rtol=0, atol=1e-13
        )
        np.testing.assert_allclose(frozen(x + TWO_PI), frozen(x) + TWO_PI, rtol=0, atol=1e-12)
        np.testing.assert_allclose(frozen.derivative(x), 1 - 0.9 * np.cos(x), rtol=0, atol=1e-13)
        assert abs(frozen.scalar()(1.3) - frozen(1.3)) < 1e-13


def test_a_blend_keeps_the_breaks_of_both():
    one, other = (
        CircleMap(lambda x, at=at: x + 0.1 * np.mod(x - at, TWO_PI), breaks=[at])
        for at in (1.0, 0.0)
    )
    both = DriftingMap.between([(0, one), (10, other)])
    assert both.at(5).breaks.tolist() == [0.0, 1.0] and both.at(0).breaks.tolist() == [1.0]


def test_a_frozen_map_is_as_far_off_as_its_neighbours_by_their_shares():
    x, at = np.linspace(0.0, TWO_PI, 600, endpoint=False), np.linspace(-7.0, 9.0, 500)
    off = {FRESH: 1e-5, WORN: 1e-3}
    lifts = [CircleMap(lambda t, one=one: one(t) + off[one], max_error=off[one]) for one in off]
    cubics = [CircleMap.from_samples(x, one(x) + off[one], max_error=2 * off[one]) for one in off]
    for before, after in (lifts, cubics):
        frozen = DriftingMap.between([(0, before), (4, after)]).at(1)
        error = np.max(np.abs(frozen(at) - 0.75 * FRESH(at) - 0.25 * WORN(at)))
        assert 2e-4 < error <= frozen.max_error * (1 + 1e-9) < 3 * error


def test_between_maps_of_samples_a_frozen_one_is_a_map_of_samples_with_their_kinks_as_knots():
    """Passages on it ask for nodes by its samples: of a mere lift there are far too many."""
    fresh, worn = (
        CircleMap.from_samples(x, CircleMap.arnold(omega, 0.9)(x), max_error=1e-4)
        for omega, x in ((0.15, np.linspace(0.0, 6.2, 301)), (0.2, np.linspace(0.1, 6.3, 290)))
    )
    frozen = DriftingMap.between([(0, fresh), (4, worn)]).at(1)
    x = np.linspace(-7.0, 9.0, 5000)
    np.testing.assert_allclose(frozen(x), 0.75 * fresh(x) + 0.25 * worn(x), rtol=0, atol=1e-13)
    slope = 0.75 * fresh.derivative(x) + 0.25 * worn.derivative(x)
    np.testing.assert_allclose(frozen.derivative(x), slope, rtol=0, atol=1e-10)
    knots = np.union1d(fresh.pieces.knots, worn.pieces.knots)
    np.testing.assert_array_equal(frozen.pieces.knots, knots)
    noise = WrappedNormal(0.02)
    time = mean_passage_time(frozen, noise, 0.9, (0.2, 1.6))
    smooth = mean_passage_time(CircleMap.arnold(0.1625, 0.9), noise, 0.9, (0.2, 1.6))
    assert abs(time - smooth) <= time.error_bound + smooth.error_bound < 0.05 * time


def test_a_noise_free_path_goes_through_each_cycles_own_map():
    swift = DriftingMap.between([(10.5, FRESH), (11.2, WORN), (200, FRESH)])
    for worn in (swift, DriftingMap.between([(5, WORN)])):
        path = sample_staircase(worn, None, 250, start=0.3).theta
        expected = [0.3]
        for n in range(250):
            expected.append(float(worn.at(n)(expected[-1])))
        np.testing.assert_allclose(path, expected, rtol=0, atol=1e-9)


def test_chunks_of_a_long_run_meet_without_a_seam():
    count = 150_000
    worn = DriftingMap.between([(0, CircleMap.rigid(0.0)), (count, CircleMap.rigid(1e-4))])
    turns = np.diff(sample_staircase(worn, None, count).theta)
    assert np.max(np.abs(turns - TWO_PI * 1e-4 * np.arange(count) / count)) < 1e-10


def test_a_family_is_met_to_the_stated_tolerance_on_every_cycle_tried():
    x = np.linspace(0.0, TWO_PI, 97)
    for schedule in (lambda n: np.sin(n / 90.0), lambda n: np.exp(-n / 50.0)):
        worn = DriftingMap.of_family(family, schedule, 1_000, tolerance=1e-4)
        for n in range(0, 1_000, 7):
            assert np.max(np.abs(worn.at(n)(x) - family(schedule(n))(x))) < 1.3e-4
        assert worn.max_error <= 1e-4 and worn.cycles.size < 300


def test_a_schedule_that_jumps_is_followed_exactly():
    values = np.where(np.arange(500) < 237, 0.0, 1.0)
    worn = DriftingMap.of_family(family, values, 500, tolerance=1e-9)
    jump = [float((worn.at(n)(0.0) - FRESH(0.0)) / (WORN(0.0) - FRESH(0.0))) for n in range(500)]
    np.testing.assert_allclose(jump, values, rtol=0, atol=1e-9)


def rotations(*knots):
    return DriftingMap.between([(cycle, CircleMap.rigid(turns)) for cycle, turns in knots])


def summed_turns(worn, count):
    return sum(float(worn.at(n).turn(0.0)) for n in range(count)) / TWO_PI


def test_the_adiabatic_climb_of_a_drifting_rotation_is_its_sum():
    """From the integral it differs by the kinks of the schedule alone, an eighth of each."""
    worn = rotations((0, 0.1), (400, 0.2), (600, 0.0))
    found = predict_drift(worn, WrappedNormal(1.0), 700)
    assert found.turns.holds(summed_turns(worn, 700)) and found.turns.error_bound < 1e-3
    assert found.steps is None and all(one.step is None for one in found.summaries)
    assert abs(found.summaries[0].mean_turn - 0.2 * np.pi) < 1e-10


def test_the_bound_of_the_climb_holds_where_a_schedule_goes_to_and_fro():
    """Every kink lies between two cycles, where the integral differs from the sum the most."""
    worn = rotations(*((60.5 * index, 2.0 * (index % 2)) for index in range(5)))
    climb, truth = predict_drift(worn, WrappedNormal(1.0), 243).turns, summed_turns(worn, 243)
    assert 0.015 < abs(climb - truth) <= climb.error_bound < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("summed", [200, 0])
def test_the_climb_of_wear_that_goes_to_and_fro_each_cycle_is_a_sum(monkeypatch, summed):
    """Integrated it took minutes, to a bound of half its size; 0: integrals that go wrong."""
    monkeypatch.setattr(drifting_map, "_SUMMED", summed)
    worn = rotations(*((n, 0.1 + 0.4 * (n % 2)) for n in range(44)))
    climb = predict_drift(worn, WrappedNormal(1.0), 44).turns
    assert abs(climb - 0.3 * 44) <= climb.error_bound < 1e-9


def test_the_climb_of_few_cycles_is_the_sum_of_their_windings_and_of_the_bounds_of_these():
    noise, worn = WrappedNormal(0.4), DriftingMap.between([(4, FRESH), (8, WORN)])
    turns = [transfer_operator(worn.at(n), noise).rotation_number for n in range(12)]
    climb = predict_drift(worn, noise, 12, points=2).turns
    assert climb.holds(sum(turns))
    assert climb.error_bound < 1.001 * sum(turn.error_bound for turn in turns) + 1e-13


def test_what_a_blend_is_off_counts_between_its_maps():
    worn = DriftingMap([0, 10], [FRESH, WORN], max_error=0.3)
    assert [worn.at(n).max_error for n in (0, 5, 10)] == [0.0, 0.3, 0.0]
    assert worn.maps == (FRESH, WORN)


def test_what_is_no_blend_is_refused():
    for bad in (-1, np.nan, "x"):
        refused(DriftingMap, [0, 10], (FRESH, WORN), bad, told="max_error must")
    refused(DriftingMap, [0], 3, told="maps is 3")
    for knots in (None, [3], []):
        refused(DriftingMap.between, knots, told="give a list of pairs")
    refused(DriftingMap.between, [("a", FRESH)], told="cycles must hold numbers")


def test_sampled_turns_under_slow_wear_agree_with_the_adiabatic_ones():
    """The mean of many runs is the sum of the frozen maps' rotation numbers; a hundred cycles are
    left to the start, so that the runs have forgotten it.
    """
    noise, cycles = WrappedNormal(0.3), 4_000
    worn = DriftingMap.between([(0, FRESH), (cycles, WORN)])
    found = predict_drift(worn, noise, cycles)
    starts = np.linspace(0, TWO_PI, 300, endpoint=False)
    paths = sample_staircases(worn, noise, cycles, starts, seed=2)
    turns = (paths[:, -1] - paths[:, 100]) / TWO_PI
    skipped = 100 * transfer_operator(FRESH, noise).rotation_number
    error = turns.std() / np.sqrt(turns.size)
    assert abs(turns.mean() - (found.turns - skipped)) < 4 * error + found.turns.error_bound + 0.02
    assert error < 1e-3 * found.turns and found.turns > 200
    assert found.turns.error_bound < 0.01 and 0.0 < found.lag_turns < 5.0


def test_wear_that_opens_a_bottleneck_shortens_the_residence_and_hastens_the_climb():
    found = predict_drift(WEAR, WrappedNormal(0.15), 400, points=3)
    assert found.cycles.tolist() == [0.0, 199.5, 399.0]
    assert np.all(np.diff([one.mean_turn for one in found.summaries]) > 0)
    assert np.all(np.diff([one.mean_residence_cycles for one in found.summaries]) < 0)
    assert [one.step for one in found.summaries] == [TWO_PI] * 3
    assert found.steps == pytest.approx(float(found.turns))


@pytest.mark.slow
def test_a_family_that_maps_cannot_follow_says_how_far_off_they_are():
    schedule, told = np.random.default_rng(1).uniform(size=10_000), "4096 maps still leave"
    rigid, kind = CircleMap.rigid, ConvergenceError
    refused(DriftingMap.of_family, rigid, schedule, 10_000, told=told, kind=kind)
