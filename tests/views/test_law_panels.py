"""Distributions of a noisy map, drawn: what each panel says."""

import numpy as np
import pytest
from drawn_panels import faces, labelled, legend_words, panel, png, written
from matplotlib.patches import Circle

from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    metastable_sets,
    quasi_stationary_distribution,
    survival_probabilities,
    transfer_operator,
)
from cyclemap.views.law_panels import (
    density_curve,
    draw_law,
    draw_metastable_sets,
    draw_quasi_stationary_distribution,
    draw_response,
    draw_spectrum,
    draw_survival,
)
from cyclemap.views.style import PREDICTED, UNSTABLE

NOISE = WrappedNormal(0.3)
WELLS = CircleMap(
    lambda x: x - 0.4 * np.sin(2 * x) + 0.1 * np.sin(x), lambda x: 1 - 0.8 * np.cos(2 * x) + 0.1 * np.cos(x)
)
SINE, ARC = CircleMap.arnold(0.1, 0.9), (-1.5, 2.0)


@pytest.fixture(scope="module")
def operator():
    return transfer_operator(CircleMap.arnold(0.1, 0.9), NOISE)


def test_density_curve_is_per_degree() -> None:
    theta_deg, density = density_curve(lambda theta: (1.0 + np.cos(theta)) / (2 * np.pi))
    assert (theta_deg[0], theta_deg[-1]) == (0.0, 360.0)
    assert np.trapezoid(density, theta_deg) == pytest.approx(1.0, abs=1e-12)


def test_law_is_a_probability_per_degree_with_its_bound(operator) -> None:
    axes = panel()
    draw_law(axes, operator)
    curve = labelled(axes, "stationary density, ± ")
    assert np.trapezoid(curve.get_ydata(), curve.get_xdata()) == pytest.approx(1.0, abs=1e-10)
    told = float(legend_words(axes)[0].split("± ")[1].replace("−", "-"))
    assert told == pytest.approx(operator.error_bound * np.pi / 180, rel=0.5)
    assert labelled(axes, "uniform").get_ydata() == [1 / 360, 1 / 360]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("θ (°)", "probability per degree")
    png(axes)


def test_law_of_a_map_of_degree_two_is_drawn() -> None:
    axes = panel()
    draw_law(axes, transfer_operator(CircleMap.blaschke([0.3, 0.2j], 0.1), NOISE))
    assert len(axes.lines) == 2
    png(axes)


def test_law_whose_parts_are_never_connected_says_so() -> None:
    parted = transfer_operator(CircleMap(lambda x: x - 0.45 * np.sin(2 * x)), WrappedNormal(0.03))
    assert not parted.is_certain
    axes = panel()
    draw_law(axes, parted)
    assert legend_words(axes)[0] == "stationary density, shares of its parts unknown"


def test_response_is_the_difference_of_two_laws() -> None:
    axes, step = panel(), 1e-4

    def law(omega):
        return transfer_operator(CircleMap.arnold(omega, 0.9), NOISE)

    draw_response(axes, law(0.1).map_response(lambda theta: np.full_like(theta, 2 * np.pi)), "turn of Ω")
    theta_deg, rate = labelled(axes, "derivative of the density, ± ").get_data()
    change = law(0.1 + step).density(np.radians(theta_deg)) - law(0.1 - step).density(np.radians(theta_deg))
    assert rate == pytest.approx(np.pi / 180 * change / (2 * step), abs=1e-5 * np.abs(rate).max())
    assert axes.get_ylabel() == "probability per degree, a turn of Ω"
    png(axes)


# -- spectrum ----------------------------------------------------------------------------------------------


def test_eigenvalues_and_the_gap_stand_in_the_unit_disc(operator) -> None:
    spectrum = operator.spectrum(9)
    axes = panel()
    draw_spectrum(axes, spectrum)
    values = labelled(axes, "eigenvalue, ± ")
    assert np.array_equal(values.get_xdata() + 1j * values.get_ydata(), spectrum.values)
    x, y = labelled(axes, "|λ₂|: gap 0.37").get_data()
    assert np.hypot(x, y) == pytest.approx(1.0 - operator.spectral_gap)
    assert axes.get_aspect() == 1.0 and axes.get_xlabel() == "real part of λ"
    png(axes)


def test_circles_about_eigenvalues_have_the_radius_of_their_bounds() -> None:
    spectrum = transfer_operator(CircleMap.arnold(0.33, 0.9), NOISE, modes=4).spectrum(7)
    axes = panel()
    draw_spectrum(axes, spectrum)
    unit, *circles = [patch for patch in axes.patches if isinstance(patch, Circle)]
    assert (unit.center, unit.radius) == ((0.0, 0.0), 1.0)
    drawn = [(complex(*circle.center), circle.radius) for circle in circles]
    bounds = zip(spectrum.values.tolist(), spectrum.error_bounds.tolist(), strict=True)
    assert drawn == [(value, bound) for value, bound in bounds if np.isfinite(bound)] and len(drawn) >= 4
    assert max(radius for _, radius in drawn) > 0.01
    png(axes)


def test_eigenvalue_without_a_bound_is_open() -> None:
    from dataclasses import replace

    spectrum = transfer_operator(CircleMap.rigid(0.3), NOISE).spectrum(3)
    unknown = replace(spectrum, error_bounds=np.array([0.0, np.inf, np.inf]))
    axes = panel()
    draw_spectrum(axes, unknown)
    assert faces(axes) == [(PREDICTED, "full", 1), (UNSTABLE, "full", 2)]
    assert "eigenvalue, error unknown" in legend_words(axes)
    png(axes)


