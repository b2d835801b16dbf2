"""Several blocks of data explained by one set of parameters, some free and some held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, Kinds, Labels
from cyclemap.evidence.identification.parameter_space import ParameterSpace


@dataclass(frozen=True, eq=False)
class JointProblem:
    """The blocks, the free parameters, and the values of all others that the blocks ask for.

    Rows of all blocks follow each other. A group is known by its block and label, so that equal labels of two blocks
    are two groups; kinds of noise are known by name alone, so that blocks may share one.

    Raises InvalidInput where a block asks for a parameter that is neither free nor given, where a free one is asked for
    by no block, or where two blocks have one name.
    """

    blocks: tuple[DataBlock, ...]
    space: ParameterSpace
    fixed: Mapping[str, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", tuple(self.blocks))
        fixed = {name: finite_number(name, value) for name, value in self.fixed.items() if name not in self.space.names}
        object.__setattr__(self, "fixed", fixed)
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

    @cached_property
    def block_index(self) -> Labels:
        """Which block each row belongs to, (n,)."""
        return np.repeat(np.arange(len(self.blocks)), [len(block.groups) for block in self.blocks])

    @cached_property
    def groups(self) -> Labels:
        """Number of each row's group, (n,), 0 ... count - 1 over all blocks."""
        labels = np.concatenate([block.groups for block in self.blocks])
        return np.unique(np.stack([self.block_index, labels]), axis=1, return_inverse=True)[1].reshape(-1)

    @cached_property
    def kinds(self) -> Kinds:
        """Which noise each row has, (n,)."""
        return np.concatenate([np.asarray(block.kinds, dtype=np.str_) for block in self.blocks])

    @cached_property
    def kind_names(self) -> tuple[str, ...]:
        """The kinds of noise, sorted."""
        return tuple(np.unique(self.kinds).tolist())

    @cached_property
    def kind_index(self) -> Labels:
        """Number of each row's kind in `kind_names`, (n,)."""
        return np.unique(self.kinds, return_inverse=True)[1].reshape(-1)

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
            jacobians.append(self._by_free(block, jacobian))
        return np.concatenate(residuals), np.concatenate(jacobians)

    def _by_free(self, block: DataBlock, jacobian: Array) -> Array:
        columns = np.zeros((len(block.groups), len(self.space)))
        for index, name in enumerate(block.parameters):
            if name in self.space.names:
                columns[:, self.space.names.index(name)] = jacobian[:, index]
        return columns

    def holding(self, name: str, value: float) -> JointProblem:
        """Return the problem with one free parameter held at a value."""
        others = self.space.select(tuple(other for other in self.space.names if other != name))
        return replace(self, space=others, fixed={**self.fixed, name: value})

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
