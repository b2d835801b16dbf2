"""Where results go: files that appear whole or not at all, the terminal of people, and a bar for
slow work; and what several commands report of the same things.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from cyclemap.cli.options import ResultOptions, is_quiet, warnings_so_far
from cyclemap.plain_text import printable
from cyclemap.progress import Progress
from cyclemap.text_files import file_stem as file_stem, write_whole
from cyclemap.written import (
    MILLIMETRES,
    Json,
    degrees,
    direction_deg,
    json_of,
    json_text,
    rows,
    written,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cyclemap.collection.loop import CollectionLoop
    from cyclemap.collection.uncertain_directions import DirectionUncertainty
    from cyclemap.evidence import MeasuredStaircase
    from cyclemap.maps import Orbit, StepComparison, Steps
    from cyclemap.mechanics import SidePush
    from cyclemap.resets import ResetStrategy

# What people are told: sentences and tables.
Told = str | Text | Table
PATIENCE_SECONDS = 2.0
LINE_SECONDS = 5.0
BAR_SECONDS = 0.1
# More letters than any table has in a row.
_WIDEST = 10_000
# Of a table wider than this, in letters, columns of words are broken at so many.
_WIDE = 120
_WORDS = 32


def result_name(kind: str, loop: CollectionLoop, surface: str | None = None) -> str:
    """Return the name of results of a kind about a loop, without an ending: by its surface, and by
    its object.

    MIT's square, which the paper is about, goes unsaid.
    surface : in place of the material's name.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.mechanics import Slider
    >>> for shape in ("rect1", "hex"):
    ...     loop = CollectionLoop.mit("pu", slider=Slider.mit(shape))
    ...     print(result_name("portrait", loop))
    portrait_pu
    portrait_hex_on_pu
    """
    from cyclemap.mechanics import Slider  # those that only publish need no mechanics

    name = loop.slider.name
    square = Slider.mit("rect1")
    where = file_stem(loop.material.name if surface is None else surface)
    is_square = (name, loop.slider.outline) == (square.name, square.outline)
    return f"{kind}_{where}" if is_square else f"{kind}_{file_stem(name)}_on_{where}"


def data_stem(data: Path) -> str:
    """The name of a file or folder of data as it can stand in the name of a result, the working
    folder's included.
    """
    return file_stem(data.stem.strip(".") or data.resolve().stem)


def write_json(path: Path, report: Json) -> None:
    """Write `report` as JSON to the file `path`."""
    write_whole(path, _json_bytes(report))


def _json_bytes(report: Json) -> bytes:
    # A path need not be text; JSON has a way to write what is none.
    return _with_doubts(report).encode(errors="backslashreplace")


def _with_doubts(report: Json) -> str:
    """The text of a report, and what was doubted of the input, if anything was."""
    doubts = warnings_so_far()
    return json_text({**report, "warnings": doubts} if doubts else report)


def publish_json(report: Json, target: str | None) -> bool:
    """Send `report` where --json says; True where it took the terminal, which then shows nothing
    else.
    """
    if target == "-":
        click.echo(_with_doubts(report), nl=False)
        return True
    if target is not None:
        write_json(Path(target), report)
    return False


def publish(
    report: Json,
    figure: Figure,
    results: ResultOptions,
    name: str,
    *words: Told,
    after: Sequence[str] = (),
    beside: Mapping[Path, bytes] | None = None,
) -> None:
    """Write NAME.json, the picture and files beside it, and send the report where --json says;
    unless it took the terminal, tell people the rest, where the picture is, and what comes after
    that.
    """
    picture = write_result(report, figure, results, name, beside)
    if not publish_json(report, results.json):
        PeopleConsole().tell(*words, f"picture: {picture}", *after)


def write_result(
    report: Json,
    figure: Figure,
    results: ResultOptions,
    name: str,
    beside: Mapping[Path, bytes] | None = None,
) -> Path:
    """Write NAME.json, the picture and files beside it, and return the picture's path."""
    from cyclemap.views.panels.layout import render

    picture = results.out / f"{name}.{results.format}"
    # All of the content is made before the first file is written.
    files = {**(beside or {}), results.out / f"{name}.json": _json_bytes(report)}
    files[picture] = render(figure, results.format)
    for path, content in files.items():
        write_whole(path, content)
    return picture


