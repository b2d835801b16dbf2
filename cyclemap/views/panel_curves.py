"""The curves of the panels: functions of the angle sampled in degrees, cut where they jump or run round the circle."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.collection.portrait import FULL_TURN
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.maps import CircleMap, OrbitBranch, SlowPassage, nth_iterate

Curve = tuple[Array, Array]

PER_DEGREE = np.pi / 180
SAMPLES = 1440
WINDOW_SAMPLES = 400
# Widths of a slow passage that are shown on each side of its slowest point.
WIDTHS_SHOWN = 4.0


def map_graph(circle_map: CircleMap) -> list[Curve]:
    """The graph of `circle_map` over one circle, (θ, θ' mod 360) in degrees, cut at jumps and where θ' runs round."""
    graph: list[Curve] = []
    for theta, turn in turn_curve(circle_map).pieces:
        graph += cut_at_turns(np.degrees(theta), theta + turn)
    return graph


def cut_at_turns(x: Array, angle: Array) -> list[Curve]:
    """Pieces (x, angle mod 360 in degrees) of the polyline through (`x`, `angle` in rad), cut at whole turns."""
    position = np.arange(angle.size, dtype=float)
    levels = np.arange(np.floor(angle.min() / FULL_TURN) + 1, np.ceil(angle.max() / FULL_TURN)) * FULL_TURN
    crossings = [_crossings(angle, level) for level in levels]
    places = np.unique(np.concatenate([position, *crossings]))
    x, angle = np.interp(places, position, x), np.interp(places, position, angle)
    turn = np.floor(0.5 * (angle[:-1] + angle[1:]) / FULL_TURN)
    edges = [0, *(np.flatnonzero(np.diff(turn)) + 1).tolist(), angle.size - 1]
    return [
        (x[first : last + 1], np.degrees(angle[first : last + 1] - FULL_TURN * turn[first]))
        for first, last in pairwise(edges)
    ]


def _crossings(angle: Array, level: float) -> Array:
    """Where along the polyline `angle` crosses `level`, in numbers of its points."""
    before = np.flatnonzero(np.diff(angle > level))
    return np.asarray(before + (level - angle[before]) / (angle[before + 1] - angle[before]))


def density_curve(density: Callable[[Array], Array], low: float = 0.0, high: float = FULL_TURN) -> Curve:
    """(angles in degrees, `density` per degree) from `low` to `high` (rad)."""
    theta = np.linspace(low, high, SAMPLES + 1)
    return np.degrees(theta), PER_DEGREE * density(theta)


def passage_curve(circle_map: CircleMap, passage: SlowPassage) -> tuple[Array, Array, Array]:
    """(θ, move of the n-fold cycle less its whole turns, parabola ε + a x²) about a slow passage, in degrees.

    The move is nan where it jumps.
    """
    reach = min(WIDTHS_SHOWN * passage.width, np.pi)
    iterate = nth_iterate(circle_map, passage.period)
    x = np.linspace(-reach, reach, WINDOW_SAMPLES + 1)
    move = iterate.turn(passage.theta + x) - FULL_TURN * passage.winding
    jumps = np.mod(iterate.jumps()[0] - passage.theta + reach, FULL_TURN) - reach
    jumps = jumps[jumps < reach]
    places = np.searchsorted(x, jumps)
    x, move = np.insert(x, places, jumps), np.insert(move, places, np.nan)
    parabola = passage.gap + passage.curvature * x**2
    return np.degrees(passage.theta + x), np.degrees(move), np.degrees(parabola)


def branch_curves(branch: OrbitBranch) -> list[tuple[bool, Curve]]:
    """(stable, (parameter, angle mod 360 in degrees)) for every run of one stability of every point of the orbits."""
    stable, angles = _stable_segments(branch), branch.points
    edges = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), stable.size]
    return [
        (bool(stable[first]), curve)
        for first, last in pairwise(edges)
        for points in angles[first : last + 1].T
        for curve in cut_at_turns(branch.parameter[first : last + 1], points)
    ]


def _stable_segments(branch: OrbitBranch) -> NDArray[np.bool_]:
    """Whether the orbits between neighbouring ones are stable: as the end is that is no bifurcation."""
    special = np.array([float(found.parameter) for found in branch.special])
    distance = np.abs(branch.parameter[:, None] - special).min(axis=1, initial=np.inf)
    bifurcates = distance <= 1e-9 * max(float(np.ptp(branch.parameter)), 1e-300)
    return np.where(bifurcates[:-1], branch.stable[1:], branch.stable[:-1])
