"""The commands: what each is called, says of itself and takes; what it does is run_NAME of its
file.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, dataclass_transform

import click
from click import Choice

from cyclemap.cli.options import (
    MOST_CYCLES,
    QUIET,
    LoopOptions,
    ProtocolOptions,
    RealRange,
    ResultOptions,
    RunOptions,
    TableOptions,
    Whole,
    argument,
    filled,
    group,
    json_option,
    option,
    out_option,
    parameters,
    seed_option,
    select_option,
    settings_option,
)

Asked = TypeVar("Asked")
_NOT_NEGATIVE = RealRange(min=0.0)
_ABOVE_ZERO = RealRange(min=0.0, min_open=True)
_SHARE = RealRange(min=0.0, max=1.0, min_open=True, max_open=True)
# Start angles, every 30 degrees.
_ALL_AROUND = ",".join(map(str, range(0, 360, 30)))
_MARGIN = (
    "Tell how far every setting is from losing or gaining a stable direction: some seconds, "
    "minutes under shapes."
)


class _Commands(click.Group):
    """The commands in the order of this file, each listed with its whole first sentence."""

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands into the help."""
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, command.get_short_help_str(limit=1000))
                    for name, command in self.commands.items()
                ]
            )


_SHOWN = {"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True}


@click.group(cls=_Commands, context_settings=_SHOWN)
@click.version_option(package_name="cyclemap")
def cli() -> None:
    """What a robot that pushes an object and drags it back will record, predicted from friction."""


@dataclass_transform(frozen_default=True, kw_only_default=True)
def command(file: str) -> Callable[[type[Asked]], type[Asked]]:
    """Add the command that a class of options asks for: NameOptions is asked by NAME, its docstring
    the help, and run by run_NAME of the file, imported only then: no help waits for it.
    """

    def add(kind: type[Asked]) -> type[Asked]:
        asked: Any = dataclass(frozen=True, kw_only=True)(kind)
        name = kind.__name__.removesuffix("Options").lower()

        def work(**given: object) -> None:
            module = import_module(f"cyclemap.cli.{file}")
            getattr(module, f"run_{name}")(filled(asked, given))

        taken = [*parameters(asked), QUIET]
        cli.add_command(click.Command(name, params=taken, callback=work, help=kind.__doc__))
        return kind

    return add


@command("run_init")
class InitOptions:
    """Write FILE.toml for your own object: its outline, a first guess of push, rod and ring, and a
    picture of it all.

    Asked for no outline, it asks back.
    """

    file: Path
    rectangle_mm: str | None = option(
        "A rectangle: its lengths along x and y.", None, metavar="WIDTH,HEIGHT"
    )
    ellipse_mm: str | None = option(
        "An ellipse, or a disc: its whole widths along x and y.", None, metavar="WIDTH,HEIGHT"
    )
    shape: str | None = option(
        "An object of the MIT push dataset: rect1 to rect3, tri1 to tri3, hex, ...",
        None,
        metavar="NAME",
    )
    outline: Path | None = option("An SVG, DXF, STL, URDF or CSV file of it.", None, metavar="PATH")
    unit: str | None = option(
        "Of the outline file. [default: guessed, said]",
        None,
        type=Choice(["mm", "cm", "m", "inch"]),
    )
    tolerance_mm: float = option("Corners of the outline that may go.", 0.1, type=_NOT_NEGATIVE)
    underside: bool = option("The foot print of a mesh, not its silhouette.", False)
    name: str | None = option("Of the object. [default: the file's]", None)
    surface: str = option("Name of the surface.", "table")
    settings: tuple[str, ...] = settings_option()
    force: bool = option("Write over a file that is there.", False)
    json: str | None = json_option()


@command("run_init")
class CheckOptions:
    """Look at a collection FILE.toml as a careful colleague would: say what is likely wrong, and
    draw it.
    """

    file: Path
    out: Path = out_option("Of the picture.")
    json: str | None = json_option()


@command("collected.run_watch")
class AuditOptions:
    """Audit a data set of pushes: what it covers, where it locked in, what it is worth, what its
    reset did.

    DATA is a file, folder or tree in the MIT layout, or a table: orientations alone tell much,
    poses more.
    """

    data: Path
    table: TableOptions
    results: ResultOptions = group("audit_DATA.png and .json")


@command("collected.run_pushes")
class ProbeOptions:
    """Ask whether pushes depend on their direction, what friction ellipse does the same, and where
    it would lock in.

    MATERIAL, or --protocol, tells the object and its push; the surface is taken as isotropic. Give
    one of --data, --command and --python.
    """

    loop: ProtocolOptions
    data: Path | None = option("Pushes made: a table with end poses.", None, metavar="DATA")
    program: str | None = option(
        'A program: {"theta_deg"} in, {"dx_mm","dy_mm","dtheta_deg"} out.',
        None,
        name="--command",
        metavar="PROGRAM",
    )
    python: str | None = option(
        "push(theta) -> (dx, dy, dtheta): rad; m in the object's frame.",
        None,
        metavar="MODULE:FUNCTION",
    )
    count: int = option("Orientations, of a program or function.", 72, type=Whole(12, 3600))
    table: TableOptions
    results: ResultOptions = group("probe.png and .json")


@command("collected.run_plan")
class PlanOptions:
    """Plan the pushes that tell most of where your object locks in, to make by hand or robot, and a
    table to fill in.

    OBJECT is a file that cyclemap init made. What is believed of the floor are the samples of
    --floor. A push is measured before, after, and, where there is a ring, once it is dragged back
    to where the ring was: by two corners with a ruler, or by a pose. Rows may stay empty, or be
    added. --after takes the tables that are filled in, and tells whether that is enough, or the
    next pushes.
    """

    object_file: Path = argument(metavar="OBJECT")
    settings: tuple[str, ...] = settings_option()
    floor: str = option(
        "What is believed of it: a name or a TOML file.", "unknown", metavar="MATERIAL"
    )
    pushes: int = option("How many.", 8, type=Whole(1, 32))
    target: str = option(
        "What is asked: stable directions and whether there are any, the whole map, or where "
        "pushes end.",
        "direction",
        "--for",
        type=Choice(["direction", "map", "pushes"]),
    )
    grid: str = option(
        "Between orientations set by hand; free: any, for a robot.", "15", metavar="DEG"
    )
    room_mm: str = option("Of the table, for object and rod.", "600,400", metavar="X,Y")
    by: str | None = option(
        "What the table asks for. [default: corners; pose if free]",
        None,
        type=Choice(["corners", "pose"]),
    )
    excel: bool = option("Write the table as an Excel file.", False)
    error_mm: float = option("Standard deviation of a measured place.", 1.0, type=_NOT_NEGATIVE)
    error_deg: float = option("And of a measured angle.", 1.0, type=_NOT_NEGATIVE)
    after: tuple[Path, ...] = option("A table that is filled in; repeatable.", (), metavar="TABLE")
    until_deg: float = option("Enough, where 95 % are within so much.", 5.0, type=_ABOVE_ZERO)
    seed: int = seed_option("Seed of the pushes that are looked at.")
    results: ResultOptions = group("plan_OBJECT.csv, .png and .json, and the robot's schedule")


@command("run_cycle")
class CycleOptions:
    """Run single cycles: one push and one drag back from each start angle."""

    loop: LoopOptions
    theta0_deg: str = option("Start angles, by commas.", _ALL_AROUND, metavar="LIST")
    out: Path | None = option("Also write cycles_MATERIAL.json there.", None, metavar="DIR")
    json: str | None = json_option()


@command("run_portrait")
class PortraitOptions(RunOptions):
    """Compute the cycle map of a material, tell what it implies, and draw it."""

    margin: bool = option(_MARGIN, False)


@command("run_portrait")
class StaircaseOptions(RunOptions):
    """Predict the staircase of θ0: its steps, how long it rests on them, and one run."""


@command("run_portrait")
class FingerprintOptions:
    """Print the seven numbers of a protocol and, for a material, the directions they predict.

    Without MATERIAL and friction settings only the protocol's own numbers are told.
    """

    loop: ProtocolOptions
    check: bool = option("Compute the full cycle map too, and set its directions beside.", False)
    margin: bool = option(_MARGIN, False)
    results: ResultOptions = group("fingerprint_MATERIAL.png and .json")


@command("run_report")
class ExploreOptions:
    """Write explore_MATERIAL.html and open it: sliders, the object moving, its map, directions and
    staircase.

    MATERIAL is plywood where none is given. The page computes in the browser, by the engine itself:
    no network, no server, no installation where it is mailed to.
    """

    loop: ProtocolOptions
    data: Path | None = option(
        "Measured θ0 or pushes to lay over the curves.", None, metavar="DATA"
    )
    table: TableOptions
    browser: bool = option(
        "Open the page, or only write it.", True, "--browser/--no-browser", show_default=False
    )
    out: Path = out_option("Where.")


@command("run_cycle")
class DynamicsOptions:
    """Set dynamic cycles (with inertia) beside quasi-static ones, on MATERIAL and on isotropic
    friction.

    Both stand on the footprint if it is made of points, else on points that carry its pressure: the
    paper's grid:8 where it is even, weighted and with points along the rim where it leans or has
    parts.
    """

    loop: LoopOptions
    theta0_deg: str = option("Start angles, by commas.", _ALL_AROUND, metavar="LIST")
    speed_mm_s: float = option("Speed of the rod.", 20.0, type=_ABOVE_ZERO)
    results: ResultOptions = group("dynamics_MATERIAL.png and .json")


@command("run_cycle")
class ExperimentOptions:
    """Run the paper's numerical experiment: batches of cycles from several θ0, and on isotropic
    friction.

    It takes a minute or two; --quasi-static on the exact footprint a quarter of that. Dynamic
    cycles stand on the footprint if it is made of points, else on points that carry its pressure:
    the paper's grid:8 where it is even, weighted and with points along the rim where it leans or
    has parts.
    """

    loop: LoopOptions
    batches: int = option("Batches, evenly spaced.", 6, type=Whole(min=1))
    cycles: int = option("Cycles a batch.", 100, type=Whole(1, MOST_CYCLES))
    speed_mm_s: float | None = option("Speed of the rod. [default: 20]", None, type=_ABOVE_ZERO)
    quasi_static: bool = option(
        "Quasi-static cycles, without inertia, in place of dynamic ones.", False
    )
    results: ResultOptions = group("experiment_MATERIAL.png and .json")


@command("run_figures")
class FiguresOptions:
    """Make figures and tables of the paper, and those it lacks; without a NAME, list them.

    Figures become pictures, tables CSV, the animation a GIF. figures.json beside them holds their
    captions.
    """

    names: tuple[str, ...] = argument(metavar="[NAME ...|all]", required=False)
    data: Path | None = option(
        "Folder of measured data. [default: $CYCLEMAP_DATA, or shared/data beside the checkout]",
        None,
        metavar="DIR",
    )
    results: ResultOptions = group("pictures, tables and figures.json")


@command("run_cycle")
class SimulateOptions:
    """Write a simulated collection as files of the MIT dataset's layout, to rehearse what comes
    after.

    Run it again with the same arguments to go on with a collection that was broken off.
    """

    loop: LoopOptions
    out: Path = option("Folder of the collection.", Path(), metavar="DIR", required=True)
    cycles: int = option("How many pushes.", 2000, type=Whole(1, MOST_CYCLES))
    seed: int = seed_option("Seed of all noise.")
    start_deg: float = option("θ0 of the first push.", 0.0)
    noise_deg: float | None = option(
        "Scatter of θ0 from cycle to cycle. [default: its own or 1.1]", None, type=_NOT_NEGATIVE
    )
    pose_noise_mm: float = option("Error of recorded positions.", 0.0, type=_NOT_NEGATIVE)
    pose_noise_deg: float = option("Error of recorded angles.", 0.0, type=_NOT_NEGATIVE)
    force_noise_n: float = option("Error of recorded forces.", 0.0, type=_NOT_NEGATIVE)
    wear_to: str | None = option(
        "The surface at the last push: a name or a TOML file.", None, metavar="MATERIAL"
    )
    speed_mm_s: float = option("Of the rod.", 20.0, type=_ABOVE_ZERO)
    scans: bool = option("Friction scans of the fresh surface, too.", False)
    format: str = option("Kind of the files.", "h5", type=Choice(["h5", "json"]))
    json: str | None = json_option()


@command("collected.run_fit")
class FitOptions:
    """Fit laws to measured pushes: Δθ, Δx, Δy over θ0, their histogram, and the cycle map with its
    wear.

    DATA is a file, a folder or a tree in the MIT layout, a CSV table of poses or of θ0, or a table
    of your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or told by --columns.
    """

    data: Path
    select: tuple[str, ...] = select_option()
    harmonics: int | None = option(
        "Order of every law. [default: by cross-validation]", None, type=Whole(0, 50)
    )
    wear: bool = option("Let the cycle map drift in time.", True, "--wear/--no-wear")
    seed: int = seed_option("Seed of folds and paths.")
    table: TableOptions
    results: ResultOptions = group("fit_NAME.png and .json, for each set,")


@command("collected.run_identify")
class IdentifyOptions:
    """Identify a surface from measured data, and write it as a material.

    DATA are files, folders or trees: friction scans and pushes in the MIT layout, and CSV tables of
    push ends with tip, of drag-backs, of θ0, or of wrenches and twists, of any number of objects on
    one surface. All are explained at once: friction and mean shape are the floor's, what it is in
    one session that session's, a plate's shape each object's, the shift between robot and camera
    each data set's.
    """

    data: tuple[Path, ...] = argument(required=True)
    table: TableOptions
    select: tuple[str, ...] = select_option()
    protocol: Path | None = option("The --set keys in TOML tables.", None, metavar="TOML")
    settings: tuple[str, ...] = settings_option()
    first: int = option("Leave out cycles before this one.", 0, type=Whole(min=0))
    most: int = option("Pushes or drags of an object and file, at most.", 2000, type=Whole(min=2))
    start: str | None = option(
        "Where the search begins: a name or a TOML file.", None, metavar="MATERIAL"
    )
    floor: str | None = option(
        "What is known of the floor: a name or a TOML file; its plates stay.",
        None,
        metavar="MATERIAL",
    )
    plate: tuple[str, ...] = option(
        "A plate of known shape: a name or a TOML file; repeatable.", (), metavar="PLATE"
    )
    target_mm: str | None = option(
        "Where resets end: the floor's shape may vary with the place about it.", None, metavar="X,Y"
    )
    free: str | None = option(
        "Parameters to identify, by commas. [default: what the data tell]", None, metavar="NAMES"
    )
    fix: tuple[str, ...] = option(
        "Hold a parameter (SI units); repeatable.", (), metavar="NAME=VALUE"
    )
    wear: bool = option("Let friction and floor change over the cycles.", False)
    no_priors: bool = option("Believe nothing beforehand: the data alone speak.", False)
    folds: int | None = option(
        "Parts for cross-validation; 0: none. [default: 5]", None, type=Whole(min=0)
    )
    student: float = option(
        "Freedom of Student noise, which lets outliers count less; a large one is normal noise.",
        4.0,
        type=RealRange(min=1.0, min_open=True),
    )
    starts: int = option("Searches.", 2, type=Whole(min=1))
    seed: int = seed_option("Seed of starts, folds and draws.")
    name: str | None = option("Of the material. [default: SURFACE-identified]", None)
    force: bool = option("Write a material that cannot be right, too.", False)
    results: ResultOptions = group("NAME.toml, identify_NAME.png and .json")


@command("collected.run_compare")
class CompareOptions:
    """Set the prediction of a material beside measured data, and say where they agree."""

    loop: LoopOptions
    table: TableOptions
    data: Path = option(
        "Measured pushes: a CSV table of θ0 or of poses, or a file or folder of the MIT layout.",
        Path(),
        metavar="DATA",
        required=True,
    )
    first: int = option("Leave out pushes before this one.", 0, type=Whole(min=0))
    select: tuple[str, ...] = select_option()
    runs: int = option("Simulated collections.", 199, type=Whole(min=19))
    seed: int = seed_option("Seed of their noise.")
    results: ResultOptions = group("compare_MATERIAL.png and .json")


@command("collected.run_pushes")
class ReplayOptions:
    """Replay recorded pushes along their own tip paths on MATERIAL, and tell how far off each ends.

    How plates press on it is taken from MATERIAL, and errors stand beside those of isotropic
    friction. The object is the data's: MIT's by its name in them, any other from MATERIAL,
    --protocol or the collection.toml beside the data. On an isotropic surface the friction
    coefficient changes no motion.
    """

    loop: LoopOptions
    data: Path = option(
        "Recorded pushes: in the MIT layout (a file, a folder or a tree), or CSV of poses and "
        "places of the tip.",
        Path(),
        metavar="PATH",
        required=True,
    )
    table: TableOptions
    select: tuple[str, ...] = select_option()
    pusher_friction: float | None = option(
        "Friction of rod and object. [default: 0.25, or as set]", None, type=_NOT_NEGATIVE
    )
    results: ResultOptions = group("replay_MATERIAL.png and .json")


@command("collected.run_watch")
class WatchOptions:
    """Watch a collection of θ0 for locking in: FILE is a CSV with theta0_deg in order, a folder of
    MIT pushes, or a table of your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or
    told by --columns.

    With --protocol it also tells which action of the strategy takes the object to where least is
    recorded. With a --material that has samples and one action, it tells the chance that the next
    300 pushes lock in, and where. With --follow, `--json -` prints a line of JSON for each push.
    """

    file: Path
    alarm_rate: float = option(
        "Chance of ever raising an alarm where turns do not depend on θ0 and θ0 does not linger.",
        0.01,
        type=_SHARE,
    )
    follow: bool = option(
        "Wait for new rows, and tell what changes, until interrupted (Ctrl-C).", False
    )
    every: float = option(
        "Between such looks.", 1.0, type=RealRange(min=0.01, max=86400.0), metavar="SECONDS"
    )
    protocol: Path | None = option(
        "With a [strategy]: which of its actions to take next.", None, metavar="TOML"
    )
    material: str | None = option(
        "Name or TOML file of the surface. [default: with --protocol isotropic]",
        None,
        metavar="MATERIAL",
    )
    table: TableOptions
    results: ResultOptions = group("watch_FILE.png and .json")


@command("run_reset")
class ResetOptions:
    """Find a reset that spreads θ0 uniformly on MATERIAL and its likes, and write it as protocol
    and schedule.
    """

    loop: LoopOptions
    allow_tv: float = option(
        "Most total variation of θ0 from uniform, in the long run, at the worst of the range.",
        0.10,
        type=_SHARE,
    )
    extra_tv: float = option("More after --within pushes.", 0.02, type=_SHARE)
    within: int = option("Pushes from the worst start.", 50, type=Whole(1, 10_000))
    drag_ratio: float = option("Most mean drag, in those of now.", 2.0, type=_ABOVE_ZERO)
    reach_mm: float | None = option(
        "Most distance of rod or object from the target.", None, type=_ABOVE_ZERO
    )
    seconds: float | None = option("Most mean time of a cycle.", None, type=_ABOVE_ZERO)
    least_push_mm: float | None = option(
        "Shortest way of the rod in contact, in every push.  [default: two thirds of the push, "
        "else one]",
        None,
        type=_ABOVE_ZERO,
    )
    abilities: tuple[str, ...] = option(
        "What the robot can do besides: put the ring elsewhere, turn the object. Repeatable.",
        (),
        "--with",
        type=Choice(["ring", "gripper"]),
    )
    keep_push: bool = option("Change only the way back: every push stays the loop's own.", False)
    axes_percent: float | None = option(
        "How much one axis of friction may be longer against the other.  [default: the material's "
        "posterior, or 10]",
        None,
        type=RealRange(min=0.0, max=100.0, max_open=True),
    )
    offsets_percent: float | None = option(
        "How much m0 and n0 may vary.  [default: the material's posterior, or 50]",
        None,
        type=_ABOVE_ZERO,
    )
    likely: tuple[str, ...] = option(
        "A material as likely as MATERIAL, in place of these percentages. Repeatable.",
        (),
        metavar="MATERIAL",
    )
    pushes: int = option("How many to collect.", 500, type=Whole(1, 10_000))
    cycles: int = option("Schedule's length.", 2000, type=Whole(1, 10_000_000))
    seed: int = seed_option("Seed of the schedule.")
    results: ResultOptions = group(
        "reset_MATERIAL.png and .json, the protocol (.toml) and the schedule (.csv)"
    )


@command("run_report")
class ReportOptions:
    """Write report_MATERIAL.html: verdict, the explorer's page, data beside it, what to do,
    provenance.
    """

    loop: LoopOptions
    data: Path | None = option("Measured pushes or θ0 to judge it by.", None, metavar="FILE")
    table: TableOptions
    reset: bool = option(
        "Also find a reset without bias, with its files (some ten seconds).", False
    )
    out: Path = out_option("Where.")


@command("run_sweep")
class SweepOptions:
    """Sweep settings: the portrait's numbers at every point of a grid or a sample.

    Results are stored as they come; the same command again goes on where it stopped, and ends at
    once when all is there. Over one key or two it draws the bifurcation or phase diagram.
    """

    loop: ProtocolOptions
    over: tuple[str, ...] = option(
        "A key of --set, noise_deg or material, with start:stop:count or a,b,c; start:stop with "
        "--sample. Repeatable.",
        (),
        metavar="KEY=VALUES",
        required=True,
    )
    sample: int | None = option(
        "N points of the ranges, not a grid.", None, type=Whole(min=1), metavar="N"
    )
    seed: int = seed_option("Seed of the sample.")
    sequence: str = option("How the sample is spread.", "sobol", type=Choice(["sobol", "uniform"]))
    quantities: str = option(
        "By commas: rotation, fixed_points, turns, stationary, staircase, or all; stationary and "
        "staircase cost most.",
        "rotation,fixed_points,turns",
        metavar="LIST",
    )
    tolerance_deg: float | None = option(
        "Of each cycle map. [default: 5.7e-04; 5.7e-05 is that of portraits, at twice the time]",
        None,
    )
    rotation_tolerance: float = option(
        "Turns a cycle to which rotation numbers need be known; 0 is a portrait's effort, far "
        "more.",
        1e-4,
    )
    workers: int | None = option("Processes. [default: one a core]", None, type=Whole(min=1))
    export: str = option(
        "Also write csv, netcdf, or both, by commas.", "", metavar="LIST", show_default=False
    )
    draw: str = option("Quantities to draw, by commas.", "", metavar="LIST", show_default=False)
    status: bool = option("Tell how far the sweep is, and compute nothing.", False)
    results: ResultOptions = group("the store sweep_MATERIAL.sqlite, .png, .csv and .nc")


@command("run_doctor")
class DoctorOptions:
    """Tell what is installed, and how far cycles are from an independent solver's.

    The exit code is 1 where something that should work does not.
    """

    json: str | None = json_option()
