"""What the data fix and how well: covariance honest about grouped errors, and directions that the
data leave open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.checks import read_only
from cyclemap.evidence.identification.data_block import BELIEF_KINDS, JointProblem, Labels
from cyclemap.evidence.identification.least_squares import NORMAL, Fit, NoiseLaw

_NORMAL = 1e9
# A direction is open if its standard error, in the parameters' scales, exceeds this.
OPEN = 3.0
# Information below this share of the largest is rounding.
_RANK = 1e-12
# Least part of a parameter in a combination for it to be named.
_NAMED = 0.3


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Errors of a fit to first order.

    Attributes
    ----------
    standard_error : ndarray, shape (k,)
        Inf for a parameter that the data do not fix.
    covariance, correlation : ndarray, shape (k, k)
        Without what is open.
    freedom : ndarray, shape (k,)
        Degrees of freedom for Student's t.
    open : tuple of str
        Which parameters, or combinations of them, the data do not fix, in words.
    """

    standard_error: Array
    covariance: Array
    correlation: Array
    freedom: Array
    open: tuple[str, ...]


def uncertainty(problem: JointProblem, fit: Fit, law: NoiseLaw = NORMAL) -> Uncertainty:
    """Return the uncertainty of a fit from its derivatives, good to first order.

    Rows of single groups, or of noise that was given: the inverse information. Where rows share
    groups otherwise: the sandwich of Liang & Zeger. To both comes what estimating the weights of
    the kinds from the same data costs, and by how much the fit is off since predictions are
    computed.

    Raises what the model raises where it is computed more closely.
    """
    scale = problem.space.scale
    kinds = problem.kind_index
    jacobian = fit.jacobian / fit.noise[kinds, None] * scale
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    seen = values > _RANK * np.max(values, initial=0.0)
    inverse = vectors[:, seen] / values[seen] @ vectors[:, seen].T
    blind = np.sqrt(np.sum(vectors[:, ~seen] ** 2, axis=1)) > 1e-4
    by_weights, share, redundancy = _kind_variance(jacobian, inverse, kinds, fit.known)
    by_weights /= law.information
    is_given = bool(np.all(fit.known[kinds]))
    if is_given or len(np.unique(problem.groups)) == len(problem.groups):
        covariance = inverse / law.information + 2.0 * by_weights
        freedom = _degrees(np.sum(share, axis=0) ** 2, np.sum(share**2 / redundancy, axis=0))
    else:
        scaled = fit.residuals / fit.noise[kinds]
        # A belief counts by its deviation, which is known, not by how far off it happened to be.
        belief = np.isin(problem.kinds, BELIEF_KINDS)
        errors = (law.weight(scaled**2) * scaled / law.information)[~belief]
        sandwich, of_groups = _grouped_variance(
            jacobian[~belief], errors, inverse, problem.groups[~belief]
        )
        believed = jacobian[belief] @ inverse
        covariance = sandwich + by_weights + believed.T @ believed
        # Each adds its variance's square over its freedom (Satterthwaite 1946); a belief of known
        # width has no end of freedom, sessions have as much as tells how they differ.
        is_belief = np.isin(problem.kind_names, BELIEF_KINDS)
        spent = np.diag(sandwich + by_weights) ** 2 / of_groups
        spent += np.sum(share[is_belief] ** 2 / redundancy[is_belief], axis=0)
        freedom = _degrees(np.diag(covariance) ** 2, spent)
    covariance = covariance + _computed_variance(problem, fit, jacobian, inverse)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    outer = np.outer(error, error)
    correlation = np.divide(covariance, outer, out=np.eye(error.size), where=outer > 0.0)
    return Uncertainty(
        read_only(np.where(blind, np.inf, error * scale)),
        read_only(covariance * np.outer(scale, scale)),
        read_only(correlation),
        read_only(freedom),
        _open_directions(problem, law.information * values, vectors, seen),
    )


