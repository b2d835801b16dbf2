"""CSV files that begin with comments: lines of `#`, some of them facts by name."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.resets.protocol.exact_units import Unit
from cyclemap.text_files import CsvRow, CsvTable, check_shape, read_text


@dataclass(frozen=True)
class CommentedTable:
    """A table, and the facts `# name: text` of the comments before it."""

    table: CsvTable
    facts: dict[str, str]

    def number(self, row: CsvRow, column: str, unit: Unit) -> float:
        """Return a field of `unit` in SI units, rounded once; DataFileError where it is no finite number."""
        text = self.table.text(row, column)
        try:
            return unit.read(Decimal(text))
        except (InvalidOperation, InvalidInput) as error:
            raise self.table.error(row.line, f"{column} is '{text}'; it must be a finite number") from error


def read_commented_csv(path: str | Path) -> CommentedTable:
    """Return a CSV file whose header may follow comments.

    DataFileError, naming the line, where it cannot be read, has no rows, a line is not as long as its header, or the
    last line is not ended: what was cut off in the middle of a number still looks like one.
    """
    lines = read_text(Path(path), "plain CSV").split("\n")
    if lines.pop():
        raise DataFileError(f"{path}, line {len(lines) + 1}: the line is cut off (it has no end); write the file anew")
    comments = [line.lstrip("#").strip() for line in lines if line.startswith("#")]
    rows = [_row(Path(path), n, line) for n, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    if len(rows) < 2:
        raise DataFileError(f"{path}: a schedule has a header and at least one row; the file is empty or cut off")
    table = CsvTable(Path(path), rows[0].fields, tuple(rows[1:]))
    check_shape(table)
    named = (comment.partition(":") for comment in comments)
    return CommentedTable(table, {name.strip(): fact.strip() for name, colon, fact in named if colon})


def _row(path: Path, number: int, line: str) -> CsvRow:
    try:
        (fields,) = csv.reader([line], strict=True)
    except csv.Error as error:
        raise DataFileError(f"{path}, line {number}: {error}; mend the quotes of this line") from error
    return CsvRow(number, tuple(field.strip() for field in fields))
