"""Orbits over a parameter: branches and where they bifurcate, where orbits settle, and whether they diverge."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cyclemap.maps import Bifurcation, LyapunovExponents, OrbitBranch, OrbitDiagram
from cyclemap.views.panel_curves import branch_curves
from cyclemap.views.panel_parts import legend_above, say, whole_turn_ticks
from cyclemap.views.style import INK, MEASURED, PREDICTED, QUIET, UNSTABLE

STABLE: dict[str, Any] = {"color": PREDICTED, "linewidth": 2.0, "linestyle": "-", "zorder": 3}
LOST: dict[str, Any] = {"color": QUIET, "linewidth": 1.3, "linestyle": "--", "zorder": 2}
# Shapes differ, so that the colours need not be told apart.
MARKERS: dict[str, dict[str, Any]] = {
    "saddle-node": {"marker": "o", "markerfacecolor": UNSTABLE},
    "period-doubling": {"marker": "D", "markerfacecolor": MEASURED},
    "border-collision": {"marker": "^", "markerfacecolor": INK},
    "branch point": {"marker": "X", "markerfacecolor": UNSTABLE},
}


def draw_orbit_branches(
    axes: Axes,
    branches: Sequence[OrbitBranch],
    bifurcations: Sequence[Bifurcation] = (),
    parameter_label: str = "parameter",
) -> None:
    """Angles of the orbits over the parameter: solid where stable, dashed where not; bifurcations by their shapes."""
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    if not branches:
        say(axes, "no periodic orbit")
    seen: set[str] = set()
    for branch in branches:
        for stable, (parameter, theta_deg) in branch_curves(branch):
            label = _once("stable" if stable else "unstable", seen)
            axes.plot(parameter, theta_deg, label=label, **(STABLE if stable else LOST))
    for found in bifurcations:
        _mark(axes, found, _once(found.kind, seen))
    axes.margins(x=0.02)
    named = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    legend_above(axes, columns=6, handles=[named[name] for name in ("stable", "unstable", *MARKERS) if name in named])


def _once(name: str, seen: set[str]) -> str | None:
    """`name` the first time, then None."""
    label = None if name in seen else name
    seen.add(name)
    return label


def _mark(axes: Axes, found: Bifurcation, label: str | None) -> None:
    points_deg = np.degrees(found.points)
    look: dict[str, Any] = {
        "linestyle": "none",
        "markersize": 7,
        "markeredgecolor": INK,
        "markeredgewidth": 1.2,
    }
    parameter = np.full(points_deg.size, float(found.parameter))
    axes.plot(parameter, points_deg, label=label, zorder=5, **look, **MARKERS[found.kind])


def draw_orbit_diagram(axes: Axes, diagram: OrbitDiagram, parameter_label: str = "parameter") -> None:
    """Every angle that the orbits visit, a dot each, over the parameter."""
    parameter = np.repeat(diagram.parameter, diagram.theta.shape[1])
    axes.plot(parameter, np.degrees(diagram.theta).ravel(), ",", color=INK, alpha=0.5, rasterized=True)
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    axes.margins(x=0.0)


def draw_lyapunov_exponents(
    axes: Axes, exponents: LyapunovExponents, first_label: str = "parameter", second_label: str = "second parameter"
) -> None:
    """A curve over the one parameter that varies, or colour over two: red where orbits diverge, blue where not."""
    varying = [values for values in exponents.parameters if values.size > 1]
    label = "Lyapunov exponent (1/cycle)"
    if exponents.value.ndim == 1:
        axes.plot(varying[0].ravel(), exponents.value, color=PREDICTED, linewidth=1.2)
        axes.axhline(0.0, color=QUIET, linewidth=0.8, linestyle="--")
        axes.set(xlabel=first_label, ylabel=label)
        axes.margins(x=0.0)
        return
    finite = exponents.value[np.isfinite(exponents.value)]
    # The few deep minima, at superstable orbits, would leave no colour to the rest.
    reach = max(float(np.max(finite, initial=0.0)), float(np.quantile(np.append(np.abs(finite), 1e-3), 0.9)))
    mesh = axes.pcolormesh(
        *(values.ravel() for values in varying),
        exponents.value.T,
        cmap="RdBu_r",
        vmin=-reach,
        vmax=reach,
        rasterized=True,
    )
    axes.set(xlabel=first_label, ylabel=second_label)
    axes.grid(visible=False)
    axes.get_figure(root=True).colorbar(mesh, ax=axes, label=label, extend="min")  # type: ignore[union-attr]
