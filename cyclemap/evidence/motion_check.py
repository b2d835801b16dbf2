"""Is what data call orientation and place what we call so? Measured motions tell: a mirror image
moves otherwise.

Of all ways to count angles and to lay axes the one is looked for in which pushes move the object
most nearly as isotropic friction would have it; a few millimetres and degrees are the surface's
own, a wrong reading misses by as much as the object moves.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array, evenly_spread, shorter_way
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.evidence.predicted_strokes import predicted_push_ends
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
_LENGTHS = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "m": 1.0}
_TURNED = {"deg": math.radians(1.0), "rad": math.degrees(1.0)}
_BY_ROD = (
    "; sides, fractions and angles that are told are passed over: the rod's places are elsewhere"
)
_TIPS = ["tip_x0", "tip_y0", "tip_x1", "tip_y1"]
_PLAIN: dict[str, Any] = {
    "material": load_material("isotropic"),
    "footprint": None,
    "accuracy": 1e-6,
}
_POSES = ["x0", "y0", "theta0", "x1", "y1", "dtheta"]


class OtherConvention(InvalidInput):
    """Data whose motions another reading explains far better: the message has the words that mend
    it.
    """


@dataclass(frozen=True)
class MotionCheck:
    """How far motions lie from isotropic friction's as they were read, and in the next best
    reading.

    Attributes
    ----------
    count : int
        Of pushes.
    taken, other : Convention
        The readings.
    distance, other_distance : float
        Of each from isotropic friction's motions, m, in the median.
    by_rod : bool
        Whether the rod's places tell the contacts, against the sides and fractions that are
        told.
    words : str
        For people.
    """

    count: int
    taken: Convention
    distance: float
    other: Convention
    other_distance: float
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
    said, checks, table = list[str](), list[MotionCheck](), pushes.table
    alone = table[table["dtheta"].isna() & table["theta_next"].notna()]
    if len(alone) == len(table[table["theta_next"].notna()]) and len(alone):
        now, later = (alone[name].to_numpy(dtype=float) for name in ("theta0", "theta_next"))
        said += check_orientations(
            now, later, None if loop is None else replace(loop, **_PLAIN), pushes.convention
        )
    for name, rows in pushes.table.groupby("object", dropna=False, sort=False):
        known = loop
        if isinstance(name, str) and (loop is None or name != file_stem(loop.slider.name)):
            known = None
            if name in MIT_SHAPE_NAMES:
                known = replace(
                    loop or CollectionLoop.mit("isotropic"), slider=Slider.mit(name), footprint=None
                )
        told = rows[["side", "fraction"]].notna().all(axis=None)
        if loop is None and not told:
            known = None
        found = check_motion(rows, known, pushes.convention, pushes.convention_told)
        checks += [] if found is None else [found]
    if len(checks) > _MOST_TOLD:
        low, high = (1e3 * end([one.distance for one in checks]) for end in (min, max))
        told = f"read with {pushes.convention.words()}: pushes of {len(checks)} objects end"
        told += f" {low:.3g} to {high:.3g} mm off isotropic friction's, in the medians"
        return (*said, told + any(one.by_rod for one in checks) * _BY_ROD)
    return tuple(dict.fromkeys((*said, *(one.words for one in checks))))


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
    if theta.size < FEWEST or not isinstance(loop, CollectionLoop):
        return said
    chosen = evenly_spread(theta.size, _MOST)
    coarse, off = replace(loop, accuracy=1e-6), {}
    for name, (sense, zero) in ANGLES.items():
        before, after = (sense * angle[chosen] + zero for angle in (theta, theta_next))
        off[name] = float(np.median(np.abs(shorter_way(after - coarse.next_theta(before)))))
    here = off.pop("counter-clockwise")
    if not convention.is_ours:
        return said
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


@dataclass(frozen=True, eq=False)
class _Written:
    """Pushes as they are written: places (n, 2), angles (n,), displacements (n, 2), turns (n,); m
    and rad as read.

    tips : (n, 2, 2) first and last place of the rod, NaN where unknown. rows : of the table, for
        what is no motion.
    """

    rows: pandas.DataFrame
    place: Array
    angle: Array
    moved: Array
    turn: Array
    tips: Array

    @classmethod
    def of(cls, rows: pandas.DataFrame, convention: Convention) -> _Written:
        x0, y0, theta, x1, y1, turn = (rows[name].to_numpy(dtype=float) for name in _POSES)
        # Both ways to lay axes otherwise are their own inverse.
        place, moved = (
            np.stack(convention.place(*pair), axis=-1) for pair in ((x0, y0), (x1 - x0, y1 - y0))
        )
        angle = convention.sense * (theta - convention.theta(0.0))
        ends = rows[_TIPS].to_numpy(dtype=float).reshape(-1, 2, 2)
        tips = np.stack(convention.place(ends[..., 0], ends[..., 1]), axis=-1)
        return cls(rows, place, angle, moved, convention.sense * turn, tips)

    @property
    def has_tips(self) -> bool:
        """Whether it is known of every push where the rod went."""
        return bool((np.hypot(*(self.tips[:, 1] - self.tips[:, 0]).T) > 0.0).all())

    def where(self, kept: Any) -> _Written:
        """Some of the pushes."""
        arrays = (self.place, self.angle, self.moved, self.turn, self.tips)
        return _Written(self.rows[kept], *(one[kept] for one in arrays))

    def read(self, reading: _Reading) -> tuple[Array, Array, Array]:
        """Orientations, displacements as complex numbers in the object's frame before the push, and
        turns.
        """
        theta = reading.convention.theta(reading.angle * self.angle)
        x, y = reading.convention.place(*(reading.length * self.moved.T))
        return (
            theta,
            (x + 1j * y) * np.exp(-1j * theta),
            reading.convention.sense * reading.angle * self.turn,
        )


def check_motion(
    table: pandas.DataFrame,
    loop: CollectionLoop | None,
    convention: Convention = OURS,
    told: bool = False,
) -> MotionCheck | None:
    """Test the reading of pushes, rows of `PushTable.table`, against their motions; None where
    these cannot tell.

    loop : who is pushed where; None: then pushes alike are asked to move the object alike in its
        own frame, which tells whether angles and axes turn the same
        way, not which way that is. convention : in which the table was read. told : whether
        somebody said it, who is then
        warned, not refused.

    Raises OtherConvention where another reading explains the motions far better, with the options
    that say it.
    """
    rows = table[np.isfinite(table[_POSES].astype(float)).all(axis=1)]
    if len(rows) < FEWEST:
        return None
    rows = rows.iloc[evenly_spread(len(rows), _MOST)]
    written, taken = _Written.of(rows, convention), _Reading(convention)
    test = _Alike(written) if loop is None else _prediction(written, loop)
    if test is None or test.count < FEWEST:
        return None
    moved = float(np.median(np.hypot(np.hypot(*written.moved.T), test.lever * written.turn)))
    here, best, other, twins = _looked(test, taken)
    by_rod = False
    if (
        loop is not None
        and written.has_tips
        and here > _EXPLAINS * moved
        and not isinstance(test, _WithTips)
    ):
        # What the rod's places explain, and the contacts that are told do not, was not pushed
        # there.
        of_rod = _WithTips(written, replace(loop, **_PLAIN))
        looked = _looked(of_rod, taken)
        # A zero of angles that is free to be anything explains pushes that are alike, wherever they
        # were made.
        free = other.convention.offset != convention.offset
        by_rod = min(looked[:2]) < (1.0 if free else _BEATEN) * min(here, best)
        if by_rod:
            test, (here, best, other, twins) = of_rod, looked
    limit = _BEATEN if (other.length, other.angle) == (1.0, 1.0) else _BEATEN_UNIT
    turned = other.convention.offset != convention.offset
    most = (_EXPLAINS_TURNED if turned else _EXPLAINS) * other.length * moved
    explains = best <= min(limit * here, most)
    if explains and here > _WELL * moved and test.closer(other, taken):
        line = _refusal(test, here, best, taken, other, twins)
        if not told:
            raise OtherConvention(line)
        warnings.warn(line, DoubtfulInput, stacklevel=3)
    elif (
        loop is not None and test.lengths_known and min(here, best) > max(_FAR * moved, test.lever)
    ):
        far = (
            f"{test.what} {1e3 * here:.3g} mm off in the median, and not less than "
            f"{1e3 * best:.3g} mm in any reading"
        )
        warnings.warn(
            f"{far}: are object, push and units those of the data?", DoubtfulInput, stacklevel=3
        )
    words = _words(test, here, best, taken, other) + by_rod * _BY_ROD
    return MotionCheck(len(rows), convention, here, other.convention, best, by_rod, words)


def _looked(test: _Predicted, taken: _Reading) -> tuple[float, float, _Reading, list[_Reading]]:
    """How far off the reading taken is and the next best, which that is, and those that are as
    good.
    """
    found = [(test.distance(one), one) for one in test.readings(taken)]
    best, other = _nearest(found, taken)
    twins = [
        one for distance, one in found if one != other and distance <= _HARDLY * best + _NOTHING
    ]
    return test.distance(taken), best, other, twins


def _nearest(found: list[tuple[float, _Reading]], taken: _Reading) -> tuple[float, _Reading]:
    """The first reading, they come by how much they change, that is hardly worse than the best."""
    best = min((distance for distance, _ in found), default=math.inf)
    enough = (entry for entry in found if entry[0] <= _HARDLY * best + _NOTHING)
    return next(enough, (math.inf, taken))


def _refusal(
    test: Any, here: float, best: float, taken: _Reading, other: _Reading, twins: Sequence[_Reading]
) -> str:
    """What is wrong, and the words that mend it."""
    off = f"{test.what} {1e3 * here:.3g} mm off in the median of {test.count} pushes"
    if other.length != 1.0 or other.angle != 1.0:
        unit, kind = _unit(other)
        also = f" {other.convention.options()}" if other.convention != taken.convention else ""
        return f"{off}; were its {kind} in {unit}, {1e3 * best:.3g} mm: give --units {unit}{also}"
    options = other.convention.options()
    changed = [f"{key} = {value}" for key, value in _keys(other.convention, taken.convention)]
    also = test.alternative(taken)
    mend = f"give {options}{also} (in collection.toml: [data] {', '.join(changed)})"
    named = [
        one.convention
        for one in twins
        if one.convention.offset == taken.convention.offset and one.length == 1.0
    ]
    if named and not also:
        mend += (
            "; or, which turns the world's frame against that, "
            f"{' or '.join(one.options() for one in named[:2])}"
        )
    return (
        f"{off}, read with {taken.convention.words()}; with {other.convention.words()}, "
        f"{1e3 * best:.3g} mm: {mend}"
    )


def _keys(convention: Convention, taken: Convention) -> Iterator[tuple[str, str]]:
    if convention.angles != taken.angles:
        yield "angles", f'"{convention.angles}"'
    if convention.frame != taken.frame:
        yield "frame", f'"{convention.frame}"'
    if convention.offset != taken.offset:
        yield "offset_deg", f"{math.degrees(convention.offset):.0f}"


def _unit(reading: _Reading) -> tuple[str, str]:
    if reading.angle != 1.0:
        return next(name for name, factor in _TURNED.items() if factor == reading.angle), "angles"
    return min(_LENGTHS, key=lambda name: abs(math.log(_LENGTHS[name] / reading.length))), "lengths"


def _words(test: Any, here: float, best: float, taken: _Reading, other: _Reading) -> str:
    told = (
        f"read with {taken.convention.words()}: {test.what} {1e3 * here:.3g} mm off in the median"
    )
    if best <= here / _BEATEN and other.convention != taken.convention:
        mirror = other.convention.words()
        return (
            f"{told}; motions cannot tell that from {mirror} ({1e3 * best:.3g} mm): that is assumed"
        )
    return f"{told}, {1e3 * best:.3g} mm in the next best reading"


def _conventions() -> list[Convention]:
    """All that have a name, those that change least first."""
    every = [Convention(angles, frame) for angles, frame in product(ANGLES, FRAMES)]
    return sorted(
        every, key=lambda one: (one.angles != "counter-clockwise") + (one.frame != RIGHT_HANDED)
    )


class _Predicted:
    """Pushes whose motion in the object's own frame a loop predicts."""

    what = "pushes end, beside isotropic friction's,"

    def __init__(
        self, written: _Written, motion: Array, turn: Array, lever: float, lengths_known: bool
    ) -> None:
        self.written, self.motion, self.turn, self.lever = written, motion, turn, lever
        self.lengths_known, self.count = lengths_known, len(turn)

    def distances(self, reading: _Reading) -> Array:
        """How far off each push is (n,), m: place, and turn by the object's lever."""
        _, motion, turn = self.written.read(reading)
        away = np.abs(motion - self.motion)
        # Turns were taken the shorter way round in the unit as read: of another they tell nothing.
        off = 0.0 if reading.angle != 1.0 else self.lever * (turn - self.turn)
        return np.asarray(np.hypot(away, off))

    def distance(self, reading: _Reading) -> float:
        """The median of `distances`."""
        return float(np.median(self.distances(reading)))

    def closer(self, other: _Reading, taken: _Reading) -> bool:
        """Whether most pushes agree that the other is nearer."""
        return float(np.mean(self.distances(other) < self.distances(taken))) > 0.7

    def readings(self, taken: _Reading) -> list[_Reading]:
        """All others than the one taken."""
        found = [_Reading(one) for one in _conventions() if one != taken.convention]
        found += [_Reading(one) for one in self._turned(taken)]
        for convention in (taken.convention, *_conventions()):
            if self.lengths_known:
                factors = {a / b for a, b in product(_LENGTHS.values(), _LENGTHS.values())} - {1.0}
                found += [_Reading(convention, length=factor) for factor in sorted(factors)]
            found += [_Reading(convention, angle=factor) for factor in _TURNED.values()]
        return found

    def _turned(self, taken: _Reading) -> list[Convention]:
        """The two senses, each with the zero of its angles where motions want it."""
        if abs(np.exp(1j * self.written.angle).mean()) > _SPREAD:
            return []
        found = []
        for convention in _conventions():
            if convention.angles == "compass" or convention.frame == "swapped":
                continue
            _, motion, _ = self.written.read(_Reading(convention))
            zero = float(
                np.angle(
                    np.median((motion / self.motion).real)
                    + 1j * np.median((motion / self.motion).imag)
                )
            )
            offset = math.radians(round(math.degrees(zero)))
            near = (0.0, taken.convention.offset)
            if all(
                abs(math.remainder(offset - one, 2.0 * math.pi)) > _LEAST_OFFSET for one in near
            ):
                found.append(replace(convention, offset=offset))
        return found

    def alternative(self, taken: _Reading) -> str:
        """What else would do; nothing."""
        return ""


