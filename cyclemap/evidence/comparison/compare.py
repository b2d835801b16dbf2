"""compare: a prediction set beside a collection, question by question, and its verdicts in words
with numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.comparison.collection_data import CollectionData, collection_data
from cyclemap.evidence.comparison.cycle_agreement import (
    CycleAgreement,
    DirectionAgreement,
    DirectionMatch,
    OrientationAgreement,
    SimulatedQuantity,
    StaircaseAgreement,
    cycle_agreement,
    direction_agreement,
    map_misfit,
    orientation_agreement,
    staircase_agreement,
)
from cyclemap.evidence.comparison.prediction import Prediction, as_prediction
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    QuantityAgreement,
    mean_distances,
    pooled_quantities,
    push_agreements,
)
from cyclemap.evidence.orientations.circular_distance import PValue
from cyclemap.evidence.orientations.collection_null import (
    collection_p_values,
    collection_statistics,
    simulated_ensemble,
)
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import Noise, StaircaseSummary, predict_staircase

# A collection shorter than this has no steps or modes worth a test.
FEWEST_CYCLES = 10
# Collections of the ensemble that gives the predicted law.
ENSEMBLE = 200
# Simulated collections whose steps and modes are found: they take some 60 ms each for 1500 cycles.
MOST_DETAILED = 99

# More sets of pushes than this are told as one.
MOST_SETS = 3
# A prediction is rejected below this p-value.
LEVEL = 0.05
_DEG = float(np.degrees(1.0))
# Of each quantity its name for people, its unit, and the factor to that.
_NAMES = {
    "dtheta": ("turn of a push", "°", _DEG),
    "dx": ("Δx", " mm", 1000.0),
    "dy": ("Δy", " mm", 1000.0),
}
# Of each number of a staircase its name, the factor to its unit, that unit, and how many decimals
# are told: the least, and the most, where fewer leave its interval no width.
_STAIRCASE = {
    "turns": ("number of turns", 1.0, " turns", 1, 2),
    "steps": ("number of steps", 1.0, " steps", 0, 0),
    "step_height": ("step height", _DEG, "°", 0, 1),
    "residence": ("residence on a step", 1.0, " cycles", 0, 1),
}
_KINDS = {"stable": "stable direction", "jump": "attracting jump", "ghost": "slow zone"}

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Verdict:
    """The answer to one question.

    Attributes
    ----------
    question : str
        What was asked.
    agrees : bool or None
        The answer, None where it is open.
    words : str
        A sentence with its numbers.

    Examples
    --------
    >>> Verdict("Does the map agree?", True, "It does: 1.2 degrees apart.").agrees
    True
    """

    question: str
    agrees: bool | None
    words: str


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction beside data; what could not be asked is None or empty.

    Attributes
    ----------
    prediction : Prediction
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
    >>> from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.1)
    >>> path = sample_staircase(sine, noise, 100).theta
    >>> found = compare(sine, Theta0Pairs(path[:-1], path[1:], path), noise=noise, runs=19)
    >>> [verdict.agrees for verdict in found.verdicts], found.pushes
    ([True, True, True, True, True], ())
    """

    prediction: Prediction
    data: CollectionData
    pushes: tuple[PushAgreement, ...]
    cycle: CycleAgreement | None
    orientations: OrientationAgreement | None
    directions: DirectionAgreement | None
    staircase: StaircaseAgreement | None
    uncertified: tuple[str, ...] = ()

    @property
    def middle(self) -> float:
        """The push in the middle of those compared, whose map stands for all where the surface
        wears.
        """
        pairs = self.data.pairs
        return 0.0 if pairs is None or pairs.cycle is None else float(np.median(pairs.cycle))

    @property
    def told_pushes(self) -> tuple[tuple[str, tuple[QuantityAgreement, ...]], ...]:
        """The sets of pushes by name with their quantities; more than three are taken together."""
        if len(self.pushes) > MOST_SETS:
            return ((f" in {len(self.pushes)} sets", pooled_quantities(self.pushes)),)
        return tuple((one.name, one.quantities) for one in self.pushes)

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The answer to each question that could be asked, in words with numbers (degrees,
        millimetres).
        """
        pooled, found = len(self.pushes) > MOST_SETS, list[Verdict]()
        for name, quantities in self.told_pushes:
            found += [_push_verdict(quantity, name, pooled) for quantity in quantities]
        if self.pushes:
            # What knowing the friction is worth: distances, not coordinates; nothing is tested.
            (off, turned), (even, even_turn) = mean_distances(self.pushes)
            beside = f"isotropic friction is {1e3 * even:.1f} mm and {_degrees(even_turn)} off"
            words = (
                f"Pushes end {1e3 * off:.1f} mm and {_degrees(turned)} from the prediction "
                f"on average; {beside}."
            )
            found.append(Verdict("ends of pushes", None, words))
        if self.cycle is not None:
            found += _cycle_verdicts(self.cycle)
        if self.orientations is not None:
            # By Watson's test, the others told beside it: one test decides, so that the level
            # holds.
            tests = self.orientations.tests
            p, kept = {name: _p(one) for name, one in tests.items()}, _kept(tests["watson"])
            wasserstein, varied = (
                tests[name].statistic for name in ("wasserstein", "total_variation")
            )
            by_watson = f"{'agrees' if kept else 'is rejected'} by Watson's test ({p['watson']})"
            words = (
                f"The histogram of {self.orientations.count} directions {by_watson}: "
                "Wasserstein distance "
            )
            words += f"{_degrees(wasserstein)} ({p['wasserstein']}), total variation {varied:.2f} "
            words += f"({p['total_variation']}), Kuiper {p['kuiper']}."
            found.append(Verdict("histogram of directions", kept, words))
        if self.directions is not None:
            found += [_direction_verdict(one) for one in self.directions.matches]
        if self.staircase is not None:
            asked = ((_STAIRCASE[name], one) for name, one in self.staircase.quantities.items())
            found += [
                verdict
                for told, one in asked
                if (verdict := _quantity_verdict(*told, one)) is not None
            ]
        return tuple(found)


def compare(
    prediction: Any,
    data: PushTable | Theta0Pairs | str | Path,
    *,
    noise: Noise | None = None,
    first: int = 0,
    select: Mapping[str, str | float] | None = None,
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
    data's, and of the protocol where they do not tell. Pushes on a surface that the data name and
    that is not the material's are left out by name; a material whose name tells no surface, such as
    ``mine`` or ``isotropic``, is set beside one surface at a time. Of orientations alone nothing of
    that is known: the protocol is taken to have made them.

    P-values come from simulated collections, as long as the measured one and from the same start,
    under the predicted map and noise: autocorrelation and wear are in them. Of a map that was
    fitted to these very data they are too large (``collection_p_values`` can fit again). Where a
    loop's material has a posterior, each simulated collection is of one of its samples, and errors
    of means hold what the parameters leave open. The noise of successive cycles is taken as
    independent: where ``cycle.lag_correlation`` is far from 0 it is not, and the p-values are too
    small.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.1)
    >>> path = sample_staircase(sine, noise, 100).theta
    >>> found = compare(sine, Theta0Pairs(path[:-1], path[1:], path), noise=noise, runs=19)
    >>> found.orientations.tests["watson"].value > 0.05, found.cycle.agreement.rms < 0.12
    (True, True)
    >>> len(found.directions.matches)
    1
    """
    report, count = progress or (lambda fraction: None), whole_number("runs", runs, least=1)
    loop = prediction if callable(getattr(prediction, "circle_map", None)) else None
    collection = collection_data(
        data,
        loop,
        first=first,
        select=select,
        push_length=push_length,
        progress=lambda done: report(0.1 * done),
    )
    pairs = collection.pairs
    numbers = (
        () if pairs is None else [one for one in (pairs.cycle, pairs.path_cycle) if one is not None]
    )
    wanted = 1 + int(max((np.max(one) for one in numbers), default=0.0))
    given = prediction if loop is None else collection.loop
    chosen = as_prediction(
        given, noise, wanted, tolerance=tolerance, progress=lambda done: report(0.1 + 0.3 * done)
    )
    pushes, unanswered = push_agreements(collection.pushes, lambda done: report(0.4 + 0.3 * done))
    if unanswered:
        left_out = {**collection.left_out, "the mechanics have no answer": unanswered}
        collection = replace(collection, left_out=left_out)
    rest = _cycles_asked(chosen, collection, count, seed, lambda done: report(0.7 + 0.3 * done))
    report(1.0)
    return replace(rest, pushes=pushes)


