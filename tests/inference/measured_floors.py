"""Infer the floors of the MIT push dataset and the shapes of its plates, and judge them on what was
left out.

`python -m tests.inference.measured_floors make FOLDER plywood` writes plywood-floor.toml from
pushes at 10 and 20 mm/s and drags of seven plates, `... plates FOLDER` the plates' shapes as
abs-floor.toml there has them. `... judge` prints how far fits to 10 mm/s lie from 20 mm/s, plate by
plate, beside isotropic friction; `... left-out PLATE` the same of a plate that the floor's fit did
not see; `... staircase` fits pushes, drags and cycles of rect1 on plywood at once.
"""

import json
import math
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cyclemap.collection import drifting_map
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError, UnsupportedContact
from cyclemap.evidence import (
    DataBlock,
    Identification,
    Parameter,
    ParameterSpace,
    collected_blocks,
    identified_material,
    identify,
    push_end_block,
    read_theta0_pairs,
)
from cyclemap.evidence.identification.data_block import session_block, usual_beliefs
from cyclemap.evidence.identification.known_floor import (
    held_values,
    known_beliefs,
    known_shapes,
    known_spread,
    telling_parameters,
)
from cyclemap.evidence.identification.stroke_block import surface_model
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
)
from cyclemap.evidence.identified_material import sampled_values
from cyclemap.evidence.predicted_strokes import predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import (
    MeasuredPush,
    RowSelection,
    measured_pushes,
    selected,
    session_name,
)
from cyclemap.evidence.tables.columns import ENDS, RODS, known_columns
from cyclemap.maps import LocalNoise, sample_staircases
from cyclemap.mechanics import (
    Material,
    PlatePressure,
    Slider,
    SurfaceShape,
    load_material,
    material_toml,
)
from cyclemap.mechanics.material import PLATE_SHAPE_KEYS, shape_numbers
from cyclemap.text_files import read_csv_table

FLOORS = ("plywood", "abs")
PLATES = ("rect1", "rect2", "tri1", "tri3", "hex", "ellip1", "ellip2")
PUSHES = {
    10: ("mit_push_endpoints_v10.csv", "mit_push_endpoints_v10_more.csv"),
    20: ("mit_push_endpoints_v20.csv",),
}
DRAGS, CYCLES = "mit_dragback_v10.csv", "plywood_rect1_theta0_2000.csv"
# Strokes of a session that take part, evenly spread.
MOST, MOST_MADE, MOST_JUDGED = 40, 60, 90
STUDENT = 4.0
PLATES_PROVENANCE = (
    "shapes of the plates of the MIT push dataset (Yu et al. 2016): what abs says of them "
    "(abs-floor), which is nearly flat; made by python -m tests.inference.measured_floors plates "
    "FOLDER"
)
# Where the robot drags to.
TARGET = (0.35, -0.03)
RUNS = 100
# Floors drawn from what the joint fit leaves open, and runs on each.
DRAWS = 60
RUNS_OF_DRAW = 10


def folder() -> Path:
    return Path(os.environ.get("CYCLEMAP_DATA", Path(__file__).parents[3] / "shared" / "data"))


@dataclass(frozen=True)
class Floor:
    """A floor as it was fitted: what was found, and the material of it."""

    found: Identification
    material: Material


def fitted(
    floor: str,
    speeds: Sequence[int],
    plates: Sequence[str] = PLATES,
    *,
    drags: bool = False,
    most: int = MOST,
    known: Material | None = None,
    shapes: Sequence[PlatePressure] = (),
    begin: Material | None = None,
    other: Material | None = None,
) -> Floor:
    """Fit a floor as `cyclemap identify` does, with isotropic friction: on these boards the ellipse
    gains nothing.

    known : as of `--floor`.
    shapes : as of `--plate`.
    begin : at whose shapes the search begins.
    other : another floor, whose plates are believed to have the shapes that they have there, to
        within what is known of them.
    """
    data = [folder() / name for speed in speeds for name in PUSHES[speed]]
    data += [folder() / DRAGS] * drags
    loop = CollectionLoop.mit("isotropic")
    chosen = {"surface": floor, "object": plates[0]}
    if len(plates) > 1:
        del chosen["object"]
    is_new = known is not None
    collected = collected_blocks(data, loop, chosen, most=most, population=is_new, target=TARGET)
    blocks = of_plates(collected.blocks, plates)
    free = telling_parameters(blocks, believed=())
    fixed = held_values(blocks, SURFACE, free, known) | known_shapes(shapes, blocks, plates[0])
    free = tuple(name for name in free if name not in fixed)
    beliefs = usual_beliefs(free) | known_beliefs(known, free, plates[0])
    beliefs |= known_beliefs(other, [name for name in free if name.startswith("plate_")], plates[0])
    blocks, space = begun(blocks, begin, plates[0])
    options = {"starts": 1, "student": STUDENT, "noise": known_spread(known, blocks)}
    found = identify(blocks, free, fixed, priors=beliefs, space=space, **options)
    source = ", ".join(["the MIT push dataset (Yu et al. 2016)", *(f"{v} mm/s" for v in speeds)])
    source += "".join(f"; {note}" for note in collected.notes if "odd session" in note)
    if other is not None:
        source += f"; plates believed to be as on {other.name}, to within what is known of them"
        source += " there"
    name, plate = f"{floor}-floor", plates[0]
    return Floor(found, identified_material(found, name, [source], plate=plate, floor=known))


