"""Branches of orbits: solid where stable, dashed where not, and every bifurcation at its place."""

import numpy as np
import pytest
from drawn_panels import legend_words, panel, png, written

from cyclemap.maps import CircleMap, bifurcations, lyapunov_exponents, orbit_branches, orbit_diagram
from cyclemap.views.orbit_panels import (
    MARKERS,
    draw_lyapunov_exponents,
    draw_orbit_branches,
    draw_orbit_diagram,
)


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
