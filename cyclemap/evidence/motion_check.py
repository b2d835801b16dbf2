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
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cyclemap.arrays import Array, evenly_spread, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.evidence.predicted_strokes import predicted_motions, predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush, told_push
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.tables.columns import (
    ANGLES,
    DEGREE,
    FRAMES,
    LENGTH_UNITS,
    OFFSET,
    OURS,
    RIGHT_HANDED,
    RODS,
    Convention,
)
from cyclemap.mechanics import MIT_SHAPE_NAMES, Pose, QuasiStaticModel, Slider, load_material
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# Another reading beats the one taken where its median distance is this share of it or less, another
# unit where it is that share: measured, a right reading lies 2 to 15 mm off on floors, a wrong one
# 60 to 200 mm.
_BEATEN = 0.5
_BEATEN_UNIT = 0.3
# The share of pushes that have to agree.
_MOST_AGREE = 0.7
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
# Right readings lie nearer than this (m) on any floor.
_ON_FLOORS = 0.02
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
_LENGTHS = {a / b for a, b in product(LENGTH_UNITS.values(), LENGTH_UNITS.values())}
_BY_ROD = (
    "; sides, fractions and angles that are told are passed over: the rod's places are elsewhere"
)
_POSES = ["x0", "y0", "theta0", "x1", "y1", "dtheta"]
_CONTACT = ["side", "fraction", "angle"]
# Abscissas of the object before and after, and of the rod; their ordinates.
_X = ["x0", "x1", "tip_x0", "tip_x1"]
_Y = ["y0", "y1", "tip_y0", "tip_y1"]
# All conventions that have a name, those that change least first.
_CONVENTIONS = sorted(
    (Convention(angles, frame) for angles, frame in product(ANGLES, FRAMES)),
    key=lambda way: (way.angles != "counter-clockwise") + (way.frame != RIGHT_HANDED),
)


class OtherConvention(InvalidInput):
    """Data whose motions another reading explains far better: the message has the words that mend
    it.
    """


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
    checks = list[_Looked]()
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
        check = _check_motion(rows, known, convention, pushes.convention_told)
        checks += [] if check is None else [check]
    if len(checks) <= _MOST_TOLD:
        return tuple(dict.fromkeys((*said, *map(_words, checks))))
    distances = [1e3 * check.here for check in checks]
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


@dataclass(frozen=True, eq=False)
class _Written:
    """Pushes as they are written, m and rad as read.

    rows : of the table, for what is no motion.
    places : (n, 4), complex: of the object before and after, and of the rod; NaN where unknown.
    angle, turn : (n,), the object's before, and by how much it changes.
    """

    rows: pandas.DataFrame
    places: Array
    angle: Array
    turn: Array

    @classmethod
    def of(cls, rows: pandas.DataFrame, convention: Convention) -> _Written:
        # Both ways to lay axes otherwise are their own inverse.
        x, y = convention.place(*(rows[names].to_numpy(dtype=float) for names in (_X, _Y)))
        theta, turn = rows[["theta0", "dtheta"]].to_numpy(dtype=float).T
        angle = convention.sense * (theta - convention.theta(0.0))
        return cls(rows, x + 1j * y, angle, convention.sense * turn)

    @property
    def is_spread(self) -> bool:
        """Whether directions are spread enough to tell a zero of angles."""
        return bool(abs(np.exp(1j * self.angle).mean()) <= _SPREAD)

    @property
    def has_tips(self) -> bool:
        """Whether it is known of every push where the rod went."""
        return bool((np.abs(self.places[:, 3] - self.places[:, 2]) > 0.0).all())

    def read(self, reading: _Reading) -> tuple[Array, Array]:
        """Where the object is after the push, and the rod before and after, (n, 3) in the object's
        frame before it; and turns (n,).
        """
        x, y = reading.convention.place(self.places.real, self.places.imag)
        place = reading.length * (x + 1j * y)
        theta = reading.convention.theta(reading.angle * self.angle)
        own = (place[:, 1:] - place[:, :1]) * np.exp(-1j * theta)[:, None]
        return own, reading.convention.sense * reading.angle * self.turn


