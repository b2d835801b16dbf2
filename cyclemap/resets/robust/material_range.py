"""Ranges of materials about a nominal one: axis ratio, offset, direction, and the rod's friction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, non_negative_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, Pusher
from cyclemap.resets.robust.sampled_materials import INDEPENDENT, SOBOL, SampledMaterials, unit_points

Array = NDArray[np.float64]

ANY = "any"
_RATIO, _M0, _N0, _ROD, _PHI = "ratio", "m0", "n0", "pusher_friction", "phi"
_DIRECTIONS = 4  # of the surface at which a scenario is taken, where its direction matters
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class MaterialRange:
    """All materials about a nominal one; each of what varies does so on its own, evenly.

    Parameters
    ----------
    material : the nominal one, with what was found with it; its wear is left out.
    ratio : share, in [0, 1), by which the axis ratio mu_a/mu_b varies: from (1 - ratio) to (1 + ratio) times
        nominal. The geometric mean sqrt(mu_a mu_b), on which no quasi-static motion depends, is kept, so that offsets
        stay the same share of it.
    offset : share, 0 or more, by which m0 and n0 vary, each by itself; one that is zero stays zero.
    phi : "any", or the half-width (rad, up to pi) of the surface's direction about the nominal one.
    pusher_friction : share, in [0, 1], by which the friction of rod and object varies about that found with the
        material (`Pusher`'s where none was).

    Raises InvalidInput for a value outside these, and where some material of the range is no friction ellipse.

    >>> from cyclemap.mechanics import load_material
    >>> about = MaterialRange(load_material("plywood"))
    >>> about.names, len(about.scenarios()), len(about.without_direction().scenarios())
    (('ratio', 'm0', 'n0', 'phi'), 36, 9)
    """

    material: Material
    ratio: float = 0.10
    offset: float = 0.50
    phi: float | str = ANY
    pusher_friction: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise InvalidInput(f"the nominal material is {self.material!r}: give a Material, as load_material does")
        for name, most in (("ratio", 1.0), ("offset", math.inf), ("pusher_friction", math.inf)):
            share = non_negative_number(f"share of {name}", getattr(self, name))
            object.__setattr__(self, name, share)
            if share >= most or (name == _ROD and share > 1.0):
                raise InvalidInput(f"share of {name} is {share:g}: what varies must keep its sign; choose less than 1")
        if self.phi != ANY:
            object.__setattr__(self, "phi", non_negative_number("range of phi", self.phi))
            if self.half_turn > math.pi:
                raise InvalidInput(f"range of phi is {self.phi} rad: give {ANY!r} for every direction")
        for corner in product((-1.0, 1.0), repeat=len(self.names)):
            self.at(corner)

    @property
    def half_turn(self) -> float:
        """Half-width of the range of phi, rad."""
        return math.pi if isinstance(self.phi, str) else self.phi

    @property
    def names(self) -> tuple[str, ...]:
        """What varies, in the order of the coordinates of `at`; phi is the last."""
        law = self.material.friction
        varies = {
            _RATIO: self.ratio > 0.0,
            _M0: self.offset > 0.0 and law.m0 != 0.0,
            _N0: self.offset > 0.0 and law.n0 != 0.0,
            _ROD: self.pusher_friction > 0.0,
            _PHI: self.half_turn > 0.0,
        }
        return tuple(name for name, does in varies.items() if does)

    def at(self, point: ArrayLike) -> Material:
        """Return the material at a point (d,) of the cube [-1, 1]^d, zero being nominal, in the order of `names`.

        >>> from cyclemap.mechanics import load_material
        >>> law = MaterialRange(load_material("plywood"), offset=0.0, phi=0.0).at([1.0]).friction
        >>> round(law.mu_a / law.mu_b / (0.2545 / 0.2346), 12), round(law.mu_a * law.mu_b / (0.2545 * 0.2346), 12)
        (1.1, 1.0)
        """
        place = finite_array("point of the range", point, ndim=1)
        if place.size != len(self.names) or np.any(np.abs(place) > 1.0):
            raise InvalidInput(f"a point of this range has {len(self.names)} coordinates in [-1, 1], not {point!r}")
        if not np.any(place):
            return replace(self.material, wear=None)
        share = dict(zip(self.names, place.tolist(), strict=True))
        told = ", ".join(self._told(name, by) for name, by in share.items())
        found = self.material.found_with
        if _ROD in share:
            rod = Pusher().friction if found.pusher_friction is None else found.pusher_friction
            found = replace(found, pusher_friction=rod * (1.0 + self._step(_ROD, share[_ROD])))
        name = f"{self.material.name} ({told})"
        return replace(self.material, name=name, friction=self._friction(share), found_with=found, wear=None)

    def sampled(self, count: int, seed: int = 0, draw: str = SOBOL) -> SampledMaterials:
        """Return `count` materials: the nominal one, the corners (of all but phi), then points drawn evenly.

        draw : `sobol`, scrambled and evenly spread, or `independent`. Where there is no room for all corners the
        first of them are taken. Corners have directions spread over the range of phi.
        """
        known = self._chosen()[: whole_number("count", count, least=1)]
        drawn = 2.0 * unit_points(count - len(known), len(self.names), seed, draw) - 1.0
        return self._materials(np.concatenate([known, drawn]), len(known), draw == INDEPENDENT)

    def scenarios(self) -> SampledMaterials:
        """Return the nominal material and the corners, each in four directions where phi varies."""
        known = self._chosen()
        if _PHI in self.names:
            places = 2.0 * np.arange(_DIRECTIONS) / _DIRECTIONS if self.half_turn == math.pi else np.linspace(-1, 1, 3)
            known = np.repeat(known, places.size, axis=0)
            known[:, -1] = np.tile(np.where(places > 1.0, places - 2.0, places), len(known) // places.size)
            known = known[np.argsort(np.any(known != 0.0, axis=1), kind="stable")]
        return self._materials(known, len(known), False)

    def without_direction(self) -> MaterialRange:
        """Return the same range with phi nominal."""
        return replace(self, phi=0.0)

    def _chosen(self) -> Array:
        """The centre and the corners of all but phi, whose directions go on by the golden ratio: (k, d)."""
        free = [name for name in self.names if name != _PHI]
        corners = list(product((-1.0, 1.0), repeat=len(free))) if free else []
        points = np.zeros((1 + len(corners), len(self.names)))
        points[1:, : len(free)] = np.reshape(corners, (len(corners), len(free)))
        if _PHI in self.names:
            points[:, -1] = (2.0 * _GOLDEN * np.arange(len(points)) + 1.0) % 2.0 - 1.0
        return points

    def _materials(self, points: Array, chosen: int, independent: bool) -> SampledMaterials:
        made = tuple(self.at(point) for point in points)
        return SampledMaterials(made, points, self.names, chosen, independent, cube=True)

    def _friction(self, share: dict[str, float]) -> EllipseFriction:
        law = self.material.friction
        mean, ratio = math.sqrt(law.mu_a * law.mu_b), law.mu_a / law.mu_b
        ratio *= 1.0 + self._step(_RATIO, share.get(_RATIO, 0.0))
        m0 = law.m0 * (1.0 + self._step(_M0, share.get(_M0, 0.0)))
        n0 = law.n0 * (1.0 + self._step(_N0, share.get(_N0, 0.0)))
        phi = law.phi + self._step(_PHI, share.get(_PHI, 0.0))
        return EllipseFriction(mean * math.sqrt(ratio), mean / math.sqrt(ratio), m0, n0, phi)

    def _step(self, name: str, by: float) -> float:
        """The change of a coordinate at `by`, in [-1, 1]: a share; of phi, rad."""
        width = {_RATIO: self.ratio, _M0: self.offset, _N0: self.offset, _ROD: self.pusher_friction}
        return by * width.get(name, self.half_turn)

    def _told(self, name: str, by: float) -> str:
        step = self._step(name, by)
        return f"phi {math.degrees(step):+.1f} deg" if name == _PHI else f"{name} {100.0 * step:+.1f} %"
