"""A second route to a patch's dissipation and its derivatives: plain numerical quadrature in polar coordinates.

About the centre of rotation c everything integrated over the patch is homogeneous in p = r - c, so that the radial
integral is a power: int F dA = 1/(k + 2) rim F(p) (p x dp) for F of degree k. What is left runs around the rim and is
summed by Gauss's rule on panels that shrink towards the place nearest to c. No closed form, no velocity plane, no
homogeneity of D. Where c is far or at infinity, a fine area rule.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from cyclemap.mechanics import Ellipse

NODE, WEIGHT = np.polynomial.legendre.leggauss(20)
FAR = 4.0


@dataclass(frozen=True)
class Pressure:
    """constant + gradient . x + x^T bend x, x the lever from the outline's centroid."""

    constant: float = 1.0
    gradient: tuple = (0.0, 0.0)
    bend: tuple = ((0.0, 0.0), (0.0, 0.0))

    def at(self, lever):
        return self.constant + lever @ np.array(self.gradient) + ((lever @ np.array(self.bend)) * lever).sum(-1)

    def slope(self, lever):
        return np.array(self.gradient) + 2.0 * np.array(self.bend) @ lever


def reference(outline, friction, twist, frame=0.0, gradient=(0.0, 0.0)):
    """Return D, grad D (3,), Hessian (3, 3) at a twist of the outline's frame, per unit load."""
    return under_pressure(outline, friction, twist, frame, Pressure(gradient=gradient))


def under_pressure(outline, friction, twist, frame, pressure):
    """Return the same under a quadratic pressure."""
    v, omega = np.array(twist[:2], float), float(twist[2])
    at_centroid = v + omega * quarter(np.array(outline.centroid))
    matrix = traction_matrix(friction, frame)
    if abs(omega) * outline.extent * FAR < np.hypot(*at_centroid):
        return _plus_offset(*_by_area(outline, matrix, twist, pressure), outline, friction, twist, frame, pressure)
    centre = np.array((-v[1], v[0])) / omega
    value, slope, hessian = _by_rim(outline, matrix, omega, centre, pressure)
    to_centre = np.array(((1.0, 0.0, -centre[1]), (0.0, 1.0, centre[0]), (0.0, 0.0, 1.0)))
    moved = value, to_centre.T @ slope, to_centre.T @ hessian @ to_centre
    return _plus_offset(*moved, outline, friction, twist, frame, pressure)


def traction_matrix(friction, frame):
    """M with s = |M v|."""
    c, s = math.cos(friction.phi - frame), math.sin(friction.phi - frame)
    return np.array(((friction.mu_a * c, friction.mu_a * s), (-friction.mu_b * s, friction.mu_b * c)))


