"""Identify plywood from the measured staircase, with wear: `python -m tests.inference.plywood_measured`.

Takes about a minute and prints the material file that is shipped, and what else was tried.
"""

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import read_theta0_pairs, turn_bins
from cyclemap.evidence.data_blocks.cycle_pair_block import SHAPE, CyclePairBlock
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.mechanics import EllipseFriction, FoundWith, Material, Wear
from cyclemap.mechanics.material_text import material_toml

CYCLES = 2000.0
LATE = 500
# Of whole-map medians and of single cycles, rad: what each may be off by where the model is as good as it gets.
MEDIAN_NOISE, CYCLE_NOISE = math.radians(2.0), math.radians(1.2)
# All single cycles together count this much more than all medians together.
CYCLE_WEIGHT = 2.5
# Around the bottleneck the measured scatter is a third of what it is elsewhere.
BOTTLENECK, BOTTLENECK_WEIGHT = (math.radians(75.0), math.radians(125.0)), 2.0
WORN = tuple(f"worn_{name}" for name in SHAPE)
START = {"ellipticity_x": -0.06, "ellipticity_y": 0.1, "offset_x": -0.06, "offset_y": -0.05}


def measured_file() -> Path:
    """The measured staircase, in the data folder that the tests use."""
    home = os.environ.get("CYCLEMAP_DATA", str(Path(__file__).parents[3] / "shared" / "data"))
    return Path(home) / "plywood_rect1_theta0_2000.csv"


def plywood_block(pairs: Theta0Pairs) -> tuple[CyclePairBlock, int]:
    """Medians over 5 degrees of the late cycles, then every cycle; and how many medians there are."""
    assert pairs.cycle is not None
    late = pairs.cycle >= LATE
    medians = turn_bins(Theta0Pairs(pairs.theta[late], pairs.theta_next[late]))
    theta, turn = np.append(medians.centre, pairs.theta), np.append(medians.median, pairs.turn)
    middle = 0.5 * (LATE + CYCLES) / CYCLES
    share = np.append(np.full(medians.centre.size, middle), np.clip(pairs.cycle / CYCLES, 0.0, 1.0))
    block = CyclePairBlock("plywood", CollectionLoop.mit(), theta, turn, np.arange(theta.size), share)
    return block, medians.centre.size


def weights(block: CyclePairBlock, medians: int, bottleneck: float, cycles: float) -> np.ndarray:
    """One weight a row: medians alike, cycles alike but for those in the bottleneck."""
    theta = np.mod(block.theta[medians:], 2.0 * math.pi)
    inside = (theta > BOTTLENECK[0]) & (theta < BOTTLENECK[1])
    share = cycles * math.sqrt(medians / theta.size) / CYCLE_NOISE
    return np.append(np.full(medians, 1.0 / MEDIAN_NOISE), share * np.where(inside, bottleneck, 1.0))


