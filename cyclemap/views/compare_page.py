"""A prediction beside data: in sentences, and on a page with map, histogram, staircase, and pushes
with poses.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.collection.portrait_curves import TurnCurve
from cyclemap.evidence import Theta0Pairs, turn_bins
from cyclemap.evidence.comparison.compare import Comparison
from cyclemap.evidence.comparison.push_agreement import mean_distances
from cyclemap.maps import DriftingMap
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import entitle, page, rows_of
from cyclemap.views.panels.orientation import OUTCOMES, draw_measured, draw_outcome, draw_staircase
from cyclemap.views.panels.style import DOTS, LINE, PREDICTED, ZERO, degree_axis, picture_style, say
from cyclemap.views.sentences import angle
from cyclemap.views.verdicts import MOST_SETS, told_sets, verdicts

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
    ((_, quantities),) = told_sets(comparison)
    measured = np.concatenate([pushes.measured for pushes in comparison.pushes])
    predicted = np.concatenate([pushes.predicted for pushes in comparison.pushes])
    for column, (axes, quantity) in enumerate(zip(panels, quantities, strict=True)):
        symbol, label, scale, unit = OUTCOMES[quantity.name]
        values = scale * measured[:, column], scale * predicted[:, column]
        orientation.draw_agreement(axes, *values, label, "pushes")
        entitle(axes, f"{symbol}: RMSE {scale * quantity.rmse:.2f}{unit}")


def headline(name: str, comparison: Comparison) -> str:
    """How many of the questions that could be answered agree."""
    answered = [verdict for verdict in verdicts(comparison) if verdict.agrees is not None]
    kept = sum(answer.agrees is True for answer in answered)
    if not answered:
        return f"{name} beside the data"
    return f"{name} agrees with the data in {kept} of {len(answered)} questions"


def data_sentence(comparison: Comparison) -> str:
    """What was compared, and what was left out."""
    pushes = sum(agreement.count for agreement in comparison.pushes)
    cycles = 0 if comparison.data.pairs is None else comparison.data.pairs.theta.size
    used = [f"{pushes} push{'es' * (pushes > 1)} with end poses"] * bool(pushes) + [
        f"{cycles} cycles"
    ] * bool(cycles)
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
    groups = {"Agree": True, "Do not agree": False, "Open": None}
    listed = {
        word: [verdict.question for verdict in verdicts(comparison) if verdict.agrees is answer]
        for word, answer in groups.items()
    }
    return " ".join(
        f"{word}: {', '.join(questions)}." for word, questions in listed.items() if questions
    )


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
