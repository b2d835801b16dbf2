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
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cyclemap.arrays import Array, Mask, evenly_spread, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.evidence.predicted_strokes import predicted_motions, predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush, told_push
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.tables.columns import DEGREE, LENGTH_UNITS, RODS
from cyclemap.evidence.tables.conventions import ANGLES, FRAMES, OURS, RIGHT_HANDED, Convention
from cyclemap.mechanics import MIT_SHAPE_NAMES, Pose, QuasiStaticModel, Slider, load_material
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# Another reading beats the one taken where its median distance is this share of it or less, another
# unit where it is that share: measured, a right reading lies 2 to 15 mm off on floors, a wrong one
# 60 to 200 mm.
_BEATEN = 0.5
_BEATEN_UNIT = 0.3
# Of readings within this factor and distance (m) of the best the simplest is named.
_HARDLY = 1.4
_NOTHING = 5e-4
_SAME_ANGLE = math.radians(2.0)
# Fewer pushes tell a reading from chance no more; more than so many tell nothing new.
FEWEST = 6
_MOST = 400
# Objects that are told of one by one.
_MOST_TOLD = 2
# Shares of how far pushes move the object, turns by its lever: a reading nearer than the first
# explains enough for any friction; one beyond the second, or with another zero of angles beyond the
# third, explains nothing, be it the best; and of one beyond the last it is told.
_WELL = 0.04
_EXPLAINS = 0.4
_EXPLAINS_TURNED = 0.25
_FAR = 0.6
# Angles whose zero is off by less (rad) may be the surface's doing; it is asked for where
# directions are spread.
_LEAST_OFFSET = math.radians(20.0)
_SPREAD = 0.8
# Another point of the object explains motions where it leaves this share of what any other reading
# does, and pushes turn the object by so much (rad); lengths are in no unit where they are off by
# this factor's logarithm.
_CLEARLY = 0.8
_LEAST_SWEPT = 0.2
_SCALED = 0.1
# No point of an object lies further from its origin than so many of its levers.
_WITHIN = 2.2
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
    said = list[str]()
    checks = list[MotionCheck]()
    convention = pushes.convention
    followed = pushes.table[pushes.table["theta_next"].notna()]
    if len(followed) and followed["dtheta"].isna().all():
        now, later = followed[["theta0", "theta_next"]].to_numpy().T
        said += check_orientations(now, later, None if loop is None else _plain(loop), convention)
    for name, rows in pushes.table.groupby("object", dropna=False, sort=False):
        known = _loop_of(name, loop)
        has_rods = bool(rows[[*RODS]].notna().all(axis=None))
        if rows["fraction"].isna().all() and rows["side"].nunique() > 1 and not has_rods:
            doubt = (
                "pushes on several sides, and no column tells where on them: add fraction (0 to 1 "
                "from a side's first corner), or the rod's places; the collection's is taken"
            )
            warnings.warn(doubt, DoubtfulInput, stacklevel=2)
        if loop is None and not rows[["side", "fraction"]].notna().all(axis=None):
            known = None
        check = check_motion(rows, known, convention, pushes.convention_told)
        checks += [] if check is None else [check]
    if len(checks) <= _MOST_TOLD:
        return tuple(dict.fromkeys((*said, *(check.words for check in checks))))
    distances = [1e3 * check.distance for check in checks]
    words = (
        f"read with {convention.words()}: pushes of {len(checks)} objects end "
        f"{min(distances):.3g} to {max(distances):.3g} mm off isotropic friction's, in the medians"
    )
    return (*said, words + any(check.by_rod for check in checks) * _BY_ROD)


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
    there, they do: OtherConvention is raised then.
    convention : in which they were read.
    """
    angles = convention.words().partition("angles ")[2]
    said = (f"angles taken as {angles}: orientations alone cannot tell; --angles says otherwise",)
    if theta.size < FEWEST or not isinstance(loop, CollectionLoop) or not convention.is_ours:
        return said
    chosen = evenly_spread(theta.size, _MOST)
    coarse = replace(loop, accuracy=1e-6)
    off = dict[str, float]()
    for name, (sense, zero) in ANGLES.items():
        before, after = (sense * angle[chosen] + zero for angle in (theta, theta_next))
        off[name] = float(np.median(np.abs(shorter_way(after - coarse.next_theta(before)))))
    here = off.pop("counter-clockwise")
    # Where the zero of angles makes no difference the plainer one is named.
    best = next(name for name in off if off[name] <= _HARDLY * min(off.values()) + _SAME_ANGLE)
    if off[best] < _BEATEN * here and here > _LEAST_OFFSET:
        raise OtherConvention(
            f"cycles lie {math.degrees(here):.3g}° from the map of {loop.material.name}, in "
            f"the median of {len(chosen)}"
            f"; counted {best}, {math.degrees(off[best]):.3g}°: "
            f"give --angles {best} if they are counted so (in collection.toml: [data] angles "
            f'= "{best}")'
        )
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
        return self.length * (x + 1j * y)


@dataclass(frozen=True, eq=False)
class _Written:
    """Pushes as they are written: places, displacements, first and last places of the rod as
    complex numbers, angles and turns; m and rad as read.

    rows : of the table, for what is no motion.
    tips : (n, 2), NaN where unknown.
    """

    rows: pandas.DataFrame
    place: Array
    angle: Array
    moved: Array
    turn: Array
    tips: Array

    @classmethod
    def of(cls, rows: pandas.DataFrame, convention: Convention) -> _Written:
        x0, y0, theta, x1, y1, turn = rows[_POSES].to_numpy(dtype=float).T
        ends = rows[[*RODS]].to_numpy(dtype=float)
        ours = _Reading(convention)
        return cls(
            rows,
            ours.place(x0 + 1j * y0),
            convention.sense * (theta - convention.theta(0.0)),
            ours.place(x1 - x0 + 1j * (y1 - y0)),
            convention.sense * turn,
            ours.place(ends[:, ::2] + 1j * ends[:, 1::2]),
        )

    @property
    def count(self) -> int:
        """How many pushes."""
        return len(self.rows)

    @property
    def is_spread(self) -> bool:
        """Whether directions are spread enough to tell a zero of angles."""
        return bool(abs(np.exp(1j * self.angle).mean()) <= _SPREAD)

    @property
    def has_tips(self) -> bool:
        """Whether it is known of every push where the rod went."""
        return bool((np.abs(self.tips[:, 1] - self.tips[:, 0]) > 0.0).all())

    def where(self, kept: Mask) -> _Written:
        """Some of the pushes."""
        arrays = (self.place, self.angle, self.moved, self.turn, self.tips)
        return _Written(self.rows[kept], *(values[kept] for values in arrays))

    def read(self, reading: _Reading) -> tuple[Array, Array, Array]:
        """Orientations, displacements in the object's frame before the push, and turns."""
        theta = reading.convention.theta(reading.angle * self.angle)
        motion = reading.place(self.moved) * np.exp(-1j * theta)
        return theta, motion, reading.convention.sense * reading.angle * self.turn


