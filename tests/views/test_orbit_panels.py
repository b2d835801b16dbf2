"""A map's graph with its orbits, basins, density, and orbits over a parameter, drawn."""

import numpy as np
import pytest
from drawn_panels import labelled, legend_words, panel, png, written

from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    basins,
    bifurcations,
    lyapunov_exponents,
    orbit_branches,
    orbit_diagram,
    periodic_orbits,
    transfer_operator,
)
from cyclemap.views.orbit_panels import (
    draw_basins,
    draw_density,
    draw_lyapunov_exponents,
    draw_map,
    draw_orbit_branches,
    draw_orbit_diagram,
)

WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x), lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x)
)
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


@pytest.mark.parametrize("name", MAPS)
def test_graph_holds_images_of_its_angles_in_one_piece_for_every_cut_and_never_leaps(name) -> None:
    circle_map, pieces = MAPS[name]
    axes, total = panel(), 0.0
    draw_map(axes, circle_map)
    graph = [line.get_data() for line in axes.lines if line.get_linestyle() == "-"]
    for theta_deg, image_deg in graph:
        assert image_deg.min() >= -1e-9 and image_deg.max() <= 360.0 + 1e-9
        truth = np.degrees(circle_map(np.radians(theta_deg)))
        # Where the graph meets 0 or 360 it is cut on the chord between two samples, a quarter of a degree apart.
        assert np.abs(np.mod(truth - image_deg + 180.0, 360.0) - 180.0).max() < 2e-3
        assert np.abs(np.diff(image_deg)).max() < 2.0
        total += float(theta_deg[-1] - theta_deg[0])
    assert total == pytest.approx(360.0, abs=1e-5)
    assert pieces is None or len(graph) == pieces
    png(axes)


@pytest.mark.parametrize(
    ("circle_map", "period", "words"),
    [
        (CircleMap.arnold(0.5, 0.9), 2, ["stable", "unstable"]),
        (CircleMap.arnold(0.9 / (2 * np.pi), 0.9), 1, ["half-stable"]),
    ],
)
def test_orbits_lie_on_the_graph_and_are_named_by_their_stability(circle_map, period, words) -> None:
    axes = panel()
    draw_map(axes, circle_map, periodic_orbits(circle_map, period))
    assert legend_words(axes) == words
    places = np.concatenate([line.get_xydata() for line in axes.lines if line.get_marker() == "o"])
    turned = np.degrees(circle_map(np.radians(places[:, 0]))) - places[:, 1]
    assert np.mod(turned + 180.0, 360.0) - 180.0 == pytest.approx(0.0, abs=1e-9)
    png(axes)


@pytest.mark.parametrize("circle_map", [CircleMap.arnold(0.1, 0.9), CircleMap.blaschke([0.3, 0.2j], 0.1)])
def test_density_is_a_probability_per_degree_with_its_bound(circle_map) -> None:
    operator, axes = transfer_operator(circle_map, WrappedNormal(0.3)), panel()
    draw_density(axes, operator)
    curve = labelled(axes, "stationary density, ± ")
    assert np.trapezoid(curve.get_ydata(), curve.get_xdata()) == pytest.approx(1.0, abs=1e-10)
    told = float(legend_words(axes)[0].split("± ")[1].replace("−", "-"))
    assert told == pytest.approx(operator.error_bound * np.pi / 180, rel=0.5)
    png(axes)


@pytest.mark.slow
@pytest.mark.parametrize("circle_map", [CircleMap.arnold(0.1, 0.9), WELLS, CircleMap.arnold(0.3, 2.5)])
def test_bands_cover_the_basins_share_of_the_circle_and_tell_it(circle_map) -> None:
    found = basins(circle_map, max_period=2, left_over=1e-3)
    axes = panel()
    draw_basins(axes, found)
    for basin, whole in zip(found, axes.collections[::2], strict=True):
        ends = [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in whole.get_paths()]
        assert sum(high - low for low, high in ends) == pytest.approx(360.0 * basin.measure, abs=1e-6)
        assert f"winding {basin.orbit.winding}: {100 * basin.measure:.3g} % of" in " ".join(written(axes))
    share = found[0].undecided
    assert legend_words(axes)[-1] == f"undecided: {f'{100 * share:.2g} %' if share > 1e-6 else 'nothing'}"
    png(axes)


def test_what_has_nothing_to_draw_or_to_tell_says_so() -> None:
    parts = transfer_operator(CircleMap(lambda x: x - 0.45 * np.sin(2 * x)), WrappedNormal(0.03))
    density, bands, branches = panel(), panel(), panel()
    draw_density(density, parts)
    draw_basins(bands, basins(CircleMap.moebius(0.5, 0.3), max_period=2))
    draw_orbit_branches(branches, [])
    assert legend_words(density)[0] == "stationary density, shares of its parts unknown"
    assert (written(bands), written(branches)) == (["no stable orbit"], ["no periodic orbit"])


def sine(K):
    return CircleMap.arnold(0.1, K)


def test_branches_are_solid_where_stable_and_change_at_bifurcations() -> None:
    """Fixed points of the sine map from before their birth to beyond their period doubling, where theory has them."""
    axes, seen = panel(), set()
    draw_orbit_branches(axes, orbit_branches(sine, (0.3, 2.5)), bifurcations(sine, (0.3, 2.5)), "K")
    for line in axes.lines:
        for K, theta_deg in line.get_xydata()[1:-1] if line.get_marker() == "None" else ():
            stable = abs(float(sine(K).derivative(np.radians(theta_deg)))) < 1.0
            assert stable == (line.get_linestyle() == "-")
            assert np.sin(np.radians(theta_deg)) == pytest.approx(0.2 * np.pi / K, abs=1e-9)
            seen.add(stable)
    assert seen == {True, False}
    assert legend_words(axes) == ["stable", "unstable", "saddle-node", "period-doubling"]
    png(axes)


def test_an_orbit_diagram_has_every_angle_and_exponents_a_curve_or_a_colour() -> None:
    K, omega = np.linspace(1.5, 4.0, 60), np.linspace(0.0, 1.0, 20)
    diagram = orbit_diagram(sine, K, cycles=40)
    curve = lyapunov_exponents(CircleMap.arnold, 0.1, K)
    plane = lyapunov_exponents(CircleMap.arnold, omega[:, None], K)
    panels = [panel() for _ in range(3)]
    draw_orbit_diagram(panels[0], diagram, "K")
    draw_lyapunov_exponents(panels[1], curve, "K")
    draw_lyapunov_exponents(panels[2], plane, "Ω", "K")
    assert panels[0].lines[0].get_xydata().shape == (60 * 40, 2)
    assert panels[1].lines[0].get_xydata() == pytest.approx(np.stack([K, curve.value], axis=1))
    assert panels[2].collections[0].get_array().shape == (60, 20)
    for axes in panels:
        png(axes)
