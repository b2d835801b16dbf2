"""The numbers that tell how a protocol's cycle answers a nearly isotropic and flat surface."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, finite_number, read_only
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.collection.loop_surfaces import (
    ISOTROPIC,
    MEAN,
    Anisotropy,
    can_bow,
    with_anisotropy,
    with_bow,
)
from cyclemap.errors import InvalidInput
from cyclemap.progress import Progress, unheard
from cyclemap.written import ANGLE, UNWRITTEN

_FRICTION = ("mu_a", "mu_b", "m0", "n0", "phi")
_BOW = ("floor_bow_x", "floor_bow_y")
_LEAST_BOW = 1e-12
# Step of the differences that give second derivatives, in offset and ellipticity, and the accuracy
# (rad) of the cycles: their gradients are then good to about 1e-8.
STEP = 0.002
_ACCURACY = 1e-10
# Usual surfaces: their offset and ellipticity, and how many of them are run.
_OFFSET = 0.12
_ELLIPTICITY = 0.06
_SURFACES = 16


@dataclass(frozen=True, eq=False)
class TurnResponse:
    """A turn G(z) about the isotropic surface, z the anisotropy as the object sees it
    (`Anisotropy.seen_from`).

    Parameters
    ----------
    turn : float
        G(0), rad.
    gradient : array_like, shape (4,)
        First derivatives of G at 0, rad.
    hessian : array_like, shape (4, 4)
        Second derivatives of G at 0, rad.
    bow : array_like, shape (2,), optional
        Derivative by b cos 2χ and b sin 2χ at θ = 0, b and χ bow and axis of the floor's shape.

    Attributes
    ----------
    offset_amplitude : float
        A₁, rad of turn a unit of offset.
    offset_phase : float
        δ₁, the object's orientation, seen from the offset, at which the offset turns it most,
        rad in (-π, π].
    ellipse_amplitude : float
        A₂, rad of turn a unit of ellipticity.
    ellipse_phase : float
        δ₂, twice such an orientation, seen from the axis of greater friction, rad in (-π, π].
    bow_amplitude : float
        A₃, rad of turn a unit of bow.
    bow_phase : float
        δ₃, twice such an orientation, seen from the axis of the bow, rad in (-π, π].

    Raises
    ------
    InvalidInput
        For arrays of other shapes, and for what is not finite.

    Notes
    -----
    G(z) = turn + gradient·z + z·hessian·z / 2 up to third order. At orientation θ on a surface of
    offset u along ψ and ellipticity v along φ, gradient·z is

        u·offset_amplitude·cos(θ - ψ - offset_phase)
            + v·ellipse_amplitude·cos(2(θ - φ) - ellipse_phase);

    a floor of bow b (mean pressures at 50 mm) along the axis χ adds b·bow_amplitude·cos(2(θ - χ) -
    bow_phase).

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import TurnResponse
    >>> both = TurnResponse(0.1, [2.0, 0.0, 0.0, 1.0], np.zeros((4, 4)))
    >>> both.offset_amplitude, both.offset_phase
    (2.0, 0.0)
    >>> both.ellipse_amplitude, round(both.ellipse_phase, 6)
    (1.0, -1.570796)
    """

    turn: float = field(metadata=ANGLE)
    gradient: Array = field(metadata=UNWRITTEN)
    hessian: Array = field(metadata=UNWRITTEN)
    bow: Array = field(default_factory=lambda: np.zeros(2), metadata=UNWRITTEN)
    offset_amplitude: float = field(init=False, metadata=ANGLE)
    offset_phase: float = field(init=False, metadata=ANGLE)
    ellipse_amplitude: float = field(init=False, metadata=ANGLE)
    ellipse_phase: float = field(init=False, metadata=ANGLE)
    bow_amplitude: float = field(init=False, metadata=ANGLE)
    bow_phase: float = field(init=False, metadata=ANGLE)

    def __post_init__(self) -> None:
        object.__setattr__(self, "turn", finite_number("turn", self.turn))
        for name, shape in (("gradient", (4,)), ("hessian", (4, 4)), ("bow", (2,))):
            array = read_only(finite_array(name, getattr(self, name)))
            if array.shape != shape:
                raise InvalidInput(f"{name} of a turn has shape {array.shape}: it must be {shape}")
            object.__setattr__(self, name, array)
        slopes = (("offset", self.gradient[:2]), ("ellipse", self.gradient[2:]), ("bow", self.bow))
        for name, (x, y) in slopes:
            object.__setattr__(self, f"{name}_amplitude", math.hypot(x, y))
            object.__setattr__(self, f"{name}_phase", -math.atan2(y, x) + 0.0)

    def first_order(self, seen: ArrayLike) -> Array:
        """Return the first-order part of the turn, (...), rad, of finite anisotropies (..., 4)."""
        return finite_array("seen", seen, last=4) @ self.gradient

    def second_order(self, seen: ArrayLike) -> Array:
        """Return the second-order part of the turn, (...), rad, of finite anisotropies (..., 4)."""
        z = finite_array("seen", seen, last=4)
        return np.asarray(0.5 * np.sum((z @ self.hessian) * z, axis=-1))


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """How the cycle of a protocol answers a surface that is nearly isotropic.

    Attributes
    ----------
    push, drag : TurnResponse
        The two parts, both over the orientation before the push.
    hessian_error : float
        Largest asymmetry of the cycle's hessian as found, rad: what the differences that gave
        it are good for.
    remainder : float
        What the second order leaves of the turn of usual surfaces, root mean square, over
        (offset·A₁ + ellipticity·A₂)², 1/rad; it does not vanish with the anisotropy, since
        second derivatives jump where contact phases come and go.
    bow_remainder : float
        What the first order leaves of the turn on a floor of bow 1, at most, rad; 0 for support
        points, which have no bow.

    Notes
    -----
    f(θ) = θ + Ω + offset·A₁ cos(θ - ψ - δ₁) + ellipticity·A₂ cos(2(θ - φ) - δ₂) + bow·A₃
    cos(2(θ - χ) - δ₃), with an error of second order, offset along ψ, greater friction along φ
    (`Anisotropy`), the floor bowed along χ. The protocol alone tells Ω, A₁, δ₁, A₂, δ₂, A₃, δ₃:
    `cycle.turn`, `cycle.offset_amplitude`, `cycle.offset_phase`, `cycle.ellipse_amplitude`,
    `cycle.ellipse_phase`, `cycle.bow_amplitude`, `cycle.bow_phase`.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop, fingerprint
    >>> found = fingerprint(CollectionLoop.mit())
    >>> round(math.degrees(found.push.turn), 2), round(math.degrees(found.drag.turn), 2)
    (74.52, -66.52)
    """

    push: TurnResponse
    drag: TurnResponse
    hessian_error: float
    remainder: float = field(metadata={"name": "remainder_per_rad"})
    bow_remainder: float = field(default=0.0, metadata=ANGLE)

    @cached_property
    def cycle(self) -> TurnResponse:
        """The response of the whole cycle: push plus drag."""
        push = self.push
        drag = self.drag
        bow = push.bow + drag.bow
        return TurnResponse(
            push.turn + drag.turn, push.gradient + drag.gradient, push.hessian + drag.hessian, bow
        )

    def margin(self, anisotropy: Anisotropy) -> float:
        """Return what the second order may leave of the turn on a surface, rad: twice the
        remainder, an estimate.

        It grows with the square of the amplitude offset·A₁ + ellipticity·A₂, and with the cube on
        surfaces that are more anisotropic than usual.
        """
        first = self.cycle.offset_amplitude
        second = self.cycle.ellipse_amplitude
        size = anisotropy.offset * first + anisotropy.ellipticity * second
        usual = _OFFSET * first + _ELLIPTICITY * second
        return 2.0 * self.remainder * size**2 * max(1.0, size / usual) if size else 0.0


def fingerprint(loop: CollectionLoop, progress: Progress | None = None) -> Fingerprint:
    """Return the fingerprint of a loop's protocol.

    Parameters
    ----------
    loop : CollectionLoop
        The protocol; its material's friction, and the floor's bow, play no part.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    Fingerprint
        How push, drag and cycle turn on surfaces that are nearly isotropic.

    Raises
    ------
    InvalidInput
        Where `loop` is no CollectionLoop, or the way back has way-points, fixed in the world.

    Notes
    -----
    The gradient comes from the sensitivities of two isotropic cycles, the hessian from central
    differences of twelve nearly isotropic ones, the remainder from sixteen cycles on usual
    surfaces.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop, fingerprint
    >>> found = fingerprint(CollectionLoop.mit()).cycle
    >>> round(math.degrees(found.turn), 3)
    8.002
    >>> round(found.offset_amplitude, 3), round(found.ellipse_amplitude, 3)
    (2.047, 1.769)
    """
    if require_loop(loop).reset.way_points:
        raise InvalidInput(
            f"way-points of the reset, {loop.reset.way_points}, are fixed in the world: a cycle "
            "then depends on the orientation on any surface and has no fingerprint; leave "
            "way_points_mm out"
        )
    report = progress or unheard
    loop = with_bow(replace(loop, accuracy=min(loop.accuracy, _ACCURACY)), 0.0)
    isotropic = with_anisotropy(loop, ISOTROPIC).cycle(0.0)
    gradients = _gradients(loop, np.zeros(4))
    report(0.1)
    differences = np.zeros((2, 4, 4))
    for axis in range(4):
        ends = [_gradients(loop, sign * STEP * np.eye(4)[axis]) for sign in (1.0, -1.0)]
        differences[:, axis] = (ends[0] - ends[1]) / (2.0 * STEP)
        report(0.3 + 0.2 * axis)
    hessians = 0.5 * (differences + differences.transpose(0, 2, 1))
    whole = differences.sum(axis=0)
    turns = isotropic.push_turn, isotropic.drag_turn
    bends = can_bow(loop)
    bows = np.zeros((2, 2))
    if bends:
        # A bow of nothing, so that the footprint is one that has shapes.
        bows = _turns_by(with_anisotropy(with_bow(loop, _LEAST_BOW), ISOTROPIC), _BOW)
    push, drag = (
        TurnResponse(*derivatives)
        for derivatives in zip(turns, gradients, hessians, bows, strict=True)
    )
    response = Fingerprint(push, drag, float(np.abs(whole - whole.T).max()), 0.0)
    return replace(
        response,
        remainder=_remainder(loop, response.cycle),
        bow_remainder=_bow_remainder(loop, response.cycle) if bends else 0.0,
    )


def _turns_by(loop: CollectionLoop, parameters: tuple[str, ...]) -> Array:
    """Derivatives (2, k) of the turns of push and drag at θ = 0 by parameters."""
    sensitivity = loop.sensitivity(0.0, parameters)
    return sensitivity.jacobian[
        [sensitivity.outputs.index(stroke) for stroke in ("push_turn", "drag_turn")]
    ]


def _bow_remainder(loop: CollectionLoop, response: TurnResponse) -> float:
    """What the first order leaves of the turn on a floor of bow 1, rad,
    at most over half a turn."""
    bowed = with_anisotropy(with_bow(loop, 1.0), ISOTROPIC)
    theta = math.pi * np.arange(_SURFACES) / _SURFACES
    first = response.bow_amplitude * np.cos(2.0 * theta - response.bow_phase)
    return float(np.abs(bowed.next_theta(theta) - theta - response.turn - first).max())


def _remainder(loop: CollectionLoop, response: TurnResponse) -> float:
    """Root mean square of what the second order leaves of usual surfaces' turns, over the first
    order squared.
    """
    # Both directions are spread evenly, their pairs too: a golden-section lattice of the torus.
    first = np.arange(_SURFACES) / _SURFACES
    second = np.arange(_SURFACES) * 0.5 * (math.sqrt(5.0) - 1.0)
    left = []
    for psi, phi in zip(TWO_PI * first, math.pi * second, strict=True):
        surface = Anisotropy(_OFFSET, float(psi), _ELLIPTICITY, float(phi))
        seen = surface.seen_from(0.0)
        expected = response.turn + response.first_order(seen) + response.second_order(seen)
        left.append(with_anisotropy(loop, surface).cycle(0.0).theta_next - float(expected))
    size = _OFFSET * response.offset_amplitude + _ELLIPTICITY * response.ellipse_amplitude
    return float(np.sqrt(np.mean(np.square(left)))) / size**2 if size else 0.0


def _gradients(loop: CollectionLoop, seen: Array) -> Array:
    """Gradients (2, 4) of the turns of push and drag, where offset or ellipticity is zero."""
    surface = Anisotropy.of_components(seen)
    if surface.ellipticity > 0.0:
        by_offset, stretch, turning = _derivatives(loop, surface)
        across = turning / (2.0 * surface.ellipticity)
        c, s = seen[2:] / surface.ellipticity
        by_ellipse = np.stack([c * stretch - s * across, s * stretch + c * across], axis=-1)
    else:
        # Without an ellipse its direction is free: two directions give both components.
        by_offset, along, _ = _derivatives(loop, replace(surface, ellipse_direction=0.0))
        oblique = _derivatives(loop, replace(surface, ellipse_direction=0.25 * math.pi))[1]
        by_ellipse = np.stack([along, oblique], axis=-1)
    return np.hstack([by_offset, by_ellipse])


def _derivatives(loop: CollectionLoop, surface: Anisotropy) -> tuple[Array, Array, Array]:
    """Derivatives of the turns of push and drag at θ = 0: by offset (2, 2), by ellipticity (2,) and
    by φ (2,).
    """
    law = surface.friction(MEAN)
    rows = _turns_by(with_anisotropy(loop, surface), _FRICTION)
    by_a, by_b, by_m, by_n, by_phi = rows.T
    c = math.cos(law.phi)
    s = math.sin(law.phi)
    by_offset = MEAN * np.stack([c * by_m - s * by_n, s * by_m + c * by_n], axis=-1)
    return by_offset, law.mu_a * by_a - law.mu_b * by_b, by_phi
