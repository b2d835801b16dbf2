"""Where noise holds a path for long: nearly invariant sets of a noisy map, from its slow left
eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole, even_angles
from cyclemap.checks import read_only
from cyclemap.maps.estimate import EPS, MATRIX, Estimate
from cyclemap.maps.lifts.scan import bracketed_root
from cyclemap.maps.operator.fourier_basis import FourierDiscretisation
from cyclemap.maps.operator.spectrum import Spectrum
from cyclemap.written import DIRECTION

_REAL = 1e-9  # an eigenvalue with a smaller imaginary part is real
_SLOW = 10.0  # cycles that a slow departure from the stationary law takes at least to fall by e
_FASTER = (
    5.0  # how many times as fast all other departures fall: free diffusion has 4 between its waves
)
_VERTEX = (
    1e-9  # of the eigenfunctions at a vertex: where a flat maximum lies is known to 1e-7 radians
)
_GRID = 16  # points a mode on which sets are told apart
_ZOOMS = 4  # times that a vertex is sought on the grid, and on points 16 times as near


@dataclass(frozen=True, eq=False)
class MetastableSet:
    """A set of angles that a noisy path rarely leaves.

    Attributes
    ----------
    arcs : ndarray, shape (n, 2)
        Radians, start < end, starts in [0, 2π), sorted.
    peak : float
        The angle in it where the stationary density is largest, radians in [0, 2π).
    share : Estimate
        The stationary probability of the set.
    leaving : Estimate
        Chance a cycle of going over to another set; stays last 1/leaving cycles on average.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
    >>> wells = CircleMap(lambda theta: theta - 0.3 * np.sin(2 * theta))
    >>> held = transfer_operator(wells, WrappedNormal(0.3)).metastable_sets()
    >>> [round(well.share, 3) for well in held]
    [0.5, 0.5]
    """

    arcs: Array
    peak: float = field(metadata=DIRECTION)
    share: Estimate
    leaving: Estimate


@dataclass(frozen=True, eq=False)
class SlowChain:
    """The chain of m states that a noisy map is on the span of its m slowest left eigenfunctions
    z_k.

    χ_i, the chance of belonging to state i, is the combination Σ_k z_k ``weight[k, i]`` that is 1
    at its own vertex and 0 at the others (inner simplex algorithm: Weber & Galliat 2002; Deuflhard
    & Weber 2005). Since E z_k(θ') = λ_k z_k(θ), the chances of a cycle are Q = weight⁻¹ Λ weight,
    exactly.
    """

    basis: FourierDiscretisation
    grid: Array  # of angles, even
    values: Array  # (m,)
    left: Array  # (n, m)
    weight: Array  # (m, m)

    def chances(self, theta: Array) -> Array:
        """(points, m): every χ_i at the angles, one backward step from its coefficients."""
        return self.basis.backward(theta, self.left) / self.values @ self.weight

    def arcs(self) -> list[Array]:
        """For each state the arcs (start, end) on which its χ is the largest, found between points
        of the grid.
        """
        owner = np.argmax(self.chances(self.grid), axis=1)
        last = np.flatnonzero(owner != np.roll(owner, -1))
        before = owner[last]
        after = np.roll(owner, -1)[last]

        def lead(theta: Array, index: Whole) -> Array:
            chances = self.chances(theta)
            rows = np.arange(index.size)
            return np.asarray(chances[rows, before[index]] - chances[rows, after[index]])

        ends = bracketed_root(lead, self.grid[last], self.grid[last] + self.grid[1])
        starts = np.roll(ends, 1) - TWO_PI * (np.arange(ends.size) == 0)
        arcs = np.stack([starts, ends], axis=1) - TWO_PI * np.floor(starts / TWO_PI)[:, None]
        order = np.argsort(arcs[:, 0])
        return [read_only(arcs[order[before[order] == index]]) for index in range(self.values.size)]

    def leaving(self, spectrum: Spectrum) -> list[Estimate]:
        """For each state the chance a cycle of leaving it, the diagonal of I - Q.

        With first-order bounds on the errors, the map's ``max_error`` ε included. Of λ: its bound
        in the spectrum; of the rest of Λ what ε couples (``FourierDiscretisation.coupling``).
        Of an eigenfunction: ε max|∂E z_k(F + ξ)/∂F|, what one more backward step leaves of E z_k(F
        + ξ) - λ_k z_k (on the grid), the functions that the basis has not, rounding and the
        eigenvalue's bound, times 2Σ_j condition_j/|λ_k - λ_j| over the fast j, for what lies in the
        span of the slow ones moves nothing: measured.
        """
        back = np.linalg.inv(self.weight)
        leaving = back * (1.0 - self.values) @ self.weight
        coupling, left_over, vector_errors = self._errors(spectrum)
        size = np.abs(self.weight)
        with np.errstate(invalid="ignore"):
            moved = np.abs(back) @ coupling + left_over + vector_errors * (1.0 - self.values)
            errors = np.diag(moved @ size) + np.abs(leaving).sum(axis=1) * (vector_errors @ size)
        # An eigenvalue without a bound leaves every state without: inf times 0 is nan.
        errors = np.where(np.isnan(errors), np.inf, errors)
        return [Estimate(*pair) for pair in zip(np.diag(leaving), errors, strict=True)]

    def _errors(self, spectrum: Spectrum) -> tuple[Array, Array, Array]:
        """Of Λ (m, m), of what one backward step leaves (m,), and of the eigenfunctions (m,)."""
        basis = self.basis
        count = self.values.size
        bounds = spectrum.error_bounds[:count]
        change = basis.matrix.T @ self.left - self.left * self.values
        largest = np.abs(basis.dual(self.grid, self.left)).max(axis=0)
        left_over = np.abs(basis.backward(self.grid, change) / self.values).max(axis=0) + bounds
        left_over += largest * (basis.left_out + MATRIX * basis.size)
        coupling = basis.coupling(self.left, spectrum.right[:, :count].real).T
        np.fill_diagonal(coupling, bounds)
        steepest = basis.map.max_error * np.abs(basis.expected_slope(self.left)).max(axis=0)
        apart = np.abs(spectrum.values[count:] - self.values[:, None])
        growth = np.sum(spectrum.condition[count:] / apart, axis=1)
        return coupling, left_over, _VERTEX + 2.0 * (left_over + steepest) * growth


def slow_chain(basis: FourierDiscretisation, spectrum: Spectrum) -> SlowChain | None:
    """The chain of the slow states; None where no departure from the stationary law is slow.

    Slow are eigenvalues at the head of the spectrum, all real and positive, whose departures take
    at least 10 cycles to fall by e and five times as long as the next one. Where a path only turns
    on slowly they are complex.
    """
    with np.errstate(divide="ignore"):
        times = -1.0 / np.log(np.minimum(np.abs(spectrum.values), 1.0 - EPS))
    real = (np.abs(spectrum.values.imag) < _REAL) & (spectrum.values.real > 0.0)
    most = min(int(np.argmin(np.append(real, False))), times.size - 1)
    slow = [m for m in range(2, most + 1) if times[m - 1] >= max(_SLOW, _FASTER * times[m])]
    if not slow:
        return None
    count = slow[-1]
    values = spectrum.values[:count].real
    # Vectors of real eigenvalues, each turned so that its largest entry is real.
    left = spectrum.left[:, :count]
    largest = left[np.argmax(np.abs(left), axis=0), np.arange(count)]
    left = (left * np.conj(largest) / np.abs(largest)).real
    left[:, 0] = basis.mass
    grid = even_angles(_GRID * basis.modes)
    return SlowChain(basis, grid, values, left, _weight(basis, grid, values, left))


def _weight(basis: FourierDiscretisation, grid: Array, values: Array, left: Array) -> Array:
    """(m, m): of the combinations of the eigenfunctions that are 1 at their own vertex.

    A vertex is where the chance of being in its own state is the largest: on the grid, then nearer
    and nearer.
    """
    functions = basis.backward(grid, left) / values
    weight = np.linalg.inv(functions[_simplex_vertices(functions)])
    for _ in range(_ZOOMS):
        vertices = np.argmax(functions @ weight, axis=0)
        weight = np.linalg.inv(functions[vertices])
    states = np.arange(values.size)
    places = grid[vertices]
    for zoom in range(_ZOOMS):
        nearby = places[:, None] + grid[1] * 16.0**-zoom * np.linspace(-1.0, 1.0, 33)
        around = (basis.backward(nearby.ravel(), left) / values).reshape(*nearby.shape, -1)
        nearest = np.argmax((around @ weight)[states, :, states], axis=1)
        places = nearby[states, nearest]
        weight = np.linalg.inv(around[states, nearest])
    return np.asarray(weight, dtype=np.float64)


def _simplex_vertices(points: Array) -> list[int]:
    """Of points (n, m) in a simplex of m vertices those: the farthest from the mean, then the
    farthest from the span of those before.
    """
    rest = points - points.mean(axis=0)
    chosen = [int(np.argmax(np.linalg.norm(rest, axis=1)))]
    rest = points - points[chosen[0]]
    for _ in range(points.shape[1] - 1):
        chosen.append(int(np.argmax(np.linalg.norm(rest, axis=1))))
        along = rest[chosen[-1]] / np.linalg.norm(rest[chosen[-1]])
        rest = rest - np.multiply.outer(rest @ along, along)
    return chosen
