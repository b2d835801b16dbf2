"""A tip's path is told by few corners, none of its places far from them, and by a travel that never falls."""

from itertools import pairwise

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.replay.replay_push import BEND, tip_path


def table(place, time=None):
    place = np.asarray(place, dtype=float)
    clock = np.linspace(0.0, 1.0, len(place)) if time is None else time
    return np.column_stack([clock, place, np.zeros(len(place))])


def from_chain(path, places):
    """Distance of each place from the chain of corners."""
    first, edge = path.corners[:-1], np.diff(path.corners, axis=0)
    offset = places[:, None] - first
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    return np.hypot(*np.moveaxis(offset - share[..., None] * edge, -1, 0)).min(axis=1)


@pytest.mark.parametrize("seed", range(4))
def test_a_straight_stroke_with_noise_of_a_tenth_of_a_millimetre_is_one_stroke(seed) -> None:
    random = np.random.default_rng(seed)
    along = np.linspace(0.0, 0.05, 300)[:, None] * np.array([np.cos(seed), np.sin(seed)])
    noisy = along + random.uniform(-0.7e-4, 0.7e-4, (300, 2))
    path = tip_path(table(noisy))
    assert path.strokes == 1
    assert 2e-5 < path.straightness < 2e-4
    assert np.all(np.diff(path.travel) >= 0.0)
    assert path.travel[-1] == pytest.approx(path.length)


def test_every_place_of_a_curved_path_is_within_the_bend_of_its_strokes() -> None:
    angle = np.linspace(0.0, 1.5 * np.pi, 700)
    places = 0.04 * np.column_stack([np.cos(angle), np.sin(angle)])
    path = tip_path(table(places))
    assert from_chain(path, places).max() <= BEND
    # A chord over an arc of radius r stays within s where its half-angle h has r (1 - cos h) = s.
    fewest = 1.5 * np.pi / (2.0 * np.arccos(1.0 - BEND / 0.04))
    assert fewest <= path.strokes <= 2.1 * fewest
    assert path.length == pytest.approx(0.04 * 1.5 * np.pi, rel=0.01)
    assert path.straightness > 0.05


def test_travel_and_place_are_inverse_to_each_other_on_the_corners() -> None:
    corners = np.array([[0.0, 0.0], [0.03, 0.0], [0.03, 0.04], [0.03, 0.01]])
    places = np.vstack([np.linspace(a, b, 50) for a, b in pairwise(corners)])
    path = tip_path(table(places))
    assert path.corners == pytest.approx(corners)
    assert path.length == pytest.approx(0.03 + 0.04 + 0.03)
    assert path.place_at(path.travel) == pytest.approx(places, abs=1e-12)
    assert path.travel_at(np.array([-5.0, 5.0])) == pytest.approx([0.0, path.length])


def test_a_tip_that_trembles_backwards_never_travels_back() -> None:
    place = np.column_stack([[0.0, 0.01, 0.0099, 0.02, 0.0198, 0.03], np.zeros(6)])
    path = tip_path(table(place))
    assert path.travel == pytest.approx([0.0, 0.01, 0.01, 0.02, 0.02, 0.03])


def test_a_tip_that_stays_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"the tip moves 0\.5 mm: it pushes nothing"):
        tip_path(table([[0.0, 0.0], [0.0005, 0.0]]))
