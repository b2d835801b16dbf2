"""Results are named by their surface and, unless it is MIT's square, by their object: none takes
another's place.
"""

import json

import pytest

from cyclemap import CollectionLoop
from cyclemap.cli.main import run
from cyclemap.cli.output import result_name
from cyclemap.protocol import loop_from_settings

TABLE = 'name = "table"\n[friction]\nmu_a = 0.26\nmu_b = 0.2\n'


def test_two_objects_on_one_surface_leave_two_results(here) -> None:
    (here / "table.toml").write_text(TABLE)
    for setting in ("shape=rect1", "shape=hex", "shape=tri1", "object_name=lid"):
        start = ["--theta0-deg", "0", "--set", setting, "--out", "made"]
        assert run(["cycle", "table.toml", *start]) == 0
    names = sorted(path.name for path in (here / "made").iterdir())
    on_table = ["cycles_hex_on_table.json", "cycles_lid_on_table.json", "cycles_tri1_on_table.json"]
    assert names == sorted([*on_table, "cycles_table.json"])
    turns = {
        json.loads((here / "made" / name).read_text())["cycles"][0]["push_turn_deg"]
        for name in names
    }
    assert len(turns) == 3


def test_a_sweep_of_an_object_is_stored_by_its_name(here, capsys) -> None:
    for setting, name in (("shape=hex", "sweep_hex_on_plywood"), ("push_mm=90", "sweep_plywood")):
        over = ["--over", "mu_a=0.2,0.3", "--set", setting, "--status"]
        assert run(["sweep", "plywood", *over]) == 0
        assert f"{name}.sqlite" in capsys.readouterr().out
    assert run(["sweep", "plywood", "--over", "shape=hex,tri1", "--status"]) == 0
    assert "sweep_plywood.sqlite" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["rect1", "own outline"])
def test_a_name_borrowed_from_the_square_is_told(name) -> None:
    """An object of another outline that is called rect1, and one without a name."""
    loop = loop_from_settings({"semi_x_mm": 40, "semi_y_mm": 50, "object_name": name})
    assert result_name("portrait", loop) == f"portrait_{name.replace(' ', '_')}_on_plywood"
    assert result_name("portrait", CollectionLoop.mit()) == "portrait_plywood"
