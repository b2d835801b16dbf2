"""The command `cyclemap doctor`: what is installed, and whether the engine comes to the right numbers."""

from __future__ import annotations

import math
import platform
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from cyclemap.cli.json_report import Json

PACKAGES = ("cyclemap", "numpy", "scipy", "casadi", "matplotlib")
UNHEALTHY = 1
# MIT's loop on plywood: theta0, turn of the push and of the drag that follows, degrees, by that solver.
REFERENCE_DEG = (
    (0.0, 73.65314, -63.68794),
    (60.0, 73.84911, -73.51442),
    (150.0, 65.58227, -77.99290),
    (270.0, 72.40902, -49.51194),
)
# How far off that the turns may be, rad: they are within 6e-5 degrees, at any accuracy of ours.
REFERENCE_ERROR = math.radians(1e-4)


@click.command("doctor")
@click.option("--json", "json_target", metavar="FILE", help="Write the findings as JSON; - prints them.")
def doctor_command(json_target: str | None) -> None:
    """Tell what is installed, and how far cycles are from an independent solver's.

    The exit code is 1 where something that should work does not.
    """
    from cyclemap.cli.output import publish_json
    from cyclemap.errors import InvalidInput
    from cyclemap.figures.catalogue import MeasuredFolder
    from cyclemap.mechanics.engine import library

    problems: list[str] = []
    data = None
    try:
        data = MeasuredFolder.found().path
    except InvalidInput as error:
        problems.append(str(error))
    engine, off = _engine(problems)
    report: Json = {
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "machine": f"{platform.system()} {platform.machine()}",
        "engine": str(library.library_path(Path(library.__file__).parent)),
        "engine_version": engine,
        "self_check_error_deg": None if off is None else math.degrees(off),
        "data_folder": None if data is None else str(data),
        "problems": problems,
        "healthy": not problems,
    }
    if not publish_json(report, json_target):
        _tell(report, problems)
    if problems:
        raise click.exceptions.Exit(UNHEALTHY)


def _engine(problems: list[str]) -> tuple[str | None, float | None]:
    """The engine's version and its largest difference from the independent solver, rad; None without an engine."""
    from cyclemap.errors import EngineNotBuilt
    from cyclemap.mechanics.engine import library

    try:
        told = library.load().cm_version().decode()
    except EngineNotBuilt as missing:
        problems.append(str(missing))
        return None, None
    error = reference_error()
    if not error <= REFERENCE_ERROR:
        problems.append(f"turns in MIT's loop are {math.degrees(error):.1e}° off those of an independent solver")
    return told, error


def reference_error() -> float:
    """Return the largest difference (rad) of turns in MIT's loop on plywood from the independent solver's."""
    import numpy as np

    from cyclemap.collection import CollectionLoop

    theta, push_turn, drag_turn = np.radians(REFERENCE_DEG).T
    cycles = CollectionLoop.mit("plywood").cycles(theta)
    return float(np.abs([cycles.push_turn - push_turn, cycles.drag_turn - drag_turn]).max())


def _tell(report: Json, problems: list[str]) -> None:
    from rich.table import Table

    from cyclemap.cli.output import PeopleConsole

    table = Table(title="cyclemap on this machine", title_justify="left", show_header=False)
    versions, error = report["versions"], report["self_check_error_deg"]
    assert isinstance(versions, dict)
    table.add_row("versions", ", ".join(f"{name} {number}" for name, number in versions.items()))
    table.add_row("machine", str(report["machine"]))
    table.add_row("engine", f"{report['engine']}, {report['engine_version'] or 'not to be used'}")
    if isinstance(error, float):
        table.add_row("self-check", f"4 cycles within {error:.1e}° of an independent solver's")
    table.add_row("measured data", str(report["data_folder"] or "not found: set CYCLEMAP_DATA where it is needed"))
    console = PeopleConsole()
    console.print_table(table)
    for problem in problems:
        console.print(f"PROBLEM: {problem}")
    console.print("healthy" if report["healthy"] else "not healthy")
