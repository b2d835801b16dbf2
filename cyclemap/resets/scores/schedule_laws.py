"""Laws of the orientation under a schedule: in the long run, after n pushes from the worst start, and of means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_distances import density_on_grid
from cyclemap.maps.mixtures.law_evolution import complex_moments
from cyclemap.maps.mixtures.start_grid import StartGrid, start_grid
from cyclemap.maps.mixtures.worst_start import ReachTime, WorstStart, farthest_start, largest_variation, worst_starts
from cyclemap.maps.operator.fourier_discretisation import waves
from cyclemap.resets.scores.evenness import Evenness, Target, evenness
from cyclemap.resets.scores.schedule_chains import JointLaw, ScheduleChain

_SETTLING, _MOST_SETTLING, _WINDOW = 48, 240, 144  # pushes left out, at least and most; averaged over
HORIZON, _LONG_HORIZON = 2, 8  # times the pushes asked for: how far a reach is followed
_ROW = 8  # pushes that must be within, where there is no period
_SOLVED = 1e-9
_GRID = 2048
_NEGLIGIBLE = 1e-6  # of the largest singular value
_HARMONICS = (1, 2)


class Images(Protocol):
    """What gives the laws one push after angles."""

    def images(self, theta: Array) -> Array:
        """(operators, m, n): the law that each operator makes of each angle (m,)."""


@dataclass(frozen=True, eq=False)
class ScheduleLaws:
    """What follows from a schedule's chain.

    The stationary law of a schedule is the share of pushes, in a long run, at each orientation. The law after n pushes
    is over noise and the schedule's own chance, from the schedule's beginning.

    chain : of the schedule. operators : whose chain it is. first_guess : a law to settle from, (n,).
    starts : starting angles compared. pushes : that the curve is for.
    """

    chain: ScheduleChain
    operators: Images
    first_guess: Array
    starts: int
    pushes: int
    _followed: list[Any] = field(default_factory=list, init=False, repr=False)

    # -- the long run --------------------------------------------------------------------------------------

    @cached_property
    def law(self) -> FourierLaw:
        """Of a push drawn at random from a long run; its bound is measured.

        Measured by how far two halves of the followed runs are apart where a schedule never repeats, else what the
        solution leaves. Modes cut off are not in it; see ``halves`` for what is.
        """
        first, second = self.halves
        apart = density_on_grid(first.moments - second.moments, _GRID)
        return FourierLaw(_unit(complex_moments(self._mean)), float(np.max(np.abs(apart))) + _SOLVED)

    @cached_property
    def halves(self) -> tuple[FourierLaw, FourierLaw]:
        """The same law from every second of the followed runs, and from the others."""
        first, second = self._window.mean(axis=0)
        return FourierLaw(_unit(complex_moments(first))), FourierLaw(_unit(complex_moments(second)))

    def evenness(self, target: Target = None) -> Evenness:
        """Total variation and W1 of ``law`` from the target, and its peak to mean; None is uniform.

        Their errors are the distances between ``halves``, which no distance from a target can exceed, and the
        target's own.
        """
        found, (first, second) = evenness(replace(self.law, error_bound=_SOLVED), target), self.halves
        variation, distance = first.total_variation(second), first.wasserstein(second)
        return Evenness(
            Estimate(found.total_variation, found.total_variation.error_bound + variation),
            Estimate(found.wasserstein, found.wasserstein.error_bound + distance),
            Estimate(found.peak_to_mean, found.peak_to_mean.error_bound + TWO_PI * self.law.error_bound),
        )

    def phase_laws(self) -> tuple[FourierLaw, ...]:
        """The laws of single pushes in the long run, over one period or the pushes that ``law`` is the mean of."""
        return tuple(FourierLaw(_unit(complex_moments(part))) for part in self._window.mean(axis=1))

    def _limits(self) -> tuple[FourierLaw, ...]:
        """What laws after n pushes tend to: that of each push of a period, or ``law``, over all random beginnings."""
        return (self.law,) if self.chain.period is None else self.phase_laws()

    # -- from the worst start ------------------------------------------------------------------------------

    def worst(self, pushes: int, target: FourierLaw | None = None) -> WorstStart:
        """Largest distances from ``target``, None for uniform, over all starts after 1, ..., ``pushes`` pushes."""
        aim = FourierLaw.uniform() if target is None else target
        laws = self._laws_after(whole_number("pushes", pushes, least=1))
        return worst_starts([farthest_start(complex_moments(law), self.grid, aim, np.inf) for law, _ in laws])

    def within(self, tv: float, target: FourierLaw | None = None) -> ReachTime:
        """The least n from which on the law from any start stays within ``tv`` of ``target``; None is uniform.

        Until as many pushes in a row as a period has are within; inf where the long run itself is not. Not certified:
        ``latest`` is inf. Where twice ``pushes`` do not do (8 times, if the schedule returns to its beginning),
        it is inf too, and ``earliest`` is one more than that.
        """
        aim = FourierLaw.uniform() if target is None else target
        if max(float(law.total_variation(aim)) for law in self._limits()) >= tv:
            return ReachTime(np.inf, 1, np.inf)
        return self._first_from(tv, lambda law, _: _farthest(law, aim))

    def mixing_cycles(self, tv: float) -> ReachTime:
        """The least n from which on the law from any start is within ``tv`` of that of a run that had settled.

        Followed as in ``within``: the marginal laws of a schedule can come near within a period, and part again.
        """
        return self._first_from(tv, lambda law, settled: _farthest(law, FourierLaw(_unit(complex_moments(settled)))))

    # -- means ---------------------------------------------------------------------------------------------

    def effective_size(self, pushes: int = 100) -> Estimate:
        """Independent draws of ``law`` that ``pushes`` pushes are worth, for the worst mean of the first harmonics.

        Exactly for that many, from a start of ``law``: the covariance of the sums of cos θ, sin θ, cos 2θ, sin 2θ is
        followed with the law (b' = L(b + h p), p' = L p, b_h the law weighted by the sum so far). No bound: inf.
        """
        from scipy.linalg import eigh

        count = whole_number("pushes", pushes, least=1)
        moves = self._products
        here, size = moves[:, 0], len(moves)
        means, second = np.zeros(size), np.zeros((size, size))
        joint = self.chain.begin(np.concatenate([self._mean[None], np.zeros((size, self.chain.size))]))
        for _ in range(count):
            law = joint.rows[:, 0]
            weighted = np.stack([law @ move.T for move in moves], axis=1)
            sums = joint.rows[:, 1:] + weighted
            cross = here @ sums.sum(axis=0).T
            second += cross + cross.T - here @ weighted.sum(axis=0).T
            means += here @ law.sum(axis=0)
            joint = self.chain.advance(JointLaw(joint.push, np.concatenate([law[:, None], sums], axis=1)))
        once = here @ self._mean
        single = here @ (moves @ self._mean).T - np.outer(once, once)
        if not np.all(np.linalg.eigvalsh(single) > 0.0):
            raise ConvergenceError("the law is too inaccurate for variances: keep more modes, or raise the noise")
        worst = eigh((second - np.outer(means, means)) / count, single, eigvals_only=True)[-1]
        return Estimate(count / worst if worst > 0.0 else np.inf, np.inf)

    # -- inside --------------------------------------------------------------------------------------------

    @cached_property
    def grid(self) -> StartGrid:
        """The starting angles."""
        return start_grid(self.starts, np.empty(0))

    @property
    def _mean(self) -> Array:
        return np.asarray(self._window.mean(axis=(0, 1)))

    @cached_property
    def _window(self) -> Array:
        """(pushes, 2, n): laws of the pushes that a long run is averaged over, for each half of the followed runs."""
        return _window(self.chain, self.first_guess)

    def _laws_after(self, pushes: int) -> list[tuple[Array, Array]]:
        """For n = 1, ..., pushes: (n, starts) laws from the starts, and (n,) that of a run that had settled."""
        if not self._followed:
            settled = self.chain.advance(self.chain.begin(self._window[0].mean(axis=0)[None]))
            begun = self.chain.begin_after(self.operators.images(self.grid.angles))
            joint = JointLaw(1, np.concatenate([begun.rows, settled.rows], axis=1))
            self._followed.extend([joint, np.eye(joint.rows.shape[1]), []])
        joint, recipe, rows = self._followed
        while len(rows) < pushes:
            law = (recipe @ joint.marginal).T
            rows.append((law[:, :-1], law[:, -1]))
            joint = self.chain.advance(joint)
            if self.chain.period and joint.push % self.chain.period == 0:
                joint, recipe = _compressed(joint, recipe)
        self._followed[:2] = joint, recipe
        return list(rows[:pushes])

    def _first_from(self, tv: float, far: Callable[[Array, Array], float]) -> ReachTime:
        """The least n from which on ``far`` is at most ``tv``, as its last values, a period of them, show."""
        most, found = (HORIZON if self.chain.period is None else _LONG_HORIZON) * self.pushes, np.empty(0)
        row = self.chain.period or _ROW
        count = max(self.pushes, row)
        while True:
            laws = self._laws_after(count)[found.size :]
            found = np.append(found, [far(law, settled) for law, settled in laws])
            if np.all(found[-row:] <= tv):
                return ReachTime(_from_which_on(found, tv), 1, np.inf)
            if count >= most:
                return ReachTime(np.inf, count + 1, np.inf)
            count *= 2

    @cached_property
    def _products(self) -> Array:
        """(4, n, n): what multiplying a density by cos θ, sin θ, cos 2θ, sin 2θ does to its coefficients."""
        modes = self.chain.size // 2
        theta = TWO_PI * np.arange(4 * modes + 8) / (4 * modes + 8)
        rows = waves(theta, modes)
        scale = np.where(np.arange(self.chain.size) == 0, 1.0, 2.0) / theta.size
        return np.array([(rows * wave(k * theta)) @ (rows.T * scale) for k in _HARMONICS for wave in (np.cos, np.sin)])


def _farthest(laws: Array, aim: FourierLaw) -> float:
    return largest_variation(complex_moments(laws), aim)


def _window(chain: ScheduleChain, first_guess: Array) -> Array:
    """(pushes, 2, n): see ``ScheduleLaws``; both halves are alike where the chain returns to its state."""
    if chain.period is None:
        joint, length = _settled(chain, first_guess), _WINDOW
    else:
        joint, length = chain.begin(_returning(chain, first_guess)[None]), chain.period
    rows = []
    for n in range(length):
        rows.append([joint.marginal[0]] * 2 if chain.period else _halves(joint.rows[:, 0]))
        joint = chain.advance(joint) if n + 1 < length else joint
    return np.array(rows)


def _settled(chain: ScheduleChain, first_guess: Array) -> JointLaw:
    """After as many pushes as it takes until two laws to begin with are told apart by less than a hundredth."""
    tilted = np.zeros(chain.size)
    tilted[:2] = 1.0, 0.5
    joint = chain.begin(np.stack([first_guess, tilted]))
    for push in range(1, _MOST_SETTLING + 1):
        joint = chain.advance(joint)
        if push % _SETTLING == 0:
            first, second = joint.marginal
            if np.mean(np.abs(density_on_grid(complex_moments(first - second), _GRID))) < 2e-2 / TWO_PI:
                break
    return JointLaw(joint.push, joint.rows[:, :1])


def _returning(chain: ScheduleChain, first_guess: Array) -> Array:
    """The law that a whole period carries to itself, by GMRES on what a period changes (Saad & Schultz 1986)."""
    from scipy.sparse.linalg import LinearOperator, gmres

    def change(law: Array) -> Array:
        joint = chain.begin(law[None])
        for _ in range(chain.period or 1):
            joint = chain.advance(joint)
        return np.asarray(law - joint.marginal[0])

    size = chain.size - 1
    operator = LinearOperator((size, size), matvec=lambda part: change(np.append(0.0, part))[1:], dtype=np.float64)
    found, failed = gmres(operator, -change(first_guess)[1:], rtol=0.0, atol=_SOLVED, restart=size, maxiter=2)
    if failed:
        raise ConvergenceError("the law in the long run was not found: it hardly mixes; raise the noise")
    return np.asarray(first_guess + np.append(0.0, found))


def _compressed(joint: JointLaw, recipe: Array) -> tuple[JointLaw, Array]:
    """Fewer columns that span the same laws, at the schedule's beginning: starts are forgotten, to one law for all."""
    left, sizes, right = np.linalg.svd(joint.marginal, full_matrices=False)
    kept = sizes > _NEGLIGIBLE * sizes[0]
    return JointLaw(joint.push, (sizes[:, None] * right)[None, kept]), np.asarray(recipe @ left[:, kept])


def _unit(moments: Any) -> Any:
    return moments / moments[0].real


def _halves(rows: Array) -> list[Array]:
    """The laws (n,) of every second of the followed runs (runs, n) and of the others; the same where there is one."""
    parts = [rows[::2].sum(axis=0), rows[1::2].sum(axis=0)] if len(rows) > 1 else [rows[0]] * 2
    return [part / part[0] for part in parts]


def _from_which_on(curve: Array, limit: float) -> int:
    """The least n from which on the curve, of n = 1, 2, ..., is at most ``limit``."""
    above = np.flatnonzero(curve > limit)
    return int(above[-1]) + 2 if above.size else 1
