"""A second route to pushes around concave outlines: every mode of one or two contacts, tried at each instant.

Plain NumPy and SciPy; friction is any function (twist, theta) -> grad D. The equations are those of
docs/theory/two-contacts.md. Lengths m, angles rad; twists, forces and contacts in the object's frame, forces per unit
load; the rod's speed is one.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, linprog, root


def quarter(vector):
    """z x vector."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def unit(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def turned(angle, vector):
    return vector[0] * unit(angle) + vector[1] * quarter(unit(angle))


def wrench_on_points(law, points, twist, theta):
    """Mean force and torque about the object's origin of equally loaded points, from the point law alone."""
    x, y = points.T
    traction = law.traction(np.stack([twist[0] - twist[2] * y, twist[1] + twist[2] * x], axis=-1), frame=theta)
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
    """What one instant gives: friction, the rod's radius, friction, and velocity in the object's frame; a length."""

    wrench: object
    theta: float
    velocity: np.ndarray
    radius: float
    mu: float
    extent: float

    def centre(self, contact):
        return np.array(contact.point) + self.radius * contact.normal

    def about(self, place, velocity, omega):
        """Twist of an object whose point at a place has a velocity, and (force, torque about the place) for it."""
        twist = np.array([*(velocity - omega * quarter(np.asarray(place))), omega])
        g = self.wrench(twist, self.theta)
        return twist, g[:2], g[2] - cross(np.asarray(place), g[:2])


@dataclass(frozen=True)
class Mode:
    """A solution of the balance of forces: contacts kept, slips' sense, twist, forces at contacts (normal, tangential).

    `margins` are all positive where the mode is consistent: forces in their cones, slips as friction has them, contacts
    that open; a wedge that sticks is told by one, how much of its undetermined force is free.
    """

    name: str
    twist: np.ndarray
    forces: tuple
    margins: np.ndarray

    @property
    def consistent(self):
        return bool(self.margins.min() > 0.0)


def free_spin(instant, place, velocity, guess=0.0):
    """Spin about a place that needs no torque there: it grows with the spin, so that the bracket always closes."""

    def torque(omega):
        return instant.about(place, velocity, omega)[2]

    step = 1e-3 / instant.extent if guess else 1.0 / instant.extent
    sign = -1.0 if torque(guess) > 0.0 else 1.0
    inner, outer = guess, guess + sign * step
    while torque(outer) * sign < 0.0:
        inner, step = outer, 4.0 * step
        outer += sign * step
    return brentq(torque, *sorted((inner, outer)), xtol=1e-15 / instant.extent, rtol=1e-15)


def sliding_twist(instant, contact, sense, guess=None):
    """The twist, up to a factor, that a force along the cone's edge -n + sense mu t drives, and the force's size.

    The contact moves within a right angle of that force, and the force turns as the contact's velocity does.
    """
    edge = -contact.normal + sense * instant.mu * contact.tangent
    toward = math.atan2(edge[1], edge[0])
    scale = np.array([1.0, 1.0 / instant.extent])

    def off(x):
        _, force, torque = instant.about(contact.point, unit(x[0]), x[1] * scale[1])
        return cross(force, edge), torque * scale[1]

    def across(angle):
        return off((angle, free_spin(instant, contact.point, unit(angle)) / scale[1]))[0]

    if guess is not None:
        found = root(off, np.array(guess) / scale, method="hybr", options={"xtol": 1e-14})
        angle, omega = found.x * scale
    if guess is None or np.abs(found.fun).max() >= 1e-13 or math.cos(angle - toward) <= 0.0:
        angle = brentq(across, toward - math.pi / 2.0, toward + math.pi / 2.0, xtol=1e-15, rtol=1e-15)
        omega = free_spin(instant, contact.point, unit(angle))
    twist, force, _ = instant.about(contact.point, unit(angle), omega)
    return twist, -force @ contact.normal, (angle, omega)


