"""Recorded pushes: `cyclemap replay` runs them along their own paths and tells how far off each
ends; `cyclemap probe` asks whether pushes, or those of a simulator, depend on their direction.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.cli.collected.readable_data import (
    FACT_UNITS,
    PLAIN_UNITS,
    UNITS,
    readable_data,
    reasons_of,
    selected_values,
)
from cyclemap.cli.commands import ProbeOptions, ReplayOptions
from cyclemap.cli.output import file_stem, people_table, progress_bar, publish, result_name
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.comparison.replay_table import (
    DATASET_PUSHER,
    ReplayedPushes,
    dataset_sliders,
    replay_pushes,
)
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.push_probe import (
    OUTCOMES,
    Harmonic,
    Probe,
    Push,
    command_push,
    probe,
    probe_pushes,
)
from cyclemap.evidence.pushes.measured_strokes import told as names_of
from cyclemap.mechanics import load_material
from cyclemap.mechanics.plate_footprint import plate_note
from cyclemap.views.push_pages import probe_page, probe_sentences, replay_headline, replay_page
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, Json, degrees, json_of, rows, written

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
    errors = map(_cells, replayed.by("surface", "object").to_dict("records"))
    publish(
        replay_report(replayed, material.name, loop.pusher.friction, notes),
        replay_page(replayed, material.name),
        asked.results,
        result_name("replay", loop),
        replay_headline(replayed),
        people_table("Error at the end, by object (means)", COLUMNS, errors, words=(0, 1)),
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


def _rows(table: pandas.DataFrame) -> list[Json]:
    units = {name: _UNITS.get(name, NUMBER) for name in map(str, table)}
    return rows(**{unit.named(name): written(table[name], unit) for name, unit in units.items()})


def run_probe(asked: ProbeOptions) -> None:
    """Probe what is asked for, draw it, and print it for people or as JSON."""
    probed = _probed(asked)
    stable = probed.stable if probed.found else ()
    report = {
        "pushes": len(probed.theta),
        **json_of(probed, "found", "p_value"),
        "harmonics": [*map(_harmonic, probed.harmonics)],
        **json_of(probed, "ratio"),
        "axis_deg": degrees(probed.anisotropy.ellipse_direction),
        **json_of(probed, "offset"),
        "offset_deg": degrees(probed.anisotropy.offset_direction),
        **json_of(probed, "explained"),
        "locks_at_deg": degrees([known.value for known in stable]),
        "locks_at_95_deg": degrees([(known.lower, known.upper) for known in stable]),
    }
    publish(report, probe_page(probed), asked.results, "probe", *probe_sentences(probed))


def _harmonic(harmonic: Harmonic) -> Json:
    name = harmonic.outcome
    return {
        **json_of(harmonic, unit=PLAIN_UNITS[name]),
        "outcome": UNITS[name].named(name),
    }


def _probed(asked: ProbeOptions) -> Probe:
    if sum(given is not None for given in (asked.data, asked.program, asked.python)) != 1:
        raise InvalidInput(
            "say what is probed by one of --data DATA, --command PROGRAM, --python MODULE:FUNCTION"
        )
    loop = replace(
        asked.loop.chosen_loop(asked.data).loop,
        material=load_material("isotropic"),
        accuracy=1e-6,
    )
    if asked.data is not None:
        return _probed_data(asked, asked.data, loop)
    if asked.program is not None:
        return probe(command_push(_words_of_command(asked.program)), loop, asked.count)
    return probe(_imported(str(asked.python)), loop, asked.count)


def _probed_data(asked: ProbeOptions, data: Path, loop: CollectionLoop) -> Probe:
    pushes = load_pushes(readable_data(data, asked.table, asked.results.out))
    for words in check_pushes(pushes, loop):
        click.echo(words, err=True)
    table = pushes.table.dropna(subset=["theta0", *OUTCOMES])
    if not len(table):
        raise InvalidInput(
            f"{data}: no push with a pose before and after it: x0, y0, theta0, x1, y1, theta1"
        )
    for name in ("object", "surface"):
        listed = sorted(names_of(table[name]))
        if len(listed) > 1:
            several = f"pushes of several {name}s, {', '.join(listed)[:80]}"
            raise InvalidInput(f"{data}: {several}: give a table of one")
    return probe_pushes(table["theta0"].to_numpy(), table[list(OUTCOMES)].to_numpy(), loop)


def _words_of_command(text: str) -> list[str]:
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InvalidInput(f"--command {text!r}: {error}; close it") from error
    if not words:
        raise InvalidInput("--command is empty: name a program")
    return words


def _imported(name: str) -> Push:
    """The function MODULE:FUNCTION, its module looked for in the working directory, too; what goes
    wrong in either is told in one line.
    """
    module, colon, function = name.partition(":")
    if not (module and colon and function):
        raise InvalidInput(f"--python {name}: give it as module:function")
    sys.path.insert(0, str(Path.cwd()))
    try:
        push = getattr(import_module(module), function)
    except Exception as error:
        raise InvalidInput(f"--python {name}: {type(error).__name__}: {error}") from error
    if not callable(push):
        raise InvalidInput(f"--python {name}: {function} is no function, but {push!r}")

    def pushed(theta: float) -> Sequence[float]:
        try:
            change: Sequence[float] = push(theta)
        except Exception as error:
            raise CycleMapError(
                f"--python {name} at theta = {theta:.4g} rad: {type(error).__name__}: {error}"
            ) from error
        return change

    return pushed
