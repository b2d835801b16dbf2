"""The portrait's page and its sentences."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from drawn_words import assert_words_apart
from matplotlib.colors import to_rgb

from cyclemap.cli.run_portrait import portrait_report
from cyclemap.collection import CollectionLoop, Portrait, portrait
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.collection.uncertain_directions import DirectionInterval, DirectionUncertainty
from cyclemap.errors import InvalidInput
from cyclemap.evidence import MapAgreement
from cyclemap.maps import CircleMap, Estimate, StaircaseSummary, WrappedNormal, transfer_operator
from cyclemap.mechanics import load_material
from cyclemap.views import sentences
from cyclemap.views.panels import style
from cyclemap.views.panels.layout import render

CASES = [("locked", True), ("rotating", True), ("jumping", False)]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "data"), CASES)
def test_words_stay_on_the_page_and_do_not_overlap(drawn, kind, data) -> None:
    assert_words_apart(drawn(kind, data)[1])


def test_predicted_and_measured_differ_in_a_grey_print() -> None:
    def lightness(color: str) -> float:
        return float(np.dot(to_rgb(color), (0.299, 0.587, 0.114)))

    assert lightness(style.MEASURED) - lightness(style.PREDICTED) > 0.3
    assert lightness(style.PREDICTED_FILL) - lightness(style.MEASURED) > 0.15


@pytest.mark.slow
@pytest.mark.parametrize(
    ("picture_format", "start"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")]
)
def test_each_format_is_what_it_says_and_comes_out_the_same_twice(
    drawn, picture_format, start
) -> None:
    page = drawn("locked")[1]
    picture = render(page, picture_format)
    assert picture.startswith(start) and render(page, picture_format) == picture
    if picture_format == "png":
        width, height = (int.from_bytes(picture[at : at + 4], "big") for at in (16, 20))
        assert width / height == pytest.approx(16 / 9, rel=0.01) and width >= 1600
        assert len(picture) < 400_000
    with pytest.raises(InvalidInput, match="'gif' is unknown; use one of png, pdf, svg"):
        render(page, "gif")


def both(orientation_deg: float) -> str:
    """The MIT push goes towards the object's -y: a quarter turn clockwise of its orientation."""
    towards = f"{orientation_deg - 90.0:.1f}°".replace("-", "−")
    return f"orientation {orientation_deg:.1f}°, pushed towards {towards}"


@pytest.mark.slow
def test_headline_and_sentence_tell_where_it_locks_and_how_fast_or_the_pace(drawn) -> None:
    # Arnold: θ + 0.02π - 0.2 sin θ is fixed where sin θ = 0.1π.
    locked, place = drawn("locked")[0], math.asin(0.1 * math.pi)
    assert sentences.headline(locked) == f"plywood locks into {both(math.degrees(place))}"
    multiplier = 1 - 0.2 * math.cos(place)
    fast = f"a tenth of an error is left after {math.log(0.1) / math.log(multiplier):.0f} cycles."
    said = sentences.lock_sentence(locked)
    assert said == f"Stable at 18.3°, multiplier {multiplier:.3f}: {fast}"
    # 2πΩ = 7.2 and K = 5.7 degrees: the turn runs from their difference to their sum.
    rotating = drawn("rotating")[0]
    assert sentences.headline(rotating) == "plywood locks into no direction"
    said = "Without noise a cycle turns the object by 1.5° to 12.9°; a full turn takes "
    assert sentences.lock_sentence(rotating).startswith(said)
    assert sentences.lock_sentence(drawn("jumping")[0]) == "Orbits gather about the jump at 114.6°."


def foretelling(found: Portrait, prediction: StaircaseSummary) -> Portrait:
    """The portrait as if map and noise had led to this prediction."""
    changed = replace(found)
    vars(changed)["prediction"] = prediction
    return changed


