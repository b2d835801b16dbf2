"""The command `cyclemap doctor`: what is installed, and whether the engine comes to the right
numbers.
"""

import math
import platform
from importlib.metadata import version
from pathlib import Path

import click
import numpy as np
from rich.table import Table

from cyclemap.cli.commands import DoctorOptions
from cyclemap.cli.output import PeopleConsole, publish_json
from cyclemap.collection import CollectionLoop
from cyclemap.errors import EngineNotBuilt, InvalidInput
from cyclemap.figures import MeasuredFolder
from cyclemap.mechanics.engine import library
from cyclemap.written import Json, written

PACKAGES = ("cyclemap", "numpy", "scipy", "casadi", "matplotlib")
# MIT's loop on plywood: theta0, turn of the push and of the drag that follows, degrees, by that
# solver.
REFERENCE_DEG = (
    (0.0, 73.65314, -63.68794),
    (60.0, 73.84911, -73.51442),
    (150.0, 65.58227, -77.99290),
    (270.0, 72.40902, -49.51194),
)
# How far off that the turns may be: they are within 6e-5 degrees, at any accuracy of ours.
REFERENCE_ERROR_DEG = 1e-4


def run_doctor(asked: DoctorOptions) -> None:
    """Look at all of it, and tell people or write JSON; exit code 1 where something is wrong."""
    report = health_report()
    if not publish_json(report, asked.json):
        _tell(report)
    if not report["healthy"]:
        raise click.exceptions.Exit(1)


def health_report() -> Json:
    """What is installed and found, and what is wrong with it."""
    problems: list[str] = []
    data = engine = off = None
    try:
        data = MeasuredFolder.found().path
    except InvalidInput as error:
        problems.append(str(error))
    try:
        engine = library.load().cm_version().decode()
        off = math.degrees(reference_error())
        if not off <= REFERENCE_ERROR_DEG:
            problems.append(
                f"turns in MIT's loop are {off:.1e}° off those of an independent solver"
            )
    except EngineNotBuilt as missing:
        problems.append(str(missing))
    return {
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in PACKAGES},
        },
        "machine": f"{platform.system()} {platform.machine()}",
        "engine": str(library.library_path(Path(library.__file__).parent)),
        "engine_version": engine,
        "self_check_error_deg": off,
        "data_folder": None if data is None else str(data),
        "problems": problems,
        "healthy": not problems,
    }


def _tell(report: Json) -> None:
    """The report for people."""
    versions = written(report["versions"])
    off = report["self_check_error_deg"]
    table = Table(title="cyclemap on this machine", title_justify="left", show_header=False)
    table.add_row("versions", ", ".join(f"{name} {release}" for name, release in versions.items()))
    table.add_row("machine", str(report["machine"]))
    table.add_row("engine", f"{report['engine']}, {report['engine_version'] or 'not to be used'}")
    if off is not None:
        table.add_row("self-check", f"4 cycles within {off:.1e}° of an independent solver's")
    where = report["data_folder"] or "not found: set CYCLEMAP_DATA where it is needed"
    table.add_row("measured data", str(where))
    console = PeopleConsole()
    console.print_table(table)
    for problem in written(report["problems"]):
        console.print(f"PROBLEM: {problem}")
    console.print("healthy" if report["healthy"] else "not healthy")


def reference_error() -> float:
    """Return the largest difference (rad) of turns in MIT's loop on plywood from the independent
    solver's.
    """
    theta, push_turn, drag_turn = np.radians(REFERENCE_DEG).T
    cycles = CollectionLoop.mit("plywood").cycles(theta)
    return float(np.abs([cycles.push_turn - push_turn, cycles.drag_turn - drag_turn]).max())
