"""Panels of maps, orbits, rotation numbers and steps come out with their words, and graphs are
where they belong.
"""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from matplotlib.axes import Axes

from cyclemap import maps
from cyclemap.collection import CollectionLoop
from cyclemap.maps import ARNOLD_FAMILY, MOEBIUS_FAMILY, CircleMap, WrappedNormal
from cyclemap.views.panels.layout import new_figure, render
from cyclemap.views.panels.orbits import (
    draw_basins,
    draw_density,
    draw_lyapunov_exponents,
    draw_map,
    draw_orbit_branches,
    draw_orbit_diagram,
)
from cyclemap.views.panels.rotation import (
    draw_bifurcation_curves,
    draw_rotation_numbers,
    draw_rotation_plane,
    draw_tongues,
)
from cyclemap.views.panels.scene import cycle_key, shown_forces, strongest_force
from cyclemap.views.panels.style import picture_style
from cyclemap.views.portrait_page import draw_step_lengths, draw_steps

WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x),
    lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x),
)
PARTS = CircleMap(lambda x: x - 0.45 * np.sin(2 * x))
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
TWO, TOUCHING = CircleMap.arnold(0.5, 0.9), CircleMap.arnold(0.9 / (2 * np.pi), 0.9)
BEND, OMEGA = np.linspace(1.5, 4.0, 60), np.linspace(0.0, 1.0, 201)
STAIRS = np.repeat([0.0, 1.0, 2.0], [20, 30, 40])


def sine(K):
    return CircleMap.arnold(0.1, K)


def drawn(draw, *values) -> Axes:
    """A panel that is drawn and comes out; a legend stands above it, where it covers nothing."""
    with picture_style():
        figure = new_figure(6.0, 4.0)
    axes = figure.add_subplot()
    draw(axes, *values)
    assert render(figure, "png", 60).startswith(b"\x89PNG")
    renderer, legend = figure.canvas.get_renderer(), axes.get_legend()
    if legend is not None:
        below = axes.get_window_extent(renderer).y1 - 1
        assert legend.get_window_extent(renderer).y0 >= below
    return axes


