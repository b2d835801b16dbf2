"""The data-collection loop: its cycles of one push and one drag back, as a map of the object's
orientation.
"""

from __future__ import annotations

import math
import reprlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, placed
from cyclemap.checks import finite_array, finite_number, positive_number, require_kind
from cyclemap.collection.adaptive_map import sample_circle_map
from cyclemap.collection.cycles import Cycles, CycleSensitivity, CycleTrajectory, StrokePair
from cyclemap.errors import DoubtfulInput, InvalidInput, unknown_name
from cyclemap.inline_svg import BLUE, CIRCLE, DISC, GREY, Stroke, inline_svg
from cyclemap.maps import CircleMap
from cyclemap.mechanics import (
    DragBack,
    DragResult,
    Footprint,
    Material,
    Pose,
    Pusher,
    PushResult,
    QuasiStaticModel,
    SidePush,
    Slider,
    Trajectory,
    load_material,
)
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.mechanics.cycle_batch import CycleSlopes, run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS
from cyclemap.mechanics.footprint import FOOTPRINTS
from cyclemap.mechanics.plate_footprint import plate_footprint
from cyclemap.progress import Progress

# What a map's error can be brought below, rad.
_LEAST_TOLERANCE = 1e-9
# Samples of a drawn push, and of each leg of a drawn drag.
_DRAWN = 60


@dataclass(frozen=True, eq=False)
class Cycle(StrokePair[PushResult, DragResult]):
    """One push and reset by the quasi-static model.

    Attributes
    ----------
    loop : CollectionLoop
        What was run.
    theta : float
        Orientation before, rad.
    push : PushResult
        The push.
    drag : DragResult
        The drag back.
    push_turn, drag_turn : float
        Turns of the object, rad.
    push_displacement : ndarray, shape (2,)
        Of the object's origin in its initial frame, m.
    drag_length : float
        Path of the ring, m.
    theta_next : float
        Orientation after, rad on the lift: theta + push_turn + drag_turn.
    ended : str
        Why the push ended, `distance`, or `left` where the rod lost the object.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop
    >>> cycle = CollectionLoop.mit("plywood").cycle(0.0)
    >>> (1e3 * cycle.push_displacement).round(2).tolist(), round(math.degrees(cycle.theta_next), 3)
    ([42.6, -66.68], 9.965)
    """

    loop: CollectionLoop

    def __reduce__(self) -> tuple[Any, ...]:
        # A copy is run anew: the strokes hold CasADi's buffers, which cannot leave their process.
        return self.loop.cycle, (self.theta,)

    @cached_property
    def trajectory(self) -> CycleTrajectory[Trajectory]:
        """The course of the cycle, run once more with steps short enough to be drawn."""
        push, drag = self.loop.strokes(self.theta, self.push.travel / _DRAWN or math.inf)
        return CycleTrajectory(push.trajectory, drag.trajectory)

    def _repr_html_(self) -> str:
        # A drag of no length has no course.
        courses = [self.push.trajectory]
        if self.drag_length > 0.0:
            courses = [self.trajectory.push, self.trajectory.drag]
        outline = self.loop.slider.outline_points()
        outlines = [
            Stroke(placed(courses[0].pose[0], outline)),
            Stroke(placed(courses[0].pose[-1], outline), BLUE),
            Stroke(placed(courses[-1].pose[-1], outline), GREY),
        ]
        rod = [Stroke(course.pusher, width=1.0) for course in courses]
        push, drag = (f"{math.degrees(turn):+.1f}°" for turn in (self.push_turn, self.drag_turn))
        caption = (
            f"from {math.degrees(self.theta):.1f}°: push {push} (blue), drag back {drag} "
            "(grey), the rod's way"
        )
        return inline_svg([*outlines, *rod], caption, 240, equal=True)


