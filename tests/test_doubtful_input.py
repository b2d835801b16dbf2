"""What cannot be meant is refused; what is likely not meant is said, in Python, on stderr and in
JSON.
"""

import json
import math
import re

import numpy as np
import pytest

from cyclemap import CollectionLoop
from cyclemap.errors import DoubtfulInput
from cyclemap.evidence import load_pushes, read_theta0_pairs
from cyclemap.mechanics import EllipseFriction, Material, Polygon, Slider

SQUARE = [(0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)]


def test_what_cannot_be_meant_is_refused(here, said, refused) -> None:
    """Metres for millimetres; friction of no surface, or along one axis alone."""
    metres = "vertices_mm=[[0.06,0.06],[-0.06,0.06],[-0.06,-0.06],[0.06,-0.06]]"
    reach = "the ring is 15 mm from the centre of an object that reaches 0.08485 mm"
    assert reach in said(f"cycle plywood --set {metres}", 2).err
    (here / "rough.toml").write_text("[friction]\nmu_a = 30\nmu_b = 25\n")
    (here / "half.toml").write_text("[friction]\nmu_a = 0.3\n")
    for material in ("rough.toml", "plywood --set mu_a=30"):
        refused(f"cycle {material}", "friction of 30 is that of no surface")
    refused("cycle half.toml", "a friction table needs mu_b")
    with pytest.warns(DoubtfulInput, match=r"friction of 2.5 is more than rubber's"):
        Material("sticky", EllipseFriction(2.5, 2.4))


def test_a_ring_outside_the_object_is_told_once_on_stderr_and_in_json(said, report_of) -> None:
    with pytest.warns(DoubtfulInput, match="it lies outside"):
        Slider(Polygon(SQUARE), hitch=(-0.06, 0.0))
    line = "cycle plywood --theta0-deg 0"
    shown = said(f"{line} --set hitch_x_mm=-60 --json -")
    (warning,) = shown.err.splitlines()
    assert re.fullmatch(r"warning: the ring is 60\.93 mm .* it lies outside; .*", warning)
    assert json.loads(shown.out)["warnings"] == [warning.removeprefix("warning: ")]
    assert "warnings" not in report_of(line)


@pytest.mark.parametrize("low", [0.0, -math.pi])
def test_radians_in_a_column_of_degrees_are_told(tmp_path, low) -> None:
    """And no angles in degrees: a circle of them, or some that lie close together near zero."""
    theta, file = low + np.linspace(0.0, 6.2, 30), tmp_path / "theta0.csv"

    def write(header: str, row: str, angles: np.ndarray = theta) -> None:
        rows = [row.replace("θ", f"{angle:.4f}") for angle in angles]
        file.write_text("\n".join([header, *rows]) + "\n")

    for columns, row in (("theta0_deg", "θ"), ("theta0_deg,theta_next_deg", "θ,θ")):
        write(columns, row)
        with pytest.warns(DoubtfulInput, match="are these radians"):
            read_theta0_pairs(file)
    write("x0,y0,theta0_deg,x1,y1,theta1_deg", "0,0,θ,0,0,θ")
    with pytest.warns(DoubtfulInput, match="theta0_deg runs from"):
        load_pushes(file)
    for angles in (np.rad2deg(theta), 0.3 * theta):
        write("theta0_deg", "θ", angles)
        read_theta0_pairs(file)


def test_degrees_for_a_cycle_in_radians_are_told() -> None:
    loop = CollectionLoop.mit(material="plywood")
    told = r"theta is 60 rad, more than a turn: .* math.radians\(60\)"
    with pytest.warns(DoubtfulInput, match=told):
        loop.cycle(60)
    for theta in (3, 0, -6.0, 60.5, math.radians(720.0)):
        loop.cycle(theta)
