"""What was identified with a surface's friction reaches the loop, in SI units, from a Material and from a file."""

import math
from dataclasses import asdict

import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics import EllipseFriction, FoundWith, Material, PatchFootprint, Slider, load_material

LAW = EllipseFriction(0.3, 0.25)
SQUARE = Slider.mit("rect1").outline


def loop_with(**found):
    return CollectionLoop.mit(Material("found", LAW, found_with=FoundWith(**found)))


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        ({"rim_share": 0.3}, (0.0, 0.3, 0.0)),
        ({"inner_share": 0.1}, (0.1, 0.0, 0.0)),
        ({"corner_share": 0.2}, (0.0, 0.0, 0.2)),
        ({"rim_share": 0.2, "inner_share": 0.1, "corner_share": 0.15}, (0.1, 0.2, 0.15)),
    ],
)
def test_shares_of_the_weight_reach_the_footprint_each_alone_and_together(found, wanted):
    loop = loop_with(**found)
    assert loop.footprint == PatchFootprint(SQUARE, *wanted)
    assert (loop.slider, loop.pusher, loop.reset) == (loop_with().slider, loop_with().pusher, loop_with().reset)


def test_a_material_with_nothing_found_leaves_the_loop_as_it_is():
    assert loop_with().footprint is None
    given = Material("found", LAW, found_with=FoundWith(rim_share=0.1))
    assert CollectionLoop.mit(given, footprint=None).footprint is None


def test_every_number_found_is_read_from_a_file_in_its_unit(tmp_path):
    path = tmp_path / "found.toml"
    path.write_text(
        "[friction]\nmu_a = 0.3\nmu_b = 0.3\n[found_with]\npusher_mu = 0.2\nrim_share = 0.25\nhitch_scale = 1.1\n"
        "hitch_turn_deg = 90\n"
        "pin_friction_mm = 2\ninner_share = 0.1\ncorner_share = 0.05\n"
    )
    found = load_material(path).found_with
    assert asdict(found) == {
        **{"pusher_friction": 0.2, "inner_share": 0.1, "rim_share": 0.25, "corner_share": 0.05, "hitch_scale": 1.1},
        **{"hitch_turn": math.pi / 2.0, "pin_friction_radius": 0.002},
    }
    loop = CollectionLoop.mit(path)
    assert loop.model.pressure == PatchFootprint(SQUARE, 0.1, 0.25, 0.05)
    assert loop.reset.pin_friction_radius == 0.002


def test_numbers_that_carry_nothing_are_refused(tmp_path):
    path = tmp_path / "found.toml"
    path.write_text("[friction]\nmu_a = 0.3\nmu_b = 0.3\n[found_with]\nrim = 0.1\n")
    with pytest.raises(DataFileError, match="rim_share"):
        load_material(path)
    with pytest.raises(InvalidInput, match="together they may be 1"):
        loop_with(rim_share=0.6, corner_share=0.5)
