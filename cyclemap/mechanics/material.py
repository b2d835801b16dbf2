"""Materials: a surface's point friction, with its name, where its numbers come from, and what was
found with them.
"""

import math
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import NoneType

import numpy as np

from cyclemap.checks import (
    finite_array,
    finite_number,
    non_negative_number,
    positive_number,
    require_kind,
)
from cyclemap.errors import DoubtfulInput, InvalidInput, unknown_name
from cyclemap.mechanics.foundation import FLAT, FloorField, SurfaceShape
from cyclemap.mechanics.friction import EllipseFriction, worn_friction
from cyclemap.plain_text import printable

# What is believed of a plate that was not measured stands under this name.
ANY_PLATE = "any"
# Names of a material file, with what `FoundWith` calls them and the SI units of one of theirs.
FRICTION_KEYS = ("mu_a", "mu_b", "m0", "n0", "phi_deg")
SHARE_KEYS = ("inner_share", "rim_share", "corner_share")
# Shapes, kPa at 50 mm.
FLOOR_SHAPE_KEYS = ("floor_dome_kpa", "floor_bow_kpa", "floor_bow_deg")
PLATE_SHAPE_KEYS = ("plate_dome_kpa", "plate_warp_kpa", "plate_warp_deg")
SURFACE_KEYS = (*FRICTION_KEYS, *FLOOR_SHAPE_KEYS)
PLATE_KEYS = (*SHARE_KEYS, *PLATE_SHAPE_KEYS)
SPREAD_KEYS = ("dome_kpa", "bow_x_kpa", "bow_y_kpa")
FIELD_KEYS = (*SPREAD_KEYS, "reach_mm")
FOUND_KEYS = {
    "pusher_mu": ("pusher_friction", 1.0),
    "pin_friction_mm": ("pin_friction_radius", 1e-3),
}
# Friction coefficients of dry surfaces are below the one; none is known above the other.
_USUAL_FRICTION, _LARGEST_FRICTION = 2.0, 10.0
# Rows of a posterior: a sample tells a 95 % interval to a hundredth of its width with less.
_MOST_SAMPLES = 4096
# A camera that is further from the robot's frame (m) was never calibrated.
_LONGEST_SHIFT = 0.02


@dataclass(frozen=True)
class FoundWith:
    """What was identified together with a surface's friction; None where it was not: the loop's own
    value holds.

    Parameters
    ----------
    pusher_friction : float or None, optional
        Coefficient of friction of rod and object.
    pin_friction_radius : float or None, optional
        Radius of the friction circle of the rod in the ring, m.

    Raises
    ------
    InvalidInput
        For a number that is negative or not finite.

    Examples
    --------
    >>> from cyclemap.mechanics import FoundWith
    >>> FoundWith(pusher_friction=0.16).pin_friction_radius is None
    True
    """

    pusher_friction: float | None = None
    pin_friction_radius: float | None = None

    def __post_init__(self) -> None:
        for name in ("pusher_friction", "pin_friction_radius"):
            value = getattr(self, name)
            if value is not None:
                vars(self)[name] = non_negative_number(name.replace("_", " "), value)


