"""Densities on the circle as trigonometric polynomials, and one cycle of a noisy map as a matrix on
them.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.quadrature import Rule, arc_rule

MAX_MODES = 2_000
MAX_WORK = 2e12  # multiplications of plain sums: how fine a map may be for its noise
NEGLIGIBLE = 1e-17  # noise coefficients beyond the last mode add up to less
# nodes times basis functions handled at a time: waves made anew in the cache beat kept ones
_ENTRIES = 400_000

Complex = npt.NDArray[np.complex128]
Waves = tuple[slice, Array]


def needed_modes(noise: Noise) -> int:
    """Fourier modes beyond which the noise's coefficients add up to less than 1e-17; InvalidInput
    beyond 2000.
    """
    if noise.tail(MAX_MODES) > NEGLIGIBLE:
        raise InvalidInput(
            f"{noise!r} needs more than {MAX_MODES} Fourier modes: raise its width (a wrapped "
            "normal is resolved from 0.27 degrees on)"
        )
    counts = range(1, MAX_MODES + 1)
    return counts[bisect_left(counts, True, key=lambda modes: noise.tail(modes) <= NEGLIGIBLE)]


def waves(theta: Array, modes: int) -> Array:
    """1, cos mθ (m = 1..modes), sin mθ at the angles ``theta`` (shape (n,)), as rows: shape
    (2·modes + 1, n).
    """
    powers = np.empty((modes + 1, theta.size), dtype=np.complex128)
    powers[0] = 1.0
    powers[1] = np.exp(1j * np.mod(theta, TWO_PI))
    filled = 2
    while filled <= modes:
        # Orders filled .. 2·filled - 2 are the known ones times the highest known power.
        more = min(filled - 1, modes + 1 - filled)
        np.multiply(powers[1 : more + 1], powers[filled - 1], out=powers[filled : filled + more])
        filled += more
    return np.concatenate([powers.real, powers[1:].imag])


@dataclass(frozen=True, eq=False)
class WavesInBlocks:
    """Blocks of some angles, each with its ``waves``; kept where all fit in one block, else made as
    they are used.
    """

    angles: Array
    modes: int

    def __iter__(self) -> Iterator[Waves]:
        step = max(64, _ENTRIES // (2 * self.modes + 1))
        if self.angles.size <= step:
            yield self._only_block
            return
        for first in range(0, self.angles.size, step):
            stretch = slice(first, first + step)
            yield stretch, waves(self.angles[stretch], self.modes)

    @cached_property
    def _only_block(self) -> Waves:
        return slice(0, self.angles.size), waves(self.angles, self.modes)

    def combined(self, factors: Array) -> Array:
        """(m,) or (m, k): at every angle the waves times ``factors`` (n,) or (n, k), added up."""
        return np.concatenate([rows.T @ factors for _, rows in self])

    def summed(self, mass: Array) -> Array:
        """(n,) or (n, k): every wave times ``mass`` (m,) or (m, k), added up over the angles."""
        return np.asarray(np.sum([rows @ mass[stretch] for stretch, rows in self], axis=0))


@dataclass(frozen=True, eq=False)
class FourierDiscretisation:
    """Trigonometric polynomials with ``modes`` harmonics, real: 1/2π, cos mθ/π, sin mθ/π.

    The coefficients of a law are its moments (1, E cos mθ, E sin mθ), and one cycle carries them to
    κ_m E cos mF, κ_m E sin mF, κ_m the noise's coefficients: a Galerkin method, exact but for
    truncation and quadrature (the setting of Galatolo, Monge & Nisoli 2020). Integrals are taken
    branch by branch, so jumps and kinks cost nothing.

    map, noise : whose cycle it is.
    modes : 1 to 2000.
    finer : how many times as many quadrature nodes as are needed.

    Raises InvalidInput for a number of modes outside that range.
    """

    map: CircleMap
    noise: Noise
    modes: int
    finer: int = 1

    def __post_init__(self) -> None:
        if whole_number("modes", self.modes, least=1) > MAX_MODES:
            raise InvalidInput(
                f"modes is {self.modes}: at most {MAX_MODES} Fourier modes can be kept"
            )

    @property
    def size(self) -> int:
        """2·modes + 1."""
        return 2 * self.modes + 1

    @cached_property
    def left_out(self) -> float:
        """A bound on what one cycle makes of the modes that are not kept: the sum of the noise's
        coefficients there.
        """
        return self.noise.tail(self.modes)

    @cached_property
    def mass(self) -> Array:
        """(n,): 1 for the constant, 0 for every wave."""
        return np.asarray(np.eye(1, self.size)[0])

    @property
    def uniform(self) -> Array:
        """(n,): the constant alone."""
        return self.mass

    @cached_property
    def scale(self) -> Array:
        """(n,): what turns a wave into a basis function."""
        return (2.0 - self.mass) / TWO_PI

    @cached_property
    def order(self) -> Array:
        """(n,): the harmonic m of every basis function."""
        rising = np.arange(1.0, self.modes + 1.0)
        return np.concatenate([[0.0], rising, rising])

    def evaluate(self, theta: Array) -> Array:
        """(n, m): 1/2π, cos mθ/π, sin mθ/π at the angles ``theta``, shape (m,)."""
        return self.scale[:, None] * waves(theta, self.modes)

    def slope(self, theta: Array, law: Array) -> Array:
        """(m,): the derivative at the angles of the density with coefficients ``law``."""
        return self.dual(theta, self.derived(self.scale * law))

    def mass_before(self, theta: Array, law: Array) -> Array:
        """(m,): ∫ (p - 1/2π) up to each angle, but for a constant, p with coefficients ``law``."""
        turned = self.derived(self.scale * law / np.maximum(self.order, 1.0) ** 2)
        return -self.dual(theta, turned)

    def moments(self, order: int) -> Complex:
        """(n,), complex: ∫ e^{i·order·θ} φ_j dθ; all 0 beyond the modes kept."""
        phase = np.ones(self.size, dtype=np.complex128)
        phase[self.modes + 1 :] = 1j * np.sign(order)
        return np.where(self.order == abs(order), phase, 0.0)

    @cached_property
    def rule(self) -> Rule:
        """Nodes and weights over one turn, for products of waves of θ, waves of F(θ) and what is as
        smooth as F.
        """
        return arc_rule(self.map, 0.0, TWO_PI, self.modes, self.finer)

    @cached_property
    def images(self) -> Array:
        """F(θ) at the nodes of ``rule``."""
        return self.map(self.rule[0])

    @cached_property
    def kappa(self) -> Array:
        """(n,): the noise's coefficient of every basis function."""
        return self.noise.coefficients(self.order)

    @cached_property
    def matrix(self) -> Array:
        """(n, n): κ_m ∫ (1, cos mF, sin mF) φ_k dθ; the first row keeps the mass exactly."""
        theta, weight = self.rule
        work = float(self.size) ** 2 * theta.size
        if work > MAX_WORK:
            raise ConvergenceError(
                f"{self.modes} modes on {theta.size} nodes take {work:.2g} multiplications, more "
                f"than {MAX_WORK:.2g}: the map has too fine a structure for so small a noise; "
                "raise the noise"
            )
        matrix = wave_integrals(theta, weight, self.images, self.modes)
        matrix *= self.kappa[:, None] * self.scale
        matrix[0] = self.mass
        return matrix

    def cycle(self, law: Array) -> Array:
        """(n,): coefficients after one cycle of the density with coefficients ``law``; or columns
        of several.
        """
        return self.carried(self.on_nodes(law))

    def expected(self, dual: Array) -> Array:
        """E z(F(θ) + ξ) for the z with the integrals ``dual``, ∫ zφ_j, at the nodes of ``rule``."""
        return self._after.combined(_times(self.kappa, dual))

    def expected_slope(self, dual: Array, at: Array | None = None) -> Array:
        """E z'(F(θ) + ξ) for the z with the integrals ``dual``, ∫ zφ_j, at the nodes of ``rule`` or
        at ``at``.
        """
        images = self._after if at is None else WavesInBlocks(self.map(at), self.modes)
        return images.combined(self.derived(_times(self.kappa, dual)))

    def slopes_on_grid(self, dual: Array, order: int) -> Array:
        """(4·modes, k): sizes of (d/dy)^order of E z(y + ξ) on an even grid of y, for the z with
        the integrals ``dual``, raised to be no less than between the points.
        """
        factors = _times(self.kappa, dual)
        for _ in range(order):
            factors = self.derived(factors)
        return sizes_on_grid(factors, 4)

    def coupling(self, left: Array | Complex, right: Array | Complex) -> Array:
        """(k, k): how much wᵀLv changes when F is off by its ``max_error`` ε, at most; w a column
        of ``left``, v one of ``right``.

        ε ∫ |g'(F)| |v| dθ + ½ε² sup|g''| ∫ |v| dθ, g(y) = E w(y + ξ).
        """
        _, weight = self.rule
        epsilon = self.map.max_error
        # In real columns: with complex ones all waves would be made complex first.
        slopes = np.hypot(self.expected_slope(left.real), self.expected_slope(left.imag))
        bends = [self.slopes_on_grid(each, 2).max(axis=0) for each in (left.real, left.imag)]
        sizes = np.hypot(self.on_nodes(right.real), self.on_nodes(right.imag))
        masses = _times(weight, sizes)
        beyond = 0.5 * epsilon * np.multiply.outer(np.hypot(*bends), masses.sum(axis=0))
        return np.asarray(epsilon * (slopes.T @ masses + beyond))

    @property
    def moved(self) -> float:
        """A bound on the norm of what L changes by when F is off by its ``max_error`` ε.

        Row m has the integrals of κ_m (e^{imF'} - e^{imF}), of size κ_m·m·ε at most, with the
        waves, which are orthogonal: √2 times that (Bessel's inequality).
        """
        return self.map.max_error * math.sqrt(2.0) * float(np.linalg.norm(self.kappa * self.order))

    def dual(self, theta: Array, dual: Array) -> Array:
        """(m, k): at the angles, the functions z with the integrals ``dual`` (n, k), ∫ zφ_j."""
        return WavesInBlocks(theta, self.modes).combined(dual)

    def backward(self, theta: Array, dual: Array) -> Array:
        """(m, k): E z(F(θ) + ξ) at the angles for the functions z with the integrals ``dual`` (n,
        k), ∫ zφ_j.
        """
        return self.dual(self.map(theta), _times(self.kappa, dual))

    def density(self, theta: Array, law: Array) -> Array:
        """(m,): the density with coefficients ``law``, per radian, at the angles, shape (m,)."""
        return self.dual(theta, self.scale * law)

    def integrals(self, theta: Array, mass: Array) -> Array:
        """(n,): Σ mass φ_j(θ) over the angles; or columns of several."""
        return _times(self.scale, WavesInBlocks(theta, self.modes).summed(mass))

    def on_nodes(self, law: Array) -> Array:
        """The density with coefficients ``law``, per radian, at the nodes of ``rule``."""
        return self._before.combined(_times(self.scale, law))

    def carried(self, density: Array) -> Array:
        """(n,): coefficients after one cycle of the density with these values at the nodes of
        ``rule``.
        """
        _, weight = self.rule
        return _times(self.kappa, self._after.summed(_times(weight, density)))

    def refined(self) -> FourierDiscretisation:
        """The same with every mode that the noise lets through and twice as many nodes: for
        residuals.
        """
        return FourierDiscretisation(
            self.map, self.noise, max(self.modes, needed_modes(self.noise)), 2 * self.finer
        )

    def places(self, coarse: FourierDiscretisation) -> Whole:
        """Where the coefficients of a ``coarse`` basis, of no more modes, stand among these."""
        modes = np.arange(coarse.modes)
        return np.concatenate([[0], 1 + modes, 1 + self.modes + modes])

    def derived(self, factors: Array) -> Array:
        """Factors (n,) or (n, k) of waves, or coefficients, as those of the derivative: cos → -m
        sin, sin → m cos.
        """
        constant, cosines, sines = np.split(_times(self.order, factors), [1, self.modes + 1])
        return np.concatenate([constant, sines, -cosines])

    @cached_property
    def _before(self) -> WavesInBlocks:
        """Waves of the nodes θ."""
        return WavesInBlocks(self.rule[0], self.modes)

    @cached_property
    def _after(self) -> WavesInBlocks:
        """Waves of F(θ) at the nodes."""
        return WavesInBlocks(self.images, self.modes)


