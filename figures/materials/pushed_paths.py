"""Paths of an object's centre in the pushes of a collection: recorded where there are files,
simulated where not.
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

from cyclemap.arrays import Array, evenly_spread, placed
from cyclemap.checks import read_only
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.evidence.pushes.mit_names import push_facts
from cyclemap.evidence.recorded_push import MIT_TARGET
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import cross
from cyclemap.views.sentences import angle, listed

from ..catalogue import MeasuredFolder
from .paper_pushes import (
    measured_run,
    measured_theta0,
    not_found,
    push_file_names,
    readable_pushes,
)
from .simulated_collections import NOISE, PAPER, STANDS_FOR, Sampling, sampled_run

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
    theta0, turn : (k,) rad, before the push, and of the push.
    object_frame : (k, m, 2) m, in the object's frame before the push.
    robot_frame : (k, m, 2) m, in the world, from the reset's target.
    orientations : (n,) rad, θ0 of all cycles of the run from which the pushes were taken at equal
        distances.
    """

    surface: str
    material: str
    origin: str
    theta0: Array
    turn: Array
    object_frame: Array
    robot_frame: Array
    orientations: Array

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
        names of the MIT dataset, as `measured_run` does, θ0 as `measured_theta0` does.
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
    `measured_run` finds none.

    Of the files chosen those that cannot be read are left out.
    orientations : those of all the recorded pushes.
    """
    run = measured_run(measured, surface)
    if run is None:
        return None
    # A folder may hold others than the set, too: their names say other things than all of its
    # pushes share.
    shared = run.pushes.facts.items()
    named = [(path, push_facts(path)) for path in push_file_names(run.pushes.source)]
    files = [
        path
        for path, facts in named
        if all(getattr(facts, name) == value for name, value in shared)
    ]
    records, _ = readable_pushes(files[index] for index in evenly_spread(len(files), drawn))
    courses = []
    for _, record in records:
        # At equal times.
        clock = record.object_pose[:, 0]
        pose = np.column_stack([record.object_pose[:, 1:3], record.object_angle])
        courses.append(_at(np.linspace(clock[0], clock[-1], STATIONS), clock, pose))
    poses = np.array(courses)
    poses[..., :2] -= MIT_TARGET
    return _paths(surface, "", RECORDED, poses, run.pushes.theta)


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
        poses.append(_at(travel, course.path, course.pose))
    return _paths(surface, loop.material.name, origin, np.array(poses), theta)


def _at(places: Array, along: Array, values: Array) -> Array:
    """Values (n, k), known along a way (n,), at some places of it (m,): (m, k)."""
    return np.stack([np.interp(places, along, column) for column in values.T], axis=-1)


def _paths(
    surface: str, material: str, origin: str, poses: Array, orientations: Array
) -> PushedPaths:
    """Paths of pushes with poses (k, m, 3)."""
    theta0, robot_frame = poses[:, 0, 2], poses[..., :2]
    back = np.stack([np.zeros_like(theta0), np.zeros_like(theta0), -theta0])
    object_frame = placed(back[:, :, None], robot_frame - robot_frame[:, :1])
    turn = poses[:, -1, 2] - theta0
    arrays = map(read_only, (theta0, turn, object_frame, robot_frame, orientations))
    return PushedPaths(surface, material, origin, *arrays)


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
    by_origin = {
        origin: [paths for paths in surfaces if paths.origin == origin] for origin in ORIGINS
    }
    recorded, started, simulated = by_origin.values()
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
