"""How far a surface is from isotropic and flat, and a loop on such a surface."""

import cmath
import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, non_negative_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, PressedFootprint, SurfaceShape
from cyclemap.written import DIRECTION

# One axis of friction 22 000 times the other: no surface is like that, and numbers beyond soon
# overflow.
MOST_ELLIPTICITY = 5.0
# The mean radius of the ellipses that are run: no turn depends on it.
MEAN = 0.25


@dataclass(frozen=True)
class Anisotropy:
    """The part of a friction ellipse that motion depends on; its mean radius sqrt(mu_a mu_b) drops
    out.

    Parameters
    ----------
    offset : float
        |(m0, n0)| / sqrt(mu_a mu_b), not negative.
    offset_direction : float
        Direction of R(φ)(m0, n0) in the surface's axes, rad.
    ellipticity : float
        log(mu_a / mu_b) / 2, not negative; (mu_a - mu_b)/(mu_a + mu_b) is its hyperbolic
        tangent.
    ellipse_direction : float
        Direction of the axis along which friction is greater, rad; that of a friction ellipse
        in [0, π).

    Raises
    ------
    InvalidInput
        For a value that is not finite, or a negative offset or ellipticity.

    Notes
    -----
    It may be larger than any surface's, since scales are sought along a ray: `require_surface`
    tells.

    Examples
    --------
    >>> from cyclemap import EllipseFriction
    >>> from cyclemap.collection import Anisotropy
    >>> seen = Anisotropy.of(EllipseFriction(0.2, 0.3, m0=0.05, phi=0.5))
    >>> round(seen.offset, 4), seen.offset_direction
    (0.2041, 0.5)
    >>> round(seen.ellipticity, 4), round(seen.ellipse_direction, 4)
    (0.2027, 2.0708)
    """

    offset: float
    offset_direction: float = field(metadata=DIRECTION)
    ellipticity: float
    ellipse_direction: float = field(metadata=DIRECTION)

    def __post_init__(self) -> None:
        for name in ("offset", "ellipticity"):
            object.__setattr__(self, name, non_negative_number(name, getattr(self, name)))
        for name in ("offset_direction", "ellipse_direction"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name)))

    @classmethod
    def of(cls, friction: EllipseFriction) -> "Anisotropy":
        """Return the anisotropy of a friction ellipse; InvalidInput for anything else."""
        if not isinstance(friction, EllipseFriction):
            raise InvalidInput(
                "friction must be an EllipseFriction, such as loop.material.friction, not "
                f"{friction!r}"
            )
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
        return cls(
            math.hypot(u_x, u_y), math.atan2(u_y, u_x), math.hypot(v_x, v_y), angle % math.pi
        )

    def friction(self, mean: float = 0.25) -> EllipseFriction:
        """Return the friction ellipse of mean radius sqrt(mu_a mu_b) = `mean`; InvalidInput as
        `require_surface`.
        """
        self.require_surface()
        centre = mean * cmath.rect(self.offset, self.offset_direction - self.ellipse_direction)
        stretch = math.exp(self.ellipticity)
        return EllipseFriction(
            mean * stretch, mean / stretch, centre.real, centre.imag, self.ellipse_direction
        )

    def require_surface(self) -> None:
        """Raise InvalidInput where the offset ends outside the friction ellipse, or the ellipticity
        is above 5.
        """
        if self.ellipticity > MOST_ELLIPTICITY:
            raise InvalidInput(
                f"ellipticity {self.ellipticity:g} is more than any surface has: it is "
                f"log(mu_a/mu_b)/2, about 0.04 for plywood; choose at most {MOST_ELLIPTICITY:g}"
            )
        angle = self.offset_direction - self.ellipse_direction
        stretch = math.exp(self.ellipticity)
        most = 1.0 / math.hypot(math.cos(angle) / stretch, math.sin(angle) * stretch)
        if self.offset >= most:
            raise InvalidInput(
                f"offset {self.offset:g} reaches out of the friction ellipse, so some direction of "
                f"sliding would gain energy: in this direction choose less than {most:.4g}"
            )

    def scaled(self, factor: float) -> "Anisotropy":
        """Return the anisotropy with offset and ellipticity `factor` times as large, 0 or more."""
        return replace(self, offset=factor * self.offset, ellipticity=factor * self.ellipticity)

    def seen_from(self, theta: ArrayLike) -> Array:
        """Return the anisotropy in the axes of an object at orientations (...), rad: (..., 4).

        offset (cos, sin)(offset_direction - θ), ellipticity (cos, sin)(2 (ellipse_direction - θ)):
        all that the turn of a cycle depends on. Raises InvalidInput for an orientation that is not
        finite.
        """
        angle = finite_array("theta", theta)
        offset = self.offset * np.exp(1j * (self.offset_direction - angle))
        ellipse = self.ellipticity * np.exp(2j * (self.ellipse_direction - angle))
        return np.stack([offset.real, offset.imag, ellipse.real, ellipse.imag], axis=-1)


ISOTROPIC = Anisotropy(0.0, 0.0, 0.0, 0.0)


def with_anisotropy(loop: CollectionLoop, anisotropy: Anisotropy) -> CollectionLoop:
    """Return the loop on a surface of this anisotropy and a usual mean friction."""
    return replace(
        loop, material=Material("surface of given anisotropy", anisotropy.friction(MEAN))
    )


def with_bow(loop: CollectionLoop, bow: float) -> CollectionLoop:
    """Return the loop on a floor of this bow along the world's x axis; support points have none,
    and stay.
    """
    footprint = loop.footprint
    if isinstance(footprint, PressedFootprint):
        return replace(
            loop, footprint=replace(footprint, floor=replace(footprint.floor, bow=bow, axis=0.0))
        )
    if bow == 0.0 or not can_bow(loop):
        return loop
    slider = loop.slider
    pressed = PressedFootprint(
        slider.outline, floor=SurfaceShape(bow=bow), centre=slider.centre_of_mass
    )
    return replace(loop, footprint=pressed)


def floor_bow(loop: CollectionLoop) -> float:
    """Return the bow of the floor under a loop, mean pressures at 50 mm."""
    return loop.footprint.floor.bow if isinstance(loop.footprint, PressedFootprint) else 0.0


def can_bow(loop: CollectionLoop) -> bool:
    """Return whether the pressure is that of an outline: flat, or one with shapes, not points or shares of
    the load.
    """
    footprint = loop.footprint
    return footprint is None or isinstance(footprint, PressedFootprint)
