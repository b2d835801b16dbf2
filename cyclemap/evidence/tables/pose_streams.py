"""A stream of one object's poses cut into pushes and drags back: by what noise lets one see, and by
what motions are.

A drag ends with the ring at the target, wherever the object's centre comes to lie: of all rests
those are before a push from which one place of the object is always at one place of the world. A
rest between two of them is a push's end, and so the pause of a robot in the middle of a stroke is
none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_propagation, uniform_filter1d

from cyclemap.arrays import Array, Mask, Whole, stretches
from cyclemap.errors import DataFileError
from cyclemap.evidence.tables.columns import ENDS

if TYPE_CHECKING:
    import pandas

# Half windows, s, in which poses are averaged before and after a moment: the shortest that noise
# allows is taken.
_WINDOWS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
# How far means before and after a moment lie apart where a motion is seen, and where it ends: in
# standard deviations of noise, and as shares of what the faster motions show.
_SEEN = 4.0
_ENDED = 2.4
_SEEN_SHARE = 0.3
_ENDED_SHARE = 0.1
# Noise that nobody has (m), turns as lengths (m per rad), and how much faster than noise motions
# have to be.
_LEAST_NOISE = 2e-5
_LEVER = 0.03
_CLEAR = 2.0
# What moves less (m, with turns by the lever) between two rests has not moved.
_LEAST_MOTION = 6e-3
# Rests are averaged over so many seconds, and that share of their length, before and after their
# middle.
_AVERAGED = 1.0
_MIDDLE = 0.3
# The ring's places agree within so many standard deviations of a rest, or that far (m).
_AGREE = 5.0
_AGREE_LEAST = 2e-3
# Pairs of rests of which a ring is tried, and how many rests it takes.
_TRIES = 400
_FEWEST_RESTS = 5
# Shares: of rests that the ring's place explains, and of cycles that may be unclear and are left
# out.
_FEWEST_HOME = 0.3
_MOST_UNCLEAR = 0.2
# Of rings those explain nearly as many rests as the best that explain this share of them.
_NEARLY = 0.85
# Where more rests than this share have the ring at one place, none tells it; then those are home
# that lie near the first, as a share of how far the others are.
_ALL_HOME = 0.8
_NEAR_THE_FIRST = 0.3
# Pushes, or drags, whose motion is further from the median of its kind than this share of it are of
# neither kind.
_ALIKE = 0.35


Rests = int | NDArray[np.intp]


class UnclearStream(DataFileError):
    """A stream of poses that does not come apart into pushes and drags: with what was seen, for a
    picture.
    """

    def __init__(self, message: str, seen: Segments) -> None:
        super().__init__(message)
        self.seen = seen


@dataclass(frozen=True, eq=False)
class Segments:
    """A stream, and how it was cut.

    Attributes
    ----------
    t, x, y, theta : ndarray, shape (n,)
        s, m, rad (unwrapped).
    rests : ndarray, shape (r, 2)
        First and last sample of each rest.
    pushes : ndarray, shape (k, 2)
        The rests between which each push lies, whole pauses within it.
    numbers : ndarray, shape (k,)
        Of their cycles, gaps where something between is unclear.
    unclear : ndarray, shape (u, 2)
        The rests between which motions make no push and drag.
    words : str
        How it was cut, for people.
    """

    t: Array
    x: Array
    y: Array
    theta: Array
    rests: Whole
    pushes: Whole
    numbers: Array
    unclear: Whole
    words: str


def cut_stream(path: Path, stream: pandas.DataFrame) -> tuple[pandas.DataFrame, Segments]:
    """Return the poses before and after each push, by our names, and how the stream was cut.

    stream : t, theta, x, y. Poses are means over the rests beside the motions.

    Raises DataFileError for orientations alone; UnclearStream where too many motions are neither a
    push nor a drag, or where there is no telling one from the other.
    """
    import pandas

    if not {"x", "y"} <= {*stream}:
        raise DataFileError(
            f"{path}: which motions push cannot be told of an angle alone: give its places, "
            "or a column episode (1, 2, ... during each push, empty else)"
        )
    t, x, y, theta = stream[["t", "x", "y", "theta"]].to_numpy().T
    theta = np.unwrap(theta)
    course = np.array([x, y, theta])
    rests, noise = _rests(path, t, course)
    if len(rests) < 2:
        raise DataFileError(f"{path}: no push in it: its object never moves, or never rests")
    poses = np.array([_mean_pose(t, course, *rest) for rest in rests.tolist()])
    counts = np.maximum(1.0, 2.0 * _MIDDLE * (np.diff(rests, axis=1)[:, 0] + 1))
    cycles = _cycles(poses, noise / np.sqrt(counts))
    seen = Segments(t, x, y, theta, rests, *cycles)
    pushes = len(seen.pushes)
    unclear = len(seen.unclear)
    if pushes < 2 or unclear > _MOST_UNCLEAR * (pushes + unclear):
        raise UnclearStream(f"{path}: {_unclear_words(seen)}", seen)
    ends = np.hstack([poses[seen.pushes[:, 0]], poses[seen.pushes[:, 1]]])
    rows = pandas.DataFrame(ends, columns=[*ENDS])
    return rows.assign(repetition=seen.numbers.astype(float)), seen


def _unclear_words(seen: Segments) -> str:
    """What was seen of a stream that does not come apart, and what mends it."""
    begins = seen.t[seen.rests[:, 0]]
    ends = seen.t[seen.rests[:, 1]]
    listed = ", ".join(f"{ends[a]:.4g} to {begins[b]:.4g} s" for a, b in seen.unclear[:3])
    return (
        f"{len(seen.rests) - 1} motions between rests, {len(seen.pushes)} of them pushes and "
        f"{len(seen.unclear)} stretches unclear{f' ({listed})' if listed else ''}: give a "
        "column episode (1, 2, ... during each push, empty else), --columns episode=NAME"
    )


def _mean_pose(t: Array, course: Array, first: int, last: int) -> Array:
    """The mean pose of a rest in its middle: at its ends motion may hide in the noise."""
    own = t[first : last + 1]
    reach = min(_AVERAGED, _MIDDLE * (own[-1] - own[0]))
    near = np.abs(own - 0.5 * (own[0] + own[-1])) <= reach
    near = near if near.any() else np.ones(near.size, dtype=bool)
    return np.asarray(course[:, first : last + 1][:, near].mean(axis=1))


# -- rests


def _rests(path: Path, t: Array, course: Array) -> tuple[Whole, float]:
    """First and last sample of each rest, and the noise of a pose (m, turns by the lever)."""
    lengths = course * [[1.0], [1.0], [_LEVER]]
    # Second differences see no steady motion; their median absolute deviation sees no jump.
    noise = max(_LEAST_NOISE, _noise(lengths))
    rate = 1.0 / max(float(np.median(np.diff(t))), 1e-6)
    for window in _WINDOWS:
        half = max(1, round(window * rate))
        change = _change(lengths, half)
        moves = float(np.quantile(change, 0.8))
        seen = _SEEN * noise * math.sqrt(2.0 / half)
        if moves > _CLEAR * seen:
            break
    else:
        raise DataFileError(
            f"{path}: its noise of {1e3 * noise:.2g} mm hides its motions: give poses "
            "before and after each push, or smoother ones"
        )
    low = max(_ENDED * seen / _SEEN, _ENDED_SHARE * moves)
    high = max(seen, low, _SEEN_SHARE * moves)
    moving = binary_propagation(change > high, mask=change > low)
    return _joined(stretches(~moving), t, course), noise


def _noise(courses: Array) -> float:
    """The standard deviation of one sample's errors, from second differences."""
    usual = [0.0]
    for second in np.abs(np.diff(courses, n=2, axis=1)):
        changed = second[second > 0.0]
        if 2 * changed.size > second.size:
            usual.append(float(np.median(changed)))
    return max(usual) / 0.6745 / 6**0.5


