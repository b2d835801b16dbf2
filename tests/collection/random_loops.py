"""Loops drawn at random from everything that can be asked for, seeded, and what becomes of their
cycles.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.collection import CollectionLoop, Cycle
from cyclemap.errors import CycleMapError, InvalidInput, TooManySteps, UnsupportedContact
from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    DragBack,
    Ellipse,
    EllipseFriction,
    Material,
    PointFootprint,
    Polygon,
    Pusher,
    SidePush,
    Slider,
    corner_footprint,
    grid_footprint,
)

# Refusals that say what the model does not describe, or what its explicit steps are too many for.
STATED = (InvalidInput, UnsupportedContact, TooManySteps)
# Every so many-th object has one of these shapes; the others are MIT's.
SHAPES = 10
SHARES = ("inner_share", "rim_share", "corner_share")


@dataclass(frozen=True)
class Fate:
    """What became of a loop's cycle from an orientation: done, or what refused it."""

    loop: CollectionLoop
    theta: float
    refusal: CycleMapError | None

    @property
    def word(self) -> str:
        """Done, refused, or failed."""
        return (
            "done"
            if self.refusal is None
            else "refused"
            if isinstance(self.refusal, STATED)
            else "failed"
        )


def random_object(rng: np.random.Generator, number: int) -> CollectionLoop:
    """A loop of an object: MIT's shapes and others in turn, from 1 mm to 1 m, its weight spread
    somehow.
    """
    slider = (
        Slider.mit(MIT_SHAPE_NAMES[number // 2 % SHAPES])
        if number % 2
        else Slider(_outline(rng, number // 2))
    )
    if rng.uniform() < 0.3:
        slider = replace(
            slider, outline=slider.outline.scaled(10 ** rng.uniform(-1.5, 1.0)), centre_of_mass=None
        )
    loop = replace(CollectionLoop.mit(), slider=slider)
    if rng.uniform() < 0.3:
        loop = _leaning(loop, rng)
    if rng.uniform() < 0.25:
        loop = _framed(loop, rng)
    return replace(loop, footprint=_points(loop, rng)) if number % 16 == 15 else loop


def _outline(rng: np.random.Generator, number: int) -> Polygon | Ellipse:
    size, thin = 0.05, 10 ** rng.uniform(-1.0, 0.0)
    kind = number % 6
    if kind == 0:
        return Ellipse(size, size)
    if kind == 1:
        return Ellipse(size, size * thin)
    if kind == 2:
        x, y = size, size * thin
        return Polygon(((x, y), (-x, y), (-x, -y), (x, -y)))
    if kind == 3:
        angles = np.arange(5) * 2.0 * math.pi / 5.0 + rng.uniform(0.0, 2.0 * math.pi)
        radii = np.array([1.0, 1.0, 0.15, 1.0, 1.0])
    else:
        angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, int(rng.integers(3, 9))))
        radii = 1.0
    points = size * np.stack(
        [radii * np.cos(angles), max(thin, 0.3) * radii * np.sin(angles)], axis=-1
    )
    try:
        polygon = Polygon(tuple(map(tuple, points)))
    except InvalidInput:
        return _outline(rng, number)
    return polygon if polygon.area > 1e-2 * size**2 else _outline(rng, number)


def _as_far_as_it_stands(
    loop: CollectionLoop, change: Callable[[float], CollectionLoop], reach: float
):
    """The loop changed by less and less, until it stands."""
    for _ in range(40):
        try:
            moved = change(reach)
            assert moved.model.pressure
            return moved
        except InvalidInput:
            reach *= 0.7
    return loop


def _leaning(loop: CollectionLoop, rng: np.random.Generator) -> CollectionLoop:
    """Its centre of mass off the centroid."""

    def moved(reach: float) -> CollectionLoop:
        away = rng.uniform(-1.0, 1.0, 2) * reach * loop.slider.outline.extent
        centre = tuple(loop.slider.outline.centroid + away)
        return replace(loop, slider=replace(loop.slider, centre_of_mass=centre))

    return _as_far_as_it_stands(loop, moved, 10.0)


def _framed(loop: CollectionLoop, rng: np.random.Generator) -> CollectionLoop:
    """More weight inside, at the rim and at the corners."""
    under = loop.model.pressure
    names = SHARES[:2] if isinstance(under.outline, Ellipse) else SHARES

    def pressed(reach: float) -> CollectionLoop:
        shares = reach * rng.dirichlet(np.full(len(names) + 1, 0.7))[:-1]
        return replace(
            loop, footprint=replace(under, **dict(zip(names, shares.tolist(), strict=True)))
        )

    return _as_far_as_it_stands(loop, pressed, 1.0)


def _points(loop: CollectionLoop, rng: np.random.Generator) -> PointFootprint:
    """A grid, the corners, or from two to six points anywhere under the object whose loads differ
    up to 1000 to 1.
    """
    outline, kind = loop.slider.outline, rng.integers(3)
    if kind == 0:
        return grid_footprint(outline, int(rng.integers(3, 13)))
    if kind == 1 and isinstance(outline, Polygon):
        return corner_footprint(outline)
    points = (
        rng.uniform(-0.7, 0.7, (int(rng.integers(2, 7)), 2)) * outline.extent + outline.centroid
    )
    return PointFootprint(
        tuple(map(tuple, points)), tuple(10 ** rng.uniform(-3.0, 0.0, len(points)))
    )


def random_loop(rng: np.random.Generator, base: CollectionLoop) -> CollectionLoop:
    """The loop of an object with everything else drawn: surface, rod, push, ring, way back,
    accuracy.
    """
    size, outline = base.slider.outline.extent, base.slider.outline
    away, ring = (
        rng.uniform(0.0, 2.0 * math.pi),
        size * (0.0 if rng.uniform() < 0.02 else 10 ** rng.uniform(-2.0, 1.0)),
    )
    hitch = outline.centroid + ring * np.array((math.cos(away), math.sin(away)))
    radius = 0.0 if rng.uniform() < 0.03 else size * 10 ** rng.uniform(-2.0, 0.5)
    friction = rng.choice([0.0, rng.uniform(), 10 ** rng.uniform(0.0, 0.7)], p=[0.1, 0.7, 0.2])
    ways = tuple(map(tuple, rng.uniform(-3.0, 3.0, (int(rng.choice([0, 0, 0, 1, 3])), 2)) * size))
    # Up to twice the ring's lever: a turn may end on its way, as `drag` tells.
    lever = math.hypot(*np.subtract(hitch, base.model.pressure.centre))
    pin = 0.0 if rng.uniform() < 0.6 else lever * 10 ** rng.uniform(-2.0, 0.3)
    return replace(
        base,
        slider=replace(base.slider, hitch=tuple(hitch)),
        material=Material("drawn", random_law(rng)),
        pusher=Pusher(radius, float(friction)),
        push=_push(rng, outline.sides, size),
        reset=DragBack(ways, pin),
        accuracy=10.0 ** rng.uniform(-11.0, -2.0),
    )


def _push(rng: np.random.Generator, sides: int, size: float) -> SidePush:
    fraction = float(rng.integers(2)) if rng.uniform() < 0.1 else rng.uniform()
    widest = 89.9 if rng.uniform() < 0.2 else 60.0
    angle, distance = (
        math.radians(rng.uniform(-widest, widest)),
        size * 10 ** rng.uniform(-1.5, 1.0),
    )
    return SidePush(int(rng.integers(sides)), fraction, angle, distance)


def random_law(rng: np.random.Generator) -> EllipseFriction:
    """Isotropic, or axes up to ten to one; its centre out to 95 % of the ellipse; in any direction.

    From about fifty to one objects turn so abruptly towards the easy direction that explicit steps
    become too many.
    """
    widest = math.log(rng.choice([1.0, 3.0, 10.0], p=[0.15, 0.45, 0.4]))
    mean, ratio = 10 ** rng.uniform(-2.0, 0.3), math.exp(rng.uniform(-widest, widest) / 2.0)
    off = 0.0 if rng.uniform() < 0.2 else 0.95 * math.sqrt(rng.uniform())
    towards, mu_a, mu_b = rng.uniform(0.0, 2.0 * math.pi), mean * ratio, mean / ratio
    centre = off * mu_a * math.cos(towards), off * mu_b * math.sin(towards)
    return EllipseFriction(mu_a, mu_b, *centre, rng.uniform(0.0, 2.0 * math.pi))


def fates(seed: int, number: int, count: int) -> list[Fate]:
    """What becomes of `count` cycles of loops of one object."""
    rng = np.random.default_rng([seed, number])
    base = random_object(rng, number)
    loops = [random_loop(rng, base) for _ in range(count)]
    theta = rng.uniform(-10.0, 10.0, count)
    return [
        Fate(loop, at, _refusal(loop, at)) for loop, at in zip(loops, theta.tolist(), strict=True)
    ]


def _refusal(loop: CollectionLoop, theta: float) -> CycleMapError | None:
    try:
        cycle = loop.cycle(theta)
    except CycleMapError as refusal:
        return refusal
    assert np.isfinite(
        (cycle.push_turn, *cycle.push_displacement, cycle.drag_turn, cycle.drag_length)
    ).all()
    return None


def worst_residual(cycle: Cycle) -> float:
    """Largest residual along a cycle, of the balance of forces and of the friction cone, relative
    to the friction.
    """
    strokes = [cycle.push, *([cycle.drag] if cycle.drag_length > 0.0 else [])]
    return max(stroke.trajectory.residual for stroke in strokes)
