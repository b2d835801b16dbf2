"""Integrals of |w| around the image of a footprint's rim in the velocity plane, as CasADi expressions."""

import math
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca
import numpy as np

# Scalars or matrices: SX for closed forms, MX for sums over many nodes.
Expression: TypeAlias = ca.SX | ca.MX

# Keeps logarithms finite where the centre of rotation lies on a side; d times them is then zero to rounding.
_TINY = 1e-60

# Gauss points on each of an ellipse's two arcs, and the least half-width of the strip (rad) that they resolve.
_ARC_ORDER = 88
_NODES = 2 * _ARC_ORDER
_NARROWEST = 1e-12


@dataclass(frozen=True)
class Rim:
    """Pieces of a rim, one a row; n the outward normal, d the distance of the origin from the piece's line.

    `normal` (k, 2): n; `distance` (k, 1): d = w . n, constant on a piece; then integrals along the piece: `length`
    (k, 1) of |w|, `unit` (k, 2) of w/|w|, `first` (k, 2) of w |w|, `second` (k, 3) of (x x, x y, y y)/|w|, w = (x, y).
    On a piece w = foot + t tangent, (k, 2) each; `inverses` (k, 4): integrals of t^i/|w|.
    A piece may also be a quadrature node, with its weight in the normal; it has no tangent.
    """

    normal: Expression
    distance: Expression
    length: Expression
    unit: Expression
    first: Expression
    second: Expression
    foot: Expression
    tangent: Expression
    inverses: Expression


def polygon_rim(x: Expression, y: Expression) -> Rim:
    """Return the rim of a counter-clockwise polygon with corners (x, y), columns, in closed form."""
    k = x.shape[0]
    following = [*range(1, k), 0]
    ex, ey = x[following] - x, y[following] - y
    size = ca.sqrt(ex * ex + ey * ey)
    tx, ty = ex / size, ey / size
    nx, ny = ty, -tx
    d = x * nx + y * ny
    start, end = x * tx + y * ty, x[following] * tx + y[following] * ty
    radius = ca.sqrt(x * x + y * y)
    s0, s1 = radius, radius[following]
    total, between = s0 + s1, start + end
    # s0 + start and s1 - end, whose sum is total - size: neither cancels where the origin is beside the side.
    before, after = ca.fabs(start), ca.fabs(end)
    spare = d * d * (1 / (s0 + before + _TINY) + 1 / (s1 + after + _TINY)) + (start + before) + (after - end)
    # Integrals along the side of 1/s, t/s, s, t^2/s and t s, with s = sqrt(d^2 + t^2), that keep their digits where it
    # is far; differences of end and start would not.
    angle = ca.log1p(2 * size / (spare + _TINY))
    rise = size * between / total
    ts = (size * total + rise * between) / 2
    length, moment = (ts + d * d * angle) / 2, (ts - d * d * angle) / 2
    cube = rise * (s0 * s0 + s0 * s1 + s1 * s1) / 3
    da = d * angle
    unit = ca.horzcat(da * nx + rise * tx, da * ny + rise * ty)
    first = ca.horzcat(d * length * nx + cube * tx, d * length * ny + cube * ty)
    dda, dr = d * da, d * rise
    second = ca.horzcat(
        dda * nx * nx + 2 * dr * nx * tx + moment * tx * tx,
        dda * nx * ny + dr * (nx * ty + tx * ny) + moment * tx * ty,
        dda * ny * ny + 2 * dr * ny * ty + moment * ty * ty,
    )
    # The integral of t^3/s by parts.
    inverses = ca.horzcat(angle, rise, moment, cube - d * dr)
    normal, tangent = ca.horzcat(nx, ny), ca.horzcat(tx, ty)
    return Rim(normal, d, length, unit, first, second, ca.horzcat(d * nx, d * ny), tangent, inverses)


def ellipse_nodes(
    centre: Expression, cosine: Expression, sine: Expression
) -> tuple[Expression, Expression, tuple[Expression, Expression]]:
    """Return nodes tau and weights around the rim w = centre + cosine cos(tau) + sine sin(tau), and what is frozen.

    |w| is singular at the two complex tau where w, as a complex number, vanishes: z = exp(i tau) solves
    p z^2 + c z + q = 0. Each half of the circle is integrated by Gauss's rule in x, tau = alpha + delta sinh(x), with
    alpha the real part of its own singularity and delta the imaginary one (the sinh transformation of Johnston &
    Elliott 2005). The four numbers are frozen: the nodes hold a symbol for them, which is returned with its expression.
    """
    symbols = type(centre).sym("singularity", 4)
    tau, weight = _graded_nodes(symbols)
    return tau, weight, (symbols, _ellipse_singularities(centre, cosine, sine))


