"""What is believed of a floor that nobody has measured: `python -m tests.inference.unknown_floor`.

Writes `unknown.toml` into the folder `out`: the population of the floors, sessions and plates that
the built-in materials know, as samples. Two measured boards are few: each sample takes one of them,
with the spread between its sessions, turned by any angle, since nobody knows how the board will
lie, and stiffer or softer by a factor. How far friction is off centre is taken from four boards.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import (
    FoundWith,
    Material,
    MaterialPosterior,
    PlatePressure,
    SurfaceShape,
    load_material,
)
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.material import ANY_PLATE
from cyclemap.mechanics.material_text import built_in_plates, material_toml
from cyclemap.text_files import write_whole

FLOORS = ("plywood-floor", "abs-floor")
# Boards of which only the published pushes are known. No shape of a floor makes the first harmonic
# of their maps, so that their offsets of friction are taken as found; their ellipses stand in for
# shapes, and are not.
PUBLISHED = ("delrin", "pu")
SAMPLES, SEED = 120, 1
# A board's shape in another place or of another make: standard deviation of the logarithm of its
# size.
STIFFNESS = 0.5
# Offsets and ellipticities of friction on the two floors (shares of the mean): Rayleigh scales.
# Joint fits of pushes and drags found .006 to .03 and .01 to .015, of staircases .05 and .04.
OFFSET, ELLIPTICITY = 0.03, 0.02
# Of rods that were found on these floors, and the radius of the rod's friction circle in its ring,
# m.
ROD, ROD_SPREAD, RING, RING_SPREAD = 0.17, 0.03, 0.8e-3, 0.4e-3
MEAN_FRICTION = 0.25
PROVENANCE = (
    "a floor that nobody has measured, as samples: the shape of one of two boards (plywood-floor, "
    "abs-floor) in one of its sessions, at any angle, larger or smaller by half, since two are few; "
    "the offset of friction of one of four (these, delrin, pu), in any direction; a plate like one "
    "of MIT's seven. The floor that stands here is alike all around, with the dome on which MIT's "
    "loop turns the square by as much as in the median of the samples"
)
PARAMETERS = (
    *("mu_a", "mu_b", "m0", "n0", "phi_deg"),
    *("floor_dome_kpa", "floor_bow_kpa", "floor_bow_deg", "pusher_mu", "pin_friction_mm"),
    *("any.plate_dome_kpa", "any.plate_warp_kpa", "any.plate_warp_deg"),
)


def floor_shapes() -> list[tuple[Array, Array]]:
    """Mean shape and spread between sessions of each measured floor, as (dome, bow_x, bow_y),
    kPa."""
    floors = [load_material(name) for name in FLOORS]
    return [(floor.floor.bend, np.array(floor.session_spread)) for floor in floors]


def turned(bend: Array, angle: float) -> Array:
    """The same shape turned by an angle, rad."""
    c, s = math.cos(2.0 * angle), math.sin(2.0 * angle)
    return np.array((bend[0], c * bend[1] - s * bend[2], s * bend[1] + c * bend[2]))


def offset_size(rng: np.random.Generator) -> float:
    """How far the friction of one of the four boards is off centre, over its mean."""
    board = rng.integers(len(FLOORS) + len(PUBLISHED))
    if board < len(FLOORS):
        return float(rng.rayleigh(OFFSET))
    material = load_material(PUBLISHED[board - len(FLOORS)])
    assert material.posterior is not None
    friction = material.sample(int(rng.integers(len(material.posterior)))).friction
    return math.hypot(friction.m0, friction.n0) / math.sqrt(friction.mu_a * friction.mu_b)


def sample(rng: np.random.Generator) -> list[float]:
    """One floor with a plate, in the order of PARAMETERS."""
    mean, spread = floor_shapes()[rng.integers(len(FLOORS))]
    bend = turned(mean + spread * rng.normal(size=3), rng.uniform(0.0, math.pi))
    bend *= rng.lognormal(sigma=STIFFNESS)
    plates = built_in_plates()
    own = turned(plates[rng.integers(len(plates))].shape.bend, rng.uniform(0.0, math.pi))
    floor, plate = SurfaceShape.of_bend(*bend.tolist()), SurfaceShape.of_bend(*own.tolist())
    stretch, offset = math.exp(rng.rayleigh(ELLIPTICITY)), MEAN_FRICTION * offset_size(rng)
    toward = rng.uniform(0.0, 2.0 * math.pi)
    rod = float(np.clip(rng.normal(ROD, ROD_SPREAD), 0.05, 0.4))
    ring = 1e3 * abs(rng.normal(RING, RING_SPREAD))
    axes = MEAN_FRICTION * stretch, MEAN_FRICTION / stretch
    centre = offset * math.cos(toward), offset * math.sin(toward)
    return [
        *(*axes, *centre, rng.uniform(0.0, 180.0)),
        *(floor.dome, floor.bow, math.degrees(floor.axis), rod, ring),
        *(plate.dome, plate.bow, math.degrees(plate.axis)),
    ]


def mean_turn(material: Material) -> float:
    """How far a cycle of MIT's loop turns the square on average over its orientation, rad."""
    theta = 2.0 * math.pi * np.arange(8) / 8
    return float(np.mean(CollectionLoop.mit(material).next_theta(theta) - theta))


def unknown_floor() -> Material:
    """The material: samples of what may be, and a dome that turns the square as far as they do."""
    rng = np.random.default_rng(SEED)
    rows = [tuple(float(f"{value:.6g}") for value in sample(rng)) for _ in range(SAMPLES)]
    unknown = Material(
        "unknown",
        EllipseFriction.isotropic(MEAN_FRICTION),
        PROVENANCE,
        inferred=True,
        found_with=FoundWith(ROD, RING),
        plates=(PlatePressure(ANY_PLATE),),
        posterior=MaterialPosterior(PARAMETERS, tuple(rows)),
        noise=load_material("plywood-measured").noise,
    )
    turn = float(np.median([mean_turn(unknown.sample(index)) for index in range(SAMPLES)]))

    def excess(dome: float) -> float:
        return mean_turn(replace(unknown, floor=SurfaceShape(dome))) - turn

    dome = brentq(excess, -4.0, 2.0, xtol=0.01)
    return replace(unknown, floor=SurfaceShape(round(dome, 1)))


if __name__ == "__main__":
    write_whole(Path("out") / "unknown.toml", material_toml(unknown_floor()).encode())
    print("out/unknown.toml")
