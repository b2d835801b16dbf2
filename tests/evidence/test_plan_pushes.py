"""Pushes are chosen by the covariance that they leave: its derivatives, its updates, and what
choosing is worth.
"""

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.evidence import PushPlan, plan_pushes
from cyclemap.evidence.identification.stroke_block import loop_on
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.plan_pushes import candidate_pushes, in_room
from cyclemap.evidence.push_design import (
    TARGETS,
    UNKNOWNS,
    Design,
    SampledBeliefs,
    over_noise,
    push_sensitivity,
    target_of,
)
from cyclemap.evidence.pushes.measured_strokes import READ, push_noise
from cyclemap.mechanics import Pose, Slider

NOISE = push_noise(READ)[:3]
PLATE = replace(Slider.mit("rect1"), name="plate")
PLYWOOD = cm.CollectionLoop.mit("plywood", slider=PLATE)
UNKNOWN = cm.CollectionLoop.mit("unknown", slider=PLATE)
TRUTH = SurfaceParameters.from_friction(
    PLYWOOD.material.friction, pusher_friction=0.15, floor_dome=1.0
)
EACH_TARGET = pytest.mark.parametrize("target", TARGETS)
# Deviations of what is believed of each unknown, and steps of differences.
WIDTHS = dict.fromkeys(UNKNOWNS, 0.05) | dict.fromkeys(UNKNOWNS[4:10], 3.0) | {UNKNOWNS[-1]: 5e-4}


def believed() -> SampledBeliefs:
    """Plywood of Table I, which locks in, and widely what may be otherwise."""
    covariance = np.diag([WIDTHS[name] ** 2 for name in UNKNOWNS])
    return SampledBeliefs(PLYWOOD, (TRUTH.values(),), covariance)


@cache
def planned(target: str = "direction") -> PushPlan:
    """A small plan on a floor that nobody has measured."""
    return plan_pushes(UNKNOWN, 4, target=target, samples=5, candidates=24)


@cache
def design(target: str) -> Design:
    known = believed()
    offered = candidate_pushes(PLYWOOD, 14, math.radians(15.0), 0.15, 0)
    made = [push.measured(PLATE, PLYWOOD.pusher.radius) for push in offered]
    _, by, measured = push_sensitivity(known, made, READ)
    return Design(known.covariance, measured, target_of(known, target, by, NOISE))


def stable_theta(values: dict[str, float]) -> float:
    loop = replace(loop_on(SurfaceParameters.from_values(values), PLYWOOD), accuracy=1e-9)
    orbits = cm.fixed_points(loop.circle_map(1e-8))
    return next(float(orbit.points[0]) for orbit in orbits if orbit.stable)


NAMES = ["ellipticity_x", "offset_y", "pusher_friction", "plate_warp_x", "pin_friction_radius"]


@pytest.mark.parametrize("name", NAMES)
def test_the_gradient_of_a_stable_direction_is_that_of_fixed_points_of_the_exact_map(name) -> None:
    wanted = target_of(believed(), "direction", np.zeros((1, 1, 3, len(UNKNOWNS))), NOISE)
    values, step = TRUTH.values(), 1e-3 * WIDTHS[name]
    at, up, on = (stable_theta(values | {name: values[name] + k * step}) for k in range(3))
    slope = (4.0 * up - on - 3.0 * at) / (2.0 * step)
    gradient = wanted.gradient[0, 1, UNKNOWNS.index(name)]
    assert gradient == pytest.approx(slope, rel=0.02, abs=5e-3 / WIDTHS[name])


@EACH_TARGET
def test_what_one_more_push_tells_is_what_the_larger_set_tells(target: str) -> None:
    made = design(target)
    losses = made.with_one_more([3, 5])
    for index in (0, 7, 13):
        assert losses[index] == pytest.approx(made.loss([3, 5, index]), rel=1e-8)
    assert np.isinf(losses[[3, 5]]).all()


@EACH_TARGET
def test_more_pushes_never_tell_less_and_every_order_of_a_set_tells_the_same(target: str) -> None:
    made = design(target)
    chosen = made.greedy(6, range(14))
    variances = [made.variance(chosen[:count]) for count in range(7)]
    assert len(set(chosen)) == 6
    for before, after in itertools.pairwise(variances):
        assert (after <= before * (1.0 + 1e-9)).all()
    assert sorted(made.greedy(6, chosen)) == sorted(chosen)
    assert made.loss(chosen[::-1]) == pytest.approx(made.loss(chosen), rel=1e-9)


