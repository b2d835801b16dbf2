"""Is what data call orientation and place what we call so? Measured motions tell: a mirror image
moves otherwise.

Of all ways to count angles and to lay axes the one is looked for in which pushes move the object
most nearly as isotropic friction would have it; a few millimetres and degrees are the surface's
own, a wrong reading misses by as much as the object moves.
"""

from __future__ import annotations

import cmath
import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, evenly_spread, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.evidence.predicted_strokes import predicted_push_ends
from cyclemap.evidence.pushes.columns import DEGREE, LENGTH_UNITS, RODS
from cyclemap.evidence.pushes.conventions import ANGLES, FRAMES, OURS, RIGHT_HANDED, Convention
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush, told_push
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.mechanics import MIT_SHAPE_NAMES, Pose, Slider, load_material
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# Another reading beats the one taken where its median distance is this share of it or less, another
# unit where it is that share: measured, a right reading lies 2 to 15 mm off on floors, a wrong one
# 60 to 200 mm.
_BEATEN, _BEATEN_UNIT = 0.5, 0.3
# Of readings within this factor and distance (m) of the best the simplest is named.
_HARDLY, _NOTHING = 1.4, 5e-4
_SAME_ANGLE = math.radians(2.0)
# Fewer pushes tell a reading from chance no more; more than so many tell nothing new.
FEWEST, _MOST = 6, 400
# Objects that are told of one by one.
_MOST_TOLD = 2
# Shares of how far pushes move the object, turns by its lever: a reading nearer than the first
# explains enough for any friction; one beyond the second, or with another zero of angles beyond the
# third, explains nothing, be it the best; and of one beyond the last it is told.
_WELL, _EXPLAINS, _EXPLAINS_TURNED, _FAR = 0.04, 0.4, 0.25, 0.6
# Angles whose zero is off by less (rad) may be the surface's doing; it is asked for where
# directions are spread.
_LEAST_OFFSET, _SPREAD = math.radians(20.0), 0.8
# So many of the pushes have to be nearer in the other reading.
_MOST_AGREE = 0.7
_PREDICTED = "pushes end, beside isotropic friction's,"
_TURNED = {"deg": DEGREE, "rad": 1.0 / DEGREE}
_BY_ROD = (
    "; sides, fractions and angles that are told are passed over: the rod's places are elsewhere"
)
_POSES = ["x0", "y0", "theta0", "x1", "y1", "dtheta"]
_CONTACT = ["side", "fraction", "angle"]


class OtherConvention(InvalidInput):
    """Data whose motions another reading explains far better: the message has the words that mend
    it.
    """


@dataclass(frozen=True)
class MotionCheck:
    """How far motions lie from isotropic friction's as they were read.

    Attributes
    ----------
    distance : float
        m, in the median.
    by_rod : bool
        Whether the rod's places tell the contacts, against the sides and fractions that are
        told.
    words : str
        For people.
    """

    distance: float
    by_rod: bool
    words: str


def check_pushes(pushes: PushTable, loop: CollectionLoop | None = None) -> tuple[str, ...]:
    """Test the reading of pushes of any number of objects against their motions; return what was
    seen, in words.

    loop : who is pushed where; objects of the MIT dataset that the data name are known without.
        Raises OtherConvention where another reading of an object's pushes explains them far better.
    """
    if loop is not None and not isinstance(loop, CollectionLoop):
        # Nobody knows what pushes of another kind of loop do.
        return ()
    said, checks, convention = list[str](), list[MotionCheck](), pushes.convention
    followed = pushes.table[pushes.table["theta_next"].notna()]
    if len(followed) and followed["dtheta"].isna().all():
        now, later = followed[["theta0", "theta_next"]].to_numpy().T
        said += check_orientations(now, later, None if loop is None else _plain(loop), convention)
    for name, rows in pushes.table.groupby("object", dropna=False, sort=False):
        known = _loop_of(name, loop)
        if loop is None and not rows[["side", "fraction"]].notna().all(axis=None):
            known = None
        found = _check_motion(rows, known, convention, pushes.convention_told)
        checks += [] if found is None else [found]
    if len(checks) <= _MOST_TOLD:
        return tuple(dict.fromkeys((*said, *(check.words for check in checks))))
    low, high = (1e3 * end(check.distance for check in checks) for end in (min, max))
    told = f"read with {convention.words()}: pushes of {len(checks)} objects end"
    told += f" {low:.3g} to {high:.3g} mm off isotropic friction's, in the medians"
    return (*said, told + any(check.by_rod for check in checks) * _BY_ROD)


