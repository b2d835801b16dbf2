"""The sentences say what the numbers of the portrait say."""

import math
from dataclasses import replace

import pytest

from cyclemap.evidence import MapAgreement
from cyclemap.mechanics import load_material
from cyclemap.views import sentences


def test_headline_names_every_stable_direction_or_none(drawn) -> None:
    assert sentences.headline(drawn("rotating").portrait) == "plywood locks into no direction"
    # Arnold: θ + 0.02π - 0.2 sin θ is fixed where sin θ = 0.1π.
    assert (
        sentences.headline(drawn("locked").portrait)
        == f"plywood locks into {math.degrees(math.asin(0.1 * math.pi)):.1f}°"
    )


def test_speed_of_locking_follows_from_the_multiplier(drawn) -> None:
    multiplier = 1 - 0.2 * math.cos(math.asin(0.1 * math.pi))
    tenth = math.log(0.1) / math.log(multiplier)
    said = sentences.lock_sentence(drawn("locked").portrait)
    fast = f"a tenth of an error is left after {tenth:.0f} cycles."
    assert said == f"Stable at 18.3°, multiplier {multiplier:.3f}: {fast}"


def test_without_fixed_points_the_pace_is_told(drawn) -> None:
    # 2πΩ = 7.2 and K = 5.7 degrees: the turn runs from their difference to their sum.
    said = sentences.lock_sentence(drawn("rotating").portrait)
    assert said.startswith("Without noise a cycle turns the object by 1.5° to 12.9°; a full turn takes ")


def test_attracting_jump_is_told(drawn) -> None:
    assert sentences.lock_sentence(drawn("jumping").portrait) == "Orbits gather about the jump at 114.6°."


def test_noise_and_staircase_sentences_carry_the_numbers(drawn) -> None:
    found = drawn("rotating").portrait
    assert "With 1.1° of noise a cycle the recorded directions peak at" in sentences.noise_sentence(found)
    flat = replace(found, prediction=replace(found.prediction, step=None, mean_turn=math.radians(4.321)))
    assert sentences.staircase_sentence(flat).endswith("on average θ0 moves 4.32° a cycle.")
    steps = replace(found.prediction, step=2 * math.pi, mean_residence_cycles=257.4, mean_turn=math.radians(0.9))
    said = sentences.staircase_sentence(replace(found, prediction=steps))
    assert "rests 257 cycles on a step, steps are 360° high, and on average θ0 moves 0.90° a cycle" in said


def test_agreement_sentence_gives_both_distances() -> None:
    said = sentences.agreement_sentence(MapAgreement(1996, math.radians(7.06), 62, math.radians(12.3)))
    assert said == ("1996 measured cycles lie 7.1° RMS from the predicted turn; the medians of 62 directions 12.3°.")


def test_parameters_line_holds_the_protocol(drawn) -> None:
    said = sentences.parameters_line(drawn("locked").portrait)
    for part in ("μa 0.2545", "μb 0.2346", "m0 0.0325", "n0 0.0082", "φ 150.0°", "rod ⌀ 9.5 mm, μ 0.15"):
        assert part in said


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.04, "0.0"),
        (9.94, "9.9"),
        (12.4, "12"),
        (99_999.0, "99999"),
        (2e7, "10^7"),
        (math.inf, "more than 10^12"),
    ],
)
def test_counts_are_short(value, said) -> None:
    assert sentences.number(value) == said


def test_angles_never_say_minus_zero() -> None:
    assert sentences.angle(-1e-9) == "0.0°"
    assert sentences.angle(math.radians(-65.04)) == "−65.0°"


def test_an_inferred_material_is_said_to_be_and_a_measured_one_says_nothing() -> None:
    told = sentences.material_line(load_material("plywood-measured"))
    assert told.startswith("plywood-measured was inferred, not measured: cycles 1.56 deg")
    assert "wears over 2000 cycles" in told
    assert sentences.material_line(load_material("plywood")) == ""
