"""What a command has to say against its input: one line each on stderr, and warnings in its JSON, too."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import click

from cyclemap.errors import DoubtfulInput
from cyclemap.plain_text import printable

# Letters of a line: what repeats its input may go on for ever.
_LONGEST = 4000
_told: list[str] = []


def one_line(message: str) -> str:
    """Return a message as one line that a terminal can show."""
    line = printable(" ".join(message.split()))
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def warnings_so_far() -> list[str]:
    """The doubts that this command has told."""
    return list(_told)


@contextmanager
def told_warnings() -> Iterator[None]:
    """Tell each doubt about the input once, as long as the block lasts."""
    _told.clear()

    def show(message: Warning | str, category: type[Warning], *place: object) -> None:
        line = one_line(str(message))
        if line not in _told:
            _told.extend([line] if issubclass(category, DoubtfulInput) else [])
            click.echo(f"warning: {line}", err=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", DoubtfulInput)
        warnings.showwarning = show  # type: ignore[assignment]
        yield