@dataclass(frozen=True, eq=False)
class _Looked:
    """How far off (m, in the median) the reading taken is and the next best, which that is, and
    others that are as good.

    by_rod : whether the rod's places tell the contacts, against the sides and fractions told.
    moved : m, the size of motions; 0 until that is known.
    """

    test: _Test
    taken: _Reading
    here: float
    best: float
    other: _Reading
    twins: list[_Reading]
    by_rod: bool = False
    moved: float = 0.0

    @classmethod
    def at(cls, test: _Test, taken: _Reading, by_rod: bool = False) -> _Looked:
        others = [(test.distance(reading), reading) for reading in test.readings(taken)]
        enough = _HARDLY * min((distance for distance, _ in others), default=math.inf) + _NOTHING
        # They come by how much they change: the first that is hardly worse than the best is taken.
        best, other = next((near for near in others if near[0] <= enough), (math.inf, taken))
        enough = _HARDLY * best + _NOTHING
        twins = [reading for distance, reading in others if reading != other and distance <= enough]
        return cls(test, taken, test.distance(taken), best, other, twins, by_rod)

    @property
    def is_turned(self) -> bool:
        """Whether the other reading has another zero of angles."""
        return self.other.convention.offset != self.taken.convention.offset

    def explains(self, moved: float) -> bool:
        """Whether the other reading explains motions, of size `moved` (m), far better, and most
        pushes agree.
        """
        other = self.other
        limit = _BEATEN if (other.length, other.angle) == (1.0, 1.0) else _BEATEN_UNIT
        most = (_EXPLAINS_TURNED if self.is_turned else _EXPLAINS) * other.length * moved
        if self.best > min(limit * self.here, most) or self.here <= _WELL * moved:
            return False
        closer = self.test.distances(other) < self.test.distances(self.taken)
        return float(np.mean(closer)) > _MOST_AGREE


def _check_motion(
    table: pandas.DataFrame, loop: CollectionLoop | None, convention: Convention, is_told: bool
) -> _Looked | None:
    """Test the reading of pushes, rows of `PushTable.table`, against their motions; None where
    these cannot tell.

    loop : who is pushed where; None: then pushes alike are asked to move the object alike in its
        own frame, which tells whether angles and axes turn the same way, not which way that is.
    is_told : whether somebody said the convention, who is then warned, not refused.

    Raises OtherConvention where another reading explains the motions far better, with the options
    that say it.
    """
    rows = table[np.isfinite(table[_POSES].astype(float)).all(axis=1)]
    if len(rows) < FEWEST:
        return None
    rows = rows.iloc[evenly_spread(len(rows), _MOST)]
    test = _alike(rows, convention) if loop is None else _prediction(rows, convention, loop)
    if test is None or len(test.written.rows) < FEWEST:
        return None
    looked = _Looked.at(test, _Reading(convention))
    own, turn = test.written.read(looked.taken)
    moved = float(np.median(np.hypot(np.abs(own[:, 0]), test.lever * turn)))
    if isinstance(test, _Predicted) and looked.here > _EXPLAINS * moved and test.written.has_tips:
        # What the rod's places explain, and the contacts that are told do not, was not pushed
        # there. A zero of angles that is free to be anything explains pushes that are alike,
        # wherever they were made.
        share = 1.0 if looked.is_turned else _BEATEN
        by_tips = _WithTips(test.written, test.lever, test.loop)
        of_rod = _Looked.at(by_tips, looked.taken, by_rod=True)
        if min(of_rod.here, of_rod.best) < share * min(looked.here, looked.best):
            looked = of_rod
    off_centre = looked.test.off_centre(looked, moved)
    if looked.explains(moved) or off_centre:
        line = off_centre or _refusal(looked)
        if not is_told:
            raise OtherConvention(line)
        warnings.warn(line, DoubtfulInput, stacklevel=3)
    elif min(looked.here, looked.best) > max(_FAR * moved, looked.test.lever):
        looked.test.doubt(looked)
    return replace(looked, moved=moved)


