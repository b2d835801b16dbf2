"""What mechanics demands of a trajectory, checked from its samples alone: forces, twists and friction cones.

The ground's law is inverted: the twist at which it balances the reported contact force is found by Newton's method on
the limit surface (over support points, of which one may rest and then carries any force that its friction holds). That
there is one, and that it moves the contact as the rod asks, shares nothing with the integrated equations.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from cyclemap.mechanics import Ellipse, EllipseFriction, LimitSurface, PatchFootprint
from cyclemap.mechanics.engine.strokes import KINDS

# Modes of a contact on the outline, with the side of the friction cone that its force lies on.
CONTACTS = {"stick": 0, "slide_left": 1, "slide_right": -1, "slide_free": 0}


@dataclass(frozen=True)
class Check:
    """Worst over the samples, relative to the friction and to unit speed (extents).

    surface : distance of the contact's wrench from what the ground can do. motion : how far the contact does not move
    as the rod asks, or slips against its force. cone : how far the force is outside the friction cone, or pulls.
    twists : (n, 3), of the object's frame, at unit speed of the rod (m); nan where the rod is just leaving.
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
    course, rows = stroke.trajectory, stroke.course.rows
    pieces = stroke.course.strokes.pieces[rows[-len(course.path) :, 6].astype(int), 0].astype(int)
    if not set(course.mode[:1]) <= {"ring", "ring_left", "ring_right", "ring_stuck"}:
        pieces = stroke.course.strokes.pieces[rows[: len(course.path), 6].astype(int), 0].astype(int)
    told = [(str(course.mode[k]), KINDS[pieces[k]]) for k in np.unique(course.phase, return_index=True)[1]]
    return [one for k, one in enumerate(told) if k == 0 or one != told[k - 1]]


def check(model, course, pin: float = 0.0) -> Check:
    """Check every sample of a trajectory of a model; `pin`: radius of the ring's friction circle, m."""
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
            wrench = wrench - np.array((0.0, 0.0, pin * np.hypot(*force) * (1.0 if mode == "ring_left" else -1.0)))
        twist, off = _twist_of(model.pressure, model.friction, wrench, theta, _guess(course, i, back))
        worst[0] = max(worst[0], off / mu)
        twist = twist / np.abs(twist / scale).max()
        velocity = twist[:2] + twist[2] * np.array((-lever[1], lever[0]))
        if mode in CONTACTS:
            sign = CONTACTS[mode]
            normals = _normals(model, lever, back @ (course.pusher[i] - course.contact_point[i]))
            outside, normal = min((_outside(force, n, model.pusher.friction, mode), tuple(n)) for n in normals)
            worst[2] = max(worst[2], outside / mu)
            normal, along = np.array(normal), np.array((-normal[1], normal[0]))
            if sign or mode == "slide_free":
                slip = (velocity @ along) * (u @ normal) - (velocity @ normal) * (u @ along)
                worst[1] = max(worst[1], velocity @ normal, -sign * slip)
                approach = (u @ normal) / (velocity @ normal) if abs(velocity @ normal) > 1e-9 else np.nan
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
    off = abs(side) - friction * press if mode == "stick" else abs(side - CONTACTS[mode] * friction * press)
    return max(float(off), float(-press))


def _normals(model, lever, towards_rod):
    """Outward normals of the outline at a contact, in the object's frame; at a corner a point rod has those of both."""
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
    """Twist at which the ground's wrench is the one given, and how far it still is from it (extents)."""
    surface, size = LimitSurface(footprint, law), footprint.extent
    scale = np.array((1.0, 1.0, 1.0 / size))
    best = None
    for start in (guess, wrench * scale * scale):
        if not np.any(start):
            continue
        found = _newton(surface, scale, wrench, theta, start / np.abs(start / scale).max())
        if best is None or found[1] < best[1]:
            best = found
        if best[1] < 1e-11:
            break
    # A support point or loaded corner rests, or is slow, where the centre of rotation is at it or near.
    resting = []
    for (x, y), load in _points(footprint) if best[1] >= 1e-11 else ():
        for spin in (1.0, -1.0):
            twist = spin * np.array((y, -x, 1.0)) / size
            off, traction = off_rest(surface, (x, y), load, twist, wrench, theta)
            resting.append((float(np.abs(scale * off).max()), (x, y), twist, _slip_of(law, traction, theta)))
    if not resting:
        return best
    resting.sort(key=lambda found: found[0])
    best = min(best, (resting[0][2], resting[0][0]), key=lambda found: found[1])
    if best[1] > 1e-11:
        # Where a point with most of the load all but rests, no step of Newton's finds its slip; the convex body does.
        starts = [best[0], *(twist for _, _, twist, _ in resting[:4])]
        best = min(best, _touching(surface, scale, wrench, theta, starts), key=lambda found: found[1])
    for _, _, twist, slip in resting[:4]:
        for speed in 10.0 ** np.arange(-1.0, -9.0, -1.0):
            if best[1] > 1e-11:
                start = twist + speed * np.array((*slip, 0.0))
                best = min(best, _newton(surface, scale, wrench, theta, start), key=lambda found: found[1])
    return best


