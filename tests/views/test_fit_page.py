"""The page of a fit draws what was measured and fitted, and its sentences carry the numbers."""

from pathlib import Path

import numpy as np
import pytest
from drawn_words import assert_words_apart

from cyclemap.errors import InvalidInput
from cyclemap.evidence import PushSet, SetFit, Theta0Pairs, fit_set
from cyclemap.views import fit_page as sentences
from cyclemap.views.fit_page import fit_page
from cyclemap.views.panels.layout import render

pytestmark = pytest.mark.slow

TURN = 2 * np.pi


def made_path(count: int, step: float, wear: float) -> Theta0Pairs:
    """A path whose bottleneck at 180° opens with the cycle number."""
    rng, path = np.random.default_rng(0), [0.0]
    for n in range(count):
        turn = step + 0.25 * np.cos(path[-1]) + wear * n
        path.append(path[-1] + turn + 0.02 * rng.standard_normal())
    angles, number = np.array(path), np.arange(count + 1.0)
    return Theta0Pairs(angles[:-1], angles[1:], angles, {"jump": 2}, number[:-1], number)


def made_set(pairs: Theta0Pairs | None, moved: bool = True, contacts: int = 1) -> PushSet:
    rng = np.random.default_rng(1)
    theta = rng.uniform(0.0, TURN, 120) if pairs is None else pairs.theta
    known = 1.0 if moved else np.nan
    dtheta = known * (1.2 + 0.1 * np.cos(2 * theta) + 0.02 * rng.standard_normal(theta.size))
    dx = known * (0.04 + 0.003 * np.cos(theta) + 0.0005 * rng.standard_normal(theta.size))
    dy = known * (-0.08 + 0.001 * rng.standard_normal(theta.size))
    return PushSet("made", Path("made.csv"), {}, contacts, theta, dtheta, dx, dy, pairs)


@pytest.fixture(scope="module")
def whole() -> SetFit:
    return fit_set(made_set(made_path(250, 0.26, 4e-4)))


@pytest.fixture(scope="module")
def motion() -> SetFit:
    return fit_set(made_set(None, contacts=120))


@pytest.fixture(scope="module")
def angles() -> SetFit:
    return fit_set(made_set(made_path(150, 0.28, 0.0), moved=False), wear=False)


def test_every_page_has_its_rows_of_panels_which_lie_apart(whole, motion, angles) -> None:
    pushes = ["Δθ", "Δx", "Δy", "Histogram of Δθ"]
    cycles = ["Cycle map", "Directions", "Staircase", "Turns"]
    for fit, titles in ((whole, pushes + cycles), (motion, pushes), (angles, cycles)):
        figure = fit_page(fit)
        assert render(figure, dpi=36).startswith(b"\x89PNG")
        assert [axes.get_title(loc="left") for axes in figure.axes] == titles
        assert_words_apart(figure)


def test_sentences_carry_the_numbers(whole) -> None:
    said = " ".join(sentences.set_sentences(whole))
    law, forecast = whole.laws[0], whole.cycle_map.forecast
    assert said.startswith("made: 250 pushes (2 left out: jump).")
    for part in (
        f"{law.law.harmonics} harmonics leaves {np.degrees(law.law.rmse):.2f}° "
        f"({law.law.percent:.1f} %)",
        f"{forecast.measured_turns:.2f} turns were measured",
        f"{np.mean(forecast.turns):.2f} ± {np.std(forecast.turns):.2f} are predicted",
        f"the last full turn took {forecast.pace.measured[-1]:.0f} pushes, predicted",
        *("Δy −80.", "wearing with degree 1", "a bottleneck at 1"),
    ):
        assert part in said


def test_what_is_not_known_is_said(motion, angles) -> None:
    first, *_, last = sentences.set_sentences(motion)
    assert "120 pushes at 120 contacts, pooled: none was repeated often." in first
    assert last == "No cycle map: no push has a known next θ0."
    assert "θ0 tells next to nothing of it" in sentences.law_sentence(motion.laws[2])
    assert "of which θ0 alone is known" in sentences.count_sentence(angles)
    assert ", no wear seen;" in sentences.order_sentence(angles.cycle_map)
    short = fit_set(made_set(made_path(25, 0.26, 0.02), moved=False))
    unknown = ", wear unknown (100 cycles or more would tell);"
    assert unknown in sentences.order_sentence(short.cycle_map)
    # Two readings by turns fix no slope between them.
    still = np.random.default_rng(0).choice([0.2, 0.202], 60)
    two = fit_set(made_set(Theta0Pairs(still[:-1], still[1:], still), moved=False))
    assert "turns by an angle that these pushes do not tell" in sentences.place_sentence(
        two.cycle_map
    )


def test_a_map_that_locks_is_drawn_with_its_fixed_points_and_no_turns() -> None:
    fit = fit_set(made_set(made_path(150, 0.1, 0.0), moved=False), harmonics=1, wear=False)
    axes = fit_page(fit).axes
    assert len(fit.cycle_map.early.fixed_points) == 1
    assert "fixed points: stable" in sentences.place_sentence(fit.cycle_map)
    assert "No full turn was measured." in sentences.map_sentences(fit.cycle_map)
    titles = [panel.get_title(loc="left") for panel in axes]
    assert titles == ["Cycle map", "Directions", "Staircase"]
    marks = [line for line in axes[0].lines if line.get_marker() == "o"]
    assert [len(line.get_xdata()) for line in marks].count(1) == 1


def test_curves_and_words_keep_to_the_orientations_that_were_measured() -> None:
    theta, noise = np.random.default_rng(2).uniform((0.5, -0.03), (2.0, 0.03), (120, 2)).T
    pairs = Theta0Pairs(theta, theta + 0.3 + 0.1 * np.cos(theta) + noise)
    fit = fit_set(made_set(pairs))
    axes = fit_page(fit).axes
    (fitted,) = (line for line in axes[4].lines if line.get_label() == "fitted map")
    for line in (axes[0].lines[1], fitted):
        drawn = np.deg2rad(line.get_xdata()[np.isfinite(line.get_ydata())])
        assert 0.45 < drawn.min() < drawn.max() < 2.05
    low, high = np.degrees(theta.min()), np.degrees(theta.max())
    said = sentences.set_sentences(fit)
    assert f"θ0 covers {high - low:.0f}° of the circle ({low:.0f}° to {high:.0f}°)" in said[0]
    assert "It has no slow zone among the measured θ0" in " ".join(said)


def test_a_set_to_which_nothing_was_fitted_has_no_page() -> None:
    few = PushSet("few", Path("few.csv"), {}, 1, *np.zeros((4, 3)), None)
    fit = fit_set(few)
    assert fit.is_empty
    with pytest.raises(InvalidInput, match="nothing was fitted to few: too few pushes"):
        fit_page(fit)
