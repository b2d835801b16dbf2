"""Five numbers of the protocol against the full map: the turn on plywood, the edge of lock-in, the
errors' order.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.collection.fingerprint import Fingerprint, fingerprint
from cyclemap.collection.fingerprint_prediction import (
    Prediction,
    PredictionCheck,
    check_prediction,
    first_order_lock_in,
    full_lock_in,
    lock_in_boundary,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy, with_anisotropy
from cyclemap.views.fingerprint_page import draw_prediction
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.style import INK, LINE, LINES, MARKS, name_tag, picture_style

from . import Exhibit, MeasuredFolder
from .loop_family import ring_radius, with_anisotropy_times, with_ring_at

INCHES = (13.333, 4.6)
SCALES = 2.0 ** -np.arange(0.0, 6.0)
# Orders are read off where the anisotropy is this share of plywood's or less.
ASYMPTOTIC = 0.125
# Rays of the (offset, ellipticity) plane along which the full map's lock-in is sought.
RAYS = np.radians([0.0, 15.0, 35.0, 60.0, 90.0])
# Up to this factor of the ring's lever an isotropic cycle comes to turn the object by nothing.
MOST_LEVER = 2.0
_ORIENTATIONS = np.radians(np.arange(0.0, 360.0, 15.0))


@dataclass(frozen=True, eq=False)
class FingerprintAgainstFull:
    """What the figure shows.

    prediction, checked : on plywood, and beside the full map.
    predicted_edge, full_edge : (k, 2), the lock-in boundary as (offset, ellipticity) along `RAYS`.
    scales : (n,), factors of plywood's anisotropy.
    turn_error, second_turn_error : (n,), rad, largest over the orientations, of the first- and the
        second-order turn.
    ring : m, its distance at which an isotropic cycle turns nothing.
    direction_error : (n,), rad, of the stable direction there.
    """

    prediction: Prediction
    checked: PredictionCheck
    predicted_edge: Array
    full_edge: Array
    scales: Array
    turn_error: Array
    second_turn_error: Array
    ring: float
    direction_error: Array


def compute(
    measured: MeasuredFolder, scales: Array = SCALES, rays: Array = RAYS
) -> FingerprintAgainstFull:
    """Compute it from the mechanics alone, at some scales and along some rays; no measured data are
    used.
    """
    loop = CollectionLoop.mit(material="plywood")
    surface = Anisotropy.of(loop.material.friction)
    prediction = Prediction(fingerprint(loop), surface)
    first, second = turn_errors(loop, prediction.fingerprint, surface, scales)
    neutral = neutral_loop(loop)
    return FingerprintAgainstFull(
        prediction,
        check_prediction(prediction, loop, tolerance=1e-4),
        lock_in_boundary(
            prediction.fingerprint.cycle, surface.offset_direction, surface.ellipse_direction, rays
        ),
        full_boundary(loop, prediction, rays),
        read_only(scales),
        first,
        second,
        ring_radius(neutral),
        direction_errors(neutral, surface, scales),
    )


def turn_errors(
    loop: CollectionLoop, fingerprint_: Fingerprint, surface: Anisotropy, scales: Array
) -> tuple[Array, Array]:
    """Largest errors (n,), rad, of the first- and the second-order turn on a surface scaled by
    `scales` (n,).
    """
    errors = []
    for scale in scales.tolist():
        scaled = Prediction(fingerprint_, surface.scaled(scale))
        full = with_anisotropy(loop, scaled.anisotropy).next_theta(_ORIENTATIONS) - _ORIENTATIONS
        laws = scaled.turn(_ORIENTATIONS), scaled.second_order_turn(_ORIENTATIONS)
        errors.append([np.abs(full - law).max() for law in laws])
    first, second = np.array(errors).T
    return first, second


def neutral_loop(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop with its ring moved out until an isotropic cycle turns the
    object by nothing."""
    from scipy.optimize import brentq

    isotropic, ring = with_anisotropy_times(loop, 0.0), ring_radius(loop)
    radius = brentq(
        lambda r: with_ring_at(isotropic, r).cycle(0.0).theta_next,
        ring,
        MOST_LEVER * ring,
        xtol=1e-13,
    )
    return with_ring_at(loop, float(radius))


def direction_errors(loop: CollectionLoop, surface: Anisotropy, scales: Array) -> Array:
    """How far (n,), rad, the first-order stable direction lies from the full map's, the surface
    scaled by `scales`.
    """
    from scipy.optimize import brentq

    response = fingerprint(loop)
    errors = []
    for scale in scales.tolist():
        scaled = Prediction(response, surface.scaled(scale))
        theta, full = scaled.stable_directions[0].theta, with_anisotropy(loop, scaled.anisotropy)
        root = brentq(
            lambda t, full=full: full.cycle(t).theta_next - t, theta - 1.0, theta + 1.0, xtol=1e-10
        )
        errors.append(abs(root - theta))
    return np.array(errors)


