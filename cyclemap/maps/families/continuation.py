"""Following a periodic orbit through a family of maps, round folds, by pseudo-arclength continuation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array, shorter_way
from cyclemap.maps.families.branch_walk import BranchWalk
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState, orbit_equations
from cyclemap.maps.families.parameter_tangent import Family, Range, family_member, parameter_range
from cyclemap.maps.families.special_points import Bifurcation
from cyclemap.maps.orbits.periodic_orbits import Orbit

MAX_STEPS = 4_000
_ON_ORBIT = 1e-12  # radians: residual of points that are an orbit
_ASIDE = 1e-3  # scaled arclength


@dataclass(frozen=True, eq=False)
class OrbitBranch:
    """A branch of periodic orbits, in order along it.

    parameter : shape (m,). points : shape (m, period), radians, continuous along the branch (any turn), in order of
    visit. multiplier : shape (m,). stable : shape (m,), whether |multiplier| < 1. arclength : shape (m,), length
    in the space (θ/√period, p/(high - low)), 0 at the first.
    special : the bifurcations met, in order. period, winding : of the orbits.
    ends : why the branch ends at its two ends: "end of the range", "jump" (a point meets a jump of the map),
        "half the period" (it merges with an orbit of half its period), "closed" (it is a loop), "lost" (no step
        converged) or "steps" (more than were allowed).
    residual : the largest |F(θ_i) - θ_{i+1} - 2πh_i| of all, radians.
    """

    parameter: Array
    points: Array
    multiplier: Array
    stable: npt.NDArray[np.bool_]
    arclength: Array
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
    max_steps: int = MAX_STEPS,
) -> OrbitBranch:
    """The branch of periodic orbits through ``start``, followed both ways within the parameters (low, high).

    start : an orbit of the family's map at the parameter ``at`` (default: low), or an angle near a point of one, then
    with its ``period`` and ``winding``.

    F(θ_i; p) = θ_{i+1} + 2πh_i is solved for all points of the orbit at once and followed in its arclength
    (Keller 1977), so that folds in p are passed and every point is correct to rounding. Steps are halved where
    Newton's method fails, the direction turns by more than 18° or the multiplier changes fast, and grow elsewhere
    up to 0.08 in units of (θ, p/(high - low)). Saddle-nodes, period doublings and branch points are where the
    multiplier passes ±1; border collisions where a point passes a break: beyond a kink the branch goes on
    with the far side's slope, at a jump it ends. What happens twice within one step is missed.

    Raises InvalidInput when there is no such orbit at ``at``, ConvergenceError when a bifurcation cannot be located.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> fold = follow_orbit(lambda omega: CircleMap.arnold(omega, 0.9), 0.0, (-0.2, 0.2), at=0.0)
    >>> [b.kind for b in fold.special], fold.ends
    (['saddle-node', 'saddle-node'], ('closed', 'closed'))
    """
    within = parameter_range("parameters", parameters)
    p = within[0] if at is None else finite_number("at", at)
    if not within[0] <= p <= within[1]:
        raise InvalidInput(f"at is {p:g}, outside the parameters ({within[0]:g}, {within[1]:g}): start inside")
    steps = whole_number("max_steps", max_steps, least=1)
    equations, first = _start(family, start, p, within, period, winding)
    direction = equations.direction(first.slopes, equations.push(p)(first.theta))
    forward = BranchWalk(equations, first, direction, steps).walked()
    if forward.reason == "closed":
        return _branch(equations, forward.states, forward.special, ("closed", "closed"))
    backward = BranchWalk(equations, first, -direction, steps).walked()
    return _branch(
        equations,
        backward.states[:0:-1] + forward.states,
        backward.special[::-1] + forward.special,
        (backward.reason, forward.reason),
    )


def _start(
    family: Family, start: Orbit | float, p: float, within: Range, period: int, winding: int
) -> tuple[OrbitEquations, OrbitState]:
    if isinstance(start, Orbit):
        points, turns = np.array(start.points), start.winding
    else:
        n, turns = whole_number("period", period, least=1), whole_number("winding", winding)
        points = _visited(family, finite_number("start", start), p, n)
    equations = orbit_equations(family, points, p, turns, within)
    first = equations.solved_at(p, points) or _beside_fold(equations, equations.state(p, points))
    if first is None or float(np.max(np.abs(first.theta - points))) > 0.5:
        raise InvalidInput(f"no orbit of period {points.size} and winding {turns} at {p:.9g} near θ = {points[0]:.6g}")
    return equations, first


def _beside_fold(equations: OrbitEquations, given: OrbitState) -> OrbitState | None:
    """A state a little along the branch from one on a saddle-node, where p cannot be held fixed."""
    if float(np.max(np.abs(equations.residual(given.member(given.theta), given.theta)))) > _ON_ORBIT:
        return None
    direction = equations.direction(given.slopes, equations.push(given.parameter)(given.theta))
    ahead = (equations.solved_along(equations.point(given) + k * _ASIDE * direction, direction) for k in (1, -1))
    return next((state for state in ahead if state is not None), None)


def _visited(family: Family, theta: float, p: float, count: int) -> Array:
    member, points = family_member(family, p), [theta]
    for _ in range(count - 1):
        points.append(float(np.mod(member(points[-1]), TWO_PI)))
    return np.array(points)


def _branch(
    equations: OrbitEquations, states: list[OrbitState], special: list[Bifurcation], ends: tuple[str, str]
) -> OrbitBranch:
    scaled = np.array([equations.point(state) for state in states])
    lengths = np.linalg.norm(np.diff(scaled, axis=0), axis=1)
    multiplier = read_only([state.multiplier for state in states])
    residuals = [equations.residual(state.member(state.theta), state.theta) for state in states if not _on_jump(state)]
    return OrbitBranch(
        read_only([state.parameter for state in states]),
        read_only([state.theta for state in states]),
        multiplier,
        np.abs(multiplier) < 1.0,
        read_only(np.append(0.0, np.cumsum(lengths))),
        tuple(special),
        equations.period,
        equations.winding,
        ends,
        float(np.max(np.abs(residuals))),
    )


def _on_jump(state: OrbitState) -> bool:
    gaps = shorter_way(state.theta[:, None] - state.member.breaks)
    return bool(np.any(np.abs(gaps) < 1e-9))
