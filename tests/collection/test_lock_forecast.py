"""What the next pushes will bring, against what must be: of rotations, of a loop that locks in, of
samples of both; and what a log tells of a map, against the assumed process, a second route, and
known maps.
"""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.collection.lock_forecast import (
    DEVIATION,
    WIDTH,
    LikelyDirection,
    LockForecast,
    SeenOrientations,
    forecast_from_turns,
    sampled_paths,
    sampled_turns,
    turns_after_log,
)
from cyclemap.collection.uncertain_directions import direction_uncertainty
from cyclemap.mechanics import EllipseFriction, Material, MaterialPosterior
from cyclemap.views.sentences import ahead_sentence

SIGMA = math.radians(1.1)


def on_samples(*rows: tuple[float, float, float]) -> cm.CollectionLoop:
    """MIT's loop on samples of axes mu_a, mu_b and offset m0."""
    best = Material("slate", EllipseFriction(*rows[0]))
    told = MaterialPosterior(("mu_a", "mu_b", "m0"), rows)
    return cm.CollectionLoop.mit(replace(best, posterior=told), accuracy=1e-6)


LOCKS, TURNS = (0.2545, 0.2346, 0.0325), (0.25, 0.25, 0.0)


def test_isotropic_friction_turns_the_object_all_around_and_never_locks_in() -> None:
    """Every cycle turns by 8.0 degrees: no 50 pushes stay within 30,
    and 45 see the whole circle."""
    found = forecast_from_turns(sampled_turns(on_samples(TURNS, TURNS)), 1e-6, 60)
    assert found.chance == 0.0 and found.directions == ()
    assert found.orientations == SeenOrientations(36.0, 36.0, 36.0)


def test_a_rest_is_told_where_it_is_though_the_path_comes_there_slowly() -> None:
    """Turns of -.05 sin θ0: from 57 degrees off, a cycle leaves 95 % of the way, and within 30
    degrees of each other are fifty pushes that begin 32 degrees off.
    """
    angles = np.arange(96) * (2.0 * math.pi / 96)
    turns = np.tile(-0.05 * np.sin(angles), (2, 1))
    (told,) = forecast_from_turns(turns, 1e-6, 400, start=1.0).directions
    assert math.remainder(told.theta, 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)


def test_a_loop_that_locks_does_so_where_its_stable_direction_is() -> None:
    loop = on_samples(LOCKS, LOCKS)
    found = forecast_from_turns(sampled_turns(loop), SIGMA, 400, seed=3)
    likeliest, *rest = found.directions
    stable = direction_uncertainty(loop).directions[0].theta
    assert (
        found.chance == 1.0
        and likeliest.share > 0.9
        and sum(direction.share for direction in rest) < 0.1
        and likeliest.within < 0.3
    )
    assert stable is not None and math.remainder(
        likeliest.theta - stable, 2.0 * math.pi
    ) == pytest.approx(0.0, abs=0.1)
    assert found.orientations.upper < 36.0


def test_the_chance_is_the_share_of_samples_that_lock() -> None:
    found = forecast_from_turns(
        sampled_turns(on_samples(LOCKS, TURNS, LOCKS, TURNS, TURNS)), SIGMA, 300
    )
    assert found.samples == 5 and found.chance == pytest.approx(0.4)


def test_more_pushes_lock_in_and_see_no_less() -> None:
    loop = on_samples(LOCKS, TURNS)
    early, late = (
        forecast_from_turns(sampled_turns(loop), SIGMA, cycles, start=4.0) for cycles in (50, 400)
    )
    assert early.chance <= late.chance and np.all(
        np.array(astuple(early.orientations)) <= astuple(late.orientations)
    )


def test_portraits_and_staircases_tell_it_where_there_are_samples() -> None:
    loop = on_samples(LOCKS, LOCKS, TURNS)
    staircase = cm.collection.staircase_forecast(loop, cycles=200, tolerance=1e-4)
    assert staircase.forecast == forecast_from_turns(
        sampled_turns(loop), staircase.noise.sigma, 200
    )
    bare = replace(loop, material=replace(loop.material, posterior=None))
    assert cm.collection.staircase_forecast(bare, cycles=200, tolerance=1e-4).forecast is None


