"""Branches of periodic orbits followed through a family, round folds, and the bifurcations met on
them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.checks import finite_number, read_only, require_room, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.arclength import FIRST, STRAIGHT, ArclengthWalk
from cyclemap.maps.families.family import (
    Family,
    Range,
    break_motion,
    family_member,
    parameter_range,
)
from cyclemap.maps.families.orbit_equations import (
    Bifurcation,
    OrbitEquations,
    OrbitState,
    border_collision,
    crossed_break,
    orbit_equations,
    smooth_bifurcation,
)
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.periodic_points import Orbit, periodic_orbits

RESOLUTION = 24
_ON_ORBIT = 1e-12  # radians: residual of points that are an orbit
_ASIDE = 1e-3  # scaled arclength
_SAME_ORBIT = 1e-7  # radians
# radians: at a fold two findings of one orbit may differ by the root of rounding
_SAME_POINT = 1e-4
_SAME_PARAMETER = 1e-9  # of the range
_WIDEST = 1e-6  # of the range: the bound of a saddle-node that is worth a proof


@dataclass(eq=False, kw_only=True)
class BranchWalk(ArclengthWalk):
    """A walk along a branch of orbits: their states, and the bifurcations that it has passed."""

    equations: OrbitEquations
    states: list[OrbitState]
    special: list[Bifurcation] = field(default_factory=list)

    def advance(self) -> None:
        """One attempt at a step: it succeeds, ends the walk, or halves the step."""
        length, row, at_end = self.ahead()
        if length <= 1e-12:
            self.reason = "end of the range"
            return
        guess = self.at[-1] + length * self.direction
        solved = self.equations.solved_along(guess, row)
        hit = self._collision(guess, solved)
        if hit is not None:
            record, state, outward = hit
            self.special.append(record)
            self._passes(state)
            if outward is None:
                self.reason = "jump"
            else:
                self.direction = outward
                self.step = min(self.step, FIRST)
        elif solved is None or not self._accepted(solved):
            self.step *= 0.5
        elif at_end:
            self.reason = self.reason or "end of the range"

    def _passes(self, state: OrbitState) -> None:
        self.states.append(state)
        self.at.append(self.equations.point(state))

    def _accepted(self, solved: OrbitState) -> bool:
        """Take the step to ``solved`` unless it is too far, too bent or crosses a break that was
        not located.
        """
        before = self.states[-1]
        there = self.equations.point(solved)
        push = solved.push
        if push is None:
            push = self.equations.push(solved.parameter)(solved.theta)
        direction = self.equations.direction(solved.slopes, push, self.direction)
        change = abs(solved.multiplier - before.multiplier)
        if (
            np.linalg.norm(there - self.at[-1]) > 2.0 * self.step
            or direction @ self.direction < STRAIGHT
            or (change > 0.5 + 0.5 * abs(before.multiplier) and self.step > 1e-4)
            or self._crossed(solved.theta, solved) is not None
        ):
            return False
        half = self.equations.hops.size // 2
        # Through an orbit of half the period, where the two halves change places?
        old, new = (np.roll(state.theta, -half) - state.theta for state in (before, solved))
        gap = shorter_way(old)
        ahead = gap + new - old
        if self.equations.hops.size == 2 * half and (
            (gap @ ahead) <= 0.0 or np.max(np.abs(ahead)) < 1e-9
        ):
            self.reason = "half the period"
            return True
        for target in (1.0, -1.0):
            if (before.multiplier - target) * (solved.multiplier - target) < 0.0:
                state, found = smooth_bifurcation(
                    self.equations, before, solved, self.direction, target
                )
                self._passes(state)
                self.special.append(found)
        self.taken(there, direction)
        if self.reason:
            solved = self.equations.state(self.states[0].parameter, self.angles(self.at[-1]))
        self.states.append(solved)
        return True

    def _crossed(self, theta: Array, state: OrbitState | None) -> tuple[int, int, float] | None:
        last = self.states[-1]
        breaks = last.member.breaks
        moved = breaks if state is None else state.member.breaks
        return crossed_break(last, theta, break_motion(breaks, moved)) if breaks.size else None

    def _collision(
        self, guess: Array, solved: OrbitState | None
    ) -> tuple[Bifurcation, OrbitState, Array | None] | None:
        """The collision with a break on this step, whether the step or only its prediction crosses
        it.
        """
        reached = guess if solved is None else self.equations.point(solved)
        crossed = self._crossed(self.angles(reached), solved) or self._crossed(
            self.angles(guess), None
        )
        if crossed is None:
            return None
        point, which, share = crossed
        here = self.at[-1]
        near = here + share * (reached - here)
        p = float(np.clip(near[-1] * self.scales[-1], *self.equations.within))
        found = border_collision(
            self.equations, self.states[-1], (self.angles(near), p), point, which
        )
        if found is None:
            return None
        offset = self.equations.point(found[1]) - here
        ahead = float(offset @ self.direction) > 0.0
        return found if ahead and np.linalg.norm(offset) <= 2.0 * self.step else None


@dataclass(frozen=True, eq=False)
class OrbitBranch:
    """A branch of periodic orbits, in order along it.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        Along the branch.
    points : ndarray, shape (m, period)
        Radians, continuous along the branch (any turn), in order of visit.
    multiplier : ndarray, shape (m,)
        Of the orbits.
    stable : ndarray of bool, shape (m,)
        Whether |multiplier| < 1.
    special : tuple of Bifurcation
        The bifurcations met, in order.
    period, winding : int
        Of the orbits.
    ends : tuple[str, str]
        Why the branch ends at its two ends: "end of the range", "jump" (a point meets a jump of
        the map), "half the period" (it merges with an orbit of half its period), "closed" (it
        is a loop), "lost" (no step converged) or "steps" (4,000 were made).
    residual : float
        The largest |F(θ_i) - θ_{i+1} - 2πh_i| of all, radians.

    Examples
    --------
    >>> from cyclemap import CircleMap, follow_orbit
    >>> fold = follow_orbit(lambda omega: CircleMap.arnold(omega, 0.9), 0.0, (-0.2, 0.2), at=0.0)
    >>> fold.period, fold.points.shape[1], bool(fold.stable.any() and not fold.stable.all())
    (1, 1, True)
    """

    parameter: Array
    points: Array
    multiplier: Array
    stable: Mask
    special: tuple[Bifurcation, ...]
    period: int
    winding: int
    ends: tuple[str, str]
    residual: float


def follow_orbit(
    family: Family,
    start: Orbit | float,
    parameters: Range,
    *,
    at: float | None = None,
    period: int = 1,
    winding: int = 0,
) -> OrbitBranch:
    """The branch of periodic orbits through one of them, followed both ways.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    start : Orbit or float
        An orbit of the family's map at the parameter ``at``, or an angle near a point of one
        (radians), then with its ``period`` and ``winding``.
    parameters : tuple[float, float]
        (low, high), the range that the branch is followed in.
    at : float or None, optional
        The parameter of ``start``; None: low.
    period : int, default 1
        Of the orbit, cycles.
    winding : int, default 0
        Whole turns of the orbit in a period.

    Returns
    -------
    OrbitBranch
        The orbits in order along it, and the bifurcations met.

    Raises
    ------
    InvalidInput
        When there is no such orbit at ``at``.
    ConvergenceError
        When a bifurcation cannot be located.

    Notes
    -----
    F(θ_i; p) = θ_{i+1} + 2πh_i is solved for all points at once and followed in its arclength
    (Keller 1977), so that folds in p are passed and every point is correct to rounding. Steps
    are halved where Newton's method fails, the direction turns by more than 18° or the
    multiplier changes fast, and grow up to 0.08 in units of (θ, p/(high - low)). Saddle-nodes,
    period doublings and branch points are where the multiplier passes ±1; border collisions
    where a point passes a break: beyond a kink the branch goes on, at a jump it ends. What
    happens twice within one step is missed.

    References
    ----------
    Keller, H. B. (1977), Numerical solution of bifurcation and nonlinear eigenvalue problems.

    Examples
    --------
    >>> from cyclemap import CircleMap, follow_orbit
    >>> fold = follow_orbit(lambda omega: CircleMap.arnold(omega, 0.9), 0.0, (-0.2, 0.2), at=0.0)
    >>> [b.kind for b in fold.special], fold.ends
    (['saddle-node', 'saddle-node'], ('closed', 'closed'))
    """
    within = parameter_range("parameters", parameters)
    p = within[0] if at is None else finite_number("at", at)
    if not within[0] <= p <= within[1]:
        raise InvalidInput(
            f"at is {p:g}, outside the parameters ({within[0]:g}, {within[1]:g}): start inside"
        )
    if isinstance(start, Orbit):
        points = np.array(start.points)
        turns = start.winding
    else:
        n = whole_number("period", period, least=1)
        turns = whole_number("winding", winding)
        points = np.full(n, finite_number("start", start))
        member = family_member(family, p)
        for i in range(1, n):
            points[i] = np.mod(member(points[i - 1]), TWO_PI)
    equations = orbit_equations(family, points, p, turns, within)
    first = equations.solved_at(p, points)
    if first is None:  # on a saddle-node p cannot be held fixed: begin a little along the branch
        given = equations.state(p, points)
        if np.max(np.abs(equations.residual(given.member(points), points))) <= _ON_ORBIT:
            along = equations.direction(given.slopes, equations.push(p)(points))
            ahead = (
                equations.solved_along(equations.point(given) + k * _ASIDE * along, along)
                for k in (1, -1)
            )
            first = next((state for state in ahead if state is not None), None)
    if first is None or np.max(np.abs(first.theta - points)) > 0.5:
        raise InvalidInput(
            f"no orbit of period {points.size} and winding {turns} at {p:.9g} near θ = "
            f"{points[0]:.6g}"
        )
    direction = equations.direction(first.slopes, equations.push(first.parameter)(first.theta))
    forward, backward = (
        BranchWalk(
            scales=equations.scales,
            ranges=(within,),
            initial=initial,
            at=[equations.point(first)],
            equations=equations,
            states=[first],
        )
        for initial in (direction, -direction)
    )
    if forward.walked().reason == "closed":
        return _branch(equations, forward.states, forward.special, ("closed", "closed"))
    backward.walked()
    return _branch(
        equations,
        backward.states[:0:-1] + forward.states,
        backward.special[::-1] + forward.special,
        (backward.reason, forward.reason),
    )


def _branch(
    equations: OrbitEquations,
    states: list[OrbitState],
    special: list[Bifurcation],
    ends: tuple[str, str],
) -> OrbitBranch:
    multiplier = read_only([state.multiplier for state in states])
    gaps = [shorter_way(state.theta[:, None] - state.member.breaks) for state in states]
    residuals = [
        equations.residual(state.member(state.theta), state.theta)
        for state, gap in zip(states, gaps, strict=True)
        if not np.any(np.abs(gap) < 1e-9)  # on a jump
    ]
    return OrbitBranch(
        read_only([state.parameter for state in states]),
        read_only([state.theta for state in states]),
        multiplier,
        np.abs(multiplier) < 1.0,
        tuple(special),
        equations.hops.size,
        equations.winding,
        ends,
        float(np.max(np.abs(residuals))),
    )


def orbit_branches(
    family: Family,
    parameters: Range,
    period: int = 1,
    winding: int = 0,
    *,
    resolution: int = RESOLUTION,
) -> list[OrbitBranch]:
    """All branches of periodic orbits of one period and winding.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    parameters : tuple[float, float]
        (low, high), the range that they are followed in.
    period : int, default 1
        Of the orbits, cycles.
    winding : int, default 0
        Whole turns of the orbits in a period.
    resolution : int, optional
        Orbits are listed at so many evenly spaced parameters, and one more.

    Returns
    -------
    list of OrbitBranch
        Each once.

    Raises
    ------
    InvalidInput
        As ``periodic_orbits`` and ``follow_orbit`` do, for instance where the map's iterate is
        the identity.
    ConvergenceError
        As these two do.

    Notes
    -----
    All orbits are listed at ``resolution + 1`` evenly spaced parameters (``periodic_orbits``);
    one that lies on no branch found so far starts a new one (``follow_orbit``): a branch that
    lives and dies between two of these parameters is lost. An orbit that is neutral or on a
    kink just at one of them is left to the next.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, orbit_branches
    >>> [branch.ends for branch in orbit_branches(lambda K: CircleMap.arnold(0.1, K), (0.5, 1.5))]
    [('end of the range', 'end of the range')]
    """
    within = parameter_range("parameters", parameters)
    n = whole_number("period", period, least=1)
    w = whole_number("winding", winding)
    branches: list[OrbitBranch] = []

    def known(branch: OrbitBranch, p: float, member: CircleMap, orbit: Orbit) -> bool:
        """Whether the branch passes through the orbit, solved where the branch crosses the
        parameter.
        """
        before = branch.parameter[:-1] - p
        after = branch.parameter[1:] - p
        for i in np.flatnonzero((before * after <= 0.0) & (before != after)):
            share = before[i] / (before[i] - after[i])
            near = (1.0 - share) * branch.points[i] + share * branch.points[i + 1]
            hops = np.round((member(near) - np.roll(near, -1)) / TWO_PI)
            solved = OrbitEquations(family, hops, branch.winding, (p - 1.0, p + 1.0)).solved_at(
                p, near, member
            )
            if solved is not None and _same_orbit(solved.theta, orbit.points, _SAME_ORBIT):
                return True
        return False

    count = whole_number("resolution", resolution, least=1) + 1
    require_room("the parameters", count, "give a smaller resolution")
    for p in np.linspace(*within, count):
        member = family_member(family, float(p))
        for orbit in periodic_orbits(member, n, w):
            regular = (
                orbit.kind in ("stable", "unstable") and orbit.multiplier == orbit.left_multiplier
            )
            if regular and not any(known(branch, float(p), member, orbit) for branch in branches):
                branches.append(follow_orbit(family, orbit, within, at=float(p)))
    return branches


def _same_orbit(one: Array, other: Array, tolerance: float) -> bool:
    gaps = (shorter_way(np.roll(one, -k) - other) for k in range(one.size))
    return any(float(np.max(np.abs(gap))) <= tolerance for gap in gaps)


def bifurcations(
    family: Family,
    parameters: Range,
    period: int = 1,
    winding: int = 0,
    *,
    resolution: int = RESOLUTION,
) -> list[Bifurcation]:
    """All bifurcations of the orbits of one period and winding.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    parameters : tuple[float, float]
        (low, high), the range that is searched.
    period : int, default 1
        Of the orbits, cycles.
    winding : int, default 0
        Whole turns of the orbits in a period.
    resolution : int, optional
        As of ``orbit_branches``.

    Returns
    -------
    list of Bifurcation
        Sorted by parameter.

    Notes
    -----
    Those met on all branches of ``orbit_branches``, each once; complete as these are. Each is
    refined by solving its extended system, to a residual near rounding, and carries an error
    bound of first order.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, bifurcations
    >>> found = bifurcations(lambda omega: CircleMap.arnold(omega, 2.5), (0.0, 0.5))
    >>> [b.kind for b in found]
    ['period-doubling', 'saddle-node']
    >>> found[0].parameter.holds((2.5**2 - 4.0) ** 0.5 / (2 * np.pi))
    True
    """
    low, high = parameter_range("parameters", parameters)
    kept: list[Bifurcation] = []
    for branch in orbit_branches(family, (low, high), period, winding, resolution=resolution):
        for found in branch.special:
            again = any(
                found.kind == other.kind
                and abs(found.parameter - other.parameter) <= _SAME_PARAMETER * (high - low)
                and _same_orbit(found.points, other.points, _SAME_POINT)
                for other in kept
            )
            if not again:
                kept.append(found)
    return sorted(kept, key=lambda found: float(found.parameter))


def saddle_nodes(
    family: Family,
    parameters: Range,
    period: int = 1,
    winding: int = 0,
    *,
    resolution: int = RESOLUTION,
    proved: bool = False,
) -> list[Bifurcation]:
    """The saddle-nodes among ``bifurcations``: two orbits merge, multiplier 1.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    parameters : tuple[float, float]
        (low, high), the range that is searched.
    period : int, default 1
        Of the orbits, cycles.
    winding : int, default 0
        Whole turns of the orbits in a period.
    resolution : int, optional
        As of ``orbit_branches``.
    proved : bool, optional
        Widen each bound until the maps at its two ends are proved to have different numbers of
        these orbits (``periodic_orbits`` with ``proved``): whatever smooth family joins the two, an
        orbit with multiplier 1 lies between. For maps given by formulas; that no saddle-node is
        missing is not proved.

    Returns
    -------
    list of Bifurcation
        Sorted by parameter.

    Raises
    ------
    ConvergenceError
        With ``proved`` where the numbers do not differ, as where one pair of orbits is born while
        another vanishes.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, saddle_nodes
    >>> [birth] = saddle_nodes(lambda K: CircleMap.arnold(0.1, K), (0.1, 1.5))
    >>> birth.parameter.holds(0.2 * np.pi)
    True
    """
    within = parameter_range("parameters", parameters)
    found = bifurcations(family, within, period, winding, resolution=resolution)
    folds = [each for each in found if each.kind == "saddle-node"]
    return [_proved_fold(family, fold, within) for fold in folds] if proved else folds


def _proved_fold(family: Family, fold: Bifurcation, within: Range) -> Bifurcation:
    centre = float(fold.parameter)
    half = max(fold.parameter.error_bound, EPS * (within[1] - within[0]))
    while half <= _WIDEST * (within[1] - within[0]):
        ends = [float(np.clip(centre + side * half, *within)) for side in (-1.0, 1.0)]
        try:
            counts = [_proved_count(family_member(family, end), fold) for end in ends]
        except ConvergenceError:  # still a tangency to what intervals can tell
            counts = [0, 0]
        if counts[0] != counts[1]:
            off = np.nextafter(max(centre - ends[0], ends[1] - centre), np.inf)
            return replace(fold, parameter=Estimate(centre, off))
        half *= 4.0
    raise ConvergenceError(
        f"no proof: on both sides of the saddle-node at {centre:.12g} there are as many orbits of "
        f"period {fold.period}, or they cannot be told apart"
    )


def _proved_count(member: CircleMap, fold: Bifurcation) -> int:
    # Of other degrees the winding depends on which point comes first.
    winding = fold.winding if member.degree == 1 else None
    return len(periodic_orbits(member, fold.period, winding, proved=True))


def period_doublings(
    family: Family,
    parameters: Range,
    period: int = 1,
    winding: int = 0,
    *,
    resolution: int = RESOLUTION,
) -> list[Bifurcation]:
    """The period doublings among ``bifurcations``: multiplier -1.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    parameters : tuple[float, float]
        (low, high), the range that is searched.
    period : int, default 1
        Of the orbits, cycles.
    winding : int, default 0
        Whole turns of the orbits in a period.
    resolution : int, optional
        As of ``orbit_branches``.

    Returns
    -------
    list of Bifurcation
        Sorted by parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, period_doublings
    >>> [flip] = period_doublings(lambda K: CircleMap.arnold(0.1, K), (1.0, 3.0))
    >>> flip.parameter.holds(float(np.hypot(2.0, 0.2 * np.pi)))
    True
    """
    found = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [one for one in found if one.kind == "period-doubling"]


def border_collisions(
    family: Family,
    parameters: Range,
    period: int = 1,
    winding: int = 0,
    *,
    resolution: int = RESOLUTION,
) -> list[Bifurcation]:
    """The border collisions among ``bifurcations``: a point of the orbit meets a kink or a jump of
    the map.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    parameters : tuple[float, float]
        (low, high), the range that is searched.
    period : int, default 1
        Of the orbits, cycles.
    winding : int, default 0
        Whole turns of the orbits in a period.
    resolution : int, optional
        As of ``orbit_branches``.

    Returns
    -------
    list of Bifurcation
        Sorted by parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, border_collisions
    >>> def tent(p):
    ...     def lift(x):
    ...         return x + p + 0.5 * np.abs(np.mod(x + np.pi, 2 * np.pi) - np.pi)
    ...     return CircleMap(lift, None, [0.0, np.pi])
    >>> (collision,) = border_collisions(tent, (-1.0, 1.0))
    >>> collision.folds, collision.parameter.holds(0.0)
    (True, True)
    """
    found = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [one for one in found if one.kind == "border-collision"]
