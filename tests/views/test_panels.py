"""Panels of maps, orbits, rotation numbers and steps come out with their words, and graphs are where they belong."""

from fractions import Fraction

import numpy as np
import pytest
from matplotlib.axes import Axes

from cyclemap import maps
from cyclemap.maps import ARNOLD_FAMILY, MOEBIUS_FAMILY, CircleMap, WrappedNormal
from cyclemap.views import orbit_panels, rotation_panels, style
from cyclemap.views.staircase_page import draw_step_lengths, draw_steps

WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x), lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x)
)
PARTS = CircleMap(lambda x: x - 0.45 * np.sin(2 * x))
SAWTOOTH = CircleMap(
    lambda theta: theta - 1.0 + 0.35 * np.mod(theta - 2.0, 2 * np.pi),
    lambda theta: np.full_like(theta, 1.35),
    breaks=(2.0,),
)
MAPS = {
    "rotation": (CircleMap.rigid(0.3), 2),
    "sine": (CircleMap.arnold(0.4, 0.9), 2),
    "folded": (CircleMap.arnold(0.1, 5.0), None),
    "sawtooth": (SAWTOOTH, 3),
    "degree 2": (CircleMap.blaschke([0.3, 0.2j], 0.1), 3),
    "degree -1": (CircleMap(lambda theta: -theta + 0.3 * np.sin(theta), degree=-1), None),
}
BEND, OMEGA = np.linspace(1.5, 4.0, 60), np.linspace(0.0, 1.0, 201)
STAIRS = np.repeat([0.0, 1.0, 2.0], [20, 30, 40])
GHOST, GHOST_NOISE = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)


def sine(K):
    return CircleMap.arnold(0.1, K)


def drawn(draw, *values) -> Axes:
    """A panel that is drawn and comes out; a legend stands above it, where it covers nothing."""
    with style.picture_style():
        figure = style.new_figure(6.0, 4.0)
    axes = figure.add_subplot()
    draw(axes, *values)
    assert style.render(figure, "png", 60).startswith(b"\x89PNG")
    renderer, legend = figure.canvas.get_renderer(), axes.get_legend()
    assert legend is None or legend.get_window_extent(renderer).y0 >= axes.get_window_extent(renderer).y1 - 1
    return axes


