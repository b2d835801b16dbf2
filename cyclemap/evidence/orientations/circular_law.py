"""Laws on the circle as tables of their distribution function, and samples of orientations, checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput

Density = Callable[[Array], Array]

_MASS_ERROR = 0.01  # a density that jumps is integrated to about a thousandth; one in other units is far off
_NEGATIVE = -1e-3 / TWO_PI  # rounding and truncated series dip below zero, but never that far


@dataclass(frozen=True, eq=False)
class CircularLaw:
    """A law on the circle, tabulated once so that many samples can be set against it.

    density : vectorised callable of angles in [0, 2π] (radians), per radian, period 2π.
    cells : equal cells of the table; 2·cells + 1 densities are evaluated.

    The distribution function is integrated by Simpson's rule and is a monotone cubic inside each cell (slopes
    limited as by Fritsch & Carlson 1980): error O(h⁴), h = 2π/cells, for a smooth positive density, O(h³) where it
    touches 0, O(h) beside a jump.
    The table is rescaled to mass 1.

    Raises InvalidInput where the density is not finite, negative, not vectorised, or further than 1 % from
    integrating to 1.

    >>> law = CircularLaw(lambda theta: (1 + np.cos(theta)) / (2 * np.pi))
    >>> round(float(law.cumulative(np.pi / 2)), 12) == round(0.25 + 1 / (2 * np.pi), 12)
    True
    """

    density: Density
    cells: int = 2048
    knots: Array = field(init=False, repr=False)
    heights: Array = field(init=False, repr=False)
    masses: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not callable(self.density):
            raise InvalidInput(f"density is {self.density!r}: give a vectorised callable of angles in radians")
        count = whole_number("cells", self.cells, least=8)
        values = _checked_density(self.density, np.linspace(0.0, TWO_PI, 2 * count + 1))
        parts = (values[:-2:2] + 4.0 * values[1::2] + values[2::2]) * (TWO_PI / (6.0 * count))
        total = float(np.sum(parts))
        if abs(total - 1.0) > _MASS_ERROR:
            raise InvalidInput(f"the density integrates to {total:g} over the circle, not 1: give it per radian")
        below = np.append(0.0, np.cumsum(parts) / total)
        below[-1] = 1.0
        object.__setattr__(self, "knots", read_only(np.linspace(0.0, TWO_PI, count + 1)))
        object.__setattr__(self, "heights", read_only(values[::2] / total))
        object.__setattr__(self, "masses", read_only(below))

    def cumulative(self, theta: Any) -> Array:
        """Probability of the arc from 0 to θ mod 2π, any shape."""
        angle = np.mod(finite_array("theta", theta), TWO_PI)
        step = TWO_PI / self.cells
        cell = np.minimum((angle / step).astype(np.int64), self.cells - 1)
        t = (angle - self.knots[cell]) / step
        low, mass = self.masses[cell], self.masses[cell + 1] - self.masses[cell]
        # At most three times the mean slope: the cubic then never falls.
        rise = np.minimum(self.heights[cell] * step, 3.0 * mass)
        end = np.minimum(self.heights[cell + 1] * step, 3.0 * mass)
        return np.asarray(low + t * (rise + t * (3.0 * mass - 2.0 * rise - end + t * (rise + end - 2.0 * mass))))

    def bin_probabilities(self, bins: int) -> Array:
        """Probability of each of ``bins`` equal bins over [0, 2π)."""
        inner = self.cumulative(np.arange(bins) * (TWO_PI / bins))
        return np.diff(np.append(inner, 1.0))


def _checked_density(density: Density, angles: Array) -> Array:
    values = finite_array("the density's values", density(angles))
    if values.shape != angles.shape:
        raise InvalidInput(f"the density gave shape {values.shape} for {angles.shape}: it must be vectorised")
    worst = int(np.argmin(values))
    if values[worst] < _NEGATIVE:
        raise InvalidInput(f"the density is {values[worst]:g} at {angles[worst]:g} rad: it must not be negative")
    return np.maximum(values, 0.0)


def law_or_sample(law: Any) -> CircularLaw | Array:
    """A law as it is, a callable density tabulated, anything else a checked second sample, shape (m,)."""
    if isinstance(law, CircularLaw):
        return law
    return CircularLaw(law) if callable(law) else orientations("the second sample", law, single=True)


def orientations(name: str, sample: Any, single: bool = False) -> Array:
    """Angles brought into [0, 2π), shape (..., n) with n ≥ 1, or (n,) where ``single``; else InvalidInput."""
    angles = finite_array(name, sample, ndim=1 if single else None)
    if angles.ndim == 0 or angles.size == 0:
        raise InvalidInput(f"{name} has shape {angles.shape}: give at least one orientation in radians")
    wrapped = np.mod(angles, TWO_PI)
    # An angle a hair below 0 wraps to exactly 2π.
    return np.asarray(np.where(wrapped >= TWO_PI, 0.0, wrapped))
