"""A watched collection on one landscape page: θ0 push by push, the evidence, the directions, what it is worth."""

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from cyclemap.resets.monitor.bias_monitor import WatchedCourse
from cyclemap.views.sentences import angle
from cyclemap.views.style import (
    FORCE,
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    QUIET,
    new_figure,
    picture_style,
)
from cyclemap.views.watch_sentences import watch_sentences

PAGE_INCHES = (13.333, 7.5)
LINE_LETTERS = 175
_DECADES = (0, 1, 2, 3, 10, 30, 100, 300, 1000)


def watch_page(course: WatchedCourse, name: str) -> Figure:
    """Draw the course of a watched collection; ``name`` : of its file."""
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        grid = GridSpec(
            2, 2, figure, width_ratios=(1.9, 1.0), left=0.06, right=0.975, bottom=0.115, top=0.8, wspace=0.16,
            hspace=0.45,
        )  # fmt: skip
        draw_path(figure.add_subplot(grid[0, 0]), course)
        _draw_evidence(figure.add_subplot(grid[1, 0]), course)
        draw_rose(figure.add_subplot(grid[0, 1], projection="polar"), course)
        draw_worth(figure.add_subplot(grid[1, 1]), course)
        _write_words(figure, course, name)
    return figure


def draw_path(axes: Axes, course: WatchedCourse) -> None:
    """Draw the orientations push by push, and the alarm."""
    axes.plot(
        _pushes(course),
        np.degrees(course.theta),
        ".",
        color=MEASURED_EDGE,
        markersize=_dot_size(course.pushes),
        zorder=2,
    )
    alarm = course.report.alarm
    if alarm is not None:
        for direction in alarm.directions:
            axes.axhline(np.degrees(direction), color=FORCE, linewidth=1.0, linestyle="--", zorder=1)
        label = f"alarm at push {alarm.push}, towards {', '.join(angle(theta) for theta in alarm.directions)}"
        axes.axvline(alarm.push, color=FORCE, linewidth=1.6, label=label, zorder=3)
        _legend_above(axes)
    axes.set(ylabel="θ0, orientation before the push (°)", ylim=(0.0, 360.0), yticks=range(0, 361, 90))
    axes.set_title("Orientations")
    _push_axis(axes, course)


def _draw_evidence(axes: Axes, course: WatchedCourse) -> None:
    axes.plot(_pushes(course), course.rest_evidence, color=PREDICTED, linewidth=1.8, label="of a rest")
    axes.plot(
        _pushes(course),
        course.visit_evidence,
        color=MEASURED,
        linewidth=1.8,
        linestyle="-.",
        label="of visits gathering",
    )
    threshold = course.report.threshold
    axes.axhline(threshold, color=FORCE, linewidth=1.2, linestyle="--", label=f"alarm, rate {course.alarm_rate:g}")
    if course.report.alarm is not None:
        axes.axvline(course.report.alarm.push, color=FORCE, linewidth=1.6)
    _scale_evidence(axes, course)
    axes.set_ylabel("evidence against no bias")
    axes.set_title("Evidence")
    _legend_above(axes)
    _push_axis(axes, course)


def _scale_evidence(axes: Axes, course: WatchedCourse) -> None:
    """Powers of ten: even steps up to the third, then narrower ones, for evidence may pass any bound."""
    highest = max(course.rest_evidence.max(), course.visit_evidence.max(), 2.0 * course.report.threshold)
    lowest = min(course.rest_evidence.min(), course.visit_evidence.min(), -0.5)
    axes.set_yscale("symlog", linthresh=3.0)
    axes.set_ylim(1.1 * lowest, 1.3 * highest)
    axes.yaxis.set_major_locator(FixedLocator([power for power in _DECADES if power <= 1.3 * highest]))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda power, _: f"$10^{{{power:.0f}}}$"))


def draw_rose(axes: Axes, course: WatchedCourse) -> None:
    """The histogram of directions with equal areas for equal counts: radii are roots of densities."""
    histogram, aim = course.histogram, course.report.advice.direction
    radii = np.sqrt(histogram.density * 2 * np.pi)
    axes.bar(
        histogram.edges[:-1], radii, width=np.diff(histogram.edges), align="edge", color=MEASURED,
        edgecolor=MEASURED_EDGE, linewidth=0.6,
    )  # fmt: skip
    around = np.linspace(0.0, 2 * np.pi, 181)
    axes.plot(around, np.ones_like(around), color=QUIET, linewidth=0.9, linestyle=":", label="spread evenly")
    top = 1.12 * max(float(radii.max()), 1.2)
    label = f"least covered: {angle(aim, 0)}"
    axes.plot([aim], [top], "v", markersize=9, color=PREDICTED, clip_on=False, label=label)
    axes.set_ylim(0.0, top)
    axes.set_yticklabels([])
    axes.set_xticks(np.radians(range(0, 360, 45)))
    axes.tick_params(axis="x", pad=1)
    axes.grid(color="#ececec")
    axes.set_title("Directions recorded", loc="left", x=-0.62, y=1.0)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.75, 0.12))


def draw_worth(axes: Axes, course: WatchedCourse) -> None:
    """Draw what the pushes recorded so far are worth."""
    pushes = np.arange(1, course.pushes + 1)
    axes.plot([0, course.pushes], [0, course.pushes], color=QUIET, linewidth=0.9, linestyle=":", label="spread evenly")
    axes.plot(pushes, course.effective_pushes, color=INK, linewidth=1.8, label="recorded")
    axes.set(xlabel="pushes recorded", ylabel="worth, in pushes spread evenly", xlim=(0, max(course.pushes, 1)))
    axes.set_ylim(bottom=0.0)
    axes.set_title("What the pushes are worth")
    axes.legend(loc="upper left")
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))


def _pushes(course: WatchedCourse) -> NDArray[np.int64]:
    return np.arange(course.pushes)


def _push_axis(axes: Axes, course: WatchedCourse) -> None:
    axes.set_xlabel("push")
    axes.set_xlim(-0.5, max(course.pushes, 2) - 0.5)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True))


def _dot_size(pushes: int) -> float:
    """Points: a few dots must be seen, many must not run into each other."""
    return float(np.clip(90.0 / pushes, 2.5, 9.0))


def _legend_above(axes: Axes) -> None:
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.3)


def _write_words(figure: Figure, course: WatchedCourse, name: str) -> None:
    title = "locks in" if course.report.alarm is not None else "no sign of locking in"
    figure.text(0.015, 0.955, f"{name}: {title}", fontsize=18, fontweight="bold", va="center")
    told = fill(" ".join(watch_sentences(course)), LINE_LETTERS)
    figure.text(0.015, 0.928, told, fontsize=10, va="top", linespacing=1.35)
    foot = (
        f"chance of an alarm, however long the collection, where no orientation lingers: {course.alarm_rate:g} at most"
    )
    figure.text(0.015, 0.02, foot, fontsize=8, color=QUIET)
