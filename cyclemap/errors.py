"""The errors cyclemap raises: one base, the few kinds a caller may want to tell apart, that of
unknown names, and where a bad value stands.
"""

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class CycleMapError(Exception):
    """Base of every error that cyclemap raises on purpose.

    Examples
    --------
    >>> import cyclemap as cm
    >>> try:
    ...     cm.load_material("plywod")
    ... except cm.CycleMapError as error:
    ...     print(str(error).split("?")[0])
    unknown material 'plywod': did you mean 'plywood'
    """


class InvalidInput(CycleMapError, ValueError):
    """A value that cannot be used: the message names the value and says what to do about it.

    Examples
    --------
    >>> import cyclemap as cm
    >>> try:
    ...     cm.Pusher(radius=-0.005)
    ... except cm.InvalidInput as error:
    ...     print(error)
    pusher radius must not be negative, not -0.005
    """


class DataFileError(InvalidInput):
    """A file that cannot be read as what it should be: the message names the file, the place and
    the mend.

    Examples
    --------
    >>> import cyclemap as cm
    >>> try:
    ...     cm.load_material("no-such-file.toml")
    ... except cm.DataFileError as error:
    ...     print(str(error).split(":")[0])
    no-such-file.toml
    """


class RodInsideObject(InvalidInput):
    """A push whose rod starts inside the object: the message names the place."""


class RodMissesObject(InvalidInput):
    """A push whose rod passes the object by, or stops before it: nothing moves."""


class ConvergenceError(CycleMapError, ArithmeticError):
    """A computation that could not reach its stated tolerance: the message carries the residual.

    Examples
    --------
    >>> import cyclemap as cm
    >>> issubclass(cm.ConvergenceError, cm.CycleMapError)
    True
    """


class TooManySteps(ConvergenceError):
    """A motion so abrupt that its steps are too short for its way: the message says how short, and
    what to do.
    """


class UnsupportedContact(CycleMapError):
    """A motion that leads out of what the model describes, such as a rod that touches two sides at
    once.

    Examples
    --------
    >>> import cyclemap as cm
    >>> issubclass(cm.UnsupportedContact, cm.CycleMapError)
    True
    """


class EngineNotBuilt(CycleMapError):
    """The compiled engine is missing, or made from other sources than those beside it: the message
    says what to do.
    """


class DoubtfulInput(UserWarning):
    """A value that can be used and is likely not meant: the message names the value and what it may
    be.
    """


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InvalidInput:
    """Return the error for a `name` that is not among the `known` ones.

    >>> print(unknown_name("material", "plywod", ["plywood", "abs"]))
    unknown material 'plywod': did you mean 'plywood'? Known: abs, plywood
    """
    names = sorted(known)
    close = difflib.get_close_matches(str(name), names, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return InvalidInput(f"unknown {kind} {name!r}: {hint}Known: {', '.join(names)}")


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