def quarter(vector):
    """z x vector."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def density(outline, matrix, lever, velocity):
    """|M v| and its derivatives by the twist about lever = 0, at points: (n,), (n, 3), (n, 3, 3)."""
    w = velocity @ matrix.T
    speed = np.maximum(np.hypot(*w.T), 1e-300)
    jacobian = np.zeros((len(w), 2, 3))
    jacobian[:, :, :2] = matrix
    jacobian[:, :, 2] = quarter(lever) @ matrix.T
    along = w / speed[:, None]
    slope = np.einsum("ni,nij->nj", along, jacobian)
    bend = np.eye(2) - along[:, :, None] * along[:, None, :]
    return speed, slope, np.einsum("nia,nij,njb->nab", jacobian, bend, jacobian) / speed[:, None, None]


def _by_rim(outline, matrix, omega, centre, pressure):
    value, slope, hessian = 0.0, np.zeros(3), np.zeros((3, 3))
    even, gradient = pressure.at(centre - outline.centroid), pressure.slope(centre - outline.centroid)
    # Degrees in p of |M v|, its derivative by v and by omega, and the second derivatives.
    first, second = np.array((0, 0, 1)), np.array(((-1, -1, 0), (-1, -1, 0), (0, 0, 1)))
    for p, step in _rim_nodes(outline, centre):
        cross = p[:, 0] * step[:, 1] - p[:, 1] * step[:, 0]
        s, g, h = density(outline, matrix, p, omega * quarter(p))
        square = ((p @ np.array(pressure.bend)) * p).sum(-1)
        for share, more in ((even * cross, 2), ((p @ gradient) * cross, 3), (square * cross, 4)):
            value += (share @ s) / (1 + more)
            slope += (share @ g) / (first + more)
            hessian += np.einsum("n,nab->ab", share, h) / (second + more)
    # The derivative by omega of |omega| |M z x p| is of degree 1, the mixed ones of degree 0.
    return value / outline.area, slope / outline.area, hessian / outline.area


def _rim_nodes(outline, centre):
    """Points seen from the centre, and rim steps times weights, of every panel of the rim."""
    if isinstance(outline, Ellipse):
        near = _nearest(outline, centre)
        breaks = np.unique(np.concatenate([near + _shrinking(math.pi), near - _shrinking(math.pi)]))
        t, w = _panels(np.unique(np.concatenate([breaks, np.linspace(near - math.pi, near + math.pi, 65)])))
        place, step = _on_ellipse(outline, t)
        yield place - centre, step * w[:, None]
        return
    for a, b in zip(outline.array, np.roll(outline.array, -1, axis=0), strict=True):
        edge = b - a
        foot = float(np.clip((centre - a) @ edge / (edge @ edge), 0.0, 1.0))
        breaks = np.concatenate([foot - _shrinking(1.0) * foot, foot + _shrinking(1.0) * (1.0 - foot)])
        t, w = _panels(np.unique(breaks))
        yield (a - centre) + t[:, None] * edge, w[:, None] * edge


def _nearest(ellipse, centre):
    """Eccentric angle of the point of the rim that is nearest to a place."""

    def slope(angle):
        place, step = _on_ellipse(ellipse, angle)
        return float((place - centre) @ step)

    tau, grid = np.linspace(0.0, 2.0 * math.pi, 2_001, retstep=True)
    near = tau[np.argmin(np.hypot(*(_on_ellipse(ellipse, tau)[0] - centre).T))]
    low, high = near - grid, near + grid
    return brentq(slope, low, high, xtol=1e-16) if slope(low) * slope(high) < 0.0 else near


def _shrinking(length):
    return np.concatenate([[0.0], length * 0.5 ** np.arange(50, -1, -1)])


def _panels(breaks):
    low, size = breaks[:-1, None], np.diff(breaks)[:, None]
    return (low + size * (NODE + 1.0) / 2.0).ravel(), (size * WEIGHT / 2.0).ravel()


def _on_ellipse(outline, tau):
    c, s = np.cos(tau), np.sin(tau)
    a, b = outline.semi_x, outline.semi_y
    return np.stack([a * c, b * s], axis=-1), np.stack([-a * s, b * c], axis=-1)


def _by_area(outline, matrix, twist, pressure):
    points, weights = area_rule(outline)
    weights = weights * pressure.at(points - outline.centroid)
    s, g, h = density(outline, matrix, points, np.array(twist[:2]) + twist[2] * quarter(points))
    return weights @ s, weights @ g, np.einsum("n,nab->ab", weights, h)


def area_rule(outline):
    """Points and weights of a fine rule: a fan of triangles about the centroid, or a disc's polar rule, stretched."""
    share, weight = (NODE + 1.0) / 2.0, WEIGHT / 2.0
    if isinstance(outline, Ellipse):
        angle = np.arange(80) * 2.0 * math.pi / 80
        rim, step = _on_ellipse(outline, angle)
        rim, step = rim[:, None], step[:, None] * 2.0 * math.pi / 80
    else:
        a, b = outline.array[:, None] - outline.centroid, np.roll(outline.array, -1, 0)[:, None] - outline.centroid
        rim = (a + share[:, None] * (b - a)).reshape(-1, 1, 2)
        step = (weight[:, None] * (b - a)).reshape(-1, 1, 2)
    cross = rim[..., 0] * step[..., 1] - rim[..., 1] * step[..., 0]
    points = outline.centroid + share[:, None] * rim
    return points.reshape(-1, 2), (cross * share * weight / outline.area).ravel()


def _plus_offset(value, slope, hessian, outline, friction, twist, frame, pressure):
    """The ellipse's centre acts as a constant force at the centre of pressure."""
    points, weights = area_rule(outline)
    weights = weights * pressure.at(points - outline.centroid)
    x, y = weights @ points
    c, s = math.cos(friction.phi - frame), math.sin(friction.phi - frame)
    fx, fy = c * friction.m0 - s * friction.n0, s * friction.m0 + c * friction.n0
    load = weights.sum()
    wrench = np.array((load * fx, load * fy, x * fy - y * fx))
    return value + wrench @ np.asarray(twist), slope + wrench, hessian
