"""Friction circles of the ring beyond half its lever: a turn goes on, or ends on its way and is refused by name."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
from force_balance import imbalance
from random_cases import random_friction
from scipy.optimize import brentq

from cyclemap.collection import CollectionLoop
from cyclemap.errors import UnsupportedContact
from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    EllipseFriction,
    LimitSurface,
    PointFootprint,
    Pose,
    QuasiStaticModel,
    Slider,
)
from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.cycle_batch import cycle_batch
from cyclemap.mechanics.runge_kutta import SLOPE

RECT = Slider.mit("rect1")


def random_leg(seed):
    """A random object in a random ring, its friction circle between half the ring's lever and the whole."""
    rng = np.random.default_rng(seed)
    slider, angle = Slider.mit(MIT_SHAPE_NAMES[seed % 7]), rng.uniform(0.0, 2.0 * math.pi)
    lever = rng.uniform(0.2, 1.5) * slider.outline.extent
    hitch = np.array(slider.outline.centroid) + lever * np.array((math.cos(angle), math.sin(angle)))
    model = QuasiStaticModel(replace(slider, hitch=tuple(hitch)), random_friction(rng))
    radius = model.ring_lever * rng.uniform(0.5, 1.0)
    return model, Pose(*rng.uniform(-0.2, 0.2, 2), rng.uniform(-3.0, 3.0)), radius


def test_between_half_the_lever_and_the_whole_a_turning_object_turns_as_the_friction_does_and_balances():
    moved, worst = 0, 0.0
    for seed in range(30):
        model, pose, radius = random_leg(seed)
        assert not model.one_spin(radius)
        course = model.drag(pose, ((0.0, 0.0),), pin_friction_radius=radius)
        if course.trajectory.mode[0] == "ring_stuck":
            continue
        legs = tuple(leg.phase for leg in course.legs)
        turns = np.array([taken.stages[-1, SLOPE][0] for taken in legs[0].phase.steps])
        sense = 1.0 if course.trajectory.mode[0] == "ring_left" else -1.0
        assert (sense * turns > -1e-6).all() and sense * course.turn > 0.0
        worst = max(worst, imbalance(model, legs, course.trajectory, radius))
        moved += 1
    assert moved >= 8
    assert worst < 1e-10


def test_from_the_whole_lever_on_the_ring_always_holds_the_object():
    """Friction in translation acts at the centre of pressure, so that its torque about the ring is its lever's."""
    for seed in range(20):
        model, pose, _ = random_leg(seed)
        for share in (1.0 + 1e-8, 3.0):
            assert model.one_spin(share * model.ring_lever)
            stuck = model.drag(pose, ((0.0, 0.0),), pin_friction_radius=share * model.ring_lever)
            assert set(stuck.trajectory.mode) == {"ring_stuck"} and stuck.turn == 0.0


def fastest_spin(model, theta, direction, radius, sense):
    """The fastest spin of a sense (rad per m of travel) that the ring's friction balances, None if there is none."""
    x, y = model.slider.hitch
    surface, along = LimitSurface(model.pressure, model.friction), direction - theta

    def left(spins):
        spins = sense * np.atleast_1d(spins)
        twists = np.stack([math.cos(along) + spins * y, math.sin(along) - spins * x, spins], axis=-1)
        wrench = surface.wrench(twists, theta)
        return sense * wrench @ np.array((y, -x, 1.0)) + radius * np.hypot(wrench[:, 0], wrench[:, 1])

    spins = np.geomspace(1e-4, 1e2, 120) / model.unit
    changes = np.flatnonzero(np.diff(np.sign(left(spins))))
    return brentq(lambda w: left(w)[0], *spins[changes[-1] : changes[-1] + 2]) if len(changes) else None


