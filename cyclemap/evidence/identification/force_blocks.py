"""Measured forces as data: friction scans, pairs of wrench and twist, and force ratios while the
rod slides.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, stretches
from cyclemap.checks import finite_array, positive_number, read_only
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, Labels, linear_block
from cyclemap.evidence.identification.identify import Identification, identify
from cyclemap.evidence.identification.surface_parameters import (
    PLATE_NAMES,
    SURFACE,
    Rows,
    SurfaceParameters,
    Values,
)
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS, contact_samples
from cyclemap.evidence.pushes.recordings import PushRecord
from cyclemap.evidence.tables.columns import TWIST_COLUMNS, WRENCH_COLUMNS
from cyclemap.mechanics import EllipseFriction, LimitSurface, Slider
from cyclemap.mechanics.outline import Outline

if TYPE_CHECKING:
    import pandas

# Columns, or arrays by their names.
Scans: TypeAlias = "pandas.DataFrame | Mapping[str, ArrayLike]"

# Columns of a table of friction scans.
SCAN_FIELDS = ("direction", "force_along", "force_across")
ELLIPSE = SURFACE.names[:5]
SCAN_KIND = "scan force (N)"
# An ellipse off its centre has five numbers, a direction gives two: fewer groups cannot tell their
# own scatter.
FEWEST_GROUPS = 4
# Directions (rad) as near as this are one.
_SAME_DIRECTION = 1e-6
FORCE_KIND = "wrench force (N)"
TORQUE_KIND = "wrench torque over radius (N)"
# Pieces of the outline that count as one place of contact each: 9 mm on a square of 90 mm.
CONTACT_PIECES = 40
_POINTS = 720
# Change of a shape, kPa, by which wrenches are differentiated.
_STEP = 0.02
RATIO_KIND = "force ratio (1)"
# Slip per travel of the rod above which it slides and below which it sticks: between them the poses
# do not tell.
SLIDING = 0.1
STICKING = 0.03
# Straight lines between poses so many times as rare are off by the square of that: noise hides the
# error of the lines between all poses, but not that.
_RARITY = 16


def scan_columns(scans: Scans) -> Array:
    """Return direction (rad) and the rod's forces along and across (N) of friction scans, (3, n);
    see the block.
    """
    missing = [name for name in SCAN_FIELDS if name not in scans]
    if missing:
        raise InvalidInput(
            f"friction scans need {', '.join(SCAN_FIELDS)}: {', '.join(missing)} is missing"
        )
    columns = [np.atleast_1d(np.asarray(scans[name], dtype=float)) for name in SCAN_FIELDS]
    lengths = [len(column) for column in columns]
    if len({*lengths}) > 1 or not lengths[0]:
        raise InvalidInput(f"friction scans must be columns of one length, not {lengths}")
    for row in np.flatnonzero(~np.all(np.isfinite(columns), axis=0))[:1]:
        raise InvalidInput(f"friction scan {row} has no direction or no force (NaN): leave it out")
    return np.array(columns)


def scan_traction(scans: Scans, weight: float) -> Array:
    """Return the traction coefficient along x and y of the world (n, 2) of friction scans of an
    object, weight N.

    >>> scans = {"direction": [0.0], "force_along": [2.0], "force_across": [0.5]}
    >>> scan_traction(scans, 8.0).tolist()
    [[0.25, 0.0625]]
    """
    direction, along, across = scan_columns(scans)
    c = np.cos(direction)
    s = np.sin(direction)
    return np.stack([along * c - across * s, along * s + across * c], axis=-1) / positive_number(
        "weight", weight
    )


def friction_scan_block(scans: Scans, weight: float) -> DataBlock:
    """Return friction scans as a block of data.

    Parameters
    ----------
    scans : pandas.DataFrame or mapping of str to array_like
        Columns, or arrays by these names: `direction` (rad, of the motion in the world),
        `force_along` and `force_across` (N, of the rod on the object, the second to the left of
        the motion).
    weight : float
        Of the object, N.

    Returns
    -------
    DataBlock
        Forces along and across, N, on the parameters of the friction ellipse.

    Raises
    ------
    InvalidInput
        For columns that are missing or hold what is no number (NaN: leave such scans out).

    Notes
    -----
    Carried in translation all points of the object slide alike, however the pressure is spread,
    and the force is the weight times the traction of one point (Ma & Rodriguez 2018, Eq. 2).
    Rows are along then across for each scan; scans in one direction are one group, so that what
    a direction's repeats have in common is not taken for evidence. With fewer than four
    directions each row stands for itself: so few groups cannot tell their scatter.

    References
    ----------
    Ma, D. & Rodriguez, A. (2018), Friction variability in planar pushing data, IEEE Robotics and
    Automation Letters 3(4), Eq. 2.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.evidence import SurfaceParameters, friction_scan_block
    >>> scans = {"direction": [0.0, 1.0], "force_along": [2.0, 2.0], "force_across": [0.0, 0.0]}
    >>> even = SurfaceParameters(math.log(0.25)).values()
    >>> residual, _ = friction_scan_block(scans, 8.0).residuals(even)
    >>> bool(np.allclose(residual, 0.0, atol=1e-5))
    True
    """
    positive_number("weight", weight)
    direction, *forces = scan_columns(scans)
    measured = np.stack(forces, axis=-1).ravel()
    groups = np.arange(len(measured))
    alike = _alike_directions(direction)
    if alike.max() + 1 >= FEWEST_GROUPS:
        groups = np.repeat(alike, 2)
    way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1)
    turn = weight * np.stack([way, left], axis=1)

    def function(values: Values) -> Rows:
        traction, by_ellipse = _traction(SurfaceParameters.from_values(values), way)
        force = np.einsum("nij,nj->ni", turn, traction).ravel()
        jacobian = np.einsum("nij,njk->nik", turn, by_ellipse)
        return force - measured, jacobian.reshape(-1, len(ELLIPSE))

    return DataBlock("friction scans", ELLIPSE, function, groups, np.array(SCAN_KIND))


def _alike_directions(direction: Array) -> Labels:
    """Numbers from 0 of directions (n,), rad; those that differ by full turns are one."""
    steps = np.round(np.remainder(direction, TWO_PI) / _SAME_DIRECTION)
    turn = round(TWO_PI / _SAME_DIRECTION)
    return np.unique(np.remainder(steps, turn), return_inverse=True)[1].reshape(-1)


def _traction(surface: SurfaceParameters, way: Array) -> Rows:
    """The traction of points that slide along unit vectors (n, 2), and its derivatives by ELLIPSE
    (n, 2, 5).

    With E = ((ellipticity_x, ellipticity_y), (ellipticity_y, -ellipticity_x)) the ellipse's shape
    matrix is mean^2 expm(E) = mean^2 A, and the traction along u is mean (offset + A u / sqrt(u A
    u)): smooth in all, a circle included.
    """
    from scipy.linalg import expm, expm_frechet

    by_x = np.array(((1.0, 0.0), (0.0, -1.0)))
    by_y = np.array(((0.0, 1.0), (1.0, 0.0)))
    traction = surface.to_friction().traction(way)
    mean = math.exp(surface.friction_scale)
    exponent = surface.ellipticity_x * by_x + surface.ellipticity_y * by_y
    push = way @ expm(exponent)
    square = np.sum(push * way, axis=1, keepdims=True)
    columns = [traction]
    for unit in (by_x, by_y):
        moved = way @ expm_frechet(exponent, unit, compute_expm=False)
        along = np.sum(moved * way, axis=1, keepdims=True)
        columns.append(mean * (moved - push * along / (2.0 * square)) / np.sqrt(square))
    columns += [np.broadcast_to(mean * unit, way.shape) for unit in np.eye(2)]
    return traction, np.stack(columns, axis=-1)


def friction_ellipse_from_scans(
    scans: Scans, weight: float, noise: float | None = None
) -> Identification:
    """Identify the friction ellipse from friction scans alone.

    Parameters
    ----------
    scans : pandas.DataFrame or mapping of str to array_like
        As in `friction_scan_block`.
    weight : float
        Of the object, N.
    noise : float or None, optional
        Of a scan's force component, N, if it is known.

    Returns
    -------
    Identification
        The ellipse, with its intervals.

    Raises
    ------
    ConvergenceError
        Where the noise can be told from nothing: without repeats of a direction or `noise`.

    Notes
    -----
    Over 200 seeded sets of 4 to 72 directions, twice each, intervals of 95 % held the truth in 90
    to 99 %, also where the repeats of a direction share most of their error. Scans in fewer than
    three directions leave the ellipse open: the estimates then say that they are not identifiable.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import friction_ellipse_from_scans
    >>> direction, along = np.linspace(0.0, 6.0, 12), 2.0 + np.zeros(12)
    >>> scans = {"direction": direction, "force_along": along, "force_across": 0.0 * along}
    >>> round(friction_ellipse_from_scans(scans, 8.0).friction().mu_a, 5)
    0.25
    """
    known = None if noise is None else {SCAN_KIND: noise}
    return identify([friction_scan_block(scans, weight)], ELLIPSE, starts=4, noise=known)


@dataclass(frozen=True, eq=False)
class WrenchTwists:
    """Wrenches that kept an object moving, and its twists then, both in its own frame about its
    origin.

    Parameters
    ----------
    wrench : array_like, shape (n, 3)
        N, N, N m, of the pusher on the object.
    twist : array_like, shape (n, 3)
        m/s, m/s, rad/s, none of them zero.

    Raises
    ------
    InvalidInput
        For shapes that do not agree, what is not finite, rest, and wrenches of the wrong sign.

    Examples
    --------
    >>> from cyclemap.evidence import WrenchTwists
    >>> data = WrenchTwists([[0.0, 2.0, 0.0]], [[0.0, 0.01, 0.0]])
    >>> data.twist.shape
    (1, 3)
    """

    wrench: Array
    twist: Array

    def __post_init__(self) -> None:
        for name in ("wrench", "twist"):
            object.__setattr__(
                self, name, read_only(finite_array(name, getattr(self, name), last=3, ndim=2))
            )
        if len(self.wrench) != len(self.twist) or not len(self.twist):
            raise InvalidInput(
                f"{len(self.wrench)} wrenches and {len(self.twist)} twists: there must be one of "
                "each"
            )
        for row in np.flatnonzero(np.all(self.twist == 0.0, axis=1))[:1]:
            raise InvalidInput(f"twist {row} is zero: friction is not unique at rest; leave it out")
        if np.median(np.sum(self.wrench * self.twist, axis=1)) < 0.0:
            raise InvalidInput(
                "most wrenches take power from the object: turn their signs, if it was the pusher's"
            )

    def contact_pieces(self, outline: Outline) -> Labels:
        """Return on which of equally long pieces of the outline (n,) the pusher touched; -1 where
        that cannot be.

        A single pusher's force passes through its contact: the line of action enters the outline
        there, as seen along the force. A line that misses the outline is no single push.
        """
        corners = outline.points(_POINTS)
        way = np.append(0.0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T)))
        along = np.linspace(0.0, way[-1], _POINTS + 1)
        x, y = (np.interp(along, way, coordinate) for coordinate in corners.T)
        force_x, force_y, torque = self.wrench.T[..., None]
        # How far the rim is beside the line of action, and how far along it.
        beside = x * force_y - y * force_x - torque
        crosses = (beside[:, :-1] * beside[:, 1:] <= 0.0) & ((force_x != 0.0) | (force_y != 0.0))
        reached = np.where(crosses, (x * force_x + y * force_y)[:, :-1], np.inf)
        entry = np.argmin(reached, axis=1)
        return np.where(crosses.any(axis=1), entry * CONTACT_PIECES // _POINTS, -1)


def read_wrench_twists(rows: pandas.DataFrame, rho: float) -> WrenchTwists:
    """Read pairs from rows, as `known_columns` tells them, of fx, fy (N), m_over_rho (N), vx, vy,
    w_times_rho (m/s).

    rho : m, the length by which torque and turning rate were scaled (rect1 of the MIT data:
        0.06364, its half diagonal).

    Raises DataFileError.
    """
    scale = np.array([1.0, 1.0, positive_number("rho", rho)])
    wrench, twist = (
        rows[[*names]].to_numpy(dtype=float) for names in (WRENCH_COLUMNS, TWIST_COLUMNS)
    )
    try:
        return WrenchTwists(wrench * scale, twist / scale)
    except InvalidInput as cause:
        raise DataFileError(f"{rows['path'].iloc[0]}: {cause}") from cause


def wrench_twist_block(data: WrenchTwists, slider: Slider) -> DataBlock:
    """Return pairs of wrench and twist as a block of data.

    Parameters
    ----------
    data : WrenchTwists
        Wrenches and twists, in the object's frame.
    slider : Slider
        The object.

    Returns
    -------
    DataBlock
        Forces, N, on `friction_scale`, the floor's dome and the plate's shape.

    Notes
    -----
    Pairs of one place of contact share their errors (`WrenchTwists.contact_pieces`). The wrench
    is the weight times grad D of the footprint at the twist (Goyal, Ruina & Papadopoulos 1991).
    The torque is divided by the outline's extent, so that all rows are in N.

    The object's orientation in the world is not in such data: friction is taken as isotropic,
    and a floor's bow, which the plate turns against, is left out. Twists are taken as exact:
    their noise makes weight near the rim look less.

    References
    ----------
    Goyal, S., Ruina, A. & Papadopoulos, J. (1991), Planar sliding with dry friction, part 1: limit
    surface and moment function, Wear 143.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap import Slider
    >>> from cyclemap.evidence import SurfaceParameters, WrenchTwists, wrench_twist_block
    >>> square, twist = Slider.mit("rect1"), [[0.0, 0.01, 0.0]]
    >>> block = wrench_twist_block(WrenchTwists([[0.0, 0.25 * square.weight, 0.0]], twist), square)
    >>> residual, _ = block.residuals(SurfaceParameters(math.log(0.25)).values())
    >>> bool(np.allclose(residual, 0.0, atol=1e-9))
    True
    """
    unit = np.array([1.0, 1.0, 1.0 / slider.outline.extent])
    law = EllipseFriction.isotropic(1.0)
    measured = (data.wrench * unit).ravel()
    parameters = ("friction_scale", "floor_dome", *PLATE_NAMES)

    def wrench(shape: Array) -> Array:
        surface = SurfaceParameters(**dict(zip(PLATE_NAMES, shape.tolist(), strict=True)))
        force = LimitSurface(surface.footprint(slider), law).wrench(data.twist) * unit
        return np.asarray(slider.weight * force.ravel())

    def function(values: Values) -> Rows:
        shape = np.array([values[name] for name in PLATE_NAMES])
        shape[0] += values["floor_dome"]
        mean = math.exp(values["friction_scale"])
        force = wrench(shape)
        steps = _STEP * np.eye(len(shape))
        slopes = [(wrench(shape + step) - wrench(shape - step)) / (2.0 * _STEP) for step in steps]
        return mean * force - measured, mean * np.column_stack([force, slopes[0], *slopes])

    groups = np.repeat(data.contact_pieces(slider.outline), 3)
    kinds = np.tile([FORCE_KIND, FORCE_KIND, TORQUE_KIND], len(data.twist))
    return DataBlock("wrenches", parameters, function, groups, kinds)


@dataclass(frozen=True, eq=False)
class SlidingForces:
    """Ratios of forces in the pieces of pushes in which the rod slid all the time.

    Attributes
    ----------
    ratio : ndarray, shape (m,)
        Sum of tangential over sum of normal force, positive where friction goes with the rod's
        slip over the object.
    closer : ndarray, shape (m,)
        The same as if poses were recorded at all times, by extrapolation.
    push : ndarray of int, shape (m,)
        Number of the push.
    samples : int
        In all pieces.
    sticking : int
        Samples in which the rod stuck.
    """

    ratio: Array
    closer: Array
    push: Labels
    samples: int
    sticking: int


def force_ratio_block(sliding: SlidingForces) -> DataBlock:
    """Return the ratios of sliding pieces as a block of data that depends on `pusher_friction`; a
    group a push.

    Whether the rod slides is read off the motion, not off the forces, so that the noise of the
    forces does not bias the answer: while it slides the ratio is the friction coefficient
    (Coulomb's law; Ma & Rodriguez 2018, Fig. 10 left), while it sticks it is less. Pieces of one
    push share their errors; those of one push alone are a group each. By how much ratios are off
    since poses are known at some times only is told by the closer ones. Raises InvalidInput where
    nothing slides.

    >>> ratio = np.array([0.14, 0.15, 0.16])
    >>> sliding = SlidingForces(ratio, ratio, np.array([0, 0, 1]), 3, 0)
    >>> force_ratio_block(sliding).residuals({"pusher_friction": 0.15})[0].round(9).tolist()
    [0.01, 0.0, -0.01]
    """
    if not sliding.ratio.size:
        raise InvalidInput("no push slides: the forces do not tell the friction of rod and object")
    count = sliding.ratio.size
    single = len(np.unique(sliding.push)) == 1
    groups = np.arange(count) if single else sliding.push
    ones = np.ones((count, 1))
    block, closer = (
        linear_block("force ratios", ("pusher_friction",), ones, ratio, groups, RATIO_KIND)
        for ratio in (sliding.ratio, sliding.closer)
    )
    return replace(block, refined=(closer.function,))


def sliding_forces(
    pushes: Iterable[tuple[PushRecord, Array]], rod_radius: float = MIT_ROD_RADIUS
) -> SlidingForces:
    """Return the force ratios of the sliding pieces of pushes, each a record and its object's
    outline (k, 2), m.

    A piece is as many consecutive samples as a window of `contact_samples`, touching, with a slip
    of more than a tenth of the rod's travel of one sign in every window that a sample is part of.
    """
    rows = []
    sticking = 0
    for index, (record, outline) in enumerate(pushes):
        samples = contact_samples(record, outline, rod_radius)
        rarity = min(samples.window, _RARITY)
        rare = contact_samples(_with_rare_poses(record, rarity), outline, rod_radius)
        for sign in (-1.0, 1.0):
            slides = samples.touching & _steady(sign * samples.slip > SLIDING, samples.window)
            for first, end in stretches(slides):
                for start in range(first, end - samples.window + 1, samples.window):
                    piece = slice(start, start + samples.window)
                    forces = [np.sum(each.force[piece]) for each in (samples, rare)]
                    ratio, coarse = (sign * force.imag / force.real for force in forces)
                    closer = ratio + (ratio - coarse) / (rarity**2 - 1.0)
                    rows.append((ratio, closer, index, samples.window))
        sticking += int(
            np.sum(samples.touching & _steady(np.abs(samples.slip) < STICKING, samples.window))
        )
    ratios, closer_ratios, numbers, lengths = np.array(rows, dtype=float).reshape(-1, 4).T
    return SlidingForces(
        ratios, closer_ratios, numbers.astype(np.int64), int(np.sum(lengths)), sticking
    )


def _with_rare_poses(record: PushRecord, rarity: int) -> PushRecord:
    """A push with its first, its last and every so many of its poses only."""
    object_pose, tip_pose = (
        pose[np.r_[: len(pose) - 1 : rarity, len(pose) - 1]]
        for pose in (record.object_pose, record.tip_pose)
    )
    return PushRecord(object_pose, tip_pose, record.ft_wrench)


def _steady(state: Mask, window: int) -> Mask:
    """Whether a state lasts through all of the window about each sample."""
    padded = np.pad(state, window // 2, constant_values=False)
    return np.asarray(np.all(np.lib.stride_tricks.sliding_window_view(padded, window), axis=1))
