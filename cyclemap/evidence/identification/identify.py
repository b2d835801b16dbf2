"""Identify parameters from blocks of data: starts, intervals, cross-validation, and all that
qualifies them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.evidence.identification.data_block import (
    BELIEF_KINDS,
    PLANE_KINDS,
    PRIOR_KIND,
    SESSION_KINDS,
    Beliefs,
    DataBlock,
    JointProblem,
    Labels,
    asked_by,
    prior_block,
)
from cyclemap.evidence.identification.least_squares import (
    NO_ANSWER,
    NORMAL,
    Fit,
    MultiStart,
    NoiseLaw,
    Search,
    Uncertainty,
    multi_start,
    spread_starts,
    uncertainty,
)
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    ParameterSpace,
    SurfaceParameters,
    Values,
    owned_shapes,
)
from cyclemap.evidence.laws.linear_fit import student_quantile
from cyclemap.evidence.pushes.measured_strokes import ROD_OFF
from cyclemap.mechanics import EllipseFriction, SurfaceShape
from cyclemap.progress import Progress, part_of, unheard
from cyclemap.written import UNWRITTEN, Unit, readable_unit

# A fold's fit starts from that to all: it is close when the deviance stands still to this share.
_CLOSE = 1e-3
# What is computed may be off by this share of a kind's noise; else the search goes on more closely.
_CLOSE_ENOUGH = 0.1
# Fewer degrees of freedom than this make an interval rough.
_FEW = 4.0
# A parameter whose error is above this share of its belief's deviation was hardly told by the data.
_TOLD = 0.8


@dataclass(frozen=True)
class KindErrors:
    """Sizes of the errors of one kind in one block, in its own unit.

    Attributes
    ----------
    block : str
        Name of the block.
    kind : str
        Name of the kind.
    rows : int
        How many errors; of a place or a force one each, the length of the vector by which it is
        off.
    mean, median, rms : float
        Sizes of the errors in the sample.
    left_out_mean, left_out_median, left_out_rms : float
        The same of rows left out; nan where none were.
    isotropic_mean, isotropic_median : float
        The same of isotropic friction, plate and floor flat, all else usual; nan where that has
        no answer.
    """

    block: str
    kind: str
    rows: int
    mean: float
    median: float
    rms: float
    left_out_mean: float
    left_out_median: float
    left_out_rms: float
    isotropic_mean: float
    isotropic_median: float


def random_folds(problem: JointProblem, folds: int, seed: int = 0) -> Labels:
    """Return the fold of each row (n,): the groups of each block dealt at random, in equal numbers;
    -1 for beliefs.

    Raises InvalidInput for fewer than two folds or more folds than groups.
    """
    stays = np.isin(problem.groups, problem.groups[np.isin(problem.kinds, BELIEF_KINDS)])
    groups = len(np.unique(problem.groups[~stays]))
    if not 2 <= whole_number("folds", folds) <= groups:
        raise InvalidInput(f"folds must be from 2 to the {groups} groups of the data, not {folds}")
    rng = np.random.default_rng(seed)
    dealt = 0
    fold = np.full(int(np.max(problem.groups)) + 1, -1)
    for block in range(len(problem.blocks)):
        members = rng.permutation(
            np.unique(problem.groups[(problem.block_index == block) & ~stays])
        )
        fold[members] = (dealt + np.arange(len(members))) % folds
        dealt += len(members)
    return fold[problem.groups]


def cross_validate(
    problem: JointProblem,
    fit: Fit,
    fold: Labels,
    law: NoiseLaw = NORMAL,
    progress: Progress | None = None,
) -> tuple[Array, list[str]]:
    """Fit without each fold (n,), from the fit to all, and predict it; kinds keep the weights of
    the fit to all.

    Returns residuals (n,), predicted less measured, nan where a row was never left out (fold -1) or
    its fold had no answer, and why folds had none. `progress` is called with the fraction done.
    """
    count = int(np.max(fold)) + 1
    whole = problem.values(fit.vector)
    residuals = np.full(len(fold), np.nan)
    failures = []
    for index in range(count):
        out = fold == index
        try:
            rest = problem.subset(~out, whole)
            noise = fit.noise[[problem.kind_names.index(kind) for kind in rest.kind_names]]
            best = Search(rest, law).minimise(rest.space.vector(whole), noise, _CLOSE)
            values = rest.values(best.vector)
            left_out = problem.subset(out, values)
            residuals[out] = left_out.evaluate(left_out.space.vector(values))[0]
        except NO_ANSWER as cause:
            failures.append(f"fold {index}: {type(cause).__name__}: {cause}")
        part_of(progress, index, count)(1.0)
    return residuals, failures


def kind_errors(
    problem: JointProblem, fit: Fit, left_out: Array, isotropic: Array
) -> tuple[KindErrors, ...]:
    """Return the sizes of the errors of every kind in every block; also of rows left out, and of
    flat isotropy, (n,), nan where they are not known.
    """
    errors = []
    for index, block in enumerate(problem.blocks):
        for kind in np.unique(block.kinds).tolist():
            if kind in BELIEF_KINDS:
                continue
            rows = (problem.block_index == index) & (problem.kinds == kind)
            inside = _moments(kind, fit.residuals[rows])
            outside = _moments(kind, left_out[rows])
            plain = _moments(kind, isotropic[rows])
            count = int(np.sum(rows)) // (2 if kind in PLANE_KINDS else 1)
            errors.append(KindErrors(block.name, kind, count, *inside, *outside, *plain[:2]))
    return tuple(errors)


def _moments(kind: str, errors: Array) -> list[float]:
    """Mean, median and root mean square of the sizes of errors that are known; nan without any."""
    # Of components the lengths of their vectors count.
    sizes = np.hypot(errors[::2], errors[1::2]) if kind in PLANE_KINDS else np.abs(errors)
    known = sizes[np.isfinite(sizes)]
    if not known.size:
        return [np.nan] * 3
    return [float(np.mean(known)), float(np.median(known)), float(np.sqrt(np.mean(known**2)))]


@dataclass(frozen=True)
class NamedInterval:
    """A number with its interval.

    Attributes
    ----------
    name, description : str
        What it is called, and in plain words what it is.
    unit : str
        SI, or kPa; 1 for a pure number.
    value, lower, upper : float
        Best value and ends of its interval, in `unit`; angles are on the lift nearest to the value.
    """

    name: str
    description: str
    unit: str
    value: float
    lower: float
    upper: float

    @property
    def readable(self) -> tuple[Unit, float, float, float]:
        """The unit that people are told it in; value and ends of its interval in that."""
        unit = readable_unit(self.unit)
        return unit, unit.of_si(self.value), unit.of_si(self.lower), unit.of_si(self.upper)


@dataclass(frozen=True)
class Estimate(NamedInterval):
    """One parameter, as identified; see `NamedInterval`.

    Attributes
    ----------
    standard_error : float
        To first order, inf where the data do not fix it.
    identifiable : bool
        Whether the data exclude any value between the bounds.
    at_bound : str
        `lower`, `upper`, or empty.
    lower_open, upper_open : bool
        The end is a bound, not a finding.
    """

    standard_error: float
    identifiable: bool
    at_bound: str
    lower_open: bool = field(metadata=UNWRITTEN)
    upper_open: bool = field(metadata=UNWRITTEN)


@dataclass(frozen=True, eq=False)
class Identification:
    """Parameters identified from data.

    Attributes
    ----------
    estimates : tuple of Estimate
        One a free parameter.
    level : float
        Of their intervals, in (0, 1).
    priors : mapping of str to tuple[float, float]
        What was believed (value, standard deviation).
    errors : tuple of KindErrors
        By block and kind.
    starts : MultiStart
        All searches.
    fit : Fit
        The minimum of the best start.
    uncertainty : Uncertainty
        To first order.
    notes : tuple of str
        All that qualifies the result, in words.
    problem : JointProblem
        What was solved.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import DataBlock, identify
    >>> ratios = np.array([0.19, 0.21, 0.2, 0.2])
    >>> def law(values):
    ...     return values["pusher_friction"] - ratios, np.ones((4, 1))
    >>> block = DataBlock("ratios", ("pusher_friction",), law, range(4), "ratio")
    >>> found = identify([block], ["pusher_friction"])
    >>> round(found.values["pusher_friction"], 4), found["pusher_friction"].identifiable
    (0.2, True)
    """

    estimates: tuple[Estimate, ...]
    level: float
    priors: Beliefs
    errors: tuple[KindErrors, ...]
    starts: MultiStart
    fit: Fit
    uncertainty: Uncertainty
    notes: tuple[str, ...]
    problem: JointProblem

    def __getitem__(self, name: str) -> Estimate:
        known = {estimate.name: estimate for estimate in self.estimates}
        if name not in known:
            raise unknown_name("identified parameter", name, known)
        return known[name]

    @property
    def lasting(self) -> tuple[Estimate, ...]:
        """The estimates of what outlasts the data: all but how far single rods were off their
        marks.
        """
        return tuple(row for row in self.estimates if not row.name.startswith(ROD_OFF))

    @property
    def values(self) -> dict[str, float]:
        """Every parameter's value by name, identified or held."""
        return self.problem.values(self.fit.vector)

    @property
    def plates(self) -> dict[str, SurfaceShape]:
        """Shapes by plate, kPa at 50 mm; of one plate alone, which no name tells apart, under the
        empty name.
        """
        return owned_shapes(self.values, PLATE_NAMES)

    @property
    def floors(self) -> dict[str, SurfaceShape]:
        """Shapes of the floor, kPa at 50 mm, by session; under the empty name the only one, or the
        mean of all.
        """
        return owned_shapes(self.values, FLOOR_NAMES)

    @property
    def session_spread(self) -> tuple[float, float, float]:
        """Standard deviations of dome and both components of the bow between sessions, kPa; 0 of
        one session alone.
        """
        noise = dict(zip(self.problem.kind_names, self.fit.noise.tolist(), strict=True))
        dome, along, across = (noise.get(kind, 0.0) for kind in SESSION_KINDS)
        return dome, along, across

    def friction(self) -> EllipseFriction:
        """Return the identified friction ellipse; what the data were not asked about has its
        nominal value.
        """
        return SurfaceParameters.from_values(self.values).to_friction()