def fitted(block: CyclePairBlock, row_weights: np.ndarray, ring: Sequence[str]) -> dict[str, float]:
    """Values of all unknowns: the ellipse, fresh and worn, and those of the ring that are named."""
    from scipy.optimize import least_squares

    free = [*SHAPE, *WORN, *ring]
    columns = [block.parameters.index(name) for name in free]
    bounds = np.array([(SURFACE[n.removeprefix("worn_")].lower, SURFACE[n.removeprefix("worn_")].upper) for n in free])
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def evaluated(vector: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if vector.tobytes() not in known:
            known.clear()
            known[vector.tobytes()] = block.residuals({**SURFACE.nominal, **dict(zip(free, vector, strict=True))})
        return known[vector.tobytes()]

    start = [START.get(name.removeprefix("worn_"), SURFACE.nominal[name] if name in ring else 0.0) for name in free]
    start = [0.65 if n == "hitch_scale" else 0.6 if n == "hitch_turn" else s for n, s in zip(free, start, strict=True)]
    found = least_squares(
        lambda v: evaluated(v)[0] * row_weights,
        start,
        jac=lambda v: (evaluated(v)[1] * row_weights[:, np.newaxis])[:, columns],
        bounds=bounds.T,
        x_scale=0.1,
        xtol=1e-4,
        ftol=1e-4,
    )
    return {**SURFACE.nominal, **dict(zip(free, found.x, strict=True))}


def bin_error(pairs: Theta0Pairs, residual: np.ndarray) -> float:
    """Root mean square, rad, over 5 degree bins of the median residual of the late cycles."""
    late = pairs.cycle >= LATE  # type: ignore[operator]
    return float(
        np.sqrt(np.mean(turn_bins(Theta0Pairs(pairs.theta[late], (pairs.theta + residual)[late])).median ** 2))
    )


def material_of(values: dict[str, float], misfit: str) -> Material:
    """The identified material, fresh and worn."""
    fresh = SurfaceParameters.from_values(values)
    worn = SurfaceParameters.from_values({**values, **{name: values[f"worn_{name}"] for name in SHAPE}})
    found = FoundWith(
        pusher_friction=fresh.pusher_friction,
        hitch_scale=round(fresh.hitch_scale, 4),
        hitch_turn=round(fresh.hitch_turn, 4),
    )
    wear = Wear(rounded(worn.to_friction()), CYCLES)
    return Material("plywood-measured", rounded(fresh.to_friction()), PROVENANCE, misfit, True, found, wear)


def rounded(law: EllipseFriction) -> EllipseFriction:
    """Return the friction to five decimals, which no motion can tell apart."""
    return EllipseFriction(*(round(value, 5) for value in (law.mu_a, law.mu_b, law.m0, law.n0, law.phi)))


PROVENANCE = (
    "inferred from the measured theta0 of 2000 pushes of rect1 on plywood (Ma & Rodriguez 2018, Fig. 9, digitised): "
    "all cycles with the wear that they show, medians over 5 degrees of pushes 500 to 2000, and twice the weight on "
    "the bottleneck at 75 to 125 degrees, which decides how long the staircase rests; friction wears on a straight way "
    "over the 2000 cycles. The lever of the ring was free and came out shorter than the nominal one and turned against "
    "it, which may stand for friction in the ring or a centre of pressure off the middle. The friction scale cannot be "
    "told from motion: mean coefficient 0.25 by convention; pusher friction 0.15 held."
)


def main() -> None:
    """Fit with each explanation of the ring, and print the shipped material."""
    pairs = read_theta0_pairs(measured_file())
    block, medians = plywood_block(pairs)
    for title, ring, bottleneck, cycles in (
        ("ring as it is", (), 1.0, 1.0),
        ("friction in the ring", ("pin_friction_radius",), 1.0, 1.0),
        ("shorter lever", ("hitch_scale",), 1.0, 1.0),
        ("shorter lever, turned", ("hitch_scale", "hitch_turn"), 1.0, 1.0),
        (
            "shorter lever, turned; weight on the bottleneck",
            ("hitch_scale", "hitch_turn"),
            BOTTLENECK_WEIGHT,
            CYCLE_WEIGHT,
        ),
    ):
        values = fitted(block, weights(block, medians, bottleneck, cycles), ring)
        misfit, medial = misfit_words(pairs, block.residuals(values)[0], medians)
        print(f"{title}: {misfit}; medians at half their wear {medial:.2f}")
        print(
            "   ",
            {name: round(float(value), 4) for name, value in values.items() if value != SURFACE.nominal.get(name)},
        )
    print(material_toml(material_of(values, misfit)))


def misfit_words(pairs: Theta0Pairs, residual: np.ndarray, medians: int) -> tuple[str, float]:
    """The misfit in words, and that of the medians at half their wear, degrees."""
    single, medial = (math.degrees(math.sqrt(np.mean(part**2))) for part in (residual[medians:], residual[:medians]))
    worn = math.degrees(bin_error(pairs, residual[medians:]))
    words = f"cycles {single:.2f} deg RMS; median error over 5 deg bins of pushes 500 to 2000 {worn:.2f} deg RMS"
    return words, medial


if __name__ == "__main__":
    main()
