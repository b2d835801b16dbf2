"""The numbers of a point: what can be asked, as `quantities.toml` lists it, the loop that its
settings make, and what the portrait of it tells.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cache, cached_property, lru_cache
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import TWO_PI
from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import noises_of, turn_statistics
from cyclemap.errors import CycleMapError, InvalidInput, unknown_name
from cyclemap.maps import (
    CircleMap,
    Estimate,
    Orbit,
    RotationNumber,
    TransferOperator,
    WrappedNormal,
    crossings_by_jump,
    fixed_points,
    is_nondecreasing,
    predict_staircase,
    rotation_number,
    transfer_operator,
)
from cyclemap.maps.operator.spectrum import mixing_time
from cyclemap.mechanics import Material
from cyclemap.protocol.settings import loop_from_settings, without_noise

PACKAGE = Path(__file__).parents[1]
# The rooms below the sweeps, and the one file here that calls them.
_SOURCES = ("mechanics", "maps", "collection", "sweeps/portrait_numbers.py")
_LANGUAGES = (".py", ".c")
# A spectral gap below this is rounding: how long such a map takes to forget is not told.
_LEAST_GAP = 1e-12


@cache
def code_version() -> str:
    """A digest of the mechanics, the maps and the bridge between them; any edit of theirs changes
    it.

    >>> len(code_version())
    16
    """
    digest = hashlib.sha256()
    for source in _SOURCES:
        root = PACKAGE / source
        # The sources in a folder, Python and C, or the one file.
        paths = (
            sorted(path for path in root.rglob("*") if path.suffix in _LANGUAGES)
            if root.is_dir()
            else [root]
        )
        for path in paths:
            digest.update(
                path.relative_to(PACKAGE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0"
            )
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class Quantity:
    """A number that every point has, or a list of numbers of which it has as many as there are.

    Attributes
    ----------
    name : str
        In Python.
    unit : str
        "rad", "1", "cycles" or "turns/cycle"; angles are kept in rad and written in degrees.
    meaning : str
        In words.
    many : str
        The name of what a list runs over, empty for a number.

    Examples
    --------
    >>> from cyclemap.sweeps import Quantity
    >>> Quantity("mean_turn", "rad", "mean turn of a cycle").written_name
    'mean_turn_deg'
    """

    name: str
    unit: str
    meaning: str
    many: str = ""

    @property
    def written_name(self) -> str:
        """The name in files, which tells degrees."""
        return f"{self.name}_deg" if self.unit == "rad" else self.name

    @property
    def written_unit(self) -> str:
        """The unit in files."""
        return "degree" if self.unit == "rad" else self.unit

    def written(self, values: ArrayLike) -> NDArray[np.float64]:
        """Values (...), SI, as files have them."""
        return np.asarray(np.degrees(values) if self.unit == "rad" else values, dtype=float)


_TEXT = (resources.files("cyclemap.sweeps") / "quantities.toml").read_text(encoding="utf-8")
GROUPS: dict[str, tuple[Quantity, ...]] = {
    group: tuple(Quantity(name, **facts) for name, facts in quantities.items())
    for group, quantities in tomllib.loads(_TEXT).items()
}
# What a phase diagram needs; each costs little beside the map.
CHEAP_GROUPS = ("map", "rotation", "fixed_points", "turns")


def chosen_groups(names: tuple[str, ...]) -> tuple[str, ...]:
    """The groups of `names` in their fixed order, with "map", which every other needs; "all" is
    each of them.

    >>> chosen_groups(("turns", "rotation"))
    ('map', 'rotation', 'turns')
    """
    if not names:
        raise InvalidInput(f"no quantities are asked for: give some of {', '.join(GROUPS)}, or all")
    for name in names:
        if name not in (*GROUPS, "all"):
            raise unknown_name("group of quantities", name, (*GROUPS, "all"))
    return tuple(name for name in GROUPS if name == "map" or name in names or "all" in names)


# How much coarser a map is tried first, and how long it is iterated; in how many parts its cubics
# are looked at.
_COARSER = 10.0
_FIRST_ITERATES = 2048
_SHARES = 8

Values = dict[str, float | tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class SweptPoint:
    """One point of a sweep.

    Attributes
    ----------
    number : int
        From 0.
    digest : str
        Names what the point's numbers depend on.
    material : Material
        The surface.
    settings : mapping of str to object
        All that differ from MIT's on `material`, noise included.
    swept : mapping of str to object
        The swept keys alone.

    Examples
    --------
    >>> from cyclemap import SweepPlan
    >>> point = SweepPlan.grid("plywood", {"mu_a": (0.2, 0.3)}).point(1)
    >>> point.number, dict(point.swept), point.material.name
    (1, {'mu_a': 0.3}, 'plywood')
    """

    number: int
    digest: str
    material: Material
    settings: Mapping[str, object]
    swept: Mapping[str, object]


@dataclass(frozen=True, eq=False)
class PointOutcome:
    """What was found at a point.

    Attributes
    ----------
    values : mapping
        Numbers, and lists of numbers, by the quantity's name, SI units and rad.
    refusal : str
        Why anything is missing; empty where nothing is.

    Examples
    --------
    >>> from cyclemap.sweeps import PointOutcome
    >>> PointOutcome({"mean_turn": 0.14}).refusal
    ''
    """

    values: Values
    refusal: str = ""


@dataclass(frozen=True)
class PortraitNumbers:
    """What a sweep asks of every point: some groups of the portrait's numbers.

    Parameters
    ----------
    groups : tuple of str, optional
        Of `GROUPS`; "map" is always among them.
    tolerance : float, default 1e-5
        Error of the cycle map, rad.
    rotation_tolerance : float, default 1e-4
        Error of the rotation number, turns a cycle; 0 is the portrait's own effort, more ends
        the iteration earlier.

    Raises
    ------
    InvalidInput
        For no group, an unknown one, and tolerances out of range.

    Notes
    -----
    The defaults are finer than a phase diagram shows. A map known to 1e-4 rad leaves the
    stationary law uncertain, and tells rotation numbers to 3e-5 turns a cycle at best, however
    long it is iterated. Where the groups need no law and rotation_tolerance is not 0, a map ten
    times as coarse as `tolerance` will do, if none within its error has another number of fixed
    points, and it tells the rotation number as finely as asked; `max_error` says how good a map
    was. With rotation_tolerance 0 every number equals that of `portrait` at the same tolerance,
    to the last bit.

    Examples
    --------
    >>> from cyclemap.sweeps import PortraitNumbers
    >>> [quantity.name for quantity in PortraitNumbers(("rotation",)).quantities][-3:]
    ['rotation_upper', 'locked_winding', 'locked_period']
    """

    groups: tuple[str, ...] = CHEAP_GROUPS
    tolerance: float = 1e-5
    rotation_tolerance: float = 1e-4

    def __post_init__(self) -> None:
        object.__setattr__(self, "groups", chosen_groups(self.groups))
        positive_number("tolerance", self.tolerance)
        non_negative_number("rotation_tolerance", self.rotation_tolerance)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities of the groups."""
        return tuple(quantity for group in self.groups for quantity in GROUPS[group])

    @property
    def version(self) -> str:
        """A digest of the code that finds the numbers; outcomes of another are never mixed in."""
        return code_version()

    def described(self) -> dict[str, object]:
        """The groups and tolerances: what else the numbers depend on, as JSON takes it."""
        return asdict(self)

    def __call__(self, point: SweptPoint) -> PointOutcome:
        """Find the numbers; what the loop or a group refuses is told in the outcome."""
        try:
            settings, said = without_noise(point.settings)
            loop = loop_from_settings(settings, CollectionLoop.mit(material=point.material))
            work = self._coarse(loop, said) or _Work(
                loop, _map_of(loop, self.tolerance), said, self.rotation_tolerance
            )
        except CycleMapError as error:
            return PointOutcome({}, str(error))
        values: Values = {}
        refusals = []
        for group in self.groups:
            try:
                values |= _FOUND[group](work)
            except CycleMapError as error:
                refusals.append(f"{group}: {error}")
        return PointOutcome(values, "; ".join(refusals))

    def _coarse(self, loop: CollectionLoop, sigma: float | None) -> _Work | None:
        """The coarser map where it settles all that is asked for."""
        if self.rotation_tolerance == 0.0 or not set(self.groups) <= set(CHEAP_GROUPS):
            return None
        coarser = _map_of(loop, _COARSER * self.tolerance)
        work = _Work(loop, coarser, sigma, self.rotation_tolerance)
        try:
            if "rotation" in self.groups and is_nondecreasing(work.map):
                # Maps that fold have an interval anyway; whether the number is told as finely as
                # asked, soon.
                rotation = rotation_number(
                    work.map, tolerance=self.rotation_tolerance, iterates=_FIRST_ITERATES
                )
                if (
                    rotation.locked is None
                    and rotation.upper - rotation.lower > 2.0 * self.rotation_tolerance
                ):
                    return None
                work.rotation = rotation
            return work if "fixed_points" not in self.groups or work.are_points_settled else None
        except CycleMapError:
            return None


