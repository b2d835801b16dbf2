"""What pushes tell of floor, plate and rod, and how what is asked depends on them: first order,
sample by sample.

Each sample s of what is believed is a possible truth. There J_s are the derivatives of what is
measured of a push, and g_s those of what is asked: of a stable direction θ* = f(θ*) it is dθ*/dp =
-f_p / (f' - 1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array, evenly_spread
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.uncertain_directions import sampled_loop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.stroke_block import (
    CYCLE_UNKNOWNS,
    cycles_by_unknowns,
    drag_turn_block,
    interpolation,
    push_end_block,
)
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters, starting_space
from cyclemap.evidence.push_plan.candidates import SetPush
from cyclemap.evidence.pushes.measured_strokes import SET_OFF
from cyclemap.mechanics import Pose
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS

TARGETS = ("direction", "map", "pushes")
# What is unknown of floor, plate, rod and ring.
UNKNOWNS = CYCLE_UNKNOWNS
# Angles at which cycles are run; between them goes a trigonometric polynomial. Angles of the map
# that is asked for.
_NODES, _FINE, _ANGLES = 33, 720, 36
# Nothing is known worse than of a direction that may be any, rad.
ANY_DIRECTION = math.pi / math.sqrt(3.0)
# Pushes of which the prediction of any is asked.
_ASKED = 60


@dataclass(frozen=True, eq=False)
class Beliefs:
    """Samples of what is believed of the unknowns, all alike likely, and their covariance.

    Attributes
    ----------
    loop : CollectionLoop
        About which is asked.
    values : tuple of dict of str to float
        A row of numbers by name for each of the s samples that are looked at.
    covariance : ndarray, shape (k, k)
        Of UNKNOWNS, over all samples.
    """

    loop: CollectionLoop
    values: tuple[dict[str, float], ...]
    covariance: Array


def sampled_beliefs(loop: CollectionLoop, samples: int) -> Beliefs:
    """Return what the posterior of a loop's material tells; `samples` of it, evenly spread, are
    looked at.

    Raises InvalidInput for a material without samples.
    """
    posterior = loop.material.posterior
    if posterior is None:
        lack = "a plan needs samples of what is believed of the floor"
        mend = "give --floor unknown, plywood-floor, abs-floor, or a file that identify wrote"
        raise InvalidInput(f"{loop.material.name}: {lack}: {mend}")
    every = [starting_space(sampled_loop(loop, number)).nominal for number in range(len(posterior))]
    covariance = np.cov([[row[name] for name in UNKNOWNS] for row in every], rowvar=False)
    chosen = evenly_spread(len(every), samples)
    return Beliefs(loop, tuple(every[index] for index in chosen), covariance)


def push_sensitivity(
    known: Beliefs, pushes: Sequence[SetPush], noise: Array
) -> tuple[Array, Array, Array]:
    """Return where pushes end in each sample (s, n, 3), m and rad, and what is measured of them by
    UNKNOWNS, twice.

    Measured are the place and the turn of the push, m and rad, and the turn of the drag back by the
    ring to where the ring was before the push, rad.
    noise (4,) : of these. The derivatives (s, n, 4, k) are over it; then over it and what a rod
        adds that is set a little off its mark: a push that depends on that tells less.
    """
    slider, radius = known.loop.slider, known.loop.pusher.radius
    starts = np.array([(push.start.x, push.start.y, push.start.theta) for push in pushes])
    block = push_end_block([push.measured(slider, radius) for push in pushes], slider)
    ends, plain, derivatives = [], [], []
    for values in known.values:
        residual, jacobian = block.residuals({**values, "tip_offset_x": 0.0, "tip_offset_y": 0.0})
        ends.append(starts + residual.reshape(-1, 3))
        shifted = jacobian.reshape(len(pushes), 3, -1)[..., -2:]
        by = block.columns_by(UNKNOWNS, jacobian).reshape(len(pushes), 3, -1)
        plain.append(by / noise[:3, None])
        derivatives.append(over_noise(by, shifted, noise[:3]))
    poses = [Pose(*pose) for pose in np.mean(ends, axis=0).tolist()]
    drags = [push.dragged(slider, pose) for push, pose in zip(pushes, poses, strict=True)]
    back = drag_turn_block(drags, slider)
    turns = [
        back.columns_by(UNKNOWNS, back.residuals(values)[1])[:, np.newaxis] / noise[3]
        for values in known.values
    ]
    first, second = (np.concatenate([pushed, turns], axis=2) for pushed in (plain, derivatives))
    return np.array(ends), first, second


def over_noise(by: Array, by_rod: Array, noise: Array) -> Array:
    """Return derivatives by (n, 3, k) of pushes over their noise (3,) and that of where the rod is
    set.

    by_rod (n, 3, 2) : derivatives by the place of the rod.
    """
    covariance = np.diag(noise**2) + SET_OFF**2 * by_rod @ by_rod.swapaxes(-1, -2)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(covariance), by))


@dataclass(frozen=True, eq=False)
class Target:
    """What is asked for, in each of s samples.

    Attributes
    ----------
    gradient : ndarray, shape (s, m, k)
        Of the m numbers asked for, by UNKNOWNS.
    loss : callable
        Their variances (..., s, m) -> (...), what is to be made small, averaged over the
        samples.
    words : callable
        Their variances (s, m) -> numbers by name, of what will be known, as people ask for it
        (rad, m).
    chance : float or None
        Share of the samples that lock in; None where that is not asked.
    """

    gradient: Array
    loss: Callable[[Array], Array]
    words: Callable[[Array], dict[str, float]]
    chance: float | None = None


def target_of(known: Beliefs, name: str, by: Array, noise: Array) -> Target:
    """Return what is asked for: the stable directions and whether there are any, the whole map, or
    single pushes.

    by (s, n, 4, k) : derivatives of pushes and drags over their noise (4,), m and rad.
    """
    if name == "direction":
        return _direction(known)
    if name == "map":
        theta = 2.0 * math.pi * np.arange(_ANGLES) / _ANGLES
        gradient = np.array(
            [cycle_map_by_unknowns(known.loop, values, theta)[2] for values in known.values]
        )
        return Target(
            gradient, _mean_loss, lambda variance: {"map": math.sqrt(float(variance.mean()))}
        )
    samples, count, _, unknowns = by.shape
    chosen = evenly_spread(count, _ASKED)
    gradient = by[:, chosen, :3].reshape(samples, -1, unknowns)

    def words(variance: Array) -> dict[str, float]:
        along, across, turn = (
            np.sqrt(variance.reshape(samples, -1, 3).mean(axis=(0, 1))) * noise[:3]
        )
        return {"place": math.hypot(along, across), "turn": float(turn)}

    return Target(gradient, _mean_loss, words)


def _mean_loss(variance: Array) -> Array:
    return np.asarray(variance.mean(axis=(-2, -1)))


def cycle_map_by_unknowns(
    loop: CollectionLoop, values: dict[str, float], theta: Array
) -> tuple[Array, Array, Array]:
    """Return turn (n,), its slope (n,) and derivatives (n, k) by UNKNOWNS of a loop's map at theta
    (n,), rad.
    """
    nodes = 2.0 * math.pi * np.arange(_NODES) / _NODES
    runs, by = cycles_by_unknowns(SurfaceParameters.from_values(values), loop, nodes)
    between = interpolation(theta, _NODES)
    slope = runs.jacobian[0, :, CYCLE_OUTPUTS.index("theta_next"), 0] - 1.0
    turn = runs.theta_next[0] - nodes
    return between @ turn, between @ slope, between @ by[:, CYCLE_OUTPUTS.index("theta_next")]


def _direction(known: Beliefs) -> Target:
    """The stable directions, and by how much the map locks or fails to."""
    theta = 2.0 * math.pi * np.arange(_FINE) / _FINE
    rows, margins = [], []
    for values in known.values:
        turn, slope, by = cycle_map_by_unknowns(known.loop, values, theta)
        following = np.roll(turn, -1)
        stable = np.flatnonzero((turn > 0.0) & (following <= 0.0) & (slope > -2.0) & (slope < 0.0))
        rows.append([-by[index] / slope[index] for index in stable.tolist()])
        # The turn that decides: the extreme that is nearest to nought, whose sign would end or
        # begin the lock.
        extremes = [int(np.argmin(turn)), int(np.argmax(turn))]
        nearest = min(extremes, key=lambda index: abs(float(turn[index])))
        rows[-1].insert(0, by[nearest])
        margins.append(abs(float(turn[nearest])))
    most = max(map(len, rows))
    gradient = np.array([row + [np.zeros(len(UNKNOWNS))] * (most - len(row)) for row in rows])
    margin = np.array(margins)
    has = np.array([[place < len(row) for place in range(1, most)] for row in rows]).reshape(
        len(rows), most - 1
    )
    locks = has.any(axis=1)

    def errors(variance: Array) -> tuple[Array, Array]:
        """Chance (..., s) of a wrong answer to whether it locks, and mean square error of
        directions (..., s).
        """
        from scipy.special import ndtr

        wrong = ndtr(-margin / np.sqrt(np.maximum(variance[..., 0], 1e-12)))
        capped = variance[..., 1:] / (1.0 + variance[..., 1:] / ANY_DIRECTION**2)
        return wrong, (capped * has).sum(axis=-1) / np.maximum(has.sum(axis=-1), 1)

    def loss(variance: Array) -> Array:
        wrong, square = errors(variance)
        return np.asarray((wrong * ANY_DIRECTION**2 + (1.0 - wrong) * square).mean(axis=-1))

    def words(variance: Array) -> dict[str, float]:
        wrong, square = errors(variance)
        chances = {"wrong": float(wrong.mean())}
        return chances | (
            {"direction": math.sqrt(float(square[locks].mean()))} if locks.any() else {}
        )

    return Target(gradient, loss, words, float(locks.mean()))
