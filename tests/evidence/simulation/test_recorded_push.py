"""A recorded push or scan is the mechanics' own, on the clocks and in the frames of the measured
files.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.pushes.contact_forces import contact_force_ratio
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.evidence.recorded_push import (
    SCAN_CENTRE,
    Recording,
    RecordingNoise,
    record_push,
    record_scan,
)
from cyclemap.evidence.simulated_collection import simulate_collection
from cyclemap.mechanics import EllipseFriction, Pose, Pusher, SidePush, Slider

LOOP = CollectionLoop.mit("plywood", accuracy=1e-8)
TARGET = np.array([0.350, -0.030])
# The whole 150 mm lose the object just before their end; 120 mm do not.
SHORT = replace(LOOP, push=SidePush(distance=0.12))
FRICTION, WEIGHT = LOOP.material.friction, LOOP.model.weight
QUIET = Recording(noise=RecordingNoise(turn=0.0))
RADIUS = 0.00475
# Where, and how fast, the rod is: it rests for 0.25 s, and touches after 1 mm.
TOUCH = 0.25 + 0.001 / 0.02


def recorded(theta, loop=LOOP, recording=QUIET, steps=60, seed=0):
    push, _ = loop.strokes(theta, loop.push.distance / steps)
    return push, record_push(push, loop.push.distance, recording, np.random.default_rng(seed))


def elapsed(rows):
    return rows[:, 0] - QUIET.start


def whole_way(record):
    """The tip's way (2,) from its first recorded place to its last."""
    return record.tip_pose[-1, 1:3] - record.tip_pose[0, 1:3]


def in_object_frame(record):
    """The tip's places (n,) in the object's frame, at the object's times from the tip's first on."""
    time, x, y, angle = record.object_pose[3:-3].T
    tip_x, tip_y = (np.interp(time, record.tip_pose[:, 0], record.tip_pose[:, k]) for k in (1, 2))
    return time, (tip_x - x + 1j * (tip_y - y)) * np.exp(-1j * angle)


@pytest.mark.parametrize("theta", [0.0, -2.9, 7.5])
def test_start_end_turn_and_displacement_are_those_of_the_cycle(theta) -> None:
    """Two integrations with other steps; the ring lies on the arena's target."""
    cycle = LOOP.cycle(theta)
    _, record = recorded(theta)
    assert record.displacement == pytest.approx(cycle.push_displacement, abs=1e-8)
    assert record.turn == pytest.approx(cycle.push_turn, abs=1e-7)
    start, pose = LOOP.start_pose(theta), record.start
    assert pose[:2] == pytest.approx((TARGET[0] + start.x, TARGET[1] + start.y), abs=1e-15)
    assert math.remainder(pose[2] - theta, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-14)
    ring = Pose(*pose).to_world(*LOOP.slider.hitch)
    assert ring == pytest.approx(TARGET, abs=1e-15)
    assert np.all(np.abs(record.object_pose[:, 3]) <= math.pi)


@pytest.mark.parametrize("theta", [0.0, 4.0])
def test_between_the_steps_the_record_is_that_of_a_run_ten_times_finer(theta) -> None:
    _, coarse = recorded(theta)
    _, fine = recorded(theta, steps=600)
    assert np.abs(coarse.object_pose[:, 1:3] - fine.object_pose[:, 1:3]).max() < 1e-6
    assert np.abs(coarse.object_angle - fine.object_angle).max() < 1e-5
    # Where the contact changes between sticking and sliding the force has a kink, never a jump.
    assert np.abs(coarse.ft_wrench[:, 1:3] - fine.ft_wrench[:, 1:3]).max() < 1e-3


@pytest.mark.parametrize("theta", [0.0, 4.0])
def test_the_rod_comes_over_one_millimetre_and_then_touches_all_the_time(theta) -> None:
    push, record = recorded(theta, SHORT)
    assert push.ended == "distance"
    time, place = in_object_frame(record)
    apart = (np.maximum(np.abs(part) - 0.045, 0.0) for part in (place.real, place.imag))
    distance, since = np.hypot(*apart), time - QUIET.start
    # Across the rod's start and stop its way between two samples is not straight.
    touching = (since >= TOUCH) & (np.abs(since - TOUCH - 6.0) > 0.004)
    assert np.count_nonzero(touching) > 1500
    assert distance[touching] == pytest.approx(RADIUS, abs=2e-6)
    assert distance[since <= 0.249] == pytest.approx(RADIUS + 0.001, abs=1e-9)


