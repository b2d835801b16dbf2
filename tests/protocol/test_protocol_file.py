"""Protocol files: every strategy comes back as it was, a loop too, and a bad file is told by file,
key and value.
"""

import math
import re
import tomllib
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    PatchFootprint,
    PointFootprint,
    Polygon,
    PressedFootprint,
    Pusher,
    SidePush,
    Slider,
)
from cyclemap.mechanics.footprint import grid_footprint
from cyclemap.protocol import loop_from_settings, read_protocol, write_protocol
from cyclemap.protocol.protocol_file import protocol_text
from cyclemap.resets import CycleAction, ResetStrategy, gripper_turns, legs
from cyclemap.written import DEGREES, MILLIMETRES, NUMBER, decimal_text

LOOP = CollectionLoop.mit()


@settings(max_examples=400, deadline=None)
@given(st.floats(-1e3, 1e3), st.sampled_from((MILLIMETRES, DEGREES, NUMBER)))
# Its decimal ends in noughts, which the text leaves out.
@example(0.0049777291318453005, DEGREES)
def test_every_double_comes_back_from_the_text_of_its_decimal(value, unit) -> None:
    """Whole and half degrees and tenths of a millimetre are read as people write them."""
    assert unit.read(Decimal(decimal_text(unit.written(value)))) == value
    short = round(value)
    assert DEGREES.read(Decimal(short) / 2) == math.radians(short / 2)
    assert MILLIMETRES.read(Decimal(short) / 10) == float(f"{short}e-4")


COIN = ResetStrategy.pushes(SidePush(), (1, 2))
WAY = ((0.1, 0.0), (1.0 / 3.0, -0.2))
ODD = CycleAction(WAY, SidePush(2, 1.0 / 3.0, 0.1, 0.07), math.pi / 7.0)
STRATEGIES = {
    "a coin": COIN,
    "weights": ResetStrategy(COIN.actions, (1.0, 2.5)),
    "in turn": ResetStrategy(COIN.actions, order="in turn"),
    "shuffled": ResetStrategy(COIN.actions, (1.0, 3.0), "shuffled", 8),
    "legs": ResetStrategy(legs(0.0731, 8)),
    "gripper": ResetStrategy(gripper_turns(36)),
    "all at once": ResetStrategy((ODD, CycleAction(()), CycleAction()), hitch=(0.01, -1.0 / 300.0)),
}


