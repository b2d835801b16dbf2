"""What happens beside a break: one-sided limits, and differences that never reach across."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.rounding import EPS, STENCIL

Function = Callable[[Array], Array]
Index = npt.NDArray[np.intp]

SIDE_STEP = 8.0 * EPS * np.pi  # how far beside a break its one-sided limits are read
JUMP = 1e-10  # radians: one-sided limits that differ by more are a jump, else a kink
SNAP = 1e-12  # radians: angles this near a break are that break
_CENTRED, _ONE_SIDED = np.arange(-2.0, 3.0), np.arange(0.0, 5.0)
_CENTRED_WEIGHTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
_ONE_SIDED_WEIGHTS = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
_DIFFERENCE_STEP = 1e-3
_AGREEING = 1e-8  # of 1 + |F'|: how far two differences may lie apart
_SHRINKINGS = 5  # of the step, each by four: rounding rules below a microradian


def distance_to_break(breaks: Array, theta: Array) -> Array:
    """How far along the circle the nearest break lies, radians; π where there is none."""
    if breaks.size == 0:
        return np.full(np.shape(theta), np.pi)
    base = theta - TWO_PI * np.floor(theta / TWO_PI)
    return np.asarray(np.abs(_nearest_break(breaks, base)[0] - base))


def _nearest_break(breaks: Array, base: Array) -> tuple[Array, Index]:
    """The copy of a break, from one turn below to one above, nearest to each angle in [0, 2π); its index."""
    around = np.concatenate([breaks[-1:] - TWO_PI, breaks, breaks[:1] + TWO_PI])
    pick = around.searchsorted(base).clip(1, breaks.size + 1)
    pick = pick - (base - around[pick - 1] <= around[pick] - base)
    return around[pick], (pick - 1) % breaks.size


def beside(function: Function, breaks: Array, side: int, climb: int) -> Array:
    """Values a few rounding units beside ``breaks`` (in [0, 2π)), always read inside that one turn.

    ``climb`` says how many turns the function climbs in one turn of θ: the degree for a lift, 0 for F'.
    """
    wraps = (side < 0) & (breaks < SIDE_STEP)
    points = np.where(wraps, breaks + TWO_PI, breaks) + side * SIDE_STEP
    return np.asarray(function(points), dtype=np.float64) - TWO_PI * climb * wraps


def one_sided_limit(function: Function, breaks: Array, theta: Any, side: int, climb: int) -> Array:
    """The function at ``theta``, and within ``SNAP`` of a break its limit there from below (-1) or above (1)."""
    angles = np.asarray(theta, dtype=np.float64)
    values = np.array(function(angles), dtype=np.float64)
    if breaks.size == 0:
        return values
    turns = np.floor(angles / TWO_PI)
    base = np.asarray(angles - TWO_PI * turns)
    nearest, index = _nearest_break(breaks, base)
    here = np.abs(base - nearest) <= SNAP
    if here.any():
        found = breaks[index[here]]
        turns = np.round((angles[here] - found) / TWO_PI)
        values[here] = beside(function, found, side, climb) + TWO_PI * climb * turns
    return values


def differences(function: Function, breaks: Array, theta: Array) -> tuple[Array, Array]:
    """Five-point differences on the circle, centred or leaning away from a break that is near, and their errors."""
    if breaks.size == 0:
        far = np.full(theta.shape, np.pi)
        return differences_between(function, theta, far, far)
    gaps = np.mod(breaks - theta[..., None], TWO_PI)
    above = np.min(np.where(gaps > 0.0, gaps, TWO_PI), axis=-1)
    below = np.min(np.mod(-gaps, TWO_PI), axis=-1)
    return differences_between(function, theta, below, above)


def differences_between(function: Function, theta: Array, below: Array, above: Array) -> tuple[Array, Array]:
    """Five-point differences that reach less than ``below`` under each angle and ``above`` over it, and their errors.

    Where a difference of a quarter of the step differs by more than rounding, the function has features as narrow as
    the step, and the step shrinks until the two agree. The error is what is left between them, and rounding.
    """
    step = np.minimum(_DIFFERENCE_STEP, (above + below) / 8.1)
    found = _five_points(function, theta, below, above, step)
    finer = _five_points(function, theta, below, above, step / 4.0)
    rough = np.abs(finer - found) > _AGREEING * (1.0 + np.abs(found))
    for _ in range(_SHRINKINGS):
        if not np.any(rough):
            break
        found, step = np.where(rough, finer, found), np.where(rough, step / 4.0, step)
        finer[rough] = _five_points(function, theta[rough], below[rough], above[rough], step[rough] / 4.0)
        rough &= np.abs(finer - found) > _AGREEING * (1.0 + np.abs(found))
    rounding = STENCIL * (TWO_PI + np.abs(theta) * (1.0 + np.abs(found)) + np.abs(function(theta))) / step
    return found, np.abs(finer - found) + rounding


def _five_points(function: Function, theta: Array, below: Array, above: Array, step: Array) -> Array:
    low, high = below < 2.0 * step, above < 2.0 * step
    lean = np.where(low, 1.0, np.where(high, -1.0, 0.0))[..., None]
    offsets = np.where(lean == 0.0, _CENTRED, lean * _ONE_SIDED)
    weights = np.where(lean == 0.0, _CENTRED_WEIGHTS, lean * _ONE_SIDED_WEIGHTS)
    values = function(theta[..., None] + step[..., None] * offsets)
    # The weights add up to zero: without their common part the values of a flat piece cancel exactly.
    return np.asarray(np.sum((values - values[..., :1]) * weights, axis=-1) / step)
