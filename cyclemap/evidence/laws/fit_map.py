"""The cycle map fitted to measured pairs, how it wears (coefficients polynomial in the cycle), and
its staircase.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, widest_gap
from cyclemap.checks import finite_array, finite_number, read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.periodic_law import (
    MAX_HARMONICS,
    PeriodicLaw,
    candidate_orders,
    fit_periodic_law,
    fit_series,
    law_of,
    paired_arrays,
    series_columns,
)
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import (
    CircleMap,
    Staircase,
    StaircaseSummary,
    StepComparison,
    Steps,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_staircase,
    sample_staircase,
)

MAX_WEAR_DEGREE = 4
HARMONICS = 6
# A law of so many harmonics may do anything in a wider gap (rad); it wants so many pairs more than
# coefficients.
_WIDEST_GAP = math.radians(60.0)
_FEWEST_FREE = 6
# Radians: no angle is measured better than this.
_LEAST_SCATTER = 1e-9
_LEAST_PAIRS = 8  # fewer do not tell a jump of their turns from a slope
_NEAR_WHOLE = 0.5  # radians: a change of the turn this near a whole one is one
_JUMP_SPREADS = 6.0  # or within so many of the usual changes from one angle to the next


@dataclass(frozen=True, eq=False)
class WornLaw:
    """A periodic law that wears: its coefficients are Σ_j P_j(s) coefficients[j], s the cycle
    scaled to [-1, 1].

    Attributes
    ----------
    coefficients : ndarray, shape (degree + 1, 2K + 1)
        Row j with Legendre's polynomial P_j; rows ordered as in ``PeriodicLaw``.
    first, last : float
        The cycles s = -1 and s = 1; outside them the law stays as it is at the nearer one.
    whole : PeriodicLaw
        The mean law of all these cycles, with the count, RMSE and scatter of the whole fit. The
        scatter does not wear.
    covariance : ndarray, shape (degree + 1, 2K + 1, degree + 1, 2K + 1)
        Of the coefficients.
    rmse_by_order : ndarray, shape (degrees, orders), or None
        As in ``PeriodicLaw``.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_worn_law
    >>> n = np.arange(400.0)
    >>> worn = fit_worn_law(2.4 * n, (1.0 + n / 100) * np.cos(2.4 * n), n, harmonics=1, degree=1)
    >>> worn.degree, worn.harmonics, round(float(worn.at(300.0).cosine[1]), 6)
    (1, 1, 4.0)
    """

    coefficients: Array
    first: float
    last: float
    whole: PeriodicLaw
    covariance: Array
    rmse_by_order: Array | None = None

    @property
    def degree(self) -> int:
        """The degree of the polynomials; 0 for a law that does not wear."""
        return len(self.coefficients) - 1

    @property
    def harmonics(self) -> int:
        """How many harmonics the law has at each cycle."""
        return len(self.coefficients[0]) // 2

    def turns(self, theta: Array, cycle: Array) -> Array:
        """The law (n,) at the angles ``theta`` (n,), rad, each in its own ``cycle`` (n,)."""
        polynomials = _polynomials(cycle, self.first, self.last, self.degree)
        return series_columns(theta, polynomials, self.harmonics) @ self.coefficients.T.ravel()

    def at(self, cycle: float) -> PeriodicLaw:
        """The law of one cycle (any real number), with the covariance of that cycle's
        coefficients."""
        now = _polynomials(
            np.array([finite_number("cycle", cycle)]), self.first, self.last, self.degree
        )[0]
        covariance = np.einsum("i,iajb,j->ab", now, self.covariance, now)
        return replace(self.whole, coefficients=now @ self.coefficients, covariance=covariance)


def fit_worn_law(
    theta: ArrayLike,
    value: ArrayLike,
    cycle: ArrayLike,
    *,
    harmonics: int | None = None,
    max_harmonics: int = MAX_HARMONICS,
    degree: int | None = None,
    noise_harmonics: int | None = 0,
    seed: int = 0,
) -> WornLaw:
    """Fit a Fourier series in θ whose coefficients are polynomials of the cycle number, in least
    squares.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Angles, rad, the rows in order of recording.
    value : array_like, shape (n,)
        Values, any unit.
    cycle : array_like, shape (n,)
        Numbers of the cycles.
    harmonics : int or None, optional
        The order of the series; None: chosen, together with the degree where that is None, as
        in ``fit_periodic_law``: by blocks of successive cycles left out, the fewest
        coefficients within one standard error of the best.
    max_harmonics : int, optional
        The largest order that is tried.
    degree : int or None, optional
        Of the polynomials; None: chosen.
    noise_harmonics : int or None, default 0
        As in ``fit_periodic_law``.
    seed : int, default 0
        As in ``fit_periodic_law``.

    Returns
    -------
    WornLaw
        The law at every cycle.

    Raises
    ------
    InvalidInput
        As in ``fit_periodic_law``, and where all cycles are the same.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_worn_law
    >>> n = np.arange(400.0)
    >>> worn = fit_worn_law(2.4 * n, (1.0 + n / 100) * np.cos(2.4 * n), n, harmonics=1, degree=1)
    >>> worn.at(100.0).coefficients.round(9).tolist()[1]
    2.0
    """
    angles, values = paired_arrays("value", theta, value)
    cycles = finite_array("cycle", cycle, ndim=1)
    if cycles.size != values.size:
        raise InvalidInput(
            f"cycle has {cycles.size} entries for {values.size} pairs; give one a pair"
        )
    if np.ptp(cycles) == 0.0:
        raise InvalidInput(f"every cycle is {cycles[0]:g}; wear needs cycles that differ")
    first = float(cycles.min())
    last = float(cycles.max())
    orders = candidate_orders("harmonics", harmonics, max_harmonics)
    degrees = candidate_orders("degree", degree, MAX_WEAR_DEGREE)
    polynomials = _polynomials(cycles, first, last, max(degrees))
    fit, log_variance, order, power, errors = fit_series(
        angles,
        values,
        polynomials,
        orders=orders,
        degrees=degrees,
        noise_harmonics=noise_harmonics,
        seed=seed,
    )
    shape = (2 * order + 1, power + 1)
    coefficients = read_only(fit.coefficients.reshape(shape).T)
    covariance = read_only(fit.covariance.reshape(shape + shape).transpose(1, 0, 3, 2))
    plain = replace(fit, coefficients=coefficients[0], covariance=covariance[0, :, 0, :])
    mean = law_of(plain, log_variance, values, None)
    errors = None if errors is None else read_only(errors)
    return WornLaw(coefficients, first, last, mean, covariance, errors)


def _polynomials(cycles: Array, first: float, last: float, degree: int) -> Array:
    """Legendre's polynomials (n, degree + 1) of the cycles, held at the ends of [first, last]."""
    scaled = np.clip((2.0 * cycles - first - last) / (last - first), -1.0, 1.0)
    return np.asarray(np.polynomial.legendre.legvander(scaled, degree))


