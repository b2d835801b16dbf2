"""Made pushes whose poses are known, and streams of them, as tables under names of one's own."""

import math
from pathlib import Path

import numpy as np
import pandas

# Poses before and after pushes, m and rad.
PUSHES = 24
NUMBERS = np.arange(PUSHES)
THETA = 0.2 + 0.21 * NUMBERS + 0.02 * (-1.0) ** NUMBERS
BEFORE = np.column_stack([0.3 + 0.01 * np.cos(NUMBERS), 0.1 + 0.01 * np.sin(NUMBERS), THETA])
AFTER = BEFORE + np.column_stack(
    [0.04 + 0.002 * np.cos(THETA), 0.05 + 0.0 * THETA, 1.0 + 0 * THETA]
)
SCALED = (1e3, 1e3, math.degrees(1.0))
PLAIN = "x_before_mm,y_before_mm,yaw_before_deg,x_after_mm,y_after_mm,yaw_after_deg"


def saved(folder: Path, content: str | bytes | pandas.DataFrame, name: str = "log.csv") -> Path:
    """A file of this content."""
    path = folder / name
    if isinstance(content, pandas.DataFrame):
        content = content.to_csv(index=False)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def frame(names, scale=(1.0, 1.0, 1.0)):
    """A row a push below six names of one's own."""
    return pandas.DataFrame(np.hstack([BEFORE * scale, AFTER * scale]), columns=names.split(","))


def plain():
    """Under plain names, in millimetres and degrees."""
    return frame(PLAIN, SCALED)


def quaternions(poses, name, parts="xyzw", upright="z"):
    """Quaternions about an upright axis, every third of the other sign."""
    sign = np.where(np.arange(len(poses)) % 3 == 0, -1.0, 1.0)
    half = 0.5 * poses[:, 2]
    values = {"x": 0.0 * half, "y": 0.0 * half, "z": 0.0 * half, "w": sign * np.cos(half)}
    values[upright] = sign * np.sin(half)
    return {name.format(part): values[part] for part in parts}


def stream():
    """Poses of an object that is pushed and dragged back by a ring at its centre, ten times a
    second.
    """
    poses, ring = [], np.array([0.015, 0.0])
    for theta, turn in zip(THETA[:12], np.diff(THETA[:13]), strict=True):
        home = np.array([0.4, 0.1, theta])
        pushed = home + np.array([0.06, 0.05, 1.0])
        later = home + np.array([0.0, 0.0, turn])
        for first, last in ((home, home), (home, pushed), (pushed, pushed), (pushed, later)):
            poses.append(first + np.linspace(0.0, 1.0, 20)[:, None] * (last - first))
    poses = np.concatenate([*poses, np.repeat(later[None], 20, axis=0)])
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    poses[:, 0] -= c * ring[0]
    poses[:, 1] -= s * ring[0]
    return 0.1 * np.arange(len(poses)), poses
