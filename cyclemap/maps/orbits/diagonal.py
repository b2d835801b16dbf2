"""Where an iterate crosses the diagonal: whole turns counted at cell ends, touches and breaks
settled; and slow passages, where it comes near without reaching it ("ghosts" of saddle-nodes).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole, shorter_way
from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import LIFT
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import differences, nearest_on_circle, within_turn
from cyclemap.maps.lifts.scan import (
    INSET,
    Cells,
    is_continuous,
    is_rising,
    iterate,
    monotone_cells,
    whole_turns,
)

TANGENCY = 1e-12  # radians: extrema and ends of jumps this near a whole turn touch it
# radians: cells with |Fⁿ - id - 2πw| below this at both ends may be arcs of periodic points
_IDENTITY = 1e-11
_FLAT = 1e-2  # radians: on a longer arc Fⁿ = id + 2πw to rounding is an arc of periodic points
# radians: how near an extremum the image of a touch must lie to be a touch of the same orbit
_MATE = 1e-4
LEAST_CYCLES = 10.0
REACH = 4.0  # widths on each side of the slowest point across which ``relative_error`` looks
_SHARE = 0.5  # of the mean |Fⁿ - id - 2πw|: a larger gap is no bottleneck
_GAUSS = 48
_FOLLOWED = 1_000.0  # iterates: longer passages are slow enough for the flow's series
_MOST_FOLLOWED = 4_000  # iterates: a path that is not across by then does not get through


@dataclass(frozen=True)
class JumpCrossing:
    """A jump of F across the diagonal: no fixed point, though orbits may gather or part there.

    Attributes
    ----------
    theta : float
        The break, radians.
    winding : int
        The w of the crossed line θ + 2πw.
    attracting : bool
        True when both sides move towards the break (a downward jump): it acts as an attractor.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, crossings_by_jump
    >>> saw = CircleMap(lambda x: x - 0.5 + np.mod(x, 2 * np.pi) / np.pi, None, [0.0])
    >>> [(crossing.theta, crossing.attracting) for crossing in crossings_by_jump(saw)]
    [(0.0, True)]
    """

    theta: float
    winding: int
    attracting: bool


@dataclass(frozen=True, eq=False)
class DiagonalScan:
    """Cells and their ends, with how many whole turns lie below g at each: what counts as crossing.

    Beside them the points that lie at a node within the tangency: ``touch`` (g meets a whole turn
    without crossing it), ``kink`` (a crossing on a kink) and ``border`` (g ends there at a jump),
    each a list of (θ, w).

    The ends are counted on round the circle: the start of cell 0, its end, the start of cell 1, ...

    joined : whether g is continuous at the start of each cell.
    theta, g, turns, tolerance : of each end; the last is how far from a whole turn it still counts
        as on it.
    """

    map: CircleMap
    cells: Cells
    joined: Mask
    theta: Array
    g: Array
    turns: Whole
    tolerance: Array
    touch: list[tuple[float, int]] = field(default_factory=list)
    kink: list[tuple[float, int]] = field(default_factory=list)
    border: list[tuple[float, int]] = field(default_factory=list)
    jumps: list[JumpCrossing] = field(default_factory=list)

    @property
    def lap(self) -> int:
        """By how many whole turns g climbs while θ runs round once."""
        return round(self.cells.climb / TWO_PI)

    def height(self, end: int) -> float:
        """g there."""
        laps, place = divmod(end, self.g.size)
        return float(self.g[place]) + self.cells.climb * laps

    def starts(self, end: int, which: Mask) -> bool:
        """Whether the end is the start of a cell of which that holds."""
        return end % 2 == 0 and bool(which[end // 2 % which.size])

    def point(self, end: int, turns: int) -> tuple[float, int]:
        """The angle of the end in [0, 2π), and ``turns`` as they are counted there."""
        laps, place = divmod(end, self.g.size)
        if place == self.g.size - 1:
            return 0.0, turns - self.lap * (laps + 1)
        return float(self.theta[place]), turns - self.lap * laps

    def reached(self, seed: int, step: int, turns: int) -> tuple[int, bool | None]:
        """The last end from ``seed`` this way that lies on so many whole turns, and whether g then
        lies above them; None at a jump.
        """
        end = seed
        for _ in range(self.g.size):
            if self.starts(max(end, end + step), ~self.joined):
                return end, None
            off = self.height(end + step) - TWO_PI * turns
            if abs(off) > self.tolerance[(end + step) % self.g.size]:
                return end, off > 0.0
            end += step
        return end, None

    def settled(self, seed: int) -> list[int]:
        """Judge the run of ends around ``seed`` that lie on the same whole turn as one point; list
        the run.
        """
        w = round(self.height(seed) / TWO_PI)
        low, below = self.reached(seed, -1, w)
        high, beyond = self.reached(seed, 1, w)
        run = range(low, high + 1)
        # Whether g lies above the line at the ends before and from the split.
        split = high + 1
        sides = (below, below)
        if below is None or beyond is None:
            sides = (bool(beyond), False) if below is None else (below, False)
            self.border.append(self.point(low if below is None else high, w))
        elif below == beyond:
            extremum = (min if below else max)(run, key=self.height)
            self.touch.append(self.point(extremum, w))
        else:
            sides = (below, beyond)
            kinks = [end for end in run[1:] if self.starts(end, self.cells.cut)]
            # On no kink the root is sought in the run's middle cell: where three roots merge, the
            # middle one.
            split = kinks[0] if kinks else (low + high + 1) // 2 | 1
            self.kink.extend(self.point(kink, w) for kink in kinks[:1])
        for end in run:
            laps, place = divmod(end, self.g.size)
            self.turns[place] = w - self.lap * laps - (0 if sides[end >= split] else 1)
        return [end % self.g.size for end in run]


def displacement(
    circle_map: CircleMap, theta: Array, period: int, winding: Whole
) -> tuple[Array, Array, Array]:
    """(Fⁿ(θ) - θ - 2πw, (Fⁿ)'(θ), a bound on the first one's rounding); whole turns are counted
    apart.

    The bound adds up ``LIFT``·(2π + |F|) an iterate, and one rounding of θ itself, through the
    slopes.
    """
    image = theta
    slope = np.ones_like(theta)
    turns = np.zeros(theta.shape, dtype=np.int64)
    rounding = 0.5 * np.spacing(np.abs(theta))
    for _ in range(period):
        steepness = circle_map.derivative(image)
        lifted = circle_map(image)
        rounding = np.abs(steepness) * rounding + LIFT * (TWO_PI + np.abs(lifted))
        image, laps = within_turn(lifted)
        turns = circle_map.degree * turns + laps.astype(np.int64)
        slope = slope * steepness
    return image - theta + TWO_PI * (turns - winding), slope, rounding


def diagonal_scan(circle_map: CircleMap, period: int) -> DiagonalScan:
    """The crossings of Fⁿ - id with 2πw: touches within ``TANGENCY`` are set apart."""
    cells = monotone_cells(circle_map, period, 1.0)
    _refuse_identity(circle_map, cells)
    joined = is_continuous(cells)
    tolerance, seeds = _tolerance(circle_map, cells, joined)
    theta, g = (
        np.stack(sides, axis=1).ravel()
        for sides in ((cells.start, cells.end), (cells.g_start, cells.g_end))
    )
    scan = DiagonalScan(circle_map, cells, joined, theta, g, whole_turns(g), tolerance)
    settled: set[int] = set()
    for seed in seeds.tolist():
        if seed not in settled:
            settled.update(scan.settled(seed))
    # The lines that g crosses by a jump; those that one side of the jump merely meets are left out.
    met = dict.fromkeys(scan.border)
    for cell in np.flatnonzero(~joined):
        before = int(scan.turns[2 * cell - 1]) - (scan.lap if cell == 0 else 0)
        after = int(scan.turns[2 * cell])
        place = float(cells.start[cell])
        for w in range(min(before, after) + 1, max(before, after) + 1):
            if (place, w) not in met:
                scan.jumps.append(JumpCrossing(place, w, before > after))
    return scan


def _refuse_identity(circle_map: CircleMap, cells: Cells) -> None:
    width = cells.end - cells.start
    near = (_gap(cells.g_start) <= _IDENTITY) & (_gap(cells.g_end) <= _IDENTITY) & (width > 1e-6)
    if not np.any(near):
        return
    theta = cells.start[near] + np.linspace(0.01, 0.99, 5)[:, None] * width[near]
    whole = np.round((iterate(circle_map, theta, cells.period) - theta) / TWO_PI).astype(np.int64)
    residual, _, rounding = displacement(circle_map, theta, cells.period, whole)
    near[near] = np.all(np.abs(residual) <= 2.0 * rounding, axis=0)
    # A touch of high order is flat as well, but on a short stretch that no breaks bound.
    stretch = np.cumsum(~near)
    flat = near & (
        (np.bincount(stretch, width * near)[stretch] > _FLAT) | (cells.cut & np.roll(cells.cut, -1))
    )
    if np.any(flat):
        raise InvalidInput(
            f"every point near θ = {cells.start[flat][0]:.6g} has period {cells.period}: the map's "
            "iterate is a rotation by whole turns there, so they cannot be listed; perturb the map "
            "or ask for its rotation number"
        )


# -- cell ends that lie on the diagonal, within the tangency


def _tolerance(circle_map: CircleMap, cells: Cells, joined: Mask) -> tuple[Array, Whole]:
    """How far from a whole turn each cell end still counts as on it, and the ends where that needs
    settling.

    Ends are counted 0, 1, 2, ...: the start of cell 0, its end, the start of cell 1, ... Only at
    extrema and breaks can plain counting lose or double a root. All points of one orbit are judged
    alike.
    """
    rising = is_rising(cells)
    special = np.flatnonzero((rising != np.roll(rising, 1)) | cells.cut)
    tolerance = np.full(2 * cells.start.size, TANGENCY)
    if special.size == 0:
        return tolerance, special
    after = cells.g_start[special]
    before = np.roll(cells.g_end, 1)[special] - cells.climb * (special == 0)
    inside = cells.start[special] + INSET * cells.cut[special]
    _, _, rounding = displacement(circle_map, inside, cells.period, whole_turns(after))
    allowed = (
        TANGENCY
        + rounding
        + LIFT * np.abs(after)
        + np.where(joined[special], np.abs(after - before), 0.0)
    )
    gap_after = _gap(after)
    gap_before = _gap(before)
    gap = np.minimum(gap_after, gap_before)
    # A touch of an iterate makes touches of the extrema next to its images: their tolerances are
    # raised.
    touches = gap <= allowed
    nodes = cells.start[special]
    image = nodes[touches]
    stretch = np.ones(np.count_nonzero(touches))
    reach = 4.0 * (gap + allowed)[touches]
    for _ in range(cells.period - 1 if image.size else 0):
        stretch = stretch * np.abs(circle_map.derivative(image))
        image = np.mod(circle_map(image), TWO_PI)
        near, mate = nearest_on_circle(nodes, image)
        same = (np.abs(near - image) <= _MATE) & (gap[mate] <= reach * np.maximum(stretch, 1.0))
        met = mate[same]
        allowed[met] = np.maximum(allowed[met], 1.01 * gap[met])
    tolerance[2 * special] = allowed
    tolerance[2 * special - 1] = allowed
    ends = np.append(2 * special[gap_after <= allowed], 2 * special[gap_before <= allowed] - 1)
    return tolerance, np.mod(ends, 2 * cells.start.size)


def _gap(g: Array) -> Array:
    return np.abs(g - TWO_PI * np.round(g / TWO_PI))


@dataclass(frozen=True)
class SlowPassage:
    """A bottleneck: near ``theta`` the n-th iterate moves by ε + a x² + ..., x the distance from
    ``theta``.

    Attributes
    ----------
    theta : float
        Radians in [0, 2π), where |Fⁿ - id - 2πw| is least.
    winding : int
        w, whole turns of the iterate.
    period : int
        n, of the iterate, cycles.
    gap : float
        ε, radians an n-fold cycle; its sign is the direction of motion. Good to rounding.
    curvature : float
        a, per radian, of the same sign as ε. Good to about 1e-8 of itself.
    width : float
        √(ε/a), radians: half the width of the stretch on which the move is less than doubled.
    passage_cycles : float
        nπ/√(aε), cycles of F: the time from far on one side to far on the other, to leading
        order.
    direction : int
        1 when the orbit moves up through it, -1 down.
    relative_error : float
        At most |true/parabola - 1| for the number of cycles across ±4 widths, the stretch that
        takes 84 % of the passage; of order ε. Measured, not proved: the true number is the integral
        of dx/v, v the flow that interpolates the map, up to a thousand cycles that of the iterates
        of one path. What is unknown of its last one, and of ε by rounding, is added. inf where
        that stretch holds a zero of v, a break, or more than a turn, and where a path across it
        does not get through.

    Examples
    --------
    >>> from cyclemap import CircleMap, slow_passages
    >>> (ghost,) = slow_passages(CircleMap.arnold(0.15, 0.9))
    >>> round(ghost.gap, 6), round(ghost.curvature, 6), round(ghost.width, 4)
    (0.042478, 0.45, 0.3072)
    """

    theta: float
    winding: int
    period: int
    gap: float
    curvature: float
    width: float
    passage_cycles: float
    direction: int
    relative_error: float


def slow_passages(
    circle_map: CircleMap, period: int = 1, winding: int | None = None
) -> list[SlowPassage]:
    """All bottlenecks of the n-th iterate of a map: what saddle-nodes leave behind when their
    orbits are gone.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    period : int, default 1
        n, cycles.
    winding : int or None, optional
        Keep only this w; None takes, at each extremum, the nearest line on the side that it
        does not cross. A passage near an orbit of period n shows at each of its n points; those
        of a divisor of n are left out, and so are kinks and jumps, where the parabola does not
        hold.

    Returns
    -------
    list of SlowPassage
        By angle.

    Raises
    ------
    InvalidInput
        For a bad request.
    ConvergenceError
        When Fⁿ is too steep to scan.

    Notes
    -----
    A bottleneck is a smooth local extremum of the move Fⁿ - id - 2πw on its own side of zero (a
    least upward or a least downward move), by more than 1e-12 radians (nearer it is a
    saddle-node, see ``periodic_points``), whose passage π/√(aε) takes at least 10 cycles of F
    in all, and whose |ε| is at most half the mean of |Fⁿ - id - 2πw| over the circle.

    x' = x + ε + a x² takes π/√(aε) steps (Pomeau & Manneville 1980; Strogatz, Nonlinear
    Dynamics and Chaos, 4.3). The flow that interpolates x' = x + g(x) is v = g - gg'/2 + gg'²/3
    + g²g''/12 + ..., so that dt = dx/v.

    References
    ----------
    - Pomeau, Y. & Manneville, P. (1980), Intermittent transition to turbulence in dissipative
      dynamical systems, Communications in Mathematical Physics 74.
    - Strogatz, S. H., Nonlinear dynamics and chaos, section 4.3.

    Examples
    --------
    >>> from cyclemap import CircleMap, slow_passages
    >>> (ghost,) = slow_passages(CircleMap.arnold(0.15, 0.9))
    >>> round(ghost.theta, 6), ghost.direction, round(ghost.passage_cycles, 3)
    (1.570796, 1, 22.723)
    """
    require_map(circle_map)
    n = whole_number("period", period, least=1)
    wanted = None if winding is None else whole_number("winding", winding)
    cells = monotone_cells(circle_map, n, 1.0)
    theta, whole, gap = _near_misses(circle_map, cells, wanted)
    near = np.abs(gap) > TANGENCY
    angle = theta
    for d in range(1, n):  # left out where a divisor of the period comes at least as near
        angle = np.mod(circle_map(angle), TWO_PI)
        near &= (n % d != 0) | (np.abs(shorter_way(angle - theta)) > np.abs(gap))
    # Half the second derivative.
    curvature, _ = differences(
        lambda x: 0.5 * displacement(circle_map, x, n, np.asarray(0))[1], circle_map.breaks, theta
    )
    near &= curvature * gap > 0.0  # else too flat for a parabola
    passages = []
    columns = (column[near].tolist() for column in (theta, whole, gap, curvature))
    for place, turns, least, bend in zip(*columns, strict=True):
        cycles = float(n * np.pi / np.sqrt(bend * least))
        if cycles >= LEAST_CYCLES:
            width = float(np.sqrt(least / bend))
            way = 1 if least > 0.0 else -1
            passage = SlowPassage(place, turns, n, least, bend, width, cycles, way, np.inf)
            error = _relative_error(circle_map, passage)
            passages.append(replace(passage, relative_error=error))
    return passages


def _near_misses(
    circle_map: CircleMap, cells: Cells, wanted: int | None
) -> tuple[Array, Whole, Array]:
    """Smooth extrema of the move that face the line 2πw, w, and their distance ε from it where that
    is small.
    """
    rising = is_rising(cells)
    place = np.flatnonzero((rising != np.roll(rising, 1)) & ~cells.cut)
    place = place[is_continuous(cells)[place]]
    theta = cells.start[place]
    g = cells.g_start[place]
    least = rising[place]
    line = np.where(least, np.floor(g / TWO_PI), np.ceil(g / TWO_PI)).astype(np.int64)
    whole = line if wanted is None else np.full(place.size, wanted)
    gap, _, _ = displacement(circle_map, theta, cells.period, whole)
    middle = 0.5 * (cells.g_start + cells.g_end)
    weight = (cells.end - cells.start) / TWO_PI
    mean = np.array([np.dot(weight, np.abs(middle - TWO_PI * w)) for w in whole])
    keep = (np.where(least, gap, -gap) > 0.0) & (np.abs(gap) <= _SHARE * mean)
    return theta[keep], whole[keep], gap[keep]


def _relative_error(circle_map: CircleMap, passage: SlowPassage) -> float:
    """How far the parabola's number of cycles across ±REACH widths is from the flow's."""
    width = passage.width
    if 2.0 * REACH * width >= TWO_PI:
        return float("inf")
    # x = width·tan(s) makes the integrand of a parabola constant.
    s, weight = np.polynomial.legendre.leggauss(_GAUSS)
    edge = np.arctan(REACH)
    x = width * np.append(np.tan(edge * s), [-REACH, REACH])
    angle = passage.theta + x
    # A break inside the stretch, or inside one of its images before the last?
    for _ in range(passage.period):
        low = float(np.min(angle))
        high = float(np.max(angle))
        if np.any(np.mod(circle_map.breaks - low, TWO_PI) < high - low):
            return float("inf")
        angle = circle_map(angle)
    g, slope, rounding = displacement(
        circle_map, passage.theta + x, passage.period, np.asarray(passage.winding)
    )
    if np.any(g * passage.gap <= 0.0):
        return float("inf")
    parabola = 2.0 * edge / np.sqrt(passage.curvature * passage.gap)
    unknown = 0.5 * float(np.max(rounding)) / abs(passage.gap)
    if parabola <= _FOLLOWED:
        true = _followed(circle_map, passage)
        unknown += abs(passage.curvature) * REACH * width / parabola
    else:
        bend = slope - 1.0
        stretch = edge * weight * width * (1.0 + (x[:-2] / width) ** 2)
        # ∫dx/v = ∫dx/g + ½[ln g] - (1/12)∫g'²/g dx - (1/12)[g'] + ...
        true = float(np.dot(stretch, (1.0 - bend[:-2] ** 2 / 12.0) / g[:-2]))
        true += 0.5 * float(np.log(g[-1] / g[-2])) - float(bend[-1] - bend[-2]) / 12.0
    return float(abs(abs(true) / parabola - 1.0) + unknown)


def _followed(circle_map: CircleMap, passage: SlowPassage) -> float:
    """Iterates from one end of the stretch to the other, ±REACH widths off, of the last one the
    share that its way has inside; inf where a path does not get through.
    """
    way = passage.direction
    reach = REACH * passage.width
    lift = circle_map.scalar()
    count = 0
    x = -reach
    while x < reach:
        before = x
        place = passage.theta + way * x
        for _ in range(passage.period):
            place = lift(place)
        x = way * (place - TWO_PI * passage.winding - passage.theta)
        count += 1
        if x <= before or count > _MOST_FOLLOWED:
            return float("inf")
    return count - (x - reach) / (x - before)
