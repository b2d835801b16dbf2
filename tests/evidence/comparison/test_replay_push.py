"""A recorded push is replayed along its own tip path, cut into straight strokes."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from made_replays import FRICTION, START, clock, model_of, record_of, world
from refusals import refused

from cyclemap.arrays import along_way
from cyclemap.errors import RodMissesObject
from cyclemap.evidence.comparison.replay_push import BEND, push_along, replay_push, tip_path
from cyclemap.evidence.comparison.replay_table import dataset_sliders
from cyclemap.mechanics import PatchFootprint, Pose, Pusher, QuasiStaticModel, Slider, WorldPush
from cyclemap.mechanics.outline import Ellipse, Polygon


def table(place):
    place = np.asarray(place, dtype=float)
    clock = np.linspace(0.0, 1.0, len(place))
    return np.column_stack([clock, place, np.zeros(len(place))])


@pytest.mark.parametrize("seed", range(2))
def test_a_straight_stroke_with_noise_of_a_tenth_of_a_millimetre_is_one_stroke(seed) -> None:
    random = np.random.default_rng(seed)
    along = np.linspace(0.0, 0.05, 300)[:, None] * np.array([np.cos(seed), np.sin(seed)])
    noisy = along + random.uniform(-0.7e-4, 0.7e-4, (300, 2))
    corners, travel, straightness = tip_path(table(noisy))
    assert len(corners) == 2 and 2e-5 < straightness < 2e-4
    assert np.all(np.diff(travel) >= 0.0) and travel[-1] == pytest.approx(0.05, abs=2e-4)


def test_every_place_of_a_curved_path_is_within_the_bend_of_its_strokes() -> None:
    angle = np.linspace(0.0, 1.5 * np.pi, 700)
    places = 0.04 * np.column_stack([np.cos(angle), np.sin(angle)])
    corners, travel, straightness = tip_path(table(places))
    # Distance of each place from the nearest edge of the chain.
    first, edge = corners[:-1], np.diff(corners, axis=0)
    offset = places[:, None] - first
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    away = np.linalg.norm(offset - share[..., None] * edge, axis=-1).min(axis=1)
    assert away.max() <= BEND
    # A chord over an arc of radius r stays within s where its half-angle h has r (1 - cos h) = s.
    fewest = 1.5 * np.pi / (2.0 * np.arccos(1.0 - BEND / 0.04))
    assert fewest <= len(corners) - 1 <= 2.1 * fewest
    assert travel[-1] == pytest.approx(0.04 * 1.5 * np.pi, rel=0.01) and straightness > 0.05


def test_a_tip_that_trembles_backwards_never_travels_back_and_one_that_stays_is_refused() -> None:
    place = np.column_stack([[0.0, 0.01, 0.0099, 0.02, 0.0198, 0.03], np.zeros(6)])
    assert tip_path(table(place))[1] == pytest.approx([0.0, 0.01, 0.01, 0.02, 0.02, 0.03])
    for far, moved in ((0.0005, r"0\.5"), (0.0, "0")):
        told = f"the tip moves {moved} mm: it pushes nothing"
        refused(tip_path, table([[0.0, 0.0], [far, 0.0]]), told=told)


MILLIMETRE = 1e-3


def simulated(model, place=(0.012, 0.075), direction=-math.pi / 2 + 0.3, distance=0.06, pose=START):
    """A record of one straight push of the simulator, its object's first pose `pose`."""
    start = world(pose, place)
    heading = pose.theta + direction
    push = model.push(pose, WorldPush(tuple(start.tolist()), heading, distance), 0.1 * MILLIMETRE)
    time, travel = clock(distance)
    course, before = push.trajectory, distance - push.travel
    if push.ended == "left":
        before = float(np.hypot(*(course.pusher[0] - start)))
    poses = along_way(travel, before + course.path, course.pose)
    tip = start + np.outer(travel, (math.cos(heading), math.sin(heading)))
    return record_of(time, poses, tip), push


@pytest.mark.parametrize(
    ("name", "place", "direction"),
    [
        ("rect1", (-0.030, 0.060), -1.4),
        ("hex", (0.010, 0.075), -1.9),
        ("ellip3", (0.090, 0.012), 3.0),
        ("ellip1", (0.028, 0.060), -1.5),
    ],
)
def test_the_simulators_own_motion_is_replayed_exactly(name, place, direction) -> None:
    model = model_of(name)
    record, push = simulated(model, place, direction)
    replay = replay_push(record, model)
    told = replay.summary()
    assert told["measured_motion"] > 5 * MILLIMETRE
    assert replay.error.max() < 0.01 * MILLIMETRE
    assert np.abs(replay.turn_error).max() < math.radians(0.01)
    assert max(told["rms_error"], told["rms_turn_error"]) < 1e-5
    assert told["measured_turn"] == pytest.approx(push.turn, abs=1e-5)
    assert replay.strokes == 1
    assert replay.straightness < 1e-9 and np.all(replay.shift == 0.0)
    assert replay.left == (push.ended == "left") and replay.touch_agrees and replay.leaving_agrees


def moved_tip(record, shift):
    tip = record.tip_pose + np.array([0.0, *shift, 0.0])
    return replace(record, tip_pose=tip)