class _Alike(_Predicted):
    """Pushes at one place of one object, told by no loop: they move it alike in its own frame,
    whatever that is.
    """

    what = "pushes that should be alike lie, in the object's own frame,"

    def __init__(self, written: _Written) -> None:
        rows = written.rows
        facts = zip(
            *(map(str, rows[name]) for name in ("object", "side", "fraction", "angle")), strict=True
        )
        labels = ["|".join(row) for row in facts]
        usual = Counter(labels).most_common(1)[0][0]
        largest = np.array([label == usual for label in labels])
        super().__init__(written.where(largest), np.zeros(0), np.zeros(0), 0.0, False)
        self.count = int(largest.sum())

    def distances(self, reading: _Reading) -> Array:
        """How far each push is from the median of all (n,), m."""
        _, motion, _ = self.written.read(reading)
        return np.asarray(np.abs(motion - (np.median(motion.real) + 1j * np.median(motion.imag))))

    def readings(self, taken: _Reading) -> list[_Reading]:
        """The other sense of angles, and other units of them."""
        if abs(np.exp(1j * self.written.angle).mean()) >= _SPREAD:
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


class _WithTips(_Predicted):
    """Pushes whose contact is told by the rod's places alone: what a loop predicts depends on the
    reading.
    """

    def __init__(self, written: _Written, loop: CollectionLoop) -> None:
        super().__init__(written, np.zeros(0), np.zeros(0), 0.5 * loop.slider.outline.extent, False)
        self.model, self.count = replace(loop, accuracy=1e-4).model, len(written.turn)

    def distances(self, reading: _Reading) -> Array:
        theta, _, turn = self.written.read(reading)
        convention = reading.convention
        x, y = convention.place(*self.written.place.T)
        dx, dy = convention.place(*self.written.moved.T)
        tips = self.written.tips
        starts, ends = (np.stack(convention.place(*tips[:, end].T), axis=-1) for end in (0, 1))
        courses = zip(
            np.stack([x, y, theta], -1).tolist(), starts.tolist(), ends.tolist(), strict=True
        )
        pushes = (
            MeasuredPush(Pose(*pose), Pose(*pose), tuple(one), tuple(last))
            for pose, one, last in courses
        )
        predicted = np.array([self._end(push) for push in pushes])
        off = self.lever * (theta + turn - predicted[:, 2])
        return np.asarray(
            np.sqrt((x + dx - predicted[:, 0]) ** 2 + (y + dy - predicted[:, 1]) ** 2 + off**2)
        )

    def _end(self, push: MeasuredPush) -> Array:
        try:
            return np.asarray(predicted_push_ends(self.model, [push])[0][0])
        except CycleMapError:
            # A rod inside the object: as far off as nothing is.
            return np.full(3, 1e3)

    def readings(self, taken: _Reading) -> list[_Reading]:
        return [_Reading(one) for one in _conventions() if one != taken.convention]


