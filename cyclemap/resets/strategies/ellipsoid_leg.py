"""A straight leg of a drag in closed form: exact under an ellipsoidal limit surface, and near trailing for any patch.

Derivations: docs/theory/moebius-drag.md, trailing-leg.md and random-leg.md. Headings are angles of the lever (from the
centre of pressure to the ring) from the trailing one, rad: 0 where the object trails behind its ring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, finite_number, non_negative_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EllipsoidLeg:
    """A leg on which headings obey d(psi)/ds = -rate sin(psi); `rate` is in 1/m, s the path of the ring.

    Under an isotropic ellipsoid rate = r/(r^2 + c^2), r the lever and c the ratio of the moment to the force that
    friction can bear (Goyal, Ruina & Papadopoulos 1991; Howe & Cutkosky 1996 for the ellipsoid).

    >>> leg = EllipsoidLeg.of_lever(0.015, 0.09 / math.sqrt(12.0))
    >>> round(leg.forgetting_length(math.radians(5.0), 5.0 / 180.0), 3)  # m
    0.376
    """

    rate: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", positive_number("rate", self.rate))

    @classmethod
    def of_lever(cls, lever: float, spin_radius: float) -> EllipsoidLeg:
        """Return the leg of an object whose ring is `lever` (m) off its centre, c = `spin_radius` (m)."""
        r, c = positive_number("lever", lever), positive_number("spin radius", spin_radius)
        return cls(r / (r * r + c * c))

    def strength(self, length: float) -> float:
        """Return a = tanh(rate length/2) of a leg (m): its map is z -> (z + a)/(1 + a z), z = e^{i psi}.

        a is also the resultant that the leg leaves of headings that were evenly spread, and 1 - a^2 the correlation
        that a leg in a uniformly random direction leaves between cycles.
        """
        return math.tanh(0.5 * self.rate * non_negative_number("length", length))

    def heading_after(self, heading: ArrayLike, length: float) -> Array:
        """Return the heading (...), within (-pi, pi], after a leg (m): tan(psi/2) shrinks by exp(-rate length)."""
        start = finite_array("heading", heading)
        shrink = math.exp(-self.rate * non_negative_number("length", length))
        return 2.0 * np.arctan2(shrink * np.sin(0.5 * start), np.cos(0.5 * start))

    def share_within(self, tolerance: float, length: float) -> float:
        """Return the share of evenly spread headings that a leg (m) brings within `tolerance` (rad) of trailing."""
        grown = math.exp(self.rate * non_negative_number("length", length))
        return 2.0 / math.pi * math.atan(grown * math.tan(0.5 * checked_tolerance(tolerance)))

    def forgetting_length(self, tolerance: float, left_out: float) -> float:
        """Return the leg (m) after which all headings but a share `left_out` lie within `tolerance` (rad) of trailing.

        (1/rate) ln(cot(pi left_out/2) cot(tolerance/2)), or 0 where no leg is needed. No leg does for a share of zero:
        the object that goes straight ahead of its ring stays there.
        """
        share = checked_share(left_out)
        product = math.tan(0.5 * math.pi * share) * math.tan(0.5 * checked_tolerance(tolerance))
        return max(-math.log(product), 0.0) / self.rate


@dataclass(frozen=True)
class TrailingPoint:
    """Where an object comes to trail on a leg in one direction, exact for any pressure and friction ellipse.

    direction : of the leg, rad, world. theta : orientation of the object that trails, rad, within (-pi, pi].
    force_direction : rad, of the friction force there, along which the lever lies. rate : 1/m, at which small headings
    die away (`EllipsoidLeg.rate` under an ellipsoid); ahead of its ring, at theta + pi, they grow as fast.
    """

    direction: float
    theta: float
    force_direction: float
    rate: float

    @property
    def leg(self) -> EllipsoidLeg:
        """The leg of the ellipsoid with this rate: the closed form nearest to the true leg."""
        return EllipsoidLeg(self.rate)


def trailing_point(loop: CollectionLoop, direction: float = 0.0) -> TrailingPoint:
    """Return where the loop's object trails on a leg along `direction` (rad, world), and how fast it gets there.

    With f the friction force of translation along u, s its part without offset, Q the ellipse and r the lever,
    rate = |f| r s^3/(det Q ((u.rho)^2 + <(u.x)^2>)), rho = r f/|f|, the mean taken over the pressure
    (docs/theory/trailing-leg.md). Raises InvalidInput where the ring is at the centre of pressure, or has friction,
    which holds the object off its trailing orientation.

    >>> even = trailing_point(CollectionLoop.from_settings({"mu_a": 0.2, "mu_b": 0.2, "m0": 0.0, "n0": 0.0}))
    >>> round(even.rate, 6) == round(0.015 / (0.015**2 + 0.09**2 / 12.0), 6)
    True
    """
    towards = finite_number("direction", direction)
    friction, pressure = loop.material.friction, loop.model.pressure
    arm = np.subtract(loop.slider.hitch, pressure.centre)
    lever = float(np.hypot(*arm))
    if lever <= 1e-9 * pressure.extent:
        raise InvalidInput("the ring is at the centre of pressure: dragged there, an object never comes to trail")
    if loop.reset.pin_friction_radius > 0.0:
        raise InvalidInput("the ring's friction holds the object off its trailing orientation: set it to zero")
    u = np.array((math.cos(towards), math.sin(towards)))
    force = friction.traction(u)
    pulled = math.atan2(force[1], force[0])
    theta = math.remainder(pulled - math.atan2(arm[1], arm[0]), 2.0 * math.pi)
    s = math.hypot(friction.mu_a * math.cos(towards - friction.phi), friction.mu_b * math.sin(towards - friction.phi))
    along = lever * math.cos(pulled - towards)
    stiffness = (friction.mu_a * friction.mu_b) ** 2 * (along**2 + _moment_along(loop, towards - theta)) / s**3
    return TrailingPoint(towards, theta, pulled, float(np.hypot(*force)) * lever / stiffness)


def _moment_along(loop: CollectionLoop, direction: float) -> float:
    """The pressure's second moment (m^2) about its centre along a direction (rad) of the object's frame."""
    points, weights = loop.model.pressure.quadrature
    along = (points - loop.model.pressure.centre) @ (math.cos(direction), math.sin(direction))
    return float(weights @ along**2)


def checked_tolerance(tolerance: float) -> float:
    """Return an angle above 0 and below pi, or raise InvalidInput."""
    value = positive_number("tolerance", tolerance)
    if value >= math.pi:
        raise InvalidInput(f"tolerance {value} rad holds every heading: choose one below pi")
    return value


def checked_share(share: float) -> float:
    """Return a share above 0 and below 1, or raise InvalidInput."""
    value = positive_number("share left out", share)
    if value >= 1.0:
        raise InvalidInput(f"share left out is {value}: choose one above 0 and below 1; none at all is out of reach")
    return value