class SentByFields:
    """A dataclass that is sent to other processes as its fields: what was computed from them stays
    behind.
    """

    def __getstate__(self) -> dict[str, object]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class CollectionLoop(SentByFields):
    """The protocol of a data collection: who is pushed where, on what, and how it is brought back.

    Parameters
    ----------
    slider : Slider
        The object that is pushed.
    material : Material
        The surface under it.
    pusher : Pusher, optional
        The rod.
    push : SidePush, optional
        Where and how it is pushed.
    reset : DragBack, optional
        How it is brought back: the drag by the ring.
    footprint : Footprint or None, optional
        How the weight is spread; None: evenly over the outline, leaning where the centre of
        mass is not the centroid.
    accuracy : float, default 1e-8
        Error aimed at for a push or a drag, rad, as `QuasiStaticModel`'s.

    Raises
    ------
    InvalidInput
        For parts that are none.

    Notes
    -----
    Every cycle starts with the ring at the target, the world's origin: the state is the
    orientation theta alone.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop
    >>> loop = CollectionLoop.mit(material="plywood")
    >>> cycle = loop.cycle(0.0)
    >>> round(math.degrees(cycle.push_turn), 3), round(math.degrees(cycle.drag_turn), 3)
    (73.653, -63.688)
    """

    slider: Slider
    material: Material
    pusher: Pusher = Pusher()
    push: SidePush = SidePush()
    reset: DragBack = DragBack()
    footprint: Footprint | None = None
    accuracy: float = 1e-8

    def __post_init__(self) -> None:
        require_kind("slider", self.slider, Slider)
        require_kind("material", self.material, Material)
        require_kind("pusher", self.pusher, Pusher)
        require_kind("push", self.push, SidePush)
        require_kind("reset", self.reset, DragBack)
        require_kind("footprint", self.footprint, *FOOTPRINTS, NoneType)

    @classmethod
    def mit(cls, material: str | Path | Material = "plywood", **changes: Any) -> CollectionLoop:
        """Return the MIT repeated-push experiment, with fields replaced.

        Parameters
        ----------
        material : str or Path or Material, default 'plywood'
            A built-in name, a TOML file or a `Material`, which brings what was found with it
            (pusher friction, pressure of the plate, lever and friction of the ring).
        **changes : object
            Any field of the loop, which overrules it.

        Returns
        -------
        CollectionLoop
            The protocol of Yu et al. (2016) and Ma & Rodriguez (2018).
        """
        surface = material if isinstance(material, Material) else load_material(material)
        slider = changes.pop("slider", None) or Slider.mit("rect1")
        return replace(cls(slider, surface).with_material(surface), **changes)

    def with_material(self, material: Material) -> CollectionLoop:
        """Return the loop on a material, with all that is not None in its `found_with` and its
        plate's pressure.

        >>> from cyclemap import CollectionLoop, load_material
        >>> CollectionLoop.mit("plywood").with_material(load_material("isotropic")).material.name
        'isotropic'
        """
        require_kind("material", material, Material)
        known = material.found_with
        brought: dict[str, Any] = {"material": material}
        if known.pusher_friction is not None:
            brought["pusher"] = replace(self.pusher, friction=known.pusher_friction)
        if known.pin_friction_radius is not None:
            brought["reset"] = replace(self.reset, pin_friction_radius=known.pin_friction_radius)
        pressure = plate_footprint(material, self.slider)
        if pressure is not None:
            brought["footprint"] = pressure
        return replace(self, **brought)

    def _repr_html_(self) -> str:
        outline = self.slider.outline_points(200)
        start, way = first_contact(self.slider, self.push, self.pusher.radius)
        push = Stroke([start, start + 0.5 * self.slider.outline.extent * way])
        marks = [Stroke([start], BLUE, DISC, 4.0), Stroke([self.slider.hitch], BLUE, CIRCLE, 4.0)]
        caption = (
            f"{self.slider.name} on {self.material.name}, pushed "
            f"{1e3 * self.push.distance:.4g} mm by a rod of "
            f"{1e3 * self.pusher.radius:.4g} mm (disc), dragged back by its ring (circle)"
        )
        return inline_svg([Stroke(outline), push, *marks], caption, equal=True)

    @cached_property
    def model(self) -> QuasiStaticModel:
        """The mechanics of the loop. Raises InvalidInput where the parts do not fit each other."""
        return QuasiStaticModel(
            self.slider, self.material.friction, self.pusher, self.footprint, self.accuracy
        )

    def start_pose(self, theta: float) -> Pose:
        """Return the object's pose before the push, its ring at the target."""
        return self.model.start_pose(theta)

    def cycle(self, theta: float) -> Cycle:
        """Run one push and reset.

        Parameters
        ----------
        theta : float
            Orientation before, rad, any number of turns.

        Returns
        -------
        Cycle
            Turns, displacement, and the orientation after.

        Warns
        -----
        DoubtfulInput
            For whole numbers beyond a turn: they are likely degrees.
        """
        theta = finite_number("theta", theta)
        if abs(theta) > TWO_PI and theta.is_integer():
            doubt = (
                f"theta is {theta:g} rad, more than a turn: degrees are given as "
                f"math.radians({theta:g})"
            )
            warnings.warn(doubt, DoubtfulInput, stacklevel=2)
        return Cycle(theta, *self.strokes(theta), self)

    def cycles(self, theta: ArrayLike) -> Cycles:
        """Run one push and reset from each of many orientations (...), rad.

        >>> import numpy as np
        >>> from cyclemap import CollectionLoop
        >>> turns = CollectionLoop.mit().cycles([0.0, 1.0]).push_turn
        >>> np.degrees(turns).round(3)
        array([73.653, 73.927])
        """
        values = finite_array("theta", theta)
        return Cycles.of_batch(values, run_batch((self,), values.reshape(1, -1)))

    def next_theta(self, theta: ArrayLike) -> Array:
        """Return theta_next (...), rad on the lift, at orientations (...)."""
        return self.cycles(theta).theta_next

    def sensitivity(
        self, theta: float, parameters: tuple[str, ...] = PARAMETERS
    ) -> CycleSensitivity:
        """Run one cycle and differentiate it by theta and by every parameter of material, pusher
        and protocol.

        Parameters
        ----------
        theta : float
            Orientation before, rad.
        parameters : tuple of str, optional
            Names of what it is differentiated by.

        Returns
        -------
        CycleSensitivity
            The derivatives of every output.

        Raises
        ------
        InvalidInput
            For an unknown name, and names that are none.

        Notes
        -----
        At accuracy 1e-8 derivatives by theta are off by 3e-7 in the median and by 1e-5 at worst, at
        1e-10 by 2e-8 and 6e-7 (MIT's loop on plywood, delrin and pu, 1,200 cycles). By the friction
        of a ring that has none, and by the radius of a rod that is a point, they are one-sided:
        where it goes around a corner or into a concave one they are those of thin rods, off by 2e-6
        in the median and by 2e-3 at worst (950 cycles). They are nan by shares that a footprint
        cannot have, and by the radius of a point that starts or rests at a corner, where a thin
        rod's way grows as the root of its radius.
        """
        require_kind("parameters", parameters, tuple, list)
        for name in parameters:
            if name not in PARAMETERS:
                raise unknown_name("parameter", name, PARAMETERS)
        theta = finite_number("theta", theta)
        batch = run_batch((self,), np.array([[theta]]), len(PARAMETERS))
        columns = [PARAMETERS.index(name) for name in parameters]
        return CycleSensitivity(
            theta, float(batch.theta_next[0, 0]), batch.jacobian[0, 0][:, columns], parameters
        )

    def circle_map(self, tolerance: float = 1e-6, progress: Progress | None = None) -> CircleMap:
        """Return the cycle map theta -> theta_next.

        Parameters
        ----------
        tolerance : float, default 1e-6
            Error of the map, rad, wherever it is not a jump.
        progress : callable or None, optional
            Called with the fraction done.

        Returns
        -------
        CircleMap
            Its `max_error` is an estimate: of maps of strongly anisotropic loops one in seven was
            further off somewhere, by up to twice that. See `sample_circle_map` for how samples are
            placed and jumps kept.
        """
        if positive_number("tolerance", tolerance) < _LEAST_TOLERANCE:
            raise InvalidInput(
                f"tolerance {tolerance} rad is out of reach: samples are good to 1e-10 rad, so ask "
                f"for {_LEAST_TOLERANCE} or more"
            )
        sample_error = max(0.1 * tolerance, 1e-10)
        slopes = CycleSlopes(replace(self, accuracy=min(sample_error, 1e-6)))
        return sample_circle_map(slopes, 0.9 * tolerance, progress, sample_error)

    def strokes(
        self, theta: float, longest_step: float = math.inf
    ) -> tuple[PushResult, DragResult]:
        """Run the push and the drag of a cycle, their steps no longer than `longest_step` (m)."""
        return self.model.cycle(theta, self.push, self.reset, longest_step)


