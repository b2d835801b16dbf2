"""compare: a prediction set beside a collection, question by question."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.comparison.collection_data import CollectionData, collection_data
from cyclemap.evidence.comparison.collection_null import (
    CollectionModel,
    Predictor,
    as_prediction,
    collection_p_values,
    collection_statistics,
    simulated_ensemble,
)
from cyclemap.evidence.comparison.cycle_agreement import (
    CycleAgreement,
    DirectionAgreement,
    OrientationAgreement,
    StaircaseAgreement,
    cycle_agreement,
    direction_agreement,
    map_misfit,
    orientation_agreement,
    staircase_agreement,
)
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    push_agreements,
)
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.evidence.tables.columns import Selection
from cyclemap.maps import CircleMap, DriftingMap, Noise, StaircaseSummary, predict_staircase
from cyclemap.progress import Progress, part_of

# A collection shorter than this has no steps or modes worth a test.
SHORTEST_COLLECTION = 10
# Collections of the ensemble that gives the predicted law.
ENSEMBLE = 200
# Simulated collections whose steps and modes are found: they take some 60 ms each for 1500 cycles.
MOST_DETAILED = 99


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction beside data; what could not be asked is None or empty.

    Attributes
    ----------
    prediction : CollectionModel
        As it was used.
    data : CollectionData
        As they were used; ``data.left_out`` counts what was not.
    pushes : tuple of PushAgreement
        One a set, the largest first.
    cycle : CycleAgreement or None
        The cycle map's turns.
    orientations : OrientationAgreement or None
        The histogram.
    directions : DirectionAgreement or None
        Stable ones and slow zones.
    staircase : StaircaseAgreement or None
        Turns, steps, dwells.
    uncertified : tuple of str
        What could not be computed to its tolerance, in words.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, compare, sample_staircase
    >>> from cyclemap.evidence import Theta0Pairs
    >>> sine, noise = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.1)
    >>> path = sample_staircase(sine, noise, 100).theta
    >>> found = compare(sine, Theta0Pairs(path[:-1], path[1:], path), noise=noise, runs=19)
    >>> found.cycle.agreement.pairs, found.pushes
    (100, ())
    """

    prediction: CollectionModel
    data: CollectionData
    pushes: tuple[PushAgreement, ...] = ()
    cycle: CycleAgreement | None = None
    orientations: OrientationAgreement | None = None
    directions: DirectionAgreement | None = None
    staircase: StaircaseAgreement | None = None
    uncertified: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """What predicted: ``loop``, ``map`` or ``drifting map``."""
        if self.data.loop is not None:
            return "loop"
        return "map" if isinstance(self.prediction.map, CircleMap) else "drifting map"

    @property
    def middle(self) -> float:
        """The push in the middle of those compared, whose map stands for all where the surface
        wears.
        """
        pairs = self.data.pairs
        return 0.0 if pairs is None else float(np.median(pairs.numbers))


