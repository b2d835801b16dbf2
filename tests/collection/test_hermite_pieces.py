"""Polynomials through values and slopes: exact where they should be, and as near as they say elsewhere."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.collection.adaptive_map import HermitePolynomial, Node, left_out_error, sample_circle_map


def nodes_of(function, slope, *places):
    return [Node(x, function(x), slope(x)) for x in places]


@pytest.mark.parametrize("places", [(0.3, 1.3), (0.3, 0.8, 1.3), (0.3, 0.4, 0.9, 1.0, 1.3)])
def test_through_k_nodes_goes_every_polynomial_of_degree_2k_less_1_with_its_slope(places):
    for degree in range(2 * len(places)):
        rng = np.random.default_rng(degree)
        polynomial = np.polynomial.Polynomial(rng.normal(size=degree + 1))
        found = HermitePolynomial.through(nodes_of(polynomial, polynomial.deriv(), *places))
        for x in rng.uniform(0.0, 1.6, 20):
            assert found.at(x) == pytest.approx((polynomial(x), polynomial.deriv()(x)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_its_error_falls_with_twice_as_high_a_power_of_the_width_as_it_has_nodes(count):
    def error(width):
        places = 1.0 + width * np.linspace(0.0, 1.0, count)
        found = HermitePolynomial.through(nodes_of(math.sin, math.cos, *places.tolist()))
        return max(abs(found.at(x)[0] - math.sin(x)) for x in np.linspace(1.0, 1.0 + width, 41))

    assert math.log2(error(2.0) / error(1.0)) == pytest.approx(2.0 * count, abs=0.5)


def test_the_node_that_is_left_out_is_missed_by_what_the_others_polynomial_is_off_there():
    """Hermite's remainder for x^8 through four nodes is the product of (x - x_k)^2 (Davis 1975, 3.5)."""
    places = (0.0, 0.25, 0.5, 0.75, 1.0)
    nodes = nodes_of(lambda x: x**8, lambda x: 8.0 * x**7, *places)
    for number, place in enumerate(places):
        remainder = math.prod((place - other) ** 2 for other in places if other != place)
        assert left_out_error(nodes, number) == pytest.approx(remainder, rel=1e-9)


@pytest.mark.parametrize("error", [1e-3, 1e-6, 1e-9])
def test_cubics_from_node_to_node_come_as_near_to_it_as_asked_with_not_many_nodes_too_many(error):
    given = nodes_of(lambda x: math.exp(2.0 * x), lambda x: 2.0 * math.exp(2.0 * x), 0.0, 0.5, 1.0)
    polynomial = HermitePolynomial.through(given)

    def worst(nodes):
        pieces = [HermitePolynomial.through(pair) for pair in pairwise(nodes)]
        places = [
            (p, a.theta + s * (b.theta - a.theta)) for p in pieces for a, b in [p.nodes] for s in (0.25, 0.5, 0.7)
        ]
        return max(abs(piece.at(x)[0] - polynomial.at(x)[0]) for piece, x in places)

    nodes = list(polynomial.refined(error))
    assert worst(nodes) <= error and set(given) <= set(nodes)
    half = np.linspace(0.0, 1.0, max(2, len(nodes) // 2)).tolist()
    assert worst([Node(x, *polynomial.at(x)) for x in half]) > error


def test_a_smooth_map_takes_less_than_a_third_of_the_samples_that_its_cubics_have_nodes():
    """`samples` tells what was asked for, the pieces how many cubics there are."""
    asked = []

    def sample(theta):
        asked.extend(theta.tolist())
        return theta + 0.5 + 0.3 * np.sin(theta), 1.0 + 0.3 * np.cos(theta)

    found = sample_circle_map(sample, 1e-9)
    theta = np.random.default_rng(4).uniform(0.0, 2.0 * math.pi, 4000)
    off = np.abs(found(theta) - (theta + 0.5 + 0.3 * np.sin(theta))).max()
    assert off <= found.max_error <= 1e-9
    assert found.pieces is not None
    assert found.samples == len(asked) < 0.33 * (len(found.pieces.knots) - 1)
