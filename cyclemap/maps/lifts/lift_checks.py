"""What a lift is: its types, what happens beside its breaks, and the checks that refuse what is no
lift.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.checks import float_array, unwritable, whole_number
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps.estimate import EPS, LIFT, STENCIL

Lift = Callable[[Array], Array]
Scalar = Callable[[float], float]
Index = npt.NDArray[np.intp]


class MadeLift(ABC):
    """A lift that is made of pieces or of other lifts, and knows the errors of its slopes."""

    has_scalar: bool = False
    """Whether one python float is quicker than an array: the lift has a form of its own for it."""

    @abstractmethod
    def __call__(self, theta: Array) -> Array:
        """The lift at ``theta`` (radians, any shape)."""

    @abstractmethod
    def derivative_and_error(self, theta: Array) -> tuple[Array, Array]:
        """Its slope, from the right where that jumps, and a bound on the slope's error."""

    def derivative(self, theta: Array) -> Array:
        """Its slope."""
        return self.derivative_and_error(theta)[0]

    def scalar(self) -> Scalar:
        """The same lift for one python float."""
        return lambda theta: float(self(np.asarray(theta)))


_LARGEST_DEGREE = 10**15  # turns beyond that leave no digit of an angle
SIDE_STEP = 8.0 * EPS * np.pi  # how far beside a break its one-sided limits are read
JUMP = 1e-10  # radians: one-sided limits that differ by more are a jump, else a kink
SNAP = 1e-12  # radians: angles this near a break are that break
_CENTRED = np.arange(-2.0, 3.0)
_ONE_SIDED = np.arange(0.0, 5.0)
_CENTRED_WEIGHTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
_ONE_SIDED_WEIGHTS = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
_DIFFERENCE_STEP = 1e-3
_AGREEING = 1e-8  # of 1 + |F'|: how far two differences may lie apart
_SHRINKINGS = 5  # of the step, each by four: rounding rules below a microradian


def within_turn(theta: Array) -> tuple[Array, Array]:
    """The angles less whole turns, in [0, 2π), and the turns that were taken off."""
    turns = np.floor(theta / TWO_PI)
    return theta - TWO_PI * turns, turns


def distance_to_break(breaks: Array, theta: Array) -> Array:
    """How far along the circle the nearest break lies, radians; π where there is none."""
    if breaks.size == 0:
        return np.full(np.shape(theta), np.pi)
    base, _ = within_turn(theta)
    return np.abs(nearest_on_circle(breaks, base)[0] - base)


def nearest_on_circle(nodes: Array, base: Array) -> tuple[Array, Index]:
    """The copy of a sorted node in [0, 2π), up to a turn away, nearest to each angle in [0, 2π];
    the node's index.
    """
    around = carried_round(nodes)
    pick = around.searchsorted(base).clip(1, nodes.size + 1)
    pick = pick - (base - around[pick - 1] <= around[pick] - base)
    return around[pick], (pick - 1) % nodes.size


def carried_round(nodes: Array, climb: float = TWO_PI) -> Array:
    """The nodes of one turn with the last of the turn before and the first of the next, ``climb``
    away.
    """
    return np.concatenate([nodes[-1:] - climb, nodes, nodes[:1] + climb])


def beside(function: Lift, breaks: Array, side: int, climb: int) -> Array:
    """Values a few rounding units beside ``breaks`` (in [0, 2π)), always read inside that one turn.

    ``climb`` says how many turns the function climbs in one turn of θ: the degree for a lift, 0 for
    F'.
    """
    wraps = (side < 0) & (breaks < SIDE_STEP)
    points = np.where(wraps, breaks + TWO_PI, breaks) + side * SIDE_STEP
    return function(points) - TWO_PI * climb * wraps


def one_sided_limit(
    function: Lift, breaks: Array, theta: ArrayLike, side: int, climb: int
) -> Array:
    """The function at ``theta``, and within ``SNAP`` of a break its limit there from below (-1) or
    above (1).
    """
    angles = float_array("theta", theta)
    values = np.array(function(angles), dtype=np.float64)
    if breaks.size == 0:
        return values
    base, _ = within_turn(angles)
    nearest, index = nearest_on_circle(breaks, base)
    here = np.abs(base - nearest) <= SNAP
    if here.any():
        met = breaks[index[here]]
        turns = np.round((angles[here] - met) / TWO_PI)
        values[here] = beside(function, met, side, climb) + TWO_PI * climb * turns
    return values


