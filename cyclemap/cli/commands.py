"""The commands: what each is called, says of itself and takes; what it does is run_NAME in
run_NAME.py.
"""

from importlib import import_module

import click
from click import Choice, argument, option

from cyclemap.cli.options import (
    MOST_CYCLES,
    PATH,
    Decorator,
    Real,
    RealRange,
    Whole,
    decorated,
    json_option,
    loop_options,
    out_option,
    protocol_options,
    quiet_option,
    result_options,
    run_options,
    seed_option,
    select_option,
    set_option,
    table_options,
    theta0_option,
)

_MARGIN = (
    "Tell how far every setting is from losing or gaining a stable direction: some seconds, "
    "minutes under shapes."
)
_NOT_NEGATIVE = RealRange(min=0.0)
_ABOVE_ZERO = RealRange(min=0.0, min_open=True)
_SHARE = RealRange(min=0.0, max=1.0, min_open=True, max_open=True)
_PERCENT = RealRange(min=0.0, max=100.0, max_open=True)
_WAIT = RealRange(min=0.01, max=86400.0)


speed_option = option("--speed-mm-s", type=Real(), default=20.0, help="Speed of the rod.")


class _Commands(click.Group):
    """The commands in the order of this file, each listed with its whole first sentence."""

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command, which like all of them can be told to be quiet."""
        cmd.params.append(quiet_option())
        super().add_command(cmd, name)

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


def command(name: str, says: str, *takes: Decorator, file: str = "") -> None:
    """Add a command: its name, its help, its arguments and options in order.

    It does run_NAME of run_NAME.py, or of the `file` that is named; that is imported only then: no
    help waits for it. Where the file has NameOptions, all that was asked comes as one of these.
    """

    def work(**given: object) -> None:
        module = import_module(f"cyclemap.cli.{file or f'run_{name}'}")
        run = getattr(module, f"run_{name}")
        options = f"{name.title()}Options"
        if hasattr(module, options):
            run(getattr(module, options)(**given))
        else:
            run(**given)

    cli.command(name, help=says)(decorated(work, *takes))


command(
    "init",
    """Write FILE.toml for your own object: its outline, a first guess of push, rod and ring, and a
    picture of it all.

    Asked for no outline, it asks back.
    """,
    argument("file", type=PATH),
    option(
        "--rectangle-mm", metavar="WIDTH,HEIGHT", help="A rectangle: its lengths along x and y."
    ),
    option(
        "--ellipse-mm",
        metavar="WIDTH,HEIGHT",
        help="An ellipse, or a disc: its whole widths along x and y.",
    ),
    option(
        "--shape",
        metavar="NAME",
        help="An object of the MIT push dataset: rect1 to rect3, tri1 to tri3, hex, ...",
    ),
    option(
        "--outline", metavar="PATH", type=PATH, help="An SVG, DXF, STL, URDF or CSV file of it."
    ),
    option(
        "--unit",
        type=Choice(["mm", "cm", "m", "inch"]),
        help="Of the outline file. [default: guessed, said]",
    ),
    option("--tolerance-mm", type=float, default=0.1, help="Corners of the outline that may go."),
    option("--underside", is_flag=True, help="The foot print of a mesh, not its silhouette."),
    option("--name", help="Of the object. [default: the file's]"),
    option("--surface", default="table", help="Name of the surface."),
    set_option,
    option("--force", is_flag=True, help="Write over a file that is there."),
    json_option,
)
command(
    "check",
    """Look at a collection FILE.toml as a careful colleague would: say what is likely wrong, and
    draw it.
    """,
    argument("file", type=PATH),
    out_option("Of the picture."),
    json_option,
    file="run_init",
)
command(
    "audit",
    """Audit a data set of pushes: what it covers, where it locked in, what it is worth, what its
    reset did.

    DATA is a file, folder or tree in the MIT layout, or a table: orientations alone tell much,
    poses more.
    """,
    argument("data", type=PATH),
    table_options,
    result_options("audit_DATA.png and .json"),
    file="collected.run_watch",
)
command(
    "probe",
    """Ask whether pushes depend on their direction, what friction ellipse does the same, and where
    it would lock in.

    MATERIAL, or --protocol, tells the object and its push; the surface is taken as isotropic. Give
    one of --data, --command and --python.
    """,
    protocol_options,
    option("--data", metavar="DATA", type=PATH, help="Pushes made: a table with end poses."),
    option(
        "--command",
        "program",
        metavar="PROGRAM",
        help='A program: {"theta_deg"} in, {"dx_mm","dy_mm","dtheta_deg"} out.',
    ),
    option(
        "--python",
        metavar="MODULE:FUNCTION",
        help="push(theta) -> (dx, dy, dtheta): rad; m in the object's frame.",
    ),
    option(
        "--count", type=Whole(12, 3600), default=72, help="Orientations, of a program or function."
    ),
    table_options,
    result_options("probe.png and .json"),
    file="collected.run_probe",
)
command(
    "plan",
    """Plan the pushes that tell most of where your object locks in, to make by hand or robot, and a
    table to fill in.

    OBJECT is a file that cyclemap init made. What is believed of the floor are the samples of
    --floor. A push is measured before, after, and, where there is a ring, once it is dragged back
    to where the ring was: by two corners with a ruler, or by a pose. Rows may stay empty, or be
    added. --after takes the tables that are filled in, and tells whether that is enough, or the
    next pushes.
    """,
    argument("object_file", metavar="OBJECT", type=PATH),
    set_option,
    option(
        "--floor",
        metavar="MATERIAL",
        default="unknown",
        help="What is believed of it: a name or a TOML file.",
    ),
    option("--pushes", type=Whole(1, 32), default=8, help="How many."),
    option(
        "--for",
        "target",
        type=Choice(["direction", "map", "pushes"]),
        default="direction",
        help=(
            "What is asked: stable directions and whether there are any, the whole map, or where "
            "pushes end."
        ),
    ),
    option(
        "--grid",
        metavar="DEG",
        default="15",
        help="Between orientations set by hand; free: any, for a robot.",
    ),
    option("--room-mm", metavar="X,Y", default="600,400", help="Of the table, for object and rod."),
    option(
        "--by",
        type=Choice(["corners", "pose"]),
        help="What the table asks for. [default: corners; pose if free]",
    ),
    option("--excel", is_flag=True, help="Write the table as an Excel file."),
    option(
        "--error-mm",
        type=_NOT_NEGATIVE,
        default=1.0,
        help="Standard deviation of a measured place.",
    ),
    option("--error-deg", type=_NOT_NEGATIVE, default=1.0, help="And of a measured angle."),
    option(
        "--after",
        metavar="TABLE",
        type=PATH,
        multiple=True,
        help="A table that is filled in; repeatable.",
    ),
    option(
        "--until-deg", type=_ABOVE_ZERO, default=5.0, help="Enough, where 95 % are within so much."
    ),
    seed_option("Seed of the pushes that are looked at."),
    result_options("plan_OBJECT.csv, .png and .json, and the robot's schedule"),
    file="collected.run_plan",
)
command(
    "cycle",
    """Run single cycles: one push and one drag back from each start angle.""",
    loop_options,
    theta0_option,
    option("--out", metavar="DIR", type=PATH, help="Also write cycles_MATERIAL.json there."),
    json_option,
)
command(
    "portrait",
    """Compute the cycle map of a material, tell what it implies, and draw it.""",
    loop_options,
    option("--margin", is_flag=True, help=_MARGIN),
    run_options,
)
command(
    "staircase",
    """Predict the staircase of θ0: its steps, how long it rests on them, and one run.""",
    loop_options,
    run_options,
    file="run_portrait",
)
command(
    "fingerprint",
    """Print the seven numbers of a protocol and, for a material, the directions they predict.

    Without MATERIAL and friction settings only the protocol's own numbers are told.
    """,
    protocol_options,
    option(
        "--check",
        is_flag=True,
        help="Compute the full cycle map too, and set its directions beside.",
    ),
    option("--margin", is_flag=True, help=_MARGIN),
    result_options("fingerprint_MATERIAL.png and .json"),
    file="run_portrait",
)
command(
    "explore",
    """Write explore_MATERIAL.html and open it: sliders, the object moving, its map, directions and
    staircase.

    MATERIAL is plywood where none is given. The page computes in the browser, by the engine itself:
    no network, no server, no installation where it is mailed to.
    """,
    protocol_options,
    option(
        "--data", metavar="DATA", type=PATH, help="Measured θ0 or pushes to lay over the curves."
    ),
    table_options,
    option(
        "--browser/--no-browser",
        default=True,
        show_default=False,
        help="Open the page, or only write it.",
    ),
    out_option("Where."),
    file="run_report",
)
command(
    "dynamics",
    """Set dynamic cycles (with inertia) beside quasi-static ones, on MATERIAL and on isotropic
    friction.

    Both stand on the footprint if it is made of points, else on points that carry its pressure: the
    paper's grid:8 where it is even, weighted and with points along the rim where it leans or has
    parts.
    """,
    loop_options,
    theta0_option,
    speed_option,
    result_options("dynamics_MATERIAL.png and .json"),
    file="run_cycle",
)
command(
    "experiment",
    """Run the paper's numerical experiment: batches of cycles from several θ0, and on isotropic
    friction.

    It takes a minute or two; --quasi-static on the exact footprint a quarter of that. Dynamic
    cycles stand on the footprint if it is made of points, else on points that carry its pressure:
    the paper's grid:8 where it is even, weighted and with points along the rim where it leans or
    has parts.
    """,
    loop_options,
    option("--batches", type=Whole(min=1), default=6, help="Batches, evenly spaced."),
    option("--cycles", type=Whole(1, MOST_CYCLES), default=100, help="Cycles a batch."),
    speed_option,
    option(
        "--quasi-static",
        is_flag=True,
        help="Quasi-static cycles, without inertia, in place of dynamic ones.",
    ),
    result_options("experiment_MATERIAL.png and .json"),
    file="run_cycle",
)
command(
    "figures",
    """Make figures and tables of the paper, and those it lacks; without a NAME, list them.

    Figures become pictures, tables CSV, the animation a GIF. figures.json beside them holds their
    captions.
    """,
    argument("names", metavar="[NAME ...|all]", nargs=-1),
    option(
        "--data",
        metavar="DIR",
        type=PATH,
        help=(
            "Folder of measured data. [default: $CYCLEMAP_DATA, or shared/data beside the checkout]"
        ),
    ),
    result_options("pictures, tables and figures.json"),
)
command(
    "simulate",
    """Write a simulated collection as files of the MIT dataset's layout, to rehearse what comes
    after.

    Run it again with the same arguments to go on with a collection that was broken off.
    """,
    loop_options,
    option(
        "--out", "folder", metavar="DIR", type=PATH, required=True, help="Folder of the collection."
    ),
    option("--cycles", type=Whole(1, MOST_CYCLES), default=2000, help="How many pushes."),
    seed_option("Seed of all noise."),
    option("--start-deg", type=Real(), default=0.0, help="θ0 of the first push."),
    option(
        "--noise-deg",
        type=_NOT_NEGATIVE,
        help="Scatter of θ0 from cycle to cycle. [default: its own or 1.1]",
    ),
    option("--pose-noise-mm", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded positions."),
    option("--pose-noise-deg", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded angles."),
    option("--force-noise-n", type=_NOT_NEGATIVE, default=0.0, help="Error of recorded forces."),
    option(
        "--wear-to", metavar="MATERIAL", help="The surface at the last push: a name or a TOML file."
    ),
    option("--speed-mm-s", type=_ABOVE_ZERO, default=20.0, help="Of the rod."),
    option("--scans", is_flag=True, help="Friction scans of the fresh surface, too."),
    option(
        "--format", "suffix", type=Choice(["h5", "json"]), default="h5", help="Kind of the files."
    ),
    json_option,
    file="collected.run_simulate",
)
command(
    "fit",
    """Fit laws to measured pushes: Δθ, Δx, Δy over θ0, their histogram, and the cycle map with its
    wear.

    DATA is a file, a folder or a tree in the MIT layout, a CSV table of poses or of θ0, or a table
    of your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or told by --columns.
    """,
    argument("data", type=PATH),
    select_option,
    option(
        "--harmonics", type=Whole(0, 50), help="Order of every law. [default: by cross-validation]"
    ),
    option("--wear/--no-wear", default=True, help="Let the cycle map drift in time."),
    seed_option("Seed of folds and paths."),
    table_options,
    result_options("fit_NAME.png and .json, for each set,"),
    file="collected.run_fit",
)
command(
    "identify",
    """Identify a surface from measured data, and write it as a material.

    DATA are files, folders or trees: friction scans and pushes in the MIT layout, and CSV tables of
    push ends with tip, of drag-backs, of θ0, or of wrenches and twists, of any number of objects on
    one surface. All are explained at once: friction and mean shape are the floor's, what it is in
    one session that session's, a plate's shape each object's, the shift between robot and camera
    each data set's.
    """,
    argument("data", nargs=-1, required=True, type=PATH),
    table_options,
    select_option,
    option("--protocol", metavar="TOML", type=PATH, help="The --set keys in TOML tables."),
    option(
        "--set",
        "settings",
        metavar="KEY=VALUE",
        multiple=True,
        help="One fact of the experiment (rod, ring, object); repeatable.",
    ),
    option("--first", type=Whole(min=0), default=0, help="Leave out cycles before this one."),
    option(
        "--most",
        type=Whole(min=2),
        default=2000,
        help="Pushes or drags of an object and file, at most.",
    ),
    option("--start", metavar="MATERIAL", help="Where the search begins: a name or a TOML file."),
    option(
        "--floor",
        metavar="MATERIAL",
        help="What is known of the floor: a name or a TOML file; its plates stay.",
    ),
    option(
        "--plate",
        metavar="PLATE",
        multiple=True,
        help="A plate of known shape: a name or a TOML file; repeatable.",
    ),
    option(
        "--target-mm",
        metavar="X,Y",
        help="Where resets end: the floor's shape may vary with the place about it.",
    ),
    option(
        "--free",
        metavar="NAMES",
        help="Parameters to identify, by commas. [default: what the data tell]",
    ),
    option(
        "--fix",
        metavar="NAME=VALUE",
        multiple=True,
        help="Hold a parameter (SI units); repeatable.",
    ),
    option("--wear", is_flag=True, help="Let friction and floor change over the cycles."),
    option("--no-priors", is_flag=True, help="Believe nothing beforehand: the data alone speak."),
    option("--folds", type=Whole(min=0), help="Parts for cross-validation; 0: none. [default: 5]"),
    option(
        "--student",
        type=RealRange(min=1.0, min_open=True),
        default=4.0,
        help=(
            "Freedom of Student noise, which lets outliers count less; a large one is normal noise."
        ),
    ),
    option("--starts", type=Whole(min=1), default=2, help="Searches."),
    seed_option("Seed of starts, folds and draws."),
    option("--name", help="Of the material. [default: SURFACE-identified]"),
    option("--force", is_flag=True, help="Write a material that cannot be right, too."),
    result_options("NAME.toml, identify_NAME.png and .json"),
    file="collected.run_identify",
)
command(
    "compare",
    """Set the prediction of a material beside measured data, and say where they agree.""",
    loop_options,
    table_options,
    option(
        "--data",
        metavar="DATA",
        required=True,
        type=PATH,
        help=(
            "Measured pushes: a CSV table of θ0 or of poses, or a file or folder of the MIT layout."
        ),
    ),
    option("--first", type=Whole(min=0), default=0, help="Leave out pushes before this one."),
    select_option,
    option("--runs", type=Whole(min=19), default=199, help="Simulated collections."),
    seed_option("Seed of their noise."),
    result_options("compare_MATERIAL.png and .json"),
    file="collected.run_compare",
)
command(
    "replay",
    """Replay recorded pushes along their own tip paths on MATERIAL, and tell how far off each ends.

    How plates press on it is taken from MATERIAL, and errors stand beside those of isotropic
    friction. The object is the data's: MIT's by its name in them, any other from MATERIAL,
    --protocol or the collection.toml beside the data. On an isotropic surface the friction
    coefficient changes no motion.
    """,
    loop_options,
    option(
        "--data",
        metavar="PATH",
        required=True,
        type=PATH,
        help=(
            "Recorded pushes: in the MIT layout (a file, a folder or a tree), or CSV of poses "
            "and places of the tip."
        ),
    ),
    table_options,
    select_option,
    option(
        "--pusher-friction",
        type=_NOT_NEGATIVE,
        help="Friction of rod and object. [default: 0.25, or as set]",
    ),
    result_options("replay_MATERIAL.png and .json"),
    file="collected.run_replay",
)
command(
    "watch",
    """Watch a collection of θ0 for locking in: FILE is a CSV with theta0_deg in order, a folder of
    MIT pushes, or a table of your own (CSV, Excel, LeRobot, ROS bag), whose columns are guessed, or
    told by --columns.

    With --protocol it also tells which action of the strategy takes the object to where least is
    recorded. With a --material that has samples and one action, it tells the chance that the next
    300 pushes lock in, and where. With --follow, `--json -` prints a line of JSON for each push.
    """,
    argument("file", type=PATH),
    option(
        "--alarm-rate",
        type=_SHARE,
        default=0.01,
        help=(
            "Chance of ever raising an alarm where turns do not depend on θ0 and θ0 does not "
            "linger."
        ),
    ),
    option(
        "--follow",
        is_flag=True,
        help="Wait for new rows, and tell what changes, until interrupted (Ctrl-C).",
    ),
    option("--every", metavar="SECONDS", type=_WAIT, default=1.0, help="Between such looks."),
    option(
        "--protocol",
        metavar="TOML",
        type=PATH,
        help="With a [strategy]: which of its actions to take next.",
    ),
    option(
        "--material",
        metavar="MATERIAL",
        help="Name or TOML file of the surface. [default: with --protocol isotropic]",
    ),
    table_options,
    result_options("watch_FILE.png and .json"),
    file="collected.run_watch",
)
command(
    "reset",
    """Find a reset that spreads θ0 uniformly on MATERIAL and its likes, and write it as protocol
    and schedule.
    """,
    loop_options,
    option(
        "--allow-tv",
        type=_SHARE,
        default=0.10,
        help="Most total variation of θ0 from uniform, in the long run, at the worst of the range.",
    ),
    option("--extra-tv", type=_SHARE, default=0.02, help="More after --within pushes."),
    option("--within", type=Whole(1, 10_000), default=50, help="Pushes from the worst start."),
    option("--drag-ratio", type=_ABOVE_ZERO, default=2.0, help="Most mean drag, in those of now."),
    option("--reach-mm", type=_ABOVE_ZERO, help="Most distance of rod or object from the target."),
    option("--seconds", type=_ABOVE_ZERO, help="Most mean time of a cycle."),
    option(
        "--least-push-mm",
        type=_ABOVE_ZERO,
        help=(
            "Shortest way of the rod in contact, in every push.  [default: two thirds of the "
            "push, else one]"
        ),
    ),
    option(
        "--with",
        "abilities",
        type=Choice(["ring", "gripper"]),
        multiple=True,
        help="What the robot can do besides: put the ring elsewhere, turn the object. Repeatable.",
    ),
    option(
        "--keep-push",
        is_flag=True,
        help="Change only the way back: every push stays the loop's own.",
    ),
    option(
        "--axes-percent",
        type=_PERCENT,
        help=(
            "How much one axis of friction may be longer against the other.  [default: the "
            "material's posterior, or 10]"
        ),
    ),
    option(
        "--offsets-percent",
        type=_ABOVE_ZERO,
        help="How much m0 and n0 may vary.  [default: the material's posterior, or 50]",
    ),
    option(
        "--likely",
        metavar="MATERIAL",
        multiple=True,
        help="A material as likely as MATERIAL, in place of these percentages. Repeatable.",
    ),
    option("--pushes", type=Whole(1, 10_000), default=500, help="How many to collect."),
    option("--cycles", type=Whole(1, 10_000_000), default=2000, help="Schedule's length."),
    seed_option("Seed of the schedule."),
    result_options("reset_MATERIAL.png and .json, the protocol (.toml) and the schedule (.csv)"),
)
command(
    "report",
    "Write report_MATERIAL.html: verdict, the explorer's page, data beside it, what to do, "
    "provenance.",
    loop_options,
    option("--data", metavar="FILE", type=PATH, help="Measured pushes or θ0 to judge it by."),
    table_options,
    option(
        "--reset",
        is_flag=True,
        help="Also find a reset without bias, with its files (some ten seconds).",
    ),
    out_option("Where."),
)
command(
    "sweep",
    """Sweep settings: the portrait's numbers at every point of a grid or a sample.

    Results are stored as they come; the same command again goes on where it stopped, and ends at
    once when all is there. Over one key or two it draws the bifurcation or phase diagram.
    """,
    protocol_options,
    option(
        "--over",
        metavar="KEY=VALUES",
        multiple=True,
        required=True,
        help=(
            "A key of --set, noise_deg or material, with start:stop:count or a,b,c; start:stop "
            "with --sample. Repeatable."
        ),
    ),
    option("--sample", metavar="N", type=Whole(min=1), help="N points of the ranges, not a grid."),
    seed_option("Seed of the sample."),
    option(
        "--sequence",
        type=Choice(["sobol", "uniform"]),
        default="sobol",
        help="How the sample is spread.",
    ),
    option(
        "--quantities",
        metavar="LIST",
        default="rotation,fixed_points,turns",
        help=(
            "By commas: rotation, fixed_points, turns, stationary, staircase, or all; stationary "
            "and staircase cost most."
        ),
    ),
    option(
        "--tolerance-deg",
        type=Real(),
        help=(
            "Of each cycle map. [default: 5.7e-04; 5.7e-05 is that of portraits, at twice the time]"
        ),
    ),
    option(
        "--rotation-tolerance",
        type=Real(),
        default=1e-4,
        help=(
            "Turns a cycle to which rotation numbers need be known; 0 is a portrait's effort, far "
            "more."
        ),
    ),
    option("--workers", type=Whole(min=1), help="Processes. [default: one a core]"),
    option(
        "--export",
        metavar="LIST",
        default="",
        show_default=False,
        help="Also write csv, netcdf, or both, by commas.",
    ),
    option(
        "--draw",
        metavar="LIST",
        default="",
        show_default=False,
        help="Quantities to draw, by commas.",
    ),
    option("--status", is_flag=True, help="Tell how far the sweep is, and compute nothing."),
    result_options("the store sweep_MATERIAL.sqlite, .png, .csv and .nc"),
)
command(
    "doctor",
    """Tell what is installed, and how far cycles are from an independent solver's.

    The exit code is 1 where something that should work does not.
    """,
    json_option,
)
