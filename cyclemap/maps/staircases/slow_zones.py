"""Slow zones: where a noisy path lingers, how long, and the staircase that follows from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.map_algebra import shifted
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
from cyclemap.maps.orbits.periodic_points import Orbit, crossings_by_jump, fixed_points
from cyclemap.maps.passages.passage_times import mean_passage_time
from cyclemap.maps.quadrature import arc_rule

_GRID = 4_096
_INSIDE = 257  # angles at which the density in a ghost's arc is averaged
_FLAT = 1e-9  # radians: a turn that varies by less has no slow zone
_CORE = 0.5  # a visit must come this much nearer the centre than the arc's ends are
_FINE, _COARSE = 1e-10, 1e-6  # noise coefficients neglected by the visits' law and by its check
_MAX_BANDWIDTH, _MAX_NODES = 4_000.0, 2_000
_LONGEST_VISIT = 1e5  # cycles: beyond, visits are taken to be exponential, with the residence as mean
_LINGERING = 1.5  # a ghost's mean density is at least this many times the uniform one


@dataclass(frozen=True)
class SlowZone:
    """A stretch of the circle where a path lingers.

    centre : radians in [0, 2π): the stable fixed point, the attracting jump, or the ghost's slowest point.
    arc : (start, end), radians, start < end: the zone, see ``predict_staircase``.
    kind : "stable", "jump" or "ghost".
    residence_cycles : mean number of cycles in the arc from the centre ("stable", "jump") or from the upstream
        end ("ghost") until the path first leaves it.
    winding : whole turns that a cycle makes there; the zone is still in the frame that turns along.
    visits_a_cycle, visit_cycles, visit_spread, upward : the visits of the stationary path, or None where they were
        not computed. A visit is a maximal run of cycles in the arc that reaches ``core``: how many begin per
        cycle, their mean length and its standard deviation (cycles), the share that ends above the arc.
    """

    centre: float
    arc: tuple[float, float]
    kind: str
    residence_cycles: Estimate
    winding: int = 0
    visits_a_cycle: float | None = None
    visit_cycles: float | None = None
    visit_spread: float | None = None
    upward: float | None = None

    @property
    def whole_turn(self) -> bool:
        """Whether the arc is a whole turn: the path then leaves it on the lifted line only."""
        return self.arc[1] - self.arc[0] > TWO_PI - 1e-9

    @property
    def middle(self) -> float:
        """The centre's representative inside the arc, radians."""
        return self.arc[0] + float(np.mod(self.centre - self.arc[0], TWO_PI))

    @property
    def core(self) -> tuple[float, float]:
        """The part of the arc that is at most half as far from the centre as the arc's end on that side."""
        low, high = self.arc
        return self.middle - _CORE * (self.middle - low), self.middle + _CORE * (high - self.middle)


@dataclass(frozen=True)
class StaircaseSummary:
    """What theory says of a staircase; see ``predict_staircase`` for the definitions.

    mean_turn : radians a cycle. mean_residence_cycles : cycles, or None without slow zones; inf above 1e300.
    step : radians, or None without slow zones. zones : the slow zones, sorted by centre.
    net_step : mean climb from one visit to the next, radians, or None where the visits were not computed.
    """

    mean_turn: float
    mean_residence_cycles: float | None
    step: float | None
    zones: tuple[SlowZone, ...]
    net_step: float | None = None

    @property
    def cycles_a_step(self) -> float | None:
        """Cycles in which the path climbs ``step`` on average, 0 or more; None without slow zones."""
        pace = abs(self.mean_turn - TWO_PI * (self.zones[0].winding if self.zones else 0))
        if self.step is None:
            return None
        return self.step / pace if pace > 0.0 else float("inf")


