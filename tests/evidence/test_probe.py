"""A planted anisotropy is found, in intervals that hold it; none is found where there is none."""

import math
import sys
from dataclasses import astuple, replace

import numpy as np
import pytest
from refusals import refused
from scipy import stats

from cyclemap.collection import Anisotropy, CollectionLoop
from cyclemap.evidence import Probe, command_push, probe, probe_pushes, simulated_push
from cyclemap.evidence.laws.linear_fit import fourier_columns
from cyclemap.evidence.push_design import Design, Target
from cyclemap.maps import fixed_points
from cyclemap.mechanics import EllipseFriction, Material, Pose
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.views.panels.layout import render
from cyclemap.views.push_pages import probe_page, probe_sentences

ISOTROPIC = CollectionLoop.mit("isotropic", accuracy=1e-5)
THETA = 2.0 * np.pi * np.arange(72) / 72
NOISE = np.array([3e-4, 3e-4, math.radians(0.3)])


def on_ellipse(friction: EllipseFriction) -> CollectionLoop:
    return replace(ISOTROPIC, material=Material("planted", friction))


def motions(loop: CollectionLoop, theta: np.ndarray) -> np.ndarray:
    made = loop.cycles(theta)
    return np.column_stack([made.push_displacement, made.push_turn])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_three_per_cent_are_found_and_held_and_nothing_else_is(seed) -> None:
    """A hundred runs each gave 100 found, 100 intervals that hold, and 0 false ones."""
    random, root = np.random.default_rng(seed), math.sqrt(1.03)
    phi = float(random.uniform(0.0, math.pi))
    change = motions(on_ellipse(EllipseFriction(0.25 * root, 0.25 / root, phi=phi)), THETA)
    planted = probe_pushes(THETA, change + NOISE * random.normal(size=(72, 3)), ISOTROPIC)
    assert planted.found and planted.ratio.lower <= 1.03 <= planted.ratio.upper < 1.04
    assert math.cos(2.0 * (planted.anisotropy.ellipse_direction - phi)) > 0.9
    assert planted.offset.lower < 0.002
    alike = motions(ISOTROPIC, THETA) + NOISE * random.normal(size=(72, 3))
    none = probe_pushes(THETA, alike, ISOTROPIC)
    assert not none.found and none.ratio.lower == 1.0 and none.ratio.upper < 1.01
    assert "No sign" in probe_sentences(none)[0]


AROUND = THETA[::6]


def test_evenly_spread_pushes_are_those_that_the_criterion_of_a_plan_chooses() -> None:
    """Of two harmonics, nothing believed before: no exchange tells more, and other sets come near."""
    columns = fourier_columns(THETA, 2)[np.newaxis, :, np.newaxis]
    wanted = Target(np.eye(5)[None], lambda variance: variance.sum(axis=(-2, -1)), lambda _: {})
    design = Design(1e4 * np.eye(5), columns, wanted)
    even = list(range(0, 72, 6))
    assert design.exchanged(even) == even
    random = np.random.default_rng(0).permutation(72)[:12].tolist()
    found = design.exchanged(random)
    assert design.loss(even) < design.loss(found) < 1.1 * design.loss(even) < design.loss(random)


def pushed(values: np.ndarray) -> np.ndarray:
    """A dozen pushes on the ellipse with these components, as `Anisotropy` has them."""
    planted = on_ellipse(Anisotropy.of_components(values).friction(0.25))
    return motions(replace(planted, accuracy=1e-7), AROUND)


