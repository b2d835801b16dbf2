"""Data of one's own as commands take them: their options, what was read said, and a table that every command reads."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import decorated
from cyclemap.errors import InvalidInput


def table_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give `command` the options that tell what the columns of a table are: they reach it as columns and units."""
    named = "What a column of an own table is, by commas: theta0=yaw,theta_next=yaw_after; pose=TOPIC for a bag."
    decorators: list[Callable[[Any], Any]] = [
        click.option("--columns", metavar="NAME=COLUMN,...", help=named),
        click.option("--units", metavar="UNITS", help="Of its angles and lengths: deg or rad, mm, cm or m, by commas."),
    ]
    return decorated(command, decorators)


def told_columns(columns: str | None, units: str | None) -> tuple[dict[str, str], list[str]]:
    """What --columns and --units say; InvalidInput where they cannot be read."""
    told = {}
    for part in filter(str.strip, (columns or "").split(",")):
        name, _, column = (word.strip() for word in part.partition("="))
        if not (name and column):
            raise InvalidInput(f"--columns {columns}: give it as theta0=yaw,theta_next=yaw_after")
        told[name] = column
    return told, [unit.strip() for unit in (units or "").split(",") if unit.strip()]


def tell_what_was_read(words: Sequence[str], guessed: bool) -> None:
    """Say it on stderr; on a terminal ask whether a guess is right, InvalidInput where it is not."""
    for line in words:
        click.echo(line, err=True)
    if guessed and sys.stdin.isatty() and not click.confirm("Is that right?", default=True, err=True):
        raise InvalidInput("say what the columns are: --columns theta0=NAME,... --units deg,mm")


def readable_data(data: Path, columns: str | None, units: str | None, out: Path) -> Path:
    """The data, or a table of them under `out` that every command reads, after saying on stderr what was read."""
    from cyclemap.evidence.pushes.own_tables import is_own, read_own_table
    from cyclemap.whole_files import file_stem, write_whole

    if columns is None and units is None and not is_own(data):
        return data
    found = read_own_table(data, *told_columns(columns, units))
    target = out / f"{file_stem(data.stem)}_as_read.csv"
    tell_what_was_read((*found.words, f"written as {target}"), found.guessed)
    write_whole(target, found.csv_text().encode())
    return target
