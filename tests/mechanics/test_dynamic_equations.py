"""The dynamic equations: motions known in closed form, and the nearest place of an outline against a search over it."""

import math
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import MIT_SHAPE_NAMES, DynamicModel, Ellipse, EllipseFriction, Polygon, Pusher, Slider
from cyclemap.mechanics.dynamic_equations import PHYSICS, nearest_place

MU = 0.25
SQUARE = Slider.mit("rect1")
FAR = np.array((50.0, 50.0))


def coasted(friction: EllipseFriction, start: list[float], time: float):
    """The slider alone on the floor, from a state in the equations' units; the rod is far away."""
    model = DynamicModel(SQUARE, friction, Pusher(), tolerance=1e-9, regularisation=1e-6)
    return model, model.equations(SQUARE.outline).run(np.array(start), FAR, np.zeros(2), time, model.physics())


@pytest.mark.parametrize("direction", [0.0, 0.9, 4.0])
def test_a_block_slides_to_rest_over_v_squared_by_2_mu_g(direction):
    model, _ = coasted(EllipseFriction.isotropic(MU), [0.0] * 6, 1e-3)
    c, s = math.cos(direction), math.sin(direction)
    _, run = coasted(EllipseFriction.isotropic(MU), [0.0, 0.0, 0.4, c, s, 0.0], 2.0 * model.froude / MU)
    distance = model.froude / (2.0 * MU)
    np.testing.assert_allclose(run.state[-1, :2], (c * distance, s * distance), rtol=1e-4, atol=1e-12)
    assert run.state[-1, 2] == pytest.approx(0.4, abs=1e-8)
    # All of its kinetic energy, Fr/2, went into the floor, nothing into a contact.
    np.testing.assert_allclose(run.works, (0.0, model.froude / 2.0, 0.0), rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize(("sign", "mu"), [(1.0, 0.34), (-1.0, 0.26)])
def test_along_an_ellipses_axis_friction_is_the_semi_axis_and_the_offset(sign, mu):
    """v = 1 - mu t / Fr, with mu = mu_a + m0 one way and mu_a - m0 the other."""
    law, model = EllipseFriction(0.3, 0.2, 0.04, 0.0, 0.0), coasted(EllipseFriction.isotropic(MU), [0.0] * 6, 1e-3)[0]
    time = model.froude
    _, run = coasted(law, [0.0, 0.0, 0.0, sign, 0.0, 0.0], time)
    assert sign * run.state[-1, 3] == pytest.approx(1.0 - mu, abs=1e-5)
    np.testing.assert_allclose(run.state[-1, [4, 5]], 0.0, atol=1e-8)


def test_a_plate_spins_to_rest_under_a_constant_torque():
    """Points at radius r each take mu r of their load: omega falls evenly, the angle is omega^2 / (2 alpha)."""
    model, _ = coasted(EllipseFriction.isotropic(MU), [0.0] * 6, 1e-3)
    radius = float(np.hypot(*np.array(model.points.positions).T).mean() / model.points.extent)
    inertia = float(model.physics()[PHYSICS.index("inertia")])
    alpha = MU * radius / (model.froude * inertia)
    _, run = coasted(EllipseFriction.isotropic(MU), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 2.0 / alpha)
    assert run.state[-1, 2] == pytest.approx(1.0 / (2.0 * alpha), rel=1e-4)
    np.testing.assert_allclose(run.state[-1, :2], 0.0, atol=1e-10)


def test_a_slider_left_alone_at_rest_creeps_by_less_than_the_creep_speed():
    law = EllipseFriction(0.3, 0.2, 0.1, 0.05, 0.3)
    _, run = coasted(law, [0.0] * 6, 1.0)
    moved = np.hypot(*run.state[-1, :2])
    assert 0.0 < moved < 1e-6
    assert np.all(run.force == 0.0)


OUTLINES = {name: Slider.mit(name).outline for name in MIT_SHAPE_NAMES} | {"slim": Ellipse(0.08, 0.02)}


def nearest_places(outline, places: np.ndarray) -> np.ndarray:
    """The nearest place of the outline to each place (2, n)."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("nearest", [x, y], [ca.vertcat(*nearest_place(outline, x, y))])
    return np.array(function(places[:1], places[1:]))


def around(outline, gap: float) -> np.ndarray:
    """Places (2, 40) about 5 mm outside."""
    random = np.random.default_rng(4)
    angle, found = random.uniform(0.0, 2.0 * np.pi, 40), []
    dense = dense_outline(outline)
    for a in angle:
        ray = np.array((np.cos(a), np.sin(a)))
        rim = dense[np.argmax((dense - dense.mean(axis=0)) @ ray)]
        found.append(rim + gap * ray)
    return np.array(found).T


def dense_outline(outline) -> np.ndarray:
    corners = outline.points(20_001)
    if isinstance(outline, Ellipse):
        return corners
    share = np.linspace(0.0, 1.0, 4_001)[:, None]
    return np.concatenate([a + share * (b - a) for a, b in pairwise(corners)])


@pytest.mark.slow
@pytest.mark.parametrize("name", OUTLINES)
def test_no_place_of_the_outline_is_nearer(name):
    outline = OUTLINES[name]
    places = around(outline, 0.00475)
    found = nearest_places(outline, places)
    dense = dense_outline(outline)
    for place, nearest in zip(places.T, found.T, strict=True):
        searched = np.hypot(*(dense - place).T).min()
        assert np.hypot(*(nearest - place)) == pytest.approx(searched, abs=1e-7)
        # The place itself lies on the outline.
        assert np.hypot(*(dense - nearest).T).min() < 4e-5
    assert found.shape == (2, 40)


def test_a_concave_outline_is_refused():
    concave = Polygon(((1.0, 1.0), (0.0, 0.2), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)))
    with pytest.raises(InvalidInput, match="convex"):
        nearest_place(concave, ca.SX.sym("x"), ca.SX.sym("y"))