def words(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [text.get_text() for text in (*axes.texts, *(legend.get_texts() if legend else ()))]


def planes():
    across, alone = np.linspace(0.0, 0.5, 26), ([0.5], [0.3])
    yield maps.rotation_plane(ARNOLD_FAMILY, across, [0.2, 0.5, 0.8, 1.1], tolerance=0.02)
    yield from (maps.rotation_plane(MOEBIUS_FAMILY, *axes) for axes in (alone, ([0.6, 0.5], [0.3, 0.2, 0.1])))


def dwells():
    """Steps of a sampled staircase beside the prediction, and of a path that never rests."""
    prediction = maps.predict_staircase(GHOST, GHOST_NOISE)
    steps = maps.find_steps(maps.sample_staircase(GHOST, GHOST_NOISE, 240).theta, zones=prediction.zones)
    yield steps, maps.compare_steps(steps, prediction)
    yield (maps.find_steps(np.linspace(0.0, 60.0, 300)),)


def kinds(draw, *circle_maps: CircleMap):
    for circle_map in circle_maps:
        yield draw, maps.transfer_operator(circle_map, WrappedNormal(0.03 if circle_map is PARTS else 0.3))


PANELS = {
    "orbits": lambda: [
        (orbit_panels.draw_map, circle_map, maps.periodic_orbits(circle_map, period))
        for circle_map, period in ((CircleMap.arnold(0.5, 0.9), 2), (CircleMap.arnold(0.9 / (2 * np.pi), 0.9), 1))
    ],
    "densities": lambda: [*kinds(orbit_panels.draw_density, sine(0.9), MAPS["degree 2"][0], PARTS)],
    "basins": lambda: [
        (orbit_panels.draw_basins, maps.basins(circle_map, max_period=2, left_over=1e-3))
        for circle_map in (sine(0.9), WELLS, CircleMap.arnold(0.3, 2.5), CircleMap.moebius(0.5, 0.3))
    ],
    "no branch": lambda: [(orbit_panels.draw_orbit_branches, [])],
    "orbit diagram": lambda: [(orbit_panels.draw_orbit_diagram, maps.orbit_diagram(sine, BEND, cycles=40), "K")],
    "exponents": lambda: [
        (orbit_panels.draw_lyapunov_exponents, maps.lyapunov_exponents(CircleMap.arnold, omega, BEND), *names)
        for omega, names in ((0.1, "K"), (OMEGA[::10, None], "ΩK"))
    ],
    "rotation planes": lambda: [(rotation_panels.draw_rotation_plane, plane, "Ω", "K") for plane in planes()],
    "plateaus": lambda: [
        (rotation_panels.draw_rotation_numbers, OMEGA, maps.rotation_numbers(ARNOLD_FAMILY, OMEGA, 0.95), "Ω")
    ],
    "tongues": lambda: [
        (
            rotation_panels.draw_tongues,
            maps.tongues(CircleMap.arnold, [0, Fraction(1, 2), Fraction(1, 3)], [0.4, 0.8, 1.2], (-0.5, 1.0)),
        )
    ],
    "steps": lambda: [(draw_steps, STAIRS, maps.find_steps(STAIRS))],
    "step lengths": lambda: [(draw_step_lengths, *values) for values in dwells()],
}
WORDS = {
    "orbits": ["stable", "unstable", "half-stable"],
    "densities": ["stationary density, ± ", "stationary density, shares of its parts unknown"],
    "basins": ["period 1, winding 0: ", "undecided: nothing", "no stable orbit"],
    "no branch": ["no periodic orbit"],
    "plateaus": ["0/1", "1/3", "1/2", "2/3", "1/1"],
    "tongues": ["0/1", "1/2", "1/3", "edge of a tongue", "edge where the map folds"],
    "steps": ["0.0°", "57.3°", "114.6°"],
    "step lengths": ["dwell", "mean", "predicted", "no dwell"],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_a_panel_comes_out_with_its_words(name) -> None:
    told = [one for panel in PANELS[name]() for one in words(drawn(*panel))]
    assert [word for word in WORDS.get(name, []) if not any(one.startswith(word) for one in told)] == []


@pytest.mark.parametrize("name", MAPS)
def test_graph_holds_images_of_its_angles_in_one_piece_for_every_cut_and_never_leaps(name) -> None:
    circle_map, pieces = MAPS[name]
    lines = drawn(orbit_panels.draw_map, circle_map).lines
    graph = [line.get_data() for line in lines if line.get_linestyle() == "-"]
    for theta_deg, image_deg in graph:
        assert image_deg.min() >= -1e-9 and image_deg.max() <= 360.0 + 1e-9
        truth = np.degrees(circle_map(np.radians(theta_deg)))
        # Where the graph meets 0 or 360 it is cut on the chord between two samples, a quarter of a degree apart.
        assert np.abs(np.mod(truth - image_deg + 180.0, 360.0) - 180.0).max() < 2e-3
        assert np.abs(np.diff(image_deg)).max() < 2.0
    assert sum(theta[-1] - theta[0] for theta, _ in graph) == pytest.approx(360.0, abs=1e-5)
    assert pieces in (None, len(graph))


def test_branches_are_solid_where_stable_and_change_at_bifurcations() -> None:
    """Fixed points of the sine map from before their birth to beyond their period doubling, where theory has them."""
    found = maps.orbit_branches(sine, (0.3, 2.5)), maps.bifurcations(sine, (0.3, 2.5))
    axes, seen = drawn(orbit_panels.draw_orbit_branches, *found, "K"), set()
    for line in axes.lines:
        for K, theta_deg in line.get_xydata()[1:-1] if line.get_marker() == "None" else ():
            stable = abs(float(sine(K).derivative(np.radians(theta_deg)))) < 1.0
            assert stable == (line.get_linestyle() == "-")
            assert np.sin(np.radians(theta_deg)) == pytest.approx(0.2 * np.pi / K, abs=1e-9)
            seen.add(stable)
    assert seen == {True, False}
    assert words(axes) == ["stable", "unstable", "saddle-node", "period-doubling"]