@dataclass(frozen=True)
class PlatePressure:
    """How a plate rests: shares of its load, or the shape of its underside.

    Parameters
    ----------
    plate : str
        Name of the `Slider`.
    inner_share, rim_share, corner_share : float, default 0.0
        Shares of the load, the rest even (`PatchFootprint`), from 0 to 1, together at most 1;
        they belong to the pair of plate and surface.
    shape : SurfaceShape, optional
        Shape of the underside, kPa at 50 mm (`SurfaceShape`), the plate's on every surface; it
        takes the place of shares.

    Raises
    ------
    InvalidInput
        For a name or a shape that is none, shares outside [0, 1] or above 1 together, and for
        shares beside a shape.

    Examples
    --------
    >>> from cyclemap.mechanics import PlatePressure
    >>> PlatePressure("rect1", rim_share=0.25).shares
    {'inner_share': 0.0, 'rim_share': 0.25, 'corner_share': 0.0}
    """

    plate: str
    inner_share: float = 0.0
    rim_share: float = 0.0
    corner_share: float = 0.0
    shape: SurfaceShape = FLAT

    def __post_init__(self) -> None:
        require_kind("name of a plate", self.plate, str)
        if not self.plate or printable(self.plate) != self.plate:
            raise InvalidInput(
                f"a plate's name is {self.plate!r}: it must be the name of a slider, such as rect1"
            )
        require_kind(f"shape of {self.plate}", self.shape, SurfaceShape)
        for key in SHARE_KEYS:
            vars(self)[key] = finite_number(f"{key} of {self.plate}", getattr(self, key))
        shares = self.shares
        given = ", ".join(f"{key} {value:g}" for key, value in shares.items())
        if min(shares.values()) < 0.0 or sum(shares.values()) > 1.0 + 1e-12:
            raise InvalidInput(
                f"{given} of {self.plate}: shares must not be negative, and together be at most 1"
            )
        if any(shares.values()) and not self.shape.is_flat:
            raise InvalidInput(
                f"{given} of {self.plate} beside a shape: both tell how it rests; keep one"
            )

    @property
    def shares(self) -> dict[str, float]:
        """The three shares by name."""
        return {key: getattr(self, key) for key in SHARE_KEYS}

    @property
    def numbers(self) -> dict[str, float]:
        """What a material file holds of the plate, but for what is nought."""
        shape = shape_numbers(self.shape, PLATE_SHAPE_KEYS)
        return {key: value for key, value in (self.shares | shape).items() if value}

    @classmethod
    def of_numbers(cls, plate: str, numbers: Mapping[str, object]) -> "PlatePressure":
        """Return what a material file holds of a plate."""
        inner, rim, corner = (finite_number(key, numbers.get(key, 0.0)) for key in SHARE_KEYS)
        return cls(plate, inner, rim, corner, shape_of_numbers(numbers, PLATE_SHAPE_KEYS))


@dataclass(frozen=True)
class FloorSession:
    """A floor's shape in one session of measurements.

    Attributes
    ----------
    name : str
        Of the session.
    shape : SurfaceShape
        kPa at 50 mm.
    """

    name: str
    shape: SurfaceShape


def friction_numbers(law: EllipseFriction) -> dict[str, float]:
    """Return the numbers of a friction ellipse by the keys of a file, its angle in degrees."""
    numbers = law.mu_a, law.mu_b, law.m0, law.n0, math.degrees(law.phi)
    return dict(zip(FRICTION_KEYS, numbers, strict=True))


def shape_numbers(shape: SurfaceShape, keys: tuple[str, ...]) -> dict[str, float]:
    """Return dome, bow and axis (degrees) of a shape under three keys of a file."""
    return dict(zip(keys, (shape.dome, shape.bow, math.degrees(shape.axis)), strict=True))


def shape_of_numbers(
    numbers: Mapping[str, object], keys: tuple[str, ...], before: SurfaceShape = FLAT
) -> SurfaceShape:
    """Return the shape that three keys of a file tell; what they do not is as `before`."""
    known: dict[str, object] = {**shape_numbers(before, keys)}
    known |= {key: numbers[key] for key in keys if key in numbers}
    dome, bow, axis_deg = (finite_number(key, known[key]) for key in keys)
    return SurfaceShape(dome, bow, math.radians(axis_deg))


@dataclass(frozen=True)
class FrameShift:
    """What to add to the robot's places (m) to have them in the camera's frame, in the data of one
    plate.

    Parameters
    ----------
    plate : str
        Name of the plate whose data are shifted.
    x : float
        Shift along the robot's x, m.
    y : float
        Shift along the robot's y, m.

    Raises
    ------
    InvalidInput
        For a shift that is not finite or longer than 20 mm.

    Notes
    -----
    It belongs to those data, not to the surface: they are replayed with it, nothing is
    predicted with it.

    Examples
    --------
    >>> from cyclemap.mechanics import FrameShift
    >>> FrameShift("rect1", 0.001, 0.0).x
    0.001
    """

    plate: str
    x: float
    y: float

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            what = f"shift of the frames of {self.plate} along {name}"
            vars(self)[name] = finite_number(what, getattr(self, name))
        if math.hypot(self.x, self.y) > _LONGEST_SHIFT:
            raise InvalidInput(
                f"the frames of {self.plate} are shifted by {1e3 * math.hypot(self.x, self.y):.3g} "
                f"mm: more than {1e3 * _LONGEST_SHIFT:g} mm is no calibration"
            )


