"""What the names of MIT files say."""

import math
from pathlib import Path

import pytest

from cyclemap.evidence.pushes.mit_names import PushFacts, ScanFacts, push_facts, scan_facts


def test_the_name_of_a_repeated_push_gives_every_fact_in_si_units() -> None:
    name = "normal/motion_surface=plywood_shape=rect1_a=100_v=20_i=2.000_s=0.700_t=-0.349_rep=0123.h5"
    expected = PushFacts("plywood", "rect1", 0.1, 0.02, 2.0, 0.7, -0.349, 123.0)
    assert push_facts(name) == push_facts(Path(name)) == expected


@pytest.mark.parametrize("suffix", ["", ".h5", ".hdf5", ".json", ".H5"])
def test_the_suffix_does_not_matter_and_a_decimal_is_none(suffix) -> None:
    facts = push_facts("motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=1.396" + suffix)
    assert facts is not None and facts.angle == 1.396
    assert math.isnan(facts.repetition)


def test_names_of_surfaces_may_hold_underscores_and_hyphens() -> None:
    facts = push_facts("motion_surface=my_wet-wood_2_shape=long_thing_a=0_v=20_i=0.000_s=0.700_t=0.000.h5")
    assert facts is not None and (facts.surface, facts.object) == ("my_wet-wood_2", "long_thing")


def test_an_accelerated_push_has_no_one_speed() -> None:
    facts = push_facts("motion_surface=abs_shape=rect1_a=2500_v=-1_i=0.000_s=0.700_t=0.000.h5")
    assert facts is not None and facts.acceleration == 2.5 and math.isnan(facts.speed)


def test_a_scan_moves_half_a_turn_from_the_direction_in_its_name() -> None:
    directions = {}
    for degrees in range(0, 360, 5):
        facts = scan_facts(f"record_surface=pu_shape=rect1_a=0_v=20_deg={degrees}_rep=001.h5")
        assert facts is not None
        directions[degrees] = round(math.degrees(facts.direction), 9)
    assert len(directions) == 72
    assert directions == {degrees: (degrees + 180) % 360 for degrees in range(0, 360, 5)}


@pytest.mark.parametrize(
    "name",
    [
        "summary.json",
        "motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700.h5",
        "motion_surface=abs_shape=hex_a=0_v=fast_i=4.000_s=0.700_t=0.000.h5",
        "motion_surface=abs_shape=hex_a=0_v=50_i=4.500_s=0.700_t=0.000.h5",
        "motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=nan.h5",
        "motion_surface=_shape=hex_a=0_v=50_i=4.000_s=0.700_t=0.000.h5",
        "copy of motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=0.000.h5",
        "motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=0.000 (1).h5",
        "record_surface=pu_shape=rect1_a=0_v=20_deg=0_rotdeg=80_radius=0.050_rep=000.h5",
        "",
    ],
)
def test_any_other_name_says_nothing(name) -> None:
    assert push_facts(name) is None and scan_facts(name) is None


def test_facts_that_no_name_gives_are_unknown() -> None:
    for facts in (PushFacts(), ScanFacts()):
        assert facts.surface is None and math.isnan(facts.speed) and math.isnan(facts.repetition)
