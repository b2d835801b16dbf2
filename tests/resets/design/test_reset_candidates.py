"""The strategies a design looks at: places of the push for any outline, names, and what keeps the push."""

from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Ellipse, Polygon, SidePush, Slider
from cyclemap.resets.design.reset_candidates import (
    EFFORTS,
    PushPlaces,
    ResetCandidate,
    combined_candidates,
    effort,
    gripper_candidates,
    leg_candidates,
    own_candidate,
    push_candidates,
    ring_places,
)
from cyclemap.resets.strategies.drag_strategies import StraightReset

MIT = CollectionLoop.mit()


def shaped(name: str, **push) -> CollectionLoop:
    return CollectionLoop.mit(slider=Slider.mit(name), push=SidePush(**push))


def everything(loop: CollectionLoop, level: str) -> list[ResetCandidate]:
    places, work = PushPlaces.of(loop, effort(level).fractions), effort(level)
    drags = [*leg_candidates(work, 0.1), *combined_candidates(places, work, 0.1), *gripper_candidates()]
    return [own_candidate(loop), *push_candidates(places), *drags, *ring_places(loop, work.rings)]


@pytest.mark.parametrize(
    ("loop", "around", "everywhere"),
    [
        (MIT, 4, 8),
        (shaped("hex"), 6, 12),
        (shaped("tri1", side=2), 3, 6),
        (shaped("ellip2"), 8, 8),
        (shaped("rect1", fraction=0.5), 4, 8),
        (shaped("rect1", angle=0.3), 4, 8),
    ],
)
def test_every_side_is_pushed_at_the_place_of_the_loops_push_and_at_its_mirror_image(loop, around, everywhere) -> None:
    places = PushPlaces.of(loop)
    assert (len(places.around), len(set(places.everywhere))) == (around, everywhere)
    assert places.own == loop.push and places.own in places.everywhere
    assert set(places.around) <= set(places.everywhere)
    assert {push.distance for push in places.everywhere} == {loop.push.distance}
    if isinstance(loop.slider.outline, Polygon):
        assert places.mirrored.angle == -loop.push.angle and places.mirrored.fraction < 0.5
        assert places.mirrored in places.everywhere


def test_a_polygon_of_many_sides_is_pushed_on_eight_even_ones() -> None:
    corners = [(0.05 * np.cos(a), 0.05 * np.sin(a)) for a in 2 * np.pi * np.arange(20) / 20]
    loop = replace(MIT, slider=Slider(Polygon(tuple(corners))), push=SidePush(side=19))
    places = PushPlaces.of(loop)
    assert len(places.around) == 8 and places.own in places.around
    assert len(places.everywhere) == 16


def test_the_opposite_of_a_place_on_an_ellipse_is_half_a_turn_away() -> None:
    loop = replace(MIT, slider=Slider(Ellipse(0.05, 0.06)), push=SidePush(fraction=0.7))
    assert PushPlaces.of(loop).opposite.fraction == pytest.approx(0.2)


def test_slanted_pushes_lie_to_both_sides_of_the_upright_ones_and_none_beyond_a_right_angle() -> None:
    slanted = PushPlaces.of(MIT, (0.5,)).slanted((0.5,))
    assert len(slanted) == 16 and {round(push.angle, 12) for push in slanted} == {0.5, -0.5}
    steep = PushPlaces.of(shaped("rect1", angle=1.4)).slanted((0.5,))
    assert steep and all(abs(push.angle) < 0.5 * np.pi for push in steep)


@pytest.mark.parametrize("level", sorted(EFFORTS))
@pytest.mark.parametrize("loop", [MIT, shaped("hex"), shaped("ellip3")], ids=["square", "hexagon", "ellipse"])
def test_every_candidate_has_a_name_of_its_own_and_a_law(level, loop) -> None:
    made = everything(loop, level)
    assert len({one.name for one in made}) == len({one.strategy for one in made}) == len(made) >= 10
    for one in made:
        law = one.strategy.law(one.nodes)
        assert law.weights.sum() == pytest.approx(1.0) and len(law.actions) <= 300


def test_only_the_way_back_changes_where_the_push_is_kept() -> None:
    kept = [one.name for one in everything(MIT, "quick") if one.keeps_push(MIT)]
    leg = "trailing leg 100 mm, side step 50 mm"
    assert kept == ["as it is", leg, f"{leg}, golden angle", "gripper, any turn"]


def test_rings_are_tried_nearer_and_further_but_not_where_the_ring_is() -> None:
    rings = ring_places(MIT, 4)
    centre, own = np.array(MIT.slider.centre_of_mass), np.array(MIT.slider.hitch)
    levers = [np.hypot(*(np.array(one.strategy.hitch) - centre)) for one in rings]
    assert len(rings) == 11
    assert sorted({round(lever / np.hypot(*(own - centre)), 3) for lever in levers}) == [0.5, 1.0, 2.0]
    middle = replace(MIT, slider=replace(MIT.slider, hitch=MIT.slider.centre_of_mass))
    assert len(ring_places(middle, 2)) == 6


def test_bad_names_and_strategies_are_refused() -> None:
    with pytest.raises(InvalidInput, match="unknown effort 'quik'"):
        effort("quik")
    with pytest.raises(InvalidInput, match="no reset strategy"):
        ResetCandidate("mine", "straight")  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="nodes must be at least 1"):
        ResetCandidate("mine", StraightReset(), 0)
    with pytest.raises(InvalidInput, match="directions"):
        ring_places(MIT, -1)
