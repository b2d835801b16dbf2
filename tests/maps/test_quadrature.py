"""Quadrature rules that fit a map."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap
from cyclemap.maps.quadrature import arc_rule, circle_rule, gauss_rule, graded_rule


@pytest.mark.parametrize("breaks", [(), (1.0,), (0.0,), (3.0, 3.1, 6.28)])
def test_rule_is_exact_for_harmonics_and_for_steps_at_breaks(breaks) -> None:
    """The weights sum to a turn, harmonics of the bandwidth are integrated, and so is a step at any break."""
    theta, weight = circle_rule(CircleMap(lambda x: x + 0.3, np.ones_like, breaks), 40)
    assert weight.sum() == pytest.approx(2.0 * np.pi, abs=1e-12)
    assert weight @ np.cos(17 * theta) ** 2 == pytest.approx(np.pi, abs=1e-11)
    for place in breaks:
        assert weight @ (theta < place) == pytest.approx(place, abs=1e-12)


def test_gauss_rules_on_panels_are_exact_for_polynomials():
    """Five nodes a panel integrate x⁹ exactly, panel by panel in the order given."""
    left, width = np.array([0.0, 2.0, -1.0]), np.array([1.0, 0.5, 0.25])
    x, w = gauss_rule(left, width, 5)
    assert x.shape == w.shape == (15,)
    exact = ((left + width) ** 10 - left**10) / 10
    np.testing.assert_allclose((w * x**9).reshape(3, 5).sum(axis=1), exact, rtol=1e-13)


@pytest.mark.parametrize("strength", [1.5, 3.0])
def test_graded_rules_integrate_the_logarithm_at_folds(strength):
    """∫ ln|1 - K cos θ| dθ = 2π ln(K/2) for K > 1 (Jensen's formula)."""
    folded = CircleMap.arnold(0.2, strength)
    for finer in (1, 2):
        theta, weight = graded_rule(folded, 10, finer)
        total = weight @ np.log(np.maximum(np.abs(folded.derivative(theta)), 1e-18))
        assert total == pytest.approx(2 * np.pi * np.log(strength / 2), abs=2e-13)


def test_cuts_are_panel_ends():
    """A step at a given cut is integrated exactly."""
    theta, weight = arc_rule(CircleMap.rigid(0.1), 0.0, 2 * np.pi, 10, cuts=np.array([0.7, 3.3]))
    assert weight @ ((theta > 0.7) & (theta < 3.3)) == pytest.approx(2.6, abs=1e-13)
