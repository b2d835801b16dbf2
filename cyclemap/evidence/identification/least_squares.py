"""Weighted least squares over joint blocks: the noise of each kind estimated along, from several
starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.checks import finite_number, positive_number, read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact, unknown_name
from cyclemap.evidence.identification.data_block import (
    BELIEF_KINDS,
    SESSION_KINDS,
    USUAL_SPREAD,
    JointProblem,
)
from cyclemap.evidence.identification.surface_parameters import Rows, Values
from cyclemap.progress import Progress, part_of, unheard

# Noise smaller than this share of the residuals at the start is no noise, but rounding.
_LEAST_NOISE = 1e-9
# A kind with fewer rows left over, once the parameters took their share, does not tell its noise.
_LEAST_REDUNDANCY = 0.5
# The noise of given residuals stands still at a change below this share, which takes a dozen
# rounds.
_WEIGHTINGS = 100
_SETTLED = 1e-4
# What the mechanics raise at parameters for which they have no answer.
NO_ANSWER = (ConvergenceError, UnsupportedContact, InvalidInput)
# The noise counts as found when no kind changes by more than this share: parameters then move by
# less than a twentieth of their standard errors. While it still changes more, fits need not be
# close; later they may be off by a twentieth of what the deviance changes by at a standard error, a
# share of the rows.
_NOISE_TOLERANCE = 5e-3
_ROUGH = 0.05
# What few sessions tell of how they differ counts less by this factor.
_LOOSE = 0.1
_FIRST = 1e-2
_LATER = 1e-5
_OFF = 0.05
# So many points asked for last are kept.
_KEPT = 9
# Evaluations after which half of a search counts as done: how many it takes is not known before.
_HALF_WAY = 15
_ROUNDS = 40
_MOST = 200
_SAME_DEVIANCE = 0.01
_SAME_PLACE = 1e-3
_ON_BOUND = 1e-3


@dataclass(frozen=True)
class NoiseLaw:
    """Distribution of the standardised residuals: normal, or Student's with `freedom` degrees of
    freedom.

    With z the squared standardised residual, rho(z) = z, or (freedom + 1) log(1 + z / freedom),
    which lets outliers count for little (Lange, Little & Taylor 1989). Raises InvalidInput for a
    freedom of one or less.

    >>> NoiseLaw(4.0).weight(np.array([0.0, 96.0])).tolist()
    [1.25, 0.05]
    """

    freedom: float | None = None

    def __post_init__(self) -> None:
        name = "degrees of freedom of the noise"
        if self.freedom is not None and finite_number(name, self.freedom) <= 1.0:
            raise InvalidInput(f"{name} must exceed one, not {self.freedom!r}")

    def loss(self, z: Array) -> Array:
        """Return rho, rho' and rho'' at squared standardised residuals (n,): (3, n)."""
        if self.freedom is None:
            return np.stack([z, np.ones_like(z), np.zeros_like(z)])
        m = self.freedom
        weight = self.weight(z)
        return np.stack([(m + 1.0) * np.log1p(z / m), weight, -weight / (m + z)])

    def weight(self, z: Array) -> Array:
        """Return how much each row counts, rho'(z)."""
        return (
            np.ones_like(z) if self.freedom is None else (self.freedom + 1.0) / (self.freedom + z)
        )

    @property
    def information(self) -> float:
        """Fisher information of one row about its mean, in units of 1/noise^2."""
        return 1.0 if self.freedom is None else (self.freedom + 1.0) / (self.freedom + 3.0)


NORMAL = NoiseLaw()


@dataclass(frozen=True, eq=False)
class Fit:
    """A minimum.

    Attributes
    ----------
    vector : ndarray, shape (k,)
        Free parameters.
    noise : ndarray, shape (kinds,)
        In the data's units.
    known : ndarray of bool, shape (kinds,)
        Which of it was given.
    deviance : float
        -2 log likelihood up to a constant, sum of rho + 2 log noise over the rows.
    residuals : ndarray, shape (n,)
        There, in the data's units.
    jacobian : ndarray, shape (n, k)
        There, in the data's units.
    on_bounds : tuple of str
        Names of parameters on a bound.
    converged : bool
        Minimum and noise both found to tolerance.
    message : str
        Why the search ended.
    """

    vector: Array
    noise: Array
    known: Mask
    deviance: float
    residuals: Array
    jacobian: Array
    on_bounds: tuple[str, ...]
    converged: bool
    message: str


@dataclass(frozen=True, eq=False)
class MultiStart:
    """The best of several starts.

    arrived : how many ended there.
    failures : why those without any answer had none.
    """

    best: Fit
    count: int
    arrived: int
    failures: tuple[str, ...]