@dataclass(frozen=True)
class MaterialPosterior:
    """Sets of numbers that the data behind a material allow, drawn from their posterior.

    Parameters
    ----------
    parameters : tuple of str
        Names as in a material file, in its units: mu_a, mu_b, m0, n0, phi_deg, the floor's
        shape; the same of the worn surface with `worn.` before them; pusher_mu and what else
        [found_with] holds; numbers of a plate as `rect1.rim_share`, `rect1.plate_dome_kpa`.
    samples : array_like, shape (rows, parameters)
        2 to 4096 rows, all alike likely.

    Raises
    ------
    InvalidInput
        For a name that is unknown or given twice, rows of another length, and numbers that are
        not finite.

    Notes
    -----
    Samples, not a covariance: the angle of an ellipse is undetermined where it is nearly a
    circle.

    Examples
    --------
    >>> from cyclemap.mechanics import MaterialPosterior
    >>> MaterialPosterior(("mu_a", "rect1.rim_share"), ((0.25, 0.1), (0.26, 0.3))).samples[1]
    (0.26, 0.3)
    """

    parameters: tuple[str, ...]
    samples: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        require_kind("parameters of a posterior", self.parameters, tuple, list)
        require_kind("samples of a posterior", self.samples, tuple, list)
        names = tuple(self.parameters)
        for name in names:
            require_kind("a parameter of a posterior", name, str)
            plain = name.removeprefix("worn.")
            if plain in SURFACE_KEYS or name in FOUND_KEYS or _of_plate(name):
                continue
            known = (*SURFACE_KEYS, *(f"worn.{key}" for key in SURFACE_KEYS), *FOUND_KEYS)
            raise unknown_name(
                "posterior parameter", name, (*known, *(f"rect1.{key}" for key in PLATE_KEYS))
            )
        twice = [name for name in names if names.count(name) > 1]
        if twice or not names:
            raise InvalidInput(
                f"a posterior names {twice[0]} twice" if twice else "a posterior needs parameters"
            )
        for index, row in enumerate(self.samples):
            if not isinstance(row, list | tuple) or len(row) != len(names):
                raise InvalidInput(
                    f"posterior sample {index} must hold {len(names)} numbers, one a parameter"
                )
            for name, value in zip(names, row, strict=True):
                finite_number(f"{name} of posterior sample {index}", value)
        rows = np.array(self.samples, dtype=float)
        if not 2 <= len(rows) <= _MOST_SAMPLES:
            raise InvalidInput(
                f"a posterior has {len(rows)} samples: it needs from 2 to {_MOST_SAMPLES}"
            )
        vars(self).update(parameters=names, samples=tuple(map(tuple, rows.tolist())))

    def __len__(self) -> int:
        return len(self.samples)


@dataclass(frozen=True)
class Wear:
    """How a surface changes with the cycles that are made on it.

    Parameters
    ----------
    friction : EllipseFriction
        The friction after `cycles` cycles, to which the fresh one goes straight
        (`worn_friction`).
    cycles : float
        How many cycles that takes, positive.
    course : array_like, shape (k, 2)
        ((cycles, share), ...), how much of that way is gone after some cycles before the last,
        both increasing, shares in [0, 1], straight between; without it the pace is even.
    floor : SurfaceShape or None, optional
        The worn floor's shape, kPa at 50 mm, to which the fresh one's dome and bow go straight,
        too; None: it stays.

    Raises
    ------
    InvalidInput
        For friction or a floor that is none, cycles that are not positive, and another course.

    Examples
    --------
    >>> from cyclemap.mechanics import EllipseFriction, Wear
    >>> wear = Wear(EllipseFriction(0.2, 0.2), 1000.0, course=((250.0, 0.8),))
    >>> wear.share(250.0), wear.share(1000.0)
    (0.8, 1.0)
    """

    friction: EllipseFriction
    cycles: float
    course: tuple[tuple[float, float], ...] = ()
    floor: SurfaceShape | None = None

    def __post_init__(self) -> None:
        require_kind("friction of the worn surface", self.friction, EllipseFriction)
        require_kind("floor of the worn surface", self.floor, SurfaceShape, NoneType)
        vars(self)["cycles"] = positive_number("cycles of wear", self.cycles)
        course = finite_array("course of wear", self.course)
        if course.shape != (0,):
            course = finite_array("course of wear", course, last=2, ndim=2)
            whole = np.vstack([[0.0, 0.0], course, [self.cycles, 1.0]])
            if np.any(np.diff(whole[:, 0]) <= 0.0) or np.any(np.diff(whole[:, 1]) < 0.0):
                raise InvalidInput(
                    f"the course of wear {course.tolist()} must be pairs [cycles, share] that "
                    f"increase, between [0, 0] and [{self.cycles:g}, 1]"
                )
        vars(self)["course"] = tuple(map(tuple, course.tolist()))

    def share(self, cycles: float) -> float:
        """Return how much of the way is gone after some cycles, 0 or more, in [0, 1]."""
        at, gone = zip((0.0, 0.0), *self.course, (self.cycles, 1.0), strict=True)
        return float(np.interp(non_negative_number("cycles", cycles), at, gone))


