"""Searches over parameters: closed-form optima, brute force, limits that bind, and demands that nothing meets."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.parameters.parameter_families import gripper_family
from cyclemap.resets.parameters.parameter_gradient import Resolution, StrategyEvaluator
from cyclemap.resets.parameters.parameter_search import search_parameters
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.strategies.push_strategies import DrawnPushes

SHORT = SidePush(distance=0.06)
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT, accuracy=1e-6)
PLYWOOD = CollectionLoop.mit("plywood", push=SHORT, accuracy=1e-6)
NOISE = WrappedNormal(0.2)
WIDE = WrappedNormal(0.8)  # so wide that the first harmonic is always the slowest
COARSE = Resolution(samples=8, modes=16, nodes=4, pushes=5)
# The first push as it is, the second's distance free.
SECOND = StrategyFamily(
    "second push",
    ("distance",),
    (0.03,),
    (0.12,),
    lambda v: DrawnPushes((SHORT, SidePush(2, distance=v[0]))),
)


def test_the_least_spread_of_a_gripper_solves_its_equation():
    """Least halfwidth h with |lambda_2| = kappa_1 sin(h)/h at most 0.5: that equation's root, the limit binds, and its
    price is 1/|d lambda/dh|."""
    size = Resolution(samples=8, modes=12, nodes=64, pushes=2)
    limits = {"second_eigenvalue": 0.5}
    found = search_parameters(EVEN, gripper_family(), NOISE, "halfwidth", limits, starts=2, resolution=size)
    kappa = float(NOISE.coefficients(1))
    root = brentq(lambda h: kappa * math.sin(h) / h - 0.5, 0.5, 3.0)
    assert found.feasible and not found.exceeded and found.converged and found.binding == ("second_eigenvalue",)
    assert abs(float(found.values[0]) - root) < 2e-4 and found.stationarity < 1e-6
    slope = kappa * (math.cos(root) / root - math.sin(root) / root**2)
    assert abs(found.prices["second_eigenvalue"] + 1.0 / slope) < 1e-2
    assert found.confirmed and found.disagreement < 1e-3 and len(found.runs) == 2
    assert found.strategy.turn.high == found.values[0]


def test_the_cheapest_second_push_is_just_long_enough_to_mix():
    """Least drag with |lambda_2| at most 0.5: a longer second push mixes more and is dragged back further, so that the
    length is the root of the limit, found here by bisection of scores alone; adaptive maps agree to 1e-4."""
    limits = {"second_eigenvalue": 0.5}
    found = search_parameters(EVEN, SECOND, WIDE, "mean_drag_length", limits, starts=1, resolution=COARSE)
    evaluator = StrategyEvaluator(EVEN, SECOND, WIDE, COARSE)
    root = brentq(lambda distance: evaluator.value_at((distance,))[2] - 0.5, 0.06, 0.09, xtol=1e-6)
    assert abs(float(found.values[0]) - root) < 2e-5 and found.binding == ("second_eigenvalue",)
    assert found.disagreement < 1e-4 and found.confirmed and found.evaluations < 15


def test_a_search_is_no_worse_than_brute_force_and_the_same_for_the_same_seed():
    """The place of the second of two pushes on plywood: 7 places tried one by one."""
    family = StrategyFamily(
        "second push",
        ("fraction",),
        (0.2,),
        (0.8,),
        lambda v: DrawnPushes((SidePush(1, distance=0.06), SidePush(3, v[0], distance=0.06))),
    )
    options = {"resolution": COARSE, "check": False, "starts": 2}
    found = search_parameters(PLYWOOD, family, NOISE, iterations=12, **options)
    evaluator = StrategyEvaluator(PLYWOOD, family, NOISE, COARSE)
    tried = [evaluator.value_at((place,))[0] for place in np.linspace(0.2, 0.8, 7).tolist()]
    assert found.best.score("total_variation") <= min(tried) + 1e-4 and max(tried) > 1.2 * min(tried)
    assert found.checked is None and not found.confirmed and found.disagreement == math.inf
    one, two = (search_parameters(PLYWOOD, family, NOISE, iterations=1, **options) for _ in range(2))
    assert one.values.tolist() == two.values.tolist() and one.evaluations == two.evaluations
    assert [run.begin.tolist() for run in one.runs] == [run.begin.tolist() for run in two.runs]


def test_a_demand_that_nothing_meets_is_answered_by_what_exceeds_it_least():
    """|lambda_2| of a narrow gripper cannot fall to 0.1: the widest comes nearest, and is at its bound."""
    size = Resolution(samples=8, modes=12, nodes=64, pushes=2)
    limits = {"second_eigenvalue": 0.1}
    found = search_parameters(
        EVEN, gripper_family((0.1, 0.5)), NOISE, "mean_drag_length", limits, starts=1, resolution=size
    )
    assert not found.feasible and not found.confirmed and found.exceeded == ("second_eigenvalue",)
    assert abs(float(found.values[0]) - 0.5) < 1e-9


def test_a_wider_range_is_never_worse_and_a_bound_that_binds_is_named():
    """Least |lambda_2| over the gripper's spread h: kappa_1 sin(h)/h falls up to pi, so that the range is used up."""
    size = Resolution(samples=8, modes=12, nodes=64, pushes=2)
    narrow, wide = (
        search_parameters(
            EVEN, gripper_family((0.1, top)), NOISE, "second_eigenvalue", starts=1, resolution=size, check=False
        )
        for top in (1.0, 2.0)
    )
    assert narrow.binding == ("halfwidth",) and abs(float(narrow.values[0]) - 1.0) < 1e-9
    assert wide.best.score("second_eigenvalue") < narrow.best.score("second_eigenvalue")


def test_what_cannot_be_run_is_told_where_nothing_can():
    family = StrategyFamily("no side", ("f",), (0.2,), (0.8,), lambda v: DrawnPushes((SidePush(7, v[0]),)))
    with pytest.raises(InvalidInput, match="side"):
        search_parameters(EVEN, family, NOISE, starts=1, resolution=COARSE)


def test_bad_demands_are_refused():
    with pytest.raises(InvalidInput, match="'bias'"):
        search_parameters(EVEN, gripper_family(), NOISE, "bias")
    with pytest.raises(InvalidInput, match="limit of reach must be positive"):
        search_parameters(EVEN, gripper_family(), NOISE, limits={"reach": 0.0})
    with pytest.raises(InvalidInput, match="'cost'"):
        search_parameters(EVEN, gripper_family(), NOISE, limits={"cost": 1.0})
    with pytest.raises(InvalidInput, match="starts must be at least 1"):
        search_parameters(EVEN, gripper_family(), NOISE, starts=0)
