"""Settings in degrees and millimetres: each reaches its place in the loop, and bad ones are told by
name.
"""

import math
import warnings

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput
from cyclemap.mechanics import (
    Ellipse,
    PatchFootprint,
    PressedFootprint,
    Slider,
    SurfaceShape,
    corner_footprint,
    grid_footprint,
    resting_pressure,
)
from cyclemap.protocol import loop_from_settings
from cyclemap.protocol.chosen_loop import chosen_collection
from cyclemap.protocol.settings import NOISE_KEY, SETTINGS, SHAPES

MIT = CollectionLoop.mit()

# key: value given, how it is read back from the loop, value in SI units.
PLACES = {
    "mu_a": (0.3, lambda loop: loop.material.friction.mu_a, 0.3),
    "mu_b": (0.3, lambda loop: loop.material.friction.mu_b, 0.3),
    "m0": (-0.01, lambda loop: loop.material.friction.m0, -0.01),
    "n0": (0.01, lambda loop: loop.material.friction.n0, 0.01),
    "phi_deg": (90, lambda loop: loop.material.friction.phi, math.pi / 2),
    "pusher_mu": (0.4, lambda loop: loop.pusher.friction, 0.4),
    "pusher_radius_mm": (3, lambda loop: loop.pusher.radius, 0.003),
    "side": (2, lambda loop: loop.push.side, 2),
    "fraction": (0.25, lambda loop: loop.push.fraction, 0.25),
    "angle_deg": (-30, lambda loop: loop.push.angle, -math.pi / 6),
    "push_mm": (80, lambda loop: loop.push.distance, 0.08),
    "hitch_x_mm": (5, lambda loop: loop.slider.hitch[0], 0.005),
    "hitch_y_mm": (-6, lambda loop: loop.slider.hitch[1], -0.006),
    "centre_x_mm": (2, lambda loop: loop.slider.centre_of_mass[0], 0.002),
    "centre_y_mm": (-3, lambda loop: loop.slider.centre_of_mass[1], -0.003),
    "pin_friction_mm": (1.5, lambda loop: loop.reset.pin_friction_radius, 0.0015),
    "rim_share": (0.3, lambda loop: loop.model.pressure.rim_share, 0.3),
    "inner_share": (0.1, lambda loop: loop.model.pressure.inner_share, 0.1),
    "corner_share": (0.2, lambda loop: loop.model.pressure.corner_share, 0.2),
    "mass_kg": (2.5, lambda loop: loop.slider.mass, 2.5),
}


def test_every_setting_reaches_its_place_in_si_units_and_no_other():
    others = {"shape", "object_name", "vertices_mm", "semi_x_mm", "semi_y_mm"}
    others |= {"way_points_mm", "footprint", *SHAPES, NOISE_KEY}
    assert set(PLACES) | others == set(SETTINGS)
    for key, (value, read, wanted) in PLACES.items():
        loop = loop_from_settings({key: value})
        assert read(loop) == pytest.approx(wanted, rel=1e-15)
        for other, (_, read_other, _) in PLACES.items():
            assert other == key or read_other(loop) == read_other(MIT)


def test_shapes_of_floor_and_plate_reach_the_footprint_in_mean_pressures():
    both = {"floor_dome": 2, "floor_bow": 3, "floor_bow_deg": 90}
    both |= {"plate_dome": -1, "plate_warp": 0.5, "plate_warp_deg": 45}
    plate, floor = SurfaceShape(-1.0, 0.5, math.pi / 4), SurfaceShape(2.0, 3.0, math.pi / 2)
    pressed = PressedFootprint(MIT.slider.outline, plate, floor, (0.0, 0.0))
    assert loop_from_settings(both).footprint == pressed
    flat = dict.fromkeys(both, 0)
    assert loop_from_settings(flat, loop_from_settings(both)).footprint is None


