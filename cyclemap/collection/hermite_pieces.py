"""Polynomials through values and slopes at a few nodes: of degree three through two, five through three, and so on."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

# Cubics are compared at these shares of their width; they are put this much closer than what is seen there asks for.
_COMPARED, _CLOSER = (0.25, 0.5, 0.75), 1.15


@dataclass(frozen=True)
class Node:
    """A sample of a function: place, value, slope."""

    theta: float
    value: float
    slope: float

    def along_tangent(self, theta: float) -> float:
        """Value of the tangent at another place."""
        return self.value + self.slope * (theta - self.theta)


@dataclass(frozen=True)
class HermitePolynomial:
    """The polynomial of degree 2 k - 1 with the values and slopes of k nodes, by divided differences (Davis 1975, 3.1).

    nodes : ascending, no place twice. differences : Newton's coefficients, to places that come twice each.

    >>> nodes = [Node(x, x**5, 5.0 * x**4) for x in (0.0, 0.5, 2.0)]
    >>> HermitePolynomial.through(nodes).at(1.5) == (1.5**5, 5.0 * 1.5**4)
    True
    """

    nodes: tuple[Node, ...]
    differences: tuple[float, ...]

    @classmethod
    def through(cls, nodes: Sequence[Node]) -> "HermitePolynomial":
        """Return the polynomial that has the values and slopes of the nodes."""
        places = [node.theta for node in nodes for _ in (0, 1)]
        column = [node.value for node in nodes for _ in (0, 1)]
        differences = column[:1]
        for order in range(1, len(places)):
            rises = [column[i + 1] - column[i] for i in range(len(column) - 1)]
            if order == 1:
                column = [
                    rise / (places[i + 1] - places[i]) if i % 2 else nodes[i // 2].slope for i, rise in enumerate(rises)
                ]
            else:
                column = [rise / (places[i + order] - places[i]) for i, rise in enumerate(rises)]
            differences.append(column[0])
        return cls(tuple(nodes), tuple(differences))

    def at(self, theta: float) -> tuple[float, float]:
        """Value and slope at a place."""
        value = slope = 0.0
        for k in reversed(range(len(self.differences))):
            off = theta - self.nodes[k // 2].theta
            slope = slope * off + value
            value = value * off + self.differences[k]
        return value, slope

    def refined(self, error: float) -> Iterator[Node]:
        """Its nodes, and so many between them that cubics from one to the next are within `error` of it."""
        for low, high in pairwise(self.nodes):
            count = max(1, math.ceil(_CLOSER * (self._off_cubic(low, high) / error) ** 0.25))
            width = (high.theta - low.theta) / count
            yield low
            for theta in (low.theta + k * width for k in range(1, count)):
                yield Node(theta, *self.at(theta))
        yield self.nodes[-1]

    def _off_cubic(self, low: Node, high: Node) -> float:
        # A cubic between two places misses q by q'''' (s (1 - s) h^2)^2 / 24 at the share s of its width h.
        width, off = high.theta - low.theta, 0.0
        for s in _COMPARED:
            tangents = width * s * (1.0 - s) * ((1.0 - s) * low.slope - s * high.slope)
            cubic = low.value + s**2 * (3.0 - 2.0 * s) * (high.value - low.value) + tangents
            off = max(off, abs(cubic - self.at(low.theta + s * width)[0]) / (16.0 * (s * (1.0 - s)) ** 2))
        return off


def left_out_error(nodes: Sequence[Node], number: int) -> float:
    """Return by how much the polynomial through all nodes but one misses the value of that one."""
    left = nodes[number]
    return abs(HermitePolynomial.through([*nodes[:number], *nodes[number + 1 :]]).at(left.theta)[0] - left.value)
