"""Files of numbers of any house, each as columns under its own names: text and sheets by
`text_tables`; JSON, LeRobot's parquet, and the poses of a ROS bag here.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import numpy as np

from cyclemap.checks import require_room
from cyclemap.errors import DataFileError, InvalidInput, located
from cyclemap.evidence.tables.columns import QUATERNION
from cyclemap.evidence.tables.text_tables import (
    Columns,
    cell_columns,
    is_table,
    number_columns,
    text_columns,
)
from cyclemap.plain_text import install_words, json_value
from cyclemap.text_files import read_bytes, read_text

if TYPE_CHECKING:
    import pandas

EXCEL = (".xlsx", ".xlsm")
PARQUET = (".parquet",)
BAGS = (".bag", ".db3", ".mcap")
JSON_LINES = (".jsonl", ".ndjson")
# A data set of LeRobot, and a bag of ROS 2, are folders with these files.
LEROBOT_INFO = Path("meta", "info.json")
BAG_INFO = Path("metadata.yaml")
# A bag's poses, in the units of ROS.
_POSE = ("t_s", "x_m", "y_m", *QUATERNION)
# Bytes of a spreadsheet, or of what is packed as doubles: a thousand times what they show on disk.
_LARGEST_DECODED = 2**26
# What columns of parquet hold beside numbers, texts and moments: parts of pictures and the like.
_NO_VALUES = ("mixed", "bytes", "empty")


def raw_columns(path: Path, given: Mapping[str, str], growing: bool) -> Columns:
    """Return the columns of a file, by its own names, NaN where a field is empty.

    given : of a bag its topic, of a workbook its sheet, as pose and sheet. growing : without an
        unfinished line.
    """
    with located(str(path), DataFileError):
        kind = path.suffix.lower()
        if (path / LEROBOT_INFO).is_file():
            return _lerobot(path)
        if not path.is_dir() and not path.is_file():
            pipe = "is a pipe or a device; give a regular file"
            raise InvalidInput(pipe if path.exists() else "there is no such file; check the path")
        if path.is_dir() or kind in BAGS:
            return _bag(path, given.get("pose"))
        if kind in PARQUET:
            return _parquet([path])
        if kind in EXCEL:
            return _excel(path, given.get("sheet"))
        text = _text(path)
        text = text[: text.rfind("\n") + 1] if growing else text
        return _json(path, text) if kind in (".json", *JSON_LINES) else text_columns(text)


def _text(path: Path) -> str:
    """The text of a file, in UTF-16 where its first bytes say so, else in UTF-8 or, failing that,
    as older programs of Windows write.
    """
    content = read_bytes(path)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = content.decode("utf-16", errors="replace")
    elif b"\0" in content:
        raise InvalidInput(
            "holds bytes, not text: save its numbers as CSV, a name above each column"
        )
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _library(name: str, extra: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        needed = name.partition(".")[0]
        raise InvalidInput(f"this kind of file needs {needed}: {install_words(extra)}") from error


@contextmanager
def _refused_as(kind: str, mend: Callable[[Exception], str] = lambda error: "") -> Iterator[None]:
    """Whatever a library raises becomes InvalidInput: each has its own kinds of error, and damage
    makes others of them.
    """
    try:
        yield
    except InvalidInput:
        raise
    except Exception as error:
        raise InvalidInput(f"not {kind} that can be read ({error}){mend(error)}") from error


def _check_size(numbers: int) -> None:
    """Refuse what is small on disk and large when it is unpacked."""
    what = f"holds {8e-6 * numbers:.0f} MB of numbers"
    require_room(what, numbers, "split it", _LARGEST_DECODED // 8)


def _excel(path: Path, given: str | None) -> Columns:
    """The sheet of a workbook that is told, else the one that has a table of numbers."""
    import pandas

    _library("openpyxl", "excel")
    with _refused_as("a spreadsheet"):
        with ZipFile(path) as parts:
            _check_size(sum(part.file_size for part in parts.infolist()) // 8)
        read = pandas.read_excel(path, sheet_name=None, header=None, dtype=object)
    sheets = {
        str(name): cells.fillna("").astype(str).values.tolist() for name, cells in read.items()
    }
    if given is None:
        tables = [name for name, cells in sheets.items() if is_table(cells)]
        if len(tables) > 1:
            raise InvalidInput(
                f"has numbers in the sheets {', '.join(tables)}: say which, --columns "
                f"sheet={tables[0]}"
            )
        given = (tables or [*sheets])[0]
    if given not in sheets:
        raise InvalidInput(f"no sheet {given}; it has {', '.join(sheets)}")
    return cell_columns(sheets[given])


# -- JSON


def _json(path: Path, text: str) -> Columns:
    """Rows of JSON, in a list, a list by column, or one a line: what stands deeper is named by its
    way there, parts of lists by their number.
    """
    import pandas

    try:
        whole = json_value(text)
    except ValueError:
        whole = None
    rows = _json_lines(path, text) if whole is None else _json_rows(whole)
    if len(rows) < 2:
        raise InvalidInput(
            f'{len(rows)} rows; more are wanted: give [{{"theta0_deg": 12.5, ...}}, ...], '
            '{"theta0_deg": [12.5, ...], ...}, or a row a line'
        )
    flat = []
    for row in rows:
        values: dict[str, object] = {}
        _flatten("", row, values)
        flat.append(values)
    _check_size(len(flat) * len(set[str]().union(*flat)))
    return number_columns(pandas.DataFrame(flat))


def _json_rows(whole: object) -> list[object]:
    """The rows of a JSON document, as pandas and others write them; none where it has none."""
    if isinstance(whole, list):
        return whole if all(isinstance(row, dict) for row in whole) else []
    if not isinstance(whole, dict):
        return []
    names = whole.get("columns")
    data = whole.get("data")
    if isinstance(names, list) and isinstance(data, list):
        if not all(isinstance(row, list) for row in data):
            return []
        if len({*map(str, names)}) < len(names) or any(len(row) > len(names) for row in data):
            raise InvalidInput(f"a row has more numbers than the {len(names)} names tell apart")
        return [dict(zip(map(str, names), row, strict=False)) for row in data]
    columns = {name: _listed(values) for name, values in whole.items()}
    known = {name: values for name, values in columns.items() if len(values) > 1}
    if len(known) == 1:
        (rows,) = known.values()
        if all(isinstance(row, dict) for row in rows):
            return rows
    if len({len(values) for values in known.values()}) != 1:
        return []
    return [dict(zip(known, row, strict=True)) for row in zip(*known.values(), strict=True)]


def _listed(values: object) -> list[object]:
    """The values of a list, or of an object whose keys count its rows; of anything else none."""
    if isinstance(values, dict) and all(key.isdecimal() for key in values):
        return [values[key] for key in sorted(values, key=int)]
    return values if isinstance(values, list) else []


def _json_lines(path: Path, text: str) -> list[object]:
    """A row of JSON a line."""
    rows = list[object]()
    for line_number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        place = f"{path}, line {line_number}"
        try:
            row = json_value(line)
        except ValueError as error:
            raise DataFileError(f"{place}: not JSON ({error})") from error
        if not isinstance(row, dict):
            raise DataFileError(f"{place}: a row is an object, {{...}}, not {line[:40]}")
        rows.append(row)
    return rows


def _flatten(name: str, value: object, values: dict[str, object]) -> None:
    """Add what stands in a value to the values of its row."""
    if isinstance(value, dict):
        for key, deeper in value.items():
            _flatten(f"{name}_{key}" if name else key, deeper, values)
    elif isinstance(value, list):
        for index, deeper in enumerate(value):
            _flatten(f"{name}[{index}]", deeper, values)
    elif name in values:
        raise InvalidInput(f"two values of a row are named {name}, one of them by its way there")
    else:
        values[name] = value


# -- parquet


def _parquet(files: Sequence[Path], names: Mapping[str, Sequence[str]] | None = None) -> Columns:
    """Columns of parquet files, one after the other; of lists each part as a column named[i], or by
    its own name.
    """
    import pandas

    parquet = _library("pyarrow.parquet", "lerobot")
    with _refused_as("parquet"):
        decoded = 0
        for metadata in map(parquet.read_metadata, files):
            for group in map(metadata.row_group, range(metadata.num_row_groups)):
                columns = map(group.column, range(group.num_columns))
                decoded += sum(column.num_values for column in columns)
        _check_size(decoded)
        frames = [pandas.read_parquet(file) for file in files]
        # An index that has a name is a column.
        frames = [frame.reset_index(drop=frame.index.name is None) for frame in frames]
        frame = pandas.concat(frames, ignore_index=True)
    return number_columns(_without_lists(frame, names or {}))


def _without_lists(frame: pandas.DataFrame, names: Mapping[str, Sequence[str]]) -> pandas.DataFrame:
    """The columns of a frame, of lists that are alike each part as one, without what has no
    value.
    """
    import pandas

    apart: dict[str, pandas.Series] = {}
    for column, values in frame.items():
        shapes = {np.shape(row) for row in values} if values.dtype.kind == "O" else {()}
        if shapes == {()} and pandas.api.types.infer_dtype(values) not in _NO_VALUES:
            apart[str(column)] = values
        elif len(shapes) == 1 and len(shapes.pop()) == 1:
            own = [*names.get(str(column), ())]
            for index, part in enumerate(np.stack(values.to_numpy()).T):
                name = own[index] if index < len(own) else ""
                is_free = name and name not in apart
                apart[name if is_free else f"{column}[{index}]"] = pandas.Series(part)
    return pandas.DataFrame(apart)


def _lerobot(path: Path) -> Columns:
    """A LeRobot data set: its parquet files in order, the parts of its features by the names that
    it gives them.
    """
    files = sorted((path / "data").rglob("*.parquet"))
    if not files:
        raise InvalidInput(
            "a LeRobot data set without data/*.parquet: fetch its data, not meta alone"
        )
    place = path / LEROBOT_INFO
    try:
        info = json_value(read_text(place, "JSON"))
    except ValueError as error:
        raise DataFileError(f"{place}: not JSON ({error})") from error
    features = info.get("features", {}) if isinstance(info, dict) else None
    if not isinstance(features, dict):
        raise DataFileError(f"{place}: features must be an object by their names")
    names = {}
    for name, feature in features.items():
        listed = feature.get("names") if isinstance(feature, dict) else None
        listed = next(iter(listed.values()), None) if isinstance(listed, dict) else listed
        if isinstance(listed, list) and all(isinstance(part, str) for part in listed):
            names[name] = listed
    return _parquet(files, names)


# -- bags


def _bag(path: Path, topic: str | None) -> Columns:
    """The poses of one topic of a ROS bag, 1 or 2."""
    highlevel = _library("rosbags.highlevel", "ros")
    typesys = _library("rosbags.typesys", "ros")
    rows = []
    with _refused_as("a ROS bag", _mend_of_bag):
        store = typesys.get_typestore(typesys.Stores.LATEST)
        with highlevel.AnyReader([path], default_typestore=store) as reader:
            wanted = _topic(topic, reader.connections)
            posed = [known for known in reader.connections if known.topic == wanted]
            _check_size(len(_POSE) * sum(connection.msgcount for connection in posed))
            for connection, stamp, content in reader.messages(posed):
                pose = reader.deserialize(content, connection.msgtype)
                rows.append([1e-9 * stamp, *_pose(pose)])
    if not rows:
        raise InvalidInput(f"the topic {wanted} has no message")
    return dict(zip(_POSE, np.array(rows).T, strict=True))


def _pose(message: Any) -> tuple[float, ...]:
    """x, y and the quaternion of a message, however deep it keeps its pose."""
    pose = message
    while not hasattr(pose, "orientation") and not hasattr(pose, "rotation"):
        pose = pose.pose if hasattr(pose, "pose") else pose.transform
    place = getattr(pose, "position", None) or pose.translation
    turn = getattr(pose, "orientation", None) or pose.rotation
    return place.x, place.y, turn.x, turn.y, turn.z, turn.w


def _topic(given: str | None, connections: Sequence[Any]) -> str:
    """The topic that is told, else the one that has poses."""
    every = sorted({known.topic for known in connections})
    with_poses = {
        known.topic for known in connections if re.search(r"Pose|Odometry|Transform", known.msgtype)
    }
    topics = sorted(with_poses)
    wanted = given or (topics[0] if len(topics) == 1 else None)
    if wanted not in topics:
        have = ", ".join(topics) or f"none among {', '.join(every) or 'none'}"
        raise InvalidInput(
            f"give the topic of the object's pose, --columns pose=TOPIC; with poses: {have}"
        )
    return str(wanted)


def _mend_of_bag(error: Exception) -> str:
    if "Profile is not ros2" in str(error):
        return ": only MCAP of ROS 2 is; write what this one holds as a table of t,x,y,qx,qy,qz,qw"
    return ": one that was not closed is mended by rosbag reindex, ros2 bag reindex or mcap recover"
