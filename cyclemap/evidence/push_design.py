"""What pushes tell of floor, plate and rod, how what is asked depends on them, and sets of pushes
that tell most: to first order, sample by sample.

Each sample s of what is believed is a possible truth. There J_s are the derivatives of what is
measured of a push, and g_s those of what is asked: of a stable direction θ* = f(θ*) it is dθ*/dp =
-f_p / (f' - 1). After pushes the covariance of the unknowns is C = (C0^-1 + Σ J^T R^-1 J)^-1, and
what is asked has the variance g C g^T (Bayesian design for linear functionals, Chaloner &
Verdinelli 1995). Pushes are chosen one by one, then each is exchanged for a better one as long as
there is any.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array, even_angles, evenly_spread
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.stroke_block import (
    CYCLE_UNKNOWNS,
    cycles_by_unknowns,
    drag_turn_block,
    interpolation,
    surface_model,
)
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters, starting_space
from cyclemap.evidence.predicted_strokes import PUSH_NAMES, predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import (
    MeasuredDrag,
    MeasuredPush,
    ReadErrors,
    push_noise,
    set_up_errors,
)
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
# How often every push of a set may be exchanged; what gains less than this share is left.
_ROUNDS = 2
_GAIN = 1e-3


@dataclass(frozen=True, eq=False)
class SampledBeliefs:
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


def sampled_beliefs(loop: CollectionLoop, samples: int) -> SampledBeliefs:
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
        starting_space(on_material(loop, loop.material.sample(index))).nominal
        for index in range(len(posterior))
    ]
    covariance = np.cov([[row[name] for name in UNKNOWNS] for row in every], rowvar=False)
    chosen = evenly_spread(len(every), samples)
    return SampledBeliefs(loop, tuple(every[index] for index in chosen), covariance)


def push_sensitivity(
    known: SampledBeliefs, pushes: Sequence[MeasuredPush], read: ReadErrors
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
    ends = []
    plain = []
    derivatives = []
    for values in known.values:
        surface = SurfaceParameters.from_values(values)
        model = surface_model(surface, slider, rod_radius=radius)
        moved, by_all, _ = predicted_push_ends(model, pushes, names=PUSH_NAMES)
        by = surface.chain(by_all[..., :-3], PUSH_NAMES, UNKNOWNS)
        ends.append(moved)
        plain.append(by / noise[:3, None])
        derivatives.append(over_noise(by, by_all[..., -3:] * set_up, noise[:3]))
    drags = []
    for push, pose in zip(pushes, np.mean(ends, axis=0).tolist(), strict=True):
        end = Pose(*pose)
        ring = push.start.to_world(*slider.hitch)
        lever = Pose(theta=end.theta).to_world(*slider.hitch)
        back = Pose(ring[0] - lever[0], ring[1] - lever[1], end.theta)
        drags.append(MeasuredDrag(end, back))
    block = drag_turn_block(drags, slider)
    turns = []
    for values in known.values:
        by_drag = block.columns_by(UNKNOWNS, block.residuals(values)[1])
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


def target_of(known: SampledBeliefs, name: str, by: Array, noise: Array) -> Target:
    """Return what is asked for: the stable directions and whether there are any, the whole map, or
    single pushes.

    by (s, n, 3, k) : derivatives of where pushes end over their noise (3,), m and rad.
    """
    if name == "direction":
        return _direction(known)
    if name == "map":
        theta = even_angles(_ANGLES)
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
    nodes = even_angles(_NODES)
    runs, by = cycles_by_unknowns(SurfaceParameters.from_values(values), loop, nodes)
    between = interpolation(theta, _NODES)
    slope = runs.jacobian[0, :, CYCLE_OUTPUTS.index("theta_next"), 0] - 1.0
    turn = runs.theta_next[0] - nodes
    return between @ turn, between @ slope, between @ by[:, CYCLE_OUTPUTS.index("theta_next")]


def _direction(known: SampledBeliefs) -> Target:
    """The stable directions, and by how much the map locks or fails to."""
    theta = even_angles(_FINE)
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


class Design:
    """Sets of candidates, by number, and what is known after them.

    Attributes
    ----------
    believed : ndarray, shape (k, k)
        Covariance of the unknowns beforehand.
    derivatives : ndarray, shape (s, n, m, k)
        Of the m numbers measured of each of the n candidates, over their noise, in each sample.
    target : Target
        What is asked for.
    """

    def __init__(self, believed: Array, derivatives: Array, target: Target) -> None:
        # In units of what is believed, so that what is known beforehand costs no digits.
        values, vectors = np.linalg.eigh(believed)
        seen = values > 1e-12 * values.max()
        root = vectors[:, seen] * np.sqrt(values[seen])
        self.rows = derivatives @ root
        self.gradient = target.gradient @ root
        self.target = target
        self.information = np.einsum("snik,snil->snkl", self.rows, self.rows)

    def covariance(self, chosen: list[int]) -> Array:
        """Of the unknowns after these pushes, (s, k, k)."""
        size = self.rows.shape[-1]
        return np.asarray(np.linalg.inv(np.eye(size) + self.information[:, chosen].sum(axis=1)))

    def variance(self, chosen: list[int]) -> Array:
        """Of what is asked, (s, m)."""
        return np.asarray(
            np.einsum("smk,skl,sml->sm", self.gradient, self.covariance(chosen), self.gradient)
        )

    def loss(self, chosen: list[int]) -> float:
        """What is to be small, after these pushes."""
        return float(self.target.loss(self.variance(chosen)))

    def knowledge(self, chosen: list[int]) -> dict[str, float]:
        """What is known after these pushes, by name."""
        return self.target.words(self.variance(chosen))

    def with_one_more(self, chosen: list[int]) -> Array:
        """The loss (n,) after these pushes and each of the candidates."""
        before = self.covariance(chosen)[:, None]
        spread = self.rows @ before
        measured = spread @ self.rows.swapaxes(-1, -2) + np.eye(self.rows.shape[2])
        asked = self.gradient[:, None].swapaxes(-1, -2)
        seen = spread @ asked
        gained = (seen * np.linalg.solve(measured, seen)).sum(axis=2)
        variance = (asked * (before @ asked)).sum(axis=2)
        losses = self.target.loss(np.maximum(variance - gained, 0.0).swapaxes(0, 1))
        losses[chosen] = math.inf
        return losses

    def greedy(self, count: int, among: Sequence[int]) -> list[int]:
        """So many of some pushes, each the one that tells most after those before it."""
        chosen = list[int]()
        while len(chosen) < count:
            losses = self.with_one_more(chosen)
            chosen.append(min(among, key=losses.__getitem__))
        return chosen

    def exchanged(self, chosen: list[int]) -> list[int]:
        """The set with pushes exchanged for better ones: in all, and on average over the loss of
        any of them.
        """
        kept = list(chosen)
        for _ in range(_ROUNDS):
            before = [*kept]
            for place in range(len(kept)):
                rest = kept[:place] + kept[place + 1 :]
                losses = self.with_one_more(rest)
                for lost in range(len(rest)):
                    fewer = self.with_one_more(rest[:lost] + rest[lost + 1 :])
                    losses = losses + np.where(np.isinf(losses), 0.0, fewer) / len(rest)
                best = int(np.argmin(losses))
                if losses[best] < (1.0 - _GAIN) * losses[kept[place]]:
                    kept[place] = best
            if kept == before:
                break
        return kept
