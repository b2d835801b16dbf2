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
    from cyclemap import (
        collection as collection,
        evidence as evidence,
        maps as maps,
        mechanics as mechanics,
        protocol as protocol,
        resets as resets,
        sweeps as sweeps,
        views as views,
    )
    from cyclemap.collection import (
        CollectionLoop as CollectionLoop,
        Cycle as Cycle,
        Portrait as Portrait,
        fingerprint as fingerprint,
        portrait as portrait,
        predict as predict,
        run_cycles as run_cycles,
    )
    from cyclemap.errors import (
        ConvergenceError as ConvergenceError,
        CycleMapError as CycleMapError,
        DataFileError as DataFileError,
        InvalidInput as InvalidInput,
        UnsupportedContact as UnsupportedContact,
    )
    from cyclemap.evidence import (
        PushTable as PushTable,
        compare as compare,
        fit_map as fit_map,
        identify as identify,
        load_pushes as load_pushes,
        replay_pushes as replay_pushes,
        simulate_collection as simulate_collection,
    )
    from cyclemap.maps import (
        CircleMap as CircleMap,
        DriftingMap as DriftingMap,
        Noise as Noise,
        Orbit as Orbit,
        UniformNoise as UniformNoise,
        VonMises as VonMises,
        WrappedCauchy as WrappedCauchy,
        WrappedNormal as WrappedNormal,
        basins as basins,
        find_steps as find_steps,
        fixed_points as fixed_points,
        follow_orbit as follow_orbit,
        hitting_probability as hitting_probability,
        lyapunov_exponent as lyapunov_exponent,
        mean_passage_time as mean_passage_time,
        periodic_orbits as periodic_orbits,
        periodic_points as periodic_points,
        predict_staircase as predict_staircase,
        rotation_interval as rotation_interval,
        rotation_number as rotation_number,
        saddle_nodes as saddle_nodes,
        sample_staircase as sample_staircase,
        slow_passages as slow_passages,
        tongue as tongue,
        tongues as tongues,
        transfer_operator as transfer_operator,
    )
    from cyclemap.mechanics import (
        DragBack as DragBack,
        Ellipse as Ellipse,
        EllipseFriction as EllipseFriction,
        LimitSurface as LimitSurface,
        Material as Material,
        PatchFootprint as PatchFootprint,
        PointFootprint as PointFootprint,
        Polygon as Polygon,
        Pose as Pose,
        Pusher as Pusher,
        QuasiStaticModel as QuasiStaticModel,
        SidePush as SidePush,
        Slider as Slider,
        load_material as load_material,
        material_names as material_names,
    )
    from cyclemap.protocol import read_protocol as read_protocol, write_protocol as write_protocol
    from cyclemap.resets import BiasMonitor as BiasMonitor, design_reset as design_reset
    from cyclemap.sweeps import SweepPlan as SweepPlan, run_sweep as run_sweep
else:
    import_on_first_use(__name__)


def _show_loops_in_notebooks() -> None:
    """Have a notebook show a loop as its explorer, of which the loop itself knows nothing."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None:
        formatter = shell.display_formatter.formatters["text/html"]
        formatter.for_type_by_name("cyclemap.collection.loop", "CollectionLoop", _explorer)


def _explorer(loop: "CollectionLoop") -> str:
    from cyclemap.views.explorer_page import explorer_frame

    return explorer_frame(loop)


_show_loops_in_notebooks()

__version__ = "0.1.0"
