"""Resets as JSON: mm, degrees and seconds, every number finite or null."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from cyclemap.cli.json_report import Json, degrees, number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.resets import ResetDesign, ResetRow, ResetStrategy
from cyclemap.views.reset_sentences import action_words, miss_sentences, recipe


def reset_report(design: ResetDesign, protocol: Path, schedule: Path) -> Json:
    """The report of `cyclemap reset`; the chosen row is the first."""
    demands = asdict(design.demands)
    for name, key in (("reach", "reach_mm"), ("contact", "least_push_mm")):
        length = demands.pop(name)
        demands[key] = None if length is None else 1e3 * length
    return {
        "material": design.loop.material.name,
        "noise_deg": degrees(design.sigma),
        "demands": demands,
        "range": {"told": design.about.told, "materials": [one.name for one in design.about.materials]},
        "met": design.met,
        "reasons": list(miss_sentences(design)),
        "considered": design.considered,
        "left_out_too_steep": design.too_steep,
        "independent_histogram_distance": design.independent,
        "histogram_distance_by_order": design.orders,
        "friction_error": {"ratio": design.ratio_errors.tolist(), "tv": design.ratio_tv.tolist()},
        "rows": [_row(design, row) for row in design.rows],
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


def _row(design: ResetDesign, row: ResetRow) -> Json:
    strategy = row.strategy
    return {
        "roles": list(row.roles),
        "recipe": recipe(strategy),
        "order": strategy.order,
        "actions": actions_report(strategy, design.loop),
        "hitch_mm": None if strategy.hitch is None else [1e3 * part for part in strategy.hitch],
        **predicted(row),
        "tv_error": number(row.nominal.error),
        "worst_material": row.worst_material.name,
        "histogram_spread": row.histogram[1],
        "worst_histogram_distance": row.worst_histogram[0],
        "seconds": row.seconds,
        "reach_mm": 1e3 * row.room,
        "shortest_contact_mm": 1e3 * row.contact,
        "misses": list(row.misses),
        "lacking": list(row.lacking),
    }


def actions_report(strategy: ResetStrategy, loop: CollectionLoop) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares of the cycles."""
    told: list[Json] = []
    for action, share in zip(strategy.actions, strategy.shares.tolist(), strict=True):
        acted = action.on(strategy.prepared(loop))
        told.append(
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
        )
    return told
