"""Each strategy: what it does, what it needs, and that its runs follow its law; alone and combined."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.combined import Combined, combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import (
    GripperTurn,
    RingPlace,
    ScatteredAim,
    StraightReset,
    TrailingLeg,
    WayPoints,
)
from cyclemap.resets.strategies.push_strategies import (
    AlternatingPushes,
    DrawnPushes,
    VariedPush,
    fraction_pushes,
    side_pushes,
)
from cyclemap.resets.strategies.schedules import GoldenAngle, Independent, LatinBlocks, Sobol, VanDerCorput
from cyclemap.resets.strategies.shared_strokes import run_action
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import ActionLaw, DrawnStrategy, ResetStrategy

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
PUSH = SidePush()
SIDES = side_pushes(PUSH, (0, 1, 2))
SECTOR = Spread.within(0.5, 0.4)
STRATEGIES = {
    "straight": StraightReset(),
    "way-points": WayPoints(((0.1, 0.0), (0.0, 0.1))),
    "fixed leg": TrailingLeg(0.05, 1.0),
    "random leg": TrailingLeg(0.05),
    "hooked leg": TrailingLeg(0.05, schedule=Sobol(), side_step=Spread(-0.02, 0.03)),
    "golden leg": TrailingLeg(0.05, schedule=GoldenAngle()),
    "Sobol leg, length too": TrailingLeg(Spread(0.03, 0.06), SECTOR, Sobol()),
    "van der Corput leg": TrailingLeg(0.05, schedule=VanDerCorput()),
    "leg in blocks": TrailingLeg(0.05, schedule=LatinBlocks(8)),
    "leg in eight directions": TrailingLeg(Spread(0.03, 0.06), schedule=LatinBlocks(8, jitter=False)),
    "scattered": ScatteredAim(0.03, GoldenAngle()),
    "gripper": GripperTurn(schedule=LatinBlocks(5)),
    "alternating": AlternatingPushes(SIDES),
    "drawn pushes": DrawnPushes(fraction_pushes(PUSH, (0.3, 0.7)), LatinBlocks(4)),
    "weighted pushes": DrawnPushes(SIDES, GoldenAngle(), (1.0, 2.0, 5.0)),
    "varied push": VariedPush(PUSH, Spread(0.6, 0.8), Spread(-0.1, 0.2), Spread(0.1, 0.15), Sobol()),
    "leg and gripper, golden": combine(
        TrailingLeg(0.05, schedule=GoldenAngle()), GripperTurn(schedule=GoldenAngle()), DrawnPushes(SIDES)
    ),
    "alternating, golden": combine(AlternatingPushes(SIDES), TrailingLeg(0.05, schedule=GoldenAngle())),
    "ring and leg": combine(RingPlace((0.0, 0.01)), TrailingLeg(0.05)),
}


def features(actions):
    """(n, k) numbers of actions whose means tell laws apart: products too, that see how parts go together."""
    rows = []
    for action in actions:
        x, y = action.way_points[-1] if action.way_points else (0.0, 0.0)
        push, wave = action.push or PUSH, np.exp(1j * action.turn)
        rows.append(
            (
                *(20 * x, 20 * y, 400 * x * x, 400 * x * y, wave.real, wave.imag, 20 * (x * wave.real + y * wave.imag)),
                *(
                    push.fraction,
                    push.fraction**2,
                    push.angle,
                    push.distance,
                    push.side == 1,
                    20 * x * (push.side == 1),
                ),
            )
        )
    return np.array(rows, dtype=float)


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_long_run_follows_the_law(name):
    """The means over 1,500 cycles are those over the law: within 5 standard errors, and nearer for sequences."""
    strategy, count = STRATEGIES[name], 1500
    assert isinstance(strategy, ResetStrategy)
    law, actions = strategy.law(16), strategy.actions(count, seed=4)
    assert len(actions) == count and actions == strategy.actions(count, seed=4)
    wanted, found = law.weights @ features(law.actions), features(actions).mean(axis=0)
    allowed = 0.02 if law.kind in ("sequence", "periodic") and "gripper" not in name else 0.09
    assert np.abs(found - wanted).max() < allowed
    assert abs(law.weights.sum() - 1.0) < 1e-12


def test_the_kinds_of_laws_say_how_cycles_depend_on_each_other():
    kinds = {name: strategy.law(8).kind for name, strategy in STRATEGIES.items()}
    for kind, names in {
        "independent": ("straight", "fixed leg", "random leg", "ring and leg"),
        "sequence": ("golden leg", "van der Corput leg", "alternating, golden", "leg and gripper, golden"),
        "blocks": ("leg in blocks", "leg in eight directions", "gripper", "drawn pushes"),
        "periodic": ("alternating",),
    }.items():
        assert [kinds[name] for name in names] == [kind] * len(names)


def test_what_the_same_rod_and_ring_cannot_do_is_named():
    needing = {name: strategy.needs for name, strategy in STRATEGIES.items() if strategy.needs}
    assert needing == {
        "gripper": ("gripper",),
        "leg and gripper, golden": ("gripper",),
        "ring and leg": ("ring at another place",),
    }


def test_a_trailing_leg_ends_with_a_leg_of_its_length_and_direction():
    strategy = TrailingLeg(Spread(0.03, 0.06), schedule=GoldenAngle())
    for action in strategy.actions(4, seed=1):
        _, drag = run_action(LOOP, action, 1.0)
        last = drag.legs[-1]
        x, y = last.frame.rod_start
        assert len(drag.legs) == 2 and 0.03 < math.hypot(x, y) < 0.06
        wanted = math.remainder(action.leg_direction + math.pi, 2 * math.pi)
        assert abs(math.remainder(last.phase.motion.rod.direction - wanted, 2 * math.pi)) < 1e-12


def test_a_side_step_comes_to_the_leg_across_it():
    """From the left as seen from the target: a quarter turn ahead of the leg's direction."""
    first, second = TrailingLeg(0.05, 1.0, side_step=0.02).law().actions[0].way_points
    step = complex(*first) - complex(*second)
    assert abs(step / complex(*second) - 0.4j) < 1e-12
    assert TrailingLeg(0.05, 1.0).law().actions[0].way_points == (second,)


