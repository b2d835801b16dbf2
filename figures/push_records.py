"""Recorded pushes one by one, for figures that look at their courses: a damaged file is passed over and counted."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cyclemap.errors import DataFileError
from cyclemap.evidence.pushes.mit_names import push_facts
from cyclemap.evidence.pushes.push_files import SUFFIXES, PushRecord, read_push_file


def push_file_names(folder: Path) -> list[Path]:
    """Return the files of a folder that are pushes by name and suffix, sorted; sub-folders are not entered."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and push_facts(path) is not None)


def readable_pushes(files: Iterable[Path]) -> tuple[list[tuple[Path, PushRecord]], int]:
    """Return the pushes that can be read, each with its file, and how many cannot.

    >>> readable_pushes([Path("motion_surface=abs_shape=hex_a=0_v=20_i=0_s=0.7_t=0.h5")])
    ([], 1)
    """
    found, unreadable = [], 0
    for path in files:
        try:
            record = read_push_file(path)
        except DataFileError:
            unreadable += 1
            continue
        assert isinstance(record, PushRecord)
        found.append((path, record))
    return found, unreadable
