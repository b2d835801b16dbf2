"""Simulated friction scans hold the material's ellipse, in the layout of the dataset."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.evidence.recorded_push import SCAN_CENTRE, Recording, RecordingNoise, record_scan, scan_set
from cyclemap.evidence.simulated_collection import simulate_collection

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
FRICTION, WEIGHT = LOOP.material.friction, LOOP.model.weight


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """The scans of a collection of one push, as they are read back."""
    made = simulate_collection(LOOP, tmp_path_factory.mktemp("scans") / "made", 1, scans=True)
    assert made.scans == 144
    table = load_pushes(made.folder)
    assert not table.unreadable and len(table.table) == 1
    return table.scans


def fitted_ellipse(points):
    """Centre (2,) and shape matrix (2, 2) of the conic through points (n, 2), (p - c) S^-1 (p - c) = 1."""
    x, y = points.T
    conic = np.linalg.svd(np.column_stack([x * x, 2.0 * x * y, y * y, 2.0 * x, 2.0 * y, np.ones_like(x)]))[2][-1]
    matrix = conic[[0, 1, 1, 2]].reshape(2, 2)
    centre = -np.linalg.solve(matrix, conic[3:5])
    return centre, np.linalg.inv(matrix / (centre @ matrix @ centre - conic[5]))


def test_every_five_degrees_are_there_twice_with_their_facts(scans) -> None:
    assert len(scans) == 144
    degrees = np.degrees(scans["direction"]).round(9)
    assert sorted(set(degrees)) == list(range(0, 360, 5))
    assert scans.groupby(degrees.tolist())["repetition"].agg(list).map(lambda pair: pair == [0.0, 1.0]).all()
    assert set(scans["surface"]) == {"plywood"} and set(scans["object"]) == {"rect1"} and set(scans["speed"]) == {0.02}


def test_the_force_along_and_across_is_the_point_law_times_the_weight(scans) -> None:
    way = np.stack([np.cos(scans["direction"]), np.sin(scans["direction"])], axis=-1)
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1)
    traction = FRICTION.traction(way)
    along, across = np.sum(traction * way, axis=1), np.sum(traction * left, axis=1)
    # The tip's way is read off times that a double holds to 0.2 microseconds: a direction is good to 1e-7.
    assert scans["force_along"].to_numpy() == pytest.approx(WEIGHT * along, rel=1e-6)
    assert scans["ratio"].to_numpy() == pytest.approx(across / along, abs=1e-6)
    assert np.abs(scans["ratio"]).max() > 0.1


def test_the_forces_lie_on_the_materials_ellipse(scans) -> None:
    """A conic through the forces, which knows nothing of the law, has the law's centre, axes and angle."""
    c, s = np.cos(scans["direction"].to_numpy()), np.sin(scans["direction"].to_numpy())
    along, across = scans["force_along"].to_numpy() / WEIGHT, scans["force_across"].to_numpy() / WEIGHT
    centre, shape = fitted_ellipse(np.column_stack([c * along - s * across, s * along + c * across]))
    rotation = np.array(
        [[math.cos(FRICTION.phi), -math.sin(FRICTION.phi)], [math.sin(FRICTION.phi), math.cos(FRICTION.phi)]]
    )
    assert rotation.T @ centre == pytest.approx([FRICTION.m0, FRICTION.n0], abs=1e-7)
    assert rotation.T @ shape @ rotation == pytest.approx(np.diag([FRICTION.mu_a**2, FRICTION.mu_b**2]), abs=1e-7)


def test_the_stroke_goes_straight_through_the_scans_centre_and_rests_at_its_ends() -> None:
    scan = record_scan(FRICTION, WEIGHT, 1.0, Recording(), np.random.default_rng(0))
    assert scan.stroke == pytest.approx((0.12 * math.cos(1.0), 0.12 * math.sin(1.0)), abs=1e-12)
    assert (scan.tip[0, 1:3] + scan.tip[-1, 1:3]) / 2.0 == pytest.approx(SCAN_CENTRE, abs=1e-12)
    assert np.all(scan.tip[:60, 1:3] == scan.tip[0, 1:3]) and np.all(scan.ft_wrench[:55, 1:] == 0.0)
    speed = np.hypot(*np.diff(scan.tip[70:-70, 1:3], axis=0).T) / np.diff(scan.tip[70:-70, 0])
    assert speed == pytest.approx(0.02, rel=1e-9)


def test_force_noise_scatters_as_asked_and_the_torques_by_the_rods_radius() -> None:
    quiet = record_scan(FRICTION, WEIGHT, 1.0, Recording(), np.random.default_rng(0))
    noisy = replace(Recording(), noise=RecordingNoise(force=0.05))
    scan = record_scan(FRICTION, WEIGHT, 1.0, noisy, np.random.default_rng(0))
    error = scan.ft_wrench[:, 1:] - quiet.ft_wrench[:, 1:]
    assert len(error) > 1600
    # The standard error of a standard deviation from 1600 draws is 1.8 %.
    assert error.std(axis=0) == pytest.approx([0.05, 0.05, 0.05 * 0.00475], rel=0.07)
    assert np.abs(np.corrcoef(error.T) - np.eye(3)).max() < 0.1
    assert np.array_equal(scan.tip, quiet.tip)


def test_the_set_repeats_no_scan() -> None:
    scans = list(scan_set("plywood", "rect1", 0.02))
    assert len(set(scans)) == len(scans) == 144
