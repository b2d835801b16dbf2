"""One sentence for every unknown name: what was asked for, what was probably meant, what there is."""

import difflib
from collections.abc import Iterable

from cyclemap.errors import InvalidInput


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InvalidInput:
    """Return the error for a `name` that is not among the `known` ones.

    >>> print(unknown_name("material", "plywod", ["plywood", "abs"]))
    unknown material 'plywod': did you mean 'plywood'? Known: abs, plywood
    """
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return InvalidInput(f"unknown {kind} {name!r}: {hint}Known: {', '.join(names)}")
