"""Topological entropy of folded lifts with bounds from both sides, and the itineraries of their
folds.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import ANGLE, Estimate
from cyclemap.maps.lifts.branches import Branch, branches, seams
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import JUMP

ITERATES = 60
_MOST_CELLS = 3_000  # of the graph, whose eigenvalues are found whole
_LOST = 1e-3  # radians: an image known no better is given up
_MOST_IMAGES = 100_000  # of all folds together: some ten seconds
_CLOSED = 1e-9  # radians: an image that meets a fold to so much closes its orbit
_CLOSING = 1e-12  # of the entropy: of eigenvalues and of orbits that close to rounding


@dataclass(frozen=True, eq=False)
class Folds:
    """A continuous lift with folds: fold j is the start of branch j, ``theta`` (m,) in [0, 2π),
    rising.
    """

    map: CircleMap
    parts: tuple[Branch, ...]
    theta: Array

    def branch(self, base: float) -> tuple[int, float]:
        """The branch of an angle of [0, 2π), and the angle in that branch's own turn."""
        own = base + TWO_PI if base < self.theta[0] else base
        return int(np.searchsorted(self.theta, own, side="right")) - 1, own

    def itinerary(self, fold: int, length: int, push: float = 0.0) -> Itinerary:
        """The branches that the fold's images run through, ``length`` at most, its value moved
        outward by ``push``.
        """
        letters: list[int] = []
        turns: list[int] = []
        image = self.parts[fold].start_value - push * self.parts[fold].direction
        error = ANGLE + self.map.max_error
        while len(letters) < length and (error < _LOST or not letters):
            base = image - TWO_PI * floor(image / TWO_PI)
            letter, own = self.branch(base)
            letters.append(letter)
            turns.append(round((image - own) / TWO_PI))
            away = np.abs(np.sin(0.5 * (base - self.theta)))
            if np.min(away) <= error:
                closes = int(np.argmin(away)) if error <= _CLOSED else None
                return Itinerary(letters, turns, closes, bool(np.min(away) == 0.0))
            error = error * abs(float(self.map.derivative(own))) + ANGLE + self.map.max_error
            image = float(self.map(own))
        return Itinerary(letters, turns, None, False)

    def orbit(self, route: Itinerary, at_end: bool) -> list[tuple[int, float]]:
        """Points (branch, angle in its own turn) that go through the route's branches, and end at
        an end of the last.

        Pulled back from there, so that nothing grows. Where a branch's image does not reach so far,
        it is its own end that is the last point.
        """
        last = self.parts[route.letters[-1]]
        points = [(route.letters[-1], last.end if at_end else last.start)]
        for letter, turns in list(zip(route.letters[:-1], route.turns[1:], strict=True))[::-1]:
            branch = self.parts[letter]
            wanted = points[0][1] + TWO_PI * turns
            low, high = sorted((branch.start_value, branch.end_value))
            if low < wanted < high:
                points.insert(0, (letter, float(branch.inverse(wanted))))
            else:
                points = [
                    (
                        letter,
                        branch.start if (wanted <= low) == (branch.direction > 0) else branch.end,
                    )
                ]
        return points


@dataclass(frozen=True)
class Itinerary:
    """The branches of a fold's images; the whole turns of each image beside its branch's own turn.

    closes : the fold that the last image meets to rounding.
    exactly : whether to the last digit.
    """

    letters: list[int]
    turns: list[int]
    closes: int | None
    exactly: bool


