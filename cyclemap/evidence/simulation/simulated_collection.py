"""A simulated collection: the files that a robot would have left behind, made cycle by cycle, to be gone on with."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError
from cyclemap.evidence.pushes.push_record import PushRecord
from cyclemap.evidence.pushes.push_writer import write_push_file
from cyclemap.evidence.simulation.collection_folder import CollectionFolder
from cyclemap.evidence.simulation.collection_plan import INSTRUMENTS, SCANS, CollectionPlan
from cyclemap.evidence.simulation.friction_scan import record_scan, scan_set
from cyclemap.evidence.simulation.recorded_push import record_push
from cyclemap.whole_files import only_writer

# Longest step (m) of a recorded push, as a share of its travel: between the steps the record is interpolated.
_RECORDED = 60


@dataclass(frozen=True)
class SimulatedCollection:
    """A complete collection.

    folder : where it is. cycles : pushes in it. written, resumed : how many of them were made now and found there.
    scans : friction scans in it. theta_last : rad, not wrapped, the true θ0 of the last push.
    bytes : size of all its files of pushes and scans.
    """

    folder: Path
    cycles: int
    written: int
    resumed: int
    scans: int
    theta_last: float
    bytes: int


def simulate_collection(
    loop: CollectionLoop,
    folder: str | Path,
    cycles: int,
    *,
    progress: Callable[[float], None] | None = None,
    **asked: Any,
) -> SimulatedCollection:
    """Write a collection of `cycles` pushes as files of the MIT layout, or go on with one that was begun.

    Cycle n starts at θ0 = θ_n, is run with the friction of its day, and θ_{n+1} = F_n(θ_n) + α_n + ξ_n with
    ξ_n ~ N(0, noise.turn²), or as `cycle_noise` says, F_n the cycle map of its loop (to `loop.accuracy`) and α_n the
    turn by a gripper, if any.
    The drag back is not recorded. See `record_push` for the series and their accuracy, `record_scan` for scans.

    asked : fields of `CollectionPlan`: start (rad), noise (`RecordingNoise`), cycle_noise (`LocalNoise`), speed (m/s),
    wear_to (`Material`), seed, scans, suffix, cycle_loops, gripper_turns (rad). progress : called with the fraction
    done.

    Every file is there whole or not at all. Random numbers depend on seed and cycle alone, so that a run that was
    broken off and is called again with the same arguments ends with the files of an undisturbed one, bit for bit:
    what was changed, cut or emptied since it was written is made again, and all pushes behind it.

    Raises InvalidInput for bad arguments, a folder that holds something else or was begun with others; CycleMapError
    where another process writes to it; OSError where
    it cannot be written; ConvergenceError or UnsupportedContact where a push leads out of what the mechanics can do.

    >>> import tempfile
    >>> from cyclemap.evidence.pushes.push_table import load_pushes
    >>> from cyclemap.evidence.simulation.recorded_motion import RecordingNoise
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     made = simulate_collection(loop, f"{place}/made", 3, noise=RecordingNoise(turn=0.0))
    ...     pushes = load_pushes(made.folder).table
    >>> made.written, round(made.theta_last, 4)
    (3, 0.309)
    >>> pushes["repetition"].tolist(), pushes["dtheta"].round(4).tolist()
    ([0.0, 1.0, 2.0], [1.2855, 1.2879, 1.289])
    """
    plan = CollectionPlan(loop, cycles, **asked)
    report = progress or (lambda fraction: None)
    with only_writer(Path(folder)):
        home = CollectionFolder(folder, plan)
        scans = _write_scans(home, plan) if plan.scans else 0
        theta = home.known_theta()
        resumed = len(theta) - 1
        for cycle in range(resumed, plan.cycles):
            record, following = _run(plan, cycle, theta[-1])
            write_push_file(home.push_path(cycle), record)
            home.append_truth(cycle + 1, following)
            theta.append(following)
            report((cycle + 1) / plan.cycles)
    written = plan.cycles - resumed
    return SimulatedCollection(home.folder, plan.cycles, written, resumed, scans, theta[-2], home.size())


def _run(plan: CollectionPlan, cycle: int, theta: float) -> tuple[PushRecord, float]:
    """The record of a cycle's push from `theta`, and the θ0 after its drag (rad)."""
    loop = plan.loop_at(cycle)
    try:
        push, back = loop.strokes(theta, loop.push.distance / _RECORDED)
    except CycleMapError as error:
        raise type(error)(f"cycle {cycle}, from θ0 = {math.degrees(theta):.3f} degrees: {error}") from error
    instruments = plan.generator(INSTRUMENTS, cycle)
    record = record_push(push, loop.push.distance, plan.recording(cycle), instruments)
    return record, back.end.theta + plan.gripper_turn_at(cycle) + plan.kick(cycle, theta)


def _write_scans(home: CollectionFolder, plan: CollectionPlan) -> int:
    """Write the scans, anew if they are there: they are quick; return how many there are."""
    count, friction, weight = 0, plan.loop.material.friction, plan.loop.model.weight
    for count, scan in enumerate(scan_set(home.surface, home.shape, plan.speed), 1):
        record = record_scan(friction, weight, scan.direction, plan.recording(0), plan.generator(SCANS, count))
        write_push_file(home.scan_path(scan), record)
    return count
