"""The full cycle map of a loop, to hold a fingerprint's prediction against: its fixed points, where it locks in."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI
from cyclemap.checks import positive_number
from cyclemap.collection.fingerprint import Anisotropy, with_anisotropy
from cyclemap.collection.fingerprint_prediction import LockIn, PredictedDirection, Prediction
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import CircleMap, Orbit, fixed_points

# How far (rad) from the first order's place the full map's extremum is looked for.
_REACH = 0.6


@dataclass(frozen=True, eq=False)
class CheckedDirection:
    """A predicted direction beside the nearest one of its kind of the full map.

    full : that fixed point, None where the full map has none of the kind. miss : rad between the two; inf without.
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
    """The full map of a loop, its fixed points by angle, and every predicted direction beside what it has."""

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
    progress: Callable[[float], None] | None = None,
) -> PredictionCheck:
    """Compute the full map of a loop to `tolerance` (rad), a hundred cycles and more, and set it beside a prediction.

    The loop is one of the protocol whose fingerprint predicted, on the surface that was predicted. Raises InvalidInput
    where its friction has another anisotropy.

    >>> from cyclemap.collection.fingerprint import fingerprint
    >>> loop = CollectionLoop.mit(material="plywood")
    >>> prediction = Prediction(fingerprint(loop), Anisotropy.of(loop.material.friction))
    >>> stable = check_prediction(prediction, loop, tolerance=1e-3).directions[0]
    >>> round(math.degrees(stable.miss), 1), stable.within_error
    (3.8, True)
    """
    if not isinstance(prediction, Prediction) or not isinstance(loop, CollectionLoop):
        raise InvalidInput(f"a check needs a Prediction and a CollectionLoop, not {prediction!r} and {loop!r}")
    own = Anisotropy.of(loop.material.friction)
    if not np.allclose(own.seen_from(0.0), prediction.anisotropy.seen_from(0.0), rtol=1e-6, atol=1e-9):
        given, found = (
            f"offset {seen.offset:.4f} along {math.degrees(seen.offset_direction):.2f}° and ellipticity "
            f"{seen.ellipticity:.4f} along {math.degrees(seen.ellipse_direction):.2f}°"
            for seen in (prediction.anisotropy, own)
        )
        raise InvalidInput(
            f"the prediction is of {given}, but {loop.material.name} has {found}: predict for this loop's own friction"
        )
    full = loop.circle_map(tolerance=tolerance, progress=progress)
    points, checked = tuple(fixed_points(full)), []
    for direction in prediction.directions:
        away = {
            abs(math.remainder(float(orbit.points[0]) - direction.theta, TWO_PI)): orbit
            for orbit in points
            if orbit.stable == direction.stable
        }
        miss = min(away, default=math.inf)
        checked.append(CheckedDirection(direction, away.get(miss), miss))
    return PredictionCheck(full, points, tuple(checked))


def full_lock_in(loop: CollectionLoop, anisotropy: Anisotropy, near: LockIn, tolerance: float = 1e-6) -> LockIn:
    """Return where the full map begins to lock in, near a first-order prediction.

    The turn's extremum within 0.6 rad of near.theta is followed as the scale varies by a factor of two either
    way, until it meets a whole number of turns, to `tolerance` in the scale's relative value. Some 100 cycles.

    Raises ConvergenceError where it meets none there, or the extremum goes farther.
    """
    from scipy.optimize import brentq, minimize_scalar

    positive_number("scale of a lock-in", near.scale)
    isotropic = float(with_anisotropy(loop, anisotropy.scaled(0.0)).next_theta(0.0))
    whole = TWO_PI * round(isotropic / TWO_PI)
    sign = 1.0 if isotropic > whole else -1.0

    def nearest(scale: float) -> tuple[float, float]:
        surface = with_anisotropy(loop, anisotropy.scaled(scale))
        found = minimize_scalar(
            lambda theta: sign * (surface.cycle(theta).theta_next - theta - whole),
            bounds=(near.theta - _REACH, near.theta + _REACH),
            method="bounded",
            options={"xatol": 3e-4},
        )
        return float(found.fun), float(found.x)

    try:
        scale = float(brentq(lambda s: nearest(s)[0], 0.5 * near.scale, 2.0 * near.scale, rtol=tolerance))
    except ValueError as cause:
        raise ConvergenceError(
            f"no lock-in between {near.scale / 2:g} and {2 * near.scale:g} of it: {cause}"
        ) from cause
    theta = nearest(scale)[1]
    if abs(theta - near.theta) > 0.99 * _REACH:
        raise ConvergenceError(
            f"the turn's extremum goes farther than {_REACH:g} rad from {near.theta:g} rad: the first order does not "
            "tell where this surface locks in"
        )
    return LockIn(scale, theta % TWO_PI)
