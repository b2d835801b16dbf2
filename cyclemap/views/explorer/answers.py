"""What the explorer's page asks for: loops by its sliders, and their portraits as plain numbers."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA, Portrait, Progress, noises_of, portrait
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.evidence import Theta0Pairs
from cyclemap.file_text import DEGREES, MILLIMETRES, NUMBER, toml_text
from cyclemap.maps import CircleMap, Orbit, WrappedNormal, fixed_points, sample_staircase
from cyclemap.mechanics import Ellipse
from cyclemap.plain_text import typeset
from cyclemap.protocol.setting_table import NOISE_KEY, SETTINGS, Settings, without_noise
from cyclemap.protocol.settings import loop_from_settings
from cyclemap.views import sentences

CONTROLS = tuple(one for one in SETTINGS.values() if one.label)
_UNITS = {MILLIMETRES: "mm", DEGREES: "°", NUMBER: ""}
Array = NDArray[np.float64]
CELLS = 360
COARSE_TOLERANCE = 1e-3
# Cycles whose course is drawn: one while a slider moves, then as many as the eye follows.
COARSE_CYCLES, EXACT_CYCLES = 1, 8
_FRAMES, _OUTLINE_POINTS, _STAIRCASE_POINTS = 18, 180, 1500
_SENTENCES = (sentences.headline, sentences.lock_sentence, sentences.noise_sentence, sentences.staircase_sentence)
# Places within a cell from which its image is taken.
_SPREAD = (np.arange(4) + 0.5) / 4


@dataclass(frozen=True, eq=False)
class Explored:
    """What the explorer was started with.

    words : of the command line that name the material. settings : of protocol file and --set. loop, sigma (rad) : what
    they come to; None: the noise of the material, where it has one.
    """

    words: tuple[str, ...]
    settings: Settings
    loop: CollectionLoop
    sigma: float | None = None

    def controls(self) -> list[dict[str, object]]:
        """The sliders that suit the object, each with where it stands; a range reaches as far as the value does."""
        outline, found = self.loop.slider.outline, self.values()
        shown = []
        for one in CONTROLS:
            value = found.get(one.key)
            if value is None or (one.key == "corner_share" and not hasattr(outline, "vertices")):
                continue
            high = max(float(outline.sides - 1) if one.key == "side" else one.high, value)
            if high > one.low:
                told = {name: getattr(one, name) for name in ("key", "label", "step", "group")}
                reach = {"unit": _UNITS[one.unit], "low": min(one.low, value), "high": high, "value": value}
                shown.append({**told, **reach})
        return shown

    def values(self) -> dict[str, float]:
        """Where every slider stands that the loop has a value for."""
        loop = self.loop
        sigma = DEFAULT_SIGMA if self.sigma is None else self.sigma
        if self.sigma is None and loop.material.noise is not None:
            sigma = noises_of(loop, loop.circle_map(tolerance=COARSE_TOLERANCE), None)[0].sigma
        found = {}
        for one in CONTROLS:
            value = sigma if one.key == NOISE_KEY else one.of(loop)
            if value is None and one.group in ("Shape", "Pressure"):
                # What is flat has no shape, and what has one no shares of its load.
                value = 0.0
            if value is not None:
                written = value / float(one.unit.in_si)
                # Axes have no sense.
                written = written % 180.0 if one.key in ("phi_deg", "floor_bow_deg", "plate_warp_deg") else written
                found[one.key] = float(f"{written:.10g}")
        return found

    def moved(self, moved: Mapping[str, object]) -> Explored:
        """The same with sliders moved, by key.

        Raises InvalidInput for a key that is no slider's, a value that is no number, or a loop that cannot be.
        """
        known = tuple(one.key for one in CONTROLS)
        for key, value in moved.items():
            if key not in known:
                raise unknown_name("slider", key, known)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InvalidInput(f"{key} is {value!r}; a slider's value is a number")
        return self.told({key: finite_number(key, value) for key, value in moved.items()})

    def told(self, settings: Mapping[str, object]) -> Explored:
        """The same with settings as on the command line."""
        mechanical, sigma = without_noise(settings)
        loop, sigma = loop_from_settings(mechanical, self.loop), self.sigma if sigma is None else sigma
        return replace(self, settings={**self.settings, **settings}, loop=loop, sigma=sigma)

    def command(self) -> str:
        """The command line that gives the same portrait."""
        texts = {key: f"{one:.10g}" if isinstance(one, float) else str(one) for key, one in self.settings.items()}
        told = [f"{key}={text}".replace("'", '"') for key, text in texts.items()]
        return shlex.join(["cyclemap", "portrait", *self.words, *(word for one in told for word in ("--set", one))])

    def protocol(self) -> str:
        """The text of a protocol file that, with the same material, gives the same loop."""
        settings: Settings = {
            key: Decimal(repr(value)) if isinstance(value, float) else value for key, value in self.settings.items()
        }
        comments = (f"cyclemap portrait {shlex.join(self.words)} --protocol FILE",)
        return toml_text({"explored": settings}, comments)


def explored(words: tuple[str, ...], material: str, settings: Settings) -> Explored:
    """What the explorer starts with: a material, and settings as on the command line."""
    return Explored(words, {}, CollectionLoop.mit(material=material)).told(settings)


def coarse(loop: CollectionLoop, sigma: float | None, start: float, cycles: int) -> dict[str, object]:
    """The answer while a slider moves; sigma, start in rad, cycles of the staircase."""
    circle_map = loop.circle_map(tolerance=COARSE_TOLERANCE)
    noise, kicks = noises_of(loop, circle_map, sigma)
    points = tuple(fixed_points(circle_map))
    stable = [sentences.angle(orbit.points[0]) for orbit in points if orbit.stable]
    path = sample_staircase(circle_map, kicks, cycles, start, 0).theta
    return {
        "exact": False,
        "may_lie": [],
        "said": [f"stable near {', '.join(stable)}" if stable else "no stable direction"],
        "density": _listed(cell_density(circle_map, noise), 4),
        **_drawn(loop, circle_map, points, path, start, COARSE_CYCLES),
    }


def exact(
    loop: CollectionLoop, sigma: float | None, start: float, cycles: int, progress: Progress | None = None
) -> dict[str, object]:
    """The answer once it rests: numbers and sentences of `cyclemap portrait`; `progress` may raise to end it."""
    return of_portrait(portrait(loop, sigma=sigma, cycles=cycles, start=start, progress=progress), start, progress)


def of_portrait(found: Portrait, start: float, progress: Progress | None = None) -> dict[str, object]:
    """The answer of a portrait; where noise does not settle the distribution, its density is None."""
    theta = 2 * np.pi * np.arange(CELLS) / CELLS
    certain, known = found.operator.is_certain, found.uncertainty
    said = []
    for sentence in _SENTENCES:
        said.append(typeset(sentence(found)))
        if progress is not None:
            progress(1.0)
    return {
        "exact": True,
        "may_lie": []
        if known is None
        else [_listed(np.degrees([one.lower, one.upper]), 2) for one in known.directions],
        "said": [*said, f"{sentences.accuracy_line(found).capitalize()}."],
        "density": _listed(2 * np.pi * found.operator.density(theta), 4) if certain else None,
        **_drawn(found.loop, found.map, found.fixed_points, found.staircase.theta, start, EXACT_CYCLES),
    }


def cell_density(circle_map: CircleMap, noise: WrappedNormal) -> Array:
    """The stationary density (360,), 1 where uniform, of cells of a degree between which map and noise carry.

    The map carries each cell from four places, whose images are shared by the two cells about them; the noise spreads
    cells by its Fourier coefficients. Good to about a cell.
    """
    width = 2 * np.pi / CELLS
    ends = np.asarray(circle_map((width * (np.arange(CELLS)[:, None] + _SPREAD)).ravel())) / width - 0.5
    cell = np.floor(ends).astype(int)
    begun = np.repeat(np.arange(CELLS), len(_SPREAD))
    carried = np.zeros((CELLS, CELLS))
    for part, share in ((0, 1.0 - (ends - cell)), (1, ends - cell)):
        np.add.at(carried, ((cell + part) % CELLS, begun), share / len(_SPREAD))
    fade = np.exp(-0.5 * (noise.sigma * np.arange(CELLS // 2 + 1)) ** 2)
    spread = np.fft.irfft(np.fft.rfft(carried, axis=0) * fade[:, None], CELLS, axis=0)
    balance = np.vstack([(spread - np.eye(CELLS))[:-1], np.ones(CELLS)])
    found = np.linalg.solve(balance, np.r_[np.zeros(CELLS - 1), CELLS])
    return np.asarray(np.maximum(found, 0.0))


def scene(loop: CollectionLoop) -> dict[str, object]:
    """The object in its own frame (mm): outline, corners, ring and rod."""
    outline = loop.slider.outline
    corners = None if isinstance(outline, Ellipse) else _listed(1e3 * outline.array, 3)
    return {
        "outline": _listed(1e3 * loop.slider.outline_points(_OUTLINE_POINTS), 3),
        "corners": corners,
        "semi_axes": [1e3 * outline.semi_x, 1e3 * outline.semi_y] if isinstance(outline, Ellipse) else None,
        "ring": _listed(1e3 * np.asarray(loop.slider.hitch), 4),
        "rod_radius": 1e3 * loop.pusher.radius,
    }


def measured(pairs: Theta0Pairs | None) -> dict[str, object] | None:
    """Measured orientations to lay over: where cycles started and how far they turned (degrees), and the staircase."""
    if pairs is None:
        return None
    return {
        "theta": _listed(np.degrees(pairs.theta) % 360.0, 2),
        "turn": _listed(np.degrees(pairs.turn), 2),
        "staircase": None if pairs.path is None else _listed(pairs.path / (2 * np.pi), 4),
    }


def _drawn(
    loop: CollectionLoop, circle_map: CircleMap, points: tuple[Orbit, ...], path: Array, start: float, shown: int
) -> dict[str, object]:
    """What every answer has: the map, its fixed points, the staircase, and some cycles without noise."""
    theta = 2 * np.pi * np.arange(CELLS + 1) / CELLS
    every = max(1, math.ceil((len(path) - 1) / _STAIRCASE_POINTS))
    orbit, courses = [start], []
    for _ in range(shown):
        cycle = loop.cycle(orbit[-1])
        orbit.append(cycle.theta_next)
        # Frames (x, y in mm, theta in deg, rod x, rod y in mm) of each stroke, evenly spread over the rod's way.
        strokes = []
        for stroke in (cycle.trajectory.push, cycle.trajectory.drag):
            places = np.linspace(stroke.path[0], stroke.path[-1], _FRAMES)
            columns = [*(1e3 * stroke.pose[:, :2].T), np.degrees(stroke.pose[:, 2]), *(1e3 * stroke.pusher.T)]
            strokes.append(_listed(np.transpose([np.interp(places, stroke.path, one) for one in columns]), 2))
        courses.append(strokes)
    return {
        "turn": _listed(np.degrees(circle_map.turn(theta)), 3),
        "fixed_points": [
            {
                "theta_deg": round(math.degrees(orbit.points[0]), 6),
                "multiplier": round(float(orbit.multiplier), 8),
                "stable": orbit.stable,
            }
            for orbit in points
        ],
        "staircase": {"every": every, "turns": _listed(path[::every] / (2 * np.pi), 4)},
        "orbit": _listed(np.degrees(orbit), 4),
        "courses": courses,
        "scene": scene(loop),
    }


def _listed(values: object, decimals: int) -> list[object]:
    rounded: list[object] = np.round(np.asarray(values, dtype=float), decimals).tolist()
    return rounded
