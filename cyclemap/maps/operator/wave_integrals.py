"""Integrals of waves of F(θ) times waves of θ, all at once: nodes spread on an even grid, and fast
transforms there.
"""

from __future__ import annotations

import math

import numpy as np

from cyclemap.arrays import TWO_PI, Array

# Cells of the grid that a node is spread over, at least twice as many cells as the waves need: what
# the grid aliases is exp(-18π/√2) = 4e-18 of the nodes' weight.
_SPREAD = 18
_HALF = 0.5 * _SPREAD
_BETA = math.pi * math.sqrt((1.5 * _HALF) ** 2 - 0.8)
_TWO_PI_REST = 2.4492935982947064e-16  # 2π less its double
_BLOCK = 64  # nodes and cells at most that are spread by one small matrix
_ROWS = 64  # waves of F transformed at a time; of very many nodes fewer, so as to hold
_ENTRIES = 1_000_000  # values at once


def wave_integrals(theta: Array, weight: Array, image: Array, modes: int) -> Array:
    """Return ∫ (1, cos mF, sin mF) (1, cos kθ, sin kθ) dθ for m, k = 1 to `modes`, (2·modes + 1,
    2·modes + 1).

    theta : rad, in [0, 2π], nodes (n,) at any distances.
    weight : their weights.
    image : F there, rad.

    Sums over uneven nodes by fast transforms (Dutt & Rokhlin 1993), nodes spread by the
    Kaiser-Bessel window (Fessler & Sutton 2003): about n·modes multiplications, where the plain
    sums take n·modes². Rounding is that of the nodes.
    """
    # A power of two, for fast transforms, and so many that a block of nodes does not meet itself
    # around the circle.
    cells = 1 << (max(4 * modes, _BLOCK) + 2 * _SPREAD - 1).bit_length()
    first_cell, window = _windows(theta, weight, cells)
    in_order = np.argsort(first_cell, kind="stable")
    image = image[in_order]
    blocks = _blocks(first_cell[in_order], window[in_order])

    order = np.arange(modes + 1)
    bend = (_HALF * TWO_PI * order / cells) ** 2
    root = np.sqrt(_BETA**2 - bend)
    # Of the window's transform, sinh(root) / root: by the difference from β, which rounding leaves
    # alone.
    undone = np.i0(_BETA) / np.sinh(_BETA) / _SPREAD * root * np.exp(bend / (root + _BETA))
    rows = max(1, min(_ROWS, _ENTRIES // theta.size))
    powers = np.empty((theta.size, rows), dtype=np.complex128)
    powers[:, 0] = 1.0
    step = np.exp(1j * np.mod(image, TWO_PI))
    for power in range(1, rows):
        powers[:, power] = powers[:, power - 1] * step
    jump = powers[:, -1] * step
    integrals = np.empty((2 * modes + 1, 2 * modes + 1))
    for first in range(0, modes + 1, rows):
        several = powers[:, : modes + 1 - first]
        gathered = np.zeros((cells, several.shape[1]), dtype=np.complex128)
        columns = np.ascontiguousarray(several).view(np.float64)
        for touched, nodes, spread in blocks:
            gathered[np.mod(touched, cells)] += (spread @ columns[nodes]).view(np.complex128)
        along = np.fft.fft(gathered, axis=0)
        falling = undone[:, None] * along[order]
        rising = undone[:, None] * along[-order]
        both = np.concatenate([0.5 * (rising + falling), -0.5j * (rising - falling)[1:]]).T
        last = first + len(both)
        integrals[first:last] = both.real
        # No row for the sine of order 0.
        skipped = int(first == 0)
        integrals[modes + first + skipped : modes + last] = both.imag[skipped:]
        powers *= jump[:, None]
    return integrals


def _windows(theta: Array, weight: Array, cells: int) -> tuple[Array, Array]:
    """The first of the cells that each node is spread over, and what of its weight each gets."""
    # A cell in two parts, the first so short that its multiples are exact: nodes keep all their
    # digits.
    coarse = float(np.float32(TWO_PI / cells))
    fine = ((TWO_PI - coarse * cells) + _TWO_PI_REST) / cells
    nearest = np.rint(theta * (cells / TWO_PI))
    place = ((theta - nearest * coarse) - nearest * fine) * (cells / TWO_PI)
    reach = np.arange(_SPREAD) - (_SPREAD // 2 - 1) - (place < 0.0)[:, None]
    across = 1.0 - ((reach - place[:, None]) / _HALF) ** 2
    window = np.i0(_BETA * np.sqrt(np.maximum(across, 0.0))) * (weight / np.i0(_BETA))[:, None]
    return np.mod(nearest.astype(int) + reach[:, 0], cells), window


def _blocks(first_cell: Array, window: Array) -> list[tuple[Array, slice, Array]]:
    """Of neighbouring nodes, by their first cells: cells (c,), the nodes, the matrix (c, nodes)
    that spreads them.
    """
    blocks = []
    first = 0
    while first < first_cell.size:
        last = int(np.searchsorted(first_cell, first_cell[first] + _BLOCK))
        last = min(last, first + _BLOCK)
        across = first_cell[first:last] - first_cell[first]
        spread = np.zeros((int(across[-1]) + _SPREAD, last - first))
        for offset in range(_SPREAD):
            spread[across + offset, np.arange(last - first)] = window[first:last, offset]
        blocks.append((first_cell[first] + np.arange(len(spread)), slice(first, last), spread))
        first = last
    return blocks
