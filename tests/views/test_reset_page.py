"""Recipes say what the robot does; the page draws every push where the mechanics puts it, and every row."""

import math

import numpy as np
import pytest

import cyclemap as cm
from cyclemap.collection.own_object import first_contact
from cyclemap.mechanics import SidePush
from cyclemap.resets import CycleAction, MaterialRange, ResetDemands, ResetStrategy, design_reset, gripper_turns, legs
from cyclemap.views.reset_page import design_sentences, draw_pushes, recipe, reset_page
from cyclemap.views.style import new_figure, render

pytestmark = pytest.mark.slow

SIDES = tuple(CycleAction(push=SidePush(side)) for side in (1, 2, 3))
SLANTED = CycleAction(push=SidePush(3, 0.3, math.radians(10.0)))


@pytest.mark.parametrize(
    ("strategy", "said"),
    [
        (ResetStrategy(SIDES[:2]), "before every push toss a coin: heads push side 1, tails push side 2, each at 0.7"),
        (ResetStrategy(SIDES), "draw one of 3 lots: 1 of 3 push side 1, 1 of 3 push side 2, 1 of 3 push side 3, each"),
        (ResetStrategy(SIDES[:2], (1.0, 5.0)), "throw a die: 1 of 6 push side 1, 5 of 6 push side 2"),
        (ResetStrategy(SIDES[:2], (1.0, 2.5)), "draw: 28.6% push side 1, 71.4% push side 2"),
        (ResetStrategy((SIDES[0], SLANTED)), "tails push side 3 at 0.3, 10° off its normal"),
        (ResetStrategy(SIDES, order="in turn"), "in turn: push side 1, push side 2, push side 3, each at 0.7"),
        (ResetStrategy(SIDES, order="shuffled"), "in shuffled blocks of 3: push side 1"),
        (ResetStrategy(gripper_turns(4)), "let a gripper turn the object by 0, 90, 180 or 270°, drawn at random"),
        (ResetStrategy(gripper_turns(36)), "by a multiple of 10°"),
        (ResetStrategy(legs(0.2, 8)), "a place 200 mm off the target, in one of 8 equal directions, drawn at random"),
        (ResetStrategy(SIDES[:2], hitch=(0.01, -0.02)), "put the ring at (10.0, -20.0) mm of the object; before"),
        (ResetStrategy((CycleAction(),)), "leave everything as it is"),
        (ResetStrategy((CycleAction(((0.05, 0.0),), turn=1.0),)), "always drag by 50 mm at 0.0°, gripper 57.3°"),
        (ResetStrategy((SIDES[0], CycleAction(push=SidePush(2, distance=0.1)))), "push 100 mm on side 2"),
    ],
)
def test_a_recipe_says_what_the_robot_does(strategy, said) -> None:
    assert said in recipe(strategy)


def test_the_arrows_end_where_the_rod_starts_and_their_shares_stand_beside_them() -> None:
    loop = cm.CollectionLoop.mit()
    axes = new_figure(4, 4).add_subplot()
    draw_pushes(axes, loop, ResetStrategy((SIDES[0], SLANTED), (1.0, 3.0)))
    arrows = [note for note in axes.texts if getattr(note, "arrow_patch", None)]
    assert len(arrows) == 2
    for arrow, action in zip(arrows, (SIDES[0], SLANTED), strict=True):
        (x, y), (dx, dy) = first_contact(loop.slider, action.push, loop.pusher.radius)
        assert arrow.xy == pytest.approx((1e3 * x, 1e3 * y))
        way = np.subtract(arrow.xy, arrow.xyann)
        assert way / np.hypot(*way) == pytest.approx((dx, dy))
    words = {note.get_text() for note in axes.texts}
    assert {"0", "1", "2", "3", "ring", "25%", "75%"} <= words


@pytest.fixture(scope="module")
def design():
    loop = cm.CollectionLoop.mit("isotropic")
    about = MaterialRange(loop.material, ())
    return design_reset(loop, ResetDemands(pushes=100, keep_push=True, drag_ratio=5.0), materials=about)


def test_the_page_has_every_row_and_the_histograms(design) -> None:
    figure = reset_page(design)
    pushes, histogram, errors = figure.axes
    drawn = [patch.get_data().values for patch in histogram.patches if hasattr(patch, "get_data")]
    assert any(np.array_equal(values, design.after[0]) for values in drawn)
    assert any(np.array_equal(values, design.before[0]) for values in drawn)
    assert np.array_equal(errors.lines[0].get_ydata(), design.ratio_tv[0])
    told = " ".join(" ".join(text.get_text().split()) for text in figure.texts)
    for row in design.rows:
        assert recipe(row.strategy) in told
    assert not pushes.axison
    assert render(figure, "svg").startswith(b"<?xml")


def test_the_three_sentences_tell_what_the_chosen_row_holds(design) -> None:
    do, leaves, costs = design_sentences(design)
    row = design.chosen
    assert recipe(row.strategy) in do
    for number in (row.nominal.total_variation, row.nominal.after, row.worst, row.histogram[0], design.independent):
        assert f"{number:.3f}" in leaves
    assert f"{1e3 * row.drag:.0f} mm of drag" in costs and f"{row.seconds:.1f} s a cycle" in costs
