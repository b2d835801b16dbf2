"""What was fitted to one set of pushes: in sentences, and on a page of laws, histograms, map,
staircase and turns.
"""

import math
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.measured_cycle_map import (
    FEWEST_FOR_WEAR,
    MapState,
    MeasuredCycleMap,
    TurnPlace,
)
from cyclemap.evidence.laws.set_fit import MotionLaw, SetFit, TurnHistogram
from cyclemap.evidence.laws.turn_bins import AngleHistogram, covered_arcs, is_covered
from cyclemap.views.panels.layout import Panel, draw_panels, page, rows_of
from cyclemap.views.panels.orientation import (
    CIRCLE,
    OUTCOMES,
    SEEN,
    SEEN_BARS,
    draw_law,
    draw_measured,
    draw_outcome,
    draw_pace,
    draw_recorded,
    draw_staircase,
    keep_to,
    turn_axes,
)
from cyclemap.views.panels.style import (
    BAND,
    LINE,
    SECOND,
    Look,
    orbit_marker,
    picture_style,
    say,
    stability,
)
from cyclemap.views.sentences import angle, counted, listed, multiplier_sentence, number, rounded

LATE_BAND: Look = {**BAND, "color": "#cfcfcf", "alpha": 0.75}


@picture_style()
def fit_page(fit: SetFit) -> Figure:
    """Draw what was fitted to a set: a row of its pushes, a row of its cycle map, or as much of
    them as there is.

    Raises InvalidInput where nothing was fitted.
    """
    laws = [law for law in fit.laws if law.law is not None]
    pushes: list[Panel] = [
        (OUTCOMES[law.quantity][0], partial(draw_motion_law, law=law)) for law in laws
    ]
    if fit.histogram is not None:
        pushes.append(("Histogram of Δθ", partial(draw_turn_histogram, histogram=fit.histogram)))
    rows = [row for row in (pushes, _cycle_panels(fit.cycle_map)) if row]
    if not rows:
        raise InvalidInput(
            f"nothing was fitted to {fit.pushes.name}: {fit.law_problem or fit.map_problem}"
        )
    foot = (
        "laws are Fourier series of θ0, their order by cross-validation over blocks of "
        "successive pushes unless given"
    )
    title = f"Fitted to {fit.pushes.name}"
    if len(rows) == 1 and len(rows[0]) > 2:
        half = (len(rows[0]) + 1) // 2
        rows = [rows[0][:half], rows[0][half:]]
    layout, words = rows_of(*map(len, rows)), set_sentences(fit)
    figure, placed = page(layout, title, words, foot, size=(16.0, 9.6), keys=2)
    draw_panels(placed, [panel for row in rows for panel in row])
    return figure


def _cycle_panels(measured: MeasuredCycleMap | None) -> list[Panel]:
    """What is drawn of a measured cycle map."""
    if measured is None:
        return []
    panels: list[Panel] = [("Cycle map", partial(draw_worn_turns, measured=measured))]
    if (forecast := measured.forecast) is not None:
        histograms = forecast.measured_histogram, forecast.histogram
        panels.append(("Directions", lambda axes: draw_recorded(axes, *histograms)))
        climb = forecast.run, forecast.measured, (forecast.lower, forecast.upper)
        panels.append(("Staircase", lambda axes: draw_staircase(axes, *climb)))
        if forecast.pace.measured.size:
            panels.append(("Turns", partial(draw_pace, pace=forecast.pace)))
    return panels


def draw_motion_law(axes: Axes, law: MotionLaw, look: Look = SEEN) -> None:
    """Measured pushes over θ0, the law through them, the band of its mean and that of one push."""
    draw_outcome(axes, law.theta, law.value, law.quantity, look)
    if law.law is None:
        say(axes, "no law")
    else:
        ends = draw_law(axes, law.law, law.quantity, is_covered(law.theta, CIRCLE))
        keep_to(axes, OUTCOMES[law.quantity][2] * law.value, *ends)


def draw_worn_turns(axes: Axes, measured: MeasuredCycleMap) -> None:
    """The measured turns of the cycle, and the fitted map's: early and late where it wears."""
    turns, worn = np.degrees(measured.pairs.turn), measured.fitted.wear
    turn_axes(axes)
    draw_measured(axes, measured.pairs.theta, turns)
    covered = is_covered(measured.pairs.theta, CIRCLE)
    ends: list[float] = []
    states = ((measured.early, LINE, BAND), (measured.late, SECOND, LATE_BAND))
    for state, look, band in states if measured.wears else states[:1]:
        law = measured.fitted.law if worn is None else worn.at(state.cycle)
        name = f"push {state.cycle:.0f}" if measured.wears else "fitted map"
        ends += draw_law(axes, law, "dtheta", covered, name, look, band)
        for orbit in state.fixed_points:
            marker = orbit_marker(stability(orbit))
            axes.plot(np.degrees(orbit.points[0]), 0.0, **marker)
    keep_to(axes, turns, min(ends), max(ends))


