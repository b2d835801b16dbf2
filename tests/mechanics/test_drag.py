"""Dragging in the ring: the law of motion, its closed form under an ellipsoid, way-points; the integrator's order."""

import math

import numpy as np
import pytest
from random_cases import balance_errors, random_case
from scipy.optimize import minimize_scalar

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, LimitSurface, Pose, QuasiStaticModel, Slider, load_material
from cyclemap.mechanics.runge_kutta import MARGIN, SLOPE, STATE, step

PLYWOOD = load_material("plywood").friction
MODEL = QuasiStaticModel(Slider.mit("rect1"), PLYWOOD, accuracy=1e-9)


def ellipsoid_motion(lever, radius):
    """Motion (theta, 0) of a ring at a lever from the centre, drawn along x.

    The limit surface is an ellipsoid, D^2 = vx^2 + vy^2 + (radius omega)^2.
    The spin minimises |u - omega z x r|^2 + (radius omega)^2.
    """

    def evaluate(state):
        row = np.zeros(10)
        row[STATE], row[MARGIN] = state, math.inf
        row[SLOPE] = (-lever * math.sin(state[0]) / (lever**2 + radius**2), 0.0)
        return row

    return evaluate


def ellipsoid_end(theta, lever, radius, length, steps):
    evaluate, state = ellipsoid_motion(lever, radius), np.array((theta, 0.0))
    for _ in range(steps):
        state = step(evaluate, state, length / steps).end
    return float(state[0])


def test_an_ellipsoids_drag_follows_its_closed_form():
    """tan(theta / 2) falls as exp(-kappa L), kappa = r / (c^2 + r^2), when the limit surface is an ellipsoid."""
    for theta, lever, radius, length in np.random.default_rng(1).uniform((-3, 0.1, 0.3, 0.5), (3, 2, 2, 5), (20, 4)):
        kappa = lever / (radius**2 + lever**2)
        exact = 2.0 * math.atan(math.exp(-kappa * length) * math.tan(theta / 2.0))
        assert abs(ellipsoid_end(theta, lever, radius, length, 200) - exact) < 1e-12


def test_the_integrator_is_of_order_seven_and_its_estimate_falls_so_too():
    """Halving the steps divides the error by 2^7 at least, and the estimate of one step's error as well."""
    starts = np.linspace(0.3, 2.7, 9)
    exact = 2.0 * np.arctan(math.exp(-1.5) * np.tan(starts / 2.0))
    errors = [np.mean(np.abs([ellipsoid_end(s, 1.0, 1.0, 3.0, n) for s in starts] - exact)) for n in (2, 4, 8)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 6.7).all()
    means = [
        np.mean([step(ellipsoid_motion(1.0, 1.0), np.array((s, 0.0)), h).error for s in starts]) for h in (0.8, 0.4)
    ]
    assert math.log2(means[0] / means[1]) > 6.7


def test_the_object_turns_as_dissipates_least():
    """At every sample the spin is the argmin of D over twists that move the ring along."""
    start, goal = Pose(0.02, -0.03, 0.8), (0.12, 0.05)
    ring = MODEL.ring_place(start)
    towards = math.atan2(goal[1] - ring[1], goal[0] - ring[0])
    drag = MODEL.drag(start, (goal,), longest_step=0.01)
    surface, (hx, hy) = LimitSurface(MODEL.pressure, PLYWOOD), MODEL.slider.hitch
    rows = [taken.stages[-1] for taken in drag.legs[0].phase.phase.steps]
    assert len(rows) > 8
    for row in rows:
        theta, spin = float(row[0]), float(row[2]) / MODEL.unit
        c, s = math.cos(towards - theta), math.sin(towards - theta)
        found = minimize_scalar(
            lambda w, c=c, s=s, t=theta: float(surface.dissipation((c + w * hy, s - w * hx, w), t)),
            bracket=(spin - 3.0, spin + 2.0),
            tol=1e-12,
        )
        assert abs(found.x - spin) < 1e-5 * 20.0


