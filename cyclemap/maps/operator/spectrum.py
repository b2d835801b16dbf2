"""The slow end of a noisy map's spectrum: eigenvalues with bounds, the mixing time, and the nearly
invariant sets that slow left eigenvectors tell.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole, even_angles
from cyclemap.checks import read_only, unwritable
from cyclemap.maps.estimate import EPS, MATRIX, Estimate
from cyclemap.maps.lifts.scan import bracketed_root
from cyclemap.maps.operator.fourier_basis import Complex, FourierDiscretisation
from cyclemap.maps.operator.poisson_equation import Discretisation
from cyclemap.written import DIRECTION

_DENSE = 320  # below this many unknowns all eigenvalues are computed at once
_TOO_SMALL = 1e-6  # left vectors are not smoothed where that divides by less
_SAME = 1e-9  # eigenvalues nearer to each other, both well conditioned, are one that is there twice
_WELL_CONDITIONED = 1e3
_TRUSTED = (
    1.0 / 16.0
)  # of the distance to the next: a bound to first order up to there leaves out no second order
_SQUARINGS = 7  # of the powers that bound all eigenvalues
_ENOUGH = 1.01  # times a lower bound: an upper one as near as that is not sought any lower
_SPACE = 48  # vectors after which the residuals of an Arnoldi iteration are first looked at
_CONVERGED = 1e-13  # residual that ends it
_COPIES = 2  # of one eigenvalue that are found


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Leading eigenvalues of a transfer operator, in falling order of modulus; the first is 1,
    exactly.

    Attributes
    ----------
    values : ndarray of complex, shape (k,)
        The eigenvalues.
    error_bounds : ndarray, shape (k,)
        Bounds on |error| to first order in the residuals of both vectors, and to second in what
        maps within ``max_error`` change; inf where that is more than a sixteenth of the distance to
        the next eigenvalue found, so that it tells nothing, or where the basis cannot tell. That
        none was overlooked is not proved.
    condition : ndarray, shape (k,)
        ‖w‖‖v‖/|wᵀv| ≥ 1, v and w the right and left vectors: how much faster than a change of
        the operator the eigenvalue moves; large near a defective one (Wilkinson 1965).
    right, left : ndarray of complex, shape (n, k)
        The vectors' coefficients, wᵀv = 1.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
    >>> spectrum = transfer_operator(CircleMap.rigid(0.25), WrappedNormal(0.5)).spectrum(3)
    >>> np.abs(spectrum.values).round(6).tolist()
    [1.0, 0.882497, 0.882497]
    """

    values: Complex
    error_bounds: Array
    condition: Array
    right: Complex = field(repr=False)
    left: Complex = field(repr=False)


def leading_values(basis: Discretisation, count: int) -> Complex:
    """The eigenvalues of largest modulus, 1 first, without vectors; fewer where the basis has
    fewer.
    """
    values, _ = _leading(_deflated(basis), max(count, 8))
    return np.append(1.0 + 0.0j, values)[:count]


def leading_spectrum(
    basis: Discretisation, finer: Discretisation, law: Array, count: int
) -> Spectrum:
    """The leading ``count`` eigenvalues on a basis, their vectors, and error bounds by a finer
    basis.
    """
    values, right, left = _eigenvectors(basis, law, max(count - 1, 8))
    with np.errstate(all="ignore"):
        overlap = np.sum(left * right, axis=0)
        left = left / overlap
        condition = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
        condition[overlap == 0.0] = np.inf
        apart = np.abs(values[:, None] - values)
        good = condition <= _WELL_CONDITIONED
        same = (apart <= _SAME) & (good[:, None] & good | np.eye(values.size, dtype=bool))
        bounds = _error_bounds(basis, finer, values, right, left, same)
        bounds += _moved_by_map(basis, right, left, apart, same)
        bounds += MATRIX * condition * float(np.linalg.norm(basis.matrix))
    # How far from each eigenvalue the nearest different one lies, 1 at most.
    apart[same] = 1.0
    trusted = bounds <= _TRUSTED * np.min(apart, axis=1, initial=1.0)
    bounds[~trusted] = np.inf
    bounds[0] = 0.0
    return Spectrum(
        unwritable(values[:count]),
        unwritable(bounds[:count]),
        unwritable(condition[:count]),
        unwritable(right[:, :count]),
        unwritable(left[:, :count]),
    )


