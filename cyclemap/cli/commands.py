"""The commands: the few calls that each of them is.

The rooms they call are imported inside them, so that `cyclemap --help` waits for none of them.
"""

from pathlib import Path
from typing import Any

import click

from cyclemap.cli.options import (
    JSON_HELP,
    MOST_CYCLES,
    PATH,
    LoopOptions,
    Real,
    RunRequest,
    Whole,
    loop_options,
    measured_orientations,
    protocol_options,
    readable_data,
    result_options,
    run_options,
    select_option,
    table_options,
    theta0_option,
)

_RECORDED = "Recorded pushes: in the MIT layout (a file, a folder or a tree), or CSV of poses and places of the tip."
_MEASURED = "Measured pushes: a CSV table of θ0 or of poses, or a file or folder of the MIT layout."
_FOLDER = "Folder of measured data. [default: $CYCLEMAP_DATA, or shared/data beside the checkout]"
_FACT = "One fact of the experiment (rod, ring, object); repeatable."
_STUDENT = "Freedom of Student noise, which lets outliers count less; a large one is normal noise."
_OVER = "A key of --set, noise_deg or material, with start:stop:count or a,b,c; start:stop with --sample. Repeatable."
_QUANTITIES = (
    "By commas: rotation, fixed_points, turns, stationary, staircase, or all; stationary and staircase cost most."
)
_TOLERANCE = "Of each cycle map. [default: 5.7e-04; 5.7e-05 is that of portraits, at twice the time]"
_ROTATION_TOLERANCE = "Turns a cycle to which rotation numbers need be known; 0 is a portrait's effort, far more."
_NOT_NEGATIVE = Real(min=0.0)


@click.command("cycle")
@loop_options
@theta0_option
@click.option("--out", metavar="DIR", type=PATH, help="Also write cycles_MATERIAL.json there.")
@click.option("--json", "json_target", metavar="FILE", help=JSON_HELP)
def cycle_command(options: LoopOptions, theta0_deg: str, out: Path | None, json_target: str | None) -> None:
    """Run single cycles: one push and one drag back from each start angle."""
    from cyclemap.cli.run_cycle import run_cycle

    run_cycle(options, theta0_deg, out, json_target)


@click.command("portrait")
@loop_options
@run_options
def portrait_command(
    options: LoopOptions, data: Path | None, columns: str | None, units: str | None, json_target: str | None,
    **request: Any,
) -> None:  # fmt: skip
    """Compute the cycle map of a material, tell what it implies, and draw it."""
    from cyclemap.cli.run_portrait import run_portrait

    measured = measured_orientations(data, columns, units, request["out"])
    run_portrait(options, RunRequest(measured, **request), json_target)


@click.command("staircase")
@loop_options
@run_options
def staircase_command(
    options: LoopOptions, data: Path | None, columns: str | None, units: str | None, json_target: str | None,
    **request: Any,
) -> None:  # fmt: skip
    """Predict the staircase of θ0: its steps, how long it rests on them, and one run."""
    from cyclemap.cli.run_portrait import run_staircase

    measured = measured_orientations(data, columns, units, request["out"])
    run_staircase(options, RunRequest(measured, **request), json_target)


@click.command("fingerprint")
@protocol_options
@click.option("--check", is_flag=True, help="Compute the full cycle map too, and set its directions beside.")
@result_options("fingerprint_MATERIAL.png and .json")
def fingerprint_command(options: LoopOptions, **request: Any) -> None:
    """Print the five numbers of a protocol and, for a material, the directions they predict.

    Without MATERIAL and friction settings only the protocol's own numbers are told.
    """
    from cyclemap.cli.run_fingerprint import run_fingerprint

    run_fingerprint(options, **request)


