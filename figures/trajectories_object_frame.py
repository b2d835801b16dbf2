"""Paths of the pushed object's centre in the object's own frame before the push, on the paper's
four surfaces.
"""

import numpy as np
from matplotlib.figure import Figure

from cyclemap.views import style
from cyclemap.views.object_page import MM
from cyclemap.views.sentences import angle

from .catalogue import MeasuredFolder
from .published_statistics import published_statistics
from .pushed_paths import (
    CYCLES,
    DRAWN,
    RECORDED,
    PushedPaths,
    draw_paths,
    material_sentence,
    paths_on_four_surfaces,
    shade_bar,
    shades_of,
)


def compute(
    measured: MeasuredFolder, cycles: int = CYCLES, drawn: int = DRAWN
) -> list[PushedPaths]:
    """Run or read the pushes on the four surfaces: `drawn` of a run of `cycles`."""
    return paths_on_four_surfaces(measured, cycles, drawn)


@style.picture_style()
def draw(result: list[PushedPaths]) -> Figure:
    """Draw four panels on one scale, y down the push, a darker shade for a larger turn."""
    ends = MM * np.concatenate([paths.object_frame.reshape(-1, 2) for paths in result])
    low, high = ends.min(axis=0) - 4.0, ends.max(axis=0) + 4.0
    figure, panels = style.page(style.rows_of(len(result)), size=(11.6, 5.5))
    shades = shades_of(result)
    for axes, paths in zip(panels, result, strict=True):
        draw_paths(axes, paths.object_frame, paths.turn, shades)
        style.show_window(axes, low, high)
        axes.set(xlabel="x (mm)", ylabel="y (mm), object's frame before the push")
        axes.label_outer()
        axes.set_title(f"{paths.surface},\n{paths.origin}")
        turn, dx, dy = paths.spread
        told = f"σ(Δθ) {angle(turn)}\nσ(Δx) {MM * dx:.1f} mm\nσ(Δy) {MM * dy:.1f} mm"
        axes.text(0.97, 0.97, told, transform=axes.transAxes, ha="right", va="top", fontsize=8)
    shade_bar(figure, panels, shades)
    return figure


def caption(result: list[PushedPaths]) -> str:
    """What is shown, how far the ends spread, and what is published of that."""
    spreads, units = [], ((float(np.degrees(1.0)), "°"), (MM, " mm"), (MM, " mm"))
    for paths in result:
        both = zip(paths.spread, published_statistics(paths.surface).std, units, strict=True)
        told = ", ".join(
            f"{unit * here:.1f}{name} ({unit * there:.1f})" for here, there, (unit, name) in both
        )
        spreads.append(f"{paths.surface} {told}")
    # A simulated push has no scatter about the law that Table III tells of.
    scatter = (
        "Simulated pushes are exact functions of θ0 and wear; recorded ones scatter about "
        "it too (Table III). "
    )
    return (
        "Paths of the object's centre in equal pushes, in the object's frame before each push (it "
        "starts at the origin and is pushed along -y); a darker shade is a larger turn. In this "
        "frame isotropic friction would give a single path. σ is the standard deviation of (Δθ, "
        "Δx, Δy) over the pushes drawn, in brackets the published one (Table II): "
        f"{'; '.join(spreads)}. "
        f"{'' if all(paths.origin == RECORDED for paths in result) else scatter}"
        f"{material_sentence(result)}"
    )
