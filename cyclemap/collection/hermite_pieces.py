"""Polynomials through values and slopes: cubics between two nodes, quintics through three."""

import math
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Node:
    """A sample of a function: place, value, slope."""

    theta: float
    value: float
    slope: float

    def along_tangent(self, theta: float) -> float:
        """Value of the tangent at another place."""
        return self.value + self.slope * (theta - self.theta)


def cubic(low: Node, high: Node, theta: float) -> tuple[float, float]:
    """Value and slope of the cubic Hermite interpolant."""
    h = high.theta - low.theta
    t = (theta - low.theta) / h
    secant = (high.value - low.value) / h
    bend, twist = secant - low.slope, low.slope + high.slope - 2.0 * secant
    value = low.value + h * t * (low.slope + t * (bend + (t - 1.0) * twist))
    slope = low.slope + 2.0 * t * bend + (3.0 * t - 2.0) * t * twist
    return value, slope


@dataclass(frozen=True)
class Quintic:
    """The polynomial of degree five through two nodes and the one midway, in powers of t in [-1, 1] between them.

    >>> nodes = [Node(x, x**5, 5.0 * x**4) for x in (0.0, 1.0, 2.0)]
    >>> Quintic.through(*nodes).at(1.5) == (1.5**5, 5.0 * 1.5**4)
    True
    """

    middle: float
    half: float
    powers: tuple[float, ...]

    @classmethod
    def through(cls, low: Node, middle: Node, high: Node) -> "Quintic":
        """Return the polynomial that has the values and slopes of three nodes, evenly spaced."""
        half = 0.5 * (high.theta - low.theta)
        before, at, after = half * low.slope, half * middle.slope, half * high.slope
        even, odd = 0.5 * (high.value + low.value) - middle.value, 0.5 * (high.value - low.value) - at
        fourth, fifth = 0.25 * (after - before) - even, 0.25 * (after + before) - 0.5 * at - 1.5 * odd
        return cls(middle.theta, half, (middle.value, at, even - fourth, odd - fifth, fourth, fifth))

    def at(self, theta: float) -> tuple[float, float]:
        """Value and slope at a place."""
        t, value, slope = (theta - self.middle) / self.half, 0.0, 0.0
        for power in reversed(self.powers):
            slope = slope * t + value
            value = value * t + power
        return value, slope / self.half

    def between(self, error: float) -> Iterator[Node]:
        """Nodes of its own, inside: cubics from node to node come within `error` of it, h^4 max |q''''| / 384."""
        bend = 24.0 * abs(self.powers[4]) + 120.0 * abs(self.powers[5])
        count = max(1, math.ceil(2.0 * (bend / (384.0 * error)) ** 0.25))
        for k in range(1, count):
            theta = self.middle + self.half * (2.0 * k / count - 1.0)
            yield Node(theta, *self.at(theta))
