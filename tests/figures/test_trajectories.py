"""Paths of pushes are those of the mechanics, in both frames, simulated and read back; they spread
and cross as the captions say.
"""

import math
import shutil

import numpy as np
import pytest
from figure_cases import (
    DRAWN,
    LONG,
    NOWHERE,
    RECORDED,
    assert_drawn,
    exhibited,
    recorded_plywood,
    small,
    words_of,
)

from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.figures import NO_DATA, MeasuredFolder, load_exhibit
from cyclemap.figures.trajectories import (
    CROWDED,
    crossing_pairs,
    crowded_arcs,
    object_frame_caption,
    paths_from_measured_theta0,
    paths_on_four_surfaces,
    recorded_paths,
    robot_frame_caption,
)
from cyclemap.maps import WrappedNormal, sample_staircase

OBJECT, ROBOT = "trajectories-object-frame", "trajectories-robot-frame"
objects, robots = exhibited(OBJECT), exhibited(ROBOT)


def assert_ends(paths, loop: CollectionLoop, pushes) -> None:
    """Paths end in both frames where the cycles of the loop end their pushes."""
    for push in pushes:
        cycle = loop.cycle(float(paths.theta0[push]))
        assert paths.turn[push] == pytest.approx(cycle.push_turn, abs=1e-4)
        assert np.allclose(paths.object_frame[push, -1], cycle.push_displacement, atol=1e-5)
        end = cycle.push.end
        assert np.allclose(paths.robot_frame[push, -1], (end.x, end.y), atol=1e-5)


