"""What cannot be meant is refused; what is likely not meant is said, in Python, on stderr and in
JSON.
"""

import json
import math
import re

import numpy as np
import pytest

from cyclemap import CollectionLoop
from cyclemap.cli.main import run
from cyclemap.errors import DoubtfulInput
from cyclemap.evidence import load_pushes, read_theta0_pairs
from cyclemap.mechanics import EllipseFriction, Material, Polygon, Slider

SQUARE = [(0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)]


def material(folder, friction: str):
    file = folder / "mine.toml"
    file.write_text(f"[friction]\n{friction}")
    return str(file)


def test_metres_where_millimetres_are_asked_are_refused(capsys) -> None:
    assert (
        run(
            [
                "cycle",
                "plywood",
                "--set",
                "vertices_mm=[[0.06,0.06],[-0.06,0.06],[-0.06,-0.06],[0.06,-0.06]]",
            ]
        )
        == 2
    )
    assert (
        "the ring is 15 mm from the centre of an object that reaches 0.08485 mm"
        in capsys.readouterr().err
    )


def test_a_ring_outside_the_object_is_told_once_on_stderr_and_in_json(capsys) -> None:
    with pytest.warns(DoubtfulInput, match="it lies outside"):
        Slider(Polygon(SQUARE), hitch=(-0.06, 0.0))
    assert (
        run(["cycle", "plywood", "--theta0-deg", "0", "--set", "hitch_x_mm=-60", "--json", "-"])
        == 0
    )
    shown = capsys.readouterr()
    (line,) = shown.err.splitlines()
    assert re.fullmatch(r"warning: the ring is 60\.93 mm .* it lies outside; .*", line)
    assert json.loads(shown.out)["warnings"] == [line.removeprefix("warning: ")]
    assert run(["cycle", "plywood", "--theta0-deg", "0", "--json", "-"]) == 0
    assert "warnings" not in json.loads(capsys.readouterr().out)


def test_friction_of_no_surface_or_with_one_axis_alone_is_refused_and_of_few_is_told(
    tmp_path, refused
) -> None:
    for options in (
        [material(tmp_path, "mu_a = 30\nmu_b = 25\n")],
        ["plywood", "--set", "mu_a=30"],
    ):
        refused(["cycle", *options], "friction of 30 is that of no surface")
    refused(["cycle", material(tmp_path, "mu_a = 0.3\n")], "a friction table needs mu_b")
    with pytest.warns(DoubtfulInput, match=r"friction of 2.5 is more than rubber's"):
        Material("sticky", EllipseFriction(2.5, 2.4))


@pytest.mark.parametrize("low", [0.0, -math.pi])
def test_radians_in_a_column_of_degrees_are_told(tmp_path, low) -> None:
    """And no angles in degrees: a circle of them, or some that lie close together near zero."""
    theta, file = low + np.linspace(0.0, 6.2, 30), tmp_path / "theta0.csv"
    for column in ("theta0_deg", "theta0_deg,theta_next_deg"):
        file.write_text(
            f"{column}\n"
            + "".join(f"{','.join([f'{t:.4f}'] * len(column.split(',')))}\n" for t in theta)
        )
        with pytest.warns(DoubtfulInput, match="are these radians"):
            read_theta0_pairs(file)
    poses = ["x0,y0,theta0_deg,x1,y1,theta1_deg", *(f"0,0,{t:.4f},0,0,{t:.4f}" for t in theta)]
    file.write_text("\n".join(poses) + "\n")
    with pytest.warns(DoubtfulInput, match="theta0_deg runs from"):
        load_pushes(file)
    for degrees in (np.rad2deg(theta), 0.3 * theta):
        file.write_text("theta0_deg\n" + "".join(f"{t:.4f}\n" for t in degrees))
        read_theta0_pairs(file)


def test_degrees_for_a_cycle_in_radians_are_told() -> None:
    loop = CollectionLoop.mit(material="plywood")
    with pytest.warns(
        DoubtfulInput, match=r"theta is 60 rad, more than a turn: .* math.radians\(60\)"
    ):
        loop.cycle(60)
    for theta in (3, 0, -6.0, 60.5, math.radians(720.0)):
        loop.cycle(theta)
