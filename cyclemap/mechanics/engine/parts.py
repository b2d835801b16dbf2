"""What a pressure is made of: kinds of rows that C sums over, and the parts of a load.

A part has its share of the load, its rows, and the nodes that stand for them from afar, by which
Python and C know it. What else a new one needs: its share in ``PatchFootprint`` (with the centre of
pressure, and in ``pressure_points``), in ``PlatePressure`` and in ``settings.toml``, a row in
``explorer_page.py`` where some outlines cannot have it, and a part that balances it, which
``browser_tables.py`` tells the page, where its mean is not the centroid. Points that come to rest
are counted in ``contact.c`` and left out in ``pressure.c``: both know those of the corners alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.mechanics.engine.columns import Columns
from cyclemap.mechanics.footprint import INNER, PatchFootprint, PointFootprint, side_arms
from cyclemap.mechanics.outline import Ellipse, Polygon, area_quadrature

# Rows of a pressure: kind, share of the part's load, and up to eight numbers of geometry.
ROW = Columns("ROW_COLUMNS", "ROW_", "kind load geometry:8")
# Geometry of each kind: a straight side under an even load, one that leans, a line load along one;
# a point; an elliptic patch, one that leans about the level of 1; a line load along an ellipse.
_ENDS = "start_x start_y end_x end_y"
_OVAL = "semi_x semi_y x y"
ROW_KINDS = {
    "edge": Columns("EDGE_SIZE", "EDGE_", _ENDS),
    "lean": Columns("LEAN_SIZE", "LEAN_", f"{_ENDS} slope_x slope_y x y"),
    "line": Columns("LINE_SIZE", "LINE_", _ENDS),
    "point": Columns("POINT_SIZE", "POINT_", "x y"),
    "chord": Columns("CHORD_SIZE", "CHORD_", f"{_OVAL} slope_x slope_y level"),
    "arc": Columns("ARC_SIZE", "ARC_", _OVAL),
}
# Nodes that are summed in place of rows from afar: place and share of the part's load.
NODE = Columns("NODE_COLUMNS", "NODE_", "place:2 share")
# Centres of rotation farther than this, in extents in the velocity plane, are summed by Gauss's
# rule of this order: it has more digits there than closed forms (tests/mechanics/test_pressure.py
# measures both). What leans cancels more.
_FAR, _FAR_ORDER, _LEANING_FAR, _LEANING_ORDER = 8.0, 6, 3.0, 12
_LINE_ORDER = 12


@dataclass(frozen=True)
class Part:
    """A part of a pressure, in which friction is linear.

    share : the parameter that moves load from the even part to this one, None: there is none.
    balance : the part that changes along with that load, or None.
    """

    name: str
    share: str | None = None
    balance: str | None = None


# All parts in the order of their sums; the even one first, at whose expense others grow: uniform
# over the outline, or all points; uniform over the outline scaled by INNER about its centroid;
# along the outline, per length as far as a side is from the centroid (the even form's derivative by
# the scale); on the corners alike. Without a load of their own: what moves the centre of pressure
# to the centre of mass; and how that changes by the load on the corners, in that derivative alone.
PARTS = (
    *(Part("even"), Part("inner", "inner_share"), Part("rim", "rim_share")),
    *(Part("corners", "corner_share", "balance"), Part("leaning"), Part("balance")),
)
# Parameters of the pressure by which motions are differentiated.
SHARES = tuple(part.share for part in PARTS if part.share is not None)


@dataclass(frozen=True)
class Loads:
    """What C sums of a footprint, in extents.

    middle : the outline's centroid (2,); of points the origin.
    far : from where on nodes are summed; infinite where rows always hold.
    shares : of the load, by the names of parts; 0: not summed.
    rows, nodes : for unit load, of the parts that the footprint can have; nodes of polygons alone.
    """

    middle: Array
    far: float
    shares: dict[str, float]
    rows: dict[str, Array]
    nodes: dict[str, Array]


def loads_of(footprint: PatchFootprint | PointFootprint) -> Loads:
    """Return the loads of a footprint."""
    if isinstance(footprint, PointFootprint):
        points, weights = footprint.quadrature
        rows = {"even": rows_of("point", weights, points / footprint.extent)}
        return Loads(np.zeros(2), np.inf, {"even": 1.0}, rows, {})
    shares = {part.name: getattr(footprint, part.share) for part in PARTS if part.share}
    leans = any(footprint.gradient)
    shares |= {"even": footprint.even_share, "leaning": float(leans)}
    slopes = {}
    for name, slope in (("leaning", footprint.gradient), ("balance", footprint.balance)):
        if any(slope):
            slopes[name] = footprint.extent * np.array(slope)
    middle = np.array(footprint.outline.centroid) / footprint.extent
    if isinstance(footprint.outline, Ellipse):
        ellipse = footprint.outline.scaled(1.0 / footprint.extent)
        return Loads(middle, np.inf, shares, _rows_of_ellipse(ellipse, slopes), {})
    polygon = footprint.outline.scaled(1.0 / footprint.extent)
    inside = polygon.scaled(INNER, polygon.centroid) if footprint.has_frame else None
    rows = _rows_of_polygon(polygon, inside, middle, slopes)
    nodes = _nodes_of_polygon(polygon, inside, middle, slopes, leans)
    return Loads(middle, _LEANING_FAR if leans else _FAR, shares, rows, nodes)


def _rows_of_ellipse(ellipse: Ellipse, slopes: Mapping[str, Array]) -> dict[str, Array]:
    """Patches, without a level where they lean, and a line along the ellipse."""
    oval = np.array((ellipse.semi_x, ellipse.semi_y, *ellipse.centroid))
    inner = oval * (INNER, INNER, 1.0, 1.0)
    rows = {"rim": rows_of("arc", 1.0, [oval])}
    for name, own in (("even", oval), ("inner", inner)):
        rows[name] = rows_of("chord", 1.0, [(*own, 0.0, 0.0, 1.0)])
    for name, slope in slopes.items():
        rows[name] = rows_of("chord", 1.0, [(*oval, *slope, 0.0)])
    return rows


def _rows_of_polygon(
    polygon: Polygon, inside: Polygon | None, middle: Array, slopes: Mapping[str, Array]
) -> dict[str, Array]:
    """Sides, also such as lean, lines along them, and corners."""
    ends = _ends_of(polygon)
    rows = {
        "even": rows_of("edge", 1.0 / polygon.area, ends),
        "corners": rows_of("point", 1.0 / polygon.sides, polygon.array),
    }
    if inside is not None:
        rows["inner"] = rows_of("edge", 1.0 / inside.area, _ends_of(inside))
        rows["rim"] = rows_of("line", _arms(polygon), ends)
    for name, slope in slopes.items():
        lean = np.tile((*slope, *middle), (len(ends), 1))
        rows[name] = rows_of("lean", 1.0 / polygon.area, np.hstack([ends, lean]))
    return rows


def _nodes_of_polygon(
    polygon: Polygon,
    inside: Polygon | None,
    middle: Array,
    slopes: Mapping[str, Array],
    leans: bool,
) -> dict[str, Array]:
    """Those of the means over both areas and along every side, and the corners themselves."""
    places, weights = area_quadrature(polygon, _LEANING_ORDER if leans else _FAR_ORDER)
    alike = np.full(polygon.sides, 1.0 / polygon.sides)
    nodes = {
        "even": np.column_stack([places, weights]),
        "corners": np.column_stack([polygon.array, alike]),
    }
    if inside is not None:
        nodes["inner"] = np.column_stack(area_quadrature(inside))
        node, weight = np.polynomial.legendre.leggauss(_LINE_ORDER)
        along, ends = (node[:, None, None] + 1.0) / 2.0, _ends_of(polygon)
        spread = ((1.0 - along) * ends[:, :2] + along * ends[:, 2:]).reshape(-1, 2)
        shares = np.outer(weight / 2.0, _arms(polygon)).ravel()
        nodes["rim"] = np.column_stack([spread, shares])
    for name, slope in slopes.items():
        nodes[name] = np.column_stack([places, weights * ((places - middle) @ slope)])
    return nodes


def rows_of(kind: str, load: ArrayLike, geometry: ArrayLike) -> Array:
    """Return rows of one kind: shares of the part's load, and geometry (n, k), k up to eight."""
    numbers = np.asarray(geometry, dtype=float)
    rows = np.zeros((len(numbers), ROW.size))
    columns = ROW.columns_of(rows)
    columns.kind[:] = tuple(ROW_KINDS).index(kind)
    columns.load[:] = load
    columns.geometry[:, : numbers.shape[1]] = numbers
    return rows


def _ends_of(polygon: Polygon) -> Array:
    """Both ends (n, 4) of every side."""
    return np.hstack([polygon.array, np.roll(polygon.array, -1, axis=0)])


def _arms(polygon: Polygon) -> Array:
    arms = side_arms(polygon)
    return np.asarray(arms / arms.sum())
