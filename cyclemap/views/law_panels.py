"""Distributions of a noisy map: stationary density, spectrum, metastable sets, staying in an arc and leaving it."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.maps import MetastableSets, QuasiStationaryDistribution, Response, Spectrum, TransferOperator
from cyclemap.views.sentences import number
from cyclemap.views.style import (
    INK,
    MEASURED,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    THETA,
    UNSTABLE,
    degree_axis,
    legend_above,
    name_tag,
    small,
)

DENSITY = "probability per degree"
# Names of neighbouring sets stand at different heights, in so many rows at most.
MOST_ROWS = 4
PER_DEGREE = np.pi / 180
SAMPLES = 1440


def density_curve(density: Callable[[Array], Array], low: float = 0.0, high: float = TWO_PI) -> tuple[Array, Array]:
    """(angles in degrees, `density` per degree) from `low` to `high` (rad)."""
    theta = np.linspace(low, high, SAMPLES + 1)
    return np.degrees(theta), PER_DEGREE * density(theta)


def draw_law(axes: Axes, operator: TransferOperator) -> None:
    """The stationary density, its error bound in the legend, and the uniform density to compare with."""
    theta_deg, density = density_curve(operator.density)
    bound = f"± {small(PER_DEGREE * operator.error_bound)}" if operator.is_certain else "shares of its parts unknown"
    axes.fill_between(theta_deg, density, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta_deg, density, color=PREDICTED, linewidth=1.8, label=f"stationary density, {bound}", zorder=3)
    axes.axhline(1.0 / 360.0, color=QUIET, linewidth=1.0, linestyle=":", label="uniform", zorder=2)
    _density_axes(axes, DENSITY)
    axes.set_ylim(bottom=0.0)


def draw_response(axes: Axes, response: Response, unit: str = "unit of the parameter") -> None:
    """The derivative of the stationary density with respect to a parameter; `unit` names what it is a rate in."""
    theta_deg, rate = density_curve(response.density)
    bound = f"± {small(PER_DEGREE * response.density_error)}" if np.isfinite(response.density_error) else "no bound"
    axes.axhline(0.0, color=QUIET, linewidth=0.9)
    axes.fill_between(theta_deg, rate, color=PREDICTED_FILL, linewidth=0, zorder=1)
    axes.plot(theta_deg, rate, color=PREDICTED, linewidth=1.8, label=f"derivative of the density, {bound}", zorder=3)
    _density_axes(axes, f"{DENSITY}, a {unit}")


def _density_axes(axes: Axes, label: str) -> None:
    degree_axis(axes, THETA)
    axes.set_ylabel(label)
    legend_above(axes)


# -- spectrum ----------------------------------------------------------------------------------------------


def draw_spectrum(axes: Axes, spectrum: Spectrum) -> None:
    """Eigenvalues in the unit disc with circles of their error bounds; open where there is none. The gap is told."""
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor=QUIET, linewidth=1.0, zorder=1))
    known = np.isfinite(spectrum.error_bounds)
    bounds = spectrum.error_bounds[known]
    name = f"eigenvalue, ± {small(float(bounds.max()))} at most" if bounds.size else "eigenvalue"
    _draw_values(axes, spectrum.values[known], PREDICTED, name)
    if not known.all():
        _draw_values(axes, spectrum.values[~known], UNSTABLE, "eigenvalue, error unknown")
    for value, bound in zip(spectrum.values[known], bounds, strict=True):
        axes.add_patch(Circle((value.real, value.imag), bound, facecolor=MEASURED, edgecolor=INK, alpha=0.5, zorder=3))
    _draw_gap(axes, spectrum)
    axes.set(xlabel="real part of λ", ylabel="imaginary part of λ", aspect="equal", xlim=(-1.1, 1.1), ylim=(-1.1, 1.1))
    legend_above(axes, columns=2)


def _draw_values(axes: Axes, values: NDArray[np.complex128], face: str, label: str) -> None:
    look: dict[str, Any] = {"marker": "o", "markersize": 4.5, "markeredgecolor": PREDICTED, "linestyle": "none"}
    axes.plot(values.real, values.imag, markerfacecolor=face, label=label, zorder=4, **look)


def _draw_gap(axes: Axes, spectrum: Spectrum) -> None:
    """The circle on which the second eigenvalue lies, its distance from 1 in the legend."""
    if spectrum.values.size < 2:
        return
    second = float(abs(spectrum.values[1]))
    label = f"|λ₂|: gap {max(0.0, 1.0 - second):.3g}"
    around = np.exp(1j * np.linspace(0.0, 2 * np.pi, 361))
    axes.plot(second * around.real, second * around.imag, color=INK, linestyle="--", linewidth=1.0, label=label)


# -- metastable sets ---------------------------------------------------------------------------------------


def draw_metastable_sets(axes: Axes, density: Callable[[Array], Array], sets: MetastableSets) -> None:
    """`density` (per rad, as an operator's) with the sets' arcs shaded below it, every other one hatched."""
    theta_deg, curve = density_curve(density)
    axes.plot(theta_deg, curve, color=PREDICTED, linewidth=1.8, label="stationary density", zorder=3)
    top = float(np.max(curve))
    for index, arc in enumerate(sets.arcs):
        _shade_set(axes, density, arc, hatched=index % 2 == 1)
    rows = 1 if len(sets.arcs) < 3 else min(len(sets.arcs), MOST_ROWS)
    middles_deg = np.mod(np.degrees(sets.arcs.mean(axis=1)), 360.0)
    for place, index in enumerate(np.argsort(middles_deg).tolist()):
        _name_set(axes, sets, index, float(middles_deg[index]), (1.06 + 0.16 * (place % rows)) * top)
    _density_axes(axes, DENSITY)
    axes.set_ylim(0.0, (1.1 + 0.16 * rows) * top)


def _name_set(axes: Axes, sets: MetastableSets, index: int, middle_deg: float, height: float) -> None:
    """The set's probabilities above its arc, and a line where it begins."""
    if len(sets.arcs) > 1:
        axes.axvline(
            float(np.degrees(sets.arcs[index, 0])) % 360.0, color=QUIET, linewidth=1.0, linestyle=":", zorder=2
        )
    side = "left" if middle_deg < 50 else "right" if middle_deg > 310 else "center"
    leaving = float(sets.leaving[index])
    chance = f"{1.0 - leaving:.4f}" if leaving >= 1e-4 or leaving == 0.0 else f"1 − {small(leaving)}"
    residence = f" ({number(1.0 / leaving)} cycles)" if leaving > 0.0 else ""
    name = f"set {index + 1}: {100 * sets.weights[index]:.3g} %\nstays {chance}{residence}"
    name_tag(axes, middle_deg, height, name, ha=side, va="bottom")


def _shade_set(axes: Axes, density: Callable[[Array], Array], arc: Array, hatched: bool) -> None:
    """Shade the density over one arc, in two parts where it runs across 360°."""
    start, length = float(np.mod(arc[0], TWO_PI)), float(arc[1] - arc[0])
    end = start + length
    for low, high in [(start, end)] if end <= TWO_PI else [(start, TWO_PI), (0.0, end - TWO_PI)]:
        theta_deg, curve = density_curve(density, low, high)
        look: dict[str, Any] = {"hatch": "///"} if hatched else {}
        axes.fill_between(theta_deg, curve, facecolor=PREDICTED_FILL, edgecolor=QUIET, linewidth=0.5, zorder=1, **look)


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
        # Less than one decade is written as 0.95, without powers of ten.
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    legend_above(axes, columns=2)


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