def travel_to_stop(model, pose, radius, sense, goal):
    """Travel (m) after which the fastest spin has ended, summed over orientations as long as there is one."""
    ring = model.ring_place(pose)
    direction, travel, step = math.atan2(goal[1] - ring[1], goal[0] - ring[0]), 0.0, 0.01
    for theta in pose.theta + sense * step * (np.arange(100) + 0.5):
        spin = fastest_spin(model, theta, direction, radius, sense)
        if spin is None:
            return travel
        travel += step / spin
    return math.inf


def test_a_turn_on_support_points_may_end_below_half_the_lever_too_and_is_refused_alike():
    """Nearly all of the load on one point: its friction, any within a bound where it rests, may point anywhere."""
    points = (
        (-0.060388567676166176, -0.007593238428438006),
        (0.0559850909957384, -0.0033635291610859238),
        (-0.05215410697299402, 0.05548594275503402),
        (0.07209962157613362, -0.06819412801526911),
    )
    footprint = PointFootprint(points, (0.060471963795, 0.002501867703, 0.009281813356, 0.927744355146))
    law = EllipseFriction(0.46289999226, 0.154390987085, -0.057054628593, -0.121371873601, 6.054906447773)
    slider = replace(Slider.mit("tri3"), hitch=(-0.4518301609523062, 0.15746669745982783))
    model, words = QuasiStaticModel(slider, law, footprint=footprint, accuracy=1e-6), Counter()
    for theta in np.linspace(-4.1, -3.5, 7):
        pose, radius = Pose(-0.2444, 0.4061, theta), 0.477 * model.ring_lever
        try:
            drag = model.drag(pose, ((0.2277, 0.2077),), pin_friction_radius=radius)
            assert imbalance(model, [leg.phase for leg in drag.legs], drag.trajectory, radius) < 1e-9
            words.update(drag.trajectory.mode[:1])
        except UnsupportedContact as told:
            assert "choose a smaller pin friction radius" in str(told)
            words["refused"] += 1
    assert words["refused"] >= 1 and words["ring_left"] + words["ring_right"] >= 1


def test_a_turn_that_the_ring_ends_on_the_way_is_refused_by_name_and_told_where_it_cannot_be():
    """By brute force it ends within the leg; below half the lever it never ends, and the drag is done."""
    law, goal, refused, done = EllipseFriction(0.065, 0.27, -0.007, -0.119, 2.667), (3.0, 0.0), 0, 0
    model = QuasiStaticModel(replace(RECT, hitch=(0.056, 0.056)), law, accuracy=1e-6)
    for theta in np.linspace(-1.75, 2.0, 16):
        pose = Pose(0.1, 0.05, theta)
        try:
            done += model.drag(pose, (goal,), pin_friction_radius=0.911 * model.ring_lever).turn != 0.0
        except UnsupportedContact as told:
            assert "radius is 0.911 times the ring's distance" in str(told)
            ends = [travel_to_stop(model, pose, 0.911 * model.ring_lever, sense, goal) for sense in (1.0, -1.0)]
            assert 0.0 < max(ends) < 2.9
            assert model.drag(pose, (goal,), pin_friction_radius=0.499 * model.ring_lever).turn != 0.0
            refused += 1
    assert refused == 3 and done >= 3


def test_compiled_cycles_are_those_whose_ring_leaves_no_choice_of_spins(monkeypatch):
    monkeypatch.setattr(stroke_runner, "WORTHWHILE", 0)
    loop = CollectionLoop.mit()
    lever = loop.model.ring_lever
    loops = [
        replace(loop, reset=replace(loop.reset, pin_friction_radius=share * lever)) for share in (0.0, 0.4, 0.7, 1.2)
    ]
    assert [one.model.one_spin(one.reset.pin_friction_radius) for one in loops] == [True, True, False, True]
    assert cycle_batch(loops, np.full((4, 1), 0.7), slopes=False).done[:, 0].tolist() == [True, True, False, True]
    turns = [one.cycle(0.7).drag_turn for one in loops]
    assert turns[3] == 0.0 and abs(turns[0]) > 0.0