def test_a_scattered_aim_fills_its_disc_evenly():
    """Of points spread evenly over a disc the share s lies within sqrt(s) of its radius."""
    places = np.array([made.way_points[0] for made in ScatteredAim(0.03, Sobol()).actions(1024, seed=2)])
    away = np.hypot(*places.T) / 0.03
    assert all(abs(np.mean(away**2 < share) - share) < 0.005 for share in (0.1, 0.5, 0.9)) and away.max() <= 1.0


def test_a_ring_at_another_place_changes_the_loop_and_nothing_else():
    made = RingPlace((0.001, 0.02))
    assert made.prepared(LOOP).slider.hitch == (0.001, 0.02) and made.prepared(LOOP).push == LOOP.push
    assert made.actions(2) == (CycleAction(), CycleAction())


def test_alternating_pushes_come_in_order_and_their_law_keeps_it():
    strategy = AlternatingPushes(SIDES)
    assert [made.push.side for made in strategy.actions(7)] == [0, 1, 2, 0, 1, 2, 0]
    assert [made.push.side for made in strategy.law().actions] == [0, 1, 2]


def test_an_even_choice_of_pushes_does_not_diffuse():
    """After n cycles the excess of one of two pushes is about sqrt(n)/2 if drawn, and a few if the golden angle says.

    So the turns of an even choice cancel, where those of chance would add up and spread the orientations.
    """
    excess = {}
    for schedule in (Independent(), GoldenAngle(), LatinBlocks(2)):
        strategy = DrawnPushes(side_pushes(PUSH, (0, 2)), schedule)
        ends = [sum(made.push.side - 1 for made in strategy.actions(900, seed)) for seed in range(12)]
        excess[schedule.kind] = float(np.sqrt(np.mean(np.square(ends))))
    assert 15.0 < excess["independent"] < 60.0 and excess["sequence"] < 5.0 and excess["blocks"] == 0.0


def test_parts_of_one_schedule_are_drawn_jointly():
    """Two golden angles each by itself would march in step: their difference would never change."""
    both = combine(TrailingLeg(0.05, schedule=GoldenAngle()), GripperTurn(schedule=GoldenAngle()))
    made = both.actions(500, seed=1)
    between = np.array([action.leg_direction - action.turn for action in made])
    assert abs(np.mean(np.exp(1j * between))) < 0.02
    alone = TrailingLeg(0.05).actions(500, seed=1), GripperTurn().actions(500, seed=1)
    assert len({(a.way_points, b.turn) for a, b in zip(*alone, strict=True)}) == 500


def test_independent_parts_do_not_share_their_draws():
    made = combine(TrailingLeg(0.05), GripperTurn(schedule=LatinBlocks(6)), TrailingLeg(0.02)).actions(400, seed=3)
    directions = np.array([[math.atan2(y, x) for x, y in action.way_points] for action in made])
    assert directions.shape == (400, 2)
    for turn in (directions[:, 0] - directions[:, 1], directions[:, 0] - [action.turn for action in made]):
        assert abs(np.mean(np.exp(1j * turn))) < 5.0 / math.sqrt(400)


