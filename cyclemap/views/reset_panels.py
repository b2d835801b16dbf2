"""The panels of a designed reset: laws, runs, maps and cycles before and after, and bias against drag."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from cyclemap.resets.design.reset_curves import DragScene, ResetCurve, ResetCurves
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_ranking import ScoredReset
from cyclemap.views.panel_parts import legend_above
from cyclemap.views.record_panels import PER_DEGREE
from cyclemap.views.style import (
    FORCE,
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    degree_axis,
)

Array = NDArray[np.float64]
MM = 1000.0
# Total variations below this share of the allowance are drawn at it: the axis is logarithmic.
LEAST_SHARE = 0.3
# Points: room for the legend between a panel and its title, and between numbers beside points that crowd.
_TITLE_PAD, _APART, _WIDE, _ASIDE = 20.0, 10.0, 11.0, 12.0
_BEFORE: dict[str, Any] = {"color": MEASURED_EDGE, "linestyle": "--", "linewidth": 1.4}
_AFTER: dict[str, Any] = {"color": PREDICTED, "linestyle": "-", "linewidth": 2.0}


def draw_laws(axes: Axes, curves: ResetCurves) -> None:
    """The stationary densities before and after, and the even one; a peak that is far higher is cut off."""
    theta = np.degrees(curves.theta)
    before, after = (PER_DEGREE * one.density for one in (curves.before, curves.after))
    axes.fill_between(theta, after, color=PREDICTED_FILL, linewidth=0.0, zorder=1)
    axes.plot(theta, before, **_BEFORE, label="as it is", zorder=3)
    axes.plot(theta, after, **_AFTER, label="chosen", zorder=4)
    axes.axhline(1.0 / 360.0, color=INK, linewidth=0.9, linestyle=":", label="even", zorder=2)
    top = min(float(before.max()), 4.0 * max(float(after.max()), 1.0 / 360.0))
    top = 1.08 * max(top, float(after.max()))
    axes.set_ylim(0.0, top)
    if before.max() > top:
        peak = float(theta[int(np.argmax(before))])
        side = "right" if peak > 180.0 else "left"
        axes.annotate(
            f"peak {before.max():.2g}", (peak, top), xytext=(6 if side == "left" else -6, -10),
            textcoords="offset points", ha=side, fontsize=7.5, color=MEASURED_EDGE,
        )  # fmt: skip
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_xticks(range(0, 361, 90))
    axes.set_ylabel("probability per degree")
    axes.set_title("Law of θ0", pad=_TITLE_PAD)
    legend_above(axes)


def draw_runs(axes: Axes, curves: ResetCurves) -> None:
    """One run of each, unwrapped: where it is flat the robot repeats the same push."""
    for one, look, name in ((curves.before, _BEFORE, "as it is"), (curves.after, _AFTER, "chosen")):
        axes.plot(one.path / (2.0 * np.pi), color=look["color"], linestyle=look["linestyle"], linewidth=1.2, label=name)
    axes.set(xlabel="push", ylabel="θ0, not wrapped (turns)", xlim=(0, len(curves.after.path) - 1))
    axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    axes.set_title("Staircase", pad=_TITLE_PAD)
    legend_above(axes)


def draw_maps(axes: Axes, curves: ResetCurves) -> None:
    """The turn of a cycle: one map before, all maps of the law after, the heavier the wider."""
    heaviest = max(weight for _, weight in curves.after.turns)
    widest = 1.6 * min(1.0, 4.0 / len(curves.after.turns))
    for number, (turn, weight) in enumerate(curves.after.turns):
        width = 0.6 + widest * weight / heaviest
        for index, (theta, up) in enumerate(turn.pieces):
            label = "chosen, each of its maps" if number == index == 0 else None
            axes.plot(
                np.degrees(theta), np.degrees(up), color=PREDICTED, linewidth=width, alpha=0.85, label=label, zorder=2
            )
    for index, (theta, up) in enumerate(curves.before.turns[0][0].pieces):
        axes.plot(np.degrees(theta), np.degrees(up), **_BEFORE, label=None if index else "as it is", zorder=3)
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_xticks(range(0, 361, 90))
    axes.set_ylabel("turn of one cycle, f(θ0) - θ0 (°)")
    axes.set_title("Map", pad=_TITLE_PAD)
    legend_above(axes)


def draw_cycles(axes: Axes, curve: ResetCurve, window: float) -> None:
    """Some cycles about the target, to scale: way of the rod in the push, object after it, way of the ring back.

    window : m, half the width of what is shown.
    """
    for scene in curve.scenes:
        _draw_scene(axes, scene, curve.rod_radius)
    axes.add_patch(Circle((0.0, 0.0), MM * curve.reach, fill=False, edgecolor=QUIET, linestyle="-.", linewidth=0.9))
    axes.plot(0.0, 0.0, "+", color=INK, markersize=9, markeredgewidth=1.6, zorder=8)
    axes.set(xlim=(-MM * window, MM * window), ylim=(-MM * window, MM * window), aspect="equal", xlabel="x (mm)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _draw_scene(axes: Axes, scene: DragScene, radius: float) -> None:
    axes.add_patch(
        Polygon(MM * scene.pushed, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.1, alpha=0.6, zorder=1)
    )
    axes.add_patch(Polygon(MM * scene.back, fill=False, edgecolor=QUIET, linewidth=0.7, linestyle="--", zorder=2))
    rod, ring = MM * scene.rod, MM * scene.ring
    axes.plot(*rod.T, color=INK, linewidth=1.0, linestyle=":", zorder=5)
    axes.add_patch(Circle(tuple(rod[-1]), MM * radius, facecolor="white", edgecolor=INK, linewidth=0.9, zorder=6))
    axes.plot(*ring.T, color=FORCE, linewidth=2.0, zorder=7)
    axes.plot(*ring[0], "o", color=FORCE, markersize=4.5, zorder=7)


def draw_trade_off(axes: Axes, design: ResetDesign) -> None:
    """Bias against mean drag of every strategy, by its number in the ranking; the corner where both are allowed."""
    limit = MM * design.demands.drag_ratio * design.own.cost.mean_drag_length
    _draw_allowed(axes, limit, design.demands.allow_tv)
    groups = (
        ("meets all", "o", PREDICTED, [one for one in design.ranking if one.meets]),
        ("misses some", "o", "white", [one for one in design.ranking if one.misses and not one.lacking]),
        ("needs more", "^", MEASURED, [one for one in design.ranking if one.lacking]),
    )
    for label, marker, face, members in groups:
        if members:
            places = np.array([_place(one, design) for one in members])
            axes.plot(
                *places.T, marker, markerfacecolor=face, markeredgecolor=INK, markersize=6, linestyle="none",
                label=label, zorder=4,
            )  # fmt: skip
    front = np.array([_place(one, design) for one in design.front])
    axes.plot(*front.T, color=PREDICTED, linewidth=1.0, drawstyle="steps-post", zorder=3)
    _scale_trade_off(axes, design, limit)
    _number_places(axes, design)


def _draw_allowed(axes: Axes, drag: float, tv: float) -> None:
    for line, level in ((axes.axvline, drag), (axes.axhline, tv)):
        line(level, color=FORCE, linewidth=1.0, linestyle="--", zorder=2)
    axes.fill_between([0.0, drag], 1e-12, tv, color="#f3f3f3", zorder=0)


def _scale_trade_off(axes: Axes, design: ResetDesign, limit: float) -> None:
    drags = [_place(one, design)[0] for one in design.ranking]
    low, high = min(*drags, limit), max(*drags, limit)
    axes.set_xlim(low - 0.12 * (high - low), high + 0.12 * (high - low))
    lowest = LEAST_SHARE * design.demands.allow_tv
    axes.set_yscale("log")
    axes.set_ylim(0.7 * lowest, 1.5)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set(xlabel="mean drag (mm)", ylabel="total variation from uniform")
    axes.set_title("Bias and drag", pad=_TITLE_PAD)
    legend_above(axes)


def _number_places(axes: Axes, design: ResetDesign) -> None:
    """The number of each strategy beside its place, at the nearest spot where it covers neither number nor place."""
    scale = 72.0 / axes.figure.dpi
    points = scale * axes.transData.transform([_place(one, design) for one in design.ranking])
    low, high = scale * axes.get_window_extent().y0, scale * axes.get_window_extent().y1
    taken = [(float(x), float(y)) for x, y in points]
    steps = [0.0, *(sign * k * _APART for k in range(1, 40) for sign in (1.0, -1.0))]
    for number, ((x, y), one) in enumerate(zip(points.tolist(), design.ranking, strict=True), 1):
        spots = [(side, up) for up in steps for side in (_ASIDE, -_ASIDE) if low + 4.0 < y + up < high]
        side, up = next((spot for spot in spots if _is_free(x + spot[0], y + spot[1], taken)), (_ASIDE, 0.0))
        taken.append((x + side, y + up))
        axes.annotate(
            str(number), _place(one, design), xytext=(side, up), textcoords="offset points", fontsize=7.5, ha="center",
            va="center", fontweight="bold" if one in (design.chosen, design.own) else "normal", zorder=5,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": QUIET, "shrinkA": 0, "shrinkB": 2},
        )  # fmt: skip


def _is_free(x: float, y: float, taken: list[tuple[float, float]]) -> bool:
    return not any(abs(x - other) < _WIDE and abs(y - height) < _APART for other, height in taken)


def _place(one: ScoredReset, design: ResetDesign) -> tuple[float, float]:
    least = LEAST_SHARE * design.demands.allow_tv
    return MM * one.cost.mean_drag_length, max(float(one.numbers.tv), least)
