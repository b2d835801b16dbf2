"""The transfer operator under uniform noise, by collocation on panels that end where laws are not smooth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.scan import Cells, monotone_cells
from cyclemap.maps.noise.bounded_noise import UniformNoise
from cyclemap.maps.noise.panels import (
    ORDER,
    Panels,
    law_singularities,
    level_steps,
    refined,
    resolving_cuts,
    tails,
    with_ends,
)

RESOLUTION = 512
MAX_PANELS = 100
_TOLERANCES = np.array([1e-13, 1e-9, 1e-9, 1e-9, 1e-9])  # of the stationary law, and of four waves after a few cycles
_UNRESOLVED = 1e-5  # share of the law's largest coefficient: rougher on the most panels, and nothing is known of it
_CYCLES = 4
_FIRST = 8  # panels to begin with
_BLOCK = 2_048


def uniform_discretisation(
    circle_map: CircleMap, noise: UniformNoise, *, max_panels: int = MAX_PANELS
) -> UniformDiscretisation:
    """Panels on which the stationary law of θ' = F(θ) + ξ, ξ uniform, and its slow departures are resolved.

    Panels end at F's breaks and where the law kinks or has a square root, with polynomials in an angle beside the
    latter; they are cut further until the law's last coefficients are below 1e-13, or there are ``max_panels`` (of 24
    functions each). Accuracy, as ``residual`` tells it, beside a density of order 1/2h: about 1e-12 for monotone maps,
    1e-8 with folds, down to h = 0.03 rad; worse where F has an inflection with F' = 0.

    Raises InvalidInput unless the noise is ``UniformNoise`` and max_panels at least 16, ConvergenceError where
    the last coefficients of the law are above 1e-5 on that many panels.
    """
    if not isinstance(noise, UniformNoise):
        raise InvalidInput(f"the noise is {noise!r}: these panels are for UniformNoise")
    most = whole_number("max_panels", max_panels, least=16)
    cells = monotone_cells(circle_map, 1, 0.0, RESOLUTION)
    singular = law_singularities(circle_map, cells, noise.halfwidth)
    ends = with_ends(np.array([0.0, TWO_PI]), circle_map.breaks)
    ends = with_ends(ends, singular.upto(1).theta)
    ends = with_ends(ends, np.linspace(0.0, TWO_PI, _FIRST + 1))

    def made(panels: Panels) -> UniformDiscretisation:
        return UniformDiscretisation(panels.start, panels.end, panels.bent, circle_map, noise, cells)

    seen: list[Array] = []  # the stationary law on the panels that were tried last

    def tried(panels: Panels) -> Array:
        """(n, 5): the stationary law, and the waves cos, sin of θ and 2θ after a few cycles."""
        trial = made(panels)
        columns = [wave(k * panels.nodes) for wave in (np.cos, np.sin) for k in (1, 2)]
        waves = panels.coefficients(np.stack(columns, axis=1))
        for _ in range(_CYCLES):
            waves = trial.matrix @ waves
        bordered = np.eye(trial.size) - trial.matrix + np.outer(trial.uniform, trial.mass)
        try:
            law = np.linalg.solve(bordered, trial.uniform)
        except np.linalg.LinAlgError:
            law = np.full(trial.size, np.nan)
        if not np.all(np.isfinite(law)):
            # Two arcs that the noise never connects: the law is not unique, but its parts are as rough as this.
            law = np.linalg.matrix_power(trial.matrix, 64) @ trial.uniform
        seen[:] = [law[:, None]]
        return np.column_stack([law, waves])

    found = made(refined(ends, singular, tried, _TOLERANCES, most))
    left = float(np.max(tails(found, seen[0])))
    if found.count >= most and left > _UNRESOLVED:
        raise ConvergenceError(
            f"{noise!r} needs more than {most} panels: the last coefficients of the stationary density are still "
            f"{left:.2g} of its largest; raise the halfwidth, or take a noise with a smooth density"
        )
    return found


@dataclass(frozen=True, eq=False)
class UniformDiscretisation(Panels):
    """One cycle θ' = F(θ) + ξ, ξ uniform on [-h, h], on panels of the circle; made by ``uniform_discretisation``.

    (Lp)(y) = (H(y - h) - H(y + h))/2h with H(z) = ∫ p(θ) ⌊(F(θ) - z)/2π⌋ dθ: the antiderivative of p at the angles
    where F crosses a level, so no discontinuous kernel is ever integrated.
    """

    map: CircleMap
    noise: UniformNoise
    cells: Cells

    @cached_property
    def matrix(self) -> Array:
        """(n, n): coefficients of the law after one cycle from those before it."""
        nodes, width, count = self.nodes, self.noise.halfwidth, self.size
        row, theta, height, last = level_steps(self.map, self.cells, np.concatenate([nodes - width, nodes + width]))
        weight = np.asarray(np.where(row < count, -1.0, 1.0) * height, dtype=np.float64)
        values = self.integral_matrix(theta, weight, row % count, count)
        values += np.multiply.outer(last[:count] - last[count:], self.mass)
        return np.asarray(self.coefficients(values) / (2.0 * width))

    @property
    def uniform(self) -> Array:
        """(n,): coefficients of the density 1/2π."""
        return np.tile(np.eye(ORDER)[0] / TWO_PI, self.count)

    def evaluate(self, theta: Array) -> Array:
        """(m, n): every basis function at the angles, any turn."""
        return super().evaluate(np.mod(theta, TWO_PI))

    def slope(self, theta: Array) -> Array:
        """(m, n): their derivatives; beside a square root, where it is infinite, read a little inside."""
        return super().slope(np.mod(theta, TWO_PI))

    def moments(self, order: int) -> Any:
        """(n,), complex: ∫ e^{i·order·θ} φ_j(θ) dθ."""
        longest = float(np.max(self.half))
        theta, weight = self.cut_rule(np.zeros(0), ORDER + int(np.ceil(abs(order) * longest)) + 8)
        waves, total = np.exp(1j * order * theta) * weight, np.zeros(self.size, dtype=np.complex128)
        for at in range(0, theta.size, _BLOCK):
            total += waves[at : at + _BLOCK] @ super().evaluate(theta[at : at + _BLOCK])
        return total

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Nodes and weights over one turn, on panels cut at F's breaks and samples and where F is steep."""
        return self.cut_rule(resolving_cuts(self.map, self), ORDER + 8)

    def residual(self, law: Array) -> float:
        """Twice the largest |(Lp)(θ) - p(θ)| at three times as many angles as collocation has, plus rounding.

        (Lp) is the true operator's, but for rounding: the crossings and the antiderivative are exact. So the
        bound is measured only in that the maximum is taken over finitely many angles.
        """
        theta, width = self.test_points, self.noise.halfwidth
        row, crossing, height, last = level_steps(self.map, self.cells, np.concatenate([theta - width, theta + width]))
        beyond = last * (self.mass @ law)  # H at every level
        np.add.at(beyond, row, -height * self.integral(law, crossing))
        below, above = np.split(beyond, 2)
        here = self.value(law, theta)
        worst = float(np.max(np.abs((below - above) / (2.0 * width) - here)))
        return 2.0 * worst + EPS * (8.0 * float(np.max(np.abs(here))) + 2.0 / width)
