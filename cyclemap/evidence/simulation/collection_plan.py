"""What a simulated collection is asked to be: enough to make any of its cycles again, and to tell it from another."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from importlib.metadata import version

import numpy as np

from cyclemap.checks import finite_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.push_files import SUFFIXES
from cyclemap.evidence.simulation.recorded_motion import FIRST_CLOCK, Recording, RecordingNoise
from cyclemap.evidence.simulation.recorded_push import recorded_seconds
from cyclemap.maps import LocalNoise
from cyclemap.mechanics import Material, SidePush
from cyclemap.mechanics.friction import worn_friction

Arguments = dict[str, str | int | float | bool]

# Streams of random numbers: what one cycle draws of each depends on the seed and its number alone.
TURN, INSTRUMENTS, SCANS = 0, 1, 2
# Seconds between two records besides the way back, which takes as long as the push: time to get in and out of the ring.
_HANDLING_SECONDS = 10.0
_LONGEST_ARGUMENT = 500


@dataclass(frozen=True)
class CollectionPlan:
    """A collection of `cycles` pushes that `loop` makes from orientation `start` (rad) on.

    noise : see `RecordingNoise`. cycle_noise : the scatter of θ0 in place of `noise.turn`, where it depends on θ0 or on
    the cycle before. speed : m/s, of the rod. wear_to : the surface at the last cycle; the loop's own is
    that at the first, and the limit ellipse goes from the one to the other in a straight line (see `worn_friction`);
    None: the surface wears as its material says.
    seed : of all random numbers. scans : whether friction scans, of the fresh surface, come first. suffix : of files.
    cycle_loops : the loop of each of the `cycles`, where pushes or way-points change from one to the next; None: `loop`
    in all. gripper_turns : rad, of each cycle, by which a gripper turns the object after the drag; None: none.

    Raises InvalidInput for a value that cannot be used.
    """

    loop: CollectionLoop
    cycles: int
    start: float = 0.0
    noise: RecordingNoise = RecordingNoise()
    speed: float = 0.020
    wear_to: Material | None = None
    seed: int = 0
    scans: bool = False
    suffix: str = ".h5"
    cycle_loops: tuple[CollectionLoop, ...] | None = None
    gripper_turns: tuple[float, ...] | None = None
    cycle_noise: LocalNoise | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "cycles", whole_number("cycles", self.cycles, least=1))
        object.__setattr__(self, "start", finite_number("start", self.start))
        object.__setattr__(self, "seed", whole_number("seed", self.seed, least=0))
        if self.suffix not in SUFFIXES:
            raise InvalidInput(f"suffix is {self.suffix!r}; choose one of {', '.join(SUFFIXES)}")
        object.__setattr__(self, "speed", Recording(self.speed).speed)
        self._check_cycles()

    def _check_cycles(self) -> None:
        """One entry a cycle, and the loops alike but for their pushes and way-points."""
        for name in ("cycle_loops", "gripper_turns"):
            given = getattr(self, name)
            if given is not None and len(given) != self.cycles:
                raise InvalidInput(f"{name} has {len(given)} entries for {self.cycles} cycles: give one a cycle")
        for number, loop in enumerate(self.cycle_loops or ()):
            if replace(loop, push=self.loop.push, reset=self.loop.reset) != self.loop:
                raise InvalidInput(f"cycle_loops: the loop of cycle {number} differs in more than push and reset")
        for turn in self.gripper_turns or ():
            finite_number("gripper turn", turn)

    def loop_at(self, cycle: int) -> CollectionLoop:
        """The loop with the surface as worn as it is at `cycle` (from 0)."""
        loop = self.loop if self.cycle_loops is None else self.cycle_loops[cycle]
        if self.wear_to is None:
            return worn_loop(loop, cycle)
        share = cycle / (self.cycles - 1) if self.cycles > 1 else 0.0
        friction = worn_friction(loop.material.friction, self.wear_to.friction, share)
        return replace(loop, material=replace(loop.material, friction=friction))

    def push_at(self, cycle: int) -> SidePush:
        """The push of `cycle`."""
        return self.loop.push if self.cycle_loops is None else self.cycle_loops[cycle].push

    def gripper_turn_at(self, cycle: int) -> float:
        """The turn (rad) by a gripper after the drag of `cycle`."""
        return 0.0 if self.gripper_turns is None else self.gripper_turns[cycle]

    def generator(self, stream: int, number: int) -> np.random.Generator:
        """The random numbers of one stream for one cycle, the same whatever was drawn before."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(stream, number)))

    def kick(self, cycle: int, theta: float) -> float:
        """By how much noise turns θ0 (rad) in `cycle`, that began at `theta`: the same whatever was drawn before."""
        size = self.noise.turn if self.cycle_noise is None else float(self.cycle_noise.sigma(theta))
        return size * self._scatter[cycle]

    @cached_property
    def _scatter(self) -> list[float]:
        """The scatter of each cycle in standard deviations, as alike as successive cycles are."""
        rho = 0.0 if self.cycle_noise is None else self.cycle_noise.correlation
        drawn = [float(self.generator(TURN, cycle).standard_normal()) for cycle in range(self.cycles)]
        for cycle in range(1, self.cycles):
            drawn[cycle] = rho * drawn[cycle - 1] + math.sqrt(1.0 - rho**2) * drawn[cycle]
        return drawn

    def recording(self, cycle: int) -> Recording:
        """How the push of `cycle` is recorded."""
        start = FIRST_CLOCK + cycle * self._period
        return Recording(self.speed, start, self.noise, self.loop.pusher.radius)

    @cached_property
    def _period(self) -> float:
        """Whole seconds from one record to the next."""
        longest = max(loop.push.distance for loop in self.cycle_loops or (self.loop,))
        return math.ceil(2.0 * recorded_seconds(longest, self.speed) + _HANDLING_SECONDS)

    def arguments(self) -> Arguments:
        """Everything that the files depend on, by name: numbers and texts; long texts are cut to a hash."""
        loop, noise = self.loop, self.noise
        wear = loop.material.wear if self.wear_to is None else self.wear_to.friction
        parts = {field.name: getattr(loop, field.name) for field in fields(loop) if field.name != "material"}
        return {
            "version": version("cyclemap"),
            "cycles": self.cycles,
            "seed": self.seed,
            "start_rad": self.start,
            "material": loop.material.name,
            "friction": repr(loop.material.friction),
            "wear_to": "none" if wear is None else repr(wear),
            **{name: _short(repr(part)) for name, part in parts.items()},
            "speed_m_s": self.speed,
            "noise_turn_rad": noise.turn,
            **({} if self.cycle_noise is None else {"cycle_noise": _short(repr(self.cycle_noise))}),
            "noise_position_m": noise.position,
            "noise_angle_rad": noise.angle,
            "noise_force_n": noise.force,
            "scans": self.scans,
            "suffix": self.suffix,
            **self._cycle_arguments(),
        }

    def _cycle_arguments(self) -> Arguments:
        """What is done cycle by cycle, as a hash; nothing where all cycles are alike."""
        if self.cycle_loops is None and self.gripper_turns is None:
            return {}
        told = [(loop.push, loop.reset) for loop in self.cycle_loops or ()], self.gripper_turns
        return {"cycle_by_cycle": hashlib.sha256(repr(told).encode()).hexdigest()}


def _short(text: str) -> str:
    if len(text) <= _LONGEST_ARGUMENT:
        return text
    return f"{text[:60]}... (sha256 {hashlib.sha256(text.encode()).hexdigest()})"
