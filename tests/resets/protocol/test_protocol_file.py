"""Protocol files: every strategy comes back as it was, a loop too, and a bad file is told by file, key and value."""

import math
import tomllib
from dataclasses import dataclass, replace
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies_of_all_kinds import EVERY_KIND, any_strategy

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import DragBack, Ellipse, PatchFootprint, PointFootprint, Polygon, Pusher, SidePush, Slider
from cyclemap.mechanics.footprint import grid_footprint
from cyclemap.resets.protocol.exact_units import DEGREES, MILLIMETRES, NUMBER, decimal_text
from cyclemap.resets.protocol.protocol_file import protocol_text, read_protocol, write_protocol
from cyclemap.resets.protocol.scheduled_actions import ScheduledActions
from cyclemap.resets.protocol.strategy_table import STRATEGY_KINDS, strategy_from_table, strategy_table
from cyclemap.resets.protocol.strategy_values import SCHEDULE_NAMES
from cyclemap.resets.protocol.toml_text import toml_text
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import TrailingLeg, WayPoints
from cyclemap.resets.strategies.schedules import Independent
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import DrawnStrategy

LOOP = CollectionLoop.mit()


@pytest.fixture
def protocol(tmp_path):
    def write(text):
        path = tmp_path / "protocol.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@settings(max_examples=400, deadline=None)
@given(st.floats(-1e3, 1e3), st.sampled_from((MILLIMETRES, DEGREES, NUMBER)))
# Its decimal ends in noughts, which the text leaves out.
@example(0.0049777291318453005, DEGREES)
def test_every_double_comes_back_from_the_text_of_its_decimal(value, unit) -> None:
    assert unit.read(Decimal(decimal_text(unit.written(value)))) == value


def test_short_numbers_are_read_as_people_write_them() -> None:
    """3000 whole and half degrees and tenths of a millimetre: the decimals of the written literals."""
    count = 0
    for half in range(-1000, 1000):
        assert DEGREES.read(Decimal(half) / 2) == math.radians(half / 2)
        count += 1
    for tenth in range(1000):
        assert MILLIMETRES.read(Decimal(tenth) / 10) == float(f"{tenth}e-4")
        count += 1
    assert count == 3000


