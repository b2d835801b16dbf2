"""Where the rod was is taken from its places in a table that tells no side and fraction."""

import math
from collections import Counter
from dataclasses import astuple, replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import load_pushes
from cyclemap.evidence.comparison.collection_data import collection_data
from cyclemap.evidence.comparison.push_agreement import push_agreements
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.predicted_strokes import push_from_contact
from cyclemap.mechanics import Slider

HEADER = "rep,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1"
THETA = np.linspace(0.1, 6.1, 12)
# The rod starts so far (m) before it touches: more than a fifth of the way of the push.
AHEAD = 0.03


@pytest.fixture(scope="module")
def loop() -> CollectionLoop:
    made = CollectionLoop.mit("plywood")
    return replace(made, push=replace(made.push, distance=0.1))


def row_of(loop, theta, mirror=1.0, aside=0.0) -> str:
    """A line of a push that the loop makes, `aside` (m) of the rod's places apart from it."""
    start = loop.start_pose(float(theta))
    made = loop.model.push(start, loop.push)
    push = push_from_contact(loop.slider, loop.pusher.radius, loop.push, start, made.end)
    c, s = math.cos(push.direction), math.sin(push.direction)
    tips = [push.tip_start[0] - AHEAD * c, push.tip_start[1] - AHEAD * s, *push.tip_end]
    end = made.end
    poses = [start.x, start.y, start.theta, end.x, end.y, end.theta]
    numbers = np.array([*poses, *(np.array(tips) + aside)])
    numbers[[1, 2, 4, 5, 7, 9]] *= mirror
    return ",".join(f"{number:.12f}" for number in numbers)


@pytest.fixture
def written(tmp_path):
    def write(rows, header="", told=""):
        file = tmp_path / "tips.csv"
        numbered = [f"{told}{number},{row}" for number, row in enumerate(rows)]
        file.write_text("\n".join([header + HEADER, *numbered]) + "\n")
        return load_pushes(file)

    return write


def pushed(loop, **contact) -> CollectionLoop:
    return replace(loop, push=replace(loop.push, **contact))


def worst(table, loop) -> float:
    found = push_agreements(collection_data(table, loop).pushes, lambda done: None)[0]
    return max(one.rmse for each in found for one in each.quantities)


@pytest.mark.parametrize(
    "contact",
    [{"side": 1, "fraction": 0.4}, {"side": 2, "fraction": 0.55, "angle": 0.3}, {"angle": -0.2}],
)
def test_side_place_and_direction_are_those_of_the_rods_places(loop, written, contact) -> None:
    """And so is how far it went from its first touch, and whose map the cycles are set beside."""
    other = pushed(loop, **contact)
    table = written([row_of(other, theta) for theta in THETA])
    data = collection_data(table, loop)
    assert worst(table, loop) < 1e-8
    assert data.left_out == {}
    own, push = data.loop.push, other.push
    assert astuple(own) == pytest.approx(astuple(push), abs=1e-8)
    assert data.pairs.theta.size == 11
    (words,) = (line for line in data.reading if line.startswith("the rod's places"))
    degrees = round(math.degrees(push.angle), 1)
    assert f"side {push.side} at {push.fraction:g}, {degrees:g}° (12 pushes)" in words
    assert "the protocol's, side 0 at 0.7, 0°, is passed over" in words


def test_a_rod_where_the_protocol_has_it_is_not_told_of(loop, written) -> None:
    data = collection_data(written([row_of(loop, theta) for theta in THETA]), loop)
    assert data.loop is loop
    assert not any("rod's places" in line for line in data.reading)


