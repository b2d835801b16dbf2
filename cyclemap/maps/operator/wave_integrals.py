"""Waves of θ and of F(θ), and integrals of their products, all at once: nodes spread on an even
grid, and fast transforms there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole

# Cells of the grid that a node is spread over, at least twice as many cells as the waves need: what
# the grid aliases is exp(-18π/√2) = 4e-18 of the nodes' weight.
_SPREAD = 18
_HALF = 0.5 * _SPREAD
_BETA = math.pi * math.sqrt((1.5 * _HALF) ** 2 - 0.8)
_TWO_PI_REST = 2.4492935982947064e-16  # 2π less its double
_BLOCK = 64  # nodes and cells at most that are spread by one small matrix


def waves(theta: Array, modes: int) -> Array:
    """1, cos mθ (m = 1..modes), sin mθ at the angles ``theta`` (shape (n,)), as rows: shape
    (2·modes + 1, n).
    """
    powers = np.empty((modes + 1, theta.size), dtype=np.complex128)
    powers[0] = 1.0
    powers[1] = np.exp(1j * np.mod(theta, TWO_PI))
    filled = 2
    while filled <= modes:
        # Orders filled .. 2·filled - 2 are the known ones times the highest known power.
        more = min(filled - 1, modes + 1 - filled)
        np.multiply(powers[1 : more + 1], powers[filled - 1], out=powers[filled : filled + more])
        filled += more
    return np.concatenate([powers.real, powers[1:].imag])


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
    gathered = np.zeros((cells, 2 * modes + 1))
    for nodes, touched, spread in _blocks(theta, weight, cells):
        gathered[touched] += spread @ waves(image[nodes], modes).T
    # Of the window's transform, sinh(root) / root: by the difference from β, which rounding leaves
    # alone.
    bend = (_HALF * TWO_PI * np.arange(modes + 1) / cells) ** 2
    root = np.sqrt(_BETA**2 - bend)
    undone = np.i0(_BETA) / np.sinh(_BETA) / _SPREAD * root * np.exp(bend / (root + _BETA))
    integrals = np.empty((2 * modes + 1, 2 * modes + 1))
    for first in range(0, 2 * modes + 1, _BLOCK):
        several = slice(first, first + _BLOCK)
        along = undone[:, None] * np.fft.rfft(gathered[:, several], axis=0)[: modes + 1]
        integrals[several] = np.concatenate([along.real, -along.imag[1:]]).T
    return integrals


def _blocks(theta: Array, weight: Array, cells: int) -> Iterator[tuple[Whole, Whole, Array]]:
    """Of neighbouring nodes: which they are, the cells (c,) that they are spread over, and the
    matrix (c, nodes) that spreads them.
    """
    first_cell, window = _windows(theta, weight, cells)
    order = np.argsort(first_cell, kind="stable")
    first_cell = first_cell[order]
    first = 0
    while first < theta.size:
        last = int(np.searchsorted(first_cell, first_cell[first] + _BLOCK))
        nodes = order[first : min(last, first + _BLOCK)]
        across = first_cell[first : first + nodes.size] - first_cell[first]
        spread = np.zeros((int(across[-1]) + _SPREAD, nodes.size))
        for offset in range(_SPREAD):
            spread[across + offset, np.arange(nodes.size)] = window[nodes, offset]
        yield nodes, np.mod(first_cell[first] + np.arange(len(spread)), cells), spread
        first += nodes.size


def _windows(theta: Array, weight: Array, cells: int) -> tuple[Whole, Array]:
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
