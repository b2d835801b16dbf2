"""An identified surface: in sentences, and on a page with its ellipse, how plates press, data
beside predictions.
"""

import math
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.evidence.identification.identify import Estimate, Identification
from cyclemap.evidence.identified_material import (
    CycleFit,
    Derived,
    IdentifiedCurves,
    StrokeFit,
)
from cyclemap.evidence.identified_words import misfit_words, readable_kind
from cyclemap.mechanics import EllipseFriction, SurfaceShape
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import Panel, draw_panels, entitle, page, rows_of
from cyclemap.views.panels.style import (
    DOTS,
    INK,
    LINE,
    LINES,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    SECOND,
    ZERO,
    cross,
    picture_style,
)
from cyclemap.views.sentences import angle, between

# Besides the intervals, which take the end of the first row.
MOST_PANELS = 8
# More intervals than fit above each other: those of plates and data sets are then in the tables
# alone.
MOST_INTERVALS = 13
# Errors that differ by less than this are as large.
WORSE = 1.01
# Friction whose axes, and whose centre over the mean, differ by less from one and nought is
# isotropic.
ROUND = 1.001


@picture_style()
def identify_page(
    title: str, identified: Identification, curves: IdentifiedCurves, words: Sequence[str]
) -> Figure:
    """Draw an identification: ellipse, intervals, and a panel for each sort of data, as many as the
    page takes.
    """
    panels: list[Panel] = [("Friction ellipse", partial(draw_ellipse, curves=curves))]
    if len(identified.plates) > 1:
        panels.append(("Shapes of plates", partial(draw_shapes, shapes=identified.plates)))
    if len(identified.floors) > 1:
        floors = {session or "mean": shape for session, shape in identified.floors.items()}
        panels.append(("Shapes of the floor", partial(draw_shapes, shapes=floors)))

    def named(fit: CycleFit | StrokeFit, what: str) -> str:
        return f"{fit.name[:1].upper()}{fit.name[1:]}: {what}"

    panels += [(named(fit, "map"), partial(draw_cycles, fit=fit)) for fit in curves.cycles]
    panels += [(named(fit, "turns"), partial(draw_stroke_turns, fit=fit)) for fit in curves.strokes]
    places = [(fit, fit.errors) for fit in curves.strokes if fit.errors is not None]
    panels += [
        (named(fit, "places"), partial(draw_places, errors=errors)) for fit, errors in places
    ]
    undrawn = len(panels) - MOST_PANELS
    more = f"; {undrawn} panels more are not drawn" if undrawn > 0 else ""
    foot = f"inferred from data; × at an interval's end: a bound, not excluded by the data{more}"
    count = min(len(panels), MOST_PANELS) + 1
    columns = count if count <= 3 else 2 if count == 4 else 3
    rows = [columns] * (count // columns) + [count % columns] * (count % columns > 0)
    layout = rows_of(*rows)
    figure, placed = page(layout, title, words, foot, size=(16.0, 9.6), keys=2)
    intervals = placed.pop(columns - 1)
    _draw_intervals(intervals, identified)
    draw_panels(placed, panels)
    return figure


def _draw_intervals(place: Axes, identified: Identification) -> None:
    """The intervals of the parameters one above the other, in the place of a panel."""
    shared = tuple(estimate for estimate in identified.lasting if "[" not in estimate.name)
    estimates = (
        identified.lasting if len(identified.lasting) <= MOST_INTERVALS or not shared else shared
    )
    whose = "" if len(estimates) == len(identified.lasting) else " of all plates"
    entitle(place, f"Parameters{whose}, with {100.0 * identified.level:g} % intervals")
    place.axis("off")
    for row, estimate in enumerate(estimates):
        bottom = 1.0 - (row + 0.7) / len(estimates)
        draw_interval(place.inset_axes((0.42, bottom, 0.58, 0.4 / len(estimates))), estimate)


def draw_ellipse(axes: Axes, curves: IdentifiedCurves) -> None:
    """The friction ellipse over directions of sliding, what it may be, and the forces that scans
    measured.
    """
    samples = LineCollection(list(curves.samples), linewidths=1.2, alpha=0.5, zorder=1)
    samples.set_color(PREDICTED_FILL)
    axes.add_collection(samples)
    axes.plot([], [], color=PREDICTED_FILL, linewidth=6, label="what it may be")
    draw_ellipses(axes, {"identified": curves.ellipse}, curves.forces)
    if curves.worn is not None:
        axes.plot(*curves.worn.T, label="at the end", **SECOND)
    axes.set_aspect("equal", adjustable="datalim")
    unit = "" if curves.sized else ", size not told by motions"
    axes.set(xlabel=f"friction coefficient along x{unit}", ylabel="along y")


def draw_ellipses(axes: Axes, ellipses: Mapping[str, Array], measured: Array | None) -> None:
    """Limit ellipses (n, 2) about the origin by name, and forces (m, 2) that scans measured."""
    if measured is not None:
        axes.plot(*measured.T, label="friction scans", **DOTS)
    for (name, ellipse), look in zip(ellipses.items(), LINES, strict=False):
        axes.plot(*ellipse.T, label=name, **look)
    cross(axes)


def draw_shapes(axes: Axes, shapes: Mapping[str, SurfaceShape]) -> None:
    """Shapes of plates or of the floor by session: how much each bends along and across its axis, a
    line each.
    """
    names = list(shapes)[::-1]
    dome, bow = np.array([(shapes[name].dome, shapes[name].bow) for name in names]).T
    heights = np.arange(len(names))
    axes.hlines(heights, dome - bow, dome + bow, color=PREDICTED, linewidth=3.0)
    axes.plot(dome, heights, "o", color=INK, markersize=4)
    axes.axvline(0.0, **ZERO)
    axes.set_yticks(heights, names, fontsize=7)
    axes.set(xlabel="bends across to along its axis (kPa at 50 mm)", ylim=(-0.6, len(names) - 0.4))


def draw_stroke_turns(axes: Axes, fit: StrokeFit) -> None:
    """Predicted over measured turns of strokes."""
    measured, predicted = np.degrees([fit.measured, fit.predicted])
    orientation.draw_agreement(axes, measured, predicted, "turn (°)", "strokes")


def draw_places(axes: Axes, errors: Array) -> None:
    """Where pushes ended, predicted less measured, with the circle that half of them keep
    within."""
    x, y = 1000.0 * errors.T
    half = float(np.median(np.hypot(x, y)))
    axes.plot(x, y, label="pushes", **DOTS)
    around = half * np.stack([np.cos(orientation.CIRCLE), np.sin(orientation.CIRCLE)])
    axes.plot(*around, label=f"half within {half:.2g} mm", **LINE)
    cross(axes)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="error of the place, x (mm)", ylabel="y (mm)")


