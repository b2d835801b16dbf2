"""What cycles of a push and a drag back give: each with its course, many as arrays, derivatives."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.checks import require_kind
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import DragResult, PushResult, Trajectory
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleBatch
from cyclemap.mechanics.engine.schema import PARAMETERS

if TYPE_CHECKING:
    import pandas
    import xarray

    from cyclemap.mechanics import DynamicDrag, DynamicPush, DynamicTrajectory


P = TypeVar("P", bound="PushResult | DynamicPush")
D = TypeVar("D", bound="DragResult | DynamicDrag")
T = TypeVar("T", bound="Trajectory | DynamicTrajectory")


@dataclass(frozen=True, eq=False)
class CycleTrajectory(Generic[T]):
    """The course of a cycle in the world, whose origin is the reset's target.

    Attributes
    ----------
    push : Trajectory or DynamicTrajectory
        The course of the push.
    drag : Trajectory or DynamicTrajectory
        The course of the drag back.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> course = CollectionLoop.mit().cycle(0.0).trajectory
    >>> course.push.pose.shape[1], str(course.drag.mode[0])
    (3, 'ring')
    """

    push: T
    drag: T


@dataclass(frozen=True, eq=False)
class StrokePair(Generic[P, D]):
    """A push and the drag that followed it.

    Attributes
    ----------
    theta : float
        Orientation before, rad.
    push, drag : results of both strokes
        Quasi-static or dynamic.
    """

    theta: float
    push: P
    drag: D

    @property
    def push_turn(self) -> float:
        """Turn of the object by the push, rad."""
        return self.push.turn

    @property
    def push_displacement(self) -> Array:
        """Of the object's origin in its initial frame, (2,), m."""
        return self.push.displacement

    @property
    def drag_turn(self) -> float:
        """Turn of the object by the drag, rad."""
        return self.drag.turn

    @property
    def drag_length(self) -> float:
        """Path of the ring, m."""
        return self.drag.length

    @property
    def theta_next(self) -> float:
        """Orientation after, rad on the lift: theta + push_turn + drag_turn."""
        return self.drag.end.theta

    @property
    def ended(self) -> str:
        """Why the push ended, `distance`, or `left` where the rod lost the object."""
        return self.push.ended


@dataclass(frozen=True, eq=False)
class Cycles:
    """Many cycles as arrays, in the shape (...) of the orientations they start from.

    Attributes
    ----------
    theta : ndarray, shape (...)
        Orientations before, rad.
    push_turn : ndarray, shape (...)
        Turns of the object by the push, rad.
    push_displacement : ndarray, shape (..., 2)
        Of the object's origin in its initial frame, m.
    drag_turn : ndarray, shape (...)
        Turns by the drag, rad.
    drag_length : ndarray, shape (...)
        Path of the ring, m.
    theta_next : ndarray, shape (...)
        Orientations after, rad on the lift.
    left : ndarray of bool, shape (...)
        Where the rod lost the object before the push's distance was done.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> cycles = CollectionLoop.mit().cycles([[0.0, 1.0, 2.0]])
    >>> cycles.push_displacement.shape, cycles.left.tolist()
    ((1, 3, 2), [[True, False, False]])
    """

    theta: Array
    push_turn: Array
    push_displacement: Array
    drag_turn: Array
    drag_length: Array
    theta_next: Array
    left: Mask

    def to_frame(self) -> pandas.DataFrame:
        """Return one row a cycle, in the order of theta.ravel(): theta, push_turn, ..., push_dx,
        push_dy (rad, m).

        >>> from cyclemap import CollectionLoop
        >>> CollectionLoop.mit().cycles([0.0, 1.0]).to_frame().drag_length.round(3).tolist()
        [0.093, 0.097]
        """
        import pandas

        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        dx, dy = np.moveaxis(columns.pop("push_displacement"), -1, 0)
        columns |= {"push_dx": dx, "push_dy": dy}
        return pandas.DataFrame({name: values.ravel() for name, values in columns.items()})

    def to_dataset(self, *axes: str) -> xarray.Dataset:
        """Return the cycles as an xarray Dataset; variables as `to_frame`.

        Parameters
        ----------
        *axes : str
            Names of the axes of theta, one each.

        Returns
        -------
        xarray.Dataset
            Over these axes.

        Raises
        ------
        InvalidInput
            Where names and axes differ in number, and for a name given twice or none.

        Examples
        --------
        >>> from cyclemap import CollectionLoop, run_cycles
        >>> dict(run_cycles([CollectionLoop.mit()], [0.0, 1.0]).to_dataset("loop", "start").sizes)
        {'loop': 1, 'start': 2}
        """
        import xarray

        if len(axes) != self.theta.ndim:
            raise InvalidInput(
                f"theta has {self.theta.ndim} axes, but {len(axes)} names are given: give one "
                "for each"
            )
        for name in axes:
            require_kind("name of an axis", name, str)
        if len(set(axes)) < len(axes):
            raise InvalidInput(f"names of axes {axes} must differ: give each axis its own")
        columns = {
            name: column.to_numpy().reshape(self.theta.shape)
            for name, column in self.to_frame().items()
        }
        return xarray.Dataset({name: (axes, values) for name, values in columns.items()})

    @classmethod
    def of_batch(cls, theta: Array, batch: CycleBatch) -> Cycles:
        """Return what the engine ran from the orientations theta (...), in its order."""
        columns = [getattr(batch, field.name) for field in fields(cls)[1:]]
        return cls(
            theta, *(column.reshape((*theta.shape, *column.shape[2:])) for column in columns)
        )


@dataclass(frozen=True, eq=False)
class CycleSensitivity:
    """Derivatives of one cycle.

    Attributes
    ----------
    theta : float
        Orientation before, rad.
    theta_next : float
        Orientation after, rad. `by("theta")` is d theta_next / d theta, the multiplier.
    jacobian : ndarray, shape (6, k)
        Derivatives of `outputs` by `parameters`, SI units and radians.
    parameters : tuple of str
        Names of what was varied.
    outputs : tuple of str
        push_turn, push_dx, push_dy, drag_turn, drag_length, theta_next.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> sensitivity = CollectionLoop.mit("plywood").sensitivity(0.0)
    >>> round(sensitivity.by("theta"), 3), round(sensitivity.by("mu_a", "push_turn"), 3)
    (0.766, 1.319)
    """

    theta: float
    theta_next: float
    jacobian: Array
    parameters: tuple[str, ...] = PARAMETERS
    outputs: tuple[str, ...] = CYCLE_OUTPUTS

    def by(self, parameter: str, output: str = "theta_next") -> float:
        """Return the derivative of an output by a parameter, both by name."""
        if parameter not in self.parameters or output not in self.outputs:
            raise InvalidInput(
                f"no derivative of {output!r} by {parameter!r}: know {self.outputs} by "
                f"{self.parameters}"
            )
        return float(self.jacobian[self.outputs.index(output), self.parameters.index(parameter)])