@EACH_TARGET
def test_the_chosen_set_is_near_the_best_of_all_sets(target: str) -> None:
    made = design(target)

    def criterion(chosen: tuple[int, ...]) -> float:
        fewer = [made.loss([other for other in chosen if other != index]) for index in chosen]
        return made.loss(list(chosen)) + float(np.mean(fewer))

    every = [criterion(chosen) for chosen in itertools.combinations(range(14), 3)]
    chosen = made.exchanged(made.greedy(3, range(14)))
    assert criterion(tuple(chosen)) <= np.quantile(every, 0.05)


@EACH_TARGET
def test_a_plan_tells_more_than_random_pushes_and_says_what_a_lost_one_costs(target: str) -> None:
    plan = planned(target)
    first, last = plan.knowledge[0], plan.knowledge[-1]
    assert first.pushes == 0 and first.planned == pytest.approx(first.random)
    after = next(step for step in plan.knowledge if step.pushes == 4)
    for name, error in after.planned.items():
        assert last.planned[name] <= error * 1.05 and error <= first.planned[name]
        assert plan.without[name] >= error * (1.0 - 1e-6)
    assert sum(after.planned.values()) < sum(after.random.values())


def test_pushes_stay_in_the_room_on_the_grid_and_differ() -> None:
    plan = planned()
    assert len(set(plan.pushes)) == 4
    for push, end in zip(plan.pushes, plan.ends, strict=True):
        off_grid = math.remainder(push.start.theta, math.radians(15.0))
        assert off_grid == pytest.approx(0.0, abs=1e-9)
        reached = [*push.rod(PLATE, plan.loop.pusher.radius)]
        for pose in (push.start, Pose(*end)):
            reached += [pose.to_world(*corner) for corner in PLATE.outline.vertices]
        reached = np.array(reached)
        assert (reached >= -1e-3).all() and (reached <= np.array(plan.room) + 1e-3).all()


def test_a_robot_turns_objects_to_any_angle_and_pushes_go_no_further_than_told() -> None:
    free = candidate_pushes(PLYWOOD, 30, None, 0.06, 0)
    off_grid = [math.degrees(push.start.theta) % 15.0 for push in free]
    assert max(off_grid) > 1.0 and {push.push.distance for push in free} == {0.05}
    assert {push.push.side for push in free} == {0, 1, 2, 3}


def test_a_push_that_needs_more_than_the_room_is_left_out() -> None:
    push = candidate_pushes(PLYWOOD, 1, None, 0.15, 0)[0]
    end = np.array([[0.1, 0.0, push.start.theta]])
    assert in_room(push, end, PLYWOOD, (0.6, 0.6)) is not None
    assert in_room(push, end, PLYWOOD, (0.12, 0.6)) is None


@pytest.mark.parametrize(
    ("count", "asked", "told"),
    [
        (33, {}, "33, of at most 32"),
        (8, {"target": "fate"}, "not 'fate'"),
        (8, {"grid": 0.0}, "grid must be positive"),
        (8, {"grid": 7.0}, "grid must be at most 2 pi rad, not 7"),
        (8, {"room": (math.inf, 0.4)}, "width and depth of a room must be a finite number"),
        (8, {"seed": -1}, "seed must be at least 0"),
        (8, {"candidates": 10**12}, "3e\\+13, of at most 5e\\+04"),
        (8, {"samples": 400}, "samples times candidates: 6.4e\\+04"),
        (2, {"room": (0.1, 0.1), "samples": 2, "candidates": 4}, "100 x 100 mm holds 0 of 4"),
    ],
)
def test_what_cannot_be_planned_is_refused_with_the_mend(count, asked, told) -> None:
    refused(plan_pushes, UNKNOWN, count, **asked, told=told)


def test_a_floor_that_is_known_for_certain_is_not_planned_for() -> None:
    refused(plan_pushes, PLYWOOD, told="plywood.*--floor unknown")


def test_a_push_that_depends_on_where_the_rod_is_set_tells_less() -> None:
    """Of one number the noise is the root of both squares; without a rod's error its own."""
    noise, by = np.array([1e-3, 1e-3, 0.02]), np.ones((1, 3, 1))
    assert over_noise(by, np.zeros((1, 3, 3)), noise)[0, :, 0] == pytest.approx(1.0 / noise)
    turning = np.zeros((1, 3, 3))
    turning[0, 2, 0] = 0.03
    weight = over_noise(by, turning, noise)[0, :, 0]
    assert weight == pytest.approx([1e3, 1e3, 1.0 / math.hypot(0.02, 0.03)])
