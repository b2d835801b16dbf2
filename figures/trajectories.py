"""Figs. 3 and 4: paths of the pushed object's centre on the paper's four surfaces, in the object's
own frame before the push, and in the robot's, where they seldom cross.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cyclemap.arrays import (
    TWO_PI,
    Array,
    along_way,
    evenly_spread,
    shorter_way,
    stretches,
    turned,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.evidence.laws.turn_bins import angle_histogram
from cyclemap.evidence.pushes.recordings import push_facts
from cyclemap.evidence.recorded_push import MIT_TARGET
from cyclemap.views.panels.layout import entitle, page, rows_of
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import FORCE, cross, picture_style, show_window
from cyclemap.views.sentences import angle, listed

from . import Exhibit, MeasuredFolder
from .repeated_pushes import (
    NOISE,
    PAPER,
    STANDS_FOR,
    Sampling,
    measured_theta0,
    not_found,
    published_statistics,
    push_file_names,
    readable_pushes,
    recorded_set,
    sampled_run,
)

DRAWN = 250
RECORDED, MEASURED_THETA0, SIMULATED = "recorded", "from measured θ0", "simulated"
STATIONS = 41
_ACCURACY = 1e-6
ORIGINS = (RECORDED, MEASURED_THETA0, SIMULATED)
# From a blue that still shows on white to nearly black: a darker shade is a larger turn, in a grey
# print too.
SHADES = ListedColormap(colormaps["YlGnBu"](np.linspace(0.32, 1.0, 256)))


@dataclass(frozen=True, eq=False)
class PushedPaths:
    """Paths of the object's centre in k pushes on one surface.

    surface : as the paper names it.
    material : what was simulated, "" where the pushes are recorded ones.
    origin : of the pushes, `RECORDED`, `MEASURED_THETA0` (simulated from measured orientations) or
        `SIMULATED`.
    poses : (k, m, 3) m, m, rad, in the world, from the reset's target.
    orientations : (n,) rad, θ0 of all cycles of the run from which the pushes were taken at equal
        distances.
    """

    surface: str
    material: str
    origin: str
    poses: Array
    orientations: Array

    @property
    def theta0(self) -> Array:
        """Orientations (k,) before the push, rad."""
        return self.poses[:, 0, 2]

    @property
    def turn(self) -> Array:
        """Turns (k,) of the push, rad."""
        return self.poses[:, -1, 2] - self.theta0

    @property
    def robot_frame(self) -> Array:
        """Paths (k, m, 2) in the world, m."""
        return self.poses[..., :2]

    @property
    def object_frame(self) -> Array:
        """Paths (k, m, 2) in the object's frame before the push, m."""
        return turned(self.robot_frame - self.robot_frame[:, :1], -self.theta0[:, None])

    @property
    def spread(self) -> Array:
        """Standard deviations (3,) of turn (rad), dx and dy (m, in the object's frame) over the
        pushes.
        """
        return np.array([self.turn.std(), *self.object_frame[:, -1].std(axis=0)])


def paths_on_four_surfaces(
    measured: MeasuredFolder, sampling: Sampling = PAPER, drawn: int = DRAWN
) -> list[PushedPaths]:
    """Return the paths on the paper's four surfaces: of recorded pushes, else from measured θ0,
    else of a run.

    sampling : of a simulated run.
    drawn : how many of all these pushes, at equal distances. Recorded pushes are looked for by the
        names of the MIT dataset, as `recorded_set` does, θ0 as `measured_theta0` does.
    """
    return [
        recorded_paths(measured, surface, drawn)
        or paths_from_measured_theta0(measured, surface, drawn)
        or simulated_paths(surface, sampling, drawn)
        for surface in STANDS_FOR
    ]


def recorded_paths(
    measured: MeasuredFolder, surface: str, drawn: int = DRAWN
) -> PushedPaths | None:
    """Return paths of `drawn` of the recorded pushes on `surface`, evenly chosen; None where
    `recorded_set` finds none.

    Of the files chosen those that cannot be read are left out.
    orientations : those of all the recorded pushes.
    """
    pushes = recorded_set(measured, surface)
    if pushes is None:
        return None
    # A folder may hold others than the set, too: their names say other things than all of its
    # pushes share.
    files = []
    for path in push_file_names(pushes.source):
        facts = push_facts(path)
        if all(getattr(facts, name) == value for name, value in pushes.facts.items()):
            files.append(path)
    records, _ = readable_pushes(files[index] for index in evenly_spread(len(files), drawn))
    courses = []
    for _, record in records:
        # At equal times.
        clock = record.object_pose[:, 0]
        pose = np.column_stack([record.object_pose[:, 1:3], record.object_angle])
        courses.append(along_way(np.linspace(clock[0], clock[-1], STATIONS), clock, pose))
    poses = np.array(courses)
    poses[..., :2] -= MIT_TARGET
    return PushedPaths(surface, "", RECORDED, poses, pushes.theta)


def paths_from_measured_theta0(
    measured: MeasuredFolder, surface: str, drawn: int = DRAWN
) -> PushedPaths | None:
    """Return paths simulated from `drawn` of the measured θ0, on the surface as worn as it then
    was; None without θ0.

    orientations : all the measured ones.
    """
    pairs = measured_theta0(measured, surface)
    if pairs is None or pairs.path is None or pairs.path_cycle is None:
        return None
    loop = CollectionLoop.mit(STANDS_FOR[surface], accuracy=_ACCURACY)
    return _simulated(surface, loop, MEASURED_THETA0, pairs.path, pairs.path_cycle, drawn)


