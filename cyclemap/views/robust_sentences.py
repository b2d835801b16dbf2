"""A reset for a range of materials, and as a surface wears, in sentences."""

from __future__ import annotations

import math

from cyclemap.resets.robust.design_under_wear import ResetUnderWear
from cyclemap.resets.robust.robust_reset import RobustReset
from cyclemap.resets.robust.worst_case import WorstCase

_COORDINATES = {
    "ratio": "axis ratio",
    "m0": "offset m0",
    "n0": "offset n0",
    "phi": "direction",
    "pusher_friction": "rod's friction",
}


def robust_sentences(robust: RobustReset, other: tuple[str, WorstCase] | None = None) -> tuple[str, ...]:
    """The whole answer, the verdict first. other : a strategy's name and what it does on the corners."""
    told = [robust_verdict(robust), confidence_sentence(robust), drag_sentence(robust)]
    return tuple(filter(None, (*told, "" if other is None else other_sentence(robust, *other))))


def robust_verdict(robust: RobustReset) -> str:
    """Whether the allowance is kept on every material that was looked at, and what the worst one leaves."""
    check, limit = robust.check, robust.check.allowance.total_variation
    material, score = check.worst()
    count = f"{len(check.scores)} materials ({range_words(robust)})"
    worst = f"total variation nominally {check.nominal.total_variation:.4f}, at worst {score.total_variation:.4f}"
    where = f"on {material.name}"
    if robust.holds:
        return f"Robust: the allowance ({limit:g}) is kept on all of {count}: {worst}, {where}."
    what = "slanted pushes too" if robust.slanted else "pushes at the loop's own angle"
    told = f"NOT ROBUST: of {count} {len(check.exceeding)} exceed what is allowed; {worst}, {where}"
    furthest = robust.worst_material
    if furthest is not material:
        told += f"; furthest beyond all that is allowed: {furthest.name}"
    return f"{told}. It is the best that was found ({what} were to choose from)."


def range_words(robust: RobustReset) -> str:
    """What the range is, and how it was looked at.

    Axis ratio and offsets about the nominal material, its corners and materials drawn evenly.
    """
    source, chosen = robust.materials, robust.check.sample.chosen
    half = "any direction" if isinstance(source.phi, str) else f"direction ±{math.degrees(source.phi):.0f}°"
    told = f"axis ratio ±{100 * source.ratio:g} %, offsets ±{100 * source.offset:g} %, {half}"
    return f"{told}: nominal, {chosen - 1} corners, {robust.drawn} drawn evenly"


def confidence_sentence(robust: RobustReset) -> str:
    """What the drawn materials say of all of the range."""
    share = robust.check.share_exceeding
    if math.isnan(share):
        return ""
    found = f"{robust.exceeding_drawn} of the {robust.drawn} drawn materials exceed" if robust.exceeding_drawn else (
        f"None of the {robust.drawn} drawn materials exceeds"
    )  # fmt: skip
    return f"{found}: at 95 % confidence at most {share:.1%} of the range do."


def drag_sentence(robust: RobustReset) -> str:
    """The drag over the drawn materials."""
    worst = robust.check.worst("drag_ratio")[1].drag_ratio
    return f"Mean drag over them: {robust.mean_drag_ratio:.2f} of the loop's own, at most {worst:.2f}."


def other_sentence(robust: RobustReset, name: str, corners: WorstCase) -> str:
    """What another strategy does on the corners."""
    most, own = float(corners.column("total_variation").max()), robust.check.sample.chosen
    here = float(robust.check.column("total_variation")[:own].max())
    return (
        f"“{name}”, the first by the nominal material, leaves {most:.4f} on the worst of the corners and exceeds on "
        f"{len(corners.exceeding)} of {len(corners.scores)}; the robust one leaves {here:.4f} there."
    )


def wear_sentence(course: ResetUnderWear, allow_tv: float, name: str) -> str:
    """What becomes of a reset as the surface wears. name : of the surface."""
    fresh, worn = course.frozen_variation(0), course.frozen_variation(course.pushes)
    at = course.leaves(allow_tv)
    kept = f"stays within {allow_tv:g} throughout" if at is None else (
        f"is beyond {allow_tv:g} from the start" if at == 0 else f"leaves {allow_tv:g} at push {at}"
    )  # fmt: skip
    return (
        f"As {name} wears over {course.pushes} pushes, total variation from uniform goes from {fresh:.4f} fresh to "
        f"{worn:.4f} worn (each as if the wear stopped there) and {kept}; that of the whole collection is "
        f"{course.collection_variation:.4f}."
    )


def coordinate_words(name: str) -> str:
    """A coordinate of the range, in words.

    >>> coordinate_words("ratio")
    'axis ratio'
    """
    return _COORDINATES.get(name, name)
