"""Point friction: the offset limit ellipse of Ma & Rodriguez (2018), Eq. 1-2."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_number, positive_number
from cyclemap.errors import InvalidInput


@dataclass(frozen=True)
class EllipseFriction:
    """Friction of one support point whose limit curve is an ellipse off its centre.

    In the material's axes (m, n), turned by `phi` counter-clockwise from the surface's x axis, the dissipation
    per unit load and unit sliding distance is the support function of the limit ellipse
    (Ma & Rodriguez 2018, Eq. 2, as a maximum-dissipation law):

        h(v) = s + m0 v_m + n0 v_n,   s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2)

    and the traction coefficient is its gradient: mu_m = m0 + mu_a^2 v_m / s, mu_n = n0 + mu_b^2 v_n / s.

    Parameters
    ----------
    mu_a, mu_b : semi-axes of the ellipse, friction coefficients, positive.
    m0, n0 : its centre in the material's axes, friction coefficients.
    phi : angle of the material's m axis, rad.

    Raises
    ------
    InvalidInput : a value is not finite, an axis is not positive, or the centre lies so far out that some
        direction of sliding would not dissipate: (m0/mu_a)^2 + (n0/mu_b)^2 must be below one.

    >>> EllipseFriction(0.3, 0.2).dissipation([1.0, 0.0])
    array(0.3)
    """

    mu_a: float
    mu_b: float
    m0: float = 0.0
    n0: float = 0.0
    phi: float = 0.0

    def __post_init__(self) -> None:
        for name in ("mu_a", "mu_b"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        for name in ("m0", "n0", "phi"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name)))
        if math.hypot(self.m0 / self.mu_a, self.n0 / self.mu_b) >= 1.0:
            raise InvalidInput(
                f"the friction ellipse mu_a={self.mu_a}, mu_b={self.mu_b} with centre m0={self.m0}, n0={self.n0} "
                "does not contain zero, so some direction of sliding would gain energy: "
                "choose (m0/mu_a)^2 + (n0/mu_b)^2 < 1"
            )

    @classmethod
    def isotropic(cls, mu: float) -> "EllipseFriction":
        """Coulomb friction, the same coefficient `mu` in every direction."""
        return cls(mu, mu)

    def turned(self, angle: float) -> "EllipseFriction":
        """Return the same surface turned by `angle` (rad, counter-clockwise)."""
        return EllipseFriction(self.mu_a, self.mu_b, self.m0, self.n0, self.phi + angle)

    def dissipation(self, velocity: ArrayLike, frame: float = 0.0) -> NDArray[np.float64]:
        """Power lost per unit load: velocities (..., 2), m/s -> (...), m/s.

        `frame` (rad) is the angle of the frame in which the velocity is given, seen from the surface.
        """
        v_m, v_n = self._in_material_axes(velocity, frame)
        return np.asarray(np.hypot(self.mu_a * v_m, self.mu_b * v_n) + self.m0 * v_m + self.n0 * v_n)

    def traction(self, velocity: ArrayLike, frame: float = 0.0) -> NDArray[np.float64]:
        """Traction coefficients (..., 2) at sliding velocities (..., 2), both in the frame at angle `frame`.

        The force of the surface on the point is minus this, times the load. Raises InvalidInput at zero
        velocity, where friction is any point of the ellipse.
        """
        v_m, v_n = self._in_material_axes(velocity, frame)
        s = np.hypot(self.mu_a * v_m, self.mu_b * v_n)
        if np.any(s == 0.0):
            raise InvalidInput("traction needs a sliding velocity: a velocity is zero, where friction is not unique")
        t_m, t_n = self.m0 + self.mu_a**2 * v_m / s, self.n0 + self.mu_b**2 * v_n / s
        c, k = math.cos(self.phi - frame), math.sin(self.phi - frame)
        return np.stack([c * t_m - k * t_n, k * t_m + c * t_n], axis=-1)

    def _in_material_axes(self, velocity: ArrayLike, frame: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        v = np.asarray(velocity, dtype=float)
        if v.shape[-1:] != (2,) or not np.all(np.isfinite(v)):
            raise InvalidInput(f"velocities must be finite with shape (..., 2), not {v.shape}: {velocity!r}")
        c, k = math.cos(self.phi - frame), math.sin(self.phi - frame)
        return c * v[..., 0] + k * v[..., 1], -k * v[..., 0] + c * v[..., 1]
