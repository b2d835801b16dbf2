"""Curves of saddle-nodes, period doublings and border collisions in a plane of two parameters, and
their points of codimension two.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_number, read_only, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.bifurcations import bifurcations
from cyclemap.maps.families.continuation import Bifurcation, followed_period
from cyclemap.maps.families.family import Family, Range, each_done, family_member, parameter_range
from cyclemap.maps.families.orbit_curves import (
    SMALLEST,
    ArclengthWalk,
    OrbitEquations,
    OrbitState,
    curve_direction,
    walked_both_ways,
)
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.progress import Progress

KINDS = "saddle-node", "period-doubling", "border-collision"
_RIGID = 0.3  # radians: a spread of F^n - id from which a tip may be near
_NEAR = 0.01  # scaled: halves of an orbit nearer than that are told apart ever worse


@dataclass(frozen=True, eq=False)
class CodimensionTwo:
    """A point of a plane at which the bifurcation along a curve changes its kind.

    Attributes
    ----------
    kind : str
        "cusp" (of a saddle-node's curve: (F^n)'' = 0), "generalised flip" (of a period
        doubling's: the first Lyapunov coefficient is 0, and a curve of saddle-nodes of twice
        the period ends), "tip" (F^n is a rotation, as where the two edges of a tongue meet),
        "border saddle-node" and "border flip" (a multiplier of 1 or -1 while a point of the
        orbit is on a break of the map).
    first, second : Estimate
        The parameters.
    points : ndarray, shape (period,)
        Of the orbit, radians in [0, 2π).
    period, winding : int
        Of the orbit.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, follow_bifurcation, saddle_nodes
    >>> [born] = saddle_nodes(lambda p: CircleMap.arnold(p, 0.9), (0.0, 0.5))
    >>> edge = follow_bifurcation(CircleMap.arnold, born, 0.9, (0.0, 0.5), (-1.0, 2.0))
    >>> [tip] = edge.special
    >>> tip.kind, tip.first.holds(0.0), tip.second.holds(0.0)
    ('tip', True, True)
    """

    kind: str
    first: Estimate
    second: Estimate
    points: Array
    period: int
    winding: int


@dataclass(frozen=True, eq=False)
class BifurcationCurve:
    """A curve of one kind of bifurcation in the plane, in order along it.

    Attributes
    ----------
    kind : str
        As of ``Bifurcation``.
    first, second : ndarray, shape (m,)
        The two parameters along the curve.
    points : ndarray, shape (m, period)
        Of the orbits, radians, continuous along the curve.
    coefficient : ndarray, shape (m,)
        Of saddle-nodes (F^n)'', of period doublings the first Lyapunov coefficient (F^n)''²/4 +
        (F^n)'''/6, above 0 where the orbit of twice the period is stable; nan at border
        collisions.
    special : tuple of CodimensionTwo
        Its points of codimension two, in order.
    period, winding : int
        Of the orbits.
    ends : tuple[str, str]
        Why it ends at its two ends: "end of the plane", "closed" (it is a loop), "tip", "half
        the period" (the orbit becomes one of half its period), "border collision" (a point of
        the orbit meets a break), "lost" or "steps".
    residual : float
        The largest of the equations' residuals.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, follow_bifurcation, saddle_nodes
    >>> [born] = saddle_nodes(lambda p: CircleMap.arnold(p, 0.9), (0.0, 0.5))
    >>> edge = follow_bifurcation(CircleMap.arnold, born, 0.9, (0.0, 0.5), (0.5, 1.0))
    >>> edge.kind, edge.ends, [point.kind for point in edge.special]
    ('saddle-node', ('end of the plane', 'end of the plane'), [])
    """

    kind: str
    first: Array
    second: Array
    points: Array
    coefficient: Array
    special: tuple[CodimensionTwo, ...]
    period: int
    winding: int
    ends: tuple[str, str]
    residual: float


@dataclass(eq=False)
class _CurveWalk(ArclengthWalk[CodimensionTwo]):
    """A walk along a curve of bifurcations, with the points of codimension two that it has passed.

    ending : where the curve is about to end, scaled, and what that may be off.
    extrapolated : the last two such ends.
    """

    ending: tuple[Array, Array] | None = None
    extrapolated: list[Array] = field(default_factory=list)

    def stop(self) -> None:
        """End where steps have become too small, with the point of codimension two that made them
        so.
        """
        self.reason = self.blocked
        flips = self.equations.kind == "period-doubling"
        names = {"half the period": "generalised flip", "tip": "tip"}
        if self.equations.side == 0:
            names["border collision"] = "border flip" if flips else "border saddle-node"
        if self.reason in names:
            state = self.states[-1]
            at, error = self.ending or (state.at[-2:], np.full(2, SMALLEST))
            self._place(names[self.reason], state, at, 4.0 * error)

    def meets_break(self, guess: Array, solved: OrbitState | None) -> bool:
        """Never: a curve ends where a point of its orbit meets a break."""
        if self.crossed(guess, None) or (solved and self.crossed(solved.at, solved.member)):
            self.blocked = "border collision"
        return False

    def passes(self, kind: str, state: OrbitState, shift: float, curved: float) -> None:
        """Record the point of codimension two, with bounds of first order: of the equations, and
        of ``shift`` along the curve.
        """
        tangent = curve_direction(state.matrix)
        error = 4.0 * (self.equations.errors(state, tangent) + EPS)
        error += np.abs(tangent[-2:]) * shift + curved * shift**2
        self._place(kind, state, state.at[-2:], error)

    def _place(self, kind: str, state: OrbitState, at: Array, error: Array) -> None:
        """Record a point at scaled parameters with scaled errors."""
        first, second = map(
            Estimate, at * self.equations.scales[-2:], error * self.equations.scales[-2:]
        )
        points = read_only(np.mod(state.theta, TWO_PI))
        place = CodimensionTwo(kind, first, second, points, points.size, self.equations.winding)
        self.special.append(place)

    def taken(self, here: OrbitState, solved: OrbitState, direction: Array) -> None:
        """Go on to ``solved``, no further than half way to where the curve is seen to end."""
        if self.ending is None or not (
            solved.spread < here.spread or np.linalg.norm(solved.gap) < np.linalg.norm(here.gap)
        ):
            self.blocked = "lost"
            self.ending = None
        super().taken(here, solved, direction)
        if not self.reason and self.equations.kind == "saddle-node" and len(self.states) > 3:
            self._near_end()

    def _near_end(self) -> None:
        """Go no further than half way to where the curve ends in a tip or an orbit of half the
        period; stop close by.
        """
        recent = self.states[-3:]
        reason, measure, distance = self._foreseen(recent)
        if distance > 4.0 * self.step:
            return
        shares = [float(np.prod([b / (b - a) for b in measure if b != a])) for a in measure]
        at = np.array(shares) @ [state.at[-2:] for state in recent]
        self.blocked = reason
        self.step = min(self.step, 0.5 * distance)
        # Two neighbouring extrapolations may agree by chance: three are compared.
        known = [*(self.extrapolated or [recent[-1].at[-2:]]), at]
        change = np.sum(np.abs(np.diff(known, axis=0)), axis=0) + 1e-12
        if self.ending is None or np.max(change) < np.max(self.ending[1]):
            self.ending = at, change
        self.extrapolated = known[-2:]
        near = _NEAR if reason == "half the period" else 1e-4
        if distance < near or recent[-1].spread < 1e-9:
            self.stop()

    def _foreseen(self, recent: list[OrbitState]) -> tuple[str, Array, float]:
        """As what the curve will end, a measure of the last three solutions in which the
        parameters are smooth and that is 0 there, and how far that is; inf where it is not seen.

        At a tip the spread of F^n - id falls as a whole power of the distance: its straightest
        root. Where the halves of the orbit meet, they come as far apart on the other side: the
        square of their distance.
        """
        n = self.equations.hops.size
        length = np.array([float(self.direction @ (state.at - recent[-1].at)) for state in recent])
        spread = np.array([state.spread for state in recent])
        candidates = []
        if spread[-1] < _RIGID:
            candidates = [("tip", spread ** (1.0 / power), 1) for power in range(1, 2 * n + 2)]
        if n % 2 == 0:
            apart = np.linalg.norm([state.gap for state in recent], axis=1)
            candidates.append(("half the period", apart, 2))
        straightest = 0.1
        ending = "", spread, np.inf
        for reason, root, power in candidates:
            if root[0] > root[1] > root[2] > 0.0 and root[2] < _RIGID ** (1.0 / n):
                slope = (root[2] - root[1]) / (length[2] - length[1])
                bent = abs(root[0] - root[2] - slope * length[0]) / root[0]
                if bent < straightest:
                    straightest = bent
                    ending = reason, root**power, -root[2] / slope
        return ending


def follow_bifurcation(
    family: Family, start: Bifurcation, at: float, first: Range, second: Range
) -> BifurcationCurve:
    """The curve of bifurcations through one of them, followed both ways in a plane of two
    parameters.

    Parameters
    ----------
    family : callable
        (p, q) → CircleMap, called only inside the plane.
    start : Bifurcation
        A saddle-node, period doubling or border collision of p → family(p, at), as
        ``bifurcations`` gives them.
    at : float
        The second parameter there.
    first, second : tuple[float, float]
        (low, high) of the two parameters.

    Returns
    -------
    BifurcationCurve
        The m points in order along it, and its points of codimension two.

    Raises
    ------
    InvalidInput
        For another kind of bifurcation, or where there is none.
    ConvergenceError
        Where a point of codimension two cannot be located.

    Notes
    -----
    The orbit's equations and the condition, a multiplier of ±1 or a point on a break, are solved
    for θ and both parameters and followed in their arclength (Keller 1977; Kuznetsov 2004, ch. 10),
    so that folds of the curve and cusps are passed and every point is correct to rounding, or to
    what the map's ``max_error`` leaves. Points of codimension two are where the normal form's
    coefficient, told from five-point differences of (Fⁿ)' over 4 and 8 mrad, changes its sign by
    more than its error: on maps that are sampled coarser than that none may be told. Beside a break
    they are narrower, and within 8 µrad of one nothing is told. What happens
    twice within one step, at most 0.06 of the plane, is missed. The bounds of tips, and of points
    at which a curve ends, are measured; the others are of first order.

    References
    ----------
    - Keller, H. B. (1977), Numerical solution of bifurcation and nonlinear eigenvalue problems.
    - Kuznetsov, Y. A. (2004), Elements of applied bifurcation theory, chapter 10.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, follow_bifurcation, saddle_nodes
    >>> [born] = saddle_nodes(lambda p: CircleMap.arnold(p, 0.9), (0.0, 0.5))
    >>> edge = follow_bifurcation(CircleMap.arnold, born, 0.9, (0.0, 0.5), (-1.0, 2.0))
    >>> edge.ends, bool(np.max(np.abs(edge.first - edge.second / (2 * np.pi))) < 1e-14)
    (('tip', 'end of the plane'), True)
    >>> [tip] = edge.special
    >>> tip.first.holds(0.0) and tip.second.holds(0.0)
    True
    """
    ranges = parameter_range("first", first), parameter_range("second", second)
    if not isinstance(start, Bifurcation) or start.kind not in KINDS:
        raise InvalidInput(
            f"start is {start!r}: give a saddle-node, a period doubling or a border collision"
        )
    place = float(start.parameter), finite_number("at", at)
    equations, begin = _begun(family, start, place, ranges)
    states, special, ends = walked_both_ways(
        lambda initial: _CurveWalk(equations, [begin], initial), curve_direction(begin.matrix)
    )
    points = np.array([state.theta for state in states])
    parameters = np.array([state.parameters for state in states])
    return BifurcationCurve(
        start.kind,
        read_only(parameters[:, 0]),
        read_only(parameters[:, 1]),
        read_only(points),
        read_only([equations.coefficient(state)[0] for state in states]),
        special,
        start.period,
        start.winding,
        ends,
        max(float(np.max(np.abs(state.residual))) for state in states),
    )


def _begun(
    family: Family, start: Bifurcation, at: tuple[float, float], ranges: tuple[Range, Range]
) -> tuple[OrbitEquations, OrbitState]:
    """The equations of the curve, from the side on which they have a solution near ``at``; and
    that.
    """
    points = np.array(start.points)
    member = family_member(family, *at)
    images = member(points)
    for side in (1, -1) if start.kind == "border-collision" else (0,):
        if side:
            images[0] = (member.right if side > 0 else member.left)(points[:1])[0]
        hops = np.round((images - np.roll(points, -1)) / TWO_PI)
        equations = OrbitEquations(family, hops, start.winding, ranges, start.kind, side=side)
        guess = np.append(points, at) / equations.scales
        begin = equations.solved(guess, curve_direction(equations.state(guess).matrix))
        if begin is not None and np.linalg.norm(begin.at - guess) < 1e-2:
            return equations, begin
    raise InvalidInput(
        f"there is no {start.kind} of period {start.period} at ({at[0]:.9g}, {at[1]:.9g}) "
        f"near θ = {points[0]:.6g}"
    )


LINES = 4
_RESOLUTION = 8  # of each line
_SAME = 0.02  # scaled distance


def bifurcation_curves(
    family: Family,
    first: Range,
    second: Range,
    period: int = 1,
    winding: int = 0,
    *,
    lines: int = LINES,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> list[BifurcationCurve]:
    """All curves of saddle-nodes, period doublings and border collisions of these orbits in a
    plane.

    Parameters
    ----------
    family : callable
        (p, q) → CircleMap, called only inside the plane.
    first, second : tuple[float, float]
        (low, high) of the two parameters.
    period : int, default 1
        Of the orbits, cycles: at most 5,000.
    winding : int, default 0
        Whole turns of the orbits in a period.
    lines : int, optional
        How many evenly spaced lines each way the plane is searched on.
    progress : callable or None, optional
        Called with the fraction done of the lines; curves are followed from each as it is met.
    executor : Executor or None, optional
        As of ``rotation_plane``; line by line.

    Returns
    -------
    list of BifurcationCurve
        Each once, in the order in which they are met.

    Notes
    -----
    ``bifurcations`` are sought on ``lines`` evenly spaced lines across the plane each way; one
    that lies on no curve found so far, to a fiftieth of the plane, starts a new one
    (``follow_bifurcation``). A curve that no line crosses is lost.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, bifurcation_curves
    >>> (edge,) = bifurcation_curves(CircleMap.arnold, (0.02, 0.3), (0.5, 0.9), lines=2)
    >>> edge.kind, bool(np.allclose(edge.first, edge.second / (2.0 * np.pi)))  # the tongue 0/1
    ('saddle-node', True)
    """
    if not callable(family):
        raise InvalidInput(f"family is {family!r}: give a callable of two parameters")
    ranges = parameter_range("first", first), parameter_range("second", second)
    n = followed_period(period)
    turns = whole_number("winding", winding)
    count = whole_number("lines", lines, least=1)
    require_room("the lines", count, "give fewer")
    curves: list[BifurcationCurve] = []
    shares = (np.arange(count) + 0.5) / count
    heights = [
        (axis, ranges[axis][0] + share * (ranges[axis][1] - ranges[axis][0]))
        for axis in (1, 0)
        for share in shares.tolist()
    ]
    work = partial(_on_line, family, ranges, n, turns)
    for starts in each_done(work, heights, executor, progress):
        for start, at in starts:
            if not any(_on(curve, start, at, ranges) for curve in curves):
                curves.append(follow_bifurcation(family, start, at, *ranges))
    return curves


def _on_line(
    family: Family,
    ranges: tuple[Range, Range],
    period: int,
    winding: int,
    line: tuple[int, float],
) -> list[tuple[Bifurcation, float]]:
    """The bifurcations on the line at one value of the parameter number ``line[0]``: each as of
    the first parameter, and the second there.
    """
    axis, height = line

    def along(value: float) -> CircleMap:
        return family(value, height) if axis else family(height, value)

    met = bifurcations(along, ranges[1 - axis], period, winding, resolution=_RESOLUTION)
    starts = [start for start in met if start.kind in KINDS]
    if axis:
        return [(start, height) for start in starts]
    across = Estimate(height, 0.0)
    return [(replace(start, parameter=across), float(start.parameter)) for start in starts]


def _on(
    curve: BifurcationCurve, start: Bifurcation, at: float, ranges: tuple[Range, Range]
) -> bool:
    """Whether the bifurcation lies on the curve, between two of its points."""
    if curve.kind != start.kind:
        return False
    away = np.column_stack([curve.first - start.parameter, curve.second - at])
    away /= np.diff(ranges).T
    for k in range(start.period):
        angles = shorter_way(curve.points - np.roll(start.points, k)) / np.sqrt(start.period)
        offset = np.column_stack([angles, away])
        step = np.diff(offset, axis=0)
        squared = np.maximum(np.sum(step * step, axis=1), 1e-300)
        share = np.clip(-np.sum(offset[:-1] * step, axis=1) / squared, 0.0, 1.0)
        distance = np.linalg.norm(offset[:-1] + share[:, None] * step, axis=1)
        if np.min(distance, initial=np.inf) < _SAME:
            return True
    return False
