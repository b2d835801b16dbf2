"""Files of people: TOML, JSON and CSV, read so that a bad field can be named; all are written whole
or not at all.
"""

import csv
import io
import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import InvalidOperation
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import CycleMapError, DataFileError, InvalidInput
from cyclemap.plain_text import json_value, number_or_nan

# Bytes that a file, or its tables as doubles, may hold: thirty times the longest push. Lists of
# Python's own numbers take thirty times as much memory, so that all readers stay under a gigabyte.
LARGEST_CONTENT = 2**24
# Of TOML, where a key of many parts takes time that grows with their square; a protocol is a few
# kilobytes.
_LARGEST_TOML = 2**17
_MOST_PARTS = 100


# What stands in a field without a number.
_NOTHING = ("", "nan", "na", "null", "none")


@dataclass(frozen=True, slots=True)
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
        value = number_or_nan(text)
        if not math.isfinite(value):
            raise self.error(
                row.line, f"{column} is '{text}'; it must be a finite number in plain digits"
            )
        return value

    def numbers(self, column: str, blank: bool = False) -> Array:
        """The numbers of a column (n,); where it may be `blank`, NaN for a field that says
        nothing.
        """
        numbers = []
        for row in self.rows:
            is_blank = blank and says_nothing(self.text(row, column))
            numbers.append(math.nan if is_blank else self.number(row, column))
        return np.array(numbers)

    def error(self, line: int, message: str) -> DataFileError:
        """A DataFileError that names this file and `line`."""
        return DataFileError(f"{self.path}, line {line}: {message}")


def says_nothing(field: str) -> bool:
    """Return whether a field stands for a number that is not there."""
    return field.lower() in _NOTHING


def read_csv_table(path: str | Path) -> CsvTable:
    """Read a CSV file whose first line is its header.

    Blank lines are passed over. DataFileError (naming the file, the line and the mend) where the
    file is absent, not UTF-8 text, empty, without rows, or has a row with more or fewer fields than
    the header.
    """
    return csv_table(Path(path), read_text(Path(path), "plain CSV"))


def csv_table(path: Path, text: str) -> CsvTable:
    """Return the table of a text, as `read_csv_table` does that of the file it is from."""
    records = _records(path, text)
    if not records:
        raise DataFileError(
            f"{path}: the file is empty; it needs a header line and at least one row"
        )
    header = tuple(name.lower() for name in records[0].fields)
    table = CsvTable(path, header, tuple(records[1:]))
    _check_shape(table)
    return table


def require_columns(table: CsvTable, columns: Sequence[str]) -> None:
    """Raise DataFileError where `table` lacks one of `columns`."""
    missing = [name for name in columns if name not in table.header]
    if missing:
        raise table.error(
            1, f"column {', '.join(missing)} is missing; the header has {', '.join(table.header)}"
        )


def read_toml(path: str | Path, parse_float: Callable[[str], Any] = float) -> dict[str, object]:
    """Read a TOML file, numbers with a point by `parse_float`.

    DataFileError, naming the file and the mend, where it is absent or not TOML, or holds what
    cannot be read.
    """
    text = read_text(Path(path), "TOML", _LARGEST_TOML)
    if any(word.count(".") >= _MOST_PARTS for word in re.split(r"[\n,=\[\]{}]", text)):
        raise DataFileError(
            f"{path}: a key of more than {_MOST_PARTS} parts is nested too deeply; a few levels "
            "are enough"
        )
    try:
        return tomllib.loads(text, parse_float=parse_float)
    except tomllib.TOMLDecodeError as error:
        raise DataFileError(f"{path}: not TOML: {error}") from error
    except (ValueError, InvalidOperation) as error:
        raise DataFileError(
            f"{path}: a number has more digits, or a larger power of ten, than can be read"
        ) from error
    except RecursionError as error:
        raise DataFileError(
            f"{path}: lists or tables are nested too deeply; a few levels are enough"
        ) from error


def key_place(path: str | Path, text: str, table: str, key: str) -> str:
    """Return the file and, where it is found, the line of a key in a table ("": before the first)
    of its TOML text.

    >>> key_place("a.toml", "side = 1\\n[push]\\nside = 2\\n", "push", "side")
    'a.toml, line 3'
    """
    here = ""
    for row, line in enumerate(text.splitlines(), 1):
        heading = re.fullmatch(
            r"\s*\[+\s*[\"']?([A-Za-z_][^\[\],\"']*?)[\"']?\s*\]+\s*(#.*)?", line
        )
        here = heading[1] if heading else here
        stands = here == table and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line)
        if stands or (heading and here == f"{table}.{key}"):
            return f"{path}, line {row}"
    return str(path)


