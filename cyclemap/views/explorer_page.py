"""Explorer and report as one HTML file: the engine inside it, as WebAssembly, where its sliders
stand, and a portrait as plain numbers; the same bytes for the same input.

Its policy lets in only the scripts and styles it was written with, by their digests, and no request
at all.
"""

from __future__ import annotations

import base64
import hashlib
import io
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from html import escape
from importlib import metadata, resources
from pathlib import Path

import jinja2
import numpy as np
from PIL import Image

from cyclemap.arrays import TWO_PI, along_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import Portrait, portrait
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.evidence import Theta0Pairs
from cyclemap.mechanics import Ellipse
from cyclemap.mechanics.browser_tables import browser_tables, wasm_engine
from cyclemap.plain_text import typeset
from cyclemap.protocol.collection_file import collection_tables, plain_numbers
from cyclemap.protocol.settings import NOISE_KEY, SETTINGS, SHAPES, SHARES
from cyclemap.views import sentences
from cyclemap.views.panels.layout import render
from cyclemap.views.portrait_page import portrait_page
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER

_PACKAGES = ("cyclemap", "numpy", "scipy", "casadi")
WORKER = ("engine.js", "circle.js", "worker.js")
SCRIPTS = ("drawing.js", "page.js")
# The ring of the stories is moved along its own direction, up to this many of its distances from
# the origin; from the origin itself along x, up to so many metres.
_FARTHEST, _FARTHEST_FROM_ORIGIN = 1.8, 0.04
# Settings of the stories' floor, where the own one has none to tell.
_USUAL_FLOOR = ("mu_a", "mu_b", "phi_deg", "m0", "n0")
_DOTS_PER_INCH, _COLOURS = 80, 48
_FRAME_HEIGHT = 860
CONTROLS = tuple(setting for setting in SETTINGS.values() if setting.label)
_DEGREES = math.degrees(1.0)
_UNITS = {MILLIMETRES: "mm", DEGREES: "°", NUMBER: ""}
_AXES = ("phi_deg", "floor_bow_deg", "plate_warp_deg")
CELLS = 360
# Cycles whose course is drawn: as many as the eye follows.
_CYCLES, _FRAMES, _OUTLINE_POINTS, _STAIRCASE_POINTS = 8, 18, 180, 1500
_SENTENCES = (
    sentences.headline,
    sentences.lock_sentence,
    sentences.noise_sentence,
    sentences.staircase_sentence,
)


@dataclass(frozen=True)
class Section:
    """A heading with its paragraphs, and a picture as PNG with what it shows,
    where there is one."""

    title: str
    paragraphs: tuple[str, ...]
    picture: bytes = b""
    shows: str = ""

    @property
    def image(self) -> str:
        """The picture as an address of its own."""
        return f"data:image/png;base64,{_base64(self.picture)}"


@dataclass(frozen=True)
class Download:
    """A file inside the page: its name, and its text."""

    name: str
    text: str

    @property
    def address(self) -> str:
        """The file as an address of its own."""
        return f"data:text/plain;charset=utf-8;base64,{_base64(self.text.encode())}"


def page_html(
    shown: Portrait,
    start: float,
    words: Sequence[str],
    settings: Mapping[str, object],
    *,
    pairs: Theta0Pairs | None = None,
    sections: Sequence[Section] = (),
    downloads: Sequence[Download] = (),
    provenance: Sequence[tuple[str, str]] = (),
) -> str:
    """The page of a portrait as HTML.

    start : rad, of the animated cycles and the staircase. words, settings : what a command line
    that gives the same loop names, for the one that the page offers. pairs : measured orientations.
    sections, downloads, provenance : what a report tells beneath, in order. The portrait as a
    picture is shown where scripts do not run.
    """
    loop, sigma = shown.loop, shown.noise.sigma
    values, tables = slider_values(loop, sigma), browser_tables(loop.model, loop.reset)
    data = {
        "name": loop.material.name,
        "answer": of_portrait(shown, start),
        "measured": measured(pairs),
        "controls": slider_controls(loop, values, tables),
        "values": values,
        "start_deg": math.degrees(start) % 360.0,
        "cycles": shown.staircase.cycles,
        "tables": tables,
        "stories": _stories(loop),
        "words": list(words),
        "settings": {
            key: f"{value:.10g}" if isinstance(value, float) else str(value)
            for key, value in settings.items()
        },
        "wasm": _base64(wasm_engine()),
    }
    style = "\n".join(_file(name) for name in ("page.css", "uplot/uPlot.min.css"))
    plot = _file("uplot/uPlot.iife.min.js")
    script = "\n".join(map(_file, SCRIPTS))
    policy = (
        f"default-src 'none'; script-src {_digest(plot)} {_digest(script)} 'wasm-unsafe-eval'; "
        f"worker-src blob:; style-src {_digest(style)}; img-src data:; base-uri 'none'; "
        "form-action 'none'"
    )
    page = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return page.from_string(_file("page.html")).render(
        data=data,
        picture=_base64(_still(shown)),
        policy=policy,
        style=style,
        plot=plot,
        worker="\n".join(map(_file, WORKER)),
        script=script,
        sections=sections,
        downloads=downloads,
        provenance=provenance,
    )