@pytest.mark.parametrize("strategy", EVERY_KIND, ids=lambda strategy: strategy.name)
def test_every_strategy_comes_back_from_its_file_and_acts_alike(strategy, tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    write_protocol(path, LOOP, strategy)
    settings, found = read_protocol(path)
    assert found == strategy
    assert type(found) is type(strategy)
    assert found.actions(20, seed=4) == strategy.actions(20, seed=4)
    assert CollectionLoop.from_settings(settings, LOOP) == LOOP
    assert [entry.name for entry in tmp_path.iterdir()] == ["protocol.toml"]


def test_every_kind_and_schedule_is_among_those_that_come_back() -> None:
    tables = [strategy_table(strategy) for strategy in EVERY_KIND]
    names = [table["schedule"] for table in tables if "schedule" in table]
    assert {table["kind"] for table in tables} == set(STRATEGY_KINDS)
    assert len(STRATEGY_KINDS) == 10
    assert {name if isinstance(name, str) else name["kind"] for name in names} == set(SCHEDULE_NAMES)


@settings(max_examples=80, deadline=None)
@given(any_strategy)
def test_any_strategy_comes_back_exactly_through_toml(strategy) -> None:
    text = toml_text({"strategy": strategy_table(strategy)})
    found = strategy_from_table(tomllib.loads(text, parse_float=Decimal)["strategy"])
    assert found == strategy


TRIANGLE = Polygon(((0.05, 0.04), (-0.06, 0.04), (0.0, -0.0501)))
LOOPS = {
    "MIT's": LOOP,
    "another material": CollectionLoop.mit("delrin"),
    "what a material brings along": CollectionLoop.mit("plywood-measured"),
    "another push and rod": CollectionLoop.mit(
        push=SidePush(2, 1.0 / 3.0, 0.2, 0.07), pusher=Pusher(0.006, 0.31), reset=DragBack(((0.03, 0.1),), 0.001)
    ),
    "another ring, mass and centre": CollectionLoop.mit(
        slider=replace(Slider.mit("hex"), hitch=(0.01, -0.02), mass=2.0, centre_of_mass=(0.004, 0.001))
    ),
    "an ellipse": CollectionLoop.mit(slider=Slider(Ellipse(0.05, 0.07))),
    "a triangle on its rim": CollectionLoop.mit(
        slider=Slider(TRIANGLE), footprint=PatchFootprint(TRIANGLE, rim_share=0.3, warp=(0.05, 0.1))
    ),
    "a grid": CollectionLoop.mit(footprint=grid_footprint(LOOP.slider.outline, 8)),
}


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_a_loop_comes_back_and_runs_the_same_cycle(loop, tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    write_protocol(path, loop, None)
    settings, strategy = read_protocol(path)
    found = CollectionLoop.from_settings(settings, CollectionLoop.mit(loop.material))
    assert strategy is None
    assert found.cycle(0.7).theta_next == pytest.approx(loop.cycle(0.7).theta_next, abs=1e-9)
    assert found.push.side == loop.push.side
    assert np.allclose(found.slider.hitch, loop.slider.hitch, atol=1e-15)


def test_what_a_material_brings_along_is_left_to_the_material() -> None:
    """A protocol made for one surface must not carry that surface's own rod friction and ring to another."""
    text = protocol_text(LOOPS["what a material brings along"], None)
    assert LOOPS["what a material brings along"] != replace(
        LOOP, material=LOOPS["what a material brings along"].material
    )
    assert not {"mu_a", "pusher_mu", "hitch_x_mm", "rim_share", "pin_friction_mm"} & set(_keys(text))
    assert "pusher_mu" in _keys(protocol_text(LOOPS["another push and rod"], None))


def _keys(text: str) -> list[str]:
    return [key for table in tomllib.loads(text).values() for key in table]


def test_support_points_of_ones_own_are_refused() -> None:
    odd = PointFootprint(((-0.04, -0.04), (0.04, -0.04), (0.0, 0.04)), (1.0, 1.0, 2.0))
    with pytest.raises(InvalidInput, match="3 support points are neither corners nor a grid"):
        protocol_text(replace(LOOP, footprint=odd), None)


def test_noise_and_prediction_stand_in_the_file_and_do_not_disturb_it(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    scores = {"tv_from_uniform": 0.04, "reach_cycles": 12, "certified": True, "peaks_deg": [10.0, 200.0], "none": None}
    write_protocol(path, LOOP, TrailingLeg(0.05), noise=WrappedNormal(0.02), predicted=scores)
    settings, strategy = read_protocol(path)
    assert settings["noise_deg"] == pytest.approx(math.degrees(0.02), abs=1e-14)
    assert strategy == TrailingLeg(0.05)
    assert tomllib.loads(path.read_text())["predicted"] == {
        key: value for key, value in scores.items() if value is not None
    }
    assert path.read_text().startswith("# Protocol of a data collection")


@dataclass(frozen=True)
class Mine(DrawnStrategy):
    name = "mine"


@dataclass(frozen=True)
class MyLeg(TrailingLeg):
    """It inherits all and might change anything."""


@dataclass(frozen=True)
class MySchedule(Independent):
    pass


@pytest.mark.parametrize("strategy", [Mine(), MyLeg(0.05), TrailingLeg(0.05, schedule=MySchedule())])
def test_a_strategy_of_ones_own_is_refused_and_pointed_to_the_schedule(strategy, tmp_path) -> None:
    with pytest.raises(InvalidInput, match=r"of your own.*write_schedule"):
        write_protocol(tmp_path / "mine.toml", LOOP, strategy)
    assert not list(tmp_path.iterdir())


def test_a_schedule_is_no_rule() -> None:
    with pytest.raises(InvalidInput, match=r"schedule of 2 cycles.*write_schedule"):
        strategy_table(ScheduledActions((CycleAction(), CycleAction())))


REFUSALS = [
    ("[strategy]\nlength_mm = 50\n", r"\[strategy\]: has no kind: give kind, one of alternating-pushes, combined"),
    ('strategy = "leg"\n', r"\[strategy\]: must be a table, not 'leg'"),
    ("[strategy]\nkind = 3\n", "kind = 3 is no text"),
    ('[strategy]\nkind = "traling-leg"\n', "unknown kind of strategy 'traling-leg': did you mean 'trailing-leg'"),
    ('[strategy]\nkind = "trailing-leg"\n', "of kind 'trailing-leg': length_mm is missing"),
    ('[strategy]\nkind = "trailing-leg"\nlength = 50\n', "unknown key 'length': did you mean 'length_mm'"),
    ('[strategy]\nkind = "trailing-leg"\nlength_mm = "long"\n', r"length_mm = 'long': must be a number, \[low, high\]"),
    ('[strategy]\nkind = "trailing-leg"\nlength_mm = true\n', "length_mm = True: must be a number"),
    ('[strategy]\nkind = "trailing-leg"\nlength_mm = nan\n', "must be a finite number"),
    (
        '[strategy]\nkind = "trailing-leg"\nlength_mm = [50, 40]\n',
        r"length_mm = \[50, 40\]: a spread runs from a lower",
    ),
    ('[strategy]\nkind = "trailing-leg"\nlength_mm = [1, 2, 3]\n', "not a list of 3"),
    ('[strategy]\nkind = "trailing-leg"\nlength_mm = -5\n', "with length_mm = -5: leg's length must be positive"),
    ('[strategy]\nkind = "gripper-turn"\nturn_deg = "all"\n', r"turn_deg = 'all': must be .*'any'"),
    ('[strategy]\nkind = "gripper-turn"\nschedule = "gold"\n', "unknown schedule 'gold'.*golden-angle"),
    ('[strategy]\nkind = "gripper-turn"\nschedule = {kind = "sobol", size = 3}\n', "size belongs to latin-blocks"),
    ('[strategy]\nkind = "gripper-turn"\nschedule = {kind = "latin-blocks", size = 0}\n', "size must be at least 1"),
    ('[strategy]\nkind = "way-points"\nway_points_mm = [[1]]\n', r"must be a point \[x, y\]"),
    ('[strategy]\nkind = "ring-place"\nhitch_mm = 3\n', "hitch_mm = 3: must be a point"),
    ('[strategy]\nkind = "drawn-pushes"\npushes = []\n', "one or more tables of a push"),
    ('[strategy]\nkind = "drawn-pushes"\n[[strategy.pushes]]\nside = 1\n', "push 1: fraction is missing"),
    (
        '[strategy]\nkind = "drawn-pushes"\n[[strategy.pushes]]\nside = 1\nfraction = 0.5\npush_mm = 9\nweight = 1\n'
        "[[strategy.pushes]]\nside = 2\nfraction = 0.5\npush_mm = 9\n",
        "1 of 2 pushes have a weight",
    ),
    (
        '[strategy]\nkind = "alternating-pushes"\npushes = [{side = 0, fraction = 0.7, push_mm = 9, weight = 2}]\n',
        "pushes that come in turn have no weight",
    ),
    (
        '[strategy]\nkind = "varied-push"\npush = {side = 0, fraction = 1.7, push_mm = 9}\n',
        r"push = .*contact fraction 1.7 lies outside",
    ),
    ('[strategy]\nkind = "combined"\nparts = []\n', "parts must be one or more tables"),
    (
        '[strategy]\nkind = "combined"\n[[strategy.parts]]\nkind = "straight"\n[[strategy.parts]]\nkind = "straigt"\n',
        r"\[\[strategy.parts\]\] 2: unknown kind of strategy 'straigt'",
    ),
    (
        '[strategy]\nkind = "combined"\n[[strategy.parts]]\nkind = "gripper-turn"\nschedule = "sobol"\n'
        '[[strategy.parts]]\nkind = "scattered-aim"\nradius_mm = 5\nschedule = "golden-angle"\n',
        "could march in step",
    ),
    (
        '[strategy]\nkind = "drawn-pushes"\npushes = [{side = 0, fraction = 0.7, push_mm = 9, wieght = 2}]\n',
        "unknown key 'wieght': did you mean 'weight'",
    ),
    (
        '[strategy]\nkind = "drawn-pushes"\npushes = [{side = 0, fraction = 0.7, push_mm = 9, weight = nan}]\n',
        "push 1: weight = NaN: must be a finite number",
    ),
    (
        '[strategy]\nkind = "drawn-pushes"\npushes = [{side = 1.5, fraction = 0.7, push_mm = 9}]\n',
        "side must be a whole number, not 1.5",
    ),
    (f"[push]\npush_mm = 1{'0' * 5000}\n", "a number has more digits"),
    ("[push]\npush_mm = 1e99999999999999999999\n", "a number has more digits, or a larger power of ten"),
    (f"[push]\nway_points_mm = {'[' * 2000}{']' * 2000}\n", "nested too deeply"),
    (
        '[strategy]\nkind = "combined"\n'
        + "".join(f'[[strategy{".parts" * depth}]]\nkind = "combined"\n' for depth in range(1, 150)),
        "nested too deeply",
    ),
    ("[predicted]\nscore = {a = 1}\n", r"\[predicted\] score must be a number"),
    ("predicted = 3\n", "predicted must be a table of scores"),
    ("[push]\npush_mn = 3\n", "unknown setting 'push_mn': did you mean 'push_mm'"),
]


@pytest.mark.parametrize(("text", "said"), REFUSALS)
def test_a_bad_protocol_is_told_by_file_key_and_value(protocol, text, said) -> None:
    path = protocol(text)
    with pytest.raises(DataFileError, match=said) as refusal:
        read_protocol(path)
    assert str(refusal.value).startswith(str(path))


def test_what_may_be_left_out_takes_the_defaults_of_the_strategies(protocol) -> None:
    path = protocol('[strategy]\nkind = "trailing-leg"\nlength_mm = 50\n')
    assert read_protocol(path) == ({}, TrailingLeg(0.05))
    path = protocol('[push]\nside = 2\n[strategy]\nkind = "trailing-leg"\nlength_mm = 50\ndirection_deg = [0, 360]\n')
    found = read_protocol(path)
    assert found == ({"side": 2}, TrailingLeg(0.05, Spread.full_turn()))


def test_the_file_is_replaced_whole_or_left_as_it_was(tmp_path) -> None:
    path = tmp_path / "protocol.toml"
    write_protocol(path, LOOP, WayPoints(((0.1, 0.0),)))
    before = path.read_bytes()
    with pytest.raises(InvalidInput):
        write_protocol(path, LOOP, Mine())
    assert path.read_bytes() == before


@pytest.mark.parametrize("predicted", [{"a": {"b": 1}}, {1: 2}, [1]])
def test_a_prediction_that_could_not_be_read_back_is_not_written(predicted, tmp_path) -> None:
    with pytest.raises(InvalidInput, match="predicted"):
        write_protocol(tmp_path / "protocol.toml", LOOP, None, predicted=predicted)
    assert not list(tmp_path.iterdir())
