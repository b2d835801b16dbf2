"""Rotation numbers: planes, staircases and tongues show the values at the parameters they belong to."""

import numpy as np
import pytest
from drawn_panels import legend_words, panel, png, written
from matplotlib.collections import QuadMesh

from cyclemap.maps import ARNOLD_FAMILY, MOEBIUS_FAMILY, CircleMap, rotation_numbers, rotation_plane, tongues
from cyclemap.views.rotation_panels import draw_rotation_numbers, draw_rotation_plane, draw_tongues

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def plane():
    return rotation_plane(ARNOLD_FAMILY, np.linspace(0.0, 0.5, 26), [0.2, 0.5, 0.8, 1.1], tolerance=0.02)


def test_a_plane_is_drawn_whichever_way_it_runs_and_a_cell_alone(plane) -> None:
    axes = panel()
    draw_rotation_plane(axes, plane, "Ω", "K")
    (mesh,) = [artist for artist in axes.collections if isinstance(artist, QuadMesh)]
    corners = mesh.get_coordinates()
    centres = 0.25 * (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:])
    assert np.array_equal(np.asarray(mesh.get_array()), plane.value.T)
    assert np.allclose(centres[..., 0], plane.first_values) and np.allclose(centres[..., 1].T, plane.second_values)
    png(axes)
    for first, second in (([0.5], [0.3]), ([0.6, 0.5], [0.3, 0.2, 0.1])):
        axes = panel()
        draw_rotation_plane(axes, rotation_plane(MOEBIUS_FAMILY, first, second))
        assert axes.get_xlim()[0] < axes.get_xlim()[1] and axes.get_ylim()[0] < axes.get_ylim()[1]
        png(axes)


def test_plateaus_are_the_locked_values_by_name() -> None:
    omega = np.linspace(0.0, 1.0, 201)
    numbers = rotation_numbers(ARNOLD_FAMILY, omega, 0.95)
    axes = panel()
    draw_rotation_numbers(axes, omega, numbers, "Ω (turns a cycle)")
    thick = [line for line in axes.lines if line.get_linewidth() == 3.0]
    assert len(thick) >= 5
    for line in thick:
        (low, high), (value, again) = line.get_data()
        inside = (omega >= low) & (omega <= high)
        assert value == again and np.all(numbers.value[inside] == value) and np.all(numbers.period[inside] > 0)
    assert {"0/1", "1/3", "1/2", "2/3", "1/1"} <= set(written(axes))
    png(axes)


def test_every_tongue_is_filled_and_named_and_folded_edges_are_dashed() -> None:
    axes = panel()
    draw_tongues(axes, tongues(CircleMap.arnold, [0, (1, 2), (1, 3)], [0.4, 0.8, 1.2], (-0.5, 1.0)))
    assert len(axes.collections) == 3
    assert sorted(written(axes)) == ["0/1", "1/2", "1/3"]
    assert legend_words(axes) == ["edge of a tongue", "edge where the map folds"]
    png(axes)
