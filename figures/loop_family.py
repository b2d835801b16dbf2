"""Families of loops: their cycle maps interpolated over a parameter or two, and variants of a loop
along one fact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebpts2, chebval, chebvander
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array, even_angles
from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy, with_anisotropy
from cyclemap.errors import ConvergenceError
from cyclemap.maps import CircleMap, ParametricLift
from cyclemap.sweeps.direction_margins import smooth_change

Range = tuple[float, float]
LoopAt = Callable[..., CollectionLoop]
# Metres, of differences by the radius.
_LENGTH_STEP = 1e-6


@dataclass(frozen=True, eq=False)
class LoopFamily:
    """The cycle maps of a family of loops, interpolated.

    loop_at : parameters -> loop.
    ranges : (low, high) of each parameter.
    coefficients : (n₁, ..., K) complex: by Chebyshev polynomials of the parameters the Fourier
        coefficients of the turn: the real part of Σ c_k e^{ikθ} is the turn f(θ) - θ in rad. Called
        with one number a parameter it gives the CircleMap.

    Where the mechanics is smooth the error falls with every node; kinks of f' (stick to slip) slow
    that down. Measure it with `error_at`.
    """

    loop_at: LoopAt
    ranges: tuple[Range, ...]
    coefficients: NDArray[np.complex128]

    def series(self, *parameters: ArrayLike) -> NDArray[np.complex128]:
        """Return the coefficients (K, ...) of the turn at parameters of shape (...) each."""
        series = self.coefficients
        for index, (value, (low, high)) in enumerate(zip(parameters, self.ranges, strict=True)):
            place = (2.0 * np.asarray(value, dtype=float) - low - high) / (high - low)
            series = np.asarray(chebval(place, series, tensor=index == 0), dtype=complex)
        return series

    def turn(self, theta: ArrayLike, *parameters: ArrayLike) -> Array:
        """Return f(θ) - θ (rad); θ and parameters broadcast."""
        return _wave(theta, self.series(*parameters))

    def slope(self, theta: ArrayLike, *parameters: ArrayLike) -> Array:
        """Return f'(θ); θ and parameters broadcast."""
        return 1.0 + _wave(theta, _derivative(self.series(*parameters)))

    def __call__(self, *parameters: float) -> CircleMap:
        """Return the cycle map at one number a parameter."""
        series = self.series(*parameters)
        slopes = _derivative(series)
        return CircleMap(
            lambda theta: theta + _wave(theta, series), lambda theta: 1.0 + _wave(theta, slopes)
        )

    @property
    def parametric(self) -> ParametricLift:
        """The family in the form that the tools for many maps at once take."""
        return ParametricLift(
            lambda theta, *p: theta + self.turn(theta, *p), self.slope, circle_map=self
        )

    def error_at(self, theta: ArrayLike, *parameters: float) -> Array:
        """Return |interpolated - computed| (rad) of f at angles (...), running the mechanics."""
        angles = np.asarray(theta, dtype=float)
        return np.asarray(
            np.abs(self(*parameters)(angles) - self.loop_at(*parameters).next_theta(angles))
        )


