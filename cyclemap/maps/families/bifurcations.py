"""The bifurcations of periodic orbits in a range of one parameter, listed; those at which a
parameter that moves slowly takes stable points away, and how late that shows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.continuation import (
    RESOLUTION,
    Bifurcation,
    orbit_branches,
    same_orbit,
)
from cyclemap.maps.families.family import (
    Family,
    Range,
    family_member,
    parameter_range,
    parameter_tangent,
)
from cyclemap.maps.lifts.lift_checks import differences
from cyclemap.maps.orbits.periodic_points import periodic_orbits

# radians: at a fold two findings of one orbit may differ by the root of rounding
_SAME_POINT = 1e-4
_SAME_PARAMETER = 1e-9  # of the range
_WIDEST = 1e-6  # of the range: the bound of a saddle-node that is worth a proof


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
        Of the orbits, cycles: at most 5,000.
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
    met: list[Bifurcation] = []
    for branch in orbit_branches(family, (low, high), period, winding, resolution=resolution):
        for special in branch.special:
            again = any(
                special.kind == other.kind
                and abs(special.parameter - other.parameter) <= _SAME_PARAMETER * (high - low)
                and same_orbit(special.points, other.points, _SAME_POINT)
                for other in met
            )
            if not again:
                met.append(special)
    return sorted(met, key=lambda special: float(special.parameter))


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
        Of the orbits, cycles: at most 5,000.
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
    met = bifurcations(family, within, period, winding, resolution=resolution)
    folds = [special for special in met if special.kind == "saddle-node"]
    return [_proved_fold(family, fold, within) for fold in folds] if proved else folds


def _proved_fold(family: Family, fold: Bifurcation, within: Range) -> Bifurcation:
    centre = float(fold.parameter)
    counts = [0, 0]
    half = max(fold.parameter.error_bound, EPS * (within[1] - within[0]))
    while half <= _WIDEST * (within[1] - within[0]):
        ends = [float(np.clip(centre + side * half, *within)) for side in (-1.0, 1.0)]
        try:
            for side, end in enumerate(ends):
                member = family_member(family, end)
                # Of other degrees the winding depends on which point comes first.
                winding = fold.winding if member.degree == 1 else None
                orbits = periodic_orbits(member, fold.period, winding, proved=True)
                counts[side] = len(orbits)
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
        Of the orbits, cycles: at most 5,000.
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
    met = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [special for special in met if special.kind == "period-doubling"]


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
        Of the orbits, cycles: at most 5,000.
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
    met = bifurcations(family, parameters, period, winding, resolution=resolution)
    return [special for special in met if special.kind == "border-collision"]


_AIRY = 2.338107410459767  # the first zero of Ai(-x)
_STEP = 1e-5  # of the range: for differences of F


@dataclass(frozen=True, eq=False)
class SlowFold:
    """A saddle-node at which a parameter that moves takes a stable fixed point away.

    Attributes
    ----------
    fold : Bifurcation
        The saddle-node, its parameter with a bound.
    delay_cycles : float
        How many cycles after the parameter has passed it the path has left.
    parameter : float
        The parameter by then.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, slow_folds
    >>> [lost] = slow_folds(lambda omega: CircleMap.arnold(omega, 0.9), (0.0, 0.3), 1e-7)
    >>> lost.fold.kind, round(lost.parameter - lost.fold.parameter, 7)
    ('saddle-node', 3.56e-05)
    """

    fold: Bifurcation
    delay_cycles: float
    parameter: float


def slow_folds(
    family: Family, parameters: Range, rate: float = 1.0, winding: int = 0
) -> list[SlowFold]:
    """Where a family whose parameter moves slowly loses fixed points, in the order in which it
    does.

    Parameters
    ----------
    family : callable
        p → CircleMap; ``drifting.at`` of a ``DriftingMap`` is one, with the cycle as parameter
        and a rate of 1, whose quasi-static fixed points ``orbit_branches`` follows.
    parameters : tuple[float, float]
        (low, high), in which folds are sought.
    rate : float, default 1.0
        Change of the parameter a cycle, not 0.
    winding : int, default 0
        Whole turns a cycle of the fixed points.

    Returns
    -------
    list of SlowFold
        Those saddle-nodes at which two fixed points vanish as the parameter moves, not those at
        which two are born.

    Raises
    ------
    InvalidInput
        For a rate of 0, and as ``saddle_nodes`` does.

    Notes
    -----
    Beside a fold θ' = θ + a(θ - θ*)² + b(p - p*): as p moves the path is gone Ω₀ (a b rate)^(-1/3)
    cycles after the crossing, Ω₀ = 2.338 the first zero of Ai(-x), so that the parameter overshoots
    by Ω₀ rate^(2/3) (b² a)^(-1/3) (the 2/3 law of slow passage: Haberman 1979; Kuehn 2015, ch. 5).
    That holds for slow rates and without noise, which makes a path leave earlier; ``delay_cycles``
    is the leading order, next to which a few cycles over a are left out.

    References
    ----------
    - Haberman, R. (1979), Slowly varying jump and transition phenomena associated with algebraic
      bifurcation problems, SIAM Journal on Applied Mathematics 37.
    - Kuehn, C. (2015), Multiple time scale dynamics, chapter 5.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, slow_folds
    >>> [lost] = slow_folds(lambda omega: CircleMap.arnold(omega, 0.9), (0.0, 0.3), 1e-7)
    >>> lost.fold.parameter.holds(0.9 / (2 * np.pi)), round(lost.delay_cycles)
    (True, 356)
    """
    within = parameter_range("parameters", parameters)
    speed = finite_number("rate", rate)
    if speed == 0.0:
        raise InvalidInput(
            "rate is 0: a parameter that stands still loses nothing; give its change a cycle"
        )
    lost = []
    for fold in saddle_nodes(family, within, 1, winding):
        p = float(fold.parameter)
        theta = fold.points
        member = family_member(family, p)
        bend = 0.5 * float(differences(member.derivative, member.breaks, theta)[0][0])
        push = float(parameter_tangent(family, p, _STEP, within)(theta)[0]) * speed
        if bend * push > 0.0:  # else two fixed points are born
            delay = _AIRY * (bend * push) ** (-1.0 / 3.0)
            lost.append(SlowFold(fold, delay, p + speed * delay))
    return lost[:: 1 if speed > 0.0 else -1]
