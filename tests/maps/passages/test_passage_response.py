"""Responses of passages: central differences, the adjoint, closed forms, Monte Carlo of the start's slope."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    mean_passage_time,
    passage_response,
)
from cyclemap.maps.passages.killed_chain import killed_chain, line_exits

TWO_PI = 2 * np.pi
STICKY = CircleMap.arnold(0.1, 0.9)


def tangent(theta):
    """∂F/∂K of the sine map."""
    return -np.sin(theta)


def slope(function, step=1e-5):
    """Central difference of fourth order."""
    ends = 8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))
    return float(ends / (12 * step))


def altered(noise, change):
    return type(noise)(next(iter(vars(noise).values())) + change)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("noise", "lifted"),
    [(WrappedNormal(0.3), False), (WrappedCauchy(0.9), False), (WrappedCauchy(0.9), True), (VonMises(20.0), False)],
)
def test_every_derivative_of_the_passage_agrees_with_differences(noise, lifted):
    start, low, high = 0.77, 0.0, 1.6

    def time(strength=0.0, noisier=0.0, moved=0.0, below=0.0, above=0.0):
        one = CircleMap.arnold(0.1, 0.9 + strength)
        return float(
            mean_passage_time(one, altered(noise, noisier), start + moved, (low + below, high + above), lifted=lifted)
        )

    found = passage_response(STICKY, noise, start, (low, high), tangent, lifted=lifted)
    assert abs(found.time - time()) < 1e-12 * time()
    pairs = [
        (found.to_map, slope(lambda h: time(strength=h))),
        (found.to_noise, slope(lambda h: time(noisier=h))),
        (found.to_start, slope(lambda h: time(moved=h))),
        (found.to_arc_start, slope(lambda h: time(below=h))),
        (found.to_arc_end, slope(lambda h: time(above=h))),
    ]
    for exact, difference in pairs:
        assert abs(exact - difference) < 1e-8 * abs(exact) + 1e-9
        assert exact.error_bound < 1e-9 * abs(exact)


def test_the_adjoint_gives_the_same_response_to_the_map():
    """δT = Σ (visits of the path from the start) · (δK T): one left solution against one right solution."""
    noise, ends, start = WrappedNormal(0.15), (-3.0, 2.0), 0.77
    chain = killed_chain(STICKY, noise, (ends,), line_exits(ends), True, stretch=1.1)
    times = chain.elimination.solve(np.ones(chain.theta.size))
    first = chain.transitions(STICKY(np.array([start])))[0]
    visits = chain.elimination.visits(first)
    sources = tangent(chain.theta) * (chain.transition_slopes(chain.images) @ times)
    at_start = tangent(start) * float((chain.transition_slopes(STICKY(np.array([start]))) @ times)[0])
    found = passage_response(STICKY, noise, start, ends, tangent, lifted=True)
    # Without the chances of leaving the adjoint's sources cancel: T is 1e10, and six digits are left.
    assert abs(found.to_map / (visits @ sources + at_start) - 1) < 1e-3
    assert abs(found.to_map - slope(lambda h: _time(0.9 + h, noise, start, ends))) < 1e-7 * found.to_map


def _time(strength, noise, start, ends):
    return float(mean_passage_time(CircleMap.arnold(0.1, strength), noise, start, ends, lifted=True))


def test_a_reset_responds_in_closed_form_even_at_a_hundred_digits():
    """T = 1/P(|ξ - c| > 1) for a map that is constant, c: derivatives by c, σ and the ends are known."""
    x = np.array([-1.5, 1.5, 1.5, TWO_PI - 1.5])
    for sigma in (0.5, 0.1, 0.05):
        noise = WrappedNormal(sigma)
        reset = CircleMap.from_samples(x, [0.1, 0.1, 0.1, TWO_PI], [0, 0, 0, 0.0])
        found = passage_response(reset, noise, 0.0, (-1.0, 1.0), np.ones_like, lifted=True)
        above, below = noise.line_density(0.9), noise.line_density(1.1)
        time = 1 / float(noise.exceedance(0.9) + noise.exceedance(1.1))
        assert found.to_map == pytest.approx(-(time**2) * (above - below), rel=1e-12)
        assert found.to_noise == pytest.approx(-(time**2) * (0.9 * above + 1.1 * below) / sigma, rel=1e-12)
        assert found.to_arc_end == pytest.approx(time**2 * above, rel=1e-12)
        assert found.to_arc_start == pytest.approx(-(time**2) * below, rel=1e-12)
        assert abs(found.to_start) <= found.to_start.error_bound + 1e-300


def test_a_long_passage_barely_knows_its_start_and_the_slope_keeps_its_digits():
    """At 1e98 cycles dT/dx at the bottom is about 1/relaxation, ninety digits below T: it must not drown."""
    noise, ends = WrappedNormal(0.05), (-3.9, 2.36)
    found = passage_response(STICKY, noise, 0.77, ends, tangent, lifted=True)
    assert found.time > 1e95 and 1 < abs(found.to_start) < 1e3
    chain = killed_chain(STICKY, noise, (ends,), line_exits(ends), True, stretch=1.2)
    expected = chain.expected(1.0, np.zeros(2))

    def change(step):
        return expected.values_at(STICKY(np.array([0.77 + step])))[1][0]

    assert abs(found.to_start / slope(change, 1e-4) - 1) < 1e-6


def test_bad_requests_are_refused():
    noise, arc = WrappedNormal(0.3), (0.0, 1.6)
    with pytest.raises(InvalidInput, match="entry by entry"):
        passage_response(STICKY, noise, 0.7, arc, lambda theta: 1.0)
    with pytest.raises(InvalidInput, match="outside the arc"):
        passage_response(STICKY, noise, 3.0, arc)
    with pytest.raises(InvalidInput, match="jumps"):
        passage_response(STICKY, UniformNoise(0.3), 0.7, arc)
    with pytest.raises(ConvergenceError, match="1e300"):
        passage_response(STICKY, WrappedNormal(0.02), 0.7, (-1.5, 2.3), lifted=True)
    assert passage_response(STICKY, noise, 0.7, arc).to_map is None
