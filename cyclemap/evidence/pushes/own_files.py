"""The columns of a file of numbers as it names them: CSV of any house, Excel, LeRobot's parquet,
poses of a ROS bag.
"""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import require_room
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.columns import QUATERNION, unit_word
from cyclemap.file_text import located
from cyclemap.plain_text import install_words, json_value
from cyclemap.text_files import LARGEST_CONTENT, read_bytes, read_text

if TYPE_CHECKING:
    import pandas

Columns = dict[str, Array]

EXCEL, PARQUET, BAGS = (".xlsx", ".xlsm"), (".parquet",), (".bag", ".db3", ".mcap")
JSON_LINES = (".jsonl", ".ndjson")
# Of columns of texts those that tell what was pushed on what are kept.
_TEXTS = re.compile(r"surface|object|shape|run|session|series", re.IGNORECASE)
# Fields of one number or more, of one with a decimal comma, and that say nothing, or yes and no.
_NUMBER = re.compile(r"[-+]?[.,]*\d[-+\d.,eE;|\s]*")
_DECIMAL = re.compile(r"^\s*([-+]?\d*),(\d+(?:[eE][-+]?\d+)?)\s*$")
_EMPTY = ("", "nan", "na", "null", "none", "-")
_FLAGS = {
    **dict.fromkeys(("True", "true", "TRUE", "yes", "ja", "ok"), "1"),
    **dict.fromkeys(("False", "false", "FALSE", "no", "nein"), "0"),
}
# Names stand within so many rows, of which so many may hold numbers; a sheet with fewer rows of
# numbers is no table.
_LONGEST_HEADER, _NUMBERS_IN_HEADERS, _FEWEST_ROWS = 40, 3, 3
_A_DAY = 86400.0
# Bytes of a spreadsheet, or of parquet as doubles: both pack a thousand times what they show on
# disk.
_LARGEST_DECODED = 2**26


def raw_columns(path: Path, told: Mapping[str, str], growing: bool) -> Columns:
    """The columns of a file, by its own names, NaN where a field is empty; `growing`: without an
    unfinished line.
    """
    with located(str(path), DataFileError):
        return _columns(path, told, growing)


def _columns(path: Path, told: Mapping[str, str], growing: bool) -> Columns:
    """The columns of a file of any kind; InvalidInput where it has none."""
    kind = path.suffix.lower()
    if path.is_dir() and (path / "meta" / "info.json").is_file():
        return _lerobot(path)
    if not path.is_dir() and not path.is_file():
        pipe = "is a pipe or a device; give a regular file"
        raise InvalidInput(pipe if path.exists() else "there is no such file; check the path")
    if path.is_dir() or kind in BAGS:
        return _bag(path, told.get("pose"))
    if kind in PARQUET:
        return _parquet([path])
    if kind in EXCEL:
        return _excel(path, told.get("sheet"))
    text = _text(path)
    text = text[: text.rfind("\n") + 1] if growing else text
    return _json(path, text) if kind in (*JSON_LINES, ".json") else _csv(text)


def _text(path: Path) -> str:
    """The text of a file, in UTF-16 where its first bytes say so, else in UTF-8 or, failing that,
    as older programs of Windows write.
    """
    content = read_bytes(path)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = content.decode("utf-16", errors="replace")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _excel(path: Path, told: str | None) -> Columns:
    """The sheet of a workbook that is told, else the one that has a table of numbers."""
    import pandas

    _library("openpyxl", "excel")
    # zipfile, zlib, XML, openpyxl, pandas: each has its own kinds of error.
    with _refused_as("a spreadsheet"):
        with ZipFile(path) as parts:
            _check_size(sum(part.file_size for part in parts.infolist()))
        read = pandas.read_excel(path, sheet_name=None, header=None, dtype=object)
    sheets = {str(name): frame.fillna("").astype(str).to_numpy() for name, frame in read.items()}
    if told is None:
        tables = []
        for name, cells in sheets.items():
            rows = cells.tolist()
            if _header(rows) is not None and sum(map(_has_number, rows)) >= _FEWEST_ROWS:
                tables.append(name)
        if len(tables) > 1:
            mend = f"say which, --columns sheet={tables[0]}"
            raise InvalidInput(f"has numbers in the sheets {', '.join(tables)}: {mend}")
        told = tables[0] if tables else next(iter(sheets))
    if told not in sheets:
        raise InvalidInput(f"no sheet {told}; it has {', '.join(sheets)}")
    return _named(sheets[told].tolist())


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
    flat = [dict(_flat("", row)) for row in rows]
    if len(flat) < 2:
        mend = 'give [{"theta0_deg": 12.5, ...}, ...], {"theta0_deg": [12.5, ...], ...}'
        raise InvalidInput(f"{len(flat)} rows; more are wanted: {mend}, or a row a line")
    _check_size(8 * len(flat) * len({name for row in flat for name in row}))
    return _numbers(pandas.DataFrame(flat))