def predict_staircase(
    circle_map: CircleMap, noise: Noise, operator: TransferOperator | None = None
) -> StaircaseSummary:
    """Mean turn, step height and residence of the staircase that the noisy map will draw.

    mean_turn : 2π times the operator's rotation number, an ``Estimate`` with its bound.
    Slow zones : the stable fixed points and attracting jumps. Around each the zone is the arc between the
        unstable points (or repelling jumps, or saddle-nodes) next to it on both sides; its residence is
        the mean passage time from the point out of that arc. With a single unstable point the arc is the
        whole turn between two copies of it, and the path leaves it on the lifted line.
        Where nothing is stable: the ghosts, the connected arcs on which |F(θ) - θ - 2πw| is below half its mean
        over the circle (uniform weight), w the whole number that makes the mean turn least, if the stationary
        path is there at least half as long again as in an arc of that length at an even pace. The residence
        is the mean passage time out of the arc from its upstream end.
    mean_residence_cycles : average of the zones' residences, an ``Estimate`` whose bound is the average bound.
    step : 2π divided by the number of zones, the mean spacing of neighbouring slow zones.
    net_step : mean_turn (less 2πw) over the number of visits that begin per cycle in all zones together, exact for
        the stationary path by the ergodic theorem. Equal to ``step`` when every climb stops once in every zone;
        smaller where a path falls back (into the zone it left, or a step down), larger where it misses zones.
    The visits' numbers are exact for the stationary path; how they are found is said at ``_with_visits``.
    A turn that is constant to 1e-9 rad has no slow zone: all but mean_turn are None.

    ``operator`` may pass a ``transfer_operator(circle_map, noise)`` that is already there.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> found = predict_staircase(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05))
    >>> [zone.kind for zone in found.zones], round(found.step, 6)
    (['ghost'], 6.283185)
    """
    known = transfer_operator(circle_map, noise) if operator is None else operator
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: a staircase needs degree 1")
    mean_turn = Estimate(TWO_PI * known.rotation_number, TWO_PI * known.rotation_number.error_bound)
    grid = TWO_PI * np.arange(_GRID) / _GRID
    turn = circle_map.turn(grid)
    if np.ptp(turn) <= _FLAT:
        return StaircaseSummary(mean_turn, None, None, ())
    found = _stable_zones(circle_map, noise)
    if not found:
        found = [ghost for ghost in _ghosts(circle_map, noise, grid, turn) if _lingers(known, ghost.arc)]
    if not found:
        return StaircaseSummary(mean_turn, None, None, ())
    zones = tuple(_with_visits(zone, circle_map, noise, known) for zone in found)
    residences = [zone.residence_cycles for zone in zones]
    mean = float(np.mean(residences))
    bound = float(np.mean([one.error_bound for one in residences])) if np.isfinite(mean) else 0.0
    climb = mean_turn - TWO_PI * zones[0].winding
    return StaircaseSummary(mean_turn, Estimate(mean, bound), TWO_PI / len(zones), zones, _net_step(climb, zones))


def _lingers(operator: TransferOperator, arc: tuple[float, float]) -> bool:
    inside = arc[0] + (arc[1] - arc[0]) * (np.arange(_INSIDE) + 0.5) / _INSIDE
    return bool(TWO_PI * np.mean(operator.density(inside)) >= _LINGERING)


def _net_step(climb: float, zones: tuple[SlowZone, ...]) -> float | None:
    rates = [zone.visits_a_cycle for zone in zones if zone.visits_a_cycle is not None]
    if len(rates) < len(zones) or sum(rates) <= 0.0 or len({zone.winding for zone in zones}) > 1:
        return None
    return climb / float(sum(rates))


# -- zones round what attracts -------------------------------------------------------------------------------


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
    still = shifted(circle_map, -winding)
    residence = mean_passage_time(still, noise, centre, arc, lifted=whole)
    return SlowZone(centre, arc, kind, residence, winding)


# -- ghosts ----------------------------------------------------------------------------------------------------


def _ghosts(circle_map: CircleMap, noise: Noise, grid: Array, turn: Array) -> list[SlowZone]:
    winding = round(float(np.mean(turn)) / TWO_PI)
    still, turn = shifted(circle_map, -winding), turn - TWO_PI * winding
    slowness = np.abs(turn)
    level = 0.5 * float(np.mean(slowness))
    slow = slowness < level
    if not np.any(slow) or np.all(slow):
        return []
    enters = np.flatnonzero(slow & ~np.roll(slow, 1))
    zones = [_ghost(still, noise, grid, turn, level, int(i)) for i in enters]
    return sorted((replace(zone, winding=winding) for zone in zones), key=lambda zone: zone.centre)


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


