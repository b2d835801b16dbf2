"""The data-collection loop run by the dynamic simulation, and beside the quasi-static loop."""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number
from cyclemap.collection.cycles import Cycles, CycleTrajectory, StrokePair
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import PointFootprint, PressedFootprint
from cyclemap.mechanics.dynamic_model import GRID, SAMPLES, DynamicModel
from cyclemap.mechanics.footprint import pressure_points
from cyclemap.mechanics.trajectory import DynamicDrag, DynamicPush, DynamicTrajectory

# What a comparison tells of both models.
QUANTITIES = ("push_turn", "drag_turn", "theta_next", "push_displacement")


@dataclass(frozen=True, eq=False)
class DynamicCycle(StrokePair[DynamicPush, DynamicDrag]):
    """One push and reset by the dynamic simulation, told as a `Cycle`'s.

    Attributes
    ----------
    theta : float
        Orientation before, rad.
    push : DynamicPush
        The push.
    drag : DynamicDrag
        The drag back.
    push_turn, drag_turn : float
        Turns of the object, rad.
    push_displacement : ndarray, shape (2,)
        Of the object's origin in its initial frame, m.
    drag_length : float
        Path of the rod in the drag, m.
    theta_next : float
        Orientation after, rad on the lift: theta + push_turn + drag_turn.
    ended : str
        Why the push ended, `distance`, or `left` where the rod lost the object.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop
    >>> cycle = DynamicLoop(CollectionLoop.mit()).cycle(1.0)
    >>> cycle.ended, round(math.degrees(cycle.theta_next), 1)
    ('distance', 57.6)
    """

    @property
    def trajectory(self) -> CycleTrajectory[DynamicTrajectory]:
        """The course of the cycle, as sampled."""
        return CycleTrajectory(self.push.trajectory, self.drag.trajectory)


@dataclass(frozen=True)
class DynamicLoop:
    """A collection loop whose strokes are run by `DynamicModel`, at rest in between.

    Parameters
    ----------
    loop : CollectionLoop
        The protocol; it stands on its own support points, or else on those that carry its
        patch's pressure (`on_points`).
    speed : float, default 0.02
        Speed of the rod, m/s, as `DynamicModel` takes and checks it.
    stiffness : float, default 1e6
        Of the contact and the ring, N/m, as `DynamicModel`'s.
    regularisation : float, default 1e-4
        Speed below which friction fades, as a share of the rod's, as `DynamicModel`'s.
    tolerance : float, default 1e-7
        Relative error of a step, as `DynamicModel`'s.

    Raises
    ------
    InvalidInput
        For a loop that is none, and where the parts do not fit each other.

    Examples
    --------
    >>> import math
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop
    >>> cycle = DynamicLoop(CollectionLoop.mit()).cycle(0.0)
    >>> round(math.degrees(cycle.push_turn), 1), round(math.degrees(cycle.drag_turn), 1)
    (73.9, -64.2)
    """

    loop: CollectionLoop
    speed: float = 0.02
    stiffness: float = 1e6
    regularisation: float = 1e-4
    tolerance: float = 1e-7

    def __post_init__(self) -> None:
        require_loop(self.loop)
        # Made here, so that its checks refuse here what does not fit.
        self.model  # noqa: B018

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def model(self) -> DynamicModel:
        """The mechanics. Raises InvalidInput where the parts do not fit each other."""
        return DynamicModel(
            self.loop.slider,
            self.loop.material.friction,
            self.loop.pusher,
            on_points(self.loop).footprint,
            self.speed,
            self.stiffness,
            regularisation=self.regularisation,
            tolerance=self.tolerance,
        )

    def cycle(self, theta: float, samples: int = SAMPLES) -> DynamicCycle:
        """Run one push and reset from orientation `theta` (rad); `samples` of the course of each
        leg are kept.
        """
        theta = finite_number("theta", theta)
        push = self.model.push(self.loop.start_pose(theta), self.loop.push, samples)
        way_points = (*self.loop.reset.way_points, (0.0, 0.0))
        drag = self.model.drag(push.end, way_points, samples, self.loop.reset.pin_friction_radius)
        return DynamicCycle(theta, push, drag)

    def cycles(self, theta: ArrayLike) -> Cycles:
        """Run one push and reset from each of many orientations (...), rad."""
        values = finite_array("theta", theta)
        runs = [self.cycle(each, samples=1) for each in values.ravel().tolist()]
        columns = {}
        for name in (field.name for field in fields(Cycles)[1:-1]):
            shape = (*values.shape, 2) if name == "push_displacement" else values.shape
            columns[name] = np.array([getattr(run, name) for run in runs], dtype=float).reshape(
                shape
            )
        left = np.array([run.ended == "left" for run in runs], dtype=bool).reshape(values.shape)
        return Cycles(values, left=left, **columns)


