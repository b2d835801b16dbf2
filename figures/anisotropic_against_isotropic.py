"""Figures 11 and 12 of the paper: paths of the pushed object in simulation, on plywood and on
isotropic friction.
"""

import numpy as np
from matplotlib.figure import Figure

from cyclemap.collection.batch_experiment import BATCHES, CYCLES, BatchExperiment, batch_experiment
from cyclemap.collection.dynamic_loop import DynamicLoop
from cyclemap.collection.loop import CollectionLoop
from cyclemap.views import style
from cyclemap.views.experiment_page import (
    draw_paths,
    experiment_headline,
    isotropic_sentence,
    method_line,
    named_runs,
    spread_sentence,
)

from .catalogue import MeasuredFolder


def compute(
    measured: MeasuredFolder, batches: int = BATCHES, cycles: int = CYCLES
) -> BatchExperiment:
    """Run the paper's numerical experiment by the dynamic simulation; it uses no measured data."""
    return batch_experiment(DynamicLoop(CollectionLoop.mit(material="plywood")), batches, cycles)


@style.picture_style()
def draw(experiment: BatchExperiment) -> Figure:
    """Draw the paths in the robot's frame above, in the object's frame below."""
    figure = style.new_figure(7.5, 7.5)
    panels = style.panels(figure, "ab;cd")
    for column, (run, name) in enumerate(named_runs(experiment)):
        draw_paths(panels[column], run, f"{name}, robot's frame")
        draw_paths(panels[2 + column], run, f"{name}, object's frame", in_object=True)
    for row in (panels[:2], panels[2:]):
        corners = np.vstack([axes.dataLim.get_points() for axes in row])
        for axes in row:
            style.square_window(axes, corners)
    return figure


def caption(experiment: BatchExperiment) -> str:
    """What the experiment shows, with its numbers."""
    loop = experiment.loop
    return (
        f"Paths of the centre of mass in simulated pushes on {loop.material.name} (left) and on "
        f"isotropic friction (right; {method_line(experiment)}); thick: the last push of each "
        f"batch. {experiment_headline(experiment)} {spread_sentence(experiment)} "
        f"{isotropic_sentence(experiment)}"
    )