def ellipse_rim(centre: Expression, cosine: Expression, sine: Expression, tau: Expression, weight: Expression) -> Rim:
    """Return the rim w = centre + cosine cos(tau) + sine sin(tau), as nodes with their weights."""
    c, s = ca.cos(tau), ca.sin(tau)
    x, y = centre[0] + cosine[0] * c + sine[0] * s, centre[1] + cosine[1] * c + sine[1] * s
    nx, ny = weight * (sine[1] * c - cosine[1] * s), -weight * (sine[0] * c - cosine[0] * s)
    length = ca.sqrt(x * x + y * y + _TINY)
    return Rim(
        ca.horzcat(nx, ny),
        x * nx + y * ny,
        length,
        ca.horzcat(x / length, y / length),
        ca.horzcat(x * length, y * length),
        ca.horzcat(x * x / length, x * y / length, y * y / length),
        ca.horzcat(x, y),
        type(centre)(_NODES, 2),
        ca.horzcat(1 / length, type(centre)(_NODES, 3)),
    )


def _graded_nodes(singularity: Expression) -> tuple[Expression, Expression]:
    """Nodes tau and weights of both halves; `singularity`: (alpha, delta) of each, alpha_2 is at most 2 pi more."""
    first, second = singularity[0], singularity[2]
    half = (second - first) / 2
    taus, weights = [], []
    # Each half runs from one midpoint between the singularities to the other.
    for alpha, delta, before, after in (
        (first, singularity[1], half - math.pi, half),
        (second, singularity[3], -half, math.pi - half),
    ):
        tau, weight = _graded_arc(alpha, delta, before, after)
        taus.append(tau)
        weights.append(weight)
    return ca.vertcat(*taus), ca.vertcat(*weights)


def _graded_arc(
    alpha: Expression, delta: Expression, before: Expression, after: Expression
) -> tuple[Expression, Expression]:
    node, weight = np.polynomial.legendre.leggauss(_ARC_ORDER)
    low, high = ca.asinh(before / delta), ca.asinh(after / delta)
    x = (low + high) / 2 + (high - low) / 2 * ca.DM(node)
    return alpha + delta * ca.sinh(x), (high - low) / 2 * ca.DM(weight) * delta * ca.cosh(x)


def _ellipse_singularities(centre: Expression, cosine: Expression, sine: Expression) -> Expression:
    """Return (alpha_1, delta_1, alpha_2, delta_2): angle and distance from the unit circle of both complex roots."""
    p = _Complex((cosine[0] + sine[1]) / 2, (cosine[1] - sine[0]) / 2)
    q = _Complex((cosine[0] - sine[1]) / 2, (cosine[1] + sine[0]) / 2)
    c = _Complex(centre[0], centre[1])
    root = (c * c - p * q * 4).sqrt()
    # The sign that does not cancel: Re(conj(c) root) >= 0.
    sign = ca.if_else(c.x * root.x + c.y * root.y >= 0, 1, -1)
    both = _Complex(-(c.x + sign * root.x) / 2, -(c.y + sign * root.y) / 2)
    alpha_1, delta_1 = (both / p).strip()
    alpha_2, delta_2 = (q / both).strip()
    # A root far from the circle needs no grading: its half is then centred opposite to the other one.
    alpha_2 = ca.if_else(delta_2 > 3, alpha_1 + math.pi, alpha_2)
    alpha_1 = ca.if_else(delta_1 > 3, alpha_2 + math.pi, alpha_1)
    gap = alpha_2 - alpha_1
    gap = gap - 2 * math.pi * ca.floor(gap / (2 * math.pi))
    return ca.vertcat(alpha_1, delta_1, alpha_1 + gap, delta_2)


@dataclass(frozen=True)
class _Complex:
    """A complex number of two real expressions."""

    x: Expression
    y: Expression

    def __mul__(self, other: "_Complex | int") -> "_Complex":
        if isinstance(other, int):
            return _Complex(self.x * other, self.y * other)
        return _Complex(self.x * other.x - self.y * other.y, self.x * other.y + self.y * other.x)

    def __sub__(self, other: "_Complex") -> "_Complex":
        return _Complex(self.x - other.x, self.y - other.y)

    def __truediv__(self, other: "_Complex") -> "_Complex":
        size = other.x**2 + other.y**2 + _TINY
        return _Complex((self.x * other.x + self.y * other.y) / size, (self.y * other.x - self.x * other.y) / size)

    def sqrt(self) -> "_Complex":
        size = ca.sqrt(ca.sqrt(self.x**2 + self.y**2))
        angle = ca.atan2(self.y, self.x) / 2
        return _Complex(size * ca.cos(angle), size * ca.sin(angle))

    def strip(self) -> tuple[Expression, Expression]:
        """Return angle and |log modulus|, the latter kept between the narrowest strip and one wide enough."""
        modulus = ca.sqrt(self.x**2 + self.y**2 + _TINY)
        return ca.atan2(self.y, self.x), ca.fmin(ca.fmax(ca.fabs(ca.log(modulus)), _NARROWEST), 4.0)
