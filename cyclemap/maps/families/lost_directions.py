"""How a stable direction is lost: when a parameter that moves slowly takes it away, how late that
shows, and how a resting path announces it, by the share of an error that its cycles keep.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_array, finite_number, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import ANGLE
from cyclemap.maps.families.bifurcations import saddle_nodes
from cyclemap.maps.families.continuation import Bifurcation
from cyclemap.maps.families.family import (
    Family,
    Range,
    family_member,
    parameter_range,
    parameter_tangent,
)
from cyclemap.maps.lifts.lift_checks import differences
from cyclemap.written import DIRECTION

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


LAST = 100
_LEAST = 20
_RESTS = np.pi / 2  # radians: a path that spreads over more does not rest
_GRID = np.append(
    np.linspace(-0.95, 0.95, 77), [0.97, 0.98, 0.99, 1.0]
)  # multipliers that are tried
_PATHS = 2_000
_SEED = 1
_LEVEL = 0.95


@dataclass(frozen=True)
class RestMultiplier:
    """The multiplier of the direction about which a path rests.

    Attributes
    ----------
    value : float
        Median-unbiased estimate.
    lower, upper : float
        95 % interval, in [-1, 1]: at 1 the direction is being lost, or has been.
    cycles : int
        How many it comes from.
    theta : float
        Their mean direction, radians in [0, 2π).

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import rest_multiplier
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for kick in rng.normal(0.0, 0.02, 60):
    ...     path.append(0.5 * path[-1] + kick)
    >>> rest = rest_multiplier(path)
    >>> rest.lower < rest.value < rest.upper < 1.0
    True
    """

    value: float
    lower: float
    upper: float
    cycles: int
    theta: float = field(metadata=DIRECTION)


def rest_multiplier(theta: ArrayLike, last: int = LAST) -> RestMultiplier | None:
    """The multiplier of the direction about which the last cycles of a path rest, with its
    interval.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Radians, on the lift or not.
    last : int, optional
        How many cycles are looked at, 20 or more.

    Returns
    -------
    RestMultiplier or None
        None where the cycles do not rest, and where there are fewer than 20. They rest where
        they spread over less than a quarter of a turn about their mean; a spread of 1e-13 rad
        is rounding.

    Raises
    ------
    InvalidInput
        For angles that are not finite, and fewer than 20 ``last`` cycles.

    Notes
    -----
    Beside a stable point θ' = θ* + λ(θ - θ*) + ξ: the regression of each angle on the one before
    falls short of λ by some (1 + 3λ)/n (Kendall 1954), and its distribution is skew as λ nears 1,
    so that interval and value come from the λ for which the regression seen is no rarer than 2.5 %
    on either side, and its median (Andrews 1993), by 2,000 simulated paths for each of 81 λ from
    -0.95 to 1 and lines between. Normal kicks are taken that do not depend on the past, and a map
    that does not bend over the rest.

    References
    ----------
    - Kendall, M. G. (1954), Note on bias in the estimation of autocorrelation, Biometrika 41.
    - Andrews, D. W. K. (1993), Exactly median-unbiased estimation of first order
      autoregressive/unit root models, Econometrica 61.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import rest_multiplier
    >>> rng = np.random.default_rng(0)
    >>> path = [0.0]
    >>> for kick in rng.normal(0.0, 0.02, 200):
    ...     path.append(0.8 * path[-1] + kick)
    >>> found = rest_multiplier(path)
    >>> found.lower < 0.8 < found.upper
    True
    """
    path = finite_array("theta", theta, ndim=1)
    count = whole_number("last", last, least=_LEAST)
    if path.size < _LEAST + 1:
        return None
    path = path[-count - 1 :]
    require_room("the simulated paths", _PATHS * path.size, "give a smaller last")
    middle = float(np.angle(np.mean(np.exp(1j * path))))
    away = shorter_way(path - middle)
    if not ANGLE < np.ptp(away) < _RESTS:
        return None
    seen = float(_regression(away[None])[0])
    below, median, above = _quantiles(path.size)
    value, lower, upper = (float(np.interp(seen, row, _GRID)) for row in (median, above, below))
    return RestMultiplier(
        value, -1.0 if seen < above[0] else lower, upper, path.size - 1, middle % TWO_PI
    )


def _regression(paths: Array) -> Array:
    """The slope of each angle on the one before, of paths (k, n)."""
    before = paths[:, :-1] - paths[:, :-1].mean(axis=1, keepdims=True)
    return np.asarray(np.sum(before * paths[:, 1:], axis=1) / np.sum(before**2, axis=1))


@lru_cache(maxsize=8)
def _quantiles(size: int) -> Array:
    """(3, 81): quantiles 2.5 %, 50 % and 97.5 % of the regression for each λ,
    made to rise with it."""
    rng = np.random.default_rng(_SEED)
    rows = []
    kicks = rng.standard_normal((_PATHS, size))  # the same for every λ, so that lines are smooth
    for multiplier in _GRID.tolist():
        paths = kicks.copy()
        if multiplier < 1.0:
            paths[:, 0] /= np.sqrt(1.0 - multiplier**2)
        for n in range(1, size):
            paths[:, n] += multiplier * paths[:, n - 1]
        rows.append(np.quantile(_regression(paths), [0.5 - 0.5 * _LEVEL, 0.5, 0.5 + 0.5 * _LEVEL]))
    return np.maximum.accumulate(np.array(rows).T, axis=1)
