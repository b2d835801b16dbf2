"""How well a law of the initial orientation predicts Δθ, Δx, Δy (Ma & Rodriguez 2018, Table III)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.order_choice import cycle_folds, nested_errors
from cyclemap.evidence.laws.periodic_basis import fourier_columns
from cyclemap.evidence.laws.periodic_law import PeriodicLaw, fit_periodic_law, paired_arrays
from cyclemap.evidence.laws.periodic_noise import scatter_weights
from cyclemap.evidence.tables.push_sets import FEWEST, PushSet
from cyclemap.evidence.tables.push_statistics import QUANTITIES

# Below this many pushes the scatter is taken constant: its dependence on the angle cannot be told from chance.
FEWEST_FOR_SCATTER = 100


@dataclass(frozen=True, eq=False)
class MotionLaw:
    """The law of one quantity (Δθ in rad, Δx or Δy in m) over θ0, or why there is none.

    quantity : "dtheta", "dx" or "dy". theta, value : (n,), the pushes it was fitted to, in order of recording.
    law : with its RMSE, ``percent`` of the mean, order, scatter and bands; None where ``problem`` says why.
    cross_validated_rmse : root mean square error at pushes that the law was fitted without; NaN where too few.
    """

    quantity: str
    theta: Array
    value: Array
    law: PeriodicLaw | None
    cross_validated_rmse: float
    problem: str | None = None

    @property
    def explained(self) -> float:
        """The share of the variance that the law predicts in pushes left out; below 0 for one worse than the mean."""
        if self.law is None or self.law.total_std == 0.0:
            return float("nan")
        return 1.0 - (self.cross_validated_rmse / self.law.total_std) ** 2


@dataclass(frozen=True, eq=False)
class SetLaws:
    """A row of the table: a set's name, its count, and the laws of Δθ, Δx and Δy."""

    name: str
    count: int
    dtheta: MotionLaw
    dx: MotionLaw
    dy: MotionLaw

    @property
    def laws(self) -> tuple[MotionLaw, MotionLaw, MotionLaw]:
        """The three laws in the order of the table."""
        return self.dtheta, self.dx, self.dy

    @property
    def problem(self) -> str | None:
        """Why there is a law missing, else None."""
        return next((law.problem for law in self.laws if law.problem), None)


def set_laws(
    pushes: PushSet,
    *,
    harmonics: int | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> SetLaws:
    """Fit the three laws of a set; a law that cannot be fitted has its ``problem`` instead.

    harmonics : the order of all three; None chooses each by cross-validation. progress : called with the share done.
    """
    found = []
    for done, quantity in enumerate(QUANTITIES, 1):
        found.append(motion_law(quantity, pushes.theta, getattr(pushes, quantity), harmonics=harmonics, seed=seed))
        if progress is not None:
            progress(done / len(QUANTITIES))
    return SetLaws(pushes.name, pushes.count, *found)


def motion_law(
    quantity: str, theta: ArrayLike, value: ArrayLike, *, harmonics: int | None = None, seed: int = 0
) -> MotionLaw:
    """Fit value (n,) over theta (n,), rad, in order of recording; NaN values are passed over.

    From 100 pushes on the scatter may depend on θ. With fewer than 20, or where the pushes do not fix the law, it says
    so in ``problem``.

    >>> theta = np.linspace(0.0, 6.2, 60)
    >>> found = motion_law("dtheta", theta, 1.2 + 0.1 * np.cos(2 * theta))
    >>> found.law.harmonics, round(found.cross_validated_rmse, 9), motion_law("dx", [0.0], [1.0]).problem
    (2, 0.0, 'too few pushes with a known end for a law: 1 of 20')
    """
    angles = np.asarray(theta, dtype=float)
    values = np.asarray(value, dtype=float)
    known = np.isfinite(values) & np.isfinite(angles)
    angles, values = angles[known], values[known]
    if values.size < FEWEST:
        reason = f"too few pushes with a known end for a law: {values.size} of {FEWEST}"
        return MotionLaw(quantity, angles, values, None, float("nan"), reason)
    noise = None if values.size >= FEWEST_FOR_SCATTER else 0
    try:
        law = fit_periodic_law(angles, values, harmonics=harmonics, noise_harmonics=noise, seed=seed)
    except (InvalidInput, ConvergenceError) as error:
        return MotionLaw(quantity, angles, values, None, float("nan"), str(error))
    return MotionLaw(quantity, angles, values, law, held_out_rmse(law, angles, values, seed))


def held_out_rmse(law: PeriodicLaw, theta: ArrayLike, value: ArrayLike, seed: int = 0) -> float:
    """Root mean square error of such laws at values left out; inf where the other values do not fix the law.

    Same order, same weights; the ten folds are blocks of successive pushes (``cycle_folds``). Order and scatter were
    chosen with all values: for a law of few coefficients that flatters it little.

    Raises InvalidInput for lists of different lengths and fewer than 20 values.
    """
    angles, values = paired_arrays("value", theta, value)
    columns = fourier_columns(angles, law.harmonics)
    weight = scatter_weights(angles, law.log_variance)
    root = np.sqrt(weight)
    size = np.array([columns.shape[1]])
    errors = nested_errors(columns * root[:, np.newaxis], values * root, size, cycle_folds(values.size, seed))[:, 0]
    return float(np.sqrt(np.mean(errors / weight)))
