"""How well a loop's stable directions are known: intervals, and how often it locks in, over its
material's posterior.

Each sample of the posterior is a surface with a cycle map of its own. To first order that map is
f_k(θ) = f(θ) + ∂f/∂p(θ) (p_k - p), with the exact derivatives of the cycle; near a saddle-node, or
where the way an object turns is about to flip, maps are not linear in p. So some samples, the most
telling of them, are run in full; where those lie where the first order says, it is used, else every
sample is run.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array, even_angles, evenly_spread, shorter_way
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.mechanics.engine.parts import SHARES
from cyclemap.mechanics.engine.schema import OF_PRESSURE, PARAMETERS
from cyclemap.mechanics.foundation import FLAT
from cyclemap.mechanics.friction import centre_and_shape
from cyclemap.progress import Progress, unheard
from cyclemap.written import ANGLE, DIRECTION

FIRST_ORDER = "first order"
SAMPLES = "samples"
LEVEL = 0.95
# Samples between whose ends a further one lies in 95 % of cases.
_FEWEST = 39
# The axes' ratio of a material without posterior is varied by this share to tell how much depends
# on it.
VARIED = 0.10
# Nodes of every map, and places of each cell at which its cubic is looked at.
_NODES = 48
_INSIDE = 16
# Samples run in full to judge the first order; what it may be off by: a share of the interval's
# width, at least rad.
_JUDGES = 6
_SHARE = 0.04
_LEAST = math.radians(0.05)
# Samples of the mechanics: accuracy of a cycle, and error of the map where it nears a fixed point,
# rad.
_ACCURACY = 1e-6
_MAP_ERROR = 3e-5
# No cell is halved more often: it may hold a jump.
_HALVINGS = 8
# Stable points farther from each other than this, rad, are not the same direction, where the stated
# numbers have none.
_APART = math.radians(40.0)


@dataclass(frozen=True)
class DirectionInterval:
    """One stable direction, over the materials that the data allow.

    Attributes
    ----------
    theta : float or None
        That of the stated numbers, rad; None where they have none here.
    lower, upper : float
        Bounds of 95 % of the samples that have the direction, rad, lower in [0, 2π) and upper
        not before it; of fewer than 39 their ends (see `DirectionUncertainty.has_interval`).
    share : float
        Share of the samples that have it, 0 to 1.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, direction_uncertainty
    >>> found = direction_uncertainty(CollectionLoop.mit("plywood"))
    >>> (direction,) = found.directions
    >>> direction.lower < direction.theta < direction.upper, direction.share
    (True, 1.0)
    """

    theta: float | None = field(metadata=DIRECTION)
    lower: float = field(metadata=ANGLE)
    upper: float = field(metadata=ANGLE)
    share: float


@dataclass(frozen=True)
class DirectionUncertainty:
    """How well stable directions are known.

    Attributes
    ----------
    source : str
        `posterior`, or `axis ratio` where the material has none: then the two `samples` are its
        axes' ratio 10 % smaller and larger, `lower` and `upper` their span with the stated one,
        and nothing here is a probability.
    method : str
        `first order` or `samples`.
    samples : int
        How many samples.
    locks : int
        How many of them have a stable direction.
    directions : tuple of DirectionInterval
        The directions, those of the stated numbers and others that samples have.
    first_order_error : float or None
        The farthest that a direction of a sample run in full lay from its first order, rad; inf
        where the first order has another number of directions, None where it was not tried.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, direction_uncertainty
    >>> found = direction_uncertainty(CollectionLoop.mit("plywood"))
    >>> found.is_posterior, found.chance, found.samples
    (False, 1.0, 2)
    """

    source: str
    method: str
    samples: int
    locks: int = field(metadata={"name": "samples_that_lock"})
    directions: tuple[DirectionInterval, ...]
    first_order_error: float | None = field(default=None, metadata=ANGLE)

    @property
    def is_posterior(self) -> bool:
        """Whether the material's posterior was at hand."""
        return self.source == "posterior"

    @property
    def chance(self) -> float:
        """Share of the samples that lock in at all."""
        return self.locks / self.samples

    def has_interval(self, direction: DirectionInterval) -> bool:
        """Whether so many samples have a direction that 95 % can lie between two of them: 39."""
        return round(direction.share * self.samples) >= _FEWEST

    def of(self, theta: float) -> DirectionInterval | None:
        """Return the interval of the stated numbers' stable direction `theta`, rad; None where
        there is none.
        """
        near = [
            direction
            for direction in self.directions
            if direction.theta is not None and abs(shorter_way(direction.theta - theta)) < 0.01
        ]
        return near[0] if near else None