def test_what_cannot_be_foretold_is_refused() -> None:
    refused(sampled_turns, cm.CollectionLoop.mit("plywood"), told="plywood has no samples")
    refused(sampled_turns, 5, told="loop must be a CollectionLoop.*, not 5")
    turns = sampled_turns(on_samples(TURNS, TURNS))
    refused(forecast_from_turns, turns, SIGMA, 20, told="at least 50, not 20")
    refused(forecast_from_turns, turns, SIGMA, 10**6, told="forecast fewer pushes")
    refused(forecast_from_turns, turns, SIGMA, 100, math.nan, told="start must be a finite number")
    refused(forecast_from_turns, turns, SIGMA, 100, seed=-1, told="seed must be at least 0")


def test_the_sentence_tells_chance_directions_and_orientations() -> None:
    told = ahead_sentence(forecast_from_turns(sampled_turns(on_samples(TURNS, TURNS)), 1e-6, 60))
    assert told == (
        "Of all that is believed, within 60 pushes the loop locks in with a chance of less than 1%; "
        "36 of 36 orientations will have been seen (36 to 36)."
    )
    directions = LikelyDirection(1.0, 0.7, 0.1), LikelyDirection(3.0, 0.05, 2.0)
    locked = ahead_sentence(
        LockForecast(300, 0.75, directions, SeenOrientations(20.0, 9.0, 36.0), 40)
    )
    assert (
        "within 300 pushes the loop locks in with a chance of 75%, at 57° ± 6° (70%) and any "
        "direction (5%); 20 of 36" in locked
    )
    assert ahead_sentence(None) == ""


NODES = 96
THETA = 2.0 * np.pi * np.arange(NODES) / NODES
LOGGED = math.radians(1.0)
# What a long run is tried with beside the noise and the change that it was made with.
ALIKE = np.exp(-2.0 * (np.sin(0.5 * (THETA[:, None] - THETA)) / WIDTH) ** 2)


def turned(row: np.ndarray, theta: np.ndarray) -> np.ndarray:
    return np.interp(np.mod(theta, 2.0 * np.pi), [*THETA, 2.0 * np.pi], [*row, row[0]])


def run_of(row: np.ndarray, count: int, rng: np.random.Generator) -> list[float]:
    """A log of a map whose turns at the nodes are given."""
    path = [0.3]
    while len(path) <= count:
        turn = float(turned(row, np.array(path[-1])))
        path.append(path[-1] + turn + LOGGED * float(rng.standard_normal()))
    return path


def test_a_map_that_does_not_change_is_found_as_by_gaussian_regression() -> None:
    """Kalman's filter, push by push, against all pushes at once by one matrix."""
    rng = np.random.default_rng(1)
    truth = math.radians(12.0) + math.radians(5.0) * np.cos(THETA - 1.0)
    believed = np.full((1, NODES), math.radians(10.0))
    path = np.array(run_of(truth, 400, rng))
    logged = turns_after_log(believed, path.tolist(), LOGGED, 50, draws=4000)
    place = np.mod(path[:-1], 2.0 * np.pi) * NODES / (2.0 * np.pi)
    node = place.astype(int)
    rows = np.zeros((400, NODES))
    rows[np.arange(400), node] = 1.0 - (place - node)
    rows[np.arange(400), (node + 1) % NODES] += place - node
    kernel = DEVIATION**2 * ALIKE
    noise = np.mean(logged.sigma**2) * np.eye(400)
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
        logged = turns_after_log(believed, path, LOGGED, 50, draws=400, seed=world)
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
        logged = turns_after_log(believed, path[:61].tolist(), LOGGED / share, 100, draws=160)
        assert LOGGED / 2.0 <= np.median(logged.sigma) <= 2.0 * LOGGED
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
    logged = turns_after_log(samples, path, LOGGED, 50)
    assert np.abs(logged.turns - samples[2]).max() < 4.0 * DEVIATION


def test_a_jump_tells_nothing_and_whole_turns_make_no_difference() -> None:
    rng = np.random.default_rng(3)
    truth = np.full(NODES, math.radians(8.0))
    path = np.array(run_of(truth, 200, rng))
    believed = np.full((2, NODES), math.radians(7.0))
    plain = turns_after_log(believed, path.tolist(), LOGGED, 50)
    jumped = path + np.where(np.arange(len(path)) > 120, 2.5, 0.0)
    told = turns_after_log(believed, jumped.tolist(), LOGGED, 50)
    assert np.abs(told.turns.mean(axis=0) - plain.turns.mean(axis=0)).max() < math.radians(1.0)
    wrapped = turns_after_log(believed, np.mod(path, 2.0 * np.pi).tolist(), LOGGED, 50)
    assert np.allclose(wrapped.turns, plain.turns, atol=1e-9)


