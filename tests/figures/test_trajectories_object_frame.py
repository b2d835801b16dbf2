"""In the object's frame the paths spread as far as the caption says, and the panels show them all."""

import math

import numpy as np
import pytest
from figure_cases import CYCLES, DRAWN, assert_drawn, assert_starts_where_the_robot_did, recorded_plywood, words_of

from cyclemap.collection import CollectionLoop
from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.trajectories_object_frame import FIGURE, compute, draw
from cyclemap.maps import WrappedNormal, sample_staircase


@pytest.fixture(scope="module")
def result():
    return compute(MeasuredFolder(None), CYCLES, DRAWN)


def test_paths_spread_on_every_surface_and_more_on_pu_than_on_abs_and_delrin(result) -> None:
    spread = np.array([result.spread(number) for number in range(4)])
    assert np.all(spread > 0.0)
    assert np.all(spread[3, [0, 2]] > spread[1:3][:, [0, 2]])
    assert spread[3, 2] > 0.008
    assert spread[3, 0] > math.radians(2.0)


def test_the_spreads_of_the_caption_are_those_of_the_paths_beside_table_ii(result) -> None:
    told = FIGURE.caption(result)
    for paths, published in zip(
        result.surfaces, ((4.7, 2.8, 8.6), (3.2, 1.6, 5.3), (1.3, 1.0, 3.2), (4.5, 2.9, 11.4)), strict=True
    ):
        turn = np.degrees(np.std(paths.turn))
        dx, dy = 1000.0 * np.std(paths.object_frame[:, -1], axis=0)
        a, b, c = published
        assert f"{paths.surface} {turn:.1f}° ({a}), {dx:.1f} mm ({b}), {dy:.1f} mm ({c})" in told


def test_on_table_i_a_run_stays_in_one_direction_as_the_caption_says(result) -> None:
    """500 noisy cycles from 0 settle within 25 degrees of the stable direction; plywood-measured climbs."""
    table = CollectionLoop.mit("plywood", accuracy=1e-6).circle_map(1e-3)
    run = sample_staircase(table, WrappedNormal(math.radians(1.1)), 500, 0.0, seed=4).theta[100:]
    assert np.ptp(run) < math.radians(50.0)
    plywood = result.surfaces[0]
    assert plywood.orientations[-1] - plywood.orientations[0] > 2 * math.pi
    assert "with Table I a run stays in one direction" in FIGURE.caption(result)


@pytest.mark.slow
def test_without_data_the_caption_and_the_panels_say_so(result) -> None:
    assert f"Recorded pushes on plywood, abs, delrin and pu: {NO_DATA}." in FIGURE.caption(result)
    figure = draw(result)
    assert words_of(figure).count(",\nsimulated") == 4
    assert_drawn(figure, 5)


@pytest.mark.slow
def test_recorded_pushes_take_the_place_of_simulated_ones(tmp_path_factory) -> None:
    found = compute(recorded_plywood(tmp_path_factory), CYCLES, DRAWN)
    told, figure = FIGURE.caption(found), draw(found)
    assert "Recorded pushes: plywood." in told
    assert f"Recorded pushes on abs, delrin and pu: {NO_DATA}." in told
    assert "with Table I" not in told
    assert "plywood,\nrecorded" in words_of(figure) and words_of(figure).count(",\nsimulated") == 3
    assert_drawn(figure, 5)


def test_on_plywood_the_pushes_start_where_the_robots_did(measured_data) -> None:
    assert_starts_where_the_robot_did(FIGURE, compute(MeasuredFolder(measured_data), CYCLES, DRAWN))
