"""Bias, mixing and cost of a family's strategy, with their gradients in its continuous parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.resets.parameters.parameter_operator import DrawnCycle, Sensitivity
from cyclemap.resets.parameters.parameter_samples import (
    CycleSampler,
    CycleSamples,
    even_orientations,
    trigonometric_interpolation,
)
from cyclemap.resets.parameters.parameter_space import LawTangent, StrategyFamily, law_tangent
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.strategy_maps import strategy_maps
from cyclemap.suggestions import unknown_name

Array = NDArray[np.float64]

TOTAL_VARIATION, DEVIATION, SECOND_EIGENVALUE, REACH, MEAN_DRAG = (
    "total_variation",
    "deviation",
    "second_eigenvalue",
    "reach",
    "mean_drag_length",
)
SCORES = (TOTAL_VARIATION, DEVIATION, SECOND_EIGENVALUE, REACH, MEAN_DRAG)
# How a gradient, and how the maps, were found.
TANGENTS, DIFFERENCES = "tangents", "differences"
GRID, ADAPTIVE = "grid", "adaptive"

# Radians: a map that is interpolated no better than this is taken to jump, and sampled adaptively.
_UNRESOLVED = 0.03
_ADAPTIVE_TOLERANCE = 1e-3
# Share of a parameter's range for differences of scores.
_STEP = 1e-3


@dataclass(frozen=True)
class Resolution:
    """How finely scores are computed: good for a search, not for a certificate.

    samples : orientations from which each action is run. modes : Fourier modes of the laws. nodes : of a law, for a
    full turn. pushes : after so many the worst start is looked at.
    """

    samples: int = 64
    modes: int = 96
    nodes: int = 16
    pushes: int = 50

    def __post_init__(self) -> None:
        for name, least in (("samples", 8), ("modes", 4), ("nodes", 1), ("pushes", 1)):
            whole_number(name, getattr(self, name), least=least)

    @property
    def points(self) -> int:
        """Angles of the quadrature: enough for maps up to a slope of five at the highest mode."""
        return 6 * self.modes


@dataclass(frozen=True, eq=False)
class BiasGradient:
    """The scores of a family's strategy at its parameters (k,), and their gradients.

    value : (5,), in the order of SCORES: `total_variation` of the stationary law from uniform; `deviation`, half the
    root mean square deviation of its density over the mean, never less and smooth; `second_eigenvalue`, modulus, of one
    cycle; `reach`, the largest total variation from uniform over all starts after some pushes; `mean_drag_length`, m,
    over the law and even orientations. gradient : (5, k). by : (k,), `tangents`, those of the mechanics, or
    `differences` of the scores where there are none. interpolation_error : rad, of the worst map. route : `grid`, or
    `adaptive` where a map jumps. Nothing is certified; a law too peaked for the modes kept gives a total variation off
    by percents, which may exceed one.
    """

    family: StrategyFamily
    values: Array
    value: Array
    gradient: Array
    by: tuple[str, ...]
    interpolation_error: float
    route: str

    def score(self, name: str) -> float:
        """Return a score by name; InvalidInput for an unknown one."""
        return float(self.value[score_index(name)])

    def slopes(self, name: str) -> Array:
        """Return the gradient (k,) of a score by name."""
        return np.asarray(self.gradient[score_index(name)])


def score_index(name: str) -> int:
    """Return the place of a score among SCORES, or raise InvalidInput."""
    if name not in SCORES:
        raise unknown_name("score", name, SCORES)
    return SCORES.index(name)


def bias_gradient(
    loop: CollectionLoop,
    family: StrategyFamily,
    values: ArrayLike,
    noise: Noise,
    resolution: Resolution | None = None,
) -> BiasGradient:
    """Return bias, mixing and cost of the family's strategy at parameters (k,), with their gradients.

    With F_p = dF/dp of every action, by the chain rule through the CasADi tangents of push and legs, one cycle's matrix
    L_mk = kappa_m (1/2pi) int exp(i m F) exp(-i k theta) dtheta moves by kappa_m (1/2pi) int i m F_p exp(i m F)
    exp(-i k theta) dtheta; the stationary law follows by (I - L) dc = dL c, an eigenvalue by y dL x / y x, and all
    parameters at once from one transposed solve a score (Giles & Pierce 2000). Maps are interpolated from even samples,
    so that gradients are those of the numbers given, to the accuracy of the mechanics.

    The law's cycles must be drawn independently: else InvalidInput.

    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.parameters.parameter_families import ring_family
    >>> found = bias_gradient(CollectionLoop.mit(), ring_family(), (0.0, 0.015), WrappedNormal(0.1), Resolution(16, 32))
    >>> found.gradient.shape, found.by, found.route
    ((5, 2), ('tangents', 'tangents'), 'grid')
    """
    return StrategyEvaluator(loop, family, noise, resolution or Resolution()).at(values)


@dataclass(eq=False)
class StrategyEvaluator:
    """Evaluates a family's strategies on a loop, and keeps the cycles that it ran.

    evaluations : how many strategies were evaluated with gradient; differences count each of theirs.
    """

    loop: CollectionLoop
    family: StrategyFamily
    noise: Noise
    resolution: Resolution = field(default_factory=Resolution)
    evaluations: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.noise, Noise):
            raise InvalidInput(f"the noise is {self.noise!r}: give the law of the cycle's own, as WrappedNormal(0.02)")
        self.sampler = CycleSampler(self.resolution.samples)

    def at(self, values: ArrayLike) -> BiasGradient:
        """Return the scores and gradients at parameters (k,)."""
        given = self.family.checked(values)
        tangent = law_tangent(self.family, given, self.loop, self.resolution.nodes)
        _refuse_dependent(tangent)
        samples = self._samples(tangent, tangent.moving)
        error = max(one.interpolation_error for one in samples)
        self.evaluations += 1
        if error > _UNRESOLVED:
            value = self._adaptive(given)
            gradient = self._differences(given, range(given.size), self._adaptive)
            return self._result(given, value, gradient, (DIFFERENCES,) * given.size, error, ADAPTIVE)
        cycle = self._cycle(tangent, samples)
        scores = _scores(cycle, self.resolution.pushes)
        value = np.array([*(score.value for score in scores), _mean_drag(tangent, samples)])
        slopes = [self._score_slopes(tangent, samples, cycle, score) for score in scores]
        gradient = np.stack([*slopes, _drag_slopes(tangent, samples)])
        rough = np.flatnonzero(~tangent.smooth | ~np.all(np.isfinite(gradient), axis=0)).tolist()
        gradient[:, rough] = self._differences(given, rough, self.value_at)
        by = tuple(DIFFERENCES if index in rough else TANGENTS for index in range(given.size))
        return self._result(given, value, gradient, by, error, GRID)

    def value_at(self, values: ArrayLike) -> Array:
        """Return the scores (5,) alone, from even samples."""
        tangent = law_tangent(self.family, values, self.loop, self.resolution.nodes)
        _refuse_dependent(tangent)
        samples = self._samples(tangent, ())
        cycle = self._cycle(tangent, samples)
        found = [score.value for score in _scores(cycle, self.resolution.pushes)]
        return np.array([*found, _mean_drag(tangent, samples)])

    # -- inside --------------------------------------------------------------------------------------------

    def _result(
        self, values: Array, value: Array, gradient: Array, by: tuple[str, ...], error: float, route: str
    ) -> BiasGradient:
        return BiasGradient(self.family, read_only(values), read_only(value), read_only(gradient), by, error, route)

    def _samples(self, tangent: LawTangent, moving: tuple[str, ...]) -> list[CycleSamples]:
        return [self.sampler.sampled(tangent.at.loop, action, moving) for action in tangent.at.actions]

    def _cycle(self, tangent: LawTangent, samples: list[CycleSamples]) -> DrawnCycle:
        points = self.resolution.points
        fine = trigonometric_interpolation(self.resolution.samples, points)
        turns = np.array([one.turn for one in samples]) @ fine.T
        lifted = np.array([[action.turn] for action in tangent.at.actions])
        images = 2.0 * math.pi * np.arange(points) / points + turns + lifted
        return DrawnCycle(images, tangent.at.law.weights, self.noise, self.resolution.modes)

    def _score_slopes(
        self, tangent: LawTangent, samples: list[CycleSamples], cycle: DrawnCycle, score: Sensitivity
    ) -> Array:
        """The gradient (k,) of a score of the cycle."""
        by_image, by_weight = cycle.by_images(score)
        pulled = by_image @ trigonometric_interpolation(self.resolution.samples, self.resolution.points)
        rows = [row @ one.turn_by for row, one in zip(pulled, samples, strict=True)]
        return _by_parameters(tangent, samples, by_weight, rows, by_image.sum(axis=1))

    def _differences(self, values: Array, which: Sequence[int], scores: Callable[[Array], Array]) -> Array:
        """Central differences of the scores, (5, len(which)); one-sided at a bound."""
        columns = []
        for index in which:
            below, above = self.family.beside(values, index, _STEP)
            columns.append((scores(above) - scores(below)) / (above[index] - below[index]))
            self.evaluations += 2
        return np.array(columns).T if columns else np.empty((len(SCORES), 0))

    def _adaptive(self, values: Array) -> Array:
        """The scores (5,) from maps that keep their jumps."""
        size, strategy = self.resolution, self.family.strategy(values)
        maps = strategy_maps(self.loop, strategy, nodes=size.nodes, tolerance=_ADAPTIVE_TOLERANCE)
        angles = 2.0 * math.pi * np.arange(size.points) / size.points
        cycle = DrawnCycle(np.array([one(angles) for one in maps.maps]), maps.law.weights, self.noise, size.modes)
        drag = float(maps.mean_drag_length(even_orientations(size.samples)).mean())
        return np.array([*(score.value for score in _scores(cycle, size.pushes)), drag])


def _refuse_dependent(tangent: LawTangent) -> None:
    """Raise InvalidInput for a law of several actions that are not drawn independently."""
    law = tangent.at.law
    if len(law.actions) > 1 and law.kind != INDEPENDENT:
        raise InvalidInput(
            f"this law's cycles depend on each other ({law.kind}): gradients are those of independent draws; give "
            "schedule=Independent()"
        )


def _scores(cycle: DrawnCycle, pushes: int) -> tuple[Sensitivity, ...]:
    """The scores of the cycle, in the order of SCORES."""
    return cycle.total_variation(), cycle.deviation(), cycle.second_eigenvalue(), cycle.reach(pushes)


def _mean_drag(tangent: LawTangent, samples: list[CycleSamples]) -> float:
    return float(tangent.at.law.weights @ np.array([one.length.mean() for one in samples]))


def _drag_slopes(tangent: LawTangent, samples: list[CycleSamples]) -> Array:
    """The gradient (k,) of the mean drag's length, which does not know the gripper's turn."""
    weights = tangent.at.law.weights.tolist()
    rows = [weight * one.length_by.mean(axis=0) for weight, one in zip(weights, samples, strict=True)]
    by_weight = np.array([one.length.mean() for one in samples])
    return _by_parameters(tangent, samples, by_weight, rows, np.zeros(len(samples)))


def _by_parameters(
    tangent: LawTangent, samples: list[CycleSamples], by_weight: Array, rows: list[Array], by_turn: Array
) -> Array:
    """The chain rule, (k,): from derivatives by the weights, by what each action's samples name, and by its turn."""
    found = by_weight @ tangent.weights
    for index, (row, one) in enumerate(zip(rows, samples, strict=True)):
        slopes = dict(zip(one.names, row.tolist(), strict=True)) | {"turn": float(by_turn[index])}
        for name, moved in zip(tangent.at.names[index], tangent.numbers[index], strict=True):
            found = found + slopes[name] * moved if np.any(moved) else found
    return np.asarray(found)