# A coarser and a finer one.
@lru_cache(maxsize=2)
def _map_of(loop: CollectionLoop, tolerance: float) -> CircleMap:
    """The map of a loop; neighbours that differ in their noise alone share it."""
    return loop.circle_map(tolerance=tolerance)


@dataclass
class _Work:
    """A loop's map, and what comes of it and of its noise once it is needed.

    sigma : of the noise, rad; None as in a portrait.
    """

    loop: CollectionLoop
    map: CircleMap
    sigma: float | None
    rotation_tolerance: float

    @cached_property
    def noise(self) -> WrappedNormal:
        return noises_of(self.loop, self.map, self.sigma)[0]

    @cached_property
    def rotation(self) -> RotationNumber:
        return rotation_number(self.map, tolerance=self.rotation_tolerance)

    @cached_property
    def points(self) -> list[Orbit]:
        return fixed_points(self.map)

    @property
    def are_points_settled(self) -> bool:
        """Whether every map within this one's error crosses the diagonal as often, as far as it
        tells.
        """
        pieces = self.map.pieces
        if pieces is None or self.map.breaks.size:
            return False
        theta = pieces.knots[:-1] + np.linspace(0.0, 1.0, _SHARES, endpoint=False)[
            :, None
        ] * np.diff(pieces.knots)
        turn = self.map.turn(theta.T.ravel())
        error = self.map.max_error
        below, above = (np.floor((turn + side * error) / TWO_PI) for side in (-1.0, 1.0))
        clear = np.flatnonzero(below == above)
        if not clear.size:
            return False
        crossed = np.abs(np.diff(below[clear], append=below[clear[0]]))
        # What comes near a whole turn and goes back might touch it or not.
        passed_by = np.diff(clear, append=clear[0] + below.size) > 1
        return bool(np.all(crossed[passed_by] > 0.0) and crossed.sum() == len(self.points))

    @cached_property
    def operator(self) -> TransferOperator:
        return transfer_operator(self.map, self.noise)