def compare(
    prediction: Predictor,
    data: PushTable | Theta0Pairs | str | Path,
    *,
    noise: Noise | None = None,
    first: int = 0,
    select: Selection | None = None,
    push_length: float | None = None,
    runs: int = 199,
    seed: int = 0,
    tolerance: float = 1e-5,
    progress: Progress | None = None,
) -> Comparison:
    """Set a prediction beside measured data.

    Parameters
    ----------
    prediction : CollectionLoop, CircleMap or DriftingMap
        The loop's mechanics, or a map with ``noise``. Cycle n of a map that wears is push n.
    data : PushTable, Theta0Pairs, str or Path
        A table, pairs, or the path of a file or folder of either.
    noise : Noise or None, optional
        Of one cycle; None takes 1.1 degrees for a loop.
    first : int, default 0
        Pushes numbered below it are left out (500 leaves out the bedding-in of a fresh
        surface).
    select : mapping of str to str or float or None, optional
        The surface, object, speed, side, fraction or angle (SI units, rad) of the pushes that
        are compared.
    push_length : float or None, optional
        How far the rod moved, m, where the data do not tell; None leaves such pushes out.
    runs : int, default 199
        Simulated collections of the null; the smallest p-value is 1/(runs + 1), 1/100 for
        directions, steps and residences.
    seed : int, default 0
        Of all of them.
    tolerance : float, default 1e-5
        Error of the loop's cycle map, rad.
    progress : callable, optional
        Called with the fraction done, in [0, 1].

    Returns
    -------
    Comparison
        What could be asked, and its answers.

    Raises
    ------
    InvalidInput
        For a prediction or data that cannot be used.
    DataFileError
        For a bad file.
    ConvergenceError
        Where the loop's cycle map cannot be computed.

    Notes
    -----
    A loop predicts what was done: object, side, place, direction and length of every push are the
    data's, by their columns or by the rod's places, and of the protocol where they do not tell.
    Pushes on a surface that the data name and that is not the material's are left out by name; a
    material whose name tells no surface, such as ``mine`` or ``isotropic``, is set beside one
    surface at a time. Of orientations alone nothing of that is known: the protocol is taken to have
    made them.

    P-values come from simulated collections, as long as the measured one and from the same start,
    under the predicted map and noise: autocorrelation and wear are in them. Of a map that was
    fitted to these very data they are too large (``collection_p_values`` can fit again). Where a
    loop's material has a posterior, each simulated collection is of one of its samples, and errors
    of means hold what the parameters leave open. The noise of successive cycles is taken as
    independent: where ``cycle.lag_correlation`` is far from 0 it is not, and the p-values are too
    small.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal, compare, sample_staircase
    >>> from cyclemap.evidence import Theta0Pairs
    >>> sine, noise = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.1)
    >>> path = sample_staircase(sine, noise, 100).theta
    >>> found = compare(sine, Theta0Pairs(path[:-1], path[1:], path), noise=noise, runs=19)
    >>> found.orientations.tests["watson"].value > 0.05, found.cycle.agreement.rms < 0.12
    (True, True)
    >>> len(found.directions.matches)
    1
    """
    count = whole_number("runs", runs, least=1)
    loop = None
    if not isinstance(prediction, CircleMap | DriftingMap) and hasattr(prediction, "circle_map"):
        loop = prediction
    collection = collection_data(
        data,
        loop,
        first=first,
        select=select,
        push_length=push_length,
        progress=part_of(progress, 0, 4),
    )
    pairs = collection.pairs
    wanted = 1
    if pairs is not None:
        # Flagged rows make no pair and stay in the path; behind the last pair there is a push more.
        last = 0.0 if pairs.path_cycle is None else float(np.max(pairs.path_cycle))
        wanted += int(max(last, 1.0 + float(np.max(pairs.numbers))))
    given = collection.loop or prediction
    chosen = as_prediction(
        given, noise, wanted, tolerance=tolerance, progress=part_of(progress, 1, 4)
    )
    pushes, unanswered = push_agreements(collection.pushes, part_of(progress, 2, 4))
    if unanswered:
        left_out = {**collection.left_out, "the mechanics have no answer": unanswered}
        collection = replace(collection, left_out=left_out)
    rest = _cycles_asked(chosen, collection, count, seed, part_of(progress, 3, 4))
    part_of(progress, 0, 1)(1.0)
    return replace(rest, pushes=pushes)


def _cycles_asked(
    model: CollectionModel, data: CollectionData, runs: int, seed: int, report: Progress
) -> Comparison:
    """All but the pushes: the cycle map, and where the order of the pushes is known what follows
    from it.
    """
    pairs = data.pairs
    if pairs is None:
        return Comparison(model, data)
    path = pairs.path
    if path is None or pairs.path_cycle is None or path.size < SHORTEST_COLLECTION:
        return Comparison(model, data, cycle=cycle_agreement(model, data.loop, pairs))
    first = int(pairs.path_cycle[0])
    start = float(path[0])
    uncertain = replace(model, first=first)
    certain = replace(uncertain, samples=())
    ensemble = simulated_ensemble(certain, start, path.size, ENSEMBLE, seed + 2)
    statistics = {**collection_statistics(), "map": map_misfit}
    tested = collection_p_values(
        path,
        uncertain,
        statistics,
        runs=runs,
        seed=seed,
        ensemble=ensemble,
        progress=part_of(report, 0, 2),
    )
    null = uncertain.paths(start, path.size, min(runs, MOST_DETAILED), seed)
    summary, uncertified = _theory(model, first + path.size // 2)
    zones = () if summary is None else summary.zones
    fixed = summary if isinstance(model.map, CircleMap) else None
    return Comparison(
        model,
        data,
        cycle=cycle_agreement(model, data.loop, pairs, tested["map"]),
        orientations=orientation_agreement(path, ensemble, tested),
        directions=direction_agreement(path, zones, ensemble, null),
        staircase=staircase_agreement(path, null, fixed, part_of(report, 1, 2)),
        uncertified=uncertified,
    )


def _theory(model: CollectionModel, middle: int) -> tuple[StaircaseSummary | None, tuple[str, ...]]:
    """What theory says of the map, or of that of the cycle at mid-run where it wears; and in words
    what it cannot say.
    """
    try:
        return predict_staircase(model.map_at(middle), model.noise), ()
    except (ConvergenceError, InvalidInput) as error:
        return None, (f"stable directions and visits: {error}",)
