"""Mean and extremes of the turn of sampled maps, by hand for cubics, and of such steepness that no wave resolves it."""

import numpy as np
import pytest

from cyclemap.collection.portrait import turn_statistics
from cyclemap.maps import CircleMap
from cyclemap.maps.quadrature import circle_rule

TURN = 2 * np.pi


def sampled(count) -> CircleMap:
    theta = np.linspace(0.0, TURN, count)
    return CircleMap.from_samples(theta, theta + 0.3 + 0.2 * np.sin(theta), 1.0 + 0.2 * np.cos(theta))


@pytest.mark.parametrize("count", [25, 200])
def test_the_mean_over_cubics_is_exact(count) -> None:
    """A cubic's integral is h (f0 + f1)/2 + h^2 (f0' - f1')/12 (Euler and Maclaurin)."""
    circle_map, theta = sampled(count), np.linspace(0.0, TURN, count)
    turn, slope, width = circle_map.turn(theta), 0.2 * np.cos(theta), np.diff(theta)
    turn[-1] = turn[0]
    whole = np.sum(width * (turn[:-1] + turn[1:]) / 2 + width**2 * (slope[:-1] - slope[1:]) / 12)
    found = turn_statistics(circle_map)
    assert found.mean == pytest.approx(whole / TURN, abs=1e-14)
    # The extremes lie between nodes at most π/150 apart, here and there: 0.2 (π/300)^2 / 2 at most is missed.
    assert found.minimum == pytest.approx(0.1, abs=2e-5)
    assert found.maximum == pytest.approx(0.5, abs=2e-5)
    assert found.min_slope == pytest.approx(0.8, abs=1e-3) and found.max_slope == pytest.approx(1.2, abs=1e-3)


def test_it_agrees_with_the_rule_for_waves_on_a_gentle_map() -> None:
    circle_map = sampled(60)
    theta, weight = circle_rule(circle_map, 2048)
    assert turn_statistics(circle_map).mean == pytest.approx(weight @ circle_map.turn(theta) / TURN, abs=1e-13)


def test_a_stretch_as_steep_as_a_jump_is_no_reason_to_refuse() -> None:
    """The map climbs by 3 rad within 1e-10 rad: its turn is that of the steps on either side."""
    at, rise = 2.0, 3.0
    theta = np.array([0.0, at, at + 1e-10, 4.0, TURN])
    lifted = np.array([0.0, at, at + rise, 4.0 + rise, TURN])
    slope = np.array([1.0, 1.0, 1.0, 1.0, 1.0])
    found = turn_statistics(CircleMap.from_samples(theta, lifted, slope))
    # From 4 on it comes down to the whole turn again: 3 h/2 under a cubic with slope 1 at both of its ends.
    mean = (rise * (4.0 - at) + 0.5 * rise * (TURN - 4.0)) / TURN
    assert found.mean == pytest.approx(mean, abs=1e-9)
    assert found.maximum == pytest.approx(rise, abs=1e-9) and found.minimum == pytest.approx(0.0, abs=1e-9)
    assert found.max_slope == pytest.approx(1.5 * rise / 1e-10, rel=1e-2)
