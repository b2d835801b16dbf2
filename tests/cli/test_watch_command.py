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
from cyclemap.cli.options import ResultOptions, TableOptions
from cyclemap.collection.lock_forecast import forecast_from_turns, sampled_turns, turns_after_log
from cyclemap.errors import DataFileError

LOCKED = [20.0, 28.0, 36.0, 44.0, 52.0, *[60.0 + 0.3 * (k % 3) for k in range(30)]]
FOLLOW = "--follow --every 0.5"
KEYS = (
    "file pushes alarm_rate alarm evidence rest useful_pushes recent_worth coverage advice "
    "multiplier"
)


def rows(angles) -> str:
    return "".join(f"{angle:.3f}\n" for angle in angles)


@pytest.fixture
def log(here) -> Path:
    """A collection that locks in at 60 degrees."""
    file = here / "run.csv"
    file.write_text(f"theta0_deg\n{rows(LOCKED)}")
    return file


def last_report(here) -> dict:
    return json.loads((here / "out" / "watch_run.json").read_text())


@pytest.mark.slow
def test_one_look_tells_alarm_direction_coverage_and_advice(log, said, saved_report) -> None:
    report = saved_report("out/watch_run", "watch run.csv --alarm-rate 0.1")
    assert " ".join(report) == KEYS
    assert (report["file"], report["pushes"], report["alarm_rate"]) == ("run.csv", 35, 0.1)
    assert report["alarm"]["directions_deg"] == [pytest.approx(60.0, abs=3.0)]
    told = report["multiplier"]
    assert told is None or told["lower"] <= told["value"] <= told["upper"]
    assert report["rest"]["towards_deg"] == [pytest.approx(60.3, abs=0.5)]
    evidence = report["evidence"]
    assert evidence["rest_log10"] >= evidence["threshold_log10"] == pytest.approx(math.log10(20.0))
    advised = pytest.approx(235.0, abs=10.0)
    assert report["advice"] == {"change_reset": True, "direction_deg": advised}
    shown = said("watch run.csv --alarm-rate 0.1")
    assert shown.err == ""
    alarm = f"ALARM at push {report['alarm']['push']}"
    for words in (alarm, "θ0 rests near 6", "Change the reset", "watch_run.png"):
        assert words in shown.out


@pytest.fixture
def follow(monkeypatch, said):
    """Follow a log; each wait takes the next of some steps, and is interrupted after the last."""

    def run(line: str, *steps, code: int = 130):
        waiting = iter(steps)

        def wait(seconds: float) -> None:
            assert seconds == 0.5
            try:
                next(waiting)()
            except StopIteration:
                raise KeyboardInterrupt from None

        monkeypatch.setattr(module.time, "sleep", wait)
        return said(f"{line} {FOLLOW}", code)

    return run


def append(file: Path, text: str):
    """A step that writes more to a file."""

    def act() -> None:
        with file.open("a") as stream:
            stream.write(text)

    return act


def told_of(shown) -> list[dict]:
    return [json.loads(line) for line in shown.out.splitlines()]


@pytest.mark.slow
def test_following_prints_a_line_of_json_for_each_push_and_keeps_the_last_report(
    here, log, follow
) -> None:
    log.write_text(f"theta0_deg\n{rows(LOCKED[:10])}")
    rest = rows(LOCKED[10:])
    steps = append(log, rest[:-3]), append(log, rest[-3:]), append(log, "1")
    lines = told_of(follow("watch run.csv --json -", *steps))
    assert [line["push"] for line in lines] == list(range(len(LOCKED)))
    assert last_report(here)["pushes"] == len(LOCKED)
    assert [line["theta0_deg"] for line in lines] == pytest.approx(LOCKED)
    raised = [line["push"] for line in lines if line["alarm"]]
    assert raised == list(range(raised[0], len(LOCKED)))


@pytest.mark.slow
def test_following_tells_people_what_changes_and_a_file_that_begins_anew(here, log, follow) -> None:
    anew = f"theta0_deg\n{rows([10, 100, 190, 280])}"
    shown = follow("watch run.csv", lambda: None, lambda: log.write_text(anew))
    assert shown.out.count("ALARM at push") == 1
    assert shown.err.startswith("watching run.csv until interrupted")
    assert "began anew, and so does the watch" in shown.err
    assert "No alarm in 4 pushes" in shown.out
    assert last_report(here)["pushes"] == 4


def test_a_table_of_ones_own_is_watched_like_ours_and_followed(
    here, log, follow, said, report_of
) -> None:
    """Semicolons and decimal commas under another name."""
    own = here / "log.csv"
    lines = [f"{n};{angle:.2f}\n".replace(".", ",") for n, angle in enumerate(LOCKED)]
    own.write_text("Nr;Winkel vorher\n" + "".join(lines))
    ours = report_of("watch run.csv")
    asked = "watch log.csv --columns 'theta0=Winkel vorher' --units deg --json -"
    shown = said(asked)
    assert {**json.loads(shown.out), "file": "run.csv"} == ours
    assert "Winkel vorher read as theta0 in deg" in shown.err
    own.write_text("Nr;Winkel vorher\n" + "".join(lines[:10]))
    told = told_of(follow(asked, append(own, "".join(lines[10:])), lambda: None))
    assert [line["theta0_deg"] for line in told] == pytest.approx(LOCKED)
    assert told[-1]["alarm"] == ours["alarm"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("failure", "code"), [(DataFileError("x"), 2), (OSError(5, "disk"), 1), (BrokenPipeError(), 0)]
)
def test_however_following_ends_picture_and_json_are_written(
    here, follow, monkeypatch, failure, code
) -> None:
    """Of pushes in files of the MIT layout."""

    def fail(*_) -> None:
        raise failure

    (here / "fol").mkdir()
    for k in range(3):
        poses = [[0.0, 0.3, 0.0, 0.1 * k], [0.1, 0.3, 0.05, 0.1 * k + 1.0]]
        tables = dict.fromkeys(("object_pose", "tip_pose", "ft_wrench"), poses)
        (here / "fol" / f"push_{k}.json").write_text(json.dumps(tables))
    if code:
        follow("watch fol", fail, code=code)
    else:
        monkeypatch.setattr(module.time, "sleep", fail)
        results = ResultOptions(out=here / "out", json="-")
        file = here / "fol"
        with pytest.raises(BrokenPipeError):
            module.run_watch(
                WatchOptions(file=file, follow=True, table=TableOptions(), results=results)
            )
    written = sorted(path.name for path in (here / "out").iterdir())
    assert written == ["watch_fol.json", "watch_fol.png"]


