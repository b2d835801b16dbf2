"""Footprints: how the slider's weight is spread over its underside, exactly or on points."""

import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import get_args

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.checks import (
    finite_array,
    finite_number,
    point,
    read_only,
    require_kind,
    whole_number,
)
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics.foundation import PressedFootprint
from cyclemap.mechanics.outline import (
    Ellipse,
    Outline,
    Polygon,
    area_quadrature,
    nearest_on_polyline,
)
from cyclemap.text_files import read_csv_table, require_columns

# The outline scaled by this about its centroid carries the inner share.
INNER = 0.55
# Rounding may leave a pressure that vanishes this much below zero.
_ROUNDING = 1e-12
# Loads of points up to this share of an even one count as none: rounding may leave them below zero.
_NO_LOAD = 1e-9
_MOST_ASIDE = 99
# A point as near to a side, in extents of its outline, lies on it.
_ON_SIDE = 1e-9
# Thinner outlines than this share of their extent lose too many digits to be summed in closed form.
_THINNEST = 1e-4


@dataclass(frozen=True)
class PatchFootprint:
    """Pressure of an outline, exact, without a grid, as a sum of parts whose shares of the load add
    to one.

    The parts: even, over the whole area: what is left; inner, over the outline scaled by INNER
    about its centroid; rim, a line load along the outline (per length as far as the side is from
    the centroid; on an ellipse alike in the eccentric angle); corners, on the vertices of a polygon
    alike. Where the centre of pressure is not that of the parts, the even part leans, as a rigid
    object does: per unit load its pressure is (share + gradient . x)/A, x = r - centroid.

    Parameters
    ----------
    outline : Polygon or Ellipse
        What touches the ground.
    inner_share : float, default 0.0
        Share of the load on the outline scaled by INNER about its centroid, from 0 to 1.
    rim_share : float, default 0.0
        Share of the load on the rim, from 0 to 1.
    corner_share : float, default 0.0
        Share of the load on the corners, from 0 to 1; together the shares are at most 1.
    centre : tuple[float, float], optional
        Centre of pressure, (x, y), m; None: the centroid.

    Attributes
    ----------
    even_share : float
        What is left of the load, spread over the whole area.
    extent : float
        Largest distance of the outline from its centroid, m.
    second_moments : ndarray, shape (2, 2)
        Means of x x^T over the outline's area, m^2.
    gradient : tuple[float, float]
        Slope of the even pressure, 1/m.
    balance : tuple[float, float]
        Derivative of `gradient` by the corner share, 1/m.
    has_frame : bool
        Whether it can have an inner and a rim share: the scaled outline lies inside, as it does
        in every convex one.

    Raises
    ------
    InvalidInput
        For an outline that is none, shares outside [0, 1] or above 1 together, corners of an
        ellipse, an inner or rim share where the scaled outline does not lie inside, and a centre
        of pressure so far out that the pressure would be negative somewhere.

    Examples
    --------
    >>> from cyclemap import Ellipse, PatchFootprint
    >>> PatchFootprint(Ellipse(1.0, 1.0), rim_share=0.25).even_share
    0.75
    """

    outline: Outline
    inner_share: float = 0.0
    rim_share: float = 0.0
    corner_share: float = 0.0
    centre: tuple[float, float] = None  # type: ignore[assignment]  # filled in below
    even_share: float = field(init=False, repr=False, compare=False)
    extent: float = field(init=False, repr=False, compare=False)
    second_moments: Array = field(init=False, repr=False, compare=False)
    gradient: tuple[float, float] = field(init=False, repr=False, compare=False)
    balance: tuple[float, float] = field(init=False, repr=False, compare=False)
    has_frame: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        outline = self.outline
        require_kind("outline of a footprint", outline, Polygon, Ellipse)
        moments, corners, has_frame = _shape_of(outline)
        even_share = self._even_share(has_frame)
        centre = (
            outline.centroid if self.centre is None else point("centre of pressure", self.centre)
        )
        off = np.column_stack(
            [np.subtract(centre, outline.centroid) - self.corner_share * corners, -corners]
        )
        off[:, np.hypot(*off) <= 1e-12 * outline.extent] = 0.0
        gradient, balance = map(tuple, np.linalg.solve(moments, off).T.tolist())
        lift = even_share + float((outline.points(720) - outline.centroid).dot(gradient).min())
        if lift < -_ROUNDING:
            raise InvalidInput(
                f"centre of pressure {centre} m with {self._shares} lifts the outline off the "
                f"ground (least pressure {lift:.3g} of the mean): bring it nearer to the centroid, "
                "leave more of the load even, or give support points"
            )
        vars(self).update(
            centre=centre,
            even_share=even_share,
            extent=outline.extent,
            second_moments=moments,
            gradient=gradient,
            balance=balance,
            has_frame=has_frame,
        )

    @property
    def _shares(self) -> str:
        return (
            f"inner share {self.inner_share}, rim share {self.rim_share} and corner share "
            f"{self.corner_share}"
        )

    def _even_share(self, has_frame: bool) -> float:
        """What other shares leave of the load; refuses those that the outline cannot have."""
        for name in ("inner_share", "rim_share", "corner_share"):
            vars(self)[name] = finite_number(name.replace("_", " "), getattr(self, name))
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InvalidInput(
                    f"{name.replace('_', ' ')} {getattr(self, name)} must lie from 0 to 1"
                )
        even_share = 1.0 - self.inner_share - self.rim_share - self.corner_share
        if even_share < -_ROUNDING:
            raise InvalidInput(
                f"{self._shares} add to {1.0 - even_share:.6g}: together they may be 1 at most"
            )
        if self.corner_share != 0.0 and isinstance(self.outline, Ellipse):
            raise InvalidInput(
                f"corner share {self.corner_share}: an ellipse has no corners; choose 0"
            )
        if (self.inner_share != 0.0 or self.rim_share != 0.0) and not has_frame:
            raise InvalidInput(
                f"inner share {self.inner_share}, rim share {self.rim_share}: the outline scaled "
                f"by {INNER} about its centroid does not lie inside this concave outline; leave "
                "both at 0 or give support points"
            )
        return even_share


