"""A sweep: in sentences, and drawn as a diagram over one key or two,
or as a scatter of a sample."""

import math
from collections import Counter
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from scipy.ndimage import binary_dilation, binary_opening

from cyclemap.arrays import Array
from cyclemap.maps import RotationPlane
from cyclemap.mechanics import MIT_HITCH, MIT_SHAPE_NAMES
from cyclemap.protocol.settings import loop_from_settings
from cyclemap.sweeps.point_sets import MATERIAL_KEY, SweepAxis
from cyclemap.sweeps.portrait_numbers import Quantity
from cyclemap.sweeps.sweep_curves import (
    SweptCurves,
    SweptLines,
    SweptPlane,
    SweptScatter,
    axis_places,
)
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.views import style
from cyclemap.views.object_page import MM
from cyclemap.views.rotation_panels import (
    cell_edges,
    draw_rotation_numbers,
    draw_rotation_plane,
    draw_shades,
    mark_cells,
    scale_beside,
)
from cyclemap.views.style import INK, PREDICTED, QUIET, Look

MOST_PANELS = 2
RING_KEYS = ("hitch_x_mm", "hitch_y_mm")
REFUSED: Look = {
    "facecolor": "#f4f4f4",
    "edgecolor": QUIET,
    "hatch": "xxx",
    "linewidth": 0.0,
}
_UNITS = {"_deg": "°", "_mm": "mm", "_kg": "kg"}
_KEY_WORDS = {
    "mu_a": "friction μa",
    "mu_b": "friction μb",
    "m0": "offset m0",
    "n0": "offset n0",
    "phi_deg": "direction φ of friction",
    "pusher_mu": "friction of the rod",
    "pusher_radius_mm": "radius of the rod",
    "fraction": "place on the side",
    "angle_deg": "angle of the push",
    "push_mm": "length of the push",
    "object_name": "object",
    "hitch_x_mm": "ring x",
    "hitch_y_mm": "ring y",
    "pin_friction_mm": "friction radius of the pin",
    "noise_deg": "noise of a cycle",
}
_SHORT_UNITS = {"degree": "°", "turns/cycle": "turns a cycle"}
_MOST_COUNTS = 8
_LONGEST_NAME = 22
# Planes with as many values along both axes are fine enough for tongues to be more than a cell
# wide.
_FINE_PLANE = 40
_MOST_REASONS = 3
_LONGEST_REASON = 160


@style.picture_style()
def sweep_page(sweep: Sweep, curves: SweptCurves) -> Figure:
    """Draw what `sweep_curves` worked out of a sweep: at most two panels side by side."""
    # Titles, which are meanings short of their remarks, and drawers; where fixed points are known
    # they come first.
    panels: list[style.Panel] = []
    draw: Any
    if isinstance(curves, SweptLines):
        draw, told = draw_swept_line, curves.lines
        if curves.points is not None:
            panels.append(("Fixed points", partial(draw_fixed_points, swept=curves)))
    elif isinstance(curves, SweptPlane):
        draw, told = draw_swept_plane, curves.planes
    else:
        draw, told = draw_swept_scatter, curves.values
    for index, (quantity, _) in enumerate(told):
        name = quantity.meaning.partition(",")[0]
        panels.append((f"{name[:1].upper()}{name[1:]}", partial(draw, swept=curves, index=index)))
    panels = panels[:MOST_PANELS]
    words, foot = sweep_sentences(sweep), settings_line(sweep)
    figure, placed = style.page(style.rows_of(len(panels)), sweep_headline(sweep), words, foot)
    style.draw_panels(placed, panels)
    if isinstance(curves, SweptPlane) and (curves.first.key, curves.second.key) == RING_KEYS:
        for axes in placed:
            _draw_object(axes, sweep)
    return figure


def _draw_object(axes: Axes, sweep: Sweep) -> None:
    """The object that the ring is set in, and MIT's ring where it is MIT's."""
    slider = loop_from_settings(sweep.description["plan"]["settings"]).slider
    outline = MM * slider.outline.points(120)
    axes.plot(*outline.T, color=INK, linewidth=1.6, clip_on=False, zorder=5)
    if slider.name in MIT_SHAPE_NAMES:
        x, y = MM * MIT_HITCH[0], MM * MIT_HITCH[1]
        axes.plot(x, y, "*", markersize=11, zorder=6, **style.OPEN)
        style.name_tag(axes, x, y, "MIT's ring", xytext=(0, -11), textcoords="offset points")
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    ends = outline.min(axis=0) - 3.0, outline.max(axis=0) + 3.0
    style.show_window(axes, np.minimum(low, ends[0]), np.maximum(high, ends[1]))
    axes.set_aspect("equal")


