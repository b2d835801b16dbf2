"""What a log tells of a map, against the assumed process, a second route, and known maps."""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.lock_forecast import (
    DEVIATION,
    WIDTH,
    forecast_from_turns,
    sampled_paths,
    turns_after_log,
)

NODES = 96
THETA = 2.0 * np.pi * np.arange(NODES) / NODES
SIGMA = math.radians(1.0)
# What a long run is tried with beside the noise and the change that it was made with.
ALIKE = np.exp(-2.0 * (np.sin(0.5 * (THETA[:, None] - THETA)) / WIDTH) ** 2)


def turned(row: np.ndarray, theta: np.ndarray) -> np.ndarray:
    return np.interp(np.mod(theta, 2.0 * np.pi), [*THETA, 2.0 * np.pi], [*row, row[0]])


def run_of(row: np.ndarray, count: int, rng: np.random.Generator) -> list[float]:
    """A log of a map whose turns at the nodes are given."""
    path = [0.3]
    while len(path) <= count:
        turn = float(turned(row, np.array(path[-1])))
        path.append(path[-1] + turn + SIGMA * float(rng.standard_normal()))
    return path


def test_a_map_that_does_not_change_is_found_as_by_gaussian_regression() -> None:
    """Kalman's filter, push by push, against all pushes at once by one matrix."""
    rng = np.random.default_rng(1)
    truth = math.radians(12.0) + math.radians(5.0) * np.cos(THETA - 1.0)
    believed = np.full((1, NODES), math.radians(10.0))
    path = np.array(run_of(truth, 400, rng))
    logged = turns_after_log(believed, path.tolist(), SIGMA, 50, draws=4000)
    place = np.mod(path[:-1], 2.0 * np.pi) * NODES / (2.0 * np.pi)
    node = place.astype(int)
    rows = np.zeros((400, NODES))
    rows[np.arange(400), node] = 1.0 - (place - node)
    rows[np.arange(400), (node + 1) % NODES] += place - node
    kernel = DEVIATION**2 * ALIKE
    noise = logged.sigma**2 * np.eye(400)
    missed = np.diff(path) - rows @ believed[0]
    mean = believed[0] + kernel @ rows.T @ np.linalg.solve(rows @ kernel @ rows.T + noise, missed)
    found = logged.turns.mean(axis=0)
    assert np.abs(found - mean).max() < math.radians(0.25)
    assert np.abs(found - truth).max() < math.radians(0.6)


def test_intervals_hold_the_map_where_the_log_has_been_and_where_it_has_not() -> None:
    """Of 25 maps drawn as it is assumed, nine tenths of all turns within 90 % intervals."""
    root = np.linalg.cholesky(ALIKE + 1e-9 * np.eye(NODES))
    believed = np.zeros((3, NODES)) + np.radians([[2.0], [6.0], [10.0]])
    inside = []
    for world in range(25):
        rng = np.random.default_rng([5, world])
        truth = believed[rng.integers(3)] + DEVIATION * root @ rng.standard_normal(NODES)
        path = run_of(truth, 80, rng)
        logged = turns_after_log(believed, path, SIGMA, 50, draws=400, seed=world)
        low, high = np.quantile(logged.turns, (0.05, 0.95), axis=0)
        inside.append(np.mean((truth > low) & (truth < high)))
    assert 0.83 < np.mean(inside) < 0.96


@pytest.mark.parametrize("share", [0.25, 4.0])
def test_the_log_tells_its_noise_where_another_is_believed(share: float) -> None:
    """Of a loop that rests, the orientations still to be seen are within their 90 % intervals."""
    rest = -np.radians(15.0) * np.sin(THETA - 1.0)
    held = []
    for world in range(10):
        rng = np.random.default_rng([6, world])
        path = np.array(run_of(rest, 160, rng))
        believed = rest + np.radians([[-2.0], [2.0]])
        logged = turns_after_log(believed, path[:61].tolist(), SIGMA / share, 100, draws=160)
        assert SIGMA / 2.0 <= logged.sigma <= 2.0 * SIGMA
        ahead = forecast_from_turns(
            logged.turns, logged.sigma, 100, float(path[60]), change=logged.change
        ).orientations
        seen = len(set(np.floor(np.degrees(np.mod(path[60:], 2.0 * np.pi)) / 10.0)))
        held.append(ahead.lower <= seen <= ahead.upper)
    assert sum(held) >= 8


