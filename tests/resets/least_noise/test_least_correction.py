from itertools import pairwise

import numpy as np
import pytest
from correction_cases import SINE, random_map

from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import UniformNoise, WrappedNormal
from cyclemap.resets.least_noise.correction_programme import solve_by_flow, solve_by_plan
from cyclemap.resets.least_noise.cycle_cells import CycleCells
from cyclemap.resets.least_noise.least_correction import GAP, least_correction
from cyclemap.resets.least_noise.turn_costs import turn_cost

ALLOWANCES = (0.0, 0.05)


@pytest.fixture(scope="module")
def plywood(real_loop):
    return real_loop.circle_map(1e-5)


def even_turns(circle_map):
    return circle_map.turn((np.arange(4096) + 0.5) * (2 * np.pi / 4096))


def test_sine_map_without_allowance_is_the_closed_form_two_k_over_pi_and_k_squared_over_two():
    """For an invertible map the optimum is the turn's mean deviation: K E|sin| for |ξ|, K² E sin² for ξ²."""
    absolute = least_correction(SINE, 0.0)
    assert absolute.lower <= 2 * 0.9 / np.pi <= absolute.upper
    assert absolute.upper - absolute.lower < 3e-4
    squared = least_correction(SINE, 0.0, cost="squared")
    assert squared.lower <= 0.9**2 / 2 <= squared.upper
    cosine = least_correction(SINE, 0.0, cost="cosine")
    exact = float(np.mean(1.0 - np.cos(even_turns(SINE) - 0.2 * np.pi)))
    assert cosine.lower <= exact <= cosine.upper < exact + 2e-4


@pytest.mark.parametrize("a", [0.2, 0.5, 0.8])
def test_moebius_map_needs_the_legendre_chi_function_of_its_parameter(a):
    """Its turn is 2 Σ aⁿ sin(nθ)/n about the mean, so E|turn| = (4/π) Σ over odd n of aⁿ/n²."""
    odd = np.arange(1, 400, 2)
    exact = 4 / np.pi * float(np.sum(a**odd / odd**2))
    found = least_correction(CircleMap.moebius(a, 0.3), 0.0)
    assert found.lower <= exact <= found.upper < exact + 4e-4


@pytest.mark.parametrize("circle_map", [CircleMap.rigid(0.123), CircleMap.blaschke([0, 0.4]), CircleMap.rigid(0.5)])
@pytest.mark.parametrize("allowed", ALLOWANCES)
def test_maps_that_keep_the_uniform_law_need_nothing(circle_map, allowed):
    """Rigid rotations, and inner functions that fix the origin."""
    found = least_correction(circle_map, allowed, cells=128)
    assert found.primal < 2e-6
    assert found.lower < 2e-6 and found.upper < 3e-4
    assert np.max(np.abs(found.extra_turn(np.linspace(0, 6, 20)))) < 1e-3 or allowed > 0.0


@pytest.mark.parametrize("allowed", ALLOWANCES)
@pytest.mark.parametrize("name", ["sine", "plywood"])
def test_duality_gap_is_below_1e_8_and_the_bounds_hold_the_value(name, allowed, plywood):
    found = least_correction(SINE if name == "sine" else plywood, allowed)
    assert found.is_certified and found.gap + 1e-13 >= 0.0 and found.gap <= GAP
    assert found.lower <= found.primal <= found.upper
    assert found.upper - found.lower < 6e-4
    assert found.tv <= allowed + 1e-12
    assert found.tv == pytest.approx(allowed, abs=1e-9)


@pytest.mark.parametrize("allowed", ALLOWANCES)
def test_the_correction_replayed_on_the_map_itself_keeps_the_law_at_the_stated_cost(allowed, plywood):
    """Points of the law, one cycle, the extra turn: no programme and no matrix has a part in it."""
    for circle_map in (SINE, plywood):
        found = least_correction(circle_map, allowed, cells=256)
        replayed = found.replayed(40_000)
        assert replayed.tv < 256 / 40_000
        assert found.lower - 1e-6 <= replayed.mean_cost <= found.upper + 1e-6


