"""A predicted staircase on one landscape page, beside the measured one where there is one."""

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.collection.staircase_forecast import StaircaseForecast
from cyclemap.evidence import MeasuredStaircase
from cyclemap.views.record_panels import draw_staircase
from cyclemap.views.sentences import uncertainty_sentence
from cyclemap.views.staircase_sentences import (
    fitted_sentence,
    forecast_sentence,
    measured_sentence,
    run_sentence,
    worn_sentence,
)
from cyclemap.views.step_panels import draw_step_lengths, draw_steps
from cyclemap.views.style import INK, QUIET, new_figure, picture_style

PAGE_INCHES = (13.333, 7.5)
LINE_LETTERS = 175


def staircase_page(forecast: StaircaseForecast, measured: MeasuredStaircase | None = None) -> Figure:
    """Draw `forecast`, with `measured` beside it where given."""
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        grid = GridSpec(
            2, 2, figure, width_ratios=(1.0, 1.0), left=0.06, right=0.985, bottom=0.115, top=0.755, wspace=0.17,
            hspace=0.5,
        )  # fmt: skip
        _draw_paths(figure.add_subplot(grid[:, 0]), forecast, measured)
        steps, lengths = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
        _draw_found(steps, lengths, forecast, measured)
        _write_words(figure, forecast, measured)
    return figure


def _draw_paths(axes: Axes, forecast: StaircaseForecast, measured: MeasuredStaircase | None) -> None:
    if measured is not None:
        fitted = np.degrees(measured.run.theta)
        axes.plot(
            fitted,
            color=INK,
            linewidth=1.0,
            linestyle="--",
            label="map fitted to all data alike, without wear",
            zorder=4,
        )
    draw_staircase(axes, forecast.run.theta, None if measured is None else measured.path)
    if measured is not None:
        axes.legend(loc="upper left")
    axes.set_title("One run" if measured is None else "One run each")


def _draw_found(steps: Axes, lengths: Axes, forecast: StaircaseForecast, measured: MeasuredStaircase | None) -> None:
    if measured is None:
        draw_steps(steps, forecast.run.theta, forecast.steps)
        draw_step_lengths(lengths, forecast.steps, forecast.comparison)
    else:
        draw_steps(steps, measured.path, measured.steps)
        draw_step_lengths(lengths, measured.steps, measured.comparison)
    whose = "predicted" if measured is None else "measured"
    steps.set_title(f"Dwells, {whose}")
    # Above the legend, whose words may be long.
    lengths.set_title("Lengths", pad=22.0)


def _write_words(figure: Figure, forecast: StaircaseForecast, measured: MeasuredStaircase | None) -> None:
    name = forecast.loop.material.name
    figure.text(0.015, 0.955, f"Staircase of {name}", fontsize=18, fontweight="bold", va="center")
    told = [forecast_sentence(forecast), worn_sentence(forecast), run_sentence(forecast)]
    told += [uncertainty_sentence(name, forecast.uncertainty)]
    if measured is not None:
        told += [measured_sentence(measured), fitted_sentence(measured)]
    figure.text(0.015, 0.928, fill(" ".join(filter(None, told)), LINE_LETTERS), fontsize=10, va="top", linespacing=1.35)
    foot = f"cycle map from {forecast.map.samples} computed cycles; dwells found in the path alone, without a model"
    figure.text(0.015, 0.02, foot, fontsize=8, color=QUIET)
