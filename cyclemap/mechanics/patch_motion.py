"""A patch's twist and the image of its rim in the velocity plane."""

from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca

from cyclemap.mechanics.outline import Outline, Polygon
from cyclemap.mechanics.rim import Expression, Rim, ellipse_nodes, ellipse_rim, polygon_rim
from cyclemap.mechanics.rim_excess import RimExcess, Tangent, ellipse_excess, polygon_excess

# Pairs (symbol, expression) to be substituted after any differentiation.
Frozen: TypeAlias = tuple[tuple[Expression, Expression], ...]


@dataclass(frozen=True)
class PatchMotion:
    """Twist of the frame's origin and traction, w(r) = matrix (velocity + omega z x r); `stretch`: det matrix."""

    velocity: Expression
    omega: Expression
    matrix: Expression
    stretch: Expression

    @property
    def map(self) -> Expression:
        """The derivative (2, 2) of w by r."""
        m = self.matrix
        return self.omega * ca.blockcat([[m[0, 1], -m[0, 0]], [m[1, 1], -m[1, 0]]])

    def at(self, point: Expression) -> Expression:
        """Return the velocity (2, 1) of a point."""
        return self.velocity + self.omega * quarter_turn(point)

    def image_area(self, outline: Outline) -> Expression:
        """Return the area of an outline's image."""
        return self.omega**2 * self.stretch * outline.area

    def hessian(self, curvature: Expression) -> Expression:
        """Return the derivatives (3, 3) by (vx, vy, omega) of a mean over w: by homogeneity from those by w alone."""
        block = self.matrix.T @ curvature @ self.matrix
        mixed = -block @ self.velocity / self.omega
        return ca.blockcat([[block, mixed], [mixed.T, -ca.dot(mixed, self.velocity) / self.omega]])


@dataclass(frozen=True)
class RimImage:
    """The image of an outline's rim: `places` are its corners' x and y, or an ellipse's nodes tau and their weights."""

    outline: Outline
    rim: Rim
    places: tuple[Expression, Expression]
    frozen: Frozen = ()

    def excess(self, tangent: Tangent) -> RimExcess:
        """Return what |w| exceeds a tangent by along the rim, of levers from the centroid."""
        outline = self.outline
        if isinstance(outline, Polygon):
            return polygon_excess(outline.array - outline.centroid, *self.places, self.rim, tangent)
        return ellipse_excess((outline.semi_x, outline.semi_y), *self.places, self.rim, tangent)


def rim_image(outline: Outline, motion: PatchMotion) -> RimImage:
    """Return the image of an outline's rim in the velocity plane."""
    velocity, omega, matrix = motion.velocity, motion.omega, motion.matrix
    if isinstance(outline, Polygon):
        corners = ca.DM(outline.array)
        vx, vy = velocity[0] - omega * corners[:, 1], velocity[1] + omega * corners[:, 0]
        places = matrix[0, 0] * vx + matrix[0, 1] * vy, matrix[1, 0] * vx + matrix[1, 1] * vy
        return RimImage(outline, polygon_rim(*places), places)
    cosine = omega * outline.semi_x * matrix @ ca.DM([0.0, 1.0])
    sine = omega * outline.semi_y * matrix @ ca.DM([-1.0, 0.0])
    image = matrix @ velocity, cosine, sine
    tau, weight, singularity = ellipse_nodes(*image)
    return RimImage(outline, ellipse_rim(*image, tau, weight), (tau, weight), (singularity,))


def quarter_turn(vector: Expression) -> Expression:
    """Return z x vector."""
    return ca.vertcat(-vector[1], vector[0])
