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
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import PercentFormatter

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import SidePush
from cyclemap.mechanics.first_touch import first_contact
from cyclemap.resets import (
    CycleAction,
    MaterialRange,
    OrientationLaw,
    ResetDesign,
    ResetRow,
    ResetStrategy,
)
from cyclemap.views import style
from cyclemap.views.object_page import number_sides
from cyclemap.views.portrait_page import PER_DEGREE
from cyclemap.views.sentences import angle
from cyclemap.views.style import FORCE, INK, MEASURED, PREDICTED, PREDICTED_FILL, QUIET

_PLACES = (0.0, 0.105, 0.535, 0.6, 0.665, 0.745, 0.82, 0.885, 0.95)
_ARROW, _NAMED = 0.45, 8


@style.picture_style()
def reset_page(design: ResetDesign) -> Figure:
    """Draw `design`."""
    figure = style.new_figure()
    grid = GridSpec(
        1,
        3,
        figure,
        width_ratios=(1.0, 1.55, 1.15),
        left=0.03,
        right=0.985,
        bottom=0.43,
        top=0.84,
        wspace=0.25,
    )
    draw_pushes(figure.add_subplot(grid[0, 0]), design.loop, design.chosen.strategy)
    _draw_histograms(figure.add_subplot(grid[0, 1]), design)
    axes = figure.add_subplot(grid[0, 2])
    errors = 100.0 * design.ratio_errors
    looks = (("chosen", PREDICTED, "-"), ("simplest", MEASURED, "--"))
    for values, (name, colour, line) in zip(design.ratio_tv, looks, strict=False):
        axes.plot(errors, values, line, color=colour, linewidth=1.8, label=name)
    axes.axhline(
        design.demands.allow_tv, color=FORCE, linewidth=1.1, linestyle=":", label="allowed"
    )
    top = 1.25 * max(float(design.ratio_tv.max()), design.demands.allow_tv)
    axes.set(
        xlabel="error in the ratio of the friction's axes (%)", ylabel="total variation, long run"
    )
    axes.set(xlim=(errors[0], errors[-1]), ylim=(0.0, top), title="Friction in error")
    axes.legend(loc="upper center", ncols=3)
    lefts, y = [0.015 + 0.97 * place for place in _PLACES], 0.313
    for left, name in zip(lefts, COLUMNS, strict=True):
        figure.text(left, y + 0.012, name, fontsize=8.5, color=QUIET, va="bottom")
    for number, row in enumerate(design.rows):
        cells = [
            fill(cell, (96 if number else 82) if place == 1 else 19)
            for place, cell in enumerate(row_cells(row))
        ]
        weight = "normal" if number else "bold"
        for left, cell in zip(lefts, cells, strict=True):
            figure.text(left, y, cell, fontsize=8, fontweight=weight, va="top", linespacing=1.15)
        y -= 0.0185 * max(cell.count("\n") + 1 for cell in cells) + 0.006
    foot = (
        f"total variation from uniform; after: {design.demands.within} pushes from the worst "
        f"start; {histogram_words(design)}; noise {math.degrees(design.sigma):.2g}° a cycle"
    )
    figure.text(0.015, 0.015, fill(foot, 180), fontsize=8, color=QUIET, va="bottom")
    title = f"Reset for {design.loop.material.name}: {recipe(design.chosen.strategy)}"
    figure.text(
        0.015,
        0.955,
        fill(title, 100),
        fontsize=15,
        fontweight="bold",
        va="center",
        linespacing=1.25,
    )
    if not design.met:
        figure.text(
            0.015,
            0.905,
            fill(miss_sentences(design)[0], 180),
            fontsize=10,
            color=FORCE,
            va="center",
        )
    return figure


def _draw_histograms(axes: Axes, design: ResetDesign) -> None:
    # Watching and auditing say sentences of this page, and need not wait for that.
    from scipy.stats import binom

    bins, pushes = design.after.shape[1], design.demands.pushes
    edges = np.linspace(0.0, 360.0, bins + 1)
    low, high = binom.ppf([0.025, 0.975], pushes, 1.0 / bins) / pushes
    axes.axhspan(low, high, color=PREDICTED_FILL, label="95 % if uniform", zorder=0)
    axes.stairs(design.before[0], edges, color=MEASURED, linewidth=1.4, label="as it is", zorder=2)
    axes.stairs(
        design.after[0], edges, color=PREDICTED, linewidth=1.8, label="with the reset", zorder=3
    )
    axes.axhline(1.0 / bins, color=INK, linewidth=0.9, linestyle="--", zorder=1)
    axes.set_ylim(0.0, max(2.2 * high, 1.25 * float(design.after[0].max())))
    if design.before[0].max() > axes.get_ylim()[1]:
        peak = int(np.argmax(design.before[0]))
        style.name_tag(
            axes,
            edges[peak] + 5.0,
            0.93 * axes.get_ylim()[1],
            f"{design.before[0][peak]:.0%}",
            color=MEASURED,
        )
    style.degree_axis(axes)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set(ylabel="share of pushes", title=f"{pushes} pushes")
    style.legend_above(axes)