def topological_entropy(circle_map: CircleMap, *, iterates: int = ITERATES) -> Estimate:
    """The topological entropy of a continuous lift's circle map, between two bounds.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    iterates : int, optional
        How many images of every fold are followed at most.

    Returns
    -------
    Estimate
        Natural logarithm a cycle: the middle of the two bounds, with half their distance as
        ``error_bound``.

    Raises
    ------
    InvalidInput
        For lifts with jumps or plateaus, for a ``max_error`` of half a turn or more, and where the
        orbits of the folds have more than 3,000 points.

    Notes
    -----
    Each fold's value is moved down to the nearest one whose orbit runs through the same branches
    and ends at a fold. The folds and these orbits cut the circle into cells that F carries over
    whole cells: the logarithm of the graph's largest eigenvalue is a lower bound (horseshoes:
    Misiurewicz 1979). Moved up instead, F's cells meet no other cells than the graph says, so Fⁿ
    has no more laps than the graph has paths: an upper bound (Misiurewicz & Szlenk 1980). The
    orbits are pulled back through the branches and good to rounding; proved but for that. The two
    bounds meet like exp(-h·iterates), to where an orbit is lost in rounding. Folds are lowered and
    raised by the map's ``max_error`` before: the bounds hold for all lifts within it that have no
    more folds; and for the bounds alone by 1e-9 radians where an image meets a fold to rounding,
    but not to the last digit. Without folds the entropy is ln
    max(1, |degree|), and never below. A kink that is a repelling fixed point opens to a horseshoe
    however little it is moved: there bounds with ``max_error`` are wide.

    References
    ----------
    - Misiurewicz, M. (1979), Horseshoes for mappings of the interval, Bulletin de l'Academie
      Polonaise des Sciences 27.
    - Misiurewicz, M. & Szlenk, W. (1980), Entropy of piecewise monotone mappings, Studia
      Mathematica 67.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, topological_entropy
    >>> entropy = topological_entropy(CircleMap.arnold(0.3, 3.0))
    >>> round(entropy, 9), entropy.error_bound < 1e-9
    (0.693147181, True)
    """
    most = whole_number("iterates", iterates, least=1)
    folds = _folds(circle_map)
    least = float(np.log(max(1, abs(circle_map.degree))))
    if len(folds.parts) == 1:
        return Estimate(least, 0.0)
    if circle_map.max_error >= np.pi:
        raise InvalidInput(
            f"max_error is {circle_map.max_error:g}: a lift that may be off by half a turn tells "
            "nothing of its entropy"
        )

    def bounds(pushes: Array) -> tuple[float, float]:
        """The lower bound with every fold moved inward by so much, the upper one with them moved
        outward.
        """
        inner, outer = (
            [folds.itinerary(k, most, by) for k, by in enumerate(way * pushes)]
            for way in (-1.0, 1.0)
        )
        low = max(least, _log_growth(folds, inner, up=False))
        return low, max(low, _log_growth(folds, outer, up=True))

    plain = [folds.itinerary(k, min(most, _MOST_CELLS)) for k in range(len(folds.parts))]
    size = sum(len(route.letters) for route in plain)
    if size > _MOST_CELLS:
        raise InvalidInput(
            f"iterates is {most}: the orbits of {len(plain)} folds have {size} points or more, "
            f"above {_MOST_CELLS}; take fewer"
        )
    known = np.full(len(plain), circle_map.max_error)
    nearly = np.array([route.closes is not None and not route.exactly for route in plain])
    lower, upper = bounds(known)
    value = 0.5 * (lower + upper)
    if np.any(nearly):
        moved = bounds(known + _CLOSED * nearly)
        lower = min(lower, moved[0])
        upper = max(upper, moved[1])
    return Estimate(value, max(upper - value, value - lower) + _CLOSING)


def kneading_sequences(circle_map: CircleMap, length: int = 30) -> tuple[tuple[int, ...], ...]:
    """For every fold the branches that its images are on, one after the other.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    length : int, default 30
        How many images of every fold are followed at most: 100,000 over the number of folds.

    Returns
    -------
    tuple of tuple of int
        One sequence a fold; fold j is the start of branch j. Branches are counted as
        ``branches`` lists them, from 0. Empty for lifts without folds.

    Raises
    ------
    InvalidInput
        For lifts with jumps or plateaus, and longer sequences.

    Notes
    -----
    A sequence ends early where an image meets a fold (with a branch beside it), or where rounding
    cannot tell its side of one (Milnor & Thurston 1988).

    References
    ----------
    Milnor, J. & Thurston, W. (1988), On iterated maps of the interval, Lecture Notes in Mathematics
    1342.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, kneading_sequences
    >>> kneading_sequences(CircleMap.arnold(0.3, 3.0), 6)
    ((1, 0, 1, 0, 1, 0), (0, 1, 0, 1, 1, 1))
    """
    count = whole_number("length", length, least=1)
    folds = _folds(circle_map)
    if len(folds.parts) == 1:
        return ()
    images = count * len(folds.parts)
    require_room("the sequences", images, "give a smaller length", _MOST_IMAGES)
    return tuple(tuple(folds.itinerary(fold, count).letters) for fold in range(len(folds.parts)))


