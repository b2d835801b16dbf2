"""Fig. 5: the turn Δθ of the push over the orientation θ0 that it starts from,
on four materials."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.evidence.laws.set_fit import MotionLaw
from cyclemap.views import style
from cyclemap.views.fit_page import draw_motion_law
from cyclemap.views.map_panels import CIRCLE, draw_curves
from cyclemap.views.sentences import angle, listed
from cyclemap.views.style import QUIET

from .catalogue import MeasuredFolder
from .measured_sets import MeasuredRun, measured_run, not_found
from .simulated_collections import (
    PAPER,
    STANDS_FOR,
    SampledRun,
    Sampling,
    as_simulated,
    draw_materials,
    fitted_laws,
    sampled_run,
)

# Share of the pushes whose arc is told.
MOST = 0.95


@dataclass(frozen=True, eq=False)
class MaterialTurns:
    """One panel.

    run : simulated pushes.
    measured : the recorded set, None where none was found.
    law : of the recorded Δθ where there are any, else of the simulated.
    simulated_law : of these.
    curves : (states, 721) rad, the mechanics' Δθ at ``CIRCLE``, fresh and worn; one where the
        surface does not wear.
    arc : rad, the shortest in which 95 % of the simulated pushes start.
    worst_miss : rad, how far their law lies from the mechanics of the fresh surface, at worst.
    """

    run: SampledRun
    measured: MeasuredRun | None
    law: MotionLaw
    simulated_law: MotionLaw
    curves: Array
    arc: float
    worst_miss: float


def shortest_arc(theta: Array, share: float) -> float:
    """Length (rad) of the shortest arc of the circle that holds a share, in (0, 1], of the angles
    (n,), any turn.

    >>> round(shortest_arc(np.array([0.1, 6.2, 0.3, 3.0]), 0.75), 6)
    0.383185
    """
    angles = np.sort(np.mod(theta, 2 * np.pi))
    held = max(int(np.ceil(share * angles.size)), 1)
    ends = np.concatenate([angles, angles + 2 * np.pi])[held - 1 : held - 1 + angles.size]
    return float(np.min(ends - angles))


def compute(measured: MeasuredFolder, sampling: Sampling = PAPER) -> tuple[MaterialTurns, ...]:
    """Simulate pushes on each material, look for recorded ones, and fit the law of Δθ to both."""
    panels = []
    for surface, material in STANDS_FOR.items():
        found, run = measured_run(measured, surface), sampled_run(material, sampling)
        simulated = fitted_laws(run.pushes)[0]
        law = simulated if found is None else fitted_laws(found.pushes)[0]
        shown = run.states[:: max(len(run.states) - 1, 1)]
        curves = np.array([state.motion(CIRCLE)[:, 0] for state in shown])
        arc = shortest_arc(run.pushes.theta, MOST)
        miss = (
            math.nan
            if simulated.law is None
            else float(np.max(np.abs(simulated.law(CIRCLE) - curves[0])))
        )
        panels.append(MaterialTurns(run, found, law, simulated, curves, arc, miss))
    return tuple(panels)


def draw(result: tuple[MaterialTurns, ...]) -> Figure:
    """Draw a panel a material."""
    return draw_materials([panel.run.surface for panel in result], result, _draw_material)


def _draw_material(axes: Axes, panel: MaterialTurns) -> None:
    draw_motion_law(axes, panel.law)
    if panel.measured is None:
        as_simulated(axes)
    else:
        theta, turn = (
            np.degrees(panel.run.pushes.theta) % 360.0,
            np.degrees(panel.run.pushes.dtheta),
        )
        axes.plot(theta, turn, label="simulated", **{**style.DOTS, "color": QUIET, "zorder": 1})
    names = ("mechanics",) if len(panel.curves) == 1 else ("mechanics, fresh", "mechanics, worn")
    curves = dict(zip(names, panel.curves, strict=True))
    draw_curves(axes, CIRCLE, curves, (style.SECOND, style.FOURTH))
    shown = np.degrees(np.concatenate([panel.curves.ravel(), panel.law.value]))
    margin = 0.08 * float(np.ptp(shown)) + 0.5
    low, high = axes.get_ylim()
    axes.set_ylim(min(shown.min() - margin, low), max(shown.max() + margin, high))


def caption(result: tuple[MaterialTurns, ...]) -> str:
    """What is drawn, and how far each law and each range of directions goes."""
    count = result[0].run.pushes.count
    recorded = [
        f"{panel.run.surface} ({panel.measured.pushes.count} pushes, law within "
        f"{angle(panel.law.law.rmse, 2)} RMS)"
        for panel in result
        if panel.measured is not None and panel.law.law is not None
    ]
    told = [
        f"Turn of the push over θ0: predicted by the mechanics, and {count} simulated pushes a "
        "material with the law fitted to them. In each push friction is off by a random offset, as "
        "much as makes the next θ0 scatter by 1.1°, as measured cycles on plywood do. Plywood is "
        "the one inferred from the measured staircase (plywood-measured), which wears; the curve "
        "of its last cycle is drawn too.",
        *[_sentence(panel) for panel in result],
        "Where no push starts, a law only guesses: around the circle it misses the mechanics by up "
        "to "
        f"{listed(f'{angle(panel.worst_miss)} on {panel.run.surface}' for panel in result)}.",
        f"Recorded pushes are drawn, and their law, on {listed(recorded)}." if recorded else "",
        not_found("pushes", [panel.run.surface for panel in result if panel.measured is None]),
    ]
    return " ".join(filter(None, told))


def _sentence(panel: MaterialTurns) -> str:
    low, high = np.degrees([panel.curves[0].min(), panel.curves[0].max()])
    rmse = panel.simulated_law.law
    fitted = (
        "no law could be fitted" if rmse is None else f"the law is {angle(rmse.rmse, 2)} RMS off"
    )
    return (
        f"On {panel.run.surface} the mechanics turns by {low:.1f}° to {high:.1f}°, {fitted} in the "
        f"simulated pushes (paper, recorded: {angle(panel.run.published.rmse[0], 2)}), and 95 "
        f"% of these start on an arc of {angle(panel.arc, 0)}."
    )
