"""What a sweep finds at each point: its numbers by name, with unit and meaning, and the groups they come in."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import InvalidInput
from cyclemap.suggestions import unknown_name


@dataclass(frozen=True)
class Quantity:
    """A number that every point has, or a list of numbers (`listed`) of which it has as many as there are.

    unit : "rad", "1", "cycles" or "turns/cycle"; angles are kept in rad and written in degrees.
    many : the name of what a list runs over.
    """

    name: str
    unit: str
    meaning: str
    many: str = ""

    @property
    def listed(self) -> bool:
        """Whether a point has any number of these."""
        return bool(self.many)

    @property
    def written_name(self) -> str:
        """The name in files, which tells degrees."""
        return f"{self.name}_deg" if self.unit == "rad" else self.name

    @property
    def written_unit(self) -> str:
        """The unit in files."""
        return "degree" if self.unit == "rad" else self.unit

    def written(self, value: float) -> float:
        """The value as files have it."""
        return float(self.written_array(np.array(value)))

    def written_array(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values, of any shape, as files have them."""
        return np.degrees(values) if self.unit == "rad" else values


_FIXED = "fixed_point"
GROUPS: dict[str, tuple[Quantity, ...]] = {
    "map": (
        Quantity("samples", "1", "cycles that were run to find the map"),
        Quantity("max_error", "rad", "bound on the error of the map"),
    ),
    "rotation": (
        Quantity("rotation", "turns/cycle", "rotation number"),
        Quantity("rotation_lower", "turns/cycle", "the rotation number is at least this"),
        Quantity("rotation_upper", "turns/cycle", "the rotation number is at most this"),
        Quantity("locked_winding", "1", "p where the rotation number is proved to be p/q; 0 elsewhere"),
        Quantity("locked_period", "1", "q where the rotation number is proved to be p/q; 0 elsewhere"),
    ),
    "fixed_points": (
        Quantity("fixed_points", "1", "number of fixed points of the map"),
        Quantity("stable_points", "1", "number of stable fixed points"),
        Quantity("fixed_point_theta", "rad", "directions of the fixed points", _FIXED),
        Quantity("fixed_point_multiplier", "1", "multipliers of the fixed points", _FIXED),
        Quantity("fixed_point_stable", "1", "1 where the fixed point is stable", _FIXED),
        Quantity("gathering_jump_theta", "rad", "jumps about which orbits gather", "gathering_jump"),
    ),
    "turns": (
        Quantity("mean_turn", "rad", "turn of a cycle, mean over start directions"),
        Quantity("min_turn", "rad", "least turn of a cycle"),
        Quantity("max_turn", "rad", "largest turn of a cycle"),
        Quantity("min_slope", "1", "least slope of the map"),
        Quantity("max_slope", "1", "largest slope of the map"),
    ),
    "stationary": (
        Quantity("tv_from_uniform", "1", "total variation distance of the stationary law from the uniform one"),
        Quantity("spectral_gap", "1", "one less the second largest eigenvalue's size, not certified"),
        Quantity("mixing_cycles", "cycles", "cycles in which the slowest mode falls by e, not certified"),
    ),
    "staircase": (
        Quantity("noisy_mean_turn", "rad", "turn of a cycle, mean over a long noisy run"),
        Quantity("mean_residence_cycles", "cycles", "mean rest in a slow zone"),
        Quantity("step", "rad", "height of a step of the staircase"),
    ),
}
# What a phase diagram needs; each costs little beside the map.
CHEAP_GROUPS = ("map", "rotation", "fixed_points", "turns")


def chosen_groups(names: tuple[str, ...]) -> tuple[str, ...]:
    """The groups of `names` in their fixed order, with "map", which every other needs; "all" is each of them.

    >>> chosen_groups(("turns", "rotation"))
    ('map', 'rotation', 'turns')
    """
    if not names:
        raise InvalidInput(f"no quantities are asked for: give some of {', '.join(GROUPS)}, or all")
    for name in names:
        if name not in (*GROUPS, "all"):
            raise unknown_name("group of quantities", name, (*GROUPS, "all"))
    return tuple(name for name in GROUPS if name == "map" or name in names or "all" in names)


def quantities_of(groups: tuple[str, ...]) -> tuple[Quantity, ...]:
    """All quantities of some groups."""
    return tuple(quantity for group in groups for quantity in GROUPS[group])
