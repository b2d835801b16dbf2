"""A loop with what was identified along with its surface: pusher friction, pressure, the ring's lever and friction."""

from dataclasses import replace
from typing import TYPE_CHECKING

from cyclemap.mechanics import FoundWith, PatchFootprint, Pose, Slider

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop


def with_found(loop: "CollectionLoop", found: FoundWith) -> "CollectionLoop":
    """Return the loop with all that is not None in `found`.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> with_found(CollectionLoop.mit(), FoundWith(pusher_friction=0.2)).pusher.friction
    0.2
    """
    if found.pusher_friction is not None:
        loop = replace(loop, pusher=replace(loop.pusher, friction=found.pusher_friction))
    if found.hitch_scale is not None or found.hitch_turn is not None:
        loop = replace(loop, slider=_with_lever(loop.slider, found.hitch_scale, found.hitch_turn or 0.0))
    shares = {name: getattr(found, name) for name in ("inner_share", "rim_share", "corner_share")}
    if any(value is not None for value in shares.values()):
        given = {name: value or 0.0 for name, value in shares.items()}
        footprint = PatchFootprint(loop.slider.outline, **given, centre=loop.slider.centre_of_mass)
        loop = replace(loop, footprint=footprint)
    if found.pin_friction_radius is not None:
        loop = replace(loop, reset=replace(loop.reset, pin_friction_radius=found.pin_friction_radius))
    return loop


def _with_lever(slider: Slider, scale: float | None, turn: float) -> Slider:
    factor = 1.0 if scale is None else scale
    x, y = Pose(theta=turn).to_world(*slider.hitch)
    return replace(slider, hitch=(factor * x, factor * y))
