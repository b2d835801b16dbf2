"""The numbers of a point: the loop that its settings make, and what the portrait of that loop tells."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np

from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA, turn_statistics
from cyclemap.collection.setting_table import without_noise
from cyclemap.errors import CycleMapError
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
from cyclemap.sweeps.code_version import code_version
from cyclemap.sweeps.quantities import CHEAP_GROUPS, Quantity, chosen_groups, quantities_of

# How much coarser a map is tried first, and how long it is iterated; in how many parts its cubics are looked at.
_COARSER, _FIRST_ITERATES, _SHARES = 10.0, 2048, 8

Values = dict[str, float | tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class SweptPoint:
    """One point of a sweep.

    number : from 0. settings : all that differ from MIT's on `material`, noise included. swept : the swept keys alone.
    """

    number: int
    digest: str
    material: Material
    settings: Mapping[str, object]
    swept: Mapping[str, object]


@dataclass(frozen=True, eq=False)
class PointOutcome:
    """What was found at a point, by quantity (SI), and why anything is missing; empty where nothing is."""

    values: Values
    refusal: str = ""


class PointNumbers(Protocol):
    """What a sweep asks of every point: picklable, and the same outcome for the same point, wherever it runs."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What an outcome may hold."""

    @property
    def version(self) -> str:
        """Which code finds the numbers; outcomes of another version are never mixed in."""

    def described(self) -> dict[str, object]:
        """What else the numbers depend on, as JSON takes it."""

    def __call__(self, point: SweptPoint) -> PointOutcome:
        """Find the numbers of a point."""


@dataclass(frozen=True)
class PortraitNumbers:
    """Some groups of the portrait's numbers.

    groups : of `GROUPS`; "map" is always among them. tolerance : of the cycle map, rad.
    rotation_tolerance : turns a cycle; 0 is the portrait's own effort, more ends the iteration earlier.

    The defaults are finer than a phase diagram shows. A map known to 1e-4 rad leaves the stationary law uncertain, and
    tells rotation numbers to 3e-5 turns a cycle at best, however long it is iterated. Where the groups need no law and
    rotation_tolerance is not 0, a map ten times as coarse as `tolerance` will do, if none within its error has another
    number of fixed points, and it tells the rotation number as finely as asked; `max_error` says how good a map was.
    With rotation_tolerance 0 every number equals that of `portrait` at the same tolerance, to the last bit.
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
        return quantities_of(self.groups)

    @property
    def version(self) -> str:
        """A digest of the code."""
        return code_version()

    def described(self) -> dict[str, object]:
        """The groups and tolerances."""
        return {
            "groups": list(self.groups),
            "tolerance": self.tolerance,
            "rotation_tolerance": self.rotation_tolerance,
        }

    def __call__(self, point: SweptPoint) -> PointOutcome:
        """Find the numbers; what the loop or a group refuses is told in the outcome."""
        try:
            loop, sigma = self._loop_and_sigma(point)
            work = self._coarse(loop, sigma) or _Work(_map_of(loop, self.tolerance), sigma, self.rotation_tolerance)
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

    def _coarse(self, loop: CollectionLoop, sigma: float) -> "_Work | None":
        """The coarser map where it settles all that is asked for."""
        if self.rotation_tolerance == 0.0 or not set(self.groups) <= set(CHEAP_GROUPS):
            return None
        work = _Work(_map_of(loop, _COARSER * self.tolerance), sigma, self.rotation_tolerance)
        try:
            settled = ("rotation" not in self.groups or work.is_rotation_settled) and (
                "fixed_points" not in self.groups or work.are_points_settled
            )
        except CycleMapError:
            return None
        return work if settled else None

    def _loop_and_sigma(self, point: SweptPoint) -> tuple[CollectionLoop, float]:
        settings, sigma = without_noise(point.settings)
        loop = CollectionLoop.from_settings(settings, CollectionLoop.mit(material=point.material))
        return loop, DEFAULT_SIGMA if sigma is None else sigma


# A coarser and a finer one.
@lru_cache(maxsize=2)
def _map_of(loop: CollectionLoop, tolerance: float) -> CircleMap:
    """The map of a loop; neighbours that differ in their noise alone share it."""
    return loop.circle_map(tolerance=tolerance)


@dataclass
class _Work:
    """A map, the noise (rad), and the operator of both once it is needed."""

    map: CircleMap
    sigma: float
    rotation_tolerance: float

    @property
    def noise(self) -> WrappedNormal:
        return WrappedNormal(self.sigma)

    @cached_property
    def rotation(self) -> RotationNumber:
        return rotation_number(self.map, tolerance=self.rotation_tolerance)

    @cached_property
    def points(self) -> list[Orbit]:
        return fixed_points(self.map)

    @property
    def is_rotation_settled(self) -> bool:
        """Whether the rotation number is told as finely as asked, soon; maps that fold have an interval anyway."""
        if not is_nondecreasing(self.map):
            return True
        found = rotation_number(self.map, tolerance=self.rotation_tolerance, iterates=_FIRST_ITERATES)
        self.rotation = found
        return found.locked is not None or found.upper - found.lower <= 2.0 * self.rotation_tolerance

    @property
    def are_points_settled(self) -> bool:
        """Whether every map within this one's error crosses the diagonal as often, as far as it tells."""
        pieces = self.map.pieces
        if pieces is None or self.map.breaks.size:
            return False
        theta = pieces.knots[:-1] + np.linspace(0.0, 1.0, _SHARES, endpoint=False)[:, None] * np.diff(pieces.knots)
        turn, error = self.map.turn(theta.T.ravel()), self.map.max_error
        below, above = (np.floor((turn + side * error) / (2.0 * np.pi)) for side in (-1.0, 1.0))
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


