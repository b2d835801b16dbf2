"""What a pressure is made of: kinds of rows that C sums over, and the parts of a load, each a class
of its own.

A part that is added here has its load, its rows, its nodes and the name of its share; C and Python
ask for no more.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.mechanics.engine.columns import Columns
from cyclemap.mechanics.footprint import (
    INNER,
    Footprint,
    PatchFootprint,
    PointFootprint,
    side_arms,
)
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
class Ground:
    """A footprint in units of its extent, as its parts ask for it."""

    footprint: Footprint

    @cached_property
    def patch(self) -> PatchFootprint | None:
        """The footprint, None where it consists of points."""
        return self.footprint if isinstance(self.footprint, PatchFootprint) else None

    @cached_property
    def outline(self) -> Polygon | Ellipse | None:
        """Its outline, None where it consists of points."""
        return self.patch.outline.scaled(1.0 / self.footprint.extent) if self.patch else None

    @cached_property
    def polygon(self) -> Polygon | None:
        """Its outline where that is a polygon, else None."""
        return self.outline if isinstance(self.outline, Polygon) else None

    @cached_property
    def middle(self) -> Array:
        """The outline's centroid (2,); of points the origin."""
        if self.patch is None:
            return np.zeros(2)
        return np.array(self.patch.outline.centroid) / self.footprint.extent

    def slope(self, name: str) -> Array:
        """Slope (2,) of a patch by its name: `gradient` of what leans, `balance` of what the load
        on the corners makes lean.
        """
        return self.footprint.extent * np.asarray(getattr(self.patch, name, (0.0, 0.0)))

    @cached_property
    def leans(self) -> bool:
        """Whether the pressure has a slope."""
        return bool(np.any(self.slope("gradient") != 0.0))

    @property
    def far(self) -> float:
        """From where on nodes are summed, extents; infinite where rows always hold."""
        if self.polygon is None:
            return np.inf
        return _LEANING_FAR if self.leans else _FAR

    @cached_property
    def area_nodes(self) -> Array:
        """Nodes of the mean over a polygon."""
        assert self.polygon is not None
        order = _LEANING_ORDER if self.leans else _FAR_ORDER
        return np.column_stack(area_quadrature(self.polygon, order))

    @cached_property
    def inside(self) -> Polygon | None:
        """The outline of the inner part of a polygon, None where that cannot be."""
        if self.polygon is None or self.patch is None or not self.patch.has_frame:
            return None
        return self.polygon.scaled(INNER, self.polygon.centroid)


class Part:
    """A part of a pressure, in which friction is linear: its name; here one that is nothing, on
    which others build.

    share : the parameter that moves load from the even part to this one, None: there is none.
    balance : the part that changes along with that load, or None.
    """

    name: ClassVar[str] = ""
    share: ClassVar[str | None] = None
    balance: ClassVar[str | None] = None

    def load(self, ground: Ground) -> float:
        """Return its share of the load; 0: it is not summed."""
        return float(getattr(ground.patch, self.share)) if self.share and ground.patch else 0.0

    def rows(self, ground: Ground) -> Array:
        """Return its rows, for unit load; none: a footprint that cannot have it."""
        return no_rows()

    def nodes(self, ground: Ground) -> Array:
        """Return its nodes, which polygons have."""
        return np.zeros((0, NODE.size))


class Even(Part):
    """Uniform over the outline; or all the points."""

    name = "even"

    def load(self, ground: Ground) -> float:
        """What no other part has."""
        return ground.patch.even_share if ground.patch else 1.0

    def rows(self, ground: Ground) -> Array:
        """Sides, one patch, or points."""
        if isinstance(ground.footprint, PointFootprint):
            points, weights = ground.footprint.quadrature
            return rows_of("point", weights, points / ground.footprint.extent)
        if isinstance(ground.outline, Ellipse):
            return _patch(ground.outline, ground.middle)
        assert ground.polygon is not None
        return rows_of("edge", 1.0 / ground.polygon.area, ends_of(ground.polygon))

    def nodes(self, ground: Ground) -> Array:
        """Those of the mean over the area."""
        return ground.area_nodes if ground.polygon else super().nodes(ground)


class Inner(Part):
    """Uniform over the outline scaled by INNER about its centroid."""

    name = "inner"
    share = "inner_share"

    def rows(self, ground: Ground) -> Array:
        """Sides of the inner outline, or one patch."""
        if isinstance(ground.outline, Ellipse):
            return _patch(ground.outline.scaled(INNER), ground.middle)
        if ground.inside is None:
            return no_rows()
        return rows_of("edge", 1.0 / ground.inside.area, ends_of(ground.inside))

    def nodes(self, ground: Ground) -> Array:
        """Those of the mean over the inner area."""
        if ground.inside is None:
            return super().nodes(ground)
        return np.column_stack(area_quadrature(ground.inside))


