"""Variants of a loop along one fact: the ring's distance from the centre, and how anisotropic the surface is."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.fingerprint import Anisotropy
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError

from .loop_family import LoopAt

# Newton's method on a fold: radians of the turn and of its slope that count as none, and steps at most.
_FOLDED, _STEPS = 1e-9, 12
_ANGLE_STEP, _LENGTH_STEP = 1e-4, 1e-6


def ring_radius(loop: CollectionLoop) -> float:
    """Return the ring's distance from the object's origin, m."""
    return math.hypot(*loop.slider.hitch)


def with_ring_at(loop: CollectionLoop, radius: float) -> CollectionLoop:
    """Return the loop with its ring at a distance (m, positive) from the object's origin, in the same direction.

    >>> round(1000 * ring_radius(with_ring_at(CollectionLoop.mit(), 0.01)), 9)
    10.0
    """
    scale = positive_number("ring radius", radius) / ring_radius(loop)
    x, y = loop.slider.hitch
    return replace(loop, slider=replace(loop.slider, hitch=(scale * x, scale * y)))


def with_anisotropy_times(loop: CollectionLoop, scale: float) -> CollectionLoop:
    """Return the loop on its surface with offset and ellipticity times `scale`: 0 isotropic, 1 as it is.

    Offset and ellipticity are those of `Anisotropy`; the mean radius of the ellipse stays. The result does not wear.

    >>> with_anisotropy_times(CollectionLoop.mit(), 0.0).material.friction.m0
    0.0
    """
    law = loop.material.friction
    mean = math.sqrt(law.mu_a * law.mu_b)
    scaled = Anisotropy.of(law).scaled(non_negative_number("scale of the anisotropy", scale)).friction(mean)
    return replace(loop, material=replace(loop.material, friction=scaled, wear=None))


@dataclass(frozen=True)
class RingFold:
    """A saddle-node of the cycle map over the ring's radius: f(θ) = θ and f'(θ) = 1.

    theta : rad. radius : m. by_radius : ∂f/∂radius, rad/m. curvature : half of f'', per rad: the move of a cycle beside
    it is by_radius·(r - radius) + curvature·(θ - theta)².
    """

    theta: float
    radius: float
    by_radius: float
    curvature: float

    def passage_cycles(self, radius: float) -> float:
        """Return the cycles π/√(ε a) that the bottleneck takes at a radius (m) beyond the fold; inf where locked."""
        product = self.by_radius * (radius - self.radius) * self.curvature
        return math.pi / math.sqrt(product) if product > 0.0 else math.inf


def ring_fold(loop_at: LoopAt, theta: float, radius: float) -> RingFold:
    """Solve f(θ) = θ, f'(θ) = 1 for angle and radius by Newton's method from `theta` (rad) and `radius` (m).

    loop_at : radius -> loop. f, f' and ∂f/∂radius are the exact tangents of the mechanics (`sensitivity`), second
    derivatives differences of them. Raises ConvergenceError where 12 steps do not reach 1e-9 rad.
    """
    for _ in range(_STEPS):
        residual, jacobian = _fold_equations(loop_at, theta, radius)
        if np.abs(residual).max() <= _FOLDED:
            return RingFold(theta, radius, float(jacobian[0, 1]), 0.5 * float(jacobian[1, 0]))
        step = np.linalg.solve(jacobian, -residual)
        # A start far off must not throw the ring through the centre.
        step *= min(1.0, 0.2 / max(abs(step[0]), 1e-12), 0.1 * radius / max(abs(step[1]), 1e-12))
        theta, radius = theta + float(step[0]), radius + float(step[1])
    raise ConvergenceError(
        f"no saddle-node found near {math.degrees(theta):.4g} deg and {1000 * radius:.4g} mm: "
        f"residual {np.abs(residual).max():.2g} rad; start nearer"
    )


def _fold_equations(loop_at: LoopAt, theta: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """(f - θ, f' - 1) and its derivatives by (θ, radius)."""
    turn, slope, by_radius = _tangent(loop_at(radius), theta)
    ahead, behind = (_tangent(loop_at(radius), theta + side * _ANGLE_STEP)[1] for side in (1, -1))
    out, back = (_tangent(loop_at(radius + side * _LENGTH_STEP), theta)[1] for side in (1, -1))
    bend, twist = (ahead - behind) / (2.0 * _ANGLE_STEP), (out - back) / (2.0 * _LENGTH_STEP)
    return np.array([turn, slope - 1.0]), np.array([[slope - 1.0, by_radius], [bend, twist]])


def _tangent(loop: CollectionLoop, theta: float) -> tuple[float, float, float]:
    """The turn of a cycle, f' and ∂f/∂radius."""
    found = loop.sensitivity(theta, ("theta", "hitch_x", "hitch_y"))
    x, y = loop.slider.hitch
    by_radius = (x * found.by("hitch_x") + y * found.by("hitch_y")) / ring_radius(loop)
    return found.theta_next - found.theta, found.by_theta, by_radius
