"""Weighted least squares over joint blocks: the noise of each kind estimated along, from several starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_number, positive_number, read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.identification.data_block import JointProblem, part_of
from cyclemap.suggestions import unknown_name

# Noise smaller than this share of the residuals at the start is no noise, but rounding.
_LEAST_NOISE = 1e-9
# A kind with fewer rows left over, once the parameters took their share, does not tell its noise.
_LEAST_REDUNDANCY = 0.5
# The noise of given residuals stands still at a change below this share, which takes a dozen rounds.
_WEIGHTINGS, _SETTLED = 100, 1e-4
# What the mechanics raise at parameters for which they have no answer.
NO_ANSWER = (ConvergenceError, UnsupportedContact, InvalidInput)
# The noise counts as found when no kind changes by more than this share: parameters then move by less than a twentieth
# of their standard errors. The first round need not be close, since its weights are not.
_NOISE_TOLERANCE = 5e-3
_FIRST, _LATER = 1e-2, 1e-5
# Evaluations after which half of a search counts as done: how many it takes is not known before.
_HALF_WAY = 15
_ROUNDS, _MOST = 40, 200
# A start arrived at the best optimum if its deviance is as low, or its parameters are the same in their scales.
_SAME_DEVIANCE, _SAME_PLACE = 0.01, 1e-3
_ON_BOUND = 1e-3


@dataclass(frozen=True)
class NoiseLaw:
    """Distribution of the standardised residuals: normal, or Student's with `freedom` degrees of freedom.

    With z the squared standardised residual, rho(z) = z, or (freedom + 1) log(1 + z / freedom), which lets outliers
    count for little (Lange, Little & Taylor 1989). Raises InvalidInput for a freedom of one or less.

    >>> NoiseLaw(4.0).weight(np.array([0.0, 96.0])).tolist()
    [1.25, 0.05]
    """

    freedom: float | None = None

    def __post_init__(self) -> None:
        if self.freedom is not None and finite_number("degrees of freedom of the noise", self.freedom) <= 1.0:
            raise InvalidInput(f"degrees of freedom of the noise must exceed one, not {self.freedom!r}")

    def loss(self, z: Array) -> Array:
        """Return rho, rho' and rho'' at squared standardised residuals (n,): (3, n)."""
        if self.freedom is None:
            return np.stack([z, np.ones_like(z), np.zeros_like(z)])
        m, weight = self.freedom, self.weight(z)
        return np.stack([(m + 1.0) * np.log1p(z / m), weight, -weight / (m + z)])

    def weight(self, z: Array) -> Array:
        """Return how much each row counts, rho'(z)."""
        return np.ones_like(z) if self.freedom is None else (self.freedom + 1.0) / (self.freedom + z)

    @property
    def information(self) -> float:
        """Fisher information of one row about its mean, in units of 1/noise^2."""
        return 1.0 if self.freedom is None else (self.freedom + 1.0) / (self.freedom + 3.0)


def noise_floor(problem: JointProblem, residuals: Array) -> Array:
    """Return the least size of each kind's noise, (kinds,), from the residuals of a first try."""
    return np.maximum(_LEAST_NOISE * root_mean_square(problem, residuals), 1e-30)


def root_mean_square(problem: JointProblem, residuals: Array) -> Array:
    """Return the root mean square of the residuals of each kind, (kinds,)."""
    index, count = problem.kind_index, len(problem.kind_names)
    return np.asarray(np.sqrt(np.bincount(index, residuals**2, count) / np.bincount(index, minlength=count)))


def estimated_noise(
    problem: JointProblem, residuals: Array, jacobian: Array, noise: Array, law: NoiseLaw, floor: Array, held: Array
) -> Array:
    """Return the next estimate (kinds,) of the noise, the residuals' sum of squares over their redundancy.

    The redundancy of a kind is its number of rows less their share in fixing the parameters, the trace of the hat
    matrix; repeated with a fit in between, this leads to restricted maximum likelihood (Foerstner 1979). Rows count as
    the noise found makes them count. `held` (kinds,) is noise that is known, nan elsewhere. Raises ConvergenceError
    where the parameters follow all rows of a kind, so that its noise cannot be told.
    """
    index, count = problem.kind_index, len(problem.kind_names)
    scaled = residuals / noise[index]
    weight = law.weight(scaled**2)
    leverage = _leverage(jacobian / noise[index, None] * np.sqrt(weight)[:, None])
    redundancy = np.bincount(index, 1.0 - leverage, count)
    for kind in np.flatnonzero((redundancy < _LEAST_REDUNDANCY) & np.isnan(held)).tolist():
        raise ConvergenceError(
            f"the parameters can follow all rows of {problem.kind_names[kind]!r} (redundancy {redundancy[kind]:.2g}): "
            "give its noise, or more data"
        )
    # Weights follow the noise, which costs nothing; what a row leaves over stays, and is told anew after the next fit.
    for _ in range(_WEIGHTINGS):
        square = np.bincount(index, weight * residuals**2, count) / np.maximum(redundancy, _LEAST_REDUNDANCY)
        before, noise = noise, np.where(np.isnan(held), np.maximum(np.sqrt(square), floor), held)
        if np.max(np.abs(np.log(noise / before))) < _SETTLED:
            break
        weight = law.weight((residuals / noise[index]) ** 2)
    return noise


