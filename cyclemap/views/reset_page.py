"""A designed reset on one landscape page: before and after, bias against drag, and the ranking."""

from __future__ import annotations

import math
from textwrap import fill, shorten
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.resets.design.reset_curves import ResetCurves
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_ranking import ScoredReset
from cyclemap.resets.design.reset_trial import ResetTrial
from cyclemap.views.reset_panels import draw_cycles, draw_laws, draw_maps, draw_runs, draw_trade_off
from cyclemap.views.reset_sentences import reset_sentences, trial_sentence
from cyclemap.views.style import FORCE, INK, QUIET, new_figure, picture_style

PAGE_INCHES = (13.333, 8.4)
LINE_LETTERS = 200
_MOST_LINES = 6
_MOST_ROWS = 22
_NAME_LETTERS = 40
# Columns of the ranking: their heads, and their right edges as shares of the width of the panel.
_COLUMNS = (("TV", 0.66), ("after", 0.76), ("drag (mm)", 0.89), ("× own", 0.99))


def reset_page(design: ResetDesign, curves: ResetCurves, trial: ResetTrial | None = None) -> Figure:
    """Draw a design with its curves, and what a run by the full mechanics found."""
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        top = GridSpec(1, 4, figure, left=0.05, right=0.985, bottom=0.535, top=0.76, wspace=0.32)
        for column, draw in enumerate((draw_laws, draw_runs, draw_maps)):
            draw(figure.add_subplot(top[0, column]), curves)
        draw_trade_off(figure.add_subplot(top[0, 3]), design)
        foot = GridSpec(
            1, 3, figure, width_ratios=(1.0, 1.0, 1.55), left=0.05, right=0.985, bottom=0.095, top=0.435, wspace=0.16
        )
        window = 1.04 * max(curves.before.reach, curves.after.reach)
        for column, (curve, name) in enumerate(((curves.before, "as it is"), (curves.after, "chosen"))):
            axes = figure.add_subplot(foot[0, column])
            draw_cycles(axes, curve, window)
            axes.set_title(f"Cycles, {name}")
        figure.axes[-2].set_ylabel("y (mm)")
        _draw_ranking(figure.add_subplot(foot[0, 2]), design)
        _write_words(figure, design, trial)
    return figure


def _draw_ranking(axes: Axes, design: ResetDesign) -> None:
    """The ranking as a list; bold: the chosen one and the loop's own."""
    axes.set_axis_off()
    axes.set_title("Ranking")
    shown = design.ranking[:_MOST_ROWS]
    step = 1.0 / (max(len(shown), 12) + 1.5)
    for head, edge in _COLUMNS:
        axes.text(edge, 1.0, head, ha="right", va="top", fontsize=7.5, color=QUIET, transform=axes.transAxes)
    for number, one in enumerate(shown, 1):
        _write_row(axes, number, one, 1.0 - (number + 0.3) * step, one in (design.chosen, design.own))
    rest = len(design.ranking) - len(shown)
    if rest:
        axes.text(0.0, 0.0, f"and {rest} more", fontsize=7.5, color=QUIET, transform=axes.transAxes)


def _write_row(axes: Axes, number: int, one: ScoredReset, height: float, bold: bool) -> None:
    look: dict[str, Any] = {
        "fontsize": 7.5,
        "fontweight": "bold" if bold else "normal",
        "color": INK if one.meets else QUIET,
        "va": "center",
        "transform": axes.transAxes,
    }
    mark = "✓" if one.meets else "△" if one.lacking else "✗"
    axes.text(0.0, height, f"{number}", ha="left", **look)
    axes.text(0.045, height, mark, ha="left", **{**look, "color": look["color"] if one.meets else FORCE})
    axes.text(0.08, height, shorten(one.name, _NAME_LETTERS, placeholder=" …"), ha="left", **look)
    cells = (
        f"{one.numbers.tv:.3f}",
        f"{one.numbers.tv_after:.3f}",
        f"{1000 * one.cost.mean_drag_length:.0f}",
        f"{one.drag_ratio:.2f}",
    )
    for (_, edge), cell in zip(_COLUMNS, cells, strict=True):
        axes.text(edge, height, cell, ha="right", **look)


def _write_words(figure: Figure, design: ResetDesign, trial: ResetTrial | None) -> None:
    name = design.loop.material.name
    figure.text(0.015, 0.962, f"A reset for {name}", fontsize=18, fontweight="bold", va="center")
    told = [*reset_sentences(design), *([] if trial is None else [trial_sentence(trial)])]
    lines = fill(" ".join(told), LINE_LETTERS, max_lines=_MOST_LINES, placeholder=" …")
    figure.text(0.015, 0.94, lines, fontsize=9.0, va="top", linespacing=1.25)
    sigma = getattr(design.noise, "sigma", math.nan)
    noise = f"noise {math.degrees(sigma):.2g}° a cycle; " if math.isfinite(sigma) else ""
    after = design.demands.within
    foot = (
        f"{noise}“after”: total variation {after} pushes after the worst start  ·  ✓ meets all demands, ✗ misses some, "
        "△ needs what the robot cannot do\ncycles: dotted: way of the rod in the push; thick: way of the ring back; "
        "dash-dotted: room needed"
    )
    figure.text(0.015, 0.01, foot, fontsize=7.5, color=QUIET, linespacing=1.3)
