"""`cyclemap dynamics` and `experiment` from outside: their JSON, pictures and words."""

import math

import numpy as np
import pytest

from cyclemap.collection import BatchExperiment, BatchRun, CollectionLoop
from cyclemap.views.experiment_page import (
    experiment_headline,
    isotropic_sentence,
    method_line,
    spread_sentence,
)

BATCH_KEYS = "start_deg final_deg last_step_deg settled_after_cycles theta0_deg"
ROW_KEYS = "theta0_deg push_turn_deg push_dx_mm push_dy_mm drag_turn_deg theta1_deg left"


def closing(ends_deg: list[float]) -> BatchRun:
    """Batches of 20 cycles that close in on given ends by a factor of 0.6 a cycle."""
    theta = np.radians(ends_deg)[:, None] - 0.9 * 0.6 ** np.arange(21)
    path = np.cumsum(np.full((len(ends_deg), 20, 4, 2), 0.01), axis=2)
    return BatchRun(theta, path)


def experiment(ends_deg: list[float]) -> BatchExperiment:
    starts, loop = np.radians([0.0, 180.0]), CollectionLoop.mit()
    return BatchExperiment(loop, 0.02, starts, closing(ends_deg), closing([0.0, 180.0]))


def turning(step_deg: float, batches: int, cycles: int) -> BatchExperiment:
    """Batches that every cycle turns alike, on both laws."""
    starts = 2.0 * np.arange(batches)
    theta = starts[:, None] + math.radians(step_deg) * np.arange(cycles + 1)
    run = BatchRun(theta, np.zeros((batches, cycles, 4, 2)))
    return BatchExperiment(CollectionLoop.mit(), None, starts, run, run)


@pytest.mark.slow
def test_json_tells_every_batch_on_both_laws_and_nothing_else(saved_report) -> None:
    line = "experiment plywood --batches 2 --cycles 2 --set push_mm=30"
    report = saved_report("out/experiment_plywood", line)
    assert " ".join(report) == "model speed_mm_s cycles within_deg anisotropic isotropic"
    assert (report["model"], report["speed_mm_s"], report["cycles"]) == ("dynamic", 20.0, 2)
    for law in ("anisotropic", "isotropic"):
        assert " ".join(report[law]) == "directions_deg all_agree spread_mm batches"
        assert [batch["theta0_deg"][0] for batch in report[law]["batches"]] == [0.0, 180.0]
        for batch in report[law]["batches"]:
            assert " ".join(batch) == BATCH_KEYS and len(batch["theta0_deg"]) == 3
    assert report["isotropic"]["spread_mm"] < 0.01 < report["anisotropic"]["spread_mm"]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "experiment plywood --batches 1 --cycles 2 --quasi-static",
            ("The batch", "On isotropic friction", "quasi-static cycles; 2 cycles"),
        ),
        (
            "dynamics plywood --theta0-deg 30 --speed-mm-s 50",
            ("differ by at most", "Cycles at 50 mm/s", "quasi-static", "isotropic"),
        ),
    ],
)
def test_people_are_told_what_the_command_is_about(here, said, line, told) -> None:
    shown = said(f"{line} --set push_mm=30 --format svg").out
    picture = f"out/{line.split()[0]}_plywood.svg"
    for words in (*told, f"picture: {picture}"):
        assert words in shown
    assert (here / picture).read_bytes().startswith(b"<?xml")


STILL_TURNS = "Not every batch comes to rest in 20 cycles: the last cycle still turns one by 5.73°."
LONE = "The batch does not come to rest in 1 cycle: the last cycle still turns it by 9.67°."


@pytest.mark.parametrize(
    ("found", "told"),
    [
        # 0.9 rad * 0.6^n falls below a degree at the 8th cycle.
        ([61.4, 421.4], "All 2 batches end at 61.4°, within 1° of it for good after at most 8 cyc"),
        ([61.4, 241.4], "The 2 batches end at 2 directions (61.4°, 241.4°), within 1° of them"),
        ([61.4], "The batch ends at 61.4°, within 1° of it for good after 8 cycles."),
        ((5.73, 2, 20), STILL_TURNS),
        ((0.04, 3, 50), "still turns one by 0.04°, and such steps do not soon die out."),
        ((9.67, 1, 1), LONE),
    ],
)
def test_the_headline_tells_one_direction_several_or_none(found, told) -> None:
    made = experiment(found) if isinstance(found, list) else turning(*found)
    assert told in experiment_headline(made)


def test_paths_and_turns_are_told_and_a_lone_cycle_in_the_singular() -> None:
    assert "every cycle turns the object by 5.73°" in isotropic_sentence(turning(5.73, 2, 20))
    assert "the 40 paths spread by up to" in spread_sentence(experiment([61.4, 61.4]))
    lone = turning(9.67, 1, 1)
    assert method_line(lone) == "quasi-static cycles; 1 cycle: 1 batch of 1"
    assert "paths" not in spread_sentence(lone) + isotropic_sentence(lone)
    assert isotropic_sentence(lone).endswith("the cycle turns the object by 9.67°.")


@pytest.mark.slow
def test_dynamics_json_tells_both_models_on_both_laws_and_nothing_else(saved_report) -> None:
    line = "dynamics plywood --theta0-deg 0,90 --set push_mm=30"
    report = saved_report("out/dynamics_plywood", line)
    assert list(report) == ["speed_mm_s", "anisotropic", "isotropic"]
    assert report["isotropic"].pop("mu") == pytest.approx((0.2545 * 0.2346) ** 0.5)
    for law in ("anisotropic", "isotropic"):
        assert list(report[law]) == ["dynamic", "quasi_static"]
        for rows in report[law].values():
            assert [row["theta0_deg"] for row in rows] == [0.0, 90.0]
            assert all(" ".join(row) == ROW_KEYS for row in rows)
        for a, b in zip(*report[law].values(), strict=True):
            assert 0.0 < abs(a["theta1_deg"] - b["theta1_deg"]) < 0.3
    turns = [row["push_turn_deg"] for row in report["isotropic"]["dynamic"]]
    assert turns[0] == pytest.approx(turns[1], abs=1e-3)
