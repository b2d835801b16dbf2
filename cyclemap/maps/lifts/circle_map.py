"""CircleMap: a lift θ → F(θ) with F(θ + 2π) = F(θ) + 2π·degree, smooth between its breaks."""

from __future__ import annotations

import pickle
from cmath import phase
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import atan2, cos, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import (
    finite_array,
    finite_number,
    float_array,
    non_negative_number,
    read_only,
)
from cyclemap.errors import InvalidInput
from cyclemap.inline_svg import inline_svg, map_strokes
from cyclemap.maps.lifts.lift_checks import (
    JUMP,
    Lift,
    MadeLift,
    Scalar,
    base_angles,
    check_lift,
    check_scalar,
    checked_degree,
    differences,
    guarded,
    one_sided_limit,
    with_rounding,
)
from cyclemap.maps.lifts.piecewise_lifts import (
    PiecewiseCubic,
    cubic_from_samples,
    lift_from_branches,
)

# a call that makes the map again
Recipe = tuple[Callable[..., "CircleMap"], tuple[Any, ...], dict[str, Any]]

Angles = Any  # a float, or an array of them
Wave = Callable[..., Angles]


@dataclass(frozen=True, init=False, eq=False, repr=False)
class CircleMap(MadeLift):
    """A map of the circle given by its lift, an ordinary function of the real line.

    Parameters
    ----------
    lift : callable
        Radians to radians, F(θ + 2π) = F(θ) + 2π·degree; never wrapped. It takes float64 arrays
        of any shape and gives float64 entry by entry.
    derivative : callable, optional
        Such a callable for F'; None: differences of fourth order that never reach across a
        break, about 1e-11 off in [-2π, 2π] where F is smooth; ``derivative_and_error`` tells.
    breaks : array_like, default ()
        Angles (radians, any order, any turn) where F jumps or F' does; kept sorted, in [0, 2π).
        F is taken to be continuous from the right there: ``F(b)`` should be the limit from above.
    degree : int, default 1
        How often the image runs round while θ runs round once; any whole number.
    max_error : float, default 0.0
        A bound on |lift - truth| in radians that the maker of the map claims; 0 for an exact
        map.

    Attributes
    ----------
    samples : int
        Number of sample points; 0 for a map given by formulas.
    formula : callable
        The lift as it was given.

    Raises
    ------
    InvalidInput
        When the lift is not a lift of that degree, jumps by more than π where no break is given
        (a wrapped lift does), is not finite, not float64 or not vectorised, writes to its
        argument, or the derivative is another lift's. Checked at 89 points and beside the
        breaks, in about 0.1 ms: faults between those points pass.

    Notes
    -----
    The value never changes after construction.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap
    >>> tilted = CircleMap(lambda x: x + 0.5 + 0.3 * np.cos(x), lambda x: 1 - 0.3 * np.sin(x))
    >>> round(float(tilted.turn(0.0)), 12)
    0.8
    """

    breaks: Array
    degree: int
    max_error: float
    samples: int
    formula: Lift
    has_scalar: bool
    _made: MadeLift | None
    _lift: Lift
    _derivative: Lift | None
    _scalar: Scalar | None
    _recipe: Recipe

    def __init__(
        self,
        lift: Lift,
        derivative: Lift | None = None,
        breaks: ArrayLike = (),
        degree: int = 1,
        *,
        max_error: float = 0.0,
    ) -> None:
        if not callable(lift) or (derivative is not None and not callable(derivative)):
            raise InvalidInput(
                f"lift is {lift!r}: lift and derivative must be callables of an array of angles"
            )
        own_breaks = read_only(np.unique(base_angles(finite_array("breaks", breaks, ndim=1))))
        made = lift if derivative is None and isinstance(lift, MadeLift) else None
        slope = derivative if made is None else made.derivative
        scalar = made.scalar() if made is not None and made.has_scalar else None
        self._set(
            breaks=own_breaks,
            degree=checked_degree(degree),
            max_error=non_negative_number("max_error", max_error),
            samples=0,
            formula=lift,
            _made=made,
            _lift=guarded("lift", lift, True),
            _derivative=None if slope is None else guarded("derivative", slope, False),
            _scalar=scalar,
            has_scalar=scalar is not None,
            _recipe=(CircleMap, (lift, derivative, own_breaks, degree), {"max_error": max_error}),
        )
        check_lift(lift, slope, self.breaks, self.degree)

    def _set(self, **fields: object) -> None:
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    def remade_by(
        self, maker: Callable[..., CircleMap], *arguments: Any, **options: Any
    ) -> CircleMap:
        """The map itself, which pickles as this call that makes it: what its own lift is made of
        may not pickle.
        """
        self._set(_recipe=(maker, arguments, options))
        return self

    def __reduce__(self) -> tuple[Callable[..., CircleMap], tuple[Recipe]]:
        _, arguments, options = self._recipe
        for given in (*arguments, *options.values()):
            if callable(given) and not isinstance(given, MadeLift):
                try:
                    pickle.dumps(given)
                except Exception as cause:
                    raise InvalidInput(
                        f"the map cannot be pickled, as {given!r} cannot: make it of functions "
                        "that are defined by def at the top of a module (or sample it: "
                        "CircleMap.from_samples)"
                    ) from cause
        return _remade, (self._recipe,)

    def __copy__(self) -> CircleMap:
        return self

    def __deepcopy__(self, _: object) -> CircleMap:
        return self

    def __repr__(self) -> str:
        return f"CircleMap(degree={self.degree}, samples={self.samples}, breaks={self.breaks.size})"

    def _repr_html_(self) -> str:
        theta = np.linspace(0.0, TWO_PI, 361)
        caption = f"{self!r}: turn of a cycle (rad) over θ from 0 to 2π"
        return inline_svg(map_strokes(theta, self.turn(theta), self.breaks), caption)

    def __call__(self, theta: ArrayLike) -> Array:
        """The lift F(θ); ``theta`` in radians, any shape, any real numbers."""
        return self._lift(float_array("theta", theta))

    def turn(self, theta: ArrayLike) -> Array:
        """F(θ) - θ, radians: how far one cycle turns."""
        angles = float_array("theta", theta)
        return self._lift(angles) - angles

    def derivative(self, theta: ArrayLike, side: int = 0) -> Array:
        """F'(θ); at a break the derivative from the right, with ``side`` -1 or 1 its limit from
        below or above.
        """
        if side not in (-1, 0, 1):
            raise InvalidInput(f"side is {side!r}: give -1, 0 or 1")
        if side:
            return one_sided_limit(self.derivative, self.breaks, theta, side, 0)
        angles = float_array("theta", theta)
        if self._derivative is not None:
            return self._derivative(angles)
        return differences(self._lift, self.breaks, angles)[0]

    def derivative_and_error(self, theta: ArrayLike) -> tuple[Array, Array]:
        """F'(θ) and a bound on its error: rounding; where no derivative was given, the measured one
        of differences.

        Maps made of maps, or of branches, carry the errors of what they are made of.
        """
        angles = float_array("theta", theta)
        if self._made is not None:
            return self._made.derivative_and_error(angles)
        if self._derivative is None:
            return differences(self._lift, self.breaks, angles)
        return with_rounding(self._derivative(angles))

    def left(self, theta: ArrayLike) -> Array:
        """The limit of F from below at ``theta``: differs from F(θ) only at breaks that jump."""
        return one_sided_limit(self._lift, self.breaks, theta, -1, self.degree)

    def right(self, theta: ArrayLike) -> Array:
        """The limit of F from above at ``theta``."""
        return one_sided_limit(self._lift, self.breaks, theta, 1, self.degree)

    def jumps(self) -> tuple[Array, Array, Array]:
        """(breaks where F jumps, its limits from the left, its limits from the right); kinks are
        left out.
        """
        left = self.left(self.breaks)
        right = self.right(self.breaks)
        jumping = np.abs(right - left) > JUMP
        return self.breaks[jumping], left[jumping], right[jumping]

    @property
    def pieces(self) -> PiecewiseCubic | None:
        """The cubics of a sampled map, None of any other."""
        return self.formula if isinstance(self.formula, PiecewiseCubic) else None

    def scalar(self) -> Scalar:
        """F as a function of one python float: for loops that follow one orbit."""
        return super().scalar() if self._scalar is None else self._scalar

    @classmethod
    def with_scalar(
        cls, lift: Lift, derivative: Lift | None, scalar: Scalar, **options: Any
    ) -> CircleMap:
        """A map with a second form of its lift for one python float (faster in loops); both must
        agree.
        """
        made = cls(lift, derivative, **options)
        check_scalar(scalar, lift, derivative)
        made._set(_scalar=scalar, has_scalar=True)
        # The caller's own array may change: the map's copy does not.
        own = {"breaks": made.breaks} if "breaks" in options else {}
        return made.remade_by(cls.with_scalar, lift, derivative, scalar, **{**options, **own})

    @classmethod
    def rigid(cls, turns: float) -> CircleMap:
        """The rotation θ → θ + 2π·turns.

        >>> from cyclemap import CircleMap
        >>> round(float(CircleMap.rigid(0.25)(0.0)), 6)
        1.570796
        """
        shift = TWO_PI * finite_number("turns", turns)
        return cls.with_scalar(lambda x: x + shift, np.ones_like, lambda x: x + shift).remade_by(
            cls.rigid, turns
        )

    @classmethod
    def arnold(cls, omega: float, K: float) -> CircleMap:
        """The sine circle map θ → θ + 2πΩ - K sin θ, in turns x → x + Ω - (K/2π) sin 2πx.

        Parameters
        ----------
        omega : float
            Ω, turns.
        K : float
            A diffeomorphism for |K| < 1, folded for |K| > 1.

        Returns
        -------
        CircleMap
            Of degree 1, with its exact derivative.

        References
        ----------
        Arnold, V. I. (1965), Small denominators I, AMS Translations 46.

        Examples
        --------
        >>> from cyclemap import CircleMap
        >>> float(CircleMap.arnold(0.0, 0.5).derivative(0.0))
        0.5
        """
        shift = TWO_PI * finite_number("omega", omega)
        strength = finite_number("K", K)
        return cls.with_scalar(
            lambda x: x + shift - strength * np.sin(x),
            lambda x: 1.0 - strength * np.cos(x),
            lambda x: x + shift - strength * sin(x),
        ).remade_by(cls.arnold, omega, K)

    @classmethod
    def moebius(cls, a: float, omega: float) -> CircleMap:
        """The Möbius map z → e^{2πiΩ}(z - a)/(1 - a z) of the unit circle.

        Parameters
        ----------
        a : float
            0 ≤ a < 1.
        omega : float
            Ω, turns.

        Returns
        -------
        CircleMap
            Its rotation number ρ is known: cos πρ = cos(πΩ)/√(1 - a²) where |sin πΩ| > a, else
            locked at 0.

        Examples
        --------
        >>> from cyclemap import CircleMap
        >>> round(float(CircleMap.moebius(0.5, 0.0).derivative(0.0)), 12)
        3.0
        """
        r = finite_number("a", a)
        if not 0.0 <= r < 1.0:
            raise InvalidInput(
                f"a is {r:g}: a Möbius map of the circle needs 0 <= a < 1; blaschke takes any "
                "|a| < 1"
            )
        return cls.blaschke([r], omega)

    @classmethod
    def blaschke(cls, zeros: ArrayLike, omega: float = 0.0) -> CircleMap:
        """The finite Blaschke product z → e^{2πiΩ} Π (z - a)/(1 - conj(a) z).

        Parameters
        ----------
        zeros : array_like of complex
            One number a with |a| < 1 or more; zeros at the origin give θ → kθ + 2πΩ.
        omega : float, default 0.0
            Ω, turns.

        Returns
        -------
        CircleMap
            Its degree is the number of zeros.

        Notes
        -----
        The derivative is the sum of the Poisson kernels (1 - |a|²)/|z - a|²; the map expands, F' >
        1, when a zero lies at the origin and there are two or more, or Σ (1 - |a|)/(1 + |a|) > 1
        (Shub & Sullivan 1985).

        References
        ----------
        Shub, M. & Sullivan, D. (1985), Expanding endomorphisms of the circle revisited, Ergodic
        Theory and Dynamical Systems 5.

        Examples
        --------
        >>> from cyclemap import CircleMap
        >>> float(CircleMap.blaschke([0, 0])(1.25)), CircleMap.blaschke([0.5, 0.3j, -0.2]).degree
        (2.5, 3)
        """
        try:
            given = np.asarray(zeros, dtype=np.complex128)
        except (TypeError, ValueError) as cause:
            raise InvalidInput(f"zeros must hold complex numbers only, not {zeros!r}") from cause
        if given.ndim != 1 or given.size == 0:
            raise InvalidInput(
                f"zeros has shape {given.shape}: give a list of one complex number or more"
            )
        outside = ~(np.abs(given) < 1.0)
        if np.any(outside):
            entry = int(np.argmax(outside))
            raise InvalidInput(
                f"zeros[{entry}] is {given[entry]:g}: every zero must lie inside the unit "
                "circle, |a| < 1"
            )
        checked = tuple(complex(a) for a in given)
        forms = _blaschke_forms(checked, TWO_PI * finite_number("omega", omega))
        return cls.with_scalar(*forms, degree=len(checked)).remade_by(cls.blaschke, checked, omega)

    @classmethod
    def from_branches(cls, branches: Any, *, degree: int = 1, max_error: float = 0.0) -> CircleMap:
        """The lift made of branches, each a function on its own interval.

        Parameters
        ----------
        branches : sequence of tuple
            (start, end, lift, derivative) in order, radians, start < end, each starting where
            the one before ends (to 1e-12), together one turn. Lifts and derivatives are
            callables as for ``CircleMap``, called on their own [start, end] only; derivative
            None takes differences inside that interval.
        degree : int, default 1
            Any whole number; with it the last end meets the first start, with or without a
            jump.
        max_error : float, default 0.0
            As of ``CircleMap``.

        Returns
        -------
        CircleMap
            At a seam it takes the value of the branch that starts there.

        Notes
        -----
        Breaks are the seams where the values differ (relative 1e-12) or the slopes do (relative
        1e-9; 1e-6 by differences).

        Examples
        --------
        >>> import numpy as np
        >>> from cyclemap import CircleMap
        >>> rising = (0, np.pi, lambda x: 2 * x, None)
        >>> falling = (np.pi, 2 * np.pi, lambda x: 4 * np.pi - 2 * x, None)
        >>> tent = CircleMap.from_branches([rising, falling], degree=0)
        >>> tent.breaks.round(6).tolist(), round(float(tent(2 * np.pi + 0.5)), 12)
        ([0.0, 3.141593], 1.0)
        """
        whole = checked_degree(degree)
        given = list(branches) if isinstance(branches, Iterable) else branches
        lift, breaks = lift_from_branches(given, whole)
        return cls(lift, None, breaks, whole, max_error=max_error)

    @classmethod
    def from_samples(
        cls,
        theta: ArrayLike,
        lifted: ArrayLike,
        slopes: ArrayLike | None = None,
        *,
        degree: int = 1,
        max_error: float = 0.0,
    ) -> CircleMap:
        """The piecewise cubic Hermite lift through samples (θ_i, F(θ_i)) of one turn.

        Parameters
        ----------
        theta : array_like, shape (n,)
            Radians, nondecreasing over [θ_0, θ_0 + 2π), with or without the end point. An angle
            given twice is a break: first its limit from the left, then from the right;
            different values make a jump, equal values with different slopes a kink. An end
            point whose value is not F(θ_0) + 2π·degree makes a break at θ_0.
        lifted : array_like, shape (n,)
            F there, radians, not wrapped.
        slopes : array_like, shape (n,), optional
            F' there; None takes shape-preserving slopes on each branch (Fritsch & Butland
            1984): monotone data give a monotone map.
        degree : int, default 1
            Any whole number.
        max_error : float, default 0.0
            As of ``CircleMap``.

        Returns
        -------
        CircleMap
            The error is O(h⁴) with slopes, O(h²) to O(h³) without.

        References
        ----------
        Fritsch, F. N. & Butland, J. (1984), A method for constructing local monotone piecewise
        cubic interpolants, SIAM Journal on Scientific and Statistical Computing 5.

        Examples
        --------
        >>> import numpy as np
        >>> from cyclemap import CircleMap
        >>> x = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        >>> sampled = CircleMap.from_samples(x, x + 0.3 * np.sin(x), 1 + 0.3 * np.cos(x))
        >>> bool(abs(sampled(1.0) - (1 + 0.3 * np.sin(1.0))) < 1e-9)
        True
        """
        whole = checked_degree(degree)
        cubic, breaks = cubic_from_samples(theta, lifted, slopes, whole)
        return cls.from_pieces(cubic, breaks, np.size(theta), max_error)

    @classmethod
    def from_pieces(
        cls, pieces: PiecewiseCubic, breaks: ArrayLike, samples: int, max_error: float = 0.0
    ) -> CircleMap:
        """The map whose lift is a piecewise cubic that is already there; ``samples`` is kept for
        the record.
        """
        made = cls(pieces, None, breaks, pieces.degree, max_error=max_error)
        made._set(samples=samples)
        return made.remade_by(cls.from_pieces, pieces, made.breaks, samples, max_error)


