"""Everything that is fitted to one set of pushes: its laws, its histogram of Δθ, its cycle map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array, Whole
from cyclemap.checks import read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.circular_distance import PValue, monte_carlo_p_value
from cyclemap.evidence.laws.linear_fit import (
    cycle_folds,
    fourier_columns,
    nested_errors,
    weighted_fit,
)
from cyclemap.evidence.laws.measured_cycle_map import MeasuredCycleMap, measured_cycle_map
from cyclemap.evidence.laws.periodic_law import (
    PeriodicLaw,
    fit_periodic_law,
    paired_arrays,
    scatter_weights,
)
from cyclemap.evidence.laws.push_sets import (
    FEWEST,
    QUANTITIES,
    PushSet,
    PushStatistics,
    push_statistics,
)
from cyclemap.maps import RestMultiplier, rest_multiplier
from cyclemap.progress import Progress, part_of

# Below this many pushes the scatter is taken constant: its dependence on the angle cannot be told
# from chance.
_FEWEST_FOR_SCATTER = 100
# Points of the distribution functions in a bin, for their distance.
_FINER = 4
_MARGIN = 3.0


@dataclass(frozen=True, eq=False)
class MotionLaw:
    """The law of one quantity (Δθ in rad, Δx or Δy in m) over θ0, or why there is none.

    Attributes
    ----------
    quantity : str
        "dtheta", "dx" or "dy".
    theta, value : ndarray, shape (n,)
        The pushes it was fitted to, in order of recording.
    law : PeriodicLaw or None
        With its RMSE, ``percent`` of the mean, order, scatter and bands; None where ``problem``
        says why.
    cross_validated_rmse : float
        Root mean square error at pushes that such laws were fitted without: NaN where too few,
        inf where the others do not fix the law.
    problem : str or None
        Why there is no law; None where there is.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, set_laws
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.sin(theta), np.cos(theta)
    >>> pushes = PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, pairs=None)
    >>> dtheta = set_laws(pushes, harmonics=1)[0]
    >>> dtheta.quantity, round(dtheta.explained, 6)
    ('dtheta', 1.0)
    """

    quantity: str
    theta: Array
    value: Array
    law: PeriodicLaw | None
    cross_validated_rmse: float
    problem: str | None = None

    @property
    def explained(self) -> float:
        """The share of the variance that the law predicts in pushes left out; below 0 for one worse
        than the mean.
        """
        if self.law is None or self.law.total_std == 0.0:
            return float("nan")
        return 1.0 - (self.cross_validated_rmse / self.law.total_std) ** 2


def set_laws(
    pushes: PushSet,
    *,
    harmonics: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[MotionLaw, ...]:
    """Fit the laws of turn and displacement over θ0 to a set of pushes.

    Parameters
    ----------
    pushes : PushSet
        The set.
    harmonics : int or None, optional
        The order of all three; None chooses each by cross-validation.
    seed : int, default 0
        Deals the blocks that are left out.
    progress : callable or None, optional
        Called with the share done.

    Returns
    -------
    tuple of MotionLaw
        Of Δθ (rad), Δx and Δy (m); one that cannot be fitted has its ``problem`` instead.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, set_laws
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.sin(theta), np.cos(theta)
    >>> pushes = PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, pairs=None)
    >>> set_laws(pushes, harmonics=1)[0].law.coefficients.round(6).tolist()[:2]
    [1.2, 0.1]
    """
    laws = []
    for index, quantity in enumerate(QUANTITIES):
        values = getattr(pushes, quantity)
        laws.append(motion_law(quantity, pushes.theta, values, harmonics=harmonics, seed=seed))
        part_of(progress, index, len(QUANTITIES))(1.0)
    return tuple(laws)


def motion_law(
    quantity: str,
    theta: ArrayLike,
    value: ArrayLike,
    *,
    harmonics: int | None = None,
    seed: int = 0,
) -> MotionLaw:
    """Fit value (n,) over theta (n,), rad, in order of recording; NaN values are passed over.

    From 100 pushes on the scatter may depend on θ. With fewer than 20, or where the pushes do not
    fix the law, it says so in ``problem``.
    """
    angles = np.asarray(theta, dtype=float)
    values = np.asarray(value, dtype=float)
    known = np.isfinite(values) & np.isfinite(angles)
    angles = angles[known]
    values = values[known]
    law = None
    if values.size < FEWEST:
        problem = f"too few pushes with a known end for a law: {values.size} of {FEWEST}"
    else:
        noise = None if values.size >= _FEWEST_FOR_SCATTER else 0
        try:
            law = fit_periodic_law(
                angles, values, harmonics=harmonics, noise_harmonics=noise, seed=seed
            )
        except (InvalidInput, ConvergenceError) as error:
            problem = str(error)
    if law is None:
        return MotionLaw(quantity, angles, values, None, float("nan"), problem)
    # Laws of the same order and weights, at blocks of successive pushes left out. Order and scatter
    # were chosen with all values: for a law of few coefficients that flatters it little.
    columns = fourier_columns(angles, law.harmonics)
    weight = scatter_weights(angles, law.log_variance)
    size = np.array([law.coefficients.size])
    fold = cycle_folds(angles, seed)
    errors = nested_errors(columns, values, size, fold, weight)[:, 0] / weight
    left_out_rms = float(np.sqrt(np.mean(errors[fold >= 0])))
    return MotionLaw(quantity, angles, values, law, left_out_rms)


@dataclass(frozen=True, eq=False)
class TurnHistogram:
    """Measured and predicted counts of the same number of pushes, in equal bins, in the unit of the
    values.

    Attributes
    ----------
    edges : ndarray, shape (k + 1,)
        Ends of the bins, in the unit of the values.
    measured : ndarray of int, shape (k,)
        Counts.
    predicted : ndarray, shape (k,)
        Expected counts where θ0 is one of the measured ones and projected by the law with its
        scatter; what falls outside the edges counts in the outer bins.
    law_alone : ndarray, shape (k,)
        The same without scatter, as Ma & Rodriguez (2018) drew it.
    total_variation, law_alone_total_variation : float
        ½ Σ |measured - predicted|/n in [0, 1].
    distance, law_alone_distance : float
        Wasserstein distance of order 1 of the values, ∫ |F - G|, in their unit.
    chance : PValue
        Of the total variation of as many pushes simulated from the law and refitted. Residuals
        are taken independent and normal: where they are correlated in time, as wear makes them,
        p is too small.

    References
    ----------
    Ma, D. & Rodriguez, A. (2018), Friction variability in planar pushing data, IEEE Robotics and
    Automation Letters 3(4).

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_periodic_law, turn_histogram
    >>> rng = np.random.default_rng(0)
    >>> theta = rng.uniform(0.0, 6.28, 100)
    >>> value = 1.0 + 0.2 * np.cos(theta) + 0.02 * rng.standard_normal(100)
    >>> law = fit_periodic_law(theta, value, harmonics=1)
    >>> found = turn_histogram(theta, value, law, bins=10, runs=20)
    >>> found.edges.shape, int(found.measured.sum()), 0.0 <= found.total_variation <= 1.0
    ((11,), 100, True)
    """

    edges: Array
    measured: Whole
    predicted: Array
    law_alone: Array
    total_variation: float
    law_alone_total_variation: float
    distance: float
    law_alone_distance: float
    chance: PValue

    @property
    def count(self) -> int:
        """How many pushes were measured."""
        return int(np.sum(self.measured))

    @property
    def chance_total_variation(self) -> float:
        """The total variation that 19 in 20 sets of as many pushes from the law
        itself stay below."""
        return float(self.chance.null_quantiles[PValue.LEVELS.index(0.95)])


def turn_histogram(
    theta: ArrayLike,
    value: ArrayLike,
    law: PeriodicLaw,
    *,
    bins: int = 40,
    runs: int = 200,
    seed: int = 0,
) -> TurnHistogram:
    """Compare measured values with what a law makes of their orientations, as histograms.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Orientations, rad.
    value : array_like, shape (n,)
        What was measured there, in the law's unit.
    law : PeriodicLaw
        That of the values over theta.
    bins : int, default 40
        How many equal bins.
    runs : int, default 200
        How many sets of pushes are simulated and refitted.
    seed : int, default 0
        Of these.

    Returns
    -------
    TurnHistogram
        Measured and predicted counts, and how far they are apart.

    Raises
    ------
    InvalidInput
        For lists of different lengths, fewer values than coefficients, and values all alike.

    Notes
    -----
    Predicted is the mixture of the laws N(law(θ_i), noise(θ_i)²) of all n orientations. A law
    fitted to the same values knows them: ``chance`` refits each simulated set, and so allows
    for that. Time: about 2 ms a run for 2000 pushes.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_periodic_law, turn_histogram
    >>> rng = np.random.default_rng(0)
    >>> theta = rng.uniform(0.0, 6.28, 400)
    >>> value = 1.0 + 0.2 * np.cos(theta) + 0.02 * rng.standard_normal(400)
    >>> found = turn_histogram(theta, value, fit_periodic_law(theta, value), runs=50)
    >>> found.count, found.total_variation < found.chance_total_variation < 0.2
    (400, True)
    """
    angles, values = paired_arrays("value", theta, value)
    centre = law(angles)
    noise = law.noise(angles)
    reach = _MARGIN * noise
    low = min(np.min(values), np.min(centre - reach))
    high = max(np.max(values), np.max(centre + reach))
    if not high - low > 1e-12 * max(abs(low), abs(high)):
        raise InvalidInput(f"all values are {values[0]:g}: there is no histogram to compare")
    edges = np.linspace(low, high, whole_number("bins", bins, least=2) + 1)
    grid = np.linspace(low, high, _FINER * bins + 1)
    seen = _empirical(grid, values)
    alone = _empirical(grid, centre)
    spread = _mixture(grid, centre, noise)
    seen_at, alone_at, spread_at = (column[::_FINER] for column in (seen, alone, spread))
    total_variation = _bin_distance(seen_at, spread_at)
    null = _refitted_distances(
        angles, law, edges, whole_number("runs", runs, least=1), whole_number("seed", seed, least=0)
    )
    return TurnHistogram(
        edges=read_only(edges),
        measured=np.histogram(values, edges)[0],
        predicted=read_only(values.size * np.diff(spread_at)),
        law_alone=read_only(values.size * np.diff(alone_at)),
        total_variation=total_variation,
        law_alone_total_variation=_bin_distance(seen_at, alone_at),
        distance=float(np.trapezoid(np.abs(seen - spread), grid)),
        law_alone_distance=float(np.trapezoid(np.abs(seen - alone), grid)),
        chance=monte_carlo_p_value(total_variation, null),
    )


def _refitted_distances(
    theta: Array, law: PeriodicLaw, edges: Array, runs: int, seed: int
) -> Array:
    """The total variation (runs,) of values made by the law at these orientations from what a law
    of the same order makes of them, fitted to each run's own, with the size of its scatter.
    """
    rng = np.random.default_rng(seed)
    centre = law(theta)
    noise = law.noise(theta)
    columns = fourier_columns(theta, law.harmonics)
    inverse = weighted_fit(columns, centre, noise**-2).covariance
    solve = inverse @ (columns / noise[:, np.newaxis] ** 2).T
    free = theta.size - law.coefficients.size
    distances = np.empty(runs)
    for run in range(runs):
        made = centre + noise * rng.standard_normal(theta.size)
        fitted = columns @ (solve @ made)
        size = np.sqrt(np.sum(((made - fitted) / noise) ** 2) / free)
        distances[run] = _bin_distance(
            _empirical(edges, made), _mixture(edges, fitted, size * noise)
        )
    return distances


def _empirical(grid: Array, values: Array) -> Array:
    """The distribution function of a sample on the grid, 0 at its first point and 1 at its last."""
    below = np.searchsorted(np.sort(values), grid, side="right") / values.size
    return np.concatenate([[0.0], below[1:-1], [1.0]])


def _mixture(grid: Array, centre: Array, noise: Array) -> Array:
    """The distribution function of the mixture of normal laws on the grid, the tails put into the
    outer cells.
    """
    from scipy.special import ndtr

    inner = np.mean(ndtr((grid[1:-1, np.newaxis] - centre) / noise), axis=1)
    return np.concatenate([[0.0], inner, [1.0]])


def _bin_distance(first: Array, second: Array) -> float:
    """Total variation of two distribution functions given at the edges of the bins."""
    return float(0.5 * np.sum(np.abs(np.diff(first - second))))


@dataclass(frozen=True, eq=False)
class SetFit:
    """A set with what was fitted to it; what could not be is None, and its row or ``map_problem``
    says why.

    Attributes
    ----------
    pushes : PushSet
        The set.
    statistics : PushStatistics
        Mean and deviation of what its pushes did.
    laws : tuple of MotionLaw
        The laws of Δθ (rad), Δx and Δy (m).
    histogram : TurnHistogram or None
        Of Δθ, measured and predicted; None without a law of Δθ, or where all Δθ are alike.
    cycle_map : MeasuredCycleMap or None
        The cycle map; None where it could not be fitted.
    map_problem : str or None
        Why there is no cycle map; None where there is.
    rest : RestMultiplier or None
        The multiplier of its last cycles, of one path without gaps that rests; else None.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, fit_set
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.sin(theta), np.cos(theta)
    >>> pushes = PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, pairs=None)
    >>> fit = fit_set(pushes, harmonics=1)
    >>> fit.is_empty, fit.map_problem
    (False, 'no push has a known next θ0')
    """

    pushes: PushSet
    statistics: PushStatistics
    laws: tuple[MotionLaw, ...]
    histogram: TurnHistogram | None
    cycle_map: MeasuredCycleMap | None
    map_problem: str | None
    rest: RestMultiplier | None = None

    @property
    def is_empty(self) -> bool:
        """Whether nothing could be fitted."""
        return self.cycle_map is None and all(law.law is None for law in self.laws)

    @property
    def law_problem(self) -> str | None:
        """Why there is a law missing, else None."""
        return next((law.problem for law in self.laws if law.problem), None)


def fit_set(
    pushes: PushSet,
    *,
    harmonics: int | None = None,
    wear: bool = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> SetFit:
    """Fit the laws, the histogram and the cycle map of a set; never fails for want of pushes.

    Parameters
    ----------
    pushes : PushSet
        The set.
    harmonics : int or None, optional
        The order of all laws; None chooses each by cross-validation.
    wear : bool, default True
        Whether the cycle map may change with the cycle.
    seed : int, default 0
        Of blocks left out and of simulated sets.
    progress : callable or None, optional
        Called with the share done.

    Returns
    -------
    SetFit
        What could be fitted, and why the rest could not.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from cyclemap.evidence import PushSet, fit_set
    >>> theta = np.linspace(0.0, 6.0, 30)
    >>> turn, dx, dy = 1.2 + 0.1 * np.cos(theta), np.sin(theta), np.cos(theta)
    >>> pushes = PushSet("slate", Path("slate.csv"), {}, 1, theta, turn, dx, dy, pairs=None)
    >>> [law.quantity for law in fit_set(pushes, harmonics=1).laws]
    ['dtheta', 'dx', 'dy']
    """
    laws = set_laws(pushes, harmonics=harmonics, seed=seed, progress=part_of(progress, 0, 2))
    histogram = None
    turns = laws[0]
    if turns.law is not None and turns.law.total_std != 0.0:
        histogram = turn_histogram(turns.theta, turns.value, turns.law, seed=seed)
    cycle_map = rest = None
    problem: str | None = "no push has a known next θ0"
    pairs = pushes.pairs
    if pairs is not None:
        try:
            cycle_map = measured_cycle_map(
                pairs,
                harmonics=harmonics,
                wear=wear,
                seed=seed,
                progress=part_of(progress, 1, 2),
            )
            problem = None
        except (InvalidInput, ConvergenceError) as error:
            problem = str(error)
        if pairs.path is not None and not pairs.moved:
            rest = rest_multiplier(pairs.path)
    part_of(progress, 0, 1)(1.0)
    return SetFit(pushes, push_statistics(pushes), laws, histogram, cycle_map, problem, rest)
