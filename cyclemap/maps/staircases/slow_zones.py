"""Slow zones: where a noisy path lingers, how long, and the staircase that follows."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from cyclemap.arrays import TWO_PI, Array, even_angles, stretches
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one
from cyclemap.maps.lifts.map_algebra import shifted
from cyclemap.maps.noise import Noise
from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
from cyclemap.maps.orbits.periodic_points import crossings_by_jump, fixed_points
from cyclemap.maps.passages.killed_chain import Passage, killed_chain
from cyclemap.maps.passages.passage_times import mean_passage_time
from cyclemap.one_thread import one_thread
from cyclemap.written import ANGLE, DIRECTION, UNWRITTEN

_GRID = 4_096
_INSIDE = 257  # angles at which the density in a ghost's arc is averaged
_FLAT = 1e-9  # radians: a turn that varies by less has no slow zone
_CORE = 0.5  # a visit must come this much nearer the centre than the arc's ends are
_STRETCH = 1.4  # bandwidth of the nodes of the visits' law over that of its check
_MAX_NODES = 2_000
_LONGEST_VISIT = (
    1e5  # cycles: beyond, visits are taken to be exponential, with the residence as mean
)
_LINGERING = 1.5  # a ghost's mean density is at least this many times the uniform one


@dataclass(frozen=True)
class SlowZone:
    """A stretch of the circle where a path lingers.

    Attributes
    ----------
    centre : float
        Radians in [0, 2π): the stable fixed point, the attracting jump, or the ghost's slowest
        point.
    arc : tuple[float, float]
        (start, end), radians, start < end: the zone, see ``predict_staircase``.
    kind : str
        "stable", "jump" or "ghost".
    residence_cycles : Estimate
        Mean number of cycles in the arc from the centre ("stable", "jump") or from the upstream
        end ("ghost") until the path first leaves it.
    winding : int
        Whole turns that a cycle makes there; the zone is still in the frame that turns along.
    visits_a_cycle, visit_cycles, visit_spread : float or None
        The visits of the stationary path, maximal runs of cycles in the arc that reach
        ``core``: how many begin per cycle, their mean length and its standard deviation,
        cycles; None where not computed.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, predict_staircase
    >>> (zone,) = predict_staircase(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3)).zones
    >>> zone.kind, round(zone.centre, 4), zone.whole_turn
    ('stable', 0.7728, True)
    """

    centre: float = field(metadata=DIRECTION)
    arc: tuple[float, float] = field(metadata=ANGLE)
    kind: str
    residence_cycles: Estimate
    winding: int = field(default=0, metadata=UNWRITTEN)
    visits_a_cycle: float | None = field(default=None, metadata=UNWRITTEN)
    visit_cycles: float | None = field(default=None, metadata=UNWRITTEN)
    visit_spread: float | None = field(default=None, metadata=UNWRITTEN)

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
        """The part of the arc that is at most half as far from the centre as the arc's end on that
        side.
        """
        low, high = self.arc
        return self.middle - _CORE * (self.middle - low), self.middle + _CORE * (high - self.middle)


@dataclass(frozen=True)
class StaircaseSummary:
    """What theory says of a staircase; see ``predict_staircase`` for the definitions.

    Attributes
    ----------
    mean_turn : float
        Radians a cycle.
    mean_residence_cycles : float or None
        Cycles, or None without slow zones; inf above 1e300.
    step : float or None
        Radians, or None without slow zones.
    zones : tuple of SlowZone
        The slow zones, sorted by centre.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, predict_staircase
    >>> found = predict_staircase(CircleMap.rigid(0.1), WrappedNormal(0.3))
    >>> round(found.mean_turn, 6), found.step, found.zones
    (0.628319, None, ())
    """

    mean_turn: float = field(metadata=ANGLE)
    mean_residence_cycles: float | None
    step: float | None = field(metadata=ANGLE)
    zones: tuple[SlowZone, ...]

    @property
    def cycles_a_step(self) -> float | None:
        """Cycles in which the path climbs ``step`` on average, 0 or more;
        None without slow zones."""
        pace = abs(self.mean_turn - TWO_PI * (self.zones[0].winding if self.zones else 0))
        if self.step is None:
            return None
        return self.step / pace if pace > 0.0 else float("inf")


@one_thread
def predict_staircase(
    circle_map: CircleMap, noise: Noise, operator: TransferOperator | None = None
) -> StaircaseSummary:
    """Mean turn, step height and residence of the staircase that a noisy map will draw.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise
        ξ, added after it.
    operator : TransferOperator or None, optional
        A ``transfer_operator(circle_map, noise)`` that is already there; None: made here.

    Returns
    -------
    StaircaseSummary
        The slow zones, and what they make of the path.

    Notes
    -----
    - ``mean_turn``: 2π times the operator's rotation number, an ``Estimate`` with its bound.
    - Slow zones: the stable fixed points and attracting jumps, each with the arc between the
      unstable points (or repelling jumps, or saddle-nodes) next to it on both sides; its residence
      is the mean passage time from the point out of that arc. With a single unstable point the arc
      is the whole turn between two copies of it, left on the lifted line only. Where nothing is
      stable: the ghosts, the connected arcs on which |F(θ) - θ - 2πw| is below half its mean over
      the circle, w the whole number that makes the mean turn least, if the stationary path is there
      at least half as long again as at an even pace. The residence is the mean passage time from
      the arc's upstream end.
    - ``mean_residence_cycles``: average of the zones' residences, an ``Estimate`` whose bound is
      the average bound.
    - ``step``: 2π divided by the number of zones, the mean spacing of neighbouring slow zones.

    The visits' numbers are exact for the stationary path; how they are found is said at
    ``_with_visits``. A turn that is constant to 1e-9 rad has no slow zone: all but ``mean_turn``
    are None.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, predict_staircase
    >>> found = predict_staircase(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05))
    >>> [zone.kind for zone in found.zones], round(found.step, 6)
    (['ghost'], 6.283185)
    """
    known = transfer_operator(circle_map, noise) if operator is None else operator
    if getattr(known, "map", None) is not circle_map or known.noise != noise:
        raise InvalidInput(
            f"operator is {operator!r}, which is not that of this map and noise: leave it out, or "
            "give transfer_operator(circle_map, noise)"
        )
    require_degree_one(circle_map, "a staircase")
    mean_turn = Estimate(TWO_PI * known.rotation_number, TWO_PI * known.rotation_number.error_bound)
    turn = circle_map.turn(even_angles(_GRID))
    zones = []
    if np.ptp(turn) > _FLAT:
        zones = _stable_zones(circle_map, noise) or _ghosts(circle_map, noise, known, turn)
    if not zones:
        return StaircaseSummary(mean_turn, None, None, ())
    residences = [zone.residence_cycles for zone in zones]
    mean = float(np.mean(residences))
    bound = float(np.mean([residence.error_bound for residence in residences]))
    return StaircaseSummary(
        mean_turn,
        Estimate(mean, bound if np.isfinite(mean) else 0.0),
        TWO_PI / len(zones),
        tuple(_with_visits(zone, circle_map, noise, known) for zone in zones),
    )


def _stable_zones(circle_map: CircleMap, noise: Noise) -> list[SlowZone]:
    points = fixed_points(circle_map)
    jumps = crossings_by_jump(circle_map)
    centres = [(float(p.points[0]), p.winding, "stable") for p in points if p.stable]
    centres += [(j.theta, j.winding, "jump") for j in jumps if j.attracting]
    parting = [float(p.points[0]) for p in points if p.kind in ("unstable", "saddle-node")]
    edges = np.array(parting + [j.theta for j in jumps if not j.attracting])
    zones = []
    for centre, winding, kind in sorted(centres) if edges.size else []:
        above = centre + float(np.min(np.mod(edges - centre, TWO_PI)))
        below = centre - float(np.min(np.mod(centre - edges, TWO_PI)))
        whole = above - below > TWO_PI - 1e-9
        arc = (above - TWO_PI, above) if whole else (below, above)
        residence = mean_passage_time(
            shifted(circle_map, -winding), noise, centre, arc, lifted=whole
        )
        zones.append(SlowZone(centre, arc, kind, residence, winding))
    return zones


def _ghosts(
    circle_map: CircleMap, noise: Noise, operator: TransferOperator, turn: Array
) -> list[SlowZone]:
    """The slow arcs where the path lingers; ``turn`` is F(θ) - θ on an even grid."""
    winding = round(float(np.mean(turn)) / TWO_PI)
    still = shifted(circle_map, -winding)
    turn = turn - TWO_PI * winding
    level = 0.5 * float(np.mean(np.abs(turn)))
    # The grid begins where the map is not slow: no stretch goes round its end.
    begin = int(np.argmax(np.abs(turn)))
    turn = np.roll(turn, -begin)
    slowness = np.abs(turn)
    zones = []
    step = TWO_PI / _GRID
    share = (np.arange(_INSIDE) + 0.5) / _INSIDE
    for first, end in stretches(slowness < level):
        # The slow arc begins and ends where |turn| crosses the level.
        before, after = (
            float((level - slowness[inside]) / (slowness[outside] - slowness[inside]))
            for inside, outside in ((first, first - 1), (end - 1, end % _GRID))
        )
        start = step * ((begin + first) % _GRID)
        arc = start - step * before, start + step * (end - first - 1 + after)
        within = arc[0] + (arc[1] - arc[0]) * share
        if TWO_PI * np.mean(operator.density(within)) < _LINGERING:
            continue
        slowest = first + int(np.argmin(slowness[first:end]))
        residence = mean_passage_time(still, noise, arc[int(turn[slowest] < 0.0)], arc)
        centre = (start + step * (slowest - first)) % TWO_PI
        zones.append(SlowZone(centre, arc, "ghost", residence, winding))
    return sorted(zones, key=lambda zone: zone.centre)


def _with_visits(
    zone: SlowZone, circle_map: CircleMap, noise: Noise, operator: TransferOperator
) -> SlowZone:
    """The zone with its visits by the stationary path.

    π the stationary density, B the arc, K the noisy map's kernel on B, lifted, ν = π - πK the law
    of run starts: moments of a run are ν·(I - K)⁻¹1 and the like, less those of runs that never
    reach the core (renewal theory: Kemeny & Snell 1960, ch. 3). The length's bound is measured,
    from coarser nodes. Beyond 1e5 cycles visits are exponential with the residence as mean and
    spread, with a bound of inf: a few relaxation times are not computed.
    """
    residence = float(zone.residence_cycles)
    still = shifted(circle_map, -zone.winding)
    if residence > _LONGEST_VISIT:
        bound = np.inf if np.isfinite(residence) else 0.0
        return replace(zone, visit_cycles=Estimate(residence, bound), visit_spread=residence)
    fine = _visit_moments(zone, still, noise, operator, _STRETCH)
    coarse = fine and _visit_moments(zone, still, noise, operator, 1.0)
    if coarse is None or fine is None:
        return zone
    rate, mean, square = fine
    length = Estimate(mean, abs(mean - coarse[1]) + 1e-9 * mean)
    spread = float(np.sqrt(max(square - mean**2, 0.0)))
    return replace(zone, visits_a_cycle=rate, visit_cycles=length, visit_spread=spread)


def _visit_moments(
    zone: SlowZone,
    circle_map: CircleMap,
    noise: Noise,
    operator: TransferOperator,
    stretch: float,
) -> tuple[float, float, float] | None:
    """Visits begun per cycle, E length, E length²; None where it takes too many nodes, or the noise
    has a density that jumps.
    """
    out_of = Passage.out_of(circle_map, noise, zone.arc, lifted=True)
    # Panels of nodes end at the core.
    passage = replace(out_of, arcs=tuple(pairwise((zone.arc[0], *zone.core, zone.arc[1]))))
    try:
        chain = killed_chain(passage, every_sample=False, stretch=stretch, most=_MAX_NODES)
    except InvalidInput:
        return None
    theta = chain.theta
    moves = chain.transitions(chain.images)
    out = chain.departures(chain.images).sum(axis=0)
    stationary = operator.density(theta) * chain.weight
    starts = stationary - stationary @ moves
    ring = (theta < zone.core[0]) | (theta > zone.core[1])
    missed = _run_moments(moves[np.ix_(ring, ring)], out[ring])
    whole = _run_moments(moves, out)
    chance, length, square = (
        float(starts @ of_all - starts[ring] @ of_missed)
        for of_all, of_missed in zip(whole, missed, strict=True)
    )
    return (chance, length / chance, square / chance) if chance > 0.0 else None


def _run_moments(moves: Array, out: Array) -> tuple[Array, Array, Array]:
    """From each node: the chance to leave by ``out``, and E length and E length² on that event."""
    runs = np.linalg.inv(np.eye(out.size) - moves)
    chance = runs @ out
    length = runs @ chance
    return chance, length, runs @ (chance + 2.0 * (moves @ length))
