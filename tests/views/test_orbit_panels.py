"""A map's graph with its orbits, basins, slow passages, and orbits over a parameter, drawn."""

import numpy as np
import pytest
from drawn_panels import faces, labelled, legend_words, panel, png, written

from cyclemap.maps import (
    CircleMap,
    basins,
    bifurcations,
    fixed_points,
    follow_orbit,
    lyapunov_exponents,
    orbit_branches,
    orbit_diagram,
    periodic_orbits,
    slow_passages,
)
from cyclemap.views.orbit_panels import (
    MARKERS,
    branch_curves,
    cut_at_turns,
    draw_basins,
    draw_lyapunov_exponents,
    draw_map,
    draw_orbit_branches,
    draw_orbit_diagram,
    draw_slow_passage,
    map_graph,
    passage_curve,
)
from cyclemap.views.style import PREDICTED, UNSTABLE

WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x), lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x)
)
SAWTOOTH = CircleMap(
    lambda theta: theta - 1.0 + 0.35 * np.mod(theta - 2.0, 2 * np.pi),
    lambda theta: np.full_like(theta, 1.35),
    breaks=(2.0,),
)
MAPS = {
    "rotation": CircleMap.rigid(0.3),
    "sine": CircleMap.arnold(0.4, 0.9),
    "folded": CircleMap.arnold(0.1, 5.0),
    "sawtooth": SAWTOOTH,
    "degree 2": CircleMap.blaschke([0.3, 0.2j], 0.1),
    "degree -1": CircleMap(lambda theta: -theta + 0.3 * np.sin(theta), degree=-1),
}


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


@pytest.mark.parametrize("name", MAPS)
def test_graph_holds_images_of_its_angles_and_never_leaps(name) -> None:
    circle_map = MAPS[name]
    graph = map_graph(circle_map)
    total = 0.0
    for theta_deg, image_deg in graph:
        assert image_deg.min() >= -1e-9 and image_deg.max() <= 360.0 + 1e-9
        truth = np.degrees(circle_map(np.radians(theta_deg)))
        # Where the graph meets 0 or 360 it is cut on the chord between two samples, a quarter of a degree apart.
        assert np.abs(np.mod(truth - image_deg + 180.0, 360.0) - 180.0).max() < 2e-3
        assert np.abs(np.diff(image_deg)).max() < 2.0
        total += float(theta_deg[-1] - theta_deg[0])
    assert total == pytest.approx(360.0, abs=1e-5)


@pytest.mark.parametrize(("name", "pieces"), [("rotation", 2), ("sine", 2), ("sawtooth", 3), ("degree 2", 3)])
def test_graph_has_one_piece_for_every_cut(name, pieces) -> None:
    assert len(map_graph(MAPS[name])) == pieces


def test_whole_turns_are_cut_in_both_directions_and_at_samples_on_them() -> None:
    angle = 2 * np.pi * np.array([-0.25, 0.25, 1.0, 1.25, 0.75])
    curves = cut_at_turns(np.arange(5.0), angle)
    assert [x.tolist() for x, _ in curves] == [[0.0, 0.5], [0.5, 1.0, 2.0], [2.0, 3.0, 3.5], [3.5, 4.0]]
    assert [[round(end) for end in (y[0], y[-1])] for _, y in curves] == [[270, 360], [0, 360], [0, 0], [360, 270]]


def test_parabola_touches_the_move_to_third_order_at_the_slowest_point() -> None:
    circle_map = CircleMap.arnold(0.15, 0.9)
    (passage,) = slow_passages(circle_map)
    theta_deg, move_deg, parabola_deg = passage_curve(circle_map, passage)
    x = np.radians(theta_deg) - passage.theta
    assert np.abs(np.degrees(passage.gap) - move_deg[np.argmin(np.abs(x))]) < 1e-10
    assert np.all(np.abs(move_deg - parabola_deg) <= np.degrees(0.9 * x**4 / 24) + 1e-8)


def test_move_of_two_cycles_is_drawn_less_its_whole_turns() -> None:
    circle_map = CircleMap.arnold(0.46, 0.9)
    passages = slow_passages(circle_map, 2)
    assert [passage.winding for passage in passages] == [1, 1]
    for passage in passages:
        _, move_deg, _ = passage_curve(circle_map, passage)
        assert np.abs(move_deg).min() == pytest.approx(abs(np.degrees(passage.gap)), rel=1e-6)


def test_jump_in_the_window_of_a_passage_is_a_gap() -> None:
    broken = CircleMap(lambda x: x + 0.4 + 0.35 * np.cos(x) + 0.3 * (np.mod(x, 2 * np.pi) < 2.0), breaks=(0.0, 2.0))
    (passage,) = slow_passages(broken)
    theta_deg, move_deg, _ = passage_curve(broken, passage)
    assert np.isnan(move_deg).sum() == 1
    assert theta_deg[np.isnan(move_deg)] == pytest.approx(np.degrees([2.0]))
    assert np.nanmax(np.abs(np.diff(move_deg))) < 1.0


@pytest.mark.parametrize(("period", "winding", "within"), [(1, 0, (-0.3, 0.3)), (2, 1, (0.4, 0.6))])
def test_closed_branch_comes_back_without_a_leap(period, winding, within) -> None:
    def family(omega):
        return CircleMap.arnold(omega, 0.9)

    start = 0.0
    branch = follow_orbit(family, start, within, at=winding / period, period=period, winding=winding)
    assert branch.ends == ("closed", "closed")
    runs = branch_curves(branch)
    assert {stable for stable, _ in runs} == {True, False}
    for _, (_, theta_deg) in runs:
        assert np.abs(np.diff(theta_deg)).max() < 12.0
    # The branch runs once round the circle, all points of an orbit together.
    assert sum(np.abs(np.diff(theta_deg)).sum() for _, (_, theta_deg) in runs) == pytest.approx(360.0, abs=1e-6)