@dataclass(frozen=True, eq=False)
class ShiftedDiscretisation(FourierDiscretisation):
    """The same basis and nodes for a map that is off by ``shift`` at the nodes, radians."""

    shift: Array | float = 0.0

    @cached_property
    def images(self) -> Array:
        """F(θ) + shift at the nodes of ``rule``."""
        return self.map(self.rule[0]) + self.shift


def sizes_on_grid(factors: Array, points: int) -> Array:
    """(points·modes, k): |Σ factors·waves| on an even grid, factors (2·modes + 1, k), raised so
    that the largest is no less than between the points (Ehlich & Zeller 1964).
    """
    modes = factors.shape[0] // 2
    spectrum = factors[: modes + 1].astype(np.complex128)
    spectrum[1:] -= 1j * factors[modes + 1 :]
    spectrum[1:] *= 0.5
    count = points * modes
    sizes = np.abs(np.fft.irfft(spectrum, count, axis=0))
    return np.asarray(sizes * (count / math.cos(math.pi / points)))


def _times(factors: Array, columns: Array) -> Array:
    """Row j of a vector or of columns, times factors[j]."""
    return (factors * columns.T).T


# Cells of the grid that a node is spread over, at least twice as many cells as the waves need: what
# the grid aliases is exp(-18π/√2) = 4e-18 of the nodes' weight.
_SPREAD = 18
_HALF = 0.5 * _SPREAD
_BETA = math.pi * math.sqrt((1.5 * _HALF) ** 2 - 0.8)
_TWO_PI_REST = 2.4492935982947064e-16  # 2π less its double
_BLOCK = 64  # nodes and cells at most that are spread by one small matrix


