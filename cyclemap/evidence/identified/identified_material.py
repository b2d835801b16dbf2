"""An identification as a material: friction, what was found with it, wear, and words on data and misfit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.cross_validation import KindErrors
from cyclemap.evidence.identification.identification import Estimate, Identification
from cyclemap.evidence.identified.identified_curves import worn_friction_of
from cyclemap.mechanics import FoundWith, Material, PlatePressure, Wear

# Units as people read them, and the factor from SI.
_READABLE = {"rad": ("°", 57.29577951308232), "m": (" mm", 1e3), "1": ("", 1.0)}


def identified_material(
    found: Identification, name: str, sources: Sequence[str] = (), last_cycle: float = 0.0, plate: str = "rect1"
) -> Material:
    """Return what was identified as a material, marked as inferred.

    sources : what the data were, for the provenance. last_cycle : the number of cycles behind the first after which a
    surface that wears is the worn one. plate : the object whose pressure was identified.
    What the data do not depend on is left open in `found_with`.
    Raises InvalidInput for an empty name.
    """
    if not name.strip():
        raise InvalidInput("a material needs a name")
    asked = {part for block in found.problem.blocks for part in block.parameters}
    told = {field.name: found.values[field.name] for field in fields(FoundWith) if field.name in asked}
    shares = {name: share for name, share in found.surface.shares.items() if name in asked}
    worn = worn_friction_of(found)
    return Material(
        name,
        found.friction(),
        provenance_words(found, sources),
        misfit_words(found),
        inferred=True,
        found_with=FoundWith(**told),
        plates=(PlatePressure(plate, **shares),) if shares else (),
        wear=None if worn is None or last_cycle <= 0.0 else Wear(worn, last_cycle),
    )


def provenance_words(found: Identification, sources: Sequence[str]) -> str:
    """Return where the numbers come from, in one paragraph."""
    data = ", ".join(f"{block.name} ({len(block.groups)} values)" for block in found.problem.blocks)
    origin = f" in {', '.join(sources)}" if sources else ""
    free = "; ".join(estimate_words(one) for one in found.estimates)
    text = f"inferred from {data}{origin}: {free}, intervals of {100 * found.level:g} %"
    held = "; ".join(f"{name} {value:.4g}" for name, value in sorted(found.problem.fixed.items()))
    return text + (f"; held: {held}" if held else "")


def misfit_words(found: Identification) -> str:
    """Return the root mean square of every kind of error, in degrees, millimetres and newtons."""
    return "; ".join(kind_words(errors) for errors in found.errors)


def kind_words(errors: KindErrors) -> str:
    """Return the root mean square of one kind of error, in the sample and left out."""
    kind, unit, factor = readable_kind(errors.kind)
    left_out = errors.left_out_rms
    tail = f" ({factor * left_out:.3g}{unit} left out)" if left_out == left_out else ""
    return f"{errors.block}, {kind}: {factor * errors.rms:.3g}{unit} RMS{tail}"


def readable_kind(kind: str) -> tuple[str, str, float]:
    """Return a kind of noise without its unit, the unit as people read it, and the factor from SI.

    >>> readable_kind("push place (m)")
    ('push place', ' mm', 1000.0)
    """
    found = re.fullmatch(r"(.*) \((\S+)\)", kind)
    if found is None:
        return kind, "", 1.0
    unit, factor = _READABLE.get(found[2], (f" {found[2]}", 1.0))
    return found[1], unit, factor


def readable_unit(unit: str) -> tuple[str, float]:
    """Return a unit as people read it, and the factor from SI.

    >>> readable_unit("m")
    (' mm', 1000.0)
    """
    return _READABLE.get(unit, (f" {unit}", 1.0))


def estimate_words(one: Estimate) -> str:
    """Return a parameter with its interval, in readable units."""
    unit, factor = readable_unit(one.unit)
    if not one.identifiable:
        return f"{one.name} not identifiable"
    value, lower, upper = (f"{round(factor * number, 6):.4g}" for number in (one.value, one.lower, one.upper))
    return f"{one.name} {value} ({lower} to {upper}){unit}"
