"""One state of a surface: its cycle map, its pushes over θ0, and how these move with the friction's offset."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.maps import CircleMap

# Radians: accuracy of the cycle maps, far below the noise of a cycle.
MAP_TOLERANCE = 1e-4
# Of the integration of pushes and drags, relative: a hundredth of that.
_ACCURACY = 1e-6
# Orientations at which derivatives are computed: they only scale noise.
_SLOPES = 36
# Orientations, golden-ratio steps round the circle, at which interpolated pushes are compared with the mechanics.
_CHECKED, _GOLDEN = 12, 0.6180339887498949
_OUTPUTS = ("push_turn", "push_dx", "push_dy", "theta_next")
_OFFSET = ("m0", "n0")


@dataclass(frozen=True, eq=False)
class SurfaceState:
    """The cycle and the push on a surface as it is at one cycle.

    cycle : its number. map : the cycle map, rad. theta : (k,) rad in [0, 2π), orientations of computed pushes.
    motion : (k, 3), their Δθ (rad), Δx and Δy (m, initial object frame). motion_error : (3,), the largest difference
    of interpolated pushes from the mechanics at 12 other orientations. slopes : (36, 4, 2), derivatives of Δθ, Δx, Δy
    and the next θ0 by the centre (m0, n0) of the limit ellipse, evenly round the circle.
    mean_friction : sqrt(mu_a mu_b).
    """

    cycle: float
    map: CircleMap
    theta: Array
    motion: Array
    motion_error: Array
    slopes: Array
    mean_friction: float

    def push_motion(self, theta: ArrayLike) -> Array:
        """(..., 3) of pushes from orientations (...), rad: the periodic cubic spline through the computed ones."""
        return _periodic_spline(self.theta, self.motion)(_base(theta))

    def by_offset(self, theta: ArrayLike) -> Array:
        """(..., 4, 2), the derivatives of ``slopes`` at orientations (...), rad, linear between neighbours."""
        places = 2 * np.pi * np.arange(_SLOPES + 1) / _SLOPES
        rows = np.concatenate([self.slopes, self.slopes[:1]]).reshape(_SLOPES + 1, -1)
        angles = _base(theta)
        found = np.stack([np.interp(angles, places, row) for row in rows.T], axis=-1)
        return np.asarray(found.reshape(*angles.shape, *self.slopes.shape[1:]))


def surface_state(loop: CollectionLoop, cycle: float = 0.0, tolerance: float = MAP_TOLERANCE) -> SurfaceState:
    """Compute the state of ``loop``'s surface at ``cycle``; pushes are computed where the map had to be sampled.

    Time: about 2 s. Raises what the mechanics raise where they have no answer.

    >>> state = surface_state(CollectionLoop.mit("isotropic"), tolerance=1e-3)
    >>> np.degrees(state.push_motion([0.0, 1.0])[:, 0]).round(3)
    array([74.52, 74.52])
    """
    frozen = replace(worn_loop(loop, cycle), accuracy=_ACCURACY)
    cycle_map = frozen.circle_map(tolerance)
    assert cycle_map.pieces is not None
    theta = cycle_map.pieces.knots[:-1]
    motion = _motion(frozen, theta)
    others = 2 * np.pi * np.mod(_GOLDEN * np.arange(1, _CHECKED + 1), 1.0)
    error = np.max(np.abs(_periodic_spline(theta, motion)(others) - _motion(frozen, others)), axis=0)
    law = frozen.material.friction
    mean, slopes = math.sqrt(law.mu_a * law.mu_b), _slopes(frozen)
    return SurfaceState(
        cycle, cycle_map, read_only(theta), read_only(motion), read_only(error), read_only(slopes), mean
    )


def _base(theta: ArrayLike) -> Array:
    return np.asarray(np.mod(np.asarray(theta, dtype=float), 2 * np.pi))


def _motion(loop: CollectionLoop, theta: Array) -> Array:
    runs = loop.cycles(theta)
    return np.column_stack([runs.push_turn, runs.push_displacement])


def _slopes(loop: CollectionLoop) -> Array:
    rows = []
    for theta in (2 * np.pi * np.arange(_SLOPES) / _SLOPES).tolist():
        found = loop.sensitivity(theta, _OFFSET)
        rows.append([[found.by(parameter, output) for parameter in _OFFSET] for output in _OUTPUTS])
    return np.array(rows)


def _periodic_spline(theta: Array, values: Array) -> Callable[[Array], Array]:
    from scipy.interpolate import CubicSpline

    whole = np.append(theta, theta[0] + 2 * np.pi)
    return CubicSpline(whole, np.vstack([values, values[:1]]), bc_type="periodic")  # type: ignore[no-any-return]
