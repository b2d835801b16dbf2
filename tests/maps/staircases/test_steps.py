"""Steps found in a path, exact or none, what symmetry asks of them, and beside predicted ones."""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    SlowZone,
    StaircaseSummary,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_staircase,
    sample_staircase,
    sample_staircases,
)
from cyclemap.maps.staircases.steps import kaplan_meier_mean

TWO_PI = 2 * np.pi
GHOST, GHOST_NOISE = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
WELL, WELL_NOISE = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.45)


def same_dwells(found, other, heights=1.0):
    assert found.start.size > 3
    assert np.array_equal(found.start, other.start)
    assert np.array_equal(found.end, other.end)
    np.testing.assert_allclose(other.heights, heights * found.heights, rtol=0, atol=1e-9)


def test_a_staircase_without_noise_is_found_exactly():
    rng = np.random.default_rng(1)
    for height in (0.2, TWO_PI):
        lengths = rng.integers(10, 200, 60)
        levels = height * np.cumsum(rng.choice([-1, 1, 1, 1, 2], 60))
        found = find_steps(np.repeat(levels, lengths))
        assert np.array_equal(found.lengths, lengths)
        np.testing.assert_allclose(found.levels, levels, rtol=0, atol=1e-12)
        assert found.count == 59 and np.max(found.scatter) < 1e-12
        assert np.flatnonzero(found.censored).tolist() == [0, 59]


def test_rotations_drifts_with_and_without_noise_and_random_walks_have_no_dwells():
    n, rng = np.arange(1_500.0), np.random.default_rng(3)
    for path in (0.01 * n, -0.3 * n, 8e-4 * n, TWO_PI * 0.13 * n, 0.02 * n + 1e-6 * n**2):
        assert find_steps(path).start.size == 0
    for speed in (0.01, 0.05, 0.2):
        for sigma in (0.02, 0.1, 0.3):
            assert find_steps(speed * n + rng.normal(0, sigma, n.size)).count == 0
            assert find_steps(np.cumsum(rng.normal(speed, sigma, n.size))).count == 0


def test_a_path_that_never_leaves_its_level_is_one_dwell_open_at_both_ends():
    rng = np.random.default_rng(4)
    for path in (np.full(50, 3.0), rng.normal(0, 0.1, 800)):
        found = find_steps(path)
        assert (found.start.tolist(), found.end.tolist()) == ([0], [path.size - 1])
        assert (found.count, found.heights.size, found.censored.tolist()) == (0, 0, [True])


def moved(zones, sign, shift):
    """The zones on the mirrored or turned circle."""
    found = []
    for zone in zones:
        arc = tuple(sorted(sign * end + shift for end in zone.arc))
        found.append(SlowZone(sign * zone.centre + shift, arc, zone.kind, 1.0))
    return found


@pytest.mark.parametrize(
    ("circle_map", "noise", "zoned"),
    [(GHOST, GHOST_NOISE, False), (WELL, WELL_NOISE, False), (WELL, WELL_NOISE, True)],
)
def test_a_constant_a_mirror_and_reading_backwards_only_move_the_dwells(circle_map, noise, zoned):
    zones = predict_staircase(circle_map, noise).zones if zoned else None
    turned, mirrored = (moved(zones, 1, 1.2345), moved(zones, -1, 0.0)) if zoned else (None, None)
    path = sample_staircase(circle_map, noise, 20_000 if zoned else 6_000, seed=3).theta
    found = find_steps(path, zones=zones)
    same_dwells(found, find_steps(path + 1.2345, zones=turned))
    same_dwells(found, find_steps(-path, zones=mirrored), -1.0)
    back, last = find_steps(path[::-1], zones=zones), path.size - 1
    assert np.array_equal(back.start, (last - found.end)[::-1])
    assert np.array_equal(back.visit_start, (last - found.visit_end)[::-1])
    if not zoned:
        assert np.array_equal(back.end, (last - found.start)[::-1])
        np.testing.assert_allclose(back.levels, found.levels[::-1], rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "noise", "cycles", "off"),
    [(GHOST, GHOST_NOISE, 20_000, 1e-3), (WELL, WELL_NOISE, 100_000, 0.02)],
)
def test_steps_of_ghosts_and_wells_are_whole_turns_as_many_as_predicted(
    circle_map, noise, cycles, off
):
    summary = predict_staircase(circle_map, noise)
    path = sample_staircase(circle_map, noise, cycles, seed=6).theta
    for found in (find_steps(path), find_steps(path, zones=summary.zones)):
        turns = found.heights / TWO_PI
        error = found.scatter.mean() / found.count
        assert abs(np.median(turns) - 1) < 5 * error + off
        assert abs(turns.sum() - cycles / summary.cycles_a_step) < 5 * np.sqrt(found.count)
    assert np.all(np.round(turns) != 0) and abs(np.mean(turns / np.round(turns)) - 1) < 0.01
    assert found.visit_start.size >= found.start.size


def test_jitter_at_the_edge_of_an_arc_makes_no_visit_and_a_return_no_step():
    zone = SlowZone(1.0, (0.0, 2.0), "stable", 10.0)
    first = [-0.1, 0.1, -0.1, 0.1, 1.0, 1.0, 2.1, 1.9, 2.1, 1.9, 1.2, 2.2]
    path = np.array([*first, 4.0, TWO_PI + 1.0, 6.0, TWO_PI + 0.1])
    found = find_steps(path, zones=[zone])
    visits = np.transpose([found.visit_start, found.visit_end, found.visit_dwell]).tolist()
    assert visits == [[3, 5, 0], [9, 10, 0], [13, 13, 1]]
    assert (found.start.tolist(), found.end.tolist()) == ([3, 13], [10, 13])
    assert found.levels[0] == pytest.approx(np.mean([0.1, 1.0, 1.0, 1.9, 1.2]))
    assert found.count == 1
    outside = find_steps(np.full(30, 3.0), zones=[zone])
    assert outside.count == outside.start.size == outside.levels.size == outside.censored.size == 0


