"""Files of every sort are recognised and become blocks of data; what is left out is told, what
cannot be is refused.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence import (
    RecordingNoise,
    SurfaceParameters,
    collected_blocks,
    identify,
    load_pushes,
    simulate_collection,
)
from cyclemap.evidence.identification.collected_blocks import CollectedBlocks
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.known_floor import FLOOR_TOLD, held_values, telling_parameters
from cyclemap.evidence.identification.surface_parameters import SURFACE, starting_space
from cyclemap.mechanics import (
    EllipseFriction,
    FoundWith,
    Material,
    PlatePressure,
    Pose,
    load_material,
)
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.protocol import loop_from_settings

LOOP = CollectionLoop.mit("isotropic")
# The tables are made up: where their pushes end is of no object.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::cyclemap.errors.DoubtfulInput"),
]
ELLIPSE = ("ellipticity_x", "ellipticity_y", "offset_x", "offset_y")
FLOOR = ("floor_bow_x", "floor_bow_y", "floor_dome")
SHAPES = (*FLOOR, "plate_dome", "plate_warp_x", "plate_warp_y")
FRAME = ("tip_offset_x", "tip_offset_y")
# A ring with some friction, as is believed of any.
RING = {"pin_friction_radius": 1e-3}
SLATE = Material(
    "slate", EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6), found_with=FoundWith(**RING)
)
TRUTH = SurfaceParameters.from_friction(SLATE.friction, pusher_friction=0.15, **RING).values()
TRUTH |= {"tip_offset_x": 0.0, "tip_offset_y": 0.0}
NOISE = RecordingNoise(turn=math.radians(0.5), position=2e-4, angle=2e-3, force=0.03)
CYCLES = 30
ENDS = "surface,shape,v_mm_s,i,s,t,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1,tip_err_mm\n"
DRAGS = "surface,shape,x1,y1,th1,x0n,y0n,th0n\n"
WRENCHES = "surface,shape,fx,fy,m_over_rho,vx,vy,w_times_rho\n"


@pytest.fixture(scope="module")
def collection(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("slate")
    loop = CollectionLoop.mit(SLATE, accuracy=1e-6)
    simulate_collection(loop, folder, CYCLES, noise=NOISE, seed=1, scans=True, start=0.3)
    return folder


@pytest.fixture(scope="module")
def data(collection) -> CollectedBlocks:
    """All of the collection, few pushes for speed."""
    return collected_blocks([collection], LOOP, most=4)


def push_row(number: int, surface="slate", shape="rect1", tip_error=0.0) -> str:
    aside = 0.001 * number
    poses, tips = f"0,0,0,0,-0.02,0.1,{aside}", f"0.05,{aside},0"
    return f"{surface},{shape},10,{number % 4},0.5,0,{poses},{tips},{tip_error}\n"


def write(path: Path, header: str, rows: list[str]) -> Path:
    path.parent.mkdir(exist_ok=True)
    path.write_text(header + "".join(rows))
    return path


def every_sort(folder: Path, surface: str = "slate") -> list[Path]:
    drags = [f"{surface},rect1,0.05,{0.01 * n},0.{n},0.01,0.0,0.5\n" for n in range(6)]
    wrenches = [f"{surface},rect1,0,2,0,0,0.01,0.001\n" for _ in range(5)]
    return [
        write(folder / "ends.csv", ENDS, [push_row(n, surface) for n in range(6)]),
        write(folder / "drags.csv", DRAGS, drags),
        write(folder / "wrenches.csv", WRENCHES, wrenches),
        write(folder / "theta.csv", "theta0_deg\n", [f"{7 * n}\n" for n in range(9)]),
    ]


def names(found: CollectedBlocks) -> dict[str, int]:
    return {block.name: len(block.groups) for block in found.blocks}


def cycles_of(found: CollectedBlocks):
    (cycles,) = [block for block in found.blocks if block.name == "cycles"]
    return cycles


def test_every_sort_of_table_is_recognised_by_its_columns_alone_or_in_a_folder(tmp_path) -> None:
    found = collected_blocks(every_sort(tmp_path), LOOP)
    pushed, alone = "rect1 10 mm/s", "rect1 theta"
    assert names(found) == {
        f"{pushed} push ends": 18,
        f"{pushed} drag-backs": 6,
        f"{pushed} wrenches": 15,
        f"{alone} cycles": 8,
        "sessions": 12,
    }
    assert found.surface == "slate" and found.last_cycle == 7.0
    blocks = [collected_blocks([path], LOOP).blocks[0] for path in every_sort(tmp_path)]
    assert {block.name: telling_parameters([block]) for block in blocks} == {
        "push ends": (*ELLIPSE, "pusher_friction", *SHAPES, *FRAME),
        "drag-backs": (*ELLIPSE, *SHAPES),
        "wrenches": ("friction_scale", "floor_dome", *SHAPES[3:]),
        "cycles": (*ELLIPSE, "pusher_friction", "pin_friction_radius", *SHAPES),
    }
    (drags,) = [block for block in blocks if block.name == "drag-backs"]
    assert held_values([drags], SURFACE, ELLIPSE)["pin_friction_radius"] == pytest.approx(0.8e-3)
    assert "pin_friction_radius" in telling_parameters([drags], FLOOR_TOLD)
    write(tmp_path / "budget.csv", "euro\n", ["3\n"])
    write(tmp_path / "notes.txt", "rod bent on tuesday", [])
    folder = collected_blocks([tmp_path], LOOP)
    assert names(folder) == names(found)
    told = f"{tmp_path / 'budget.csv'}: not used: a CSV table of unknown columns (euro)"
    assert any(note.startswith(told) for note in folder.notes)


def test_a_collection_gives_scans_cycles_push_ends_and_force_ratios_as_it_was_made(data) -> None:
    """Residuals at the truth are of the noise put in: half a degree a cycle; 0.2 mm and 2 mrad a
    pose, which also shift the contact by so much on a lever of 18 mm, and with it the turn by a few
    times more."""
    told = names(data)
    assert told.pop("force ratios") >= 4
    assert told == {"friction scans": 2 * 144, "cycles": CYCLES - 1, "push ends": 3 * 4}
    assert any("every 7.5th of 30 pushes taken" in note for note in data.notes)
    law = SLATE.friction
    turned = (data.scans @ [1.0, 1j]) * np.exp(-1j * law.phi) - complex(law.m0, law.n0)
    radius = np.hypot(turned.real / law.mu_a, turned.imag / law.mu_b)
    assert radius == pytest.approx(np.ones(144), abs=5e-3)
    sizes = {}
    for block in data.blocks:
        residual, _ = block.residuals(TRUTH)
        for kind in np.unique(block.kinds).tolist():
            sizes[kind] = float(np.std(residual[block.kinds == kind]))
    assert sizes["cycle turn (rad)"] == pytest.approx(math.radians(0.5), rel=0.35)
    assert 1e-4 < sizes["push place (m)"] < 1.2e-3 and 1e-3 < sizes["push turn (rad)"] < 1.5e-2


def test_the_friction_of_a_simulated_collection_comes_back_within_its_intervals(data) -> None:
    free = telling_parameters(data.blocks)
    assert set(free) >= {"friction_scale", *SHAPES, "pin_friction_radius"} and len(free) == 15
    options = {"priors": usual_beliefs(free), "starts": 1, "level": 0.99}
    found = identify(data.blocks, free, space=starting_space(LOOP), **options)
    assert found.fit.converged
    for name in free:
        assert found[name].lower <= TRUTH[name] <= found[name].upper, found[name]
    assert found.friction().mu_a == pytest.approx(0.28, abs=2e-3)


# A surface that might wear, at an even pace, and does not.
PACE = {f"wear_pace_{stretch}": 0.0 for stretch in range(1, 9)}
WORN = {f"worn_{name}": TRUTH[name] for name in (*ELLIPSE, *FLOOR)} | PACE


def test_first_and_wear_choose_and_order_the_cycles(collection) -> None:
    found = collected_blocks([collection], LOOP, first=20, wear=True, most=6)
    cycles = cycles_of(found)
    assert len(cycles.groups) == CYCLES - 1 - 20 and found.last_cycle == CYCLES - 2 - 20
    # On a surface that does not wear each derivative is shared out between its two ends.
    jacobian = dict(zip(cycles.parameters, cycles.residuals(TRUTH | WORN)[1].T, strict=True))
    fresh, worn = jacobian["offset_x"], jacobian["worn_offset_x"]
    assert [worn[0], fresh[-1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.all(np.diff(worn / (fresh + worn)) > 0.0)
    assert set(telling_parameters(found.blocks)[-15:]) == set(WORN)


# Pushed at side 1, at 0.4 of it, where the protocol has 0 and 0.7.
PUSH = replace(LOOP.push, side=1, fraction=0.4)
ELSEWHERE = replace(CollectionLoop.mit(SLATE, accuracy=1e-5), push=PUSH)
PUSHED = ("repetition", "x0", "y0", "theta0", "x1", "y1", "theta1")
PUSHED += ("tip_x0", "tip_y0", "tip_x1", "tip_y1")


def as_table(pushes: Path, file: Path, *left_out: str) -> Path:
    """The pushes of a folder as a table of poses and tips, which names no side."""
    rows = load_pushes(pushes).table.sort_values("repetition")
    rows[[name for name in PUSHED if name not in left_out]].to_csv(file, index=False)
    return file


def test_cycles_are_taken_of_a_table_with_tips_as_of_the_same_pushes_in_files(tmp_path) -> None:
    simulate_collection(ELSEWHERE, tmp_path / "made", 14, noise=RecordingNoise(turn=0.01))
    table = as_table(tmp_path / "made", tmp_path / "tips.csv")
    for options in ({}, {"first": 4}, {"first": 4, "wear": True}):
        files, rows = (collected_blocks([it], LOOP, **options) for it in (tmp_path / "made", table))
        assert len(cycles_of(rows).groups) == 13 - options.get("first", 0)
        assert rows.last_cycle == files.last_cycle
        assert cycles_of(rows).parameters == cycles_of(files).parameters
        values = TRUTH | WORN
        misses, expected = (cycles_of(found).residuals(values)[0] for found in (rows, files))
        np.testing.assert_allclose(misses, expected, rtol=0, atol=1e-6)
    assert names(rows)["push ends"] == 3 * 10
    assert f"{table}: 4 left out: pushes before 4" in rows.notes
    refused(collected_blocks, [table], LOOP, first=99, told="first is 99: the last push is 13")


def test_first_and_wear_are_refused_where_no_push_is_numbered(collection, tmp_path) -> None:
    table = as_table(collection, tmp_path / "tips.csv", "repetition")
    told = "first is 3: the data number no pushes: add a column rep, or leave --first out"
    refused(collected_blocks, [table], LOOP, first=3, told=told)
    told = "wear is that of cycles, and the data have none: number the pushes"
    refused(collected_blocks, [table], LOOP, wear=True, told=told)


def test_the_cycles_of_a_table_with_drag_backs_are_not_counted_twice(collection, tmp_path) -> None:
    rows = load_pushes(collection).table.rename(columns={"theta_next": "th0n"})
    rows = rows.assign(x0n=0.35, y0n=-0.03)
    rows[[*PUSHED, "x0n", "y0n", "th0n"]].dropna().to_csv(tmp_path / "both.csv", index=False)
    found = collected_blocks([tmp_path / "both.csv"], LOOP)
    assert {*names(found)} == {"push ends", "drag-backs"}


def test_poses_alone_tell_the_push_whose_rod_went_as_the_protocol_says(tmp_path) -> None:
    loop = replace(LOOP, push=replace(PUSH, angle=0.2, distance=0.05))
    bare, full = [], []
    place, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    for theta in np.linspace(0.3, 6.0, 8):
        start = Pose(0.1, -0.05, theta)
        tips = [*start.to_world(*place), *start.to_world(*(place + 0.05 * way))]
        poses = f"{start.x},{start.y},{theta},0.12,-0.06,{theta + 0.3}"
        bare.append(poses + "\n")
        full.append(f"{poses},{','.join(map(str, tips))}\n")
    tips = "tip_x0,tip_y0,tip_x1,tip_y1"
    paths = [
        write(tmp_path / "full.csv", f"x0,y0,th0,x1,y1,th1,{tips}\n", full),
        write(tmp_path / "bare.csv", "x0,y0,theta0,x1,y1,theta1\n", bare),
    ]
    told = "8 left out: ends of pushes: .* add a column push_mm, or set push_mm"
    refused(collected_blocks, paths[1:], loop, told=told)
    collected = [collected_blocks([path], loop, push_length=0.05) for path in paths]
    known, found = (own.blocks[0].residuals(TRUTH)[0] for own in collected)
    assert found == pytest.approx(known, abs=1e-9)


def test_objects_are_plates_and_what_is_not_selected_is_left_out_and_counted(tmp_path) -> None:
    rows = [push_row(n) for n in range(5)] + [push_row(n, shape="hex") for n in range(3)]
    rows += [push_row(n, "felt") for n in range(2)] + [push_row(0, tip_error=9.0)]
    file = write(tmp_path / "ends.csv", ENDS, rows)
    slate = {"surface": "slate"}
    found = collected_blocks([file], LOOP, slate)
    pushed = {"rect1 10 mm/s push ends": 15, "hex 10 mm/s push ends": 9}
    assert names(found) == pushed | {"sessions": 12}
    for reason in ("2 left out: of surface felt", "1 left out: the tip was not where it was sent"):
        assert sum(note.startswith(f"{file}: {reason}") for note in found.notes) == 1
    more = write(tmp_path / "more.csv", ENDS, rows[:8])
    of_more = {f"{plate} 10 mm/s, more push ends" for plate in ("rect1", "hex")}
    assert set(names(collected_blocks([file, more], LOOP, slate))) == {*names(found), *of_more}
    hexagons = collected_blocks([file], LOOP, {"object": "hex"})
    assert names(hexagons) == {"push ends": 9} and hexagons.loop.slider.name == "hex"


def test_numbers_are_selected_however_they_are_written(tmp_path) -> None:
    texts = enumerate((",0.5,0,", ",0.50,0,", ",0.6,0,"))
    rows = [push_row(n).replace(",0.5,0,", text) for n, text in texts]
    file = write(tmp_path / "ends.csv", ENDS, rows)
    assert names(collected_blocks([file], LOOP, {"fraction": 0.5})) == {"push ends": 6}


def test_several_surfaces_or_unknown_objects_are_refused_until_one_is_selected(tmp_path) -> None:
    first, second = tmp_path / "one", tmp_path / "two"
    every_sort(first)
    every_sort(second, "felt")
    told = "several surfaces: felt, slate; select one"
    refused(collected_blocks, [first, second], LOOP, told=told)
    told = r"no such surface: delrin; .* left out: of surface slate, not delrin"
    refused(collected_blocks, [first / "ends.csv"], LOOP, {"surface": "delrin"}, told=told)
    found = collected_blocks([first, second], LOOP, {"surface": "felt"})
    assert found.surface == "felt"
    # Orientations tell no surface: both tables of them are kept, and told apart by a number.
    cycles = {"rect1 theta cycles", "rect1 theta, theta cycles"}
    assert {*cycles, "rect1 10 mm/s push ends"} <= {*names(found)}
    rows = [push_row(n, shape=shape) for n in range(3) for shape in ("brick", "plate")]
    file = write(tmp_path / "ends.csv", ENDS, rows)
    own = replace(LOOP, slider=replace(LOOP.slider, name="own outline"))
    refused(collected_blocks, [file], own, told="several objects: brick, plate; select one")
    assert names(collected_blocks([file], own, {"object": "brick"})) == {"push ends": 9}


def test_nothing_recognised_names_what_each_path_was(tmp_path) -> None:
    text = write(tmp_path / "notes.txt", "rod bent", [])
    table = write(tmp_path / "budget.csv", "euro\n", ["3\n"])
    (tmp_path / "empty").mkdir()
    each = r"kind \(\.txt\).*unknown columns \(euro\).*holds no \.h5"
    for paths, told in (
        ([text, table, tmp_path / "empty"], each),
        ([tmp_path / "absent.csv"], "there is nothing there"),
        ([write(tmp_path / "cut.json", "", ["{"])], r"1 left out: unreadable, the first cut\.json"),
    ):
        refused(collected_blocks, paths, LOOP, told=told)
    for key, value in (("first", -1), ("most", 1), ("most", 2.5)):
        refused(collected_blocks, [table], LOOP, **{key: value})


def test_the_measured_tables_are_recognised_whole(measured_data) -> None:
    plywood = {"surface": "plywood", "object": "rect1"}
    sorts = ("push_endpoints", "rect1_dragback", "rect1_wrench_twist")
    files = [measured_data / f"mit_{sort}_v10.csv" for sort in sorts]
    found = collected_blocks(files, LOOP, plywood, most=1000)
    assert names(found) == {"push ends": 3 * 395, "drag-backs": 130, "wrenches": 3 * 1100}
    assert any("several sources (HEAD_filtered, hist_52a83a8)" in note for note in found.notes)
    assert len(set(found.blocks[0].groups.tolist())) == 44
    cycles = collected_blocks([measured_data / "plywood_rect1_theta0_2000.csv"], LOOP, first=500)
    assert names(cycles) == {"cycles": 1497}


def test_a_material_to_start_from_is_where_every_search_begins() -> None:
    plywood, plates = load_material("plywood"), (PlatePressure("rect1"),)
    known = replace(plywood, found_with=FoundWith(pusher_friction=0.3), plates=plates)
    space = starting_space(LOOP, known)
    wanted = SurfaceParameters.from_friction(plywood.friction).offset_x
    assert space["offset_x"].start == space["offset_x"].nominal == wanted
    assert space["pusher_friction"].start == 0.3
    assert space["plate_dome"].nominal == space["plate_dome"].start == 0.0
    points = loop_from_settings({"footprint": "grid:8"}, LOOP)
    refused(starting_space, points, told="exact footprint")


def test_a_row_that_does_not_tell_its_plate_or_its_speed_counts_once(tmp_path) -> None:
    rows = []
    for place in range(24):
        cells = push_row(place, shape=("rect1", "hex", "")[place % 3]).split(",")
        cells[2] = ("10", "20", "")[place // 3 % 3]
        rows.append(",".join(cells))
    found = collected_blocks([write(tmp_path / "ends.csv", ENDS, rows)], LOOP)
    counts = {name: rows for name, rows in names(found).items() if name != "sessions"}
    assert sum(counts.values()) == 3 * 24
    assert {name.partition(" ")[0] for name in counts} == {"rect1", "hex"}


@pytest.mark.parametrize("tips", [True, False])
def test_pushes_at_one_contact_are_one_group_whether_or_not_the_rods_places_are_told(
    tmp_path, tips
) -> None:
    """Twelve contacts, three pushes at each: what the model misses at a contact is no evidence
    three times.
    """
    columns = ENDS.strip().split(",")
    count = len(columns) if tips else columns.index("tip_x0")
    rows = []
    for place in range(36):
        side, fraction = place % 4, 0.3 + 0.2 * (place // 4 % 3)
        cells = ["slate", "rect1", 10, side, fraction, 0, 0, 0, 0, 0, -0.02, 0.1, 0.001 * place]
        rows.append(",".join(map(str, [*cells, 0.05, 0.001 * place, 0, 0][:count])) + "\n")
    header = ",".join(columns[:count]) + "\n"
    path = write(tmp_path / "ends.csv", header, rows)
    (block,) = collected_blocks([path], LOOP, push_length=0.05).blocks
    assert len(block.motions) == 36 and len(np.unique(block.groups)) == 12


def test_pushes_at_few_contacts_are_said_to_make_narrow_intervals(tmp_path) -> None:
    rows = [push_row(place) for place in range(12)]
    found = collected_blocks([write(tmp_path / "ends.csv", ENDS, rows)], LOOP)
    assert any("12 pushes at 4 contacts alone" in note for note in found.notes)
    few = collected_blocks([write(tmp_path / "each.csv", ENDS, rows[:4])], LOOP)
    assert not any("alone" in note for note in few.notes)


def test_pieces_of_one_push_are_said_to_share_errors_that_are_not_told(data, tmp_path) -> None:
    """Each of several pushes is a group; those of one alone cannot tell what they share."""
    loop = CollectionLoop.mit(SLATE, accuracy=1e-6)
    simulate_collection(loop, tmp_path, 1, noise=NOISE, seed=1, start=0.3)
    alone = collected_blocks([tmp_path], LOOP)
    assert names(alone)["force ratios"] >= 3
    said = "errors that they share are not told"
    assert any(said in note for note in alone.notes)
    assert not any(said in note for note in data.notes)
