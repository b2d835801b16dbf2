"""Steps found in a path: exact where the steps are known, none where there are none, and what
symmetry asks.
"""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    SlowZone,
    WrappedNormal,
    find_steps,
    predict_staircase,
    sample_staircase,
)

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
    for height in (0.2, 1.0, TWO_PI):
        lengths = rng.integers(10, 200, 60)
        levels = height * np.cumsum(rng.choice([-1, 1, 1, 1, 2], 60))
        found = find_steps(np.repeat(levels, lengths))
        assert np.array_equal(found.lengths, lengths)
        np.testing.assert_allclose(found.levels, levels, rtol=0, atol=1e-12)
        assert found.count == 59
        assert np.max(found.scatter) < 1e-12
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
        assert found.count == 0
        assert found.heights.size == 0
        assert found.censored.tolist() == [True]


def moved(zones, sign, shift):
    """The zones, or none, on the mirrored or turned circle."""
    return zones and [
        SlowZone(
            sign * z.centre + shift, tuple(sorted(sign * end + shift for end in z.arc)), z.kind, 1.0
        )
        for z in zones
    ]


@pytest.mark.parametrize(
    ("circle_map", "noise", "zoned"),
    [(GHOST, GHOST_NOISE, False), (WELL, WELL_NOISE, False), (WELL, WELL_NOISE, True)],
)
def test_a_constant_a_mirror_and_reading_backwards_only_move_the_dwells(circle_map, noise, zoned):
    zones = predict_staircase(circle_map, noise).zones if zoned else None
    path = sample_staircase(circle_map, noise, 20_000 if zoned else 6_000, seed=3).theta
    found = find_steps(path, zones=zones)
    same_dwells(found, find_steps(path + 1.2345, zones=moved(zones, 1, 1.2345)))
    same_dwells(found, find_steps(-path, zones=moved(zones, -1, 0.0)), -1.0)
    back, last = find_steps(path[::-1], zones=zones), path.size - 1
    assert np.array_equal(back.start, (last - found.end)[::-1])
    assert np.array_equal(back.visit_start, (last - found.visit_end)[::-1])
    if not zoned:
        assert np.array_equal(back.end, (last - found.start)[::-1])
        np.testing.assert_allclose(back.levels, found.levels[::-1], rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "noise", "cycles", "off"),
    [(GHOST, GHOST_NOISE, 40_000, 1e-3), (WELL, WELL_NOISE, 100_000, 0.02)],
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
    path = np.array(
        [
            -0.1,
            0.1,
            -0.1,
            0.1,
            1.0,
            1.0,
            2.1,
            1.9,
            2.1,
            1.9,
            1.2,
            2.2,
            4.0,
            TWO_PI + 1.0,
            6.0,
            TWO_PI + 0.1,
        ]
    )
    found = find_steps(path, zones=[zone])
    assert found.visit_start.tolist() == [3, 9, 13]
    assert found.visit_end.tolist() == [5, 10, 13]
    assert found.visit_dwell.tolist() == [0, 0, 1]
    assert (found.start.tolist(), found.end.tolist()) == ([3, 13], [10, 13])
    assert found.levels[0] == pytest.approx(np.mean([0.1, 1.0, 1.0, 1.9, 1.2]))
    assert found.count == 1


def test_a_path_outside_every_zone_has_no_dwells():
    found = find_steps(np.full(30, 3.0), zones=[SlowZone(1.0, (0.0, 2.0), "ghost", 10.0)])
    assert (found.count, found.start.size, found.levels.size, found.censored.size) == (0, 0, 0, 0)
