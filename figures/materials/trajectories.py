"""Figs. 3 and 4: paths of the pushed object's centre on the paper's four surfaces, in the object's
own frame before the push, and in the robot's, where they seldom cross.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array, evenly_spread, shorter_way
from cyclemap.evidence.laws.turn_bins import angle_histogram
from cyclemap.views.panels.layout import entitle, page, rows_of
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import FORCE, picture_style, show_window
from cyclemap.views.sentences import angle

from ..catalogue import Exhibit, MeasuredFolder
from .paper_pushes import published_statistics
from .pushed_paths import (
    DRAWN,
    RECORDED,
    PushedPaths,
    crossing_pairs,
    draw_paths,
    material_sentence,
    paths_on_four_surfaces,
    shade_bar,
    shades_of,
)
from .simulated_collections import PAPER, Sampling


@picture_style()
def draw_object_frame(result: list[PushedPaths]) -> Figure:
    """Draw four panels on one scale, y down the push, a darker shade for a larger turn."""
    ends = MM * np.concatenate([paths.object_frame.reshape(-1, 2) for paths in result])
    low, high = ends.min(axis=0) - 4.0, ends.max(axis=0) + 4.0
    figure, panels = page(rows_of(len(result)), size=(11.6, 5.5))
    shades = shades_of(result)
    for axes, paths in zip(panels, result, strict=True):
        draw_paths(axes, paths.object_frame, paths.turn, shades)
        show_window(axes, low, high)
        axes.set(xlabel="x (mm)", ylabel="y (mm), object's frame before the push")
        axes.label_outer()
        axes.set_title(f"{paths.surface},\n{paths.origin}")
        turn, dx, dy = paths.spread
        words = f"σ(Δθ) {angle(turn)}\nσ(Δx) {MM * dx:.1f} mm\nσ(Δy) {MM * dy:.1f} mm"
        axes.text(0.97, 0.97, words, transform=axes.transAxes, ha="right", va="top", fontsize=8)
    shade_bar(figure, panels, shades)
    return figure


def object_frame_caption(result: list[PushedPaths]) -> str:
    """What is shown, how far the ends spread, and what is published of that."""
    spreads, units = [], ((float(np.degrees(1.0)), "°"), (MM, " mm"), (MM, " mm"))
    for paths in result:
        both = zip(paths.spread, published_statistics(paths.surface).std, units, strict=True)
        words = ", ".join(
            f"{unit * here:.1f}{name} ({unit * there:.1f})" for here, there, (unit, name) in both
        )
        spreads.append(f"{paths.surface} {words}")
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


Arc = tuple[float, float]

# A direction is crowded where it is recorded this many times as often as if all were recorded
# alike.
CROWDED = 2.0
# Crossings are counted among so many pushes, between those whose θ0 differ by at least so much
# (rad).
COUNTED, APART = 60, np.deg2rad(5.0)
_BINS = 36
_MARK_GAP = 8.0


@dataclass(frozen=True)
class RobotFramePaths:
    """The pushes on each surface, the crowded arcs of θ0, and how many pairs of paths cross.

    arcs : for each surface, (begin, end) in rad, begin in [0, 2π).
    crossed : for each surface, pairs of paths that cross in the robot's frame, in the object's
        frame, and pairs looked at.
    """

    surfaces: list[PushedPaths]
    arcs: list[list[Arc]]
    crossed: list[tuple[int, int, int]]


def robot_frame(
    measured: MeasuredFolder, sampling: Sampling = PAPER, drawn: int = DRAWN
) -> RobotFramePaths:
    """Run or read the pushes on the four surfaces, `drawn` of a run, and count their
    crossings.
    """
    surfaces = paths_on_four_surfaces(measured, sampling, drawn)
    crossed = []
    for paths in surfaces:
        chosen = evenly_spread(len(paths.theta0), COUNTED)
        theta = paths.theta0[chosen]
        apart = np.abs(shorter_way(theta - theta[:, None])) >= APART
        # Every second station: the paths bend too little between them to hide a crossing.
        here, pairs = crossing_pairs(paths.robot_frame[chosen, ::2], apart)
        crossed.append((here, crossing_pairs(paths.object_frame[chosen, ::2], apart)[0], pairs))
    return RobotFramePaths(
        surfaces, [crowded_arcs(paths.orientations) for paths in surfaces], crossed
    )


def crowded_arcs(orientations: Array) -> list[Arc]:
    """Return the arcs (begin, end), rad, of orientations that are crowded, in bins of 10 degrees.

    >>> (arc,) = crowded_arcs(np.array([0.1, 0.02, -0.02]))
    >>> [round(float(np.degrees(end))) for end in arc]
    [350, 370]
    """
    histogram = angle_histogram(orientations, _BINS)
    crowded = histogram.density * (2 * np.pi) >= CROWDED
    size = crowded.size
    begins = np.flatnonzero(crowded & ~np.roll(crowded, 1))
    widths = [
        next(k for k in range(1, size + 1) if not crowded[(first + k) % size])
        for first in begins.tolist()
    ]
    return [
        (float(histogram.edges[first]), float(histogram.edges[first] + width * 2 * np.pi / size))
        for first, width in zip(begins.tolist(), widths, strict=True)
    ]


@picture_style()
def draw_robot_frame(result: RobotFramePaths) -> Figure:
    """Draw four panels on one scale, the crowded directions marked outside the ends
    of the paths."""
    reach = max(float(np.abs(paths.robot_frame).max()) for paths in result.surfaces)
    window = MM * reach + 2.5 * _MARK_GAP
    figure, panels = page("ab;cd", size=(8.8, 8.6))
    shades = shades_of(result.surfaces)
    for axes, paths, arcs in zip(panels, result.surfaces, result.arcs, strict=True):
        draw_paths(axes, paths.robot_frame, paths.turn, shades)
        for arc in arcs:
            _mark(axes, paths, arc)
        axes.set(xlim=(-window, window), ylim=(-window, window), xlabel="x (mm)", ylabel="y (mm)")
        entitle(axes, f"{paths.surface}, {paths.origin}")
    shade_bar(figure, panels, shades)
    return figure


def _mark(axes: Axes, paths: PushedPaths, arc: Arc) -> None:
    """A thick arc about the target, outside the ends of the paths that start within
    an arc of θ0."""
    end = paths.robot_frame[:, -1]
    inside = np.mod(paths.theta0 - arc[0], 2 * np.pi) <= arc[1] - arc[0]
    if not inside.any():
        return
    ahead = shorter_way(np.arctan2(end[inside, 1], end[inside, 0]) - paths.theta0[inside])
    middle = float(np.angle(np.mean(np.exp(1j * ahead))))
    radius = MM * float(np.hypot(*end[inside].T).max()) + _MARK_GAP
    angle = np.linspace(*arc, 60) + middle
    label = "where pushes from crowded θ0 end"
    axes.plot(
        radius * np.cos(angle),
        radius * np.sin(angle),
        label=label,
        color=FORCE,
        linewidth=4.0,
        solid_capstyle="butt",
    )


def robot_frame_caption(result: RobotFramePaths) -> str:
    """What is shown, where it is crowded, and how many paths cross."""
    marked = []
    for paths, arcs in zip(result.surfaces, result.arcs, strict=True):
        places = ", ".join(f"{angle(begin, 0)} to {angle(end, 0)}" for begin, end in arcs)
        marked.append(f"{paths.surface} {places or 'nowhere'}")
    here, there, pairs = (sum(column) for column in zip(*result.crossed, strict=True))
    return (
        "Paths of the object's centre in equal pushes, in the robot's frame about the reset's "
        "target (cross); a darker shade is a larger turn. Thick arcs are where those pushes end "
        "whose orientation before the push occurs at least twice as often as if all were alike (in "
        f"bins of 10°): {'; '.join(marked)}. Of {pairs} pairs of paths from orientations "
        f"{angle(APART, 0)} or more apart, {here} cross here and {there} in the object's "
        "frame: seen from the floor the pushes are told apart. "
        f"{material_sentence(result.surfaces)}"
    )


EXHIBITS = {
    "trajectories-object-frame": Exhibit(
        paths_on_four_surfaces, object_frame_caption, draw_object_frame
    ),
    "trajectories-robot-frame": Exhibit(robot_frame, robot_frame_caption, draw_robot_frame),
}