def _map_values(work: _Work) -> Values:
    return {"samples": float(work.map.samples), "max_error": float(work.map.max_error)}


def _rotation_values(work: _Work) -> Values:
    found = work.rotation
    winding, period = (0, 0) if found.locked is None else (found.locked.numerator, found.locked.denominator)
    return {
        "rotation": float(found.value),
        "rotation_lower": found.lower,
        "rotation_upper": found.upper,
        "locked_winding": float(winding),
        "locked_period": float(period),
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
        "gathering_jump_theta": tuple(float(jump.theta) for jump in crossings_by_jump(work.map) if jump.attracting),
    }


def _turn_values(work: _Work) -> Values:
    turns = turn_statistics(work.map)
    return {
        "mean_turn": turns.mean,
        "min_turn": turns.minimum,
        "max_turn": turns.maximum,
        "min_slope": turns.min_slope,
        "max_slope": turns.max_slope,
    }


def _stationary_values(work: _Work) -> Values:
    operator = work.operator
    # The gap without the error bound that it has in a portrait, which takes as long as all the rest.
    second = float(np.abs(operator.eigenvalues(2)[1]))
    return {
        "tv_from_uniform": float(operator.tv_from_uniform) if operator.is_certain else np.nan,
        "spectral_gap": max(0.0, 1.0 - second),
        "mixing_cycles": float(mixing_time(Estimate(second, np.inf))),
    }


def _staircase_values(work: _Work) -> Values:
    found = predict_staircase(work.map, work.noise, work.operator)
    return {
        "noisy_mean_turn": float(found.mean_turn),
        "mean_residence_cycles": np.nan if found.mean_residence_cycles is None else float(found.mean_residence_cycles),
        "step": np.nan if found.step is None else float(found.step),
    }


_FOUND: dict[str, Callable[[_Work], Values]] = {
    "map": _map_values,
    "rotation": _rotation_values,
    "fixed_points": _fixed_point_values,
    "turns": _turn_values,
    "stationary": _stationary_values,
    "staircase": _staircase_values,
}
