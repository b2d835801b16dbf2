"""A simulated collection: the files that a robot would have left behind, made cycle by cycle, to be
gone on with.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.checks import finite_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence.pushes.push_files import write_push_file
from cyclemap.evidence.pushes.recordings import PushFacts, push_name, scan_name
from cyclemap.evidence.recorded_push import (
    APPROACH,
    FIRST_CLOCK,
    Recording,
    RecordingNoise,
    record_push,
    record_scan,
    recorded_seconds,
    scan_set,
)
from cyclemap.evidence.tables.data_kinds import SUFFIXES
from cyclemap.maps import LocalNoise
from cyclemap.mechanics import Material
from cyclemap.mechanics.friction import worn_friction
from cyclemap.plain_text import plain_number
from cyclemap.progress import Progress, part_of
from cyclemap.protocol.collection_file import FILE_NAME, SIMULATION, collection_text
from cyclemap.text_files import UNFINISHED_SUFFIX, file_stem, only_writer, read_toml, write_whole
from cyclemap.written import toml_text

Arguments = dict[str, str | int | float | bool]

# Streams of random numbers: what one cycle draws of each depends on the seed and its number alone.
TURN = 0
INSTRUMENTS = 1
SCANS = 2
# Seconds between two records besides the way back, which takes as long as the push: time to get in
# and out of the ring.
_HANDLING_SECONDS = 10.0
_LONGEST_ARGUMENT = 500
# Neither is a kind of file that readers of push data look at.
TRUTH_FILE = "true_theta0.txt"
_COMMENTS = (
    "The collection that these data are of; [simulation] is what was asked when they were made.",
)
PUSH_FOLDER = "normal"
SCAN_FOLDER = "friction_scan"
# Longest step (m) of a recorded push, as a share of its travel: between the steps the record is
# interpolated.
_RECORDED = 60


@dataclass(frozen=True)
class CollectionPlan:
    """A collection that a loop makes.

    Parameters
    ----------
    loop : CollectionLoop
        Who is pushed where, on what.
    cycles : int
        How many pushes.
    start : float, default 0.0
        Orientation before the first, rad.
    noise : RecordingNoise, optional
        Of the cycles and of the instruments.
    speed : float, default 0.02
        Of the rod, m/s.
    wear_to : Material or None, optional
        The surface at the last cycle, to which the limit ellipse goes in a straight line from
        the loop's own (see `worn_friction`); None: it wears as its material says.
    seed : int, default 0
        Of all noise.
    scans : bool, default False
        Whether friction scans, of the fresh surface, come first.
    suffix : str, default '.h5'
        Of files.
    cycle_loops : tuple of CollectionLoop, default ()
        The loop of each of the `cycles`, where pushes or way-points change; else none.
    gripper_turns : tuple of float, default ()
        Of each cycle, by which a gripper turns the object after the drag, rad; none without one.
    cycle_noise : LocalNoise or None, optional
        The scatter of θ0 in place of `noise.turn`, where it depends on θ0 or on the cycle
        before.

    Raises
    ------
    InvalidInput
        For a value that cannot be used.
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
    cycle_loops: tuple[CollectionLoop, ...] = ()
    gripper_turns: tuple[float, ...] = ()
    cycle_noise: LocalNoise | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "cycles", whole_number("cycles", self.cycles, least=1))
        object.__setattr__(self, "start", finite_number("start", self.start))
        object.__setattr__(self, "seed", whole_number("seed", self.seed, least=0))
        if self.suffix not in SUFFIXES:
            raise InvalidInput(f"suffix is {self.suffix!r}; choose one of {', '.join(SUFFIXES)}")
        object.__setattr__(self, "speed", Recording(self.speed).speed)
        for name in ("cycle_loops", "gripper_turns"):
            given = getattr(self, name)
            if given and len(given) != self.cycles:
                raise InvalidInput(
                    f"{name} has {len(given)} entries for {self.cycles} cycles: give one a cycle"
                )
        for cycle, loop in enumerate(self.cycle_loops):
            if replace(loop, push=self.loop.push, reset=self.loop.reset) != self.loop:
                raise InvalidInput(
                    f"cycle_loops: the loop of cycle {cycle} differs in more than push and reset"
                )
        for turn in self.gripper_turns:
            finite_number("gripper turn", turn)

    def new_loop_at(self, cycle: int) -> CollectionLoop:
        """The loop of `cycle` (from 0) with the surface as it was at first."""
        return self.cycle_loops[cycle] if self.cycle_loops else self.loop

    def loop_at(self, cycle: int) -> CollectionLoop:
        """The loop with the surface as worn as it is at `cycle` (from 0)."""
        loop = self.new_loop_at(cycle)
        if self.wear_to is None:
            return worn_loop(loop, cycle)
        share = cycle / (self.cycles - 1) if self.cycles > 1 else 0.0
        friction = worn_friction(loop.material.friction, self.wear_to.friction, share)
        return replace(loop, material=replace(loop.material, friction=friction))

    def generator(self, stream: int, cycle: int) -> np.random.Generator:
        """The random numbers of one stream for one cycle, the same whatever was drawn before."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(stream, cycle)))

    def kick(self, cycle: int, theta: float) -> float:
        """By how much noise turns θ0 (rad) in `cycle`, that began at `theta`: the same whatever was
        drawn before.
        """
        size = self.noise.turn if self.cycle_noise is None else float(self.cycle_noise.sigma(theta))
        return size * self._scatter[cycle]

    @cached_property
    def _scatter(self) -> list[float]:
        """The scatter of each cycle in standard deviations, as alike as successive cycles are."""
        rho = 0.0 if self.cycle_noise is None else self.cycle_noise.correlation
        drawn = [
            float(self.generator(TURN, cycle).standard_normal()) for cycle in range(self.cycles)
        ]
        for cycle in range(1, self.cycles):
            drawn[cycle] = rho * drawn[cycle - 1] + math.sqrt(1.0 - rho**2) * drawn[cycle]
        return drawn

    def recording(self, cycle: int) -> Recording:
        """How the push of `cycle` is recorded."""
        # Whole seconds from one record to the next.
        longest = max(loop.push.distance for loop in self.cycle_loops or (self.loop,))
        seconds = recorded_seconds(APPROACH + longest, self.speed)
        period = math.ceil(2.0 * seconds + _HANDLING_SECONDS)
        return Recording(
            self.speed, FIRST_CLOCK + cycle * period, self.noise, self.loop.pusher.radius
        )

    def arguments(self) -> Arguments:
        """Everything that the files depend on, by name: numbers and texts; long texts are cut to a
        hash.
        """
        loop = self.loop
        noise = self.noise
        wear = loop.material.wear if self.wear_to is None else self.wear_to.friction
        asked: Arguments = {
            "version": version("cyclemap"),
            "cycles": self.cycles,
            "seed": self.seed,
            "start_rad": self.start,
            "material": loop.material.name,
            "friction": repr(loop.material.friction),
            "wear_to": "none" if wear is None else repr(wear),
            "speed_m_s": self.speed,
        }
        for field in fields(loop):
            if field.name != "material":
                asked[field.name] = _short(repr(getattr(loop, field.name)))
        asked |= {
            "noise_turn_rad": noise.turn,
            "noise_position_m": noise.position,
            "noise_angle_rad": noise.angle,
            "noise_force_n": noise.force,
            "scans": self.scans,
            "suffix": self.suffix,
        }
        if self.cycle_noise is not None:
            asked["cycle_noise"] = _short(repr(self.cycle_noise))
        if self.cycle_loops or self.gripper_turns:
            actions = [(loop.push, loop.reset) for loop in self.cycle_loops]
            text = repr((actions, self.gripper_turns))
            asked["cycle_by_cycle"] = hashlib.sha256(text.encode()).hexdigest()
        return asked


def _short(text: str) -> str:
    if len(text) <= _LONGEST_ARGUMENT:
        return text
    return f"{text[:60]}... (sha256 {hashlib.sha256(text.encode()).hexdigest()})"


class CollectionFolder:
    """A folder that holds one collection, begun or complete.

    `SURFACE/SHAPE/normal/` holds the pushes, `SURFACE/SHAPE/friction_scan/` the scans;
    `collection.toml` the collection and what was asked, `true_theta0.txt` the true θ0 (rad, not
    wrapped) of each cycle and of the one that would follow, with a seal behind each.

    Raises InvalidInput where the folder holds something else, or a collection that was asked for
    otherwise.
    """

    def __init__(self, folder: str | Path, plan: CollectionPlan) -> None:
        self.folder = Path(folder)
        self.plan = plan
        self.surface = file_stem(plan.loop.material.name)
        self.shape = file_stem(plan.loop.slider.name)
        self.home = self.folder / self.surface / self.shape
        asked = {SIMULATION: plan.arguments()}
        record = self.folder / FILE_NAME
        unfinished = f".*{UNFINISHED_SUFFIX}"
        begun = record.is_file()
        if begun:
            self._require_same(read_toml(record).get(SIMULATION), asked[SIMULATION])
        elif any(not path.match(unfinished) for path in self.folder.glob("*")):
            raise InvalidInput(
                f"{self.folder} holds other files; give a new or empty folder for the collection"
            )
        for path in self.folder.rglob(unfinished):
            path.unlink(missing_ok=True)
        if not begun:
            try:
                # The loop as every command reads it; without it where no setting can say it.
                text = collection_text(
                    plan.loop, noise=plan.noise.turn or None, more=asked, comments=_COMMENTS
                )
            except InvalidInput as error:
                text = toml_text(
                    asked, (*_COMMENTS, f"Not told here: object, push and reset, for {error}")
                )
            write_whole(record, text.encode())

    def _require_same(self, table: object, asked: Arguments) -> None:
        """Raise InvalidInput where the folder's collection was asked for otherwise."""
        there = table if isinstance(table, dict) else {}
        differences = [
            f"{name} is {there.get(name)} there and {asked.get(name)} here"
            for name in {**asked, **there}
            if asked.get(name) != there.get(name)
        ]
        if differences:
            raise InvalidInput(
                f"{self.folder} holds a collection that was asked for otherwise: "
                f"{'; '.join(differences)}. Choose another folder"
            )

    def push_path(self, cycle: int) -> Path:
        """Where the push of `cycle` is kept."""
        push = self.plan.new_loop_at(cycle).push
        plan = self.plan
        place = (float(push.side), push.fraction, push.angle, float(cycle))
        facts = PushFacts(self.surface, self.shape, 0.0, plan.speed, *place)
        return self.home / PUSH_FOLDER / f"{push_name(facts)}{plan.suffix}"

    def known_theta(self) -> list[float]:
        """The true θ0 of the cycles that are complete, and of the next: where to go on; the start
        if there are none.

        Every line of the truth is sealed with the file of the push that led to its θ0, and with the
        line before; what comes behind a broken seal does not count, and goes.
        """
        truth = self.folder / TRUTH_FILE
        theta = [self.plan.start]
        lines = truth.read_bytes().splitlines(keepends=True) if truth.is_file() else []
        self._lines = [self._truth_line(0, self.plan.start, b"")]
        for cycle, line in enumerate(
            lines[1 : self.plan.cycles + 1] if lines[:1] == self._lines else (), 1
        ):
            try:
                value = plain_number(line.split()[1].decode())
            except (IndexError, ValueError):
                break
            if line != self._truth_line(cycle, value, self._lines[-1]):
                break
            theta.append(value)
            self._lines.append(line)
        write_whole(truth, b"".join(self._lines))
        return theta

    def append_truth(self, cycle: int, theta: float) -> None:
        """Add the θ0 of `cycle`, once the push before is written."""
        self._lines.append(self._truth_line(cycle, theta, self._lines[-1]))
        write_whole(self.folder / TRUTH_FILE, b"".join(self._lines))

    def _truth_line(self, cycle: int, theta: float, before: bytes) -> bytes:
        """The cycle, its θ0, and a digest of these, of the push that led there and of the line
        before.
        """
        push = self.push_path(cycle - 1) if cycle else None
        content = push.read_bytes() if push is not None and push.is_file() else b""
        words = f"{cycle} {theta!r}".encode()
        seal = hashlib.sha256(b"\0".join((before, words, content))).hexdigest()[:16]
        return words + f" # {seal}\n".encode()


