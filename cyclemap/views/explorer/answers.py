"""What the explorer's page begins with: where its sliders stand,
and a portrait as plain numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import Portrait
from cyclemap.evidence import Theta0Pairs
from cyclemap.file_text import DEGREES, MILLIMETRES, NUMBER
from cyclemap.mechanics import Ellipse
from cyclemap.plain_text import typeset
from cyclemap.protocol.setting_table import NOISE_KEY, SETTINGS, SHAPES, SHARES
from cyclemap.views import sentences

CONTROLS = tuple(setting for setting in SETTINGS.values() if setting.label)
_UNITS = {MILLIMETRES: "mm", DEGREES: "°", NUMBER: ""}
_AXES = ("phi_deg", "floor_bow_deg", "plate_warp_deg")
Array = NDArray[np.float64]
CELLS = 360
# Cycles whose course is drawn: as many as the eye follows.
_CYCLES, _FRAMES, _OUTLINE_POINTS, _STAIRCASE_POINTS = 8, 18, 180, 1500
_SENTENCES = (
    sentences.headline,
    sentences.lock_sentence,
    sentences.noise_sentence,
    sentences.staircase_sentence,
)


def slider_values(loop: CollectionLoop, sigma: float) -> dict[str, float]:
    """Where every slider stands, by key and in its unit; sigma : noise of a cycle, rad.

    >>> slider_values(CollectionLoop.mit(), 0.0)["push_mm"]
    150.0
    """
    values = {}
    for setting in CONTROLS:
        value = sigma if setting.key == NOISE_KEY else setting.of(loop)
        # What is flat has no shape, and what has one no shares of its load.
        written = 0.0 if value is None else float(value) / float(setting.unit.in_si)
        # Axes have no sense.
        values[setting.key] = written % 180.0 if setting.key in _AXES else written
    return values


def slider_controls(
    loop: CollectionLoop, values: Mapping[str, float], tables: Mapping[str, dict[str, bool]]
) -> list[dict[str, object]]:
    """The sliders that suit the object, each with where it stands; a range reaches as far as the
    value does.

    tables : of `browser_tables`, which tell what the page can compute.
    """
    parts, controls = tables["parts"], []
    left_out = {*SHAPES} if tables["pressed"] is None else set()
    left_out |= set() if parts["can_share"] else {*SHARES}
    left_out |= set() if parts.get("can_frame") else {"inner_share", "rim_share"}
    left_out |= set() if parts.get("can_corner") else {"corner_share"}
    left_out |= set() if tables["is_convex"] else {"pusher_radius_mm"}
    for setting in CONTROLS:
        value = values[setting.key]
        high = max(
            float(loop.slider.outline.sides - 1) if setting.key == "side" else setting.high, value
        )
        low = min(setting.low, value)
        if setting.key == "pusher_radius_mm" and value > 0.0:
            # The contact curve of a point has no arcs.
            low = min(setting.step, value)
        if setting.key in left_out or high <= low:
            continue
        facts = {name: getattr(setting, name) for name in ("key", "label", "step", "group")}
        controls.append(
            {**facts, "unit": _UNITS[setting.unit], "low": low, "high": high, "value": value}
        )
    return controls


def of_portrait(portrait: Portrait, start: float) -> dict[str, object]:
    """The portrait as the page draws it; where noise does not settle the distribution, its density
    is None.
    """
    degrees = 2 * np.pi * np.arange(CELLS + 1) / CELLS
    certain, known, loop = portrait.operator.is_certain, portrait.uncertainty, portrait.loop
    ends = (
        []
        if known is None
        else [np.degrees([direction.lower, direction.upper]) for direction in known.directions]
    )
    path = portrait.staircase.theta
    every = max(1, math.ceil((len(path) - 1) / _STAIRCASE_POINTS))
    orbit, courses = _courses(loop, start)
    return {
        "may_lie": [_listed(pair, 2) for pair in ends],
        "said": [
            *(typeset(sentence(portrait)) for sentence in _SENTENCES),
            f"{sentences.accuracy_line(portrait).capitalize()}.",
        ],
        "density": _listed(2 * np.pi * portrait.operator.density(degrees[:-1]), 4)
        if certain
        else None,
        "turn": _listed(np.degrees(portrait.map.turn(degrees)), 3),
        "fixed_points": [
            {
                "theta_deg": round(math.degrees(point.points[0]), 6),
                "multiplier": round(float(point.multiplier), 8),
                "stable": point.stable,
            }
            for point in portrait.fixed_points
        ],
        "staircase": {"every": every, "turns": _listed(path[::every] / (2 * np.pi), 4)},
        "orbit": _listed(np.degrees(orbit), 4),
        "courses": courses,
        "scene": scene(loop),
    }


def _courses(loop: CollectionLoop, start: float) -> tuple[list[float], list[list[list[object]]]]:
    """Some cycles without noise: orientations, rad, and frames (x, y mm, theta deg, rod x, rod y
    mm) of each stroke.
    """
    orbit, courses = [start], []
    for _ in range(_CYCLES):
        cycle = loop.cycle(orbit[-1])
        orbit.append(cycle.theta_next)
        strokes = []
        for stroke in (cycle.trajectory.push, cycle.trajectory.drag):
            # Evenly spread over the rod's way.
            places = np.linspace(stroke.path[0], stroke.path[-1], _FRAMES)
            columns = [
                *(1e3 * stroke.pose[:, :2].T),
                np.degrees(stroke.pose[:, 2]),
                *(1e3 * stroke.pusher.T),
            ]
            frames = np.transpose([np.interp(places, stroke.path, column) for column in columns])
            strokes.append(_listed(frames, 2))
        courses.append(strokes)
    return orbit, courses


def scene(loop: CollectionLoop) -> dict[str, object]:
    """The object in its own frame (mm): outline, corners, ring and rod."""
    outline = loop.slider.outline
    corners = None if isinstance(outline, Ellipse) else _listed(1e3 * outline.array, 3)
    return {
        "outline": _listed(1e3 * loop.slider.outline_points(_OUTLINE_POINTS), 3),
        "corners": corners,
        "semi_axes": [1e3 * outline.semi_x, 1e3 * outline.semi_y]
        if isinstance(outline, Ellipse)
        else None,
        "ring": _listed(1e3 * np.asarray(loop.slider.hitch), 4),
        "rod_radius": 1e3 * loop.pusher.radius,
    }


def measured(pairs: Theta0Pairs | None) -> dict[str, object] | None:
    """Measured orientations to lay over: where cycles started and how far they turned (degrees),
    and the staircase.
    """
    if pairs is None:
        return None
    return {
        "theta": _listed(np.degrees(pairs.theta) % 360.0, 2),
        "turn": _listed(np.degrees(pairs.turn), 2),
        "staircase": None if pairs.path is None else _listed(pairs.path / (2 * np.pi), 4),
    }


def _listed(values: object, decimals: int) -> list[object]:
    rounded: list[object] = np.round(np.asarray(values, dtype=float), decimals).tolist()
    return rounded
