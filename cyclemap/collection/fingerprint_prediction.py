"""What a fingerprint predicts of a surface: stable directions with their error, beside those of the
full map.
"""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_array, positive_number, require_kind
from cyclemap.collection.fingerprint import Fingerprint, TurnResponse
from cyclemap.collection.loop import CollectionLoop, SentByFields
from cyclemap.collection.loop_surfaces import (
    Anisotropy,
    floor_bow,
    floor_varies,
    with_anisotropy,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import CircleMap, Orbit, fixed_points, is_nondecreasing, rotation_number
from cyclemap.mechanics import EllipseFriction
from cyclemap.progress import Progress

# Error over first order, beyond which a first-order law is not to be trusted.
TRUSTED_RATIO = 0.5
# The hessian's asymmetry over its largest entry, beyond which differences did not find it: usual
# protocols have below 0.002, a rod without friction 0.03.
_KNOWN = 0.02
_ANGLES = np.arange(7200) * (TWO_PI / 7200)

LOCKS = "locks"
DRIFTS = "drifts"
UNDECIDED = "undecided"


@dataclass(frozen=True)
class LockIn:
    """Where lock-in begins as an anisotropy grows in proportion: a saddle-node.

    Attributes
    ----------
    scale : float
        Factor of the anisotropy from which there is a fixed point; inf where no factor gives
        one.
    theta : float
        Where it is, rad; nan where no factor gives one.
    """

    scale: float
    theta: float


def first_order_lock_in(response: TurnResponse, anisotropy: Anisotropy) -> LockIn:
    """Return where the first-order map begins to lock in, exactly.

    Its turn is Ω + scale·h(θ) with h of mean zero: it first meets a whole number of turns at the
    least or greatest h.
    """
    theta = stationary_angles(response, anisotropy)
    if not theta.size:
        return LockIn(math.inf, math.nan)
    first = response.first_order(anisotropy.seen_from(theta))
    low = int(np.argmin(first))
    high = int(np.argmax(first))
    ahead = response.turn % TWO_PI
    ways = (
        LockIn(float(-ahead / first[low]), float(theta[low])),
        LockIn(float((TWO_PI - ahead) / first[high]), float(theta[high])),
    )
    return min(ways, key=lambda lock_in: lock_in.scale)


def stationary_angles(response: TurnResponse, anisotropy: Anisotropy) -> Array:
    """Return angles (k,) in [0, 2π), sorted, among them all extrema of the first-order turn; none
    where it is constant.

    With z = exp(iθ) the turn is Re(p z + q z²), and its derivative vanishes where 2q z⁴ + p z³ - p̄
    z - 2q̄ = 0.
    """
    p, q = harmonics(response, anisotropy)
    largest = max(abs(p), abs(q))
    if largest == 0.0:
        return np.zeros(0)
    p = p / largest
    q = q / largest
    roots = np.roots([2.0 * q, p, 0.0, -p.conjugate(), -2.0 * q.conjugate()])
    # Roots off the unit circle are no extrema; an angle too many does no harm where the least turn
    # is sought.
    return np.sort(np.angle(roots[np.abs(roots) > 0.0]) % TWO_PI)


def harmonics(response: TurnResponse, anisotropy: Anisotropy) -> tuple[complex, complex]:
    """Return (p, q), rad: the first-order turn less Ω is Re(p exp(iθ) + q exp(2iθ))."""
    u_x, u_y, v_x, v_y = anisotropy.seen_from(0.0).tolist()
    g_x, g_y, k_x, k_y = response.gradient.tolist()
    return complex(g_x, g_y) * complex(u_x, -u_y), complex(k_x, k_y) * complex(v_x, -v_y)


def lock_in_boundary(
    response: TurnResponse, offset_direction: float, ellipse_direction: float, shares: ArrayLike
) -> Array:
    """Return points (..., 2) of (offset, ellipticity) on the lock-in boundary of the first-order
    map; inf where none.

    `shares` (...): angles in [0, π/2] of rays in that plane, 0 being offset alone. Directions in
    rad.
    """
    rays = finite_array("shares", shares)
    points = []
    for angle in rays.ravel().tolist():
        ray = Anisotropy(
            max(math.cos(angle), 0.0),
            offset_direction,
            max(math.sin(angle), 0.0),
            ellipse_direction,
        )
        scale = first_order_lock_in(response, ray).scale
        points.append([scale * size if size else 0.0 for size in (ray.offset, ray.ellipticity)])
    return np.array(points).reshape((*rays.shape, 2))


@dataclass(frozen=True, eq=False)
class PredictedDirection:
    """A fixed point of the first-order map.

    Attributes
    ----------
    orbit : Orbit
        The fixed point.
    error : float
        How far off it may be, rad; π where it may be anywhere.
    second_order : Orbit or None
        The fixed point of the second-order map next to it, if one of its kind lies within the
        error.
    """

    orbit: Orbit
    error: float
    second_order: Orbit | None

    @property
    def theta(self) -> float:
        """The direction, rad in [0, 2π)."""
        return float(self.orbit.points[0])

    @property
    def stable(self) -> bool:
        """Whether the loop locks into it."""
        return self.orbit.stable


@dataclass(frozen=True, eq=False)
class Prediction(SentByFields):
    """The cycle map of a surface to first order, from the fingerprint of the protocol and its
    anisotropy alone.

    Parameters
    ----------
    fingerprint : Fingerprint
        That of the protocol.
    anisotropy : Anisotropy
        That of the surface.

    Raises
    ------
    InvalidInput
        For a fingerprint or an anisotropy that is none.

    Notes
    -----
    The first-order map is off by `turn_error(θ)`: the second-order term there, and the
    fingerprint's margin for what the second order leaves. That is an estimate, not a bound: of
    the directions of random surfaces (offset up to 0.2, ellipticity up to 0.12) on four
    protocols 96 % lay within their errors, and every verdict given was right.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import Anisotropy, CollectionLoop, Prediction, fingerprint
    >>> found = fingerprint(CollectionLoop.mit())
    >>> prediction = Prediction(found, Anisotropy(0.02, 0.0, 0.02, 0.0))
    >>> prediction.verdict, round(math.degrees(prediction.mean_turn), 2)
    ('drifts', 7.49)
    """

    fingerprint: Fingerprint
    anisotropy: Anisotropy

    def __post_init__(self) -> None:
        require_kind("fingerprint", self.fingerprint, Fingerprint)
        require_kind("anisotropy", self.anisotropy, Anisotropy)

    def turn(self, theta: ArrayLike) -> Array:
        """Return the first-order turn f(θ) - θ, (...), rad."""
        response = self.fingerprint.cycle
        return response.turn + response.first_order(self.anisotropy.seen_from(theta))

    def second_order_turn(self, theta: ArrayLike) -> Array:
        """Return the turn to second order, (...), rad."""
        return self.turn(theta) + self._second_order(theta)

    def turn_error(self, theta: ArrayLike) -> Array:
        """Return how far off the first-order turn is estimated to be, (...), rad."""
        return np.abs(self._second_order(theta)) + self.fingerprint.margin(self.anisotropy)

    def _second_order(self, theta: ArrayLike) -> Array:
        return self.fingerprint.cycle.second_order(self.anisotropy.seen_from(theta))

    @cached_property
    def map(self) -> CircleMap:
        """The first-order map, with two harmonics: θ + Ω + Re(p exp(iθ) + q exp(2iθ))."""
        turn = self.fingerprint.cycle.turn
        p, q = harmonics(self.fingerprint.cycle, self.anisotropy)
        return CircleMap.with_scalar(
            lambda theta: theta + turn + (p * np.exp(1j * theta) + q * np.exp(2j * theta)).real,
            lambda theta: 1.0 - (p * np.exp(1j * theta) + 2.0 * q * np.exp(2j * theta)).imag,
            lambda theta: (
                theta + turn + (p * cmath.exp(1j * theta) + q * cmath.exp(2j * theta)).real
            ),
        )

    @cached_property
    def ratio(self) -> float:
        """Largest error of the turn over its largest first-order part;
        0 on an isotropic surface."""
        first = float(np.abs(self.turn(_ANGLES) - self.fingerprint.cycle.turn).max())
        return float(self.turn_error(_ANGLES).max()) / first if self._anisotropic else 0.0

    @property
    def second_order_found(self) -> bool:
        """Whether differences found the protocol's second order; where not, every error here is
        unknown too.
        """
        known = self.fingerprint
        return known.hessian_error <= _KNOWN * max(float(np.abs(known.cycle.hessian).max()), 1e-3)

    @property
    def trusted(self) -> bool:
        """Whether the anisotropy is small enough for a first-order law, and the second order was
        found.
        """
        return self.second_order_found and self.ratio <= TRUSTED_RATIO

    @cached_property
    def directions(self) -> tuple[PredictedDirection, ...]:
        """The fixed points of the first-order map, by angle; a saddle-node counts once. None on
        isotropic surfaces.
        """
        directions = []
        for orbit in fixed_points(self.map) if self._anisotropic else ():
            theta = float(orbit.points[0])
            error = max(self._reach(theta, 1.0), self._reach(theta, -1.0))
            nearest, away = _nearest(orbit, self.second_order_points)
            directions.append(PredictedDirection(orbit, error, nearest if away <= error else None))
        return tuple(directions)

    @cached_property
    def second_order_points(self) -> tuple[Orbit, ...]:
        """The fixed points of the second-order map, by angle; none on isotropic surfaces."""
        if not self._anisotropic:
            return ()
        return tuple(fixed_points(CircleMap(lambda theta: theta + self.second_order_turn(theta))))

    @property
    def stable_directions(self) -> tuple[PredictedDirection, ...]:
        """Those of the directions that the loop locks into."""
        return tuple(direction for direction in self.directions if direction.stable)

    @cached_property
    def verdict(self) -> str:
        """`locks` or `drifts` where every map within the error does, else `undecided`."""
        turn = self.turn(_ANGLES)
        error = self.turn_error(_ANGLES)
        wholes = TWO_PI * np.arange(
            np.floor(turn.min() / TWO_PI), np.ceil(turn.max() / TWO_PI) + 1.0
        )
        away = turn[:, None] - wholes
        if np.any(np.any(away > error[:, None], axis=0) & np.any(away < -error[:, None], axis=0)):
            return LOCKS
        return DRIFTS if np.all(np.abs(away) > error[:, None]) else UNDECIDED

    @cached_property
    def mean_turn(self) -> float | None:
        """Turn of a cycle on the long average, rad; None where the first-order map is folded."""
        return TWO_PI * rotation_number(self.map).value if is_nondecreasing(self.map) else None

    @cached_property
    def slowest(self) -> float:
        """Orientation (rad) at which the first-order turn is nearest to a whole number of turns; 0
        if all are equal.
        """
        return (
            float(_ANGLES[np.argmin(np.abs(shorter_way(self.turn(_ANGLES))))])
            if self._anisotropic
            else 0.0
        )

    @cached_property
    def lock_in(self) -> LockIn:
        """Where the first-order map begins to lock in as this anisotropy grows from nothing: its
        factor and place.
        """
        return first_order_lock_in(self.fingerprint.cycle, self.anisotropy)

    @cached_property
    def lock_in_range(self) -> tuple[float, float]:
        """Factors of the anisotropy between which lock-in is estimated to begin; inf where it may
        never.
        """
        from scipy.optimize import brentq

        scale = self.lock_in.scale
        if not 0.0 < scale < math.inf:
            return scale, scale
        low = float(brentq(self._least_turn, 0.0, scale, args=(-1.0,), xtol=1e-9))
        for above in scale * 1.1 ** np.arange(1.0, 16.0):
            if self._least_turn(above, 1.0) < 0.0:
                high = float(brentq(self._least_turn, scale, above, args=(1.0,), xtol=1e-9))
                return low, high
        return low, math.inf

    @property
    def _anisotropic(self) -> bool:
        return self.anisotropy.offset > 0.0 or self.anisotropy.ellipticity > 0.0

    def _least_turn(self, factor: float, sign: float) -> float:
        """The turn (rad, negative where it locks) nearest to lock-in at a factor, `sign` errors
        off.
        """
        scaled = Prediction(self.fingerprint, self.anisotropy.scaled(factor))
        isotropic = self.fingerprint.cycle.turn
        side = -math.copysign(1.0, float(self.turn(self.lock_in.theta)) - isotropic)
        turn = (side * isotropic) % TWO_PI + side * (scaled.turn(_ANGLES) - isotropic)
        return float(np.min(turn + sign * scaled.turn_error(_ANGLES)))

    def _reach(self, theta: float, sense: float) -> float:
        """How far from the fixed point `theta`, in one sense, a turn within the error may still be
        none; π at most.
        """
        reach = _ANGLES[: _ANGLES.size // 2 + 1]
        places = theta + sense * reach
        inside = self.turn_error(places) - np.abs(shorter_way(self.turn(places)))
        out = int(np.argmax(inside < 0.0))
        if out == 0:
            return 0.0 if inside[0] < 0.0 else math.pi
        before = inside[out - 1]
        after = inside[out]
        return float(reach[out - 1] + (reach[1] - reach[0]) * before / (before - after))


def _nearest(orbit: Orbit, others: Sequence[Orbit]) -> tuple[Orbit | None, float]:
    """The nearest of other fixed points of its kind, and how far that is, rad; None and inf without
    any.
    """
    same = [other for other in others if other.stable == orbit.stable]
    away = [abs(float(shorter_way(other.points[0] - orbit.points[0]))) for other in same]
    nearest = min(away, default=math.inf)
    return (same[away.index(nearest)] if away else None), nearest


def predict(fingerprint: Fingerprint, anisotropy: Anisotropy | EllipseFriction) -> Prediction:
    """Return what a fingerprint predicts of a surface of this anisotropy, or of this friction.

    Parameters
    ----------
    fingerprint : Fingerprint
        The fingerprint of the protocol.
    anisotropy : Anisotropy or EllipseFriction
        That of the surface, or its friction.

    Returns
    -------
    Prediction
        The cycle map to first order, and its errors.

    Raises
    ------
    InvalidInput
        For anything else, and for an anisotropy that no surface has
        (`Anisotropy.require_surface`).

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop, fingerprint, predict
    >>> loop = CollectionLoop.mit(material="plywood")
    >>> (direction,) = predict(fingerprint(loop), loop.material.friction).stable_directions
    >>> round(math.degrees(direction.theta), 1), round(math.degrees(direction.error), 1)
    (59.4, 21.1)
    """
    if not isinstance(fingerprint, Fingerprint):
        raise InvalidInput(
            f"a prediction needs a Fingerprint, such as fingerprint(loop), not {fingerprint!r}"
        )
    surface = Anisotropy.of(anisotropy) if isinstance(anisotropy, EllipseFriction) else anisotropy
    if not isinstance(surface, Anisotropy):
        raise InvalidInput(
            "a surface must be an Anisotropy or an EllipseFriction, such as "
            f"loop.material.friction, not {anisotropy!r}"
        )
    surface.require_surface()
    return Prediction(fingerprint, surface)


# How far (rad) from the first order's place the full map's extremum is looked for.
_REACH = 0.6


@dataclass(frozen=True, eq=False)
class CheckedDirection:
    """A predicted direction beside the nearest one of its kind of the full map.

    Attributes
    ----------
    predicted : PredictedDirection
        The direction.
    full : Orbit or None
        That fixed point, None where the full map has none of the kind.
    miss : float
        rad between the two; inf without.
    """

    predicted: PredictedDirection
    full: Orbit | None
    miss: float

    @property
    def within_error(self) -> bool:
        """Whether the full map's direction lies within the error that was stated."""
        return self.miss <= self.predicted.error


@dataclass(frozen=True, eq=False)
class PredictionCheck:
    """The full map of a loop beside what its fingerprint predicted.

    Attributes
    ----------
    map : CircleMap
        The full cycle map.
    fixed_points : tuple of Orbit
        Its fixed points, by angle.
    directions : tuple of CheckedDirection
        Every predicted direction beside what the full map has.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, check_prediction, fingerprint, predict
    >>> loop = CollectionLoop.mit(material="plywood")
    >>> prediction = predict(fingerprint(loop), loop.material.friction)
    >>> check = check_prediction(prediction, loop, tolerance=1e-3)
    >>> [round(math.degrees(orbit.points[0])) for orbit in check.stable_points]
    [63]
    """

    map: CircleMap
    fixed_points: tuple[Orbit, ...]
    directions: tuple[CheckedDirection, ...]

    @property
    def stable_points(self) -> tuple[Orbit, ...]:
        """The fixed points that the loop locks into."""
        return tuple(orbit for orbit in self.fixed_points if orbit.stable)


def check_prediction(
    prediction: Prediction,
    loop: CollectionLoop,
    tolerance: float = 1e-5,
    progress: Progress | None = None,
) -> PredictionCheck:
    """Compute the full map of a loop, a hundred cycles and more, and set it beside a prediction.

    Parameters
    ----------
    prediction : Prediction
        What was predicted.
    loop : CollectionLoop
        One of the protocol whose fingerprint predicted, on the surface that was predicted.
    tolerance : float, default 1e-5
        Error of the full map, rad.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    PredictionCheck
        The full map, its fixed points, and the predicted directions beside them.

    Raises
    ------
    InvalidInput
        Where its friction has another anisotropy, or its floor a bow.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import Anisotropy, CollectionLoop, Prediction, check_prediction
    >>> from cyclemap.collection import fingerprint
    >>> loop = CollectionLoop.mit(material="plywood")
    >>> prediction = Prediction(fingerprint(loop), Anisotropy.of(loop.material.friction))
    >>> stable = check_prediction(prediction, loop, tolerance=1e-3).directions[0]
    >>> round(math.degrees(stable.miss), 1), stable.within_error
    (3.8, True)
    """
    if not isinstance(prediction, Prediction) or not isinstance(loop, CollectionLoop):
        raise InvalidInput(
            f"a check needs a Prediction and a CollectionLoop, not {prediction!r} and {loop!r}"
        )
    own = Anisotropy.of(loop.material.friction)
    if floor_bow(loop):
        raise InvalidInput(
            "the prediction is of a floor without a bow, but the loop's has one of "
            f"{floor_bow(loop):g} mean pressures: set floor_bow=0, or ask its portrait"
        )
    if floor_varies(loop):
        raise InvalidInput(
            "the prediction is of a floor that is alike everywhere, but the loop's has a field: "
            "replace its footprint by one with field=None, or ask its portrait"
        )
    if not np.allclose(
        own.seen_from(0.0), prediction.anisotropy.seen_from(0.0), rtol=1e-6, atol=1e-9
    ):
        given, own_words = (
            f"offset {seen.offset:.4f} along {math.degrees(seen.offset_direction):.2f}° and "
            f"ellipticity {seen.ellipticity:.4f} along {math.degrees(seen.ellipse_direction):.2f}°"
            for seen in (prediction.anisotropy, own)
        )
        raise InvalidInput(
            f"the prediction is of {given}, but {loop.material.name} has {own_words}: predict for "
            "this loop's own friction"
        )
    full = loop.circle_map(tolerance=tolerance, progress=progress)
    points = tuple(fixed_points(full))
    checked = tuple(
        CheckedDirection(direction, *_nearest(direction.orbit, points))
        for direction in prediction.directions
    )
    return PredictionCheck(full, points, checked)


def full_lock_in(
    loop: CollectionLoop, anisotropy: Anisotropy, near: LockIn, tolerance: float = 1e-6
) -> LockIn:
    """Return where the full map begins to lock in, near a first-order prediction.

    The turn's extremum within 0.6 rad of near.theta is followed as the scale varies by a factor of
    two either way, until it meets a whole number of turns, to `tolerance` in the scale's relative
    value. Some 100 cycles.

    Raises ConvergenceError where it meets none there, or the extremum goes farther.
    """
    from scipy.optimize import brentq, minimize_scalar

    positive_number("scale of a lock-in", near.scale)
    isotropic = float(with_anisotropy(loop, anisotropy.scaled(0.0)).next_theta(0.0))
    whole = TWO_PI * round(isotropic / TWO_PI)
    sign = 1.0 if isotropic > whole else -1.0

    def nearest(scale: float) -> tuple[float, float]:
        surface = with_anisotropy(loop, anisotropy.scaled(scale))
        least = minimize_scalar(
            lambda theta: sign * (surface.cycle(theta).theta_next - theta - whole),
            bounds=(near.theta - _REACH, near.theta + _REACH),
            method="bounded",
            options={"xatol": 3e-4},
        )
        return float(least.fun), float(least.x)

    try:
        scale = float(
            brentq(lambda s: nearest(s)[0], 0.5 * near.scale, 2.0 * near.scale, rtol=tolerance)
        )
    except ValueError as cause:
        raise ConvergenceError(
            f"no lock-in between {near.scale / 2:g} and {2 * near.scale:g} of it: {cause}"
        ) from cause
    theta = nearest(scale)[1]
    if abs(theta - near.theta) > 0.99 * _REACH:
        raise ConvergenceError(
            f"the turn's extremum goes farther than {_REACH:g} rad from {near.theta:g} rad: the "
            "first order does not tell where this surface locks in"
        )
    return LockIn(scale, theta % TWO_PI)
