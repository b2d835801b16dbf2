"""What one sees first of a family of maps: where its orbits settle, and whether they diverge, over its parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.families.parameter_tangent import Family, family_member
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.parametric_lift import parametric_form
from cyclemap.maps.rotation.rotation_number import orbit_angles

_START = 0.9  # radians: an angle that no symmetry favours
_BATCHES = 20
_DEVIATIONS = 4.0  # standard errors of the batches' mean


@dataclass(frozen=True, eq=False)
class OrbitDiagram:
    """Made by ``orbit_diagram``. parameter : shape (m,). theta : shape (m, cycles), radians in [0, 2π)."""

    parameter: Array
    theta: Array


@dataclass(frozen=True, eq=False)
class LyapunovExponents:
    """Made by ``lyapunov_exponents``: arrays of the parameters' broadcast shape.

    value : mean of ln|F'| along one orbit, per cycle; -inf where it meets F' = 0. error : four standard errors of the
    means over 20 parts of the orbit: statistical where it is chaotic, and no bound.
    """

    parameters: tuple[Array, ...]
    value: Array
    error: Array


def orbit_diagram(
    family: Family, values: Any, *, cycles: int = 200, transient: int = 500, start: float = _START
) -> OrbitDiagram:
    """Where the orbit of each member of a family is in ``cycles`` cycles, after ``transient`` cycles that are left out.

    family : parameter → CircleMap. values : shape (m,), in the order in which they are gone through: each orbit starts
    where the one before has ended (the first at ``start``, radians), so that an attractor is followed for as long
    as it lasts; through the values in reverse order the other branch of a hysteresis loop shows.

    Raises InvalidInput for values that are not finite, none at all, or a family that gives no CircleMap.

    >>> flips = orbit_diagram(lambda K: CircleMap.arnold(0.1, K), [1.8, 2.2], transient=2000)
    >>> [np.unique(row.round(6)).size for row in flips.theta]  # the period doubles at K = 2.0964
    [1, 2]
    """
    rows, count = finite_array("values", values, ndim=1), whole_number("cycles", cycles, least=1)
    skipped, theta = whole_number("transient", transient, least=0), finite_number("start", start)
    if rows.size == 0:
        raise InvalidInput("values is empty: give the parameters to go through")
    visited = np.empty((rows.size, count))
    for row, value in zip(visited, rows.tolist(), strict=True):
        row[:] = orbit_angles(family_member(family, value), theta, skipped + count)[skipped:]
        theta = float(row[-1])
    return OrbitDiagram(read_only(rows), read_only(visited))


def lyapunov_exponents(
    family: Callable[..., CircleMap],
    *parameters: Any,
    cycles: int = 2_000,
    transient: int = 500,
    start: float = _START,
) -> LyapunovExponents:
    """The Lyapunov exponents of the orbits of ``start`` (radians) over arrays of parameters that broadcast together.

    family : parameters → CircleMap. A ``ParametricLift`` that has a derivative, ``CircleMap.arnold`` and
    ``CircleMap.moebius`` are followed all together, others one by one, a hundred times slower. One array gives a
    curve, ``values[:, None]`` and another one a plane. The mean of ln|F'| over ``cycles`` cycles after
    ``transient`` ones: good to about 1/cycles on periodic orbits; ``lyapunov_exponent`` solves one map's far better.

    Raises InvalidInput for parameters that are not finite, none at all, or a family that gives no CircleMap.

    >>> found = lyapunov_exponents(CircleMap.arnold, 0.1, [0.9, 5.0])
    >>> bool(found.value[0] < -1.0 < 1.0 < found.value[1])
    True
    """
    if not parameters:
        raise InvalidInput("parameters are missing: give an array for each parameter of the family")
    arrays = [finite_array(f"parameter {i}", values) for i, values in enumerate(parameters)]
    count, skipped = whole_number("cycles", cycles, least=_BATCHES), whole_number("transient", transient, least=0)
    theta = finite_number("start", start)
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    flat = [np.broadcast_to(array, shape).ravel() for array in arrays]
    formula = parametric_form(family)
    parts = np.zeros((_BATCHES, flat[0].size))
    lengths = np.diff(np.linspace(0, count, _BATCHES + 1).astype(int))
    if formula is not None and formula.derivative is not None:
        angle = np.full(flat[0].size, theta)
        for _ in range(skipped):
            angle = np.mod(formula.lift(angle, *flat), TWO_PI)
        for part, length in zip(parts, lengths.tolist(), strict=True):
            for _ in range(length):
                part += _log(formula.derivative(angle, *flat))
                angle = np.mod(formula.lift(angle, *flat), TWO_PI)
    else:
        for place, values in enumerate(zip(*(array.tolist() for array in flat), strict=True)):
            member = family_member(family, *values)
            visited = orbit_angles(member, theta, skipped + count)[skipped:]
            parts[:, place] = np.add.reduceat(_log(member.derivative(visited)), np.cumsum(lengths) - lengths)
    means = parts / lengths[:, None]
    with np.errstate(invalid="ignore"):
        error = _DEVIATIONS * np.std(means, axis=0, ddof=1) / np.sqrt(_BATCHES)
    value = parts.sum(axis=0) / count
    error = np.where(np.isneginf(value), 0.0, error)
    return LyapunovExponents(
        tuple(read_only(array) for array in arrays), read_only(value.reshape(shape)), read_only(error.reshape(shape))
    )


def _log(slope: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.log(np.abs(slope))
