"""The dynamic simulation: paths on plywood and on isotropic friction (Figs. 11 and 12), and what
inertia changes against the quasi-static model.
"""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.collection.batch_experiment import BATCHES, CYCLES, BatchExperiment, batch_experiment
from cyclemap.collection.dynamic_loop import (
    DynamicLoop,
    DynamicsComparison,
    compare_dynamics,
    isotropic_twin,
)
from cyclemap.collection.loop import CollectionLoop
from cyclemap.views.experiment_page import (
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
from cyclemap.views.panels.style import (
    FOURTH,
    LINE,
    THIRD,
    picture_style,
    plain_ticks,
    square_window,
)

from .catalogue import Exhibit, MeasuredFolder


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
        first, second = (
            np.polyfit(np.log(self.speeds), np.log(row), 1)[0] for row in self.differences
        )
        return float(first), float(second)


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
    theta, some = (2.0 * np.pi * np.arange(count) / count for count in (orientations, fewer))
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
        f"{_at_most(study.material)} on plywood, {_at_most(study.isotropic)} on isotropic "
        f"friction. The difference of a cycle falls with the speed to the power {first:.2f} on "
        f"plywood and {second:.2f} on isotropic friction: inertia enters as the speed squared. At "
        f"{slowest} mm/s {left:.3f}° are left."
    )


def _at_most(comparison: DynamicsComparison) -> str:
    push, drag, cycle = (
        math.degrees(largest(comparison.difference(name)))
        for name in ("push_turn", "drag_turn", "theta_next")
    )
    place = 1e3 * largest(comparison.difference("push_displacement"))
    return (
        f"at most {push:.2f}° in the push, {drag:.2f}° in the drag, {cycle:.2f}° in the cycle "
        f"and {place:.2f} mm"
    )


EXHIBITS = {
    "anisotropic-against-isotropic": Exhibit(paper_experiment, experiment_caption, draw_experiment),
    "dynamic-against-quasi-static": Exhibit(inertia_study, inertia_caption, draw_inertia),
}