def wave_integrals(theta: Array, weight: Array, image: Array, modes: int) -> Array:
    """Return ∫ (1, cos mF, sin mF) (1, cos kθ, sin kθ) dθ for m, k = 1 to `modes`, (2·modes + 1,
    2·modes + 1).

    theta : rad, in [0, 2π], nodes (n,) at any distances.
    weight : their weights.
    image : F there, rad.

    Sums over uneven nodes by fast transforms (Dutt & Rokhlin 1993), nodes spread by the
    Kaiser-Bessel window (Fessler & Sutton 2003): about n·modes multiplications, where the plain
    sums take n·modes². Rounding is that of the nodes.
    """
    # A power of two, for fast transforms, and so many that a block of nodes does not meet itself
    # around the circle.
    cells = 1 << (max(4 * modes, _BLOCK) + 2 * _SPREAD - 1).bit_length()
    gathered = np.zeros((cells, 2 * modes + 1))
    for nodes, touched, spread in _blocks(theta, weight, cells):
        gathered[touched] += spread @ waves(image[nodes], modes).T
    # Of the window's transform, sinh(root) / root: by the difference from β, which rounding leaves
    # alone.
    bend = (_HALF * TWO_PI * np.arange(modes + 1) / cells) ** 2
    root = np.sqrt(_BETA**2 - bend)
    undone = np.i0(_BETA) / np.sinh(_BETA) / _SPREAD * root * np.exp(bend / (root + _BETA))
    integrals = np.empty((2 * modes + 1, 2 * modes + 1))
    for first in range(0, 2 * modes + 1, _BLOCK):
        several = slice(first, first + _BLOCK)
        along = undone[:, None] * np.fft.rfft(gathered[:, several], axis=0)[: modes + 1]
        integrals[several] = np.concatenate([along.real, -along.imag[1:]]).T
    return integrals