def test_correction_of_an_invertible_map_to_exact_evenness_makes_it_a_rigid_rotation():
    found = least_correction(SINE, 0.0, cells=256)
    theta = np.linspace(0.0, 2 * np.pi, 500)
    after = SINE(theta) + found.extra_turn(SINE(theta))
    assert np.ptp(after - theta) < 1e-3


@pytest.mark.parametrize("circle_map", [CircleMap.arnold(0.3, 2.5), random_map(3)])
def test_exhaustive_assignment_of_points_agrees_for_exact_evenness(circle_map):
    """400 even points, their images, and the best assignment back (Hungarian method) for two costs."""
    from scipy.optimize import linear_sum_assignment

    points = (np.arange(400) + 0.5) * (2 * np.pi / 400)
    apart = np.mod(points - circle_map(points)[:, None] + np.pi, 2 * np.pi) - np.pi
    for cost, prices in (("absolute", np.abs(apart)), ("squared", apart**2)):
        rows, columns = linear_sum_assignment(prices)
        by_hand = float(np.mean(prices[rows, columns]))
        found = least_correction(circle_map, 0.0, cost=cost, cells=96)
        assert by_hand == pytest.approx(found.primal, abs=0.02 * by_hand)
        assert found.lower - 0.02 * by_hand <= by_hand <= found.upper + 0.02 * by_hand


@pytest.mark.parametrize("cost", ["absolute", "squared"])
def test_the_programme_over_all_pairs_of_points_agrees_with_an_allowance(cost):
    """min Σ m_ij c(x_j - F(x_i)) with equal marginals, on 60 points as it stands: no hat functions, no flows."""
    from scipy.optimize import linprog

    count, allowed = 60, 0.05
    points = (np.arange(count) + 0.5) * (2 * np.pi / count)
    turns = np.mod(points - SINE(points)[:, None] + np.pi, 2 * np.pi) - np.pi
    leave, arrive = np.kron(np.eye(count), np.ones(count)), np.kron(np.ones(count), np.eye(count))
    rows = np.block([[leave - arrive, np.zeros((count, count))], [np.ones((1, count**2)), np.zeros((1, count))]])
    limits = np.block([[leave, -np.eye(count)], [np.zeros((1, count**2)), np.ones((1, count))]])
    prices = np.abs(turns) if cost == "absolute" else turns**2
    solved = linprog(
        np.append(prices.ravel(), np.zeros(count)),
        A_ub=limits,
        b_ub=np.append(np.full(count, 1 / count), allowed),
        A_eq=rows,
        b_eq=np.append(np.zeros(count), 1.0),
    )
    found = least_correction(SINE, allowed, cost=cost, cells=96)
    assert solved.fun == pytest.approx(found.primal, rel=0.02)


def test_flows_and_plans_are_one_programme_for_the_absolute_cost():
    for circle_map in (SINE, random_map(5)):
        grid = CycleCells(circle_map, 48)
        plan, flow = solve_by_plan(grid, 0.05, turn_cost("absolute")), solve_by_flow(grid, 0.05)
        assert plan.primal == pytest.approx(flow.primal, abs=1e-9) and plan.dual == pytest.approx(flow.dual, abs=1e-9)


def test_smaller_cells_close_the_bounds_and_every_pair_holds_a_common_value():
    found = [least_correction(SINE, 0.05, cells=cells) for cells in (32, 64, 128, 256, 512)]
    spans = [one.upper - one.lower for one in found]
    assert all(after < before for before, after in pairwise(spans))
    assert max(one.lower for one in found) <= min(one.upper for one in found)


def test_optimum_falls_and_is_convex_in_the_allowance():
    """A mixture of two plans is a plan, for the mixed allowance."""
    found = [least_correction(SINE, allowed, cells=128).primal for allowed in (0.0, 0.05, 0.1, 0.15, 0.2, 0.25)]
    assert np.all(np.diff(found) < 0.0) and np.all(np.diff(found, 2) > -1e-9)