RUNS = 100


def comparisons(circle_map, noise, cycles):
    """Seeded runs from the stationary law, each compared with the prediction."""
    summary = predict_staircase(circle_map, noise)
    starts = np.linspace(0, TWO_PI, RUNS, endpoint=False)
    settled = sample_staircases(circle_map, noise, 400, starts, seed=8)[:, -1]
    paths = sample_staircases(circle_map, noise, cycles, settled, seed=9)
    steps = [find_steps(path, zones=summary.zones) for path in paths]
    return summary, [compare_steps(found, summary) for found in steps]


@pytest.fixture(scope="module")
def ghost():
    return comparisons(GHOST, GHOST_NOISE, 600)


@pytest.fixture(scope="module")
def well():
    return comparisons(WELL, WELL_NOISE, 3_000)


@pytest.mark.slow
def test_measured_means_over_many_runs_are_the_predicted_ones(ghost, well):
    """Weighted by exits the maximum-likelihood means are unbiased to an exit's worth a run."""
    for summary, found in (ghost, well):
        zone = summary.zones[0]
        means = np.array([one.visits[0].mean for one in found])
        errors = np.array([one.visits[0].standard_error for one in found])
        exits = np.array([one.visits[0].exits for one in found])
        pooled = np.sum(means * exits) / np.sum(exits)
        assert abs(pooled - zone.visit_cycles) < 4 * zone.visit_spread / np.sqrt(exits.sum())
        assert 0.8 < np.median(errors) / np.median(zone.visit_spread / np.sqrt(exits)) < 1.2
        net = np.array([one.net_steps for one in found])
        assert abs(net.mean() - found[0].expected_steps) < 4 * net.std() / np.sqrt(RUNS)
        assert 0.7 < np.median([one.net_error for one in found]) / net.std() < 1.3


@pytest.mark.slow
def test_the_climb_of_regular_steps_is_as_unsure_as_the_places_of_its_ends_on_them():
    """Five steps of fifty cycles each, as predicted."""
    regular, scatter = TWO_PI * np.floor(np.arange(251) / 50.0), 0.3
    expected = StaircaseSummary(TWO_PI / 50.0, 50.0, TWO_PI, ())
    paths = regular + scatter * np.random.default_rng(0).standard_normal((RUNS, 251))
    found = [compare_steps(find_steps(path), expected) for path in paths]
    net, error = np.transpose([(one.net_steps, one.net_error) for one in found])
    assert abs(net.mean() - 5.0) < 4 * net.std() / np.sqrt(RUNS)
    assert net.std() == pytest.approx(np.sqrt(2.0) * scatter / TWO_PI, rel=0.2)
    assert 0.9 < np.median(error) / net.std() < 1.3


@pytest.mark.slow
def test_a_ghosts_spread_is_the_predicted_one_and_far_from_exponential(ghost):
    zone = ghost[0].zones[0]
    spreads = np.array([one.visits[0].spread for one in ghost[1]])
    assert abs(spreads.mean() / zone.visit_spread - 1) < 0.05
    assert zone.visit_spread < 0.3 * zone.visit_cycles


def test_a_wrong_prediction_is_told_by_its_p_values():
    path = sample_staircase(GHOST, GHOST_NOISE, 3_000, seed=1).theta
    summary = predict_staircase(GHOST, GHOST_NOISE)
    zones = (replace(summary.zones[0], visit_cycles=16.0),)
    wrong = replace(summary, mean_turn=1.1 * summary.mean_turn, zones=zones)
    found = compare_steps(find_steps(path, zones=zones), wrong)
    assert found.visits[0].mean_p_value < 1e-4 and found.pace_p_value < 1e-4


def test_the_kaplan_meier_mean_of_the_textbook_remission_times():
    """6-MP arm of Freireich et al. (1963), with the published survival after each drop."""
    weeks = np.array([6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35])
    ended = [1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0]
    mean, error = kaplan_meier_mean(weeks, np.logical_not(ended))
    heights = [1.0, 0.857143, 0.806723, 0.752941, 0.690196, 0.627451, 0.537815, 0.448179]
    assert abs(mean - np.dot(heights, np.diff([0, 6, 7, 10, 13, 16, 22, 23, 35]))) < 1e-4
    assert abs(error - 2.828) < 0.01


def test_what_cannot_be_compared_is_none():
    summary = predict_staircase(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.4))
    resting = np.full(100, summary.zones[0].centre)
    still = compare_steps(find_steps(resting), summary)
    assert (still.steps, still.mean_length, still.net_error, still.pace_p_value) == (0, *[None] * 3)
    assert still.visits == ()
    (visit,) = compare_steps(find_steps(resting, zones=summary.zones), summary).visits
    assert (visit.exits, visit.mean) == (0, None)
    assert visit.mean_p_value == pytest.approx(np.exp(-100 / visit.predicted), rel=0.1)
    turning = predict_staircase(CircleMap.rigid(0.1), WrappedNormal(0.1))
    none = compare_steps(find_steps(0.2 * np.pi * np.arange(50)), turning)
    assert (none.predicted_length, none.net_steps, none.expected_steps) == (None,) * 3
    assert kaplan_meier_mean(np.array([3.0]), np.array([True])) == (None, None)
    assert kaplan_meier_mean(np.zeros(0), np.zeros(0, dtype=bool)) == (None, None)
