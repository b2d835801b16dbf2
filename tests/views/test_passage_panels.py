"""Staying and leaving: survival on a logarithmic scale, and the law of a long stay."""

import numpy as np
import pytest
from drawn_panels import labelled, legend_words, panel, png

from cyclemap.maps import CircleMap, WrappedNormal, quasi_stationary_distribution, survival_probabilities
from cyclemap.views.law_panels import draw_quasi_stationary_distribution, draw_survival

SINE, ARC = CircleMap.arnold(0.1, 0.9), (-1.5, 2.0)


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