def draw_turn_histogram(axes: Axes, histogram: TurnHistogram, look: Look = SEEN_BARS) -> None:
    """Measured counts of Δθ, those the law predicts, and those it predicts without its scatter."""
    edges = np.degrees(histogram.edges)
    axes.stairs(histogram.measured, edges, fill=True, **look)
    axes.stairs(histogram.predicted, edges, label="law with scatter", **LINE)
    # A law alone piles up where it is flat: columns that run out of the panel are told by their
    # height.
    top = float(max(np.max(histogram.measured), np.max(histogram.predicted)))
    alone = float(np.max(histogram.law_alone))
    label = f"law alone, up to {alone:.0f}" if alone > 1.5 * top else "law alone"
    axes.stairs(histogram.law_alone, edges, label=label, **{**SECOND, "linewidth": 0.9})
    axes.set(xlabel=OUTCOMES["dtheta"][1], ylabel="pushes")
    axes.set_ylim(0.0, 1.08 * min(max(top, alone), 1.5 * top))


# Residuals more alike than this make bands and spreads visibly too narrow.
ALIKE = 0.15
# A law that predicts less of the variance than this tells next to nothing.
LITTLE = 0.05


def set_sentences(fit: SetFit) -> list[str]:
    """All that is to be said of a set, in order."""
    said = [count_sentence(fit)]
    said += [law_sentence(law) for law in fit.laws if law.law is not None]
    if (histogram := fit.histogram) is not None:
        chance = f"chance alone makes up to {_share(histogram.chance_total_variation)}"
        said.append(
            "The histogram of Δθ that the law predicts with its scatter has "
            f"{_share(histogram.total_variation)} of the pushes in other bins than measured "
            f"({chance}), {angle(histogram.distance, 2)} away on average; without scatter "
            f"{_share(histogram.law_alone_total_variation)}, "
            f"{angle(histogram.law_alone_distance, 2)}."
        )
    if fit.cycle_map is None:
        return [*said, f"No cycle map: {fit.map_problem}."]
    return [*said, *map_sentences(fit.cycle_map), *filter(None, [multiplier_sentence(fit.rest)])]


def count_sentence(fit: SetFit) -> str:
    """How many pushes, of how many contacts, and what is known of them."""
    pushes, contacts = fit.pushes, fit.pushes.contacts
    pooled = f" at {contacts} contacts, pooled: none was repeated often" if contacts > 1 else ""
    known = "" if pushes.has_motion else " of which θ0 alone is known"
    left = {} if pushes.pairs is None else pushes.pairs.dropped
    reasons = ", ".join(f"{count} left out: {reason}" for reason, count in left.items())
    dropped = f" ({reasons})" if reasons else ""
    counted, arcs = (
        f"{pushes.name}: {pushes.count} pushes{pooled}{known}{dropped}.",
        covered_arcs(pushes.theta),
    )
    if arcs == ((0.0, TWO_PI),):
        return counted
    size = angle(sum(high - low for low, high in arcs), 0)
    where = [f"{angle(low, 0)} to {angle(high % TWO_PI, 0)}" for low, high in arcs]
    return (
        f"{counted} θ0 covers {size} of the circle ({listed(where)}); nothing is said of the rest."
    )


def law_sentence(law: MotionLaw) -> str:
    """Mean and spread of a quantity, and what its law leaves of the spread."""
    fitted = law.law
    assert fitted is not None
    spread = (
        f"{OUTCOMES[law.quantity][0]} {amount(law, fitted.mean)} ± {amount(law, fitted.total_std)}"
    )
    if not law.explained > LITTLE:
        return f"{spread}; θ0 tells next to nothing of it."
    left = f"{amount(law, fitted.rmse)} ({fitted.percent:.1f} %)"
    unseen = f"{amount(law, law.cross_validated_rmse)} in pushes left out"
    order = counted(fitted.harmonics, "harmonic")
    return f"{spread}; a law of θ0 with {order} leaves {left}, {unseen}."


def amount(law: MotionLaw, value: float) -> str:
    """A value of the law's quantity in degrees or millimetres."""
    _, _, scale, unit = OUTCOMES[law.quantity]
    return f"{rounded(scale * value, 2)}{unit}"


