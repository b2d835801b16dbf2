"""The engine's library: which file it is, what it is made from, and its loading.

The build of the package and run.py read this file by its path: until it loads, it needs nothing but
Python.
"""

import ctypes
import hashlib
import sys
from functools import cache
from pathlib import Path

_SUFFIXES = {"win32": ".dll", "darwin": ".dylib"}
# Python that only calls the engine: all other files of Python and C in this folder are what it is
# made from.
_CALLERS = ("__init__.py", "library.py", "strokes.py")
_BUILD = (
    "in a checkout, `python3 run.py doctor` or `pip install .` (`-e .` to go on editing) builds it "
    "anew"
)


def library_path(folder: Path) -> Path:
    """Return where the library lies in the engine's folder."""
    return folder / f"_engine{_SUFFIXES.get(sys.platform, '.so')}"


def digest_of(folder: Path) -> str | None:
    """Return the digest of what the engine is made from; None in an installed package, which is
    without the C files.
    """
    found = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix in (".c", ".py") and path.name not in _CALLERS
    ]
    if not any(path.suffix == ".c" for path in found):
        return None
    digest = hashlib.sha256()
    for path in found:
        content = path.read_bytes()
        digest.update(f"{path.name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def is_built(folder: Path) -> bool:
    """Whether the library is there and made from the sources beside it, if there are any: it holds
    their digest.
    """
    digest, library = digest_of(folder), library_path(folder)
    return library.exists() and (digest is None or digest.encode() in library.read_bytes())


@cache
def load() -> ctypes.CDLL:
    """Return the engine's library; EngineNotBuilt where there is none, or one of other sources than
    those beside it.
    """
    library, table, number = open_engine(Path(__file__).parent), ctypes.c_void_p, ctypes.c_int64
    library.cm_run.argtypes, library.cm_run.restype = (
        (*(table,) * 3, number, number, *(table,) * 4),
        None,
    )
    library.cm_record.argtypes, library.cm_record.restype = (
        (table, table, ctypes.c_double, table, number),
        number,
    )
    library.cm_friction.argtypes, library.cm_friction.restype = (
        (table, table, table, number, table),
        None,
    )
    return library


def open_engine(folder: Path) -> ctypes.CDLL:
    """Load the library of the engine in `folder`, unless it is made from other sources than those
    there.
    """
    from cyclemap.errors import EngineNotBuilt

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