def direction_uncertainty(
    loop: CollectionLoop, progress: Progress | None = None
) -> DirectionUncertainty:
    """Return how well the stable directions of a loop are known from its material's posterior.

    Parameters
    ----------
    loop : CollectionLoop
        Whose directions; its material may hold a posterior.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    DirectionUncertainty
        An interval for each direction.

    Raises
    ------
    InvalidInput
        For a loop that is none.

    Notes
    -----
    95 % intervals of samples alike likely (Hyndman & Fan 1996, type 6: a further sample lies inside
    in 95 % of cases). A direction is a stable fixed point of the cycle map; places where orbits
    gather about a jump are not among them.

    References
    ----------
    Hyndman, R. J. & Fan, Y. (1996), Sample quantiles in statistical packages, The American
    Statistician 50(4).

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, direction_uncertainty
    >>> found = direction_uncertainty(CollectionLoop.mit("plywood"))
    >>> found.source, found.locks, [round(math.degrees(row.theta)) for row in found.directions]
    ('axis ratio', 2, [63])
    """
    report = progress or unheard
    stated = replace(require_loop(loop), accuracy=max(loop.accuracy, _ACCURACY))
    if loop.material.posterior is None:
        return _of_axis_ratio(stated, report)
    samples = map(loop.material.sample, range(len(loop.material.posterior)))
    loops = [on_material(stated, sample) for sample in samples]
    nominal = stable_points([stated])[0]
    linear = _first_order(stated, loops)
    telling, extreme = _judges(linear)
    judges = [*telling, *extreme]
    full = dict(zip(judges, stable_points([loops[index] for index in judges]), strict=True))
    report(0.3)
    intervals = _intervals(nominal, linear)
    # The farthest that a direction lies from the first order's.
    off = [
        shorter_way(linear[index][:, None] - full[index]) for index in telling if linear[index].size
    ]
    error = math.inf
    if all(linear[index].size == full[index].size for index in judges):
        error = max((float(np.abs(away).min(axis=1).max()) for away in off), default=0.0)
    widths = [interval.upper - interval.lower for interval in intervals]
    method = FIRST_ORDER
    if error > max(_LEAST, _SHARE * min(widths, default=0.0)):
        rest = [index for index in range(len(loops)) if index not in full]
        ran = stable_points([loops[index] for index in rest], lambda done: report(0.3 + 0.7 * done))
        full.update(zip(rest, ran, strict=True))
        linear = [full[index] for index in range(len(loops))]
        method = SAMPLES
        intervals = _intervals(nominal, linear)
    report(1.0)
    locks = sum(points.size > 0 for points in linear)
    return DirectionUncertainty("posterior", method, len(loops), locks, intervals, error)


def _of_axis_ratio(stated: CollectionLoop, report: Progress) -> DirectionUncertainty:
    """What the ratio of the axes does to the directions, where nothing is known of it."""
    law = stated.material.friction
    loops = [stated]
    less = 1.0 / (1.0 + VARIED)
    mean = math.sqrt(less)
    # Less friction in all moves nothing, where more may be that of no surface.
    for along, across in ((less, 1.0), (1.0, less)):
        axes = {"mu_a": along * law.mu_a, "mu_b": across * law.mu_b}
        # Far off the centre one of the two, never both, leaves zero outside the ellipse.
        with suppress(InvalidInput):
            friction = replace(law, **axes, m0=mean * law.m0, n0=mean * law.n0)
            material = replace(stated.material, friction=friction, wear=None)
            loops.append(replace(stated, material=material))
    nominal, *varied = stable_points(loops, report)
    locks = sum(points.size > 0 for points in varied)
    intervals = _intervals(nominal, varied, span=True)
    return DirectionUncertainty("axis ratio", SAMPLES, len(varied), locks, intervals)


