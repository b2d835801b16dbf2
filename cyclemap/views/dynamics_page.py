"""Dynamic beside quasi-static cycles on a landscape page: the turns of both, and how far they
differ over θ0.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import Array
from cyclemap.collection.dynamic_loop import DynamicsComparison
from cyclemap.views import style
from cyclemap.views.style import FORCE, INK, PREDICTED

# Name, colour, marker of each turn that is compared.
_TURNS = (
    ("push_turn", "push", PREDICTED, "o"),
    ("drag_turn", "drag", FORCE, "s"),
    ("theta_next", "push and drag", INK, "^"),
)
_PLACES = ((0, "dx", PREDICTED, "o"), (1, "dy", FORCE, "s"))


@style.picture_style()
def dynamics_page(material: DynamicsComparison, isotropic: DynamicsComparison) -> Figure:
    """Draw the comparison on a material and on its isotropic twin, from the same orientations."""
    figure = style.new_figure()
    name, speed = material.loop.loop.material.name, 1e3 * material.loop.speed
    title = f"Dynamic and quasi-static cycles on {name} at {speed:g} mm/s"
    told = [difference_sentence(comparison) for comparison in (material, isotropic)]
    foot = (
        "solid, filled: the material; dashed, open: isotropic friction of the same mean "
        "coefficient; both models stand on the same support points"
    )
    turns, differences, places = style.panels(
        figure, "abc", style.write_page(figure, title, told, foot), keys=2
    )
    for comparison, law, face in ((material, "material", PREDICTED), (isotropic, "isotropic", "w")):
        theta = np.degrees(comparison.dynamic.theta)
        still = np.degrees(comparison.quasi_static.theta_next) - theta
        line = style.SECOND if law == "isotropic" else style.LINE
        # A curve through one orientation needs a marker, over the dot, to be seen.
        marker = "x" if theta.size == 1 else None
        turns.plot(theta, still, label=f"{law}, quasi-static", **{**line, "marker": marker})
        dots: style.Look = {
            "markerfacecolor": face,
            "markersize": 4.5,
            "zorder": 3 if marker else 5,
        }
        moved = np.degrees(comparison.dynamic.theta_next) - theta
        turns.plot(theta, moved, "o", color=PREDICTED, label=f"{law}, dynamic", **dots)
    style.degree_axis(turns, every=60)
    turns.set_ylabel("turn of a cycle (°)")
    style.entitle(turns, "Turn of push and drag")
    draw_turn_differences(differences, material, isotropic)
    draw_place_differences(places, material, isotropic)
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
    axes.axhline(0.0, **style.ZERO)
    for (label, colour, marker), (filled, hollow) in curves:
        look: style.Look = {"color": colour, "marker": marker, "markersize": 4.5, "linewidth": 1.3}
        axes.plot(np.degrees(theta), filled, label=label, **look)
        axes.plot(np.degrees(theta), hollow, "--", markerfacecolor="white", **look)
    style.degree_axis(axes, every=60)
    axes.set_ylabel(f"dynamic − quasi-static ({unit})")
    style.entitle(axes, f"Difference of the {what}")
