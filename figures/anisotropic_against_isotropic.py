"""Figures 11 and 12 of the paper: paths of the pushed object in simulation, on plywood and on
isotropic friction.
"""

import numpy as np
from matplotlib.figure import Figure

from cyclemap.collection.batch_experiment import BATCHES, CYCLES, BatchExperiment, batch_experiment
from cyclemap.collection.dynamic_loop import DynamicLoop
from cyclemap.collection.loop import CollectionLoop
from cyclemap.views.experiment_page import (
    draw_paths,
    experiment_headline,
    isotropic_sentence,
    method_line,
    named_runs,
    spread_sentence,
)
from cyclemap.views.style import new_figure, picture_style

from .catalogue import MeasuredFolder


def compute(
    measured: MeasuredFolder, batches: int = BATCHES, cycles: int = CYCLES
) -> BatchExperiment:
    """Run the paper's numerical experiment by the dynamic simulation; it uses no measured data."""
    return batch_experiment(DynamicLoop(CollectionLoop.mit(material="plywood")), batches, cycles)


def draw(experiment: BatchExperiment) -> Figure:
    """Draw the paths in the robot's frame above, in the object's frame below."""
    with picture_style():
        figure = new_figure(7.5, 7.5)
        panels = figure.subplots(2, 2, gridspec_kw={"wspace": 0.3, "hspace": 0.42})
        figure.subplots_adjust(left=0.1, right=0.98, bottom=0.075, top=0.925)
        for column, (run, name) in enumerate(named_runs(experiment)):
            draw_paths(panels[0, column], run, f"{name}, robot's frame")
            draw_paths(panels[1, column], run, f"{name}, object's frame", in_object=True)
        for row in panels:
            limits = np.array([(*axes.dataLim.min, *axes.dataLim.max) for axes in row])
            low, high = limits[:, :2].min(axis=0), limits[:, 2:].max(axis=0)
            middle, half = (low + high) / 2.0, 0.56 * float((high - low).max())
            for axes in row:
                axes.set_aspect("equal", adjustable="box")
                axes.set(
                    xlim=(middle[0] - half, middle[0] + half),
                    ylim=(middle[1] - half, middle[1] + half),
                )
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
