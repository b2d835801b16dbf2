"""The options that commands share, what they come to (which loop, which run), and what is said
against them.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.plain_text import plain_number, plain_whole, printable

if TYPE_CHECKING:
    from cyclemap.arrays import Array
    from cyclemap.evidence import Theta0Pairs
    from cyclemap.evidence.tables.conventions import Convention
    from cyclemap.evidence.tables.pose_streams import Segments
    from cyclemap.protocol.chosen_loop import LoopOptions


_QUIET = "cyclemap.quiet"
PATH = click.Path(path_type=Path)
Command = Callable[..., None]
Decorator = Callable[[Command], Command]


json_option = click.option(
    "--json",
    "json_target",
    metavar="FILE",
    help="Write JSON there; '-' prints JSON and nothing else.",
)
set_option = click.option(
    "--set",
    "settings",
    metavar="KEY=VALUE",
    multiple=True,
    help="One fact of the experiment; repeatable.",
)
select_option = click.option(
    "--select",
    metavar="KEY=VALUE",
    multiple=True,
    help="Keep data with surface, object, speed_mm_s, side, fraction or angle_deg of this value; "
    "repeatable.",
)


def seed_option(of: str) -> Decorator:
    """The option of the seed `of` something."""
    return click.option("--seed", type=Whole(min=0), default=0, help=of)


def out_option(of: str) -> Decorator:
    """The option of the folder where results go; `of` says which."""
    return click.option("--out", metavar="DIR", type=PATH, default="out", help=of)


def decorated(command: Command, *decorators: Decorator) -> Command:
    """Give `command` arguments and options, in this order."""
    for decorate in reversed(decorators):
        command = decorate(command)
    return command


def loop_options(command: Command, needs_material: bool = True) -> Command:
    """Give `command` MATERIAL and the options of a loop, which reach it as `options`, a
    `LoopOptions`.
    """

    @wraps(command)
    def chosen(
        material: str | None,
        material_file: str | None,
        protocol: Path | None,
        settings: tuple[str, ...],
        **others: object,
    ) -> None:
        has_one = (material is None) != (material_file is None)
        if not has_one and (needs_material or material is not None):
            raise click.UsageError(
                "give one material: a name or a TOML file, as MATERIAL or with --material"
            )
        from cyclemap.protocol.chosen_loop import LoopOptions

        command(options=LoopOptions(material or material_file, protocol, settings), **others)

    file = "A material file, in place of MATERIAL."
    tables = "The --set keys in TOML tables, and a [strategy]."
    return decorated(
        chosen,
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
    "--theta0-deg",
    metavar="LIST",
    default=",".join(map(str, range(0, 360, 30))),
    help="Start angles, by commas.",
)


@dataclass(frozen=True)
class RunOptions:
    """What a command that predicts a run of cycles was asked."""

    options: LoopOptions
    data: Path | None
    table: TableOptions
    cycles: int | None
    seed: int
    results: ResultOptions

    def pairs(self) -> Theta0Pairs | None:
        """The measured pairs of θ0, if any."""
        return measured_orientations(self.data, self.table, self.results.out)

    def run_beside(self, path: Array | None) -> dict[str, Any]:
        """Length, start and seed of the run: those of a measured path (rad), unless told
        otherwise.
        """
        from cyclemap.collection.portrait import DEFAULT_CYCLES

        length, start = (DEFAULT_CYCLES, 0.0) if path is None else (len(path) - 1, float(path[0]))
        return {"cycles": self.cycles or length, "start": start, "seed": self.seed}


def run_options(command: Command) -> Command:
    """Give `command`, which has those of a loop, the options of one that predicts a run of cycles:
    all of them reach it as asked, a `RunOptions`.
    """
    return decorated(
        gathered(command, "asked", RunOptions),
        click.option(
            "--data", metavar="DATA", type=PATH, help="Measured θ0 or pushes to set beside it."
        ),
        table_options,
        click.option(
            "--cycles",
            type=Whole(1, MOST_CYCLES),
            help="Length of the staircase. [default: 2000, or the data's]",
        ),
        seed_option("Seed of its noise."),
        result_options("COMMAND_MATERIAL.png and .json"),
    )


def said_command(*left_out: str, files_by_name: bool = False) -> list[str]:
    """The words of the command that runs, as they were said, without parameters that are left out.

    files_by_name : without the folders of files.
    """
    context = click.get_current_context()
    words = ["cyclemap", str(context.command.name)]
    for parameter in context.command.params:
        name = str(parameter.name)
        is_said = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if not is_said or name in left_out or name not in context.params:
            continue
        given = context.params[name]
        option = parameter.opts[:1]
        if isinstance(parameter, click.Argument):
            option = []
        if given is True:
            words += option
            continue
        for value in given if isinstance(given, tuple) else (given,):
            words += [
                *option,
                value.name if files_by_name and isinstance(value, Path) else str(value),
            ]
    return words


def pair_in_metres(option: str, text: str) -> tuple[float, float]:
    """The two lengths (m) of a text such as `350,-30`, mm.

    >>> pair_in_metres("--target-mm", "250, -30")
    (0.25, -0.03)
    """
    try:
        x, y = (1e-3 * plain_number(length.strip()) for length in text.split(","))
    except ValueError as cause:
        raise InvalidInput(f"{option} {text!r} is not of the form x,y, such as 350,-30") from cause
    return x, y


@dataclass(frozen=True)
class ResultOptions:
    """Where results go, and as what."""

    out: Path
    picture_format: str
    json_target: str | None


def gathered(command: Command, name: str, kind: type) -> Command:
    """Give `command` the options that are fields of `kind` as one object, called `name`."""

    @wraps(command)
    def gather(**given: object) -> None:
        own = {field.name: given.pop(field.name) for field in fields(kind)}
        command(**given, **{name: kind(**own)})

    return gather


def result_options(files: str) -> Decorator:
    """Give a command the options of where results go, and as what, which reach it as results, a
    `ResultOptions`; `files` names them in the help.
    """
    formats = click.Choice(["png", "pdf", "svg"])
    return lambda command: decorated(
        gathered(command, "results", ResultOptions),
        out_option(f"Where {files} go."),
        click.option(
            "--format", "picture_format", type=formats, default="png", help="Format of the picture."
        ),
        json_option,
    )


def quiet_option() -> click.Option:
    """The option of every command that leaves its words and its progress unsaid; see `is_quiet`."""

    def keep(context: click.Context, _: click.Parameter, value: bool) -> None:
        context.meta[_QUIET] = value

    words = "Say nothing but errors, warnings and --json."
    return click.Option(["--quiet"], is_flag=True, expose_value=False, callback=keep, help=words)


def is_quiet() -> bool:
    """Whether the command that runs was given --quiet."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.meta.get(_QUIET))