@dataclass(frozen=True, eq=False)
class DynamicsComparison:
    """Cycles from the same orientations by the dynamic simulation and by the quasi-static model, on
    the same points.

    Attributes
    ----------
    loop : DynamicLoop
        What was compared.
    dynamic : Cycles
        Cycles by the dynamic simulation.
    quasi_static : Cycles
        Cycles by the quasi-static model.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop, compare_dynamics
    >>> comparison = compare_dynamics(DynamicLoop(CollectionLoop.mit()), [0.0])
    >>> np.degrees(comparison.quasi_static.push_turn).round(1).tolist()
    [73.9]
    >>> bool(abs(np.degrees(comparison.difference("push_turn")[0])) < 0.05)
    True
    """

    loop: DynamicLoop
    dynamic: Cycles
    quasi_static: Cycles

    def difference(self, quantity: str) -> Array:
        """Return dynamic less quasi-static of push_turn, drag_turn, theta_next (rad) or
        push_displacement (m).
        """
        if quantity not in QUANTITIES:
            raise InvalidInput(
                f"a comparison has no difference {quantity!r}: choose one of "
                f"{', '.join(QUANTITIES)}"
            )
        return np.asarray(getattr(self.dynamic, quantity) - getattr(self.quasi_static, quantity))


def compare_dynamics(loop: DynamicLoop, theta: ArrayLike) -> DynamicsComparison:
    """Run cycles by the dynamic simulation and by the quasi-static model, on the same support
    points.

    Parameters
    ----------
    loop : DynamicLoop
        The loop; its support points are those of `on_points`.
    theta : array_like, shape (...)
        Orientations that the cycles start from, rad.

    Returns
    -------
    DynamicsComparison
        The cycles of both, in the shape of theta.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, DynamicLoop, compare_dynamics
    >>> comparison = compare_dynamics(DynamicLoop(CollectionLoop.mit()), [0.0])
    >>> np.degrees(comparison.dynamic.push_turn).round(1).tolist()
    [73.9]
    """
    if not isinstance(loop, DynamicLoop):
        raise InvalidInput(
            "what is compared must be a DynamicLoop, such as DynamicLoop(loop), not a "
            f"{type(loop).__name__}"
        )
    return DynamicsComparison(loop, loop.cycles(theta), on_points(loop.loop).cycles(theta))


def on_points(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop standing on points: its own, or those that carry its patch's pressure
    (`pressure_points`).

    Turns of a cycle on plywood from 12 orientations are within 0.44 degrees in the push, 0.63 in
    the drag and 0.25 in both of those on the patch, as the even grid's are. Shapes of plate and
    floor stay: the dynamic model's points follow them, the quasi-static one has the exact contact.
    Raises InvalidInput for a pressure that points cannot carry.
    """
    if isinstance(require_loop(loop).footprint, (PointFootprint, PressedFootprint)):
        return loop
    return replace(loop, footprint=pressure_points(loop.model.pressure, GRID))
