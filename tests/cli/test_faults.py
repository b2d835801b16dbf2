"""What goes wrong: bad use of any command, closed output, odd names and surroundings; one line
each, no traceback.
"""

import os
import subprocess
import sys

import pytest

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, load_material

FILES = {
    "bad.csv": "theta0_deg\n1\nx\n",
    "far.csv": "theta0_deg\n1\n1e300\n",
    "own.csv": "speed;force\n1;2\n",
    "none_good.csv": "theta0_deg,good\n1,0\n2,0\n3,0\n",
    "plain.toml": "[push]\npush_mm = 100\n",
    "measured.csv": "theta0_deg\n" + "".join(f"{7 * n % 360}\n" for n in range(120)),
    "pairs.csv": "theta0_deg,theta_next_deg\n" + "".join(f"{n},{n + 2}\n" for n in range(50)),
    "poses.csv": "rep,surface,x0,y0,theta0,x1,y1,theta1\n"
    + "".join(f"{n},plywood,0,0,1,0,-0.1,2\n" for n in range(5)),
}
# Two commands before all arguments, which have a line of their own.
COMPARE = "compare plywood --data measured.csv"
SWEEP = "sweep plywood --over hitch_x_mm=-12:0:5"
BAD_USES = {
    "portait plywood": "portait",
    "cycle": "give one material",
    "cycle plywod": "did you mean 'plywood'",
    "cycle missing.toml": "missing.toml",
    "cycle plywood --material x.toml": "give one material",
    "cycle plywood --set mu_aa=1": "did you mean 'mu_a'",
    "cycle plywood --set mu_a": "key=value",
    "cycle plywood --set mu_a=high": "mu_a",
    "cycle plywood --set side=7": "side",
    "cycle plywood --set hitch_x_mm=inf": "hitch",
    "cycle plywood --set footprint=grid:0": "grid",
    "cycle plywood --set footprint=grid:100000": "100000 points a side",
    "cycle plywood --set footprint=grid:١٢": "none of: exact",
    "cycle plywood --set noise_deg=0": "noise_deg",
    "cycle plywood --theta0-deg 0,x": "'x'",
    "cycle plywood --theta0-deg nan": "'nan'",
    "cycle plywood --theta0-deg 1e300": "lost to rounding",
    "cycle plywood --theta0-deg 1,,2": "''",
    "cycle plywood --protocol none.toml": "none.toml",
    "cycle plywood --speed 3": "--speed",
    "portrait plywood --data none.csv": "none.csv",
    "portrait plywood --cycles 0": "--cycles",
    "dynamics plywood --theta0-deg x": "theta0-deg",
    "dynamics plywood --speed-mm-s 0": "0.0 is not in the range x>0",
    "dynamics plywood --set pusher_radius_mm=0": "thicker rod",
    "experiment plywood --batches 0": "batches",
    "experiment plywood --cycles 0": "cycles",
    "experiment plywood --speed-mm-s -1": "-1.0 is not in the range x>0",
    "staircase plywood --data pairs.csv": "order",
    "figures sadle-node": "did you mean 'saddle-node'",
    "figures staircases --data nowhere": "nowhere",
    "figures staircases --format gif": "gif",
    "fingerprint --check": "name a MATERIAL",
    "fingerprint plywood --set 'way_points_mm=[[0, 50]]'": "fixed in the world",
    "reset plywood --allow-tv 0": "--allow-tv",
    "reset plywood --within 0": "--within",
    "reset plywood --with wings": "--with",
    "reset plywood --cycles 1000000000": "--cycles",
    "reset plywood --likely no-such-wood": "unknown material 'no-such-wood'",
    "reset plywood --likely pu --axes-percent 60": "--likely takes the place of --axes-percent",
    "reset plywood --axes-percent 100": "--axes-percent",
    "simulate plywood --out made --noise-deg -1": "-1.0 is not in the range",
    "simulate plywood --out made --pose-noise-mm nan": "--pose-noise-mm': nan is in no range",
    "simulate plywood --out made --speed-mm-s 0": "0.0 is not in the range",
    "simulate plywood --out made --start-deg inf": "start must be a finite number",
    "compare --data measured.csv": "material",
    f"{COMPARE} --runs 3": "runs",
    f"{COMPARE} --first 1000": "first is 1000",
    f"{COMPARE} --first -1": "first",
    f"{COMPARE} --select surface=delrin": "orientations alone and tell no surface",
    "fit": "DATA",
    "fit nowhere": "nowhere: there is nothing there",
    "fit poses.csv --select surface": "not of the form key=value",
    "fit poses.csv --select surfac=abs": "did you mean 'surface'",
    "fit poses.csv --select surface=abs": "no such surface: abs; the data have plywood",
    "fit poses.csv --select side=north": "give a finite number",
    "fit poses.csv --harmonics -1": "harmonics",
    "replay isotropic": "--data",
    "replay isotropic --data nowhere": "nowhere",
    "replay isotropic --data . --pusher-friction -1": "pusher-friction",
    "audit . --units deg,mm": "files in the MIT layout tell their columns and units",
    "sweep plywood": "over",
    "sweep --over hitch_x_mm=-12:0:5": "give a material",
    "sweep plywood --over mu_a=0.2:0.3": "mu_a is a range without a count",
    "sweep plywood --over mu_a=0.2:0.3 --sample 4 --over mu_a=1:2": "mu_a is swept twice",
    f"{SWEEP} --workers 0": "x>=1",
    f"{SWEEP} --export xls": "unknown format to export 'xls'",
    f"{SWEEP} --draw tv_from_uniform": "unknown quantity to draw",
    f"{SWEEP} --tolerance-deg -1": "tolerance must be positive",
    f"{SWEEP} --rotation-tolerance -1": "rotation_tolerance must not be negative",
    f"{SWEEP} --seed 0 --sequence sobol": "--seed and --sequence: a grid has none",
    "watch": "FILE",
    "watch bad.csv": "bad.csv, line 3: theta0_deg is 'x'; it must be a finite number",
    "watch none.csv": "none.csv: there is no such file",
    "watch none_good.csv": "none_good.csv",
    "watch bad.csv --alarm-rate 0": "--alarm-rate",
    "watch bad.csv --alarm-rate nan": "nan is in no range",
    "watch measured.csv --every 2": "--every 2: only --follow looks again",
    "watch bad.csv --follow --every 86400.1": "0.01<=x<=86400",
    "watch bad.csv --follow --every 0.001": "0.01<=x<=86400",
    "watch bad.csv --columns yaw": "is not of the form theta0=yaw",
    "watch own.csv": "say which, --columns theta0=NAME; it has speed, force",
    "watch far.csv": "line 3: theta0_deg is '1e300'; at such a size the fraction of a turn is lost",
    "watch measured.csv --protocol plain.toml": "there is no action to choose",
    "watch measured.csv --material plywood": "plywood has no samples of what is believed of it",
}
FRICTION = "[friction]\nmu_a = 0.3\nmu_b = 0.3\n"


