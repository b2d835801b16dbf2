"""Progress of one of several equal parts of a work, told as progress of the whole."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float], None]


def part_of(progress: Progress | None, number: int, count: int) -> Progress:
    """Return the function to which part `number` of `count` (from 0) reports the fraction of it that is done.

    >>> part_of(print, 1, 4)(0.5)
    0.375
    """

    def told(fraction: float) -> None:
        if progress is not None:
            progress((number + fraction) / count)

    return told
