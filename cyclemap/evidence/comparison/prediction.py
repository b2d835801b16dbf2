"""What is predicted of a collection: a loop, a map, a fitted map or one that wears, brought to one form."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection import CollectionLoop, drifting_map
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.collection.settings import sampled_loop
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.laws.fit_map import FittedMap, fit_worn_law
from cyclemap.evidence.laws.periodic_law import PeriodicLaw, fit_periodic_law
from cyclemap.evidence.orientations.collection_null import CollectionModel, CollectionRefit
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap, DriftingMap, Noise, WrappedNormal

PREDICTIONS = "a CollectionLoop, a CircleMap or DriftingMap with noise, or a FittedMap"
# Cycles between which a refitted map that wears is blended, for each degree of its polynomials above one.
REFIT_KNOTS = 10
# Coefficients that agree so well were fitted to the same pairs.
SAME_FIT = 1e-9
# Samples of a material's posterior that are used, and how good their maps are, rad: they tell a spread.
SAMPLES = 32
_SAMPLE_TOLERANCE, _SAMPLE_BLEND = 1e-3, 1e-2
_APART = 1_000  # between the seeds of two samples

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Prediction:
    """A prediction in one form.

    map : of the cycle; cycle n of a drifting one is push n of the data, those dropped counted.
    noise : of one cycle. given : what was handed in.
    kind : "loop", "map", "drifting map", "fitted map" or "worn fitted map".
    samples : the maps of samples of the posterior of a loop's material, those that can be run; () without a posterior.
    """

    map: CircleMap | DriftingMap
    noise: Noise
    kind: str
    given: Any
    samples: tuple[CircleMap | DriftingMap, ...] = ()

    @property
    def is_drifting(self) -> bool:
        """Whether the map changes with the cycle."""
        return isinstance(self.map, DriftingMap)

    def model(self, first: int) -> CollectionModel:
        """The model of a collection that begins with push ``first``."""
        return CollectionModel(self.map, self.noise, first)

    def null(self, first: int) -> CollectionModel:
        """The same, whose simulated collections are as uncertain as the parameters are."""
        return PosteriorModel(self.map, self.noise, first, self.samples) if self.samples else self.model(first)

    def map_at(self, cycle: float) -> CircleMap:
        """The map of one push."""
        return self.map if isinstance(self.map, CircleMap) else self.map.at(cycle)

    def turn(self, theta: Array, cycle: Array) -> Array:
        """The predicted turn (rad) of pairs that start at ``theta`` (n,) in the pushes ``cycle`` (n,)."""
        return _turn(self.map, theta, cycle)

    def mean_turn_error(self, theta: Array, cycle: Array) -> float:
        """How well the material's parameters fix the mean of ``turn``: its standard deviation over the samples, rad."""
        if not self.samples:
            return 0.0
        return float(np.std([np.mean(_turn(one, theta, cycle)) for one in self.samples], ddof=1))


@dataclass(frozen=True, eq=False)
class PosteriorModel(CollectionModel):
    """A model whose simulated collections come from the maps of a posterior's samples in turn, not from its own."""

    samples: tuple[CircleMap | DriftingMap, ...] = ()

    def paths(self, start: float, length: int, count: int, seed: int) -> Array:
        """``count`` collections of ``length`` orientations from ``start``: (count, length), rad, unwrapped."""
        found, used = np.empty((count, length)), self.samples[:count]
        for number, one in enumerate(used):
            rows = found[number :: len(used)]
            own = seed + _APART * (number + 1)
            rows[:] = CollectionModel(one, self.noise, self.first).paths(start, length, len(rows), own)
        return found


def _turn(one: CircleMap | DriftingMap, theta: Array, cycle: Array) -> Array:
    return one.turn(theta) if isinstance(one, CircleMap) else one.images(theta, cycle) - theta


