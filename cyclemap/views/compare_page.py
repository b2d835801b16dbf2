"""A prediction beside data: in sentences, and on a page with map, histogram, staircase, and pushes
with poses.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.arrays import TWO_PI
from cyclemap.collection.portrait_curves import TurnCurve
from cyclemap.evidence import Theta0Pairs, turn_bins
from cyclemap.evidence.comparison.compare import Comparison
from cyclemap.evidence.comparison.push_agreement import mean_distances
from cyclemap.views import style
from cyclemap.views.portrait_page import (
    PER_DEGREE,
    draw_measured_histogram,
    draw_measured_turns,
    draw_staircase,
    draw_turn,
)
from cyclemap.views.sentences import angle
from cyclemap.views.style import PREDICTED, QUIET
from cyclemap.views.verdicts import MOST_SETS, told_sets, verdicts

# Points between a panel and its title, so that the legend has a line of its own.
TITLE_PAD = 22.0
# Fewer medians make no line.
FEWEST_MEDIANS = 12
# Symbol, label and the factor to its unit.
_LABELS = {
    "dtheta": ("Δθ", "turn of a push (°)", float(np.degrees(1.0))),
    "dx": ("Δx", "Δx (mm)", 1000.0),
    "dy": ("Δy", "Δy (mm)", 1000.0),
}
# A lag correlation beyond this makes p-values of independent noise too small.
CORRELATED = 0.2
ISOTROPIC = "isotropic friction under even pressure"


@style.picture_style()
def compare_page(name: str, found: Comparison, curve: TurnCurve) -> Figure:
    """Draw the comparison; ``curve``: the turn of the predicted map (at mid-run where it wears)."""
    figure = style.new_figure()
    rows = bool(found.pushes) + (found.cycle is not None)
    grid = GridSpec(
        max(rows, 1),
        3,
        figure,
        left=0.06,
        right=0.985,
        bottom=0.125,
        top=0.775,
        wspace=0.24,
        hspace=0.62,
    )
    if found.cycle is not None:
        _draw_cycles([figure.add_subplot(grid[0, column]) for column in range(3)], found, curve)
    if found.pushes:
        panels = [figure.add_subplot(grid[rows - 1, column]) for column in range(3)]
        draw = _draw_pushes if len(found.pushes) <= MOST_SETS else _draw_sets
        draw(panels, found)
    drawn = "all are drawn" if len(found.pushes) > MOST_SETS else "the largest is drawn"
    sets = f"; {len(found.pushes)} sets of pushes, {drawn}" if len(found.pushes) > 1 else ""
    told = (data_sentence(found), summary_sentence(found))
    kinds = {"loop": "mechanics", "map": "map", "drifting map": "map that wears"}
    noise = "" if found.cycle is None else f" with {angle(found.cycle.noise)} of noise a cycle"
    foot = f"predicted by the {kinds[found.prediction.kind]}{noise}{sets}"
    style.write_page(figure, headline(name, found), told, foot)
    return figure


@style.picture_style()
def residual_page(found: Comparison) -> Figure | None:
    """Draw measured less predicted over θ0, with medians of 5 degrees: of cycles, of pushes; None
    without either.
    """
    left = (
        []
        if found.cycle is None or found.data.pairs is None
        else [("turn of a cycle (°)", found.data.pairs.theta, np.degrees(found.cycle.off))]
    )
    if found.pushes:
        theta = np.concatenate([one.theta for one in found.pushes])
        off = np.concatenate([one.measured - one.predicted for one in found.pushes])
        left += [
            (label, theta, scale * off[:, column])
            for column, (_, label, scale) in enumerate(_LABELS.values())
        ]
    if not left:
        return None
    columns = min(len(left), 2)
    rows = -(-len(left) // columns)
    figure = style.new_figure(5.0 + 2.0 * columns, 2.7 * rows)
    grid = GridSpec(
        rows,
        columns,
        figure,
        left=0.1,
        right=0.98,
        bottom=0.2 / rows,
        top=1.0 - 0.05 / rows,
        wspace=0.2,
        hspace=0.35,
    )
    for number, (label, theta, off) in enumerate(left):
        axes = figure.add_subplot(grid[number // columns, number % columns])
        axes.axhline(0.0, color=QUIET, linewidth=0.9)
        axes.plot(np.degrees(np.mod(theta, TWO_PI)), off, marker="o", **style.DOTS)
        bins = turn_bins(Theta0Pairs(theta, theta + off))
        if bins.centre.size >= FEWEST_MEDIANS:
            axes.plot(np.degrees(bins.centre), bins.median, color=PREDICTED, linewidth=1.6)
        style.degree_axis(axes)
        axes.set_ylabel(label)
    return figure


def _draw_cycles(panels: list[Axes], found: Comparison, curve: TurnCurve) -> None:
    """The cycle map, the directions recorded and the staircase, measured and predicted."""
    turn, histogram, staircase = panels
    assert found.cycle is not None and found.data.pairs is not None
    draw_turn(turn, curve, ())
    draw_measured_turns(turn, found.data.pairs, found.cycle.bins)
    turn.set_title(
        "Cycle map, midway" if found.prediction.is_drifting else "Cycle map", pad=TITLE_PAD
    )
    style.legend_above(turn)
    histogram.set_title("Directions", pad=TITLE_PAD)
    style.degree_axis(histogram)
    histogram.set_ylabel("probability per degree")
    if found.orientations is None:
        style.say(histogram, "order of the pushes unknown")
    else:
        draw_measured_histogram(histogram, found.orientations.measured)
        predicted = found.orientations.predicted
        heights, edges = PER_DEGREE * predicted.density, np.degrees(predicted.edges)
        histogram.stairs(
            heights, edges, color=PREDICTED, linewidth=1.6, label="predicted", zorder=3
        )
        histogram.set_ylim(bottom=0.0)
        style.legend_above(histogram)
    staircase.set_title("Staircase", pad=TITLE_PAD)
    if found.data.pairs.path is None or found.staircase is None:
        style.say(staircase, "order of the pushes unknown")
    else:
        draw_staircase(staircase, found.staircase.run, found.data.pairs.path)
        staircase.set_xlabel("cycle of the compared path")
        style.legend_above(staircase)


def _draw_pushes(panels: list[Axes], found: Comparison) -> None:
    """The largest set of pushes over θ0, measured and predicted."""
    largest = found.pushes[0]
    theta = np.degrees(np.mod(largest.theta, 2 * np.pi))
    for column, (axes, quantity) in enumerate(zip(panels, largest.quantities, strict=True)):
        symbol, label, scale = _LABELS[quantity.name]
        axes.plot(
            theta,
            scale * largest.measured[:, column],
            marker="o",
            label="measured",
            zorder=2,
            **style.DOTS,
        )
        predicted = scale * largest.predicted[:, column]
        axes.plot(
            theta, predicted, ".", color=PREDICTED, markersize=4.0, label="predicted", zorder=3
        )
        style.degree_axis(axes)
        axes.set_ylabel(label)
        axes.set_title(
            f"{symbol}: RMSE {quantity.percent:.1f} %, std {quantity.std_percent:.1f} %",
            pad=TITLE_PAD,
        )
        style.legend_above(axes)


def _draw_sets(panels: list[Axes], found: Comparison) -> None:
    """Many sets: every push measured over predicted, beside the line where both are equal."""
    ((_, quantities),) = told_sets(found)
    for column, (axes, quantity) in enumerate(zip(panels, quantities, strict=True)):
        symbol, label, scale = _LABELS[quantity.name]
        for one in found.pushes:
            axes.plot(
                scale * one.predicted[:, column],
                scale * one.measured[:, column],
                marker="o",
                zorder=2,
                **style.DOTS,
            )
        axes.axline(
            (0.0, 0.0), slope=1.0, color=PREDICTED, linewidth=1.6, label="as predicted", zorder=3
        )
        axes.set(xlabel=f"predicted {label}", ylabel=f"measured {label}")
        unit = "°" if quantity.name == "dtheta" else " mm"
        axes.set_title(f"{symbol}: RMSE {scale * quantity.rmse:.2f}{unit}", pad=TITLE_PAD)
        style.legend_above(axes)


def headline(name: str, found: Comparison) -> str:
    """How many of the questions that could be answered agree."""
    answered = [one for one in verdicts(found) if one.agrees is not None]
    kept = sum(one.agrees is True for one in answered)
    if not answered:
        return f"{name} beside the data"
    return f"{name} agrees with the data in {kept} of {len(answered)} questions"


def data_sentence(found: Comparison) -> str:
    """What was compared, and what was left out."""
    pushes = sum(one.count for one in found.pushes)
    cycles = 0 if found.data.pairs is None else found.data.pairs.theta.size
    used = [f"{pushes} push{'es' * (pushes > 1)} with end poses"] * bool(pushes) + [
        f"{cycles} cycles"
    ] * bool(cycles)
    out = [f"{count} ({reason})" for reason, count in found.data.left_out.items() if count]
    files = [f"{found.data.unreadable} unreadable files"] * bool(found.data.unreadable)
    left = f"; left out: {', '.join(out + files)}" if out or files else ""
    return f"Compared: {' and '.join(used)}{left}."


def trust_sentences(found: Comparison) -> list[str]:
    """What to know before the p-values are believed."""
    told = [f"Not certified: {one}." for one in found.uncertified]
    correlation = 0.0 if found.cycle is None else found.cycle.lag_correlation or 0.0
    if found.orientations is not None and abs(correlation) > CORRELATED:
        told.append(
            "What a measured cycle differs from the best smooth map by goes with the next one's "
            f"(correlation {correlation:.2f}): the surface wears or is disturbed slowly, the "
            "simulated noise is not."
        )
    return told


def summary_sentence(found: Comparison) -> str:
    """The questions by their answer, in a line or two."""
    answers = verdicts(found)
    groups = {"Agree": True, "Do not agree": False, "Open": None}
    listed = {
        word: [one.question for one in answers if one.agrees is answer]
        for word, answer in groups.items()
    }
    return " ".join(
        f"{word}: {', '.join(questions)}." for word, questions in listed.items() if questions
    )


def explanation_sentences(name: str, found: Comparison) -> list[str]:
    """What the turns of the measured cycles are explained by, and which of the explanations leaves
    least.
    """
    said = []
    if found.pushes:
        sides = zip((name, ISOTROPIC), mean_distances(found.pushes), strict=True)
        by_place = sorted(sides, key=lambda side: side[1])
        told = ", ".join(
            f"{1e3 * place:.1f} mm and {angle(turn)} by {one}" for one, (place, turn) in by_place
        )
        said.append(
            f"Of {sum(one.count for one in found.pushes)} pushes there is left on average: {told}."
        )
    if found.cycle is None:
        return said
    cycle = found.cycle
    left = {name: cycle.agreement.rms, "one turn for all orientations": cycle.turn.measured_std}
    if cycle.isotropic_rms is not None:
        left[ISOTROPIC] = cycle.isotropic_rms
    told = ", ".join(
        f"{angle(rms)} by {one}" for one, rms in sorted(left.items(), key=lambda pair: pair[1])
    )
    fitted = (
        ""
        if cycle.scatter is None
        else f"; the best smooth map, fitted to these, {angle(cycle.scatter)}"
    )
    return [
        *said,
        f"Of the turns of {cycle.agreement.pairs} cycles there is left as root mean square "
        f"{told}{fitted}.",
    ]
