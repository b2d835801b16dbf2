"""Staying in an arc and leaving it: survival over the cycles, and the law of a path that has stayed for long."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from cyclemap.arrays import Array
from cyclemap.maps import QuasiStationaryDistribution
from cyclemap.views.panel_curves import PER_DEGREE, density_curve
from cyclemap.views.panel_parts import THETA, legend_above, small
from cyclemap.views.sentences import number
from cyclemap.views.style import INK, PREDICTED, PREDICTED_FILL, QUIET


def draw_survival(axes: Axes, probabilities: Array, law: QuasiStationaryDistribution | None = None) -> None:
    """`probabilities` (n,) of being still inside after 0, 1, ... cycles; with `law` its exponential λⁿ beside them."""
    cycles = np.arange(probabilities.size)
    shown = probabilities > 0.0
    axes.plot(cycles[shown], probabilities[shown], color=PREDICTED, linewidth=2.0, label="from the start", zorder=3)
    if law is not None:
        label = f"from the quasi-stationary law: λⁿ, mean {number(law.residence_cycles)} cycles"
        chances = law.residence_probability(cycles)
        axes.plot(cycles, chances, color=INK, linewidth=1.2, linestyle="--", label=label, zorder=4)
    axes.set(xlabel="cycles", ylabel="probability of being still inside", yscale="log")
    axes.set_xlim(0, max(probabilities.size - 1, 1))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
    if shown.all() and probabilities[-1] > 0.1:
        _write_plain(axes)
    legend_above(axes, columns=2)


def _write_plain(axes: Axes) -> None:
    """Write the values of a logarithmic axis of less than one decade as 0.95, without powers of ten."""
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def draw_quasi_stationary_distribution(axes: Axes, law: QuasiStationaryDistribution) -> None:
    """The density over the arc of a path that has stayed inside for long; what leaves, by which end, is told."""
    theta_deg, density = density_curve(law.density, *law.arc)
    name = f"density given a long stay, ± {small(PER_DEGREE * law.density_error)}"
    axes.fill_between(theta_deg, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta_deg, density, color=PREDICTED, linewidth=1.8, label=name, zorder=3)
    for end_deg, label in zip(theta_deg[[0, -1]], (_ends_name(law), None), strict=True):
        axes.axvline(end_deg, color=QUIET, linewidth=1.2, linestyle="--", label=label, zorder=2)
    axes.set(xlabel="θ, unwrapped (°)" if law.lifted else THETA, ylabel="probability per degree")
    axes.margins(x=0.05)
    axes.xaxis.set_major_locator(MaxNLocator(9, steps=[1, 1.5, 3, 4.5, 9, 10]))
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=1)


def _ends_name(law: QuasiStationaryDistribution) -> str:
    """What the arc's ends let through, per cycle."""
    told = f"ends of the arc: {law.escape_probability:.3g} leaves a cycle"
    if law.up is None or law.down is None:
        return told
    return f"{told} ({law.up:.3g} up, {law.down:.3g} down)"
