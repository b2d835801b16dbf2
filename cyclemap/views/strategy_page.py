"""What a collection with a strategy records: orientations of a run, their distribution, turns, and where it pushes."""

from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.resets import OrientationLaw, ResetStrategy
from cyclemap.views.map_panels import PER_DEGREE
from cyclemap.views.reset_page import draw_pushes
from cyclemap.views.style import (
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    degree_axis,
    legend_above,
    new_figure,
    picture_style,
)


def strategy_page(
    words: Sequence[str], loop: CollectionLoop, strategy: ResetStrategy, theta: Array, measured: Array | None,
    turns: Array | None = None, law: OrientationLaw | None = None,
) -> Figure:  # fmt: skip
    """Draw one run theta (n + 1,), rad, beside measured orientations; with turns (actions, n) rad and the law, if any.

    words : the title, then what is said below it.
    """
    with picture_style():
        figure = new_figure()
        grid = GridSpec(2, 2, figure, left=0.06, right=0.98, bottom=0.09, top=0.77, wspace=0.18, hspace=0.5)
        path = figure.add_subplot(grid[0, 0])
        if measured is not None:
            path.plot(np.degrees(measured) % 360.0, ".", color=MEASURED, markersize=4, label="measured")
        path.plot(np.degrees(theta) % 360.0, ".", color=PREDICTED, markersize=2, label="predicted")
        path.set(xlabel="cycle", ylabel="θ0 (°)", title="One run", ylim=(0.0, 360.0), yticks=range(0, 361, 90))
        legend_above(path)
        draw_pushes(figure.add_subplot(grid[0, 1]), loop, strategy)
        _draw_shares(figure.add_subplot(grid[1, 0]), theta, measured, law)
        last = figure.add_subplot(grid[1, 1])
        if turns is None:
            last.plot(np.degrees(theta), color=PREDICTED, linewidth=1.2)
            last.set(xlabel="cycle", ylabel="θ0, not wrapped (°)", title="Staircase")
        else:
            _draw_turns(last, turns, strategy)
        figure.text(0.015, 0.955, words[0], fontsize=18, fontweight="bold", va="center")
        figure.text(0.015, 0.928, fill(" ".join(words[1:]), 175), fontsize=10, va="top", linespacing=1.35)
    return figure


def _draw_shares(axes: Axes, theta: Array, measured: Array | None, law: OrientationLaw | None) -> None:
    looks = ((theta, PREDICTED_FILL, "this run"), (measured, MEASURED, "measured"))
    for place, (path, colour, name) in enumerate(looks):
        if path is not None:
            heights, edges = np.histogram(np.degrees(path) % 360.0, np.linspace(0.0, 360.0, 37), density=True)
            axes.stairs(heights, edges, fill=place == 0, color=colour, label=name, linewidth=1.4)
    if law is not None:
        axes.plot(PER_DEGREE * law.density, color=PREDICTED, linewidth=1.8, label="long run")
    axes.axhline(1.0 / 360.0, color=INK, linewidth=1.0, linestyle="--", label="uniform")
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set(ylabel="probability per degree", title="Directions recorded")
    legend_above(axes, columns=4)


def _draw_turns(axes: Axes, turns: Array, strategy: ResetStrategy) -> None:
    theta = np.linspace(0.0, 360.0, turns.shape[1], endpoint=False)
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    for turn, share in zip(np.degrees(turns), strategy.shares.tolist(), strict=True):
        axes.plot(theta, turn, color=PREDICTED, linewidth=0.7 + 1.6 * share)
    axes.plot(theta, np.degrees(strategy.shares @ turns), color=INK, linewidth=1.6, linestyle="--", label="mean")
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set(ylabel="turn of one cycle (°)", title="Turn of each action")
    legend_above(axes)
