"""Recipes say what the robot does; the page draws every row."""

import math
import re

import pytest

import cyclemap as cm
from cyclemap.mechanics import SidePush
from cyclemap.resets import (
    CycleAction,
    MaterialRange,
    ResetDemands,
    ResetStrategy,
    design_reset,
    gripper_turns,
    legs,
)
from cyclemap.views.panels.layout import render
from cyclemap.views.reset_page import (
    design_sentences,
    histogram_words,
    recipe,
    reset_page,
    row_cells,
)

pytestmark = pytest.mark.slow

SIDES = tuple(CycleAction(push=SidePush(side)) for side in (1, 2, 3))
SLANTED = CycleAction(push=SidePush(3, 0.3, math.radians(10.0)))


@pytest.mark.parametrize(
    ("strategy", "said"),
    [
        (
            ResetStrategy(SIDES[:2]),
            "before every push toss a coin: heads push side 1, tails push side 2, each at 0.7",
        ),
        (
            ResetStrategy(SIDES),
            "draw one of 3 lots: 1 of 3 push side 1, 1 of 3 push side 2, 1 of 3 push side 3, each",
        ),
        (
            ResetStrategy(SIDES[:2], (1.0, 5.0)),
            "throw a die: 1 of 6 push side 1, 5 of 6 push side 2",
        ),
        (ResetStrategy(SIDES[:2], (1.0, 2.5)), "draw: 28.6% push side 1, 71.4% push side 2"),
        (ResetStrategy((SIDES[0], SLANTED)), "tails push side 3 at 0.3, 10° off its normal"),
        (
            ResetStrategy(SIDES, order="in turn"),
            "in turn: push side 1, push side 2, push side 3, each at 0.7",
        ),
        (ResetStrategy(SIDES, order="shuffled"), "in shuffled blocks of 3: push side 1"),
        (
            ResetStrategy(gripper_turns(4)),
            "let a gripper turn the object by 0, 90, 180 or 270°, drawn at random",
        ),
        (ResetStrategy(gripper_turns(36)), "by a multiple of 10°"),
        (
            ResetStrategy(legs(0.2, 8)),
            "a place 200 mm off the target, in one of 8 equal directions, drawn at random",
        ),
        (
            ResetStrategy(SIDES[:2], hitch=(0.01, -0.02)),
            "put the ring at (10.0, -20.0) mm of the object; before",
        ),
        (ResetStrategy((CycleAction(),)), "leave everything as it is"),
        (
            ResetStrategy((CycleAction(((0.05, 0.0),), turn=1.0),)),
            "always drag by 50 mm at 0.0°, gripper 57.3°",
        ),
        (
            ResetStrategy((SIDES[0], CycleAction(push=SidePush(2, distance=0.1)))),
            "push 100 mm on side 2",
        ),
    ],
)
def test_a_recipe_says_what_the_robot_does(strategy, said) -> None:
    assert said in recipe(strategy)


@pytest.fixture(scope="module")
def design():
    loop = cm.CollectionLoop.mit("isotropic")
    about = MaterialRange(loop.material, ())
    return design_reset(
        loop, ResetDemands(pushes=100, keep_push=True, drag_ratio=5.0), materials=about
    )


def test_the_page_has_every_row_and_the_histograms(design) -> None:
    figure = reset_page(design)
    assert len(figure.axes) == 3
    told = " ".join(" ".join(text.get_text().split()) for text in figure.texts)
    for row in design.rows:
        assert recipe(row.strategy) in told
    assert render(figure, "svg").startswith(b"<?xml")


def test_the_three_sentences_tell_what_the_chosen_row_holds(design) -> None:
    do, leaves, costs = design_sentences(design)
    row = design.chosen
    assert recipe(row.strategy) in do
    told = [f"{number:.3f}" for number in (row.worst, row.worst_after, row.worst_histogram[0])]
    assert re.findall(r"0\.\d{3}", leaves) == told
    cells = " ".join(row_cells(row))
    for number in (
        row.nominal.total_variation,
        row.worst,
        row.worst_after,
        row.histogram[0],
        row.worst_histogram[0],
    ):
        assert f"{number:.3f}" in cells
    assert f"{design.independent:.3f}" in histogram_words(design)
    assert f"{1e3 * row.drag:.0f} mm of drag" in costs and f"{row.seconds:.1f} s a cycle" in costs
