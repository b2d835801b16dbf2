"""Paths of the pushed object's centre in the object's own frame before the push, on the paper's four surfaces."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.arrays import Array
from cyclemap.evidence.published_statistics import published_statistics
from cyclemap.views.style import QUIET, new_figure, picture_style

from .catalogue import MeasuredFolder, PaperFigure
from .pushed_paths import (
    CYCLES,
    DRAWN,
    MM,
    PushedPaths,
    draw_paths,
    material_sentence,
    panel_title,
    paths_on_four_surfaces,
    shade_bar,
    turn_shades,
)


@dataclass(frozen=True)
class ObjectFramePaths:
    """The pushes on each surface, in the order of the paper."""

    surfaces: list[PushedPaths]

    def spread(self, surface: int) -> Array:
        """Standard deviations (3,) of turn (rad), dx and dy (m) over the pushes on a surface."""
        paths = self.surfaces[surface]
        return np.array([paths.turn.std(), *paths.end.std(axis=0)])


def compute(measured: MeasuredFolder, cycles: int = CYCLES, drawn: int = DRAWN) -> ObjectFramePaths:
    """Run or read the pushes on the four surfaces: `drawn` of a run of `cycles`."""
    return ObjectFramePaths(paths_on_four_surfaces(measured, cycles, drawn))


def draw(result: ObjectFramePaths) -> Figure:
    """Draw four panels on one scale, y down the push, a darker shade for a larger turn."""
    ends = MM * np.concatenate([paths.object_frame.reshape(-1, 2) for paths in result.surfaces])
    low, high = ends.min(axis=0) - 4.0, ends.max(axis=0) + 4.0
    shades = turn_shades(result.surfaces)
    with picture_style():
        figure = new_figure(10.6, 5.5)
        grid = GridSpec(1, 4, figure, left=0.065, right=0.9, bottom=0.1, top=0.91, wspace=0.12)
        for number, paths in enumerate(result.surfaces):
            axes = figure.add_subplot(grid[number])
            draw_paths(axes, paths.object_frame, paths.turn, shades)
            axes.plot(0.0, 0.0, "+", color=QUIET, markersize=8)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x (mm)")
            axes.set_title(panel_title(paths).replace(", ", ",\n"))
            turn, dx, dy = result.spread(number)
            told = f"σ(Δθ) {np.degrees(turn):.1f}°\nσ(Δx) {MM * dx:.1f} mm\nσ(Δy) {MM * dy:.1f} mm"
            axes.text(0.97, 0.97, told, transform=axes.transAxes, ha="right", va="top", fontsize=8)
            if number:
                axes.tick_params(labelleft=False)
            else:
                axes.set_ylabel("y (mm), object's frame before the push")
        shade_bar(figure, (0.925, 0.2, 0.014, 0.55), shades)
    return figure


def caption(result: ObjectFramePaths) -> str:
    """What is shown, how far the ends spread, and what is published of that."""
    spreads, units = [], ((float(np.degrees(1.0)), "°"), (MM, " mm"), (MM, " mm"))
    for number, paths in enumerate(result.surfaces):
        both = zip(result.spread(number), published_statistics(paths.surface).std, units, strict=True)
        told = ", ".join(f"{unit * here:.1f}{name} ({unit * there:.1f})" for here, there, (unit, name) in both)
        spreads.append(f"{paths.surface} {told}")
    scatter = "" if all(paths.recorded for paths in result.surfaces) else _LAW_SCATTER
    return (
        "Paths of the object's centre in equal pushes, in the object's frame before each push (it starts at the "
        "origin and is pushed along -y); a darker shade is a larger turn. In this frame isotropic friction would give "
        "a single path. σ is the standard deviation of (Δθ, Δx, Δy) over the pushes drawn, in brackets the "
        f"published one (Table II): {'; '.join(spreads)}. {scatter}"
        f"{material_sentence(result.surfaces)}"
    )


# A simulated push has no scatter about the law that Table III tells of.
_LAW_SCATTER = "Simulated pushes are exact functions of θ0 and wear; recorded ones scatter about it too (Table III). "

FIGURE = PaperFigure(compute, draw, caption)
