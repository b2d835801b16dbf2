"""Cells of text, of a CSV file or of a sheet, as columns of numbers under the names above them."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from itertools import takewhile
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import require_room
from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.meaning import unit_word
from cyclemap.text_files import LARGEST_CONTENT, says_nothing

if TYPE_CHECKING:
    import pandas

Columns = dict[str, Array]
Cells = Sequence[Sequence[str]]

# Of columns of texts those that tell what was pushed on what are kept.
_TEXTS = re.compile(r"surface|object|shape|run|session|series", re.IGNORECASE)
# Fields of one number or more, and that say yes or no.
_NUMBER = re.compile(r"[-+]?[.,]*\d[-+\d.,eE;|\s]*")
_FLAGS = {
    **dict.fromkeys(("True", "true", "TRUE", "yes", "ja", "ok"), "1"),
    **dict.fromkeys(("False", "false", "FALSE", "no", "nein"), "0"),
}
# Names stand within so many rows, of which so many may hold numbers; a sheet with fewer rows of
# numbers is no table.
_LONGEST_HEADER = 40
_NUMBERS_IN_HEADERS = 3
_FEWEST_ROWS = 3
_SEPARATORS = (",", ";", "\t", "|", None)
_A_DAY = 86400.0


def text_columns(text: str) -> Columns:
    """Return the columns of a CSV file of any separator; where that is no comma, commas in numbers
    are decimal ones.
    """
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("sep=")]
    comments = list(takewhile(_is_comment, lines))
    bare = [line for line in lines if not _is_comment(line)]
    if len(bare) < 2:
        raise InvalidInput(f"{len(bare)} lines; a header and rows are wanted")
    tables = list[tuple[int, bool, Cells]]()
    # Names may stand behind the mark of a comment.
    for above in ([], comments[-1:]):
        for separator in _SEPARATORS:
            rows = _split([*above, *bare], separator)
            head = _header(rows)
            if head is not None and _fits(rows[head:], separator):
                tables.append((len(rows[head]), separator != ",", rows))
    if not tables:
        raise InvalidInput(
            "no names above its numbers: give it a first line such as "
            "x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg, or theta0_deg"
        )
    _, has_decimal_commas, rows = max(tables, key=lambda table: table[0])
    return cell_columns(rows, has_decimal_commas)


def _is_comment(line: str) -> bool:
    return line.startswith(("#", "%"))


def _split(lines: Sequence[str], separator: str | None) -> Cells:
    """Lines in fields; without a separator where blanks are."""
    bare = [line.lstrip("#% ") for line in lines]
    if separator is None:
        return [line.split() for line in bare]
    try:
        return list(csv.reader(bare, delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise InvalidInput(f"no rows of a table ({error})") from error


def _fits(rows: Cells, separator: str | None) -> bool:
    """Whether a separator that parts the names, the first row, parts the numbers below, too; blanks
    into as many.
    """
    if len(rows) == 1:
        return False
    names = len(rows[0])
    numbers = len(rows[1])
    return names == numbers if separator is None else (names > 1) == (numbers > 1)


def is_table(rows: Cells) -> bool:
    """Return whether rows of cells are names and numbers below."""
    return _header(rows) is not None and sum(map(_has_number, rows)) >= _FEWEST_ROWS


def _header(rows: Cells) -> int | None:
    """The row of the names: the last one of words alone before the rows of numbers begin."""
    with_numbers = 0
    head = None
    for index, row in enumerate(rows[:_LONGEST_HEADER]):
        with_numbers += _has_number(row)
        if with_numbers > _NUMBERS_IN_HEADERS:
            break
        words = [field for field in map(str.strip, row) if field != "-" and not says_nothing(field)]
        if not _has_number(row) and 2 * len(words) >= len(row):
            head = index
    return 0 if rows and with_numbers == 0 else head


def _has_number(row: Sequence[str]) -> bool:
    return any(_NUMBER.fullmatch(field.strip()) for field in row)


def cell_columns(rows: Cells, has_decimal_commas: bool = False) -> Columns:
    """Return the columns below a header of one row or several, the last of which may be units."""
    import pandas

    head = _header(rows)
    if head is None:
        raise InvalidInput("no names above its numbers")
    names = _names(rows[: head + 1])
    below = rows[head + 1 :]
    width = len(names)
    for row in below:
        if any(field.strip() for field in row[width:]):
            raise InvalidInput(f"{len(row)} fields below {width} names: {','.join(row)[:80]}")
    wide = f"has {len(below)} rows below {width} names"
    require_room(wide, len(below) * width, "leave columns out", LARGEST_CONTENT // 2)
    filled = [[*row[:width], *[""] * (width - len(row))] for row in below]
    frame = pandas.DataFrame(filled, columns=_counted(names))
    return number_columns(frame[[name for name in frame if name]], has_decimal_commas)


def _names(headings: Cells) -> list[str]:
    """The names that rows of headings tell: the last row's, with units that stand below them, and
    with the words above where they are there twice.
    """
    *above, last = [[field.strip() for field in row] for row in headings]
    names = last
    if above and all(unit_word(name) for name in last if name):
        pairs = zip(above.pop(), last, strict=False)
        names = [f"{name} [{unit.strip('[]()')}]" if unit else name for name, unit in pairs]
    while above and max(Counter(filter(None, names)).values(), default=1) > 1:
        # Each heading is over all fields up to the next.
        over = ""
        for index, word in enumerate([*above.pop(), *[""] * len(names)][: len(names)]):
            over = word or over
            names[index] = f"{over} {names[index]}" if over and names[index] else names[index]
    return names


def _counted(names: Sequence[str]) -> list[str]:
    """Names, of which those that are there twice are counted."""
    seen = Counter[str]()
    taken = set[str]()
    apart = list[str]()
    for name in names:
        own = name
        while name and own in taken:
            seen[name] += 1
            own = f"{name}.{seen[name]}"
        taken.add(own)
        apart.append(own)
    return apart


def number_columns(frame: pandas.DataFrame, has_decimal_commas: bool = False) -> Columns:
    """Return the columns of a frame as numbers, NaN where there is none, by their names with the
    unit that stands behind each number; texts as such where they tell what was pushed on what.

    Raises InvalidInput where no column has a number, or two have one name.
    """
    columns: Columns = {}
    for column in frame.columns:
        name, values = _numbers(str(column).strip(), frame[column], has_decimal_commas)
        if name in columns:
            raise InvalidInput(f"two columns are named {name}: rename one of them")
        columns[name] = values
    if not any(np.isfinite(own).any() for own in columns.values() if own.dtype.kind == "f"):
        raise InvalidInput(f"no column of numbers among {', '.join(columns)[:200]}")
    return columns


def _numbers(name: str, column: pandas.Series, has_decimal_commas: bool) -> tuple[str, Array]:
    """A column's name, with its unit, and its numbers."""
    import pandas

    if column.dtype.kind in "iufb":
        return name, column.to_numpy(dtype=float, na_value=math.nan)
    text = column.astype("string").str.strip()
    numbers = pandas.to_numeric(text.replace(_FLAGS), errors="coerce")
    unit = ""
    if numbers.isna().any():
        if _TEXTS.fullmatch(name):
            return name, column.to_numpy(dtype=object)
        numbers, unit = _written_out(name, text, numbers, has_decimal_commas)
    return f"{name}{unit}", numbers.to_numpy(dtype=float, na_value=math.nan)


