"""`cyclemap reset`: three lines and a few rows, as JSON, a picture, a protocol and a schedule."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from cyclemap.cli.json_numbers import degrees, number
from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.settings import chosen_collection
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.mechanics import load_material
from cyclemap.resets import (
    CycleAction,
    MaterialRange,
    ResetDemands,
    ResetDesign,
    ResetRow,
    ResetStrategy,
    design_reset,
    material_range,
    write_protocol,
    write_schedule,
)
from cyclemap.views import reset_sentences as sentences
from cyclemap.views.reset_page import COLUMNS, reset_page, row_cells
from cyclemap.views.sentences import material_line
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole


@dataclass(frozen=True)
class ResetRequest:
    """What is asked of `cyclemap reset` besides the loop, in the units of the command line."""

    allow_tv: float
    extra_tv: float
    within: int
    drag_ratio: float
    reach_mm: float | None
    seconds: float | None
    least_push_mm: float | None
    abilities: tuple[str, ...]
    keep_push: bool
    axes_percent: float
    offsets_percent: float
    likely: tuple[str, ...]
    pushes: int
    cycles: int
    seed: int
    out: Path
    picture_format: str

    @property
    def demands(self) -> ResetDemands:
        """The demands in SI units."""
        reach, contact = (None if value is None else 1e-3 * value for value in (self.reach_mm, self.least_push_mm))
        kept = (self.allow_tv, self.extra_tv, self.within, self.drag_ratio)
        return ResetDemands(*kept, self.seconds, reach, contact, self.abilities, self.keep_push, self.pushes)


def run_reset(options: LoopOptions, request: ResetRequest, json_target: str | None) -> None:
    """Design the reset, write picture, protocol, schedule and JSON, and print for people or as JSON."""
    asked, demands = chosen_collection(options), request.demands
    about = material_range(asked.loop.material, 0.01 * request.axes_percent, 0.01 * request.offsets_percent)
    if request.likely:
        about = MaterialRange(about.nominal, tuple(map(load_material, request.likely)), ", ".join(request.likely))
    sigma = DEFAULT_SIGMA if asked.sigma is None else asked.sigma
    with ExitStack() as bars:
        shown: dict[str, Callable[[float], None]] = {}

        def report(stage: str, done: float) -> None:
            if stage not in shown:
                bars.close()
                shown[stage] = bars.enter_context(progress_bar(stage))
            shown[stage](done)

        design = design_reset(
            asked.loop, demands, sigma=sigma, materials=about, given=asked.strategy, seed=request.seed, progress=report
        )
    stem = request.out / f"reset_{file_stem(asked.loop.material.name)}"
    picture, protocol, schedule = (
        stem.with_name(f"{stem.name}.{end}") for end in (request.picture_format, "toml", "csv")
    )
    told = reset_report(design, protocol, schedule)
    write_protocol(protocol, design.loop, design.chosen.strategy, noise=sigma, predicted=_predicted(design.chosen))
    write_schedule(schedule, design.loop, design.chosen.strategy, request.cycles, request.seed)
    write_whole(picture, render(reset_page(design), request.picture_format))
    write_json(stem.with_name(f"{stem.name}.json"), told)
    if not publish_json(told, json_target):
        _print_for_people(design, (picture, protocol, schedule))


def reset_report(design: ResetDesign, protocol: Path, schedule: Path) -> Json:
    """The report as JSON: mm, degrees and seconds, every number finite or null; the chosen row is the first."""
    demands = design.demands
    return {
        "material": design.loop.material.name,
        "noise_deg": degrees(design.sigma),
        "demands": {
            "allow_tv": demands.allow_tv,
            "extra_tv": demands.extra_tv,
            "within": demands.within,
            "drag_ratio": demands.drag_ratio,
            "seconds": demands.seconds,
            "reach_mm": None if demands.reach is None else 1e3 * demands.reach,
            "least_push_mm": None if demands.contact is None else 1e3 * demands.contact,
            "abilities": list(demands.abilities),
            "keep_push": demands.keep_push,
            "pushes": demands.pushes,
        },
        "range": {
            "told": design.about.told,
            "materials": [one.name for one in (*design.about.materials, *design.tried)],
        },
        "met": design.met,
        "reasons": list(sentences.miss_sentences(design)),
        "considered": design.considered,
        "left_out_too_steep": design.too_steep,
        "independent_histogram_distance": design.independent,
        "histogram_distance_by_order": design.orders,
        "friction_error": {"ratio": design.ratio_errors.tolist(), "tv": design.ratio_tv.tolist()},
        "rows": [_row(design, row) for row in design.rows],
        "protocol": str(protocol),
        "schedule": str(schedule),
    }


def _predicted(row: ResetRow) -> dict[str, float]:
    """What a protocol file carries along."""
    return {
        "tv": row.nominal.total_variation,
        "tv_after": row.nominal.after,
        "within": row.nominal.pushes,
        "worst_tv": row.worst,
        "worst_tv_after": row.worst_after,
        "histogram_distance": row.histogram[0],
        "mean_drag_mm": 1e3 * row.drag,
    }


def _row(design: ResetDesign, row: ResetRow) -> Json:
    strategy = row.strategy
    return {
        "roles": list(row.roles),
        "recipe": sentences.recipe(strategy),
        "order": strategy.order,
        "actions": actions_report(strategy, design),
        "hitch_mm": None if strategy.hitch is None else [1e3 * part for part in strategy.hitch],
        **_predicted(row),
        "tv_error": number(row.nominal.error),
        "worst_material": row.worst_material.name,
        "histogram_spread": row.histogram[1],
        "worst_histogram_distance": row.worst_histogram[0],
        "seconds": row.seconds,
        "reach_mm": 1e3 * row.room,
        "shortest_contact_mm": 1e3 * row.contact,
        "misses": list(row.misses),
        "lacking": list(row.lacking),
    }


def actions_report(strategy: ResetStrategy, design: ResetDesign) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares."""
    prepared = strategy.prepared(design.loop)
    shares = zip(strategy.actions, strategy.shares.tolist(), strict=True)
    return [action_report(action.filled(prepared), action, share) for action, share in shares]


def action_report(filled: CycleAction, action: CycleAction, share: float) -> Json:
    """An action, filled in by its loop, with its share of the cycles."""
    assert filled.push is not None and filled.way_points is not None
    return {
        "name": sentences.action_words(action),
        "weight": number(share),
        "side": filled.push.side,
        "fraction": number(filled.push.fraction),
        "angle_deg": degrees(filled.push.angle),
        "push_mm": number(1e3 * filled.push.distance),
        "way_points_mm": [[number(1e3 * x), number(1e3 * y)] for x, y in filled.way_points],
        "gripper_turn_deg": degrees(filled.turn),
    }


def _print_for_people(design: ResetDesign, files: tuple[Path, ...]) -> None:
    console = PeopleConsole()
    for sentence in sentences.miss_sentences(design):
        console.print(sentence, style="bold red")
    for place, sentence in enumerate(sentences.design_sentences(design)):
        console.print(sentence, style=None if place else "bold")
    console.print_table(rows_table(design))
    if told := material_line(design.loop.material):
        console.print(told)
    for name, path in zip(("picture", "protocol", "schedule"), files, strict=True):
        console.print(f"{name}: {path}")


def rows_table(design: ResetDesign) -> Table:
    """The rows beside the chosen one: what one would ask about."""
    table = Table(title="Beside it", title_justify="left")
    for place, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if place < 2 else "right", no_wrap=place > 1)
    for row in design.rows[1:]:
        table.add_row(*row_cells(design, row))
    return table
