"""Thirty tables as robots write them: one true collection each, in other units, columns, axes and
senses of angles.

The object has no mirror image of its own and is pushed off its middle, so that whoever reads a
table in a mirror sees another motion. Every table knows its truth and the reading that it wants.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import cyclemap as cm
from cyclemap.protocol.collection_file import collection_text

# An L: no axis of symmetry.
VERTICES = (
    (0.050, -0.035),
    (0.050, 0.005),
    (0.010, 0.010),
    (-0.005, 0.045),
    (-0.045, 0.045),
    (-0.045, -0.035),
)
TARGET = (0.35, -0.03)
PUSHES = 72


@cache
def loop() -> cm.CollectionLoop:
    """The L on plywood, pushed on its longest side."""
    slider = cm.mechanics.Slider(
        cm.mechanics.Polygon(VERTICES), 0.8, hitch=(-0.012, 0.010), name="ell"
    )
    push = cm.mechanics.SidePush(side=5, fraction=0.72, angle=0.0, distance=0.11)
    return cm.CollectionLoop.mit("plywood", slider=slider, push=push, footprint=None, accuracy=1e-6)


@dataclass(frozen=True, eq=False)
class Truth:
    """Poses (n, 3) before and after each push, m and rad, counter-clockwise in a right-handed
    frame, unwrapped.
    """

    start: np.ndarray
    end: np.ndarray
    start_next: np.ndarray


@cache
def truth(seed: int) -> Truth:
    """A collection of the loop, whose cycles turn the object by 97 to 107 degrees: it covers all of
    the circle.
    """
    generator, theta = np.random.default_rng(seed), 0.4
    rows = []
    for _ in range(PUSHES):
        cycle = loop().cycle(theta)
        later = cycle.theta_next + math.radians(1.1) * generator.standard_normal()
        start = loop().start_pose(theta)
        x, y = start.to_world(*cycle.push_displacement)
        after = loop().start_pose(later)
        poses = (
            (start.x, start.y, theta),
            (x, y, theta + cycle.push_turn),
            (after.x, after.y, later),
        )
        rows.append([(a + TARGET[0], b + TARGET[1], c) for a, b, c in poses])
        theta = later
    table = np.array(rows)
    return Truth(table[:, 0], table[:, 1], table[:, 2])


# From true poses (n, 3) to what a robot writes.
CONVENTIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "ours": lambda p: p,
    "clockwise": lambda p: p * (1, 1, -1),
    "compass": lambda p: p * (1, 1, -1) + (0, 0, math.pi / 2),
    "picture": lambda p: p * (1, -1, -1),
    "picture counter-clockwise": lambda p: p * (1, -1, 1),
    "swapped": lambda p: p[:, [1, 0, 2]],
    "north east down": lambda p: p[:, [1, 0, 2]] * (1, 1, -1) + (0, 0, math.pi / 2),
}


@dataclass(frozen=True)
class Foreign:
    """One table: its name, the writer, the convention, the noise (mm, and as many degrees), what it
    has.
    """

    name: str
    write: Callable[..., str]
    suffix: str
    convention: str
    noise_mm: float
    posed: bool
    seed: int

    def truth(self) -> Truth:
        """What really happened."""
        return truth(self.seed)

    def made(self, folder: Path, with_collection: bool = True) -> Path:
        """Write the table, and what is known of object and push beside it."""
        folder.mkdir(parents=True, exist_ok=True)
        if with_collection:
            (folder / "collection.toml").write_text(collection_text(loop()))
        generator = np.random.default_rng(1000 + self.seed)
        noise = self.noise_mm * np.array([1e-3, 1e-3, math.radians(1.0)])
        seen = {}
        for name in ("start", "end"):
            poses = getattr(self.truth(), name)
            # A camera errs in every frame, and not in what it looks at.
            error = 0.0 if self.write is stream else noise * generator.standard_normal(poses.shape)
            seen[name] = CONVENTIONS[self.convention](poses + error)
        path = folder / f"{self.name}{self.suffix}"
        path.write_text(self.write(seen["start"], seen["end"], noise, generator, self))
        return path


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return (np.asarray(angle) + math.pi) % (2.0 * math.pi) - math.pi


def _rows(header: str, columns: list[np.ndarray], sign: str = ",", decimal: str = ".") -> str:
    lines = [header]
    for row in zip(*columns, strict=True):
        lines.append(sign.join(f"{value:.9g}" for value in row).replace(".", decimal))
    return "\n".join(lines) + "\n"


def _columns(start, end, length: float, metre: float = 1.0, radian: float = 1.0) -> list:
    """Poses before and after, and the length of the push, in units of a house."""
    unit = np.array([metre, metre, radian])
    return [*(start * unit).T, *(end * unit).T, np.full(len(start), length)]


def canonical(start, end, *_) -> str:
    """Metres and radians under our own names."""
    return _rows("x0,y0,th0,x1,y1,th1,push_mm", _columns(start, end, 110.0))


def wrapped_canonical(start, end, *_) -> str:
    """The same, angles wrapped."""
    columns = _columns(start, end, 110.0)
    columns[2], columns[5] = _wrapped(columns[2]), _wrapped(columns[5])
    return _rows("x0,y0,theta0,x1,y1,theta1,push_mm", columns)


def millimetres(start, end, *_) -> str:
    """Millimetres and degrees under a house's names."""
    before, after = "x_before_mm,y_before_mm,yaw_before_deg", "x_after_mm,y_after_mm,yaw_after_deg"
    columns = _columns(start, end, 110.0, 1e3, math.degrees(1.0))
    return _rows(f"{before},{after},push_length_mm", columns)