def test_a_heavier_object_has_less_of_a_shape_and_rests_more_evenly():
    light = loop_from_settings({"floor_dome": 2, "floor_bow": 2})
    heavy = loop_from_settings({"mass_kg": 3 * light.slider.mass}, light)
    assert heavy.footprint.floor.dome == pytest.approx(2 / 3, rel=1e-15)
    places = [(0.045, 0.045), (0.0, 0.0)]
    more, less = (np.ptp(resting_pressure(loop.footprint, 0.0, places)) for loop in (light, heavy))
    assert 0.0 < less < more


def test_outlines_come_by_name_by_vertices_or_by_semi_axes_and_keep_the_ring():
    named = loop_from_settings({"shape": "tri1"})
    assert named.slider.outline == Slider.mit("tri1").outline
    own = loop_from_settings({"vertices_mm": [[-40, -10], [60, -10], [-40, 40]]})
    assert own.slider.outline.vertices == ((-0.04, -0.01), (0.06, -0.01), (-0.04, 0.04))
    ellipse = loop_from_settings({"semi_x_mm": 50, "semi_y_mm": 70})
    assert ellipse.slider.outline == Ellipse(0.05, 0.07)
    for loop in (named, own, ellipse):
        assert loop.slider.hitch == MIT.slider.hitch
        assert loop.slider.centre_of_mass == loop.slider.outline.centroid
        assert loop.cycle(0.3).ended in ("distance", "left")
    moved = loop_from_settings({"shape": "hex", "hitch_x_mm": 1, "hitch_y_mm": 2})
    assert moved.slider.hitch == pytest.approx((0.001, 0.002))


def test_footprints_are_those_of_the_outline_that_is_set():
    square = loop_from_settings({"footprint": "grid:8"})
    assert square.footprint == grid_footprint(Slider.mit("rect1").outline, 8)
    both = loop_from_settings({"shape": "hex", "footprint": "corners"})
    assert both.footprint == corner_footprint(Slider.mit("hex").outline)
    assert loop_from_settings({"semi_x_mm": 40, "semi_y_mm": 40}, square).footprint is None


def test_the_exact_footprint_leans_as_the_centre_of_mass_asks_and_keeps_its_rim_share():
    even = loop_from_settings({"footprint": "exact"}, loop_from_settings({"footprint": "grid:8"}))
    assert even.model.pressure == PatchFootprint(Slider.mit("rect1").outline)
    both = loop_from_settings({"rim_share": 0.3, "centre_x_mm": 4})
    assert both.model.pressure.rim_share == 0.3
    assert both.model.pressure.centre == pytest.approx((0.004, 0.0), abs=1e-15)
    more = loop_from_settings({"rim_share": 0.2, "pin_friction_mm": 1}, both)
    square = Slider.mit("rect1").outline
    assert more.model.pressure == PatchFootprint(square, rim_share=0.2, centre=(0.004, 0.0))
    moved = loop_from_settings({"way_points_mm": [[10, 20]]}, more)
    assert moved.reset.pin_friction_radius == 0.001
    assert loop_from_settings({"footprint": "exact"}, more).model.pressure.rim_share == 0.0


def test_a_centre_of_mass_that_support_points_do_not_have_is_told():
    """Strokes go by the points alone: one that is set beside them would count for nothing."""
    with pytest.warns(DoubtfulInput, match=r"about \(-?0.0, -?0.0\) mm, .* \(20.0, 0.0\) mm"):
        loop = loop_from_settings({"footprint": "grid:8", "centre_x_mm": 20})
    even = loop_from_settings({"footprint": "grid:8"})
    assert loop.cycle(0.3).push_turn == even.cycle(0.3).push_turn
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        loop_from_settings({"footprint": "grid:8", "centre_x_mm": 0.5})
        loop_from_settings({"centre_x_mm": 20})


