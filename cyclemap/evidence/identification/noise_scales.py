"""The size of each kind of noise, estimated from the residuals, and the loss that goes with normal or Student noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.identification.joint_problem import JointProblem

# Noise smaller than this share of the residuals at the start is no noise, but rounding.
_LEAST_NOISE = 1e-9
# A kind with fewer rows left over, once the parameters took their share, does not tell its noise.
_LEAST_REDUNDANCY = 0.5
# The noise of given residuals stands still at a change below this share, which takes a dozen rounds.
_WEIGHTINGS, _SETTLED = 100, 1e-4


@dataclass(frozen=True)
class NoiseLaw:
    """Distribution of the standardised residuals: normal, or Student's with `freedom` degrees of freedom.

    With z the squared standardised residual, rho(z) = z, or (freedom + 1) log(1 + z / freedom), which lets outliers
    count for little (Lange, Little & Taylor 1989). Raises InvalidInput for a freedom of one or less.

    >>> NoiseLaw(4.0).weight(np.array([0.0, 96.0])).tolist()
    [1.25, 0.05]
    """

    freedom: float | None = None

    def __post_init__(self) -> None:
        if self.freedom is not None and finite_number("degrees of freedom of the noise", self.freedom) <= 1.0:
            raise InvalidInput(f"degrees of freedom of the noise must exceed one, not {self.freedom!r}")

    def loss(self, z: Array) -> Array:
        """Return rho, rho' and rho'' at squared standardised residuals (n,): (3, n)."""
        if self.freedom is None:
            return np.stack([z, np.ones_like(z), np.zeros_like(z)])
        m, weight = self.freedom, self.weight(z)
        return np.stack([(m + 1.0) * np.log1p(z / m), weight, -weight / (m + z)])

    def weight(self, z: Array) -> Array:
        """Return how much each row counts, rho'(z)."""
        return np.ones_like(z) if self.freedom is None else (self.freedom + 1.0) / (self.freedom + z)

    @property
    def information(self) -> float:
        """Fisher information of one row about its mean, in units of 1/noise^2."""
        return 1.0 if self.freedom is None else (self.freedom + 1.0) / (self.freedom + 3.0)


def noise_floor(problem: JointProblem, residuals: Array) -> Array:
    """Return the least size of each kind's noise, (kinds,), from the residuals of a first try."""
    return np.maximum(_LEAST_NOISE * root_mean_square(problem, residuals), 1e-30)


def root_mean_square(problem: JointProblem, residuals: Array) -> Array:
    """Return the root mean square of the residuals of each kind, (kinds,)."""
    index, count = problem.kind_index, len(problem.kind_names)
    return np.asarray(np.sqrt(np.bincount(index, residuals**2, count) / np.bincount(index, minlength=count)))


def estimated_noise(
    problem: JointProblem, residuals: Array, jacobian: Array, noise: Array, law: NoiseLaw, floor: Array, held: Array
) -> Array:
    """Return the next estimate (kinds,) of the noise, the residuals' sum of squares over their redundancy.

    The redundancy of a kind is its number of rows less their share in fixing the parameters, the trace of the hat
    matrix; repeated with a fit in between, this leads to restricted maximum likelihood (Foerstner 1979). Rows count as
    the noise found makes them count. `held`
    (kinds,) is noise that is known, nan elsewhere. Raises ConvergenceError where the parameters follow all rows of a
    kind, so that its noise cannot be told.
    """
    index, count = problem.kind_index, len(problem.kind_names)
    scaled = residuals / noise[index]
    weight = law.weight(scaled**2)
    leverage = _leverage(jacobian / noise[index, None] * np.sqrt(weight)[:, None])
    redundancy = np.bincount(index, 1.0 - leverage, count)
    for kind in np.flatnonzero((redundancy < _LEAST_REDUNDANCY) & np.isnan(held)).tolist():
        raise ConvergenceError(
            f"the parameters can follow all rows of {problem.kind_names[kind]!r} (redundancy {redundancy[kind]:.2g}): "
            "give its noise, or more data"
        )
    # Weights follow the noise, which costs nothing; what a row leaves over stays, and is told anew after the next fit.
    for _ in range(_WEIGHTINGS):
        square = np.bincount(index, weight * residuals**2, count) / np.maximum(redundancy, _LEAST_REDUNDANCY)
        before, noise = noise, np.where(np.isnan(held), np.maximum(np.sqrt(square), floor), held)
        if np.max(np.abs(np.log(noise / before))) < _SETTLED:
            break
        weight = law.weight((residuals / noise[index]) ** 2)
    return noise


def _leverage(jacobian: Array) -> Array:
    """Diagonal of the hat matrix, (n,)."""
    size = np.linalg.norm(jacobian, axis=0)
    columns = jacobian[:, size > 0.0] / size[size > 0.0]
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    kept = values > 1e-10 * np.max(values, initial=0.0)
    return np.asarray(np.sum(left[:, kept] ** 2, axis=1))
