"""Runs by the mechanics and from sampled maps are the same collections; histograms lie as far from
uniform as told; what is no turn, strategy, histogram or map is refused.
"""

import math

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.resets import (
    CycleAction,
    ResetStrategy,
    histogram_distances,
    histogram_shares,
    independent_distance,
    map_turns,
    orientation_law,
    run_strategy,
    sampled_orientations,
    steered_orientations,
    strategy_maps,
)

LOOP = cm.CollectionLoop.mit(accuracy=1e-6)
COIN = ResetStrategy.pushes(LOOP.push, (1, 2))
ALONE = ResetStrategy((CycleAction(),))
TURNING = ResetStrategy((CycleAction(), CycleAction(turn=2.0)))


@pytest.fixture(scope="module")
def coin_maps():
    return strategy_maps(LOOP, COIN)


def test_a_run_is_cycle_after_cycle_of_what_is_drawn() -> None:
    run = run_strategy(LOOP, TURNING, 6, start=0.3, sigma=0.0, seed=4)
    theta = 0.3
    for number, action in enumerate(TURNING.run(6, 4)):
        theta = action.on(LOOP).cycle(theta).theta_next + action.turn
        assert run.theta[0, number + 1] == pytest.approx(theta, abs=1e-8)


def test_runs_from_sampled_maps_follow_the_mechanics(coin_maps) -> None:
    """Two routes to the same paths, until what is between the samples has grown."""
    sampled = sampled_orientations(map_turns(coin_maps, 1440), COIN, 20, 5, 0.02, seed=3, start=1.0)
    # The noise is drawn for as many cycles as there are.
    run = run_strategy(LOOP, COIN, 20, runs=5, start=1.0, sigma=0.02, seed=3)
    assert run.action.shape == (5, 20) and len({tuple(row) for row in run.action.tolist()}) == 5
    assert sampled == pytest.approx(run.theta[:, :-1], abs=5e-3)


def test_runs_and_seeds_are_drawn_by_themselves() -> None:
    """What was done and what was kicked are other in every run and seed."""
    turns = np.outer([1.0, 2.0], np.ones(8))
    found = [sampled_orientations(turns, TURNING, 61, 5, 0.1, seed=seed) for seed in (1, 2)]
    steps = np.diff(np.concatenate(found), axis=1)
    assert len({tuple(row) for row in np.rint(steps).tolist()}) == 10
    kicks = steps - np.rint(steps)
    assert np.abs(np.corrcoef(kicks) - np.eye(10)).max() < 0.5
    assert np.std(kicks) == pytest.approx(0.1, rel=0.1)


def test_a_surface_that_wears_does_so_in_a_run() -> None:
    measured = cm.CollectionLoop.mit("plywood-measured", accuracy=1e-6)
    run = run_strategy(measured, ALONE, 3, start=1.0)
    theta = 1.0
    for number in range(3):
        theta = cm.collection.worn_loop(measured, number).cycle(theta).theta_next
        assert run.theta[0, number + 1] == pytest.approx(theta, abs=1e-8)


@pytest.mark.parametrize("pushes", [300, 73, 5, 1])
def test_the_mean_distance_of_independent_pushes_is_de_moivres_and_shares_are_numpys(
    pushes,
) -> None:
    theta = np.random.default_rng(1).uniform(0.0, 2.0 * math.pi, (2000, pushes))
    shares = histogram_shares(theta)
    found = histogram_distances(shares)
    error = found.std() / math.sqrt(len(found))
    assert abs(found.mean() - independent_distance(pushes)) < 4.0 * error + 1e-12
    assert shares[0] == pytest.approx(np.histogram(theta[0], 36, (0.0, 2 * math.pi))[0] / pushes)


def test_steered_runs_do_what_the_next_action_says(coin_maps) -> None:
    """Without noise: the coverage and the exact maps, push by push; evener than what is drawn."""
    turns = map_turns(coin_maps, 2880)
    theta = steered_orientations(turns, 15, 1, 0.0, seed=1)[0]
    coverage = cm.resets.Coverage()
    for push in range(14):
        coverage.add(float(theta[push]))
        chosen = cm.resets.next_action(coin_maps, coverage, float(theta[push]))
        away = (theta[push + 1] - chosen.lands + math.pi) % (2 * math.pi) - math.pi
        assert abs(away) < 1e-3
    drawn = histogram_distances(histogram_shares(sampled_orientations(turns, COIN, 100, 30, 0.02)))
    steered = histogram_distances(histogram_shares(steered_orientations(turns, 100, 30, 0.02)))
    assert steered.mean() < 0.6 * drawn.mean()