def key_words(key: str) -> str:
    """A swept key in words, without its unit.

    >>> key_words("hitch_x_mm"), key_words("rim_share")
    ('ring x', 'rim share')
    """
    ending = next(filter(key.endswith, _UNITS), "")
    return _KEY_WORDS.get(key, key.removesuffix(ending).replace("_", " "))


def key_unit(key: str) -> str:
    """The unit of a swept key; empty where it has none."""
    return next((unit for ending, unit in _UNITS.items() if key.endswith(ending)), "")


def key_label(key: str) -> str:
    """A swept key as the label of an axis.

    >>> key_label("hitch_x_mm"), key_label("mu_a")
    ('ring x (mm)', 'friction μa')
    """
    unit = key_unit(key)
    return f"{key_words(key)} ({unit})" if unit else key_words(key)


def quantity_label(quantity: Quantity) -> str:
    """A quantity's meaning and unit, as the label of an axis."""
    unit = _SHORT_UNITS.get(quantity.written_unit, quantity.written_unit)
    return quantity.meaning if unit == "1" else f"{quantity.meaning} ({unit})"


def draw_swept_plane(axes: Axes, swept: SweptPlane, index: int) -> None:
    """One quantity over two keys, by colour; locked regions outlined,
    refused points crossed out."""
    quantity, values = swept.planes[index]
    first, second = (cell_edges(axis_places(axis)) for axis in (swept.first, swept.second))
    labels = key_label(swept.first.key), key_label(swept.second.key)
    if quantity.name == "rotation" and swept.rotation is not None and np.isfinite(values).any():
        draw_rotation_plane(axes, without_specks(swept.rotation), *labels)
    else:
        look, ticks = _shades(values)
        scale = draw_shades(axes, first, second, values, quantity_label(quantity), **look)
        _mark_counts(scale, ticks)
        axes.set(xlabel=labels[0], ylabel=labels[1])
    if swept.refused.any():
        mark_cells(axes, first, second, swept.refused, label="refused", zorder=2, **REFUSED)
    _name_ticks(axes.xaxis, swept.first)
    _name_ticks(axes.yaxis, swept.second)


def _mark_counts(scale: Colorbar, counts: Array | None) -> None:
    """A tick for each count on a scale of shades; as they are for what runs on."""
    if counts is not None:
        scale.set_ticks(counts.tolist())


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
    found = values[np.isfinite(values)]
    counted = (
        found.size > 0
        and bool(np.all(found == np.round(found)))
        and float(np.ptp(found)) < _MOST_COUNTS
    )
    if not counted:
        return {"cmap": "cividis"}, None
    levels = np.arange(found.min(), found.max() + 1.0)
    # The lightest shade is not white: that is where no point is.
    shades = ListedColormap(colormaps["Blues"](np.linspace(0.12, 0.95, levels.size)))
    norm = BoundaryNorm(np.append(levels, levels[-1] + 1.0) - 0.5, levels.size)
    return {"cmap": shades, "norm": norm}, levels


def _name_ticks(side: Axis, axis: SweepAxis) -> None:
    """Words at the values of an axis that holds no numbers."""
    if not axis.is_number:
        side.set_ticks(axis_places(axis), [_short(value) for value in axis.values])


def draw_fixed_points(axes: Axes, swept: SweptLines) -> None:
    """The bifurcation diagram: directions of fixed points over the key, filled where stable."""
    axes.set(xlabel=key_label(swept.axis.key), ylabel="θ of the fixed points (°)")
    style.whole_turn_ticks(axes)
    at, theta, stable = (
        swept.points if swept.points is not None else (np.empty(0), np.empty(0), np.empty(0, bool))
    )
    if not at.size:
        style.say(axes, "no fixed point")
    size = float(np.clip(300.0 / max(swept.parameter.size, 1), 2.0, 6.0))
    for kind, chosen in (("stable", stable), ("unstable", ~stable)):
        look = {**style.orbit_marker(kind), "markersize": size, "markeredgewidth": 0.9}
        axes.plot(at[chosen], theta[chosen], label=kind if chosen.any() else None, **look)
    _finish_line_axis(axes, swept)


def draw_swept_line(axes: Axes, swept: SweptLines, index: int) -> None:
    """One quantity over the key: rotation numbers with their plateaus, anything else as a line with
    dots.
    """
    quantity, values = swept.lines[index]
    if quantity.name == "rotation" and swept.rotation is not None and swept.axis.is_number:
        draw_rotation_numbers(axes, swept.rotation_at, swept.rotation, key_label(swept.axis.key))
    else:
        mark = "o-" if swept.axis.is_number else "o"
        axes.plot(swept.parameter, values, mark, color=PREDICTED, markersize=3.5, linewidth=1.4)
        axes.set(xlabel=key_label(swept.axis.key), ylabel=quantity_label(quantity))
    _finish_line_axis(axes, swept)