def test_the_ring_goes_where_it_is_told_and_the_forces_balance():
    drag = MODEL.drag(Pose(0.0, 0.0, 2.0), ((0.1, 0.0), (0.1, 0.1), (0.0, 0.0)))
    assert len(drag.legs) == 3
    assert np.allclose(MODEL.ring_place(drag.end), (0.0, 0.0), atol=1e-16)
    ring = MODEL.ring_place(Pose(0.0, 0.0, 2.0))
    legs = (math.hypot(0.1 - ring[0], ring[1]), 0.1, math.hypot(0.1, 0.1))
    assert abs(drag.length - sum(legs)) < 1e-15
    trajectory = drag.trajectory
    assert abs(trajectory.path[-1] - drag.length) < 1e-15
    assert set(trajectory.mode) == {"ring"}
    assert np.allclose(trajectory.contact_point, trajectory.pusher)
    errors = balance_errors(MODEL, [leg.phase for leg in drag.legs], trajectory)
    assert errors.max() < 1e-10
    assert len(errors) > 10


def test_cutting_a_straight_leg_in_two_changes_nothing():
    start = Pose(0.1, 0.05, 1.0)
    ring = np.array(MODEL.ring_place(start))
    whole = MODEL.drag(start, ((0.0, 0.0),))
    for share in (0.1, 0.5, 0.77):
        cut = MODEL.drag(start, (tuple(share * ring), (0.0, 0.0)))
        assert abs(cut.turn - whole.turn) < 1e-9
        assert abs(cut.length - whole.length) < 1e-15


def test_a_ring_that_is_already_there_moves_nothing():
    start = Pose(0.1, 0.05, 1.0)
    here = MODEL.ring_place(start)
    drag = MODEL.drag(start, (here, here))
    assert drag.legs == ()
    assert (drag.turn, drag.length, drag.end) == (0.0, 0.0, start)
    with pytest.raises(InvalidInput, match="no length"):
        _ = drag.trajectory
    assert MODEL.drag(start, (here, (0.0, 0.0))).turn == MODEL.drag(start, ((0.0, 0.0),)).turn


def test_a_long_drag_without_anisotropy_ends_with_the_ring_ahead():
    model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.3))
    for theta in np.random.default_rng(2).uniform(-3, 3, 5):
        drag = model.drag(Pose(0.0, 0.0, theta), ((20.0, 0.0),))
        ahead = drag.end.theta + math.atan2(model.slider.hitch[1], model.slider.hitch[0])
        assert abs(math.remainder(ahead - drag.legs[0].phase.motion.rod.direction, 2.0 * math.pi)) < 1e-7


def test_a_ring_in_the_centre_of_pressure_turns_nothing():
    slider = Slider(Slider.mit("hex").outline, hitch=(0.0, 0.0))
    drag = QuasiStaticModel(slider, PLYWOOD).drag(Pose(0.05, 0.1, 0.4), ((0.0, 0.0),))
    assert abs(drag.turn) < 1e-15


def test_drags_of_random_objects_balance_and_reach_their_accuracy():
    checked = 0
    for seed in range(40, 60):
        case = random_case(seed)
        pushed, drag = case.run()
        errors = balance_errors(case.model, [leg.phase for leg in drag.legs], drag.trajectory)
        assert errors.max() < 1e-10
        fine = QuasiStaticModel(case.model.slider, case.model.friction, case.model.pusher, accuracy=1e-10)
        assert abs(fine.drag(pushed.end, ((0.0, 0.0),)).turn - drag.turn) < 1e-6
        checked += len(errors)
    assert checked > 60


def test_way_points_that_are_no_numbers_are_refused():
    with pytest.raises(InvalidInput, match="way-point x"):
        MODEL.drag(Pose(), ((float("nan"), 0.0),))
