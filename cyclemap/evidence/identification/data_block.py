"""Blocks of data: predicted minus measured values, their derivatives, and which rows belong together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.parameter_space import Parameter

Array = NDArray[np.float64]
Labels = NDArray[np.int64]
Kinds = NDArray[np.str_]
Values = Mapping[str, float]

# Kinds whose rows are the two components of a vector, one behind the other.
PLANE_KINDS = ("push place (m)", "scan force (N)", "wrench force (N)")


class DataBlock(Protocol):
    """Data of one sort, set against a prediction that depends on named parameters.

    A block is a value: nothing that it holds changes. It may be asked for parameters at which the model has no answer;
    it then raises InvalidInput, ConvergenceError or UnsupportedContact, and the search turns back.
    """

    @property
    def name(self) -> str:
        """What the data are, for reports."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the k parameters that the prediction depends on."""

    @property
    def groups(self) -> Labels:
        """(n,) integer labels: rows of one label share their errors and are left out together."""

    @property
    def kinds(self) -> Kinds:
        """(n,) which noise each row has, such as `push turn (rad)`; rows of one kind have one size of noise."""

    def residuals(self, values: Values) -> tuple[Array, Array]:
        """Return predicted minus measured values (n,) in the data's own units, and their derivatives (n, k).

        `values` holds at least this block's parameters by name; columns are in the order of `parameters`.
        """

    def subset(self, keep_groups: ArrayLike) -> DataBlock:
        """Return the block with the rows of some groups only; none of them may be known here."""


def kept_rows(groups: Labels, keep_groups: ArrayLike) -> NDArray[np.bool_]:
    """Return which rows (n,) belong to one of the groups to be kept.

    >>> kept_rows(np.array([0, 0, 3]), [3]).tolist()
    [False, False, True]
    """
    return np.asarray(np.isin(groups, np.asarray(keep_groups, dtype=np.int64)))


def checked_labels(name: str, groups: ArrayLike, count: int) -> Labels:
    """Return `groups` as whole numbers (count,), or raise InvalidInput naming the block."""
    labels = np.array(groups)
    if labels.shape != (count,) or (labels.size and not np.issubdtype(labels.dtype, np.integer)):
        raise InvalidInput(
            f"groups of block {name!r} must be {count} whole numbers, one a row, not shape {labels.shape}"
        )
    labels = labels.astype(np.int64)
    labels.setflags(write=False)
    return labels


@dataclass(frozen=True, eq=False)
class FunctionBlock:
    """A block from a function of its parameters, the rows being known in number.

    function : values by name -> (residuals (n,), derivatives (n, k)), for all n rows of the whole block.
    groups, kinds : (n,) as `DataBlock` tells; `kinds` may be one name for all rows.
    rows : which of the function's rows are in the block; all, if left out.

    Raises InvalidInput where shapes do not agree.

    >>> line = FunctionBlock("line", ("slope",), lambda v: (v["slope"] - np.ones(2), np.ones((2, 1))), [0, 1], "m")
    >>> line.residuals({"slope": 3.0})[0]
    array([2., 2.])
    """

    name: str
    parameters: tuple[str, ...]
    function: Callable[[Values], tuple[Array, Array]]
    groups: Labels
    kinds: Kinds
    rows: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        count = np.size(self.groups)
        object.__setattr__(self, "parameters", tuple(self.parameters))
        object.__setattr__(self, "groups", checked_labels(self.name, self.groups, count))
        kinds = np.full(count, self.kinds) if np.ndim(self.kinds) == 0 else np.array(self.kinds, dtype=np.str_)
        if kinds.shape != (count,):
            raise InvalidInput(f"kinds of block {self.name!r} must be one name, or one a row: shape {kinds.shape}")
        object.__setattr__(self, "kinds", kinds)
        object.__setattr__(self, "rows", np.arange(count) if self.rows is None else np.asarray(self.rows))

    def residuals(self, values: Values) -> tuple[Array, Array]:
        """Return residuals (n,) and derivatives (n, k) of the block's rows."""
        residual, jacobian = self.function(values)
        residual = finite_array(f"residuals of block {self.name!r}", residual, ndim=1)
        jacobian = finite_array(f"derivatives of block {self.name!r}", jacobian, last=len(self.parameters), ndim=2)
        if len(jacobian) != len(residual):
            raise InvalidInput(f"block {self.name!r} gave {len(residual)} residuals but {len(jacobian)} derivatives")
        return residual[self.rows], jacobian[self.rows]

    def subset(self, keep_groups: ArrayLike) -> FunctionBlock:
        """Return the block with the rows of some groups only."""
        keep = kept_rows(self.groups, keep_groups)
        assert self.rows is not None
        return replace(self, groups=self.groups[keep], kinds=self.kinds[keep], rows=self.rows[keep])


@dataclass(frozen=True, eq=False)
class PlateBlock:
    """A block of one plate among several: what belongs to the plate alone has its name behind it, `rim_share[hex]`.

    owned : the parameters of `block` that belong to the plate, in its own names.

    >>> rim = FunctionBlock("pushes", ("offset_x", "rim_share"), lambda v: None, [0], "m")
    >>> PlateBlock(rim, "hex", (Parameter("rim_share", "", "1", 0.0, 1.0, 0.3, 0.2),)).parameters
    ('offset_x', 'rim_share[hex]')
    """

    block: DataBlock
    plate: str
    owned: tuple[Parameter, ...]

    @property
    def name(self) -> str:
        """The plate and what the data are."""
        return f"{self.plate} {self.block.name}"

    @property
    def parameters(self) -> tuple[str, ...]:
        """Those of the block, the plate's own with its name."""
        own = {parameter.name for parameter in self.owned}
        return tuple(f"{name}[{self.plate}]" if name in own else name for name in self.block.parameters)

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """The plate's own unknowns, and those of the block."""
        asked = {name.partition("[")[0] for name in self.parameters if "[" in name}
        mine = tuple(
            replace(one, name=f"{one.name}[{self.plate}]", description=f"{one.description}; {self.plate}")
            for one in self.owned
            if one.name in asked
        )
        own = {one.name for one in self.owned}
        return (*mine, *(one for one in getattr(self.block, "own_parameters", ()) if one.name not in own))

    @property
    def groups(self) -> Labels:
        """Those of the block."""
        return self.block.groups

    @property
    def kinds(self) -> Kinds:
        """Those of the block."""
        return self.block.kinds

    def residuals(self, values: Values) -> tuple[Array, Array]:
        """Those of the block at the plate's own values."""
        own = zip(self.block.parameters, self.parameters, strict=True)
        return self.block.residuals({name: values[named] for name, named in own})

    def subset(self, keep_groups: ArrayLike) -> PlateBlock:
        """Return the block with the rows of some groups only."""
        return replace(self, block=self.block.subset(keep_groups))


def plain_block(block: DataBlock) -> DataBlock:
    """Return the block itself, without the plate that it may be of."""
    return block.block if isinstance(block, PlateBlock) else block
