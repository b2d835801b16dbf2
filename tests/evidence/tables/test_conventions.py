"""Data in other people's conventions: what a reading means, and that motions tell a wrong one from
the right.
"""

import math

import foreign_tables
import numpy as np
import pytest
from foreign_tables import CONVENTIONS, agrees, loop, thirty, truth
from refusals import refused

import cyclemap as cm
from cyclemap.evidence.identification.collected_blocks import collected_blocks
from cyclemap.evidence.motion_check import OtherConvention, check_pushes
from cyclemap.evidence.pushes.push_table import PushTable
from cyclemap.evidence.pushes.recordings import as_ours
from cyclemap.evidence.tables.columns import Convention, as_read_name, written_convention
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table
from cyclemap.mechanics import EllipseFriction, Pose, Pusher, QuasiStaticModel, Slider, WorldPush
from cyclemap.mechanics.contact_curve import first_contact

pandas = pytest.importorskip("pandas")

# The reading that each writer's convention wants; of some there are two, which turn the world.
WANTED = {
    "ours": [Convention()],
    "clockwise": [Convention("clockwise")],
    "compass": [Convention("compass")],
    "picture": [Convention("clockwise", "mirrored")],
    "picture counter-clockwise": [Convention(frame="mirrored")],
    "swapped": [Convention(frame="swapped")],
    "north east down": [Convention("compass", "swapped"), Convention("clockwise", "mirrored")],
}


def read(path, **told):
    """The pushes of a table of any kind, as every command has them."""
    if file_kind(path) is FileKind.OTHER:
        columns, units = told.pop("columns", None), told.pop("units", ())
        target = path.parent / "made_as_read.csv"
        target.write_text(read_own_table(path, columns, units, **told).csv_text())
        return cm.load_pushes(target)
    return cm.load_pushes(path, **told)


@pytest.mark.parametrize("name", CONVENTIONS)
def test_a_convention_undoes_what_its_writer_did(name) -> None:
    """Poses come back as they were, but for a turn of the world that nobody sees."""
    poses = truth(0).start
    written = CONVENTIONS[name](poses)
    for convention in WANTED[name]:
        x, y = convention.place(*written[:, :2].T)
        theta = convention.theta(written[:, 2])
        turned = theta - poses[:, 2]
        assert np.ptp(turned) < 1e-12
        place = (x + 1j * y) * np.exp(-1j * turned[0])
        assert place == pytest.approx(poses[:, 0] + 1j * poses[:, 1])


@pytest.mark.parametrize("name", [name for name in CONVENTIONS if name != "ours"])
@pytest.mark.filterwarnings("ignore::cyclemap.errors.DoubtfulInput")
def test_a_wrong_reading_is_refused_with_the_words_of_a_right_one(tmp_path, name) -> None:
    table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", name, 0.3, True, 3)
    path = table.made(tmp_path, with_collection=False)
    with pytest.raises(OtherConvention) as caught:
        check_pushes(cm.load_pushes(path), loop())
    given = str(caught.value).partition("give ")[2]
    assert any(given.startswith(one.options()) for one in WANTED[name]), given
    for one in WANTED[name]:
        pushes = cm.load_pushes(path, angles=one.angles, frame=one.frame)
        (words,) = check_pushes(pushes, loop())
        assert one.words() in words
        assert agrees({key: pushes.table[key].to_numpy() for key in _NAMES}, table)


_NAMES = ("x0", "y0", "theta0", "x1", "y1", "theta1")


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
    for name, told in (
        ("clockwise", True),
        ("picture counter-clockwise", True),
        ("picture", False),
        ("ours", False),
    ):
        table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", name, 0.3, True, 3)
        pushes = cm.load_pushes(table.made(tmp_path, with_collection=False))
        if told:
            refused(
                check_pushes,
                pushes,
                told="--angles clockwise, or --frame mirrored",
                kind=OtherConvention,
            )
        else:
            assert check_pushes(pushes)


