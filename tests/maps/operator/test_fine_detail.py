"""Lifts with fine detail: against dense sums, and against ten million steps of a path."""

import numpy as np
import pytest

from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    lyapunov_exponent,
    transfer_operator,
)
from tests.bounds.random_lifts import RandomLift, dense_exponent, dense_numbers


def rippled(waves, steepness=0.95, breaks=()):
    """θ + .3 + .2 sin θ with so many waves a turn on it."""
    return CircleMap(
        lambda x: x + 0.3 + steepness / waves * np.sin(waves * x) + 0.2 * np.sin(x),
        lambda x: 1 + steepness * np.cos(waves * x) + 0.2 * np.cos(x),
        breaks,
    )


@pytest.mark.parametrize(
    ("waves", "noise"),
    [
        (97, WrappedNormal(0.3)),
        (256, VonMises(2.0)),
        (256, WrappedNormal(3.0)),
        pytest.param(1000, WrappedCauchy(0.2), marks=pytest.mark.slow),
        pytest.param(4096, WrappedNormal(0.3), marks=pytest.mark.slow),
    ],
)
def test_waves_that_meet_the_nodes_do_not_deceive_the_bounds(waves, noise):
    """However many waves a turn, commensurate with nodes or not."""
    circle_map = rippled(waves)
    operator = transfer_operator(circle_map, noise)
    dense = dense_numbers(RandomLift(circle_map, noise, waves, "smooth"))
    for order in (1, 2):
        error = abs(operator.moment(order) - dense.moments[order])
        assert error <= operator.moment_error(order) + 1e-14 < 1e-12
    winding = operator.rotation_number
    assert abs(winding - dense.rotation) <= winding.error_bound + 1e-14


def test_breaks_change_nothing_where_there_are_none():
    """Panels that are cut at breaks, and panels that are not, are two routes to one law."""
    plain, cut = (
        transfer_operator(rippled(256, breaks=b), WrappedNormal(0.3)) for b in ((), (1.0, 3.0))
    )
    bounds = plain.moment_error(1) + cut.moment_error(1)
    assert abs(plain.moment(1) - cut.moment(1)) <= bounds < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("breaks", [(), (2.0,)])
def test_an_exponent_follows_the_detail_of_the_slope(breaks):
    circle_map = rippled(400, 0.7, breaks)
    found = lyapunov_exponent(circle_map, WrappedNormal(3.0))
    case = RandomLift(circle_map, WrappedNormal(3.0), 400, "smooth")
    dense = dense_exponent(case, dense_numbers(case))
    assert abs(found - dense) <= found.error_bound + 1e-12 < 1e-10


def test_what_cannot_be_resolved_is_refused_with_the_limit():
    """The narrowest noise that is promised is taken."""
    assert transfer_operator(CircleMap.rigid(0.3), WrappedNormal(0.0046)).modes <= 2000
    with pytest.raises(ConvergenceError, match="quadrature nodes, more than 400000"):
        transfer_operator(rippled(4096, 4000.0, (1.0,)), WrappedNormal(0.3)).moment(1)
    # 280,000 nodes can be held; with 2,000 modes they cannot be summed over.
    steep = transfer_operator(rippled(1000, 50.0), WrappedNormal(0.0047))
    with pytest.raises(ConvergenceError, match=r"multiplications, more than 2e\+12"):
        steep.discretisation.matrix  # noqa: B018


@pytest.mark.slow
def test_ten_million_steps_of_a_path_have_the_operators_moments():
    """2,500 paths of 4,000 steps, within four and a half standard errors of the paths' means."""
    circle_map, noise, rng = rippled(97), WrappedNormal(0.3), np.random.default_rng(11)
    theta = rng.uniform(0.0, 2 * np.pi, 2_500)
    total, climb = np.zeros(2_500, dtype=complex), np.zeros(2_500)
    for step in range(4_050):
        image = circle_map(theta)
        if step >= 50:
            climb += image - theta
            total += np.exp(1j * theta)
        theta = np.mod(image + noise.sample(rng, theta.size), 2 * np.pi)
    operator = transfer_operator(circle_map, noise)
    for values, truth in (
        (total.real / 4_000, operator.moment(1).real),
        (total.imag / 4_000, operator.moment(1).imag),
        (climb / 4_000 / (2 * np.pi), operator.rotation_number),
    ):
        assert abs(values.mean() - truth) < 4.5 * values.std(ddof=1) / np.sqrt(values.size)