def begun(
    blocks: Sequence[DataBlock], begin: Material | None, plate: str
) -> tuple[list[DataBlock], ParameterSpace]:
    """Let the search begin at the shapes of a material."""
    if begin is None:
        return list(blocks), SURFACE
    shapes = {one.plate: one.shape.bend for one in begin.plates}
    heights = held_values(blocks, SURFACE, (), begin)

    def started(one: Parameter) -> Parameter:
        plain, _, owner = one.name.partition("[")
        at = heights.get(one.name, one.start)
        if plain in FLOOR_NAMES:
            at = begin.floor.bend[FLOOR_NAMES.index(plain)]
        elif plain in PLATE_NAMES:
            at = shapes.get(owner.rstrip("]") or plate, np.zeros(3))[PLATE_NAMES.index(plain)]
        return replace(one, start=float(at))

    changed = []
    for block in blocks:
        changed.append(replace(block, own_parameters=tuple(map(started, block.own_parameters))))
    return changed, ParameterSpace(tuple(map(started, SURFACE.parameters)))


def of_plates(blocks: Sequence[DataBlock], plates: Sequence[str]) -> list[DataBlock]:
    """The blocks of some of the plates, and how their sessions differ; all blocks of all plates."""
    if len(plates) in (1, len(PLATES)):
        return list(blocks)
    kept = [block for block in blocks if block.name.split()[0] in plates]
    names = {name for block in kept for name in block.parameters if name.startswith("floor_dome[")}
    return [*kept, session_block(sorted(name.partition("[")[2].rstrip("]") for name in names))]


def measured(floor: str, plate: str, speed: int, most: int = 150) -> list[MeasuredPush]:
    """Pushes of a session, evenly spread."""
    pushes: list[MeasuredPush] = []
    for name in PUSHES[speed]:
        rows = known_columns(read_csv_table(folder() / name), (*ENDS, *RODS))
        pushes += measured_pushes(selected(rows, RowSelection((plate,), {"surface": floor}))[0])
    spread = np.linspace(0, len(pushes) - 1, min(most, len(pushes))).astype(int)
    return [pushes[place] for place in np.unique(spread)]


def errors(
    material: Material, plate: str, pushes: Sequence[MeasuredPush], session: str = ""
) -> tuple[float, float]:
    """Mean distance (mm) and turn (degrees) by which pushes miss; in the shape of a session that
    was seen.
    """
    slider, known = Slider.mit(plate), material.pressure_of(plate)
    floor = next((one.shape for one in material.sessions if one.name == session), material.floor)
    shapes = dict(zip(FLOOR_NAMES, floor.bend.tolist(), strict=True))
    if known is not None:
        shapes |= zip(PLATE_NAMES, known.shape.bend.tolist(), strict=True)
    rod = material.found_with.pusher_friction or 0.15
    surface = SurfaceParameters.from_friction(material.friction, pusher_friction=rod, **shapes)
    shift = next(((one.x, one.y) for one in material.frames if one.plate == plate), (0.0, 0.0))
    model, rows = surface_model(surface, slider, field=material.field), []
    for push in pushes:
        # One push in hundreds has no answer: the rod grazes a tip.
        with suppress(ConvergenceError, UnsupportedContact):
            end = predicted_push_ends(model, [push], shift, (), TARGET)[0][0]
            rows.append(end - (push.end.x, push.end.y, push.end.theta))
    off = np.array(rows)
    turn = np.degrees(np.mean(np.abs(off[:, 2])))
    return float(1e3 * np.mean(np.hypot(off[:, 0], off[:, 1]))), float(turn)


def report(title: str, rows: dict[str, tuple[float, float]]) -> None:
    mean = np.mean([*rows.values()], axis=0)
    told = " | ".join(f"{plate} {mm:.2f}/{deg:.2f}" for plate, (mm, deg) in rows.items())
    print(f"{title}: {told} | MEAN {mean[0]:.2f}/{mean[1]:.2f}", flush=True)


