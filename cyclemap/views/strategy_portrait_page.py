"""The portrait of a collection with a strategy on one landscape page."""

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.evidence import MeasuredOverlay
from cyclemap.resets.strategy_portrait import StrategyPortrait
from cyclemap.resets.strategy_portrait_curves import StrategyCurves
from cyclemap.views import strategy_sentences as sentences
from cyclemap.views.panel_parts import legend_above
from cyclemap.views.record_panels import PER_DEGREE, draw_measured_histogram
from cyclemap.views.sentences import material_line
from cyclemap.views.strategy_panels import (
    draw_action_turns,
    draw_drags,
    draw_forgetting,
    draw_orientations,
    draw_pushes,
)
from cyclemap.views.style import INK, PREDICTED, PREDICTED_FILL, QUIET, degree_axis, new_figure, picture_style

PAGE_INCHES = (13.333, 7.5)
LINE_LETTERS = 175


def strategy_portrait_page(
    portrait: StrategyPortrait, curves: StrategyCurves, measured: MeasuredOverlay | None = None
) -> Figure:
    """Draw `portrait`, whose curves are `curves`, with the measured directions and path over it where given."""
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        grid = GridSpec(
            2, 3, figure, width_ratios=(4.6, 3.3, 2.6), left=0.055, right=0.985, bottom=0.145, top=0.79,
            wspace=0.24, hspace=0.46,
        )  # fmt: skip
        panels = [figure.add_subplot(grid[row, column]) for column in range(3) for row in range(2)]
        turn, density, forgetting, orientations, pushes, drags = panels
        draw_action_turns(turn, curves)
        turn.set_title("Turn of one cycle, each action")
        _draw_density(density, curves, measured)
        draw_forgetting(forgetting, curves, float(portrait.scores.total_variation))
        forgetting.set_title("A start forgotten")
        path = None if measured is None else measured.pairs.path
        draw_orientations(orientations, portrait.staircase.theta, path)
        draw_pushes(pushes, curves)
        pushes.set_title("Pushes, object's frame")
        draw_drags(drags, curves)
        drags.set_title("Drags, world")
        _write_words(figure, portrait, curves)
    return figure


def _draw_density(axes: Axes, curves: StrategyCurves, measured: MeasuredOverlay | None) -> None:
    theta, density = np.degrees(curves.density_theta), PER_DEGREE * curves.density
    axes.fill_between(theta, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta, density, color=PREDICTED, linewidth=1.8, label="predicted", zorder=3)
    axes.axhline(1.0 / 360.0, color=INK, linewidth=1.0, linestyle="--", label="uniform", zorder=4)
    if measured is not None:
        draw_measured_histogram(axes, measured.histogram)
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("probability per degree")
    axes.set_ylim(bottom=0.0)
    axes.set_title("Directions recorded")
    legend_above(axes)


def _write_words(figure: Figure, portrait: StrategyPortrait, curves: StrategyCurves) -> None:
    figure.text(0.015, 0.955, sentences.portrait_headline(portrait), fontsize=18, fontweight="bold", va="center")
    told = (
        sentences.law_sentence(portrait),
        sentences.memory_sentence(portrait),
        sentences.mean_turn_sentence(portrait),
    )
    figure.text(0.015, 0.928, fill(" ".join(told), LINE_LETTERS), fontsize=10, va="top", linespacing=1.35)
    strategy = "; ".join(filter(None, (sentences.strategy_line(portrait.maps), sentences.gripper_words(curves))))
    foot = [strategy, sentences.accuracy_line(portrait), material_line(portrait.maps.loop.material)]
    figure.text(0.015, 0.06, "\n".join(filter(None, foot)), fontsize=8, color=QUIET, va="top", linespacing=1.35)
