"""How far a long computation is: what it reports to, and what its parts do."""

from collections.abc import Callable

# Called with the fraction done, in (0, 1].
Progress = Callable[[float], None]


def part_of(progress: Progress | None, index: float, count: float) -> Progress:
    """Return the function to which part `index` of `count` (from 0) reports the fraction of it
    that is done; to None nothing is reported.

    >>> part_of(print, 1, 4)(0.5)
    0.375
    """
    return lambda fraction: None if progress is None else progress((index + fraction) / count)


def unheard(fraction: float) -> None:
    """Take a report that nobody asked for."""
