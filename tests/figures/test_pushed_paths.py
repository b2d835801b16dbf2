"""Paths of pushes are those of the mechanics, in both frames, simulated and read back from recorded
files.
"""

import math
import shutil

import numpy as np
import pytest
from figure_cases import DRAWN, LONG, RECORDED, recorded_plywood, small

from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.figures.materials.trajectories import (
    crossing_pairs,
    paths_from_measured_theta0,
    paths_on_four_surfaces,
    recorded_paths,
)


def assert_ends(paths, loop: CollectionLoop, pushes) -> None:
    """Paths end in both frames where the cycles of the loop end their pushes."""
    for push in pushes:
        cycle = loop.cycle(float(paths.theta0[push]))
        assert paths.turn[push] == pytest.approx(cycle.push_turn, abs=1e-4)
        assert np.allclose(paths.object_frame[push, -1], cycle.push_displacement, atol=1e-5)
        assert np.allclose(
            paths.robot_frame[push, -1], (cycle.push.end.x, cycle.push.end.y), atol=1e-5
        )


@pytest.mark.parametrize("number", [1, 3])
def test_a_path_ends_where_the_cycle_of_the_loop_ends_its_push(number: int) -> None:
    paths = small("trajectories-object-frame")[number]
    assert_ends(paths, CollectionLoop.mit(paths.material), (0, DRAWN // 2, DRAWN - 1))


def test_wear_runs_from_the_fresh_surface_to_the_worn_one_within_the_run() -> None:
    paths = small("trajectories-object-frame")[0]
    loop = CollectionLoop.mit("plywood-measured")
    fresh = loop.cycle(float(paths.theta0[0]))
    assert paths.turn[0] == pytest.approx(fresh.push_turn, abs=1e-4)
    last = float(paths.theta0[-1])
    worn = worn_loop(loop, LONG.pushes - 1).cycle(last).push_turn
    assert paths.turn[-1] == pytest.approx(worn, abs=1e-4)
    assert abs(worn - loop.cycle(last).push_turn) > math.radians(0.05)


def test_both_frames_tell_the_same_path_turned_by_theta0() -> None:
    for paths in small("trajectories-object-frame"):
        c, s = np.cos(paths.theta0)[:, None], np.sin(paths.theta0)[:, None]
        x, y = np.moveaxis(paths.object_frame, -1, 0)
        turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)
        assert np.allclose(turned, paths.robot_frame - paths.robot_frame[:, :1], atol=1e-12)
        assert np.all(paths.object_frame[:, 0] == 0.0)


@pytest.mark.slow
def test_recorded_pushes_are_read_back_as_the_paths_that_were_recorded(tmp_path_factory) -> None:
    measured = recorded_plywood(tmp_path_factory)
    paths = recorded_paths(measured, "plywood", 5)
    assert paths is not None
    assert paths.theta0.shape == (5,) and paths.orientations.shape == (RECORDED,)
    assert_ends(paths, CollectionLoop.mit("plywood"), range(5))
    surfaces = paths_on_four_surfaces(measured, LONG, DRAWN)
    assert [one.origin for one in surfaces] == ["recorded", "simulated", "simulated", "simulated"]


@pytest.mark.slow
def test_pushes_of_another_kind_in_the_folder_are_left_out(tmp_path, tmp_path_factory) -> None:
    shutil.copytree(recorded_plywood(tmp_path_factory).path, tmp_path / "mixed")
    home = tmp_path / "mixed" / "plywood" / "rect1" / "normal"
    first = sorted(home.iterdir())[0]
    for old, new in (("=plywood", "=abs"), ("s=0.700", "s=0.200")):
        assert old in first.name
        shutil.copy(first, home / first.name.replace(old, new))
    paths = recorded_paths(MeasuredFolder(tmp_path / "mixed"), "plywood")
    assert paths is not None and len(paths.theta0) == len(paths.orientations) == RECORDED


def test_measured_orientations_are_pushed_on_the_floor_as_worn_as_it_then_was(
    measured_data,
) -> None:
    paths = paths_from_measured_theta0(MeasuredFolder(measured_data), "plywood", 5)
    assert paths is not None and paths.origin == "from measured θ0"
    loop = CollectionLoop.mit("plywood-measured")
    for push, cycle in enumerate((0, 500, 1000, 1499, 1999)):
        run = worn_loop(loop, cycle).cycle(float(paths.orientations[cycle]))
        assert paths.theta0[push] == paths.orientations[cycle]
        assert paths.turn[push] == pytest.approx(run.push_turn, abs=1e-4)
    assert paths_from_measured_theta0(MeasuredFolder(measured_data), "abs") is None


def test_chords_of_a_circle_cross_exactly_when_their_ends_alternate() -> None:
    angle = np.random.default_rng(3).uniform(0.0, 2 * np.pi, (24, 2))
    chords = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    low, high = np.sort(angle, axis=1).T
    between = (angle[None] > low[:, None, None]) & (angle[None] < high[:, None, None])
    alternate = between[..., 0] != between[..., 1]
    assert crossing_pairs(chords, np.ones((24, 24), dtype=bool)) == (
        int(np.triu(alternate, 1).sum()),
        276,
    )


def test_paths_that_start_at_one_point_do_not_cross_there() -> None:
    fan = np.array([[[0.0, 0.0], [np.cos(a), np.sin(a)]] for a in (0.1, 0.4, 0.9)])
    assert crossing_pairs(fan, np.ones((3, 3), dtype=bool)) == (0, 3)
    assert crossing_pairs(fan, np.zeros((3, 3), dtype=bool)) == (0, 0)