def identify(
    blocks: Sequence[DataBlock],
    free: Sequence[str],
    fixed: Values | None = None,
    *,
    priors: Beliefs | None = None,
    starts: int = 8,
    level: float = 0.95,
    folds: int = 0,
    noise: Values | None = None,
    student: float | None = None,
    space: ParameterSpace = SURFACE,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Identify parameters from blocks of data by maximum likelihood.

    Blocks share friction and rod; what belongs to a plate or a data set is an unknown of its own
    there (`DataBlock.of_owner`), so that any number of data sets of any plates and sorts is
    explained at once.

    Parameters
    ----------
    blocks : sequence of DataBlock
        The data; the `own_parameters` of a block are added to `space`.
    free : sequence of str
        Names to be identified.
    fixed : mapping of str to float or None, optional
        Values of others; what is not given has its nominal value, and a note.
    priors : mapping, optional
        Beliefs (value, standard deviation) about free parameters, in SI units; see
        `usual_beliefs`.
    starts : int, default 8
        How many searches, the first from the natural start, the rest spread about it.
    level : float, default 0.95
        Of the intervals, in (0, 1): value -+ t standard errors, cut at the bounds; errors of
        rows of one group may be alike.
    folds : int, default 0
        0, or a number of random folds of every block's groups, each left out once.
    noise : mapping of str to float or None, optional
        Sizes of kinds of noise that are known; all others are estimated.
    student : float or None, optional
        Degrees of freedom of Student noise, for data with outliers; None: normal.
    space : ParameterSpace, optional
        What the parameters are.
    seed : int, default 0
        Of starts and folds.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    Identification
        Estimates with their intervals, and what qualifies them.

    Raises
    ------
    InvalidInput
        For names or numbers that do not fit.
    ConvergenceError
        If no start has an answer.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import DataBlock, identify
    >>> x = np.linspace(0.0, 1.0, 8)
    >>> data = 0.2 + 0.01 * np.cos(40.0 * x)
    >>> def law(values):
    ...     return values["pusher_friction"] - data, np.ones((8, 1))
    >>> block = DataBlock("ratios", ("pusher_friction",), law, range(8), "ratio")
    >>> rod = identify([block], ["pusher_friction"])["pusher_friction"]
    >>> round(rod.value, 4), round(rod.lower, 4), round(rod.upper, 4)
    (0.1986, 0.1919, 0.2053)
    """
    student_quantile(level, 10.0)
    whole_number("seed", seed, least=0)
    law = NoiseLaw(student)
    believed = dict(priors or {})
    known = dict(noise or {})
    if believed:
        blocks = (*blocks, prior_block(believed))
    if any(PRIOR_KIND in block.kinds for block in blocks):
        known[PRIOR_KIND] = 1.0
    problem, notes = _problem(blocks, tuple(free), fixed or {}, space)
    problem.space.select(tuple(believed))
    fold = random_folds(problem, folds, seed) if folds else np.full(problem.groups.size, -1)
    # The searches are the first three fifths of the work, cross-validation the rest.
    searching = part_of(progress, 0.0, 5.0 / 3.0)
    validating = part_of(progress, 1.5, 2.5)
    searches = multi_start(problem, spread_starts(problem, starts, seed), law, known, searching)
    problem, searches, closer_notes = _searched_closer(problem, searches, law, known)
    fit = searches.best
    errors = uncertainty(problem, fit, law)
    left_out, failures = cross_validate(problem, fit, fold, law, validating)
    validating(1.0)
    estimates = _estimates(problem, fit, errors, level)
    notes += [*closer_notes, *_notes(searches, errors, estimates, believed), *failures]
    notes += _stayed_notes(blocks, problem.values(fit.vector))
    table = kind_errors(problem, fit, left_out, _isotropic_residuals(problem))
    return Identification(
        estimates, level, believed, table, searches, fit, errors, tuple(notes), problem
    )


def _searched_closer(
    problem: JointProblem, searches: MultiStart, law: NoiseLaw, known: Values
) -> tuple[JointProblem, MultiStart, list[str]]:
    """The problem so closely computed as the noise found asks for, and the searches with their best
    one gone on in it; a note where the model has no answer so close.
    """
    notes = []
    try:
        while not _is_close_enough(problem, searches.best):
            closer = problem.computed_closer()
            if closer.blocks == problem.blocks:
                break
            best = Search(closer, law, known).solve(searches.best.vector, unheard)
            problem = closer
            searches = replace(searches, best=best)
    except NO_ANSWER as cause:
        plain = tuple(replace(block, refined=()) for block in problem.blocks)
        problem = replace(problem, blocks=plain)
        notes.append(f"by how much strokes are off as they are computed is not known: {cause}")
    return problem, searches, notes


def _is_close_enough(problem: JointProblem, fit: Fit) -> bool:
    """Whether predictions are off by less than the noise of each kind lets one see."""
    sizes = problem.size_by_kind(problem.numerical_errors(fit.vector))
    return bool(np.all(sizes <= _CLOSE_ENOUGH * fit.noise))


def _stayed_notes(blocks: Sequence[DataBlock], values: Values) -> list[str]:
    """Of blocks of strokes, how many are taken to leave the object where it was."""
    notes = []
    for block in blocks:
        if block.stayed is None or block.motions is None:
            continue
        stayed = block.stayed(block.own_values(values))
        if stayed:
            notes.append(
                f"{block.name}: {stayed} of {len(block.motions)} are taken to leave the object "
                "where it was: the rod misses it, or the motion has no answer"
            )
    return notes


def _isotropic_residuals(problem: JointProblem) -> Array:
    """The residuals (n,) of isotropic friction, plate and floor flat, rod and ring as usual, no
    frames shifted; nan where that has no answer.
    """
    plain = ("ellipticity", "offset", "worn_", "floor_", "plate_", "tip_offset", "rod_off")
    usual = {**problem.fixed, **problem.space.nominal}
    flat = {name: 0.0 if name.startswith(plain) else usual[name] for name in usual}
    with suppress(*NO_ANSWER):
        return replace(problem, fixed=flat).evaluate(problem.space.vector(flat))[0]
    return np.full(problem.groups.size, np.nan)


def _problem(
    blocks: Sequence[DataBlock],
    free: tuple[str, ...],
    fixed: Values,
    space: ParameterSpace,
) -> tuple[JointProblem, list[str]]:
    """The problem, and a note for every value that was not given."""
    for block in blocks:
        space = space.extended(*block.own_parameters)
    both = sorted(set(free) & set(fixed))
    if both or not free:
        raise InvalidInput(
            f"name what is free, and give no value for it: free {list(free)}, also fixed {both}"
        )
    space.select(tuple(fixed))
    rest = asked_by(blocks).difference(free, fixed)
    nominal = {name: value for name, value in space.nominal.items() if name in rest}
    notes = [
        f"{name} was neither free nor given: taken as {value:.4g}"
        for name, value in nominal.items()
    ]
    return JointProblem(tuple(blocks), space.select(free), {**nominal, **fixed}), notes


def _estimates(
    problem: JointProblem, fit: Fit, errors: Uncertainty, level: float
) -> tuple[Estimate, ...]:
    """Every free parameter with its interval, cut at its bounds."""
    columns = (fit.vector.tolist(), errors.standard_error.tolist(), errors.freedom.tolist())
    estimates = []
    for row, value, error, freedom in zip(problem.space.parameters, *columns, strict=True):
        half = student_quantile(level, freedom) * error if math.isfinite(error) else math.inf
        open_below = value - half <= row.lower
        open_above = value + half >= row.upper
        nearer = "lower" if value - row.lower <= row.upper - value else "upper"
        estimate = Estimate(
            row.name,
            row.description,
            row.unit,
            value,
            max(value - half, row.lower),
            min(value + half, row.upper),
            error,
            not (open_below and open_above),
            nearer if row.name in fit.on_bounds else "",
            open_below,
            open_above,
        )
        estimates.append(estimate)
    return tuple(estimates)


def _notes(
    searches: MultiStart, errors: Uncertainty, estimates: tuple[Estimate, ...], believed: Beliefs
) -> list[str]:
    """All that qualifies the result, in words."""
    fit = searches.best
    notes = [*errors.open]
    failed = len(searches.failures)
    if not fit.converged:
        notes.append(f"the search did not converge: {fit.message}")
    if failed:
        notes.append(f"{failed} of {searches.count} starts had no answer")
    elsewhere = searches.count - failed - searches.arrived
    if elsewhere:
        notes.append(f"{elsewhere} of {searches.count} starts ended in other, worse minima")
    notes += [f"{name} lies on a bound" for name in fit.on_bounds]
    notes += [f"{row.name} is not identifiable" for row in estimates if not row.identifiable]
    untold = []
    few = []
    for estimate, freedom in zip(estimates, errors.freedom, strict=True):
        name = estimate.name
        width = believed.get(name, (0.0, math.inf))[1]
        if estimate.standard_error > _TOLD * width and not name.startswith(ROD_OFF):
            untold.append(name)
        if freedom < _FEW:
            few.append(name)
    if untold:
        notes.append(f"the data hardly tell {', '.join(untold)}: what is believed of it counts")
    if few:
        notes.append(f"few independent groups: the intervals of {', '.join(few)} are rough")
    return notes