@dataclass(frozen=True, eq=False)
class FittedMap:
    """The lift θ → θ + law(θ) that fits measured pairs, and how sure it is.

    Attributes
    ----------
    law : PeriodicLaw
        The law of the turn (rad), all pairs alike: wear is in its scatter.
    wear : WornLaw or None
        The law that changes with the cycle, with its own scatter; None where no cycle numbers
        were given.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import fit_map
    >>> theta = np.linspace(0.0, 6.0, 60)
    >>> fitted = fit_map(theta, theta + 0.3 - 0.2 * np.sin(theta), harmonics=1)
    >>> fitted.map.degree, fitted.sigma < 1e-9
    (1, True)
    """

    law: PeriodicLaw
    wear: WornLaw | None = None

    @property
    def map(self) -> CircleMap:
        """The fitted map, of degree 1, with its exact derivative."""
        return map_of_turn(self.law)

    @property
    def sigma(self) -> float:
        """Radians, root mean square scatter of one cycle about ``map``."""
        return self.law.sigma

    @property
    def pairs(self) -> int:
        """How many pairs were fitted."""
        return self.law.count

    def map_at(self, cycle: float) -> CircleMap:
        """The map of one cycle; outside the measured cycles, that of the nearest.

        Parameters
        ----------
        cycle : float
            Number of the cycle.

        Returns
        -------
        CircleMap
            Of degree 1.

        Raises
        ------
        InvalidInput
            Where the pairs were fitted without cycle numbers.
        """
        return map_of_turn(self._worn().at(cycle))

    def paths(
        self, starts: ArrayLike, cycles: int, first: float | None = None, seed: int = 0
    ) -> Array:
        """Paths of the worn map with its own scatter at each angle.

        Parameters
        ----------
        starts : array_like, shape (paths,)
            rad, the θ0 of the measured cycle ``first``.
        cycles : int
            How many cycles.
        first : float or None, optional
            Where in the wear the paths begin; None: the first measured cycle.
        seed : int, default 0
            Of the scatter.

        Returns
        -------
        ndarray, shape (paths, cycles + 1)
            Rad, unwrapped, starts first.

        Notes
        -----
        The scatter of one cycle is taken as independent of the next one's; measured scatter often
        is not.
        """
        worn = self._worn()
        count = whole_number("cycles", cycles, least=1)
        begin = worn.first if first is None else finite_number("first", first)
        rng = np.random.default_rng(whole_number("seed", seed, least=0))
        followed = [finite_array("starts", starts, ndim=1)]
        for n in range(count):
            law = worn.at(begin + n)
            theta = followed[-1]
            followed.append(theta + law(theta) + law.noise(theta) * rng.standard_normal(theta.size))
        return np.stack(followed, axis=1)

    def _worn(self) -> WornLaw:
        if self.wear is None:
            raise InvalidInput(
                "the map was fitted without cycle numbers; give fit_map the cycle of each pair"
            )
        return self.wear


