"""The options that commands share, what they come to (which loop, which run), and what is said against them."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.plain_text import plain_number, plain_whole, printable

if TYPE_CHECKING:
    from cyclemap.evidence import Theta0Pairs


_QUIET = "cyclemap.quiet"
PATH: Any = click.Path(path_type=Path)
Command = Callable[..., None]


@dataclass(frozen=True)
class LoopOptions:
    """Which loop a command is about; material: None where none was named, which stands for isotropic friction."""

    material: str | None
    protocol: Path | None
    settings: tuple[str, ...]


json_option = click.option(
    "--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else."
)
set_option = click.option(
    "--set", "settings", metavar="KEY=VALUE", multiple=True, help="One fact of the experiment; repeatable."
)
select_option = click.option(
    "--select",
    metavar="KEY=VALUE",
    multiple=True,
    help="Keep data with surface, object, speed_mm_s, side, fraction or angle_deg of this value; repeatable.",
)


def decorated(command: Command, *decorators: Callable[[Any], Any]) -> Command:
    """Give `command` arguments and options, in this order."""
    for decorate in reversed(decorators):
        command = decorate(command)
    return command


def loop_options(command: Command, needs_material: bool = True) -> Command:
    """Give `command` MATERIAL and the options of a loop, which reach it as `options`, a `LoopOptions`."""

    @wraps(command)
    def gathered(
        material: str | None, material_file: str | None, protocol: Path | None, settings: tuple[str, ...], **others: Any
    ) -> None:
        one = (material is None) != (material_file is None)
        if not one and (needs_material or material is not None):
            raise click.UsageError("give one material: a name or a TOML file, as MATERIAL or with --material")
        command(options=LoopOptions(material or material_file, protocol, settings), **others)

    file, tables = "A material file, in place of MATERIAL.", "The --set keys in TOML tables, and a [strategy]."
    return decorated(
        gathered,
        click.argument("material", required=False),
        click.option("--material", "material_file", metavar="TOML", help=file),
        click.option("--protocol", metavar="TOML", type=PATH, help=tables),
        set_option,
    )


def protocol_options(command: Command) -> Command:
    """The same where the material may be left out."""
    return loop_options(command, needs_material=False)


# Start angles, every 30 degrees by default.
theta0_option = click.option(
    "--theta0-deg", metavar="LIST", default=",".join(map(str, range(0, 360, 30))), help="Start angles, by commas."
)


def run_options(command: Command) -> Command:
    """Give `command` the options of a command that predicts a run of cycles."""
    return decorated(
        command,
        click.option("--data", metavar="DATA", type=PATH, help="Measured θ0 or pushes to set beside it."),
        table_options,
        click.option(
            "--cycles", type=Whole(1, MOST_CYCLES), help="Length of the staircase. [default: 2000, or the data's]"
        ),
        click.option("--seed", type=Whole(min=0), default=0, help="Seed of its noise."),
        result_options("COMMAND_MATERIAL.png and .json"),
    )


def result_options(files: str) -> Callable[[Command], Command]:
    """Give a command the options of where results go, and as what; `files` names them in the help."""
    formats = click.Choice(["png", "pdf", "svg"])
    return lambda command: decorated(
        command,
        click.option("--out", metavar="DIR", type=PATH, default="out", help=f"Where {files} go."),
        click.option("--format", "picture_format", type=formats, default="png", help="Format of the picture."),
        json_option,
    )


def quiet_option() -> click.Option:
    """The option of every command that leaves its words and its progress unsaid; see `is_quiet`."""

    def keep(context: click.Context, _: click.Parameter, value: bool) -> None:
        context.meta[_QUIET] = value

    told = "Say nothing but errors, warnings and --json."
    return click.Option(["--quiet"], is_flag=True, expose_value=False, callback=keep, help=told)


def is_quiet() -> bool:
    """Whether the command that runs was given --quiet."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.meta.get(_QUIET))


# Longer runs fill memory before they tell more.
MOST_CYCLES = 1_000_000


class Whole(click.IntRange):
    """A whole number of a range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; a usage error for other than plain digits."""
        return super().convert(_plain(self, plain_whole, value, param, ctx), param, ctx)


class Real(click.FloatRange):
    """A number of a range, which has no nan, or any where no range is given."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; a usage error for other than plain digits."""
        found = super().convert(_plain(self, plain_number, value, param, ctx), param, ctx)
        if math.isnan(found) and (self.min is not None or self.max is not None):
            self.fail("nan is in no range", param, ctx)
        return found


def _plain(kind: Whole | Real, read: Any, value: Any, param: Any, ctx: Any) -> Any:
    try:
        return read(value) if isinstance(value, str) else value
    except ValueError as error:
        kind.fail(str(error), param, ctx)


def table_options(command: Command) -> Command:
    """Give `command` the options that tell what the columns of a table are: they reach it as columns and units."""
    named = "What a column of an own table is, by commas: theta0=yaw,theta_next=yaw_after; pose=TOPIC for a bag."
    return decorated(
        command,
        click.option("--columns", metavar="NAME=COLUMN,...", help=named),
        click.option("--units", metavar="UNITS", help="Of angles, lengths, times: deg, mm, ms, ... by commas."),
    )


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
    from cyclemap.text_files import file_stem, write_whole

    if columns is None and units is None and not is_own(data):
        return data
    found = read_own_table(data, *told_columns(columns, units))
    target = out / f"{file_stem(data.stem)}_as_read.csv"
    tell_what_was_read((*found.words, f"written as {target}"), found.guessed)
    write_whole(target, found.csv_text().encode())
    return target


def measured_orientations(data: Path | None, columns: str | None, units: str | None, out: Path) -> Theta0Pairs | None:
    """The pairs of θ0 that data in any form tell; None without data."""
    if data is None:
        return None
    from cyclemap.evidence.comparison.collection_data import measured_pairs

    return measured_pairs(readable_data(data, columns, units, out))


# Letters of a line: what repeats its input may go on for ever.
_LONGEST = 4000
_told: list[str] = []


def one_line(message: str) -> str:
    """Return a message as one line that a terminal can show."""
    line = printable(" ".join(message.split()))
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def warnings_so_far() -> list[str]:
    """The doubts that this command has told."""
    return list(_told)


@contextmanager
def told_warnings() -> Iterator[None]:
    """Tell each doubt about the input once, as long as the block lasts."""
    _told.clear()

    def show(message: Warning | str, category: type[Warning], *place: object) -> None:
        line = one_line(str(message))
        if line not in _told:
            _told.extend([line] if issubclass(category, DoubtfulInput) else [])
            click.echo(f"warning: {line}", err=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", DoubtfulInput)
        warnings.showwarning = show  # type: ignore[assignment]
        yield