@lru_cache(maxsize=256)
def _shape_of(outline: Outline) -> tuple[Array, Array, bool]:
    """Second moments (2, 2), the mean corner off the centroid (2,), and whether it has a frame;
    refuses thin ones.
    """
    corners, has_frame = np.zeros(2), True
    if isinstance(outline, Ellipse):
        semi_axes = np.array((outline.semi_x, outline.semi_y))
        moments = np.diag(semi_axes**2) / 4.0
        thickness = float(semi_axes.min()) / outline.extent
    else:
        points, weights = area_quadrature(outline)
        lever = points - outline.centroid
        moments = np.asarray(np.einsum("k,ki,kj->ij", weights, lever, lever))
        thickness = float(np.sqrt(12.0 * max(np.linalg.eigvalsh(moments)[0], 0.0)) / outline.extent)
        corners = np.asarray(outline.array.mean(axis=0) - outline.centroid)
        inside = outline.scaled(INNER, outline.centroid)
        has_frame = outline.is_convex or (
            bool(np.all(side_arms(outline) > 0.0)) and outline.encloses(inside)
        )
    if thickness < _THINNEST:
        raise InvalidInput(
            f"the outline is {thickness:.3g} times as thick as it is long: below {_THINNEST} its "
            "pressure cannot be summed accurately; give support points along a line instead"
        )
    return read_only(moments), read_only(corners), has_frame


def side_arms(outline: Polygon) -> Array:
    """Distances (k,) of the sides from the centroid, times the sides' lengths, m^2."""
    x, y = (outline.array - outline.centroid).T
    return np.asarray(x * np.roll(y, -1) - y * np.roll(x, -1))