def test_a_path_ends_where_the_cycle_of_the_loop_ends_its_push(objects) -> None:
    for paths in objects[1::2]:
        assert_ends(paths, CollectionLoop.mit(paths.material), (0, DRAWN // 2, DRAWN - 1))


def test_wear_runs_from_the_fresh_surface_to_the_worn_one_within_the_run(objects) -> None:
    paths = objects[0]
    loop = CollectionLoop.mit("plywood-measured")
    fresh = loop.cycle(float(paths.theta0[0]))
    assert paths.turn[0] == pytest.approx(fresh.push_turn, abs=1e-4)
    last = float(paths.theta0[-1])
    worn = worn_loop(loop, LONG.pushes - 1).cycle(last).push_turn
    assert paths.turn[-1] == pytest.approx(worn, abs=1e-4)
    assert abs(worn - loop.cycle(last).push_turn) > math.radians(0.05)


def test_both_frames_tell_the_same_path_turned_by_theta0(objects) -> None:
    for paths in objects:
        c, s = np.cos(paths.theta0)[:, None], np.sin(paths.theta0)[:, None]
        x, y = np.moveaxis(paths.object_frame, -1, 0)
        turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)
        assert np.allclose(turned, paths.robot_frame - paths.robot_frame[:, :1], atol=1e-12)
        assert np.all(paths.object_frame[:, 0] == 0.0)


@pytest.mark.slow
def test_recorded_pushes_are_read_back_as_the_paths_that_were_recorded(tmp_path_factory) -> None:
    measured = recorded_plywood(tmp_path_factory)
    paths = recorded_paths(measured, "plywood", 5)
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
    assert len(paths.theta0) == len(paths.orientations) == RECORDED


def test_measured_orientations_are_pushed_on_the_floor_as_worn_as_it_then_was(
    measured_data,
) -> None:
    paths = paths_from_measured_theta0(MeasuredFolder(measured_data), "plywood", 5)
    assert paths.origin == "from measured θ0"
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
    crossed = int(np.triu(alternate, 1).sum())
    assert crossing_pairs(chords, np.ones((24, 24), dtype=bool)) == (crossed, 276)


def test_paths_that_start_at_one_point_do_not_cross_there() -> None:
    fan = np.array([[[0.0, 0.0], [np.cos(a), np.sin(a)]] for a in (0.1, 0.4, 0.9)])
    assert crossing_pairs(fan, np.ones((3, 3), dtype=bool)) == (0, 3)
    fan = np.array([[[0.0, 0.0], [np.cos(a), np.sin(a)]] for a in (0.1, 0.4, 0.9)])
    assert crossing_pairs(fan, np.ones((3, 3), dtype=bool)) == (0, 3)
    assert crossing_pairs(fan, np.zeros((3, 3), dtype=bool)) == (0, 0)


def test_paths_spread_on_every_surface_and_more_on_pu_than_on_abs_and_delrin(objects) -> None:
    spread = np.array([paths.spread for paths in objects])
    assert np.all(spread > 0.0)
    assert np.all(spread[3, [0, 2]] > spread[1:3][:, [0, 2]])
    assert np.all(spread[3, [0, 2]] > (math.radians(2.0), 0.008))


def test_the_spreads_of_the_caption_are_those_of_the_paths_beside_table_ii(objects) -> None:
    told = object_frame_caption(objects)
    printed = (4.7, 2.8, 8.6), (3.2, 1.6, 5.3), (1.3, 1.0, 3.2), (4.5, 2.9, 11.4)
    for paths, (a, b, c) in zip(objects, printed, strict=True):
        turn = np.degrees(np.std(paths.turn))
        dx, dy = 1000.0 * np.std(paths.object_frame[:, -1], axis=0)
        assert f"{paths.surface} {turn:.1f}° ({a}), {dx:.1f} mm ({b}), {dy:.1f} mm ({c})" in told


def test_on_table_i_a_run_stays_in_one_direction_as_the_caption_says(objects) -> None:
    """500 noisy cycles from 0 settle within 25 degrees of the stable direction; plywood-measured
    climbs.
    """
    table = CollectionLoop.mit("plywood", accuracy=1e-6).circle_map(1e-3)
    run = sample_staircase(table, WrappedNormal(math.radians(1.1)), 500, 0.0, seed=4).theta[100:]
    assert np.ptp(run) < math.radians(50.0)
    plywood = objects[0]
    assert plywood.orientations[-1] - plywood.orientations[0] > 2 * math.pi
    assert "with Table I a run stays in one direction" in object_frame_caption(objects)


def test_paths_seldom_cross_in_the_robots_frame_but_often_in_the_objects(robots) -> None:
    here, there, pairs = np.sum(robots.crossed, axis=0)
    assert pairs > 300 and here == 0 and there > 0.15 * pairs
    told = f"Of {pairs} pairs of paths from orientations 5° or more apart, 0 cross here and {there}"
    assert told in robot_frame_caption(robots)


def test_crowded_arcs_hold_their_directions_more_than_twice_as_densely_as_all_alike(robots) -> None:
    assert all(robots.arcs)
    for paths, arcs in zip(robots.surfaces, robots.arcs, strict=True):
        for begin, end in arcs:
            share = np.mean(np.mod(paths.orientations - begin, 2 * np.pi) < end - begin)
            assert share >= CROWDED * (end - begin) / (2 * np.pi)


def test_arcs_are_found_across_zero_and_nowhere_where_all_directions_are_alike() -> None:
    assert crowded_arcs(np.linspace(0.0, 2 * np.pi, 720, endpoint=False)) == []
    ((begin, end),) = crowded_arcs(np.deg2rad([355.0, 358.0, 2.0, 8.0]))
    assert np.degrees((begin, end)) == pytest.approx((350.0, 370.0))


@pytest.mark.slow
@pytest.mark.parametrize("origin", ["simulated", "recorded", "from measured θ0"])
@pytest.mark.parametrize("name", [OBJECT, ROBOT])
def test_captions_and_panels_tell_where_pushes_come_from(
    name, origin, tmp_path_factory, request
) -> None:
    measured, is_recorded, is_started = NOWHERE, origin == "recorded", origin == "from measured θ0"
    if is_recorded:
        measured = recorded_plywood(tmp_path_factory)
    elif is_started:
        measured = MeasuredFolder(request.getfixturevalue("measured_data"))
    module, found = load_exhibit(name), small(name, measured)
    told, figure = module.caption(found), module.draw(found)
    titles = {f"plywood, {origin}", "abs, simulated", "delrin, simulated", "pu, simulated"}
    assert titles <= set(words_of(figure).replace(",\n", ", ").split(" | "))
    absent = "abs, delrin and pu" if is_recorded else "plywood, abs, delrin and pu"
    assert f"Recorded pushes on {absent}: {NO_DATA}." in told
    assert ("Recorded pushes: plywood." in told) == ("with Table I" not in told) == is_recorded
    started = f"from {DRAWN} of the 2000 measured orientations of plywood"
    assert (started in told) == is_started
    assert_drawn(figure, 5)
