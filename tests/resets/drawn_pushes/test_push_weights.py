"""The best weights of pushes: against brute force over the simplex, closed cases, and the scores of their strategy."""

import math
from itertools import product

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.start_ensemble import StartEnsemble
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_weights import best_push_weights, push_weights

NOISE, MODES = WrappedNormal(0.25), 24
MAPS = [CircleMap.arnold(omega, bend) for omega, bend in ((0.02, 0.7), (0.2, 0.5), (0.45, 0.8))]
OTHERS = [CircleMap.arnold(omega, bend) for omega, bend in ((0.9, 0.6), (0.3, 0.8), (0.4, 0.3))]
DRAGS = [0.05, 0.10, 0.15]


@pytest.fixture(scope="module")
def library():
    return PushLibrary.of_maps([MAPS], NOISE, [DRAGS], MODES)


@pytest.fixture(scope="module")
def simplex(library):
    """(weights, bias, drag) over all weights in steps of 1/20; the bias is the whole one, early pushes counted."""
    rows = []
    for i, j in product(range(21), repeat=2):
        if i + j <= 20:
            share = np.array([i, j, 20 - i - j]) / 20.0
            kept = np.flatnonzero(share)
            found = push_weights(library, kept, share[kept])
            rows.append((share, found.bias, found.drag[0]))
    assert len(rows) == 231
    return rows


def test_the_least_bias_for_a_drag_is_that_of_brute_force(library, simplex):
    """A step of 1/20 in the weights cannot miss the optimum's bias by more than 0.02 here."""
    for limit in (0.08, 0.11):
        found = best_push_weights(library, drag_limit=limit, starts=3)
        least = min(bias for _, bias, drag in simplex if drag <= limit + 1e-12)
        assert found.met and found.drag[0] <= limit * (1 + 1e-6) and "bias" in found.limiting
        assert least - 0.02 < found.bias <= least + 2e-3


def test_the_least_drag_for_a_bias_is_that_of_brute_force(library, simplex):
    found = best_push_weights(library, allow_tv=0.16, starts=3)
    least = min(drag for _, bias, drag in simplex if bias <= 0.16)
    assert found.met and found.tv[0] <= 0.16 * (1 + 1e-6) and least - 0.005 < found.drag[0] <= least + 5e-4


def test_what_is_told_of_the_weights_are_the_operators_own_numbers(library):
    found = push_weights(library, [2, 0], [3.0, 1.0], within=12)
    assert found.weights.tolist() == [0.75, 0.25]
    operator = mixture_operator([MAPS[2], MAPS[0]], [0.75, 0.25], NOISE)
    assert abs(found.tv[0] - operator.tv_from_uniform) < 1e-5
    late = StartEnsemble(operator, bounded=False).worst(12, None).total_variation[-1]
    from_uniform = found.scores(bounded=False, pushes=12).curve.total_variation[-1]
    assert abs(found.tv_within[0] - from_uniform) < 1e-4 and abs(late - from_uniform) <= found.tv[0] + 1e-6
    assert abs(1.0 - found.second_eigenvalue[0] - operator.spectral_gap) < 1e-6
    assert (
        abs(found.drag[0] - (0.75 * 0.15 + 0.25 * 0.05)) < 1e-12 and abs(found.long_run_drag[0] - found.drag[0]) < 1e-12
    )


def test_a_law_that_the_modes_do_not_resolve_is_told_with_as_many_as_it_takes():
    """Eight modes give a locked map's law moments beyond one; what is reported is the full operator's."""
    locked, narrow = CircleMap.arnold(0.0, 0.9), WrappedNormal(0.08)
    found = push_weights(PushLibrary.of_maps([[locked]], narrow, [[0.1]], modes=8), [0], [1.0])
    assert abs(found.tv[0] - transfer_operator(locked, narrow).tv_from_uniform) < 1e-5


def test_of_even_pushes_the_cheapest_one_is_taken_alone():
    turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]]
    library = PushLibrary.of_maps(turns, WrappedNormal(0.5), [[0.2, 0.1]], modes=8)
    found = best_push_weights(library, allow_tv=0.01, starts=2)
    assert found.met and found.numbers == (1,) and found.tv[0] < 1e-9 and abs(found.drag[0] - 0.1) < 1e-9


def test_even_is_not_the_same_as_fast():
    """A rotation keeps the uniform law and, with little noise, any other as long: the speed asks for both pushes."""
    turns = [[CircleMap.rigid(0.2), CircleMap.rigid(0.2 + 1 / 3)]]
    library = PushLibrary.of_maps(turns, WrappedNormal(0.05), [[0.1, 0.2]], modes=40)
    slow = best_push_weights(library, allow_tv=0.02, extra_tv=0.98, starts=2)
    fast = best_push_weights(library, allow_tv=0.02, extra_tv=0.6, starts=2)
    assert slow.numbers == (0,) and slow.tv_within[0] > 0.7 and slow.met and fast.met
    assert set(fast.numbers) == {0, 1} and fast.tv_within[0] <= 0.62 + 1e-5 and "speed" in fast.limiting


def test_an_impossible_allowance_is_answered_by_the_least_bias_and_why(library, simplex):
    found = best_push_weights(library, allow_tv=0.001, drag_limit=0.08)
    least = min(bias for _, bias, drag in simplex if drag <= 0.08 + 1e-12)
    assert not found.met and "bias" in found.limiting and found.bias <= least + 2e-3


