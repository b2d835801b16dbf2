"""What no rule can beat: below every open-loop mixture, tight for one push, with no gap, closing as cells shrink."""

import numpy as np
import pytest
from scipy.special import ndtr

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
from cyclemap.resets.drawn_pushes.push_bound import GAP, _PushCells, least_bias, push_bound
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_weights import best_push_weights

NOISE = WrappedNormal(0.2)
MAPS = [CircleMap.arnold(omega, bend) for omega, bend in ((0.0, 0.9), (0.05, 0.8), (0.4, 0.9), (0.7, 0.6))]
DRAGS = np.array([[0.1, 0.15, 0.2, 0.3]])


@pytest.fixture(scope="module")
def library():
    return PushLibrary.of_maps([MAPS], NOISE, DRAGS, 32)


def test_the_bound_lies_below_every_mixture_and_below_what_the_rule_attains(library):
    """With the drag in the long run, weights are a rule like any other; the rule looks and does better."""
    found = best_push_weights(library, drag_limit=0.13, extra_tv=0.95, starts=3)
    bound = push_bound(library, drag_limit=float(found.long_run_drag[0]), cells=48)
    assert bound.is_certified and abs(bound.gap) <= GAP and bound.dual - GAP <= bound.primal
    assert 0.05 < bound.lower <= bound.primal < found.tv[0]
    assert bound.drag <= found.long_run_drag[0] + 1e-9 and bound.price > 0.0


@pytest.mark.parametrize("width", [0.2, 0.06])
def test_with_one_push_there_is_nothing_to_choose(width):
    """The bound then is the bias of the map's own operator: two routes, also with cells wider than the noise."""
    gentle, noise = CircleMap.arnold(0.1, 0.4), WrappedNormal(width)
    one = PushLibrary.of_maps([[gentle]], noise, [[0.1]], 32)
    exact = transfer_operator(gentle, noise).tv_from_uniform
    bound = push_bound(one, cells=64)
    assert bound.is_certified and bound.lower <= exact + exact.error_bound and exact - bound.lower < 0.01
    assert np.all(bound.rule == 1.0) and abs(bound.primal - exact) < 2e-3


def test_the_proved_bound_closes_on_the_programme_as_the_cells_shrink(library):
    bounds = [push_bound(library, drag_limit=0.12, cells=cells) for cells in (16, 64)]
    apart = [bound.primal - bound.lower for bound in bounds]
    assert all(bound.is_certified for bound in bounds) and min(apart) >= 0.0
    assert apart[1] < 0.5 * apart[0] and apart[1] < 0.01 and bounds[0].lower < bounds[1].primal


def test_any_lower_bound_lies_below_any_grids_optimum_of_the_drag(library):
    bounds = [push_bound(library, allow_tv=0.05, cells=cells) for cells in (24, 64)]
    assert all(bound.primal == bound.drag and bound.is_certified and bound.tv <= 0.05 + 1e-9 for bound in bounds)
    assert max(bound.lower for bound in bounds) <= min(bound.primal for bound in bounds)
    assert bounds[1].primal - bounds[1].lower < 0.01 * bounds[1].primal
    # No drag is shorter than the shortest push's, and less bias costs more.
    assert DRAGS.min() <= bounds[1].lower < push_bound(library, allow_tv=0.01, cells=64).lower


def test_the_rule_itself_attains_the_bound():
    """Simulated: the push is drawn by the cell of the orientation, and the histogram is the programme's law."""
    library = PushLibrary.of_maps([MAPS], NOISE, DRAGS, 32)
    bound = push_bound(library, drag_limit=0.12, cells=64)
    rng = np.random.default_rng(3)
    theta = rng.uniform(0.0, 2 * np.pi, 20_000)
    for _ in range(50):
        push = bound.push_at(theta, rng.random(theta.size))
        theta = np.choose(push, [one(theta) for one in MAPS]) + NOISE.sample(rng, theta.size)
    counts, _ = np.histogram(np.mod(theta, 2 * np.pi), 64, (0.0, 2 * np.pi))
    assert np.abs(counts / theta.size - bound.masses).sum() / 2 < 0.03
    assert abs(DRAGS[0][push].mean() - 0.12) < 0.002


