"""`cyclemap watch` from outside: once over a file, and following one that grows until it is
interrupted.
"""

import json
import math
import signal
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from foreign_tables import Foreign, canonical, millimetres

from cyclemap.cli.collected import run_watch as module
from cyclemap.cli.commands import WatchOptions
from cyclemap.cli.main import run
from cyclemap.cli.options import ResultOptions, TableOptions
from cyclemap.collection.lock_forecast import forecast_from_turns, sampled_turns, turns_after_log
from cyclemap.errors import DataFileError

LOCKED = [20.0, 28.0, 36.0, 44.0, 52.0, *[60.0 + 0.3 * (k % 3) for k in range(30)]]
FOLLOW = ("--follow", "--every", "0.5")


def rows(angles) -> str:
    return "".join(f"{angle:.3f}\n" for angle in angles)


def data_file(folder: Path, angles=LOCKED) -> Path:
    file = folder / "my run.csv"
    file.write_text("theta0_deg\n" + rows(angles))
    return file


@pytest.mark.slow
def test_one_look_tells_alarm_direction_coverage_and_advice(here, capsys, saved_report) -> None:
    asked = ["watch", str(data_file(here)), "--alarm-rate", "0.1"]
    report = saved_report("out/watch_my_run", *asked)
    parts = (
        "file pushes alarm_rate alarm evidence rest useful_pushes recent_worth coverage "
        "advice multiplier"
    )
    assert set(report) == set(parts.split())
    assert (report["file"], report["pushes"], report["alarm_rate"]) == ("my run.csv", 35, 0.1)
    assert report["alarm"]["directions_deg"] == [pytest.approx(60.0, abs=3.0)]
    told = report["multiplier"]
    assert told is None or told["lower"] <= told["value"] <= told["upper"]
    assert report["rest"]["towards_deg"] == [pytest.approx(60.3, abs=0.5)]
    assert (
        report["evidence"]["rest_log10"]
        >= report["evidence"]["threshold_log10"]
        == pytest.approx(math.log10(20.0))
    )
    assert report["advice"] == {
        "change_reset": True,
        "direction_deg": pytest.approx(235.0, abs=10.0),
    }
    assert run(asked) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    for part in (
        f"ALARM at push {report['alarm']['push']}",
        "θ0 rests near 6",
        "Change the reset",
        "watch_my_run.png",
    ):
        assert part in shown.out


def grown(monkeypatch, *steps) -> None:
    """Let each wait of --follow take the next of `steps`, and interrupt it after the last."""
    waiting = iter(steps)

    def wait(seconds: float) -> None:
        assert seconds == 0.5
        try:
            next(waiting)()
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(module.time, "sleep", wait)


def append(file: Path, text: str):
    """A step that writes more to a file."""

    def act() -> None:
        with file.open("a") as stream:
            stream.write(text)

    return act


@pytest.mark.slow
def test_following_prints_a_line_of_json_for_each_push_and_keeps_the_last_report(
    here, capsys, monkeypatch
) -> None:
    file = data_file(here, LOCKED[:10])
    grown(
        monkeypatch,
        append(file, rows(LOCKED[10:])[:-3]),
        append(file, rows(LOCKED)[-3:]),
        append(file, "1"),
    )
    assert run(["watch", str(file), *FOLLOW, "--json", "-"]) == 130
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["push"] for line in lines] == list(range(len(LOCKED)))
    assert json.loads((here / "out" / "watch_my_run.json").read_text())["pushes"] == len(LOCKED)
    assert [line["theta0_deg"] for line in lines] == pytest.approx(LOCKED)
    raised = [line["push"] for line in lines if line["alarm"]]
    assert raised == list(range(raised[0], len(LOCKED)))


@pytest.mark.slow
def test_following_tells_people_what_changes_and_a_file_that_begins_anew(
    here, capsys, monkeypatch
) -> None:
    file = data_file(here)
    grown(
        monkeypatch,
        lambda: None,
        lambda: file.write_text("theta0_deg\n" + rows([10, 100, 190, 280])),
    )
    assert run(["watch", str(file), *FOLLOW]) == 130
    shown = capsys.readouterr()
    assert shown.out.count("ALARM at push") == 1
    assert shown.err.startswith(f"watching {file} until interrupted")
    assert "began anew, and so does the watch" in shown.err
    assert "No alarm in 4 pushes" in shown.out
    assert json.loads((here / "out" / "watch_my_run.json").read_text())["pushes"] == 4