def test_a_drag_shorter_than_any_is_answered_by_the_shortest(library):
    found = best_push_weights(library, drag_limit=0.04)
    assert not found.met and "drag" in found.limiting and found.drag[0] < 0.06


def test_few_pushes_are_no_better_than_many_and_no_more_than_asked():
    rng = np.random.default_rng(5)
    maps = [CircleMap.arnold(o, k) for o, k in zip(rng.random(5), rng.uniform(0.3, 0.9, 5), strict=True)]
    library = PushLibrary.of_maps([maps], NOISE, rng.uniform(0.05, 0.2, (1, 5)), MODES)
    most, three, two = (best_push_weights(library, drag_limit=0.15, most_pushes=k, starts=2) for k in (None, 3, 2))
    assert len(three.numbers) <= 3 and len(two.numbers) <= 2 and "number of pushes" in two.limiting
    assert most.bias <= three.bias + 1e-3 and three.bias <= two.bias + 1e-3
    pairs = []
    for i, j in product(range(5), repeat=2):
        if i < j:
            part = library.only([i, j])
            pairs += [push_weights(part, [0, 1], [w, 1 - w], drag_limit=0.15) for w in np.arange(0.1, 0.95, 0.1)]
    assert len(pairs) == 10 * 9
    assert two.bias <= min(pair.bias for pair in pairs if pair.met) + 2e-3


def test_on_two_loops_the_worse_one_counts(library):
    both = PushLibrary.of_maps([MAPS, OTHERS], NOISE, [DRAGS, DRAGS], MODES)
    found = best_push_weights(both, drag_limit=0.11, starts=3)
    alone = [best_push_weights(PushLibrary.of_maps([row], NOISE, [DRAGS], MODES), drag_limit=0.11, starts=3)
             for row in (MAPS, OTHERS)]  # fmt: skip
    assert found.tv.shape == found.tv_within.shape == found.drag.shape == (2,)
    assert abs(found.bias - max(found.tv.max(), found.tv_within.max() - 0.05)) < 1e-12
    assert found.bias >= max(one.bias for one in alone) - 1e-3
    for scenario in (0, 1):
        assert abs(found.scores(scenario, bounded=False).evenness.total_variation - found.tv[scenario]) < 1e-5


def test_drags_are_compared_with_each_loops_own_limit():
    turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]] * 2
    library = PushLibrary.of_maps(turns, WrappedNormal(0.5), [[0.1, 0.2], [0.4, 0.1]], modes=8)
    found = best_push_weights(library, allow_tv=0.01, drag_limit=[0.1, 0.4], starts=2)
    # Shares of the limits are (w + 2(1 - w)) and (w + (1 - w)/4): the first is the larger, least at w = 1.
    assert found.met and found.numbers == (0,)


def test_the_strategy_draws_the_pushes_with_their_weights(library):
    found = best_push_weights(library, drag_limit=0.11, starts=2)
    law = found.strategy().law()
    assert tuple(action.push for action in law.actions) == found.pushes and np.allclose(law.weights, found.weights)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "allow_tv"),
        ({"drag_limit": -0.1}, "drag_limit"),
        ({"drag_limit": [0.1, 0.2]}, "drag_limit"),
        ({"allow_tv": 1.5}, "allowed_tv"),
        ({"allow_tv": 0.1, "within": 0}, "within"),
        ({"allow_tv": 0.1, "extra_tv": math.nan}, "extra_tv"),
        ({"allow_tv": 0.1, "most_pushes": 0}, "most_pushes"),
        ({"allow_tv": 0.1, "reach_limit": 0.3}, "without loops"),
    ],
)
def test_bad_demands_are_refused(library, options, message):
    with pytest.raises(InvalidInput, match=message):
        best_push_weights(library, **options)


@pytest.mark.parametrize(
    ("numbers", "weights"),
    [([0, 9], [1, 1]), ([0], [0.0]), ([0, 1], [1.0]), ([], []), ([0.7], [1.0]), ([-1], [1.0])],
)
def test_weights_that_fit_no_pushes_are_refused(library, numbers, weights):
    with pytest.raises(InvalidInput, match="positive weights"):
        push_weights(library, numbers, weights)


@pytest.mark.parametrize("numbers", [[math.nan], ["a"], [[0, 1]]])
def test_numbers_that_are_none_are_refused(library, numbers):
    with pytest.raises(InvalidInput, match="numbers"):
        push_weights(library, numbers, [1.0])


def test_only_the_ratios_of_weights_count_be_they_as_large_as_doubles_go(library):
    told, huge = (push_weights(library, [0, 1], weights) for weights in ([1.0, 1.0], [1e308, 1e308]))
    assert np.array_equal(told.weights, huge.weights) and np.array_equal(told.tv, huge.tv)


def test_the_drag_in_the_long_run_is_weighted_by_the_law_of_the_maps_own_operator():
    """For a drag of 0.1 + 0.02 cos θ it is 0.1 + 0.02 E cos θ; the mean over even orientations is 0.1."""
    bent, noise, even = CircleMap.arnold(0.1, 0.7), WrappedNormal(0.15), 2 * np.pi * np.arange(72) / 72
    library = PushLibrary.of_maps([[bent]], noise, [[0.1 + 0.02 * np.cos(even)]], 48)
    found = push_weights(library, [0], [1.0])
    mean = transfer_operator(bent, noise).moment(1).real
    assert abs(mean) > 0.05 and abs(found.drag[0] - 0.1) < 1e-12
    assert abs(found.long_run_drag[0] - 0.1 - 0.02 * mean) < 1e-7
