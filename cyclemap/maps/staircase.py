"""Staircases: noisy paths of the lifted orientation, and what theory predicts of their steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.orbits import Orbit, crossings_by_jump, fixed_points
from cyclemap.maps.passage import mean_passage_time
from cyclemap.maps.transfer_operator import TransferOperator, transfer_operator

_GRID = 4_096
_CHUNK = 65_536
_FLAT = 1e-9  # radians: a turn that varies by less has no slow zone


@dataclass(frozen=True, eq=False)
class Staircase:
    """One path θ_{n+1} = F(θ_n) + ξ_n of the lifted orientation.

    theta : shape (cycles + 1,), radians, not wrapped, the start first; seed : of the noise; start : radians.
    """

    theta: Array
    seed: int
    start: float

    @property
    def cycles(self) -> int:
        """Number of cycles."""
        return int(self.theta.size - 1)

    @property
    def mean_turn(self) -> float:
        """(θ_N - θ_0)/N, radians a cycle."""
        return float((self.theta[-1] - self.theta[0]) / self.cycles)


@dataclass(frozen=True)
class SlowZone:
    """A stretch of the circle where a path lingers.

    centre : radians in [0, 2π): the stable fixed point, the attracting jump, or the ghost's slowest point.
    arc : (start, end), radians, start < end: the zone, see ``predict_staircase``.
    kind : "stable", "jump" or "ghost".
    residence_cycles : mean number of cycles spent there in one visit.
    """

    centre: float
    arc: tuple[float, float]
    kind: str
    residence_cycles: float


@dataclass(frozen=True)
class StaircaseSummary:
    """What theory says of a staircase; see ``predict_staircase`` for the definitions.

    mean_turn : radians a cycle. mean_residence_cycles : cycles, or None without slow zones; inf above 1e300.
    step : radians, or None without slow zones. zones : the slow zones, sorted by centre.
    """

    mean_turn: float
    mean_residence_cycles: float | None
    step: float | None
    zones: tuple[SlowZone, ...]


def sample_staircase(
    circle_map: CircleMap, noise: Noise | None, cycles: int, start: float = 0.0, seed: int = 0
) -> Staircase:
    """A path of ``cycles`` cycles from ``start`` (radians); ``noise`` None follows the map alone.

    The same seed gives the same path. About a million cycles a second for sampled and textbook maps, a
    hundred thousand for maps given by numpy callables.

    >>> path = sample_staircase(CircleMap.rigid(0.25), None, 4)
    >>> (path.theta / np.pi).round(6).tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    count = whole_number("cycles", cycles, least=1)
    theta = begin = finite_number("start", start)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    if noise is not None and not isinstance(noise, Noise):
        raise InvalidInput(f"the noise is {noise!r}: give a noise, for example WrappedNormal(0.02), or None")
    lift = circle_map.scalar()
    path = np.empty(count + 1)
    path[0] = theta
    for at in range(0, count, _CHUNK):
        size = min(_CHUNK, count - at)
        kicks = np.zeros(size) if noise is None else noise.sample(rng, size)
        visited = []
        for kick in kicks.tolist():
            theta = lift(theta) + kick
            visited.append(theta)
        path[at + 1 : at + 1 + size] = visited
    return Staircase(read_only(path), seed, begin)


