"""Families whose parameter moves slowly: when a stable direction is lost at a saddle-node, and how
late that shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.families.continuation import saddle_nodes
from cyclemap.maps.families.family import (
    Family,
    Range,
    family_member,
    parameter_range,
    parameter_tangent,
)
from cyclemap.maps.families.orbit_equations import Bifurcation

_AIRY = 2.338107410459767  # the first zero of Ai(-x)
_BEND, _STEP = 1e-4, 1e-5  # radians, and of the range: for differences of F' and of F


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
        p, theta = float(fold.parameter), fold.points
        member = family_member(family, p)
        bend = float(np.diff(member.derivative(theta[0] + np.array([-_BEND, _BEND])))[0]) / (
            4.0 * _BEND
        )
        push = float(parameter_tangent(family, p, _STEP, within)(theta)[0]) * speed
        if bend * push > 0.0:  # else two fixed points are born
            delay = _AIRY * (bend * push) ** (-1.0 / 3.0)
            lost.append(SlowFold(fold, delay, p + speed * delay))
    return lost[:: 1 if speed > 0.0 else -1]
