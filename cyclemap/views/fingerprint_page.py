"""A fingerprint: in sentences, and on a page: how the protocol answers, the predicted map, the full
one beside it.
"""

import math
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection.fingerprint import Fingerprint, TurnResponse
from cyclemap.collection.fingerprint_prediction import DRIFTS, LOCKS, Prediction, PredictionCheck
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.maps import CircleMap
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import Panel, picture
from cyclemap.views.panels.orientation import CIRCLE
from cyclemap.views.panels.style import BAND, LINE, MEASURED, SECOND
from cyclemap.views.sentences import angle, rounded

ANYWHERE = math.radians(90.0)


def fingerprint_page(
    fingerprint: Fingerprint,
    prediction: Prediction | None = None,
    checked: PredictionCheck | None = None,
    name: str = "",
) -> Figure:
    """Draw a fingerprint; with a prediction its map too, and the full map where that was computed.

    `name` is the material's, for the title and the sentences.
    """
    title, words = "Fingerprint of the protocol", [protocol_sentence(fingerprint)]
    panels: list[Panel] = [
        (
            f"Answer to 1 % of {what}",
            partial(draw_responses, fingerprint=fingerprint, ellipse=ellipse),
        )
        for what, ellipse in (("offset", False), ("ellipticity", True))
    ]
    if prediction is not None:
        title = f"{title}, on {name}"
        words += [surface_sentence(prediction, name), direction_sentence(prediction, name)]
        words += [lock_in_sentence(prediction), trust_sentence(prediction)]
        full = None if checked is None else checked.map
        turn = partial(draw_prediction, prediction=prediction, full=full)
        panels.append(("Turn of one cycle", turn))
    if checked is not None:
        words.append(check_sentence(checked))
    symbols = ("Ω", "A₁", "δ₁", "A₂", "δ₂", "A₃", "δ₃")
    numbers = zip(symbols, seven_numbers(fingerprint.cycle), strict=True)
    written = "   ".join(f"{symbol} {value}°" for symbol, value in numbers)
    foot = f"{written}   ·   angles; A₁ and A₂ a unit of offset and ellipticity"
    layout = "a;b" if prediction is None else "acc;bcc"
    return picture(layout, panels, title=title, words=words, foot=foot)


def draw_responses(axes: Axes, fingerprint: Fingerprint, ellipse: bool) -> None:
    """Draw the change of a cycle's turn by one percent of offset, or of ellipticity, over the
    orientation.
    """
    answers = {
        name: _response(getattr(fingerprint, name), ellipse) for name in ("cycle", "drag", "push")
    }
    orientation.draw_turns(axes, CIRCLE, answers)
    seen = (
        "θ - φ, from the axis of greater friction (°)" if ellipse else "θ - ψ, from the offset (°)"
    )
    axes.set(xlabel=f"orientation {seen}", ylabel="change of turn (°)")


def draw_prediction(axes: Axes, prediction: Prediction, full: CircleMap | None = None) -> None:
    """Draw the first-order turn with its error and its directions, the second-order turn, and the
    full map's.
    """
    turn, error = prediction.turn(CIRCLE), prediction.turn_error(CIRCLE)
    if full is not None:
        orientation.draw_turn(
            axes, turn_curve(full), "full map", color=MEASURED, linewidth=3.0, zorder=3
        )
    ends = np.degrees([turn - error, turn + error])
    axes.fill_between(np.degrees(CIRCLE), *ends, label="its error", **BAND)
    turns = {"first order": turn, "second order": prediction.second_order_turn(CIRCLE)}
    orientation.draw_turns(axes, CIRCLE, turns, (LINE, SECOND))
    orientation.mark_fixed_points(axes, [direction.orbit for direction in prediction.directions])


def _response(response: TurnResponse, ellipse: bool) -> Array:
    """The answer (rad) to one percent at `CIRCLE`."""
    angle = -2.0 * CIRCLE if ellipse else -CIRCLE
    cosine, sine = response.gradient[2:4] if ellipse else response.gradient[:2]
    return 0.01 * np.asarray(cosine * np.cos(angle) + sine * np.sin(angle))


def seven_numbers(response: TurnResponse) -> tuple[str, ...]:
    """Ω, A₁, δ₁, A₂, δ₂, A₃, δ₃ in degrees, as text with three decimals."""
    harmonics = [
        f"{cause}_{measure}"
        for cause in ("offset", "ellipse", "bow")
        for measure in ("amplitude", "phase")
    ]
    names = ("turn", *harmonics)
    return tuple(rounded(math.degrees(getattr(response, name)), 3) for name in names)


