"""Saddle-nodes, period doublings and border collisions of a family of circle maps over a parameter range."""

from __future__ import annotations

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import whole_number
from cyclemap.maps.families.continuation import OrbitBranch, follow_orbit
from cyclemap.maps.families.orbit_equations import OrbitEquations
from cyclemap.maps.families.parameter_tangent import Family, Range, family_member, parameter_range
from cyclemap.maps.families.special_points import Bifurcation
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.periodic_points import Orbit, periodic_orbits

RESOLUTION = 24
_SAME_ORBIT = 1e-7  # radians
_SAME_POINT = 1e-4  # radians: at a fold two findings of one orbit may differ by the root of rounding
_SAME_PARAMETER = 1e-9  # of the range


def orbit_branches(
    family: Family, parameters: Range, period: int = 1, winding: int = 0, *, resolution: int = RESOLUTION
) -> list[OrbitBranch]:
    """All branches of periodic orbits of this period and winding within the parameters (low, high).

    All orbits are listed at ``resolution + 1`` evenly spaced parameters (``periodic_orbits``); one that lies on no
    branch found so far starts a new one (``follow_orbit``). So a branch is lost only when it lives and dies between two
    neighbouring ones of these parameters, or where ``periodic_orbits`` would lose it. An orbit that is neutral or
    on a kink just at one of them is left to the next.

    Raises InvalidInput as these two do, for instance where the map's iterate is the identity.

    >>> [branch.ends for branch in orbit_branches(lambda K: CircleMap.arnold(0.1, K), (0.5, 1.5))]
    [('end of the range', 'end of the range')]
    """
    within = parameter_range("parameters", parameters)
    n, w = whole_number("period", period, least=1), whole_number("winding", winding)
    branches: list[OrbitBranch] = []
    for p in np.linspace(*within, whole_number("resolution", resolution, least=1) + 1):
        member = family_member(family, float(p))
        for orbit in periodic_orbits(member, n, w):
            regular = orbit.kind in ("stable", "unstable") and orbit.multiplier == orbit.left_multiplier
            if regular and not any(_holds(family, branch, float(p), member, orbit) for branch in branches):
                branches.append(follow_orbit(family, orbit, within, at=float(p)))
    return branches


def _holds(family: Family, branch: OrbitBranch, p: float, member: CircleMap, orbit: Orbit) -> bool:
    """Whether the branch passes through the orbit, solved where the branch crosses the parameter."""
    before, after = branch.parameter[:-1] - p, branch.parameter[1:] - p
    for i in np.flatnonzero((before * after <= 0.0) & (before != after)):
        share = before[i] / (before[i] - after[i])
        near = (1.0 - share) * branch.points[i] + share * branch.points[i + 1]
        hops = np.round((member(near) - np.roll(near, -1)) / TWO_PI)
        solved = OrbitEquations(family, hops, branch.winding, (p - 1.0, p + 1.0)).solved_at(p, near, member)
        if solved is not None and _same_orbit(solved.theta, orbit.points, _SAME_ORBIT):
            return True
    return False


def _same_orbit(one: Array, other: Array, tolerance: float) -> bool:
    gaps = (shorter_way(np.roll(one, -k) - other) for k in range(one.size))
    return any(float(np.max(np.abs(gap))) <= tolerance for gap in gaps)


def bifurcations(
    family: Family, parameters: Range, period: int = 1, winding: int = 0, *, resolution: int = RESOLUTION
) -> list[Bifurcation]:
    """All bifurcations of the orbits of this period and winding within (low, high), sorted by parameter.

    Those met on all branches of ``orbit_branches``, each once; complete as these are. Each is refined by solving
    its extended system, to a residual near rounding, and carries an error bound of first order.

    >>> import numpy as np
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
            if not any(_same(found, other, _SAME_PARAMETER * (high - low)) for other in kept):
                kept.append(found)
    return sorted(kept, key=lambda found: float(found.parameter))


def _same(one: Bifurcation, other: Bifurcation, tolerance: float) -> bool:
    return (
        one.kind == other.kind
        and abs(one.parameter - other.parameter) <= tolerance
        and _same_orbit(one.points, other.points, _SAME_POINT)
    )


def saddle_nodes(
    family: Family, parameters: Range, period: int = 1, winding: int = 0, *, resolution: int = RESOLUTION
) -> list[Bifurcation]:
    """The saddle-nodes among ``bifurcations``: two orbits merge, multiplier 1.

    >>> import numpy as np
    >>> [birth] = saddle_nodes(lambda K: CircleMap.arnold(0.1, K), (0.1, 1.5))
    >>> birth.parameter.holds(0.2 * np.pi)
    True
    """
    found = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [one for one in found if one.kind == "saddle-node"]


def period_doublings(
    family: Family, parameters: Range, period: int = 1, winding: int = 0, *, resolution: int = RESOLUTION
) -> list[Bifurcation]:
    """The period doublings among ``bifurcations``: multiplier -1.

    >>> import numpy as np
    >>> [flip] = period_doublings(lambda K: CircleMap.arnold(0.1, K), (1.0, 3.0))
    >>> flip.parameter.holds(float(np.hypot(2.0, 0.2 * np.pi)))
    True
    """
    found = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [one for one in found if one.kind == "period-doubling"]


def border_collisions(
    family: Family, parameters: Range, period: int = 1, winding: int = 0, *, resolution: int = RESOLUTION
) -> list[Bifurcation]:
    """The border collisions among ``bifurcations``: a point of the orbit meets a kink or a jump of the map.

    >>> import numpy as np
    >>> def tent(p):
    ...     return CircleMap(lambda x: x + p + 0.5 * np.abs(np.mod(x + np.pi, 2 * np.pi) - np.pi), None, [0.0, np.pi])
    >>> [(one.folds, bool(one.parameter.holds(0.0))) for one in border_collisions(tent, (-1.0, 1.0))]
    [(True, True)]
    """
    found = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [one for one in found if one.kind == "border-collision"]