@dataclass(frozen=True)
class PointFootprint:
    """Weight carried by points.

    Parameters
    ----------
    positions : array_like, shape (k, 2)
        Places of the points, m, object's frame, not all the same.
    weights : array_like, shape (k,)
        Their shares of the load, none negative, scaled to sum one; points without load are left
        out.

    Attributes
    ----------
    quadrature : tuple[ndarray, ndarray]
        Positions (k, 2), m, and weights (k,) as arrays.
    centre : tuple[float, float]
        Centre of pressure, m.
    extent : float
        Largest distance of a point from the centre, m.

    Raises
    ------
    InvalidInput
        For shapes that do not match, weights that are negative or all zero, and points that all
        lie in one place.

    Examples
    --------
    >>> from cyclemap import PointFootprint
    >>> PointFootprint(((0.0, 0.0), (2.0, 0.0)), (1.0, 3.0)).centre
    (1.5, 0.0)
    """

    positions: tuple[tuple[float, float], ...]
    weights: tuple[float, ...]
    quadrature: tuple[Array, Array] = field(init=False, repr=False, compare=False)
    centre: tuple[float, float] = field(init=False, repr=False, compare=False)
    extent: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        points = finite_array("support points", self.positions, last=2)
        weights = finite_array("support weights", self.weights)
        if points.ndim != 2 or weights.shape != points.shape[:1]:
            raise InvalidInput(
                f"support points (k, 2) and weights (k,) do not match: {points.shape}, "
                f"{weights.shape}"
            )
        if np.any(weights < 0.0) or not weights.sum() > 0.0:
            raise InvalidInput(
                "support weights must not be negative and not all zero: the least is "
                f"{weights.min()}"
            )
        points, weights = points[weights > 0.0], weights[weights > 0.0]
        if np.ptp(points, axis=0).max() == 0.0:
            raise InvalidInput(
                "a footprint needs two support points apart: one point alone resists no turning"
            )
        weights = weights / weights.sum()
        x, y = weights @ points
        vars(self).update(
            positions=tuple(map(tuple, points.tolist())),
            weights=tuple(weights.tolist()),
            quadrature=(read_only(points), read_only(weights)),
            centre=(float(x), float(y)),
            extent=float(np.hypot(*(points - (x, y)).T).max()),
        )


Footprint = PatchFootprint | PressedFootprint | PointFootprint
FOOTPRINTS = get_args(Footprint)


def grid_footprint(outline: Outline, count: int) -> PointFootprint:
    """Return the paper's footprint: the centres of `count` x `count` cells of the bounding box,
    where they lie inside the outline, with the same load on each; half of it on a side.

    Parameters
    ----------
    outline : Polygon or Ellipse
        What touches the ground.
    count : int
        Cells along each side of the bounding box, 2 to 99: each point weighs in every step of
        every push. Ma & Rodriguez (2018) use 8.

    Returns
    -------
    PointFootprint
        The points, which carry the same load each; those on a side of the outline half of it.

    Raises
    ------
    InvalidInput
        For an outline that is none, and a count outside 2 to 99.

    References
    ----------
    Ma, D. & Rodriguez, A. (2018), Friction variability in planar pushing data, IEEE Robotics and
    Automation Letters 3(4).

    Examples
    --------
    >>> from cyclemap.mechanics import Ellipse, grid_footprint
    >>> len(grid_footprint(Ellipse(1.0, 1.0), 4).positions)
    12
    """
    require_kind("outline of a footprint", outline, Polygon, Ellipse)
    if whole_number("points a side of a grid footprint", count, least=2) > _MOST_ASIDE:
        raise InvalidInput(
            f"a grid footprint of {count} points a side: the points a side must be below 100"
        )
    corners = outline.points(4)
    low, high = corners.min(axis=0), corners.max(axis=0)
    share = (np.arange(count) + 0.5) / count
    shares = np.stack(np.meshgrid(share, share, indexing="ij"), axis=-1).reshape(-1, 2)
    cells = low + shares * (high - low)
    # On an ellipse lies none: no squares of two of the centres' odd numbers add up to a square.
    on_side = _on_sides(outline, cells) if isinstance(outline, Polygon) else np.zeros(len(cells))
    load = np.where(on_side, 0.5, outline.contains(cells))
    bears = load > 0.0
    if bears.sum() < 2:
        raise InvalidInput(
            f"a {count} x {count} grid has {bears.sum()} points inside the outline: make it finer"
        )
    return PointFootprint(tuple(map(tuple, cells[bears].tolist())), tuple(load[bears].tolist()))


