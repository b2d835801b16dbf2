"""What was identified, in sentences."""

from collections.abc import Sequence

from cyclemap.evidence.identification.derived_quantities import Derived
from cyclemap.evidence.identification.explanations import Explanation, ExplanationComparison
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identified.identified_material import kind_words
from cyclemap.views.sentences import angle


def headline(name: str, derived: Sequence[Derived]) -> str:
    """The friction ellipse as far as it is known: intervals, for no value is surer than its own."""
    known = {one.name: one for one in derived}
    told = []
    if "axis_ratio" in known:
        longer = _way(known, "axis_direction", " (longer along {})")
        told.append(f"axes {_range(known['axis_ratio'], 1.0, 2)} : 1{longer}")
    if "offset_size" in known:
        towards = _way(known, "offset_direction", " towards {}")
        told.append(f"centre {_range(known['offset_size'], 100.0, 1)} % off{towards}")
    if "mean_friction" in known:
        told.append(f"mean friction {_range(known['mean_friction'], 1.0, 3)}")
    return f"{name}: friction ellipse with {', '.join(told)}" if told else f"{name}: friction taken as isotropic"


def error_sentence(found: Identification) -> str:
    """How far predictions lie from the data."""
    return f"Predictions lie from the data by {'; '.join(kind_words(errors) for errors in found.errors)}."


def note_sentences(found: Identification) -> list[str]:
    """What qualifies the result."""
    return [f"note: {note}" for note in found.notes]


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


def page_sentences(found: Identification, comparison: ExplanationComparison | None) -> list[str]:
    """What is written on the page."""
    said = [f"Ranges are intervals of {100.0 * found.level:g} %.", error_sentence(found)]
    return said + ([] if comparison is None else comparison_sentences(comparison))


def _named(one: Explanation) -> str:
    return f"“{one.name}”"


def _range(one: Derived, factor: float, decimals: int) -> str:
    return _between(f"{factor * one.lower:.{decimals}f}", f"{factor * one.upper:.{decimals}f}")


def _between(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _way(known: dict[str, Derived], name: str, words: str) -> str:
    """The interval of a direction in these words; that it may be any; nothing where it was not asked for."""
    if name not in known:
        return ""
    way = known[name]
    if not way.known:
        return ", in any direction"
    return words.format(_between(angle(way.lower, 0), angle(way.upper, 0)))
