"""The multiplier of the last cycles of a resting path."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.maps import CircleMap, WrappedNormal, fixed_points, rest_multiplier, sample_staircases


def paths(multiplier, count=200, size=101, seed=3):
    kicks = np.random.default_rng(seed).normal(0.0, 0.01, (count, size))
    kicks[:, 0] /= np.sqrt(1 - multiplier**2)
    for n in range(1, size):
        kicks[:, n] += multiplier * kicks[:, n - 1]
    return kicks


@pytest.mark.parametrize("multiplier", [-0.5, 0.0, 0.8, 0.97])
def test_intervals_hold_the_truth_in_95_of_100_paths_and_the_value_lies_above_it_as_often_as_below(
    multiplier,
):
    found = [rest_multiplier(path) for path in paths(multiplier)]
    held = np.mean([rest.lower <= multiplier <= rest.upper for rest in found])
    above = np.mean([rest.value > multiplier for rest in found])
    # Three standard deviations of 200 trials.
    assert held >= 0.95 - 0.047 and 0.5 - 0.106 <= above <= 0.5 + 0.106


def test_it_is_the_multiplier_of_the_fixed_point_that_a_noisy_map_rests_at_on_the_lift_or_off_it():
    sticky = CircleMap.arnold(0.05, 0.4)
    (stable,) = [orbit for orbit in fixed_points(sticky) if orbit.stable]
    climbing = sample_staircases(
        sticky, WrappedNormal(0.01), 160, np.full(40, stable.points[0]), seed=2
    )
    found = [rest_multiplier(path) for path in climbing]
    assert np.mean([rest.lower <= stable.multiplier <= rest.upper for rest in found]) > 0.85
    assert all(abs(rest.theta - stable.points[0]) < 0.1 and rest.cycles == 100 for rest in found)
    wrapped = rest_multiplier(np.mod(climbing[0] + 6.0 * np.pi - stable.points[0], 2 * np.pi))
    assert abs(wrapped.value - found[0].value) < 1e-9


def test_a_path_on_its_way_to_a_rest_is_told_by_the_cycles_that_rest():
    """Sixty cycles from a radian off, of which the second thirty are at rest."""
    found = []
    for path in paths(0.5, size=61):
        found.append(rest_multiplier(path + 0.5 ** np.arange(61)))
    held = np.mean([rest.lower <= 0.5 <= rest.upper for rest in found])
    above = np.mean([rest.value > 0.5 for rest in found])
    assert held >= 0.95 - 0.047 and 0.5 - 0.106 <= above <= 0.5 + 0.106
    assert all(min(rest.theta, 2 * np.pi - rest.theta) < 0.02 for rest in found)
    assert all(rest.cycles <= 30 for rest in found)


def test_a_steady_climb_does_not_rest_however_short_and_a_lost_direction_may():
    """Thirty cycles of two kicks each cover less than a quarter of a turn; of kicks alone one path
    in twenty ends too far off.
    """
    kicks = np.random.default_rng(5).normal(0.0, 0.02, (200, 30))
    assert all(rest_multiplier(np.cumsum(path + 0.04)) is None for path in kicks)
    lost = [rest_multiplier(np.cumsum(path)) for path in kicks]
    told = [rest for rest in lost if rest is not None]
    assert len(told) >= 180 and np.mean([rest.upper == 1.0 for rest in told]) > 0.9


def test_what_does_not_rest_has_none():
    assert rest_multiplier(np.linspace(0.0, 6.0, 101)) is None
    assert rest_multiplier(np.zeros(10)) is None
    assert rest_multiplier(np.zeros(101)) is None
    assert rest_multiplier(1e-200 * np.arange(40)) is None
    assert rest_multiplier(np.pi + 1e-16 * np.arange(50)) is None
    refused(rest_multiplier, [0.0] * 30, 5, told="last must be at least 20")
    refused(rest_multiplier, [np.nan] * 30, told="finite")
