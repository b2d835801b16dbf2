"""Points that cost nothing, or as much as a test asks for: numbers by formulas of the settings."""

import os
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.errors import UnsupportedContact
from cyclemap.sweeps import PointOutcome, SweepPlan, SweepStore, load_sweep, run_sweep
from cyclemap.sweeps.portrait_numbers import GROUPS


@dataclass(frozen=True)
class FakeNumbers:
    """Rotation and fixed points by formulas of mu_a (default 0.25) and hitch_x_mm (default 0).

    log : a file that gets a line for each point begun.
    seconds : how long a point takes.
    refused_above : mu_a from which on points are refused.
    fails_at, dies_at : numbers of points at which there is a bug, or a process ends.
    """

    log: str = ""
    seconds: float = 0.0
    refused_above: float = np.inf
    fails_at: int = -1
    dies_at: int = -1
    version: str = "fake 1"
    told: str = "fake"

    @property
    def quantities(self):
        return (*GROUPS["rotation"], *GROUPS["fixed_points"])

    def described(self):
        return {"told": self.told}

    def __call__(self, point):
        if self.log:
            with Path(self.log).open("a") as file:
                file.write(f"{point.number}\n")
        time.sleep(self.seconds)
        if point.number == self.dies_at:
            os._exit(3)
        if point.number == self.fails_at:
            raise ZeroDivisionError("a bug")
        mu, x = (
            float(point.settings.get("mu_a", 0.25)),
            float(point.settings.get("hitch_x_mm", 0.0)),
        )
        if mu > self.refused_above:
            return PointOutcome({}, str(UnsupportedContact(f"mu_a is {mu:g}")))
        return PointOutcome(fake_values(mu, x))


def fake_values(mu, x):
    """Two fixed points where x is below -5, else none and a rotation number that is not a
    fraction."""
    locked = x < -5.0
    rotation = 0.0 if locked else np.sqrt(2.0) * 0.01 * (1.0 + x + mu)
    theta = (0.1 - x / 7.0, 3.0 + mu / 3.0) if locked else ()
    return {
        "rotation": rotation,
        "rotation_lower": rotation - (0.0 if locked else 1e-6),
        "rotation_upper": rotation + (0.0 if locked else 1e-6),
        "locked_winding": 0.0,
        "locked_period": float(locked),
        "fixed_points": float(len(theta)),
        "stable_points": 1.0 if locked else 0.0,
        "fixed_point_theta": theta,
        "fixed_point_multiplier": (0.5 + mu / 3.0, 1.5) if locked else (),
        "fixed_point_stable": (1.0, 0.0) if locked else (),
        "gathering_jump_theta": (),
    }


def fake_plan(rows=5, columns=4, **options):
    """A grid of fake points: mu_a from 0.2 to 0.3 by hitch_x_mm from -20 to 0."""
    over = {
        "mu_a": np.linspace(0.2, 0.3, rows).tolist(),
        "hitch_x_mm": np.linspace(-20.0, 0.0, columns).tolist(),
    }
    return SweepPlan.grid("plywood", over, numbers=FakeNumbers(**options))


def fake_sample(count, sequence="sobol", **options):
    """A sample of fake points in the box of the grid."""
    ranges = {"mu_a": (0.2, 0.3), "hitch_x_mm": (-20.0, 0.0)}
    return SweepPlan.sample(
        "plywood", ranges, count, sequence=sequence, numbers=FakeNumbers(**options)
    )


def swept(path, plan):
    """What a sweep of the plan in this process found, stored at `path`."""
    run_sweep(plan, path, workers=1)
    return load_sweep(path)


def opened(path):
    """How many points the plan of a store has, as told by the store, which is made where there is
    none.
    """
    with SweepStore(path, fake_plan()) as store:
        return store.status().points


def logged(path):
    """The numbers of the points that were begun, in the order in which they were."""
    return [int(line) for line in Path(path).read_text().split()] if Path(path).exists() else []
