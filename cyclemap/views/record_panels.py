"""What the robot will record: the histogram of directions and the staircase."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from cyclemap.arrays import Array
from cyclemap.collection.portrait_curves import PortraitCurves
from cyclemap.views.panel_parts import unwrapped_axis
from cyclemap.views.style import MEASURED, MEASURED_EDGE, PREDICTED, PREDICTED_FILL, degree_axis

if TYPE_CHECKING:
    from cyclemap.evidence import AngleHistogram


PER_DEGREE = np.pi / 180
LEAST_SPAN_DEG = 120.0


def draw_density(axes: Axes, curves: PortraitCurves) -> None:
    """The predicted stationary density of θ0."""
    theta, density = np.degrees(curves.density_theta), PER_DEGREE * curves.density
    axes.fill_between(theta, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta, density, color=PREDICTED, linewidth=1.8, label="predicted", zorder=3)
    degree_axis(axes, "θ0, orientation before the push (°)")
    axes.set_ylabel("probability per degree")


def draw_measured_histogram(axes: Axes, histogram: AngleHistogram) -> None:
    """How often each direction was recorded."""
    axes.stairs(
        PER_DEGREE * histogram.density,
        np.degrees(histogram.edges),
        fill=True,
        facecolor=MEASURED,
        edgecolor=MEASURED_EDGE,
        linewidth=0.6,
        alpha=0.65,
        label="measured",
        zorder=2,
    )


def draw_staircase(axes: Axes, predicted: Array, measured: Array | None) -> None:
    """θ0 over the cycles, unwrapped: one predicted noisy run, and the measured one where there is one."""
    if measured is not None:
        axes.plot(np.degrees(measured), color=MEASURED, linewidth=2.2, label="measured", zorder=2)
    axes.plot(np.degrees(predicted), color=PREDICTED, linewidth=1.2, label="predicted", zorder=3)
    axes.set_xlabel("cycle")
    axes.set_xlim(0, max(len(predicted), 0 if measured is None else len(measured)) - 1)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
    unwrapped_axis(axes, "θ0, unwrapped", LEAST_SPAN_DEG)