def test_clocks_run_at_250_hz_and_begin_one_after_the_other() -> None:
    _, record = recorded(0.0)
    seconds = 0.5 + 0.151 / 0.02
    series = (record.object_pose, record.tip_pose, record.ft_wrench)
    for rows, lag in zip(series, (0.0, 0.009, 0.011), strict=True):
        assert elapsed(rows)[0] == pytest.approx(lag, abs=1e-6)
        assert np.diff(rows[:, 0]) == pytest.approx(0.004, abs=1e-6)
        assert seconds <= elapsed(rows)[-1] <= seconds + 0.016
    still = (elapsed(record.object_pose) < TOUCH) | (elapsed(record.object_pose) > TOUCH + 7.5)
    resting = record.object_pose[still, 1:]
    assert len(resting) > 130 and len(np.unique(resting, axis=0)) == 2


@pytest.mark.parametrize("speed", [0.005, 0.1])
def test_the_rod_goes_at_the_speed_asked_for_and_the_way_is_the_same(speed) -> None:
    _, record = recorded(1.0, recording=replace(QUIET, speed=speed))
    step = np.hypot(*np.diff(record.tip_pose[:, 1:3], axis=0).T) / np.diff(record.tip_pose[:, 0])
    moving = step > 0.0
    assert np.count_nonzero(moving) > 370 and step[moving][1:-1] == pytest.approx(speed, rel=1e-6)
    assert np.hypot(*whole_way(record)) == pytest.approx(0.151, abs=1e-12)
    assert record.turn == recorded(1.0)[1].turn


@pytest.mark.parametrize("friction", [0.05, 0.3])
def test_forces_read_back_give_the_pushers_friction_where_the_contact_slides(friction) -> None:
    """A slippery rod slides most of the way: the median ratio is its friction."""
    loop = replace(LOOP, pusher=Pusher(friction=friction), push=SidePush(fraction=0.7, angle=0.9))
    push, record = recorded(0.3, loop)
    slides = np.char.startswith(push.trajectory.mode.astype(str), "slide")
    assert slides.mean() > 0.6
    ratio = contact_force_ratio(record, loop.slider.outline_points())
    assert ratio == pytest.approx(friction, rel=1e-5)


def test_the_wrench_is_nothing_before_touch_held_at_rest_and_within_the_cone() -> None:
    _, record = recorded(0.0, SHORT)
    time, wrench = elapsed(record.ft_wrench), record.ft_wrench[:, 1:]
    force = np.hypot(*wrench[:, :2].T)
    assert np.all(wrench[time < TOUCH] == 0.0) and force[time > TOUCH + 0.01].min() > 0.5
    assert np.all(wrench[time >= TOUCH + 6.0] == wrench[-1])
    # The contact's force has the lever of one radius: torque² = radius² (force² - normal²).
    bound = RADIUS * force * math.sin(math.atan(0.15))
    assert np.all(np.abs(wrench[:, 2]) <= bound * (1.0 + 5e-6))
    assert np.count_nonzero(np.abs(wrench[:, 2]) > 0.999 * bound) > 300


def test_a_disc_pushed_through_its_centre_pushes_back_with_friction_times_weight() -> None:
    even = replace(LOOP.material, friction=EllipseFriction.isotropic(0.25))
    loop = CollectionLoop(Slider.mit("ellip1"), even, push=SidePush(0, 0.3))
    _, record = recorded(0.4, loop)
    force = record.ft_wrench[elapsed(record.ft_wrench) > TOUCH, 1:3]
    assert len(force) > 1900
    assert np.hypot(*force.T) == pytest.approx(0.25 * 0.8937 * 9.80665, rel=1e-6)
    assert record.turn == pytest.approx(0.0, abs=1e-8)
    assert np.all(force @ whole_way(record) < 0.0)


def test_a_rod_that_loses_the_object_goes_on_alone_without_force() -> None:
    loop = replace(LOOP, pusher=Pusher(friction=0.0), push=SidePush(fraction=0.97, angle=-0.6))
    push, record = recorded(0.5, loop)
    assert push.ended == "left" and push.travel < 0.12
    left = TOUCH + push.travel / 0.02
    wrench, pose = (
        rows[elapsed(rows) > left, 1:] for rows in (record.ft_wrench, record.object_pose)
    )
    assert len(wrench) > 300 and np.all(wrench == 0.0) and np.all(pose == pose[-1])
    assert np.hypot(*whole_way(record)) == pytest.approx(0.151, abs=1e-12)