def test_stability_changes_at_the_bifurcations_and_nowhere_else() -> None:
    branch = follow_orbit(lambda K: CircleMap.arnold(0.1, K), 0.6, (0.3, 3.0), at=1.2)
    changes = [float(found.parameter) for found in branch.special]
    assert len(changes) == 2
    ends = {
        round(float(end), 9)
        for stable, (parameter, _) in branch_curves(branch)
        for end in (parameter[0], parameter[-1])
        if stable
    }
    assert ends == {round(change, 9) for change in changes}


def sine(K):
    return CircleMap.arnold(0.1, K)


def kinked(shift):
    return CircleMap(lambda x: x + shift + 0.5 * np.abs(np.mod(x + np.pi, 2 * np.pi) - np.pi), breaks=[0.0, np.pi])


@pytest.fixture(scope="module")
def doubling():
    """Fixed points of the sine map from before their birth to beyond their period doubling."""
    axes = panel()
    draw_orbit_branches(axes, orbit_branches(sine, (0.3, 2.5)), bifurcations(sine, (0.3, 2.5)), "K")
    return axes


def test_solid_lines_hold_the_stable_fixed_points_and_dashed_ones_the_others(doubling) -> None:
    counted = {"-": 0, "--": 0}
    for line in doubling.lines:
        if line.get_marker() != "None":
            continue
        for K, theta_deg in line.get_xydata()[1:-1]:
            multiplier = float(sine(K).derivative(np.radians(theta_deg)))
            assert (abs(multiplier) < 1.0) == (line.get_linestyle() == "-")
            assert np.sin(np.radians(theta_deg)) == pytest.approx(0.2 * np.pi / K, abs=1e-9)
            counted[line.get_linestyle()] += 1
    assert min(counted.values()) > 5


def test_bifurcations_stand_where_theory_has_them_with_shapes_of_their_own(doubling) -> None:
    shown = {line.get_marker(): line for line in doubling.lines if line.get_marker() != "None"}
    assert set(shown) == {MARKERS["saddle-node"]["marker"], MARKERS["period-doubling"]["marker"]}
    assert shown["o"].get_xydata() == pytest.approx(np.array([[0.2 * np.pi, 90.0]]), abs=1e-5)
    K = np.hypot(2.0, 0.2 * np.pi)
    place = np.array([[K, np.degrees(np.arctan2(0.2 * np.pi, 2.0))]])
    assert shown["D"].get_xydata() == pytest.approx(place, abs=1e-6)
    assert len({look["marker"] for look in MARKERS.values()}) == len(MARKERS) == 4


def test_legend_names_each_look_once_and_axes_their_units(doubling) -> None:
    assert legend_words(doubling) == ["stable", "unstable", "saddle-node", "period-doubling"]
    assert (doubling.get_xlabel(), doubling.get_ylabel()) == ("K", "θ of the orbit (°)")
    png(doubling)


@pytest.mark.slow
def test_border_collisions_are_marked_and_whole_turns_leave_no_upright_line() -> None:
    axes = panel()
    draw_orbit_branches(axes, orbit_branches(kinked, (-2.0, 0.5)), bifurcations(kinked, (-2.0, 0.5)), "shift (rad)")
    triangles = [line for line in axes.lines if line.get_marker() == "^"]
    assert len(triangles) == 2
    for line in axes.lines:
        assert np.abs(np.diff(line.get_ydata())).max(initial=0.0) < 45.0
    png(axes)


@pytest.mark.slow
def test_every_point_of_a_longer_orbit_is_drawn_and_marked() -> None:
    def family(omega):
        return CircleMap.arnold(omega, 0.9)

    axes = panel()
    draw_orbit_branches(axes, orbit_branches(family, (0.4, 0.6), 2, 1), bifurcations(family, (0.4, 0.6), 2, 1))
    circles = [line for line in axes.lines if line.get_marker() == "o"]
    assert [len(line.get_xdata()) for line in circles] == [2, 2]
    for line in axes.lines:
        assert np.abs(np.diff(line.get_ydata())).max(initial=0.0) < 15.0 or line in circles
    png(axes)


def test_no_branches_are_said_to_be_none() -> None:
    axes = panel()
    draw_orbit_branches(axes, [])
    assert written(axes) == ["no periodic orbit"] and axes.get_legend() is None
    png(axes)


def test_an_orbit_diagram_has_every_angle_and_exponents_a_curve_or_a_colour() -> None:
    axes, diagram = panel(), orbit_diagram(sine, np.linspace(1.5, 4.0, 60), cycles=40)
    draw_orbit_diagram(axes, diagram, "K")
    shown = axes.lines[0].get_xydata()
    assert shown.shape == (60 * 40, 2) and shown[-1] == pytest.approx([4.0, np.degrees(diagram.theta[-1, -1])])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("K", "θ of the orbit (°)")
    png(axes)
    axes, K = panel(), np.linspace(1.5, 4.0, 60)
    curve = lyapunov_exponents(CircleMap.arnold, 0.1, K)
    draw_lyapunov_exponents(axes, curve, "K")
    assert axes.lines[0].get_xydata() == pytest.approx(np.stack([K, curve.value], axis=1))
    png(axes)
    axes = panel()
    draw_lyapunov_exponents(axes, lyapunov_exponents(CircleMap.arnold, np.linspace(0, 1, 20)[:, None], K), "Ω", "K")
    assert axes.collections[0].get_array().shape == (60, 20)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Ω", "K")
    png(axes)
