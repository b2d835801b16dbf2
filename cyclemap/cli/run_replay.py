"""`cyclemap replay`: recorded pushes replayed; errors by object in a table, all as JSON, and as a picture."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.table import Table

from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.replay_report import replay_report
from cyclemap.cli.run_fit import selected_values
from cyclemap.cli.settings import chosen_loop, told_settings
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.errors import CycleMapError
from cyclemap.evidence.replay.replay_table import DATASET_PUSHER, ReplayedPushes, replay_pushes
from cyclemap.evidence.replay.shapes import dataset_sliders
from cyclemap.views.replay_page import replay_headline, replay_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

# Files left out are told by name up to this many, and counted beyond.
MOST_NAMED = 10
COLUMNS = (
    "surface", "object", "pushes", "error (mm)", "median", "isotropic", "motion (mm)", "share",
    "turn error (°)", "median", "isotropic",
    "turn (°)", "share",
)  # fmt: skip


@dataclass(frozen=True)
class ReplayRequest:
    """What is asked of the replay: which data, the rod's friction where it is named, and where results go."""

    data: Path
    select: tuple[str, ...]
    pusher_friction: float | None
    out: Path
    picture_format: str


def run_replay(options: LoopOptions, request: ReplayRequest, json_target: str | None) -> None:
    """Replay the pushes, write picture and JSON, and print for people or as JSON."""
    loop, told = chosen_loop(options, request.data)[0], told_settings(options, request.data)[1]
    material, pusher = loop.material, loop.pusher
    found = material.found_with.pusher_friction
    if request.pusher_friction is not None or ("pusher_mu" not in told and found is None):
        named = request.pusher_friction
        pusher = replace(pusher, friction=DATASET_PUSHER.friction if named is None else named)
    sliders = {**dataset_sliders(), file_stem(loop.slider.name): loop.slider}
    with progress_bar(f"replaying {request.data.name}") as report:
        replayed = replay_pushes(
            request.data,
            material.friction,
            pusher=pusher,
            sliders=sliders,
            plates=material.plates,
            frames=material.frames,
            select=selected_values(request.select),
            progress=report,
        )
    if not replayed.replays:
        raise CycleMapError(f"{request.data}: no push could be replayed: {_reasons(replayed)}")
    report_json = replay_report(replayed, material.name, pusher.friction)
    stem = f"replay_{file_stem(material.name)}"
    write_json(request.out / f"{stem}.json", report_json)
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(replay_page(replayed, material.name), request.picture_format))
    if not publish_json(report_json, json_target):
        _print_for_people(replayed, picture)


def _reasons(replayed: ReplayedPushes) -> str:
    left_out = replayed.not_replayed
    told = "; ".join(f"{file.path}: {file.reason}" for file in left_out[:MOST_NAMED])
    return told + (f"; and {len(left_out) - MOST_NAMED} files more" if len(left_out) > MOST_NAMED else "")


def _print_for_people(replayed: ReplayedPushes, picture: Path) -> None:
    console = PeopleConsole()
    console.print(replay_headline(replayed), style="bold")
    table = Table(title="Error at the end, by object (means)", title_justify="left")
    for number, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if number < 2 else "right")
    for row in replayed.by("surface", "object").to_dict("records"):
        table.add_row(*_cells(row))
    console.print_table(table)
    if replayed.not_replayed:
        console.print(f"not replayed: {_reasons(replayed)}")
    console.print(f"picture: {picture}")


def _cells(row: dict[Any, Any]) -> tuple[str, ...]:
    return (
        str(row["surface"]),
        str(row["object"]),
        str(row["count"]),
        *(f"{1e3 * row[name]:.2f}" for name in ("mean_error", "median_error", "isotropic_mean_error")),
        f"{1e3 * row['mean_motion']:.1f}",
        f"{100 * row['relative_error']:.0f} %",
        *(
            f"{math.degrees(row[name]):.2f}"
            for name in ("mean_turn_error", "median_turn_error", "isotropic_mean_turn_error")
        ),
        f"{math.degrees(row['mean_turn']):.1f}",
        f"{100 * row['relative_turn_error']:.0f} %",
    )
