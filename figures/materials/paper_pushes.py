"""The paper's repeated pushes on four materials: what Ma & Rodriguez (2018) publish of them, and
those that the user's folder holds.

The paper gives standard deviations and root mean square errors, and both as percentages of the
mean: the mean is one over the other. Percentages carry no sign. In this package's frame the object
moves along -y: the means of the published plywood, 69.1 deg, 36.6 mm and 94.3 mm, put the rod's
centre 48.9 mm from the middle of the pushed side, where it must be 49.75 mm, if the motion is
(+36.6, -94.3) mm, and nowhere near that side with any other signs or with x and y exchanged. So dx
is the published Δx, dy minus the published Δy. Orientations are those of this package: the measured
plywood staircase lingers near 95 deg, where the paper sees its high peak ("around 100 deg").
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.errors import DataFileError, unknown_name
from cyclemap.evidence import PushSet, Theta0Pairs, load_pushes, push_sets, read_theta0_pairs
from cyclemap.evidence.identification.force_blocks import SCAN_FIELDS
from cyclemap.evidence.laws.push_sets import FEWEST
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.recordings import PushRecord, push_facts, scan_facts
from cyclemap.evidence.tables.data_kinds import SUFFIXES
from cyclemap.views.sentences import listed

from ..catalogue import NO_DATA, THETA0_FILE, MeasuredFolder

if TYPE_CHECKING:
    import pandas


SOURCE = "Ma & Rodriguez 2018, Tables II and III and the text on stable directions"
PUBLISHED_CYCLES = 2000


@dataclass(frozen=True)
class PublishedStatistics:
    """What is published of one material, in the order dtheta (rad), dx, dy (m, initial object
    frame).

    mean, std : of the pushes.
    rmse : of them about the paper's fitted law of θ0; rmse_percent : as printed beside it, per cent
        of a mean that is up to 3 % off that of Table II.
    directions : rad, where the histogram of θ0 has the peaks that the text names, the one visited
        first in front.
    always_advancing : the text sees no stable direction.
    first_share : of the cycles, spent in the first direction, where the run starts there and leaves
        it for good.
    """

    material: str
    mean: tuple[float, ...]
    std: tuple[float, ...]
    rmse: tuple[float, ...]
    rmse_percent: tuple[float, ...]
    directions: tuple[float, ...]
    always_advancing: bool = False
    first_share: float | None = None


def published_statistics(material: str) -> PublishedStatistics:
    """Return what is published of `material`: plywood, abs, delrin or pu. Raises InvalidInput for
    another.

    >>> [round(1e3 * length, 1) for length in published_statistics("abs").mean[1:]]
    [40.1, -67.6]
    """
    if material not in PUBLISHED:
        raise unknown_name("material of Ma & Rodriguez (2018)", material, PUBLISHED)
    return PUBLISHED[material]


# As printed: standard deviations of Δθ (deg), Δx, Δy (mm), these in per cent of the means, errors
# of the fitted law, these in per cent, and directions (deg). abs is "stuck in one stable direction"
# for "about 150 times", then in a second for good; the first has the small peak.
_TABLES: dict[str, tuple[tuple[float, ...], ...]] = {
    "plywood": (
        (4.74, 2.84, 8.57),
        (6.86, 7.75, 9.09),
        (2.07, 0.91, 3.39),
        (2.99, 2.46, 3.66),
        (100.0, 280.0),
    ),
    "abs": (
        (3.21, 1.59, 5.31),
        (4.30, 3.97, 7.86),
        (2.99, 1.56, 3.21),
        (4.00, 3.88, 4.75),
        (-150.0, 150.0),
    ),
    "delrin": (
        (1.28, 0.97, 3.21),
        (1.63, 2.49, 6.33),
        (1.28, 0.81, 1.61),
        (1.63, 2.07, 3.08),
        (80.0,),
    ),
    "pu": ((4.53, 2.93, 11.39), (6.53, 7.30, 13.40), (1.14, 0.60, 1.56), (1.64, 1.49, 1.86), ()),
}
_SI = np.array([math.radians(1.0), 1e-3, 1e-3])
PUBLISHED = MappingProxyType(
    {
        name: PublishedStatistics(
            name,
            tuple((_SI * [1.0, 1.0, -1.0] * 100.0 * std / percent).tolist()),
            tuple((_SI * std).tolist()),
            tuple((_SI * rmse).tolist()),
            rmse_percent,
            tuple(np.radians(directions).tolist()),
            always_advancing=name == "pu",
            first_share=150.0 / PUBLISHED_CYCLES if name == "abs" else None,
        )
        for name, (std, percent, rmse, rmse_percent, directions) in _TABLES.items()
    }
)


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
    run = None if measured.path is None else _run_below(measured.path, surface)
    if measured.path is not None and run is not None:
        # One who watches the folder so knows what was used.
        measured.find(run.pushes.source.relative_to(measured.path).as_posix())
    return run


def measured_theta0(measured: MeasuredFolder, surface: str) -> Theta0Pairs | None:
    """Return the measured θ0 of ``surface`` in order: of its set, else for plywood of its own file;
    None without.
    """
    run = measured_run(measured, surface)
    if run is not None and run.pushes.pairs is not None:
        return run.pushes.pairs
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

    def is_wanted(name: str) -> bool:
        scan = scan_facts(name)
        return scan is not None and (scan.surface, scan.object) == (surface, OBJECT)

    for home, _ in folders_by_count(measured.path, is_wanted)[:1]:
        measured.find(home.relative_to(measured.path).as_posix())
        scans = load_pushes(home).scans
        wanted = scans[(scans["surface"] == surface) & (scans["object"] == OBJECT)]
        return wanted.dropna(subset=list(SCAN_FIELDS))
    return None


def folders_by_count(folder: Path, is_wanted: Callable[[str], bool]) -> list[tuple[Path, int]]:
    """Return the folders below one that hold files of wanted names, and how many, most first."""
    counts: Counter[Path] = Counter()
    for home, _, names in sorted(os.walk(folder)):
        counts[Path(home)] = sum(is_wanted(name) for name in names if name.endswith(SUFFIXES))
    return [(home, count) for home, count in counts.most_common() if count]


def not_found(what: str, surfaces: Iterable[str]) -> str:
    """Say that ``what`` was not found for these surfaces; empty where there are none.

    >>> not_found("pushes", ["abs", "pu"])
    'Recorded pushes on abs and pu: no measured data found.'
    """
    names = list(surfaces)
    return f"Recorded {what} on {listed(names)}: {NO_DATA}." if names else ""


@lru_cache(maxsize=32)
def _run_below(folder: Path, surface: str) -> MeasuredRun | None:
    def is_wanted(name: str) -> bool:
        facts = push_facts(name)
        if facts is None or facts.repetition < 0:
            return False
        given = [getattr(facts, key) for key in PROTOCOL]
        is_own = np.allclose(given, list(PROTOCOL.values()), rtol=1e-6, atol=1e-9)
        return is_own and (facts.surface, facts.object) == (surface, OBJECT)

    for home, count in folders_by_count(folder, is_wanted):
        if count < FEWEST:
            return None
        table = load_pushes(home)
        sets = push_sets(table, {"surface": surface, "object": OBJECT, **PROTOCOL})
        best = max(sets, key=lambda pushes: pushes.count)
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
    records, unreadable = [], 0
    for path in files:
        try:
            record = read_push_file(path)
        except DataFileError:
            unreadable += 1
            continue
        assert isinstance(record, PushRecord)
        records.append((path, record))
    return records, unreadable
