"""Pushing and dragging under anisotropic friction, quasi-static and dynamic; knows no circle map.

Objects
-------
Slider : a flat object: outline, mass, centre, ring; by name those of the MIT push dataset
Polygon, Ellipse : outlines
MIT_SHAPE_NAMES, MIT_HITCH : the names, and the place of the ring, of MIT's objects

Friction and pressure
---------------------
EllipseFriction, worn_friction : friction of a point; between fresh and worn
Footprint, PatchFootprint, PointFootprint : how the load is spread, exactly or over points
SurfaceShape, FloorField, PressedFootprint, resting_pressure : plates and floors that are not flat,
    and where one rests on the other
grid_footprint, corner_footprint : footprints of points, by their count or on the corners
load_footprint, parse_footprint : footprints from a file, or by a word
LimitSurface : friction of a whole footprint; dissipation, wrench and twist

Materials
---------
Material, load_material, material_names, material_toml : a surface, read and written
Wear, CycleNoise : how it changes, and how cycles on it scatter
FoundWith, PlatePressure, FrameShift, MaterialPosterior : what was identified along with it

Motion
------
Pose, Pusher : place and orientation; the rod
SidePush, WorldPush, DragBack : what the rod does: push a side, push in the world, drag by the ring
QuasiStaticModel, PushResult, DragResult, Trajectory : friction balances the rod at every instant
DynamicModel, DynamicPush, DynamicDrag, DynamicTrajectory : with inertia and a stiff contact
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time names are imported when first used.
    from cyclemap.mechanics.dynamic_model import DynamicModel
    from cyclemap.mechanics.footprint import (
        Footprint,
        PatchFootprint,
        PointFootprint,
        corner_footprint,
        grid_footprint,
        load_footprint,
        parse_footprint,
    )
    from cyclemap.mechanics.foundation import FloorField, PressedFootprint, SurfaceShape
    from cyclemap.mechanics.friction import EllipseFriction, LimitSurface, worn_friction
    from cyclemap.mechanics.material import (
        CycleNoise,
        FoundWith,
        FrameShift,
        Material,
        MaterialPosterior,
        PlatePressure,
        Wear,
    )
    from cyclemap.mechanics.material_text import load_material, material_names, material_toml
    from cyclemap.mechanics.outline import Ellipse, Polygon
    from cyclemap.mechanics.quasi_static import QuasiStaticModel
    from cyclemap.mechanics.resting import resting_pressure
    from cyclemap.mechanics.slider import (
        MIT_HITCH,
        MIT_SHAPE_NAMES,
        DragBack,
        Pose,
        Pusher,
        SidePush,
        Slider,
        WorldPush,
    )
    from cyclemap.mechanics.trajectory import (
        DragResult,
        DynamicDrag,
        DynamicPush,
        DynamicTrajectory,
        PushResult,
        Trajectory,
    )
else:
    import_on_first_use(__name__)

__all__ = ["MIT_HITCH", "MIT_SHAPE_NAMES", "Ellipse", "Polygon", "Slider"]
__all__ += [
    "EllipseFriction",
    "FloorField",
    "Footprint",
    "LimitSurface",
    "PatchFootprint",
    "PointFootprint",
    "PressedFootprint",
    "SurfaceShape",
    "corner_footprint",
    "resting_pressure",
]
__all__ += ["grid_footprint", "load_footprint", "parse_footprint", "worn_friction"]
__all__ += [
    "CycleNoise",
    "FoundWith",
    "FrameShift",
    "Material",
    "MaterialPosterior",
    "PlatePressure",
    "Wear",
]
__all__ += ["load_material", "material_names", "material_toml"]
__all__ += [
    "DragBack",
    "DragResult",
    "DynamicDrag",
    "DynamicModel",
    "DynamicPush",
    "DynamicTrajectory",
    "Pose",
]
__all__ += ["PushResult", "Pusher", "QuasiStaticModel", "SidePush", "Trajectory", "WorldPush"]
