"""One push and reset told by its two strokes, whoever ran them, and many of them as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.cycle_batch import CycleBatch

if TYPE_CHECKING:
    import pandas

    from cyclemap.mechanics import DragResult, DynamicDrag, DynamicPush, DynamicTrajectory, PushResult, Trajectory


P = TypeVar("P", bound="PushResult | DynamicPush")
D = TypeVar("D", bound="DragResult | DynamicDrag")
T = TypeVar("T", bound="Trajectory | DynamicTrajectory")


@dataclass(frozen=True, eq=False)
class CycleTrajectory(Generic[T]):
    """The course of a cycle in the world, whose origin is the reset's target."""

    push: T
    drag: T


@dataclass(frozen=True, eq=False)
class StrokePair(Generic[P, D]):
    """A push from orientation `theta` (rad) and the drag that followed it."""

    theta: float
    push: P
    drag: D

    @property
    def push_turn(self) -> float:
        """Turn during the push, rad."""
        return self.push.turn

    @property
    def push_displacement(self) -> NDArray[np.float64]:
        """Displacement of the object's origin during the push, in its initial frame, (2,), m."""
        return self.push.displacement

    @property
    def drag_turn(self) -> float:
        """Turn during the drag, rad."""
        return self.drag.turn

    @property
    def drag_length(self) -> float:
        """Path of the ring during the drag, m."""
        return self.drag.length

    @property
    def theta_next(self) -> float:
        """Orientation before the next push, rad, on the lift."""
        return self.drag.end.theta

    @property
    def ended(self) -> str:
        """Why the push ended: `distance`, or `left` where the rod lost the object."""
        return self.push.ended


@dataclass(frozen=True, eq=False)
class Cycles:
    """Many cycles as arrays, in the shape (...) of the orientations they start from.

    theta, theta_next (lift), push_turn, drag_turn : (...), rad. push_displacement : (..., 2), m, initial object frame.
    drag_length : (...), m. left : (...), bool, where the rod lost the object before the push's distance was done.
    """

    theta: NDArray[np.float64]
    push_turn: NDArray[np.float64]
    push_displacement: NDArray[np.float64]
    drag_turn: NDArray[np.float64]
    drag_length: NDArray[np.float64]
    theta_next: NDArray[np.float64]
    left: NDArray[np.bool_]

    @classmethod
    def gathered(cls, theta: NDArray[np.float64], runs: Sequence[StrokePair[Any, Any]]) -> Cycles:
        """Return the runs from the orientations theta (...), in its order, as arrays."""
        shapes = {field.name: theta.shape for field in fields(cls)[1:-1]} | {"push_displacement": (*theta.shape, 2)}
        columns = {name: np.array([getattr(run, name) for run in runs], dtype=float) for name in shapes}
        left = np.array([run.ended == "left" for run in runs]).reshape(theta.shape)
        return cls(theta, left=left, **{name: columns[name].reshape(shape) for name, shape in shapes.items()})

    def to_frame(self) -> pandas.DataFrame:
        """Return one row a cycle, in the order of theta.ravel(): theta, push_turn, ..., push_dx, push_dy (rad, m).

        >>> from cyclemap import CollectionLoop
        >>> CollectionLoop.mit().cycles([0.0, 1.0]).to_frame().drag_length.round(3).tolist()
        [0.093, 0.097]
        """
        import pandas

        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        dx, dy = np.moveaxis(columns.pop("push_displacement"), -1, 0)
        columns |= {"push_dx": dx, "push_dy": dy}
        return pandas.DataFrame({name: values.ravel() for name, values in columns.items()})

    @classmethod
    def of_batch(cls, theta: NDArray[np.float64], batch: CycleBatch) -> Cycles:
        """Return what the engine ran from the orientations theta (...), in its order."""
        columns = [getattr(batch, field.name) for field in fields(cls)[1:]]
        return cls(theta, *(column.reshape((*theta.shape, *column.shape[2:])) for column in columns))
