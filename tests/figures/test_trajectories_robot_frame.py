"""In the robot's frame paths of different orientations do not cross, and crowded directions are marked."""

import numpy as np
import pytest
from figure_cases import CYCLES, DRAWN, assert_drawn, assert_starts_where_the_robot_did, recorded_plywood, words_of

from cyclemap.figures.measured_folder import MeasuredFolder
from cyclemap.figures.trajectories_robot_frame import CROWDED, FIGURE, compute, crowded_arcs, draw


@pytest.fixture(scope="module")
def result():
    return compute(MeasuredFolder(None), CYCLES, DRAWN)


def test_paths_seldom_cross_in_the_robots_frame_but_often_in_the_objects(result) -> None:
    here, there, pairs = np.sum(result.crossed, axis=0)
    assert pairs > 300
    assert here == 0
    assert there > 0.2 * pairs
    assert f"Of {pairs} pairs of paths from orientations 5° or more apart, {here} cross here" in FIGURE.caption(result)
    assert f"{there} in the object's frame" in FIGURE.caption(result)


def test_crowded_arcs_hold_their_directions_more_than_twice_as_densely_as_all_alike(result) -> None:
    assert all(result.arcs)
    for paths, arcs in zip(result.surfaces, result.arcs, strict=True):
        for begin, end in arcs:
            share = np.mean(np.mod(paths.orientations - begin, 2 * np.pi) < end - begin)
            assert share >= CROWDED * (end - begin) / (2 * np.pi)


def test_arcs_are_found_across_zero_and_nowhere_where_all_directions_are_alike() -> None:
    assert crowded_arcs(np.linspace(0.0, 2 * np.pi, 720, endpoint=False)) == []
    ((begin, end),) = crowded_arcs(np.deg2rad([355.0, 358.0, 2.0, 8.0]))
    assert np.degrees((begin, end)) == pytest.approx((350.0, 370.0))


@pytest.mark.slow
def test_the_picture_has_four_full_panels_with_and_without_recorded_pushes(result, tmp_path_factory) -> None:
    assert_drawn(draw(result), 5)
    found = compute(recorded_plywood(tmp_path_factory), CYCLES, DRAWN)
    figure = draw(found)
    assert "plywood, recorded" in words_of(figure)
    assert "Recorded pushes: plywood." in FIGURE.caption(found)
    assert_drawn(figure, 5)


@pytest.mark.slow
def test_on_plywood_the_pushes_start_where_the_robots_did(measured_data) -> None:
    assert_starts_where_the_robot_did(FIGURE, compute(MeasuredFolder(measured_data), CYCLES, DRAWN))