def fit_map(
    theta: ArrayLike,
    theta_next: ArrayLike,
    *,
    harmonics: int | None = None,
    max_harmonics: int = MAX_HARMONICS,
    noise_harmonics: int | None = 0,
    cycle: ArrayLike | None = None,
    wear_degree: int | None = None,
    seed: int = 0,
) -> FittedMap:
    """Fit the cycle map to measured pairs: the turn θ_next - θ as a Fourier series of θ.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Angles, rad, in order of recording.
    theta_next : array_like, shape (n,)
        Their images, rad, lifted: the difference is the turn. Where all images lie within one
        turn, and turns of neighbouring angles differ by whole ones, they were wrapped: whole
        turns are then added so that neighbours agree, and the middle turn lies in [-π, π).
    harmonics : int or None, optional
        The order; None chooses it, as in ``fit_periodic_law``.
    max_harmonics : int, optional
        The largest order that is tried.
    noise_harmonics : int or None, default 0
        As in ``fit_periodic_law``.
    cycle : array_like, shape (n,), optional
        The number of each pair's cycle; then the wear is fitted too, with its own choice of
        ``harmonics`` and polynomial degree, see ``fit_worn_law``.
    wear_degree : int or None, optional
        Degree of the wear's polynomials; None chooses up to 4.
    seed : int, default 0
        As in ``fit_periodic_law``.

    Returns
    -------
    FittedMap
        The map, its scatter, and its wear.

    Raises
    ------
    InvalidInput
        For lists of different lengths, values that are not finite, too few pairs, and turns
        that jump by a whole one where images are not all within one turn.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import fit_map
    >>> theta = np.linspace(0.0, 6.0, 60)
    >>> fitted = fit_map(theta, theta + 0.3 - 0.2 * np.sin(theta), harmonics=1)
    >>> round(float(fitted.map.derivative(0.0)), 9), fitted.pairs
    (0.8, 60)
    """
    angles, images = paired_arrays("theta_next", theta, theta_next)
    images = angles + _without_jumps(angles, images)
    law = fit_periodic_law(
        angles,
        images - angles,
        harmonics=harmonics,
        max_harmonics=max_harmonics,
        noise_harmonics=noise_harmonics,
        seed=seed,
    )
    if cycle is None:
        return FittedMap(law)
    wear = fit_worn_law(
        angles,
        images - angles,
        cycle,
        harmonics=harmonics,
        max_harmonics=max_harmonics,
        degree=wear_degree,
        noise_harmonics=noise_harmonics,
        seed=seed,
    )
    return FittedMap(law, wear)


def _without_jumps(theta: Array, images: Array) -> Array:
    """The turns of all pairs, those of wrapped images less the whole turns that they jump by."""
    turn = images - theta
    if turn.size < _LEAST_PAIRS:
        return turn
    order = np.argsort(np.mod(theta, TWO_PI), kind="stable")
    # From each angle to the next one round the circle: whole turns, and what is left of the change.
    change = np.diff(turn[order], append=turn[order[0]])
    whole = np.round(change / TWO_PI)
    left = np.abs(change - TWO_PI * whole)
    jumps = whole != 0.0
    allowed = max(_NEAR_WHOLE, _JUMP_SPREADS * float(np.median(left)))
    if (
        np.count_nonzero(jumps) < 2
        or np.sum(whole) != 0.0
        or float(np.median(left[jumps])) > allowed
    ):
        return turn
    if np.ptp(images) > TWO_PI:
        place = float(np.mod(theta[order[int(np.argmax(jumps))]], TWO_PI))
        raise InvalidInput(
            f"the turns jump by whole ones, {np.count_nonzero(jumps)} times, first near theta = "
            f"{place:.4g} rad: give theta_next unwrapped, so that theta_next - theta is the turn"
        )
    mended = np.empty_like(turn)
    mended[order] = np.unwrap(turn[order])
    middle = float(np.median(mended))
    return np.asarray(mended - TWO_PI * np.floor((middle + np.pi) / TWO_PI))


def map_of_turn(law: PeriodicLaw) -> CircleMap:
    """The lift θ → θ + law(θ) of degree 1, with its derivative, and a form for one number at a
    time.
    """
    # c_k cos kθ + s_k sin kθ is the real part of (c_k - i s_k) e^{ikθ}: one exponential, then
    # Horner's rule.
    descending = (law.cosine - 1j * law.sine)[::-1].tolist()

    def scalar(theta: float) -> float:
        turner = cmath.exp(1j * theta)
        total = 0j
        for coefficient in descending:
            total = total * turner + coefficient
        return theta + total.real

    return CircleMap.with_scalar(
        lambda theta: theta + law(theta), lambda theta: 1.0 + law.slope(theta), scalar
    )


