"""What a lift is: its types, whole turns taken off an angle, and the checks that refuse what is no lift."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.one_sided import beside, distance_to_break

Lift = Callable[[Array], Array]
Scalar = Callable[[float], float]

_SPREAD = np.linspace(-5.0, 6.0, 12) + 0.0137 * np.sqrt(np.arange(2.0, 14.0))
_TURN = 0.0731 + np.linspace(0.0, TWO_PI, 65)
_POINTS = np.concatenate([_SPREAD, _SPREAD + TWO_PI, _TURN])
_TOLERANCE = 1e-8  # radians, and relative: F(θ + 2π) - F(θ) off by less is a lift
_HIDDEN_JUMP = np.pi  # radians: a larger step between neighbours is looked into
_SECTIONS = np.arange(65.0) / 64.0


def base_angles(theta: Array) -> Array:
    """``theta`` mod 2π, in [0, 2π); a tiny negative angle is 0, never 2π."""
    base = np.mod(theta, TWO_PI)
    return np.asarray(np.where(base < TWO_PI, base, 0.0))


def check_lift(lift: Lift, derivative: Lift | None, breaks: Array, degree: int) -> None:
    """Raise InvalidInput unless ``lift`` is, at 89 points and beside its breaks, a lift of that degree.

    Refused: callables that fail on arrays or do not act entry by entry, values that are not finite float64,
    F(θ + 2π) - F(θ) other than 2π·degree, and jumps of more than π that are not among the breaks (wrapped).
    """
    points = _POINTS
    if breaks.size:
        points = points.copy()
        points[:24] += 1e-3 * np.tile(distance_to_break(breaks, _SPREAD) < 1e-6, 2)
    with np.errstate(all="ignore"):
        values = checked_call("lift", lift, points)
        slopes = values[:0] if derivative is None else checked_call("derivative", derivative, points[:12])
        _check_turn(points, values, slopes, degree)
        _check_entry_by_entry(lift, points, values, slopes)
        if breaks.size:
            checked_call("lift", lambda theta: beside(lift, theta, -1, degree), breaks)
            checked_call("lift", lambda theta: beside(lift, theta, 1, degree), breaks)
        steps = np.abs(values[25:] - values[24:-1])
        if steps.max() > _HIDDEN_JUMP:
            _refuse_hidden_jump(lift, derivative, breaks, points[24:], steps)


def check_scalar(scalar: Scalar, lift: Lift, derivative: Lift | None) -> None:
    """Raise InvalidInput unless the form for one python float gives what the lift gives at three points."""
    values = lift(_POINTS[:3])
    worst = max(abs(scalar(x) - y) for x, y in zip(_POINTS[:3].tolist(), values.tolist(), strict=True))
    if worst <= _TOLERANCE:
        return
    slopes = values[:0] if derivative is None else derivative(_POINTS[:12])
    if not worst <= _allowance(values, slopes):
        raise InvalidInput(f"the scalar form differs from the lift by {worst:.3g}: both must be one function")


def checked_call(name: str, function: Lift, points: Array) -> Array:
    """The callable's values at ``points``, refused by name unless they are finite float64, entry by entry.

    >>> checked_call("lift", np.sin, np.zeros(2)).tolist()
    [0.0, 0.0]
    """
    try:
        values = function(points)
    except CycleMapError:
        raise
    except Exception as cause:
        raise InvalidInput(_failure(name, function, points, cause)) from cause
    if getattr(values, "dtype", None) != np.float64:
        kind = getattr(values, "dtype", type(values).__name__)
        raise InvalidInput(f"the {name} gives {kind} for float64 angles: it must give real float64 numbers")
    if values.shape != points.shape:
        raise InvalidInput(f"the {name} turns shape {points.shape} into {values.shape}: it must act entry by entry")
    if not np.isfinite(values).all():
        worst = int(np.argmin(np.isfinite(values)))
        raise InvalidInput(
            f"the {name} gives {values.ravel()[worst]} at θ = {points.ravel()[worst]:.6g}: it must be finite everywhere"
        )
    return values


def _failure(name: str, function: Lift, points: Array, cause: Exception) -> str:
    """Name the first angle at which the callable fails by itself; if it fails at none it is not vectorised."""
    for theta in np.ravel(points):
        kinds = [_raised(function, one) for one in (np.asarray(theta), np.array([theta]))]
        if all(kinds):
            return f"the {name} fails at θ = {theta:.9g} ({kinds[0]}): it must be defined everywhere"
    return (
        f"the {name} fails on an array of shape {points.shape} ({cause}): it must be vectorised; "
        "build it of numpy functions, or wrap it in np.vectorize"
    )


def _raised(function: Lift, theta: Array) -> str:
    try:
        function(theta)
    except Exception as cause:
        return f"{type(cause).__name__}: {cause}"
    return ""


def guarded(name: str, function: Lift, finite: bool) -> Lift:
    """The callable, which says at which angle it fails or gives nan (or ±inf, where values must be ``finite``).

    >>> guarded("lift", np.sqrt, True)(np.array([4.0])).tolist()
    [2.0]
    """
    bad = _not_finite if finite else np.isnan

    def call(theta: Array) -> Array:
        try:
            values = function(theta)
        except CycleMapError:
            raise
        except Exception as cause:
            raise InvalidInput(_failure(name, function, theta, cause)) from cause
        wrong = bad(values)
        if wrong.any():
            place = int(np.argmax(wrong))
            raise InvalidInput(
                f"the {name} gives {np.ravel(values)[place]} at θ = {np.ravel(theta)[place]:.9g}: "
                "it must be finite everywhere"
            )
        return values

    return call


def _not_finite(values: Array) -> Any:
    return ~np.isfinite(values)


def _allowance(values: Array, slopes: Array) -> float:
    """What rounding may do: steep maps, such as high iterates, magnify the rounding of θ + 2π."""
    steepest = float(np.max(np.abs(slopes))) if slopes.size else 0.0
    return _TOLERANCE * (1.0 + float(np.max(np.abs(values)))) + 1e-13 * steepest


def _check_turn(points: Array, values: Array, slopes: Array, degree: int) -> None:
    climb = values[12:24] - values[:12]
    gap = np.abs(climb - TWO_PI * degree)
    if gap.max() > _TOLERANCE and gap.max() > _allowance(values[:24], slopes):
        worst = int(np.argmax(gap))
        turns = np.round(climb / TWO_PI)
        fits = np.ptp(turns) == 0.0 and np.max(np.abs(climb - TWO_PI * turns)) <= _TOLERANCE
        hint = f"that is degree {turns[0]:.0f}, if it is not wrapped" if fits else "give a lift that is not wrapped"
        raise InvalidInput(
            f"not a lift of degree {degree}: F(θ + 2π) - F(θ) is {climb[worst]:.9g} "
            f"at θ = {points[worst]:.6g}, not {TWO_PI * degree:.9g}; {hint}"
        )


def _check_entry_by_entry(lift: Lift, points: Array, values: Array, slopes: Array) -> None:
    """The same angles in another shape and company must give the same values."""
    again = checked_call("lift", lift, points[:6].reshape(2, 3)).ravel()
    gap = np.abs(again - values[:6])
    if gap.max() > _TOLERANCE and gap.max() > _allowance(values[:24], slopes):
        worst = int(np.argmax(gap))
        raise InvalidInput(
            f"the lift gives {values[worst]:.9g} or {again[worst]:.9g} at θ = {points[worst]:.6g}, "
            "depending on the other entries: it must act entry by entry"
        )


def _refuse_hidden_jump(lift: Lift, derivative: Lift | None, breaks: Array, points: Array, steps: Array) -> None:
    """Close in on the largest step that spans no break: a steep piece flattens, a jump stays."""
    lap = np.searchsorted(np.concatenate([breaks, breaks + TWO_PI]), points)
    free = np.where(np.diff(lap) == 0, steps, 0.0)
    worst = int(np.argmax(free))
    low, high, step = points[worst], points[worst + 1], free[worst]
    while step > _HIDDEN_JUMP and high - low > 1e-13:
        sections = low + (high - low) * _SECTIONS
        steps = np.abs(np.diff(lift(sections)))
        worst = int(np.argmax(steps))
        low, high, step = sections[worst], sections[worst + 1], steps[worst]
    ends = np.array([low, high])
    steepest = 0.0 if derivative is None else float(np.max(np.abs(derivative(ends))))
    if step > _HIDDEN_JUMP + 8.0 * steepest * (high - low):
        raise InvalidInput(
            f"the lift jumps by {step:.6g} at θ = {low:.9g}, which is none of its breaks: "
            "if it is wrapped there give the unwrapped lift, else name the break"
        )
