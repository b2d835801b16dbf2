"""The materials that a reset must serve: about a nominal one, as far as nobody can know its friction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cyclemap.checks import non_negative_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material
from cyclemap.mechanics.plate_footprint import plate_footprint

AXES, OFFSETS = 0.10, 0.50
# Samples of a posterior, every second of which a reset is searched on.
POSTERIOR_SAMPLES = 24
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


def material_range(material: Material, axes: float | None = None, offsets: float | None = None) -> MaterialRange:
    """Return the nominal material with samples of its posterior, where it has one, else with the corners of a range.

    The samples are 24 (or as many as there are) evenly spaced through the posterior, of one that wears at times evenly
    spaced through its wear. Corners are made where `axes` or `offsets` is given, too; of a surface that wears the worn
    one is among them. Its direction needs no corners: turning it turns the law of the orientations, and no more.

    axes : share by which one half axis may be longer or shorter against the other, in [0, 1), None: 0.1. The ratio runs
    from nominal / (1 + axes) to nominal (1 + axes); their geometric mean, on which no quasi-static motion depends, is
    kept. offsets : share by which m0 and n0 vary, each by itself, None: 0.5; one that is zero stays zero.

    Raises InvalidInput for shares outside these, or where a corner is no friction ellipse.

    >>> from cyclemap.mechanics import load_material
    >>> about = material_range(load_material("plywood"))
    >>> len(about.searched), about.searched[1].name
    (9, 'plywood (axis ratio ÷ 1.1, m0 -50 %, n0 -50 %)')
    """
    if axes is None and offsets is None and material.posterior is not None:
        return _posterior_range(material)
    by_axes = non_negative_number("range of the axes", AXES if axes is None else axes)
    by_offsets = non_negative_number("range of the offsets", OFFSETS if offsets is None else offsets)
    if by_axes >= 1.0:
        raise InvalidInput(f"the axes may vary by less than 100 %, not by {100.0 * by_axes:g} %")
    nominal, law = replace(material, wear=None, posterior=None), material.friction
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


def _posterior_range(material: Material) -> MaterialRange:
    assert material.posterior is not None
    count = len(material.posterior)
    rows = np.unique(np.linspace(0, count - 1, min(POSTERIOR_SAMPLES, count)).round().astype(int)).tolist()
    samples = []
    for place, row in enumerate(rows):
        one = material.sample(row)
        worn = 0.0 if one.wear is None else one.wear.cycles * place / max(len(rows) - 1, 1)
        name = f"{material.name} (sample {row} of its posterior)"
        samples.append(replace(one, name=name, friction=one.friction_after(worn), wear=None))
    told = f"{len(rows)} of the {count} samples of its posterior{'' if material.wear is None else ', fresh to worn'}"
    nominal = replace(material, wear=None, posterior=None)
    return MaterialRange(nominal, tuple(samples[::2]), told, tuple(samples[1::2]))


def on_material(loop: CollectionLoop, material: Material) -> CollectionLoop:
    """Return the loop on another material, which brings what the loop has from its own: `FoundWith` and pressure.

    What was set otherwise, as the friction of another rod, stays. The ring's lever is scaled and turned as it is from
    the one material to the other, wherever the ring is.

    >>> from cyclemap.mechanics import FoundWith, load_material
    >>> slate = replace(load_material("plywood"), name="slate", found_with=FoundWith(pusher_friction=0.2))
    >>> on_material(CollectionLoop.mit("plywood"), slate).pusher.friction
    0.2
    """
    own, other = (CollectionLoop.mit(surface) for surface in (loop.material, material))
    x, y = loop.slider.hitch
    lever = complex(x, y) * complex(*other.slider.hitch) / complex(*own.slider.hitch)
    pusher, reset, footprint = loop.pusher, loop.reset, loop.footprint
    if pusher.friction == own.pusher.friction:
        pusher = replace(pusher, friction=other.pusher.friction)
    if reset.pin_friction_radius == own.reset.pin_friction_radius:
        reset = replace(reset, pin_friction_radius=other.reset.pin_friction_radius)
    if footprint == plate_footprint(loop.material, loop.slider):
        footprint = plate_footprint(material, loop.slider)
    # Their numbers kept to the last bit where the lever is the same.
    slider = loop.slider if own.slider == other.slider else replace(loop.slider, hitch=(lever.real, lever.imag))
    return replace(loop, material=material, slider=slider, pusher=pusher, reset=reset, footprint=footprint)


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
