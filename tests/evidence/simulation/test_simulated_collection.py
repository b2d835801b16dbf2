"""A simulated collection is the loop's path in the dataset's layout, the same however often it was
broken off.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, UnsupportedContact
from cyclemap.evidence import simulated_collection as module
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.evidence.recorded_push import RecordingNoise
from cyclemap.evidence.simulated_collection import (
    FILE_NAME,
    TRUTH_FILE,
    CollectionFolder,
    CollectionPlan,
    simulate_collection,
)
from cyclemap.mechanics import DragBack, EllipseFriction, Material, Pusher, SidePush

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
WORN = Material("worn", EllipseFriction(0.2, 0.15, m0=0.02, n0=-0.01, phi=0.4))
SILENT = RecordingNoise(turn=0.0)
NOISY = RecordingNoise(position=1e-4, angle=1e-3, force=0.02)
CYCLES = 5
BRIEF = CollectionLoop.mit(accuracy=1e-6, push=SidePush(distance=0.01))
# Loops whose push and reset change from cycle to cycle, and turns by a gripper.
LOOPS = (
    BRIEF,
    replace(BRIEF, push=SidePush(2, 0.4, 0.1, 0.02)),
    replace(BRIEF, push=SidePush(1, distance=0.015), reset=DragBack(((0.02, 0.0),))),
)
TURNS = (0.0, 0.5, -1.0)
OTHER_ROD = (LOOP, replace(LOOP, pusher=Pusher(0.01)), LOOP, LOOP, LOOP)


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def truth(folder: Path) -> np.ndarray:
    return np.loadtxt(folder / TRUTH_FILE)[:, 1]


def simulate(folder, **changes):
    given = {"cycles": CYCLES, "noise": NOISY, "wear_to": WORN, "seed": 3} | changes
    return simulate_collection(LOOP, folder, **given)


def briefly(folder, **given):
    """Three short cycles without noise."""
    return simulate_collection(BRIEF, folder, 3, start=2.0, noise=SILENT, suffix=".json", **given)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> dict[str, bytes]:
    """The files of a noisy, wearing collection that was never broken off."""
    folder = tmp_path_factory.mktemp("undisturbed") / "made"
    made = simulate(folder)
    assert (made.written, made.resumed) == (CYCLES, 0)
    return contents(folder)


def test_files_lie_where_the_dataset_has_them_under_its_names(tmp_path) -> None:
    loop = replace(LOOP, material=replace(LOOP.material, name="plywood (changed)"))
    made = simulate_collection(loop, tmp_path, 2, suffix=".json", speed=0.05)
    name = "motion_surface=plywood_changed_shape=rect1_a=0_v=50_i=0.000_s=0.700_t=0.000_rep={:04d}.json"
    files = sorted((tmp_path / "plywood_changed" / "rect1" / "normal").iterdir())
    assert [path.name for path in files] == [name.format(0), name.format(1)]
    assert made.bytes == sum(path.stat().st_size for path in files)
    beside = sorted(path.name for path in tmp_path.iterdir())
    assert beside == [FILE_NAME, "plywood_changed", TRUTH_FILE]
    pushes = load_pushes(tmp_path)
    assert pushes.unreadable == () and pushes.table["speed"].tolist() == [0.05, 0.05]


@pytest.mark.slow
def test_its_motions_are_read_as_they_were_made(tmp_path) -> None:
    """On a floor that moves the object otherwise than isotropic friction does."""
    loop = CollectionLoop.mit("abs", accuracy=1e-6)
    made = simulate_collection(loop, tmp_path, 8, noise=SILENT, suffix=".json")
    (words,) = check_pushes(load_pushes(made.folder), loop)
    assert words.startswith("read with axes right-handed, angles counter-clockwise")


def test_cycles_scatter_about_the_map_as_asked(tmp_path) -> None:
    """θ_{n+1} - F(θ_n) is normal: mean, deviation and correlation within three standard errors."""
    sigma, cycles = 0.02, 40
    made = simulate_collection(LOOP, tmp_path, cycles, noise=RecordingNoise(turn=sigma), seed=1)
    theta = truth(made.folder)
    error = (theta[1:] - LOOP.next_theta(theta[:-1])) / sigma
    assert error.size == cycles and abs(error.mean()) < 3.0 / math.sqrt(cycles)
    assert error.std() == pytest.approx(1.0, abs=3.0 / math.sqrt(2.0 * cycles))
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 3.0 / math.sqrt(cycles)
    recorded = load_pushes(tmp_path).table["theta0"].to_numpy()
    assert np.remainder(recorded - theta[:-1] + 1.0, 2.0 * math.pi) == pytest.approx(1.0, abs=1e-12)


def test_scatter_may_depend_on_the_orientation_and_on_the_cycle_before() -> None:
    """The first kicks of many are those of few."""
    noise = cm.maps.LocalNoise((math.log(0.02), 0.5, 0.0), 0.6)
    plan, few = (CollectionPlan(LOOP, n, cycle_noise=noise, seed=5) for n in (3000, 3))
    theta = np.linspace(0.0, 60.0, 3000)
    kicks = [plan.kick(cycle, angle) for cycle, angle in enumerate(theta.tolist())]
    unit = kicks / noise.sigma(theta)
    assert np.std(unit) == pytest.approx(1.0, abs=0.05)
    assert np.mean(unit[1:] * unit[:-1]) == pytest.approx(0.6, abs=0.05)
    assert [few.kick(k, 0.3) for k in range(3)] == [plan.kick(k, 0.3) for k in range(3)]


def test_noise_of_the_instruments_does_not_touch_the_path_and_another_seed_does(tmp_path) -> None:
    asked = {"noisy": {}, "clean": {"noise": RecordingNoise()}, "other": {"seed": 4}}
    noisy, clean, other = (
        truth(simulate(tmp_path / name, cycles=2, **changes).folder)
        for name, changes in asked.items()
    )
    assert np.array_equal(noisy, clean) and np.abs(noisy - other)[1:].min() > 1e-3


@pytest.mark.parametrize("loops", [(), LOOPS])
def test_wear_goes_from_the_one_surface_to_the_other(tmp_path, loops) -> None:
    made = briefly(tmp_path, wear_to=WORN, cycle_loops=loops)
    turned = load_pushes(made.folder).table.sort_values("repetition")["dtheta"].to_numpy()
    theta = truth(made.folder)
    for row, loop in enumerate(loops or (BRIEF,) * 3):
        fresh = loop.cycle(theta[row])
        worn = replace(loop, material=WORN).cycle(theta[row])
        if row == 1:
            assert min(abs(turned[1] - cycle.push_turn) for cycle in (fresh, worn)) > 1e-6
            continue
        cycle = fresh if row == 0 else worn
        assert turned[row] == pytest.approx(cycle.push_turn, abs=1e-6)
        assert theta[row + 1] == pytest.approx(cycle.theta_next, abs=1e-5)
    alone = CollectionPlan(LOOP, 1, wear_to=WORN).loop_at(0)
    assert alone.material.friction == LOOP.material.friction


@pytest.mark.parametrize("calls", [1, 4, 9])
def test_a_run_stopped_between_files_ends_like_an_undisturbed_one(
    tmp_path, monkeypatch, undisturbed, calls
) -> None:
    left = [calls]

    def stopping(real):
        def call(*arguments):
            if left[0] == 0:
                raise KeyboardInterrupt
            left[0] -= 1
            return real(*arguments)

        return call

    with monkeypatch.context() as patch:
        patch.setattr(module, "write_push_file", stopping(module.write_push_file))
        patch.setattr(CollectionFolder, "append_truth", stopping(CollectionFolder.append_truth))
        with pytest.raises(KeyboardInterrupt):
            simulate(tmp_path)
    made = simulate(tmp_path)
    assert (made.resumed, made.written) == (calls // 2, CYCLES - calls // 2)
    assert contents(tmp_path) == undisturbed
    again = simulate(tmp_path)
    assert (again.resumed, again.written, again.theta_last) == (CYCLES, 0, made.theta_last)
    assert contents(tmp_path) == undisturbed


def test_damaged_notes_are_made_again(tmp_path, undisturbed) -> None:
    # As a run leaves it that was killed before its first file was whole.
    (tmp_path / f".{FILE_NAME}.123.part").write_text("version = ")
    told: list[float] = []
    assert simulate(tmp_path, progress=told.append).resumed == 0
    assert contents(tmp_path) == undisturbed
    assert told == [(n + 1) / CYCLES for n in range(CYCLES)]
    notes = tmp_path / TRUTH_FILE
    for damage, resumed in ((notes.read_text()[:-9], CYCLES - 1), ("0 0.0\n1 nan\n2 0.1\n", 0)):
        notes.write_text(damage)
        assert simulate(tmp_path).resumed == resumed and contents(tmp_path) == undisturbed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cycles": 9}, "cycles is 5 there and 9 here"),
        ({"seed": 4}, "seed is 3 there and 4 here"),
        ({"start": 0.1}, "start_rad is 0.0 there and 0.1 here"),
        ({"noise": replace(NOISY, turn=0.1)}, "noise_turn_rad is .* there and 0.1 here"),
        ({"noise": replace(NOISY, force=0.03)}, "noise_force_n is 0.02 there and 0.03 here"),
        ({"speed": 0.03}, "speed_m_s is 0.02 there and 0.03 here"),
        ({"wear_to": None}, "wear_to is EllipseFriction.* there and none here"),
        ({"scans": True}, "scans is False there and True here"),
        ({"suffix": ".json"}, "suffix is .h5 there and .json here"),
        ({"gripper_turns": (0.1,) * 5}, "cycle_by_cycle is None there"),
        (
            {"loop": replace(LOOP, pusher=Pusher(friction=0.2))},
            "pusher is .*0.15.* there and .*0.2",
        ),
        ({"loop": replace(LOOP, push=BRIEF.push)}, "push is .*distance=0.15.* there and .*0.01"),
        ({"loop": replace(LOOP, material=WORN)}, "friction is .*0.2545.* there and .*mu_a=0.2,"),
        ({"loop": replace(LOOP, accuracy=1e-7)}, "accuracy is 1e-06 there and 1e-07 here"),
    ],
)
def test_other_arguments_in_the_same_folder_are_refused_by_name(tmp_path, changes, message) -> None:
    plan = CollectionPlan(LOOP, CYCLES, noise=NOISY, wear_to=WORN, seed=3)
    CollectionFolder(tmp_path, plan)
    before = contents(tmp_path)
    refused(CollectionFolder, tmp_path, replace(plan, **changes), told=message)
    assert contents(tmp_path) == before and list(before) == [FILE_NAME]


def test_a_folder_of_another_version_or_of_other_cycles_is_refused(tmp_path) -> None:
    plan = CollectionPlan(BRIEF, 3, cycle_loops=LOOPS)
    CollectionFolder(tmp_path, plan)
    CollectionFolder(tmp_path, plan)
    for other in ({"cycle_loops": LOOPS[::-1]}, {"gripper_turns": TURNS}, {"cycle_loops": ()}):
        told = "asked for otherwise: cycle_by_cycle"
        refused(CollectionFolder, tmp_path, replace(plan, **other), told=told)
    record = tmp_path / FILE_NAME
    record.write_text(record.read_text().replace('version = "', 'version = "0.0.0-'))
    refused(CollectionFolder, tmp_path, plan, told=r"version is 0\.0\.0-")


@pytest.mark.parametrize("name", ["thesis.txt", "film.part", "motion_surface=abs_rep=0000.h5"])
def test_a_folder_with_anything_else_in_it_is_left_alone(tmp_path, name) -> None:
    (tmp_path / name).write_text("years of work")
    refused(simulate, tmp_path, told="holds other files")
    assert contents(tmp_path) == {name: b"years of work"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cycles": 0}, "cycles must be at least 1"),
        ({"start": math.nan}, "start must be a finite number"),
        ({"seed": -1}, "seed must be at least 0"),
        ({"speed": 0.0}, "speed of the rod must be positive"),
        ({"suffix": ".csv"}, "suffix is '.csv'"),
        ({"cycle_loops": LOOPS[:2]}, "cycle_loops has 2 entries for 5 cycles"),
        ({"gripper_turns": (0.1,)}, "gripper_turns has 1 entries for 5 cycles"),
        ({"gripper_turns": (0.1, math.nan, 0.2, 0.0, 0.0)}, "gripper turn must be a finite number"),
        ({"cycle_loops": OTHER_ROD}, "loop of cycle 1 differs in more than push"),
    ],
)
def test_bad_arguments_are_refused_before_anything_is_written(tmp_path, changes, message) -> None:
    refused(simulate, tmp_path / "made", told=message, **changes)
    assert list(tmp_path.iterdir()) == []


def test_a_push_that_the_mechanics_cannot_do_is_told_with_its_cycle(tmp_path, monkeypatch) -> None:
    def refuse(*arguments):
        raise UnsupportedContact("the rod touches two sides")

    monkeypatch.setattr(CollectionLoop, "strokes", refuse)
    told = r"cycle 0, from θ0 = 57\.296 degrees: the rod touches two sides"
    refused(simulate, tmp_path, start=1.0, told=told, kind=UnsupportedContact)


def altered(path: Path) -> None:
    """One digit of the path, or one byte of a record, is another."""
    content = bytearray(path.read_bytes())
    place = content.rindex(b".") + 3 if path.name == TRUTH_FILE else len(content) // 2
    content[place] ^= 1
    path.write_bytes(content)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pattern", "damage", "resumed"),
    [
        (TRUTH_FILE, altered, 3),
        (TRUTH_FILE, Path.unlink, 0),
        ("motion_*rep=0002.h5", altered, 2),
        ("motion_*rep=0002.h5", Path.unlink, 2),
        ("record_*deg=90*rep=000.h5", lambda path: path.write_bytes(b""), 4),
    ],
)
def test_what_was_damaged_since_is_made_again_to_the_bit(
    tmp_path, pattern, damage, resumed
) -> None:
    scans = "record" in pattern
    made = simulate(tmp_path / "made", cycles=4, scans=scans)
    before = contents(made.folder)
    damage(next(made.folder.rglob(pattern)))
    assert contents(made.folder) != before
    again = simulate(made.folder, cycles=4, scans=scans)
    assert contents(made.folder) == before and again.resumed == resumed


def test_a_second_run_in_the_same_folder_is_refused(tmp_path) -> None:
    folder, tried = tmp_path / "made", []

    def meanwhile(fraction: float) -> None:
        refused(briefly, folder, told="written by another process", kind=CycleMapError)
        tried.append(fraction)

    briefly(folder, progress=meanwhile)
    assert len(tried) == 3 and briefly(folder).resumed == 3


@pytest.mark.parametrize("given", [{}, {"cycle_loops": LOOPS, "gripper_turns": TURNS}])
def test_the_table_read_back_is_the_path_of_each_cycles_loop_and_gripper_turn(
    tmp_path, given
) -> None:
    """By each loop's own `cycle`, in other steps: equal to the accuracy asked of it."""
    made = briefly(tmp_path / "made", **given)
    pushes, theta = load_pushes(made.folder), [2.0]
    rows = list(pushes.table.sort_values("repetition").itertuples())
    assert pushes.unreadable == () and [row.repetition for row in rows] == [0, 1, 2]
    loops, turns = given.get("cycle_loops", (BRIEF,) * 3), given.get("gripper_turns", (0.0,) * 3)
    for row, loop, turn in zip(rows, loops, turns, strict=True):
        cycle = loop.cycle(theta[-1])
        assert row.side == loop.push.side
        assert math.remainder(row.theta0 - theta[-1], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-5)
        moved = (*cycle.push_displacement, cycle.push_turn)
        assert (row.dx, row.dy, row.dtheta) == pytest.approx(moved, abs=1e-5)
        theta.append(cycle.theta_next + turn)
        ahead = theta[-1] - theta[-2] if not given and row.repetition < 2 else math.nan
        assert row.theta_next - row.theta0 == pytest.approx(ahead, abs=1e-5, nan_ok=True)
    assert truth(made.folder) == pytest.approx(theta, abs=2e-5)
    assert made.theta_last == truth(made.folder)[-2]
