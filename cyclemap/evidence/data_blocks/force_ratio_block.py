"""Friction of rod and object from contact forces: the ratio of tangential to normal force while the rod slides."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Values
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS, ContactSamples, contact_samples
from cyclemap.evidence.pushes.push_files import PushRecord

Labels = NDArray[np.int64]

RATIO_KIND = "force ratio (1)"
# Slip per travel of the rod above which it slides and below which it sticks: between them the poses do not tell.
SLIDING, STICKING = 0.1, 0.03


@dataclass(frozen=True, eq=False)
class SlidingForces:
    """Ratios of forces in the pieces of pushes in which the rod slid all the time.

    ratio : (m,) sum of tangential over sum of normal force, positive where friction goes with the rod's slip over the
    object. sign : (m,) of the slip along the tangent. push : (m,) number of the push. samples : (m,) in each piece.
    pushes : looked at. touching : samples of contact with a normal force. sticking : samples in which the rod stuck.
    sticking_ratio : the largest |ratio| of a piece of sticking, nan if there is none: the friction is no less.
    """

    ratio: Array
    sign: Array
    push: Labels
    samples: Labels
    pushes: int
    touching: int
    sticking: int
    sticking_ratio: float


@dataclass(frozen=True)
class PusherFriction:
    """Friction coefficient of rod and object.

    value, lower, upper : estimate and interval of probability `level`; nan, 0 and inf where no push slides.
    sliding_pushes, sliding_samples : that tell it; sticking_samples : that only bound it; pushes : all.
    notes : what qualifies it, in words.
    """

    value: float
    lower: float
    upper: float
    level: float
    pushes: int
    sliding_pushes: int
    sliding_samples: int
    sticking_samples: int
    notes: tuple[str, ...]

    @property
    def identifiable(self) -> bool:
        """Whether any push slides."""
        return math.isfinite(self.value)

    def __str__(self) -> str:
        if not self.identifiable:
            return self.notes[0]
        return f"pusher_friction {self.value:.4g} ({self.lower:.4g} to {self.upper:.4g})"


def pusher_friction_from_forces(
    source: str | Path | Sequence[PushRecord],
    outline: ArrayLike | None = None,
    *,
    rod_radius: float = MIT_ROD_RADIUS,
    level: float = 0.95,
    student: float | None = None,
) -> PusherFriction:
    """Return the friction of rod and object by the forces of recorded pushes.

    source : a file, folder or tree of the MIT layout (see `load_pushes`), or records. outline : (k, 2) m, of the object
    as a closed polyline, needed for records; files of MIT shapes bring it by their names, others are passed over.
    rod_radius : m. level : of the interval. student : degrees of freedom of Student noise, for pushes that disagree.

    Whether the rod slides is read off the motion, not off the forces, so that the noise of the forces does not bias the
    answer: while it slides the ratio is the friction coefficient (Coulomb's law; Ma & Rodriguez 2018, Fig. 10 left),
    while it sticks it is less. Pieces of one push share their errors, so that the interval tells the scatter from push
    to push; of a single push it tells the scatter within, and a note says so.

    On 13 made pushes (plywood, mu 0.15, 0.1 mm, 0.1 degrees and 0.05 N of noise in each sample) the mean of the answers
    is 0.14999 and their scatter 0.0004, where the median ratio of the samples says 0.1355.

    Raises InvalidInput for records without an outline, and where there is no push at all.
    """
    radius = positive_number("rod radius", rod_radius)
    found = sliding_forces(_records(source, outline), radius)
    if not found.pushes:
        raise InvalidInput(f"{source}: no push of an object of known outline; give records and their outline")
    if not found.ratio.size:
        return _unidentified(found, level)
    sliding_pushes = len(np.unique(found.push))
    counts = found.pushes, sliding_pushes, int(np.sum(found.samples)), found.sticking
    if len(found.ratio) < 2:
        note = "not identifiable: only one piece of a push slides, so that nothing tells its error"
        return PusherFriction(math.nan, 0.0, math.inf, level, *counts, (note,))
    result = identify([force_ratio_block(found)], ["pusher_friction"], starts=1, level=level, student=student)
    one, notes = result["pusher_friction"], []
    if sliding_pushes == 1:
        notes.append("one push alone slides: the interval tells the scatter within it, not from push to push")
    if np.median(found.ratio) <= 0.0:
        notes.append("friction goes against the slip in most pieces: the forces or their signs cannot be right")
    return PusherFriction(one.value, one.lower, one.upper, level, *counts, (*notes, *result.notes))


def force_ratio_block(sliding: SlidingForces, name: str = "force ratios") -> FunctionBlock:
    """Return the ratios of sliding pieces as a block of data that depends on `pusher_friction`; a group a push.

    Pieces of one push alone are a group each. Raises InvalidInput where nothing slides.

    >>> one, two = np.ones(3), np.ones(3, dtype=int)
    >>> sliding = SlidingForces(np.array([0.14, 0.15, 0.16]), one, np.array([0, 0, 1]), two, 2, 9, 0, math.nan)
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
    return FunctionBlock(name, ("pusher_friction",), function, groups, np.full(len(measured), RATIO_KIND))


def sliding_forces(
    pushes: Sequence[tuple[PushRecord, Array]] | Iterator[tuple[PushRecord, Array]], rod_radius: float = MIT_ROD_RADIUS
) -> SlidingForces:
    """Return the force ratios of the sliding pieces of pushes, each a record and its object's outline (k, 2), m.

    A piece is as many consecutive samples as a window of `contact_samples`, touching, with a slip of more than a tenth
    of the rod's travel of one sign in every window that a sample is part of.
    """
    rows, count, touching, sticking, largest = [], 0, 0, 0, math.nan
    for count, (record, outline) in enumerate(pushes, 1):
        samples = contact_samples(record, outline, rod_radius)
        for sign in (-1.0, 1.0):
            slides = samples.touching & _steady(sign * samples.slip > SLIDING, samples.window)
            rows += [(sign * ratio, sign, count - 1, size) for ratio, size in _pieces(samples, slides)]
        sticks = samples.touching & _steady(np.abs(samples.slip) < STICKING, samples.window)
        touching, sticking = touching + int(np.sum(samples.touching)), sticking + int(np.sum(sticks))
        largest = float(np.fmax.reduce([largest, *(abs(ratio) for ratio, _ in _pieces(samples, sticks))]))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    push, size = table[:, 2:].astype(np.int64).T
    return SlidingForces(table[:, 0], table[:, 1], push, size, count, touching, sticking, largest)


def _steady(state: NDArray[np.bool_], window: int) -> NDArray[np.bool_]:
    """Whether a state lasts through all of the window about each sample."""
    padded = np.pad(state, window // 2, constant_values=False)
    return np.asarray(np.all(np.lib.stride_tricks.sliding_window_view(padded, window), axis=1))


def _pieces(samples: ContactSamples, chosen: NDArray[np.bool_]) -> list[tuple[float, int]]:
    """Ratio of summed forces and number of samples of each piece of consecutive chosen samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    found = []
    for first, last in edges.reshape(-1, 2).tolist():
        for start in range(first, last - samples.window + 1, samples.window):
            part = slice(start, start + samples.window)
            found.append((float(np.sum(samples.tangential[part]) / np.sum(samples.pressing[part])), samples.window))
    return found


def _records(
    source: str | Path | Sequence[PushRecord], outline: ArrayLike | None
) -> Iterator[tuple[PushRecord, Array]]:
    if not isinstance(source, (str, Path)):
        if outline is None:
            raise InvalidInput("records of pushes need the outline of their object: a closed polyline (k, 2), m")
        rim = finite_array("outline", outline, last=2, ndim=2)
        yield from ((record, rim) for record in source)
        return
    from cyclemap.evidence.pushes.push_files import read_push_file
    from cyclemap.evidence.pushes.push_table import load_pushes
    from cyclemap.mechanics import MIT_SHAPE_NAMES, Slider

    table = load_pushes(source).table
    for name, file, size in zip(table["object"], table["path"], table["samples"], strict=True):
        if size == 0 or (outline is None and name not in MIT_SHAPE_NAMES):
            continue
        record = read_push_file(file)
        assert isinstance(record, PushRecord)
        given = Slider.mit(name).outline_points(360) if outline is None else outline
        yield record, finite_array("outline", given, last=2, ndim=2)


def _unidentified(found: SlidingForces, level: float) -> PusherFriction:
    note = "not identifiable: no push slides"
    if not found.touching:
        note = "not identifiable: no push has a normal force while rod and object touch"
    if math.isfinite(found.sticking_ratio):
        note += f"; while sticking the ratio reached {found.sticking_ratio:.3g}, and the friction is no less"
    return PusherFriction(math.nan, 0.0, math.inf, level, found.pushes, 0, 0, found.sticking, (note,))
