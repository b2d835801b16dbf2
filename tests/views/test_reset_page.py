"""The page and the sentences of a designed reset tell the verdict, both laws, the limits, and why nothing does."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.resets.design.push_proof import PushProof
from cyclemap.resets.design.reset_candidates import Effort
from cyclemap.resets.design.reset_curves import reset_curves
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_design import design_reset
from cyclemap.resets.design.reset_ranking import ScoredReset, outlooks, ranked
from cyclemap.resets.design.reset_trial import ResetTrial, SampledStatistic, reset_trial
from cyclemap.resets.strategies.drag_strategies import WayPoints
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle
from cyclemap.resets.strategies.strategy_run import run_strategy
from cyclemap.views import reset_sentences as sentences
from cyclemap.views.reset_page import reset_page
from cyclemap.views.style import render

NOISE = WrappedNormal(1.2)
LITTLE = Effort((), (), (), (), (), 4, 0, 1, 1)
ASIDE = WayPoints(((0.05, 0.05),))


def designed(**demands):
    loop = CollectionLoop.mit()
    return design_reset(
        loop, ResetDemands(**demands), NOISE, keep_push=True, thoroughness=LITTLE, also=[ASIDE], tolerance=1e-2
    )


def asked_anew(design, demands):
    """The design with the same strategies set against other demands."""
    drag = design.own.cost.mean_drag_length
    scored = {
        one.name: ScoredReset.of(one.candidate, one.numbers, one.cost, demands, drag, one.contact)
        for one in design.ranking
    }
    order, own = ranked(list(scored.values())), scored[design.own.name]
    found = outlooks(order, demands, drag)
    return replace(design, demands=demands, ranking=order, own=own, chosen=order[0], outlooks=found)


@pytest.fixture(scope="module")
def met():
    """With noise so wide that the loop as it is does."""
    return designed(allow_tv=0.4)


@pytest.fixture(scope="module")
def hopeless(met):
    """Less room than the push itself takes."""
    return asked_anew(met, ResetDemands(allow_tv=0.4, reach=0.05, seconds=15.0, contact=0.2))


def drawn(design, trial=None):
    return reset_page(design, reset_curves(design, pushes=20), trial)


def test_both_laws_and_the_even_one_are_drawn_on_one_scale(met) -> None:
    laws = drawn(met).axes[0]
    before, after, even = laws.lines
    assert even.get_ydata()[0] == pytest.approx(1.0 / 360.0)
    for line in (before, after):
        assert np.trapezoid(line.get_ydata(), line.get_xdata()) == pytest.approx(1.0, abs=2e-3)
    assert "per degree" in laws.get_ylabel() and laws.get_ylim()[0] == 0.0


def test_every_strategy_is_a_numbered_point_and_limits_are_lines(met) -> None:
    trade = drawn(met).axes[3]
    assert [text.get_text() for text in trade.texts if text.get_text().isdigit()]
    assert {int(text.get_text()) for text in trade.texts} == set(range(1, len(met.ranking) + 1))
    points = sum(len(line.get_xdata()) for line in trade.lines if line.get_linestyle() == "None")
    assert points == len(met.ranking) >= 3
    limit = 1000 * 2.0 * met.own.cost.mean_drag_length
    assert trade.lines[0].get_xdata()[0] == pytest.approx(limit)
    assert trade.lines[1].get_ydata()[0] == pytest.approx(0.4)


def test_the_numbers_beside_the_points_do_not_cover_each_other(met) -> None:
    page = drawn(met)
    render(page)
    boxes = [Text.get_window_extent(text) for text in page.axes[3].texts]
    pairs = [(a, b) for i, a in enumerate(boxes) for b in boxes[:i]]
    assert pairs and not any(a.overlaps(b) for a, b in pairs)


def test_cycles_are_to_scale_about_the_target_in_the_same_window(met) -> None:
    before, after = drawn(met).axes[4:6]
    assert before.get_aspect() == after.get_aspect() == 1.0
    assert before.get_xlim() == after.get_xlim() == before.get_ylim()
    assert before.get_xlim()[1] > 1000 * met.own.cost.reach


def test_legends_and_titles_do_not_meet(met) -> None:
    page = drawn(met)
    render(page)
    for axes in page.axes[:4]:
        legend = axes.get_legend().get_window_extent()
        assert legend.y0 >= axes.get_window_extent().y1 - 1
        titles = [one for one in (axes.title, axes._left_title) if one.get_text()]
        assert titles and not any(title.get_window_extent().overlaps(legend) for title in titles)


def test_the_verdict_tells_what_meets_with_its_numbers(met) -> None:
    verdict = sentences.verdict_sentence(met)
    assert verdict.startswith("plywood: “") and "meets all demands" in verdict
    assert re.search(r"total variation from uniform 0\.\d{3} ± .* in the long run", verdict)
    assert sentences.reason_sentences(met) == ()
    assert "(1.00 of the loop's own)" in sentences.cost_words(met.own)


def test_impossible_demands_are_told_loudly_with_what_stands_in_the_way(hopeless) -> None:
    told = " ".join(sentences.reset_sentences(hopeless))
    assert told.startswith("NO RESET MEETS ALL DEMANDS on plywood. The nearest")
    assert "room about the target (189 mm where 50 mm is allowed)" in told
    assert "No strategy that was looked at meets the demand on room about the target and time of a cycle" in told
    assert "A push of 150 mm alone takes 80 mm" in told
    assert "Push and handling alone take 17.5 s" in told
    assert "contact in a push (132 mm where 200 mm is asked for)" in told
    assert "NO RESET MEETS" in drawn(hopeless).texts[1].get_text()


def test_a_gripper_that_would_do_is_named(met) -> None:
    tight = asked_anew(met, ResetDemands(allow_tv=1e-6, extra_tv=1e-3))
    more = sentences.more_sentence(tight)
    assert "With more (gripper) “gripper, any turn” would meet all demands" in more
    assert sentences.standing(tight.with_more[0]) == "would need gripper"


def test_a_trial_is_told_and_drawn_with_its_sampling_error(met) -> None:
    trial = reset_trial(met.cache, met.own.candidate, 30)
    told = sentences.trial_sentence(trial)
    assert told.startswith("30 pushes by the full mechanics agree with the prediction")
    assert f"{trial.kuiper.low:.3f} to {trial.kuiper.high:.3f}" in told
    assert render(drawn(met, trial)).startswith(b"\x89PNG")


def test_pushes_are_told_with_their_chances() -> None:
    pushes = side_pushes(CollectionLoop.mit().push, (0, 2))
    whole = DrawnPushes(pushes, weights=(1.0, 3.0))
    drawn_ = sentences.what_to_do(whole, lambda push: push.distance)
    assert drawn_ == "Draw before every push: side 0 at 0.70 (25.0%), side 2 at 0.70 (75.0%)."
    lost = sentences.what_to_do(replace(whole, schedule=GoldenAngle()), lambda push: 0.048 if push.side else 0.15)
    told = "side 0 at 0.70 (25.0%), side 2 at 0.70 (75.0%, the object lost after 48 mm)"
    assert lost == f"Draw by golden angle before every push: {told}."
    turns = sentences.what_to_do(AlternatingPushes(pushes), lambda push: 0.15)
    assert turns.startswith("In turn: side 0 at 0.70")
    assert sentences.what_to_do(ASIDE, lambda push: 0.15) == ""


def test_pushes_that_lose_the_object_early_are_told_with_how_to_forbid_them(met) -> None:
    brief = replace(met, chosen=replace(met.chosen, contact=0.052))
    assert "after 52 mm of 150 mm" in sentences.brief_sentence(brief) and "--least-push-mm" in " ".join(
        sentences.reset_sentences(brief)
    )
    assert sentences.brief_sentence(met) == ""


def test_a_proof_is_told_with_its_pushes(hopeless) -> None:
    pushes = side_pushes(CollectionLoop.mit().push, (0, 2))
    told = sentences.proof_sentence(replace(hopeless, proof=PushProof(pushes, "tv", 0.0213, 0.01, 0.2)))
    assert told.endswith("gets below total variation 0.021 in the long run with a mean drag of at most 200 mm.")
    told = sentences.proof_sentence(replace(hopeless, proof=PushProof(pushes, "drag", 0.06, 0.02, 0.05)))
    assert told.startswith("Proved: no rule with the pushes side 0 at 0.70, side 2 at 0.70, even one that looks at")
    assert sentences.proof_sentence(hopeless) == ""


def test_a_run_more_even_than_predicted_agrees_and_is_called_so(met) -> None:
    predicted = np.linspace(0.05, 0.15, 400)
    low, high = (SampledStatistic.of(value, predicted) for value in (0.01, 0.2))
    assert low.p_value == 1.0 and high.p_value < 0.01 and not low.agrees
    run = run_strategy(met.loop, met.own.candidate.strategy, 2)
    trial = ResetTrial(run, low, low, low, 36, 400)
    assert trial.agrees and not replace(trial, kuiper=high).agrees
    told = sentences.trial_sentence(trial)
    assert told.count("below them: more even than predicted") == 2 and "below them: nearer than predicted" in told
