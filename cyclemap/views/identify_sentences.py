"""What was identified, in sentences."""

from collections.abc import Sequence

from cyclemap.evidence.identification.derived_quantities import Derived
from cyclemap.evidence.identification.explanations import Explanation, ExplanationComparison
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identified.identified_material import kind_words
from cyclemap.views.sentences import angle


def headline(name: str, derived: Sequence[Derived]) -> str:
    """The shape of the friction ellipse, as far as it is known."""
    known = {one.name: one for one in derived}
    told = []
    if "axis_ratio" in known:
        told.append(f"axes {known['axis_ratio'].value:.2f} : 1{_along(known.get('axis_direction'))}")
    if "offset_size" in known:
        size, way = known["offset_size"], known.get("offset_direction")
        told.append(f"{100.0 * size.value:.1f} % off centre{_towards(way)}")
    if "mean_friction" in known:
        told.append(f"mean friction {known['mean_friction'].value:.3f}")
    return f"{name}: friction ellipse with {', '.join(told)}" if told else f"{name}: friction taken as isotropic"


def error_sentence(found: Identification) -> str:
    """How far predictions lie from the data."""
    return f"Predictions lie from the data by {'; '.join(kind_words(errors) for errors in found.errors)}."


def note_sentences(found: Identification) -> list[str]:
    """What qualifies the result."""
    return [f"note: {note}" for note in found.notes]


def interval_sentences(derived: Sequence[Derived]) -> list[str]:
    """Intervals of the ellipse's ratio and offset."""
    told = []
    for one in derived:
        if one.name == "axis_ratio":
            told.append(f"The axes' ratio lies between {one.lower:.2f} and {one.upper:.2f}{_way(derived, 'axis')}.")
        if one.name == "offset_size":
            ends = f"{100.0 * one.lower:.1f} and {100.0 * one.upper:.1f} %"
            told.append(f"The centre is between {ends} of the mean radius off{_way(derived, 'offset')}.")
    return told


def comparison_sentences(comparison: ExplanationComparison) -> list[str]:
    """Which explanation predicts best, what the data tell from it, and what remains open."""
    best, others = comparison.best, comparison.explanations[1:]
    worse = [one for one in others if one.told_apart]
    said = [f"Of the explanations, {_named(best)} predicts data left out best."]
    if worse:
        listed = "; ".join(f"{_named(one)} (by {one.worse:.0f} ± {one.standard_error:.0f})" for one in worse)
        said.append(f"Worse by more than the error: {listed}.")
    if comparison.equals:
        listed = "; ".join(_named(one) for one in comparison.equals)
        said.append(f"Not told from it, the difference being within its error: {listed}. This remains open.")
    lost = [one for one in others if one.found is None]
    said += [f"{one.name}: no fit was found ({one.problem})." for one in lost]
    return said


def page_sentences(
    found: Identification, derived: Sequence[Derived], comparison: ExplanationComparison | None
) -> list[str]:
    """What is written on the page."""
    said = [*interval_sentences(derived), error_sentence(found)]
    return said + ([] if comparison is None else comparison_sentences(comparison))


def _named(one: Explanation) -> str:
    return f"“{one.name}”"


def _way(derived: Sequence[Derived], part: str) -> str:
    for one in derived:
        if one.name == f"{part}_direction":
            return (
                f", its direction between {angle(one.lower)} and {angle(one.upper)}"
                if one.known
                else ", its direction open"
            )
    return ""


def _along(way: Derived | None) -> str:
    return f" (longer along {angle(way.value)})" if way is not None and way.known else ""


def _towards(way: Derived | None) -> str:
    return f" towards {angle(way.value)}" if way is not None and way.known else ""
