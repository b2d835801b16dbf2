"""The transfer operator of a noisy circle map, θ' = F(θ) + ξ: its stationary distribution, and what
is read off it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import INTEGRAL, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one, require_map
from cyclemap.maps.lifts.scan import bracketed_root
from cyclemap.maps.noise import Noise, require_noise
from cyclemap.maps.operator.cells import CellLaw, cell_law
from cyclemap.maps.operator.fourier_basis import Complex, FourierDiscretisation, needed_modes
from cyclemap.maps.operator.poisson_equation import Discretisation, FourierLaw, Function
from cyclemap.maps.operator.spectrum import (
    MetastableSet,
    Spectrum,
    leading_spectrum,
    leading_values,
    mixing_time,
    second_modulus,
    slow_chain,
)
from cyclemap.maps.quadrature import arc_rule, graded_rule
from cyclemap.one_thread import one_thread


def peaks_of(slope: Function, grid: Array, values: Array, margin: float) -> Array:
    """Angles in [0, 2π) of the maxima that rise by ``margin`` above the minima beside them,
    sorted."""
    before = np.roll(values, 1)
    after = np.roll(values, -1)
    tops = np.flatnonzero((values > before) & (values >= after) & (values > margin))
    while tops.size:
        lows = np.minimum.reduceat(np.roll(values, -tops[0]), tops - tops[0])
        height = values[tops] - np.maximum(lows, np.roll(lows, 1))
        least = int(np.argmin(height))
        if height[least] > margin:
            break
        tops = np.delete(tops, least)
    step = grid[1]
    at = grid[tops]
    inside = slope(at - step) * slope(at + step) < 0.0
    if np.any(inside):
        at[inside] = bracketed_root(lambda x, _: slope(x), at[inside] - step, at[inside] + step)
    at = np.mod(at, TWO_PI)
    # A tiny negative angle rounds up to a whole turn.
    return np.sort(np.where(at >= TWO_PI, 0.0, at))


_LEADING = 5  # eigenvalues among which the second largest is told from the rest


def transfer_operator(
    circle_map: CircleMap, noise: Noise | None, *, modes: int | None = None
) -> TransferOperator:
    """The transfer (Perron-Frobenius) operator of θ' = F(θ) + ξ: it carries the law of θ one cycle
    on.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    noise : Noise or None
        ξ, or None for none.
    modes : int or None, optional
        Keep this many Fourier modes, at most 2000, instead of as many as the noise lets
        through: fewer show what the bounds are worth.

    Returns
    -------
    TransferOperator
        The operator on its basis; its law and all else are computed when asked for.

    Raises
    ------
    InvalidInput
        When there is no noise and no power of the map expands, or the noise is so narrow that
        more than 2000 modes would be needed (for ``WrappedNormal`` below 0.0046 rad).
    ConvergenceError
        From what is computed later, when the map is too steep or too fine for the noise, so
        that more than 400,000 nodes or 2e12 multiplications would be needed.

    Notes
    -----
    Noise makes every law analytic or smooth, so Fourier modes are all but exact: as many are kept
    as the noise lets through, to where the rest of its coefficients sum to less than 1e-17 (see
    ``FourierDiscretisation``; Galatolo, Monge & Nisoli 2020). ``UniformNoise``, whose density
    jumps, and None, no noise, take the masses of 512 or 1,024 cells, with bounds that fall with
    their length (see ``CellLaw``); without noise the map must expand.

    References
    ----------
    Galatolo, S., Monge, M. & Nisoli, I. (2020), Existence of noise induced order, a computer aided
    proof, Nonlinearity 33.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
    >>> turning = transfer_operator(CircleMap.rigid(0.3), WrappedNormal(0.5))
    >>> round(turning.rotation_number, 12), round(float(turning.density(1.0)) * 2 * np.pi, 12)
    (0.3, 1.0)
    """
    require_map(circle_map)
    if noise is not None:
        require_noise(noise)
    if noise is None or noise.jump > 0.0:
        if modes is not None:
            raise InvalidInput(
                f"modes is {modes!r}, but with {noise!r} nothing is resolved in Fourier modes: "
                "leave it out"
            )
        return TransferOperator(circle_map, noise, cell_law(circle_map, noise))
    needed = needed_modes(noise)
    kept = needed if modes is None else whole_number("modes", modes, least=1)
    return TransferOperator(
        circle_map, noise, FourierLaw(FourierDiscretisation(circle_map, noise, kept))
    )


@dataclass(frozen=True, eq=False)
class TransferOperator:
    """Made by ``transfer_operator``; everything is computed when first asked for, and kept.

    Attributes
    ----------
    map : CircleMap
        The map that it is the operator of.
    noise : Noise or None
        The noise that is added after the map.
    law : FourierLaw or CellLaw
        Its stationary law on a basis.

    Notes
    -----
    Every number knows its accuracy. The bounds come from what the computed law leaves over in L
    p = p (see ``StationaryLaw.error`` for what in them is proved and what measured), and hold for
    every map within ``max_error`` of this one: of the density and its integrals to all orders, of
    the spectrum to second order as far as the eigenvalues found tell, of the diffusion constant as
    far as the worst map to first order tells (measured). Without noise they say nothing of others:
    a map beside one that expands may gather all paths in a point.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
    >>> law = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3))
    >>> round(law.tv_from_uniform, 3), law.peaks().round(2).tolist(), law.is_certain
    (0.735, [0.81], True)
    """

    map: CircleMap
    noise: Noise | None
    law: FourierLaw | CellLaw

    @property
    def discretisation(self) -> Discretisation:
        """The basis on which the operator is a matrix."""
        return self.law.basis

    @property
    def modes(self) -> int:
        """Fourier modes on each side; for other bases half the number of functions."""
        return self.discretisation.size // 2

    @one_thread
    def density(self, theta: ArrayLike) -> Array:
        """The stationary density per radian at ``theta`` (radians, any shape);
        see ``error_bound``."""
        angles = finite_array("theta", theta)
        return self.law.density(angles.ravel()).reshape(angles.shape)

    @property
    @one_thread
    def error_bound(self) -> float:
        """Bound on the error of the stationary density, per radian, anywhere on the circle.

        inf without noise: the density may jump then, and only its integrals have bounds.
        """
        return self.law.density_error

    @cached_property
    def is_certain(self) -> bool:
        """Whether the law is known to a tenth of the uniform density, or better.

        It is not where the map has several basins that the noise hardly ever connects: the weights
        of their parts then are beyond double precision, and the law is any mixture of them.
        """
        return bool(self.error_bound <= 0.1 / TWO_PI)

    @one_thread
    def moment(self, n: int) -> complex:
        """E e^{inθ} of the stationary law; 0 beyond the modes kept. See ``moment_error``."""
        return complex(self.discretisation.moments(whole_number("n", n)) @ self.law.coefficients)

    @one_thread
    def moment_error(self, n: int) -> float:
        """Bound on |error| of ``moment(n)``."""
        return self.law.moment_error(whole_number("n", n))

    @one_thread
    def expectation(self, function: Function, *, folds: bool = False) -> Estimate:
        """The mean E h(θ) of a function under the stationary law.

        Parameters
        ----------
        function : callable
            h, vectorised, as smooth as F between F's breaks.
        folds : bool, default False
            Whether h may also be singular, like a logarithm, where F' = 0; then the nodes crowd
            towards those points.

        Returns
        -------
        Estimate
            The bound adds to the law's the difference that twice as many nodes make (measured).

        Raises
        ------
        InvalidInput
            Where h is not finite.

        Examples
        --------
        >>> import numpy as np
        >>> from cyclemap import CircleMap, WrappedCauchy, transfer_operator
        >>> law = transfer_operator(CircleMap.rigid(0.1), WrappedCauchy(0.5))
        >>> abs(law.expectation(lambda theta: np.cos(theta) ** 2) - 0.5) < 1e-15
        True
        """
        if not folds:
            return self.law.expectation(function)
        rules = graded_rule(self.map, self.modes), graded_rule(self.map, self.modes, 2)
        return self.law.expectation(function, rules)

    @cached_property
    @one_thread
    def rotation_number(self) -> Estimate:
        """Mean winding in turns a cycle: E[F(θ) - θ]/2π under the stationary law."""
        require_degree_one(self.map, "a mean winding")
        return self.law.expectation(
            lambda theta: self.map.turn(theta) / TWO_PI, direct=1.0 / TWO_PI
        )

    @cached_property
    @one_thread
    def diffusion(self) -> Estimate:
        """D = lim Var(θ_n)/2n, radians² a cycle, of the path on the line: see
        ``StationaryLaw.diffusion``.

        For normal noise, by a measured bound against D on a finer basis and of maps within
        ``max_error``; inf for Cauchy's, other noise is refused.

        >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
        >>> round(transfer_operator(CircleMap.rigid(0.2), WrappedNormal(0.4)).diffusion, 12)
        0.08
        """
        plain = self.law.diffusion()
        if np.isinf(plain):
            return plain
        off = abs(self._finer.diffusion() - plain) + plain.error_bound
        return Estimate(plain, off + self.law.diffusion_moved())

    @cached_property
    @one_thread
    def tv_from_uniform(self) -> Estimate:
        """Total variation distance of the law from uniform, ½ ∫ |density - 1/2π| dθ, in [0, 1].

        0 where the density is nowhere further from uniform than four times its error bound.
        """
        return self.law.distance_from_uniform()

    @one_thread
    def peaks(self) -> Array:
        """Angles in [0, 2π) of the local maxima of the stationary density, sorted; none where it is
        uniform.

        Maxima that rise above their neighbouring minima by less than the error bound are not told
        apart.
        """
        return peaks_of(self.law.slope, *self.law.grid, 4.0 * self.error_bound)

    @one_thread
    def eigenvalues(self, k: int) -> Complex:
        """The k eigenvalues of largest modulus, in falling order; the first is 1.

        Fewer are returned only when the basis has fewer functions. Small operators are solved
        whole, large ones by Arnoldi's iteration, whose residuals are checked; ConvergenceError when
        they fail.
        """
        return leading_values(self._noisy_basis, whole_number("k", k, least=1))

    @one_thread
    def spectrum(self, k: int) -> Spectrum:
        """The same with error bounds, condition numbers and vectors; see ``Spectrum``."""
        count = whole_number("k", k, least=1)
        return leading_spectrum(self._noisy_basis, self._finer.basis, self.law.coefficients, count)

    @property
    def _noisy_basis(self) -> Discretisation:
        """The basis, or InvalidInput: without noise most of the spectrum is a disc, which cells do
        not tell.
        """
        if self.noise is None:
            raise InvalidInput(
                "the noise is None: eigenvalues need noise, for example WrappedNormal(0.02)"
            )
        return self.discretisation

    @cached_property
    def spectral_gap(self) -> Estimate:
        """1 - |λ₂|, λ₂ the eigenvalue of second largest modulus; for its bound see
        ``spectrum.second_modulus``.
        """
        second = self._second
        return Estimate(max(0.0, 1.0 - second), second.error_bound)

    @cached_property
    def mixing_cycles(self) -> Estimate:
        """-1/ln|λ₂|: cycles in which the slowest departure from the law falls by e;
        ∞ if |λ₂| = 1."""
        return mixing_time(self._second)

    @one_thread
    def metastable_sets(self) -> tuple[MetastableSet, ...]:
        """The sets of angles among which noise rarely carries a path, the largest share first; or
        none.

        Their arcs end where the slow left eigenfunctions say that a path belongs to either side
        alike: see ``SlowChain``. Bounds: of the shares those of the density; of the chances of
        leaving see ``SlowChain.leaving``.

        >>> import numpy as np
        >>> from cyclemap import CircleMap, WrappedNormal, transfer_operator
        >>> wells = CircleMap(lambda theta: theta - 0.3 * np.sin(2 * theta) + 0.05 * np.sin(theta))
        >>> held = transfer_operator(wells, WrappedNormal(0.3)).metastable_sets()
        >>> [(round(well.share, 4), round(1 / well.leaving)) for well in held]
        [(0.8779, 10269), (0.1221, 1428)]
        """
        basis = self.law.smooth_basis
        spectrum = self._leading
        chain = slow_chain(basis, spectrum)
        if chain is None:
            return ()
        sets = []
        for arcs, leaving in zip(chain.arcs(), chain.leaving(spectrum), strict=True):
            rules = [
                arc_rule(self.map, start, end, self.modes, every_sample=False)
                for start, end in arcs
            ]
            theta, weight = np.concatenate(rules, axis=1)
            density = self.density(theta)
            bound = self.error_bound * float(weight.sum()) + INTEGRAL
            peak = float(np.mod(theta[np.argmax(density)], TWO_PI))
            share = Estimate(float(weight @ density), bound)
            sets.append(MetastableSet(arcs, peak, share, leaving))
        return tuple(sorted(sets, key=lambda held: -held.share))

    @cached_property
    def _leading(self) -> Spectrum:
        return self.spectrum(_LEADING)

    @cached_property
    def _finer(self) -> FourierLaw | CellLaw:
        return self.law.refined()

    @cached_property
    @one_thread
    def _second(self) -> Estimate:
        return second_modulus(self._leading, self.discretisation)