@dataclass(frozen=True)
class CycleNoise:
    """What a cycle on this surface scatters by, as measured: log of the standard deviation (rad)
    over θ0, and memory.

    Parameters
    ----------
    log_sigma : tuple of float
        c_0, a_1, b_1, ...: log σ(θ) = c_0 + Σ a_k cos kθ + b_k sin kθ, σ in rad; an odd count
        of numbers.
    correlation : float, default 0.0
        Of successive cycles, in [0, 1).

    Raises
    ------
    InvalidInput
        For an even count of numbers, numbers that are not finite, and a correlation outside
        [0, 1).

    Examples
    --------
    >>> from cyclemap.mechanics import CycleNoise
    >>> CycleNoise(log_sigma=(-3.0, 0.2, 0.1), correlation=0.3).correlation
    0.3
    """

    log_sigma: tuple[float, ...]
    correlation: float = 0.0

    def __post_init__(self) -> None:
        numbers = finite_array("log_sigma", self.log_sigma, ndim=1)
        if numbers.size % 2 == 0:
            raise InvalidInput(
                f"log_sigma has {numbers.size} numbers: it takes one, and pairs of cosine and sine"
            )
        vars(self)["log_sigma"] = tuple(numbers.tolist())
        if not 0.0 <= finite_number("correlation", self.correlation) < 1.0:
            raise InvalidInput(
                f"correlation of successive cycles is {self.correlation:g}: it must lie in [0, 1)"
            )


# What the parts of a material are, one of each and several.
_PARTS: dict[str, tuple[type, ...]] = {
    "name": (str,),
    "friction": (EllipseFriction,),
    "found_with": (FoundWith,),
    "wear": (Wear, NoneType),
    "posterior": (MaterialPosterior, NoneType),
    "noise": (CycleNoise, NoneType),
    "floor": (SurfaceShape,),
    "field": (FloorField, NoneType),
}
_ROWS: dict[str, type] = {"plates": PlatePressure, "frames": FrameShift, "sessions": FloorSession}


