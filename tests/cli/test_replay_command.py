"""`cyclemap replay` from outside: its JSON, its picture, its table, and what it refuses."""

import json
import math

import numpy as np
import pytest

from cyclemap.mechanics import (
    EllipseFriction,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    Slider,
    WorldPush,
)

OFF_MM = (1.0, 3.0)
FRICTION, ROD = EllipseFriction.isotropic(0.25), Pusher(friction=0.25)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Two pushes of rect1 that end 1 and 3 mm from where the simulator's do, and a file that is cut
    short.
    """
    model = QuasiStaticModel(Slider.mit("rect1"), FRICTION, ROD, accuracy=1e-5)
    push = model.push(Pose(), WorldPush((0.012, 0.07), -math.pi / 2, 0.05), 0.5e-3)
    travel = np.linspace(0.0, 0.05, 101)
    path, course = 0.05 - push.travel + push.trajectory.path, push.trajectory.pose
    poses = np.column_stack([np.interp(travel, path, column) for column in course.T])
    tip = np.column_stack([0.0 * travel + 0.012, 0.07 - travel, 0.0 * travel])
    home = tmp_path_factory.mktemp("data")
    name = "motion_surface=abs_shape=rect1_a=0_v=100_i=0.000_s=0.700_t=0.000_rep"
    for number, off in enumerate(OFF_MM):
        moved = poses + np.outer(np.clip(travel / 0.01 - 4.0, 0.0, 1.0), (1e-3 * off, 0.0, 0.0))
        series = {"object_pose": moved, "tip_pose": tip, "ft_wrench": 0.0 * tip}
        tables = {
            key: np.column_stack([10.0 * travel, rows]).tolist() for key, rows in series.items()
        }
        (home / f"{name}={number:04d}.json").write_text(json.dumps(tables))
    (home / "cut.json").write_text("{")
    return home


@pytest.mark.slow
def test_json_tells_every_push_its_groups_and_the_files_left_out(data, saved_report) -> None:
    report = saved_report("out/replay_isotropic", f"replay isotropic --data {data}")
    assert [report[key] for key in ("material", "pusher_friction")] == ["isotropic", 0.25]
    assert report["pushes"] == 2
    assert [row["error_mm"] for row in report["replays"]] == pytest.approx(list(OFF_MM), abs=0.01)
    assert [row["speed_mm_s"] for row in report["replays"]] == pytest.approx([100.0, 100.0])
    (group,) = report["by_object"]
    assert (group["object"], group["count"]) == ("rect1", 2)
    assert group["mean_error_mm"] == report["mean_error_mm"] == pytest.approx(2.0, abs=0.01)
    assert [row["count"] for row in report["by_speed"]] == [2]
    assert [entry["reason"][:8] for entry in report["not_replayed"]] == ["not JSON"]


@pytest.mark.slow
def test_people_get_a_table_by_object_whole_even_in_a_narrow_terminal(
    data, here, said, monkeypatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    shown = said(f"replay isotropic --data {data} --format svg").out
    headline = "2 pushes replayed: they end 2.0 mm and 0.0° off on average; 1 file could not be."
    told = ("turn error (°)", "rect1", "2.00", "cut.json: not JSON", "replay_isotropic.svg")
    for words in (headline, *told):
        assert words in shown
    assert "…" not in shown


@pytest.mark.slow
def test_the_rods_friction_changes_the_replay(data, here, report_of) -> None:
    sticking, sliding = (
        report_of(f"replay isotropic --data {data} --pusher-friction {friction}")
        for friction in (0.25, 0)
    )
    assert sticking["mean_turn_error_deg"] < 0.01 and sliding["mean_turn_error_deg"] > 0.5


def test_data_without_a_push_are_a_failure(data, refused) -> None:
    refused(f"replay isotropic --data {data}/cut.json", "no push could be replayed", 1)


def test_a_table_without_names_of_objects_is_asked_for_its_convention(
    here, said, report_of
) -> None:
    """Clockwise angles are refused with what to say, and that gives what the right ones give."""
    plate = Slider(Polygon(((0.05, 0.04), (-0.05, 0.04), (-0.05, -0.04), (0.05, -0.04))))
    model = QuasiStaticModel(plate, FRICTION, ROD)
    rows = []
    for theta in np.linspace(0.1, 6.0, 30).tolist():
        start = Pose(0.0, 0.0, theta)
        place, way = start.to_world(0.012, 0.06), theta - math.pi / 2
        end = model.push(start, WorldPush(place, way, 0.05)).end
        tip = (place[0] + 0.05 * math.cos(way), place[1] + 0.05 * math.sin(way))
        rows.append([0.0, 0.0, theta, end.x, end.y, end.theta, *place, *tip])
    header = "x0,y0,theta0,x1,y1,theta1,tip_x0,tip_y0,tip_x1,tip_y1"
    for name, sense in (("right", 1.0), ("clockwise", -1.0)):
        seen = np.array(rows) * (1, 1, sense, 1, 1, sense, 1, 1, 1, 1)
        np.savetxt(here / f"{name}.csv", seen, "%.9f", ",", header=header, comments="")
    said("init box.toml --rectangle-mm 100,80 --quiet")
    line = "replay isotropic --protocol box.toml --pusher-friction 0.25 --data"
    right = report_of(f"{line} right.csv", silent=False)
    assert right["pushes"] == 30 and right["mean_error_mm"] < 0.01
    assert "--angles clockwise" in said(f"{line} clockwise.csv", 2).err
    told = report_of(f"{line} clockwise.csv --angles clockwise", silent=False)
    assert told["mean_error_mm"] == pytest.approx(right["mean_error_mm"], abs=1e-3)
