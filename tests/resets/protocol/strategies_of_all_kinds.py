"""One strategy of every kind, and a Hypothesis strategy that draws any of them, alone and combined."""

import math

from hypothesis import strategies as st

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.combined import Combined, combine
from cyclemap.resets.strategies.drag_strategies import (
    GripperTurn,
    RingPlace,
    ScatteredAim,
    StraightReset,
    TrailingLeg,
    WayPoints,
)
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, VariedPush, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle, Independent, LatinBlocks, Sobol, VanDerCorput
from cyclemap.resets.strategies.spread import Spread

SIDES = side_pushes(SidePush(fraction=1.0 / 3.0, angle=-0.1, distance=0.1), (0, 1, 2))
EVERY_KIND = (
    StraightReset(),
    WayPoints(((0.1, 1.0 / 300.0), (-0.02, 0.0))),
    WayPoints(()),
    RingPlace((0.0, 0.02)),
    TrailingLeg(0.05, 1.0),
    TrailingLeg(Spread(0.03, 0.06), Spread(-math.pi, math.pi, around=True), Sobol(), Spread(-0.02, 0.03)),
    TrailingLeg(0.05, Spread(0.3, 1.2, around=True), GoldenAngle()),
    ScatteredAim(0.02, VanDerCorput()),
    GripperTurn(),
    GripperTurn(Spread(0.0, 2.0 * math.pi), LatinBlocks(5, jitter=False)),
    AlternatingPushes(SIDES),
    DrawnPushes(SIDES, LatinBlocks(6)),
    DrawnPushes(SIDES, Independent(), (0.1, 1.0 / 3.0, 7.0)),
    VariedPush(SIDES[1], Spread(0.6, 0.8), Spread(-0.1, 0.2), Spread(0.1, 0.15), Sobol()),
    VariedPush(SIDES[0]),
    combine(TrailingLeg(0.07), DrawnPushes(SIDES), GripperTurn(Spread(-0.1, 0.1))),
    Combined((WayPoints(((0.1, 0.0),)), Combined((RingPlace((0.01, 0.0)), StraightReset())))),
)

lengths = st.floats(-0.5, 0.5)
angles = st.floats(-7.0, 7.0)
points = st.tuples(lengths, lengths)


def spreads(ends, around):
    """A spread between two different numbers."""
    pairs = st.tuples(ends, ends).filter(lambda pair: pair[0] != pair[1]).map(sorted)
    return st.builds(lambda pair, turns: _spread(pair, turns), pairs, around)


def _spread(pair, around):
    return Spread(*pair, around=around and pair[1] - pair[0] <= 2.0 * math.pi)


def numbers(ends):
    return st.one_of(ends, spreads(ends, st.just(False)))


directions = st.one_of(angles, spreads(angles, st.booleans()), st.just(Spread.full_turn()))
schedules = st.one_of(
    st.sampled_from((Independent(), GoldenAngle(), VanDerCorput(), Sobol())),
    st.builds(LatinBlocks, st.integers(1, 40), st.booleans()),
)
pushes = st.builds(SidePush, st.integers(0, 5), st.floats(0.0, 1.0), st.floats(-1.5, 1.5), st.floats(1e-4, 0.3))
push_rows = st.lists(pushes, min_size=1, max_size=4).map(tuple)
plain_schedules = st.sampled_from((Independent(), GoldenAngle(), Sobol()))
weighted = push_rows.flatmap(
    lambda rows: st.builds(
        DrawnPushes,
        st.just(rows),
        plain_schedules,
        st.none() | st.tuples(*(st.floats(1e-6, 1e6) for _ in rows)),
    )
)
varied = st.builds(
    VariedPush,
    pushes,
    st.none() | numbers(st.floats(0.0, 1.0)),
    st.none() | numbers(st.floats(-1.5, 1.5)),
    st.none() | numbers(st.floats(1e-4, 0.3)),
    schedules,
)
single = st.one_of(
    st.just(StraightReset()),
    st.builds(WayPoints, st.lists(points, max_size=3).map(tuple)),
    st.builds(RingPlace, points),
    st.builds(TrailingLeg, numbers(st.floats(1e-4, 0.3)), directions, schedules, numbers(lengths)),
    st.builds(ScatteredAim, st.floats(1e-4, 0.3), schedules),
    st.builds(GripperTurn, directions, schedules),
    st.builds(AlternatingPushes, push_rows),
    weighted,
    varied,
)


def _combined(parts):
    try:
        made = combine(*parts)
        made.actions(1)
    except InvalidInput:
        # Two fixed sequences that could march in step, or two pushes for one cycle, are no strategy.
        return parts[0]
    return made


any_strategy = single | st.lists(single, min_size=1, max_size=3).map(_combined)