def draw_cycles(axes: Axes, fit: CycleFit) -> None:
    """Measured turns of cycles over θ0, and the fitted map's."""
    orientation.draw_measured(axes, fit.theta, np.degrees(fit.turn))
    turns = {"identified": fit.fitted}
    if fit.late is not None:
        turns = {"at the start": fit.fitted, "at the end": fit.late}
    orientation.draw_turns(axes, fit.grid, turns)


def draw_interval(axes: Axes, estimate: Estimate) -> None:
    """The interval of one parameter on an axis of its own, its name at the left."""
    unit, value, lower, upper = estimate.readable
    color = PREDICTED if estimate.identifiable else QUIET
    axes.plot([lower, upper], [0.0, 0.0], color=color, linewidth=2.2, solid_capstyle="butt")
    axes.plot(value, 0.0, "o", color=color, markersize=5)
    for end, opened in ((lower, estimate.lower_open), (upper, estimate.upper_open)):
        axes.plot(end, 0.0, "|" if not opened else "x", color=color, markersize=8)
    # An interval narrower than the digits of its ticks would be labelled with an offset that nobody
    # can read.
    room = max(0.35 * (upper - lower), 1e-3 * max(abs(lower), abs(upper), 1e-3))
    axes.set_xlim(lower - room, upper + room)
    axes.ticklabel_format(axis="x", useOffset=False)
    axes.set(yticks=[], ylim=(-1.0, 1.0))
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.grid(visible=False)
    for side in ("left", "top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="x", labelsize=7, length=2, pad=1)
    words = f"{estimate.name.replace('_', ' ')}{f' ({unit.sign.strip()})' if unit.sign else ''}"
    axes.text(-0.03, 0.5, words, transform=axes.transAxes, ha="right", va="center", fontsize=8)


def headline(name: str, derived: Sequence[Derived], held: EllipseFriction) -> str:
    """Friction ellipse and floor as far as they are known: intervals, for no value is surer than
    its own.

    held : the friction where the data were not asked about its shape.
    """
    known = {quantity.name: quantity for quantity in derived}
    clauses = []
    if "axis_ratio" in known:
        way = _way(known.get("axis_direction"), " (longer along {})")
        clauses.append(f"axes {_size(known['axis_ratio'], 1.0, 2)} : 1{way}")
    if "offset_size" in known:
        way = _way(known.get("offset_direction"), " towards {}")
        clauses.append(f"centre {_size(known['offset_size'], 100.0, 1)} % off{way}")
    if "mean_friction" in known:
        clauses.append(f"mean friction {_size(known['mean_friction'], 1.0, 3)}")
    words = [f"friction ellipse with {', '.join(clauses)}"] if clauses else []
    if "axis_ratio" not in known and "offset_size" not in known:
        words.append(_held_words(held))
    if "floor_bow" in known:
        way = _way(known.get("floor_axis"), " (up along {})")
        words.append(f"floor bowed by {_size(known['floor_bow'], 1.0, 1)} kPa{way}")
    return f"{name}: {'; '.join(words)}"


def _size(quantity: Derived, factor: float, decimals: int) -> str:
    return between(*(f"{factor * end:.{decimals}f}" for end in (quantity.lower, quantity.upper)))


def _way(quantity: Derived | None, words: str) -> str:
    """A direction put into words; empty where it was not asked for."""
    if quantity is None:
        return ""
    if not quantity.known:
        return ", in any direction"
    turns = math.floor((quantity.lower + math.pi) / TWO_PI)
    ends = (angle(end - TWO_PI * turns, 0) for end in (quantity.lower, quantity.upper))
    return words.format(between(*ends))


def _held_words(held: EllipseFriction) -> str:
    ratio = held.mu_a / held.mu_b
    off = 100.0 * Anisotropy.of(held).offset
    if ratio < ROUND and off < 100.0 * (ROUND - 1.0):
        return "friction taken as isotropic"
    return f"friction held at axes {ratio:.2f} : 1, centre {off:.1f} % off"


def note_sentences(identified: Identification) -> list[str]:
    """What qualifies the result."""
    return [*worse_than_isotropic(identified), *(f"note: {note}" for note in identified.notes)]


def worse_than_isotropic(identified: Identification) -> list[str]:
    """Which data the identified surface predicts worse than isotropic friction does, by 1 %; left
    out where it was.
    """
    worse = []
    for error in identified.errors:
        mean = error.left_out_mean if error.left_out_mean == error.left_out_mean else error.mean
        if mean > WORSE * error.isotropic_mean:
            kind, unit = readable_kind(error.kind)
            worse.append(
                f"{error.block}, {kind} ({unit.of_si(mean):.3g} against "
                f"{unit.of_si(error.isotropic_mean):.3g}{unit.sign})"
            )
    return [f"Worse than isotropic friction does: {'; '.join(worse)}."] if worse else []


def page_sentences(identified: Identification) -> list[str]:
    """What is written on the page: how far predictions lie from the data, and what they predict
    worse.
    """
    errors = f"Predictions lie from the data by {misfit_words(identified)}."
    return [
        f"Ranges are intervals of {100.0 * identified.level:g} %.",
        errors,
        *worse_than_isotropic(identified),
    ]
