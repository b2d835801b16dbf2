"""An object that is set up, and a plan of pushes to print: each to scale on one page, and in
sentences.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError
from cyclemap.evidence.measured_plan import SURE, MeasuredPlan
from cyclemap.evidence.plan_pushes import PushPlan
from cyclemap.evidence.tables.planned_table import marks_of
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.protocol.own_object import CheckedCollection
from cyclemap.views.panels.layout import entitle, grid_of, page
from cyclemap.views.panels.scene import (
    LATER,
    MM,
    draw_object,
    draw_ring,
    draw_setup,
    draw_way,
    mark_target,
)
from cyclemap.views.panels.style import (
    FORCE,
    MEASURED_EDGE,
    PREDICTED,
    arrow,
    name_tag,
    picture_style,
    say,
    square_window,
)
from cyclemap.views.sentences import angle, chance, uncertainty_sentence


@picture_style()
def object_page(checked: CheckedCollection) -> Figure:
    """Draw the set-up in the object's frame, one cycle in the world, and what the check found below
    them.
    """
    loop = checked.loop
    words = [
        f"{'Wrong' if finding.wrong else 'Likely wrong'}: {finding.words}."
        for finding in checked.findings
    ]
    title = f"{'Collection' if loop is None else loop.slider.name}, to scale"
    size = (11.0, 6.4 + 0.2 * len(words))
    figure, (setup, cycle) = page("ab", title, words, size=size, keys=3)
    if loop is not None:
        draw_setup(setup, loop)
        _draw_cycle(cycle, loop)
    return figure


def _draw_cycle(axes: Axes, loop: CollectionLoop) -> None:
    """One cycle from θ0 = 0 in the world, whose origin is the target."""
    try:
        course = loop.cycle(0.0).trajectory
    except CycleMapError:
        axes.axis("off")
        say(axes, "no cycle can be run")
        return
    poses, outline = (course.push.pose[0], *course.drag.pose[[0, -1]]), loop.slider.outline_points()
    before, pushed, dragged = (placed(pose, outline) for pose in poses)
    draw_object(axes, before, label="before the push")
    draw_object(axes, pushed, label="after it", **{**LATER, "edgecolor": PREDICTED})
    draw_object(axes, dragged, label="after the drag back", **{**LATER, "linestyle": "-"})
    draw_way(axes, course.push.pusher, color=FORCE, linewidth=1.6, label="way of the rod")
    arrow(axes, MM * placed(poses[1], np.array(loop.slider.hitch)), np.zeros(2), MEASURED_EDGE)
    axes.plot([], [], color=MEASURED_EDGE, label="way of the ring")
    mark_target(axes)
    square_window(axes, axes.dataLim.get_points())
    axes.set(xlabel="x (mm), world", ylabel="y (mm)")
    way = first_contact(loop.slider, loop.push, loop.pusher.radius)[1]
    towards = math.degrees(math.atan2(way[1], way[0]))
    entitle(axes, f"One cycle from orientation 0°, pushed towards {towards:.4g}°")


_COLUMNS = 4
# Inches of a panel, of the labels beside it, and of the words.
_WIDTH, _BESIDE, _WORDS = 2.6, 1.0, 1.8
_FOOT = (
    "Filled: the object as it is set, its ring a circle, corners a and b to set and to measure. "
    "Dashed: where it is likely to end. Arrow: the rod's centre, from first touch. Millimetres "
    "from the near left corner of the room."
)


def known_parts(known: Mapping[str, float]) -> dict[str, str]:
    """What is known after some pushes, by what it is of: whether the loop locks in, and where; the
    map; where pushes end.
    """
    parts = {}
    if "wrong" in known:
        parts["whether it locks in"] = f"{chance(1.0 - known['wrong'])} sure"
    for name, called in (("direction", "where"), ("map", "map")):
        if name in known:
            parts[called] = f"±{angle(2.0 * known[name], 0 if name == 'direction' else 1)}"
    if "place" in known:
        parts["place"] = f"±{2.0 * MM * known['place']:.1f} mm"
        parts["turn"] = f"±{angle(2.0 * known['turn'])}"
    return parts


def known_words(known: Mapping[str, float]) -> str:
    """The same in a row of words."""
    return ", ".join(f"{name} {size}" for name, size in known_parts(known).items())


def plan_sentences(plan: PushPlan) -> tuple[str, ...]:
    """How many pushes of what, what they will tell, what any one's loss costs, and what the numbers
    rest on.
    """
    planned, name, floor = len(plan.pushes), plan.loop.slider.name, plan.loop.material.name
    after = {step.pushes: step for step in plan.knowledge}
    chosen = after[planned]
    asked = {
        "direction": "where the loop locks in, if it does",
        "map": "the cycle map",
        "pushes": "where pushes end",
    }
    read = f"{MM * plan.read[0]:.2g} mm and {math.degrees(plan.read[1]):.2g}°"
    locks = ""
    if plan.chance is not None:
        count = round(plan.chance * plan.samples)
        lock = "locks" if count < 2 else "lock"
        locks = f"Of {plan.samples} floors as {floor} has them {count or 'none'} {lock} it in. "
    return (
        f"{planned} pushes of {name} that tell most of {asked[plan.target]}.",
        f"{locks}Known now: {known_words(after[0].planned)}. After these {planned}: "
        f"{known_words(chosen.planned)}; after {planned} random ones: "
        f"{known_words(chosen.random)}; "
        f"with one of them lost, at worst: {known_words(plan.without)}.",
        f"Expected, to first order, over {plan.samples} floors as {floor} has them, with readings "
        f"good to {read} and what models miss on real floors; two standard deviations, averaged "
        "where there is a direction.",
    )


def measured_sentences(measured: MeasuredPlan, within: float) -> tuple[str, ...]:
    """Whether what was measured is enough, how well directions are known, and what was read and
    left out.
    """
    locks = measured.directions.chance
    if not measured.is_enough(within):
        verdict = f"Not yet known to {SURE:.0%} within ±{angle(within, 0)}"
    elif locks >= SURE:
        verdict = f"Enough: {SURE:.0%} within ±{angle(measured.half_width)}"
    else:
        verdict = f"Enough: it locks in nowhere, with a chance of {chance(1.0 - locks)}"
    known = uncertainty_sentence(measured.loop.material.name, measured.directions)
    return f"{verdict}.", known, *(f"data: {note}" for note in measured.notes)


@picture_style()
def plan_page(plan: PushPlan) -> Figure:
    """Draw each push in the room, to scale, with its number, how it is set up, and where it is
    likely to end.
    """
    count = len(plan.pushes)
    rows = -(-count // _COLUMNS)
    tall = _WIDTH * plan.room[1] / plan.room[0] + _BESIDE
    size = (_COLUMNS * (_WIDTH + _BESIDE), rows * tall + _WORDS)
    title, *words = plan_sentences(plan)
    figure, panels = page(grid_of(count, _COLUMNS), title, words, _FOOT, size=size)
    for index, axes in enumerate(panels):
        _draw_push(axes, plan, index)
    return figure


def _draw_push(axes: Axes, plan: PushPlan, index: int) -> None:
    planned, slider = plan.pushes[index], plan.loop.slider
    push, start = planned.push, planned.start
    pose = np.array([start.x, start.y, start.theta])
    outline = slider.outline_points(120)
    draw_object(axes, placed(pose, outline))
    draw_object(axes, placed(np.array(plan.ends[index]), outline), **LATER)
    first, last = (MM * np.array(place) for place in planned.rod(slider, plan.loop.pusher.radius))
    arrow(axes, first, last, FORCE)
    axes.plot(*first, "o", color=FORCE, markersize=4)
    draw_ring(axes, placed(pose, np.array(slider.hitch)))
    marks = np.array(marks_of(slider))
    inside = 0.78 * marks + 0.22 * np.array(slider.outline.centroid)
    draw_way(axes, placed(pose, marks), ".", color=MEASURED_EDGE, markersize=6)
    for name, (x, y) in zip("ab", (MM * placed(pose, inside)).tolist(), strict=True):
        name_tag(axes, x, y, name, color=MEASURED_EDGE)
    axes.set(xlim=(0.0, MM * plan.room[0]), ylim=(0.0, MM * plan.room[1]), aspect="equal")
    axes.tick_params(labelsize=6)
    slant = f", slanted {math.degrees(push.angle):+.0f}°" if push.angle else ""
    where = f"side {push.side} at {push.fraction:.2f}{slant}, {MM * push.distance:.0f} mm"
    axes.set_title(f"{index + 1}: {where}", fontsize=8.5)
    axes.set_ylabel("y (mm)", fontsize=7)
    places = (MM * placed(pose, marks)).tolist()
    set_to = "; ".join(
        f"{name} to {x:.0f}, {y:.0f}" for name, (x, y) in zip("ab", places, strict=True)
    )
    axes.set_xlabel(f"x (mm); {set_to}; θ {math.degrees(start.theta):.0f}°", fontsize=8)
