"""A fingerprint in sentences: what the protocol does on any surface, and where one surface locks in."""

import math

from cyclemap.collection.fingerprint import Fingerprint, TurnResponse
from cyclemap.collection.fingerprint_check import CheckedDirection, PredictionCheck
from cyclemap.collection.fingerprint_prediction import DRIFTS, LOCKS, PredictedDirection, Prediction
from cyclemap.views.sentences import angle

ANYWHERE = math.radians(90.0)


def five_numbers(response: TurnResponse) -> tuple[str, ...]:
    """Ω, A₁, δ₁, A₂, δ₂ in degrees, as text with three decimals."""
    values = (
        response.turn,
        response.offset_amplitude,
        response.offset_phase,
        response.ellipse_amplitude,
        response.ellipse_phase,
    )
    return tuple(f"{math.degrees(value):.3f}".replace("-", "−") for value in values)


def protocol_sentence(found: Fingerprint) -> str:
    """What the protocol does, in a sentence."""
    parts = f"push {angle(found.push.turn)}, drag {angle(found.drag.turn)}"
    offset, ellipse = (angle(0.01 * size, 2) for size in (found.offset_amplitude, found.ellipse_amplitude))
    return (
        f"On an isotropic surface a cycle turns the object by {angle(found.turn, 2)} ({parts}); an offset of 1 % "
        f"changes that by up to {offset}, an ellipticity of 1 % by up to {ellipse}."
    )


def surface_sentence(prediction: Prediction, material: str) -> str:
    """How anisotropic the surface is."""
    surface = prediction.anisotropy
    if not surface.offset and not surface.ellipticity:
        return f"{material} is the same in every direction."
    return (
        f"{material}: offset {100 * surface.offset:.1f} % along {angle(surface.offset_direction % (2 * math.pi))}, "
        f"ellipticity {100 * surface.ellipticity:.1f} % along {angle(surface.ellipse_direction)}."
    )


def direction_sentence(prediction: Prediction, material: str) -> str:
    """Where the surface locks in, or how fast it drifts, to first order and with the error."""
    stable = prediction.stable_directions
    if stable:
        places = ", ".join(_place(direction) for direction in stable)
        return f"To first order {material} locks into {places}{_doubt(prediction, LOCKS)}."
    pace = ""
    if prediction.mean_turn is not None:
        pace = f": the map turns {angle(prediction.mean_turn, 2)} a cycle on average"
        slow = angle(float(prediction.turn(prediction.slowest)), 2)
        pace += f", slowest near {angle(prediction.slowest, 0)} ({slow})" if prediction.ratio else ""
    refined = [angle(orbit.points[0]) for orbit in prediction.second_order_points if orbit.stable]
    second = f"; to second order it locks into {', '.join(refined)}" if refined else ""
    return f"To first order {material} has no stable direction{pace}{_doubt(prediction, DRIFTS)}{second}."


def lock_in_sentence(prediction: Prediction) -> str:
    """How near the surface is to the edge of lock-in; empty where no anisotropy of this kind locks in."""
    lock_in = prediction.lock_in
    if not math.isfinite(lock_in.scale):
        return ""
    low, high = prediction.lock_in_range
    between = f"{low:.2f} to {high:.2f}" if math.isfinite(high) else f"{low:.2f} or more"
    return f"Lock-in begins at {lock_in.scale:.2f} times this anisotropy ({between}), near {angle(lock_in.theta, 0)}."


def trust_sentence(prediction: Prediction) -> str:
    """That the first-order law is not to be trusted here, and why; empty where it is."""
    if prediction.trusted:
        return ""
    why = (
        f"its error is {prediction.ratio:.0%} of what it predicts"
        if prediction.second_order_found
        else "the protocol's second order could not be found, so its error is not known"
    )
    return f"A first-order law is not to be trusted here: {why}; compute the full map."


def check_sentence(checked: PredictionCheck) -> str:
    """What the full map says of it."""
    if not checked.stable_points:
        return "The full map has no stable direction."
    places = [f"{angle(orbit.points[0])} (multiplier {_signed(orbit.multiplier)})" for orbit in checked.stable_points]
    misses = [_miss(direction) for direction in checked.directions if direction.predicted.stable]
    return " ".join([f"The full map locks into {', '.join(places)}.", *misses])


def _place(direction: PredictedDirection) -> str:
    second = direction.second_order
    refined = "" if second is None else f"; to second order {angle(second.points[0])}"
    width = "± more than 90°" if direction.error > ANYWHERE else f"± {angle(direction.error)}"
    return f"{angle(direction.theta)} {width} (multiplier {_signed(direction.multiplier)}{refined})"


def _signed(value: float) -> str:
    return f"{value:.3f}".replace("-", "−")


def _doubt(prediction: Prediction, verdict: str) -> str:
    return "" if prediction.verdict == verdict else ", but the error leaves open whether it locks at all"


def _miss(checked: CheckedDirection) -> str:
    if checked.full is None:
        return "It has no such direction as predicted."
    within = "within" if checked.within_error else "beyond"
    return f"The prediction is {angle(checked.miss)} off, {within} its error."
