"""Data in other people's conventions: what a reading means, and that motions tell a wrong one from
the right.
"""

import math
from dataclasses import astuple

import foreign_tables
import numpy as np
import pytest
from foreign_tables import CONVENTIONS, agrees, loop, thirty, truth
from made_tables import saved
from refusals import refused

import cyclemap as cm
from cyclemap.evidence.identification.collected_blocks import collected_blocks
from cyclemap.evidence.motion_check import OtherConvention, check_pushes
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.recordings import as_ours
from cyclemap.evidence.tables.columns import (
    ENDS,
    Convention,
    as_read_name,
    written_convention,
)
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table
from cyclemap.mechanics import EllipseFriction, Pose, Pusher, QuasiStaticModel, Slider, WorldPush
from cyclemap.mechanics.contact_curve import first_contact

pandas = pytest.importorskip("pandas")

# The reading that each writer's convention wants; of some there are two, which turn the world.
WANTED = {
    "clockwise": [Convention("clockwise")],
    "compass": [Convention("compass")],
    "picture": [Convention("clockwise", "mirrored")],
    "picture counter-clockwise": [Convention(frame="mirrored")],
    "swapped": [Convention(frame="swapped")],
    "north east down": [Convention("compass", "swapped"), Convention("clockwise", "mirrored")],
}


def table_in(folder, convention="ours", noise=0.3, with_collection=False):
    """The L's pushes under our own names in a convention: what they are, and their table."""
    write = foreign_tables.canonical
    table = foreign_tables.Foreign("made", write, ".csv", convention, noise, True, 3)
    return table, table.made(folder, with_collection)


def loaded(folder, content):
    """The pushes of a table of this content."""
    return cm.load_pushes(saved(folder, content))


def motions(pushes):
    """Ends of pushes by the names of `agrees`."""
    return {name: pushes.table[name].to_numpy() for name in ENDS}


def read(path, **told):
    """The pushes of a table of any kind, as every command has them."""
    if file_kind(path) is FileKind.OTHER:
        columns, units = told.pop("columns", None), told.pop("units", ())
        target = path.parent / "made_as_read.csv"
        target.write_text(read_own_table(path, columns, units, **told).csv_text())
        return cm.load_pushes(target)
    return cm.load_pushes(path, **told)


@pytest.mark.parametrize("name", [name for name in CONVENTIONS if name != "ours"])
@pytest.mark.filterwarnings("ignore::cyclemap.errors.DoubtfulInput")
def test_a_wrong_reading_is_refused_with_the_words_of_a_right_one(tmp_path, name) -> None:
    table, path = table_in(tmp_path, name)
    with pytest.raises(OtherConvention) as caught:
        check_pushes(cm.load_pushes(path), loop())
    given = str(caught.value).partition("give ")[2]
    assert any(given.startswith(one.options()) for one in WANTED[name]), given
    for one in WANTED[name]:
        pushes = cm.load_pushes(path, angles=one.angles, frame=one.frame)
        (words,) = check_pushes(pushes, loop())
        assert one.words() in words
        assert agrees(motions(pushes), table)


def test_ends_in_the_objects_own_frame_are_no_angles_in_degrees(tmp_path) -> None:
    """Were radians degrees all pushes would begin at next to nothing, and these ends fit; but the
    object would hardly turn.
    """
    made = foreign_tables.wrapped_canonical
    table = foreign_tables.Foreign("made", made, ".csv", "ours", 0.0, True, 3)
    path = table.made(tmp_path, with_collection=False)
    header, *lines = path.read_text().splitlines()
    poses = np.array([line.split(",") for line in lines], dtype=float)
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = (poses[:, 3:5] - poses[:, :2]).T
    poses[:, 3], poses[:, 4] = c * x + s * y, c * y - s * x
    poses[:, :2] = 0.0
    text = "\n".join(",".join(map(str, row)) for row in poses.tolist())
    path.write_text(f"{header}\n{text}\n")
    (said,) = check_pushes(cm.load_pushes(path), loop())
    assert "no reading explains them" in said and "--units" not in said


def test_without_a_loop_pushes_that_should_be_alike_tell_the_sense_and_not_the_hand(
    tmp_path,
) -> None:
    """Angles or axes turned, each alone, are told; both turned are a mirror image, in which all is
    as consistent.
    """
    told = "--angles clockwise, or --frame mirrored"
    for name in ("clockwise", "picture counter-clockwise"):
        pushes = cm.load_pushes(table_in(tmp_path, name)[1])
        refused(check_pushes, pushes, told=told, kind=OtherConvention)
    for name in ("picture", "ours"):
        assert check_pushes(cm.load_pushes(table_in(tmp_path, name)[1]))


