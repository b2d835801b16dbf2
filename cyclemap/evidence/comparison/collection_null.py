"""What is predicted of a collection, and p-values for orientations that follow one another: the
null is simulated as paths of the noisy cycle map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, evenly_spread
from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.collection import CollectionLoop, drifting_map
from cyclemap.collection.loop_surfaces import BLEND_TOLERANCE, on_material
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.laws.circular_distance import (
    CircularLaw,
    PValue,
    circular_wasserstein,
    kuiper_statistic,
    monte_carlo_p_value,
    total_variation,
    watson_statistic,
)
from cyclemap.maps import CircleMap, DriftingMap, Noise, WrappedNormal, sample_staircases
from cyclemap.progress import Progress, part_of, unheard

_CELLS = 4096  # of the grid on which the images of an ensemble are counted
_REFIT_ENSEMBLE = 40  # paths of the ensemble of each refitted model
_APART = 1_000  # between the seeds of two samples


# Samples of a material's posterior that are used, and how good their maps are, rad: they tell a
# spread.
SAMPLES = 32
_SAMPLE_TOLERANCE = 1e-3
_SAMPLE_BLEND = 1e-2

Predictor = CollectionLoop | CircleMap | DriftingMap


@dataclass(frozen=True, eq=False)
class CollectionModel:
    """θ_{n+1} = F_n(θ_n) + ξ_n: a map, fixed or drifting, and its noise.

    Parameters
    ----------
    map : CircleMap or DriftingMap
        The map, fixed or drifting.
    noise : Noise
        That of one cycle.
    first : int, default 0
        Of a drifting map, the cycle that a collection begins with.
    samples : tuple of CircleMap or DriftingMap, default ()
        Maps of a posterior's samples, from which simulated collections then come in turn, not
        from ``map``.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal
    >>> from cyclemap.evidence import CollectionModel
    >>> model = CollectionModel(CircleMap.rigid(0.25), WrappedNormal(0.1))
    >>> model.paths(0.0, length=5, count=3, seed=0).shape
    (3, 5)
    """

    map: CircleMap | DriftingMap
    noise: Noise
    first: int = 0
    samples: tuple[CircleMap | DriftingMap, ...] = ()

    @cached_property
    def begun(self) -> DriftingMap:
        """The map whose cycle 0 is the collection's first."""
        worn = _drifting(self.map)
        return replace(worn, cycles=worn.cycles - self.first)

    def paths(self, start: float, length: int, count: int, seed: int) -> Array:
        """Simulate collections from one start.

        Parameters
        ----------
        start : float
            Orientation that every collection begins with, rad.
        length : int
            Orientations of a collection.
        count : int
            How many collections.
        seed : int
            Of the noise.

        Returns
        -------
        ndarray, shape (count, length)
            Rad, unwrapped.
        """
        if not self.samples:
            return sample_staircases(
                self.begun, self.noise, length - 1, np.full(count, start), seed
            )
        paths = np.empty((count, length))
        used = self.samples[:count]
        for index, own_map in enumerate(used):
            rows = paths[index :: len(used)]
            own = seed + _APART * (index + 1)
            rows[:] = replace(self, map=own_map, samples=()).paths(start, length, len(rows), own)
        return paths

    def map_at(self, cycle: float) -> CircleMap:
        """The map of one cycle."""
        return _drifting(self.map).at(cycle)

    def turns(self, theta: Array, cycle: Array) -> Array:
        """Turns (1 + k, n), rad, from ``theta`` (n,) in the cycles ``cycle`` (n,): of the map, then
        of each sample.
        """
        known = (self.map, *self.samples)
        return np.array([_drifting(each).images(theta, cycle) - theta for each in known])

    def images(self, paths: Array) -> Array:
        """F_n(θ_n) of each orientation but the last, of paths (..., n): shape (..., n - 1), rad, on
        the same lift.
        """
        return self.begun.images(paths[..., :-1], np.arange(paths.shape[-1] - 1))


def _drifting(known: CircleMap | DriftingMap) -> DriftingMap:
    """The map of each cycle, of a fixed one always the same."""
    return known if isinstance(known, DriftingMap) else DriftingMap.between([(0.0, known)])


