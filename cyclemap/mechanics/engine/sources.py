"""Which library the engine is compiled into, and what it is made from.

The build of the package and run.py read this file by its path: it needs nothing but Python.
"""

import hashlib
import sys
from pathlib import Path

_SUFFIXES = {"win32": ".dll", "darwin": ".dylib"}
# Python that only calls the engine: all other files of Python and C in this folder are what it is made from.
_CALLERS = ("__init__.py", "library.py", "sources.py", "strokes.py")


def library_path(folder: Path) -> Path:
    """Return where the library lies in the engine's folder."""
    return folder / f"_engine{_SUFFIXES.get(sys.platform, '.so')}"


def digest_of(folder: Path) -> str | None:
    """Return the digest of what the engine is made from; None in an installed package, which is without the C files."""
    found = [path for path in sorted(folder.iterdir()) if path.suffix in (".c", ".py") and path.name not in _CALLERS]
    if not any(path.suffix == ".c" for path in found):
        return None
    digest = hashlib.sha256()
    for path in found:
        content = path.read_bytes()
        digest.update(f"{path.name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def is_built(folder: Path) -> bool:
    """Whether the library is there and made from the sources beside it, if there are any: it holds their digest."""
    digest, library = digest_of(folder), library_path(folder)
    return library.exists() and (digest is None or digest.encode() in library.read_bytes())
