"""Variance of least squares and its degrees of freedom, for independent rows and for rows that share groups."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array

Labels = NDArray[np.int64]

_NORMAL = 1e9


def independent_freedom(jacobian: Array, inverse: Array, kinds: Labels, known: ArrayLike = False) -> Array:
    """Degrees of freedom (k,) of each parameter's variance where every kind of row has a noise of its own.

    jacobian (n, k) and inverse (k, k) of its square, both in units of the noise; kinds (n,) 0 ... count - 1;
    known (kinds,) whether a kind's noise was given.
    Each kind adds its share to the variance, known as well as the kind's redundancy (rows less leverage) allows:
    freedom = (sum c)^2 / sum(c^2 / redundancy) (Satterthwaite 1946). One kind gives n - k for each parameter.

    >>> independent_freedom(np.ones((5, 1)), np.array([[0.2]]), np.zeros(5, dtype=int))
    array([4.])
    """
    redundancy = _redundancy(jacobian, inverse, kinds, known)
    share = np.zeros((len(redundancy), jacobian.shape[1]))
    np.add.at(share, kinds, (jacobian @ inverse) ** 2)
    return _degrees(np.sum(share, axis=0) ** 2, np.sum(share**2 / redundancy[:, None], axis=0))


def weight_variance(jacobian: Array, inverse: Array, kinds: Labels, known: ArrayLike = False) -> Array:
    """Covariance (k, k) that comes on top because the weights of the kinds are estimated from the same data.

    To first order, for independent rows: the sum over kinds of 2 / redundancy times inverse (A - A inverse A) inverse,
    A the kind's part of jacobian^T jacobian (Kackar & Harville 1984). The inverse information itself is too small by
    as much again (Kenward & Roger 1997). Zero for a single kind, and for kinds whose noise is `known`.

    >>> weight_variance(np.ones((4, 1)), np.array([[0.25]]), np.array([0, 0, 1, 1])).round(6).tolist()
    [[0.166667]]
    """
    total = np.zeros_like(inverse)
    for kind, redundancy in enumerate(_redundancy(jacobian, inverse, kinds, known)):
        part = jacobian[kinds == kind] @ inverse
        square = part.T @ part
        own = part.T @ jacobian[kinds == kind]
        total += 2.0 / redundancy * (square - own @ square)
    return total


def _redundancy(jacobian: Array, inverse: Array, kinds: Labels, known: ArrayLike) -> Array:
    """Rows of each kind less their leverage, (kinds,); without end for known noise."""
    leverage = np.einsum("ni,ij,nj->n", jacobian, inverse, jacobian)
    return np.where(known, np.inf, np.maximum(np.bincount(kinds, 1.0 - leverage), 0.1))


def grouped_variance(jacobian: Array, errors: Array, inverse: Array, groups: Labels) -> tuple[Array, Array]:
    """Covariance (k, k) that allows for any dependence within groups, and its degrees of freedom (k,).

    jacobian (n, k), errors (n,), inverse (k, k) of jacobian^T jacobian, in units of the noise; groups (n,).
    The sandwich of Liang & Zeger (1986), each group's errors first freed of their own pull on the fit; the freedom is
    Satterthwaite's for independent rows (Bell & McCaffrey 2002, CR2). Few or unequal groups have little freedom.
    """
    order = np.argsort(groups, kind="stable")
    meat, own, pull = [], [], []
    for rows in np.split(order, np.flatnonzero(np.diff(groups[order])) + 1):
        part = jacobian[rows]
        freed = _inverse_root(np.eye(len(rows)) - part @ inverse @ part.T) @ part
        meat.append(freed.T @ errors[rows])
        own.append(np.sum((freed @ inverse) ** 2, axis=0))
        pull.append(part.T @ freed @ inverse)
    scores = np.array(meat) @ inverse
    return scores.T @ scores, _grouped_freedom(np.array(own), np.array(pull), inverse)


def with_known_variance(estimated: Array, freedom: Array, known: Array) -> tuple[Array, Array]:
    """Covariance (k, k) and freedom (k,) where a known covariance comes on top of one estimated with a freedom.

    Satterthwaite's (1946): the known part has no end of freedom, so freedom = that of the estimate / (its share)^2.

    >>> with_known_variance(np.array([[1.0]]), np.array([3.0]), np.array([[1.0]]))
    (array([[2.]]), array([12.]))
    """
    total = estimated + known
    share = np.diag(estimated) / np.maximum(np.diag(total), 1e-300)
    return total, _degrees(freedom, share**2)


def _inverse_root(matrix: Array) -> Array:
    """Inverse square root of a symmetric matrix; directions that the fit follows wholly have none and give zero."""
    values, vectors = np.linalg.eigh(matrix)
    root = np.where(values > 1e-8, 1.0 / np.sqrt(np.maximum(values, 1e-8)), 0.0)
    return np.asarray(vectors * root @ vectors.T)


def _grouped_freedom(own: Array, pull: Array, inverse: Array) -> Array:
    """Trace squared over squared norm of the quadratic form that estimates each variance.

    With own (g, k) and pull (g, k, k), its matrix for parameter j is diag(own_j) - U inverse U^T, U = pull[:, :, j].
    """
    fed = np.einsum("ij,gjp->gip", inverse, pull)
    square = np.einsum("gip,gjp->pij", fed, pull)
    trace = np.sum(own, axis=0) - np.einsum("pii->p", square)
    cross = np.einsum("gp,gip,gip->p", own, fed, pull)
    return _degrees(trace**2, np.sum(own**2, axis=0) - 2.0 * cross + np.einsum("pij,pji->p", square, square))


def _degrees(above: Array, below: Array) -> Array:
    """The ratio, between one and so many that Student is normal."""
    return np.clip(above / np.maximum(below, 1e-300), 1.0, _NORMAL)
