"""Rotation numbers: planes, staircases and tongues show the values at the parameters they belong to."""

import numpy as np
import pytest
from drawn_panels import labelled, legend_words, panel, png, written
from matplotlib.collections import QuadMesh

from cyclemap.maps import ARNOLD_FAMILY, MOEBIUS_FAMILY, CircleMap, rotation_numbers, rotation_plane, tongues
from cyclemap.views.rotation_panels import draw_rotation_numbers, draw_rotation_plane, draw_tongues

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def plane():
    return rotation_plane(ARNOLD_FAMILY, np.linspace(0.0, 0.5, 26), [0.2, 0.5, 0.8, 1.1], tolerance=0.02)


def one(axes, kind):
    (found,) = [artist for artist in axes.collections if isinstance(artist, kind)]
    return found


def test_plane_shows_every_value_in_its_own_cell(plane) -> None:
    axes = panel()
    draw_rotation_plane(axes, plane, "Ω", "K")
    mesh = one(axes, QuadMesh)
    assert np.array_equal(np.asarray(mesh.get_array()), plane.value.T)
    corners = mesh.get_coordinates()
    centres = 0.25 * (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:])
    assert np.allclose(centres[..., 0], plane.first_values) and np.allclose(centres[..., 1].T, plane.second_values)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Ω", "K")
    (bar,) = [other for other in axes.get_figure().axes if other is not axes]
    assert bar.get_ylabel() == "rotation number (turns a cycle)"
    png(axes)


def test_plane_of_one_cell_and_one_running_down_are_drawn() -> None:
    axes = panel()
    draw_rotation_plane(axes, rotation_plane(MOEBIUS_FAMILY, [0.5], [0.3]))
    png(axes)
    axes = panel()
    draw_rotation_plane(axes, rotation_plane(MOEBIUS_FAMILY, [0.6, 0.5], [0.3, 0.2, 0.1]))
    assert axes.get_xlim()[0] < axes.get_xlim()[1] and axes.get_ylim()[0] < axes.get_ylim()[1]
    assert axes.get_legend() is None
    png(axes)


def test_staircase_band_holds_its_curve_and_plateaus_are_the_locked_values() -> None:
    omega = np.linspace(0.0, 1.0, 201)
    numbers = rotation_numbers(ARNOLD_FAMILY, omega, 0.95)
    axes = panel()
    draw_rotation_numbers(axes, omega, numbers, "Ω (turns a cycle)")
    curve = labelled(axes, "middle")
    assert np.array_equal(curve.get_ydata(), numbers.value)
    thick = [line for line in axes.lines if line.get_linewidth() == 3.0]
    assert len(thick) >= 5
    for line in thick:
        (low, high), (value, again) = line.get_data()
        inside = (omega >= low) & (omega <= high)
        assert value == again and np.all(numbers.value[inside] == value) and np.all(numbers.period[inside] > 0)
    assert {"0/1", "1/3", "1/2", "2/3", "1/1"} <= set(written(axes))
    png(axes)


@pytest.fixture(scope="module")
def boundaries():
    return tongues(CircleMap.arnold, [0, (1, 2), (1, 3)], [0.4, 0.8, 1.2], (-0.5, 1.0))


def test_every_tongue_is_filled_and_named_and_folded_edges_are_dashed(boundaries) -> None:
    axes = panel()
    draw_tongues(axes, boundaries)
    assert len(axes.collections) == 3
    assert sorted(written(axes)) == ["0/1", "1/2", "1/3"]
    for index, fill in enumerate(axes.collections):
        ends = fill.get_paths()[0].vertices[:, 0]
        assert (ends.min(), ends.max()) == (boundaries.left[index].min(), boundaries.right[index].max())
    dashed = [line for line in axes.lines if line.get_linestyle() == "--"]
    solid = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert len(dashed) == len(solid) == 6
    assert all(line.get_ydata()[-1] == 1.2 for line in dashed) and all(max(line.get_ydata()) < 1.0 for line in solid)
    assert legend_words(axes) == ["edge of a tongue", "edge where the map folds"]