def run_cycles(loops: Sequence[CollectionLoop], theta: ArrayLike) -> Cycles:
    """Run one push and reset of each of k loops from each of n orientations.

    Parameters
    ----------
    loops : sequence of CollectionLoop
        Any mixture.
    theta : array_like, shape (n,) or (k, n)
        Orientations that all loops start from, or those of each, rad.

    Returns
    -------
    Cycles
        With the axes (k, n).

    Raises
    ------
    InvalidInput
        For loops that are none, or thetas in another shape.
    CycleMapError
        What `CollectionLoop.cycle` raises where a cycle is refused, telling which loop and
        orientation.

    Notes
    -----
    One call of the engine, on as many threads as CYCLEMAP_THREADS tells, else one a core; the
    results are the numbers of `CollectionLoop.cycle` to the bit.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop, run_cycles
    >>> loops = [CollectionLoop.mit(material) for material in ("plywood", "delrin")]
    >>> np.degrees(run_cycles(loops, [0.0, 1.0, 2.0]).push_turn).round(2)
    array([[73.65, 73.93, 70.46],
           [79.15, 80.12, 78.44]])
    """
    if not isinstance(loops, Sequence):
        raise InvalidInput(
            "loops must be a sequence, such as [CollectionLoop.mit('plywood')], not "
            f"{reprlib.repr(loops)}"
        )
    for loop in loops:
        require_loop(loop)
    values = finite_array("theta", theta)
    if values.ndim not in (1, 2) or (values.ndim == 2 and len(values) != len(loops)):
        raise InvalidInput(
            f"theta must have shape (n,) for all loops or ({len(loops)}, n), one row a loop, not "
            f"{values.shape}"
        )
    values = np.broadcast_to(values, (len(loops), values.shape[-1])).copy()
    return Cycles.of_batch(values, run_batch(loops, values))


def require_loop(loop: object) -> CollectionLoop:
    """Return the loop that it is; InvalidInput for anything else."""
    if not isinstance(loop, CollectionLoop):
        raise InvalidInput(
            "loop must be a CollectionLoop, such as CollectionLoop.mit('plywood'), not "
            f"{reprlib.repr(loop)}"
        )
    return loop
