"""What recorded strokes are predicted with: the loop with their object, on the floor as it was in
their session, and how the frames of their data are shifted.
"""

from __future__ import annotations

from dataclasses import replace

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import Material, Slider
from cyclemap.mechanics.plate_footprint import plate_footprint


def loop_of_session(loop: CollectionLoop, slider: Slider, session: str = "") -> CollectionLoop:
    """Return the loop with another object, which rests as the material says.

    session : its name. Where the material saw it, the floor is as it was then, without a posterior,
    which is of the mean of sessions.
    """
    material = loop.material
    for seen in material.sessions:
        if seen.name == session:
            material = replace(material, floor=seen.shape, posterior=None)
    footprint = plate_footprint(material, slider)
    return replace(loop, slider=slider, material=material, footprint=footprint)


def frame_shift(material: Material, plate: str) -> tuple[float, float]:
    """Return what to add to the robot's places to have them in the frame of a plate's poses, m."""
    for frame in material.frames:
        if frame.plate == plate:
            return frame.x, frame.y
    return 0.0, 0.0
