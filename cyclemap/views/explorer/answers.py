"""What the page draws for one set of settings, in degrees and millimetres, ready for JSON.

While a slider moves, `coarse`: a map good to 1e-3 rad and a distribution over 360 cells. Once it rests, `exact`: the
portrait that the command line computes. Both have the same keys.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA, Portrait, Progress, portrait
from cyclemap.evidence import Theta0Pairs
from cyclemap.maps import CircleMap, Orbit, WrappedNormal, fixed_points, sample_staircase
from cyclemap.mechanics import Ellipse
from cyclemap.views import sentences

Array = NDArray[np.float64]

CELLS = 360
COARSE_TOLERANCE = 1e-3
# Cycles whose course is drawn: one while a slider moves, then as many as the eye follows.
COARSE_CYCLES, EXACT_CYCLES = 1, 8
_FRAMES, _OUTLINE_POINTS, _STAIRCASE_POINTS = 18, 180, 1500
_SENTENCES = (sentences.headline, sentences.lock_sentence, sentences.noise_sentence, sentences.staircase_sentence)
# Places within a cell from which its image is taken.
_SPREAD = (np.arange(4) + 0.5) / 4


def coarse(loop: CollectionLoop, sigma: float | None, start: float, cycles: int) -> dict[str, object]:
    """The answer while a slider moves; sigma, start in rad, cycles of the staircase."""
    circle_map = loop.circle_map(tolerance=COARSE_TOLERANCE)
    noise = WrappedNormal(DEFAULT_SIGMA if sigma is None else sigma)
    points = tuple(fixed_points(circle_map))
    stable = [sentences.angle(orbit.points[0]) for orbit in points if orbit.stable]
    path = sample_staircase(circle_map, noise, cycles, start, 0).theta
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
        said.append(sentence(found))
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
        courses.append([_course(stroke) for stroke in (cycle.trajectory.push, cycle.trajectory.drag)])
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


def _course(trajectory: object) -> list[object]:
    """Frames (x, y in mm, theta in deg, rod x, rod y in mm) of a stroke, evenly spread over the rod's way."""
    pose, rod, path = trajectory.pose, trajectory.pusher, trajectory.path  # type: ignore[attr-defined]
    places = np.linspace(path[0], path[-1], _FRAMES)
    columns = [*(1e3 * pose[:, :2].T), np.degrees(pose[:, 2]), *(1e3 * rod.T)]
    return _listed(np.transpose([np.interp(places, path, column) for column in columns]), 2)


def _listed(values: object, decimals: int) -> list[object]:
    rounded: list[object] = np.round(np.asarray(values, dtype=float), decimals).tolist()
    return rounded
