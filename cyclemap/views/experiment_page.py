"""Numerical experiments: batches of cycles on a material and on its isotropic twin, and dynamic
beside quasi-static cycles; in sentences, and a page each.
"""

import math
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from cyclemap.arrays import Array
from cyclemap.collection.dynamic_loop import WITHIN, BatchExperiment, BatchRun, DynamicsComparison
from cyclemap.views.panels.layout import Panel, picture
from cyclemap.views.panels.scene import draw_way
from cyclemap.views.panels.style import (
    FORCE,
    INK,
    LINE,
    PREDICTED,
    SECOND,
    ZERO,
    Look,
    count_axis,
    degree_axis,
    unwrapped_axis,
)
from cyclemap.views.sentences import angle, counted

_MARKERS = "os^vDP*X"
# On a material, and on its isotropic twin.
Twins = tuple[DynamicsComparison, DynamicsComparison]


def experiment_page(experiment: BatchExperiment) -> Figure:
    """Draw the experiment: on the material above, on its isotropic twin below."""
    words = (
        experiment_headline(experiment),
        spread_sentence(experiment),
        isotropic_sentence(experiment),
    )
    foot = (
        f"{method_line(experiment)}; thin: path of the centre in a push, thick: the last push "
        "of each batch"
    )
    panels: list[Panel] = []
    for run, name in named_runs(experiment):
        panels += [
            (f"{name}: robot's frame", partial(draw_paths, run=run)),
            (f"{name}: object's frame", partial(draw_paths, run=run, in_object=True)),
            (f"{name}: θ0 over the cycles", partial(draw_course, run=run)),
        ]
    title = f"Batches of cycles on {experiment.loop.material.name}"
    return picture("abc;def", panels, title=title, words=words, foot=foot, keys=2)


def named_runs(experiment: BatchExperiment) -> tuple[tuple[BatchRun, str], ...]:
    """The runs on the material and on its isotropic twin, with what they are called."""
    return (experiment.anisotropic, "Anisotropic"), (experiment.isotropic, "Isotropic")


def draw_paths(axes: Axes, run: BatchRun, in_object: bool = False) -> None:
    """Paths of the centre, each batch's last one thick: about the reset's target, or seen from the
    object.
    """
    paths, where = (run.object_path, " in the object's frame") if in_object else (run.path, "")
    for path in paths.reshape(-1, *paths.shape[2:]):
        draw_way(axes, path, color=PREDICTED, linewidth=0.5, alpha=0.45, label="pushes")
    for path in paths[:, -1]:
        draw_way(
            axes,
            path,
            "o-",
            markevery=[0],
            markersize=4.0,
            color=FORCE,
            linewidth=1.8,
            label="last of a batch",
            zorder=3,
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel=f"x{where} (mm)", ylabel=f"y{where} (mm)")