def _first_order(loop: CollectionLoop, loops: Sequence[CollectionLoop]) -> list[Array]:
    """The stable points of each loop's map to first order about that of `loop`."""
    theta = even_angles(_NODES)
    batch = run_batch((loop,), theta[None], len(PARAMETERS))
    by = dict(zip(PARAMETERS, batch.jacobian[0, :, -1].T, strict=True))
    law = loop.material.friction
    # By the shape matrix of the ellipse instead of axes and angle, of which the latter is singular
    # at a circle.
    round_law = law.mu_a**2 - law.mu_b**2
    turned = by["phi"] - by["n0"] * law.m0 + by["m0"] * law.n0
    by_shape = [by["m0"], by["n0"], by["mu_a"] / (2.0 * law.mu_a), by["mu_b"] / (2.0 * law.mu_b)]
    by_shape += [turned / round_law if round_law else np.zeros(_NODES)]
    others = ("pusher_friction", "hitch_x", "hitch_y", *OF_PRESSURE)
    columns = np.array(
        [*by_shape, *(np.nan_to_num(by[name]) for name in (*others, "pin_friction_radius"))]
    )
    change = np.array([_coordinates(sample, law.phi) for sample in loops]) - _coordinates(
        loop, law.phi
    )
    # Slopes by the map's own derivative, and of the change by that of its Fourier series.
    waves = 1j * np.fft.rfftfreq(_NODES, 1.0 / _NODES)
    waves[-1] = 0.0
    slopes = np.fft.irfft(waves * np.fft.rfft(columns, axis=1), _NODES, axis=1)
    turn = batch.theta_next[0] - theta + change @ columns
    slope = batch.jacobian[0, :, -1, 0] - 1.0 + change @ slopes
    owners = np.repeat(np.arange(len(loops)), _NODES)
    return _roots(owners, _cells(turn, slope), len(loops))


def _coordinates(loop: CollectionLoop, phi: float) -> Array:
    """What a posterior may change of a loop: centre and shape of the ellipse in axes at `phi`, rod,
    ring, pressure.
    """
    centre, shape = centre_and_shape(loop.material.friction, phi)
    pressure = loop.model.pressure
    shares = [getattr(pressure, name, 0.0) for name in SHARES]
    bends = [getattr(pressure, name, FLAT).bend for name in ("floor", "plate")]
    ellipse = [*centre, shape[0, 0], shape[1, 1], shape[0, 1]]
    rod = [loop.pusher.friction, *loop.slider.hitch]
    pin = loop.reset.pin_friction_radius
    return np.concatenate([ellipse, rod, shares, *bends, [pin]])


def _judges(points: Sequence[Array]) -> tuple[list[int], list[int]]:
    """Samples whose directions are judged, from end to end of the interval; and extremes, of which
    only the number.
    """
    some = [index for index, directions in enumerate(points) if directions.size]
    none = [index for index, directions in enumerate(points) if not directions.size]
    if not some:
        return sorted(none[index] for index in evenly_spread(len(none), _JUDGES)), []
    middle = np.angle(np.exp(1j * np.concatenate([points[index] for index in some])).sum())
    order = np.argsort([shorter_way(points[index] - middle)[0] for index in some])
    ends = 0.5 * (1.0 - LEVEL) + LEVEL * np.linspace(0.0, 1.0, _JUDGES)
    ranks = (ends * (len(some) - 1)).round().astype(int)
    telling = {some[order[rank]] for rank in ranks.tolist()}
    return sorted(telling), sorted(
        {some[order[0]], some[order[-1]], *none[:1], *none[-1:]} - telling
    )