# Longer runs fill memory before they tell more.
MOST_CYCLES = 1_000_000


class _PlainDigits(click.ParamType):  # type: ignore[type-arg]
    """Numbers written in plain digits; a usage error for any other."""

    read: Callable[[str], float] = staticmethod(plain_number)

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Any:
        """Return the number."""
        try:
            given = self.read(value) if isinstance(value, str) else value
        except ValueError as error:
            self.fail(str(error), param, ctx)
        return super().convert(given, param, ctx)


class Whole(_PlainDigits, click.IntRange):
    """A whole number of a range."""

    read = staticmethod(plain_whole)


class Real(_PlainDigits, click.types.FloatParamType):
    """Any number."""


class RealRange(_PlainDigits, click.FloatRange):
    """A number of a range, which has no nan."""

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Any:
        """Return the number."""
        converted = super().convert(value, param, ctx)
        if math.isnan(converted):
            self.fail("nan is in no range", param, ctx)
        return converted


@dataclass(frozen=True)
class TableOptions:
    """What is said of a table: its columns and units as they were typed, and how it counts angles
    and lays its axes.
    """

    columns: str | None = None
    units: str | None = None
    angles: str | None = None
    frame: str | None = None
    offset_deg: float | None = None

    @property
    def convention(self) -> dict[str, Any]:
        """The keywords of readers that tell how angles are counted and axes laid."""
        return {"angles": self.angles, "frame": self.frame, "offset_deg": self.offset_deg}


def table_options(command: Command) -> Command:
    """Give `command` the options that tell what data mean: they reach it as table, a
    `TableOptions`.
    """
    named = (
        "What a column of an own table is, by commas: theta0=yaw,theta_next=yaw_after; "
        "pose=TOPIC of a bag, sheet=NAME of a workbook."
    )
    senses = click.Choice(["counter-clockwise", "clockwise", "compass"])
    return decorated(
        gathered(command, "table", TableOptions),
        click.option("--columns", metavar="NAME=COLUMN,...", help=named),
        click.option(
            "--units",
            metavar="UNITS",
            help="Of angles, lengths, times: deg, turn, mm, ms, ... by commas.",
        ),
        click.option(
            "--angles",
            type=senses,
            help="How data count them, from above; compass: clockwise from y. [default: counter-]",
        ),
        click.option(
            "--frame",
            type=click.Choice(["right-handed", "mirrored", "swapped"]),
            help="How data lay axes, from above: mirrored has y the other way, as pictures do; "
            "swapped y before x.",
        ),
        click.option(
            "--offset-deg", type=Real(), help="Orientation of the object where the data say 0."
        ),
    )