def one_contact(instant, contact, opens=(), guesses=None, only=None):
    """Modes that keep one contact; `opens` are the others that touch, which must open."""
    n, t, u = contact.normal, contact.tangent, instant.velocity
    guesses = {} if guesses is None else guesses
    found = []

    def gaps(twist):
        velocity = twist[:2] + twist[2] * quarter(instant.centre(contact))
        return [other.normal @ (u - velocity) for other in opens]

    if only in (None, "stick"):
        omega = free_spin(instant, contact.point, u, guesses.get("stick", 0.0))
        guesses["stick"] = omega
        twist, force, _ = instant.about(contact.point, u, omega)
        normal, tangential = -force @ n, force @ t
        margins = [instant.mu * normal - tangential, instant.mu * normal + tangential, *gaps(twist)]
        found.append(Mode("stick", twist, ((normal, tangential),), np.array(margins)))
    for sense, name in ((1.0, "slide+"), (-1.0, "slide-")):
        if only not in (None, name):
            continue
        twist, normal, guesses[name] = sliding_twist(instant, contact, sense, guesses.get(name))
        velocity = twist[:2] + twist[2] * quarter(np.array(contact.point))
        factor = (n @ u) / (n @ velocity)
        twist, velocity = factor * twist, factor * velocity
        margins = [factor, normal, sense * (u - velocity) @ t, *gaps(twist)]
        found.append(Mode(name, twist, ((normal, sense * instant.mu * normal),), np.array(margins)))
    return found


def wedge_turns(instant, contacts, sense, near=None):
    """Modes that keep both contacts and turn about the rod: a bearing whose friction opposes the turn."""
    place, u, mu = instant.centre(contacts[0]), instant.velocity, instant.mu
    # Both slide in one sense: their forces along these edges add up to that of friction.
    edges = np.stack([-c.normal + sense * mu * c.tangent for c in contacts], axis=-1)

    def surplus(omega):
        _, force, torque = instant.about(place, u, omega)
        return torque + sense * instant.radius * mu * np.linalg.solve(edges, force).sum()

    def brackets(grid):
        values = [surplus(omega) for omega in grid]
        return [sorted(grid[i : i + 2]) for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0.0]

    close = [] if near is None else brackets(near + np.array((-1.0, 1.0)) * (0.03 * abs(near) + 1e-3 / instant.extent))
    found = []
    for bracket in close or brackets(sense * np.tan(np.linspace(0.0, 1.569, 160)) / instant.extent):
        omega = brentq(surplus, *bracket, xtol=1e-16, rtol=1e-15)
        twist, force, _ = instant.about(place, u, omega)
        normal = np.linalg.solve(edges, force)
        forces = tuple((one, sense * mu * one) for one in normal)
        found.append(Mode(f"turn{'+' if sense > 0 else '-'}", twist, forces, np.array([*normal, sense * omega])))
    return found


def wedge_sticks(instant, contacts):
    """The mode in which the object translates with the rod; one force of four is undetermined.

    Of all that balance friction it takes those that keep farthest inside their cones, as far as a weight.
    """
    twist, force, torque = instant.about(instant.centre(contacts[0]), instant.velocity, 0.0)
    (a, b), mu = contacts, instant.mu
    # Unknowns: normal and tangential force at both contacts, and how far inside their cones they keep.
    balance = np.zeros((3, 5))
    balance[:2, :4] = np.stack([-a.normal, a.tangent, -b.normal, b.tangent], axis=-1)
    balance[2, [1, 3]] = -instant.radius
    cones = [[-mu, 1, 0, 0, 1], [-mu, -1, 0, 0, 1], [0, 0, -mu, 1, 1], [0, 0, -mu, -1, 1]]
    bounds = [(None, None)] * 4 + [(None, 1.0)]
    found = linprog([0, 0, 0, 0, -1], cones, np.zeros(4), balance, [*force, torque], bounds)
    n0, t0, n1, t1, inside = found.x
    return Mode("wedged", twist, ((n0, t0), (n1, t1)), np.array([inside]))


def point_pivots(instant, contacts):
    """A point in a concave vertex: it turns freely while the force lies in the sum of both cones."""
    place, u, mu = np.array(contacts[0].point), instant.velocity, instant.mu
    twist, force, _ = instant.about(place, u, free_spin(instant, place, u))
    # With the second normal clockwise of the first: the outer edges are -n1 - mu t1 and -n2 + mu t2.
    edges = -contacts[0].normal - mu * contacts[0].tangent, -contacts[1].normal + mu * contacts[1].tangent
    normal = np.linalg.solve(np.stack(edges, axis=-1), force)
    forces = (normal[0], -mu * normal[0]), (normal[1], mu * normal[1])
    if cross(edges[0], edges[1]) >= 0.0:
        normal = np.array([1.0, 1.0])  # The cones together hold every force.
    return Mode("pivot", twist, forces, normal)


