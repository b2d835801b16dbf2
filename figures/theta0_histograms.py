"""Fig. 6: how often each orientation θ0 is pushed from, on four materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.evidence import AngleHistogram, angle_histogram, total_variation
from cyclemap.views import style
from cyclemap.views.map_panels import CIRCLE, PER_DEGREE, draw_histogram, draw_recorded
from cyclemap.views.sentences import angle, listed

from .catalogue import MeasuredFolder
from .measured_sets import measured_theta0, not_found
from .simulated_collections import (
    PAPER,
    STANDS_FOR,
    SampledRun,
    Sampling,
    draw_materials,
    sampled_run,
)

UNIFORM = 1.0 / (2 * np.pi)
# A maximum of the density counts as a peak from this many times the uniform density on.
LEAST_PEAK = 0.5
# The paper's words for the peaks, in the order of `PublishedStatistics.directions`.
PEAK_WORDS = {"plywood": ("high", "small"), "abs": ("small", "high"), "delrin": ("only",), "pu": ()}
# Pushes within so many rad of a direction are counted as there.
NEAR = float(np.deg2rad(30.0))


@dataclass(frozen=True, eq=False)
class MaterialDirections:
    """One panel.

    run : simulated pushes.
    simulated : their histogram.
    density : (721,) per rad at ``CIRCLE``, stationary, of the map with its noise, known to
        density_error.
    theta0 : (m,) rad, the recorded orientations, and recorded, their histogram; None where not
        found.
    """

    run: SampledRun
    simulated: AngleHistogram
    density: Array
    density_error: float
    theta0: Array | None
    recorded: AngleHistogram | None

    @property
    def peaks(self) -> Array:
        """(k,) rad, where the stationary density has a maximum above half the uniform one, the
        highest first.
        """
        value = self.density[:-1]
        top = (
            (value >= np.roll(value, 1))
            & (value > np.roll(value, -1))
            & (value > LEAST_PEAK * UNIFORM)
        )
        places = np.flatnonzero(top)
        return np.asarray(CIRCLE[places[np.argsort(-value[places])]])


def share_near(theta: ArrayLike, directions: ArrayLike) -> float:
    """The share of the angles (n,), rad, within NEAR (rad) of one of the directions (k,).

    >>> share_near([0.1, 3.0, 6.2], [0.0])
    0.6666666666666666
    """
    apart = np.cos(
        np.subtract.outer(np.asarray(theta, dtype=float), np.asarray(directions, dtype=float))
    )
    return float(np.mean((apart >= np.cos(NEAR)).any(axis=-1)))


def compute(measured: MeasuredFolder, sampling: Sampling = PAPER) -> tuple[MaterialDirections, ...]:
    """Simulate pushes on each material and look for recorded ones."""
    found = []
    for surface, material in STANDS_FOR.items():
        run, pairs = sampled_run(material, sampling), measured_theta0(measured, surface)
        theta0 = None if pairs is None else pairs.path if pairs.path is not None else pairs.theta
        recorded = None if theta0 is None else angle_histogram(theta0)
        simulated = angle_histogram(run.pushes.theta)
        found.append(MaterialDirections(run, simulated, *run.density(CIRCLE), theta0, recorded))
    return tuple(found)


def draw(result: tuple[MaterialDirections, ...]) -> Figure:
    """Draw a panel a material."""
    return draw_materials([panel.run.surface for panel in result], result, _draw_material)


def _draw_material(axes: Axes, panel: MaterialDirections) -> None:
    draw_recorded(axes, panel.recorded)
    look = {**style.SECOND, "linestyle": "-"}
    draw_histogram(axes, panel.simulated, "simulated", **look)
    around, density = np.degrees(CIRCLE), PER_DEGREE * panel.density
    axes.plot(around, density, label="stationary density", **style.LINE)
    top = 1.3 * axes.dataLim.y1
    axes.set_ylim(0.0, top)
    for place, word in zip(_published(panel), PEAK_WORDS[panel.run.surface], strict=True):
        axes.axvline(place, ymax=0.9, label="paper's peak", **style.THIRD)
        style.name_tag(axes, place, 0.94 * top, f"{place:.0f}° {word}")
    if not PEAK_WORDS[panel.run.surface]:
        style.name_tag(axes, 180.0, 0.94 * top, "paper: no stable direction")


def _published(panel: MaterialDirections) -> list[float]:
    return [float(np.degrees(angle) % 360.0) for angle in panel.run.published.directions]


def caption(result: tuple[MaterialDirections, ...]) -> str:
    """What is drawn, and where each material's histogram has its peaks."""
    count = result[0].run.pushes.count
    error = max(panel.density_error for panel in result) * PER_DEGREE
    told = [
        f"Orientation before each push: {count} simulated pushes a material, 1.1° of noise a "
        f"cycle, and the stationary density of the noisy map (within {error:.1g} per degree). "
        f"Plywood is plywood-measured, whose density is the mean over {len(result[0].run.states)} "
        "states of its wear. Dashed: the peaks that the paper names. Maxima above half the uniform "
        "density count as peaks.",
        *[_sentence(panel) for panel in result],
        not_found("θ0", [panel.run.surface for panel in result if panel.theta0 is None]),
    ]
    return " ".join(filter(None, told))


def _sentence(panel: MaterialDirections) -> str:
    name, peaks = panel.run.surface, [f"{angle(peak, 0)}" for peak in panel.peaks]
    where = f"peaks at {listed(peaks)}" if peaks else "has no peak"
    told = f"On {name} the density {where}"
    if not _published(panel):
        return (
            f"{told}, {panel.density.max() / UNIFORM:.1f} times the uniform one at most (paper: "
            "none)."
        )
    words = [
        f"{at:.0f}° {word}" for at, word in zip(_published(panel), PEAK_WORDS[name], strict=True)
    ]
    near = share_near(panel.run.pushes.theta, panel.run.published.directions)
    told += (
        f" (paper: {listed(words)}); {near:.0%} of the simulated pushes start within 30° of "
        "the paper's"
    )
    if panel.theta0 is None or panel.recorded is None:
        return f"{told}."
    recorded = share_near(panel.theta0, panel.run.published.directions)
    highest = int(np.argmax(panel.recorded.density))
    low, high = np.degrees(panel.recorded.edges[highest : highest + 2])
    apart = float(total_variation(panel.theta0, panel.run.pushes.theta))
    return (
        f"{told}, {recorded:.0%} of the {panel.theta0.size} recorded ones, whose highest bin is "
        f"{low:.0f}° to {high:.0f}°; the two histograms are {apart:.2f} apart in total variation."
    )