def explorer_frame(loop: CollectionLoop) -> str:
    """Return the page of a loop as HTML for a notebook, 500 kB: a frame of its own, laid over a
    picture, which is left where what is not trusted may have no frames.

    >>> from cyclemap import CollectionLoop
    >>> explorer_frame(CollectionLoop.mit("plywood")).count("<iframe")
    1
    """
    shown, tables = portrait(loop), collection_tables(loop)
    settings = {
        key: value for table in tables.values() for key, value in plain_numbers(table).items()
    }
    page = page_html(shown, 0.0, (loop.material.name,), settings)
    still = Section("", (), _still(shown)).image
    return (
        f'<div style="position: relative; min-height: {_FRAME_HEIGHT}px">'
        f'<img alt="portrait of {escape(loop.material.name)}" width="100%" src="{still}">'
        '<iframe sandbox="allow-scripts allow-downloads" style="position: absolute; inset: 0; '
        'width: 100%; height: 100%; border: 0; background: #fff" '
        f'srcdoc="{escape(page)}"></iframe></div>'
    )


@lru_cache(maxsize=1)
def _still(shown: Portrait) -> bytes:
    """The portrait as a picture of few colours, a third as long as with all of them."""
    whole = render(portrait_page(shown, portrait_curves(shown)), "png", _DOTS_PER_INCH)
    few = io.BytesIO()
    with Image.open(io.BytesIO(whole)) as picture:
        picture.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(
            few, "png", optimize=True
        )
    return few.getvalue()


def provenance_of(shown: Portrait, command: str, inputs: Sequence[Path]) -> list[tuple[str, str]]:
    """Where a report comes from: the command that made it, the digests of what it read,
    versions."""
    versions = [f"{name} {metadata.version(name)}" for name in _PACKAGES]
    return [
        ("command", command),
        ("seed", str(shown.staircase.seed)),
        *(
            (f"input {path.name}", f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}")
            for path in inputs
        ),
        ("material", shown.loop.material.provenance or "as named on the command line"),
        ("versions", ", ".join([*versions, f"Python {platform.python_version()}"])),
    ]


def _stories(loop: CollectionLoop) -> dict[str, object]:
    """Where the page looks for its three stories: the line of the ring (mm), and a floor to fall
    back on.
    """
    hitch = np.asarray(loop.slider.hitch)
    distance = math.hypot(*hitch)
    along = hitch / distance if distance > 0.0 else np.array([1.0, 0.0])
    # No farther than the sliders of the ring reach; the last place tried is .05 farther than told.
    reach = np.maximum(SETTINGS["hitch_x_mm"].high, 1e3 * np.abs(hitch)) / 1.05
    with np.errstate(divide="ignore"):
        farthest = min(
            1e3 * (_FARTHEST * distance or _FARTHEST_FROM_ORIGIN), *reach / np.abs(along)
        )
    usual = slider_values(CollectionLoop.mit("plywood"), 0.0)
    floor = {key: usual[key] for key in _USUAL_FLOOR} | dict.fromkeys((*SHAPES, *SHARES), 0.0)
    return {
        "along": along.tolist(),
        "farthest": float(farthest),
        "floor": floor,
    }


def _digest(text: str) -> str:
    return f"'sha256-{_base64(hashlib.sha256(text.encode()).digest())}'"


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _file(name: str) -> str:
    return (resources.files("cyclemap.views") / "explorer" / name).read_text(encoding="utf-8")


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
    # The contact curve of a point about corners has no arcs, which a rod rolls along.
    has_arcs = tables["semi_axes"] is not None or values["pusher_radius_mm"] > 0.0
    left_out = set[str]()
    for keys, is_computed in (
        (SHAPES, tables["pressed"] is not None),
        (SHARES, parts["can_share"]),
        (("inner_share", "rim_share"), parts.get("can_frame")),
        (("corner_share",), parts.get("can_corner")),
        (("pusher_radius_mm",), tables["is_convex"] and has_arcs),
    ):
        if not is_computed:
            left_out |= {*keys}
    for setting in CONTROLS:
        value = values[setting.key]
        high = max(
            float(loop.slider.outline.sides - 1) if setting.key == "side" else setting.high, value
        )
        low = min(setting.low, value)
        if setting.key == "pusher_radius_mm" and value > 0.0:
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
    degrees = TWO_PI * np.arange(CELLS + 1) / CELLS
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
        "density": _listed(TWO_PI * portrait.operator.density(degrees[:-1]), 4)
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
        "staircase": {"every": every, "turns": _listed(path[::every] / TWO_PI, 4)},
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
            seen = np.column_stack([stroke.pose, stroke.pusher]) * [1e3, 1e3, _DEGREES, 1e3, 1e3]
            strokes.append(_listed(along_way(places, stroke.path, seen), 2))
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
        "staircase": None if pairs.path is None else _listed(pairs.path / TWO_PI, 4),
    }


def _listed(values: object, decimals: int) -> list[object]:
    rounded: list[object] = np.round(np.asarray(values, dtype=float), decimals).tolist()
    return rounded
