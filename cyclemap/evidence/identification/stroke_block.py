"""Blocks of data whose prediction is the mechanics of strokes: push end points, drag-backs, and
whole cycles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import lagrange

from cyclemap.arrays import Array, Place, even_angles
from cyclemap.checks import finite_array
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, Function, Labels
from cyclemap.evidence.identification.surface_parameters import (
    FIELD,
    FLOOR_NAMES,
    FRICTION_NAMES,
    PACE_NAMES,
    PLATE_NAMES,
    SURFACE,
    Parameter,
    Rows,
    SurfaceParameters,
    Values,
    floor_field,
    worn_share,
)
from cyclemap.evidence.predicted_strokes import (
    DRAG_NAMES,
    PUSH_NAMES,
    StrokeEnds,
    in_kpa,
    predicted_drag_ends,
    predicted_push_ends,
)
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS
from cyclemap.evidence.pushes.measured_strokes import ROD_OFF, MeasuredDrag, MeasuredPush
from cyclemap.mechanics import FoundWith, Material, Pusher, QuasiStaticModel, Slider
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleBatch, run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS
from cyclemap.mechanics.foundation import FloorField

# Radians (extents) asked of a stroke: measured pushes come out within 1e-3 mm and .003 degrees of
# exact ones.
ACCURACY = 1e-3
# What tells by how much strokes, and cycles, are off at that, and what data of less noise ask for.
_REFINED = (1e-6, 1e-9)
_REFINED_CYCLES = 1e-9
TIP_OFFSET = tuple(
    Parameter(
        f"tip_offset_{axis}",
        f"shift of the robot's frame against the camera's, along {axis}",
        *("m", -0.01, 0.01, 0.0, 1e-3),
    )
    for axis in "xy"
)
# What wears of a surface comes first.
WORN = (*SURFACE.names[1:5], *FLOOR_NAMES)
CYCLE_UNKNOWNS = (*WORN, *PLATE_NAMES, "pusher_friction", "pin_friction_radius")
_WORN_PARAMETERS = tuple(
    replace(
        SURFACE[name],
        name=f"worn_{name}",
        description=f"{SURFACE[name].description}, at the end of the data",
    )
    for name in WORN
)
_PACE_PARAMETERS = tuple(
    Parameter(
        name,
        f"logarithm of the pace of wear in stretch {stretch} of {len(PACE_NAMES)} of the data",
        *("", -8.0, 8.0, 0.0, 0.1),
    )
    for stretch, name in enumerate(PACE_NAMES, start=1)
)
# Turns on a surface that wears are computed at these shares of the wear, and a polynomial between.
_WEAR_NODES = (0.0, 0.15, 0.5, 0.85, 1.0)
# Sectors of θ0, how many cycles tell the noise of some of them, and from how many on it is asked.
_SECTOR_DEG, _FEWEST_PASSES, _MANY_CYCLES = 20, 25, 200
# Cycles are computed at this many angles and interpolated between by a Fourier series.
NODES = 47
_REFINED_NODES = 95
CYCLE_ACCURACY = 1e-6


def push_end_block(
    pushes: Sequence[MeasuredPush],
    slider: Slider,
    target: Place | None = None,
    first_set: int | None = None,
    rod_radius: float = MIT_ROD_RADIUS,
) -> DataBlock:
    """Return the block of where pushes ended.

    Parameters
    ----------
    pushes : sequence of MeasuredPush
        The pushes.
    slider : Slider
        The object.
    target : tuple[float, float] or None, optional
        (x, y), m, where resets end: how the floor's shape varies with the place about it is
        then an unknown, too.
    first_set : int or None, optional
        Where rods were set by marks on the object, the number of the first push; each is then
        off its mark by itself, and its object turned from what was read, so that so much of what
        it did is its own: `rod_off_x[push 7]` of the seventh.
    rod_radius : float, optional
        m.

    Returns
    -------
    DataBlock
        Place (m) and orientation (rad), grouped by contact.

    Notes
    -----
    Its own unknowns are `tip_offset_x`, `tip_offset_y`: what to add to the robot's places to have
    them in the frame of the object's poses.

    Examples
    --------
    >>> from cyclemap import Pose, Slider
    >>> from cyclemap.evidence import MeasuredPush, push_end_block
    >>> push = MeasuredPush(Pose(), Pose(0.0, -0.03, 0.2), (0.0, 0.05), (0.0, 0.01))
    >>> block = push_end_block([push], Slider.mit("rect1"))
    >>> sorted(set(block.kinds.tolist()))
    ['push place (m)', 'push turn (rad)']
    """
    unknown = TIP_OFFSET if first_set is None else set_ups(first_set, len(pushes))
    # Which of the unknowns a push has, along x, along y, and, where it is its own, of its turn.
    width = 2 if first_set is None else 3
    own = np.broadcast_to(np.arange(len(unknown)).reshape(-1, width), (len(pushes), width))

    def ends(model: QuasiStaticModel, chosen: Labels, values: Values) -> StrokeEnds:
        columns = own[chosen]
        off = np.zeros((chosen.size, 3))
        off[:, :width] = np.array([values[row.name] for row in unknown])[columns]
        strokes = [pushes[index] for index in chosen.tolist()]
        moved, by, stayed = predicted_push_ends(
            model, strokes, off[:, :2], PUSH_NAMES, target, off[:, 2]
        )
        by_off = np.zeros((chosen.size, 3, len(unknown)))
        np.put_along_axis(by_off, columns[:, None], by[..., -3:][..., :width], axis=-1)
        return moved, np.concatenate([by[..., :-3], by_off], axis=-1), stayed

    kinds = ("push place (m)", "push place (m)", "push turn (rad)")
    parameters = (*(() if target is None else FIELD), *unknown)
    return _stroke_block(
        "push ends", pushes, slider, ends, kinds, PUSH_NAMES, parameters, rod_radius
    )


def set_ups(first: int, count: int) -> tuple[Parameter, ...]:
    """Return what is unknown of pushes that were set up by hand, from push number ``first`` on: how
    far each rod was off its mark, x and y, and how each object lay turned, in turn.
    """
    parameters = list[Parameter]()
    for index in range(first, first + count):
        push = f"push {index}"
        for axis in "xy":
            words = f"how far the rod of {push} was set off its mark, along {axis}"
            name = f"{ROD_OFF}{axis}[{push}]"
            parameters.append(Parameter(name, words, "m", -0.02, 0.02, 0.0, 1e-3))
        words = f"by how much the object of {push} lay turned from what was read"
        name = f"{ROD_OFF}turn[{push}]"
        parameters.append(Parameter(name, words, "rad", -0.2, 0.2, 0.0, 1e-2))
    return tuple(parameters)


def drag_turn_block(
    drags: Sequence[MeasuredDrag], slider: Slider, target: Place | None = None
) -> DataBlock:
    """Return the block of how far drags turned the object, each ring going straight to where it
    ended.

    Parameters
    ----------
    drags : sequence of MeasuredDrag
        The drags.
    slider : Slider
        The object.
    target : tuple[float, float] or None, optional
        As of `push_end_block`.

    Returns
    -------
    DataBlock
        Turns, rad.

    Examples
    --------
    >>> from cyclemap import Pose, Slider
    >>> from cyclemap.evidence import MeasuredDrag, drag_turn_block
    >>> block = drag_turn_block([MeasuredDrag(Pose(), Pose(0.05, 0.0, -0.4))], Slider.mit("rect1"))
    >>> block.kinds.tolist(), block.groups.tolist()
    (['drag turn (rad)'], [0])
    """

    def ends(model: QuasiStaticModel, chosen: Labels, values: Values) -> StrokeEnds:
        strokes = [drags[index] for index in chosen.tolist()]
        return predicted_drag_ends(model, strokes, values["pin_friction_radius"], target)

    own = () if target is None else FIELD
    kinds = ("drag turn (rad)",)
    return _stroke_block("drag-backs", drags, slider, ends, kinds, DRAG_NAMES, own)


def _stroke_block(
    name: str,
    strokes: Sequence[MeasuredPush] | Sequence[MeasuredDrag],
    slider: Slider,
    ends: Callable[[QuasiStaticModel, Labels, Values], StrokeEnds],
    kinds: tuple[str, ...],
    names: tuple[str, ...],
    own_parameters: tuple[Parameter, ...],
    rod_radius: float = MIT_ROD_RADIUS,
) -> DataBlock:
    """The block of strokes of an object; strokes of one contact are a group.

    ends : model, indices of strokes, values -> where they end.
    kinds : noise of what is measured of a pose, its place and its orientation, or the latter alone.
    names : parameters of the mechanics, the friction law's first, by which these ends are
        differentiated before the own ones.
    """
    if not strokes:
        raise InvalidInput(f"block {name!r} has no strokes: give some")
    count = len(kinds)
    # The motion does not depend on the mean friction.
    unknowns = (*SURFACE.names[1:5], *names[len(FRICTION_NAMES) :])
    parameters = (*unknowns, *(parameter.name for parameter in own_parameters))
    measured = np.array([(stroke.end.x, stroke.end.y, stroke.end.theta) for stroke in strokes])

    def misfit(chosen: Labels, values: Values, accuracy: float = ACCURACY) -> StrokeEnds:
        surface = SurfaceParameters.from_values(values)
        field = floor_field(values)
        model = surface_model(surface, slider, accuracy, field, rod_radius)
        predicted, by, stayed = ends(model, chosen, values)
        by_surface = surface.chain(by[..., : len(names)], names, unknowns)
        jacobian = np.concatenate([by_surface, by[..., len(names) :]], axis=-1)
        return (predicted - measured[chosen])[:, -count:], jacobian[:, -count:], stayed

    def part(chosen: Labels, accuracy: float = ACCURACY) -> Function:
        indices = chosen[::count] // count

        def function(values: Values) -> Rows:
            residual, jacobian, _ = misfit(indices, values, accuracy)
            return residual.ravel(), jacobian.reshape(residual.size, len(parameters))

        return function

    rows = np.arange(count * len(strokes))
    turned = [(stroke.start.theta, stroke.end.theta - stroke.start.theta) for stroke in strokes]
    groups = np.repeat([stroke.contact for stroke in strokes], count)
    return DataBlock(
        name,
        parameters,
        part(rows),
        groups,
        np.tile(kinds, len(strokes)),
        own_parameters,
        part,
        np.array(turned),
        stayed=lambda values: int(np.sum(misfit(np.arange(len(strokes)), values)[2])),
        refined=tuple(part(rows, accuracy) for accuracy in _REFINED),
    )


def surface_model(
    surface: SurfaceParameters,
    slider: Slider,
    accuracy: float = ACCURACY,
    field: FloorField | None = None,
    rod_radius: float = MIT_ROD_RADIUS,
) -> QuasiStaticModel:
    """Return the model of a slider on a surface, of the shapes that the surface says; field : of
    the floor, kPa.
    """
    rod = Pusher(rod_radius, surface.pusher_friction)
    return QuasiStaticModel(
        slider, surface.to_friction(), rod, surface.footprint(slider, field), accuracy
    )


def interpolation(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the Fourier series through them
    at theta (n,), rad; count : odd.

    >>> nodes = 2 * np.pi * np.arange(5) / 5
    >>> bool(np.allclose(interpolation([0.3], 5) @ np.cos(2 * nodes), np.cos(0.6)))
    True
    """
    nodes = even_angles(count)
    off = finite_array("theta", theta, ndim=1)[:, np.newaxis] - nodes
    orders = np.arange(1, (count - 1) // 2 + 1, dtype=float)
    return np.asarray((1.0 + 2.0 * np.cos(off[..., np.newaxis] * orders).sum(axis=-1)) / count)


def cycle_pair_block(
    loop: CollectionLoop,
    theta: ArrayLike,
    turn: ArrayLike,
    groups: Labels,
    elapsed: ArrayLike | None = None,
) -> DataBlock:
    """Return the block of measured turns of whole cycles, set against the cycle map of a loop.

    Parameters
    ----------
    loop : CollectionLoop
        Who is pushed where, and how it is brought back; surface, rod, shapes and ring are the
        unknowns'. Its map must be smooth: it is a trigonometric polynomial through 47 cycles.
    theta : array_like, shape (n,)
        Orientation before a push, rad.
    turn : array_like, shape (n,)
        How far the cycle turned the object, rad.
    groups : array_like of int, shape (n,)
        Rows of one label share their errors.
    elapsed : array_like, shape (n,), optional
        How much of the data was made before each cycle, 0 to 1, where the surface wears: its turn
        is then blended between those of a fresh surface and of one as worn as at the end, whose
        ellipse and floor are `worn_...`. How fast it wears, stretch by stretch, is unknown, too
        (`wear_pace_...`).

    Returns
    -------
    DataBlock
        Turns, rad.

    Raises
    ------
    InvalidInput
        Where shapes differ or nothing is given.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import SurfaceParameters, cycle_pair_block
    >>> loop = CollectionLoop.mit("isotropic")
    >>> theta = np.linspace(0.0, 6.0, 4)
    >>> block = cycle_pair_block(loop, theta, loop.next_theta(theta) - theta, [0, 1, 2, 3])
    >>> bool(np.abs(block.residuals(SurfaceParameters().values())[0]).max() < 1e-6)
    True
    """
    angles = finite_array("theta", theta, ndim=1)
    measured = finite_array("turn", turn, ndim=1)
    if angles.size == 0 or measured.shape != angles.shape:
        raise InvalidInput(
            f"{angles.size} orientations and {measured.size} turns: give one turn for each, one at "
            "least"
        )
    own_parameters: tuple[Parameter, ...] = ()
    passed = None
    if elapsed is not None:
        own_parameters = (*_WORN_PARAMETERS, *_PACE_PARAMETERS)
        passed = finite_array("elapsed share of the data", elapsed, ndim=1)
        if passed.shape != angles.shape or passed.min() < 0.0 or passed.max() > 1.0:
            raise InvalidInput("elapsed must be a share of the data, 0 to 1, for each cycle")
    cycles = _CycleTurns(loop, angles, measured, passed)
    refined = replace(cycles, nodes=_REFINED_NODES, accuracy=_REFINED_CYCLES)
    return DataBlock(
        "cycles",
        (*CYCLE_UNKNOWNS, *(parameter.name for parameter in own_parameters)),
        cycles.residuals,
        groups,
        _cycle_kinds(angles),
        own_parameters,
        motions=np.column_stack([angles, measured]),
        curve=cycles.curve,
        refined=(refined.residuals,),
    )


@dataclass(frozen=True, eq=False)
class _CycleTurns:
    """Turns (n,) of cycles, rad, measured and as a Fourier series through computed ones; where the
    surface wears these are computed at _WEAR_NODES, with a polynomial between.

    theta : (n,), orientations before the cycles, rad.
    elapsed : (n,), shares of the data made before; None where nothing wears.
    nodes, accuracy : how many cycles are computed, and how closely, extents.
    """

    loop: CollectionLoop
    theta: Array
    measured: Array
    elapsed: Array | None
    nodes: int = NODES
    accuracy: float = CYCLE_ACCURACY

    @cached_property
    def between(self) -> Array:
        """The matrix (n, nodes) from the nodes to the orientations of the cycles."""
        return interpolation(self.theta, self.nodes)

    def at_nodes(self, values: Values, worn: float = 0.0) -> Rows:
        """Return turns at the nodes on a surface as worn as that, and their derivatives by
        CYCLE_UNKNOWNS.
        """
        blended = {name: values[name] for name in CYCLE_UNKNOWNS}
        for name in WORN if worn else ():
            blended[name] = (1.0 - worn) * values[name] + worn * values[f"worn_{name}"]
        surface = SurfaceParameters.from_values(blended)
        places = even_angles(self.nodes)
        runs, by_unknowns = cycles_by_unknowns(surface, self.loop, places, self.accuracy)
        return runs.theta_next[0] - places, by_unknowns[:, CYCLE_OUTPUTS.index("theta_next")]

    def residuals(self, values: Values) -> Rows:
        """Return predicted less measured turns, and their derivatives by the unknowns."""
        if self.elapsed is None:
            turned, by_unknowns = self.at_nodes(values)
            return self.between @ turned - self.measured, self.between @ by_unknowns
        share, share_by_pace = worn_share([values[name] for name in PACE_NAMES], self.elapsed)
        blends = [lagrange(_WEAR_NODES, basis) for basis in np.eye(len(_WEAR_NODES))]
        predicted = np.zeros(share.size)
        by_share = np.zeros(share.size)
        by_fresh = np.zeros((share.size, len(CYCLE_UNKNOWNS)))
        by_worn = np.zeros((share.size, len(WORN)))
        for worn, blend in zip(_WEAR_NODES, blends, strict=True):
            turned, by_unknowns = self.at_nodes(values, worn)
            turns = self.between @ turned
            weight = blend(share)
            predicted += weight * turns
            by_share += blend.deriv()(share) * turns
            by_surface = weight[:, np.newaxis] * (self.between @ by_unknowns)
            by_worn += worn * by_surface[:, : len(WORN)]
            by_surface[:, : len(WORN)] *= 1.0 - worn
            by_fresh += by_surface
        by_pace = by_share[:, np.newaxis] * share_by_pace
        return predicted - self.measured, np.hstack([by_fresh, by_worn, by_pace])

    def curve(self, values: Values, around: Array, late: bool) -> Array:
        """Return turns at angles `around`, on the surface as fresh or as worn as can be."""
        return interpolation(around, self.nodes) @ self.at_nodes(values, float(late))[0]


def _cycle_kinds(theta: Array) -> NDArray[np.str_]:
    """Return the kind of error of each cycle (n,): where θ0 hardly moves, turns scatter by a tenth
    of what they do elsewhere, so that of many cycles those of neighbouring sectors have a noise of
    their own.
    """
    if theta.size < _MANY_CYCLES:
        return np.repeat("cycle turn (rad)", theta.size)
    sectors = (np.degrees(theta) % 360.0 // _SECTOR_DEG).astype(int)
    count = 360 // _SECTOR_DEG
    kinds = np.empty(theta.size, dtype="<U40")
    first = 0
    for last in range(1, count + 1):
        inside = (sectors >= first) & (sectors < last)
        behind = int(np.sum(sectors >= last))
        if np.sum(inside) >= _FEWEST_PASSES and (behind >= _FEWEST_PASSES or last == count):
            place = f"{first * _SECTOR_DEG} to {last * _SECTOR_DEG} deg"
            kinds[inside] = f"cycle turn at {place} (rad)"
            first = last
    return kinds


def cycles_by_unknowns(
    surface: SurfaceParameters,
    loop: CollectionLoop,
    theta: Array,
    accuracy: float = CYCLE_ACCURACY,
) -> tuple[CycleBatch, Array]:
    """Run cycles of the loop on an identified surface from theta (n,), rad; with d CYCLE_OUTPUTS /
    d CYCLE_UNKNOWNS.

    The batch has the shape (1, n), the derivatives (n, 6, k).
    """
    names = (*PUSH_NAMES, "pin_friction_radius")
    runs = run_batch((loop_on(surface, loop, accuracy),), theta[None], len(PARAMETERS))
    by_names = in_kpa(loop.slider, names, runs.jacobian[0])
    return runs, surface.chain(by_names, names, CYCLE_UNKNOWNS)


def loop_on(
    surface: SurfaceParameters, loop: CollectionLoop, accuracy: float = CYCLE_ACCURACY
) -> CollectionLoop:
    """Return the loop on an identified surface, with the rod, shapes and ring that were identified
    along with it.
    """
    rod_and_ring = FoundWith(surface.pusher_friction, surface.pin_friction_radius)
    material = Material("identified", surface.to_friction(), found_with=rod_and_ring)
    changed = replace(loop, accuracy=accuracy).with_material(material)
    return replace(changed, footprint=surface.footprint(loop.slider))
