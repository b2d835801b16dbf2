"""A sweep: in sentences, and drawn as a diagram over one key or two, or as a scatter of a
sample.
"""

import math
from collections import Counter
from dataclasses import replace
from functools import partial

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from scipy.ndimage import binary_dilation, binary_opening

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.maps import RotationNumbers, RotationPlane
from cyclemap.mechanics import MIT_HITCH, MIT_SHAPE_NAMES
from cyclemap.protocol.settings import loop_from_settings
from cyclemap.sweeps.point_sets import KEY_UNITS, MATERIAL_KEY, SWEPT, SweepAxis, key_unit
from cyclemap.sweeps.portrait_numbers import Quantity
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.views.panels.layout import Panel, draw_panels, page, rows_of
from cyclemap.views.panels.rotation import (
    cell_edges,
    draw_rotation_numbers,
    draw_rotation_plane,
    draw_shades,
    mark_cells,
    scale_beside,
)
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import (
    INK,
    OPEN,
    PREDICTED,
    QUIET,
    Look,
    name_tag,
    orbit_marker,
    picture_style,
    say,
    show_window,
    whole_turn_ticks,
)

MOST_PANELS = 2
RING_KEYS = ("hitch_x_mm", "hitch_y_mm")
REFUSED: Look = {
    "facecolor": "#f4f4f4",
    "edgecolor": QUIET,
    "hatch": "xxx",
    "linewidth": 0.0,
}
# Where a number is infinite, such as a rest that never ends.
ENDLESS: Look = {"marker": "^", "linestyle": "none", "color": PREDICTED, "label": "without end"}
_SHORT_UNITS = {"degree": "°", "turns/cycle": "turns a cycle"}
# Behind a number.
_SPACED_UNITS = {"degree": "°", "mm": " mm", "kg": " kg"}
_ROTATION = ("rotation", "rotation_lower", "rotation_upper", "locked_period", "locked_winding")
_MOST_COUNTS = 8
# Positive values that differ by more than this factor are drawn by their logarithms.
_DECADES = 1e3
_LONGEST_NAME = 22
# Planes with as many values along both axes are fine enough for tongues to be more than a cell
# wide.
_FINE_PLANE = 40
_MOST_REASONS = 3
_LONGEST_REASON = 160


@picture_style()
def sweep_page(sweep: Sweep, names: tuple[str, ...] = ()) -> Figure:
    """Draw a sweep over one key or two: some quantities, at most two panels side by side.

    names : of quantities; (): those that are there.

    Raises InvalidInput for more keys (select values of the others first), a sample of keys that are
    no numbers, a quantity that was not asked for, and a sweep without points.
    """
    panels = swept_panels(sweep, names)[:MOST_PANELS]
    words, foot = sweep_sentences(sweep), settings_line(sweep)
    figure, placed = page(rows_of(len(panels)), sweep_headline(sweep), words, foot)
    draw_panels(placed, panels)
    if tuple(axis.key for axis in sweep.axes) == RING_KEYS:
        for axes in placed:
            _draw_object(axes, sweep)
    return figure


def swept_panels(sweep: Sweep, names: tuple[str, ...] = ()) -> list[Panel]:
    """The panels of a sweep; where fixed points are known they come first."""
    if not len(sweep):
        raise InvalidInput("no point of this sweep is stored: there is nothing to draw")
    keys = [axis.key for axis in sweep.axes] or sweep.keys
    if len(keys) > 2:
        raise InvalidInput(
            f"{len(keys)} keys are swept ({', '.join(keys)}): select values of all but two to draw "
            "them"
        )
    draw = draw_swept_plane if sweep.axes else draw_swept_scatter
    panels: list[Panel] = []
    if len(keys) == 1:
        draw, sweep = draw_swept_line, in_order(sweep)
        if "fixed_point_theta" in sweep.table:
            panels.append(("Fixed points", partial(draw_fixed_points, sweep=sweep)))
    default = [name for name in ("rotation", "stable_points") if name in sweep.table]
    first = [quantity.name for quantity in sweep.quantities if not quantity.many][:2]
    for name in names or default or first:
        quantity = sweep.quantity(name)
        if quantity.many:
            raise InvalidInput(
                f"{name} is a list at each point: draw a quantity that is one number"
            )
        # A meaning is a title short of its remarks.
        title = quantity.meaning.partition(",")[0]
        drawn = partial(draw, sweep=sweep, quantity=quantity)
        panels.append((f"{title[:1].upper()}{title[1:]}", drawn))
    return panels


