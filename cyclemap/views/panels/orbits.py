"""A map's graph with its orbits, their basins, orbits over a parameter, exponents, and the density
under noise.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cyclemap.arrays import TWO_PI, Array, Mask, stretches
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.maps import (
    Basin,
    Bifurcation,
    CircleMap,
    LyapunovExponents,
    Orbit,
    OrbitBranch,
    OrbitDiagram,
    TransferOperator,
)
from cyclemap.views.panels import orientation
from cyclemap.views.panels.layout import legend_above
from cyclemap.views.panels.rotation import cell_edges, draw_shades
from cyclemap.views.panels.style import (
    INK,
    LINE,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    SECOND,
    THETA,
    UNSTABLE,
    Look,
    degree_axis,
    orbit_marker,
    say,
    small,
    stability,
    whole_turn_ticks,
)

HALF_ROW = 0.28
# A smaller share of the circle is what rounding leaves between neighbouring arcs.
LEAST_SHARE = 1e-6
STABLE: Look = {**LINE, "label": "stable"}
LOST: Look = {**SECOND, "color": QUIET, "label": "unstable"}
BASIN: Look = {
    "facecolor": PREDICTED_FILL,
    "linewidth": 0,
    "label": "basin",
    "zorder": 2,
}
IMMEDIATE: Look = {
    "facecolor": "none",
    "edgecolor": PREDICTED,
    "hatch": "////",
    "linewidth": 0,
    "label": "immediate basin",
    "zorder": 3,
}
BIFURCATION: Look = {
    "linestyle": "none",
    "markersize": 7,
    "markeredgecolor": INK,
    "markeredgewidth": 1.2,
    "zorder": 5,
}
# Shapes differ, so that the colours need not be told apart.
MARKERS: dict[str, Look] = {
    "saddle-node": {"marker": "o", "markerfacecolor": UNSTABLE},
    "period-doubling": {"marker": "D", "markerfacecolor": MEASURED},
    "border-collision": {"marker": "^", "markerfacecolor": INK},
    "branch point": {"marker": "X", "markerfacecolor": UNSTABLE},
}


def draw_map(axes: Axes, circle_map: CircleMap, orbits: Sequence[Orbit] = ()) -> None:
    """Draw the graph of a map on one circle, cut at its jumps, with the diagonal.

    Parameters
    ----------
    axes : Axes
        Where it is drawn.
    circle_map : CircleMap
        The map.
    orbits : sequence of Orbit, default ()
        Marked on the graph.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, fixed_points
    >>> from cyclemap.views.panels.orbits import draw_map
    >>> axes, sine = Figure().subplots(), CircleMap.arnold(0.1, 0.9)
    >>> draw_map(axes, sine, fixed_points(sine))
    >>> axes.has_data()
    True
    """
    axes.plot([0.0, 360.0], [0.0, 360.0], color=QUIET, linewidth=0.9, linestyle="--", zorder=2)
    for theta, turn in turn_curve(circle_map).pieces:
        look = {**LINE, "linewidth": 1.8, "zorder": 3}
        draw_on_circle(axes, np.degrees(theta), theta + turn, **look)
    for orbit in orbits:
        points_deg, kind = np.degrees(orbit.points), stability(orbit)
        axes.plot(points_deg, np.roll(points_deg, -1), label=kind, **orbit_marker(kind))
    degree_axis(axes, THETA)
    whole_turn_ticks(axes)
    axes.set(ylabel="next θ (°)", aspect="equal")
    legend_above(axes)


def draw_on_circle(axes: Axes, x: Array, angle: Array, **look: Any) -> None:
    """Angles (n,), rad, lifted, over `x` (n,), a copy for every turn that they reach: axes of one
    circle show each angle once.
    """
    degrees = np.degrees(angle)
    first, last = np.floor([degrees.min() / 360.0, degrees.max() / 360.0])
    for turn in np.arange(first, last + 1.0):
        axes.plot(x, degrees - 360.0 * turn, **look)


def draw_density(axes: Axes, operator: TransferOperator) -> None:
    """Draw the stationary density of a noisy map, its error bound in the legend, and the uniform
    density beside it.

    Parameters
    ----------
    axes : Axes
        Where it is drawn.
    operator : TransferOperator
        As ``transfer_operator`` makes it.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
    >>> from cyclemap.views.panels.orbits import draw_density
    >>> axes = Figure().subplots()
    >>> draw_density(axes, transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3)))
    >>> axes.has_data()
    True
    """
    theta = np.linspace(0.0, TWO_PI, 1441)
    bound = (
        f"± {small(np.radians(operator.error_bound))}"
        if operator.is_certain
        else "shares of its parts unknown"
    )
    orientation.draw_density(axes, theta, operator.density(theta), f"stationary density, {bound}")
    axes.set_xlabel(THETA)
    legend_above(axes)


def draw_basins(axes: Axes, basins: Sequence[Basin]) -> None:
    """Draw a band for every basin, its immediate part hatched, its stable points as dots; the share
    of none is told.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    basins : sequence of Basin
        As ``basins`` of `cyclemap.maps` finds them.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, basins
    >>> from cyclemap.views.panels.orbits import draw_basins
    >>> axes = Figure().subplots()
    >>> draw_basins(axes, basins(CircleMap.arnold(0.1, 0.9), max_period=1))
    >>> axes.has_data()
    True
    """
    degree_axis(axes, THETA)
    axes.set_yticks([])
    axes.set_ylim(max(len(basins), 1) - 0.6, -0.5)
    if not basins:
        say(axes, "no stable orbit")
        return
    for row, basin in enumerate(basins):
        height, orbit = (row - HALF_ROW, 2 * HALF_ROW), basin.orbit
        for arcs, look in ((basin.arcs, BASIN), (basin.immediate, IMMEDIATE)):
            starts, lengths = np.degrees(arcs[:, 0]) % 360.0, np.degrees(np.diff(arcs)[:, 0])
            for back in (0.0, 360.0):
                axes.broken_barh(list(zip(starts - back, lengths, strict=True)), height, **look)
        name = (
            f"period {orbit.period}, winding {orbit.winding}: {100 * basin.measure:.3g} % of "
            "the circle"
        )
        axes.annotate(name, (0.0, row - HALF_ROW), (0, 4), textcoords="offset points", fontsize=8)
        level, marker = np.full(orbit.points.size, row), orbit_marker("stable")
        axes.plot(np.degrees(orbit.points), level, label="stable orbit", **marker)
    undecided = basins[0].undecided
    share = f"{100 * undecided:.2g} %" if undecided > LEAST_SHARE else "nothing"
    axes.plot([], [], label=f"undecided: {share}", linestyle="none")
    legend_above(axes)


def stable_between(branch: OrbitBranch) -> Mask:
    """Whether the orbits between each two neighbours (n - 1,) of a branch are stable: as the one of
    them is that is no bifurcation.
    """
    special = np.array([float(bifurcation.parameter) for bifurcation in branch.special])
    distance = np.abs(branch.parameter[:, None] - special).min(axis=1, initial=np.inf)
    bifurcates = distance <= 1e-9 * max(float(np.ptp(branch.parameter)), 1e-300)
    return np.where(bifurcates[:-1], branch.stable[1:], branch.stable[:-1])


def draw_orbit_branches(
    axes: Axes,
    branches: Sequence[OrbitBranch],
    bifurcations: Sequence[Bifurcation] = (),
    parameter_label: str = "parameter",
) -> None:
    """Draw the angles of orbits over a parameter: solid where stable, dashed where not.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    branches : sequence of OrbitBranch
        As ``orbit_branches`` finds them.
    bifurcations : sequence of Bifurcation, default ()
        Marked by their shapes.
    parameter_label : str, default 'parameter'
        Of the horizontal axis.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, orbit_branches
    >>> from cyclemap.views.panels.orbits import draw_orbit_branches
    >>> axes = Figure().subplots()
    >>> branches = orbit_branches(lambda K: CircleMap.arnold(0.1, K), (0.7, 0.9), resolution=4)
    >>> draw_orbit_branches(axes, branches, parameter_label="K")
    >>> axes.get_xlabel()
    'K'
    """
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    if not branches:
        say(axes, "no periodic orbit")
    for is_stable, look in ((True, STABLE), (False, LOST)):
        for branch in branches:
            for first, last in stretches(stable_between(branch) == is_stable):
                for points in branch.points[first : last + 1].T:
                    draw_on_circle(axes, branch.parameter[first : last + 1], points, **look)
    for bifurcation in sorted(
        bifurcations, key=lambda bifurcation: list(MARKERS).index(bifurcation.kind)
    ):
        parameter = np.full(bifurcation.points.size, float(bifurcation.parameter))
        marker = {**BIFURCATION, **MARKERS[bifurcation.kind], "label": bifurcation.kind}
        axes.plot(parameter, np.degrees(bifurcation.points), **marker)
    axes.margins(x=0.02)
    legend_above(axes)


def draw_orbit_diagram(
    axes: Axes, diagram: OrbitDiagram, parameter_label: str = "parameter"
) -> None:
    """Draw every angle that orbits visit, a dot each, over a parameter.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    diagram : OrbitDiagram
        As ``orbit_diagram`` makes it.
    parameter_label : str, default 'parameter'
        Of the horizontal axis.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, orbit_diagram
    >>> from cyclemap.views.panels.orbits import draw_orbit_diagram
    >>> axes = Figure().subplots()
    >>> diagram = orbit_diagram(lambda K: CircleMap.arnold(0.1, K), [0.5, 0.9], cycles=10)
    >>> draw_orbit_diagram(axes, diagram, "K")
    >>> axes.get_xlabel()
    'K'
    """
    parameter = np.repeat(diagram.parameter, diagram.theta.shape[1])
    axes.plot(
        parameter, np.degrees(diagram.theta).ravel(), ",", color=INK, alpha=0.5, rasterized=True
    )
    axes.set(xlabel=parameter_label, ylabel="θ of the orbit (°)")
    whole_turn_ticks(axes)
    axes.margins(x=0.0)


def draw_lyapunov_exponents(
    axes: Axes,
    exponents: LyapunovExponents,
    first_label: str = "parameter",
    second_label: str = "second parameter",
) -> None:
    """Draw Lyapunov exponents: a curve over the one parameter that varies, or colour over two, red
    where orbits diverge, blue where not.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    exponents : LyapunovExponents
        As ``lyapunov_exponents`` finds them.
    first_label : str, default 'parameter'
        Of the horizontal axis.
    second_label : str, default 'second parameter'
        Of the vertical axis, where two parameters vary.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from cyclemap.maps import CircleMap, lyapunov_exponents
    >>> from cyclemap.views.panels.orbits import draw_lyapunov_exponents
    >>> axes = Figure().subplots()
    >>> draw_lyapunov_exponents(axes, lyapunov_exponents(CircleMap.arnold, 0.1, [0.5, 0.9]), "K")
    >>> axes.get_xlabel()
    'K'
    """
    varying = [values.ravel() for values in exponents.parameters if values.size > 1]
    label = "Lyapunov exponent (1/cycle)"
    if exponents.value.ndim == 1:
        axes.plot(varying[0], exponents.value, color=PREDICTED, linewidth=1.2)
        axes.axhline(0.0, color=QUIET, linewidth=0.8, linestyle="--")
        axes.set(xlabel=first_label, ylabel=label)
        axes.margins(x=0.0)
        return
    finite = exponents.value[np.isfinite(exponents.value)]
    # The few deep minima, at superstable orbits, would leave no colour to the rest.
    reach = max(
        float(np.max(finite, initial=0.0)), float(np.quantile(np.append(np.abs(finite), 1e-3), 0.9))
    )
    first, second = map(cell_edges, varying)
    draw_shades(axes, first, second, exponents.value, label, cmap="RdBu_r", vmin=-reach, vmax=reach)
    axes.set(xlabel=first_label, ylabel=second_label)