class Search:
    """Searches in a problem under one noise law, with the noise of some kinds known (by name), the
    others' estimated.

    Residuals and derivatives of the points asked for last are kept. Raises InvalidInput for noise
    of an unknown kind.
    """

    def __init__(self, problem: JointProblem, law: NoiseLaw, known: Values | None = None) -> None:
        given = known or {}
        for kind, size in given.items():
            if kind not in problem.kind_names:
                raise unknown_name("kind of noise", kind, problem.kind_names)
            positive_number(f"noise of {kind!r}", size)
        self.problem = problem
        self.law = law
        # What is given of the noise (kinds,), nan elsewhere, and its least size, empty until the
        # first start tells it.
        self.held = np.array([given.get(kind, np.nan) for kind in problem.kind_names], dtype=float)
        self.floor = np.zeros(0)
        self.count = 0
        self.progress: Progress = unheard
        self._evaluate = lru_cache(_KEPT)(self._evaluated)

    def solve(self, start: Array, progress: Progress) -> Fit:
        """Fit parameters (k,) and the noise of each kind in turn, until both stand still.

        `progress` is called with the fraction of the search that is done, as far as that can be
        told. Raises what the model raises at the start, and ConvergenceError where a kind's noise
        cannot be told.
        """
        self.count = 0
        self.progress = progress
        vector = self.inside(start)
        index = self.problem.kind_index
        held = self.held
        squares = np.bincount(index, self.at(vector)[0] ** 2, held.size)
        rows = np.bincount(index, minlength=held.size)
        first = np.sqrt(squares / rows)
        if not self.floor.size:
            self.floor = np.maximum(_LEAST_NOISE * first, 1e-30)
        noise = np.where(np.isnan(held), np.maximum(first, self.floor), held)
        counts = np.where(np.isin(self.problem.kind_names, BELIEF_KINDS), _LOOSE, 1.0)
        tolerance = _FIRST
        close = float(np.clip(_OFF / index.size, _LATER, 10.0 * _LATER))
        for _ in range(_ROUNDS):
            fit = self.minimise(vector, noise, tolerance)
            vector = fit.vector
            new = self.estimated_noise(fit)
            change = float(np.max(np.abs(np.log(new / noise)) * counts))
            noise = new
            if tolerance == close and change < _NOISE_TOLERANCE:
                break
            if change < _ROUGH:
                tolerance = close
        converged = fit.converged and change < _NOISE_TOLERANCE
        message = fit.message
        if fit.converged and not converged:
            message = f"the noise did not settle in {_ROUNDS} rounds"
        return self.fit(vector, noise, converged, message)

    def at(self, vector: Array) -> Rows:
        """Return residuals (n,) and derivatives (n, k), or raise what the model raises."""
        return self._evaluate(vector.tobytes())

    def _evaluated(self, vector: bytes) -> Rows:
        self.count += 1
        both = self.problem.evaluate(np.frombuffer(vector))
        self.progress(self.count / (self.count + _HALF_WAY))
        return both

    def inside(self, vector: Array) -> Array:
        """Return the point, strictly within the bounds."""
        lower = self.problem.space.lower
        upper = self.problem.space.upper
        width = np.where(np.isfinite(upper - lower), upper - lower, 1.0)
        return np.clip(vector, lower + 1e-9 * width, upper - 1e-9 * width)

    def minimise(self, start: Array, noise: Array, tolerance: float) -> Fit:
        """Minimise the deviance at given noise (kinds,) from a start (k,) by a trust region within
        the bounds.

        Raises what the model raises at the start itself. Points without an answer on the way
        shorten the step (Branch, Coleman & Li 1999, as in `scipy.optimize.least_squares`).
        """
        from scipy.optimize import least_squares

        space = self.problem.space
        size = noise[self.problem.kind_index]
        begin = self.inside(start)
        self.at(begin)
        if len(space) == 0:
            return self.fit(begin, noise, True, "nothing is free")

        def residuals(vector: Array) -> Array:
            try:
                return self.at(vector)[0] / size
            except NO_ANSWER:
                return np.full(len(size), np.inf)

        minimum = least_squares(
            residuals,
            begin,
            lambda vector: self.at(vector)[1] / size[:, None],
            bounds=(space.lower, space.upper),
            x_scale=space.scale,
            loss="linear" if self.law.freedom is None else self.law.loss,
            ftol=tolerance,
            xtol=tolerance,
            gtol=1e-12,
            max_nfev=_MOST,
        )
        return self.fit(minimum.x, noise, minimum.status > 0, minimum.message)

    def fit(self, vector: Array, noise: Array, converged: bool, message: str) -> Fit:
        """Return what there is to tell of a minimum at this noise (kinds,)."""
        space = self.problem.space
        size = noise[self.problem.kind_index]
        (residuals, jacobian) = self.at(vector)
        gap = np.minimum(vector - space.lower, space.upper - vector) / space.scale
        return Fit(
            read_only(vector),
            read_only(noise),
            ~np.isnan(self.held),
            float(np.sum(self.law.loss((residuals / size) ** 2)[0]) + 2.0 * np.sum(np.log(size))),
            read_only(residuals),
            read_only(jacobian),
            tuple(name for name, left in zip(space.names, gap, strict=True) if left <= _ON_BOUND),
            converged,
            message,
        )

    def estimated_noise(self, fit: Fit) -> Array:
        """Return the next estimate (kinds,) of the noise, above its least size: the residuals'
        squares over their redundancy.

        The redundancy of a kind is its number of rows less their share in fixing the parameters,
        the trace of the hat matrix; repeated with a fit in between, this leads to restricted
        maximum likelihood (Foerstner 1979). Rows count as the noise found makes them count. Raises
        ConvergenceError where the parameters follow all rows of a kind, so that its noise cannot be
        told.
        """
        index = self.problem.kind_index
        names = self.problem.kind_names
        noise = fit.noise
        held = self.held
        weight = self.law.weight((fit.residuals / noise[index]) ** 2)
        weighed = fit.jacobian / noise[index, None] * np.sqrt(weight)[:, None]
        length = np.linalg.norm(weighed, axis=0)
        left, values, _ = np.linalg.svd(
            weighed[:, length > 0.0] / length[length > 0.0], full_matrices=False
        )
        leverage = np.sum(left[:, values > 1e-10 * np.max(values, initial=0.0)] ** 2, axis=1)
        redundancy = np.bincount(index, 1.0 - leverage, len(names))
        for kind in np.flatnonzero((redundancy < _LEAST_REDUNDANCY) & np.isnan(held)).tolist():
            raise ConvergenceError(
                f"the parameters can follow all rows of {names[kind]!r} (redundancy "
                f"{redundancy[kind]:.2g}): give its noise, or more data"
            )
        left_over = np.maximum(redundancy, _LEAST_REDUNDANCY)
        between_sessions = np.isin(names, SESSION_KINDS)
        # Weights follow the noise, which costs nothing; what a row leaves over stays, and is told
        # anew after the fit.
        for _ in range(_WEIGHTINGS):
            variance = np.bincount(index, weight * fit.residuals**2, len(names)) / left_over
            # The most likely spread sigma under a half-normal belief of this width:
            # sigma^4 / width^2 + rows sigma^2 = squares.
            half = 0.5 * left_over * USUAL_SPREAD**2
            tame = half * (np.sqrt(1.0 + 2.0 * variance / half) - 1.0)
            variance = np.where(between_sessions, tame, variance)
            sizes = np.maximum(np.sqrt(variance), self.floor)
            before = noise
            noise = np.where(np.isnan(held), sizes, held)
            if np.max(np.abs(np.log(noise / before))) < _SETTLED:
                break
            weight = self.law.weight((fit.residuals / noise[index]) ** 2)
        return noise