@dataclass(frozen=True, eq=False)
class _Looked:
    """How far off (m, in the median) the reading taken is and the next best, which that is, and
    others that are as good.
    """

    test: _Test
    taken: _Reading
    here: float
    best: float
    other: _Reading
    twins: list[_Reading]

    @classmethod
    def at(cls, test: _Test, taken: _Reading) -> _Looked:
        others = [(test.distance(reading), reading) for reading in test.readings(taken)]
        enough = _HARDLY * min((distance for distance, _ in others), default=math.inf) + _NOTHING
        # They come by how much they change: the first that is hardly worse than the best is taken.
        best, other = next((near for near in others if near[0] <= enough), (math.inf, taken))
        enough = _HARDLY * best + _NOTHING
        twins = [reading for distance, reading in others if reading != other and distance <= enough]
        return cls(test, taken, test.distance(taken), best, other, twins)

    @property
    def is_turned(self) -> bool:
        """Whether the other reading has another zero of angles."""
        return self.other.convention.offset != self.taken.convention.offset

    def explains(self, moved: float) -> bool:
        """Whether the other reading explains motions, of size `moved` (m), far better."""
        other = self.other
        here = self.here
        limit = _BEATEN if (other.length, other.angle) == (1.0, 1.0) else _BEATEN_UNIT
        most = (_EXPLAINS_TURNED if self.is_turned else _EXPLAINS) * other.length * moved
        far_better = self.best <= min(limit * here, most) and here > _WELL * moved
        return far_better and self.test.closer(other, self.taken)