@dataclass(frozen=True)
class Material:
    """A surface: its name, its point friction against the slider, and the source of the numbers.

    Parameters
    ----------
    name : str
        Names the surface in files and in print: at least a letter or a digit, no control
        characters.
    friction : EllipseFriction
        Friction of a point of the object on the fresh surface; coefficients of more than
        rubber's are a `DoubtfulInput` warning.
    provenance : str, default ''
        Source of the numbers, in words.
    misfit : str, default ''
        How far the data lie from what the numbers predict, in words.
    inferred : bool, default False
        Whether the numbers are inferred from how objects moved rather than from forces.
    found_with : FoundWith, optional
        What was identified along with the friction.
    wear : Wear or None, optional
        How it changes; None: not.
    plates : tuple of PlatePressure, default ()
        How plates rest on it; those not named are flat, and on a flat floor press evenly.
    posterior : MaterialPosterior or None, optional
        What else the data allow; None where that is not known.
    noise : CycleNoise or None, optional
        That of a cycle, as measured; None where that is not known.
    frames : tuple of FrameShift, default ()
        Shifts of the frames of the data behind it.
    floor : SurfaceShape, optional
        The floor's shape, kPa at 50 mm, its axis in the world's frame. A pressure a square
        metre carries over from object to object; what it is in mean pressures depends on the
        object's weight per area.
    sessions : tuple of FloorSession, default ()
        The floor's shape as it was in single sessions; `floor` is their mean.
    session_spread : tuple[float, float, float], default (0.0, 0.0, 0.0)
        Standard deviations of dome, bow cos 2 axis and bow sin 2 axis from session to session,
        kPa; a new session is off by so much.
    field : FloorField or None, optional
        How the floor's shape varies with the place, kPa; None: not.

    Raises
    ------
    InvalidInput
        For a name or a part that is none, friction of no surface, a plate told twice, where a
        sample of the posterior is no material, or where plates have shares on a floor that has a
        shape.

    Examples
    --------
    >>> from cyclemap import EllipseFriction, Material
    >>> slate = Material("slate", EllipseFriction(0.3, 0.2), provenance="a guess")
    >>> slate.has_flat_floor, slate.friction_after(1000.0).mu_a
    (True, 0.3)
    """

    name: str
    friction: EllipseFriction
    provenance: str = ""
    misfit: str = ""
    inferred: bool = False
    found_with: FoundWith = FoundWith()
    wear: Wear | None = None
    plates: tuple[PlatePressure, ...] = ()
    posterior: MaterialPosterior | None = None
    noise: CycleNoise | None = None
    frames: tuple[FrameShift, ...] = ()
    floor: SurfaceShape = FLAT
    sessions: tuple[FloorSession, ...] = ()
    session_spread: tuple[float, float, float] = (0.0, 0.0, 0.0)
    field: FloorField | None = None

    def __post_init__(self) -> None:
        for name, kinds in _PARTS.items():
            require_kind(f"{name} of a material", getattr(self, name), *kinds)
        for name, kind in _ROWS.items():
            rows = getattr(self, name)
            require_kind(f"{name} of a material", rows, tuple, list)
            for row in rows:
                require_kind(f"each of the {name} of a material", row, kind)
            vars(self)[name] = tuple(rows)
        spread = finite_array("session spread", self.session_spread, last=3, ndim=1)
        if np.any(spread < 0.0):
            raise InvalidInput(f"session spread {spread.tolist()}: deviations must not be negative")
        vars(self)["session_spread"] = tuple(spread.tolist())
        if not stays_flat(self):
            shared = [plate.plate for plate in self.plates if any(plate.shares.values())]
            if shared:
                raise InvalidInput(
                    f"{shared[0]} has shares of its load on a floor that has a shape: both tell "
                    "how it rests; keep one"
                )
        if (
            not re.search(r"[^\W_]", self.name)
            or printable(self.name) != self.name
            or "\n" in self.name
        ):
            raise InvalidInput(
                f"a material's name is {self.name!r}: it names files and is printed, so it needs a "
                "letter or a digit, and no control characters"
            )
        for friction in (self.friction, *([self.wear.friction] if self.wear else [])):
            largest = max(friction.mu_a, friction.mu_b)
            if largest > _LARGEST_FRICTION:
                raise InvalidInput(
                    f"friction of {largest:g} is that of no surface: give a coefficient, not per "
                    "cent"
                )
            if largest > _USUAL_FRICTION:
                warnings.warn(
                    f"friction of {largest:g} is more than rubber's: is that the coefficient?",
                    DoubtfulInput,
                    stacklevel=3,
                )
        names = [plate.plate for plate in self.plates]
        if len(set(names)) < len(names):
            raise InvalidInput(
                f"a material tells the pressure of a plate twice: {', '.join(names)}"
            )
        if self.posterior is not None:
            self._check_posterior(self.posterior)

    def _check_posterior(self, posterior: MaterialPosterior) -> None:
        fresh = {name for name in posterior.parameters if name in SURFACE_KEYS}
        worn = {
            name.removeprefix("worn.") for name in posterior.parameters if name.startswith("worn.")
        }
        if worn != (fresh if self.wear is not None else set()):
            raise InvalidInput(
                "a posterior names the numbers of the worn surface (worn.mu_a, ...) as it does "
                "those of the fresh one, and only where the surface wears"
            )
        for name in posterior.parameters:
            plate = _of_plate(name)
            if plate and self.pressure_of(plate) is None:
                raise InvalidInput(
                    f"a posterior of {name} needs a table [plates.{plate}] with what is best"
                )
            if name in FOUND_KEYS and getattr(self.found_with, FOUND_KEYS[name][0]) is None:
                raise InvalidInput(
                    f"a posterior of {name} needs {name} in [found_with], with what is best"
                )
        for index in range(len(posterior)):
            try:
                self.sample(index)
            except InvalidInput as cause:
                raise InvalidInput(f"posterior sample {index}: {cause}") from cause

    def sample(self, index: int) -> "Material":
        """Return the material of one sample of the posterior, without a posterior of its own.

        Parameters
        ----------
        index : int
            Of the sample, from 0.

        Returns
        -------
        Material
            What the posterior does not name is as in this one.

        Raises
        ------
        InvalidInput
            Where there is no such sample.
        """
        if self.posterior is None or not 0 <= index < len(self.posterior):
            raise InvalidInput(f"{self.name} has no posterior sample {index}")
        row = dict(zip(self.posterior.parameters, self.posterior.samples[index], strict=True))
        identified = {
            field: unit * row[key] for key, (field, unit) in FOUND_KEYS.items() if key in row
        }
        plates = []
        for plate in self.plates:
            before = f"{plate.plate}."
            own = {key: row[before + key] for key in PLATE_KEYS if before + key in row}
            plates.append(PlatePressure.of_numbers(plate.plate, plate.numbers | own))
        wear = self.wear
        if wear is not None:
            law = _changed(wear.friction, row, "worn.")
            worn = {key: row[f"worn.{key}"] for key in FLOOR_SHAPE_KEYS if f"worn.{key}" in row}
            shape = wear.floor or self.floor
            floor = shape_of_numbers(worn, FLOOR_SHAPE_KEYS, shape) if worn else wear.floor
            wear = replace(wear, friction=law, floor=floor)
        return replace(
            self,
            friction=_changed(self.friction, row),
            found_with=replace(self.found_with, **identified),
            wear=wear,
            plates=tuple(plates),
            posterior=None,
            floor=shape_of_numbers(row, FLOOR_SHAPE_KEYS, self.floor),
        )

    def pressure_of(self, plate: str) -> PlatePressure | None:
        """Return how a plate (the name of a slider) presses on this surface, or what is believed of
        any plate; None where neither is known.
        """
        pressures = {pressure.plate: pressure for pressure in self.plates}
        return pressures.get(plate, pressures.get(ANY_PLATE))

    def friction_after(self, cycles: float) -> EllipseFriction:
        """Return the friction after a number of cycles, 0 or more; beyond those of `wear` it stays
        the worn one.

        >>> from cyclemap.mechanics import EllipseFriction, Material, Wear
        >>> wear = Wear(EllipseFriction(0.2, 0.2), 1000.0)
        >>> slate = Material("slate", EllipseFriction(0.3, 0.2), wear=wear)
        >>> round(slate.friction_after(500.0).mu_a, 3)
        0.255
        """
        if self.wear is None:
            return self.friction
        return worn_friction(self.friction, self.wear.friction, self.wear.share(cycles))

    @property
    def has_flat_floor(self) -> bool:
        """Whether the fresh floor has no shape, here or elsewhere."""
        return self.floor.is_flat and self.field is None

    def floor_after(self, cycles: float) -> SurfaceShape:
        """Return the floor's shape after a number of cycles, kPa at 50 mm."""
        if self.wear is None or self.wear.floor is None:
            return self.floor
        share = self.wear.share(cycles)
        bend = (1.0 - share) * self.floor.bend + share * self.wear.floor.bend
        return SurfaceShape.of_bend(*bend.tolist())


def stays_flat(material: Material) -> bool:
    """Return whether a material's floor has no shape, and wears to none."""
    worn = None if material.wear is None else material.wear.floor
    return material.has_flat_floor and (worn is None or worn.is_flat)


def _of_plate(name: str) -> str:
    """Plate of a posterior's parameter such as `rect1.rim_share`; empty where it is of none."""
    plate, _, key = name.rpartition(".")
    return plate if plate != "worn" and key in PLATE_KEYS else ""


def _changed(law: EllipseFriction, row: Mapping[str, float], before: str = "") -> EllipseFriction:
    """The law with what a row names, its keys after `before`."""
    given = {key: row[before + key] for key in FRICTION_KEYS if before + key in row}
    if "phi_deg" in given:
        given["phi"] = math.radians(given.pop("phi_deg"))
    return replace(law, **given)
