"""The plan of a sweep: which points, of which loop, and what is asked of each; checked before
anything runs.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Material, load_material
from cyclemap.protocol.settings import loop_from_settings, without_noise
from cyclemap.sweeps.point_sets import (
    FOOTPRINT_KEY,
    MATERIAL_KEY,
    Grid,
    PointSet,
    Sample,
    SweepAxis,
    SweepRange,
    check_key,
    checked_value,
)
from cyclemap.sweeps.portrait_numbers import PortraitNumbers, SweptPoint


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """A sweep: MIT's loop on a material with settings, changed at each point, and the numbers asked
    of it.

    Parameters
    ----------
    points : Grid or Sample
        A `Grid` or a `Sample`.
    material : str or Path or Material or None, optional
        A name, a TOML file or a `Material`; None only where the points name one.
    settings : mapping of str to object, optional
        Of all points, in degrees and millimetres, by the keys of `--set` and `noise_deg`.
    numbers : PortraitNumbers, optional
        What is asked of each point.

    Attributes
    ----------
    materials : mapping of str to Material
        The surfaces, by their names.
    footprint_files : mapping of str to str
        Digests of the files of support points, by their names.

    Raises
    ------
    InvalidInput
        Where a key is unknown, both set and swept, or has a value that it cannot have.

    Notes
    -----
    Whether a point's values go together is found when it runs: its refusal is then part of the
    result.

    Examples
    --------
    >>> from cyclemap import SweepPlan
    >>> plan = SweepPlan.grid("plywood", {"mu_a": (0.2, 0.3), "hitch_x_mm": (-12, -10, -8)})
    >>> len(plan), dict(plan.point(1).settings)
    (6, {'mu_a': 0.2, 'hitch_x_mm': -10.0})
    """

    points: PointSet
    material: str | Path | Material | None = None
    settings: Mapping[str, object] = field(default_factory=dict)
    numbers: PortraitNumbers = PortraitNumbers()
    materials: Mapping[str, Material] = field(init=False)
    footprint_files: Mapping[str, str] = field(init=False)

    def __post_init__(self) -> None:
        if MATERIAL_KEY in self.settings:
            raise InvalidInput("material is no setting: give the material by itself, or sweep it")
        for key in self.settings:
            check_key(key)
        both = next((key for key in self.points.keys if key in self.settings), None)
        if both is not None:
            raise InvalidInput(f"{both} is both set and swept: give it once")
        object.__setattr__(
            self,
            "settings",
            {key: checked_value(key, value) for key, value in self.settings.items()},
        )
        object.__setattr__(self, "materials", self._loaded_materials())
        # What the files hold counts, not their names: points found with other support points are
        # other points.
        swept = _listed_words(self.points, FOOTPRINT_KEY)
        digests = {}
        for name in sorted({str(self.settings.get(FOOTPRINT_KEY, "")), *swept}):
            file = Path(name)
            if file.is_file():
                digests[str(file)] = _digest(file.read_bytes())
        object.__setattr__(self, "footprint_files", digests)
        # Settings with which no loop can be made: not by themselves, nor at the first or the last
        # point.
        material = next(iter(self.materials.values()))
        points = [self.point(index) for index in (0, len(self) - 1)]
        faults = []
        for surface, settings in (
            (material, self.settings),
            *((point.material, point.settings) for point in points),
        ):
            try:
                loop_from_settings(without_noise(settings)[0], CollectionLoop.mit(material=surface))
            except InvalidInput as fault:
                faults.append(fault)
        if len(faults) > len(points):
            raise faults[0]

    @classmethod
    def grid(
        cls,
        material: str | Path | Material | None,
        over: Mapping[str, Sequence[object]],
        settings: Mapping[str, object] | None = None,
        numbers: PortraitNumbers | None = None,
    ) -> "SweepPlan":
        """Return the plan of every combination of the values of some keys, the last key running
        fastest.

        Parameters
        ----------
        material : str or Path or Material or None
            A name, a TOML file or a `Material`; None only where the points name one.
        over : mapping of str to sequence of object
            Values by key, in degrees and millimetres.
        settings : mapping of str to object or None, optional
            Of all points.
        numbers : PortraitNumbers or None, optional
            What is asked of each point.

        Returns
        -------
        SweepPlan
            A plan over a `Grid`.
        """
        axes = tuple(SweepAxis(key, values) for key, values in _listed(over, "values").items())
        return cls(Grid(axes), material, settings or {}, numbers or PortraitNumbers())

    @classmethod
    def sample(
        cls,
        material: str | Path | Material | None,
        over: Mapping[str, tuple[float, float]],
        count: int,
        seed: int = 0,
        sequence: str = "sobol",
        settings: Mapping[str, object] | None = None,
        numbers: PortraitNumbers | None = None,
    ) -> "SweepPlan":
        """Return the plan of points spread over the ranges of some keys.

        Parameters
        ----------
        material : str or Path or Material or None
            A name, a TOML file or a `Material`; None only where the points name one.
        over : mapping of str to tuple[float, float]
            (low, high) by key, in degrees and millimetres.
        count : int
            How many points.
        seed : int, default 0
            Of the points.
        sequence : str, default 'sobol'
            "sobol" or "uniform", as of `Sample`.
        settings : mapping of str to object or None, optional
            Of all points.
        numbers : PortraitNumbers or None, optional
            What is asked of each point.

        Returns
        -------
        SweepPlan
            A plan over a `Sample`.
        """
        ends = _listed(over, "ends")
        uneven = next((key for key, given in ends.items() if len(given) != 2), None)
        if uneven is not None:
            raise InvalidInput(
                f"{uneven} is drawn from {over[uneven]!r}: give its two ends, (low, high)"
            )
        ranges = tuple(SweepRange(key, *given) for key, given in ends.items())
        return cls(
            Sample(ranges, count, seed, sequence),
            material,
            settings or {},
            numbers or PortraitNumbers(),
        )

    @property
    def keys(self) -> tuple[str, ...]:
        """The swept keys."""
        return self.points.keys

    def __len__(self) -> int:
        return len(self.points)

    def point(self, number: int) -> SweptPoint:
        """Return point `number`, counted from 0; InvalidInput for one beyond the last."""
        if whole_number("point", number, least=0) >= len(self):
            raise InvalidInput(f"point is {number}: the plan has points 0 to {len(self) - 1}")
        swept = self.points.settings(number)
        settings = {**self.settings, **swept}
        name = str(settings.pop(MATERIAL_KEY, ""))
        material = self.materials[name]
        numbers = self.numbers
        facts = [_fingerprint(material), settings, numbers.described(), numbers.version]
        file = str(Path(str(settings.get(FOOTPRINT_KEY, ""))))
        if file in self.footprint_files:
            facts.append(self.footprint_files[file])
        digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()
        return SweptPoint(number, digest, material, settings, swept)

    def described(self) -> dict[str, object]:
        """The plan as JSON takes it: what two sweeps must share to share a store."""
        files = {"footprint_files": dict(self.footprint_files)} if self.footprint_files else {}
        return {
            **files,
            "points": self.points.described(),
            "material": {
                name or material.name: _fingerprint(material)
                for name, material in self.materials.items()
            },
            "settings": dict(self.settings),
            "quantities": self.numbers.described(),
            "code": self.numbers.version,
        }

    def _loaded_materials(self) -> dict[str, Material]:
        """The materials by the names that points give them;
        "" is that of points which give none."""
        swept = _listed_words(self.points, MATERIAL_KEY)
        if (self.material is None) == (not swept):
            wanted = "a material: a name, a TOML file, or material=A,B among the swept keys"
            raise InvalidInput(
                "material is both given and swept: give it once" if swept else f"give {wanted}"
            )
        if swept:
            return {name: load_material(name) for name in swept}
        given = self.material
        assert given is not None
        return {"": given if isinstance(given, Material) else load_material(given)}


def _listed(over: object, what: str) -> dict[str, tuple[Any, ...]]:
    if not isinstance(over, Mapping):
        raise InvalidInput(
            f"over must tell the values of each key, as {{'mu_a': (0.2, 0.3)}}, not {over!r}"
        )
    for key, values in over.items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise InvalidInput(f"{key} is {values!r}: give its {what} as a list")
    return {key: tuple(values) for key, values in over.items()}


def _listed_words(points: PointSet, key: str) -> tuple[str, ...]:
    """The words that a swept key takes; () where it is not swept."""
    listed = points.axes if isinstance(points, Grid) else points.ranges
    axis = next((swept for swept in listed if swept.key == key), None)
    return tuple(map(str, axis.values)) if isinstance(axis, SweepAxis) else ()


@lru_cache(maxsize=64)
def _fingerprint(material: Material) -> str:
    """A digest of all that a material says; the repr of a float is exact."""
    return _digest(repr(material).encode())


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]