def loop_family(
    loop_at: LoopAt, ranges: tuple[Range, ...], nodes: tuple[int, ...], angles: int
) -> LoopFamily:
    """Run `angles` cycles at each of `nodes` Chebyshev nodes a parameter (one or two), and
    interpolate them.

    >>> from cyclemap.protocol import loop_from_settings
    >>> push = lambda distance: loop_from_settings({"push_mm": distance})
    >>> family = loop_family(push, ((100.0, 120.0),), (2,), 8)
    >>> family.coefficients.shape
    (2, 5)
    """
    grid = np.meshgrid(
        *(chebyshev_nodes(*ends, n) for ends, n in zip(ranges, nodes, strict=True)), indexing="ij"
    )
    theta = even_angles(angles)
    places = np.reshape(grid, (len(nodes), -1)).T.tolist()
    turns = np.array([loop_at(*place).next_theta(theta) - theta for place in places])
    series = np.fft.rfft(turns, axis=-1) / angles
    # Each wave but the mean and, for an even count, the fastest stands for two of the transform's.
    series[:, 1 : (angles + 1) // 2] *= 2.0
    series = series.reshape(*nodes, -1)
    for axis, count in enumerate(nodes):
        from_nodes = np.linalg.inv(chebvander(chebpts2(count), count - 1))
        series = np.moveaxis(np.tensordot(from_nodes, series, (1, axis)), 0, axis)
    return LoopFamily(loop_at, ranges, series)


def chebyshev_nodes(low: float, high: float, count: int) -> Array:
    """Return the `count` (2 or more) Chebyshev points of [low, high], ends included, in order.

    >>> chebyshev_nodes(0.0, 2.0, 3).round(9).tolist()
    [0.0, 1.0, 2.0]
    """
    return np.asarray(low + (high - low) * (0.5 + 0.5 * chebpts2(count)))


def _wave(theta: ArrayLike, series: NDArray[np.complex128]) -> Array:
    """The real part of Σ c_k e^{ikθ} with coefficients (K, ...), which broadcast over θ."""
    wave = polyval(np.exp(1j * np.asarray(theta, dtype=float)), series, tensor=False)
    return np.asarray(wave.real, dtype=float)


def _derivative(series: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The coefficients (K, ...) of a wave's derivative."""
    return (1j * np.arange(len(series)) * series.T).T


def ring_radius(loop: CollectionLoop) -> float:
    """Return the ring's distance from the object's origin, m."""
    return math.hypot(*loop.slider.hitch)


def with_ring_at(loop: CollectionLoop, radius: float) -> CollectionLoop:
    """Return the loop with its ring at a distance (m, positive) from the object's origin, in the
    same direction.

    >>> round(1000 * ring_radius(with_ring_at(CollectionLoop.mit(), 0.01)), 9)
    10.0
    """
    scale = positive_number("ring radius", radius) / ring_radius(loop)
    x, y = loop.slider.hitch
    return replace(loop, slider=replace(loop.slider, hitch=(scale * x, scale * y)))


def with_anisotropy_times(loop: CollectionLoop, scale: float) -> CollectionLoop:
    """Return the loop on a surface with its offset and ellipticity times `scale`: 0 isotropic, 1 as
    it is. The result does not wear.

    >>> with_anisotropy_times(CollectionLoop.mit(), 0.0).material.friction.m0
    0.0
    """
    return with_anisotropy(loop, Anisotropy.of(loop.material.friction).scaled(scale))


@dataclass(frozen=True)
class RingFold:
    """A saddle-node of the cycle map over the ring's radius: f(θ) = θ and f'(θ) = 1.

    theta : rad.
    radius : m.
    by_radius : ∂f/∂radius, rad/m.
    curvature : half of f'', per rad: the move of a cycle beside it is by_radius·(r - radius) +
        curvature·(θ - theta)².
    """

    theta: float
    radius: float
    by_radius: float
    curvature: float

    def passage_cycles(self, radius: float) -> float:
        """Return the cycles π/√(ε a) that the bottleneck takes at a radius (m) beyond the fold; inf
        where locked.
        """
        product = self.by_radius * (radius - self.radius) * self.curvature
        return math.pi / math.sqrt(product) if product > 0.0 else math.inf


def ring_fold(loop_at: LoopAt, theta: float, radius: float) -> RingFold:
    """Solve f(θ) = θ, f'(θ) = 1 for angle and radius by Newton's method from `theta` (rad) and
    `radius` (m).

    loop_at : radius -> loop.

    Raises ConvergenceError where no fold is found between half and twice the radius.
    """
    change = smooth_change(
        loop_at, (theta, radius), 1.0, _LENGTH_STEP, (0.5 * radius, 2.0 * radius)
    )
    if change is None:
        raise ConvergenceError(
            f"no saddle-node found near {math.degrees(theta):.4g} deg and {1000 * radius:.4g} mm: "
            "start nearer"
        )
    (_, by_radius), (bend, _) = change.slopes.tolist()
    return RingFold(change.theta, float(change.value), by_radius, 0.5 * bend)
