"""How long a cycle takes, with its derivatives, with inertia, to first order: one table, with ratios.

Run `python -m tests.benchmarks.cycles` from the repository's root. It prints medians of repeated runs, asserts nothing:
times are for people. `python -m tests.benchmarks.peers` times other solvers of the same push.
"""

import math
from dataclasses import replace

import numpy as np

from cyclemap.collection import CollectionLoop, DynamicLoop, fingerprint
from cyclemap.mechanics import grid_footprint
from cyclemap.mechanics.engine.strokes import PARAMETERS
from tests.benchmarks.timing import Row, map_alone, seconds, show

MIT = CollectionLoop.mit()
OUTLINE = MIT.slider.outline
THETA_0 = math.radians(150.0)
COUNTS = (25, 50, 100, 200)


def cycle_rows() -> list[Row]:
    """One cycle at two accuracies, and with its derivatives: averages over the circle."""
    theta = np.linspace(-math.pi, math.pi, 40, endpoint=False).tolist()
    rows = []
    for accuracy in (1e-6, 1e-8):
        loop = replace(MIT, accuracy=accuracy)
        plain = seconds(lambda loop=loop: [loop.cycle(t) for t in theta]) / 40
        rows.append(Row(f"cycle at {accuracy:g}", plain, "push and drag"))
        found = seconds(lambda loop=loop: [loop.sensitivity(t) for t in theta], 3) / 40
        rows.append(Row(f"with {len(PARAMETERS)} derivatives at {accuracy:g}", found, "push and drag"))
    return rows


def dynamic_rows() -> list[Row]:
    """The cycle with inertia on 8 x 8 points, beside the quasi-static one on the same points."""
    quasi_static = replace(MIT, footprint=grid_footprint(OUTLINE, 8), accuracy=1e-6)
    rows = [Row("quasi-static cycle on 8 x 8 points at 1e-6", seconds(lambda: quasi_static.cycle(THETA_0)), "cycle")]
    for tolerance in (1e-5, 1e-7):
        moving = DynamicLoop(quasi_static, tolerance=tolerance)
        taken = seconds(lambda moving=moving: moving.cycle(THETA_0), 3)
        rows.append(Row(f"dynamic cycle at tolerance {tolerance:g}", taken, "cycle at 20 mm/s"))
    return rows


def fingerprint_rows() -> list[Row]:
    """The five numbers of the protocol, beside the full map of one material at 1e-3 rad."""
    full = seconds(map_alone(MIT, 1e-3), 3)
    five = seconds(lambda: fingerprint(MIT), 3)
    return [Row("cycle map of plywood at 1e-3 rad", full, "one material"), Row("fingerprint", five, "any material")]


def growth_rows() -> list[Row]:
    """Time of n cycles, over n: level where the cost grows linearly."""
    loop, rows = replace(MIT, accuracy=1e-6), []
    for count in COUNTS:
        theta = np.linspace(-3.0, 3.0, count)
        taken = seconds(lambda theta=theta: loop.next_theta(theta), 3) / count
        rows.append(Row(f"{count} cycles, each", taken, "push and drag"))
    return rows


def main() -> None:
    """Print the table."""
    show("with and without inertia", dynamic_rows())
    show("full map and first order", fingerprint_rows())
    show("pushes and drags", [*cycle_rows(), *growth_rows()])


if __name__ == "__main__":
    main()
