"""The command `cyclemap reset`: three lines and a few rows, as JSON, a picture, a protocol and a schedule."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.cli.options import LoopOptions, Real, Whole, decorated, loop_options, result_options

if TYPE_CHECKING:
    from cyclemap.mechanics import Material
    from cyclemap.resets import MaterialRange, ResetDesign

_SHARE = Real(min=0.0, max=1.0, min_open=True, max_open=True)
_ABOVE_ZERO = Real(min=0.0, min_open=True)
_PERCENT = Real(min=0.0, max=100.0, max_open=True)
_SHOWN: dict[str, Any] = {"show_default": True}


def _reset_options(command: Callable[..., None]) -> Callable[..., None]:
    tv = "Most total variation of θ0 from uniform, in the long run, at the worst of the range."
    held = "Shortest way of the rod in contact, in every push.  [default: two thirds of the push, else one]"
    more = "What the robot can do besides: put the ring elsewhere, turn the object. Repeatable."
    able: dict[str, Any] = {"type": click.Choice(["ring", "gripper"]), "multiple": True}
    axes = "How much one axis of friction may be longer against the other.  [default: the material's posterior, or 10]"
    offsets = "How much m0 and n0 may vary.  [default: the material's posterior, or 50]"
    likely = "A material as likely as MATERIAL, in place of these percentages. Repeatable."
    decorators: list[Callable[[Any], Any]] = [
        click.option("--allow-tv", type=_SHARE, default=0.10, help=tv, **_SHOWN),
        click.option("--extra-tv", type=_SHARE, default=0.02, help="More after --within pushes.", **_SHOWN),
        click.option("--within", type=Whole(1, 10_000), default=50, help="Pushes from the worst start.", **_SHOWN),
        click.option("--drag-ratio", type=_ABOVE_ZERO, default=2.0, help="Most mean drag, in those of now.", **_SHOWN),
        click.option("--reach-mm", type=_ABOVE_ZERO, help="Most distance of rod or object from the target."),
        click.option("--seconds", type=_ABOVE_ZERO, help="Most mean time of a cycle."),
        click.option("--least-push-mm", type=_ABOVE_ZERO, help=held),
        click.option("--with", "abilities", help=more, **able),
        click.option("--keep-push", is_flag=True, help="Change only the way back: every push stays the loop's own."),
        click.option("--axes-percent", type=_PERCENT, help=axes),
        click.option("--offsets-percent", type=_ABOVE_ZERO, help=offsets),
        click.option("--likely", metavar="MATERIAL", multiple=True, help=likely),
        click.option("--pushes", type=Whole(1, 10_000), default=500, help="How many to collect.", **_SHOWN),
        click.option("--cycles", type=Whole(1, 10_000_000), default=2000, help="Schedule's length.", **_SHOWN),
        click.option("--seed", type=Whole(min=0), default=0, help="Seed of the schedule.", **_SHOWN),
        result_options("reset_MATERIAL.png and .json, the protocol (.toml) and the schedule (.csv)"),
    ]
    return decorated(command, decorators)


@click.command("reset")
@loop_options
@_reset_options
def reset_command(
    options: LoopOptions,
    json_target: str | None,
    out: Path,
    picture_format: str,
    cycles: int,
    seed: int,
    reach_mm: float | None,
    least_push_mm: float | None,
    axes_percent: float | None,
    offsets_percent: float | None,
    likely: tuple[str, ...],
    **wanted: Any,
) -> None:
    """Find a reset that spreads θ0 uniformly on MATERIAL and its likes, and write it as protocol and schedule."""
    from cyclemap.cli.output import file_stem, progress_bar, publish
    from cyclemap.cli.reset_report import predicted, reset_report
    from cyclemap.cli.settings import chosen_collection
    from cyclemap.collection.portrait import DEFAULT_SIGMA
    from cyclemap.resets import ResetDemands, design_reset, write_protocol, write_schedule
    from cyclemap.views.reset_page import reset_page

    reach, contact = (None if length is None else 1e-3 * length for length in (reach_mm, least_push_mm))
    asked, demands = chosen_collection(options), ResetDemands(reach=reach, contact=contact, **wanted)
    about = _range_of(asked.loop.material, axes_percent, offsets_percent, likely)
    sigma = DEFAULT_SIGMA if asked.sigma is None else asked.sigma
    with ExitStack() as bars:
        shown: dict[str, Callable[[float], None]] = {}

        def report(stage: str, done: float) -> None:
            if stage not in shown:
                bars.close()
                shown[stage] = bars.enter_context(progress_bar(stage))
            shown[stage](done)

        design = design_reset(
            asked.loop, demands, sigma=sigma, materials=about, given=asked.strategy, seed=seed, progress=report
        )
    stem, strategy = out / f"reset_{file_stem(asked.loop.material.name)}", design.chosen.strategy
    protocol, schedule = (stem.with_name(f"{stem.name}.{end}") for end in ("toml", "csv"))
    write_protocol(protocol, design.loop, strategy, noise=sigma, predicted=predicted(design.chosen))
    write_schedule(schedule, design.loop, strategy, cycles, seed)
    report_json = reset_report(design, protocol, schedule)
    picture = publish(report_json, reset_page(design), stem, picture_format, json_target)
    if picture is not None:
        _print_for_people(design, {"picture": picture, "protocol": protocol, "schedule": schedule})


def _range_of(material: Material, axes: float | None, offsets: float | None, likely: tuple[str, ...]) -> MaterialRange:
    from cyclemap.mechanics import load_material
    from cyclemap.resets import MaterialRange, material_range

    about = material_range(material, *(None if percent is None else 0.01 * percent for percent in (axes, offsets)))
    if not likely:
        return about
    return MaterialRange(about.nominal, tuple(map(load_material, likely)), ", ".join(likely))


def _print_for_people(design: ResetDesign, files: dict[str, Path]) -> None:
    from rich.table import Table

    from cyclemap.cli.terminal import PeopleConsole
    from cyclemap.views.reset_sentences import COLUMNS, design_sentences, miss_sentences, row_cells
    from cyclemap.views.sentences import material_line

    console = PeopleConsole()
    for sentence in miss_sentences(design):
        console.print(sentence, style="bold red")
    console.tell(*design_sentences(design))
    table = Table(title="Beside it", title_justify="left")
    for place, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if place < 2 else "right", no_wrap=place > 1)
    for row in design.rows[1:]:
        table.add_row(*row_cells(row))
    console.print_table(table)
    if told := material_line(design.loop.material):
        console.print(told)
    for name, path in files.items():
        console.print(f"{name}: {path}")
