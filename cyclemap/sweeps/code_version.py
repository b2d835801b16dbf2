"""Which code found a number: a digest of everything that a portrait's numbers come from."""

import hashlib
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# The rooms below the sweeps, and the one file here that calls them.
_SOURCES = ("mechanics", "maps", "collection", "sweeps/portrait_numbers.py")
_LANGUAGES = (".py", ".c")


@cache
def code_version() -> str:
    """A digest of the mechanics, the maps and the bridge between them; any edit of theirs changes it.

    >>> len(code_version())
    16
    """
    digest = hashlib.sha256()
    for source in _SOURCES:
        root = PACKAGE / source
        for path in _files(root):
            digest.update(path.relative_to(PACKAGE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _files(root: Path) -> list[Path]:
    """The sources in a folder, Python and C, or the one file."""
    if not root.is_dir():
        return [root]
    return sorted(path for path in root.rglob("*") if path.suffix in _LANGUAGES)