def check_motion(
    table: pandas.DataFrame,
    loop: CollectionLoop | None,
    convention: Convention = OURS,
    is_told: bool = False,
) -> MotionCheck | None:
    """Test the reading of pushes, rows of `PushTable.table`, against their motions; None where
    these cannot tell.

    loop : who is pushed where; None: then pushes alike are asked to move the object alike in its
        own frame, which tells whether angles and axes turn the same way, not which way that is.
    convention : in which the table was read.
    is_told : whether somebody said it, who is then warned, not refused.

    Raises OtherConvention where another reading explains the motions far better, with the options
    that say it.
    """
    rows = table[np.isfinite(table[_POSES].astype(float)).all(axis=1)]
    if len(rows) < FEWEST:
        return None
    written = _Written.of(rows.iloc[evenly_spread(len(rows), _MOST)], convention)
    test = _alike(written) if loop is None else _prediction(written, loop)
    if test is None or test.written.count < FEWEST:
        return None
    moved = float(np.median(np.hypot(np.abs(written.moved), test.lever * written.turn)))
    looked = _Looked.at(test, _Reading(convention))
    by_rod = False
    if loop is not None and looked.here > _EXPLAINS * moved and not isinstance(test, _WithTips):
        looked, by_rod = _by_rod(looked, written, loop)
    off_centre = looked.test.off_centre(
        looked.taken, min(_BEATEN * looked.here, looked.best), moved
    )
    if looked.explains(moved) or off_centre:
        line = off_centre or _refusal(looked)
        if not is_told:
            raise OtherConvention(line)
        warnings.warn(line, DoubtfulInput, stacklevel=3)
    elif loop is not None and looked.test.lengths_known:
        _doubt_far(looked, max(_FAR * moved, looked.test.lever))
    return MotionCheck(looked.here, by_rod, _words(looked) + by_rod * _BY_ROD)


def _by_rod(looked: _Looked, written: _Written, loop: CollectionLoop) -> tuple[_Looked, bool]:
    """What the rod's places explain, and the contacts that are told do not, was not pushed
    there.
    """
    if not written.has_tips:
        return looked, False
    of_rod = _Looked.at(_WithTips.on(written, _plain(loop)), looked.taken)
    # A zero of angles that is free to be anything explains pushes that are alike, wherever they
    # were made.
    share = 1.0 if looked.is_turned else _BEATEN
    if min(of_rod.here, of_rod.best) < share * min(looked.here, looked.best):
        return of_rod, True
    return looked, False


def _doubt_far(looked: _Looked, limit: float) -> None:
    """Warn where no reading comes nearer than `limit`, m."""
    if min(looked.here, looked.best) > limit:
        doubt = (
            f"{looked.test.what} {1e3 * looked.here:.3g} mm off in the median, and not less than "
            f"{1e3 * looked.best:.3g} mm in any reading: are object, push and units those of the "
            "data?"
        )
        warnings.warn(doubt, DoubtfulInput, stacklevel=4)