def test_what_noise_carries_off_within_the_run_is_not_locked(drawn) -> None:
    found = drawn("locked")[0]
    (zone,) = found.prediction.zones
    short = replace(found.prediction, zones=(replace(zone, residence_cycles=Estimate(45.0, 0.1)),))
    resting = foretelling(found, short)
    assert sentences.headline(resting) == f"plywood rests at {both(18.3)}, for 45 cycles at a time"
    run = replace(found.staircase, theta=found.staircase.theta[:41])
    brief = foretelling(replace(found, staircase=run), short)
    assert sentences.headline(brief) == f"plywood locks into {both(18.3)}"
    unknown = foretelling(found, replace(found.prediction, zones=()))
    assert sentences.headline(unknown) == f"plywood rests at {both(18.3)}"


@pytest.mark.slow
def test_a_portrait_of_a_surface_that_wears_does_not_say_that_it_locks() -> None:
    loop = CollectionLoop.mit("plywood-measured")
    found = portrait(loop, tolerance=1e-3, sigma=math.radians(1.0))
    assert found.drifting is not None and found.worn is not None
    said = sentences.headline(found)
    assert said.startswith("plywood-measured rests at orientation ")
    assert "when fresh, near 9" in said
    told = " ".join([said, sentences.lock_sentence(found), sentences.noise_sentence(found)])
    told += sentences.staircase_sentence(found)
    assert "locks" not in told and "flat" not in told
    turns = (found.staircase.theta[-1] - found.staircase.theta[0]) / (2 * math.pi)
    assert 10.0 < turns < 25.0
    assert f"makes {turns:.1f} turns; by then θ0 rests near 9" in told
    curves = portrait_curves(found)
    assert math.isclose(sum(curves.density[:-1]) * 2 * math.pi / 1440, 1.0, rel_tol=1e-3)
    fresh = found.operator.density(curves.density_theta)
    assert abs(curves.density - fresh).max() > 1.0


def test_noise_that_holds_two_directions_is_told_with_their_shares_and_how_often_it_changes(
    drawn,
) -> None:
    wells = CircleMap(lambda x: x - 0.3 * np.sin(2 * x) + 0.05 * np.sin(x))
    found = replace(drawn("rotating")[0], operator=transfer_operator(wells, WrappedNormal(0.3)))
    (much, few), said = found.held, sentences.noise_sentence(found)
    held = (
        "Noise holds two directions: 88% near 180° and 12% near 360°, a change every 5849 cycles."
    )
    assert said.endswith(held)
    assert much.share * much.leaving + few.share * few.leaving == pytest.approx(1 / 5849, rel=1e-3)
    report = portrait_report(found)["stationary"]
    assert [round(one["share"], 2) for one in report["held"]] == [0.88, 0.12]
    assert "held" not in portrait_report(drawn("rotating")[0])["stationary"]


def test_sentences_of_noise_staircase_agreement_and_parameters_carry_the_numbers(drawn) -> None:
    found = drawn("rotating")[0]
    noise = "With 1.1° of noise a cycle the recorded directions peak at"
    assert noise in sentences.noise_sentence(found)
    level = replace(found.prediction, step=None, mean_turn=math.radians(4.321))
    said = sentences.staircase_sentence(foretelling(found, level))
    assert said.endswith("on average θ0 moves 4.32° a cycle.")
    pace = {"mean_residence_cycles": 257.4, "mean_turn": math.radians(0.9)}
    steps = foretelling(found, replace(found.prediction, step=2 * math.pi, **pace))
    told = "rests 257 cycles on a step, steps are 360° high, and on average θ0 moves 0.90° a cycle"
    assert told in sentences.staircase_sentence(steps)
    agreement = MapAgreement(1996, math.radians(7.06), 62, math.radians(12.3))
    lie = "1996 measured cycles lie 7.1° RMS from the predicted turn; the medians of 62 directions"
    assert sentences.agreement_sentence(agreement) == f"{lie} 12.3°."
    said, law = sentences.parameters_line(found), "μa 0.2545, μb 0.2346, m0 0.0325, n0 0.0082, φ"
    assert f"{law} 150.0°" in said and "rod ⌀ 9.5 mm, μ 0.15" in said


