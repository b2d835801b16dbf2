"""Means under a stationary law, with the law's error, the quadrature's and the map's in their bounds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.operator.operator_bounds import SolutionError, density_at, map_error_of_integral, moments_against
from cyclemap.maps.rounding import INTEGRAL

Rule = tuple[Array, Array]


def expected(
    error: SolutionError, function: Callable[[Array], Array], rules: tuple[Rule, Rule], direct: float
) -> Estimate:
    """E h under the law whose error is ``error``, on the finer of two rules; their difference is in the bound.

    direct : ∂h/∂F where h depends on F, for the part of the bound that the map's ``max_error`` makes.
    """
    (coarse, coarse_weight), (theta, weight) = rules
    basis, law = error.system.basis, error.law
    values = _values(function, theta)
    mass = weight * density_at(basis, theta, law)
    found = float(np.dot(mass, values))
    rough = float(np.dot(coarse_weight * _values(function, coarse), density_at(basis, coarse, law)))
    bound = abs(found - rough) + INTEGRAL * float(np.dot(np.abs(mass), np.abs(values)))
    bound += error.of_integral(values, theta, weight)
    if basis.map.max_error > 0.0:
        moments = moments_against(basis, theta, weight * values)
        bound += map_error_of_integral(error.system, law, moments, direct)
    return Estimate(found, bound)


def _values(function: Callable[[Array], Array], theta: Array) -> Array:
    if not callable(function):
        raise InvalidInput(f"function is {function!r}: give a callable of an array of angles")
    values = finite_array("the function's values", function(theta))
    if values.shape != theta.shape:
        raise InvalidInput(f"function turns shape {theta.shape} into {values.shape}: it must act entry by entry")
    return values