def draw_pushes(axes: Axes, loop: CollectionLoop, strategy: ResetStrategy) -> None:
    """The object with its sides numbered and its ring, and the rod's way in each push, with its
    share.
    """
    prepared, outline = strategy.prepared(loop), 1e3 * loop.slider.outline_points()
    size, (x, y) = (
        float(np.ptp(outline, axis=0).max()),
        (1e3 * np.array(prepared.slider.hitch)).tolist(),
    )
    axes.fill(*outline.T, facecolor=PREDICTED_FILL, edgecolor=QUIET, linewidth=1.0, zorder=1)
    axes.plot(x, y, "o", markersize=6, markerfacecolor="white", color=INK, zorder=2)
    style.name_tag(axes, x, y, "ring", xytext=(9, 7), textcoords="offset points")
    number_sides(axes, outline, -0.14, fontsize=12, fontweight="bold", color=PREDICTED)
    shares: Counter[SidePush] = Counter()
    for action, share in zip(strategy.actions, strategy.shares.tolist(), strict=True):
        shares[action.push or prepared.push] += share
    for push, share in shares.items():
        tip, way = first_contact(prepared.slider, push, prepared.pusher.radius)
        tip, tail, beyond = (1e3 * tip - part * size * way for part in (0.0, _ARROW, _ARROW + 0.09))
        look = {
            "arrowstyle": "-|>",
            "color": FORCE,
            "linewidth": 1.0 + 2.2 * share,
            "mutation_scale": 16,
        }
        axes.annotate(
            "", tuple(tip), tuple(tail), arrowprops={**look, "shrinkA": 0, "shrinkB": 0}, zorder=3
        )
        axes.plot(*np.array([tip, beyond]).T, linestyle="none")
        if len(shares) <= _NAMED:
            style.name_tag(axes, beyond[0], beyond[1], f"{share:.0%}", fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.1)
    axes.set_axis_off()
    axes.set_title("Where to push, object's frame")


@style.picture_style()
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
    figure = style.new_figure()
    grid = GridSpec(
        2, 2, figure, left=0.06, right=0.98, bottom=0.09, top=0.77, wspace=0.18, hspace=0.5
    )
    path = figure.add_subplot(grid[0, 0])
    if measured is not None:
        path.plot(np.degrees(measured) % 360.0, ".", color=MEASURED, markersize=4, label="measured")
    path.plot(np.degrees(theta) % 360.0, ".", color=PREDICTED, markersize=2, label="predicted")
    path.set(
        xlabel="cycle",
        ylabel="θ0 (°)",
        title="One run",
        ylim=(0.0, 360.0),
        yticks=range(0, 361, 90),
    )
    style.legend_above(path)
    draw_pushes(figure.add_subplot(grid[0, 1]), loop, strategy)
    axes = figure.add_subplot(grid[1, 0])
    looks = ((theta, PREDICTED_FILL, "this run"), (measured, MEASURED, "measured"))
    for place, (one, colour, name) in enumerate(looks):
        if one is not None:
            heights, edges = np.histogram(
                np.degrees(one) % 360.0, np.linspace(0.0, 360.0, 37), density=True
            )
            axes.stairs(heights, edges, fill=place == 0, color=colour, label=name, linewidth=1.4)
    if law is not None:
        axes.plot(PER_DEGREE * law.density, color=PREDICTED, linewidth=1.8, label="long run")
    axes.axhline(1.0 / 360.0, color=INK, linewidth=1.0, linestyle="--", label="uniform")
    style.degree_axis(axes)
    axes.set(ylabel="probability per degree", title="Directions recorded")
    style.legend_above(axes)
    last = figure.add_subplot(grid[1, 1])
    if turns is None:
        last.plot(np.degrees(theta), color=PREDICTED, linewidth=1.2)
        last.set(xlabel="cycle", ylabel="θ0, not wrapped (°)", title="Staircase")
    else:
        degrees = np.linspace(0.0, 360.0, turns.shape[1], endpoint=False)
        last.axhline(0.0, color=QUIET, linewidth=0.9)
        for turn, share in zip(np.degrees(turns), strategy.shares.tolist(), strict=True):
            last.plot(degrees, turn, color=PREDICTED, linewidth=0.7 + 1.6 * share)
        last.plot(
            degrees,
            np.degrees(strategy.shares @ turns),
            color=INK,
            linewidth=1.6,
            linestyle="--",
            label="mean",
        )
        style.degree_axis(last)
        last.set(ylabel="turn of one cycle (°)", title="Turn of each action")
        style.legend_above(last)
    style.write_page(figure, words[0], words[1:])
    return figure


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
    push, told = action.push, []
    if push is not None:
        told.append(f"push {1e3 * push.distance:.4g} mm on side {push.side}{_place(push)}")
    if action.way_points is not None:
        places = [
            f"{1e3 * math.hypot(x, y):.4g} mm at {angle(math.atan2(y, x))}"
            for x, y in action.way_points
        ]
        more = f", and {len(places) - _MOST_TOLD} places more" if len(places) > _MOST_TOLD else ""
        told.append(
            f"drag by {', then '.join(places[:_MOST_TOLD])}{more}" if places else "straight drag"
        )
    if action.turn:
        told.append(f"gripper {angle(action.turn)}")
    return ", ".join(told) or "as the loop does"


