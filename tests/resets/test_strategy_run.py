"""Runs by the mechanics and from sampled maps are the same collections; histograms lie as far from
uniform as told.
"""

import math

import numpy as np
import pytest

import cyclemap as cm
from cyclemap.resets import (
    CycleAction,
    ResetStrategy,
    histogram_distances,
    histogram_shares,
    independent_distance,
    map_turns,
    run_strategy,
    sampled_orientations,
    steered_orientations,
    strategy_maps,
)

LOOP = cm.CollectionLoop.mit(accuracy=1e-6)
COIN = ResetStrategy.pushes(LOOP.push, (1, 2))
TURNING = ResetStrategy((CycleAction(), CycleAction(turn=2.0)))


def test_a_run_is_cycle_after_cycle_of_what_is_drawn() -> None:
    run = run_strategy(LOOP, TURNING, 6, start=0.3, sigma=0.0, seed=4)
    theta = 0.3
    for number, action in enumerate(TURNING.run(6, 4)):
        theta = action.on(LOOP).cycle(theta).theta_next + action.turn
        assert run.theta[0, number + 1] == pytest.approx(theta, abs=1e-8)


def test_runs_from_sampled_maps_follow_the_mechanics() -> None:
    """Two routes to the same paths, until what is between the samples has grown."""
    turns = map_turns(strategy_maps(LOOP, COIN), 1440)
    sampled = sampled_orientations(turns, COIN, 20, 5, 0.02, seed=3, start=1.0)
    run = run_strategy(LOOP, COIN, 19, runs=5, start=1.0, sigma=0.02, seed=3)
    assert run.action.shape == (5, 19) and len({tuple(row) for row in run.action.tolist()}) == 5
    # The noise is drawn for as many cycles as there are.
    first = run_strategy(LOOP, COIN, 20, runs=5, start=1.0, sigma=0.02, seed=3)
    assert sampled == pytest.approx(first.theta[:, :-1], abs=5e-3)


def test_runs_and_seeds_are_drawn_by_themselves() -> None:
    """Turns of 1 and 2 rad and some noise: what was done and what was kicked are other in every run
    and seed.
    """
    turns = np.array([np.full(8, 1.0), np.full(8, 2.0)])
    strategy = ResetStrategy((CycleAction(), CycleAction(turn=1.0)))
    found = [sampled_orientations(turns, strategy, 61, 5, 0.1, seed=seed) for seed in (1, 2)]
    steps = np.diff(np.concatenate(found), axis=1)
    assert len({tuple(row) for row in np.rint(steps).tolist()}) == 10
    kicks = np.corrcoef(steps - np.rint(steps))
    assert np.abs(kicks - np.eye(10)).max() < 0.5
    assert np.std(steps - np.rint(steps)) == pytest.approx(0.1, rel=0.1)


def test_a_surface_that_wears_does_so_in_a_run() -> None:
    measured = cm.CollectionLoop.mit("plywood-measured", accuracy=1e-6)
    own = ResetStrategy((CycleAction(),))
    run = run_strategy(measured, own, 3, start=1.0)
    theta = 1.0
    for number in range(3):
        theta = cm.collection.worn_loop(measured, number).cycle(theta).theta_next
        assert run.theta[0, number + 1] == pytest.approx(theta, abs=1e-8)


@pytest.mark.parametrize("pushes", [500, 73, 5, 1])
def test_the_mean_distance_of_independent_pushes_is_de_moivres_and_shares_are_numpys(
    pushes,
) -> None:
    theta = np.random.default_rng(1).uniform(0.0, 2.0 * math.pi, (4000, pushes))
    shares = histogram_shares(theta)
    found = histogram_distances(shares)
    error = found.std() / math.sqrt(len(found))
    assert abs(found.mean() - independent_distance(pushes)) < 4.0 * error + 1e-12
    assert shares[0] == pytest.approx(np.histogram(theta[0], 36, (0.0, 2 * math.pi))[0] / pushes)


def test_steered_runs_do_what_the_next_action_says() -> None:
    """Without noise: the monitor's coverage and the exact maps, push by push; evener than what is
    drawn.
    """
    maps = strategy_maps(LOOP, COIN)
    turns = map_turns(maps, 2880)
    theta = steered_orientations(turns, 15, 1, 0.0, seed=1)[0]
    coverage = cm.resets.Coverage()
    for push in range(14):
        coverage.add(float(theta[push]))
        chosen = cm.resets.next_action(maps, coverage, float(theta[push]))
        away = (theta[push + 1] - chosen.lands + math.pi) % (2 * math.pi) - math.pi
        assert abs(away) < 1e-3
    drawn = histogram_distances(histogram_shares(sampled_orientations(turns, COIN, 200, 30, 0.02)))
    steered = histogram_distances(histogram_shares(steered_orientations(turns, 200, 30, 0.02)))
    assert steered.mean() < 0.6 * drawn.mean()
