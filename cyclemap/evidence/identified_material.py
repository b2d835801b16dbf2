"""An identification as a material: friction, what was found with it, wear, and words on data and misfit."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import fields, replace

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import PRIOR_KIND
from cyclemap.evidence.identification.identify import Estimate, Identification, plate_shares
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.identified_curves import sampled_values, worn_friction_of
from cyclemap.mechanics import EllipseFriction, FoundWith, FrameShift, Material, MaterialPosterior, PlatePressure, Wear

POSTERIOR_SAMPLES = 200
# Keys of a material file, what they are here, and the factor to their unit.
_FOUND_UNITS = {"pusher_mu": ("pusher_friction", 1.0), "pin_friction_mm": ("pin_friction_radius", 1e3)}
# Units as people read them, and the factor from SI.
_READABLE = {"rad": ("°", 57.29577951308232), "m": (" mm", 1e3), "1": ("", 1.0)}


def identified_material(
    found: Identification,
    name: str,
    sources: Sequence[str] = (),
    last_cycle: float = 0.0,
    plate: str = "rect1",
    seed: int = 0,
) -> Material:
    """Return what was identified as a material, marked as inferred.

    sources : what the data were, for the provenance. last_cycle : the number of cycles behind the first after which a
    surface that wears is the worn one. plate : the object whose pressure was identified, where it is one alone.
    seed : of the samples of the posterior. What the data do not depend on is left open in `found_with`. Raises
    InvalidInput for an empty name.
    """
    if not name.strip():
        raise InvalidInput("a material needs a name")
    asked = {part.partition("[")[0] for block in found.problem.blocks for part in block.parameters}
    told = {field.name: found.values[field.name] for field in fields(FoundWith) if field.name in asked}
    worn, shifts = worn_friction_of(found.values), dict[str, list[float]]()
    for key, value in found.values.items():
        if key.startswith(("tip_offset_x", "tip_offset_y")):
            own = key.partition("[")[2].rstrip("]") or plate
            shifts.setdefault(own, [0.0, 0.0])[key.startswith("tip_offset_y")] = value
    material = Material(
        name,
        found.friction(),
        provenance_words(found, sources),
        misfit_words(found),
        inferred=True,
        found_with=FoundWith(**told),
        plates=tuple(PlatePressure(named or plate, **shares) for named, shares in found.plates.items()),
        wear=None if worn is None or last_cycle <= 0.0 else Wear(worn, last_cycle),
        frames=tuple(FrameShift(named, *shift) for named, shift in sorted(shifts.items())),
    )
    return replace(material, posterior=_posterior(found, material, plate, seed))


def _posterior(found: Identification, material: Material, plate: str, seed: int) -> MaterialPosterior | None:
    """Samples of what the data allow, in the names and units of a material file."""
    rows = []
    for values in sampled_values(found, POSTERIOR_SAMPLES, seed):
        row, worn = _ellipse(SurfaceParameters.from_values(values).to_friction()), worn_friction_of(values)
        if material.wear is not None and worn is not None:
            row |= {f"worn.{key}": value for key, value in _ellipse(worn).items()}
        for key, (name, factor) in _FOUND_UNITS.items():
            if getattr(material.found_with, name) is not None:
                row[key] = factor * values[name]
        for named, shares in plate_shares(values).items():
            # Rounded down, since they add to one at most.
            row |= {f"{named or plate}.{key}": math.floor(1e6 * share) / 1e6 for key, share in shares.items()}
        rows.append(row)
    rounded = tuple(tuple(float(f"{value:.6g}") for value in row.values()) for row in rows)
    return MaterialPosterior(tuple(rows[0]), rounded) if len(rows) > 1 else None


def _ellipse(law: EllipseFriction) -> dict[str, float]:
    return {**{key: getattr(law, key) for key in ("mu_a", "mu_b", "m0", "n0")}, "phi_deg": math.degrees(law.phi)}


def provenance_words(found: Identification, sources: Sequence[str]) -> str:
    """Return where the numbers come from, in one paragraph."""
    blocks = [block for block in found.problem.blocks if PRIOR_KIND not in block.kinds]
    data = ", ".join(f"{block.name} ({len(block.groups)} values)" for block in blocks)
    origin = f" in {', '.join(sources)}" if sources else ""
    free = "; ".join(estimate_words(one) for one in found.estimates)
    text = f"inferred from {data}{origin}: {free}, intervals of {100 * found.level:g} %"
    if found.priors:
        # Beliefs of all plates alike are told once.
        common = {name.partition("[")[0]: belief for name, belief in found.priors.items()}
        listed = ", ".join(f"{name} {mean:g} +- {deviation:g}" for name, (mean, deviation) in common.items())
        text += f"; believed beforehand, in SI units: {listed}"
    held = "; ".join(f"{name} {value:.4g}" for name, value in sorted(found.problem.fixed.items()))
    return text + (f"; held: {held}" if held else "")


def misfit_words(found: Identification) -> str:
    """Return the mean of every kind of error, beside what isotropic friction misses; of many blocks their ranges."""
    sentences = []
    for named in dict.fromkeys(one.kind for one in found.errors):
        kind, unit, factor = readable_kind(named)
        alike = [one for one in found.errors if one.kind == named]
        if len(alike) > 2:
            beside = []
            for word, size in (("", "mean"), ("left out ", "left_out_mean"), ("isotropic ", "isotropic_mean")):
                sizes = [factor * value for one in alike if (value := getattr(one, size)) == value]
                beside += [f"{word}{min(sizes):.3g} to {max(sizes):.3g}"] if sizes else []
            told = f"{kind} in {len(alike)} blocks: {beside.pop(0)}{unit}"
            sentences.append(told + (f" ({', '.join(beside)})" if beside else ""))
            continue
        for one in alike:
            left_out, isotropic = one.left_out_mean, one.isotropic_mean
            beside = [f"{factor * left_out:.3g} left out"] if left_out == left_out else []
            beside += [f"isotropic {factor * isotropic:.3g}"] if isotropic == isotropic else []
            told = f"{one.block}, {kind}: {factor * one.mean:.3g}{unit}"
            sentences.append(told + (f" ({', '.join(beside)})" if beside else ""))
    return "; ".join(sentences)


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