def on_both(floor: str, other: str, plates: Sequence[str] = PLATES) -> Material:
    """Fit a floor to 10 mm/s, its plates believed to be what the other floor's pushes at 10 mm/s
    tell.
    """
    alone, there = fitted(floor, (10,), plates).material, fitted(other, (10,)).material
    begin = replace(alone, plates=there.plates, posterior=None)
    return fitted(floor, (10,), plates, most=MOST_JUDGED, begin=begin, other=there).material


def judge() -> None:
    """Fit to 10 mm/s, judge on 20 mm/s."""
    for floor, other in zip(FLOORS, FLOORS[::-1], strict=True):
        found = on_both(floor, other)
        flat = Material("flat", found.friction, found_with=found.found_with, frames=found.frames)
        pushes = {plate: measured(floor, plate, 20) for plate in PLATES}
        for title, known in (("isotropic and flat", flat), ("floor's mean", found)):
            rows = {plate: errors(known, plate, own) for plate, own in pushes.items()}
            report(f"{floor}, {title}", rows)
        at_ten = {}
        for plate, own in pushes.items():
            at_ten[plate] = errors(found, plate, own, session_name(plate, 0.01))
        report(f"{floor}, that plate's session", at_ten)
        print(material_toml(replace(found, posterior=None)), flush=True)


def left_out(plate: str) -> None:
    """Leave a plate out of a floor's fit: with its shape from the other floor, and with ten of its
    own pushes, too.
    """
    others = [name for name in PLATES if name != plate]
    for floor, other in zip(FLOORS, FLOORS[::-1], strict=True):
        there, pushes = fitted(other, (10,)).material, measured(floor, plate, 20)
        known, shape = on_both(floor, other, others), there.pressure_of(plate)
        assert shape is not None
        carried = fitted(floor, (10,), (plate,), most=10, known=known, shapes=(shape,)).material
        own = fitted(floor, (10,), (plate,), most=10, known=known, other=there).material
        title = f"{floor}, shape from {other}, frame from ten pushes"
        report(title, {plate: errors(carried, plate, pushes)})
        report(f"{floor}, ten pushes", {plate: errors(own, plate, pushes)})


