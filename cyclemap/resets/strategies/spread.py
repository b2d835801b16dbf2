"""A number that a strategy keeps fixed, or draws evenly from an interval: how it is drawn, and how it is averaged."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput

Array = NDArray[np.float64]

_FULL_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Spread:
    """A number drawn evenly from `low` to `high`; whether it is an angle, of which 2 pi is a whole turn, `around` says.

    >>> Spread(0.0, 2.0).at(0.25)
    0.5
    """

    low: float
    high: float
    around: bool = False

    def __post_init__(self) -> None:
        low, high = finite_number("low end", self.low), finite_number("high end", self.high)
        if not low < high:
            raise InvalidInput(f"a spread runs from a lower to a higher number, not from {low} to {high}")
        if self.around and high - low > _FULL_TURN * (1.0 + 1e-12):
            raise InvalidInput(f"a spread of angles must not be wider than a full turn, but goes from {low} to {high}")
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)

    @classmethod
    def full_turn(cls) -> Spread:
        """Every direction alike.

        >>> Spread.full_turn().closed
        True
        """
        return cls(0.0, _FULL_TURN, around=True)

    @classmethod
    def within(cls, centre: float, halfwidth: float) -> Spread:
        """Return the spread centre - halfwidth ... centre + halfwidth, not around the circle."""
        middle, half = finite_number("centre", centre), finite_number("halfwidth", halfwidth)
        return cls(middle - half, middle + half)

    @property
    def closed(self) -> bool:
        """Whether it covers a full turn of an angle, so that its ends are the same."""
        return self.around and self.high - self.low >= _FULL_TURN * (1.0 - 1e-12)

    def at(self, share: float) -> float:
        """Return the number at a share (0 to 1) of the way from low to high."""
        return self.low + (self.high - self.low) * float(share)

    def nodes(self, count: int, sectors: int | None = None) -> tuple[Array, Array]:
        """Return values (k,) and weights (k,), summing to one, that stand for the even law.

        A full turn: `count` equal steps, exact for the harmonics below the count. Else Gauss-Legendre with a quarter
        as many nodes, at least 3: exact for polynomials of degree 2k - 1. `sectors`: the middles of as many sectors,
        which is then the law itself.
        """
        number = whole_number("nodes", count, least=1)
        if sectors is not None or self.closed:
            steps = sectors or number
            return self.low + (self.high - self.low) * (np.arange(steps) + 0.5) / steps, np.full(steps, 1.0 / steps)
        places, weights = np.polynomial.legendre.leggauss(max(3, number // 4))
        return self.low + (self.high - self.low) * 0.5 * (1.0 + places), 0.5 * weights

    def interpolation(self, share: Array, count: int, sectors: int | None = None) -> Array:
        """Return the weights (n, k) that the values at `nodes` have in the interpolant at shares (n,) of the way.

        A full turn: the trigonometric interpolant; else the polynomial through the nodes (Lagrange); with sectors the
        value of the sector.

        >>> rows = Spread(0.0, 1.0).interpolation(np.array([0.3]), 16)
        >>> round(float(rows[0] @ Spread(0.0, 1.0).nodes(16)[0] ** 3), 12)
        0.027
        """
        values, _ = self.nodes(count, sectors)
        if sectors is not None:
            sector = np.minimum((share * sectors).astype(int), sectors - 1)
            return np.asarray(np.eye(sectors)[sector])
        if not self.closed:
            return _lagrange((values - self.low) / (self.high - self.low), share)
        return _dirichlet(_FULL_TURN * (share[:, None] - (np.arange(values.size) + 0.5) / values.size), values.size)


def _dirichlet(x: Array, count: int) -> Array:
    """The trigonometric polynomial that is 1 at x = 0 and 0 at the other multiples of 2 pi/count."""
    near = np.abs(np.sin(0.5 * x)) < 1e-12
    half = np.where(near, 1.0, 0.5 * x)
    lower = np.sin(half) if count % 2 else np.tan(half)
    return np.asarray(np.where(near, 1.0, np.sin(count * half) / (count * lower)))


def _lagrange(nodes: Array, at: Array) -> Array:
    """Lagrange's polynomials of the nodes (k,), at places (n,): (n, k)."""
    columns = []
    for j, node in enumerate(nodes.tolist()):
        others = np.delete(nodes, j)
        columns.append(np.prod((at[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)


Number = float | Spread


def checked_number(name: str, value: Number) -> Number:
    """Return a finite number or a spread as it is, or raise InvalidInput."""
    return value if isinstance(value, Spread) else finite_number(name, value)


def lowest(value: Number) -> float:
    """Return the least value that a number takes."""
    return value.low if isinstance(value, Spread) else value
