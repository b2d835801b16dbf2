"""Curves are sampled where the maps are, and cut where they jump or run round the circle."""

import numpy as np
import pytest

from cyclemap.maps import CircleMap, follow_orbit, slow_passages
from cyclemap.views.orbit_panels import branch_curves, cut_at_turns, density_curve, map_graph, passage_curve

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


def test_density_curve_is_per_degree() -> None:
    theta_deg, density = density_curve(lambda theta: (1.0 + np.cos(theta)) / (2 * np.pi))
    assert (theta_deg[0], theta_deg[-1]) == (0.0, 360.0)
    assert np.trapezoid(density, theta_deg) == pytest.approx(1.0, abs=1e-12)


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
