"""Fixed points that a moving parameter takes away, and the 2/3 law of how late that shows."""

import math

import numpy as np
from refusals import refused

from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    fixed_points,
    orbit_branches,
    sample_staircase,
    slow_folds,
)

TWO_PI = 2 * np.pi
K = 0.9


def sine(omega):
    return CircleMap.arnold(omega, K)


def cycles_until_gone(rate, begin=0.13):
    """Cycles after the crossing of K/2π until a path that began at rest is a radian
    past the fold."""
    theta, n = float(fixed_points(sine(begin))[0].points[0]), 0
    while theta < 0.5 * np.pi + 1.0:
        theta += TWO_PI * (begin + rate * n) - K * math.sin(theta)
        n += 1
    return n - (K / TWO_PI - begin) / rate


def test_paths_leave_as_late_as_the_two_thirds_law_tells():
    rates, late = (1e-4, 1e-5, 1e-6, 1e-7), []
    for rate in rates:
        (lost,) = slow_folds(sine, (0.0, 0.3), rate)
        assert lost.fold.parameter.holds(K / TWO_PI)
        late.append(cycles_until_gone(rate))
        # Next to the leading order a few cycles over a = K/2.
        assert abs(late[-1] - lost.delay_cycles) < 2.0 / (0.5 * K)
        assert abs(lost.parameter - K / TWO_PI - rate * lost.delay_cycles) < 1e-12
    order = np.polyfit(np.log(rates), np.log(np.array(rates) * late), 1)[0]
    assert abs(order - 2 / 3) < 0.01


def test_a_parameter_that_moves_the_other_way_loses_at_the_other_edge():
    (lost,) = slow_folds(sine, (-0.3, 0.3), -1e-5)
    assert lost.fold.parameter.holds(-K / TWO_PI) and lost.parameter < -K / TWO_PI
    assert abs(lost.delay_cycles - slow_folds(sine, (-0.3, 0.3), 1e-5)[0].delay_cycles) < 1e-3


def test_a_drifting_map_is_a_family_of_its_cycle_whose_rest_is_followed_to_the_loss():
    worn = DriftingMap.of_family(sine, lambda n: 0.13 + 1e-5 * n, 3000)
    (lost,) = slow_folds(worn.at, (0.0, 2999.0))
    assert (
        abs(lost.fold.parameter - (K / TWO_PI - 0.13) / 1e-5)
        <= lost.fold.parameter.error_bound + 1e-6
    )
    (branch,) = orbit_branches(worn.at, (0.0, 2999.0), resolution=2)
    start = next(orbit.points[0] for orbit in fixed_points(worn.at(0)) if orbit.stable)
    path = sample_staircase(worn, None, 2999, float(start)).theta
    rest = branch.stable & (branch.parameter > 500) & (branch.parameter < 1000)
    assert rest.sum() >= 3
    near = np.interp(branch.parameter[rest], np.arange(path.size), path)
    # It lags behind by some (dθ*/dn)/(1 - multiplier).
    assert np.max(np.abs(near - branch.points[rest, 0])) < 5e-3
    left = int(np.argmax(path > 0.5 * np.pi + 1.0))
    assert abs(left - lost.parameter) < 2.0 / (0.5 * K)


def test_a_parameter_that_stands_still_is_refused():
    refused(slow_folds, sine, (0.0, 0.3), 0.0, told="rate is 0")
