"""Made pushes and friction scans whose facts, motion and forces are known, written as files of the
MIT layout.
"""

import json
from pathlib import Path

import h5py
import numpy as np

PUSH_NAME = "motion_surface=plywood_shape=rect1_a=0_v=20_i=0.000_s=0.700_t=0.000"
SCAN_NAME = "record_surface=plywood_shape=rect1_a=0_v=20_deg=30_rep=000"
ROD = np.array([-0.018, 0.045 + 0.00475])


def turned(angle, vector):
    c, s = np.cos(angle), np.sin(angle)
    x, y = np.moveaxis(np.asarray(vector, dtype=float), -1, 0)
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def made_push(start=(0.35, -0.03, 0.4), moved=(0.03, -0.09), turn=1.2, ratio=0.12, samples=60):
    """Tables of a push of rect1 at a fixed point of side 0: `moved` in its initial frame (m),
    `turn` (rad).
    """
    clock = np.linspace(0.0, 0.004 * (samples - 1), samples)
    share = clock / clock[-1]
    angle = start[2] + turn * share
    place = np.array(start[:2]) + turned(start[2], np.outer(share, moved))
    force = turned(angle, np.tile([ratio * 4.0, -4.0], (samples, 1)))
    wrapped = np.angle(np.exp(1j * angle))
    return {
        "object_pose": np.column_stack([1e9 + clock, place, wrapped]),
        "tip_pose": np.column_stack([1e9 + clock, place + turned(angle, ROD), 0 * clock]),
        # The sensor feels the object's push back on the rod.
        "ft_wrench": np.column_stack([1e9 + clock, -force, 0 * clock]),
    }


def made_scan(direction=3.665, along=2.0, across=0.3, samples=60):
    """Tables of a stroke of 120 mm in `direction` (rad); the rod presses with these forces (N) on
    the object.
    """
    clock = np.linspace(0.0, 6.0, samples)
    place = np.array([0.35, -0.018]) + turned(
        direction, np.column_stack([0.02 * clock - 0.06, 0 * clock])
    )
    force = turned(direction, np.tile([along, across], (samples, 1)))
    # The robot starts and stops: the ends say nothing about sliding friction.
    force[:10] *= 5.0
    force[-10:] *= 0.0
    return {
        "tip_array": np.column_stack([clock, place, 0 * clock]),
        "ft_wrench": np.column_stack([clock, -force, 0 * clock]),
    }


def write(path: Path, tables, **options) -> Path:
    """Write tables to a .h5 or .json file, making its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".json":
        path.write_text(
            json.dumps({name: np.asarray(rows).tolist() for name, rows in tables.items()})
        )
        return path
    with h5py.File(path, "w") as file:
        for name, rows in tables.items():
            file.create_dataset(name, data=rows, **options)
    return path
