"""The terminal that people read: rich output, plain where it must be."""

from typing import NoReturn

from rich.console import Console


class PeopleConsole(Console):
    """Standard output without markup or guessed highlights; a reader that goes away is a BrokenPipeError."""

    def __init__(self) -> None:
        super().__init__(highlight=False, markup=False, soft_wrap=True)

    def on_broken_pipe(self) -> NoReturn:
        """Raise what plain output would raise, so that the command line answers both alike."""
        raise BrokenPipeError