def test_without_a_loop_a_collection_that_locked_in_tells_the_sense_too(tmp_path) -> None:
    """Orientations within some 30 degrees are enough for motions to tell the sense of angles."""
    rng = np.random.default_rng(0)
    theta = 0.9 + 0.1 * rng.standard_normal(40)
    moved = (0.042 - 0.072j + 0.001 * rng.standard_normal(40)) * np.exp(1j * theta)
    for sense in (1.0, -1.0):
        columns = {"x0": 0.0, "y0": 0.0, "theta0": sense * theta, "x1": moved.real}
        columns |= {"y1": moved.imag, "theta1": sense * (theta + 1.28)}
        pushes = loaded(tmp_path, pandas.DataFrame(columns))
        if sense > 0.0:
            (words,) = check_pushes(pushes)
            assert "inf" not in words
        else:
            refused(check_pushes, pushes, told="--angles clockwise", kind=OtherConvention)


def test_an_object_that_is_its_own_mirror_image_pushed_in_its_middle_is_not_refused(
    tmp_path,
) -> None:
    """A square pushed through its centre moves alike in a mirror: no reading is better, and that is
    said.
    """
    push = cm.mechanics.SidePush(side=0, fraction=0.5, angle=0.0, distance=0.05)
    square = cm.CollectionLoop.mit("isotropic", push=push)
    made = square.cycles(np.linspace(0.0, 6.0, 20))
    moved = (made.push_displacement @ (1.0, 1j)) * np.exp(1j * made.theta)
    columns = {"x0": 0.0, "y0": 0.0, "th0": made.theta, "x1": moved.real, "y1": moved.imag}
    table = pandas.DataFrame(columns | {"th1": made.theta, "push_mm": 50.0})
    (words,) = check_pushes(loaded(tmp_path, table), square)
    assert "0 mm off" in words or "e-" in words


def with_rod(**columns) -> pandas.DataFrame:
    """The L's pushes with the rod's places, and other columns."""
    place, way = first_contact(loop().slider, loop().push, loop().pusher.radius)
    start, end = truth(5).start, truth(5).end
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    poses = pandas.DataFrame(np.hstack([start, end]), columns=[*ENDS])
    for number, (x, y) in enumerate((place, place + loop().push.distance * way)):
        poses[f"tip_x{number}"] = start[:, 0] + c * x - s * y
        poses[f"tip_y{number}"] = start[:, 1] + s * x + c * y
    return poses.assign(**columns).iloc[:24]


# Contacts that nobody tells, and those of a logger that writes nought for what it does not know.
@pytest.mark.parametrize("contacts", [{}, {"i": 0.0, "s": 0.0, "t": 0.0}], ids=["untold", "nought"])
def test_rods_places_tell_the_reading_where_contacts_do_not(tmp_path, contacts) -> None:
    """The L in the mirror: the rod would start inside it, or beside it. As it is, nothing is warned
    of.
    """
    poses = with_rod(**contacts)
    (words,) = check_pushes(loaded(tmp_path, poses), loop())
    assert ("passed over" in words) == bool(contacts)
    assert float(words.partition("friction's, ")[2].split()[0]) < 10.0
    poses.loc[:, poses.columns.str.contains("y|theta")] *= -1.0
    told = "give --angles clockwise --frame mirrored"
    refused(check_pushes, loaded(tmp_path, poses), loop(), told=told, kind=OtherConvention)


def test_contacts_that_are_right_tell_units_whatever_the_rods_places(tmp_path) -> None:
    """Lengths ten times too long: places of rod and object agree with each other, and with no
    object of that size.
    """
    poses = with_rod(i=5.0, s=0.72, t=0.0)
    (words,) = check_pushes(loaded(tmp_path, poses), loop())
    assert "passed over" not in words
    poses.loc[:, poses.columns.str.contains("x|y")] *= 10.0
    told = "lengths in "
    refused(check_pushes, loaded(tmp_path, poses), loop(), told=told, kind=OtherConvention)


def test_pushes_of_many_plates_anywhere_on_them_are_no_false_alarm(tmp_path) -> None:
    """Rods' places of random pushes on a floor with axes 1.25 : 1, sides and fractions nought: no
    warning.
    """
    friction, generator = EllipseFriction(0.30, 0.24, 0.01, 0.0, 0.4), np.random.default_rng(7)
    rows = ["shape,v_mm_s,i,s,t,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1"]
    for shape in ("rect1", "tri1", "hex"):
        model = QuasiStaticModel(Slider.mit(shape), friction, Pusher(friction=0.15), None, 1e-6)
        most = (3.0, 3.0, 0.015, 0.015)
        for theta, way, x, y in generator.uniform(np.negative(most), most, (12, 4)):
            start, along = Pose(0.3, 0.0, theta), np.array((math.cos(way), math.sin(way)))
            first = np.array(start.to_world(x, y)) - 0.1 * along
            end = model.push(start, WorldPush(tuple(first), way, 0.09)).end
            poses = [*astuple(start), *astuple(end), *first, *(first + 0.09 * along)]
            rows.append(f"{shape},10,0,0,0," + ",".join(f"{number:.17g}" for number in poses))
    (words,) = check_pushes(loaded(tmp_path, "\n".join(rows)))
    assert "3 objects" in words and "passed over" in words


