"""Compiled libraries of one user: found by what they were made from, trusted only if every byte is as written."""

import contextlib
import ctypes
import hashlib
import os
import platform
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import casadi as ca
from platformdirs import user_cache_path

from cyclemap.mechanics.compiled.compiler import FLAGS, NoCompiler, find_compiler
from cyclemap.whole_files import write_whole

# Folder to keep compiled kernels in, instead of the user's cache folder.
CACHE_VARIABLE = "CYCLEMAP_CACHE"

_EXPRESSIONS = Path(__file__).resolve().parents[1]


def cache_folder() -> Path:
    """Return the folder of compiled kernels: CYCLEMAP_CACHE, else `cyclemap` in the user's cache folder."""
    named = os.environ.get(CACHE_VARIABLE)
    try:
        return Path(named).expanduser() if named else user_cache_path("cyclemap", appauthor=False)
    except RuntimeError as error:
        raise NoCompiler(f"there is no folder for compiled kernels ({error}): name one in {CACHE_VARIABLE}") from error


def cached_library(made_from: str, source: Callable[[], str] | None) -> ctypes.CDLL | None:
    """Return the library made from what `made_from` tells, compiling `source` where no sound one is kept.

    Without a source it returns None where that would be needed. Files bear the hash of what they were made from and
    the hash of their own bytes in their names and appear whole, so that processes need not wait for each other and a
    damaged file is passed over. Raises NoCompiler, telling why, where there is no library to be had.
    """
    compiler = find_compiler()
    key = _digest("\n".join((made_from, _own_sources(), compiler.identity, *FLAGS, *_system())).encode())
    folder = cache_folder()
    for path in sorted(folder.glob(f"{key}-*.so")):
        library = _sound(path)
        if library is not None:
            return library
    if source is None:
        return None
    content = compiler.shared_library(source())
    path = folder / f"{key}-{_digest(content)}.so"
    try:
        write_whole(path, content)
    except OSError as error:
        raise NoCompiler(f"the compiled kernels cannot be kept: {error}; set {CACHE_VARIABLE}") from error
    library = _sound(path)
    if library is None:
        raise NoCompiler(f"the compiled kernels in {path} cannot be loaded: is its folder mounted without execution?")
    return library


def _sound(path: Path) -> ctypes.CDLL | None:
    """Load a library whose bytes are those that its name tells; one that is damaged is removed."""
    try:
        if _digest(path.read_bytes()) == path.stem.split("-")[1]:
            return ctypes.CDLL(str(path))
    except OSError:
        return None
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:32]


def _system() -> tuple[str, ...]:
    return str(ca.__version__), sys.platform, platform.machine(), platform.libc_ver()[1]


@lru_cache(maxsize=1)
def _own_sources() -> str:
    """Hash of the files that write the kernels: what they write is not written again to be found."""
    files = sorted(
        [*_EXPRESSIONS.glob("*.py"), *_EXPRESSIONS.glob("compiled/*.py"), *_EXPRESSIONS.glob("compiled/*.c")]
    )
    return _digest(b"".join(path.name.encode() + path.read_bytes() for path in files))