def test_settings_build_on_a_given_loop_and_replace_nothing_unasked():
    base = loop_from_settings({"pusher_mu": 0.4, "way_points_mm": [[10, 20]]})
    loop = loop_from_settings({"push_mm": 80}, base)
    assert loop.pusher.friction == 0.4
    assert loop.reset.way_points == ((0.01, 0.02),)
    assert loop_from_settings({}) == MIT


def test_a_changed_material_says_so_and_an_unchanged_one_does_not():
    assert loop_from_settings({"mu_a": 0.3}).material.name == "plywood (changed)"
    assert loop_from_settings({"mu_a": 0.2545}).material.name == "plywood"


def test_a_cycle_scatters_as_measured_on_a_friction_that_is_set_to_another():
    """As under another ring: else a sweep would jump to the default where it meets the material's."""
    measured = CollectionLoop.mit("plywood-measured")
    changed = loop_from_settings({"mu_a": 0.29}, measured)
    assert measured.material.noise is not None
    assert changed.material.noise == measured.material.noise


def test_what_was_found_with_a_friction_is_told_to_be_left_out_where_that_is_set_to_another():
    with pytest.warns(DoubtfulInput, match="plywood-measured is set to another.*out, its wear$"):
        chosen_collection("plywood-measured", settings=["mu_a=0.29"])
    with pytest.warns(DoubtfulInput, match="left out, the samples of what is believed of it$"):
        chosen_collection("unknown", settings=["mu_a=0.29"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        chosen_collection("plywood-measured", settings=["mu_a=0.28513", "push_mm=140"])


BAD = [
    ({"mu_c": 1}, "did you mean 'mu_"),
    ({"mu_a": "rough"}, "rough"),
    ({"mu_a": -0.1}, "-0.1"),
    ({"m0": 0.3}, "gain energy"),
    ({"pusher_radius_mm": -1}, "radius"),
    ({"side": 1.5}, "side"),
    ({"fraction": 1.01}, "1.01"),
    ({"angle_deg": 90}, "points away"),
    ({"push_mm": 0}, "distance"),
    ({"shape": "rect9"}, "did you mean 'rect"),
    ({"shape": "hex", "semi_x_mm": 3, "semi_y_mm": 3}, "both name the outline"),
    ({"semi_x_mm": 3}, "both semi_x_mm and semi_y_mm"),
    ({"vertices_mm": [[0, 0], [1, 1], [1, 0], [0, 1]]}, "cross"),
    ({"vertices_mm": "square"}, "vertices_mm"),
    ({"way_points_mm": [1, 2]}, "way_points_mm"),
    ({"centre_x_mm": 60}, "outside the outline"),
    ({"footprint": "exact:8"}, "none of"),
    ({"footprint": "none.csv"}, "none.csv"),
    ({"mass_kg": 0}, "mass"),
    ({"rim_share": 1.5}, "1.5"),
    ({"rim_share": 0.5, "inner_share": 0.6}, "add to 1.1"),
    ({"corner_share": 0.2, "footprint": "grid:8"}, "corner_share belongs to the exact footprint"),
    ({"corner_share": 0.2, "shape": "ellip1"}, "no corners"),
    ({"pin_friction_mm": -1}, "pin_friction_mm=-1"),
    ({"floor_dome": 1, "rim_share": 0.2}, "rim_share=0.2 beside shapes"),
    ({"floor_dome": 1, "footprint": "grid:8"}, "floor_dome belongs to the exact footprint"),
    ({"floor_dome": 1001}, "rigid"),
    ({"plate_warp": math.nan}, "plate_warp"),
    ({3: 4}, "unknown setting '3'"),
]


def test_bad_settings_are_refused_by_name_in_one_line():
    """A side that the outline has not before anything moves."""
    for settings, told in BAD:
        refused(loop_from_settings, settings, told=told)
    for settings in ({"side": 4}, {"shape": "ellip1", "side": 1}):
        refused(loop_from_settings(settings).cycle, 0.0, told="does not exist", kind=CycleMapError)