def protocol_sentence(fingerprint: Fingerprint) -> str:
    """What the protocol does, in a sentence."""
    whole, strokes = (
        fingerprint.cycle,
        f"push {angle(fingerprint.push.turn)}, drag {angle(fingerprint.drag.turn)}",
    )
    offset, ellipse = (
        angle(0.01 * size, 2) for size in (whole.offset_amplitude, whole.ellipse_amplitude)
    )
    return (
        f"On an isotropic surface a cycle turns the object by {angle(whole.turn, 2)} ({strokes}); "
        f"an offset of 1 % changes that by up to {offset}, an ellipticity of 1 % by up to {ellipse}"
        ", a floor with a bow of 0.1 mean pressures at 50 mm by up to "
        f"{angle(0.1 * whole.bow_amplitude, 2)}."
    )


def floor_sentence(fingerprint: Fingerprint, bow: float, varies: bool) -> str:
    """What stands instead of a prediction where the floor has a bow or varies from place to place;
    nothing elsewhere.
    """
    words = []
    if bow:
        most = angle(bow * fingerprint.cycle.bow_amplitude, 1)
        words.append(
            f"The floor has a bow of {bow:.3g} mean pressures: to first order it changes the turn "
            f"by up to {most}."
        )
    if varies:
        words.append("The floor varies from place to place, which these numbers leave out.")
    if words:
        words.append("No direction is predicted from that; portrait computes the map.")
    return " ".join(words)


def surface_sentence(prediction: Prediction, material: str) -> str:
    """How anisotropic the surface is."""
    surface = prediction.anisotropy
    if not surface.offset and not surface.ellipticity:
        return f"{material} is the same in every direction."
    return (
        f"{material}: offset {100 * surface.offset:.1f} % along "
        f"{angle(surface.offset_direction % TWO_PI)}, ellipticity "
        f"{100 * surface.ellipticity:.1f} % along {angle(surface.ellipse_direction)}."
    )


def direction_sentence(prediction: Prediction, material: str) -> str:
    """Where the surface locks in, or how fast it drifts, to first order and with the error."""
    stable = prediction.stable_directions
    if stable:
        places = []
        for direction in stable:
            second = (
                ""
                if direction.second_order is None
                else f"; to second order {angle(direction.second_order.points[0])}"
            )
            width = (
                "± more than 90°" if direction.error > ANYWHERE else f"± {angle(direction.error)}"
            )
            places.append(
                f"{angle(direction.theta)} {width} (multiplier "
                f"{rounded(direction.orbit.multiplier, 3)}{second})"
            )
        return (
            f"To first order {material} locks into {', '.join(places)}{_doubt(prediction, LOCKS)}."
        )
    pace = ""
    if prediction.mean_turn is not None:
        pace = f": the map turns {angle(prediction.mean_turn, 2)} a cycle on average"
        slow = angle(float(prediction.turn(prediction.slowest)), 2)
        pace += (
            f", slowest near {angle(prediction.slowest, 0)} ({slow})" if prediction.ratio else ""
        )
    refined = [angle(orbit.points[0]) for orbit in prediction.second_order_points if orbit.stable]
    second = f"; to second order it locks into {', '.join(refined)}" if refined else ""
    return (
        f"To first order {material} has no stable "
        f"direction{pace}{_doubt(prediction, DRIFTS)}{second}."
    )


def lock_in_sentence(prediction: Prediction) -> str:
    """How near the surface is to the edge of lock-in; empty where no anisotropy of this kind locks
    in.
    """
    lock_in = prediction.lock_in
    if not math.isfinite(lock_in.scale):
        return ""
    low, high = prediction.lock_in_range
    between = f"{low:.2f} to {high:.2f}" if math.isfinite(high) else f"{low:.2f} or more"
    return (
        f"Lock-in begins at {lock_in.scale:.2f} times this anisotropy ({between}), near "
        f"{angle(lock_in.theta, 0)}."
    )


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
    places = [
        f"{angle(orbit.points[0])} (multiplier {rounded(orbit.multiplier, 3)})"
        for orbit in checked.stable_points
    ]
    misses = [
        "It has no such direction as predicted."
        if direction.full is None
        else f"The prediction is {angle(direction.miss)} off, "
        f"{'within' if direction.within_error else 'beyond'} its error."
        for direction in checked.directions
        if direction.predicted.stable
    ]
    return " ".join([f"The full map locks into {', '.join(places)}.", *misses])


def _doubt(prediction: Prediction, verdict: str) -> str:
    return (
        ""
        if prediction.verdict == verdict
        else ", but the error leaves open whether it locks at all"
    )