def _finish_line_axis(axes: Axes, swept: SweptLines) -> None:
    """Limits and ticks of the key's axis, and marks of refused points."""
    low, high = float(axis_places(swept.axis).min()), float(axis_places(swept.axis).max())
    margin = 0.02 * (high - low) if swept.axis.is_number and high > low else 0.5
    axes.set_xlim(low - margin, high + margin)
    _name_ticks(axes.xaxis, swept.axis)
    if swept.refused.size:
        bottom, level = axes.get_xaxis_transform(), np.full(swept.refused.size, 0.02)
        axes.plot(swept.refused, level, "x", color=INK, transform=bottom, label="refused")


def draw_swept_scatter(axes: Axes, swept: SweptScatter, index: int) -> None:
    """One quantity at the points of a sample over two keys, by colour;
    refused points as crosses."""
    quantity, values = swept.values[index]
    (first_key, first), (second_key, second) = swept.first, swept.second
    look, ticks = _shades(values)
    size = float(np.clip(6000.0 / max(first.size, 1), 6.0, 60.0))
    found = np.isfinite(values)
    look |= {"edgecolor": QUIET, "linewidth": 0.6, "zorder": 3}
    dots = axes.scatter(first[found], second[found], c=values[found], s=size, **look)
    _mark_counts(scale_beside(axes, dots, quantity_label(quantity)), ticks)
    if swept.refused.any():
        refused = first[swept.refused], second[swept.refused]
        axes.plot(*refused, "x", color=INK, markersize=5, label="refused", zorder=4)
    axes.set(xlabel=key_label(first_key), ylabel=key_label(second_key))


def _short(value: object) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST_NAME else f"{text[: _LONGEST_NAME - 1]}…"


def axis_words(axis: SweepAxis) -> str:
    """An axis in words: its key, ends and number of values.

    >>> axis_words(SweepAxis("hitch_x_mm", (-12.0, -8.0, -4.0)))
    'ring x -12 to -4 mm (3 values)'
    """
    name, unit = key_words(axis.key), key_unit(axis.key)
    unit = unit if unit in ("", "°") else f" {unit}"
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
    values = {key: sweep.swept[key][0] for key in sweep.keys if key not in kept and len(sweep)}
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
    told = [f"{whole} over {swept}."]
    if "locked_period" in sweep.columns:
        period, winding = sweep.columns["locked_period"], sweep.columns["locked_winding"]
        pairs = zip(winding[period > 0].tolist(), period[period > 0].tolist(), strict=True)
        ratios = Counter(f"{int(p)}/{int(q)}" for p, q in pairs)
        listed = ", ".join(
            f"{count} at {ratio}" for ratio, count in ratios.most_common(_MOST_REASONS)
        )
        more = ", ..." if len(ratios) > _MOST_REASONS else ""
        told.append(
            f"{ratios.total()} lock ({listed}{more})." if ratios else "No point is proved to lock."
        )
    stable = sweep.columns.get("stable_points", np.empty(0))
    if np.isfinite(stable).any():
        counts = sorted(Counter(stable[np.isfinite(stable)].astype(int).tolist()).items())
        told.append(
            f"Stable directions: {', '.join(f'{points} with {count}' for count, points in counts)}."
        )
    if refused := [text.partition(" (set:")[0] for text in sweep.refusals if text]:
        reason, count = Counter(refused).most_common(1)[0]
        short = reason if len(reason) <= _LONGEST_REASON else f"{reason[: _LONGEST_REASON - 1]}…"
        most = f"{count} of them" if count < len(refused) else "all of them" if count > 1 else "it"
        told.append(f"{len(refused)} refused; {most} so: {short}.")
    return told


def settings_line(sweep: Sweep) -> str:
    """What holds for all points: settings, and the accuracy asked for."""
    plan = sweep.description["plan"]
    told = ", ".join(f"{key}={value}" for key, value in plan["settings"].items())
    asked = plan["quantities"]
    accuracy = f"map to {np.degrees(asked['tolerance']):.1g}°" if "tolerance" in asked else ""
    pace = asked.get("rotation_tolerance", 0.0)
    turns = (
        f"rotation numbers to {pace:g} turns a cycle"
        if pace and "rotation" in sweep.columns
        else ""
    )
    return "; ".join(part for part in (f"set: {told}" if told else "", accuracy, turns) if part)
