"""Branches of periodic orbits, what is met on them, and the 2/3 law of losing them slowly."""

import math
from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from refusals import refused

from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    border_collisions,
    fixed_points,
    follow_orbit,
    orbit_branches,
    period_doublings,
    periodic_orbits,
    saddle_nodes,
    sample_staircase,
    slow_folds,
    tongue,
)
from tests.maps.known_maps import contraction, plateau, tent

TWO_PI = 2 * np.pi


def arnold(K):
    return lambda omega: CircleMap.arnold(omega, K)


KNOTS = np.array([-np.pi, -1.0, 0.0, np.pi])
LEVELS = np.array([-np.pi / 2, 0.2, 0.0, -np.pi / 2])


def broken_line(p, drift=0.0):
    """θ + p + a periodic broken line with corners at -π, -1 and 0, all turned by drift·p."""

    def lift(theta):
        y = np.mod(theta - drift * p + np.pi, TWO_PI) - np.pi
        return theta + p + np.interp(y, KNOTS, LEVELS)

    return CircleMap(lift, None, breaks=drift * p + KNOTS[:-1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("K", "start", "at", "kinds"),
    [
        (2.5, 0.1, 0.0, ["period-doubling", "saddle-node", "saddle-node", "period-doubling"]),
        (0.5, np.pi / 2, 0.5 / TWO_PI, ["saddle-node"] * 2),  # started on its saddle-node
    ],
)
def test_the_fixed_points_of_the_sine_family_form_one_loop_given_in_closed_form(
    K, start, at, kinds
):
    branch = follow_orbit(arnold(K), start, (-0.5, 0.5), at=at)
    theta = branch.points[:, 0]
    assert branch.ends == ("closed", "closed")
    assert branch.parameter.size > 50 and branch.residual < 1e-14
    assert np.max(np.abs(TWO_PI * branch.parameter - K * np.sin(theta))) < 1e-14
    assert np.max(np.abs(branch.multiplier - (1 - K * np.cos(theta)))) < 1e-13
    assert np.array_equal(branch.stable, np.abs(branch.multiplier) < 1)
    assert abs(abs(theta[-1] - theta[0]) - TWO_PI) < 1e-12
    assert np.max(np.abs(np.diff(theta))) < 0.5
    assert [found.kind for found in branch.special] == kinds
    folds = sorted(one.parameter for one in branch.special if one.kind == "saddle-node")
    assert folds[0].holds(-K / TWO_PI) and folds[1].holds(K / TWO_PI)


@pytest.mark.parametrize("before", [1e-3, 0.0])
def test_a_loop_begun_on_its_fold_or_just_before_it_lists_it_once(before):
    start = np.pi / 2 - before
    at = 0.9 * np.sin(start) / TWO_PI
    loop = follow_orbit(arnold(0.9), start, (-0.2, 0.2), at=at)
    assert loop.ends == ("closed", "closed")
    folds = sorted(found.parameter for found in loop.special)
    assert len(folds) == 2
    assert folds[0].holds(-0.9 / TWO_PI) and folds[1].holds(0.9 / TWO_PI)


def test_a_branch_begun_where_its_period_doubles_lists_that_once():
    """θ + r sin θ has the multiplier 1 - r at π: -1 to the last digit where r = 2."""

    def family(r):
        return CircleMap(lambda x: x + r * np.sin(x), lambda x: 1 + r * np.cos(x))

    (flip,) = follow_orbit(family, np.pi, (1.5, 2.5), at=2.0).special
    assert flip.kind == "period-doubling" and flip.parameter.holds(2.0)


def test_a_branch_in_K_passes_its_saddle_node_and_its_period_doubling():
    omega = 0.1
    start = fixed_points(CircleMap.arnold(omega, 0.9))[0]
    branch = follow_orbit(lambda K: CircleMap.arnold(omega, K), start, (0.0, 3.0), at=0.9)
    fold, flip = branch.special
    assert branch.ends == ("end of the range", "end of the range")
    assert branch.parameter[0] == branch.parameter[-1] == 3.0
    assert fold.kind == "saddle-node" and fold.parameter.holds(TWO_PI * omega)
    assert abs(fold.theta - np.pi / 2) < 1e-12
    assert flip.kind == "period-doubling" and flip.parameter.holds(np.hypot(2.0, TWO_PI * omega))
    assert abs(flip.multiplier + 1.0) < 1e-14
    assert max(fold.parameter.error_bound, flip.parameter.error_bound) < 1e-13
    family = lambda K: CircleMap.arnold(omega, K)  # noqa: E731
    [alone] = period_doublings(family, (1.5, 2.5), resolution=2)
    assert alone.parameter.holds(np.hypot(2.0, TWO_PI * omega))


def test_a_doubled_orbit_ends_where_it_merges_with_the_orbit_of_half_its_period():
    start = periodic_orbits(CircleMap.arnold(0.05, 2.3), 2, 0)[0]
    branch = follow_orbit(lambda K: CircleMap.arnold(0.05, K), start, (1.5, 2.3), at=2.3)
    assert sorted(branch.ends) == ["end of the range", "half the period"]
    assert not any(found.kind == "saddle-node" for found in branch.special)
    # It was born at the period doubling of the fixed point.
    assert 0.0 < np.min(branch.parameter) - np.hypot(2.0, 0.1 * np.pi) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("drift", [0.0, 0.7])
def test_a_broken_line_has_its_border_collisions_at_its_corners_moving_or_not(drift):
    branch = follow_orbit(lambda p: broken_line(p, drift), 0.2 + 0.1 * drift, (-1.0, 2.0), at=0.1)
    found = sorted(branch.special, key=lambda one: float(one.parameter))
    assert [one.kind for one in found] == ["border-collision"] * 3
    assert branch.ends == ("closed", "closed")
    for one, corner, level in zip(found, (-1.0, 0.0, np.pi), (0.2, 0.0, -np.pi / 2), strict=True):
        assert one.parameter.holds(-level) and one.parameter.error_bound < 1e-13
        assert abs(np.mod(one.theta - corner + drift * level + np.pi, TWO_PI) - np.pi) < 1e-13
        assert not one.jump
    # Two orbits vanish where 1 lies between the one-sided multipliers.
    assert [one.folds for one in found] == [True, False, True]
    assert abs(found[1].multiplier - 0.5) < 1e-9
    assert abs(found[1].left_multiplier - 0.8) < 1e-9
    angles = np.mod(branch.points[:, 0] - drift * branch.parameter + np.pi, TWO_PI) - np.pi
    assert np.max(np.abs(branch.parameter + np.interp(angles, KNOTS, LEVELS))) < 1e-13


def test_a_branch_ends_where_a_point_meets_a_jump():
    fixed = follow_orbit(partial(contraction, 0.6), np.pi, (-0.5, 1.5), at=0.2)
    assert fixed.ends == ("jump", "jump")
    low, high = sorted(fixed.special, key=lambda one: float(one.parameter))
    assert low.parameter.holds(0.0) and high.parameter.holds(0.4)
    assert low.jump and high.jump and not high.folds
    assert np.max(np.abs(fixed.points[:, 0] - TWO_PI * fixed.parameter / 0.4)) < 1e-13
    start = periodic_orbits(contraction(0.6, 0.65), 2, 1)[0]
    double = follow_orbit(partial(contraction, 0.6), start, (0.0, 1.5), at=0.65)
    edge = max(float(one.parameter) for one in double.special)
    assert abs(edge - plateau(0.6, Fraction(1, 2))[1]) < 1e-14
    assert double.ends == ("jump", "jump")


def test_a_symmetric_family_passes_a_pitchfork_as_a_branch_point():
    def family(p):
        return CircleMap(
            lambda x: x + p * np.sin(x) + 0.3 * np.sin(2 * x),
            lambda x: 1 + p * np.cos(x) + 0.6 * np.cos(2 * x),
        )

    branch = follow_orbit(family, 0.0, (-1.0, 0.0), at=-0.9)
    assert [found.kind for found in branch.special] == ["branch point"]
    assert abs(branch.special[0].parameter + 0.6) < 1e-12
    assert np.max(np.abs(branch.points)) < 1e-12


def test_the_family_is_never_called_outside_the_range():
    asked = []

    def family(K):
        asked.append(K)
        return CircleMap.arnold(0.02, K)

    follow_orbit(family, fixed_points(CircleMap.arnold(0.02, 0.5))[0], (0.2, 0.5), at=0.5)
    assert len(asked) > 50 and min(asked) >= 0.2 and max(asked) <= 0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("finder", "family", "p", "q"),
    [
        (saddle_nodes, arnold(0.95), 2, 5),
        (border_collisions, tent, 1, 2),
    ],
)
def test_the_edges_of_a_tongue_are_its_saddle_nodes_or_border_collisions(finder, family, p, q):
    locked = tongue(family, (p, q), (-0.5, 1.0))
    reach = 0.5 * float(locked.width)
    within = (locked.left - reach, locked.right + reach)
    found = [one for one in finder(family, within, q, p, resolution=8) if one.folds]
    assert len(found) == 2
    for one, edge in zip(found, (locked.left, locked.right), strict=True):
        assert abs(one.parameter - edge) <= one.parameter.error_bound + edge.error_bound
    assert finder is saddle_nodes or saddle_nodes(family, within, q, p, resolution=8) == []


