"""The columns of a file of numbers as it names them: CSV of any house, Excel, LeRobot's parquet,
poses of a ROS bag.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import require_room
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.columns import QUATERNION
from cyclemap.file_text import located
from cyclemap.plain_text import install_words, json_value
from cyclemap.text_files import read_text

if TYPE_CHECKING:
    import pandas

Columns = dict[str, Array]

EXCEL, PARQUET, BAGS = (".xlsx", ".xlsm"), (".parquet",), (".bag", ".db3", ".mcap")
JSON_LINES = (".jsonl", ".ndjson")
# Of columns of texts those that tell what was pushed on what are kept.
_TEXTS = re.compile(r"surface|object|shape", re.IGNORECASE)
# Bytes of a spreadsheet, or of parquet as doubles: both pack a thousand times what they show on
# disk.
_LARGEST_DECODED = 2**26


def raw_columns(path: Path, told: Mapping[str, str], growing: bool) -> Columns:
    """The columns of a file, by its own names, NaN where a field is empty; `growing`: without an
    unfinished line.
    """
    with located(str(path), DataFileError):
        return _columns(path, told.get("pose"), growing)


def _columns(path: Path, topic: str | None, growing: bool) -> Columns:
    """The columns of a file of any kind; InvalidInput where it has none."""
    kind = path.suffix.lower()
    if path.is_dir() and (path / "meta" / "info.json").is_file():
        return _lerobot(path)
    if not path.is_dir() and not path.is_file():
        pipe = "is a pipe or a device; give a regular file"
        raise InvalidInput(pipe if path.exists() else "there is no such file; check the path")
    if path.is_dir() or kind in BAGS:
        return _bag(path, topic)
    if kind in PARQUET:
        return _parquet([path])
    if kind in EXCEL:
        return _excel(path)
    text = read_text(path, "CSV")
    text = text[: text.rfind("\n") + 1] if growing else text
    return _json_lines(path, text) if kind in (*JSON_LINES, ".json") else _csv(text)


def _excel(path: Path) -> Columns:
    """The first sheet of a workbook."""
    import pandas

    _library("openpyxl", "excel")
    # zipfile, zlib, XML, openpyxl, pandas: each has its own kinds of error.
    with _refused_as("a spreadsheet"):
        with ZipFile(path) as parts:
            _check_size(sum(part.file_size for part in parts.infolist()))
        return _numbers(pandas.read_excel(path))


@contextmanager
def _refused_as(kind: str, mend: Callable[[Exception], str] = lambda error: "") -> Iterator[None]:
    """Whatever a library raises becomes InvalidInput."""
    try:
        yield
    except InvalidInput:
        raise
    except Exception as error:
        raise InvalidInput(f"not {kind} that can be read ({error}){mend(error)}") from error


def _check_size(decoded: int) -> None:
    """Refuse what is small on disk and large when it is unpacked."""
    what = f"holds {decoded / 1e6:.0f} MB of numbers"
    require_room(what, decoded // 8, "split it", _LARGEST_DECODED // 8)


def _json_lines(path: Path, text: str) -> Columns:
    """Rows of JSON, one a line: what stands deeper is named by its way there, parts of lists by
    their number.
    """
    import pandas

    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            row = json_value(line)
        except ValueError as error:
            raise DataFileError(f"{path}, line {number}: not JSON ({error})") from error
        if not isinstance(row, dict):
            raise DataFileError(
                f"{path}, line {number}: a row is an object, {{...}}, not {line[:40]}"
            )
        rows.append(dict(_flat("", row)))
    if len(rows) < 2:
        raise InvalidInput(f"{len(rows)} lines; rows are wanted")
    _check_size(8 * len(rows) * len({name for row in rows for name in row}))
    return _numbers(pandas.DataFrame(rows))


def _flat(name: str, value: object) -> Iterator[tuple[str, object]]:
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _flat(f"{name}_{key}" if name else str(key), one)
    elif isinstance(value, list):
        for number, one in enumerate(value):
            yield from _flat(f"{name}[{number}]", one)
    else:
        yield name, value


def _csv(text: str) -> Columns:
    """A CSV file of any separator; where that is no comma, commas in numbers are decimal ones."""
    import pandas

    lines = [
        line for line in text.splitlines() if line.strip() and not line.startswith(("#", "sep="))
    ]
    if len(lines) < 2:
        raise InvalidInput(f"{len(lines)} lines; a header and rows are wanted")
    separator = max(";\t,|", key=lambda sign: (lines[0].count(sign), sign == ","))
    # A comma below a header of one name is a decimal one.
    if separator not in lines[0]:
        separator = ";"
    try:
        rows = list(csv.reader(lines, delimiter=separator, skipinitialspace=True))
        names = len(rows[0])
        # pandas would take the first column of longer rows for their names, and move all others by
        # one.
        for row in rows:
            if any(field.strip() for field in row[names:]):
                raise InvalidInput(
                    f"{len(row)} fields below {names} names: {separator.join(row)[:80]}"
                )
        frame = pandas.read_csv(
            io.StringIO("\n".join(lines)),
            sep=separator,
            decimal="." if separator == "," else ",",
            skipinitialspace=True,
            usecols=range(names),
            index_col=False,
        )
    except InvalidInput:
        raise
    except (ValueError, csv.Error, pandas.errors.ParserError) as error:
        raise InvalidInput(f"rows of different lengths, or none ({error})") from error
    return _numbers(frame)


def _numbers(frame: pandas.DataFrame) -> Columns:
    import pandas

    found: Columns = {}
    for name in frame.columns:
        column = frame[name]
        if _TEXTS.fullmatch(str(name).strip()) and column.dtype.kind not in "iufb":
            found[str(name).strip()] = column.to_numpy(dtype=object)
            continue
        if column.dtype.kind not in "iufb":
            text = column.astype("string").str.strip().str.replace(",", ".", regex=False)
            column = pandas.to_numeric(text, errors="coerce")
            if column.isna().all():
                moment = pandas.to_datetime(text, errors="coerce", format="ISO8601", utc=True)
                column = (moment - pandas.Timestamp(0, tz="UTC")).dt.total_seconds()
        found[str(name).strip()] = column.to_numpy(dtype=float, na_value=math.nan)
    if not any(np.isfinite(values).any() for values in found.values() if values.dtype.kind == "f"):
        raise InvalidInput(f"no column of numbers among {', '.join(map(str, frame.columns))[:200]}")
    return found


def _parquet(files: Sequence[Path], names: Mapping[str, Sequence[str]] | None = None) -> Columns:
    """Columns of parquet files, one after the other; of lists each part as a column named[i], or by
    its own name.
    """
    _library("pyarrow", "lerobot")
    import pandas

    parquet: Any = import_module("pyarrow.parquet")
    # Arrow's own kinds of error, and any of what a damaged type makes of pandas.
    with _refused_as("parquet"):
        decoded = 0
        for metadata in map(parquet.read_metadata, files):
            for group in map(metadata.row_group, range(metadata.num_row_groups)):
                columns = map(group.column, range(group.num_columns))
                decoded += 8 * sum(column.num_values for column in columns)
        _check_size(decoded)
        frame = pandas.concat([pandas.read_parquet(file) for file in files], ignore_index=True)
    found: Columns = {}
    for column in frame.columns:
        values = frame[column]
        if values.dtype.kind in "iufb":
            found[column] = values.to_numpy(dtype=float)
        elif len(values) and np.ndim(values.iloc[0]) == 1:
            lists = np.stack(values.to_numpy())
            own = list((names or {}).get(column, ()))
            for place, numbers in enumerate(lists.T if lists.dtype.kind in "iuf" else ()):
                name = own[place] if place < len(own) else ""
                is_free = name and name not in found
                found[name if is_free else f"{column}[{place}]"] = numbers.astype(float)
    return found


def _lerobot(path: Path) -> Columns:
    """A LeRobot data set: its parquet files in order, the parts of its features by the names that
    it gives them.
    """
    files = sorted((path / "data").rglob("*.parquet"))
    if not files:
        raise InvalidInput(
            "a LeRobot data set without data/*.parquet: fetch its data, not meta alone"
        )
    try:
        features = json.loads(read_text(path / "meta" / "info.json", "JSON")).get("features", {})
    except ValueError as error:
        raise DataFileError(f"{path / 'meta' / 'info.json'}: not JSON ({error})") from error
    names = {}
    for name, feature in features.items():
        listed = feature.get("names") if isinstance(feature, dict) else None
        listed = next(iter(listed.values()), None) if isinstance(listed, dict) else listed
        if isinstance(listed, list) and all(isinstance(one, str) for one in listed):
            names[name] = listed
    return _parquet(files, names)


def _bag(path: Path, topic: str | None) -> Columns:
    """The poses of one topic of a ROS bag, 1 or 2."""
    _library("rosbags", "ros")
    highlevel: Any = import_module("rosbags.highlevel")
    typesys: Any = import_module("rosbags.typesys")
    rows = []
    with _refused_as("a ROS bag", _mend_of_bag):
        store = typesys.get_typestore(typesys.Stores.LATEST)
        with highlevel.AnyReader([path], default_typestore=store) as reader:
            wanted = _topic(topic, reader.connections)
            posed = [one for one in reader.connections if one.topic == wanted]
            for connection, stamp, content in reader.messages(posed):
                pose = reader.deserialize(content, connection.msgtype)
                while not hasattr(pose, "orientation") and not hasattr(pose, "rotation"):
                    pose = pose.pose if hasattr(pose, "pose") else pose.transform
                place = getattr(pose, "position", None) or pose.translation
                turn = getattr(pose, "orientation", None) or pose.rotation
                rows.append([1e-9 * stamp, place.x, place.y, turn.x, turn.y, turn.z, turn.w])
    if not rows:
        raise InvalidInput(f"the topic {wanted} has no message")
    return dict(zip(("t", "x", "y", *QUATERNION), np.array(rows).T, strict=True))


def _topic(told: str | None, connections: Sequence[Any]) -> str:
    """The topic that is told, else the one that has poses."""
    posed = [one for one in connections if re.search(r"Pose|Odometry|Transform", one.msgtype)]
    topics = sorted({one.topic for one in posed})
    wanted = told or (topics[0] if len(topics) == 1 else None)
    if wanted not in topics:
        among = ", ".join(sorted({one.topic for one in connections})) or "none"
        have = ", ".join(topics) or f"none among {among}"
        mend = "give the topic of the object's pose, --columns pose=TOPIC"
        raise InvalidInput(f"{mend}; with poses: {have}")
    return str(wanted)


def _mend_of_bag(error: Exception) -> str:
    if "Profile is not ros2" in str(error):
        return ": only MCAP of ROS 2 is; write what this one holds as a table of t,x,y,qx,qy,qz,qw"
    return ": one that was not closed is mended by rosbag reindex, ros2 bag reindex or mcap recover"


def _library(name: str, extra: str) -> None:
    try:
        import_module(name)
    except ImportError as error:
        raise InvalidInput(f"this kind of file needs {name}: {install_words(extra)}") from error