def as_prediction(
    given: Predictor,
    noise: Noise | None,
    last: int,
    *,
    tolerance: float = 1e-6,
    progress: Progress | None = None,
) -> CollectionModel:
    """Bring a prediction of pushes up to ``last`` to one form; of a loop whose material has a
    posterior, with the maps of its samples that can be run.

    noise : of one cycle; None takes 1.1 degrees for a loop (the scatter of measured plywood cycles
        about a smooth function of θ0), and is refused for a map.
    tolerance : of a loop's cycle map, rad.

    Raises InvalidInput for anything else, ConvergenceError where the loop's map cannot be computed.
    """
    if noise is not None and not isinstance(noise, Noise):
        raise InvalidInput(
            f"noise is {noise!r}: give a noise of one cycle, for example WrappedNormal(0.02)"
        )
    if isinstance(given, CircleMap | DriftingMap):
        if noise is None:
            raise InvalidInput(
                "a map alone predicts no histogram: give the noise of a cycle, such as "
                "WrappedNormal(0.02)"
            )
        return CollectionModel(given, noise)
    # A loop is told by what it can do, so that a loop whose map is known may stand in for it.
    if not all(callable(getattr(given, name, None)) for name in ("circle_map", "cycle")):
        raise InvalidInput(
            f"the prediction is {given!r}: give a CollectionLoop, or a CircleMap or DriftingMap "
            "with noise"
        )
    samples = list[CircleMap | DriftingMap]()
    loops = posterior_samples(given)
    parts = 1 + len(loops)
    chosen = _map_of(given, last, tolerance, BLEND_TOLERANCE, part_of(progress, 0, parts))
    for done, loop in enumerate(loops, 1):
        # A surface at the edge of the posterior may not be able to make every cycle: the others
        # tell the spread.
        with suppress(UnsupportedContact, ConvergenceError):
            samples.append(_map_of(loop, last, _SAMPLE_TOLERANCE, _SAMPLE_BLEND, unheard))
        part_of(progress, done, parts)(1.0)
    kept = tuple(samples) if len(samples) > 1 else ()
    return CollectionModel(chosen, noise or WrappedNormal(DEFAULT_SIGMA), samples=kept)


def _map_of(
    loop: CollectionLoop, last: int, tolerance: float, blend: float, report: Progress
) -> CircleMap | DriftingMap:
    """The map of a loop, or where its surface wears, its maps up to push ``last``."""
    if isinstance(loop, CollectionLoop) and loop.material.wear is not None:
        # How many maps it takes is not known before; some twenty are usual.
        return drifting_map(loop, last + 1, blend, lambda done: report(min(1.0, done / 20.0)))
    return loop.circle_map(tolerance=tolerance, progress=report)


