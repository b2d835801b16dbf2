"""From legs in the equations' units to a trajectory and energies in SI units."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.dynamics.dynamic_results import DynamicTrajectory, EnergyBalance
from cyclemap.mechanics.dynamics.stroke_integrator import LegRun

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Units:
    """Units of the equations: length (m), speed (m/s), force (N)."""

    length: float
    speed: float
    force: float

    @property
    def time(self) -> float:
        """Unit of time, s."""
        return self.length / self.speed


def trajectory_of(
    moving: Sequence[LegRun], resting: Sequence[LegRun], units: Units, centre: tuple[float, float]
) -> DynamicTrajectory:
    """Return the course of legs that follow each other; of the coming to rest only its end is kept.

    `centre`: the centre of mass in the slider's frame, m.
    """
    rows: list[Array] = []
    time, path = 0.0, 0.0
    for leg in (*moving, *resting):
        speed = float(np.hypot(*leg.velocity))
        chosen = slice(-1 if leg in resting else 1 if rows else 0, None)
        clock = np.column_stack([time + leg.time, path + speed * leg.time, leg.rod + np.outer(leg.time, leg.velocity)])
        rows.append(np.column_stack([clock, leg.state, leg.observed])[chosen])
        time, path = time + leg.time[-1], path + speed * leg.time[-1]
    return _in_si_units(np.concatenate([*rows[: len(moving)], *rows[len(moving) :][-1:]]), units, centre)


def energy_of(runs: Sequence[LegRun], froude: float, inertia: float, units: Units) -> EnergyBalance:
    """Return where the rod's work went over legs that follow each other; the slider starts at rest."""
    work, floor, contact = units.force * units.length * np.sum([run.works for run in runs], axis=0)
    vx, vy, omega = runs[-1].state[-1, 3:]
    motion = froude * (vx**2 + vy**2 + inertia * omega**2) / 2.0
    stored = units.force * units.length * (motion + runs[-1].observed[-1, 4])
    return EnergyBalance(float(work), float(floor), float(contact), float(stored))


def _in_si_units(table: Array, units: Units, centre: tuple[float, float]) -> DynamicTrajectory:
    """`table`: (n, 15) time, path, rod (2), state (6), observed (5)."""
    theta = table[:, 6]
    c, s = np.cos(theta), np.sin(theta)
    lever = np.column_stack([c * centre[0] - s * centre[1], s * centre[0] + c * centre[1]])
    return DynamicTrajectory(
        time=units.time * table[:, 0],
        path=units.length * table[:, 1],
        pose=np.column_stack([units.length * table[:, 4:6] - lever, theta]),
        velocity=np.column_stack([units.speed * table[:, 7:9], table[:, 9] / units.time]),
        pusher=units.length * table[:, 2:4],
        contact_point=units.length * table[:, 12:14],
        contact_force=units.force * table[:, 10:12],
    )
