"""A portrait in sentences: which directions it locks into, how fast, and its staircase."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import ROUND_UP, Context
from textwrap import shorten
from typing import TYPE_CHECKING

from cyclemap.arrays import TWO_PI
from cyclemap.collection.lock_forecast import ORIENTATIONS, LockForecast
from cyclemap.collection.portrait import Portrait
from cyclemap.collection.uncertain_directions import (
    FIRST_ORDER,
    DirectionInterval,
    DirectionUncertainty,
)
from cyclemap.maps import RestMultiplier, StaircaseSummary
from cyclemap.mechanics import Material, PressedFootprint, SurfaceShape
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.protocol.settings import SETTINGS

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop
    from cyclemap.evidence import MapAgreement
    from cyclemap.sweeps.direction_margins import DirectionMargin


# A stay longer than this is beyond any experiment: only its order of magnitude is told.
LONGEST_STAY = 1e5
MOST_PEAKS = 3
# Of a material's errors so many letters are told; its file tells all of them.
_MISFIT_LETTERS = 480
# Decimals of a degree at most: no orientation is known better.
_FINEST = 3
# Of a bound, rounded so that it stays one.
_ONE_DIGIT = Context(prec=1, rounding=ROUND_UP)
_COUNTS = {2: "two", 3: "three", 4: "four"}
# A share is told in whole per cent where it is known so well.
_TOLD_SHARE = 0.005


# Of orbits that come back after more cycles noise leaves nothing.
_MOST_IN_TURN = 12


def headline(portrait: Portrait) -> str:
    """The answer in a line: where this material locks in, or rests until noise or wear carries it
    on.
    """
    # Locked is what neither noise nor wear carries off within the run.
    run, wears, known = portrait.staircase.cycles, portrait.worn is not None, portrait.uncertainty
    locked, rests = [], []
    for orbit in portrait.stable_points:
        theta, stay = orbit.points[0], portrait.stay(orbit)
        interval, decimals = _known_to(known, theta)
        spread = "" if interval is None else f" (95 %: {_ends(interval)})"
        place = orientation_and_push(theta, portrait.loop, decimals) + spread
        if stay is not None and stay >= run and not wears:
            locked.append(place)
        else:
            rests.append(
                place if stay is None or stay >= run else f"{place}, for {cycles(stay)} at a time"
            )
    words = [
        f"{how} {listed(places)}"
        for how, places in (("locks into", locked), ("rests at", rests))
        if places
    ]
    jumps = [angle(theta) for theta in portrait.gathering_jumps]
    lock = portrait.rotation.locked
    if not words and jumps:
        words = [f"gathers about {listed(jumps)}"]
    elif not words and lock is not None and 1 < lock.denominator <= _MOST_IN_TURN:
        words = [f"locks into {lock.denominator} directions in turn"]
    words = words or ["locks into no direction"]
    verdict = f"{portrait.loop.material.name} {' and '.join(words)}"
    if known is not None and known.is_posterior and 0 < known.locks < known.samples:
        verdict += f" (locked in {known.chance:.0%} of what its data allow)"
    if portrait.worn is None:
        return verdict
    worn = [angle(zone.centre) for zone in portrait.worn.zones]
    return f"{verdict} when fresh, {f'near {listed(worn)}' if worn else 'nowhere'} when worn"


def orientation_and_push(theta: float, loop: CollectionLoop, decimals: int = 1) -> str:
    """Both answers to "which direction?": the object's orientation, and where the push goes.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> orientation_and_push(math.radians(63.2), CollectionLoop.mit())
    'orientation 63.2°, pushed towards −26.8°'
    """
    towards = math.remainder(theta + push_angle(loop), TWO_PI)
    return f"orientation {angle(theta, decimals)}, pushed towards {angle(towards, decimals)}"


def push_angle(loop: CollectionLoop) -> float:
    """The direction of the push in the object's frame, rad."""
    x, y = first_contact(loop.slider, loop.push, loop.pusher.radius)[1].tolist()
    return math.atan2(y, x)