def _touching(surface, scale, wrench, theta, starts):
    """Twist that tells a wrench from the ground's best, and how far the wrench is from the surface in its direction.

    The ground's wrenches are a convex body with the dissipation for a support function: a wrench is on its surface
    where power less dissipation is zero at most, over all twists of one size, and zero at one.
    """

    def lost(vector):
        twist = vector / np.linalg.norm(vector) * scale
        return float(twist @ (surface.wrench(twist, theta) - wrench))

    exact = {"xatol": 1e-14, "fatol": 1e-17, "maxiter": 4000}
    tried = [minimize(lost, start / scale, method="Nelder-Mead", options=exact) for start in starts]
    found = min(tried, key=lambda one: one.fun)
    return found.x / np.linalg.norm(found.x) * scale, abs(float(found.fun))


def _slip_of(law, traction, theta):
    """Unit velocity (object's frame) at which a point has a traction, or would be if it were on the ellipse."""
    c, s = math.cos(law.phi - theta), math.sin(law.phi - theta)
    back = np.array(((c, -s), (s, c)))
    slip = back @ ((back.T @ traction - (law.m0, law.n0)) / np.square((law.mu_a, law.mu_b)))
    return slip / max(np.hypot(*slip), 1e-300)


def _newton(surface, scale, wrench, theta, twist):
    off = scale * (wrench - surface.wrench(twist, theta))
    for _ in range(60):
        size = np.abs(off).max()
        if size < 1e-15:
            break
        bend = surface.hessian(twist, theta) * np.outer(scale, scale)
        step = scale * np.linalg.lstsq(bend, off, rcond=1e-11)[0]
        for share in 0.5 ** np.arange(12):
            tried = twist + share * step
            if not np.any(tried):
                continue
            tried = tried / np.abs(tried / scale).max()
            left = scale * (wrench - surface.wrench(tried, theta))
            if np.abs(left).max() < size:
                break
        else:
            break
        twist, off = tried, left
    return twist, float(np.abs(off).max())


def _points(footprint):
    """Places and loads of what is a point of the pressure."""
    if isinstance(footprint, PatchFootprint):
        share = footprint.corner_share / len(footprint.outline.vertices) if footprint.corner_share else 0.0
        return [(place, share) for place in footprint.outline.vertices] if share else []
    return list(zip(footprint.positions, footprint.weights, strict=True))


def off_rest(surface, place, load, twist, wrench, theta: float) -> tuple[np.ndarray, np.ndarray]:
    """Wrench (3,) of the ground at a twist about a point, less a contact's; and the traction asked of the point.

    The point takes the force that the others leave, as far as its friction goes.
    """
    # Theirs is the whole, at a twist at which the point just moves, less what the point then does.
    x, y = place
    fx, fy = load * surface.friction.traction((1.0, 0.0), theta)
    others = surface.wrench(twist + np.array((1e-11, 0.0, 0.0)), theta) - np.array((fx, fy, x * fy - y * fx))
    asked = (wrench - others)[:2] / load
    fx, fy = load * _nearest_held(surface.friction, asked, theta)
    return others + np.array((fx, fy, x * fy - y * fx)) - wrench, asked


def _nearest_held(law: EllipseFriction, traction, theta: float) -> np.ndarray:
    """A traction (object's frame), drawn towards the friction ellipse's centre until it lies inside."""
    c, s = math.cos(law.phi - theta), math.sin(law.phi - theta)
    back = np.array(((c, -s), (s, c)))
    centre = np.array((law.m0, law.n0))
    arm = back.T @ traction - centre
    return back @ (centre + arm / max(1.0, math.hypot(arm[0] / law.mu_a, arm[1] / law.mu_b)))
