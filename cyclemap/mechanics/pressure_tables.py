"""What the engine reads of a footprint: its pressure as pieces that it sums over, in extents of the footprint."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cyclemap.arrays import Array
from cyclemap.mechanics.footprint import INNER, Footprint, PointFootprint, side_arms
from cyclemap.mechanics.outline import Ellipse, Polygon, area_quadrature

# Kinds of pieces, and the parts of a pressure, in the order of pressure.c.
EDGE, LEAN, LINE, POINT, CHORD, ARC = map(float, range(6))
PARTS = ("even", "inner", "rim", "corners", "leaning", "balance")
ROW_COLUMNS = 10
# Centres of rotation farther than this, in extents in the velocity plane, are summed by Gauss's rule of this order: it
# has more digits there than closed forms (tests/mechanics/test_pressure.py measures both). What leans cancels more.
FAR, FAR_ORDER, LEANING_FAR, LEANING_ORDER = 8.0, 6, 3.0, 12
_LINE_ORDER = 12


@dataclass(frozen=True, eq=False)
class PressureTables:
    """Pieces (n, ROW_COLUMNS) and nodes (m, 3: x, y, share), part by part: part i has rows first_row[i] to [i + 1].

    load (6,): of each part. middle (2,): the outline's centroid. far: see FAR; infinite where pieces always hold.
    """

    load: tuple[float, ...]
    middle: tuple[float, float]
    far: float
    rows: Array
    first_row: tuple[int, ...]
    nodes: Array
    first_node: tuple[int, ...]


@lru_cache(maxsize=256)
def pressure_tables(footprint: Footprint) -> PressureTables:
    """Return the tables of a footprint."""
    size = footprint.extent
    if isinstance(footprint, PointFootprint):
        points, weights = footprint.quadrature
        bare = [_row(POINT, share, *place) for place, share in zip(points / size, weights, strict=True)]
        return _tables((1.0, *(0.0,) * 5), (0.0, 0.0), np.inf, [bare, [], [], [], [], []], [])
    outline, middle = footprint.outline.scaled(1.0 / size), np.array(footprint.outline.centroid) / size
    leaning, balance = (size * np.asarray(slope) for slope in (footprint.gradient, footprint.balance))
    load = (footprint.even_share, footprint.inner_share, footprint.rim_share, footprint.corner_share)
    whole = (*load, float(np.any(leaning != 0.0)), 0.0)
    if isinstance(outline, Ellipse):
        inside = outline.shrunk(INNER)
        rows: list[list[Array]] = [
            [_row(CHORD, 1.0, outline.semi_x, outline.semi_y, *middle, 0.0, 0.0, 1.0)],
            [_row(CHORD, 1.0, inside.semi_x, inside.semi_y, *middle, 0.0, 0.0, 1.0)],
            [_row(ARC, 1.0, outline.semi_x, outline.semi_y, *middle)],
            [],
            [_row(CHORD, 1.0, outline.semi_x, outline.semi_y, *middle, *leaning, 0.0)],
            [],
        ]
        return _tables(whole, tuple(middle), np.inf, rows, [])
    far, order = (LEANING_FAR, LEANING_ORDER) if whole[4] else (FAR, FAR_ORDER)
    framed = footprint.has_frame
    return _tables(whole, tuple(middle), far, *_polygon(outline, middle, leaning, balance, order, framed))


def _polygon(
    outline: Polygon, middle: Array, leaning: Array, balance: Array, order: int, framed: bool
) -> tuple[list[list[Array]], list[Array]]:
    corners, inside = outline.array, outline.shrunk(INNER)
    ends = np.hstack([corners, np.roll(corners, -1, axis=0)])
    rows: list[list[Array]] = [[_row(EDGE, 1.0 / outline.area, *pair) for pair in ends]]
    points, shares = area_quadrature(outline, order)
    lever = points - middle
    nodes = [np.column_stack([points, shares])]
    if framed:
        inner = np.hstack([inside.array, np.roll(inside.array, -1, axis=0)])
        # A line's load goes with the distance of its side from the centroid: the even form's derivative by the scale.
        arms = side_arms(outline)
        arms /= arms.sum()
        rows.append([_row(EDGE, 1.0 / inside.area, *pair) for pair in inner])
        rows.append([_row(LINE, arm, *pair) for pair, arm in zip(ends, arms, strict=True)])
        node, weight = np.polynomial.legendre.leggauss(_LINE_ORDER)
        along = (node[:, None, None] + 1.0) / 2.0
        spread = ((1.0 - along) * ends[:, :2] + along * ends[:, 2:]).reshape(-1, 2)
        nodes.append(np.column_stack(area_quadrature(inside, order)))
        nodes.append(np.column_stack([spread, np.outer(weight / 2.0, arms).ravel()]))
    else:
        rows += [[], []]
        nodes += [np.zeros((0, 3))] * 2
    rows.append([_row(POINT, 1.0 / len(corners), *corner) for corner in corners])
    nodes.append(np.column_stack([corners, np.full(len(corners), 1.0 / len(corners))]))
    for slope in (leaning, balance):
        given = any(slope != 0.0)
        rows.append([_row(LEAN, 1.0 / outline.area, *pair, *slope, *middle) for pair in ends] if given else [])
        nodes.append(np.column_stack([points, shares * (lever @ slope)]) if given else np.zeros((0, 3)))
    return rows, nodes


def _row(kind: float, load: float, *geometry: float) -> Array:
    return np.array((kind, load, *geometry, *(0.0,) * (ROW_COLUMNS - 2 - len(geometry))))


def _tables(
    load: tuple[float, ...], middle: tuple[float, ...], far: float, rows: list[list[Array]], nodes: list[Array]
) -> PressureTables:
    first_row = np.cumsum([0, *map(len, rows)])
    first_node = np.cumsum([0, *map(len, nodes)]) if nodes else np.zeros(len(PARTS) + 1, int)
    return PressureTables(
        load,
        (float(middle[0]), float(middle[1])),
        far,
        np.array([row for part in rows for row in part]),
        tuple(first_row.tolist()),
        np.concatenate(nodes) if nodes else np.zeros((0, 3)),
        tuple(first_node.tolist()),
    )