EVEN = np.zeros((1, 256))


@pytest.mark.parametrize(
    ("turn", "told"),
    [
        (np.full((1, 256), np.nan), "turn must be finite"),
        (np.zeros((2, 256)), "2 rows for 1 actions"),
        (np.zeros(256), "turn must have 2 axes"),
        (np.zeros((1, 0)), r"turn has shape \(1, 0\)"),
        (None, "turn must"),
    ],
)
def test_turns_that_are_none_are_refused(turn, told) -> None:
    refused(orientation_law, turn, ALONE, 0.3, told=told)
    refused(sampled_orientations, turn, ALONE, 5, 2, 0.1, told=told)
    if "rows" not in told:
        refused(steered_orientations, turn, 5, 2, 0.1, told=told)


NO_STRATEGY = "give a ResetStrategy"


@pytest.mark.parametrize(
    ("call", "values", "told"),
    [
        (orientation_law, (EVEN, None, 0.3), "strategy is None"),
        (orientation_law, (EVEN, ALONE, 0.3, 50, 0), "at least 1"),
        (orientation_law, (EVEN, ALONE, 0.3, 50, 10.5), "whole"),
        (orientation_law, (EVEN, ALONE, 0.3, 50, 400), "too few for 400 modes"),
        (orientation_law, (np.zeros((1, 48)), ALONE, 0.3), "give 49 or more"),
        (run_strategy, (LOOP, "x", 3), NO_STRATEGY),
        (strategy_maps, (LOOP, None), NO_STRATEGY),
        (sampled_orientations, (EVEN, "x", 5, 2, 0.1), NO_STRATEGY),
        (run_strategy, (None, ALONE, 3), "CollectionLoop"),
        (strategy_maps, (None, ALONE), "CollectionLoop"),
        (run_strategy, (LOOP, ALONE, 10**9), "fewer cycles"),
        (histogram_shares, ([[np.nan, 1.0]],), "theta must be finite"),
        (histogram_shares, (np.zeros((1, 0)),), r"shape \(1, 0\)"),
        (histogram_shares, (1.0,), r"shape \(\)"),
        (histogram_distances, (np.zeros((1, 0)),), r"shape \(1, 0\)"),
        (histogram_distances, (1.0,), r"shape \(\)"),
        (independent_distance, (10**30,), "give fewer"),
        (map_turns, ([3],), "CircleMap"),
        (map_turns, (3,), "maps is 3"),
        *((map_turns, ([], bad), "samples") for bad in ("x", None, 0)),
        (map_turns, ([cm.CircleMap.rigid(0.25)], 10**12), "samples"),
    ],
)
def test_what_is_no_strategy_histogram_or_map_is_refused(call, values, told) -> None:
    refused(call, *values, told=told)


@pytest.mark.parametrize(
    ("cycles", "runs", "sigma", "seed", "told"),
    [
        (0, 1, 0.1, 0, "cycles"),
        (1, 0, 0.1, 0, "runs"),
        (10**8, 10**8, 0.1, 0, "fewer cycles"),
        (5, 2, -1.0, 0, "sigma"),
        (5, 2, np.nan, 0, "sigma"),
        (5, 2, 0.1, -1, "seed"),
    ],
)
def test_numbers_that_make_no_runs_are_refused(cycles, runs, sigma, seed, told) -> None:
    refused(sampled_orientations, EVEN, ALONE, cycles, runs, sigma, seed, told=told)
    refused(steered_orientations, EVEN, cycles, runs, sigma, seed, told=told)
    refused(run_strategy, LOOP, ALONE, cycles, runs=runs, sigma=sigma, seed=seed, told=told)


def test_lists_are_taken_for_arrays_and_the_fewest_turns_do() -> None:
    law, same = (orientation_law(turn, ALONE, 0.5) for turn in ([[2.4] * 256], EVEN + 2.4))
    assert law.total_variation == same.total_variation
    assert orientation_law(np.zeros((1, 49)), ALONE, 0.3).modes == 24
    assert [float(histogram_distances(shares)) for shares in ([0.5, 0.5], [1.0, 0.0])] == [0.0, 0.5]
