"""Streams of poses: pushes are found by where the ring is at rest, whatever noise, pauses and lost
rows there are.
"""

import math
from itertools import pairwise

import foreign_tables
import numpy as np
import pytest
from foreign_tables import CONVENTIONS, agrees
from refusals import refused

import cyclemap as cm
from cyclemap.errors import DataFileError
from cyclemap.evidence.tables.own_tables import read_own_table
from cyclemap.evidence.tables.pose_streams import UnclearStream, cut_stream

pandas = pytest.importorskip("pandas")


def made(tmp_path, noise_mm, convention="ours", seed=3):
    """A stream of 72 cycles with pauses of 2.5 s in two pushes and three rows in a hundred lost,
    and what it holds.
    """
    write = foreign_tables.stream
    table = foreign_tables.Foreign("made", write, ".csv", convention, noise_mm, True, seed)
    return table, table.made(tmp_path, with_collection=False)


@pytest.mark.slow
@pytest.mark.parametrize("noise_mm", [0.0, 0.3, 1.0])
def test_pushes_are_told_from_drags_through_noise_pauses_and_lost_rows(tmp_path, noise_mm) -> None:
    """Every push that is given is one that happened, and follows the one before it where it says
    so.
    """
    table, path = made(tmp_path, noise_mm)
    found = read_own_table(path)
    assert agrees(found.columns, table)
    assert len(found.columns["x0"]) == 72
    follows = np.isfinite(found.columns["theta_next"])
    turn = found.columns["theta_next"] - found.columns["theta0"]
    true = foreign_tables.loop().next_theta(found.columns["theta0"]) - found.columns["theta0"]
    off = np.degrees(np.abs((turn - true + math.pi) % (2.0 * math.pi) - math.pi))[follows]
    # The noise of a cycle is 1.1 degrees, that of a rest's mean pose a fifth of the camera's.
    assert off.max() < 4.0 + 4.0 * noise_mm and follows.sum() > 50
    assert found.segments is not None and "2 of them" in found.segments.words


@pytest.mark.slow
@pytest.mark.parametrize("convention", [name for name in CONVENTIONS if name != "ours"])
def test_a_stream_is_cut_alike_in_every_convention(tmp_path, convention) -> None:
    """Which rests have the ring at the target is the same in a mirror."""
    (tmp_path / "ours").mkdir()
    straight = read_own_table(made(tmp_path / "ours", 0.0)[1])
    other = read_own_table(made(tmp_path, 0.0, convention)[1])
    assert np.array_equal(straight.segments.pushes, other.segments.pushes)


def timed(poses):
    """Poses (n, 3) at 30 Hz."""
    table = pandas.DataFrame(poses, columns=["x", "y", "theta"])
    return table.assign(t=np.arange(len(table)) / 30.0)


def test_a_stream_whose_motions_are_of_no_kind_is_refused_and_can_be_drawn(tmp_path) -> None:
    """An object carried about at random."""
    rng, rows, now = np.random.default_rng(0), [], np.zeros(3)
    for _ in range(30):
        later = np.concatenate([0.2 * rng.uniform(-1, 1, 2), rng.uniform(-3, 3, 1)])
        rows += [now] * 40 + [now + share * (later - now) for share in np.linspace(0.0, 1.0, 60)]
        now = later
    with pytest.raises(UnclearStream, match="give a column episode") as caught:
        cut_stream(tmp_path / "walk.csv", timed(rows))
    from cyclemap.views.push_pages import stream_page

    assert len(caught.value.seen.rests) > 25 and stream_page(caught.value.seen).axes


def recorded(marks, creep=0.0):
    """A stream at 30 Hz that goes from mark to mark (m, m, rad) in 2 s and rests on each; on the
    fourth it creeps by so much (m), a fifth as fast as motions are.
    """
    rows, crept = [], np.array([creep, 0.0, 0.0])
    marks = [*marks[:4], *(mark + crept for mark in marks[4:])]
    for number, (a, b) in enumerate(pairwise(marks)):
        if number == 3:
            rows += [a] * 20 + [a + share * crept for share in np.linspace(0.0, 1.0, 40)]
            a = a + crept
        rows += [a] * 40 + [a + share * (b - a) for share in np.linspace(0.0, 1.0, 60)]
    return timed([*rows, *[marks[-1]] * 40])


