"""`cyclemap reset`: three lines and a few rows, as JSON, a picture, a protocol and a schedule."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cyclemap.cli.json_report import actions_report
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import Told, people_table, progress_bar, publish, result_stem, styled
from cyclemap.mechanics import Material, load_material
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
    asked = chosen_collection(options)
    with progress_bar("comparing resets") as report:
        design = design_reset(
            asked.loop,
            ResetDemands(
                reach=_times(1e-3, reach_mm), contact=_times(1e-3, least_push_mm), **wanted
            ),
            sigma=asked.noise,
            materials=_range(asked.loop.material, axes_percent, offsets_percent, likely),
            given=asked.strategy,
            seed=seed,
            progress=report,
        )
    stem = result_stem(results.out, "reset", asked.loop)
    strategy = design.chosen.strategy
    protocol, schedule = (stem.with_name(f"{stem.name}.{end}") for end in ("toml", "csv"))
    write_protocol(
        protocol, design.loop, strategy, noise=asked.noise, predicted=_predicted(design.chosen)
    )
    write_schedule(schedule, design.loop, strategy, cycles, seed)
    publish(
        _report(design, protocol, schedule),
        reset_page(design),
        stem,
        results,
        *_lines(design),
        after=(f"protocol: {protocol}", f"schedule: {schedule}"),
    )


def _times(factor: float, value: float | None) -> float | None:
    return None if value is None else factor * value


def _range(
    nominal: Material,
    axes_percent: float | None,
    offsets_percent: float | None,
    likely: Sequence[str],
) -> MaterialRange:
    """The materials that are named, else those of percentages."""
    about = material_range(nominal, _times(0.01, axes_percent), _times(0.01, offsets_percent))
    if not likely:
        return about
    return MaterialRange(about.nominal, tuple(map(load_material, likely)), ", ".join(likely))


def _lines(design: ResetDesign) -> list[Told]:
    headline, *sentences = design_sentences(design)
    title = f"It, and others beside it ({histogram_words(design)})"
    return [
        *(styled(sentence, "bold red") for sentence in miss_sentences(design)),
        styled(headline, "bold"),
        *sentences,
        people_table(title, COLUMNS, map(row_cells, design.rows), words=(0, 1)),
        material_line(design.loop.material),
    ]


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
