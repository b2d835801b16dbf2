"""What is predicted of a collection: a loop, a map or one that wears, brought to one form."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array, evenly_spread
from cyclemap.collection import CollectionLoop, drifting_map
from cyclemap.collection.loop_surfaces import BLEND_TOLERANCE, on_material
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.comparison.collection_null import CollectionModel
from cyclemap.maps import CircleMap, DriftingMap, Noise, WrappedNormal
from cyclemap.progress import Progress, part_of

# Samples of a material's posterior that are used, and how good their maps are, rad: they tell a
# spread.
SAMPLES = 32
_SAMPLE_TOLERANCE, _SAMPLE_BLEND = 1e-3, 1e-2

Predictor = CollectionLoop | CircleMap | DriftingMap


@dataclass(frozen=True, eq=False)
class Prediction:
    """A prediction in one form.

    map : of the cycle; cycle n of a drifting one is push n of the data, those dropped counted.
    noise : of one cycle.
    kind : "loop", "map" or "drifting map".
    given : what was handed in.
    samples : the maps of samples of the posterior of a loop's material, those that can be run; ()
        without a posterior.
    """

    map: CircleMap | DriftingMap
    noise: Noise
    kind: str
    given: Predictor
    samples: tuple[CircleMap | DriftingMap, ...] = ()

    @property
    def is_drifting(self) -> bool:
        """Whether the map changes with the cycle."""
        return isinstance(self.map, DriftingMap)

    def model(self, first: int, uncertain: bool = False) -> CollectionModel:
        """The model of a collection that begins with push ``first``; ``uncertain`` as far as the
        parameters are.
        """
        return CollectionModel(self.map, self.noise, first, self.samples if uncertain else ())

    def map_at(self, cycle: float) -> CircleMap:
        """The map of one push."""
        return self.map if isinstance(self.map, CircleMap) else self.map.at(cycle)

    def turns(self, theta: Array, cycle: Array) -> Array:
        """Turns (1 + k, n), rad, from ``theta`` (n,) in the pushes ``cycle`` (n,): of the map, then
        of each sample.
        """
        turns = []
        for known in (self.map, *self.samples):
            if isinstance(known, CircleMap):
                turns.append(known.turn(theta))
            else:
                turns.append(known.images(theta, cycle) - theta)
        return np.array(turns)


def as_prediction(
    given: Predictor,
    noise: Noise | None,
    last: int,
    *,
    tolerance: float = 1e-6,
    progress: Progress | None = None,
) -> Prediction:
    """Bring a prediction of pushes up to ``last`` to one form.

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
        kind = "map" if isinstance(given, CircleMap) else "drifting map"
        return Prediction(given, noise, kind, given)
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
            samples.append(
                _map_of(loop, last, _SAMPLE_TOLERANCE, _SAMPLE_BLEND, part_of(None, 0, 1))
            )
        part_of(progress, done, parts)(1.0)
    kept = tuple(samples) if len(samples) > 1 else ()
    return Prediction(chosen, noise or WrappedNormal(DEFAULT_SIGMA), "loop", given, kept)


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
