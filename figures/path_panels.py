"""Panels of pushed paths shaded by the turn of the push, with one bar of shades for all of them."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from cyclemap.arrays import Array

from .measured_sets import listed, not_found
from .pushed_paths import MEASURED_THETA0, RECORDED, SIMULATED, PushedPaths
from .simulated_collections import NOISE

MM = 1000.0
ORIGINS = (RECORDED, MEASURED_THETA0, SIMULATED)
# From a blue that still shows on white to nearly black: a darker shade is a larger turn, in a grey print too.
SHADES = ListedColormap(colormaps["YlGnBu"](np.linspace(0.32, 1.0, 256)))


def turn_shades(surfaces: list[PushedPaths]) -> ScalarMappable:
    """The shades of the turns (degrees) of all pushes, from the least to the largest in whole degrees."""
    turns = np.degrees(np.concatenate([paths.turn for paths in surfaces]))
    return ScalarMappable(Normalize(np.floor(turns.min()), np.ceil(turns.max())), SHADES)


def draw_paths(axes: Axes, lines: Array, turn: Array, shades: ScalarMappable) -> None:
    """Draw paths (k, m, 2) m, in millimetres, each in the shade of its turn (k,) rad."""
    collection = LineCollection(list(MM * lines), colors=shades.to_rgba(np.degrees(turn)), linewidths=0.7, alpha=0.75)
    axes.add_collection(collection)
    axes.set_aspect("equal")


def shade_bar(figure: Figure, place: tuple[float, float, float, float], shades: ScalarMappable) -> None:
    """The bar of shades at a place (left, bottom, width, height) of the figure."""
    bar = figure.add_axes(place)
    figure.colorbar(shades, cax=bar, label="Δθ, turn of the push (°)")
    bar.grid(False)


def panel_title(paths: PushedPaths) -> str:
    """The surface, and where its pushes come from."""
    return f"{paths.surface}, {paths.origin}"


def material_sentence(surfaces: list[PushedPaths]) -> str:
    """What is recorded, what was simulated in its stead, and why plywood stands as it does."""
    by_origin = {origin: [paths for paths in surfaces if paths.origin == origin] for origin in ORIGINS}
    recorded, started, simulated = by_origin.values()
    words = [f"Recorded pushes: {listed(paths.surface for paths in recorded)}."] if recorded else []
    words.append(not_found("pushes", [paths.surface for paths in (*started, *simulated)]))
    for paths in started:
        words.append(
            f"Simulated instead: on {paths.material} from {len(paths.theta0)} of the {len(paths.orientations)} "
            f"measured orientations of {paths.surface}, at equal distances."
        )
    if simulated:
        names, count = listed(paths.material for paths in simulated), len(simulated[0].orientations)
        words.append(
            f"Simulated as a whole: {names}, {len(simulated[0].theta0)} pushes at equal distances in a run of {count} "
            f"cycles with {np.degrees(NOISE.sigma):.1f}° of noise each."
        )
    if any(paths.material == "plywood-measured" for paths in surfaces):
        words.append(
            "Plywood is the one inferred from the measured orientations, wearing as it did: with Table I a run stays "
            "in one direction, where the measured one climbs through all of them."
        )
    return " ".join(filter(None, words))
