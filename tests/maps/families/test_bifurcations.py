"""Bifurcations over a range: closed forms, tongue edges as a second route, isolated branches, bad input."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    bifurcations,
    border_collisions,
    orbit_branches,
    period_doublings,
    periodic_orbits,
    saddle_nodes,
    tongue,
)

TWO_PI = 2 * np.pi


def arnold(K):
    return lambda omega: CircleMap.arnold(omega, K)


def test_saddle_nodes_of_the_sine_family_are_at_omega_equal_to_K_over_two_pi():
    found = saddle_nodes(arnold(0.7), (-0.5, 0.5))
    assert len(found) == 2
    for one, sign in zip(found, (-1, 1), strict=True):
        assert one.parameter.holds(sign * 0.7 / TWO_PI)
        assert abs(one.theta - np.mod(sign * np.pi / 2, TWO_PI)) < 1e-12
        assert one.folds
        assert one.parameter.error_bound < 1e-14


def test_saddle_nodes_of_the_moebius_family_are_at_sine_equal_to_a():
    found = saddle_nodes(lambda omega: CircleMap.moebius(0.6, omega), (-0.45, 0.45))
    assert len(found) == 2
    for one, sign in zip(found, (-1, 1), strict=True):
        assert one.parameter.holds(sign * np.arcsin(0.6) / np.pi)


@pytest.mark.slow
@pytest.mark.parametrize("K", [2.1, 2.8])
def test_a_folded_fixed_point_doubles_where_K_cosine_is_two(K):
    found = period_doublings(arnold(K), (0.0, 0.5))
    assert len(found) == 1
    assert found[0].parameter.holds(np.sqrt(K * K - 4.0) / TWO_PI)
    assert abs(np.cos(found[0].theta) - 2.0 / K) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(("p", "q", "K"), [(1, 2, 0.9), (2, 5, 0.95)])
def test_saddle_nodes_of_period_q_are_the_edges_of_the_tongue(p, q, K):
    locked = tongue(arnold(K), (p, q), (0.0, 1.0))
    reach = float(locked.width)
    found = saddle_nodes(arnold(K), (locked.left - reach, locked.right + reach), q, p, resolution=8)
    assert len(found) == 2
    for one, edge in zip(found, (locked.left, locked.right), strict=True):
        assert abs(one.parameter - edge) <= one.parameter.error_bound + edge.error_bound


@pytest.mark.slow
def test_a_branch_born_and_gone_inside_the_range_is_found():
    """Ω(p) dips below K/2π only between two values of p; nothing exists at either end of the range."""

    def family(p):
        return CircleMap.arnold(0.2 - 0.1 * np.exp(-((p - 0.43) ** 2) / 0.01), 0.9)

    assert not periodic_orbits(family(0.0), 1) and not periodic_orbits(family(1.0), 1)
    found = saddle_nodes(family, (0.0, 1.0))
    away = np.sqrt(-0.01 * np.log((0.2 - 0.9 / TWO_PI) / 0.1))
    assert len(found) == 2
    for one, sign in zip(found, (-1, 1), strict=True):
        assert abs(one.parameter - (0.43 + sign * away)) <= one.parameter.error_bound + 2e-16
    assert saddle_nodes(family, (0.0, 1.0), resolution=1) == []  # no grid point inside: the stated resolution


def test_the_second_doubling_has_multiplier_minus_one_where_scanning_finds_the_orbit():
    family = lambda K: CircleMap.arnold(0.1, K)  # noqa: E731
    found = period_doublings(family, (2.05, 2.9), 2, 0, resolution=6)
    assert len(found) >= 1
    for one in found:
        listed = periodic_orbits(family(float(one.parameter)), 2, 0)
        near = min(listed, key=lambda orbit: abs(orbit.points[0] - one.theta))
        assert abs(near.multiplier + 1.0) < 1e-8
        assert abs(near.points[0] - one.theta) < 1e-9
        assert one.parameter.error_bound < 1e-12


def test_all_saddle_nodes_together_account_for_every_change_in_the_number_of_orbits():
    family = arnold(1.6)
    found = bifurcations(family, (0.30, 0.42), 3, 1, resolution=12)
    folds = sorted(float(one.parameter) for one in found if one.kind == "saddle-node")
    assert len(folds) >= 1
    ends = [0.30, *folds, 0.42]
    counts = [len(periodic_orbits(family(0.5 * (a + b)), 3, 1)) for a, b in pairwise(ends)]
    assert all(abs(b - a) == 2 for a, b in pairwise(counts))


def tent(p):
    def lift(x):
        return x + p + 0.5 * np.abs(np.mod(x + np.pi, TWO_PI) - np.pi)

    return CircleMap(lift, None, breaks=[0.0, np.pi])


@pytest.mark.slow
def test_a_tent_loses_its_fixed_points_in_two_folding_border_collisions():
    found = border_collisions(tent, (-2.0, 1.0))
    assert len(found) == 2
    for one, at in zip(found, (-np.pi / 2, 0.0), strict=True):
        assert one.parameter.holds(at)
        assert one.folds
        assert not one.jump
    assert saddle_nodes(tent, (-2.0, 1.0)) == []


@pytest.mark.slow
def test_border_collisions_of_period_two_are_the_edges_of_a_kinked_tongue():
    locked = tongue(lambda p: tent(TWO_PI * p), (1, 2), (0.0, 1.0))
    found = border_collisions(lambda p: tent(TWO_PI * p), (locked.left - 0.02, locked.right + 0.02), 2, 1, resolution=6)
    edges = [float(one.parameter) for one in found if one.folds]
    assert len(edges) == 2
    assert abs(edges[0] - locked.left) <= found[0].parameter.error_bound + locked.left.error_bound
    assert abs(edges[1] - locked.right) <= found[-1].parameter.error_bound + locked.right.error_bound


def test_a_sampled_family_has_its_saddle_node_near_that_of_the_family_it_samples():
    x = np.linspace(0, TWO_PI, 300, endpoint=False)

    def sampled(omega):
        exact = CircleMap.arnold(omega, 0.9)
        return CircleMap.from_samples(x, exact(x), exact.derivative(x))

    found = saddle_nodes(sampled, (0.05, 0.2), resolution=4)
    assert len(found) == 1
    assert abs(found[0].parameter - 0.9 / TWO_PI) < 1e-9


def test_branches_are_listed_once_each():
    branches = orbit_branches(arnold(0.9), (0.40, 0.60), 2, 1, resolution=10)
    assert [branch.ends for branch in branches] == [("closed", "closed")]
    assert branches[0].period == 2
    assert branches[0].winding == 1


def test_bad_input_is_refused():
    with pytest.raises(InvalidInput, match="period must be at least 1"):
        saddle_nodes(arnold(0.9), (0.0, 1.0), 0)
    with pytest.raises(InvalidInput, match="low end must lie below"):
        period_doublings(arnold(0.9), (1.0, 0.0))
    with pytest.raises(InvalidInput, match="finite"):
        border_collisions(arnold(0.9), (0.0, float("inf")))
    with pytest.raises(InvalidInput, match="must return a CircleMap"):
        saddle_nodes(lambda p: 1.0, (0.0, 1.0))
    with pytest.raises(InvalidInput, match="every point"):
        saddle_nodes(lambda p: CircleMap.rigid(0.0), (0.0, 1.0))