def two_contacts(instant, contacts):
    """Every mode of two contacts, consistent or not, as (kept, mode); the second normal is clockwise of the first."""
    found = []
    for kept in (0, 1):
        for mode in one_contact(instant, contacts[kept], (contacts[1 - kept],)):
            # At a vertex a point that sticks to one side sticks to both.
            if instant.radius > 0.0 or mode.name != "stick":
                found.append((str(kept), mode))
    if instant.radius == 0.0:
        return [*found, ("both", point_pivots(instant, contacts))]
    for sense in (1.0, -1.0):
        found += [("both", mode) for mode in wedge_turns(instant, contacts, sense)]
    return [*found, ("both", wedge_sticks(instant, contacts))]


def consistent_modes(instant, contacts):
    """Those modes of two contacts that hold, as (kept, mode)."""
    return [(kept, mode) for kept, mode in two_contacts(instant, contacts) if mode.consistent]


@dataclass(frozen=True)
class Plate:
    """A polygon (counter-clockwise vertices) with its friction, and the rod: radius and friction with the plate."""

    vertices: tuple
    wrench: object
    radius: float
    mu: float

    @property
    def extent(self):
        return float(np.ptp(self.vertices, axis=0).max())

    def side(self, i):
        """First vertex, direction, length and normal's angle of a side."""
        a, b = (np.array(self.vertices[k % len(self.vertices)]) for k in (i, i + 1))
        size = math.dist(a, b)
        along = (b - a) / size
        return a, along, size, math.atan2(-along[0], along[1])

    def turn(self, i):
        """Turn from the side before vertex i to the one behind it, positive where convex."""
        return math.remainder(self.side(i)[3] - self.side(i - 1)[3], 2.0 * math.pi)

    def contact(self, place):
        """The contact at a place ("side", side, distance) or ("corner", vertex, angle)."""
        kind, i, q = place
        if kind == "side":
            a, along, _, angle = self.side(i)
            return Contact(tuple(a + q * along), angle)
        return Contact(self.vertices[i], q)

    def centre(self, place):
        """Where the rod's centre is when it touches there."""
        contact = self.contact(place)
        return np.array(contact.point) + self.radius * contact.normal

    def bounds(self, place):
        kind, i, _ = place
        if kind == "side":
            return self.reach(i), self.side(i)[2] - self.reach(i + 1)
        return self.side(i - 1)[3], self.side(i - 1)[3] + self.turn(i)

    def reach(self, i):
        """How far from a concave vertex the rod touches both sides there; zero where they are too short for that."""
        reach = self.radius * math.tan(max(-self.turn(i), 0.0) / 2.0)
        return reach if reach < min(self.side(i - 1)[2], self.side(i)[2]) else 0.0

    def others(self, place):
        """Sides that the rod may run into before it comes to an end of its place."""
        kind, i, _ = place
        own = {i, i - 1} if kind == "corner" else {i}
        if kind == "side":
            # A neighbour behind a concave corner that the rod does not reach into may come first.
            ends = ((i - 1, i), (i + 1, i + 1))
            own |= {j for j, end in ends if self.turn(end) > 0.0 or self.reach(end) > 0.0 or self.radius == 0.0}
        count = len(self.vertices)
        return [j for j in range(count) if j not in {k % count for k in own}]

    def nearest(self, centre, sides):
        """Distance of the nearest of some sides, and the place there."""
        found = []
        for j in sides:
            a, along, size, _ = self.side(j)
            q = float((centre - a) @ along)
            away = centre - a - min(max(q, 0.0), size) * along
            if 0.0 < q < size:
                place = ("side", j, q)
            else:
                vertex = j if q <= 0.0 else (j + 1) % len(self.vertices)
                low = self.side(vertex - 1)[3]
                angle = math.atan2(away[1], away[0])
                place = ("corner", vertex, low + (angle - low) % (2.0 * math.pi))
            found.append((float(np.hypot(*away)), place))
        return min(found, default=(math.inf, None), key=lambda one: one[0])