def write_page(page: str, place: Path) -> None:
    """Write a page, and tell people where."""
    content = page.encode()
    write_whole(place, content)
    click.echo(f"page: {place} ({len(content) / 1e3:.0f} kB)")


def styled(text: str, style: str) -> Text:
    """Return a sentence to be told in a style."""
    return Text(printable(text), style)


def people_table(
    title: str,
    columns: Iterable[str],
    rows: Iterable[Iterable[str]] = (),
    words: Container[int] = (),
) -> Table:
    """A table whose columns hold numbers, at the right, but for those that hold words."""
    table = Table(title=title, title_justify="left", caption_justify="left")
    for place, column in enumerate(columns):
        table.add_column(column, justify="left" if place in words else "right")
    for row in rows:
        table.add_row(*row)
    return table


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A function to report the fraction done to; work that takes long shows on stderr that it goes
    on.

    A terminal gets a bar with the time left once it takes over two seconds, anything else a line
    every five seconds; nothing is shown with --quiet.
    """
    if is_quiet():
        yield lambda fraction: None
        return
    share = 0.0
    ended = threading.Event()
    begun = time.monotonic()

    def report(fraction: float) -> None:
        nonlocal share
        share = fraction

    def show_bar() -> None:
        if ended.wait(PATIENCE_SECONDS):
            return
        from rich.progress import Progress  # slow to import, and most work is done by now

        with Progress(console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(printable(label), total=None)
            while not ended.wait(BAR_SECONDS):
                bar.update(task, completed=share, total=1.0 if share else None)

    def show_lines() -> None:
        while not ended.wait(LINE_SECONDS):
            spent = time.monotonic() - begun
            done = f"{100.0 * share:.0f} % done, " if share else ""
            left = (
                f", about {spent * (1.0 - share) / share:.0f} s left" if 0.0 < share < 1.0 else ""
            )
            click.echo(f"{printable(label)}: {done}{spent:.0f} s{left}", err=True)

    show = show_bar if sys.stderr.isatty() else show_lines
    shown = threading.Thread(target=show, daemon=True)
    shown.start()
    try:
        yield report
    finally:
        ended.set()
        shown.join()


class PeopleConsole(Console):
    """Standard output without markup or guessed highlights; a reader that goes away is a
    BrokenPipeError.
    """

    def __init__(self) -> None:
        super().__init__(highlight=False, markup=False, soft_wrap=True, quiet=is_quiet())

    def on_broken_pipe(self) -> NoReturn:
        """Raise what plain output would raise, so that the command line answers both alike."""
        raise BrokenPipeError

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text, or a field of a table, as it is shown: names and paths hold what their
        givers like.
        """
        return super().render_str(printable(text), **options)

    def tell(self, headline: Told, *words: Told) -> None:
        """Print a headline, in bold where it is a sentence, and sentences and tables below it; what
        is empty goes unsaid.
        """
        for item in (styled(headline, "bold") if isinstance(headline, str) else headline, *words):
            if isinstance(item, Table):
                self.print_table(item)
            elif item:
                self.print(item)

    def print_table(self, table: Table) -> None:
        """Print a table at its own width; in a terminal too narrow for it, row by row, a line a
        column.

        Squeezed it would lose its numbers, and broken lines are no table.
        """
        before = self.width
        room = self.options.update(width=_WIDEST)
        needed = Measurement.get(self, room, table).maximum
        if needed > _WIDE and table.show_header:
            # Words can be broken, numbers cannot.
            for column in table.columns:
                if column.justify == "left" and not column.no_wrap:
                    column.max_width = min(column.max_width or _WORDS, _WORDS)
                    column.overflow = "fold"
            needed = Measurement.get(self, room, table).maximum
        if self.is_terminal and needed > before:
            if table.title:
                self.print(table.title, style="italic")
            for fields in zip(*(column.cells for column in table.columns), strict=True):
                for column, field in zip(table.columns, fields, strict=True):
                    name = " ".join(str(column.header).split())
                    self.print(f"{name}: {field}" if name else str(field))
                self.print()
            return
        self.width = max(before, needed)
        self.print(table)
        self.width = before


