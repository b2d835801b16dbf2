"""What the data fix and how well: covariance honest about grouped errors, and directions that the data leave open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.grouped_errors import (
    grouped_variance,
    independent_freedom,
    weight_variance,
    with_known_variance,
)
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import Fit
from cyclemap.evidence.identification.noise_scales import NoiseLaw
from cyclemap.evidence.identification.priors import PRIOR_KIND

Array = NDArray[np.float64]

# A direction is open if its standard error, in the parameters' scales, exceeds this.
OPEN = 3.0
# Information below this share of the largest is rounding.
_RANK = 1e-12
# Least part of a parameter in a combination for it to be named.
_NAMED = 0.3


@dataclass(frozen=True, eq=False)
class OpenDirection:
    """A combination of parameters that the data do not fix.

    names : who takes part, the greatest part first. weights : change of each, in its own unit, along the direction.
    standard_error : along it, in the parameters' scales; inf where the data say nothing at all.
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    standard_error: float

    def __str__(self) -> str:
        if len(self.names) == 1:
            return f"{self.names[0]} is not fixed by the data"
        listed = ", ".join(self.names[:-1]) + f" and {self.names[-1]}"
        moves = ", ".join(f"{name} {weight:+.3g}" for name, weight in zip(self.names, self.weights, strict=True))
        return f"{listed} trade off: the data hardly tell a change of {moves}"


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Errors of a fit to first order.

    standard_error (k,) : inf for a parameter that the data do not fix. covariance (k, k), correlation (k, k) : without
    what is open. freedom (k,) : degrees of freedom for Student's t. inflation (k,) : variance over that of the inverse
    information. clustered : whether rows share groups. open : what the data do not fix.
    influence (k,) : standardised change of the residuals by one scale of each parameter.
    """

    standard_error: Array
    covariance: Array
    correlation: Array
    freedom: Array
    inflation: Array
    clustered: bool
    open: tuple[OpenDirection, ...]
    influence: Array


def uncertainty(problem: JointProblem, fit: Fit, law: NoiseLaw | None = None) -> Uncertainty:
    """Return the uncertainty of a fit from its derivatives, good to first order.

    Rows of single groups: the inverse information, with the freedom of `independent_freedom`. Where rows share groups:
    `grouped_variance`. To both `weight_variance` is added, since the weights of the kinds come from the data.
    """
    law, scale = law or NoiseLaw(), problem.space.scale
    jacobian = fit.jacobian / fit.noise[problem.kind_index, None] * scale
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    seen = values > _RANK * np.max(values, initial=0.0)
    inverse = vectors[:, seen] / values[seen] @ vectors[:, seen].T
    blind = np.sqrt(np.sum(vectors[:, ~seen] ** 2, axis=1)) > 1e-4
    covariance, freedom, clustered = _variance(problem, fit, law, jacobian, inverse)
    error, plain = np.sqrt(np.maximum(np.diag(covariance), 0.0)), np.diag(inverse) / law.information
    return Uncertainty(
        read_only(np.where(blind, np.inf, error * scale)),
        read_only(covariance * np.outer(scale, scale)),
        read_only(_correlation(covariance, error)),
        read_only(freedom),
        read_only(np.where(plain > 0.0, error**2 / np.where(plain > 0.0, plain, 1.0), 1.0)),
        clustered,
        _open_directions(problem, law.information * values, vectors, seen),
        read_only(np.linalg.norm(jacobian, axis=0)),
    )


def _variance(
    problem: JointProblem, fit: Fit, law: NoiseLaw, jacobian: Array, inverse: Array
) -> tuple[Array, Array, bool]:
    """Covariance (k, k) and its freedom (k,), all standardised, and whether rows share groups."""
    kinds, information = problem.kind_index, law.information
    known = np.zeros(len(fit.noise), dtype=bool) if fit.known is None else fit.known
    by_weights = weight_variance(jacobian, inverse, kinds, known) / information
    if len(np.unique(problem.groups)) == len(problem.groups):
        freedom = independent_freedom(jacobian, inverse, kinds, known)
        return inverse / information + 2.0 * by_weights, freedom, False
    scaled = fit.residuals / fit.noise[kinds]
    # A belief counts by its deviation, which is known, not by how far off it happened to be.
    belief = problem.kinds == PRIOR_KIND
    told, errors = jacobian[~belief], (law.weight(scaled**2) * scaled / information)[~belief]
    covariance, freedom = grouped_variance(told, errors, inverse, problem.groups[~belief])
    believed = jacobian[belief] @ inverse
    return *with_known_variance(covariance + by_weights, freedom, believed.T @ believed), True


def _correlation(covariance: Array, error: Array) -> Array:
    outer = np.outer(error, error)
    return np.where(outer > 0.0, covariance / np.where(outer > 0.0, outer, 1.0), np.eye(len(error)))


def _open_directions(problem: JointProblem, values: Array, vectors: Array, seen: Array) -> tuple[OpenDirection, ...]:
    found = []
    for value, vector, visible in zip(values, vectors.T, seen, strict=True):
        error = 1.0 / np.sqrt(value) if visible else np.inf
        if error <= OPEN:
            continue
        part = np.abs(vector)
        order = [index for index in np.argsort(-part).tolist() if part[index] >= _NAMED * np.max(part)]
        names = tuple(problem.space.names[index] for index in order)
        signed = vector * np.sign(vector[order[0]]) * problem.space.scale
        found.append(OpenDirection(names, tuple(float(signed[index]) for index in order), float(error)))
    return tuple(found)


def student_quantile(level: float, freedom: float) -> float:
    """Return t such that a Student variable lies within -t and t with probability `level`.

    >>> round(student_quantile(0.95, 10_000_000), 4)
    1.96
    """
    from scipy.special import stdtrit

    probability = finite_number("level", level)
    if not 0.0 < probability < 1.0:
        raise InvalidInput(f"level is {level!r}; it must be a probability between 0 and 1, such as 0.95")
    return float(stdtrit(freedom, 0.5 + 0.5 * probability))
