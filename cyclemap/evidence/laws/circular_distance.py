"""Orientations against a law on the circle: distances, statistics with Monte Carlo p-values, and
modes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from cyclemap.arrays import TWO_PI, Array, even_angles
from cyclemap.checks import finite_array, finite_number, positive_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.turn_bins import bin_shares
from cyclemap.maps.operator.transfer_operator import peaks_of
from cyclemap.written import NUMBER

Density = Callable[[Array], Array]

_MASS_ERROR = (
    0.01  # a density that jumps is integrated to about a thousandth; one in other units is far off
)
_NEGATIVE = -1e-3 / TWO_PI  # rounding and truncated series dip below zero, but never that far
DEFAULT_BINS = 36
_TIE = 1e-12  # values that differ by rounding alone count as equal, which makes p larger
DEFAULT_BANDWIDTH = 0.1  # rad, about 6 degrees
_LEAST_RISE = 0.1 / TWO_PI  # a tenth of the uniform density
_REACH = 8.5  # bandwidth times harmonics, beyond which the kernel's coefficients are below 1e-15
_NARROWEST = 0.002


@dataclass(frozen=True, eq=False)
class CircularLaw:
    """A law on the circle, tabulated once so that many samples can be set against it.

    Parameters
    ----------
    density : callable
        Vectorised, of angles in [0, 2π] (rad), per radian, period 2π.
    cells : int, default 2048
        Of the table, equal, at least 8.

    Attributes
    ----------
    reached : scipy.interpolate.CubicHermiteSpline
        Distribution function of an angle in [0, 2π], rad; its knots are the ends of the cells.

    Raises
    ------
    InvalidInput
        Where the density is not finite, negative, not vectorised, or further than 1 % from
        integrating to 1.

    Notes
    -----
    The distribution function is integrated by Simpson's rule and is a monotone cubic inside
    each cell (slopes limited as by Fritsch & Carlson 1980): error O(h⁴), h = 2π/cells, for a
    smooth positive density, O(h³) where it touches 0, O(h) beside a jump. The table is rescaled
    to mass 1.

    References
    ----------
    Fritsch, F. N. & Carlson, R. E. (1980), Monotone piecewise cubic interpolation, SIAM Journal on
    Numerical Analysis 17(2).

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import CircularLaw
    >>> law = CircularLaw(lambda theta: (1 + np.cos(theta)) / (2 * np.pi))
    >>> round(float(law.cumulative(np.pi / 2)), 12) == round(0.25 + 1 / (2 * np.pi), 12)
    True
    """

    density: Density
    cells: int = 2048
    reached: CubicHermiteSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not callable(self.density):
            raise InvalidInput(
                f"density is {self.density!r}: give a vectorised callable of angles in radians"
            )
        count = whole_number("cells", self.cells, least=8)
        angles = np.linspace(0.0, TWO_PI, 2 * count + 1)
        values = finite_array("the density's values", self.density(angles))
        if values.shape != angles.shape:
            raise InvalidInput(
                f"the density gave shape {values.shape} for {angles.shape}: it must be vectorised"
            )
        worst = int(np.argmin(values))
        if values[worst] < _NEGATIVE:
            raise InvalidInput(
                f"the density is {values[worst]:g} at {angles[worst]:g} rad: it must not be "
                "negative"
            )
        values = np.maximum(values, 0.0)
        below = cumulative_simpson(values, dx=angles[1], initial=0.0)[::2]
        total = float(below[-1])
        if abs(total - 1.0) > _MASS_ERROR:
            raise InvalidInput(
                f"the density integrates to {total:g} over the circle, not 1: give it per radian"
            )
        # At most three times the mean slope of either cell beside: the cubic then never falls.
        mean = np.diff(below) / np.diff(angles[::2])
        least = np.minimum(np.append(mean, mean[0]), np.append(mean[-1], mean))
        slopes = np.minimum(values[::2], 3.0 * least)
        reached = CubicHermiteSpline(angles[::2], below / total, slopes / total)
        object.__setattr__(self, "reached", reached)

    def cumulative(self, theta: ArrayLike) -> Array:
        """Probability of the arc from 0 to θ mod 2π, any shape."""
        return np.asarray(self.reached(np.mod(finite_array("theta", theta), TWO_PI)))

    def bin_probabilities(self, bins: int) -> Array:
        """Probability of each of ``bins`` equal bins over [0, 2π)."""
        inner = self.cumulative(np.arange(bins) * (TWO_PI / bins))
        return np.diff(np.append(inner, 1.0))


def orientations(name: str, sample: ArrayLike, single: bool = False) -> Array:
    """Angles brought into [0, 2π), shape (..., n) with n ≥ 1, or (n,) where ``single``; else
    InvalidInput.
    """
    angles = finite_array(name, sample, ndim=1 if single else None)
    if angles.ndim == 0 or angles.size == 0:
        raise InvalidInput(
            f"{name} has shape {angles.shape}: give at least one orientation in radians"
        )
    wrapped = np.mod(angles, TWO_PI)
    # An angle a hair below 0 wraps to exactly 2π.
    return np.where(wrapped >= TWO_PI, 0.0, wrapped)


def _two_samples(sample: ArrayLike, second: ArrayLike) -> tuple[Array, Array]:
    angles = orientations("sample", sample, single=True)
    return angles, orientations("second sample", second, single=True)


def circular_wasserstein(sample: ArrayLike, law: CircularLaw | ArrayLike) -> Array:
    """Return the Wasserstein distance of order 1 on the circle.

    Parameters
    ----------
    sample : array_like, shape (..., n)
        Orientations, rad, any turn; each row is a sample of its own.
    law : CircularLaw or array_like, shape (m,)
        A law, or a second sample, with which ``sample`` must be (n,).

    Returns
    -------
    ndarray, shape (...)
        Distances, rad, in [0, π]; a number for one sample.

    Raises
    ------
    InvalidInput
        For an empty sample and numbers that are not finite.

    Notes
    -----
    W1 = ∫ |F - G - median(F - G)| dθ, F and G the distribution functions from any origin, the
    median over the uniform measure (Rabin, Delon & Gousseau 2011). Between two samples it is exact
    to rounding. Against a law, G is taken as linear between the table's knots and the sample's
    angles: an error of at most h²/8 times the total variation of the density, h = 2π/cells; about
    1e-6 rad for a density with one peak of height 1.

    References
    ----------
    Rabin, J., Delon, J. & Gousseau, Y. (2011), Transportation distances on the circle, Journal of
    Mathematical Imaging and Vision 41.

    Examples
    --------
    >>> from cyclemap.evidence import circular_wasserstein
    >>> round(float(circular_wasserstein([0.1, 0.1], [6.2])), 6)
    0.183185
    """
    if not isinstance(law, CircularLaw):
        # F - G is constant from one angle of either sample to the next.
        pair = _two_samples(sample, law)
        angles = np.unique(np.concatenate(pair))
        shares = [np.searchsorted(np.sort(own), angles, side="right") / own.size for own in pair]
        levels = shares[0] - shares[1]
        gaps = np.diff(angles, append=angles[0] + TWO_PI)
        order = np.argsort(levels)
        median = levels[order[np.argmax(np.cumsum(gaps[order]) >= np.pi)]]
        return np.asarray(np.abs(levels - median) @ gaps)[()]
    return np.apply_along_axis(_distance_from_law, -1, orientations("sample", sample), law)[()]


def _distance_from_law(angles: Array, law: CircularLaw) -> float:
    """∫ |F - G - median(F - G)| dθ of one sample (n,), rad in [0, 2π)."""
    places = np.concatenate([angles, law.reached.x[:-1]])
    order = np.argsort(places)
    places = places[order]
    width = np.diff(places, append=TWO_PI)
    # F - G falls on each segment between samples and knots, from high to low.
    steps = np.cumsum(order < angles.size) / angles.size
    reached = np.append(law.reached(places), 1.0)
    high = steps - reached[:-1]
    low = steps - reached[1:]
    span = np.where(high > low, high - low, 1.0)
    rate = np.where(high > low, 1.0 / span, 1e300)
    # The level that it lies below on half of the circle; the integral is flat there.
    level = brentq(lambda level: np.clip((level - low) * rate, 0.0, 1.0) @ width - np.pi, -2.0, 2.0)
    above = high - level
    below = low - level
    crossing = (above > 0.0) & (below < 0.0)
    mean = np.where(crossing, (above**2 + below**2) / (2.0 * span), 0.5 * np.abs(above + below))
    return float(width @ mean)


def total_variation(
    sample: ArrayLike, law: CircularLaw | ArrayLike, bins: int = DEFAULT_BINS
) -> Array:
    """Return the total variation distance ½ Σ |share of the sample - probability| over equal bins
    of [0, 2π).

    Parameters
    ----------
    sample : array_like, shape (..., n)
        Orientations, rad, as for ``circular_wasserstein``.
    law : CircularLaw or array_like, shape (m,)
        As for ``circular_wasserstein``.
    bins : int, optional
        How many bins.

    Returns
    -------
    ndarray, shape (...)
        Distances in [0, 1]; a number for one sample.

    Notes
    -----
    Bins hide what differs inside them, so that it is at most the distance of the laws themselves; n
    independent orientations from the law itself lie Σ √(P(1 - P)/(2πn)) away on average, more where
    they are autocorrelated.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import CircularLaw, total_variation
    >>> uniform = CircularLaw(lambda theta: np.full_like(theta, 0.5 / np.pi))
    >>> float(total_variation([0.5, 1.0, 2.0, 3.0], uniform, bins=2))
    0.5
    """
    if not isinstance(law, CircularLaw):
        shares, against = (bin_shares(own, bins) for own in _two_samples(sample, law))
    else:
        shares = bin_shares(orientations("sample", sample), bins)
        against = law.bin_probabilities(bins)
    return np.asarray(0.5 * np.sum(np.abs(shares - against), axis=-1))[()]


@dataclass(frozen=True, eq=False)
class PValue:
    """A Monte Carlo p-value and what it rests on.

    Attributes
    ----------
    value : float
        (1 + number of simulated statistics that reach the observed one)/(runs + 1), in (0, 1]:
        under the null P(value ≤ a) ≤ a for any a and any number of runs.
    runs : int
        How many simulated statistics.
    statistic : float
        The observed one.
    null_quantiles : ndarray, shape (7,)
        The simulated ones at ``LEVELS``.
    standard_error : float
        Of ``value`` by the finite number of runs: the posterior standard deviation of the true
        p after a uniform prior, which is never 0.

    References
    ----------
    Davison, A. C. & Hinkley, D. V. (1997), Bootstrap methods and their application, Cambridge.

    Examples
    --------
    >>> from cyclemap import CircleMap, WrappedNormal
    >>> from cyclemap.evidence import CollectionModel, collection_p_values
    >>> model = CollectionModel(CircleMap.rigid(0.25), WrappedNormal(0.1))
    >>> path = model.paths(0.0, 50, 1, seed=5)[0]
    >>> turns = collection_p_values(path, model, runs=19)["turns"]
    >>> turns.runs, 0.05 <= turns.value <= 1.0
    (19, True)
    """

    LEVELS: ClassVar[tuple[float, ...]] = (0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)

    value: float = field(metadata={"name": "p_value", "unit": NUMBER})
    runs: int
    statistic: float
    null_quantiles: Array
    standard_error: float


def monte_carlo_p_value(observed: float, simulated: ArrayLike) -> PValue:
    """The upper-tail p-value of ``observed`` among ``simulated`` (runs,) values under the null.

    Raises InvalidInput without simulated values or where a number is not finite.
    """
    null = finite_array("simulated", simulated, ndim=1)
    mark = finite_number("observed", observed)
    if null.size == 0:
        raise InvalidInput("there are no simulated values: run at least one")
    reached = int(np.sum(null >= mark - _TIE * max(1.0, abs(mark))))
    more = reached + 1
    fewer = null.size - reached + 1
    total = null.size + 2
    error = float(np.sqrt(more * fewer / (total**2 * (total + 1))))
    quantiles = read_only(np.quantile(null, PValue.LEVELS))
    return PValue((1 + reached) / (null.size + 1), null.size, mark, quantiles, error)


def kuiper_statistic(sample: ArrayLike, law: CircularLaw) -> Array:
    """Return Kuiper's V = max(F - G) + max(G - F); it does not depend on the origin of the angles.

    Parameters
    ----------
    sample : array_like, shape (..., n)
        Orientations, rad, any turn; each row is a sample of its own.
    law : CircularLaw
        What it is set against.

    Returns
    -------
    ndarray, shape (...)
        V in (0, 1].

    Raises
    ------
    InvalidInput
        For an empty sample, and numbers that are not finite.

    References
    ----------
    Kuiper, N. H. (1960), Tests concerning random points on a circle, Indagationes Mathematicae 22.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import CircularLaw, kuiper_statistic
    >>> uniform = CircularLaw(lambda theta: np.full_like(theta, 0.5 / np.pi))
    >>> round(float(kuiper_statistic([0.0, np.pi], uniform)), 12)
    0.5
    """
    reached = np.sort(law.cumulative(orientations("sample", sample)), axis=-1)
    rank = np.arange(reached.shape[-1] + 1) / reached.shape[-1]
    return np.asarray(np.max(rank[1:] - reached, axis=-1) + np.max(reached - rank[:-1], axis=-1))[
        ()
    ]


def watson_statistic(sample: ArrayLike, law: CircularLaw) -> Array:
    """Return Watson's U² = n ∫ (F - G - mean)² dG; it does not depend on the origin of the angles.

    Parameters
    ----------
    sample : array_like, shape (..., n)
        Orientations, rad, any turn; each row is a sample of its own.
    law : CircularLaw
        What it is set against.

    Returns
    -------
    ndarray, shape (...)
        U², at least 1/(12n).

    Raises
    ------
    InvalidInput
        For an empty sample, and numbers that are not finite.

    References
    ----------
    Watson, G. S. (1961), Goodness-of-fit tests on a circle, Biometrika 48.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import CircularLaw, watson_statistic
    >>> uniform = CircularLaw(lambda theta: np.full_like(theta, 0.5 / np.pi))
    >>> round(float(watson_statistic([0.0, np.pi], uniform)), 6)
    0.041667
    """
    reached = np.sort(law.cumulative(orientations("sample", sample)), axis=-1)
    size = reached.shape[-1]
    excess = reached - (2.0 * np.arange(size) + 1.0) / (2.0 * size)
    return np.asarray(size * np.var(excess, axis=-1) + 1.0 / (12.0 * size))[()]


def kernel_modes(theta: ArrayLike, bandwidth: float = DEFAULT_BANDWIDTH) -> Array:
    """Return the maxima of a wrapped normal kernel estimate of the density of orientations.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Orientations, rad, any turn.
    bandwidth : float, optional
        The kernel's standard deviation, rad, 0.002 to π.

    Returns
    -------
    ndarray, shape (k,)
        Angles in [0, 2π), sorted.

    Notes
    -----
    The estimate is a finite Fourier series, exactly: p = 1/2π + (1/π) Σ e^(-h²k²/2) Re(c_k*
    e^(ikθ)), c_k the mean of e^(ikθ). Maxima that rise less than a tenth of the uniform density
    above the dips beside them are left out.

    Examples
    --------
    >>> from cyclemap.evidence import kernel_modes
    >>> kernel_modes([1.0, 1.0, 4.0]).round(6).tolist()
    [1.0, 4.0]
    """
    angles = orientations("theta", theta, single=True)
    width = positive_number("bandwidth", bandwidth)
    if not _NARROWEST <= width <= np.pi:
        raise InvalidInput(f"bandwidth is {width:g} rad: give one between {_NARROWEST} and π")
    order = np.arange(1, int(np.ceil(_REACH / width)) + 1)
    moments = np.array([np.mean(np.exp(1j * k * angles)) for k in order])
    weights = np.exp(-0.5 * np.square(width * order)) * moments.conj() / np.pi

    def series(at: Array, weights: Array) -> Array:
        return np.real(np.exp(1j * np.multiply.outer(at, order)) @ weights)

    count = 1 << int(np.ceil(np.log2(8 * order.size)))
    grid = even_angles(count)
    values = 1.0 / TWO_PI + series(grid, weights)
    return peaks_of(lambda at: series(at, 1j * order * weights), grid, values, _LEAST_RISE)
