"""How far settings are from a change of the stable directions, against full cycle maps."""

import numpy as np
import pytest
from refusals import refused

from cyclemap import CollectionLoop, fixed_points
from cyclemap.protocol import loop_from_settings
from cyclemap.sweeps import change_curve, direction_margins

LOOP = CollectionLoop.mit("plywood")


def map_at(key: str, value: float, tolerance: float = 1e-6, loop: CollectionLoop = LOOP):
    return loop_from_settings({key: value}, loop).circle_map(tolerance)


def stable(circle_map) -> int:
    return sum(orbit.stable for orbit in fixed_points(circle_map))


@pytest.fixture(scope="module")
def margins():
    return {one.key: one for one in direction_margins(LOOP, ("hitch_x_mm", "mu_b", "pusher_mu"))}


def test_full_maps_have_the_told_directions_on_both_sides_of_a_change(margins) -> None:
    assert list(margins) == ["mu_b", "hitch_x_mm", "pusher_mu"]  # nearest first
    for key, unit in (("hitch_x_mm", 1e-3), ("mu_b", 1.0)):
        one = margins[key]
        assert one.directions == 1 and one.share == abs(one.nearest.value - one.value) / one.span
        for change in (one.below, one.above):
            assert change.kind == "saddle-node" and change.value.error_bound < 1e-7 * one.span
            step = 1e-3 * one.span * np.sign(change.value - one.value)
            assert stable(map_at(key, (change.value - step) / unit)) == one.directions
            assert stable(map_at(key, (change.value + step) / unit)) == change.directions
    rod = margins["pusher_mu"]
    assert (rod.nearest, rod.low, rod.high) == (None, 0.0, 0.8)


def test_full_maps_touch_whole_turns_where_the_saddle_node_is_told(margins) -> None:
    """The least turn of whole maps, good to 1e-6 rad, moves by some 0.05 rad a millimetre."""
    change = margins["hitch_x_mm"].above
    at, near = 1000 * change.value, change.theta + np.linspace(-0.3, 0.3, 4001)
    before, after = (
        float(map_at("hitch_x_mm", at + off).turn(near).min()) for off in (-5e-5, 5e-5)
    )
    assert before * after < 0.0


TWO_CHANGES = {
    "mu_a": 0.329138,
    "m0": 0.044865,
    "n0": -0.018817,
    "phi_deg": 25.94873,
    "push_mm": 119.265703,
    "fraction": 0.696622,
    "angle_deg": -2.724026,
    "hitch_x_mm": 1.983748,
    "hitch_y_mm": -18.897635,
    "shape": "ellip1",
}
FOLDED = {
    "mu_a": 0.402,
    "m0": -0.0285,
    "n0": 0.0139,
    "phi_deg": 50.74,
    "push_mm": 172.7,
    "fraction": 0.778,
    "angle_deg": -10.48,
    "hitch_x_mm": -0.71,
    "hitch_y_mm": 15.79,
    "shape": "hex",
}


@pytest.mark.parametrize(
    ("settings", "mu_b", "side", "kind"),
    [
        (TWO_CHANGES, 0.479033, "below", "saddle-node"),
        (FOLDED, 0.5435, "above", "period doubling"),
    ],
)
def test_the_nearest_change_is_told_where_another_is_near_or_the_map_folds(
    settings, mu_b: float, side: str, kind: str
) -> None:
    """Two saddle-nodes 0.001 of the friction apart, and a slope that nears -1 slowly."""
    loop = loop_from_settings({**settings, "mu_b": mu_b})
    (margin,) = direction_margins(loop, ("mu_b",))
    change = getattr(margin, side)
    assert (margin.directions, change.directions, change.kind) == (2, 1, kind)
    assert change.value.error_bound < 1e-6
    step = 1e-4 * np.sign(change.value - margin.value)
    assert stable(map_at("mu_b", change.value - step, loop=loop)) == 2
    assert stable(map_at("mu_b", change.value + step, loop=loop)) == 1


def test_a_value_beyond_its_usual_range_has_no_change_on_the_far_side() -> None:
    """Plywood's friction, as many times as takes its first axis beyond 1.2: no direction moves."""
    many = 1.15 / 0.2346
    law = LOOP.material.friction
    offset = {"m0": many * law.m0, "n0": many * law.n0}
    loop = loop_from_settings({"mu_a": 1.5, "mu_b": 1.15, **offset})
    (scaled,) = direction_margins(loop, ("mu_a",))
    (plywood,) = direction_margins(LOOP, ("mu_a",))
    assert scaled.above is None and scaled.high == scaled.value == 1.5
    assert scaled.below.value == pytest.approx(many * plywood.above.value, abs=1e-6)
    assert (scaled.directions, scaled.below.directions) == (2, 1)


@pytest.mark.slow
def test_a_curve_in_the_plane_of_the_ring_is_where_full_maps_touch_whole_turns(margins) -> None:
    """In a corner of the plane, since every map of it is run cycle by cycle."""
    change = margins["hitch_x_mm"].above
    curve = change_curve(LOOP, "hitch_x_mm", change, "hitch_y_mm", (-6.30, -6.271), (10.606, 10.64))
    assert curve.kind == "saddle-node" and curve.residual < 1e-8
    away = np.hypot(curve.first - 1000 * change.value, curve.second - 10.6066)
    assert np.min(away) < 1e-4
    for index in (0, -1):
        ring = {"hitch_x_mm": float(curve.first[index]), "hitch_y_mm": float(curve.second[index])}
        turned = loop_from_settings(ring, LOOP).circle_map()
        turn = turned.turn(curve.points[index, 0] + np.linspace(-0.2, 0.2, 2001))
        assert abs(turn.min()) < 2e-6  # twice what the map is off by


def test_what_has_no_range_or_no_value_is_refused() -> None:
    for key, told in (
        ("mass_kg", "mass_kg has no usual range"),
        ("floor_bow", "floor_bow has no usual range or no value here"),
        ("hitch", "hitch"),
    ):
        refused(direction_margins, LOOP, (key,), told=told)
    refused(direction_margins, "plywood", told="CollectionLoop")
