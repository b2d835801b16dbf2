"""Friction of a patch under uneven pressure by what |w| exceeds its tangent by: no cancellation far from the centre.

With w = w_c + A x the image of the lever x from the centroid, and the direction e = w_c/|w_c|, the excess

    r = |w| - e . w = (e x w)^2 / (|w| + e . w)

is not negative, and the smaller the farther the centre of rotation x_O. What the tangent e . w adds to any integral is
a number times a moment of the pressure. Like |w|, r is homogeneous about x_O, so that the divergence theorem leaves rim
integrals, for a weight f and its homogeneous parts m of degree k about the centroid:

    int f grad r     = rim f r n - int r grad f
    int f x . grad r = rim f r (x . n) - int (2 f + x . grad f) r
    (k + 3) int m r  = rim m r (x - x_O) . n + x_O . int r grad m

Along a straight side of image length L, with sigma = |w_0| + |w_1| and q = L/sigma <= 1 the integrals of tau^i |w|,
-1/2 <= tau <= 1/2, are those of its chord less h(q) = 1 - (1 - q^2) atanh(q)/q and what its series has beyond its first
terms: rounding is relative to r and to the excess over the chord, not to |w|.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.rim import Expression, Rim

# Below this q^2 the tail of h is summed, by so many terms: to rounding on both sides.
_SERIES_BELOW, _TERMS = 0.04, 10
# Gives the velocity of the centroid a direction where it vanishes; any one serves.
_TINY = 1e-150


@dataclass(frozen=True)
class Tangent:
    """The tangent e . w at the centroid: `map` A (2, 2), `direction` e (2, 1)."""

    map: Expression
    direction: Expression

    @classmethod
    def at(cls, velocity: Expression, image: Expression) -> "Tangent":
        """Return the tangent at a velocity w_c, `image` being A."""
        x, y = velocity[0] + _TINY, velocity[1]
        return cls(image, ca.vertcat(x, y) / ca.sqrt(x * x + y * y))

    def excess(self, x: Expression, y: Expression, speed: Expression, lever: Expression) -> Expression:
        """Return r (k, 1) at w = (x, y), the images of levers (k, 2), whose |w| is `speed`."""
        e, across = self.direction, lever @ (self.map.T @ ca.vertcat(-self.direction[1], self.direction[0]))
        along = e[0] * x + e[1] * y
        size = ca.fabs(along)
        # Rounding may leave e x w above |w| where both vanish.
        return ca.fmin(across * across, speed * speed) / (speed + size + _TINY) + (size - along)


@dataclass(frozen=True)
class Weight:
    """A weight constant + slope . x + x^T bend x of the lever x; `bend` (2, 2) symmetric, or None."""

    constant: Expression
    slope: Expression
    bend: Expression | None = None


@dataclass(frozen=True)
class RimExcess:
    """Pieces of a rim of levers, one a row: x = middle + tau edge, -1/2 <= tau <= 1/2.

    `normal` (k, 2): outward, times the piece's length; `powers`: integrals (k, 1) of tau^i r. A piece may also be a
    quadrature node, with its weight in the normal; it has no edge and one power.
    """

    normal: Expression
    middle: Expression
    edge: Expression | None
    powers: tuple[Expression, ...]

    @property
    def first(self) -> Expression:
        """Integrals (k, 2) of x r along the pieces."""
        if self.edge is None:
            return _scaled(self.middle, self.powers[0])
        return _scaled(self.middle, self.powers[0]) + _scaled(self.edge, self.powers[1])

    def bent(self, bend: Expression) -> Expression:
        """Integrals (k, 1) of x^T bend x r along the pieces."""
        along = self.middle @ bend
        even = _rows(along, self.middle) * self.powers[0]
        if self.edge is None:
            return even
        return even + 2 * _rows(along, self.edge) * self.powers[1] + _rows(self.edge @ bend, self.edge) * self.powers[2]


@dataclass(frozen=True)
class ExcessIntegrals:
    """Integrals over a patch of f grad r (2, 1), and of f x . grad r."""

    gradient: Expression
    radial: Expression


def excess_integrals(rim: RimExcess, centre: Expression, weight: Weight) -> ExcessIntegrals:
    """Return the integrals over the patch within a rim; `centre` (2, 1): the lever x_O of the centre of rotation."""
    arm, first = _rows(rim.normal, rim.middle), rim.first
    reach = arm - rim.normal @ centre
    even = ca.dot(reach, rim.powers[0]) / 3
    linear = (first.T @ reach + centre * even) / 4
    # The weight's own integrals along the pieces, and those of its gradient and of 2 f + x . grad f over the patch.
    weighted = weight.constant * rim.powers[0] + first @ weight.slope
    steep, radial = weight.slope * even, 2 * weight.constant * even + 3 * ca.dot(weight.slope, linear)
    if weight.bend is not None:
        bent, turned = rim.bent(weight.bend), 2 * weight.bend @ linear
        weighted, steep = weighted + bent, steep + turned
        radial = radial + 4 * (ca.dot(reach, bent) + ca.dot(centre, turned)) / 5
    return ExcessIntegrals(rim.normal.T @ weighted - steep, ca.dot(arm, weighted) - radial)


def polygon_excess(levers: NDArray[np.float64], x: Expression, y: Expression, rim: Rim, tangent: Tangent) -> RimExcess:
    """Return the excess along the sides of a polygon whose corners (k, 2) have the images (x, y), columns."""
    following = [*range(1, len(levers)), 0]
    speed = ca.sqrt(x * x + y * y)
    excess = tangent.excess(x, y, speed, ca.DM(levers))
    total, both = speed + speed[following], excess + excess[following]
    ex, ey = x[following] - x, y[following] - y
    # By how much |w| grows along a side, as a share of its length.
    size = ca.sqrt(ex * ex + ey * ey)
    slope, q = rim.inverses[:, 1] / size, size / total
    second, fourth, sixth = _chord_tail(q, rim.inverses[:, 0])
    square, steepness = q * q, total * (1 - slope * slope)
    powers = (
        both / 2 - steepness * square * second / 4,
        (excess[following] - excess) / 12 + slope * steepness * square * q * fourth / 8,
        both / 24 + steepness * square * ((1 - slope * slope) * square * (5 * sixth - fourth) / 4 - fourth) / 16,
    )
    edge = np.roll(levers, -1, axis=0) - levers
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=-1)
    return RimExcess(ca.DM(normal), ca.DM(levers + edge / 2.0), ca.DM(edge), powers)


def ellipse_excess(
    semi_axes: tuple[float, float], tau: Expression, weight: Expression, rim: Rim, tangent: Tangent
) -> RimExcess:
    """Return the excess at nodes around an ellipse, whose images the rim holds."""
    a, b = semi_axes
    c, s = ca.cos(tau), ca.sin(tau)
    lever = ca.horzcat(a * c, b * s)
    excess = tangent.excess(rim.foot[:, 0], rim.foot[:, 1], rim.length, lever)
    return RimExcess(ca.horzcat(b * weight * c, a * weight * s), lever, None, (excess,))


def _chord_tail(q: Expression, angle: Expression) -> tuple[Expression, Expression, Expression]:
    """Return (k2, k4, k6): h(q)/q^2, and (k2 - 2/3)/q^2, (k4 - 2/15)/q^2; `angle`: 2 atanh(q)."""
    square = q * q
    series = ca.if_else(square < _SERIES_BELOW, _sixth_series(square), _sixth_closed(q, angle))
    fourth = 2 / 15 + square * series
    return 2 / 3 + square * fourth, fourth, series


def _sixth_series(square: Expression) -> Expression:
    value = 0.0
    for m in range(_TERMS - 1, -1, -1):
        value = 2.0 / ((2 * m + 5) * (2 * m + 7)) + square * value
    return value


def _sixth_closed(q: Expression, angle: Expression) -> Expression:
    square = q * q
    h = 1 - (1 - square) * angle / (2 * q)
    return (h - square * (2 / 3 + 2 / 15 * square)) / square**3


def _rows(a: Expression, b: Expression) -> Expression:
    """Return the products (k, 1) of rows (k, 2)."""
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]


def _scaled(rows: Expression, by: Expression) -> Expression:
    """Return rows (k, 2) times numbers (k, 1)."""
    return ca.horzcat(rows[:, 0] * by, rows[:, 1] * by)