def _refusal(looked: _Looked) -> str:
    """What is wrong, and the words that mend it."""
    test = looked.test
    other = looked.other.convention
    taken = looked.taken.convention
    off = f"{test.what} {1e3 * looked.here:.3g} mm off in the median of {test.written.count} pushes"
    nearer = f"{1e3 * looked.best:.3g} mm"
    scale = looked.other.length
    if looked.other.angle == 1.0 and _is_no_unit(scale):
        also = f", with {other.options(taken)}" if other != taken else ""
        return (
            f"{off}; were its lengths {scale:.3g} times as long{also}, {nearer}: are they pixels? "
            "Multiply them by the length of one first"
        )
    if scale != 1.0 or looked.other.angle != 1.0:
        unit, kind = _unit(looked.other)
        also = f" {other.options(taken)}" if other != taken else ""
        return f"{off}; were its {kind} in {unit}, {nearer}: give --units {unit}{also}"
    also = test.alternative(looked.taken)
    changed = ", ".join(_keys(other, taken))
    mend = f"give {other.options(taken)}{also} (in collection.toml: [data] {changed})"
    named = [
        twin.convention.options(taken)
        for twin in looked.twins
        if twin.convention.offset == taken.offset and twin.length == 1.0
    ]
    if named and not also:
        mend += f"; or, which turns the world's frame against that, {' or '.join(named[:2])}"
    return f"{off}, read with {taken.words()}; with {other.words()}, {nearer}: {mend}"


def _keys(convention: Convention, taken: Convention) -> Iterator[str]:
    if convention.angles != taken.angles:
        yield f'angles = "{convention.angles}"'
    if convention.frame != taken.frame:
        yield f'frame = "{convention.frame}"'
    if convention.offset != taken.offset:
        yield f"offset_deg = {math.degrees(convention.offset):.6g}"


def _unit(reading: _Reading) -> tuple[str, str]:
    """The unit that a reading is of, and of what."""
    if reading.angle != 1.0:
        return next(name for name, factor in _TURNED.items() if factor == reading.angle), "angles"
    away = {name: abs(math.log(size / reading.length)) for name, size in LENGTH_UNITS.items()}
    return min(away, key=lambda name: away[name]), "lengths"


def _is_no_unit(scale: float) -> bool:
    """Whether no unit is that many times another."""
    factors = [a / b for a, b in product(LENGTH_UNITS.values(), LENGTH_UNITS.values())]
    return min(abs(math.log(scale / factor)) for factor in factors) > _SCALED


def _words(looked: _Looked) -> str:
    taken = looked.taken.convention
    other = looked.other.convention
    here, best = (f"{1e3 * distance:.3g} mm" for distance in (looked.here, looked.best))
    words = f"read with {taken.words()}: {looked.test.what} {here} off in the median"
    if looked.best <= looked.here / _BEATEN and other != taken:
        return f"{words}; motions cannot tell that from {other.words()} ({best}): that is assumed"
    return f"{words}, {best} in the next best reading"


def _conventions() -> list[Convention]:
    """All that have a name, those that change least first."""
    every = [Convention(angles, frame) for angles, frame in product(ANGLES, FRAMES)]
    return sorted(
        every, key=lambda way: (way.angles != "counter-clockwise") + (way.frame != RIGHT_HANDED)
    )


def _middle(motion: Array) -> complex:
    """The median of complex numbers, of each part by itself."""
    return complex(np.median(motion.real), np.median(motion.imag))


@dataclass(frozen=True, eq=False)
class _Test:
    """Pushes as they are written, whose motions tell how well a reading fits.

    lever : of the object, m, by which turns count as distances.
    lengths_known : whether it is known how far rods went.
    """

    what: ClassVar[str] = "pushes end, beside isotropic friction's,"

    written: _Written
    lever: float
    lengths_known: bool = False

    def distances(self, reading: _Reading) -> Array:
        """How far off each push is (n,), m: place, and turn by the object's lever."""
        raise NotImplementedError

    def distance(self, reading: _Reading) -> float:
        """The median of `distances`."""
        return float(np.median(self.distances(reading)))

    def closer(self, other: _Reading, taken: _Reading) -> bool:
        """Whether most pushes agree that the other is nearer."""
        return float(np.mean(self.distances(other) < self.distances(taken))) > 0.7

    def readings(self, taken: _Reading) -> list[_Reading]:
        """All others than the one taken."""
        named = [convention for convention in _conventions() if convention != taken.convention]
        return [_Reading(convention) for convention in named]

    def off_centre(self, taken: _Reading, limit: float, moved: float) -> str:
        """What is wrong where the places are those of another point of the object than its origin,
        as one that leaves less than `limit` (m) in the median tells; empty where none does.

        moved : m, the size of motions.
        """
        return ""

    def alternative(self, taken: _Reading) -> str:
        """What else would do; nothing."""
        return ""