@dataclass(frozen=True, eq=False)
class FittedStaircase:
    """The staircase of a map fitted to measured pairs.

    Attributes
    ----------
    fitted : FittedMap
        The map and noise fitted to the pairs.
    prediction : StaircaseSummary
        Its staircase, on average.
    run : Staircase
        One noisy run of it, as long as the path and from the same start.
    comparison : StepComparison
        The path against the prediction, its visits counted in the predicted slow zones.
    """

    fitted: FittedMap
    prediction: StaircaseSummary
    run: Staircase
    comparison: StepComparison


@dataclass(frozen=True, eq=False)
class MeasuredStaircase:
    """A measured path, and the staircase of the map fitted to it.

    Attributes
    ----------
    path : ndarray, shape (m,)
        Orientations, rad, unwrapped.
    steps : Steps
        The dwells and steps found in the path, without a model.
    foretold : FittedStaircase or None
        What the map fitted to its pairs makes of it; None where the pairs do not fix a map all
        around, and `problem` says why.
    problem : str
        Why there is nothing foretold; empty where there is.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_staircase
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for scatter in 0.05 * rng.standard_normal(80):
    ...     path.append(path[-1] + 0.5 + 0.3 * math.sin(path[-1]) + scatter)
    >>> theta = np.array(path)
    >>> found = measured_staircase(Theta0Pairs(theta[:-1], theta[1:], path=theta))
    >>> round(found.cycles_a_turn, 1), found.problem
    (15.4, '')
    """

    path: Array
    steps: Steps
    foretold: FittedStaircase | None
    problem: str = ""

    @property
    def cycles_a_turn(self) -> float:
        """Cycles the path took to climb a full turn, on average;
        inf where it ended where it began."""
        climb = abs(float(self.path[-1] - self.path[0])) / TWO_PI
        return (len(self.path) - 1) / climb if climb > 0.0 else float("inf")


def measured_staircase(pairs: Theta0Pairs, seed: int = 0) -> MeasuredStaircase:
    """Find the steps of a measured path, fit its map, and predict the staircase from that: wear
    counts as noise.

    Parameters
    ----------
    pairs : Theta0Pairs
        Measured steps of the cycle map, in order.
    seed : int, default 0
        Of the noisy run, and of the choice of the fit's order.

    Returns
    -------
    MeasuredStaircase
        The path, its steps, and what its map foretells.

    Raises
    ------
    InvalidInput
        Where the order of the pushes is unknown, or the turns have no noise.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_staircase
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for scatter in 0.05 * rng.standard_normal(80):
    ...     path.append(path[-1] + 0.5 + 0.3 * math.sin(path[-1]) + scatter)
    >>> theta = np.array(path)
    >>> found = measured_staircase(Theta0Pairs(theta[:-1], theta[1:], path=theta))
    >>> found.foretold.run.theta.shape, len(found.steps.start)
    ((81,), 0)
    """
    path = pairs.unbroken.path
    if path is None:
        raise InvalidInput(
            "the pairs come in no known order: a staircase needs theta0_deg, one row a push in "
            "order"
        )
    steps = find_steps(path)
    gap = widest_gap(pairs.theta)
    harmonics = min(HARMONICS, (pairs.theta.size - _FEWEST_FREE) // 4)
    problem = ""
    if gap > _WIDEST_GAP:
        problem = (
            f"θ0 leave a gap of {math.degrees(gap):.0f}°, and what cycles do there nothing tells"
        )
    elif harmonics < 1:
        problem = f"{pairs.theta.size} cycles are too few to fit a map to"
    if problem:
        return MeasuredStaircase(path, steps, None, problem)
    fitted = fit_map(pairs.theta, pairs.theta_next, harmonics=harmonics)
    if fitted.sigma < _LEAST_SCATTER:
        raise InvalidInput(
            "the measured turns lie exactly on a smooth curve: they are no measurement with noise"
        )
    noise = WrappedNormal(fitted.sigma)
    fitted_map = fitted.map
    try:
        prediction = predict_staircase(fitted_map, noise)
    except ConvergenceError as error:
        return MeasuredStaircase(
            path, steps, None, f"of the map fitted to them no staircase can be computed: {error}"
        )
    visits = find_steps(path, zones=prediction.zones) if prediction.zones else steps
    run = sample_staircase(fitted_map, noise, len(path) - 1, float(path[0]), seed)
    foretold = FittedStaircase(fitted, prediction, run, compare_steps(visits, prediction))
    return MeasuredStaircase(path, steps, foretold)
