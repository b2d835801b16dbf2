"""Portrait and forecast of a loop: every number checked on maps whose answers are known in closed
form.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.arrays import placed
from cyclemap.collection import portrait, staircase_forecast
from cyclemap.collection.portrait import DEFAULT_SIGMA, turn_statistics
from cyclemap.collection.portrait_curves import cobweb, portrait_curves, turn_curve
from cyclemap.maps import CircleMap

TURN = 2 * np.pi


def sawtooth() -> CircleMap:
    """The turn climbs from -1 at the jump, θ = 1, to π - 1 just before it a turn later:
    slope 3/2."""

    def lift(theta):
        phase = np.mod(theta - 1.0, TURN)
        return theta + phase / 2 - 1.0

    return CircleMap(lift, lambda theta: np.full_like(theta, 1.5), breaks=(1.0,))


def test_statistics_do_not_smooth_a_jump() -> None:
    turns = turn_statistics(sawtooth())
    assert turns.mean_turn == pytest.approx(np.pi / 2 - 1.0, abs=1e-12)
    assert turns.min_turn == pytest.approx(-1.0, abs=1e-3)
    assert turns.max_turn == pytest.approx(np.pi - 1.0, abs=1e-3)
    assert turns.max_slope == 1.5


def sampled(count):
    theta = np.linspace(0.0, TURN, count)
    return CircleMap.from_samples(
        theta, theta + 0.3 + 0.2 * np.sin(theta), 1.0 + 0.2 * np.cos(theta)
    )


@pytest.mark.parametrize("count", [25, 200])
def test_the_mean_over_cubics_is_exact(count) -> None:
    """A cubic's integral is h (f0 + f1)/2 + h^2 (f0' - f1')/12 (Euler and Maclaurin)."""
    circle_map, theta = sampled(count), np.linspace(0.0, TURN, count)
    turn, slope, width = circle_map.turn(theta), 0.2 * np.cos(theta), np.diff(theta)
    turn[-1] = turn[0]
    whole = np.sum(width * (turn[:-1] + turn[1:]) / 2 + width**2 * (slope[:-1] - slope[1:]) / 12)
    found = turn_statistics(circle_map)
    assert found.mean_turn == pytest.approx(whole / TURN, abs=1e-14)
    # The extremes lie between nodes at most π/150 apart, here and there: 0.2 (π/300)^2 / 2 at most
    # is missed.
    assert found.min_turn == pytest.approx(0.1, abs=2e-5)
    assert found.max_turn == pytest.approx(0.5, abs=2e-5)
    assert found.min_slope == pytest.approx(0.8, abs=1e-3) and found.max_slope == pytest.approx(
        1.2, abs=1e-3
    )


def test_portrait_without_fixed_points_draws_the_cycle_from_zero(loop_of) -> None:
    reported: list[float] = []
    found = portrait(loop_of(CircleMap.arnold(0.2, 0.5)), cycles=50, progress=reported.append)
    assert found.fixed_points == found.stable_points == () and found.cycle.theta == 0.0
    assert found.noise.sigma == DEFAULT_SIGMA and found.staircase.theta.shape == (51,)
    assert reported == sorted(reported) and reported[-1] == 1.0


def test_of_two_stable_points_the_more_visited_comes_first(loop_of) -> None:
    # Both wells of this map pull; the one at 0 pulls harder and from farther.
    uneven = CircleMap(lambda theta: theta - 0.2 * np.sin(2 * theta) - 0.1 * np.sin(theta))
    found = portrait(loop_of(uneven), sigma=0.3, cycles=50)
    places = [float(orbit.points[0]) for orbit in found.stable_points]
    assert places == [pytest.approx(0.0, abs=1e-9), pytest.approx(np.pi, abs=1e-9)]
    assert (
        found.cycle.theta == places[0]
        and found.rotation.locked == 0
        and len(found.fixed_points) == 4
    )
    assert found.stable_points[0].multiplier == pytest.approx(0.5)


def test_turn_curve_ends_at_the_jump_on_both_sides() -> None:
    curve = turn_curve(sawtooth())
    assert len(curve.pieces) == 2
    (left, left_turn), (right, right_turn) = curve.pieces
    assert left[-1] < 1.0 < right[0]
    assert right[0] - left[-1] < 1e-7
    assert left_turn[-1] == pytest.approx(np.pi - 1.0, abs=1e-7)
    assert right_turn[0] == pytest.approx(-1.0, abs=1e-7)
    assert [(jump.theta, jump.before, jump.after) for jump in curve.jumps] == [
        (1.0, pytest.approx(np.pi - 1.0), pytest.approx(-1.0))
    ]


