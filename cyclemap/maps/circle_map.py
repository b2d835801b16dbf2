"""CircleMap: a lift θ → F(θ) with F(θ + 2π) = F(θ) + 2π·degree, smooth between its breaks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, cos, sin
from typing import Any

import numpy as np

from cyclemap.checks import finite_array, finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.piecewise_cubic import PiecewiseCubic, cubic_from_samples

Lift = Callable[[Array], Array]
Scalar = Callable[[float], float]

SIDE_STEP = 8.0 * np.finfo(float).eps * np.pi  # how far beside a break its one-sided limits are read
JUMP = 1e-10  # radians: one-sided limits that differ by more are a jump, else a kink
SNAP = 1e-12  # radians: angles this near a break are that break
_CHECKED = np.linspace(-5.0, 6.0, 12) + 0.0137 * np.sqrt(np.arange(2.0, 14.0))
_CENTRED, _ONE_SIDED = np.arange(-2.0, 3.0), np.arange(0.0, 5.0)
_CENTRED_WEIGHTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
_ONE_SIDED_WEIGHTS = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
_DIFFERENCE_STEP = 1e-3


@dataclass(frozen=True, init=False, eq=False, repr=False)
class CircleMap:
    """A map of the circle given by its lift, an ordinary function of the real line.

    Parameters
    ----------
    lift : vectorised callable, radians to radians, F(θ + 2π) = F(θ) + 2π·degree; never wrapped.
    derivative : vectorised callable for F', or None: then differences of fourth order that never reach across
        a break; their error is about 1e-11 + 1e-13·|F⁽⁵⁾| in [-2π, 2π].
    breaks : angles (radians, any order, any turn) where F jumps or F' does. F is taken to be continuous
        from the right there: ``F(b)`` should be the limit from above.
    degree : how often the image runs round while θ runs round once; any whole number.
    max_error : a bound on |lift - truth| in radians that the maker of the map claims; 0 for an exact map.

    Attributes: ``breaks`` (sorted, in [0, 2π)), ``degree``, ``max_error``, ``samples`` (number of sample
    points; 0 for a map given by formulas). The value never changes after construction.

    Raises InvalidInput when the lift is not a lift of that degree, gives NaN, or is not vectorised.

    Example
    -------
    >>> import numpy as np
    >>> tilted = CircleMap(lambda x: x + 0.5 + 0.3 * np.cos(x), lambda x: 1 - 0.3 * np.sin(x))
    >>> round(float(tilted.turn(0.0)), 12)
    0.8
    """

    breaks: Array
    degree: int
    max_error: float
    samples: int
    pieces: PiecewiseCubic | None
    _lift: Lift
    _derivative: Lift | None
    _scalar: Scalar | None

    def __init__(
        self,
        lift: Lift,
        derivative: Lift | None = None,
        breaks: Any = (),
        degree: int = 1,
        *,
        max_error: float = 0.0,
    ) -> None:
        if not callable(lift) or (derivative is not None and not callable(derivative)):
            raise InvalidInput(f"lift is {lift!r}: lift and derivative must be callables of an array of angles")
        claimed = finite_number("max_error", max_error)
        if claimed < 0.0:
            raise InvalidInput(f"max_error is {claimed:g}: a bound on an error cannot be negative")
        sorted_breaks = np.unique(np.mod(finite_array("breaks", breaks, ndim=1), TWO_PI))
        self._set(
            breaks=read_only(sorted_breaks[sorted_breaks < TWO_PI]),
            degree=whole_number("degree", degree),
            max_error=claimed,
            samples=0,
            pieces=None,
            _lift=lift,
            _derivative=derivative,
            _scalar=None,
        )
        self._check_lift()

    def _set(self, **fields: Any) -> None:
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    def _check_lift(self) -> None:
        points = _CHECKED + 1e-3 * (self._distance_to_break(_CHECKED) < 1e-6)
        low, high = self._checked_call(self._lift, points), self._checked_call(self._lift, points + TWO_PI)
        gap = np.abs(high - low - TWO_PI * self.degree)
        worst = int(np.argmax(gap))
        if gap[worst] > 1e-8 * (1.0 + np.abs(low[worst])):
            raise InvalidInput(
                f"not a lift of degree {self.degree}: F(θ + 2π) - F(θ) is {high[worst] - low[worst]:.9g} "
                f"at θ = {points[worst]:.6g}, not {TWO_PI * self.degree:.9g}; give a lift that is not wrapped"
            )
        if self._derivative is not None:
            self._checked_call(self._derivative, points)
        self._checked_call(lambda theta: self._beside(self._lift, theta, -1), self.breaks)
        self._checked_call(lambda theta: self._beside(self._lift, theta, 1), self.breaks)

    @staticmethod
    def _checked_call(function: Lift, points: Array) -> Array:
        values = np.asarray(function(points), dtype=np.float64)
        if values.shape != points.shape:
            raise InvalidInput(
                f"the callable turns shape {points.shape} into {values.shape}: it must act entry by entry"
            )
        if not np.all(np.isfinite(values)):
            raise InvalidInput(f"the callable gives {values[~np.isfinite(values)][0]}: it must be finite everywhere")
        return values

    def __repr__(self) -> str:
        return f"CircleMap(degree={self.degree}, samples={self.samples}, breaks={self.breaks.size})"

    # -- values --------------------------------------------------------------------------------------------

    def __call__(self, theta: Any) -> Array:
        """The lift F(θ); ``theta`` in radians, any shape, any real numbers."""
        return self._lift(np.asarray(theta, dtype=np.float64))

    def turn(self, theta: Any) -> Array:
        """F(θ) - θ, radians: how far one cycle turns."""
        angles = np.asarray(theta, dtype=np.float64)
        return self._lift(angles) - angles

    def derivative(self, theta: Any) -> Array:
        """F'(θ); at a break the derivative from the right."""
        angles = np.asarray(theta, dtype=np.float64)
        if self._derivative is not None:
            return self._derivative(angles)
        return self._differences(angles)

    def left(self, theta: Any) -> Array:
        """The limit of F from below at ``theta``: differs from F(θ) only at breaks that jump."""
        return self._one_sided(self._lift, theta, -1, self.degree)

    def right(self, theta: Any) -> Array:
        """The limit of F from above at ``theta``."""
        return self._one_sided(self._lift, theta, 1, self.degree)

    def left_derivative(self, theta: Any) -> Array:
        """The limit of F' from below at ``theta``."""
        return self._one_sided(self.derivative, theta, -1, 0)

    def right_derivative(self, theta: Any) -> Array:
        """The limit of F' from above at ``theta``."""
        return self._one_sided(self.derivative, theta, 1, 0)

    def jumps(self) -> tuple[Array, Array, Array]:
        """(breaks where F jumps, its limits from the left, its limits from the right); kinks are left out."""
        left, right = self.left(self.breaks), self.right(self.breaks)
        jumping = np.abs(right - left) > JUMP
        return self.breaks[jumping], left[jumping], right[jumping]

    def scalar(self) -> Scalar:
        """F as a function of one python float: for loops that follow one orbit."""
        if self._scalar is not None:
            return self._scalar
        lift = self._lift
        return lambda theta: float(lift(np.asarray(theta)))

    # -- one-sided limits and differences ------------------------------------------------------------------

    def _distance_to_break(self, theta: Array) -> Array:
        if self.breaks.size == 0:
            return np.full(np.shape(theta), np.pi)
        gap = np.mod(theta[..., None] - self.breaks + np.pi, TWO_PI) - np.pi
        return np.asarray(np.min(np.abs(gap), axis=-1))

    def _one_sided(self, function: Lift, theta: Any, side: int, degree: int) -> Array:
        angles = np.asarray(theta, dtype=np.float64)
        values = np.array(function(angles), dtype=np.float64)
        for b in self.breaks:
            here = np.abs(np.mod(angles - b + np.pi, TWO_PI) - np.pi) <= SNAP
            if np.any(here):
                turns = np.round((angles[here] - b) / TWO_PI)
                at_break = self._beside(function, np.array([b]), side, degree)[0]
                values[here] = at_break + TWO_PI * degree * turns
        return values

    def _beside(self, function: Lift, breaks: Array, side: int, degree: int | None = None) -> Array:
        """Values a few rounding units beside ``breaks``, always read inside one period [0, 2π)."""
        climb = self.degree if degree is None else degree
        wraps = (side < 0) & (breaks < SIDE_STEP)
        points = np.where(wraps, breaks + TWO_PI, breaks) + side * SIDE_STEP
        return np.asarray(function(points), dtype=np.float64) - TWO_PI * climb * wraps

    def _differences(self, theta: Array) -> Array:
        """Five-point differences: centred, or leaning away from a break that is near."""
        if self.breaks.size == 0:
            return self._stencil(theta, np.full(theta.shape, _DIFFERENCE_STEP), 0)
        gaps = np.mod(self.breaks - theta[..., None], TWO_PI)
        above = np.min(np.where(gaps > 0.0, gaps, TWO_PI), axis=-1)
        below = np.min(np.mod(-gaps, TWO_PI), axis=-1)
        step = np.minimum(_DIFFERENCE_STEP, (above + below) / 8.1)
        slopes = self._stencil(theta, step, 0)
        slopes = np.where(above < 2.0 * step, self._stencil(theta, step, -1), slopes)
        return np.where(below < 2.0 * step, self._stencil(theta, step, 1), slopes)

    def _stencil(self, theta: Array, step: Array, lean: int) -> Array:
        offsets = _CENTRED if lean == 0 else lean * _ONE_SIDED
        weights = _CENTRED_WEIGHTS if lean == 0 else lean * _ONE_SIDED_WEIGHTS
        values = self._lift(theta[..., None] + step[..., None] * offsets)
        return np.asarray(values @ weights / step)

    # -- constructors --------------------------------------------------------------------------------------

    @classmethod
    def with_scalar(cls, lift: Lift, derivative: Lift | None, scalar: Scalar, **options: Any) -> CircleMap:
        """A map with a second form of its lift for one python float (faster in loops); both must agree."""
        made = cls(lift, derivative, **options)
        made._set(_scalar=scalar)
        return made

    @classmethod
    def rigid(cls, turns: float) -> CircleMap:
        """The rotation θ → θ + 2π·turns.

        >>> round(float(CircleMap.rigid(0.25)(0.0)), 6)
        1.570796
        """
        shift = TWO_PI * finite_number("turns", turns)
        return cls.with_scalar(lambda x: x + shift, np.ones_like, lambda x: x + shift)

    @classmethod
    def arnold(cls, omega: float, K: float) -> CircleMap:
        """The sine circle map θ → θ + 2πΩ - K sin θ, in turns x → x + Ω - (K/2π) sin 2πx (Arnold 1965).

        A diffeomorphism for |K| < 1, folded for |K| > 1.

        >>> float(CircleMap.arnold(0.0, 0.5).derivative(0.0))
        0.5
        """
        shift, strength = TWO_PI * finite_number("omega", omega), finite_number("K", K)
        return cls.with_scalar(
            lambda x: x + shift - strength * np.sin(x),
            lambda x: 1.0 - strength * np.cos(x),
            lambda x: x + shift - strength * sin(x),
        )

    @classmethod
    def moebius(cls, a: float, omega: float) -> CircleMap:
        """The Möbius map z → e^{2πiΩ}(z - a)/(1 - a z) of the unit circle, 0 ≤ a < 1.

        Its rotation number ρ is known: cos πρ = cos(πΩ)/√(1 - a²) where |sin πΩ| > a, else locked at 0.

        >>> round(float(CircleMap.moebius(0.5, 0.0).derivative(0.0)), 12)
        3.0
        """
        shift, r = TWO_PI * finite_number("omega", omega), finite_number("a", a)
        if not 0.0 <= r < 1.0:
            raise InvalidInput(f"a is {r:g}: a Möbius map of the circle needs 0 <= a < 1")
        return cls.with_scalar(
            lambda x: x + shift + 2.0 * np.arctan2(r * np.sin(x), 1.0 - r * np.cos(x)),
            lambda x: (1.0 - r * r) / (1.0 - 2.0 * r * np.cos(x) + r * r),
            lambda x: x + shift + 2.0 * atan2(r * sin(x), 1.0 - r * cos(x)),
        )

    @classmethod
    def from_samples(
        cls, theta: Any, lifted: Any, slopes: Any = None, *, degree: int = 1, max_error: float = 0.0
    ) -> CircleMap:
        """The piecewise cubic Hermite lift through samples (θ_i, F(θ_i)) of one turn.

        theta : shape (n,), radians, nondecreasing over [θ_0, θ_0 + 2π), with or without the end point.
            An angle given twice is a break: its first entry is the limit from the left, its second from
            the right; different values make a jump, equal values with different slopes a kink. An end
            point whose value is not F(θ_0) + 2π·degree makes a break at θ_0.
        lifted : shape (n,), radians, not wrapped.
        slopes : shape (n,), F' there; None takes shape-preserving slopes on each branch (Fritsch & Butland
            1984): monotone data give a monotone map. The error is O(h⁴) with slopes, O(h²) to O(h³) without.

        >>> import numpy as np
        >>> x = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        >>> sampled = CircleMap.from_samples(x, x + 0.3 * np.sin(x), 1 + 0.3 * np.cos(x))
        >>> bool(abs(sampled(1.0) - (1 + 0.3 * np.sin(1.0))) < 1e-9)
        True
        """
        whole = whole_number("degree", degree)
        cubic, breaks, count = cubic_from_samples(theta, lifted, slopes, whole)
        made = cls(cubic, cubic.derivative, breaks, whole, max_error=max_error)
        made._set(_scalar=cubic.scalar(), pieces=cubic, samples=count)
        return made