@pytest.mark.parametrize("overlap", [0.3, 4.0])
def test_a_rod_that_starts_inside_is_moved_out_along_the_normal_and_no_further(overlap) -> None:
    """The tip recorded too deep by a constant is a calibration's offset: undone, all is exact."""
    model = model_of("rect1")
    beside = (0.010, 0.045 + model.pusher.radius + 1e-7)
    record, _ = simulated(model, beside, direction=-math.pi / 2)
    inward = world(Pose(0.0, 0.0, START.theta), (0.0, -overlap * MILLIMETRE))
    replay = replay_push(moved_tip(record, inward), model)
    assert replay.shift == pytest.approx(-inward, abs=1e-6)
    assert replay.start_gap == pytest.approx(-overlap * MILLIMETRE, abs=1e-6)
    assert replay.error.max() < 0.01 * MILLIMETRE


def test_an_overlap_of_more_than_5_mm_is_refused_with_its_size() -> None:
    model = model_of("rect1")
    record, _ = simulated(model)
    inside = moved_tip(record, world(START, (0.0, 0.040)) - record.tip_pose[0, 1:3])
    refused(replay_push, inside, model, told=r"starts 9\.75 mm inside the object")


# A path that bends in contact, and one that leaves the object and finds it again from another side.
BENT = [[0.008, 0.1], [0.008, 0.045], [0.018, 0.022]]
AROUND = [[0.0, 0.09], [0.0, 0.03], [0.0, 0.09], [0.11, 0.09], [0.11, -0.02], [0.03, -0.02]]


@pytest.mark.parametrize(
    ("name", "corners"), [("rect1", BENT), ("ellip2", BENT), ("rect1", AROUND)]
)
def test_a_path_that_bends_is_the_same_pushes_one_after_the_other(name, corners) -> None:
    model, pose, share = model_of(name), START, np.linspace(0.0, 1.0, 501)
    places = np.array([world(START, corner) for corner in corners])
    for place, leg in zip(places, np.diff(places, axis=0), strict=False):
        push = WorldPush(tuple(place.tolist()), math.atan2(leg[1], leg[0]), float(np.hypot(*leg)))
        with suppress(RodMissesObject):
            pose = model.push(pose, push).end
    tip = along_way(share, np.linspace(0.0, 1.0, len(places)), places)
    still = np.tile([START.x, START.y, START.theta], (len(share), 1))
    replay = replay_push(record_of(share, still, tip), model)
    assert replay.strokes == len(corners) - 1 and replay.straightness > 1 * MILLIMETRE
    wanted = [pose.x - START.x, pose.y - START.y, pose.theta - START.theta]
    assert replay.predicted[-1] - replay.predicted[0] == pytest.approx(wanted, abs=1e-6)
    assert math.hypot(*wanted) > 0.02 and not replay.touch_agrees


def test_a_rod_that_passes_by_predicts_no_motion_and_says_so() -> None:
    model = model_of("rect1")
    time, travel = clock(0.05)
    tip = np.column_stack([0.2 + travel, 0.0 * travel])
    moved = np.outer(travel / 0.05, (0.01, 0.0, 0.02))
    replay = replay_push(record_of(time, moved, tip), model)
    assert not replay.touched and not replay.left
    assert replay.summary()["predicted_motion"] == replay.summary()["predicted_turn"] == 0.0
    assert (replay.error[-1], replay.turn_error[-1]) == pytest.approx((0.01, -0.02))
    assert not replay.touch_agrees


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "offset"), [(0.0, 0.03), (0.25, -0.02), (1.0, 0.004)])
def test_an_ellipse_cut_into_192_sides_moves_as_the_ellipse_does(friction, offset) -> None:
    """A chain of contacts with sides and corners, and the exact contact of the ellipse."""
    whole, rod = Ellipse(0.045, 0.060), Pusher(friction=friction)
    exact, cut = (
        QuasiStaticModel(Slider(outline), FRICTION, rod, PatchFootprint(whole), accuracy=1e-6)
        for outline in (whole, Polygon(whole.points(192)[:-1]))
    )
    corners = np.array([[-0.06, offset], [-0.03, offset], [-0.01, offset + 0.004]])
    wanted, found = (push_along(model, Pose(), corners) for model in (exact, cut))
    travel = np.linspace(0.0, wanted[0][-1], 41)
    off = along_way(travel, *found[:2]) - along_way(travel, *wanted[:2])
    assert np.hypot(*off[:, :2].T).max() < 0.06e-3 and np.abs(off[:, 2]).max() < math.radians(0.2)
    assert np.ptp(wanted[1][:, 0]) > 0.002 and found[2:] == wanted[2:]


def test_the_butterfly_is_symmetric_as_large_as_its_mesh_and_has_its_plates_inertia() -> None:
    """The number given, and the second moment of area by triangles about the centre."""
    butter = dataset_sliders()["butter"]
    outline, p = butter.outline, butter.outline.array
    points = {(round(x, 9), round(y, 9)) for x, y in outline.vertices}
    assert (
        points == {(round(-x, 9), y) for x, y in points} == {(x, round(-y, 9)) for x, y in points}
    )
    assert np.abs(p).max(axis=0) == pytest.approx([0.0477, 0.0786], abs=1e-4)
    assert outline.centroid == pytest.approx((0.0, 0.0), abs=1e-12)
    q = np.roll(p, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    moment = float((cross * ((p * p) + (p * q) + (q * q)).sum(1)).sum()) / 12.0
    assert butter.mass / outline.area == pytest.approx(0.8374 / 0.09**2)
    assert butter.inertia == pytest.approx(moment * butter.mass / outline.area, rel=1e-3)