def test_a_zero_of_angles_anywhere_is_found(tmp_path) -> None:
    """A tag stuck on askew: the object lies at 37 degrees where it reads zero."""
    table = pandas.read_csv(table_in(tmp_path, noise=0.0)[1])
    table[["th0", "th1"]] -= math.radians(37.0)
    path = saved(tmp_path, table)
    with pytest.raises(OtherConvention, match="--offset-deg") as caught:
        check_pushes(cm.load_pushes(path), loop())
    offset = float(str(caught.value).partition("give --offset-deg ")[2].split()[0])
    # As near as friction that is not isotropic lets one see.
    assert offset == pytest.approx(37.0, abs=6.0)
    assert check_pushes(cm.load_pushes(path, offset_deg=37.0), loop())


def test_places_of_a_corner_and_lengths_in_pixels_are_told_as_what_they_are(tmp_path) -> None:
    """Neither is taken for another zero of angles, which would fit them better than nothing."""
    frame = pandas.read_csv(table_in(tmp_path)[1])
    corner, at_corner, pixels = complex(*foreign_tables.VERTICES[0]), frame.copy(), frame.copy()
    for end in ("0", "1"):
        moved = corner * np.exp(1j * frame[f"th{end}"])
        at_corner[f"x{end}"] += moved.to_numpy().real
        at_corner[f"y{end}"] += moved.to_numpy().imag
        pixels[[f"x{end}", f"y{end}"]] *= 1.8
    for table, told in (
        (at_corner, r"of a point of the object \((4|5)\d?[\d.]*, -3[\d.]+\) mm from its origin"),
        (pixels, r"were its lengths 0\.5\d+ times as long, [\d.]+ mm: are they pixels"),
    ):
        refused(check_pushes, loaded(tmp_path, table), loop(), told=told, kind=OtherConvention)


@pytest.mark.filterwarnings("ignore:pushes end")
def test_sides_without_a_place_on_them_are_doubted(tmp_path) -> None:
    frame = pandas.read_csv(table_in(tmp_path)[1])
    pushes = loaded(tmp_path, frame.assign(side=np.arange(len(frame)) % 2 + 4))
    with pytest.warns(cm.errors.DoubtfulInput, match="no column tells where on them: add fraction"):
        check_pushes(pushes, loop())


def test_a_collection_file_says_it_for_all_data_beside_it(tmp_path) -> None:
    table, path = table_in(tmp_path, "picture", 0.0, with_collection=True)
    file = tmp_path / "collection.toml"
    file.write_text(f'{file.read_text()}\n[data]\nangles = "clockwise"\nframe = "mirrored"\n')
    pushes = cm.load_pushes(path)
    assert agrees(motions(pushes), table)
    assert check_pushes(pushes, cm.protocol.loop_from_file(file))
    file.write_text(file.read_text().replace("mirrored", "mirorred"))
    refused(cm.load_pushes, path, told="did you mean 'mirrored'")


def test_orientations_alone_say_what_is_assumed_and_are_turned_as_told(tmp_path) -> None:
    theta = np.degrees(truth(1).start[:, 2])
    path = saved(tmp_path, pandas.DataFrame({"yaw_deg": -theta}))
    assert any("orientations alone cannot tell" in line for line in read_own_table(path).words)
    found = np.degrees(read_own_table(path, angles="clockwise").columns["theta0"])
    assert found == pytest.approx(theta)
    path = saved(tmp_path, pandas.DataFrame({"theta0_deg": 90.0 - theta}))
    pairs = cm.evidence.read_theta0_pairs(path, angles="compass")
    assert np.cos(pairs.theta) == pytest.approx(np.cos(np.radians(theta[:-1])))
    assert np.degrees(pairs.turn) == pytest.approx(np.diff(theta))


