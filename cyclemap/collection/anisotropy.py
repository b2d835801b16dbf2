"""How far a surface is from isotropic: the offset of its limit ellipse, a vector, and its ellipticity, a tensor."""

import cmath
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, finite_number, non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction

Array = NDArray[np.float64]

# One axis of friction 22 000 times the other: no surface is like that, and numbers beyond soon overflow.
MOST_ELLIPTICITY = 5.0


@dataclass(frozen=True)
class Anisotropy:
    """The part of a friction ellipse that motion depends on; its mean radius sqrt(mu_a mu_b) drops out.

    offset : |(m0, n0)| / sqrt(mu_a mu_b). offset_direction : rad, of R(φ)(m0, n0) in the surface's axes.
    ellipticity : log(mu_a / mu_b) / 2, here never negative; (mu_a - mu_b)/(mu_a + mu_b) is its hyperbolic tangent.
    ellipse_direction : rad in [0, π), of the axis along which friction is greater.

    Other means of mu_a and mu_b in the offset, and (mu_a - mu_b)/(mu_a + mu_b) as the ellipticity, differ from these
    by terms of third order in the anisotropy. These are additive under exchange and scaling of the axes.

    It may be larger than any surface's, for the first-order law is linear in it and scales may be sought along a ray:
    `require_surface` tells. Raises InvalidInput for a value that is not finite, or a negative offset or ellipticity.

    >>> seen = Anisotropy.of(EllipseFriction(0.2, 0.3, m0=0.05, phi=0.5))
    >>> round(seen.offset, 4), seen.offset_direction, round(seen.ellipticity, 4), round(seen.ellipse_direction, 4)
    (0.2041, 0.5, 0.2027, 2.0708)
    """

    offset: float
    offset_direction: float
    ellipticity: float
    ellipse_direction: float

    def __post_init__(self) -> None:
        for name in ("offset", "ellipticity"):
            object.__setattr__(self, name, non_negative_number(name, getattr(self, name)))
        for name in ("offset_direction", "ellipse_direction"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name)))

    @classmethod
    def of(cls, friction: EllipseFriction) -> "Anisotropy":
        """Return the anisotropy of a friction ellipse; InvalidInput for anything else."""
        if not isinstance(friction, EllipseFriction):
            raise InvalidInput(f"friction must be an EllipseFriction, such as loop.material.friction, not {friction!r}")
        vector = complex(friction.m0, friction.n0) / math.sqrt(friction.mu_a * friction.mu_b)
        signed = 0.5 * math.log(friction.mu_a / friction.mu_b)
        axis = friction.phi if signed >= 0.0 else friction.phi + 0.5 * math.pi
        vector *= cmath.exp(1j * friction.phi)
        return cls(abs(vector), cmath.phase(vector), abs(signed), axis % math.pi)

    @classmethod
    def of_components(cls, components: ArrayLike) -> "Anisotropy":
        """Return the anisotropy of the four numbers that `seen_from(0)` gives."""
        u_x, u_y, v_x, v_y = finite_array("components", components, last=4).tolist()
        angle = 0.5 * math.atan2(v_y, v_x)
        return cls(math.hypot(u_x, u_y), math.atan2(u_y, u_x), math.hypot(v_x, v_y), angle % math.pi)

    def friction(self, mean: float = 0.25) -> EllipseFriction:
        """Return the friction ellipse of this anisotropy whose mean radius sqrt(mu_a mu_b) is `mean`.

        Raises InvalidInput where there is none: see `require_surface`.
        """
        self.require_surface()
        centre = mean * cmath.rect(self.offset, self.offset_direction - self.ellipse_direction)
        stretch = math.exp(self.ellipticity)
        return EllipseFriction(mean * stretch, mean / stretch, centre.real, centre.imag, self.ellipse_direction)

    def require_surface(self) -> None:
        """Raise InvalidInput where no surface has this anisotropy.

        A friction ellipse contains zero, so the offset ends inside it; the ellipticity is at most 5.
        """
        if self.ellipticity > MOST_ELLIPTICITY:
            raise InvalidInput(
                f"ellipticity {self.ellipticity:g} is more than any surface has: it is log(mu_a/mu_b)/2, "
                f"about 0.04 for plywood; choose at most {MOST_ELLIPTICITY:g}"
            )
        angle, stretch = self.offset_direction - self.ellipse_direction, math.exp(self.ellipticity)
        most = 1.0 / math.hypot(math.cos(angle) / stretch, math.sin(angle) * stretch)
        if self.offset >= most:
            raise InvalidInput(
                f"offset {self.offset:g} reaches out of the friction ellipse, so some direction of sliding would gain "
                f"energy: in this direction choose less than {most:.4g}"
            )

    def scaled(self, factor: float) -> "Anisotropy":
        """Return the anisotropy with offset and ellipticity `factor` times as large, 0 or more."""
        return replace(self, offset=factor * self.offset, ellipticity=factor * self.ellipticity)

    def seen_from(self, theta: ArrayLike) -> Array:
        """Return the anisotropy in the axes of an object at orientations (...), rad: (..., 4).

        The numbers are offset (cos, sin)(offset_direction - θ), ellipticity (cos, sin)(2 (ellipse_direction - θ)): all
        that the turn of a cycle depends on, because turning surface and object together turns the motion alone. Raises
        InvalidInput for an orientation that is not finite.
        """
        angle = finite_array("theta", theta)
        first, second = self.offset_direction - angle, 2.0 * (self.ellipse_direction - angle)
        u, v = self.offset, self.ellipticity
        return np.stack([u * np.cos(first), u * np.sin(first), v * np.cos(second), v * np.sin(second)], axis=-1)
