"""A prediction beside data: on a page with map, histogram, staircase, and pushes with poses; in
sentences; and question by question, whether both agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.collection.portrait_curves import TurnCurve
from cyclemap.evidence import Theta0Pairs, turn_bins
from cyclemap.evidence.comparison.compare import Comparison
from cyclemap.evidence.comparison.cycle_agreement import (
    CycleAgreement,
    DirectionMatch,
    OrientationAgreement,
    SimulatedQuantity,
)
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    QuantityAgreement,
    astray,
    mean_distances,
    pooled_quantities,
)
from cyclemap.evidence.laws.circular_distance import PValue
from cyclemap.maps import DriftingMap
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import entitle, page, rows_of
from cyclemap.views.panels.orientation import OUTCOMES, draw_measured, draw_outcome, draw_staircase
from cyclemap.views.panels.style import DOTS, LINE, PREDICTED, ZERO, degree_axis, picture_style, say
from cyclemap.views.sentences import angle, counted, rounded

# Fewer medians make no line.
FEWEST_MEDIANS = 12
# A lag correlation beyond this makes p-values of independent noise too small.
CORRELATED = 0.2
ISOTROPIC = "isotropic friction under even pressure"


@picture_style()
def compare_page(name: str, comparison: Comparison, curve: TurnCurve) -> Figure:
    """Draw the comparison; ``curve``: the turn of the predicted map (at mid-run where it wears)."""
    many = len(comparison.pushes) > MOST_SETS
    sets = f"; {len(comparison.pushes)} sets of pushes, " if len(comparison.pushes) > 1 else ""
    drawn = ("all are drawn" if many else "the largest is drawn") if sets else ""
    words = (data_sentence(comparison), summary_sentence(comparison))
    kinds = {"loop": "mechanics", "map": "map", "drifting map": "map that wears"}
    noise = (
        ""
        if comparison.cycle is None
        else f" with {angle(comparison.cycle.noise)} of noise a cycle"
    )
    foot = f"predicted by the {kinds[comparison.kind]}{noise}{sets}{drawn}"
    layout = rows_of(*(3,) * ((comparison.cycle is not None) + bool(comparison.pushes)))
    figure, panels = page(layout, headline(name, comparison), words, foot)
    if comparison.cycle is not None:
        _draw_cycles(panels[:3], comparison, curve)
    if comparison.pushes:
        draw = _draw_sets if many else _draw_pushes
        draw(panels[-3:], comparison)
    return figure


@picture_style()
def residual_page(comparison: Comparison) -> Figure | None:
    """Draw measured less predicted over θ0, with medians of 5 degrees: of cycles, of pushes; None
    without either.
    """
    left: list[tuple[str, Array, Array]] = []
    if comparison.cycle is not None and comparison.data.pairs is not None:
        off = np.degrees(comparison.cycle.off)
        left.append(("turn of one cycle (°)", comparison.data.pairs.theta, off))
    if comparison.pushes:
        theta = np.concatenate([pushes.theta for pushes in comparison.pushes])
        off = np.concatenate([pushes.measured - pushes.predicted for pushes in comparison.pushes])
        for column, (_, label, scale, _) in zip(off.T, OUTCOMES.values(), strict=True):
            left.append((label, theta, scale * column))
    if not left:
        return None
    layout = ("a", "ab", "ab;cd", "ab;cd")[len(left) - 1]
    size = (7.0 if layout == "a" else 9.0, 2.7 * len(layout.split(";")))
    figure, panels = page(layout, size=size)
    for axes, (label, theta, off) in zip(panels, left, strict=False):
        axes.axhline(0.0, **ZERO)
        draw_measured(axes, theta, off)
        bins = turn_bins(Theta0Pairs(theta, theta + off))
        if bins.centre.size >= FEWEST_MEDIANS:
            axes.plot(np.degrees(bins.centre), bins.median, **LINE)
        degree_axis(axes)
        axes.set_ylabel(label)
    return figure


def _draw_cycles(panels: list[Axes], comparison: Comparison, curve: TurnCurve) -> None:
    """The cycle map, the directions recorded and the staircase, measured and predicted."""
    turn, histogram, staircase = panels
    assert comparison.cycle is not None and comparison.data.pairs is not None
    orientation.draw_turn(turn, curve)
    orientation.draw_measured_turns(turn, comparison.data.pairs, comparison.cycle.bins)
    is_drifting = isinstance(comparison.prediction.map, DriftingMap)
    entitle(turn, "Cycle map, midway" if is_drifting else "Cycle map")
    if comparison.orientations is None:
        say(histogram, "order of the pushes unknown")
    else:
        orientations = comparison.orientations
        orientation.draw_recorded(histogram, orientations.measured, orientations.predicted)
    entitle(histogram, "Directions")
    path = comparison.data.pairs.path
    if path is None or comparison.staircase is None:
        say(staircase, "order of the pushes unknown")
    else:
        draw_staircase(
            staircase, comparison.staircase.run, path, count="cycle of the compared path"
        )
    entitle(staircase, "Staircase")


def _draw_pushes(panels: list[Axes], comparison: Comparison) -> None:
    """The largest set of pushes over θ0, measured and predicted."""
    largest = comparison.pushes[0]
    for column, (axes, quantity) in enumerate(zip(panels, largest.quantities, strict=True)):
        draw_outcome(axes, largest.theta, largest.measured[:, column], quantity.name)
        symbol, _, scale, _ = OUTCOMES[quantity.name]
        predicted = {**DOTS, "color": PREDICTED, "markeredgewidth": 0.0, "alpha": 1.0}
        theta, values = np.degrees(largest.theta) % 360.0, scale * largest.predicted[:, column]
        axes.plot(theta, values, label="predicted", **{**predicted, "markersize": 2.2})
        spread = f"std {quantity.std_percent:.1f} %"
        entitle(axes, f"{symbol}: RMSE {quantity.percent:.1f} %, {spread}")


def _draw_sets(panels: list[Axes], comparison: Comparison) -> None:
    """Many sets: every push predicted over measured, beside the line where both are equal."""
    ((_, quantities),) = answered_sets(comparison)
    measured = np.concatenate([pushes.measured for pushes in comparison.pushes])
    predicted = np.concatenate([pushes.predicted for pushes in comparison.pushes])
    for column, (axes, quantity) in enumerate(zip(panels, quantities, strict=True)):
        symbol, label, scale, unit = OUTCOMES[quantity.name]
        values = scale * measured[:, column], scale * predicted[:, column]
        orientation.draw_agreement(axes, *values, label, "pushes")
        entitle(axes, f"{symbol}: RMSE {scale * quantity.rmse:.2f}{unit}")


def headline(name: str, comparison: Comparison) -> str:
    """How many of the questions that could be answered agree."""
    answers = [verdict.agrees for verdict in verdicts(comparison) if verdict.agrees is not None]
    if not answers:
        return f"{name} beside the data"
    return f"{name} agrees with the data in {sum(answers)} of {len(answers)} questions"


def data_sentence(comparison: Comparison) -> str:
    """What was compared, and what was left out."""
    pushes = sum(agreement.count for agreement in comparison.pushes)
    cycles = 0 if comparison.data.pairs is None else comparison.data.pairs.theta.size
    used = [f"{counted(pushes, 'push', 'es')} with end poses"] * bool(pushes)
    used += [f"{cycles} cycles"] * bool(cycles)
    out = [f"{count} ({reason})" for reason, count in comparison.data.left_out.items() if count]
    files = [f"{comparison.data.unreadable} unreadable files"] * bool(comparison.data.unreadable)
    left = f"; left out: {', '.join(out + files)}" if out or files else ""
    return f"Compared: {' and '.join(used)}{left}."


def trust_sentences(comparison: Comparison) -> list[str]:
    """What to know before the p-values are believed."""
    doubts = [f"Not certified: {reason}." for reason in comparison.uncertified]
    correlation = 0.0 if comparison.cycle is None else comparison.cycle.lag_correlation or 0.0
    if comparison.orientations is not None and abs(correlation) > CORRELATED:
        doubts.append(
            "What a measured cycle differs from the best smooth map by goes with the next one's "
            f"(correlation {correlation:.2f}): the surface wears or is disturbed slowly, the "
            "simulated noise is not."
        )
    return doubts


def summary_sentence(comparison: Comparison) -> str:
    """The questions by their answer, in a line or two."""
    answered = verdicts(comparison)
    sentences = []
    for word, answer in (("Agree", True), ("Do not agree", False), ("Open", None)):
        questions = [verdict.question for verdict in answered if verdict.agrees is answer]
        if questions:
            sentences.append(f"{word}: {', '.join(questions)}.")
    return " ".join(sentences)


def explanation_sentences(name: str, comparison: Comparison) -> list[str]:
    """What the turns of the measured cycles are explained by, and which of the explanations leaves
    least.
    """
    said = []
    if comparison.pushes:
        sides = zip((name, ISOTROPIC), mean_distances(comparison.pushes), strict=True)
        by_place = sorted(sides, key=lambda side: side[1])
        errors = ", ".join(
            f"{1e3 * place:.1f} mm and {angle(turn)} by {by}" for by, (place, turn) in by_place
        )
        said.append(
            f"Of {sum(agreement.count for agreement in comparison.pushes)} pushes there is left on "
            f"average: {errors}."
        )
    if comparison.cycle is None:
        return said
    cycle = comparison.cycle
    left = {name: cycle.agreement.rms, "one turn for all orientations": cycle.turn.measured_std}
    if cycle.isotropic_rms is not None:
        left[ISOTROPIC] = cycle.isotropic_rms
    errors = ", ".join(
        f"{angle(rms)} by {by}" for by, rms in sorted(left.items(), key=lambda pair: pair[1])
    )
    fitted = (
        ""
        if cycle.scatter is None
        else f"; the best smooth map, fitted to these, {angle(cycle.scatter)}"
    )
    return [
        *said,
        f"Of the turns of {cycle.agreement.pairs} cycles there is left as root mean square "
        f"{errors}{fitted}.",
    ]


# A prediction is rejected below this p-value.
LEVEL = 0.05
# A few pushes in a hundred go wrong on any robot.
_MOST_ASTRAY = 0.1
# More sets of pushes than this are told as one.
MOST_SETS = 3
_KINDS = {"stable": "stable direction", "jump": "attracting jump", "ghost": "slow zone"}


@dataclass(frozen=True)
class Verdict:
    """question : what was asked.
    agrees : the answer, None where it is open.
    words : a sentence with its numbers.
    """

    question: str
    agrees: bool | None
    words: str


@dataclass(frozen=True)
class _Quantity:
    """How a quantity is told: its name, the factor to its unit, that unit, and of how many decimals
    the least, and the most, where fewer leave its interval no width.
    """

    name: str
    scale: float
    unit: str
    least: int = 2
    most: int = 2

    def number(self, value: float, digits: int = 2) -> str:
        """The number alone; never −0."""
        return rounded(self.scale * value, digits)

    def value(self, value: float, digits: int = 2) -> str:
        """The number with its unit."""
        return f"{self.number(value, digits)}{self.unit}"


_DEG = math.degrees(1.0)
_QUANTITIES = {
    "dtheta": _Quantity("turn of a push", _DEG, "°"),
    "dx": _Quantity("Δx", 1e3, " mm"),
    "dy": _Quantity("Δy", 1e3, " mm"),
    "turn": _Quantity("turn of a cycle", _DEG, "°"),
    "turns": _Quantity("number of turns", 1.0, " turns", 1),
    "steps": _Quantity("number of steps", 1.0, " steps", 0, 0),
    "step_height": _Quantity("step height", _DEG, "°", 0, 1),
    "residence": _Quantity("residence on a step", 1.0, " cycles", 0, 1),
}


def verdicts(comparison: Comparison) -> tuple[Verdict, ...]:
    """Return the answer to each question that could be asked, in degrees and millimetres."""
    said = list[Verdict]()
    tell = _pooled_verdict if len(comparison.pushes) > MOST_SETS else _mean_verdict
    for name, quantities in answered_sets(comparison):
        said += [tell(quantity, name) for quantity in quantities]
    if comparison.pushes:
        said.append(_ends_verdict(comparison.pushes))
    if comparison.cycle is not None:
        said += [_turn_verdict(comparison.cycle), _map_verdict(comparison.cycle)]
    if comparison.orientations is not None:
        said.append(_histogram_verdict(comparison.orientations))
    if comparison.directions is not None:
        said += map(_direction_verdict, comparison.directions.matches)
    if comparison.staircase is not None:
        asked = comparison.staircase.quantities.items()
        answers = (_staircase_verdict(_QUANTITIES[name], quantity) for name, quantity in asked)
        said += [answer for answer in answers if answer is not None]
    return tuple(said)


def answered_sets(comparison: Comparison) -> list[tuple[str, tuple[QuantityAgreement, ...]]]:
    """Return the sets of pushes by name with their quantities; more than three are taken
    together.
    """
    if len(comparison.pushes) > MOST_SETS:
        return [(f" in {len(comparison.pushes)} sets", pooled_quantities(comparison.pushes))]
    return [(pushes.name, pushes.quantities) for pushes in comparison.pushes]


def _pooled_verdict(agreement: QuantityAgreement, whose: str) -> Verdict:
    """How near the law comes to single pushes of several protocols, whose means cancel: nothing is
    tested.
    """
    quantity = _QUANTITIES[agreement.name]
    error = "" if agreement.bias_error is None else f" ± {quantity.value(agreement.bias_error)}"
    words = (
        f"Over {agreement.count} pushes{whose} the {quantity.name} is predicted with RMSE "
        f"{quantity.value(agreement.rmse)}, bias {quantity.value(agreement.bias)}{error}; its "
        f"standard deviation is {quantity.value(agreement.measured_std)}."
    )
    return Verdict(f"{quantity.name}{whose}", None, words)


def _mean_verdict(agreement: QuantityAgreement, whose: str) -> Verdict:
    """Whether the mean agrees, and how near the law comes to the single pushes."""
    quantity = _QUANTITIES[agreement.name]
    error = _error(agreement)
    over = f"over {agreement.count} pushes{', ' if error else ''}{error}"
    rmse, least = quantity.value(agreement.rmse), quantity.value(agreement.measured_std)
    # In per cent of the mean, too, unless that mean is nothing beside the spread.
    if agreement.std_percent < 100.0:
        rmse += f" ({agreement.percent:.1f} %)"
        least += f" ({agreement.std_percent:.1f} %)"
    better = "below" if agreement.explains else "not below"
    question = f"mean {quantity.name}{whose}"
    words = (
        f"The {question} {_means(agreement)} {over}; RMSE {rmse}, {better} the {least} that a law "
        "blind to θ0 can reach."
    )
    return Verdict(question, agreement.agrees, words)


def _means(agreement: QuantityAgreement) -> str:
    quantity = _QUANTITIES[agreement.name]
    kept = {True: "agrees within its error", False: "is off", None: "is"}[agreement.agrees]
    measured = quantity.value(agreement.measured_mean)
    return f"{kept}: {measured} measured, {quantity.value(agreement.predicted_mean)} predicted"


def _error(agreement: QuantityAgreement) -> str:
    """The error of a difference, and how much of it is that of the material's parameters."""
    if agreement.bias_error is None:
        return ""
    quantity = _QUANTITIES[agreement.name]
    is_seen = quantity.scale * agreement.model_error >= 0.005
    of_model = f", {quantity.value(agreement.model_error)} of it the material's" if is_seen else ""
    return f"error of the difference {quantity.value(agreement.bias_error)}{of_model}"