# -- visits of the stationary path -----------------------------------------------------------------------------


def _with_visits(zone: SlowZone, circle_map: CircleMap, noise: Noise, operator: TransferOperator) -> SlowZone:
    """The zone with its visits by the stationary path.

    π the stationary density, B the arc, K the noisy map's kernel between points of B on the lifted line, ν = π - πK
    the law of run starts: moments of a run are ν·(I - K)⁻¹1 and the like, less those of runs that never reach the
    core (renewal theory: Kemeny & Snell 1960, ch. 3). The bound of the length is measured, from coarser nodes. A
    residence beyond 1e5 cycles is put in its place, and in the spread's, as is right for rare escapes (exponential
    law), with a bound of inf: the difference, a few relaxation times, is not computed.
    """
    residence, still = float(zone.residence_cycles), shifted(circle_map, -zone.winding)
    if residence > _LONGEST_VISIT:
        bound = np.inf if np.isfinite(residence) else 0.0
        return replace(zone, visit_cycles=Estimate(residence, bound), visit_spread=residence)
    fine = _visit_moments(zone, still, noise, operator, _FINE)
    coarse = _visit_moments(zone, still, noise, operator, _COARSE) if fine is not None else None
    if coarse is None or fine is None:
        return zone
    rate, mean, square, up = fine
    length = Estimate(mean, abs(mean - coarse[1]) + 1e-9 * mean)
    spread = float(np.sqrt(max(square - mean**2, 0.0)))
    return replace(zone, visits_a_cycle=rate, visit_cycles=length, visit_spread=spread, upward=up)


def _visit_moments(
    zone: SlowZone, circle_map: CircleMap, noise: Noise, operator: TransferOperator, neglected: float
) -> tuple[float, float, float, float] | None:
    """Visits begun per cycle, E length, E length², share that ends above; None where it takes too many nodes."""
    bandwidth = 4.0
    while noise.tail(int(bandwidth)) > neglected and bandwidth <= _MAX_BANDWIDTH:
        bandwidth *= 1.1
    edges = (zone.arc[0], *zone.core, zone.arc[1])
    rules = [arc_rule(circle_map, low, high, bandwidth, every_sample=False) for low, high in pairwise(edges)]
    theta, weight = (np.concatenate(part) for part in zip(*rules, strict=True))
    if bandwidth > _MAX_BANDWIDTH or theta.size > _MAX_NODES:
        return None
    image = circle_map(theta)
    kernel = noise.line_density(theta - image[:, None])
    stationary = operator.density(theta) * weight
    starts = stationary - weight * (stationary @ kernel)
    above = noise.exceedance(zone.arc[1] - image)
    out = above + noise.exceedance(image - zone.arc[0])
    ring = (theta < zone.core[0]) | (theta > zone.core[1])
    missed = _run_moments((kernel * weight)[np.ix_(ring, ring)], out[ring], above[ring])
    whole = _run_moments(kernel * weight, out, above)
    rate = float(np.sum(starts) - starts[ring] @ missed[0])
    length, square, up = (float(starts @ w - starts[ring] @ m) for w, m in zip(whole[1:], missed[1:], strict=True))
    return (rate, length / rate, square / rate, up / rate) if rate > 0.0 else None


def _run_moments(kernel: Array, out: Array, above: Array) -> tuple[Array, Array, Array, Array]:
    """From each node: the chance to leave by ``out``, and E length, E length² and the chance of above on that event."""
    factors = lu_factor(np.eye(out.size) - kernel)
    chance, up = lu_solve(factors, np.stack([out, above], axis=1)).T
    length = lu_solve(factors, chance)
    square = lu_solve(factors, chance + 2.0 * (kernel @ length))
    return chance, length, square, up