def _leverage(jacobian: Array) -> Array:
    """Diagonal of the hat matrix, (n,)."""
    size = np.linalg.norm(jacobian, axis=0)
    columns = jacobian[:, size > 0.0] / size[size > 0.0]
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    kept = values > 1e-10 * np.max(values, initial=0.0)
    return np.asarray(np.sum(left[:, kept] ** 2, axis=1))


@dataclass(frozen=True, eq=False)
class Fit:
    """A minimum.

    vector : (k,) free parameters. noise : (kinds,) in the data's units; known : (kinds,) which of it was given.
    deviance : -2 log likelihood up to a constant, sum of rho + 2 log noise over the rows. residuals (n,),
    jacobian (n, k) : there, in the data's units. gradient : largest slope of half the deviance by one scale of a
    parameter, not counting those that push into a bound. on_bounds : names of parameters on a bound. converged :
    minimum and noise both found to tolerance. message : why the search ended.
    """

    vector: Array
    noise: Array
    deviance: float
    residuals: Array
    jacobian: Array
    gradient: float
    on_bounds: tuple[str, ...]
    converged: bool
    message: str
    known: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False)
class StartOutcome:
    """What became of one start (k,): where it ended and at which deviance, or (None, nan) and why it failed."""

    start: Array
    end: Array | None
    deviance: float
    message: str


@dataclass(frozen=True, eq=False)
class MultiStart:
    """The best of several starts. arrived : how many ended there. failed : how many had no answer at all."""

    best: Fit
    starts: tuple[StartOutcome, ...]
    arrived: int

    @property
    def failed(self) -> int:
        """How many starts ended without an answer."""
        return sum(outcome.end is None for outcome in self.starts)


class _Evaluator:
    """The problem's residuals and derivatives at the points asked for last; inf where the model has no answer."""

    def __init__(self, problem: JointProblem, progress: Callable[[float], None] | None = None) -> None:
        self.problem, self.count, self.progress = problem, 0, progress
        self.noise = np.ones(len(problem.kind_index))
        self._known: dict[bytes, tuple[Array, Array]] = {}

    def at(self, vector: Array) -> tuple[Array, Array]:
        key = vector.tobytes()
        if key not in self._known:
            self.count += 1
            found = self.problem.evaluate(vector)
            if self.progress is not None:
                self.progress(self.count / (self.count + _HALF_WAY))
            self._known = dict([*self._known.items()][-8:]) | {key: found}
        return self._known[key]

    def scaled_residuals(self, vector: Array) -> Array:
        try:
            return self.at(vector)[0] / self.noise
        except NO_ANSWER:
            return np.full(len(self.noise), np.inf)

    def scaled_jacobian(self, vector: Array) -> Array:
        return self.at(vector)[1] / self.noise[:, None]


def minimise(problem: JointProblem, start: Array, noise: Array, law: NoiseLaw, tolerance: float = 1e-8) -> Fit:
    """Minimise the deviance at given noise (kinds,) from a start (k,) by a trust region within the bounds.

    Raises what the model raises at the start itself. Points without an answer on the way shorten the step
    (Branch, Coleman & Li 1999, as in `scipy.optimize.least_squares`).
    """
    return _minimise(_Evaluator(problem), start, noise, law, tolerance)


def _minimise(evaluator: _Evaluator, start: Array, noise: Array, law: NoiseLaw, tolerance: float) -> Fit:
    from scipy.optimize import least_squares

    space = evaluator.problem.space
    evaluator.noise = noise[evaluator.problem.kind_index]
    inside = _strictly_inside(start, space.lower, space.upper)
    evaluator.at(inside)
    if len(space) == 0:
        return _fit(evaluator, inside, noise, law, True, "nothing is free")
    found = least_squares(
        evaluator.scaled_residuals,
        inside,
        evaluator.scaled_jacobian,
        bounds=(space.lower, space.upper),
        x_scale=space.scale,
        loss="linear" if law.freedom is None else law.loss,
        ftol=tolerance,
        xtol=tolerance,
        gtol=1e-12,
        max_nfev=_MOST,
    )
    return _fit(evaluator, found.x, noise, law, found.status > 0, found.message)


def _strictly_inside(vector: Array, lower: Array, upper: Array) -> Array:
    width = np.where(np.isfinite(upper - lower), upper - lower, 1.0)
    return np.asarray(np.clip(vector, lower + 1e-9 * width, upper - 1e-9 * width))