def with_rounding(slope: Array) -> tuple[Array, Array]:
    """A slope that was given, and a bound on its rounding."""
    return slope, LIFT * (1.0 + np.abs(slope))


def differences(function: Lift, breaks: Array, theta: Array) -> tuple[Array, Array]:
    """Five-point differences on the circle, centred or leaning away from a break that is near, and
    their errors.
    """
    if breaks.size == 0:
        far = np.full(theta.shape, np.pi)
        return differences_between(function, theta, far, far)
    gaps = np.mod(breaks - theta[..., None], TWO_PI)
    above = np.min(np.where(gaps > 0.0, gaps, TWO_PI), axis=-1)
    below = np.min(np.mod(-gaps, TWO_PI), axis=-1)
    return differences_between(function, theta, below, above)


def differences_between(
    function: Lift, theta: Array, below: Array, above: Array
) -> tuple[Array, Array]:
    """Five-point differences that reach less than ``below`` under each angle and ``above`` over it,
    and their errors.

    Where a difference of a quarter of the step differs by more than rounding, the function has
    features as narrow as the step, and the step shrinks until the two agree. The error is what is
    left between them, and rounding.
    """
    step = np.minimum(_DIFFERENCE_STEP, (above + below) / 8.1)
    slope = _five_points(function, theta, below, above, step)
    finer = _five_points(function, theta, below, above, step / 4.0)
    rough = np.abs(finer - slope) > _AGREEING * (1.0 + np.abs(slope))
    for _ in range(_SHRINKINGS):
        if not np.any(rough):
            break
        slope = np.where(rough, finer, slope)
        step = np.where(rough, step / 4.0, step)
        finer[rough] = _five_points(
            function, theta[rough], below[rough], above[rough], step[rough] / 4.0
        )
        rough &= np.abs(finer - slope) > _AGREEING * (1.0 + np.abs(slope))
    rounding = (
        STENCIL * (TWO_PI + np.abs(theta) * (1.0 + np.abs(slope)) + np.abs(function(theta))) / step
    )
    # The finer difference has 1/256 of the error of the other, or little less than all of it on a
    # rough stretch.
    return slope, 2.0 * np.abs(finer - slope) + rounding


def _five_points(function: Lift, theta: Array, below: Array, above: Array, step: Array) -> Array:
    low = below < 2.0 * step
    high = above < 2.0 * step
    lean = np.where(low, 1.0, np.where(high, -1.0, 0.0))[..., None]
    offsets = np.where(lean == 0.0, _CENTRED, lean * _ONE_SIDED)
    weights = np.where(lean == 0.0, _CENTRED_WEIGHTS, lean * _ONE_SIDED_WEIGHTS)
    values = function(theta[..., None] + step[..., None] * offsets)
    # The weights add up to zero: without their common part the values of a flat piece cancel
    # exactly.
    return np.asarray(np.sum((values - values[..., :1]) * weights, axis=-1) / step)


_SPREAD = np.linspace(-5.0, 6.0, 12) + 0.0137 * np.sqrt(np.arange(2.0, 14.0))
_TURN = 0.0731 + np.linspace(0.0, TWO_PI, 65)
# for reading only: a lift that writes to its argument fails on them
_POINTS = unwritable(np.concatenate([_SPREAD, _SPREAD + TWO_PI, _TURN]))
_TOLERANCE = 1e-8  # radians, and relative: F(θ + 2π) - F(θ) off by less is a lift
_SIDES = np.array([[-1.0], [1.0]])
_CLOSE = 1e-7  # radians: half the step of the difference that a derivative is compared with
_OTHER_SLOPE = 0.1  # of 1 + |F'|: a derivative that is off by more at most angles is another's
_HIDDEN_JUMP = np.pi  # radians: a larger step between neighbours is looked into


def base_angles(theta: Array) -> Array:
    """``theta`` mod 2π, in [0, 2π); a tiny negative angle is 0, never 2π."""
    base = np.mod(theta, TWO_PI)
    return np.where(base < TWO_PI, base, 0.0)


def checked_degree(degree: object) -> int:
    """A map's degree, or InvalidInput where it is no whole number, or no float tells its angles."""
    whole = whole_number("degree", degree)
    if abs(whole) > _LARGEST_DEGREE:
        raise InvalidInput("degree must lie within ±1e15: angles are lost to rounding beyond")
    return whole


