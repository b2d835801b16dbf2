"""The whole course of a push or a drag, in the world frame, SI units."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.motion import Motion
from cyclemap.mechanics.push_run import RunPhase
from cyclemap.mechanics.runge_kutta import STATE, UNKNOWN


@dataclass(frozen=True)
class Trajectory:
    """A motion sampled at the ends of its steps.

    path : (n,) rod travel, m
    pose : (n, 3) object's x, y (m) and theta (rad)
    pusher : (n, 2) rod's centre, m
    contact_point : (n, 2) m
    contact_force : (n, 2) force of the rod on the object, N
    mode : (n,) str: stick, slide_left, slide_right, slide_free; in the ring: ring, with friction ring_left, ring_right,
        ring_stuck
    residual : largest residual of the force balance over the samples, relative to the friction coefficients
    """

    path: NDArray[np.float64]
    pose: NDArray[np.float64]
    pusher: NDArray[np.float64]
    contact_point: NDArray[np.float64]
    contact_force: NDArray[np.float64]
    mode: NDArray[np.str_]
    residual: float


@dataclass(frozen=True)
class Frame:
    """How normalised runs lie in the world: unit of length (m), rod's start (m), weight (N)."""

    unit: float
    rod_start: tuple[float, float]
    weight: float


def trajectory_of(phases: tuple[RunPhase, ...], frame: Frame) -> Trajectory:
    """Return the trajectory of phases that follow each other."""
    rows, modes, residuals, travel = [], [], [], 0.0
    for phase in phases:
        for at, state, unknowns in _nodes(phase):
            row, residual = _row(phase.motion, travel + at, state, unknowns, frame)
            rows.append(row)
            residuals.append(residual)
            modes.append(phase.motion.mode)
        travel += phase.phase.length
    table = np.array(rows)
    return Trajectory(
        table[:, 0], table[:, 1:4], table[:, 4:6], table[:, 6:8], table[:, 8:10], np.array(modes), max(residuals)
    )


def _nodes(phase: RunPhase) -> list[tuple[float, NDArray[np.float64], list[float]]]:
    """Start of the phase and ends of its steps: travel since its start, state, contact's unknowns."""
    steps = phase.phase.steps
    nodes = [(0.0, phase.start, steps[0].stages[0, UNKNOWN].tolist())]
    for taken, at in zip(steps, np.cumsum([taken.h for taken in steps]).tolist(), strict=True):
        nodes.append((at, taken.stages[-1, STATE], taken.stages[-1, UNKNOWN].tolist()))
    return nodes


def _row(
    motion: Motion, travel: float, state: NDArray[np.float64], unknowns: list[float], frame: Frame
) -> tuple[list[float], float]:
    theta, direction = float(state[0]), motion.rod.direction
    contact, _ = motion.piece.contact(float(state[1]), motion.rod.radius)
    motion.unknowns = unknowns
    compression, tangential, residual = motion.forces(state)
    outward = np.array((math.cos(contact.normal + theta), math.sin(contact.normal + theta)))
    along = np.array((-outward[1], outward[0]))
    rod = np.array(frame.rod_start) + frame.unit * travel * np.array((math.cos(direction), math.sin(direction)))
    touch = rod if motion.in_ring else rod - frame.unit * motion.rod.radius * outward
    c, s = math.cos(theta), math.sin(theta)
    place = touch - frame.unit * np.array((c * contact.x - s * contact.y, s * contact.x + c * contact.y))
    force = frame.weight * (-compression * outward + tangential * along)
    return [frame.unit * travel, *place.tolist(), theta, *rod.tolist(), *touch.tolist(), *force.tolist()], residual
