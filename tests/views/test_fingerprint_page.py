"""The fingerprint page draws the protocol's answers, the predicted turn with its error, and the
full map's.
"""

import math

import numpy as np
import pytest
from drawn_words import assert_words_apart

from cyclemap.collection import Anisotropy, Fingerprint, Prediction, PredictionCheck, TurnResponse
from cyclemap.collection.fingerprint_prediction import CheckedDirection
from cyclemap.maps import CircleMap, fixed_points
from cyclemap.views import fingerprint_page as sentences
from cyclemap.views.fingerprint_page import fingerprint_page

PUSH = TurnResponse(1.2, [0.3, 0.1, 0.2, -0.4], np.zeros((4, 4)))
DRAG = TurnResponse(-1.1, [1.5, -0.6, 0.9, 1.0], 0.4 * np.eye(4))
FOUND = Fingerprint(PUSH, DRAG, 0.0, 0.1)
LOCKED = Prediction(FOUND, Anisotropy(0.12, 0.3, 0.05, 1.0))
DRIFTING = Prediction(FOUND, Anisotropy(0.01, 0.3, 0.005, 1.0))
STRONG = Prediction(FOUND, Anisotropy(0.8, 0.3, 0.9, 1.0))


def checked(prediction: Prediction) -> PredictionCheck:
    """A full map a hundredth of a radian off the predicted one."""
    full = CircleMap(lambda theta: prediction.map(theta - 0.01) + 0.01)
    points = tuple(fixed_points(full))
    pairs = zip(prediction.directions, points, strict=True)
    return PredictionCheck(full, points, tuple(CheckedDirection(*pair, 0.01) for pair in pairs))


@pytest.mark.parametrize(("prediction", "panels"), [(None, 2), (LOCKED, 3), (DRIFTING, 3)])
def test_the_page_holds_the_numbers_and_the_sentences(prediction, panels) -> None:
    check = checked(LOCKED) if prediction is LOCKED else None
    page = fingerprint_page(FOUND, prediction, check, "wood")
    assert len(page.axes) == panels
    words = [text.get_text().replace("\n", " ") for text in page.texts]
    assert words[0] == "Fingerprint of the protocol" + ", on wood" * (prediction is not None)
    assert sentences.protocol_sentence(FOUND) in words[1]
    assert all(number in words[-1] for number in sentences.seven_numbers(FOUND.cycle))
    if prediction is LOCKED:
        assert "The full map locks into" in words[1]
        assert "The prediction is 0.6° off, within its error." in words[1]
    assert_words_apart(page)


def test_a_full_map_without_a_stable_direction_is_told() -> None:
    nothing = tuple(CheckedDirection(direction, None, math.inf) for direction in LOCKED.directions)
    told = sentences.check_sentence(PredictionCheck(CircleMap.rigid(0.1), (), nothing))
    assert told == "The full map has no stable direction."


def test_sentences_tell_locking_drifting_and_distrust() -> None:
    (stable,) = LOCKED.stable_directions
    told = sentences.direction_sentence(LOCKED, "wood")
    assert told.startswith(f"To first order wood locks into {math.degrees(stable.theta):.1f}° ± ")
    assert sentences.trust_sentence(LOCKED) == ""
    drifting = sentences.direction_sentence(DRIFTING, "wood")
    assert drifting.startswith("To first order wood has no stable direction: the map turns ")
    assert f"slowest near {math.degrees(DRIFTING.slowest):.0f}°" in drifting
    assert "leaves open" not in drifting
    assert "Lock-in begins at" in sentences.lock_in_sentence(DRIFTING)
    assert "not to be trusted" in sentences.trust_sentence(STRONG)
    isotropic = Prediction(FOUND, Anisotropy(0.0, 0.0, 0.0, 0.0))
    assert sentences.lock_in_sentence(isotropic) == ""
    assert sentences.surface_sentence(isotropic, "wood") == "wood is the same in every direction."
    assert "turns 5.73° a cycle on average." in sentences.direction_sentence(isotropic, "wood")


def test_a_second_order_that_was_not_found_is_the_reason_before_any_error_that_came_of_it() -> None:
    """The errors are made of the second order: where it is not known a percentage would only
    mislead.
    """
    unknown = Fingerprint(PUSH, DRAG, 2.2, 50.0)
    for surface in (LOCKED.anisotropy, STRONG.anisotropy):
        doubtful = Prediction(unknown, surface)
        assert doubtful.ratio > 1.0 and not doubtful.trusted
        told = sentences.trust_sentence(doubtful)
        assert "second order could not be found, so its error is not known" in told
        assert "%" not in told
    told = sentences.trust_sentence(STRONG)
    assert "its error is" in told and "second order" not in told


def test_a_surface_that_locks_to_second_order_only_is_told_so() -> None:
    """The second order lowers the turn by |u|², which is enough to reach zero."""
    lower = TurnResponse(-1.1, DRAG.gradient, np.diag([-2.0, -2.0, 0.0, 0.0]))
    weaker = LOCKED.anisotropy.scaled(0.97 * LOCKED.lock_in.scale)
    edge = Prediction(Fingerprint(PUSH, lower, 0.0, 0.0), weaker)
    (stable,) = (orbit for orbit in edge.second_order_points if orbit.stable)
    told = sentences.direction_sentence(edge, "wood")
    assert "no stable direction" in told and "leaves open" in told
    assert told.endswith(f"; to second order it locks into {math.degrees(stable.points[0]):.1f}°.")


def test_why_no_direction_is_predicted_of_a_floor_is_told_of_what_it_has() -> None:
    bowed = sentences.floor_sentence(FOUND, 0.5, False)
    varying = sentences.floor_sentence(FOUND, 0.0, True)
    assert "bow of 0.5" in bowed and "varies" not in bowed
    assert "varies from place to place" in varying and "bow" not in varying
    assert bowed.endswith("portrait computes the map.") and varying.endswith("computes the map.")
    assert "bow of 0.5" in sentences.floor_sentence(FOUND, 0.5, True)
    assert sentences.floor_sentence(FOUND, 0.0, False) == ""
