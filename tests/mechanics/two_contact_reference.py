"""A second route to what a rod that touches two places of an outline does: every mode that keeps
both, at an instant.

Plain NumPy and SciPy; friction is any function (twist, theta) -> grad D. The equations are those of
docs/theory/two-contacts.md. Lengths m, angles rad; twists, forces and contacts in the object's
frame, forces per unit load; the rod's speed is one.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, linprog


def quarter(vector):
    """z x vector."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def unit(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def wrench_on_points(law, points, twist, theta):
    """Mean force and torque about the object's origin of equally loaded points, from the point law
    alone.
    """
    x, y = points.T
    traction = law.traction(
        np.stack([twist[0] - twist[2] * y, twist[1] + twist[2] * x], axis=-1), frame=theta
    )
    return np.array((*traction.mean(axis=0), (x * traction[:, 1] - y * traction[:, 0]).mean()))


@dataclass(frozen=True)
class Contact:
    """A contact's point and its outward normal's angle."""

    point: tuple
    angle: float

    @property
    def normal(self):
        return unit(self.angle)

    @property
    def tangent(self):
        return quarter(unit(self.angle))


@dataclass(frozen=True)
class Instant:
    """What one instant gives: friction, the rod's radius, friction, and velocity in the object's
    frame; a length.
    """

    wrench: object
    theta: float
    velocity: np.ndarray
    radius: float
    mu: float
    extent: float

    def centre(self, contact):
        return np.array(contact.point) + self.radius * contact.normal

    def about(self, place, velocity, omega):
        """Twist of an object whose point at a place has a velocity, and (force, torque about the
        place) for it.
        """
        twist = np.array([*(velocity - omega * quarter(np.asarray(place))), omega])
        g = self.wrench(twist, self.theta)
        return twist, g[:2], g[2] - cross(np.asarray(place), g[:2])


@dataclass(frozen=True)
class Mode:
    """A solution of the balance of forces: contacts kept, slips' sense, twist, forces at contacts
    (normal, tangential).

    `margins` are all positive where the mode is consistent: forces in their cones, slips as
    friction has them, contacts that open; a wedge that sticks is told by one, how much of its
    undetermined force is free.
    """

    name: str
    twist: np.ndarray
    forces: tuple
    margins: np.ndarray


def free_spin(instant, place, velocity):
    """Spin about a place that needs no torque there: it grows with the spin, so that the bracket
    always closes.
    """

    def torque(omega):
        return instant.about(place, velocity, omega)[2]

    sign = -1.0 if torque(0.0) > 0.0 else 1.0
    inner, outer = 0.0, sign / instant.extent
    while torque(outer) * sign < 0.0:
        inner, outer = outer, 5.0 * outer
    return brentq(torque, *sorted((inner, outer)), xtol=1e-15 / instant.extent, rtol=1e-15)


def wedge_turns(instant, contacts, sense):
    """Modes that keep both contacts and turn about the rod: a bearing whose friction opposes the
    turn.
    """
    place, u, mu = instant.centre(contacts[0]), instant.velocity, instant.mu
    # Both slide in one sense: their forces along these edges add up to that of friction.
    edges = np.stack([-c.normal + sense * mu * c.tangent for c in contacts], axis=-1)

    def surplus(omega):
        _, force, torque = instant.about(place, u, omega)
        return torque + sense * instant.radius * mu * np.linalg.solve(edges, force).sum()

    grid, found = sense * np.tan(np.linspace(0.0, 1.569, 160)) / instant.extent, []
    for low in np.flatnonzero(np.diff(np.sign([surplus(omega) for omega in grid]))):
        omega = brentq(surplus, *sorted(grid[low : low + 2]), xtol=1e-16, rtol=1e-15)
        twist, force, _ = instant.about(place, u, omega)
        normal = np.linalg.solve(edges, force)
        forces = tuple((one, sense * mu * one) for one in normal)
        found.append(
            Mode(
                f"turn{'+' if sense > 0 else '-'}",
                twist,
                forces,
                np.array([*normal, sense * omega]),
            )
        )
    return found


def wedge_sticks(instant, contacts):
    """The mode in which the object translates with the rod; one force of four is undetermined.

    Of all that balance friction it takes those that keep farthest inside their cones, as far as a
    weight.
    """
    twist, force, torque = instant.about(instant.centre(contacts[0]), instant.velocity, 0.0)
    (a, b), mu = contacts, instant.mu
    # Unknowns: normal and tangential force at both contacts, and how far inside their cones they
    # keep.
    balance = np.zeros((3, 5))
    balance[:2, :4] = np.stack([-a.normal, a.tangent, -b.normal, b.tangent], axis=-1)
    balance[2, [1, 3]] = -instant.radius
    cones = [[-mu, 1, 0, 0, 1], [-mu, -1, 0, 0, 1], [0, 0, -mu, 1, 1], [0, 0, -mu, -1, 1]]
    bounds = [(None, None)] * 4 + [(None, 1.0)]
    found = linprog([0, 0, 0, 0, -1], cones, np.zeros(4), balance, [*force, torque], bounds)
    n0, t0, n1, t1, inside = found.x
    return Mode("wedged", twist, ((n0, t0), (n1, t1)), np.array([inside]))


def point_pivots(instant, contacts):
    """A point in a concave vertex: it turns freely while the force lies in the sum
    of both cones."""
    place, u, mu = np.array(contacts[0].point), instant.velocity, instant.mu
    twist, force, _ = instant.about(place, u, free_spin(instant, place, u))
    # With the second normal clockwise of the first: the outer edges are -n1 - mu t1 and -n2 + mu
    # t2.
    edges = (
        -contacts[0].normal - mu * contacts[0].tangent,
        -contacts[1].normal + mu * contacts[1].tangent,
    )
    normal = np.linalg.solve(np.stack(edges, axis=-1), force)
    forces = (normal[0], -mu * normal[0]), (normal[1], mu * normal[1])
    if cross(edges[0], edges[1]) >= 0.0:
        normal = np.array([1.0, 1.0])  # The cones together hold every force.
    return Mode("pivot", twist, forces, normal)


def modes_of_both(instant, contacts):
    """Every mode that keeps two contacts, consistent or not; the second normal is clockwise of the
    first.
    """
    if instant.radius == 0.0:
        return [point_pivots(instant, contacts)]
    turns = [mode for sense in (1.0, -1.0) for mode in wedge_turns(instant, contacts, sense)]
    return [*turns, wedge_sticks(instant, contacts)]
