"""Strokes and cycles as data: exact where the mechanics made them, their derivatives true, wear
blended.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import (
    DataBlock,
    MeasuredDrag,
    MeasuredPush,
    SurfaceParameters,
    cycle_pair_block,
    drag_turn_block,
    identify,
    push_end_block,
)
from cyclemap.evidence.identification.session_blocks import PLATE_OWNED
from cyclemap.evidence.identification.stroke_block import (
    TIP_OFFSET,
    loop_on,
    surface_model,
)
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_NAMES,
    FLOOR_NAMES,
    PLATE_NAMES,
    worn_share,
)
from cyclemap.evidence.predicted_strokes import predicted_push_ends, push_from_contact
from cyclemap.evidence.pushes.measured_strokes import measured_drags
from cyclemap.evidence.tables.columns import DRAG_ENDS, known_columns
from cyclemap.mechanics import Pose, Pusher, Slider, WorldPush
from cyclemap.text_files import read_csv_table

RECT1, MIT = Slider.mit("rect1"), CollectionLoop.mit()
TRUTH = SurfaceParameters(
    ellipticity_x=0.1,
    ellipticity_y=-0.05,
    offset_x=0.04,
    offset_y=0.02,
    floor_dome=2.0,
    floor_bow_x=-1.5,
    floor_bow_y=0.4,
    pusher_friction=0.2,
    plate_dome=-0.5,
    plate_warp_x=0.6,
    plate_warp_y=-0.3,
    pin_friction_radius=1e-3,
)
LATE = {"ellipticity_x": 0.05, "ellipticity_y": -0.1, "offset_x": 0.01, "offset_y": -0.01}
LATE |= {"floor_dome": 2.5, "floor_bow_x": -1.0, "floor_bow_y": 0.2}
EXACT = surface_model(TRUTH, RECT1, accuracy=1e-9)
OFFSET = np.array([8e-4, -5e-4])
SHIFTS = {"tip_offset_x": 8e-4, "tip_offset_y": -5e-4, "rod_off_x": 3e-4, "rod_off_y": -2e-4}
SHIFTS |= {"rod_off_turn": 0.01}
VALUES = {**TRUTH.values(), **SHIFTS}
PACE = {f"wear_pace_{stretch}": 0.1 * stretch for stretch in range(1, 9)}
WORN = VALUES | {f"worn_{name}": value for name, value in LATE.items()} | PACE
PLAIN = {**SurfaceParameters().values(), **dict.fromkeys(SHIFTS, 0.0)}
# What a stroke itself may be off by, rad, and steps wide enough that it counts for little.
STROKE_ERROR = 3e-4
STEPS = {**dict.fromkeys((*FLOOR_NAMES, *PLATE_NAMES), 0.12), "pin_friction_radius": 1.6e-5}
STEPS |= dict.fromkeys(SHIFTS, 1.6e-4) | {"rod_off_turn": 3e-3} | dict.fromkeys(PACE, 0.3)
THETA = np.random.default_rng(0).uniform(-3.0, 9.0, 12)


def made_pushes(count: int) -> list[MeasuredPush]:
    """Pushes of 50 mm from random sides at random angles, as a robot whose frame is shifted would
    record them.
    """
    generator, pushes = np.random.default_rng(0), []
    for number in range(count):
        start = Pose(0.0, 0.0, float(generator.uniform(-3.0, 3.0)))
        way = float(generator.uniform(-math.pi, math.pi))
        along = 0.115 * np.array([math.cos(way), math.sin(way)])
        first = np.array(start.to_world(*generator.uniform(-0.02, 0.02, 2).tolist())) - along
        end = EXACT.push(start, WorldPush(tuple(first.tolist()), way, 0.115)).end
        tips = (tuple(tip.tolist()) for tip in (first - OFFSET, first + along - OFFSET))
        pushes.append(MeasuredPush(start, end, *tips, number // 2))
    return pushes


def made_drags(count: int) -> list[MeasuredDrag]:
    generator, drags = np.random.default_rng(1), []
    for number in range(count):
        place = generator.uniform(-0.08, 0.08, 2).tolist()
        start = Pose(*place, float(generator.uniform(-3.0, 3.0)))
        end = EXACT.drag(start, ((0.0, 0.0),), pin_friction_radius=TRUTH.pin_friction_radius).end
        drags.append(MeasuredDrag(start, end, number))
    return drags


def made_cycles(share: float | np.ndarray | None = None) -> DataBlock:
    turns = loop_on(TRUTH, MIT).next_theta(THETA) - THETA
    elapsed = None if share is None else share + 0.0 * THETA
    return cycle_pair_block(MIT, THETA, turns, np.arange(12), elapsed)


PUSHES = push_end_block(made_pushes(8), RECT1)
# Of each kind its block, how many rows and parameters it has, and the largest residual at the truth
# (m, rad): the Fourier series through 47 cycles is as near as 2 mrad; a measured cycle scatters by
# ten times as much.
KINDS = {
    "pushes": (lambda: PUSHES, (24, 13), 1e-4),
    "pushes of a plate": (lambda: PUSHES.of_owner("rect1", PLATE_OWNED), (24, 13), 1e-4),
    # Eight rods, each off its mark by itself, and as many objects turned: three unknowns a push.
    "pushes by hand": (lambda: push_end_block(made_pushes(8), RECT1, None, 3), (24, 35), math.inf),
    "drags": (lambda: drag_turn_block(made_drags(8), RECT1), (8, 11), 3e-4),
    "cycles": (made_cycles, (12, 12), 5e-3),
    "worn cycles": (lambda: made_cycles(np.linspace(0.0, 1.0, 12)), (12, 27), math.inf),
}


# Of cycles that wear; of those that do not each is checked.
SOME_WORN = ("offset_x", "floor_bow_x", "plate_dome", "worn_offset_x", "worn_floor_bow_x")
SOME_WORN += ("wear_pace_1", "wear_pace_8")


def assert_slope(block, values, jacobian, name: str, step: float) -> None:
    """Assert that a column is the central difference, but for errors of the strokes."""
    up, down = (block.residuals({**values, name: values[name] + by})[0] for by in (step, -step))
    expected = (up - down) / (2.0 * step)
    error = 0.03 * np.abs(expected).max() + STROKE_ERROR / step
    column = block.parameters.index(name)
    assert jacobian[:, column] == pytest.approx(expected, abs=error), name


CASES = [pytest.param(kind, {}, marks=[pytest.mark.slow] * ("cycles" in kind)) for kind in KINDS]
CASES += [(kind, dict.fromkeys((*FLOOR_NAMES, *PLATE_NAMES), 0.0)) for kind in ("pushes", "drags")]
CASES += [("pushes", {"ellipticity_x": size, "ellipticity_y": 0.0}) for size in (0.0, 1e-8, 3e-5)]


@pytest.mark.parametrize(("kind", "changed"), CASES)
def test_what_the_mechanics_made_leaves_no_residual_and_has_true_derivatives(
    kind: str, changed: dict
) -> None:
    make, shape, largest = KINDS[kind]
    block, given = make(), WORN | changed
    checked = SOME_WORN if kind == "worn cycles" else block.parameters
    values = {name: given[name.partition("[")[0]] for name in block.parameters}
    residual, jacobian = block.residuals(values)
    assert np.abs(residual).max() < largest or changed
    assert jacobian.shape == shape
    for name in checked:
        assert_slope(block, values, jacobian, name, STEPS.get(name.partition("[")[0], 3e-3))


@pytest.mark.parametrize("kind", ["pushes", "drags"])
def test_the_floors_heights_have_true_derivatives_and_are_told_from_the_target(kind: str) -> None:
    make = {"pushes": push_end_block, "drags": drag_turn_block}[kind]
    strokes = {"pushes": made_pushes, "drags": made_drags}[kind](6)
    block = make(strokes, RECT1, (0.002, 0.001))
    heights = np.random.default_rng(5).normal(0.0, 1.0, len(FIELD_NAMES))
    values = WORN | dict(zip(FIELD_NAMES, heights.tolist(), strict=True))
    jacobian = block.residuals(values)[1]
    for name in ("floor_h30", "floor_h12", "floor_h22", "floor_h04"):
        assert_slope(block, values, jacobian, name, 0.3)
    flat = block.residuals(WORN | dict.fromkeys(FIELD_NAMES, 0.0))[0]
    assert flat == pytest.approx(make(strokes, RECT1).residuals(WORN)[0], abs=1e-9)


@pytest.mark.parametrize("kind", [*KINDS][:-1])
def test_a_subset_has_the_rows_of_whole_strokes(kind: str) -> None:
    block = KINDS[kind][0]()
    values = {name: WORN[name.partition("[")[0]] for name in block.parameters}
    keep = np.isin(block.groups, [1, 3])
    some = block.subset(keep)
    part = some.subset(some.groups == 3)
    for rows, found in ((keep, some), (block.groups == 3, part)):
        assert (found.groups == block.groups[rows]).all()
        assert (found.kinds == block.kinds[rows]).all()
        for whole, own in zip(block.residuals(values), found.residuals(values), strict=True):
            assert own == pytest.approx(whole[rows], abs=1e-9)


def test_cycles_on_a_surface_that_wears_turn_as_on_one_of_which_all_is_between() -> None:
    """Not the turns are between those of fresh and worn surface, which differ by degrees: the
    surface is.
    """
    steady = WORN | dict.fromkeys(PACE, 0.0)
    for share in (0.0, 0.3, 0.6, 1.0):
        between = {name: (1.0 - share) * VALUES[name] + share * LATE[name] for name in LATE}
        expected = made_cycles().residuals(VALUES | between)[0]
        assert made_cycles(share).residuals(steady)[0] == pytest.approx(expected, abs=2e-3)


def test_a_surface_wears_where_its_pace_is_fast_and_all_of_it_by_the_end() -> None:
    elapsed = np.linspace(0.0, 1.0, 33)
    share, by_pace = worn_share(list(PACE.values()), elapsed)
    assert share[[0, -1]] == pytest.approx([0.0, 1.0]) and np.all(np.diff(share) > 0.0)
    assert np.diff(share[::4]) / share[4] == pytest.approx(np.exp(0.1 * np.arange(8)))
    assert worn_share(np.full(8, 3.0), elapsed)[0] == pytest.approx(elapsed)
    # All paces faster alike change nothing.
    assert by_pace.sum(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_of_many_cycles_neighbouring_sectors_have_a_noise_of_their_own_and_none_has_few() -> None:
    """Three of four rest at 90 degrees; 30 passes are spread over the circle, 5 lie behind 340."""
    resting = np.full(265, np.radians(90.0))
    passing = np.radians(np.linspace(0.0, 339.0, 30))
    theta = np.concatenate([resting, passing, np.full(5, np.radians(350.0))])
    kinds = cycle_pair_block(MIT, theta, 0.0 * theta, np.arange(theta.size)).kinds
    names, counts = np.unique(kinds, return_counts=True)
    assert counts.min() >= 25 and counts.sum() == theta.size and len(names) == 2
    few = cycle_pair_block(MIT, theta[:150], 0.0 * theta[:150], np.arange(150)).kinds
    assert np.unique(few).tolist() == ["cycle turn (rad)"]


def test_a_shape_is_a_pressure_so_that_a_heavier_plate_has_less_of_it_in_its_own() -> None:
    heavy = replace(RECT1, mass=2.0 * RECT1.mass)
    light, other = (TRUTH.footprint(slider) for slider in (RECT1, heavy))
    assert light.floor.bend == pytest.approx(2.0 * other.floor.bend, rel=1e-12)
    assert light.plate.bend == pytest.approx(2.0 * other.plate.bend, rel=1e-12)
    kilopascal = 1e-3 * RECT1.weight / RECT1.outline.area
    assert light.floor.bend * kilopascal == pytest.approx([2.0, -1.5, 0.4])


def test_a_rod_that_starts_inside_is_drawn_back_and_one_that_misses_moves_nothing() -> None:
    model = surface_model(TRUTH, RECT1)
    inside = MeasuredPush(Pose(), Pose(), (-0.018, 0.0495), (-0.018, -0.0005))
    whole = model.push(Pose(), WorldPush((-0.018, 0.06), -math.pi / 2.0, 0.0605)).end
    missing = MeasuredPush(Pose(), Pose(), (0.2, 0.2), (0.2, 0.3))
    ends, by, stayed = predicted_push_ends(model, [inside, missing])
    assert stayed.tolist() == [False, True]
    assert ends[0, 2] == pytest.approx(whole.theta, abs=1e-4)
    assert not ends[1].any() and by[0].any()
    # It stays turned as it lay.
    assert by[1].tolist() == [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    assert not predicted_push_ends(model, [missing])[0].any()
    # On a floor whose shape varies with the place, too.
    floor = CollectionLoop.mit("plywood-floor").model
    by = predicted_push_ends(floor, [missing], (0.0, 0.0), ("mu_a",), (0.0, 0.0))[1]
    assert by.shape == (1, 3, 1 + 9 + 3) and not by[..., :-1].any()
    deep = replace(inside, tip_start=(0.0, 0.0), tip_end=(0.001, 0.0))
    refused(predicted_push_ends, model, [deep], told="deep inside")


def test_an_object_that_lay_turned_from_what_was_read_is_one_that_was_read_so() -> None:
    pushes = made_pushes(4)
    starts = [replace(push.start, theta=push.start.theta + 0.02) for push in pushes]
    turned = [replace(push, start=start) for push, start in zip(pushes, starts, strict=True)]
    by_hand, plain = push_end_block(pushes, RECT1, None, 1), push_end_block(turned, RECT1)
    off = {row.name: 0.02 * ("turn" in row.name) for row in by_hand.own_parameters}
    rods = dict.fromkeys((row.name for row in TIP_OFFSET), 0.0)
    told, expected = by_hand.residuals(VALUES | off)[0], plain.residuals(VALUES | rods)[0]
    assert told == pytest.approx(expected, abs=1e-12)
    assert np.abs(told - by_hand.residuals(VALUES | dict.fromkeys(off, 0.0))[0]).max() > 0.02


def test_strokes_that_are_taken_to_leave_the_object_where_it_was_are_told() -> None:
    pushes = made_pushes(8)
    missed = [replace(push, tip_start=(1.0, 0.0), tip_end=(1.1, 0.0)) for push in pushes[:2]]
    held = {name: value for name, value in VALUES.items() if name != "pusher_friction"}
    notes = []
    for strokes in (pushes, [*pushes[2:], *missed]):
        block = push_end_block(strokes, RECT1)
        asked = {name: value for name, value in held.items() if name in block.parameters}
        found = identify([block], ["pusher_friction"], asked, starts=1)
        notes.append([note for note in found.notes if "leave" in note])
    (note,) = notes[1]
    assert notes[0] == []
    assert note.startswith("push ends: 2 of 8 are taken to leave the object where it was")


def test_strokes_and_cycles_that_do_not_fit_are_refused() -> None:
    refused(drag_turn_block, [], RECT1, told="no strokes")
    refused(cycle_pair_block, MIT, THETA, THETA[1:], np.arange(12), told="one turn for each")
    refused(made_cycles, 1.5, told="a share of the data, 0 to 1")


def test_measured_drags_turn_less_than_by_even_pressure_and_a_free_ring(measured_data) -> None:
    """Regression slopes measured over predicted are below one; weight towards the rim and a rubbing
    ring help.
    """
    table = read_csv_table(measured_data / "mit_rect1_dragback_v10.csv")
    rows = known_columns(table, DRAG_ENDS)
    for surface, slope, radius in (("plywood", 0.74, 0.0), ("abs", 0.68, 2e-3)):
        block = drag_turn_block(measured_drags(rows[rows["surface"] == surface]), RECT1)
        measured, ideal = block.motions[:, 1], block.residuals(PLAIN)[0]
        predicted = measured + ideal
        assert predicted @ measured / (predicted @ predicted) == pytest.approx(slope, abs=0.02)
        rubbing = block.residuals({**PLAIN, "plate_dome": 6.0, "pin_friction_radius": radius})[0]
        assert np.median(np.abs(rubbing)) < 0.8 * np.median(np.abs(ideal))


def test_the_rod_of_a_collection_is_as_thick_as_it_is_said_to_be() -> None:
    """Of pushes with another rod than MIT's nothing is left over, and with MIT's a millimetre."""
    loop = CollectionLoop.mit("isotropic", pusher=Pusher(0.008, 0.15), accuracy=1e-9)
    pushes = []
    for theta in np.linspace(0.0, 5.0, 4):
        cycle, start = loop.cycle(theta), loop.start_pose(theta)
        end = Pose(*start.to_world(*cycle.push_displacement), theta + cycle.push_turn)
        pushes.append(push_from_contact(loop.slider, 0.008, loop.push, start, end))
    values = SurfaceParameters.from_friction(loop.material.friction, pusher_friction=0.15).values()
    given = {**values, "tip_offset_x": 0.0, "tip_offset_y": 0.0}
    right = push_end_block(pushes, loop.slider, rod_radius=0.008).residuals(given)[0]
    wrong = push_end_block(pushes, loop.slider).residuals(given)[0]
    assert np.abs(right).max() < 1e-5 and np.abs(wrong).max() > 1e-3