def as_prediction(
    given: Any,
    noise: Noise | None,
    last: int,
    *,
    tolerance: float = 1e-6,
    progress: Progress | None = None,
) -> Prediction:
    """Bring a prediction of pushes up to ``last`` to one form.

    noise : of one cycle; None takes a fit's own scatter, for a loop 1.1 degrees (that of measured plywood cycles about
        a smooth function of θ0), and is refused for a map. tolerance : of a loop's cycle map, rad.
    A ``FittedMap`` with wear predicts the worn map, its cycles being numbered as the data's pushes are.

    Raises InvalidInput for anything else, ConvergenceError where the loop's map cannot be computed.
    """
    if noise is not None and not isinstance(noise, Noise):
        raise InvalidInput(f"noise is {noise!r}: give a noise of one cycle, for example WrappedNormal(0.02)")
    if isinstance(given, CircleMap | DriftingMap):
        if noise is None:
            raise InvalidInput(
                "a map alone predicts no histogram: give the noise of a cycle, such as WrappedNormal(0.02)"
            )
        kind = "map" if isinstance(given, CircleMap) else "drifting map"
        return Prediction(given, noise, kind, given)
    if isinstance(given, FittedMap):
        if given.wear is None:
            return Prediction(given.map, noise or _scatter(given.sigma), "fitted map", given)
        chosen = given.drifting_map(last + 1, first=0.0)
        return Prediction(chosen, noise or _scatter(given.wear.sigma), "worn fitted map", given)
    # A loop is told by what it can do, so that a loop whose map is known may stand in for it.
    if callable(getattr(given, "circle_map", None)) and callable(getattr(given, "cycle", None)):
        report = progress or (lambda fraction: None)
        if isinstance(given, CollectionLoop) and given.material.wear is not None:
            # How many maps it takes is not known before; some twenty are usual.
            chosen = drifting_map(given, last + 1, progress=lambda done: report(0.3 * min(1.0, done / 20.0)))
        else:
            chosen = given.circle_map(tolerance=tolerance, progress=lambda done: report(0.3 * done))
        samples: list[CircleMap | DriftingMap] = []
        loops = posterior_samples(given)
        for done, one in enumerate(loops, 1):
            # A surface at the edge of the posterior may not be able to make every cycle: the others tell the spread.
            with suppress(UnsupportedContact, ConvergenceError):
                worn = one.material.wear is not None
                samples.append(
                    drifting_map(one, last + 1, _SAMPLE_BLEND) if worn else one.circle_map(_SAMPLE_TOLERANCE)
                )
            report(0.3 + 0.7 * done / len(loops))
        kept = tuple(samples) if len(samples) > 1 else ()
        return Prediction(chosen, noise or WrappedNormal(DEFAULT_SIGMA), "loop", given, kept)
    raise InvalidInput(f"the prediction is {given!r}: give {PREDICTIONS}")


def posterior_samples(loop: Any) -> list[CollectionLoop]:
    """The loop on up to ``SAMPLES`` surfaces of its material's posterior, evenly picked; [] without a posterior."""
    posterior = loop.material.posterior if isinstance(loop, CollectionLoop) else None
    if posterior is None:
        return []
    picked = np.linspace(0, len(posterior) - 1, min(SAMPLES, len(posterior))).round().astype(int)
    return [sampled_loop(loop, number) for number in picked.tolist()]


def refit_rule(given: Any, pairs: Theta0Pairs, cycle: Array, first: int) -> CollectionRefit | None:
    """What fits a simulated collection as the prediction was fitted to these very pairs; None where it was not.

    A fit is told to be of these pairs by fitting them again, with its own orders: the same coefficients come out.
    The orders are held as they were chosen.
    """
    if not isinstance(given, FittedMap) or given.pairs != pairs.theta.size:
        return None

    def orders(law: PeriodicLaw) -> dict[str, Any]:
        return {"harmonics": law.harmonics, "noise_harmonics": law.log_variance.size // 2}

    def fit(pairs: Theta0Pairs, cycle: Array) -> FittedMap:
        law = fit_periodic_law(pairs.theta, pairs.turn, **orders(given.law))
        if given.wear is None:
            return FittedMap(law)
        chosen = {**orders(given.wear.whole), "harmonics": given.wear.harmonics, "degree": given.wear.degree}
        return FittedMap(law, fit_worn_law(pairs.theta, pairs.turn, cycle, **chosen))

    same = fit(pairs, cycle)
    both = [(given.law.coefficients, same.law.coefficients)]
    if given.wear is not None and same.wear is not None:
        both.append((given.wear.coefficients, same.wear.coefficients))
    if not all(a.shape == b.shape and np.allclose(a, b, rtol=SAME_FIT, atol=SAME_FIT) for a, b in both):
        return None

    def refitted(path: Array) -> CollectionModel:
        again = fit(Theta0Pairs(path[:-1], path[1:]), first + np.arange(path.size - 1.0))
        if again.wear is None:
            return CollectionModel(again.map, _scatter(again.sigma), first)
        # Blended between evenly spread cycles, at a fraction of the cost: exact for wear linear in the cycle.
        wear = again.wear
        knots = np.linspace(wear.first, wear.last, 1 + REFIT_KNOTS * max(0, wear.degree - 1) + 1)
        drifting = DriftingMap.between([(n, again.map_at(n)) for n in knots.tolist()])
        return CollectionModel(drifting, _scatter(wear.sigma), first)

    return refitted


def _scatter(sigma: float) -> WrappedNormal:
    if not sigma > 1e-9:
        raise InvalidInput("the fitted turns lie exactly on a smooth curve: give the noise of a cycle")
    return WrappedNormal(sigma)
