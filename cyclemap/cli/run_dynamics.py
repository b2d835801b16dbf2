"""`cyclemap dynamics`: dynamic and quasi-static cycles side by side: table, JSON, picture."""

import math
from dataclasses import replace
from pathlib import Path

from cyclemap.cli.json_report import Json, degrees, number
from cyclemap.cli.output import PeopleConsole, people_table, progress_bar, publish, result_stem
from cyclemap.cli.run_cycle import parse_angles
from cyclemap.collection.dynamic_loop import (
    DynamicLoop,
    DynamicsComparison,
    compare_dynamics,
    isotropic_twin,
)
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views.experiment_page import difference_sentence, dynamics_page

COLUMNS = (
    "law",
    "model",
    "θ0 (°)",
    "push turn (°)",
    "dx (mm)",
    "dy (mm)",
    "drag turn (°)",
    "next θ0 (°)",
)


def run_dynamics(
    options: LoopOptions,
    theta0_deg: str,
    speed_mm_s: float,
    out: Path,
    picture_format: str,
    json_target: str | None,
) -> None:
    """Run the cycles of both models under both laws, draw them, and print them for people or as
    JSON.
    """
    starts_deg = parse_angles(theta0_deg)
    theta = [math.radians(start) for start in starts_deg]
    chosen, _ = chosen_loop(options)
    loop = DynamicLoop(chosen, speed=1e-3 * speed_mm_s)
    with progress_bar(f"dynamic cycles on {chosen.material.name}") as report:
        material = compare_dynamics(loop, theta)
        report(0.5)
        isotropic = compare_dynamics(replace(loop, loop=isotropic_twin(chosen)), theta)
        report(1.0)
    rows = {"anisotropic": _rows(starts_deg, material), "isotropic": _rows(starts_deg, isotropic)}
    mu = {"mu": number(isotropic.loop.loop.material.friction.mu_a)}
    told: Json = {
        "speed_mm_s": number(1e3 * loop.speed),
        **rows,
        "isotropic": {**mu, **rows["isotropic"]},
    }
    stem = result_stem(out, "dynamics", chosen)
    picture = publish(told, dynamics_page(material, isotropic), stem, picture_format, json_target)
    if picture is None:
        return
    console = PeopleConsole()
    console.tell(difference_sentence(material), difference_sentence(isotropic))
    table = people_table(f"Cycles at {1e3 * loop.speed:g} mm/s", COLUMNS, words=(0, 1))
    for law, models in rows.items():
        for dynamic, quasi_static in zip(models["dynamic"], models["quasi_static"], strict=True):
            table.add_row(law, "dynamic", *_cells(dynamic))
            table.add_row("", "quasi-static", "", *_cells(quasi_static)[1:], end_section=True)
    console.print_table(table)
    console.print(f"picture: {picture}")


def _rows(starts_deg: list[float], comparison: DynamicsComparison) -> dict[str, list[Json]]:
    """The cycles of both models from each start angle (degrees)."""
    return {
        name: [
            {
                "theta0_deg": start,
                "push_turn_deg": degrees(cycles.push_turn[k]),
                "push_dx_mm": number(1e3 * cycles.push_displacement[k, 0]),
                "push_dy_mm": number(1e3 * cycles.push_displacement[k, 1]),
                "drag_turn_deg": degrees(cycles.drag_turn[k]),
                "theta1_deg": degrees(cycles.theta_next[k]),
                "left": bool(cycles.left[k]),
            }
            for k, start in enumerate(starts_deg)
        ]
        for name, cycles in (
            ("dynamic", comparison.dynamic),
            ("quasi_static", comparison.quasi_static),
        )
    }


def _cells(row: Json) -> list[str]:
    start, *lengths, _ = row.values()
    return [f"{start:.1f}", *("–" if length is None else f"{length:.3f}" for length in lengths)]
