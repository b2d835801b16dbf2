"""Families of circle maps: one formula for many parameters at once, and how lifts move with a
parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.checks import finite_array, finite_number, non_negative_number, read_only
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import carried_round
from cyclemap.progress import Progress, unheard

ParametricFunction = Callable[..., Array]
# Where a lift of unknown kind is looked at for folds.
_ANGLES = read_only(np.linspace(0.0, TWO_PI, 65))
_FALL = 1e-12  # radians: a smaller descent is rounding


@dataclass(frozen=True, eq=False)
class ParametricLift:
    """A family of degree-1 lifts F(θ; p₁, p₂, ...) by one formula; called with numbers it gives the
    CircleMap.

    Parameters
    ----------
    lift : callable
        ``lift(theta, *parameters)``, radians to radians, never wrapped; broadcasts over theta,
        shape (..., n), and parameters, each a number or of shape (n,). Several threads may call
        it at once.
    derivative : callable, optional
        The same for F'; None: differences.
    breaks : array_like, default ()
        Radians, the same for the whole family, where F jumps or F' does.
    nondecreasing : callable or None, optional
        ``nondecreasing(*parameters)``, a boolean array: where theory says that F never falls;
        None compares F at 65 angles instead, which sees only folds wider than that.
    circle_map : callable or None, optional
        Makes the member at given numbers where a faster form than the formula exists.
    max_error : float, default 0.0
        A bound on |lift - truth| in radians, as of ``CircleMap``.

    Raises
    ------
    InvalidInput
        For what is not callable; each member is checked like any CircleMap.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import ParametricLift
    >>> two_waves = ParametricLift(lambda x, shift, size: x + shift + size * np.sin(2 * x))
    >>> round(float(two_waves(0.5, 0.2).turn(np.pi / 4)), 12)
    0.7
    """

    lift: ParametricFunction
    derivative: ParametricFunction | None = None
    breaks: ArrayLike = ()
    nondecreasing: Callable[..., ArrayLike] | None = None
    circle_map: Callable[..., CircleMap] | None = None
    max_error: float = 0.0

    def __post_init__(self) -> None:
        if not callable(self.lift):
            raise InvalidInput(
                f"lift is {self.lift!r}: give a callable of an array of angles and the parameters"
            )
        for name in ("derivative", "nondecreasing", "circle_map"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise InvalidInput(f"{name} is {given!r}: give a callable or None")
        object.__setattr__(self, "breaks", read_only(finite_array("breaks", self.breaks, ndim=1)))
        object.__setattr__(self, "max_error", non_negative_number("max_error", self.max_error))

    def __call__(self, *parameters: float) -> CircleMap:
        """The member at these numbers."""
        values = [finite_number(f"parameter {i}", value) for i, value in enumerate(parameters)]
        if self.circle_map is not None:
            return self.circle_map(*values)
        slope = None if self.derivative is None else partial(_at, self.derivative, values)
        return CircleMap(
            partial(_at, self.lift, values), slope, self.breaks, max_error=self.max_error
        )

    def rises(self, *parameters: ArrayLike) -> Mask:
        """Where F never falls, by ``nondecreasing`` or at 65 angles; parameters of shape (n,) each,
        result (n,).
        """
        if self.nondecreasing is not None:
            size = np.broadcast_shapes(*(np.shape(p) for p in parameters))
            return np.broadcast_to(np.asarray(self.nondecreasing(*parameters), bool), size).copy()
        lower = formula_values("lift", self.lift, _ANGLES[:1], *parameters)
        rising = np.ones(np.shape(lower), dtype=bool)
        for theta in _ANGLES[1:]:
            upper = self.lift(np.array([theta]), *parameters)
            rising &= upper >= lower - _FALL
            lower = upper
        return rising


def _at(function: ParametricFunction, values: list[float], theta: Array) -> Array:
    return function(theta, *values)


def _sine_lift(theta: Array, omega: Array | float, K: Array | float) -> Array:
    image = K * np.sin(theta)
    np.subtract(theta, image, out=image)  # in place: the quickest of the ways to write it
    return image + TWO_PI * omega


ARNOLD_FAMILY = ParametricLift(
    _sine_lift,
    lambda theta, omega, K: 1.0 - K * np.cos(theta) + 0.0 * omega,
    nondecreasing=lambda omega, K: np.abs(K) <= 1.0 + 0.0 * omega,
    circle_map=CircleMap.arnold,
)
"""The sine family θ → θ + 2πΩ - K sin θ, parameters (Ω, K) as of ``CircleMap.arnold``."""

MOEBIUS_FAMILY = ParametricLift(
    lambda theta, a, omega: (
        theta + TWO_PI * omega + 2.0 * np.arctan2(a * np.sin(theta), 1.0 - a * np.cos(theta))
    ),
    lambda theta, a, omega: (1.0 - a * a) / (1.0 - 2.0 * a * np.cos(theta) + a * a) + 0.0 * omega,
    nondecreasing=lambda a, omega: (a >= 0.0) & (a < 1.0 + 0.0 * omega),
    circle_map=CircleMap.moebius,
)
"""The Möbius family z → e^{2πiΩ}(z - a)/(1 - a z), parameters as of ``CircleMap.moebius``."""


def parametric_form(family: Family) -> ParametricLift | None:
    """The formula for many parameters at once that a family is known by, or None."""
    if isinstance(family, ParametricLift):
        return family
    known = ARNOLD_FAMILY, MOEBIUS_FAMILY
    return next((formula for formula in known if formula.circle_map == family), None)


def formula_values(
    name: str, function: ParametricFunction, theta: Array, *parameters: ArrayLike
) -> Array:
    """What a family's formula gives at angles for many parameters at once, or InvalidInput where it
    fails or gives other than float64 of their shape.
    """
    shape = np.broadcast_shapes(theta.shape, *(np.shape(values) for values in parameters))
    try:
        values = np.asarray(function(theta, *parameters))
    except CycleMapError:
        raise
    except Exception as cause:
        raise InvalidInput(
            f"the {name} fails on many angles and parameters at once ({type(cause).__name__}: "
            f"{cause}): it must broadcast over both and leave them as they are; build it of numpy "
            "functions"
        ) from cause
    if values.dtype != np.float64 or values.shape != shape:
        raise InvalidInput(
            f"the {name} gives {values.dtype} of shape {values.shape} for float64 angles and "
            f"parameters of shape {shape}: it must broadcast and give real float64 numbers"
        )
    return values


def require_parameters(formula: ParametricLift, count: int) -> None:
    """Raise InvalidInput where the formula does not take so many parameters."""
    try:
        called = signature(formula.lift)
    except ValueError:  # of a compiled function
        return
    try:
        called.bind(_ANGLES, *range(count))
    except TypeError as cause:
        raise InvalidInput(
            f"{count} parameters are given, but the lift is called as {called}: give one for each "
            "after the angle"
        ) from cause


def broadcast_parameters(
    parameters: Sequence[ArrayLike],
) -> tuple[list[Array], tuple[int, ...], Array]:
    """Arrays of parameters, checked; the shape to which they broadcast; and all of them in it, of
    shape (k, m).
    """
    if not parameters:
        raise InvalidInput("parameters are missing: give an array for each parameter of the family")
    arrays = [finite_array(f"parameter {i}", values) for i, values in enumerate(parameters)]
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError as cause:
        shapes = " and ".join(str(array.shape) for array in arrays)
        raise InvalidInput(
            f"the parameters have shapes {shapes}: give arrays that broadcast, or of one shape"
        ) from cause
    return arrays, shape, np.array([np.broadcast_to(array, shape).ravel() for array in arrays])


Family = Callable[..., CircleMap]
Range = tuple[float, float]
Item = TypeVar("Item")
Result = TypeVar("Result")


def each_done(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    executor: Executor | None,
    progress: Progress | None,
    together: int = 1,
) -> Iterator[Result]:
    """The work on every item, in order: by this thread, or by an executor, ``together`` at a time.

    progress : called with the fraction done. What processes are to work on must be one that can be
        pickled.
    """
    report = progress or unheard
    results = executor.map(work, items, chunksize=together) if executor else map(work, items)
    for done, result in enumerate(results, start=1):
        report(done / len(items))
        yield result


def family_member(family: Family, *parameters: float) -> CircleMap:
    """The map of the family at these parameters; InvalidInput when it is not a CircleMap."""
    if not callable(family):
        raise InvalidInput(
            f"family is {family!r}: give a callable from the parameter to a CircleMap"
        )
    member = family(*parameters)
    if not isinstance(member, CircleMap):
        given = ", ".join(f"{value:.9g}" for value in parameters)
        raise InvalidInput(f"family({given}) is {member!r}: it must return a CircleMap")
    return member


def parameter_range(name: str, ends: Range) -> Range:
    """A range (low, high) of a parameter as two floats with low < high, or InvalidInput."""
    try:
        low, high = ends
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"{name} is {ends!r}: give a pair (low, high)") from cause
    first = finite_number(f"{name}[0]", low)
    last = finite_number(f"{name}[1]", high)
    if not first < last:
        raise InvalidInput(
            f"{name} is ({first:g}, {last:g}): its low end must lie below its high end"
        )
    return first, last


@dataclass(frozen=True, eq=False)
class ParameterTangent:
    """θ → ∂F/∂p at one parameter (radians a unit of p), 2π-periodic, any shape; from the right at
    breaks.

    member : the family's map at the parameter.
    members, weights, step : those of the difference, and its spacing.
    motions : how far the breaks of each of ``members`` have moved.
    break_rates : shape (breaks,), dθ_b/dp.
    """

    member: CircleMap
    members: tuple[CircleMap, ...]
    weights: tuple[float, ...]
    step: float
    motions: tuple[Array, ...]
    break_rates: Array

    def __call__(self, theta: ArrayLike) -> Array:
        """∂F/∂p at ``theta`` (radians)."""
        base = np.mod(np.asarray(theta, dtype=np.float64), TWO_PI)
        total = self._difference(CircleMap.right, base)
        carried = self._carried(base, self.break_rates)
        # The difference follows the breaks: dF/dp along them is ∂F/∂p + F' times their rate.
        return total - self.member.derivative(base, 1) * carried if np.any(carried) else total

    @property
    def error(self) -> float:
        """What the ``max_error`` of the maps may make of it, anywhere but beside jumps."""
        errors = [member.max_error for member in self.members]
        return float(np.abs(self.weights) @ errors) / self.step

    def of_slopes(self, theta: Array, bend: Array) -> Array:
        """∂F'/∂p at ``theta`` (radians) beside the breaks, where F'' is ``bend``."""
        base = np.mod(theta, TWO_PI)
        difference = self._difference(CircleMap.derivative, base)
        return difference - self._carried(base, self.break_rates) * bend

    def _difference(self, read: Callable[[CircleMap, Array], Array], base: Array) -> Array:
        """Of what is read of the maps at ``base`` (in [0, 2π)), carried along with the breaks."""
        total = np.zeros_like(base)
        for member, weight, motion in zip(self.members, self.weights, self.motions, strict=True):
            total += weight * read(member, base + self._carried(base, motion))
        return total / self.step

    def _carried(self, theta: Array, motion: Array) -> Array:
        """Displacements at ``theta`` (in [0, 2π)) that are linear between those of the breaks."""
        breaks = self.member.breaks
        if breaks.size == 0 or not np.any(motion):
            return np.zeros_like(theta)
        return np.interp(theta, carried_round(breaks), carried_round(motion, 0.0))


