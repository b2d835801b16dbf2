"""In the object's frame paths spread as the caption says; in the robot's frame those of different
θ0 do not cross.
"""

import math

import numpy as np
import pytest
from figure_cases import DRAWN, NOWHERE, assert_drawn, recorded_plywood, small, words_of

from cyclemap.collection import CollectionLoop
from cyclemap.figures.catalogue import NO_DATA, MeasuredFolder, load_exhibit
from cyclemap.figures.materials.trajectories import (
    CROWDED,
    crowded_arcs,
    object_frame_caption,
    robot_frame_caption,
)
from cyclemap.maps import WrappedNormal, sample_staircase

OBJECT, ROBOT = "trajectories-object-frame", "trajectories-robot-frame"


@pytest.fixture(scope="module")
def objects():
    return small(OBJECT)


@pytest.fixture(scope="module")
def robots():
    return small(ROBOT)


def test_paths_spread_on_every_surface_and_more_on_pu_than_on_abs_and_delrin(objects) -> None:
    spread = np.array([paths.spread for paths in objects])
    assert np.all(spread > 0.0)
    assert np.all(spread[3, [0, 2]] > spread[1:3][:, [0, 2]])
    assert spread[3, 2] > 0.008
    assert spread[3, 0] > math.radians(2.0)


def test_the_spreads_of_the_caption_are_those_of_the_paths_beside_table_ii(objects) -> None:
    told = object_frame_caption(objects)
    printed = (4.7, 2.8, 8.6), (3.2, 1.6, 5.3), (1.3, 1.0, 3.2), (4.5, 2.9, 11.4)
    for paths, (a, b, c) in zip(objects, printed, strict=True):
        turn, (dx, dy) = (
            np.degrees(np.std(paths.turn)),
            1000.0 * np.std(paths.object_frame[:, -1], axis=0),
        )
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
    assert pairs > 300
    assert here == 0
    assert there > 0.15 * pairs
    told = robot_frame_caption(robots)
    assert (
        f"Of {pairs} pairs of paths from orientations 5° or more apart, {here} cross here" in told
    )
    assert f"{there} in the object's frame" in told


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
    if origin == "recorded":
        measured = recorded_plywood(tmp_path_factory)
    else:
        measured = (
            NOWHERE
            if origin == "simulated"
            else MeasuredFolder(request.getfixturevalue("measured_data"))
        )
    module, found = load_exhibit(name), small(name, measured)
    told, figure = module.caption(found), module.draw(found)
    titles = {f"plywood, {origin}", "abs, simulated", "delrin, simulated", "pu, simulated"}
    assert titles <= set(words_of(figure).replace(",\n", ", ").split(" | "))
    absent = "abs, delrin and pu" if origin == "recorded" else "plywood, abs, delrin and pu"
    assert f"Recorded pushes on {absent}: {NO_DATA}." in told
    assert (
        ("Recorded pushes: plywood." in told)
        == ("with Table I" not in told)
        == (origin == "recorded")
    )
    assert (f"from {DRAWN} of the 2000 measured orientations of plywood" in told) == (
        origin == "from measured θ0"
    )
    assert_drawn(figure, 5)
    if origin == "from measured θ0":
        plywood = (found if name == OBJECT else found.surfaces)[0]
        assert plywood.orientations.shape == (2000,) and plywood.theta0.shape == (DRAWN,)
        assert np.degrees(plywood.theta0[[0, -1]]) == pytest.approx(
            np.degrees(plywood.orientations[[0, -1]])
        )