def test_without_a_loop_a_collection_that_locked_in_tells_the_sense_too(tmp_path) -> None:
    """Orientations within some 30 degrees are enough for motions to tell the sense of angles."""
    rng = np.random.default_rng(0)
    theta = 0.9 + 0.1 * rng.standard_normal(40)
    moved = (0.042 - 0.072j + 0.001 * rng.standard_normal(40)) * np.exp(1j * theta)
    for sense in (1.0, -1.0):
        columns = {"x0": 0.0, "y0": 0.0, "theta0": sense * theta, "x1": moved.real}
        columns |= {"y1": moved.imag, "theta1": sense * (theta + 1.28)}
        path = tmp_path / "pushes.csv"
        pandas.DataFrame(columns).to_csv(path, index=False)
        pushes = cm.load_pushes(path)
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
    rows = ["x0,y0,th0,x1,y1,th1,push_mm"]
    for theta, (dx, dy) in zip(made.theta, made.push_displacement, strict=True):
        moved = (dx + 1j * dy) * np.exp(1j * theta)
        rows.append(f"0,0,{theta},{moved.real},{moved.imag},{theta},50")
    (tmp_path / "pushes.csv").write_text("\n".join(rows) + "\n")
    (words,) = check_pushes(cm.load_pushes(tmp_path / "pushes.csv"), square)
    assert "0 mm off" in words or "e-" in words


def _with_rod(path, **columns) -> pandas.DataFrame:
    """The L's pushes with the rod's places, and other columns; written as they are and in the
    mirror.
    """
    place, way = first_contact(loop().slider, loop().push, loop().pusher.radius)
    start, end = truth(5).start, truth(5).end
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    poses = pandas.DataFrame(
        np.hstack([start, end]), columns=["x0", "y0", "th0", "x1", "y1", "th1"]
    )
    for number, (x, y) in enumerate((place, place + loop().push.distance * way)):
        poses[f"tip_x{number}"] = start[:, 0] + c * x - s * y
        poses[f"tip_y{number}"] = start[:, 1] + s * x + c * y
    poses = poses.assign(**columns).iloc[:24]
    poses.to_csv(path, index=False)
    return poses


# Contacts that nobody tells, and those of a logger that writes nought for what it does not know.
@pytest.mark.parametrize("contacts", [{}, {"i": 0.0, "s": 0.0, "t": 0.0}], ids=["untold", "nought"])
def test_rods_places_tell_the_reading_where_contacts_do_not(tmp_path, contacts) -> None:
    """The L in the mirror: the rod would start inside it, or beside it. As it is, nothing is warned
    of.
    """
    path = tmp_path / "tips.csv"
    poses = _with_rod(path, **contacts)
    (words,) = check_pushes(cm.load_pushes(path), loop())
    assert ("passed over" in words) == bool(contacts)
    assert float(words.partition("friction's, ")[2].split()[0]) < 10.0
    mirrored = poses.assign(**{name: -poses[name] for name in poses if "y" in name or "th" in name})
    mirrored.to_csv(path, index=False)
    told = "give --angles clockwise --frame mirrored"
    refused(check_pushes, cm.load_pushes(path), loop(), told=told, kind=OtherConvention)


def test_contacts_that_are_right_tell_units_whatever_the_rods_places(tmp_path) -> None:
    """Lengths ten times too long: places of rod and object agree with each other, and with no
    object of that size.
    """
    path = tmp_path / "tips.csv"
    push = {"i": 5.0, "s": 0.72, "t": 0.0}
    poses = _with_rod(path, **push)
    (words,) = check_pushes(cm.load_pushes(path), loop())
    assert "passed over" not in words
    poses.assign(
        **{name: 10.0 * poses[name] for name in poses if "x" in name or "y" in name}
    ).to_csv(path, index=False)
    refused(check_pushes, cm.load_pushes(path), loop(), told="lengths in ", kind=OtherConvention)