class Push(NamedTuple):
    """Where a push ended: (x, y, theta), "distance" or "left", the modes it went through, and what was ambiguous."""

    pose: tuple
    ended: str
    modes: tuple
    ambiguous: tuple


def run_push(plate, side, fraction, theta, angle, length, accuracy=1e-10):
    """Push a plate at the origin, turned by theta, from a fraction of a side; angle as in SidePush."""
    return _Run(plate, theta + plate.side(side)[3] + math.pi + angle, length, accuracy).go(side, fraction, theta)


class _Run:
    def __init__(self, plate, direction, length, accuracy):
        self.plate, self.direction, self.length, self.accuracy = plate, direction, length, accuracy
        self.guesses = {}

    def instant(self, theta):
        p = self.plate
        return Instant(p.wrench, theta, unit(self.direction - theta), p.radius, p.mu, p.extent)

    def go(self, side, fraction, theta):
        p, travel = self.plate, 0.0
        touching = [("side", side, fraction * p.side(side)[2])]
        start = turned(theta, p.centre(touching[0]))
        modes, ambiguous, previous, ended = [], [], None, None
        while ended is None:
            kept, name, several = self.resolve(theta, touching, previous)
            if several:
                ambiguous.append(several)
            if kept is None:
                ended = "left"
                break
            modes.append(name if len(touching) == 1 else f"wedge {name}" if kept == "both" else f"leave {name}")
            if name == "wedged":
                travel = self.length
            elif kept == "both":
                theta, travel = self.turn(theta, travel, touching, name)
            else:
                theta, travel, touching, left = self.roll(theta, travel, touching[kept], name)
                ended = "left" if left else None
            previous = name
            if ended is None and travel >= self.length * (1.0 - 1e-14):
                ended = "distance"
            assert len(modes) < 200
        x, y = start + travel * unit(self.direction) - turned(theta, p.centre(touching[0]))
        return Push((float(x), float(y), float(theta)), ended, tuple(modes), tuple(ambiguous))

    def ordered(self, touching):
        """Contacts of a wedge and whether they had to be exchanged: the second normal is clockwise of the first."""
        contacts = [self.plate.contact(place) for place in touching]
        swapped = bool(cross(contacts[0].normal, contacts[1].normal) > 0.0)
        return contacts[::-1] if swapped else contacts, swapped

    def resolve(self, theta, touching, previous):
        """The mode that holds from here on: that which still does a little further on its own way."""
        instant = self.instant(theta)
        if all(self.plate.contact(place).normal @ instant.velocity >= -1e-13 for place in touching):
            return None, None, None
        if len(touching) == 1:
            modes = [(0, mode) for mode in one_contact(instant, self.plate.contact(touching[0]))]
        else:
            contacts, swapped = self.ordered(touching)
            modes = two_contacts(instant, contacts)
            modes = [(kept if kept == "both" else int(kept) ^ swapped, mode) for kept, mode in modes]
        holding = []
        for kept, mode in modes:
            # A sliding twist with a negative factor would take the contact backwards.
            forward = kept == "both" or mode.name == "stick" or mode.margins[0] > 0.0
            if forward and mode.margins.min() > -1e-6 and self.goes_on(theta, touching, kept, mode):
                holding.append((kept, mode.name))
        assert holding, (theta, touching, [(kept, mode.name, mode.margins) for kept, mode in modes])
        several = tuple(name for _, name in holding) if len(holding) > 1 else None
        # Of several the one without a force inside the wedge that nothing has built up.
        holding.sort(key=lambda one: (one[1] == "wedged", one[1] != previous))
        return (*holding[0], several)

    def goes_on(self, theta, touching, kept, mode):
        step = 1e-6 * self.plate.extent
        ahead = self.instant(theta + step * mode.twist[2])
        if kept == "both":
            contacts, _ = self.ordered(touching)
            if mode.name in ("wedged", "pivot"):
                again = wedge_sticks(ahead, contacts) if mode.name == "wedged" else point_pivots(ahead, contacts)
                return again.consistent
            turns = wedge_turns(ahead, contacts, 1.0 if mode.name == "turn+" else -1.0, mode.twist[2])
            return any(again.consistent for again in turns)
        place = touching[kept]
        q = place[2] + step * self.speed(theta, place, mode)
        low, high = self.plate.bounds(place)
        if len(touching) == 1 and not low - 1e-12 <= q <= high + 1e-12:
            q = min(max(q, low), high)
        there = (*place[:2], q)
        # The rates ahead: where a force has just vanished the other contact opens from rest.
        opens = [self.plate.contact(touching[1 - kept])] if len(touching) == 2 else []
        return one_contact(ahead, self.plate.contact(there), opens, only=mode.name)[0].consistent

    def speed(self, theta, place, mode):
        """Rate of a place's coordinate under a mode."""
        centre, contact = self.plate.centre(place), self.plate.contact(place)
        slip = unit(self.direction - theta) - mode.twist[:2] - mode.twist[2] * quarter(centre)
        return float(slip @ contact.tangent) / (1.0 if place[0] == "side" else self.plate.radius)

    def integrate(self, rates, events, state, travel):
        for event in events:
            event.terminal, event.direction = True, -1
        options = {"rtol": self.accuracy, "atol": 0.01 * self.accuracy, "max_step": 0.05 * self.length}
        ivp = solve_ivp(rates, (travel, self.length), state, method="DOP853", events=events, **options)
        assert ivp.success
        which = next((i for i, times in enumerate(ivp.t_events) if len(times)), None)
        return ivp.y[:, -1], float(ivp.t[-1]), which

    def roll(self, theta, travel, place, name):
        """Go on with one contact until its mode, its place or the number of contacts changes."""
        p, kind, i = self.plate, place[0], place[1]
        low, high = p.bounds(place)
        others = p.others(place)

        def mode(state):
            contact = p.contact((kind, i, state[1]))
            return one_contact(self.instant(state[0]), contact, (), self.guesses, name)[0]

        def rates(_, state):
            found = mode(state)
            return [found.twist[2], self.speed(state[0], (kind, i, state[1]), found)]

        margins = (0, 1) if name == "stick" else (2,)
        events = [
            lambda _, state: -p.contact((kind, i, state[1])).normal @ unit(self.direction - state[0]),
            lambda _, state: state[1] - low,
            lambda _, state: high - state[1],
            *[lambda _, state: p.nearest(p.centre((kind, i, state[1])), others)[0] - p.radius for _ in others[:1]],
            *[lambda _, state, k=k: mode(state).margins[k] for k in margins],
        ]
        state, travel, which = self.integrate(rates, events, [theta, place[2]], travel)
        theta, place = float(state[0]), (kind, i, float(state[1]))
        if which in (1, 2):
            return theta, travel, self.across(place, which == 2), False
        if which == 3 and others:
            _, other = p.nearest(p.centre(place), others)
            return theta, travel, [place, other], False
        return theta, travel, [place], which == 0

    def across(self, place, forward):
        """What the rod touches past an end of its place."""
        p, count = self.plate, len(self.plate.vertices)
        kind, i, _ = place
        if kind == "corner":
            return [("side", i, 0.0) if forward else ("side", (i - 1) % count, p.side(i - 1)[2])]
        vertex = (i + 1) % count if forward else i
        if p.radius > 0.0 and p.turn(vertex) > 0.0:
            return [("corner", vertex, p.side(vertex - 1)[3] + (0.0 if forward else p.turn(vertex)))]
        reach = p.reach(vertex)
        onward = ("side", vertex, reach) if forward else ("side", (i - 1) % count, p.side(i - 1)[2] - reach)
        here = ("side", i, p.side(i)[2] - reach if forward else reach)
        return [onward] if p.turn(vertex) > 0.0 else [here, onward]

    def turn(self, theta, travel, touching, name):
        """Turn about the rod, both contacts kept, until a force vanishes or the turn does."""
        contacts, _ = self.ordered(touching)
        near = [None]

        def mode(theta):
            if name == "pivot":
                return point_pivots(self.instant(theta), contacts)
            found = wedge_turns(self.instant(theta), contacts, 1.0 if name == "turn+" else -1.0, near[0])
            best = min(found, key=lambda one: abs(one.twist[2] - (near[0] or 0.0)))
            near[0] = best.twist[2]
            return best

        count = 2 if name == "pivot" else 3
        events = [lambda _, state, k=k: mode(state[0]).margins[k] for k in range(count)]
        state, travel, _ = self.integrate(lambda _, state: [mode(state[0]).twist[2]], events, [theta], travel)
        return float(state[0]), travel
