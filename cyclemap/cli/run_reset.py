"""`cyclemap reset`: three lines and a few rows, as JSON, a picture, a protocol and a schedule."""

from pathlib import Path
from typing import Any

from cyclemap.cli.json_report import actions_report
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import people_table, progress_bar, publish, result_stem, styled
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.mechanics import load_material
from cyclemap.protocol import write_protocol, write_schedule
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.resets import (
    MaterialRange,
    ResetDemands,
    ResetDesign,
    ResetRow,
    design_reset,
    material_range,
)
from cyclemap.views.reset_page import (
    COLUMNS,
    design_sentences,
    histogram_words,
    miss_sentences,
    recipe,
    reset_page,
    row_cells,
)
from cyclemap.views.sentences import material_line
from cyclemap.written import Json, degrees, json_of


def run_reset(
    options: LoopOptions,
    results: ResultOptions,
    cycles: int,
    seed: int,
    reach_mm: float | None,
    least_push_mm: float | None,
    axes_percent: float | None,
    offsets_percent: float | None,
    likely: tuple[str, ...],
    **wanted: Any,
) -> None:
    """Design the reset, write its files, and print it for people or as JSON."""
    reach, contact = (
        None if length is None else 1e-3 * length for length in (reach_mm, least_push_mm)
    )
    axes, offsets = (
        None if part is None else 0.01 * part for part in (axes_percent, offsets_percent)
    )
    asked, demands = (
        chosen_collection(options),
        ResetDemands(reach=reach, contact=contact, **wanted),
    )
    about = material_range(asked.loop.material, axes, offsets)
    if likely:
        about = MaterialRange(about.nominal, tuple(map(load_material, likely)), ", ".join(likely))
    sigma = DEFAULT_SIGMA if asked.sigma is None else asked.sigma
    with progress_bar("comparing resets") as report:
        design = design_reset(
            asked.loop,
            demands,
            sigma=sigma,
            materials=about,
            given=asked.strategy,
            seed=seed,
            progress=report,
        )
    stem, strategy = result_stem(results.out, "reset", asked.loop), design.chosen.strategy
    protocol, schedule = (stem.with_name(f"{stem.name}.{end}") for end in ("toml", "csv"))
    write_protocol(
        protocol, design.loop, strategy, noise=sigma, predicted=_predicted(design.chosen)
    )
    write_schedule(schedule, design.loop, strategy, cycles, seed)
    told = _report(design, protocol, schedule)
    table = people_table(
        f"It, and others beside it ({histogram_words(design)})",
        COLUMNS,
        map(row_cells, design.rows),
        words=(0, 1),
    )
    headline, *sentences = design_sentences(design)
    publish(
        told,
        reset_page(design),
        stem,
        results,
        *(styled(sentence, "bold red") for sentence in miss_sentences(design)),
        styled(headline, "bold"),
        *sentences,
        table,
        material_line(design.loop.material),
        after=(f"protocol: {protocol}", f"schedule: {schedule}"),
    )


def _report(design: ResetDesign, protocol: Path, schedule: Path) -> Json:
    """The report of `cyclemap reset`; the chosen row is the first."""
    rows: list[Json] = [
        {
            **json_of(row, "roles"),
            "recipe": recipe(row.strategy),
            "actions": actions_report(row.strategy, design.loop),
            **_predicted(row),
            "worst_material": row.worst_material.name,
            "histogram_spread": row.histogram[1],
            "worst_histogram_distance": row.worst_histogram[0],
            "seconds": row.seconds,
            "reach_mm": 1e3 * row.room,
            "shortest_contact_mm": 1e3 * row.contact,
            **json_of(row, "misses", "lacking"),
        }
        for row in design.rows
    ]
    return {
        "material": design.loop.material.name,
        "noise_deg": degrees(design.sigma),
        "range": {
            **json_of(design.about, "told"),
            "materials": [material.name for material in design.about.materials],
            **json_of(design.about, "share", "confidence"),
        },
        "met": design.met,
        "reasons": list(miss_sentences(design)),
        "independent_histogram_distance": design.independent,
        "histogram_distance_by_order": design.orders,
        "friction_error": {"ratio": design.ratio_errors.tolist(), "tv": design.ratio_tv.tolist()},
        "rows": rows,
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
