"""Pictures of a reset over a range of materials, and as a surface wears."""

from __future__ import annotations

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import MaxNLocator

from cyclemap.resets.robust.design_under_wear import ResetUnderWear
from cyclemap.resets.robust.robust_reset import RobustReset
from cyclemap.resets.robust.worst_case import WorstCase
from cyclemap.views.panel_parts import legend_above
from cyclemap.views.robust_sentences import coordinate_words, robust_sentences, wear_sentence
from cyclemap.views.style import (
    FORCE,
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    new_figure,
    picture_style,
)

ROBUST_INCHES, WEAR_INCHES = (13.333, 5.2), (10.0, 5.0)
_ROBUST_LETTERS, _WEAR_LETTERS = 190, 140
_MOST_BINS = 16
_TV = "total variation from uniform"


def robust_page(robust: RobustReset, other: tuple[str, WorstCase] | None = None) -> Figure:
    """Draw the total variations over the sampled materials: how many have which, and how they depend on the range."""
    names = [name for name in robust.check.sample.names if name != "phi"]
    with picture_style():
        figure = new_figure(*ROBUST_INCHES)
        columns = 1 + len(names)
        grid = GridSpec(1, columns, figure, left=0.055, right=0.985, bottom=0.115, top=0.67, wspace=0.24)
        top = 1.08 * max(_values(robust).max(), robust.check.allowance.total_variation)
        _draw_distribution(figure.add_subplot(grid[0, 0]), robust, top)
        for column, name in enumerate(names, 1):
            _draw_coordinate(figure.add_subplot(grid[0, column]), robust, name, top)
        _write(figure, f"A reset for a range about {robust.materials.material.name}", robust_sentences(robust, other),
               _ROBUST_LETTERS)  # fmt: skip
    return figure


def wear_page(course: ResetUnderWear, allow_tv: float, name: str) -> Figure:
    """Draw the total variation push by push: as if the wear stopped there, and of the law. name : of the surface."""
    with picture_style():
        figure = new_figure(*WEAR_INCHES)
        axes = figure.add_axes((0.085, 0.12, 0.89, 0.6))
        places, frozen = course.frozen_course()
        pushes = np.arange(1, course.pushes)
        axes.plot(
            pushes, course.variation, color=MEASURED, linewidth=1.3, linestyle="--", label="θ0 at that push", zorder=4
        )
        axes.plot(places, frozen, color=PREDICTED, linewidth=2.0, label="as if the wear stopped there")
        axes.axhline(allow_tv, color=FORCE, linewidth=1.2, linestyle=":", label="allowed")
        left = course.leaves(allow_tv)
        if left is not None:
            axes.plot(
                left, course.frozen_variation(left), "o", color=FORCE, markersize=7, label=f"push {left}", zorder=5
            )
        # The start is a certain orientation: its law is as far from uniform as can be, and off the scale.
        axes.set(xlim=(0, course.pushes), ylim=(0.0, 1.15 * max(2.0 * allow_tv, float(frozen.max()))))
        axes.set(xlabel="push", ylabel=_TV)
        legend_above(axes, columns=4)
        _write(figure, f"The reset as {name} wears", (wear_sentence(course, allow_tv, name),), _WEAR_LETTERS)
    return figure


def _draw_distribution(axes: Axes, robust: RobustReset, top: float) -> None:
    """A histogram over the drawn materials, lying on its side so that the axis is that of the other panels."""
    check = robust.check
    drawn = _values(robust)[check.sample.chosen :]
    bins = min(_MOST_BINS, max(5, drawn.size // 12))
    edges = np.linspace(drawn.min(), max(drawn.max(), drawn.min() + 1e-6), bins + 1)
    axes.hist(drawn, edges.tolist(), orientation="horizontal", color=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=0.8)
    _draw_levels(axes, robust)
    axes.set(ylim=(0.0, top), xlabel="materials drawn", ylabel=_TV)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.set_title("Materials", pad=20.0)


def _draw_coordinate(axes: Axes, robust: RobustReset, name: str, top: float) -> None:
    change, values, chosen = 100.0 * robust.changes(name), _values(robust), robust.check.sample.chosen
    axes.plot(change[chosen:], values[chosen:], ".", color=PREDICTED, markersize=4.5, label="drawn", zorder=2)
    axes.plot(
        change[1:chosen], values[1:chosen], "s", markerfacecolor=MEASURED, markeredgecolor=INK, markersize=5.5,
        markeredgewidth=0.7, label="corner", zorder=3,
    )  # fmt: skip
    axes.plot(change[:1], values[:1], "*", markerfacecolor="white", markeredgecolor=INK, markersize=12, label="nominal",
              linestyle="none", zorder=4)  # fmt: skip
    _draw_levels(axes, robust)
    axes.set(ylim=(0.0, top), xlabel=f"{coordinate_words(name)} off nominal (%)")
    axes.set_title(coordinate_words(name)[:1].upper() + coordinate_words(name)[1:], pad=20.0)
    axes.tick_params(labelleft=False)
    legend_above(axes)


def _draw_levels(axes: Axes, robust: RobustReset) -> None:
    axes.axhline(robust.check.allowance.total_variation, color=FORCE, linewidth=1.3, linestyle="--", zorder=1)


def _values(robust: RobustReset) -> np.ndarray:
    return robust.check.column("total_variation")


def _write(figure: Figure, title: str, sentences: tuple[str, ...], letters: int) -> None:
    figure.text(0.012, 0.945, title, fontsize=16, fontweight="bold", va="center")
    told = fill(" ".join(sentences), letters, max_lines=5, placeholder=" …")
    figure.text(0.012, 0.905, told, fontsize=9.0, va="top", linespacing=1.25)
    if len(figure.axes) > 1:
        figure.text(0.012, 0.012, "dashed: allowed", fontsize=7.5, color=QUIET)
