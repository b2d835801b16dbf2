"""Pushes one by one: a stream of poses and how it was cut into them, a probe of what goes with
their orientation, and recorded ones replayed; in sentences, and each on a landscape page.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Whole, placed
from cyclemap.evidence.comparison.replay_push import Replay
from cyclemap.evidence.comparison.replay_table import ReplayedPushes
from cyclemap.evidence.identified_words import MOST_RATIO
from cyclemap.evidence.push_probe import ALARM_RATE, OUTCOMES, Probe
from cyclemap.evidence.tables.pose_streams import Segments
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import entitle, legend_above, page, rows_of
from cyclemap.views.panels.orientation import CIRCLE, draw_outcome
from cyclemap.views.panels.scene import MM, draw_way
from cyclemap.views.panels.style import (
    EVEN,
    FORCE,
    FOURTH,
    INK,
    LINE,
    MARKS,
    OPEN,
    PATH,
    PREDICTED,
    PREDICTED_FILL,
    ZERO,
    picture_style,
)
from cyclemap.views.sentences import angle, counted, orientation_and_push

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
    if probe.stable:
        where = " and at ".join(orientation_and_push(theta, probe.loop) for theta in probe.stable)
        locks = f"at {where}"
    else:
        low, high = (angle(turn) for turn in probe.turns)
        locks = f"nowhere: a cycle turns it by {low} to {high}"
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
        f"A push-and-drag-back collection on such a surface locks in {locks}.",
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
        draw_outcome(axes, probe.theta, probe.change[:, column], outcome, label="probed")
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
    also = f"; {counted(left_out, 'file')} could not be" if left_out else ""
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
