"""What `cyclemap reset` finds for every built-in material and two other objects, and whether the
mechanics agree.

Run `python -m tests.benchmarks.resets [NAME ...]` from the repository's root; without names all are
done, an hour's work of two cores at most. For each it prints a row of the table in
docs/how-to/reset-without-bias.md, the time, and how far 200 collections of 500 pushes by the full
mechanics lie from what was promised, on the nominal and on the worst material, in standard errors.
It asserts nothing.
"""

import math
import os
import sys
import time
from dataclasses import replace

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from cyclemap.collection import CollectionLoop, on_material
from cyclemap.mechanics import Material, Polygon, material_names
from cyclemap.protocol import loop_from_settings
from cyclemap.protocol.own_object import first_settings, within_reach
from cyclemap.resets import (
    ResetDesign,
    design_reset,
    histogram_distances,
    histogram_shares,
    orientation_law,
    run_strategy,
    sample_turns,
)
from cyclemap.views.reset_page import recipe

# The box as `cyclemap init --rectangle-mm 120,60` makes it: its own push and ring.
BOX = Polygon(((0.06, 0.03), (-0.06, 0.03), (-0.06, -0.03), (0.06, -0.03)))
OBJECTS = {
    "plywood, box of 120 x 60 mm": first_settings(BOX, "box"),
    "plywood, tri3": {"shape": "tri3"},
}
RUNS, PUSHES, FORGOTTEN = 200, 500, 50


def agreement(design: ResetDesign, material: Material, seed: int) -> str:
    """Total variation and mean histogram distance by the mechanics against those promised, in
    standard errors.

    The total variation is the mean excess of pushes in the orientations that the promised density
    favours, after the first 50 pushes.
    """
    strategy, sigma = design.chosen.strategy, design.sigma
    turn = sample_turns(strategy.prepared(design.loop), strategy.actions, [material], 72).refined(
        1440
    )[0]
    law = orientation_law(turn, strategy, sigma)
    loop = replace(on_material(design.loop, material), accuracy=1e-4)
    start = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, RUNS)
    run = run_strategy(
        loop, strategy, PUSHES + FORGOTTEN, runs=RUNS, start=start, sigma=sigma, seed=seed
    )
    favoured = law.density > 1.0 / (2.0 * math.pi)
    nearest = np.rint(np.degrees(run.theta[:, FORGOTTEN:-1] % (2.0 * math.pi))).astype(int) % 360
    excess = favoured[nearest].mean(axis=1) - favoured.mean()
    error = excess.std(ddof=1) / math.sqrt(RUNS)
    apart = (excess.mean() - law.total_variation) / error
    promised = (
        design.chosen.histogram
        if material == design.about.nominal
        else design.chosen.worst_histogram
    )
    found = histogram_distances(histogram_shares(run.theta[:, :PUSHES]))
    z = (found.mean() - promised[0]) / math.sqrt((found.var(ddof=1) + promised[1] ** 2) / RUNS)
    return (
        f"{excess.mean():.3f} for {law.total_variation:.3f} (z {apart:+.1f}), histogram "
        f"{found.mean():.3f} ± {found.std(ddof=1):.3f} for {promised[0]:.3f} ± {promised[1]:.3f} "
        f"(z {z:+.1f})"
    )


def main(names: list[str]) -> None:
    """Design the resets and set them beside the mechanics."""
    for name in names or [*material_names(), *OBJECTS]:
        loop = CollectionLoop.mit(name.partition(",")[0])
        loop = loop_from_settings(OBJECTS.get(name, {}), loop)
        loop = within_reach(loop) if "box" in name else loop
        begun = time.process_time()
        design = design_reset(loop)
        row = design.chosen
        print(
            f"| {name} | {recipe(row.strategy)} | {row.nominal.total_variation:.3f}, "
            f"{row.nominal.after:.3f} | {row.worst:.3f}, {row.worst_after:.3f} | "
            f"{1e3 * row.contact:.0f} mm |"
        )
        met = "meets all demands" if design.met else f"misses {', '.join(row.misses)}"
        print(
            f"  {met}; {design.about.told}; {time.process_time() - begun:.0f} s of processor time"
        )
        for seed, material in ((1, design.about.nominal), (2, row.worst_material)):
            print(f"  {material.name}: {agreement(design, material, seed)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