# -- what several commands report


def actions_report(strategy: ResetStrategy, loop: CollectionLoop) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares of the cycles."""
    from cyclemap.views.reset_page import action_words

    return [
        {
            "name": action_words(action),
            "weight": written(share),
            **push_report(acted.push),
            "way_points_mm": [[*map(millimetres, place)] for place in acted.reset.way_points],
            "gripper_turn_deg": degrees(action.turn),
        }
        for action, acted, share in zip(
            strategy.actions, strategy.loops(loop), strategy.shares, strict=True
        )
    ]


def push_report(push: SidePush) -> Json:
    """How the rod pushes."""
    return {
        **json_of(push, "side", "fraction"),
        "angle_deg": degrees(push.angle),
        "push_mm": millimetres(push.distance),
    }


def orbit_report(orbit: Orbit) -> Json:
    """Where a fixed point is, and whether it is stable."""
    return {"theta_deg": orbit_deg(orbit), **json_of(orbit, "multiplier", "stable")}


def orbit_deg(orbit: Orbit) -> float:
    """Where a fixed point is, degrees."""
    return direction_deg(float(orbit.points[0]))


def uncertainty_report(known: DirectionUncertainty) -> Json:
    """How well stable directions are known; `upper_deg` may pass 360. Of no posterior the shares
    are no chances.
    """
    return {
        **json_of(known, "source", "method", "first_order_error", "samples", "locks"),
        "chance_of_lock_in": known.chance if known.is_posterior else None,
        **json_of(known, "directions"),
    }


def steps_report(steps: Steps) -> Json:
    """The dwells and steps of a path."""
    return {
        **json_of(steps, "cycles", "climb"),
        "steps": steps.count,
        "heights_deg": degrees(steps.heights),
        "dwells": rows(
            first_cycle=steps.start,
            cycles=steps.lengths,
            level_deg=degrees(steps.levels),
            censored=steps.censored,
        ),
    }


def measured_report(measured: MeasuredStaircase) -> Json:
    """A measured staircase, and what the map fitted to it predicts."""
    report: Json = {"fitted": None, "problem": measured.problem or None, "comparison": None}
    foretold = measured.foretold
    if foretold is not None:
        report["fitted"] = {
            "harmonics": foretold.fitted.law.harmonics,
            "pairs": foretold.fitted.pairs,
            "noise_deg": degrees(foretold.fitted.sigma),
            **json_of(foretold.prediction),
        }
        report["comparison"] = comparison_report(foretold.comparison)
    return steps_report(measured.steps) | report


def comparison_report(comparison: StepComparison, errors: bool = True) -> Json:
    """Steps and visits measured beside those predicted; of visits also their standard errors where
    asked for.
    """
    means = ("mean", "standard_error") if errors else ("mean",)
    visits = [
        {
            **json_of(visit.zone, "centre"),
            **json_of(visit, "exits", *means, "predicted", "mean_p_value"),
        }
        for visit in comparison.visits
    ]
    return {**json_of(comparison, "net_steps", "expected_steps", "pace_p_value"), "visits": visits}


def millimetres(metres: float) -> float:
    """Return a length that was set in millimetres, in the digits it was set in.

    >>> millimetres(0.01378)
    13.78
    """
    return float(MILLIMETRES.written(metres))
