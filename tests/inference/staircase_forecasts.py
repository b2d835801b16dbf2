"""Forecasts of the measured staircase from where it stood, by log score: `python -m
tests.inference.staircase_forecasts`.

From pushes 100, 250, 500 and 1000 on, the next 250: which orientations (of 36) they are at, and by
how much the object will have turned. The log joined with what is believed (`watch`) is judged
beside the material alone and beside "as in the last 250". Every forecast gives one chance in a
hundred to anything at all, so that no score is endless.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import pandas as pd

from cyclemap.collection import CollectionLoop
from cyclemap.collection.lock_forecast import sampled_paths, sampled_turns, turns_after_log
from tests.inference.measured_floors import folder

MATERIAL, SIGMA = "plywood-floor", math.radians(1.1)
BEGIN, AHEAD = (100, 250, 500, 1000), 250
ARCS = 36
# What is given to anything at all, and the turns that are all there are: 30 degrees a push.
ANYTHING, WIDEST = 0.01, 2.0 * AHEAD * math.radians(30.0)
# Of the last pushes, how many go together when what they did is drawn again; runs; the least width
# (rad) of a run's share in the density of turns.
BLOCK, RUNS, LEAST = 50, 400, math.radians(5.0)


@dataclass(frozen=True)
class Scores:
    """Logarithms of densities over uniform ones: of an orientation, of the turn in all."""

    orientation: float
    turn: float


def staircase() -> np.ndarray:
    """Measured orientations before each push, unwrapped, rad."""
    table = pd.read_csv(folder() / "plywood_rect1_theta0_2000.csv")
    return np.radians(table["theta0_accum_deg"].to_numpy(dtype=float))


@cache
def believed() -> np.ndarray:
    """Turns of the cycle on samples of the floor, which was fitted to pushes and drags alone."""
    return sampled_turns(CollectionLoop.mit(material=MATERIAL))


def scored(paths: np.ndarray, truth: np.ndarray) -> Scores:
    """Runs (AHEAD + 1, n) beside what was measured."""
    before = np.mod(paths[:-1], 2.0 * np.pi) * ARCS / (2.0 * np.pi)
    share = np.bincount(np.minimum(before.astype(int), ARCS - 1).ravel(), minlength=ARCS)
    density = (1.0 - ANYTHING) * ARCS * share / share.sum() + ANYTHING
    arc = np.mod(truth[:-1], 2.0 * np.pi) * ARCS / (2.0 * np.pi)
    seen = density[np.minimum(arc.astype(int), ARCS - 1)]
    total = paths[-1] - paths[0]
    width = max(float(total.std()) * len(total) ** -0.2, LEAST)
    off = (truth[-1] - truth[0] - total) / width
    likely = float(np.exp(-0.5 * off**2).mean()) / (width * math.sqrt(2.0 * math.pi))
    turn = (1.0 - ANYTHING) * likely * WIDEST + ANYTHING
    return Scores(float(np.log(seen).mean()), math.log(turn))


def as_in_the_last(path: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Runs of what the last pushes did, drawn again in blocks."""
    last = np.diff(path[-AHEAD - 1 :])
    blocks = AHEAD // BLOCK
    runs = np.empty((AHEAD + 1, RUNS))
    for run in range(RUNS):
        begin = rng.integers(0, len(last) - BLOCK + 1, blocks)
        steps = np.concatenate([last[first : first + BLOCK] for first in begin])
        runs[:, run] = np.concatenate([[0.0], np.cumsum(steps)])
    return runs


def forecasts(begin: int, path: np.ndarray) -> dict[str, Scores]:
    """Scores of the three forecasts from a push on."""
    past, truth = path[: begin + 1], path[begin : begin + AHEAD + 1]
    logged = turns_after_log(believed(), past.tolist(), SIGMA, AHEAD)
    start = float(past[-1])
    joined = sampled_paths(logged.turns, logged.sigma, AHEAD, start, change=logged.change)
    alone = sampled_paths(believed(), SIGMA, AHEAD, start)
    again = as_in_the_last(past, np.random.default_rng(begin))
    # Where the last pushes were is told by their own orientations.
    last = np.repeat(past[-AHEAD - 1 :, None], 2, axis=1)
    return {
        "log and floor": scored(joined, truth),
        "floor alone": scored(alone, truth),
        "as in the last": Scores(scored(last, truth).orientation, scored(again, truth).turn),
    }


def main() -> None:
    """Print the scores."""
    path = staircase()
    rows = {begin: forecasts(begin, path) for begin in BEGIN}
    for name in rows[BEGIN[0]]:
        told = [rows[begin][name] for begin in BEGIN]
        for what in ("orientation", "turn"):
            values = [getattr(score, what) for score in told]
            words = " ".join(f"{value:6.2f}" for value in values)
            print(f"{name:16}{what:12} {words}  mean {np.mean(values):6.2f}")


if __name__ == "__main__":
    main()