def _folds(circle_map: CircleMap) -> Folds:
    """The branches, or InvalidInput where they do not join."""
    require_map(circle_map)
    parts = branches(circle_map)
    for branch, _, jump in seams(parts, circle_map.degree):
        if branch.direction == 0 or abs(jump) > JUMP:
            raise InvalidInput(
                f"F jumps or is constant near θ = {branch.end % TWO_PI:.6g}: entropy is computed "
                "for continuous lifts without plateaus"
            )
    return Folds(circle_map, parts, np.array([branch.start for branch in parts]))


def _log_growth(folds: Folds, routes: list[Itinerary], up: bool) -> float:
    """ln of the largest eigenvalue of the graph of cells, all folds moved outward if ``up``, else
    inward.
    """
    images = sorted(_images(folds, routes, up).items())
    points = np.array([base for base, _ in images])
    size = points.size
    place = {base: index for index, (base, _) in enumerate(images)}
    # Of every point's image, counted on round the circle.
    start = np.array([turn * size + place[base] for _, (turn, base) in images])
    end = np.roll(start, -1)
    end[np.roll(points, -1) == folds.theta[0]] += folds.map.degree * size
    if not up:
        _hold_within_folds(folds, points, start, end)
    graph = np.zeros((size, size))
    for row, ends in zip(graph, np.sort([start, end], axis=0).T.tolist(), strict=True):
        np.add.at(row, np.arange(*ends) % size, 1.0)
    largest = float(np.max(np.abs(np.linalg.eigvals(graph))))
    return float(np.log(largest)) if largest > 0.0 else -np.inf


def _hold_within_folds(folds: Folds, points: Array, start: Whole, end: Whole) -> None:
    """Cut the images of cells, counted as ``start`` and ``end``, to what their branch reaches once
    its folds have been moved inward: to nothing where they have passed each other.
    """
    place = np.searchsorted(points, folds.theta)
    for first, after, branch in zip(
        place, np.append(place[1:], place[0] + points.size), folds.parts, strict=True
    ):
        cells = np.arange(first, after) % points.size
        low, high = sorted((start[cells[0]], end[cells[-1]]))
        if branch.direction * (end[cells[-1]] - start[cells[0]]) < 0:
            high = low
        start[cells] = np.clip(start[cells], low, high)
        end[cells] = np.clip(end[cells], low, high)


def _images(folds: Folds, routes: list[Itinerary], up: bool) -> dict[float, tuple[int, float]]:
    """Of the folds and their moved orbits: base angles, to the whole turns and base angles of their
    images, in the turn of their branch.
    """
    images: dict[float, tuple[int, float]] = {}
    for branch, route in zip(folds.parts, routes, strict=True):
        orbits = [folds.orbit(route, at_end) for at_end in (False, True)]
        if route.closes is not None:
            orbits = [orbits[route.closes != route.letters[-1]]]
        chosen = (max if (branch.direction < 0) == up else min)(
            orbits, key=lambda orbit: orbit[0][1]
        )
        base = branch.start
        for (letter, own), turns in zip(chosen, route.turns, strict=False):
            is_fold = own == folds.parts[letter].end
            following = folds.parts[(letter + 1) % len(folds.parts)].start
            after = following if is_fold else own - TWO_PI * (own >= TWO_PI)
            images[base] = (turns + round((own - after) / TWO_PI), after)
            base = after
    return images