def _prediction(written: _Written, loop: CollectionLoop) -> _Predicted | None:
    """The pushes with what isotropic friction makes of them;
    None where it makes nothing of most."""
    rows, plain = written.rows, replace(loop, **_PLAIN)
    labelled = rows[["side", "fraction"]].notna().all(axis=1).to_numpy()
    if not labelled.all() and written.has_tips:
        return _WithTips(written, plain)
    facts = rows[["side", "fraction", "angle", "length"]].to_numpy(dtype=float)
    known = bool(np.isfinite(facts[:, 3]).all())
    labels = np.column_stack([facts[:, :3], np.round(facts[:, 3], 3)])
    different, number = np.unique(np.nan_to_num(labels, nan=-1e9), axis=0, return_inverse=True)
    motions = np.full((len(different), 3), np.nan)
    for index, _ in enumerate(different):
        told = dict(zip(("side", "fraction", "angle"), facts[number == index][0, :3], strict=True))
        length = float(np.median(facts[number == index][:, 3]))
        try:
            one = replace(plain, push=told_push(loop.push, told, length)).cycle(0.0)
        except CycleMapError:
            continue
        motions[index] = (*one.push_displacement, one.push_turn)
    ours = motions[number.ravel()]
    good = np.isfinite(ours[:, 0])
    if good.sum() < max(FEWEST, 0.5 * len(rows)):
        return _WithTips(written, plain) if written.has_tips else None
    lever = 0.5 * loop.slider.outline.extent
    return _Predicted(
        written.where(good), ours[good, 0] + 1j * ours[good, 1], ours[good, 2], lever, known
    )