@dataclass(frozen=True, eq=False)
class _Predicted(_Test):
    """Pushes whose motion (n,), complex, and turn (n,) in the object's own frame a loop predicts."""

    motion: Array = field(kw_only=True)
    turn: Array = field(kw_only=True)

    def distances(self, reading: _Reading) -> Array:
        _, motion, turn = self.written.read(reading)
        away = np.abs(motion - self.motion)
        # Turns were taken the shorter way round in the unit as read: of another they tell nothing.
        off = 0.0 if reading.angle != 1.0 else self.lever * (turn - self.turn)
        return np.hypot(away, off)

    def readings(self, taken: _Reading) -> list[_Reading]:
        others = super().readings(taken)
        if self.written.is_spread:
            others += [_Reading(convention) for convention in self._turned(taken)]
        lengths = LENGTH_UNITS.values() if self.lengths_known else ()
        factors = sorted({a / b for a, b in product(lengths, lengths)} - {1.0})
        usual = float(np.median(np.abs(self.written.moved)))
        scale = float(np.median(np.abs(self.motion))) / usual if usual > 0.0 else 0.0
        factors += [scale] if scale > 0.0 and _is_no_unit(scale) else []
        for convention in (taken.convention, *_conventions()):
            others += [_Reading(convention, length=factor) for factor in factors]
            others += [_Reading(convention, angle=factor) for factor in _TURNED.values()]
        return others

    def _turned(self, taken: _Reading) -> list[Convention]:
        """The two senses, each with the zero of its angles where motions want it."""
        turned = []
        for convention in _conventions():
            if convention.angles == "compass" or convention.frame == "swapped":
                continue
            _, motion, _ = self.written.read(_Reading(convention))
            zero = cmath.phase(_middle(motion / self.motion))
            offset = math.radians(round(math.degrees(zero)))
            off = [shorter_way(offset - known) for known in (0.0, taken.convention.offset)]
            if np.min(np.abs(off)) > _LEAST_OFFSET:
                turned.append(replace(convention, offset=offset))
        return turned

    def off_centre(self, taken: _Reading, limit: float, moved: float) -> str:
        _, motion, turn = self.written.read(taken)
        swept = np.exp(1j * turn) - 1.0
        if float(np.median(np.abs(swept))) < _LEAST_SWEPT:
            return ""
        off = motion - self.motion
        point = _middle(off / np.where(swept == 0.0, math.inf, swept))
        away = np.hypot(np.abs(off - swept * point), self.lever * (turn - self.turn))
        left = float(np.median(away))
        # Pushes that turn the object alike are off alike on any floor: then it takes more.
        alike = float(np.median(np.abs(off - _middle(off))))
        least = (_EXPLAINS if left > _CLEARLY * alike else _WELL) * moved
        is_other = left <= _CLEARLY * limit and abs(point) <= _WITHIN * self.lever
        here = self.distance(taken)
        if not is_other or here <= least:
            return ""
        return (
            f"{self.what} {1e3 * here:.3g} mm off in the median; {1e3 * left:.3g} mm, were its "
            f"places those of a point of the object ({1e3 * point.real:.3g}, "
            f"{1e3 * point.imag:.3g}) mm from its origin: give the poses of its origin, or the "
            "outline in the frame of that point"
        )


