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
    pressure = found.rim_share, found.warp_a, found.warp_b
    if any(value is not None for value in pressure):
        share, *warp = (0.0 if value is None else value for value in pressure)
        assert loop.slider.centre_of_mass is not None
        footprint = PatchFootprint.under(loop.slider.outline, loop.slider.centre_of_mass, share, (warp[0], warp[1]))
        loop = replace(loop, footprint=footprint)
    if found.pin_friction_radius is not None:
        loop = replace(loop, reset=replace(loop.reset, pin_friction_radius=found.pin_friction_radius))
    return loop


def _with_lever(slider: Slider, scale: float | None, turn: float) -> Slider:
    factor = 1.0 if scale is None else scale
    x, y = Pose(theta=turn).to_world(*slider.hitch)
    return replace(slider, hitch=(factor * x, factor * y))