def continental(start, end, *_) -> str:
    """Semicolons and decimal commas, centimetres."""
    before, after = "x_start_cm;y_start_cm;Winkel_start_deg", "x_end_cm;y_end_cm;Winkel_end_deg"
    columns = [np.arange(len(start)), *_columns(start, end, 11.0, 1e2, math.degrees(1.0))]
    return _rows(f"Nr;{before};{after};push_length_cm", columns, ";", ",")


def inches(start, end, *_) -> str:
    """Inches and turns, and columns that say nothing here."""
    header = "px,py,id,x0_in,y0_in,theta0_turns,x1_in,y1_in,theta1_turns,push_length_in"
    number = np.arange(len(start))
    columns = _columns(start, end, 11.0 / 2.54, 1.0 / 0.0254, 0.5 / math.pi)
    return _rows(header, [0 * number, 0 * number, number, *columns])


def shuffled(start, end, noise, generator, _) -> str:
    """Rows in any order, with the number of each push."""
    order = generator.permutation(len(start))
    columns = [np.arange(len(start)), *_columns(start, end, 0.11)]
    header = "push,x_before,y_before,theta_before,x_after,y_after,theta_after,push_length_m"
    return _rows(header, [column[order] for column in columns])


def json_lines(start, end, *_) -> str:
    """A JSON object a line, poses nested."""
    lines = []
    for number, poses in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        before, after = (dict(zip(("x", "y", "yaw"), pose, strict=True)) for pose in poses)
        row = {"rep": number, "before": before, "after": after, "push_length": 0.11}
        lines.append(json.dumps(row))
    return "\n".join(lines) + "\n"


def dirty(start, end, *_) -> str:
    """Our own names, three rows without a pose, and an empty field in a column that nobody
    needs.
    """
    header, *rows = canonical(start, end).splitlines()
    lines = [f"{header},remark"]
    for number, row in enumerate(rows):
        fields = row.split(",")
        if number in (6, 29, 30):
            fields[3:6] = ["nan"] * 3
        lines.append(",".join([*fields, "" if number == 4 else "ok"]))
    return "\n".join(lines) + "\n"


