"""What mechanics demands of a trajectory, checked from its samples alone: forces, twists and
friction cones.

The ground's law is inverted: the twist at which it balances the reported contact force is found by
Newton's method on the limit surface (over support points, of which one may rest and then carries
any force that its friction holds). That there is one, and that it moves the contact as the rod
asks, shares nothing with the integrated equations.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from cyclemap.mechanics import Ellipse, LimitSurface, PatchFootprint
from cyclemap.mechanics.engine.schema import KINDS, PIECE, RECORD

# Modes of a contact on the outline, with the side of the friction cone that its force lies on.
CONTACTS = {"stick": 0, "slide_left": 1, "slide_right": -1, "slide_free": 0}


@dataclass(frozen=True)
class Check:
    """Worst over the samples, relative to the friction and to unit speed (extents).

    surface : distance of the contact's wrench from what the ground can do.
    motion : how far the contact does not move as the rod asks, or slips against its force.
    cone : how far the force is outside the friction cone, or pulls.
    twists : (n, 3), of the object's frame, at unit speed of the rod (m); nan where the rod is just
        leaving.
    """

    surface: float
    motion: float
    cone: float
    twists: np.ndarray
    wrenches: np.ndarray

    @property
    def worst(self) -> float:
        return max(self.surface, self.motion, self.cone)


def story(stroke):
    """Modes and kinds of contact that a push or drag goes through, in order."""
    course, rows, kinds = stroke.trajectory, stroke.course.rows, tuple(KINDS)
    in_ring = str(course.mode[0]).startswith("ring")
    of_stroke = rows[-len(course.path) :] if in_ring else rows[: len(course.path)]
    pieces = stroke.course.strokes.pieces[RECORD.columns_of(of_stroke).piece.astype(int)]
    numbers = PIECE.columns_of(pieces).kind.astype(int)
    starts = np.unique(course.phase, return_index=True)[1]
    told = [(str(course.mode[k]), kinds[numbers[k]]) for k in starts]
    return [one for k, one in enumerate(told) if k == 0 or one != told[k - 1]]


def check(model, course, pin: float = 0.0) -> Check:
    """Check every sample of a trajectory of a model; `pin`: radius of the ring's friction circle,
    m.
    """
    unit, mu = model.unit, math.sqrt(model.friction.mu_a * model.friction.mu_b)
    scale, worst = np.array((1.0, 1.0, 1.0 / unit)), np.zeros(3)
    twists, wrenches = np.full((len(course.path), 3), np.nan), np.zeros((len(course.path), 3))
    toward = _directions(course)
    for i, mode in enumerate(course.mode.tolist()):
        if mode.startswith("wedge"):
            continue  # Two forces of which only the sum is told.
        (x, y, theta), force = course.pose[i], course.contact_force[i] / model.weight
        back = np.array(((math.cos(theta), math.sin(theta)), (-math.sin(theta), math.cos(theta))))
        force, u, lever = back @ force, back @ toward[i], back @ (course.contact_point[i] - (x, y))
        wrench = wrenches[i] = (*force, lever[0] * force[1] - lever[1] * force[0])
        if mode == "ring_stuck":
            twists[i] = (*u, 0.0)
            off = LimitSurface(model.pressure, model.friction).wrench(twists[i], theta) - wrench
            torque = off[2] - lever[0] * off[1] + lever[1] * off[0]
            off[2] = max(abs(torque) - pin * np.hypot(*force), 0.0)
            worst[0] = max(worst[0], np.abs(scale * off).max() / mu)
            continue
        if mode in ("ring_left", "ring_right"):
            wrench = wrench - np.array(
                (0.0, 0.0, pin * np.hypot(*force) * (1.0 if mode == "ring_left" else -1.0))
            )
        twist, off = _twist_of(
            model.pressure, model.friction, wrench, theta, _guess(course, i, back)
        )
        worst[0] = max(worst[0], off)
        twist = twist / np.abs(twist / scale).max()
        velocity = twist[:2] + twist[2] * np.array((-lever[1], lever[0]))
        if mode in CONTACTS:
            sign = CONTACTS[mode]
            normals = _normals(model, lever, back @ (course.pusher[i] - course.contact_point[i]))
            outside, normal = min(
                (_outside(force, n, model.pusher.friction, mode), tuple(n)) for n in normals
            )
            worst[2] = max(worst[2], outside / mu)
            normal, along = np.array(normal), np.array((-normal[1], normal[0]))
            if sign or mode == "slide_free":
                slip = (velocity @ along) * (u @ normal) - (velocity @ normal) * (u @ along)
                worst[1] = max(worst[1], velocity @ normal, -sign * slip)
                approach = (
                    (u @ normal) / (velocity @ normal) if abs(velocity @ normal) > 1e-9 else np.nan
                )
                twists[i] = twist * approach
                continue
        worst[1] = max(worst[1], abs(velocity[0] * u[1] - velocity[1] * u[0]), -(velocity @ u))
        twists[i] = twist / (velocity @ u) if velocity @ u > 1e-9 else np.nan
    return Check(*worst.tolist(), twists, wrenches)


def _directions(course):
    """Unit vectors (n, 2) along the rod's way at the samples."""
    steps = np.diff(course.pusher, axis=0)
    length = np.hypot(*steps.T)
    found, last = np.zeros((len(course.path), 2)), None
    for i in range(len(course.path)):
        ahead = i < len(steps) and course.phase[i + 1] == course.phase[i] and length[i] > 0.0
        if ahead:
            last = steps[i] / length[i]
        found[i] = last if last is not None else steps[np.argmax(length)] / length.max()
    return found