def uncertainty_sentence(name: str, known: DirectionUncertainty | None) -> str:
    """How well the stable directions of a material are known; empty where nothing is."""
    if known is None:
        return ""
    if not known.is_posterior:
        intervals = [_arc(interval) for interval in known.directions]
        where = f", the stable direction at {listed(intervals)}" if intervals else ""
        many = (
            "neither surface locks in",
            "one of the two surfaces locks in",
            "both surfaces lock in",
        )[known.locks]
        return (
            f"The numbers of {name} come without an error: with the axes' ratio 10 % less or "
            f"more {many}{where}."
        )
    how = "to first order" if known.method == FIRST_ORDER else "each run in full"
    intervals, few = list[str](), list[str]()
    for direction in known.directions:
        count = round(direction.share * known.samples)
        if known.has_interval(direction):
            intervals.append(f"{_ends(direction)} (in {direction.share:.0%} of samples)")
        elif count:
            few.append(f"{count} at {_arc(direction)}")
    places = [f"95 % of them at {listed(intervals)}"] if intervals else []
    places += [f"only {listed(few)}"] if few else []
    of = f"{known.locks} of {known.samples} samples {'has' if known.locks == 1 else 'have'}"
    words = f"Of what the data on {name} allow, {of} a stable direction ({how})"
    return f"{', '.join([words, *places])}."


def ahead_sentence(forecast: LockForecast | None, start: float | None = None) -> str:
    """What the next pushes will bring, of all that is believed; empty where that is not known.

    start : rad, the orientation that they start from, where it is to be said.
    """
    if forecast is None:
        return ""
    likely = []
    for direction in forecast.directions:
        if direction.share >= 0.01:
            place = (
                "any direction"
                if direction.within > 0.5 * math.pi
                else f"{angle(direction.theta, 0)} ± {angle(direction.within, 0)}"
            )
            likely.append(f"{place} ({direction.share:.0%})")
    where = f", at {listed(likely)}" if likely else ""
    seen = forecast.orientations
    locks = f"the loop locks in with a chance of {chance(forecast.chance)}{where}"
    seen_words = (
        f"{seen.median:.0f} of {ORIENTATIONS} orientations will have been seen ({seen.lower:.0f} "
        f"to {seen.upper:.0f})"
    )
    lead = "Of" if start is None else f"From {angle(start % TWO_PI)} on, of"
    return f"{lead} all that is believed, within {forecast.cycles} pushes {locks}; {seen_words}."


def _ends(interval: DirectionInterval) -> str:
    """Where an interval begins and ends; one of more than half a turn tells no direction."""
    low = interval.lower
    high = interval.upper
    decimals = _decimals(interval)
    if high - low > math.pi:
        return "any direction"
    end = high % TWO_PI if high > TWO_PI else high
    return between(angle(low, decimals), angle(end, decimals))


def _arc(interval: DirectionInterval) -> str:
    """An interval on the circle in whole degrees."""
    return between(angle(interval.lower, 0), angle(interval.upper % TWO_PI, 0))


def _decimals(interval: DirectionInterval) -> int:
    """So many that an interval has a few of its last digits."""
    return interval_decimals(math.degrees(interval.upper - interval.lower))


def interval_decimals(width: float) -> int:
    """How many decimals tell the ends of an interval of a width apart, in its own unit, by four of
    the last at least.

    >>> [interval_decimals(width) for width in (10.0, 1.0, 0.1, 0.0)]
    [0, 1, 2, 3]
    """
    return next((decimals for decimals in range(_FINEST) if width * 10.0**decimals >= 4.0), _FINEST)


def multiplier_sentence(multiplier: RestMultiplier | None) -> str:
    """What the last cycles keep of an error, and whether the direction may be on its way out; empty
    without a rest.
    """
    if multiplier is None:
        return ""
    kept, *ends = (
        rounded(end, 2) for end in (multiplier.value, multiplier.lower, multiplier.upper)
    )
    lost = (
        " At 1 the direction is lost: watch whether that share grows."
        if multiplier.upper >= 1.0
        else ""
    )
    return (
        f"Over the last {multiplier.cycles} cycles, at rest near {angle(multiplier.theta, 0)}, "
        f"each keeps {kept} of an error ({' to '.join(ends)}).{lost}"
    )


MARGIN_COLUMNS = ("setting", "here", "change below", "change above", "of the usual range")


