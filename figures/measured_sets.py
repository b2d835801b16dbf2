"""The repeated pushes that the user's folder holds of each material, and what a caption says where
it holds none.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.errors import DataFileError
from cyclemap.evidence import PushSet, Theta0Pairs, load_pushes, push_sets, read_theta0_pairs
from cyclemap.evidence.data_blocks.force_blocks import SCAN_FIELDS
from cyclemap.evidence.laws.push_sets import FEWEST
from cyclemap.evidence.pushes.mit_names import push_facts, scan_facts
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.recordings import PushRecord
from cyclemap.evidence.tables.data_kinds import SUFFIXES
from cyclemap.views.sentences import listed

from .catalogue import NO_DATA, THETA0_FILE, MeasuredFolder

if TYPE_CHECKING:
    import pandas

# The paper's repeated pushes, as the names of the MIT files say it; SI units and radians.
OBJECT = "rect1"
PROTOCOL = {"acceleration": 0.0, "speed": 0.02, "side": 0.0, "fraction": 0.7, "angle": 0.0}
# The material whose θ0 are at hand in a file of their own.
THETA0_SURFACE = "plywood"


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """A measured set of the paper's repeated pushes.

    unreadable : files in its folder that could not be read.
    """

    pushes: PushSet
    unreadable: int


def measured_run(measured: MeasuredFolder, surface: str) -> MeasuredRun | None:
    """Return the set of ``surface`` with the most pushes in the folder, in the MIT layout; None
    where there is none.

    Looked for in all sub-folders by the names of the files,
    ``motion_surface=SURFACE_shape=rect1_..._rep=NNNN`` with the paper's protocol (``PROTOCOL``); at
    least 20 of them, in one folder, make a set.
    """
    found = None if measured.path is None else _run_below(measured.path, surface)
    if measured.path is not None and found is not None:
        # One who watches the folder so knows what was used.
        measured.find(found.pushes.source.relative_to(measured.path).as_posix())
    return found


def measured_theta0(measured: MeasuredFolder, surface: str) -> Theta0Pairs | None:
    """Return the measured θ0 of ``surface`` in order: of its set, else for plywood of its own file;
    None without.
    """
    found = measured_run(measured, surface)
    if found is not None and found.pushes.pairs is not None:
        return found.pushes.pairs
    file = measured.find(THETA0_FILE) if surface == THETA0_SURFACE else None
    return None if file is None else read_theta0_pairs(file)


def measured_scans(measured: MeasuredFolder, surface: str) -> pandas.DataFrame | None:
    """Return the friction scans of rect1 on ``surface`` as ``PushTable.scans`` has them; None where
    there are none.

    Of several folders that hold some, the one with the most; scans whose force could not be told
    are left out.
    """
    if measured.path is None:
        return None
    homes: Counter[str] = Counter()
    for home, _, names in sorted(os.walk(measured.path)):
        scans = [scan_facts(name) for name in names if name.endswith(SUFFIXES)]
        homes[home] += sum(
            scan is not None and (scan.surface, scan.object) == (surface, OBJECT) for scan in scans
        )
    for home, count in homes.most_common(1):
        if count:
            measured.find(Path(home).relative_to(measured.path).as_posix())
            scans = load_pushes(home).scans
            told = scans[(scans["surface"] == surface) & (scans["object"] == OBJECT)]
            return told.dropna(subset=list(SCAN_FIELDS))
    return None


def not_found(what: str, surfaces: Iterable[str]) -> str:
    """Say that ``what`` was not found for these surfaces; empty where there are none.

    >>> not_found("pushes", ["abs", "pu"])
    'Recorded pushes on abs and pu: no measured data found.'
    """
    names = list(surfaces)
    return f"Recorded {what} on {listed(names)}: {NO_DATA}." if names else ""


@lru_cache(maxsize=32)
def _run_below(folder: Path, surface: str) -> MeasuredRun | None:
    homes: Counter[str] = Counter()
    for home, _, names in sorted(os.walk(folder)):
        for facts in map(push_facts, (name for name in names if name.endswith(SUFFIXES))):
            if (
                facts is not None
                and (facts.surface, facts.object) == (surface, OBJECT)
                and facts.repetition >= 0
            ):
                told = [getattr(facts, name) for name in PROTOCOL]
                homes[home] += np.allclose(told, list(PROTOCOL.values()), rtol=1e-6, atol=1e-9)
    for home, count in homes.most_common():
        if count < FEWEST:
            return None
        table = load_pushes(home)
        found = push_sets(table, {"surface": surface, "object": OBJECT, **PROTOCOL})
        best = max(found, key=lambda one: one.count)
        if best.count >= FEWEST:
            return MeasuredRun(best, len(table.unreadable))
    return None


def push_file_names(folder: Path) -> list[Path]:
    """Return the files of a folder that are pushes by name and suffix, sorted; sub-folders are not
    entered.
    """
    return sorted(
        path
        for path in folder.iterdir()
        if path.suffix.lower() in SUFFIXES and push_facts(path) is not None
    )


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
