"""A reset over a range of materials, and as a surface wears, as JSON: millimetres, degrees, percent."""

from __future__ import annotations

import math

from cyclemap.cli.json_numbers import degrees, number
from cyclemap.cli.json_report import Json
from cyclemap.mechanics import Material
from cyclemap.resets.robust.design_under_wear import ResetUnderWear
from cyclemap.resets.robust.robust_reset import RobustReset
from cyclemap.resets.robust.worst_case import WorstCase
from cyclemap.views.robust_sentences import robust_sentences, wear_sentence


def robust_report(robust: RobustReset, other: tuple[str, WorstCase] | None = None) -> Json:
    """The entry "robust"; other : a strategy's name and what it does on the corners."""
    check, source = robust.check, robust.materials
    return {
        "holds": robust.holds,
        "says": list(robust_sentences(robust, other)),
        "range": {
            "ratio_percent": number(100 * source.ratio),
            "offset_percent": number(100 * source.offset),
            "direction": "any" if isinstance(source.phi, str) else degrees(source.phi),
        },
        "materials": robust.drawn,
        "corners": check.sample.chosen - 1,
        "seed": robust.seed,
        "slanted": robust.slanted,
        "scenarios": len(robust.made.scenarios),
        "pushes": [
            {"side": push.side, "fraction": push.fraction, "angle_deg": degrees(push.angle), "chance": chance}
            for push, chance in zip(robust.strategy.pushes, robust.strategy.chances.tolist(), strict=True)
        ],
        "nominal_tv": number(check.nominal.total_variation),
        "quantile_95_tv": number(check.quantile(0.95)),
        **_worst(robust),
        "exceeding": len(check.exceeding),
        "exceeding_drawn": robust.exceeding_drawn,
        "share_exceeding_95": number(check.share_exceeding),
        "mean_drag_ratio": number(robust.mean_drag_ratio),
        "grid_error": number(float(check.column("error").max())),
        "first_by_nominal": None if other is None else _corners(*other),
    }


def wear_report(course: ResetUnderWear | None, why_not: str, allow_tv: float, name: str) -> Json:
    """The entry "wear"; course : None where the strategy cannot be followed, for the reason `why_not`."""
    if course is None:
        return {"followed": False, "reason": why_not}
    return {
        "followed": True,
        "says": wear_sentence(course, allow_tv, name),
        "surface": name,
        "pushes": course.pushes,
        "fresh_tv": number(course.frozen_variation(0)),
        "worn_tv": number(course.frozen_variation(course.pushes)),
        "collection_tv": number(course.collection_variation),
        "allow_tv": number(allow_tv),
        "leaves_at_push": course.leaves(allow_tv),
        "blend_error": number(course.blend_error),
    }


def _worst(robust: RobustReset) -> Json:
    check = robust.check
    material, score = check.worst()
    names = [name for name in check.sample.names if name != "phi"]
    at = check.sample.materials.index(material)
    return {
        "worst_tv": number(score.total_variation),
        "worst_tv_after": number(float(check.column("variation_after").max())),
        "worst_drag_ratio": number(float(check.column("drag_ratio").max())),
        "worst_material": {
            "name": material.name,
            **{f"{name}_off_percent": number(100 * float(robust.changes(name)[at])) for name in names},
            **_friction(material),
        },
    }


def _friction(material: Material) -> Json:
    law = material.friction
    values = {name: number(getattr(law, name)) for name in ("mu_a", "mu_b", "m0", "n0")}
    return {**values, "phi_deg": number(math.degrees(law.phi))}


def _corners(name: str, corners: WorstCase) -> Json:
    return {
        "name": name,
        "worst_corner_tv": number(float(corners.column("total_variation").max())),
        "corners_exceeding": len(corners.exceeding),
    }