def predict_staircase(
    circle_map: CircleMap, noise: Noise, operator: TransferOperator | None = None
) -> StaircaseSummary:
    """Mean turn, step height and residence of the staircase that the noisy map will draw.

    mean_turn : 2π times the operator's rotation number.
    Slow zones : the stable fixed points and attracting jumps. Around each the zone is the arc between the
        unstable points (or repelling jumps, or saddle-nodes) next to it on both sides; its residence is
        the mean passage time from the point out of that arc. With a single unstable point the arc is the
        whole turn between two copies of it, and the path leaves it on the lifted line.
        Where nothing is stable: the ghosts, the connected arcs on which |F(θ) - θ| is below half its mean
        over the circle (uniform weight). The residence is the mean passage time out of the arc from its
        upstream end.
    mean_residence_cycles : average of the zones' residences.
    step : 2π divided by the number of zones, the mean spacing of successive slow zones on a climb.
    A turn that is constant to 1e-9 rad has no slow zone: both are None.

    ``operator`` may pass a ``transfer_operator(circle_map, noise)`` that is already there.

    >>> from cyclemap.maps.noise import WrappedNormal
    >>> found = predict_staircase(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05))
    >>> [zone.kind for zone in found.zones], round(found.step, 6)
    (['ghost'], 6.283185)
    """
    known = transfer_operator(circle_map, noise) if operator is None else operator
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: a staircase needs degree 1")
    mean_turn = TWO_PI * known.rotation_number
    grid = TWO_PI * np.arange(_GRID) / _GRID
    turn = circle_map.turn(grid)
    if np.ptp(turn) <= _FLAT:
        return StaircaseSummary(mean_turn, None, None, ())
    zones = _stable_zones(circle_map, noise) or _ghosts(circle_map, noise, grid, turn)
    if not zones:
        return StaircaseSummary(mean_turn, None, None, ())
    residence = float(np.mean([zone.residence_cycles for zone in zones]))
    return StaircaseSummary(mean_turn, residence, TWO_PI / len(zones), tuple(zones))


def _stable_zones(circle_map: CircleMap, noise: Noise) -> list[SlowZone]:
    points, jumps = fixed_points(circle_map), crossings_by_jump(circle_map)
    centres = [(float(p.points[0]), p.winding, "stable") for p in points if p.stable]
    centres += [(j.theta, j.winding, "jump") for j in jumps if j.attracting]
    edges = [float(p.points[0]) for p in points if _parts(p)] + [j.theta for j in jumps if not j.attracting]
    if not edges:
        return []
    return [
        _stable_zone(circle_map, noise, centre, winding, np.array(edges), kind)
        for centre, winding, kind in sorted(centres)
    ]


def _parts(point: Orbit) -> bool:
    return point.kind in ("unstable", "saddle-node")


def _stable_zone(circle_map: CircleMap, noise: Noise, centre: float, winding: int, edges: Array, kind: str) -> SlowZone:
    above = centre + float(np.min(np.mod(edges - centre, TWO_PI)))
    below = centre - float(np.min(np.mod(centre - edges, TWO_PI)))
    whole = above - below > TWO_PI - 1e-9
    arc = (above - TWO_PI, above) if whole else (below, above)
    # Seen from a frame that makes whole turns along with the fixed point, it stays where it is.
    still = _without_turns(circle_map, winding) if winding else circle_map
    residence = mean_passage_time(still, noise, centre, arc, lifted=whole)
    return SlowZone(centre, arc, kind, residence)


def _without_turns(circle_map: CircleMap, winding: int) -> CircleMap:
    shift = TWO_PI * winding
    return CircleMap(lambda theta: circle_map(theta) - shift, circle_map.derivative, circle_map.breaks)


def _ghosts(circle_map: CircleMap, noise: Noise, grid: Array, turn: Array) -> list[SlowZone]:
    slowness = np.abs(turn)
    level = 0.5 * float(np.mean(slowness))
    slow = slowness < level
    if not np.any(slow) or np.all(slow):
        return []
    enters = np.flatnonzero(slow & ~np.roll(slow, 1))
    zones = [_ghost(circle_map, noise, grid, turn, level, int(i)) for i in enters]
    return sorted(zones, key=lambda zone: zone.centre)


def _ghost(circle_map: CircleMap, noise: Noise, grid: Array, turn: Array, level: float, first: int) -> SlowZone:
    """The ghost whose slow arc begins at grid point ``first``; it ends where |turn| crosses the level."""
    slowness = np.abs(np.roll(turn, -first))
    length = int(np.argmax(slowness >= level))
    step, begin = grid[1], float(grid[first])
    start = begin - step * _share(level, slowness[0], slowness[-1])
    end = begin + step * (length - 1) + step * _share(level, slowness[length - 1], slowness[length])
    slowest = int(np.argmin(slowness[:length]))
    forward = np.roll(turn, -first)[slowest] >= 0.0
    residence = mean_passage_time(circle_map, noise, start if forward else end, (start, end))
    centre = float((begin + step * slowest) % TWO_PI)
    return SlowZone(centre, (float(start), float(end)), "ghost", residence)


def _share(level: float, inside: float, outside: float) -> float:
    """Part of a grid step from the inside point to where the level is crossed."""
    return float((level - inside) / (outside - inside))