def _refusal(looked: _Looked) -> str:
    """What is wrong, and the words that mend it."""
    test = looked.test
    reading = looked.other
    taken = looked.taken.convention
    count = len(test.written.rows)
    other = reading.convention
    off = f"{test.what} {1e3 * looked.here:.3g} mm off in the median of {count} pushes"
    nearer = f"{1e3 * looked.best:.3g} mm"
    options = other.options(taken)
    if reading.angle == 1.0 and _is_no_unit(reading.length):
        also = f", with {options}" if other != taken else ""
        return (
            f"{off}; were its lengths {reading.length:.3g} times as long{also}, {nearer}: are they "
            "pixels? Multiply them by the length of one first"
        )
    if reading.length != 1.0 or reading.angle != 1.0:
        unit, kind = _unit(reading)
        also = f" {options}" if other != taken else ""
        return f"{off}; were its {kind} in {unit}, {nearer}: give --units {unit}{also}"
    also = test.alternative(looked.taken)
    changed = ", ".join(
        f"{key} = {value}" if key == OFFSET else f'{key} = "{value}"'
        for key, value in other.changes(taken).items()
    )
    mend = f"give {options}{also} (in collection.toml: [data] {changed})"
    named = [
        twin.convention.options(taken)
        for twin in looked.twins
        if twin.convention.offset == taken.offset and twin.length == 1.0
    ]
    if named and not also:
        mend += f"; or, which turns the world's frame against that, {' or '.join(named[:2])}"
    return f"{off}, read with {taken.words()}; with {other.words()}, {nearer}: {mend}"


def _unit(reading: _Reading) -> tuple[str, str]:
    """The unit that a reading is of, and of what."""
    if reading.angle != 1.0:
        return next(name for name, factor in _TURNED.items() if factor == reading.angle), "angles"
    away = {name: abs(math.log(size / reading.length)) for name, size in LENGTH_UNITS.items()}
    return min(away, key=lambda name: away[name]), "lengths"


def _is_no_unit(scale: float) -> bool:
    """Whether no unit is that many times another."""
    return min(abs(math.log(scale / factor)) for factor in _LENGTHS) > _SCALED


def _words(looked: _Looked) -> str:
    """What was seen, for people."""
    taken = looked.taken.convention
    other = looked.other.convention
    here, best = (f"{1e3 * distance:.3g} mm" for distance in (looked.here, looked.best))
    words = f"read with {taken.words()}: {looked.test.what} {here} off in the median"
    if min(looked.here, looked.best) > max(_EXPLAINS_TURNED * looked.moved, _ON_FLOORS):
        words += (
            f", and no reading explains them ({other.words()}: {best}): are object and push those "
            "of the data, and angles and axes as they are read (--offset-deg, --angles, --frame)?"
        )
    elif _BEATEN * looked.here <= looked.best <= looked.here / _BEATEN and other != taken:
        words += f"; motions cannot tell that from {other.words()} ({best}): that is assumed"
    else:
        words += f", {best} in the next best reading"
    return words + looked.by_rod * _BY_ROD


def _middle(motion: Array) -> complex:
    """The median of complex numbers, of each part by itself."""
    return complex(np.median(motion.real), np.median(motion.imag))