def _eigenvectors(
    basis: Discretisation, law: Array, count: int
) -> tuple[Complex, Complex, Complex]:
    """1 and the leading ``count`` other eigenvalues, their right and their left vectors."""
    deflated = _deflated(basis)
    # More than wanted, so that no eigenvalue loses a copy at the end.
    values, right = _leading(deflated, count + _COPIES)
    left = _paired(values, right, *_leading(deflated.T, count + _COPIES))[:, :count]
    values = values[:count]
    # Balancing leaves errors where the noise's coefficients are tiny: one more cycle takes them
    # away.
    kept = np.abs(values) > _TOO_SMALL
    left[:, kept] = deflated.T @ left[:, kept] / values[kept]
    # A left vector of the deflated matrix is one of L but for its share of the first, which is the
    # mass.
    left = left - np.multiply.outer(basis.mass, law @ left)
    return (
        np.append(1.0 + 0.0j, values),
        np.column_stack([law, right[:, :count]]),
        np.column_stack([basis.mass, left]),
    )


def second_modulus(spectrum: Spectrum, basis: Discretisation) -> Estimate:
    """|λ₂|, with the bounds of every eigenvalue that could be the second largest.

    Where one of those is not known, as near a defective eigenvalue, no more than that it lies
    between the eigenvalues that are known and ``_radius``.
    """
    moduli = np.abs(spectrum.values[1:])
    bounds = spectrum.error_bounds[1:]
    if moduli.size == 0:
        return Estimate(0.0, 0.0)
    close = moduli + bounds >= moduli[0] - bounds[0]
    highest = float(np.max(np.where(close, moduli + bounds, 0.0)))
    if np.isfinite(highest):
        return Estimate(float(moduli[0]), max(highest - float(moduli[0]), float(bounds[0])))
    least = max(0.0, float(np.max(moduli - bounds)))
    most = _radius(basis, least) if np.isfinite(basis.left_out) else 1.0
    value = min(float(moduli[0]), most)
    return Estimate(value, max(value - least, most - value))


def _radius(basis: Discretisation, least: float) -> float:
    """A bound on every eigenvalue but the first: the least ‖L₀ⁿ‖^(1/n), n = 1, 2, 4, ..., L₀ the
    operator without it.

    Of a power that is off by E, the square is off by (2‖L₀ⁿ‖ + E) E and its own rounding.
    """
    power = _deflated(basis)
    size = float(np.linalg.norm(power))
    rounding = MATRIX * (4.0 + np.sqrt(basis.size))
    off = float((rounding + basis.left_out) * (1.0 + size)) + basis.moved
    most = min(1.0, size + off)
    for squaring in range(1, _SQUARINGS + 1):
        if most <= _ENOUGH * least:
            break
        power = power @ power
        off = (2.0 * size + off) * off + rounding * size**2
        size = float(np.linalg.norm(power))
        most = min(most, (size + off) ** (0.5**squaring))
    return most


def mixing_time(second: Estimate) -> Estimate:
    """-1/ln|λ₂|, cycles, with the bound that follows from that of |λ₂|; inf where |λ₂| may be 1."""
    with np.errstate(divide="ignore"):
        moduli = np.clip([second.lower, second, second.upper], 0.0, 1.0)
        low, time, high = (1.0 / np.abs(np.log(moduli))).tolist()
    return Estimate(time, max(high - time, time - low) if np.isfinite(high) else float("inf"))


def _deflated(basis: Discretisation) -> Array:
    """L - u·massᵀ: the eigenvalue 1 moved to 0, all others left where they are."""
    return basis.matrix - np.multiply.outer(basis.uniform, basis.mass)


def _falling(values: Complex) -> Whole:
    """Order by falling modulus, of a pair the one above the real line first."""
    return np.lexsort((-values.imag, -np.round(np.abs(values), 13)))