@dataclass(frozen=True)
class SimulatedCollection:
    """A complete collection.

    Attributes
    ----------
    folder : Path
        Where its files are.
    cycles : int
        How many pushes it has.
    written : int
        How many of them were made now.
    resumed : int
        How many were found there.
    scans : int
        How many friction scans it has.
    theta_last : float
        The true θ0 of the last push, rad, not wrapped.
    bytes : int
        Size of all files.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, simulate_collection
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     first = simulate_collection(loop, f"{place}/made", 2)
    ...     again = simulate_collection(loop, f"{place}/made", 2)
    >>> first.written, again.written, again.resumed
    (2, 0, 2)
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
    progress: Progress | None = None,
    **asked: Any,
) -> SimulatedCollection:
    """Write a collection of pushes as files of the MIT layout, or go on with one that was begun.

    Parameters
    ----------
    loop : CollectionLoop
        What is run.
    folder : str or Path
        Where the files are written.
    cycles : int
        How many pushes.
    progress : callable or None, optional
        Called with the fraction done.
    **asked : object
        `start` (rad, the first θ0), `noise` (a `RecordingNoise`), `seed`, `speed` (of the rod,
        m/s), `wear_to`, `scans`, `suffix`, `cycle_loops`, `gripper_turns`, `cycle_noise`: the
        other fields of `CollectionPlan`.

    Returns
    -------
    SimulatedCollection
        How many pushes were made, and where they are.

    Raises
    ------
    InvalidInput
        For bad arguments, a folder that holds something else or was begun with others.
    CycleMapError
        Where another process writes to it.
    OSError
        Where it cannot be written.
    ConvergenceError, UnsupportedContact
        Where a push leads out of what the mechanics can do.

    Notes
    -----
    Cycle n starts at θ0 = θ_n, is run with the friction of its day, and θ_{n+1} = F_n(θ_n) + α_n +
    ξ_n with ξ_n ~ N(0, noise.turn²), or as `cycle_noise` says, F_n the cycle map of its loop (to
    `loop.accuracy`) and α_n the turn by a gripper, if any. The drag back is not recorded. See
    `record_push` for the series and their accuracy.

    Every file is there whole or not at all. Random numbers depend on seed and cycle alone: a run
    that was broken off and is called again with the same arguments ends with the files of an
    undisturbed one, bit for bit; what was changed, cut or emptied since it was written is made
    again, and all pushes behind it.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, load_pushes, simulate_collection
    >>> from cyclemap.evidence import RecordingNoise
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
    with only_writer(Path(folder)):
        begun = CollectionFolder(folder, plan)
        # Scans are made anew if they are there: they are quick.
        scans = scan_set(begun.surface, begun.shape, plan.speed) if plan.scans else []
        for index, scan in enumerate(scans, 1):
            friction = loop.material.friction
            draws = plan.generator(SCANS, index)
            made = record_scan(
                friction, loop.model.weight, scan.direction, plan.recording(0), draws
            )
            write_push_file(begun.home / SCAN_FOLDER / f"{scan_name(scan)}{plan.suffix}", made)
        theta = begun.known_theta()
        resumed = len(theta) - 1
        for cycle in range(resumed, plan.cycles):
            now = plan.loop_at(cycle)
            distance = now.push.distance
            try:
                push, back = now.strokes(theta[-1], distance / _RECORDED)
            except CycleMapError as error:
                raise type(error)(
                    f"cycle {cycle}, from θ0 = {math.degrees(theta[-1]):.3f} degrees: {error}"
                ) from error
            record = record_push(
                push, distance, plan.recording(cycle), plan.generator(INSTRUMENTS, cycle)
            )
            write_push_file(begun.push_path(cycle), record)
            gripped = plan.gripper_turns[cycle] if plan.gripper_turns else 0.0
            theta.append(back.end.theta + gripped + plan.kick(cycle, theta[-1]))
            begun.append_truth(cycle + 1, theta[-1])
            part_of(progress, cycle, plan.cycles)(1.0)
    size = sum(path.stat().st_size for path in begun.home.rglob(f"*{plan.suffix}"))
    written = plan.cycles - resumed
    return SimulatedCollection(
        begun.folder, plan.cycles, written, resumed, len(scans), theta[-2], size
    )
