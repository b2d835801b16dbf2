"""Blocks of data, beliefs among them, and the problem of explaining several by one set of
parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_number, positive_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_NAMES,
    FLOOR_NAMES,
    PACE_NAMES,
    PLATE_NAMES,
    Parameter,
    ParameterSpace,
    Rows,
    Values,
)

Labels = NDArray[np.int64]
Kinds = NDArray[np.str_]

# Kinds whose rows are the two components of a vector, one behind the other.
PLANE_KINDS = ("push place (m)", "scan force (N)", "wrench force (N)")
PRIOR_KIND = "prior (standard deviations)"
# How floors differ between sessions: dome, and both components of the bow.
SESSION_KINDS = ("session dome (kPa)", "session bow (kPa)", "session bow (kPa)")
# Kinds that are beliefs, not data.
BELIEF_KINDS = (PRIOR_KIND, *SESSION_KINDS)
# Deviation of a session from the floor's mean, kPa, that so many sessions more are believed to have
# had; also the width of what is believed of spreads.
USUAL_SPREAD = 2.0
_BELIEVED_SESSIONS = 2
# What is usual: how anisotropic floors are, rods and rings of steel on steel (a ring's lever is
# the rod's friction times its radius), shapes of plates and floors, how well the frames of a robot
# and a camera agree. Wide enough that data which know better overrule it.
USUAL = MappingProxyType(
    {
        "ellipticity_x": (0.0, 0.2),
        "ellipticity_y": (0.0, 0.2),
        "offset_x": (0.0, 0.15),
        "offset_y": (0.0, 0.15),
        "pusher_friction": (0.15, 0.05),
        **{f"{worn}{name}": (0.0, 8.0) for worn in ("", "worn_") for name in FLOOR_NAMES},
        **dict.fromkeys(FIELD_NAMES, (0.0, 2.0)),
        **dict.fromkeys(PLATE_NAMES, (0.0, 6.0)),
        "pin_friction_radius": (0.8e-3, 0.5e-3),
        "tip_offset_x": (0.0, 1.5e-3),
        "tip_offset_y": (0.0, 1.5e-3),
        **dict.fromkeys(PACE_NAMES, (0.0, 1.5)),
    }
)
Function = Callable[[Values], Rows]
Beliefs = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class DataBlock:
    """Data of one sort, set against a prediction that depends on named parameters.

    Parameters
    ----------
    name : str
        Names the data in print, unlike that of any other block.
    parameters : tuple of str
        Names of the k unknowns.
    function : callable
        Values by name -> residuals (n,), predicted less measured in the data's own units, and
        derivatives (n, k). Where the model has no answer it raises InvalidInput,
        ConvergenceError or UnsupportedContact, and the search turns back.
    groups : array_like of int, shape (n,)
        Rows of one label share their errors and are left out together.
    kinds : str or array_like of str, shape (n,)
        Which noise each row has, such as `push turn (rad)`, one size of noise a kind; one name
        does for all.
    own_parameters : tuple of Parameter, default ()
        Unknowns that belong to these data alone.
    part : callable or None, optional
        Rows (m,) -> the function of these rows alone, where that is quicker than to leave out
        the others.
    motions : ndarray, shape (s, 2), or None
        Orientation before each stroke or cycle and its measured turn, rad, for pictures.
    curve : callable or None, optional
        Of cycles: values, angles (a,), whether at the end of the wear -> predicted turns (a,).
    asked : tuple of str, default ()
        What `function` calls the parameters, where they have other names.
    stayed : callable or None, optional
        Of strokes: values -> after how many the object is taken to be where it was, since the
        rod misses it or the motion has no answer.
    refined : tuple of callable, default ()
        `function` computed ever more closely, each so much more that the difference to the one
        before is the error of that; without any, its error is none to speak of.

    Raises
    ------
    InvalidInput
        Where shapes do not agree.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import DataBlock
    >>> def function(values):
    ...     return values["slope"] - np.ones(2), np.ones((2, 1))
    >>> line = DataBlock("line", ("slope",), function, groups=[0, 1], kinds="m")
    >>> line.residuals({"slope": 3.0})[0]
    array([2., 2.])
    """

    name: str
    parameters: tuple[str, ...]
    function: Function
    groups: Labels
    kinds: Kinds
    own_parameters: tuple[Parameter, ...] = ()
    part: Callable[[Labels], Function] | None = None
    motions: Array | None = None
    curve: Callable[[Values, Array, bool], Array] | None = None
    asked: tuple[str, ...] = ()
    stayed: Callable[[Values], int] | None = None
    refined: tuple[Function, ...] = ()

    def __post_init__(self) -> None:
        groups = np.array(self.groups)
        if groups.ndim != 1 or (groups.size and not np.issubdtype(groups.dtype, np.integer)):
            raise InvalidInput(f"groups of block {self.name!r} must be whole numbers, one a row")
        groups.setflags(write=False)
        kinds = np.array(self.kinds, dtype=np.str_)
        if kinds.ndim == 0:
            kinds = np.repeat(kinds, groups.size)
        if kinds.shape != groups.shape:
            raise InvalidInput(
                f"kinds of block {self.name!r} must be one name, or one a row: shape {kinds.shape}"
            )
        names = tuple(self.parameters)
        set_fields(self, parameters=names, asked=self.asked or names, groups=groups, kinds=kinds)

    def own_values(self, values: Values) -> dict[str, float]:
        """Return the block's parameters by the names that its functions have for them."""
        return {name: values[own] for name, own in zip(self.asked, self.parameters, strict=True)}

    def residuals(self, values: Values) -> Rows:
        """Return predicted minus measured values, and their derivatives.

        Parameters
        ----------
        values : Values
            At least this block's parameters by name.

        Returns
        -------
        residuals : ndarray, shape (n,)
            In the data's own units.
        derivatives : ndarray, shape (n, k)
            Columns in order of `parameters`.

        Raises
        ------
        ConvergenceError
            For what is not finite.
        """
        residual, jacobian = self.function(self.own_values(values))
        if residual.shape != self.groups.shape or jacobian.shape != (
            residual.size,
            len(self.parameters),
        ):
            raise InvalidInput(
                f"block {self.name!r} of {self.groups.size} rows gave residuals {residual.shape} "
                f"and derivatives {jacobian.shape}"
            )
        if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))):
            raise ConvergenceError(
                f"block {self.name!r} has residuals or derivatives that are not finite"
            )
        return residual, jacobian

    def numerical_errors(self, values: Values) -> Array:
        """Return how far the residuals (n,) are off since they are computed, in the data's own
        units.
        """
        if not self.refined:
            return np.zeros(self.groups.size)
        given = self.own_values(values)
        return self.function(given)[0] - self.refined[0](given)[0]

    def computed_closer(self) -> DataBlock:
        """Return the block computed more closely; itself where nothing would tell its error."""
        if len(self.refined) < 2:
            return self
        return replace(self, function=self.refined[0], refined=self.refined[1:], part=None)

    def columns_by(self, names: Sequence[str], jacobian: Array) -> Array:
        """Return derivatives (n, k) by names of those by the block's parameters, 0 by others."""
        same = np.array(self.parameters)[:, np.newaxis] == np.array(names, dtype=np.str_)
        return np.asarray(jacobian @ same)

    def subset(self, keep: ArrayLike) -> DataBlock:
        """Return the block with the rows only where `keep` (n,) is true, whole strokes; its motions
        are left out.
        """
        rows = np.flatnonzero(keep)
        of_rows = self.part

        def some(whole: Function) -> Function:
            def of_some(values: Values) -> Rows:
                residual, jacobian = whole(values)
                return residual[rows], jacobian[rows]

            return of_some

        return replace(
            self,
            function=some(self.function) if of_rows is None else of_rows(rows),
            groups=self.groups[rows],
            kinds=self.kinds[rows],
            part=None if of_rows is None else lambda fewer: of_rows(rows[fewer]),
            motions=None,
            stayed=None,
            refined=tuple(some(function) for function in self.refined),
        )

    def of_owner(self, owner: str, owned: Sequence[Parameter]) -> DataBlock:
        """Return the block of one plate or session of several: `plate_dome`, if `owned`, is then
        `plate_dome[hex]`.
        """
        asked = [parameter for parameter in owned if parameter.name in self.parameters]
        names = {parameter.name: f"{parameter.name}[{owner}]" for parameter in asked}
        new = [
            replace(row, name=names[row.name], description=f"{row.description}; {owner}")
            for row in asked
        ]
        kept = [row for row in self.own_parameters if row.name not in names]
        parameters = tuple(names.get(name, name) for name in self.parameters)
        return replace(self, parameters=parameters, own_parameters=(*new, *kept))


