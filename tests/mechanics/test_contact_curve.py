"""The curve of a rod's centre around concave outlines: exact, complete, closed; touches;
near-degenerate input.
"""

import math
from contextlib import suppress

import numpy as np
import pytest
from random_cases import distances

from cyclemap.errors import InvalidInput
from cyclemap.evidence.comparison.replay_table import dataset_sliders
from cyclemap.mechanics import Polygon
from cyclemap.mechanics.contact_curve import (
    CornerPiece,
    SidePiece,
    contact_curve,
    first_touches,
    side_coordinate,
)

NOTCHED = Polygon([(0, 0), (4, 0), (4, 2), (2, 1), (0, 2)])
SLOT = Polygon([(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)])


def star(rng, corners):
    angle, reach = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners)), rng.uniform(0.2, 1.0, corners)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=-1)


def comb(widths, depths):
    """A bar with slots from above: widths of teeth and slots in turn,
    heights of the slots' floors."""
    x = np.concatenate([[0.0], np.cumsum(widths)])
    points = [(0.0, -0.3), (x[-1], -0.3)]
    for i in range(len(widths) - 1, -1, -1):
        height = 0.5 if i % 2 == 0 else depths[i // 2]
        points += [(x[i + 1], height), (x[i], height)]
    return np.array(points)


def rooms(rng, count):
    """A bar with rooms in it, each open upwards by a mouth,
    all corners a little off their places."""
    points = [(0.0, 0.0), (float(count), 0.0), (float(count), 1.0)]
    for room in range(count - 1, -1, -1):
        mouth, height = rng.uniform(0.05, 0.3), rng.uniform(0.6, 0.9)
        right = [(0.5 + mouth, 1.0), (0.5 + mouth, height), (0.85, height), (0.85, 0.15)]
        points += [(room + x, y) for x, y in right] + [(room + 1.0 - x, y) for x, y in right[::-1]]
    points = np.array([*points, (0.0, 1.0)])
    return points + rng.uniform(-0.03, 0.03, points.shape)


def lattice(rng, corners):
    """Integer vertices around a centre: many coincidences when the radius is a simple number."""
    points = rng.integers(-4, 5, (corners, 2)).astype(float)
    from_centre = points - points.mean(axis=0) - 1e-3 * rng.normal(size=2)
    return points[np.argsort(np.arctan2(from_centre[:, 1], from_centre[:, 0]))]


def turned(rng, points):
    angle = rng.uniform(0.0, 2.0 * np.pi)
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def generic(rng):
    """Outlines with a rod between a thousandth of their size and three times of it."""
    kind, radius = rng.integers(3), 10.0 ** rng.uniform(-3.0, 0.5)
    if kind == 0:
        points = star(rng, rng.integers(4, 14))
    elif kind == 1:
        points, radius = rooms(rng, rng.integers(1, 4)), rng.uniform(0.02, 0.35)
    else:
        teeth = rng.integers(1, 5)
        points = comb(rng.uniform(0.05, 0.3, 2 * teeth + 1), rng.uniform(-0.1, 0.45, teeth))
    return turned(rng, points), radius


def degenerate(rng):
    """Rods exactly, or to a few roundings or nudges, as wide as notches; coinciding corners of the
    offset curve.
    """
    if rng.random() < 0.5:
        points = lattice(rng, rng.integers(4, 12))
        radius = rng.choice([0.25, 0.5, 1.0, 1.5, 2.0, *np.sqrt([0.5, 1.25, 2.0])])
    else:
        teeth = rng.integers(1, 5)
        points = comb(0.1 * rng.integers(1, 4, 2 * teeth + 1), 0.1 * rng.integers(0, 4, teeth))
        radius = rng.choice([0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5])
    radius *= 1.0 + rng.choice(
        [0.0, 0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-13, -1e-13, 1e-12, -1e-12, 1e-10]
    )
    return (turned(rng, points) if rng.random() < 0.5 else points), radius


def cases(draw, seed, count):
    """As many outlines that are polygons, with the rod's radius and the generator."""
    rng, made = np.random.default_rng(seed), 0
    while made < count:
        points, radius = draw(rng)
        with suppress(InvalidInput):
            outline = Polygon(points)
            made += 1
            yield outline, float(radius), rng


def centres(curve, index, count=33):
    piece = curve.pieces[index]
    at = np.linspace(piece.low, piece.high, count)
    return np.array([piece.contact(float(s), curve.radius).rod_centre(curve.radius) for s in at])


def length(curve):
    return math.fsum(
        (p.high - p.low) * (curve.radius if isinstance(p, CornerPiece) else 1.0)
        for p in curve.pieces
    )


def loops(curve):
    left, found = set(range(len(curve.pieces))), []
    while left:
        loop, index = [], min(left)
        while index in left:
            left.remove(index)
            loop.append(index)
            index = curve.after[index]
        assert index == loop[0]
        found.append(loop)
    return found


def check_points_and_junctions(outline, curve, rounding):
    """Every point has the distance of the radius, from outside; ends meet; smooth normals go on,
    wedges turn right.
    """
    scale = curve.radius + np.abs(outline.array).max()
    for index, piece in enumerate(curve.pieces):
        assert piece.low < piece.high
        places = centres(curve, index)
        assert np.abs(distances(outline, places) - curve.radius).max() < rounding * scale
        assert not outline.contains(places[1:-1]).any()
        ends, begins = curve.contacts_at_end(index)
        assert curve.before[curve.after[index]] == index
        assert (
            math.dist(ends.rod_centre(curve.radius), begins.rod_centre(curve.radius))
            < rounding * scale
        )
        turn = math.remainder(begins.normal - ends.normal, 2.0 * math.pi)
        if curve.junctions[index] == "smooth":
            assert abs(turn) < 1e-9
        else:
            assert curve.junctions[index] == "wedge"
            assert turn < 1e-7 or math.pi - abs(turn) < 1e-7
    assert sum(map(len, loops(curve))) == len(curve.pieces)


def raw_samples(outline, radius, count):
    """Centres of rods along every side and around every convex corner, (k, 2), and the length each
    stands for.
    """
    a = outline.array
    places, weights = [], []
    edge = np.roll(a, -1, axis=0) - a
    size = np.hypot(*edge.T)
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / size[:, None]
    share = (np.arange(count) + 0.5) / count
    for i in range(len(a)):
        j = (i + 1) % len(a)
        places.append(a[i] + share[:, None] * edge[i] + radius * normal[i])
        weights.append(np.full(count, size[i] / count))
        cross, dot = (
            normal[i, 0] * normal[j, 1] - normal[i, 1] * normal[j, 0],
            normal[i] @ normal[j],
        )
        if cross > 0.0:
            turn = math.atan2(cross, dot)
            angle = math.atan2(normal[i, 1], normal[i, 0]) + turn * share
            places.append(a[j] + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
            weights.append(np.full(count, radius * turn / count))
    return np.concatenate(places), np.concatenate(weights)


@pytest.mark.slow
def test_curves_are_exact_closed_and_complete():
    """Against samples of all untrimmed pieces:
    those that no side overlaps make up the same length."""
    several_loops = 0
    for outline, radius, _ in cases(generic, seed=1, count=60):
        curve = contact_curve(outline, radius)
        check_points_and_junctions(outline, curve, 1e-13)
        several_loops += len(loops(curve)) > 1
        places, weights = raw_samples(outline, radius, 100)
        free = weights[distances(outline, places) >= radius * (1.0 - 1e-12)].sum()
        # Each end that lies between samples costs a sample at most.
        assert abs(free - length(curve)) < weights.max() * (2 + len(curve.pieces))
    assert several_loops > 4


@pytest.mark.slow
def test_coincidences_within_rounding_leave_neither_gaps_nor_crashes():
    for outline, radius, _ in cases(degenerate, seed=3, count=250):
        check_points_and_junctions(outline, contact_curve(outline, radius), 2e-12)


def test_a_rod_as_wide_as_a_slot_is_in_it_or_not():
    for radius, floor in (
        (0.49, True),
        (0.5 - 1e-9, True),
        (0.5, None),
        (0.5 + 1e-9, False),
        (0.6, False),
    ):
        curve = contact_curve(SLOT, radius)
        check_points_and_junctions(SLOT, curve, 1e-12)
        sides = {piece.side for piece in curve.pieces if isinstance(piece, SidePiece)}
        assert {3, 5} <= sides or not {3, 4, 5} & sides
        assert floor is None or (4 in sides) == floor


def test_a_point_touches_every_side_and_two_at_a_concave_vertex():
    curve = contact_curve(NOTCHED, 0.0)
    assert [piece.side for piece in curve.pieces] == list(range(5))
    assert curve.junctions == ("corner", "corner", "wedge", "corner", "corner")
    ends, begins = curve.contacts_at_end(2)
    assert (
        ends[:2] == pytest.approx((2.0, 1.0))
        and begins[:2] == (2.0, 1.0)
        and ends.normal > begins.normal
    )


def test_straight_continuations_and_slight_turns():
    """A vertex on a straight side joins smoothly; slightly concave ones end in flat wedges,
    slightly convex in arcs.
    """
    for bend, junctions in (
        (0.0, {"smooth"}),
        (1e-6, {"smooth"}),
        (-1e-6, {"smooth", "wedge"}),
        (-1e-8, None),
    ):
        for radius in (0.01, 0.5, 30.0):
            outline = Polygon([(0, 0), (2, 0), (2, 1), (1, 1 + bend), (0, 1)])
            curve = contact_curve(outline, radius)
            check_points_and_junctions(outline, curve, 1e-13)
            assert junctions is None or set(curve.junctions) == junctions


@pytest.mark.slow
def test_sizes_do_not_matter():
    """From rods of a billionth of the outline to walls a million times as wide, and a thousand
    sizes off the origin.
    """
    for outline, _, _ in cases(generic, seed=4, count=12):
        for radius in (1e-9, 1e-6, 1e3, 1e6):
            check_points_and_junctions(outline, contact_curve(outline, radius), 1e-13)
        moved = Polygon(outline.array + 1e3)
        check_points_and_junctions(moved, contact_curve(moved, 0.1), 1e-13)
        flat, thin = contact_curve(outline, 0.1), contact_curve(outline.scaled(1e-3), 1e-4)
        assert thin.after == flat.after and thin.junctions == flat.junctions
        assert length(thin) == pytest.approx(1e-3 * length(flat), rel=1e-12)


def first_touch(pieces, radius, start, direction):
    """Travel, piece and coordinate of one rod's; None where there is no touch."""
    (travel,), (piece,), (coordinate,) = first_touches(
        pieces, radius, np.array([start]), np.array([direction])
    )
    return None if math.isnan(travel) else (max(travel, 0.0), piece, coordinate)


def marched(outline, radius, start, toward):
    """Travel of a rod that goes as far as nothing can be in its way, again and again; None where it
    gets away.
    """
    travel = 0.0
    for _ in range(100_000):
        gap = float(distances(outline, (start + travel * toward)[None])[0]) - radius
        if gap < 1e-10:
            return travel
        travel += gap
        if travel > 10.0 + 4.0 * radius:
            return None
    return travel


@pytest.mark.slow
def test_first_touches_are_where_a_marching_rod_stops():
    touched = 0
    for outline, radius, rng in cases(generic, seed=5, count=25):
        curve = contact_curve(outline, radius)
        for _ in range(8):
            direction = rng.uniform(0.0, 2.0 * np.pi)
            toward = np.array([math.cos(direction), math.sin(direction)])
            start = rng.uniform(-1.2, 1.2, 2) - rng.choice([0.0, 3.0 + radius]) * toward
            if overlaps(outline, radius * (1.0 + 1e-6) + 1e-9, start):
                continue
            expected = marched(outline, radius, start, toward)
            found = first_touch(curve.pieces, radius, start, direction)
            if expected is None or found is None:
                assert expected is None and found is None
                continue
            # Where the rod grazes, the march stops a little before it touches.
            contact = curve.pieces[found[1]].contact(found[2], radius)
            assert np.allclose(contact.rod_centre(radius), start + found[0] * toward, atol=1e-9)
            assert expected <= found[0] + 1e-9 and found[0] - expected < 1e-4
            touched += 1
    assert touched > 60


@pytest.mark.slow
def test_a_rod_aimed_into_a_wedge_touches_at_the_end_of_one_of_its_pieces():
    wedged = 0
    for outline, radius, rng in cases(generic, seed=6, count=60):
        curve = contact_curve(outline, radius)
        for index in (i for i, junction in enumerate(curve.junctions) if junction == "wedge"):
            ends, begins = curve.contacts_at_end(index)
            between = 0.5 * (
                ends.normal
                + begins.normal
                + math.remainder(ends.normal - begins.normal, 2 * math.pi)
            )
            direction = between + math.pi + rng.uniform(-0.01, 0.01)
            place = np.array(ends.rod_centre(radius))
            toward = np.array([math.cos(direction), math.sin(direction)])
            start = place - 1e-3 * radius * toward
            if distances(outline, start[None])[0] < radius:
                continue
            travel, piece, coordinate = first_touch(curve.pieces, radius, start, direction)
            assert travel == pytest.approx(1e-3 * radius, abs=1e-9)
            assert (piece, coordinate) in (
                (index, pytest.approx(curve.pieces[index].high, abs=1e-6)),
                (curve.after[index], pytest.approx(curve.pieces[curve.after[index]].low, abs=1e-6)),
            )
            wedged += 1
    assert wedged > 40


def test_a_side_is_touched_where_its_pieces_are():
    curve = contact_curve(SLOT, 0.2)
    index, coordinate, _ = side_coordinate(SLOT, curve.pieces, 4, 0.5)
    assert curve.pieces[index].side == 4 and coordinate == 0.5
    for fraction, radius in ((0.1, 0.2), (0.5, 0.7)):
        with pytest.raises(InvalidInput, match="concave corner"):
            side_coordinate(SLOT, contact_curve(SLOT, radius).pieces, 4, fraction)
    # A beak hangs over a long floor: where the rod is too thick to pass, the floor keeps a piece on
    # either hand.
    hook = [(9, 0), (9, 1), (1, 1), (1, 3), (4, 3), (4, 1.3), (4.2, 1.3), (4.2, 3.2)]
    hooked = Polygon([(0, 0), *hook, (0, 3.2)])
    floor = [
        (p.low, p.high)
        for p in contact_curve(hooked, 0.2).pieces
        if isinstance(p, SidePiece) and p.side == 2
    ]
    assert np.allclose(floor, [(0.0, 4.8 - math.sqrt(0.03)), (5.0 + math.sqrt(0.03), 7.8)])
    index, coordinate, _ = side_coordinate(hooked, contact_curve(hooked, 0.2).pieces, 2, 0.75)
    assert contact_curve(hooked, 0.2).pieces[index].high == pytest.approx(7.8) and coordinate == 6.0


def overlaps(outline, radius, place):
    return outline.contains(place) or distances(outline, np.array([place]))[0] < radius - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tri3", "ellip3", "butter"])
def test_a_touch_lies_behind_a_rod_that_went_on_inside(name):
    """A rod that starts inside touched where one that came the same way from outside does."""
    outline = dataset_sliders()[name].outline
    radius, rng = 0.00475, np.random.default_rng(5)
    pieces = contact_curve(outline, radius).pieces
    starts = rng.uniform(-2.0, 2.0, (60, 2)) * outline.extent
    starts = starts[[not overlaps(outline, radius, place) for place in starts]]
    directions = np.arctan2(*(-starts).T[::-1]) + rng.normal(0.0, 0.4, len(starts))
    travel, piece, coordinate = first_touches(pieces, radius, starts, directions)
    behind = starts + (travel + 1e-3)[:, None] * np.stack(
        [np.cos(directions), np.sin(directions)], axis=-1
    )
    inside = np.array(
        [bool(np.isfinite(place[0])) and overlaps(outline, radius, place) for place in behind]
    )
    assert inside.sum() > 12
    back, same, there = first_touches(pieces, radius, behind[inside], directions[inside])
    assert back == pytest.approx(-1e-3, abs=1e-10) and np.all(same == piece[inside])
    assert there == pytest.approx(coordinate[inside], abs=1e-9)


@pytest.mark.parametrize("name", ["hex", "ellip3"])
def test_a_rod_that_touches_meets_the_object_at_once_or_has_left_it(name):
    """Half a nanometre off or in, as rounding leaves it: inwards the touch is here, outwards there
    is none.
    """
    outline, radius = dataset_sliders()[name].outline, 0.00475
    pieces = contact_curve(outline, radius).pieces
    start, direction = np.array([2.0 * outline.extent, 0.003]), math.pi
    touch = first_touch(pieces, radius, start, direction)
    assert touch is not None
    for off in (-5e-10, 0.0, 5e-10):
        place = start - np.array([touch[0] - off, 0.0])
        met = first_touch(pieces, radius, place, direction)
        assert met is not None and met[0] == pytest.approx(0.0, abs=1e-9)
        assert first_touch(pieces, radius, place, 0.0) is None
