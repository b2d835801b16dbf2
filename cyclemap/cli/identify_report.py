"""The report of `cyclemap identify` as JSON: degrees and millimetres, every number finite or null."""

import math
from collections.abc import Sequence

from cyclemap.cli.json_numbers import number
from cyclemap.cli.json_report import Json
from cyclemap.evidence.identification.cross_validation import KindErrors
from cyclemap.evidence.identification.derived_quantities import Derived
from cyclemap.evidence.identification.identification import Estimate, Identification
from cyclemap.evidence.identified.identified_material import readable_kind, readable_unit
from cyclemap.mechanics import EllipseFriction, Material

# How units are named in the report.
_NAMES = {"°": "deg", " mm": "mm", "": "1"}


def identify_report(
    material: Material,
    data: Sequence[str],
    found: Identification,
    derived: Sequence[Derived],
) -> Json:
    """The report of an identification."""
    return {
        **_material(material),
        "converged": found.converged,
        "level": found.level,
        "parameters": [_parameter(one) for one in found.estimates],
        "plates": {one.plate: {key: number(value) for key, value in one.shares.items()} for one in material.plates},
        "priors": {name: [number(value) for value in belief] for name, belief in found.priors.items()},
        "held": {name: number(value) for name, value in sorted(found.problem.fixed.items())},
        "derived": [_derived(one) for one in derived],
        "errors": [_errors(one) for one in found.errors],
        "starts": _starts(found),
        "notes": list(found.notes),
        "data": list(data),
    }


def _material(material: Material) -> Json:
    wear = material.wear
    return {
        "name": material.name,
        "provenance": material.provenance,
        "misfit": material.misfit,
        "inferred": material.inferred,
        "friction": _friction(material.friction),
        "worn": None if wear is None else {"cycles": wear.cycles, **_friction(wear.friction)},
    }


def _friction(law: EllipseFriction) -> Json:
    told = {name: number(getattr(law, name)) for name in ("mu_a", "mu_b", "m0", "n0")}
    return {**told, "phi_deg": number(math.degrees(law.phi))}


def _parameter(one: Estimate) -> Json:
    unit, factor = readable_unit(one.unit)
    return {
        "name": one.name,
        "description": one.description,
        "unit": _NAMES.get(unit, unit.strip()),
        "value": number(factor * one.value),
        "lower": number(factor * one.lower),
        "upper": number(factor * one.upper),
        "standard_error": number(factor * one.standard_error),
        "identifiable": bool(one.identifiable),
        "at_bound": one.at_bound or None,
    }


def _derived(one: Derived) -> Json:
    unit, factor = readable_unit(one.unit)
    values = {name: number(factor * getattr(one, name)) for name in ("value", "lower", "upper")}
    return {"name": one.name, "description": one.description, "unit": _NAMES[unit], **values, "known": one.known}


def _errors(one: KindErrors) -> Json:
    kind, unit, factor = readable_kind(one.kind)
    sizes = (
        "mean",
        "median",
        "rms",
        "left_out_mean",
        "left_out_median",
        "left_out_rms",
        "isotropic_mean",
        "isotropic_median",
    )
    told = {name: number(factor * getattr(one, name)) for name in sizes}
    return {"block": one.block, "kind": kind, "unit": _NAMES.get(unit, unit.strip()), "rows": one.rows, **told}


def _starts(found: Identification) -> Json:
    return {"count": len(found.starts.starts), "arrived": found.starts.arrived, "failed": found.starts.failed}
