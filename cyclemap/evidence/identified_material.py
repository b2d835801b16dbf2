"""What follows from an identification: axes and directions with intervals, what is drawn, and a
material.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import asked_by
from cyclemap.evidence.identification.identify import Identification, NamedInterval
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PACE_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
    Values,
    floor_field,
    owned_numbers,
    owned_shapes,
    worn_share,
)
from cyclemap.evidence.identified_words import misfit_words, provenance_words
from cyclemap.evidence.laws.linear_fit import student_quantile
from cyclemap.mechanics import (
    EllipseFriction,
    FoundWith,
    FrameShift,
    Material,
    MaterialPosterior,
    PlatePressure,
    SurfaceShape,
    Wear,
)
from cyclemap.mechanics.foundation import FLAT
from cyclemap.mechanics.material import (
    FLOOR_SHAPE_KEYS,
    FOUND_KEYS,
    PLATE_SHAPE_KEYS,
    FloorSession,
    friction_numbers,
    shape_numbers,
)

T = TypeVar("T")

DRAWS = 2000
# A direction whose draws spread over more than this share of their circle is not known.
_ALL_AROUND = 0.9
_AROUND = np.linspace(0.0, TWO_PI, 181)
_BAND_DRAWS = 200
POSTERIOR_SAMPLES = 200
_TIP_NAMES = ("tip_offset_x", "tip_offset_y")


@dataclass(frozen=True)
class Derived(NamedInterval):
    """What follows from identified parameters; see `NamedInterval`.

    known : whether the data tell it; a direction that may be any is not.
    """

    known: bool = True


# Names, what they are, of which parameters (by their beginning), unit, period of an angle, least
# value, and how.
_QUANTITIES: tuple[
    tuple[str, str, str, str, float, float, Callable[[SurfaceParameters], float]], ...
] = (
    (
        "axis_ratio",
        "longer over shorter axis of the friction ellipse",
        "ellipticity",
        "1",
        0.0,
        1.0,
        lambda at: at.to_friction().mu_a / at.to_friction().mu_b,
    ),
    (
        "axis_direction",
        "direction of the longer axis",
        "ellipticity",
        "rad",
        math.pi,
        0.0,
        lambda at: at.to_friction().phi,
    ),
    (
        "offset_size",
        "distance of the ellipse's centre from zero, over its mean radius",
        "offset",
        "1",
        0.0,
        0.0,
        lambda at: math.hypot(at.offset_x, at.offset_y),
    ),
    (
        "offset_direction",
        "direction of the ellipse's centre",
        "offset",
        "rad",
        TWO_PI,
        0.0,
        lambda at: math.atan2(at.offset_y, at.offset_x),
    ),
    (
        "mean_friction",
        "mean friction coefficient",
        "friction_scale",
        "1",
        0.0,
        0.0,
        lambda at: math.exp(at.friction_scale),
    ),
    (
        "floor_bow",
        "how the floor bends one way along its axis, the other across, at 50 mm",
        "floor_bow",
        "kPa",
        0.0,
        0.0,
        lambda at: at.floor.bow,
    ),
    (
        "floor_axis",
        "direction along which the floor bends upwards",
        "floor_bow",
        "rad",
        math.pi,
        0.0,
        lambda at: at.floor.axis,
    ),
)


def sampled_values(
    identified: Identification, count: int = DRAWS, seed: int = 0
) -> tuple[dict[str, float], ...]:
    """Return values of all parameters drawn from the uncertainty of an identification, each a
    possible truth.

    Parameters are normal with the fit's covariance, each spread so that its interval is Student's,
    and cut at their bounds; what the data leave wholly open stays at its value. Draws that are no
    friction ellipse are left out.
    """
    whole_number("draws", count, least=1)
    errors = identified.uncertainty
    space = identified.problem.space
    spread = np.array(
        [student_quantile(identified.level, float(freedom)) for freedom in errors.freedom]
    )
    spread /= student_quantile(identified.level, 1e9)
    size = np.sqrt(np.maximum(np.diag(errors.covariance), 0.0))
    squares, vectors = np.linalg.eigh(errors.correlation)
    root = vectors * np.sqrt(np.maximum(squares, 0.0))
    draws = np.random.default_rng(seed).standard_normal((count, len(space))) @ root.T
    drawn = []
    for vector in np.clip(identified.fit.vector + draws * size * spread, space.lower, space.upper):
        values = identified.problem.values(vector)
        with suppress(InvalidInput):
            for surface in (SurfaceParameters.from_values(values), worn_surface(values)):
                if surface is not None:
                    surface.to_friction()
            drawn.append(values)
    return tuple(drawn)


def derived_quantities(
    identified: Identification, draws: int = DRAWS, seed: int = 0
) -> tuple[Derived, ...]:
    """Return directions and sizes of friction ellipse and floor's bow as far as their parameters
    are free.

    Intervals hold the middle share `identified.level` of sampled surfaces. Where a vector
    (ellipticity, offset, bow) may be zero by Hotelling's test, its direction is not known and its
    size has its least value, 1 or 0, for a lower end: drawn vectors never are zero.
    """
    drawn = [
        SurfaceParameters.from_values(draw) for draw in sampled_values(identified, draws, seed)
    ]
    free = identified.problem.space.names
    best = SurfaceParameters.from_values(identified.values)
    ends = (0.5 - identified.level / 2.0, 0.5 + identified.level / 2.0)
    derived = []
    for name, description, of, unit, period, least, quantity in _QUANTITIES:
        parameters = [parameter for parameter in SURFACE.names if parameter.startswith(of)]
        if not drawn or not {*free} >= {*parameters}:
            continue
        value = quantity(best)
        off = np.array([quantity(surface) for surface in drawn]) - value
        vanishes = len(parameters) == 2 and _may_vanish(identified, [*map(free.index, parameters)])
        if period:
            off = (off + 0.5 * period) % period - 0.5 * period
        lower, upper = (value + np.quantile(off, ends)).tolist()
        known = True
        if period:
            known = upper - lower < _ALL_AROUND * identified.level * period and not vanishes
        else:
            lower = least if vanishes else min(lower, value)
            upper = max(upper, value)
        derived.append(Derived(name, description, unit, value, lower, upper, known))
    return tuple(derived)


def _may_vanish(identified: Identification, index: list[int]) -> bool:
    """Whether the vector of two parameters is within its error of zero: T^2 against
    F(2, freedom)."""
    from scipy.stats import f

    vector = identified.fit.vector[index]
    errors = identified.uncertainty
    covariance = errors.covariance[np.ix_(index, index)]
    if not np.all(np.isfinite(errors.standard_error[index])) or np.linalg.det(covariance) <= 0.0:
        return True
    size = float(vector @ np.linalg.solve(covariance, vector)) / 2.0
    return bool(size < f.ppf(identified.level, 2, float(np.min(errors.freedom[index]))))


@dataclass(frozen=True, eq=False)
class StrokeFit:
    """Turns of strokes of one block, (n,) rad; errors (n, 2), m, of where pushes ended, None of
    drags.
    """

    name: str
    measured: Array
    predicted: Array
    errors: Array | None


@dataclass(frozen=True, eq=False)
class CycleFit:
    """Cycles: orientation and turn measured (n,), rad; the fitted map's turn over `grid` (k,), and
    late in the wear.
    """

    name: str
    theta: Array
    turn: Array
    grid: Array
    fitted: Array
    late: Array | None


@dataclass(frozen=True, eq=False)
class IdentifiedCurves:
    """Tractions: the ellipse (m, 2), its worn state or None, sampled ones (d, m, 2), forces (s, 2)
    of scans or None.

    sized : whether the data tell the size of the ellipse, and not its shape alone.
    """

    ellipse: Array
    worn: Array | None
    samples: Array
    forces: Array | None
    sized: bool
    strokes: tuple[StrokeFit, ...]
    cycles: tuple[CycleFit, ...]


def identified_curves(
    identified: Identification, scans: Array | None = None, seed: int = 0
) -> IdentifiedCurves:
    """Compute what is drawn of an identification; `scans` : (s, 2) tractions
    of its friction scans."""
    worn = worn_surface(identified.values)
    samples = []
    for values in sampled_values(identified, _BAND_DRAWS, seed):
        samples.append(_outline(SurfaceParameters.from_values(values).to_friction()))
    strokes = []
    cycles = []
    for index, block in enumerate(identified.problem.blocks):
        if block.motions is None:
            continue
        theta, turn = block.motions.T
        if block.curve is None:
            # Each stroke's last row is its turn, those before its place.
            errors = identified.fit.residuals[identified.problem.block_index == index]
            *place, off = errors.reshape(turn.size, -1).T
            ends = np.stack(place, -1) if place else None
            strokes.append(StrokeFit(block.name, turn, turn + off, ends))
        else:
            values = block.own_values(identified.values)
            wears = any(name.startswith("worn_") for name in block.parameters)
            late = block.curve(values, _AROUND, True) if wears else None
            fitted = block.curve(values, _AROUND, False)
            cycles.append(CycleFit(block.name, theta, turn, _AROUND, fitted, late))
    return IdentifiedCurves(
        _outline(identified.friction()),
        None if worn is None else _outline(worn.to_friction()),
        np.reshape(samples, (-1, _AROUND.size, 2)),
        scans,
        "friction_scale" in identified.problem.space.names,
        tuple(strokes),
        tuple(cycles),
    )


def worn_surface(values: Values) -> SurfaceParameters | None:
    """Return the surface at the end of data that were let wear, by the values of all parameters;
    else None.
    """
    worn = {}
    for name, value in values.items():
        if name.startswith("worn_"):
            worn[name.removeprefix("worn_")] = value
    return SurfaceParameters.from_values({**values, **worn}) if worn else None


def _worn_floor(identified: Identification, worn: SurfaceShape) -> SurfaceShape:
    """Return the floor's mean shape, changed as the session of the cycles was changed by wear."""
    for block in identified.problem.blocks:
        for session, fresh in identified.floors.items():
            if {PACE_NAMES[0], f"floor_dome[{session}]"} <= {*block.parameters}:
                bend = identified.floors[""].bend + worn.bend - fresh.bend
                return SurfaceShape.of_bend(*bend.tolist())
    return worn


