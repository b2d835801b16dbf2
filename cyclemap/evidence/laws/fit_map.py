"""The cycle map fitted to measured pairs, how it wears, and the staircase that it makes."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.periodic_law import MAX_HARMONICS, PeriodicLaw, fit_periodic_law, paired_arrays
from cyclemap.evidence.laws.wear import MAX_WEAR_DEGREE, WornLaw, fit_worn_law
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
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

# Radians: the blend between a drifting map's cycles stays this near the law; far below any measured scatter.
BLEND_TOLERANCE = 1e-4
HARMONICS = 6
# Radians: no angle is measured better than this.
LEAST_SCATTER = 1e-9


@dataclass(frozen=True, eq=False)
class FittedMap:
    """The lift θ → θ + law(θ) that fits measured pairs, and how sure it is.

    law : the law of the turn (rad), all pairs alike: wear is in its scatter.
    wear : the law that changes with the cycle, with its own scatter; None where no cycle numbers were given.
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

        Raises InvalidInput where the pairs were fitted without cycle numbers.
        """
        return map_of_turn(self._worn().at(cycle))

    def drifting_map(self, cycles: int, first: float | None = None) -> DriftingMap:
        """The map that wears as measured, for ``cycles`` cycles; its cycle 0 is the measured cycle ``first``.

        first : None takes the first measured cycle. The blend between cycles is good to 1e-4 rad. Before and after the
        measured cycles the wear stands still: nothing is extrapolated.
        """
        worn = self._worn()
        start = worn.first if first is None else finite_number("first", first)
        count = whole_number("cycles", cycles, least=1)
        return DriftingMap.of_family(self.map_at, lambda n: start + n, count, BLEND_TOLERANCE)

    def paths(self, starts: ArrayLike, cycles: int, first: float | None = None, seed: int = 0) -> Array:
        """Paths of the worn map with its own scatter at each angle: (paths, cycles + 1) rad, unwrapped, starts first.

        starts : (paths,) rad, the θ0 of the measured cycle ``first`` (None: the first measured). The scatter of one
        cycle is taken as independent of the next one's; measured scatter often is not.
        """
        worn, count = self._worn(), whole_number("cycles", cycles, least=1)
        begin = worn.first if first is None else finite_number("first", first)
        rng = np.random.default_rng(whole_number("seed", seed, least=0))
        followed = [finite_array("starts", starts, ndim=1)]
        for n in range(count):
            law, theta = worn.at(begin + n), followed[-1]
            followed.append(theta + law(theta) + law.noise(theta) * rng.standard_normal(theta.size))
        return np.stack(followed, axis=1)

    def _worn(self) -> WornLaw:
        if self.wear is None:
            raise InvalidInput("the map was fitted without cycle numbers; give fit_map the cycle of each pair")
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
    max_wear_degree: int = MAX_WEAR_DEGREE,
    seed: int = 0,
) -> FittedMap:
    """Fit the cycle map to measured pairs: the turn θ_next - θ as a Fourier series of θ.

    theta, theta_next : (n,) radians in order of recording, ``theta_next`` lifted: the difference is the turn.
    cycle : (n,) the number of each pair's cycle; then the wear is fitted too, with its own choice of ``harmonics``
        and polynomial degree (``wear_degree`` None chooses up to ``max_wear_degree``), see ``fit_worn_law``.
    The rest is as in ``fit_periodic_law``.

    Raises InvalidInput for lists of different lengths, values that are not finite, and too few pairs.

    >>> theta = np.linspace(0.0, 6.0, 60)
    >>> fitted = fit_map(theta, theta + 0.3 - 0.2 * np.sin(theta), harmonics=1)
    >>> round(float(fitted.map.derivative(0.0)), 9), fitted.pairs
    (0.8, 60)
    """
    angles, images = paired_arrays("theta_next", theta, theta_next)
    options: dict[str, Any] = {"harmonics": harmonics, "max_harmonics": max_harmonics}
    options |= {"noise_harmonics": noise_harmonics, "seed": seed}
    law = fit_periodic_law(angles, images - angles, **options)
    if cycle is None:
        return FittedMap(law)
    wear = fit_worn_law(angles, images - angles, cycle, degree=wear_degree, max_degree=max_wear_degree, **options)
    return FittedMap(law, wear)


def map_of_turn(law: PeriodicLaw) -> CircleMap:
    """The lift θ → θ + law(θ) of degree 1, with its derivative, and a form for one number at a time."""
    # c_k cos kθ + s_k sin kθ is the real part of (c_k - i s_k) e^{ikθ}: one exponential, then Horner's rule.
    descending = (law.cosine - 1j * law.sine)[::-1].tolist()

    def scalar(theta: float) -> float:
        turner, total = cmath.exp(1j * theta), 0j
        for coefficient in descending:
            total = total * turner + coefficient
        return theta + total.real

    return CircleMap.with_scalar(lambda theta: theta + law(theta), lambda theta: 1.0 + law.slope(theta), scalar)


@dataclass(frozen=True, eq=False)
class MeasuredStaircase:
    """A measured path, and the staircase of the map fitted to it.

    path : (m,) rad, unwrapped. steps : the dwells and steps found in it, without a model.
    fitted : the map and noise fitted to its pairs. prediction : the staircase of that map, on average.
    run : one noisy run of it, as long as the path and from the same start.
    comparison : the path against the prediction, its visits counted in the predicted slow zones.
    """

    path: Array
    steps: Steps
    fitted: FittedMap
    prediction: StaircaseSummary
    run: Staircase
    comparison: StepComparison

    @property
    def cycles_a_turn(self) -> float:
        """Cycles the path took to climb a full turn, on average; inf where it ended where it began."""
        climb = abs(float(self.path[-1] - self.path[0])) / (2 * np.pi)
        return (len(self.path) - 1) / climb if climb > 0.0 else float("inf")


def measured_staircase(pairs: Theta0Pairs, seed: int = 0) -> MeasuredStaircase:
    """Find the steps of the measured path, fit its map, and predict the staircase from that.

    The fit takes all pairs alike: where the surface wears, its noise contains the wear.
    Raises InvalidInput where the order of the pushes is unknown, or the pairs do not fix the map.
    """
    path = pairs.unbroken.path
    if path is None:
        raise InvalidInput("the pairs come in no known order: a staircase needs theta0_deg, one row a push in order")
    fitted = fit_map(pairs.theta, pairs.theta_next, harmonics=HARMONICS)
    if fitted.sigma < LEAST_SCATTER:
        raise InvalidInput("the measured turns lie exactly on a smooth curve: they are no measurement with noise")
    noise, fitted_map = WrappedNormal(fitted.sigma), fitted.map
    prediction = predict_staircase(fitted_map, noise)
    visits = find_steps(path, zones=prediction.zones) if prediction.zones else find_steps(path)
    return MeasuredStaircase(
        path=path,
        steps=find_steps(path),
        fitted=fitted,
        prediction=prediction,
        run=sample_staircase(fitted_map, noise, len(path) - 1, float(path[0]), seed),
        comparison=compare_steps(visits, prediction),
    )
