"""Surfaces as a loop meets them: how far one is from isotropic and flat, and the loop on another
one, or on one that wears.
"""

import cmath
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, non_negative_number, whole_number
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, DriftingMap
from cyclemap.mechanics import (
    DragBack,
    EllipseFriction,
    Material,
    PatchFootprint,
    PressedFootprint,
    Pusher,
    SurfaceShape,
)
from cyclemap.mechanics.plate_footprint import known_plate
from cyclemap.written import DIRECTION

# Radians: the blend between computed cycles stays this near the map of each cycle.
BLEND_TOLERANCE = 1e-3
# Radians: accuracy of the maps that are blended.
MAP_TOLERANCE = 1e-4
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
        # Neither a product nor a quotient, which may leave the floats.
        mean = math.sqrt(friction.mu_a) * math.sqrt(friction.mu_b)
        vector = complex(friction.m0, friction.n0) / mean
        signed = 0.5 * (math.log(friction.mu_a) - math.log(friction.mu_b))
        axis = friction.phi if signed >= 0.0 else friction.phi + 0.5 * math.pi
        vector *= cmath.exp(1j * friction.phi)
        return cls(abs(vector), cmath.phase(vector), abs(signed), axis % math.pi)

    @classmethod
    def of_components(cls, components: ArrayLike) -> "Anisotropy":
        """Return the anisotropy of the four numbers that `seen_from(0)` gives."""
        u_x, u_y, v_x, v_y = finite_array("components", components, last=4, ndim=1).tolist()
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
    """Return the loop on a floor of this bow along the world's x axis, everywhere alike; support
    points have none, and stay.
    """
    footprint = loop.footprint
    if isinstance(footprint, PressedFootprint):
        floor = replace(footprint.floor, bow=bow, axis=0.0)
        return replace(loop, footprint=replace(footprint, floor=floor, field=None))
    if bow == 0.0 or not can_bow(loop):
        return loop
    slider = loop.slider
    outline, centre = slider.outline, slider.centre_of_mass
    if isinstance(footprint, PatchFootprint):
        outline, centre = footprint.outline, footprint.centre
    pressed = PressedFootprint(outline, floor=SurfaceShape(bow=bow), centre=centre)
    return replace(loop, footprint=pressed)


def floor_bow(loop: CollectionLoop) -> float:
    """Return the bow of the floor under a loop, mean pressures at 50 mm."""
    return loop.footprint.floor.bow if isinstance(loop.footprint, PressedFootprint) else 0.0


def floor_varies(loop: CollectionLoop) -> bool:
    """Return whether the floor's shape is another one at another place."""
    return isinstance(loop.footprint, PressedFootprint) and loop.footprint.field is not None


