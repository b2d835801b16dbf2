"""Families of loops whose cycle maps are one formula: Fourier in the angle, Chebyshev in the parameters."""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import CircleMap, ParametricLift

Range = tuple[float, float]
LoopAt = Callable[..., CollectionLoop]


@dataclass(frozen=True, eq=False)
class LoopFamily:
    """The cycle maps of a family of loops, interpolated.

    loop_at : parameters -> loop. ranges : (low, high) of each parameter. coefficients : (n₁, ..., K) complex: at each
    Chebyshev node of the parameters the Fourier coefficients of the turn, of which the real part of Σ c_k e^{ikθ}
    is the turn f(θ) - θ in rad. Called with one number a parameter it gives the CircleMap.

    Where the mechanics is smooth the error falls with every node; kinks of f' (stick to slip) slow that down. Measure
    it with `error_at`.
    """

    loop_at: LoopAt
    ranges: tuple[Range, ...]
    coefficients: NDArray[np.complex128]

    def series(self, *parameters: Any) -> NDArray[np.complex128]:
        """Return the coefficients (..., K) of the turn at parameters of shape (...) each."""
        weights = [
            _barycentric(np.asarray(value, dtype=float), chebyshev_nodes(*ends, count))
            for value, ends, count in zip(parameters, self.ranges, self.coefficients.shape, strict=False)
        ]
        if len(weights) == 1:
            return np.asarray(weights[0] @ self.coefficients)
        return np.asarray(np.einsum("...i,...j,ijk->...k", *weights, self.coefficients))

    def turn(self, theta: Any, *parameters: Any) -> Array:
        """Return f(θ) - θ (rad); θ and parameters broadcast."""
        return np.asarray(_horner(np.asarray(theta, dtype=float), self.series(*parameters)).real)

    def slope(self, theta: Any, *parameters: Any) -> Array:
        """Return f'(θ); θ and parameters broadcast."""
        series = self.series(*parameters)
        return np.asarray(1.0 + _horner(np.asarray(theta, dtype=float), 1j * np.arange(series.shape[-1]) * series).real)

    def __call__(self, *parameters: float) -> CircleMap:
        """Return the cycle map at one number a parameter."""
        series = self.series(*parameters)
        slopes = 1j * np.arange(series.size) * series
        descending = series[::-1].tolist()

        def scalar(theta: float) -> float:
            turner = cmath.exp(1j * theta)
            return theta + reduce(lambda total, coefficient: total * turner + coefficient, descending, 0j).real

        return CircleMap.with_scalar(
            lambda theta: theta + _horner(theta, series).real, lambda theta: 1.0 + _horner(theta, slopes).real, scalar
        )

    @property
    def parametric(self) -> ParametricLift:
        """The family in the form that the tools for many maps at once take."""
        return ParametricLift(lambda theta, *p: theta + self.turn(theta, *p), self.slope, circle_map=self)

    def error_at(self, theta: Any, *parameters: float) -> Array:
        """Return |interpolated - computed| (rad) of f at angles (...), running the mechanics."""
        angles = np.asarray(theta, dtype=float)
        return np.asarray(np.abs(self(*parameters)(angles) - self.loop_at(*parameters).next_theta(angles)))


def loop_family(loop_at: LoopAt, ranges: tuple[Range, ...], nodes: tuple[int, ...], angles: int) -> LoopFamily:
    """Run `angles` cycles at each of `nodes` Chebyshev nodes a parameter (one or two), and interpolate them.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> push = lambda distance: CollectionLoop.from_settings({"push_mm": distance})
    >>> family = loop_family(push, ((100.0, 120.0),), (2,), 8)
    >>> family.coefficients.shape
    (2, 5)
    """
    grid = np.meshgrid(*(chebyshev_nodes(*ends, n) for ends, n in zip(ranges, nodes, strict=True)), indexing="ij")
    theta = 2.0 * np.pi * np.arange(angles) / angles
    loops = [loop_at(*place) for place in zip(*(axis.ravel().tolist() for axis in grid), strict=True)]
    turns = np.array([loop.next_theta(theta) - theta for loop in loops])
    series = np.fft.rfft(turns, axis=-1) / angles
    # Each wave but the mean and, for an even count, the fastest stands for two of the transform's.
    series[:, 1 : (angles + 1) // 2] *= 2.0
    return LoopFamily(loop_at, ranges, series.reshape(*nodes, -1))


def chebyshev_nodes(low: float, high: float, count: int) -> Array:
    """Return the `count` (2 or more) Chebyshev points of [low, high], ends included, in order.

    >>> chebyshev_nodes(0.0, 2.0, 3).round(9).tolist()
    [0.0, 1.0, 2.0]
    """
    share = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / (count - 1))
    return np.asarray(low + (high - low) * share)


def _barycentric(value: Array, nodes: Array) -> Array:
    """The weights (..., n) of the nodes in the polynomial through them, at values (...) (Berrut & Trefethen 2004)."""
    signs = (-1.0) ** np.arange(nodes.size)
    signs[[0, -1]] *= 0.5
    off = value[..., np.newaxis] - nodes
    hit = off == 0.0
    with np.errstate(divide="ignore"):
        weights = np.where(hit.any(axis=-1, keepdims=True), hit, signs / np.where(hit, 1.0, off))
    return np.asarray(weights / weights.sum(axis=-1, keepdims=True))


def _horner(theta: Array, series: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Σ c_k e^{ikθ} with coefficients (..., K), which broadcast over θ."""
    turner, total = np.exp(1j * theta), np.zeros(np.broadcast_shapes(theta.shape, series.shape[:-1]), dtype=complex)
    for k in range(series.shape[-1] - 1, -1, -1):
        total = total * turner + series[..., k]
    return total
