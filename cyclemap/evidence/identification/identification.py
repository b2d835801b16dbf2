"""What an identification found: each parameter with its interval, how the data are met, and what remains open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cyclemap.evidence.identification.cross_validation import CrossValidation, KindErrors
from cyclemap.evidence.identification.identifiability import Uncertainty
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import Fit, MultiStart
from cyclemap.evidence.identification.surface_parameters import SHARE_NAMES, SurfaceParameters
from cyclemap.mechanics import EllipseFriction
from cyclemap.suggestions import unknown_name


@dataclass(frozen=True)
class Estimate:
    """One parameter.

    value, lower, upper : best value and ends of its interval, in `unit`. standard_error : to first order, inf where the
    data do not fix it. identifiable : whether the data exclude any value between the bounds. at_bound : `lower`,
    `upper`, or empty. lower_open, upper_open : the end is a bound, not a finding.
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

    def __str__(self) -> str:
        if not self.identifiable:
            return f"{self.name} not identifiable"
        return f"{self.name} {self.value:.4g} ({self.lower:.4g} to {self.upper:.4g})"


@dataclass(frozen=True, eq=False)
class Identification:
    """Parameters identified from data.

    estimates : of the free parameters. fixed : values that were held. level : of the intervals. priors : what was
    believed (value, standard deviation). errors : by block and
    kind, in sample and left out. starts : what became of each start. fit : the minimum. uncertainty : to first order.
    validation : residuals of rows left out, None if not asked for. notes : all that qualifies the result, in words.
    problem : what was solved.
    """

    estimates: tuple[Estimate, ...]
    fixed: Mapping[str, float]
    level: float
    priors: Mapping[str, tuple[float, float]]
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

    @property
    def plates(self) -> dict[str, dict[str, float]]:
        """Shares of the weight by plate; of one plate alone, which no name tells apart, under the empty name."""
        return plate_shares(self.values)

    def friction(self) -> EllipseFriction:
        """Return the identified friction ellipse."""
        return self.surface.to_friction()


def plate_shares(values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return the shares of the weight that values tell by plate; of a plate that no name tells apart, under the empty.

    >>> plate_shares({"rim_share[hex]": 0.5, "inner_share[hex]": 0.5, "offset_x": 0.1})
    {'hex': {'inner_share': 0.25, 'rim_share': 0.5, 'corner_share': 0.0}}
    """
    named = {name.partition("[")[2].rstrip("]") for name in values if name.partition("[")[0] in SHARE_NAMES}
    found = {}
    for plate in sorted(named):
        tail = f"[{plate}]" if plate else ""
        own = {name: values[name + tail] for name in SHARE_NAMES if name + tail in values}
        found[plate] = SurfaceParameters.from_values(own).shares
    return found