def staircase() -> None:
    """Fit rect1 on plywood to pushes, drags and every second block of 100 cycles at once; judge
    what was left out.
    """
    data = [folder() / name for name in (PUSHES[10][0], DRAGS, CYCLES)]
    loop = CollectionLoop.mit("isotropic")
    chosen = {"surface": "plywood", "object": "rect1"}
    collected = collected_blocks(data, loop, chosen, wear=True, most=MOST)
    blocks, space = begun(collected.blocks, load_material("plywood-floor"), "rect1")
    (place,) = (number for number, block in enumerate(blocks) if block.curve is not None)
    cycles = blocks[place]
    pushes = next(block for block in blocks if block.name.endswith("push ends"))
    seen = np.arange(len(cycles.groups)) // 100 % 2 == 0
    blocks[place] = cycles.subset(seen)
    free = telling_parameters(blocks)
    options = {"priors": usual_beliefs(free), "starts": 1, "student": STUDENT}
    found = identify(blocks, free, space=space, **options)
    off = np.degrees(cycles.residuals(found.values)[0])
    assert cycles.motions is not None
    theta, late = cycles.motions[:, 0] % (2.0 * np.pi), np.arange(len(off)) >= 500
    bins = (theta // np.radians(10.0)).astype(int)
    by_bins = [np.mean(off[late & (bins == index)]) for index in np.unique(bins[late])]
    size, map_size = (np.sqrt(np.mean(np.square(miss))) for miss in (off[~seen], by_bins))
    print(f"cycles left out: {size:.2f} deg root mean square, ", end="")
    print(f"median {np.median(np.abs(off[~seen])):.2f}; map {map_size:.2f}")
    judged = push_end_block(measured("plywood", "rect1", 20), Slider.mit("rect1"))
    ends = judged.function(pushes.own_values(found.values))[0].reshape(-1, 3)
    place_off, turn_off = 1e3 * np.hypot(*ends.T[:2]), np.degrees(np.abs(ends[:, 2]))
    print(f"pushes at 20 mm/s: {place_off.mean():.2f} mm, {turn_off.mean():.2f} deg")
    for one in found.estimates:
        print(f"  {one.name} {one.value:.4g} ({one.lower:.4g} to {one.upper:.4g})")
    print("\n".join(found.notes))
    robot = read_theta0_pairs(folder() / CYCLES).path
    assert robot is not None
    starts = np.full(RUNS, robot[0])
    likeliest = joint_runs(found, collected.last_cycle, starts, 0)
    print_beside("of the likeliest floor", likeliest, robot)
    runs = []
    for index, values in enumerate(sampled_values(found, DRAWS, seed=1)):
        vector = np.array([values[name] for name in found.problem.space.names])
        drawn = replace(found, fit=replace(found.fit, vector=vector))
        # A floor at the edge of what is possible may not be able to make every cycle.
        with suppress(ConvergenceError, UnsupportedContact):
            runs.append(joint_runs(drawn, collected.last_cycle, starts[:RUNS_OF_DRAW], index))
    print_beside(f"of {len(runs)} floors as likely", np.concatenate(runs), robot)


def joint_runs(
    found: Identification, last_cycle: float, starts: np.ndarray, seed: int
) -> np.ndarray:
    """Lifts of staircases (runs, cycles + 1) on the floor as it was in the session of the cycles,
    with the noise that `plywood-measured` has.
    """
    sources = ["pushes, drags and cycles"]
    material = identified_material(found, "joint", sources, last_cycle=last_cycle)
    session = next(row for row in material.sessions if row.name.endswith(Path(CYCLES).stem))
    assert material.wear is not None and material.wear.floor is not None
    worn = material.wear.floor.bend + session.shape.bend - material.floor.bend
    wear = replace(material.wear, floor=SurfaceShape.of_bend(*worn.tolist()))
    loop = CollectionLoop.mit(replace(material, floor=session.shape, wear=wear, posterior=None))
    noise = load_material("plywood-measured").noise
    assert noise is not None
    local = LocalNoise(noise.log_sigma, noise.correlation)
    count = int(last_cycle) + 1
    drifting = drifting_map(loop, count, math.radians(0.05))
    return sample_staircases(drifting, local, count, starts, seed=seed)


def print_beside(title: str, runs: np.ndarray, robot: np.ndarray) -> None:
    """Print how far histogram of θ0 and turns of the runs are from those of the robot, and how far
    single runs are from their own mean histogram: no model can be expected nearer.
    """
    for first, last in ((0, 500), (500, 1000), (1000, 1500), (1500, 2000), (500, 2000), (0, 2000)):
        end = min(last, len(robot) - 1)
        densities = np.array([histogram_10_deg(run[first:last]) for run in runs])
        mean = np.mean(densities, axis=0)
        off = 0.5 * np.abs(mean - histogram_10_deg(robot[first:last])).sum()
        own = np.median(0.5 * np.abs(densities - mean).sum(axis=1))
        turns = (runs[:, end] - runs[:, first]) / (2.0 * np.pi)
        low, middle, high = np.quantile(turns, (0.025, 0.5, 0.975))
        made = (robot[end] - robot[first]) / (2.0 * np.pi)
        print(f"{title}, pushes {first} to {last}: histogram {off:.3f} in total variation ", end="")
        print(f"(a run's own {own:.3f}), {middle:.1f} turns ({low:.1f} to {high:.1f}), ", end="")
        print(f"the robot's {made:.1f}")


def histogram_10_deg(theta: np.ndarray) -> np.ndarray:
    """Shares of the orientations in bins of 10 degrees."""
    counts = np.histogram(theta % (2.0 * np.pi), 36, (0.0, 2.0 * np.pi))[0]
    return counts / theta.size


def make(target: Path, floor: str) -> None:
    """Write a floor's material, fitted to all."""
    begin, other = load_material(f"{floor}-floor"), None
    if floor == "plywood":
        other = load_material("abs-floor")
        begin = replace(begin, plates=other.plates)
    options = {"drags": True, "most": MOST_MADE, "begin": begin, "other": other}
    material = fitted(floor, (10, 20), **options).material
    made = f"made by python -m tests.inference.measured_floors make FOLDER {floor}"
    told = replace(material, provenance=f"{material.provenance}; {made}")
    (target / f"{material.name}.toml").write_text(material_toml(told))


def plates(target: Path) -> None:
    """Write the shapes of plates as abs tells them: on its pushes at 20 mm/s those of plywood miss
    by 3.0 mm, 4.7° instead of 2.4 mm, 3.4°, on plywood's those of abs by 2.2 mm, 2.3° instead of
    2.1 mm, 2.2°: what rests over a trough tells little of its middle.
    """
    known = load_material(target / "abs-floor.toml")
    lines = [f"provenance = {json.dumps(PLATES_PROVENANCE)}\n"]
    for plate in PLATES:
        own = known.pressure_of(plate)
        assert own is not None
        numbers = shape_numbers(own.shape, PLATE_SHAPE_KEYS)
        rows = [f"{key} = {value:.3f}" for key, value in numbers.items()]
        lines += [f"[plates.{plate}]", *rows, ""]
    (target / "plates.toml").write_text("\n".join(lines))


if __name__ == "__main__":
    command, *rest = sys.argv[1:] or ["judge"]
    if command == "make":
        make(Path(rest[0]), rest[1])
    elif command == "plates":
        plates(Path(rest[0]))
    elif command == "left-out":
        left_out(rest[0])
    elif command == "staircase":
        staircase()
    else:
        judge()
