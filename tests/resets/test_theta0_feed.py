"""Orientations from files that grow, stop in mid-line, are cut, replaced or damaged; and from
folders of pushes.
"""

import json
import os
import shutil
from functools import partial

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.evidence import read_theta0_pairs
from cyclemap.evidence.tables.columns import Convention
from cyclemap.resets import theta0_feed as module
from cyclemap.resets.theta0_feed import NewOrientations, theta0_feed

NOTHING = NewOrientations(())
damaged = partial(refused, kind=DataFileError)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "data.csv"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pushes").mkdir()
    return tmp_path / "pushes"


def degrees(found) -> list[float]:
    return np.round(np.degrees(found.theta), 9).tolist()


def append(file, text: str) -> None:
    with file.open("a", newline="") as stream:
        stream.write(text)


def test_rows_are_given_once_as_they_come_and_a_half_written_one_when_it_is_whole(file) -> None:
    file.write_text("theta0")
    feed = theta0_feed(file)
    assert degrees(feed.look()) == []
    for text, rows in (
        ("_deg\n10.5\n\n37", [10.5]),
        ("0.25\r\n-5\r\n", [370.25, -5.0]),
        ("", []),
        ("7", []),
    ):
        append(file, text)
        assert degrees(feed.look()) == rows
    late = theta0_feed(file)
    assert len(late.look().theta) == 3 and degrees(feed.look(finished=True)) == [7.0]
    append(file, "\n3\n4,5\n")
    damaged(late.look, told="line 8: 2 of 1 fields")


@pytest.mark.parametrize("size", [1, 7])
def test_a_file_in_pieces_of_any_size_gives_what_the_whole_file_gives(file, size) -> None:
    raw = ("\ufefftheta0_deg,note\n" + "".join(f"{7.5 * k},é{k}\n" for k in range(20))).encode()
    file.touch()
    feed, found = theta0_feed(file), []
    for at in range(0, len(raw), size):
        with file.open("ab") as stream:
            stream.write(raw[at : at + size])
        found += degrees(feed.look())
    assert found == [7.5 * k for k in range(20)]


@pytest.mark.parametrize("name", ["theta0_deg", "yaw_deg"])
def test_the_convention_turns_orientations_of_ours_and_of_own_tables(file, name) -> None:
    file.write_text(f"{name}\n10\n25\n170\n")
    feed = theta0_feed(file, convention=Convention("compass"))
    assert degrees(feed.look(finished=True)) == [80.0, 65.0, -80.0]


def test_pairs_and_staircases_are_read_by_their_first_orientation(file, measured_data) -> None:
    file.write_text("theta_next_deg,Theta0_deg\n20,10\n30,20\n")
    assert degrees(theta0_feed(file).look(finished=True)) == [10.0, 20.0]
    staircase = measured_data / "plywood_rect1_theta0_2000.csv"
    found = theta0_feed(staircase).look(finished=True).theta
    assert np.array(found) == pytest.approx(read_theta0_pairs(staircase).path)


ROWS = ["10.125", "20.250", "30.375", "40.500"]


def written(rows) -> str:
    return "theta0_deg\n" + "".join(f"{row}\n" for row in rows)


@pytest.mark.parametrize("how", ["in place", "replaced", "removed"])
@pytest.mark.parametrize(
    "rows",
    [
        # Cut short; cut at its start and written on; edited; a rotated log that begins alike.
        *(ROWS[:1], ROWS[1:], [*ROWS[1:], "1.5", "2.5"]),
        *(["10.129", *ROWS[1:]], [*ROWS[:2], "30.379", *ROWS[3:]], [*ROWS[:3], "40.509"]),
        *(["111.5", "222.5"], [*ROWS[:3], "111.5", "222.5"]),
    ],
)
def test_a_file_that_begins_anew_is_read_from_its_start(file, how, rows) -> None:
    """By the same inode, by another's, or by one that is used again."""
    file.write_text(written(ROWS))
    feed = theta0_feed(file)
    assert not feed.look().began_anew
    if how == "in place":
        file.write_text(written(rows))
    elif how == "replaced":
        other = file.with_name("other.csv")
        other.write_text(written(rows))
        other.replace(file)
    else:
        file.unlink()
        assert feed.look() == NOTHING
        file.write_text(written(rows))
    found = feed.look()
    assert found.began_anew and degrees(found) == [float(one) for one in rows]
    assert feed.look() == NOTHING


