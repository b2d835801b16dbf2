"""The materials that a reset must serve: about a nominal one, as far as nobody can know its friction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cyclemap.checks import non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material

AXES, OFFSETS = 0.10, 0.50
# Materials inside the range that what is found is tried on besides the corners.
TRIED_INSIDE = 4


@dataclass(frozen=True)
class MaterialRange:
    """Materials about a nominal one.

    nominal : the first. others : with it, those that a reset is searched on. told : in words, where they came from.
    tried : those that what is found is tried on besides; None: four between the others, weighted means of three drawn
    ones, the same each time.
    """

    nominal: Material
    others: tuple[Material, ...]
    told: str = ""
    tried: tuple[Material, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "others", tuple(self.others))
        for material in (self.nominal, *self.others, *(self.tried or ())):
            if not isinstance(material, Material):
                raise InvalidInput(f"a range is made of materials, as load_material returns them, not of {material!r}")
        if self.tried is None:
            object.__setattr__(self, "tried", tuple(_between(self.searched)) if self.others else ())

    @property
    def searched(self) -> tuple[Material, ...]:
        """Those that a reset is searched on, the nominal one first."""
        return (self.nominal, *self.others)

    @property
    def materials(self) -> tuple[Material, ...]:
        """All of them, the nominal one first."""
        return (*self.searched, *(self.tried or ()))


def material_range(material: Material, axes: float = AXES, offsets: float = OFFSETS) -> MaterialRange:
    """Return the nominal material and the corners of its range; of one that wears also the worn one.

    The direction of the surface needs no corners: turning it turns the law of the orientations, and no more.

    axes : share by which one half axis may be longer or shorter against the other, in [0, 1): the ratio runs from
    nominal / (1 + axes) to nominal (1 + axes); their geometric mean, on which no quasi-static motion depends, is
    kept. offsets : share by which m0 and n0 vary, each by itself; one that is zero stays zero.

    Raises InvalidInput for shares outside these, or where a corner is no friction ellipse.

    >>> from cyclemap.mechanics import load_material
    >>> about = material_range(load_material("plywood"))
    >>> len(about.searched), about.searched[1].name
    (9, 'plywood (axis ratio ÷ 1.1, m0 -50 %, n0 -50 %)')
    """
    by_axes, by_offsets = non_negative_number("range of the axes", axes), non_negative_number("of offsets", offsets)
    if by_axes >= 1.0:
        raise InvalidInput(f"the axes may vary by less than 100 %, not by {100.0 * by_axes:g} %")
    nominal, law = replace(material, wear=None), material.friction
    ratios = (1.0 / (1.0 + by_axes), 1.0 + by_axes) if by_axes else (1.0,)
    shares = [(-by_offsets, by_offsets) if by_offsets and value else (0.0,) for value in (law.m0, law.n0)]
    corners = []
    for ratio, m0, n0 in product(ratios, *shares):
        told = [f"axis ratio {'÷' if ratio < 1.0 else '×'} {1.0 + by_axes:g}"] if by_axes else []
        told += [f"{name} {100.0 * by:+.0f} %" for name, by in (("m0", m0), ("n0", n0)) if by]
        if told:
            root = math.sqrt(ratio)
            friction = replace(
                law, mu_a=law.mu_a * root, mu_b=law.mu_b / root, m0=law.m0 * (1 + m0), n0=law.n0 * (1 + n0)
            )
            corners.append(replace(nominal, name=f"{material.name} ({', '.join(told)})", friction=friction))
    if material.wear is not None:
        corners.append(replace(nominal, name=f"{material.name} (worn)", friction=material.wear.friction))
    words = f"axis ratio ± {100.0 * by_axes:g} %, offsets ± {100.0 * by_offsets:g} %, any direction"
    return MaterialRange(nominal, tuple(corners), words)


def _between(materials: Sequence[Material]) -> Iterator[Material]:
    """Materials between some: axes weighed by their logarithms, offsets as they are, the direction of one of them."""
    random = np.random.default_rng(0)
    for number in range(1, TRIED_INSIDE + 1):
        laws = [materials[k].friction for k in random.choice(len(materials), min(3, len(materials)), replace=False)]
        shares = random.dirichlet(np.ones(len(laws)))
        a, b = np.exp(shares @ np.log([(law.mu_a, law.mu_b) for law in laws])).tolist()
        m0, n0 = (shares @ [(law.m0, law.n0) for law in laws]).tolist()
        name = f"{materials[0].name}, inside its range ({number})"
        yield replace(materials[0], name=name, friction=EllipseFriction(a, b, m0, n0, laws[0].phi))
