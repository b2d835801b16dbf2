"""Mean passage times and hitting probabilities of a noisy circle map, and how they change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import Arc, arc_ends, arcs_between, into_arc, required_inside
from cyclemap.maps.estimate import ELIMINATION, SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.noise.uniform_noise import UniformNoise
from cyclemap.maps.passages.killed_chain import Expectation, KilledChain, circle_exit, killed_chain, line_exits

LONGEST = 1e300  # cycles: a longer passage is given as inf
_GOOD = 1e-9  # relative error bound with which few nodes will do
_ACCEPTED = 1e-6  # relative error bound that is accepted at all
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
        from cyclemap.maps.uniform.uniform_passage import uniform_passage_time

        return uniform_passage_time(circle_map, noise, inside, ends, lifted, progress=progress)
    exits = line_exits(ends) if lifted else circle_exit(ends)
    make = partial(killed_chain, circle_map, noise, (ends,), exits, lifted)
    return _certified(make, inside, 1.0, np.zeros(len(exits)), "mean passage time")


def hitting_probability(circle_map: CircleMap, noise: Noise, start: float, arc_a: Arc, arc_b: Arc) -> Estimate:
    """Probability that the path from ``start`` is in ``arc_a`` at an earlier cycle than in ``arc_b``.

    The arcs are (start, end) pairs, counter-clockwise, radians, and must not overlap; a start inside one
    of them gives 1 or 0. u(x) = P(F(x) + ξ in a) + ∫ over the rest of g(y - F(x)) u(y) dy, solved and
    bounded as in ``mean_passage_time``: small chances keep their digits too. ConvergenceError also when
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
        from cyclemap.maps.uniform.uniform_passage import uniform_hitting_probability

        return uniform_hitting_probability(circle_map, noise, theta, a, b)
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
        if own <= _GOOD * abs(value):
            return Estimate(value, own + from_map)
    other = make(every_sample=True, stretch=1.0).expected(each, at).value_at(start)
    own = min(own, 10.0 * abs(other - value) + ELIMINATION * abs(value))
    if not own <= _ACCEPTED * abs(value):
        raise ConvergenceError(
            f"the {name} came out as {value:.9g} with error bound {own:.3g}: the map is too rough for so small a "
            "noise; raise the noise or give the map's breaks"
        )
    return Estimate(value, own + from_map)


Tangent = Callable[[Array], Array]

_STRETCH = 1.3  # bandwidth of the second solution over that of the first


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


@dataclass(frozen=True)
class HittingResponse:
    """Made by ``hitting_response``: a hitting probability and its derivatives, as in ``PassageResponse``."""

    probability: Estimate
    to_map: Estimate | None
    to_noise: Estimate
    to_start: Estimate


def passage_response(
    circle_map: CircleMap,
    noise: Noise,
    start: float,
    arc: Arc,
    tangent: Tangent | None = None,
    *,
    lifted: bool = False,
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
    exits = line_exits(ends) if lifted else circle_exit(ends)
    make = partial(killed_chain, circle_map, noise, (ends,), exits, lifted, every_sample=True)
    values = _compared(make, 1.0, np.zeros(len(exits)), inside, tangent, ends)
    time, to_map, *others = values
    return PassageResponse(time, None if tangent is None else to_map, *others)


def hitting_response(
    circle_map: CircleMap, noise: Noise, start: float, arc_a: Arc, arc_b: Arc, tangent: Tangent | None = None
) -> HittingResponse:
    """The probability of ``hitting_probability`` and its derivatives; see ``passage_response``.

    Raises InvalidInput also for a start inside one of the arcs, where the probability is 0 or 1 whatever changes.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> still = CircleMap.rigid(0.0)
    >>> found = hitting_response(still, WrappedNormal(0.3), 0.0, (1.0, 2.0), (-2.0, -1.0))
    >>> found.to_start > 0.1  # nearer to the first arc
    True
    """
    a, b = arc_ends(arc_a, "arc_a"), arc_ends(arc_b, "arc_b")
    rest, theta = arcs_between(a, b), finite_number("start", start)
    if into_arc(theta, a) is not None or into_arc(theta, b) is not None:
        raise InvalidInput(f"start is {theta:g}, inside one of the arcs: start between them")
    make = partial(killed_chain, circle_map, noise, rest, (a, b), False, every_sample=True)
    probability, to_map, *others = _compared(make, 0.0, np.array([1.0, 0.0]), theta, tangent, None)
    return HittingResponse(probability, None if tangent is None else to_map, *others)


# -- inside --------------------------------------------------------------------------------------------------


def _compared(
    make: Callable[..., KilledChain], each: float, at: Array, start: float, tangent: Tangent | None, ends: Arc | None
) -> list[Estimate]:
    """Value and derivatives on the first nodes, with bounds from the second ones."""
    (first, sizes), (second, _) = (
        _responses(make(stretch=stretch).expected(each, at), start, tangent, ends) for stretch in (1.0, _STRETCH)
    )
    bounds = 3.0 * np.abs(first - second) + ELIMINATION * sizes
    return [Estimate(value, bound) for value, bound in zip(first, bounds, strict=True)]


def _responses(expected: Expectation, start: float, tangent: Tangent | None, ends: Arc | None) -> tuple[Array, Array]:
    """X and its derivatives by map, noise, start and, if given, arc ends; and the sums of their terms' sizes."""
    if not abs(expected.top) < LONGEST:
        raise ConvergenceError("the passage takes more than 1e300 cycles: raise the noise or shorten the arc")
    chain, here = expected.chain, np.array([start])
    points = np.append(chain.theta, start)
    images = np.append(chain.images, chain.map(here))
    slope = expected.map_slope(images, chain, expected.change)
    along = slope * (np.zeros_like(points) if tangent is None else _checked(tangent, points))
    sources = [along, _noise_slope(expected, images)]
    if ends is not None:
        sources += _end_slopes(expected, images, ends)
    table = np.stack(sources, axis=1)
    last_moves = chain.transitions(images[-1:])[0]
    spread, size = (_carried(expected, last_moves, part) for part in (table, np.abs(table)))
    to_start = float(slope[-1] * chain.map.derivative(here)[0])
    value = expected.value_at(start)
    return np.array([value, *spread[:2], to_start, *spread[2:]]), np.array([value, *size[:2], abs(to_start), *size[2:]])


def _carried(expected: Expectation, last_moves: Array, sources: Array) -> Array:
    """(I - K)⁻¹ of sources at the nodes and, last, at the start: its value there."""
    chain = expected.chain
    return np.asarray(last_moves @ chain.elimination.solve(sources[:-1]) + sources[-1])


def _noise_slope(expected: Expectation, images: Array) -> Array:
    chain = expected.chain
    return np.asarray(
        (expected.at - expected.top) @ chain.departure_rates(images) + chain.transition_rates(images) @ expected.change
    )


def _end_slopes(expected: Expectation, images: Array, ends: Arc) -> list[Array]:
    """Moving an end outward turns chances of leaving into chances of going to that end."""
    chain = expected.chain
    law = chain.noise.line_density if chain.lifted else chain.noise.density
    return [sign * law(end - images) * expected.value_at(end) for sign, end in ((-1.0, ends[0]), (1.0, ends[1]))]


def _checked(tangent: Tangent, theta: Array) -> Array:
    values = np.asarray(tangent(theta), dtype=np.float64)
    if values.shape != theta.shape or not np.all(np.isfinite(values)):
        raise InvalidInput(f"tangent turns shape {theta.shape} into {values.shape}: it must act entry by entry, finite")
    return values