def _cycles_asked(
    prediction: Prediction, data: CollectionData, runs: int, seed: int, report: Progress
) -> Comparison:
    """All but the pushes: the cycle map, and where the order of the pushes is known what follows
    from it.
    """
    pairs = data.pairs
    empty = Comparison(prediction, data, (), None, None, None, None)
    if pairs is None:
        return empty
    path = pairs.path
    if path is None or pairs.path_cycle is None or path.size < FEWEST_CYCLES:
        return replace(empty, cycle=cycle_agreement(prediction, pairs))
    first, start = int(pairs.path_cycle[0]), float(path[0])
    uncertain = prediction.model(first, uncertain=True)
    ensemble = simulated_ensemble(prediction.model(first), start, path.size, ENSEMBLE, seed + 2)
    statistics = {**collection_statistics(), "map": map_misfit}
    tested = collection_p_values(
        path,
        uncertain,
        statistics,
        runs=runs,
        seed=seed,
        ensemble=ensemble,
        progress=lambda done: report(0.5 * done),
    )
    null = uncertain.paths(start, path.size, min(runs, MOST_DETAILED), seed)
    summary: StaircaseSummary | None = None
    uncertified: tuple[str, ...] = ()
    try:
        # What theory says of the map, or of the map at mid-run where it wears.
        summary = predict_staircase(prediction.map_at(first + path.size // 2), prediction.noise)
    except (ConvergenceError, InvalidInput) as error:
        uncertified = (f"stable directions and visits: {error}",)
    fixed = None if prediction.is_drifting else summary
    return replace(
        empty,
        cycle=cycle_agreement(prediction, pairs, tested["map"]),
        orientations=orientation_agreement(path, ensemble, tested),
        directions=direction_agreement(
            path, () if summary is None else summary.zones, ensemble, null
        ),
        staircase=staircase_agreement(path, null, fixed, lambda done: report(0.5 + 0.4 * done)),
        uncertified=uncertified,
    )


def _push_verdict(found: QuantityAgreement, whose: str, pooled: bool) -> Verdict:
    """Whether the mean agrees, and how near the law comes to the single pushes."""
    name, unit, scale = _NAMES[found.name]
    if pooled:
        # Of several protocols the means cancel, so that only single pushes can tell; nothing is
        # tested.
        error = "" if found.bias_error is None else f" ± {scale * found.bias_error:.2f}{unit}"
        off = (
            f"RMSE {scale * found.rmse:.2f}{unit}, bias "
            f"{_fixed(scale * found.bias, 2)}{unit}{error}"
        )
        words = (
            f"Over {found.count} pushes{whose} the {name} is predicted with {off}; its "
            "standard deviation is "
        )
        return Verdict(f"{name}{whose}", None, f"{words}{scale * found.measured_std:.2f}{unit}.")
    error = _error(found, scale, unit)
    over = f"over {found.count} pushes{', ' if error else ''}{error}"
    # In per cent of the mean, too, unless that mean is nothing beside the spread.
    shares = (found.percent, found.std_percent) if found.std_percent < 100.0 else (None, None)
    rmse, least = (
        f"{scale * size:.2f}{unit}" + ("" if share is None else f" ({share:.1f} %)")
        for size, share in zip((found.rmse, found.measured_std), shares, strict=True)
    )
    better = "below" if found.explains else "not below"
    words = f"The mean {name}{whose} {_means(found, scale, unit)} "
    words += f"{over}; RMSE {rmse}, {better} the {least} that a law blind to θ0 can reach."
    return Verdict(f"mean {name}{whose}", found.agrees, words)


def _means(found: QuantityAgreement, scale: float, unit: str) -> str:
    kept = {True: "agrees within its error", False: "is off", None: "is"}[found.agrees]
    measured, predicted = (
        _fixed(scale * mean, 2) for mean in (found.measured_mean, found.predicted_mean)
    )
    return f"{kept}: {measured}{unit} measured, {predicted}{unit} predicted"


def _error(found: QuantityAgreement, scale: float, unit: str) -> str:
    """The error of a difference, and how much of it is that of the material's parameters."""
    if found.bias_error is None:
        return ""
    model = scale * found.model_error
    of_model = f", {model:.2f}{unit} of it the material's" if model >= 0.005 else ""
    return f"error of the difference {scale * found.bias_error:.2f}{unit}{of_model}"


def _cycle_verdicts(found: CycleAgreement) -> list[Verdict]:
    error, agreement = _error(found.turn, _DEG, "°"), found.agreement
    words = (
        f"The mean turn of a cycle {_means(found.turn, _DEG, '°')}{f' ({error})' if error else ''}."
    )
    question = Verdict("mean turn of a cycle", found.turn.agrees, words)
    beside = (
        ""
        if found.isotropic_rms is None
        else f" (isotropic friction {_degrees(found.isotropic_rms)})"
    )
    misfit = f"{agreement.pairs} cycles lie {_degrees(agreement.rms)} RMS from the map{beside}"
    if agreement.bins:
        misfit += f", the medians of {agreement.bins} directions {_degrees(agreement.bin_rms)}"
    if found.scatter is not None:
        misfit += f"; about the best smooth map of θ0 they scatter by {_degrees(found.scatter)}"
    if found.p_value is None:
        return [
            question,
            Verdict(
                "cycle map", None, f"{misfit}; their order is unknown, so the map is not tested."
            ),
        ]
    return [
        question,
        Verdict("cycle map", _kept(found.p_value), f"The map {_told(found.p_value)}: {misfit}."),
    ]


def _direction_verdict(found: DirectionMatch) -> Verdict:
    centre, predicted, measured = (
        None if angle is None else f"{_DEG * angle % 360.0:.1f}°"
        for angle in (found.centre, found.predicted_mode, found.measured_mode)
    )
    place = f"{_KINDS[found.kind]} at {centre}"
    if found.difference is None:
        return Verdict(
            place, None, f"The predicted {place} has no peak of a histogram to be set beside."
        )
    off = f"{round(_DEG * found.difference, 1) + 0.0:+.1f}° off".replace("-", "−")
    kept, told = (
        (None, "") if found.p_value is None else (_kept(found.p_value), f" ({_p(found.p_value)})")
    )
    words = (
        f"The predicted {place} makes a predicted peak at {predicted}, measured at {measured}: "
        f"{off}{told}."
    )
    return Verdict(place, kept, words)


def _quantity_verdict(
    name: str, scale: float, unit: str, least: int, most: int, found: SimulatedQuantity
) -> Verdict | None:
    """The verdict on a number of the staircase; None where it is no question."""
    if found.measured is None and found.predicted is None:
        return None
    digits = _telling_digits(found, scale, least, most)
    if digits is None:
        return None
    measured = (
        "none" if found.measured is None else f"{_fixed(scale * found.measured, digits)}{unit}"
    )
    if found.predicted is None or found.lower is None or found.upper is None:
        return Verdict(
            name, None, f"The {name}: {measured} measured, none in any simulated collection."
        )
    low, high = (_fixed(scale * edge, digits) for edge in (found.lower, found.upper))
    expected = (
        f"{_fixed(scale * found.predicted, digits)}{unit} predicted (95 % of collections: "
        f"{low} to {high})"
    )
    if found.p_value is None:
        return Verdict(name, None, f"The {name}: {measured} measured, {expected}.")
    return Verdict(
        name,
        _kept(found.p_value),
        f"The {name} {_told(found.p_value)}: {measured} measured, {expected}.",
    )


def _telling_digits(found: SimulatedQuantity, scale: float, least: int, most: int) -> int | None:
    """How many decimals show that the interval has a width; None where none does and the data lie
    in it, to rounding.

    All collections then have the number, the measured one among them, and nothing could be seen to
    fail.
    """
    if found.lower is None or found.upper is None or found.measured is None:
        return least
    values = [scale * value for value in (found.measured, found.lower, found.upper)]
    for digits in range(least, most + 1):
        shown, least_shown, most_shown = (_fixed(value, digits) for value in values)
        is_inside = found.lower <= found.measured <= found.upper
        if least_shown != most_shown and (shown not in (least_shown, most_shown) or is_inside):
            return digits
    measured, low, high = (round(value, most) for value in values)
    # A number that is no count may lie on the other side of a rounding.
    rounding = 1.5 * 10.0**-most if most else 0.0
    if low == high and abs(measured - low) <= rounding:
        return None
    return most


def _kept(found: PValue) -> bool:
    return found.value > LEVEL


def _told(found: PValue) -> str:
    return f"agrees ({_p(found)})" if _kept(found) else f"is rejected at {_p(found)}"


def _p(found: PValue) -> str:
    """A p-value, and where none of the runs came near, that it may be smaller."""
    least = 1.0 / (found.runs + 1)
    return (
        f"p ≤ {found.value:.2g}"
        if found.value <= least * (1.0 + 1e-9)
        else f"p = {found.value:.2g}"
    )


def _degrees(radians: float) -> str:
    return f"{_fixed(_DEG * radians, 1)}°"


def _fixed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")
