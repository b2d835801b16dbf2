"""Arnold tongues: for which parameters of a family an orbit of rotation number p/q exists."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.families.parameter_tangent import Family, Range, parameter_range
from cyclemap.maps.families.tongue_edges import EdgeSearch

RESOLUTION = 128
_WIDENING = 8.0  # by how much a bracket that misses the edge grows


@dataclass(frozen=True)
class Tongue:
    """The tongue p/q of a one-parameter family: the parameters at which an orbit of rotation number p/q exists.

    ratio : p/q, turns a cycle. left, right : its edges, in the parameter's unit.
    left_theta, right_theta : a point, radians in [0, 2π), of the orbit that is born at each edge.
    folded : whether the map folds at an edge. If not, the rotation number is p/q all through the tongue and
        nowhere else (locking); if it does, p/q is one of an interval of rotation numbers, and tongues overlap.
    """

    ratio: Fraction
    left: Estimate
    right: Estimate
    left_theta: float
    right_theta: float
    folded: bool

    @property
    def width(self) -> Estimate:
        """right - left, zero where they agree within rounding; its bound is the sum of theirs."""
        return Estimate(max(self.right - self.left, 0.0), self.left.error_bound + self.right.error_bound)


@dataclass(frozen=True, eq=False)
class TongueBoundaries:
    """The edges of several tongues as curves over a second parameter.

    ratios : the p/q, k of them. second : shape (m,), the second parameter's values.
    left, right : shape (k, m), the edges in the first parameter. left_error, right_error : bounds on their errors.
    folded : shape (k, m), whether the map folds at an edge there (see ``Tongue``).
    """

    ratios: tuple[Fraction, ...]
    second: Array
    left: Array
    right: Array
    left_error: Array
    right_error: Array
    folded: npt.NDArray[np.bool_]

    @property
    def width(self) -> Array:
        """right - left, shape (k, m), zero where the edges agree within rounding."""
        return np.maximum(self.right - self.left, 0.0)


def tongue(family: Family, ratio: Any, parameters: Range, *, resolution: int = RESOLUTION) -> Tongue:
    """The edges of the tongue p/q of a family whose lifts nowhere fall as the parameter grows.

    family : parameter → CircleMap of degree 1. ratio : a Fraction, a whole number, or (p, q) in lowest terms.
    parameters : (low, high), with the whole tongue inside; the family is called only there.
    resolution : cells a turn at least in the search for extrema of F^q - id.

    Left edge: where the largest value of F^q - id - 2πp over the circle reaches 0; right edge: where the
    least does (Arnold 1965; Herman 1977). At a smooth edge a saddle-node of period q is born, at a kink or jump
    a border collision. Where F folds, the same of its monotone envelopes: the left edge of F⁺ and the right
    edge of F⁻ bound the parameters whose rotation interval holds p/q, where for a continuous lift an orbit
    of that rotation number exists (Boyland 1986). Both extrema are monotone in the parameter, so each edge is
    bracketed to neighbouring floats. A tongue narrower than rounding has width 0 and the bound says how narrow.

    The error bounds add the bracket, the lift's rounding (a lift moved by δ moves the edge by at most δ over
    the least ∂F/∂p; taken to first order along the edge's orbit), some 2e-15 for ``arnold``, and what the search for
    extrema may have missed just outside the edge: since F^q does not fall, no value between two samples exceeds the
    second by more than their distance, and samples are added until that rules every other hump out (proved). Where
    4096 samples cannot, as near the top itself or in a tongue next to nothing wide, F^q counts as smooth where a
    quartic meets five neighbours to rounding: humps narrower than half a milliradian, and no higher, may hide there.
    The bounds hold for the family as given: ``max_error`` is not added.

    Raises InvalidInput when an edge lies outside the range or the family is seen to fall.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> locked = tongue(lambda omega: CircleMap.arnold(omega, 0.9), (0, 1), (-0.5, 0.5))
    >>> locked.right.holds(0.9 / (2 * np.pi)), locked.right.error_bound < 1e-14
    (True, True)
    """
    wanted, within = rotation_ratio(ratio), parameter_range("parameters", parameters)
    nodes = whole_number("resolution", resolution, least=16)
    edges = []
    for side in ("left", "right"):
        search = EdgeSearch(family, wanted, side, nodes, within)
        search.require_inside()
        edges.append(search.edge(*within))
    left, right = edges
    first, last = (Estimate(edge.parameter, edge.error) for edge in edges)
    return Tongue(wanted, first, last, left.theta, right.theta, left.folded or right.folded)


def rotation_ratio(ratio: Any) -> Fraction:
    """p/q as a Fraction, from a Fraction, a whole number or a pair (p, q) in lowest terms, q ≥ 1.

    >>> rotation_ratio((2, 5))
    Fraction(2, 5)
    """
    if isinstance(ratio, Fraction):
        return ratio
    if isinstance(ratio, (int, np.integer)):
        return Fraction(whole_number("ratio", ratio))
    if not isinstance(ratio, Sequence) or isinstance(ratio, str) or len(ratio) != 2:
        raise InvalidInput(f"ratio is {ratio!r}: give a Fraction, a whole number or a pair (p, q)")
    p, q = whole_number("p", ratio[0]), whole_number("q", ratio[1])
    if q < 1 or gcd(p, q) != 1:
        raise InvalidInput(f"ratio is {p}/{q}: give p/q in lowest terms with q of at least 1")
    return Fraction(p, q)


# -- over a second parameter -----------------------------------------------------------------------------------


def tongues(
    family: Family, ratios: Sequence[Any], second: Any, parameters: Range, *, resolution: int = RESOLUTION
) -> TongueBoundaries:
    """The edges of the tongues ``ratios`` of a family (p, q) → CircleMap, for each value q of ``second``.

    family : nowhere falling in its first parameter. second : shape (m,), in the order in which it is
    followed: each edge is sought near the line through the last two. parameters : (low, high) of the first
    parameter, with every edge inside. Accuracy, bounds and errors raised as in ``tongue``.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> edges = tongues(CircleMap.arnold, [0, (1, 2)], [0.4, 0.8], (-0.5, 1.0))
    >>> bool(np.all(np.abs(edges.right[0] - np.array([0.4, 0.8]) / (2 * np.pi)) <= edges.right_error[0]))
    True
    """
    wanted = tuple(rotation_ratio(ratio) for ratio in ratios)
    values = finite_array("second", second, ndim=1)
    low, high = parameter_range("parameters", parameters)
    nodes = whole_number("resolution", resolution, least=16)
    if not wanted or values.size == 0:
        raise InvalidInput(f"{len(wanted)} ratios and {values.size} values of the second parameter: give some of each")
    found = np.empty((2, len(wanted), values.size, 3))
    for s, side in enumerate(("left", "right")):
        for i, ratio in enumerate(wanted):
            found[s, i] = _curve(family, ratio, side, values, (low, high), nodes)
    (left, left_error), (right, right_error) = (
        tuple(map(read_only, side[..., :2].transpose(2, 0, 1))) for side in found
    )
    folded = np.any(found[..., 2] > 0.0, axis=0)
    return TongueBoundaries(wanted, read_only(values), left, right, left_error, right_error, folded)


def _curve(family: Family, ratio: Fraction, side: str, second: Array, within: Range, resolution: int) -> Array:
    """(m, 3): parameter, error and folding of one edge at every value of the second parameter."""
    rows = np.empty((second.size, 3))
    for j, value in enumerate(second):
        search = EdgeSearch(_at(family, float(value)), ratio, side, resolution, within)
        search.require_inside()
        edge = search.edge(*_bracket(search, rows[:j, 0], within))
        rows[j] = edge.parameter, edge.error, edge.folded
    return rows


def _at(family: Family, value: float) -> Callable[[float], Any]:
    return lambda p: family(p, value)


def _bracket(search: EdgeSearch, before: Array, within: Range) -> Range:
    """A bracket of the edge round the line through the edges before it, widened until it holds the edge."""
    if before.size < 2:
        return within
    guess = 2.0 * before[-1] - before[-2]
    reach = 0.1 * abs(before[-1] - before[-2]) + 1e-9 * (within[1] - within[0])
    while True:
        low, high = max(within[0], guess - reach), min(within[1], guess + reach)
        if (low, high) == within or (low < high and search.value(low) < 0.0 <= search.value(high)):
            return low, high
        reach *= _WIDENING
