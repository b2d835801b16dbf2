"""Pushes one by one: a stream of poses and how it was cut into them, a probe of what goes with
their orientation, recorded ones replayed, an object as it is set up, and a plan to print; in
sentences, and each on a page.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Whole, placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError
from cyclemap.evidence.comparison.replay_push import Replay
from cyclemap.evidence.comparison.replay_table import ReplayedPushes
from cyclemap.evidence.identified_words import MOST_RATIO
from cyclemap.evidence.measured_plan import SURE, MeasuredPlan
from cyclemap.evidence.plan_pushes import PushPlan
from cyclemap.evidence.push_probe import ALARM_RATE, OUTCOMES, Probe
from cyclemap.evidence.tables.planned_table import marks_of
from cyclemap.evidence.tables.pose_streams import Segments
from cyclemap.protocol.own_object import CheckedCollection
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import entitle, grid_of, legend_above, page, rows_of
from cyclemap.views.panels.orientation import CIRCLE, draw_outcome
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
    DOTS,
    EVEN,
    FORCE,
    FOURTH,
    INK,
    LINE,
    MARKS,
    MEASURED_EDGE,
    OPEN,
    PATH,
    PREDICTED,
    PREDICTED_FILL,
    ZERO,
    arrow,
    name_tag,
    picture_style,
    say,
    square_window,
)
from cyclemap.views.sentences import (
    angle,
    chance,
    counted,
    orientation_and_push,
    push_angle,
    uncertainty_sentence,
)

# Samples drawn, and pushes shown: the first ones tell what was taken for what.
_MOST_SAMPLES, _MOST_PUSHES = 4000, 12


@picture_style()
def stream_page(seen: Segments) -> Figure:
    """Draw place and orientation over time, pushes shaded, rests marked below, and what is unclear
    hatched.
    """
    foot = "shaded: pushes; bars: rests; hatched: neither a push nor a drag"
    figure, (above, below) = page("a;b", seen.words, foot=foot, sharex=True)
    pushes, unclear = seen.pushes[:_MOST_PUSHES], seen.unclear[:_MOST_PUSHES]
    ends = [int(seen.rests[end][1]) for _, end in (*pushes, *unclear)]
    last = max(ends, default=min(_MOST_SAMPLES, seen.t.size) - 1)
    every = slice(0, last + 1, max(1, (last + 1) // _MOST_SAMPLES))
    for name, place, look in (("x (mm)", seen.x, LINE), ("y (mm)", seen.y, FOURTH)):
        above.plot(seen.t[every], 1e3 * (place[every] - place[0]), label=name, **look)
    below.plot(seen.t[every], np.degrees(seen.theta[every]), **LINE)
    above.set_ylabel("place from the first (mm)")
    below.set(ylabel="orientation (°)", xlabel="time (s)")
    below.set_xlim(max(0.0, float(seen.t[0])), float(seen.t[last]))
    for axes in (above, below):
        _shade(axes, seen, pushes, color=PREDICTED_FILL, zorder=0)
        _shade(axes, seen, unclear, facecolor="none", edgecolor=FORCE, hatch="//")
    floor = below.get_ylim()[0]
    for first, end in seen.rests:
        if seen.t[first] <= seen.t[last]:
            below.plot(
                seen.t[[first, end]], [floor, floor], color=INK, linewidth=4, solid_capstyle="butt"
            )
    legend_above(above)
    return figure


def _shade(axes: Axes, seen: Segments, spans: Whole, **look: Any) -> None:
    """Shade the times between the rests of each pair."""
    for first, end in spans:
        axes.axvspan(seen.t[seen.rests[first][1]], seen.t[seen.rests[end][0]], **look)


def probe_sentences(probe: Probe) -> tuple[str, ...]:
    """The answer, what was found, the ellipse that does the same, and the lock-in that it would
    cause.
    """
    sizes = {
        name: max(harmonic.amplitude for harmonic in probe.harmonics if harmonic.outcome == name)
        for name in OUTCOMES
    }
    turn = f"±{math.degrees(sizes['dtheta']):.2g}°"
    place = f"±{1e3 * max(sizes['dx'], sizes['dy']):.2g} mm"
    noise = (
        f"noise of one push {1e3 * max(probe.noise[:2]):.2g} mm and "
        f"{math.degrees(probe.noise[2]):.2g}°"
    )
    if not probe.found:
        return (
            f"No sign that pushes depend on their direction, in {probe.theta.size} pushes (p = "
            f"{probe.p_value:.2g}).",
            f"Anisotropy that could hide behind the {noise}: axes up to {probe.ratio.upper:.4g} : "
            "1, "
            f"a centre up to {probe.offset.upper:.2g} of the mean radius off (95 % confidence).",
        )
    depend = (
        f"Pushes depend on direction: by {turn} and {place} (p = {probe.p_value:.2g}, "
        f"{len(probe.theta)} pushes)."
    )
    if probe.ratio.lower > MOST_RATIO:
        return (
            depend,
            f"A friction ellipse would need axes {probe.ratio.value:.3g} : 1, and no floor that "
            "was measured has them beyond 1.7 : 1: this cannot be friction. Look at object, push, "
            "units and --angles of the data.",
        )
    return (
        depend,
        f"A friction ellipse with axes {probe.ratio.value:.4g} : 1 ({probe.ratio.lower:.4g} to "
        f"{probe.ratio.upper:.4g}), longer along {angle(probe.anisotropy.ellipse_direction)}, its "
        f"centre {probe.offset.value:.2g} of the mean radius off ({probe.offset.lower:.2g} to "
        f"{probe.offset.upper:.2g}), explains {probe.explained:.0%} of that; {noise}.",
        _lock_sentence(probe),
    )


def _lock_sentence(probe: Probe) -> str:
    """Where a collection would lock in, how surely, or how far a cycle turns where it would not."""
    collection = "push-and-drag-back collection on such a surface"
    if probe.stable:
        places = []
        for known in probe.stable:
            reach = min(known.upper - known.value, math.pi)
            decimals = int(reach < math.radians(1.0))
            where = orientation_and_push(known.value, probe.loop, decimals)
            places.append(f"{where}, within ±{angle(reach, decimals)}")
        return f"A {collection} locks in at {' and at '.join(places)} (95 % confidence)."
    low, high = (angle(turn) for turn in probe.turns)
    slowest = probe.slowest
    if slowest.lower * slowest.upper > 0.0:
        return f"A {collection} locks in nowhere: a cycle turns it by {low} to {high}."
    least, most = (angle(turn) for turn in (slowest.lower, slowest.upper))
    return (
        f"Whether a {collection} locks in cannot be told: a cycle turns it by {low} to {high}, "
        f"where it is slowest by {least} to {most} (95 % confidence)."
    )


@picture_style()
def probe_page(probe: Probe) -> Figure:
    """Draw each outcome over the orientation, with what the harmonics and the ellipse make of
    it."""
    answer, *words = probe_sentences(probe)
    foot = f"called anisotropy where chance does as much in less than {ALARM_RATE:g} of probes"
    figure, panels = page("abc", answer, words, foot, size=(12.0, 4.8))
    made = probe.mimic.cycles(CIRCLE)
    mimicked = np.column_stack([made.push_displacement, made.push_turn])
    # The mean motion is free in the fit: it is what the object rests on, not the direction.
    mimicked += probe.change.mean(axis=0) - mimicked[:-1].mean(axis=0)
    for column, (axes, outcome) in enumerate(zip(panels, OUTCOMES, strict=True)):
        draw_outcome(
            axes, probe.theta, probe.change[:, column], outcome, {**DOTS, "label": "probed"}
        )
        title, _, scale, _ = orientation.OUTCOMES[outcome]
        values = scale * mimicked[:, column]
        axes.plot(np.degrees(CIRCLE), values, label="the ellipse", **LINE)
        entitle(axes, title)
    return figure


# Courses are drawn of the pushes at these shares of the order of their errors: a good, a usual, a
# bad one.
_SHARES = (0.25, 0.5, 0.75)
_MARKERS = "osD^vP*X<>ph"
# Of motion and turn: the column of errors, titles of both panels, factor and unit.
_WHOLE = {
    "motion": ("error", "Place", "Distance", MM, "mm"),
    "turn": ("turn_error", "Turn", "Turn", math.degrees(1.0), "°"),
}


def replay_headline(replayed: ReplayedPushes) -> str:
    """How many pushes were replayed and how far off they end, in a sentence."""
    error, turn_error = replayed.mean_errors
    count, left_out = len(replayed.table), len(replayed.not_replayed)
    # Of one file several rows may be left out.
    are_files = len({entry.path for entry in replayed.not_replayed}) == left_out
    which = counted(left_out, "file") if are_files else str(left_out)
    also = f"; {which} could not be" if left_out else ""
    ends = "ends" if count == 1 else "they end"
    who = "1 push replayed: it" if count == 1 else f"{count} pushes replayed:"
    return f"{who} {ends} {1e3 * error:.1f} mm and {angle(turn_error)} off on average{also}."


@picture_style()
def replay_page(replayed: ReplayedPushes, material: str) -> Figure:
    """Draw the replays of a collection on `material`; at least one replay is needed."""
    foot = (
        "quasi-static prediction along the recorded tip; poses at the recorded times; a dot a "
        "push, a bar a mean"
    )
    layout, words = rows_of(4, len(_SHARES)), [replay_headline(replayed)]
    figure, panels = page(layout, f"Replayed on {material}", words, foot, keys=2)
    places, distances, turns, angles, *courses = panels
    _draw_whole(places, distances, replayed, "motion")
    _draw_whole(turns, angles, replayed, "turn")
    order = np.argsort(replayed.table["error"].to_numpy(), kind="stable")
    for axes, share in zip(courses, _SHARES, strict=True):
        row = int(order[min(int(share * len(order)), len(order) - 1)])
        _draw_course(axes, replayed.replays[row])
        facts = replayed.table.iloc[row]
        speed = "" if math.isnan(facts["speed"]) else f", {1e3 * facts['speed']:.0f} mm/s"
        off = f"{1e3 * facts['error']:.1f} mm, {angle(abs(facts['turn_error']))}"
        entitle(axes, f"{facts['object']}{speed}: off {off}")
    return figure


def _draw_course(axes: Axes, replay: Replay) -> None:
    """One push seen from above: the object before, and after it as measured and as predicted, with
    its ways.
    """
    before = placed(replay.measured[0], replay.outline)
    draw_way(axes, before, label="before", **EVEN)
    ways = (("measured", replay.measured, PATH), ("predicted", replay.predicted, LINE))
    for name, poses, look in ways:
        draw_way(axes, placed(poses[-1], replay.outline), label=name, **look)
        draw_way(axes, poses[:, :2], **look)
    draw_way(
        axes,
        replay.tip,
        linewidth=1.5,
        label="rod's way",
        color=FORCE,
        marker="o",
        markersize=4.0,
        markevery=[0],
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")


def _draw_whole(errors: Axes, motions: Axes, replayed: ReplayedPushes, name: str) -> None:
    """Errors at the end by object, each push and their mean; predicted over measured motion, a
    marker an object.
    """
    table, kinds = replayed.table, sorted(set(replayed.table["object"]))
    column, title, other, factor, unit = _WHOLE[name]
    off = factor * table[column].abs().to_numpy()
    both = factor * table[[f"measured_{name}", f"predicted_{name}"]].to_numpy()
    motions.axline((0.0, 0.0), slope=1.0, **ZERO)
    for place, kind in enumerate(kinds):
        chosen = (table["object"] == kind).to_numpy()
        error = off[chosen]
        spread = place + 0.5 * (np.arange(error.size) + 0.5) / error.size - 0.25
        marker = _MARKERS[place % len(_MARKERS)]
        errors.plot(spread, error, marker, **MARKS)
        errors.hlines(
            error.mean(), place - 0.36, place + 0.36, color=PREDICTED, linewidth=2.5, zorder=4
        )
        look = {**OPEN, "markeredgecolor": PREDICTED, "markersize": 4.0}
        motions.plot(*both[chosen].T, marker, **look)
    errors.set_xticks(range(len(kinds)), kinds, rotation=30 if len(kinds) > 3 else 0)
    errors.set(xlim=(-0.6, len(kinds) - 0.4), ylim=(0.0, 1.08 * max(float(off.max()), 1e-12)))
    errors.set_ylabel(f"{'turn ' * (name == 'turn')}error ({unit})")
    entitle(errors, f"{title}, off at the end")
    motions.set(xlabel=f"measured {name} ({unit})", ylabel=f"predicted {name} ({unit})")
    entitle(motions, other)


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
    towards = math.degrees(push_angle(loop))
    entitle(axes, f"One cycle from orientation 0°, pushed towards {towards:.4g}°")


_COLUMNS = 4
# Inches of a panel, of the labels beside it, and of the words.
_WIDTH, _BESIDE, _WORDS = 2.6, 1.0, 1.8
_FOOT = (
    "Filled: the object as it is set, its ring a circle, corners a and b to set and to measure. "
    "Dashed: where it is likely to end. Arrow: the rod's centre, from first touch. Millimetres "
    "from the near left corner of the room."
)


def known_sizes(known: Mapping[str, float]) -> dict[str, str]:
    """What is known after some pushes, by what it is of: whether the loop locks in, and where; the
    map; where pushes end.
    """
    sizes = {}
    if "wrong" in known:
        sizes["whether it locks in"] = f"{chance(1.0 - known['wrong'])} sure"
    for name, called in (("direction", "where"), ("map", "map")):
        if name in known:
            sizes[called] = f"±{angle(2.0 * known[name], 0 if name == 'direction' else 1)}"
    if "place" in known:
        sizes["place"] = f"±{2.0 * MM * known['place']:.1f} mm"
        sizes["turn"] = f"±{angle(2.0 * known['turn'])}"
    return sizes


def known_words(known: Mapping[str, float]) -> str:
    """The same in a row of words."""
    return ", ".join(f"{name} {size}" for name, size in known_sizes(known).items())


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
