"""Infer abs, delrin and pu from published statistics: `python -m
tests.inference.published_materials [MATERIAL ...]`.

Writes each material's file into the folder `out` and prints the table of published and predicted
numbers. Takes some minutes a material.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from cyclemap.cli.output import progress_bar
from cyclemap.collection import CollectionLoop
from cyclemap.evidence import DataBlock, SurfaceParameters, identified_material, identify
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.stroke_block import (
    CYCLE_UNKNOWNS,
    cycles_by_unknowns,
    interpolation,
)
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.figures.repeated_pushes import (
    PUBLISHED_CYCLES,
    SOURCE,
    PublishedStatistics,
    published_statistics,
)
from cyclemap.mechanics import Material
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS
from cyclemap.mechanics.material_text import material_toml
from cyclemap.text_files import write_whole
from tests.inference.published_prediction import (
    CYCLE_NOISE,
    NODES,
    predicted_statistics,
    published_comparison,
)

MATERIALS = ("abs", "delrin", "pu")
STARTS = 4
# How near a prediction is asked to come. Means: about a third of what the mechanics miss on single
# measured pushes; spreads: about a tenth. A direction read off a histogram is good to some 8
# degrees; the turn about it changes by less than a tenth of that.
TOLERANCES = {
    "mean turn (rad)": float(np.deg2rad(1.2)),
    "mean dx (m)": 1.5e-3,
    "mean dy (m)": 3e-3,
    "std of turn (rad)": float(np.deg2rad(0.5)),
    "std of dx (m)": 0.4e-3,
    "std of dy (m)": 1e-3,
    "turn at a stable direction (rad)": float(np.deg2rad(0.6)),
    "slope at a stable direction": 0.05,
    "turn where none is stable (rad)": float(np.deg2rad(0.5)),
    "share of the first direction": 0.05,
    "share of cycles near the directions": 0.1,
}
MOMENTS, (STILL, SLOPE, ADVANCE, FIRST, THERE) = list(TOLERANCES)[:6], list(TOLERANCES)[6:]
# Where the text sees no other peak, at least this share of the cycles lies within so many rad of
# one of the directions.
ONLY_THERE, MOST, NEAR = ("abs", "delrin"), 0.9, float(np.deg2rad(30.0))
# A slope above this at a stable direction, and a turn (rad) below this where none is stable, count
# as misses. The paper's "changes very regularly" leaves no place where the object lingers.
STEEPEST, SLOWEST = 0.95, float(np.deg2rad(3.0))
# Steps by which the law of orientations (share of a parameter's scale) and a slope (rad) are
# differenced.
STEP, ACROSS = 1e-5, 1e-4
LIMITS = (
    ". From means and standard deviations of 2000 equal pushes and from where the object lingers, "
    "no forces and no single motions; the friction scale cannot be told from motion: mean "
    "coefficient 0.25 by convention; other optima may be nearly as good"
)
UNTURNED = (
    "; no direction is published, so neither can the surface's orientation: its longer "
    "axis lies along x"
)


def cycle_nodes(
    surface: SurfaceParameters, loop: CollectionLoop, count: int = NODES
) -> tuple[np.ndarray, np.ndarray]:
    """`node_values` (count, 4) of the loop on a surface and their exact derivatives by
    CYCLE_UNKNOWNS (count, 4, k).
    """
    theta = 2.0 * np.pi * np.arange(count) / count
    runs, by_unknowns = cycles_by_unknowns(surface, loop, theta)
    turn = runs.theta_next[0] - theta
    values = np.column_stack([turn, runs.push_turn[0], runs.push_displacement[0]])
    names = ("theta_next", "push_turn", "push_dx", "push_dy")
    return values, by_unknowns[:, [CYCLE_OUTPUTS.index(name) for name in names]]


def statistics_block(
    published: PublishedStatistics,
    loop: CollectionLoop,
    nodes: int = NODES,
    cycles: int = PUBLISHED_CYCLES,
) -> DataBlock:
    """The published statistics of a material as data that depend on CYCLE_UNKNOWNS; of noise
    TOLERANCES.

    Cycles are computed at `nodes` (odd) orientations with exact derivatives; the law of θ0 is
    differenced through the nodes, to first order, without further mechanics.
    """
    there = np.array(published.directions)
    only = published.material in ONLY_THERE and bool(published.directions)
    told = published.first_share is not None
    kinds = [*MOMENTS, *[STILL] * there.size, *[SLOPE] * there.size]
    kinds += [ADVANCE] * (nodes * published.always_advancing) + [FIRST] * told + [THERE] * only

    def rows(values: np.ndarray) -> np.ndarray:
        """Predicted less published."""
        found = predicted_statistics(values, published, CYCLE_NOISE, cycles)
        turn = values[:, 0]
        still, ahead, behind = (
            interpolation(there + step, nodes) @ turn for step in (0.0, ACROSS, -ACROSS)
        )
        slope = 1.0 + (ahead - behind) / (2.0 * ACROSS)
        parts = [found.mean - published.mean, found.std - published.std, still]
        parts.append(np.maximum(slope - STEEPEST, 0.0))
        if published.always_advancing:
            parts.append(np.minimum(turn - SLOWEST, 0.0))
        if told:
            parts.append(np.array([found.first_share - published.first_share]))
        if only:
            near = np.cos(found.theta[:, np.newaxis] - there) >= np.cos(NEAR)
            parts.append(np.array([min(found.law[near.any(axis=1)].sum() - MOST, 0.0)]))
        return np.concatenate(parts)

    def function(values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        found, by_unknowns = cycle_nodes(SurfaceParameters.from_values(values), loop, nodes)
        here, steps = rows(found), [STEP * SURFACE[name].scale for name in CYCLE_UNKNOWNS]
        moved = [rows(found + step * by_unknowns[..., index]) for index, step in enumerate(steps)]
        return here, (np.array(moved) - here).T / steps

    name = f"published statistics of {published.material}"
    return DataBlock(name, CYCLE_UNKNOWNS, function, np.arange(len(kinds)), np.array(kinds))


def inferred(name: str) -> Material:
    """The material from what is published of it and what is usual, its misfit the published
    comparison.
    """
    published = published_statistics(name)
    # Where no direction is published, turning the surface changes no statistic.
    held = {} if published.directions else {"ellipticity_y": 0.0}
    beliefs = {
        key: belief for key, belief in usual_beliefs(CYCLE_UNKNOWNS).items() if key not in held
    }
    block = statistics_block(published, CollectionLoop.mit())
    noise = {kind: size for kind, size in TOLERANCES.items() if kind in block.kinds}
    with progress_bar(name) as report:
        told = {"priors": beliefs, "noise": noise, "starts": STARTS, "progress": report}
        found = identify([block], tuple(beliefs), held, **told)
    for note in found.notes:
        print(f"{name}: {note}", flush=True)
    material = identified_material(found, name, [SOURCE])
    words = material.provenance + LIMITS + ("" if published.directions else UNTURNED) + "."
    words += "" if found.fit.converged else " The search was stopped a little short of the optimum."
    return replace(material, provenance=words, misfit=published_comparison(material).sentence)


if __name__ == "__main__":
    wanted = sys.argv[1:] or MATERIALS
    unknown = set(wanted) - set(MATERIALS)
    if unknown:
        sys.exit(f"unknown material {', '.join(sorted(unknown))}; known: {', '.join(MATERIALS)}")
    materials = [inferred(name) for name in wanted]
    for material in materials:
        write_whole(Path("out", f"{material.name}.toml"), material_toml(material).encode())
    for one in ["plywood", *materials]:
        print(published_comparison(one).sentence)