def _ends_verdict(pushes: tuple[PushAgreement, ...]) -> Verdict:
    """What knowing the friction is worth: distances, not coordinates; nothing is tested. But pushes
    of which many go astray are others than were predicted, whatever their means are.
    """
    (off, turned), (isotropic_off, isotropic_turned) = mean_distances(pushes)
    words = (
        f"Pushes end {1e3 * off:.1f} mm and {angle(turned)} from the prediction on average; "
        f"isotropic friction is {1e3 * isotropic_off:.1f} mm and {angle(isotropic_turned)} off."
    )
    count = sum(agreement.count for agreement in pushes)
    lost = astray(pushes)
    if lost <= _MOST_ASTRAY * count:
        return Verdict("ends of pushes", None, words)
    words += (
        f" {lost} of {count} end further from it than half their way, or turned by more than 35° "
        "against it: are all of this object, and of this push?"
    )
    return Verdict("ends of pushes", False, words)


def _turn_verdict(agreement: CycleAgreement) -> Verdict:
    error = _error(agreement.turn)
    words = f"The mean turn of a cycle {_means(agreement.turn)}{f' ({error})' if error else ''}."
    return Verdict("mean turn of a cycle", agreement.turn.agrees, words)


def _map_verdict(cycle: CycleAgreement) -> Verdict:
    agreement = cycle.agreement
    misfit = f"{agreement.pairs} cycles lie {angle(agreement.rms)} RMS from the map"
    if cycle.isotropic_rms is not None:
        misfit += f" (isotropic friction {angle(cycle.isotropic_rms)})"
    if agreement.bins:
        misfit += f", the medians of {agreement.bins} directions {angle(agreement.bin_rms)}"
    if cycle.scatter is not None:
        misfit += f"; about the best smooth map of θ0 they scatter by {angle(cycle.scatter)}"
    words = f"{misfit}; their order is unknown, so the map is not tested."
    if cycle.p_value is not None:
        words = f"The map {_tested(cycle.p_value)}: {misfit}."
    return Verdict("cycle map", _kept(cycle.p_value), words)