def posterior_samples(loop: CollectionLoop) -> list[CollectionLoop]:
    """The loop on up to ``SAMPLES`` surfaces of its material's posterior, evenly picked; [] without
    a posterior.
    """
    posterior = loop.material.posterior if isinstance(loop, CollectionLoop) else None
    if posterior is None:
        return []
    return [
        on_material(loop, loop.material.sample(index))
        for index in evenly_spread(len(posterior), SAMPLES)
    ]


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What a model predicts of a collection: simulated ones from the same start, and the law of
    their orientations.

    Attributes
    ----------
    model : CollectionModel
        What was simulated.
    paths : ndarray, shape (k, n)
        rad, unwrapped.
    law : CircularLaw
        Of an orientation drawn at random from a collection, the start left out.
    """

    model: CollectionModel
    paths: Array
    law: CircularLaw


CollectionStatistic = Callable[[Array, Ensemble], Array]
# How far orientations lie from a law, by name.
DISTANCES = {
    "wasserstein": circular_wasserstein,
    "total_variation": total_variation,
    "kuiper": kuiper_statistic,
    "watson": watson_statistic,
}
CollectionRefit = Callable[[Array], CollectionModel]


def simulated_ensemble(
    model: CollectionModel, start: float, length: int, count: int, seed: int
) -> Ensemble:
    """Simulate collections from one start, with the law of what they record.

    Parameters
    ----------
    model : CollectionModel
        What is simulated.
    start : float
        Orientation that every collection begins with, rad.
    length : int
        Orientations of a collection.
    count : int
        How many collections.
    seed : int
        Of the noise.

    Returns
    -------
    Ensemble
        The paths (count, length), rad, and the law.

    Notes
    -----
    The law is the mean over the collections' cycles of the noise's density about the image of
    each orientation: no bandwidth is chosen, and wear and the approach from the start are in
    it.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal
    >>> from cyclemap.evidence import CollectionModel, simulated_ensemble
    >>> model = CollectionModel(CircleMap.rigid(0.25), WrappedNormal(0.1))
    >>> law = simulated_ensemble(model, 0.0, 401, 50, seed=0).law
    >>> bool(np.allclose(law.bin_probabilities(4), 0.25, atol=0.01))
    True
    """
    size = whole_number("length", length, least=2)
    paths = model.paths(
        finite_number("start", start), size, whole_number("count", count, least=1), seed
    )
    # The images counted on a fine grid, and the noise added by Fourier coefficients.
    cell = np.mod(np.floor(model.images(paths) * (_CELLS / TWO_PI)).astype(np.int64), _CELLS)
    share = np.bincount(cell.ravel(), minlength=_CELLS) / cell.size
    smooth = np.fft.rfft(share) * model.noise.coefficients(np.arange(_CELLS // 2 + 1))
    density = np.maximum(np.fft.irfft(smooth, _CELLS), 0.0) * (_CELLS / TWO_PI)
    density *= _CELLS / TWO_PI / np.sum(density)
    middles = (np.arange(_CELLS) + 0.5) * (TWO_PI / _CELLS)
    return Ensemble(
        model, paths, CircularLaw(lambda theta: np.interp(theta, middles, density, period=TWO_PI))
    )


def collection_statistics() -> dict[str, CollectionStatistic]:
    """The statistics of a collection by name.

    wasserstein (rad), total_variation, kuiper, watson : of its orientations against the ensemble's
        law.
    turns : |its climb less the ensemble's mean climb|, in turns.
    """

    def climb(paths: Array) -> Array:
        return paths[:, -1] - paths[:, 0]

    def turns(paths: Array, ensemble: Ensemble) -> Array:
        return np.abs(climb(paths) - np.mean(climb(ensemble.paths))) / TWO_PI

    def from_law(name: str) -> CollectionStatistic:
        return lambda paths, ensemble: DISTANCES[name](paths, ensemble.law)

    return {name: from_law(name) for name in DISTANCES} | {"turns": turns}


def collection_p_values(
    theta: ArrayLike,
    model: CollectionModel,
    statistics: Mapping[str, CollectionStatistic] | None = None,
    *,
    runs: int = 199,
    seed: int = 0,
    refit: CollectionRefit | None = None,
    ensemble: Ensemble | None = None,
    progress: Progress | None = None,
) -> dict[str, PValue]:
    """P-values of a path of orientations under a map that may wear, autocorrelation and fitted
    parameters included.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Orientations, rad, n ≥ 2, in the order of the cycles, unwrapped where a statistic asks
        for the climb.
    model : CollectionModel
        The null: the map and its noise.
    statistics : mapping of str to callable or None, optional
        By name; None takes ``collection_statistics()``.
    runs : int, default 199
        How many collections are simulated.
    seed : int, default 0
        Of these.
    refit : callable, optional
        None for a model given in full, else what fits a path (n,), unwrapped, to a model, by
        the rule that made ``model`` of ``theta``: each simulated collection is then set against
        an ensemble of its own fit, as the measured one is (parametric bootstrap).
    ensemble : Ensemble or None, optional
        Of the model, where it is at hand; it must come from another seed than ``seed`` and
        ``seed`` + 1.
    progress : callable or None, optional
        Called with the fraction done, in (0, 1].

    Returns
    -------
    dict of str to PValue
        By the names of the statistics.

    Raises
    ------
    InvalidInput
        For a path or counts that cannot be used; what ``refit`` raises passes through.

    Notes
    -----
    The null is the same statistics of ``runs`` simulated collections, as long and from the same
    start.

    Without ``refit`` the values are exact: P(p ≤ a) ≤ a under the null for any n and ``runs``
    (Davison & Hinkley 1997, chapter 4), whatever the ensemble's size. With it they are so to
    first order in the error of the fit: true models that wear, fitted with two harmonics to 300
    cycles, are measured to be rejected at the 5 % level in 3 to 6 % of runs, at 10 % in 6 to 11
    %.

    References
    ----------
    Davison, A. C. & Hinkley, D. V. (1997), Bootstrap methods and their application, Cambridge,
    chapter 4.

    Examples
    --------
    >>> from cyclemap import CircleMap, DriftingMap, WrappedNormal
    >>> from cyclemap.evidence import CollectionModel, collection_p_values
    >>> fresh, old = CircleMap.arnold(0.05, 0.3), CircleMap.arnold(0.1, 0.3)
    >>> worn = CollectionModel(DriftingMap.between([(0, fresh), (200, old)]), WrappedNormal(0.2))
    >>> path = worn.paths(0.0, 200, 1, seed=5)[0]
    >>> still = CollectionModel(fresh, WrappedNormal(0.2))
    >>> [collection_p_values(path, model)["turns"].value < 0.05 for model in (worn, still)]
    [False, True]
    """
    path = finite_array("theta", theta, ndim=1)
    if path.size < 2:
        raise InvalidInput(
            f"theta holds {path.size} orientations: a chain needs at least two, in order"
        )
    count = whole_number("runs", runs, least=1)
    first_seed = whole_number("seed", seed, least=0)
    chosen = collection_statistics() if statistics is None else statistics
    size = max(count, 200) if refit is None else _REFIT_ENSEMBLE
    known = ensemble or simulated_ensemble(model, float(path[0]), path.size, size, first_seed + 1)
    paths = model.paths(float(path[0]), path.size, count, first_seed)

    def values(collections: Array, against: Ensemble) -> dict[str, Array]:
        measured = {}
        for name, measure in chosen.items():
            measured[name] = finite_array("the statistic's values", measure(collections, against))
            if measured[name].shape != (len(collections),):
                raise InvalidInput(
                    f"the statistic gave shape {measured[name].shape} for {len(collections)} "
                    "paths: give one value a path"
                )
        return measured

    observed = values(path[None], known)
    if refit is None:
        null = values(paths, known)
    else:
        parts = []
        for index, made in enumerate(paths):
            # An ensemble of the simulated collection's own fit, made as the measured one's was.
            own = simulated_ensemble(
                refit(made), float(made[0]), made.size, known.paths.shape[0], first_seed + 1
            )
            parts.append(values(made[None], own))
            part_of(progress, index, len(paths))(1.0)
        null = {name: np.concatenate([row[name] for row in parts]) for name in chosen}
    part_of(progress, 0, 1)(1.0)
    return {name: monte_carlo_p_value(float(observed[name][0]), null[name]) for name in chosen}
