"""The dynamic simulation converges at the orders its docstrings state, and to the quasi-static model as speed falls."""

import math
from functools import cache

import numpy as np
import pytest
from force_balance import story

from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    DynamicModel,
    EllipseFriction,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    grid_footprint,
    load_material,
)

PLYWOOD = load_material("plywood").friction
STRONG = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
SQUARE = Slider.mit("rect1")


def strokes(model, theta=0.3, distance=0.04, **options) -> np.ndarray:
    """Turns (rad) and displacement (0.1 m) of a push and of the drag back."""
    push = model.push(Pose(theta=theta), SidePush(distance=distance), **options)
    drag = model.drag(push.end, ((0.0, 0.0),), **options)
    return np.array((push.turn, *(10.0 * push.displacement), drag.turn))


@cache
def dynamic(friction=STRONG, theta=0.3, **numbers) -> np.ndarray:
    return strokes(DynamicModel(SQUARE, friction, Pusher(), **numbers), theta, samples=1)


def halvings(name: str, first: float, factor: float, count: int, friction: EllipseFriction) -> np.ndarray:
    """Changes (count - 1, 4) from one value of a number to the next."""
    values = (first * factor**k for k in range(count))
    return np.diff([dynamic(friction, **{"tolerance": 1e-8, name: value}) for value in values], axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [PLYWOOD, STRONG], ids=["plywood", "strong"])
@pytest.mark.parametrize(
    ("name", "first", "factor", "order"),
    [("stiffness", 1e5, 2.0, 1.0), ("regularisation", 1.6e-3, 0.5, 1.0), ("speed", 0.04, 0.5, 2.0)],
)
def test_errors_fall_with_softness_and_regularisation_and_with_speed_squared(name, first, factor, order, friction):
    size = np.abs(halvings(name, first, factor, 4, friction)).max(axis=1)
    assert size.shape == (3,) and np.all(size > 1e-6)
    orders = np.log2(size[:-1] / size[1:])
    # A stroke's end, where stick and slip change, is not smooth in the stiffness.
    slack = 0.8 if name == "stiffness" else 0.15
    np.testing.assert_allclose(orders, order, atol=slack)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [PLYWOOD, STRONG], ids=["plywood", "strong"])
def test_the_error_stays_within_fifty_times_the_tolerance(friction):
    exact = dynamic(friction, tolerance=1e-10)
    errors = {
        tolerance: np.abs(dynamic(friction, tolerance=tolerance) - exact).max() for tolerance in (1e-5, 1e-6, 1e-8)
    }
    assert all(error < 50.0 * tolerance for tolerance, error in errors.items()), errors
    assert errors[1e-8] < 0.05 * errors[1e-5]


@pytest.mark.parametrize(("friction", "theta"), [(PLYWOOD, 0.3), (PLYWOOD, 2.6), (STRONG, 0.3), (STRONG, 4.0)])
def test_extrapolated_to_no_speed_it_is_the_quasi_static_model(friction, theta):
    """Two speeds, their v^2 taken out: turns agree to 2e-5 rad (0.001 degrees), displacements to 2 micrometres."""
    sharp = {"tolerance": 1e-8, "stiffness": 1e7, "regularisation": 2e-5}
    slow, slower = (dynamic(friction, theta, speed=speed, **sharp) for speed in (0.02, 0.01))
    footprint = grid_footprint(SQUARE.outline, 8)
    still = strokes(QuasiStaticModel(SQUARE, friction, Pusher(), footprint), theta)
    at_rest = (4.0 * slower - slow) / 3.0
    np.testing.assert_allclose(at_rest, still, atol=2e-5, rtol=0.0)
    # What was taken out was larger: the extrapolation carries the agreement.
    assert np.abs(slow - still).max() > 3e-4


@pytest.mark.slow
@pytest.mark.parametrize("name", MIT_SHAPE_NAMES)
def test_every_shape_on_strong_friction_comes_within_inertia_of_the_quasi_static_model(name):
    """Axis ratio, offset and push drawn: at 20 mm/s a push differs by less than 0.3 degrees, its drag by 1."""
    random = np.random.default_rng(MIT_SHAPE_NAMES.index(name))
    slider, ratio = Slider.mit(name), math.exp(random.uniform(-1.0, 1.0))
    law = EllipseFriction(0.25, 0.25 * ratio, 0.08, -0.05 * min(ratio, 1.0), random.uniform(0.0, math.pi))
    side = int(random.integers(slider.outline.sides))
    push = SidePush(side, random.uniform(0.05, 0.95), random.uniform(-0.6, 0.6), random.uniform(0.02, 0.1))
    parts = slider, law, Pusher(friction=random.uniform(0.0, 0.6)), grid_footprint(slider.outline, 8)
    start = Pose(0.01, 0.03, random.uniform(-3.0, 3.0))
    found, still = DynamicModel(*parts).push(start, push), QuasiStaticModel(*parts).push(start, push)
    assert found.ended == still.ended
    assert found.turn == pytest.approx(still.turn, abs=math.radians(0.3))
    np.testing.assert_allclose(found.displacement, still.displacement, atol=5e-4)
    drag, slow_drag = (model(*parts).drag(found.end, ((0.0, 0.0),)) for model in (DynamicModel, QuasiStaticModel))
    assert drag.turn == pytest.approx(slow_drag.turn, abs=math.radians(1.0))
    assert drag.length == pytest.approx(slow_drag.length, rel=1e-12)


def test_the_rod_rolls_around_a_corner_as_in_the_quasi_static_model():
    """Pushed near a corner at a slant, the contact passes from the side on to the corner."""
    push = SidePush(0, 0.97, math.radians(-30.0), 0.05)
    footprint = grid_footprint(SQUARE.outline, 8)
    still = QuasiStaticModel(SQUARE, PLYWOOD, Pusher(friction=0.5), footprint).push(Pose(), push)
    assert {kind for _, kind in story(still)} == {"side", "corner"}
    found = DynamicModel(SQUARE, PLYWOOD, Pusher(friction=0.5), footprint).push(Pose(), push)
    assert found.ended == still.ended
    assert found.turn == pytest.approx(still.turn, abs=1e-3)
