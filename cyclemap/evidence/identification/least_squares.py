"""Weighted least squares over joint blocks: the noise of each kind estimated along, from several
starts; what the data fix and how well: covariance honest about grouped errors, and directions that
the data leave open.
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
    Labels,
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
# Degrees of freedom at which Student is normal.
_MOST_FREEDOM = 1e9
# A direction is open if its standard error, in the parameters' scales, exceeds this.
OPEN = 3.0
# Information below this share of the largest is rounding.
_RANK = 1e-12
# Least part of a parameter in a combination for it to be named.
_NAMED = 0.3


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
        weight = self.weight(z)
        m = self.freedom
        if m is None:
            return np.stack([z, weight, np.zeros_like(z)])
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
    least : ndarray of bool, shape (kinds,)
        Which of it is the least that can be told of residuals, since these are less.
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
    least: Mask
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
        # What is given of the noise (kinds,), nan elsewhere, and its least size, zero until the
        # first start tells it.
        self.held = np.array([given.get(kind, np.nan) for kind in problem.kind_names], dtype=float)
        self.floor = np.zeros(len(problem.kind_names))
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
        held = self.held
        first = self.problem.size_by_kind(self.at(vector)[0])
        if not self.floor.any():
            self.floor = np.maximum(_LEAST_NOISE * first, 1e-30)
        noise = np.where(np.isnan(held), np.maximum(first, self.floor), held)
        counts = np.where(np.isin(self.problem.kind_names, BELIEF_KINDS), _LOOSE, 1.0)
        tolerance = _FIRST
        rows = self.problem.kind_index.size
        close = float(np.clip(_OFF / rows, _LATER, 10.0 * _LATER))
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
            np.isnan(self.held) & (noise <= self.floor),
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
    # The least power of two that is no less than what is asked for.
    power = (size - 2).bit_length()
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


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Errors of a fit to first order.

    Attributes
    ----------
    standard_error : ndarray, shape (k,)
        Inf for a parameter that the data do not fix.
    covariance, correlation : ndarray, shape (k, k)
        Without what is open.
    freedom : ndarray, shape (k,)
        Degrees of freedom for Student's t.
    open : tuple of str
        Which parameters, or combinations of them, the data do not fix, in words.
    """

    standard_error: Array
    covariance: Array
    correlation: Array
    freedom: Array
    open: tuple[str, ...]


def uncertainty(problem: JointProblem, fit: Fit, law: NoiseLaw = NORMAL) -> Uncertainty:
    """Return the uncertainty of a fit from its derivatives, good to first order.

    Rows of single groups, or of noise that was given: the inverse information. Where rows share
    groups otherwise: the sandwich of Liang & Zeger. To both comes what estimating the weights of
    the kinds from the same data costs, and by how much the fit is off since predictions are
    computed.

    Raises what the model raises where it is computed more closely.
    """
    scale = problem.space.scale
    kinds = problem.kind_index
    jacobian = fit.jacobian / fit.noise[kinds, None] * scale
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    seen = values > _RANK * np.max(values, initial=0.0)
    inverse = vectors[:, seen] / values[seen] @ vectors[:, seen].T
    blind = np.sqrt(np.sum(vectors[:, ~seen] ** 2, axis=1)) > 1e-4
    by_weights, share, redundancy = _kind_variance(jacobian, inverse, kinds, fit.known)
    by_weights /= law.information
    is_given = bool(np.all(fit.known[kinds]))
    if is_given or len(np.unique(problem.groups)) == len(problem.groups):
        covariance = inverse / law.information + 2.0 * by_weights
        freedom = _degrees(np.sum(share, axis=0) ** 2, np.sum(share**2 / redundancy, axis=0))
    else:
        scaled = fit.residuals / fit.noise[kinds]
        # A belief counts by its deviation, which is known, not by how far off it happened to be.
        belief = np.isin(problem.kinds, BELIEF_KINDS)
        errors = (law.weight(scaled**2) * scaled / law.information)[~belief]
        sandwich, of_groups = _grouped_variance(
            jacobian[~belief], errors, inverse, problem.groups[~belief]
        )
        # Residuals below the least noise tell of no group how far it may be off.
        unseen = jacobian[fit.least[kinds] & ~belief] @ inverse
        sandwich += unseen.T @ unseen
        believed = jacobian[belief] @ inverse
        covariance = sandwich + by_weights + believed.T @ believed
        # Each adds its variance's square over its freedom (Satterthwaite 1946); a belief of known
        # width has no end of freedom, sessions have as much as tells how they differ.
        is_belief = np.isin(problem.kind_names, BELIEF_KINDS)
        spent = np.diag(sandwich + by_weights) ** 2 / of_groups
        spent += np.sum(share[is_belief] ** 2 / redundancy[is_belief], axis=0)
        freedom = _degrees(np.diag(covariance) ** 2, spent)
    covariance = covariance + _computed_variance(problem, fit, jacobian, inverse)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    outer = np.outer(error, error)
    correlation = np.divide(covariance, outer, out=np.eye(error.size), where=outer > 0.0)
    return Uncertainty(
        read_only(np.where(blind, np.inf, error * scale)),
        read_only(covariance * np.outer(scale, scale)),
        read_only(correlation),
        read_only(freedom),
        _open_directions(problem, law.information * values, vectors, seen),
    )


