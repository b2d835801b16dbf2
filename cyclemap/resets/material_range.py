"""The materials that a reset must serve: about a nominal one, as far as nobody can know its
friction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product

import numpy as np

from cyclemap.arrays import Array, evenly_spread
from cyclemap.checks import non_negative_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material

AXES = 0.10
OFFSETS = 0.50
# Samples of a posterior that a reset is searched on, and others that it is judged on: the fewest of
# which the worst is worse than 95 % of the posterior, as surely (.95^59 < .05).
SEARCHED_SAMPLES = 12
JUDGED_SAMPLES = 59
# What is promised of a posterior: this share of it, as surely.
PROMISED = 0.95
# Materials inside the range that what is found is tried on besides the corners.
TRIED_INSIDE = 4


@dataclass(frozen=True)
class MaterialRange:
    """Materials about a nominal one.

    Parameters
    ----------
    nominal : Material
        The first.
    others : tuple of Material
        With it, those that a reset is searched on.
    origin : str, default ''
        In words, where they came from.
    tried : tuple of Material or None, optional
        Those that what is found is tried on besides; None: four between the others, weighted
        means of three drawn ones, the same each time.
    sampled : bool, default False
        Whether those tried are samples, each as likely as another, of what nobody knows better:
        what is told of the worst then holds for 95 % of all that they stand for, else for all
        materials.

    Raises
    ------
    InvalidInput
        For what is no `Material`.

    Examples
    --------
    >>> from cyclemap import load_material
    >>> from cyclemap.resets import MaterialRange
    >>> about = MaterialRange(load_material("plywood"), (load_material("delrin"),))
    >>> [material.name for material in about.searched], len(about.materials)
    (['plywood', 'delrin'], 6)
    """

    nominal: Material
    others: tuple[Material, ...]
    origin: str = field(default="", metadata={"name": "told"})
    tried: tuple[Material, ...] | None = None
    sampled: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "others", tuple(self.others))
        for material in (self.nominal, *self.others, *(self.tried or ())):
            if not isinstance(material, Material):
                raise InvalidInput(
                    "a range is made of materials, as load_material returns them, not of "
                    f"{material!r}"
                )
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

    def worst(self, values: Array) -> int:
        """Return which of `materials` has the worst of their values (n,), of each how far it leaves
        uniform.

        Of a range that is sampled: an order statistic of those tried, below which 95 % of all that
        they are samples of lie with the `confidence` of 95 % (S. S. Wilks, Annals of Mathematical
        Statistics 12 (1941), 91-96); where they are too few for that, the largest of all.
        """
        rank = _safe_rank(len(self.tried or ())) if self.sampled else 0
        if not rank:
            return int(np.argmax(values))
        first = len(self.searched)
        return first + int(np.argsort(values[first:], kind="stable")[rank - 1])

    @property
    def share(self) -> float:
        """Of what the range stands for, the share that is no worse than its `worst`."""
        return PROMISED if self.sampled else 1.0

    @property
    def confidence(self) -> float:
        """How surely that share is no worse, over draws of the samples that were tried."""
        from scipy.stats import binom

        count = len(self.tried or ())
        return (
            float(binom.cdf((_safe_rank(count) or count) - 1, count, PROMISED))
            if self.sampled
            else 1.0
        )


@cache
def _safe_rank(count: int) -> int:
    """The least rank of so many values above which the 95th percentile lies in at most 5 % of all
    draws; 0: none.
    """
    from scipy.stats import binom

    rank = int(binom.ppf(PROMISED, count, PROMISED)) + 1
    return rank if rank <= count else 0


def material_range(
    material: Material, axes: float | None = None, offsets: float | None = None
) -> MaterialRange:
    """Return the nominal material with samples of its posterior, where it has one, else with the
    corners of a range.

    Parameters
    ----------
    material : Material
        The nominal one.
    axes : float or None, optional
        Share by which one half axis may be longer or shorter against the other, in [0, 1),
        None: 0.1. The ratio runs from nominal / (1 + axes) to nominal (1 + axes); their
        geometric mean, on which no quasi-static motion depends, is kept.
    offsets : float or None, optional
        Share by which m0 and n0 vary, each by itself, None: 0.5; one that is zero stays zero.

    Returns
    -------
    MaterialRange
        The nominal one first.

    Raises
    ------
    InvalidInput
        For shares outside these, or where a corner is no friction ellipse.

    Notes
    -----
    It is searched on 12 samples, evenly spaced through the posterior, and tried on 59 others
    (or as many as there are), of one that wears at times evenly spaced through its wear.
    Corners are made where `axes` or `offsets` is given, too; of a surface that wears the worn
    one is among them. Its direction needs no corners: turning it turns the law of the
    orientations, and no more.

    Examples
    --------
    >>> from cyclemap import load_material
    >>> from cyclemap.resets import material_range
    >>> about = material_range(load_material("plywood"))
    >>> len(about.searched), about.searched[1].name
    (9, 'plywood (axis ratio ÷ 1.1, m0 -50 %, n0 -50 %)')
    """
    if axes is None and offsets is None and material.posterior is not None:
        return _posterior_range(material)
    by_axes = non_negative_number("range of the axes", AXES if axes is None else axes)
    by_offsets = non_negative_number(
        "range of the offsets", OFFSETS if offsets is None else offsets
    )
    if by_axes >= 1.0:
        raise InvalidInput(f"the axes may vary by less than 100 %, not by {100.0 * by_axes:g} %")
    nominal = replace(material, wear=None, posterior=None)
    law = material.friction
    ratios = (1.0 / (1.0 + by_axes), 1.0 + by_axes) if by_axes else (1.0,)
    shares = [
        (-by_offsets, by_offsets) if by_offsets and value else (0.0,) for value in (law.m0, law.n0)
    ]
    corners = []
    for ratio, m0, n0 in product(ratios, *shares):
        changes = [f"axis ratio {'÷' if ratio < 1.0 else '×'} {1.0 + by_axes:g}"] if by_axes else []
        changes += [f"{name} {100.0 * by:+.0f} %" for name, by in (("m0", m0), ("n0", n0)) if by]
        if changes:
            friction = replace(stretched(law, ratio), m0=law.m0 * (1 + m0), n0=law.n0 * (1 + n0))
            corners.append(
                replace(nominal, name=f"{material.name} ({', '.join(changes)})", friction=friction)
            )
    if material.wear is not None:
        corners.append(
            replace(nominal, name=f"{material.name} (worn)", friction=material.wear.friction)
        )
    words = f"axis ratio ± {100.0 * by_axes:g} %, offsets ± {100.0 * by_offsets:g} %, any direction"
    return MaterialRange(nominal, tuple(corners), words)


def stretched(law: EllipseFriction, ratio: float) -> EllipseFriction:
    """Return an ellipse whose axes' ratio is so many times larger, their geometric mean kept."""
    root = math.sqrt(ratio)
    return replace(law, mu_a=law.mu_a * root, mu_b=law.mu_b / root)