def _guess(course, i, back):
    """The object's twist from differences of the samples."""
    j = i + 1 if i + 1 < len(course.path) and course.phase[i + 1] == course.phase[i] else i - 1
    moved = (course.pose[j] - course.pose[i]) * (1.0 if j > i else -1.0)
    return np.array((*(back @ moved[:2]), moved[2]))


def _outside(force, normal, friction, mode):
    """How far a force pulls, or lies outside the cone, or off its edge where the rod slides."""
    press, side = -force @ normal, force @ (-normal[1], normal[0])
    off = (
        abs(side) - friction * press
        if mode == "stick"
        else abs(side - CONTACTS[mode] * friction * press)
    )
    return max(float(off), float(-press))


def _normals(model, lever, towards_rod):
    """Outward normals of the outline at a contact, in the object's frame; at a corner a point rod
    has those of both.
    """
    if model.pusher.radius > 0.0:
        return (towards_rod / np.hypot(*towards_rod))[None]
    outline = model.slider.outline
    if isinstance(outline, Ellipse):
        normal = lever / np.square((outline.semi_x, outline.semi_y))
        return (normal / np.hypot(*normal))[None]
    a = outline.array
    edge = np.roll(a, -1, axis=0) - a
    normals = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / np.hypot(*edge.T)[:, None]
    share = np.clip(((lever - a) * edge).sum(1) / (edge * edge).sum(1), 0.0, 1.0)
    gap = np.hypot(*(lever - a - share[:, None] * edge).T)
    return normals[gap < gap.min() + 1e-6 * model.unit]


def _twist_of(footprint, law, wrench, theta, guess):
    """Twist of which a wrench is the ground's, and how far the wrench is from what the ground can
    do.

    The ground's wrenches are a convex body with the dissipation D for a support function: over all
    twists V the largest w.V / D(V) is one where w is on its surface, at the twist of which w is the
    wrench.
    """
    surface, size = LimitSurface(footprint, law), footprint.extent
    scale = np.array((1.0, 1.0, 1.0 / size))

    def power(vector):
        return float(wrench @ (scale * vector)) / float(surface.dissipation(scale * vector, theta))

    # Newton's method on D^2/2 - w.V, which is convex: its least is at that twist.
    found = []
    for start in (guess / scale, wrench * scale):
        if not np.any(start):
            continue
        vector = start * power(start) / float(surface.dissipation(scale * start, theta))
        for _ in range(60):
            slope = scale * surface.wrench(scale * vector, theta)
            lost = slope @ vector
            off = lost * slope - scale * wrench
            converged = np.abs(off).max() < 1e-13
            if converged:
                break
            bend = np.outer(slope, slope) + lost * np.outer(scale, scale) * surface.hessian(
                scale * vector, theta
            )
            step, height = (
                -np.linalg.lstsq(bend, off, rcond=1e-13)[0],
                0.5 * lost**2 - scale * wrench @ vector,
            )
            for share in 0.5 ** np.arange(12):
                tried = vector + share * step
                if np.any(tried) and (
                    0.5 * surface.dissipation(scale * tried, theta) ** 2 - scale * wrench @ tried
                    < height
                    or np.abs(share * step).max() < 1e-7 * np.abs(vector).max()
                ):
                    break
            else:
                break
            vector = tried
        found.append(vector)
        if converged:
            break  # The function is convex: no other start ends elsewhere.
    # Where the centre of rotation is at a support point or a loaded corner, or all but there, D has
    # a kink.
    if abs(max(map(power, found)) - 1.0) > 1e-11:
        pins = [
            sign * np.array((y / size, -x / size, 1.0))
            for x, y in _points(footprint)
            for sign in (1.0, -1.0)
        ]
        found = sorted([*found, *pins], key=power, reverse=True)[:4]
    if abs(power(found[0]) - 1.0) > 1e-11:
        exact = {"xatol": 1e-14, "fatol": 1e-17, "maxiter": 4000}
        found += [
            minimize(lambda v: -power(v), v, method="Nelder-Mead", options=exact).x for v in found
        ]
    best = max(found, key=power)
    return scale * best, abs(power(best) - 1.0)


def _points(footprint):
    """Places of what is a point of the pressure."""
    if isinstance(footprint, PatchFootprint):
        return footprint.outline.vertices if footprint.corner_share else ()
    return footprint.positions
