"""Rotation numbers over a plane of two parameters: phase diagrams with their tongues."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.checks import finite_array, positive_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.parametric_lift import ParametricLift, parametric_form
from cyclemap.maps.rotation.envelopes import is_nondecreasing
from cyclemap.maps.rotation.rotation_batch import Whole, rotation_numbers
from cyclemap.maps.rotation.rotation_number import rotation_number

_AT_ONCE = 65_536  # maps between two reports of progress


@dataclass(frozen=True, eq=False)
class RotationPlane:
    """Rotation numbers over a grid of parameters, turns a cycle; arrays of shape (m, n).

    first_values, second_values : shape (m,) and (n,), the parameters of rows and of columns.
    value : the middle of [lower, upper], or what ``rotation_number`` gives for a map done by itself; where the lift
        folds, the weighted Birkhoff average of the one orbit from θ = 0.
    lower, upper : the truth lies between them; where the lift folds, all of its rotation interval does.
    period, winding : q and p where ρ = p/q is proved for every orbit, else 0 and 0.
    folded : where the lift falls somewhere, so that rotation numbers fill an interval.
    tolerance : the half-width that was asked for where the lift does not fold.
    """

    first_values: Array
    second_values: Array
    value: Array
    lower: Array
    upper: Array
    period: Whole
    winding: Whole
    folded: npt.NDArray[np.bool_]
    tolerance: float

    def locked(self, row: int, column: int) -> Fraction | None:
        """p/q where it is proved, else None."""
        period = int(self.period[row, column])
        return Fraction(int(self.winding[row, column]), period) if period else None


def rotation_plane(
    family: Callable[..., CircleMap],
    first_values: Any,
    second_values: Any,
    tolerance: float = 1e-3,
    progress: Callable[[float], None] | None = None,
) -> RotationPlane:
    """The rotation number of ``family(first, second)`` at every pair of the two axes.

    family : any callable of two numbers that gives a CircleMap of degree 1; a ``ParametricLift``, ``CircleMap.arnold``
        and ``CircleMap.moebius`` are done many maps at once (``rotation_numbers``) where the lifts do not fold, all
        else map by map (``rotation_number``), hundreds of times slower: write such a family as a ``ParametricLift``.
    first_values, second_values : shape (m,) and (n,), strictly increasing or decreasing.
    tolerance : turns a cycle, in (0, 0.1]: the wanted half-width of the enclosures where the lift does not fold.
    progress : called with the fraction done.

    Enclosures hold on the terms of ``rotation_number``; one that is wider than the tolerance shows it by its own
    ``lower`` and ``upper``. Inside the tongue p/q of the plane (Arnold 1965) ``period`` is q.

    Raises InvalidInput for axes that are empty, not finite or not monotone, and for a map that is no CircleMap of
    degree 1.

    >>> plane = rotation_plane(CircleMap.arnold, [0.0, 0.5], [0.3, 0.9])
    >>> plane.period.tolist(), plane.locked(1, 1)
    ([[1, 1], [2, 2]], Fraction(1, 2))
    """
    if not callable(family):
        raise InvalidInput(f"family is {family!r}: give a callable of two parameters that gives a CircleMap")
    first, second = _axis("first_values", first_values), _axis("second_values", second_values)
    wanted = positive_number("tolerance", tolerance)
    if wanted > 0.1:
        raise InvalidInput(f"tolerance is {wanted:g}: give at most 0.1 turns a cycle")
    shape = (first.size, second.size)
    sheet = _Sheet(family, np.repeat(first, second.size), np.tile(second, first.size), wanted, progress)
    sheet.fill()
    value, lower, upper = (read_only(part.reshape(shape)) for part in (sheet.value, sheet.lower, sheet.upper))
    period, winding, folded = sheet.period.reshape(shape), sheet.winding.reshape(shape), sheet.folded.reshape(shape)
    for part in (period, winding, folded):
        part.setflags(write=False)
    return RotationPlane(read_only(first), read_only(second), value, lower, upper, period, winding, folded, wanted)


def _axis(name: str, values: Any) -> Array:
    axis = finite_array(name, values, ndim=1)
    if axis.size == 0:
        raise InvalidInput(f"{name} is empty: give at least one value")
    steps = np.diff(axis)
    if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        turned = int(np.argmax(steps * np.sign(axis[-1] - axis[0]) <= 0.0))
        raise InvalidInput(f"{name} turns back after {axis[turned]:g}: give increasing or decreasing values, each once")
    return axis


class _Sheet:
    """The plane laid out as one row of maps, filled part by part."""

    def __init__(
        self,
        family: Callable[..., CircleMap],
        first: Array,
        second: Array,
        tolerance: float,
        progress: Callable[[float], None] | None,
    ) -> None:
        self.family, self.first, self.second, self.tolerance, self.progress = family, first, second, tolerance, progress
        self.value, self.lower, self.upper = np.empty((3, first.size))
        self.period, self.winding = np.zeros((2, first.size), dtype=np.int64)
        self.folded = np.zeros(first.size, dtype=bool)
        self._done = 0

    def fill(self) -> None:
        """Many maps at once where that is possible, then the rest map by map."""
        singly = np.ones(self.first.size, dtype=bool)
        formula = parametric_form(self.family)
        if formula is not None:
            singly = ~formula.rises(self.first, self.second)
            together = np.flatnonzero(~singly)
            for at in range(0, together.size, _AT_ONCE):
                self._fill_together(formula, together[at : at + _AT_ONCE])
        for place in np.flatnonzero(singly).tolist():
            self._fill_one(place)

    def _fill_together(self, family: ParametricLift, places: npt.NDArray[np.int64]) -> None:
        found = rotation_numbers(family, self.first[places], self.second[places], tolerance=self.tolerance)
        for name in ("value", "lower", "upper", "period", "winding"):
            getattr(self, name)[places] = getattr(found, name)
        self._report(places.size)

    def _fill_one(self, place: int) -> None:
        pair = float(self.first[place]), float(self.second[place])
        member = self.family(*pair)
        if not isinstance(member, CircleMap) or member.degree != 1:
            raise InvalidInput(f"the family gives {member!r} at {pair}: it must be a CircleMap of degree 1")
        found = rotation_number(member, iterates=max(16, int(np.ceil(1.0 / self.tolerance))), tolerance=self.tolerance)
        self.value[place], self.lower[place], self.upper[place] = found.value, found.lower, found.upper
        if found.locked is not None:
            self.period[place], self.winding[place] = found.locked.denominator, found.locked.numerator
        self.folded[place] = not is_nondecreasing(member)
        self._report(1)

    def _report(self, count: int) -> None:
        self._done += count
        if self.progress is not None:
            self.progress(self._done / self.first.size)
