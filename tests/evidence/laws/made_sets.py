"""Made collections whose law, noise and path are known, as arrays and as CSV tables of poses."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from cyclemap.evidence.laws.push_sets import PushSet
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs

TURN = 2 * np.pi
HEADER = "surface,shape,v_mm_s,i,s,t,rep,x0,y0,th0,x1,y1,th1"


def true_turn(theta):
    """Δθ (rad): a second harmonic that the fit must find."""
    return 1.2 + 0.08 * np.cos(2 * theta) + 0.03 * np.sin(theta)


def made_set(theta, dtheta, dx=None, dy=None, pairs=None, name="made") -> PushSet:
    theta, dtheta = np.asarray(theta, dtype=float), np.asarray(dtheta, dtype=float)
    dx = 0.04 + 0.003 * np.cos(theta) if dx is None else dx
    dy = -0.08 + 0.01 * np.sin(2 * theta) if dy is None else dy
    return PushSet(name, Path("made.csv"), {"surface": "plywood"}, 1, theta, dtheta, dx, dy, pairs)


def noisy_set(seed: int, count: int = 300, sigma: float = 0.03) -> PushSet:
    rng = np.random.default_rng(seed)
    theta = rng.uniform(0.0, TURN, count)
    return made_set(theta, true_turn(theta) + sigma * rng.standard_normal(count))


def worn_turn(theta, cycle):
    """The turn of a cycle (rad): a bottleneck at 180° that opens with the cycle number, and no
    other slow zone.
    """
    return 0.26 + 0.25 * np.cos(theta) + 1e-4 * cycle


def worn_pairs(
    count: int = 900, sigma: float = 0.02, seed: int = 0, turn: Callable = worn_turn
) -> Theta0Pairs:
    """A path whose every cycle turns by ``turn`` of θ and the cycle number, and its pairs."""
    rng, path = np.random.default_rng(seed), [0.0]
    for n in range(count):
        path.append(path[-1] + float(turn(path[-1], n)) + sigma * rng.standard_normal())
    angles, number = np.array(path), np.arange(count + 1.0)
    return Theta0Pairs(angles[:-1], angles[1:], angles, cycle=number[:-1], path_cycle=number)


def write_collection(file: Path, path, turns) -> Path:
    """Pushes of rect1 in the world: orientation ``path`` (rad, any turn), turn of each push
    ``turns``, small moves.
    """
    rng, rows = np.random.default_rng(0), [HEADER]
    for n, (theta, turn) in enumerate(zip(path, turns, strict=True)):
        dx, dy = np.array([0.04, -0.08]) + 0.001 * rng.standard_normal(2)
        x, y = np.cos(theta) * dx - np.sin(theta) * dy, np.sin(theta) * dx + np.cos(theta) * dy
        start, end = np.mod(theta, TURN), np.mod(theta + turn, TURN)
        rows.append(
            f"plywood,rect1,20,0,0.7,0,{n},0.35,-0.03,{start:.9f},{0.35 + x:.9f},{-0.03 + y:.9f},{end:.9f}"
        )
    file.write_text("\n".join(rows) + "\n")
    return file