def test_pushes_of_many_plates_anywhere_on_them_are_no_false_alarm(tmp_path) -> None:
    """Rods' places of random pushes on a floor with axes 1.25 : 1, sides and fractions nought: no
    warning.
    """
    friction, generator = EllipseFriction(0.30, 0.24, 0.01, 0.0, 0.4), np.random.default_rng(7)
    rows = ["shape,v_mm_s,i,s,t,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1"]
    for shape in ("rect1", "tri1", "hex"):
        model = QuasiStaticModel(Slider.mit(shape), friction, Pusher(friction=0.15), None, 1e-6)
        for theta, way, x, y in generator.uniform(
            (-3, -3, -0.015, -0.015), (3, 3, 0.015, 0.015), (12, 4)
        ):
            start, along = Pose(0.3, 0.0, theta), np.array((math.cos(way), math.sin(way)))
            first = np.array(start.to_world(x, y)) - 0.1 * along
            end, last = (
                model.push(start, WorldPush(tuple(first), way, 0.09)).end,
                first + 0.09 * along,
            )
            poses = (start.x, start.y, theta, end.x, end.y, end.theta, *first, *last)
            rows.append(f"{shape},10,0,0,0," + ",".join(map(repr, map(float, poses))))
    path = tmp_path / "plates.csv"
    path.write_text("\n".join(rows) + "\n")
    (words,) = check_pushes(cm.load_pushes(path))
    assert "3 objects" in words and "passed over" in words


def test_a_zero_of_angles_anywhere_is_found(tmp_path) -> None:
    """A tag stuck on askew: the object lies at 37 degrees where it reads zero."""
    askew = math.radians(37.0)
    table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", "ours", 0.0, True, 3)
    text = table.made(tmp_path, with_collection=False).read_text().splitlines()
    rows = [[float(field) for field in line.split(",")] for line in text[1:]]
    lines = [text[0]] + [
        ",".join(map(str, [*r[:2], r[2] - askew, *r[3:5], r[5] - askew, r[6]])) for r in rows
    ]
    path = tmp_path / "askew.csv"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(OtherConvention, match="--offset-deg") as caught:
        check_pushes(cm.load_pushes(path), loop())
    offset = float(str(caught.value).partition("give --offset-deg ")[2].split()[0])
    # As near as friction that is not isotropic lets one see.
    assert offset == pytest.approx(37.0, abs=6.0)
    assert check_pushes(cm.load_pushes(path, offset_deg=37.0), loop())


def test_places_of_a_corner_and_lengths_in_pixels_are_told_as_what_they_are(tmp_path) -> None:
    """Neither is taken for another zero of angles, which would fit them better than nothing."""
    table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", "ours", 0.3, True, 3)
    frame = pandas.read_csv(table.made(tmp_path, with_collection=False))
    corner, path = complex(*foreign_tables.VERTICES[0]), tmp_path / "other.csv"
    at_corner, pixels = frame.copy(), frame.copy()
    for end in ("0", "1"):
        moved = corner * np.exp(1j * frame[f"th{end}"])
        at_corner[f"x{end}"] += moved.to_numpy().real
        at_corner[f"y{end}"] += moved.to_numpy().imag
        pixels[[f"x{end}", f"y{end}"]] *= 1.8
    for written, told in (
        (at_corner, r"of a point of the object \((4|5)\d?[\d.]*, -3[\d.]+\) mm from its origin"),
        (pixels, r"were its lengths 0\.5\d+ times as long, [\d.]+ mm: are they pixels"),
    ):
        written.to_csv(path, index=False)
        refused(check_pushes, cm.load_pushes(path), loop(), told=told, kind=OtherConvention)


@pytest.mark.filterwarnings("ignore:pushes end")
def test_sides_without_a_place_on_them_are_doubted(tmp_path) -> None:
    table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", "ours", 0.3, True, 3)
    path = table.made(tmp_path, with_collection=False)
    frame = pandas.read_csv(path)
    frame.assign(side=np.arange(len(frame)) % 2 + 4).to_csv(path, index=False)
    with pytest.warns(cm.errors.DoubtfulInput, match="no column tells where on them: add fraction"):
        check_pushes(cm.load_pushes(path), loop())


