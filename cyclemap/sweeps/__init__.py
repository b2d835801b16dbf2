"""Sweeps: the portrait's numbers at every point of a grid or a sample of settings, stored as they
come.

Planning
--------
SweepPlan, SweptPoint : which points, of which loop, and what is asked of each
Grid, Sample, SweepAxis, SweepRange : all combinations of values, or a number of points spread over
    ranges
PortraitNumbers, PointOutcome, Quantity : what is found at a point

Running
-------
run_sweep, sweep_status, SweepStatus : run what a store lacks; how far it is
SweepStore, StoreWriteError : the file that keeps every point as it comes

Reading
-------
load_sweep, Sweep : what was found so far
to_dataset, write_netcdf, write_csv : as an xarray Dataset, NetCDF, CSV

Margins
-------
direction_margins, DirectionMargin, DirectionChange : how far each setting is from losing or gaining
    a stable direction
change_curve : where that happens in a plane of two settings
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.sweeps.direction_margins import (
        DirectionChange as DirectionChange,
        DirectionMargin as DirectionMargin,
        change_curve as change_curve,
        direction_margins as direction_margins,
    )
    from cyclemap.sweeps.point_sets import (
        Grid as Grid,
        Sample as Sample,
        SweepAxis as SweepAxis,
        SweepRange as SweepRange,
    )
    from cyclemap.sweeps.portrait_numbers import (
        PointOutcome as PointOutcome,
        PortraitNumbers as PortraitNumbers,
        Quantity as Quantity,
        SweptPoint as SweptPoint,
    )
    from cyclemap.sweeps.run_sweep import run_sweep as run_sweep, sweep_status as sweep_status
    from cyclemap.sweeps.sweep_plan import SweepPlan as SweepPlan
    from cyclemap.sweeps.sweep_results import (
        Sweep as Sweep,
        load_sweep as load_sweep,
        to_dataset as to_dataset,
        write_csv as write_csv,
        write_netcdf as write_netcdf,
    )
    from cyclemap.sweeps.sweep_store import (
        StoreWriteError as StoreWriteError,
        SweepStatus as SweepStatus,
        SweepStore as SweepStore,
    )
else:
    import_on_first_use(__name__)