def test_turning_the_surface_changes_nothing():
    """Conjugation by a rotation through whole cells carries plan and law along."""
    turn = 2 * np.pi / 128 * 37
    turned = CircleMap(lambda theta: SINE(theta - turn) + turn, lambda theta: SINE.derivative(theta - turn))
    one, other = (least_correction(m, 0.05, cells=128) for m in (SINE, turned))
    assert other.primal == pytest.approx(one.primal, abs=1e-9)
    assert other.upper == pytest.approx(one.upper, abs=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_bounds_hold_on_random_maps_and_other_corrections_cost_more(seed):
    """The bounds of two costs obey Jensen's inequality, and no even law of points beats the lower bound."""
    circle_map = random_map(seed)
    absolute = least_correction(circle_map, 0.05, cells=128)
    squared = least_correction(circle_map, 0.05, cost="squared", cells=48)
    assert absolute.is_certified and squared.is_certified
    assert absolute.lower <= absolute.upper and squared.lower <= squared.upper
    assert absolute.lower**2 <= squared.upper
    uniform = least_correction(circle_map, 0.0, cells=128)
    assert absolute.lower <= uniform.upper


def test_a_target_that_the_map_keeps_needs_nothing_and_uniform_then_needs_much():
    """z → -(z - c)/(1 - cz), c = 2a/(1 + a²), is a half turn seen through z → (z + a)/(1 + az): Poisson's law stays."""
    a = 0.5

    def poisson(theta):
        return (1 - a * a) / (1 + a * a - 2 * a * np.cos(theta)) / (2 * np.pi)

    involution = CircleMap.moebius(2 * a / (1 + a * a), 0.5)
    assert least_correction(involution, 0.0, target=poisson, cells=256).upper < 1e-3
    assert least_correction(involution, 0.0, cells=256).lower > 0.5


def test_own_noise_lessens_what_is_needed_and_uniform_own_noise_leaves_nothing():
    plain, noisy = (least_correction(SINE, 0.05, cells=128, own_noise=own) for own in (None, WrappedNormal(0.3)))
    assert noisy.is_certified and noisy.upper < plain.lower
    assert noisy.replayed(40_000, seed=1).tv < 3 * np.sqrt(128 / (2 * np.pi * 40_000))
    assert least_correction(SINE, 0.0, own_noise=UniformNoise(np.pi), cells=128).primal < 1e-9


def test_independent_pushforward_by_inverse_images_gives_the_same_wasserstein_distance():
    """For ε = 0, W1 from the distribution function of F#u, by the inverse map, and the median of the difference."""
    from cyclemap.maps.algebra.map_algebra import inverse

    grid = (np.arange(8192) + 0.5) * (2 * np.pi / 8192)
    difference = (inverse(SINE)(grid) - grid) / (2 * np.pi)
    distance = 2 * np.pi * float(np.mean(np.abs(difference - np.median(difference))))
    found = least_correction(SINE, 0.0)
    assert found.lower <= distance <= found.upper


def test_bad_values_are_named():
    for options, match in (
        ({"allowed_tv": 1.0}, "allowed_tv is 1"),
        ({"allowed_tv": -0.1}, "allowed_tv is -0.1"),
        ({"allowed_tv": 0.1, "cost": "cubic"}, "unknown cost 'cubic'"),
        ({"allowed_tv": 0.1, "cells": 4}, "cells must be at least 8"),
        ({"allowed_tv": 0.1, "cells": 5000}, "cells is 5000"),
        ({"allowed_tv": 0.1, "cells": 500, "cost": "squared"}, "cells is 500"),
        ({"allowed_tv": 0.1, "target": 3.0}, "target is 3.0"),
        ({"allowed_tv": 0.1, "own_noise": 0.2}, "own_noise is 0.2"),
    ):
        with pytest.raises(InvalidInput, match=match):
            least_correction(SINE, **options)
    with pytest.raises(InvalidInput, match="the map is 'sine'"):
        least_correction("sine", 0.1)
