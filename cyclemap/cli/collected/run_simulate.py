"""`cyclemap simulate`: a simulated collection as files, and what became of it,
in words or as JSON."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cyclemap.cli.output import PeopleConsole, progress_bar, publish_json
from cyclemap.evidence.recorded_push import RecordingNoise
from cyclemap.evidence.simulated_collection import SimulatedCollection, simulate_collection
from cyclemap.maps import LocalNoise
from cyclemap.mechanics import load_material
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_collection
from cyclemap.written import json_of

# Far below any noise of a cycle, and twice as fast as the default.
ACCURACY = 1e-6


@dataclass(frozen=True)
class SimulateOptions:
    """What `cyclemap simulate` was asked, as it was typed."""

    options: LoopOptions
    folder: Path
    cycles: int
    seed: int
    start_deg: float
    noise_deg: float | None
    pose_noise_mm: float
    pose_noise_deg: float
    force_noise_n: float
    wear_to: str | None
    speed_mm_s: float
    scans: bool
    suffix: str
    json_target: str | None


def run_simulate(asked: SimulateOptions) -> None:
    """Write the collection that is asked for, or the rest of it, and tell where it is."""
    chosen = chosen_collection(asked.options).simplified()
    loop = replace(chosen.loop, accuracy=ACCURACY)
    strategy = chosen.strategy
    cycle_by_cycle = dict[str, Any]()
    if strategy is not None:
        # What it changes from cycle to cycle is the same that its schedule of this seed says.
        loop = strategy.prepared(loop)
        actions = strategy.run(asked.cycles, asked.seed)
        cycle_by_cycle["cycle_loops"] = tuple(action.on(loop) for action in actions)
        cycle_by_cycle["gripper_turns"] = tuple(action.turn for action in actions)
    own = loop.material.noise if asked.noise_deg is None and chosen.sigma is None else None
    with progress_bar(f"collection on {loop.material.name}") as report:
        made = simulate_collection(
            loop,
            asked.folder,
            asked.cycles,
            start=math.radians(asked.start_deg),
            noise=_noise(asked, chosen.noise),
            cycle_noise=None if own is None else LocalNoise(own.log_sigma, own.correlation),
            speed=1e-3 * asked.speed_mm_s,
            wear_to=None if asked.wear_to is None else load_material(asked.wear_to),
            seed=asked.seed,
            scans=asked.scans,
            suffix=f".{asked.suffix}",
            progress=report,
            **cycle_by_cycle,
        )
    as_json = {
        **json_of(made, "folder", "cycles", "written", "resumed"),
        "theta0_deg_last": math.degrees(made.theta_last),
        "bytes": made.bytes,
    }
    if not publish_json(as_json, asked.json_target):
        PeopleConsole().tell(*_sentences(made))


def _noise(asked: SimulateOptions, turn: float) -> RecordingNoise:
    """The noise that is asked for; turn : rad, of a cycle where none is."""
    return RecordingNoise(
        turn=turn if asked.noise_deg is None else math.radians(asked.noise_deg),
        position=1e-3 * asked.pose_noise_mm,
        angle=math.radians(asked.pose_noise_deg),
        force=asked.force_noise_n,
    )


def _sentences(made: SimulatedCollection) -> tuple[str, ...]:
    scans = f" and {made.scans} friction scans" if made.scans else ""
    added = f"{made.resumed} of the pushes were there already, {made.written} were added."
    last = f"{math.degrees(made.theta_last):.2f}°, counted without wrapping"
    return (
        f"{made.cycles} pushes{scans} in {made.folder}, {made.bytes / 1e6:.1f} MB",
        added if made.resumed else "",
        f"The last push starts at θ0 = {last}.",
        f"next: cyclemap fit {made.folder}",
    )
