"""A probe in sentences and on one page: what goes with the orientation, and the ellipse that does
the same.
"""

from __future__ import annotations

import math
import textwrap

import numpy as np
from matplotlib.figure import Figure

from cyclemap.evidence.plausibility import MOST_RATIO
from cyclemap.evidence.push_probe import ALARM_RATE, OUTCOMES, Probe
from cyclemap.views.sentences import angle, orientation_and_push
from cyclemap.views.style import (
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    degree_axis,
    new_figure,
    picture_style,
)

_LABELS = {"dx": ("Δx (mm)", 1e3), "dy": ("Δy (mm)", 1e3), "dtheta": ("Δθ (°)", math.degrees(1.0))}
_LETTERS = 150


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
    if found.ratio.lower > MOST_RATIO:
        return (
            f"Pushes depend on direction: by {turn} and {place} (p = {found.p_value:.2g}, "
            f"{len(found.theta)} pushes).",
            f"A friction ellipse would need axes {found.ratio.value:.3g} : 1, and no floor that was "
            "measured has them beyond 1.7 : 1: this cannot be friction. Look at object, push, "
            "units and --angles of the data.",
        )
    return (
        f"Pushes depend on direction: by {turn} and {place} (p = {found.p_value:.2g}, "
        f"{len(found.theta)} pushes).",
        f"A friction ellipse with axes {found.ratio.value:.4g} : 1 ({found.ratio.lower:.4g} to "
        f"{found.ratio.upper:.4g}), longer along {angle(found.anisotropy.ellipse_direction)}, its "
        f"centre {found.offset.value:.2g} of the mean radius off ({found.offset.lower:.2g} to "
        f"{found.offset.upper:.2g}), explains {found.explained:.0%} of that; {noise}.",
        f"A push-and-drag-back collection on such a surface locks in {locks}.",
    )


@picture_style()
def probe_page(found: Probe) -> Figure:
    """Draw each outcome over the orientation,
    with what the harmonics and the ellipse make of it."""
    words = [
        line for sentence in probe_sentences(found) for line in textwrap.wrap(sentence, _LETTERS)
    ]
    figure = new_figure(12.0, 4.6)
    panels = figure.subplots(1, 3)
    figure.subplots_adjust(left=0.06, right=0.98, top=0.86, bottom=0.34, wspace=0.26)
    for column, (axes, outcome) in enumerate(zip(panels, OUTCOMES, strict=True)):
        label, scale = _LABELS[outcome]
        measured = scale * found.change[:, column]
        theta = np.degrees(found.theta) % 360.0
        axes.plot(
            theta, measured, "o", mfc=MEASURED, mec=MEASURED_EDGE, markersize=4, label="probed"
        )
        around = np.linspace(0.0, 2.0 * math.pi, 91)
        made = found.mimic.cycles(around)
        mimicked = scale * (
            made.push_turn if outcome == "dtheta" else made.push_displacement[:, column]
        )
        # The mean motion is free in the fit: it is what the object rests on, not the direction.
        mimicked += measured.mean() - mimicked[:-1].mean()
        axes.plot(np.degrees(around), mimicked, color=PREDICTED, label="the ellipse")
        axes.set_ylabel(label)
        degree_axis(axes, "orientation θ0 (°)")
    panels[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    foot = f"called anisotropy where chance does as much in less than {ALARM_RATE:g} of probes"
    figure.text(
        0.02, 0.02, "\n".join([*words, foot]), color=INK, fontsize=8.5, va="bottom", linespacing=1.4
    )
    return figure