def with_even_floor(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop on a floor that has at every place the shape that it has at the target."""
    footprint = loop.footprint
    if not isinstance(footprint, PressedFootprint):
        return loop
    return replace(loop, footprint=replace(footprint, field=None))


def can_bow(loop: CollectionLoop) -> bool:
    """Return whether the pressure is that of an outline: flat, or one with shapes, not points or
    shares of the load.
    """
    footprint = loop.footprint
    if isinstance(footprint, PatchFootprint):
        return footprint.even_share == 1.0
    return footprint is None or isinstance(footprint, PressedFootprint)


def isotropic_twin(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop on a surface whose limit curve is the centred circle as large as its limit
    ellipse, of a floor without bow and field.

    Parameters
    ----------
    loop : CollectionLoop
        The loop to take the preferred direction from.

    Returns
    -------
    CollectionLoop
        The same protocol on friction that is alike in every direction.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, isotropic_twin
    >>> round(isotropic_twin(CollectionLoop.mit()).material.friction.mu_a, 4)
    0.2443
    """
    law = require_loop(loop).material.friction
    friction = EllipseFriction.isotropic(math.sqrt(law.mu_a * law.mu_b))
    name = f"{loop.material.name}, made isotropic"
    material = Material(name, friction, f"the mean coefficient of {loop.material.name}")
    return replace(with_bow(loop, 0.0), material=material)


def on_material(loop: CollectionLoop, material: Material) -> CollectionLoop:
    """Return the loop on another material, with what it brings along: `FoundWith` and pressure.

    Parameters
    ----------
    loop : CollectionLoop
        The loop; what it has from its own material gives way.
    material : Material
        The other material, such as a sample of its own one's posterior.

    Returns
    -------
    CollectionLoop
        The same protocol on the other surface.

    Raises
    ------
    InvalidInput
        For a loop or a material that is none.

    Notes
    -----
    What was set otherwise, as the friction of another rod, stays.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from cyclemap import CollectionLoop, load_material
    >>> from cyclemap.mechanics import FoundWith
    >>> from cyclemap.collection import on_material
    >>> found = FoundWith(pusher_friction=0.2)
    >>> slate = replace(load_material("plywood"), name="slate", found_with=found)
    >>> on_material(CollectionLoop.mit("plywood"), slate).pusher.friction
    0.2
    """
    bare = replace(
        require_loop(loop),
        pusher=replace(loop.pusher, friction=Pusher().friction),
        reset=replace(loop.reset, pin_friction_radius=DragBack().pin_friction_radius),
        footprint=None,
    )
    before = bare.with_material(loop.material)
    after = bare.with_material(material)
    brought = {
        name: getattr(after, name)
        for name in ("pusher", "reset", "footprint")
        if _alike(getattr(before, name), getattr(loop, name))
    }
    return replace(loop, material=material, **brought)


def _alike(first: object, second: object) -> bool:
    """Whether parts of a loop are the same, shapes but for the rounding of an object's weight."""
    if isinstance(first, PressedFootprint) and isinstance(second, PressedFootprint):
        return first.outline == second.outline and first.is_near(second)
    return first == second


def worn_loop(loop: CollectionLoop, cycles: float) -> CollectionLoop:
    """Return the loop on its surface as it is after a number of cycles, from there on unchanging.

    Parameters
    ----------
    loop : CollectionLoop
        The loop; where its surface does not wear, it is returned as it is.
    cycles : float
        How many cycles were made on the surface, 0 or more.

    Returns
    -------
    CollectionLoop
        The loop on the worn surface.

    Raises
    ------
    InvalidInput
        For a loop that is none, and cycles that are negative.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, worn_loop
    >>> loop = CollectionLoop.mit()
    >>> worn_loop(loop, 1000.0) == loop
    True
    """
    material = require_loop(loop).material
    if material.wear is None:
        return loop
    plates = material.plates
    known = known_plate(material, loop.slider)
    # A plate's built-in shape stays where the floor wears flat.
    if known is not None and known not in plates:
        plates = (*plates, known)
    worn = replace(
        material,
        plates=plates,
        friction=material.friction_after(cycles),
        floor=material.floor_after(cycles),
        wear=None,
        posterior=None,
    )
    return on_material(loop, worn)


def drifting_map(
    loop: CollectionLoop,
    cycles: int,
    tolerance: float = BLEND_TOLERANCE,
    progress: Callable[[int], None] | None = None,
) -> DriftingMap:
    """Return the cycle map as the surface wears, over cycles 0 ... cycles - 1.

    Parameters
    ----------
    loop : CollectionLoop
        The loop, on a material that wears.
    cycles : int
        How many cycles.
    tolerance : float, optional
        Error of the blend between the maps that are computed, rad.
    progress : callable or None, optional
        Called with the number of maps computed so far.

    Returns
    -------
    DriftingMap
        The maps, and how they are blended.

    Raises
    ------
    InvalidInput
        For a loop that is none, and where the material does not wear.

    Examples
    --------
    >>> import cyclemap as cm
    >>> wear = cm.mechanics.Wear(cm.EllipseFriction.isotropic(0.2), cycles=10.0)
    >>> slate = cm.Material("slate", cm.EllipseFriction.isotropic(0.25), wear=wear)
    >>> drifting = cm.collection.drifting_map(cm.CollectionLoop.mit(slate), cycles=10)
    >>> drifting.max_error < 1e-3
    True
    """
    wear = require_loop(loop).material.wear
    if wear is None:
        raise InvalidInput(
            f"{loop.material.name} does not wear: its file has no table [worn]; use its "
            "circle_map()"
        )
    count = whole_number("cycles", cycles, least=1)
    numbered = itertools.count(1)
    # The way is blended, then gone through at the pace of the course: kinks of the course cost no
    # maps.
    first = wear.share(0.0)
    last = wear.share(count - 1.0)
    even = replace(loop, material=replace(loop.material, wear=replace(wear, cycles=1.0, course=())))

    def at(share: float) -> CircleMap:
        made = worn_loop(even, share).circle_map(MAP_TOLERANCE)
        if progress is not None:
            progress(next(numbered))
        return made

    steps = count if last > first else 1
    blend = DriftingMap.of_family(at, np.linspace(first, last, steps), steps, tolerance)
    shares = first + (last - first) * blend.cycles / max(steps - 1, 1)
    course = [(cycle, gone) for cycle, gone in wear.course if 0.0 < cycle < count - 1.0]
    bend_cycles, bend_shares = np.array([(0.0, first), *course, (count - 1.0, last)]).T
    at_bends = (bend_shares - first) / max(last - first, 1e-300) * (steps - 1)
    knots = dict(zip(bend_cycles.tolist(), map(blend.at, at_bends.tolist()), strict=True))
    between = np.interp(shares, bend_shares, bend_cycles)
    for cycle, share, worn in zip(between.tolist(), shares, blend.maps, strict=True):
        if share not in bend_shares:
            knots[cycle] = worn
    order = sorted(knots)
    return DriftingMap(np.array(order), tuple(knots[n] for n in order), blend.max_error)
