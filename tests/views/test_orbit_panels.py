"""Graphs, basins and slow passages: the artists lie where the results say."""

import numpy as np
import pytest
from drawn_panels import faces, labelled, legend_words, panel, png, written

from cyclemap.maps import CircleMap, basins, fixed_points, periodic_orbits, slow_passages
from cyclemap.views.orbit_panels import draw_basins, draw_map, draw_slow_passage
from cyclemap.views.style import PREDICTED, UNSTABLE

WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x), lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x)
)


def test_map_marks_stable_orbits_filled_and_unstable_ones_open() -> None:
    circle_map = CircleMap.arnold(0.5, 0.9)
    orbits = periodic_orbits(circle_map, 2)
    axes = panel()
    draw_map(axes, circle_map, orbits)
    assert sorted(faces(axes)) == sorted([(PREDICTED, "full", 2), (UNSTABLE, "full", 2)])
    assert [orbit.stable for orbit in orbits].count(True) == 1
    assert legend_words(axes) == ["stable", "unstable"]
    png(axes)


def test_orbit_points_lie_on_the_graph() -> None:
    circle_map = CircleMap.moebius(0.5, 0.1)
    orbits = fixed_points(circle_map)
    axes = panel()
    draw_map(axes, circle_map, orbits)
    places = [(float(x), float(y)) for line in axes.lines if line.get_marker() == "o" for x, y in line.get_xydata()]
    assert len(places) == len(orbits) == 2
    for theta_deg, next_deg in places:
        turned = np.degrees(circle_map(np.radians(theta_deg))) - next_deg
        assert np.mod(turned + 180.0, 360.0) - 180.0 == pytest.approx(0.0, abs=1e-9)


def test_saddle_node_is_half_filled() -> None:
    circle_map = CircleMap.arnold(0.9 / (2 * np.pi), 0.9)
    axes = panel()
    draw_map(axes, circle_map, fixed_points(circle_map))
    assert faces(axes) == [(PREDICTED, "left", 1)]
    assert legend_words(axes) == ["half-stable"]
    png(axes)


def test_map_without_orbits_and_of_degree_two_is_drawn_with_units_and_no_legend() -> None:
    axes = panel()
    draw_map(axes, CircleMap.blaschke([0.3, 0.2j], 0.1))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("θ (°)", "next θ (°)")
    assert axes.get_legend() is None and faces(axes) == []
    png(axes)


def test_jump_of_the_map_is_not_joined_by_a_line() -> None:
    axes = panel()
    broken = CircleMap(lambda x: x - 1.0 + 0.35 * np.mod(x - 2.0, 2 * np.pi), breaks=(2.0,))
    draw_map(axes, broken, fixed_points(broken))
    graph = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert len(graph) == 3
    for line in graph:
        assert np.abs(np.diff(line.get_ydata())).max() < 1.0


# -- basins ------------------------------------------------------------------------------------------------


def bars(collection) -> list[tuple[float, float]]:
    """(low, high) of every bar, in the order drawn."""
    return [(float(path.vertices[:, 0].min()), float(path.vertices[:, 0].max())) for path in collection.get_paths()]


@pytest.mark.slow
@pytest.mark.parametrize("circle_map", [CircleMap.arnold(0.1, 0.9), WELLS, CircleMap.arnold(0.3, 2.5)])
def test_bands_cover_the_basins_share_of_the_circle(circle_map) -> None:
    found = basins(circle_map, max_period=2, left_over=1e-3)
    axes = panel()
    draw_basins(axes, found)
    assert len(axes.collections) == 2 * len(found) > 0
    for basin, whole, near in zip(found, axes.collections[::2], axes.collections[1::2], strict=True):
        ends = bars(whole)
        assert min(low for low, _ in ends) >= 0.0 and max(high for _, high in ends) <= 360.0
        assert sum(high - low for low, high in ends) == pytest.approx(360.0 * basin.measure, abs=1e-6)
        length = sum(high - low for low, high in bars(near))
        assert length == pytest.approx(np.degrees(np.ptp(basin.immediate, axis=1).sum()), abs=1e-9)
        assert near.get_hatch() and not whole.get_hatch()
    assert faces(axes) == [(PREDICTED, "full", basin.orbit.period) for basin in found]
    png(axes)


def test_undecided_share_and_each_basins_share_are_told() -> None:
    axes = panel()
    draw_basins(axes, basins(WELLS))
    assert legend_words(axes)[-1] == "undecided: nothing"
    assert written(axes) == ["period 1, winding 0: 46 % of the circle", "period 1, winding 0: 54 % of the circle"]
    (rough,) = basins(CircleMap.arnold(0.3, 2.5), max_period=1, left_over=0.1)
    axes = panel()
    draw_basins(axes, [rough])
    assert 0.001 < rough.undecided < 0.1
    assert legend_words(axes)[-1] == f"undecided: {100 * rough.undecided:.2g} %"


def test_map_without_stable_orbits_says_so() -> None:
    axes = panel()
    draw_basins(axes, basins(CircleMap.moebius(0.5, 0.3), max_period=2))
    assert written(axes) == ["no stable orbit"]
    png(axes)


# -- slow passages -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("omega", [0.15, -0.15])
def test_passage_shows_the_gap_the_width_and_the_cycles(omega) -> None:
    circle_map = CircleMap.arnold(omega, 0.9)
    (passage,) = slow_passages(circle_map)
    axes = panel()
    draw_slow_passage(axes, circle_map, passage)
    (bracket,) = [line for line in axes.lines if line.get_marker() == "|"]
    width_deg, gap_deg = np.degrees(passage.width), np.degrees(passage.gap)
    assert np.ptp(bracket.get_xdata()) == pytest.approx(2 * width_deg)
    # On the parabola the move is doubled at the ends of that stretch.
    parabola = labelled(axes, "parabola: 23 cycles to pass")
    x_deg, y_deg = parabola.get_data()
    assert np.interp(bracket.get_xdata(), x_deg, y_deg) == pytest.approx([2 * gap_deg] * 2, rel=1e-3)
    assert f"ε = {gap_deg:.2f}°".replace("-", "−") in written(axes)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("θ (°)", "move of one cycle (°)")
    low, high = axes.get_ylim()
    assert low < 0.0 < high
    png(axes)


def test_passage_of_longer_period_names_its_cycles_and_turns() -> None:
    circle_map = CircleMap.arnold(0.46, 0.9)
    axes = panel()
    draw_slow_passage(axes, circle_map, slow_passages(circle_map, 2)[0])
    assert axes.get_ylabel() == "move of 2 cycles less 360° (°)"
    png(axes)