class _Alike(_Test):
    """Pushes at one place of one object, told by no loop: they move it alike in its own frame,
    whatever that is.
    """

    what = "pushes that should be alike lie, in the object's own frame,"

    def distances(self, reading: _Reading) -> Array:
        """How far each push is from the median of all (n,), m."""
        _, motion, _ = self.written.read(reading)
        return np.asarray(np.abs(motion - _middle(motion)))

    def readings(self, taken: _Reading) -> list[_Reading]:
        """The other sense of angles, and other units of them."""
        if not self.written.is_spread:
            return []
        angles = "clockwise" if taken.convention.sense > 0.0 else "counter-clockwise"
        other = _Reading(replace(taken.convention, angles=angles))
        return [other, *(_Reading(taken.convention, angle=factor) for factor in _TURNED.values())]

    def alternative(self, taken: _Reading) -> str:
        """Axes laid the other way do the same."""
        frame = "mirrored" if taken.convention.frame == RIGHT_HANDED else RIGHT_HANDED
        return (
            f", or --frame {frame} where it is the axes that are, or --angles compass for "
            "headings from y"
        )


def _alike(written: _Written) -> _Alike:
    """The pushes at the place that has most of them."""
    labels = written.rows.groupby(["object", *_CONTACT], dropna=False, sort=False).ngroup()
    largest = (labels == labels.value_counts(sort=False).idxmax()).to_numpy()
    return _Alike(written.where(largest), 0.0)


@dataclass(frozen=True, eq=False)
class _WithTips(_Test):
    """Pushes whose contact is told by the rod's places alone: what a loop predicts depends on the
    reading.
    """

    model: QuasiStaticModel = field(kw_only=True)

    @classmethod
    def on(cls, written: _Written, loop: CollectionLoop) -> _WithTips:
        """The pushes on a loop's object."""
        lever = 0.5 * loop.slider.outline.extent
        return cls(written, lever, model=replace(loop, accuracy=1e-4).model)

    def distances(self, reading: _Reading) -> Array:
        theta, _, turn = self.written.read(reading)
        place = reading.place(self.written.place)
        tips = reading.place(self.written.tips)
        pushes = zip(place.tolist(), theta.tolist(), *tips.T.tolist(), strict=True)
        ends = np.array([self._end(*push) for push in pushes])
        away = np.abs(place + reading.place(self.written.moved) - ends[:, 0])
        return np.asarray(np.hypot(away, self.lever * (theta + turn - ends[:, 1].real)))

    def _end(
        self, place: complex, theta: float, first: complex, last: complex
    ) -> tuple[complex, float]:
        pose = Pose(place.real, place.imag, theta)
        push = MeasuredPush(pose, pose, (first.real, first.imag), (last.real, last.imag))
        try:
            x, y, theta = predicted_push_ends(self.model, [push])[0][0]
        except CycleMapError:
            # A rod inside the object: as far off as nothing is.
            return complex(1e3, 1e3), 1e3
        return complex(x, y), theta


def _prediction(written: _Written, loop: CollectionLoop) -> _Test | None:
    """The pushes with what isotropic friction makes of them;
    None where it makes nothing of most."""
    rows = written.rows
    plain = _plain(loop)
    labelled = rows[["side", "fraction"]].notna().all(axis=None)
    if not labelled and written.has_tips:
        return _WithTips.on(written, plain)
    model = plain.model
    start = plain.start_pose(0.0)
    known = []
    courses = []
    for index, row in enumerate(rows.to_dict("records")):
        with suppress(CycleMapError):
            push = told_push(loop.push, row, row["length"])
            courses.append(model.course(model.push_strokes(start, push), start))
            known.append(index)
    moved = np.full((len(rows), 3), np.nan)
    moved[known] = predicted_motions(courses, most_failing=1.0)
    turn = moved[:, 0]
    motion = moved[:, 1] + 1j * moved[:, 2]
    good = np.isfinite(turn)
    if good.sum() < max(FEWEST, 0.5 * len(rows)):
        return _WithTips.on(written, plain) if written.has_tips else None
    lever = 0.5 * loop.slider.outline.extent
    lengths_known = bool(rows["length"].notna().all())
    return _Predicted(
        written.where(good), lever, lengths_known, motion=motion[good], turn=turn[good]
    )
