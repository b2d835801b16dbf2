"""A probe in sentences and on one page: what goes with the orientation, and the ellipse that does
the same.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from cyclemap.evidence.identified_words import MOST_RATIO
from cyclemap.evidence.push_probe import ALARM_RATE, OUTCOMES, Probe
from cyclemap.views import map_panels, style
from cyclemap.views.map_panels import CIRCLE, draw_outcome
from cyclemap.views.sentences import angle, orientation_and_push


def probe_sentences(found: Probe) -> tuple[str, ...]:
    """The answer, what was found, the ellipse that does the same, and the lock-in that it would
    cause.
    """
    sizes = {
        name: max(one.amplitude for one in found.harmonics if one.outcome == name)
        for name in OUTCOMES
    }
    turn = f"±{math.degrees(sizes['dtheta']):.2g}°"
    place = f"±{1e3 * max(sizes['dx'], sizes['dy']):.2g} mm"
    noise = (
        f"noise of one push {1e3 * max(found.noise[:2]):.2g} mm and "
        f"{math.degrees(found.noise[2]):.2g}°"
    )
    if not found.found:
        return (
            f"No sign that pushes depend on their direction, in {found.theta.size} pushes (p = "
            f"{found.p_value:.2g}).",
            f"Anisotropy that could hide behind the {noise}: axes up to {found.ratio.upper:.4g} : 1, "
            f"a centre up to {found.offset.upper:.2g} of the mean radius off (95 % confidence).",
        )
    if found.stable:
        where = " and at ".join(orientation_and_push(theta, found.loop) for theta in found.stable)
        locks = f"at {where}"
    else:
        low, high = (angle(turn) for turn in found.turns)
        locks = f"nowhere: a cycle turns it by {low} to {high}"
    depend = (
        f"Pushes depend on direction: by {turn} and {place} (p = {found.p_value:.2g}, "
        f"{len(found.theta)} pushes)."
    )
    if found.ratio.lower > MOST_RATIO:
        return (
            depend,
            f"A friction ellipse would need axes {found.ratio.value:.3g} : 1, and no floor that was "
            "measured has them beyond 1.7 : 1: this cannot be friction. Look at object, push, "
            "units and --angles of the data.",
        )
    return (
        depend,
        f"A friction ellipse with axes {found.ratio.value:.4g} : 1 ({found.ratio.lower:.4g} to "
        f"{found.ratio.upper:.4g}), longer along {angle(found.anisotropy.ellipse_direction)}, its "
        f"centre {found.offset.value:.2g} of the mean radius off ({found.offset.lower:.2g} to "
        f"{found.offset.upper:.2g}), explains {found.explained:.0%} of that; {noise}.",
        f"A push-and-drag-back collection on such a surface locks in {locks}.",
    )


@style.picture_style()
def probe_page(found: Probe) -> Figure:
    """Draw each outcome over the orientation, with what the harmonics and the ellipse make of
    it."""
    answer, *words = probe_sentences(found)
    foot = f"called anisotropy where chance does as much in less than {ALARM_RATE:g} of probes"
    figure, panels = style.page("abc", answer, words, foot, size=(12.0, 4.8))
    made = found.mimic.cycles(CIRCLE)
    mimicked = np.column_stack([made.push_displacement, made.push_turn])
    # The mean motion is free in the fit: it is what the object rests on, not the direction.
    mimicked += found.change.mean(axis=0) - mimicked[:-1].mean(axis=0)
    for column, (axes, outcome) in enumerate(zip(panels, OUTCOMES, strict=True)):
        draw_outcome(axes, found.theta, found.change[:, column], outcome, "probed")
        title, _, scale = map_panels.OUTCOMES[outcome]
        values = scale * mimicked[:, column]
        axes.plot(np.degrees(CIRCLE), values, label="the ellipse", **style.LINE)
        style.entitle(axes, title)
    return figure
