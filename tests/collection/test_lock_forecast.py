"""What the next pushes will bring, against what must be: of rotations, of a loop that locks in, of
samples of both.
"""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.collection.lock_forecast import (
    LikelyDirection,
    LockForecast,
    SeenOrientations,
    forecast_from_turns,
    sampled_turns,
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
