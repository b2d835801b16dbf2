"""How much anisotropy it takes to lock in: exactly for the first-order map, and for the full map to compare with."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, positive_number
from cyclemap.collection.anisotropy import Anisotropy
from cyclemap.collection.fingerprint import TurnResponse, with_anisotropy
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError

Array = NDArray[np.float64]

FULL_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class LockIn:
    """Where lock-in begins as an anisotropy grows in proportion: a saddle-node at orientation `theta`, rad.

    scale : factor of the anisotropy from which there is a fixed point; inf where no factor gives one (theta nan).
    """

    scale: float
    theta: float


def first_order_lock_in(response: TurnResponse, anisotropy: Anisotropy) -> LockIn:
    """Return where the first-order map begins to lock in, exactly.

    Its turn is Ω + scale·h(θ) with h of mean zero: it first meets a whole number of turns at the least or greatest h.
    For one harmonic that is |Ω| = scale·offset·A₁, Ω taken between -π and π.

    >>> one = TurnResponse(0.1, [2.0, 0.0, 0.0, 0.0], np.zeros((4, 4)))
    >>> round(first_order_lock_in(one, Anisotropy(1.0, 0.0, 0.0, 0.0)).scale, 12)
    0.05
    """
    theta = stationary_angles(response, anisotropy)
    if not theta.size:
        return LockIn(math.inf, math.nan)
    part = response.first_order(anisotropy.seen_from(theta))
    low, high = int(np.argmin(part)), int(np.argmax(part))
    ahead = response.turn % FULL_TURN
    found = (
        LockIn(float(-ahead / part[low]), float(theta[low])),
        LockIn(float((FULL_TURN - ahead) / part[high]), float(theta[high])),
    )
    return min(found, key=lambda lock_in: lock_in.scale)


def stationary_angles(response: TurnResponse, anisotropy: Anisotropy) -> Array:
    """Return angles (k,) in [0, 2π), sorted, among them all extrema of the first-order turn; none where it is constant.

    With z = exp(iθ) the turn is Re(p z + q z²), and its derivative vanishes where 2q z⁴ + p z³ - p̄ z - 2q̄ = 0.
    """
    p, q = harmonics(response, anisotropy)
    largest = max(abs(p), abs(q))
    if largest == 0.0:
        return np.zeros(0)
    p, q = p / largest, q / largest
    roots = np.roots([2.0 * q, p, 0.0, -p.conjugate(), -2.0 * q.conjugate()])
    # Roots off the unit circle are no extrema; an angle too many does no harm where the least turn is sought.
    return np.sort(np.angle(roots[np.abs(roots) > 0.0]) % FULL_TURN)


def harmonics(response: TurnResponse, anisotropy: Anisotropy) -> tuple[complex, complex]:
    """Return (p, q), rad: the first-order turn less Ω is Re(p exp(iθ) + q exp(2iθ))."""
    u_x, u_y, v_x, v_y = anisotropy.seen_from(0.0).tolist()
    g_x, g_y, k_x, k_y = response.gradient.tolist()
    return complex(g_x, g_y) * complex(u_x, -u_y), complex(k_x, k_y) * complex(v_x, -v_y)


def lock_in_boundary(
    response: TurnResponse, offset_direction: float, ellipse_direction: float, shares: ArrayLike
) -> Array:
    """Return points (..., 2) of (offset, ellipticity) on the lock-in boundary of the first-order map; inf where none.

    `shares` (...): angles in [0, π/2] of rays in that plane, 0 being offset alone. Directions in rad.
    """
    rays = finite_array("shares", shares)
    points = []
    for angle in rays.ravel().tolist():
        ray = Anisotropy(max(math.cos(angle), 0.0), offset_direction, max(math.sin(angle), 0.0), ellipse_direction)
        scale = first_order_lock_in(response, ray).scale
        points.append([scale * part if part else 0.0 for part in (ray.offset, ray.ellipticity)])
    return np.array(points).reshape((*rays.shape, 2))


def full_lock_in(
    loop: CollectionLoop, anisotropy: Anisotropy, near: LockIn, reach: float = 0.6, tolerance: float = 1e-6
) -> LockIn:
    """Return where the full map begins to lock in, near a first-order prediction.

    The turn's extremum within `reach` (rad) of near.theta is followed as the scale varies by a factor of two either
    way, until it meets a whole number of turns, to `tolerance` in the scale's relative value. Some 100 cycles.

    Raises ConvergenceError where it meets none there, or the extremum leaves the reach.
    """
    from scipy.optimize import brentq, minimize_scalar

    positive_number("scale of a lock-in", near.scale)
    isotropic = float(with_anisotropy(loop, anisotropy.scaled(0.0)).next_theta(0.0))
    whole = FULL_TURN * round(isotropic / FULL_TURN)
    sign = 1.0 if isotropic > whole else -1.0

    def nearest(scale: float) -> tuple[float, float]:
        surface = with_anisotropy(loop, anisotropy.scaled(scale))
        ends = near.theta - reach, near.theta + reach
        found = minimize_scalar(
            lambda theta: sign * (surface.cycle(theta).theta_next - theta - whole),
            bounds=ends,
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
    if abs(theta - near.theta) > 0.99 * reach:
        raise ConvergenceError(
            f"the extremum left the reach of {reach:g} rad about {near.theta:g}: give a larger reach"
        )
    return LockIn(scale, theta % FULL_TURN)
