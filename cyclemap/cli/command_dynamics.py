"""The command `cyclemap dynamics`: dynamic and quasi-static cycles side by side: table, JSON, picture."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cyclemap.cli.options import LoopOptions, Real, loop_options, result_options, theta0_option

if TYPE_CHECKING:
    from cyclemap.cli.json_report import Json
    from cyclemap.collection.dynamic_loop import DynamicsComparison
    from cyclemap.collection.loop import Cycles

COLUMNS = ("law", "θ0 (°)", "model", "push turn (°)", "dx (mm)", "dy (mm)", "drag turn (°)", "next θ0 (°)")


@click.command("dynamics")
@loop_options
@theta0_option
@click.option("--speed-mm-s", type=Real(), default=20.0, help="Speed of the rod.")
@result_options("dynamics_MATERIAL.png and .json")
def dynamics_command(
    options: LoopOptions, theta0_deg: str, speed_mm_s: float, out: Path, picture_format: str, json_target: str | None
) -> None:
    """Set dynamic cycles (with inertia) beside quasi-static ones, on MATERIAL and on isotropic friction.

    Both stand on the footprint if it is made of points, else on points that carry its pressure: the paper's grid:8
    where it is even, weighted and with points along the rim where it leans or has parts.
    """
    from cyclemap.cli.output import file_stem, progress_bar, publish
    from cyclemap.cli.run_cycle import parse_angles
    from cyclemap.cli.settings import chosen_loop
    from cyclemap.collection.dynamic_loop import DynamicLoop, compare_dynamics, isotropic_twin
    from cyclemap.views.dynamics_page import dynamics_page

    starts_deg = parse_angles(theta0_deg)
    theta = [math.radians(start) for start in starts_deg]
    chosen, _ = chosen_loop(options)
    loop = DynamicLoop(chosen, speed=1e-3 * speed_mm_s)
    with progress_bar(f"dynamic cycles on {chosen.material.name}") as report:
        material = compare_dynamics(loop, theta)
        report(0.5)
        isotropic = compare_dynamics(replace(loop, loop=isotropic_twin(chosen)), theta)
        report(1.0)
    told = _report(starts_deg, material, isotropic)
    stem = out / f"dynamics_{file_stem(chosen.material.name)}"
    picture = publish(told, dynamics_page(material, isotropic), stem, picture_format, json_target)
    if picture is not None:
        from cyclemap.cli.output import PeopleConsole, people_table
        from cyclemap.views.dynamics_page import difference_sentence

        console = PeopleConsole()
        console.tell(difference_sentence(material), difference_sentence(isotropic))
        table = people_table(f"Cycles at {1e3 * material.loop.speed:g} mm/s", COLUMNS)
        for place in (0, 2):
            table.columns[place].justify = "left"
        for law, comparison in (("anisotropic", material), ("isotropic", isotropic)):
            for k in range(comparison.dynamic.theta.size):
                table.add_row(*_cells(law, "dynamic", comparison.dynamic, k))
                table.add_row(*_cells("", "quasi-static", comparison.quasi_static, k), end_section=True)
        console.print_table(table)
        console.print(f"picture: {picture}")


def _report(starts_deg: list[float], material: DynamicsComparison, isotropic: DynamicsComparison) -> Json:
    """The comparison as JSON: for both laws the cycles of both models from each start angle (degrees)."""
    from cyclemap.cli.json_report import degrees, number

    def rows(comparison: DynamicsComparison) -> Json:
        both = (("dynamic", comparison.dynamic), ("quasi_static", comparison.quasi_static))
        return {name: [row(start, cycles, k) for k, start in enumerate(starts_deg)] for name, cycles in both}

    def row(start_deg: float, cycles: Cycles, k: int) -> Json:
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

    return {
        "speed_mm_s": number(1e3 * material.loop.speed),
        "anisotropic": rows(material),
        "isotropic": {"mu": number(isotropic.loop.loop.material.friction.mu_a), **rows(isotropic)},
    }


def _cells(law: str, model: str, cycles: Cycles, k: int) -> tuple[str, ...]:
    dx, dy = 1e3 * cycles.push_displacement[k]
    push, drag = math.degrees(cycles.push_turn[k]), math.degrees(cycles.drag_turn[k])
    start = f"{math.degrees(cycles.theta[k]):.1f}" if law else ""
    return law, start, model, *(f"{x:.3f}" for x in (push, dx, dy, drag, math.degrees(cycles.theta_next[k])))
