"""What commands can be asked: fields that a command line fills, the groups of them that commands
share, and what is said against what was typed.
"""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import Field, dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_origin

import click
from click.core import ParameterSource

from cyclemap.errors import DoubtfulInput, InvalidInput
from cyclemap.plain_text import key_and_value, plain_number, plain_whole, printable

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from cyclemap.evidence import MeasuredStaircase, Theta0Pairs
    from cyclemap.protocol.chosen_loop import ChosenCollection

    Measured = Theta0Pairs | MeasuredStaircase | None

_ONE_MATERIAL = "give one material: a name or a TOML file, as MATERIAL or with --material"
Default = TypeVar("Default")
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


# What a field of a type is read as; a tuple is a repeated option, or an argument of many words.
_READERS = {Path: click.Path(path_type=Path), int: Whole(), float: Real()}


def option(help: str, default: Default, name: str = "", **settings: object) -> Default:
    """Return a field that an option fills, named after it or by `name`; settings are Click's."""
    return field(default=default, metadata={"name": name, "help": help, **settings})


def seed_option(of: str) -> int:
    """Return the field of the seed `of` something."""
    return option(of, 0, type=Whole(min=0))


def out_option(of: str) -> Path:
    """Return the field of the folder where results go; `of` says which."""
    return option(of, Path("out"), metavar="DIR")


def settings_option() -> tuple[str, ...]:
    """Return the field of settings by their keys."""
    return option("One fact of the experiment; repeatable.", (), "--set", metavar="KEY=VALUE")


def json_option() -> str | None:
    """Return the field that tells where JSON goes."""
    return option("Write JSON there; '-' prints JSON and nothing else.", None, metavar="FILE")


def select_option() -> tuple[str, ...]:
    """Return the field of the facts by which data are selected."""
    return option(
        "Keep data with surface, object, speed_mm_s, side, fraction or angle_deg of this value; "
        "repeatable.",
        (),
        metavar="KEY=VALUE",
    )


def group(about: str) -> Any:
    """Return a field that is a class of options; `about`: see `parameters`."""
    return field(metadata={"help": about})


def argument(**settings: object) -> Any:
    """Return a field that an argument fills, as one does of which nothing is said; settings are
    Click's.
    """
    return field(metadata=settings)


def parameters(kind: "type[DataclassInstance]", about: str = "") -> Iterator[click.Parameter]:
    """The parameters that fill a class of options, in order, and those that fill its fields which
    are such classes; `about`: what stands in their helps where these leave a place.
    """
    for place in fields(kind):
        settings = dict(place.metadata)
        inner = _inner_options(place)
        if inner is not None:
            yield from parameters(inner, settings.get("help", ""))
            continue
        kinds = {place.type, *get_args(place.type)}
        is_many = get_origin(place.type) is tuple
        reader = next((_READERS[each] for each in kinds if each in _READERS), None)
        settings.setdefault("type", reader)
        if "help" not in settings:
            yield click.Argument([place.name], nargs=-1 if is_many else 1, **settings)
            continue
        if bool in kinds:
            settings["is_flag"] = True
        if place.default is not None and not settings.get("required"):
            settings["default"] = place.default
        name = settings.pop("name") or f"--{place.name.replace('_', '-')}"
        settings["help"] = settings["help"].replace("{}", about)
        yield click.Option([name, place.name], multiple=is_many, **settings)


def _inner_options(place: "Field[object]") -> "type[DataclassInstance] | None":
    """The class of options that a field holds, if it does."""
    kind = place.type
    return kind if isinstance(kind, type) and is_dataclass(kind) else None


def filled(kind: "type[DataclassInstance]", given: Mapping[str, object]) -> object:
    """Return a class of options with what was given for its parameters, by their names."""
    values = {}
    for place in fields(kind):
        inner = _inner_options(place)
        values[place.name] = given[place.name] if inner is None else filled(inner, given)
    return kind(**values)


@dataclass(frozen=True, kw_only=True)
class ProtocolOptions:
    """Which loop a command is about; without a material it is on isotropic friction."""

    material: str | None = argument(required=False)
    material_file: str | None = option(
        "A material file, in place of MATERIAL.", None, "--material", metavar="TOML"
    )
    protocol: Path | None = option(
        "The --set keys in TOML tables, and a [strategy].", None, metavar="TOML"
    )
    settings: tuple[str, ...] = settings_option()

    def __post_init__(self) -> None:
        if self.material is not None and self.material_file is not None:
            raise click.UsageError(_ONE_MATERIAL)

    @property
    def surface(self) -> str | None:
        """The material's name or file."""
        return self.material or self.material_file

    def chosen_collection(self, data: Path | None = None) -> "ChosenCollection":
        """What is asked for; what the folder of the data says holds where nothing else is said."""
        from cyclemap.protocol.chosen_loop import chosen_collection

        return chosen_collection(self.surface, self.protocol, self.settings, data)

    def chosen_loop(self, data: Path | None = None) -> "ChosenCollection":
        """The same; InvalidInput where it is not one loop."""
        from cyclemap.protocol.chosen_loop import chosen_loop

        return chosen_loop(self.surface, self.protocol, self.settings, data)


@dataclass(frozen=True, kw_only=True)
class LoopOptions(ProtocolOptions):
    """The same where a material has to be given."""

    def __post_init__(self) -> None:
        if (self.material is None) == (self.material_file is None):
            raise click.UsageError(_ONE_MATERIAL)


