"""What is told and drawn of a reset over a range of materials, from made-up scores; and under wear."""

from types import SimpleNamespace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.robust.design_under_wear import reset_under_wear
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.material_score import MaterialScore, QuickGrid
from cyclemap.resets.robust.robust_reset import RobustReset
from cyclemap.resets.robust.sampled_materials import INDEPENDENT
from cyclemap.resets.robust.worst_case import Allowance, WorstCase
from cyclemap.resets.strategies.drag_strategies import StraightReset
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.views.robust_page import robust_page, wear_page
from cyclemap.views.robust_sentences import confidence_sentence, robust_sentences, robust_verdict, wear_sentence
from cyclemap.views.style import render

ABOUT = MaterialRange(Material("board", EllipseFriction(0.27, 0.24, 0.02, 0.01)))


def made_up(drawn: list[float], slanted: bool = False) -> RobustReset:
    """Nominal .02, the eight corners .03, and what was drawn."""
    values = [0.02, *[0.03] * 8, *drawn]
    sample = ABOUT.without_direction().sampled(len(values), draw=INDEPENDENT)
    scores = tuple(MaterialScore(value, value, 0.04, 0.1, 0.0) for value in values)
    strategy = DrawnPushes((SidePush(),))
    check = WorstCase(strategy, sample, scores, Allowance(), False)
    return RobustReset(ABOUT, SimpleNamespace(holds=True), strategy, check, slanted, 0)


def test_a_range_that_is_held_is_told_with_what_the_draws_say_of_all_of_it():
    """None of 59: at most 1 - .05^(1/59) = 5.0 % exceed."""
    held = made_up([0.01 * k / 59 for k in range(59)])
    told = robust_sentences(held)
    assert told[0].startswith("Robust: the allowance (0.05) is kept on all of 68 materials")
    assert "nominally 0.0200, at worst 0.0300, on board (ratio -10.0 %, m0 -50.0 %, n0 -50.0 %)" in told[0]
    assert told[1] == "None of the 59 drawn materials exceeds: at 95 % confidence at most 5.0% of the range do."
    assert told[2] == "Mean drag over them: 0.40 of the loop's own, at most 0.40." and len(told) == 3


def test_a_range_that_is_not_held_is_told_with_its_worst_material():
    missed = made_up([0.01, 0.2, 0.01, 0.06], slanted=True)
    verdict = robust_verdict(missed)
    assert verdict.startswith("NOT ROBUST: of 13 materials") and " 2 exceed what is allowed" in verdict
    assert (
        f"at worst 0.2000, on {missed.check.sample.materials[10].name}" in verdict and "slanted pushes too" in verdict
    )
    assert confidence_sentence(missed).startswith("2 of the 4 drawn materials exceed: at 95 % confidence at most 90.2%")
    every = made_up([0.2])
    assert "at most 100.0% of the range" in confidence_sentence(every)


def test_another_strategy_is_set_beside_it_on_the_corners():
    robust, other = made_up([0.01]), made_up([])
    scores = tuple(MaterialScore(value, value, 0.04, 0.1, 0.0) for value in [0.01, *[0.04] * 6, 0.3, 0.06])
    corners = WorstCase(other.strategy, other.check.sample, scores, Allowance(), False)
    told = robust_sentences(robust, ("two pushes", corners))[-1]
    assert told.startswith("“two pushes”, the first by the nominal material, leaves 0.3000 on the worst of the corners")
    assert "exceeds on 2 of 9; the robust one leaves 0.0300 there" in told


@pytest.mark.parametrize("shape", ["png", "svg"])
def test_the_picture_has_a_panel_for_the_materials_and_one_for_each_coordinate(shape):
    rng = np.random.default_rng(0)
    figure = robust_page(made_up((0.01 + 0.03 * rng.random(40)).tolist()))
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["Materials", "Axis ratio", "Offset m0", "Offset n0"]
    counts = sum(bar.get_width() for bar in figure.axes[0].patches)
    assert counts == 40 and all(axes.get_ylim()[1] > 0.05 for axes in figure.axes)
    assert len(render(figure, shape)) > 5000


def test_wear_is_told_and_drawn():
    """On even friction that does not wear nothing changes, and the allowance is never left."""
    even = Material("even", EllipseFriction.isotropic(0.25))
    short = CollectionLoop.mit(even, push=SidePush(distance=0.02))
    course = reset_under_wear(short, StraightReset(), 20, knots=2, grid=QuickGrid(samples=8, modes=8))
    told = wear_sentence(course, 0.05, "even")
    assert told.startswith("As even wears over 20 pushes") and "0.0000 fresh to 0.0000 worn" in told
    assert "stays within 0.05 throughout" in told
    places, frozen = course.frozen_course(5)
    assert places.tolist() == [0.0, 5.0, 10.0, 15.0, 20.0] and frozen.max() < 1e-6
    figure = wear_page(course, 0.05, "even")
    assert len(figure.axes) == 1 and len(render(figure)) > 5000
