"""Measured pairs of wrench and twist as data: how friction is spread over the object, seen from forces alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number, read_only
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Values, checked_labels
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters, share_names
from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint
from cyclemap.mechanics.outline import Outline
from cyclemap.text_files import CsvRow, CsvTable, read_csv_table, require_columns

Labels = NDArray[np.int64]

FORCE_KIND, TORQUE_KIND = "wrench force (N)", "wrench torque over radius (N)"
WRENCH_COLUMNS = ("fx", "fy", "m_over_rho")
TWIST_COLUMNS = ("vx", "vy", "w_times_rho")
# Pieces of the outline that count as one place of contact each: 9 mm on a square of 90 mm.
CONTACT_PIECES = 40
_POINTS = 720
# Of the weight, that its parts are computed with: the rest may have to lean under it.
_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class WrenchTwists:
    """Wrenches that kept an object moving, and its twists then, both in its own frame about its origin.

    wrench (n, 3) : N, N, N m, of the pusher on the object. twist (n, 3) : m/s, m/s, rad/s, none of them zero.

    Raises InvalidInput for shapes that do not agree, what is not finite, rest, and for wrenches most of which take
    power from the object: these are the object's on the pusher.
    """

    wrench: Array
    twist: Array

    def __post_init__(self) -> None:
        for name in ("wrench", "twist"):
            object.__setattr__(self, name, read_only(finite_array(name, getattr(self, name), last=3, ndim=2)))
        if len(self.wrench) != len(self.twist) or not len(self.twist):
            raise InvalidInput(f"{len(self.wrench)} wrenches and {len(self.twist)} twists: there must be one of each")
        for row in np.flatnonzero(np.all(self.twist == 0.0, axis=1))[:1]:
            raise InvalidInput(f"twist {row} is zero: friction is not unique at rest; leave it out")
        if np.median(self.power) < 0.0:
            raise InvalidInput("most wrenches take power from the object: turn their signs, if it was the pusher's")

    @property
    def power(self) -> Array:
        """(n,) W, that the pusher gives."""
        return np.asarray(np.sum(self.wrench * self.twist, axis=1))

    def contact_pieces(self, outline: Outline, pieces: int = CONTACT_PIECES) -> Labels:
        """Return on which of equally long pieces of the outline (n,) the pusher touched; -1 where that cannot be.

        A single pusher's force passes through its contact: the line of action enters the outline there, as seen along
        the force. A line that misses the outline is no single push.
        """
        rim = outline.points(_POINTS)
        place = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rim, axis=0).T))])
        found = [_entry(rim, place, *row) for row in self.wrench.tolist()]
        share = np.array(found) / place[-1]
        return np.where(np.isnan(share), -1, np.minimum(np.nan_to_num(share) * pieces, pieces - 1)).astype(np.int64)


def read_wrench_twists(
    path: str | Path, *, rho: float, surface: str | None = None, source: str | None = None
) -> WrenchTwists:
    """Read pairs from a CSV file with the columns fx, fy (N), m_over_rho (N), vx, vy, w_times_rho (m/s).

    rho : m, the length by which torque and turning rate were scaled (rect1 of the MIT data: 0.06364, its half
    diagonal). surface, source : rows of this entry in the column of that name only. Raises DataFileError.
    """
    table, length = read_csv_table(path), positive_number("rho", rho)
    require_columns(table, (*WRENCH_COLUMNS, *TWIST_COLUMNS))
    rows = list(table.rows)
    for column, wanted in (("surface", surface), ("source", source)):
        if wanted is not None:
            require_columns(table, (column,))
            rows = [row for row in rows if table.text(row, column) == wanted]
            _refuse_none(table, rows, column, wanted)
    scale = np.array([1.0, 1.0, length])
    wrench, twist = (
        np.array([[table.number(row, name) for name in names] for row in rows])
        for names in (WRENCH_COLUMNS, TWIST_COLUMNS)
    )
    try:
        return WrenchTwists(wrench * scale, twist / scale)
    except InvalidInput as cause:
        raise DataFileError(f"{table.path}: {cause}") from cause


def _refuse_none(table: CsvTable, rows: list[CsvRow], column: str, wanted: str) -> None:
    if not rows:
        known = sorted({table.text(row, column) for row in table.rows})
        raise DataFileError(f"{table.path}: no row has {column} {wanted!r}; there are {', '.join(known)}")


def wrench_twist_block(
    data: WrenchTwists, outline: Outline, weight: float, groups: Labels | None = None, name: str = "wrenches"
) -> FunctionBlock:
    """Return pairs of wrench and twist as a block of data that depends on `friction_scale` and shares of the weight.

    outline : of the object, in the frame of the data. weight : N. groups : (n,) whole numbers, pairs that share their
    errors; None: pairs of one place of contact (`WrenchTwists.contact_pieces`), which do not need their order.

    The wrench is the weight times grad D of the footprint at the twist (Goyal, Ruina & Papadopoulos 1991), and D is
    linear in the shares. The torque is divided by the outline's extent, so that all rows are in N.

    The object's orientation in the world is not in such data: friction is taken as isotropic. Over orientations all
    around, offset and ellipticity leave the mean wrench as it is to first order: the plywood of Ma & Rodriguez (2018)
    then moves the rim share by about 0.01, by up to 0.08 where all orientations lie within 40 degrees of one. Twists
    are taken as exact: their noise flattens the wrench's response and draws the rim share down (a share of 0.5 to 0.37
    for 0.5 mm/s in each component at speeds of 10 mm/s, to 0.14 for 1 mm/s), so that a small share is weak evidence
    for even pressure, a large one strong evidence against it.

    >>> from cyclemap.mechanics import Slider
    >>> square, twist = Slider.mit("rect1").outline, [[0.0, 0.01, 0.0]]
    >>> block = wrench_twist_block(WrenchTwists([[0.0, 2.0, 0.0]], twist), square, 8.0)
    >>> residual, _ = block.residuals({"friction_scale": math.log(0.25), "rim_share": 0.3})
    >>> bool(np.allclose(residual, 0.0, atol=1e-12))
    True
    """
    load, length = positive_number("weight", weight), outline.extent
    scale = np.array([1.0, 1.0, 1.0 / length])
    names = share_names(outline)
    even, *by_shares = (load * part * scale for part in _wrench_parts(outline, data.twist, names))
    measured, parameters = (data.wrench * scale).ravel(), ("friction_scale", *names)

    def function(values: Values) -> tuple[Array, Array]:
        mean, surface = math.exp(values["friction_scale"]), SurfaceParameters.from_values(values)
        shares = [surface.shares[name] for name in names]
        force = mean * (even + sum(share * part for share, part in zip(shares, by_shares, strict=True))).ravel()
        by_mechanics = np.column_stack([force, *(mean * part.ravel() for part in by_shares)])
        return force - measured, surface.chain(by_mechanics, parameters, parameters)

    labels = data.contact_pieces(outline) if groups is None else checked_labels(name, groups, len(data.twist))
    kinds = np.tile([FORCE_KIND, FORCE_KIND, TORQUE_KIND], len(data.twist))
    return FunctionBlock(name, parameters, function, np.repeat(labels, 3), kinds)


def _wrench_parts(outline: Outline, twist: Array, names: tuple[str, ...]) -> list[Array]:
    """Wrenches (n, 3) per unit load and friction under even pressure, then their change by each share."""
    law = EllipseFriction.isotropic(1.0)
    even = LimitSurface(PatchFootprint(outline), law).wrench(twist)
    parts = [replace(PatchFootprint(outline), **{name: _SHARE}) for name in names]  # type: ignore[arg-type]
    return [even, *((LimitSurface(part, law).wrench(twist) - even) / _SHARE for part in parts)]


def _entry(rim: Array, place: Array, fx: float, fy: float, torque: float) -> float:
    """Arclength (m) at which the line of action of a wrench enters a closed polyline (k, 2); nan if it misses."""
    height = rim[:, 0] * fy - rim[:, 1] * fx - torque
    crossing = np.flatnonzero(height[:-1] * height[1:] <= 0.0)
    if fx == fy == 0.0 or not crossing.size:
        return math.nan
    drop = height[crossing] - height[crossing + 1]
    share = np.clip(np.where(drop == 0.0, 0.0, height[crossing] / np.where(drop == 0.0, 1.0, drop)), 0.0, 1.0)
    points = rim[crossing] + share[:, None] * (rim[crossing + 1] - rim[crossing])
    first = int(np.argmin(points @ (fx, fy)))
    lengths = place[crossing + 1] - place[crossing]
    return float(place[crossing[first]] + share[first] * lengths[first])