def test_a_table_of_ones_own_is_watched_like_ours_and_followed(
    here, capsys, monkeypatch, report_of
) -> None:
    """Semicolons and decimal commas under another name: the report is that of the same angles in
    our columns.
    """
    own = here / "log.csv"
    lines = [f"{n};{angle:.2f}\n".replace(".", ",") for n, angle in enumerate(LOCKED)]
    own.write_text("Nr;Winkel vorher\n" + "".join(lines))
    ours = report_of("watch", str(data_file(here)))
    asked = [
        "watch",
        "log.csv",
        "--columns",
        "theta0=Winkel vorher",
        "--units",
        "deg",
        "--json",
        "-",
    ]
    assert run(asked) == 0
    shown = capsys.readouterr()
    assert {**json.loads(shown.out), "file": "my run.csv"} == ours
    assert "Winkel vorher read as theta0 in deg" in shown.err
    own.write_text("Nr;Winkel vorher\n" + "".join(lines[:10]))
    grown(monkeypatch, append(own, "".join(lines[10:])), lambda: None)
    assert run([*asked, *FOLLOW]) == 130
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["theta0_deg"] for line in told] == pytest.approx(LOCKED)
    assert told[-1]["alarm"] == ours["alarm"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("failure", "code"),
    [
        (DataFileError("x"), 2),
        (OSError(5, "disk"), 1),
        (BrokenPipeError(), None),
        (ZeroDivisionError(), None),
    ],
)
def test_however_following_ends_picture_and_json_are_written(
    here, monkeypatch, failure, code
) -> None:
    def fail() -> None:
        raise failure

    (here / "fol").mkdir()
    for k in range(3):
        poses = [[0.0, 0.3, 0.0, 0.1 * k], [0.1, 0.3, 0.05, 0.1 * k + 1.0]]
        tables = dict.fromkeys(("object_pose", "tip_pose", "ft_wrench"), poses)
        (here / "fol" / f"push_{k}.json").write_text(json.dumps(tables))
    grown(monkeypatch, fail)
    asked = WatchOptions(
        file=here / "fol",
        follow=True,
        every=0.5,
        table=TableOptions(),
        results=ResultOptions(out=here / "out", json="-"),
    )
    with pytest.raises(type(failure)):
        module.run_watch(asked)
    if code is not None:
        grown(monkeypatch, fail)
        assert run(["watch", "fol", *FOLLOW]) == code
    assert sorted(path.name for path in (here / "out").iterdir()) == [
        "watch_fol.json",
        "watch_fol.png",
    ]


@pytest.mark.slow
def test_a_real_interrupt_ends_with_130_quietly_and_leaves_the_report(here) -> None:
    command = [
        sys.executable,
        "-m",
        "cyclemap",
        "watch",
        str(data_file(here)),
        "--follow",
        "--json",
        "-",
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert [json.loads(process.stdout.readline())["push"] for _ in LOCKED] == list(
        range(len(LOCKED))
    )
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60) == ("", "") and process.returncode == 130
    assert json.loads((here / "out" / "watch_my_run.json").read_text())["alarm"]["kind"] == "rest"


ACTION = "[[strategy.actions]]\nfraction = 0.7\npush_mm = 150\n"
MIXTURE = f'[strategy]\norder = "random"\n{ACTION}side = 1\n{ACTION}side = 2\n'


@pytest.mark.slow
def test_a_protocol_tells_which_action_to_take_next(here, capsys, report_of) -> None:
    """The landing is that of `cyclemap cycle` from the last direction recorded with
    the same push."""
    (here / "mix.toml").write_text(MIXTURE)
    asked = ["watch", str(data_file(here)), "--protocol", "mix.toml", "--material", "plywood"]
    chosen = report_of(*asked)["next_action"]
    assert set(chosen) == {"number", "name", "lands_deg", "crowding"}
    cycles = report_of(
        "cycle", "plywood", "--protocol", "mix.toml", "--theta0-deg", str(LOCKED[-1])
    )["cycles"]
    assert len(cycles) == 2 and len({round(cycle["theta1_deg"]) for cycle in cycles}) == 2
    assert chosen["lands_deg"] == pytest.approx(
        cycles[chosen["number"]]["theta1_deg"] % 360.0, abs=0.1
    )
    assert chosen["name"] == cycles[chosen["number"]]["action"]["name"]
    assert run(asked) == 0
    assert (
        f"Next: {chosen['name']}; it brings θ0 to {chosen['lands_deg']:.0f}°"
        in capsys.readouterr().out
    )


