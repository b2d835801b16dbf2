"""Which rows of measured data take part in an identification: one object, and what was selected."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.evidence.pushes.push_table import CSV_SUFFIX, PushTable, load_pushes
from cyclemap.suggestions import unknown_name
from cyclemap.text_files import CsvRow, CsvTable, read_csv_table

# Facts by which rows are selected, the columns of CSV files that tell them, and the factor to SI units.
_COLUMNS: dict[str, dict[str, float | None]] = {
    "surface": {"surface": None},
    "object": {"object": None, "shape": None},
    "speed": {"speed": 1.0, "v_mm_s": 1e-3},
    "side": {"side": 1.0, "i": 1.0},
    "fraction": {"fraction": 1.0, "s": 1.0},
    "angle": {"angle": 1.0, "t": 1.0},
}
FACTS = tuple(_COLUMNS)


@dataclass(frozen=True)
class RowSelection:
    """The objects whose rows are kept (none: whatever it is), and values of other facts, SI units and radians.

    What a row does not tell is not held against it. Raises InvalidInput for an unknown fact.
    """

    objects: tuple[str, ...] = ()
    chosen: Mapping[str, str | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.chosen:
            if name not in FACTS:
                raise unknown_name("fact of a push", name, FACTS)

    def refusal(self, facts: Mapping[str, Any]) -> str:
        """Return why a row of these facts stays out; empty where it is kept.

        >>> RowSelection(("rect1",)).refusal({"object": "hex"})
        'of hex, not rect1'
        """
        shape = facts.get("object")
        if self.objects and _known(shape) and shape not in self.objects:
            return f"of {shape}, not {self.objects[0]}" if len(self.objects) == 1 else f"of {shape}, of unknown outline"
        for name, wanted in self.chosen.items():
            value = facts.get(name)
            if name != "object" and _known(value) and not _equal(value, wanted):
                told = value if isinstance(value, str) else f"{value:g}"
                return f"of {name} {told}, not {wanted}"
        return ""


@dataclass(frozen=True, eq=False)
class CsvSelection:
    """The rows of a CSV file that take part: texts of columns that pick them, each a selection of its own.

    rows : how many each of `texts` picks. surfaces, objects : that the rows tell. left_out : counted by reason.
    """

    texts: tuple[dict[str, str], ...]
    rows: tuple[int, ...]
    surfaces: frozenset[str]
    objects: frozenset[str]
    left_out: Counter[str]


def select_csv(path: Path, selection: RowSelection) -> CsvSelection:
    """Return which rows of a CSV file take part. Raises DataFileError where a fact is no number."""
    table = read_csv_table(path)
    sources = {name: column for name in FACTS if (column := _source(table, name)) is not None}
    needed = {name: sources[name] for name in ("surface", "object", *selection.chosen) if name in sources}
    picked: Counter[tuple[str, ...]] = Counter()
    left_out: Counter[str] = Counter()
    told: dict[str, set[str]] = {"surface": set(), "object": set()}
    for row in table.rows:
        facts = {name: _fact(table, row, name, column) for name, column in needed.items()}
        reason = selection.refusal(facts)
        if reason:
            left_out[reason] += 1
            continue
        picked[tuple(table.text(row, column) for column in needed.values())] += 1
        for name, values in told.items():
            values |= {str(facts[name])} if _known(facts.get(name)) else set()
    texts = tuple(dict(zip(needed.values(), key, strict=True)) for key in picked)
    return CsvSelection(texts, tuple(picked.values()), frozenset(told["surface"]), frozenset(told["object"]), left_out)


def row_facts(table: CsvTable, row: CsvRow) -> dict[str, str | float | None]:
    """Return what a row of a CSV file tells of its push, by FACTS; None where it does not."""
    sources = {name: _source(table, name) for name in FACTS}
    return {name: None if column is None else _fact(table, row, name, column) for name, column in sources.items()}


def select_pushes(
    path: Path, selection: RowSelection, tables_too: bool, progress: Any = None
) -> tuple[PushTable, Counter[str]]:
    """Return the pushes and scans of a file or tree that take part, and how many stay out, by reason.

    tables_too : whether CSV tables count; else files of the MIT layout alone do.
    """
    found, left_out = load_pushes(path, progress=progress), Counter[str]()
    frames = []
    for frame in (found.table, found.scans):
        facts = frame[[name for name in FACTS if name in frame]].to_dict("records")
        keep = np.ones(len(frame), dtype=bool)
        for number, (row, file) in enumerate(zip(facts, frame["path"], strict=True)):
            table = not tables_too and str(file).lower().endswith(CSV_SUFFIX)
            reason = "" if table else selection.refusal(row)
            left_out[reason] += bool(reason)
            keep[number] = not (reason or table)
        frames.append(frame[keep].reset_index(drop=True))
    bad = [file for file in found.unreadable if tables_too or file.path.suffix.lower() != CSV_SUFFIX]
    return PushTable(frames[0], frames[1], tuple(bad)), +left_out


def pushes_of(pushes: PushTable, plate: str) -> PushTable:
    """Return the pushes and scans of one object of several, without what could not be read."""
    table, scans = (frame[frame["object"] == plate].reset_index(drop=True) for frame in (pushes.table, pushes.scans))
    return PushTable(table, scans, ())


def told(frame: Any, column: str) -> frozenset[str]:
    """Return the texts that a column tells."""
    return frozenset(str(value) for value in frame[column] if _known(value))


def _source(table: CsvTable, name: str) -> str | None:
    return next((column for column in _COLUMNS[name] if column in table.header), None)


def _fact(table: CsvTable, row: CsvRow, name: str, column: str) -> str | float | None:
    factor, text = _COLUMNS[name][column], table.text(row, column)
    if factor is None or not text:
        return text or None
    return factor * table.number(row, column)


def _known(value: Any) -> bool:
    return bool(value) if isinstance(value, str) else value is not None and not math.isnan(value)


def _equal(value: Any, wanted: str | float) -> bool:
    if isinstance(wanted, str) or isinstance(value, str):
        return str(value) == str(wanted)
    return math.isclose(float(value), wanted, rel_tol=1e-6, abs_tol=1e-9)
