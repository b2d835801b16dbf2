"""The limit surface of a footprint: dissipation, friction wrench and their derivatives at any twist."""

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.footprint import Footprint, PatchFootprint, PointFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.patch_integrals import far_ratio, patch_expressions
from cyclemap.mechanics.pressure_family import PressureFamily, rim_share, warp


@dataclass(frozen=True)
class LimitSurface:
    """Friction of a whole footprint, in its own frame, per unit load.

    The dissipation D(V) is convex and homogeneous of degree one in the twist V = (vx, vy, omega) of the frame's
    origin; the friction wrench on the object is -grad D (maximum dissipation; Goyal, Ruina & Papadopoulos 1991).
    Exact footprints are accurate to 1e-10 relative everywhere.

    >>> from cyclemap.mechanics import Ellipse
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
        size = self.footprint.extent
        # Lengths in extents: (v, omega) -> (v, omega size), D unchanged, derivatives by omega times size.
        scale = np.array([1.0, 1.0, size])
        columns = (twists * scale).reshape(-1, 3).T
        if np.any(np.all(columns == 0.0, axis=0)):
            raise InvalidInput("friction is not unique at rest: a twist is zero")
        law = self.friction
        pressure = rim_share(self.footprint), *warp(self.footprint)
        parameters = np.array([law.mu_a, law.mu_b, law.m0, law.n0, law.phi, *pressure, frame])
        family = PressureFamily.of(normalised(self.footprint))
        (near, far), limit = _compiled(family), far_ratio(family)
        with np.errstate(all="ignore"):
            ratio = np.array(far(columns, parameters)).reshape(14, -1)[13]
        values = np.empty((13, columns.shape[1]))
        for function, chosen in ((near, ratio <= limit), (far, ~(ratio <= limit))):
            if chosen.any():
                values[:, chosen] = np.array(function(columns[:, chosen], parameters)).reshape(14, -1)[:13]
        factor = np.concatenate([[1.0], scale, np.outer(scale, scale).ravel()])
        return np.asarray((values.T * factor).reshape(*twists.shape[:-1], 13))


@lru_cache(maxsize=64)
def normalised(footprint: Footprint) -> Footprint:
    """Return the footprint with lengths in units of its extent."""
    size = footprint.extent
    if isinstance(footprint, PointFootprint):
        positions = np.asarray(footprint.positions) / size
        return PointFootprint(tuple(map(tuple, positions.tolist())), footprint.weights)
    gradient = (footprint.gradient[0] * size, footprint.gradient[1] * size)
    return PatchFootprint(footprint.outline.scaled(1.0 / size), gradient, footprint.rim_share, footprint.warp)


@lru_cache(maxsize=64)
def _compiled(pressure: PressureFamily) -> tuple[ca.Function, ca.Function]:
    """CasADi functions (twist, parameters) -> (D, gradient, Hessian, far), near and far."""
    twist, parameters = ca.SX.sym("twist", 3), ca.SX.sym("parameters", 9)
    functions = []
    for near in (True, False):
        patch = patch_expressions(pressure, twist, parameters[:8], parameters[8], near)
        values = ca.vertcat(patch.dissipation, patch.force, patch.torque, ca.vec(patch.hessian), patch.far)
        functions.append(ca.Function("patch", [twist, parameters], [patch.substituted(values)]))
    return functions[0], functions[1]
