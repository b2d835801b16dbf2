"""`cyclemap dynamics`: dynamic and quasi-static cycles side by side, in a table, as JSON, and as a picture."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from rich.table import Table

from cyclemap.cli.json_numbers import degrees, number
from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.run_cycle import parse_angles
from cyclemap.cli.settings import chosen_loop
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.cycle import Cycles
from cyclemap.collection.dynamic_loop import DynamicLoop, DynamicsComparison, compare_dynamics, isotropic_twin
from cyclemap.views.dynamics_page import difference_sentence, dynamics_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

COLUMNS = ("law", "θ0 (°)", "model", "push turn (°)", "dx (mm)", "dy (mm)", "drag turn (°)", "next θ0 (°)")


@dataclass(frozen=True)
class DynamicsRequest:
    """What is asked of the comparison: start angles, the rod's speed, and where results go."""

    theta0_deg: str
    speed_mm_s: float
    out: Path
    picture_format: str


def run_dynamics(options: LoopOptions, request: DynamicsRequest, json_target: str | None) -> None:
    """Run the cycles by both routes, write picture and JSON, and print for people or as JSON."""
    starts = parse_angles(request.theta0_deg)
    chosen, _ = chosen_loop(options)
    loop = DynamicLoop(chosen, speed=1e-3 * request.speed_mm_s)
    material, isotropic = _compared(loop, starts)
    report = dynamics_report(starts, material, isotropic)
    stem = f"dynamics_{file_stem(chosen.material.name)}"
    write_json(request.out / f"{stem}.json", report)
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(dynamics_page(material, isotropic), request.picture_format))
    if not publish_json(report, json_target):
        _print_for_people(material, isotropic, picture)


def _compared(loop: DynamicLoop, starts_deg: list[float]) -> tuple[DynamicsComparison, DynamicsComparison]:
    theta = [math.radians(start) for start in starts_deg]
    with progress_bar(f"dynamic cycles on {loop.loop.material.name}") as report:
        material = compare_dynamics(loop, theta)
        report(0.5)
        isotropic = compare_dynamics(replace(loop, loop=isotropic_twin(loop.loop)), theta)
        report(1.0)
    return material, isotropic


def dynamics_report(starts_deg: list[float], material: DynamicsComparison, isotropic: DynamicsComparison) -> Json:
    """The comparison as JSON: for both laws the cycles of both models from each start angle (degrees)."""
    return {
        "speed_mm_s": number(1e3 * material.loop.speed),
        "anisotropic": _rows(starts_deg, material),
        "isotropic": {"mu": number(isotropic.loop.loop.material.friction.mu_a), **_rows(starts_deg, isotropic)},
    }


def _rows(starts_deg: list[float], comparison: DynamicsComparison) -> Json:
    both = (("dynamic", comparison.dynamic), ("quasi_static", comparison.quasi_static))
    return {name: [_row(start, cycles, k) for k, start in enumerate(starts_deg)] for name, cycles in both}


def _row(start_deg: float, cycles: Cycles, k: int) -> Json:
    dx, dy = cycles.push_displacement[k]
    return {
        "theta0_deg": start_deg,
        "push_turn_deg": degrees(cycles.push_turn[k]),
        "push_dx_mm": number(1e3 * dx),
        "push_dy_mm": number(1e3 * dy),
        "drag_turn_deg": degrees(cycles.drag_turn[k]),
        "theta1_deg": degrees(cycles.theta_next[k]),
        "left": bool(cycles.left[k]),
    }


def _print_for_people(material: DynamicsComparison, isotropic: DynamicsComparison, picture: Path) -> None:
    console = PeopleConsole()
    speed = 1e3 * material.loop.speed
    console.print(difference_sentence(material), style="bold")
    console.print(difference_sentence(isotropic))
    table = Table(title=f"Cycles at {speed:g} mm/s", title_justify="left")
    for place, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if place in (0, 2) else "right")
    for law, comparison in (("anisotropic", material), ("isotropic", isotropic)):
        for k in range(comparison.dynamic.theta.size):
            table.add_row(*_cells(law, "dynamic", comparison.dynamic, k))
            table.add_row(*_cells("", "quasi-static", comparison.quasi_static, k), end_section=True)
    console.print_table(table)
    console.print(f"picture: {picture}")


def _cells(law: str, model: str, cycles: Cycles, k: int) -> tuple[str, ...]:
    dx, dy = 1e3 * cycles.push_displacement[k]
    push, drag = math.degrees(cycles.push_turn[k]), math.degrees(cycles.drag_turn[k])
    start = f"{math.degrees(cycles.theta[k]):.1f}" if law else ""
    return law, start, model, *(f"{x:.3f}" for x in (push, dx, dy, drag, math.degrees(cycles.theta_next[k])))
