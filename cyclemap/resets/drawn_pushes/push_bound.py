"""What no rule can beat: the least bias, or drag, of pushes from a library, chosen by the measured orientation too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import hstack

from cyclemap.checks import finite_array, positive_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.resets.drawn_pushes.bound_programme import solved_programme
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.least_noise.correction_programme import least_mean
from cyclemap.resets.least_noise.cycle_cells import CycleCells, noise_masses
from cyclemap.resets.least_noise.least_correction import checked_allowance

Array = NDArray[np.float64]

GAP = 1e-8  # between primal and dual, relative to the objective's scale, that counts as solved
_MOST_CELLS = 512
_STEPS, _EVEN = 200, 1e-4  # of the potential's equation, on the parts; where they end


@dataclass(frozen=True, eq=False)
class PushBound:
    """The best rule "push i with probability rule[i, j] where the orientation measured lies in cell j", on one loop.

    lower : proved: no rule has a smaller long-run bias (total variation from uniform) with a mean drag of at most
    `drag_limit` (m); or, where `allow_tv` is given, no smaller drag (m) with that bias.
    primal, dual : of the programme on N cells, what such a rule attains there, up to O(1/N) of the cells themselves.
    gap : (primal - dual) over the objective's scale, 1 for a bias, the longest mean drag for a drag. rule : (P, N).
    masses : (N,), the law before a push, cell [2πj/N, 2π(j+1)/N). tv, drag : the rule's on the cells. certificate : ψ,
    constant on each of some 65,536 parts of the circle, and price, of a metre of drag: all that `lower` rests on.
    """

    allow_tv: float | None
    drag_limit: float
    lower: float
    primal: float
    dual: float
    gap: float
    rule: Array
    masses: Array
    tv: float
    drag: float
    certificate: Array
    price: float

    @property
    def cells(self) -> int:
        """N."""
        return int(self.masses.size)

    @property
    def is_certified(self) -> bool:
        """Whether the programme is solved, |gap| ≤ 1e-8; `lower` holds anyway."""
        return abs(self.gap) <= GAP

    def push_at(self, theta: ArrayLike, share: ArrayLike) -> NDArray[np.int64]:
        """Return the numbers of the pushes (n,) that the rule takes at measured orientations (n,), rad, any turn.

        share : (n,), drawn evenly from [0, 1): which push, where the rule draws one.
        """
        angles, drawn = finite_array("theta", theta, ndim=1), finite_array("share", share, ndim=1)
        cell = (np.mod(angles, TWO_PI) * (self.cells / TWO_PI)).astype(np.int64) % self.cells
        return np.asarray(np.sum(drawn >= np.cumsum(self.rule[:-1], axis=0)[:, cell], axis=0), dtype=np.int64)


def push_bound(
    library: PushLibrary,
    scenario: int = 0,
    *,
    allow_tv: float | None = None,
    drag_limit: float | None = None,
    cells: int = 96,
) -> PushBound:
    """Bound what any rule reaches in the long run with the library's pushes on one loop, and give the best on cells.

    allow_tv : given: the least mean drag with this bias is bounded; None: the least bias within drag_limit (m; None:
    any drag). Not both. cells : 8 to 512.

    With ν_i(dθ) the law of orientation and push together the problem is linear: minimise TV(Σ ν_i, uniform) over
    ν ≥ 0 with Σ_i ∫ (P_i ψ - ψ) dν_i = 0 for all ψ, and Σ_i ∫ d_i dν_i ≤ D (occupation measures: Manne 1960; Hernández-
    Lerma & Lasserre 1996). Weights that do not look at the orientation are rules too: `lower` holds for them, with D
    their drag in the long run. Any ψ and price λ ≥ 0 prove a bound: with h = min_i (λ d_i + P_i ψ) - ψ no rule has a
    bias below ∫ min(h, inf h + 1) dθ/2π - λD, and, with λ = 1, none a drag below the least mean of h over the laws
    allowed. ψ is the programme's, refined; h is bounded below on each part by the maps' monotone pieces. Proved up to
    double rounding; the maps' own errors are counted (1e-4 is good enough), drags are linear between orientations.

    Says nothing of speed: a rule may keep a law that it hardly ever reaches. Some 0.3 s and 1 MB a map.
    Raises InvalidInput for bad values, and where no rule keeps the drag; ConvergenceError where HiGHS fails.

    >>> from cyclemap.maps import CircleMap, WrappedNormal
    >>> maps = [[CircleMap.arnold(0.0, 0.9), CircleMap.rigid(0.31)]]
    >>> library = PushLibrary.of_maps(maps, WrappedNormal(0.3), [[0.1, 0.2]], modes=16)
    >>> found = push_bound(library, drag_limit=0.12, cells=32)
    >>> found.is_certified, 0.0 < found.lower < found.tv, round(found.drag, 9)
    (True, True, 0.12)
    """
    if allow_tv is not None and drag_limit is not None:
        raise InvalidInput("give allow_tv, to bound the drag, or drag_limit, to bound the bias, not both")
    allowed = None if allow_tv is None else checked_allowance(allow_tv)
    limit = math.inf if drag_limit is None else positive_number("drag_limit", drag_limit)
    count = whole_number("cells", cells, least=8)
    if count > _MOST_CELLS:
        raise InvalidInput(f"cells is {count}: at most {_MOST_CELLS} can be solved")
    number = whole_number("scenario", scenario, least=0)
    if number >= library.scenarios:
        raise InvalidInput(f"scenario is {number}: the library has loops 0 to {library.scenarios - 1}")
    if limit < float(library.drag_lengths[number].min()):
        raise InvalidInput(f"drag_limit is {limit:g} m: every drag is longer than that")
    pushes = _PushCells(library.random_maps[number], library.drag_lengths[number], count)
    return _solved(pushes, allowed, limit)


@dataclass(frozen=True, eq=False)
class _PushCells:
    """Pushes on cells: transitions and drags, and lower bounds of what follows a push on all of the circle."""

    random_maps: Sequence[RandomMap]
    lengths: Array
    cells: int

    @cached_property
    def grids(self) -> tuple[tuple[CycleCells, ...], ...]:
        """Of every map of every push."""
        return tuple(
            tuple(CycleCells(one, self.cells, None, pushed.noise) for one in pushed.maps) for pushed in self.random_maps
        )

    @property
    def grid(self) -> CycleCells:
        """Any of them, for what they share."""
        return self.grids[0][0]

    @cached_property
    def changes(self) -> Any:
        """(N, P·N), sparse: what one cycle after each push changes in the law, on hat functions."""
        moved = []
        for pushed, grids in zip(self.random_maps, self.grids, strict=True):
            moved.append(sum(w * one.after for w, one in zip(pushed.weights, grids, strict=True)) - self.grid.before)
        return hstack(moved).tocsr()

    @cached_property
    def part_drags(self) -> Array:
        """(P, parts): drag at the middles of the parts, m, linear between even orientations."""
        even = TWO_PI * np.arange(self.lengths.shape[1]) / self.lengths.shape[1]
        return np.array([np.interp(self.grid.middles, even, row, period=TWO_PI) for row in self.lengths])

    @cached_property
    def drags(self) -> Array:
        """(P, N): mean drag over each cell, m."""
        return np.asarray(self.part_drags.reshape(len(self.lengths), self.cells, -1).mean(axis=2))

    @cached_property
    def turning(self) -> Any:
        """The spectrum of the noise's masses on the parts."""
        return np.fft.rfft(noise_masses(self.random_maps[0].noise, self.grid.parts))

    def cheapest(self, values: Array, price: float, bounded: bool) -> Array:
        """(parts,): min_i (price·d_i + P_i v), v constant on each part; at the middles, or bounded below all over them.

        E v(x + ξ) is exact at the middles; between them its slope differs by at most its second derivative times the
        width, and that is at most half of v's range times ∫|g''|, g the noise's density.
        """
        grid, least = self.grid, np.full(self.grid.parts, np.inf)
        ahead = np.fft.irfft(np.fft.rfft(values) * self.turning, values.size)
        steep = float(np.max(np.abs(np.diff(ahead, append=ahead[0])))) / grid.part_width
        steep += 0.5 * grid.part_width * float(np.ptp(values)) * _bending(self.random_maps[0].noise)
        longer = np.max(np.abs(np.diff(self.lengths, append=self.lengths[:, :1]))) * self.lengths.shape[1] / TWO_PI
        for pushed, grids, drags in zip(self.random_maps, self.grids, self.part_drags, strict=True):
            worth = price * drags
            for weight, one in zip(pushed.weights, grids, strict=True):
                worth = worth + weight * (_at_images(ahead, one) - (steep * one.image_reach if bounded else 0.0))
            np.minimum(least, worth, out=least)
        return least - 0.5 * grid.part_width * (price * longer + steep) if bounded else least


