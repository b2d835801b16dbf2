"""The library of pushes: its operators and drags are those of the strategies, and what cannot be made is named."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.mechanics import EllipseFriction, Material, SidePush, Slider
from cyclemap.resets.drawn_pushes.push_library import PushLibrary, push_library
from cyclemap.resets.drawn_pushes.push_mixture import PushMixture
from cyclemap.resets.drawn_pushes.push_weights import best_push_weights
from cyclemap.resets.strategies.action_cost import strategy_cost
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import TrailingLeg
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.resets.strategies.strategy_maps import strategy_maps

SHORT = SidePush(distance=0.05)  # a short push is a quick one
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT)
PLYWOOD = CollectionLoop.mit("plywood", push=SHORT)
SLIPS = SidePush(0, 0.95, math.radians(-60.0), 0.05)
COARSE = {"modes": 16, "tolerance": 1e-2, "noise": WrappedNormal(0.3)}


@pytest.fixture(scope="module")
def library():
    """Two pushes on two loops, and one that slips off."""
    pushes = (SHORT, SidePush(2, 0.3, 0.2, 0.05), SLIPS)
    seen = []
    made = push_library([EVEN, PLYWOOD], pushes, progress=seen.append, **COARSE)
    assert seen == [1 / 3, 2 / 3, 1.0]
    return made


def test_what_slips_off_is_left_out_and_named(library):
    assert len(library.pushes) == 2 and len(library.left_out) == 1
    assert library.left_out[0].push == SLIPS and library.left_out[0].loop == 0
    assert "loses the object" in library.left_out[0].reason


def test_the_matrices_are_those_of_the_strategys_own_maps(library):
    made = strategy_maps(PLYWOOD, DrawnPushes(library.pushes), tolerance=1e-2)
    chances = np.array([0.3, 0.7])
    own = mixture_operator(made.maps, chances, COARSE["noise"], 16).discretisation.matrix
    assert np.abs(PushMixture(library.matrices[1]).matrix(chances) - own).max() < 1e-9
    joined = library.random_map(1, [0, 1], [3.0, 7.0])
    assert (
        np.abs(mixture_operator(joined.maps, joined.weights, joined.noise, 16).discretisation.matrix - own).max() < 1e-9
    )


def test_drags_are_those_that_the_cost_of_the_strategy_tells(library):
    cost = strategy_cost(PLYWOOD, library.strategy([0, 1], [1.0, 3.0]), orientations=24)
    assert abs(library.mean_drags[1] @ [0.25, 0.75] - cost.mean_drag_length) < 2e-4
    assert library.drag_lengths.shape == (2, 2, 72) and library.reach(0).shape == (2,)
    assert abs(library.reach(0)[1] - strategy_cost(PLYWOOD, DrawnPushes((SHORT,))).reach) < 1e-12


def test_on_an_even_surface_every_push_is_a_rotation_and_every_weight_even(library):
    mixture, rng = PushMixture(library.matrices[0]), np.random.default_rng(0)
    biases = [mixture.bias(weights)[0] for weights in rng.dirichlet(np.ones(2), 5)]
    assert len(biases) == 5 and max(biases) < 1e-3
    assert np.ptp(library.drag_lengths[0], axis=1).max() < 1e-5 < np.ptp(library.drag_lengths[1], axis=1).max()


def test_legs_are_averaged_over_their_law():
    """A leg in a uniformly random direction: the mean of its nodes' operators; on an even surface it leaves no bias."""
    legs = TrailingLeg(0.04)
    made = push_library(EVEN, [SHORT], legs=legs, nodes=8, **COARSE)
    maps = strategy_maps(EVEN, combine(DrawnPushes((SHORT,)), legs), nodes=8, tolerance=1e-2)
    own = mixture_operator(maps.maps, maps.weights, COARSE["noise"], 16).discretisation.matrix
    assert np.abs(made.matrices[0, 0] - own).max() < 1e-9 and len(made.random_maps[0][0].maps) == 8
    found = best_push_weights(made, allow_tv=0.01)
    assert found.met and found.strategy() == combine(DrawnPushes((SHORT,), weights=(1.0,)), legs)
    # The leg adds its own length to the drag, there and back.
    assert made.mean_drags[0, 0] > push_library(EVEN, [SHORT], **COARSE).mean_drags[0, 0] + 0.04


def test_the_grid_is_every_side_fraction_angle_and_distance():
    triangle = CollectionLoop.mit(EVEN.material, slider=Slider.mit("tri1"), push=SHORT)
    options = {"fractions": (0.5,), "distances": (0.01,), "least_travel": 0.0} | COARSE
    made = push_library(triangle, **options)
    assert [push.side for push in made.pushes] == [0, 1, 2] and not made.left_out
    assert {(push.fraction, push.angle, push.distance) for push in made.pushes} == {(0.5, 0.0, 0.01)}


def test_a_reach_too_small_for_a_push_leaves_it_out(library):
    reaches = [library.reach(i).max() for i in (0, 1)]
    between = float(np.mean(reaches))
    found = best_push_weights(library, allow_tv=0.9, reach_limit=between, starts=1)
    assert found.numbers == (int(np.argmin(reaches)),) and "reach" in found.limiting and found.reach.max() < between
    with pytest.raises(InvalidInput, match="every push needs more room"):
        best_push_weights(library, allow_tv=0.9, reach_limit=0.05)


def test_a_part_of_a_library_is_the_same_pushes_alone(library):
    part = library.only([1])
    assert part.pushes == library.pushes[1:] and np.array_equal(part.matrices, library.matrices[:, 1:])
    assert np.array_equal(part.mean_drags, library.mean_drags[:, 1:]) and part.loops == library.loops


@pytest.mark.parametrize("numbers", [[9], [-1], [0.5]])
def test_a_part_of_pushes_that_are_not_there_is_refused(library, numbers):
    with pytest.raises(InvalidInput, match="number of a push"):
        library.only(numbers)


@pytest.mark.parametrize(
    ("pushes", "message"),
    [([], "one or more"), ([0.7], "one or more"), ([SLIPS], "none of the 1 pushes"), ([SidePush(7)], "none of the 1")],
)
def test_without_a_push_there_is_no_library(pushes, message):
    with pytest.raises(InvalidInput, match=message):
        push_library(EVEN, pushes, **COARSE)


def test_what_does_not_fit_is_refused():
    with pytest.raises(InvalidInput, match="loops"):
        push_library(["plywood"], [SHORT])
    with pytest.raises(InvalidInput, match="least_travel"):
        push_library(EVEN, [SHORT], least_travel=-1.0)
    turn = CircleMap.rigid(0.1)
    for rows, lengths, message in (
        ([], np.ones((0, 1)), "one random map"),
        ([[turn], [turn, turn]], [[0.1], [0.1]], "one random map"),
        ([[turn]], [[0.1, 0.2]], "drag_lengths"),
        ([[turn]], [[-0.1]], "drag_lengths"),
    ):
        with pytest.raises(InvalidInput, match=message):
            PushLibrary.of_maps(rows, WrappedNormal(0.1), lengths, 8)