@pytest.mark.slow
def test_a_real_interrupt_ends_with_130_quietly_and_leaves_the_report(here, log) -> None:
    words = [sys.executable, "-m", "cyclemap", "watch", "run.csv", "--follow", "--json", "-"]
    pipe = subprocess.PIPE
    process = subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True)
    pushes = [json.loads(process.stdout.readline())["push"] for _ in LOCKED]
    assert pushes == list(range(len(LOCKED)))
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60) == ("", "") and process.returncode == 130
    assert last_report(here)["alarm"]["kind"] == "rest"


ACTION = "[[strategy.actions]]\nfraction = 0.7\npush_mm = 150\n"
MIXTURE = f'[strategy]\norder = "random"\n{ACTION}side = 1\n{ACTION}side = 2\n'


@pytest.mark.slow
def test_a_protocol_tells_which_action_to_take_next(here, log, said, report_of) -> None:
    """It lands where `cyclemap cycle` does from the last direction with the same push."""
    (here / "mix.toml").write_text(MIXTURE)
    loop = "--protocol mix.toml --material plywood"
    chosen = report_of(f"watch run.csv {loop}")["next_action"]
    assert set(chosen) == {"number", "name", "lands_deg", "crowding"}
    cycles = report_of(f"cycle {loop} --theta0-deg {LOCKED[-1]}")["cycles"]
    assert len(cycles) == 2 and len({round(cycle["theta1_deg"]) for cycle in cycles}) == 2
    cycle = cycles[chosen["number"]]
    assert chosen["lands_deg"] == pytest.approx(cycle["theta1_deg"] % 360.0, abs=0.1)
    assert chosen["name"] == cycle["action"]["name"]
    told = f"Next: {chosen['name']}; it brings θ0 to {chosen['lands_deg']:.0f}°"
    assert told in said(f"watch run.csv {loop}").out


@pytest.mark.slow
@pytest.mark.parametrize("beside", [False, True])
def test_the_sense_of_angles_is_tested_where_poses_stand_before_and_after_pushes(
    here, refused, said, beside
) -> None:
    """With the collection beside the table and without, under names of their own or ours."""
    for write in (canonical, millimetres):
        path = Foreign("log", write, ".csv", "clockwise", 0.0, True, 2).made(here, beside)
        refused(f"watch {path}", "give --angles clockwise")
        assert "orientations alone" not in said(f"watch {path} --angles clockwise").err


SAMPLED = """[friction]
mu_a = 0.25
mu_b = 0.25
[posterior]
parameters = ["mu_a", "mu_b", "m0"]
samples = [[0.2545, 0.2346, 0.0325], [0.25, 0.25, 0.0]]
"""


def test_a_surface_with_samples_tells_what_is_ahead_of_where_the_log_stands(
    here, log, follow, said, monkeypatch
) -> None:
    """After every look the forecast from the last orientation, on maps that are computed once."""
    (here / "slate.toml").write_text(SAMPLED)
    computed = []

    def counted(loop, report):
        computed.append(sampled_turns(loop, report))
        return computed[-1]

    monkeypatch.setattr(module, "sampled_turns", counted)
    asked = "watch run.csv --material slate.toml"
    steps = append(log, "200\n"), append(log, "10\n340\n")
    lines = told_of(follow(f"{asked} --json -", *steps))
    assert len(lines) == len(LOCKED) + 3 and len(computed) == 1
    ahead = [(line["theta0_deg"], line["forecast"]) for line in lines if "forecast" in line]
    assert [theta_deg for theta_deg, _ in ahead] == pytest.approx([LOCKED[-1], 200.0, 340.0])
    path = np.radians([*LOCKED, 200.0, 10.0, 340.0])
    for (theta_deg, told), pushes in zip(ahead, (0, 1, 3), strict=True):
        known = path[: len(LOCKED) + pushes].tolist()
        logged = turns_after_log(computed[0], known, math.radians(1.1), 300)
        start = math.radians(theta_deg)
        expected = forecast_from_turns(logged.turns, logged.sigma, 300, start, change=logged.change)
        assert told["cycles"] == 300 and told["chance_of_lock_in"] == expected.chance
        assert told["orientations_of_36"] == asdict(expected.orientations)
    assert last_report(here)["forecast"] == ahead[-1][1]
    told = "From 340.0° on, of all that is believed, within 300 pushes the loop locks in"
    assert told in said(asked).out
