"""Friction: of one point, the offset limit ellipse of Ma & Rodriguez (2018), as it wears, and of a
whole footprint.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array, turned
from cyclemap.checks import finite_array, finite_number, positive_number, require_kind
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.engine.strokes import friction_values, pressure_tables
from cyclemap.mechanics.footprint import FOOTPRINTS, Footprint
from cyclemap.written import ANGLE


@dataclass(frozen=True)
class EllipseFriction:
    """Friction of one support point whose limit curve is an ellipse off its centre.

    Parameters
    ----------
    mu_a : float
        Semi-axis of the limit ellipse along the material's m axis, a friction coefficient,
        positive.
    mu_b : float
        Semi-axis along the n axis, positive.
    m0 : float, default 0.0
        m coordinate of the ellipse's centre.
    n0 : float, default 0.0
        n coordinate of the ellipse's centre.
    phi : float, default 0.0
        Direction of the m axis from the surface's x axis, rad, counter-clockwise.

    Raises
    ------
    InvalidInput
        Where a value is not finite, an axis is not positive, or the centre lies so far out that
        some direction of sliding would not dissipate: (m0/mu_a)^2 + (n0/mu_b)^2 must be below
        one.

    Notes
    -----
    In the material's axes (m, n), turned by `phi` (rad) counter-clockwise from the surface's x
    axis, the dissipation per unit load and distance is the support function of the limit
    ellipse (Ma & Rodriguez 2018, Eq. 2):

        h(v) = s + m0 v_m + n0 v_n,   s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2)

    and the traction coefficient is its gradient: mu_m = m0 + mu_a^2 v_m / s, mu_n = n0 + mu_b^2
    v_n / s.

    References
    ----------
    Ma, D. & Rodriguez, A. (2018), Friction variability in planar pushing data, IEEE Robotics and
    Automation Letters 3(4), Eq. 1-2.

    Examples
    --------
    >>> from cyclemap import EllipseFriction
    >>> EllipseFriction(0.3, 0.2).dissipation([1.0, 0.0])
    array(0.3)
    """

    mu_a: float
    mu_b: float
    m0: float = 0.0
    n0: float = 0.0
    phi: float = field(default=0.0, metadata=ANGLE)

    def __post_init__(self) -> None:
        for name in ("mu_a", "mu_b"):
            vars(self)[name] = positive_number(name, getattr(self, name))
        for name in ("m0", "n0", "phi"):
            vars(self)[name] = finite_number(name, getattr(self, name))
        if math.hypot(self.m0 / self.mu_a, self.n0 / self.mu_b) >= 1.0:
            raise InvalidInput(
                f"the friction ellipse mu_a={self.mu_a}, mu_b={self.mu_b} with centre "
                f"m0={self.m0}, n0={self.n0} does not contain zero, so some direction of sliding "
                "would gain energy: choose (m0/mu_a)^2 + (n0/mu_b)^2 < 1"
            )

    @classmethod
    def isotropic(cls, mu: float) -> "EllipseFriction":
        """Coulomb friction, the same coefficient `mu` in every direction."""
        return cls(mu, mu)

    def turned(self, angle: float) -> "EllipseFriction":
        """Return the same surface turned by `angle` (rad, counter-clockwise)."""
        return EllipseFriction(self.mu_a, self.mu_b, self.m0, self.n0, self.phi + angle)

    def dissipation(self, velocity: ArrayLike, frame: float = 0.0) -> Array:
        """Return the power lost per unit load.

        Parameters
        ----------
        velocity : array_like, shape (..., 2)
            m/s.
        frame : float, default 0.0
            Angle of the frame in which the velocity is given, seen from the surface, rad.

        Returns
        -------
        ndarray, shape (...)
            h(v), m/s.
        """
        v_m, v_n = np.moveaxis(self._in_material_axes(velocity, frame), -1, 0)
        return np.asarray(
            np.hypot(self.mu_a * v_m, self.mu_b * v_n) + self.m0 * v_m + self.n0 * v_n
        )

    def traction(self, velocity: ArrayLike, frame: float = 0.0) -> Array:
        """Return the traction coefficients at sliding velocities.

        Parameters
        ----------
        velocity : array_like, shape (..., 2)
            m/s, not zero.
        frame : float, default 0.0
            Angle of the frame in which velocity and traction are given, seen from the surface,
            rad.

        Returns
        -------
        ndarray, shape (..., 2)
            The force on the point is minus this, times the load.

        Raises
        ------
        InvalidInput
            At rest, where friction is not unique.
        """
        v_m, v_n = np.moveaxis(self._in_material_axes(velocity, frame), -1, 0)
        s = np.hypot(self.mu_a * v_m, self.mu_b * v_n)
        if np.any(s == 0.0):
            raise InvalidInput(
                "traction needs a sliding velocity: a velocity is zero, where friction is not "
                "unique"
            )
        t_m, t_n = self.m0 + self.mu_a**2 * v_m / s, self.n0 + self.mu_b**2 * v_n / s
        return turned(np.stack([t_m, t_n], axis=-1), self.phi - frame)

    def _in_material_axes(self, velocity: ArrayLike, frame: float) -> Array:
        given = finite_array("velocities", velocity, last=2)
        return turned(given, finite_number("frame", frame) - self.phi)


def worn_friction(fresh: EllipseFriction, worn: EllipseFriction, share: float) -> EllipseFriction:
    """Return the friction a share of the way from a fresh surface to a worn one.

    Parameters
    ----------
    fresh : EllipseFriction
        Friction at share 0.
    worn : EllipseFriction
        Friction at share 1.
    share : float
        How much of the way is gone, 0 to 1.

    Returns
    -------
    EllipseFriction
        The friction in between; at the ends that which was given.

    Notes
    -----
    The ellipse's centre c = R(φ)(m0, n0) and shape matrix S = R(φ) diag(mu_a², mu_b²) R(φ)ᵀ go
    in a straight line, so that angles that name the same ellipse (φ, φ + π; φ + π/2 with the
    axes exchanged) make no difference. cᵀ S⁻¹ c, which must be below one, is jointly convex in
    (c, S). Between the ends mu_a is of the axis nearest to `fresh`'s.

    Examples
    --------
    >>> from cyclemap.mechanics import EllipseFriction, worn_friction
    >>> between = worn_friction(EllipseFriction(0.3, 0.3), EllipseFriction(0.4, 0.3, m0=0.1), 0.5)
    >>> round(between.mu_a, 6), between.mu_b, between.m0
    (0.353553, 0.3, 0.05)
    """
    for law in (fresh, worn):
        require_kind("friction", law, EllipseFriction)
    share = finite_number("share of wear", share)
    if not 0.0 <= share <= 1.0:
        raise InvalidInput(f"share of wear is {share:g}: it runs from 0 (fresh) to 1 (worn)")
    if share in (0.0, 1.0) or fresh == worn:
        return worn if share == 1.0 else fresh
    (centre, shape), (worn_centre, worn_shape) = (centre_and_shape(law) for law in (fresh, worn))
    squares, axes = np.linalg.eigh((1.0 - share) * shape + share * worn_shape)
    first = np.array([math.cos(fresh.phi), math.sin(fresh.phi)])
    nearest = int(np.argmax(np.abs(first @ axes)))
    x, y = np.copysign(1.0, axes[:, nearest] @ first) * axes[:, nearest]
    m0, n0 = np.array([[x, y], [-y, x]]) @ ((1.0 - share) * centre + share * worn_centre)
    mu_a, mu_b = math.sqrt(squares[nearest]), math.sqrt(squares[1 - nearest])
    return EllipseFriction(mu_a, mu_b, float(m0), float(n0), math.atan2(float(y), float(x)))


def centre_and_shape(law: EllipseFriction, frame: float = 0.0) -> tuple[Array, Array]:
    """Return the centre c (2,) of a friction ellipse and its shape matrix S (2, 2), in a frame that
    is turned by an angle (rad): its dissipation is c.v + sqrt(v.S v).
    """
    c, s = math.cos(law.phi - frame), math.sin(law.phi - frame)
    axes = np.array([[c, -s], [s, c]])
    return axes @ (law.m0, law.n0), axes @ np.diag([law.mu_a**2, law.mu_b**2]) @ axes.T


@dataclass(frozen=True)
class LimitSurface:
    """Friction of a whole footprint, in its own frame, per unit load.

    Parameters
    ----------
    footprint : Footprint
        How the load is spread over the object.
    friction : EllipseFriction
        Friction of each point of the surface.

    Notes
    -----
    The dissipation D(V) is convex and homogeneous of degree one in the twist V = (vx, vy,
    omega) of the frame's origin; the friction wrench on the object is -grad D (maximum
    dissipation; Goyal, Ruina & Papadopoulos 1991). Exact footprints are accurate to 1e-10
    relative where the outline is at least 1 % as thick as it is long; thinner ones, and those
    that lean, lose digits in proportion: to 1e-6 at 1e-4, the thinnest that there may be. Of a
    PressedFootprint, `frame` is the object's orientation on the floor: what the floor's shape
    turns by against the plate; it is accurate to 1e-10 of the mean load times the shapes'
    numbers, where those are above one.

    References
    ----------
    Goyal, S., Ruina, A. & Papadopoulos, J. (1991), Planar sliding with dry friction, part 1: limit
    surface and moment function, Wear 143.

    Examples
    --------
    >>> from cyclemap import Ellipse, EllipseFriction, LimitSurface, PatchFootprint
    >>> surface = LimitSurface(PatchFootprint(Ellipse(1.0, 1.0)), EllipseFriction.isotropic(0.3))
    >>> round(float(surface.dissipation([0.0, 0.0, 1.0])), 12)  # pure spin of a disc: 2/3 mu R
    0.2
    """

    footprint: Footprint
    friction: EllipseFriction

    def __post_init__(self) -> None:
        require_kind("footprint", self.footprint, *FOOTPRINTS)
        require_kind("friction", self.friction, EllipseFriction)

    def dissipation(self, twist: ArrayLike, frame: float = 0.0) -> Array:
        """Return the dissipation D per unit load.

        Parameters
        ----------
        twist : array_like, shape (..., 3)
            Vx, vy, omega of the frame's origin (m/s, m/s, rad/s).
        frame : float, default 0.0
            Orientation of the object, rad.

        Returns
        -------
        ndarray, shape (...)
            D, m/s.
        """
        return self._evaluate(twist, frame)[..., 0]

    def wrench(self, twist: ArrayLike, frame: float = 0.0) -> Array:
        """Return the wrench that keeps the object moving, grad D.

        Parameters
        ----------
        twist : array_like, shape (..., 3)
            Vx, vy, omega of the frame's origin (m/s, m/s, rad/s).
        frame : float, default 0.0
            Orientation of the object, rad.

        Returns
        -------
        ndarray, shape (..., 3)
            (fx, fy) and the torque (m) about the frame's origin, per unit load.
        """
        return self._evaluate(twist, frame)[..., 1:4]

    def hessian(self, twist: ArrayLike, frame: float = 0.0) -> Array:
        """Return the second derivatives of D, (..., 3, 3)."""
        values = self._evaluate(twist, frame)[..., 4:]
        return values.reshape(*values.shape[:-1], 3, 3)

    def _evaluate(self, twist: ArrayLike, frame: float) -> Array:
        twists = finite_array("twist", twist, last=3)
        size, law = self.footprint.extent, self.friction
        # Lengths in extents: (v, omega) -> (v, omega size), D unchanged, derivatives by omega times
        # size.
        scale = np.array([1.0, 1.0, size])
        columns = (twists * scale).reshape(-1, 3)
        if np.any(np.all(columns == 0.0, axis=1)):
            raise InvalidInput("friction is not unique at rest: a twist is zero")
        angle = law.phi - finite_number("frame", frame)
        c, s = math.cos(angle), math.sin(angle)
        matrix = (law.mu_a * c, -law.mu_b * s, law.mu_a * s, law.mu_b * c)
        values = friction_values(pressure_tables(self.footprint), frame, matrix, columns)
        # The ellipse's centre (m0, n0) acts as one constant force at the centre of pressure.
        fx, fy = c * law.m0 - s * law.n0, s * law.m0 + c * law.n0
        x, y = np.divide(self.footprint.centre, size)
        constant = np.array((fx, fy, x * fy - y * fx))
        dissipation, wrench = values[:, 0] + columns @ constant, values[:, 1:4] + constant
        hessian = values[:, [4, 5, 7, 5, 6, 8, 7, 8, 9]] * np.outer(scale, scale).ravel()
        stacked = np.column_stack([dissipation, wrench * scale, hessian])
        return np.asarray(stacked.reshape(*twists.shape[:-1], 13))
