"""The pictures of the locking-in animation: one figure whose artists move."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import FuncFormatter, MultipleLocator

from cyclemap.views.style import (
    INK,
    MEASURED,
    MEASURED_EDGE,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    new_figure,
    picture_style,
)

from .animation import figure_pixels
from .exhibit import Frame

if TYPE_CHECKING:
    from .locking_in import LockingIn, Moment

MM = 1000.0
INCHES, DPI = (7.2, 4.1), 100
RING_MM, MARGIN_MM = 7.0, 12.0
TABLE_COLOUR = "#faf6ee"


def frames(result: LockingIn) -> Iterator[Frame]:
    """Draw every moment of the run."""
    with picture_style():
        stage = _Stage(result)
        for moment in result.moments:
            stage.show(moment)
            yield Frame(figure_pixels(stage.figure, DPI), moment.seconds)


class _Stage:
    """The figure with everything that moves in it."""

    def __init__(self, result: LockingIn) -> None:
        self.result = result
        self.figure: Figure = new_figure(*INCHES)
        grid = GridSpec(
            2, 2, self.figure, width_ratios=(1.32, 1.0), height_ratios=(1.55, 1.0),
            left=0.015, right=0.985, bottom=0.125, top=0.915, wspace=0.27, hspace=0.5,
        )  # fmt: skip
        self._table(self.figure.add_subplot(grid[:, 0]))
        self._cobweb(self.figure.add_subplot(grid[0, 1]))
        self._staircase(self.figure.add_subplot(grid[1, 1]))

    def _table(self, axes: Axes) -> None:
        """The table from above; the world's origin is where the ring is set down."""
        everything = MM * np.concatenate([moment.outline for moment in self.result.moments])
        low, high = everything.min(axis=0) - MARGIN_MM, everything.max(axis=0) + MARGIN_MM
        axes.set(
            xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[], facecolor=TABLE_COLOUR
        )
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.plot(0, 0, "+", color=QUIET, markersize=10, zorder=1)
        (self.path,) = axes.plot([], [], color=INK, linewidth=1.2, zorder=4)
        self.body = Polygon(np.zeros((3, 2)), facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.6, zorder=2)
        self.ring = Circle((0, 0), RING_MM, fill=False, edgecolor=PREDICTED, linewidth=1.6, zorder=3)
        self.rod = Circle((0, 0), MM * self.result.rod_radius, facecolor=INK, edgecolor=INK, zorder=5)
        (self.side,) = axes.plot([], [], color=PREDICTED, linewidth=4.5, solid_capstyle="butt", zorder=3)
        for patch in (self.body, self.ring, self.rod):
            axes.add_patch(patch)
        bar = low + 14.0
        axes.plot([bar[0], bar[0] + 50.0], [bar[1]] * 2, color=INK, linewidth=2.0)
        axes.text(bar[0] + 25.0, bar[1] + 4.0, "50 mm", ha="center", fontsize=7.5)
        self.told = axes.set_title("", fontsize=10)

    def _cobweb(self, axes: Axes) -> None:
        curve = np.degrees(self.result.curve)
        axes.plot(curve[:, 0], curve[:, 0], color=QUIET, linewidth=0.9)
        axes.plot(curve[:, 0], curve[:, 1], color=PREDICTED, linewidth=1.8)
        (self.stairs,) = axes.plot([], [], color=MEASURED_EDGE, linewidth=0.9)
        for place, face in ((self.result.stable, PREDICTED), (self.result.unstable, "white")):
            at = math.degrees(place)
            axes.plot(at, at, "o", markerfacecolor=face, markeredgecolor=PREDICTED, markersize=5, zorder=5)
        axes.set(xlim=curve[[0, -1], 0], ylim=curve[[0, -1], 0], xlabel="θ0 (°)", ylabel="next θ0 (°)")
        for axis in (axes.xaxis, axes.yaxis):
            _on_the_circle(axis)
        axes.set_title("The cycle map", fontsize=9)

    def _staircase(self, axes: Axes) -> None:
        axes.axhline(math.degrees(self.result.stable), color=PREDICTED, linewidth=1.2, linestyle="--")
        look = {"color": MEASURED, "markeredgecolor": MEASURED_EDGE, "markeredgewidth": 0.5, "markersize": 3.5}
        (self.dots,) = axes.plot([], [], "o", **look)  # type: ignore[arg-type]
        theta = np.degrees(self.result.theta)
        span = (theta.min() - 12.0, theta.max() + 15.0)
        axes.set(xlim=(-1, self.result.cycles + 1), ylim=span, xlabel="cycle", ylabel="θ0 (°)")
        _on_the_circle(axes.yaxis)

    def show(self, moment: Moment) -> None:
        """Move everything to where it is at this moment."""
        self.body.set_xy(MM * moment.outline)
        self.side.set_data(*(MM * moment.side).T)
        self.ring.center = tuple(MM * moment.ring)
        self.rod.center = tuple(MM * moment.rod)
        self.path.set_data(*(MM * moment.rod_path).T)
        self.path.set_linestyle("-" if moment.pushing else ":")
        theta = np.degrees(self.result.theta[: moment.cycle + 1])
        doing = "push" if moment.pushing else "drag back"
        self.told.set_text(f"Cycle {moment.cycle + 1}, from θ0 = {theta[-1] % 360:.1f}°: {doing}")
        self.dots.set_data(np.arange(theta.size), theta)
        corners = np.repeat(theta, 2)
        self.stairs.set_data(corners[:-1], corners[1:])


def _on_the_circle(axis: object) -> None:
    """Ticks each eighth of a turn, named in [0, 360)."""
    axis.set_major_locator(MultipleLocator(45.0))  # type: ignore[attr-defined]
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value % 360:.0f}"))  # type: ignore[attr-defined]