@pytest.mark.slow
def test_a_branch_born_and_gone_inside_the_range_is_found():
    """Ω(p) dips below K/2π only between two values of p. Without a grid point inside it is missed,
    as the resolution states.
    """

    def family(p):
        return CircleMap.arnold(0.2 - 0.1 * np.exp(-((p - 0.43) ** 2) / 0.01), 0.9)

    assert not periodic_orbits(family(0.0), 1) and not periodic_orbits(family(1.0), 1)
    found = saddle_nodes(family, (0.0, 1.0))
    away = np.sqrt(-0.01 * np.log((0.2 - 0.9 / TWO_PI) / 0.1))
    assert len(found) == 2
    for one, sign in zip(found, (-1, 1), strict=True):
        assert abs(one.parameter - (0.43 + sign * away)) <= one.parameter.error_bound + 2e-16
    assert saddle_nodes(family, (0.0, 1.0), resolution=1) == []


def test_bounds_hold_for_families_moved_by_what_they_may_be_off():
    """Saddle-nodes of period 1 and 2, and kinks: moved by a wave of 1e-6 rad, but for the breaks."""
    off = 1e-6

    def changed(plain, claim, size):
        return CircleMap(
            lambda x: plain(x) + size * np.cos(2 * x + 0.5),
            lambda x: plain.derivative(x) - 2 * size * np.sin(2 * x + 0.5),
            plain.breaks,
            max_error=claim,
        )

    def located(find, make, claim, size, *orbits):
        family = lambda p: changed(make(p), claim, size)  # noqa: E731
        return find(family, *orbits, resolution=4)

    for find, make, *orbits in (
        (saddle_nodes, arnold(0.9), (0.13, 0.15), 1, 0),
        (saddle_nodes, arnold(0.9), (0.46, 0.475), 2, 1),
        (border_collisions, broken_line, (-0.5, 0.5), 1, 0),
    ):
        given = located(find, make, off, 0.0, *orbits)
        others = located(find, make, 0.0, off, *orbits)
        assert len(given) == len(others) > 0
        for one, other in zip(given, others, strict=True):
            error, bound = abs(one.parameter - other.parameter), one.parameter.error_bound
            assert 0.01 * off < error <= 1.001 * bound + other.parameter.error_bound
            assert bound < 10.0 * off