def in_order(sweep: Sweep) -> Sweep:
    """A sweep over one key as a grid of its values, numbers in order."""
    (key,) = (axis.key for axis in sweep.axes) if sweep.axes else sweep.keys
    values = sweep.axes[0].values if sweep.axes else tuple(set(sweep.table[key]))
    if sweep.is_numeric(key) or not sweep.axes:
        values = tuple(sorted(values))  # type: ignore[type-var]
    return replace(sweep, axes=(SweepAxis(key, values),))


def _draw_object(axes: Axes, sweep: Sweep) -> None:
    """The object that the ring is set in, and MIT's ring where it is MIT's."""
    slider = loop_from_settings(sweep.description["plan"]["settings"]).slider
    outline = MM * slider.outline.points(120)
    axes.plot(*outline.T, color=INK, linewidth=1.6, clip_on=False, zorder=5)
    if slider.name in MIT_SHAPE_NAMES:
        x, y = MM * MIT_HITCH[0], MM * MIT_HITCH[1]
        axes.plot(x, y, "*", markersize=11, zorder=6, **OPEN)
        name_tag(axes, x, y, "MIT's ring", xytext=(0, -11), textcoords="offset points")
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    ends = outline.min(axis=0) - 3.0, outline.max(axis=0) + 3.0
    show_window(axes, np.minimum(low, ends[0]), np.maximum(high, ends[1]))
    axes.set_aspect("equal")


def key_words(key: str) -> str:
    """A swept key in words, without its unit.

    >>> key_words("hitch_x_mm"), key_words("pin_friction_mm")
    ('ring x', 'pin friction')
    """
    name, _, unit = key.rpartition("_")
    return SWEPT[key].label or (name if unit in KEY_UNITS else key).replace("_", " ")


def label(words: str, unit: str) -> str:
    """Words and unit, as the label of an axis.

    >>> label("ring x", "mm"), label("friction μa", "1")
    ('ring x (mm)', 'friction μa')
    """
    return words if unit == "1" else f"{words} ({_SHORT_UNITS.get(unit, unit)})"


def key_label(key: str) -> str:
    """A swept key as the label of an axis."""
    return label(key_words(key), key_unit(key))


def quantity_label(quantity: Quantity) -> str:
    """A quantity's meaning and unit, as the label of an axis."""
    return label(quantity.meaning, quantity.written_unit)


def draw_swept_plane(axes: Axes, sweep: Sweep, quantity: Quantity) -> None:
    """One quantity over two keys, by colour; locked regions outlined,
    refused points crossed out."""
    values = quantity.written(sweep.on_grid(quantity.name))
    first, second = (cell_edges(axis.positions) for axis in sweep.axes)
    labels = [key_label(axis.key) for axis in sweep.axes]
    if quantity.name == "rotation" and np.isfinite(values).any():
        draw_rotation_plane(axes, without_specks(rotation_plane(sweep)), *labels)
    else:
        look, ticks = _shades(values)
        draw_shades(axes, first, second, values, quantity_label(quantity), ticks, **look)
        axes.set(xlabel=labels[0], ylabel=labels[1])
    column, row = np.nonzero(np.isposinf(values))
    if column.size:
        place = sweep.axes[0].positions[column], sweep.axes[1].positions[row]
        axes.plot(*place, **ENDLESS, markersize=5, zorder=3)
    refused = np.zeros(sweep.shape, dtype=bool)
    refused[sweep.places()] = sweep.refused
    if refused.any():
        mark_cells(axes, first, second, refused, label="refused", zorder=2, **REFUSED)
    for side, axis in zip((axes.xaxis, axes.yaxis), sweep.axes, strict=True):
        _name_ticks(side, axis)