def range_of(material: Material, given: Sequence[Material] | MaterialRange | None) -> MaterialRange:
    """Return the range that is given, or made of materials; without either that of the material."""
    if given is None:
        return material_range(material)
    if isinstance(given, MaterialRange):
        return given
    return MaterialRange(replace(material, wear=None, posterior=None), tuple(given))


def _posterior_range(material: Material) -> MaterialRange:
    assert material.posterior is not None
    count = len(material.posterior)
    rows = evenly_spread(count, SEARCHED_SAMPLES + JUDGED_SAMPLES)
    samples = []
    for place, row in enumerate(rows):
        sample = material.sample(row)
        worn = 0.0 if sample.wear is None else sample.wear.cycles * place / max(len(rows) - 1, 1)
        name = f"{material.name} (sample {row} of its posterior)"
        samples.append(replace(sample, name=name, friction=sample.friction_after(worn), wear=None))
    chosen = evenly_spread(len(rows), min(SEARCHED_SAMPLES, -(-len(rows) // 2)))
    others = tuple(samples[place] for place in chosen)
    tried = tuple(sample for place, sample in enumerate(samples) if place not in chosen)
    words = (
        f"{len(rows)} of the {count} samples of its "
        f"posterior{'' if material.wear is None else ', fresh to worn'}"
    )
    nominal = replace(material, wear=None, posterior=None)
    return MaterialRange(nominal, others, words, tried, sampled=True)


def _between(materials: Sequence[Material]) -> Iterator[Material]:
    """Materials between some: axes weighed by their logarithms, offsets as they are, the direction
    of one of them.
    """
    random = np.random.default_rng(0)
    for index in range(1, TRIED_INSIDE + 1):
        laws = [
            materials[k].friction
            for k in random.choice(len(materials), min(3, len(materials)), replace=False)
        ]
        shares = random.dirichlet(np.ones(len(laws)))
        a, b = np.exp(shares @ np.log([(law.mu_a, law.mu_b) for law in laws])).tolist()
        m0, n0 = (shares @ [(law.m0, law.n0) for law in laws]).tolist()
        name = f"{materials[0].name}, inside its range ({index})"
        yield replace(materials[0], name=name, friction=EllipseFriction(a, b, m0, n0, laws[0].phi))
