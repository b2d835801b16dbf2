"""Laws after n cycles from all starting points together: the worst start, and when no start matters any more."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import (
    CycleOperator,
    basis_parts,
    complex_moments,
    fourier_basis,
    images_law,
    is_resolved,
    largest_density,
    real_coefficients,
    stationary_fourier_law,
)
from cyclemap.maps.mixtures.start_grid import StartGrid, start_grid
from cyclemap.maps.mixtures.worst_start import ReachTime, WorstStart, farthest_start, largest_variation, worst_starts
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation

_LEAST_STARTS, _MOST_STARTS = 128, 2048
_SLOPES = 512  # angles at which the steepest slope is sought
_LONGEST = 40  # doublings of the number of cycles
_ROUNDS = 4  # of a bound's search
_SCANNED = 500  # cycles looked at one by one


@dataclass(frozen=True, eq=False)
class StartEnsemble:
    """The laws after n cycles from ``starts`` evenly spaced angles, by powers of the operator.

    operator : of a map or of a mixture, on Fourier modes. starts : at least 8; None takes so many that no map carries
    two neighbours further apart than the noise is wide, which the bounds rely on (128 to 2048).
    bounded : False leaves out the stationary law's bound, and all others then are as wide as can be.
    Raises InvalidInput for anything else.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> from cyclemap.maps.operator.transfer_operator import transfer_operator
    >>> spread = StartEnsemble(transfer_operator(CircleMap.rigid(0.3), WrappedNormal(1.0)))
    >>> spread.mixing_cycles(0.05)
    ReachTime(cycles=6, earliest=6, latest=6)
    """

    operator: CycleOperator
    starts: int | None = None
    bounded: bool = True
    _powers: list[Array] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        fourier_basis(self.operator)
        if self.starts is not None:
            whole_number("starts", self.starts, least=8)

    @cached_property
    def law(self) -> FourierLaw:
        """The stationary law."""
        return stationary_fourier_law(self.operator, self.bounded)

    @cached_property
    def grid(self) -> StartGrid:
        """The starting angles, to which both sides of the maps' breaks are added."""
        return start_grid(self.starts or enough_starts(self._basis), self._basis.map.breaks)

    def worst(self, cycles: int, target: FourierLaw | None = None) -> WorstStart:
        """The largest distances from the stationary law, or from ``target``, after 1, ..., ``cycles`` cycles."""
        count = whole_number("cycles", cycles, least=1)
        columns, rows = self._first, []
        for n in range(1, count + 1):
            rows.append(self._farthest(columns, n, target))
            columns = self._basis.matrix @ columns if n < count else columns
        return worst_starts(rows)

    def mixing_cycles(self, tv: float) -> ReachTime:
        """The least n with total variation ≤ ``tv`` from the stationary law for every start; tv in (0, 1).

        That distance never grows with n, so n is found by doubling. inf where 2⁴⁰ cycles do not do.
        """
        limit = _checked_limit(tv)
        found = self._first_below(limit)
        return ReachTime(found, self._surely_too_few(found, limit), self._surely_enough(found, limit))

    def reach_cycles(self, tv: float, target: FourierLaw | None = None) -> ReachTime:
        """The least n from which on every start's law stays within ``tv`` of ``target``; None is uniform.

        inf where the stationary law itself is not nearer, surely so where ``earliest`` is inf too. Up to 500 cycles
        are looked at one by one; a longer wait is that for mixing to what the stationary law leaves of ``tv``: an
        upper estimate, its ``earliest`` 1.
        """
        limit, aim = _checked_limit(tv), FourierLaw.uniform() if target is None else target
        apart = self.law.total_variation(aim)
        if apart >= limit:
            return ReachTime(np.inf, np.inf if apart.lower > limit else 1, np.inf)
        settled = self._first_below(limit - apart)
        # From there on the law is near enough: the distance from the stationary law never grows.
        sure = self._surely_enough(settled, limit - apart.upper) if apart.upper < limit else np.inf
        if settled > _SCANNED:
            return ReachTime(settled, 1, sure)
        until = int(sure if sure <= _SCANNED else settled)
        curve = self._scanned(until, aim)
        found = _from_which_on(curve, limit)
        error = max(self._farthest(self._after(n), n, aim)[3] for n in {max(1, found - 1), found, until})
        latest = min(sure, _from_which_on(curve, limit - error)) if until == sure else sure
        return ReachTime(found, _from_which_on(curve, limit + error), latest)

    # -- inside --------------------------------------------------------------------------------------------

    @property
    def _basis(self) -> FourierDiscretisation:
        return fourier_basis(self.operator)

    @cached_property
    def _first(self) -> Array:
        """(n, angles): coefficients one cycle after every start."""
        return images_law(self._basis, self.grid.angles, self.grid.from_left)

    def _power(self, doublings: int) -> Array:
        """The matrix of 2^doublings cycles."""
        if not self._powers:
            self._powers.append(self._basis.matrix)
        while len(self._powers) <= doublings:
            self._powers.append(self._powers[-1] @ self._powers[-1])
        return self._powers[doublings]

    def _after(self, cycles: int) -> Array:
        columns, left = self._first, cycles - 1
        for k in range(left.bit_length()):
            if left >> k & 1:
                columns = self._power(k) @ columns
        return columns

    def _largest(self, columns: Array, target: FourierLaw | None = None) -> float:
        """The largest total variation distance of the columns' laws, on their grids."""
        return largest_variation(complex_moments(columns), self.law if target is None else target)

    def _scanned(self, cycles: int, target: FourierLaw) -> Array:
        """That distance after 1, ..., ``cycles`` cycles."""
        columns, found = self._first, np.empty(cycles)
        for n in range(cycles):
            found[n] = self._largest(columns, target)
            columns = self._basis.matrix @ columns
        return found

    def _first_below(self, limit: float) -> float:
        """The least n whose largest distance from the stationary law, on the grid, is at most ``limit``."""
        columns, gone = self._first, 1
        if self._largest(columns) <= limit:
            return 1
        doublings = next((k for k in range(_LONGEST) if self._largest(self._power(k) @ columns) <= limit), None)
        if doublings is None:
            return np.inf
        for k in reversed(range(doublings)):
            after = self._power(k) @ columns
            if self._largest(after) > limit:
                columns, gone = after, gone + (1 << k)
        return gone + 1

    def _surely_enough(self, cycles: float, limit: float) -> float:
        """The least n found whose distance with its error bound is at most ``limit``; inf where none is."""
        for _ in range(_ROUNDS):
            if not np.isfinite(cycles):
                break
            value, error = self._distance_after(int(cycles))
            if value + error <= limit:
                return cycles
            cycles = self._first_below(limit - error) if error < limit else np.inf
        return np.inf

    def _surely_too_few(self, cycles: float, limit: float) -> float:
        """One more than the largest n found whose distance less its error bound is above ``limit``."""
        for _ in range(_ROUNDS):
            if cycles <= 1 or not np.isfinite(cycles):
                break
            value, error = self._distance_after(int(cycles) - 1)
            if value - error > limit:
                return cycles
            cycles = min(cycles - 1, self._first_below(limit + error)) if error < 1.0 - limit else 1
        return 1

    def _distance_after(self, cycles: int) -> tuple[float, float]:
        found = self._farthest(self._after(cycles), cycles, None)
        return found[0], found[3]

    def _farthest(self, columns: Array, cycles: int, target: FourierLaw | None) -> tuple[float, ...]:
        """(TV, W1, start, their bounds) of the worst start after ``cycles``."""
        aim = self.law if target is None else target
        return farthest_start(complex_moments(columns), self.grid, aim, self._truncation(cycles))

    def _truncation(self, cycles: int) -> float:
        """Bound on the error of every law in L1: what each cycle leaves out, and the map's ``max_error`` (inf if cut).

        With all modes kept only quadrature and rounding are left out, as the stationary law measures them.
        """
        return cycles * self._left_a_cycle if is_resolved(self._basis) else float("inf")

    @cached_property
    def _left_a_cycle(self) -> float:
        left = self._basis.residual(real_coefficients(self.law.moments, self._basis.modes))
        return float(TWO_PI * left + 2.0 * self._basis.map.max_error * largest_density(self.operator.noise))


def enough_starts(basis: FourierDiscretisation) -> int:
    """So many even starts that no map carries two neighbours further apart than the noise, or the basis, resolves."""
    grid = TWO_PI * np.arange(_SLOPES) / _SLOPES
    steepest = max(float(np.max(np.abs(part.map.derivative(grid)))) for _, part in basis_parts(basis))
    width = max(1.0 / (np.sqrt(TWO_PI) * largest_density(basis.noise)), 2.0 / basis.modes)
    return int(np.clip(np.ceil(TWO_PI * steepest / width), _LEAST_STARTS, _MOST_STARTS))


def _checked_limit(tv: float) -> float:
    limit = finite_number("tv", tv)
    if not 0.0 < limit < 1.0:
        raise InvalidInput(f"tv is {limit:g}: a total variation to reach lies between 0 and 1")
    return limit


def _from_which_on(curve: Array, limit: float) -> int:
    """The least n from which on the curve, of n = 1, 2, ..., is at most ``limit``."""
    above = np.flatnonzero(curve > limit)
    return int(above[-1]) + 2 if above.size else 1
