"""Mean passage times and hitting probabilities of a noisy circle map, and how they change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import ELIMINATION, SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.bounded_noise import UniformNoise
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.passages.killed_chain import (
    Arc,
    KilledChain,
    arc_chain,
    arc_ends,
    arcs_between,
    into_arc,
    killed_chain,
    required_inside,
)

Tangent = Callable[[Array], Array]

LONGEST = 1e300  # cycles: a longer passage is given as inf
_GOOD = 1e-9  # relative error bound with which few nodes will do
_ACCEPTED = 1e-6  # relative error bound that is accepted at all
_BESIDE = 0.01  # share of what the map's own error makes uncertain, below which more nodes are of no use
_STRETCH = 1.3  # bandwidth of the second solution of a response over that of the first
_MORE = 1.4  # bandwidth of the second attempt over that of the first


def mean_passage_time(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc: Arc,
    *,
    lifted: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Estimate:
    """Mean number of cycles until the path θ' = F(θ) + ξ from ``start`` is first outside ``arc``.

    start : radians, inside the arc. arc : (start, end), counter-clockwise, radians, length in (0, 2π).
    lifted : False counts positions mod 2π, so that a step of a whole turn comes back; True follows the
        path on the real line, where the arc may be a whole turn.
    progress : called with the fraction done, at most, where uniform noise is resolved, which takes seconds where it
        is narrow. An exception from it ends the work.

    T(x) = 1 + ∫_arc g(y - F(x)) T(y) dy, g the noise's density, on Gauss-Legendre nodes with panels
    between the map's breaks and samples (Nyström). The system is eliminated without subtraction from the
    exactly known chances of leaving (Grassmann, Taksar & Heyman 1985), so that even 1e100 cycles keep
    their digits; inf above 1e300, where ``log10_passage_time`` goes on. ``UniformNoise`` has a method of its own.

    ``error_bound``: with r the residual of the interpolant on twice as many nodes, rounding
    included, Φ = (I - K)⁻¹|r| bounds the error, since K is positive (Collatz 1952). That comparison is
    proved; r and Φ are measured on nodes. The map's ``max_error`` is included to first order. Where an arc
    holds several deep wells the residual drowns in rounding; the bound is then ten times the difference
    from a solution on other nodes. ConvergenceError when the bound, ``max_error`` apart, exceeds 1e-6 of the time.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> time = mean_passage_time(stuck, WrappedNormal(0.1 * np.pi), 0.77278, (0.0, np.pi / 2))
    >>> round(time, 3), time.error_bound < 1e-9
    (44.624, True)
    """
    ends = arc_ends(arc, "arc", whole=lifted)
    inside = required_inside(start, ends)
    if isinstance(noise, UniformNoise):
        from cyclemap.maps.passages.uniform_passage import uniform_passage_time

        return uniform_passage_time(circle_map, noise, inside, ends, lifted, progress=progress)
    make = partial(arc_chain, circle_map, noise, ends, lifted)
    return _certified(make, inside, 1.0, np.zeros(2 if lifted else 1), "mean passage time")


def hitting_probability(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc_a: Arc,
    arc_b: Arc,
    *,
    progress: Callable[[float], None] | None = None,
) -> Estimate:
    """Probability that the path from ``start`` is in ``arc_a`` at an earlier cycle than in ``arc_b``.

    The arcs are (start, end) pairs, counter-clockwise, radians, and must not overlap; a start inside one of them gives
    1 or 0. u(x) = P(F(x) + ξ in a) + ∫ over the rest of g(y - F(x)) u(y) dy, solved and bounded as in
    ``mean_passage_time``, with its ``progress``: small chances keep their digits too. ConvergenceError also when
    neither arc is reached within 1e300 cycles.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> even = hitting_probability(CircleMap.rigid(0.0), WrappedNormal(0.3), 0.0, (1.0, 2.0), (-2.0, -1.0))
    >>> round(even, 9), even.holds(0.5)
    (0.5, True)
    """
    a, b = arc_ends(arc_a, "arc_a"), arc_ends(arc_b, "arc_b")
    rest = arcs_between(a, b)
    theta = finite_number("start", start)
    for ends, answer in ((a, 1.0), (b, 0.0)):
        if into_arc(theta, ends) is not None:
            return Estimate(answer, 0.0)
    if isinstance(noise, UniformNoise):
        from cyclemap.maps.passages.uniform_passage import uniform_hitting_probability

        return uniform_hitting_probability(circle_map, noise, theta, a, b, progress=progress)
    make = partial(killed_chain, circle_map, noise, rest, (a, b), False)
    found = _certified(make, theta, 0.0, np.array([1.0, 0.0]), "hitting probability")
    if not np.isfinite(found):
        raise ConvergenceError("neither arc is reached within 1e300 cycles: raise the noise or widen the arcs")
    return Estimate(min(found, 1.0), found.error_bound)


def _certified(make: Callable[..., KilledChain], start: float, each: float, at: Array, name: str) -> Estimate:
    """The expectation at ``start``: on few nodes first, on more where their bound is not good."""
    for every_sample, stretch in (False, 1.0), (True, _MORE):
        chain = make(every_sample=every_sample, stretch=stretch)
        expected = chain.expected(each, at)
        if not abs(expected.top) < LONGEST:
            return Estimate(np.inf, np.inf)
        value, (own, from_map) = expected.value_at(start), expected.error_bounds(start)
        own += SOLUTION * abs(value)
        if own <= max(_GOOD * abs(value), min(_ACCEPTED * abs(value), _BESIDE * from_map)):
            return Estimate(value, own + from_map)
    other = make(every_sample=True, stretch=1.0).expected(each, at).value_at(start)
    own = min(own, 10.0 * abs(other - value) + ELIMINATION * abs(value))
    if not own <= _ACCEPTED * abs(value):
        raise ConvergenceError(
            f"the {name} came out as {value:.9g} with error bound {own:.3g}: the map is too rough for so small a "
            "noise; raise the noise or give the map's breaks"
        )
    return Estimate(value, own + from_map)


# -- how a passage time changes ------------------------------------------------------------------------------


@dataclass(frozen=True)
class PassageResponse:
    """Made by ``passage_response``: a mean passage time in cycles and its derivatives.

    to_map : per unit of the parameter whose ``tangent`` was given, None without one. to_noise : per unit of the noise's
    own parameter. to_start : per radian of the start. to_arc_start, to_arc_end : per radian of the arc's ends.
    """

    time: Estimate
    to_map: Estimate | None
    to_noise: Estimate
    to_start: Estimate
    to_arc_start: Estimate
    to_arc_end: Estimate


def passage_response(
    circle_map: CircleMap, noise: Noise, start: float, arc: Arc, tangent: Tangent | None = None, *, lifted: bool = False
) -> PassageResponse:
    """The mean passage time of ``mean_passage_time`` and its derivatives.

    tangent : ∂F/∂p as a vectorised callable of θ, radians a unit of p. For a map with jumps, p must leave the
        jumps where they are. The other arguments are those of ``mean_passage_time``.

    T = 1 + K T gives δT = (I - K)⁻¹ δK T (first-order perturbation, Kato 1966): one more solution with the
    same elimination for each. The derivatives of K's constant part are taken from the chances of leaving, so that even
    those of 1e100 cycles keep their digits. ``error_bound``: three times the difference from a solution on other
    nodes and 1e-13 of the terms; measured, and without the map's ``max_error``.

    Raises InvalidInput as ``mean_passage_time``, for a tangent of the wrong shape, and for ``UniformNoise``, whose
    density has no slope; ConvergenceError for passages beyond 1e300 cycles.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> found = passage_response(stuck, WrappedNormal(0.3), 0.77, (0.0, 1.6), lambda theta: -np.sin(theta))
    >>> found.to_noise < 0 < found.to_arc_end  # more noise shortens the passage, a longer arc lengthens it
    True
    """
    ends = arc_ends(arc, "arc", whole=lifted)
    inside = required_inside(start, ends)
    (first, sizes), (second, _) = (
        _responses(arc_chain(circle_map, noise, ends, lifted, stretch=stretch), inside, tangent)
        for stretch in (1.0, _STRETCH)
    )
    bounds = 3.0 * np.abs(first - second) + ELIMINATION * sizes
    time, to_map, *others = (Estimate(value, bound) for value, bound in zip(first, bounds, strict=True))
    return PassageResponse(time, None if tangent is None else to_map, *others)


def _responses(chain: KilledChain, start: float, tangent: Tangent | None) -> tuple[Array, Array]:
    """T and its derivatives by map, noise, start and the arc's ends; and the sums of their terms' sizes."""
    expected = chain.expected(1.0, np.zeros(len(chain.exits)))
    if not abs(expected.top) < LONGEST:
        raise ConvergenceError("the passage takes more than 1e300 cycles: raise the noise or shorten the arc")
    here, density = np.array([start]), chain.noise.line_density if chain.lifted else chain.noise.density
    points, images = np.append(chain.theta, start), np.append(chain.images, chain.map(here))
    slope = expected.map_slope(images, chain, expected.change)
    pushed = np.zeros_like(points) if tangent is None else np.asarray(tangent(points), dtype=np.float64)
    if pushed.shape != points.shape or not np.all(np.isfinite(pushed)):
        raise InvalidInput(
            f"tangent turns shape {points.shape} into {pushed.shape}: it must act entry by entry, finite"
        )
    by_noise = chain.transition_rates(images) @ expected.change
    by_noise -= expected.top * chain.departure_rates(images).sum(axis=0)
    # Moving an end outward turns chances of leaving into chances of going to that end.
    low, high = (density(end - images) * expected.value_at(end) for end in chain.arcs[0])
    table, last_moves = np.stack([slope * pushed, by_noise, -low, high], axis=1), chain.transitions(images[-1:])[0]
    # (I - K)⁻¹ of each source at the nodes and, last, at the start: its value there.
    spread, size = (last_moves @ chain.elimination.solve(part[:-1]) + part[-1] for part in (table, np.abs(table)))
    to_start, value = float(slope[-1] * chain.map.derivative(here)[0]), expected.value_at(start)
    return np.array([value, *spread[:2], to_start, *spread[2:]]), np.array([value, *size[:2], abs(to_start), *size[2:]])