def test_spectrum_of_one_eigenvalue_has_no_gap(operator) -> None:
    axes = panel()
    draw_spectrum(axes, operator.spectrum(1))
    assert legend_words(axes) == ["eigenvalue, ± 0 at most"]
    png(axes)


# -- metastable sets ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3])
def test_shaded_arcs_have_the_sets_lengths_and_probabilities(count) -> None:
    law, sets = transfer_operator(WELLS, NOISE), metastable_sets(WELLS, NOISE, count)
    axes = panel()
    draw_metastable_sets(axes, law.density, sets)
    shades = [fill.get_paths()[0].vertices for fill in axes.collections]
    assert sum(np.ptp(corners[:, 0]) for corners in shades) == pytest.approx(360.0, abs=1e-9)
    assert count <= len(shades) <= count + 1
    hatched = sum(np.ptp(fill.get_paths()[0].vertices[:, 0]) for fill in axes.collections if fill.get_hatch())
    assert hatched == pytest.approx(np.degrees(np.ptp(sets.arcs[1::2], axis=1).sum()), abs=1e-9)
    areas = sum(_area(fill) for fill in axes.collections if fill.get_hatch())
    assert areas == pytest.approx(sets.weights[1::2].sum(), abs=1e-5)
    png(axes)


def _area(fill) -> float:
    """Of a closed outline, by the shoelace formula."""
    x, y = fill.get_paths()[0].vertices.T
    return 0.5 * abs(float(np.dot(x[:-1], y[1:]) - np.dot(x[1:], y[:-1])))


def test_names_of_the_sets_tell_weight_staying_and_residence() -> None:
    law, sets = transfer_operator(WELLS, NOISE), metastable_sets(WELLS, NOISE)
    axes = panel()
    draw_metastable_sets(axes, law.density, sets)
    assert len(sets.arcs) == 2
    for number, (weight, leaving) in enumerate(zip(sets.weights, sets.leaving, strict=True), 1):
        (name,) = [text for text in written(axes) if text.startswith(f"set {number}: ")]
        assert f"{100 * weight:.3g} %" in name and f"({1 / leaving:.0f} cycles)" in name
    assert "0.9993" in written(axes)[0] + written(axes)[1]


@pytest.mark.slow
def test_names_of_the_sets_do_not_cover_each_other_or_the_curve(operator) -> None:
    sets = metastable_sets(operator.map, NOISE, 3)
    axes = panel(6.4, 4.2)
    draw_metastable_sets(axes, operator.density, sets)
    png(axes)
    renderer = axes.get_figure().canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in axes.texts]
    assert len(boxes) == 3
    assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])
    top = axes.transData.transform((0.0, labelled(axes, "stationary").get_ydata().max()))[1]
    assert all(box.y0 > top for box in boxes)


def test_survival_runs_parallel_to_the_quasi_stationary_exponential() -> None:
    noise = WrappedNormal(0.8)
    law = quasi_stationary_distribution(SINE, noise, ARC)
    axes = panel()
    draw_survival(axes, survival_probabilities(SINE, noise, 0.0, ARC, 60), law)
    chances = labelled(axes, "from the start").get_ydata()
    exponential = labelled(axes, "from the quasi-stationary law: λⁿ").get_ydata()
    assert exponential[:3] == pytest.approx([1.0, law.survival, law.survival**2])
    assert np.diff(np.log(chances[-9:])) == pytest.approx(np.diff(np.log(exponential[-9:])), rel=1e-9)
    assert axes.get_yscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("cycles", "probability of being still inside")
    png(axes)


def test_survival_over_less_than_a_decade_is_written_without_powers() -> None:
    axes = panel()
    draw_survival(axes, survival_probabilities(SINE, WrappedNormal(0.3), 0.0, ARC, 60))
    png(axes)
    ticks = [tick.get_text() for tick in axes.yaxis.get_ticklabels(which="both")]
    assert "0.95" in ticks and not any("10^" in tick for tick in ticks)
    assert legend_words(axes) == ["from the start"]


@pytest.mark.parametrize("probabilities", [[1.0], [1.0, 0.25, 0.0]])
def test_survival_of_one_number_or_down_to_zero_is_drawn(probabilities) -> None:
    axes = panel()
    draw_survival(axes, np.array(probabilities))
    assert labelled(axes, "from the start").get_ydata().tolist() == [p for p in probabilities if p > 0.0]
    png(axes)


@pytest.mark.parametrize("lifted", [False, True])
def test_law_of_a_long_stay_fills_its_arc_and_tells_its_ends(lifted) -> None:
    law = quasi_stationary_distribution(SINE, WrappedNormal(0.3), ARC, lifted=lifted)
    axes = panel()
    draw_quasi_stationary_distribution(axes, law)
    theta_deg, density = labelled(axes, "density given a long stay").get_data()
    assert (theta_deg[0], theta_deg[-1]) == pytest.approx(np.degrees(ARC))
    assert np.trapezoid(density, theta_deg) == pytest.approx(1.0, abs=1e-6)
    ends = [line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == "--"]
    assert ends == pytest.approx(np.degrees(ARC))
    told = legend_words(axes)[1]
    assert told.startswith(f"ends of the arc: {law.escape_probability:.3g} leaves a cycle")
    assert told.endswith("down)") == lifted
    assert axes.get_xlabel() == ("θ, unwrapped (°)" if lifted else "θ (°)")
    png(axes)
