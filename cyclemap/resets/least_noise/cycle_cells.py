"""The circle cut into cells, and where one cycle takes them: what the programmes and their bounds are built on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps.algebra.branches import branches
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise

MOST_PARTS = 1 << 16  # of the circle; the proven bounds are apart by at least about a part's width
_NEGLIGIBLE = 1e-8  # entries that the solver would drop: left out before the columns are scaled to one


@dataclass(frozen=True, eq=False)
class CycleCells:
    """``cells`` equal cells, each cut into an even number of parts, at most 65,536 in all; and where F takes them.

    circle_map : F. target : the density wanted, per radian, None for uniform. own_noise : the law of what the cycle
    itself adds after F, None for nothing.
    A law "on the cells" has in each cell the shape of the target: then its distance in total variation from the
    target is that of the cells' masses, exactly.
    """

    circle_map: CircleMap
    cells: int
    target: Callable[[Array], Array] | None = None
    own_noise: Noise | None = None

    @property
    def parts(self) -> int:
        """Parts of the whole circle."""
        return 2 * self.cells * (MOST_PARTS // (2 * self.cells))

    @property
    def width(self) -> float:
        """Of a cell, radians."""
        return TWO_PI / self.cells

    @property
    def part_width(self) -> float:
        """Radians."""
        return TWO_PI / self.parts

    @cached_property
    def centres(self) -> Array:
        """(cells,): the cells' middles, radians."""
        return np.asarray((np.arange(self.cells) + 0.5) * self.width)

    @cached_property
    def middles(self) -> Array:
        """(parts,): the parts' middles, radians."""
        return np.asarray((np.arange(self.parts) + 0.5) * self.part_width)

    @cached_property
    def part_masses(self) -> Array:
        """(parts,): the target's mass in every part."""
        if self.target is None:
            return np.full(self.parts, 1.0 / self.parts)
        law = CircularLaw(self.target, max(2048, self.parts // 4))
        return np.maximum(law.bin_probabilities(self.parts), 0.0)

    @cached_property
    def target_masses(self) -> Array:
        """(cells,): the target's mass in every cell."""
        return np.asarray(self.by_cell(self.part_masses).sum(axis=1))

    @cached_property
    def shares(self) -> Array:
        """(parts,): the part of its cell's mass that each part has."""
        masses, whole = self.by_cell(self.part_masses), self.target_masses[:, None]
        even = np.full(masses.shape, self.cells / self.parts)
        return np.asarray(np.divide(masses, whole, out=even, where=whole > 0.0).ravel())

    @cached_property
    def images(self) -> Array:
        """(parts,): F at the parts' middles, lifted."""
        return self.circle_map(self.middles)

    @cached_property
    def image_reach(self) -> Array:
        """(parts,): a bound on |F(θ) - F(middle)| for θ in the part, and on the map's own error.

        F is monotone between its breaks and folds, so the ends of every piece are enough.
        """
        ends = np.arange(self.parts + 1) * self.part_width
        reach = np.maximum(
            np.abs(self.circle_map.right(ends[:-1]) - self.images), np.abs(self.circle_map.left(ends[1:]) - self.images)
        )
        turns = np.array([part.start for part in branches(self.circle_map)])
        turns = np.mod(np.append(turns, self.circle_map.breaks), TWO_PI)
        inside = np.minimum((turns / self.part_width).astype(np.int64), self.parts - 1)
        for side in (self.circle_map.left(turns), self.circle_map.right(turns)):
            np.maximum.at(reach, inside, np.abs(side - self.images[inside]))
        return reach + self.circle_map.max_error

    def by_cell(self, values: Array) -> Array:
        """(cells, parts a cell) from (parts,)."""
        return values.reshape(self.cells, -1)

    def spread_over_parts(self, masses: Array) -> Array:
        """(parts,) masses of the law on the cells with masses (cells,)."""
        return np.asarray(np.repeat(masses, self.parts // self.cells) * self.shares)

    # -- matrices on the cells -----------------------------------------------------------------------------

    @cached_property
    def before(self) -> Any:
        """(cells, cells): from a law on the cells to its integrals against the hat functions at the centres."""
        return self._averaged(self.middles)

    @cached_property
    def after(self) -> Any:
        """The same one cycle later. Hat functions sum to one, so that no mass is lost."""
        moved = self._averaged(self.images)
        if self.own_noise is None:
            return moved
        turned = circulant(noise_masses(self.own_noise, self.cells)) @ moved.toarray()
        turned[turned < _NEGLIGIBLE] = 0.0
        return csr_matrix(turned / turned.sum(axis=0))

    def _averaged(self, angles: Array) -> Any:
        place = angles / self.width - 0.5
        below = np.floor(place)
        ahead, column = place - below, np.repeat(np.arange(self.cells), self.parts // self.cells)
        rows = np.concatenate([below, below + 1.0]).astype(np.int64) % self.cells
        values = np.concatenate([self.shares * (1.0 - ahead), self.shares * ahead])
        return coo_matrix((values, (rows, np.tile(column, 2))), shape=(self.cells, self.cells)).tocsr()


def noise_masses(noise: Noise, count: int) -> Array:
    """(count,): P(ξ in the arc of width 2π/count about 2πk/count), k from 0."""
    edges = (np.arange(count + 1) - 0.5) * (TWO_PI / count)
    masses = np.maximum(noise.arc_probability(edges[:-1], edges[1:]), 0.0)
    return np.asarray(masses / np.sum(masses))


def circulant(masses: Array) -> Array:
    """(n, n): the matrix of the circular convolution with ``masses``, (n,)."""
    index = np.arange(masses.size)
    return np.asarray(masses[(index[:, None] - index) % masses.size])


def checked_own_noise(noise: Any) -> Noise | None:
    """A noise, or None, or InvalidInput."""
    if noise is not None and not isinstance(noise, Noise):
        raise InvalidInput(f"own_noise is {noise!r}: give the law of what the cycle adds, or None for nothing")
    return noise
