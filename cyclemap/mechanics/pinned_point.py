"""Slip about a support point that does not slide: the solution at the kinks of a point footprint's dissipation."""

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.friction import EllipseFriction

Solution = tuple[float, float, float, float]


class PinnedPoints:
    """Tests whether the slider turns about one of its support points, whose friction is then a reaction.

    It remembers the point that was pinned last, since it stays so over an interval.
    """

    def __init__(self, footprint: PointFootprint, friction: EllipseFriction) -> None:
        self._points, self._weights = footprint.quadrature
        self._friction = friction
        self._last: int | None = None

    def remembered(self, arguments: NDArray[np.float64]) -> Solution | None:
        """Return the solution about the last pinned point, if it still is pinned."""
        return None if self._last is None else self._about(self._last, arguments)

    def nearest(self, arguments: NDArray[np.float64], guess: tuple[float, float]) -> Solution | None:
        """Return the solution about one of the points that hardly move at a guess (omega, tau), if one is pinned."""
        _, _, x, y, normal = arguments[:5].tolist()
        omega, tau = guess
        vx = -math.cos(normal) - tau * math.sin(normal) - omega * (self._points[:, 1] - y)
        vy = -math.sin(normal) + tau * math.cos(normal) + omega * (self._points[:, 0] - x)
        for index in np.argsort(np.hypot(vx, vy))[:4].tolist():
            solution = self._about(index, arguments)
            if solution is not None:
                return solution
        return None

    def _about(self, index: int, arguments: NDArray[np.float64]) -> Solution | None:
        """Return (omega, tau, f_n, f_t) of turning about a point, or None if its friction could not hold it.

        Torques about the point give the contact force lambda d, d = -n + smu t; the point carries what remains.
        """
        theta, _, x, y, normal, smu = arguments[:6].tolist()
        c, s = math.cos(normal), math.sin(normal)
        lever_x, lever_y = x - self._points[index, 0], y - self._points[index, 1]
        inward = c * lever_y - s * lever_x
        dx, dy = -c - smu * s, -s + smu * c
        arm = lever_x * dy - lever_y * dx
        if inward == 0.0 or arm == 0.0:
            return None
        # n . (omega z x lever) = -1
        omega = 1.0 / inward
        tau = omega * (c * lever_x + s * lever_y)
        fx, fy, torque = self._others(index, omega, theta)
        size = torque / arm
        reaction = np.array([size * dx - fx, size * dy - fy])
        if size <= 0.0 or not self._holds(reaction / self._weights[index], theta):
            return None
        self._last = index
        return omega, tau, size, size * smu

    def _others(self, index: int, omega: float, theta: float) -> tuple[float, float, float]:
        """Force and torque about a point that keep the other points turning about it."""
        others = np.arange(len(self._weights)) != index
        lever = self._points[others] - self._points[index]
        velocity = omega * np.stack([-lever[:, 1], lever[:, 0]], axis=-1)
        force = self._weights[others, None] * self._friction.traction(velocity, frame=theta)
        torque = lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]
        return float(force[:, 0].sum()), float(force[:, 1].sum()), float(torque.sum())

    def _holds(self, traction: NDArray[np.float64], theta: float) -> bool:
        """Whether a traction (slider's frame) lies inside the friction ellipse."""
        law = self._friction
        c, s = math.cos(law.phi - theta), math.sin(law.phi - theta)
        along, across = c * traction[0] + s * traction[1], -s * traction[0] + c * traction[1]
        return math.hypot((along - law.m0) / law.mu_a, (across - law.n0) / law.mu_b) <= 1.0