def test_rotations_need_no_bias_and_the_least_drag_is_the_shortest():
    turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]]
    library = PushLibrary.of_maps(turns, NOISE, [[0.1, 0.2]], 8)
    even = push_bound(library, drag_limit=0.1, cells=32)
    assert even.lower == 0.0 and even.primal < 1e-9
    cheap = push_bound(library, allow_tv=0.0, cells=32)
    assert abs(cheap.lower - 0.1) < 1e-9 and abs(cheap.primal - 0.1) < 1e-9


def test_the_price_of_mass_is_that_of_brute_force():
    """min TV(p, q) + h·p over a fine grid of laws on three points."""
    worth, target = np.array([0.1, 0.9, 1.7]), np.array([0.3, 0.3, 0.4])
    steps = np.array([(i, j, 100 - i - j) for i in range(101) for j in range(101 - i)]) / 100
    values = 0.5 * np.abs(steps - target).sum(axis=1) + steps @ worth
    assert len(values) == 5151 and abs(least_bias(worth, target) - values.min()) < 1e-12


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"allow_tv": 0.1, "drag_limit": 0.1}, "not both"),
        ({"drag_limit": 0.05}, "every drag is longer"),
        ({"allow_tv": 1.0}, "allowed_tv"),
        ({"cells": 4}, "cells"),
        ({"cells": 1000}, "cells"),
        ({"scenario": 1}, "scenario"),
    ],
)
def test_bad_values_are_refused(library, options, message):
    with pytest.raises(InvalidInput, match=message):
        push_bound(library, **options)


@pytest.mark.parametrize("options", [{}, {"drag_limit": 0.13}, {"allow_tv": 0.0}])
def test_beside_a_rotation_the_programme_ends_and_says_how_well(options):
    """A rotation keeps the law even: the optimum is degenerate, and simplex steps alone would go in a circle."""
    maps = [CircleMap.arnold(0.1, 0.7), CircleMap.arnold(0.3, -0.9), CircleMap.rigid(0.7), CircleMap.arnold(2.0, 0.5)]
    library = PushLibrary.of_maps([maps], WrappedNormal(0.15), [[0.1, 0.2, 0.15, 0.12]], modes=8)
    bound = push_bound(library, cells=64, **options)
    assert bound.is_certified and bound.tv < 1e-8
    assert bound.lower == 0.0 if "allow_tv" not in options else 0.1 < bound.lower <= bound.drag < 0.15


@pytest.mark.parametrize(("price", "swing", "wave"), [(0.0, 0.0, 1.0), (1.0, 0.05, 0.0), (1.0, 0.05, 1.0)])
def test_what_follows_a_push_is_bounded_below_all_over_every_part_not_at_its_middle_alone(price, swing, wave):
    """Price times drag, plus the chance that map and noise lead onto a half circle, by the normal law itself."""
    stretch, noise = CircleMap.arnold(0.3, 0.9), WrappedNormal(0.05)
    even = 2 * np.pi * np.arange(64) / 64
    library = PushLibrary.of_maps([[stretch]], noise, [[0.1 + swing * np.cos(even)]], 8)
    pushes = _PushCells(library.random_maps[0], library.drag_lengths[0], 64)
    parts, width = pushes.grid.parts, pushes.grid.part_width
    values = np.where(np.arange(parts) < parts // 2, wave, 0.0)
    lowest, middle = (pushes.cheapest(values, price, bounded=bounded) for bounded in (True, False))
    theta = (np.arange(parts)[:, None] + np.array([0.0, 0.5, 1.0])) * width
    half_turns = np.pi * np.arange(-4.0, 8.0).reshape(-1, 2, 1, 1)
    onto = np.diff(ndtr((half_turns - stretch(theta)) / 0.05), axis=1).sum(axis=(0, 1))
    drags = np.interp(theta, even, library.drag_lengths[0, 0], period=2 * np.pi)
    worth = price * drags + wave * onto
    assert np.abs(worth[:, 1] - middle).max() < 1e-6
    assert np.all(lowest <= worth.min(axis=1) + 1e-12) and np.max(middle - worth.min(axis=1)) > 1e-7
    assert np.max(worth.min(axis=1) - lowest) < 5e-3
