"""The unknowns of a surface under a pushed object, chosen so that nothing special happens where friction is isotropic.

The limit ellipse is fixed by its mean radius sqrt(mu_a mu_b), by the vector log(mu_a/mu_b) (cos 2 phi, sin 2 phi),
and by its centre in the world's axes over the mean radius. All are smooth functions of the ellipse, a circle included,
where the angle phi has no meaning. Quasi-static motion does not depend on the mean radius, only forces do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.parameter_space import Parameter, ParameterSpace
from cyclemap.mechanics import EllipseFriction, Pusher
from cyclemap.suggestions import unknown_name

Array = NDArray[np.float64]

FRICTION_NAMES = ("mu_a", "mu_b", "m0", "n0", "phi")
HITCH_NAMES = ("hitch_x", "hitch_y")

# An ellipse rounder than this (log of the axis ratio) counts as this round: phi then stays defined, and no motion or
# force changes by more than a millionth.
ROUNDEST = 1e-6

SURFACE = ParameterSpace(
    (
        Parameter("friction_scale", "log of the mean friction coefficient", "1", -5.0, 1.5, math.log(0.25), 0.5),
        Parameter("ellipticity_x", "log axis ratio of the friction ellipse, part along x", "1", -1.5, 1.5, 0.0, 0.2),
        Parameter("ellipticity_y", "log axis ratio of the friction ellipse, part at 45 deg", "1", -1.5, 1.5, 0.0, 0.2),
        Parameter(
            "offset_x", "centre of the friction ellipse along x, over its mean radius", "1", -0.95, 0.95, 0.0, 0.1
        ),
        Parameter(
            "offset_y", "centre of the friction ellipse along y, over its mean radius", "1", -0.95, 0.95, 0.0, 0.1
        ),
        Parameter(
            "pusher_friction", "friction coefficient of rod and object", "1", 0.0, 1.5, 0.2, 0.08, Pusher().friction
        ),
        Parameter("rim_share", "share of the weight that rests on the object's rim", "1", 0.0, 1.0, 0.3, 0.2, 0.0),
        Parameter("hitch_scale", "effective over nominal lever of the ring", "1", 0.1, 2.0, 1.0, 0.2),
        Parameter(
            "pin_friction_radius", "lever of the ring's friction torque over its force", "m", 0.0, 0.03, 2e-3, 1e-3, 0.0
        ),
        Parameter("hitch_turn", "angle from the ring's nominal lever to the effective one", "rad", -1.0, 1.0, 0.0, 0.1),
        Parameter(
            "saddle_a", "saddle of the pressure along the object's axes, share of the largest", "1", -1, 1, 0, 0.2
        ),
        Parameter("saddle_b", "saddle of the pressure along its diagonals, share of the largest", "1", -1, 1, 0, 0.2),
    )
)


@dataclass(frozen=True)
class SurfaceParameters:
    """Values of the unknowns of a surface, rod and ring; `SURFACE` describes each.

    friction_scale : log sqrt(mu_a mu_b). ellipticity_x, ellipticity_y : log(mu_a/mu_b) (cos 2 phi, sin 2 phi).
    offset_x, offset_y : R(phi)(m0, n0) / sqrt(mu_a mu_b), world frame. pusher_friction : coefficient of rod on object.
    rim_share : 0 to 1. saddle_a, saddle_b : of `underside.warp_of`. pin_friction_radius : m. hitch_scale, hitch_turn :
    the effective hitch is the nominal one times the scale, turned by the angle (rad).

    Raises InvalidInput for a value that is not finite or beyond its bounds.

    >>> surface = SurfaceParameters.from_friction(EllipseFriction(0.3, 0.2, phi=0.5))
    >>> round(surface.to_friction().mu_a, 12), round(surface.to_friction().phi, 12)
    (0.3, 0.5)
    """

    friction_scale: float = math.log(0.25)
    ellipticity_x: float = 0.0
    ellipticity_y: float = 0.0
    offset_x: float = 0.0
    offset_y: float = 0.0
    pusher_friction: float = Pusher().friction
    rim_share: float = 0.0
    hitch_scale: float = 1.0
    pin_friction_radius: float = 0.0
    hitch_turn: float = 0.0
    saddle_a: float = 0.0
    saddle_b: float = 0.0

    def __post_init__(self) -> None:
        for name in SURFACE.names:
            value, bounds = finite_number(name, getattr(self, name)), SURFACE[name]
            object.__setattr__(self, name, value)
            if not bounds.lower <= value <= bounds.upper:
                raise InvalidInput(f"{name} is {value}: it must lie between {bounds.lower} and {bounds.upper}")

    @classmethod
    def from_values(cls, values: Mapping[str, float]) -> SurfaceParameters:
        """Return the surface of values by name; other names are left alone, missing ones take their nominal value."""
        return cls(**{field.name: values[field.name] for field in fields(cls) if field.name in values})

    @classmethod
    def from_friction(cls, friction: EllipseFriction, **others: float) -> SurfaceParameters:
        """Return the surface of a friction ellipse, with `others` (pusher_friction, ...) as given."""
        for name in others:
            if name not in SURFACE.names[5:]:
                raise unknown_name("parameter besides friction", name, SURFACE.names[5:])
        mean, ratio = math.sqrt(friction.mu_a * friction.mu_b), math.log(friction.mu_a / friction.mu_b)
        c, k = math.cos(friction.phi), math.sin(friction.phi)
        return cls(
            math.log(mean),
            ratio * math.cos(2.0 * friction.phi),
            ratio * math.sin(2.0 * friction.phi),
            (c * friction.m0 - k * friction.n0) / mean,
            (k * friction.m0 + c * friction.n0) / mean,
            **others,
        )

    def values(self) -> dict[str, float]:
        """Return the values by name."""
        return {name: float(getattr(self, name)) for name in SURFACE.names}

    def to_friction(self) -> EllipseFriction:
        """Return the friction ellipse, mu_a >= mu_b, phi within (-pi/2, pi/2].

        Raises InvalidInput where the offset leaves the ellipse, so that some direction of sliding would gain energy.
        """
        ratio, phi, mean = *self._ellipse(), math.exp(self.friction_scale)
        c, k = math.cos(phi), math.sin(phi)
        m0, n0 = c * self.offset_x + k * self.offset_y, -k * self.offset_x + c * self.offset_y
        return EllipseFriction(mean * math.exp(ratio / 2.0), mean * math.exp(-ratio / 2.0), mean * m0, mean * n0, phi)

    def hitch(self, nominal: tuple[float, float]) -> tuple[float, float]:
        """Return the effective place of the ring (m, object frame) from the nominal one."""
        c, k = self.hitch_scale * math.cos(self.hitch_turn), self.hitch_scale * math.sin(self.hitch_turn)
        return c * nominal[0] - k * nominal[1], k * nominal[0] + c * nominal[1]

    def pusher(self, radius: float = Pusher().radius) -> Pusher:
        """Return the rod of a radius (m) with this friction."""
        return Pusher(radius, self.pusher_friction)

    def friction_jacobian(self) -> Array:
        """Return d FRICTION_NAMES / d (friction_scale, ellipticity_x, _y, offset_x, _y), (5, 5).

        The row of phi grows without bound towards a circle. What depends smoothly on the ellipse has a finite product
        with it, since turning a circle changes nothing; `chain` forms that product with errors below 1e-6.
        """
        ratio, phi = self._ellipse()
        law, mean = self.to_friction(), math.exp(self.friction_scale)
        double, across = (
            np.array((math.cos(2 * phi), math.sin(2 * phi))),
            np.array((-math.sin(2 * phi), math.cos(2 * phi))),
        )
        c, k = math.cos(phi), math.sin(phi)
        jacobian = np.zeros((5, 5))
        jacobian[:4, 0] = law.mu_a, law.mu_b, law.m0, law.n0
        jacobian[0, 1:3], jacobian[1, 1:3] = 0.5 * law.mu_a * double, -0.5 * law.mu_b * double
        jacobian[4, 1:3] = across / (2.0 * ratio)
        jacobian[2, 1:3], jacobian[3, 1:3] = law.n0 * jacobian[4, 1:3], -law.m0 * jacobian[4, 1:3]
        jacobian[2:4, 3:5] = mean * np.array(((c, k), (-k, c)))
        return jacobian

    def chain(
        self,
        jacobian: Array,
        names: tuple[str, ...],
        parameters: tuple[str, ...] = SURFACE.names,
        hitch: tuple[float, float] | None = None,
    ) -> Array:
        """Turn derivatives by the mechanics' parameters into derivatives by these: (..., j) -> (..., k).

        `names` (j) are those of the columns: of FRICTION_NAMES, HITCH_NAMES (m), or of SURFACE itself, which pass
        through and add up. `parameters` (k) are wanted. `hitch` (m) is the nominal one, needed for HITCH_NAMES.
        Parameters that no column tells of have derivative zero. Raises InvalidInput for an unknown name.
        """
        columns = np.asarray(jacobian, dtype=float)
        if columns.shape[-1:] != (len(names),):
            raise InvalidInput(
                f"the jacobian has shape {columns.shape}: its last axis must match the {len(names)} names"
            )
        table = self._chain_table(hitch)
        for name in names:
            if name not in table:
                raise unknown_name("parameter of the mechanics", name, table)
        rows = np.array([table[name] for name in names]).reshape(len(names), len(SURFACE))
        wanted = [_index(name) for name in parameters]
        return np.asarray(columns @ rows[:, wanted])

    def _chain_table(self, hitch: tuple[float, float] | None) -> dict[str, Array]:
        """The derivative (k,) of each of the mechanics' parameters by SURFACE."""
        unit = np.eye(len(SURFACE))
        table = dict(zip(SURFACE.names, unit, strict=True))
        for name, row in zip(FRICTION_NAMES, self.friction_jacobian(), strict=True):
            table[name] = np.concatenate([row, np.zeros(len(SURFACE) - 5)])
        if hitch is not None:
            x, y = self.hitch(hitch)
            by_scale, by_turn = unit[_index("hitch_scale")], unit[_index("hitch_turn")]
            table["hitch_x"] = x / self.hitch_scale * by_scale - y * by_turn
            table["hitch_y"] = y / self.hitch_scale * by_scale + x * by_turn
        return table

    def _ellipse(self) -> tuple[float, float]:
        """Return log(mu_a/mu_b), never quite zero, and phi."""
        ratio = math.hypot(self.ellipticity_x, self.ellipticity_y)
        return max(ratio, ROUNDEST), 0.5 * math.atan2(self.ellipticity_y, self.ellipticity_x)


def _index(name: str) -> int:
    if name not in SURFACE.names:
        raise unknown_name("parameter", name, SURFACE.names)
    return SURFACE.names.index(name)