def spread_starts(problem: JointProblem, count: int, seed: int) -> Array:
    """Return starts (count, k): the natural one, then Sobol points within two scales of it and
    within the bounds.
    """
    from scipy.stats import qmc

    space = problem.space
    size = whole_number("number of starts", count, least=1)
    low = np.maximum(space.start - 2 * space.scale, space.lower)
    high = np.minimum(space.start + 2 * space.scale, space.upper)
    if size == 1 or len(space) == 0:
        return space.start[None, :]
    power = max(int(np.ceil(np.log2(size - 1))), 0)
    points = qmc.Sobol(len(space), rng=np.random.default_rng(seed)).random_base2(power)[: size - 1]
    return np.concatenate([space.start[None, :], low + points * (high - low)])


def multi_start(
    problem: JointProblem,
    starts: Array,
    law: NoiseLaw = NORMAL,
    known: Values | None = None,
    progress: Progress | None = None,
) -> MultiStart:
    """Fit from every start (count, k) and keep the best; a start without an answer is recorded and
    passed over.

    known : noise of some kinds by name, taken as given. `progress` is called with the fraction
        done.

    Raises InvalidInput for noise of an unknown kind, ConvergenceError if no start has an answer.
    """
    search = Search(problem, law, known)
    fits = []
    failures = []
    for index, start in enumerate(starts):
        report = part_of(progress, index, len(starts))
        try:
            fits.append(search.solve(start, report))
        except NO_ANSWER as cause:
            failures.append(f"{type(cause).__name__}: {cause}")
        report(1.0)
    if not fits:
        raise ConvergenceError(
            f"none of {len(starts)} starts has an answer; the first: {failures[0]}"
        )
    best = min(fits, key=lambda fit: fit.deviance)
    arrived = 0
    for fit in fits:
        # A start arrived if its deviance is as low, or its parameters are the same in their scales.
        apart = np.max(np.abs(fit.vector - best.vector) / problem.space.scale, initial=0.0)
        if apart < _SAME_PLACE or fit.deviance - best.deviance < _SAME_DEVIANCE:
            arrived += 1
    return MultiStart(best, len(starts), arrived, tuple(failures))
