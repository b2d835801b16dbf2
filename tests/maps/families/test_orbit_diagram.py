"""Orbit diagrams and exponents over parameters, against theory and against one map at a time."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    ParametricLift,
    lyapunov_exponent,
    lyapunov_exponents,
    orbit_diagram,
    period_doublings,
    saddle_nodes,
)


def of_strength(K):
    return CircleMap.arnold(0.1, K)


def periods(theta):
    return [np.unique(np.round(row, 6)).size for row in theta]


def test_the_period_doubles_where_the_multiplier_passes_minus_one():
    [flip] = period_doublings(of_strength, (1.0, 2.4))
    values = float(flip.parameter) + np.array([-0.05, 0.05])
    assert periods(orbit_diagram(of_strength, values, transient=2000).theta) == [1, 2]


@pytest.mark.slow
def test_an_attractor_is_followed_until_its_saddle_node_from_either_side():
    """Two wells, of which a tilt fills the shallow one first: it is seen only by a path that comes from within it."""

    def tilted(p):
        return CircleMap(lambda x: x + p - 0.1 * np.sin(x) - 0.3 * np.sin(2 * x))

    values = np.linspace(-0.2, 0.3, 51)
    up = orbit_diagram(tilted, values, cycles=1, transient=300, start=np.pi).theta[:, 0]
    down = orbit_diagram(tilted, values[::-1], cycles=1, transient=300, start=0.0).theta[::-1, 0]
    apart = np.abs(np.angle(np.exp(1j * (up - down)))) > 0.5
    [last] = np.flatnonzero(np.diff(apart))
    # Where the paths join, the shallow well ends in a saddle-node.
    nodes = [float(found.parameter) for found in saddle_nodes(tilted, (0.1, 0.3), resolution=4)]
    assert np.all(apart[: last + 1]) and any(values[last] < node < values[last + 1] for node in nodes)


def test_exponents_over_a_plane_are_those_of_one_map_at_a_time():
    omega, K = np.array([0.05, 0.1, 0.3]), np.array([0.5, 0.9])
    found = lyapunov_exponents(CircleMap.arnold, omega[:, None], K)
    assert found.value.shape == (3, 2)
    single = lyapunov_exponents(lambda a, b: CircleMap.arnold(a, b), omega[:, None], K)
    np.testing.assert_allclose(found.value, single.value, rtol=0, atol=1e-9)
    exact = np.array([[lyapunov_exponent(CircleMap.arnold(a, b)) for b in K] for a in omega])
    assert np.all(np.abs(found.value - exact) < 2e-3 + found.error)


def test_a_rotation_has_none_and_a_doubling_map_has_ln_2():
    turning = lyapunov_exponents(CircleMap.arnold, [0.1, 0.3], 0.0)
    assert np.all(turning.value == 0.0) and np.all(turning.error == 0.0)
    # The tent-like family x → x + s sin 2x has F'(0) = 1 + 2s: at rest on 0 the exponent is its logarithm.
    family = ParametricLift(lambda x, s: x + s * np.sin(2 * x), lambda x, s: 1 + 2 * s * np.cos(2 * x))
    at_rest = lyapunov_exponents(family, [-0.25, -0.5], start=0.0)
    np.testing.assert_allclose(at_rest.value[:1], np.log(0.5), rtol=1e-14)
    assert np.isneginf(at_rest.value[1]) and at_rest.error[1] == 0.0


@pytest.mark.slow
def test_chaos_agrees_with_the_long_orbit_within_the_errors():
    found = lyapunov_exponents(CircleMap.arnold, 0.1, np.array([4.0, 5.0, 6.0]), cycles=20_000)
    for K, value, error in zip((4.0, 5.0, 6.0), found.value, found.error, strict=True):
        exact = lyapunov_exponent(CircleMap.arnold(0.1, K))
        assert abs(value - exact) < error + exact.error_bound


def test_bad_requests_are_refused():
    with pytest.raises(InvalidInput, match="empty"):
        orbit_diagram(of_strength, [])
    with pytest.raises(InvalidInput, match="CircleMap"):
        orbit_diagram(lambda K: K, [1.0])
    with pytest.raises(InvalidInput, match="missing"):
        lyapunov_exponents(CircleMap.arnold)
