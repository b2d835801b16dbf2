"""What a transfer operator asks of a finite basis for densities on the circle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from cyclemap.maps.arcs import Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise


class Discretisation(Protocol):
    """A basis of n functions on the circle, and one cycle θ' = F(θ) + ξ as a matrix on their coefficients.

    A density p(θ) = Σ_j c_j φ_j(θ), per radian, is its coefficients c, shape (n,), real, or complex where said.
    """

    @property
    def map(self) -> CircleMap:
        """The map of the cycle."""

    @property
    def noise(self) -> Noise:
        """The noise of the cycle."""

    @property
    def size(self) -> int:
        """n."""

    @property
    def matrix(self) -> Array:
        """(n, n): coefficients of the law after one cycle from those before it."""

    @property
    def mass(self) -> Array:
        """(n,): the integral of each φ_j over the circle."""

    @property
    def uniform(self) -> Array:
        """(n,): coefficients of the density 1/2π."""

    def evaluate(self, theta: Array) -> Array:
        """(m, n): every φ_j at the angles ``theta``, shape (m,), any turn."""

    def slope(self, theta: Array) -> Array:
        """(m, n): every φ_j' there (from the right where it is not smooth)."""

    def moments(self, order: int) -> Any:
        """(n,), complex: ∫ e^{i·order·θ} φ_j(θ) dθ over the circle."""

    def rule(self) -> tuple[Array, Array]:
        """Nodes and weights over one turn, exact to rounding for φ_j(θ) h(θ), h as smooth as F between its breaks."""

    def residual(self, law: Array) -> float:
        """A bound on sup_θ |(Lp)(θ) - p(θ)| per radian, L the true operator: truncation, quadrature and rounding."""

    def map_response(self, law: Any, tangent: Callable[[Array], Array], break_shifts: Array) -> Any:
        """(n,): coefficients of d(Lp) when F moves by ``tangent`` (radians a unit) and F's breaks by ``break_shifts``.

        ``law`` may be complex. ``break_shifts``: one rate a break of F, radians a unit.
        """

    def noise_response(self, law: Any) -> Any:
        """(n,): coefficients of d(Lp)/d(the noise's own parameter); ``law`` may be complex."""