def test_a_collection_file_says_it_for_all_data_beside_it(tmp_path) -> None:
    table = foreign_tables.Foreign(
        "made", foreign_tables.canonical, ".csv", "picture", 0.0, True, 3
    )
    path = table.made(tmp_path)
    file = tmp_path / "collection.toml"
    file.write_text(f'{file.read_text()}\n[data]\nangles = "clockwise"\nframe = "mirrored"\n')
    pushes = cm.load_pushes(path)
    assert agrees({key: pushes.table[key].to_numpy() for key in _NAMES}, table)
    assert check_pushes(pushes, cm.protocol.loop_from_file(file))
    file.write_text(file.read_text().replace("mirrored", "mirorred"))
    refused(cm.load_pushes, path, told="did you mean 'mirrored'")


def test_orientations_alone_say_what_is_assumed_and_are_turned_as_told(tmp_path) -> None:
    theta = np.degrees(truth(1).start[:, 2])
    path = tmp_path / "log.csv"
    path.write_text("yaw_deg\n" + "".join(f"{-angle}\n" for angle in theta))
    assert any("orientations alone cannot tell" in line for line in read_own_table(path).words)
    found = np.degrees(read_own_table(path, angles="clockwise").columns["theta0"])
    assert found == pytest.approx(theta)
    path.write_text("theta0_deg\n" + "".join(f"{90.0 - angle}\n" for angle in theta))
    pairs = cm.evidence.read_theta0_pairs(path, angles="compass")
    assert np.cos(pairs.theta) == pytest.approx(np.cos(np.radians(theta[:-1])))
    assert np.degrees(pairs.turn) == pytest.approx(np.diff(theta))


def test_a_turn_that_is_told_has_the_sense_of_the_angles(tmp_path) -> None:
    """One of more than half a turn, which two poses cannot tell."""
    path = tmp_path / "log.csv"
    rows = [f"0.1,0.2,{start},0.14,0.2,{start + 4.0 - 2.0 * math.pi},4.0" for start in (0.1, 0.9)]
    path.write_text("\n".join(["x0,y0,theta0,x1,y1,theta1,dtheta", *rows, ""]))
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
    poses = [[0.0, 0.3, 0.1, 0.5], [0.1, 0.32, 0.15, 0.9]]
    record = cm.evidence.PushRecord(poses, poses, [[0.0, 1.0, 2.0, 0.1]])
    written = cm.evidence.PushRecord(
        [[t, x, -y, -a] for t, x, y, a in poses],
        [[t, x, -y, -a] for t, x, y, a in poses],
        [[0.0, 1.0, -2.0, -0.1]],
    )
    found = as_ours(written, Convention("clockwise", "mirrored"))
    assert found.displacement == pytest.approx(record.displacement) and found.turn == pytest.approx(
        record.turn
    )
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
    assert agrees({key: pushes.table[key].to_numpy() for key in _NAMES}, table)


def test_another_loop_than_the_tables_is_not_taken_for_another_convention(tmp_path) -> None:
    """Half as large an object misses everywhere: no reading beats another,
    and nothing is refused."""
    table = foreign_tables.Foreign("made", foreign_tables.canonical, ".csv", "ours", 1.0, True, 3)
    pushes = cm.load_pushes(table.made(tmp_path, with_collection=False))
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
    assert (of_folder.convention, as_told.convention) == (
        Convention("clockwise", "mirrored"),
        Convention(),
    )
    assert of_folder.convention_told and as_told.convention_told
    assert np.allclose(of_folder.table["theta0"], -as_told.table["theta0"])


@pytest.mark.parametrize("degrees", [30.0, -7.25, 1e-05, 90])
def test_the_name_of_a_table_as_read_tells_its_convention(degrees) -> None:
    told = {"angles": "clockwise", "frame": "mirrored", "offset_deg": degrees}
    assert written_convention(as_read_name("log", told)) == (Convention.of_keys(told), True)
    assert written_convention("log_plus.deg_as_read.csv") == (Convention(), False)
