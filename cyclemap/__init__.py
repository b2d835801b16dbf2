"""cyclemap: the push-then-drag-back data-collection loop of a robot as a map of the circle.

>>> import cyclemap as cm
>>> cm.fixed_points(cm.CircleMap.arnold(omega=0.1, K=0.9))[0].kind
'stable'
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclemap.collection import (
        CollectionLoop,
        Cycle,
        CycleSensitivity,
        Portrait,
        portrait,
    )
    from cyclemap.errors import (
        ConvergenceError,
        CycleMapError,
        DataFileError,
        InvalidInput,
        UnsupportedContact,
    )
    from cyclemap.maps import (
        CircleMap,
        Orbit,
        RotationInterval,
        RotationNumber,
        TransferOperator,
        WrappedCauchy,
        WrappedNormal,
        fixed_points,
        lyapunov_exponent,
        periodic_orbits,
        predict_staircase,
        rotation_interval,
        rotation_number,
        sample_staircase,
        transfer_operator,
    )
    from cyclemap.mechanics import (
        DragBack,
        Ellipse,
        EllipseFriction,
        LimitSurface,
        Material,
        PatchFootprint,
        PointFootprint,
        Polygon,
        Pose,
        Pusher,
        QuasiStaticModel,
        SidePush,
        Slider,
        WorldPush,
        load_material,
        material_names,
    )

__version__ = "0.1.0"

_ROOMS = ("cyclemap.errors", "cyclemap.maps", "cyclemap.mechanics", "cyclemap.collection")

__all__ = [
    "CircleMap",
    "CollectionLoop",
    "ConvergenceError",
    "Cycle",
    "CycleMapError",
    "CycleSensitivity",
    "DataFileError",
    "DragBack",
    "Ellipse",
    "EllipseFriction",
    "InvalidInput",
    "LimitSurface",
    "Material",
    "Orbit",
    "PatchFootprint",
    "PointFootprint",
    "Polygon",
    "Portrait",
    "Pose",
    "Pusher",
    "QuasiStaticModel",
    "RotationInterval",
    "RotationNumber",
    "SidePush",
    "Slider",
    "TransferOperator",
    "UnsupportedContact",
    "WorldPush",
    "WrappedCauchy",
    "WrappedNormal",
    "fixed_points",
    "load_material",
    "lyapunov_exponent",
    "material_names",
    "periodic_orbits",
    "portrait",
    "predict_staircase",
    "rotation_interval",
    "rotation_number",
    "sample_staircase",
    "transfer_operator",
]


def __getattr__(name: str) -> Any:
    # Rooms are imported when they are first used, so that a command which needs one does not wait for the others.
    if name in __all__:
        for room in map(import_module, _ROOMS):
            if hasattr(room, name):
                return getattr(room, name)
    raise AttributeError(f"module 'cyclemap' has no attribute {name!r}")