def asked_by(blocks: Iterable[DataBlock]) -> set[str]:
    """Return the names of the parameters that blocks depend on."""
    return {name for block in blocks for name in block.parameters}


def set_fields(frozen: object, **values: object) -> None:
    """Set fields of a frozen dataclass while it is made."""
    for name, value in values.items():
        object.__setattr__(frozen, name, value)


@dataclass(frozen=True, eq=False)
class JointProblem:
    """The blocks, the free parameters, and the values of all others that the blocks ask for.

    Rows of all n blocks follow each other: block_index (n,) which block each is of, groups (n,)
    0 ... count - 1, kinds (n,) its noise, kind_names sorted, kind_index (n,) among them. A group is
    known by its block and label, so that equal labels of two blocks are two groups; kinds of noise
    are known by name alone, so that blocks may share one.

    Raises InvalidInput where a block asks for a parameter that is neither free nor given, where a
    free one is asked for by no block, or where two blocks have one name.
    """

    blocks: tuple[DataBlock, ...]
    space: ParameterSpace
    fixed: Values
    block_index: Labels = field(init=False)
    groups: Labels = field(init=False)
    kinds: Kinds = field(init=False)
    kind_names: tuple[str, ...] = field(init=False)
    kind_index: Labels = field(init=False)

    def __post_init__(self) -> None:
        fixed = {
            name: finite_number(name, value)
            for name, value in self.fixed.items()
            if name not in self.space.names
        }
        names = [block.name for block in self.blocks]
        if not names or len(set(names)) < len(names):
            raise InvalidInput(
                f"blocks must have names of their own, and there must be one at least, not {names}"
            )
        asked = asked_by(self.blocks)
        idle = [name for name in self.space.names if name not in asked]
        if idle:
            raise InvalidInput(
                f"no block of data depends on {', '.join(idle)}: take it out of the free parameters"
            )
        missing = sorted(asked - set(self.space.names) - set(fixed))
        if missing:
            raise InvalidInput(
                f"the data depend on {', '.join(missing)}: let it be free, or give its value in "
                "`fixed`"
            )
        index = np.repeat(np.arange(len(self.blocks)), [len(block.groups) for block in self.blocks])
        labels = np.stack([index, np.concatenate([block.groups for block in self.blocks])])
        groups = np.unique(labels, axis=1, return_inverse=True)[1].reshape(-1)
        kinds = np.concatenate([block.kinds for block in self.blocks])
        kind_names, kind_index = np.unique(kinds, return_inverse=True)
        set_fields(self, fixed=fixed, block_index=index, groups=groups, kinds=kinds)
        set_fields(self, kind_names=tuple(kind_names.tolist()), kind_index=kind_index.reshape(-1))

    def values(self, vector: Array) -> dict[str, float]:
        """Return every parameter's value by name, at values (k,) of the free ones."""
        return {**self.fixed, **self.space.values(vector)}

    def evaluate(self, vector: Array) -> Rows:
        """Return residuals (n,) and their derivatives by the free parameters (n, k). Raises
        whatever a block raises.
        """
        values = self.values(vector)
        residuals = []
        jacobians = []
        for block in self.blocks:
            residual, jacobian = block.residuals(values)
            residuals.append(residual)
            jacobians.append(block.columns_by(self.space.names, jacobian))
        return np.concatenate(residuals), np.concatenate(jacobians)

    def numerical_errors(self, vector: Array) -> Array:
        """Return how far the residuals (n,) at values (k,) of the free parameters are off since
        they are computed.
        """
        values = self.values(vector)
        return np.concatenate([block.numerical_errors(values) for block in self.blocks])

    def size_by_kind(self, errors: Array) -> Array:
        """Return the root mean square (kinds,) of errors (n,) by their kinds of noise."""
        squares = np.bincount(self.kind_index, errors**2)
        return np.asarray(np.sqrt(squares / np.bincount(self.kind_index)))

    def computed_closer(self) -> JointProblem:
        """Return the problem with all blocks computed more closely that can be."""
        return replace(self, blocks=tuple(block.computed_closer() for block in self.blocks))

    def subset(self, keep: ArrayLike, values: Values) -> JointProblem:
        """Return the problem of the rows where `keep` (n,) is true; empty blocks drop out.

        A free parameter that no block asks for any more is held at its value in `values`.
        """
        chosen = np.asarray(keep, dtype=bool)
        blocks = []
        for index, block in enumerate(self.blocks):
            rows = chosen[self.block_index == index]
            if rows.any():
                blocks.append(block if rows.all() else block.subset(rows))
        asked = asked_by(blocks)
        idle = {name: values[name] for name in self.space.names if name not in asked}
        space = self.space.select(tuple(name for name in self.space.names if name in asked))
        return JointProblem(tuple(blocks), space, {**self.fixed, **idle})


