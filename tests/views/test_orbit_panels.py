"""A map's graph with its orbits, basins, density, and orbits over a parameter, drawn."""

import numpy as np
import pytest
from drawn_panels import faces, labelled, legend_words, panel, png, written

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
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("θ (°)", "next θ (°)")
    assert axes.get_legend() is None and faces(axes) == []
    png(axes)


@pytest.mark.parametrize(
    ("circle_map", "period", "looks", "words"),
    [
        (CircleMap.arnold(0.5, 0.9), 2, [(PREDICTED, "full", 2), (UNSTABLE, "full", 2)], ["stable", "unstable"]),
        (CircleMap.arnold(0.9 / (2 * np.pi), 0.9), 1, [(PREDICTED, "left", 1)], ["half-stable"]),
    ],
)
def test_orbits_lie_on_the_graph_stable_ones_filled_others_open_saddle_nodes_half(
    circle_map, period, looks, words
) -> None:
    axes = panel()
    draw_map(axes, circle_map, periodic_orbits(circle_map, period))
    assert sorted(faces(axes)) == sorted(looks) and legend_words(axes) == words
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
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("θ (°)", "probability per degree")
    png(axes)


def test_density_whose_parts_are_never_connected_says_so() -> None:
    axes = panel()
    draw_density(axes, transfer_operator(CircleMap(lambda x: x - 0.45 * np.sin(2 * x)), WrappedNormal(0.03)))
    assert legend_words(axes)[0] == "stationary density, shares of its parts unknown"


def bars(collection) -> list[tuple[float, float]]:
    """(low, high) of every bar, in the order drawn."""
    return [(float(path.vertices[:, 0].min()), float(path.vertices[:, 0].max())) for path in collection.get_paths()]


@pytest.mark.slow
@pytest.mark.parametrize("circle_map", [CircleMap.arnold(0.1, 0.9), WELLS, CircleMap.arnold(0.3, 2.5)])
def test_bands_cover_the_basins_share_of_the_circle_and_tell_it(circle_map) -> None:
    found = basins(circle_map, max_period=2, left_over=1e-3)
    axes = panel()
    draw_basins(axes, found)
    assert len(axes.collections) == 2 * len(found) > 0
    for basin, whole, near in zip(found, axes.collections[::2], axes.collections[1::2], strict=True):
        assert sum(high - low for low, high in bars(whole)) == pytest.approx(360.0 * basin.measure, abs=1e-6)
        assert near.get_hatch() and not whole.get_hatch()
        assert f"winding {basin.orbit.winding}: {100 * basin.measure:.3g} % of" in " ".join(written(axes))
    assert faces(axes) == [(PREDICTED, "full", basin.orbit.period) for basin in found]
    share = found[0].undecided
    assert legend_words(axes)[-1] == f"undecided: {f'{100 * share:.2g} %' if share > 1e-6 else 'nothing'}"
    png(axes)


def test_map_without_stable_orbits_says_so() -> None:
    axes = panel()
    draw_basins(axes, basins(CircleMap.moebius(0.5, 0.3), max_period=2))
    assert written(axes) == ["no stable orbit"]


def sine(K):
    return CircleMap.arnold(0.1, K)


def test_branches_are_solid_where_stable_and_change_at_bifurcations_that_stand_where_theory_has_them() -> None:
    """Fixed points of the sine map from before their birth to beyond their period doubling."""
    axes, counted = panel(), {"-": 0, "--": 0}
    draw_orbit_branches(axes, orbit_branches(sine, (0.3, 2.5)), bifurcations(sine, (0.3, 2.5)), "K")
    for line in axes.lines:
        for K, theta_deg in line.get_xydata()[1:-1] if line.get_marker() == "None" else ():
            multiplier = float(sine(K).derivative(np.radians(theta_deg)))
            assert (abs(multiplier) < 1.0) == (line.get_linestyle() == "-")
            assert np.sin(np.radians(theta_deg)) == pytest.approx(0.2 * np.pi / K, abs=1e-9)
            counted[line.get_linestyle()] += 1
    assert min(counted.values()) > 5
    shown = {line.get_marker(): line.get_xydata() for line in axes.lines if line.get_marker() != "None"}
    assert shown["o"] == pytest.approx(np.array([[0.2 * np.pi, 90.0]]), abs=1e-5) and len(shown) == 2
    assert legend_words(axes) == ["stable", "unstable", "saddle-node", "period-doubling"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("K", "θ of the orbit (°)")
    png(axes)


def test_no_branches_are_said_to_be_none() -> None:
    axes = panel()
    draw_orbit_branches(axes, [])
    assert written(axes) == ["no periodic orbit"] and axes.get_legend() is None


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