def _fit(evaluator: _Evaluator, vector: Array, noise: Array, law: NoiseLaw, converged: bool, message: str) -> Fit:
    problem, (residuals, jacobian) = evaluator.problem, evaluator.at(vector)
    space, scaled = problem.space, residuals / evaluator.noise
    rho, weight, _ = law.loss(scaled**2)
    slope = (jacobian / evaluator.noise[:, None]).T @ (weight * scaled) * space.scale
    low, high = vector - space.lower <= _ON_BOUND * space.scale, space.upper - vector <= _ON_BOUND * space.scale
    free = ~(low & (slope > 0.0)) & ~(high & (slope < 0.0))
    return Fit(
        read_only(vector),
        read_only(noise),
        float(np.sum(rho) + 2.0 * np.sum(np.log(evaluator.noise))),
        read_only(residuals),
        read_only(jacobian),
        float(np.max(np.abs(slope[free]), initial=0.0)),
        tuple(name for name, on in zip(space.names, low | high, strict=True) if on),
        converged,
        message,
    )


def fit_with_noise(
    problem: JointProblem,
    start: Array,
    law: NoiseLaw | None = None,
    known: Mapping[str, float] | None = None,
    floor: Array | None = None,
    progress: Callable[[float], None] | None = None,
) -> Fit:
    """Fit parameters and the noise of each kind in turn, until both stand still.

    `known` : noise of some kinds by name, taken as given. `floor` : least noise (kinds,).
    Raises what the model raises at the start, and ConvergenceError where a kind's noise cannot be told.
    """
    law, given = law or NoiseLaw(), known or {}
    for kind, size in given.items():
        if kind not in problem.kind_names:
            raise unknown_name("kind of noise", kind, problem.kind_names)
        positive_number(f"noise of {kind!r}", size)
    held = np.array([given.get(kind, np.nan) for kind in problem.kind_names], dtype=float)
    evaluator, vector = _Evaluator(problem, progress), _strictly_inside(start, problem.space.lower, problem.space.upper)
    residuals, _ = evaluator.at(vector)
    least = noise_floor(problem, residuals) if floor is None else floor
    noise = np.where(np.isnan(held), np.maximum(root_mean_square(problem, residuals), least), held)
    for turn in range(_ROUNDS):
        fit = _minimise(evaluator, vector, noise, law, _FIRST if turn == 0 else _LATER)
        vector = fit.vector
        new = estimated_noise(problem, fit.residuals, fit.jacobian, noise, law, least, held)
        change, noise = float(np.max(np.abs(np.log(new / noise)))), new
        if turn > 0 and change < _NOISE_TOLERANCE:
            break
    converged = fit.converged and change < _NOISE_TOLERANCE
    message = fit.message if converged or not fit.converged else f"the noise did not settle in {_ROUNDS} rounds"
    evaluator.noise = noise[problem.kind_index]
    finished = _fit(evaluator, fit.vector, noise, law, converged, message)
    return replace(finished, known=~np.isnan(held))


def spread_starts(problem: JointProblem, count: int, seed: int) -> Array:
    """Return starts (count, k): the natural one, then Sobol points within two scales of it and within the bounds."""
    from scipy.stats import qmc

    space, size = problem.space, whole_number("number of starts", count, least=1)
    low, high = (
        np.maximum(space.start - 2 * space.scale, space.lower),
        np.minimum(space.start + 2 * space.scale, space.upper),
    )
    if size == 1 or len(space) == 0:
        return space.start[None, :]
    power = max(int(np.ceil(np.log2(size - 1))), 0)
    points = qmc.Sobol(len(space), rng=np.random.default_rng(seed)).random_base2(power)[: size - 1]
    return np.concatenate([space.start[None, :], low + points * (high - low)])


def multi_start(
    problem: JointProblem,
    starts: Array,
    law: NoiseLaw | None = None,
    known: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> MultiStart:
    """Fit from every start (count, k) and keep the best; a start without an answer is recorded and passed over.

    `progress` is called with the fraction done. Raises ConvergenceError if no start has an answer.
    """
    fits, outcomes, floor = [], [], None
    for number, start in enumerate(starts):
        try:
            if floor is None:
                floor = noise_floor(problem, problem.evaluate(start)[0])
            fit = fit_with_noise(problem, start, law, known, floor, part_of(progress, number, len(starts)))
        except NO_ANSWER as cause:
            outcomes.append(StartOutcome(read_only(start), None, np.nan, f"{type(cause).__name__}: {cause}"))
        else:
            fits.append(fit)
            outcomes.append(StartOutcome(read_only(start), fit.vector, fit.deviance, fit.message))
        if progress is not None:
            progress((number + 1) / len(starts))
    if not fits:
        raise ConvergenceError(f"none of {len(starts)} starts has an answer; the first: {outcomes[0].message}")
    best = min(fits, key=lambda fit: fit.deviance)
    apart = [np.max(np.abs(fit.vector - best.vector) / problem.space.scale, initial=0.0) for fit in fits]
    higher = [abs(fit.deviance - best.deviance) for fit in fits]
    arrived = sum(d < _SAME_PLACE or h < _SAME_DEVIANCE for d, h in zip(apart, higher, strict=True))
    return MultiStart(best, tuple(outcomes), int(arrived))