def words(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [text.get_text() for text in (*axes.texts, *(legend.get_texts() if legend else ()))]


def law(circle_map: CircleMap, sigma: float = 0.3):
    return (maps.transfer_operator(circle_map, WrappedNormal(sigma)),)


def basins(circle_map: CircleMap):
    return (maps.basins(circle_map, max_period=2, left_over=1e-3),)


def plane(family, *axes, tolerance: float = 1e-3):
    return maps.rotation_plane(family, *axes, tolerance=tolerance), "Ω", "K"


def dwells():
    """Steps of a sampled staircase, and their prediction."""
    ghost, noise = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
    prediction = maps.predict_staircase(ghost, noise)
    steps = maps.find_steps(maps.sample_staircase(ghost, noise, 240).theta, zones=prediction.zones)
    return steps, maps.compare_steps(steps, prediction)


@cache
def tongues():
    ratios = [0, Fraction(1, 2), Fraction(1, 3)]
    return maps.tongues(CircleMap.arnold, ratios, [0.4, 0.8, 1.2], (-0.5, 1.0))


PANELS = [
    (draw_map, lambda: (TWO, maps.periodic_orbits(TWO, 2)), ["stable", "unstable"]),
    (draw_map, lambda: (TOUCHING, maps.periodic_orbits(TOUCHING, 1)), ["half-stable"]),
    (draw_density, lambda: law(sine(0.9)), ["stationary density, ± "]),
    (draw_density, lambda: law(PARTS, 0.03), ["stationary density, shares of its parts unknown"]),
    (draw_basins, lambda: basins(sine(0.9)), ["period 1, winding 0: ", "undecided: nothing"]),
    (draw_basins, lambda: basins(WELLS), ["period 1, winding 0: "]),
    (draw_basins, lambda: basins(CircleMap.arnold(0.3, 2.5)), ["period "]),
    (draw_basins, lambda: basins(CircleMap.moebius(0.5, 0.3)), ["no stable orbit"]),
    (draw_orbit_branches, lambda: ([],), ["no periodic orbit"]),
    (draw_orbit_diagram, lambda: (maps.orbit_diagram(sine, BEND, cycles=40), "K"), []),
    (
        draw_lyapunov_exponents,
        lambda: (maps.lyapunov_exponents(CircleMap.arnold, 0.1, BEND), "K"),
        [],
    ),
    (
        draw_lyapunov_exponents,
        lambda: (maps.lyapunov_exponents(CircleMap.arnold, OMEGA[:, None], BEND), *"ΩK"),
        [],
    ),
    (
        draw_rotation_plane,
        lambda: plane(ARNOLD_FAMILY, OMEGA[:100:4], [0.2, 0.5, 0.8, 1.1], tolerance=0.02),
        [],
    ),
    (draw_rotation_plane, lambda: plane(MOEBIUS_FAMILY, [0.5], [0.3]), []),
    (draw_rotation_plane, lambda: plane(MOEBIUS_FAMILY, [0.6, 0.5], [0.3, 0.2, 0.1]), []),
    (
        draw_rotation_numbers,
        lambda: (OMEGA, maps.rotation_numbers(ARNOLD_FAMILY, OMEGA, 0.95), "Ω"),
        ["0/1", "1/3", "1/2", "2/3", "1/1"],
    ),
    (
        draw_tongues,
        lambda: (tongues(),),
        ["0/1", "1/2", "1/3", "edge of a tongue", "edge where the map folds"],
    ),
    (
        draw_bifurcation_curves,
        lambda: (
            maps.bifurcation_curves(CircleMap.arnold, (-0.6, 0.6), (-0.1, 3.0), lines=1),
            tongues(),
        ),
        ["0/1", "1/2", "1/3", "edge of a tongue", "saddle-node", "period-doubling", "tip"],
    ),
    (draw_steps, lambda: (STAIRS, maps.find_steps(STAIRS)), ["0.0°", "57.3°", "114.6°"]),
    (draw_step_lengths, dwells, ["dwell", "mean", "predicted"]),
    (draw_step_lengths, lambda: (maps.find_steps(np.linspace(0.0, 60.0, 300)),), ["no dwell"]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("draw", "values", "wanted"), PANELS)
def test_a_panel_comes_out_with_its_words(draw, values, wanted) -> None:
    told = words(drawn(draw, *values()))
    assert [word for word in wanted if not any(one.startswith(word) for one in told)] == []


@pytest.mark.parametrize("name", MAPS)
def test_graph_holds_images_of_its_angles_each_once_in_the_window_and_never_leaps(name) -> None:
    circle_map = MAPS[name]
    axes = drawn(draw_map, circle_map)
    assert axes.get_ylim() == (0.0, 360.0)
    graph = [line.get_data() for line in axes.lines if line.get_linestyle() == "-"]
    seen = np.array([], dtype=float)
    for theta_deg, image_deg in graph:
        truth = np.degrees(circle_map(np.radians(theta_deg)))
        assert np.abs(np.mod(truth - image_deg + 180.0, 360.0) - 180.0).max() < 1e-6
        assert np.abs(np.diff(image_deg)).max() < 2.0
        seen = np.append(seen, theta_deg[(image_deg >= 0.0) & (image_deg < 360.0)])
    # Where the map jumps both sides of the jump are drawn.
    assert np.diff(np.unique(seen)).max() < 0.3
    assert seen.size - np.unique(seen).size <= 2


def test_branches_are_solid_where_stable_and_change_at_bifurcations() -> None:
    """Fixed points of the sine map from before their birth to beyond their period doubling, where
    theory has them.
    """
    found = maps.orbit_branches(sine, (0.3, 2.5)), maps.bifurcations(sine, (0.3, 2.5))
    axes, seen = drawn(draw_orbit_branches, *found, "K"), set()
    for line in axes.lines:
        for K, theta_deg in line.get_xydata()[1:-1] if line.get_marker() == "None" else ():
            stable = abs(float(sine(K).derivative(np.radians(theta_deg)))) < 1.0
            assert stable == (line.get_linestyle() == "-")
            assert np.sin(np.radians(theta_deg)) == pytest.approx(0.2 * np.pi / K, abs=1e-9)
            seen.add(stable)
    assert seen == {True, False}
    assert words(axes) == ["stable", "unstable", "saddle-node", "period-doubling"]


def test_the_forces_shown_are_some_of_the_course_and_the_key_names_the_largest():
    cycle = CollectionLoop.mit("plywood").cycle(0.7)
    for course in (cycle.trajectory.push, cycle.trajectory.drag):
        places, forces = shown_forces(course)
        assert len(places) == len(forces) >= 2
        assert all((course.contact_force == force).all(axis=1).any() for force in forces)
        assert (np.hypot(*forces.T) <= strongest_force(cycle)).all()
    assert f"longest {strongest_force(cycle):.2g} N" in cycle_key(cycle)