def test_measurement_noise_has_the_deviations_asked_for_and_leaves_the_tip_alone() -> None:
    asked = RecordingNoise(turn=0.0, position=2e-4, angle=3e-3, force=0.05)
    _, quiet = recorded(3.1)
    _, noisy = recorded(3.1, recording=replace(QUIET, noise=asked), seed=7)
    pose = noisy.object_pose[:, 1:] - quiet.object_pose[:, 1:]
    pose[:, 2] = np.remainder(pose[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    wrench = noisy.ft_wrench[:, 1:] - quiet.ft_wrench[:, 1:]
    still, scan = (
        record_scan(FRICTION, WEIGHT, 1.0, replace(QUIET, noise=noise), np.random.default_rng(0))
        for noise in (RecordingNoise(), asked)
    )
    of_wrenches = [0.05, 0.05, 0.05 * RADIUS]
    scanned = scan.ft_wrench[:, 1:] - still.ft_wrench[:, 1:]
    asked_of = ((pose, [2e-4, 2e-4, 3e-3]), (wrench, of_wrenches), (scanned, of_wrenches))
    for error, deviation in asked_of:
        assert len(error) > 1600
        # Standard errors from 1600 draws: 1.8 % of a deviation, 2.5 % of it for a mean.
        assert error.std(axis=0) == pytest.approx(deviation, rel=0.07)
        assert np.abs(error.mean(axis=0) / deviation).max() < 0.1
        assert np.abs(np.corrcoef(error.T) - np.eye(3)).max() < 0.1
    assert np.array_equal(noisy.tip_pose, quiet.tip_pose) and np.array_equal(scan.tip, still.tip)


@pytest.mark.parametrize("field", ["turn", "position", "angle", "force"])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_noise_that_is_none_is_refused_by_name(field, value) -> None:
    refused(RecordingNoise, told=f"noise of the {field}", **{field: value})


def test_a_rod_that_does_not_move_or_a_stroke_shorter_than_the_push_is_refused() -> None:
    refused(Recording, speed=0.0, told="speed of the rod must be positive")
    push, _ = SHORT.strokes(0.0, 0.01)
    told = r"went 0\.12 m, further than the stroke of 0\.1 m"
    refused(record_push, push, 0.1, QUIET, np.random.default_rng(0), told=told)


def test_scans_are_twice_every_five_degrees_with_the_point_laws_forces(tmp_path) -> None:
    made = simulate_collection(LOOP, tmp_path / "made", 1, scans=True)
    table = load_pushes(made.folder)
    assert not table.unreadable and len(table.table) == 1
    scans = table.scans
    assert made.scans == len(scans) == 144
    degrees = np.degrees(scans["direction"]).round(9)
    assert sorted(set(zip(degrees, scans["repetition"], strict=True))) == [
        (angle, repetition) for angle in range(0, 360, 5) for repetition in (0.0, 1.0)
    ]
    facts = {tuple(row) for row in scans[["surface", "object", "speed"]].to_numpy().tolist()}
    assert facts == {("plywood", "rect1", 0.02)}
    way = np.stack([np.cos(scans["direction"]), np.sin(scans["direction"])], axis=-1)
    traction = FRICTION.traction(way)
    along = np.sum(traction * way, axis=1)
    across = way[:, 0] * traction[:, 1] - way[:, 1] * traction[:, 0]
    # Recorded times hold 0.2 microseconds: a direction is good to 1e-7.
    assert scans["force_along"].to_numpy() == pytest.approx(WEIGHT * along, rel=1e-6)
    assert scans["ratio"].to_numpy() == pytest.approx(across / along, abs=1e-6)


def test_the_stroke_goes_straight_through_the_scans_centre_and_rests_at_its_ends() -> None:
    scan = record_scan(FRICTION, WEIGHT, 1.0, Recording(), np.random.default_rng(0))
    assert scan.stroke == pytest.approx((0.12 * math.cos(1.0), 0.12 * math.sin(1.0)), abs=1e-12)
    assert (scan.tip[0, 1:3] + scan.tip[-1, 1:3]) / 2.0 == pytest.approx(SCAN_CENTRE, abs=1e-12)
    assert np.all(scan.tip[:60, 1:3] == scan.tip[0, 1:3]) and np.all(scan.ft_wrench[:55, 1:] == 0.0)
    speed = np.hypot(*np.diff(scan.tip[70:-70, 1:3], axis=0).T) / np.diff(scan.tip[70:-70, 0])
    assert speed == pytest.approx(0.02, rel=1e-9)
