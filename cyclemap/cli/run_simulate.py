"""`cyclemap simulate`: a simulated collection as files, and what became of it, in words or as JSON."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import PeopleConsole, progress_bar, publish_json
from cyclemap.cli.settings import ChosenCollection, chosen_collection
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence.recorded_push import RecordingNoise
from cyclemap.evidence.simulated_collection import simulate_collection
from cyclemap.maps import LocalNoise
from cyclemap.mechanics import load_material

# Far below any noise of a cycle, and twice as fast as the default.
ACCURACY = 1e-6


@dataclass(frozen=True)
class SimulationRequest:
    """What is asked of `cyclemap simulate` besides the loop, in the units of the command line."""

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


def run_simulate(options: LoopOptions, request: SimulationRequest, json_target: str | None) -> None:
    """Write the collection that is asked for, or the rest of it, and tell where it is."""
    chosen = chosen_collection(options).simplified()
    loop, cycle_by_cycle = _prepared(chosen, request)
    own = loop.material.noise if request.noise_deg is None and chosen.sigma is None else None
    measured = None if own is None else LocalNoise(own.log_sigma, own.correlation)
    sigma = DEFAULT_SIGMA if chosen.sigma is None else chosen.sigma
    noise = RecordingNoise(
        turn=sigma if request.noise_deg is None else math.radians(request.noise_deg),
        position=1e-3 * request.pose_noise_mm,
        angle=math.radians(request.pose_noise_deg),
        force=request.force_noise_n,
    )
    with progress_bar(f"collection on {loop.material.name}") as report:
        made = simulate_collection(
            loop,
            request.folder,
            request.cycles,
            start=math.radians(request.start_deg),
            noise=noise,
            cycle_noise=measured,
            speed=1e-3 * request.speed_mm_s,
            wear_to=None if request.wear_to is None else load_material(request.wear_to),
            seed=request.seed,
            scans=request.scans,
            suffix=f".{request.suffix}",
            progress=report,
            **cycle_by_cycle,
        )
    report_json: Json = {
        "folder": str(made.folder),
        "cycles": made.cycles,
        "written": made.written,
        "resumed": made.resumed,
        "theta0_deg_last": math.degrees(made.theta_last),
        "bytes": made.bytes,
    }
    if publish_json(report_json, json_target):
        return
    scans = f" and {made.scans} friction scans" if made.scans else ""
    last = f"The last push starts at θ0 = {math.degrees(made.theta_last):.2f}°, counted without wrapping."
    told = [last, f"next: cyclemap fit {made.folder}"]
    if made.resumed:
        told.insert(0, f"{made.resumed} of the pushes were there already, {made.written} were added.")
    PeopleConsole().tell(f"{made.cycles} pushes{scans} in {made.folder}, {made.bytes / 1e6:.1f} MB", *told)


def _prepared(chosen: ChosenCollection, request: SimulationRequest) -> tuple[CollectionLoop, dict[str, Any]]:
    """The loop, and what a strategy changes of it from cycle to cycle: the same that its schedule of this seed says."""
    loop, strategy = replace(chosen.loop, accuracy=ACCURACY), chosen.strategy
    if strategy is None:
        return loop, {}
    loop = strategy.prepared(loop)
    actions = strategy.run(request.cycles, request.seed)
    turns = tuple(action.turn for action in actions)
    return loop, {"cycle_loops": tuple(action.on(loop) for action in actions), "gripper_turns": turns}
