"""Files that appear whole or not at all, and how they are named."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cyclemap.errors import CycleMapError, InvalidInput

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows has no such locks
    fcntl = None  # type: ignore[assignment]

# What a process killed while writing leaves behind ends so; no reader of data takes it for any.
UNFINISHED_SUFFIX = ".part"


def write_whole(path: Path, content: bytes) -> None:
    """Write `content` to `path` by way of a file beside it; OSError, naming the path, where that cannot be done."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED_SUFFIX}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as file:
                file.write(content)
                file.flush()
                # A name may reach the disk before what it names: power lost between would leave an empty file.
                os.fsync(file.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        cause = f"{error.strerror}: {error.filename}" if error.filename else error.strerror or error
        raise OSError(f"{path} cannot be written ({cause}); nothing was left half-written") from error


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Make `folder` and hold it for this process while the block lasts, however that ends.

    CycleMapError where another process holds it. Windows has no such locks: there nobody is refused.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY) if fcntl is not None else None
    except OSError as error:
        raise OSError(f"{folder} cannot be used ({error.strerror}); choose another folder") from error
    if handle is None:
        yield
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError as error:
        raise CycleMapError(f"{folder} is written by another process; wait for it, or choose another folder") from error
    finally:
        os.close(handle)


def file_stem(name: str) -> str:
    """Return the name of a material or an object as it can stand in a file name; InvalidInput where nothing is left.

    >>> file_stem("worn plywood (side B)")
    'worn_plywood_side_B'
    """
    stem = re.sub(r"[^\w.-]+", "_", name).strip("_.")
    if not stem:
        raise InvalidInput(f"{name!r} can name no file: it needs a letter or a digit")
    return stem
