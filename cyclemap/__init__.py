"""cyclemap: the push-then-drag-back data-collection loop of a robot as a map of the circle.

What one begins with is here; the rest is in its room: `cm.maps`, `cm.mechanics`, `cm.collection`,
`cm.protocol`, `cm.evidence`, `cm.resets`, `cm.sweeps`, `cm.views`, each with a table of contents in
`help()` and `dir()`.

>>> import cyclemap as cm
>>> cm.fixed_points(cm.CircleMap.arnold(omega=0.1, K=0.9))[0].kind
'stable'
"""

import sys
from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap import collection, evidence, maps, mechanics, protocol, resets, sweeps, views
    from cyclemap.collection import (
        CollectionLoop,
        Cycle,
        Portrait,
        fingerprint,
        portrait,
        predict,
        run_cycles,
    )
    from cyclemap.errors import (
        ConvergenceError,
        CycleMapError,
        DataFileError,
        InvalidInput,
        UnsupportedContact,
    )
    from cyclemap.evidence import (
        PushTable,
        compare,
        fit_map,
        identify,
        load_pushes,
        replay_pushes,
        simulate_collection,
    )
    from cyclemap.maps import (
        CircleMap,
        DriftingMap,
        Noise,
        Orbit,
        UniformNoise,
        VonMises,
        WrappedCauchy,
        WrappedNormal,
        basins,
        find_steps,
        fixed_points,
        follow_orbit,
        hitting_probability,
        lyapunov_exponent,
        mean_passage_time,
        periodic_orbits,
        periodic_points,
        predict_staircase,
        rotation_interval,
        rotation_number,
        saddle_nodes,
        sample_staircase,
        slow_passages,
        tongue,
        tongues,
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
        load_material,
        material_names,
    )
    from cyclemap.protocol import read_protocol, write_protocol
    from cyclemap.resets import BiasMonitor, design_reset
    from cyclemap.sweeps import SweepPlan, run_sweep
else:
    import_on_first_use(__name__)


def _show_loops_in_notebooks() -> None:
    """Have a notebook show a loop as its explorer, of which the loop itself knows nothing."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None:
        formatter = shell.display_formatter.formatters["text/html"]
        formatter.for_type_by_name("cyclemap.collection.loop", "CollectionLoop", _explorer)


def _explorer(loop: "CollectionLoop") -> str:
    from cyclemap.views.explorer.page import explorer_frame

    return explorer_frame(loop)


_show_loops_in_notebooks()

__version__ = "0.1.0"

__all__ = [
    "CollectionLoop",
    "Cycle",
    "Portrait",
    "fingerprint",
    "portrait",
    "predict",
    "run_cycles",
]
__all__ += ["collection", "evidence", "maps", "mechanics", "protocol", "resets", "sweeps", "views"]
__all__ += [
    "ConvergenceError",
    "CycleMapError",
    "DataFileError",
    "InvalidInput",
    "UnsupportedContact",
]
__all__ += [
    "PushTable",
    "compare",
    "fit_map",
    "identify",
    "load_pushes",
    "replay_pushes",
    "simulate_collection",
]
__all__ += [
    "CircleMap",
    "DriftingMap",
    "Noise",
    "Orbit",
    "UniformNoise",
    "VonMises",
    "WrappedCauchy",
    "WrappedNormal",
]
__all__ += [
    "basins",
    "find_steps",
    "fixed_points",
    "follow_orbit",
    "hitting_probability",
    "lyapunov_exponent",
]
__all__ += [
    "mean_passage_time",
    "periodic_orbits",
    "periodic_points",
    "predict_staircase",
    "rotation_interval",
]
__all__ += [
    "rotation_number",
    "saddle_nodes",
    "sample_staircase",
    "slow_passages",
    "tongue",
    "tongues",
]
__all__ += ["transfer_operator"]
__all__ += [
    "DragBack",
    "Ellipse",
    "EllipseFriction",
    "LimitSurface",
    "Material",
    "PatchFootprint",
    "PointFootprint",
]
__all__ += [
    "Polygon",
    "Pose",
    "Pusher",
    "QuasiStaticModel",
    "SidePush",
    "Slider",
    "load_material",
    "material_names",
]
__all__ += ["read_protocol", "write_protocol"]
__all__ += ["BiasMonitor", "design_reset"]
__all__ += ["SweepPlan", "run_sweep"]
