"""What was fitted to one set of pushes on a landscape page: laws, histograms, cycle map, staircase."""

from collections.abc import Callable
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.measured_cycle_map import MeasuredCycleMap
from cyclemap.evidence.tables.set_fit import MotionLaw, SetFit, TurnHistogram
from cyclemap.views.fit_panels import (
    draw_directions,
    draw_law,
    draw_pace,
    draw_turn_histogram,
    draw_worn_staircase,
    draw_worn_turns,
)
from cyclemap.views.fit_sentences import SIGNS, set_sentences
from cyclemap.views.style import QUIET, new_figure, picture_style

PAGE_INCHES = (16.0, 9.6)
LINE_LETTERS = 205
# Shares of the page's height: a line of words, what lies below the panels, and titles and labels of a row.
LINE_HEIGHT, FOOT, TITLES, LABELS = 0.0188, 0.03, 0.075, 0.06
# Points between a panel and its title: two rows of a legend.
TITLE_PAD = 31.0
Panel = tuple[str, Callable[[Axes], None]]


def fit_page(fit: SetFit) -> Figure:
    """Draw what was fitted to a set: a row of its pushes, a row of its cycle map, or as much of them as there is.

    Raises InvalidInput where nothing was fitted.
    """
    rows = [row for row in (_push_row(fit), _map_row(fit.cycle_map)) if row]
    if not rows:
        raise InvalidInput(f"nothing was fitted to {fit.pushes.name}: {fit.laws.problem or fit.map_problem}")
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        top = _write_words(figure, fit)
        shared = _shared_out(rows)
        height = (top - FOOT) / len(shared)
        for number, row in enumerate(shared):
            _draw_row(figure, row, top - number * height, height)
    return figure


def _push_row(fit: SetFit) -> list[Panel]:
    panels: list[Panel] = [(SIGNS[law.quantity], _law_drawer(law)) for law in fit.laws.laws if law.law is not None]
    if fit.histogram is not None:
        panels.append(("Histogram of Δθ", _histogram_drawer(fit.histogram)))
    return panels


def _map_row(found: MeasuredCycleMap | None) -> list[Panel]:
    if found is None:
        return []
    panels: list[Panel] = [("Cycle map", lambda axes: draw_worn_turns(axes, found))]
    forecast = found.forecast
    if forecast is not None:
        panels.append(("Directions", lambda axes: draw_directions(axes, forecast)))
        panels.append(("Staircase", lambda axes: draw_worn_staircase(axes, forecast)))
        if forecast.pace.measured.size:
            panels.append(("Turns", lambda axes: draw_pace(axes, forecast.pace)))
    return panels


def _law_drawer(law: MotionLaw) -> Callable[[Axes], None]:
    return lambda axes: draw_law(axes, law)


def _histogram_drawer(histogram: TurnHistogram) -> Callable[[Axes], None]:
    return lambda axes: draw_turn_histogram(axes, histogram)


def _shared_out(rows: list[list[Panel]]) -> list[list[Panel]]:
    """Two rows at most; a single row of several panels is split in two."""
    if len(rows) == 1 and len(rows[0]) > 2:
        half = (len(rows[0]) + 1) // 2
        return [rows[0][:half], rows[0][half:]]
    return rows


def _draw_row(figure: Figure, row: list[Panel], top: float, height: float) -> None:
    """Draw panels side by side in this part of the page, with room for titles above and labels below them."""
    ends = {"top": top - TITLES, "bottom": top - height + LABELS, "left": 0.045, "right": 0.985}
    grid = GridSpec(1, len(row), figure, wspace=0.27 if len(row) > 2 else 0.16, **ends)
    for column, (title, draw) in enumerate(row):
        axes = figure.add_subplot(grid[0, column])
        draw(axes)
        axes.set_title(title, pad=TITLE_PAD)


def _write_words(figure: Figure, fit: SetFit) -> float:
    """Write title, sentences and foot; returns where the sentences end, as a share of the page's height."""
    figure.text(0.012, 0.968, f"Fitted to {fit.pushes.name}", fontsize=18, fontweight="bold", va="center")
    told = fill(" ".join(set_sentences(fit)), LINE_LETTERS)
    figure.text(0.012, 0.947, told, fontsize=9.5, va="top", linespacing=1.3)
    foot = (
        "laws are Fourier series of θ0, their order by cross-validation over blocks of successive pushes unless given"
    )
    figure.text(0.012, 0.012, foot, fontsize=8, color=QUIET)
    return 0.947 - LINE_HEIGHT * (told.count("\n") + 1)