def rotation_plane(sweep: Sweep) -> RotationPlane:
    """The rotation numbers of a grid over two keys."""
    value, lower, upper, periods, windings = (sweep.on_grid(name) for name in _ROTATION)
    period, winding = (np.nan_to_num(locked).astype(int) for locked in (periods, windings))
    # Whether a map folds is told by its least slope, where that was asked for.
    slope = sweep.on_grid("min_slope") if "min_slope" in sweep.table else np.zeros(sweep.shape)
    first, second = (axis.positions for axis in sweep.axes)
    return RotationPlane(first, second, value, lower, upper, period, winding, slope < 0.0, 0.0)


def without_specks(plane: RotationPlane) -> RotationPlane:
    """Of a fine plane, the tongues that are wide enough to be seen: narrower ones would be a litter
    of outlined cells.

    A cell is kept where it is one of two by two that lock at the same p/q, or touches one that is
    and locks alike.
    """
    if min(plane.period.shape) < _FINE_PLANE:
        return plane
    ratio, kept = (
        np.where(plane.period > 0, plane.winding / np.maximum(plane.period, 1), np.nan),
        plane.period < 0,
    )
    for locked in np.unique(ratio[plane.period > 0]):
        wide = binary_opening(ratio == locked, np.ones((2, 2)))
        kept |= (ratio == locked) & binary_dilation(wide, np.ones((3, 3)))
    return replace(
        plane, period=np.where(kept, plane.period, 0), winding=np.where(kept, plane.winding, 0)
    )


def _shades(values: Array) -> tuple[Look, Array | None]:
    """One shade for each small count, light to dark; shades that run on for all else."""
    known = values[np.isfinite(values)]
    if _spans_decades(known):
        return {"cmap": "cividis", "norm": LogNorm()}, None
    counted = (
        known.size > 0
        and bool(np.all(known == np.round(known)))
        and float(np.ptp(known)) < _MOST_COUNTS
    )
    if not counted:
        return {"cmap": "cividis"}, None
    levels = np.arange(known.min(), known.max() + 1.0)
    # The lightest shade is not white: that is where no point is.
    shades = ListedColormap(colormaps["Blues"](np.linspace(0.12, 0.95, levels.size)))
    norm = BoundaryNorm(np.append(levels, levels[-1] + 1.0) - 0.5, levels.size)
    return {"cmap": shades, "norm": norm}, levels


def _spans_decades(known: Array) -> bool:
    """Whether finite values are told apart by their logarithms alone, as rests of cycles are."""
    return known.size > 1 and known.min() > 0.0 and bool(known.max() > _DECADES * known.min())


def _name_ticks(side: Axis, axis: SweepAxis) -> None:
    """Words at the values of an axis that holds no numbers."""
    if not axis.is_number:
        side.set_ticks(axis.positions, [_short(value) for value in axis.values])


def draw_fixed_points(axes: Axes, sweep: Sweep) -> None:
    """The bifurcation diagram: directions of fixed points over the key, filled where stable."""
    (axis,), (places,) = sweep.axes, sweep.places()
    axes.set(xlabel=key_label(axis.key), ylabel="θ of the fixed points (°)")
    whole_turn_ticks(axes)
    points = sweep.table["fixed_point_theta"].tolist()
    at = np.repeat(axis.positions[places], [theta.size for theta in points])
    theta = np.degrees(np.concatenate(points))
    stable = np.concatenate(sweep.table["fixed_point_stable"].tolist()) == 1.0
    if not at.size:
        say(axes, "no fixed point")
    size = float(np.clip(300.0 / len(sweep), 2.0, 6.0))
    for kind, chosen in (("stable", stable), ("unstable", ~stable)):
        look = {**orbit_marker(kind), "markersize": size, "markeredgewidth": 0.9}
        axes.plot(at[chosen], theta[chosen], label=kind if chosen.any() else None, **look)
    _finish_line_axis(axes, sweep)