def draw_course(axes: Axes, run: BatchRun) -> None:
    """θ0 over the cycles, unwrapped, a marker a batch."""
    cycles = run.theta.shape[1] - 1
    for index, theta in enumerate(run.theta):
        every = (index * max(cycles // 30, 1), max(cycles // 8, 1))
        look: Look = {"marker": _MARKERS[index % len(_MARKERS)], "markevery": every}
        shade = str(0.65 * index / max(len(run.theta) - 1, 1))
        look |= {"color": shade, "label": f"from {angle(theta[0], 0)}", "clip_on": False}
        axes.plot(np.degrees(theta), linewidth=1.3, markersize=3.5, **look)
    count_axis(axes, "cycle", cycles)
    span = float(np.ptp(np.degrees(run.theta)))
    if span > 300.0:
        axes.yaxis.set_major_locator(MultipleLocator(60.0 * max(1, round(span / 420.0))))
    unwrapped_axis(axes, "θ0, unwrapped")


def experiment_headline(experiment: BatchExperiment) -> str:
    """Where the batches end on the material, and how soon; of batches that end nowhere how far they
    still turn.
    """
    run, cycles = experiment.anisotropic, counted(experiment.cycles, "cycle")
    count, directions = len(run.theta), run.directions()
    if not directions:
        # Of small steps also why they are no rest.
        step = float(run.last_step.max())
        why = ", and such steps do not soon die out" if step <= 0.1 * WITHIN else ""
        turned = f"{angle(step, 2)}{why}."
        if count == 1:
            return (
                f"The batch does not come to rest in {cycles}: the last cycle still turns it "
                f"by {turned}"
            )
        return (
            f"Not every batch comes to rest in {cycles}: the last cycle still turns one by {turned}"
        )
    after = counted(int(run.settled_after().max()), "cycle")
    soon = f"within 1° of it for good after {'' if count == 1 else 'at most '}{after}"
    if len(directions) == 1:
        who = "The batch ends" if count == 1 else f"All {count} batches end"
        return f"{who} at {angle(directions[0])}, {soon}."
    places = ", ".join(angle(direction) for direction in directions)
    return (
        f"The {count} batches end at {len(directions)} directions ({places}), "
        f"{soon.replace('of it', 'of them')}."
    )


def isotropic_sentence(experiment: BatchExperiment) -> str:
    """What the batches do on the isotropic twin, and that they follow one path in the object's
    frame.
    """
    run = experiment.isotropic
    turns = run.theta[:, 1:] - run.theta[:, :-1]
    turned = f"turns the object by {angle(float(turns.mean()), 2)}"
    surface = "On isotropic friction of the same mean coefficient"
    if turns.size == 1:
        return f"{surface} the cycle {turned}."
    return f"{surface} every cycle {turned}, whatever θ0: {_path_clause(run)}."


def spread_sentence(experiment: BatchExperiment) -> str:
    """How far the paths on the material spread in the object's frame."""
    if experiment.anisotropic.theta[:, 1:].size == 1:
        return f"On {experiment.loop.material.name} there is one path, and none to compare it with."
    return f"On {experiment.loop.material.name} {_path_clause(experiment.anisotropic)}."


def method_line(experiment: BatchExperiment) -> str:
    """How the experiment was run."""
    batches = len(experiment.starts)
    total = (
        f"{counted(batches * experiment.cycles, 'cycle')}: {counted(batches, 'batch', 'es')} "
        f"of {experiment.cycles}"
    )
    if experiment.speed is None:
        return f"quasi-static cycles; {total}"
    return f"dynamic simulation at {1e3 * experiment.speed:g} mm/s; {total}"


def length(metres: float) -> str:
    """A small length for people, in mm or µm; a nanometre where it is less.

    >>> length(0.0123), length(4.2e-7), length(3e-12)
    ('12.3 mm', '0.42 µm', '0.001 µm')
    """
    return f"{1e3 * metres:.1f} mm" if metres >= 1e-4 else f"{max(1e6 * metres, 1e-3):.2g} µm"


def _path_clause(run: BatchRun) -> str:
    paths = run.theta[:, 1:].size
    if run.spread < 1e-4:
        return (
            f"seen in the object's frame all {paths} paths are one (none is further than "
            f"{length(run.spread)} off)"
        )
    return (
        f"seen in the object's frame the {paths} paths spread by up to {length(run.spread)} "
        "about their mean"
    )


# Name, colour, marker of each turn that is compared.
_TURNS = (
    ("push_turn", "push", PREDICTED, "o"),
    ("drag_turn", "drag", FORCE, "s"),
    ("theta_next", "push and drag", INK, "^"),
)
_PLACES = ((0, "dx", PREDICTED, "o"), (1, "dy", FORCE, "s"))


def dynamics_page(material: DynamicsComparison, isotropic: DynamicsComparison) -> Figure:
    """Draw the comparison on a material and on its isotropic twin, from the same orientations."""
    name, speed = material.loop.loop.material.name, 1e3 * material.loop.speed
    both = material, isotropic
    foot = (
        "solid, filled: the material; dashed, open: isotropic friction of the same mean "
        "coefficient; both models stand on the same support points"
    )
    panels: list[Panel] = [
        ("Turn of push and drag", partial(draw_both_turns, both=both)),
        ("Difference of the turns", partial(draw_turn_differences, both=both)),
        ("Difference of the displacement", partial(draw_place_differences, both=both)),
    ]
    title = f"Dynamic and quasi-static cycles on {name} at {speed:g} mm/s"
    words = map(difference_sentence, both)
    return picture("abc", panels, title=title, words=words, foot=foot, keys=2)


def draw_both_turns(axes: Axes, both: Twins) -> None:
    """Turns of a cycle over θ0 by both models."""
    for comparison, law, face in zip(
        both, ("material", "isotropic"), (PREDICTED, "w"), strict=True
    ):
        theta = np.degrees(comparison.dynamic.theta)
        still = np.degrees(comparison.quasi_static.theta_next) - theta
        line = SECOND if law == "isotropic" else LINE
        # A curve through one orientation needs a marker, over the dot, to be seen.
        marker = "x" if theta.size == 1 else None
        axes.plot(theta, still, label=f"{law}, quasi-static", **{**line, "marker": marker})
        moved = np.degrees(comparison.dynamic.theta_next) - theta
        axes.plot(
            theta,
            moved,
            "o",
            color=PREDICTED,
            label=f"{law}, dynamic",
            markerfacecolor=face,
            markersize=4.5,
            zorder=3 if marker else 5,
        )
    degree_axis(axes, every=60)
    axes.set_ylabel("turn of a cycle (°)")


def difference_sentence(comparison: DynamicsComparison) -> str:
    """How far the dynamic simulation is from the quasi-static model,
    at most over the orientations."""
    return (
        f"{comparison.loop.loop.material.name}: dynamic and quasi-static differ by "
        f"{differences(comparison, 3)} ({counted(comparison.dynamic.theta.size, 'orientation')})."
    )


def differences(comparison: DynamicsComparison, decimals: int) -> str:
    """The largest differences of both models, in degrees and millimetres."""
    push, drag, cycle = (
        f"{math.degrees(largest(comparison.difference(name))):.{decimals}f}°" for name, *_ in _TURNS
    )
    place = f"{1e3 * largest(comparison.difference('push_displacement')):.{decimals}f} mm"
    return (
        f"at most {push} in the push, {drag} in the drag, {cycle} in the cycle, {place} in the "
        "push's displacement"
    )


def largest(difference: Array) -> float:
    """The largest absolute value."""
    return float(np.abs(difference).max())


def draw_turn_differences(axes: Axes, both: Twins) -> None:
    """Dynamic less quasi-static turns over θ0, on a material and on isotropic friction."""
    curves = [
        ([np.degrees(comparison.difference(name)) for comparison in both], look)
        for name, *look in _TURNS
    ]
    _draw_differences(axes, both, curves, "°")


def draw_place_differences(axes: Axes, both: Twins) -> None:
    """Dynamic less quasi-static displacements of the push over θ0."""
    off = [1e3 * comparison.difference("push_displacement") for comparison in both]
    curves = [([values[..., column] for values in off], look) for column, *look in _PLACES]
    _draw_differences(axes, both, curves, "mm")


def _draw_differences(
    axes: Axes, both: Twins, curves: list[tuple[list[Array], list[str]]], unit: str
) -> None:
    """Values on a material, solid and filled, and on isotropic friction, open, of each quantity;
    with its label, colour and marker.
    """
    axes.axhline(0.0, **ZERO)
    theta = np.degrees(both[0].dynamic.theta)
    for (filled, hollow), (label, colour, marker) in curves:
        look: Look = {"color": colour, "marker": marker, "markersize": 4.5, "linewidth": 1.3}
        axes.plot(theta, filled, label=label, **look)
        axes.plot(theta, hollow, "--", markerfacecolor="white", **look)
    degree_axis(axes, every=60)
    axes.set_ylabel(f"dynamic − quasi-static ({unit})")
