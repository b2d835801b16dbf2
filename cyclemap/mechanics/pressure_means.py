"""Integrals of |w| and its derivatives over a patch of the velocity plane, weighted by a polynomial of w."""

from dataclasses import dataclass

import casadi as ca

from cyclemap.mechanics.rim import Expression, Rim


@dataclass(frozen=True)
class Means:
    """Integrals over the patch, weighted: of |w|, its gradient (2, 1) and its Hessian (2, 2) in the velocity plane."""

    speed: Expression
    direction: Expression
    curvature: Expression

    def plus(self, factor: Expression, other: "Means") -> "Means":
        """Return these integrals plus a factor times others."""
        return Means(
            self.speed + factor * other.speed,
            self.direction + factor * other.direction,
            self.curvature + factor * other.curvature,
        )

    def times(self, factor: Expression) -> "Means":
        """Return these integrals times a factor."""
        return Means(factor * self.speed, factor * self.direction, factor * self.curvature)


def even_means(rim: Rim) -> Means:
    """Return the integrals with weight one."""
    speed = ca.dot(rim.distance, rim.length) / 3
    return Means(speed, rim.normal.T @ rim.length, rim.unit.T @ rim.normal)


def linear_curvature(rim: Rim, constant: Expression, slope: Expression) -> Expression:
    """Return the integral (2, 2) of the Hessian with weight constant + slope . w."""
    even = even_means(rim)
    second = ca.horzcat(rim.second[:, :2] @ slope, rim.second[:, 1:] @ slope)
    return constant * even.curvature + second.T @ rim.normal - even.direction @ slope.T


def quadratic_curvature(rim: Rim, constant: Expression, slope: Expression, bend: Expression) -> Expression:
    """Return the same with weight constant + slope . w + w^T bend w, `bend` (2, 2) being symmetric."""
    even = even_means(rim)
    outer = rim.normal.T @ rim.first - even.speed * ca.DM.eye(2)
    # The weight along a piece, by powers of t.
    bent_foot, bent_tangent = rim.foot @ bend, rim.tangent @ bend
    powers = (
        constant + rim.foot @ slope + _rows(bent_foot, rim.foot),
        rim.tangent @ slope + 2 * _rows(bent_foot, rim.tangent),
        _rows(bent_tangent, rim.tangent),
    )
    return _weighted_unit(rim, powers).T @ rim.normal - even.direction @ slope.T - 2 * outer @ bend


def _weighted_unit(rim: Rim, powers: tuple[Expression, ...]) -> Expression:
    """Integrals (k, 2) of w/|w| along the pieces, weighted by a polynomial of t."""
    foot, tangent = (sum(p * rim.inverses[:, i + shift] for i, p in enumerate(powers)) for shift in (0, 1))
    return ca.horzcat(
        rim.foot[:, 0] * foot + rim.tangent[:, 0] * tangent, rim.foot[:, 1] * foot + rim.tangent[:, 1] * tangent
    )


def _rows(a: Expression, b: Expression) -> Expression:
    """Return the products (k, 1) of rows (k, 2)."""
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
