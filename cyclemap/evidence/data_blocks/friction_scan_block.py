"""Friction scans as data: the rod's force while it carries the object along without turning it, by direction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Values
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.identify import Progress, identify
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters

if TYPE_CHECKING:
    import pandas

ELLIPSE = SURFACE.names[:5]
SCAN_KIND = "scan force (N)"
SCAN_FIELDS = ("direction", "force_along", "force_across")
# An ellipse off its centre has five numbers, a direction gives two: fewer groups cannot tell their own scatter.
FEWEST_GROUPS = 4
# Directions (rad) as near as this are one.
_SAME_DIRECTION = 1e-6
# Below this log axis ratio the series has all digits, the quotient has not.
_ROUND = 1e-2


def friction_scan_block(
    scans: pandas.DataFrame | Mapping[str, ArrayLike], weight: float, name: str = "friction scans"
) -> FunctionBlock:
    """Return friction scans as a block of data.

    scans : columns `direction` (rad, of the motion in the world), `force_along` and `force_across` (N, of the rod on
    the object, the second to the left of the motion), as `PushTable.scans` has them, or arrays by these names.
    weight : N, of the object.

    Carried in translation all points of the object slide alike, however the pressure is spread, and the force is the
    weight times the traction of one point (Ma & Rodriguez 2018, Eq. 2). Rows are along then across for each scan;
    scans in one direction are one group, so that what a direction's repeats have in common is not taken for evidence.
    With fewer than four directions each row stands for itself: so few groups cannot tell their scatter.

    Raises InvalidInput for columns that are missing or hold what is no number (NaN: leave such scans out).

    >>> scans = {"direction": [0.0, 1.0], "force_along": [2.0, 2.0], "force_across": [0.0, 0.0]}
    >>> residual, _ = friction_scan_block(scans, 8.0).residuals(SurfaceParameters(math.log(0.25)).values())
    >>> bool(np.allclose(residual, 0.0, atol=1e-5))
    True
    """
    direction, along, across = _columns(scans)
    load, measured = positive_number("weight", weight), np.stack([along, across], axis=-1).ravel()

    def function(values: Values) -> tuple[Array, Array]:
        force, jacobian = _predicted(values, direction, load)
        return force - measured, jacobian

    return FunctionBlock(name, ELLIPSE, function, _row_groups(direction), np.full(len(measured), SCAN_KIND))


def friction_ellipse_from_scans(
    scans: pandas.DataFrame | Mapping[str, ArrayLike],
    weight: float,
    *,
    level: float = 0.95,
    folds: int = 0,
    noise: float | None = None,
    student: float | None = None,
    progress: Progress | None = None,
) -> Identification:
    """Identify the friction ellipse from friction scans alone; arguments as in `friction_scan_block` and `identify`.

    noise : N, of a scan's force component, if it is known. Intervals are by covariance: the law is nearly linear. Over
    200 seeded sets of 4 to 72 directions, twice each, intervals of 95 % held the truth in 90 to 99 %, also where the
    repeats of a direction share most of their error. Scans in fewer than three directions leave the ellipse open: the
    estimates then say that they are not identifiable (this needs repeats, or `noise`; else there is nothing to tell
    the noise from, and ConvergenceError is raised).

    >>> from cyclemap.mechanics import EllipseFriction
    >>> direction = np.linspace(0.0, 6.0, 12)
    >>> way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    >>> force = 8.0 * EllipseFriction(0.3, 0.2, m0=0.01, phi=0.4).traction(way)
    >>> along, across = np.sum(force * way, axis=1), force[:, 1] * way[:, 0] - force[:, 0] * way[:, 1]
    >>> scans = {"direction": direction, "force_along": along, "force_across": across}
    >>> friction = friction_ellipse_from_scans(scans, 8.0).friction()
    >>> round(friction.mu_a, 6), round(friction.m0, 6), round(friction.phi, 6)
    (0.3, 0.01, 0.4)
    """
    block = friction_scan_block(scans, weight)
    known = None if noise is None else {SCAN_KIND: noise}
    return identify(
        [block],
        ELLIPSE,
        starts=4,
        level=level,
        folds=folds,
        noise=known,
        student=student,
        progress=progress,
    )


def _columns(scans: Any) -> tuple[Array, Array, Array]:
    """Directions (rad) and forces along and across (N), (n,) each."""
    missing = [name for name in SCAN_FIELDS if name not in scans]
    if missing:
        raise InvalidInput(f"friction scans need {', '.join(SCAN_FIELDS)}: {', '.join(missing)} is missing")
    columns = [np.asarray(scans[name], dtype=float) for name in SCAN_FIELDS]
    if columns[0].ndim != 1 or any(column.shape != columns[0].shape for column in columns) or not len(columns[0]):
        raise InvalidInput(f"friction scans must be columns of one length, not {[c.shape for c in columns]}")
    for row in np.flatnonzero(~np.all(np.isfinite(columns), axis=0))[:1]:
        raise InvalidInput(f"friction scan {row} has no direction or no force (NaN): leave it out")
    return finite_array("direction", columns[0]), columns[1], columns[2]


def _row_groups(direction: Array) -> NDArray[np.int64]:
    """Group of each row (2 n,): the number of its direction, equal for directions that differ by full turns."""
    step = np.round(np.remainder(direction, 2.0 * math.pi) / _SAME_DIRECTION)
    whole = round(2.0 * math.pi / _SAME_DIRECTION)
    found, number = np.unique(np.remainder(step, whole), return_inverse=True)
    return np.arange(2 * len(direction)) if len(found) < FEWEST_GROUPS else np.repeat(number.reshape(-1), 2)


def _predicted(values: Values, direction: Array, weight: float) -> tuple[Array, Array]:
    """Forces (2 n,), along then across for each scan, and their derivatives by ELLIPSE (2 n, 5).

    With E = ((ellipticity_x, ellipticity_y), (ellipticity_y, -ellipticity_x)) the ellipse's shape matrix is
    mean^2 expm(E) = mean^2 A, and the traction along u is mean (offset + A u / sqrt(u A u)): smooth in all, a circle
    included.
    """
    surface = SurfaceParameters.from_values(values)
    way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1)
    traction = surface.to_friction().traction(way)
    mean = math.exp(surface.friction_scale)
    shape, by_shape = _shape(surface.ellipticity_x, surface.ellipticity_y)
    push, size = way @ shape, np.sqrt(np.sum(way @ shape * way, axis=1))[:, None]
    columns = [traction]
    for change in by_shape:
        moved = way @ change
        columns.append(mean * (moved - push * np.sum(moved * way, axis=1)[:, None] / (2.0 * size**2)) / size)
    columns += [np.broadcast_to(mean * unit, way.shape) for unit in np.eye(2)]
    jacobian = np.stack(columns, axis=-1)
    turn = weight * np.stack([way, left], axis=1)
    force = np.einsum("nij,nj->ni", turn, traction)
    return force.ravel(), np.einsum("nij,njk->nik", turn, jacobian).reshape(-1, len(ELLIPSE))


def _shape(x: float, y: float) -> tuple[Array, tuple[Array, Array]]:
    """Return expm of ((x, y), (y, -x)), (2, 2), and its derivatives by x and y."""
    ratio = math.hypot(x, y)
    exponent, one = np.array(((x, y), (y, -x))), np.eye(2)
    if ratio < _ROUND:
        quotient, slope = 1.0 + ratio**2 / 6.0 + ratio**4 / 120.0, 1.0 / 3.0 + ratio**2 / 30.0 + ratio**4 / 840.0
    else:
        quotient = math.sinh(ratio) / ratio
        slope = (math.cosh(ratio) - quotient) / ratio**2
    units = np.array(((1.0, 0.0), (0.0, -1.0))), np.array(((0.0, 1.0), (1.0, 0.0)))
    first, second = (
        at * (quotient * one + slope * exponent) + quotient * unit for at, unit in zip((x, y), units, strict=True)
    )
    return math.cosh(ratio) * one + quotient * exponent, (first, second)