def test_the_log_tells_which_sample_made_it() -> None:
    """Samples further apart than the deviation: draws come from the one that made the log."""
    samples = np.radians(np.array([-60.0, 0.0, 60.0]))[:, None] + np.zeros((3, NODES))
    path = run_of(samples[2], 30, np.random.default_rng(2))
    logged = turns_after_log(samples, path, SIGMA, 50)
    assert np.abs(logged.turns - samples[2]).max() < 4.0 * DEVIATION


def test_a_jump_tells_nothing_and_whole_turns_make_no_difference() -> None:
    rng = np.random.default_rng(3)
    truth = np.full(NODES, math.radians(8.0))
    path = np.array(run_of(truth, 200, rng))
    believed = np.full((2, NODES), math.radians(7.0))
    plain = turns_after_log(believed, path.tolist(), SIGMA, 50)
    jumped = path + np.where(np.arange(len(path)) > 120, 2.5, 0.0)
    told = turns_after_log(believed, jumped.tolist(), SIGMA, 50)
    assert np.abs(told.turns.mean(axis=0) - plain.turns.mean(axis=0)).max() < math.radians(1.0)
    wrapped = turns_after_log(believed, np.mod(path, 2.0 * np.pi).tolist(), SIGMA, 50)
    assert np.allclose(wrapped.turns, plain.turns, atol=1e-9)


def test_a_map_that_changes_is_followed_and_goes_on_changing() -> None:
    """The turn grows from 4 to 12 degrees over 600 pushes: it is found as it is at the end, and
    what is ahead is less certain than what is now.
    """
    rng = np.random.default_rng(4)
    path = [0.0]
    for push in range(600):
        turn = math.radians(4.0 + 8.0 * push / 600.0)
        path.append(path[-1] + turn + SIGMA * float(rng.standard_normal()))
    logged = turns_after_log(np.full((1, NODES), math.radians(4.0)), path, SIGMA, 200)
    assert abs(math.degrees(logged.turns.mean()) - 12.0) < 1.0
    assert logged.change.std() > math.radians(0.3)
    ends = sampled_paths(logged.turns, logged.sigma, 200, path[-1], change=logged.change)[-1]
    still = sampled_paths(logged.turns, logged.sigma, 200, path[-1])[-1]
    assert ends.std() > still.std()


def test_a_log_of_one_orientation_leaves_what_is_believed() -> None:
    believed = np.radians([[1.0], [3.0]]) + np.zeros((2, NODES))
    logged = turns_after_log(believed, [1.0], SIGMA, 50, draws=4000)
    assert logged.sigma == SIGMA
    assert logged.turns.mean() == pytest.approx(math.radians(2.0), abs=math.radians(0.3))
    assert logged.turns.std() == pytest.approx(math.hypot(DEVIATION, math.radians(1.0)), rel=0.1)


def test_what_makes_no_sense_is_refused() -> None:
    rows = np.zeros((2, NODES))
    refused(turns_after_log, rows[0], [0.0, 1.0], SIGMA, 50, told="turns must be .samples, nodes.")
    refused(turns_after_log, rows, [0.0, math.nan], SIGMA, 50, told="path")
    refused(turns_after_log, rows, [0.0, 1.0], -1.0, 50, told="sigma")
    refused(turns_after_log, rows, [0.0, 1.0], SIGMA, 0, told="pushes ahead")
    refused(turns_after_log, rows, [0.0, 1.0], SIGMA, 50, draws=10**12, told="fewer draws")
    for path in (0.0, [[0.0, 1.0], [0.0, 1.0]]):
        refused(turns_after_log, rows, path, SIGMA, 50, told="path must have 1 axes")
    refused(turns_after_log, rows[:0], [0.0], SIGMA, 50, told="turns must be .samples, nodes.")
    for turns in (rows[0], rows[:0], rows[:, :1]):
        refused(sampled_paths, turns, SIGMA, 50, told="turns must be .samples, nodes.")
    refused(sampled_paths, rows + math.nan, SIGMA, 50, told="turns must be finite")
    refused(sampled_paths, rows, SIGMA, 50, change=rows[:1], told="change must have the shape of")
    refused(sampled_paths, rows, SIGMA, 50, change=rows + math.nan, told="change must be finite")
