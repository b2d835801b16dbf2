"""The report of `cyclemap identify` as JSON: degrees and millimetres, every number finite or null."""

import math
from collections.abc import Sequence

from rich.table import Table

from cyclemap.cli.json_report import Json, number
from cyclemap.evidence.identification.cross_validation import KindErrors
from cyclemap.evidence.identification.identify import Estimate, Identification
from cyclemap.evidence.identified_curves import Derived
from cyclemap.evidence.identified_material import readable_kind, readable_unit
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
        "starts": {
            "count": len(found.starts.starts),
            "arrived": found.starts.arrived,
            "failed": found.starts.failed,
        },
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


NOTHING = "–"


def parameter_table(found: Identification) -> Table:
    """Every parameter that the data were asked about: identified with its interval, or held."""
    table = _table(
        "Parameters",
        ("name", "left"),
        ("value", "right"),
        (f"{100.0 * found.level:g} % interval", "right"),
        ("what it is", "left"),
    )
    for one in found.estimates:
        unit, factor = readable_unit(one.unit)
        if not one.identifiable:
            interval = "not identifiable"
        else:
            ends = (_digits(factor * end) + "*" * opened for end, opened in _ends(one))
            interval = " to ".join(ends)
        value = f"{_digits(factor * one.value)}{unit}"
        table.add_row(one.name, value, interval, one.description)
    for name, held in sorted(found.problem.fixed.items()):
        table.add_row(name, _digits(held), "held", "")
    if any(opened for one in found.estimates if one.identifiable for _, opened in _ends(one)):
        table.caption = "* a bound of the parameter, not excluded by the data"
    return table


def derived_table(derived: Sequence[Derived]) -> Table:
    """What follows from the parameters."""
    table = _table("It follows", ("name", "left"), ("value", "right"), ("interval", "right"), ("what it is", "left"))
    for one in derived:
        unit, factor = readable_unit(one.unit)
        value = f"{_digits(factor * one.value)}{unit}"
        interval = f"{_digits(factor * one.lower)} to {_digits(factor * one.upper)}" if one.known else "any"
        table.add_row(one.name.replace("_", " "), value, interval, one.description)
    return table


def error_table(found: Identification) -> Table:
    """How far predictions lie from the data: in the sample, left out, and those of isotropic friction."""
    columns = [("data", "left"), ("error", "left"), ("values", "right"), ("mean", "right"), ("median", "right")]
    columns += [("mean, left out", "right"), ("median", "right"), ("mean, isotropic", "right"), ("median", "right")]
    table = _table("Errors, predicted less measured", *columns)
    for one in found.errors:
        kind, unit, factor = readable_kind(one.kind)
        sizes = (one.mean, one.median, one.left_out_mean, one.left_out_median, one.isotropic_mean, one.isotropic_median)
        told = [f"{_digits(factor * size)}{unit}" if math.isfinite(size) else NOTHING for size in sizes]
        table.add_row(one.block, kind, str(one.rows), *told)
    table.caption = "isotropic: the same friction all around, weight spread evenly, nothing identified"
    return table


def _ends(one: Estimate) -> tuple[tuple[float, bool], tuple[float, bool]]:
    """Both ends of an interval, each with whether it is a bound."""
    return (one.lower, one.lower_open), (one.upper, one.upper_open)


def _table(title: str, *columns: tuple[str, str]) -> Table:
    table = Table(title=title, title_justify="left", caption_justify="left")
    for heading, side in columns:
        table.add_column(heading, justify=side, no_wrap=side == "right")  # type: ignore[arg-type]
    return table


def _digits(value: float) -> str:
    """Three digits, or as many decimals as make sense for a number of this size; less than a millionth is none."""
    if not math.isfinite(value):
        return NOTHING
    if abs(value) < 1e-6:
        return "0"
    return f"{value:.1f}" if abs(value) >= 100.0 else f"{value:.3g}".replace("e-0", "e-")
