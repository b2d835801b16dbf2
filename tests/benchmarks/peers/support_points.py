"""Quasi-static pushing on support points in plain NumPy, as one would write it down: forces summed
over the points.

Nothing of the package's engine is used: the formulas here are an independent way to the same end
poses.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.benchmarks.peers.push_problem import PushProblem

Array = NDArray[np.float64]

# Finds the (omega, slip) that balances the forces, from a guess.
Solve = Callable[["Balance", Array], Array]
# Of the state (x, y, theta), a unit of the rod's travel, by how far the rod has gone and the state.
Velocity = Callable[[float, Array], Array]


class Contact(NamedTuple):
    """Where the rod touches: place (2,), m; outward normal and tangent (2,), all in the world
    frame.
    """

    place: Array
    normal: Array
    tangent: Array


@dataclass(frozen=True, eq=False)
class Balance:
    """The balance of forces at one instant, for a contact that sticks (cone 0) or slides on an edge
    of its cone (+-1).

    spun : (k, 2), m, how the points move as the object turns about the contact.
    rod : (2,), velocity of the rod.

    The unknown is (omega, slip): the object turns by omega (rad/m) a unit of travel, and its
    contact point moves along the tangent by slip, past the rod.
    """

    points: "SupportPoints"
    contact: Contact
    spun: Array
    rod: Array
    cone: int = 0

    def residual(self, unknown: Array) -> tuple[Array, Array]:
        """What is out of balance (n,): torque about the contact, force off the cone's edge; and its
        slope (n, n).
        """
        slip = unknown[1] if self.cone else 0.0
        force, slope = self.points.traction(
            self.rod + slip * self.contact.tangent + unknown[0] * self.spun
        )
        by = [slope(self.spun), slope(self.contact.tangent)][: len(unknown)]
        rows, slopes = [np.vdot(self.spun, force)], [[np.vdot(self.spun, each) for each in by]]
        if self.cone:
            edge = (
                self.contact.tangent
                + self.cone * self.points.problem.pusher.friction * self.contact.normal
            )
            rows.append(force.sum(axis=0) @ edge)
            slopes.append([each.sum(axis=0) @ edge for each in by])
        return np.array(rows), np.array(slopes)

    def cone_edge(self, unknown: Array) -> int:
        """Edge of the friction cone on which the contact slides if it cannot stick at this
        solution; 0 if it can.
        """
        force = self.points.traction(self.rod + unknown[0] * self.spun)[0].sum(axis=0)
        tangential = float(force @ self.contact.tangent)
        limit = -self.points.problem.pusher.friction * float(force @ self.contact.normal)
        return 0 if abs(tangential) <= limit else int(math.copysign(1, tangential))

    def object_velocity(self, unknown: Array, lever: Array) -> Array:
        """Velocity (3,) of the object's (x, y, theta) a unit of travel, its place at a lever (2,)
        from the contact.
        """
        omega, slip = unknown[0], unknown[1] if self.cone else 0.0
        x, y = self.rod + slip * self.contact.tangent
        return np.array([x - omega * lever[1], y + omega * lever[0], omega])


class SupportPoints:
    """The points that carry the object, and its velocity under a rod.

    softness : speed, in shares of the rod's, below which friction fades, so that a point may stand
        still.
    """

    def __init__(self, problem: PushProblem, softness: float) -> None:
        self.problem = problem
        self._places, self._loads = problem.footprint.quadrature
        half = np.abs(np.array(problem.slider.outline.vertices)).max(axis=0)
        self._half = half
        law = problem.friction
        c, s = math.cos(law.phi), math.sin(law.phi)
        axes = np.array([[c, -s], [s, c]])
        self._shape = axes @ np.diag([law.mu_a**2, law.mu_b**2]) @ axes.T
        self._centre = axes @ np.array([law.m0, law.n0])
        self._softness = softness * min(law.mu_a, law.mu_b)
        self.forget()

    def forget(self) -> None:
        """Start a new push: solutions to start from are those of a contact that neither turns nor
        slides.
        """
        self._guess = {0: np.zeros(1), 1: np.zeros(2), -1: np.zeros(2)}

    def traction(self, velocity: Array) -> tuple[Array, Callable[[Array], Array]]:
        """What every point asks of the rod, (k, 2) in shares of the weight; how it changes along
        (k, 2) or (2,).
        """
        shaped = velocity @ self._shape
        size = np.sqrt((velocity * shaped).sum(axis=1) + self._softness**2)[:, None]
        unit, loads = shaped / size, self._loads[:, None] / size

        def slope(along: Array) -> Array:
            return loads * (along @ self._shape - unit * (unit * along).sum(axis=1)[:, None])

        return loads * (shaped + size * self._centre), slope

    def velocity(self, state: Array, rod: Array, direction: Array, solve: Solve) -> Array:
        """Velocity (3,) of the object's state (x, y, theta) a unit of the travel of a rod whose
        centre is at (2,).
        """
        turn = _turn(state[2])
        contact = self._contact(turn, state[:2], rod)
        if contact.normal @ direction >= 0.0:  # the rod leaves
            return np.zeros(3)
        lever = state[:2] - contact.place
        arms = lever + self._places @ turn.T
        balance = Balance(self, contact, np.stack([-arms[:, 1], arms[:, 0]], axis=-1), direction)
        unknown = solve(balance, self._guess[0])
        cone = balance.cone_edge(unknown)
        self._guess[0] = unknown
        if cone:
            balance = replace(balance, cone=cone)
            self._guess[cone] = unknown = solve(balance, self._guess[cone])
        return balance.object_velocity(unknown, lever)

    def _contact(self, turn: Array, place: Array, rod: Array) -> Contact:
        """The point of the rectangle that is nearest to the rod's centre."""
        seen = (rod - place) @ turn
        nearest = np.clip(seen, -self._half, self._half)
        away = (seen - nearest) / math.hypot(*(seen - nearest))
        normal = turn @ away
        return Contact(place + turn @ nearest, normal, np.array([-normal[1], normal[0]]))


def _turn(theta: float) -> Array:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s], [s, c]])