def check_lift(lift: Lift, derivative: Lift | None, breaks: Array, degree: int) -> None:
    """Raise InvalidInput unless ``lift`` is, at 89 points and beside its breaks, a lift of that
    degree.

    Refused: callables that fail on arrays, write to them or do not act entry by entry, values that
    are not finite float64, F(θ + 2π) - F(θ) other than 2π·degree, a derivative that most
    differences contradict, and jumps of more than π that are not among the breaks (wrapped).
    """
    points = _POINTS
    if breaks.size:
        points = points.copy()
        points[:24] += 1e-3 * np.tile(distance_to_break(breaks, _SPREAD) < 1e-6, 2)
        unwritable(points)
    with np.errstate(all="ignore"):
        values = checked_call("lift", lift, points)
        slopes = (
            values[:0]
            if derivative is None
            else checked_call("derivative", derivative, points[:12])
        )
        allowed = _allowance(values[:24], slopes)
        climb = values[12:24] - values[:12]
        if np.max(np.abs(climb - TWO_PI * degree)) > allowed:
            _refuse_climb(points, climb, degree)
        # The same angles in another shape and company must give the same values.
        again = checked_call("lift", lift, points[:6].reshape(2, 3)).ravel()
        gap = np.abs(again - values[:6])
        if gap.max() > allowed:
            worst = int(np.argmax(gap))
            raise InvalidInput(
                f"the lift gives {values[worst]:.9g} or {again[worst]:.9g} at θ = "
                f"{points[worst]:.6g}, depending on the other entries: it must act entry by entry"
            )
        if not isinstance(lift, MadeLift):
            _refuse_other_slope(lift, points[: slopes.size], slopes)
        if breaks.size:
            for side in (-1, 1):
                checked_call("lift", partial(beside, lift, side=side, climb=degree), breaks)
        steps = np.abs(values[25:] - values[24:-1])
        if steps.max() > _HIDDEN_JUMP:
            _refuse_hidden_jump(lift, derivative, breaks, points[24:], steps)


def _refuse_other_slope(lift: Lift, points: Array, slopes: Array) -> None:
    """Raise InvalidInput where most slopes are nowhere near those of the lift: of another one, of
    another sign, in other units.
    """
    if slopes.size == 0:
        return
    below, above = checked_call("lift", lift, points + _CLOSE * _SIDES)
    measured = (above - below) / (2.0 * _CLOSE)
    unsure = EPS * (np.abs(points) + np.abs(below) + np.abs(above)) / _CLOSE
    off = np.abs(slopes - measured)
    wrong = off > (_OTHER_SLOPE + 4.0 * unsure) * (1.0 + np.abs(measured))
    if 2 * np.count_nonzero(wrong) > points.size:
        worst = int(np.argmax(np.where(wrong, off, 0.0)))
        raise InvalidInput(
            f"the derivative gives {slopes[worst]:.6g} at θ = {points[worst]:.6g}, where the lift "
            f"climbs by {measured[worst]:.6g} a radian: it is not that of this lift"
        )


def _refuse_climb(points: Array, climb: Array, degree: int) -> None:
    worst = int(np.argmax(np.abs(climb - TWO_PI * degree)))
    turns = np.round(climb / TWO_PI)
    fits = np.ptp(turns) == 0.0 and np.max(np.abs(climb - TWO_PI * turns)) <= _TOLERANCE
    hint = (
        f"that is degree {turns[0]:.0f}, if it is not wrapped"
        if fits
        else "give a lift that is not wrapped"
    )
    raise InvalidInput(
        f"not a lift of degree {degree}: F(θ + 2π) - F(θ) is {climb[worst]:.9g} "
        f"at θ = {points[worst]:.6g}, not {TWO_PI * degree:.9g}; {hint}"
    )


def check_scalar(scalar: Scalar, lift: Lift, derivative: Lift | None) -> None:
    """Raise InvalidInput unless the form for one python float gives what the lift gives at three
    points.
    """
    values = lift(_POINTS[:3])
    try:
        worst = max(
            abs(scalar(x) - y) for x, y in zip(_POINTS[:3].tolist(), values.tolist(), strict=True)
        )
    except Exception as cause:
        raise InvalidInput(
            f"the scalar form fails ({type(cause).__name__}: {cause}): it must turn one float into "
            "one"
        ) from cause
    slopes = values[:0] if derivative is None else derivative(_POINTS[:12])
    if not worst <= _allowance(values, slopes):
        raise InvalidInput(
            f"the scalar form differs from the lift by {worst:.3g}: both must be one function"
        )


