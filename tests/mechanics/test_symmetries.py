"""What must not change a push or a drag: units, place, mass, a turn of everything, a mirror."""

import math
from dataclasses import replace

import numpy as np
import pytest
from random_cases import random_case, sized

from cyclemap.mechanics import EllipseFriction, Polygon, Pose, SidePush, Slider

SEEDS = (0, 3, 6, 9, 11, 25)
every_case = pytest.mark.parametrize("seed", SEEDS)


def outcome(case):
    """Turns of push and drag, displacement in the initial frame."""
    push, drag = case.run()
    return np.array((push.turn, drag.turn, *push.displacement))


def accurate(seed):
    return random_case(seed, accuracy=1e-9)


def turned_pose(pose, angle):
    c, s = math.cos(angle), math.sin(angle)
    return Pose(c * pose.x - s * pose.y, s * pose.x + c * pose.y, pose.theta + angle)


@every_case
def test_scaling_every_friction_force_and_the_mass_changes_no_digit(seed):
    """Nothing of the engine is measured in absolute friction."""
    case, law = accurate(seed), accurate(seed).model.friction
    for factor in (1e-9, 1e-4, 7.0, 1e3):
        scaled = EllipseFriction(*(factor * v for v in (law.mu_a, law.mu_b, law.m0, law.n0)), law.phi)
        model = replace(case.model, friction=scaled, slider=replace(case.model.slider, mass=factor))
        assert np.abs(outcome(replace(case, model=model)) - outcome(case)).max() < 1e-12


@every_case
def test_scaling_every_length_scales_displacements_and_nothing_else(seed):
    case = accurate(seed)
    for factor in (1e-4, 300.0):
        found = outcome(sized(case, factor))
        assert np.abs(found / (1.0, 1.0, factor, factor) - outcome(case)).max() < 1e-8


@every_case
def test_turning_surface_and_object_together_changes_nothing(seed):
    case, angle = accurate(seed), 1.234
    model = replace(case.model, friction=case.model.friction.turned(angle))
    turned = replace(case, model=model, pose=turned_pose(case.pose, angle))
    assert np.abs(outcome(turned) - outcome(case)).max() < 1e-8


@every_case
def test_a_mirror_image_moves_as_the_mirror_image(seed):
    case = accurate(seed)
    law, slider = case.model.friction, case.model.slider
    mirrored = EllipseFriction(law.mu_a, law.mu_b, law.m0, -law.n0, -law.phi)
    outline, side, fraction = slider.outline, case.push.side, 1.0 - case.push.fraction
    if isinstance(outline, Polygon):
        # Mirrored in the x axis and kept counter-clockwise behind vertex 0: side i becomes side k - 1 - i.
        outline, side = (
            Polygon(tuple(map(tuple, np.roll(outline.array[::-1] * (1.0, -1.0), 1, axis=0)))),
            outline.sides - 1 - case.push.side,
        )
    image = Slider(outline, hitch=(slider.hitch[0], -slider.hitch[1]))
    model = replace(case.model, friction=mirrored, slider=image)
    pose = Pose(case.pose.x, -case.pose.y, -case.pose.theta)
    push = SidePush(side, fraction, -case.push.angle, case.push.distance)
    found = outcome(replace(case, model=model, pose=pose, push=push))
    assert np.abs(found * (-1.0, -1.0, 1.0, -1.0) - outcome(case)).max() < 1e-8
