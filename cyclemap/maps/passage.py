"""Mean passage times and hitting probabilities of a noisy circle map, by Nyström's method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array, arc_ends, into_arc
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.quadrature import arc_rule

Arc = tuple[float, float]

MAX_UNKNOWNS = 6_000
_FINE, _COARSE = 1e-13, 1e-8  # noise coefficients neglected by the answer and by its check
_AGREEMENT = 1e-6  # relative difference of answer and check that is accepted
_ILL = 1e4  # cycles: longer passages are eliminated without subtractions
_MIN_BANDWIDTH = 4
_BLOCK = 48  # unknowns eliminated together


@dataclass(frozen=True, eq=False)
class _Killed:
    """The chain on the nodes of its arcs: q[i, j] = chance of i → j, out[i] = chance of leaving at once."""

    q: Array
    out: Array
    reach: Array


def mean_passage_time(circle_map: CircleMap, noise: Noise, start: float, arc: Arc, *, lifted: bool = False) -> float:
    """Mean number of cycles until the path θ' = F(θ) + ξ from ``start`` is first outside ``arc``.

    start : radians, inside the arc. arc : (start, end), counter-clockwise, radians, length in (0, 2π).
    lifted : False counts positions mod 2π, so that a step of a whole turn comes back; True follows the
        path on the real line, where the arc may be a whole turn.

    T(x) = 1 + ∫_arc g(y - F(x)) T(y) dy, g the noise's density, on Gauss-Legendre nodes with panels
    between the map's breaks and samples (Nyström). Where the passage is long the system is eliminated
    without subtraction from the exactly known chances of leaving (Grassmann, Taksar & Heyman 1985), so
    that even 1e100 cycles keep their digits; inf above 1e300. Checked against a coarser solution:
    ConvergenceError unless they agree to 1e-6 (the finer one, whose nodes resolve the noise to 1e-13, is
    then good to about 1e-10; a sampled map's kinks in F'' may cost 1e-8).

    >>> from cyclemap.maps.noise import WrappedNormal
    >>> stuck = CircleMap.arnold(0.1, 0.9)
    >>> round(mean_passage_time(stuck, WrappedNormal(0.1 * np.pi), 0.77278, (0.0, np.pi / 2)), 3)
    44.624
    """
    ends = arc_ends(arc, "arc", whole=lifted)
    inside = _required(start, ends)
    return _agreed(
        lambda *rule: _passage(circle_map, noise, inside, ends, lifted, _nodes(circle_map, noise, [ends], *rule)),
        "mean passage time",
    )


def hitting_probability(circle_map: CircleMap, noise: Noise, start: float, arc_a: Arc, arc_b: Arc) -> float:
    """Probability that the path from ``start`` is in ``arc_a`` at an earlier cycle than in ``arc_b``.

    The arcs are (start, end) pairs, counter-clockwise, radians, and must not overlap; a start inside one
    of them gives 1 or 0. u(x) = P(F(x) + ξ in a) + ∫ over the rest of g(y - F(x)) u(y) dy, solved as in
    ``mean_passage_time``.

    >>> from cyclemap.maps.noise import WrappedNormal
    >>> even = hitting_probability(CircleMap.rigid(0.0), WrappedNormal(0.3), 0.0, (1.0, 2.0), (-2.0, -1.0))
    >>> round(even, 9)
    0.5
    """
    a, b = arc_ends(arc_a, "arc_a"), arc_ends(arc_b, "arc_b")
    rest = _complement(a, b)
    theta = finite_number("start", start)
    for ends, answer in ((a, 1.0), (b, 0.0)):
        if into_arc(theta, ends) is not None:
            return answer
    found = _agreed(
        lambda *rule: _hit(circle_map, noise, theta, a, b, _nodes(circle_map, noise, rest, *rule)),
        "hitting probability",
    )
    return min(found, 1.0)


def _required(start: float, ends: Arc) -> float:
    inside = into_arc(finite_number("start", start), ends)
    if inside is None:
        raise InvalidInput(f"start is {start:g}, outside the arc ({ends[0]:g}, {ends[1]:g}): start inside it")
    return inside


def _complement(a: Arc, b: Arc) -> list[Arc]:
    """The arcs between two disjoint arcs (those of positive length)."""
    begin = a[1] + float(np.mod(b[0] - a[1], TWO_PI))
    finish = begin + (b[1] - b[0])
    if begin > a[0] + TWO_PI or finish > a[0] + TWO_PI + 1e-14:
        raise InvalidInput(f"arc_a {a} and arc_b {b} overlap: give disjoint arcs")
    rest = [(a[1], begin), (finish, a[0] + TWO_PI)]
    return [ends for ends in rest if ends[1] - ends[0] > 1e-14]


def _agreed(answer: Callable[[float, bool], float], name: str) -> float:
    """The answer on fine nodes if coarse ones agree; else the same with panels that end at every sample."""
    for every_sample in (False, True):
        coarse = answer(_COARSE, every_sample)
        if np.isinf(coarse):
            return coarse
        fine = answer(_FINE, every_sample)
        if fine == coarse or abs(fine - coarse) <= _AGREEMENT * abs(fine):
            return fine
    raise ConvergenceError(
        f"the {name} came out as {fine:.9g} and, with fewer nodes, {coarse:.9g}: the map is too rough for "
        "so small a noise; raise the noise or give the map's breaks"
    )


# -- the two equations ---------------------------------------------------------------------------------------


def _passage(
    circle_map: CircleMap, noise: Noise, start: float, ends: Arc, lifted: bool, rule: tuple[Array, Array]
) -> float:
    theta, weight = rule
    images = circle_map(np.append(theta, start))
    out = escape_probability(noise, images, ends, lifted)
    kernel = _kernel(noise, images, theta, lifted) * weight
    times = _solved(_Killed(kernel[:-1], out[:-1], np.ones(theta.size)))
    return 1.0 + float(kernel[-1] @ times) if np.all(np.isfinite(times)) else float("inf")


def _hit(circle_map: CircleMap, noise: Noise, start: float, a: Arc, b: Arc, rule: tuple[Array, Array]) -> float:
    theta, weight = rule
    images = circle_map(np.append(theta, start))
    success, failure = arrival_probability(noise, images, a), arrival_probability(noise, images, b)
    kernel = _kernel(noise, images, theta, False) * weight
    chances = _solved(_Killed(kernel[:-1], (success + failure)[:-1], success[:-1]))
    if not np.all(np.isfinite(chances)):
        raise ConvergenceError("neither arc is reached within 1e300 cycles: raise the noise or widen the arcs")
    return float(success[-1] + kernel[-1] @ chances)


def escape_probability(noise: Noise, image: Array, ends: Arc, lifted: bool) -> Array:
    """P(image + ξ outside the arc), without cancellation where it is small."""
    if not lifted:
        return arrival_probability(noise, image, (ends[1], ends[0] + TWO_PI))
    return noise.exceedance(ends[1] - image) + noise.exceedance(image - ends[0])


def arrival_probability(noise: Noise, image: Array, ends: Arc) -> Array:
    """P(image + ξ mod 2π in the arc), to full relative accuracy also where it is small."""
    return noise.arc_probability(ends[0] - image, ends[1] - image)


def _kernel(noise: Noise, images: Array, theta: Array, lifted: bool) -> Array:
    gap = theta - images[:, None]
    return noise.line_density(gap) if lifted else noise.density(gap)


def _nodes(
    circle_map: CircleMap, noise: Noise, arcs: list[Arc], neglected: float, every_sample: bool
) -> tuple[Array, Array]:
    bandwidth = float(_MIN_BANDWIDTH)
    while noise.coefficients(bandwidth) > neglected and bandwidth < 1e5:
        bandwidth *= 1.05
    rules = [arc_rule(circle_map, *ends, bandwidth, every_sample=every_sample) for ends in arcs]
    theta, weight = (np.concatenate(part) for part in zip(*rules, strict=True))
    if theta.size > MAX_UNKNOWNS:
        raise InvalidInput(f"{noise!r} needs {theta.size} nodes on the arc, more than {MAX_UNKNOWNS}: raise its width")
    return theta, weight


# -- linear algebra ------------------------------------------------------------------------------------------


def _solved(chain: _Killed) -> Array:
    """x = reach + q x; by elimination without subtraction where plain elimination would lose digits."""
    system = np.eye(chain.out.size) - chain.q
    try:
        times = np.linalg.solve(system, np.stack([chain.reach, np.ones(chain.out.size)], axis=1))
    except np.linalg.LinAlgError:
        return _without_subtraction(chain)
    longest = float(np.max(times[:, 1]))
    good = np.all(times > -1e-9) and 0.0 < longest < _ILL
    return np.asarray(times[:, 0]) if good else _without_subtraction(chain)


def _without_subtraction(chain: _Killed) -> Array:
    """Grassmann-Taksar-Heyman elimination of (I - q) x = reach, in blocks, without a difference."""
    q, out, reach = chain.q.copy(), chain.out.copy(), chain.reach.copy()
    pivot, answer = np.empty(out.size), np.empty(out.size)
    with np.errstate(all="ignore"):
        for high in range(out.size, 0, -_BLOCK):
            low = max(0, high - _BLOCK)
            for k in range(high - 1, low - 1, -1):
                pivot[k] = out[k] + np.sum(q[k, :k])
                share = q[:k, k] / pivot[k]
                q[:k, k] = share
                # Only the block's own rows and columns now; the rest at once below.
                q[:k, low:k] += np.multiply.outer(share, q[k, low:k])
                q[low:k, :low] += np.multiply.outer(share[low:], q[k, :low])
                out[:k] += share * out[k]
                reach[:k] += share * reach[k]
            q[:low, :low] += q[:low, low:high] @ q[low:high, :low]
        for k in range(out.size):
            answer[k] = (reach[k] + q[k, :k] @ answer[:k]) / pivot[k]
    return np.where(np.isfinite(answer), answer, np.inf)