def prior_block(beliefs: Beliefs) -> DataBlock:
    """Return beliefs (value, standard deviation) about parameters by name, in SI units, as a block
    of data.

    A row is the parameter's distance from the believed value in standard deviations; its noise is
    known to be 1: give `noise={PRIOR_KIND: 1.0, ...}` to `identify`. Raises InvalidInput for no
    belief or a deviation that is not positive.

    >>> block = prior_block({"pusher_friction": (0.15, 0.03)})
    >>> block.residuals({"pusher_friction": 0.18})[0].round(9).tolist()
    [1.0]
    """
    if not beliefs:
        raise InvalidInput("a block of priors needs a belief about one parameter at least")
    names = tuple(beliefs)
    centre = np.array([finite_number(f"believed {key}", beliefs[key][0]) for key in names])
    width = np.array(
        [positive_number(f"deviation of the believed {key}", beliefs[key][1]) for key in names]
    )
    groups = np.arange(len(names))
    return linear_block("priors", names, np.diag(1.0 / width), centre / width, groups, PRIOR_KIND)


def linear_block(
    name: str,
    parameters: tuple[str, ...],
    jacobian: Array,
    measured: Array,
    groups: Labels,
    kinds: ArrayLike,
) -> DataBlock:
    """Return the block of measured values (n,) that are ``jacobian`` (n, k) times parameters."""

    def function(values: Values) -> Rows:
        return jacobian @ [values[key] for key in parameters] - measured, jacobian

    return DataBlock(name, parameters, function, groups, np.asarray(kinds, dtype=np.str_))


