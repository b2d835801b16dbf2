"""Panels of a strategy: the turns of its actions, how a start is forgotten, where it pushes and how it drags."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, PercentFormatter
from numpy.typing import NDArray

from cyclemap.collection.portrait_curves import TurnCurve
from cyclemap.resets.strategy_portrait_curves import DrawnPush, StrategyCurves
from cyclemap.views.panel_parts import legend_above, name_tag, say
from cyclemap.views.style import FORCE, INK, MEASURED, PREDICTED, PREDICTED_FILL, QUIET, degree_axis

Array = NDArray[np.float64]

# With more pushes than this their shares are not written beside them.
MOST_NAMED = 8
# With more actions than this their lines are thin and let each other through.
_MANY = 16
# Length of the arrows of pushes, mm.
_ARROW_MM = 24.0
_BESIDE_MM = 9.0


def draw_action_turns(axes: Axes, curves: StrategyCurves) -> None:
    """The turn of each action over θ0, the more often the stronger its line, and their mean."""
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    heaviest, many = float(curves.weights.max()), len(curves.turns) > _MANY
    thick, alpha = (0.7, 0.35) if many else (1.5, 1.0)
    for curve, weight in zip(curves.turns, curves.weights.tolist(), strict=True):
        look = {"linewidth": thick * (0.4 + 0.6 * weight / heaviest), "alpha": alpha}
        _draw_turn(axes, curve, look)
    theta, mean = curves.mean
    mean_look: dict[str, Any] = {"color": INK, "linewidth": 1.8, "linestyle": "--", "label": "mean"}
    axes.plot(np.degrees(theta), np.degrees(mean), zorder=4, **mean_look)
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("turn of one cycle (°)")
    axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 3, 4.5, 6, 9, 10]))
    axes.margins(y=0.08)
    # The line of one action among many is too pale for a legend.
    action = Line2D([], [], color=PREDICTED, linewidth=thick, label="each action")
    legend_above(axes, handles=[action, Line2D([], [], **mean_look)])


def _draw_turn(axes: Axes, curve: TurnCurve, look: dict[str, Any]) -> None:
    for theta, turn in curve.pieces:
        axes.plot(np.degrees(theta), np.degrees(turn), color=PREDICTED, zorder=3, **look)
    for jump in curve.jumps:
        place, ends = math.degrees(jump.theta), np.degrees([jump.before, jump.after])
        axes.plot([place, place], ends, color=PREDICTED, linestyle=":", zorder=3, **look)


def draw_forgetting(axes: Axes, curves: StrategyCurves, long_run: float) -> None:
    """The total variation from uniform after each push from the worst start, and where it comes to rest."""
    axes.plot(curves.pushed, curves.farthest, "o-", color=PREDICTED, markersize=3, label="worst start", zorder=3)
    axes.axhline(long_run, color=INK, linewidth=1.2, linestyle="--", label="long run", zorder=2)
    axes.set(xlabel="pushes", ylabel="total variation from uniform", xlim=(0, curves.pushed[-1]), ylim=(0.0, 1.02))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    legend_above(axes)


def draw_orientations(axes: Axes, predicted: Array, measured: Array | None) -> None:
    """θ0 of each push on the circle: unwrapped, a path that turns in every cycle hides where it has been."""
    if measured is not None:
        theta = np.degrees(measured) % 360.0
        axes.plot(theta, ".", color=MEASURED, markersize=4, label="measured", zorder=2)
    axes.plot(np.degrees(predicted) % 360.0, ".", color=PREDICTED, markersize=2, label="predicted", zorder=3)
    axes.set(xlabel="cycle", ylabel="θ0 (°)", xlim=(0, predicted.size - 1), ylim=(0.0, 360.0), yticks=range(0, 361, 90))
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.set_title("Orientations, one run")
    if measured is not None:
        legend_above(axes)


def draw_pushes(axes: Axes, curves: StrategyCurves) -> None:
    """The object with its ring, and the rod's way to it in each push, in the object's frame."""
    axes.fill(*(1e3 * curves.outline.T), facecolor=PREDICTED_FILL, edgecolor=QUIET, linewidth=1.0, zorder=1)
    ring = (1e3 * curves.hitch[0], 1e3 * curves.hitch[1])
    axes.plot(*ring, "o", markersize=6, markerfacecolor="white", color=INK, zorder=2)
    axes.annotate("ring", ring, xytext=(6, 3), textcoords="offset points", fontsize=8)
    heaviest = max(push.weight for push in curves.pushes)
    for push in curves.pushes:
        _draw_push(axes, push, push.weight / heaviest, named=1 < len(curves.pushes) <= MOST_NAMED)
    _frame(axes)


def _draw_push(axes: Axes, push: DrawnPush, share: float, named: bool) -> None:
    (x, y), (dx, dy) = push.start, push.direction
    tip = (1e3 * x, 1e3 * y)
    tail = (tip[0] - _ARROW_MM * dx, tip[1] - _ARROW_MM * dy)
    beyond = (tail[0] - _BESIDE_MM * dx, tail[1] - _BESIDE_MM * dy)
    look = {"arrowstyle": "-|>", "color": FORCE, "linewidth": 0.8 + 1.8 * share, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, tail, arrowprops=look, zorder=3)
    # Annotations do not widen the panel.
    axes.plot([tip[0], beyond[0]], [tip[1], beyond[1]], linestyle="none")
    if named:
        name_tag(axes, *beyond, f"{push.weight:.0%}")


def draw_drags(axes: Axes, curves: StrategyCurves) -> None:
    """The legs of the drag between way-points and to the target, in the world."""
    drawn = [(points, weight) for points, weight in curves.drags if points]
    straight = sum(weight for points, weight in curves.drags if not points)
    for points, _ in drawn:
        legs = 1e3 * np.array([*points, (0.0, 0.0)])
        axes.plot(*legs.T, color=PREDICTED, linewidth=1.0, zorder=2)
        axes.plot(*legs[:-1].T, ".", color=PREDICTED, markersize=5, zorder=3)
    if not drawn:
        axes.set_axis_off()
        say(axes, "the drag goes straight\nto the target")
        return
    axes.plot(0.0, 0.0, "s", color=INK, markersize=6, zorder=4)
    below: dict[str, Any] = {"xytext": (0, -7), "textcoords": "offset points", "ha": "center", "va": "top"}
    axes.annotate("target", (0.0, 0.0), fontsize=8, **below)
    if straight:
        axes.set_xlabel(f"x (mm); {straight:.0%} of the drags go straight to the target")
    _frame(axes)


def _frame(axes: Axes) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.14)
    if not axes.get_xlabel():
        axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5))
