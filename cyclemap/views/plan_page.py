"""A plan of pushes in sentences and on one page to print: each push to scale with its number."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from cyclemap.evidence.measured_plan import SURE, MeasuredPlan
from cyclemap.evidence.push_plan.plan_pushes import PushPlan
from cyclemap.evidence.pushes.planned_table import marks_of
from cyclemap.views.sentences import angle, uncertainty_sentence
from cyclemap.views.style import (
    FORCE,
    INK,
    MEASURED_EDGE,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    arrow,
    new_figure,
    picture_style,
    write_page,
)

MM = 1000.0
_COLUMNS = 4
# Inches of a panel, of the labels at its left, of the words above, and of the foot.
_WIDTH, _LEFT, _ABOVE, _BELOW = 3.3, 0.6, 1.35, 0.4
_FOOT = (
    "Filled: the object as it is set, its ring a circle, corners a and b to measure. Dashed: where "
    "it is likely to end. Arrow: the rod's centre, from first touch. Millimetres from the near "
    "left corner of the room."
)


def known_words(known: Mapping[str, float]) -> str:
    """What is known after some pushes: of directions and whether there are any, of the map, or of
    pushes.
    """
    if "wrong" in known:
        where = f", where to ±{angle(2.0 * known['direction'], 0)}" if "direction" in known else ""
        return f"whether it locks in with {1.0 - known['wrong']:.0%} certainty{where}"
    if "map" in known:
        return f"the map within ±{angle(2.0 * known['map'])}"
    return f"a push within ±{2.0 * MM * known['place']:.1f} mm and ±{angle(2.0 * known['turn'])}"


def plan_sentences(plan: PushPlan) -> tuple[str, ...]:
    """How many pushes of what, what they will tell, what any one's loss costs, and what the numbers
    rest on.
    """
    number, name, floor = len(plan.pushes), plan.loop.slider.name, plan.loop.material.name
    after = {one.pushes: one for one in plan.knowledge}
    chosen = after[number]
    asked = {
        "direction": "where the loop locks in, if it does",
        "map": "the cycle map",
        "pushes": "where pushes end",
    }
    read = f"{MM * plan.read[0]:.2g} mm and {math.degrees(plan.read[1]):.2g}°"
    locks = (
        ""
        if plan.chance is None
        else f"Of floors as {floor} has them {plan.chance:.0%} lock it in. "
    )
    return (
        f"{number} pushes of {name} that tell most of {asked[plan.target]}.",
        f"{locks}Known now: {known_words(after[0].planned)}. After these {number}: "
        f"{known_words(chosen.planned)}; after {number} random ones: {known_words(chosen.random)}; "
        f"with one of them lost, at worst: {known_words(plan.without)}.",
        f"Expected, to first order, over {plan.samples} floors as {floor} has them, with readings "
        f"good to {read} and what models miss on real floors; two standard deviations, averaged "
        "where there is a direction.",
    )


def measured_sentences(measured: MeasuredPlan, within: float) -> tuple[str, ...]:
    """Whether what was measured is enough, how well directions are known, and what was read and
    left out.
    """
    chance = measured.directions.chance
    if not measured.is_enough(within):
        told = f"Not yet known to {SURE:.0%} within ±{angle(within, 0)}"
    elif chance >= SURE:
        told = f"Enough: {SURE:.0%} within ±{angle(measured.half_width)}"
    else:
        told = f"Enough: it locks in nowhere, with a chance of {1.0 - chance:.0%}"
    known = uncertainty_sentence(measured.loop.material.name, measured.directions)
    return f"{told}.", known, *(f"data: {note}" for note in measured.notes)


@picture_style()
def plan_page(plan: PushPlan) -> Figure:
    """Draw each push in the room, to scale, with its number, how it is set up, and where it is
    likely to end.
    """
    rows = -(-len(plan.pushes) // _COLUMNS)
    tall = _WIDTH * plan.room[1] / plan.room[0] + 0.75
    height = _ABOVE + _BELOW + rows * tall
    width = _COLUMNS * _WIDTH + 0.2
    figure = new_figure(width, height)
    title, *words = plan_sentences(plan)
    write_page(figure, title, words, _FOOT, top=1.0 - 0.62 / height, letters=185, size=16.0)
    for number in range(len(plan.pushes)):
        row, column = divmod(number, _COLUMNS)
        left = (_LEFT + column * _WIDTH) / width
        bottom = 1.0 - (_ABOVE + (row + 1) * tall - 0.35) / height
        axes = figure.add_axes((left, bottom, (_WIDTH - _LEFT) / width, (tall - 0.75) / height))
        _draw_push(axes, plan, number)
    return figure


def _draw_push(axes: Axes, plan: PushPlan, number: int) -> None:
    planned, slider = plan.pushes[number], plan.loop.slider
    push, start = planned.push, planned.start
    outline = slider.outline_points(120)
    lying = MM * np.array([start.to_world(*point) for point in outline.tolist()])
    x, y, theta = plan.ends[number]
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    ended = MM * (outline @ turn.T + (x, y))
    axes.add_patch(Polygon(lying, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.4))
    axes.add_patch(
        Polygon(ended, fill=False, edgecolor=QUIET, linewidth=1.0, linestyle=(0, (4, 3)))
    )
    first, last = (MM * np.array(place) for place in planned.rod(slider, plan.loop.pusher.radius))
    arrow(axes, first, last, FORCE)
    axes.plot(*first, "o", color=FORCE, markersize=4)
    axes.plot(
        *(MM * np.array(start.to_world(*slider.hitch))), "o", mfc="none", mec=INK, markersize=6
    )
    for name, mark in zip("ab", marks_of(slider), strict=True):
        inner = 0.78 * np.array(mark) + 0.22 * np.array(slider.outline.centroid)
        axes.plot(*(MM * np.array(start.to_world(*mark))), ".", color=MEASURED_EDGE, markersize=6)
        place = MM * np.array(start.to_world(*inner.tolist()))
        axes.text(
            float(place[0]),
            float(place[1]),
            name,
            ha="center",
            va="center",
            color=MEASURED_EDGE,
            fontsize=8,
        )
    axes.set_xlim(0.0, MM * plan.room[0])
    axes.set_ylim(0.0, MM * plan.room[1])
    axes.set_aspect("equal")
    axes.tick_params(labelsize=6)
    slant = f", slanted {math.degrees(push.angle):+.0f}°" if push.angle else ""
    axes.set_title(
        f"{number + 1}: side {push.side} at {push.fraction:.2f}{slant}, {MM * push.distance:.0f} "
        "mm",
        fontsize=8.5,
    )
    axes.set_ylabel("y (mm)", fontsize=7)
    axes.set_xlabel(
        f"x (mm); set to x {MM * start.x:.0f}, y {MM * start.y:.0f} mm, θ "
        f"{math.degrees(start.theta):.0f}°",
        fontsize=8,
    )
