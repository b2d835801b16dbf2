"""Intervals by profile likelihood: how far one parameter may go while the others do their best to make up for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.evidence.identification.identifiability import Uncertainty, student_quantile
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import NO_ANSWER, Fit, minimise
from cyclemap.evidence.identification.noise_scales import NoiseLaw

Array = NDArray[np.float64]

# Fits a side, at most; the root is found when it is this close, as a share of the target.
_FITS = 6
_CLOSE = 0.01
# A deviance lower than the best by more than this is another, better minimum.
_BETTER = 0.01


@dataclass(frozen=True, eq=False)
class Interval:
    """Where a parameter may lie.

    lower, upper : the ends. lower_open, upper_open : the end is a bound of the parameter that the data do not exclude.
    resolved : both ends are found or open; else an end lies somewhere beyond what is given. fits : made for it.
    better : a point (k,) of lower deviance than the fit's, if one was met.
    """

    lower: float
    upper: float
    lower_open: bool
    upper_open: bool
    resolved: bool = True
    fits: int = 0
    better: Array | None = None

    @property
    def identifiable(self) -> bool:
        """Whether the data exclude anything."""
        return not (self.lower_open and self.upper_open)


def covariance_interval(problem: JointProblem, fit: Fit, errors: Uncertainty, name: str, level: float) -> Interval:
    """Return value -+ t standard errors, cut at the bounds."""
    index, bounds = problem.space.names.index(name), problem.space[name]
    half = student_quantile(level, float(errors.freedom[index])) * float(errors.standard_error[index])
    lower, upper = float(fit.vector[index]) - half, float(fit.vector[index]) + half
    return Interval(max(lower, bounds.lower), min(upper, bounds.upper), lower <= bounds.lower, upper >= bounds.upper)


def profile_interval(
    problem: JointProblem, fit: Fit, errors: Uncertainty, name: str, level: float, law: NoiseLaw | None = None
) -> Interval:
    """Return the interval in which the signed root of the profile deviance stays within Student's t.

    The noise is held, so that the rise of the deviance is F(1, freedom) distributed to first order
    (Bates & Watts 1988, chapter 6); where rows share groups it is divided by the inflation of the variance. Each side
    takes at most six fits of the other parameters, each started from the last, and inverse interpolation of the root,
    which is nearly a straight line. A parameter without any influence, or part of a direction that the data do not see,
    has its whole range for an interval.
    """
    bounds, index = problem.space[name], problem.space.names.index(name)
    if errors.influence[index] == 0.0 or not np.isfinite(errors.standard_error[index]):
        return Interval(bounds.lower, bounds.upper, True, True)
    target = student_quantile(level, float(errors.freedom[index]))
    sides = [_Side(problem, fit, errors, name, sign, target, law or NoiseLaw()) for sign in (-1.0, 1.0)]
    (lower, lower_open, lower_found), (upper, upper_open, upper_found) = (side.end() for side in sides)
    better = min((side.best for side in sides), key=lambda best: best[0])[1]
    found, fits = lower_found and upper_found, sum(side.fits for side in sides)
    return Interval(lower, upper, lower_open, upper_open, found, fits, better)


class _Side:
    """The search for one end of a profile interval; distances run from the fit outwards."""

    def __init__(
        self, problem: JointProblem, fit: Fit, errors: Uncertainty, name: str, sign: float, target: float, law: NoiseLaw
    ) -> None:
        self.problem, self.fit, self.law, self.name, self.sign, self.target = problem, fit, law, name, sign, target
        self.index = problem.space.names.index(name)
        self.value, bounds = float(fit.vector[self.index]), problem.space[name]
        self.room = (bounds.upper - self.value) if sign > 0.0 else (self.value - bounds.lower)
        self.bound = bounds.upper if sign > 0.0 else bounds.lower
        self.inflation = max(float(errors.inflation[self.index]), 1e-6)
        error = float(errors.standard_error[self.index])
        self.step = target * error if np.isfinite(error) and error > 0.0 else bounds.scale
        self.origin = np.delete(fit.vector, self.index)
        self.others, self.last = self.origin, self.value
        self.slope = _response(errors, self.index)
        self.distances, self.roots, self.fits = [0.0], [0.0], 0
        self.best: tuple[float, Array | None] = (fit.deviance - _BETTER, None)

    def end(self) -> tuple[float, bool, bool]:
        """Return the end, whether it is the bound, and whether it is found."""
        trial, limit = min(self.step, self.room), np.inf
        while self.fits < _FITS:
            if self.room <= 1e-9 * max(self.step, 1e-300):
                return self.bound, True, True
            root = self._root(trial)
            if root is None:
                limit, trial = trial, 0.5 * (trial + self.distances[-1])
                continue
            self._remember(trial, root)
            if abs(root - self.target) < _CLOSE * self.target:
                return self.value + self.sign * self._interpolated(), False, True
            if root < self.target and trial >= self.room:
                return self.bound, True, True
            trial = self._next(limit)
        reached = self.roots[-1] >= self.target
        if not np.isfinite(self.room) and self.roots[-1] < 0.3 * self.target:
            return self.bound, True, True
        return self.value + self.sign * (self._interpolated() if reached else self.distances[-1]), False, reached

    def _root(self, distance: float) -> float | None:
        """Signed root of the profile deviance at a distance; None where the model has no answer."""
        value = self.value + self.sign * distance if distance < self.room else self.bound
        held = self.problem.holding(self.name, value)
        start = np.clip(self._guess(value), held.space.lower, held.space.upper)
        self.fits += 1
        try:
            found = minimise(held, start, self.fit.noise, self.law, 1e-7)
        except NO_ANSWER:
            return None
        rise = found.deviance - self.fit.deviance
        if found.deviance < self.best[0]:
            self.best = found.deviance, np.insert(found.vector, self.index, value)
        self.others, self.last = found.vector, value
        return float(np.sqrt(max(rise, 0.0) / self.inflation))

    def _guess(self, value: float) -> Array:
        """The other parameters to begin with: along the response seen so far, or that of the covariance."""
        passed = self.last - self.value
        if passed == 0.0:
            return np.asarray(self.origin + (value - self.value) * self.slope)
        return np.asarray(self.origin + min((value - self.value) / passed, 2.0) * (self.others - self.origin))

    def _remember(self, distance: float, root: float) -> None:
        place = int(np.searchsorted(self.distances, distance))
        self.distances.insert(place, distance)
        self.roots.insert(place, root)

    def _interpolated(self) -> float:
        """Distance at which the root meets the target: inverse quadratic through three points where they rise."""
        roots, distances = np.array(self.roots), np.array(self.distances)
        near = np.sort(np.argsort(np.abs(roots - self.target))[:3])
        if len(near) == 3 and np.all(np.diff(roots[near]) > 1e-9):
            ratio = np.polyfit(roots[near], distances[near], 2)
            value = float(np.polyval(ratio, self.target))
            below, above = distances[roots < self.target], distances[roots >= self.target]
            if np.max(below, initial=0.0) < value < np.min(above, initial=np.inf):
                return value
        last = int(np.clip(np.searchsorted(roots, self.target), 1, len(roots) - 1))
        share = (self.target - roots[last - 1]) / max(roots[last] - roots[last - 1], 1e-300)
        return float(distances[last - 1] + share * (distances[last] - distances[last - 1]))

    def _next(self, limit: float) -> float:
        """The next distance to try: within the bracket, or outwards by no more than threefold."""
        furthest = self.distances[-1]
        if self.roots[-1] >= self.target:
            return self._interpolated()
        if self.roots[-1] < 0.3 * self.target:
            guess = min(10.0 * furthest, self.room) if np.isfinite(self.room) else 10.0 * furthest
            guess = self.room if self.fits >= 3 and np.isfinite(self.room) else guess
        else:
            guess = min(max(self._interpolated(), 1.05 * furthest), 3.0 * furthest, self.room)
        return min(guess, 0.5 * (furthest + limit)) if guess >= limit else guess


def _response(errors: Uncertainty, index: int) -> Array:
    """How the others follow one parameter to first order, (k - 1,)."""
    variance = float(errors.covariance[index, index])
    column = np.delete(errors.covariance[:, index], index)
    return np.asarray(column / variance) if variance > 0.0 else np.zeros(len(column))
