"""Where noise holds a path for long: nearly invariant sets of a noisy map, from its slow left
eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole
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
_ZOOMS = 4  # times that a vertex is sought on points 16 times as near


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
    values: Array  # (m,)
    left: Array  # (n, m)
    weight: Array  # (m, m)

    def eigenfunctions(self, theta: Array) -> Array:
        """(points, m): every z_k at the angles, one backward step from its coefficients."""
        return self.basis.backward(theta, self.left) / self.values

    @property
    def leaving(self) -> Array:
        """(m, m): I - Q; the chance of leaving a state stands on the diagonal."""
        return np.linalg.inv(self.weight) * (1.0 - self.values) @ self.weight

    def arcs(self, grid: Array) -> list[Array]:
        """For each state the arcs (start, end) on which its χ is the largest, found between points
        of an even grid.
        """
        owner = np.argmax(self.eigenfunctions(grid) @ self.weight, axis=1)
        last = np.flatnonzero(owner != np.roll(owner, -1))
        before = owner[last]
        after = np.roll(owner, -1)[last]

        def lead(theta: Array, index: Whole) -> Array:
            chances = self.eigenfunctions(theta) @ self.weight
            rows = np.arange(index.size)
            return np.asarray(chances[rows, before[index]] - chances[rows, after[index]])

        ends = bracketed_root(lead, grid[last], grid[last] + grid[1])
        starts = np.roll(ends, 1) - TWO_PI * (np.arange(ends.size) == 0)
        turns = TWO_PI * np.floor(starts / TWO_PI)
        arcs = np.stack([starts - turns, ends - turns], axis=1)
        arcs, state = arcs[np.argsort(arcs[:, 0])], before[np.argsort(arcs[:, 0])]
        return [read_only(arcs[state == index]) for index in range(self.values.size)]


def slow_chain(basis: FourierDiscretisation, spectrum: Spectrum, grid: Array) -> SlowChain | None:
    """The chain of the slow states; None where no departure from the stationary law is slow.

    Slow are eigenvalues at the head of the spectrum, all real and positive, whose departures take
    at least 10 cycles to fall by e and five times as long as the next one. Where a path only turns
    on slowly they are complex.
    """
    with np.errstate(divide="ignore"):
        times = -1.0 / np.log(np.minimum(np.abs(spectrum.values), 1.0 - EPS))
    real = (np.abs(spectrum.values.imag) < _REAL) & (spectrum.values.real > 0.0)
    count = min(int(np.argmin(np.append(real, False))), times.size - 1)
    slow = [m for m in range(2, count + 1) if times[m - 1] >= max(_SLOW, _FASTER * times[m])]
    if not slow:
        return None
    values = spectrum.values[: slow[-1]].real
    complex_left = spectrum.left[:, : slow[-1]]
    # Vectors of real eigenvalues, each turned so that its largest entry is real.
    largest = complex_left[np.argmax(np.abs(complex_left), axis=0), np.arange(slow[-1])]
    left = (complex_left * np.conj(largest) / np.abs(largest)).real
    left[:, 0] = basis.mass
    functions = basis.backward(grid, left) / values
    chosen = _simplex_vertices(functions)
    # Each where the chance of being in its own state is the largest: on the grid, then nearer and
    # nearer.
    states = np.arange(slow[-1])
    vertices = grid[chosen]
    step = grid[1]
    weight = np.linalg.inv(functions[chosen])
    for zoom in range(-_ZOOMS, _ZOOMS):
        if zoom < 0:
            vertices = grid[np.argmax(functions @ weight, axis=0)]
        else:
            nearby = vertices[:, None] + step * 16.0**-zoom * np.linspace(-1.0, 1.0, 33)
            chances = (basis.backward(nearby.ravel(), left) / values) @ weight
            vertices = nearby[
                states, np.argmax(chances.reshape(*nearby.shape, -1)[states, :, states], axis=1)
            ]
        weight = np.linalg.inv(basis.backward(vertices, left) / values)
    return SlowChain(basis, values, left, np.asarray(weight, dtype=np.float64))


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


def leaving_errors(chain: SlowChain, spectrum: Spectrum, grid: Array) -> Array:
    """(m,): first-order bounds on the errors of ``chain.leaving``'s diagonal, the map's
    ``max_error`` included.

    Of λ: its bound in the spectrum; of Λ as a matrix ε ∫|p_j||∂E z_k(F + ξ)/∂F|, p_j the right
    eigenfunctions. Of an eigenfunction: ε max|∂E z_k(F + ξ)/∂F|, what one more backward step leaves
    of E z_k(F + ξ) - λ_k z_k (on the grid), the functions that the basis has not, rounding and the
    eigenvalue's bound, times 2Σ_j condition_j/|λ_k - λ_j| over the fast j, for what lies in the
    span of the slow ones moves nothing: measured.
    """
    basis = chain.basis
    count = chain.values.size
    change = (
        basis.backward(grid, basis.matrix.T @ chain.left - chain.left * chain.values) / chain.values
    )
    largest = np.abs(basis.dual(grid, chain.left)).max(axis=0)
    left_over = np.abs(change).max(axis=0) + largest * (basis.left_out + MATRIX * basis.size)
    left_over += spectrum.error_bounds[:count]
    coupling = np.diag(spectrum.error_bounds[:count])
    steepest = np.zeros(count)
    if basis.map.max_error > 0.0:
        slopes = np.stack([np.abs(basis.expected_slope(dual)) for dual in chain.left.T], axis=1)
        masses = np.abs(basis.on_nodes(spectrum.right[:, :count].real)) * basis.rule[1][:, None]
        coupling = coupling + basis.map.max_error * (masses.T @ slopes)
        steepest = basis.map.max_error * slopes.max(axis=0)
    apart = np.abs(spectrum.values[count:] - chain.values[:, None])
    vector_errors = _VERTEX + 2.0 * (left_over + steepest) * np.sum(
        spectrum.condition[count:] / apart, axis=1
    )
    if not np.all(np.isfinite(vector_errors)):
        # An eigenvalue without a bound leaves every state without: inf times 0 would be nan.
        return np.full(count, np.inf)
    size = np.abs(chain.weight)
    moved = np.abs(np.linalg.inv(chain.weight)) @ coupling
    moved += left_over + vector_errors * (1.0 - chain.values)
    return np.asarray(
        np.diag(moved @ size) + np.abs(chain.leaving).sum(axis=1) * (vector_errors @ size)
    )