def test_a_file_that_is_empty_for_a_while_is_what_was_read_until_new_rows_come(file) -> None:
    file.write_text(written(ROWS))
    feed = theta0_feed(file)
    feed.look()
    file.write_text("")
    assert feed.look() == NOTHING
    file.write_text(written(ROWS[:1]))
    assert feed.look() == NewOrientations((np.radians(10.125),), began_anew=True)
    append(file, "20.25\n")
    assert feed.look() == NewOrientations((np.radians(20.25),))


def test_a_pipe_and_a_file_without_end_are_refused(tmp_path, file, monkeypatch) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    damaged(theta0_feed(tmp_path / "pipe.csv").look, told=r"pipe\.csv: is a pipe or a device")
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    file.write_text(written(ROWS * 5))
    damaged(theta0_feed(file).look, told=r"data\.csv: holds more than 0\.0 MB")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("theta0_deg\n1\nabc\n", r"data.csv, line 3: theta0_deg is 'abc'; .* a finite number"),
        ("theta0_deg\n1\n\nnan\n", r"line 4: theta0_deg is 'nan'"),
        ("theta0_deg,flag\n1,\n2\n", "line 3: 1 of 2 fields"),
        ("speed,flag\n1,\n", r"say which, --columns theta0=NAME; it has speed, flag"),
        ('theta0_deg\n"1\n', r"line 2: .* mend the quotes"),
        ("theta0_deg\n1\n1e300\n", r"line 3: theta0_deg is '1e300'; .* of a turn is lost"),
        ("theta0_accum_deg\n-6e10\n", r"line 2: theta0_accum_deg is '-6e10'; at such a size"),
        ("theta0_deg\n", "line 1: a header but no rows"),
        ("", "the file is empty; it needs a header line"),
        ("theta0_deg\n1\n\udcff\n", "line 3: byte 13 is not UTF-8 text"),
    ],
)
def test_bad_rows_are_named_with_line_and_value(file, content, told) -> None:
    damaged(theta0_feed(file).look, told="there is no such file")
    file.write_text(content, errors="surrogateescape")
    damaged(theta0_feed(file).look, finished=True, told=told)


def test_a_header_that_grows_into_another_is_refused(file) -> None:
    file.write_text("theta0")
    feed = theta0_feed(file)
    append(file, "\n1\n")
    named = "line 1: the header is theta0; it must have theta0_deg or theta0_accum_deg"
    damaged(feed.look, told=named)


def push_text(theta: float) -> str:
    poses = [[0.0, 0.3, 0.0, theta], [0.1, 0.3, 0.05, theta + 1.0]]
    return json.dumps({"object_pose": poses, "tip_pose": poses, "ft_wrench": poses})


def push_file(folder, repetition: int, text: str):
    name = f"motion_surface=abs_shape=hex_a=0_v=20_i=0.000_s=0.700_t=0.000_rep={repetition:04d}"
    (folder / f"{name}.json").write_text(text)


def test_a_folder_gives_its_pushes_in_order_and_waits_for_one_half_written(folder) -> None:
    for repetition in (2, 10, 1):
        push_file(folder, repetition, push_text(0.1 * repetition))
    feed = theta0_feed(folder)
    assert feed.look().theta == pytest.approx((0.1, 0.2, 1.0))
    push_file(folder, 11, push_text(1.1)[:60])
    push_file(folder, 12, push_text(1.2))
    assert feed.look().theta == ()
    push_file(folder, 11, push_text(1.1))
    assert feed.look().theta == pytest.approx((1.1, 1.2))
    push_file(folder, 13, "{")
    feed.look()
    damaged(feed.look, told=r"rep=0013\.json: not JSON, or cut short")
    push_file(folder, 13, push_text(2e9))
    lost = r"rep=0013\.json: .* is 2e[+]09; it must be a number within"
    damaged(feed.look, finished=True, told=lost)