def _plain(loop: CollectionLoop) -> CollectionLoop:
    """The loop on a flat floor of isotropic friction."""
    return replace(loop, material=load_material("isotropic"), footprint=None, accuracy=1e-6)


def _loop_of(name: object, loop: CollectionLoop | None) -> CollectionLoop | None:
    """The loop with the object that data name; None where nobody knows its outline."""
    if not isinstance(name, str) or (loop is not None and name == file_stem(loop.slider.name)):
        return loop
    if name not in MIT_SHAPE_NAMES:
        return None
    return replace(loop or CollectionLoop.mit("isotropic"), slider=Slider.mit(name), footprint=None)


def check_orientations(
    theta: Array, theta_next: Array, loop: CollectionLoop | None, convention: Convention = OURS
) -> tuple[str, ...]:
    """Test the sense of orientations (n,), rad, before pushes and before the next ones, by what a
    loop makes of them.

    Alone they cannot tell it, which is said; beside a loop that explains them in a mirror, and only
    there, they do:
    OtherConvention is raised then. convention : in which they were read.
    """
    angles = convention.words().partition("angles ")[2]
    said = (f"angles taken as {angles}: orientations alone cannot tell; --angles says otherwise",)
    if theta.size < FEWEST or not isinstance(loop, CollectionLoop) or not convention.is_ours:
        return said
    chosen = evenly_spread(theta.size, _MOST)
    coarse, off = replace(loop, accuracy=1e-6), dict[str, float]()
    for name, (sense, zero) in ANGLES.items():
        before, after = (sense * angle[chosen] + zero for angle in (theta, theta_next))
        off[name] = float(np.median(np.abs(shorter_way(after - coarse.next_theta(before)))))
    here = off.pop("counter-clockwise")
    # Where the zero of angles makes no difference the plainer one is named.
    best = next(name for name in off if off[name] <= _HARDLY * min(off.values()) + _SAME_ANGLE)
    if off[best] < _BEATEN * here and here > _LEAST_OFFSET:
        told = (
            f"cycles lie {math.degrees(here):.3g}° from the map of {loop.material.name}, in "
            f"the median of {len(chosen)}"
        )
        mend = (
            f"give --angles {best} if they are counted so (in collection.toml: [data] angles "
            f'= "{best}")'
        )
        raise OtherConvention(f"{told}; counted {best}, {math.degrees(off[best]):.3g}°: {mend}")
    return said


@dataclass(frozen=True)
class _Reading:
    """One way to read: a convention, and factors to the lengths and angles as they were read."""

    convention: Convention
    length: float = 1.0
    angle: float = 1.0

    def place(self, written: Array) -> Array:
        """Places as complex numbers in our frame; both ways to lay axes otherwise are their own
        inverse.
        """
        x, y = self.convention.place(written.real, written.imag)
        return np.asarray(self.length * (x + 1j * y))


@dataclass(frozen=True, eq=False)
class _Written:
    """Pushes as they are written: places, displacements, first and last places of the rod as
    complex numbers, angles and turns; m and rad as read.

    taken : in which they were read. rows : of the table, for what is no motion. tips : (n, 2), NaN
        where unknown.
    """

    taken: Convention
    rows: pandas.DataFrame
    place: Array
    angle: Array
    moved: Array
    turn: Array
    tips: Array

    @classmethod
    def of(cls, rows: pandas.DataFrame, taken: Convention) -> _Written:
        x0, y0, theta, x1, y1, turn = rows[_POSES].to_numpy(dtype=float).T
        ends, ours = rows[[*RODS]].to_numpy(dtype=float), _Reading(taken)
        return cls(
            taken,
            rows,
            ours.place(x0 + 1j * y0),
            taken.sense * (theta - taken.theta(0.0)),
            ours.place(x1 - x0 + 1j * (y1 - y0)),
            taken.sense * turn,
            ours.place(ends[:, ::2] + 1j * ends[:, 1::2]),
        )

    @property
    def has_tips(self) -> bool:
        """Whether it is known of every push where the rod went."""
        return bool((np.abs(self.tips[:, 1] - self.tips[:, 0]) > 0.0).all())

    @property
    def is_spread(self) -> bool:
        """Whether directions are spread: they tell a zero of angles then."""
        return bool(abs(np.exp(1j * self.angle).mean()) <= _SPREAD)

    def where(self, kept: Mask) -> _Written:
        """Some of the pushes."""
        arrays = (self.place, self.angle, self.moved, self.turn, self.tips)
        return _Written(self.taken, self.rows[kept], *(values[kept] for values in arrays))

    def read(self, reading: _Reading) -> tuple[Array, Array, Array]:
        """Orientations, displacements in the object's frame before the push, and turns."""
        theta = reading.convention.theta(reading.angle * self.angle)
        motion = reading.place(self.moved) * np.exp(-1j * theta)
        return theta, motion, reading.convention.sense * reading.angle * self.turn