def _written_out(
    name: str, text: pandas.Series, numbers: pandas.Series, has_decimal_commas: bool
) -> tuple[pandas.Series, str]:
    """Numbers with signs of thousands or decimal commas, or with a unit behind each, and that unit;
    moments and times of the day in seconds.
    """
    import pandas

    parts = text.str.extract(r"^([-+\d.,eE]+)\s*([^\d\s,.]*)$")
    units = set(parts[1].dropna())
    if len(units) == 1 and units <= {"", *filter(unit_word, units)}:
        (unit,) = units
        plain = _plain(name, parts[0], has_decimal_commas)
        return pandas.to_numeric(plain, errors="coerce"), f" [{unit}]" if unit else ""
    if numbers.notna().any():
        return numbers, ""
    moment = pandas.to_datetime(text, errors="coerce", format="ISO8601", utc=True)
    if moment.notna().any():
        return (moment - pandas.Timestamp(0, tz="UTC")).dt.total_seconds(), ""
    clock = pandas.to_timedelta(text, errors="coerce").dt.total_seconds()
    if clock.isna().all():
        return numbers, ""
    # Past midnight a clock begins anew.
    return clock + _A_DAY * (clock.diff() < -0.5 * _A_DAY).cumsum(), " [s]"


def _plain(name: str, numbers: pandas.Series, has_decimal_commas: bool) -> pandas.Series:
    """Numbers without signs of thousands, and with decimal points.

    One number with both signs tells what they are in all of a column; commas alone are decimal ones
    where a comma parts no fields, or where one parts no three digits.
    """

    def is_any(pattern: str) -> bool:
        return bool(numbers.str.contains(pattern, na=False).any())

    with_comma = numbers[numbers.str.contains(",", na=False, regex=False)]
    with_point = numbers[numbers.str.contains(".", na=False, regex=False)]
    has_points_for_thousands = is_any(r"\..*,") or (
        has_decimal_commas and len(with_comma) and with_point.str.fullmatch(_groups(".")).all()
    )
    if is_any(r",.*\."):
        thousands = ","
    elif has_points_for_thousands:
        thousands = "."
    elif has_decimal_commas or not with_comma.str.fullmatch(_groups(",")).all():
        thousands = ""
    elif not len(with_comma) or is_any(",.*,"):
        thousands = ","
    else:
        raise InvalidInput(
            f"is {with_comma.iloc[0]} of {name} more than a thousand, or a decimal fraction? "
            "Write its numbers without commas"
        )
    if thousands:
        sign = re.escape(thousands)
        numbers = numbers.str.replace(rf"{sign}(?=\d{{3}}(?:[.,]|$))", "", regex=True)
    return numbers if thousands == "," else numbers.str.replace(",", ".", regex=False)


def _groups(sign: str) -> str:
    """The pattern of numbers in groups of three digits."""
    return rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(sign)}\d{{3}})+"
