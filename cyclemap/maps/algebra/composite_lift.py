"""Lifts of one map after another: the representation behind ``compose``, ``nth_iterate`` and ``conjugate``."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from math import floor

import numpy as np

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import SIDE_STEP, CircleMap
from cyclemap.maps.lifts.lift_checks import Scalar


@dataclass(frozen=True, eq=False)
class Stage:
    """One map of the chain and, for each piece of the composite, where its argument stays.

    ``turns``, ``low``, ``high`` have shape (pieces,): on piece p the argument less 2π·turns[p] lies in
    [low[p], high[p]], between two breaks of the map; None for a map without breaks, or the first.
    """

    map: CircleMap
    turns: Array | None = None
    low: Array | None = None
    high: Array | None = None


@dataclass(frozen=True, eq=False)
class CompositeLift:
    """θ → F_k(… F_2(F_1(θ))). Whole turns are taken off between the maps and carried apart.

    So no digits are lost on long orbits, and beside a break of the composite each map is used on that side of
    its own break on which the image truly lies, however rounding moves it. ``breaks`` are sorted, in [0, 2π).
    """

    stages: tuple[Stage, ...]
    breaks: Array

    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta`` (radians, any shape)."""
        return self._walk(theta)[0]

    def derivative(self, theta: Array) -> Array:
        """Its slope by the chain rule."""
        return self._walk(theta, slope=True)[1]

    def _walk(self, theta: Array, slope: bool = False) -> tuple[Array, Array]:
        turns = np.floor(theta / TWO_PI)
        angle = np.asarray(theta - TWO_PI * turns)
        product = np.ones_like(angle)
        piece = np.searchsorted(self.breaks, angle, side="right") if self.breaks.size else None
        for place, stage in enumerate(self.stages):
            if stage.turns is not None:
                whole = stage.turns[piece]
                angle = np.clip(angle - TWO_PI * whole, stage.low[piece], stage.high[piece])  # type: ignore[index]
                turns = turns + whole
            elif place > 0:
                whole = np.floor(angle / TWO_PI)
                angle, turns = angle - TWO_PI * whole, turns + whole
            if slope:
                product = product * stage.map.derivative(angle)
            angle, turns = stage.map(angle), turns * float(stage.map.degree)
        return np.asarray(angle + TWO_PI * turns), product

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        breaks: list[float] = self.breaks.tolist()
        rows = [(stage.map.scalar(), stage.map.degree, _guards(stage)) for stage in self.stages]

        def lift(theta: float) -> float:
            turns = floor(theta / TWO_PI)
            angle = theta - TWO_PI * turns
            piece = bisect_right(breaks, angle)
            for one, degree, guards in rows:
                if guards:
                    whole, low, high = guards[piece]
                    angle = min(max(angle - TWO_PI * whole, low), high)
                else:
                    whole = floor(angle / TWO_PI)
                    angle -= TWO_PI * whole
                angle, turns = one(angle), (turns + whole) * degree
            return angle + TWO_PI * turns

        return lift


def composite_lift(maps: list[CircleMap], breaks: Array) -> CompositeLift:
    """The chain of ``maps``, the first applied first; ``breaks`` are all the breaks of the composite, [0, 2π)."""
    stages = [Stage(maps[0])]
    if breaks.size:
        edges = np.concatenate([breaks[-1:] - TWO_PI, breaks, breaks[:1] + TWO_PI])
        angle = maps[0](0.5 * (edges[:-1] + edges[1:]))
    for circle_map in maps[1:]:
        if circle_map.breaks.size == 0:
            stages.append(Stage(circle_map))
        else:
            stages.append(_guarded(circle_map, angle))
        if breaks.size:
            angle = circle_map(angle - TWO_PI * np.floor(angle / TWO_PI))
    return CompositeLift(tuple(stages), breaks)


def _guarded(circle_map: CircleMap, angle: Array) -> Stage:
    """The stage whose argument lies, piece by piece, between the breaks on both sides of ``angle``."""
    turns = np.floor(angle / TWO_PI)
    breaks = circle_map.breaks
    around = np.concatenate([breaks[-1:] - TWO_PI, breaks, breaks[:1] + TWO_PI])
    above = np.clip(np.searchsorted(around, angle - TWO_PI * turns, side="right"), 1, around.size - 1)
    margin = np.minimum(SIDE_STEP, 0.25 * (around[above] - around[above - 1]))
    return Stage(circle_map, turns, around[above - 1] + margin, around[above] - margin)


def _guards(stage: Stage) -> list[tuple[int, float, float]]:
    if stage.turns is None or stage.low is None or stage.high is None:
        return []
    return list(zip(stage.turns.astype(int).tolist(), stage.low.tolist(), stage.high.tolist(), strict=True))
