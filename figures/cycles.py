"""The set-up of the repeated push, to scale, and two cycles of push and drag that follow each
other.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array, even_angles, placed, turned
from cyclemap.collection.dynamic_loop import (
    BATCHES,
    CYCLES,
    BatchExperiment,
    DynamicLoop,
    DynamicsComparison,
    batch_experiment,
    compare_dynamics,
)
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.collection.loop_surfaces import isotropic_twin
from cyclemap.mechanics import Trajectory
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.views.experiment_page import (
    differences,
    draw_paths,
    draw_place_differences,
    draw_turn_differences,
    experiment_headline,
    isotropic_sentence,
    largest,
    method_line,
    named_runs,
    spread_sentence,
)
from cyclemap.views.panels.layout import Panel, entitle, page, picture
from cyclemap.views.panels.scene import MM, draw_object, draw_setup, mark_target
from cyclemap.views.panels.style import (
    FORCE,
    FOURTH,
    INK,
    LINE,
    PREDICTED,
    QUIET,
    THIRD,
    Look,
    arrow,
    picture_style,
    plain_ticks,
    square_window,
)
from cyclemap.views.sentences import angle

from . import Exhibit, MeasuredFolder

# Where the first cycle starts: there the cycle turns the object enough to be seen.
START = math.radians(270.0)
# The shade of the first cycle and of the second, by lightness.
_CYCLE_COLOURS = (QUIET, PREDICTED)
_ARROW, _WORDS = 38.0, 46.0
_NAMES = (("k", "ᵏ"), ("k+1", "ᵏ⁺¹"))


@dataclass(frozen=True, eq=False)
class SetupAndCycles:
    """The loop, and two cycles of it, the second from where the first ended."""

    loop: CollectionLoop
    cycles: tuple[Cycle, Cycle]

    @property
    def contact(self) -> Array:
        """(2,) m, where the rod first touches, in the object's frame."""
        # A rod without thickness touches where its centre is.
        return first_contact(self.loop.slider, self.loop.push, 0.0)[0]


def compute(measured: MeasuredFolder) -> SetupAndCycles:
    """Run two cycles of the MIT loop on plywood from `START`; nothing here is measured."""
    loop = CollectionLoop.mit("plywood")
    first = loop.cycle(START)
    return SetupAndCycles(loop, (first, loop.cycle(first.theta_next)))


@picture_style()
def draw(result: SetupAndCycles) -> Figure:
    """Draw the set-up in the object's frame on the left, the two cycles in the world on the
    right."""
    figure, (setup, cycles) = page("ab", size=(11.0, 5.9), keys=2)
    draw_setup(setup, result.loop)
    _draw_lengths(setup, result)
    _draw_cycles(cycles, result)
    return figure


def _draw_lengths(axes: Axes, result: SetupAndCycles) -> None:
    """The lengths of the set-up, and the ring's distance from the centre."""
    loop, contact = result.loop, MM * result.contact
    hitch, (left, low) = MM * np.array(loop.slider.hitch), MM * loop.slider.outline.points(4).min(0)
    axes.plot([0.0, hitch[0]], [0.0, hitch[1]], color=QUIET, linewidth=1.0, linestyle="--")
    _dimension(axes, contact[0], 0.0, contact[1] + 22.0)
    _dimension(axes, left, -left, low - 15.0)


def _dimension(axes: Axes, start: float, end: float, level: float) -> None:
    """A level line with arrows at both ends and its length."""
    look = {"arrowstyle": "<->", "color": INK, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=(end, level), xytext=(start, level), arrowprops=look)
    middle, length = 0.5 * (start + end), f"{abs(end - start):.0f} mm"
    axes.text(middle, level + 2.0, length, fontsize=8, ha="center", va="bottom")