def read_json(path: str | Path) -> object:
    """Read a JSON file; DataFileError where it is absent, cut short, not JSON, or names a key
    twice.
    """
    content = read_bytes(Path(path))
    try:
        return json_value(content)
    except json.JSONDecodeError as error:
        raise DataFileError(
            f"{path}: not JSON, or cut short: {error.msg} at line {error.lineno}, column "
            f"{error.colno}"
        ) from error
    except ValueError as error:
        raise DataFileError(f"{path}: not JSON that can be used: {error}") from error


def read_text(path: Path, kind: str, most: int = LARGEST_CONTENT) -> str:
    """Return the text of a UTF-8 file, line ends as "\n"; DataFileError, naming file and mend,
    where it has none.
    """
    return decoded(path, read_bytes(path, most), kind)


def decoded(path: Path, content: bytes, kind: str) -> str:
    """Return what `read_text` does, of content that was read."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise DataFileError(
            f"{path}, line {line}: byte {error.start} is not UTF-8 text; save it as {kind}"
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_bytes(path: Path, most: int = LARGEST_CONTENT) -> bytes:
    """Return the content of a regular file of at most `most` bytes; DataFileError, naming file and
    mend, otherwise.
    """
    try:
        with open(path, "rb", opener=_open_at_once) as file:
            is_regular = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            content = file.read(most + 1) if is_regular else b""
    except FileNotFoundError as error:
        raise DataFileError(f"{path}: there is no such file; check the path") from error
    except (OSError, ValueError) as error:
        cause = getattr(error, "strerror", error)
        raise DataFileError(f"{path}: cannot be read ({cause}); give a readable file") from error
    if not is_regular:
        raise DataFileError(f"{path}: is a pipe or a device; give a regular file")
    if len(content) > most:
        raise DataFileError(
            f"{path}: holds more than {most / 1e6:.1f} MB; split it, or leave out what is not "
            "needed"
        )
    return content


def _open_at_once(path: str, flags: int) -> int:
    # Without this a pipe is opened only when somebody writes to it.
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _records(path: Path, text: str) -> list[CsvRow]:
    reader = csv.reader(io.StringIO(text), strict=True)
    rows = []
    room = LARGEST_CONTENT // 8
    try:
        for fields in reader:
            stripped = tuple(field.strip() for field in fields)
            room -= len(stripped)
            if room < 0:
                raise DataFileError(
                    f"{path}: holds more than {LARGEST_CONTENT // 8} fields; split it"
                )
            if any(stripped):
                rows.append(CsvRow(reader.line_num, stripped))
    except csv.Error as error:
        raise DataFileError(
            f"{path}, line {reader.line_num}: {error}; mend the quotes of this line"
        ) from error
    return rows


def _check_shape(table: CsvTable) -> None:
    """Raise DataFileError where a column is there twice, `table` has no rows, or one not as long as
    its header.
    """
    names = [name for name in table.header if name]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise table.error(1, f"the column {twice} is there twice; keep one")
    if not table.rows:
        raise table.error(1, "a header but no rows; the file is empty or cut off")
    for row in table.rows:
        if len(row.fields) != len(table.header):
            raise table.error(
                row.line,
                f"{len(row.fields)} of {len(table.header)} fields; the line is cut off or has "
                "a stray comma: mend or remove it",
            )


try:
    import fcntl
except ImportError:  # pragma: no cover - Windows has no such locks
    fcntl = None  # type: ignore[assignment]

# What a process killed while writing leaves behind ends so; no reader of data takes it for any.
UNFINISHED_SUFFIX = ".part"


def write_whole(path: Path, content: bytes) -> None:
    """Write `content` to `path` by way of a file beside it; OSError, naming the path, where that
    cannot be done.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED_SUFFIX}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as file:
                file.write(content)
                file.flush()
                # A name may reach the disk before what it names: power lost between would leave an
                # empty file.
                os.fsync(file.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        cause = f"{error.strerror}: {error.filename}" if error.filename else error.strerror or error
        raise OSError(
            f"{path} cannot be written ({cause}); nothing was left half-written"
        ) from error


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Make `folder` and hold it for this process while the block lasts, however that ends.

    CycleMapError where another process holds it. Windows has no such locks: there nobody is
    refused.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY) if fcntl is not None else None
    except OSError as error:
        raise OSError(
            f"{folder} cannot be used ({error.strerror}); choose another folder"
        ) from error
    if handle is None:
        yield
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError as error:
        raise CycleMapError(
            f"{folder} is written by another process; wait for it, or choose another folder"
        ) from error
    finally:
        os.close(handle)


def file_stem(name: str) -> str:
    """Return the name of a material or an object as it can stand in a file name; InvalidInput where
    nothing is left.

    >>> file_stem("worn plywood (side B)")
    'worn_plywood_side_B'
    """
    stem = re.sub(r"[^\w.-]+", "_", name).strip("_.")
    if not stem:
        raise InvalidInput(f"{name!r} can name no file: it needs a letter or a digit")
    return stem