def test_a_turn_that_is_told_has_the_sense_of_the_angles(tmp_path) -> None:
    """One of more than half a turn, which two poses cannot tell."""
    rows = [f"0.1,0.2,{start},0.14,0.2,{start + 4.0 - 2.0 * math.pi},4.0" for start in (0.1, 0.9)]
    path = saved(tmp_path, "\n".join(["x0,y0,theta0,x1,y1,theta1,dtheta", *rows]))
    for angles, sense in (("counter-clockwise", 1.0), ("clockwise", -1.0)):
        table = cm.load_pushes(path, angles=angles).table
        assert table["dtheta"].to_numpy() == pytest.approx(4.0 * sense)
        assert table["theta1"].to_numpy() == pytest.approx(sense * np.array([4.1, 4.9]))


def test_wrenches_and_twists_in_another_convention_are_refused(tmp_path) -> None:
    path = tmp_path / "wrenches.csv"
    path.write_text("fx,fy,m_over_rho,vx,vy,w_times_rho\n1,2,0.1,0.3,0.4,0.5\n")
    (tmp_path / "collection.toml").write_text('[data]\nangles = "clockwise"\n')
    told = "wrenches and twists are read with axes right-handed.* alone, not --angles clockwise"
    refused(collected_blocks, [path], loop(), told=told)


def test_a_recording_in_another_convention_is_brought_to_ours() -> None:
    """Displacement, turn and lever of the force are those of the true motion."""
    poses, wrench = np.array([[0.0, 0.3, 0.1, 0.5], [0.1, 0.32, 0.15, 0.9]]), [[0.0, 1.0, 2.0, 0.1]]
    record = cm.evidence.PushRecord(poses, poses, wrench)
    mirror = np.array([1.0, 1.0, -1.0, -1.0])
    written = cm.evidence.PushRecord(poses * mirror, poses * mirror, wrench * mirror)
    found = as_ours(written, Convention("clockwise", "mirrored"))
    assert found.displacement == pytest.approx(record.displacement)
    assert found.turn == pytest.approx(record.turn)
    assert found.ft_wrench == pytest.approx(record.ft_wrench)


@pytest.mark.slow
@pytest.mark.parametrize("table", [one for one in thirty() if one.posed], ids=lambda one: one.name)
@pytest.mark.filterwarnings("ignore::cyclemap.errors.DoubtfulInput")
def test_thirty_foreign_tables_are_read_right_or_refused_with_what_mends_them(
    tmp_path, table
) -> None:
    """As it stands, or after what the refusal says, every push is what happened; half of the tables
    are not in ours.
    """
    path, told = table.made(tmp_path, with_collection=False), {}
    for _ in range(2):
        pushes = read(path, **told)
        try:
            check_pushes(pushes, loop())
        except OtherConvention as error:
            given = str(error).partition("give ")[2].split()
            for option, value in zip(given[::2], given[1::2], strict=False):
                if option not in ("--angles", "--frame", "--units"):
                    break
                told[option[2:]] = [value] if option == "--units" else value.rstrip(";,:")
        else:
            break
    assert (table.convention != "ours") == bool(set(told) - {"units"})
    assert agrees(motions(pushes), table)


def test_another_loop_than_the_tables_is_not_taken_for_another_convention(tmp_path) -> None:
    """Half as large an object misses everywhere: no reading beats another,
    and nothing is refused."""
    pushes = cm.load_pushes(table_in(tmp_path, noise=1.0)[1])
    assert isinstance(pushes, PushTable)
    assert check_pushes(pushes, cm.CollectionLoop.mit("plywood"))


def test_a_table_tells_the_convention_it_was_read_in_and_who_said_it(tmp_path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("x0,y0,theta0,x1,y1,theta1\n" + 3 * "0.1,0.2,0.3,0.14,0.2,0.5\n")
    ours = {"angles": "counter-clockwise", "frame": "right-handed"}
    assert not cm.load_pushes(path).convention_told
    assert cm.load_pushes(path, **ours).convention_told
    said = '[data]\nangles = "clockwise"\nframe = "mirrored"\n'
    (tmp_path / "collection.toml").write_text(said)
    of_folder, as_told = cm.load_pushes(path), cm.load_pushes(path, **ours)
    assert of_folder.convention == Convention("clockwise", "mirrored")
    assert as_told.convention == Convention()
    assert of_folder.convention_told and as_told.convention_told
    assert np.allclose(of_folder.table["theta0"], -as_told.table["theta0"])


@pytest.mark.parametrize("degrees", [30.0, -7.25, 1e-05, 90])
def test_the_name_of_a_table_as_read_tells_its_convention(degrees) -> None:
    told = {"angles": "clockwise", "frame": "mirrored", "offset_deg": degrees}
    assert written_convention(as_read_name("log", told)) == (Convention.of_keys(told), True)
    assert written_convention("log_plus.deg_as_read.csv") == (Convention(), False)
