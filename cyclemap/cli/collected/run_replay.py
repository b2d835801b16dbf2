"""`cyclemap replay`: recorded pushes replayed; errors by object in a table, all as JSON, and as a
picture.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from cyclemap.cli.commands import ReplayOptions
from cyclemap.cli.json_report import FACT_UNITS
from cyclemap.cli.output import (
    file_stem,
    people_table,
    progress_bar,
    publish,
    result_stem,
)
from cyclemap.cli.readable_data import readable_data, reasons_of, selected_values
from cyclemap.errors import CycleMapError
from cyclemap.evidence.comparison.replay_table import (
    DATASET_PUSHER,
    ReplayedPushes,
    dataset_sliders,
    replay_pushes,
)
from cyclemap.mechanics.plate_footprint import plate_note
from cyclemap.views.push_pages import replay_headline, replay_page
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, Json, degrees, rows, written

if TYPE_CHECKING:
    import pandas

COLUMNS = (
    "surface",
    "object",
    "pushes",
    "error (mm)",
    "median",
    "isotropic",
    "motion (mm)",
    "share",
    "turn error (°)",
    "median",
    "isotropic",
    "turn (°)",
    "share",
)


def run_replay(asked: ReplayOptions) -> None:
    """Replay the pushes, write picture and JSON, and print for people or as JSON; the rod's
    friction may be named.
    """
    chosen = asked.loop.chosen_loop(asked.data)
    loop = chosen.loop
    material = chosen.loop.material
    identified = material.found_with.pusher_friction
    friction = asked.pusher_friction
    if friction is None and "pusher_mu" not in chosen.settings and identified is None:
        friction = DATASET_PUSHER.friction
    if friction is not None:
        loop = replace(loop, pusher=replace(loop.pusher, friction=friction))
    sliders = {**dataset_sliders(), file_stem(loop.slider.name): loop.slider}
    read = readable_data(asked.data, asked.table, asked.results.out)
    selected = selected_values(asked.select)
    with progress_bar(f"replaying {asked.data.name}") as report:
        replayed = replay_pushes(read, loop, select=selected, progress=report)
    reasons = "; ".join(reasons_of(replayed.not_replayed))
    if not replayed.replays:
        raise CycleMapError(f"{asked.data}: no push could be replayed: {reasons}")
    seen = [name for name in replayed.table["object"].unique() if name in sliders]
    notes = [
        note for name in seen if (note := plate_note(material, replace(sliders[name], name=name)))
    ]
    errors_table = people_table("Error at the end, by object (means)", COLUMNS, words=(0, 1))
    for row in replayed.by("surface", "object").to_dict("records"):
        errors_table.add_row(*_cells(row))
    publish(
        replay_report(replayed, material.name, loop.pusher.friction, notes),
        replay_page(replayed, material.name),
        result_stem(asked.results.out, "replay", loop),
        asked.results,
        replay_headline(replayed),
        errors_table,
        *(f"note: {note}" for note in notes),
        f"not replayed: {reasons}" if reasons else "",
    )


def _cells(row: Mapping[str, Any]) -> list[str]:
    """The mean errors of an object on a surface: of the place, then of the turn."""
    cells = [str(row["surface"]), str(row["object"]), str(row["count"])]
    for error, motion, relative in (
        ("error", "mean_motion", "relative_error"),
        ("turn_error", "mean_turn", "relative_turn_error"),
    ):
        names = (f"mean_{error}", f"median_{error}", f"isotropic_mean_{error}")
        cells += [f"{_UNITS[name].of_si(row[name]):.2f}" for name in names]
        cells += [f"{_UNITS[motion].of_si(row[motion]):.1f}", f"{100 * row[relative]:.0f} %"]
    return cells


# What columns of the replays are written in, where it is not as measured.
_LENGTHS = (
    "error",
    "rms_error",
    "measured_motion",
    "predicted_motion",
    "shift",
    "start_gap",
    "straightness",
    "mean_error",
    "median_error",
    "mean_motion",
    "mean_rms_error",
    "isotropic_error",
    "isotropic_mean_error",
)
_TURNS = (
    "turn_error",
    "rms_turn_error",
    "measured_turn",
    "predicted_turn",
    "mean_turn_error",
    "median_turn_error",
    "mean_turn",
    "isotropic_turn_error",
    "isotropic_mean_turn_error",
)
_UNITS = FACT_UNITS | dict.fromkeys(_LENGTHS, MILLIMETRES) | dict.fromkeys(_TURNS, DEGREES)


def replay_report(
    replayed: ReplayedPushes, material: str, pusher_friction: float, notes: list[str]
) -> Json:
    """The replays of a collection: the groups by object and by speed, every push, and the files
    left out.
    """
    error, turn_error = replayed.mean_errors
    return {
        "material": material,
        "pusher_friction": pusher_friction,
        "pushes": len(replayed.table),
        "mean_error_mm": written(error, MILLIMETRES),
        "mean_turn_error_deg": degrees(turn_error),
        "notes": notes,
        "by_object": _rows(replayed.by("surface", "object")),
        "by_speed": _rows(replayed.by("speed")),
        "replays": _rows(replayed.table),
        "not_replayed": written(replayed.not_replayed),
    }


def _rows(table: "pandas.DataFrame") -> list[Json]:
    units = {name: _UNITS.get(name, NUMBER) for name in map(str, table)}
    return rows(**{unit.named(name): written(table[name], unit) for name, unit in units.items()})
