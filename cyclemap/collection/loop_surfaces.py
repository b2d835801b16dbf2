"""A loop on other surfaces: on another material, on one that wears, and its map as that drifts."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, DriftingMap
from cyclemap.mechanics import DragBack, Material, PressedFootprint, Pusher

# Radians: the blend between computed cycles stays this near the map of each cycle.
BLEND_TOLERANCE = 1e-3
# Radians: accuracy of the maps that are blended.
MAP_TOLERANCE = 1e-4


def on_material(loop: CollectionLoop, material: Material) -> CollectionLoop:
    """Return the loop on another material, with what it brings along: `FoundWith` and pressure.

    Parameters
    ----------
    loop : CollectionLoop
        The loop; what it has from its own material gives way.
    material : Material
        The other material, such as a sample of its own one's posterior.

    Returns
    -------
    CollectionLoop
        The same protocol on the other surface.

    Notes
    -----
    What was set otherwise, as the friction of another rod, stays.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from cyclemap import CollectionLoop, load_material
    >>> from cyclemap.mechanics import FoundWith
    >>> from cyclemap.collection import on_material
    >>> found = FoundWith(pusher_friction=0.2)
    >>> slate = replace(load_material("plywood"), name="slate", found_with=found)
    >>> on_material(CollectionLoop.mit("plywood"), slate).pusher.friction
    0.2
    """
    bare = replace(
        loop,
        pusher=replace(loop.pusher, friction=Pusher().friction),
        reset=replace(loop.reset, pin_friction_radius=DragBack().pin_friction_radius),
        footprint=None,
    )
    before = bare.with_material(loop.material)
    after = bare.with_material(material)
    brought = {
        name: getattr(after, name)
        for name in ("pusher", "reset", "footprint")
        if _alike(getattr(before, name), getattr(loop, name))
    }
    return replace(loop, material=material, **brought)


def _alike(first: object, second: object) -> bool:
    """Whether parts of a loop are the same, shapes but for the rounding of an object's weight."""
    if isinstance(first, PressedFootprint) and isinstance(second, PressedFootprint):
        return first.outline == second.outline and first.is_near(second)
    return first == second


def worn_loop(loop: CollectionLoop, cycles: float) -> CollectionLoop:
    """Return the loop on its surface as it is after a number of cycles, from there on unchanging.

    Parameters
    ----------
    loop : CollectionLoop
        The loop; where its surface does not wear, it is returned as it is.
    cycles : float
        How many cycles were made on the surface, 0 or more.

    Returns
    -------
    CollectionLoop
        The loop on the worn surface.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, worn_loop
    >>> loop = CollectionLoop.mit()
    >>> worn_loop(loop, 1000.0) == loop
    True
    """
    material = loop.material
    if material.wear is None:
        return loop
    worn = replace(
        material,
        friction=material.friction_after(cycles),
        floor=material.floor_after(cycles),
        wear=None,
        posterior=None,
    )
    return on_material(loop, worn)


def drifting_map(
    loop: CollectionLoop,
    cycles: int,
    tolerance: float = BLEND_TOLERANCE,
    progress: Callable[[int], None] | None = None,
) -> DriftingMap:
    """Return the cycle map as the surface wears, over cycles 0 ... cycles - 1.

    Parameters
    ----------
    loop : CollectionLoop
        The loop, on a material that wears.
    cycles : int
        How many cycles.
    tolerance : float, optional
        Error of the blend between the maps that are computed, rad.
    progress : callable or None, optional
        Called with the number of maps computed so far.

    Returns
    -------
    DriftingMap
        The maps, and how they are blended.

    Raises
    ------
    InvalidInput
        Where the material does not wear.

    Examples
    --------
    >>> import cyclemap as cm
    >>> wear = cm.mechanics.Wear(cm.EllipseFriction.isotropic(0.2), cycles=10.0)
    >>> slate = cm.Material("slate", cm.EllipseFriction.isotropic(0.25), wear=wear)
    >>> drifting = cm.collection.drifting_map(cm.CollectionLoop.mit(slate), cycles=10)
    >>> drifting.max_error < 1e-3
    True
    """
    if loop.material.wear is None:
        raise InvalidInput(
            f"{loop.material.name} does not wear: its file has no table [worn]; use its "
            "circle_map()"
        )
    wear = loop.material.wear
    count = whole_number("cycles", cycles, least=1)
    done = [0]
    # The way is blended, then gone through at the pace of the course: kinks of the course cost no
    # maps.
    first = wear.share(0.0)
    last = wear.share(count - 1.0)
    even = replace(loop, material=replace(loop.material, wear=replace(wear, cycles=1.0, course=())))

    def at(share: float) -> CircleMap:
        made = worn_loop(even, share).circle_map(MAP_TOLERANCE)
        done[0] += 1
        if progress is not None:
            progress(done[0])
        return made

    steps = count if last > first else 1
    blend = DriftingMap.of_family(at, np.linspace(first, last, steps), steps, tolerance)
    shares = first + (last - first) * blend.cycles / max(steps - 1, 1)
    bends = [
        (0.0, first),
        *((n, gone) for n, gone in wear.course if 0.0 < n < count - 1.0),
        (count - 1.0, last),
    ]
    knots: dict[float, CircleMap] = {}
    for (begin, low), (end, high) in pairwise(bends):
        for n, share in ((begin, low), (end, high)):
            knots.setdefault(n, blend.at((share - first) / max(last - first, 1e-300) * (steps - 1)))
        for share, worn in zip(shares, blend.maps, strict=True):
            if low < share < high:
                knots.setdefault(begin + (end - begin) * float((share - low) / (high - low)), worn)
    order = sorted(knots)
    return DriftingMap(np.array(order), tuple(knots[n] for n in order), blend.max_error)