@pytest.mark.slow
def test_cobweb_corners_lie_in_turn_on_the_diagonal_and_on_the_graph(loop_of) -> None:
    """Of a map that hops to and fro they stay few; the density drawn is one."""
    circle_map = CircleMap.arnold(0.0, 0.5)
    found = portrait(loop_of(circle_map), cycles=10)
    web, curves = cobweb(found), portrait_curves(found)
    assert len(web.paths) == 2
    for path in web.paths:
        assert len(path) >= 7
        assert np.allclose(path[0::2, 0], path[0::2, 1], atol=0)
        assert np.allclose(circle_map(path[1::2, 0]), path[1::2, 1], atol=1e-13)
        # Both settle at the stable point, here 0.
        assert abs(path[-1, 0]) < 1e-3
    assert np.trapezoid(curves.density, curves.density_theta) == pytest.approx(1.0, abs=1e-6)
    flip = CircleMap(lambda theta: theta - 1.999 * np.sin(theta))
    assert all(len(path) < 100 for path in cobweb(portrait(loop_of(flip), cycles=10)).paths)


def test_a_cycle_moves_the_outline_rigidly_and_brings_the_ring_home(real_loop) -> None:
    """Forces push the object along; the drag begins where the push ended."""
    course, slider = real_loop.cycle(0.7).trajectory, real_loop.slider
    outline, hitch = slider.outline_points(), np.array(slider.hitch)
    for stroke in (course.push, course.drag):
        sides = [np.hypot(*np.diff(placed(pose, outline), axis=0).T) for pose in stroke.pose]
        assert np.allclose(sides, sides[0], atol=1e-12)
        assert (stroke.contact_force @ (stroke.pusher[-1] - stroke.pusher[0]) > 0).all()
    assert np.allclose(course.push.pose[-1], course.drag.pose[0], atol=1e-9)
    assert np.allclose(placed(course.push.pose[0], hitch), 0.0, atol=1e-12)
    assert np.allclose(placed(course.drag.pose[-1], hitch), 0.0, atol=1e-9)
    assert np.allclose(course.drag.pusher[0], placed(course.push.pose[-1], hitch), atol=1e-9)


def test_residences_that_a_float_can_hold_are_told_alike_by_their_logarithm(loop_of) -> None:
    found = staircase_forecast(loop_of(CircleMap.arnold(0.1, 0.9)), sigma=0.4, cycles=500)
    (zone,) = found.prediction.zones
    assert zone.kind == "stable"
    assert found.log10_residences[0] == pytest.approx(math.log10(zone.residence_cycles), abs=1e-12)


@pytest.mark.slow
def test_long_residences_grow_as_one_over_the_noise_squared(loop_of) -> None:
    """Freidlin and Wentzell: σ² ln T tends to a constant of the map, however long T; whole turns
    move no direction.
    """
    wide, narrow, turning = (
        staircase_forecast(loop_of(CircleMap.arnold(omega, 0.9)), sigma=sigma, cycles=10)
        for omega, sigma in ((0.1, 0.056), (0.1, 0.028), (1.1, 0.028))
    )
    assert narrow.prediction.mean_residence_cycles == math.inf
    assert narrow.log10_residences[0] > 300.0
    assert narrow.log10_residences[0] / wide.log10_residences[0] == pytest.approx(4.0, rel=0.03)
    assert turning.prediction.zones[0].winding == 1
    assert turning.log10_residences[0] == pytest.approx(float(narrow.log10_residences[0]), rel=1e-9)


def test_the_steps_of_a_run_past_a_ghost_are_whole_turns_of_the_predicted_length(loop_of) -> None:
    found = staircase_forecast(
        loop_of(CircleMap.arnold(0.0955, 0.6)), sigma=0.03, cycles=20_000, seed=3
    )
    assert found.prediction.step == pytest.approx(2 * np.pi)
    assert found.steps.count > 50
    assert np.median(found.steps.heights) == pytest.approx(2 * np.pi, abs=0.05)
    assert (
        abs(found.comparison.net_steps - found.comparison.expected_steps)
        < 4 * found.comparison.net_error
    )


@pytest.mark.slow
def test_plywood_of_the_paper_climbs_in_whole_turns_but_hardly_ever(real_loop) -> None:
    found = staircase_forecast(real_loop, cycles=200)
    assert math.degrees(found.prediction.step) == pytest.approx(360.0)
    assert found.log10_residences[0] == pytest.approx(683.81, abs=0.1)
    assert found.log10_residences[0].error_bound < 1e-6
    assert found.steps.count == 0


def test_nonsense_is_refused(loop_of) -> None:
    loop = loop_of(CircleMap.arnold(0.1, 0.5))
    for sigma in (0.0, -1.0, np.nan):
        refused(portrait, loop, sigma=sigma, told="sigma")
    refused(portrait, loop, cycles=0, told="cycles")
    refused(staircase_forecast, loop, sigma=0.0, told="sigma")
    for asked in (portrait, staircase_forecast):
        refused(asked, 5, told="loop must be a CollectionLoop.*, not 5")