def test_a_period_doubling_is_bounded_where_the_slope_comes_from_differences():
    """x + p sin x + sin(3x)/5 doubles its fixed point π at p = 1.4."""
    family = lambda p: CircleMap(lambda x: x + p * np.sin(x) + 0.2 * np.sin(3.0 * x))  # noqa: E731
    [doubling] = period_doublings(family, (1.0, 1.7))
    assert doubling.parameter.holds(1.4) and doubling.parameter.error_bound < 1e-9


EDGE, BEGIN, PAST = 0.9 / TWO_PI, 0.13, 0.5 * np.pi + 1.0  # past: a radian beyond the fold


def cycles_until_gone(rate):
    """Cycles after the crossing of the edge until a path that began at rest is past the fold."""
    theta, n = float(fixed_points(CircleMap.arnold(BEGIN, 0.9))[0].points[0]), 0
    while theta < PAST:
        theta += TWO_PI * (BEGIN + rate * n) - 0.9 * math.sin(theta)
        n += 1
    return n - (EDGE - BEGIN) / rate


def test_paths_leave_as_late_as_the_two_thirds_law_tells():
    """Next to the leading order a few cycles over a = K/2; the other way at the other edge."""
    rates, late = (1e-4, 1e-5, 1e-6), []
    for rate in rates:
        (lost,) = slow_folds(arnold(0.9), (0.0, 0.3), rate)
        assert lost.fold.parameter.holds(EDGE)
        late.append(cycles_until_gone(rate))
        assert abs(late[-1] - lost.delay_cycles) < 2.0 / 0.45
        assert abs(lost.parameter - EDGE - rate * lost.delay_cycles) < 1e-12
    order = np.polyfit(np.log(rates), np.log(np.array(rates) * late), 1)[0]
    assert abs(order - 2 / 3) < 0.01
    (other,) = slow_folds(arnold(0.9), (-0.3, 0.3), -rate)
    assert other.fold.parameter.holds(-EDGE) and other.parameter < -EDGE
    assert abs(other.delay_cycles - lost.delay_cycles) < 1e-3
    refused(slow_folds, arnold(0.9), (0.0, 0.3), 0.0, told="rate is 0")


def test_a_drifting_map_is_a_family_of_its_cycle_whose_rest_is_followed_to_the_loss():
    """The path lags behind it by some (dθ*/dn)/(1 - multiplier)."""
    worn = DriftingMap.of_family(arnold(0.9), lambda n: BEGIN + 1e-5 * n, 3000)
    (lost,) = slow_folds(worn.at, (0.0, 2999.0))
    fold = lost.fold.parameter
    assert abs(fold - (EDGE - BEGIN) / 1e-5) <= fold.error_bound + 1e-6
    (branch,) = orbit_branches(worn.at, (0.0, 2999.0), resolution=2)
    start = next(orbit.points[0] for orbit in fixed_points(worn.at(0)) if orbit.stable)
    path = sample_staircase(worn, None, 2999, float(start)).theta
    rest = branch.stable & (branch.parameter > 500) & (branch.parameter < 1000)
    assert rest.sum() >= 3
    near = np.interp(branch.parameter[rest], np.arange(path.size), path)
    assert np.max(np.abs(near - branch.points[rest, 0])) < 5e-3
    assert abs(int(np.argmax(path > PAST)) - lost.parameter) < 2.0 / 0.45
