"""The portrait of a loop on one page, and its panels: turn, cobweb, histogram of directions,
staircase.
"""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.portrait import Portrait
from cyclemap.collection.portrait_curves import Cobweb, PortraitCurves, TurnCurve
from cyclemap.collection.uncertain_directions import DirectionInterval
from cyclemap.maps import Orbit
from cyclemap.views import sentences, style
from cyclemap.views.object_page import cycle_key, draw_cycle
from cyclemap.views.style import INK, MEASURED, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, QUIET

if TYPE_CHECKING:
    from cyclemap.evidence import AngleHistogram, MeasuredOverlay, Theta0Pairs, TurnBins


# The top of its panel, where titles stand anyway; said, it spares Matplotlib the measuring of every
# tick label.
_TITLE_PLACE = 1.0
# A legend of four entries stands beside the longest title.
_NARROW: dict[str, Any] = {
    "handlelength": 1.2,
    "handletextpad": 0.4,
    "columnspacing": 0.8,
    "fontsize": 7.5,
}
# So many letters of a headline fill the page at full size.
_HEADLINE_LETTERS = 84
# Letters of a line at the foot.
_FOOT_LETTERS = 148


@style.picture_style()
def portrait_page(
    portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None = None
) -> Figure:
    """Draw `portrait`, whose curves are `curves`, with `measured` over it where given."""
    figure = style.new_figure()
    grid = GridSpec(
        2,
        3,
        figure,
        width_ratios=(5.2, 2.75, 3.2),
        left=0.055,
        right=0.99,
        bottom=0.145,
        top=0.80,
        wspace=0.24,
        hspace=0.42,
    )
    panels = [figure.add_subplot(grid[row, column]) for column in range(3) for row in range(2)]
    turn, density, cobweb, staircase, push, drag = panels
    known = portrait.uncertainty
    draw_turn(turn, curves.turn, portrait.fixed_points, () if known is None else known.directions)
    if measured is not None:
        draw_measured_turns(turn, measured.pairs, measured.bins)
    draw_density(density, curves)
    if measured is not None:
        draw_measured_histogram(density, measured.histogram)
    density.set_ylim(bottom=0.0)
    for axes in (turn, density):
        # On the title's line, where it can cover nothing.
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2, **_NARROW
        )
    draw_cobweb(cobweb, curves.cobweb, portrait.fixed_points)
    place = "the jump" if portrait.gathering_jumps else "the slowest direction"
    place = "the stable direction" if portrait.stable_points else place
    about = "" if curves.cobweb.high - curves.cobweb.low > 6.2 else f" about {place}"
    path = None if measured is None else measured.pairs.path
    draw_staircase(staircase, portrait.staircase.theta, path)
    if path is not None:
        staircase.legend(loc="upper left")
    draw_cycle(push, drag, curves.scene)
    cycle = portrait.cycle
    start, pushed, dragged = map(sentences.angle, (cycle.theta, cycle.push_turn, cycle.drag_turn))
    titles = (
        f"Turn of one cycle{', fresh' * (portrait.worn is not None)}",
        *("Directions recorded", f"Cobweb{about}", "Staircase"),
        *(f"Push from {start}: turns {pushed}", f"Drag by the ring: turns {dragged}"),
    )
    for axes, title in zip(panels, titles, strict=True):
        axes.set_title(title, y=_TITLE_PLACE)
    _write_words(figure, portrait, curves, measured)
    return figure


def _write_words(
    figure: Figure, portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None
) -> None:
    material, said = portrait.loop.material, sentences.headline(portrait)
    tellers = (sentences.lock_sentence, sentences.noise_sentence, sentences.staircase_sentence)
    told = [
        *(tell(portrait) for tell in tellers),
        sentences.uncertainty_sentence(material.name, portrait.uncertainty),
    ]
    style.write_page(figure, said, told, size=18.0 * min(1.0, _HEADLINE_LETTERS / len(said)))
    inferred = f"{material.name} was inferred, not measured  ·  " if material.inferred else ""
    how = f"{sentences.push_line(portrait)}  ·  {sentences.accuracy_line(portrait)}"
    foot = [sentences.parameters_line(portrait), f"{inferred}{how}"]
    if measured is not None:
        foot.append(sentences.agreement_sentence(measured.agreement))
    # Beside the key of the drawings, whose lines begin where these must end.
    lines = "\n".join(fill(line, _FOOT_LETTERS) for line in foot)
    for x, words, side in ((0.015, lines, "left"), (0.985, cycle_key(curves.scene), "right")):
        figure.text(x, 0.01, words, ha=side, va="bottom", fontsize=8, color=QUIET, linespacing=1.35)


PER_DEGREE = np.pi / 180
LEAST_SPAN_DEG = 120.0