def margin_rows(margins: Sequence[DirectionMargin]) -> list[tuple[str, ...]]:
    """For every setting with a change: where it is, the changes on both sides, and the nearer one's
    distance.
    """
    rows = []
    for margin in margins:
        if margin.nearest is None:
            continue
        unit = float(SETTINGS[margin.key].unit.in_si)
        sides = [
            "-"
            if change is None
            else f"{change.value / unit:.4g} ({margin.directions} → {change.directions})"
            for change in (margin.below, margin.above)
        ]
        rows.append((margin.key, f"{margin.value / unit:.4g}", *sides, f"{margin.share:.2%}"))
    return rows


def margin_sentence(margins: Sequence[DirectionMargin]) -> str:
    """The nearest change of the stable directions, and the settings that have none."""
    still = [margin.key for margin in margins if margin.nearest is None]
    rest = (
        f" Within their usual ranges {listed(still)} change{'s' * (len(still) == 1)} no direction."
        if still
        else ""
    )
    if len(still) == len(margins):
        return "No setting alone changes the number of stable directions within its usual range."
    margin, change = margins[0], margins[0].nearest
    assert change is not None
    unit = float(SETTINGS[margin.key].unit.in_si)
    value, error = change.value / unit, change.value.error_bound / unit
    where = "" if math.isnan(change.theta) else f" at {angle(change.theta)}"
    return (
        f"The number of stable directions, {margin.directions}, becomes {change.directions} "
        f"soonest by {margin.key}: at {value:.6g} ± {error:.1g} in place of "
        f"{margin.value / unit:.6g}, a {change.kind}{where}.{rest}"
    )


def worn_rests(worn: StaircaseSummary) -> str:
    """Where θ0 rests on the surface of the last cycle, and how long."""
    if not worn.zones:
        return "nowhere"
    times = [rest.residence_cycles for rest in worn.zones]
    stays = [
        cycles(time) if time <= LONGEST_STAY else "longer than any collection" for time in times
    ]
    rests = [
        f"{angle(zone.centre)} for {stay}" for zone, stay in zip(worn.zones, stays, strict=True)
    ]
    return f"near {listed(rests)}"


def _known_to(
    known: DirectionUncertainty | None, theta: float
) -> tuple[DirectionInterval | None, int]:
    """What 95 % of a posterior say of a stable direction, where they are enough to tell, and to how
    many decimals it may be told: never sharper than that.
    """
    interval = known.of(theta) if known is not None and known.is_posterior else None
    if known is None or interval is None:
        return None, 1
    return (interval, _decimals(interval)) if known.has_interval(interval) else (None, 0)


def lock_sentence(portrait: Portrait) -> str:
    """Which directions the loop locks into, and how fast."""
    jumps, orbits = [angle(theta) for theta in portrait.gathering_jumps], portrait.stable_points
    sentences = []
    if orbits:
        directions = []
        for orbit in orbits:
            _, decimals = _known_to(portrait.uncertainty, orbit.points[0])
            directions.append(angle(orbit.points[0], decimals))
        multipliers = listed(rounded(orbit.multiplier, 3) for orbit in orbits)
        # How many cycles take an error to its tenth.
        sizes = [abs(orbit.multiplier) for orbit in orbits]
        after = [
            "less than 1"
            if size < 0.1
            else "ever more"
            if size >= 1.0
            else number(math.log(0.1) / math.log(size))
            for size in sizes
        ]
        stable = f"Stable at {listed(directions)}, multiplier {multipliers}"
        sentences.append(f"{stable}: a tenth of an error is left after {listed(after)} cycles.")
    if jumps:
        sentences.append(f"Orbits gather about the jump at {listed(jumps)}.")
    if sentences:
        return " ".join(sentences if portrait.worn is None else ["Fresh:", *sentences])
    turns = portrait.turns
    value = portrait.rotation.value
    pace = (
        f"a full turn takes {cycles(1 / abs(value))}"
        if value
        else "over many cycles it gets nowhere"
    )
    turned = between(angle(turns.min_turn), angle(turns.max_turn))
    return f"Without noise a cycle turns the object by {turned}; {pace}."


