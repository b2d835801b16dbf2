"""Polynomials through values and slopes: exact where they should be, and as near as they say elsewhere."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.collection.adaptive_map import sample_circle_map
from cyclemap.collection.hermite_pieces import Node, Quintic, cubic


def nodes_of(function, slope, *places):
    return [Node(x, function(x), slope(x)) for x in places]


@pytest.mark.parametrize("degree", range(6))
def test_a_quintic_is_every_polynomial_of_its_degree_and_its_slope(degree):
    rng = np.random.default_rng(degree)
    polynomial = np.polynomial.Polynomial(rng.normal(size=degree + 1))
    quintic = Quintic.through(*nodes_of(polynomial, polynomial.deriv(), 0.3, 0.8, 1.3))
    for x in rng.uniform(0.0, 1.6, 20):
        assert quintic.at(x) == pytest.approx((polynomial(x), polynomial.deriv()(x)), abs=1e-12)


def test_its_error_falls_with_the_sixth_power_of_the_width():
    def error(width):
        quintic = Quintic.through(*nodes_of(math.sin, math.cos, 1.0, 1.0 + width / 2.0, 1.0 + width))
        return max(abs(quintic.at(x)[0] - math.sin(x)) for x in np.linspace(1.0, 1.0 + width, 41))

    assert math.log2(error(0.8) / error(0.4)) == pytest.approx(6.0, abs=0.3)


@pytest.mark.parametrize("error", [1e-3, 1e-6, 1e-9])
def test_cubics_from_node_to_node_come_as_near_to_it_as_asked_with_not_many_nodes_too_many(error):
    low, middle, high = nodes_of(lambda x: math.exp(2.0 * x), lambda x: 2.0 * math.exp(2.0 * x), 0.0, 0.5, 1.0)
    quintic = Quintic.through(low, middle, high)

    def worst(nodes):
        places = [(a, b, a.theta + s * (b.theta - a.theta)) for a, b in pairwise(nodes) for s in (0.25, 0.5, 0.7)]
        return max(abs(cubic(a, b, x)[0] - quintic.at(x)[0]) for a, b, x in places)

    nodes = [low, *quintic.between(error), high]
    assert worst(nodes) <= error
    half = np.linspace(0.0, 1.0, max(2, len(nodes) // 2)).tolist()
    assert worst([Node(x, *quintic.at(x)) for x in half]) > error


def test_a_smooth_map_takes_less_than_half_the_samples_that_its_cubics_have_nodes():
    asked = []

    def sample(theta):
        asked.append(theta)
        return theta + 0.5 + 0.3 * math.sin(theta), 1.0 + 0.3 * math.cos(theta)

    found = sample_circle_map(sample, lambda theta: sample(theta)[0], 1e-9)
    theta = np.random.default_rng(4).uniform(0.0, 2.0 * math.pi, 4000)
    off = np.abs(found(theta) - (theta + 0.5 + 0.3 * np.sin(theta))).max()
    assert off <= found.max_error <= 1e-9
    assert len(asked) < 0.5 * found.samples