@pytest.mark.parametrize("line", BAD_USES)
def test_bad_use_exits_2_with_one_clear_line_and_writes_nothing(here, refused, line) -> None:
    for name, text in FILES.items():
        (here / name).write_text(text)
    refused(line, BAD_USES[line])


def command(folder, line, closed=(), **environment) -> subprocess.CompletedProcess:
    """Run `cyclemap` in a process of its own, with some of its outputs closed."""
    redirected = "".join(f" {number}>&-" for number in closed)
    return subprocess.run(
        ["sh", "-c", f"exec {sys.executable} -m cyclemap {line}{redirected}"],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_closed_output_is_told_or_at_least_a_failure(tmp_path) -> None:
    one, both = (command(tmp_path, "cycle plywood", closed) for closed in ((1,), (1, 2)))
    assert (one.returncode, one.stdout, len(one.stderr.splitlines())) == (1, "", 1)
    assert "standard output is closed" in one.stderr
    assert (both.returncode, both.stdout, both.stderr) == (1, "", "")
    errors_closed = command(tmp_path, "cycle plywood --json -", closed=(2,))
    assert errors_closed.returncode == 0 and errors_closed.stdout.startswith("{")


@pytest.mark.slow
def test_pictures_need_no_screen_whatever_the_user_draws_with(tmp_path) -> None:
    done = command(tmp_path, "staircase isotropic --cycles 20", MPLBACKEND="nonsense")
    assert done.returncode == 0 and all(" % done, " in line for line in done.stderr.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("picture", ["png", "svg"])
def test_dollars_in_a_name_are_no_formula(here, said, picture) -> None:
    (here / "odd.toml").write_text(rf"name = 'a$b$c \$x\$ $\frac{{$'{chr(10)}{FRICTION}")
    assert said(f"staircase odd.toml --cycles 20 --format {picture}").err == ""


@pytest.mark.slow
def test_what_a_terminal_would_obey_reaches_it_as_text(here, said) -> None:
    (here / "\x1b[31mred.toml").write_text(FRICTION)
    shown = said("cycle '\x1b[31mred.toml' --theta0-deg 0", 2)
    assert "\x1b" not in shown.out + shown.err and r"\x1b[31mred" in shown.err
    (here / "\x1b]0;title\x07.csv").write_text(FILES["measured.csv"])
    shown = said("fit '\x1b]0;title\x07.csv'")
    assert "\x1b" not in shown.out + shown.err and r"\x1b]0;title\x07" in shown.out


@pytest.mark.parametrize("name", ["", " ", "..", "///", "_", "\u202e", "a\nb", "a\u200bb"])
def test_a_name_that_cannot_name_a_file_or_be_seen_is_refused(name) -> None:
    with pytest.raises(InvalidInput, match=r"^a material's name is"):
        Material(name, EllipseFriction(0.3, 0.2))


def test_names_of_all_scripts_are_kept(tmp_path) -> None:
    file = tmp_path / "φύλλο 2.toml"
    file.write_text(FRICTION)
    assert load_material(file).name == "φύλλο 2"