def noise_sentence(portrait: Portrait) -> str:
    """What noise makes of it: the recorded directions and how soon the start is forgotten."""
    fresh = "" if portrait.worn is None else " on the fresh surface"
    operator, noise = (
        portrait.operator,
        f"With {angle(portrait.noise.sigma)} of noise a cycle{fresh}",
    )
    forgotten = cycles(operator.mixing_cycles)
    away = portrait.tv_from_uniform
    if away is None and len(portrait.stable_points) < 2:
        return (
            f"{noise} the map is not known well enough to tell how often each direction is "
            "recorded."
        )
    if away is None or (len(portrait.stable_points) > 1 and operator.mixing_cycles > LONGEST_STAY):
        stays = "stays at the stable direction it falls into first"
        return f"{noise} the loop {stays}, and moves on once in {forgotten}."
    peaks = portrait.highest_peaks[:MOST_PEAKS]
    where = f"peak at {listed([angle(peak) for peak in peaks])}" if peaks else "have no peak"
    sentence = f"{noise} the recorded directions {where} ({away:.0%} away from uniform); "
    sentence += f"the start is forgotten in {forgotten}."
    held = [direction for direction in portrait.held if direction.share.error_bound < _TOLD_SHARE]
    if len(held) < 2:
        return sentence
    shares = listed(
        [f"{direction.share:.0%} near {angle(direction.peak, 0)}" for direction in held]
    )
    change = 1.0 / sum(direction.share * direction.leaving for direction in held)
    many = _COUNTS.get(len(held), str(len(held)))
    return f"{sentence} Noise holds {many} directions: {shares}, a change every {cycles(change)}."


def staircase_sentence(portrait: Portrait) -> str:
    """What the staircase of θ0 over the cycles looks like."""
    expected = portrait.prediction
    pace = f"on average θ0 moves {angle(expected.mean_turn, 2)} a cycle"
    if portrait.worn is not None:
        path = portrait.staircase.theta
        run = f"one run of {portrait.staircase.cycles} cycles (seed {portrait.staircase.seed})"
        climbed = rounded((path[-1] - path[0]) / TWO_PI, 1)
        return (
            f"As the surface wears, {run} makes {climbed} turns; by then θ0 rests "
            f"{worn_rests(portrait.worn)}."
        )
    if expected.step is None or expected.mean_residence_cycles is None:
        return f"The staircase has no flat steps: {pace}."
    stay = cycles(expected.mean_residence_cycles)
    if expected.mean_residence_cycles > LONGEST_STAY:
        return f"The staircase is flat: noise carries it off a step once in {stay}."
    return (
        f"The staircase rests {stay} on a step, steps are {angle(expected.step, 0)} high, and "
        f"{pace}."
    )


def agreement_sentence(agreement: MapAgreement) -> str:
    """How far measured turns lie from the predicted map."""
    return (
        f"{agreement.pairs} measured cycles lie {angle(agreement.rms)} RMS from the predicted "
        f"turn; the medians of {agreement.bins} directions {angle(agreement.bin_rms)}."
    )


def parameters_line(portrait: Portrait) -> str:
    """The friction law, shapes of floor and object, the rod and the ring, with units."""
    loop, law = portrait.loop, portrait.loop.material.friction
    ring_x, ring_y = (1000 * coordinate for coordinate in loop.slider.hitch)
    friction = (
        f"friction μa {law.mu_a:.4g}, μb {law.mu_b:.4g}, m0 {law.m0:.4g}, n0 {law.n0:.4g}, φ "
        f"{angle(law.phi)}"
    )
    if math.isclose(law.mu_a, law.mu_b, rel_tol=1e-5) and law.m0 == law.n0 == 0.0:
        friction = f"friction {law.mu_a:.3g} all around"
    clauses = [friction]
    if isinstance(loop.footprint, PressedFootprint):
        shapes = {"floor": loop.footprint.floor, "plate": loop.footprint.plate}
        clauses += [
            f"{name} {shape_words(shape)}" for name, shape in shapes.items() if not shape.is_flat
        ]
    clauses.append(f"rod ⌀ {2000 * loop.pusher.radius:g} mm, μ {loop.pusher.friction:.3g}")
    return "  ·  ".join([*clauses, f"ring at ({ring_x:.1f}, {ring_y:.1f}) mm"])