def _wear(identified: Identification, last_cycle: float) -> Wear | None:
    """How the surface wears until the last cycle, where the data were let tell it."""
    values = identified.values
    worn = worn_surface(values)
    if worn is None or last_cycle <= 0.0:
        return None
    pace = [values[name] for name in PACE_NAMES if name in values]
    elapsed = np.arange(1, len(pace)) / max(len(pace), 1)
    shares = worn_share(pace, elapsed)[0]
    course = tuple(zip((last_cycle * elapsed).tolist(), shares.tolist(), strict=True))
    return Wear(worn.to_friction(), last_cycle, course, _worn_floor(identified, worn.floor))


def _outline(law: EllipseFriction) -> Array:
    """Traction (m, 2) over all directions of sliding, world axes."""
    return law.traction(np.stack([np.cos(_AROUND), np.sin(_AROUND)], axis=-1))


def identified_material(
    identified: Identification,
    name: str,
    sources: Sequence[str] = (),
    last_cycle: float = 0.0,
    plate: str = "rect1",
    floor: Material | None = None,
) -> Material:
    """Return what was identified as a material, marked as inferred.

    Parameters
    ----------
    identified : Identification
        What was identified.
    name : str
        That of the material, not empty.
    sources : sequence of str, default ()
        What the data were, for the provenance.
    last_cycle : float, default 0.0
        The number of cycles behind the first after which a surface that wears is the worn one.
    plate : str, default 'rect1'
        The object whose shape was identified, where it is one alone.
    floor : Material or None, optional
        What was known of it, whose plates, sessions and frames are kept, but for shares of the
        load, which belong to flat floors; None: nothing.

    Returns
    -------
    Material
        With samples of its posterior, which are of new sessions; what the data do not depend on
        is left open in `found_with`.

    Raises
    ------
    InvalidInput
        For an empty name.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import friction_ellipse_from_scans, identified_material
    >>> direction, along = np.linspace(0.0, 6.0, 12), 2.0 + np.zeros(12)
    >>> scans = {"direction": direction, "force_along": along, "force_across": 0.0 * along}
    >>> slate = identified_material(friction_ellipse_from_scans(scans, 8.0), "slate", ["scans.csv"])
    >>> slate.name, slate.inferred, round(slate.friction.mu_a, 5)
    ('slate', True, 0.25)
    """
    if not name.strip():
        raise InvalidInput("a material needs a name")
    values = identified.values
    asked = asked_by(identified.problem.blocks)
    rod_and_ring = {row.name: values[row.name] for row in fields(FoundWith) if row.name in asked}
    floors = identified.floors
    before = Material(name, identified.friction()) if floor is None else floor
    plates = [
        PlatePressure(owner or plate, shape=shape) for owner, shape in identified.plates.items()
    ]
    sessions = [FloorSession(session, shape) for session, shape in floors.items() if session]
    shifts = owned_numbers(values, _TIP_NAMES)
    frames = [FrameShift(owner or plate, *shift) for owner, shift in shifts.items()]
    kept = [known for known in before.plates if not any(known.shares.values())]
    material = Material(
        name,
        identified.friction(),
        provenance_words(identified, sources),
        misfit_words(identified),
        inferred=True,
        found_with=replace(before.found_with, **rod_and_ring),
        plates=_joined(kept, plates, "plate"),
        wear=_wear(identified, last_cycle),
        frames=_joined(before.frames, frames, "plate"),
        noise=before.noise,
        floor=floors.get("", FLAT),
        sessions=_joined(before.sessions, sessions, "name"),
        session_spread=identified.session_spread,
        field=floor_field(values),
    )
    return replace(material, posterior=_posterior(identified, material, plate, before.posterior))