def _histogram_verdict(agreement: OrientationAgreement) -> Verdict:
    """By Watson's test, the others told beside it: one test decides, so that the level holds."""
    tests = agreement.tests
    kept = _kept(tests["watson"])
    words = (
        f"The histogram of {agreement.count} directions {'agrees' if kept else 'is rejected'} by "
        f"Watson's test ({_p(tests['watson'])}): Wasserstein distance "
        f"{angle(tests['wasserstein'].statistic)} ({_p(tests['wasserstein'])}), total variation "
        f"{tests['total_variation'].statistic:.2f} ({_p(tests['total_variation'])}), Kuiper "
        f"{_p(tests['kuiper'])}."
    )
    return Verdict("histogram of directions", kept, words)


def _direction_verdict(match: DirectionMatch) -> Verdict:
    place = f"{_KINDS[match.kind]} at {_DEG * match.centre % 360.0:.1f}°"
    if match.predicted_mode is None or match.measured_mode is None or match.difference is None:
        words = f"The predicted {place} has no peak of a histogram to be set beside."
        return Verdict(place, None, words)
    predicted, measured = match.predicted_mode, match.measured_mode
    off = f"{round(_DEG * match.difference, 1) + 0.0:+.1f}° off".replace("-", "−")
    tested = "" if match.p_value is None else f" ({_p(match.p_value)})"
    words = (
        f"The predicted {place} makes a predicted peak at {_DEG * predicted % 360.0:.1f}°, "
        f"measured at {_DEG * measured % 360.0:.1f}°: {off}{tested}."
    )
    return Verdict(place, _kept(match.p_value), words)