@dataclass(frozen=True, eq=False)
class _Test:
    """Pushes, and how far off each is, (n,) m, in a reading.

    what : they do, in words. others : than the reading taken. lever : m, of turns. lengths_known :
        whether what is expected has lengths. by_rod : whether the rod's places tell it, and no
        contact. also : what else than another reading would do, in words.
    """

    what: str
    written: _Written
    distances: Callable[[_Reading], Array]
    others: list[_Reading]
    lever: float = 0.0
    lengths_known: bool = False
    by_rod: bool = False
    also: str = ""

    def distance(self, reading: _Reading) -> float:
        """The median of the distances."""
        return float(np.median(self.distances(reading)))


@dataclass(frozen=True, eq=False)
class _Looked:
    """How far off (m, in the median) the reading taken is and the next best, which that is, and
    others that are as good.
    """

    test: _Test
    here: float
    best: float
    other: _Reading
    twins: list[_Reading]

    @classmethod
    def at(cls, test: _Test) -> _Looked:
        taken = _Reading(test.written.taken)
        found = [(test.distance(reading), reading) for reading in test.others]
        enough = _HARDLY * min((distance for distance, _ in found), default=math.inf) + _NOTHING
        # They come by how much they change: the first that is hardly worse than the best is taken.
        best, other = next((near for near in found if near[0] <= enough), (math.inf, taken))
        enough = _HARDLY * best + _NOTHING
        twins = [reading for distance, reading in found if reading != other and distance <= enough]
        return cls(test, test.distance(taken), best, other, twins)

    @property
    def taken(self) -> Convention:
        """In which the pushes were read."""
        return self.test.written.taken

    @property
    def is_turned(self) -> bool:
        """Whether the other reading has another zero of angles."""
        return self.other.convention.offset != self.taken.offset

    def explains(self, moved: float) -> bool:
        """Whether the other reading explains motions, of size `moved` (m), far better, and most
        pushes agree in that.
        """
        other, here = self.other, self.here
        limit = _BEATEN if (other.length, other.angle) == (1.0, 1.0) else _BEATEN_UNIT
        most = (_EXPLAINS_TURNED if self.is_turned else _EXPLAINS) * other.length * moved
        if self.best > min(limit * here, most) or here <= _WELL * moved:
            return False
        nearer = self.test.distances(other) < self.test.distances(_Reading(self.taken))
        return float(np.mean(nearer)) > _MOST_AGREE


def _check_motion(
    table: pandas.DataFrame, loop: CollectionLoop | None, convention: Convention, told: bool
) -> MotionCheck | None:
    """Test the reading of pushes, rows of `PushTable.table`, against their motions; None where
    these cannot tell.

    loop : who is pushed where; None: then pushes alike are asked to move the object alike in its
        own frame, which tells whether angles and axes turn the same way, not which way that is.
        convention : in which the table was read. told : whether somebody said it, who is then
        warned, not refused.
    """
    rows = table[np.isfinite(table[_POSES].astype(float)).all(axis=1)]
    if len(rows) < FEWEST:
        return None
    written = _Written.of(rows.iloc[evenly_spread(len(rows), _MOST)], convention)
    test = _alike(written) if loop is None else _prediction(written, _plain(loop))
    if test is None or len(test.written.turn) < FEWEST:
        return None
    moved = float(np.median(np.hypot(np.abs(written.moved), test.lever * written.turn)))
    looked, by_rod = _Looked.at(test), False
    if (
        loop is not None
        and looked.here > _EXPLAINS * moved
        and written.has_tips
        and not test.by_rod
    ):
        # What the rod's places explain, and the contacts that are told do not, was not pushed
        # there. A zero of angles that is free to be anything explains pushes that are alike,
        # wherever they were made.
        of_rod = _Looked.at(_with_tips(written, _plain(loop)))
        share = 1.0 if looked.is_turned else _BEATEN
        by_rod = min(of_rod.here, of_rod.best) < share * min(looked.here, looked.best)
        looked = of_rod if by_rod else looked
    nearest = min(looked.here, looked.best)
    if looked.explains(moved):
        line = _refusal(looked)
        if not told:
            raise OtherConvention(line)
        warnings.warn(line, DoubtfulInput, stacklevel=3)
    elif looked.test.lengths_known and nearest > max(_FAR * moved, looked.test.lever):
        far = (
            f"{looked.test.what} {1e3 * looked.here:.3g} mm off in the median, and not less than "
            f"{1e3 * looked.best:.3g} mm in any reading"
        )
        doubt = f"{far}: are object, push and units those of the data?"
        warnings.warn(doubt, DoubtfulInput, stacklevel=3)
    return MotionCheck(looked.here, by_rod, _words(looked) + by_rod * _BY_ROD)