@click.command("simulate")
@loop_options
@click.option("--out", "folder", metavar="DIR", type=PATH, required=True, help="Folder of the collection.")
@click.option("--cycles", type=Whole(1, MOST_CYCLES), default=2000, help="How many pushes.")
@click.option("--seed", type=Whole(min=0), default=0, help="Seed of all noise.")
@click.option("--start-deg", type=Real(), default=0.0, help="θ0 of the first push.")
@click.option("--noise-deg", type=_NOT_NEGATIVE, help="Scatter of θ0 from cycle to cycle. [default: its own or 1.1]")
@click.option("--pose-noise-mm", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded positions.")
@click.option("--pose-noise-deg", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded angles.")
@click.option("--force-noise-n", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded forces.")
@click.option("--wear-to", metavar="MATERIAL", help="The surface at the last push: a name or a TOML file.")
@click.option("--speed-mm-s", type=Real(min=0.0, min_open=True), default=20.0, help="Of the rod.")
@click.option("--scans", is_flag=True, help="Friction scans of the fresh surface, too.")
@click.option("--format", "suffix", type=click.Choice(["h5", "json"]), default="h5", help="Kind of the files.")
@click.option("--json", "json_target", metavar="FILE", help=JSON_HELP)
def simulate_command(options: LoopOptions, **request: Any) -> None:
    """Write a simulated collection as files of the MIT dataset's layout, to rehearse what comes after.

    Run it again with the same arguments to go on with a collection that was broken off.
    """
    from cyclemap.cli.run_simulate import run_simulate

    run_simulate(options, **request)


@click.command("replay")
@loop_options
@click.option("--data", metavar="PATH", required=True, type=PATH, help=_RECORDED)
@select_option
@click.option("--pusher-friction", type=Real(min=0.0), help="Friction of rod and object. [default: 0.25, or as set]")
@result_options("replay_MATERIAL.png and .json")
def replay_command(options: LoopOptions, **request: Any) -> None:
    """Replay recorded pushes along their own tip paths on MATERIAL, and tell how far off each ends.

    How plates press on it is taken from MATERIAL, and errors stand beside those of isotropic friction. The object is
    the data's: MIT's by its name in them, any other from MATERIAL, --protocol or the collection.toml beside the data.
    On an isotropic surface the friction coefficient changes no motion.
    """
    from cyclemap.cli.run_replay import run_replay

    run_replay(options, **request)


MOST_HARMONICS = 50


@click.command("fit")
@click.argument("data", type=PATH)
@select_option
@click.option("--harmonics", type=Whole(0, MOST_HARMONICS), help="Order of every law. [default: by cross-validation]")
@click.option("--wear/--no-wear", default=True, help="Let the cycle map drift in time.")
@click.option("--seed", type=Whole(min=0), default=0, help="Seed of folds and paths.")
@table_options
@result_options("fit_NAME.png and .json, for each set,")
def fit_command(data: Path, columns: str | None, units: str | None, **request: Any) -> None:
    """Fit laws to measured pushes: Δθ, Δx, Δy over θ0, their histogram, and the cycle map with its wear.

    DATA is a file, a folder or a tree in the MIT layout, a CSV table of poses or of θ0, or a table of
    your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or told by --columns.
    """
    from cyclemap.cli.run_fit import run_fit

    run_fit(readable_data(data, columns, units, request["out"]), **request)


@click.command("identify")
@click.argument("data", nargs=-1, required=True, type=PATH)
@table_options
@select_option
@click.option("--protocol", metavar="TOML", type=PATH, help="The --set keys in TOML tables.")
@click.option("--set", "settings", metavar="KEY=VALUE", multiple=True, help=_FACT)
@click.option("--first", type=Whole(min=0), default=0, help="Leave out cycles before this one.")
@click.option("--most", type=Whole(min=2), default=2000, help="Pushes or drags of an object and file, at most.")
@click.option("--start", metavar="MATERIAL", help="Where the search begins: a name or a TOML file.")
@click.option("--free", metavar="NAMES", help="Parameters to identify, by commas. [default: what the data tell]")
@click.option("--fix", metavar="NAME=VALUE", multiple=True, help="Hold a parameter (SI units); repeatable.")
@click.option("--wear", is_flag=True, help="Let the friction change over the cycles.")
@click.option("--no-priors", is_flag=True, help="Believe nothing beforehand: the data alone speak.")
@click.option("--folds", type=Whole(min=0), help="Parts for cross-validation; 0: none. [default: 5]")
@click.option("--student", type=Real(min=1.0, min_open=True), default=4.0, help=_STUDENT)
@click.option("--starts", type=Whole(min=1), default=2, help="Searches.")
@click.option("--seed", type=Whole(min=0), default=0, help="Seed of starts, folds and draws.")
@click.option("--name", help="Of the material. [default: SURFACE-identified]")
@result_options("NAME.toml, identify_NAME.png and .json")
def identify_command(data: tuple[Path, ...], columns: str | None, units: str | None, **request: Any) -> None:
    """Identify a surface from measured data, and write it as a material.

    DATA are files, folders or trees: friction scans and pushes in the MIT layout, and CSV tables of push ends with
    tip, of drag-backs, of θ0, or of wrenches and twists, of any number of objects on one surface. All are explained at
    once: friction is the surface's, pressure each object's, the shift between robot and camera each data set's.
    """
    from cyclemap.cli.run_identify import run_identify

    run_identify([readable_data(path, columns, units, request["out"]) for path in data], **request)


@click.command("compare")
@loop_options
@table_options
@click.option("--data", metavar="DATA", required=True, type=PATH, help=_MEASURED)
@click.option("--first", type=Whole(min=0), default=0, help="Leave out pushes before this one.")
@select_option
@click.option("--runs", type=Whole(min=19), default=199, help="Simulated collections.")
@click.option("--seed", type=Whole(min=0), default=0, help="Seed of their noise.")
@result_options("compare_MATERIAL.png and .json")
def compare_command(options: LoopOptions, columns: str | None, units: str | None, **request: Any) -> None:
    """Set the prediction of a material beside measured data, and say where they agree."""
    from cyclemap.cli.run_compare import run_compare

    run_compare(options, read=readable_data(request["data"], columns, units, request["out"]), **request)


@click.command("sweep")
@protocol_options
@click.option("--over", metavar="KEY=VALUES", multiple=True, required=True, help=_OVER)
@click.option("--sample", metavar="N", type=Whole(min=1), help="N points of the ranges, not a grid.")
@click.option("--seed", type=Whole(min=0), default=0, help="Seed of the sample.")
@click.option("--sequence", type=click.Choice(["sobol", "uniform"]), default="sobol", help="How the sample is spread.")
@click.option("--quantities", metavar="LIST", default="rotation,fixed_points,turns", help=_QUANTITIES)
@click.option("--tolerance-deg", type=Real(), help=_TOLERANCE)
@click.option("--rotation-tolerance", type=Real(), default=1e-4, help=_ROTATION_TOLERANCE)
@click.option("--workers", type=Whole(min=1), help="Processes. [default: one a core]")
@click.option(
    "--export", metavar="LIST", default="", show_default=False, help="Also write csv, netcdf, or both, by commas."
)
@click.option("--draw", metavar="LIST", default="", show_default=False, help="Quantities to draw, by commas.")
@click.option("--status", is_flag=True, help="Tell how far the sweep is, and compute nothing.")
@result_options("the store sweep_MATERIAL.sqlite, .png, .csv and .nc")
def sweep_command(options: LoopOptions, **request: Any) -> None:
    """Sweep settings: the portrait's numbers at every point of a grid or a sample.

    Results are stored as they come; the same command again goes on where it stopped, and ends at once when all is
    there. Over one key or two it draws the bifurcation or phase diagram.
    """
    from cyclemap.cli.run_sweep import run_sweep_command

    run_sweep_command(options, **request)


@click.command("figures")
@click.argument("names", metavar="[NAME ...|all]", nargs=-1)
@click.option("--data", metavar="DIR", type=PATH, help=_FOLDER)
@result_options("pictures, tables and figures.json")
def figures_command(
    names: tuple[str, ...], data: Path | None, out: Path, picture_format: str, json_target: str | None
) -> None:
    """Make figures and tables of the paper, and those it lacks; without a NAME, list them.

    Figures become pictures, tables CSV, the animation a GIF. figures.json beside them holds their captions.
    """
    from cyclemap.cli.run_figures import list_figures, run_figures

    if names:
        run_figures(names, data, out, picture_format, json_target)
    else:
        list_figures(json_target)
