"""A designed reset, and a strategy whose cycles differ: in sentences, and each on one landscape
page.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from cyclemap.arrays import TWO_PI, Array, even_angles
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence import angle_histogram
from cyclemap.mechanics import SidePush
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.resets import (
    CycleAction,
    MaterialRange,
    OrientationLaw,
    ResetDesign,
    ResetRow,
    ResetStrategy,
)
from cyclemap.views.panels.layout import entitle, new_figure, page, panels_in, write_page
from cyclemap.views.panels.orientation import (
    PER_DEGREE,
    draw_histogram,
    draw_recorded,
    draw_staircase,
    draw_turns,
)
from cyclemap.views.panels.scene import MM, draw_object, draw_ring, number_sides
from cyclemap.views.panels.style import (
    BAND,
    DOTS,
    EVEN,
    FORCE,
    INK,
    LINE,
    LINES,
    MEASURED,
    PREDICTED,
    QUIET,
    SECOND,
    THETA0,
    Look,
    arrow,
    count_axis,
    degree_axis,
    name_tag,
    picture_style,
    whole_turn_ticks,
)
from cyclemap.views.sentences import angle

_PLACES = (0.0, 0.105, 0.535, 0.6, 0.665, 0.745, 0.82, 0.885, 0.95)
_ARROW, _NAMED, _BINS = 0.45, 8, 36


@picture_style()
def reset_page(design: ResetDesign) -> Figure:
    """Draw `design`."""
    figure = new_figure(13.333, 8.2)
    foot = (
        f"total variation from uniform; after: {design.demands.within} pushes from the worst "
        f"start; {histogram_words(design)}; noise {math.degrees(design.sigma):.2g}° a cycle"
    )
    title = f"Reset for {design.loop.material.name}: {recipe(design.chosen.strategy)}"
    low, high = write_page(figure, title, miss_sentences(design)[:1], foot)
    low = _write_rows(figure, design, low)
    pushes, histograms, friction = panels_in(
        figure, "abc", (low, high), width_ratios=(1.0, 1.55, 1.15)
    )
    draw_pushes(pushes, design.loop, design.chosen.strategy)
    _draw_histograms(histograms, design)
    errors = 100.0 * design.ratio_errors
    for values, name, look in zip(design.ratio_tv, ("chosen", "simplest"), LINES, strict=False):
        friction.plot(errors, values, label=name, **look)
    allowed = design.demands.allow_tv
    friction.axhline(allowed, color=FORCE, linewidth=1.1, linestyle=":", label="allowed")
    top = 1.25 * max(float(design.ratio_tv.max()), allowed)
    friction.set(xlim=(errors[0], errors[-1]), ylim=(0.0, top))
    friction.set_xlabel("error in the ratio of the friction's axes (%)")
    friction.set_ylabel("total variation, long run")
    entitle(friction, "Friction in error")
    return figure


def _write_rows(figure: Figure, design: ResetDesign, low: float) -> float:
    """Write the table of the strategies above `low`; return where it ends, shares of the page."""
    rows = [COLUMNS, *(row_cells(row) for row in design.rows)]
    cells = [
        [fill(cell, 82 if place == 1 else 19) for place, cell in enumerate(row)] for row in rows
    ]
    heights = [0.0175 * max(cell.count("\n") + 1 for cell in row) + 0.006 for row in cells]
    y = top = low + sum(heights) + 0.02
    for index, (row, height) in enumerate(zip(cells, heights, strict=True)):
        look: Look = {"fontsize": 8, "linespacing": 1.15, "va": "top"}
        look |= {"color": INK if index else QUIET, "fontweight": "bold" if index == 1 else "normal"}
        for place, cell in zip(_PLACES, row, strict=True):
            figure.text(0.015 + 0.97 * place, y, cell, **look)
        y -= height
    return top


def _draw_histograms(axes: Axes, design: ResetDesign) -> None:
    # Watching and auditing say sentences of this page, and need not wait for that.
    from scipy.stats import binom

    bins, pushes = design.after.shape[1], design.demands.pushes
    edges = np.linspace(0.0, 360.0, bins + 1)
    low, high = binom.ppf([0.025, 0.975], pushes, 1.0 / bins) / pushes
    axes.axhspan(low, high, label="95 % if uniform", **BAND)
    before, after = design.before[0], design.after[0]
    axes.stairs(before, edges, color=MEASURED, linewidth=1.4, label="as it is", zorder=2)
    axes.stairs(after, edges, label="with the reset", **LINE)
    axes.axhline(1.0 / bins, **EVEN)
    top, peak = max(2.2 * high, 1.25 * float(after.max())), int(np.argmax(before))
    axes.set_ylim(0.0, top)
    if before[peak] > top:
        share = f"{before[peak]:.0%}"
        name_tag(axes, edges[peak] + 5.0, 0.93 * top, share, color=MEASURED)
    degree_axis(axes)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_ylabel("share of pushes")
    entitle(axes, f"{pushes} pushes")


def draw_pushes(axes: Axes, loop: CollectionLoop, strategy: ResetStrategy) -> None:
    """The object with its sides numbered and its ring, and the rod's way in each push, with its
    share.
    """
    prepared, outline = strategy.prepared(loop), loop.slider.outline_points()
    draw_object(axes, outline)
    ring = np.array(prepared.slider.hitch)
    draw_ring(axes, ring)
    x, y = (MM * ring).tolist()
    name_tag(axes, x, y, "ring", xytext=(9, 9), textcoords="offset points")
    number_sides(axes, MM * outline, -0.14, fontsize=12, fontweight="bold", color=PREDICTED)
    shares: Counter[SidePush] = Counter()
    for action, share in zip(strategy.actions, strategy.shares.tolist(), strict=True):
        shares[action.push or prepared.push] += share
    length = _ARROW * MM * float(np.ptp(outline, axis=0).max())
    for push, share in shares.items():
        tip, way = first_contact(prepared.slider, push, prepared.pusher.radius)
        tip, beyond = MM * tip, MM * tip - 1.2 * length * way
        width = 1.0 + 2.2 * share
        arrow(axes, tip - length * way, tip, FORCE, width, 3.0, mutation_scale=16)
        axes.plot(*np.array([tip, beyond]).T, linestyle="none")
        if len(shares) <= _NAMED:
            name_tag(axes, beyond[0], beyond[1], f"{share:.0%}", fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.1)
    axes.set_axis_off()
    entitle(axes, "Where to push, object's frame")


@picture_style()
def strategy_page(
    words: Sequence[str],
    loop: CollectionLoop,
    strategy: ResetStrategy,
    theta: Array,
    measured: Array | None,
    turns: Array | None = None,
    law: OrientationLaw | None = None,
) -> Figure:
    """Draw one run theta (n + 1,), rad, beside measured orientations; with turns (actions, n) rad
    and the law, if any.

    words : the title, then what is said below it.
    """
    figure, (path, recorded, pushes, last) = page("ac;bd", words[0], words[1:])
    if measured is not None:
        path.plot(np.degrees(measured) % 360.0, label="measured", **DOTS)
    path.plot(
        np.degrees(theta) % 360.0, ".", color=PREDICTED, markersize=2, label="predicted", zorder=3
    )
    path.set_ylabel(THETA0)
    whole_turn_ticks(path)
    count_axis(path, "cycle", len(theta) - 1)
    entitle(path, "One run")
    draw_pushes(pushes, loop, strategy)
    _draw_recorded(recorded, theta, measured, law)
    entitle(recorded, "Directions recorded")
    if turns is None:
        draw_staircase(last, theta)
        entitle(last, "Staircase")
        return figure
    around = even_angles(turns.shape[1])
    draw_turns(last, around, {"mean": strategy.shares @ turns}, (SECOND,))
    for turn, share in zip(np.degrees(turns), strategy.shares.tolist(), strict=True):
        last.plot(np.degrees(around), turn, color=PREDICTED, linewidth=0.7 + 1.6 * share)
    entitle(last, "Turn of each action")
    return figure


def _draw_recorded(
    axes: Axes, theta: Array, measured: Array | None, law: OrientationLaw | None
) -> None:
    """How often each orientation was recorded in run and data, and is in the long run."""
    shown = None if measured is None else angle_histogram(measured, _BINS)
    draw_recorded(axes, shown)
    look = {**BAND, "linewidth": 1.0, "label": "this run", "fill": True}
    draw_histogram(axes, angle_histogram(theta, _BINS), look)
    if law is not None:
        axes.plot(PER_DEGREE * law.density, label="long run", **LINE)


# More actions or way-points than this are counted, not told one by one.
_MOST_TOLD = 6
_DRAWS = {2: "toss a coin", 4: "toss two coins", 6: "throw a die"}
COLUMNS = (
    "",
    "what to do",
    "long run",
    "at worst",
    "after, worst",
    "histogram",
    "drag",
    "cycle",
    "contact",
)
# What each demand is of, in how many of which units.
_DEMANDS = {
    "tv": ("total variation in the long run", 1.0, ""),
    "after": ("total variation after the pushes allowed", 1.0, ""),
    "drag": ("mean drag", 1e3, " mm"),
    "seconds": ("time of a cycle", 1.0, " s"),
    "reach": ("room about the target", 1e3, " mm"),
    "contact": ("shortest contact", 1e3, " mm"),
}


def action_words(action: CycleAction) -> str:
    """The push, the drag and the gripper's turn of a cycle; what the loop does of itself is left
    out.

    >>> action_words(CycleAction(((0.05, 0.0),), SidePush(side=1, distance=0.08), math.pi / 6))
    'push 80 mm on side 1 at 0.7, drag by 50 mm at 0.0°, gripper 30.0°'
    >>> action_words(CycleAction()), action_words(CycleAction(()))
    ('as the loop does', 'straight drag')
    """
    push, clauses = action.push, []
    if push is not None:
        clauses.append(f"push {1e3 * push.distance:.4g} mm on side {push.side}{_place(push)}")
    if action.way_points is not None:
        places = [
            f"{1e3 * math.hypot(x, y):.4g} mm at {angle(math.atan2(y, x))}"
            for x, y in action.way_points
        ]
        more = f", and {len(places) - _MOST_TOLD} places more" if len(places) > _MOST_TOLD else ""
        clauses.append(
            f"drag by {', then '.join(places[:_MOST_TOLD])}{more}" if places else "straight drag"
        )
    if action.turn:
        clauses.append(f"gripper {angle(action.turn)}")
    return ", ".join(clauses) or "as the loop does"


def _place(push: SidePush) -> str:
    slant = f", {angle(push.angle, 0)} off its normal" if push.angle else ""
    return f" at {push.fraction:.4g}{slant}"


def recipe(strategy: ResetStrategy) -> str:
    """What a robot program has to do, in one sentence.

    >>> recipe(ResetStrategy.pushes(SidePush(), (1, 2)))
    'before every push toss a coin: heads push side 1, tails push side 2, each at 0.7'
    """
    if strategy.hitch is None:
        return _order_words(strategy)
    x, y = (1e3 * coordinate for coordinate in strategy.hitch)
    return f"put the ring at ({x:.1f}, {y:.1f}) mm of the object; {_order_words(strategy)}"


def _order_words(strategy: ResetStrategy) -> str:
    """Which action to take before each push."""
    actions, order = strategy.actions, strategy.order
    words, common = _named(actions)
    if len(actions) == 1:
        is_own = actions[0] == CycleAction()
        return "leave everything as it is" if is_own else f"always {words[0]}{common}"
    if strategy.weights is None and order == "random" and (round_about := _round_about(actions)):
        return f"{round_about}, drawn at random"
    shuffled = f"in shuffled blocks of {sum(strategy.counts)}"
    ordered = {"random": "drawn before every push", "in turn": "in turn"}.get(order, shuffled)
    if len(actions) > _MOST_TOLD:
        return f"take one of {len(actions)} actions, {ordered} (see the protocol file)"
    if order != "random":
        return f"{ordered}: {', '.join(words)}{common}"
    weights = np.array(strategy.weights or (1.0,) * len(words))
    if not np.allclose(weights, weights.round(), rtol=0.0, atol=1e-9):
        shares = [
            f"{share:.1%} {word}"
            for share, word in zip(strategy.shares.tolist(), words, strict=True)
        ]
        return f"before every push draw: {', '.join(shares)}{common}"
    counts, lots = [round(weight) for weight in weights.tolist()], round(weights.sum())
    if counts == [1, 1]:
        return f"before every push toss a coin: heads {words[0]}, tails {words[1]}{common}"
    draws = ", ".join(
        f"{count} of {lots} {word}" for count, word in zip(counts, words, strict=True)
    )
    return f"before every push {_DRAWS.get(lots, f'draw one of {lots} lots')}: {draws}{common}"


def _named(actions: Sequence[CycleAction]) -> tuple[list[str], str]:
    """Each action in words, and what is common to them: pushes of one length go by side and place
    alone.
    """
    pushes = [
        action.push
        for action in actions
        if action.push is not None and action == CycleAction(push=action.push)
    ]
    if len(pushes) < len(actions) or len({push.distance for push in pushes}) > 1:
        return [action_words(action) for action in actions], ""
    if len({(push.fraction, push.angle) for push in pushes}) > 1 or len(pushes) == 1:
        return [f"push side {push.side}{_place(push)}" for push in pushes], ""
    return [f"push side {push.side}" for push in pushes], f", each{_place(pushes[0])}"


def _round_about(actions: Sequence[CycleAction]) -> str:
    """Turns of a gripper, or legs of one length, in all directions, as one; empty where they are
    not these.
    """
    count, step = len(actions), TWO_PI / len(actions)
    ways = [action.way_points or () for action in actions if action.push is None]
    if len(ways) == count and not any(ways):
        by = {2: "a half turn or not", 4: "0, 90, 180 or 270°"}.get(
            count, f"a multiple of {angle(step, 0)}"
        )
        even = np.allclose(
            [action.turn for action in actions], step * np.arange(count), rtol=0.0, atol=1e-9
        )
        return f"after every drag let a gripper turn the object by {by}" if even else ""
    lengths = {round(1e3 * math.hypot(*way[0]), 6) for way in ways if len(way) == 1}
    if (
        [len(way) for way in ways] != [1] * count
        or len(lengths) > 1
        or any(action.turn for action in actions)
    ):
        return ""
    return (
        f"drag back by a place {lengths.pop():.4g} mm off the target, in one of {count} equal "
        "directions"
    )


def design_sentences(design: ResetDesign) -> tuple[str, str, str]:
    """What to do, what that leaves, what it costs."""
    row, own, demands = design.chosen, design.own, design.demands
    left = (
        f"What it leaves {worst_words(design.about)}: {row.worst:.3f} of total variation from "
        f"uniform in the long run, {row.worst_after:.3f} after {demands.within} pushes from the "
        f"worst start, and a histogram of {demands.pushes} pushes {row.worst_histogram[0]:.3f} "
        "from uniform."
    )
    cost = (
        f"What it costs: {1e3 * row.drag:.0f} mm of drag ({row.drag / own.drag:.2f} of now), "
        f"{row.seconds:.1f} s a cycle, {1e3 * row.room:.0f} mm of room about the target, shortest "
        f"contact {1e3 * row.contact:.0f} mm."
    )
    return f"What to do: {recipe(row.strategy)}.", left, cost


def worst_words(about: MaterialRange) -> str:
    """Of what the worst is told.

    >>> from cyclemap.mechanics import load_material
    >>> from cyclemap.resets import material_range
    >>> worst_words(material_range(load_material("pu"))).partition(" (")[0]
    'at most in 95 % of its posterior, with 95 % confidence'
    """
    remark = f" ({about.origin})" if about.origin else ""
    if about.sampled:
        share, confidence = 100.0 * about.share, 100.0 * about.confidence
        return (
            f"at most in {share:.0f} % of its posterior, with {confidence:.0f} % confidence{remark}"
        )
    return (
        f"at the worst of {len(about.materials)} materials{remark}"
        if about.others
        else "on that material alone"
    )


def histogram_words(design: ResetDesign) -> str:
    """What histograms of as many pushes are held against, in 36 bins."""
    measure = (
        f"histogram: mean distance of {design.demands.pushes} pushes in 36 bins, nominal and "
        "at worst"
    )
    steered = design.orders.get("steered")
    seeing = (
        ""
        if steered is None
        else f", the chosen one steered by what is seen (cyclemap watch) {steered:.3f}"
    )
    return f"{measure}; independent uniform ones {design.independent:.3f}{seeing}"


def miss_sentences(design: ResetDesign) -> tuple[str, ...]:
    """Where nothing meets the demands: what the nearest misses, and what any reset considered
    reaches of it.
    """
    if design.met:
        return ()
    missed = ", ".join(_DEMANDS[name][0] for name in design.chosen.misses) or "none by itself"
    misses = [
        f"Nothing that was considered meets all demands. The nearest is told; it misses: {missed}."
    ]
    for limit in design.binding:
        (of, scale, unit), least = (
            _DEMANDS[limit.demand],
            "most" if limit.demand == "contact" else "least",
        )
        misses.append(
            f"The {least} {of} considered is {scale * limit.value:.3g}{unit}: "
            f"{recipe(limit.strategy)}."
        )
    return tuple(misses)


def row_cells(row: ResetRow) -> tuple[str, ...]:
    """A row as words, in the order of `COLUMNS`; a row that misses a demand says so."""
    distances = (row.nominal.total_variation, row.worst, row.worst_after)
    histogram = f"{row.histogram[0]:.3f}, {row.worst_histogram[0]:.3f}"
    costs = f"{1e3 * row.drag:.0f} mm", f"{row.seconds:.1f} s", f"{1e3 * row.contact:.0f} mm"
    roles = ", ".join(row.roles) + (" (misses)" if row.misses else "")
    return (
        roles,
        recipe(row.strategy),
        *(f"{distance:.3f}" for distance in distances),
        histogram,
        *costs,
    )