def _leading(matrix: Array, count: int) -> tuple[Complex, Complex]:
    """The leading eigenvalues and right vectors, in falling order: of a large matrix by Arnoldi's
    iteration (1951), residuals checked.

    The space of v, Lv, L²v, ... grows until the residuals in it are below 1e-13, and is never
    restarted: noise makes eigenvalues fall so fast that some hundred vectors do. It grows from two
    v, for from one an eigenvalue is found once only.
    """
    size = matrix.shape[0]
    begin = np.random.default_rng(1).standard_normal((size, _COPIES))
    space = np.linalg.qr(begin)[0].T
    ahead = space @ matrix.T
    wanted = max(4 * count, _SPACE)
    while size > _DENSE and 2 * wanted < size:
        space, ahead = _grown(matrix, space, ahead, wanted)
        values, inside = np.linalg.eig(space @ ahead.T)
        order = _falling(values)[:count]
        values = values[order]
        inside = inside[:, order]
        vectors = space.T @ inside
        if np.max(np.linalg.norm(ahead.T @ inside - vectors * values, axis=0)) <= _CONVERGED:
            return values.astype(np.complex128), vectors.astype(np.complex128)
        wanted *= 2
    values, vectors = np.linalg.eig(matrix)
    order = _falling(values)[:count]
    return values[order].astype(np.complex128), vectors[:, order].astype(np.complex128)


def _grown(matrix: Array, space: Array, ahead: Array, wanted: int) -> tuple[Array, Array]:
    """An orthonormal space, as rows, with more vectors of L, L², ..., and L times each."""
    vectors = np.concatenate([space, np.empty((wanted - len(space), len(matrix)))])
    carried = np.concatenate([ahead, np.empty_like(vectors[len(space) :])])
    for known in range(len(space), wanted, _COPIES):
        new = slice(known, known + _COPIES)
        latest = carried[known - _COPIES : known]
        for _ in range(2):  # once leaves parts along the others, where much cancels
            latest = latest - latest @ vectors[:known].T @ vectors[:known]
            latest = np.linalg.qr(latest.T)[0].T
        vectors[new] = latest
        carried[new] = latest @ matrix.T
    return vectors, carried


def _paired(values: Complex, right: Complex, others: Complex, left: Complex) -> Complex:
    """The left vector (n, k) of each right one: of the nearest value; of all copies of a value, the
    dual basis.

    Any vectors of such an eigenvalue's left space may come out of an iteration, some at right
    angles to the right one.
    """
    paired = np.empty_like(right)
    for value in values:
        copies = np.abs(values - value) <= _SAME
        apart = np.abs(others - value)
        opposite = left[:, apart <= max(_SAME, np.min(apart))]
        paired[:, copies] = opposite @ np.linalg.pinv(opposite.T @ right[:, copies]).T
    return paired


def _error_bounds(
    basis: Discretisation,
    finer: Discretisation,
    values: Complex,
    right: Complex,
    left: Complex,
    same: Mask,
) -> Array:
    """How far the finer basis moves every eigenvalue, to first order where it has no further
    functions.

    same : (k, k), which values are copies of one: these move by the eigenvalues of their block, at
        most its row sums.
    """
    if finer.size == basis.size:
        # In real columns: with complex ones all waves would be made complex first.
        carried = finer.cycle(right.real) + 1j * finer.cycle(right.imag)
        rows = np.sum(np.abs(left.T @ carried - np.diag(values)), axis=1, where=same)
        return np.asarray(np.max(np.where(same, rows, 0.0), axis=1))
    from scipy.optimize import linear_sum_assignment

    # One to one, or to 0: the nearest finer value may be another's.
    others = np.append(leading_values(finer, max(2 * values.size, 8)), np.zeros(values.size))
    gaps = np.abs(values[:, None] - others)
    return np.asarray(2.0 * gaps[linear_sum_assignment(gaps)])


def _moved_by_map(
    basis: Discretisation, right: Complex, left: Complex, apart: Array, same: Mask
) -> Array:
    """How far every eigenvalue may move when F is off by its ``max_error``, to first order and, as
    far as the other vectors here tell, to second.

    |wᵀ(L' - L)v| for each pair of vectors; of an eigenvalue its own, or of copies of one the row
    of their block, and Σ_j |w_kᵀ(L' - L)v_j||w_jᵀ(L' - L)v_k| / |λ_k - λ_j|.
    """
    if basis.map.max_error == 0.0:
        return np.zeros(right.shape[1])
    coupling = basis.coupling(left, right)
    own = np.max(np.where(same, np.sum(coupling, axis=1, where=same), 0.0), axis=1)
    others = coupling * coupling.T / apart
    return np.asarray(own + np.sum(others, axis=1, where=~same))


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