def _blocks(theta: Array, weight: Array, cells: int) -> Iterator[tuple[Whole, Whole, Array]]:
    """Of neighbouring nodes: which they are, the cells (c,) that they are spread over, and the
    matrix (c, nodes) that spreads them.
    """
    first_cell, window = _windows(theta, weight, cells)
    order = np.argsort(first_cell, kind="stable")
    first_cell = first_cell[order]
    first = 0
    while first < theta.size:
        last = int(np.searchsorted(first_cell, first_cell[first] + _BLOCK))
        nodes = order[first : min(last, first + _BLOCK)]
        across = first_cell[first : first + nodes.size] - first_cell[first]
        spread = np.zeros((int(across[-1]) + _SPREAD, nodes.size))
        for offset in range(_SPREAD):
            spread[across + offset, np.arange(nodes.size)] = window[nodes, offset]
        yield nodes, np.mod(first_cell[first] + np.arange(len(spread)), cells), spread
        first += nodes.size


def _windows(theta: Array, weight: Array, cells: int) -> tuple[Whole, Array]:
    """The first of the cells that each node is spread over, and what of its weight each gets."""
    width = TWO_PI / cells  # of which the remainder is exact: nodes keep all their digits
    before, place = np.divmod(theta, width)
    place = (place - before * (_TWO_PI_REST / cells)) / width
    reach = np.arange(_SPREAD) - (_SPREAD // 2 - 1)
    across = 1.0 - ((reach - place[:, None]) / _HALF) ** 2
    window = np.i0(_BETA * np.sqrt(np.maximum(across, 0.0))) * (weight / np.i0(_BETA))[:, None]
    return np.mod(before.astype(int) + reach[0], cells), window