def test_intervals_of_a_dozen_pushes_are_those_of_linear_regression() -> None:
    """A second route: derivatives by differences about the ellipse that was planted. The weight of
    dy, which tells nearly all, is known by the 7 degrees of freedom that two harmonics leave.
    """
    planted, random = np.array([0.02, -0.01, 0.03, 0.01]), np.random.default_rng(3)
    found = probe_pushes(AROUND, pushed(planted) + NOISE * random.normal(size=(12, 3)), ISOTROPIC)

    def away(change: np.ndarray) -> np.ndarray:
        return np.asarray(((change - change.mean(axis=0)) / found.noise).ravel())

    steps = 1e-4 * np.eye(4)
    by = np.stack([away(pushed(planted + s) - pushed(planted - s)) / 2e-4 for s in steps], axis=1)
    moved, square, *_ = np.linalg.lstsq(by, away(found.change - pushed(planted)))
    covariance = square[0] / (36 - 7) * np.linalg.inv(by.T @ by)
    reach = math.sqrt(2.0 * stats.f.ppf(0.95, 2, 12 - 5))
    angles = np.linspace(0.0, 2.0 * np.pi, 2001)
    circle = reach * np.stack([np.cos(angles), np.sin(angles)])
    offset, ratio = (astuple(interval) for interval in (found.offset, found.ratio))
    intervals = offset, np.log(ratio) / 2.0
    for part, interval in zip((slice(0, 2), slice(2, 4)), intervals, strict=True):
        root = np.linalg.cholesky(covariance[part, part])
        lengths = np.hypot(*((planted + moved)[part, None] + root @ circle))
        expected = (np.hypot(*(planted + moved)[part]), lengths.min(), lengths.max())
        assert interval == pytest.approx(expected, abs=0.01 * np.ptp(lengths))


@pytest.mark.slow
def test_nineteen_of_twenty_probes_of_equal_friction_find_it_possible() -> None:
    alike, random, held = pushed(np.zeros(4)), np.random.default_rng(5), np.zeros(2)
    for _ in range(100):
        found = probe_pushes(AROUND, alike + NOISE * random.normal(size=(12, 3)), ISOTROPIC)
        held += (found.ratio.lower == 1.0, found.offset.lower == 0.0)
    assert np.all(np.abs(held / 100 - 0.95) < 0.03)


def test_the_p_value_is_the_share_of_aimless_pushes_that_show_as_much() -> None:
    """Of 20,000 dozens of normal changes, by Wilks' determinants of what two harmonics leave."""
    random = np.random.default_rng(5)
    columns = [f(k * AROUND) for k in (0, 1, 2) for f in (np.cos, np.sin)]
    design, _ = np.linalg.qr(np.stack([*columns[:1], *columns[2:]], axis=1))

    def shown(change: np.ndarray) -> np.ndarray:
        centred = change - change.mean(axis=-2, keepdims=True)
        left = change - design @ (design.T @ change)
        first, second = (np.swapaxes(part, -1, -2) @ part for part in (centred, left))
        return np.asarray(np.linalg.det(first) / np.linalg.det(second))

    aimless = shown(random.normal(size=(20_000, 12, 3)))
    for _ in range(3):
        change = pushed(np.zeros(4)) + NOISE * random.normal(size=(12, 3))
        share = np.mean(aimless >= shown(change / NOISE))
        assert 0.02 < share < 0.98
        assert probe_pushes(AROUND, change, ISOTROPIC).p_value == pytest.approx(share, abs=0.015)


@pytest.mark.slow
def test_the_ellipse_and_its_lock_in_are_those_of_the_surface_that_was_pushed_on() -> None:
    plywood = CollectionLoop.mit("plywood", accuracy=1e-6)

    def push(theta: float) -> tuple[float, ...]:
        cycle = plywood.cycle(theta)
        return (*cycle.push_displacement.tolist(), cycle.push_turn)

    found = probe(push, ISOTROPIC, 36)
    assert found.found and found.explained > 0.999
    assert found.ratio.value == pytest.approx(0.2545 / 0.2346, abs=1e-4)
    offset = math.hypot(0.0325, 0.0082) / math.sqrt(0.2545 * 0.2346)
    assert found.offset.value == pytest.approx(offset, abs=1e-4)
    (place,) = found.stable
    assert math.degrees(place.value) == pytest.approx(63.2, abs=0.3)
    assert math.degrees(place.upper - place.lower) < 0.3
    said = probe_sentences(found)[2]
    assert "orientation 63." in said and "pushed towards −26." in said
    assert render(probe_page(found)).startswith(b"\x89PNG")


def noisy_probe(scale: float, size: float, seed: int) -> tuple[list[float], Probe]:
    """Where a planted ellipse locks in (rad), and a probe by 36 pushes, as noisy as told (m)."""
    planted = scale * np.array([0.12, 0.07, -0.01, -0.03])
    truth = on_ellipse(Anisotropy.of_components(planted).friction(0.25))
    noise = size * np.array([1.0, 1.0, 14.0]) * np.random.default_rng(seed).normal(size=(36, 3))
    stable = [orbit.points[0] for orbit in fixed_points(truth.circle_map(1e-4)) if orbit.stable]
    found = probe_pushes(THETA[::2], motions(truth, THETA[::2]) + noise, ISOTROPIC)
    return stable, found