def _draw_cycles(axes: Axes, result: SetupAndCycles) -> None:
    corners = []
    outline = result.loop.slider.outline_points()
    shown = zip(result.cycles, _NAMES, _CYCLE_COLOURS, strict=True)
    for cycle, (index, raised), colour in shown:
        push, drag = cycle.trajectory.push, cycle.trajectory.drag
        for pose, width in zip(push.pose[[0, -1]], (1.6, 0.7), strict=True):
            look: Look = {"facecolor": "none", "edgecolor": colour, "linewidth": width}
            draw_object(axes, placed(pose, outline), **look)
        _path(axes, push, colour, "-", f"push {index}")
        _path(axes, drag, colour, (0, (4, 2)), f"drag back {index}")
        tip = MM * push.pusher[0]
        # The touched side's inward normal is -y in the object's frame.
        way = turned(np.array([0.0, -1.0]), cycle.theta + result.loop.push.angle)
        corners.append(tip - (_ARROW + _WORDS) * way)
        arrow(axes, tip - _ARROW * way, tip, FORCE, 2.2, 8)
        words = f"push {index}, from\nθ₀{raised} = {angle(cycle.theta, 0)}"
        x, y = (tip - (_ARROW + 4.0) * way).tolist()
        lean = "right" if way[0] > 0.3 else "left" if way[0] < -0.3 else "center"
        axes.text(x, y, words, color=FORCE, fontsize=9, ha=lean, va="center", zorder=8)
    mark_target(axes)
    square_window(axes, np.vstack([axes.dataLim.get_points(), *corners]))
    axes.set(xlabel="x (mm), world frame", ylabel="y (mm)")
    entitle(axes, "Path of the centre in cycles k and k+1")


def _path(axes: Axes, course: Trajectory, colour: str, dash: object, label: str) -> None:
    path = MM * course.pose[:, :2]
    axes.plot(*path.T, color=colour, linestyle=dash, linewidth=2.2, label=label, zorder=5)
    middle = len(path) // 2
    arrow(axes, path[middle - 1], path[middle + 1], colour, zorder=6, mutation_scale=13)


def caption(result: SetupAndCycles) -> str:
    """The lengths of the set-up, and how the orientation goes from one cycle to the next."""
    loop, (first, second) = result.loop, result.cycles
    angles = [
        math.degrees(turn) for turn in (first.theta, first.push_turn, first.drag_turn, second.theta)
    ]
    return (
        f"Left: a square of {MM * np.ptp(loop.slider.outline.points(4)[:, 0]):.0f} mm is pushed "
        f"over {MM * loop.push.distance:.0f} mm at side {loop.push.side}, "
        f"{MM * abs(result.contact[0]):.0f} mm from its middle, and dragged back by a ring "
        f"{MM * math.hypot(*loop.slider.hitch):.0f} mm from its centre; the size of the ring is "
        "not published, that drawn is free. Right: path of the centre in two cycles that follow "
        f"each other, solid in the push, dashed in the drag, computed on {loop.material.name}. "
        "Arrows are the directions of the pushes, alike in the object's frame; beside them, the "
        f"orientation before the push. From θ0 = {angles[0]:.0f}° the push turns the object by "
        f"{angles[1]:.1f}°, the drag by {angles[2]:.1f}°, so that the next push starts at "
        f"{angles[3]:.1f}°: the ring is back at its target, the centre is not where it was."
    )


def paper_experiment(
    measured: MeasuredFolder, batches: int = BATCHES, cycles: int = CYCLES
) -> BatchExperiment:
    """Run the paper's numerical experiment by the dynamic simulation; it uses no measured data."""
    return batch_experiment(DynamicLoop(CollectionLoop.mit(material="plywood")), batches, cycles)


@picture_style()
def draw_experiment(experiment: BatchExperiment) -> Figure:
    """Draw the paths in the robot's frame above, in the object's frame below."""
    figure, panels = page("ab;cd", size=(7.5, 7.5))
    for column, (run, name) in enumerate(named_runs(experiment)):
        draw_paths(panels[column], run)
        entitle(panels[column], f"{name}, robot's frame")
        draw_paths(panels[2 + column], run, in_object=True)
        entitle(panels[2 + column], f"{name}, object's frame")
    for row in (panels[:2], panels[2:]):
        corners = np.vstack([axes.dataLim.get_points() for axes in row])
        for axes in row:
            square_window(axes, corners)
    return figure


def experiment_caption(experiment: BatchExperiment) -> str:
    """What the experiment shows, with its numbers."""
    loop = experiment.loop
    return (
        f"Paths of the centre of mass in simulated pushes on {loop.material.name} (left) and on "
        f"isotropic friction (right; {method_line(experiment)}); thick: the last push of each "
        f"batch. {experiment_headline(experiment)} {spread_sentence(experiment)} "
        f"{isotropic_sentence(experiment)}"
    )


ORIENTATIONS = 12
# Of the rod, m/s.
SPEEDS = (0.005, 0.01, 0.02, 0.04, 0.08)
# Contact and friction sharper than by default, so that nothing but inertia is left at the lowest
# speed.
_STIFFNESS, _REGULARISATION, _TOLERANCE = 4e6, 2e-5, 1e-7


