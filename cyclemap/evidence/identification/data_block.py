"""Blocks of data, beliefs among them, and the problem of explaining several by one set of parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, positive_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.identification.surface_parameters import Parameter, ParameterSpace

Labels = NDArray[np.int64]
Kinds = NDArray[np.str_]
Values = Mapping[str, float]

# Kinds whose rows are the two components of a vector, one behind the other.
PLANE_KINDS = ("push place (m)", "scan force (N)", "wrench force (N)")
PRIOR_KIND = "prior (standard deviations)"
# What is usual: how anisotropic floors are, rods and rings of steel on steel, how plates press, how well the frames of
# a robot and a camera agree. Wide enough that data which know better overrule it.
USUAL = MappingProxyType(
    {
        "ellipticity_x": (0.0, 0.2),
        "ellipticity_y": (0.0, 0.2),
        "offset_x": (0.0, 0.15),
        "offset_y": (0.0, 0.15),
        "pusher_friction": (0.15, 0.05),
        "rim_share": (0.2, 0.3),
        "corner_share": (0.1, 0.3),
        "inner_share": (0.2, 0.4),
        "pin_friction_radius": (1.5e-3, 1e-3),
        "tip_offset_x": (0.0, 1.5e-3),
        "tip_offset_y": (0.0, 1.5e-3),
    }
)
Progress = Callable[[float], None]


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


def set_fields(frozen: object, **values: object) -> None:
    """Set fields of a frozen dataclass while it is made."""
    for name, value in values.items():
        object.__setattr__(frozen, name, value)


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
        kinds = np.full(count, self.kinds) if np.ndim(self.kinds) == 0 else np.array(self.kinds, dtype=np.str_)
        if kinds.shape != (count,):
            raise InvalidInput(f"kinds of block {self.name!r} must be one name, or one a row: shape {kinds.shape}")
        rows = np.arange(count) if self.rows is None else np.asarray(self.rows)
        groups = checked_labels(self.name, self.groups, count)
        set_fields(self, parameters=tuple(self.parameters), groups=groups, kinds=kinds, rows=rows)

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
        keep = np.isin(self.groups, keep_groups)
        assert self.rows is not None
        return replace(self, groups=self.groups[keep], kinds=self.kinds[keep], rows=self.rows[keep])


@dataclass(frozen=True, eq=False)
class PlateBlock:
    """A block of one plate among several: what belongs to the plate alone has its name behind it, `rim_share[hex]`.

    owned : the parameters of `block` that belong to the plate, in its own names. name : the plate and the block's, if
    left out. own_parameters : the plate's own unknowns, and those of the block.

    >>> rim = FunctionBlock("pushes", ("offset_x", "rim_share"), lambda v: None, [0], "m")
    >>> PlateBlock(rim, "hex", (Parameter("rim_share", "", "1", 0.0, 1.0, 0.3, 0.2),)).parameters
    ('offset_x', 'rim_share[hex]')
    """

    block: DataBlock
    plate: str
    owned: tuple[Parameter, ...]
    name: str = ""
    parameters: tuple[str, ...] = field(init=False)
    own_parameters: tuple[Parameter, ...] = field(init=False)
    groups: Labels = field(init=False)
    kinds: Kinds = field(init=False)

    def __post_init__(self) -> None:
        named = {
            one.name: replace(one, name=f"{one.name}[{self.plate}]", description=f"{one.description}; {self.plate}")
            for one in self.owned
            if one.name in self.block.parameters
        }
        told = [one for one in getattr(self.block, "own_parameters", ()) if one.name not in named]
        own = {name: one.name for name, one in named.items()}
        set_fields(
            self,
            name=self.name or f"{self.plate} {self.block.name}",
            parameters=tuple(own.get(name, name) for name in self.block.parameters),
            own_parameters=(*named.values(), *told),
            groups=self.block.groups,
            kinds=self.block.kinds,
        )

    def residuals(self, values: Values) -> tuple[Array, Array]:
        """Return those of the block at the plate's own values."""
        own = zip(self.block.parameters, self.parameters, strict=True)
        return self.block.residuals({name: values[named] for name, named in own})

    def subset(self, keep_groups: ArrayLike) -> PlateBlock:
        """Return the block with the rows of some groups only."""
        return replace(self, block=self.block.subset(keep_groups))