def _rotation_values(work: _Work) -> Values:
    rotation = work.rotation
    locked = rotation.locked
    return {
        "rotation": float(rotation.value),
        "rotation_lower": rotation.lower,
        "rotation_upper": rotation.upper,
        "locked_winding": 0.0 if locked is None else float(locked.numerator),
        "locked_period": 0.0 if locked is None else float(locked.denominator),
    }


def _fixed_point_values(work: _Work) -> Values:
    points = work.points
    stable = tuple(float(orbit.stable) for orbit in points)
    return {
        "fixed_points": float(len(points)),
        "stable_points": sum(stable),
        "fixed_point_theta": tuple(float(orbit.points[0]) for orbit in points),
        "fixed_point_multiplier": tuple(float(orbit.multiplier) for orbit in points),
        "fixed_point_stable": stable,
        "gathering_jump_theta": tuple(
            float(jump.theta) for jump in crossings_by_jump(work.map) if jump.attracting
        ),
    }


def _stationary_values(work: _Work) -> Values:
    operator = work.operator
    # The gap without the error bound that it has in a portrait, which takes as long as all the
    # rest.
    second = float(np.abs(operator.eigenvalues(2)[1]))
    is_told = 1.0 - second > _LEAST_GAP
    return {
        "tv_from_uniform": float(operator.tv_from_uniform) if operator.is_certain else np.nan,
        "spectral_gap": 1.0 - second if is_told else np.nan,
        "mixing_cycles": float(mixing_time(Estimate(second, np.inf))) if is_told else np.nan,
    }


def _staircase_values(work: _Work) -> Values:
    staircase = predict_staircase(work.map, work.noise, work.operator)
    return {
        "noisy_mean_turn": float(staircase.mean_turn),
        "mean_residence_cycles": np.nan
        if staircase.mean_residence_cycles is None
        else float(staircase.mean_residence_cycles),
        "step": np.nan if staircase.step is None else float(staircase.step),
    }


_FOUND: dict[str, Callable[[_Work], Values]] = {
    "map": lambda work: {
        "samples": float(work.map.samples),
        "max_error": float(work.map.max_error),
    },
    "rotation": _rotation_values,
    "fixed_points": _fixed_point_values,
    "turns": lambda work: asdict(turn_statistics(work.map)),
    "stationary": _stationary_values,
    "staircase": _staircase_values,
}