@pytest.mark.parametrize("seed", range(2))
def test_where_noisy_pushes_would_lock_in_is_told_with_an_interval_that_holds_it(seed) -> None:
    """The interval held the planted place in 45 of 48 such runs."""
    (stable,), found = noisy_probe(1.0, 5e-3, seed)
    (place,) = found.stable
    assert place.lower < stable < place.upper
    assert math.radians(6.0) < place.upper - place.lower < math.radians(25.0)
    assert "°, within ±" in probe_sentences(found)[-1]


def test_noisy_pushes_near_a_lock_in_are_said_to_leave_it_open() -> None:
    """The slowest cycle of the ellipse that was found turns by less than noise lets it be known."""
    stable, found = noisy_probe(0.33, 3e-3, 0)
    assert not stable and not found.stable
    assert found.slowest.lower < 0.0 < found.slowest.upper
    assert "cannot be told" in probe_sentences(found)[-1]


def test_a_simulator_is_told_the_rods_way_and_its_poses_are_seen_from_the_object() -> None:
    """The mechanics as a simulator, its poses wrapped."""
    plywood = CollectionLoop.mit("plywood", accuracy=1e-6)
    (x, y), way = first_contact(plywood.slider, plywood.push, plywood.pusher.radius)

    def end_pose(theta, start, end) -> tuple[float, float, float]:
        begun = Pose(theta=theta)
        assert start == pytest.approx(begun.to_world(x, y))
        assert np.subtract(end, start) == pytest.approx(np.multiply(0.15, begun.to_world(*way)))
        cycle = plywood.cycle(theta)
        turned = (theta + cycle.push_turn) % (2.0 * math.pi)
        return (*begun.to_world(*cycle.push_displacement), turned)

    push = simulated_push(plywood, end_pose)
    for theta in (0.0, 3.0, 6.0):
        cycle = plywood.cycle(theta)
        assert push(theta) == pytest.approx((*cycle.push_displacement, cycle.push_turn), abs=1e-12)
    assert probe(push, ISOTROPIC, 24).ratio.value == pytest.approx(0.2545 / 0.2346, abs=1e-4)


def test_what_no_ellipse_can_mimic_is_found_and_said_to_be_unexplained() -> None:
    """A fourth harmonic, as a pyramidal friction cone makes it."""
    change = np.array([0.04, -0.07, 1.3]) + NOISE * np.random.default_rng(0).normal(size=(72, 3))
    change[:, 2] += 0.05 * np.cos(4.0 * THETA)
    found = probe_pushes(THETA, change, ISOTROPIC)
    assert found.found and found.explained < 0.1
    turn = {one.order: one for one in found.harmonics if one.outcome == "dtheta"}
    assert turn[4].lower <= 0.05 <= turn[4].upper and turn[1].lower < 1e-3


def test_a_program_is_asked_line_by_line(tmp_path) -> None:
    program = tmp_path / "sim.py"
    program.write_text(
        "import json, sys\nfor line in sys.stdin:\n    theta = json.loads(line)['theta_deg']\n"
        "    print(json.dumps({'dx_mm': theta, 'dy_mm': -70, 'dtheta_deg': 74.5}), flush=True)\n"
    )
    push = command_push([sys.executable, str(program)])
    assert push(math.radians(30.0)) == pytest.approx((0.030, -0.070, math.radians(74.5)))
    assert push(math.radians(60.0))[0] == pytest.approx(0.060)
    program.write_text("print('hello', flush=True)\ninput()\n")
    push = command_push([sys.executable, str(program)])
    refused(push, 0.0, told=r"answered 'hello': for each line")


def test_pushes_that_cannot_tell_are_refused() -> None:
    arc = np.linspace(0.0, 3.0, 20)
    refused(probe_pushes, arc, np.zeros((20, 3)), ISOTROPIC, told="gap of more than a quarter turn")
    refused(probe_pushes, THETA[:5], np.zeros((5, 3)), ISOTROPIC, told="give 12 or more")
    refused(probe, lambda theta: (0.0, 1.0), ISOTROPIC, 12, told=r"give \(dx, dy, dtheta\)")