def _refusal(looked: _Looked) -> str:
    """What is wrong, and the words that mend it."""
    test, other, taken = looked.test, looked.other.convention, looked.taken
    count = len(test.written.turn)
    off = f"{test.what} {1e3 * looked.here:.3g} mm off in the median of {count} pushes"
    nearer = f"{1e3 * looked.best:.3g} mm"
    if looked.other.length != 1.0 or looked.other.angle != 1.0:
        unit, kind = _unit(looked.other)
        also = f" {other.options()}" if other != taken else ""
        return f"{off}; were its {kind} in {unit}, {nearer}: give --units {unit}{also}"
    changed = []
    if other.angles != taken.angles:
        changed.append(f'angles = "{other.angles}"')
    if other.frame != taken.frame:
        changed.append(f'frame = "{other.frame}"')
    if looked.is_turned:
        changed.append(f"offset_deg = {math.degrees(other.offset):.0f}")
    mend = f"give {other.options()}{test.also} (in collection.toml: [data] {', '.join(changed)})"
    named = [
        twin.convention.options()
        for twin in looked.twins
        if twin.convention.offset == taken.offset and twin.length == 1.0
    ]
    if named and not test.also:
        mend += f"; or, which turns the world's frame against that, {' or '.join(named[:2])}"
    return f"{off}, read with {taken.words()}; with {other.words()}, {nearer}: {mend}"


def _unit(reading: _Reading) -> tuple[str, str]:
    """The unit that a reading is of, and of what."""
    if reading.angle != 1.0:
        return next(name for name, factor in _TURNED.items() if factor == reading.angle), "angles"
    away = {name: abs(math.log(size / reading.length)) for name, size in LENGTH_UNITS.items()}
    return min(away, key=lambda name: away[name]), "lengths"


def _words(looked: _Looked) -> str:
    taken, other = looked.taken, looked.other.convention
    here, best = (f"{1e3 * distance:.3g} mm" for distance in (looked.here, looked.best))
    told = f"read with {taken.words()}: {looked.test.what} {here} off in the median"
    if looked.best <= looked.here / _BEATEN and other != taken:
        mirror = f"motions cannot tell that from {other.words()} ({best}): that is assumed"
        return f"{told}; {mirror}"
    return f"{told}, {best} in the next best reading"


def _middle(motion: Array) -> complex:
    """The median of complex numbers, of each part by itself."""
    return complex(np.median(motion.real), np.median(motion.imag))


def _alike(written: _Written) -> _Test:
    """Pushes at one place of one object, told by no loop: they move it alike in its own frame,
    whatever that is. The other sense of angles, and other units of them, are asked for; axes laid
    the other way do the same.
    """
    labels = written.rows.groupby(["object", *_CONTACT], dropna=False, sort=False).ngroup()
    own = written.where((labels == labels.value_counts(sort=False).idxmax()).to_numpy())
    taken = written.taken

    def distances(reading: _Reading) -> Array:
        motion = own.read(reading)[1]
        return np.asarray(np.abs(motion - _middle(motion)))

    angles = "clockwise" if taken.sense > 0.0 else "counter-clockwise"
    others = [_Reading(replace(taken, angles=angles))]
    others += [_Reading(taken, angle=factor) for factor in _TURNED.values()]
    frame = "mirrored" if taken.frame == RIGHT_HANDED else RIGHT_HANDED
    also = f", or --frame {frame} where it is the axes that are, or --angles compass for "
    what = "pushes that should be alike lie, in the object's own frame,"
    return _Test(
        what, own, distances, others if own.is_spread else [], also=f"{also}headings from y"
    )