@dataclass(frozen=True, eq=False)
class _Test:
    """Pushes as they are written, whose motions tell how well a reading fits.

    lever : of the object, m, by which turns count as distances.
    """

    what: ClassVar[str] = "pushes end, beside isotropic friction's,"

    written: _Written
    lever: float

    def expected(self, own: Array) -> tuple[Array, Array]:
        """Motions in the object's own frame, m, and turns, rad, (n,) each, that are expected of
        places `own` (n, 3), as `_Written.read` has them.
        """
        raise NotImplementedError

    def distances(self, reading: _Reading) -> Array:
        """How far off each push is (n,), m: place, and turn by the object's lever."""
        own, turn = self.written.read(reading)
        motion, expected_turn = self.expected(own)
        off = self.lever * (turn - expected_turn)
        if reading.angle != 1.0:
            # Turns were taken the shorter way round in the unit as read: of another they tell no
            # more than that a turn is no larger than the angles are that it lies between.
            ends = self.written.rows[["theta0", "theta1"]].to_numpy(dtype=float)
            most = 2.0 * reading.angle * (float(np.abs(ends).max()) + math.pi)
            off = self.lever * np.maximum(np.abs(expected_turn) - most, 0.0)
        return np.hypot(np.abs(own[:, 0] - motion), off)

    def distance(self, reading: _Reading) -> float:
        """The median of `distances`."""
        return float(np.median(self.distances(reading)))

    def readings(self, taken: _Reading) -> list[_Reading]:
        """All others than the one taken."""
        return [_Reading(named) for named in _CONVENTIONS if named != taken.convention]

    def off_centre(self, looked: _Looked, moved: float) -> str:
        """What is wrong where the places are those of another point of the object than its origin;
        empty where that is not known.

        moved : m, the size of motions.
        """
        return ""

    def alternative(self, taken: _Reading) -> str:
        """What else would do; nothing."""
        return ""

    def doubt(self, looked: _Looked) -> None:
        """Warn where no reading comes near, if that tells anything."""


@dataclass(frozen=True, eq=False)
class _Predicted(_Test):
    """Pushes whose motion (n,), complex, and turn (n,), in the object's frame, a loop predicts."""

    loop: CollectionLoop
    motion: Array
    turn: Array

    @property
    def lengths_known(self) -> bool:
        """Whether it is known how far rods went."""
        return bool(self.written.rows["length"].notna().all())

    def expected(self, own: Array) -> tuple[Array, Array]:
        return self.motion, self.turn

    def readings(self, taken: _Reading) -> list[_Reading]:
        others = super().readings(taken)
        if self.written.is_spread:
            others += [_Reading(convention) for convention in self._turned(taken)]
        factors = sorted(_LENGTHS - {1.0}) if self.lengths_known else []
        usual = float(np.median(np.abs(self.written.read(taken)[0][:, 0])))
        scale = float(np.median(np.abs(self.motion))) / usual if usual > 0.0 else 0.0
        factors += [scale] if scale > 0.0 and _is_no_unit(scale) else []
        for convention in (taken.convention, *_CONVENTIONS):
            others += [_Reading(convention, length=factor) for factor in factors]
            others += [_Reading(convention, angle=factor) for factor in _TURNED.values()]
        return others

    def _turned(self, taken: _Reading) -> list[Convention]:
        """The two senses, each with the zero of its angles where motions want it."""
        turned = []
        for convention in _CONVENTIONS:
            if convention.angles == "compass" or convention.frame == "swapped":
                continue
            motion = self.written.read(_Reading(convention))[0][:, 0]
            zero = cmath.phase(_middle(motion / self.motion))
            offset = math.radians(round(math.degrees(zero)))
            off = [shorter_way(offset - known) for known in (0.0, taken.convention.offset)]
            if np.min(np.abs(off)) > _LEAST_OFFSET:
                turned.append(replace(convention, offset=offset))
        return turned

    def off_centre(self, looked: _Looked, moved: float) -> str:
        own, turn = self.written.read(looked.taken)
        swept = np.exp(1j * turn) - 1.0
        if float(np.median(np.abs(swept))) < _LEAST_SWEPT:
            return ""
        off = own[:, 0] - self.motion
        point = _middle(off / np.where(swept == 0.0, math.inf, swept))
        away = np.hypot(np.abs(off - swept * point), self.lever * (turn - self.turn))
        left = float(np.median(away))
        # Pushes that turn the object alike are off alike on any floor: then it takes more.
        alike = float(np.median(np.abs(off - _middle(off))))
        least = (_EXPLAINS if left > _CLEARLY * alike else _WELL) * moved
        is_nearer = left <= _CLEARLY * min(_BEATEN * looked.here, looked.best)
        if not is_nearer or abs(point) > _WITHIN * self.lever or looked.here <= least:
            return ""
        return (
            f"{self.what} {1e3 * looked.here:.3g} mm off in the median; {1e3 * left:.3g} mm, were "
            f"its places those of a point of the object ({1e3 * point.real:.3g}, "
            f"{1e3 * point.imag:.3g}) mm from its origin: give the poses of its origin, or the "
            "outline in the frame of that point"
        )

    def doubt(self, looked: _Looked) -> None:
        if self.lengths_known:
            doubt = (
                f"{self.what} {1e3 * looked.here:.3g} mm off in the median, and not less than "
                f"{1e3 * looked.best:.3g} mm in any reading: are object, push and units those of "
                "the data?"
            )
            warnings.warn(doubt, DoubtfulInput, stacklevel=4)


