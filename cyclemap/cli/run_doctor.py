"""`cyclemap doctor`: what is installed, what runs compiled, and whether the numbers are right."""

import math
import platform
from importlib.metadata import version

import click
from rich.table import Table

from cyclemap.cli.json_report import Json
from cyclemap.cli.output import publish_json
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.kernel_check import KernelCheck, check_kernels
from cyclemap.errors import InvalidInput
from cyclemap.figures.measured_folder import MeasuredFolder
from cyclemap.mechanics.compiled.library_cache import cache_folder

PACKAGES = ("cyclemap", "numpy", "scipy", "casadi", "matplotlib")
UNHEALTHY = 1


def run_doctor(json_target: str | None) -> None:
    """Look, tell, and end with exit code 1 where something that should work does not."""
    check = check_kernels()
    data, trouble = _data_folder()
    problems = [*check.problems, *trouble]
    report: Json = {
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "machine": f"{platform.system()} {platform.machine()}",
        "kernels": _kernels(check),
        "data_folder": data,
        "problems": problems,
        "healthy": not problems,
    }
    if not publish_json(report, json_target):
        _tell(report, check)
    if problems:
        raise click.exceptions.Exit(UNHEALTHY)


def _data_folder() -> tuple[str | None, list[str]]:
    try:
        path = MeasuredFolder.found().path
    except InvalidInput as error:
        return None, [str(error)]
    return (None if path is None else str(path)), []


def _kernels(check: KernelCheck) -> Json:
    return {
        "compiler": check.compiler,
        "cache_folder": str(cache_folder()),
        "compiled": not check.refusal,
        "why_not": check.refusal or None,
        "interpreted_ms": 1e3 * check.interpreted_seconds,
        "compiled_ms": None if check.compiled_seconds is None else 1e3 * check.compiled_seconds,
        "difference_rad": check.difference,
        "self_check_error_deg": math.degrees(check.error),
    }


def _tell(report: Json, check: KernelCheck) -> None:
    table = Table(title="cyclemap on this machine", title_justify="left", show_header=False)
    versions = report["versions"]
    assert isinstance(versions, dict)
    table.add_row("versions", ", ".join(f"{name} {number}" for name, number in versions.items()))
    table.add_row("machine", str(report["machine"]))
    table.add_row("compiler", check.compiler or "none")
    table.add_row(
        "kernels", f"interpreted: {check.refusal}" if check.refusal else f"compiled, kept in {cache_folder()}"
    )
    table.add_row("measured data", str(report["data_folder"] or "not found: set CYCLEMAP_DATA where it is needed"))
    table.add_row("self-check", f"push and drag from θ0 = 0 are {math.degrees(check.error):.1e}° off their reference")
    compiled, slow = check.compiled_seconds, f"{1e3 * check.interpreted_seconds:.3g} ms interpreted"
    table.add_row("one cycle at 1e-8 rad", slow if compiled is None else f"{1e3 * compiled:.3g} ms compiled, {slow}")
    console = PeopleConsole()
    console.print_table(table)
    problems = report["problems"]
    assert isinstance(problems, list)
    for problem in problems:
        console.print(f"PROBLEM: {problem}")
    console.print("healthy" if report["healthy"] else "not healthy")