def draw_swept_line(axes: Axes, sweep: Sweep, quantity: Quantity) -> None:
    """One quantity over the key: rotation numbers with their plateaus, anything else as a line with
    dots.
    """
    (axis,) = sweep.axes
    values = quantity.written(sweep.on_grid(quantity.name))
    known = np.isfinite(values)
    if quantity.name == "rotation" and axis.is_number and known.any():
        value, lower, upper, *locked = (sweep.on_grid(name)[known] for name in _ROTATION)
        period, winding = (column.astype(int) for column in locked)
        numbers = RotationNumbers(value, lower, upper, period, winding, 0.0)
        draw_rotation_numbers(axes, axis.positions[known], numbers, key_label(axis.key))
    else:
        mark = "o-" if axis.is_number else "o"
        axes.plot(axis.positions, values, mark, color=PREDICTED, markersize=3.5, linewidth=1.4)
        axes.set(xlabel=key_label(axis.key), ylabel=quantity_label(quantity))
        if _spans_decades(values[known]):
            axes.set_yscale("log")
    endless = axis.positions[np.isposinf(values)]
    if endless.size:
        level = np.full(endless.size, 0.98)
        axes.plot(endless, level, transform=axes.get_xaxis_transform(), **ENDLESS, markersize=6)
    _finish_line_axis(axes, sweep)


def _finish_line_axis(axes: Axes, sweep: Sweep) -> None:
    """Limits and ticks of the key's axis, and marks of refused points."""
    (axis,), (places,) = sweep.axes, sweep.places()
    low, high = float(axis.positions.min()), float(axis.positions.max())
    margin = 0.02 * (high - low) if axis.is_number and high > low else 0.5
    axes.set_xlim(low - margin, high + margin)
    _name_ticks(axes.xaxis, axis)
    if sweep.refused.any():
        refused = axis.positions[places[sweep.refused]]
        bottom, level = axes.get_xaxis_transform(), np.full(refused.size, 0.02)
        axes.plot(refused, level, "x", color=INK, transform=bottom, label="refused")


def draw_swept_scatter(axes: Axes, sweep: Sweep, quantity: Quantity) -> None:
    """One quantity at the points of a sample over two keys, by colour;
    refused points as crosses."""
    values = quantity.written(sweep.table[quantity.name])
    first, second = (sweep.values(key) for key in sweep.keys)
    look, ticks = _shades(values)
    size = float(np.clip(6000.0 / len(sweep), 6.0, 60.0))
    known, refused = np.isfinite(values), sweep.refused
    look |= {"edgecolor": QUIET, "linewidth": 0.6, "zorder": 3}
    dots = axes.scatter(first[known], second[known], c=values[known], s=size, **look)
    scale_beside(axes, dots, quantity_label(quantity), ticks)
    endless = np.isposinf(values)
    if endless.any():
        axes.plot(first[endless], second[endless], **ENDLESS, markersize=6, zorder=4)
    if refused.any():
        place = first[refused], second[refused]
        axes.plot(*place, "x", color=INK, markersize=5, label="refused", zorder=4)
    axes.set(xlabel=key_label(sweep.keys[0]), ylabel=key_label(sweep.keys[1]))


def _short(value: object) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST_NAME else f"{text[: _LONGEST_NAME - 1]}…"


def axis_words(axis: SweepAxis) -> str:
    """An axis in words: its key, ends and number of values.

    >>> axis_words(SweepAxis("hitch_x_mm", (-12.0, -8.0, -4.0)))
    'ring x -12 to -4 mm (3 values)'
    """
    name, unit = key_words(axis.key), _SPACED_UNITS.get(key_unit(axis.key), "")
    if axis.is_number and len(axis.values) > 1:
        return (
            f"{name} {_short(axis.values[0])} to {_short(axis.values[-1])}{unit} "
            f"({len(axis.values)} values)"
        )
    return f"{name} {', '.join(_short(value) for value in axis.values)}{unit}"


