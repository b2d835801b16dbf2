"""Where results go: files that appear whole or not at all, the terminal of people, and a bar for
slow work.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from cyclemap.cli.json_report import json_text
from cyclemap.cli.options import ResultOptions, is_quiet, warnings_so_far
from cyclemap.plain_text import printable
from cyclemap.progress import Progress
from cyclemap.text_files import file_stem as file_stem, write_whole
from cyclemap.written import Json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cyclemap.collection.loop import CollectionLoop

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


def result_stem(out: Path, kind: str, loop: CollectionLoop, surface: str | None = None) -> Path:
    """Return where results of a kind about a loop go, without an ending: named by its surface, and
    by its object.

    MIT's square, which the paper is about, goes unsaid.
    surface : in place of the material's name.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.mechanics import Slider
    >>> for shape in ("rect1", "hex"):
    ...     loop = CollectionLoop.mit("pu", slider=Slider.mit(shape))
    ...     print(result_stem(Path(), "portrait", loop))
    portrait_pu
    portrait_hex_on_pu
    """
    from cyclemap.mechanics import Slider  # those that only publish need no mechanics

    name = loop.slider.name
    square = Slider.mit("rect1")
    where = file_stem(loop.material.name if surface is None else surface)
    is_square = (name, loop.slider.outline) == (square.name, square.outline)
    return out / (f"{kind}_{where}" if is_square else f"{kind}_{file_stem(name)}_on_{where}")


def write_json(path: Path, report: Json) -> None:
    """Write `report` as JSON to the file `path`."""
    # A path need not be text; JSON has a way to write what is none.
    write_whole(path, json_text(_with_doubts(report)).encode(errors="backslashreplace"))


def _with_doubts(report: Json) -> Json:
    """The report, and what was doubted of the input, if anything was."""
    doubts = warnings_so_far()
    return {**report, "warnings": doubts} if doubts else report


def publish_json(report: Json, target: str | None) -> bool:
    """Send `report` where --json says; True where it took the terminal, which then shows nothing
    else.
    """
    if target == "-":
        click.echo(json_text(_with_doubts(report)), nl=False)
        return True
    if target is not None:
        write_json(Path(target), report)
    return False


def publish(
    report: Json,
    figure: Figure,
    stem: Path,
    results: ResultOptions,
    *words: Told,
    after: Sequence[str] = (),
) -> None:
    """Write stem.json and the picture beside it, and send the report where --json says; unless it
    took the terminal, tell people the rest, where the picture is, and what comes after that.
    """
    picture = write_result(report, figure, stem, results.format)
    if not publish_json(report, results.json):
        PeopleConsole().tell(*words, f"picture: {picture}", *after)


def write_result(report: Json, figure: Figure, stem: Path, picture_format: str) -> Path:
    """Write stem.json and the picture beside it, and return the picture's path."""
    from cyclemap.views.panels.layout import render

    write_json(stem.with_name(f"{stem.name}.json"), report)
    picture = stem.with_name(f"{stem.name}.{picture_format}")
    write_whole(picture, render(figure, picture_format))
    return picture


def write_page(page: str, stem: Path) -> Path:
    """Write a page as stem.html, tell people where, and return that."""
    place = stem.with_name(f"{stem.name}.html")
    content = page.encode()
    write_whole(place, content)
    click.echo(f"page: {place} ({len(content) / 1e3:.0f} kB)")
    return place


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