@dataclass(frozen=True, eq=False)
class InertiaStudy:
    """The comparison at the experiment's speed, and the largest difference of a cycle's turn over
    speed.

    material, isotropic : by orientation, at 20 mm/s.
    speeds : (k,) m/s.
    differences : (2, k) rad, largest over the orientations, on the material and on isotropic
        friction.
    """

    material: DynamicsComparison
    isotropic: DynamicsComparison
    speeds: Array
    differences: Array

    @property
    def orders(self) -> tuple[float, float]:
        """Exponents of the speed that the differences follow, by least squares in logarithms."""
        first, second = np.polyfit(np.log(self.speeds), np.log(self.differences).T, 1)[0].tolist()
        return first, second


def inertia_study(
    measured: MeasuredFolder,
    orientations: int = ORIENTATIONS,
    speeds: tuple[float, ...] = SPEEDS,
    fewer: int = 3,
) -> InertiaStudy:
    """Compare both models on plywood and its isotropic twin; over speed from `fewer` orientations.
    No measured data.
    """
    loop = DynamicLoop(CollectionLoop.mit(material="plywood"))
    twin = replace(loop, loop=isotropic_twin(loop.loop))
    theta, some = (even_angles(count) for count in (orientations, fewer))
    differences = np.empty((2, len(speeds)))
    for row, each in zip(differences, (loop, twin), strict=True):
        slower = (
            DynamicLoop(
                each.loop, speed, _STIFFNESS, regularisation=_REGULARISATION, tolerance=_TOLERANCE
            )
            for speed in speeds
        )
        row[:] = [largest(compare_dynamics(slow, some).difference("theta_next")) for slow in slower]
    return InertiaStudy(
        compare_dynamics(loop, theta), compare_dynamics(twin, theta), np.array(speeds), differences
    )


def draw_inertia(study: InertiaStudy) -> Figure:
    """Draw the differences over θ0, and their fall with the speed."""
    both = study.material, study.isotropic
    panels: list[Panel] = [
        ("Difference of the turns", partial(draw_turn_differences, both=both)),
        ("Difference of the displacement", partial(draw_place_differences, both=both)),
        ("Its fall with the speed", partial(_draw_fall, study=study)),
    ]
    foot = "left and middle at 20 mm/s: solid, filled: plywood; dashed, open: isotropic friction"
    return picture("abc", panels, foot=foot, size=(11.0, 4.5), keys=2)


def _draw_fall(axes: Axes, study: InertiaStudy) -> None:
    speeds = 1e3 * study.speeds
    looks = (("plywood", "o", LINE), ("isotropic", "s", THIRD))
    for values, (name, marker, look) in zip(np.degrees(study.differences), looks, strict=True):
        axes.plot(speeds, values, marker=marker, label=name, **look)
    guide = np.degrees(study.differences[0, -1]) * (speeds / speeds[-1]) ** 2
    axes.plot(speeds, 0.5 * guide, label="speed squared", **FOURTH)
    axes.set(xlabel="speed of the rod (mm/s)", ylabel="largest difference of a cycle (°)")
    axes.set(xscale="log", yscale="log")
    plain_ticks(axes.xaxis, speeds.tolist())


def inertia_caption(study: InertiaStudy) -> str:
    """How far inertia matters, with the numbers of the study."""
    speed = 1e3 * study.material.loop.speed
    first, second = study.orders
    slowest = f"{1e3 * study.speeds.min():g}"
    left = math.degrees(float(study.differences[:, int(study.speeds.argmin())].max()))
    return (
        f"The paper's dynamic simulation less the quasi-static model at {speed:g} mm/s: "
        f"{differences(study.material, 2)} on plywood, {differences(study.isotropic, 2)} on "
        "isotropic friction. The difference of a cycle falls with the speed to the power "
        f"{first:.2f} on plywood and {second:.2f} on isotropic friction: inertia enters as the "
        f"speed squared. At {slowest} mm/s {left:.3f}° are left."
    )


EXHIBITS = {
    "setup-and-cycle": Exhibit(compute, caption, draw),
    "anisotropic-against-isotropic": Exhibit(paper_experiment, experiment_caption, draw_experiment),
    "dynamic-against-quasi-static": Exhibit(inertia_study, inertia_caption, draw_inertia),
}