def _on_sides(outline: Polygon, points: Array) -> Mask:
    """Whether points (k, 2) lie on a side, but for rounding."""
    corners = outline.array
    nearest, _ = nearest_on_polyline(points, np.vstack([corners, corners[:1]]))
    return np.asarray(np.hypot(*(points - nearest).T) <= _ON_SIDE * outline.extent)


def corner_footprint(outline: Polygon) -> PointFootprint:
    """Return the footprint of an object that stands on its corners, the same load on each.

    Parameters
    ----------
    outline : Polygon
        What stands on its corners.

    Returns
    -------
    PointFootprint
        Its vertices, each with the same weight.

    Raises
    ------
    InvalidInput
        For an outline that has no corners.

    Examples
    --------
    >>> from cyclemap.mechanics import Polygon, corner_footprint
    >>> corner_footprint(Polygon(((0, 0), (1, 0), (1, 1), (0, 1)))).weights
    (0.25, 0.25, 0.25, 0.25)
    """
    require_kind("outline of a footprint on corners", outline, Polygon)
    return PointFootprint(outline.vertices, (1.0,) * outline.sides)


def load_footprint(path: str | Path) -> PointFootprint:
    """Read support points from a CSV file with the columns x_mm, y_mm, weight (object frame).

    Parameters
    ----------
    path : str or Path
        The CSV file; positions in mm in the object's frame, weights in any unit.

    Returns
    -------
    PointFootprint
        One point a row, the weights scaled to sum one.

    Raises
    ------
    DataFileError
        Naming file and line, for a missing file or column, or a row that is not three numbers;
        and for points and weights that make no footprint.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.mechanics import load_footprint
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = Path(place, "points.csv").write_text("x_mm,y_mm,weight\\n0,0,1\\n20,0,3\\n")
    ...     footprint = load_footprint(f"{place}/points.csv")
    >>> footprint.centre
    (0.015, 0.0)
    """
    table = read_csv_table(path)
    columns = ("x_mm", "y_mm", "weight")
    require_columns(table, columns)
    x_mm, y_mm, weight = (table.numbers(name) for name in columns)
    try:
        return PointFootprint(tuple(zip(x_mm * 1e-3, y_mm * 1e-3, strict=True)), tuple(weight))
    except InvalidInput as cause:
        raise DataFileError(f"{path}: {cause}") from cause


def parse_footprint(text: str, outline: Outline) -> Footprint:
    """Return the footprint that a word names: `exact`, `grid:N`, `corners`, or the path of a CSV
    file.

    Parameters
    ----------
    text : str
        `exact`, `grid:N`, `corners` (of a polygon), or a path that ends in .csv.
    outline : Polygon or Ellipse
        The outline that it is the footprint of; a file's points need none.

    Returns
    -------
    PatchFootprint or PointFootprint
        The outline's exact pressure, spread evenly, or points.

    Raises
    ------
    InvalidInput
        For another word.
    DataFileError
        For a file that cannot be read as support points.

    Examples
    --------
    >>> from cyclemap.mechanics import Polygon, parse_footprint
    >>> parse_footprint("corners", Polygon(((0, 0), (1, 0), (1, 1)))).positions[2]
    (1.0, 1.0)
    """
    require_kind("word for a footprint", text, str)
    if text == "exact":
        return PatchFootprint(outline)
    if text == "corners" and isinstance(outline, Polygon):
        return corner_footprint(outline)
    if re.fullmatch(r"grid:[0-9]{1,9}", text):
        return grid_footprint(outline, int(text[5:]))
    if text.endswith(".csv"):
        return load_footprint(text)
    raise InvalidInput(
        f"footprint {text!r} is none of: exact, grid:N, corners (polygons), FILE.csv"
    )