def test_a_map_that_changes_is_followed_and_goes_on_changing() -> None:
    """The turn grows from 4 to 12 degrees over 600 pushes: it is found as it is at the end, and
    what is ahead is less certain than what is now.
    """
    rng = np.random.default_rng(4)
    path = [0.0]
    for push in range(600):
        turn = math.radians(4.0 + 8.0 * push / 600.0)
        path.append(path[-1] + turn + LOGGED * float(rng.standard_normal()))
    logged = turns_after_log(np.full((1, NODES), math.radians(4.0)), path, LOGGED, 200)
    assert abs(math.degrees(logged.turns.mean()) - 12.0) < 1.0
    assert logged.change.std() > math.radians(0.3)
    ends = sampled_paths(logged.turns, logged.sigma, 200, path[-1], change=logged.change)[-1]
    still = sampled_paths(logged.turns, logged.sigma, 200, path[-1])[-1]
    assert ends.std() > still.std()


def test_a_log_of_one_orientation_leaves_what_is_believed() -> None:
    believed = np.radians([[1.0], [3.0]]) + np.zeros((2, NODES))
    logged = turns_after_log(believed, [1.0], LOGGED, 50, draws=4000)
    assert np.median(logged.sigma) == LOGGED
    assert logged.turns.mean() == pytest.approx(math.radians(2.0), abs=math.radians(0.3))
    assert logged.turns.std() == pytest.approx(math.hypot(DEVIATION, math.radians(1.0)), rel=0.1)


def test_two_turns_do_not_tell_the_noise() -> None:
    """Two turns of a loop that rests, each beyond the noise: with twice the noise it would never
    rest, but that is one of those that two turns leave.
    """
    sigma = math.radians(6.0)
    rest = -np.radians(15.0) * np.sin(THETA)
    path = np.radians([0.0, 10.0, -3.0])
    logged = turns_after_log(rest[None], path, sigma, 300)
    low, high = np.quantile(logged.sigma, (0.1, 0.9))
    assert low <= sigma and 2.0 * sigma <= high
    ahead = forecast_from_turns(logged.turns, logged.sigma, 300, path[-1], change=logged.change)
    assert 0.1 < ahead.chance < 0.9


def test_each_sample_may_have_a_noise_of_its_own() -> None:
    """One sample without noise to speak of, one with 3 degrees a push."""
    noise = np.array([1e-9, math.radians(3.0)])
    ends = sampled_paths(np.zeros((2, NODES)), noise, 100)[-1]
    still, noisy = np.split(ends, 2)
    assert np.abs(still).max() < 1e-6
    assert noisy.std() == pytest.approx(10.0 * noise[1], rel=0.2)
    for wrong in (noise[:1], -noise, noise[:, None]):
        refused(sampled_paths, np.zeros((2, NODES)), wrong, 100, told="sigma")


def test_what_makes_no_sense_is_refused() -> None:
    rows = np.zeros((2, NODES))
    refused(turns_after_log, rows[0], [0.0, 1.0], LOGGED, 50, told="turns must be .samples, nodes.")
    refused(turns_after_log, rows, [0.0, math.nan], LOGGED, 50, told="path")
    refused(turns_after_log, rows, [0.0, 1.0], -1.0, 50, told="sigma")
    refused(turns_after_log, rows, [0.0, 1.0], LOGGED, 0, told="pushes ahead")
    refused(turns_after_log, rows, [0.0, 1.0], LOGGED, 50, draws=10**12, told="fewer draws")
    for path in (0.0, [[0.0, 1.0], [0.0, 1.0]]):
        refused(turns_after_log, rows, path, LOGGED, 50, told="path must have 1 axes")
    refused(turns_after_log, rows[:0], [0.0], LOGGED, 50, told="turns must be .samples, nodes.")
    for turns in (rows[0], rows[:0], rows[:, :1]):
        refused(sampled_paths, turns, LOGGED, 50, told="turns must be .samples, nodes.")
    refused(sampled_paths, rows + math.nan, LOGGED, 50, told="turns must be finite")
    refused(sampled_paths, rows, LOGGED, 50, change=rows[:1], told="change must have the shape of")
    refused(sampled_paths, rows, LOGGED, 50, change=rows + math.nan, told="change must be finite")
