"""Pushes are parted into sets made alike, and the spread of each set is told."""

from pathlib import Path

import numpy as np
import pytest
from made_sets import HEADER, TURN, made_set, noisy_set, true_turn, worn_pairs, write_collection
from refusals import refused

from cyclemap.arrays import shorter_way
from cyclemap.evidence.laws.push_sets import ordered_pairs, push_sets, push_statistics
from cyclemap.evidence.pushes.push_table import load_pushes

PUSH = "0.35,-0.03,0.1,0.37,-0.05,0.4"


def rows(surface: str, count: int, fraction: float = 0.7) -> list[str]:
    return [f"{surface},rect1,20,0,{fraction},0,{n},{PUSH}" for n in range(count)]


def write(file: Path, lines: list[str]) -> Path:
    file.write_text("\n".join([HEADER, *lines]) + "\n")
    return file


@pytest.mark.parametrize("missing", [[], [30]])
def test_repeated_pushes_in_any_order_give_their_path_and_pairs_but_across_gaps(
    tmp_path, missing
) -> None:
    true, kept = worn_pairs(60), np.delete(np.arange(61), missing)
    file = write_collection(tmp_path / "poses.csv", true.path, true_turn(true.path))
    header, *lines = file.read_text().splitlines()
    file.write_text("\n".join([header, *(lines[n] for n in reversed(kept))]) + "\n")
    (found,) = push_sets(load_pushes(file))
    assert (found.name, found.count, found.contacts) == ("plywood rect1", kept.size, 1)
    assert found.has_motion
    assert np.allclose(found.dtheta, true_turn(true.path[kept]), atol=1e-8)
    assert np.allclose(np.diff(found.pairs.path), np.diff(true.path[kept]), atol=1e-8)
    assert found.pairs.path_cycle.tolist() == kept.tolist()
    paired = np.setdiff1d(np.arange(60), [[n - 1, n] for n in missing])
    assert found.pairs.cycle.tolist() == paired.tolist()
    assert np.allclose(found.pairs.turn, true.turn[paired], atol=1e-8)


def test_the_path_passes_through_every_orientation_that_was_measured() -> None:
    """What somebody moved the object by behind a push, and the errors of two readings of one
    orientation, do not add up along the path: the move is a gap, which parts it.
    """
    noise = np.radians(0.5) * np.random.default_rng(5).standard_normal((2, 200))
    true = worn_pairs(200)
    moved = 1.5 * (np.arange(200) >= 120)
    theta, theta_next = true.path[:-1] + noise[0] + moved, true.path[1:] + noise[1] + moved
    pairs = ordered_pairs(theta, theta_next, np.arange(200.0))
    assert np.max(np.abs(shorter_way(pairs.theta - theta))) < 1e-12
    assert np.allclose(pairs.turn, theta_next - theta, atol=1e-12)
    assert pairs.unbroken.path_cycle.tolist() == list(range(120))


def test_sets_are_told_apart_by_surface_and_contact_and_named_shortly(tmp_path) -> None:
    lines = rows("plywood", 25) + rows("abs", 30) + rows("abs", 22, fraction=0.5)
    sets = push_sets(load_pushes(write(tmp_path / "poses.csv", lines)))
    assert {found.name: found.count for found in sets} == {
        "plywood rect1": 25,
        "abs rect1 v=20 i=0 s=0.7 t=0": 30,
        "abs rect1 v=20 i=0 s=0.5 t=0": 22,
    }
    assert all(found.contacts == 1 for found in sets)
    assert sets[0].facts["speed"] == pytest.approx(0.02)


def test_pushes_that_were_never_repeated_are_pooled_over_contacts_and_say_so(tmp_path) -> None:
    lines = [f"plywood,rect1,20,0,{k / 100:g},0,,{PUSH}" for k in range(40)]
    (found,) = push_sets(load_pushes(write(tmp_path / "poses.csv", lines)))
    assert (found.count, found.contacts, found.pairs) == (40, 40, None)
    assert "fraction" not in found.facts


def test_two_tables_alike_stay_two_sets_with_two_names(tmp_path) -> None:
    for name in ("one.csv", "two.csv"):
        write(tmp_path / name, rows("abs", 20))
    sets = push_sets(load_pushes(tmp_path))
    assert [found.count for found in sets] == [20, 20] and len({found.name for found in sets}) == 2
    assert all(Path(found.source).stem in found.name for found in sets)


def test_a_table_of_theta0_has_pairs_and_path_but_no_motion(tmp_path) -> None:
    path = tmp_path / "angles.csv"
    path.write_text("theta0_deg\n" + "".join(f"{10 * k % 360}\n" for k in range(50)))
    (found,) = push_sets(load_pushes(path))
    assert (found.name, found.has_motion) == ("angles", False)
    assert found.pairs.path[-1] == pytest.approx(490 / 360 * TURN)
    assert found.pairs.cycle.tolist() == list(range(49))
    # Pairs of orientations alone have the sense in which they were loaded.
    (found,) = push_sets(load_pushes(path, angles="clockwise"))
    assert np.degrees(found.pairs.turn) == pytest.approx(-10.0)
    assert found.pairs.theta == pytest.approx(found.theta)


def test_select_keeps_one_value_and_refuses_what_is_not_there(tmp_path) -> None:
    lines = rows("plywood", 20) + rows("abs", 20, fraction=0.5)
    table = load_pushes(write(tmp_path / "poses.csv", lines))
    for select, name in (
        ({"surface": "abs"}, "abs"),
        ({"fraction": 0.7, "speed": 0.02}, "plywood"),
    ):
        assert [found.name for found in push_sets(table, select)] == [f"{name} rect1"]
    for select, told in (
        ({"surface": "pu"}, "no such surface: pu; the data have abs, plywood"),
        ({"surface": "abs", "fraction": 0.7}, r"no push has surface abs, fraction 0\.7 at once"),
        ({"surfaces": "abs"}, "unknown column 'surfaces'"),
    ):
        refused(push_sets, table, select, told=told)


def test_a_row_tells_mean_and_spread_of_the_pushes_that_are_known() -> None:
    value = np.append(np.random.default_rng(1).standard_normal(50), np.nan)
    row = push_statistics(made_set(np.zeros(51), value, value + 3.0, -2.0 * value))
    one, moved, larger = row.dtheta, row.dx, row.dy
    assert (row.count, one.count) == (51, 50)
    assert (one.mean, one.std) == pytest.approx((np.nanmean(value), np.nanstd(value, ddof=1)))
    assert (moved.mean, moved.std) == pytest.approx((one.mean + 3.0, one.std))
    assert (larger.mean, larger.std) == pytest.approx((-2.0 * one.mean, 2.0 * one.std))
    assert [one.percent, larger.percent] == pytest.approx([100.0 * one.std / abs(one.mean)] * 2)


def test_a_set_with_too_few_pushes_says_so_in_its_row() -> None:
    row = push_statistics(made_set([0.0, 1.0, 2.0], [1.0, np.nan, np.nan]))
    assert (row.dtheta, row.dx, row.dy) == (None, None, None)
    assert row.problem == "too few pushes with a known end for a spread: 1 of 5"
    assert push_statistics(noisy_set(0, 20)).problem is None
