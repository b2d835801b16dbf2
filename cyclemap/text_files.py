"""Files that people write: TOML, and CSV as tables that know their line numbers, so that a bad field can be named."""

import csv
import io
import math
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import InvalidOperation
from pathlib import Path
from typing import Any

from cyclemap.errors import DataFileError


@dataclass(frozen=True)
class CsvRow:
    """One record: its fields, stripped of blanks, and the line of the file it stands on."""

    line: int
    fields: tuple[str, ...]


@dataclass(frozen=True)
class CsvTable:
    """A CSV file with a header: every row has as many fields as the header has names."""

    path: Path
    header: tuple[str, ...]
    rows: tuple[CsvRow, ...]

    def text(self, row: CsvRow, column: str) -> str:
        """The field of `row` in `column` (a name of the header)."""
        return row.fields[self.header.index(column)]

    def number(self, row: CsvRow, column: str) -> float:
        """The field of `row` in `column` as a finite number; DataFileError otherwise."""
        text = self.text(row, column)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(row.line, f"{column} is '{text}'; it must be a finite number")
        return value

    def error(self, line: int, message: str) -> DataFileError:
        """A DataFileError that names this file and `line`."""
        return DataFileError(f"{self.path}, line {line}: {message}")


def read_csv_table(path: str | Path) -> CsvTable:
    """Read a CSV file whose first line is its header.

    Blank lines are passed over. DataFileError (naming the file, the line and the mend) where the file is
    absent, not UTF-8 text, empty, without rows, or has a row with more or fewer fields than the header.
    """
    path = Path(path)
    records = _records(path, read_text(path, "plain CSV"))
    if not records:
        raise DataFileError(f"{path}: the file is empty; it needs a header line and at least one row")
    table = CsvTable(path, tuple(name.lower() for name in records[0].fields), tuple(records[1:]))
    check_shape(table)
    return table


def require_columns(table: CsvTable, columns: Sequence[str]) -> None:
    """Raise DataFileError where `table` lacks one of `columns`."""
    missing = [name for name in columns if name not in table.header]
    if missing:
        raise table.error(1, f"column {', '.join(missing)} is missing; the header has {', '.join(table.header)}")


def read_toml(path: str | Path, parse_float: Callable[[str], Any] = float) -> dict[str, object]:
    """Read a TOML file, numbers with a point by `parse_float`.

    DataFileError, naming the file and the mend, where it is absent or not TOML, or holds what cannot be read.
    """
    try:
        return tomllib.loads(read_text(Path(path), "TOML"), parse_float=parse_float)
    except tomllib.TOMLDecodeError as error:
        raise DataFileError(f"{path}: not TOML: {error}") from error
    except (ValueError, InvalidOperation) as error:
        if isinstance(error, DataFileError):
            raise
        raise DataFileError(f"{path}: a number has more digits, or a larger power of ten, than can be read") from error
    except RecursionError as error:
        raise DataFileError(f"{path}: lists or tables are nested too deeply; a few levels are enough") from error


def read_text(path: Path, kind: str) -> str:
    """Return the text of a UTF-8 file, line ends as "\n"; DataFileError, naming file and mend, where it has none."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataFileError(f"{path}: byte {error.start} is not UTF-8 text; save it as {kind}") from error
    except FileNotFoundError as error:
        raise DataFileError(f"{path}: there is no such file; check the path") from error
    except OSError as error:
        raise DataFileError(f"{path}: cannot be read ({error.strerror}); give a readable {kind} file") from error


def _records(path: Path, text: str) -> list[CsvRow]:
    reader = csv.reader(io.StringIO(text), strict=True)
    try:
        stripped = [(reader.line_num, tuple(field.strip() for field in fields)) for fields in reader]
    except csv.Error as error:
        raise DataFileError(f"{path}, line {reader.line_num}: {error}; mend the quotes of this line") from error
    return [CsvRow(line, fields) for line, fields in stripped if any(fields)]


def check_shape(table: CsvTable) -> None:
    """Raise DataFileError where `table` has no rows, or a row that is not as long as its header."""
    if not table.rows:
        raise table.error(1, "a header but no rows; the file is empty or cut off")
    for row in table.rows:
        if len(row.fields) != len(table.header):
            counts = f"{len(row.fields)} of {len(table.header)} fields"
            raise table.error(row.line, f"{counts}; the line is cut off or has a stray comma: mend or remove it")
