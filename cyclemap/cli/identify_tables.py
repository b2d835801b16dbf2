"""The tables of `cyclemap identify`: parameters, what follows from them, errors, and rival explanations."""

import math
from collections.abc import Sequence

from rich.table import Table

from cyclemap.evidence.identification.cross_validation import KindErrors
from cyclemap.evidence.identification.derived_quantities import Derived
from cyclemap.evidence.identification.explanations import Explanation, ExplanationComparison
from cyclemap.evidence.identification.identification import Estimate, Identification
from cyclemap.evidence.identified.identified_material import readable_kind, readable_unit

NOTHING = "–"


def parameter_table(found: Identification) -> Table:
    """Every parameter that the data were asked about: identified with its interval, or held."""
    table = _table(
        "Parameters", ("name", "left"), ("value", "right"), (_interval(found), "right"), ("what it is", "left")
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
    """How far predictions lie from the data, in the sample and for data left out."""
    columns = [("data", "left"), ("error", "left"), ("values", "right"), ("mean", "right"), ("RMS", "right")]
    columns += [("mean, left out", "right"), ("RMS, left out", "right")]
    table = _table("Errors, predicted less measured", *columns)
    for one in found.errors:
        kind, unit, factor = readable_kind(one.kind)
        sizes = (one.mean, one.rms, one.left_out_mean, one.left_out_rms)
        told = [f"{_digits(factor * size)}{unit}" if math.isfinite(size) else NOTHING for size in sizes]
        table.add_row(one.block, kind, str(one.rows), *told)
    return table


def explanation_table(comparison: ExplanationComparison) -> Table:
    """The explanations, the best first: free numbers, errors by kind in and out of the sample, and what they free."""
    kinds = _kinds(comparison.explanations)
    headings = [(f"{block}\n{readable_kind(kind)[0]}{_bracket(kind)}", "right") for block, kind in kinds]
    columns = [("explanation", "left"), ("free", "right"), *headings, ("loss above best", "right"), ("found", "left")]
    table = _table("Explanations, the best first: RMS in the sample / left out", *columns)
    for one in comparison.explanations:
        if one.found is None:
            table.add_row(one.name, NOTHING, *[NOTHING] * len(kinds), NOTHING, one.problem)
            continue
        errors = {(error.block, error.kind): error for error in one.found.errors}
        worse = f"{one.worse:.1f} ± {one.standard_error:.1f}" if one is not comparison.best else "0"
        found = ", ".join(_found(one, name) for name in one.extra)
        table.add_row(one.name, str(len(one.found.estimates)), *(_both(errors[key]) for key in kinds), worse, found)
    return table


def _kinds(explanations: Sequence[Explanation]) -> list[tuple[str, str]]:
    first = next(one.found for one in explanations if one.found is not None)
    return [(error.block, error.kind) for error in first.errors]


def _bracket(kind: str) -> str:
    unit = readable_kind(kind)[1].strip()
    return f" ({unit})" if unit else ""


def _both(error: KindErrors) -> str:
    factor = readable_kind(error.kind)[2]
    return f"{_digits(factor * error.rms)} / {_digits(factor * error.left_out_rms)}"


def _found(one: Explanation, name: str) -> str:
    assert one.found is not None
    estimate = one.found[name]
    unit, factor = readable_unit(estimate.unit)
    ends = f"{_digits(factor * estimate.lower)} to {_digits(factor * estimate.upper)}"
    return f"{name} {_digits(factor * estimate.value)}{unit} ({ends})"


def _interval(found: Identification) -> str:
    return f"{100.0 * found.level:g} % interval"


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