def parameter_tangent(family: Family, p: float, share: float, within: Range) -> ParameterTangent:
    """∂F/∂p of a family p → CircleMap, by differences of second order of its lifts in p, inside
    ``within``.

    share : of the range ``within``, the differences' spacing.

    Breaks may move with p: angles are carried along with the breaks on both sides, so that no
    difference reaches across one. Raises InvalidInput when neighbouring maps have different numbers
    of breaks.
    """
    below = p - within[0]
    above = within[1] - p
    step = share * (within[1] - within[0])
    offsets: tuple[int, ...] = (-1, 1)
    weights: tuple[float, ...] = (-0.5, 0.5)
    if min(below, above) < step:
        side = 1 if above >= below else -1
        offsets = (0, side, 2 * side)
        weights = (-1.5 * side, 2.0 * side, -0.5 * side)
        step = min(step, 0.5 * max(below, above))
    member = family_member(family, p)
    members = tuple(member if k == 0 else family_member(family, p + k * step) for k in offsets)
    motions = tuple(read_only(break_motion(member.breaks, other.breaks)) for other in members)
    rates = read_only(np.tensordot(weights, motions, 1) / step)
    return ParameterTangent(member, members, weights, step, motions, rates)


def parameter_inside(name: str, value: float, within: Range) -> float:
    """A parameter as a float inside the range, or InvalidInput."""
    p = finite_number(name, value)
    if not within[0] <= p <= within[1]:
        raise InvalidInput(
            f"{name} is {p:g}, outside the parameters ({within[0]:g}, {within[1]:g}): take one "
            "inside"
        )
    return p


def break_motion(breaks: Array, moved: Array) -> Array:
    """How far each break has moved (radians, the short way round) to its partner among ``moved``.

    Both sorted in [0, 2π); partners keep their order round the circle. InvalidInput when the counts
    differ.
    """
    if breaks.size != moved.size:
        raise InvalidInput(
            f"the family's maps have {breaks.size} and {moved.size} breaks at neighbouring "
            "parameters: their difference is not defined; take a smaller step or another parameter"
        )
    if breaks.size == 0:
        return np.zeros(0)
    motions = [shorter_way(np.roll(moved, k) - breaks) for k in range(breaks.size)]
    return min(motions, key=lambda motion: float(np.sum(np.abs(motion))))