def checked_call(name: str, function: Lift, points: Array) -> Array:
    """The callable's values at ``points``, refused by name unless they are finite float64, entry by
    entry.
    """
    values = _called(name, function, points)
    kind = getattr(values, "dtype", type(values).__name__)
    if kind != np.float64:
        raise InvalidInput(
            f"the {name} gives {kind} for float64 angles: it must give real float64 numbers"
        )
    if values.shape != points.shape:
        raise InvalidInput(
            f"the {name} turns shape {points.shape} into {values.shape}: it must act entry by entry"
        )
    _refuse_values(name, points, values, ~np.isfinite(values))
    return values


def _called(name: str, function: Lift, theta: Array) -> Array:
    """What the callable gives, or InvalidInput that says where it fails."""
    try:
        return function(theta)
    except CycleMapError:
        raise
    except Exception as cause:
        raise InvalidInput(_failure(name, function, theta, cause)) from cause


def _refuse_values(name: str, theta: Array, values: Array, wrong: Mask) -> None:
    if wrong.any():
        place = int(np.argmax(wrong))
        raise InvalidInput(
            f"the {name} gives {np.ravel(values)[place]} at θ = {np.ravel(theta)[place]:.9g}: "
            "it must be finite everywhere"
        )


def _failure(name: str, function: Lift, points: Array, cause: Exception) -> str:
    """Name the first angle at which the callable fails by itself; if it fails at none it is not
    vectorised.
    """
    for theta in np.ravel(points):
        raised = []
        for single in (np.asarray(theta), np.array([theta])):
            try:
                function(single)
            except Exception as error:
                raised.append(f"{type(error).__name__}: {error}")
        if len(raised) == 2:
            return (
                f"the {name} fails at θ = {theta:.9g} ({raised[0]}): it must be defined everywhere"
            )
    return (
        f"the {name} fails on an array of shape {points.shape} ({cause}): it must be vectorised "
        "and leave its argument as it is; build it of numpy functions, or wrap it in np.vectorize"
    )


def guarded(name: str, function: Lift, finite: bool) -> Lift:
    """The callable, which says at which angle it fails or gives nan (or ±inf, where values must be
    ``finite``).
    """
    bad = (lambda values: ~np.isfinite(values)) if finite else np.isnan

    def call(theta: Array) -> Array:
        values = _called(name, function, theta)
        _refuse_values(name, theta, values, bad(values))
        return values

    return call


def _allowance(values: Array, slopes: Array) -> float:
    """What rounding may do: steep maps, such as high iterates, magnify the rounding of θ + 2π."""
    steepest = float(np.max(np.abs(slopes))) if slopes.size else 0.0
    return _TOLERANCE * (1.0 + float(np.max(np.abs(values)))) + 1e-13 * steepest


def _refuse_hidden_jump(
    lift: Lift, derivative: Lift | None, breaks: Array, points: Array, steps: Array
) -> None:
    """Close in on the largest step that spans no break: a steep piece flattens, a jump stays."""
    lap = np.searchsorted(np.concatenate([breaks, breaks + TWO_PI]), points)
    free = np.where(np.diff(lap) == 0, steps, 0.0)
    worst = int(np.argmax(free))
    low, high = points[worst : worst + 2]
    step = free[worst]
    while step > _HIDDEN_JUMP and high - low > 1e-13:
        middle = 0.5 * (low + high)
        before, after = np.abs(np.diff(lift(np.array([low, middle, high]))))
        low, high = (low, middle) if before >= after else (middle, high)
        step = max(before, after)
    ends = np.array([low, high])
    steepest = 0.0 if derivative is None else float(np.max(np.abs(derivative(ends))))
    if step > _HIDDEN_JUMP + 8.0 * steepest * (high - low):
        raise InvalidInput(
            f"the lift jumps by {step:.6g} at θ = {low:.9g}, which is none of its breaks: "
            "if it is wrapped there give the unwrapped lift, else name the break"
        )