def test_an_empty_folder_is_no_collection(folder) -> None:
    feed = theta0_feed(folder)
    assert feed.look().theta == ()
    damaged(feed.look, finished=True, told="holds no recorded push")
    (folder / "plywood").mkdir()
    (folder / "plywood" / "push.h5").touch()
    damaged(feed.look, finished=True, told=r"there are some in .*plywood: give that")
    shutil.rmtree(folder)
    folder.write_text("")
    damaged(feed.look, told=r"pushes: cannot be read \(Not a directory\)")


def test_a_folder_that_is_away_is_read_anew_once_it_holds_pushes_again(folder) -> None:
    push_file(folder, 1, push_text(0.1))
    feed = theta0_feed(folder)
    assert feed.look().theta == pytest.approx((0.1,))
    shutil.rmtree(folder)
    assert [feed.look(), feed.look()] == [NOTHING] * 2
    damaged(feed.look, finished=True, told="pushes: there is no such folder; check the path")
    folder.mkdir()
    assert feed.look() == NOTHING
    push_file(folder, 1, push_text(0.3))
    found = feed.look()
    assert found.began_anew and found.theta == pytest.approx((0.3,))
    assert feed.look() == NOTHING


def test_folders_pipes_and_links_to_nothing_among_the_pushes_are_passed_over(folder) -> None:
    push_file(folder, 1, push_text(0.1))
    (folder / "d.json").mkdir()
    os.mkfifo(folder / "p.json")
    assert theta0_feed(folder).look(finished=True).theta == pytest.approx((0.1,))
    elsewhere = folder.with_name("push.json")
    (folder / "link.json").symlink_to(elsewhere)
    feed = theta0_feed(folder)
    assert feed.look().theta == pytest.approx((0.1,))
    damaged(feed.look, finished=True, told=r"link\.json: a link to a file that is not there")
    elsewhere.write_text(push_text(0.7))
    assert feed.look(finished=True).theta == pytest.approx((0.7,))


def test_a_push_that_goes_while_it_is_read_or_cannot_be_read_is_no_bare_error(
    folder, monkeypatch
) -> None:
    """One that is deleted after it was listed is passed over; a failing disk is named."""

    def vanishing(path):
        path.unlink()
        raise FileNotFoundError(2, "No such file or directory", str(path))

    def failing(path):
        raise OSError(5, "Input/output error")

    push_file(folder, 1, push_text(0.1))
    monkeypatch.setattr(module, "read_push_file", vanishing)
    feed = theta0_feed(folder)
    assert [feed.look().theta, feed.look().theta] == [(), ()]
    push_file(folder, 1, push_text(0.1))
    monkeypatch.setattr(module, "read_push_file", failing)
    damaged(feed.look, finished=True, told=r"rep=0001\.json: cannot be read \(Input/output error\)")


def test_a_table_of_ones_own_is_followed_row_by_row(file) -> None:
    """Semicolons and decimal commas, a number cut off, a missing value, an edit."""
    file.write_text("Nr;yaw")
    feed = theta0_feed(file, {"theta0": "yaw"}, ["deg"])
    assert feed.look() == NOTHING
    append(file, "\n1;12,5\n2;17,2")
    assert degrees(feed.look()) == [12.5]
    append(file, "5\n3;\n4;31,0\n")
    found = feed.look()
    assert degrees(found) == [17.25, 31.0]
    assert any("yaw read as theta0 in deg" in line for line in found.words)
    assert feed.look() == NOTHING
    file.write_text("Nr;yaw\n1;12,5\n2;18,0\n3;20,0\n")
    found = feed.look()
    assert found.began_anew and degrees(found) == [12.5, 18.0, 20.0]
    file.unlink()
    assert feed.look() == NOTHING
    damaged(feed.look, finished=True, told="no such file")


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("small.csv", "yaw\n0.5\n1.0\n", "another unit of yaw: say it, --units deg or rad"),
        ("stream.csv", "t,x,y,yaw_deg\n0,0,0,10\n1,0,0,20\n", "into pushes once it is whole"),
        ("log.xlsx", "no\nmatter\n", "only a CSV file is read while it grows"),
    ],
)
def test_what_rows_to_come_would_read_otherwise_is_not_followed(
    tmp_path, name, content, told
) -> None:
    (tmp_path / name).write_text(content)
    damaged(theta0_feed(tmp_path / name).look, told=told)
