"""The unknowns of a surface under a pushed object, chosen so that nothing special happens where
friction is isotropic.

The limit ellipse is fixed by its mean radius sqrt(mu_a mu_b), by the vector log(mu_a/mu_b) (cos 2
phi, sin 2 phi), and by its centre in the world's axes over the mean radius. All are smooth
functions of the ellipse, a circle included, where the angle phi has no meaning. Quasi-static motion
does not depend on the mean radius, only forces do. Shapes of floor and plate are told likewise by
dome, bow cos 2 axis and bow sin 2 axis, in kPa at 50 mm (`SurfaceShape`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_number, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.mechanics import (
    EllipseFriction,
    Material,
    PatchFootprint,
    PointFootprint,
    PressedFootprint,
    Pusher,
    Slider,
    SurfaceShape,
)
from cyclemap.mechanics.foundation import FLAT, FloorField
from cyclemap.mechanics.plate_footprint import mean_pressure, pressed_footprint

Values = Mapping[str, float]
# Numbers, and their derivatives.
Rows = tuple[Array, Array]
FRICTION_NAMES = ("mu_a", "mu_b", "m0", "n0", "phi")
FLOOR_NAMES = ("floor_dome", "floor_bow_x", "floor_bow_y")
PLATE_NAMES = ("plate_dome", "plate_warp_x", "plate_warp_y")
# How a floor's shape varies with the place: factors of X^m Y^n of one height, from the reset's
# target on, in 50 mm.
HEIGHT_POWERS = ((3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (3, 1), (2, 2), (1, 3), (0, 4))
FIELD_NAMES = tuple(f"floor_h{m}{n}" for m, n in HEIGHT_POWERS)
# How fast a surface wears may differ between so many equal stretches of the cycles made on it.
PACE_NAMES = tuple(f"wear_pace_{stretch}" for stretch in range(1, 9))
# Beyond this from the target (m) pushes are too few to tell it: the shape stays what it is there.
FIELD_REACH = 0.025
# Beyond this, kPa at 50 mm, a foundation of steel plates is as good as rigid.
_RIGID = 60.0
# An ellipse rounder than this (log of the axis ratio) counts as this round: phi then stays defined,
# and no motion or force changes by more than a millionth.
ROUNDEST = 1e-6


@dataclass(frozen=True)
class Parameter:
    """One unknown.

    Parameters
    ----------
    name : str
        Names it in files and in print.
    description : str
        In plain words, for reports.
    unit : str
        SI; 1 for a pure number.
    lower, upper : float
        Bounds; infinite where there is none.
    start : float
        Where a search begins, strictly between the bounds.
    scale : float
        A change that matters, positive; starts are drawn within two scales of `start`.
    nominal : float or None, optional
        The value taken where the parameter is neither free nor given; None: `start`.

    Raises
    ------
    InvalidInput
        Where the numbers contradict each other.

    Examples
    --------
    >>> from cyclemap.evidence import Parameter
    >>> heat = Parameter("heat", "how warm it is", "K", 0.0, 10.0, start=1.0, scale=0.5)
    >>> heat.nominal
    1.0
    """

    name: str
    description: str
    unit: str
    lower: float
    upper: float
    start: float
    scale: float
    nominal: float | None = None

    def __post_init__(self) -> None:
        start = finite_number(f"start of {self.name}", self.start)
        positive_number(f"scale of {self.name}", self.scale)
        if not self.lower < start < self.upper:
            raise InvalidInput(
                f"start of {self.name} is {start}: it must lie strictly between its bounds "
                f"{self.lower}, {self.upper}"
            )
        if self.nominal is None:
            object.__setattr__(self, "nominal", start)
        nominal = finite_number(f"nominal value of {self.name}", self.nominal)
        if not self.lower <= nominal <= self.upper:
            raise InvalidInput(f"nominal value of {self.name} is {nominal}: outside its bounds")


@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """Parameters in order, each name once.

    Parameters
    ----------
    parameters : tuple of Parameter
        The parameters.

    Attributes
    ----------
    names : tuple of str
        k names.
    lower : ndarray, shape (k,)
        Lower bounds.
    upper : ndarray, shape (k,)
        Upper bounds.
    start : ndarray, shape (k,)
        Where searches begin.
    scale : ndarray, shape (k,)
        Changes that matter.

    Raises
    ------
    InvalidInput
        For a name that is given twice.

    Examples
    --------
    >>> from cyclemap.evidence import Parameter, ParameterSpace
    >>> heat = Parameter("heat", "how warm it is", "K", 0.0, 10.0, 1.0, 0.5)
    >>> ParameterSpace((heat,)).vector({"heat": 3.0})
    array([3.])
    """

    parameters: tuple[Parameter, ...]
    names: tuple[str, ...] = field(init=False)
    lower: Array = field(init=False)
    upper: Array = field(init=False)
    start: Array = field(init=False)
    scale: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(row.name for row in self.parameters))
        if len(set(self.names)) < len(self.names):
            raise InvalidInput(f"a parameter is named twice: {self.names}")
        for key in ("lower", "upper", "start", "scale"):
            column = np.array([getattr(row, key) for row in self.parameters], dtype=float)
            object.__setattr__(self, key, column)

    def __len__(self) -> int:
        return len(self.parameters)

    def __getitem__(self, name: str) -> Parameter:
        known = dict(zip(self.names, self.parameters, strict=True))
        if name not in known:
            raise unknown_name("parameter", name, self.names)
        return known[name]

    @property
    def nominal(self) -> dict[str, float]:
        """Value of each parameter where nothing is known of it."""
        return {parameter.name: float(parameter.nominal or 0.0) for parameter in self.parameters}

    def select(self, names: tuple[str, ...]) -> ParameterSpace:
        """Return the space of some of the parameters, in the order of `names`. Raises InvalidInput
        for unknown ones.
        """
        return ParameterSpace(tuple(map(self.__getitem__, names)))

    def extended(self, *parameters: Parameter) -> ParameterSpace:
        """Return the space with further parameters; one of a name that is already there takes its
        place.
        """
        new = {parameter.name: parameter for parameter in parameters}
        kept = [new.pop(parameter.name, parameter) for parameter in self.parameters]
        return ParameterSpace((*kept, *new.values()))

    def vector(self, values: Values) -> Array:
        """Return the values (k,) in this order. Raises InvalidInput for one that is missing or not
        finite.
        """
        missing = [name for name in self.names if name not in values]
        if missing:
            raise InvalidInput(
                f"no value for {', '.join(missing)}: give one for each of {', '.join(self.names)}"
            )
        return np.array([finite_number(name, values[name]) for name in self.names], dtype=float)

    def values(self, vector: Array) -> dict[str, float]:
        """Return the values (k,) by name."""
        return dict(zip(self.names, np.asarray(vector, dtype=float).tolist(), strict=True))


_OFFSET = "centre of the friction ellipse"
_AT = "at 50 mm"


def _shape(name: str, description: str) -> Parameter:
    return Parameter(name, description, "kPa", -_RIGID, _RIGID, 0.0, 4.0)


SURFACE = ParameterSpace(
    (
        Parameter(
            "friction_scale",
            "log of the mean friction coefficient",
            "1",
            -5.0,
            1.5,
            math.log(0.25),
            0.5,
        ),
        Parameter(
            "ellipticity_x",
            "log axis ratio of the friction ellipse, part along x",
            "1",
            -1.5,
            1.5,
            0.0,
            0.2,
        ),
        Parameter(
            "ellipticity_y",
            "log axis ratio of the friction ellipse, part at 45 deg",
            "1",
            -1.5,
            1.5,
            0.0,
            0.2,
        ),
        Parameter(
            "offset_x", f"{_OFFSET} along x, over its mean radius", "1", -0.95, 0.95, 0.0, 0.1
        ),
        Parameter(
            "offset_y", f"{_OFFSET} along y, over its mean radius", "1", -0.95, 0.95, 0.0, 0.1
        ),
        _shape("floor_dome", f"how the floor bends alike in all directions, {_AT}"),
        _shape("floor_bow_x", f"how much higher the floor is along x than along y, {_AT}"),
        _shape("floor_bow_y", f"the same at 45 deg, {_AT}"),
        Parameter(
            "pusher_friction",
            "friction coefficient of rod and object",
            "1",
            0.0,
            1.5,
            0.2,
            0.08,
            Pusher().friction,
        ),
        _shape("plate_dome", f"how the plate's underside bends alike in all directions, {_AT}"),
        _shape(
            "plate_warp_x", f"how much lower the plate reaches along its x than along its y, {_AT}"
        ),
        _shape("plate_warp_y", f"the same at 45 deg, {_AT}"),
        Parameter(
            "pin_friction_radius",
            "lever of the ring's friction torque over its force",
            "m",
            0.0,
            0.03,
            2e-3,
            1e-3,
            0.0,
        ),
    )
)


FIELD = tuple(
    Parameter(
        name,
        f"height of the floor that goes with X^{m} Y^{n}, {_AT}",
        "kPa",
        -_RIGID,
        _RIGID,
        0.0,
        2.0,
    )
    for name, (m, n) in zip(FIELD_NAMES, HEIGHT_POWERS, strict=True)
)


def field_factors() -> Array:
    """Return what each height adds to the coefficients of a `FloorField`, (3, 5, 9).

    A plate feels the curvature of the height h under its centroid: dome (h_xx + h_yy) / 4, bow
    (h_xx - h_yy) / 4 and h_xy / 2.
    """
    terms = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
    shares = {(2, 0): (0.25, 0.25, 0.0), (0, 2): (0.25, -0.25, 0.0), (1, 1): (0.0, 0.0, 0.5)}
    factors = np.zeros((3, 5, len(HEIGHT_POWERS)))
    for column, (m, n) in enumerate(HEIGHT_POWERS):
        for (by_x, by_y), share in shares.items():
            if m >= by_x and n >= by_y:
                factor = math.perm(m, by_x) * math.perm(n, by_y)
                factors[:, terms.index((m - by_x, n - by_y)), column] += factor * np.array(share)
    return factors


def worn_share(pace: ArrayLike, elapsed: ArrayLike) -> Rows:
    """Return how much of the wear is done, 0 to 1, and its derivatives (n, k) by the logarithms
    of the pace.

    The wear of a stretch is the exponential of its logarithm over the sum of all; within a stretch
    the pace is even. pace : (k,), of k equal stretches; elapsed : (n,), shares of the data.

    >>> worn_share([0.0, 0.0], [0.25, 1.0])[0].tolist()
    [0.25, 1.0]
    """
    worn = np.exp(np.asarray(pace, dtype=float))
    worn /= worn.sum()
    stretches = np.arange(worn.size)
    done = np.clip(worn.size * np.asarray(elapsed)[:, np.newaxis] - stretches, 0.0, 1.0)
    share = done @ worn
    return share, worn * (done - share[:, np.newaxis])


def floor_field(values: Values) -> FloorField | None:
    """Return how values by name let a floor's shape vary with the place, kPa; None where they do
    not.
    """
    heights = np.array([values.get(name, 0.0) for name in FIELD_NAMES])
    if not heights.any():
        return None
    return FloorField(tuple(map(tuple, (field_factors() @ heights).tolist())), FIELD_REACH)


@dataclass(frozen=True)
class SurfaceParameters:
    """Values of the unknowns of a surface, rod and ring; `SURFACE` describes each.

    Parameters
    ----------
    friction_scale : float, optional
        Log sqrt(mu_a mu_b).
    ellipticity_x, ellipticity_y : float, default 0.0
        log(mu_a/mu_b) (cos 2 phi, sin 2 phi).
    offset_x, offset_y : float, default 0.0
        R(phi)(m0, n0) / sqrt(mu_a mu_b), world frame.
    floor_dome : float, default 0.0
        Dome of the floor, kPa at 50 mm.
    floor_bow_x, floor_bow_y : float, default 0.0
        Bow of the floor times cos and sin of twice its axis, world frame, kPa at 50 mm.
    pusher_friction : float, optional
        Coefficient of friction of rod and object.
    plate_dome : float, default 0.0
        Dome of the plate, kPa at 50 mm.
    plate_warp_x, plate_warp_y : float, default 0.0
        Bow of the plate times cos and sin of twice its axis, its own frame, kPa at 50 mm.
    pin_friction_radius : float, default 0.0
        Radius of the friction circle of the rod in the ring, m.

    Raises
    ------
    InvalidInput
        For a value that is not finite or beyond its bounds.

    Examples
    --------
    >>> from cyclemap import EllipseFriction
    >>> from cyclemap.evidence import SurfaceParameters
    >>> surface = SurfaceParameters.from_friction(EllipseFriction(0.3, 0.2, phi=0.5))
    >>> round(surface.to_friction().mu_a, 12), round(surface.to_friction().phi, 12)
    (0.3, 0.5)
    """

    friction_scale: float = math.log(0.25)
    ellipticity_x: float = 0.0
    ellipticity_y: float = 0.0
    offset_x: float = 0.0
    offset_y: float = 0.0
    floor_dome: float = 0.0
    floor_bow_x: float = 0.0
    floor_bow_y: float = 0.0
    pusher_friction: float = Pusher().friction
    plate_dome: float = 0.0
    plate_warp_x: float = 0.0
    plate_warp_y: float = 0.0
    pin_friction_radius: float = 0.0

    def __post_init__(self) -> None:
        for row in SURFACE.parameters:
            value = finite_number(row.name, getattr(self, row.name))
            object.__setattr__(self, row.name, value)
            if not row.lower <= value <= row.upper:
                raise InvalidInput(
                    f"{row.name} is {value}: it must lie between {row.lower} and {row.upper}"
                )

    @classmethod
    def from_values(cls, values: Values) -> SurfaceParameters:
        """Return the surface of values by name; other names are left alone, missing ones take their
        nominal value.
        """
        return cls(**{name: values[name] for name in SURFACE.names if name in values})

    @classmethod
    def from_friction(cls, friction: EllipseFriction, **others: float) -> SurfaceParameters:
        """Return the surface of a friction ellipse, with `others`
        (pusher_friction, ...) as given."""
        for name in others:
            if name not in SURFACE.names[5:]:
                raise unknown_name("parameter besides friction", name, SURFACE.names[5:])
        scale = 0.5 * math.log(friction.mu_a * friction.mu_b)
        offset_x, offset_y, half_x, half_y = Anisotropy.of(friction).seen_from(0.0).tolist()
        return cls(scale, 2.0 * half_x, 2.0 * half_y, offset_x, offset_y, **others)

    def values(self) -> dict[str, float]:
        """Return the values by name."""
        return asdict(self)

    def to_friction(self) -> EllipseFriction:
        """Return the friction ellipse, mu_a >= mu_b, phi within (-pi/2, pi/2].

        Raises InvalidInput where the offset leaves the ellipse, so that some direction of sliding
        would gain energy.
        """
        ratio, phi = self._ellipse()
        mean = math.exp(self.friction_scale)
        c = math.cos(phi)
        k = math.sin(phi)
        m0 = c * self.offset_x + k * self.offset_y
        n0 = -k * self.offset_x + c * self.offset_y
        return EllipseFriction(
            mean * math.exp(ratio / 2.0), mean * math.exp(-ratio / 2.0), mean * m0, mean * n0, phi
        )

    @property
    def floor(self) -> SurfaceShape:
        """The shape of the floor, kPa at 50 mm."""
        return SurfaceShape.of_bend(self.floor_dome, self.floor_bow_x, self.floor_bow_y)

    @property
    def plate(self) -> SurfaceShape:
        """The shape of the plate, kPa at 50 mm."""
        return SurfaceShape.of_bend(self.plate_dome, self.plate_warp_x, self.plate_warp_y)

    def footprint(self, slider: Slider, field: FloorField | None = None) -> PressedFootprint:
        """Return how an object rests on the surface, in its own mean pressures; field : of the
        floor, kPa.
        """
        unit = 1.0 / mean_pressure(slider)
        return pressed_footprint(slider, self.plate, self.floor, field, unit)

    def chain(
        self, jacobian: Array, names: tuple[str, ...], parameters: tuple[str, ...] = SURFACE.names
    ) -> Array:
        """Turn derivatives by the mechanics' parameters into derivatives by these.

        Parameters
        ----------
        jacobian : ndarray, shape (..., j)
            Derivatives by the mechanics' parameters.
        names : tuple of str
            Of the j columns: of FRICTION_NAMES, or others of SURFACE, which pass through.
        parameters : tuple of str, optional
            k names, those that are wanted; what no column tells of has derivative zero.

        Returns
        -------
        ndarray, shape (..., k)
            Derivatives by these parameters.

        Notes
        -----
        Of a circle's phi, which has no meaning, the derivatives cancel with errors below 1e-6.
        """
        ratio, phi = self._ellipse()
        law = self.to_friction()
        mean = math.exp(self.friction_scale)
        # The derivative (k,) of each of the mechanics' parameters by SURFACE; that of phi has no
        # bound at a circle.
        double = np.array((math.cos(2 * phi), math.sin(2 * phi)))
        across = np.array((-math.sin(2 * phi), math.cos(2 * phi)))
        c = math.cos(phi)
        k = math.sin(phi)
        friction = np.zeros((5, len(SURFACE)))
        friction[:4, 0] = law.mu_a, law.mu_b, law.m0, law.n0
        friction[0, 1:3] = 0.5 * law.mu_a * double
        friction[1, 1:3] = -0.5 * law.mu_b * double
        friction[4, 1:3] = across / (2.0 * ratio)
        friction[2, 1:3] = law.n0 * friction[4, 1:3]
        friction[3, 1:3] = -law.m0 * friction[4, 1:3]
        friction[2:4, 3:5] = mean * np.array(((c, k), (-k, c)))
        by_all = np.vstack([np.eye(len(SURFACE)), friction])
        rows = [(*SURFACE.names, *FRICTION_NAMES).index(name) for name in names]
        columns = [SURFACE.names.index(name) for name in parameters]
        return np.asarray(jacobian @ by_all[np.ix_(rows, columns)])

    def _ellipse(self) -> tuple[float, float]:
        """Return log(mu_a/mu_b), never quite zero, and phi."""
        ratio = math.hypot(self.ellipticity_x, self.ellipticity_y)
        return max(ratio, ROUNDEST), 0.5 * math.atan2(self.ellipticity_y, self.ellipticity_x)


def owned_numbers(values: Values, names: tuple[str, ...]) -> dict[str, list[float]]:
    """Return the numbers that have these names, by their owner, in order of the owners; of what has
    no owner, under the empty. What is not told is 0.
    """
    numbers: dict[str, list[float]] = {}
    for name, value in values.items():
        plain, _, owner = name.partition("[")
        if plain in names:
            own = numbers.setdefault(owner.rstrip("]"), [0.0] * len(names))
            own[names.index(plain)] = value
    return dict(sorted(numbers.items()))


def owned_shapes(values: Values, names: tuple[str, ...]) -> dict[str, SurfaceShape]:
    """Return the shapes, kPa at 50 mm, that three names tell, by their owner; of what has no owner,
    under the empty.

    >>> owned_shapes({"plate_warp_x[hex]": 2.0, "offset_x": 0.1}, PLATE_NAMES)
    {'hex': SurfaceShape(dome=0.0, bow=2.0, axis=0.0)}
    """
    return {
        owner: SurfaceShape.of_bend(*numbers)
        for owner, numbers in owned_numbers(values, names).items()
    }


def starting_space(loop: CollectionLoop, start: Material | None = None) -> ParameterSpace:
    """Return the unknowns of a surface, what is neither free nor given having the loop's value.

    start : a material from which every search begins; its friction, and what was found with it,
        then also stand for what is not free.

    Raises InvalidInput for a footprint of points, which no block of data takes.

    >>> space = starting_space(CollectionLoop.mit("isotropic"))
    >>> space["pusher_friction"].nominal, space["floor_dome"].nominal
    (0.15, 0.0)
    """
    if isinstance(loop.footprint, PointFootprint):
        raise InvalidInput("identification takes the exact footprint: leave footprint=grid out")
    if isinstance(loop.footprint, PatchFootprint) and loop.footprint.even_share != 1.0:
        raise InvalidInput(
            "identification tells shapes of floor and plate, not shares of the load: leave "
            "these out"
        )
    if start is not None:
        loop = loop.with_material(start)
    pressed = loop.footprint
    unit = mean_pressure(loop.slider)
    floor, plate = (
        (pressed.floor, pressed.plate) if isinstance(pressed, PressedFootprint) else (FLAT, FLAT)
    )
    values = SurfaceParameters.from_friction(
        loop.material.friction,
        pusher_friction=loop.pusher.friction,
        pin_friction_radius=loop.reset.pin_friction_radius,
        **dict(zip(FLOOR_NAMES, (unit * floor.bend).tolist(), strict=True)),
        **dict(zip(PLATE_NAMES, (unit * plate.bend).tolist(), strict=True)),
    ).values()
    space = ParameterSpace(
        tuple(replace(row, nominal=values[row.name]) for row in SURFACE.parameters)
    )
    if start is None:
        return space
    # A search begins at the value, or a little inside the bound that it lies on.
    margin = 0.01 * (space.upper - space.lower)
    inside = np.clip(space.vector(values), space.lower + margin, space.upper - margin).tolist()
    return ParameterSpace(
        tuple(replace(row, start=at) for row, at in zip(space.parameters, inside, strict=True))
    )