def orientations(start, *_) -> str:
    """Orientations alone, degrees."""
    return _rows("theta0_deg", [np.degrees(start[:, 2]) % 360.0])


def stream(start, end, noise, generator, table) -> str:
    """A camera at 30 Hz: rests, pushes, rests, drags; a pause in some strokes, rows lost."""
    frames, rate = [], 30.0
    for number in range(len(start)):
        later = CONVENTIONS[table.convention](table.truth().start_next)[number]
        still = np.repeat(start[number][None], int(rate * generator.uniform(0.8, 1.6)), axis=0)
        rest = np.repeat(end[number][None], int(rate * generator.uniform(0.8, 1.6)), axis=0)
        share = np.linspace(0.0, 1.0, int(5.5 * rate))[:, None]
        if number in (9, 40):
            share = np.concatenate(
                [share[share < 0.5], np.full(int(2.5 * rate), 0.5), share[share >= 0.5]]
            )[:, None]
        push = start[number] + share * (end[number] - start[number])
        drag = end[number] + np.linspace(0.0, 1.0, int(4.0 * rate))[:, None] * (later - end[number])
        frames += [still, push, rest, drag]
    poses = np.concatenate(frames)
    seen = poses + noise * generator.standard_normal(poses.shape)
    t, kept = np.arange(len(seen)) / rate, generator.uniform(size=len(seen)) > 0.03
    half = 0.5 * seen[:, 2]
    columns = [t, seen[:, 0], seen[:, 1], 0.0 * t, 0.0 * t, np.sin(half), np.cos(half)]
    return _rows("timestamp,x,y,qx,qy,qz,qw", [column[kept] for column in columns])


_WRITERS = (
    *(canonical, wrapped_canonical, millimetres, continental, inches),
    *(shuffled, json_lines, dirty, stream, orientations),
)
_OTHERS = [name for name in CONVENTIONS if name != "ours"]


@cache
def thirty() -> tuple[Foreign, ...]:
    """Each writer three times: in our convention and in others, fifteen of thirty, at noises of 0,
    0.3 and 1 mm.
    """
    made = []
    for number in range(30):
        write = _WRITERS[number % 10]
        suffix = ".jsonl" if write is json_lines else ".csv"
        # Fifteen in our convention, fifteen in others, each writer in both.
        ours = (number // 10 + number) % 2 == 0
        convention = "ours" if ours else _OTHERS[(number // 2) % len(_OTHERS)]
        name = f"{write.__name__}_{number}"
        noise = (0.0, 0.3, 1.0)[(number // 10 + number % 3) % 3]
        posed = write is not orientations
        made.append(Foreign(name, write, suffix, convention, noise, posed, number))
    return tuple(made)


def agrees(columns: dict[str, np.ndarray], table: Foreign) -> bool:
    """Whether what was read is what happened: each push's motion in the object's own frame, for
    some and nearly all.

    The world may be turned against the truth's, which nobody can see.
    """
    start, end = table.truth().start, table.truth().end
    true = _motion(start, end)
    read = _motion(
        np.stack([columns["x0"], columns["y0"], columns["theta0"]], axis=-1),
        np.stack([columns["x1"], columns["y1"], columns["theta1"]], axis=-1),
    )
    if len(read) < 0.8 * len(true):
        return False
    limit = 1e-4 + 4.5e-3 * table.noise_mm
    gaps = [np.min(np.abs(true - one[None]).max(axis=1)) for one in read]
    return bool(np.mean(np.array(gaps) < limit) > 0.97)


def _motion(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Displacement in the frame before (m), and turn by a lever of 50 mm (m)."""
    dx, dy = (end - start)[:, :2].T
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    turn = _wrapped(end[:, 2] - start[:, 2])
    return np.stack([c * dx + s * dy, c * dy - s * dx, 0.05 * turn], axis=-1)