def _staircase_verdict(quantity: _Quantity, simulated: SimulatedQuantity) -> Verdict | None:
    """The verdict on a number of the staircase; None where it is no question."""
    digits = _telling_digits(quantity, simulated)
    if digits is None or (simulated.measured is None and simulated.predicted is None):
        return None
    measured = "none" if simulated.measured is None else quantity.value(simulated.measured, digits)
    if simulated.predicted is None or simulated.lower is None or simulated.upper is None:
        words = f"The {quantity.name}: {measured} measured, none in any simulated collection."
        return Verdict(quantity.name, None, words)
    tested = "" if simulated.p_value is None else f" {_tested(simulated.p_value)}"
    words = (
        f"The {quantity.name}{tested}: {measured} measured, "
        f"{quantity.value(simulated.predicted, digits)} predicted (95 % of collections: "
        f"{quantity.number(simulated.lower, digits)} to "
        f"{quantity.number(simulated.upper, digits)})."
    )
    return Verdict(quantity.name, _kept(simulated.p_value), words)


def _telling_digits(quantity: _Quantity, simulated: SimulatedQuantity) -> int | None:
    """How many decimals show that the interval has a width; None where none does and the data lie
    in it, to rounding.

    All collections then have the number, the measured one among them, and nothing could be seen to
    fail.
    """
    if simulated.lower is None or simulated.upper is None or simulated.measured is None:
        return quantity.least
    values = (simulated.measured, simulated.lower, simulated.upper)
    for digits in range(quantity.least, quantity.most + 1):
        shown, lowest, highest = (quantity.number(value, digits) for value in values)
        is_inside = simulated.lower <= simulated.measured <= simulated.upper
        if lowest != highest and (shown not in (lowest, highest) or is_inside):
            return digits
    measured, low, high = (round(quantity.scale * value, quantity.most) for value in values)
    # A number that is no count may lie on the other side of a rounding.
    rounding = 1.5 * 10.0**-quantity.most if quantity.most else 0.0
    return None if low == high and abs(measured - low) <= rounding else quantity.most


def _kept(p_value: PValue | None) -> bool | None:
    return None if p_value is None else p_value.value > LEVEL


def _tested(p_value: PValue) -> str:
    return f"agrees ({_p(p_value)})" if _kept(p_value) else f"is rejected at {_p(p_value)}"


def _p(p_value: PValue) -> str:
    """A p-value, and where none of the runs came near, that it may be smaller."""
    least = 1.0 / (p_value.runs + 1)
    return f"p {'≤' if p_value.value <= least * (1.0 + 1e-9) else '='} {p_value.value:.2g}"