def _bending(noise: Noise) -> float:
    """A bound on ∫|g''| over the circle, g the density, per radian: √(2 Σ m⁴ κ_m²), by Cauchy and Parseval."""
    orders = np.arange(1.0, needed_modes(noise) + 1.0)
    return float(np.sqrt(2.0 * np.sum(orders**4 * noise.coefficients(orders) ** 2)))


def _at_images(values: Array, grid: CycleCells) -> Array:
    """(parts,): a function, given at the middles of the parts and linear between them, where the map takes these."""
    place = grid.images / grid.part_width - 0.5
    below = np.floor(place)
    index = below.astype(np.int64) % grid.parts
    return np.asarray(values[index] + (place - below) * (values[(index + 1) % grid.parts] - values[index]))


def least_bias(worth: Array, target: Array) -> float:
    """min over probabilities p of TV(p, target) + Σ h_j p_j: mass leaves where h exceeds its minimum by more than one.

    worth, target : (n,). Exact to rounding.

    >>> round(least_bias(np.array([0.0, 0.5, 3.0]), np.array([0.2, 0.5, 0.3])), 12)
    0.55
    """
    return float(np.dot(target, np.minimum(worth, worth.min() + 1.0)))


def _solved(pushes: _PushCells, allowed: float | None, limit: float) -> PushBound:
    found, count = solved_programme(pushes.changes, pushes.drags, allowed, limit), pushes.cells
    joint = np.maximum(found.x[: pushes.drags.size], 0.0).reshape(-1, count)
    joint = joint / joint.sum()
    masses, drag = joint.sum(axis=0), float(np.sum(joint * pushes.drags))
    tv = 0.5 * float(np.sum(np.abs(masses - 1.0 / count)))
    limited = allowed is None and math.isfinite(limit)  # the last row then tells the bias a metre of drag
    price = max(0.0, -float(found.ineqlin.marginals[-1])) if limited else float(allowed is not None)
    certificate, dual, lower = _proofs(pushes, found, allowed, limit, price)
    primal, scale = (tv, 1.0) if allowed is None else (drag, float(pushes.drags.mean(axis=1).max()))
    return PushBound(
        allow_tv=allowed,
        drag_limit=limit,
        lower=lower,
        primal=primal,
        dual=dual,
        gap=(primal - dual) / scale,
        rule=read_only(np.divide(joint, masses, out=np.full_like(joint, 1.0 / len(joint)), where=masses > 0.0)),
        masses=read_only(masses),
        tv=tv,
        drag=drag,
        certificate=read_only(certificate),
        price=price,
    )


