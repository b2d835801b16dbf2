"""The limit surface of a footprint: dissipation, friction wrench and their derivatives at any twist."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.engine.strokes import friction_values
from cyclemap.mechanics.footprint import Footprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.pressure_tables import pressure_tables


@dataclass(frozen=True)
class LimitSurface:
    """Friction of a whole footprint, in its own frame, per unit load.

    The dissipation D(V) is convex and homogeneous of degree one in the twist V = (vx, vy, omega) of the frame's
    origin; the friction wrench on the object is -grad D (maximum dissipation; Goyal, Ruina & Papadopoulos 1991).
    Exact footprints are accurate to 1e-10 relative where the outline is at least 1 % as thick as it is long; thinner
    ones, and those that lean, lose digits in proportion: to 1e-6 at 1e-4, the thinnest that there may be.

    >>> from cyclemap.mechanics import Ellipse, PatchFootprint
    >>> surface = LimitSurface(PatchFootprint(Ellipse(1.0, 1.0)), EllipseFriction.isotropic(0.3))
    >>> round(float(surface.dissipation([0.0, 0.0, 1.0])), 12)  # pure spin of a disc: 2/3 mu R
    0.2
    """

    footprint: Footprint
    friction: EllipseFriction

    def dissipation(self, twist: ArrayLike, frame: float = 0.0) -> NDArray[np.float64]:
        """Return D at twists (..., 3) (m/s, m/s, rad/s), in m/s; `frame` is the orientation of the object, rad."""
        return self._evaluate(twist, frame)[..., 0]

    def wrench(self, twist: ArrayLike, frame: float = 0.0) -> NDArray[np.float64]:
        """Return grad D, (..., 3): (fx, fy) and the torque (m) about the frame's origin that keep the object moving."""
        return self._evaluate(twist, frame)[..., 1:4]

    def hessian(self, twist: ArrayLike, frame: float = 0.0) -> NDArray[np.float64]:
        """Return the second derivatives of D, (..., 3, 3)."""
        values = self._evaluate(twist, frame)[..., 4:]
        return values.reshape(*values.shape[:-1], 3, 3)

    def _evaluate(self, twist: ArrayLike, frame: float) -> NDArray[np.float64]:
        twists = finite_array("twist", twist, last=3)
        size, law = self.footprint.extent, self.friction
        # Lengths in extents: (v, omega) -> (v, omega size), D unchanged, derivatives by omega times size.
        scale = np.array([1.0, 1.0, size])
        columns = (twists * scale).reshape(-1, 3)
        if np.any(np.all(columns == 0.0, axis=1)):
            raise InvalidInput("friction is not unique at rest: a twist is zero")
        c, s = math.cos(law.phi - frame), math.sin(law.phi - frame)
        matrix = (law.mu_a * c, -law.mu_b * s, law.mu_a * s, law.mu_b * c)
        values = friction_values(pressure_tables(self.footprint), matrix, columns)
        # The ellipse's centre (m0, n0) acts as one constant force at the centre of pressure.
        fx, fy = c * law.m0 - s * law.n0, s * law.m0 + c * law.n0
        x, y = np.divide(self.footprint.centre, size)
        constant = np.array((fx, fy, x * fy - y * fx))
        dissipation, wrench = values[:, 0] + columns @ constant, values[:, 1:4] + constant
        hessian = values[:, [4, 5, 7, 5, 6, 8, 7, 8, 9]] * np.outer(scale, scale).ravel()
        found = np.column_stack([dissipation, wrench * scale, hessian])
        return np.asarray(found.reshape(*twists.shape[:-1], 13))