def _change(courses: Array, half: int) -> Array:
    """How far the mean after each sample lies from the mean before it, (n,), m."""
    means = uniform_filter1d(courses, half, axis=1, mode="nearest")
    # A filter of this length is centred: these means begin behind the sample, and end before it.
    ahead = np.roll(means, -(half - half // 2), axis=1)
    ahead[:, -half:] = means[:, -1:]
    behind = np.roll(means, half // 2 + 1, axis=1)
    behind[:, : half + 1] = means[:, :1]
    return np.asarray(np.linalg.norm(ahead - behind, axis=0))


def _joined(rests: Sequence[tuple[int, int]], t: Array, course: Array) -> Whole:
    """First and last sample of the rests, those between which nothing moved made one."""
    kept: list[tuple[int, int]] = []
    for first, end in rests:
        begin = first
        if kept:
            moved = _mean_pose(t, course, first, end - 1) - _mean_pose(t, course, *kept[-1])
            if math.hypot(moved[0], moved[1], _LEVER * moved[2]) < _LEAST_MOTION:
                begin, _ = kept.pop()
        kept.append((begin, end - 1))
    return _pairs(kept)


def _pairs(rows: Sequence[Sequence[int]]) -> Whole:
    """Pairs (n, 2) of whole numbers, n may be 0."""
    return np.array(rows, dtype=np.int64).reshape(-1, 2)


# -- cycles


def _cycles(poses: Array, errors: Array) -> tuple[Whole, Array, Whole, str]:
    """Pushes as pairs of rests, their numbers, unclear stretches likewise, and what was seen, in
    words.
    """
    home, sense, how = _home(poses, errors)
    where = np.union1d(np.flatnonzero(home), len(poses) - 1).tolist()
    spans = list(pairwise(where))
    closed = [first for first, last in spans if last == first + 2 and home[last]]
    if not closed:
        return _pairs([]), np.zeros(0), _pairs([(0, len(poses) - 1)]), "no push is clear"
    begins = np.array(closed)
    clean = _motion(poses, begins, begins + 1, sense)
    backs = _motion(poses, begins + 1, begins + 2, sense)
    usual = np.median(clean, axis=0)
    back = np.median(backs, axis=0)
    limit = _spread(clean)
    limit_back = _spread(backs)
    pushes = []
    cycles = []
    paused = 0
    # What comes before the first push is a push's end at most.
    unclear = [(0, where[0])] if where[0] > 1 else []
    # What is unclear is a number left out, so that nothing is taken to follow across it.
    for cycle, (first, last) in enumerate(spans):
        is_open = not home[last]
        ends = np.arange(first + 1, last + is_open)
        away = np.linalg.norm(_motion(poses, first, ends, sense) - usual, axis=-1)
        end = int(ends[np.argmin(away)]) if ends.size else first
        # Two cycles with an unseen rest between them begin with a push, too.
        off_back = np.linalg.norm(_motion(poses, end, last, sense) - back)
        if away.min(initial=math.inf) <= limit and (is_open or off_back <= limit_back):
            pushes.append((first, end))
            cycles.append(cycle)
            paused += last - first > 2
        elif not is_open:
            unclear.append((first, last))
    words = f"{len(poses) - 1} motions between rests: {len(pushes)} pushes, {how}"
    words += f", {paused} of them or of their drags with a pause" if paused else ""
    words += f"; left out, as neither push nor drag: {len(unclear)} stretches" if unclear else ""
    return _pairs(pushes), np.array(cycles), _pairs(unclear), words


def _spread(motions: Array) -> float:
    """How far from their median motions of one kind may lie: a share of its size, or where most of
    them do.
    """
    middle = np.median(motions, axis=0)
    off = np.linalg.norm(motions - middle, axis=1)
    return max(_ALIKE * float(np.linalg.norm(middle)), 2.0 * float(np.quantile(off, 0.8)))


def _motion(poses: Array, first: Rests, last: Rests, sense: float = 1.0) -> Array:
    """Motions (..., 3) from one rest to another in the object's frame at their begin: dx, dy (m),
    turn by the lever (m).

    sense : -1 where angles grow from y to x of the places.
    """
    dx, dy, turn = (poses[last] - poses[first]).T
    c = np.cos(poses[first, 2])
    s = sense * np.sin(poses[first, 2])
    return np.stack([c * dx + s * dy, c * dy - s * dx, _LEVER * turn], axis=-1)


def _home(poses: Array, errors: Array) -> tuple[Mask, float, str]:
    """Which rests are before a push, the sense of angles in which that is so, and how it is known:
    they have the ring at the target.

    Where no place of the object is again and again at one place of the world, motions may come in
    two kinds in turn.

    The ring h and the target c solve p + R(theta) h = c; two rests tell them, and those that most
    agree with are taken. Ends of pushes that are all alike agree with a ring of their own, but one
    farther from the object's centre.
    """
    generator = np.random.default_rng(0)
    limit = np.maximum(_AGREE * errors, _AGREE_LEAST)
    rings = []
    for sense in (1.0, -1.0):
        for agree, radius in _rings(poses, limit, sense, generator):
            rings.append((int(agree.sum()), round(radius, 3), agree, sense))
    if not rings:
        how = "of two kinds in turn: the first motion and every other one"
        return _in_turn(poses), 1.0, how
    most = max(count for count, *_ in rings)
    # Of those that explain nearly as many the ring nearest to the centre.
    near = [entry for entry in rings if entry[0] >= _NEARLY * most]
    home, sense = min(near, key=lambda entry: (entry[1], -entry[0]))[2:]
    if home.mean() > _ALL_HOME:
        # Locked in: from two poses again and again no ring can be told, and the first one is taken
        # as a push's begin.
        home = _like_the_first(poses)
    return home, sense, "each from where the ring is at the target"


def _rings(
    poses: Array, limit: Array, sense: float, generator: np.random.Generator
) -> Iterator[tuple[Mask, float]]:
    """Which rests agree with a ring that two of them tell, and how far it is from the centre, m."""
    place = poses[:, 0] + 1j * poses[:, 1]
    way = np.exp(1j * sense * poses[:, 2])
    rows = np.stack([way, np.full(len(poses), -1.0)], axis=-1)
    for _ in range(_TRIES if len(poses) >= _FEWEST_RESTS else 0):
        chosen = generator.choice(len(poses), 2, replace=False)
        solved, *_ = np.linalg.lstsq(rows[chosen], -place[chosen], rcond=None)
        agree = np.abs(rows @ solved + place) < limit
        if agree.sum() >= max(3, _FEWEST_HOME * len(poses)):
            solved, *_ = np.linalg.lstsq(rows[agree], -place[agree], rcond=None)
            yield np.abs(rows @ solved + place) < limit, float(abs(solved[0]))


def _like_the_first(poses: Array) -> Mask:
    """Which poses lie near to the first, beside how far the others are."""
    places = np.column_stack(
        [poses[:, :2], _LEVER * np.cos(poses[:, 2]), _LEVER * np.sin(poses[:, 2])]
    )
    away = np.linalg.norm(places - places[0], axis=1)
    centre = np.median(places[away < 0.5 * np.median(away[away > 0.5 * away.max()])], axis=0)
    off = np.linalg.norm(places - centre, axis=1)
    return np.asarray(off < _NEAR_THE_FIRST * np.median(off[off > 0.5 * off.max()]))


def _in_turn(poses: Array) -> Mask:
    """Every other rest, where motions from these and to these separate; else none."""
    rests = np.arange(len(poses))
    motions = _motion(poses, rests[:-1], rests[1:])
    kinds = [kind for kind in (motions[::2], motions[1::2]) if len(kind)]
    medians = [np.median(kind, axis=0) for kind in kinds]
    pairs = zip(kinds, medians, strict=True)
    off = [np.linalg.norm(kind - middle, axis=1).max() for kind, middle in pairs]
    apart = np.linalg.norm(medians[0] - medians[-1])
    are_apart = len(kinds) == 2 and max(off) <= 0.5 * apart
    return np.asarray((rests % 2 == 0) & are_apart)
