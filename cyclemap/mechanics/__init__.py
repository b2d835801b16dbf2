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
    from cyclemap.mechanics.dynamic_model import DynamicModel as DynamicModel
    from cyclemap.mechanics.footprint import (
        Footprint as Footprint,
        PatchFootprint as PatchFootprint,
        PointFootprint as PointFootprint,
        corner_footprint as corner_footprint,
        grid_footprint as grid_footprint,
        load_footprint as load_footprint,
        parse_footprint as parse_footprint,
    )
    from cyclemap.mechanics.foundation import (
        FloorField as FloorField,
        PressedFootprint as PressedFootprint,
        SurfaceShape as SurfaceShape,
    )
    from cyclemap.mechanics.friction import (
        EllipseFriction as EllipseFriction,
        LimitSurface as LimitSurface,
        worn_friction as worn_friction,
    )
    from cyclemap.mechanics.material import (
        CycleNoise as CycleNoise,
        FoundWith as FoundWith,
        FrameShift as FrameShift,
        Material as Material,
        MaterialPosterior as MaterialPosterior,
        PlatePressure as PlatePressure,
        Wear as Wear,
    )
    from cyclemap.mechanics.material_text import (
        load_material as load_material,
        material_names as material_names,
        material_toml as material_toml,
    )
    from cyclemap.mechanics.outline import Ellipse as Ellipse, Polygon as Polygon
    from cyclemap.mechanics.plate_footprint import resting_pressure as resting_pressure
    from cyclemap.mechanics.quasi_static import QuasiStaticModel as QuasiStaticModel
    from cyclemap.mechanics.slider import (
        MIT_HITCH as MIT_HITCH,
        MIT_SHAPE_NAMES as MIT_SHAPE_NAMES,
        DragBack as DragBack,
        Pose as Pose,
        Pusher as Pusher,
        SidePush as SidePush,
        Slider as Slider,
        WorldPush as WorldPush,
    )
    from cyclemap.mechanics.trajectory import (
        DragResult as DragResult,
        DynamicDrag as DynamicDrag,
        DynamicPush as DynamicPush,
        DynamicTrajectory as DynamicTrajectory,
        PushResult as PushResult,
        Trajectory as Trajectory,
    )
else:
    import_on_first_use(__name__)
