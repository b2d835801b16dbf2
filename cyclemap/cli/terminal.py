"""The terminal that people read: rich output, plain where it must be."""

from typing import Any, NoReturn

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from cyclemap.cli.options import is_quiet
from cyclemap.plain_text import printable

# More letters than any table has in a row.
_WIDEST = 10_000


class PeopleConsole(Console):
    """Standard output without markup or guessed highlights; a reader that goes away is a BrokenPipeError."""

    def __init__(self) -> None:
        super().__init__(highlight=False, markup=False, soft_wrap=True, quiet=is_quiet())

    def on_broken_pipe(self) -> NoReturn:
        """Raise what plain output would raise, so that the command line answers both alike."""
        raise BrokenPipeError

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text, or a field of a table, as it is shown: names and paths hold what their givers like."""
        return super().render_str(printable(text), **options)

    def tell(self, headline: str, *sentences: str) -> None:
        """Print a headline in bold, and sentences below it."""
        self.print(headline, style="bold")
        for sentence in sentences:
            self.print(sentence)

    def print_table(self, table: Table) -> None:
        """Print a table at its own width; in a terminal too narrow for it, row by row, a line a column.

        Squeezed it would lose its numbers, and broken lines are no table.
        """
        before, room = self.width, self.options.update(width=_WIDEST)
        needed = Measurement.get(self, room, table).maximum
        if self.is_terminal and needed > before:
            self._print_rows(table)
            return
        self.width = max(before, needed)
        self.print(table)
        self.width = before

    def _print_rows(self, table: Table) -> None:
        if table.title:
            self.print(table.title, style="italic")
        for fields in zip(*(column.cells for column in table.columns), strict=True):
            for column, field in zip(table.columns, fields, strict=True):
                name = " ".join(str(column.header).split())
                self.print(f"{name}: {field}" if name else str(field))
            self.print()