def full_boundary(loop: CollectionLoop, prediction: Prediction, rays: Array) -> Array:
    """Return points (k, 2) of (offset, ellipticity) at which the full map begins to lock in along
    rays (k,), rad.
    """
    points = []
    for angle in rays.tolist():
        ray = replace(prediction.anisotropy, offset=math.cos(angle), ellipticity=math.sin(angle))
        near = first_order_lock_in(prediction.fingerprint.cycle, ray)
        scale = full_lock_in(replace(loop, accuracy=1e-6), ray, near, tolerance=1e-4).scale
        points.append([scale * ray.offset, scale * ray.ellipticity])
    return np.array(points)


def order(scales: Array, errors: Array) -> float:
    """Return the slope of log error over log scale, by least squares over the scales up to
    `ASYMPTOTIC`.
    """
    small = scales <= ASYMPTOTIC
    return float(np.polyfit(np.log(scales[small]), np.log(errors[small]), 1)[0])


@picture_style()
def draw(result: FingerprintAgainstFull) -> Figure:
    """Draw the predicted turn beside the full map's, both edges of lock-in, and the errors over the
    anisotropy.
    """
    figure, (turn, edge, errors) = page("abc", size=INCHES, width_ratios=(1.45, 1.0, 1.0))
    draw_prediction(turn, result.prediction, result.checked.map)
    entitle(turn, "Plywood")
    _draw_edge(edge, result)
    _draw_errors(errors, result)
    return figure


def _draw_edge(axes: Axes, result: FingerprintAgainstFull) -> None:
    surface, response = result.prediction.anisotropy, result.prediction.fingerprint.cycle
    rays = np.radians(np.linspace(0.0, 90.0, 361))
    edge = lock_in_boundary(response, surface.offset_direction, surface.ellipse_direction, rays)
    axes.plot(*edge.T, label="first order", **LINE)
    axes.plot(*result.full_edge.T, "s", label="full map", clip_on=False, **MARKS)
    axes.plot(surface.offset, surface.ellipticity, "*", color=INK, markersize=10.0, zorder=5)
    name_tag(axes, surface.offset, surface.ellipticity + 0.009, "plywood")
    axes.set(xlim=(0.0, 0.16), ylim=(0.0, 0.12), xlabel="offset (1)", ylabel="ellipticity (1)")
    name_tag(axes, 0.023, 0.012, "drifts")
    name_tag(axes, 0.125, 0.09, "locks")
    entitle(axes, "Edge of lock-in")


def _draw_errors(axes: Axes, result: FingerprintAgainstFull) -> None:
    curves = (
        ("turn, first order", result.turn_error, "o"),
        ("turn, second order", result.second_turn_error, "^"),
        ("stable direction", result.direction_error, "s"),
    )
    for (name, errors, marker), look in zip(curves, LINES, strict=False):
        # The kinks' share of what the second order leaves vanishes before the rest: it has no
        # single order.
        known = "" if "second" in name else f": order {order(result.scales, errors):.1f}"
        axes.loglog(
            result.scales, np.degrees(errors), marker=marker, label=f"{name}{known}", **look
        )
    inverse = [round(1.0 / scale) for scale in result.scales.tolist()]
    names = [f"1/{times}" if times > 1 else "1" for times in inverse]
    axes.set_xticks(result.scales, names)
    axes.minorticks_off()
    axes.set(xlabel="anisotropy over plywood's (1)", ylabel="error (°)", title="Errors")
    axes.legend(loc="lower right")


def caption(result: FingerprintAgainstFull) -> str:
    """Sentences that hold for this result."""
    response, (stable, *_) = (
        result.prediction.fingerprint.cycle,
        [checked for checked in result.checked.directions if checked.predicted.stable],
    )
    numbers = (
        response.turn,
        response.offset_amplitude,
        response.offset_phase,
        response.ellipse_amplitude,
        response.ellipse_phase,
    )
    five = "Ω {:.2f}°, A₁ {:.1f}°, δ₁ {:.1f}°, A₂ {:.1f}°, δ₂ {:.1f}°".format(
        *map(math.degrees, numbers)
    )
    theta, error, miss = (
        math.degrees(v) for v in (stable.predicted.theta, stable.predicted.error, stable.miss)
    )
    within = "within" if stable.within_error else "beyond"
    off = np.abs(
        1.0
        - np.linalg.norm(result.predicted_edge, axis=1) / np.linalg.norm(result.full_edge, axis=1)
    )
    turn, direction = (
        order(result.scales, errors) for errors in (result.turn_error, result.direction_error)
    )
    return (
        f"Five numbers of the protocol ({five}) predict plywood's stable direction, {theta:.1f}° ± "
        f"{error:.1f}°; the full map's is {miss:.1f}° away, {within} that error. The edge of "
        f"lock-in is predicted to {off.max():.0%} or better. Where the anisotropy is small, the "
        f"error of the turn falls with its power {turn:.2f}, that of the stable direction with its "
        f"power {direction:.2f}, the latter with the ring {1e3 * result.ring:.1f} mm from the "
        "centre, where an isotropic cycle turns nothing."
    )


EXHIBITS = {
    "fingerprint": Exhibit(compute, caption, draw),
}