class _Alike(_Test):
    """Pushes at one place of one object, told by no loop: they move it alike in its own frame,
    whatever that is.
    """

    what = "pushes that should be alike lie, in the object's own frame,"

    def expected(self, own: Array) -> tuple[Array, Array]:
        return np.full(len(own), _middle(own[:, 0])), np.zeros(len(own))

    def readings(self, taken: _Reading) -> list[_Reading]:
        """The other sense of angles, and where directions are spread other units of them."""
        angles = "clockwise" if taken.convention.sense > 0.0 else "counter-clockwise"
        others = [_Reading(replace(taken.convention, angles=angles))]
        if self.written.is_spread:
            others += [_Reading(taken.convention, angle=factor) for factor in _TURNED.values()]
        return others

    def alternative(self, taken: _Reading) -> str:
        """Axes laid the other way do the same."""
        frame = "mirrored" if taken.convention.frame == RIGHT_HANDED else RIGHT_HANDED
        return (
            f", or --frame {frame} where it is the axes that are, or --angles compass for "
            "headings from y"
        )


def _alike(rows: pandas.DataFrame, convention: Convention) -> _Alike:
    """The pushes at the place that has most of them."""
    labels = rows.groupby(["object", *_CONTACT], dropna=False, sort=False).ngroup()
    largest = labels == labels.value_counts(sort=False).idxmax()
    return _Alike(_Written.of(rows[largest], convention), 0.0)


@dataclass(frozen=True, eq=False)
class _WithTips(_Test):
    """Pushes whose contact is told by the rod's places alone: what the loop predicts depends on the
    reading.
    """

    loop: CollectionLoop

    @cached_property
    def model(self) -> QuasiStaticModel:
        """The mechanics, as coarse as a reading needs it."""
        return replace(self.loop, accuracy=1e-4).model

    def expected(self, own: Array) -> tuple[Array, Array]:
        # A rod inside the object: as far off as nothing is.
        motion = np.full(len(own), 1e3 + 1e3j)
        turn = np.full(len(own), 1e3)
        for index, (_, first, last) in enumerate(own.tolist()):
            tips = (first.real, first.imag), (last.real, last.imag)
            with suppress(CycleMapError):
                push = MeasuredPush(Pose(), Pose(), *tips)
                x, y, turn[index] = predicted_push_ends(self.model, [push])[0][0]
                motion[index] = complex(x, y)
        return motion, turn


def _prediction(
    rows: pandas.DataFrame, convention: Convention, loop: CollectionLoop
) -> _Test | None:
    """The pushes with what isotropic friction makes of them; None where it makes nothing of
    most.
    """
    plain = _plain(loop)
    lever = 0.5 * loop.slider.outline.extent
    every = _Written.of(rows, convention)
    by_tips = _WithTips(every, lever, plain) if every.has_tips else None
    if by_tips and not rows[["side", "fraction"]].notna().all(axis=None):
        return by_tips
    start = plain.start_pose(0.0)
    known = []
    courses = []
    for index, row in enumerate(rows.to_dict("records")):
        with suppress(CycleMapError):
            push = told_push(loop.push, row, row["length"])
            courses.append(plain.model.course(plain.model.push_strokes(start, push), start))
            known.append(index)
    turn, dx, dy = predicted_motions(courses, most_failing=1.0).T
    good = np.isfinite(turn)
    if good.sum() < max(FEWEST, 0.5 * len(rows)):
        return by_tips
    written = _Written.of(rows.iloc[np.array(known)[good]], convention)
    return _Predicted(written, lever, plain, (dx + 1j * dy)[good], turn[good])
