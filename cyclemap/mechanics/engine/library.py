"""The engine's library: which file it is, what it is made from, and its loading.

The build of the package and run.py read this file by its path: until it loads, it needs nothing but
Python.
"""

import ctypes
import hashlib
import struct
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
    sources = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix in (".c", ".py") and path.name not in _CALLERS
    ]
    if not any(path.suffix == ".c" for path in sources):
        return None
    digest = hashlib.sha256()
    for path in sources:
        content = path.read_bytes()
        digest.update(f"{path.name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def is_built(folder: Path) -> bool:
    """Whether the library is there, whole, and made from the sources beside it, if any are."""
    return _flaw(folder) is None


def _flaw(folder: Path) -> str | None:
    """What is wrong with the library, as the rest of a sentence about it; None where nothing is."""
    digest, library = digest_of(folder), library_path(folder)
    if not library.exists():
        return "is missing"
    content = library.read_bytes()
    if not _is_whole(content):
        return "is cut short"
    if digest is None or digest.encode() in content:
        return None
    return "is not made from the sources beside it"


def _is_whole(content: bytes) -> bool:
    """Whether a library goes on to its end, where compilers put the table of its sections.

    Linux maps what is not there, and kills the process that comes to it; other systems look.
    """
    if content[:4] != b"\x7fELF":
        return True
    long_words, order = content[4:5] == b"\x02", "<" if content[5:6] == b"\x01" else ">"
    header = struct.Struct(f"{order}{'QI6H' if long_words else 'II6H'}")
    begin = 40 if long_words else 32
    if len(content) < begin + header.size:
        return False
    sections, _, *_, size, count, _ = header.unpack_from(content, begin)
    return bool(sections + count * size <= len(content))


@cache
def load() -> ctypes.CDLL:
    """Return the engine's library; EngineNotBuilt where there is none that may be used."""
    library, table, whole = open_engine(Path(__file__).parent), ctypes.c_void_p, ctypes.c_int64
    library.cm_run.argtypes = (*(table,) * 3, whole, whole, *(table,) * 4)
    library.cm_run.restype = None
    library.cm_record.argtypes = (table, table, ctypes.c_double, table, whole)
    library.cm_record.restype = whole
    library.cm_friction.argtypes = (table, ctypes.c_double, table, table, whole, table)
    library.cm_friction.restype = None
    library.cm_balance.argtypes = (table, table)
    library.cm_balance.restype = whole
    library.cm_press.argtypes = (table, ctypes.c_double, table)
    library.cm_press.restype = None
    return library


def open_engine(folder: Path) -> ctypes.CDLL:
    """Load the library of the engine in `folder`; EngineNotBuilt unless it `is_built`."""
    from cyclemap.errors import EngineNotBuilt

    path = library_path(folder)
    if flaw := _flaw(folder):
        raise EngineNotBuilt(f"the compiled engine {path} {flaw}: {_BUILD}")
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise EngineNotBuilt(f"the compiled engine cannot be loaded ({error}): {_BUILD}") from error
    library.cm_version.restype = ctypes.c_char_p
    return library