def simulated_paths(surface: str, sampling: Sampling = PAPER, drawn: int = DRAWN) -> PushedPaths:
    """Return paths of pushes of a noisy simulated run on `surface`, a `sampled_run`."""
    run = sampled_run(STANDS_FOR[surface], sampling)
    pairs = run.pushes.pairs
    assert pairs is not None and pairs.path_cycle is not None
    loop = CollectionLoop.mit(run.material, accuracy=_ACCURACY)
    return _simulated(surface, loop, SIMULATED, pairs.theta, pairs.path_cycle[:-1], drawn)


def _simulated(
    surface: str, loop: CollectionLoop, origin: str, theta: Array, cycle: Array, drawn: int
) -> PushedPaths:
    """Paths of `drawn` of the pushes from orientations (n,) at cycles (n,) of the wear.

    At equal distances of the rod's stroke; the object rests where the rod has left it.
    """
    chosen = evenly_spread(theta.size, drawn)
    travel, poses = np.linspace(0.0, loop.push.distance, STATIONS), []
    for start, now in zip(theta[chosen].tolist(), cycle[chosen].tolist(), strict=True):
        worn = worn_loop(loop, now)
        course = worn.model.push(worn.start_pose(start), worn.push, float(travel[1])).trajectory
        poses.append(along_way(travel, course.path, course.pose))
    return PushedPaths(surface, loop.material.name, origin, np.array(poses), theta)


def crossing_pairs(paths: Array, apart: NDArray[np.bool_]) -> tuple[int, int]:
    """Return how many pairs of paths (k, m, 2) cross, and how many there are, among those with
    `apart` (k, k) true.

    Paths that meet at an end do not cross there.

    >>> rising, falling = [[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]
    >>> paths = np.array([rising, falling, [[2.0, 0.0], [2.0, 1.0]]])
    >>> crossing_pairs(paths, np.ones((3, 3), dtype=bool))
    (1, 3)
    """

    def side(a: Array, b: Array, point: Array) -> Array:
        """Twice the area of the triangles a, b, point: positive where the point lies left of the
        way from a to b.
        """
        return np.asarray(
            (b - a)[..., 0] * (point - a)[..., 1] - (b - a)[..., 1] * (point - a)[..., 0]
        )

    later = np.triu(apart, 1)
    crossed = 0
    for path, row in zip(paths, later, strict=True):
        a, b = path[:-1, None], path[1:, None]
        c, d = paths[row][:, None, :-1], paths[row][:, None, 1:]
        crossings = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
        crossed += int(np.sum(np.any(crossings, axis=(1, 2))))
    return crossed, int(np.sum(later))


def shades_of(surfaces: list[PushedPaths]) -> ScalarMappable:
    """The shades of the turns (degrees) of all pushes, from the least to the largest in whole
    degrees.
    """
    turns = np.degrees(np.concatenate([paths.turn for paths in surfaces]))
    return ScalarMappable(Normalize(np.floor(turns.min()), np.ceil(turns.max())), SHADES)


def shade_bar(figure: Figure, panels: list[Axes], shades: ScalarMappable) -> None:
    """The bar of shades at the right of all panels."""
    bar = figure.colorbar(shades, ax=panels, label="Δθ, turn of the push (°)", shrink=0.6)
    bar.ax.grid(visible=False)


def draw_paths(axes: Axes, lines: Array, turn: Array, shades: ScalarMappable) -> None:
    """Draw paths (k, m, 2) m from the cross, in millimetres, each in the shade of its turn (k,)
    rad.
    """
    collection = LineCollection(
        list(MM * lines), colors=shades.to_rgba(np.degrees(turn)), linewidths=0.7, alpha=0.75
    )
    axes.add_collection(collection)
    cross(axes)
    axes.set_aspect("equal")


def material_sentence(surfaces: list[PushedPaths]) -> str:
    """What is recorded, what was simulated in its stead, and why plywood stands as it does."""
    recorded, started, simulated = (
        [paths for paths in surfaces if paths.origin == origin] for origin in ORIGINS
    )
    words = [f"Recorded pushes: {listed(paths.surface for paths in recorded)}."] if recorded else []
    words.append(not_found("pushes", [paths.surface for paths in (*started, *simulated)]))
    for paths in started:
        words.append(
            f"Simulated instead: on {paths.material} from {len(paths.theta0)} of the "
            f"{len(paths.orientations)} measured orientations of {paths.surface}, at equal "
            "distances."
        )
    if simulated:
        names, count = listed(paths.material for paths in simulated), len(simulated[0].orientations)
        words.append(
            f"Simulated as a whole: {names}, {len(simulated[0].theta0)} pushes at equal distances "
            f"in a run of {count} cycles with {angle(NOISE.sigma)} of noise each."
        )
    if any(paths.material == "plywood-measured" for paths in surfaces):
        words.append(
            "Plywood is the one inferred from the measured orientations, wearing as it did: with "
            "Table I a run stays in one direction, where the measured one climbs through all of "
            "them."
        )
    return " ".join(filter(None, words))


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
    crowded = angle_histogram(orientations, _BINS).density * TWO_PI >= CROWDED
    # Counted from outside of any arc, so that none is cut in two.
    outside, width = int(np.argmin(crowded)), TWO_PI / _BINS
    arcs = []
    for first, end in stretches(np.roll(crowded, -outside)):
        begin = width * ((outside + first) % _BINS)
        arcs.append((begin, begin + width * (end - first)))
    return arcs


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
    inside = np.mod(paths.theta0 - arc[0], TWO_PI) <= arc[1] - arc[0]
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