def require_map(circle_map: CircleMap) -> None:
    """InvalidInput for anything else."""
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")


def require_degree_one(circle_map: CircleMap, what: str) -> None:
    """InvalidInput for a map of another degree, for which ``what`` is asked has no meaning."""
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: {what} needs degree 1")


def _remade(recipe: Recipe) -> CircleMap:
    maker, arguments, options = recipe
    return maker(*arguments, **options)


def _blaschke_forms(zeros: tuple[complex, ...], shift: float) -> tuple[Lift, Lift, Scalar]:
    """Lift, derivative and form for one float: each factor turns z by a further -2 arg(1 - conj(a)
    z).

    That argument stays inside (-π/2, π/2), so the lift is kθ plus a smooth periodic part. Half
    angles keep all digits where a zero is close to the circle; one at the origin is a factor z,
    which only adds θ.
    """
    turning = [(abs(a), phase(a)) for a in zeros if a != 0.0]
    k = float(len(zeros))
    plain = float(len(zeros) - len(turning))
    # 1 - r cos φ = (1 - r) + 2r sin²(φ/2), and r sin φ = 2r sin(φ/2) cos(φ/2).
    rows = [(0.5 * angle, 2.0 * r, 1.0 - r, (1.0 - r) * (1.0 + r)) for r, angle in turning]

    def turned(x: Angles, sin: Wave, cos: Wave, arctan2: Wave) -> Angles:
        value = k * x + shift
        for half, double, gap, _ in rows:
            s = sin(0.5 * x - half)
            value = value + 2.0 * arctan2(double * s * cos(0.5 * x - half), gap + double * s * s)
        return value

    def derivative(x: Array) -> Array:
        slope = np.full_like(x, plain)
        for half, double, gap, top in rows:
            s = np.sin(0.5 * x - half)
            slope = slope + top / (gap * gap + 2.0 * double * s * s)
        return slope

    return (
        lambda x: turned(x, np.sin, np.cos, np.arctan2),
        derivative,
        lambda x: turned(x, sin, cos, atan2),
    )