def test_fixed_sequences_that_could_march_in_step_are_refused():
    """Two pushes in turn beside base two: the first digit of n is its parity, so that directions would follow it."""
    with pytest.raises(InvalidInput, match="could march in step"):
        combine(AlternatingPushes(SIDES), TrailingLeg(0.05, schedule=VanDerCorput()))
    with pytest.raises(InvalidInput, match="could march in step"):
        combine(TrailingLeg(0.05, schedule=Sobol()), GripperTurn(schedule=GoldenAngle()))
    assert len(combine(AlternatingPushes(SIDES), combine(TrailingLeg(0.05), GripperTurn(0.1))).parts) == 3


def test_a_combined_law_is_the_product_of_the_laws():
    law = combine(DrawnPushes(SIDES), TrailingLeg(0.05), GripperTurn(0.3)).law(8)
    assert len(law.actions) == 24 and np.ptp(law.weights) < 1e-15
    assert len({(made.push.side, made.way_points) for made in law.actions}) == 24
    assert {made.turn for made in law.actions} == {0.3}


def test_a_strategy_of_ones_own_needs_two_methods():
    class Zigzag(DrawnStrategy):
        name = "zigzag"

        def drawn(self):
            return (Spread(0.0, 0.05), 0.02)

        def action(self, numbers):
            return CycleAction(((numbers[0], numbers[1]), (-numbers[0], numbers[1])))

    mine = combine(Zigzag(), GripperTurn(0.1))
    assert mine.name == "zigzag + gripper turn" and len(mine.actions(3, seed=1)[2].way_points) == 2
    assert all(made.way_points[0][1] == 0.02 for made in mine.law().actions)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: TrailingLeg(0.0), "leg's length must be positive"),
        (lambda: TrailingLeg(Spread(-0.01, 0.02)), "leg's length must be positive"),
        (lambda: TrailingLeg(0.05, "north"), "leg's direction must be a finite number"),
        (lambda: TrailingLeg(0.05, schedule="golden"), "'golden' is no schedule"),
        (lambda: ScatteredAim(-0.1), "radius of the disc must be positive"),
        (lambda: GripperTurn(math.nan), "gripper turn must be a finite number"),
        (lambda: RingPlace((0.1,)), "hitch must be two finite numbers"),
        (lambda: WayPoints(((0.1, math.inf),)), "way-point must be two finite numbers"),
        (lambda: AlternatingPushes(()), "one or more of SidePush"),
        (lambda: DrawnPushes((0, 1)), "one or more of SidePush"),
        (lambda: DrawnPushes(SIDES, LatinBlocks(4, jitter=False)), "choose another size"),
        (lambda: DrawnPushes(SIDES, weights=(1.0, 2.0)), "3 pushes need as many weights"),
        (lambda: DrawnPushes(SIDES, weights=(1.0, 2.0, 0.0)), "weight of a push must be positive"),
        (lambda: VariedPush(PUSH, fraction=Spread(0.9, 1.1)), "lies outside the side"),
        (lambda: VariedPush("push"), "must be a SidePush"),
        (lambda: Combined(()), "made of one or more strategies"),
        (lambda: combine(StraightReset(), "leg"), "made of one or more strategies"),
        (lambda: combine(DrawnPushes(SIDES), AlternatingPushes(SIDES)).law(), "two pushes for one cycle"),
        (lambda: TrailingLeg(Spread(0.1, 0.2)).law(400), "ask for fewer nodes"),
        (lambda: TrailingLeg(0.05).actions(-1), "cycles must be at least 0"),
        (lambda: ActionLaw((CycleAction(),), [0.5]), "sum to one"),
        (lambda: ActionLaw((CycleAction(),), [0.5, 0.5]), "one weight for each action"),
    ],
)
def test_bad_values_are_refused(call, match):
    with pytest.raises(InvalidInput, match=match):
        call()


def test_the_same_seed_gives_every_part_independent_first_draws():
    """An independent strategy and the same inside a combination draw from streams of their own."""
    alone = TrailingLeg(0.05, schedule=Independent()).actions(3, seed=7)
    inside = combine(StraightReset(), TrailingLeg(0.05)).actions(3, seed=7)
    assert alone != inside and inside == combine(StraightReset(), TrailingLeg(0.05)).actions(3, seed=7)


def test_weights_count_by_their_ratios_however_large_or_small() -> None:
    for scale in (1e-300, 1.0, 1e308):
        chances = DrawnPushes(SIDES, weights=(0.25 * scale, 0.5 * scale, 1.0 * scale)).chances
        np.testing.assert_allclose(chances, [1 / 7, 2 / 7, 4 / 7], rtol=1e-14)
