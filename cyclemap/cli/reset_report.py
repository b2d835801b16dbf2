"""Resets as JSON: mm, degrees and seconds, every number finite or null."""

from __future__ import annotations

from pathlib import Path

from cyclemap.cli.json_report import Json, degrees, number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.resets import ResetDesign, ResetRow, ResetStrategy
from cyclemap.views.reset_sentences import action_words, miss_sentences, recipe


def reset_report(design: ResetDesign, protocol: Path, schedule: Path) -> Json:
    """The report of `cyclemap reset`; the chosen row is the first."""
    rows: list[Json] = [
        {
            "roles": list(row.roles),
            "recipe": recipe(row.strategy),
            "actions": actions_report(row.strategy, design.loop),
            **predicted(row),
            "worst_material": row.worst_material.name,
            "histogram_spread": row.histogram[1],
            "worst_histogram_distance": row.worst_histogram[0],
            "seconds": row.seconds,
            "reach_mm": 1e3 * row.room,
            "shortest_contact_mm": 1e3 * row.contact,
            "misses": list(row.misses),
            "lacking": list(row.lacking),
        }
        for row in design.rows
    ]
    return {
        "material": design.loop.material.name,
        "noise_deg": degrees(design.sigma),
        "range": {"told": design.about.told, "materials": [one.name for one in design.about.materials]},
        "met": design.met,
        "reasons": list(miss_sentences(design)),
        "independent_histogram_distance": design.independent,
        "histogram_distance_by_order": design.orders,
        "friction_error": {"ratio": design.ratio_errors.tolist(), "tv": design.ratio_tv.tolist()},
        "rows": rows,
        "protocol": str(protocol),
        "schedule": str(schedule),
    }


def predicted(row: ResetRow) -> dict[str, float]:
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


def actions_report(strategy: ResetStrategy, loop: CollectionLoop) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares of the cycles."""
    return [
        {
            "name": action_words(action),
            "weight": number(share),
            "side": acted.push.side,
            "fraction": number(acted.push.fraction),
            "angle_deg": degrees(acted.push.angle),
            "push_mm": number(1e3 * acted.push.distance),
            "way_points_mm": [[number(1e3 * x), number(1e3 * y)] for x, y in acted.reset.way_points],
            "gripper_turn_deg": degrees(action.turn),
        }
        for action, acted, share in zip(strategy.actions, strategy.loops(loop), strategy.shares, strict=True)
    ]
