"""Interpolated families of loops: exact at their nodes, close between them, and one function in all
their forms.
"""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.errors import ConvergenceError
from cyclemap.figures.loop_family import (
    LoopFamily,
    chebyshev_nodes,
    loop_family,
    ring_fold,
    ring_radius,
    with_anisotropy_times,
    with_ring_at,
)

PLYWOOD = replace(CollectionLoop.mit(material="plywood"), accuracy=1e-6)
RINGS = partial(with_ring_at, PLYWOOD)


@pytest.fixture(scope="module")
def family() -> LoopFamily:
    return loop_family(RINGS, ((0.0095, 0.0105),), (3,), 24)


def test_at_its_nodes_the_family_is_the_cycles_that_were_run(family) -> None:
    theta = 2 * np.pi * np.arange(24)[::5] / 24
    errors = [family.error_at(theta, r).max() for r in chebyshev_nodes(0.0095, 0.0105, 3)]
    assert len(errors) == 3
    assert max(errors) < 1e-10


def test_between_its_nodes_the_family_is_within_a_twentieth_of_a_degree_and_nearer_with_more_angles(
    family,
) -> None:
    theta = np.linspace(0.1, 6.2, 13)
    coarse = loop_family(RINGS, ((0.0095, 0.0105),), (3,), 12).error_at(theta, 0.0098).max()
    assert family.error_at(theta, 0.0098).max() < 0.5 * coarse < 0.5 * math.radians(0.05)


def test_array_scalar_slope_and_parametric_form_are_one_function(family) -> None:
    theta, radius = np.linspace(-1.0, 7.0, 9), 0.0099
    member, slow = family(radius), family.parametric
    assert np.allclose(member(theta), theta + family.turn(theta, radius), atol=1e-13)
    assert member.scalar()(2.0) == pytest.approx(float(member(2.0)), abs=1e-13)
    assert np.allclose(slow.lift(theta, np.full(9, radius)), member(theta), atol=1e-13)
    step = 1e-5
    slopes = (member(theta + step) - member(theta - step)) / (2 * step)
    assert np.allclose(member.derivative(theta), slopes, atol=1e-8)
    assert np.allclose(family.slope(theta, np.full(9, radius)), slopes, atol=1e-8)


def test_two_parameters_agree_with_one(family) -> None:
    both = loop_family(
        lambda radius, scale: with_anisotropy_times(RINGS(radius), scale),
        ((0.0095, 0.0105), (0.5, 1.0)),
        (3, 2),
        24,
    )
    theta = np.linspace(0.0, 6.0, 7)
    assert both.coefficients.shape == (3, 2, 13)
    assert np.allclose(both.turn(theta, 0.0101, 1.0), family.turn(theta, 0.0101), atol=1e-9)


def test_the_ring_moves_on_its_ray_and_no_anisotropy_leaves_a_rotation() -> None:
    moved = with_ring_at(PLYWOOD, 0.010)
    assert ring_radius(moved) == pytest.approx(0.010)
    assert moved.slider.hitch[0] == pytest.approx(-moved.slider.hitch[1])
    turns = with_anisotropy_times(PLYWOOD, 0.0).next_theta([0.0, 1.0, 4.0]) - [0.0, 1.0, 4.0]
    assert np.ptp(turns) < 1e-7
    same = with_anisotropy_times(PLYWOOD, 1.0).cycle(1.0).theta_next
    assert same == pytest.approx(PLYWOOD.cycle(1.0).theta_next, abs=1e-9)


def test_a_fold_of_the_mechanics_is_a_touch_of_the_diagonal() -> None:
    """At the fold cycles move by nothing to first order, and its bend and rate are those of cycles
    beside it.
    """
    exact = partial(with_ring_at, CollectionLoop.mit(material="plywood"))
    fold = ring_fold(exact, math.radians(160.0), 0.0099)
    assert 1000 * fold.radius == pytest.approx(9.7932, abs=2e-4)

    def turn(theta: float, radius: float) -> float:
        return exact(radius).cycle(theta).theta_next - theta

    assert abs(turn(fold.theta, fold.radius)) < 1e-8
    beside = [turn(fold.theta + side * 0.02, fold.radius) / 0.02**2 for side in (1, -1)]
    assert np.mean(beside) == pytest.approx(fold.curvature, rel=1e-2)
    rate = (turn(fold.theta, fold.radius + 1e-5) - turn(fold.theta, fold.radius - 1e-5)) / 2e-5
    assert rate == pytest.approx(fold.by_radius, rel=1e-3)
    assert fold.passage_cycles(fold.radius + 1e-4) == math.inf
    quarter = fold.passage_cycles(fold.radius - 4e-5)
    assert fold.passage_cycles(fold.radius - 1e-5) == pytest.approx(2 * quarter)


def test_bad_input_is_refused_by_name_and_a_start_without_fold_does_not_converge() -> None:
    refused(with_ring_at, PLYWOOD, 0.0, told="ring radius")
    refused(with_anisotropy_times, PLYWOOD, -0.5, told="offset")
    flat = partial(with_ring_at, with_anisotropy_times(PLYWOOD, 1e-3))
    refused(ring_fold, flat, 1.0, 0.008, told="no saddle-node", kind=ConvergenceError)