def sweep_headline(sweep: Sweep) -> str:
    """What was swept, in a line, and what was selected of it."""
    names = (
        ""
        if MATERIAL_KEY in sweep.keys
        else f"{', '.join(sweep.description['plan']['material'])}: "
    )
    kept = [axis.key for axis in sweep.axes] or list(sweep.keys)
    values = {key: sweep.table[key].iloc[0] for key in sweep.keys if key not in kept and len(sweep)}
    fixed = [
        f"{key_words(key)} = {f'{value:.5g}' if isinstance(value, float) else value}"
        for key, value in values.items()
    ]
    return f"{names}{' × '.join(map(key_words, kept))}{' at ' if fixed else ''}{', '.join(fixed)}"


def sweep_sentences(sweep: Sweep) -> list[str]:
    """How much is done, the share that is proved to lock and to what, the stable directions, and
    the refusals.
    """
    total = math.prod(sweep.shape) if sweep.axes else int(sweep.description["count"])
    whole = f"{len(sweep)} points" if len(sweep) == total else f"{len(sweep)} of {total} points"
    if sweep.axes:
        swept = ", ".join(axis_words(axis) for axis in sweep.axes)
    else:
        sample = sweep.description["plan"]["points"]
        ranges = (
            f"{key_words(key)} {ends['low']:g} to {ends['high']:g}"
            if isinstance(ends, dict)
            else f"{key_words(key)} {', '.join(map(str, ends))}"
            for key, ends in sample.get("ranges", {}).items()
        )
        swept = f"{', '.join(ranges)} ({sample.get('sequence')} sample, seed {sample.get('seed')})"
    sentences = [f"{whole} over {swept}."]
    if "locked_period" in sweep.table:
        period, winding = sweep.table["locked_period"], sweep.table["locked_winding"]
        pairs = zip(winding[period > 0].tolist(), period[period > 0].tolist(), strict=True)
        ratios = Counter(f"{int(p)}/{int(q)}" for p, q in pairs)
        listed = ", ".join(
            f"{count} at {ratio}" for ratio, count in ratios.most_common(_MOST_REASONS)
        )
        more = ", ..." if len(ratios) > _MOST_REASONS else ""
        sentences.append(
            f"{ratios.total()} lock ({listed}{more})." if ratios else "No point is proved to lock."
        )
    if "stable_points" in sweep.table and sweep.table["stable_points"].notna().any():
        counts = sorted(Counter(sweep.table["stable_points"].dropna().astype(int)).items())
        sentences.append(
            f"Stable directions: {', '.join(f'{points} with {count}' for count, points in counts)}."
        )
    if refused := [text.partition(" (set:")[0] for text in sweep.table["refusal"] if text]:
        reason, count = Counter(refused).most_common(1)[0]
        short = reason if len(reason) <= _LONGEST_REASON else f"{reason[: _LONGEST_REASON - 1]}…"
        most = f"{count} of them" if count < len(refused) else "all of them" if count > 1 else "it"
        sentences.append(f"{len(refused)} refused; {most} so: {short}.")
    return sentences


def settings_line(sweep: Sweep) -> str:
    """What holds for all points: settings, and the accuracy asked for."""
    plan = sweep.description["plan"]
    settings = ", ".join(f"{key}={value}" for key, value in plan["settings"].items())
    asked = plan["quantities"]
    accuracy = f"map to {np.degrees(asked['tolerance']):.1g}°" if "tolerance" in asked else ""
    pace = asked.get("rotation_tolerance", 0.0)
    turns = (
        f"rotation numbers to {pace:g} turns a cycle" if pace and "rotation" in sweep.table else ""
    )
    return "; ".join(
        clause for clause in (f"set: {settings}" if settings else "", accuracy, turns) if clause
    )