def session_block(sessions: Sequence[str], odd: Sequence[str] = ()) -> DataBlock:
    """Return how the floor's shape in each session may differ from its mean, as a block of data.

    Rows are differences (kPa), whose noise is the spread between sessions: `identify` estimates it
    along (restricted maximum likelihood), as if two sessions more had differed by 2 kPa, and
    believed to be half-normal of that width: the data of a plate tell the sum of its shape and the
    floor's alone. odd : sessions that do not count to the mean.

    >>> block = session_block(["a", "b"])
    >>> values = {name: 3.0 * name.endswith("dome[b]") for name in block.parameters}
    >>> block.residuals(values)[0].tolist()
    [0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0]
    """
    names = [f"{name}[{session}]" for session in sessions for name in FLOOR_NAMES]
    counted = np.repeat([session not in odd for session in sessions], len(FLOOR_NAMES))
    size = np.where(counted, 1.0, USUAL["floor_dome"][1])
    mean = np.tile(np.eye(len(FLOOR_NAMES)), (len(sessions), 1)) * counted[:, np.newaxis]
    differences = np.hstack([np.eye(len(names)), -mean]) / size[:, np.newaxis]
    believed = _BELIEVED_SESSIONS * len(FLOOR_NAMES)
    jacobian = np.pad(differences, ((0, believed), (0, 0)))
    kinds = np.tile(SESSION_KINDS, len(sessions) + _BELIEVED_SESSIONS)
    kinds = np.where(np.append(counted, [True] * believed), kinds, PRIOR_KIND)
    usual = np.repeat([0.0, -USUAL_SPREAD], [len(names), believed])
    groups = np.arange(usual.size) // len(FLOOR_NAMES)
    return linear_block("sessions", (*names, *FLOOR_NAMES), jacobian, usual, groups, kinds)


def usual_beliefs(names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return what is usual (value, standard deviation) of those parameters of which it is known, of
    any plate.

    What a floor was like in one of several sessions is told by its mean (`session_block`).

    >>> usual_beliefs(["plate_dome[hex]", "friction_scale", "floor_dome[hex 20 mm/s]"])
    {'plate_dome[hex]': (0.0, 6.0)}
    """
    beliefs = {}
    for name in names:
        plain = name.partition("[")[0]
        is_of_session = plain in FLOOR_NAMES and plain != name
        if plain in USUAL and not is_of_session:
            beliefs[name] = USUAL[plain]
    return beliefs