def _kind_variance(
    jacobian: Array, inverse: Array, kinds: Labels, known: Mask
) -> tuple[Array, Array, Array]:
    """Covariance (k, k) that comes on top because the weights of the kinds are estimated; what each
    kind adds to the variances (kinds, k), and its redundancy (kinds, 1), its degrees of freedom.

    To first order the sum over kinds of 2 / redundancy times inverse (A - A inverse A) inverse, A
    the kind's part of jacobian^T jacobian (Kackar & Harville 1984); the inverse information itself
    is too small by as much again (Kenward & Roger 1997).
    """
    leverage = np.einsum("ni,ij,nj->n", jacobian, inverse, jacobian)
    redundancy = np.where(known, np.inf, np.maximum(np.bincount(kinds, 1.0 - leverage), 0.1))
    total = np.zeros_like(inverse)
    share = np.zeros((len(redundancy), len(inverse)))
    for kind, rest in enumerate(redundancy):
        own = jacobian[kinds == kind] @ inverse
        square = own.T @ own
        total += 2.0 / rest * (square - own.T @ jacobian[kinds == kind] @ square)
        share[kind] = np.diag(square)
    return total, share, redundancy[:, None]


def _grouped_variance(
    jacobian: Array, errors: Array, inverse: Array, groups: Labels
) -> tuple[Array, Array]:
    """Covariance (k, k) that allows for any dependence within groups, and its degrees of freedom
    (k,).

    The sandwich of Liang & Zeger (1986), each group's errors first freed of their own pull on the
    fit; the freedom is Satterthwaite's for independent rows (Bell & McCaffrey 2002, CR2). Few or
    unequal groups have little freedom.
    """
    order = np.argsort(groups, kind="stable")
    meat = []
    own = []
    pull = []
    for rows in np.split(order, np.flatnonzero(np.diff(groups[order])) + 1):
        slopes = jacobian[rows]
        # The inverse square root; directions that the fit follows wholly have none and give zero.
        values, vectors = np.linalg.eigh(np.eye(len(rows)) - slopes @ inverse @ slopes.T)
        root = np.where(values > 1e-8, 1.0 / np.sqrt(np.maximum(values, 1e-8)), 0.0)
        freed = vectors * root @ vectors.T @ slopes
        meat.append(freed.T @ errors[rows])
        own.append(np.sum((freed @ inverse) ** 2, axis=0))
        pull.append(slopes.T @ freed @ inverse)
    scores = np.array(meat) @ inverse
    each = np.array(own)
    pulled = np.array(pull)
    # Trace squared over squared norm of the quadratic form that estimates the variance of parameter
    # p: its matrix is diag(each_p) - U inverse U^T, U = pulled[:, :, p].
    fed = np.einsum("ij,gjp->gip", inverse, pulled)
    square = np.einsum("gip,gjp->pij", fed, pulled)
    trace = np.sum(each, axis=0) - np.einsum("pii->p", square)
    cross = np.einsum("gp,gip,gip->p", each, fed, pulled)
    norm = np.sum(each**2, axis=0) - 2.0 * cross + np.einsum("pij,pji->p", square, square)
    return scores.T @ scores, _degrees(trace**2, norm)


def _computed_variance(problem: JointProblem, fit: Fit, jacobian: Array, inverse: Array) -> Array:
    """Covariance (k, k) that comes on top because predictions are computed: their errors as they
    are, which move the fit as one, and, since these are a sample, any others so large at random.
    """
    kinds = problem.kind_index
    off = problem.numerical_errors(fit.vector) / fit.noise[kinds]
    moved = inverse @ (jacobian.T @ off)
    largest = np.zeros(fit.noise.size)
    np.maximum.at(largest, kinds, np.abs(off))
    spread = jacobian * largest[kinds, None] @ inverse
    return np.outer(moved, moved) + spread.T @ spread


def _degrees(above: Array, below: Array) -> Array:
    """The ratio, between one and so many that Student is normal."""
    return np.clip(above / np.maximum(below, 1e-300), 1.0, _MOST_FREEDOM)


def _open_directions(
    problem: JointProblem, values: Array, vectors: Array, seen: Array
) -> tuple[str, ...]:
    """Of each direction that the data leave open the parameters that take part, the greatest part
    first.
    """
    directions = []
    for value, vector, visible in zip(values, vectors.T, seen, strict=True):
        if visible and value >= OPEN**-2:
            continue
        share = np.abs(vector)
        ranked = np.argsort(-share)
        order = ranked[share[ranked] >= _NAMED * np.max(share)].tolist()
        *names, last = (problem.space.names[index] for index in order)
        if not names:
            directions.append(f"{last} is not fixed by the data")
            continue
        signed = vector * np.sign(vector[order[0]]) * problem.space.scale
        moves = [f"{problem.space.names[index]} {signed[index]:+.3g}" for index in order]
        directions.append(
            f"{', '.join(names)} and {last} trade off: the data hardly tell a change of "
            f"{', '.join(moves)}"
        )
    return tuple(directions)
