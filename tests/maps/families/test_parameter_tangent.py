"""Families: the derivative of the lift with respect to the parameter, and moving breaks."""

import numpy as np

from cyclemap.maps import CircleMap
from cyclemap.maps.families.family import parameter_tangent

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


def test_the_error_falls_with_the_square_of_the_step():
    truth = 2.0 * np.sin(1.0) / (1.0 - 1.2 * np.cos(1.0) + 0.36)
    steps = np.array([0.08, 0.04, 0.02])
    family = lambda r: CircleMap.moebius(r, 0.2)  # noqa: E731
    for within in ((0.0, 0.999), (0.0, 0.6)):  # in the middle, and at an end of what is allowed
        errors = [abs(float(parameter_tangent(family, 0.6, h, within)(1.0)) - truth) for h in steps]
        orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
        assert np.all(np.abs(orders - 2.0) < 0.35)


def test_a_difference_at_the_end_of_the_allowed_range_never_leaves_it():
    asked = []

    def family(K):
        asked.append(K)
        return CircleMap.arnold(0.1, K)

    for parameter in (0.0, 0.0005, 0.999, 1.0):
        tangent = parameter_tangent(family, parameter, 1e-3, (0.0, 1.0))
        assert np.max(np.abs(tangent(THETA) + np.sin(THETA))) < 1e-10
    assert len(asked) > 10
    assert min(asked) >= 0.0
    assert max(asked) <= 1.0


def test_breaks_that_move_are_followed_and_never_differenced_across():
    p = 6.1  # one break close to 2π, which wraps inside the stencil with a large step
    for step, good in ((1e-4, 1e-8), (1e-2, 1e-4)):
        tangent = parameter_tangent(moving_jump, p, step / 10.0, (0.0, 10.0))
        assert np.allclose(tangent.break_rates, 1.0, atol=1e-10)
        y = np.mod(np.append(THETA, [p, p + 2.0, p - 1e-6, p + 1e-6]) - p, TWO_PI)
        truth = (
            -0.3 * np.cos(y)
            - 0.4 * np.cos(p) * 2.0 * y / TWO_PI**2
            - 0.4 * np.sin(p) * (y / TWO_PI) ** 2
            - 0.1 * np.where(y >= 2.0 - 1e-12, TWO_PI - 2.0 * y + 2.0, 0.0)
        )
        assert np.max(np.abs(tangent(p + y) - truth)) < good