def _proofs(
    pushes: _PushCells, found: Any, allowed: float | None, limit: float, price: float
) -> tuple[Array, float, float]:
    """The certificate on the parts, the programme's dual value, and the proved bound; both computed afresh."""
    count = pushes.cells
    potential = -np.asarray(found.eqlin.marginals[:count], dtype=np.float64)
    on_cells = np.min(price * pushes.drags + (pushes.changes.T @ potential).reshape(-1, count), axis=0)
    certificate = _certificate(pushes, potential, -np.asarray(found.ineqlin.marginals[:count]), price)
    worth = pushes.cheapest(certificate, price, bounded=True) - certificate
    return certificate, _dual(on_cells, allowed, limit, price), max(0.0, _dual(worth, allowed, limit, price))


def _certificate(pushes: _PushCells, potential: Array, excess: Array, price: float) -> Array:
    """(parts,): ψ from the programme's, by steps of ψ = min_i (price·d_i + P_i ψ) + φ, φ the price of an excess.

    Value iteration (White 1963), until a step lifts all parts alike to 1e-4 of what it adds, at most 200 times: cells
    wider than the noise leave ψ rough.
    """
    grid, added = pushes.grid, np.repeat(excess, pushes.grid.parts // pushes.cells)
    values = np.interp(grid.middles, grid.centres, potential, period=TWO_PI)
    for _ in range(_STEPS):
        lifted = pushes.cheapest(values, price, bounded=False) + added
        uneven, values = float(np.ptp(lifted - values)), lifted - lifted.mean()
        if uneven <= _EVEN * max(float(np.ptp(added)), price * float(np.ptp(pushes.drags)), 1e-12):
            break
    return np.asarray(values)


def _dual(worth: Array, allowed: float | None, limit: float, price: float) -> float:
    """The value of h on equal cells or parts: a lower bound on the objective over all rules there."""
    even = np.full_like(worth, 1.0 / worth.size)
    if allowed is not None:
        return least_mean(worth, even, allowed)
    return least_bias(worth, even) - (price * limit if math.isfinite(limit) else 0.0)
