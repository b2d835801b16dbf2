"""`cyclemap reset` from outside: its files, its JSON, its table and sentences, and what it refuses."""

import csv
import json
import math
import tomllib
from types import SimpleNamespace

import pytest

from cyclemap.cli import main, reset_robust
from cyclemap.cli.reset_robust import followed_under_wear
from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush
from cyclemap.resets.design import reset_candidates
from cyclemap.resets.design.reset_candidates import Effort
from cyclemap.resets.protocol.protocol_file import write_protocol
from cyclemap.resets.robust import robust_weights
from cyclemap.resets.robust.material_score import QuickGrid
from cyclemap.resets.strategies.drag_strategies import GripperTurn
from cyclemap.resets.strategies.push_strategies import AlternatingPushes

LITTLE = Effort((), (), (), (), (), 4, 0, 1, 1)
# Noise so wide that a few modes do.
QUICK = ("--quick", "--set", "noise_deg=25", "--pushes", "20", "--cycles", "30")


@pytest.fixture(autouse=True)
def few_strategies(monkeypatch) -> None:
    monkeypatch.setitem(reset_candidates.EFFORTS, "quick", LITTLE)


def refuse(name: str) -> None:
    pytest.fail(f"JSON holds {name}")


def run_json(tmp_path, capsys, *arguments):
    assert main.run(["reset", "plywood", *QUICK, *arguments, "--out", str(tmp_path), "--json", "-"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    return json.loads(shown.out, parse_constant=refuse), shown.out


def test_a_reset_that_meets_the_demands_is_ranked_written_and_drawn(tmp_path, capsys) -> None:
    report, text = run_json(tmp_path, capsys, "--allow-tv", "0.05", "--seed", "3")
    assert (report["material"], report["met"], report["certified"], report["reasons"]) == ("plywood", True, True, [])
    assert report["noise_deg"] == pytest.approx(25.0)
    chosen, ranking = report["chosen"], report["ranking"]
    assert chosen["tv"] + chosen["tv_error"] <= 0.05 and chosen["tv_after"] + chosen["tv_after_error"] <= 0.1
    assert sum(push["chance"] for push in chosen["pushes"]) == pytest.approx(1.0)
    met = [one for one in ranking if one["meets"]]
    assert met == ranking[: len(met)] and len(ranking) >= 8
    assert [one["mean_drag_mm"] for one in met] == sorted(one["mean_drag_mm"] for one in met)
    assert report["own"]["name"] == "as it is" and report["own"]["drag_ratio"] == 1.0
    assert [one["lacking"] for one in ranking[-2:]] == [["gripper"], ["gripper"]]
    assert report["trial"]["pushes"] == 20 and isinstance(report["trial"]["agrees"], bool)
    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert set(written) == {f"reset_plywood.{ending}" for ending in ("png", "json", "toml", "csv")}
    assert written["reset_plywood.png"].startswith(b"\x89PNG")
    assert written["reset_plywood.json"].decode() == text
    protocol = tomllib.loads(written["reset_plywood.toml"].decode())
    assert protocol["predicted"]["tv"] == pytest.approx(chosen["tv"])
    rows = [row for row in written["reset_plywood.csv"].decode().splitlines() if not row.startswith("#")]
    schedule = list(csv.DictReader(rows))
    allowed = {(str(push["side"]), push["fraction"]) for push in chosen["pushes"]}
    assert len(schedule) == 30
    assert {(row["side"], float(row["fraction"])) for row in schedule} <= allowed


def test_demands_that_nothing_meets_are_answered_and_not_an_error(tmp_path, capsys) -> None:
    impossible = ("--keep-push", "--reach-mm", "50", "--drag-ratio", "0.5", "--pushes", "0", "--format", "svg")
    report, _ = run_json(tmp_path, capsys, *impossible)
    assert (report["met"], report["certified"]) == (False, False)
    assert "trial" not in report and report["demands"]["keep_push"]
    binding = {one["demand"]: one for one in report["binding"]}
    assert set(binding) >= {"reach", "drag"}
    assert binding["reach"]["limit_mm"] == pytest.approx(50.0) and binding["reach"]["least_mm"] > 150.0
    assert any("A push of 150 mm alone takes 80 mm" in reason for reason in report["reasons"])
    assert all(one["kind"] in ("straight", "gripper turn") for one in report["ranking"])
    assert (tmp_path / "reset_plywood.svg").read_bytes().startswith(b"<?xml")


def test_people_read_the_table_the_verdict_and_where_the_files_are(tmp_path, capsys) -> None:
    arguments = ("--keep-push", "--allow-tv", "0.001", "--with", "gripper")
    assert main.run(["reset", "plywood", *QUICK, *arguments, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    for words in ("Resets for plywood", "misses TV", "meets all", "as it is", "gripper, any turn", "room (mm)"):
        assert words in shown
    assert "plywood: “gripper, any turn” meets all demands: total variation from uniform 0.000" in shown
    assert "20 pushes by the full mechanics agree with the prediction" in shown
    for ending in ("png", "toml", "csv"):
        assert f"{tmp_path / 'reset_plywood'}.{ending}" in shown


def test_the_strategy_of_a_protocol_is_ranked_with_the_others(tmp_path, capsys) -> None:
    protocol = tmp_path / "mine.toml"
    write_protocol(protocol, CollectionLoop.mit(), GripperTurn(1.0), noise=WrappedNormal(0.5))
    arguments = ("--protocol", str(protocol), "--keep-push", "--pushes", "0", "--quick", "--json", "-")
    assert main.run(["reset", "abs", *arguments, "--out", str(tmp_path / "other")]) == 0
    report = json.loads(capsys.readouterr().out, parse_constant=refuse)
    assert report["noise_deg"] == pytest.approx(math.degrees(0.5)) and report["material"] == "abs"
    given = [one for one in report["ranking"] if one["name"] == "gripper turn (given)"]
    assert len(given) == 1 and given[0]["lacking"] == ["gripper"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ply"], "ply"),
        (["plywood", "--allow-tv", "0"], "--allow-tv"),
        (["plywood", "--allow-tv", "nan"], "allow_tv must be a finite number"),
        (["plywood", "--extra-tv", "1"], "--extra-tv"),
        (["plywood", "--within", "0"], "--within"),
        (["plywood", "--drag-ratio", "-1"], "--drag-ratio"),
        (["plywood", "--reach-mm", "inf"], "reach must be a finite number"),
        (["plywood", "--with", "magnet"], "magnet"),
        (["plywood", "--cycles", "0"], "--cycles"),
        (["plywood", "--set", "nonsense=1"], "nonsense"),
        (["plywood", "--robust", "--ratio-percent", "100"], "--ratio-percent"),
        (["plywood", "--robust", "--offset-percent", "5000"], "friction ellipse"),
        (["plywood", "--robust", "--keep-push"], "--robust draws pushes"),
        (["plywood", "--materials", "0"], "--materials"),
        (["plywood", "--wear"], "plywood does not wear: name the worn surface with --wear-to"),
        (["plywood", "--wear-to", "plyw"], "plyw"),
        (["plywood-measured", "--wear", "--cycles", "1"], "2 pushes or more"),
        ([], "give one material"),
    ],
)
def test_bad_use_is_one_line_and_code_2(arguments, words, tmp_path, capsys) -> None:
    assert main.run(["reset", *arguments, "--quick", "--out", str(tmp_path)]) == 2
    shown = capsys.readouterr()
    assert words in shown.err and shown.err.count("\n") == 1 and shown.out == ""
    assert not list(tmp_path.iterdir())


@pytest.fixture
def little_robust(monkeypatch) -> None:
    """Three pushes to choose from and few orientations; how well they do is not what is tested."""
    monkeypatch.setattr(robust_weights, "FRACTIONS", (0.7,))
    monkeypatch.setattr(reset_robust, "ROBUST_GRID", QuickGrid(samples=8, modes=8, allowed=1.0))


def test_a_robust_reset_is_checked_on_sampled_materials_and_followed_under_wear(
    tmp_path, capsys, little_robust
) -> None:
    asked = ("--allow-tv", "0.5", "--drag-ratio", "4", "--pushes", "0", "--wear-to", "plywood-measured")
    narrow = ("--robust", "--ratio-percent", "5", "--offset-percent", "0", "--materials", "3", "--workers", "1")
    report, _ = run_json(tmp_path, capsys, *narrow, *asked)
    robust, chosen = report["robust"], report["chosen"]
    assert robust["holds"] and (robust["materials"], robust["corners"], robust["exceeding"]) == (3, 2, 0)
    assert robust["range"] == {"ratio_percent": 5.0, "offset_percent": 0.0, "direction": "any"}
    assert robust["share_exceeding_95"] == pytest.approx(1.0 - 0.05 ** (1 / 3))
    assert robust["nominal_tv"] <= robust["worst_tv"] <= 0.5
    assert abs(robust["worst_material"]["ratio_off_percent"]) <= 5.0
    assert robust["first_by_nominal"]["name"] == report["ranking"][1]["name"]
    assert chosen["name"] == report["ranking"][0]["name"] == "drawn pushes, robust"
    shares = {(push["side"], push["fraction"]): push["chance"] for push in robust["pushes"]}
    assert shares == {(push["side"], push["fraction"]): push["chance"] for push in chosen["pushes"]}
    assert sum(shares.values()) == pytest.approx(1.0) and {fraction for _, fraction in shares} == {0.7}
    # The nominal material twice: on a grid of eight orientations, and by maps to 1e-5 with error bounds.
    assert chosen["certified"] and chosen["tv"] == pytest.approx(robust["nominal_tv"], abs=0.02)
    protocol = tomllib.loads((tmp_path / "reset_plywood.toml").read_text())
    assert protocol["predicted"]["tv"] == pytest.approx(chosen["tv"])
    assert protocol["predicted"]["robust_holds"] and protocol["predicted"]["robust_worst_tv"] == robust["worst_tv"]
    wear = report["wear"]
    assert wear["followed"] and (wear["pushes"], wear["surface"], wear["allow_tv"]) == (30, "plywood", 0.5)
    # Fresh is the nominal material of the check: the same number by the same grid.
    assert wear["fresh_tv"] == pytest.approx(robust["nominal_tv"], abs=1e-6) and wear["worn_tv"] != wear["fresh_tv"]
    assert (wear["leaves_at_push"] is None) == ("throughout" in wear["says"])
    for name in ("robust", "wear"):
        assert (tmp_path / f"reset_plywood_{name}.png").read_bytes().startswith(b"\x89PNG")


def test_pushes_that_know_of_each_other_are_not_followed_under_wear() -> None:
    pushes = AlternatingPushes((SidePush(side=0), SidePush(side=2)))
    chosen = SimpleNamespace(candidate=SimpleNamespace(strategy=pushes))
    design = SimpleNamespace(chosen=chosen, demands=SimpleNamespace(allow_tv=0.05), loop=CollectionLoop.mit())
    told = followed_under_wear(design, CollectionLoop.mit("plywood-measured"), 100)
    assert told.course is None and "know of each other (periodic)" in told.told()
    assert told.report() == {"followed": False, "reason": told.why_not}