@pytest.mark.parametrize("creep", [0.0, 0.010])
def test_two_kinds_in_turn_are_told_where_no_ring_is(tmp_path, creep) -> None:
    """Pushes that are alike, and a gripper that brings the object anywhere between them: two kinds
    in turn. An object that creeps while it should rest makes no third.
    """
    now = np.array([0.0, 0.0, 0.2])
    marks = [now]
    for number in range(10):
        c, s = math.cos(now[2]), math.sin(now[2])
        pushed = now + np.array([0.05 * c, 0.05 * s, 1.0])
        turned = pushed[2] - 1.4 + 0.1 * math.cos(5.0 * number)
        now = np.array([0.03 * math.sin(7.0 * number), 0.02 * number, turned])
        marks += [pushed, now]
    columns, seen = cut_stream(tmp_path / "gripper.csv", recorded(marks, creep))
    turns = columns["theta1"].to_numpy() - columns["theta0"].to_numpy()
    assert turns == pytest.approx(np.ones(10), abs=0.02) and "two kinds" in seen.words


def test_of_two_poses_again_and_again_the_first_is_a_pushs_begin(tmp_path) -> None:
    """A loop without noise at its stable direction: any place of the object's that goes there and
    back could be its ring.
    """
    loop = cm.CollectionLoop.mit("plywood", accuracy=1e-6)
    (theta,) = (orbit.points[0] for orbit in cm.fixed_points(loop.circle_map(1e-4)) if orbit.stable)
    poses = loop.start_pose(theta), loop.cycle(theta).push.end
    begin, end = (np.array([pose.x, pose.y, pose.theta]) for pose in poses)
    columns, seen = cut_stream(tmp_path / "locked.csv", recorded([begin, end] * 12))
    assert seen.pushes.tolist() == [[rest, rest + 1] for rest in range(0, 24, 2)]
    assert columns["theta0"].to_numpy() == pytest.approx(begin[2], abs=1e-3)
    assert columns["theta1"].to_numpy() == pytest.approx(end[2], abs=1e-3)


@pytest.mark.parametrize("rows_apart", [6, 11])
def test_a_stream_of_few_rows_a_second_is_cut_as_a_dense_one(tmp_path, rows_apart) -> None:
    """At 5 and 2.7 rows a second a window is one or two rows: means behind and before a row are
    of different rows.
    """
    begin, end = np.array([0.0, 0.0, 0.2]), np.array([0.03, 0.05, 1.3])
    dense = recorded([begin, end] * 12)
    rng = np.random.default_rng(6)
    dense[["x", "y"]] += 2e-4 * rng.standard_normal((len(dense), 2))
    _, seen = cut_stream(tmp_path / "dense.csv", dense)
    _, sparse = cut_stream(tmp_path / "few.csv", dense.iloc[::rows_apart])
    assert sparse.pushes.tolist() == seen.pushes.tolist() and len(seen.pushes) == 12


def test_noise_that_hides_all_motion_is_told(tmp_path) -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.05, (3000, 3))
    told = r"hides its motions|no push in it"
    refused(cut_stream, tmp_path / "noise.csv", timed(noise), told=told, kind=DataFileError)


@pytest.mark.slow
@pytest.mark.parametrize(("noise_mm", "pauses"), [(0.0, ()), (0.3, (1, 11, 12)), (1.0, (5,))])
def test_pushes_of_a_collection_that_locked_in_are_told_through_pauses(
    tmp_path, noise_mm, pauses
) -> None:
    """Two poses again and again: a pause within a push does not make drags of all
    that follow it."""
    loop, rng = cm.CollectionLoop.mit("plywood", accuracy=1e-6), np.random.default_rng(7)
    theta, rows, starts = 1.0, [], []
    push, back = np.linspace(0.0, 1.0, 225)[:, None], np.linspace(0.0, 1.0, 150)[:, None]
    paused = np.insert(push, [90] * 75, push[90], axis=0)
    for number in range(30):
        cycle = loop.cycle(theta)
        starts.append(theta)
        theta = cycle.theta_next + math.radians(1.1) * rng.standard_normal()
        poses = [loop.start_pose(starts[-1]), cycle.push.end, loop.start_pose(theta)]
        a, b, c = (np.array([pose.x, pose.y, pose.theta]) for pose in poses)
        still = int(rng.uniform(24.0, 48.0))
        share = paused if number in pauses else push
        rows += [*[a] * still, *(a + share * (b - a)), *[b] * still, *(b + back * (c - b))]
    table = np.array([*rows, *[c] * 40])
    table += noise_mm * np.array([1e-3, 1e-3, math.radians(1.0)]) * rng.normal(size=table.shape)
    columns, _ = cut_stream(tmp_path / "locked.csv", timed(table))
    assert columns["theta0"].to_numpy() == pytest.approx(starts, abs=0.01 + 0.03 * noise_mm)
    assert np.degrees(columns["theta1"].to_numpy() - columns["theta0"].to_numpy()).min() > 60.0