@dataclass(frozen=True, eq=False)
class JointProblem:
    """The blocks, the free parameters, and the values of all others that the blocks ask for.

    Rows of all n blocks follow each other: block_index (n,) which block each is of, groups (n,) 0 ... count - 1, kinds
    (n,) its noise, kind_names sorted, kind_index (n,) among them. A group is known by its block and label, so that
    equal labels of two blocks are two groups; kinds of noise are known by name alone, so that blocks may share one.

    Raises InvalidInput where a block asks for a parameter that is neither free nor given, where a free one is asked for
    by no block, or where two blocks have one name.
    """

    blocks: tuple[DataBlock, ...]
    space: ParameterSpace
    fixed: Mapping[str, float]
    block_index: Labels = field(init=False)
    groups: Labels = field(init=False)
    kinds: Kinds = field(init=False)
    kind_names: tuple[str, ...] = field(init=False)
    kind_index: Labels = field(init=False)

    def __post_init__(self) -> None:
        fixed = {name: finite_number(name, value) for name, value in self.fixed.items() if name not in self.space.names}
        names = [block.name for block in self.blocks]
        if not names or len(set(names)) < len(names):
            raise InvalidInput(f"blocks must have names of their own, and there must be one at least, not {names}")
        asked = {name for block in self.blocks for name in block.parameters}
        idle = [name for name in self.space.names if name not in asked]
        if idle:
            raise InvalidInput(f"no block of data depends on {', '.join(idle)}: take it out of the free parameters")
        missing = sorted(asked - set(self.space.names) - set(fixed))
        if missing:
            raise InvalidInput(f"the data depend on {', '.join(missing)}: let it be free, or give its value in `fixed`")
        index = np.repeat(np.arange(len(self.blocks)), [len(block.groups) for block in self.blocks])
        labels = np.stack([index, np.concatenate([block.groups for block in self.blocks])])
        groups = np.unique(labels, axis=1, return_inverse=True)[1].reshape(-1)
        kinds = np.concatenate([np.asarray(block.kinds, dtype=np.str_) for block in self.blocks])
        found, kind_index = np.unique(kinds, return_inverse=True)
        set_fields(self, fixed=fixed, block_index=index, groups=groups, kinds=kinds)
        set_fields(self, kind_names=tuple(found.tolist()), kind_index=kind_index.reshape(-1))

    def values(self, vector: Array) -> dict[str, float]:
        """Return every parameter's value by name, at values (k,) of the free ones."""
        return {**self.fixed, **self.space.values(vector)}

    def evaluate(self, vector: Array) -> tuple[Array, Array]:
        """Return residuals (n,) and their derivatives by the free parameters (n, k).

        Raises whatever a block raises; ConvergenceError where its numbers are not finite.
        """
        values = self.values(vector)
        residuals, jacobians = [], []
        for block in self.blocks:
            residual, jacobian = block.residuals(values)
            if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))):
                raise ConvergenceError(f"block {block.name!r} has residuals or derivatives that are not finite")
            residuals.append(residual)
            by_free = np.zeros((len(block.groups), len(self.space)))
            for index, name in enumerate(block.parameters):
                if name in self.space.names:
                    by_free[:, self.space.names.index(name)] = jacobian[:, index]
            jacobians.append(by_free)
        return np.concatenate(residuals), np.concatenate(jacobians)

    def subset(self, keep: ArrayLike, values: Mapping[str, float]) -> JointProblem:
        """Return the problem of the groups of which `keep` (n,), bool by row, holds a row; empty blocks drop out.

        A free parameter that no block asks for any more is held at its value in `values`.
        """
        chosen, parts = np.asarray(keep, dtype=bool), []
        for index, block in enumerate(self.blocks):
            rows = chosen[self.block_index == index]
            if rows.all():
                parts.append(block)
            elif rows.any():
                parts.append(block.subset(np.unique(block.groups[rows])))
        asked = {name for block in parts for name in block.parameters}
        idle = {name: values[name] for name in self.space.names if name not in asked}
        space = self.space.select(tuple(name for name in self.space.names if name in asked))
        return JointProblem(tuple(parts), space, {**self.fixed, **idle})


def prior_block(beliefs: Mapping[str, tuple[float, float]]) -> FunctionBlock:
    """Return beliefs (value, standard deviation) about parameters by name, in SI units, as a block of data.

    A row is the parameter's distance from the believed value in standard deviations; its noise is known to be 1: give
    `noise={PRIOR_KIND: 1.0, ...}` to `identify`. Raises InvalidInput for no belief or a deviation that is not positive.

    >>> prior_block({"pusher_friction": (0.15, 0.03)}).residuals({"pusher_friction": 0.18})[0].round(9).tolist()
    [1.0]
    """
    if not beliefs:
        raise InvalidInput("a block of priors needs a belief about one parameter at least")
    names = tuple(beliefs)
    centre = np.array([finite_number(f"believed {key}", beliefs[key][0]) for key in names])
    width = np.array([positive_number(f"deviation of the believed {key}", beliefs[key][1]) for key in names])

    def function(values: Values) -> tuple[Array, Array]:
        return (np.array([values[key] for key in names]) - centre) / width, np.diag(1.0 / width)

    return FunctionBlock("priors", names, function, np.arange(len(names)), np.full(len(names), PRIOR_KIND))


def usual_beliefs(names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return what is usual (value, standard deviation) of those parameters of which it is known, of any plate.

    >>> usual_beliefs(["rim_share[hex]", "friction_scale"])
    {'rim_share[hex]': (0.2, 0.3)}
    """
    return {name: USUAL[plain] for name in names if (plain := name.partition("[")[0]) in USUAL}


def part_of(progress: Progress | None, number: float, count: float) -> Progress:
    """Return the function to which part `number` of `count` (from 0) reports the fraction of it that is done.

    >>> part_of(print, 1, 4)(0.5)
    0.375
    """
    return lambda fraction: None if progress is None else progress((number + fraction) / count)
