"""Branches of periodic orbits followed through a family, round folds, and the bifurcations met on
them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.checks import finite_number, read_only, require_room, unwritable, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.family import (
    Family,
    Range,
    family_member,
    parameter_inside,
    parameter_range,
)
from cyclemap.maps.families.orbit_curves import (
    FIRST,
    ArclengthWalk,
    OrbitEquations,
    OrbitState,
    curve_direction,
    orbit_equations,
    walked_both_ways,
)
from cyclemap.maps.orbits.orbit_means import orbit_angles
from cyclemap.maps.orbits.periodic_points import Orbit, periodic_orbits

RESOLUTION = 24
_ON_ORBIT = 1e-12  # radians: residual of points that are an orbit
_ASIDE = 1e-3  # scaled arclength
MAX_PERIOD = 5_000  # cycles: orbits that are solved for all their points at once
_SAME_ORBIT = 1e-7  # radians
# a saddle-node's orbit moves with the parameter by more than this share of ∂F/∂p
_TRANSVERSE = 1e-6


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """A parameter at which a periodic orbit changes.

    Attributes
    ----------
    kind : str
        "saddle-node" (two orbits merge, multiplier 1), "period-doubling" (multiplier -1),
        "border-collision" (a point of the orbit meets a break of the map) or "branch point"
        (multiplier 1 where branches cross).
    parameter : Estimate
        Where, with a bound on its error, to first order; it holds the map's ``max_error`` and
        what ``derivative_and_error`` tells of F'; of a sampled map that is the table's slope,
        not the truth's, and period doublings and branch points move with the difference.
    points : ndarray, shape (period,)
        Radians in [0, 2π), in order of visit, the smallest first; of a border collision the one
        on the break first.
    period, winding : int
        Of the orbit.
    multiplier, left_multiplier : float
        (Fⁿ)' there; at a border collision with the slopes from the right and from the left of
        the break.
    jump : bool
        Whether the break met is a jump of the map, where the branch ends, and not a kink.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, saddle_nodes
    >>> [birth] = saddle_nodes(lambda K: CircleMap.arnold(0.1, K), (0.1, 1.5))
    >>> birth.kind, birth.parameter.holds(0.2 * np.pi), birth.folds, round(birth.theta, 6)
    ('saddle-node', True, True, 1.570796)
    """

    kind: str
    parameter: Estimate
    points: Array
    period: int
    winding: int
    multiplier: float
    left_multiplier: float
    jump: bool

    @property
    def theta(self) -> float:
        """The first of the points, radians."""
        return float(self.points[0])

    @property
    def folds(self) -> bool:
        """Whether two orbits meet and vanish here: a saddle-node, or its like at a kink.

        At a kink that is so where 1 lies between the one-sided multipliers (di Bernardo et al.
        2008, ch. 3).
        """
        if self.kind != "border-collision":
            return self.kind == "saddle-node"
        return not self.jump and (self.multiplier - 1.0) * (self.left_multiplier - 1.0) < 0.0


def _recorded(
    kind: str, equations: OrbitEquations, state: OrbitState, multipliers: tuple[float, float]
) -> Bifurcation:
    [parameter] = state.parameters
    [error] = equations.errors(state, np.zeros((0, state.at.size))) * equations.scales[-1:]
    points = np.mod(state.theta, TWO_PI)
    first = equations.point if equations.side else int(np.argmin(points))
    return Bifurcation(
        kind,
        Estimate(parameter, float(error) + 2.0 * EPS * abs(parameter)),
        read_only(np.roll(points, -first)),
        points.size,
        equations.winding,
        *multipliers,
        bool(equations.side) and equations.jumps(state),
    )


class BranchWalk(ArclengthWalk[Bifurcation]):
    """A walk along a branch of orbits, with the bifurcations that it has passed."""

    def passes(self, kind: str, state: OrbitState, shift: float, curved: float) -> None:
        """Record the orbit with multiplier 1 or -1, which is one of the branch."""
        located = replace(self.equations, kind=kind)
        at = located.state(state.at)
        if kind == "saddle-node":
            n = at.theta.size
            left, _, _ = np.linalg.svd(at.matrix[:n, :n])
            push = at.matrix[:n, n]
            if abs(float(left[:, -1] @ push)) <= _TRANSVERSE * float(np.max(np.abs(push))):
                kind = "branch point"
        self.special.append(_recorded(kind, located, at, (at.multiplier, at.multiplier)))
        self.states.append(state)

    def meets_break(self, guess: Array, solved: OrbitState | None) -> bool:
        """Whether a point collides with a break on this step, and the branch goes on from there,
        whether the step or only its prediction crosses it.
        """
        here = self.states[-1].at
        reached, member = (guess, None) if solved is None else (solved.at, solved.member)
        crossed = self.crossed(reached, member) or self.crossed(guess, None)
        if crossed is None:
            return False
        point, side, share = crossed
        located = replace(self.equations, kind="border-collision", point=point, side=side)
        near = here + share * (reached - here)
        state = located.solved(near, np.zeros((0, near.size)))
        if state is None:
            return False
        offset = state.at - here
        if offset @ self.direction <= 0.0 or np.linalg.norm(offset) > 2.0 * self.step:
            return False
        self._collides(located, state)
        return True

    def _collides(self, located: OrbitEquations, state: OrbitState) -> None:
        """Record the collision, where the branch ends at a jump; beyond a kink it goes on with the
        slopes of the far side.
        """
        beyond = replace(located, side=-located.side).state(state.at)
        right, left = (state, beyond) if located.side > 0 else (beyond, state)
        record = _recorded(located.kind, located, state, (right.multiplier, left.multiplier))
        self.special.append(record)
        self.states.append(state if record.jump else beyond)
        if record.jump:
            self.reason = "jump"
            return
        outward = curve_direction(beyond.matrix[:-1])
        leaving = -located.side * float(beyond.matrix[-1] @ outward)
        self.direction = outward if leaving >= 0.0 else -outward
        self.step = min(self.step, FIRST)


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
        Of the orbit, cycles: at most 5,000.
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
    p = within[0] if at is None else parameter_inside("at", at, within)
    if isinstance(start, Orbit):
        points = np.array(start.points)
        turns = start.winding
    else:
        n = followed_period(period)
        turns = whole_number("winding", winding)
        points = orbit_angles(family_member(family, p), finite_number("start", start), n)
    equations = orbit_equations(family, points, p, turns, within)
    first = _first_orbit(equations, np.append(points, p) / equations.scales)
    if first is None or np.max(np.abs(first.theta - points)) > 0.5:
        raise InvalidInput(
            f"no orbit of period {points.size} and winding {turns} at {p:.9g} near θ = "
            f"{points[0]:.6g}"
        )
    states, special, ends = walked_both_ways(
        lambda initial: BranchWalk(equations, [first], initial), curve_direction(first.matrix)
    )
    multiplier = read_only([state.multiplier for state in states])
    return OrbitBranch(
        read_only([state.parameters[0] for state in states]),
        read_only([state.theta for state in states]),
        multiplier,
        unwritable(np.abs(multiplier) < 1.0),
        special,
        points.size,
        turns,
        ends,
        max(float(np.max(np.abs(state.residual))) for state in states),
    )


def followed_period(period: object) -> int:
    """A period of orbits that are to be followed as an int, or InvalidInput."""
    n = whole_number("period", period, least=1)
    require_room("the period", n, "give a smaller one", MAX_PERIOD)
    return n


def _first_orbit(equations: OrbitEquations, at: Array) -> OrbitState | None:
    """The orbit near ``at``, its parameter held fixed; on a saddle-node, where it cannot be, a
    little along the branch.
    """
    first = equations.solved(at, np.eye(at.size)[-1])
    given = equations.state(at)
    if first is not None or np.max(np.abs(given.residual)) > _ON_ORBIT:
        return first
    along = curve_direction(given.matrix)
    ahead = (equations.solved(at + aside * along, along) for aside in (_ASIDE, -_ASIDE))
    return next((state for state in ahead if state is not None), None)


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
        Of the orbits, cycles: at most 5,000.
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
    n = followed_period(period)
    w = whole_number("winding", winding)
    branches: list[OrbitBranch] = []

    def known(branch: OrbitBranch, p: float, orbit: Orbit) -> bool:
        """Whether the branch passes through the orbit, solved where the branch crosses the
        parameter.
        """
        before = branch.parameter[:-1] - p
        after = branch.parameter[1:] - p
        for i in np.flatnonzero((before * after <= 0.0) & (before != after)):
            share = before[i] / (before[i] - after[i])
            near = (1.0 - share) * branch.points[i] + share * branch.points[i + 1]
            equations = orbit_equations(family, near, p, branch.winding, within)
            at = np.append(near, p) / equations.scales
            solved = equations.solved(at, np.eye(at.size)[-1])
            if solved is not None and same_orbit(solved.theta, orbit.points, _SAME_ORBIT):
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
            if regular and not any(known(branch, float(p), orbit) for branch in branches):
                branches.append(follow_orbit(family, orbit, within, at=float(p)))
    return branches


def same_orbit(points: Array, other: Array, tolerance: float) -> bool:
    """Whether two orbits, radians, are the same but for whole turns and the first point."""
    gaps = (shorter_way(np.roll(points, -k) - other) for k in range(points.size))
    return any(float(np.max(np.abs(gap))) <= tolerance for gap in gaps)
