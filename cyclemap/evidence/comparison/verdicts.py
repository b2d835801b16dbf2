"""A comparison and its verdicts: the answer to each question, in words with numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.evidence.comparison.collection_data import CollectionData
from cyclemap.evidence.comparison.cycle_agreement import (
    CycleAgreement,
    DirectionAgreement,
    DirectionMatch,
    OrientationAgreement,
    SimulatedQuantity,
    StaircaseAgreement,
)
from cyclemap.evidence.comparison.prediction import Prediction
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    QuantityAgreement,
    mean_distances,
    pooled_quantities,
)
from cyclemap.evidence.orientations.circular_distance import PValue

# More sets of pushes than this are told as one.
MOST_SETS = 3
# A prediction is rejected below this p-value.
LEVEL = 0.05
_DEG = float(np.degrees(1.0))
# Of each quantity its name for people, its unit, and the factor to that.
_NAMES = {"dtheta": ("turn of a push", "°", _DEG), "dx": ("Δx", " mm", 1000.0), "dy": ("Δy", " mm", 1000.0)}
_KINDS = {"stable": "stable direction", "jump": "attracting jump", "ghost": "slow zone"}


@dataclass(frozen=True)
class Verdict:
    """question : what was asked. agrees : the answer, None where it is open. words : a sentence with its numbers."""

    question: str
    agrees: bool | None
    words: str


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction beside data; what could not be asked is None or empty.

    prediction, data : both as they were used; ``data.left_out`` counts what was not. pushes : one a set, the largest
    first. orientations : the histogram. directions : stable ones and slow zones. staircase : turns, steps, dwells.
    uncertified : what could not be computed to its tolerance, in words.
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
        """The push in the middle of those compared, whose map stands for all where the surface wears."""
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
        """The answer to each question that could be asked, in words with numbers (degrees, millimetres)."""
        pooled, found = len(self.pushes) > MOST_SETS, list[Verdict]()
        for name, quantities in self.told_pushes:
            found += [_push_verdict(quantity, name, pooled) for quantity in quantities]
        if self.pushes:
            # What knowing the friction is worth: distances, not coordinates; nothing is tested.
            (off, turned), (even, even_turn) = mean_distances(self.pushes)
            beside = f"isotropic friction is {1e3 * even:.1f} mm and {_degrees(even_turn)} off"
            words = f"Pushes end {1e3 * off:.1f} mm and {_degrees(turned)} from the prediction on average; {beside}."
            found.append(Verdict("ends of pushes", None, words))
        if self.cycle is not None:
            found += _cycle_verdicts(self.cycle)
        if self.orientations is not None:
            # By Watson's test, the others told beside it: one test decides, so that the level holds.
            tests = self.orientations.tests
            p, kept = {name: _p(one) for name, one in tests.items()}, _kept(tests["watson"])
            wasserstein, varied = (tests[name].statistic for name in ("wasserstein", "total_variation"))
            by_watson = f"{'agrees' if kept else 'is rejected'} by Watson's test ({p['watson']})"
            words = f"The histogram of {self.orientations.count} directions {by_watson}: Wasserstein distance "
            words += f"{_degrees(wasserstein)} ({p['wasserstein']}), total variation {varied:.2f} "
            words += f"({p['total_variation']}), Kuiper {p['kuiper']}."
            found.append(Verdict("histogram of directions", kept, words))
        if self.directions is not None:
            found += [_direction_verdict(one) for one in self.directions.matches]
        if self.staircase is not None:
            asked = [
                _quantity_verdict("number of turns", self.staircase.turns, 1.0, " turns", 1),
                _quantity_verdict("number of steps", self.staircase.step_count, 1.0, " steps", 0),
                _quantity_verdict("step height", self.staircase.step_height, _DEG, "°", 0),
                _quantity_verdict("residence on a step", self.staircase.residence, 1.0, " cycles", 0),
            ]
            found += [one for one in asked if one is not None]
        return tuple(found)


def _push_verdict(found: QuantityAgreement, whose: str, pooled: bool) -> Verdict:
    """Whether the mean agrees, and how near the law comes to the single pushes."""
    name, unit, scale = _NAMES[found.name]
    if pooled:
        # Of several protocols the means cancel, so that only single pushes can tell; nothing is tested.
        error = "" if found.bias_error is None else f" ± {scale * found.bias_error:.2f}{unit}"
        off = f"RMSE {scale * found.rmse:.2f}{unit}, bias {_fixed(scale * found.bias, 2)}{unit}{error}"
        words = f"Over {found.count} pushes{whose} the {name} is predicted with {off}; its standard deviation is "
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
    measured, predicted = (_fixed(scale * mean, 2) for mean in (found.measured_mean, found.predicted_mean))
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
    words = f"The mean turn of a cycle {_means(found.turn, _DEG, '°')}{f' ({error})' if error else ''}."
    question = Verdict("mean turn of a cycle", found.turn.agrees, words)
    beside = "" if found.isotropic_rms is None else f" (isotropic friction {_degrees(found.isotropic_rms)})"
    misfit = f"{agreement.pairs} cycles lie {_degrees(agreement.rms)} RMS from the map{beside}"
    if agreement.bins:
        misfit += f", the medians of {agreement.bins} directions {_degrees(agreement.bin_rms)}"
    if found.scatter is not None:
        misfit += f"; about the best smooth map of θ0 they scatter by {_degrees(found.scatter)}"
    if found.p_value is None:
        return [question, Verdict("cycle map", None, f"{misfit}; their order is unknown, so the map is not tested.")]
    return [question, Verdict("cycle map", _kept(found.p_value), f"The map {_told(found.p_value)}: {misfit}.")]


def _direction_verdict(found: DirectionMatch) -> Verdict:
    centre, predicted, measured = (
        None if angle is None else f"{_DEG * angle % 360.0:.1f}°"
        for angle in (found.centre, found.predicted_mode, found.measured_mode)
    )
    place = f"{_KINDS[found.kind]} at {centre}"
    if found.difference is None:
        return Verdict(place, None, f"The predicted {place} has no peak of a histogram to be set beside.")
    off = f"{round(_DEG * found.difference, 1) + 0.0:+.1f}° off".replace("-", "−")
    kept, told = (None, "") if found.p_value is None else (_kept(found.p_value), f" ({_p(found.p_value)})")
    words = f"The predicted {place} makes a predicted peak at {predicted}, measured at {measured}: {off}{told}."
    return Verdict(place, kept, words)


def _quantity_verdict(name: str, found: SimulatedQuantity, scale: float, unit: str, digits: int) -> Verdict | None:
    if found.measured is None and found.predicted is None:
        return None
    measured = "none" if found.measured is None else f"{_fixed(scale * found.measured, digits)}{unit}"
    if found.predicted is None or found.lower is None or found.upper is None:
        return Verdict(name, None, f"The {name}: {measured} measured, none in any simulated collection.")
    low, high = (_fixed(scale * edge, digits) for edge in (found.lower, found.upper))
    expected = f"{_fixed(scale * found.predicted, digits)}{unit} predicted (95 % of collections: {low} to {high})"
    if found.p_value is None:
        return Verdict(name, None, f"The {name}: {measured} measured, {expected}.")
    return Verdict(name, _kept(found.p_value), f"The {name} {_told(found.p_value)}: {measured} measured, {expected}.")


def _kept(found: PValue) -> bool:
    return found.value > LEVEL


def _told(found: PValue) -> str:
    return f"agrees ({_p(found)})" if _kept(found) else f"is rejected at {_p(found)}"


def _p(found: PValue) -> str:
    """A p-value, and where none of the runs came near, that it may be smaller."""
    least = 1.0 / (found.runs + 1)
    return f"p ≤ {found.value:.2g}" if found.value <= least * (1.0 + 1e-9) else f"p = {found.value:.2g}"


def _degrees(radians: float) -> str:
    return f"{_fixed(_DEG * radians, 1)}°"


def _fixed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")
