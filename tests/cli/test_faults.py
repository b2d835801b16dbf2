"""What the world does to a command: closed output, odd names, odd surroundings; one line each, and no traceback."""

import os
import subprocess
import sys

import pytest

from cyclemap.cli.main import run
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, load_material

FRICTION = "[friction]\nmu_a = 0.3\nmu_b = 0.3\n"


def command(folder, *arguments, closed=(), **environment) -> subprocess.CompletedProcess:
    """Run `cyclemap` in a process of its own, with some of its outputs closed."""
    redirected = "".join(f" {number}>&-" for number in closed)
    return subprocess.run(
        ["sh", "-c", f'exec "$0" -m cyclemap "$@"{redirected}', sys.executable, *arguments],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_closed_output_is_told_or_at_least_a_failure(tmp_path) -> None:
    one, both = (command(tmp_path, "cycle", "plywood", closed=closed) for closed in ((1,), (1, 2)))
    assert (one.returncode, one.stdout, len(one.stderr.splitlines())) == (1, "", 1)
    assert "standard output is closed" in one.stderr
    assert (both.returncode, both.stdout, both.stderr) == (1, "", "")
    errors_closed = command(tmp_path, "cycle", "plywood", "--json", "-", closed=(2,))
    assert errors_closed.returncode == 0 and errors_closed.stdout.startswith("{")


@pytest.mark.slow
def test_pictures_need_no_screen_whatever_the_user_draws_with(tmp_path) -> None:
    done = command(tmp_path, "staircase", "isotropic", "--cycles", "20", MPLBACKEND="nonsense")
    assert done.returncode == 0 and all(" % done, " in line for line in done.stderr.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "picture"), [(r"$\frac{$", "png"), ("$", "png"), ("a$b$c", "png"), (r"\$x\$", "png"), (r"$\frac{$", "svg")]
)
def test_dollars_in_a_name_are_no_formula(tmp_path, capsys, name, picture) -> None:
    file = tmp_path / "odd.toml"
    file.write_text(f"name = 'a {name}'\n{FRICTION}")
    assert run(["staircase", str(file), "--cycles", "20", "--out", str(tmp_path), "--format", picture]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_what_a_terminal_would_obey_reaches_it_as_text(tmp_path, capsys) -> None:
    file = tmp_path / "\x1b[31mred.toml"
    file.write_text(FRICTION)
    assert run(["cycle", str(file), "--theta0-deg", "0"]) == 2
    shown = capsys.readouterr()
    assert "\x1b" not in shown.out + shown.err and r"\x1b[31mred" in shown.err
    data = tmp_path / "\x1b]0;title\x07.csv"
    data.write_text("theta0_deg\n" + "".join(f"{3 * number}\n" for number in range(200)))
    assert run(["fit", str(data), "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr()
    assert "\x1b" not in shown.out + shown.err and r"\x1b]0;title\x07" in shown.out


@pytest.mark.parametrize("name", ["", " ", "..", "///", "_", "\u202e", "a\x1b[31m", "a\nb", "a\u200bb"])
def test_a_name_that_cannot_name_a_file_or_be_seen_is_refused(name) -> None:
    with pytest.raises(InvalidInput, match=r"^a material's name is"):
        Material(name, EllipseFriction(0.3, 0.2))


def test_names_of_all_scripts_are_kept(tmp_path) -> None:
    file = tmp_path / "φύλλο 2.toml"
    file.write_text(FRICTION)
    assert load_material(file).name == "φύλλο 2"