def test_the_error_that_is_told_is_no_smaller_than_the_error() -> None:
    """One digit of a bound, rounded so that it still is one."""
    for degrees, told in ((1.4e-4, "0.0002"), (5.436e-5, "0.00006"), (0.03, "0.03")):
        known = SimpleNamespace(samples=99, max_error=math.radians(degrees))
        said = sentences.accuracy_line(SimpleNamespace(map=known))
        assert said.endswith(f"estimated error {told}°")


def test_counts_are_short_and_no_angle_says_minus_zero() -> None:
    counts = (0.04, 9.94, 12.4, 99_999.0, 2e7, math.inf)
    said = ["0.0", "9.9", "12", "99999", "10^7", "more than 10^12"]
    assert [sentences.number(count) for count in counts] == said
    assert (sentences.angle(-1e-9), sentences.angle(math.radians(-65.04))) == ("0.0°", "−65.0°")


def test_a_material_says_where_it_is_from_and_what_it_misses() -> None:
    told = sentences.material_line(load_material("plywood-measured"))
    assert told.startswith("plywood-measured was inferred, not measured: blocks left out")
    assert "wears over 2000 cycles" in told
    assert "where isotropic friction misses" in sentences.material_line(load_material("plywood"))
    assert sentences.material_line(load_material("isotropic")) == ""


def test_a_long_list_of_errors_is_told_in_its_first_clauses() -> None:
    clauses = [f"session {number}, push place: 1.23 mm (isotropic 2.34)" for number in range(40)]
    long = replace(load_material("isotropic"), misfit="; ".join(clauses), inferred=True)
    told = sentences.material_line(long)
    assert len(told) < 600
    assert told.startswith(f"isotropic was inferred, not measured: {clauses[0]}; {clauses[1]}")
    assert told.endswith(f"; {40 - told.count('session')} more in its file")
    endless = sentences.material_line(replace(long, misfit="word " * 400))
    assert len(endless) < 600 and endless.endswith(" ...")


@pytest.mark.parametrize(
    ("width", "told"),
    [
        (0.5, "84.0° to 84.5°"),
        (0.03, "84.000° to 84.030°"),
        (0.0, "84.000°"),
        (170.0, "84° to 254°"),
        (340.0, "at any direction (in 100% of samples)"),
    ],
)
def test_the_ends_of_an_interval_are_told_apart(width, told) -> None:
    ends = math.radians(84.0), math.radians(84.0 + width)
    one = DirectionInterval(math.radians(84.01), *ends, share=1.0)
    known = DirectionUncertainty("posterior", "first order", 40, 40, (one,))
    assert told in sentences.uncertainty_sentence("felt", known)


@pytest.mark.parametrize(("count", "told"), [(1, "1 at 245°"), (38, "38 at 245° to 252°")])
def test_of_few_samples_no_interval_is_told_nor_a_decimal(count: int, told: str) -> None:
    ends = math.radians(244.785), math.radians(244.785 + 0.2 * (count - 1))
    few = DirectionInterval(None, *ends, share=count / 200)
    known = DirectionUncertainty("posterior", "first order", 200, count, (few,))
    have = "1 of 200 samples has" if count == 1 else "38 of 200 samples have"
    said = f"{have} a stable direction (to first order), only {told}."
    assert sentences.uncertainty_sentence("felt", known).endswith(said)


@pytest.mark.slow
def test_a_loop_that_comes_back_after_five_cycles_is_said_to() -> None:
    loop = CollectionLoop.mit("plywood")
    loop = replace(loop, slider=replace(loop.slider, hitch=(0.0, 0.0)), accuracy=1e-6)
    assert sentences.headline(portrait(loop)) == "plywood locks into 5 directions in turn"
