"""Families: the derivative of the lift with respect to the parameter, its error, and moving breaks."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, parameter_tangent
from cyclemap.maps.families.family import break_motion, family_member, parameter_range

TWO_PI = 2 * np.pi
THETA = np.linspace(-7.0, 9.0, 101)


def moving_jump(p):
    """x + 0.3 sin(x - p) + 1 with a jump of 0.4 at p and a kink at p + 2."""

    def lift(x):
        y = np.mod(x - p, TWO_PI)
        return (
            x
            + 1.0
            + 0.3 * np.sin(y)
            + 0.4 * np.cos(p) * (y / TWO_PI) ** 2
            + 0.1 * np.maximum(y - 2.0, 0.0) * (TWO_PI - y)
        )

    return CircleMap(lift, None, breaks=[p, p + 2.0])


def test_the_tangent_of_the_moebius_family_is_its_closed_form_within_its_bound():
    a, omega = 0.6, 0.2
    tangent = parameter_tangent(lambda r: CircleMap.moebius(r, omega), a)
    truth = 2.0 * np.sin(THETA) / (1.0 - 2.0 * a * np.cos(THETA) + a * a)
    assert np.all(np.abs(tangent(THETA) - truth) <= tangent.error(THETA))
    assert np.max(tangent.error(THETA)) < 1e-8
    assert np.max(np.abs(tangent(THETA) - truth)) < 1e-9


@pytest.mark.parametrize("order", [2, 4])
def test_the_error_falls_with_the_step_to_the_power_of_the_order(order):
    truth = 2.0 * np.sin(1.0) / (1.0 - 1.2 * np.cos(1.0) + 0.36)
    steps = np.array([0.08, 0.04, 0.02])
    family = lambda r: CircleMap.moebius(r, 0.2)  # noqa: E731
    errors = [abs(float(parameter_tangent(family, 0.6, step=h, order=order)(1.0)) - truth) for h in steps]
    orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(orders - order) < 0.35)


def test_a_difference_at_the_end_of_the_allowed_range_never_leaves_it_and_keeps_its_order():
    asked = []

    def family(K):
        asked.append(K)
        return CircleMap.arnold(0.1, K)

    for parameter in (0.0, 0.0005, 0.999, 1.0):
        tangent = parameter_tangent(family, parameter, within=(0.0, 1.0))
        assert np.all(np.abs(tangent(THETA) + np.sin(THETA)) <= tangent.error(THETA))
        assert np.max(tangent.error(THETA)) < 1e-9
    assert len(asked) > 20
    assert min(asked) >= 0.0
    assert max(asked) <= 1.0


def test_breaks_that_move_are_followed_and_never_differenced_across():
    p = 6.1  # one break close to 2π, which wraps inside the stencil with a large step
    for step in (1e-3, 0.1):
        tangent = parameter_tangent(moving_jump, p, step=step)
        assert np.allclose(tangent.break_rates, 1.0, atol=1e-10)
        y = np.mod(np.append(THETA, [p, p + 2.0, p - 1e-6, p + 1e-6]) - p, TWO_PI)
        truth = (
            -0.3 * np.cos(y)
            - 0.4 * np.cos(p) * 2.0 * y / TWO_PI**2
            - 0.4 * np.sin(p) * (y / TWO_PI) ** 2
            - 0.1 * np.where(y >= 2.0 - 1e-12, TWO_PI - 2.0 * y + 2.0, 0.0)
        )
        error = np.abs(tangent(p + y) - truth)
        assert np.max(error) < (1e-8 if step == 1e-3 else 1e-5)


def test_break_motion_pairs_breaks_round_the_circle():
    breaks = np.array([0.01, 1.0, 6.2])
    for shift in (0.05, -0.05, 0.3):
        moved = np.sort(np.mod(breaks + shift, TWO_PI))
        assert np.allclose(break_motion(breaks, moved), shift, atol=1e-14)
    with pytest.raises(InvalidInput, match="3 and 2 breaks"):
        break_motion(breaks, breaks[:2])


def test_a_claimed_error_of_the_lifts_enters_the_bound():
    family = lambda p: CircleMap(lambda x: x + p, np.ones_like, max_error=1e-9)  # noqa: E731
    assert parameter_tangent(family, 0.5, step=0.01).error(1.0) > 1e-7


def test_bad_families_are_refused():
    with pytest.raises(InvalidInput, match=r"family\(0\.5\) is 1\.5: it must return a CircleMap"):
        family_member(lambda p: p + 1.0, 0.5)
    with pytest.raises(InvalidInput, match="give a callable"):
        parameter_tangent(3.0, 0.5)
    with pytest.raises(InvalidInput, match="parameter must be a finite number"):
        parameter_tangent(CircleMap.rigid, float("nan"))
    with pytest.raises(InvalidInput, match="step must be positive"):
        parameter_tangent(CircleMap.rigid, 0.1, step=0.0)
    with pytest.raises(InvalidInput, match="order is 3"):
        parameter_tangent(CircleMap.rigid, 0.1, order=3)
    with pytest.raises(InvalidInput, match="low end must lie below"):
        parameter_range("parameters", (1.0, 1.0))
    with pytest.raises(InvalidInput, match="give a pair"):
        parameter_range("parameters", 1.0)
    with pytest.raises(InvalidInput, match="finite number"):
        parameter_range("parameters", (0.0, np.nan))
    jumpy = lambda p: CircleMap(lambda x: x, breaks=[1.0] if p < 0.5 else [1.0, 2.0])  # noqa: E731
    with pytest.raises(InvalidInput, match="breaks at neighbouring parameters"):
        parameter_tangent(jumpy, 0.5)
