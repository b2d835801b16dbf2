"""An identified surface on a landscape page: its ellipse, how plates press, data beside predictions, intervals."""

from collections.abc import Callable, Sequence
from functools import partial
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.evidence.identification.identify import Identification
from cyclemap.evidence.identified_curves import IdentifiedCurves
from cyclemap.views.identify_panels import (
    draw_cycles,
    draw_ellipse,
    draw_interval,
    draw_places,
    draw_shares,
    draw_turns,
)
from cyclemap.views.style import QUIET, new_figure, picture_style

PAGE_INCHES = (16.0, 9.6)
LINE_LETTERS = 205
LINE_HEIGHT = 0.0188
TITLE_PAD = 22.0
# Besides the intervals, which take the end of the first row.
MOST_PANELS = 8
# More intervals than fit above each other: those of plates and data sets are then in the tables alone.
MOST_INTERVALS = 13
Panel = tuple[str, Callable[[Axes], None]]


def identify_page(title: str, found: Identification, curves: IdentifiedCurves, words: Sequence[str]) -> Figure:
    """Draw an identification: ellipse, intervals, and a panel for each sort of data, as many as the page takes."""
    panels = _panels(curves)
    if len(found.plates) > 1:
        panels.insert(1, ("How the weight rests", partial(draw_shares, plates=found.plates)))
    with picture_style():
        figure = new_figure(*PAGE_INCHES)
        top = _write_words(figure, title, words, len(panels) - MOST_PANELS)
        rows, columns = _layout(min(len(panels), MOST_PANELS) + 1)
        ends = {"left": 0.05, "right": 0.985, "bottom": 0.085, "top": top - 0.07}
        grid = GridSpec(rows, columns, figure, wspace=0.24, hspace=0.24 + 0.14 * rows, **ends)
        _draw_intervals(figure, grid, found)
        cells = [(row, column) for row in range(rows) for column in range(columns) if (row, column) != (0, columns - 1)]
        for cell, (name, draw) in zip(cells, panels[:MOST_PANELS], strict=False):
            axes = figure.add_subplot(grid[cell])
            draw(axes)
            axes.set_title(name, pad=TITLE_PAD)
    return figure


def _layout(cells: int) -> tuple[int, int]:
    """Rows and columns for so many cells."""
    if cells <= 3:
        return 1, cells
    return (2, 2) if cells == 4 else (-(-cells // 3), 3)


def _panels(curves: IdentifiedCurves) -> list[Panel]:
    panels: list[Panel] = [("Friction ellipse", partial(draw_ellipse, curves=curves))]
    panels += [(f"{_title(fit.name)}: map", partial(draw_cycles, fit=fit)) for fit in curves.cycles]
    panels += [(f"{_title(fit.name)}: turns", partial(draw_turns, fit=fit)) for fit in curves.turns]
    panels += [(f"{_title(fit.name)}: places", partial(draw_places, fit=fit)) for fit in curves.places]
    return panels


def _title(name: str) -> str:
    return name[:1].upper() + name[1:]


def _draw_intervals(figure: Figure, grid: GridSpec, found: Identification) -> None:
    shared = tuple(one for one in found.estimates if "[" not in one.name)
    estimates = found.estimates if len(found.estimates) <= MOST_INTERVALS or not shared else shared
    rows = grid[0, -1].subgridspec(len(estimates), 1, hspace=1.6)
    box = grid[0, -1].get_position(figure)
    whose = "" if len(estimates) == len(found.estimates) else " of all plates"
    heading = f"Parameters{whose}, with {100.0 * found.level:g} % intervals"
    figure.text(box.x0, box.y1 + 0.025, heading, fontsize=10, fontweight="bold")
    for number, one in enumerate(estimates):
        axes = figure.add_subplot(rows[number, 0])
        draw_interval(axes, one)
        place = axes.get_position()
        axes.set_position((place.x0 + 0.42 * place.width, place.y0, 0.58 * place.width, place.height))


def _write_words(figure: Figure, title: str, words: Sequence[str], undrawn: int) -> float:
    """Write title, sentences and foot; returns where the sentences end, as a share of the page's height."""
    figure.text(0.012, 0.968, title, fontsize=13, fontweight="bold", va="center")
    told = fill(" ".join(words), LINE_LETTERS)
    figure.text(0.012, 0.947, told, fontsize=9.5, va="top", linespacing=1.3)
    more = f"; {undrawn} panels more are not drawn" if undrawn > 0 else ""
    foot = f"inferred from data; × at an interval's end: a bound, not excluded by the data{more}"
    figure.text(0.012, 0.012, foot, fontsize=8, color=QUIET)
    return 0.947 - LINE_HEIGHT * (told.count("\n") + 1)