def draw_turn(
    axes: Axes,
    curve: TurnCurve,
    fixed_points: tuple[Orbit, ...],
    known: tuple[DirectionInterval, ...] = (),
) -> None:
    """The turn of one cycle over θ0, with the fixed points on its zero line and bands of where they
    may lie.
    """
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    for number, one in enumerate(known):
        label = "may lie here" if number == 0 else None
        for back in (0.0, 360.0) if one.upper > 2 * np.pi else (0.0,):
            ends = np.clip(np.degrees([one.lower, one.upper]) - back, 0.0, 360.0)
            axes.axvspan(
                *ends.tolist(),
                color=PREDICTED_FILL,
                linewidth=0.0,
                label=label if back == 0.0 else None,
                zorder=0,
            )
    for index, (theta, turn) in enumerate(curve.pieces):
        label = "predicted" if index == 0 else None
        axes.plot(
            np.degrees(theta),
            np.degrees(turn),
            color=PREDICTED,
            linewidth=2.0,
            label=label,
            zorder=3,
        )
    for jump in curve.jumps:
        place, ends = np.degrees(jump.theta), np.degrees([jump.before, jump.after])
        axes.plot([place, place], ends, color=PREDICTED, linewidth=1.0, linestyle=":", zorder=3)
    for orbit in fixed_points:
        at = float(np.degrees(orbit.points[0]))
        axes.plot(at, 0.0, **_marker(orbit))
        name = f"{at:.1f}° {'stable' if orbit.stable else 'unstable'}"
        style.name_beside(axes, at, 0.0, name, (7 if at < 290 else -7, 9 if orbit.stable else -16))
    style.degree_axis(axes)
    axes.set_ylabel("turn of one cycle, f(θ0) - θ0 (°)")
    axes.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 3, 5, 6, 10]))
    axes.margins(y=0.12)


def draw_measured_turns(axes: Axes, pairs: Theta0Pairs, bins: TurnBins) -> None:
    """Measured pairs as light dots, and their medians by bin; the scale keeps to the medians."""
    theta = np.degrees(np.mod(pairs.theta, 2 * np.pi))
    axes.plot(
        theta,
        np.degrees(pairs.turn),
        ".",
        color=MEASURED,
        markersize=3,
        alpha=0.35,
        label="measured",
        zorder=1,
    )
    look: dict[str, Any] = {
        "markeredgecolor": MEASURED_EDGE,
        "markeredgewidth": 0.7,
        "markersize": 4.0,
        "zorder": 2,
    }
    axes.plot(
        np.degrees(bins.centre),
        np.degrees(bins.median),
        "s",
        color=MEASURED,
        label="5° medians",
        **look,
    )


def draw_cobweb(axes: Axes, cobweb: Cobweb, fixed_points: tuple[Orbit, ...]) -> None:
    """The graph of the map about its most telling place, and paths walking up its stairs."""
    window = np.degrees([cobweb.low, cobweb.high])
    axes.plot(window, window, color=QUIET, linewidth=0.9)
    for theta, image in cobweb.pieces:
        axes.plot(np.degrees(theta), np.degrees(image), color=PREDICTED, linewidth=2.0)
    for path in cobweb.paths:
        axes.plot(*np.degrees(path).T, color=INK, linewidth=0.7)
        axes.plot(*np.degrees(path[0]), marker="|", color=INK, markersize=7)
    for orbit in fixed_points:
        for lift in float(np.degrees(orbit.points[0])) + 360.0 * np.arange(-2, 3):
            if window[0] <= lift <= window[1]:
                axes.plot(lift, lift, **_marker(orbit))
    axes.set(
        xlim=window, ylim=window, aspect="equal", anchor="W", xlabel="θ0 (°)", ylabel="next θ0 (°)"
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 3, 4.5, 6, 9, 10]))


def _marker(orbit: Orbit) -> dict[str, Any]:
    kind = "stable" if orbit.stable else "unstable"
    return {**style.orbit_marker(kind), "markersize": 7.5, "markeredgewidth": 1.6, "clip_on": True}


def draw_density(axes: Axes, curves: PortraitCurves) -> None:
    """The predicted stationary density of θ0."""
    theta, density = np.degrees(curves.density_theta), PER_DEGREE * curves.density
    axes.fill_between(theta, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta, density, color=PREDICTED, linewidth=1.8, label="predicted", zorder=3)
    style.degree_axis(axes)
    axes.set_ylabel("probability per degree")


def draw_measured_histogram(axes: Axes, histogram: AngleHistogram) -> None:
    """How often each direction was recorded."""
    look: dict[str, Any] = {
        "facecolor": MEASURED,
        "edgecolor": MEASURED_EDGE,
        "linewidth": 0.6,
        "alpha": 0.65,
    }
    heights, edges = PER_DEGREE * histogram.density, np.degrees(histogram.edges)
    axes.stairs(heights, edges, fill=True, label="measured", zorder=2, **look)


def draw_staircase(axes: Axes, predicted: Array, measured: Array | None) -> None:
    """θ0 over the cycles, unwrapped: one predicted noisy run, and the measured one where there is
    one.
    """
    if measured is not None:
        axes.plot(np.degrees(measured), color=MEASURED, linewidth=2.2, label="measured", zorder=2)
    axes.plot(np.degrees(predicted), color=PREDICTED, linewidth=1.2, label="predicted", zorder=3)
    axes.set_xlabel("cycle")
    axes.set_xlim(0, max(len(predicted), 0 if measured is None else len(measured)) - 1)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
    style.unwrapped_axis(axes, "θ0, unwrapped", LEAST_SPAN_DEG)
