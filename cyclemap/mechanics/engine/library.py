"""Loads the compiled engine."""

import ctypes
from functools import cache
from pathlib import Path

from cyclemap.errors import EngineNotBuilt
from cyclemap.mechanics.engine.sources import is_built, library_path

_BUILD = "in a checkout, `python3 run.py doctor` or `pip install .` (`-e .` to go on editing) builds it anew"


@cache
def load() -> ctypes.CDLL:
    """Return the engine's library; EngineNotBuilt where there is none, or one of other sources than those beside it."""
    library, table, number = open_engine(Path(__file__).parent), ctypes.c_void_p, ctypes.c_int64
    library.cm_run.argtypes, library.cm_run.restype = (*(table,) * 3, number, number, *(table,) * 4), None
    library.cm_record.argtypes, library.cm_record.restype = (table, table, ctypes.c_double, table, number), number
    library.cm_friction.argtypes, library.cm_friction.restype = (table, table, table, number, table), None
    return library


def open_engine(folder: Path) -> ctypes.CDLL:
    """Load the library of the engine in `folder`, unless it is made from other sources than those there."""
    path = library_path(folder)
    if not is_built(folder):
        state = "is not made from the sources beside it" if path.exists() else "is missing"
        raise EngineNotBuilt(f"the compiled engine {path} {state}: {_BUILD}")
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise EngineNotBuilt(f"the compiled engine cannot be loaded ({error}): {_BUILD}") from error
    library.cm_version.restype = ctypes.c_char_p
    return library
