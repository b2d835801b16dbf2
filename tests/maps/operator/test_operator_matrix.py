"""The matrix of the operator in Fourier modes, against plain sums over the nodes,
entry by entry."""

import math

import numpy as np
import pytest

import cyclemap as cm

BENT = np.linspace(0.0, 2.0 * math.pi, 40)[:-1]
MAPS = {
    "smooth": cm.CircleMap.arnold(0.3, 0.9),
    "sampled": cm.CircleMap.from_samples(BENT, BENT + 0.4 + 0.2 * np.abs(np.sin(BENT))),
}


def waves(theta, modes):
    """1, cos mθ, sin mθ, rows."""
    phases = np.arange(1, modes + 1)[:, None] * theta
    return np.concatenate([np.ones((1, theta.size)), np.cos(phases), np.sin(phases)])


@pytest.mark.parametrize("name", ["smooth", "sampled"])
@pytest.mark.parametrize("modes", [1, 5, 200])
def test_entries_are_the_sums_over_the_nodes(name, modes) -> None:
    """What the fast transforms give is off by rounding alone, also with hardly any modes."""
    basis = cm.transfer_operator(MAPS[name], cm.WrappedNormal(0.05), modes=modes).discretisation
    theta, weight = basis.rule
    exact = np.longdouble
    before = waves(theta.astype(exact), modes) * weight
    after = waves(MAPS[name](theta).astype(exact), modes)
    damped = np.exp(
        -0.5 * (0.05 * np.concatenate([np.arange(modes + 1), np.arange(1, modes + 1)])) ** 2
    )
    share = np.full(basis.size, 1.0 / math.pi)
    share[0] = 0.5 / math.pi
    plain = damped[:, None] * share * (after @ before.T)
    plain[0] = np.eye(1, basis.size)[0]
    np.testing.assert_allclose(basis.matrix, plain.astype(float), rtol=0.0, atol=3e-15)


def test_a_rigid_turn_only_turns_and_damps_every_wave() -> None:
    """Under θ + ω + ξ the moment E e^{imθ} is multiplied by κ_m e^{imω}, and no mode reaches
    another.
    """
    turn, sigma = 0.1234, 0.03
    basis = cm.transfer_operator(cm.CircleMap.rigid(turn), cm.WrappedNormal(sigma)).discretisation
    order = np.arange(1, basis.modes + 1)
    damped = np.exp(-0.5 * (sigma * order) ** 2)
    cosine = np.diag(damped * np.cos(2.0 * math.pi * turn * order))
    sine = np.diag(damped * np.sin(2.0 * math.pi * turn * order))
    low = order <= 0.5 * basis.modes
    kept = np.flatnonzero(np.concatenate([[False], low, low]))
    expected = np.zeros((basis.size, basis.size))
    expected[1:, 1:] = np.block([[cosine, -sine], [sine, cosine]])
    # Of the highest modes, which the noise all but kills, the nodes are fewer than their products
    # need.
    some = np.ix_(kept, kept)
    np.testing.assert_allclose(basis.matrix[some], expected[some], rtol=0.0, atol=1e-14)