def _json_rows(whole: object) -> list[dict[str, object]]:
    """The rows of a JSON document, as pandas and others write them; none where it has none."""
    if isinstance(whole, list):
        return whole if all(isinstance(row, dict) for row in whole) else []
    if not isinstance(whole, dict):
        return []
    names, data = whole.get("columns"), whole.get("data")
    if isinstance(names, list) and isinstance(data, list):
        if not all(isinstance(row, list) for row in data):
            return []
        return [dict(zip(map(str, names), row, strict=False)) for row in data]
    columns = {name: _in_a_row(values) for name, values in whole.items()}
    known = {name: values for name, values in columns.items() if len(values) > 1}
    if len(known) == 1:
        (only,) = known.values()
        if all(isinstance(row, dict) for row in only):
            return only
    if len({len(values) for values in known.values()}) != 1:
        return []
    return [dict(zip(known, row, strict=True)) for row in zip(*known.values(), strict=True)]


def _in_a_row(values: object) -> list[Any]:
    """The values of a list, or of an object whose keys count its rows; of anything else none."""
    if isinstance(values, dict) and all(key.isdecimal() for key in values):
        return [values[key] for key in sorted(values, key=int)]
    return values if isinstance(values, list) else []


def _json_lines(path: Path, text: str) -> list[dict[str, object]]:
    """A row of JSON a line."""
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
        rows.append(row)
    return rows


def _flat(name: str, value: object) -> Iterator[tuple[str, object]]:
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _flat(f"{name}_{key}" if name else str(key), one)
    elif isinstance(value, list):
        for number, one in enumerate(value):
            yield from _flat(f"{name}[{number}]", one)
    else:
        yield name, value


# -- text


