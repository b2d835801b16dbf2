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
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.stroke_block import (
    CYCLE_UNKNOWNS,
    cycles_by_unknowns,
    drag_turn_block,
    interpolation,
    surface_model,
)
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters, starting_space
from cyclemap.evidence.predicted_strokes import PUSH_NAMES, predicted_push_ends
from cyclemap.evidence.push_plan.candidates import SetPush
from cyclemap.evidence.pushes.measured_strokes import push_noise, set_up_errors
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
    every = [
        starting_space(on_material(loop, loop.material.sample(number))).nominal
        for number in range(len(posterior))
    ]
    covariance = np.cov([[row[name] for name in UNKNOWNS] for row in every], rowvar=False)
    chosen = evenly_spread(len(every), samples)
    return Beliefs(loop, tuple(every[index] for index in chosen), covariance)


def push_sensitivity(
    known: Beliefs, pushes: Sequence[SetPush], read: tuple[float, float]
) -> tuple[Array, Array, Array]:
    """Return where pushes end in each sample (s, n, 3), m and rad, and derivatives by UNKNOWNS, all
    over the noise: of these ends (s, n, 3, k), and of what is measured (s, n, 4, k).

    Measured are the place and the turn of the push, m and rad, and the turn of the drag back by the
    ring to where the ring was before the push, rad. read : how far readings are off, m and rad.
    Noise of what is measured is also what a hand adds that sets a rod a little off its mark, and an
    object a little turned: a push that depends on that tells less.
    """
    slider = known.loop.slider
    radius = known.loop.pusher.radius
    noise = push_noise(read)
    set_up = set_up_errors(read)
    made = [push.measured(slider, radius) for push in pushes]
    ends = []
    plain = []
    derivatives = []
    for values in known.values:
        surface = SurfaceParameters.from_values(values)
        model = surface_model(surface, slider, rod_radius=radius)
        moved, by_all, _ = predicted_push_ends(model, made, names=PUSH_NAMES)
        by = surface.chain(by_all[..., :-3], PUSH_NAMES, UNKNOWNS)
        ends.append(moved)
        plain.append(by / noise[:3, None])
        derivatives.append(over_noise(by, by_all[..., -3:] * set_up, noise[:3]))
    poses = [Pose(*pose) for pose in np.mean(ends, axis=0).tolist()]
    drags = [push.dragged(slider, pose) for push, pose in zip(pushes, poses, strict=True)]
    back = drag_turn_block(drags, slider)
    turns = []
    for values in known.values:
        by_drag = back.columns_by(UNKNOWNS, back.residuals(values)[1])
        turns.append(by_drag[:, np.newaxis] / noise[3])
    return np.array(ends), np.array(plain), np.concatenate([derivatives, turns], axis=2)


def over_noise(by: Array, by_set_up: Array, noise: Array) -> Array:
    """Return derivatives by (n, 3, k) of pushes over their noise (3,) and that of how they are set
    up.

    by_set_up (n, 3, m) : what each way in which a push is set up wrongly adds, a deviation of it.
    """
    covariance = np.diag(noise**2) + by_set_up @ by_set_up.swapaxes(-1, -2)
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

    by (s, n, 3, k) : derivatives of where pushes end over their noise (3,), m and rad.
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
    gradient = by[:, evenly_spread(count, _ASKED)].reshape(samples, -1, unknowns)

    def words(variance: Array) -> dict[str, float]:
        square = variance.reshape(samples, -1, 3).mean(axis=(0, 1))
        along, across, turn = (np.sqrt(square) * noise).tolist()
        return {"place": math.hypot(along, across), "turn": turn}

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
    rows = list[Array]()
    margins = list[float]()
    for values in known.values:
        turn, slope, by = cycle_map_by_unknowns(known.loop, values, theta)
        falls = (turn > 0.0) & (np.roll(turn, -1) <= 0.0)
        stable = falls & (slope > -2.0) & (slope < 0.0)
        # The turn that decides: the extreme that is nearest to nought, whose sign would end or
        # begin the lock.
        nearest = min(np.argmin(turn), np.argmax(turn), key=lambda index: abs(float(turn[index])))
        rows.append(np.vstack([by[nearest], -by[stable] / slope[stable, None]]))
        margins.append(abs(float(turn[nearest])))
    lengths = np.array([len(row) for row in rows])
    padded = [np.pad(row, ((0, lengths.max() - len(row)), (0, 0))) for row in rows]
    margin = np.array(margins)
    has = np.arange(1, lengths.max()) < lengths[:, np.newaxis]
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

    return Target(np.array(padded), loss, words, float(locks.mean()))
