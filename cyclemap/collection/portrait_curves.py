"""The curves of a portrait, ready to draw."""

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.portrait import Portrait
from cyclemap.maps import CircleMap, transfer_operator

CURVE_SAMPLES = 1440
# Surfaces, from fresh to worn, whose densities are averaged.
WORN_SURFACES = 8
COBWEB_CYCLES = 400
COBWEB_REVERSALS = 12
SETTLED = np.deg2rad(0.02)


@dataclass(frozen=True)
class Jump:
    """A place where the map jumps: θ, and the turn just before and just after it (rad)."""

    theta: float
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class TurnCurve:
    """The turn of a map over [0, 2π]: pieces (theta, turn), each (n,) rad, and the jumps between
    them.
    """

    pieces: tuple[tuple[Array, Array], ...]
    jumps: tuple[Jump, ...]


@dataclass(frozen=True, eq=False)
class Cobweb:
    """A window on the graph of the map, and paths of the cobweb in it.

    Attributes
    ----------
    low, high : float
        The window on θ (lifted), rad.
    pieces : tuple of tuple[ndarray, ndarray]
        (θ, f(θ)) of the map in the window, each (n,), rad.
    paths : tuple of ndarray
        Corners (m, 2) of each cobweb, rad, on the same lift.
    """

    low: float
    high: float
    pieces: tuple[tuple[Array, Array], ...]
    paths: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class PortraitCurves:
    """The curves that are drawn of a portrait.

    density_theta, density : (n,) rad and (n,) per rad; where the surface wears, the mean over the
        run of the densities that the surface of each of some cycles would lead to.
    """

    turn: TurnCurve
    cobweb: Cobweb
    density_theta: Array
    density: Array


def portrait_curves(portrait: Portrait) -> PortraitCurves:
    """The curves of `portrait`."""
    theta = np.linspace(0.0, TWO_PI, CURVE_SAMPLES + 1)
    drifting = portrait.drifting
    if drifting is None:
        density = portrait.operator.density(theta)
    else:
        shares = (np.arange(WORN_SURFACES) + 0.5) / WORN_SURFACES
        maps = (drifting.at(portrait.staircase.cycles * share) for share in shares.tolist())
        density = np.mean(
            [transfer_operator(worn, portrait.noise).density(theta) for worn in maps], axis=0
        )
    return PortraitCurves(turn_curve(portrait.map), cobweb(portrait), theta, density)


def turn_curve(cycle_map: CircleMap) -> TurnCurve:
    """The turn of `cycle_map` over one circle, cut where the map jumps."""
    places, before, after = cycle_map.jumps()
    turns = zip(places.tolist(), (before - places).tolist(), (after - places).tolist(), strict=True)
    jumps = tuple(Jump(*values) for values in turns)
    pieces = _pieces(0.0, TWO_PI, places)
    return TurnCurve(tuple((theta, cycle_map.turn(theta)) for theta in pieces), jumps)


def cobweb(portrait: Portrait) -> Cobweb:
    """The cobweb where it tells most: about a stable point, a gathering jump, or the slowest place.

    The window is four times as wide as the largest turn to either side (at least 20 degrees, at
    most the whole circle), so that single cycles can be told apart. Paths start at its ends, where
    the map leads inward, and on both sides of every unstable point.
    """
    curve = turn_curve(portrait.map)
    theta, turn = (np.concatenate(columns) for columns in zip(*curve.pieces, strict=True))
    places = [
        *(float(orbit.points[0]) for orbit in portrait.stable_points),
        *portrait.gathering_jumps,
    ]
    centre = places[0] if places else float(theta[np.argmin(np.abs(turn))])
    largest = max(abs(portrait.turns.min_turn), abs(portrait.turns.max_turn))
    half = float(np.clip(4 * largest, np.deg2rad(20.0), np.pi))
    low = centre - half
    high = centre + half
    # Every lift of the jumps and of the unstable points in the window.
    jumps = np.array([jump.theta for jump in curve.jumps])
    unstable = np.array([orbit.points[0] for orbit in portrait.fixed_points if not orbit.stable])
    turns = TWO_PI * np.arange(np.floor(low / TWO_PI) - 1, np.ceil(high / TWO_PI) + 1)
    lifts = (np.add.outer(turns, theta).ravel() for theta in (jumps, unstable))
    cuts, between = (every[(every >= low) & (every <= high)] for every in lifts)
    pieces = _pieces(low, high, cuts)
    beside = 0.01 * (high - low)
    starts = [low + beside] * bool(portrait.map.turn(low) > 0) + [high - beside] * bool(
        portrait.map.turn(high) < 0
    )
    starts += [place + side for place in between for side in (-beside, beside)]
    paths = tuple(_cobweb_path(portrait.map, start, low, high) for start in starts)
    return Cobweb(low, high, tuple((piece, portrait.map(piece)) for piece in pieces), paths)


def _cobweb_path(cycle_map: CircleMap, start: float, low: float, high: float) -> Array:
    """Corners (m, 2) of the cobweb from `start` until it leaves the window, settles or keeps
    turning back.
    """
    visited = [start]
    reversals = 0
    while len(visited) <= COBWEB_CYCLES and reversals < COBWEB_REVERSALS:
        visited.append(float(cycle_map(visited[-1])))
        step = visited[-1] - visited[-2]
        if not low <= visited[-1] <= high or abs(step) < SETTLED:
            break
        reversals += len(visited) > 2 and step * (visited[-2] - visited[-3]) < 0
    corners = np.repeat(visited, 2)
    return np.stack([corners[:-1], np.concatenate([corners[:1], corners[2:]])], axis=1)


def _pieces(low: float, high: float, cuts: Array) -> tuple[Array, ...]:
    """Sample points (n,) of [low, high], in pieces that end just short of each cut."""
    hair = 1e-9 * TWO_PI
    edges = np.concatenate(
        [[low], np.sort(cuts[(cuts > low + hair) & (cuts < high - hair)]), [high]]
    )
    spacing = TWO_PI / CURVE_SAMPLES
    sizes = np.maximum(np.ceil(np.diff(edges) / spacing).astype(int) + 1, 2)
    return tuple(
        np.linspace(left + hair, right - hair, size)
        for left, right, size in zip(edges[:-1], edges[1:], sizes, strict=True)
    )
