"""What was identified, in sentences."""

import math
from collections.abc import Sequence

from cyclemap.arrays import TWO_PI
from cyclemap.evidence.identification.identify import Identification
from cyclemap.evidence.identified_curves import Derived
from cyclemap.evidence.identified_material import misfit_words, readable_kind
from cyclemap.views.sentences import angle

# Errors that differ by less than this are as large.
WORSE = 1.01


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
    return f"Predictions lie from the data by {misfit_words(found)}."


def note_sentences(found: Identification) -> list[str]:
    """What qualifies the result."""
    return [*worse_than_isotropic(found), *(f"note: {note}" for note in found.notes)]


def worse_than_isotropic(found: Identification) -> list[str]:
    """Which data the identified surface predicts worse than isotropic friction does, by 1 %; left out where it was."""
    worse = []
    for one in found.errors:
        mean = one.left_out_mean if one.left_out_mean == one.left_out_mean else one.mean
        if mean > WORSE * one.isotropic_mean:
            kind, unit, factor = readable_kind(one.kind)
            worse.append(f"{one.block}, {kind} ({factor * mean:.3g} against {factor * one.isotropic_mean:.3g}{unit})")
    return [f"Worse than isotropic friction does: {'; '.join(worse)}."] if worse else []


def page_sentences(found: Identification) -> list[str]:
    """What is written on the page."""
    return [f"Ranges are intervals of {100.0 * found.level:g} %.", error_sentence(found), *worse_than_isotropic(found)]


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
    whole = TWO_PI * math.floor((way.lower + math.pi) / TWO_PI)
    return words.format(_between(angle(way.lower - whole, 0), angle(way.upper - whole, 0)))
