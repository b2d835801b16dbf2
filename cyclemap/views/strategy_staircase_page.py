"""A staircase climbed with a strategy on one landscape page, beside the measured one where there is one."""

from textwrap import fill

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from numpy.typing import NDArray

from cyclemap.evidence import MeasuredStaircase
from cyclemap.maps import Steps
from cyclemap.resets.strategy_staircase import StrategyStaircase
from cyclemap.views.record_panels import draw_staircase
from cyclemap.views.staircase_sentences import fitted_sentence, measured_sentence
from cyclemap.views.step_panels import draw_step_lengths, draw_steps
from cyclemap.views.strategy_panels import draw_orientations
from cyclemap.views.strategy_sentences import run_sentence, staircase_headline
from cyclemap.views.style import QUIET, new_figure, picture_style

Array = NDArray[np.float64]

PAGE_INCHES = (13.333, 7.5)
LINE_LETTERS = 175


def strategy_staircase_page(found: StrategyStaircase, measured: MeasuredStaircase | None = None) -> Figure:
    """Draw the run, with `measured` beside it where given; dwells are those of the measured path then."""
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        grid = GridSpec(2, 2, figure, left=0.06, right=0.985, bottom=0.115, top=0.78, wspace=0.17, hspace=0.5)
        path = figure.add_subplot(grid[:, 0])
        draw_staircase(path, found.run.theta, None if measured is None else measured.path)
        if measured is not None:
            path.legend(loc="upper left")
        path.set_title("One run" if measured is None else "One run each")
        shown, whose = (found.steps, found.run.theta) if measured is None else (measured.steps, measured.path)
        if shown.levels.size:
            _draw_dwells(figure, grid, shown, whose, "predicted" if measured is None else "measured")
        else:
            orientations = figure.add_subplot(grid[:, 1])
            draw_orientations(orientations, found.run.theta, None if measured is None else measured.path)
        _write_words(figure, found, measured)
    return figure


def _draw_dwells(figure: Figure, grid: GridSpec, steps: Steps, path: Array, whose: str) -> None:
    top, bottom = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    draw_steps(top, path, steps)
    draw_step_lengths(bottom, steps)
    top.set_title(f"Dwells, {whose}")
    bottom.set_title("Lengths")


def _write_words(figure: Figure, found: StrategyStaircase, measured: MeasuredStaircase | None) -> None:
    figure.text(0.015, 0.955, staircase_headline(found), fontsize=18, fontweight="bold", va="center")
    told = [run_sentence(found)]
    if measured is not None:
        told += [measured_sentence(measured), fitted_sentence(measured)]
    figure.text(0.015, 0.915, fill(" ".join(told), LINE_LETTERS), fontsize=10, va="top", linespacing=1.35)
    foot = "dwells are sought in the path alone, without a model"
    figure.text(0.015, 0.02, foot, fontsize=8, color=QUIET)
