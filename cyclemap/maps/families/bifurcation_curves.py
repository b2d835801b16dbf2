"""Curves of saddle-nodes, period doublings and border collisions in a plane of two parameters, and
their points.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_number, read_only, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.families.arclength import SMALLEST, STRAIGHT, ArclengthWalk
from cyclemap.maps.families.continuation import bifurcations
from cyclemap.maps.families.curve_equations import KINDS, CodimensionTwo, CurveEquations, CurveSpot
from cyclemap.maps.families.family import (
    Family,
    Range,
    break_motion,
    each_done,
    family_member,
    parameter_range,
)
from cyclemap.maps.families.orbit_equations import Bifurcation, crossed_break, zero_along
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.progress import Progress

_RIGID = 0.3  # radians: a spread of F^n - id from which a tip may be near
_NEAR = 0.01  # scaled: halves of an orbit nearer than that are told apart ever worse


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


@dataclass(eq=False, kw_only=True)
class _CurveWalk(ArclengthWalk):
    """A walk along a curve of bifurcations: its solutions, and the points of codimension two that
    it has passed.
    """

    equations: CurveEquations
    spots: list[CurveSpot]
    special: list[CodimensionTwo] = field(default_factory=list)
    blocked: str = "lost"  # what the last step that was refused ran into
    # where the curve is about to end, scaled, and what that may be off
    ending: tuple[Array, Array] | None = None
    extrapolated: list[Array] = field(default_factory=list)  # the last two such ends

    def stop(self) -> None:
        """End where steps have become too small, with the point of codimension two that made them
        so.
        """
        self.reason = self.blocked
        spot = self.spots[-1]
        flips = self.equations.kind == "period-doubling"
        names = {"half the period": "generalised flip", "tip": "tip"}
        if self.equations.side == 0:
            names["border collision"] = "border flip" if flips else "border saddle-node"
        if self.reason in names:
            at, error = self.ending or (spot.at[-2:], np.full(2, SMALLEST))
            self.special.append(self.equations.placed(names[self.reason], spot, at, 4.0 * error))

    def advance(self) -> None:
        """One attempt at a step: it succeeds, ends the walk, or halves the step."""
        here = self.spots[-1]
        length, row, at_end = self.ahead()
        if length <= 1e-12:
            self.reason = "end of the plane"
            return
        guess = here.at + length * self.direction
        unmoved = np.zeros(here.state.member.breaks.size)
        if crossed_break(here.state, self.angles(guess), unmoved) is not None:
            self.blocked = "border collision"
        solved = self.equations.solved(guess, row)
        if solved is None or not self._accepted(here, solved):
            self.step *= 0.5
        elif at_end:
            self.reason = self.reason or "end of the plane"

    def _accepted(self, here: CurveSpot, solved: CurveSpot) -> bool:
        """Take the step unless it is too far, too bent, or crosses what it must stop before."""
        direction = self.equations.direction(solved, self.direction)
        if (
            np.linalg.norm(solved.at - here.at) > 2.0 * self.step
            or direction @ self.direction < STRAIGHT
        ):
            return False
        old = here.state
        new = solved.state
        motion = break_motion(old.member.breaks, new.member.breaks)
        if crossed_break(old, new.theta, motion) is not None:
            self.blocked = "border collision"
            return False
        if (
            here.gap.size
            and (here.gap @ (here.gap + np.diff([here.halves, solved.halves], axis=0)[0])) <= 0.0
        ):
            self.blocked = "half the period"
            return False
        self._tested(here, solved, direction)
        self.spots.append(solved)
        if self.ending is None or not (
            solved.spread < here.spread or np.linalg.norm(solved.gap) < np.linalg.norm(here.gap)
        ):
            self.blocked = "lost"
            self.ending = None
        self.taken(solved.at, direction)
        if self.reason:
            self.spots[-1] = replace(self.spots[0], at=self.at[-1])
        elif self.equations.kind == "saddle-node" and len(self.spots) > 3:
            self._nears_end()
        return True

    def _tested(self, here: CurveSpot, solved: CurveSpot, direction: Array) -> None:
        """Record the points of codimension two between two neighbouring solutions."""
        length = float(self.direction @ (solved.at - here.at))
        tests = zip(self.equations.tests(here), self.equations.tests(solved), strict=True)
        for index, ((kind, before, off), (_, after, far)) in enumerate(tests):
            if not before * after < 0.0 or abs(before) <= off or abs(after) <= far:
                continue

            def test(spot: CurveSpot, index: int = index) -> float:
                return list(self.equations.tests(spot))[index][1]

            spot = zero_along(
                (here, solved),
                length,
                lambda distance: self.equations.solved(
                    here.at + distance * self.direction, self.direction
                ),
                test,
                "a point of codimension two could not be reached along its curve",
            )
            error = list(self.equations.tests(spot))[index][2]
            shift = error * length / abs(after - before)
            curved = float(np.linalg.norm(direction - self.direction)) / length
            tangent = self.equations.direction(spot, self.direction)
            self.special.append(self.equations.recorded(kind, spot, 4.0 * shift, tangent, curved))

    def _nears_end(self) -> None:
        """Go no further than half way to where the curve ends in a tip or an orbit of half the
        period; stop close by.

        The parameters are extrapolated from the last three solutions to where a measure is 0 in
        which they are smooth. At a tip the spread of F^n - id falls as a whole power of the
        distance: its straightest root. Where the halves of the orbit meet, they come as far apart
        on the other side: the square of their distance.
        """
        recent = self.spots[-3:]
        orbit = self.equations.hops.size
        length = np.array([float(self.direction @ (spot.at - recent[-1].at)) for spot in recent])
        spread = np.array([spot.spread for spot in recent])
        apart = (
            np.array([np.linalg.norm(spot.gap) for spot in recent])
            if orbit % 2 == 0
            else np.full(3, np.inf)
        )
        candidates = [("tip", spread ** (1.0 / power), 1) for power in range(1, 2 * orbit + 2)]
        candidates = [*(candidates if spread[-1] < _RIGID else []), ("half the period", apart, 2)]
        best = 0.1
        ending = None
        for reason, root, power in candidates:
            if root[0] > root[1] > root[2] > 0.0 and root[2] < _RIGID ** (1.0 / orbit):
                slope = (root[2] - root[1]) / (length[2] - length[1])
                bent = abs(root[0] - root[2] - slope * length[0]) / root[0]
                if bent < best:
                    best = bent
                    ending = (reason, root**power, -root[2] / slope)
        if ending is None or ending[2] > 4.0 * self.step:
            return
        reason, measure, distance = ending
        shares = [float(np.prod([b / (b - a) for b in measure if b != a])) for a in measure]
        at = np.sum(
            [share * spot.at[-2:] for share, spot in zip(shares, recent, strict=True)], axis=0
        )
        self.blocked = reason
        self.step = min(self.step, 0.5 * distance)
        # Two neighbouring extrapolations may agree by chance: three are compared.
        known = [*(self.extrapolated or [recent[-1].at[-2:]]), at]
        change = np.sum(np.abs(np.diff(known, axis=0)), axis=0) + 1e-12
        if self.ending is None or np.max(change) < np.max(self.ending[1]):
            self.ending = at, change
        self.extrapolated = known[-2:]
        if distance < (_NEAR if reason == "half the period" else 1e-4) or spread[-1] < 1e-9:
            self.stop()


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
    height = finite_number("at", at)
    return _followed(family, start, (float(start.parameter), height), ranges)


def _followed(
    family: Family, start: Bifurcation, at: tuple[float, float], ranges: tuple[Range, Range]
) -> BifurcationCurve:
    points = np.array(start.points)
    member = family_member(family, *at)
    images = member(points)
    sides: tuple[int, ...] = (0,)
    if start.kind == "border-collision":
        sides = (1, -1) if start.jump else (1,)
    begin = None
    for side in sides:
        if side:
            images[0] = (member.right if side > 0 else member.left)(points[:1])[0]
        hops = np.round((images - np.roll(points, -1)) / TWO_PI)
        equations = CurveEquations(
            family, hops, start.winding, start.kind, ranges, side, start.jump
        )
        guess = np.append(points, at) / equations.scales
        along = equations.direction(equations.spot(guess))
        begin = equations.solved(guess, along)
        if begin is not None and np.linalg.norm(begin.at - guess) < 1e-2:
            break
    else:
        raise InvalidInput(
            f"there is no {start.kind} of period {start.period} at ({at[0]:.9g}, {at[1]:.9g}) "
            f"near θ = {points[0]:.6g}"
        )
    ahead = equations.direction(begin)
    forward, backward = (
        _CurveWalk(
            scales=equations.scales,
            ranges=ranges,
            initial=initial,
            at=[begin.at],
            equations=equations,
            spots=[begin],
        )
        for initial in (ahead, -ahead)
    )
    spots = forward.walked().spots
    special = forward.special
    ends = ("closed", "closed")
    if forward.reason != "closed":
        spots = backward.walked().spots[:0:-1] + spots
        special = backward.special[::-1] + special
        ends = backward.reason, forward.reason
    at_all = np.array([spot.at * equations.scales for spot in spots])
    return BifurcationCurve(
        start.kind,
        read_only(at_all[:, -2]),
        read_only(at_all[:, -1]),
        read_only(at_all[:, :-2]),
        read_only([equations.coefficient(spot)[0] for spot in spots]),
        tuple(special),
        start.period,
        start.winding,
        ends,
        max(float(np.max(np.abs(spot.residual))) for spot in spots),
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
        Of the orbits, cycles.
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
    ranges = parameter_range("first", first), parameter_range("second", second)
    count = whole_number("lines", lines, least=1)
    require_room("the lines", count, "give fewer")
    curves: list[BifurcationCurve] = []
    spans = np.array([high - low for low, high in ranges])
    shares = (np.arange(count) + 0.5) / count
    heights = [
        (axis, height)
        for axis in (1, 0)
        for height in (ranges[axis][0] + shares * spans[axis]).tolist()
    ]
    work = partial(_on_line, family, ranges, period, winding)
    for starts in each_done(work, heights, executor, progress):
        for start, at in starts:
            if not any(_on(curve, start, np.array(at), spans) for curve in curves):
                curves.append(_followed(family, start, at, ranges))
    return curves


def _on_line(
    family: Family,
    ranges: tuple[Range, Range],
    period: int,
    winding: int,
    line: tuple[int, float],
) -> list[tuple[Bifurcation, tuple[float, float]]]:
    """The bifurcations on the line at one value of the parameter number ``line[0]``, and where."""
    axis, height = line

    def along(value: float) -> CircleMap:
        return family(value, height) if axis else family(height, value)

    met = bifurcations(along, ranges[1 - axis], period, winding, resolution=_RESOLUTION)
    values = [(start, float(start.parameter)) for start in met if start.kind in KINDS]
    return [(start, (value, height) if axis else (height, value)) for start, value in values]


def _on(curve: BifurcationCurve, start: Bifurcation, at: Array, spans: Array) -> bool:
    """Whether the bifurcation lies on the curve, between two of its points."""
    if curve.kind != start.kind:
        return False
    plane = np.column_stack([curve.first, curve.second]) / spans
    for k in range(start.period):
        angles = shorter_way(curve.points - np.roll(start.points, k)) / np.sqrt(start.period)
        offset = np.column_stack([angles, plane - at / spans])
        step = np.diff(offset, axis=0)
        share = np.clip(
            -np.sum(offset[:-1] * step, 1) / np.maximum(np.sum(step * step, 1), 1e-300), 0.0, 1.0
        )
        if (
            np.min(np.linalg.norm(offset[:-1] + share[:, None] * step, axis=1), initial=np.inf)
            < _SAME
        ):
            return True
    return False