def _csv(text: str) -> Columns:
    """A CSV file of any separator; where that is no comma, commas in numbers are decimal ones."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("sep=")]
    said = list(takewhile(_is_comment, lines))
    bare = [line for line in lines if not _is_comment(line)]
    if len(bare) < 2:
        raise InvalidInput(f"{len(bare)} lines; a header and rows are wanted")
    try:
        # Names may stand behind the mark of a comment.
        tables = [
            rows
            for above in ([], said[-1:])
            for separator in (",", ";", "\t", "|", None)
            if _fits_its_names(rows := _split([*above, *bare], separator), separator is None)
        ]
    except csv.Error as error:
        raise InvalidInput(f"no rows of a table ({error})") from error
    if not tables:
        first = "x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg, or theta0_deg"
        raise InvalidInput(f"no names above its numbers: give it a first line such as {first}")
    return _named(max(tables, key=lambda rows: len(rows[_header(rows) or 0])))


def _is_comment(line: str) -> bool:
    return line.startswith(("#", "%"))


def _split(lines: Sequence[str], separator: str | None) -> list[list[str]]:
    """Lines in fields; without a separator where blanks are."""
    lines = [line.lstrip("#% ") for line in lines]
    if separator is None:
        return [line.split() for line in lines]
    rows = list(csv.reader(lines, delimiter=separator, skipinitialspace=True))
    if separator == ",":
        return rows
    # A comma that parts no fields is a decimal one.
    return [[_DECIMAL.sub(r"\1.\2", field) for field in row] for row in rows]


def _fits_its_names(rows: Sequence[Sequence[str]], strictly: bool) -> bool:
    """Whether a separator that parts the names parts the numbers below, too; strictly: into as
    many.
    """
    head = _header(rows)
    if head is None or head + 1 == len(rows):
        return False
    names, numbers = (len(row) for row in rows[head : head + 2])
    return names == numbers if strictly else (names > 1) == (numbers > 1)


def _header(rows: Sequence[Sequence[str]]) -> int | None:
    """The row of the names: the last one of words alone before the rows of numbers begin."""
    numeric, found = 0, None
    for index, row in enumerate(rows[:_LONGEST_HEADER]):
        numeric += _has_number(row)
        if numeric > _NUMBERS_IN_HEADERS:
            break
        words = [field for field in row if field.strip().lower() not in _EMPTY]
        if not _has_number(row) and 2 * len(words) >= len(row):
            found = index
    return 0 if rows and numeric == 0 else found


def _has_number(row: Sequence[str]) -> bool:
    return any(_NUMBER.fullmatch(field.strip()) for field in row)


def _named(rows: Sequence[Sequence[str]]) -> Columns:
    """The columns below a header of one row or several, the last of which may be units."""
    import pandas

    head = _header(rows)
    if head is None:
        raise InvalidInput("no names above its numbers")
    names = [field.strip() for field in rows[head]]
    above = head - 1
    if head and all(unit_word(name) for name in names if name):
        units, names = names, [field.strip() for field in rows[above]]
        pairs = zip(names, units, strict=False)
        names = [f"{name} [{unit.strip('[]()')}]" if unit else name for name, unit in pairs]
        above -= 1
    while above >= 0 and len(set(filter(None, names))) < len(list(filter(None, names))):
        upper = _spread_right(rows[above], len(names))
        names = [
            f"{word} {name}" if word and name else name
            for word, name in zip(upper, names, strict=True)
        ]
        above -= 1
    width = len(names)
    for row in rows[head + 1 :]:
        if any(field.strip() for field in row[width:]):
            told = ",".join(row)[:80]
            raise InvalidInput(f"{len(row)} fields below {width} names: {told}")
    wide = f"has {len(rows)} rows below {width} names"
    require_room(wide, len(rows) * width, "leave columns out", LARGEST_CONTENT // 2)
    filled = [[*row[:width], *[""] * (width - len(row))] for row in rows[head + 1 :]]
    frame = pandas.DataFrame(filled, columns=_told_apart(names))
    return _numbers(frame[[name for name in frame.columns if name]])


def _spread_right(row: Sequence[str], width: int) -> list[str]:
    """A row of headings, each over all fields up to the next."""
    filled, last = [], ""
    for field in [*row, *[""] * width][:width]:
        last = field.strip() or last
        filled.append(last)
    return filled


def _told_apart(names: Sequence[str]) -> list[str]:
    """Names, of which those that are there twice are counted."""
    seen, taken = Counter[str](), set[str]()
    apart = []
    for name in names:
        own = name
        while name and own in taken:
            seen[name] += 1
            own = f"{name}.{seen[name]}"
        taken.add(own)
        apart.append(own)
    return apart


# -- numbers


def _numbers(frame: pandas.DataFrame) -> Columns:
    import pandas

    found: Columns = {}
    for name in frame.columns:
        column = frame[name]
        if column.dtype.kind in "iufb":
            found[str(name).strip()] = column.to_numpy(dtype=float, na_value=math.nan)
            continue
        text = column.astype("string").str.strip()
        parsed = pandas.to_numeric(text.replace(_FLAGS), errors="coerce")
        if _TEXTS.fullmatch(str(name).strip()) and parsed.isna().any():
            found[str(name).strip()] = column.to_numpy(dtype=object)
            continue
        unit = ""
        if parsed.isna().any():
            parsed, unit = _written_out(text, parsed)
        found[f"{str(name).strip()}{unit}"] = parsed.to_numpy(dtype=float, na_value=math.nan)
    if not any(np.isfinite(values).any() for values in found.values() if values.dtype.kind == "f"):
        raise InvalidInput(f"no column of numbers among {', '.join(map(str, frame.columns))[:200]}")
    return found


def _written_out(text: pandas.Series, parsed: pandas.Series) -> tuple[pandas.Series, str]:
    """Numbers with signs of thousands or decimal commas, or with a unit behind each, and that unit;
    moments and times of the day in seconds.
    """
    import pandas

    parts = text.str.extract(r"^([-+\d.,eE]+)\s*([^\d\s,.]*)$")
    units = set(parts[1].dropna())
    if len(units) == 1 and units <= {"", *filter(unit_word, units)}:
        # One number with both tells what the commas of a column are.
        if parts[0].str.contains(r",.*\.", regex=True).any():
            plain = parts[0].str.replace(r",(?=\d{3}(?:[.,]|$))", "", regex=True)
        else:
            plain = parts[0].str.replace(",", ".", regex=False)
        (unit,) = units
        return pandas.to_numeric(plain, errors="coerce"), f" [{unit}]" if unit else ""
    if parsed.notna().any():
        return parsed, ""
    moment = pandas.to_datetime(text, errors="coerce", format="ISO8601", utc=True)
    if moment.notna().any():
        return (moment - pandas.Timestamp(0, tz="UTC")).dt.total_seconds(), ""
    clock = pandas.to_timedelta(text, errors="coerce").dt.total_seconds()
    # Past midnight a clock begins anew.
    if clock.isna().all():
        return parsed, ""
    return clock + _A_DAY * (clock.diff() < -0.5 * _A_DAY).cumsum(), " [s]"


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
        frames = [pandas.read_parquet(file) for file in files]
        # An index that has a name is a column.
        frames = [one.reset_index(drop=one.index.name is None) for one in frames]
        frame = pandas.concat(frames, ignore_index=True)
    found: Columns = {}
    for column in frame.columns:
        values = frame[column]
        if values.dtype.kind in "iufb":
            found[column] = values.to_numpy(dtype=float)
        elif values.dtype.kind == "M":
            begun = pandas.Timestamp(0, tz=values.dt.tz)
            found[column] = (values - begun).dt.total_seconds().to_numpy()
        elif _TEXTS.fullmatch(column):
            found[column] = values.fillna("").astype(str).to_numpy(dtype=object)
        elif len({np.shape(row) for row in values}) == 1 and np.ndim(values.iloc[0]) == 1:
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
    place = path / "meta" / "info.json"
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
