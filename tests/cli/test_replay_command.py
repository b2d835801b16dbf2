"""`cyclemap replay` from outside: its JSON, its picture, its table, and what it refuses."""

import json
import math

import numpy as np
import pytest

from cyclemap.cli.main import run
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


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Two pushes of rect1 that end 1 and 3 mm from where the simulator's do, and a file that is cut
    short.
    """
    model = QuasiStaticModel(
        Slider.mit("rect1"), EllipseFriction.isotropic(0.25), Pusher(friction=0.25), accuracy=1e-5
    )
    push = model.push(Pose(), WorldPush((0.012, 0.07), -math.pi / 2, 0.05), 0.5e-3)
    travel = np.linspace(0.0, 0.05, 101)
    course = push.trajectory
    poses = np.column_stack(
        [np.interp(travel, 0.05 - push.travel + course.path, part) for part in course.pose.T]
    )
    tip = np.column_stack([0.0 * travel + 0.012, 0.07 - travel, 0.0 * travel])
    home = tmp_path_factory.mktemp("data")
    for number, off in enumerate(OFF_MM):
        moved = poses + np.outer(np.clip(travel / 0.01 - 4.0, 0.0, 1.0), (1e-3 * off, 0.0, 0.0))
        series = {"object_pose": moved, "tip_pose": tip, "ft_wrench": 0.0 * tip}
        tables = {
            name: np.column_stack([10.0 * travel, part]).tolist() for name, part in series.items()
        }
        name = f"motion_surface=abs_shape=rect1_a=0_v=100_i=0.000_s=0.700_t=0.000_rep={number:04d}.json"
        (home / name).write_text(json.dumps(tables))
    (home / "cut.json").write_text("{")
    return home


@pytest.mark.slow
def test_json_tells_every_push_its_groups_and_the_files_left_out(data, saved_report) -> None:
    report = saved_report("out/replay_isotropic", "replay", "isotropic", "--data", str(data))
    assert (report["material"], report["pusher_friction"], report["pushes"]) == (
        "isotropic",
        0.25,
        2,
    )
    assert [row["error_mm"] for row in report["replays"]] == pytest.approx(list(OFF_MM), abs=0.01)
    assert [row["speed_mm_s"] for row in report["replays"]] == pytest.approx([100.0, 100.0])
    (group,) = report["by_object"]
    assert (group["object"], group["count"]) == ("rect1", 2)
    assert group["mean_error_mm"] == report["mean_error_mm"] == pytest.approx(2.0, abs=0.01)
    assert [row["count"] for row in report["by_speed"]] == [2]
    assert [entry["reason"][:8] for entry in report["not_replayed"]] == ["not JSON"]


@pytest.mark.slow
def test_people_get_a_table_by_object_whole_even_in_a_narrow_terminal(
    data, tmp_path, capsys, monkeypatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert (
        run(["replay", "isotropic", "--data", str(data), "--out", str(tmp_path), "--format", "svg"])
        == 0
    )
    shown = capsys.readouterr().out
    assert (
        "2 pushes replayed: they end 2.0 mm and 0.0° off on average; 1 file could not be." in shown
    )
    for part in ("turn error (°)", "rect1", "2.00", "cut.json: not JSON", "replay_isotropic.svg"):
        assert part in shown
    assert "…" not in shown


@pytest.mark.slow
def test_the_rods_friction_changes_the_replay(data, here, report_of) -> None:
    asked = ("replay", "isotropic", "--data", str(data), "--pusher-friction")
    sticking, sliding = (
        report_of(*asked, friction)["mean_turn_error_deg"] for friction in ("0.25", "0")
    )
    assert sticking < 0.01 and sliding > 0.5


def test_data_without_a_push_are_a_failure(data, refused) -> None:
    refused(
        ["replay", "isotropic", "--data", str(data / "cut.json")], "no push could be replayed", 1
    )


def test_a_table_without_names_of_objects_is_asked_for_its_convention(here, capsys) -> None:
    """Clockwise angles are refused with what to say, and that gives what the right ones give."""
    plate = Slider(Polygon(((0.05, 0.04), (-0.05, 0.04), (-0.05, -0.04), (0.05, -0.04))))
    model = QuasiStaticModel(plate, EllipseFriction.isotropic(0.25), Pusher(friction=0.25))
    ends = ("x0", "y0", "theta0", "x1", "y1", "theta1", "tip_x0", "tip_y0", "tip_x1", "tip_y1")
    for name, sense in (("right", 1.0), ("clockwise", -1.0)):
        lines = [",".join(ends)]
        for theta in np.linspace(0.1, 6.0, 30):
            start = Pose(0.0, 0.0, float(theta))
            place, way = start.to_world(0.012, 0.06), theta - math.pi / 2
            end = model.push(start, WorldPush(place, way, 0.05)).end
            tip = [place[0] + 0.05 * math.cos(way), place[1] + 0.05 * math.sin(way)]
            poses = [0.0, 0.0, sense * theta, end.x, end.y, sense * end.theta]
            lines.append(",".join(f"{value:.9f}" for value in (*poses, *place, *tip)))
        (here / f"{name}.csv").write_text("\n".join(lines))
    assert run(["init", "box.toml", "--rectangle-mm", "100,80", "--quiet"]) == 0
    words = ["replay", "isotropic", "--protocol", "box.toml", "--pusher-friction", "0.25"]
    words += ["--json", "-", "--data"]
    assert run([*words, "right.csv"]) == 0
    right = json.loads(capsys.readouterr().out)
    assert right["pushes"] == 30 and right["mean_error_mm"] < 0.01
    assert run([*words, "clockwise.csv"]) == 2
    assert "--angles clockwise" in capsys.readouterr().err
    assert run([*words, "clockwise.csv", "--angles", "clockwise"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["mean_error_mm"] == pytest.approx(right["mean_error_mm"], abs=1e-3)
