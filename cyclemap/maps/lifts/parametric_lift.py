"""Families of lifts given by one formula that broadcasts over its parameters, ready for vectorised sweeps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.checks import finite_array, finite_number, non_negative_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap

ParametricFunction = Callable[..., Array]
_ANGLES = np.linspace(0.0, TWO_PI, 65)  # where a lift of unknown kind is looked at for folds
_FALL = 1e-12  # radians: a smaller descent is rounding


@dataclass(frozen=True, eq=False)
class ParametricLift:
    """A family of degree-1 lifts F(θ; p₁, p₂, ...) by one formula; called with numbers it gives the CircleMap.

    lift : ``lift(theta, *parameters)``, radians to radians, never wrapped; broadcasts over theta, shape (..., n),
        and parameters, each a number or of shape (n,). Several threads may call it at once.
    derivative : the same for F', or None: then differences.
    breaks : radians, the same for the whole family, where F jumps or F' does.
    nondecreasing : ``nondecreasing(*parameters)``, a boolean array: where theory says that F never falls; None
        compares F at 65 angles instead, which sees only folds wider than that.
    circle_map : makes the member at given numbers where a faster form than the formula exists; else None.
    max_error : a bound on |lift - truth| in radians, as of ``CircleMap``.

    It is a callable parameters → CircleMap, as all tools for families take. Raises InvalidInput for what is not
    callable; each member is checked like any CircleMap.

    >>> two_waves = ParametricLift(lambda x, shift, size: x + shift + size * np.sin(2 * x))
    >>> round(float(two_waves(0.5, 0.2).turn(np.pi / 4)), 12)
    0.7
    """

    lift: ParametricFunction
    derivative: ParametricFunction | None = None
    breaks: Any = ()
    nondecreasing: Callable[..., Any] | None = None
    circle_map: Callable[..., CircleMap] | None = None
    max_error: float = 0.0

    def __post_init__(self) -> None:
        if not callable(self.lift):
            raise InvalidInput(f"lift is {self.lift!r}: give a callable of an array of angles and the parameters")
        for name in ("derivative", "nondecreasing", "circle_map"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise InvalidInput(f"{name} is {given!r}: give a callable or None")
        object.__setattr__(self, "breaks", read_only(finite_array("breaks", self.breaks, ndim=1)))
        object.__setattr__(self, "max_error", non_negative_number("max_error", self.max_error))

    def __call__(self, *parameters: float) -> CircleMap:
        """The member at these numbers."""
        values = [finite_number(f"parameter {i}", value) for i, value in enumerate(parameters)]
        if self.circle_map is not None:
            return self.circle_map(*values)
        slope = None if self.derivative is None else partial(_at, self.derivative, values)
        return CircleMap(partial(_at, self.lift, values), slope, self.breaks, max_error=self.max_error)

    def rises(self, *parameters: Any) -> Mask:
        """Where F never falls, by ``nondecreasing`` or at 65 angles; parameters of shape (n,) each, result (n,)."""
        if self.nondecreasing is not None:
            size = np.broadcast_shapes(*(np.shape(p) for p in parameters))
            return np.array(np.broadcast_to(np.asarray(self.nondecreasing(*parameters), dtype=bool), size))
        lower = self.lift(_ANGLES[:1], *parameters)
        rising = np.ones(np.shape(lower), dtype=bool)
        for theta in _ANGLES[1:]:
            upper = self.lift(np.array([theta]), *parameters)
            rising &= upper >= lower - _FALL
            lower = upper
        return rising


def _at(function: ParametricFunction, values: list[float], theta: Array) -> Array:
    return function(theta, *values)


# -- textbook families -------------------------------------------------------------------------------------


def _sine_lift(theta: Array, omega: Any, K: Any) -> Array:
    image = K * np.sin(theta)
    np.subtract(theta, image, out=image)
    return np.asarray(image + TWO_PI * omega)


def _sine_slope(theta: Array, omega: Any, K: Any) -> Array:
    return np.asarray(1.0 - K * np.cos(theta) + 0.0 * omega)


def _sine_rises(omega: Any, K: Any) -> Any:
    return np.abs(K) <= 1.0 + 0.0 * omega


def _moebius_lift(theta: Array, a: Any, omega: Any) -> Array:
    return np.asarray(theta + TWO_PI * omega + 2.0 * np.arctan2(a * np.sin(theta), 1.0 - a * np.cos(theta)))


def _moebius_slope(theta: Array, a: Any, omega: Any) -> Array:
    return np.asarray((1.0 - a * a) / (1.0 - 2.0 * a * np.cos(theta) + a * a) + 0.0 * omega)


def _moebius_rises(a: Any, omega: Any) -> Any:
    return (a >= 0.0) & (a < 1.0 + 0.0 * omega)


ARNOLD_FAMILY = ParametricLift(_sine_lift, _sine_slope, nondecreasing=_sine_rises, circle_map=CircleMap.arnold)
"""The sine family θ → θ + 2πΩ - K sin θ, parameters (Ω, K) as of ``CircleMap.arnold``."""

MOEBIUS_FAMILY = ParametricLift(
    _moebius_lift, _moebius_slope, nondecreasing=_moebius_rises, circle_map=CircleMap.moebius
)
"""The Möbius family z → e^{2πiΩ}(z - a)/(1 - a z), parameters (a, Ω) as of ``CircleMap.moebius``."""


def parametric_form(family: Any) -> ParametricLift | None:
    """The formula for many parameters at once that a family is known by, or None.

    >>> parametric_form(CircleMap.arnold) is ARNOLD_FAMILY
    True
    """
    if isinstance(family, ParametricLift):
        return family
    return next((one for one in (ARNOLD_FAMILY, MOEBIUS_FAMILY) if one.circle_map == family), None)