def pressure_points(footprint: Footprint, count: int) -> PointFootprint:
    """Return support points that carry the load of a footprint: points as they are, a patch on
    `count` x `count`.

    The even part becomes the paper's grid (`grid_footprint`), weighted where it leans; the inner
    part that grid scaled; the rim about 4 `count` points along the outline, and the corners
    themselves; all then weighted with 1 + c . x, so that the centre of pressure is the patch's to
    rounding. InvalidInput where that takes negative weights, steep leans on coarse grids, and for
    a PressedFootprint, whose loads follow the orientation.
    """
    if isinstance(footprint, PointFootprint):
        return footprint
    if isinstance(footprint, PressedFootprint):
        raise InvalidInput(
            "the pressure under a floor or plate with a shape changes as the object turns: no "
            "support points have it; leave floor and plate flat"
        )
    even = grid_footprint(footprint.outline, count)
    if footprint.even_share == 1.0 and footprint.gradient == (0.0, 0.0):
        return even
    (grid, share), centroid = even.quadrature, np.array(footprint.outline.centroid)
    leaning = (grid - centroid) @ np.array(footprint.gradient)
    points, loads = [grid], [(footprint.even_share + leaning) * share]
    if footprint.inner_share:
        points.append(centroid + INNER * (grid - centroid))
        loads.append(footprint.inner_share * share)
    if footprint.rim_share:
        around, shares = _rim_points(footprint, 4 * count)
        points.append(around)
        loads.append(footprint.rim_share * shares)
    if footprint.corner_share and not isinstance(footprint.outline, Ellipse):
        points.append(footprint.outline.array)
        loads.append(
            np.full(footprint.outline.sides, footprint.corner_share / footprint.outline.sides)
        )
    places, load = np.concatenate(points), np.concatenate(loads)
    load = np.where(np.abs(load) < _NO_LOAD / len(load), 0.0, load)
    mean = load @ places / load.sum()
    lever = places - mean
    lean = np.linalg.solve(
        (load[:, None] * lever).T @ lever / load.sum(), np.subtract(footprint.centre, mean)
    )
    weights = load * (1.0 + lever @ lean)
    if weights.min() < 0.0:
        raise InvalidInput(
            "this footprint's pressure cannot be carried by support points (least load "
            f"{weights.min():.3g}): set the footprint to points, such as grid:8 or a CSV file"
        )
    return PointFootprint(tuple(map(tuple, places.tolist())), tuple(weights.tolist()))


def _rim_points(footprint: PatchFootprint, count: int) -> tuple[Array, Array]:
    """Points (k, 2), m, along the outline, and the shares (k,) of the rim's load that belong to
    them.
    """
    outline = footprint.outline
    if isinstance(outline, Ellipse):
        angle = TWO_PI * (np.arange(count) + 0.5) / count
        around = np.stack([outline.semi_x * np.cos(angle), outline.semi_y * np.sin(angle)], axis=-1)
        return around, np.full(count, 1.0 / count)
    start, arms = outline.array, side_arms(outline)
    end = np.roll(start, -1, axis=0)
    length = np.hypot(*(end - start).T)
    pieces = np.maximum(np.rint(count * length / length.sum()), 1.0)
    side = np.repeat(np.arange(len(start)), pieces.astype(int))
    along = (np.arange(side.size) - np.searchsorted(side, side) + 0.5) / pieces[side]
    points = start[side] + along[:, None] * (end - start)[side]
    return points, (arms / arms.sum() / pieces)[side]
