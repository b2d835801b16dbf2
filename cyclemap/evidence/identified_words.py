"""What is said of an identification: where its numbers come from, what it misses, and what no
surface does: signs that it explains other data than it was told, or none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from cyclemap.evidence.identification.data_block import BELIEF_KINDS, Beliefs
from cyclemap.evidence.identification.identify import Identification, KindErrors
from cyclemap.written import NUMBER, Unit, readable_unit

# Means of errors, by what is said before them.
_MOMENTS = {"": "mean", "left out ": "left_out_mean", "isotropic ": "isotropic_mean"}
# An identification that misses more than isotropic friction, by this factor, has found nothing of
# it.
_WORSE = 1.1
# Half of the places are further off than this share of the object's reach, half of the turns than
# that (rad): on floors they lie within a tenth, and within 10 degrees.
_LOST_PLACE = 0.5
# Between those on floors and the lost ones the object or its frame is another.
_FAR_PLACE = 0.15
_LOST_TURN = math.radians(35.0)
# Beliefs are held against values further away than this many of their standard deviations.
_BEYOND_BELIEF = 4.0
# No floor that was measured has axes of friction beyond 1.7 : 1.
MOST_RATIO = 3.0
_FEWEST = 6


def provenance_words(identified: Identification, sources: Sequence[str]) -> str:
    """Return where the numbers come from, in one paragraph."""
    blocks = [block for block in identified.problem.blocks if not {*block.kinds} & {*BELIEF_KINDS}]
    data = ", ".join(f"{block.name} ({len(block.groups)} values)" for block in blocks)
    origin = f" in {', '.join(sources)}" if sources else ""
    estimates = []
    for row in identified.lasting:
        unit, *sizes = row.readable
        value, lower, upper = (f"{round(size, 6):.4g}" for size in sizes)
        interval = f"{value} ({lower} to {upper}){unit.sign}"
        estimates.append(f"{row.name} {interval if row.identifiable else 'not identifiable'}")
    free = "; ".join(estimates)
    text = f"inferred from {data}{origin}: {free}, intervals of {100 * identified.level:g} %"
    if identified.priors:
        text += f"; believed beforehand, in SI units: {belief_words(identified.priors)}"
    held = "; ".join(
        f"{name} {value:.4g}" for name, value in sorted(identified.problem.fixed.items())
    )
    return text + (f"; held: {held}" if held else "")


def belief_words(beliefs: Beliefs) -> str:
    """Return beliefs (value, standard deviation) in words; those alike for all plates or sessions
    are told once.

    >>> domes = {"plate_dome[hex]": (0.0, 6.0), "plate_dome[tri1]": (0.0, 6.0)}
    >>> belief_words({**domes, "plate_warp_x[hex]": (2.0, 0.5)})
    'plate_dome 0 +- 6, plate_warp_x 2 +- 0.5'
    """
    own: dict[str, dict[str, tuple[float, float]]] = {}
    for name, belief in beliefs.items():
        own.setdefault(name.partition("[")[0], {})[name] = belief
    words = []
    for plain, alike in own.items():
        if len({*alike.values()}) == 1:
            alike = {plain: next(iter(alike.values()))}
        words += [f"{name} {mean:.4g} +- {width:.4g}" for name, (mean, width) in alike.items()]
    return ", ".join(words)


def misfit_words(identified: Identification) -> str:
    """Return the mean of every kind of error, beside what isotropic friction misses; of many blocks
    their ranges.
    """
    sentences = []
    for written in dict.fromkeys(row.kind for row in identified.errors):
        kind, unit = readable_kind(written)
        alike = [row for row in identified.errors if row.kind == written]
        groups = {f"{row.block}, {kind}": [row] for row in alike}
        if len(alike) > 2:
            groups = {f"{kind} in {len(alike)} blocks": alike}
        for name, rows in groups.items():
            sizes = []
            for word, moment in _MOMENTS.items():
                known = [unit.of_si(getattr(row, moment)) for row in rows]
                known = [size for size in known if math.isfinite(size)]
                ends = dict.fromkeys(f"{end(known):.3g}" for end in (min, max) if known)
                sizes += [word + " to ".join(ends)] if ends else []
            beside = f" ({', '.join(sizes[1:])})" if sizes[1:] else ""
            sentences.append(f"{name}: {sizes[0]}{unit.sign}{beside}")
    return "; ".join(sentences)


def readable_kind(kind: str) -> tuple[str, Unit]:
    """Return a kind of noise without its unit, and the unit that it is told in.

    >>> kind, unit = readable_kind("push place (m)")
    >>> kind, unit.sign
    ('push place', ' mm')
    """
    match = re.fullmatch(r"(.*) \((\S+)\)", kind)
    return (kind, NUMBER) if match is None else (match[1], readable_unit(match[2]))


def implausible(identified: Identification, reach: float) -> tuple[str, ...]:
    """Return what speaks against an identification, in words; nothing where it may be right.

    reach : m, of the object from its origin.
    """
    errors = [off for off in identified.errors if off.rows >= _FEWEST]
    doubts = [words for off in errors for words in _lost(off, reach)]
    beside = [off for off in errors if math.isfinite(off.isotropic_median)]
    if beside and all(off.median > _WORSE * off.isotropic_median for off in beside):
        for off in beside:
            isotropic = _size(off, off.isotropic_median)
            doubts.append(f"{_named(off)}, more than isotropic friction's {isotropic}")
    for row in identified.estimates:
        value, deviation = identified.priors.get(row.name, (row.value, math.inf))
        is_shape = row.name.startswith(("ellipticity", "offset"))
        is_beyond = abs(row.value - value) > _BEYOND_BELIEF * deviation
        if is_shape and row.identifiable and is_beyond:
            doubts.append(
                f"{row.name} is {row.value:.3g}, where {value:.3g} ± {deviation:.2g} is usual "
                "(--no-priors believes anything)"
            )
    law = identified.friction()
    low, high = sorted((law.mu_a, law.mu_b))
    if high > MOST_RATIO * low and any(row.identifiable for row in identified.estimates):
        doubts.append(
            f"axes of friction {high / low:.3g} : 1 long; no floor that was measured has them "
            "beyond 1.7 : 1"
        )
    return tuple(dict.fromkeys(doubts))


def far_places(identified: Identification, reach: float) -> tuple[str, ...]:
    """Return which places lie further off than on any floor that was measured, in words.

    reach : m, of the object from its origin.
    """
    words = []
    for off in identified.errors:
        is_place = off.kind.endswith("place (m)") and off.rows >= _FEWEST
        if is_place and off.median > _FAR_PLACE * reach:
            words.append(
                f"{_named(off)}, of an object that reaches {1e3 * reach:.3g} mm; on floors that "
                "were measured half lie within a tenth of that: are outline and origin of its frame "
                "those of the data's poses, and the push's side, place and length those made?"
            )
    return tuple(words)


def _size(off: KindErrors, value: float) -> str:
    _, unit = readable_kind(off.kind)
    return f"{unit.of_si(value):.3g}{unit.sign}"


def _named(off: KindErrors) -> str:
    return (
        f"{off.block}: {readable_kind(off.kind)[0]} off by {_size(off, off.median)} in the median"
    )


def _lost(off: KindErrors, reach: float) -> list[str]:
    """What is wrong with the errors of one kind, whatever isotropic friction's are."""
    if off.kind.endswith("(rad)") and off.median > _LOST_TURN:
        return [f"{_named(off)}, as if at random"]
    if off.kind.endswith("place (m)") and off.median > _LOST_PLACE * reach:
        return [f"{_named(off)}, of an object that reaches {1e3 * reach:.3g} mm"]
    return []
