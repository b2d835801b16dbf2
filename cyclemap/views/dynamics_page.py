"""Dynamic beside quasi-static cycles on a landscape page: the turns of both, and how far they
differ over θ0.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import MultipleLocator

from cyclemap.arrays import Array
from cyclemap.collection.dynamic_loop import DynamicsComparison
from cyclemap.views.style import (
    FORCE,
    INK,
    PREDICTED,
    QUIET,
    Look,
    legend_above,
    new_figure,
    picture_style,
    write_page,
)

THETA0 = "θ0 (°)"
# Name, colour, marker of each turn that is compared.
_TURNS = (
    ("push_turn", "push", PREDICTED, "o"),
    ("drag_turn", "drag", FORCE, "s"),
    ("theta_next", "push and drag", INK, "^"),
)
_PLACES = ((0, "dx", PREDICTED, "o"), (1, "dy", FORCE, "s"))


@picture_style()
def dynamics_page(material: DynamicsComparison, isotropic: DynamicsComparison) -> Figure:
    """Draw the comparison on a material and on its isotropic twin, from the same orientations."""
    figure = new_figure()
    grid = GridSpec(1, 3, figure, left=0.055, right=0.985, bottom=0.12, top=0.74, wspace=0.27)
    turns, differences, places = (figure.add_subplot(grid[0, column]) for column in range(3))
    for comparison, isotropic_law in ((material, False), (isotropic, True)):
        law = "isotropic" if isotropic_law else "material"
        theta = np.degrees(comparison.dynamic.theta)
        still = np.degrees(comparison.quasi_static.theta_next) - theta
        # A curve through one orientation needs a marker, over the dot, to be seen.
        alone = theta.size == 1
        dash = ("--" if isotropic_law else "-") + "x" * alone
        on = 4 if alone else 2
        turns.plot(
            theta, still, dash, color=QUIET, linewidth=1.4, label=f"{law}, quasi-static", zorder=on
        )
        moved = np.degrees(comparison.dynamic.theta_next) - theta
        look: Look = {
            "markerfacecolor": "white" if isotropic_law else PREDICTED,
            "markersize": 4.5,
        }
        turns.plot(theta, moved, "o", color=PREDICTED, label=f"{law}, dynamic", zorder=3, **look)
    turns.set(xlabel=THETA0, ylabel="turn of a cycle (°)")
    turns.xaxis.set_major_locator(MultipleLocator(60.0))
    turns.set_title("Turn of push and drag", pad=36.0)
    legend_above(turns)
    draw_turn_differences(differences, material, isotropic)
    draw_place_differences(places, material, isotropic)
    name, speed = material.loop.loop.material.name, 1e3 * material.loop.speed
    title = f"Dynamic and quasi-static cycles on {name} at {speed:g} mm/s"
    told = [difference_sentence(one) for one in (material, isotropic)]
    foot = (
        "solid, filled: the material; dashed, open: isotropic friction of the same mean coefficient"
    )
    write_page(figure, title, told, f"{foot}; both models stand on the same support points")
    return figure


def difference_sentence(comparison: DynamicsComparison) -> str:
    """How far the dynamic simulation is from the quasi-static model,
    at most over the orientations."""
    push, drag, cycle = (math.degrees(largest(comparison.difference(name))) for name, *_ in _TURNS)
    place = 1e3 * largest(comparison.difference("push_displacement"))
    count = comparison.dynamic.theta.size
    return (
        f"{comparison.loop.loop.material.name}: dynamic and quasi-static differ by at most "
        f"{push:.3f}° in the push, {drag:.3f}° in the drag, {cycle:.3f}° in the cycle, {place:.3f} "
        f"mm in the push's displacement ({count} orientation{'s' * (count != 1)})."
    )


def largest(difference: Array) -> float:
    """The largest absolute value."""
    return float(np.abs(difference).max())


def draw_turn_differences(
    axes: Axes, material: DynamicsComparison, isotropic: DynamicsComparison
) -> None:
    """Dynamic less quasi-static turns over θ0."""
    curves = [
        (look, [np.degrees(one.difference(name)) for one in (material, isotropic)])
        for name, *look in _TURNS
    ]
    _draw_differences(axes, material.dynamic.theta, curves, "°", "turns")


def draw_place_differences(
    axes: Axes, material: DynamicsComparison, isotropic: DynamicsComparison
) -> None:
    """Dynamic less quasi-static displacements of the push over θ0."""
    off = [1e3 * one.difference("push_displacement") for one in (material, isotropic)]
    curves = [(look, [one[..., column] for one in off]) for column, *look in _PLACES]
    _draw_differences(axes, material.dynamic.theta, curves, "mm", "displacement")


def _draw_differences(
    axes: Axes, theta: Array, curves: list[tuple[list[str], list[Array]]], unit: str, what: str
) -> None:
    """Label, colour and marker of each quantity: on the material solid and filled, on isotropic
    friction open.
    """
    for (label, colour, marker), pair in curves:
        for values, line, face, name in zip(
            pair, ("-", "--"), (colour, "white"), (label, "_isotropic"), strict=True
        ):
            axes.plot(
                np.degrees(theta),
                values,
                line,
                color=colour,
                marker=marker,
                markersize=4.5,
                linewidth=1.3,
                markerfacecolor=face,
                label=name,
                zorder=3,
            )
    axes.axhline(0.0, color=QUIET, linewidth=0.8, zorder=1)
    axes.set(xlabel=THETA0, ylabel=f"dynamic − quasi-static ({unit})")
    axes.xaxis.set_major_locator(MultipleLocator(60.0))
    axes.set_title(f"Difference of the {what}", pad=22.0)
    legend_above(axes)
