"""What has no prediction is refused by name: other things than surfaces, surfaces that cannot be, other loops."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import (
    Anisotropy,
    CollectionLoop,
    Fingerprint,
    TurnResponse,
    check_prediction,
    fingerprint,
    predict,
)
from cyclemap.collection.fingerprint import MOST_ELLIPTICITY, with_anisotropy
from cyclemap.collection.fingerprint_prediction import lock_in_boundary
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap
from cyclemap.mechanics import EllipseFriction

RESPONSE = TurnResponse(0.1, [2.0, 0.5, 0.4, 1.0], np.zeros((4, 4)))
FOUND = Fingerprint(RESPONSE, TurnResponse(0.0, np.zeros(4), np.zeros((4, 4))), 0.0, 0.1)


@pytest.fixture(scope="module")
def plywood():
    return CollectionLoop.mit(material="plywood")


def test_a_friction_is_predicted_as_its_anisotropy(plywood) -> None:
    by_friction = predict(FOUND, plywood.material.friction)
    assert by_friction.anisotropy == Anisotropy.of(plywood.material.friction)
    assert len(by_friction.directions) == 2


@pytest.mark.parametrize("surface", [None, "plywood", 0.1, (0.1, 0.0, 0.1, 0.0)])
def test_other_things_than_a_surface_are_refused_at_once(surface) -> None:
    with pytest.raises(InvalidInput, match=r"must be an Anisotropy or an EllipseFriction.*not "):
        predict(FOUND, surface)
    with pytest.raises(InvalidInput, match="friction must be an EllipseFriction"):
        Anisotropy.of(surface)
    with pytest.raises(InvalidInput, match="needs a Fingerprint"):
        predict(surface, Anisotropy(0.1, 0.0, 0.0, 0.0))
    with pytest.raises(InvalidInput, match="loop must be a CollectionLoop"):
        fingerprint(surface)


@pytest.mark.parametrize("ellipticity", [0.0, 0.3, MOST_ELLIPTICITY])
@pytest.mark.parametrize("away", [0.0, 0.7, 0.5 * np.pi, 2.4])
def test_offsets_are_refused_exactly_where_the_friction_ellipse_leaves_zero_out(ellipticity, away) -> None:
    """The edge in polar form: along `away` from the axis of greater friction it lies at |cos/e^v, sin e^v|^-1."""
    stretch = math.exp(ellipticity)
    edge = 1.0 / math.hypot(math.cos(away) / stretch, math.sin(away) * stretch)
    inside, outside = (Anisotropy(factor * edge, 0.4 + away, ellipticity, 0.4) for factor in (1.0 - 1e-9, 1.0 + 1e-9))
    assert predict(FOUND, inside).anisotropy is inside
    assert isinstance(inside.friction(), EllipseFriction)
    for refused in (lambda: predict(FOUND, outside), outside.friction):
        with pytest.raises(InvalidInput, match=r"offset .* reaches out of the friction ellipse.*choose less than"):
            refused()


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (Anisotropy(1e200, 0.0, 0.1, 0.0), "offset 1e[+]200 reaches out"),
        (Anisotropy(2.0, 0.0, 0.0, 0.0), "offset 2 reaches out.*choose less than 1$"),
        (Anisotropy(0.0, 0.0, 5.1, 0.0), "ellipticity 5.1 is more than any surface has.*choose at most 5"),
        (Anisotropy(1e200, 0.0, 1e200, 0.0), "ellipticity 1e[+]200"),
    ],
)
def test_an_anisotropy_that_no_surface_has_is_refused_however_large(surface, message) -> None:
    with pytest.raises(InvalidInput, match=message):
        predict(FOUND, surface)


def test_the_first_order_law_may_be_scaled_beyond_any_surface() -> None:
    """Rays of unit length, and ranges of lock-in beyond scale 10, need no surface that has them."""
    edge = lock_in_boundary(RESPONSE, 0.0, 0.0, [0.0, 0.5 * np.pi])
    assert edge[0, 0] == pytest.approx(0.1 / math.hypot(2.0, 0.5))
    slow = Fingerprint(TurnResponse(3.0, RESPONSE.gradient, np.zeros((4, 4))), FOUND.drag, 0.0, 0.01)
    found = predict(slow, Anisotropy(0.1, 0.0, 0.02, 0.0))
    assert 10.0 < found.lock_in_range[0] < found.lock_in.scale


@pytest.mark.parametrize("theta", [math.nan, [0.0, math.inf], "abc"])
def test_orientations_that_are_no_finite_numbers_are_refused(theta) -> None:
    predicted = predict(FOUND, Anisotropy(0.1, 0.0, 0.02, 0.0))
    laws = (predicted.turn, predicted.second_order_turn, predicted.turn_error, predicted.anisotropy.seen_from)
    for law in laws:
        with pytest.raises(InvalidInput, match="theta must"):
            law(theta)


@pytest.mark.parametrize("seen", ["abc", math.nan, [0.1, 0.0, 0.0], [0.1, 0.0, math.nan, 0.0]])
def test_a_response_takes_finite_anisotropies_of_four_numbers(seen) -> None:
    for law in (RESPONSE.first_order, RESPONSE.second_order):
        with pytest.raises(InvalidInput, match="seen must"):
            law(seen)
    with pytest.raises(InvalidInput, match="shares must"):
        lock_in_boundary(RESPONSE, 0.0, 0.0, "abc")


def test_a_prediction_is_checked_on_its_own_surface_only(plywood, monkeypatch) -> None:
    """Another material is refused before any cycle; the same ellipse under exchanged axes or twice the friction not."""
    monkeypatch.setattr(CollectionLoop, "circle_map", lambda loop, **how: CircleMap.rigid(0.3))
    prediction = predict(FOUND, plywood.material.friction)
    law = plywood.material.friction
    doubled = EllipseFriction(2 * law.mu_a, 2 * law.mu_b, 2 * law.m0, 2 * law.n0, law.phi + 2 * np.pi)
    exchanged = EllipseFriction(law.mu_b, law.mu_a, -law.n0, law.m0, law.phi - np.pi / 2)
    for same in (law, exchanged, doubled):
        loop = replace(plywood, material=replace(plywood.material, friction=same))
        assert check_prediction(prediction, loop).fixed_points == ()
    assert check_prediction(prediction, with_anisotropy(plywood, prediction.anisotropy)).fixed_points == ()
    with pytest.raises(
        InvalidInput, match=r"prediction is of offset 0.13.*but isotropic has offset 0.0000.*own friction"
    ):
        check_prediction(prediction, CollectionLoop.mit(material="isotropic"))
    with pytest.raises(InvalidInput, match="needs a Prediction and a CollectionLoop"):
        check_prediction(None, plywood)


def test_without_a_friction_on_the_rod_the_second_order_is_not_found() -> None:
    """Differences of a jump: the hessian's asymmetry is far beyond that of the MIT rod, whose second order is found."""
    loop = CollectionLoop.from_settings({"pusher_mu": 0.0})
    slippery = predict(fingerprint(loop), loop.material.friction)
    assert not slippery.second_order_found and not slippery.trusted
    assert slippery.fingerprint.hessian_error > 0.02 * np.abs(slippery.fingerprint.cycle.hessian).max()
    usual = CollectionLoop.mit()
    assert predict(fingerprint(usual), usual.material.friction).second_order_found
