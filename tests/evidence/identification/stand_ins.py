"""Made data whose law, parameters and noise are known: forces around directions, and a quick
stand-in for pushes.
"""

from typing import Any

import numpy as np

from cyclemap.evidence import DataBlock, friction_scan_block
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.force_blocks import SCAN_FIELDS
from cyclemap.evidence.identification.least_squares import NORMAL, Fit, NoiseLaw, multi_start
from cyclemap.evidence.identification.surface_parameters import SURFACE, Values
from cyclemap.mechanics import EllipseFriction

ELLIPSE = SURFACE.names[:5]
MOTION = (*SURFACE.names[1:5], "pusher_friction", "plate_dome")
TRUTH = {
    "friction_scale": -1.3,
    "ellipticity_x": 0.12,
    "ellipticity_y": -0.07,
    "offset_x": 0.06,
    "offset_y": 0.03,
    "pusher_friction": 0.17,
    "plate_dome": 0.4,
}


def forces(values: Values, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Traction coefficients along, then across directions (n,) of sliding: (2 n,), and derivatives
    by ELLIPSE.
    """
    zero = 0.0 * directions
    still = {"direction": directions, "force_along": zero, "force_across": zero}
    traction, jacobian = friction_scan_block(still, 1.0).residuals(values)
    return traction.reshape(-1, 2).T.ravel(), np.concatenate([jacobian[::2], jacobian[1::2]])


def motions(values: Values, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turns (rad) then shifts (m) of pushes in directions (n,): (2 n,), and derivatives by MOTION
    (2 n, 6).

    To first order what a push answers to ellipticity and offset, bent by a square so that it is not
    linear.
    """
    ex, ey, ox, oy, mu, share = (values[name] for name in MOTION)
    c, k = np.cos(directions), np.sin(directions)
    c2, k2 = np.cos(2 * directions), np.sin(2 * directions)
    zero = np.zeros_like(c)
    turn = 1.2 + 0.9 * (ox * c + oy * k) + 0.6 * (ex * c2 + ey * k2) + 0.8 * mu - 0.5 * mu**2 * c
    by_turn = [0.6 * c2, 0.6 * k2, 0.9 * c, 0.9 * k, 0.8 - mu * c, zero]
    bend = 1.0 + 0.5 * turn
    shift = 0.1 * share * turn * bend + 0.02 * (oy * c - ox * k)
    by_shift = [0.1 * share * (1.0 + turn) * d for d in by_turn]
    by_shift[2], by_shift[3] = by_shift[2] - 0.02 * k, by_shift[3] + 0.02 * c
    by_shift[5] = 0.1 * turn * bend
    jacobian = [np.concatenate(pair) for pair in zip(by_turn, by_shift, strict=True)]
    return np.concatenate([turn, shift]), np.stack(jacobian, -1)


def block(
    name: str, law: Any, parameters: tuple[str, ...], directions: np.ndarray, noise: np.ndarray
) -> DataBlock:
    """A block whose data are the law at TRUTH plus `noise` (2 n,); the two rows of a direction are
    one group.
    """
    data = law(TRUTH, directions)[0] + noise
    kinds = ("force (1)", "force (1)") if law is forces else ("turn (rad)", "shift (m)")

    def function(values: Values) -> tuple[np.ndarray, np.ndarray]:
        predicted, jacobian = law(values, directions)
        return predicted - data, jacobian

    groups = np.tile(np.arange(len(directions)), 2)
    return DataBlock(name, parameters, function, groups, np.repeat(kinds, len(directions)))


def force_block(
    count: int = 12, noise: float = 0.0, seed: int = 0, name: str = "scan"
) -> DataBlock:
    off = noise * np.random.default_rng([seed, 1]).standard_normal(2 * count)
    directions = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return block(name, forces, ELLIPSE, directions, off)


def motion_block(
    count: int = 16,
    turn_noise: float = 0.0,
    shift_noise: float = 0.0,
    seed: int = 0,
    shared: float = 0.0,
) -> DataBlock:
    """`shared`: share of the variance that the turn and the shift of a push have in common."""
    rng = np.random.default_rng([seed, 2])
    directions = rng.uniform(0.0, 2 * np.pi, count)
    common, own = rng.standard_normal(count), rng.standard_normal((2, count))
    both = np.sqrt(shared) * common + np.sqrt(1.0 - shared) * own
    off = np.concatenate([turn_noise * both[0], shift_noise * both[1]])
    return block("pushes", motions, MOTION, directions, off)


NAMES = (*ELLIPSE, "pusher_friction", "plate_dome")
SPACE = SURFACE.select(NAMES)


def blocks(
    noise: float, seed: int = 0, count: int = 16, shared: float = 0.0
) -> tuple[DataBlock, DataBlock]:
    """Forces and motions that together tell all of NAMES."""
    pushes = motion_block(count, 2 * noise, 0.2 * noise, seed, shared)
    return force_block(noise=noise, seed=seed), pushes


def joint(noise: float) -> JointProblem:
    return JointProblem(blocks(noise), SPACE, {})


def fitted(problem: JointProblem, start: Any, law: NoiseLaw = NORMAL, known: Any = None) -> Fit:
    """The fit from one start."""
    return multi_start(problem, np.asarray(start)[None], law, known).best


def made_scans(
    law: EllipseFriction, directions: Any, weight: float, noise: float = 0.0, seed: int = 0
) -> dict[str, Any]:
    """Friction scans of an object in directions (n,) rad, twice each; noise in N."""
    direction = np.repeat(directions, 2)
    c, s = np.cos(direction), np.sin(direction)
    fx, fy = weight * law.traction(np.stack([c, s], axis=-1)).T
    along, across = noise * np.random.default_rng(seed).standard_normal((2, len(direction)))
    columns = (direction, c * fx + s * fy + along, c * fy - s * fx + across)
    return dict(zip(SCAN_FIELDS, columns, strict=True))
