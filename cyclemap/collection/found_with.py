"""A loop on a material, with what was identified along with it: rod, ring, and how the object presses on it."""

from dataclasses import replace
from typing import TYPE_CHECKING

from cyclemap.mechanics import Footprint, Material, PatchFootprint, Slider

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop


def with_material(loop: "CollectionLoop", material: Material) -> "CollectionLoop":
    """Return the loop on a material, with all that is not None in its `found_with` and its plate's pressure."""
    found = material.found_with
    loop = replace(loop, material=material)
    if found.pusher_friction is not None:
        loop = replace(loop, pusher=replace(loop.pusher, friction=found.pusher_friction))
    if found.pin_friction_radius is not None:
        loop = replace(loop, reset=replace(loop.reset, pin_friction_radius=found.pin_friction_radius))
    pressure = plate_footprint(material, loop.slider)
    return loop if pressure is None else replace(loop, footprint=pressure)


def plate_footprint(material: Material, slider: Slider) -> Footprint | None:
    """Return how an object presses on a material that knows its plate by the object's name; None where it does not."""
    known = material.pressure_of(slider.name)
    if known is None:
        return None
    return PatchFootprint(slider.outline, **known.shares, centre=slider.centre_of_mass)


def sampled_loop(loop: "CollectionLoop", number: int) -> "CollectionLoop":
    """Return the loop on one sample of its material's posterior; what was set otherwise than by the material stays.

    Raises InvalidInput where there is no such sample.
    """
    stated, sample = loop.material, loop.material.sample(number)
    bare = replace(loop, footprint=None)
    before, after = with_material(bare, stated), with_material(bare, sample)
    parts = {
        name: getattr(after, name)
        for name in ("pusher", "reset", "footprint")
        if getattr(before, name) == getattr(loop, name)
    }
    return replace(loop, material=sample, **parts)