def _joined(before: Sequence[T], new: Sequence[T], key: str) -> tuple[T, ...]:
    """What was known, each of a name of its own, then what is new, which takes the place of what
    has its name.
    """
    names = {getattr(row, key) for row in new}
    return (*(row for row in before if getattr(row, key) not in names), *new)


def _posterior(
    identified: Identification, material: Material, plate: str, before: MaterialPosterior | None
) -> MaterialPosterior | None:
    """Samples of what the data allow in a new session, in the names and units of a material file.

    before : samples of what was known; those of plates that the data are not of stay.
    """
    rows = list[dict[str, float]]()
    rng = np.random.default_rng(0)
    for index, values in enumerate(sampled_values(identified, POSTERIOR_SAMPLES)):
        row = friction_numbers(SurfaceParameters.from_values(values).to_friction())
        worn = worn_surface(values)
        # Sessions of the posterior are new ones: they differ from the mean by the spread.
        off = rng.standard_normal(3) * identified.session_spread
        floors = owned_shapes(values, FLOOR_NAMES)
        if "" in floors:
            row |= shape_numbers(SurfaceShape.of_bend(*(floors[""].bend + off)), FLOOR_SHAPE_KEYS)
        if material.wear is not None and worn is not None:
            shape = SurfaceShape.of_bend(*(worn.floor.bend + off))
            late = friction_numbers(worn.to_friction()) | shape_numbers(shape, FLOOR_SHAPE_KEYS)
            row |= {f"worn.{key}": value for key, value in late.items()}
        for key, (name, unit) in FOUND_KEYS.items():
            if name in values and getattr(material.found_with, name) is not None:
                row[key] = values[name] / unit
        for owner, shape in owned_shapes(values, PLATE_NAMES).items():
            for key, size in shape_numbers(shape, PLATE_SHAPE_KEYS).items():
                row[f"{owner or plate}.{key}"] = size
        if before is not None:
            known = zip(before.parameters, before.samples[index % len(before)], strict=True)
            kept = {
                key: value
                for key, value in known
                if key in FOUND_KEYS or material.pressure_of(key.partition(".")[0])
            }
            row = kept | row
        rows.append(row)
    rounded = tuple(tuple(float(f"{value:.6g}") for value in row.values()) for row in rows)
    return MaterialPosterior(tuple(rows[0]), rounded) if len(rows) > 1 else None
