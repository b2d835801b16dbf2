"""Outlines that are smooth curves cut into short straight sides, and the curve through their vertices."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from cyclemap.arrays import Array
from cyclemap.mechanics.outline import Outline, Polygon

# A polygon none of whose corners turns by more than this (rad) is a curve cut up: those of objects turn by far more.
LARGEST_BEND = math.radians(20.0)
# Pieces that each side is cut into; what the curve bends within one is no error, for its normal is interpolated.
_FINER = 8


@dataclass(frozen=True, eq=False)
class CutCurve:
    """A smooth closed curve, finely sampled: places (n, 2), m, counter-clockwise, and the outward normals (n, 2) there.

    The last place is the first again.
    """

    place: Array
    normal: Array

    def nearest(self, rod: Array) -> tuple[float, Array, Array]:
        """Return the signed distance (m) of a place (2,) from the curve, its foot on it, and the normal at the foot.

        The distance is negative inside.
        """
        first, edge = self.place[:-1], np.diff(self.place, axis=0)
        share = np.clip(((rod - first) * edge).sum(1) / (edge * edge).sum(1), 0.0, 1.0)
        index = int(((rod - first - share[:, None] * edge) ** 2).sum(1).argmin())
        foot = first[index] + share[index] * edge[index]
        mixed = (1.0 - share[index]) * self.normal[index] + share[index] * self.normal[index + 1]
        normal = mixed / np.hypot(*mixed)
        return float((rod - foot) @ normal), foot, normal


def is_cut_curve(outline: Outline) -> bool:
    """Whether an outline is a polygon that stands for a smooth curve: no corner of it turns by more than 20 degrees.

    >>> angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    >>> is_cut_curve(Polygon(np.column_stack([np.cos(angle), np.sin(angle)])))
    True
    """
    if not isinstance(outline, Polygon):
        return False
    edge = np.roll(outline.array, -1, axis=0) - outline.array
    heading = np.arctan2(edge[:, 1], edge[:, 0])
    turn = np.remainder(np.diff(heading, append=heading[:1]) + np.pi, 2.0 * np.pi) - np.pi
    return bool(np.abs(turn).max() <= LARGEST_BEND)


@cache
def cut_curve(outline: Polygon) -> CutCurve:
    """Return the periodic cubic spline through a polygon's vertices, by the length of its sides."""
    from scipy.interpolate import CubicSpline

    corners = outline.points(0)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    spline = CubicSpline(length, corners, bc_type="periodic")
    at = np.interp(np.arange(_FINER * outline.sides + 1) / _FINER, np.arange(outline.sides + 1), length)
    tangent = spline(at, 1)
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]]) / np.hypot(*tangent.T)[:, None]
    return CutCurve(spline(at), normal)
