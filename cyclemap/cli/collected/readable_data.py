"""The data that a command is given, in whatever form, as files that every reader takes; what was
read as what is said.
"""

import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from cyclemap.cli.options import TableOptions, is_quiet
from cyclemap.cli.output import data_stem
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.evidence import UnreadableFile, load_pushes
from cyclemap.evidence.tables.columns import (
    Convention,
    as_read_name,
    convention_of,
    known_columns,
    our_names,
    our_text,
)
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind, is_csv
from cyclemap.evidence.tables.own_tables import read_own_table
from cyclemap.evidence.tables.planned_table import filled_text
from cyclemap.evidence.tables.pose_streams import Segments, UnclearStream
from cyclemap.plain_text import key_and_value, number_or_nan
from cyclemap.protocol.collection_file import data_table
from cyclemap.text_files import read_csv_table, write_whole
from cyclemap.views.panels.layout import render
from cyclemap.views.push_pages import stream_page
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, Json, Unit, written

# What a push changes, what is known of it, and what these are written in.
UNITS = {"dtheta": DEGREES, "dx": MILLIMETRES, "dy": MILLIMETRES}
# The same where the unit is said elsewhere.
PLAIN_UNITS = {name: Unit("", unit.of_si) for name, unit in UNITS.items()}
FACT_UNITS = {
    "surface": NUMBER,
    "object": NUMBER,
    "acceleration": Unit("mm_s2", MILLIMETRES.of_si),
    "speed": Unit("mm_s", MILLIMETRES.of_si),
    "side": NUMBER,
    "fraction": NUMBER,
    "angle": DEGREES,
}
# Facts by which pushes are selected, and the names of these in the files.
SELECT_KEYS = {
    unit.named(fact): fact for fact, unit in FACT_UNITS.items() if fact != "acceleration"
} | {"shape": "object"}
# Bad files are told by name up to this many, and counted beyond.
MOST_NAMED = 10


def readable_data(data: Path, table: TableOptions, out: Path) -> Path:
    """The data, or a table of them under `out` that every command reads, after saying on stderr
    what was read.
    """
    said = {key: value for key, value in table.convention.items() if value is not None}
    said = {**data_table(data), **said}
    words: Sequence[str] = ()
    guessed = False
    kind = file_kind(data)
    if not (said or table.columns or table.units or kind in (FileKind.PLANNED, FileKind.OTHER)):
        return data
    stem = data_stem(data)
    if kind is FileKind.PLANNED:
        if any(vars(table).values()):
            raise InvalidInput(
                f"{data}: a table of planned pushes tells its columns, units and angles: leave "
                "these out"
            )
        target = out / f"{stem}_as_read.csv"
        text, words = filled_text(data)
    elif kind is FileKind.RECORDS and (table.columns or table.units):
        raise InvalidInput(
            f"{data}: files in the MIT layout tell their columns and units: leave --columns and "
            "--units out"
        )
    elif table.columns or table.units or kind is FileKind.OTHER:
        target = out / as_read_name(stem, said)
        text, words, guessed = _own_text(data, table, out / f"{stem}_motions.png")
    else:
        target = out / as_read_name(stem, said)
        text = _in_our_convention(data, convention_of(data, **table.convention))
    tell_what_was_read((*words, f"written as {target}"), guessed)
    write_whole(target, text.encode())
    return target


def readable_tables(paths: Sequence[Path], table: TableOptions, out: Path) -> list[Path]:
    """`readable_data` of several; InvalidInput where two would be one, or one is written over
    another.
    """
    read: dict[Path, Path] = {}
    for path in paths:
        target = readable_data(path, table, out)
        if target in read:
            what = (
                "is given twice"
                if path == read[target]
                else f"has the name of {read[target]}: both become {target}"
            )
            raise InvalidInput(f"{path} {what}; give each once, under a name of its own")
        read[target] = path
    return list(read)


def tell_what_was_read(words: Sequence[str], guessed: bool) -> None:
    """Say it on stderr, unless --quiet; on a terminal ask whether a guess is right, InvalidInput
    where it is not.
    """
    if is_quiet():
        return
    for line in words:
        click.echo(line, err=True)
    if (
        guessed
        and sys.stdin.isatty()
        and not click.confirm("Is that right?", default=True, err=True)
    ):
        raise InvalidInput("say what the columns are: --columns theta0=NAME,... --units deg,mm")


def _own_text(data: Path, table: TableOptions, motions: Path) -> tuple[str, Sequence[str], bool]:
    """A table of people's own as CSV, what was read as what, and whether that was guessed; a
    stream of poses is drawn, as it was cut into `motions`.
    """
    try:
        own = read_own_table(data, table.named_columns, table.named_units, **table.convention)
    except UnclearStream as error:
        _draw(error.seen, motions)
        raise UnclearStream(f"{error}; picture: {motions}", error.seen) from error
    words = list(own.words)
    if own.segments is not None:
        _draw(own.segments, motions)
        words.append(f"picture: {motions}")
    return own.csv_text(), words, own.guessed


def _draw(segments: Segments, path: Path) -> None:
    write_whole(path, render(stream_page(segments), "png"))


def _in_our_convention(data: Path, convention: Convention) -> str:
    """A table of ours, or the pushes of files in the MIT layout, as CSV in our convention."""
    if is_csv(data) and data.is_file():
        table = read_csv_table(data)
        rows = convention.rows(known_columns(table))
        return our_text({name: rows[name] for name in our_names(table.header)})
    offset = math.degrees(convention.offset)
    pushes = load_pushes(
        data, angles=convention.angles, frame=convention.frame, offset_deg=offset
    ).table
    known = pushes.drop(columns=["path", "line", "samples", "dx", "dy"])
    return our_text(known.to_dict("series"))


def selected_values(pairs: tuple[str, ...]) -> dict[str, str | float]:
    """The columns and values of `key=value` texts, in SI units and radians; `shape` is another word
    for `object`.

    >>> selected_values(("surface=plywood", "speed_mm_s=20"))
    {'surface': 'plywood', 'speed': 0.02}
    """
    values: dict[str, str | float] = {}
    for pair in pairs:
        key, text = key_and_value("--select", pair)
        if key not in SELECT_KEYS:
            raise unknown_name("selection", key, SELECT_KEYS)
        column = SELECT_KEYS[key]
        values[column] = text
        if column not in ("surface", "object"):
            values[column] = value = number_or_nan(text) / FACT_UNITS[column].of_si(1.0)
            if not math.isfinite(value):
                raise InvalidInput(f"--select {key}={text}: give a finite number")
    return values


def reasons_of(left_out: Sequence[UnreadableFile]) -> list[str]:
    """Why files and rows were left out, the first reasons with their file, the others counted."""
    reasons = Counter(f"{file.path}: {file.reason}" for file in left_out)
    first = list(reasons.items())[:MOST_NAMED]
    named = [reason if count == 1 else f"{reason} ({count} times)" for reason, count in first]
    more = len(left_out) - sum(count for _, count in first)
    return [*named, f"and {more} more"] if more > 0 else named


def facts_report(facts: Mapping[str, object], *left_out: str) -> Json:
    """What the pushes of a set share, None where it is not known."""
    return {
        unit.named(name): written(facts.get(name), unit)
        for name, unit in FACT_UNITS.items()
        if name not in left_out
    }
