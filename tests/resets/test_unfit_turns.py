"""What is no turn, strategy, histogram or map is refused in one line."""

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
    orientation_law,
    run_strategy,
    sampled_orientations,
    steered_orientations,
    strategy_maps,
)
from tests.refusals import refused

LOOP = cm.CollectionLoop.mit(accuracy=1e-6)
ALONE = ResetStrategy((CycleAction(),))
EVEN = np.zeros((1, 256))
BAD_TURNS = [
    (np.full((1, 256), np.nan), "turn must be finite"),
    (np.zeros((2, 256)), "2 rows for 1 actions"),
    (np.zeros(256), "turn must have 2 axes"),
    (np.zeros((1, 0)), r"turn has shape \(1, 0\)"),
    (None, "turn must"),
]


@pytest.mark.parametrize(("turn", "told"), BAD_TURNS)
def test_turns_that_are_none_are_refused(turn, told) -> None:
    refused(orientation_law, turn, ALONE, 0.3, told=told)
    refused(sampled_orientations, turn, ALONE, 5, 2, 0.1, told=told)
    if "rows" not in told:
        refused(steered_orientations, turn, 5, 2, 0.1, told=told)


def test_a_law_takes_lists_and_no_other_strategy_or_modes() -> None:
    law = orientation_law([[2.4] * 256], ALONE, 0.5)
    assert (
        law.total_variation == orientation_law(np.full((1, 256), 2.4), ALONE, 0.5).total_variation
    )
    refused(orientation_law, EVEN, None, 0.3, told="strategy is None")
    for modes, told in ((0, "at least 1"), (10.5, "whole"), (400, "too few for 400 modes")):
        refused(orientation_law, EVEN, ALONE, 0.3, modes=modes, told=told)
    for few in (8, 48):
        refused(orientation_law, np.zeros((1, few)), ALONE, 0.3, told="give 49 or more")
    assert orientation_law(np.zeros((1, 49)), ALONE, 0.3).modes == 24


def test_runs_by_what_is_no_strategy_loop_or_number_are_refused() -> None:
    for strategy in (None, "x"):
        refused(run_strategy, LOOP, strategy, 3, sigma=0.01, seed=1, told="give a ResetStrategy")
        refused(strategy_maps, LOOP, strategy, told="give a ResetStrategy")
        refused(sampled_orientations, EVEN, strategy, 5, 2, 0.1, told="give a ResetStrategy")
    refused(run_strategy, None, ALONE, 3, told="CollectionLoop")
    refused(strategy_maps, None, ALONE, told="CollectionLoop")
    refused(run_strategy, LOOP, ALONE, 3, seed=-1, told="seed")
    refused(run_strategy, LOOP, ALONE, 10**9, told="fewer cycles")
    for bad in (-1.0, np.nan):
        refused(sampled_orientations, EVEN, ALONE, 5, 2, bad, told="sigma")
        refused(steered_orientations, EVEN, 5, 2, bad, told="sigma")
    for cycles, runs, told in ((0, 1, "cycles"), (1, 0, "runs"), (10**8, 10**8, "fewer cycles")):
        refused(sampled_orientations, EVEN, ALONE, cycles, runs, 0.1, told=told)
        refused(steered_orientations, EVEN, cycles, runs, 0.1, told=told)


def test_histograms_of_nothing_are_refused() -> None:
    refused(histogram_shares, [[np.nan, 1.0]], told="theta must be finite")
    for ask in (histogram_shares, histogram_distances):
        refused(ask, np.zeros((1, 0)), told=r"shape \(1, 0\)")
        refused(ask, 1.0, told=r"shape \(\)")
    assert histogram_distances([0.5, 0.5]) == 0.0
    assert histogram_distances([1.0, 0.0]) == 0.5
    refused(independent_distance, 10**30, told="give fewer")


def test_turns_of_what_is_no_map_are_refused() -> None:
    refused(map_turns, [3], told="CircleMap")
    refused(map_turns, 3, told="maps is 3")
    for bad in ("x", None, 0, 10**12):
        refused(map_turns, [cm.CircleMap.rigid(0.25)], bad, told="samples")
