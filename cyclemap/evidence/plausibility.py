"""What no surface does: signs that an identification explains other data than it was told,
or none."""

from __future__ import annotations

import math

from cyclemap.evidence.identification.identify import Identification, KindErrors
from cyclemap.evidence.identified_material import readable_kind

# An identification that misses more than isotropic friction, by this factor, has found nothing of
# it.
_WORSE = 1.1
# Half of the places are further off than this share of the object's reach, half of the turns than
# that (rad): on floors they lie within a tenth, and within 10 degrees.
_LOST_PLACE = 0.5
_LOST_TURN = math.radians(35.0)
# Beliefs are held against values further away than this many of their standard deviations.
_BEYOND_BELIEF = 4.0
# No floor that was measured has axes of friction beyond 1.7 : 1.
MOST_RATIO = 3.0
_FEWEST = 6


def implausible(found: Identification, reach: float) -> tuple[str, ...]:
    """Return what speaks against an identification, in words; nothing where it may be right.

    reach : m, of the object from its origin.
    """
    errors = [off for off in found.errors if off.rows >= _FEWEST]
    said = [words for off in errors for words in _lost(off, reach)]
    beside = [off for off in errors if math.isfinite(off.isotropic_median)]
    if beside and all(off.median > _WORSE * off.isotropic_median for off in beside):
        said += [
            f"{_named(off)}, more than isotropic friction's {_size(off, off.isotropic_median)}"
            for off in beside
        ]
    for estimate in found.estimates:
        value, deviation = found.priors.get(estimate.name, (estimate.value, math.inf))
        shape = estimate.name.startswith(("ellipticity", "offset"))
        if (
            shape
            and estimate.identifiable
            and abs(estimate.value - value) > _BEYOND_BELIEF * deviation
        ):
            said.append(
                f"{estimate.name} is {estimate.value:.3g}, where {value:.3g} ± {deviation:.2g} is "
                "usual (--no-priors believes anything)"
            )
    law = found.friction()
    low, high = sorted((law.mu_a, law.mu_b))
    if high > MOST_RATIO * low and any(estimate.identifiable for estimate in found.estimates):
        said.append(
            f"axes of friction {high / low:.3g} : 1 long; no floor that was measured has them "
            "beyond 1.7 : 1"
        )
    return tuple(dict.fromkeys(said))


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