def told_columns(columns: str | None, units: str | None) -> tuple[dict[str, str], list[str]]:
    """What --columns and --units say; InvalidInput where they cannot be read."""
    named = {}
    for pair in filter(str.strip, (columns or "").split(",")):
        name, _, column = (word.strip() for word in pair.partition("="))
        if not (name and column):
            raise InvalidInput(f"--columns {columns}: give it as theta0=yaw,theta_next=yaw_after")
        named[name] = column
    return named, [unit.strip() for unit in (units or "").split(",") if unit.strip()]


def tell_what_was_read(words: Sequence[str], guessed: bool) -> None:
    """Say it on stderr; on a terminal ask whether a guess is right,
    InvalidInput where it is not."""
    for line in words:
        click.echo(line, err=True)
    if (
        guessed
        and sys.stdin.isatty()
        and not click.confirm("Is that right?", default=True, err=True)
    ):
        raise InvalidInput("say what the columns are: --columns theta0=NAME,... --units deg,mm")


def readable_data(data: Path, table: TableOptions, out: Path) -> Path:
    """The data, or a table of them under `out` that every command reads, after saying on stderr
    what was read.
    """
    from cyclemap.evidence.tables.conventions import as_read_name, convention_of
    from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
    from cyclemap.evidence.tables.planned_table import filled_text
    from cyclemap.protocol.collection_file import data_table
    from cyclemap.text_files import file_stem, write_whole

    said = {key: value for key, value in table.convention.items() if value is not None}
    said = {**data_table(data), **said}
    words: Sequence[str] = ()
    guessed = False
    kind = file_kind(data)
    if kind is FileKind.PLANNED:
        if any(vars(table).values()):
            raise InvalidInput(
                f"{data}: a table of planned pushes tells its columns, units and angles: leave "
                "these out"
            )
        target = out / f"{file_stem(data.stem)}_as_read.csv"
        text, words = filled_text(data)
    elif table.columns is not None or table.units is not None or kind is FileKind.OTHER:
        target = out / as_read_name(file_stem(data.stem), said)
        text, words, guessed = _own_text(data, table, out)
    elif said:
        target = out / as_read_name(file_stem(data.stem), said)
        text = _in_our_convention(data, convention_of(data, **table.convention))
    else:
        return data
    tell_what_was_read((*words, f"written as {target}"), guessed)
    write_whole(target, text.encode())
    return target


def _own_text(data: Path, table: TableOptions, out: Path) -> tuple[str, Sequence[str], bool]:
    """A table of people's own as CSV, what was read as what, and whether that was guessed; a
    stream of poses is drawn as it was cut.
    """
    from cyclemap.evidence.tables.own_tables import read_own_table
    from cyclemap.evidence.tables.pose_streams import UnclearStream
    from cyclemap.text_files import file_stem

    motions = out / f"{file_stem(data.stem)}_motions.png"
    columns, units = told_columns(table.columns, table.units)
    try:
        own = read_own_table(data, columns, units, **table.convention)
    except UnclearStream as error:
        picture = _pictured(error.seen, motions)
        raise UnclearStream(f"{error}; picture: {picture}", error.seen) from error
    words = list(own.words)
    if own.segments is not None:
        words.append(f"picture: {_pictured(own.segments, motions)}")
    return own.csv_text(), words, own.guessed


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


def _in_our_convention(data: Path, convention: Convention) -> str:
    """A table of ours, or the pushes of files in the MIT layout, as CSV in our convention."""
    from cyclemap.evidence.pushes.push_table import load_pushes
    from cyclemap.evidence.tables.columns import known_columns, our_names, our_text
    from cyclemap.evidence.tables.data_kinds import is_csv
    from cyclemap.text_files import read_csv_table

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


def _pictured(seen: Segments, path: Path) -> Path:
    """Draw how a stream of poses was cut, and return where."""
    from cyclemap.text_files import write_whole
    from cyclemap.views.panels.layout import render
    from cyclemap.views.push_pages import stream_page

    write_whole(path, render(stream_page(seen), "png"))
    return path


def measured_orientations(data: Path | None, table: TableOptions, out: Path) -> Theta0Pairs | None:
    """The pairs of θ0 that data in any form tell; None without data."""
    if data is None:
        return None
    from cyclemap.evidence.comparison.collection_data import measured_pairs

    return measured_pairs(readable_data(data, table, out))


# Letters of a line: what repeats its input may go on for ever.
_LONGEST = 4000
_told: list[str] = []


def one_line(message: str) -> str:
    """Return a message as one line that a terminal can show."""
    line = printable(" ".join(message.split()))
    return (
        line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"
    )


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