def stable_points(
    loops: Sequence[CollectionLoop],
    report: Progress | None = None,
    map_error: float = _MAP_ERROR,
    halvings: int = _HALVINGS,
) -> list[Array]:
    """The stable fixed points of each loop's map, rad in [0, 2π), of maps good to 0.002 degrees,
    0.02 beside a kink.

    map_error, halvings : of finer maps, rad, and how often a cell may be halved for them.
    """
    theta = np.tile(even_angles(_NODES // 2), (len(loops), 1))
    batch = run_batch(loops, theta, 1)
    cells = _cells(batch.theta_next - theta, batch.jacobian[:, :, -1, 0] - 1.0)
    owners = np.repeat(np.arange(len(loops)), theta.shape[1])
    done = []
    owner = []
    for halving in range(halvings):
        start, width, first, last, rise, fall = cells.T
        half = 0.5 * width
        middle = start + half
        batch = run_batch([loops[index] for index in owners.tolist()], middle[:, None], 1)
        turn = batch.theta_next[:, 0] - middle
        slope = batch.jacobian[:, 0, -1, 0] - 1.0
        error = np.abs(turn - _cubic(cells, np.array([0.5]))[:, 0])
        left = np.stack([start, half, first, turn, rise, slope], -1)
        right = np.stack([middle, half, turn, last, slope, fall], -1)
        halves = np.concatenate([left, right])
        # A half is a sixteenth as far off as the whole where the map is smooth; at a kink by luck
        # less.
        parents, error = (np.concatenate([values, values]) for values in (owners, error))
        nearest = np.abs(_offset(halves)).min(axis=1)
        is_open = (error > 4.0 * map_error) & (nearest < 2.0 * error + map_error)
        done.append(halves[~is_open])
        owner.append(parents[~is_open])
        cells = halves[is_open]
        owners = parents[is_open]
        if report is not None:
            report((halving + 1) / halvings)
        if not owners.size:
            break
    return _roots(np.concatenate([*owner, owners]), np.concatenate([*done, cells]), len(loops))


def _cells(turn: Array, slope: Array) -> Array:
    """Cells (k n, 6: start, width, turns and slopes of turn at both ends) of k maps from turns and
    slopes (k, n) at nodes evenly all around.
    """
    count = turn.shape[1]
    start = even_angles(count)
    ends = (turn, np.roll(turn, -1, 1), slope, np.roll(slope, -1, 1))
    return np.stack(np.broadcast_arrays(start, TWO_PI / count, *ends), -1).reshape(-1, 6)


def _cubic(cells: Array, share: Array) -> Array:
    """Turns (n, k) of cells (n, 6) at shares (k,) of the width."""
    h00 = (1.0 + 2.0 * share) * (1.0 - share) ** 2
    h01 = share**2 * (3.0 - 2.0 * share)
    h10 = share * (1.0 - share) ** 2
    h11 = share**2 * (share - 1.0)
    _, width, first, last, rise, fall = cells.T
    return np.stack([first, last, width * rise, width * fall], -1) @ [h00, h01, h10, h11]


def _cubic_slope(cells: Array, share: Array) -> Array:
    """Slopes of the turn (n,) of cells (n, 6), each at a share (n,) of its width."""
    _, width, first, last, rise, fall = cells.T
    chord = 6.0 * share * (1.0 - share) * (last - first) / width
    ends = (1.0 - share) * (1.0 - 3.0 * share) * rise + share * (3.0 * share - 2.0) * fall
    return np.asarray(chord + ends)


def _offset(cells: Array) -> Array:
    """Turns (n, k) of cells at evenly spread shares of the width, counted from the whole turn
    nearest to each cell.
    """
    turn = _cubic(cells, np.linspace(0.0, 1.0, _INSIDE + 1))
    return turn - TWO_PI * np.round(turn[:, [_INSIDE // 2]] / TWO_PI)


def _roots(owners: NDArray[np.intp], cells: Array, count: int) -> list[Array]:
    """The stable fixed points of each of `count` maps, whose cells have its number."""
    turn = _offset(cells)
    cell, place = np.nonzero((turn[:, :-1] > 0.0) & (turn[:, 1:] <= 0.0))
    high = turn[cell, place]
    low = turn[cell, place + 1]
    share = (place + high / (high - low)) / _INSIDE
    theta = cells[cell, 0] + cells[cell, 1] * share
    # Of a stable point the map's slope 1 + d turn / dθ is above -1.
    stable = _cubic_slope(cells[cell], share) > -2.0
    points: list[Array] = [
        np.sort(np.mod(theta[stable & (owners[cell] == index)], TWO_PI)) for index in range(count)
    ]
    return points


def _intervals(
    nominal: Array, points: Sequence[Array], span: bool = False
) -> tuple[DirectionInterval, ...]:
    """The interval of each stable direction of the stated numbers, else of each cluster of the
    samples'.
    """
    every = np.concatenate([np.zeros(0), *points])
    centres = nominal if nominal.size else clusters(every)
    intervals = []
    for index, centre in enumerate(centres):
        away = []
        for some in points:
            if not some.size:
                continue
            nearest = np.argmin(np.abs(shorter_way(some[:, None] - centres)), axis=1)
            own = shorter_way(some[nearest == index] - centre)
            if own.size:
                away.append(own[np.argmin(np.abs(own))])
        offsets = np.array([*away, 0.0] if span and nominal.size else away or [0.0])
        ends = (0.0, 1.0) if span else (0.5 * (1.0 - LEVEL), 0.5 * (1.0 + LEVEL))
        low, high = np.quantile(offsets, ends, method="linear" if span else "weibull")
        lower = float((centre + low) % TWO_PI)
        theta = float(centre) if nominal.size else None
        intervals.append(
            DirectionInterval(theta, lower, lower + float(high - low), len(away) / len(points))
        )
    return tuple(intervals)


def clusters(points: Array, apart: float = _APART) -> Array:
    """Return the centres of points of the circle (n,), rad in [0, 2π), that gaps (rad) part, of 40
    degrees where nothing else is said.
    """
    if not points.size:
        return points
    order = np.sort(points)
    gaps = np.diff(order, append=order[0] + TWO_PI)
    order = np.roll(order, -1 - int(np.argmax(gaps)))
    cuts = np.flatnonzero(np.mod(np.diff(order), TWO_PI) > apart) + 1
    return np.array(
        [np.angle(np.exp(1j * group).mean()) % TWO_PI for group in np.split(order, cuts)]
    )
