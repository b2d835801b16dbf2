"""Pushes from CSV tables: poses before and after each push, or the orientation before each push alone."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.arrays import shorter_way
from cyclemap.errors import DataFileError
from cyclemap.evidence.pushes.mit_names import PushFacts
from cyclemap.evidence.pushes.push_record import LARGEST_ANGLE, LARGEST_POSITION
from cyclemap.evidence.theta0.theta0_pairs import doubt_degrees, read_theta0_pairs
from cyclemap.text_files import LARGEST_CONTENT, CsvRow, CsvTable, read_csv_table

# A column of the push table, the names it goes by in a file, and the factor to SI units.
_POSES = {
    "x0": {"x0": 1.0},
    "y0": {"y0": 1.0},
    "theta0": {"theta0": 1.0, "th0": 1.0, "theta0_deg": math.pi / 180.0},
    "x1": {"x1": 1.0},
    "y1": {"y1": 1.0},
    "theta1": {"theta1": 1.0, "th1": 1.0, "theta1_deg": math.pi / 180.0},
}
_FACTS = {
    "acceleration": {"acceleration": 1.0, "a_mm_s2": 1e-3},
    "speed": {"speed": 1.0, "v_mm_s": 1e-3},
    "side": {"side": 1.0, "i": 1.0},
    "fraction": {"fraction": 1.0, "s": 1.0},
    "angle": {"angle": 1.0, "t": 1.0},
    "repetition": {"repetition": 1.0, "rep": 1.0},
    "length": {"length": 1.0, "push_mm": 1e-3},
    "tip_x0": {"tip_x0": 1.0},
    "tip_y0": {"tip_y0": 1.0},
    "dtheta": {"dtheta": 1.0},
    "theta_next": {"theta_next": 1.0, "th0n": 1.0},
    "force_ratio": {"force_ratio": 1.0},
}
_TIP = ("tip_x0", "tip_y0", "tip_x1", "tip_y1")
# As a table of twenty columns they are as large as any file may be.
_MOST_PUSHES = LARGEST_CONTENT // 8 // 20
_TEXTS = {"surface": ("surface",), "object": ("object", "shape")}


def read_push_csv(path: str | Path) -> list[dict[str, Any]]:
    """Read a CSV file of pushes: a list of rows with the columns of `PushTable.table`, in the order of the file.

    A table of poses has a header with `x0,y0,theta0,x1,y1,theta1` (m, rad; also `th0`, `th1`, `theta0_deg`,
    `theta1_deg`); it may have `surface`, `object` (or `shape`), `acceleration` (`a_mm_s2`), `speed` (`v_mm_s`),
    `side` (`i`), `fraction` (`s`), `angle` (`t`), `repetition` (`rep`), `dtheta`, `theta_next` (`th0n`),
    `force_ratio`, and how far the rod moved: `length` (`push_mm`), or its places `tip_x0,tip_y0,tip_x1,tip_y1` (m).
    Columns of other names are passed over. What is absent or empty is NaN; `dtheta` is then the shorter way round, for
    two poses cannot tell more. `theta_next` is put on the lift nearest to theta1.

    Any other table is read by `read_theta0_pairs`: a row a pair, with theta0 and theta_next alone (and its `rep`,
    where the file has it).

    DataFileError names the file, the line and the mend.
    """
    table = read_csv_table(path)
    if len(table.rows) > _MOST_PUSHES:
        raise DataFileError(f"{table.path}: holds more than {_MOST_PUSHES} pushes; split it")
    if all(_source(table, names) for names in _POSES.values()):
        doubt_degrees(table, [name for name in ("theta0_deg", "theta1_deg") if name in table.header])
        return [_pose_row(table, row) for row in table.rows]
    return _pair_rows(table)


def _pose_row(table: CsvTable, row: CsvRow) -> dict[str, Any]:
    pose = {column: _number(table, row, names) for column, names in _POSES.items()}
    for column, value in pose.items():
        limit = LARGEST_ANGLE if column.startswith("theta") else LARGEST_POSITION
        if not abs(value) <= limit:
            raise table.error(row.line, f"{column} is {value:g}; it must be a number within {limit:g} (SI units)")
    facts = {column: _number(table, row, names) for column, names in _FACTS.items()}
    if all(name in table.header and table.text(row, name) for name in _TIP):
        x0, y0, x1, y1 = (table.number(row, name) for name in _TIP)
        facts["length"] = math.hypot(x1 - x0, y1 - y0)
    texts = {column: _text(table, row, names) for column, names in _TEXTS.items()}
    return _row(table) | texts | facts | pose | _motion(pose, facts)


def _motion(pose: dict[str, float], facts: dict[str, float]) -> dict[str, float]:
    x, y, theta, dtheta = pose["x1"] - pose["x0"], pose["y1"] - pose["y0"], pose["theta0"], facts["dtheta"]
    if math.isnan(dtheta):
        dtheta = float(shorter_way(pose["theta1"] - theta))
    theta1, c, s = theta + dtheta, math.cos(theta), math.sin(theta)
    ahead = theta1 + float(shorter_way(facts["theta_next"] - theta1))
    return {"dx": c * x + s * y, "dy": c * y - s * x, "dtheta": dtheta, "theta1": theta1, "theta_next": ahead}


def _pair_rows(table: CsvTable) -> list[dict[str, Any]]:
    pairs = read_theta0_pairs(table.path)
    number = np.full(pairs.theta.size, math.nan)
    if "theta0_accum_deg" in table.header:
        kept = [row for row in table.rows if table.text(row, "dtheta_to_next_deg") and not table.text(row, "flag")]
        number = np.array([table.number(row, "rep") for row in kept])
    columns = zip(number.tolist(), pairs.theta.tolist(), pairs.theta_next.tolist(), strict=True)
    return [_row(table) | {"repetition": rep, "theta0": now, "theta_next": later} for rep, now, later in columns]


def _row(table: CsvTable) -> dict[str, Any]:
    return asdict(PushFacts()) | {"samples": 0, "path": str(table.path)}


def _source(table: CsvTable, names: Any) -> str | None:
    """The first of `names` that the header has."""
    return next((name for name in names if name in table.header), None)


def _number(table: CsvTable, row: CsvRow, names: dict[str, float]) -> float:
    """The field times its factor; NaN where it is absent or empty."""
    name = _source(table, names)
    return names[name] * table.number(row, name) if name is not None and table.text(row, name) else math.nan


def _text(table: CsvTable, row: CsvRow, names: tuple[str, ...]) -> str | None:
    name = _source(table, names)
    return None if name is None else table.text(row, name) or None
