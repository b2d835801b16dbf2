"""What an identification found: each parameter with its interval, how the data are met, and what remains open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cyclemap.evidence.identification.cross_validation import CrossValidation, KindErrors
from cyclemap.evidence.identification.identifiability import Uncertainty
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import Fit, MultiStart
from cyclemap.evidence.identification.parameter_space import Parameter
from cyclemap.evidence.identification.profile_likelihood import Interval
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics import EllipseFriction
from cyclemap.suggestions import unknown_name


@dataclass(frozen=True)
class Estimate:
    """One parameter.

    value, lower, upper : best value and ends of its interval, in `unit`. standard_error : to first order, inf where the
    data do not fix it. identifiable : whether the data exclude any value between the bounds. at_bound : `lower`,
    `upper`, or empty. lower_open, upper_open : the end is a bound, not a finding. method : `profile` or `covariance`.
    """

    name: str
    description: str
    unit: str
    value: float
    lower: float
    upper: float
    standard_error: float
    identifiable: bool
    at_bound: str
    lower_open: bool
    upper_open: bool
    method: str

    def __str__(self) -> str:
        if not self.identifiable:
            return f"{self.name} not identifiable"
        return f"{self.name} {self.value:.4g} ({self.lower:.4g} to {self.upper:.4g})"


@dataclass(frozen=True, eq=False)
class Identification:
    """Parameters identified from data.

    estimates : of the free parameters. fixed : values that were held. level : of the intervals. errors : by block and
    kind, in sample and left out. starts : what became of each start. fit : the minimum. uncertainty : to first order.
    validation : residuals of rows left out, None if not asked for. notes : all that qualifies the result, in words.
    problem : what was solved.
    """

    estimates: tuple[Estimate, ...]
    fixed: Mapping[str, float]
    level: float
    errors: tuple[KindErrors, ...]
    starts: MultiStart
    fit: Fit
    uncertainty: Uncertainty
    validation: CrossValidation | None
    notes: tuple[str, ...]
    problem: JointProblem

    def __getitem__(self, name: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.name == name:
                return estimate
        raise unknown_name("identified parameter", name, [estimate.name for estimate in self.estimates])

    @property
    def converged(self) -> bool:
        """Whether minimum and noise were found to tolerance."""
        return self.fit.converged

    @property
    def values(self) -> dict[str, float]:
        """Every parameter's value by name, identified or held."""
        return self.problem.values(self.fit.vector)

    @property
    def surface(self) -> SurfaceParameters:
        """The identified surface; what the data were not asked about has its nominal value."""
        return SurfaceParameters.from_values(self.values)

    def friction(self) -> EllipseFriction:
        """Return the identified friction ellipse."""
        return self.surface.to_friction()


def estimate(
    parameter: Parameter, value: float, error: float, interval: Interval, on_bound: bool, method: str
) -> Estimate:
    """Put one parameter's results together."""
    nearer_lower = value - parameter.lower <= parameter.upper - value
    return Estimate(
        parameter.name,
        parameter.description,
        parameter.unit,
        value,
        interval.lower,
        interval.upper,
        error,
        interval.identifiable,
        ("lower" if nearer_lower else "upper") if on_bound else "",
        interval.lower_open,
        interval.upper_open,
        method,
    )
