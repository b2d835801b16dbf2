"""What cannot be had better without paying more: the non-dominated ones of many candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, finite_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.suggestions import unknown_name

Array = NDArray[np.float64]


def non_dominated(points: ArrayLike) -> NDArray[np.bool_]:
    """Return which of the points (n, d) no other dominates, (n,): none is as low in all coordinates and lower in one.

    Points alike do not dominate each other. In lexicographic order a point can be dominated by earlier ones only, and
    then by one that is itself not dominated (Kung, Luccio & Preparata 1975).

    >>> non_dominated([(1.0, 3.0), (2.0, 2.0), (2.0, 3.0)]).tolist()
    [True, True, False]
    """
    rows = finite_array("points", points, ndim=2)
    found, kept = np.zeros(len(rows), dtype=bool), np.empty((0, rows.shape[1]))
    for index in np.lexsort(rows.T[::-1]).tolist():
        row = rows[index]
        if not np.any(np.all(kept <= row, axis=1) & np.any(kept < row, axis=1)):
            found[index], kept = True, np.vstack([kept, row])
    return found


def hypervolume(points: ArrayLike, reference: ArrayLike) -> float:
    """Return the volume that points (n, d) dominate below a reference (d,): the union of the boxes between them.

    Exact, by slices along the last coordinate (Zitzler & Thiele 1998), in some n^(d - 1) steps.

    >>> hypervolume([(1.0, 2.0), (2.0, 1.0)], (3.0, 3.0))
    3.0
    """
    corner = finite_array("reference", reference, ndim=1)
    rows = finite_array("points", points, last=corner.size, ndim=2)
    inside = rows[np.all(rows < corner, axis=1)]
    return _dominated_volume(inside[non_dominated(inside)], corner) if len(inside) else 0.0


def _dominated_volume(rows: Array, corner: Array) -> float:
    if corner.size == 1:
        return float(corner[0] - rows[:, 0].min())
    rows = rows[np.argsort(rows[:, -1], kind="stable")]
    heights = np.append(rows[1:, -1], corner[-1]) - rows[:, -1]
    slices = (
        _dominated_volume(rows[: k + 1, :-1], corner[:-1]) * height for k, height in enumerate(heights) if height > 0.0
    )
    return float(sum(slices))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A strategy, and what it was found to reach: `values` (d,), in the order of the front's names, less is better.

    title : for people, of its family or its own. strategy : None where only numbers are compared.
    """

    title: str
    values: ArrayLike
    strategy: ResetStrategy | None = None

    def __post_init__(self) -> None:
        if self.strategy is not None and not isinstance(self.strategy, ResetStrategy):
            raise InvalidInput(f"the strategy of {self.title!r} is none: {self.strategy!r}")
        object.__setattr__(self, "values", read_only(finite_array("values of a candidate", self.values, ndim=1)))


@dataclass(frozen=True, eq=False)
class ParetoFront:
    """The candidates that none of the others dominates, sorted by the first value, and those that are dominated.

    names : of the values, (d,). candidates : the front. dominated : the rest, in the order given.
    """

    names: tuple[str, ...]
    candidates: tuple[Candidate, ...]
    dominated: tuple[Candidate, ...]

    @property
    def points(self) -> Array:
        """The values of the front, (m, d)."""
        return np.array([one.values for one in self.candidates])

    @property
    def dominated_points(self) -> Array:
        """The values of the dominated ones, (n - m, d)."""
        return np.array([one.values for one in self.dominated]).reshape(len(self.dominated), len(self.names))

    def hypervolume(self, reference: ArrayLike) -> float:
        """Return the volume that the front dominates below `reference` (d,)."""
        return hypervolume(self.points, reference)

    def best(self, minimise: str, limits: Mapping[str, float] | None = None) -> Candidate | None:
        """Return the candidate least in one value, others within limits by name; None where none keeps them.

        What is best within limits is always on the front, or as good as one that is.
        """
        kept = self.points
        allowed = np.ones(len(kept), dtype=bool)
        for name, limit in (limits or {}).items():
            allowed &= kept[:, self._index(name)] <= finite_number(f"limit of {name}", limit)
        if not allowed.any():
            return None
        cost = np.where(allowed, kept[:, self._index(minimise)], np.inf)
        return self.candidates[int(np.argmin(cost))]

    def with_candidates(self, more: Sequence[Candidate]) -> ParetoFront:
        """Return the front of these candidates and more."""
        return pareto_front((*self.candidates, *self.dominated, *more), self.names)

    def _index(self, name: str) -> int:
        if name not in self.names:
            raise unknown_name("value", name, self.names)
        return self.names.index(name)


def pareto_front(candidates: Sequence[Candidate], names: Sequence[str]) -> ParetoFront:
    """Return the front of one candidate or more, each with a value for every name; all values are to be small.

    Raises InvalidInput where there is none, or one has another number of values.

    >>> front = pareto_front([Candidate("a", (0.1, 2.0)), Candidate("b", (0.2, 2.5))], ("bias", "cost"))
    >>> [one.title for one in front.candidates], [one.title for one in front.dominated]
    (['a'], ['b'])
    """
    given, called = tuple(candidates), tuple(names)
    if not given:
        raise InvalidInput("a front needs one candidate or more")
    for one in given:
        if np.size(one.values) != len(called):
            raise InvalidInput(f"{one.title!r} has {np.size(one.values)} values for the {len(called)} names {called}")
    points = np.array([one.values for one in given])
    best = non_dominated(points)
    order = [index for index in np.lexsort(points.T[::-1]).tolist() if best[index]]
    rest = tuple(one for one, kept in zip(given, best.tolist(), strict=True) if not kept)
    return ParetoFront(called, tuple(given[index] for index in order), rest)
