"""Infer abs, delrin and pu from published statistics: `python -m tests.inference.published_materials [MATERIAL ...]`.

Writes each material's file into the folder `out` and prints the table of published and predicted numbers. Takes some
minutes a material.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cyclemap.cli.output import progress_bar
from cyclemap.collection import CollectionLoop
from cyclemap.evidence.data_blocks.cycle_pair_block import CYCLE_UNKNOWNS
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identified_material import identified_material
from cyclemap.evidence.published_comparison import TOLERANCES, comparison_table, published_comparison, statistics_block
from cyclemap.evidence.published_statistics import SOURCE, published_statistics
from cyclemap.mechanics import Material
from cyclemap.mechanics.material_text import material_toml
from cyclemap.whole_files import write_whole

MATERIALS = ("abs", "delrin", "pu")
STARTS = 4
LIMITS = (
    ". From means and standard deviations of 2000 equal pushes and from where the object lingers, no forces and no "
    "single motions; the friction scale cannot be told from motion: mean coefficient 0.25 by convention; other optima "
    "may be nearly as good"
)
UNTURNED = "; no direction is published, so neither can the surface's orientation: its longer axis lies along x"


def inferred(name: str) -> Material:
    """The material from what is published of it and what is usual, its misfit the published comparison."""
    published = published_statistics(name)
    # Where no direction is published, turning the surface changes no statistic.
    held = {} if published.directions else {"ellipticity_y": 0.0}
    beliefs = {key: belief for key, belief in usual_beliefs(CYCLE_UNKNOWNS).items() if key not in held}
    block = statistics_block(published, CollectionLoop.mit())
    noise = {kind: size for kind, size in TOLERANCES.items() if kind in block.kinds}
    with progress_bar(name) as report:
        found = identify([block], tuple(beliefs), held, priors=beliefs, noise=noise, starts=STARTS, progress=report)
    for note in found.notes:
        print(f"{name}: {note}", flush=True)
    material = identified_material(found, name, [SOURCE])
    words = material.provenance + LIMITS + ("" if published.directions else UNTURNED) + "."
    words += "" if found.converged else " The search was stopped a little short of the optimum."
    return replace(material, provenance=words, misfit=published_comparison(material).sentence)


if __name__ == "__main__":
    wanted = sys.argv[1:] or MATERIALS
    unknown = set(wanted) - set(MATERIALS)
    if unknown:
        sys.exit(f"unknown material {', '.join(sorted(unknown))}; known: {', '.join(MATERIALS)}")
    materials = [inferred(name) for name in wanted]
    for material in materials:
        write_whole(Path("out", f"{material.name}.toml"), material_toml(material).encode())
    print(comparison_table(published_comparison(material) for material in ["plywood", *materials]))