def map_sentences(cycle_map: MeasuredCycleMap) -> list[str]:
    """The cycle map: its law, where it holds or is slow, and what it foretells."""
    said, forecast = [order_sentence(cycle_map), place_sentence(cycle_map)], cycle_map.forecast
    if forecast is None and (cycle_map.pairs.path is None or cycle_map.pairs.cycle is None):
        return [*said, "The order of the pushes is unknown: no wear, no staircase."]
    if forecast is None:
        return [
            *said,
            "Its paths leave the orientations that were measured: no staircase is foretold.",
        ]
    spread = f"{np.mean(forecast.turns):.2f} ± {np.std(forecast.turns):.2f}"
    jumps = forecast.left_out_turns
    left_out = f" ({jumps:.2f} of them in cycles left out of the fit)" if abs(jumps) >= 0.01 else ""
    since = f"From push {forecast.first_cycle:.0f} on (the last three quarters)"
    said.append(
        f"{since} {forecast.measured_turns:.2f} turns were measured{left_out}, {spread} are "
        "predicted."
    )
    pace, steps = forecast.pace, []
    for name, end in (("first", 0), ("last", -1))[: min(pace.measured.size, 2)]:
        middle, *ends = (
            number(value[end]) if math.isfinite(value[end]) else "longer than followed"
            for value in (pace.predicted, pace.lower, pace.upper)
        )
        pace_words = (
            f"the {name} full turn took {pace.measured[end]:.0f} pushes, predicted {middle} "
            f"({' to '.join(ends)})"
        )
        steps.append(pace_words)
    share = f"{_share(pace.inside)} of the {pace.measured.size} turns lie in their 95 % ranges"
    said.append(
        f"Of the steps, {'; '.join(steps)}; {share}." if steps else "No full turn was measured."
    )
    measured, predicted = _peak(forecast.measured_histogram), _peak(forecast.histogram)
    chance = angle(float(np.quantile(forecast.run_distances, 0.95)))
    apart = (
        f"{angle(forecast.wasserstein)} apart (of the map's own paths 1 in 20 is more than "
        f"{chance})"
    )
    most = f"θ0 was recorded most often at {measured}, predicted {predicted}"
    return [*said, f"{most}; the histograms are {apart}."]


def order_sentence(measured: MeasuredCycleMap) -> str:
    """The order, wear and scatter of the cycle map."""
    worn, few = measured.fitted.wear, f"{FEWEST_FOR_WEAR} cycles or more would tell"
    law = measured.fitted.law if worn is None else worn.whole
    wear = (
        ""
        if worn is None
        else f", wearing with degree {worn.degree}"
        if measured.wears
        else ", no wear seen"
    )
    if worn is not None and measured.pairs.theta.size < FEWEST_FOR_WEAR:
        wear = f", wear unknown ({few})"
    quiet, loud = (
        f"{angle(place.scatter, 2)} at {angle(place.theta, 0)}"
        for place in (measured.quietest, measured.loudest)
    )
    scatter = f"scatter {angle(law.sigma, 2)}" + (
        "" if law.log_variance.size == 1 else f", from {quiet} to {loud}"
    )
    alike = (
        f"; neighbouring residuals correlate ({law.lag_correlation:.2f}), so bands and "
        "ranges are too narrow"
    )
    tail = alike if law.lag_correlation > ALIKE else ""
    # Whether cross-validation took the largest order it was offered.
    tried = measured.fitted.wear or measured.fitted.law
    most = (
        tried.rmse_by_order is not None and 1 < tried.rmse_by_order.shape[-1] == tried.harmonics + 1
    )
    order = f"{counted(law.harmonics, 'harmonic')}{' (the most tried)' if most else ''}"
    return f"Cycle map of {measured.pairs.theta.size} pairs: {order}{wear}; {scatter}{tail}."


def place_sentence(measured: MeasuredCycleMap) -> str:
    """Where the map holds or is slow, early and late."""
    if not measured.wears:
        places = _places(measured.late)
        return f"{places[0].upper()}{places[1:]}."
    early, late = (f"push {state.cycle:.0f}" for state in (measured.early, measured.late))
    return f"At {early} {_places(measured.early)}. At {late} {_places(measured.late)}."


def _peak(histogram: AngleHistogram) -> str:
    bin_ = int(np.argmax(histogram.density))
    low, high = np.degrees(histogram.edges[bin_ : bin_ + 2])
    return f"{low:.0f}–{high:.0f}°"


def _places(state: MapState) -> str:
    kinds = [f"{orbit.kind} {angle(orbit.points[0])}" for orbit in state.fixed_points]
    has = [f"fixed points: {listed(kinds)}"] if kinds else []
    slow = [
        f"{angle(p.theta)} ({number(p.cycles or math.nan)} pushes; least turn {_interval(p)})"
        for p in state.passages
    ]
    has += (
        [f"{'bottlenecks' if len(slow) > 1 else 'a bottleneck'} at {listed(slow)}"] if slow else []
    )
    open_ = [
        f"{angle(place.theta)}, where a cycle turns by {_interval(place)}"
        for place in state.undecided
    ]
    clauses = [f"it has {listed(has)}"] if has else []
    clauses += [f"it cannot be told whether θ0 rests or passes at {listed(open_)}"] if open_ else []
    slowest = f"{angle(state.slowest.theta)}, a cycle turns by {_interval(state.slowest)}"
    return (
        "; ".join(clauses)
        or f"it has no slow zone among the measured θ0: at the slowest, {slowest}"
    )


def _interval(place: TurnPlace) -> str:
    """A turn with its interval, in the decimals that the interval allows."""
    width = math.degrees(place.upper - place.lower)
    if not width < 360.0:
        return "an angle that these pushes do not tell"
    decimals = 2 if width < 1.0 else 1 if width < 10.0 else 0
    low, high = angle(place.lower, decimals), angle(place.upper, decimals)
    return f"{angle(place.turn, decimals)} ({low} to {high})"


def _share(value: float) -> str:
    return "an unknown share" if math.isnan(value) else f"{100.0 * value:.0f} %"
