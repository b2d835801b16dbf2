"""P-values for orientations that follow one another: the null is simulated as paths of the noisy cycle map."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.harmonic_map import HARMONICS, harmonic_map
from cyclemap.evidence.orientations.circular_distance import DEFAULT_BINS, circular_wasserstein, total_variation
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.evidence.orientations.goodness_of_fit import kuiper_statistic, watson_statistic
from cyclemap.evidence.orientations.p_value import PValue, monte_carlo_p_value
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap, Noise, TransferOperator, WrappedNormal, sample_staircases, transfer_operator

Statistic = Callable[[Array, CircularLaw], Array]
Refit = Callable[[Array], tuple[CircleMap, Noise]]


def orientation_statistics(bins: int = DEFAULT_BINS) -> Mapping[str, Statistic]:
    """The four statistics by name: wasserstein (rad), total_variation over ``bins`` bins, kuiper and watson."""
    count = whole_number("bins", bins, least=1)
    return MappingProxyType(
        {
            "wasserstein": circular_wasserstein,
            "total_variation": partial(total_variation, bins=count),
            "kuiper": kuiper_statistic,
            "watson": watson_statistic,
        }
    )


def chain_p_value(
    theta: Any,
    circle_map: CircleMap,
    noise: Noise,
    statistic: str | Statistic,
    *,
    runs: int = 200,
    seed: int = 0,
    refit: Refit | None = None,
) -> PValue:
    """P-value of a path of orientations under θ' = F(θ) + ξ, autocorrelation and fitted parameters included.

    The statistic sets the path against the stationary law of the map and noise; the null is the same statistic of
    ``runs`` simulated paths, as long and from the same start.

    Parameters
    ----------
    theta : shape (n,), radians, n ≥ 2, in the order of the cycles; whole turns do not matter.
    circle_map, noise : the model. Where it was fitted to ``theta``, give ``refit`` too.
    statistic : "wasserstein", "total_variation", "kuiper" or "watson", or a vectorised callable of paths (runs, n)
        and a ``CircularLaw`` that gives (runs,), large where they disagree.
    runs : simulated paths; the smallest p-value is 1/(runs + 1). seed : of their noise.
    refit : None for a model given in full, else what fits a path (n,), unwrapped, to a (map, noise): every simulated
        path then is set against the law of its own fit (parametric bootstrap), as the measured one is. It must be
        what made ``circle_map`` and ``noise`` of ``theta``; otherwise p is too small or too large.

    Without ``refit`` the value is exact: P(p ≤ a) ≤ a under the null for any n and ``runs`` (Davison & Hinkley 1997,
    chapter 4). With ``refit`` it is so to first order in the error of the fit: true models of a slow chain of 300
    orientations, fitted with two harmonics, are measured to be rejected at the 5 % level in 2 to 5 % of runs, at 10 %
    in 7 to 10 %, the Wasserstein distance least often.
    Raises InvalidInput for a path or counts that cannot be used, ConvergenceError where a stationary law is not known
    to a tenth of the uniform density; what ``refit`` raises passes through.

    >>> from cyclemap.evidence.orientations.goodness_of_fit import watson_p_value
    >>> model = CircleMap.rigid(0.0), WrappedNormal(0.2)
    >>> path = sample_staircases(*model, 50, [0.0])[0]
    >>> p = chain_p_value(path, *model, "watson", runs=99)
    >>> p.value > 0.05, watson_p_value(p.statistic, 51) < 1e-6
    (True, True)
    """
    chosen = {"statistic": _statistic(statistic)}
    return chain_p_values(theta, circle_map, noise, chosen, runs=runs, seed=seed, refit=refit)["statistic"]


def chain_p_values(
    theta: Any,
    circle_map: CircleMap,
    noise: Noise,
    statistics: Mapping[str, Statistic] | None = None,
    *,
    runs: int = 200,
    seed: int = 0,
    refit: Refit | None = None,
    operator: TransferOperator | None = None,
) -> dict[str, PValue]:
    """The same for several statistics on the same simulated paths; None takes ``orientation_statistics()``.

    operator : of this map and noise, where it is at hand already.
    """
    path = checked_path(theta)
    count = whole_number("runs", runs, least=1)
    chosen = orientation_statistics() if statistics is None else statistics
    made = transfer_operator(circle_map, noise) if operator is None else operator
    law = stationary_law(made)
    observed = {name: float(_measured(measure, path[None], law)[0]) for name, measure in chosen.items()}
    starts = np.full(count, path[0])
    paths = sample_staircases(circle_map, noise, path.size - 1, starts, whole_number("seed", seed, least=0))
    null = _simulated(chosen, paths, law, refit)
    return {name: monte_carlo_p_value(observed[name], null[name]) for name in chosen}


def stationary_law(operator: TransferOperator) -> CircularLaw:
    """The stationary law of a noisy map as a table; ConvergenceError where it is not known well enough to test."""
    if not operator.is_certain:
        raise ConvergenceError(
            f"the stationary density is known to {operator.error_bound:.2g} a radian only: the noise hardly ever "
            "connects the map's basins, and no collection visits them by that law; raise the noise"
        )
    return CircularLaw(operator.density)


def checked_path(theta: Any) -> Array:
    """``theta`` as a finite path (n,) of at least two orientations, or InvalidInput."""
    path = finite_array("theta", theta, ndim=1)
    if path.size < 2:
        raise InvalidInput(f"theta holds {path.size} orientations: a chain needs at least two, in order")
    return path


def refit_harmonic_map(path: Array, harmonics: int = HARMONICS) -> tuple[CircleMap, WrappedNormal]:
    """The ``harmonic_map`` of an unwrapped path (n,) and its scatter as normal noise: a ``refit``."""
    unwrapped = checked_path(path)
    fitted = harmonic_map(Theta0Pairs(unwrapped[:-1], unwrapped[1:]), harmonics)
    return fitted.map, WrappedNormal(fitted.sigma)


def _simulated(
    chosen: Mapping[str, Statistic], paths: Array, law: CircularLaw, refit: Refit | None
) -> dict[str, Array]:
    if refit is None:
        return {name: _measured(measure, paths, law) for name, measure in chosen.items()}
    laws = [stationary_law(transfer_operator(*refit(path))) for path in paths]
    return {
        name: np.concatenate([_measured(measure, path[None], own) for path, own in zip(paths, laws, strict=True)])
        for name, measure in chosen.items()
    }


def _measured(measure: Statistic, paths: Array, law: CircularLaw) -> Array:
    values = finite_array("the statistic's values", measure(paths, law))
    if values.shape != (len(paths),):
        raise InvalidInput(f"the statistic gave shape {values.shape} for {len(paths)} paths: give one value a path")
    return values


def _statistic(statistic: str | Statistic) -> Statistic:
    if callable(statistic):
        return statistic
    known = orientation_statistics()
    if statistic not in known:
        raise InvalidInput(f"statistic is {statistic!r}: it must be a callable or one of {', '.join(known)}")
    return known[statistic]
