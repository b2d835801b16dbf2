"""Pushing and dragging under anisotropic friction, quasi-static and dynamic; knows no circle map."""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first used.
    from cyclemap.mechanics.dynamic_model import (
        DynamicDrag,
        DynamicModel,
        DynamicPush,
        DynamicTrajectory,
        EnergyBalance,
    )
    from cyclemap.mechanics.footprint import (
        Footprint,
        PatchFootprint,
        PointFootprint,
        corner_footprint,
        grid_footprint,
        load_footprint,
        parse_footprint,
    )
    from cyclemap.mechanics.friction import EllipseFriction, LimitSurface, worn_friction
    from cyclemap.mechanics.material import (
        CycleNoise,
        FoundWith,
        FrameShift,
        Material,
        MaterialPosterior,
        PlatePressure,
        Wear,
        load_material,
        material_names,
    )
    from cyclemap.mechanics.material_text import material_toml
    from cyclemap.mechanics.outline import Ellipse, Polygon
    from cyclemap.mechanics.protocol import DragBack, Pose, Pusher, SidePush, WorldPush
    from cyclemap.mechanics.quasi_static import QuasiStaticModel
    from cyclemap.mechanics.slider import MIT_HITCH, MIT_SHAPE_NAMES, Slider
    from cyclemap.mechanics.trajectory import DragResult, PushResult, Trajectory
else:
    import_on_first_use(__name__)

__all__ = [
    "MIT_HITCH",
    "MIT_SHAPE_NAMES",
    "CycleNoise",
    "DragBack",
    "DragResult",
    "DynamicDrag",
    "DynamicModel",
    "DynamicPush",
    "DynamicTrajectory",
    "Ellipse",
    "EllipseFriction",
    "EnergyBalance",
    "Footprint",
    "FoundWith",
    "FrameShift",
    "LimitSurface",
    "Material",
    "MaterialPosterior",
    "PatchFootprint",
    "PlatePressure",
    "PointFootprint",
    "Polygon",
    "Pose",
    "PushResult",
    "Pusher",
    "QuasiStaticModel",
    "SidePush",
    "Slider",
    "Trajectory",
    "Wear",
    "WorldPush",
    "corner_footprint",
    "grid_footprint",
    "load_footprint",
    "load_material",
    "material_names",
    "material_toml",
    "parse_footprint",
    "worn_friction",
]
