"""Where in a file something is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cyclemap.errors import DataFileError, InvalidInput


@contextmanager
def located(place: str, kind: type[InvalidInput] = InvalidInput) -> Iterator[None]:
    """Say `place` before what is said of a bad value; raise it as `kind`.

    >>> with located("length_mm = -5"):
    ...     raise InvalidInput("must be positive")
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: length_mm = -5: must be positive
    """
    try:
        yield
    except DataFileError:
        raise
    except InvalidInput as error:
        raise kind(f"{place}: {error}") from error
