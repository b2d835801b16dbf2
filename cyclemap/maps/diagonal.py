"""Where an iterate crosses the diagonal: whole turns counted at cell ends, touches and breaks settled."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.scan import INSET, Cells, iterate, monotone_cells

_IDENTITY = 1e-12  # radians: |Fⁿ - id - 2πw| below this all along a cell means a whole arc of periodic points

Turns = npt.NDArray[np.int64]


@dataclass(frozen=True)
class JumpCrossing:
    """A jump of F across the diagonal: no fixed point, though orbits may gather or part there.

    theta : the break, radians; winding : the w of the crossed line θ + 2πw.
    left_turn, right_turn : F(θ) - θ - 2πw on both sides, radians.
    attracting : True when both sides move towards the break (a downward jump): it acts as an attractor.
    """

    theta: float
    winding: int
    left_turn: float
    right_turn: float
    attracting: bool


@dataclass(frozen=True, eq=False)
class DiagonalScan:
    """Cells with, at each end, how many whole turns lie below g: what counts as a crossing."""

    cells: Cells
    turn_start: Turns
    turn_end: Turns
    touch_theta: list[float] = field(default_factory=list)
    touch_winding: list[int] = field(default_factory=list)
    kink_theta: list[float] = field(default_factory=list)
    kink_winding: list[int] = field(default_factory=list)
    jumps: list[JumpCrossing] = field(default_factory=list)


def diagonal_scan(circle_map: CircleMap, period: int, resolution: int, tangency: float) -> DiagonalScan:
    """The crossings of Fⁿ - id with 2πw: touches within ``tangency`` (radians) are set apart."""
    cells = monotone_cells(circle_map, period, 1.0, resolution)
    _refuse_identity(circle_map, cells)
    scan = DiagonalScan(cells, _whole_turns(cells.g_start), _whole_turns(cells.g_end))
    _settle_touches(scan, tangency)
    _sort_breaks(scan)
    return scan


def _whole_turns(g: Array) -> Turns:
    return np.floor(g / TWO_PI).astype(np.int64)


def _refuse_identity(circle_map: CircleMap, cells: Cells) -> None:
    near = _off_turns(cells.g_start) & _off_turns(cells.g_end) & (cells.end - cells.start > 1e-6)
    if not np.any(near):
        return
    middle = 0.5 * (cells.start + cells.end)[near]
    whole = _off_turns(iterate(circle_map, middle, cells.period) - middle)
    if np.any(whole):
        first = float(middle[whole][0])
        raise InvalidInput(
            f"every point near θ = {first:.6g} has period {cells.period}: the map's iterate is a rotation by "
            "whole turns there, so they cannot be listed; perturb the map or ask for its rotation number"
        )


def _off_turns(g: Array) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(g - TWO_PI * np.round(g / TWO_PI)) <= _IDENTITY)


def _settle_touches(scan: DiagonalScan, tangency: float) -> None:
    """Record extrema within ``tangency`` of a whole turn, and count them as no crossing."""
    cells = scan.cells
    rising = _rising(cells)
    nearest = np.round(cells.g_start / TWO_PI)
    close = np.abs(cells.g_start - TWO_PI * nearest) <= tangency
    extremum = (rising != np.roll(rising, 1)) & _continuous(cells)
    for i in np.flatnonzero(extremum & close):
        w, side = int(nearest[i]), 0 if rising[i] else -1
        if not _known(scan, float(cells.start[i]), w):
            scan.touch_theta.append(float(cells.start[i]))
            scan.touch_winding.append(w)
        _absorb(scan, int(i), w, side, tangency, 1)
        _absorb(scan, int(i), w, side, tangency, -1)


def _rising(cells: Cells) -> npt.NDArray[np.bool_]:
    trend = cells.slope_start + cells.slope_end
    return np.where(trend == 0.0, cells.g_end > cells.g_start, trend > 0.0)


def _known(scan: DiagonalScan, theta: float, winding: int) -> bool:
    pairs = zip(scan.touch_theta, scan.touch_winding, strict=True)
    return any(abs(theta - other) < 1e-6 and winding == w for other, w in pairs)


def _continuous(cells: Cells) -> npt.NDArray[np.bool_]:
    """Whether g is continuous at the start of each cell (the last cell's end is the first cell's start)."""
    before, slope = np.roll(cells.g_end, 1), np.abs(np.roll(cells.slope_end, 1))
    before[0] -= cells.climb
    allowed = 1e-9 + 4.0 * INSET * (slope + np.abs(cells.slope_start))
    return np.asarray(np.abs(before - cells.g_start) <= allowed)


def _absorb(scan: DiagonalScan, node: int, winding: int, side: int, tangency: float, direction: int) -> None:
    """Count every node next to a touch that is itself within ``tangency`` as lying on the touch's side."""
    cells, size = scan.cells, scan.cells.size
    lap = round(cells.climb / TWO_PI)
    near, far = (scan.turn_start, scan.turn_end) if direction > 0 else (scan.turn_end, scan.turn_start)
    far_g = cells.g_end if direction > 0 else cells.g_start
    i = node if direction > 0 else node - 1
    for _ in range(size):
        w = winding + lap * (i // size)
        near[i % size] = w + side
        if abs(far_g[i % size] - TWO_PI * w) > tangency:
            return
        far[i % size] = w + side
        i += direction


def _sort_breaks(scan: DiagonalScan) -> None:
    """At breaks across which the count changes: a root on the kink, or a jump across the diagonal."""
    cells, lap = scan.cells, round(scan.cells.climb / TWO_PI)
    smooth = _continuous(cells)
    for i in np.flatnonzero(cells.cut):
        back = lap if i == 0 else 0
        before, after = int(scan.turn_end[i - 1]) - back, int(scan.turn_start[i])
        left, right = float(cells.g_end[i - 1]) - TWO_PI * back, float(cells.g_start[i])
        for w in range(min(before, after) + 1, max(before, after) + 1):
            theta = float(cells.start[i])
            if smooth[i]:
                scan.kink_theta.append(theta)
                scan.kink_winding.append(w)
            else:
                scan.jumps.append(JumpCrossing(theta, w, left - TWO_PI * w, right - TWO_PI * w, before > after))