@dataclass(frozen=True, kw_only=True)
class TableOptions:
    """What is said of a table: its columns and units as they were typed, and how it counts angles
    and lays its axes.
    """

    columns: str | None = option(
        "What a column of an own table is, by commas: theta0=yaw,theta_next=yaw_after; pose=TOPIC "
        "of a bag, sheet=NAME of a workbook.",
        None,
        metavar="NAME=COLUMN,...",
    )
    units: str | None = option(
        "Of angles, lengths, times: deg, turn, mm, ms, ... by commas.", None, metavar="UNITS"
    )
    angles: str | None = option(
        "How data count them, from above; compass: clockwise from y. [default: counter-clockwise]",
        None,
        type=click.Choice(["counter-clockwise", "clockwise", "compass"]),
    )
    frame: str | None = option(
        "How data lay axes, from above: mirrored has y the other way, as pictures do; swapped y "
        "before x.",
        None,
        type=click.Choice(["right-handed", "mirrored", "swapped"]),
    )
    offset_deg: float | None = option("Orientation of the object where the data say 0.", None)

    @property
    def convention(self) -> dict[str, Any]:
        """The keywords of readers that tell how angles are counted and axes laid."""
        return {"angles": self.angles, "frame": self.frame, "offset_deg": self.offset_deg}

    @property
    def named_columns(self) -> dict[str, str]:
        """Columns by what they are; InvalidInput where that cannot be read."""
        named = {}
        for pair in words_of(self.columns or ""):
            name, column = key_and_value("--columns", pair, "theta0=yaw,theta_next=yaw_after")
            named[name] = column
        return named

    @property
    def named_units(self) -> list[str]:
        """The units, in the order in which they were given."""
        return words_of(self.units or "")


@dataclass(frozen=True, kw_only=True)
class ResultOptions:
    """Where results go, and as what."""

    out: Path = out_option("Where {} go.")
    format: str = option("Format of the picture.", "png", type=click.Choice(["png", "pdf", "svg"]))
    json: str | None = json_option()


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What a command that predicts a run of cycles was asked."""

    loop: LoopOptions
    data: Path | None = option("Measured θ0 or pushes to set beside it.", None, metavar="DATA")
    table: TableOptions
    cycles: int | None = option(
        "Length of the staircase. [default: 2000, or the data's]", None, type=Whole(1, MOST_CYCLES)
    )
    seed: int = seed_option("Seed of its noise.")
    results: ResultOptions = group("COMMAND_MATERIAL.png and .json")

    def run_beside(self, measured: "Measured") -> dict[str, Any]:
        """Length, start and seed of the run: those of a measured path, unless told otherwise."""
        length, start = length_and_start(measured)
        return {"cycles": self.cycles or length, "start": start, "seed": self.seed}


def length_and_start(measured: "Measured") -> tuple[int, float]:
    """Cycles, and θ0 (rad), of a run beside a measured path, or of one alone."""
    from cyclemap.collection.portrait import DEFAULT_CYCLES

    path = None if measured is None else measured.path
    return (DEFAULT_CYCLES, 0.0) if path is None else (len(path) - 1, float(path[0]))


def is_said(parameter: str) -> bool:
    """Whether the command that runs was given this parameter, by the name of its field."""
    context = click.get_current_context()
    return context.get_parameter_source(parameter) is ParameterSource.COMMANDLINE


def said_command(*left_out: str, files_by_name: bool = False) -> list[str]:
    """The words of the command that runs, as they were said, without parameters that are left out.

    files_by_name : without the folders of files.
    """
    context = click.get_current_context()
    words = ["cyclemap", str(context.command.name)]
    for parameter in context.command.params:
        name = str(parameter.name)
        if not is_said(name) or name in (*left_out, "quiet"):
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
        x, y = (plain_number(length.strip()) for length in text.split(","))
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError("not finite")
    except ValueError as cause:
        raise InvalidInput(f"{option} {text!r} is not of the form x,y, such as 350,-30") from cause
    return 1e-3 * x, 1e-3 * y


def words_of(text: str) -> list[str]:
    """The words of a list by commas.

    >>> words_of("deg, mm,")
    ['deg', 'mm']
    """
    return [word.strip() for word in text.split(",") if word.strip()]


# Of every command: it leaves words and progress unsaid.
QUIET = click.Option(
    ["--quiet"], is_flag=True, help="Say nothing but errors, warnings and the JSON asked for."
)


def is_quiet() -> bool:
    """Whether the command that runs was given --quiet."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.params.get("quiet"))


# Letters of a line: what repeats its input may go on for ever.
_LONGEST = 4000
_doubts: list[str] = []


def one_line(message: str) -> str:
    """Return a message as one line that a terminal can show."""
    line = printable(" ".join(message.split()))
    return (
        line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"
    )


def warnings_so_far() -> list[str]:
    """The doubts about the input that this command has told."""
    return list(_doubts)


@contextmanager
def shown_warnings() -> Iterator[None]:
    """Tell each doubt about the input once, as long as the block lasts."""
    _doubts.clear()

    def show(message: Warning | str, category: type[Warning], *place: object) -> None:
        line = one_line(str(message))
        if line not in _doubts:
            _doubts.extend([line] if issubclass(category, DoubtfulInput) else [])
            click.echo(f"warning: {line}", err=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", DoubtfulInput)
        warnings.showwarning = show  # type: ignore[assignment]
        yield
