"""Named unknowns of an identification: what each means, where it may lie, where a search for it starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number, positive_number
from cyclemap.errors import InvalidInput
from cyclemap.suggestions import unknown_name


@dataclass(frozen=True)
class Parameter:
    """One unknown.

    description : in plain words, for reports. unit : SI; 1 for a pure number.
    lower, upper : bounds; infinite where there is none. start : where a search begins, strictly between the bounds.
    scale : a change that matters; starts are drawn within two scales of `start`.
    nominal : the value taken where the parameter is neither free nor given; `start` if left out.

    Raises InvalidInput where the numbers contradict each other.
    """

    name: str
    description: str
    unit: str
    lower: float
    upper: float
    start: float
    scale: float
    nominal: float | None = None

    def __post_init__(self) -> None:
        start = finite_number(f"start of {self.name}", self.start)
        positive_number(f"scale of {self.name}", self.scale)
        if not self.lower < start < self.upper:
            raise InvalidInput(
                f"start of {self.name} is {start}: it must lie strictly between its bounds {self.lower}, {self.upper}"
            )
        if self.nominal is None:
            object.__setattr__(self, "nominal", start)
        nominal = finite_number(f"nominal value of {self.name}", self.nominal)
        if not self.lower <= nominal <= self.upper:
            raise InvalidInput(f"nominal value of {self.name} is {nominal}: outside its bounds")


@dataclass(frozen=True)
class ParameterSpace:
    """Parameters in order, each name once.

    >>> heat = Parameter("heat", "how warm it is", "K", 0.0, 10.0, 1.0, 0.5)
    >>> ParameterSpace((heat,)).vector({"heat": 3.0})
    array([3.])
    """

    parameters: tuple[Parameter, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", tuple(self.parameters))
        if len(set(self.names)) < len(self.names):
            raise InvalidInput(f"a parameter is named twice: {self.names}")

    def __len__(self) -> int:
        return len(self.parameters)

    def __getitem__(self, name: str) -> Parameter:
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise unknown_name("parameter", name, self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def lower(self) -> Array:
        """Lower bounds, (k,)."""
        return np.array([parameter.lower for parameter in self.parameters], dtype=float)

    @property
    def upper(self) -> Array:
        """Upper bounds, (k,)."""
        return np.array([parameter.upper for parameter in self.parameters], dtype=float)

    @property
    def start(self) -> Array:
        """Where a search begins, (k,)."""
        return np.array([parameter.start for parameter in self.parameters], dtype=float)

    @property
    def scale(self) -> Array:
        """Changes that matter, (k,)."""
        return np.array([parameter.scale for parameter in self.parameters], dtype=float)

    @property
    def nominal(self) -> dict[str, float]:
        """Value of each parameter where nothing is known of it."""
        return {parameter.name: float(parameter.nominal or 0.0) for parameter in self.parameters}

    def select(self, names: tuple[str, ...]) -> ParameterSpace:
        """Return the space of some of the parameters, in the order of `names`. Raises InvalidInput for unknown ones."""
        return ParameterSpace(tuple(self[name] for name in names))

    def extended(self, *parameters: Parameter) -> ParameterSpace:
        """Return the space with further parameters; one of a name that is already there takes its place."""
        new = {parameter.name: parameter for parameter in parameters}
        kept = [new.pop(parameter.name, parameter) for parameter in self.parameters]
        return ParameterSpace((*kept, *new.values()))

    def bounded(self, name: str, lower: float, upper: float) -> ParameterSpace:
        """Return the space with other bounds for one parameter; its start moves to their middle if it falls outside."""
        old = self[name]
        start = old.start if lower < old.start < upper else 0.5 * (lower + upper)
        nominal = min(max(self.nominal[name], lower), upper)
        return self.extended(replace(old, lower=lower, upper=upper, start=start, nominal=nominal))

    def vector(self, values: Mapping[str, float]) -> Array:
        """Return the values (k,) in this order. Raises InvalidInput for one that is missing or not finite."""
        missing = [name for name in self.names if name not in values]
        if missing:
            raise InvalidInput(f"no value for {', '.join(missing)}: give one for each of {', '.join(self.names)}")
        return np.array([finite_number(name, values[name]) for name in self.names], dtype=float)

    def values(self, vector: Array) -> dict[str, float]:
        """Return the values (k,) by name."""
        return {name: float(value) for name, value in zip(self.names, vector, strict=True)}