class Rim(Part):
    """Along the outline, per length as far as a side is from the centroid: the even form's
    derivative by the scale.
    """

    name = "rim"
    share = "rim_share"

    def rows(self, ground: Ground) -> Array:
        """A line along every side, or one along the ellipse."""
        outline = ground.outline
        if isinstance(outline, Ellipse):
            return rows_of("arc", 1.0, [(outline.semi_x, outline.semi_y, *ground.middle)])
        if ground.inside is None or ground.polygon is None:
            return no_rows()
        return rows_of("line", _arms(ground.polygon), ends_of(ground.polygon))

    def nodes(self, ground: Ground) -> Array:
        """Gauss's along every side."""
        if ground.inside is None or ground.polygon is None:
            return super().nodes(ground)
        node, weight = np.polynomial.legendre.leggauss(_LINE_ORDER)
        along, ends = (node[:, None, None] + 1.0) / 2.0, ends_of(ground.polygon)
        spread = ((1.0 - along) * ends[:, :2] + along * ends[:, 2:]).reshape(-1, 2)
        return np.column_stack([spread, np.outer(weight / 2.0, _arms(ground.polygon)).ravel()])


class Corners(Part):
    """On the vertices of a polygon alike."""

    name = "corners"
    share = "corner_share"
    balance = "balance"

    def rows(self, ground: Ground) -> Array:
        """The vertices as points."""
        if ground.polygon is None:
            return no_rows()
        return rows_of("point", 1.0 / ground.polygon.sides, ground.polygon.array)

    def nodes(self, ground: Ground) -> Array:
        """The vertices themselves."""
        if ground.polygon is None:
            return super().nodes(ground)
        count = ground.polygon.sides
        return np.column_stack([ground.polygon.array, np.full(count, 1.0 / count)])


class Leaning(Part):
    """No load of its own: it moves the centre of pressure to the centre of mass."""

    name = "leaning"
    slope: ClassVar[str] = "gradient"

    def load(self, ground: Ground) -> float:
        """As it is, where the footprint leans."""
        return float(ground.leans)

    def rows(self, ground: Ground) -> Array:
        """Sides that lean, or one patch without a level."""
        slope = ground.slope(self.slope)
        if not np.any(slope != 0.0):
            return no_rows()
        if isinstance(ground.outline, Ellipse):
            return _patch(ground.outline, ground.middle, slope, 0.0)
        assert ground.polygon is not None
        ends = ends_of(ground.polygon)
        lean = np.tile((*slope, *ground.middle), (len(ends), 1))
        return rows_of("lean", 1.0 / ground.polygon.area, np.hstack([ends, lean]))

    def nodes(self, ground: Ground) -> Array:
        """Those of the mean over the area, weighted."""
        slope = ground.slope(self.slope)
        if ground.polygon is None or not np.any(slope != 0.0):
            return super().nodes(ground)
        places, shares = ground.area_nodes[:, :2], ground.area_nodes[:, 2]
        return np.column_stack([places, shares * ((places - ground.middle) @ slope)])


class Balance(Leaning):
    """How what leans changes by the load on the corners: in no sum, but in that derivative."""

    name = "balance"
    slope = "balance"

    def load(self, ground: Ground) -> float:
        """None."""
        return 0.0


# All parts in the order of their sums; the even one first, at whose expense others grow.
PARTS: tuple[Part, ...] = (Even(), Inner(), Rim(), Corners(), Leaning(), Balance())
# Parameters of the pressure by which motions are differentiated.
SHARES = tuple(part.share for part in PARTS if part.share is not None)


def rows_of(kind: str, load: ArrayLike, geometry: ArrayLike) -> Array:
    """Return rows of one kind: shares of the part's load, and geometry (n, k), k up to eight."""
    numbers = np.asarray(geometry, dtype=float)
    rows = np.zeros((len(numbers), ROW.size))
    columns = ROW.columns_of(rows)
    columns.kind[:] = tuple(ROW_KINDS).index(kind)
    columns.load[:] = load
    columns.geometry[:, : numbers.shape[1]] = numbers
    return rows


def no_rows() -> Array:
    """Return no rows."""
    return np.zeros((0, ROW.size))


def ends_of(polygon: Polygon) -> Array:
    """Return both ends (n, 4) of every side."""
    return np.hstack([polygon.array, np.roll(polygon.array, -1, axis=0)])


def _arms(polygon: Polygon) -> Array:
    arms = side_arms(polygon)
    return np.asarray(arms / arms.sum())


def _patch(
    outline: Ellipse, middle: Array, slope: ArrayLike = (0.0, 0.0), level: float = 1.0
) -> Array:
    return rows_of(
        "chord", 1.0, [(outline.semi_x, outline.semi_y, *middle, *np.asarray(slope), level)]
    )