def shape_words(shape: SurfaceShape) -> str:
    """Dome and bow, mean pressures at 50 mm, and the bow's axis.

    >>> shape_words(SurfaceShape(8.2, 3.7, 1.5))
    'dome 8.2, bow 3.7 along 86°'
    """
    return f"dome {shape.dome:.2g}, bow {shape.bow:.2g} along {angle(shape.axis, 0)}"


def material_line(material: Material) -> str:
    """That a material was inferred and how far it misses its data, and that it wears.

    Empty where nothing is to be said.

    >>> from cyclemap.mechanics import load_material
    >>> material_line(load_material("unknown"))
    'unknown was inferred, not measured'
    """
    misfit = _first_clauses(material.misfit, _MISFIT_LETTERS)
    how_far = f": {misfit}" if misfit else ""
    said = [f"{material.name} was inferred, not measured{how_far}"] if material.inferred else []
    said += [f"{material.name}: {misfit}"] if misfit and not material.inferred else []
    if material.wear is not None:
        said.append(f"it wears over {material.wear.cycles:g} cycles")
    return "; ".join(said)


def _first_clauses(text: str, letters: int) -> str:
    """The first clauses of a text, and how many more there are; all of one that is short."""
    if len(text) <= letters:
        return text
    clauses = text.split("; ")
    kept = clauses[:1]
    for clause in clauses[1:]:
        if len("; ".join([*kept, clause])) > letters:
            break
        kept.append(clause)
    shown, left = "; ".join(kept), len(clauses) - len(kept)
    shown = shorten(shown, letters, placeholder=" ...") if len(shown) > letters else shown
    return f"{shown}; {left} more in its file" if left else shown


def push_line(portrait: Portrait) -> str:
    """The object and where it is pushed, with units."""
    loop = portrait.loop
    slanted = f", {angle(loop.push.angle)} off its normal" if loop.push.angle else ""
    place = f"on side {loop.push.side} at {loop.push.fraction:g}{slanted}"
    return f"{loop.slider.name} pushed {1000 * loop.push.distance:g} mm {place}"


def accuracy_line(portrait: Portrait) -> str:
    """How the map was computed and how well."""
    error = _ONE_DIGIT.create_decimal(math.degrees(portrait.map.max_error))
    return f"cycle map from {portrait.map.samples} computed cycles, estimated error {error:f}°"


def angle(radians: float, decimals: int = 1) -> str:
    """An angle for people, in degrees.

    >>> angle(math.pi / 3)
    '60.0°'
    """
    return f"{rounded(math.degrees(radians), decimals)}°"


def rounded(value: float, decimals: int) -> str:
    """A number for people, with so many decimals; never −0.

    >>> rounded(-1.25, 1), rounded(-0.001, 2)
    ('−1.2', '0.00')
    """
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")


def between(low: str, high: str) -> str:
    """Both ends of a range, or the one that they read as.

    >>> between("1°", "2°"), between("1°", "1°")
    ('1° to 2°', '1°')
    """
    return low if low == high else f"{low} to {high}"


def chance(share: float) -> str:
    """A chance for people: what some hundred samples tell is never quite sure.

    >>> chance(0.0), chance(0.421), chance(1.0)
    ('less than 1%', '42%', 'more than 99%')
    """
    if share < 0.01:
        return "less than 1%"
    return "more than 99%" if share > 0.99 else f"{share:.0%}"


def number(value: float) -> str:
    """A count for people: whole from ten on, a power of ten when it is beyond any experiment.

    >>> number(1.234), number(12.345), number(3.2e9)
    ('1.2', '12', '10^9')
    """
    if value >= 1e12:
        return "more than 10^12"
    if value >= LONGEST_STAY:
        return f"10^{math.floor(math.log10(value))}"
    return f"{value:.1f}" if value < 10 else f"{value:.0f}"


def cycles(value: float | None) -> str:
    """A number of cycles for people."""
    return "an unknown number of cycles" if value is None else f"{number(value)} cycles"


def counted(count: int, noun: str, plural: str = "s") -> str:
    """A number of things for people.

    >>> counted(1, "cycle"), counted(3, "push", "es")
    ('1 cycle', '3 pushes')
    """
    return f"{count} {noun}{plural * (count != 1)}"


def listed(words: Iterable[str]) -> str:
    """Words in a row, with "and" before the last.

    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
