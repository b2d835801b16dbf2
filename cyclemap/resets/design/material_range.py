"""The materials that a reset must serve: about a nominal one, as far as nobody can know its friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cyclemap.checks import non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material

AXES, OFFSETS = 0.10, 0.50
# Materials inside the range that a chosen reset is tried on besides the corners.
TRIED_INSIDE = 4


@dataclass(frozen=True)
class MaterialRange:
    """Materials about a nominal one.

    nominal : the first. others : the rest. told : in words, where they came from.
    """

    nominal: Material
    others: tuple[Material, ...]
    told: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "others", tuple(self.others))
        for material in (self.nominal, *self.others):
            if not isinstance(material, Material):
                raise InvalidInput(f"a range is made of materials, as load_material returns them, not of {material!r}")

    @property
    def materials(self) -> tuple[Material, ...]:
        """The nominal one first."""
        return (self.nominal, *self.others)

    def inside(self) -> tuple[Material, ...]:
        """Return materials between the nominal one and the others: weighted means of three drawn ones, seeded."""
        random, made = np.random.default_rng(0), []
        for number in range(TRIED_INSIDE if self.others else 0):
            chosen = random.choice(len(self.materials), min(3, len(self.materials)), replace=False)
            shares = random.dirichlet(np.ones(len(chosen)))
            laws = [self.materials[index].friction for index in chosen]
            name = f"{self.nominal.name}, inside its range ({number + 1})"
            made.append(replace(self.nominal, name=name, friction=_between(laws, shares.tolist())))
        return tuple(made)


def material_range(material: Material, axes: float = AXES, offsets: float = OFFSETS) -> MaterialRange:
    """Return the nominal material and the corners of its range, its wear left out.

    The direction of the surface needs no corners: turning it turns the law of the orientations, and no more.

    axes : share by which one half axis may be longer or shorter against the other, in [0, 1): the ratio runs from
    nominal / (1 + axes) to nominal (1 + axes); their geometric mean, on which no quasi-static motion depends, is
    kept. offsets : share by which m0 and n0 vary, each by itself; one that is zero stays zero.

    Raises InvalidInput for shares outside these, or where a corner is no friction ellipse.

    >>> from cyclemap.mechanics import load_material
    >>> about = material_range(load_material("plywood"))
    >>> len(about.materials), about.materials[1].name
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
    words = f"axis ratio ± {100.0 * by_axes:g} %, offsets ± {100.0 * by_offsets:g} %, any direction"
    return MaterialRange(nominal, tuple(corners), words)


def _between(laws: Sequence[EllipseFriction], shares: Sequence[float]) -> EllipseFriction:
    """A friction ellipse between some: axes by their logarithms, offsets as they are, the direction of the first."""
    weigh = list(zip(shares, laws, strict=True))
    return EllipseFriction(
        math.exp(sum(share * math.log(law.mu_a) for share, law in weigh)),
        math.exp(sum(share * math.log(law.mu_b) for share, law in weigh)),
        sum(share * law.m0 for share, law in weigh),
        sum(share * law.n0 for share, law in weigh),
        laws[0].phi,
    )
