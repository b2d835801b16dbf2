"""What the names of MIT files say."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from refusals import refused

from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.recordings import (
    PushFacts,
    ScanFacts,
    push_facts,
    push_name,
    scan_facts,
    scan_name,
)


@pytest.mark.parametrize("suffix", ["", ".h5", ".hdf5", ".json", ".H5"])
@pytest.mark.parametrize(
    ("told", "facts"),
    [
        ("a=100_v=20_i=2.000_s=0.700_t=-0.349_rep=0123", (0.1, 0.02, 2.0, 0.7, -0.349, 123.0)),
        ("a=0_v=50_i=4.000_s=0.700_t=1.396", (0.0, 0.05, 4.0, 0.7, 1.396, math.nan)),
        ("a=2500_v=-1_i=0.000_s=0.700_t=0.000", (2.5, math.nan, 0.0, 0.7, 0.0, math.nan)),
    ],
)
def test_a_name_gives_its_facts_in_si_units_and_an_accelerated_push_no_speed(
    told, facts, suffix
) -> None:
    path = f"normal/motion_surface=plywood_shape=rect1_{told}{suffix}"
    for name in (path, Path(path)):
        assert repr(push_facts(name)) == repr(PushFacts("plywood", "rect1", *facts))


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


TEXTS = st.from_regex(
    r"[A-Za-z][\w.-]{0,12}", fullmatch=True, alphabet=st.characters(codec="ascii")
)
NUMBERS = st.floats(0.0, 1e4) | st.decimals(0, 2000, places=3).map(float)
SIGNED = st.floats(-1e3, 1e3) | st.decimals(-2, 2, places=3).map(float)
REPETITIONS = st.integers(0, 99_999).map(float) | st.just(math.nan)


@pytest.mark.slow
@settings(deadline=None, derandomize=True)
@given(TEXTS, TEXTS, NUMBERS, NUMBERS, st.integers(0, 40).map(float), NUMBERS, SIGNED, REPETITIONS)
def test_any_facts_of_a_push_come_back_from_its_name_to_the_last_bit(
    surface, shape, a, v, side, fraction, angle, repetition
) -> None:
    facts = PushFacts(surface, shape, a, v, side, fraction, angle + 0.0, repetition)
    try:
        name = push_name(facts)
    except InvalidInput:
        # Only texts that hold the layout's own words cannot stand in a name.
        assert "_a=" in shape or "_shape" in surface + shape
        return
    # NaN is equal to itself by its words.
    assert repr(push_facts(name)) == repr(push_facts(f"{name}.h5")) == repr(facts)
    assert push_name(push_facts(name)) == name


@pytest.mark.slow
@settings(deadline=None, derandomize=True)
@given(TEXTS, st.integers(0, 359), NUMBERS, REPETITIONS)
def test_any_facts_of_a_scan_come_back_from_its_name(surface, degrees, speed, repetition) -> None:
    facts = ScanFacts(surface, "rect1", 0.0, speed, math.radians(degrees), repetition)
    name = scan_name(facts)
    assert f"_deg={(degrees + 180) % 360}" in name
    read = scan_facts(name)
    assert read is not None and read.direction == pytest.approx(facts.direction, abs=1e-12)
    assert repr(replace(read, direction=facts.direction)) == repr(facts) and scan_name(read) == name


def test_every_name_of_the_measured_files_is_written_as_it_is(measured_data) -> None:
    files = [*(measured_data / "mit_files").iterdir()]
    names = [path.stem for path in files if path.suffix in (".h5", ".json")]
    assert len(names) == 91 and [push_name(push_facts(f"{name}.h5")) for name in names] == names


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"surface": None}, "no file name"),
        ({"surface": "a/b"}, "no file name"),
        ({"object": "x_shape=y"}, "no file name"),
        ({"speed": math.nan}, "speed must be a finite number"),
        ({"speed": -0.1}, "no file name"),
        ({"side": 1.5}, "no file name"),
        ({"repetition": 1.5}, "repetition must be a whole number"),
        ({"repetition": -1.0}, "repetition must be at least 0"),
    ],
)
def test_facts_that_no_name_could_say_are_refused(changes, message) -> None:
    facts = PushFacts("plywood", "rect1", 0.0, 0.02, 0.0, 0.7, 0.0, 3.0)
    assert push_facts(push_name(facts)) == facts
    refused(push_name, replace(facts, **changes), told=message)