def test_pushes_at_several_contacts_are_sets_of_their_own(loop, written) -> None:
    """Twelve at one place of a side, eight at another, and each of ten that are all over it."""
    loops = [pushed(loop, side=1, fraction=0.3)] * 12 + [pushed(loop, side=1)] * 8
    loops += [pushed(loop, side=2, fraction=share) for share in np.linspace(0.1, 0.9, 10)]
    table = written([row_of(made, 0.2 * number) for number, made in enumerate(loops)])
    data = collection_data(table, loop)
    assert sorted(len(each.push) for each in data.pushes) == [*[1] * 10, 8, 12]
    assert worst(table, loop) < 1e-8
    # What follows the last of the twelve is another contact's push, and yet ends its cycle.
    assert data.pairs.theta.size == 12
    assert data.loop.push.fraction == pytest.approx(0.3)


def test_a_disc_is_touched_anywhere_around_it(loop, written) -> None:
    disc = replace(loop, slider=Slider.mit("ellip1", loop.slider.hitch), footprint=None)
    other = pushed(disc, side=0, fraction=0.0)
    rows = [row_of(pushed(other, fraction=share % 1.0), 0.5) for share in (-1e-3, 0.0, 1e-3) * 3]
    data = collection_data(written(rows), disc)
    (found,) = data.pushes
    share = found.push[0].fraction
    assert min(share, 1.0 - share) < 1e-9


def test_a_rod_in_another_frame_than_the_object_tells_no_contact(loop, written) -> None:
    """It passes the object by: the protocol's contact is taken, as without its places."""
    other = pushed(loop, side=1)
    table = written([row_of(other, theta, aside=1.0) for theta in THETA])
    (found,) = collection_data(table, loop).pushes
    assert {(push.side, push.fraction) for push in found.push} == {(0, loop.push.fraction)}


def test_what_touches_no_side_or_tells_no_place_is_left_out_by_reason(loop, written) -> None:
    rows = [row_of(loop, theta) for theta in THETA]
    rows[3] = row_of(loop, THETA[3], aside=1.0)
    rows[5] = ",".join([*rows[5].split(",")[:6], "", "", "", ""])
    left = Counter(collection_data(written(rows), loop).left_out)
    assert left["the rod's places touch no side of the object"] == 1
    assert left["the rod's places are told of other pushes alone"] == 1


def test_a_contact_that_is_the_protocols_in_a_mirror_is_told(loop, written) -> None:
    table = written([row_of(loop, theta, mirror=-1.0) for theta in THETA])
    reading = collection_data(table, loop).reading
    told = "would be the protocol's: give --angles clockwise --frame mirrored if they are"
    assert any(told in line for line in reading)
    other = written([row_of(pushed(loop, side=1, fraction=0.4), theta) for theta in THETA])
    assert not any("mirrored if they are" in line for line in collection_data(other, loop).reading)


def test_a_contact_that_is_told_counts_where_the_rod_was_near_it_and_nowhere_else(
    loop, written
) -> None:
    """A logger writes nought for what it does not know; a robot says where it was sent."""
    other = pushed(loop, side=1, fraction=0.4)
    rows = [row_of(other, theta) for theta in THETA]
    table = written(rows, "i,s,t,", "0,0,0,")
    assert worst(table, loop) < 1e-8
    assert collection_data(table, loop).loop.push.side == 1
    near = written(rows, "i,s,t,", "1,0.45,0,")
    assert {push.fraction for push in collection_data(near, loop).pushes[0].push} == {0.45}


def test_where_no_reading_explains_the_pushes_that_is_said(loop, written) -> None:
    """Angles clockwise from 37 degrees: two readings that are far off are not taken for alike."""
    rows = [row_of(loop, theta) for theta in THETA]
    numbers = np.array([row.split(",") for row in rows], dtype=float)
    numbers[:, [2, 5]] = math.radians(37.0) - numbers[:, [2, 5]]
    turned = [",".join(map(str, row)) for row in numbers.tolist()]
    (words, *_) = check_pushes(written(turned), loop)
    assert "no reading explains them" in words and "cannot tell" not in words
    assert "(--offset-deg, --angles, --frame)?" in words
    (words,) = check_pushes(written(rows), loop)
    assert "explains" not in words