def _place(push: SidePush) -> str:
    slant = f", {angle(push.angle, 0)} off its normal" if push.angle else ""
    return f" at {push.fraction:.4g}{slant}"


def recipe(strategy: ResetStrategy) -> str:
    """What a robot program has to do, in one sentence.

    >>> recipe(ResetStrategy.pushes(SidePush(), (1, 2)))
    'before every push toss a coin: heads push side 1, tails push side 2, each at 0.7'
    """
    ring, actions, order = "", strategy.actions, strategy.order
    if strategy.hitch is not None:
        ring = (
            f"put the ring at ({1e3 * strategy.hitch[0]:.1f}, {1e3 * strategy.hitch[1]:.1f}) "
            "mm of the object; "
        )
    words, common = _named(actions)
    if len(actions) == 1:
        return ring + (
            "leave everything as it is"
            if actions[0] == CycleAction()
            else f"always {words[0]}{common}"
        )
    if strategy.weights is None and order == "random" and (round_about := _round_about(actions)):
        return f"{ring}{round_about}, drawn at random"
    shuffled = f"in shuffled blocks of {sum(strategy.counts)}"
    ordered = {"random": "drawn before every push", "in turn": "in turn"}.get(order, shuffled)
    if len(actions) > _MOST_TOLD:
        return f"{ring}take one of {len(actions)} actions, {ordered} (see the protocol file)"
    if order != "random":
        return f"{ring}{ordered}: {', '.join(words)}{common}"
    parts = np.array(strategy.weights or (1.0,) * len(words))
    if not np.allclose(parts, parts.round(), rtol=0.0, atol=1e-9):
        shares = [
            f"{share:.1%} {word}"
            for share, word in zip(strategy.shares.tolist(), words, strict=True)
        ]
        return f"{ring}before every push draw: {', '.join(shares)}{common}"
    counts, lots = [round(part) for part in parts.tolist()], round(parts.sum())
    if counts == [1, 1]:
        return f"{ring}before every push toss a coin: heads {words[0]}, tails {words[1]}{common}"
    told = ", ".join(f"{count} of {lots} {word}" for count, word in zip(counts, words, strict=True))
    return f"{ring}before every push {_DRAWS.get(lots, f'draw one of {lots} lots')}: {told}{common}"


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
    count, step = len(actions), 2.0 * math.pi / len(actions)
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
    >>> worst_words(material_range(load_material("pu")))
    'at most in 95 % of its posterior, with 95 % confidence (71 of the 200 samples of its posterior)'
    """
    told = f" ({about.told})" if about.told else ""
    if about.sampled:
        share, confidence = 100.0 * about.share, 100.0 * about.confidence
        return (
            f"at most in {share:.0f} % of its posterior, with {confidence:.0f} % confidence{told}"
        )
    return (
        f"at the worst of {len(about.materials)} materials{told}"
        if about.others
        else "on that material alone"
    )


def histogram_words(design: ResetDesign) -> str:
    """What histograms of as many pushes are held against, in 36 bins."""
    told = (
        f"histogram: mean distance of {design.demands.pushes} pushes in 36 bins, nominal and "
        "at worst"
    )
    steered = design.orders.get("steered")
    seeing = (
        ""
        if steered is None
        else f", the chosen one steered by what is seen (cyclemap watch) {steered:.3f}"
    )
    return f"{told}; independent uniform ones {design.independent:.3f}{seeing}"


def miss_sentences(design: ResetDesign) -> tuple[str, ...]:
    """Where nothing meets the demands: what the nearest misses, and what any reset considered
    reaches of it.
    """
    if design.met:
        return ()
    missed = ", ".join(_DEMANDS[name][0] for name in design.chosen.misses) or "none by itself"
    told = [
        f"Nothing that was considered meets all demands. The nearest is told; it misses: {missed}."
    ]
    for limit in design.binding:
        (of, scale, unit), least = (
            _DEMANDS[limit.demand],
            "most" if limit.demand == "contact" else "least",
        )
        told.append(
            f"The {least} {of} considered is {scale * limit.value:.3g}{unit}: "
            f"{recipe(limit.strategy)}."
        )
    return tuple(told)


def row_cells(row: ResetRow) -> tuple[str, ...]:
    """A row as words, in the order of `COLUMNS`; a row that misses a demand says so."""
    numbers = (row.nominal.total_variation, row.worst, row.worst_after)
    histogram = f"{row.histogram[0]:.3f}, {row.worst_histogram[0]:.3f}"
    costs = f"{1e3 * row.drag:.0f} mm", f"{row.seconds:.1f} s", f"{1e3 * row.contact:.0f} mm"
    told = ", ".join(row.roles) + (" (misses)" if row.misses else "")
    return told, recipe(row.strategy), *(f"{number:.3f}" for number in numbers), histogram, *costs