def _with_tips(written: _Written, plain: CollectionLoop) -> _Test:
    """Pushes whose contact is told by the rod's places alone: what a loop predicts depends on the
    reading.
    """
    lever, model = 0.5 * plain.slider.outline.extent, replace(plain, accuracy=1e-4).model

    def distances(reading: _Reading) -> Array:
        theta, _, turn = written.read(reading)
        place, tips = reading.place(written.place), reading.place(written.tips)
        # A rod inside the object: as far off as nothing is.
        ends = np.full((len(theta), 3), 1e3)
        for end, here, angle, (first, last) in zip(ends, place, theta, tips, strict=True):
            pose = Pose(float(here.real), float(here.imag), float(angle))
            rod = (float(first.real), float(first.imag)), (float(last.real), float(last.imag))
            with suppress(CycleMapError):
                end[:] = predicted_push_ends(model, [MeasuredPush(pose, pose, *rod)])[0][0]
        away = place + reading.place(written.moved) - (ends[:, 0] + 1j * ends[:, 1])
        return np.asarray(np.hypot(np.abs(away), lever * (theta + turn - ends[:, 2])))

    return _Test(_PREDICTED, written, distances, _named(written.taken), lever, by_rod=True)


def _prediction(written: _Written, plain: CollectionLoop) -> _Test | None:
    """The pushes with what isotropic friction makes of them; None where it makes nothing of
    most.
    """
    rows = written.rows
    if not rows[["side", "fraction"]].notna().all(axis=None) and written.has_tips:
        return _with_tips(written, plain)
    contacts = rows[_CONTACT].assign(length=rows["length"].round(3))
    labels = contacts.groupby([*contacts], dropna=False).ngroup().to_numpy()
    expected, turned = np.full(len(rows), np.nan, dtype=complex), np.full(len(rows), np.nan)
    for label in np.unique(labels):
        alike = labels == label
        length = float(np.median(rows["length"][alike]))
        with suppress(CycleMapError):
            push = told_push(plain.push, dict(rows[_CONTACT][alike].iloc[0]), length)
            cycle = replace(plain, push=push).cycle(0.0)
            expected[alike], turned[alike] = complex(*cycle.push_displacement), cycle.push_turn
    good = np.isfinite(turned)
    if good.sum() < max(FEWEST, 0.5 * len(rows)):
        return _with_tips(written, plain) if written.has_tips else None
    own, expected, turned = written.where(good), expected[good], turned[good]
    lever, lengths_known = 0.5 * plain.slider.outline.extent, bool(rows["length"].notna().all())

    def distances(reading: _Reading) -> Array:
        _, motion, turn = own.read(reading)
        # Turns were taken the shorter way round in the unit as read: of another they tell nothing.
        off = 0.0 if reading.angle != 1.0 else lever * (turn - turned)
        return np.asarray(np.hypot(np.abs(motion - expected), off))

    others = _named(written.taken)
    others += [_Reading(zero) for zero in _turned(own, expected)] if own.is_spread else []
    lengths = LENGTH_UNITS.values() if lengths_known else ()
    factors = sorted({a / b for a, b in product(lengths, lengths)} - {1.0})
    for convention in (written.taken, *_conventions()):
        others += [_Reading(convention, length=factor) for factor in factors]
        others += [_Reading(convention, angle=factor) for factor in _TURNED.values()]
    return _Test(_PREDICTED, own, distances, others, lever, lengths_known)


def _conventions() -> list[Convention]:
    """All that have a name, those that change least first."""
    every = [Convention(angles, frame) for angles, frame in product(ANGLES, FRAMES)]
    return sorted(
        every,
        key=lambda known: (known.angles != "counter-clockwise") + (known.frame != RIGHT_HANDED),
    )


def _named(taken: Convention) -> list[_Reading]:
    """All conventions that have a name but the one taken."""
    return [_Reading(convention) for convention in _conventions() if convention != taken]


def _turned(written: _Written, expected: Array) -> Iterator[Convention]:
    """The two senses, each with the zero of its angles where motions want it."""
    for convention in _conventions():
        if convention.angles == "compass" or convention.frame == "swapped":
            continue
        _, motion, _ = written.read(_Reading(convention))
        zero = cmath.phase(_middle(motion / expected))
        offset = math.radians(round(math.degrees(zero)))
        off = (math.remainder(offset - own, TWO_PI) for own in (0.0, written.taken.offset))
        if min(map(abs, off)) > _LEAST_OFFSET:
            yield replace(convention, offset=offset)
