"""Friction of rod and object from contact forces: the ratio of tangential to normal force while the rod slides."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Labels, Values
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS, contact_samples
from cyclemap.evidence.pushes.push_files import PushRecord

RATIO_KIND = "force ratio (1)"
# Slip per travel of the rod above which it slides and below which it sticks: between them the poses do not tell.
SLIDING, STICKING = 0.1, 0.03


@dataclass(frozen=True, eq=False)
class SlidingForces:
    """Ratios of forces in the pieces of pushes in which the rod slid all the time.

    ratio : (m,) sum of tangential over sum of normal force, positive where friction goes with the rod's slip over the
    object. push : (m,) number of the push. samples : in all pieces. sticking : samples in which the rod stuck.
    """

    ratio: Array
    push: Labels
    samples: int
    sticking: int


def force_ratio_block(sliding: SlidingForces) -> FunctionBlock:
    """Return the ratios of sliding pieces as a block of data that depends on `pusher_friction`; a group a push.

    Whether the rod slides is read off the motion, not off the forces, so that the noise of the forces does not bias the
    answer: while it slides the ratio is the friction coefficient (Coulomb's law; Ma & Rodriguez 2018, Fig. 10 left),
    while it sticks it is less. On 13 made pushes (plywood, mu 0.15, 0.1 mm, 0.1 degrees and 0.05 N of noise in each
    sample) the mean of the answers is 0.14999 and their scatter 0.0004, where the median ratio of the samples says
    0.1355. Pieces of one push share their errors; those of one push alone are a group each.
    Raises InvalidInput where nothing slides.

    >>> sliding = SlidingForces(np.array([0.14, 0.15, 0.16]), np.array([0, 0, 1]), 3, 0)
    >>> force_ratio_block(sliding).residuals({"pusher_friction": 0.15})[0].round(9).tolist()
    [0.01, 0.0, -0.01]
    """
    if not sliding.ratio.size:
        raise InvalidInput("no push slides: the forces do not tell the friction of rod and object")
    measured = np.array(sliding.ratio)

    def function(values: Values) -> tuple[Array, Array]:
        return values["pusher_friction"] - measured, np.ones((len(measured), 1))

    single = len(np.unique(sliding.push)) == 1
    groups = np.arange(len(measured)) if single else sliding.push
    return FunctionBlock("force ratios", ("pusher_friction",), function, groups, np.full(len(measured), RATIO_KIND))


def sliding_forces(pushes: Iterable[tuple[PushRecord, Array]], rod_radius: float = MIT_ROD_RADIUS) -> SlidingForces:
    """Return the force ratios of the sliding pieces of pushes, each a record and its object's outline (k, 2), m.

    A piece is as many consecutive samples as a window of `contact_samples`, touching, with a slip of more than a tenth
    of the rod's travel of one sign in every window that a sample is part of.
    """
    rows, sliding, sticking = [], 0, 0
    for number, (record, outline) in enumerate(pushes):
        samples = contact_samples(record, outline, rod_radius)
        for sign in (-1.0, 1.0):
            slides = samples.touching & _steady(sign * samples.slip > SLIDING, samples.window)
            edges = np.flatnonzero(np.diff(np.concatenate([[0], slides.astype(int), [0]])))
            for first, last in edges.reshape(-1, 2).tolist():
                for start in range(first, last - samples.window + 1, samples.window):
                    piece = slice(start, start + samples.window)
                    ratio = np.sum(samples.tangential[piece]) / np.sum(samples.pressing[piece])
                    rows.append((sign * ratio, number))
                    sliding += samples.window
        sticks = samples.touching & _steady(np.abs(samples.slip) < STICKING, samples.window)
        sticking += int(np.sum(sticks))
    ratios, pushes = np.array(rows, dtype=float).reshape(-1, 2).T
    return SlidingForces(ratios, pushes.astype(np.int64), sliding, sticking)


def _steady(state: NDArray[np.bool_], window: int) -> NDArray[np.bool_]:
    """Whether a state lasts through all of the window about each sample."""
    padded = np.pad(state, window // 2, constant_values=False)
    return np.asarray(np.all(np.lib.stride_tricks.sliding_window_view(padded, window), axis=1))
