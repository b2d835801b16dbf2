"""Files that appear whole or not at all."""

import os
from pathlib import Path

# What a process killed while writing leaves behind ends so; no reader of data takes it for any.
UNFINISHED_SUFFIX = ".part"


def write_whole(path: Path, content: bytes) -> None:
    """Write `content` to `path` by way of a file beside it; OSError, naming the path, where that cannot be done."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED_SUFFIX}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        cause = f"{error.strerror}: {error.filename}" if error.filename else error.strerror or error
        raise OSError(f"{path} cannot be written ({cause}); nothing was left half-written") from error