def _kind_variance(
    jacobian: Array, inverse: Array, kinds: Labels, known: Mask
) -> tuple[Array, Array, Array]:
    """Covariance (k, k) that comes on top because the weights of the kinds are estimated; what each
    kind adds to the variances (kinds, k), and its redundancy (kinds, 1), its degrees of freedom.

    To first order the sum over kinds of 2 / redundancy times inverse (A - A inverse A) inverse, A
    the kind's part of jacobian^T jacobian (Kackar & Harville 1984); the inverse information itself
    is too small by as much again (Kenward & Roger 1997).
    """
    leverage = np.einsum("ni,ij,nj->n", jacobian, inverse, jacobian)
    redundancy = np.where(known, np.inf, np.maximum(np.bincount(kinds, 1.0 - leverage), 0.1))
    total = np.zeros_like(inverse)
    share = np.zeros((len(redundancy), len(inverse)))
    for kind, rest in enumerate(redundancy):
        own = jacobian[kinds == kind] @ inverse
        square = own.T @ own
        total += 2.0 / rest * (square - own.T @ jacobian[kinds == kind] @ square)
        share[kind] = np.diag(square)
    return total, share, redundancy[:, None]


def _grouped_variance(
    jacobian: Array, errors: Array, inverse: Array, groups: Labels
) -> tuple[Array, Array]:
    """Covariance (k, k) that allows for any dependence within groups, and its degrees of freedom
    (k,).

    The sandwich of Liang & Zeger (1986), each group's errors first freed of their own pull on the
    fit; the freedom is Satterthwaite's for independent rows (Bell & McCaffrey 2002, CR2). Few or
    unequal groups have little freedom.
    """
    order = np.argsort(groups, kind="stable")
    meat = []
    own = []
    pull = []
    for rows in np.split(order, np.flatnonzero(np.diff(groups[order])) + 1):
        slopes = jacobian[rows]
        # The inverse square root; directions that the fit follows wholly have none and give zero.
        values, vectors = np.linalg.eigh(np.eye(len(rows)) - slopes @ inverse @ slopes.T)
        root = np.where(values > 1e-8, 1.0 / np.sqrt(np.maximum(values, 1e-8)), 0.0)
        freed = vectors * root @ vectors.T @ slopes
        meat.append(freed.T @ errors[rows])
        own.append(np.sum((freed @ inverse) ** 2, axis=0))
        pull.append(slopes.T @ freed @ inverse)
    scores = np.array(meat) @ inverse
    each = np.array(own)
    pulled = np.array(pull)
    # Trace squared over squared norm of the quadratic form that estimates the variance of parameter
    # p: its matrix is diag(each_p) - U inverse U^T, U = pulled[:, :, p].
    fed = np.einsum("ij,gjp->gip", inverse, pulled)
    square = np.einsum("gip,gjp->pij", fed, pulled)
    trace = np.sum(each, axis=0) - np.einsum("pii->p", square)
    cross = np.einsum("gp,gip,gip->p", each, fed, pulled)
    norm = np.sum(each**2, axis=0) - 2.0 * cross + np.einsum("pij,pji->p", square, square)
    return scores.T @ scores, _degrees(trace**2, norm)


def _computed_variance(problem: JointProblem, fit: Fit, jacobian: Array, inverse: Array) -> Array:
    """Covariance (k, k) that comes on top because predictions are computed: their errors as they
    are, which move the fit as one, and, since these are a sample, any others so large at random.
    """
    kinds = problem.kind_index
    off = problem.numerical_errors(fit.vector) / fit.noise[kinds]
    moved = inverse @ (jacobian.T @ off)
    largest = np.zeros(fit.noise.size)
    np.maximum.at(largest, kinds, np.abs(off))
    spread = jacobian * largest[kinds, None] @ inverse
    return np.outer(moved, moved) + spread.T @ spread


def _degrees(above: Array, below: Array) -> Array:
    """The ratio, between one and so many that Student is normal."""
    return np.clip(above / np.maximum(below, 1e-300), 1.0, _NORMAL)


def _open_directions(
    problem: JointProblem, values: Array, vectors: Array, seen: Array
) -> tuple[str, ...]:
    """Of each direction that the data leave open the parameters that take part, the greatest part
    first.
    """
    directions = []
    for value, vector, visible in zip(values, vectors.T, seen, strict=True):
        if visible and value >= OPEN**-2:
            continue
        share = np.abs(vector)
        order = [
            index for index in np.argsort(-share).tolist() if share[index] >= _NAMED * np.max(share)
        ]
        *names, last = (problem.space.names[index] for index in order)
        signed = vector * np.sign(vector[order[0]]) * problem.space.scale
        moves = ", ".join(
            f"{name} {signed[k]:+.3g}" for name, k in zip((*names, last), order, strict=True)
        )
        together = (
            f"{', '.join(names)} and {last} trade off: the data hardly tell a change of {moves}"
        )
        directions.append(together if names else f"{last} is not fixed by the data")
    return tuple(directions)