def test_every_strategy_comes_back_from_its_file_and_acts_alike(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    for strategy in STRATEGIES.values():
        write_protocol(path, LOOP, strategy)
        settings, found = read_protocol(path)
        assert found == strategy
        assert found.run(20, seed=4) == strategy.run(20, seed=4)
        assert loop_from_settings(settings, LOOP) == LOOP
        assert [entry.name for entry in tmp_path.iterdir()] == ["protocol.toml"]


def test_a_change_of_any_character_is_noticed_unless_the_checksum_is_taken_out(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    write_protocol(path, LOOP, STRATEGIES["weights"])
    text = path.read_text()
    assert text.startswith("# checksum: ")
    places = [at for at in range(text.index("\n") + 1, len(text)) if text[at].isdigit()][::4]
    assert len(places) > 5
    for at in places:
        path.write_text(text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :])
        refused(read_protocol, path, told="not as it was written", kind=DataFileError)
    path.write_text(text.split("\n", 1)[1].replace("weight = 2.5", "weight = 4"))
    assert read_protocol(path)[1] == ResetStrategy(COIN.actions, (1.0, 4.0))


TRIANGLE = Polygon(((0.05, 0.04), (-0.06, 0.04), (0.0, -0.0501)))
HEX = replace(Slider.mit("hex"), hitch=(0.01, -0.02), mass=2.0, centre_of_mass=(0.004, 0.001))
RIM = PatchFootprint(TRIANGLE, rim_share=0.3, corner_share=0.1)
LOOPS = {
    "MIT's": LOOP,
    "another material": CollectionLoop.mit("delrin"),
    "what a material brings along": CollectionLoop.mit("plywood-measured"),
    "another push and rod": CollectionLoop.mit(
        push=SidePush(2, 1.0 / 3.0, 0.2, 0.07),
        pusher=Pusher(0.006, 0.31),
        reset=DragBack(((0.03, 0.1),), 0.001),
    ),
    "another ring, mass and centre": CollectionLoop.mit(slider=HEX),
    "an ellipse": CollectionLoop.mit(slider=Slider(Ellipse(0.05, 0.07))),
    "a triangle on its rim": CollectionLoop.mit(slider=Slider(TRIANGLE), footprint=RIM),
    "a grid": CollectionLoop.mit(footprint=grid_footprint(LOOP.slider.outline, 8)),
}


def test_a_loop_comes_back_and_runs_the_same_cycle(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    for loop in LOOPS.values():
        write_protocol(path, loop, None)
        settings, strategy = read_protocol(path)
        found = loop_from_settings(settings, CollectionLoop.mit(loop.material))
        assert strategy is None
        assert found.cycle(0.7).theta_next == pytest.approx(loop.cycle(0.7).theta_next, abs=1e-9)
        assert found.push.side == loop.push.side
        assert np.allclose(found.slider.hitch, loop.slider.hitch, atol=1e-15)


def test_what_a_material_brings_along_is_left_to_the_material() -> None:
    """A protocol made for one surface must not carry that surface's own rod friction and ring to
    another.
    """
    brought, other = (
        {key for table in tomllib.loads(protocol_text(LOOPS[name], None)).values() for key in table}
        for name in ("what a material brings along", "another push and rod")
    )
    assert not {"mu_a", "pusher_mu", "hitch_x_mm", "rim_share", "pin_friction_mm"} & brought
    assert "pusher_mu" in other


def test_noise_and_prediction_stand_in_the_file_and_do_not_disturb_it(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    scores = {"tv": 0.04, "reach_cycles": 12, "certified": True, "peaks_deg": [10.0, 200.0]}
    write_protocol(path, LOOP, COIN, noise=0.02, predicted=scores | {"none": None})
    settings, strategy = read_protocol(path)
    assert settings["noise_deg"] == pytest.approx(math.degrees(0.02), abs=1e-14)
    assert strategy == COIN
    assert tomllib.loads(path.read_text())["predicted"] == scores
    assert path.read_text().splitlines()[1].startswith("# Protocol of a data collection")


ONE, TWO = "{ gripper_turn_deg = 1 }", "{ gripper_turn_deg = 2 }"
WEIGHED, HEAVIER = "{ gripper_turn_deg = 1, weight = 1 }", "{ way_points_mm = [], weight = 2 }"
BAD_STRATEGIES = [
    ("kind = 'drawn-pushes'", "kind = 'drawn-pushes' is how earlier versions said it: give order"),
    ("", "actions is missing"),
    ("actions = []", "actions must be one or more tables"),
    (f"order = 'sobol'\nactions = [{ONE}]", "order is 'sobol'; it must be one of"),
    (f"order = 'shuffled'\nblock = 1000000000\nactions = [{ONE}]", "is larger than 10000"),
    (f"block = 2\nactions = [{ONE}]", "belongs to the order 'shuffled'"),
    ("actions = [{}]", "actions]] 1: it is empty"),
    ("actions = [{ weight = 2 }]", "actions]] 1: it is empty"),
    ("actions = [{ sid = 1 }]", "unknown key 'sid': did you mean 'side'"),
    ("actions = [{ side = 1, push_mm = 9 }]", "fraction is missing"),
    ("actions = [{ side = 1.5, fraction = 0.5, push_mm = 9 }]", "side must be a whole number"),
    (
        "actions = [{ side = 1, fraction = 0.5, push_mm = nan }]",
        "push_mm = NaN: must be a finite number",
    ),
    ("actions = [{ side = 1, fraction = 0.5, push_mm = -3 }]", "push distance must be positive"),
    ("actions = [{ way_points_mm = [[1, 2, 3]] }]", "way_points_mm must hold [x, y]"),
    ("actions = [{ gripper_turn_deg = true }]", "must be a number"),
    (f"actions = [{WEIGHED}, {TWO}]", "1 of 2 actions have a weight"),
    (f"order = 'in turn'\nactions = [{WEIGHED}, {HEAVIER}]", "actions in turn are all alike"),
    (f"hitch_mm = 3\nactions = [{ONE}]", "hitch_mm must hold [x, y]"),
]
BAD_FILES = [
    (
        'strategy = "leg"',
        "[strategy]: must be a table with order, block, hitch_mm, actions, not 'leg'",
    ),
    (f"[push]\npush_mm = 1{'0' * 5000}", "a number has more digits"),
    (
        "[push]\npush_mm = 1e99999999999999999999",
        "a number has more digits, or a larger power of ten",
    ),
    (f"[push]\nway_points_mm = {'[' * 2000}{']' * 2000}", "nested too deeply"),
    ("[predicted]\nscore = {a = 1}", "[predicted] score must be a number"),
    ("predicted = 3", "predicted must be a table of scores"),
    ("[push]\npush_mn = 3", "unknown setting 'push_mn': did you mean 'push_mm'"),
    *((f"[strategy]\n{text}", said) for text, said in BAD_STRATEGIES),
]


def test_a_bad_protocol_is_told_by_file_key_and_value_and_what_is_left_out_takes_its_default(
    protocol_file,
) -> None:
    action = "[[strategy.actions]]\nside = 2\nfraction = 0.6\npush_mm = 80\n"
    found = read_protocol(protocol_file(f"[push]\nside = 2\n[strategy]\n{action}"))
    assert found == ({"side": 2}, ResetStrategy((CycleAction(push=SidePush(2, 0.6, 0.0, 0.08)),)))
    for text, said in BAD_FILES:
        path = protocol_file(f"{text}\n")
        told = f"^{re.escape(str(path))}.*{re.escape(said)}"
        refused(read_protocol, path, told=told, kind=DataFileError)


def test_what_could_not_be_read_back_leaves_the_file_as_it_was(protocol_file) -> None:
    path = protocol_file("before")
    for predicted in ({"a": {"b": 1}}, {1: 2}, [1]):
        refused(write_protocol, path, LOOP, None, predicted=predicted, told="predicted")
    odd = PointFootprint(((-0.04, -0.04), (0.04, -0.04), (0.0, 0.04)), (1.0, 1.0, 2.0))
    told = "3 support points are neither corners nor a grid"
    refused(write_protocol, path, replace(LOOP, footprint=odd), None, told=told)
    assert path.read_text() == "before" and list(path.parent.iterdir()) == [path]


def test_a_floor_without_the_variation_that_its_material_has_is_refused_not_changed() -> None:
    """No key says that a floor does not vary with the place: read back,
    the loop would be another."""
    loop = CollectionLoop.mit("plywood-floor")
    assert isinstance(loop.footprint, PressedFootprint)
    alike = replace(loop, footprint=replace(loop.footprint, field=None))
    refused(protocol_text, alike, None, told="loop's footprint: leave that as it was")


def test_settings_that_a_protocol_gives_make_its_loop_its_noise_among_them(tmp_path) -> None:
    """In the digits that they were set in: 0.01378 m are no 13.780000000000001 mm."""
    loop = loop_from_settings({"hitch_x_mm": 13.78, "hitch_y_mm": 4.1, "push_mm": 13.78})
    write_protocol(tmp_path / "it.toml", loop, None, noise=math.radians(2.0))
    text, settings = (tmp_path / "it.toml").read_text(), read_protocol(tmp_path / "it.toml")[0]
    assert text.count("= 13.78\n") == 2 and settings["noise_deg"] == pytest.approx(2.0)
    found = loop_from_settings(settings)
    assert (found.slider.hitch, found.push) == (loop.slider.hitch, loop.push)
    with pytest.raises(InvalidInput, match="noise_deg"):
        loop_from_settings({"noise_deg": -1.0})