@pytest.mark.slow
@pytest.mark.parametrize("beside", [False, True])
def test_the_sense_of_angles_is_tested_where_poses_stand_before_and_after_pushes(
    here, capsys, beside
) -> None:
    """With the collection beside the table and without, whose columns have names of their own or
    ours; orientations alone are taken as they are.
    """
    for write, suffix in ((canonical, ".csv"), (millimetres, ".csv")):
        table = Foreign("log", write, suffix, "clockwise", 0.0, True, 2)
        path = str(table.made(here, beside))
        assert run(["watch", path]) == 2
        shown = capsys.readouterr()
        assert "give --angles clockwise" in shown.err and shown.out == ""
        assert run(["watch", path, "--angles", "clockwise"]) == 0
        assert "orientations alone" not in capsys.readouterr().err
    assert run(["watch", str(data_file(here, [7.0 * k for k in range(20)]))]) == 0


SAMPLED = """[friction]
mu_a = 0.25
mu_b = 0.25
[posterior]
parameters = ["mu_a", "mu_b", "m0"]
samples = [[0.2545, 0.2346, 0.0325], [0.25, 0.25, 0.0]]
"""


def test_a_surface_with_samples_tells_what_is_ahead_of_where_the_log_stands(
    here, capsys, monkeypatch
) -> None:
    """After every look the forecast of the loop from the last orientation, on maps that are
    computed once.
    """
    (here / "slate.toml").write_text(SAMPLED)
    file = data_file(here)
    computed = []

    def counted(loop, report):
        computed.append(sampled_turns(loop, report))
        return computed[-1]

    monkeypatch.setattr(module, "sampled_turns", counted)
    grown(monkeypatch, append(file, "200\n"), append(file, "10\n340\n"))
    asked = ["watch", str(file), "--material", "slate.toml"]
    assert run([*asked, *FOLLOW, "--json", "-"]) == 130
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(lines) == len(LOCKED) + 3 and len(computed) == 1
    ahead = [(line["theta0_deg"], line["forecast"]) for line in lines if "forecast" in line]
    assert [theta_deg for theta_deg, _ in ahead] == pytest.approx([LOCKED[-1], 200.0, 340.0])
    sigma = math.radians(1.1)
    path = np.radians([*LOCKED, 200.0, 10.0, 340.0])
    for (theta_deg, told), pushes in zip(ahead, (0, 1, 3), strict=True):
        log = path[: len(LOCKED) + pushes]
        logged = turns_after_log(computed[0], log.tolist(), sigma, 300)
        expected = forecast_from_turns(
            logged.turns, logged.sigma, 300, math.radians(theta_deg), change=logged.change
        )
        assert told["cycles"] == 300 and told["chance_of_lock_in"] == expected.chance
        assert told["orientations_of_36"] == asdict(expected.orientations)
    assert json.loads((here / "out" / "watch_my_run.json").read_text())["forecast"] == ahead[-1][1]
    assert run(asked) == 0
    assert (
        "From 340.0° on, of all that is believed, within 300 pushes the loop locks in"
        in capsys.readouterr().out
    )


@pytest.mark.parametrize(
    "table", ["theta0_deg,good\n1,0\n2,0\n3,0\n", "yaw_deg,force\n,1\n,2\n,3\n"]
)
def test_a_table_of_which_no_orientation_counts_is_refused_in_a_line(here, capsys, table) -> None:
    file = here / "nothing.csv"
    file.write_text(table)
    assert run(["watch", str(file)]) in (1, 2)
    error = capsys.readouterr().err
    assert error.startswith("error: ") and "nothing.csv" in error and len(error.splitlines()) == 1
